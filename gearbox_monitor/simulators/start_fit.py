# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Where runs of another simulator start: positions and speeds that fit a window best."""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.kernels.levenberg_marquardt import Damping, minimise
from gearbox_monitor.kernels.types import Array, Integers

STEPS = (1e-4, 1e-3)   # rad and rad/s: differences that make a slope
RULE = Damping(0.0, 9.0, 0.01, lowered=0.0, attempts=5, relative=1e-12)
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
    (start,), (residual,), _ = minimise(_Window(residual_of, steps), start[None], RULE, GAIN,
                                        RULE.attempts * ITERATIONS, ITERATIONS)
    return start, residual


@dataclass(frozen=True, eq=False)
class _Window:
    """The start of one window as a problem, see fitted_start."""

    residual_of: Callable[[Array], Array]
    steps: Array

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta` of the problems `index`."""
        residual = self.residual_of(theta[0])[None]
        return residual, (residual ** 2).sum(axis=1)

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        columns = slopes(self.residual_of, theta[0], self.steps)
        return (columns.T @ columns)[None], -residual @ columns
