# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Columns that are made of another one: the same values in another unit, or a filtered copy.

An encoder at the other end of a gear has noise and a lattice of its own. What follows another
column to a fraction of its own resolution, at once or through a short filter, holds nothing new.
"""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.kernels.sensor_noise import quantisation_step
from gearbox_monitor.kernels.types import Array

AFFINE, FILTERED = 'affine', 'filtered'
ORDER = 3           # of a recursive filter that is looked for
EXACT = 1e-6        # of the spread: rounding of numbers as they are written
OF_STEP = 0.05      # of the own lattice: an encoder of its own rounds by 0.29
INNOVATION = 0.02   # of the column's own roughness that a filtered copy leaves at most
ROWS = 20_000       # that are looked at
LEAST = 50          # rows


def copy_of(values: Array, origin: Array) -> str:
    """
    Return AFFINE, FILTERED or '': how the column `values` is made of `origin`.

    Args:
        values: [N]; NaN: not measured.
        origin: [N], that it may be a copy of.
    """
    x, y = np.asarray(origin, float)[:ROWS], np.asarray(values, float)[:ROWS]
    valid = np.isfinite(x) & np.isfinite(y)
    x, y = x[valid], y[valid]
    if len(y) < LEAST or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return ''
    x, y = x - x.mean(), y - y.mean()
    if abs(np.corrcoef(x, y)[0, 1]) > 0.9 and _left(y, [x]) < _rounding(y):
        return AFFINE
    return FILTERED if _filtered(x, y) else ''


def _left(y: Array, columns: Sequence[Array]) -> float:
    """Return the rms that a linear regression on `columns` leaves of `y`."""
    matrix = np.column_stack([*columns, np.ones(len(y))])
    scale = np.abs(matrix).max(axis=0) + 1e-300
    solution = np.linalg.lstsq(matrix / scale, y, rcond=1e-13)[0]
    return float(np.sqrt(np.mean((y - matrix / scale @ solution) ** 2)))


def _rounding(y: Array) -> float:
    """Return the rms of `y` below which a residual is the rounding of a written number."""
    return max(EXACT * float(np.std(y)), OF_STEP * quantisation_step(y))


def _filtered(x: Array, y: Array) -> bool:
    """
    Return whether `y` is `x` through a recursive filter of ORDER.

    The own past of a smooth signal predicts it well, and so does another sensor of the same
    motion; only a filter explains the roughness of `y`, with which its own past fails.
    """
    n = len(y)
    past = [y[ORDER - k:n - k] for k in range(1, ORDER + 1)]
    inputs = [x[ORDER - k:n - k] for k in range(ORDER + 1)]
    target = y[ORDER:]
    unexplained = _left(target, past)
    if unexplained <= _rounding(y):  # smooth to its last digit: nothing tells what it is made of
        return False
    return _left(target, [*past, *inputs]) < INNOVATION * unexplained
