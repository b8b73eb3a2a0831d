# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Signals of another clock: at other stamps, and the lag that makes them fit a motion."""
from collections.abc import Mapping

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.recordings.log_units import EFFORT, POSITION, VELOCITY
from gearbox_monitor.recordings.mapping import kind_of

DROPOUT = 3.0  # sample times between two samples that are not interpolated
LAGS, POINTS = 1500, 3000  # that are tried, and at which each is judged
OVERLAP = 0.5  # of the shorter recording, at every lag
EXPLAINED = 0.5  # share of the variance without which no lag is stated
WIDEST = 0.25  # of the range of lags: a motion with as wide an optimum has no feature to align


def interpolated(stamp_ns: Integers, own_ns: Integers, values: Array) -> Array:
    """
    Return a signal at other stamps, linearly interpolated.

    Args:
        stamp_ns: int64 [N], of the samples that are asked for.
        own_ns: int64 [M], of the signal; of samples in disorder or with one stamp the first count.
        values: float [M], NaN = not measured.

    Returns:
        float [N], NaN outside of the signal and within its dropouts.
    """
    own_ns, rows = np.unique(own_ns, return_index=True)
    values = values[rows]
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


def estimated_lag(source: str, first_ns: Integers, first: Mapping[str, Array],
                  second_ns: Integers, second: Mapping[str, Array]) -> tuple[float, float]:
    """
    Return (s by which the second stamps must grow to fit the first, share of variance explained).

    Args:
        source: of the mapping, for messages.
        first_ns: stamps [N].
        first: {signal: [N]} with a position.
        second_ns: stamps [M] of another clock.
        second: {signal: [M]} with a position or an effort.

    Raises:
        InputError: no lag explains the second, or several do as well.
    """
    where = f'{source}: second_file.lag: estimated'
    positions = [x for name, x in first.items() if kind_of(name).quantity == POSITION]
    names = sorted(second, key=lambda name: kind_of(name).quantity, reverse=True)
    if not positions or kind_of(names[0]).quantity == VELOCITY:
        raise InputError(f'{where}: no position in the first file and position or effort in the '
                         'second, expected a number (s)')
    t, own = ((stamps - int(first_ns[0])) * 1e-9 for stamps in (first_ns, second_ns))
    position, y = positions[0], second[names[0]]
    t, position = t[~np.isnan(position)], position[~np.isnan(position)]
    own, y = own[~np.isnan(y)], y[~np.isnan(y)]
    overlap = OVERLAP * min(t[-1] - t[0], own[-1] - own[0])
    low, high = t[0] + overlap - own[-1], t[-1] - overlap - own[0]
    regressors = _regressors(t, position, kind_of(names[0]).quantity == EFFORT)
    keep = np.unique(np.linspace(0, len(own) - 1, POINTS).astype(int))

    def misfit_at(lag: float) -> float:
        return _unexplained(t, regressors, own[keep] + lag, y[keep])
    lags = np.linspace(low, high, LAGS)
    misfit = np.array([misfit_at(lag) for lag in lags])
    at = int(misfit.argmin())
    lobe: Flags = misfit < 2.0 * misfit[at] + 0.01
    borders = np.flatnonzero(~lobe)
    begin = int(max(borders[borders < at], default=-1)) + 1
    end = int(min(borders[borders > at], default=len(lobe))) - 1
    if misfit[at] > 1.0 - EXPLAINED:
        raise InputError(f'{where}: no lag from {low:.3g} to {high:.3g} s explains more than '
                         f'{1.0 - misfit[at]:.0%} of the signal, expected a number (s)')
    others = [k for k in np.flatnonzero(lobe) if not begin <= k <= end]
    if others:
        raise InputError(f'{where}: {lags[at]:.4g} s and {lags[others[0]]:.4g} s fit as well (a '
                         'periodic motion), expected a number (s)')
    if end - begin > WIDEST * LAGS:
        raise InputError(f'{where}: all lags from {lags[begin]:.3g} to {lags[end]:.3g} s fit as '
                         'well, expected a number (s)')
    lag = float(scipy.optimize.minimize_scalar(misfit_at, bounds=(
        lags[max(at - 1, 0)], lags[min(at + 1, LAGS - 1)]), method='bounded',
        options={'xatol': 1e-7}).x)
    return lag, 1.0 - misfit_at(lag)


def _regressors(t: Array, position: Array, of_effort: bool) -> Array:
    """Return what explains a position, or an effort: [N, R] with derivatives over 10 samples."""
    if not of_effort:
        return np.column_stack([position, np.ones(len(t))])
    window = np.full(9, 1.0 / 9.0)

    def smooth(x: Array) -> Array:
        smoothed: Array = np.convolve(np.pad(x, 4, mode='edge'), window, 'valid')
        return smoothed
    velocity = smooth(np.gradient(smooth(position), t))
    acceleration = smooth(np.gradient(velocity, t))
    # The sign as a function without jumps, so that quantised positions at rest say nothing.
    sign = np.tanh(velocity / (0.05 * np.abs(velocity).max() + 1e-300))
    return np.column_stack([acceleration, velocity, sign, position, np.ones(len(t))])


def _unexplained(t: Array, regressors: Array, at: Array, y: Array) -> float:
    """Return the share of the variance of `y` at times `at` that regressors at `t` leave."""
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
    coefficients = np.linalg.lstsq(columns.T @ columns, columns.T @ y, rcond=1e-12)[0]
    residual = y - columns @ coefficients
    return float(residual @ residual) / variance
