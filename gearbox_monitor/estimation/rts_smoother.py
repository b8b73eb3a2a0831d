# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Rauch-Tung-Striebel over step records: the newest ones (fixed lag) or a whole recording.

The filtered tau_K lags by about 20 ms and therefore draws a hysteresis loop that is not there; the
smoothed one does not. A backward pass runs over a block, so its cost per sample stays bounded;
blocks can be chained backwards, from the belief at the seam.
"""
import math
from typing import NamedTuple

from gearbox_monitor.estimation.consider import variances_of
from gearbox_monitor.estimation.filter_kind import places, sensitivities
from gearbox_monitor.estimation.process_model import (
    motor_side, TAU_K_MODEL_STD, torque_of, USUAL, X1, X2, X3, X4)
from gearbox_monitor.kernels.kernel import apart, entry, folded, kernel
from gearbox_monitor.kernels.linalg import (
    add_product, multiply, solve_positive, transposed_multiply_symmetric)
from gearbox_monitor.kernels.types import Array, Layout, Matrix, Vector
from gearbox_monitor.parameters import CURVES, EstimatorParameters

# A smoother sees both sides of a sample: it needs less room for tau_K to wander than a filter
# (error -20 %), and friction at a standstill less steep (another -20 %).
Q_RATIO = 0.2
LAG = 0.5  # s, beyond which no sample tells more of an earlier one
# Columns of a smoothed row.
(S_TWIST, S_TWIST_RATE, S_TAU_K, S_TWIST_STD, S_TWIST_RATE_STD, S_TAU_K_STD,
 # ... arm position and speed, motor speed, and the motor torque over the step that led here.
 S_X2, S_X4, S_X3, S_U,
 # Standard deviations by noise alone: the smoother's own, with an exact model.
 S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD, S_TAU_K_NOISE_STD,
 # tau_K and the friction's error together: what motor torque and motion show, in which the load
 # on the arm has no part. Where that error is no state: tau_K.
 S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, N_SMOOTHED) = range(16)


class Span(NamedTuple):
    """Steps to smooth, `newest` back to `oldest`; those up to `keep_until` are written."""

    newest: int
    oldest: int
    keep_until: int


def smoother_parameters(parameters: EstimatorParameters) -> EstimatorParameters:
    """
    Return the `parameters` of a filter changed for smoothing a recording.

    With LAG and deviations of the filter alone, the spectral density of tau_K's noise times
    Q_RATIO, friction linearised statistically.
    """
    parameters = parameters.replace(
        friction_linearisation='statistical', smoother_lag=LAG, narrow_std=False)
    if parameters.tau_k_model in CURVES:  # no lag to make up for
        return parameters
    return parameters.replace(
        q_std_tau_k=Q_RATIO ** 0.5 * parameters.q_std_tau_k,
        q_std_tau_k_speed=Q_RATIO ** 0.5 * parameters.q_std_tau_k_speed)


@entry
@folded(*USUAL)
@apart
def smooth(layout: Layout, ring: Matrix, span: Span, p: Vector, z: Vector, matrices: Matrix,
           out: Matrix) -> None:
    """
    Smooth a span of steps backwards (Rauch, Tung and Striebel 1965).

    A singular P_pred ends the pass: the filtered values then stand in for earlier steps.

    Args:
        layout: of the n states.
        ring: step records [M, record_size(n, c)]; step k stands in row k % M. Their smoothed
            sensitivities are written, but for the oldest less the predicted ones.
        span: the steps to smooth and to write.
        p: process_model.pack.
        z: [n], the smoothed state of the oldest step is left here, and its covariance in
            matrices[0].
        matrices: scratch [>= 5, n * n].
        out: [>= span.keep_until - span.oldest + 1, N_SMOOTHED], one row for each step written.

    """
    n, rows = layout.n, ring.shape[0]
    newest, oldest, keep_until = span
    P, gain_t, factor, change, product = (
        matrices[0], matrices[1], matrices[2], matrices[3], matrices[4])
    at_pred, at_P_pred, at_cross, at_z, at_P, _, _, _, _ = places(n)
    count, at_s_pred, at_s, at_smoothed = sensitivities(n, ring.shape[1])
    last = ring[newest % rows]
    last[at_smoothed:at_smoothed + n * count] = last[at_s:at_s + n * count]
    z[:], P[:] = last[at_z:at_z + n], last[at_P:at_P + n * n]
    if newest <= keep_until:
        _write(layout, z, P, p, last, out[newest - oldest])
    for k in range(newest - 1, oldest - 1, -1):
        record, later = ring[k % rows], ring[(k + 1) % rows]
        factor[:] = later[at_P_pred:at_P_pred + n * n]
        for i in range(n * n):
            change[i] = P[i] - later[at_P_pred + i]
        # G' = P_pred^-1 C
        if solve_positive(layout, factor, later[at_cross:at_cross + n * n], gain_t):
            for i in range(n):
                z[i] -= later[at_pred + i]
            multiply(layout, change, gain_t, product)
            transposed_multiply_symmetric(layout, gain_t, product, P)
            for i in range(n * n):
                P[i] += record[at_P + i]
            for i in range(n):
                s = record[at_z + i]
                for m in range(n):
                    s += gain_t[m * n + i] * z[m]
                product[i] = s
            z[:] = product[:n]
            change_s = later[at_smoothed:at_smoothed + n * count]
            for i in range(n * count):
                change_s[i] -= later[at_s_pred + i]
                record[at_smoothed + i] = record[at_s + i]
            add_product(layout, change_s, gain_t, record[at_smoothed:at_smoothed + n * count])
        else:
            record[at_smoothed:at_smoothed + n * count] = record[at_s:at_s + n * count]
            z[:], P[:] = record[at_z:at_z + n], record[at_P:at_P + n * n]
        if k <= keep_until:
            _write(layout, z, P, p, record, out[k - oldest])


@kernel
def _write(layout: Layout, z: Array, P: Array, p: Array, record: Array, row: Array) -> None:
    n = layout.n
    count, _, _, at_smoothed = sensitivities(n, record.shape[0])
    of_twist, of_rate, of_torque = variances_of(layout, z, record, (count, at_smoothed), p)
    row[S_TWIST] = z[X1] - z[X2]
    row[S_TWIST_RATE] = z[X3] - z[X4]
    row[S_TAU_K], variance = torque_of(layout, z, P, p)
    noise = max(P[X1 * n + X1] + P[X2 * n + X2] - 2.0 * P[X1 * n + X2], 0.0)
    row[S_TWIST_NOISE_STD], row[S_TWIST_STD] = math.sqrt(noise), math.sqrt(noise + of_twist)
    noise = max(P[X3 * n + X3] + P[X4 * n + X4] - 2.0 * P[X3 * n + X4], 0.0)
    row[S_TWIST_RATE_NOISE_STD] = math.sqrt(noise)
    row[S_TWIST_RATE_STD] = math.sqrt(noise + of_rate)
    row[S_TAU_K_NOISE_STD] = math.sqrt(max(variance, 0.0))
    row[S_TAU_K_STD] = math.sqrt(
        max(variance, 0.0) + of_torque + p[TAU_K_MODEL_STD] * p[TAU_K_MODEL_STD])
    row[S_MOTOR_SIDE], variance = motor_side(z, P, (row[S_TAU_K], variance), p)
    row[S_MOTOR_SIDE_NOISE_STD] = math.sqrt(max(variance, 0.0))
    row[S_X2], row[S_X4], row[S_X3] = z[X2], z[X4], z[X3]
    row[S_U] = record[-1]
