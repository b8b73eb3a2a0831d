# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How well a filter predicts: likelihood, consistency, whiteness, error of the torque.

Whiteness is the portmanteau statistic of Ljung and Box (Biometrika 65, 1978). A likelihood takes
whole runs of any filter, in which refused samples, dropouts and restarts count as in run_score.
"""
from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.noise_search import BURN_IN, DIVERGED, Trial
from gearbox_monitor.estimation.sample_loop import (
    E_INNOVATION_COVARIANCE, E_INNOVATION_STD_ARM, E_INNOVATION_STD_MOTOR, E_WHITE_1,
    E_WHITE_2, ESTIMATE, SECOND)
from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values, Vector
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

MIN_SAMPLES = 100
LAGS = 20


@entry
def _centre(column: Vector, out: Vector) -> int:
    """Write finite values of `column` [N] less their mean behind LAGS of `out`; return the end."""
    at, total = LAGS, 0.0
    for i in range(column.shape[0]):
        if math.isfinite(column[i]):
            out[at] = column[i]
            total += column[i]
            at += 1
    mean = total / (at - LAGS)
    for i in range(LAGS, at):
        out[i] -= mean
    return at


@lru_cache(maxsize=64)
def _weights(n: int) -> Array:
    weights: Array = n * (n + 2.0) / np.arange(n - 1.0, n - LAGS - 1.0, -1.0)
    return weights


def ljung_box(e: Array) -> tuple[float, float]:
    """
    Return (Q of Ljung and Box over LAGS lags, sum of squared correlations) of `e` [N].

    NaN is left out; zeros where fewer than MIN_SAMPLES are left, or all are alike.
    """
    out = np.zeros(LAGS + len(e))
    centred = out[:_centre(e, out)]
    n = len(centred) - LAGS
    if n < MIN_SAMPLES:
        return 0.0, 0.0
    products = np.correlate(centred, centred[LAGS:])
    energy = products[LAGS]
    if not energy > 0.0:
        return 0.0, 0.0  # constant: a matter for the mean
    squares = (products[LAGS - 1::-1] / energy) ** 2
    return float(squares @ _weights(n)), float(squares.sum())


# What one divergence costs in log-likelihood: more than any good parameter can gain.
DIVERGENCE_COST = 1e4
# Numbers of scipy.special, which takes longer to load than all of this; tests compute them.
WHITE_LIMIT = 34.16960690283834  # of LAGS degrees of freedom: two encoders share 5 %


@dataclass(frozen=True)
class Score:
    """
    How well a filter predicted its measurements; the first BURN_IN seconds do not count.

    loglik: sum over `estimates`; nis: mean, with the band [nis_low, nis_high] that holds 95 % of
    such means when the filter is right; mean, ljung_box: [2] of the whitened innovations of motor
    and arm, rms [2]: of the innovations (rad); diverged: how often the filter was restarted.
    """

    filter: str
    estimates: int
    loglik: float
    nis: float
    nis_low: float
    nis_high: float
    rms: tuple[float | None, ...]
    mean: tuple[float, ...]
    ljung_box: tuple[float, ...]
    diverged: int

    @property
    def criterion(self) -> float:
        """The log-likelihood with what divergences cost."""
        if not self.estimates:
            return DIVERGED
        return self.loglik - DIVERGENCE_COST * self.diverged


def settled(stamps: Integers, burn_in: float = BURN_IN) -> Flags:
    """Return a mask of the `stamps` int64 [M] ns later than `burn_in` s after the first."""
    return stamps >= (stamps[0] if len(stamps) else 0) + round(burn_in * SECOND)


def score(estimates: Estimates, name: str = '', diverged: int = 0,
          burn_in: float = BURN_IN) -> Score:
    """
    Score the innovations of a filter: likelihood, consistency (NIS) and whiteness.

    The mean NIS of a consistent filter has a chi-square distribution (Bar-Shalom, Li and
    Kirubarajan, Estimation with Applications to Tracking and Navigation, 5.4).

    Args:
        estimates: of the filter.
        name: of the filter.
        diverged: how often the filter failed.
        burn_in: time at the start that does not count, s.

    Returns:
        The Score; without any estimate its criterion is DIVERGED.

    """
    import scipy
    keep = settled(estimates.stamp_ns, burn_in)
    nis, dof = estimates.nis[keep], float(estimates.dof[keep].sum())
    n = len(nis)
    if not n or not dof:
        missing = (np.nan, np.nan)
        return Score(name, 0, DIVERGED, np.nan, np.nan, np.nan, missing, missing, missing,
                     diverged)
    channels = [_finite(column[keep]) for column in (estimates.white_1, estimates.white_2)]
    innovations = (estimates.innovation_motor, estimates.innovation_arm)
    low, high = (float(2.0 * scipy.special.gammaincinv(0.5 * dof, share) / n)
                 for share in (0.025, 0.975))
    return Score(
        name, n, float(estimates.loglik[keep].sum()), float(nis.mean()), low, high,
        tuple(_rms(_finite(innovation[keep])) for innovation in innovations),
        tuple(float(c.mean()) if len(c) else np.nan for c in channels),
        tuple(ljung_box(c)[0] if len(c) > LAGS else np.nan for c in channels), int(diverged))


def run_unsmoothed(model: DriveModel, parameters: EstimatorParameters | Values,
                   samples: Samples) -> tuple[Estimates, int]:
    """
    Run an Estimator without its smoother.

    Args:
        model: of the drive.
        parameters: of the estimator.
        samples: the recording.

    Returns:
        The estimates, and how often the filter diverged.

    Raises:
        InputError: a parameter is unknown or out of range.

    """
    estimator = Estimator(model, unsmoothed(parameters))
    with np.errstate(all='ignore'):
        estimates = estimator.run(samples)
    return estimates, int(estimator.counts[sample_loop.DIVERGED])


def run_score(model: DriveModel, parameters: EstimatorParameters | Values,
              samples: Samples) -> Score:
    """
    Run an Estimator and score it: `model`, `parameters` and `samples` as of run_unsmoothed.

    Returns:
        The Score, named after the filter.

    """
    estimates, diverged = run_unsmoothed(model.exact(), parameters, samples)
    return score(estimates, EstimatorParameters.of(parameters).filter, diverged)


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None


@np.errstate(all='ignore')  # a trial may be anything
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
    rows, counted = estimates.rows, settled(estimates.stamp_ns)
    criterion = float(estimates.loglik[counted].sum()) if counted.any() else DIVERGED
    variance = rows[:, [E_INNOVATION_STD_MOTOR, E_INNOVATION_STD_ARM]] ** 2
    white = rows[:, [E_WHITE_1, E_WHITE_2]]
    variance[:, 1] -= np.where(np.isfinite(white[:, 0]), rows[:, E_INNOVATION_COVARIANCE] ** 2
                               / variance[:, 0], 0.0)
    variance = np.where(np.isfinite(white), variance, np.nan)
    features = np.column_stack([white * np.sqrt(variance), np.log(variance)])
    weights = np.column_stack([variance ** -0.5, np.full_like(variance, math.sqrt(0.5))])
    residual = np.column_stack([white, math.sqrt(0.5) * (1.0 - white ** 2)])
    features[~counted] = math.nan
    return Trial(criterion - DIVERGENCE_COST * diverged, int(diverged > 0), *map(
        np.ravel, by_sample(estimates, features, weights, residual)))


def by_sample(estimates: Estimates, *columns: Array) -> tuple[Array, ...]:
    """Return `columns` [M, k] of the M `estimates` by sample [N, k], NaN where there is none."""
    result = []
    for column in columns:
        result.append(np.full((len(estimates.codes), column.shape[1]), math.nan))
        result[-1][estimates.codes == ESTIMATE] = column
    return tuple(result)
