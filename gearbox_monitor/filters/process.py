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
The process model that every filter shares: the drive's equations with unknown torques as states.

State z = [x1, x2, x3, x4, tau_K, (tau_arm), (tau_e)]:
    equations (1) with tau_K as a state (the paper's equations (2), (3)),
    tau_K'   = k_p (x3 - x4) + w      k_p = 0 is the paper's random walk
    tau_arm' = w                      load on the arm, present with arm_load "unknown"
    tau_e'   = -tau_e / T + w         error of the friction model, present with a standard
                                      deviation > 0; Ornstein-Uhlenbeck, so Q = 2 std^2 / T
Measurements y = [x1, x2] + noise.
"""
import math

import numpy as np

from gearbox_monitor.drive.model import (
    ALPHA, arm_acceleration, CC, CV, D, fastest_eigenvalue, KR, M1, M2, motor_acceleration,
    motor_friction_load_slope, motor_friction_slope, N_PARAMETERS)
from gearbox_monitor.filters.adaptation import adapted_names, softened_model
from gearbox_monitor.jit import jit

X1, X2, X3, X4, TAU_K, TAU_ARM, TAU_E = range(7)
N_MAX = 7

# Places in the packed array of a filter, behind the drive's parameters.
(K_P, FRICTION_TIME, LOAD_AT, FRICTION_AT, EIGENVALUE, R1, R2, TAU_K_MODEL_STD, Q_TAU_K_SPEED,
 NUMERIC, STATISTICAL, UKF_ALPHA, UKF_BETA, UKF_KAPPA, SINGLE, ADAPT_START, ADAPT_RATE,
 ADAPT_FORGETTING, ADAPT_COUNT, ADAPT_AT) = range(N_PARAMETERS, N_PARAMETERS + 20)
Q0 = ADAPT_AT + 6
P0 = Q0 + N_MAX
N_PACKED = P0 + N_MAX

# Where the adaptive filter finds what it may adapt; of standard deviations stands the square.
SLOTS = {'q_std_tau_k': Q0 + TAU_K, 'r_std_motor': R1, 'r_std_arm': R2, 'viscous_friction': CV,
         'coulomb_friction': CC, 'tau_k_stiffness': K_P}

DIFFERENCE = 1e-6  # step of forward differences, relative above 1


def state_names(model, parameters):
    """Return which of the names below form the state vector, in order."""
    names = ['x1', 'x2', 'x3', 'x4', 'tau_k']
    if model.arm_load == 'unknown':
        names.append('tau_arm')
    if parameters['friction_error_std'] > 0.0:
        names.append('tau_e')
    return names


def pack(model, parameters):
    """
    Return the float64 array [N_PACKED] that filter kernels take.

    model: DriveModel. parameters: mapping with the filter names of parameters.ESTIMATOR.
    """
    adaptive = parameters['filter'] == 'aekf'
    if adaptive:
        model = softened_model(model, parameters)
    names = state_names(model, parameters)
    p = np.zeros(N_PACKED)
    p[:N_PARAMETERS] = model.pack()
    p[K_P] = parameters['tau_k_stiffness']
    p[FRICTION_TIME] = parameters['friction_error_time']
    p[LOAD_AT] = names.index('tau_arm') if 'tau_arm' in names else -1
    p[FRICTION_AT] = names.index('tau_e') if 'tau_e' in names else -1
    stiffness = max(model.transmission.stiffness, p[K_P])
    p[EIGENVALUE] = fastest_eigenvalue(model.with_(stiffness=stiffness))
    if 'tau_e' in names:
        p[EIGENVALUE] = max(p[EIGENVALUE], 1.0 / p[FRICTION_TIME])
    p[R1] = parameters['r_std_motor'] ** 2
    p[R2] = parameters['r_std_arm'] ** 2
    p[TAU_K_MODEL_STD] = parameters['tau_k_model_std']
    p[Q_TAU_K_SPEED] = parameters['q_std_tau_k_speed'] ** 2
    p[NUMERIC] = parameters['ekf_jacobian'] == 'numeric'
    p[STATISTICAL] = parameters['friction_linearisation'] == 'statistical'
    p[UKF_ALPHA], p[UKF_BETA] = parameters['ukf_alpha'], parameters['ukf_beta']
    p[UKF_KAPPA] = parameters['ukf_kappa']
    p[SINGLE] = parameters['srukf_precision'] == 'float32'
    if adaptive:
        p[NUMERIC] = p[STATISTICAL] = 0.0
        adapted = adapted_names(model, parameters)
        p[ADAPT_COUNT] = len(adapted)
        p[ADAPT_AT:ADAPT_AT + len(adapted)] = [SLOTS[name] for name in adapted]
        p[ADAPT_START] = parameters['adapt_forgetting_start']
        p[ADAPT_RATE] = parameters['adapt_forgetting_rate']
        p[ADAPT_FORGETTING] = parameters['adapt_forgetting']
    std = {
        'x1': 'q_std_motor_position', 'x2': 'q_std_arm_position', 'x3': 'q_std_motor_speed',
        'x4': 'q_std_arm_speed', 'tau_k': 'q_std_tau_k', 'tau_arm': 'q_std_tau_arm'}
    for i, name in enumerate(names):
        if name == 'tau_e':
            variance = parameters['friction_error_std'] ** 2
            p[Q0 + i], p[P0 + i] = 2.0 * variance / p[FRICTION_TIME], variance
        else:
            p[Q0 + i] = parameters[std[name]] ** 2
    p[P0 + X1], p[P0 + X2] = p[R1], p[R2]
    p[P0 + X3] = p[P0 + X4] = parameters['p0_std_speed'] ** 2
    p[P0 + TAU_K] = parameters['p0_std_torque'] ** 2
    if 'tau_arm' in names:
        p[P0 + TAU_ARM] = parameters['p0_std_torque'] ** 2
    return p


@jit
def noise(z, p, i):
    """
    Return the spectral density of the process noise on state `i` at `z` [n].

    Constant but for tau_K: what the model of tau_K lacks shows more the faster the drive turns.
    """
    if i == TAU_K:
        return p[Q0 + TAU_K] + p[Q_TAU_K_SPEED] * z[X3] * z[X3]
    return p[Q0 + i]


@jit
def derivative(z, u, load, p, out):
    """Write z' into `out` [n] under the motor torque `u` and the known load on the arm (N m)."""
    tau_arm = load
    if p[LOAD_AT] > 0.0:
        tau_arm += z[int(p[LOAD_AT])]
    if p[FRICTION_AT] > 0.0:
        i = int(p[FRICTION_AT])
        out[i] = -z[i] / p[FRICTION_TIME]
        u -= z[i]
    if p[LOAD_AT] > 0.0:
        out[int(p[LOAD_AT])] = 0.0
    out[X1] = z[X3]
    out[X2] = z[X4]
    out[X3] = motor_acceleration(z[X1], z[X3], z[X4], u, z[TAU_K], p)
    out[X4] = arm_acceleration(z[X3], z[X4], z[TAU_K], tau_arm, p)
    out[TAU_K] = p[K_P] * (z[X3] - z[X4])


@jit
def tangent(z, m, p, out):
    """Write A(z) m into `out`, A = d z' / d z [n, n] and `m` [n, n]."""
    slope = motor_friction_slope(z[X3], z[TAU_K], p)
    torque_share = 1.0 + motor_friction_load_slope(z[X3], z[TAU_K], p)
    load_at, friction_at = int(p[LOAD_AT]), int(p[FRICTION_AT])
    inverse_m1, inverse_m2 = 1.0 / p[M1], 1.0 / p[M2]
    for j in range(m.shape[1]):
        twist_rate = m[X3, j] - m[X4, j]
        motor = (-p[D] * twist_rate - torque_share * m[TAU_K, j] - slope * m[X3, j]
                 - p[KR] * m[X1, j])
        arm = p[D] * twist_rate + m[TAU_K, j]
        if friction_at > 0:
            motor -= m[friction_at, j]
            out[friction_at, j] = -m[friction_at, j] / p[FRICTION_TIME]
        if load_at > 0:
            arm -= m[load_at, j]
            out[load_at, j] = 0.0
        out[X1, j] = m[X3, j]
        out[X2, j] = m[X4, j]
        out[X3, j] = motor * inverse_m1
        out[X4, j] = arm * inverse_m2
        out[TAU_K, j] = p[K_P] * twist_rate


@jit
def softened(p, variance):
    """
    Return a copy of `p` with the friction linearised over a motor speed of that variance.

    At standstill its slope is then that of the mean friction, E[sign(x3)] for a sharp one, instead
    of a slope 1 / alpha wide (0.01 rad/s) that the speed is never known to.
    """
    p = p.copy()
    p[ALPHA] = 1.0 / math.sqrt(1.0 / (p[ALPHA] * p[ALPHA]) + variance / (0.5 * math.pi))
    return p


@jit
def advance(z, u, load, dt, n_substeps, p, vectors):
    """Advance `z` [n] by `dt` s in RK4 substeps; u (N m) is held. vectors [>=3, n]: scratch."""
    n = z.shape[0]
    h = dt / n_substeps
    stage, k, total = vectors[0], vectors[1], vectors[2]
    for _ in range(n_substeps):
        derivative(z, u, load, p, k)
        for i in range(n):
            total[i] = k[i]
        for s in range(3):
            a = h if s == 2 else 0.5 * h
            weight = 1.0 if s == 2 else 2.0
            for i in range(n):
                stage[i] = z[i] + a * k[i]
            derivative(stage, u, load, p, k)
            for i in range(n):
                total[i] += weight * k[i]
        for i in range(n):
            z[i] += h / 6.0 * total[i]


@jit
def propagate_numeric(z, phi, u, load, dt, n_substeps, p, vectors):
    """As propagate, but `phi` by forward differences of the map; vectors [>=4, n]: scratch."""
    n = z.shape[0]
    start = vectors[3]
    for i in range(n):
        start[i] = z[i]
    advance(z, u, load, dt, n_substeps, p, vectors)
    for j in range(n):
        moved = phi[j]  # column j, transposed below
        for i in range(n):
            moved[i] = start[i]
        moved[j] += DIFFERENCE * max(1.0, abs(start[j]))
        step = moved[j] - start[j]  # what the sum has kept of it
        advance(moved, u, load, dt, n_substeps, p, vectors)
        for i in range(n):
            moved[i] = (moved[i] - z[i]) / step
    for i in range(n):
        for j in range(i):
            phi[i, j], phi[j, i] = phi[j, i], phi[i, j]


@jit
def propagate(z, phi, u, load, dt, n_substeps, p, vectors, matrices):
    """
    Advance `z` [n] by `dt` s in RK4 substeps and write the exact tangent of that map into `phi`.

    The tangent differentiates the RK4 step itself: at the friction's fastest eigenvalue the usual
    I + hA is far from it. u (N m) is held; vectors [>=3, n], matrices [>=3, n, n] are scratch.
    """
    n = z.shape[0]
    h = dt / n_substeps
    stage, k, total = vectors[0], vectors[1], vectors[2]
    m_stage, m_k, m_total = matrices[0], matrices[1], matrices[2]
    for i in range(n):
        for j in range(n):
            phi[i, j] = 1.0 if i == j else 0.0
    for _ in range(n_substeps):
        derivative(z, u, load, p, k)
        tangent(z, phi, p, m_k)
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
            derivative(stage, u, load, p, k)
            tangent(stage, m_stage, p, m_k)
            for i in range(n):
                total[i] += weight * k[i]
                for j in range(n):
                    m_total[i, j] += weight * m_k[i, j]
        for i in range(n):
            z[i] += h / 6.0 * total[i]
            for j in range(n):
                phi[i, j] += h / 6.0 * m_total[i, j]


@jit
def finite(values):
    """Return True when all of `values` [n] are finite."""
    for i in range(values.shape[0]):
        if not math.isfinite(values[i]):
            return False
    return True
