# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Torque over twist with errors of torque and twist beside it, and its least squares.

    tau = K dz(y, b) + k_s (z - w) + dCv x3 + dCc (2/pi) atan(alpha x3) + g u + dm m
    z = twist - t0 - s x2 - d x4,  w = play of half width |c| behind z
    m = u - K dz(y, b) - k_s (z - w) - D twist' - Cv x3 - Cc (2/pi) atan(alpha x3)

    play, c >= 0   y = w           lower branch while the twist grows (the paper's)
    play, c < 0    y = 2 z - w     upper branch while it grows, on the flanks only
    passive        y = z           a loop of height 2 k_s c everywhere, in the gap, too

A mask states which parameters are fitted. Fitted together, a change of friction or torque gain
cannot pass for a gap, nor the reverse.
"""
from dataclasses import dataclass, replace
import math
from typing import NamedTuple, Self

import numpy as np

from gearbox_monitor.estimation.rts_smoother import (
    S_MOTOR_SIDE, S_TWIST, S_TWIST_RATE, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.linear_least_squares import covariance as covariance_of, Damping
from gearbox_monitor.kernels.types import Array, Cube, Flags, Matrix, Vector
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.transmission import dead_zone

(STIFFNESS, HALF_GAP, WIDTH, ZERO, VISCOUS, COULOMB, GAIN, HEIGHT, SCALE, DELAY, INERTIA,
 N_SHAPE) = range(12)
# Columns of the data; D_FRICTION: share of Coulomb friction that acts.
D_TWIST, D_RATE, D_X2, D_X4, D_X3, D_FRICTION, D_U, D_TORQUE, N_DATA = range(9)
COLUMNS = (S_TWIST, S_TWIST_RATE, S_X2, S_X4, S_X3, S_X3, S_U, S_MOTOR_SIDE)  # of smoothed rows
COLUMN_OF = {VISCOUS: D_X3, COULOMB: D_FRICTION, GAIN: D_U}  # what errors of torque multiply
BLOCKS = 20  # parts of a window that count as independent


def data_of(rows: Array, drive: DriveModel) -> Array:
    """Return the data [N, N_DATA] of smoothed `rows` [N, N_SMOOTHED] of a `drive`."""
    data = np.ascontiguousarray(rows[:, COLUMNS])
    data[:, D_FRICTION] = drive.friction_side(rows[:, S_X3])
    return data


class ElasticLaw(NamedTuple):
    """
    What a regression compares, and how.

    passive: whether the loop is open in the backlash, too. by_height: whether HEIGHT is k_s |c|
    (N m) instead of k_s. side: end that carries the play at the first row, 1 or -1; 0: unknown,
    and rows until the twist carries it do not count. friction: viscous, Coulomb and damping of the
    model, for INERTIA. group: rows that are averaged. paired: whether each group is compared
    together with the previous one. block: groups whose errors may be correlated. huber: stated
    deviations beyond which residuals count less.
    """

    passive: bool = False
    by_height: bool = False
    side: float = 0.0
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    group: int = 1
    paired: bool = False
    block: int = 1
    huber: float = math.inf


@entry
def normal_equations(theta: Vector, free: Flags, law: ElasticLaw, data: Matrix, weights: Vector,
                     units: Vector, blocks: tuple[Cube, Matrix, Matrix], residuals: Vector
                     ) -> tuple[float, float]:
    """
    Write the weighted normal equations at `theta` [N_SHAPE], block by block.

    Args:
        theta: parameters [N_SHAPE].
        free: which are fitted [N_SHAPE].
        law: see ElasticLaw.
        data: [N, N_DATA].
        weights: of the groups [M].
        units: 1 over the stated deviations of the groups [M].
        blocks: zeros, written: matrices [M // law.block + 1, N_SHAPE, N_SHAPE], right sides of the
            step [M // law.block + 1, N_SHAPE], and room [3, N_SHAPE].
        residuals: written, of each group, or of each with the previous one, in stated
            deviations [M]; 0 before the play is known.

    Returns:
        The cost, and the share of rows in contact.

    """
    k, b, zero, r = theta[STIFFNESS], theta[HALF_GAP], theta[ZERO], abs(theta[WIDTH])
    per_width = 1.0 / r if law.by_height and r > 0.0 else 0.0
    spring = theta[HEIGHT] * (per_width if law.by_height else 1.0)
    sign, lower = 1.0, 0.0 if law.passive else 1.0
    if theta[WIDTH] < 0.0:
        sign, lower = -1.0, -lower
    normal, right, room = blocks
    slope, last, part = room[0], room[1], room[2]
    w, side, x2_carried, x4_carried = 0.0, law.side, data[0, D_X2], data[0, D_X4]
    error_last, cost, contacts, paired = 0.0, 0.0, 0, not law.paired
    share = (0.5 if law.paired else 1.0) / law.group
    elastic_share = 1.0 - theta[INERTIA]
    for j in range(residuals.shape[0]):
        for p in range(N_SHAPE):
            slope[p] = 0.0
        error = 0.0
        for i in range(j * law.group, (j + 1) * law.group):
            x2, x4, x3, u, friction = (data[i, D_X2], data[i, D_X4], data[i, D_X3], data[i, D_U],
                                       data[i, D_FRICTION])
            z = data[i, D_TWIST] - zero - theta[SCALE] * x2 - theta[DELAY] * x4
            if i == 0:
                w = z - side * r
            if z - w > r or w - z > r:
                side = 1.0 if z > w else -1.0
                w, x2_carried, x4_carried = z - side * r, x2, x4
            stretch = z - w
            load = dead_zone(z - lower * stretch, b)
            flank = 1.0 if load > 0.0 else (-1.0 if load < 0.0 else 0.0)
            if load != 0.0:
                contacts += 1
            steep = k * abs(flank)
            of_stretch = spring - lower * steep
            elastic = k * load + spring * stretch
            slope[STIFFNESS] += elastic_share * load
            slope[HALF_GAP] -= elastic_share * k * flank
            slope[WIDTH] += elastic_share * sign * (
                of_stretch * side - spring * per_width * stretch)
            slope[ZERO] -= elastic_share * steep
            slope[HEIGHT] += elastic_share * stretch * (per_width if law.by_height else 1.0)
            slope[SCALE] -= elastic_share * (steep * x2 + of_stretch * (x2 - x2_carried))
            slope[DELAY] -= elastic_share * (steep * x4 + of_stretch * (x4 - x4_carried))
            slope[VISCOUS] += x3
            slope[COULOMB] += friction
            slope[GAIN] += u
            torque = (elastic + theta[VISCOUS] * x3 + theta[COULOMB] * friction
                      + theta[GAIN] * u)
            if free[INERTIA]:  # M1 x3', by the curve: tau_K itself would explain itself
                viscous, coulomb, damping = law.friction
                missing = (u - elastic - damping * data[i, D_RATE] - viscous * x3
                           - coulomb * friction)
                slope[INERTIA] += missing
                torque += theta[INERTIA] * missing
            error += data[i, D_TORQUE] - torque
        residuals[j] = 0.0
        if side == 0.0:
            continue
        both = share * units[j]
        for p in range(N_SHAPE):
            part[p] = both * (slope[p] + last[p])
            if law.paired:
                last[p] = slope[p]
        e = both * (error + error_last)
        if law.paired:
            error_last = error
            if not paired:
                paired = True
                continue
        residuals[j] = e
        size = abs(e)
        weight = weights[j] / max(1.0, size / law.huber)
        cost += weights[j] * (e * e if size < law.huber
                              else law.huber * (2.0 * size - law.huber))
        at = j // law.block
        for p in range(N_SHAPE):
            if free[p]:
                weighted = weight * part[p]
                right[at, p] += weighted * e
                for q in range(p + 1):
                    if free[q]:
                        normal[at, p, q] += weighted * part[q]
    for at in range(normal.shape[0]):
        for p in range(N_SHAPE):
            for q in range(p):
                normal[at, q, p] = normal[at, p, q]
    return cost, contacts / max(data.shape[0], 1)


class _Problem(NamedTuple):
    """What Regression holds of the same names, for `_minimise`."""

    law: ElasticLaw
    data: Matrix
    weights: Vector
    units: Vector
    prior: Vector
    base: Vector
    low: Vector
    high: Vector
    strict: bool


class _Room(NamedTuple):
    """What `_evaluated` and `_minimise` write."""

    blocks: tuple[Cube, Matrix, Matrix]  # as of normal_equations
    residuals: Vector
    normals: Cube    # [3, N_SHAPE, N_SHAPE]
    vectors: Matrix  # [4, N_SHAPE]


@kernel
def _evaluated(theta: Array, free: Flags, problem: _Problem, room: _Room, normal: Array,
               right: Array) -> float:
    """Move `theta` within its bounds, write the normal equations, return the cost."""
    normals, rights, sums = room.blocks
    at, beyond, cost = room.vectors[0], False, 0.0
    for p in range(N_SHAPE):
        x = theta[p]
        if x < problem.low[p]:
            x = problem.low[p]
        elif x > problem.high[p]:
            x = problem.high[p]
        if free[p]:
            beyond |= x != theta[p]
            cost += problem.prior[p] * x * x
        theta[p], at[p] = x, problem.base[p] + x
        for k in range(sums.shape[0]):
            sums[k, p] = 0.0
        for k in range(rights.shape[0]):
            rights[k, p] = 0.0
            for q in range(N_SHAPE):
                normals[k, p, q] = 0.0
    cost += normal_equations(at, free, problem.law, problem.data, problem.weights, problem.units,
                             room.blocks, room.residuals)[0]
    for p in range(N_SHAPE):
        right[p] = -problem.prior[p] * theta[p] if free[p] else 0.0
        for q in range(N_SHAPE):
            normal[p, q] = problem.prior[p] if p == q and free[p] else 0.0
        for k in range(rights.shape[0]):
            right[p] += rights[k, p]
            for q in range(N_SHAPE):
                normal[p, q] += normals[k, p, q]
    return math.inf if problem.strict and beyond else cost


@kernel
def _step(normal: Array, right: Array, damping: float, rule: Damping, factor: Array, step: Array
          ) -> bool:
    """Write the damped `step`, by Cholesky; return whether the damped matrix is positive."""
    for i in range(N_SHAPE):
        added = normal[i, i] * (damping + rule.relative) + rule.absolute
        step[i] = right[i]
        for j in range(i + 1):
            value = normal[i, j]
            if i == j:
                value += added if added > 0.0 else 1.0
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = value / factor[j, j]
                step[i] -= factor[i, j] * step[j]
            elif value > 0.0:
                factor[i, i] = math.sqrt(value)
            else:
                return False
        step[i] /= factor[i, i]
    for i in range(N_SHAPE - 1, -1, -1):
        for j in range(i + 1, N_SHAPE):
            step[i] -= factor[j, i] * step[j]
        step[i] /= factor[i, i]
    return True


@entry
def _minimise(theta: Vector, free: Flags, problem: _Problem, rule: Damping, tolerance: float,
              iterations: int, room: _Room) -> None:
    """Move `theta` to the minimum by the steps of levenberg_marquardt.minimise."""
    normal, next_normal, factor = room.normals[0], room.normals[1], room.normals[2]
    right, next_right, trial = room.vectors[1], room.vectors[2], room.vectors[3]
    cost = _evaluated(theta, free, problem, room, normal, right)
    damping, failures = rule.start, 0
    for _ in range(iterations):
        gain = -math.inf
        if _step(normal, right, damping, rule, factor, trial):
            for p in range(N_SHAPE):
                trial[p] += theta[p]
            gain = cost - _evaluated(trial, free, problem, room, next_normal, next_right)
        if gain > 0.0 or (rule.level and gain == 0.0):
            for p in range(N_SHAPE):
                theta[p], right[p] = trial[p], next_right[p]
                for q in range(N_SHAPE):
                    normal[p, q] = next_normal[p, q]
            solved = gain <= tolerance * cost
            cost -= gain
            damping, failures = max(damping * rule.lowered, rule.smallest), 0
        else:
            damping = min(max(damping * rule.raised, rule.raised_from), rule.largest)
            failures += 1
            solved = failures >= rule.attempts or damping > rule.hopeless
        if solved:
            break


@dataclass(frozen=True, eq=False)
class Optimum:
    """
    The linear problem at a minimum, by B blocks.

    theta [N_SHAPE]. free [N_SHAPE]: what was fitted. normals [B, N_SHAPE, N_SHAPE], rights
    [B, N_SHAPE]: of the step. prior [N_SHAPE]: 1 over the variance of the deviation of a parameter
    from 0, in units of the residuals' variance. contact: share of the rows that a flank holds.
    """

    theta: Array
    free: Flags
    normals: Array
    rights: Array
    prior: Array
    contact: float

    def normal(self) -> Array:
        """Return the normal matrix [N_SHAPE, N_SHAPE], 0 of what was not fitted."""
        total: Array = self.normals.sum(axis=0) + np.diag(self.prior)
        return total

    def covariance(self, variance: float = 1.0, held: bool = False) -> Array:
        """
        Return the covariance [N_SHAPE, N_SHAPE] of theta, 0 where nothing was fitted.

        The scatter of the blocks decides, not that of samples: residuals are correlated. They
        scatter less than errors, by what the fit has taken up: G blocks with p parameters count as
        G - p (Cameron and Miller 2015).

        Args:
            variance: that of the residuals that the prior was given in.
            held: whether p is without what priors hold.

        Returns:
            The covariance.

        """
        free, prior = self.free, self.prior[self.free]
        scores = self.rights[:BLOCKS, free]
        inverse = covariance_of(self.normal()[np.ix_(free, free)])
        blocks = int((np.abs(scores).sum(axis=1) > 0.0).sum())
        fitted = len(prior) - (float(np.diag(inverse) @ prior) if held else 0.0)
        middle = scores.T @ scores * (blocks / max(blocks - fitted, 1.0))
        result = np.zeros((N_SHAPE, N_SHAPE))
        result[np.ix_(free, free)] = inverse @ (middle + np.diag(prior * variance)) @ inverse
        return result

    def with_prior(self, prior: Array) -> Self:
        """Return the optimum of the same linear problem with another `prior` [N_SHAPE]."""
        moved = replace(self, prior=np.where(self.free, prior, 0.0))
        right = self.rights.sum(axis=0) + self.normals.sum(axis=0) @ self.theta
        theta = np.where(self.free, covariance_of(moved.normal()) @ right, self.theta)
        return replace(moved, theta=theta, rights=self.rights + self.normals @ (
            self.theta - theta))


class Regression:
    """
    Least squares of the torque over one window, by Levenberg and Marquardt.

    data [N, N_DATA], law: see normal_equations. weights, units [N // law.group]: of the groups,
    see there. prior: see Optimum. low, high [N_SHAPE]: bounds of the parameters; beyond them is no
    step where `strict`, else the bound. base [N_SHAPE]: what the parameters are changes of.
    """

    def __init__(self, data: Array, law: ElasticLaw, weights: Array) -> None:
        self.data, self.law, self.weights = data, law, weights
        self.units: Array = np.ones(len(weights))
        self.prior: Array = np.zeros(N_SHAPE)
        self.base = np.zeros(N_SHAPE)
        self.low, self.high = np.full(N_SHAPE, -np.inf), np.full(N_SHAPE, np.inf)
        self.low[[STIFFNESS, HALF_GAP]] = 0.0
        self.strict = False
        self.residuals = np.zeros(len(weights))

    def evaluate(self, theta: Array, free: Flags) -> tuple[float, Optimum]:
        """Return the cost and the linear problem at `theta` [N_SHAPE]; free: see Optimum."""
        blocks = normals, rights, _ = _blocks(len(self.weights) // self.law.block + 1)
        cost, contact = normal_equations(self.base + theta, free, self.law, self.data,
                                         self.weights, self.units, blocks, self.residuals)
        prior = np.where(free, self.prior, 0.0)
        return cost + float(prior @ theta ** 2), Optimum(
            theta, free, normals, rights, prior, contact)

    def solve(self, theta: Array, free: Flags, rule: Damping, tolerance: float,
              iterations: int) -> float:
        """
        Minimise the cost; `optimum` and `residuals` are those of the minimum.

        Args:
            theta: start [N_SHAPE].
            free: which parameters are fitted [N_SHAPE].
            rule: of the damping.
            tolerance: of the cost, for another step.
            iterations: at most.

        Returns:
            The cost at the minimum.

        """
        theta, count = theta.copy(), len(self.weights) // self.law.block + 1
        problem = _Problem(self.law, self.data, self.weights, self.units, self.prior, self.base,
                           self.low, self.high, self.strict)
        _minimise(theta, free, problem, rule, tolerance, iterations, _Room(
            _blocks(count), self.residuals, np.empty((3, N_SHAPE, N_SHAPE)),
            np.empty((4, N_SHAPE))))
        # The residuals at hand may be those of a step that was not taken.
        cost, self.optimum = self.evaluate(theta, free)
        return cost


def _blocks(count: int) -> tuple[Array, Array, Array]:
    """Return zeros for normal_equations of `count` blocks."""
    return np.zeros((count, N_SHAPE, N_SHAPE)), np.zeros((count, N_SHAPE)), np.zeros((3, N_SHAPE))
