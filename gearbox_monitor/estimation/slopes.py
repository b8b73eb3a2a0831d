# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Log-likelihood of a recording with its slopes over the logarithms of noise parameters.

`LikelihoodSlopes` are exact: the EKF runs as the adaptive filter computes it, with sensitivities
of state and covariance (likelihood_ekf), in the sample loop, so that refused samples, dropouts
and restarts count as in score.run_score. `differenced` serves every other filter and criterion.
"""
from collections.abc import Callable, Mapping, Sequence
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.estimation.estimates import checked, Estimates, Samples
from gearbox_monitor.estimation.filter_setup import drive_of, loop_arrays, settings_of
from gearbox_monitor.estimation.filters.aekf import INFORMATION, THETA
from gearbox_monitor.estimation.likelihood_ekf import FILTER
from gearbox_monitor.estimation.noise_search import Slopes
from gearbox_monitor.estimation.process_model import (
    ADAPT_AT, ADAPT_COUNT, CURVE_COUNT, layout_of, NUMERIC, P0, pack, R1, R2, SLOTS, state_names,
    X1, X2)
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED
from gearbox_monitor.estimation.sample_loop import (
    CHOICES, DIVERGED, E_INNOVATION_COVARIANCE, E_INNOVATION_STD_ARM, E_INNOVATION_STD_MOTOR,
    E_LOGLIK, E_WHITE_1, E_WHITE_2, ESTIMATE, N_ESTIMATE, NEVER, Output, part_of, run, STOP_AT,
    Stream)
from gearbox_monitor.estimation.score import DIVERGENCE_COST, run_unsmoothed, score, settled
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, LAW
from gearbox_monitor.plant.transmission import ATAN

DIFFERENCE = 0.03  # of the logarithms; a criterion may be rough on smaller scales


class LikelihoodSlopes:
    """
    The log-likelihood of `samples` under an EKF, a function of {name: deviation}.

    model: of the drive. parameters: of the filter, see `suited`. names: of the deviations, of
    process_model.SLOTS, at most aekf.MAX_THETA.
    """

    def __init__(self, model: DriveModel, parameters: EstimatorParameters, names: Sequence[str],
                 samples: Samples) -> None:
        self._drive = drive_of(model.exact(), parameters)
        self._p = pack(self._drive, parameters)
        self._slots = {name: SLOTS[name] for name in names}
        self._p[ADAPT_COUNT] = len(names)
        self._p[ADAPT_AT:ADAPT_AT + len(names)] = list(self._slots.values())
        self._states = layout_of(self._p, len(state_names(self._drive, parameters)))
        self._settings = settings_of(self._drive, parameters)._replace(
            lag=0, filter=CHOICES[FILTER.name])
        self._stream = Stream(*checked(samples))
        count = len(self._stream.stamps)
        self._output = Output(np.zeros(count, np.int64), np.empty((count, N_ESTIMATE)),
                              np.empty(0, np.int64), np.empty((0, N_SMOOTHED)))

    def __call__(self, values: Mapping[str, float]) -> Slopes:
        """Return the Slopes at `values`; of what follows the last divergence, if there is one."""
        p, codes, rows = self._p.copy(), self._output.codes, self._output.estimates
        for name, slot in self._slots.items():
            p[slot] = values[name] ** 2
        p[P0 + X1], p[P0 + X2] = p[R1], p[R2]
        belief, scratch, state = loop_arrays(FILTER, self._states.n, 2, self._drive)
        state.gate[STOP_AT] = NEVER

        def take(begin: int, end: int) -> tuple[Array, Array]:
            """Take the samples from `begin` to `end`; return the sums after them."""
            while begin < end:
                begin += run(
                    self._states, self._settings, p, part_of(self._stream, begin, end), state,
                    belief, scratch, self._output._replace(
                        codes=codes[begin:end], estimates=rows[begin:end]))[0]
            return _sums(belief.memory, len(values))

        at, stamps = 0, self._stream.stamps
        while at < len(codes) and not (at and codes[at - 1] == ESTIMATE):
            take(at, at + 1)
            at += 1
        later = at + int(np.argmax(np.append(settled(stamps[at - 1:])[1:], True)))
        settled_sums, sums_at_end = take(at, later), take(later, len(codes))
        diverged = int(state.counts[DIVERGED])
        logliks = rows[later:, E_LOGLIK][codes[later:] == ESTIMATE]
        value = float(logliks.sum()) if len(logliks) else -math.inf
        # theta is the logarithm of a variance
        gradient, information = (
            scale * (sums if diverged else sums - first)
            for scale, sums, first in zip((2.0, 4.0), sums_at_end, settled_sums))
        return Slopes(value - DIVERGENCE_COST * diverged, gradient, information, 1, bool(diverged))


def suited(model: DriveModel, parameters: EstimatorParameters) -> bool:
    """Return whether LikelihoodSlopes know the filter with `parameters` for the drive `model`."""
    p = pack(drive_of(model, parameters), parameters)
    return bool(parameters.filter in ('ekf', 'aekf') and p[CURVE_COUNT] < 0.0
                and p[NUMERIC] == 0.0 and p[LAW] == ATAN)


def _sums(memory: Array, count: int) -> tuple[Array, Array]:
    """Return gradient [count] and information [count, count] that `step` has added up."""
    rows, columns = np.tril_indices(count)
    information = np.zeros((count, count))
    information[rows, columns] = information[columns, rows] = memory[
        INFORMATION:INFORMATION + len(rows)]
    return memory[THETA:THETA + count].copy(), information


class Trial(NamedTuple):
    """
    A criterion and what it is made of.

    criterion; diverged: whether the filter did; features [N, k] of N samples, NaN where they do
    not count: the criterion falls as the squares of (changes of features) * weights [N, k].
    """

    criterion: float
    diverged: bool
    features: Array
    weights: Array


def likelihood(model: DriveModel, parameters: EstimatorParameters, samples: Samples) -> Trial:
    """
    Return the log-likelihood, whose features tell as much as Fisher's information.

    Those are innovations, the arm's less what the motor's predicts of it, and their log-variances.

    Args:
        model: of the drive.
        parameters: of the filter.
        samples: the recording.
    """
    estimates, diverged = run_unsmoothed(model.exact(), parameters, samples)
    rows = estimates.rows
    variance = rows[:, [E_INNOVATION_STD_MOTOR, E_INNOVATION_STD_ARM]] ** 2
    white = rows[:, [E_WHITE_1, E_WHITE_2]]
    variance[:, 1] -= np.where(np.isfinite(white[:, 0]), rows[:, E_INNOVATION_COVARIANCE] ** 2
                               / variance[:, 0], 0.0)
    variance = np.where(np.isfinite(white), variance, np.nan)
    features = np.column_stack([white * np.sqrt(variance), np.log(variance)])
    weights = np.column_stack([variance ** -0.5, np.full_like(variance, math.sqrt(0.5))])
    features[~settled(estimates.stamp_ns)] = math.nan
    return Trial(score(estimates, diverged=diverged).criterion, bool(diverged),
                 *by_sample(estimates, features, weights))


def by_sample(estimates: Estimates, *columns: Array) -> tuple[Array, ...]:
    """Return `columns` [M, k] of the M `estimates` by sample [N, k], NaN where there is none."""
    result = []
    for column in columns:
        result.append(np.full((len(estimates.codes), column.shape[1]), math.nan))
        result[-1][estimates.codes == ESTIMATE] = column
    return tuple(result)


def differenced(evaluate: Callable[[Mapping[str, float]], Trial],
                values: Mapping[str, float]) -> Slopes:
    """
    Return the slopes of any criterion, by central differences.

    Args:
        evaluate: of {name: value}, gives the Trial.
        values: where.
    """
    def around(name: str, sign: float) -> Trial:
        """Return the Trial with `name` a step of that `sign` away."""
        return evaluate({**values, name: values[name] * math.exp(sign * DIFFERENCE)})

    middle = evaluate(values)
    sides = [(around(name, 1.0), around(name, -1.0)) for name in values]
    features = np.array([np.nan_to_num(
        (upper.features - lower.features) / (2.0 * DIFFERENCE) * middle.weights).ravel()
        for upper, lower in sides])
    gradient = [(upper.criterion - lower.criterion) / (2.0 * DIFFERENCE) for upper, lower in sides]
    return Slopes(middle.criterion, np.array(gradient), features @ features.T, 1 + 2 * len(sides),
                  middle.diverged + sum(one.diverged for pair in sides for one in pair))
