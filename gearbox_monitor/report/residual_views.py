# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Views of a residual: binned over the motion, smoothed over time.

x, y: values of the axes; x_edges, y_edges, edges: of their bins.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.identification.basis_functions import FEWEST
from gearbox_monitor.kernels.types import Array, Integers


@dataclass(frozen=True)
class BinnedMap:
    """
    A quantity over a motion variable: edges [B + 1], count [B], mean [B], rms [B].

    NaN in bins with too few samples.
    """

    edges: Array
    count: Integers
    mean: Array
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
    bins = len(edges) - 1
    x = np.asarray(x, float)
    value = np.asarray(value, float).reshape(*x.shape, -1)
    at = np.clip(np.searchsorted(edges, x.ravel(), side='right') - 1, 0, bins - 1)
    count = np.bincount(at, minlength=bins)
    populated = count >= max(1.0, FEWEST * x.size)

    def mean(v: Array) -> Array:
        """Return the mean of `v` in each bin, NaN if it holds too few samples."""
        total = np.bincount(at, v.mean(axis=-1).ravel(), minlength=bins)
        return np.where(populated, total / np.where(populated, count, 1), np.nan)
    return BinnedMap(edges, count, mean(value), np.sqrt(mean(value ** 2)))


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
    shape = len(y_edges) - 1, len(x_edges) - 1
    x, y = np.asarray(x, float), np.asarray(y, float)
    power = (np.asarray(value, float).reshape(*x.shape, -1) ** 2).mean(axis=-1).ravel()
    column = np.clip(np.searchsorted(x_edges, x.ravel(), side='right') - 1, 0, shape[1] - 1)
    row = np.clip(np.searchsorted(y_edges, y.ravel(), side='right') - 1, 0, shape[0] - 1)
    at = row * shape[1] + column
    count = np.bincount(at, minlength=shape[0] * shape[1])
    populated = count >= max(1.0, FEWEST / 10.0 * x.size)
    total = np.bincount(at, power, minlength=len(count))
    return np.sqrt(np.where(populated, total / np.where(populated, count, 1),
                            np.nan)).reshape(shape)


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
