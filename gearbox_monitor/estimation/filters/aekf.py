# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Adaptive extended Kalman filter: recursive prediction-error method with a sensitivity model.

Adapts theta, logarithms of the entries of p that process.SLOTS names, so that the innovations
become as likely as can be (Ljung; Bohn and Unbehauen). Carried for each theta_i, and exact for
the filter as computed: s_i = d z / d theta_i and P_i = d P / d theta_i.

    predict   s_i <- Phi s_i + F_i,  P_i <- dPhi_i P Phi' + Phi P dPhi_i' + Phi P_i Phi' + Q_i
    innovate  e_i = -H s_i,  S_i = H P_i H' + R_i,  K_i = (P_i H' - K S_i) S^-1
    update    s_i <- s_i + K_i e + K e_i,  P_i <- (I - K H) P_i (I - K H)' + K R_i K'
    score     g_i = e_i' S^-1 e - e' S^-1 S_i S^-1 e / 2 + tr(S^-1 S_i) / 2
              M_ij: forgetting mean of e_i' S^-1 e_j + tr(S^-1 S_i S^-1 S_j) / 2
    adapt     theta <- theta - gain (M + gain R I)^-1 g,  gain <- gain / (gain + lambda)

dPhi_i needs no second propagation. In an RK4 step theta and s_i enter the tangent only by single
rows of A at the four stages (that of x3; with a load on the arm that of x4, too), so dPhi_i =
sum_k g_k (c_ik r_k)': how the end of the step answers to a unit in stage k (g_k) and what that
stage saw (r_k) are common to all theta.

Forgetting counts samples with a measurement, not seconds. `gain R I` is the information of a prior
on each theta (R = RIDGE): where the motion says nothing, theta rests.
"""
import math
from typing import NamedTuple

from gearbox_monitor.estimation.filter_kind import (
    Adaptation, Belief, FilterKind, places, Reading, Scratch)
from gearbox_monitor.estimation.filters import ekf
from gearbox_monitor.estimation.process_model import (
    ADAPT_AT, ADAPT_COUNT, ADAPT_FORGETTING, ADAPT_RATE, ADAPT_START, along, answer, Column, decay,
    EIGENVALUE, FRICTION_AT, K_P, LOAD_AT, N_PACKED, N_TRACE, N_TRACE_OF_LOAD, noise, Q0,
    Q_TAU_K_SPEED, R1, R2, rates, rk4, SLOTS, softened_sharpness, STATISTICAL, TAU_K,
    TRACE_ARM_POSITION, TRACE_ARM_SPEED, TRACE_ON_POSITION, TRACE_ON_SPEED, TRACE_SHARE,
    TRACE_SLOPE, TRACE_SPEED, TRACE_TAU_K, TRACE_TORQUE, TRACE_TWIST_RATE, TRACE_X2, TRACE_X3,
    TRACE_X4, WALKS, X1, X2, X3, X4)
from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import apart, folded, inline, kernel
from gearbox_monitor.kernels.linalg import multiply, multiply_symmetric
from gearbox_monitor.kernels.types import Array, Layout, Pair, Vector
from gearbox_monitor.plant.drive import (
    ALPHA, ARM_ALPHA, CAV, CC, CL, CV, G, INVERSE_M1, INVERSE_M2, PHI, substeps)
from gearbox_monitor.plant.transmission import TWO_OVER_PI

MAX_THETA = 6
FIRST = 200  # samples before the first adaptation
STEP_LIMIT = 0.05  # of theta in one sample
RIDGE = 20.0  # a prior of 1 / sqrt(20) e-folds: tames the start, where all is wrong at once
NOISE_RANGE, MODEL_RANGE = math.log(1e6), math.log(30.0)  # of theta around its start
S_LIMIT, P_LIMIT = 1e5, 1e7  # a sensitivity of a norm beyond them has run away

# Places in the memory: flags and counters, then theta [6], its start [6], M (lower triangle, by
# rows), the parameters in use [N_PACKED], s [6, n], P_i [6, n, n].
(STARTED, SAMPLES, GAIN, FORGETTING, RESETS, STEPS_LIMITED, AT_BOUND, NOT_SOLVED,
 THETA) = range(9)
START = THETA + MAX_THETA
INFORMATION = START + MAX_THETA
IN_USE = INFORMATION + MAX_THETA * (MAX_THETA + 1) // 2
SENSITIVITY = IN_USE + N_PACKED
GUARDS = {'sensitivity_resets': RESETS, 'limited_steps': STEPS_LIMITED,
          'steps_held_at_bound': AT_BOUND, 'unsolvable_steps': NOT_SOLVED}

# Rows of the scratch vectors; the first ones, and with a load on the arm the last ones, are what
# rk4 has seen. Four rows of a kind, or four columns, belong to the stages of RK4.
(_R_SPEED, _R_TWIST, _R_TORQUE, _R_ARM_POSITION, _R_ARM_SPEED) = (
    TRACE_SPEED, TRACE_TWIST_RATE, TRACE_TORQUE, TRACE_ARM_POSITION, TRACE_ARM_SPEED)
(_CURVATURE, _CROSS, _TWIST_RATE, _TORQUE, _FORCE, _A, _B, _C_SPEED, _C_TORQUE,
 _G) = range(N_TRACE, N_TRACE + 10)
(_V_SPEED, _V_TORQUE, _G_TWIST, _V_TWIST, _W, _SCORE) = range(_G + 4, _G + 28, 4)
_GRADIENT = _SCORE + MAX_THETA
# With a load on the arm:
(_G_ARM, _V_ARM_POSITION, _V_ARM_SPEED,
 _ON_POSITION) = range(_GRADIENT + MAX_THETA, _GRADIENT + MAX_THETA + 16, 4)
(_ON_SPEED, _C_ARM_POSITION, _C_ARM_SPEED) = range(_ON_POSITION + 1, _ON_POSITION + 4)
_SHARPER = _C_ARM_SPEED + 1  # of each theta: relative change of the two sharpnesses of friction
N_VECTORS, N_MATRICES = _SHARPER + MAX_THETA + N_TRACE_OF_LOAD, 3


class BeliefSensitivity(NamedTuple):
    """Derivatives of z and P in theta: z [>= n_theta, n], P [>= n_theta, n * n]."""

    z: Array
    P: Array
    n_theta: int


def memory_size(n: int) -> int:
    """Return how many numbers the filter carries besides z and P of `n` states."""
    return SENSITIVITY + MAX_THETA * (n + n * n)


def adapted(memory: Array, p: Array) -> dict[str, float]:
    """Return {name: value in use} of the adapted parameters in `memory`; p: process_model.pack."""
    names = {slot: name for name, slot in SLOTS.items()}
    result = {}
    for i in range(int(p[ADAPT_COUNT])):
        slot = int(p[ADAPT_AT + i])
        value = float(memory[IN_USE + slot] if memory[STARTED] else p[slot])
        result[names[slot]] = math.sqrt(value) if '_std_' in names[slot] else value
    return result


def guards(memory: Array) -> dict[str, int]:
    """Return {guard: how often it acted}, from the filter's `memory`."""
    return {name: int(memory[place]) for name, place in GUARDS.items()}


def at_bound(memory: Array, p: Array) -> list[str]:
    """Return the names of parameters at the bound of their range; memory, p: as of adapted."""
    return [name for i, name in enumerate(adapted(memory, p)) if memory[STARTED] and
            abs(memory[THETA + i] - memory[START + i]) >= 0.999 * _range(int(p[ADAPT_AT + i]))]


def in_use(memory: Array, p: Array) -> Array:
    """Return the packed parameters [N_PACKED] of the next step; memory, p: as of adapted."""
    return memory[IN_USE:IN_USE + N_PACKED].copy() if memory[STARTED] else p


@inline
def used(memory: Array, p: Array) -> tuple[Array, float]:
    """Return a view of in_use and how much its fastest eigenvalue exceeds that of `p`, 1/s."""
    if memory[STARTED] == 0.0:
        return p, 0.0
    current = memory[IN_USE:IN_USE + N_PACKED]
    return current, _eigenvalue(current, p) - p[EIGENVALUE]


@kernel
def resume(memory: Array) -> None:
    """Restart the filter with the parameters in `memory`."""
    memory[SAMPLES] = 0.0
    memory[SENSITIVITY:] = 0.0


@folded(*WALKS)
@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
         record: Vector) -> bool:
    """
    Predict, update and adapt.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    if p[ADAPT_COUNT] == 0.0:
        return ekf.step(layout, belief, reading, p, scratch, record)
    if belief.memory[STARTED] == 0.0:
        begin(belief.memory, p)
    if not differentiate(layout, belief, reading, p, scratch, record):
        return False
    _adapt(layout, belief.memory, p, scratch.vectors, scratch.matrices, record)
    return True


@kernel
def _range(slot: int) -> float:
    """Return how far theta of that place in p may go from its start, either way."""
    return MODEL_RANGE if slot == CV or slot == CC or slot == K_P else NOISE_RANGE


@kernel
def begin(memory: Array, p: Array) -> None:
    """Set `memory`, all zero, to the parameters `p`; sensitivities start at zero."""
    memory[STARTED] = 1.0
    memory[GAIN], memory[FORGETTING] = 1.0, p[ADAPT_START]
    memory[IN_USE:IN_USE + N_PACKED] = p
    for i in range(int(p[ADAPT_COUNT])):
        memory[THETA + i] = math.log(p[int(p[ADAPT_AT + i])])
        memory[START + i] = memory[THETA + i]
        memory[INFORMATION + i * (i + 1) // 2 + i] = 1.0


@inline
def gradient(vectors: Array, i: int) -> float:
    """Return how the log-likelihood of the innovation of `differentiate` answers to theta `i`."""
    return -vectors[_GRADIENT + i, 0]


@inline
def information(vectors: Array, i: int, j: int) -> float:
    """Return what the innovation of `differentiate` tells of theta `i` and `j` (Fisher)."""
    a, b = vectors[_SCORE + i], vectors[_SCORE + j]
    return a[0] * b[0] + a[1] * b[1] + 0.5 * (a[2] * b[2] + 2.0 * a[3] * b[3] + a[4] * b[4])


@apart
def differentiate(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
                  record: Vector) -> bool:
    """
    Predict and update belief and sensitivities with the theta in the memory.

    The arguments layout, belief, reading, p, scratch and record are as of step.

    Returns:
        False if the belief is unusable.

    """
    n, memory, vectors = layout.n, belief.memory, scratch.vectors
    current = memory[IN_USE:IN_USE + N_PACKED]
    count = int(p[ADAPT_COUNT])
    s = memory[SENSITIVITY:SENSITIVITY + MAX_THETA * n].reshape(MAX_THETA, n)
    P_s = memory[SENSITIVITY + MAX_THETA * n:].reshape(MAX_THETA, n * n)
    _predict(layout, belief, BeliefSensitivity(s, P_s, count), reading, current, p, scratch,
             record)
    if not ekf.update(layout, belief, reading.y1, reading.y2, current, record):
        return False
    _correct(layout, BeliefSensitivity(s, P_s, count), current, p, vectors, record)
    for i in range(count):
        if not _sound(layout, s[i], P_s[i]):
            memory[RESETS] += 1.0
            s[i] = 0.0
            P_s[i] = 0.0
            vectors[_GRADIENT + i, 0] = 0.0
            vectors[_SCORE + i, :5] = 0.0
    return ekf.healthy(layout, belief)


@inline
def _sound(layout: Layout, s: Array, P_s: Array) -> bool:
    n = layout.n
    of_s = of_P = 0.0
    for a in range(n):
        of_s += s[a] * s[a]
        for b in range(a + 1):
            of_P += P_s[a * n + b] * P_s[a * n + b]
    return of_s <= S_LIMIT * S_LIMIT and of_P <= P_LIMIT * P_LIMIT  # NaN is not


@kernel
def _eigenvalue(current: Array, p: Array) -> float:
    """Return a bound on the fastest eigenvalue with the parameters in use."""
    slope = current[CV] - p[CV] + TWO_OVER_PI * p[ALPHA] * (current[CC] - p[CC])
    stiffer = max(current[K_P] - p[K_P], 0.0)
    return (p[EIGENVALUE] + max(slope, 0.0) * p[INVERSE_M1]
            + math.sqrt(stiffer * (p[INVERSE_M1] + p[INVERSE_M2])))


@inline
def _arm(loaded: bool, q: int, vectors: Array) -> Pair:
    """Return the slopes of the load on the arm that stage `q` has seen."""
    if not loaded:
        return 0.0, 0.0
    return vectors[TRACE_ON_POSITION, q], vectors[TRACE_ON_SPEED, q]


@inline
def _apply(loaded: bool, v: Column, stage: int, current: Array, vectors: Array) -> Column:
    """Return A v for v = (v1, v2, v3, v4, v_tau), A as of stage `stage`, from these states."""
    m = (v[0], v[2], v[3], v[4], v[1])
    load = answer(loaded, _arm(loaded, stage, vectors), 0.0, m)
    r = rates(m, vectors[TRACE_SLOPE, stage], vectors[TRACE_SHARE, stage], 0.0, load, current)
    return v[2], v[3], r[0], r[1], current[K_P] * (v[2] - v[3])


@inline
def _look(loaded: bool, with_atan: bool, current: Array, vectors: Array) -> None:
    """Complete what rk4 has seen of its four stages by what sensitivities need besides."""
    for q in range(4):
        x3, tau = vectors[TRACE_X3, q], vectors[TRACE_TAU_K, q]
        v = current[ALPHA] * x3
        flat = 1.0 / (1.0 + v * v)
        coulomb = vectors[TRACE_SLOPE, q] - current[CV]
        vectors[_CURVATURE, q] = -2.0 * coulomb * current[ALPHA] * v * flat
        vectors[_FORCE, q] = TWO_OVER_PI * current[ALPHA] * flat
        sign = 1.0 if tau > 0.0 else (-1.0 if tau < 0.0 else 0.0)
        vectors[_CROSS, q] = current[CL] * vectors[_FORCE, q] * sign
        vectors[_TWIST_RATE, q] = x3 - vectors[TRACE_X4, q]
        vectors[_TORQUE, q] = TWO_OVER_PI * math.atan(v) if with_atan else 0.0
        if loaded:  # how the slopes of the load bend
            v = current[ARM_ALPHA] * vectors[TRACE_X4, q]
            coulomb = vectors[TRACE_ON_SPEED, q] - current[CAV]
            vectors[_ON_SPEED, q] = -2.0 * coulomb * current[ARM_ALPHA] * v / (1.0 + v * v)
            vectors[_ON_POSITION, q] = -current[G] * math.sin(
                vectors[TRACE_X2, q] + current[PHI])


@inline
def _sum(a: float, v: Column, b: float, w: Column) -> Column:
    return (a * v[0] + b * w[0], a * v[1] + b * w[1], a * v[2] + b * w[2], a * v[3] + b * w[3],
            a * v[4] + b * w[4])


@inline
def _write(row: Array, v: Column, n: int) -> None:
    for j in range(n):
        row[j] = v[j] if j < 5 else 0.0


@apart
def _answers(layout: Layout, unit: Column, g: int, h: float, current: Array,
             vectors: Array) -> None:
    """
    Write into rows g .. g + 2 how the end of a step of `h` s answers to a `unit` on z'.

    On that of the stages 1 to 3 each; the answer to the last one is h / 6 of the unit.
    """
    n, loaded = layout.n, layout.loaded
    a3 = _apply(loaded, unit, 3, current, vectors)
    _write(vectors[g + 2], _sum(h / 3.0, unit, h * h / 6.0, a3), n)
    a2 = _apply(loaded, unit, 2, current, vectors)
    a32 = _apply(loaded, a2, 3, current, vectors)
    end = _sum(h / 3.0, a2, h * h / 6.0, a32)
    _write(vectors[g + 1], _sum(h / 3.0, unit, 0.5 * h, end), n)
    a1 = _apply(loaded, unit, 1, current, vectors)
    a21 = _apply(loaded, a1, 2, current, vectors)
    a321 = _apply(loaded, a21, 3, current, vectors)
    end = _sum(h / 3.0, a21, h * h / 6.0, a321)
    end = _sum(h / 3.0, a1, 0.5 * h, end)
    _write(vectors[g], _sum(h / 6.0, unit, 0.5 * h, end), n)


@inline
def _sensitivity_rates(loaded: bool, m: Column, q: int, theta: tuple[int, Pair],
                       error: float, load: float, current: Array, vectors: Array) -> Pair:
    """
    Return how x3' and x4' of stage `q` answer to theta, m = (s1, s3, s4, s_tau, s2) of that stage.

    theta: its slot, and how it changes the two sharpnesses, see _SHARPER. Keeps the change of A:
    row X3 changes by -c / m1 on the column of x3, and on that of tau_K; row X4 on those of x2 and
    x4.
    """
    slot, (sharper, arm_sharper) = theta
    coulomb = sharper * (vectors[TRACE_SLOPE, q] - current[CV])
    moved = m[1] + sharper * vectors[TRACE_X3, q]
    c = vectors[_CURVATURE, q] * moved + vectors[_CROSS, q] * m[3] + coulomb
    error += coulomb * vectors[TRACE_X3, q]
    if slot == CV:
        c += current[CV]
        error += current[CV] * vectors[TRACE_X3, q]
    elif slot == CC:
        c += current[CC] * vectors[_FORCE, q]
        error += current[CC] * vectors[_TORQUE, q]
    vectors[_C_SPEED, q] = -c * current[INVERSE_M1]
    vectors[_C_TORQUE, q] = -vectors[_CROSS, q] * moved * current[INVERSE_M1]
    if loaded:
        x4 = vectors[TRACE_X4, q]
        coulomb = arm_sharper * (vectors[TRACE_ON_SPEED, q] - current[CAV])
        load += coulomb * x4
        vectors[_C_ARM_POSITION, q] = -vectors[_ON_POSITION, q] * m[4] * current[INVERSE_M2]
        vectors[_C_ARM_SPEED, q] = -(vectors[_ON_SPEED, q] * (m[2] + arm_sharper * x4)
                                     + coulomb) * current[INVERSE_M2]
    return rates(m, vectors[TRACE_SLOPE, q], vectors[TRACE_SHARE, q], error,
                 answer(loaded, _arm(loaded, q, vectors), load, m), current)


@inline
def _advance_sensitivity(layout: Layout, s: Array, theta: tuple[int, Pair], h: float,
                         current: Array, vectors: Array) -> None:
    """Advance `s` [n] by the derivative of one RK4 step; theta: as of _sensitivity_rates."""
    n, loaded, slot = layout.n, layout.loaded, theta[0]
    half, sixth = 0.5 * h, h / 6.0
    error, load = (0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    if n > 5:
        if current[LOAD_AT] > 0.0:
            load = s[int(current[LOAD_AT])]
        if current[FRICTION_AT] > 0.0:
            error = decay(s[int(current[FRICTION_AT])], half, h, current)
            s[int(current[FRICTION_AT])] = error[4]
    twist = (0.0, 0.0, 0.0, 0.0)  # what k_p as a theta adds to tau_K'
    if slot == K_P:
        twist = (current[K_P] * vectors[_TWIST_RATE, 0], current[K_P] * vectors[_TWIST_RATE, 1],
                 current[K_P] * vectors[_TWIST_RATE, 2], current[K_P] * vectors[_TWIST_RATE, 3])
    m1 = (s[X1], s[X3], s[X4], s[TAU_K], s[X2])
    r1 = _sensitivity_rates(loaded, m1, 0, theta, error[0], load, current, vectors)
    m2 = _added(along(m1, half, m1, r1, current), half * twist[0])
    r2 = _sensitivity_rates(loaded, m2, 1, theta, error[1], load, current, vectors)
    m3 = _added(along(m1, half, m2, r2, current), half * twist[1])
    r3 = _sensitivity_rates(loaded, m3, 2, theta, error[2], load, current, vectors)
    m4 = _added(along(m1, h, m3, r3, current), h * twist[2])
    r4 = _sensitivity_rates(loaded, m4, 3, theta, error[3], load, current, vectors)
    moved1 = sixth * (m1[1] + 2.0 * (m2[1] + m3[1]) + m4[1])
    moved2 = sixth * (m1[2] + 2.0 * (m2[2] + m3[2]) + m4[2])
    s[X1] += moved1
    s[X2] += moved2
    s[X3] += sixth * (r1[0] + 2.0 * (r2[0] + r3[0]) + r4[0])
    s[X4] += sixth * (r1[1] + 2.0 * (r2[1] + r3[1]) + r4[1])
    s[TAU_K] += current[K_P] * (moved1 - moved2) + sixth * (
        twist[0] + 2.0 * (twist[1] + twist[2]) + twist[3])


@inline
def _added(m: Column, torque: float) -> Column:
    return m[0], m[1], m[2], m[3] + torque, m[4]


@inline
def _predict(layout: Layout, belief: Belief, sensitivity: BeliefSensitivity, reading: Reading,
             current: Array, p: Array, scratch: Scratch, record: Array) -> None:
    """Predict belief and sensitivities; current: packed parameters in use."""
    n, loaded = layout.n, layout.loaded
    z, P, dt, torques = belief.z, belief.P, reading.dt, (reading.u, reading.load)
    s, P_s, count = sensitivity
    vectors, matrices = scratch
    at_z, at_P, at_cross, _, _, _, _, _, _ = places(n)
    product, change, phi = matrices[0], matrices[1], matrices[2]
    cross, P_pred = record[at_cross:at_cross + n * n], record[at_P:at_P + n * n]
    flat = vectors.reshape(N_VECTORS * n)
    with_twist = with_atan = with_viscous = False
    for i in range(count):
        with_twist |= p[ADAPT_AT + i] == K_P
        with_atan |= p[ADAPT_AT + i] == CC
        with_viscous |= p[ADAPT_AT + i] == CV
    stiffer = with_twist or with_atan or with_viscous
    counted = substeps(dt, _eigenvalue(current, p) if stiffer else p[EIGENVALUE])
    h = dt / counted
    half = 0.5 * dt
    motor, arm = current[ALPHA], current[ARM_ALPHA]
    if p[STATISTICAL] > 0.0:  # until the end of the propagation, as in ekf.predict
        current[ALPHA] = softened_sharpness(motor, P[X3 * n + X3])
        current[ARM_ALPHA] = softened_sharpness(arm, P[X4 * n + X4])
        for i in range(count):
            row = vectors[_SHARPER + i]
            row[0] = -current[ALPHA] * current[ALPHA] / math.pi * P_s[i, X3 * n + X3]
            row[1] = -current[ARM_ALPHA] * current[ARM_ALPHA] / math.pi * P_s[i, X4 * n + X4]
    _add_noise(layout, z, sensitivity, half, current, p)
    for i in range(n):
        record[at_z + i] = half * noise(z, current, i)
    for part in range(counted):
        rk4(layout, z, phi, True, torques, h, current, vectors)
        _look(loaded, with_atan, current, vectors)
        if part == 0:
            multiply(layout, phi, P, cross)
            for i in range(n):
                for j in range(n):
                    product[i * n + j] = fma(phi[i * n + j], record[at_z + j], cross[i * n + j])
        else:
            multiply(layout, phi, cross, product)
            cross[:] = product
            multiply(layout, phi, P_pred, product)
        multiply_symmetric(layout, product, phi, P_pred)
        _answers(layout, (0.0, 0.0, 1.0, 0.0, 0.0), _G, h, current, vectors)
        _times(layout, product, _R_SPEED, flat, _V_SPEED)
        if current[CL] > 0.0:
            _times(layout, product, _R_TORQUE, flat, _V_TORQUE)
        if with_twist:
            _answers(layout, (0.0, 0.0, 0.0, 0.0, 1.0), _G_TWIST, h, current, vectors)
            _times(layout, product, _R_TWIST, flat, _V_TWIST)
        if loaded:
            _answers(layout, (0.0, 0.0, 0.0, 1.0, 0.0), _G_ARM, h, current, vectors)
            _times(layout, product, _R_ARM_POSITION, flat, _V_ARM_POSITION)
            _times(layout, product, _R_ARM_SPEED, flat, _V_ARM_SPEED)
        for i in range(count):
            slot = int(p[ADAPT_AT + i])
            sharper = vectors[_SHARPER + i, 0], vectors[_SHARPER + i, 1]
            _advance_sensitivity(layout, s[i], (slot, sharper), h, current, vectors)
            multiply(layout, phi, P_s[i], change)
            multiply_symmetric(layout, change, phi, P_s[i])
            _advance_covariance(layout, P_s[i], slot, h, current, vectors, flat)
    current[ALPHA], current[ARM_ALPHA] = motor, arm
    _add_noise(layout, z, sensitivity, half, current, p)
    for i in range(n):
        P_pred[i * n + i] += half * noise(z, current, i)
        record[at_z + i] = z[i]


@apart
def _times(layout: Layout, product: Array, source: int, flat: Array, out: int) -> None:
    """Write Phi P r of the four stages' rows r from row `source` on into rows from `out` on."""
    n = layout.n
    for a in range(n):
        v0 = v1 = v2 = v3 = 0.0
        for b in range(n):
            v, at = product[a * n + b], source * n + b
            v0, v1 = fma(v, flat[at], v0), fma(v, flat[at + n], v1)
            v2, v3 = fma(v, flat[at + 2 * n], v2), fma(v, flat[at + 3 * n], v3)
        at = out * n + a
        flat[at], flat[at + n], flat[at + 2 * n], flat[at + 3 * n] = v0, v1, v2, v3


@inline
def _advance_covariance(layout: Layout, P_i: Array, slot: int, h: float, current: Array,
                        vectors: Array, flat: Array) -> None:
    """Add dphi_i P phi' + phi P dphi_i' to `P_i` [n * n]."""
    n = layout.n
    for q in range(4):
        c, d = vectors[_C_SPEED, q], vectors[_C_TORQUE, q]
        for a in range(n):
            w = c * flat[(_V_SPEED + q) * n + a]
            if current[CL] > 0.0:
                w += d * flat[(_V_TORQUE + q) * n + a]
            flat[(_W + q) * n + a] = w
    _add_products(layout, P_i, 1.0, X3, h, _G, _W, flat)
    if slot == K_P:
        _add_products(layout, P_i, current[K_P], TAU_K, h, _G_TWIST, _V_TWIST, flat)
    if layout.loaded:
        for q in range(4):
            c, d = vectors[_C_ARM_POSITION, q], vectors[_C_ARM_SPEED, q]
            for a in range(n):
                flat[(_W + q) * n + a] = (c * flat[(_V_ARM_POSITION + q) * n + a]
                                          + d * flat[(_V_ARM_SPEED + q) * n + a])
        _add_products(layout, P_i, 1.0, X4, h, _G_ARM, _W, flat)


@apart
def _add_products(layout: Layout, P_i: Array, factor: float, at: int, h: float, g: int, w: int,
                  flat: Array) -> None:
    """
    Add factor (g w' + w g') of the four stages, rows from `g` and `w` on, to P_i [n * n].

    The last stage's g is h / 6 at the state `at` alone.
    """
    n = layout.n
    for a in range(n):
        for b in range(a + 1):
            total = 0.0
            for q in range(3):
                total = fma(flat[(g + q) * n + a], flat[(w + q) * n + b], total)
                total = fma(flat[(w + q) * n + a], flat[(g + q) * n + b], total)
            if a == at:
                total += h / 6.0 * flat[(w + 3) * n + b]
            if b == at:
                total += h / 6.0 * flat[(w + 3) * n + a]
            value = P_i[a * n + b] + factor * total
            P_i[a * n + b], P_i[b * n + a] = value, value


@inline
def _add_noise(layout: Layout, z: Array, sensitivity: BeliefSensitivity, half: float,
               current: Array, p: Array) -> None:
    """Add the derivative of half a step's process noise."""
    n, (s, P_s, count) = layout.n, sensitivity
    for i in range(count):
        q = 2.0 * current[Q_TAU_K_SPEED] * z[X3] * s[i, X3]
        if p[ADAPT_AT + i] == Q0 + TAU_K:
            q += current[Q0 + TAU_K]
        P_s[i, TAU_K * n + TAU_K] += half * q
        at = int(p[ADAPT_AT + i]) - Q0
        if 0 <= at < n and at != TAU_K:
            P_s[i, at * n + at] += half * current[Q0 + at]


@inline
def _correct(layout: Layout, sensitivity: BeliefSensitivity, current: Array, p: Array,
             vectors: Array, record: Array) -> None:
    """Update the sensitivities after ekf.update, and keep what the score needs."""
    n = layout.n
    s, P_s, count = sensitivity
    _, _, _, _, _, at_innovation, at_S, at_K, _ = places(n)
    e1, e2 = record[at_innovation], record[at_innovation + 1]
    have1, have2 = math.isfinite(e1), math.isfinite(e2)
    e1, e2 = e1 if have1 else 0.0, e2 if have2 else 0.0
    big_s11, big_s12, big_s22 = record[at_S], record[at_S + 1], record[at_S + 2]
    # J with J' J = S^-1 over what was measured, zero elsewhere.
    j11 = j21 = j22 = 0.0
    if have1 and have2:
        root, root_det = math.sqrt(big_s11), math.sqrt(big_s11 * big_s22 - big_s12 * big_s12)
        j11, j21, j22 = 1.0 / root, -big_s12 / (root * root_det), root / root_det
    elif have1:
        j11 = 1.0 / math.sqrt(big_s11)
    elif have2:
        j22 = 1.0 / math.sqrt(big_s22)
    i11, i12, i22 = j11 * j11 + j21 * j21, j21 * j22, j22 * j22
    white1, white2 = j11 * e1, j21 * e1 + j22 * e2
    w1, w2 = vectors[_A], vectors[_B]
    for i in range(count):
        slot = int(p[ADAPT_AT + i])
        s_i, P_i = s[i], P_s[i]
        d1 = -s_i[X1] if have1 else 0.0
        d2 = -s_i[X2] if have2 else 0.0
        s11 = P_i[0] + (current[R1] if slot == R1 else 0.0)
        s12 = P_i[1]
        s22 = P_i[n + 1] + (current[R2] if slot == R2 else 0.0)
        for a in range(n):
            c1 = record[at_K + 2 * a] * s11 + record[at_K + 2 * a + 1] * s12
            c2 = record[at_K + 2 * a] * s12 + record[at_K + 2 * a + 1] * s22
            b1, b2 = P_i[a * n], P_i[a * n + 1]
            k1 = (b1 - c1) * i11 + (b2 - c2) * i12
            k2 = (b1 - c1) * i12 + (b2 - c2) * i22
            s_i[a] += k1 * e1 + k2 * e2 + record[at_K + 2 * a] * d1 + record[at_K + 2 * a + 1] * d2
            w1[a], w2[a] = b1 - 0.5 * c1, b2 - 0.5 * c2
        for a in range(n):
            k1, k2 = record[at_K + 2 * a], record[at_K + 2 * a + 1]
            for b in range(a + 1):
                value = (P_i[a * n + b] - k1 * w1[b] - k2 * w2[b]
                         - w1[a] * record[at_K + 2 * b] - w2[a] * record[at_K + 2 * b + 1])
                P_i[a * n + b] = value
                P_i[b * n + a] = value
        # Whitened: J e_i and J S_i J'.
        f1, f2 = j11 * d1, j21 * d1 + j22 * d2
        t1, t2 = j21 * s11 + j22 * s12, j21 * s12 + j22 * s22
        v11, v12, v22 = j11 * j11 * s11, j11 * t1, j21 * t1 + j22 * t2
        row = vectors[_SCORE + i]
        row[0], row[1], row[2], row[3], row[4] = f1, f2, v11, v12, v22
        vectors[_GRADIENT + i, 0] = (
            f1 * white1 + f2 * white2 + 0.5 * (v11 + v22)
            - 0.5 * (white1 * white1 * v11 + 2.0 * white1 * white2 * v12
                     + white2 * white2 * v22))


@inline
def _adapt(layout: Layout, memory: Array, p: Array, vectors: Array, matrices: Array,
           record: Array) -> None:
    """Move theta by one Gauss-Newton step on the likelihood of the present innovation."""
    _, _, _, _, _, _, _, _, at_scores = places(layout.n)
    if record[at_scores + 2] == 0.0:
        return  # nothing measured, nothing learnt
    count = int(p[ADAPT_COUNT])
    gain = memory[GAIN]
    for i in range(count):
        for j in range(i + 1):
            place = INFORMATION + i * (i + 1) // 2 + j
            memory[place] += gain * (information(vectors, i, j) - memory[place])
    gain = gain / (gain + memory[FORGETTING])
    memory[GAIN] = gain
    memory[FORGETTING] += (1.0 - p[ADAPT_RATE]) * (p[ADAPT_FORGETTING] - memory[FORGETTING])
    memory[SAMPLES] += 1.0
    if memory[SAMPLES] <= FIRST:
        return
    if not _solve(memory, count, gain * RIDGE, vectors, matrices[0]):
        memory[NOT_SOLVED] += 1.0
        return
    limited = clipped = False
    for i in range(count):
        change = -gain * vectors[_GRADIENT + i, 1]
        if abs(change) > STEP_LIMIT:
            change = STEP_LIMIT if change > 0.0 else -STEP_LIMIT
            limited = True
        slot = int(p[ADAPT_AT + i])
        width = _range(slot)
        theta = memory[THETA + i] + change
        if abs(theta - memory[START + i]) > width:
            theta = memory[START + i] + (width if theta > memory[START + i] else -width)
            clipped = True
        memory[THETA + i] = theta
        memory[IN_USE + slot] = math.exp(theta)
    memory[STEPS_LIMITED] += 1.0 if limited else 0.0
    memory[AT_BOUND] += 1.0 if clipped else 0.0


@inline
def _solve(memory: Array, count: int, ridge: float, vectors: Array, factor: Array) -> bool:
    """
    Solve (M + ridge I) x = g by L D L'; g stands in column 0 of the gradient rows, x goes to 1.

    factor [>= 21]: scratch, below the diagonal L D, on it 1 / D. False when the matrix is not
    positive definite or x is not finite.
    """
    for j in range(count):
        at_j = j * (j + 1) // 2
        for i in range(j, count):
            at_i = i * (i + 1) // 2
            total = memory[INFORMATION + at_i + j] + (ridge if i == j else 0.0)
            for k in range(j):
                total -= factor[at_i + k] * factor[at_j + k] * factor[k * (k + 1) // 2 + k]
            if i == j and not total > 0.0:
                return False
            factor[at_i + j] = 1.0 / total if i == j else total
    for i in range(count):
        total = vectors[_GRADIENT + i, 0]
        for k in range(i):
            total -= factor[i * (i + 1) // 2 + k] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] = total * factor[i * (i + 1) // 2 + i]
    for i in range(count - 1, -1, -1):
        total = 0.0
        for k in range(i + 1, count):
            total += factor[k * (k + 1) // 2 + i] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] -= total * factor[i * (i + 1) // 2 + i]
    for i in range(count):
        if not math.isfinite(vectors[_GRADIENT + i, 1]):
            return False
    return True


@folded(*WALKS)
@apart
def accumulate(layout: Layout, belief: Belief, reading: Reading, p: Array, scratch: Scratch,
               record: Array) -> bool:
    """
    Do as ekf.step, and add up gradient and information of the likelihood in the memory.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    memory, vectors = belief.memory, scratch.vectors
    if memory[STARTED] == 0.0:
        memory[STARTED] = 1.0
        memory[IN_USE:IN_USE + N_PACKED] = p
    if memory[SAMPLES] == 0.0:
        memory[SAMPLES] = 1.0
        for i in range(int(p[ADAPT_COUNT])):
            if p[ADAPT_AT + i] == R1:
                _begin_noise(belief, i, (X1, X3), p[R1], reading.dt)
            elif p[ADAPT_AT + i] == R2:
                _begin_noise(belief, i, (X2, X4), p[R2], reading.dt)
    if not differentiate(layout, belief, reading, p, scratch, record):
        return False
    for i in range(int(p[ADAPT_COUNT])):
        memory[THETA + i] += gradient(vectors, i)
        for j in range(i + 1):
            memory[INFORMATION + i * (i + 1) // 2 + j] += information(vectors, i, j)
    return True


@inline
def _begin_noise(belief: Belief, i: int, places: tuple[int, int], r: float, dt: float) -> None:
    """
    Write how a start answers to the noise of an encoder, see sample_loop.start and first_speed.

    Args:
        belief: before the first step of `dt` s.
        i: number of theta.
        places: of position and speed.
        r: variance of the encoder, rad^2.
        dt: s.

    """
    (z, P, memory), (x, v) = belief, places
    n = z.shape[0]
    of_P = r if P[x * n + x] == r else 0.0  # else not measured at the start
    memory[SENSITIVITY + MAX_THETA * n + (i * n + x) * n + x] = of_P
    memory[SENSITIVITY + i * n + v] = -z[v] * (of_P + r) / (
        P[v * n + v] * dt * dt + P[x * n + x] + r)


FILTER = FilterKind(step, N_VECTORS, N_MATRICES, memory_size, resume, used, adaptation=Adaptation(
    adapted, in_use, at_bound, guards))
# Not for users: the EKF that adds up slopes of its log-likelihood, see score.LikelihoodSlopes.
LIKELIHOOD = FilterKind(accumulate, N_VECTORS, N_MATRICES, memory_size, resume)
