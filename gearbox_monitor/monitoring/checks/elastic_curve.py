# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Whether tau_K, which comes from the motor's torque, is what the elastic curve says of the twist.

Both encoders and the model's stiffness give the torque of the transmission a second time, and a
load on the arm, known or not, has no part in it. Over a window the difference of the two is fitted
with what may be wrong (linearised, Gauss-Newton with Huber weights and priors):

    tau_K = K' dz(twist - o - s x2 - d x4, b') + g u + dCv x3 + dCc (2/pi) atan(alpha x3) + e

K', b' and the zero o may differ from the model's: a gearbox wears, and that makes no estimate
wrong. g and the friction are errors of tau_K; scale s and delay d between the encoders are errors
of the twist; e is what no such error explains. Each counts where it is certain and exceeds the
stated deviations.

Where the filter estimates an error of the friction, that goes back into tau_K first: what motor
torque and motion show, in which a load by a robot's description has no part. No friction is wrong
then, so VISCOUS and COULOMB count as nothing; the motor's inertia may be off, too, and gain, scale
and delay count beyond the tolerances of the model file.

Some motions do not tell errors of tau_K from those of the twist: where inertia does not show, a
late encoder is viscous friction. Where neither is certain, each is asked for once more with the
other held to its tolerances in the model file: one of the two is wrong then.
"""
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from gearbox_monitor.estimation.process_model import UNIFORM
from gearbox_monitor.estimation.rts_smoother import (
    S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE,
    S_TWIST_RATE_NOISE_STD, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.monitoring.checks.outcome import Condition, Level
from gearbox_monitor.monitoring.checks.row_check import Result, RowCheck
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS

WINDOW, SHORTEST = 10.0, 4.0  # s; shares of it that must be there
MAX_ROWS = 500                # looked at
BLOCKS = 20                   # parts of a window that count as independent
CONTACT = 0.05                # share of the rows that a flank must hold
SIGMA = 3.0                   # stated standard deviations
SIGNIFICANCE = 1e-3           # of an error of torque or twist, by Student's t over its blocks
SHARE = 0.01                  # of the rows that may be beyond
OFTEN = float(stdtrit(BLOCKS - 1, 0.95))  # by Student's t: not in a block or two alone
HUBER, ITERATIONS, ENOUGH = 1.5, 12, 1e-3
STANDSTILL = 3.0              # deviations of the speed below which friction is uncertain
STANDSTILL_WEIGHT = 0.05
(ZERO, STIFFNESS, HALF_GAP, SCALE, DELAY, VISCOUS, COULOMB, GAIN, INERTIA,
 N_SHAPE) = range(10)
TORQUE, TWIST = [VISCOUS, COULOMB, GAIN], [SCALE, DELAY]
CURVE = [ZERO, STIFFNESS, HALF_GAP, SCALE, DELAY]
# Standard deviations that are expected before the window is seen: of stiffness and half gap
# relative to the model's, by wear; of the friction, too; scale; delay (s); gain. That of the
# motor's inertia is the model's tolerance.
WORN, FRICTION, SCALES, DELAYS, GAINS = (0.1, 0.5), 1.0, 0.5, 0.05, 1.0
LEAST = 1e-4  # standard deviation of what has no tolerance
_WINDOW = f'{WINDOW:g} s'

NO_CURVE = Condition(
    'prediction error', Level.WARN, 'no elastic curve explains the torque',
    f'share of the smoothed tau_K that is more than {SIGMA:g} stated standard deviations off '
    f'the best elastic curve, gain, friction, scale and delay, in more than single moments, '
    f'> {SHARE:g}', _WINDOW,
    'check sign, limits and delay of the effort and the signs and order of the encoders',
    ('elastic_misfit_share',), ('elastic_misfit_share_threshold',))
OTHER_TORQUE = Condition(
    'prediction error', Level.WARN, 'torque disagrees with the twist',
    f'share of the smoothed tau_K whose error by gain and friction, as the twist shows it, '
    f'is more than {SIGMA:g} stated standard deviations, and certain, > {SHARE:g}', _WINDOW,
    'check scale of the effort, time stamps and friction of the model; then its stiffness',
    ('elastic_torque_share', 'elastic_gain', 'elastic_viscous', 'elastic_coulomb'),
    ('elastic_torque_share_threshold',))
OTHER_TWIST = Condition(
    'prediction error', Level.WARN, 'encoders disagree',
    f'share of the smoothed twist whose error by scale and delay between the encoders is more '
    f'than {SIGMA:g} stated standard deviations, and certain, > {SHARE:g}', _WINDOW,
    'check gear_ratio, scale and delay of both encoders',
    ('elastic_twist_share', 'elastic_scale', 'elastic_delay_s'),
    ('elastic_twist_share_threshold',))
CONDITIONS = (NO_CURVE, OTHER_TORQUE, OTHER_TWIST)


class _Fit(NamedTuple):
    """
    Parameters [N_SHAPE] and covariance, rows in contact, and the linear problem at its optimum.

    slopes: over theta, in stated deviations [N, N_SHAPE]; weights [N]; residuals [N].
    """

    theta: Array
    covariance: Array
    contact: Flags
    slopes: Array
    weights: Array
    residuals: Array


def _curve(rows: Array, drive: DriveModel, theta: Array) -> tuple[Array, Array, Flags]:
    """Return tau_K by the curve [N], its slopes [N, N_SHAPE] over `theta`, rows in contact."""
    shape = drive.transmission
    k, b = shape.stiffness + theta[STIFFNESS], shape.half_gap + theta[HALF_GAP]
    twist = (rows[:, S_TWIST] - theta[ZERO] - theta[SCALE] * rows[:, S_X2]
             - theta[DELAY] * rows[:, S_X4])
    load = np.sign(twist) * np.maximum(np.abs(twist) - b, 0.0)
    contact = load != 0.0
    slopes = np.zeros((len(rows), N_SHAPE))
    slopes[:, ZERO] = -k * contact
    slopes[:, SCALE], slopes[:, DELAY] = (slopes[:, ZERO] * rows[:, i] for i in (S_X2, S_X4))
    slopes[:, STIFFNESS], slopes[:, HALF_GAP] = load, slopes[:, ZERO] * np.sign(twist)
    slopes[:, VISCOUS], slopes[:, GAIN] = rows[:, S_X3], rows[:, S_U]
    slopes[:, COULOMB] = drive.friction_side(rows[:, S_X3])
    torque = k * load + slopes[:, TORQUE] @ theta[TORQUE]
    if _friction_estimated(rows):  # M1 x3', by the curve: tau_K itself would explain itself
        accelerating = (
            rows[:, S_U] - k * load - drive.damping * rows[:, S_TWIST_RATE]
            - drive.viscous_friction * rows[:, S_X3] - drive.coulomb_friction * slopes[:, COULOMB])
        slopes[:, CURVE] *= 1.0 - theta[INERTIA]
        slopes[:, INERTIA] = accelerating
        torque = torque + theta[INERTIA] * accelerating
    return torque, slopes, contact


def _friction_estimated(rows: Array) -> bool:
    """Return whether an error of the friction is a state of the filter."""
    return bool((rows[:, S_MOTOR_SIDE] != rows[:, S_TAU_K]).any())


def _prior(drive: DriveModel) -> Array:
    """Return 1 / variance [N_SHAPE] of what is expected of the parameters."""
    shape, tolerance = drive.transmission, drive.tolerance
    std = np.empty(N_SHAPE)
    std[ZERO] = np.inf
    std[STIFFNESS] = np.hypot(WORN[0], tolerance) * shape.stiffness
    std[HALF_GAP] = max(WORN[1] * shape.half_gap, 1e-3)
    std[SCALE], std[DELAY], std[GAIN] = SCALES, DELAYS, GAINS
    std[VISCOUS] = max(FRICTION * abs(drive.viscous_friction), 1e-2)
    std[COULOMB] = max(FRICTION * drive.coulomb_friction, 1e-2)
    std[INERTIA] = max(UNIFORM * drive.inertia_tolerance, LEAST)
    return 1.0 / std ** 2


def _within_tolerances(drive: DriveModel, at: list[int]) -> Array:
    """Return _prior, but with the parameters `at` held to the tolerances of the model."""
    std = np.empty(N_SHAPE)
    std[VISCOUS] = UNIFORM * drive.damping_tolerance * abs(drive.viscous_friction)
    std[COULOMB] = UNIFORM * drive.friction_tolerance * drive.coulomb_friction
    std[GAIN] = UNIFORM * drive.torque_gain_tolerance
    std[DELAY], std[SCALE] = UNIFORM * drive.encoder_delay_tolerance, LEAST
    result = _prior(drive)
    result[at] = 1.0 / np.maximum(std[at], LEAST) ** 2
    return result


def _fit(rows: Array, drive: DriveModel) -> _Fit:
    """Return the robust fit of the curve by Levenberg and Marquardt."""
    stds, prior = rows[:, S_MOTOR_SIDE_NOISE_STD], _prior(drive)
    base = _weights(rows, drive)

    def errors(theta: Array) -> tuple[Array, Array, Flags, float]:
        """Return residuals and slopes in stated deviations, contact, and the cost at `theta`."""
        torque, slopes, contact = _curve(rows, drive, theta)
        e = (rows[:, S_MOTOR_SIDE] - torque) / stds
        size = np.abs(e)
        cost = base @ np.where(size < HUBER, e * e, HUBER * (2.0 * size - HUBER))
        return e, slopes / stds[:, None], contact, float(cost + prior @ theta ** 2)

    theta = _start(rows, drive, base, prior)
    e, a, contact, cost = errors(theta)
    damping = 1e-3
    for _ in range(ITERATIONS):
        weighted = a * (base / np.maximum(1.0, np.abs(e) / HUBER))[:, None]
        normal = weighted.T @ a + np.diag(prior)
        damped = normal + np.diag(damping * np.diag(normal) + 1e-12)
        step = theta + np.linalg.solve(damped, weighted.T @ e - prior * theta)
        shape = drive.transmission
        if shape.stiffness + step[STIFFNESS] > 0.0 and shape.half_gap + step[HALF_GAP] >= 0.0:
            e_new, a_new, contact_new, cost_new = errors(step)
            if cost_new < cost:
                done = cost - cost_new < ENOUGH * cost
                theta, e, a, contact, cost = step, e_new, a_new, contact_new, cost_new
                damping *= 0.1
                if done:
                    break
                continue
        damping *= 10.0
    weights = base / np.maximum(1.0, np.abs(e) / HUBER)
    return _Fit(theta, _covariance(a, weights, e, prior), contact, a, weights, e)


def _covariance(slopes: Array, weights: Array, residuals: Array, prior: Array) -> Array:
    """
    Return the covariance of a weighted fit, blocks of rows taken as independent (sandwich).

    Args:
        slopes: [N, N_SHAPE].
        weights: [N].
        residuals: [N].
        prior: 1 / variance of the parameters [N_SHAPE].

    """
    weighted = slopes * weights[:, None]
    inverse = np.linalg.pinv(weighted.T @ slopes + np.diag(prior), 1e-12)
    length = max(1, len(residuals) // BLOCKS)  # neighbours err alike
    scores = (weighted * residuals[:, None])[:length * BLOCKS].reshape(
        BLOCKS, length, -1).sum(axis=1)
    covariance: Array = inverse @ (scores.T @ scores + np.diag(prior)) @ inverse
    return covariance


def _held(fit: _Fit, prior: Array) -> _Fit:
    """Return `fit` with another `prior` [N_SHAPE], by its linear problem."""
    weighted = fit.slopes * fit.weights[:, None]
    normal = weighted.T @ fit.slopes
    right = weighted.T @ fit.residuals + normal @ fit.theta
    theta = np.linalg.pinv(normal + np.diag(prior), 1e-12) @ right
    residuals = fit.residuals + fit.slopes @ (fit.theta - theta)
    return fit._replace(theta=theta, residuals=residuals, covariance=_covariance(
        fit.slopes, fit.weights, residuals, prior))


def _start(rows: Array, drive: DriveModel, base: Array, prior: Array) -> Array:
    """
    Return parameters [N_SHAPE] to start from: zero of the twist by a grid, errors of torque.

    Args:
        rows: [N, N_SMOOTHED].
        drive: of the filter.
        base: weights [N].
        prior: 1 / variance of the parameters [N_SHAPE].

    """
    shape, torque, stds = (drive.transmission, rows[:, S_MOTOR_SIDE],
                           rows[:, S_MOTOR_SIDE_NOISE_STD])
    middle = np.median(rows[:, S_TWIST] - torque / shape.stiffness)
    best, least = np.zeros(N_SHAPE), np.inf
    for zero in (0.0, *(middle + 1.5 * shape.half_gap * np.linspace(-1.0, 1.0, 13))):
        theta = np.zeros(N_SHAPE)
        theta[ZERO] = zero
        curve, slopes, _ = _curve(rows, drive, theta)
        columns, e = slopes[:, TORQUE] / stds[:, None], (torque - curve) / stds
        for free in (False, True):
            if free:
                weighted = columns * (base / np.maximum(1.0, np.abs(e) / HUBER))[:, None]
                theta[TORQUE] = np.linalg.solve(
                    weighted.T @ columns + np.diag(prior[TORQUE]), weighted.T @ e)
                e = e - columns @ theta[TORQUE]
            cost = float(base @ np.minimum(np.abs(e), SIGMA) + prior @ theta ** 2)
            if cost < least:
                best, least = theta.copy(), cost
    return best


def _weights(rows: Array, drive: DriveModel) -> Array:
    """Return weights [N] that fall where the speed may be 0, and friction anything."""
    if drive.coulomb_friction == 0.0:
        return np.ones(len(rows))
    doubt = STANDSTILL * float(np.median(rows[:, S_TWIST_RATE_NOISE_STD]))
    ratio = (rows[:, S_X3] / max(doubt, 1e-12)) ** 2
    return STANDSTILL_WEIGHT + ratio / (1.0 + ratio)


def _share_beyond(columns: Array, stds: Array, fit: _Fit, at: list[int]) -> float:
    """
    Return the share of the rows at which an error is beyond SIGMA stated deviations, and certain.

    Args:
        columns: [N, A] what the parameters `at` multiply.
        stds: stated standard deviations [N].
        fit: of the window.
        at: places of the A parameters.

    """
    error = np.abs(columns @ fit.theta[at])
    variance = ((columns @ fit.covariance[np.ix_(at, at)]) * columns).sum(axis=1)
    certain = float(-stdtrit(_moving_blocks(columns), SIGNIFICANCE / 2))
    return float(np.mean((error > SIGMA * stds) & (error ** 2 > certain ** 2 * variance)))


def _moving_blocks(columns: Array) -> float:
    """Return how many blocks count, by how `columns` [N, A] vary in them: a rest tells nothing."""
    length = len(columns) // BLOCKS
    blocks = (columns / np.maximum(columns.std(axis=0), 1e-300))[:length * BLOCKS].reshape(
        BLOCKS, length, -1)
    moved = blocks.var(axis=1).sum(axis=1)
    return float(max(moved.sum() ** 2 / max((moved ** 2).sum(), 1e-300), 1.0))


def _lasting_share(beyond: Flags) -> float:
    """Return the lower confidence bound of the share of rows `beyond` [N], from its blocks."""
    length = len(beyond) // BLOCKS
    shares = beyond[:length * BLOCKS].reshape(BLOCKS, length).mean(axis=1)
    return float(max(shares.mean() - OFTEN * shares.std(ddof=1) / BLOCKS ** 0.5, 0.0))


def check(rows: Array, drive: DriveModel) -> Result:
    """
    Return the Result of `rows` [N, N_SMOOTHED] against the elastic curve of `drive`.

    None where no flank is in contact, or where the curve has effects that the filter leaves out.
    """
    drive = drive.folded()
    rows = rows[::max(1, len(rows) // MAX_ROWS)]
    if len(rows) < MAX_ROWS * SHORTEST / WINDOW or not np.isfinite(rows).all() or any(
            EFFECTS[e['id']].location == 'transmission' for e in drive.effects
            if e['id'] in EFFECTS):
        return None
    fit = _fit(rows, drive)
    if fit.contact.mean() < CONTACT:
        return None
    torque, twist = (rows[:, i] for i in (S_MOTOR_SIDE_NOISE_STD, S_TWIST_NOISE_STD))
    of_twist = rows[:, [S_X2, S_X4]] - np.median(rows[:, [S_X2, S_X4]], axis=0)
    wrong = TORQUE
    if _friction_estimated(rows):
        wrong, precision = [GAIN], _within_tolerances(drive, TORQUE + TWIST)
        torque = np.sqrt(torque ** 2 + rows[:, S_U] ** 2 / precision[GAIN])
        twist = np.sqrt(twist ** 2 + (of_twist ** 2) @ (1.0 / precision[TWIST]))
    of_torque = fit.slopes[:, wrong] * rows[:, [S_MOTOR_SIDE_NOISE_STD]]
    shares = {
        'misfit': _lasting_share(np.abs(fit.residuals) > SIGMA),
        'torque': _share_beyond(of_torque, torque, fit, wrong),
        'twist': _share_beyond(of_twist, twist, fit, TWIST)}
    if not max(shares.values()) > SHARE:
        shares['torque'] = _share_beyond(
            of_torque, torque, _held(fit, _within_tolerances(drive, TWIST)), wrong)
        shares['twist'] = _share_beyond(
            of_twist, twist, _held(fit, _within_tolerances(drive, TORQUE)), TWIST)
    values = {f'elastic_{name}_share': share for name, share in shares.items()}
    values |= {f'elastic_{name}_share_threshold': SHARE for name in shares}
    values |= {'elastic_gain': float(fit.theta[GAIN]), 'elastic_scale': float(fit.theta[SCALE]),
               'elastic_delay_s': float(fit.theta[DELAY]),
               'elastic_viscous': float(fit.theta[VISCOUS]),
               'elastic_coulomb': float(fit.theta[COULOMB])}
    broken = [condition for condition, name in (
        (NO_CURVE, 'misfit'), (OTHER_TORQUE, 'torque'), (OTHER_TWIST, 'twist'))
        if shares[name] > SHARE]
    return broken, values


CHECK = RowCheck('elastic', WINDOW, check, down=1)
