# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Local cosines (Malvar's lapped transform) and masks, of which test functions are made."""
from collections.abc import Callable
import math
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags, Integers


def cosine_basis(hop: int, count: int) -> tuple[Array, Array]:
    """
    Return local cosines [2 hop, M] with a sine window, and their derivatives, 1/samples.

    Args:
        hop: distance of two of them, samples.
        count: number M of frequencies.
    """
    n, order = np.arange(2 * hop) + 0.5, np.arange(count) + 0.5
    phase = np.pi / hop * np.outer(n + hop / 2.0, order)
    window, fall = np.sin(np.pi * n / (2 * hop)), np.cos(np.pi * n / (2 * hop))
    scale, rate = np.sqrt(2.0 / hop), np.pi / hop
    return (scale * window[:, None] * np.cos(phase),
            scale * rate * (0.5 * fall[:, None] * np.cos(phase)
                            - window[:, None] * order * np.sin(phase)))


def motion_mask(still: Flags, width: int) -> Array:
    """
    Return a mask [N], 1 in motion and 0 at rest and about it, with ramps.

    Args:
        still: whether it rests [N].
        width: half width of the ramps, samples.
    """
    ones, bell = np.ones(2 * width + 1), np.hanning(2 * width + 3)[1:-1]
    wide = np.convolve(still, ones, 'same') > 0.5
    return np.asarray(np.clip(1.0 - np.convolve(wide, bell / bell.sum(), 'same'), 0, 1))


RANK = 1e-12
LEAST = 1e-100  # of a diagonal: below it no row has the parameter


def covariance(normal: Array) -> Array:
    """Return the inverse [P, P] of a `normal` matrix, 0 of what no row determines."""
    diagonal = np.diag(normal)
    scale = np.where(diagonal > LEAST, 1.0 / np.sqrt(np.maximum(diagonal, LEAST)), 0.0)
    unit = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(normal * unit, RANK) * unit)


Trial = TypeVar('Trial')


class Damping(NamedTuple):
    """
    How the damping of steps moves, relative to the diagonal of the normal matrix.

    start: of the first step. raised: factor after a step that did not help, to `raised_from` at
    least and `largest` at most. lowered: factor after one that did, to `smallest` at least.
    attempts: steps in a row that do not help until a problem is given up. hopeless: damping beyond
    which it is. absolute, relative: what the diagonal has beside the damping. level: whether a
    step of equal cost helps.
    """

    start: float
    raised: float = 10.0
    raised_from: float = 0.0
    largest: float = math.inf
    lowered: float = 0.1
    smallest: float = 0.0
    attempts: int = 100
    hopeless: float = math.inf
    absolute: float = 0.0
    relative: float = 0.0
    level: bool = False

    def after(self, damping: Array, improved: Flags) -> Array:
        """Return the `damping` [M] of next steps, by whether the last ones `improved` [M]."""
        return np.where(improved, np.maximum(damping * self.lowered, self.smallest), np.minimum(
            np.maximum(damping * self.raised, self.raised_from), self.largest))


class LeastSquaresProblems(Protocol):
    """Problems side by side; those numbered `index` [M] are meant, at `theta` [M, P]."""

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """
        Return (residuals [M, R], or what `linearised` needs of `theta`, costs [M]).

        It may move `theta` into bounds. index: numbers of the problems [M].
        """

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """Return normal matrices [M, P, P], right sides [M, P]: `theta`, `residual`, `index`."""


def minimise(problems: LeastSquaresProblems, start: Array, rule: Damping, tolerance: float,
             passes: int, steps: int = 10 ** 6, ridge: Array | None = None
             ) -> tuple[Array, Array, Array]:
    """
    Return (theta [W, P], residuals [W, R], costs [W]) at the minima; those reached wait.

    Args:
        problems: how they are evaluated and linearised.
        start: parameters [W, P].
        rule: of the damping.
        tolerance: relative gain of a step up to which a problem is solved.
        passes: steps tried at most.
        steps: steps that help, at most.
        ridge: 1 over the variance of the parameters about 0 [W, P], None for none; it is no part
            of `problems`, and is not damped.
    """
    theta, active = start.copy(), np.arange(len(start))
    ridge = np.zeros(start.shape) if ridge is None else ridge

    def evaluated(theta: Array, index: Integers) -> tuple[Array, Array]:
        """Do as problems.evaluated with `theta` of `index`, the ridge in the costs."""
        residual, cost = problems.evaluated(theta, index)
        return residual, cost + (theta ** 2 * ridge[index]).sum(axis=1)
    residual, cost = evaluated(theta, active)
    count = theta.shape[1]
    diagonal = np.arange(count)
    damping = np.full(len(theta), rule.start)
    failures, helped = np.zeros((2, len(theta)), int)
    normal, right = np.empty((len(theta), count, count)), np.empty(theta.shape)
    moved = active
    for _ in range(passes):
        if len(moved):
            normal[moved], right[moved] = problems.linearised(theta[moved], residual[moved], moved)
        damped = normal[active]
        added = damped[:, diagonal, diagonal] * (
            damping[active, None] + rule.relative) + rule.absolute
        damped[:, diagonal, diagonal] += ridge[active]
        damped[:, diagonal, diagonal] += np.where(added > 0.0, added, 1.0)
        pull = right[active] - ridge[active] * theta[active]
        trial = theta[active] + np.linalg.solve(damped, pull[:, :, None])[:, :, 0]
        trial_residual, trial_cost = evaluated(trial, active)
        gain = cost[active] - trial_cost
        improved = gain >= 0.0 if rule.level else gain > 0.0
        solved = gain <= tolerance * cost[active]
        damping[active] = rule.after(damping[active], improved)
        failures[active] = np.where(improved, 0, failures[active] + 1)
        helped[active] += improved
        solved = np.where(improved, solved | (helped[active] >= steps), (
            failures[active] >= rule.attempts) | (damping[active] > rule.hopeless))
        moved = active[improved]
        theta[moved], residual[moved] = trial[improved], trial_residual[improved]
        cost[moved] = trial_cost[improved]
        moved, active = active[improved & ~solved], active[~solved]
        if not len(active):
            break
    return theta, residual, cost


def damped_step(normal: Array, right: Array, trial_of: Callable[[Array], Trial],
                gain_of: Callable[[Trial], float], damping: float, rule: Damping
                ) -> tuple[Trial, float] | None:
    """
    Return (where the first step that helps leads to, damping of the next); None if none helps.

    Args:
        normal: normal matrix [P, P].
        right: right side [P] of a step.
        trial_of: where a step [P] leads to.
        gain_of: how much that is better, above 0 to be taken.
        damping: of the first step tried.
        rule: of the damping.
    """
    for _ in range(rule.attempts):
        trial = trial_of(damped_solve(normal, right, damping))
        improved = gain_of(trial) > 0.0
        damping = float(rule.after(np.array(damping), np.array(improved)))
        if improved:
            return trial, damping
    return None


def damped_solve(S: Array, g: Array, damping: float) -> Array:
    """
    Solve S dz = g, scaled by its diagonal, Levenberg-Marquardt damping on it.

    Args:
        S: normal matrix [P, P].
        g: right side [P].
        damping: relative to the diagonal.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-12 * max(np.diag(S).max(initial=0.0), 1e-30)))
    scaled = S * scale[:, None] * scale
    scaled[np.diag_indices_from(scaled)] += damping
    return scale * np.linalg.solve(scaled, scale * g)
