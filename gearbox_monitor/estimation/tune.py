# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Tune a filter on recordings: R from standstill, the rest by likelihood.

The search itself is noise_search; here it runs the Estimator. It needs no truth.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import noise_search
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.model_bank import member_parameters
from gearbox_monitor.estimation.noise_search import EncoderMotion, Trial, Tuned
from gearbox_monitor.estimation.score import (
    LAGS, likelihood, run_score, Score, WHITE_LIMIT)
from gearbox_monitor.kernels.types import Flags
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters, RANDOM_WALK
from gearbox_monitor.plant.drive import DriveModel

# The likelihood of the tangent at standstill is too rough to search on; averaging the friction
# over the speed's spread smooths it and has its optimum at the same place. An adaptive filter is
# tuned with its adaptation off: these are the values it starts from.
SEARCH: dict[str, Any] = {'friction_linearisation': 'statistical', 'adapt': ['']}
FIRST = 0.7  # share of the time until the random walk of a mixture is tuned
OPEN = (
    'a wrong torque constant scales tau_K, and an offset of the torque shifts it: no likelihood '
    'shows that; replay states the error of tau_K where a bag holds a measured torque')


def tune(model: DriveModel, parameters: EstimatorParameters, recordings: Sequence[Samples],
         speeds: bool = True, progress: Callable[[float], object] = bool) -> dict[str, Any]:
    """
    Tune Q and R by maximum likelihood of the innovations.

    Args:
        model: of the drive.
        parameters: in force; the result depends only on those that are not tuned.
        recordings: of one drive; the first gives R at standstill and the scores.
        speeds: tune the process noise of the speeds, too.
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
    first = _scores(model, parameters, recordings)
    start = _criterion(first)

    def searched() -> tuple[Tuned, dict[str, float], list[Score]]:
        """Return the result of a search, its values and their scores."""
        fixed = {} if noise is None else dict(zip(noise_search.R_NAMES, noise))
        guess = noise_search.first_guess(
            motion, _free_names(model, parameters, speeds, noise is None))
        base = parameters.replace(**fixed)
        result = _searched(model, base, recordings, guess, progress)
        values = _rounded({**fixed, **result.parameters})
        return result, values, _scores(model, parameters.replace(**values), recordings)

    result, values, last = searched()
    if noise is not None and _criterion(last) < start:
        # Noise at rest is not that in motion, as of an encoder without noise on its lattice.
        noise = None
        result, values, last = searched()
    progress(1.0)
    most_likely = _criterion(last)
    unchanged = most_likely < start
    tuned_values: dict[str, Any] = values
    if unchanged:
        tuned_values, last = {name: getattr(parameters, name) for name in values}, first
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
        'diverged_evaluations': result.failed, 'starts': result.starts,
        'starts_met': result.agreeing_starts, 'spread': result.spread, 'notes': _notes(result)}
    data['unidentifiable'] = OPEN
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
    return data


def _searched(model: DriveModel, parameters: EstimatorParameters, recordings: Sequence[Samples],
              guess: dict[str, float], progress: Callable[[float], object]) -> Tuned:
    """
    Return the result of a search from a `guess`; the other arguments are as of tune.

    The likelihood averages friction, as the filter for a smoother does. The filter as it is finds
    the rest: of a mixture, whose random walk determines the others, the noise of the deviation
    from the curve.
    """
    base = parameters.replace(**SEARCH)

    def as_it_is(values: Mapping[str, float]) -> tuple[float, bool]:
        """Return the criterion that tune reports of `values`, and whether a filter diverged."""
        scores = _scores(model, parameters.replace(**_rounded(values)), recordings)
        return _criterion(scores), any(score.diverged for score in scores)

    name, others = noise_search.DEVIATION, dict(guess)
    if member_parameters(base):
        base = base.replace(tau_k_model=RANDOM_WALK)
        del others[name]
    result = noise_search.search(
        _likelihood(model, base, recordings), others,
        lambda share: progress(FIRST * share))
    if len(others) < len(guess):
        return noise_search.with_another(result, as_it_is, name, guess[name])
    return noise_search.polished(result, as_it_is)


def _scores(model: DriveModel, parameters: EstimatorParameters,
            recordings: Sequence[Samples]) -> list[Score]:
    return [run_score(model, parameters, samples) for samples in recordings]


def _criterion(scores: Sequence[Score]) -> float:
    """Return the log-likelihood of all recordings with what divergences cost."""
    return sum(score.criterion for score in scores)


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


def _likelihood(model: DriveModel, base: EstimatorParameters,
                recordings: Sequence[Samples]) -> noise_search.Evaluate:
    """Return the criterion of noise_search.search: log-likelihoods, summed over `recordings`."""
    coarse_parts = [_liveliest(recordings[0], noise_search.COARSE_SECONDS)]
    fine_parts = [_liveliest(samples, noise_search.FINE_SECONDS) for samples in recordings]

    def evaluate(trial: Mapping[str, float], coarse: bool) -> Trial:
        """Return the Trial; `coarse`: of one short part."""
        parameters = base.replace(**_clipped(trial))
        parts = [likelihood(model, parameters, part)
                 for part in (coarse_parts if coarse else fine_parts)]
        return Trial(sum(part.criterion for part in parts), max(part.failed for part in parts),
                     *map(np.concatenate, list(zip(*parts))[2:]))

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
    middle, added = 0.5 * (low + high), 4.0 * scipy.special.ndtri(0.975) ** 2 / readings
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
