# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Tune a filter on recordings: R from standstill, what is left by likelihood or on a reference.

The search itself is in filters.tuning; here it runs the Estimator. No truth is needed.
"""
from dataclasses import asdict
import math

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import noise_search, sample_loop
from gearbox_monitor.estimation.batch_score import criteria
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.score import (
    DIVERGENCE_COST, known_at, run_score, settled, torque_errors, WHITE_LIMIT)
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters

# The likelihood of the tangent at standstill is too rough to search on; averaging the friction
# over the speed's spread smooths it and has its optimum at the same place. An adaptive filter is
# tuned with its adaptation off: these are the values it starts from.
SEARCH = {'friction_linearisation': 'statistical', 'adapt': ['']}
SMOOTHER_FACTOR = math.sqrt(5.0)
REFERENCE_WEIGHT = 1e3  # makes 0.1 % of error one unit of the criterion
OPEN_WITHOUT_REFERENCE = (
    'a wrong torque constant scales tau_K, and an offset of the torque shifts it: no likelihood '
    'shows that; compare with a measured torque (--reference)')
OPEN_WITH_REFERENCE = (
    'gain and offset of the reference over the estimate: {gain:.3f}, {offset:+.4g} N m (1 and 0 '
    'when torque constant and offset are right; not written)')


def tune(model, parameters, recordings, reference=None, speeds=True, smoother=False,
         progress=None):
    """
    Return what was found as {name: value}, ready for JSON; `parameters` holds the tuned ones.

    model: DriveModel; parameters: EstimatorParameters; recordings: list of Samples
    of one drive (the first tells R at standstill, and before and after); reference: (stamps
    int64 [T] ns, torque [T] N m) or None; speeds: tune the process noise of the speeds, too;
    smoother: for the smoothed torque; progress: called with the share done. Raises InputError.
    """
    samples = recordings[0]
    motion = noise_search.describe(samples.stamp_ns, samples.u[:, 0], samples.y)
    load = parameters.arm_load
    load = model.arm_load if load == 'model' else load
    free = ['q_std_tau_k', *(['q_std_tau_arm'] if load == 'unknown' else []),
            *(noise_search.SPEED_NAMES if speeds else [])]
    noise = motion.rest
    if noise is None and reference is not None:
        noise = motion.noise  # the error of tau_K depends on Q / R only: one must be given
    fixed = {} if noise is None else dict(zip(noise_search.R_NAMES, noise))
    if noise is None:
        free = [*noise_search.R_NAMES, *free]
    for name in free:
        if not getattr(parameters, name) > 0.0:
            raise InputError(f'{name}: {getattr(parameters, name):g}, expected > 0 to tune it')
    some = [_liveliest(samples, noise_search.COARSE_SECONDS)]
    most = [_liveliest(s, noise_search.FINE_SECONDS) for s in recordings]
    base = parameters.replace(**SEARCH, **fixed)

    def evaluate(trials, coarse):
        trials = [base.replace(**_within(values)) for values in trials]
        if reference is not None:
            return [_reference_criterion(model, trial, some[0] if coarse else most[0], reference)
                    for trial in trials]
        by_recording = [criteria(model, trials, s) for s in (some if coarse else most)]
        return [(sum(criterion for criterion, _ in results),
                 any(diverged for _, diverged in results)) for results in zip(*by_recording)]

    if reference is not None:
        _, found = known_at(samples.stamp_ns, *reference)
        if found.sum() < noise_search.MIN_SAMPLES:
            raise InputError(f'reference: {found.sum()} samples have a reference torque, expected '
                             f'at least {noise_search.MIN_SAMPLES}')
        inside = _part(samples, found)
        some = [_liveliest(inside, noise_search.COARSE_SECONDS)]
        most = [_liveliest(inside, noise_search.FINE_SECONDS)]
    found = noise_search.search(evaluate, noise_search.first_guess(motion, free), progress,
                                likelihood=reference is None)
    tuned = {**fixed, **_within(found.parameters)}
    if smoother:
        tuned['q_std_tau_k'] /= SMOOTHER_FACTOR
    tuned = {name: float(f'{value:.6g}') for name, value in tuned.items()}
    if smoother and parameters.filter == 'ekf':
        tuned['friction_linearisation'] = SEARCH['friction_linearisation']
    data = {
        'filter': parameters.filter, 'parameters': tuned, 'relative_error': found.error,
        'noise_from': 'likelihood' if noise is None else 'standstill' if motion.rest else
        'fourth differences', 'rest_seconds': motion.rest_seconds, 'seconds': motion.seconds,
        'evaluations': found.evaluations, 'diverged_evaluations': found.failed,
        'smoother': smoother, 'starts': found.starts, 'starts_met': found.met,
        'spread': found.spread, 'notes': []}
    if reference is not None:
        data.update(_fit_reference(model, parameters, tuned, samples, reference))
    else:
        data['unidentifiable'] = OPEN_WITHOUT_REFERENCE
    data['white_limit'] = WHITE_LIMIT
    data['before_parameters'] = {name: getattr(parameters, name) for name in data['parameters']}
    data['before'] = asdict(run_score(model, parameters, samples))
    data['after'] = asdict(run_score(model, parameters.replace(**tuned), samples))
    if data['after']['diverged']:
        estimator = Estimator(model, parameters.replace(**tuned, smoother_lag=0.0))
        estimator.run(samples)
        raise InputError(f'with the best parameters found {estimator.divergence_notes()[0]}, '
                         'expected a filter that runs through')
    if found.met < found.starts:
        data['notes'].append(f'{found.starts - found.met} of {found.starts} starts of the search '
                             'ended at a worse place')
    if found.failed:
        data['notes'].append(f'the filter diverged in {found.failed} of {found.evaluations} '
                             'trials, which counted against them')
    vague = [name for name in free if found.error.get(name, 0.0) > 0.3]
    if vague:
        data['notes'].append('the recording hardly determines ' + ', '.join(vague))
    return data


def tuned(model, parameters, recordings):
    """
    Return `parameters` {name: value} with R and the Q of the torques tuned by likelihood.

    recordings: list of Samples of one drive `model`. Raises InputError.
    """
    complete = EstimatorParameters.of(parameters)
    return {**parameters, **tune(model, complete, recordings, speeds=False)['parameters']}


def _part(samples, which):
    return Samples(samples.stamp_ns[which], samples.u[which], samples.y[which])


def _liveliest(samples, seconds):
    return _part(samples, noise_search.liveliest(samples.stamp_ns, samples.y, seconds))


def _within(values):
    """Return `values` inside the bounds of the table of parameters."""
    rows = {row.name: row for row in ESTIMATOR}
    return {name: min(max(value, rows[name].low), rows[name].high)
            for name, value in values.items()}


def _run(model, parameters, samples):
    estimator = Estimator(model, unsmoothed(parameters))
    return estimator.run(samples), int(estimator.counts[sample_loop.DIVERGED])


def _errors(estimates, reference):
    """Return (estimate, reference, variance) after the burn-in where both are known."""
    known, found = known_at(estimates.stamp_ns, *reference)
    keep = found & settled(estimates.stamp_ns)
    return estimates.tau_k[keep], known[keep], estimates.tau_k_std[keep] ** 2


def _reference_criterion(model, parameters, samples, reference):
    estimates, diverged = _run(model, parameters, samples)
    tau_k, known, _ = _errors(estimates, reference)
    if not len(tau_k):
        return noise_search.DIVERGED, diverged
    rmse = float(np.sqrt(np.mean((tau_k - known) ** 2)))
    return -REFERENCE_WEIGHT * math.log(max(rmse, 1e-12)) - DIVERGENCE_COST * diverged, diverged


def _fit_reference(model, parameters, tuned, samples, reference):
    """Add tau_k_model_std to `tuned`; return what the reference says."""
    tuned['tau_k_model_std'] = 0.0
    before = torque_errors(_run(model, parameters, samples)[0], *reference)
    estimates, _ = _run(model, parameters.replace(**tuned), samples)
    tau_k, known, variance = _errors(estimates, reference)
    tuned['tau_k_model_std'] = float(f'{noise_search.widened(tau_k - known, variance):.6g}')
    gain, offset = np.polyfit(tau_k, known, 1) if np.ptp(tau_k) > 0.0 else (np.nan, np.nan)
    after = torque_errors(_run(model, parameters.replace(**tuned), samples)[0], *reference)
    return {'reference_before': before, 'reference_after': after,
            'unidentifiable': OPEN_WITH_REFERENCE.format(gain=gain, offset=offset)}
