# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Checks of smoothed torque and twist, which abstain where the motion does not show a result.

CURVE: whether tau_K, which comes from the motor's torque, is what the elastic curve says of the
twist.

Both encoders and the model's stiffness give the torque of the transmission a second time, and a
load on the arm, known or not, has no part in it. Over a window the difference of the two is fitted
with what may be wrong (robust, with priors, see elastic_regression):

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gearbox_monitor.estimation.process_model import UNIFORM
from gearbox_monitor.estimation.rts_smoother import (
    S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_TWIST_NOISE_STD,
    S_TWIST_RATE_NOISE_STD, S_U, S_X3, S_X4)
from gearbox_monitor.health.alarms import Condition, Level, LIMITS
from gearbox_monitor.health.elastic_regression import (
    BLOCKS, COLUMN_OF, COULOMB, D_TORQUE, D_TWIST, D_X2, D_X4, data_of, DELAY, ElasticLaw, GAIN,
    HALF_GAP, HEIGHT, INERTIA, N_SHAPE, Optimum, Regression, SCALE, STIFFNESS, VISCOUS, WIDTH,
    ZERO)
from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.linear_least_squares import Damping
from gearbox_monitor.kernels.types import Array, Values, Vector
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.presentation import Said

MAX_ROWS = 500  # of a window that are looked at: neighbours are alike

# What conditions that are broken say and {key: value}; None: the check abstains.
Result: TypeAlias = tuple[Sequence[Said], dict[str, float]] | None


@dataclass(frozen=True)
class RowCheck:
    """
    One check of the newest smoothed rows, registered in monitor.ROW_CHECKS.

    name: what the keys of its counters begin with; window: s of rows that it looks at; check:
    takes `thinned` rows [N, N_SMOOTHED] in order of time (columns rts_smoother.S_*) and the drive
    of the filter; conditions: that it can break, of `prediction error`; keys: of its values, with
    unit and meaning, see diagnostic_keys; down: results in a row that lower its level, 1 where the
    windows overlap by far; free_torque: whether it needs a tau_K that the filter does not take
    from the twist; earlier: how many windows before, of which it takes the values, too.
    """

    name: str
    window: float
    check: Callable[..., Result]
    conditions: tuple[Condition, ...] = ()
    keys: tuple[tuple[str, str, str], ...] = ()
    down: int = 5
    free_torque: bool = False
    earlier: int = 0


def thinned(rows: Array) -> Array:
    """Return MAX_ROWS, or up to twice as many, of the `rows` [N, M] of a window."""
    return rows[::max(1, len(rows) // MAX_ROWS)]


def middle(values: Array) -> float:
    """Return the median of `values` [N], the upper one of two."""
    at = len(values) // 2
    return float(np.partition(values, at)[at])


AGAINST = Condition(
    'against_twist', 'prediction error', Level.WARN,
    ('torque_twist_correlation', 'torque_twist_power'),
    ('torque_twist_correlation_threshold', 'torque_twist_power_threshold'))


def passivity(rows: Array, drive: DriveModel) -> Result:
    """
    Return whether torque and twist act like a transmission: it pushes back, and makes no power.

    A spring that is wound up at the beginning of a window gives back what it holds: that is no
    power made. An unknown load on the arm explains away what the prediction errors would tell: an
    encoder or a torque of wrong sign, a torque that is not what acts.

    Args:
        rows: [N, N_SMOOTHED].
        drive: of the filter.

    Returns:
        The Result; None if they do not show it.
    """
    if len(rows) < LIMITS.window_points:
        return None
    torque, twist, rate = rows[:, S_TAU_K], rows[:, S_TWIST], rows[:, S_X3] - rows[:, S_X4]
    moved = torque.std(), twist.std(), float(np.sqrt(np.mean(rate ** 2)))
    stds = S_TAU_K_NOISE_STD, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD
    if not all(size > LIMITS.deviations * middle(rows[:, std]) for size, std in zip(moved, stds)):
        return None
    correlation = float(np.mean((torque - torque.mean()) * (twist - twist.mean()))
                        / (moved[0] * moved[1]))
    steps = np.diff(twist)
    work = 0.5 * (torque[1:] + torque[:-1]) @ steps
    released = max(torque[0] ** 2 - torque[-1] ** 2, 0.0) / (
        2.0 * drive.folded().transmission.stiffness)
    power = float((work + released) / np.sqrt(np.mean(torque ** 2) * len(steps) * steps @ steps))
    values = {'torque_twist_correlation': correlation,
              'torque_twist_correlation_threshold': LIMITS.correlation,
              'torque_twist_power': power, 'torque_twist_power_threshold': LIMITS.power}
    against = correlation < LIMITS.correlation or power < LIMITS.power
    return [AGAINST.said()] if against else [], values


PASSIVITY = RowCheck('torque_twist', LIMITS.error_window, passivity, (AGAINST,), (
    ('torque_twist_correlation', '-', 'of smoothed torque and twist, 2 s'),
    ('torque_twist_correlation_threshold', '-', 'WARN below'),
    ('torque_twist_power', '-', 'mean of torque times twist rate, without what a spring gives '
     'back, over their rms'),
    ('torque_twist_power_threshold', '-', 'WARN below')))


BEYOND = Condition('twist_range', 'prediction error', Level.ERROR, ('twist_range',),
                   ('twist_range_threshold',))


def twist_range(rows: Array, drive: DriveModel) -> Result:
    """
    Return whether backlash and compliance of the model leave room for the twist that is measured.

    rows: [N, N_SMOOTHED]; drive: of the filter. None where they are too few. The zero of the
    encoders against each other does not matter: only the range of the twist does.
    """
    if len(rows) < LIMITS.window_points:
        return None
    shape = drive.folded().transmission
    torque = float(np.ptp(rows[:, S_TAU_K])
                   + 2.0 * LIMITS.deviations * middle(rows[:, S_TAU_K_NOISE_STD]))
    allowed = LIMITS.twist_room * (2.0 * (shape.half_gap + shape.hysteresis_width)
                                   + torque / shape.stiffness)
    twist = float(np.ptp(rows[:, S_TWIST]))
    return ([BEYOND.said()] if not twist <= allowed else [],
            {'twist_range': twist, 'twist_range_threshold': allowed})


TWIST_RANGE = RowCheck('twist_range', LIMITS.curve_window, twist_range, (BEYOND,), (
    ('twist_range', 'rad', 'range of the smoothed twist, 10 s'),
    ('twist_range_threshold', 'rad', 'ERROR above')), down=1)


TORQUE, TWIST = [VISCOUS, COULOMB, GAIN], [SCALE, DELAY]
ERRORS = {GAIN: 'elastic_gain', SCALE: 'elastic_scale', DELAY: 'elastic_delay_s',
          VISCOUS: 'elastic_viscous', COULOMB: 'elastic_coulomb'}  # as they are published
SIGMA = LIMITS.deviations
# Of Student's t, as scipy.special has it: it takes longer to load than all of this.
OFTEN = LIMITS.curve_often  # not in a block or two
RULE = Damping(1e-3, relative=1e-12)
ITERATIONS, ENOUGH = 12, 1e-3
ZEROS = 13  # of the grid that the fit starts from
TINY, ROUNDING = 1e-300, 1e-20

NO_CURVE = Condition('no_curve', 'prediction error', Level.WARN, ('elastic_misfit_share',),
                     ('elastic_misfit_share_threshold',))
OTHER_TORQUE = Condition(
    'other_torque', 'prediction error', Level.WARN,
    ('elastic_torque_share', 'elastic_gain', 'elastic_viscous', 'elastic_coulomb'),
    ('elastic_torque_share_threshold',))
OTHER_TWIST = Condition(
    'other_twist', 'prediction error', Level.WARN,
    ('elastic_twist_share', 'elastic_scale', 'elastic_delay_s'),
    ('elastic_twist_share_threshold',))


def _friction_estimated(rows: Array) -> bool:
    """Return whether an error of the friction is a state of the filter."""
    return bool((rows[:, S_MOTOR_SIDE] != rows[:, S_TAU_K]).any())


def _prior(drive: DriveModel) -> Array:
    """Return 1 / variance [N_SHAPE] of what is expected of the parameters."""
    shape, tolerance = drive.transmission, drive.tolerance
    std = np.full(N_SHAPE, np.inf)
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


def _play_width(drive: DriveModel) -> float:
    """Return half the width of the play in the transmission of `drive`, rad; 0 without one."""
    shape = drive.transmission
    return shape.hysteresis_width if shape.kind in ('play', 'passive_play') else 0.0


def _remembered(twist: Array, drive: DriveModel) -> tuple[int, float]:
    """Return the first row of `twist` [N] at which the play is known, N if none, and its end."""
    high, low = np.maximum.accumulate(twist), np.minimum.accumulate(twist)
    carried = high - low >= 2.0 * _play_width(drive)
    first = int(np.argmax(carried)) if carried[-1] else len(twist)
    return first, 1.0 if first == len(twist) or twist[first] == high[first] else -1.0


def _weights(rows: Array, drive: DriveModel) -> Array:
    """Return weights [N] that fall where the speed may be 0, and friction anything."""
    if drive.coulomb_friction == 0.0:
        return np.ones(len(rows))
    doubt = LIMITS.deviations * middle(rows[:, S_TWIST_RATE_NOISE_STD])
    ratio = (rows[:, S_X3] / max(doubt, 1e-12)) ** 2
    return LIMITS.curve_standstill_weight + ratio / (1.0 + ratio)


def _fitted(data: Array, rows: Array, drive: DriveModel, side: float, with_inertia: bool
            ) -> tuple[Optimum, Array]:
    """
    Return the Optimum of a window, and its residuals [N] in stated deviations.

    Args:
        data: of `rows` [N, N_DATA].
        rows: [N, N_SMOOTHED].
        drive: of the filter.
        side: which end carried the play to the first row, 1 or -1.
        with_inertia: whether an error of the motor's inertia is fitted.

    """
    shape, width = drive.transmission, _play_width(drive)
    friction = drive.viscous_friction, drive.coulomb_friction, drive.damping
    fit = Regression.of(data, ElasticLaw(
        passive=shape.kind != 'play', side=side, friction=friction, block=len(data) // BLOCKS,
        huber=LIMITS.huber), _weights(rows, drive), strict=True)
    fit.units[:], fit.prior[:] = 1.0 / rows[:, S_MOTOR_SIDE_NOISE_STD], _prior(drive)
    at = [STIFFNESS, HALF_GAP, WIDTH]
    fit.base[at] = shape.stiffness, shape.half_gap, width
    fit.base[HEIGHT] = shape.hysteresis_stiffness if shape.kind == 'passive_play' else 0.0
    fit.low[at] = -fit.base[at]
    free = np.ones(N_SHAPE, bool)
    free[HEIGHT], free[WIDTH], free[INERTIA] = False, width > 0.0, with_inertia
    start = _start(fit, middle(data[:, D_TWIST] - data[:, D_TORQUE] / shape.stiffness))
    return fit.solve(start, free, RULE, ENOUGH, ITERATIONS)[1], fit.residuals


def _start(fit: Regression, centre: float) -> Array:
    """Return parameters [N_SHAPE] to start `fit` from: a zero about `centre`, errors of torque."""
    k, b, width, spring = fit.base[[STIFFNESS, HALF_GAP, WIDTH, HEIGHT]]
    data, weights, prior = fit.data, fit.weights, fit.prior[TORQUE]
    stretch = np.zeros(len(data))
    if width > 0.0:
        _stretches(data[:, D_TWIST], width, fit.law.side, stretch)
    zeros = np.append(0.0, centre + 1.5 * (b + width) * (
        2.0 * np.arange(ZEROS) / (ZEROS - 1.0) - 1.0))
    twist = data[:, D_TWIST] - zeros[:, None] - (0.0 if fit.law.passive else stretch)
    e = (data[:, D_TORQUE] - spring * stretch - k * (twist - np.clip(twist, -b, b))) * fit.units
    columns = data[:, [COLUMN_OF[i] for i in TORQUE]] * fit.units[:, None]
    robust = weights / np.maximum(1.0, np.abs(e) / LIMITS.huber)  # [ZEROS + 1, N]
    normal = columns.T @ (robust[:, :, None] * columns) + np.diag(prior)
    errors = np.linalg.solve(normal, ((robust * e) @ columns)[:, :, None])[:, :, 0]
    costs = np.stack([np.minimum(np.abs(e), SIGMA) @ weights, errors ** 2 @ prior + np.minimum(
        np.abs(e - errors @ columns.T), SIGMA) @ weights], axis=1)
    at, with_errors = divmod(int(np.argmin(costs)), 2)
    theta = np.zeros(N_SHAPE)
    theta[ZERO] = zeros[at]
    theta[TORQUE] = errors[at] * with_errors
    return theta


@entry
def _stretches(twist: Vector, width: float, side: float, stretch: Vector) -> None:
    """Write by how much `twist` [N] leads the play behind it, `side` the end that carried it."""
    memory = twist[0] - side * width
    for i in range(len(twist)):
        memory = min(max(memory, twist[i] - width), twist[i] + width)
        stretch[i] = twist[i] - memory


def _lasting_share(residuals: Array) -> float:
    """Return the lower confidence bound of the share of `residuals` [N] beyond SIGMA."""
    length = len(residuals) // BLOCKS
    shares = (np.abs(residuals) > SIGMA)[:length * BLOCKS].reshape(BLOCKS, length).mean(axis=1)
    return float(max(shares.mean() - OFTEN * shares.std(ddof=1) / BLOCKS ** 0.5, 0.0))


def _share_beyond(columns: Array, stds: Array, optimum: Optimum, at: list[int], noise: float,
                  earlier: Array) -> float:
    """
    Return the share of the rows that a certain error puts beyond SIGMA stated deviations.

    Certain is that it exceeds one of them: so much smoothing and a play that follows an uncertain
    twist leave on a healthy drive. Slow motion shows that only over several windows, by how little
    they differ. What noise adds to the error counts, too.

    Args:
        columns: what the parameters multiply [A, N].
        stds: stated standard deviations [N].
        optimum: of the window.
        at: places of the A parameters.
        noise: of the rows, in stated deviations.
        earlier: parameters of the windows before [K, N_SHAPE].

    """
    import scipy
    size = np.abs(optimum.theta[at] @ columns)
    if not (size > stds).any():
        return 0.0
    covariance = optimum.covariance(held=True)[np.ix_(at, at)]
    std = np.sqrt(np.maximum(((covariance @ columns) * columns).sum(axis=0), 0.0))
    certain = [(size, std, _moving_blocks(columns))]
    if len(earlier) >= LIMITS.curve_earlier:
        errors = np.vstack([optimum.theta, earlier])[:, at] @ columns
        certain.append((np.abs(errors.mean(axis=0)), errors.std(axis=0, ddof=1)
                        / len(errors) ** 0.5, len(earlier)))
    beyond = scipy.special.ndtr((size - SIGMA * stds) / np.hypot(noise * stds, std))
    return max(float((beyond * (error - stds > -scipy.special.stdtrit(
        dof, LIMITS.curve_significance / 2) * error_std)).mean())
        for error, error_std, dof in certain)


def _moving_blocks(columns: Array) -> float:
    """Return how many blocks count, by how `columns` [A, N] vary in them: a rest tells nothing."""
    length = columns.shape[1] // BLOCKS
    blocks = columns[:, :length * BLOCKS].reshape(len(columns), BLOCKS, length)
    least = ROUNDING * (columns ** 2).mean(axis=1) + TINY  # a constant tells nothing, either
    moved = (blocks.var(axis=2) / np.maximum(columns.var(axis=1), least)[:, None]).sum(axis=0)
    return max(float(moved.sum()) ** 2 / max(float(moved @ moved), TINY), 1.0)


def check(rows: Array, drive: DriveModel, earlier: Sequence[Values] = ()) -> Result:
    """
    Return the Result of `rows` [N, N_SMOOTHED] against the elastic curve of `drive`.

    None where no flank is in contact, or where the curve has effects that the filter leaves out.
    earlier: values of the windows before.
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
    optimum, residuals = _fitted(data, rows, drive, side, friction_estimated)
    if optimum.contact < LIMITS.curve_contact:
        return None
    torque, twist = rows[:, S_MOTOR_SIDE_NOISE_STD], rows[:, S_TWIST_NOISE_STD]
    of_twist = np.stack([data[:, i] - middle(data[:, i]) for i in (D_X2, D_X4)])
    wrong = TORQUE
    if friction_estimated:
        wrong, precision = [GAIN], _within_tolerances(drive, TORQUE + TWIST)
        torque = np.sqrt(torque ** 2 + rows[:, S_U] ** 2 / precision[GAIN])
        twist = np.sqrt(twist ** 2 + (1.0 / precision[TWIST]) @ of_twist ** 2)
    of_torque = data[:, [COLUMN_OF[i] for i in wrong]].T
    noise, before = 1.4826 * middle(np.abs(residuals)), np.zeros((len(earlier), N_SHAPE))
    for place, name in ERRORS.items():
        before[:, place] = [values[name] for values in earlier]
    shares = {'misfit': _lasting_share(residuals),
              'torque': _share_beyond(of_torque, torque, optimum, wrong, noise, before),
              'twist': _share_beyond(of_twist, twist, optimum, TWIST, noise, before)}
    if not max(shares.values()) > LIMITS.curve_share:
        by_twist, by_torque = (optimum.with_prior(_within_tolerances(drive, at))
                               for at in (TWIST, TORQUE))
        shares['torque'] = _share_beyond(of_torque, torque, by_twist, wrong, noise, before)
        shares['twist'] = _share_beyond(of_twist, twist, by_torque, TWIST, noise, before)
    values = {f'elastic_{name}_share': share for name, share in shares.items()}
    values |= {f'elastic_{name}_share_threshold': LIMITS.curve_share for name in shares}
    values |= {name: float(optimum.theta[at]) for at, name in ERRORS.items()}
    broken = [condition.said() for condition, name in (
        (NO_CURVE, 'misfit'), (OTHER_TORQUE, 'torque'), (OTHER_TWIST, 'twist'))
        if shares[name] > LIMITS.curve_share]
    return broken, values


CURVE = RowCheck('elastic', LIMITS.curve_window, check, (NO_CURVE, OTHER_TORQUE, OTHER_TWIST), (
    ('elastic_misfit_share', '-', 'smoothed tau_K that no elastic curve explains, 10 s'),
    ('elastic_misfit_share_threshold', '-', 'WARN above'),
    ('elastic_torque_share', '-', 'smoothed tau_K with an error of gain or friction, 10 s'),
    ('elastic_torque_share_threshold', '-', 'WARN above'),
    ('elastic_twist_share', '-', 'smoothed twist with an error of scale or delay, 10 s'),
    ('elastic_twist_share_threshold', '-', 'WARN above'),
    ('elastic_gain', '-', 'error of the torque gain'),
    ('elastic_viscous', 'N m s/rad', 'error of the viscous friction'),
    ('elastic_coulomb', 'N m', 'error of the Coulomb friction'),
    ('elastic_scale', '-', 'error of scale between the encoders'),
    ('elastic_delay_s', 's', 'delay between the encoders')), down=1, free_torque=True,
    earlier=2 * LIMITS.curve_earlier)
