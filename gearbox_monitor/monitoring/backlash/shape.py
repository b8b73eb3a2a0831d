# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Torque over twist with friction errors beside it, and its least squares.

    tau = K dz(y, b) + h s + dCv x3 + dCc (2/pi) atan(alpha x3) - dg u
    z = twist - t0,  w = play of half width |c| behind z,  s = (z - w) / |c|

    play, c >= 0   y = z - c s, h = 0   lower branch while the twist grows (the paper's)
    play, c < 0    the same: upper branch while it grows, on the flanks only
    passive        y = z, h free        a loop of height 2 h everywhere, in the gap, too

K, b, c, t0, dCv, dCc, dg, h are fitted together: what friction or a torque gain that have changed
do to tau_K cannot pass for a gap then, nor the reverse. Torque and model are averaged
over pairs of neighbouring groups of samples before they are compared: the noise of a smoothed
torque is high-frequency. Each group belongs to two pairs, so that nothing is lost between them.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.kernels.jit import jit_allocating
from gearbox_monitor.kernels.levenberg_marquardt import Damping, minimise
from gearbox_monitor.kernels.linear_least_squares import covariance
from gearbox_monitor.kernels.types import Array, Flags, Integers

STIFFNESS, HALF_GAP, WIDTH, ZERO, VISCOUS, COULOMB, GAIN, HEIGHT, N_SHAPE = range(9)
RULE = Damping(1e-3, 10.0, 1e-3, hopeless=1e5, relative=1e-12, level=True)  # differ by 1e10
TOLERANCE = 1e-7  # of the cost, for another step


@jit_allocating
def normal_equations(theta: Array, free: Flags, passive: bool, data: Array, group: int,
                     weights: Array, block: int, normal: Array, right: Array, scores: Array,
                     residuals: Array) -> float:
    """
    Write the weighted normal equations at `theta` [N_SHAPE]; return the weighted cost.

    free bool [N_SHAPE]: what is fitted. passive: whether the loop is open in the backlash, too.
    data [N, 5]: twist, tau, x3, friction direction
    (2/pi) atan(alpha x3), u. weights [M]: of the groups of `group` samples, M group <= N. Written:
    normal [N_SHAPE, N_SHAPE] and right [N_SHAPE] of the step, scores [M // block + 1, N_SHAPE]
    (the parts of `right` by blocks of `block` groups), residuals [M] of each group's pair with the
    one before (0 before the play is known).
    """
    k, b, t0, height = theta[STIFFNESS], theta[HALF_GAP], theta[ZERO], theta[HEIGHT]
    active = theta[WIDTH] >= 0.0
    r = abs(theta[WIDTH])
    w, w_r, w_t, tracked = data[0, 0] - t0, 0.0, -1.0, False
    normal[:, :] = 0.0
    right[:] = 0.0
    scores[:, :] = 0.0
    slope, last, pair = np.zeros(N_SHAPE), np.zeros(N_SHAPE), np.zeros(N_SHAPE)
    error_last, paired = 0.0, False
    inverse, cost = 0.5 / group, 0.0
    for j in range(residuals.shape[0]):
        slope[:] = 0.0
        error = 0.0
        for i in range(j * group, (j + 1) * group):
            z = data[i, 0] - t0
            if z - w > r:
                w, w_r, w_t, tracked = z - r, -1.0, -1.0, True
            elif w - z > r:
                w, w_r, w_t, tracked = z + r, 1.0, -1.0, True
            y, y_c, y_t = z, 0.0, -1.0
            if not passive:
                y_c = w_r
                if active:
                    y, y_t = w, w_t
                else:
                    y, y_t = 2.0 * z - w, -2.0 - w_t
            side, load = 0.0, 0.0
            if y > b:
                side, load = 1.0, y - b
            elif y < -b:
                side, load = -1.0, y + b
            torque = k * load
            slope[STIFFNESS] += load
            slope[HALF_GAP] -= k * side
            if side != 0.0:
                slope[WIDTH] += k * y_c
                slope[ZERO] += k * y_t
            if passive and r > 0.0:
                s = (z - w) / r
                torque += height * s
                slope[HEIGHT] += s
                slope[WIDTH] += height * (-w_r - s) / r
                slope[ZERO] += height * (-1.0 - w_t) / r
            slope[VISCOUS] += data[i, 2]
            slope[COULOMB] += data[i, 3]
            slope[GAIN] -= data[i, 4]
            torque += (theta[VISCOUS] * data[i, 2] + theta[COULOMB] * data[i, 3]
                       - theta[GAIN] * data[i, 4])
            error += data[i, 1] - torque
        residuals[j] = 0.0
        if not tracked:
            continue
        for p in range(N_SHAPE):
            pair[p] = inverse * (slope[p] + last[p])
            last[p] = slope[p]
        mean = inverse * (error + error_last)
        error_last = error
        if not paired:
            paired = True
            continue
        error = mean
        residuals[j] = error
        cost += weights[j] * error * error
        for p in range(N_SHAPE):
            if free[p]:
                part = weights[j] * pair[p]
                right[p] += part * error
                scores[j // block, p] += part * error
                for q in range(p + 1):
                    normal[p, q] += part * pair[q]
    for p in range(N_SHAPE):
        for q in range(p):
            normal[q, p] = normal[p, q]
    return cost


class Regression:
    """
    Least squares of the shape over one window, by Levenberg and Marquardt.

    data [N, 5]: see normal_equations. group: samples averaged before they are compared. weights
    [N // group]. blocks: parts of the window that count as independent. prior [N_SHAPE]: 1 over
    the variance of the deviation of a parameter from 0, in units of the residuals' variance.
    twist_span: range of the twist (rad).
    """

    def __init__(self, data: Array, group: int, weights: Array, blocks: int, prior: Array,
                 twist_span: float) -> None:
        self.data, self.group, self.weights, self.prior = data, group, weights, prior
        m = len(weights)
        self.block = max(1, -(-m // blocks))
        self.residuals = np.zeros(m)
        self.scores = np.zeros((m // self.block + 1, N_SHAPE))
        self.span = twist_span
        self.theta: Array = np.zeros(N_SHAPE)
        self.free: Flags = np.zeros(N_SHAPE, bool)
        self.normal: Array = np.zeros((N_SHAPE, N_SHAPE))

    def evaluate(self, theta: Array, free: Flags, passive: bool) -> tuple[float, Array, Array]:
        """
        Return the cost and the normal equations, with the part of the prior.

        Args:
            theta: parameters [N_SHAPE].
            free: which of them are fitted [N_SHAPE].
            passive: whether the loop is open in the backlash, too.

        Returns:
            Cost, normal matrix [N_SHAPE, N_SHAPE] and right side [N_SHAPE].

        """
        normal, right = np.zeros((N_SHAPE, N_SHAPE)), np.zeros(N_SHAPE)
        cost = normal_equations(
            theta, free, passive, self.data, self.group, self.weights, self.block, normal, right,
            self.scores, self.residuals)
        prior = np.where(free, self.prior, 0.0)
        normal[np.arange(N_SHAPE), np.arange(N_SHAPE)] += prior
        return cost + float(prior @ theta ** 2), normal, right - prior * theta

    def solve(self, theta: Array, free: Flags, passive: bool = False,
              iterations: int = 30) -> float:
        """
        Minimise the cost by Levenberg and Marquardt's method.

        Args:
            theta: start [N_SHAPE].
            free: which parameters are fitted [N_SHAPE].
            passive: whether the loop is open in the backlash, too.
            iterations: at most.

        Returns:
            The cost at the minimum, whose parameters stand in `theta` of this object.

        """
        problem = _Free(self, theta, free, passive)
        solved, _, _ = minimise(problem, theta[None, free], RULE, TOLERANCE, iterations)
        theta = problem.whole(solved[0])
        # The scores and residuals at hand may be those of a step that was not taken.
        cost, self.normal, _ = self.evaluate(theta, free, passive)
        self.theta, self.free = theta, free
        return cost

    def covariance(self, variance: float) -> Array:
        """
        Return the covariance [N_SHAPE, N_SHAPE] of theta, 0 where nothing was fitted.

        The scatter of the blocks decides, not that of samples: residuals are correlated.
        variance: that of the residuals that the prior was given in.
        """
        at = np.flatnonzero(self.free)
        used = np.flatnonzero(np.abs(self.scores).sum(axis=1) > 0.0)
        scores = self.scores[np.ix_(used, at)]
        middle = scores.T @ scores * (len(used) / max(len(used) - len(at), 1))
        middle = middle + np.diag(self.prior[at] * variance)
        inverse = covariance(self.normal[np.ix_(at, at)])
        result = np.zeros((N_SHAPE, N_SHAPE))
        result[np.ix_(at, at)] = inverse @ middle @ inverse
        return result


@dataclass(frozen=True, eq=False)
class _Free:
    """A Regression as a problem in those parameters of `start` that are free."""

    regression: Regression
    start: Array
    free: Flags
    passive: bool

    def whole(self, part: Array) -> Array:
        """Return all parameters [N_SHAPE] within their bounds, the free ones from `part`."""
        theta, span = self.start.copy(), self.regression.span
        theta[self.free] = part
        theta[STIFFNESS] = max(theta[STIFFNESS], 0.0)
        theta[HALF_GAP] = min(max(theta[HALF_GAP], 0.0), span)
        low = 1e-3 * span if self.passive else -0.5 * span
        theta[WIDTH] = min(max(theta[WIDTH], low), 0.5 * span)
        return theta

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta` of the problems `index`."""
        whole = self.whole(theta[0])
        theta[0] = whole[self.free]
        cost, normal, right = self.regression.evaluate(whole, self.free, self.passive)
        return np.append(normal[self.free][:, self.free], right[self.free])[None], np.array([cost])

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """See LeastSquaresProblems: `theta`, `residual` of the problems `index`."""
        count = theta.shape[1]
        return residual[:, :-count].reshape(1, count, count), residual[:, -count:]


def warm_up() -> None:
    """Compile normal_equations, or load it."""
    free, zeros = np.ones(N_SHAPE, bool), np.zeros(N_SHAPE)
    Regression(np.zeros((2, 5)), 1, np.ones(2), 1, zeros, 1.0).evaluate(zeros, free, False)
