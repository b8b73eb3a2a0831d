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
rows of A at the four stages, so dPhi_i = sum_k g_k (c_ik r_k)': how the end of the step answers to
a unit in stage k (g_k) and what that stage saw (r_k) are common to all theta.

Forgetting counts samples with a measurement, not seconds. `gain R I` is the information of a prior
on each theta (R = RIDGE): where the motion says nothing, theta rests.
"""
import math

from gearbox_monitor.drive.model import (
    ALPHA, CC, CL, CV, D, KR, M1, M2, motor_friction_load_slope, motor_friction_slope, substeps,
    TWO_OVER_PI)
from gearbox_monitor.filters import ekf
from gearbox_monitor.filters.linalg import multiply, multiply_transposed, symmetrise
from gearbox_monitor.filters.process import (
    ADAPT_AT, ADAPT_COUNT, ADAPT_FORGETTING, ADAPT_RATE, ADAPT_START, derivative, EIGENVALUE,
    FRICTION_AT, FRICTION_TIME, K_P, LOAD_AT, N_PACKED, noise, Q0, Q_TAU_K_SPEED, R1, R2,
    SLOTS, tangent, TAU_K, X1, X2, X3, X4)
from gearbox_monitor.filters.record import correction, predicted
from gearbox_monitor.jit import jit

MAX_THETA = 6
FIRST = 200  # samples before the first adaptation
STEP_LIMIT = 0.05  # of theta in one sample
RIDGE = 20.0  # a prior of 1 / sqrt(20) e-folds: tames the start, where all is wrong at once
NOISE_RANGE, MODEL_RANGE = math.log(1e6), math.log(30.0)  # of theta around its start
S_LIMIT, P_LIMIT = 1e5, 1e7  # a sensitivity beyond them has run away

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

# Rows of the scratch vectors; four rows of a kind belong to the stages of RK4.
(_STAGE, _K, _TOTAL, _R_SPEED, _R_TORQUE, _R_TWIST) = (0, 1, 2, 3, 7, 11)
(_G, _V_SPEED, _V_TORQUE, _G_TWIST, _V_TWIST) = (15, 19, 23, 27, 31)
(_SLOPE, _CURVATURE, _SHARE, _CROSS, _X3, _TWIST_RATE, _TORQUE, _FORCE) = range(35, 43)
(_A, _B, _C, _C_SPEED, _C_TORQUE) = range(43, 48)
(_W, _SCORE, _GRADIENT) = (48, 52, 52 + MAX_THETA)
N_VECTORS, N_MATRICES = _GRADIENT + MAX_THETA, 4


def memory_size(n):
    """Return how many numbers the filter carries besides z [n] and P [n, n]."""
    return SENSITIVITY + MAX_THETA * (n + n * n)


def adapted(memory, p):
    """Return {name: value in use} of what is adapted, standard deviations as such."""
    names = {slot: name for name, slot in SLOTS.items()}
    result = {}
    for i in range(int(p[ADAPT_COUNT])):
        slot = int(p[ADAPT_AT + i])
        value = float(memory[IN_USE + slot] if memory[STARTED] else p[slot])
        result[names[slot]] = math.sqrt(value) if '_std_' in names[slot] else value
    return result


def guards(memory):
    """Return {guard: how often it acted}."""
    return {name: int(memory[place]) for name, place in GUARDS.items()}


def at_bound(memory, p):
    """Return the names of what stands at the bound of its range."""
    return [name for i, name in enumerate(adapted(memory, p)) if memory[STARTED] and
            abs(memory[THETA + i] - memory[START + i]) >= 0.999 * _range(int(p[ADAPT_AT + i]))]


def in_use(memory, p):
    """Return the packed parameters [N_PACKED] that the next step computes with."""
    return memory[IN_USE:IN_USE + N_PACKED].copy() if memory[STARTED] else p


@jit
def step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record):
    """Predict, update and adapt; arguments as of ekf.step."""
    if p[ADAPT_COUNT] == 0.0:
        return ekf.step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record)
    if memory[STARTED] == 0.0:
        begin(memory, p)
    if not differentiate(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record):
        return False
    _adapt(memory, p, vectors, matrices, record, z.shape[0])
    return True


@jit
def _range(slot):
    """Return how far theta of that place in p may go from its start, either way."""
    return MODEL_RANGE if slot == CV or slot == CC or slot == K_P else NOISE_RANGE


@jit
def begin(memory, p):
    """Set `memory`, all zero, to the parameters `p`; sensitivities start at zero."""
    memory[STARTED] = 1.0
    memory[GAIN], memory[FORGETTING] = 1.0, p[ADAPT_START]
    for i in range(N_PACKED):
        memory[IN_USE + i] = p[i]
    for i in range(int(p[ADAPT_COUNT])):
        memory[THETA + i] = math.log(p[int(p[ADAPT_AT + i])])
        memory[START + i] = memory[THETA + i]
        memory[INFORMATION + i * (i + 1) // 2 + i] = 1.0


@jit
def likelihood_gradient(u, load, y, dt, z, P, memory, p, vectors, matrices, record, gradient):
    """
    Return the log-likelihood of N samples, and add its gradient in theta to `gradient` [6].

    Theta stays as it is in `memory` (after begin). u, load [N], y [N, 2], dt [N]; the rest as of
    step. NaN when the filter diverges.
    """
    total = 0.0
    n = z.shape[0]
    for k in range(u.shape[0]):
        if not differentiate(z, P, memory, dt[k], u[k], load[k], y[k, 0], y[k, 1], p, vectors,
                             matrices, record):
            return math.nan
        _, _, _, scores = correction(record, n)
        total += scores[1]
        for i in range(int(p[ADAPT_COUNT])):
            gradient[i] -= vectors[_GRADIENT + i, 0]
    return total


@jit
def differentiate(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record):
    """Predict and update belief and sensitivities with the theta in `memory`; as of step."""
    n = z.shape[0]
    now = memory[IN_USE:IN_USE + N_PACKED]
    count = int(p[ADAPT_COUNT])
    s = memory[SENSITIVITY:SENSITIVITY + MAX_THETA * n].reshape(MAX_THETA, n)
    begin_P = SENSITIVITY + MAX_THETA * n
    P_s = memory[begin_P:begin_P + MAX_THETA * n * n].reshape(MAX_THETA, n, n)
    _predict(z, P, s, P_s, count, dt, u, load, now, p, vectors, matrices, record)
    if not ekf.update(z, P, y1, y2, now, matrices, record):
        return False
    _correct(s, P_s, count, now, p, vectors, record, n)
    for i in range(count):
        if not _sound(s[i], P_s[i], n):
            memory[RESETS] += 1.0
            for a in range(n):
                s[i, a] = 0.0
                for b in range(n):
                    P_s[i, a, b] = 0.0
            vectors[_GRADIENT + i, 0] = 0.0
            for a in range(5):
                vectors[_SCORE + i, a] = 0.0
    return ekf.healthy(z, P, n)


@jit
def _sound(s, P_s, n):
    for a in range(n):
        if not abs(s[a]) <= S_LIMIT:
            return False
        for b in range(a + 1):
            if not abs(P_s[a, b]) <= P_LIMIT:
                return False
    return True


@jit
def _eigenvalue(now, p):
    """Return a bound on the fastest eigenvalue with the parameters in use."""
    slope = now[CV] - p[CV] + TWO_OVER_PI * p[ALPHA] * (now[CC] - p[CC])
    stiffer = max(now[K_P] - p[K_P], 0.0)
    return (p[EIGENVALUE] + max(slope, 0.0) / p[M1]
            + math.sqrt(stiffer * (1.0 / p[M1] + 1.0 / p[M2])))


@jit
def _apply(v, stage, now, vectors, out):
    """Write A v into `out` [n], A as of stage `stage`."""
    twist_rate = v[X3] - v[X4]
    motor = (-now[D] * twist_rate - vectors[_SHARE, stage] * v[TAU_K]
             - vectors[_SLOPE, stage] * v[X3] - now[KR] * v[X1])
    arm = now[D] * twist_rate + v[TAU_K]
    if now[FRICTION_AT] > 0.0:
        i = int(now[FRICTION_AT])
        motor -= v[i]
        out[i] = -v[i] / now[FRICTION_TIME]
    if now[LOAD_AT] > 0.0:
        i = int(now[LOAD_AT])
        arm -= v[i]
        out[i] = 0.0
    out[X1] = v[X3]
    out[X2] = v[X4]
    out[X3] = motor / now[M1]
    out[X4] = arm / now[M2]
    out[TAU_K] = now[K_P] * twist_rate


@jit
def _see(stage, z, m, first, with_twist, with_atan, now, vectors):
    """Keep what stage `stage` of RK4 sees at `z` [n] and tangent `m` [n, n]; `first`: m = I."""
    n = z.shape[0]
    x3, tau = z[X3], z[TAU_K]
    v = now[ALPHA] * x3
    flat = 1.0 / (1.0 + v * v)
    steep = TWO_OVER_PI * now[ALPHA] * flat
    vectors[_SLOPE, stage] = motor_friction_slope(x3, tau, now)
    coulomb = vectors[_SLOPE, stage] - now[CV]
    vectors[_CURVATURE, stage] = -2.0 * coulomb * now[ALPHA] * v * flat
    vectors[_SHARE, stage], vectors[_CROSS, stage] = 1.0, 0.0
    if now[CL] > 0.0:
        vectors[_SHARE, stage] += motor_friction_load_slope(x3, tau, now)
        vectors[_CROSS, stage] = now[CL] * steep * (
            1.0 if tau > 0.0 else (-1.0 if tau < 0.0 else 0.0))
    vectors[_X3, stage], vectors[_TWIST_RATE, stage] = x3, x3 - z[X4]
    vectors[_FORCE, stage] = steep
    vectors[_TORQUE, stage] = TWO_OVER_PI * math.atan(v) if with_atan else 0.0
    for j in range(n):
        vectors[_R_SPEED + stage, j] = (1.0 if j == X3 else 0.0) if first else m[X3, j]
    if now[CL] > 0.0:
        for j in range(n):
            vectors[_R_TORQUE + stage, j] = m[TAU_K, j]
    if with_twist:
        for j in range(n):
            vectors[_R_TWIST + stage, j] = m[X3, j] - m[X4, j]


@jit
def _answers(at, g, h, now, vectors):
    """Write into rows g .. g + 3 how the end of a step of `h` s answers to a unit on z'[at]."""
    n = vectors.shape[1]
    a, b, c = vectors[_A], vectors[_B], vectors[_C]
    for j in range(n):
        unit = 1.0 if j == at else 0.0
        vectors[g, j] = unit
        vectors[g + 3, j] = h / 6.0 * unit
    unit = vectors[g]
    _apply(unit, 3, now, vectors, a)
    for j in range(n):
        vectors[g + 2, j] = h / 3.0 * unit[j] + h * h / 6.0 * a[j]
    _apply(unit, 2, now, vectors, a)
    _apply(a, 3, now, vectors, b)
    for j in range(n):
        vectors[g + 1, j] = h / 3.0 * unit[j] + 0.5 * h * (h / 3.0 * a[j] + h * h / 6.0 * b[j])
    _apply(unit, 1, now, vectors, a)
    _apply(a, 2, now, vectors, b)
    _apply(b, 3, now, vectors, c)
    for j in range(n):
        vectors[g, j] = h / 6.0 * unit[j] + 0.5 * h * (
            h / 3.0 * a[j] + 0.5 * h * (h / 3.0 * b[j] + h * h / 6.0 * c[j]))


@jit
def _propagate(z, phi, u, load, h, with_twist, with_atan, now, vectors, matrices):
    """Advance `z` by one RK4 step of `h` s as process.propagate does, keeping its stages."""
    n = z.shape[0]
    stage, k, total = vectors[_STAGE], vectors[_K], vectors[_TOTAL]
    m_stage, m_k, m_total = matrices[0], matrices[1], matrices[2]
    for i in range(n):
        for j in range(n):
            phi[i, j] = 1.0 if i == j else 0.0
    _see(0, z, phi, True, with_twist, with_atan, now, vectors)
    derivative(z, u, load, now, k)
    tangent(z, phi, now, m_k)
    for i in range(n):
        total[i] = k[i]
        for j in range(n):
            m_total[i, j] = m_k[i, j]
    for s in range(3):
        a = h if s == 2 else 0.5 * h
        weight = 1.0 if s == 2 else 2.0
        for i in range(n):
            stage[i] = z[i] + a * k[i]
            for j in range(n):
                m_stage[i, j] = phi[i, j] + a * m_k[i, j]
        _see(s + 1, stage, m_stage, False, with_twist, with_atan, now, vectors)
        derivative(stage, u, load, now, k)
        tangent(stage, m_stage, now, m_k)
        for i in range(n):
            total[i] += weight * k[i]
            for j in range(n):
                m_total[i, j] += weight * m_k[i, j]
    for i in range(n):
        z[i] += h / 6.0 * total[i]
        for j in range(n):
            phi[i, j] += h / 6.0 * m_total[i, j]


@jit
def _advance_sensitivity(s, slot, h, now, vectors):
    """
    Advance `s` [n] by the derivative of one RK4 step, and keep the change of A at its stages.

    Row X3 of A changes by -c / m1 on the column of x3 and by -c_torque / m1 on that of tau_K.
    """
    n = s.shape[0]
    stage, k, total = vectors[_STAGE], vectors[_K], vectors[_TOTAL]
    for i in range(n):
        stage[i] = s[i]
    for q in range(4):
        c = vectors[_CURVATURE, q] * stage[X3] + vectors[_CROSS, q] * stage[TAU_K]
        force = 0.0
        if slot == CV:
            c += now[CV]
            force = now[CV] * vectors[_X3, q]
        elif slot == CC:
            c += now[CC] * vectors[_FORCE, q]
            force = now[CC] * vectors[_TORQUE, q]
        vectors[_C_SPEED, q] = -c / now[M1]
        vectors[_C_TORQUE, q] = -vectors[_CROSS, q] * stage[X3] / now[M1]
        _apply(stage, q, now, vectors, k)
        k[X3] -= force / now[M1]
        if slot == K_P:
            k[TAU_K] += now[K_P] * vectors[_TWIST_RATE, q]
        weight = 1.0 if q == 0 or q == 3 else 2.0
        a = h if q == 2 else 0.5 * h
        for i in range(n):
            total[i] = weight * k[i] + (total[i] if q > 0 else 0.0)
            stage[i] = s[i] + a * k[i]
    for i in range(n):
        s[i] += h / 6.0 * total[i]


@jit
def _predict(z, P, s, P_s, count, dt, u, load, now, p, vectors, matrices, record):
    """Predict belief and sensitivities over `dt` s; s [>=count, n], P_s [>=count, n, n]."""
    n = z.shape[0]
    z_pred, P_pred, cross = predicted(record, n)
    phi, product, change = matrices[3], matrices[0], matrices[1]
    with_twist = with_atan = False
    for i in range(count):
        with_twist |= p[ADAPT_AT + i] == K_P
        with_atan |= p[ADAPT_AT + i] == CC
    counted = substeps(dt, _eigenvalue(now, p))
    h = dt / counted
    half = 0.5 * dt
    _add_noise(z, s, P_s, count, half, now, p)
    for i in range(n):
        z_pred[i] = half * noise(z, now, i)
    for part in range(counted):
        _propagate(z, phi, u, load, h, with_twist, with_atan, now, vectors, matrices)
        if part == 0:
            multiply(phi, P, cross)
            for i in range(n):
                P[i, i] += z_pred[i]
        else:
            multiply(phi, cross, product)
            for i in range(n):
                for j in range(n):
                    cross[i, j] = product[i, j]
        multiply(phi, P, product)
        multiply_transposed(product, phi, P)
        symmetrise(P)
        _answers(X3, _G, h, now, vectors)
        if with_twist:
            _answers(TAU_K, _G_TWIST, h, now, vectors)
        for q in range(4):  # Phi P r: what else the change of P needs of each stage
            for a in range(n):
                v = 0.0
                for b in range(n):
                    v += product[a, b] * vectors[_R_SPEED + q, b]
                vectors[_V_SPEED + q, a] = v
            if now[CL] > 0.0:
                for a in range(n):
                    v = 0.0
                    for b in range(n):
                        v += product[a, b] * vectors[_R_TORQUE + q, b]
                    vectors[_V_TORQUE + q, a] = v
            if with_twist:
                for a in range(n):
                    v = 0.0
                    for b in range(n):
                        v += product[a, b] * vectors[_R_TWIST + q, b]
                    vectors[_V_TWIST + q, a] = v
        for i in range(count):
            slot = int(p[ADAPT_AT + i])
            _advance_sensitivity(s[i], slot, h, now, vectors)
            multiply(phi, P_s[i], change)
            _advance_covariance(P_s[i], slot, phi, change, now, vectors)
    _add_noise(z, s, P_s, count, half, now, p)
    for i in range(n):
        P[i, i] += half * noise(z, now, i)
        z_pred[i] = z[i]
    for i in range(n):
        for j in range(n):
            P_pred[i, j] = P[i, j]


@jit
def _advance_covariance(P_i, slot, phi, product, now, vectors):
    """Replace `P_i` by phi P_i phi' + dphi P phi' + phi P dphi'; product: phi P_i."""
    n = P_i.shape[0]
    for q in range(4):
        c, d = vectors[_C_SPEED, q], vectors[_C_TORQUE, q]
        for a in range(n):
            vectors[_W + q, a] = c * vectors[_V_SPEED + q, a]
        if now[CL] > 0.0:
            for a in range(n):
                vectors[_W + q, a] += d * vectors[_V_TORQUE + q, a]
    for a in range(n):
        for b in range(a + 1):
            total = 0.0
            for c in range(n):
                total += product[a, c] * phi[b, c]
            for q in range(4):
                total += (vectors[_G + q, a] * vectors[_W + q, b]
                          + vectors[_W + q, a] * vectors[_G + q, b])
            P_i[a, b] = total
    if slot == K_P:
        for a in range(n):
            for b in range(a + 1):
                total = 0.0
                for q in range(4):
                    total += (vectors[_G_TWIST + q, a] * vectors[_V_TWIST + q, b]
                              + vectors[_V_TWIST + q, a] * vectors[_G_TWIST + q, b])
                P_i[a, b] += now[K_P] * total
    for a in range(n):
        for b in range(a):
            P_i[b, a] = P_i[a, b]


@jit
def _add_noise(z, s, P_s, count, half, now, p):
    """Add the derivative of half a step's process noise."""
    for i in range(count):
        q = 2.0 * now[Q_TAU_K_SPEED] * z[X3] * s[i, X3]
        if p[ADAPT_AT + i] == Q0 + TAU_K:
            q += now[Q0 + TAU_K]
        P_s[i, TAU_K, TAU_K] += half * q


@jit
def _correct(s, P_s, count, now, p, vectors, record, n):
    """Update the sensitivities after ekf.update, and keep what the score needs."""
    innovation, S, K, scores = correction(record, n)
    have1, have2 = math.isfinite(innovation[0]), math.isfinite(innovation[1])
    e1 = innovation[0] if have1 else 0.0
    e2 = innovation[1] if have2 else 0.0
    # J with J' J = S^-1 over what was measured, zero elsewhere.
    j11 = j21 = j22 = 0.0
    if have1 and have2:
        j11 = 1.0 / math.sqrt(S[0])
        j22 = 1.0 / math.sqrt(S[2] - S[1] * S[1] / S[0])
        j21 = -S[1] / S[0] * j22
    elif have1:
        j11 = 1.0 / math.sqrt(S[0])
    elif have2:
        j22 = 1.0 / math.sqrt(S[2])
    i11, i12, i22 = j11 * j11 + j21 * j21, j21 * j22, j22 * j22
    white1, white2 = j11 * e1, j21 * e1 + j22 * e2
    w1, w2 = vectors[_A], vectors[_B]
    for i in range(count):
        slot = int(p[ADAPT_AT + i])
        s_i, P_i = s[i], P_s[i]
        d1 = -s_i[X1] if have1 else 0.0
        d2 = -s_i[X2] if have2 else 0.0
        s11 = P_i[X1, X1] + (now[R1] if slot == R1 else 0.0)
        s12 = P_i[X1, X2]
        s22 = P_i[X2, X2] + (now[R2] if slot == R2 else 0.0)
        for a in range(n):
            c1 = K[a, 0] * s11 + K[a, 1] * s12
            c2 = K[a, 0] * s12 + K[a, 1] * s22
            b1, b2 = P_i[a, X1], P_i[a, X2]
            k1 = (b1 - c1) * i11 + (b2 - c2) * i12
            k2 = (b1 - c1) * i12 + (b2 - c2) * i22
            s_i[a] += k1 * e1 + k2 * e2 + K[a, 0] * d1 + K[a, 1] * d2
            w1[a], w2[a] = b1 - 0.5 * c1, b2 - 0.5 * c2
        for a in range(n):
            for b in range(a + 1):
                value = (P_i[a, b] - K[a, 0] * w1[b] - K[a, 1] * w2[b]
                         - w1[a] * K[b, 0] - w2[a] * K[b, 1])
                P_i[a, b] = value
                P_i[b, a] = value
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


@jit
def _adapt(memory, p, vectors, matrices, record, n):
    """Move theta by one Gauss-Newton step on the likelihood of the present innovation."""
    _, _, _, scores = correction(record, n)
    if scores[2] == 0.0:
        return  # nothing measured, nothing learnt
    count = int(p[ADAPT_COUNT])
    gain = memory[GAIN]
    for i in range(count):
        a = vectors[_SCORE + i]
        for j in range(i + 1):
            b = vectors[_SCORE + j]
            place = INFORMATION + i * (i + 1) // 2 + j
            memory[place] += gain * (
                a[0] * b[0] + a[1] * b[1]
                + 0.5 * (a[2] * b[2] + 2.0 * a[3] * b[3] + a[4] * b[4]) - memory[place])
    gain = gain / (gain + memory[FORGETTING])
    memory[GAIN] = gain
    memory[FORGETTING] += (1.0 - p[ADAPT_RATE]) * (p[ADAPT_FORGETTING] - memory[FORGETTING])
    memory[SAMPLES] += 1.0
    if memory[SAMPLES] <= FIRST:
        return
    if not _solve(memory, count, gain * RIDGE, vectors, matrices[0].reshape(n * n)):
        memory[NOT_SOLVED] += 1.0
        return
    limited = held = False
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
            held = True
        memory[THETA + i] = theta
        memory[IN_USE + slot] = math.exp(theta)
    memory[STEPS_LIMITED] += 1.0 if limited else 0.0
    memory[AT_BOUND] += 1.0 if held else 0.0


@jit
def _solve(memory, count, ridge, vectors, factor):
    """
    Solve (M + ridge I) x = g by Cholesky; g stands in column 0 of the gradient rows, x goes to 1.

    factor [>= 21]: scratch. False when the matrix is not positive definite or x is not finite.
    """
    for j in range(count):
        at_j = j * (j + 1) // 2
        for i in range(j, count):
            at_i = i * (i + 1) // 2
            total = memory[INFORMATION + at_i + j] + (ridge if i == j else 0.0)
            for k in range(j):
                total -= factor[at_i + k] * factor[at_j + k]
            if i > j:
                factor[at_i + j] = total / factor[at_j + j]
            elif total > 0.0:
                factor[at_i + j] = math.sqrt(total)
            else:
                return False
    for i in range(count):
        total = vectors[_GRADIENT + i, 0]
        for k in range(i):
            total -= factor[i * (i + 1) // 2 + k] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] = total / factor[i * (i + 1) // 2 + i]
    for i in range(count - 1, -1, -1):
        total = vectors[_GRADIENT + i, 1]
        for k in range(i + 1, count):
            total -= factor[k * (k + 1) // 2 + i] * vectors[_GRADIENT + k, 1]
        vectors[_GRADIENT + i, 1] = total / factor[i * (i + 1) // 2 + i]
    for i in range(count):
        if not math.isfinite(vectors[_GRADIENT + i, 1]):
            return False
    return True
