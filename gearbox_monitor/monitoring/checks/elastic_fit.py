# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The least squares behind elastic_curve: Levenberg and Marquardt, Huber weights, priors.

The play of a transmission with hysteresis follows the twist behind it: its memory was left by the
last row that carried it along, and so were the memory's slopes.
"""
import math
from typing import NamedTuple

import numpy as np
import scipy

from gearbox_monitor.kernels.jit import jit, jit_allocating, jit_inline
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.monitoring.alert_limits import LIMITS
from gearbox_monitor.monitoring.checks.row_check import middle
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.transmission import dead_zone

(ZERO, STIFFNESS, HALF_GAP, WIDTH, SCALE, DELAY, VISCOUS, COULOMB, GAIN, INERTIA,
 N_SHAPE) = range(11)
TORQUE, TWIST = [VISCOUS, COULOMB, GAIN], [SCALE, DELAY]
FIRST, LAST = VISCOUS, GAIN + 1  # of TORQUE
# Rows of the data that are fitted: smoothed values, the share of Coulomb friction that acts, the
# torque to explain and its stated deviation.
(D_TWIST, D_RATE, D_X2, D_X4, D_X3, D_FRICTION, D_U, D_TORQUE, D_STD, N_DATA) = range(10)
BLOCKS = 20                   # parts of a window that count as independent
SIGMA = LIMITS.curve_sigma
OFTEN = float(scipy.special.stdtrit(BLOCKS - 1, LIMITS.curve_often))  # not in a block or two
HUBER, ITERATIONS, ENOUGH = LIMITS.huber, 12, 1e-3
ZEROS = 13                    # of the grid that the fit starts from
ROUNDING, TINY = 1e-12, 1e-300


class ElasticLaw(NamedTuple):
    """
    The elastic curve that theta changes.

    stiffness, half_gap, width, hysteresis_stiffness: of the transmission. lower: 1 of a play whose
    lower branch acts while the twist grows, else 0. side: which end carried the play to the first
    row. friction: viscous, Coulomb and damping of the model where the motor's inertia is fitted.
    with_inertia: whether it is.
    """

    stiffness: float
    half_gap: float
    width: float
    hysteresis_stiffness: float
    lower: float
    side: float
    friction: tuple[float, float, float]
    with_inertia: bool


class CurveFit(NamedTuple):
    """
    Parameters and covariance, share of the rows in contact, and the linear problem at the optimum.

    theta [N_SHAPE]; covariance [N_SHAPE, N_SHAPE]; slopes: over theta, in stated deviations
    [N, N_SHAPE]; weights [N]; residuals [N].
    """

    theta: Array
    covariance: Array
    contact: float
    slopes: Array
    weights: Array
    residuals: Array


def play_width(drive: DriveModel) -> float:
    """Return half the width of the play in the transmission of `drive`, rad; 0 without one."""
    shape = drive.transmission
    return shape.hysteresis_width if shape.kind in ('play', 'passive_play') else 0.0


def law_of(drive: DriveModel, side: float, with_inertia: bool) -> ElasticLaw:
    """
    Return the ElasticLaw of a drive.

    Args:
        drive: of the filter.
        side: which end carried the play to the first row, 1 or -1.
        with_inertia: whether an error of the motor's inertia is fitted.

    """
    shape = drive.transmission
    return ElasticLaw(shape.stiffness, shape.half_gap, play_width(drive),
               shape.hysteresis_stiffness if shape.kind == 'passive_play' else 0.0,
               1.0 if shape.kind == 'play' else 0.0, side,
               (drive.viscous_friction, drive.coulomb_friction, drive.damping), with_inertia)


@jit_inline
def _carried(twist: float, memory: float, width: float, side: float) -> tuple[bool, float]:
    """Return whether `twist` carries a play along, and by which end: `side` if it does not."""
    if twist - memory >= width:
        return True, 1.0
    if memory - twist >= width:
        return True, -1.0
    return False, side


@jit
def curve(theta: Array, data: Array, law: ElasticLaw, torque: Array, slopes: Array) -> float:
    """
    Write the torque by the curve and the errors `theta`; return the share of rows in contact.

    Args:
        theta: [N_SHAPE].
        data: [N, N_DATA].
        law: of the transmission.
        torque: written [N], N m.
        slopes: of it over theta, written [N, N_SHAPE].

    """
    n, contacts = data.shape[0], 0
    k, b, width = (law.stiffness + theta[STIFFNESS], law.half_gap + theta[HALF_GAP],
                   law.width + theta[WIDTH])
    memory, side, x2_carried, x4_carried = 0.0, law.side, data[0, D_X2], data[0, D_X4]
    for i in range(n):
        x2, x4, x3, u, friction = (data[i, D_X2], data[i, D_X4], data[i, D_X3], data[i, D_U],
                                   data[i, D_FRICTION])
        twist = data[i, D_TWIST] - theta[ZERO] - theta[SCALE] * x2 - theta[DELAY] * x4
        if i == 0:
            memory = twist - side * width
        carried, side = _carried(twist, memory, width, side)
        if carried or i == 0:
            memory, x2_carried, x4_carried = twist - side * width, x2, x4
        stretch = twist - memory
        load = dead_zone(twist - law.lower * stretch, b)
        sign = 1.0 if load > 0.0 else (-1.0 if load < 0.0 else 0.0)
        if load != 0.0:
            contacts += 1
        slope = k * abs(sign)
        of_stretch = law.hysteresis_stiffness - law.lower * slope
        elastic = k * load + law.hysteresis_stiffness * stretch
        slopes[i, ZERO], slopes[i, STIFFNESS], slopes[i, HALF_GAP] = -slope, load, -k * sign
        slopes[i, WIDTH] = of_stretch * side if law.width > 0.0 else 0.0
        slopes[i, SCALE] = -slope * x2 - of_stretch * (x2 - x2_carried)
        slopes[i, DELAY] = -slope * x4 - of_stretch * (x4 - x4_carried)
        slopes[i, VISCOUS], slopes[i, COULOMB], slopes[i, GAIN] = x3, friction, u
        slopes[i, INERTIA] = 0.0
        torque[i] = elastic + theta[VISCOUS] * x3 + theta[COULOMB] * friction + theta[GAIN] * u
        if law.with_inertia:  # M1 x3', by the curve: tau_K itself would explain itself
            viscous, coulomb, damping = law.friction
            slopes[i, INERTIA] = (
                u - elastic - damping * data[i, D_RATE] - viscous * x3 - coulomb * friction)
            torque[i] += theta[INERTIA] * slopes[i, INERTIA]
            for p in range(FIRST):
                slopes[i, p] *= 1.0 - theta[INERTIA]
    return contacts / n


@jit
def _errors(theta: Array, data: Array, law: ElasticLaw, base: Array, prior: Array, e: Array,
            slopes: Array) -> tuple[float, float]:
    """
    Write residuals `e` [N] and slopes [N, N_SHAPE] in stated deviations.

    base, prior: see fit. Returns the share of rows in contact and Huber's cost.
    """
    contact, cost = curve(theta, data, law, e, slopes), 0.0
    for i in range(data.shape[0]):
        e[i] = (data[i, D_TORQUE] - e[i]) / data[i, D_STD]
        for p in range(N_SHAPE):
            slopes[i, p] /= data[i, D_STD]
        size = abs(e[i])
        cost += base[i] * (size * size if size < HUBER else HUBER * (2.0 * size - HUBER))
    for p in range(N_SHAPE):
        cost += prior[p] * theta[p] * theta[p]
    return contact, cost


@jit
def _normal(slopes: Array, weights: Array, prior: Array, normal: Array) -> None:
    """Write the normal matrix [P, P] of `slopes` [N, P], `weights` [N] and `prior` [P]."""
    size = slopes.shape[1]
    for p in range(size):
        for q in range(size):
            normal[p, q] = prior[p] if p == q else 0.0
    for i in range(slopes.shape[0]):
        for p in range(size):
            part = weights[i] * slopes[i, p]
            for q in range(p + 1):
                normal[p, q] += part * slopes[i, q]
    for p in range(size):
        for q in range(p):
            normal[q, p] = normal[p, q]


@jit_allocating
def _solved(matrix: Array, right: Array) -> Array:
    """
    Return matrix^-1 right, [P, M], of a symmetric positive semidefinite `matrix` [P, P].

    By Cholesky at unit diagonal, with a trace of rounding on it: what no row determines is 0.
    """
    size = matrix.shape[0]
    scale, factor, out = np.empty(size), np.empty((size, size)), np.empty_like(right)
    for p in range(size):
        scale[p] = 1.0 / math.sqrt(matrix[p, p]) if matrix[p, p] > 0.0 else 1.0
    for p in range(size):
        for q in range(p + 1):
            total = matrix[p, q] * scale[p] * scale[q] + (ROUNDING if p == q else 0.0)
            for k in range(q):
                total -= factor[p, k] * factor[q, k]
            factor[p, q] = (math.sqrt(max(total, ROUNDING)) if p == q else total / factor[q, q])
    for c in range(right.shape[1]):
        for p in range(size):
            total = right[p, c] * scale[p]
            for k in range(p):
                total -= factor[p, k] * out[k, c]
            out[p, c] = total / factor[p, p]
        for p in range(size - 1, -1, -1):
            total = out[p, c]
            for k in range(p + 1, size):
                total -= factor[k, p] * out[k, c]
            out[p, c] = total / factor[p, p]
        for p in range(size):
            out[p, c] *= scale[p]
    return out


@jit_allocating
def _start(data: Array, law: ElasticLaw, base: Array, prior: Array, centre: float) -> Array:
    """
    Return parameters [N_SHAPE] to start from: zero of the twist by a grid, errors of torque.

    Args:
        data: [N, N_DATA].
        law: of the transmission.
        base: weights [N].
        prior: 1 / variance of the parameters [N_SHAPE].
        centre: of the grid of zeros, rad.

    """
    n, reach = data.shape[0], 1.5 * (law.half_gap + law.width)
    chosen, lowest_cost = np.zeros(N_SHAPE), math.inf
    columns, weights, e, stretch = np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
    memory, side = data[0, D_TWIST] - law.side * law.width, law.side
    for i in range(n):
        twist = data[i, D_TWIST]
        carried, side = _carried(twist, memory, law.width, side)
        if carried:
            memory = twist - side * law.width
        stretch[i] = twist - memory
        columns[i, 0] = data[i, D_X3] / data[i, D_STD]
        columns[i, 1] = data[i, D_FRICTION] / data[i, D_STD]
        columns[i, 2] = data[i, D_U] / data[i, D_STD]
    normal, right = np.empty((3, 3)), np.empty((3, 1))
    for step in range(-1, ZEROS):
        zero = centre + reach * (2.0 * step / (ZEROS - 1.0) - 1.0) if step >= 0 else 0.0
        right[:] = 0.0
        cost = prior[ZERO] * zero * zero
        for i in range(n):
            torque = law.hysteresis_stiffness * stretch[i] + law.stiffness * dead_zone(
                data[i, D_TWIST] - zero - law.lower * stretch[i], law.half_gap)
            e[i] = (data[i, D_TORQUE] - torque) / data[i, D_STD]
            weights[i] = base[i] / max(1.0, abs(e[i]) / HUBER)
            cost += base[i] * min(abs(e[i]), SIGMA)
            for p in range(3):
                right[p, 0] += weights[i] * columns[i, p] * e[i]
        if cost < lowest_cost:
            lowest_cost = cost
            chosen[:] = 0.0
            chosen[ZERO] = zero
        _normal(columns, weights, prior[FIRST:LAST], normal)
        errors = _solved(normal, right)[:, 0]
        cost = prior[ZERO] * zero * zero
        for p in range(3):
            cost += prior[FIRST + p] * errors[p] * errors[p]
        for i in range(n):
            off = e[i]
            for p in range(3):
                off -= columns[i, p] * errors[p]
            cost += base[i] * min(abs(off), SIGMA)
        if cost < lowest_cost:
            lowest_cost = cost
            chosen[:] = 0.0
            chosen[ZERO] = zero
            for p in range(3):
                chosen[FIRST + p] = errors[p]
    return chosen


@jit_allocating
def _covariance(slopes: Array, weights: Array, residuals: Array, prior: Array) -> Array:
    """
    Return the covariance of a weighted fit, blocks of rows taken as independent (sandwich).

    Residuals scatter less than errors, by what the fit has taken up: G blocks with p parameters
    count as G - p (Cameron and Miller 2015), p without what priors hold.

    Args:
        slopes: [N, N_SHAPE].
        weights: [N].
        residuals: [N].
        prior: 1 / variance of the parameters [N_SHAPE].

    Returns:
        [N_SHAPE, N_SHAPE].

    """
    n, size = slopes.shape
    normal, scatter, score = np.empty((size, size)), np.zeros((size, size)), np.empty(size)
    _normal(slopes, weights, prior, normal)
    inverse, fitted = _solved(normal, np.eye(size)), float(size)
    for p in range(size):
        fitted -= inverse[p, p] * prior[p]
    length = max(1, n // BLOCKS)  # neighbours err alike
    for block in range(min(BLOCKS, n // length)):
        score[:] = 0.0
        for i in range(block * length, (block + 1) * length):
            for p in range(size):
                score[p] += weights[i] * residuals[i] * slopes[i, p]
        for p in range(size):
            for q in range(size):
                scatter[p, q] += score[p] * score[q] * BLOCKS / (BLOCKS - fitted)
    for p in range(size):
        scatter[p, p] += prior[p]
    half, covariance = np.zeros((size, size)), np.zeros((size, size))
    for p in range(size):
        for q in range(size):
            for k in range(size):
                half[p, q] += inverse[p, k] * scatter[k, q]
    for p in range(size):
        for q in range(size):
            for k in range(size):
                covariance[p, q] += half[p, k] * inverse[k, q]
    return covariance


@jit_allocating
def _fit(data: Array, law: ElasticLaw, base: Array, prior: Array, centre: float
         ) -> tuple[Array, Array, float, Array, Array, Array]:
    n, theta, damping = data.shape[0], _start(data, law, base, prior, centre), 1e-3
    slopes, tried = np.empty((n, N_SHAPE)), np.empty((n, N_SHAPE))
    e, e_tried, weights, step = np.empty(n), np.empty(n), np.empty(n), np.empty(N_SHAPE)
    normal, right = np.empty((N_SHAPE, N_SHAPE)), np.empty((N_SHAPE, 1))
    contact, cost = _errors(theta, data, law, base, prior, e, slopes)
    for _ in range(ITERATIONS):
        for p in range(N_SHAPE):
            right[p, 0] = -prior[p] * theta[p]
        for i in range(n):
            weights[i] = base[i] / max(1.0, abs(e[i]) / HUBER)
            for p in range(N_SHAPE):
                right[p, 0] += weights[i] * e[i] * slopes[i, p]
        _normal(slopes, weights, prior, normal)
        for p in range(N_SHAPE):
            normal[p, p] += damping * normal[p, p]
        change = _solved(normal, right)
        for p in range(N_SHAPE):
            step[p] = theta[p] + change[p, 0]
        if (law.stiffness + step[STIFFNESS] > 0.0 and law.half_gap + step[HALF_GAP] >= 0.0
                and law.width + step[WIDTH] >= 0.0):
            contact_new, cost_new = _errors(step, data, law, base, prior, e_tried, tried)
            if cost_new < cost:
                done = cost - cost_new < ENOUGH * cost
                theta[:] = step
                contact, cost = contact_new, cost_new
                e, e_tried, slopes, tried = e_tried, e, tried, slopes
                damping *= 0.1
                if done:
                    break
                continue
        damping *= 10.0
    for i in range(n):
        weights[i] = base[i] / max(1.0, abs(e[i]) / HUBER)
    covariance = _covariance(slopes, weights, e, prior)
    return theta, covariance, contact, slopes, weights, e


@jit_allocating
def _held(theta: Array, slopes: Array, weights: Array, residuals: Array,
          prior: Array) -> tuple[Array, Array, Array]:
    (n, size), off = slopes.shape, residuals.copy()
    normal, right = np.empty((size, size)), np.zeros((size, 1))
    for i in range(n):
        for p in range(size):
            off[i] += slopes[i, p] * theta[p]
        for p in range(size):
            right[p, 0] += weights[i] * slopes[i, p] * off[i]
    _normal(slopes, weights, prior, normal)
    new = _solved(normal, right)[:, 0].copy()
    for i in range(n):
        for p in range(size):
            off[i] -= slopes[i, p] * new[p]
    covariance = _covariance(slopes, weights, off, prior)
    return new, covariance, off


@jit
def _share_beyond(columns: Array, stds: Array, theta: Array, covariance: Array,
                  certain: float) -> float:
    count, n = columns.shape
    beyond = 0
    for k in range(n):
        error, variance = 0.0, 0.0
        for i in range(count):
            error += theta[i] * columns[i, k]
            for j in range(count):
                variance += covariance[i, j] * columns[i, k] * columns[j, k]
        size = abs(error)
        if size > SIGMA * stds[k] and size - stds[k] > certain * variance ** 0.5:
            beyond += 1
    return beyond / n


@jit_inline
def _variance(column: Array) -> float:
    total, squares = 0.0, 0.0
    for value in column:
        total += value - column[0]
        squares += (value - column[0]) * (value - column[0])
    return max(squares - total * total / len(column), 0.0) / len(column)


@jit
def _moving_blocks(columns: Array) -> float:
    """Return how many blocks count, by how `columns` [A, N] vary in them: a rest tells nothing."""
    length, total, squares = columns.shape[1] // BLOCKS, 0.0, 0.0
    for block in range(BLOCKS):
        moved = 0.0
        for i in range(columns.shape[0]):
            moved += _variance(columns[i, block * length:(block + 1) * length]) / max(
                _variance(columns[i]), TINY)
        total += moved
        squares += moved * moved
    return max(total * total / max(squares, TINY), 1.0)


def fit(data: Array, law: ElasticLaw, base: Array, prior: Array) -> CurveFit:
    """
    Return the robust fit of the curve by Levenberg and Marquardt.

    Args:
        data: [N, N_DATA].
        law: of the transmission.
        base: weights [N] of the rows.
        prior: 1 / variance of the parameters [N_SHAPE].

    """
    zero = middle(data[:, D_TWIST] - data[:, D_TORQUE] / law.stiffness)
    return CurveFit(*_fit(data, law, base, prior, zero))


def held(optimum: CurveFit, prior: Array) -> CurveFit:
    """Return the `optimum` with another `prior` [N_SHAPE], by its linear problem."""
    theta, covariance, residuals = _held(
        optimum.theta, optimum.slopes, optimum.weights, optimum.residuals, prior)
    return optimum._replace(theta=theta, covariance=covariance, residuals=residuals)


def share_beyond(columns: Array, stds: Array, optimum: CurveFit, at: list[int]) -> float:
    """
    Return the share of the rows at which an error is beyond SIGMA stated deviations, and certain.

    Certain is that it exceeds one of them: so much smoothing and a play that follows an uncertain
    twist leave on a healthy drive.

    Args:
        columns: what the parameters multiply [A, N].
        stds: stated standard deviations [N].
        optimum: of the window.
        at: places of the A parameters.

    """
    certain = float(-scipy.special.stdtrit(_moving_blocks(columns), LIMITS.curve_significance / 2))
    return _share_beyond(columns, stds, optimum.theta[at], optimum.covariance[at][:, at], certain)


def lasting_share(residuals: Array) -> float:
    """Return the lower confidence bound of the share of `residuals` [N] beyond SIGMA."""
    length = len(residuals) // BLOCKS
    shares = (np.abs(residuals) > SIGMA)[:length * BLOCKS].reshape(BLOCKS, length).mean(axis=1)
    return float(max(shares.mean() - OFTEN * shares.std(ddof=1) / BLOCKS ** 0.5, 0.0))
