# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Torque over twist with errors of torque and twist, and its least squares.

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
from typing import NamedTuple, Self, TypeAlias

import numpy as np

from gearbox_monitor.estimation.rts_smoother import (
    S_MOTOR_SIDE, S_TWIST, S_TWIST_RATE, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.linear_least_squares import (
    covariance as covariance_of, Damping, minimise)
from gearbox_monitor.kernels.types import Array, Cube, Flags, Integers, Matrix, Vector
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


class _Curve(NamedTuple):
    """What rows have in common at a theta: see the module's equations."""

    k: float
    b: float
    zero: float
    r: float
    per_width: float
    spring: float
    sign: float
    lower: float
    share: float  # of the elastic torque that acts


# A play while rows pass: w, the end that carries it (1, -1; 0: unknown), x2 and x4 when it was
# last carried.
Play: TypeAlias = tuple[float, float, float, float]


@inline
def _curve(theta: Array, law: ElasticLaw) -> _Curve:
    r = abs(theta[WIDTH])
    per_width = 1.0 / r if law.by_height and r > 0.0 else 0.0
    sign, lower = 1.0, 0.0 if law.passive else 1.0
    if theta[WIDTH] < 0.0:
        sign, lower = -1.0, -lower
    return _Curve(theta[STIFFNESS], theta[HALF_GAP], theta[ZERO], r, per_width,
                  theta[HEIGHT] * (per_width if law.by_height else 1.0), sign, lower,
                  1.0 - theta[INERTIA])


@inline
def _carried(play: Play, z: float, r: float, x2: float, x4: float) -> Play:
    """Return a play of half width `r` after the twist z."""
    w, side, x2_carried, x4_carried = play
    if z - w > r or w - z > r:
        side = 1.0 if z > w else -1.0
        w, x2_carried, x4_carried = z - side * r, x2, x4
    return w, side, x2_carried, x4_carried


@inline
def _add_row(theta: Array, law: ElasticLaw, curve: _Curve, row: Array, play: Play, moves: bool,
             slope: Array, every: bool = True) -> tuple[float, Play, bool]:
    """
    Add the slopes of a row's torque to those of its group.

    Args:
        theta: parameters [N_SHAPE].
        law: see ElasticLaw.
        curve: _curve of both.
        row: of the data [N_DATA].
        play: before it.
        moves: whether the inertia is fitted.
        slope: of the group [N_SHAPE], changed.
        every: whether more than FITTED parameters may differ from 0.

    Returns:
        What the torque misses (N m), the play, and whether the row is in contact.

    """
    x2, x4, x3, u, friction = row[D_X2], row[D_X4], row[D_X3], row[D_U], row[D_FRICTION]
    share, spring = curve.share, curve.spring
    z = row[D_TWIST] - curve.zero
    if every:
        z = z - theta[SCALE] * x2 - theta[DELAY] * x4
    w, side, x2_carried, x4_carried = play = _carried(play, z, curve.r, x2, x4)
    stretch = z - w
    load = dead_zone(z - curve.lower * stretch, curve.b)
    flank = 1.0 if load > 0.0 else (-1.0 if load < 0.0 else 0.0)
    steep = curve.k * abs(flank)
    of_stretch = spring - curve.lower * steep
    elastic = curve.k * load + spring * stretch
    slope[STIFFNESS] += share * load
    slope[HALF_GAP] -= share * curve.k * flank
    slope[WIDTH] += share * curve.sign * (of_stretch * side - spring * curve.per_width * stretch)
    slope[ZERO] -= share * steep
    if every:
        slope[HEIGHT] += share * stretch * (curve.per_width if law.by_height else 1.0)
        slope[SCALE] -= share * (steep * x2 + of_stretch * (x2 - x2_carried))
        slope[DELAY] -= share * (steep * x4 + of_stretch * (x4 - x4_carried))
    slope[VISCOUS] += x3
    slope[COULOMB] += friction
    slope[GAIN] += u
    torque = elastic + theta[VISCOUS] * x3 + theta[COULOMB] * friction + theta[GAIN] * u
    if moves:  # M1 x3', by the curve: tau_K itself would explain itself
        viscous, coulomb, damping = law.friction
        missing = u - elastic - damping * row[D_RATE] - viscous * x3 - coulomb * friction
        slope[INERTIA] += missing
        torque += theta[INERTIA] * missing
    return row[D_TORQUE] - torque, play, load != 0.0


@inline
def _pair(both: float, paired: bool, room: Matrix) -> None:
    """Write room[2], the slopes of a group (room[0]) with those of the previous one (room[1])."""
    slope, last, part = room[0], room[1], room[2]
    for p in range(N_SHAPE):
        part[p] = both * (slope[p] + last[p])
        if paired:
            last[p] = slope[p]


@inline
def _add_group(free: Flags, weight: float, e: float, part: Array, normal: Array, right: Array
               ) -> None:
    """Add a residual `e` of that weight with the slopes `part` to the normal equations."""
    for p in range(N_SHAPE):
        if free[p]:
            weighted = weight * part[p]
            right[p] += weighted * e
            for q in range(p + 1):
                if free[q]:
                    normal[p, q] += weighted * part[q]


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
    curve = _curve(theta, law)
    normal, right, room = blocks
    error_last, cost, contacts, paired = 0.0, 0.0, 0, not law.paired
    share = (0.5 if law.paired else 1.0) / law.group
    z = data[0, D_TWIST] - curve.zero - theta[SCALE] * data[0, D_X2] - (
        theta[DELAY] * data[0, D_X4])
    play = z - law.side * curve.r, law.side, data[0, D_X2], data[0, D_X4]
    for j in range(residuals.shape[0]):
        for p in range(N_SHAPE):
            room[0, p] = 0.0
        error = 0.0
        for i in range(j * law.group, (j + 1) * law.group):
            missed, play, contact = _add_row(theta, law, curve, data[i], play, free[INERTIA],
                                             room[0])
            contacts += contact
            error += missed
        residuals[j] = 0.0
        if play[1] == 0.0:
            continue
        both = share * units[j]
        _pair(both, law.paired, room)
        e = both * (error + error_last)
        if law.paired:
            error_last = error
            if not paired:
                paired = True
                continue
        residuals[j] = e
        size = abs(e)
        cost += weights[j] * (e * e if size < law.huber
                              else law.huber * (2.0 * size - law.huber))
        at = j // law.block
        _add_group(free, weights[j] / max(1.0, size / law.huber), e, room[2], normal[at],
                   right[at])
    for at in range(normal.shape[0]):
        for p in range(N_SHAPE):
            for q in range(p):
                normal[at, q, p] = normal[at, p, q]
    return cost, contacts / max(data.shape[0], 1)


@inline
def certainty(x3: float, doubt: float) -> float:
    """Return the weight of a row at the speed `x3`; below `doubt` (rad/s) friction is anything."""
    ratio = x3 / doubt
    ratio *= ratio
    return 0.01 + ratio / (1.0 + ratio)


@entry
def certainties(x3: Vector, doubt: float, weights: Vector) -> None:
    """Write the certainty of each of `x3` [N] to `weights` [N]."""
    for i in range(x3.shape[0]):
        weights[i] = certainty(x3[i], doubt)


class Sums(NamedTuple):
    """
    The normal equations of a window in the drive, row by row; changed in place.

    theta [N_SHAPE], normal [N_SHAPE, N_SHAPE], right [N_SHAPE]: of FITTED parameters, see
    normal_equations. room: see there. row [N_DATA]: the next one. carried: S_*.
    """

    theta: Vector
    normal: Matrix
    right: Vector
    room: Matrix
    row: Vector
    carried: Vector


# Of Sums.carried: cost and number of the groups that entered, rows of a group, those of this one,
# their errors and weights, the errors of the group before, whether there was one, whether there
# was a row, and the Play.
(S_COST, S_GROUPS, S_GROUP, S_ROWS, S_ERROR, S_WEIGHT, S_LAST, S_PAIRED, S_BEGUN, S_PLAY,
 N_CARRIED) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 13
FITTED: Flags = np.arange(N_SHAPE) < HEIGHT
PLAIN = ElasticLaw(paired=True)  # of Sums


@kernel
def add_row(sums: Sums, certain: float) -> None:
    """Add sums.row, whose weight is `certain`, to a window."""
    theta, normal, right, room, row, s = sums
    curve = _curve(theta, PLAIN)
    play = s[S_PLAY], s[S_PLAY + 1], s[S_PLAY + 2], s[S_PLAY + 3]
    if s[S_BEGUN] == 0.0:
        play, s[S_BEGUN] = (row[D_TWIST] - curve.zero, 0.0, row[D_X2], row[D_X4]), 1.0
    missed, play, _ = _add_row(theta, PLAIN, curve, row, play, False, room[0], False)
    s[S_PLAY], s[S_PLAY + 1], s[S_PLAY + 2], s[S_PLAY + 3] = play
    s[S_ERROR] += missed
    s[S_WEIGHT] += certain
    s[S_ROWS] += 1.0
    if s[S_ROWS] < s[S_GROUP]:
        return
    if play[1] != 0.0:
        both, weight = 0.5 / s[S_GROUP], s[S_WEIGHT] / s[S_GROUP]
        _pair(both, True, room)
        e = both * (s[S_ERROR] + s[S_LAST])
        if s[S_PAIRED] > 0.0:
            s[S_GROUPS] += 1.0
            s[S_COST] += weight * (e * e)
            _add_group(FITTED, weight, e, room[2], normal, right)
        s[S_LAST], s[S_PAIRED] = s[S_ERROR], 1.0
    for p in range(N_SHAPE):
        room[0, p] = 0.0
    s[S_ROWS] = s[S_ERROR] = s[S_WEIGHT] = 0.0


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


class Regression(NamedTuple):
    """
    Least squares of the torque over one window, by Levenberg and Marquardt.

    law, data [N, N_DATA]: see normal_equations. weights, units [N // law.group]: of the groups,
    see there. prior: see Optimum. base [N_SHAPE]: what the parameters are changes of. low, high
    [N_SHAPE]: bounds of the parameters; beyond them is no step where `strict`, else the bound.
    residuals [N // law.group]: those of the last evaluation.
    """

    law: ElasticLaw
    data: Matrix
    weights: Vector
    units: Vector
    prior: Vector
    base: Vector
    low: Vector
    high: Vector
    residuals: Vector
    strict: bool

    @classmethod
    def of(cls, data: Array, law: ElasticLaw, weights: Array, strict: bool = False) -> Self:
        """Return one without priors, all units 1; `data`, `law`, `weights`, `strict`: as above."""
        low = np.full(N_SHAPE, -np.inf)
        low[[STIFFNESS, HALF_GAP]] = 0.0
        return cls(law, data, weights, np.ones(len(weights)), np.zeros(N_SHAPE), np.zeros(N_SHAPE),
                   low, np.full(N_SHAPE, np.inf), np.zeros(len(weights)), strict)

    def evaluate(self, theta: Array, free: Flags) -> tuple[float, Optimum]:
        """Return the cost and the linear problem at `theta` [N_SHAPE]; free: see Optimum."""
        count = len(self.weights) // self.law.block + 1
        blocks = normals, rights, _ = (np.zeros((count, N_SHAPE, N_SHAPE)),
                                       np.zeros((count, N_SHAPE)), np.zeros((3, N_SHAPE)))
        cost, contact = normal_equations(self.base + theta, free, self.law, self.data,
                                         self.weights, self.units, blocks, self.residuals)
        prior = np.where(free, self.prior, 0.0)
        return cost + float(prior @ theta ** 2), Optimum(
            theta, free, normals, rights, prior, contact)

    def solve(self, theta: Array, free: Flags, rule: Damping, tolerance: float,
              iterations: int) -> tuple[float, Optimum]:
        """
        Minimise the cost; `residuals` are those of the minimum.

        Args:
            theta: start [N_SHAPE].
            free: which parameters are fitted [N_SHAPE].
            rule: of the damping.
            tolerance: of the cost, for another step.
            iterations: at most.

        Returns:
            The cost at the minimum, and the linear problem there.

        """
        found, _, _ = minimise(_Problem(self, free), theta[None], rule, tolerance, iterations)
        # The residuals at hand may be those of a step that was not taken.
        return self.evaluate(found[0], free)


class _Problem(NamedTuple):
    """A `regression` of what is `free`, as `minimise` takes it."""

    regression: Regression
    free: Flags

    def evaluated(self, theta: Array, index: Integers) -> tuple[Array, Array]:
        """Move `theta` [1, N_SHAPE] into bounds; return normal matrix with right side, cost."""
        regression, x = self.regression, np.clip(theta[0], *self.regression[6:8])
        beyond = regression.strict and bool((x != theta[0])[self.free].any())
        theta[0] = x
        cost, optimum = regression.evaluate(x, self.free)
        right = optimum.rights.sum(axis=0) - optimum.prior * x
        return np.vstack([optimum.normal(), right])[None], np.array([math.inf if beyond else cost])

    def linearised(self, theta: Array, residual: Array, index: Integers) -> tuple[Array, Array]:
        """Return the normal matrix [1, N_SHAPE, N_SHAPE] and the right side [1, N_SHAPE]."""
        return residual[:, :N_SHAPE], residual[:, N_SHAPE]
