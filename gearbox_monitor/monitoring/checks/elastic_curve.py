# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether tau_K, which comes from the motor's torque, is what the elastic curve says of the twist.

Both encoders and the model's stiffness give the torque of the transmission a second time, and a
load on the arm, known or not, has no part in it. Over a window the difference of the two is fitted
with what may be wrong (linearised, Gauss-Newton with Huber weights and priors, see elastic_fit):

    tau_K = K' dz(y, b') + k_s (z - w) + g u + dCv x3 + dCc (2/pi) atan(alpha x3) + e
    z = twist - o - s x2 - d x4,  w = play of half width c' behind z

y is z, in a transmission of kind play w; c and k_s are 0 without hysteresis. K', b', c' and the
zero o may differ from the model's: a gearbox wears, and that makes no estimate wrong. g and the
friction are errors of tau_K; scale s and delay d between the encoders are errors of the twist; e
is what no such error explains. Each counts where it is certain and exceeds the stated deviations.

Where the filter estimates an error of the friction, that goes back into tau_K first: what motor
torque and motion show, in which a load by a robot's description has no part. No friction is wrong
then, so VISCOUS and COULOMB count as nothing; the motor's inertia may be off, too, and gain, scale
and delay count beyond the tolerances of the model file.

Some motions do not tell errors of tau_K from those of the twist: where inertia does not show, a
late encoder is viscous friction. Where neither is certain, each is asked for once more with the
other held to its tolerances in the model file: one of the two is wrong then.
"""
import numpy as np

from gearbox_monitor.estimation.process_model import UNIFORM
from gearbox_monitor.estimation.rts_smoother import (
    S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE,
    S_TWIST_RATE_NOISE_STD, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.monitoring.alert_limits import LIMITS
from gearbox_monitor.monitoring.checks import elastic_fit
from gearbox_monitor.monitoring.checks.elastic_fit import (
    COULOMB, D_FRICTION, D_U, D_X2, D_X3, D_X4, DELAY, GAIN, HALF_GAP, INERTIA, lasting_share,
    N_SHAPE, SCALE, share_beyond, SIGMA, STIFFNESS, TORQUE, TWIST, VISCOUS, WIDTH, ZERO)
from gearbox_monitor.monitoring.checks.outcome import Condition, Level
from gearbox_monitor.monitoring.checks.row_check import MAX_ROWS, middle, Result, RowCheck
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS

# Columns of the smoothed rows in the order of elastic_fit.D_*, but for D_FRICTION.
COLUMNS = (S_TWIST, S_TWIST_RATE, S_X2, S_X4, S_X3, S_X3, S_U, S_MOTOR_SIDE,
           S_MOTOR_SIDE_NOISE_STD)
COLUMN_OF = {VISCOUS: D_X3, COULOMB: D_FRICTION, GAIN: D_U}  # what errors of torque multiply
_WINDOW = f'{LIMITS.curve_window:g} s'

NO_CURVE = Condition(
    'prediction error', Level.WARN, 'no elastic curve explains the torque',
    f'share of the smoothed tau_K that is more than {SIGMA:g} stated standard deviations off '
    f'the best elastic curve, gain, friction, scale and delay, in more than single moments, '
    f'> {LIMITS.curve_share:g}', _WINDOW,
    'check sign, limits and delay of the effort and the signs and order of the encoders',
    ('elastic_misfit_share',), ('elastic_misfit_share_threshold',))
OTHER_TORQUE = Condition(
    'prediction error', Level.WARN, 'torque disagrees with the twist',
    f'share of the smoothed tau_K whose error by gain and friction, as the twist shows it, '
    f'is more than {SIGMA:g} stated standard deviations, and certain, > {LIMITS.curve_share:g}',
    _WINDOW,
    'check scale of the effort, time stamps and friction of the model; then its stiffness',
    ('elastic_torque_share', 'elastic_gain', 'elastic_viscous', 'elastic_coulomb'),
    ('elastic_torque_share_threshold',))
OTHER_TWIST = Condition(
    'prediction error', Level.WARN, 'encoders disagree',
    f'share of the smoothed twist whose error by scale and delay between the encoders is more '
    f'than {SIGMA:g} stated standard deviations, and certain, > {LIMITS.curve_share:g}', _WINDOW,
    'check gear_ratio, scale and delay of both encoders',
    ('elastic_twist_share', 'elastic_scale', 'elastic_delay_s'),
    ('elastic_twist_share_threshold',))
CONDITIONS = (NO_CURVE, OTHER_TORQUE, OTHER_TWIST)


def _friction_estimated(rows: Array) -> bool:
    """Return whether an error of the friction is a state of the filter."""
    return bool((rows[:, S_MOTOR_SIDE] != rows[:, S_TAU_K]).any())


def _prior(drive: DriveModel) -> Array:
    """Return 1 / variance [N_SHAPE] of what is expected of the parameters."""
    shape, tolerance = drive.transmission, drive.tolerance
    std = np.empty(N_SHAPE)
    std[ZERO] = np.inf
    std[STIFFNESS] = np.hypot(LIMITS.curve_stiffness, tolerance) * shape.stiffness
    std[HALF_GAP] = max(LIMITS.curve_gap * shape.half_gap, 1e-3)
    std[WIDTH] = max(LIMITS.curve_gap * shape.hysteresis_width, LIMITS.curve_fixed)
    std[SCALE], std[DELAY], std[GAIN] = LIMITS.curve_scale, LIMITS.curve_delay, LIMITS.curve_gain
    std[VISCOUS] = max(LIMITS.curve_friction * abs(drive.viscous_friction), 1e-2)
    std[COULOMB] = max(LIMITS.curve_friction * drive.coulomb_friction, 1e-2)
    std[INERTIA] = max(UNIFORM * drive.inertia_tolerance, LIMITS.curve_fixed)
    return 1.0 / std ** 2


def _within_tolerances(drive: DriveModel, at: list[int]) -> Array:
    """Return _prior, but with the parameters `at` held to the tolerances of the model."""
    std = np.empty(N_SHAPE)
    std[VISCOUS] = UNIFORM * drive.damping_tolerance * abs(drive.viscous_friction)
    std[COULOMB] = UNIFORM * drive.friction_tolerance * drive.coulomb_friction
    std[GAIN] = UNIFORM * drive.torque_gain_tolerance
    std[DELAY], std[SCALE] = UNIFORM * drive.encoder_delay_tolerance, LIMITS.curve_fixed
    result = _prior(drive)
    result[at] = 1.0 / np.maximum(std[at], LIMITS.curve_fixed) ** 2
    return result


def data_of(rows: Array, drive: DriveModel) -> Array:
    """Return the data [N, N_DATA] that elastic_fit takes of `rows` of a `drive`."""
    data: Array = rows[:, COLUMNS]
    data[:, D_FRICTION] = drive.friction_side(rows[:, S_X3])
    return data


def _remembered(twist: Array, drive: DriveModel) -> tuple[int, float]:
    """Return the first row of `twist` [N] at which the play is known, N if none, and its end."""
    high, low = np.maximum.accumulate(twist), np.minimum.accumulate(twist)
    carried = high - low >= 2.0 * elastic_fit.play_width(drive)
    first = int(np.argmax(carried)) if carried[-1] else len(twist)
    return first, 1.0 if first == len(twist) or twist[first] == high[first] else -1.0


def _weights(rows: Array, drive: DriveModel) -> Array:
    """Return weights [N] that fall where the speed may be 0, and friction anything."""
    if drive.coulomb_friction == 0.0:
        return np.ones(len(rows))
    doubt = LIMITS.standstill * middle(rows[:, S_TWIST_RATE_NOISE_STD])
    ratio = (rows[:, S_X3] / max(doubt, 1e-12)) ** 2
    return LIMITS.curve_standstill_weight + ratio / (1.0 + ratio)


def check(rows: Array, drive: DriveModel) -> Result:
    """
    Return the Result of `rows` [N, N_SMOOTHED] against the elastic curve of `drive`.

    None where no flank is in contact, or where the curve has effects that the filter leaves out.
    """
    drive = drive.folded()
    shortest = MAX_ROWS * LIMITS.curve_shortest / LIMITS.curve_window
    if len(rows) < shortest or not np.isfinite(rows).all() or any(
            EFFECTS[e['id']].location == 'transmission' for e in drive.effects
            if e['id'] in EFFECTS):
        return None
    first, side = _remembered(rows[:, S_TWIST], drive)
    rows = rows[first:]
    if len(rows) < shortest:
        return None
    friction_estimated = _friction_estimated(rows)
    data = data_of(rows, drive)
    fit = elastic_fit.fit(data, elastic_fit.law_of(drive, side, friction_estimated),
                          _weights(rows, drive), _prior(drive))
    if fit.contact < LIMITS.curve_contact:
        return None
    torque, twist = (np.ascontiguousarray(rows[:, i]) for i in (
        S_MOTOR_SIDE_NOISE_STD, S_TWIST_NOISE_STD))
    of_twist = np.stack([data[:, i] - middle(data[:, i]) for i in (D_X2, D_X4)])
    wrong = TORQUE
    if friction_estimated:
        wrong, precision = [GAIN], _within_tolerances(drive, TORQUE + TWIST)
        torque = np.sqrt(torque ** 2 + rows[:, S_U] ** 2 / precision[GAIN])
        twist = np.sqrt(twist ** 2 + (1.0 / precision[TWIST]) @ of_twist ** 2)
    of_torque = np.ascontiguousarray(data[:, [COLUMN_OF[i] for i in wrong]].T)
    shares = {'misfit': lasting_share(fit.residuals),
              'torque': share_beyond(of_torque, torque, fit, wrong),
              'twist': share_beyond(of_twist, twist, fit, TWIST)}
    by_tolerance = [elastic_fit.held(fit, _within_tolerances(drive, at)) for at in (TWIST, TORQUE)]
    if not max(shares.values()) > LIMITS.curve_share:
        shares['torque'] = share_beyond(of_torque, torque, by_tolerance[0], wrong)
        shares['twist'] = share_beyond(of_twist, twist, by_tolerance[1], TWIST)
    values = {f'elastic_{name}_share': share for name, share in shares.items()}
    values |= {f'elastic_{name}_share_threshold': LIMITS.curve_share for name in shares}
    values |= {'elastic_gain': float(fit.theta[GAIN]), 'elastic_scale': float(fit.theta[SCALE]),
               'elastic_delay_s': float(fit.theta[DELAY]),
               'elastic_viscous': float(fit.theta[VISCOUS]),
               'elastic_coulomb': float(fit.theta[COULOMB])}
    broken = [condition for condition, name in (
        (NO_CURVE, 'misfit'), (OTHER_TORQUE, 'torque'), (OTHER_TWIST, 'twist'))
        if shares[name] > LIMITS.curve_share]
    return broken, values


CHECK = RowCheck('elastic', LIMITS.curve_window, check, down=1, free_torque=True)
