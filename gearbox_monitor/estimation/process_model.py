# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a filter takes for the law of tau_K: a random walk, or the model's curve and a deviation.

random_walk: tau_K itself wanders (the paper). elastic: the curve of the model file over the twist,
plus a deviation that wanders. learned: the same with stiffness, half gap and hysteresis as states.
mixed: a filter of each, see model_bank; the random walk leads.
"""
from collections.abc import Collection
import math
from typing import NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.filter_kind import filter_kind
from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import (
    Array, Curve, Four, Layout, Matrix, Packed, Pair, Slopes, Triple, Vector)
from gearbox_monitor.parameters import CURVES, EstimatorParameters, LEARNED, RANDOM_WALK
from gearbox_monitor.plant.drive import (
    arm_acceleration, arm_constraint, arm_load, arm_load_slopes, CAC, CAV, CC, CL, CV, D,
    DriveModel, fastest_eigenvalue, G, HALF_GAP, INVERSE_M1, INVERSE_M2, K_S, KR, LAW,
    motor_acceleration, motor_acceleration_by_law, motor_friction_load_slope, motor_friction_slope,
    motor_friction_slope_by_law, N_PARAMETERS, STIFFNESS, TL, WIDTH)
from gearbox_monitor.plant.transmission import ATAN, dead_zone_torque, elastic_torque, play

# What is learnt stays within this factor of the model's stiffness.
LEARNT_RANGE = 10.0
MEMORY, LEARNT = 'twist_memory', ('stiffness', 'gap_torque', 'hysteresis_torque')
# Spectral density of the memory's noise over the variance of its start, per s: a smoother needs
# one, as on a branch the memory follows from the other states.
MEMORY_NOISE = 1e-6
# How large the hysteresis may be at a start beside the gap; both shift the flanks, and a wider one
# takes the place of the gap before the twist has turned often enough to tell them apart.
HYSTERESIS_SHARE = 0.3


def curve_states(model: DriveModel, name: str) -> list[str]:
    """Return the names of the states that the torque model `name` adds for the drive `model`."""
    if name not in CURVES:
        return []
    if name == LEARNED:
        return [MEMORY, *LEARNT]
    shape = model.folded().transmission
    return [MEMORY] if shape.kind != 'dead_zone' and shape.hysteresis_width > 0.0 else []


def curve_drive(model: DriveModel, parameters: EstimatorParameters,
                offered: Collection[str]) -> DriveModel:
    """
    Return a drive with only those values of its transmission that its kind uses.

    Args:
        model: of the drive.
        parameters: of the filter.
        offered: torque models that the filter can take.

    Returns:
        The drive.

    Raises:
        InputError: no curve goes with the parameters.

    """
    name = parameters.tau_k_model
    if name not in offered:
        raise InputError(f'tau_k_model: {name}, expected {" or ".join(offered)} with filter '
                         f'{parameters.filter}')
    if parameters.tau_k_stiffness > 0.0:
        raise InputError(f'tau_k_stiffness: {parameters.tau_k_stiffness:g}, expected 0 with '
                         f'tau_k_model {name}, whose curve has a stiffness of its own')
    if not parameters.arm_joint:
        raise InputError(f'tau_k_model: {name}, expected {RANDOM_WALK} where no arm is measured '
                         '(arm_joint is empty): there is no twist')
    model = model.folded()
    shape = model.transmission
    return model.with_(
        hysteresis_width=0.0 if shape.kind == 'dead_zone' else shape.hysteresis_width,
        hysteresis_stiffness=shape.hysteresis_stiffness if shape.kind == 'passive_play' else 0.0)


def start_deviations(model: DriveModel, parameters: EstimatorParameters) -> dict[str, float]:
    """
    Return {state of the curve: its standard deviation at a start} for the drive `model`.

    Relative to the model's values by p0_std_curve; torques are no smaller than p0_std_torque, so
    that a model without backlash can learn one.
    """
    shape, relative = model.transmission, parameters.p0_std_curve
    torque = math.hypot(shape.stiffness * max(shape.half_gap, shape.hysteresis_width),
                        parameters.p0_std_torque)
    return dict(zip((MEMORY, *LEARNT), (
        torque / shape.stiffness, relative * shape.stiffness, relative * torque,
        HYSTERESIS_SHARE * relative * torque)))


# Parameters of the estimator, and fields of the model.
NOISE = ('q_std_tau_k', 'r_std_motor', 'r_std_arm')
MODEL = ('viscous_friction', 'coulomb_friction')
ADAPTABLE = NOISE + MODEL + ('tau_k_stiffness',)
REFUSED = {
    'damping': 'it cannot be distinguished from tau_K: a damping of many times the truth '
    'compensates for the lag of the random walk of tau_K',
}


def softened_model(model: DriveModel, parameters: EstimatorParameters) -> DriveModel:
    """
    Return `model` with the friction of an adaptive filter: atan, as soft as `parameters` say.

    A sharp friction step is far narrower than the speed is known to: with it the likelihood is
    rough and its gradient, though exact, leads nowhere.
    """
    soft, arm = parameters.adapt_friction_sharpness, model.arm_sharpness
    return model.with_(friction_law={'kind': 'atan'}, integrator='rk4',
                       friction_sharpness=min(model.friction_sharpness, soft),
                       arm_friction_sharpness=min(arm, soft))


def adapted_names(model: DriveModel, parameters: EstimatorParameters) -> list[str]:
    """Return the names in `parameters` to adapt to `model`. Raises InputError for a bad one."""
    names = [name for name in parameters.adapt if name]  # [''] is how ROS writes "none"
    for name in names:
        where = f'parameters: adapt: {name!r}'
        if name not in ADAPTABLE:
            reason = f' ({REFUSED[name]})' if name in REFUSED else ''
            raise InputError(f'{where}{reason}, expected some of {", ".join(ADAPTABLE)}')
        if names.count(name) > 1:
            raise InputError(f'{where}: named twice, expected once')
        value = getattr(model, name) if name in MODEL else getattr(parameters, name)
        if not value > 0.0:
            raise InputError(f'{where}: adapted as a logarithm, but starts at {value:g}; expected '
                             'a start > 0')
    return names


X1, X2, X3, X4, TAU_K, TAU_ARM, TAU_E = range(7)
N_MAX = 11
BESIDE = 16  # states that advance_beside takes: at least 2 n + 1, constant for the compiler
# Rows behind them: of the four stages of an RK4 step, and the load on the arm.
LANE_X3, LANE_X4, LANE_F, LANE_G, LANE_ERROR, LANE_LOAD = range(0, 24, 4)
N_LANE = LANE_LOAD + 1
# What may differ between their drives: values in the packed array, and behind them the gain and
# the delay of the motor torque.
FACTORS = (INVERSE_M1, INVERSE_M2, D, CV, CC, CAV, CAC, CL)
FACTOR_GAIN, FACTOR_DELAY, N_FACTORS = range(len(FACTORS), len(FACTORS) + 3)
FACTOR_OF = tuple(FACTORS.index(i) if i in FACTORS else -1 for i in range(N_PARAMETERS + 1))
# Standard deviation of what is anywhere between -1 and 1.
UNIFORM = 1.0 / math.sqrt(3.0)
# Places of the states of a curve behind the others, from the first of them.
W, K, C, SHIFT, N_CURVE = range(5)

# Places in the packed array of a filter, behind the drive's parameters.
(K_P, FRICTION_TIME, LOAD_AT, FRICTION_AT, EIGENVALUE, R1, R2, TAU_K_MODEL_STD, ENCODER_DELAY_STD,
 Q_TAU_K_SPEED, NUMERIC, STATISTICAL, UKF_ALPHA, UKF_BETA, UKF_KAPPA, CURVE_COUNT,
 ADAPT_START, ADAPT_RATE, ADAPT_FORGETTING, ADAPT_COUNT, ADAPT_AT) = range(
     N_PARAMETERS, N_PARAMETERS + 21)
Q0 = ADAPT_AT + 6
P0 = Q0 + N_MAX
N_PACKED = P0 + N_MAX

# Where the adaptive filter finds what it may adapt: standard deviations as their squares.
SLOTS = {'q_std_tau_k': Q0 + TAU_K, 'r_std_motor': R1, 'r_std_arm': R2, 'viscous_friction': CV,
         'coulomb_friction': CC, 'tau_k_stiffness': K_P}

N_ALONG = 6  # columns of the tangent that go along with the stages
# What a stage answers: of (x1, x3, x4, tau_K, x2), and rates of (x3, x4); then of four stages.
Column: TypeAlias = tuple[float, float, float, float, float]
Columns: TypeAlias = tuple[Column, ...]
Pairs: TypeAlias = tuple[Pair, ...]
# Layouts that are folded into kernels: with an unknown load on the arm, and without one; of walks,
# and of a curve by the number of its states.
WALKS = (Layout(6, False, -1, False), Layout(5, False, -1, False))
USUAL = tuple(Layout(walk.n + max(curve, 0), False, curve, False)
              for curve in (-1, 0, 1, 4) for walk in WALKS)


class _Stage(NamedTuple):
    """
    What the tangent needs of a stage of an RK4 step.

    slope, share: of the friction, on x3 and on tau_K; arm: of the load on the arm, on x2 and x4;
    bend: of the curve.
    """

    slope: float
    share: float
    arm: Pair
    bend: Slopes


class _Step(NamedTuple):
    """The stages of an RK4 step of `h` s; first: phi is the unit matrix before it."""

    stages: tuple[_Stage, _Stage, _Stage, _Stage]
    h: float
    first: bool


DIFFERENCE = 1e-6  # step of forward differences, relative above 1


def state_names(model: DriveModel, parameters: EstimatorParameters) -> list[str]:
    """Return the names of the states of a filter with `parameters` for the drive `model`."""
    names = ['x1', 'x2', 'x3', 'x4', 'tau_k']
    if model.arm_load == 'unknown':
        names.append('tau_arm')
    if parameters.friction_error_std > 0.0:
        names.append('tau_e')
    return names + curve_states(model, parameters.tau_k_model)


def pack(model: DriveModel, parameters: EstimatorParameters) -> Array:
    """
    Return the float64 array [N_PACKED] that filter kernels take.

    model: the drive; parameters: those of the filter, with tau_k_model "mixed" of the one that
    leads, the random walk.
    """
    kind = filter_kind(parameters.filter)
    adaptive = kind.adaptation is not None
    if adaptive:
        model = softened_model(model, parameters)
    if parameters.tau_k_model in CURVES:
        model = curve_drive(model, parameters, kind.tau_k_models)
    names, curve = state_names(model, parameters), curve_states(model, parameters.tau_k_model)
    p = np.zeros(N_PACKED)
    p[:N_PARAMETERS] = model.pack()
    p[K_P] = parameters.tau_k_stiffness
    p[FRICTION_TIME] = parameters.friction_error_time
    p[LOAD_AT] = names.index('tau_arm') if 'tau_arm' in names else -1
    p[FRICTION_AT] = names.index('tau_e') if 'tau_e' in names else -1
    p[CURVE_COUNT] = len(curve) if parameters.tau_k_model in CURVES else -1
    stiffness = max(model.transmission.stiffness, p[K_P])
    if 'stiffness' in curve:
        stiffness *= LEARNT_RANGE
    p[EIGENVALUE] = fastest_eigenvalue(model.with_(stiffness=stiffness))
    if 'tau_e' in names:
        p[EIGENVALUE] = max(p[EIGENVALUE], 1.0 / p[FRICTION_TIME])
    p[R1] = parameters.r_std_motor ** 2
    p[R2] = parameters.r_std_arm ** 2
    p[TAU_K_MODEL_STD] = parameters.tau_k_model_std
    p[ENCODER_DELAY_STD] = UNIFORM * model.encoder_delay_tolerance
    p[Q_TAU_K_SPEED] = parameters.q_std_tau_k_speed ** 2
    # No tangent has the slopes of a constraint over all other torques.
    p[NUMERIC] = model.friction_law.constraint
    p[STATISTICAL] = parameters.friction_linearisation == 'statistical'
    p[UKF_ALPHA], p[UKF_BETA] = parameters.ukf_alpha, parameters.ukf_beta
    p[UKF_KAPPA] = parameters.ukf_kappa
    if adaptive:
        p[NUMERIC] = p[STATISTICAL] = 0.0
        adapted = adapted_names(model, parameters)
        p[ADAPT_COUNT] = len(adapted)
        p[ADAPT_AT:ADAPT_AT + len(adapted)] = [SLOTS[name] for name in adapted]
        p[ADAPT_START] = parameters.adapt_forgetting_start
        p[ADAPT_RATE] = parameters.adapt_forgetting_rate
        p[ADAPT_FORGETTING] = parameters.adapt_forgetting
    _pack_noise(p, model, parameters)
    p[P0 + X1], p[P0 + X2] = p[R1], p[R2]
    p[P0 + X3] = p[P0 + X4] = parameters.p0_std_speed ** 2
    start = parameters.p0_std_torque
    if parameters.tau_k_model in CURVES and parameters.p0_std_tau_k_deviation > 0.0:
        start = parameters.p0_std_tau_k_deviation
    p[P0 + TAU_K] = start ** 2
    if 'tau_arm' in names:
        p[P0 + TAU_ARM] = parameters.p0_std_torque ** 2
    return p


def _pack_noise(p: Array, model: DriveModel, parameters: EstimatorParameters) -> None:
    """Put the noise of each state into p [N_PACKED], and the start variances of learnt ones."""
    std = {
        'x1': 'q_std_motor_position', 'x2': 'q_std_arm_position', 'x3': 'q_std_motor_speed',
        'x4': 'q_std_arm_speed', 'tau_k': 'q_std_tau_k', 'tau_arm': 'q_std_tau_arm'}
    if parameters.tau_k_model in CURVES:
        std['tau_k'] = 'q_std_tau_k_deviation'
    learnt = start_deviations(model, parameters)
    for i, name in enumerate(state_names(model, parameters)):
        if name in learnt:
            p[P0 + i] = learnt[name] ** 2
            p[Q0 + i] = p[P0 + i] * (
                MEMORY_NOISE if name == MEMORY else parameters.q_std_curve ** 2)
        elif name == 'tau_e':
            variance = parameters.friction_error_std ** 2
            p[Q0 + i], p[P0 + i] = 2.0 * variance / p[FRICTION_TIME], variance
        else:
            p[Q0 + i] = getattr(parameters, std[name]) ** 2


def layout_of(p: Array, n: int) -> Layout:
    """
    Return the Layout of a filter with `n` states and p: pack.

    What only a load on the arm, a curve or another law of friction wants is left out without it.
    """
    return Layout(n, bool(_has_load(p)), int(p[CURVE_COUNT]), bool(p[LAW] != ATAN))


@inline
def curve_count(curve: int) -> int:
    """Return the number of states of a `curve`, see Layout."""
    return max(curve, 0)


@inline
def _curve(curve: int, z: Array, width: int, i: int, at: int, p: Packed) -> Curve:
    """Return the parameters of the curve in state `i` of `width` in z; at: its first state."""
    if curve < 0:
        return 0.0, 0.0, 0.0, 0.0
    count = curve_count(curve)
    if count > 1:
        return (z[(at + K) * width + i], z[(at + C) * width + i], z[(at + SHIFT) * width + i],
                p[K_S])
    return (p[STIFFNESS], p[STIFFNESS] * p[HALF_GAP],
            p[STIFFNESS] * p[WIDTH] if count > 0 else 0.0, p[K_S])


@inline
def _memory(curve: int, z: Array, at: int, otherwise: float) -> float:
    """Return the memory of a curve that stands at `at` in z; `otherwise`: if it has none."""
    if curve < 0:
        return otherwise
    if curve_count(curve) > 0:
        return z[at]
    return otherwise


@inline
def _total(curve: int, twist: float, memory: float, law: Curve,
           tau_k: float) -> tuple[float, Slopes]:
    """Return (tau_K, slopes of its curve) where the state stands at `tau_k`."""
    if curve < 0:
        return tau_k, (0.0, 0.0, 0.0, 0.0, 0.0)
    if curve_count(curve) == 0:
        torque, slopes = dead_zone_torque(twist, law[0], law[1])
    else:
        torque, slopes = elastic_torque(twist, memory, law)
    return tau_k + torque, slopes


@inline
def torque_of(layout: Layout, z: Array, P: Array, p: Array) -> Pair:
    """
    Return tau_K (N m) and its variance.

    Args:
        layout: of the n states.
        z: mean [n].
        P: covariance [n * n].
        p: pack.

    Returns:
        Both; the variance by the slopes of the curve at the mean.

    """
    n, curve = layout.n, layout.curve
    if curve < 0:
        return z[TAU_K], P[TAU_K * n + TAU_K]
    at = n - curve_count(curve)
    twist = z[X1] - z[X2]
    tau_k, slopes = _total(curve, twist, _memory(curve, z, at, twist),
                           _curve(curve, z, 1, 0, at, p), z[TAU_K])
    variance = (P[TAU_K * n + TAU_K]
                + slopes[0] * slopes[0] * (P[X1 * n + X1] + P[X2 * n + X2] - 2.0 * P[X1 * n + X2])
                + 2.0 * slopes[0] * (P[X1 * n + TAU_K] - P[X2 * n + TAU_K]))
    for i in range(curve_count(curve)):
        row = (at + i) * n
        on_others = P[row + TAU_K] + slopes[0] * (P[row + X1] - P[row + X2])
        for j in range(i):
            on_others += slopes[1 + j] * P[row + at + j]
        variance += slopes[1 + i] * (2.0 * on_others + slopes[1 + i] * P[row + at + i])
    return tau_k, max(variance, 0.0)


@inline
def motor_side(z: Array, P: Array, tau_k: Pair, p: Array) -> Pair:
    """
    Return tau_K + tau_e (N m) and its variance; those of tau_K where tau_e is no state.

    Args:
        z: mean [n].
        P: covariance [n * n].
        tau_k: torque_of.
        p: pack.

    """
    (torque, variance), n, i = tau_k, z.shape[0], int(p[FRICTION_AT])
    if i < 0:
        return torque, variance
    return torque + z[i], variance + P[i * n + i] + 2.0 * P[TAU_K * n + i]


@inline
def torque_slopes(layout: Layout, z: Array, p: Array) -> Slopes:
    """
    Return the slopes of the curve of tau_K at a state: over the twist, then over its own states.

    Args:
        layout: of the n states.
        z: state [n].
        p: pack.

    """
    curve = layout.curve
    at, twist = layout.n - curve_count(curve), z[X1] - z[X2]
    return _total(curve, twist, _memory(curve, z, at, twist), _curve(curve, z, 1, 0, at, p),
                  z[TAU_K])[1]


@inline
def learned_length(z: Array, P: Array, n: int, i: int) -> Pair:
    """
    Return half gap or hysteresis width (rad) as learned, and its standard deviation.

    Args:
        z: mean [n].
        P: covariance [n * n].
        n: number of states; the last three are K, c and g.
        i: place of c or g.

    Returns:
        That state over K, and the deviation to first order.

    """
    k = n - 3
    length = z[i] / z[k]
    variance = P[i * n + i] + length * (length * P[k * n + k] - 2.0 * P[k * n + i])
    return length, math.sqrt(max(variance, 0.0)) / z[k]


@inline
def begin_curve(layout: Layout, z: Array, p: Array) -> None:
    """
    Set the states of the curve for a start.

    Args:
        layout: of the n states.
        z: state [n] with its positions, changed in place.
        p: pack.

    """
    count = curve_count(layout.curve)
    at = layout.n - count
    if count > 0:
        z[at + W] = z[X1] - z[X2]
    if count > 1:
        z[at + K] = p[STIFFNESS]
        z[at + C], z[at + SHIFT] = p[STIFFNESS] * p[HALF_GAP], p[STIFFNESS] * p[WIDTH]


@inline
def bound_curve(layout: Layout, z: Array, p: Array) -> None:
    """
    Keep what is learnt of the curve within its bounds.

    Args:
        layout: of the n states.
        z: state [n], changed in place.
        p: pack.

    """
    count = curve_count(layout.curve)
    if count > 1:
        at = layout.n - count
        z[at + K] = min(max(z[at + K], p[STIFFNESS] / LEARNT_RANGE), p[STIFFNESS] * LEARNT_RANGE)
        z[at + C] = max(z[at + C], 0.0)
        if p[K_S] > 0.0:
            z[at + SHIFT] = max(z[at + SHIFT], 0.0)


@inline
def _has_load(p: Array) -> bool:
    return p[CAV] != 0.0 or p[CAC] != 0.0 or p[G] != 0.0 or p[TL] != 0.0


@inline
def noise(z: Array, p: Array, i: int) -> float:
    """
    Return the spectral density of the process noise on a state.

    Constant but for tau_K: the error of its random walk grows with the speed of the drive.

    Args:
        z: state [n].
        p: pack.
        i: number of the state.

    """
    if i == TAU_K:
        return tau_k_noise(p[Q0 + TAU_K], p[Q_TAU_K_SPEED], z[X3])
    return p[Q0 + i]


@inline
def tau_k_noise(constant: float, of_speed: float, x3: float) -> float:
    """
    Return the spectral density of the process noise on tau_K, (N m)^2/s.

    Args:
        constant: share that does not depend on the speed, (N m)^2/s.
        of_speed: share per speed squared, (N m)^2 s/rad^2.
        x3: motor speed, rad/s.

    """
    return constant + of_speed * x3 * x3


@entry
def tangent(z: Vector, m: Matrix, p: Vector, out: Matrix) -> None:
    """
    Multiply a matrix by the Jacobian A = d z' / d z of the continuous model.

    Args:
        z: state [n].
        m: matrix [n, n].
        p: pack.
        out: A m [n, n], written.

    """
    slope = motor_friction_slope_by_law(z[X3], z[TAU_K], p)
    share = 1.0 + motor_friction_load_slope(z[X3], z[TAU_K], p)
    loaded, arm = _has_load(p), arm_load_slopes(z[X2], z[X4], p)
    load_at, friction_at = int(p[LOAD_AT]), int(p[FRICTION_AT])
    for j in range(m.shape[1]):
        load = error = 0.0
        if load_at > 0:
            load = m[load_at, j]
            out[load_at, j] = 0.0
        if friction_at > 0:
            error = m[friction_at, j]
            out[friction_at, j] = -error / p[FRICTION_TIME]
        column = (m[X1, j], m[X3, j], m[X4, j], m[TAU_K, j], m[X2, j])
        if loaded:
            load = answer(True, arm, load, column)
        out[X3, j], out[X4, j] = rates(column, slope, share, error, load, p)
        out[X1, j], out[X2, j] = m[X3, j], m[X4, j]
        out[TAU_K, j] = p[K_P] * (m[X3, j] - m[X4, j])


@kernel
def softened_sharpness(sharpness: float, variance: float) -> float:
    """
    Return the `sharpness` (s/rad) of a friction linearised over a speed of that variance.

    At standstill its slope is then that of the mean friction, E[sign(x3)] for a sharp one, instead
    of a slope 1 / alpha wide (0.01 rad/s) that the speed is never known to.
    """
    return 1.0 / math.sqrt(1.0 / (sharpness * sharpness) + variance / (0.5 * math.pi))


@inline
def decay(error: float, half: float, h: float, p: Packed) -> Column:
    """
    Let the friction error decay over an RK4 step.

    Args:
        error: at the start, N m.
        half: half the length of the step, s.
        h: length of the step, s.
        p: pack.

    Returns:
        The error at the four stages, and at the end of the step.

    """
    rate = -1.0 / p[FRICTION_TIME]
    second = error + half * rate * error
    third = error + half * rate * second
    fourth = error + h * rate * third
    return error, second, third, fourth, (
        error + h / 6.0 * rate * (error + 2.0 * (second + third) + fourth))


@inline
def _moved(start: Column, a: float, x: Column, f: Pair, p: Packed) -> Column:
    """Return the state `a` s after `start` at the speeds of `x` and the accelerations `f`."""
    return (start[0] + a * x[2], start[1] + a * x[3], start[2] + a * f[0], start[3] + a * f[1],
            start[4] + a * p[K_P] * (x[2] - x[3]))


@inline
def _after(x: Columns, f: Pairs, sixth: float, p: Packed) -> Column:
    """Return the state behind an RK4 step with the stages `x` and their accelerations `f`."""
    moved1 = sixth * (x[0][2] + 2.0 * (x[1][2] + x[2][2]) + x[3][2])
    moved2 = sixth * (x[0][3] + 2.0 * (x[1][3] + x[2][3]) + x[3][3])
    return (x[0][0] + moved1, x[0][1] + moved2,
            x[0][2] + sixth * (f[0][0] + 2.0 * (f[1][0] + f[2][0]) + f[3][0]),
            x[0][3] + sixth * (f[0][1] + 2.0 * (f[1][1] + f[2][1]) + f[3][1]),
            x[0][4] + p[K_P] * (moved1 - moved2))


@inline
def _bearing(layout: Layout, x: Column, elastic: tuple[float, Curve]) -> Column:
    """Return `x` with the whole torque in place of its state; elastic: see _advanced."""
    tau_k = _total(layout.curve, x[0] - x[1], elastic[0], elastic[1], x[4])[0]
    return x[0], x[1], x[2], x[3], tau_k


@inline
def _accelerations(layout: Layout, x: Column, u: float, load: float, p: Packed) -> Pair:
    """Return (x3', x4') at x = (x1, x2, x3, x4, tau_K), with the whole torque."""
    x1, x2, x3, x4, tau_k = x
    if layout.loaded:
        load += arm_load(x2, x4, p)
    if layout.law:
        load += arm_constraint(x3, x4, tau_k, load, p)
        return (motor_acceleration_by_law(x1, x3, x4, u, tau_k, p),
                arm_acceleration(x3, x4, tau_k, load, p))
    return motor_acceleration(x1, x3, x4, u, tau_k, p), arm_acceleration(x3, x4, tau_k, load, p)


@kernel
def advance_beside(layout: Layout, lanes: Array, count: int, differ: bool | None, torques: Triple,
                   dt: float, n_substeps: int, p: Array) -> None:
    """
    Advance states side by side in the vector unit, by RK4 steps.

    Stage by stage: the processor then works on several vectors at once. In whole steps, one after
    the other, each would wait for its own arctangents.

    Args:
        layout: of the n states.
        lanes: the states [n, BESIDE] by rows, changed in place; behind them the rows LANE_*,
            scratch, and, where drives differ, factors [N_FACTORS, BESIDE]: on the values FACTORS
            of the drive and on the motor torque, then how much later that acts, s.
        count: number of states; those up to a multiple of four go along.
        differ: None: all are of the drive of p.
        torques: of the motor and the measured load, N m, held; and the rate of the motor's, N m/s.
        dt: time to advance by, s.
        n_substeps: number of RK4 steps in it.
        p: see pack.

    """
    n, width, h = layout.n, (count + 3) & -4, dt / n_substeps
    at_load, at_error, friction_at = (n + LANE_LOAD) * BESIDE, (n + LANE_ERROR) * BESIDE, (
        int(p[FRICTION_AT]) * BESIDE)
    share = 1.0 if p[LOAD_AT] > 0.0 else 0.0
    # Of numbers the compiler knows that writing a state does not change them.
    drive = tuple(p[i] for i in range(K_P + 1))
    if n > 5:
        for i in range(width):
            lanes[at_load + i] = torques[1] + share * lanes[TAU_ARM * BESIDE + i]
            for q in range(4):
                lanes[at_error + q * BESIDE + i] = 0.0
    for _ in range(n_substeps):
        if n > 5 and friction_at > 0:
            for i in range(width):
                error = decay(lanes[friction_at + i], 0.5 * h, h, p)
                for q in range(4):
                    lanes[at_error + q * BESIDE + i] = error[q]
                lanes[friction_at + i] = error[4]
        _stage(layout, lanes, width, 0, 0.0, differ, torques, drive)
        _stage(layout, lanes, width, 1, 0.5 * h, differ, torques, drive)
        _stage(layout, lanes, width, 2, 0.5 * h, differ, torques, drive)
        _stage(layout, lanes, width, 3, h, differ, torques, drive)
        for i in range(width):
            _finish(layout, lanes, i, h / 6.0, drive)


@inline
def _stage(layout: Layout, lanes: Array, width: int, q: int, part: float, differ: bool | None,
           torques: Triple, shared: Packed) -> None:
    """Take stage `q` of an RK4 step, `part` s from its start; shared: p up to K_P."""
    n, curve, z = layout.n, layout.curve, lanes
    at_curve = (n - curve_count(curve)) * BESIDE
    for i in range(width):
        u, drive = _own_drive(differ, z, (n + N_LANE) * BESIDE + i, torques, shared)
        law = _curve(curve, z, BESIDE, i, n - curve_count(curve), drive)
        memory = _memory(curve, z, at_curve + i, z[X1 * BESIDE + i] - z[X2 * BESIDE + i])
        at = (n + q) * BESIDE + i
        x = z[X1 * BESIDE + i], z[X2 * BESIDE + i], z[X3 * BESIDE + i], z[X4 * BESIDE + i], (
            z[TAU_K * BESIDE + i])
        if q > 0:
            last = at - BESIDE
            x3, x4 = z[last + LANE_X3 * BESIDE], z[last + LANE_X4 * BESIDE]
            x = (x[0] + part * x3, x[1] + part * x4, x[2] + part * z[last + LANE_F * BESIDE],
                 x[3] + part * z[last + LANE_G * BESIDE], x[4] + part * drive[K_P] * (x3 - x4))
        load = z[(n + LANE_LOAD) * BESIDE + i] if n > 5 else torques[1]
        f, g = _accelerations(layout, _bearing(layout, x, (memory, law)),
                              u - (z[at + LANE_ERROR * BESIDE] if n > 5 else 0.0), load, drive)
        z[at + LANE_X3 * BESIDE], z[at + LANE_X4 * BESIDE] = x[2], x[3]
        z[at + LANE_F * BESIDE], z[at + LANE_G * BESIDE] = f, g


@inline
def _own_drive(differ: bool | None, lanes: Array, at: int, torques: Triple,
               p: Packed) -> tuple[float, Packed]:
    """Return the motor torque and the drive of a lane whose factors begin at `at`."""
    if differ is None:
        return torques[0], p
    f = lanes
    u = f[at + FACTOR_GAIN * BESIDE] * torques[0] - f[at + FACTOR_DELAY * BESIDE] * torques[2]
    return u, tuple(p[i] if FACTOR_OF[i] < 0 else p[i] * f[at + FACTOR_OF[i] * BESIDE]
                    for i in range(K_P + 1))


@inline
def _finish(layout: Layout, lanes: Array, i: int, sixth: float, p: Packed) -> None:
    """End the RK4 step of lane `i`."""
    n, curve, z = layout.n, layout.curve, lanes
    at, at_curve = n * BESIDE + i, n - curve_count(curve)
    law = _curve(curve, z, BESIDE, i, at_curve, p)
    memory = _memory(curve, z, at_curve * BESIDE + i, 0.0)
    moved1, moved2 = _mean(z, at + LANE_X3 * BESIDE, sixth), _mean(z, at + LANE_X4 * BESIDE, sixth)
    z[X1 * BESIDE + i] += moved1
    z[X2 * BESIDE + i] += moved2
    z[X3 * BESIDE + i] += _mean(z, at + LANE_F * BESIDE, sixth)
    z[X4 * BESIDE + i] += _mean(z, at + LANE_G * BESIDE, sixth)
    z[TAU_K * BESIDE + i] += p[K_P] * (moved1 - moved2)
    if curve_count(curve) > 0:
        z[at_curve * BESIDE + i] = play(z[X1 * BESIDE + i] - z[X2 * BESIDE + i], memory,
                                        abs(law[2]) / law[0])[0]


@inline
def _mean(lanes: Array, at: int, sixth: float) -> float:
    """Return a step by its four stages, which stand from `at` on."""
    return sixth * (lanes[at] + 2.0 * (lanes[at + BESIDE] + lanes[at + 2 * BESIDE])
                    + lanes[at + 3 * BESIDE])


# The tangent, column by column: m = (m1, m3, m4, m_tau, m2), how x1, x3, x4, tau_K and x2 of a
# stage answer to one state at the start. No other row depends on anything but these, and without a
# load on the arm nothing depends on m2.

@inline
def answer(loaded: bool, arm: Pair, load: float, m: Column) -> float:
    """
    Return the derivative of the arm's load at a stage along a column of the tangent.

    Args:
        loaded: None without a load on the arm.
        arm: arm_load_slopes of the stage.
        load: derivative of the load that is a state.
        m: the column.

    """
    if not loaded:
        return load
    return load + arm[0] * m[4] + arm[1] * m[2]


@inline
def rates(m: Column, slope: float, share: float, error: float, load: float, p: Packed) -> Pair:
    """
    Return the derivatives of x3' and x4' at a stage along a column of the tangent.

    Args:
        m: the column.
        slope: of the friction over x3.
        share: of the motor's acceleration over tau_K.
        error: derivative of the friction error.
        load: derivative of the load on the arm, see answer.
        p: pack, up to K_P.

    """
    twist_rate = m[1] - m[2]
    on_motor = fma(share, m[3], fma(slope, m[1], fma(p[KR], m[0], error)))
    return (-p[INVERSE_M1] * fma(p[D], twist_rate, on_motor),
            p[INVERSE_M2] * fma(p[D], twist_rate, m[3] - load))


@inline
def along(start: Column, a: float, m: Column, r: Pair, p: Packed) -> Column:
    """
    Return a column of the tangent at the next stage of an RK4 step.

    Args:
        start: the column at the start of the step.
        a: time from the start to the stage, s.
        m: the column at the present stage.
        r: rates of `m`.
        p: pack, up to K_P.

    """
    return (fma(a, m[1], start[0]), fma(a, r[0], start[1]), fma(a, r[1], start[2]),
            fma(a * p[K_P], m[1] - m[2], start[3]), fma(a, m[2], start[4]))


@inline
def _bent(curve: int, bend: Slopes, source: float, m: Column) -> Column:
    """Return the column `m` with that of tau_K for that of its state; source: of the memory."""
    if curve < 0:
        return m
    return m[0], m[1], m[2], fma(bend[0], m[0] - m[4], m[3] + source), m[4]


@inline
def _stage_rates(layout: Layout, stage: _Stage, m: Column, source: float, error: float,
                 load: float, p: Packed) -> Pair:
    """Return `rates` of the column `m` at a `stage`; source: as of _bent."""
    return rates(_bent(layout.curve, stage.bend, source, m), stage.slope, stage.share, error,
                 answer(layout.loaded, stage.arm, load, m), p)


@inline
def _memory_row(layout: Layout, phi: Array, j: int, first: bool) -> float:
    """Return how the memory of the curve answers to state `j` at the start of an RK4 step."""
    n, count = layout.n, curve_count(layout.curve)
    if count == 0 or first:
        return 1.0 if count > 0 and j == n - count else 0.0
    return phi[(n - count) * n + j]


@inline
def _rates_along(layout: Layout, stage: _Stage, m: Columns, rows: tuple[float, ...],
                 p: Array) -> Pairs:
    """Return `rates` of several columns; rows: how the memory of the curve answers to each."""
    return tuple(_stage_rates(layout, stage, m[j], stage.bend[1] * rows[j], 0.0, 0.0, p)
                 for j in range(N_ALONG))


@inline
def _all_along(start: Columns, a: float, m: Columns, r: Pairs, p: Array) -> Columns:
    return tuple(along(start[j], a, m[j], r[j], p) for j in range(N_ALONG))


@inline
def _begin(n: int, phi: Array, j: int, first: bool) -> Column:
    """Return column `j` at the start of an RK4 step."""
    if first:
        return (1.0 if j == X1 else 0.0, 1.0 if j == X3 else 0.0, 1.0 if j == X4 else 0.0,
                1.0 if j == TAU_K else 0.0, 1.0 if j == X2 else 0.0)
    return (phi[X1 * n + j], phi[X3 * n + j], phi[X4 * n + j], phi[TAU_K * n + j],
            phi[X2 * n + j])


@inline
def _end(layout: Layout, phi: Array, j: int, h: float, m: Columns, r: Pairs, p: Array) -> None:
    """Write column `j` of phi behind an RK4 step; m, r: its four stages and their rates."""
    n = layout.n
    moved1 = h / 6.0 * fma(2.0, m[1][1] + m[2][1], m[0][1] + m[3][1])
    moved2 = h / 6.0 * fma(2.0, m[1][2] + m[2][2], m[0][2] + m[3][2])
    phi[X1 * n + j] = m[0][0] + moved1
    phi[X2 * n + j] = m[0][4] + moved2
    phi[X3 * n + j] = fma(h / 6.0, fma(2.0, r[1][0] + r[2][0], r[0][0] + r[3][0]), m[0][1])
    phi[X4 * n + j] = fma(h / 6.0, fma(2.0, r[1][1] + r[2][1], r[0][1] + r[3][1]), m[0][2])
    phi[TAU_K * n + j] = m[0][3] + p[K_P] * (moved1 - moved2)


@inline
def _column(layout: Layout, phi: Array, j: int, step: _Step, errors: Four, sources: Pair,
            p: Array) -> None:
    """
    Advance column `j` of phi by an RK4 step.

    errors: of friction, in its four stages; sources: what the state adds to the load on the arm,
    and the place of its slope in those of the curve, 0 for none.
    """
    (one, two, three, four), h, first = step
    load, own, memory = sources[0], int(sources[1]), _memory_row(layout, phi, j, first)
    m1 = _begin(layout.n, phi, j, first)
    r1 = _stage_rates(layout, one, m1, _source(one.bend, memory, own), errors[0], load, p)
    m2 = along(m1, 0.5 * h, m1, r1, p)
    r2 = _stage_rates(layout, two, m2, _source(two.bend, memory, own), errors[1], load, p)
    m3 = along(m1, 0.5 * h, m2, r2, p)
    r3 = _stage_rates(layout, three, m3, _source(three.bend, memory, own), errors[2], load, p)
    m4 = along(m1, h, m3, r3, p)
    r4 = _stage_rates(layout, four, m4, _source(four.bend, memory, own), errors[3], load, p)
    _end(layout, phi, j, h, (m1, m2, m3, m4), (r1, r2, r3, r4), p)


@inline
def _source(bend: Slopes, memory: float, own: int) -> float:
    return bend[1] * memory + (bend[2] if own == 2 else 0.0) + (
        bend[3] if own == 3 else 0.0) + (bend[4] if own == 4 else 0.0)


@inline
def _stage_at(layout: Layout, x: Column, elastic: tuple[float, Curve], torques: Pair,
              p: Array) -> tuple[Pair, _Stage]:
    """Return the accelerations at `x` and the _Stage; elastic: as of _advanced."""
    total, bend = _total(layout.curve, x[0] - x[1], elastic[0], elastic[1], x[4])
    slope = (motor_friction_slope_by_law(x[2], total, p) if layout.law
             else motor_friction_slope(x[2], total, p))
    arm = arm_load_slopes(x[1], x[3], p) if layout.loaded else (0.0, 0.0)
    return (_accelerations(layout, (x[0], x[1], x[2], x[3], total), torques[0], torques[1], p),
            _Stage(slope, 1.0 + motor_friction_load_slope(x[2], total, p), arm, bend))


@inline
def _rk4(layout: Layout, z: Array, phi: Array, first: bool, torques: Pair, h: float,
         p: Array) -> None:
    """
    Advance a state by one RK4 step, and a matrix by the exact tangent of that step.

    The columns of four states go along with the stages, and fill the time in which one arctangent
    waits for the previous one.

    Args:
        layout: as of advance_beside.
        torques: of the motor and the measured load, N m, held.
        p: as of advance_beside.
        z: state [n], changed in place.
        phi: matrix [n * n], changed in place.
        first: phi is not read, but taken for the unit matrix.
        h: length of the step, s.

    """
    n, curve = layout.n, layout.curve
    u, load = torques
    half = 0.5 * h
    x1 = z[X1], z[X2], z[X3], z[X4], z[TAU_K]
    count = curve_count(curve)
    law = _curve(curve, z, 1, 0, n - count, p)
    memory = _memory(curve, z, n - count, x1[0] - x1[1])
    # Nothing depends on x2 without load and curve; the compiler leaves out what is not written.
    places = (X1, X3, X4, TAU_K, X2, n - max(count, 1))
    rows = tuple(_memory_row(layout, phi, j, first) for j in places)
    error = (0.0, 0.0, 0.0, 0.0, 0.0)
    if n > 5:
        if p[LOAD_AT] > 0.0:
            load += z[int(p[LOAD_AT])]
        if p[FRICTION_AT] > 0.0:
            error = decay(z[int(p[FRICTION_AT])], half, h, p)
    # Stage by stage: the state x and its accelerations f, the columns m and their rates r.
    m1 = tuple(_begin(n, phi, j, first) for j in places)
    f1, one = _stage_at(layout, x1, (memory, law), (u - error[0], load), p)
    r1 = _rates_along(layout, one, m1, rows, p)
    x2, m2 = _moved(x1, half, x1, f1, p), _all_along(m1, half, m1, r1, p)
    f2, two = _stage_at(layout, x2, (memory, law), (u - error[1], load), p)
    r2 = _rates_along(layout, two, m2, rows, p)
    x3, m3 = _moved(x1, half, x2, f2, p), _all_along(m1, half, m2, r2, p)
    f3, three = _stage_at(layout, x3, (memory, law), (u - error[2], load), p)
    r3 = _rates_along(layout, three, m3, rows, p)
    x4, m4 = _moved(x1, h, x3, f3, p), _all_along(m1, h, m3, r3, p)
    f4, four = _stage_at(layout, x4, (memory, law), (u - error[3], load), p)
    r4 = _rates_along(layout, four, m4, rows, p)
    z[X1], z[X2], z[X3], z[X4], z[TAU_K] = _after((x1, x2, x3, x4), (f1, f2, f3, f4), h / 6.0, p)
    for i, j in enumerate(places):
        if i < 4 or (i == 5 and count > 0) or (i == 4 and (layout.loaded or curve >= 0)):
            _end(layout, phi, j, h, (m1[i], m2[i], m3[i], m4[i]), (r1[i], r2[i], r3[i], r4[i]), p)
        elif i == 4 and first:
            for k in range(n):
                phi[k * n + X2] = 1.0 if k == X2 else 0.0
    step = _Step((one, two, three, four), h, first)
    if n > 5:
        if first:
            for i in range(5, n):
                for j in range(n):
                    phi[i * n + j] = 1.0 if i == j else 0.0
        none = (0.0, 0.0, 0.0, 0.0)
        if p[LOAD_AT] > 0.0:
            _column(layout, phi, int(p[LOAD_AT]), step, none, (1.0, 0.0), p)
        if p[FRICTION_AT] > 0.0:
            i = int(p[FRICTION_AT])
            z[i] = error[4]
            fades = decay(phi[i * n + i], half, h, p)
            _column(layout, phi, i, step, fades[:4], (0.0, 0.0), p)
            phi[i * n + i] = fades[4]
        _columns_of_curve(layout, z, phi, memory, law, step, p)


@inline
def _columns_of_curve(layout: Layout, z: Array, phi: Array, memory: float, law: Curve,
                      step: _Step, p: Array) -> None:
    """Advance the columns of the curve's states, then the row of its memory; z: at the end."""
    n, count = layout.n, curve_count(layout.curve)
    at, none = n - count, (0.0, 0.0, 0.0, 0.0)
    if count > 1:
        for i, own in ((K, 2.0), (C, 3.0), (SHIFT, 4.0)):
            _column(layout, phi, at + i, step, none, (0.0, own), p)
    if count > 0:
        width = abs(law[2]) / law[0]
        z[at + W], end = play(z[X1] - z[X2], memory, width)
        if end != 0.0:
            for j in range(n):
                phi[(at + W) * n + j] = phi[X1 * n + j] - phi[X2 * n + j]
            if count > 1:
                phi[(at + W) * n + at + K] += end * width / law[0]
                phi[(at + W) * n + at + SHIFT] -= (end if law[2] >= 0.0 else -end) / law[0]


@inline
def propagate(layout: Layout, z: Vector, phi: Vector, torques: Pair, dt: float, n_substeps: int,
              p: Vector) -> None:
    """
    Advance a state by RK4 steps, and write the exact tangent of that map.

    The tangent differentiates the RK4 step itself: at the friction's fastest eigenvalue the usual
    I + hA is far from it.

    Args:
        layout: as of advance_beside.
        z: as of advance_beside.
        torques: of the motor and the measured load, N m, held.
        dt: as of advance_beside.
        n_substeps: as of advance_beside.
        p: as of advance_beside.
        phi: tangent [n * n], written.

    """
    h = dt / n_substeps if n_substeps > 1 else dt
    for k in range(max(n_substeps, 1)):
        _rk4(layout, z, phi, k == 0, torques, h, p)


@kernel
def propagate_numeric(layout: Layout, z: Vector, phi: Vector, torques: Pair, dt: float,
                      n_substeps: int, p: Vector, lanes: Vector) -> None:
    """
    Do as propagate, but with the tangent by forward differences.

    Args:
        layout: as of propagate.
        z: as of propagate.
        phi: as of propagate.
        torques: as of propagate.
        dt: as of propagate.
        n_substeps: as of propagate.
        p: as of propagate.
        lanes: scratch, as of advance_beside.

    """
    n = layout.n
    for i in range(n):
        lanes[i * BESIDE:(i + 1) * BESIDE] = z[i]
        lanes[i * BESIDE + 1 + i] += DIFFERENCE * max(1.0, abs(z[i]))
        phi[i] = lanes[i * BESIDE + 1 + i] - z[i]  # the increment as rounded
    advance_beside(layout, lanes, n + 1, None, (torques[0], torques[1], 0.0), dt, n_substeps, p)
    for i in range(n - 1, -1, -1):
        z[i] = lanes[i * BESIDE]
        for j in range(n):
            phi[i * n + j] = (lanes[i * BESIDE + 1 + j] - z[i]) / phi[j]
