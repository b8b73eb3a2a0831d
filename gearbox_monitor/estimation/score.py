# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Whiteness of innovations: the portmanteau statistic of Ljung and Box (Biometrika 65, 1978)."""
from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.noise_search import BURN_IN, DIVERGED
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_STD
from gearbox_monitor.estimation.sample_loop import SECOND
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
    return Score(
        name, n, float(estimates.loglik[keep].sum()), float(nis.mean()),
        float(scipy.stats.chi2.ppf(0.025, dof) / n), float(scipy.stats.chi2.isf(0.025, dof) / n),
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


def torque_errors(estimates: Estimates, stamps: Integers, tau_k: Array,
                  burn_in: float = BURN_IN) -> dict[str, float | None]:
    """
    Compare the estimated tau_K with a true or measured one.

    Args:
        estimates: of the filter.
        stamps: of the reference int64 [T], ns.
        tau_k: the reference [T], N m; interpolated between its stamps, see reference_at.
        burn_in: time at the start that does not count, s.

    Returns:
        {name: value}: rms of the reference (N m); rmse (N m) and coverage (share within the
        stated deviation) of the filtered torque; rmse_smoothed and coverage_smoothed of the
        smoothed one. None where no estimate has a reference.

    """
    result = {}
    begin = estimates.stamp_ns[0] + round(burn_in * SECOND) if len(estimates.stamp_ns) else 0
    for suffix, at, value, std in (
            ('', estimates.stamp_ns, estimates.tau_k, estimates.tau_k_std),
            ('_smoothed', estimates.smoothed_stamp_ns, estimates.smoothed[:, S_TAU_K],
             estimates.smoothed[:, S_TAU_K_STD])):
        reference, valid = reference_at(at, stamps, tau_k)
        keep = valid & (at >= begin)
        error = value[keep] - reference[keep]
        if not suffix:
            result['rms'] = _rms(reference[keep])
        result['rmse' + suffix] = _rms(error)
        result['coverage' + suffix] = (
            float((np.abs(error) <= std[keep]).mean()) if len(error) else None)
    return result


def reference_at(at: Integers, stamps: Integers, tau_k: Array) -> tuple[Array, Flags]:
    """
    Interpolate a reference torque linearly, but not across dropouts of 0.1 s or more.

    Args:
        at: stamps int64 [M] at which the torque is asked for, ns.
        stamps: of the reference int64 [T], ns, in any order.
        tau_k: the reference [T], N m; NaN = not measured.

    Returns:
        The torque [M], N m, and a mask [M] of where it is valid.

    """
    finite = np.isfinite(tau_k)
    stamps, index = np.unique(stamps[finite], return_index=True)
    tau_k = tau_k[finite][index]
    if not len(stamps):
        return np.full(len(at), np.nan), np.zeros(len(at), bool)
    upper = np.clip(np.searchsorted(stamps, at), 0, len(stamps) - 1)
    lower = np.clip(upper - 1, 0, None)
    exact = stamps[upper] == at
    between = ((at >= stamps[0]) & (at <= stamps[-1])
               & (stamps[upper] - stamps[lower] < SECOND // 10))
    origin = stamps[0]
    values = np.interp((at - origin) * 1e-9, (stamps - origin) * 1e-9, tau_k)
    values[exact] = tau_k[upper[exact]]
    return values, exact | between


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None
