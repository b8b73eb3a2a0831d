# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Signals of two clocks on the stamps of one: interpolation, and the lag between the clocks.

The lag is that at which the motion of one file explains most of the other's signal: positions by
linear regression on the position, efforts on acceleration, velocity, its sign and position.
"""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags, Integers

DROPOUT = 3.0  # sample times between two samples that are not interpolated
LAGS, POINTS = 1500, 3000  # that are tried, and at which each is judged
OVERLAP = 0.5  # of the shorter recording, at every lag
EXPLAINED = 0.5  # share of the variance without which no lag is stated
WIDEST = 0.25  # of the range of lags: a motion with as wide an optimum has no feature to align


@dataclass(frozen=True)
class LagEstimate:
    """Lag of the second clock, s; `explained` share of the variance at it."""

    lag: float
    explained: float


def interpolated(stamp_ns: Integers, own_ns: Integers, values: Array) -> Array:
    """
    Return a signal at other stamps, linearly interpolated.

    Args:
        stamp_ns: int64 [N], of the samples that are asked for.
        own_ns: int64 [M], of the signal, strictly increasing.
        values: float [M], NaN = not measured.

    Returns:
        float [N], NaN outside of the signal and within its dropouts.
    """
    valid = ~np.isnan(values)
    if valid.sum() < 2:
        return np.full(len(stamp_ns), np.nan)
    own, y = (own_ns[valid] - own_ns[0]).astype(float), values[valid]
    at = (stamp_ns - own_ns[0]).astype(float)
    following = np.clip(np.searchsorted(own, at), 1, len(own) - 1)
    step = np.median(np.diff(own_ns))
    hole = (own[following] - own[following - 1] > DROPOUT * step) & (at != own[following]) & (
        at != own[following - 1])
    result: Array = np.interp(at, own, y)
    result[(at < own[0]) | (at > own[-1]) | hole] = np.nan
    return result


def estimated_lag(motion: tuple[Array, Array], response: tuple[Array, Array], is_position: bool,
                  where: str) -> LagEstimate:
    """
    Return the time by which the stamps of `response` must grow to fit `motion`.

    Args:
        motion: (times [N] in s, position [N]).
        response: (times [M] in s, values [M]) of another clock.
        is_position: whether `response` is a position, not an effort.
        where: names the key in messages.

    Returns:
        The LagEstimate.

    Raises:
        InputError: no lag explains the response, or several do as well.
    """
    (t, position), (own, y) = motion, response
    t, position = t[~np.isnan(position)], position[~np.isnan(position)]
    own, y = own[~np.isnan(y)], y[~np.isnan(y)]
    overlap = OVERLAP * min(t[-1] - t[0], own[-1] - own[0])
    low, high = t[0] + overlap - own[-1], t[-1] - overlap - own[0]
    regressors = motion_regressors(t, position, is_position)
    keep = np.unique(np.linspace(0, len(own) - 1, POINTS).astype(int))

    def _misfit(lag: float) -> float:
        return unexplained(t, regressors, own[keep] + lag, y[keep])
    lags = np.linspace(low, high, LAGS)
    misfit = np.array([_misfit(lag) for lag in lags])
    at = int(misfit.argmin())
    lobe = misfit < 2.0 * misfit[at] + 0.01
    first, last = _lobe(lobe, at)
    if misfit[at] > 1.0 - EXPLAINED:
        raise InputError(f'{where}: estimated: no lag from {low:.3g} to {high:.3g} s explains '
                         f'more than {1.0 - misfit[at]:.0%} of the signal, expected a number (s)')
    peaks = np.flatnonzero(lobe[:first].tolist() + [False] * (last + 1 - first)
                           + lobe[last + 1:].tolist())
    if len(peaks):
        raise InputError(f'{where}: estimated: {lags[at]:.4g} s and {lags[peaks[0]]:.4g} s fit '
                         'as well (a periodic motion), expected a number (s)')
    if last - first > WIDEST * LAGS:
        raise InputError(f'{where}: estimated: all lags from {lags[first]:.3g} to '
                         f'{lags[last]:.3g} s fit as well, expected a number (s)')
    lag = _minimum(_misfit, lags[max(at - 1, 0)], lags[min(at + 1, LAGS - 1)])
    return LagEstimate(lag, 1.0 - _misfit(lag))


def _lobe(lobe: Flags, at: int) -> tuple[int, int]:
    """Return first and last place of the run of True around `at`."""
    borders = np.flatnonzero(~lobe)
    lower, upper = borders[borders < at], borders[borders > at]
    return (int(lower[-1]) + 1 if len(lower) else 0,
            int(upper[0]) - 1 if len(upper) else len(lobe) - 1)


def motion_regressors(t: Array, position: Array, is_position: bool) -> Array:
    """
    Return what explains a signal.

    Args:
        t: times [N], s.
        position: [N].
        is_position: whether the signal is a position; else it is an effort.

    Returns:
        [N, R]: position and 1, or acceleration, velocity, its sign, position and 1, with
        derivatives over some 10 samples.
    """
    if is_position:
        return np.column_stack([position, np.ones(len(t))])
    window = np.full(9, 1.0 / 9.0)

    def _smooth(x: Array) -> Array:
        smoothed: Array = np.convolve(np.pad(x, 4, mode='edge'), window, 'valid')
        return smoothed
    velocity = _smooth(np.gradient(_smooth(position), t))
    acceleration = _smooth(np.gradient(velocity, t))
    # The sign as a function without jumps, so that quantised positions at rest say nothing.
    sign = np.tanh(velocity / (0.05 * np.abs(velocity).max() + 1e-300))
    return np.column_stack([acceleration, velocity, sign, position, np.ones(len(t))])


def unexplained(t: Array, regressors: Array, at: Array, y: Array) -> float:
    """
    Return the share of a signal's variance that regressors leave.

    Args:
        t: times [N] of the regressors.
        regressors: [N, R].
        at: times [M] of the signal.
        y: the signal [M].
    """
    overlap = (at >= t[0]) & (at <= t[-1])
    at, y = at[overlap], y[overlap]
    if len(y) <= 2 * regressors.shape[1]:
        return 1.0
    columns = np.column_stack([np.interp(at, t, column) for column in regressors.T])
    columns = columns / (np.abs(columns).max(axis=0) + 1e-300)
    y = y - y.mean()
    variance = float(y @ y)
    if variance == 0.0:
        return 1.0
    normal = columns.T @ columns
    coefficients = np.linalg.lstsq(normal, columns.T @ y, rcond=1e-12)[0]
    residual = y - columns @ coefficients
    return float(residual @ residual) / variance


def _minimum(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the argument between `low` and `high` with the least value (golden section)."""
    result = scipy.optimize.minimize_scalar(
        function, bounds=(low, high), method='bounded', options={'xatol': 1e-7})
    return float(result.x)
