# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Views of a residual: binned over the motion, smoothed over time.

x, y: values of the axes; x_edges, y_edges, edges: of their bins.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.diagnosis.joint.basis_functions import FEWEST
from gearbox_monitor.kernels.types import Array, Integers


@dataclass(frozen=True)
class BinnedMap:
    """A quantity over a motion variable: edges [B + 1], rms [B]; NaN where samples are few."""

    edges: Array
    rms: Array


def binned(x: Array, value: Array, edges: Array) -> BinnedMap:
    """
    Return the Map of `value` [...] over x [...], or of value [..., C]: channels together.

    What lies beyond the edges counts in the outermost bins.

    Args:
        x: motion variable in each sample.
        value: quantity to average, of the shape of `x`, or with channels as a last axis.
        edges: edges of the bins [B + 1], in the unit of the motion variable.
    """
    return BinnedMap(edges, _rms(value, _bins(x, edges), len(edges) - 1, FEWEST))


def plane(x: Array, y: Array, value: Array, x_edges: Array, y_edges: Array) -> Array:
    """
    Return the rms [Y, X] of value [..., C] over two variables; NaN where samples are few.

    Args:
        x: motion variable in each sample.
        y: second motion variable in each sample.
        value: quantity to average, of the shape of `x`, or with channels as a last axis.
        x_edges: edges of the columns [X + 1].
        y_edges: edges of the rows [Y + 1].
    """
    rows, columns = len(y_edges) - 1, len(x_edges) - 1
    at = _bins(y, y_edges) * columns + _bins(x, x_edges)
    return _rms(value, at, rows * columns, FEWEST / 10.0).reshape(rows, columns)


def _bins(x: Array, edges: Array) -> Integers:
    """Return the number of the bin [N] of each of the values `x` [...]."""
    return np.clip(np.searchsorted(edges, np.ravel(x), side='right') - 1, 0, len(edges) - 2)


def _rms(value: Array, at: Integers, bins: int, fewest: float) -> Array:
    """Return the rms [bins] of `value` in the bins `at` [N]; NaN below the share `fewest`."""
    power = (np.asarray(value, float).reshape(len(at), -1) ** 2).mean(axis=-1)
    count = np.bincount(at, minlength=bins)
    populated = count >= max(1.0, fewest * len(at))
    total = np.bincount(at, power, minlength=bins)
    return np.sqrt(np.where(populated, total / np.where(populated, count, 1), np.nan))


def smoothed(residual: Array, dt: float, seconds: float = 0.02) -> Array:
    """
    Return the moving mean [N] of a residual [N] over `seconds`: what is more than noise.

    Args:
        residual: residual of one encoder [N].
        dt: sample time, s.
        seconds: length of the moving mean, s.
    """
    width = max(1, min(round(seconds / dt), len(residual)))
    ones = np.ones(width)
    return np.convolve(residual, ones, 'same') / np.convolve(np.ones(len(residual)), ones, 'same')


def clipped_to_range(y: Array, measured: Array) -> Array:
    """Return y [N], NaN where it is far off all that was measured [N]: fit to be drawn."""
    low, high = float(measured.min()), float(measured.max())
    with np.errstate(invalid='ignore'):
        return np.where(np.abs(y - 0.5 * (low + high)) < 2.0 * (high - low), y, np.nan)
