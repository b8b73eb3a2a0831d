# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The EKF for several candidates of Q and R side by side: lanes of a vector unit.

Model, inputs and measurements are the same for all. The equations are those of filters.ekf and
process_model, for drives without the effects that need a branch or a sine in each stage (see
suited) and samples with both encoders.

states: process_model.markers; s [N_ROWS * LANES]: what the lanes carry, row by row, lanes side
by side; drive: see drive_of.
"""
from typing import TypeAlias

from gearbox_monitor.estimation.filters.ekf import inverse, joseph, joseph_element, mahalanobis
from gearbox_monitor.estimation.process_model import (
    along, answer, Column, CURVE_COUNT, EIGENVALUE, FRICTION_AT, K_P, NUMERIC, P0, Q0,
    Q_TAU_K_SPEED, R1, R2, rates, softened_sharpness, STATISTICAL, TAU_ARM, TAU_K, tau_k_noise,
    X1, X2, X3, X4)
from gearbox_monitor.kernels.jit import fma, jit, jit_inline
from gearbox_monitor.kernels.types import Array, Four, Packed, Pair, States
from gearbox_monitor.plant.drive import (
    ALPHA, arm_acceleration, CAC, CAV, CL, G, LAW, motor_acceleration, motor_friction_slope,
    steady_arm_load, substeps)

LANES = 16
N = 6  # states at most
# Rows of s: numbers of a lane, then vectors [N], then matrices [N, N].
(SHARPNESS, NOISE_1, NOISE_2, OF_SPEED, ERROR_1, ERROR_2, S11, S22, NIS, DETERMINANT, BAD,
 N_NUMBERS) = range(12)
Z, DENSITY, HALF, GAIN_1, GAIN_2, MATRICES = range(N_NUMBERS, N_NUMBERS + 6 * N, N)
P, PHI, CROSS, PRIOR, N_ROWS = range(MATRICES, MATRICES + 5 * N * N, N * N)
HUGE = 1e300
Drive: TypeAlias = tuple[tuple[float, ...], tuple[float, ...]]


def suited(p: Array) -> bool:
    """Return whether lanes can run filters with the packed parameters `p`."""
    return (not p[[NUMERIC, G, CAC, CL, LAW]].any()
            and bool(p[FRICTION_AT] < 0.0 and p[CURVE_COUNT] < 0.0))


def drive_of(p: Array) -> Drive:
    """Return the packed parameters `p` up to K_P, without the sharpness: each lane has its own."""
    return tuple(p[:ALPHA].tolist()), tuple(p[ALPHA + 1:K_P + 1].tolist())


@jit
def begin(states: States, p: Array, y1: float, y2: float, s: Array) -> None:
    """
    Start all lanes.

    Args:
        states: process_model.markers.
        p: packed parameters [LANES, N_PACKED].
        y1: motor position, rad.
        y2: arm position, rad.
        s: the lanes, written.

    """
    n = len(states)
    s[:] = 0.0
    for i in range(LANES):
        s[LANES * (Z + X1) + i], s[LANES * (Z + X2) + i] = y1, y2
        s[LANES * NOISE_1 + i], s[LANES * NOISE_2 + i] = p[i, R1], p[i, R2]
        s[LANES * OF_SPEED + i], s[LANES * SHARPNESS + i] = p[i, Q_TAU_K_SPEED], p[i, ALPHA]
        for j in range(n):
            s[LANES * (DENSITY + j) + i] = p[i, Q0 + j]
            s[LANES * (P + N * j) + LANES * j + i] = p[i, P0 + j]


@jit_inline
def _accelerations(loaded: bool | None, x1: float, x3: float, x4: float, tau_k: float, u: float,
                   load: float, p: Packed) -> Pair:
    if loaded is not None:
        load += steady_arm_load(x4, p)
    return motor_acceleration(x1, x3, x4, u, tau_k, p), arm_acceleration(x3, x4, tau_k, load, p)


@jit_inline
def _rates(loaded: bool | None, m: Column, slope: float, load: float, p: Packed) -> Pair:
    return rates(m, slope, 1.0, 0.0, answer(loaded, (0.0, p[CAV]), load, m), p)


@jit_inline
def _column(loaded: bool | None, at: int, m1: Column, h: float, slopes: Four, load: float,
            p: Packed, s: Array) -> None:
    """
    Advance the column `m1` of phi by an RK4 step, and write it.

    at: place of the column and lane in a row; load: answer of the state.
    """
    r1 = _rates(loaded, m1, slopes[0], load, p)
    m2 = along(m1, 0.5 * h, m1, r1, p)
    r2 = _rates(loaded, m2, slopes[1], load, p)
    m3 = along(m1, 0.5 * h, m2, r2, p)
    r3 = _rates(loaded, m3, slopes[2], load, p)
    m4 = along(m1, h, m3, r3, p)
    r4 = _rates(loaded, m4, slopes[3], load, p)
    moved1 = h / 6.0 * fma(2.0, m2[1] + m3[1], m1[1] + m4[1])
    moved2 = h / 6.0 * fma(2.0, m2[2] + m3[2], m1[2] + m4[2])
    s[LANES * (PHI + N * X1) + at] = m1[0] + moved1
    s[LANES * (PHI + N * X2) + at] = m1[4] + moved2
    s[LANES * (PHI + N * X3) + at] = fma(h / 6.0, fma(2.0, r2[0] + r3[0], r1[0] + r4[0]), m1[1])
    s[LANES * (PHI + N * X4) + at] = fma(h / 6.0, fma(2.0, r2[1] + r3[1], r1[1] + r4[1]), m1[2])
    s[LANES * (PHI + N * TAU_K) + at] = m1[3] + p[K_P] * (moved1 - moved2)


@jit_inline
def _begun(first: bool | None, j: int, s: Array, i: int) -> Column:
    """Return column `j` of phi as it is before a step; first: None, or it is the unit matrix."""
    if first is not None:
        return (1.0 if j == X1 else 0.0, 1.0 if j == X3 else 0.0, 1.0 if j == X4 else 0.0,
                1.0 if j == TAU_K else 0.0, 0.0)
    at = LANES * j + i
    return (s[LANES * (PHI + N * X1) + at], s[LANES * (PHI + N * X3) + at],
            s[LANES * (PHI + N * X4) + at], s[LANES * (PHI + N * TAU_K) + at],
            s[LANES * (PHI + N * X2) + at])


@jit
def _rk4(states: States, first: bool | None, u: float, load: float, h: float, drive: Drive,
         s: Array) -> None:
    """
    Advance z and phi by one RK4 step of `h` s; first: None, or phi is taken for the unit matrix.

    The column of x2, on which nothing depends, and the rows behind tau_K stay those of the unit
    matrix and are never written.
    """
    n, loaded = len(states), states[0]
    half, sixth = 0.5 * h, h / 6.0
    for i in range(LANES):
        p = drive[0] + (s[LANES * SHARPNESS + i],) + drive[1]
        x1, x2, x3 = s[LANES * (Z + X1) + i], s[LANES * (Z + X2) + i], s[LANES * (Z + X3) + i]
        x4, tau_k = s[LANES * (Z + X4) + i], s[LANES * (Z + TAU_K) + i]
        on_arm = load
        if n > 5:
            on_arm = load + s[LANES * (Z + TAU_ARM) + i]
        slope1 = motor_friction_slope(x3, tau_k, p)
        f1, g1 = _accelerations(loaded, x1, x3, x4, tau_k, u, on_arm, p)
        y3, y4 = x3 + half * f1, x4 + half * g1
        tau_y = tau_k + half * p[K_P] * (x3 - x4)
        slope2 = motor_friction_slope(y3, tau_y, p)
        f2, g2 = _accelerations(loaded, x1 + half * x3, y3, y4, tau_y, u, on_arm, p)
        v3, v4 = x3 + half * f2, x4 + half * g2
        tau_v = tau_k + half * p[K_P] * (y3 - y4)
        slope3 = motor_friction_slope(v3, tau_v, p)
        f3, g3 = _accelerations(loaded, x1 + half * y3, v3, v4, tau_v, u, on_arm, p)
        w3, w4 = x3 + h * f3, x4 + h * g3
        tau_w = tau_k + h * p[K_P] * (v3 - v4)
        slope4 = motor_friction_slope(w3, tau_w, p)
        f4, g4 = _accelerations(loaded, x1 + h * v3, w3, w4, tau_w, u, on_arm, p)
        moved1 = sixth * (x3 + 2.0 * (y3 + v3) + w3)
        moved2 = sixth * (x4 + 2.0 * (y4 + v4) + w4)
        s[LANES * (Z + X1) + i], s[LANES * (Z + X2) + i] = x1 + moved1, x2 + moved2
        s[LANES * (Z + X3) + i] = x3 + sixth * (f1 + 2.0 * (f2 + f3) + f4)
        s[LANES * (Z + X4) + i] = x4 + sixth * (g1 + 2.0 * (g2 + g3) + g4)
        s[LANES * (Z + TAU_K) + i] = tau_k + p[K_P] * (moved1 - moved2)
        slopes = (slope1, slope2, slope3, slope4)
        _column(loaded, LANES * X1 + i, _begun(first, X1, s, i), h, slopes, 0.0, p, s)
        _column(loaded, LANES * X3 + i, _begun(first, X3, s, i), h, slopes, 0.0, p, s)
        _column(loaded, LANES * X4 + i, _begun(first, X4, s, i), h, slopes, 0.0, p, s)
        _column(loaded, LANES * TAU_K + i, _begun(first, TAU_K, s, i), h, slopes, 0.0, p, s)
        if n > 5:
            _column(loaded, LANES * TAU_ARM + i, _begun(first, TAU_ARM, s, i), h, slopes, 1.0, p,
                    s)


@jit_inline
def _phi_times_P(n: int, k: int, s: Array, i: int) -> None:
    """Write row `k` of phi P, k <= TAU_K."""
    phi = LANES * (PHI + N * k) + i
    for j in range(n):
        at = LANES * j + i
        value = s[phi + LANES * X1] * s[LANES * (P + N * X1) + at]
        if k == X2:
            value += s[LANES * (P + N * X2) + at]
        value = fma(s[phi + LANES * X3], s[LANES * (P + N * X3) + at], value)
        value = fma(s[phi + LANES * X4], s[LANES * (P + N * X4) + at], value)
        value = fma(s[phi + LANES * TAU_K], s[LANES * (P + N * TAU_K) + at], value)
        if n > 5:
            value = fma(s[phi + LANES * TAU_ARM], s[LANES * (P + N * TAU_ARM) + at], value)
        s[LANES * (CROSS + N * k) + at] = value


@jit_inline
def _predicted(n: int, k: int, half_dt: float, s: Array, i: int) -> None:
    """Write row `k` of P_pred, up to its diagonal: (phi P + phi Q h / 2) phi' + Q h / 2."""
    phi, cross = LANES * (PHI + N * k) + i, LANES * (CROSS + N * k) + i
    if k < TAU_ARM:
        a1 = fma(s[phi + LANES * X1], s[LANES * (HALF + X1) + i], s[cross + LANES * X1])
        a2 = s[cross + LANES * X2]
        if k == X2:
            a2 += s[LANES * (HALF + X2) + i]
        a3 = fma(s[phi + LANES * X3], s[LANES * (HALF + X3) + i], s[cross + LANES * X3])
        a4 = fma(s[phi + LANES * X4], s[LANES * (HALF + X4) + i], s[cross + LANES * X4])
        a5 = fma(s[phi + LANES * TAU_K], s[LANES * (HALF + TAU_K) + i], s[cross + LANES * TAU_K])
        a6 = 0.0
        if n > 5:
            a6 = fma(s[phi + LANES * TAU_ARM], s[LANES * (HALF + TAU_ARM) + i],
                     s[cross + LANES * TAU_ARM])
    else:  # a row of the unit matrix
        row_p = LANES * (P + N * TAU_ARM) + i
        a1, a2, a3 = s[row_p + LANES * X1], s[row_p + LANES * X2], s[row_p + LANES * X3]
        a4, a5 = s[row_p + LANES * X4], s[row_p + LANES * TAU_K]
        a6 = s[row_p + LANES * TAU_ARM] + s[LANES * (HALF + TAU_ARM) + i]
    for j in range(k + 1):
        if j == TAU_ARM:
            value = a6
        else:
            row_j = LANES * (PHI + N * j) + i
            value = a1 * s[row_j + LANES * X1]
            if j == X2:
                value += a2
            value = fma(a3, s[row_j + LANES * X3], value)
            value = fma(a4, s[row_j + LANES * X4], value)
            value = fma(a5, s[row_j + LANES * TAU_K], value)
            if n > 5:
                value = fma(a6, s[row_j + LANES * TAU_ARM], value)
        if j == k:
            density = s[LANES * (DENSITY + k) + i]
            if k == TAU_K:
                density = tau_k_noise(density, s[LANES * OF_SPEED + i], s[LANES * (Z + X3) + i])
            value += half_dt * density
        s[LANES * (PRIOR + N * k) + LANES * j + i] = value
        s[LANES * (PRIOR + N * j) + LANES * k + i] = value


@jit
def predict(states: States, dt: float, u: float, load: float, p: Array, drive: Drive,
            s: Array) -> None:
    """
    Predict z and PRIOR of all lanes, as ekf.predict does.

    Args:
        states: process_model.markers.
        dt: length of the step, s.
        u: motor torque, N m.
        load: measured load on the arm, N m.
        p: packed parameters of any of the lanes.
        drive: see drive_of.
        s: the lanes, changed.

    """
    n = len(states)
    half = 0.5 * dt
    for i in range(LANES):
        for j in range(n):
            s[LANES * (HALF + j) + i] = half * s[LANES * (DENSITY + j) + i]
        s[LANES * (HALF + TAU_K) + i] = half * tau_k_noise(
            s[LANES * (DENSITY + TAU_K) + i], s[LANES * OF_SPEED + i], s[LANES * (Z + X3) + i])
    if p[STATISTICAL] > 0.0:
        for i in range(LANES):
            s[LANES * SHARPNESS + i] = softened_sharpness(
                p[ALPHA], s[LANES * (P + N * X3) + LANES * X3 + i])
    counted = substeps(dt, p[EIGENVALUE])
    h = dt / counted if counted > 1 else dt
    _rk4(states, True, u, load, h, drive, s)
    for _ in range(1, counted):
        _rk4(states, None, u, load, h, drive, s)
    for i in range(LANES):
        _phi_times_P(n, X1, s, i)
        _phi_times_P(n, X2, s, i)
        _phi_times_P(n, X3, s, i)
        _phi_times_P(n, X4, s, i)
        _phi_times_P(n, TAU_K, s, i)
    for i in range(LANES):
        _predicted(n, X1, half, s, i)
        _predicted(n, X2, half, s, i)
        _predicted(n, X3, half, s, i)
        _predicted(n, X4, half, s, i)
        _predicted(n, TAU_K, half, s, i)
        if n > 5:
            _predicted(n, TAU_ARM, half, s, i)


@jit_inline
def _updated(n: int, k: int, s: Array, i: int) -> None:
    """Write row and column `k` of P, Joseph's form; see ekf.update."""
    prior, first = LANES * (PRIOR + N * k) + i, LANES * (PRIOR + N * X1) + i
    second = LANES * (PRIOR + N * X2) + i
    k1, k2 = s[LANES * (GAIN_1 + k) + i], s[LANES * (GAIN_2 + k) + i]
    row = joseph(k, (k1, k2), (s[prior + LANES * X1], s[prior + LANES * X2]),
                 (s[first], s[first + LANES * X2], s[second + LANES * X2]),
                 (s[LANES * NOISE_1 + i], s[LANES * NOISE_2 + i]))
    for j in range(k + 1):
        value = joseph_element(
            k, s[prior + LANES * j], row, (s[first + LANES * j], s[second + LANES * j]),
            (s[LANES * (GAIN_1 + j) + i], s[LANES * (GAIN_2 + j) + i]))
        s[LANES * (P + N * k) + LANES * j + i] = value
        s[LANES * (P + N * j) + LANES * k + i] = value
        if j == k and not 0.0 < value < HUGE:
            s[LANES * BAD + i] = 1.0


@jit
def update(states: States, y1: float, y2: float, s: Array) -> None:
    """
    Update z and P of all lanes, as ekf.update does; a lane stays BAD once ekf.step would fail.

    Args:
        states: process_model.markers.
        y1: motor position, rad, finite.
        y2: arm position, rad, finite.
        s: the lanes, changed.

    """
    n = len(states)
    for i in range(LANES):
        s11 = s[LANES * (PRIOR + N * X1) + i] + s[LANES * NOISE_1 + i]
        s12 = s[LANES * (PRIOR + N * X1) + LANES * X2 + i]
        s22 = s[LANES * (PRIOR + N * X2) + LANES * X2 + i] + s[LANES * NOISE_2 + i]
        determinant = s11 * s22 - s12 * s12
        i11, i12, i22 = inverse(s11, s12, s22, determinant)
        e1, e2 = y1 - s[LANES * (Z + X1) + i], y2 - s[LANES * (Z + X2) + i]
        nis = mahalanobis(e1, e2, i11, i12, i22)
        bad = s[LANES * BAD + i]
        if not (determinant > 0.0 and nis < HUGE):
            bad = 1.0
        s[LANES * S11 + i], s[LANES * S22 + i] = s11, s22
        s[LANES * ERROR_1 + i], s[LANES * ERROR_2 + i] = e1, e2
        s[LANES * NIS + i], s[LANES * DETERMINANT + i] = nis, determinant
        for k in range(n):
            c1 = s[LANES * (PRIOR + N * k) + LANES * X1 + i]
            c2 = s[LANES * (PRIOR + N * k) + LANES * X2 + i]
            k1, k2 = c1 * i11 + c2 * i12, c1 * i12 + c2 * i22
            s[LANES * (GAIN_1 + k) + i], s[LANES * (GAIN_2 + k) + i] = k1, k2
            z = s[LANES * (Z + k) + i] + (k1 * e1 + k2 * e2)
            s[LANES * (Z + k) + i] = z
            if not abs(z) < HUGE:
                bad = 1.0
        s[LANES * BAD + i] = bad
    for i in range(LANES):
        _updated(n, X1, s, i)
        _updated(n, X2, s, i)
        _updated(n, X3, s, i)
        _updated(n, X4, s, i)
        _updated(n, TAU_K, s, i)
        if n > 5:
            _updated(n, TAU_ARM, s, i)
