# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Where runs of another simulator start: positions and speeds that fit a window best."""
from collections.abc import Callable

import numpy as np

from gearbox_monitor.kernels.types import Array

STEPS = (1e-4, 1e-3)   # rad and rad/s: differences that make a slope
DAMPINGS = (0.0, 0.1, 0.3, 1.0, 5.0)  # of a step, over its slopes, until it helps
ITERATIONS = 8
GAIN = 1e-3            # least relative gain of an iteration worth another


def slopes(residual_of: Callable[[Array], Array], start: Array, steps: Array) -> Array:
    """
    Return the slopes of a residual over the start, by central differences.

    Args:
        residual_of: see fitted_start.
        start: [n].
        steps: differences [n].

    Returns:
        A column for each value of the start.
    """
    return np.column_stack([
        (residual_of(start + step * e) - residual_of(start - step * e)) / (2.0 * step)
        for step, e in zip(steps, np.eye(len(start)))])


def fitted_start(residual_of: Callable[[Array], Array], start: Array, steps: Array
                 ) -> tuple[Array, Array]:
    """
    Return the start that fits best, and its residual (Levenberg-Marquardt).

    Args:
        residual_of: function of a start [n] that runs a window: residual, in standard deviations.
        start: where the search begins [n].
        steps: differences that make a slope [n].

    Returns:
        (start [n], residual).
    """
    residual = residual_of(start)
    for _ in range(ITERATIONS):
        columns = slopes(residual_of, start, steps)
        size = np.sqrt(np.sum(columns * columns, axis=0))
        before = float(residual @ residual)
        for damping in DAMPINGS:
            change = np.linalg.lstsq(np.vstack([columns, np.diag(damping * size)]),
                                     np.append(-residual, 0.0 * start), rcond=None)[0]
            trial = residual_of(start + change)
            if trial @ trial < float(residual @ residual):
                start, residual = start + change, trial
                break
        if float(residual @ residual) > (1.0 - GAIN) * before:
            break
    return start, residual
