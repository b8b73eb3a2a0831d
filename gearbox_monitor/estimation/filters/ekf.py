# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Extended Kalman filter with the exact tangent of the RK4 step and Joseph's update.

Optional: the friction linearised over the present uncertainty of the motor speed
(`friction_linearisation: statistical`).

Process noise enters in halves before and after the propagation (Strang), the trapezoid rule for
the integral of Phi Q Phi'; it needs no Phi, so every filter can share it.
"""
import math

from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, places, Reading, Scratch
from gearbox_monitor.estimation.process_model import (
    BESIDE, bound_curve, EIGENVALUE, N_LANE, noise, NUMERIC, propagate, propagate_numeric, R1, R2,
    softened_sharpness, STATISTICAL, USUAL, X3, X4)
from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.linalg import carry
from gearbox_monitor.kernels.types import Array, Four, Layout, Pair, Triple, unrolled, Vector
from gearbox_monitor.parameters import CURVES, RANDOM_WALK
from gearbox_monitor.plant.drive import ALPHA, ARM_ALPHA, substeps

LOG_TWO_PI = math.log(2.0 * math.pi)


@folded(*USUAL)
@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
         record: Vector) -> bool:
    """
    Predict over a step and update with its measurements: the signature of every filter.

    Args:
        layout: of the n states.
        belief: changed in place.
        reading: torques, held over the step, and positions at its end.
        p: process_model.pack [N_PACKED].
        scratch: of the size that the FilterKind states.
        record: row of filter_kind.record_size(n) numbers, written.

    Returns:
        False if the result is not finite or P has lost its positive diagonal; the belief is then
        unusable.

    """
    predict(layout, belief, reading, p, scratch, record)
    if not update(layout, belief, reading.y1, reading.y2, p, record):
        return False
    bound_curve(layout, belief.z, p)
    return healthy(layout, belief)


@inline
def predict(layout: Layout, belief: Belief, reading: Reading, p: Array, scratch: Scratch,
            record: Array) -> None:
    """
    Predict z and the record's P_pred and C; P stays.

    The arguments layout, belief, reading, p, scratch and record are as of step.
    """
    n, z, P, dt = layout.n, belief.z, belief.P, reading.dt
    at_z, at_P, at_cross, _, _, _, _, _, _ = places(n)
    phi = scratch.matrices[0]
    cross, P_pred = record[at_cross:at_cross + n * n], record[at_P:at_P + n * n]
    for i in unrolled(n):  # the first half
        record[at_z + i] = 0.5 * dt * noise(z, p, i)
    counted = substeps(dt, p[EIGENVALUE])
    motor, arm = p[ALPHA], p[ARM_ALPHA]
    if p[STATISTICAL] > 0.0:  # until the end of the propagation
        p[ALPHA] = softened_sharpness(motor, P[X3 * n + X3])
        p[ARM_ALPHA] = softened_sharpness(arm, P[X4 * n + X4])
    if layout.law and p[NUMERIC] > 0.0:
        rest = scratch.matrices[1:]
        propagate_numeric(layout, z, phi, (reading.u, reading.load), dt, counted, p,
                          rest.reshape(len(rest) * n * n)[:(n + N_LANE) * BESIDE])
    else:
        propagate(layout, z, phi, (reading.u, reading.load), dt, counted, p)
    if p[STATISTICAL] > 0.0:
        p[ALPHA], p[ARM_ALPHA] = motor, arm
    carry(layout, phi, P, record[at_z:at_z + n], cross, P_pred)
    for i in unrolled(n):
        P_pred[i * n + i] += 0.5 * dt * noise(z, p, i)
        record[at_z + i] = z[i]


@inline
def update(layout: Layout, belief: Belief, y1: float, y2: float, p: Array,
           record: Array) -> bool:
    """
    Update z with the measurements, and P from the record's P_pred, in Joseph's form.

    Args:
        layout: as of step.
        belief: as of step.
        p: as of step.
        record: as of step.
        y1: motor and arm position, rad; NaN = not measured.
        y2: motor and arm position, rad; NaN = not measured.

    Returns:
        False if S is not positive or the NIS overflows.

    """
    n, z, P = layout.n, belief.z, belief.P
    _, at_prior, _, at_z, at_P, at_innovation, at_S, at_K, at_scores = places(n)
    prior = record[at_prior:at_prior + n * n]
    r1, r2 = p[R1], p[R2]
    have1, have2 = math.isfinite(y1), math.isfinite(y2)
    s11, s12, s22 = prior[0] + r1, prior[1], prior[n + 1] + r2
    record[at_S], record[at_S + 1], record[at_S + 2] = s11, s12, s22
    record[at_innovation] = y1 - z[0] if have1 else math.nan
    record[at_innovation + 1] = y2 - z[1] if have2 else math.nan
    # Inverse of S over what was measured; zero elsewhere makes the gain's column zero.
    i11 = i12 = i22 = 0.0
    determinant = 1.0
    if have1 and have2:
        determinant = s11 * s22 - s12 * s12
        i11, i12, i22 = inverse(s11, s12, s22, determinant)
    elif have1:
        determinant = s11
        i11 = 1.0 / determinant
    elif have2:
        determinant = s22
        i22 = 1.0 / determinant
    if not determinant > 0.0:
        return False
    e1 = y1 - z[0] if have1 else 0.0
    e2 = y2 - z[1] if have2 else 0.0
    dof = (1.0 if have1 else 0.0) + (1.0 if have2 else 0.0)
    nis = mahalanobis(e1, e2, i11, i12, i22)
    if not math.isfinite(nis):
        return False
    record[at_scores] = nis
    record[at_scores + 1] = -0.5 * (nis + math.log(determinant) + dof * LOG_TWO_PI)
    record[at_scores + 2] = dof
    for i in unrolled(n):
        c1, c2 = prior[i * n], prior[i * n + 1]
        k1, k2 = c1 * i11 + c2 * i12, c1 * i12 + c2 * i22
        record[at_K + 2 * i], record[at_K + 2 * i + 1] = k1, k2
        z[i] += k1 * e1 + k2 * e2
        record[at_z + i] = z[i]
        row = joseph(i, (k1, k2), (c1, c2), (prior[0], prior[1], prior[n + 1]), (r1, r2))
        for j in unrolled(n):
            if j <= i:
                value = joseph_element(i, prior[i * n + j], row, (prior[j], prior[n + j]),
                                       (record[at_K + 2 * j], record[at_K + 2 * j + 1]))
                P[i * n + j], P[j * n + i] = value, value
                record[at_P + i * n + j], record[at_P + j * n + i] = value, value
    return True


@inline
def inverse(s11: float, s12: float, s22: float, determinant: float) -> Triple:
    """Return the inverse (i11, i12, i22) of S, given by s11, s12, s22 and its `determinant`."""
    scale = 1.0 / determinant
    return s22 * scale, -s12 * scale, s11 * scale


@inline
def mahalanobis(e1: float, e2: float, i11: float, i12: float, i22: float) -> float:
    """Return e' S^-1 e of e = (e1, e2), with the inverse of S, given by i11, i12, i22."""
    return e1 * (i11 * e1 + i12 * e2) + e2 * (i12 * e1 + i22 * e2)


# (I - K H) P (I - K H)' + K R K' = T + (K R - T H') K' with T = (I - K H) P. H picks the first two
# states, the rest of I - K H is I.

@inline
def joseph(i: int, gain: Pair, column: Pair, prior: Triple, r: Pair) -> Four:
    """
    Return (a, b, w1, w2), which all elements of a row of Joseph's update share.

    Args:
        i: number of the row.
        gain: row i of K.
        column: row i of the first two columns of the predicted P.
        prior: the elements 11, 12 and 22 of the predicted P.
        r: the diagonal of R.

    Returns:
        a, b: row i of the first two columns of I - K H; w1, w2: of K R - T H'.

    """
    a, b = (1.0 if i == 0 else 0.0) - gain[0], (1.0 if i == 1 else 0.0) - gain[1]
    t1 = (column[0] if i > 1 else -0.0) + a * prior[0] + b * prior[1]
    t2 = (column[1] if i > 1 else -0.0) + a * prior[1] + b * prior[2]
    return a, b, gain[0] * r[0] - t1, gain[1] * r[1] - t2


@inline
def joseph_element(i: int, prior: float, row: Four, column_j: Pair, gain: Pair) -> float:
    """
    Return the element (i, j) of the updated P.

    Args:
        i: number of the row.
        prior: the element of the predicted P.
        row: what joseph gave for row i.
        column_j: column j of the predicted P, its first two rows.
        gain: row j of K.

    """
    predicted = fma(row[1], column_j[1], fma(row[0], column_j[0], prior if i > 1 else -0.0))
    return fma(row[3], gain[1], fma(row[2], gain[0], predicted))


@inline
def healthy(layout: Layout, belief: Belief) -> bool:
    """Return True if z of the `belief` in `states` is finite and P has a positive diagonal."""
    n, z, P = layout.n, belief.z, belief.P
    for i in unrolled(n):
        if not (math.isfinite(z[i]) and P[i * n + i] > 0.0 and math.isfinite(P[i * n + i])):
            return False
    return True


FILTER = FilterKind(step, tau_k_models=(RANDOM_WALK, *CURVES))
