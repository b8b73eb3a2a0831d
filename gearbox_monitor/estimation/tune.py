# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Tune a filter on recordings: R from standstill, the rest by likelihood or on a reference torque.

The search itself is noise_search; here it runs the Estimator. It needs no truth.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
import math
from typing import Any, TypeAlias

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import noise_search, sample_loop
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.model_bank import member_parameters
from gearbox_monitor.estimation.noise_search import EncoderMotion, Slopes, Tuned
from gearbox_monitor.estimation.score import (
    by_sample, differenced, DIVERGENCE_COST, LAGS, likelihood, LikelihoodSlopes, reference_at,
    run_score, run_unsmoothed, Score, settled, suited, torque_errors, Trial, WHITE_LIMIT)
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters, RANDOM_WALK
from gearbox_monitor.plant.drive import DriveModel

ReferenceTorque: TypeAlias = tuple[Integers, Array]  # stamps [T] ns, torque [T] N m

# The likelihood of the tangent at standstill is too rough to search on; averaging the friction
# over the speed's spread smooths it and has its optimum at the same place. An adaptive filter is
# tuned with its adaptation off: these are the values it starts from.
SEARCH: dict[str, Any] = {'friction_linearisation': 'statistical', 'adapt': ['']}
SMOOTHER_FACTOR = math.sqrt(5.0)
FIRST = 0.7  # share of the time until the random walk of a mixture is tuned
REFERENCE_WEIGHT = 1e3  # makes 0.1 % of error one unit of the criterion
OPEN_WITHOUT_REFERENCE = (
    'a wrong torque constant scales tau_K, and an offset of the torque shifts it: no likelihood '
    'shows that; compare with a measured torque (--reference)')
OPEN_WITH_REFERENCE = (
    'gain and offset of the reference over the estimate: {gain:.3f}, {offset:+.4g} N m (1 and 0 '
    'when torque constant and offset are right; not written)')


def tune(model: DriveModel, parameters: EstimatorParameters, recordings: Sequence[Samples],
         reference: ReferenceTorque | None = None, speeds: bool = True, smoother: bool = False,
         progress: Callable[[float], object] = bool) -> dict[str, Any]:
    """
    Tune Q and R by maximum likelihood of the innovations, or Q on a measured torque.

    Args:
        model: of the drive.
        parameters: in force; the result depends only on those that are not tuned.
        recordings: of one drive; the first gives R at standstill and the scores.
        reference: measured torque of the first recording, or None.
        speeds: tune the process noise of the speeds, too.
        smoother: tune for the smoothed torque.
        progress: called with the share done, 0..1.

    Returns:
        {name: value} for JSON; `parameters` holds the tuned ones.

    Raises:
        InputError: the recording is too short or does not move, a parameter to tune is 0, or the
            filter diverges with the best parameters.

    """
    samples = recordings[0]
    motion = noise_search.describe(samples.stamp_ns, samples.u[:, 0], samples.y)
    noise = motion.standstill_noise
    if noise is None and reference is not None:
        noise = motion.noise  # the error of tau_K depends on Q / R only: one must be fixed
    first = _scores(model, parameters, recordings)
    start = _criterion(first)

    def searched() -> tuple[Tuned, dict[str, float], list[Score]]:
        """Return the result of a search, its values and their scores."""
        fixed = {} if noise is None else dict(zip(noise_search.R_NAMES, noise))
        guess = noise_search.first_guess(
            motion, _free_names(model, parameters, speeds, noise is None))
        base = parameters.replace(**fixed)
        result = _searched(model, base, recordings, reference, guess, smoother, progress)
        values = _rounded({**fixed, **result.parameters})
        return result, values, _scores(model, parameters.replace(**values), recordings)

    result, values, last = searched()
    if reference is None and noise is not None and _criterion(last) < start:
        # Noise at rest is not that in motion, as of an encoder without noise on its lattice.
        noise = None
        result, values, last = searched()
    progress(1.0)
    most_likely = _criterion(last)
    unchanged = reference is None and most_likely < start
    tuned_values: dict[str, Any] = values
    if unchanged:
        tuned_values, last = {name: getattr(parameters, name) for name in values}, first
    elif smoother:
        if 'q_std_tau_k' in values:
            tuned_values['q_std_tau_k'] = float(f'{values["q_std_tau_k"] / SMOOTHER_FACTOR:.6g}')
        if parameters.filter == 'ekf':
            tuned_values['friction_linearisation'] = SEARCH['friction_linearisation']
        last = _scores(model, parameters.replace(**tuned_values), recordings)
    undetermined = [] if unchanged else [name for name, error in result.error.items()
                                         if error >= 1.0 and name in tuned_values]
    if undetermined:  # what the recording does not tell stays as it was
        tuned_values.update({name: getattr(parameters, name) for name in undetermined})
        last = _scores(model, parameters.replace(**tuned_values), recordings)
    data: dict[str, Any] = {
        'filter': parameters.filter, 'tau_k_model': parameters.tau_k_model,
        'parameters': tuned_values, 'relative_error': result.error,
        'undetermined': undetermined,
        'noise_from': _noise_source(motion, noise), 'rest_seconds': motion.standstill_seconds,
        'seconds': motion.seconds, 'evaluations': result.evaluations,
        'diverged_evaluations': result.failed, 'smoother': smoother, 'starts': result.starts,
        'starts_met': result.agreeing_starts, 'spread': result.spread, 'notes': _notes(result)}
    if reference is not None:
        data.update(_fit_reference(model, parameters, tuned_values, samples, reference))
    else:
        data['unidentifiable'] = OPEN_WITHOUT_REFERENCE
    data['white_limit'] = WHITE_LIMIT
    data['before_parameters'] = {name: getattr(parameters, name) for name in tuned_values}
    data['before'], data['after'] = asdict(first[0]), asdict(last[0])
    data['nis_band'] = _nis_band(last[0], motion)
    data['autocorrelation'] = [math.sqrt(q / (LAGS * max(last[0].estimates, 1)))
                               for q in last[0].ljung_box]
    if data['after']['diverged'] and not unchanged:
        estimator = Estimator(model, parameters.replace(**tuned_values, smoother_lag=0.0))
        estimator.run(samples)
        raise InputError(f'with the best parameters found {estimator.divergence_notes()[0]}, '
                         'expected a filter that runs through')
    data['kept'] = unchanged
    data['kept_by'] = start - most_likely if unchanged else 0.0
    if unchanged:
        data['relative_error'] = {}
        data['notes'].insert(0, f'nothing found is more likely than the parameters before '
                             f'(log-likelihood {most_likely:.1f}, {start:.1f} before): they are '
                             'kept')
    inferior = _worse_than_static(data)
    data['worse_than_static'] = bool(inferior)
    data['notes'] = [*inferior, *data['notes']]
    return data


def _searched(model: DriveModel, parameters: EstimatorParameters, recordings: Sequence[Samples],
              reference: ReferenceTorque | None, guess: dict[str, float], smoother: bool,
              progress: Callable[[float], object]) -> Tuned:
    """
    Return the result of a search from a `guess`; the other arguments are as of tune.

    The likelihood averages friction, as the filter for a smoother does. The filter as it is finds
    the rest: of a mixture, whose random walk determines the others, the noise of the deviation
    from the curve.
    """
    base = parameters.replace(**SEARCH)
    if reference is not None:
        return noise_search.search(_reference_fit(model, base, recordings[0], reference), guess,
                                   progress, likelihood=False)

    def as_it_is(values: Mapping[str, float]) -> tuple[float, bool]:
        """Return the criterion that tune reports of `values`, and whether a filter diverged."""
        scores = _scores(model, parameters.replace(**_rounded(values)), recordings)
        return _criterion(scores), any(score.diverged for score in scores)

    name, others = noise_search.DEVIATION, dict(guess)
    if member_parameters(base):
        base = base.replace(tau_k_model=RANDOM_WALK)
        del others[name]
    result = noise_search.search(
        _likelihood(model, base, recordings, others), others,
        lambda share: progress(FIRST * share))
    if len(others) < len(guess):
        return noise_search.with_another(result, as_it_is, name, guess[name])
    return result if smoother else noise_search.polished(result, as_it_is)


def _scores(model: DriveModel, parameters: EstimatorParameters,
            recordings: Sequence[Samples]) -> list[Score]:
    return [run_score(model, parameters, samples) for samples in recordings]


def _criterion(scores: Sequence[Score]) -> float:
    """Return the log-likelihood of all recordings with what divergences cost."""
    return sum(score.criterion for score in scores)


def _worse_than_static(data: Mapping[str, Any]) -> list[str]:
    """Return a sentence where static compensation is nearer to the reference than tau_K."""
    if data.get('static_rmse') is None or data['reference_after']['rmse'] is None:
        return []
    error, static = data['reference_after']['rmse'], data['static_rmse']
    if error <= static:
        return []
    return [f'the torque errs by {error:.4g} N m rms, static compensation of the command by '
            f'{static:.4g} N m: check the model file and the times of the effort before use']


def static_torque(model: DriveModel, estimates: Estimates) -> Array:
    """
    Return the torque [M] that static compensation of the command gives, N m.

    The command less the friction at the estimated speed, without any dynamics: what is there
    without a filter.

    Args:
        model: of the drive.
        estimates: of the filter [M].
    """
    rows = estimates.rows
    speed = rows[:, sample_loop.E_X3]
    torque: Array = (
        rows[:, sample_loop.E_U] - model.position_gain * rows[:, sample_loop.E_X1]
        - model.viscous_friction * speed - model.coulomb_friction * model.friction_side(speed))
    return torque


def tuned(model: DriveModel, parameters: Mapping[str, object],
          recordings: Sequence[Samples]) -> dict[str, Any]:
    """
    Tune R and the process noise of the torques by likelihood.

    Args:
        model: of the drive.
        parameters: of the estimator, {name: value}.
        recordings: of one drive.

    Returns:
        `parameters` with the tuned values.

    Raises:
        InputError: see tune.

    """
    complete = EstimatorParameters.of(parameters)
    return {**parameters, **tune(model, complete, recordings, speeds=False)['parameters']}


def _free_names(model: DriveModel, parameters: EstimatorParameters, speeds: bool,
                noise: bool) -> list[str]:
    """Return the names to search: of Q, and of R if `noise`. Raises InputError for a value 0."""
    load = model.arm_load if parameters.arm_load == 'model' else parameters.arm_load
    names = [*(noise_search.R_NAMES if noise else []), *noise_search.torque_noise(parameters),
             *(['q_std_tau_arm'] if load == 'unknown' else []),
             *(noise_search.SPEED_NAMES if speeds else [])]
    for name in names:
        if not getattr(parameters, name) > 0.0:
            raise InputError(f'{name}: {getattr(parameters, name):g}, expected > 0 to tune it')
    return names


def _likelihood(model: DriveModel, base: EstimatorParameters, recordings: Sequence[Samples],
                names: Iterable[str]) -> noise_search.Evaluate:
    """Return the criterion of noise_search.search: log-likelihoods, summed over `recordings`."""
    coarse_part = _slopes(model, base, names, _liveliest(
        recordings[0], noise_search.COARSE_SECONDS))
    fine_parts = [_slopes(model, base, names, _liveliest(samples, noise_search.FINE_SECONDS))
                  for samples in recordings]

    def evaluate(trial: Mapping[str, float], coarse: bool) -> Slopes:
        """Return the slopes at the `trial`; `coarse`: on one short part."""
        values = _clipped(trial)
        parts = [slopes(values) for slopes in ([coarse_part] if coarse else fine_parts)]
        return Slopes(sum(part.criterion for part in parts),
                      np.sum([part.gradient for part in parts], axis=0),
                      np.sum([part.information for part in parts], axis=0),
                      max(part.runs for part in parts),  # a run takes all recordings
                      max(part.failed for part in parts))

    return evaluate


def _slopes(model: DriveModel, base: EstimatorParameters, names: Iterable[str],
            samples: Samples) -> Callable[[Mapping[str, float]], Slopes]:
    """Return a function of {name: value} of `names`: the log-likelihood with its slopes."""
    if suited(model, base):
        return LikelihoodSlopes(model, base, list(names), samples)
    return partial(differenced, lambda values: likelihood(
        model, base.replace(**_clipped(values)), samples))


def _reference_fit(model: DriveModel, base: EstimatorParameters, samples: Samples,
                   reference: ReferenceTorque) -> noise_search.Evaluate:
    """Return the criterion of noise_search.search: how near tau_K is to the `reference`."""
    _, valid = reference_at(samples.stamp_ns, *reference)
    if valid.sum() < noise_search.MIN_SAMPLES:
        raise InputError(f'reference: {valid.sum()} samples have a reference torque, expected '
                         f'at least {noise_search.MIN_SAMPLES}')
    covered = _part(samples, valid)
    coarse_part = _liveliest(covered, noise_search.COARSE_SECONDS)
    fine_part = _liveliest(covered, noise_search.FINE_SECONDS)

    def evaluate(trial: Mapping[str, float], coarse: bool) -> Slopes:
        """Return the slopes at the `trial`; `coarse`: on one short part."""
        return differenced(lambda values: _reference_trial(
            model, base.replace(**_clipped(values)), coarse_part if coarse else fine_part,
            reference), trial)

    return evaluate


def _nis_band(score: Score, motion: EncoderMotion) -> tuple[float, float]:
    """
    Return the 95 % band of the mean NIS, with the uncertainty of R from the standstill.

    The variance of n readings at rest has the relative variance 2 / n; an innovation follows R at
    most in proportion, so two encoders add 4 / n to the variance of the mean NIS.
    """
    low, high = score.nis_low, score.nis_high
    if not motion.standstill_noise:
        return low, high
    readings = motion.standstill_seconds * score.estimates / motion.seconds
    middle, added = 0.5 * (low + high), 4.0 * scipy.stats.norm.isf(0.025) ** 2 / readings
    half = math.sqrt((0.5 * (high - low)) ** 2 + added)
    return middle - half, middle + half


def _noise_source(motion: EncoderMotion, noise: Sequence[float] | None) -> str:
    if noise is None:
        return 'likelihood'
    return 'standstill' if motion.standstill_noise else 'fourth differences'


def _notes(result: Tuned) -> list[str]:
    """Return sentences about the search `result` for the user."""
    notes = []
    if result.agreeing_starts < result.starts:
        notes.append(f'{result.starts - result.agreeing_starts} of {result.starts} starts of the '
                     'search ended in a poorer optimum')
    if result.failed:
        notes.append(f'the filter diverged in {result.failed} of {result.evaluations} '
                     'trials, which counted against them')
    uncertain = [name for name, error in result.error.items() if error > noise_search.BLUNT]
    if uncertain:
        notes.append('the recording hardly determines ' + ', '.join(uncertain))
    return notes


def _part(samples: Samples, part: slice | Flags) -> Samples:
    return Samples(samples.stamp_ns[part], samples.u[part], samples.y[part])


def _liveliest(samples: Samples, seconds: float) -> Samples:
    return _part(samples, noise_search.liveliest(samples.stamp_ns, samples.y, seconds))


def _clipped(values: Mapping[str, float]) -> dict[str, Any]:
    """Return `values` inside the bounds of the table of parameters."""
    rows = {row.name: row for row in ESTIMATOR}
    return {name: min(max(value, rows[name].low), rows[name].high)
            for name, value in values.items()}


def _rounded(values: Mapping[str, float]) -> dict[str, Any]:
    """Return `values` as they are written."""
    return {name: float(f'{value:.6g}') for name, value in _clipped(values).items()}


def _reference_of(estimates: Estimates, reference: ReferenceTorque) -> tuple[Array, Flags]:
    """Return the torque [M] of the reference, and where [M] it is known after the burn-in."""
    torque, valid = reference_at(estimates.stamp_ns, *reference)
    return torque, valid & settled(estimates.stamp_ns)


def _reference_trial(model: DriveModel, parameters: EstimatorParameters, samples: Samples,
                     reference: ReferenceTorque) -> Trial:
    """Return the criterion; its features are estimates of tau_K where the reference is known."""
    estimates, diverged = run_unsmoothed(model.exact(), parameters, samples)
    torque, keep = _reference_of(estimates, reference)
    error = np.where(keep, estimates.tau_k - torque, np.nan)
    square = float(np.nanmean(error ** 2)) if keep.any() else math.nan
    criterion = noise_search.DIVERGED if not keep.any() else (
        -0.5 * REFERENCE_WEIGHT * math.log(max(square, 1e-24)) - DIVERGENCE_COST * diverged)
    weight = math.sqrt(REFERENCE_WEIGHT / max(keep.sum() * square, 1e-24))
    features, = by_sample(estimates, error[:, None])
    return Trial(criterion, bool(diverged), features, np.full((1, 1), weight))


def _fit_reference(model: DriveModel, parameters: EstimatorParameters,
                   tuned_values: dict[str, Any], samples: Samples,
                   reference: ReferenceTorque) -> dict[str, Any]:
    """Add tau_k_model_std to `tuned_values`; return the comparison with the reference."""
    tuned_values['tau_k_model_std'] = 0.0
    errors_at_start = torque_errors(run_unsmoothed(model, parameters, samples)[0], *reference)
    estimates, _ = run_unsmoothed(model, parameters.replace(**tuned_values), samples)
    torque, keep = _reference_of(estimates, reference)
    tau_k, variance = estimates.tau_k[keep], estimates.tau_k_std[keep] ** 2
    tuned_values['tau_k_model_std'] = float(
        f'{noise_search.widened(tau_k - torque[keep], variance):.6g}')
    gain, offset = (np.polyfit(tau_k, torque[keep], 1) if np.ptp(tau_k) > 0.0
                    else (np.nan, np.nan))
    tuned_run, _ = run_unsmoothed(model, parameters.replace(**tuned_values), samples)
    errors = torque_errors(tuned_run, *reference)
    off = (static_torque(model, estimates) - torque)[keep]
    off = off[np.isfinite(off)]
    return {'static_rmse': float(np.sqrt(np.mean(off ** 2))) if len(off) else None,
            'reference_before': errors_at_start, 'reference_after': errors,
            'unidentifiable': OPEN_WITH_REFERENCE.format(gain=gain, offset=offset)}
