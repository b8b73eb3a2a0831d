# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What UKF and SRUKF share: sigma points, and the scaled unscented transform in factored form.

The points are z and z +- L_i / sqrt(W), L_i the columns of a factor of P, W = 1 / (alpha^2 (n +
kappa)); each weighs W / 2, and the centre 1 - n W for the mean and 2 - n W - alpha^2 + beta for
the covariance. With what a pair gives as a difference, d_i = (f+ - f-) / 2, and as a bend,
s_i = (f+ + f-) / 2 - f(z), the textbook's sums are, without approximation,

    mean        f(z) + m,   m = W sum s_i
    covariance  W sum d_i d_i' + W sum s_i s_i' + (beta - alpha^2) m m'
              = W sum d_i d_i' + W sum b_i b_i',   b_i = s_i - g sum s_j

with g n = 1 - sqrt(1 + (beta - alpha^2) n W): a sum of squares for all beta, kappa >= 0. So no
weight is negative, nothing is ever subtracted from a factor, and large weights do not cancel.
"""
import math

from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, places, Reading, Scratch
from gearbox_monitor.estimation.filters.ekf import healthy, update
from gearbox_monitor.estimation.process_model import (
    advance_beside, BESIDE, EIGENVALUE, N_LANE, noise, UKF_ALPHA, UKF_BETA, UKF_KAPPA, WALKS)
from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.linalg import add_transposed_product
from gearbox_monitor.kernels.types import Array, Layout, unrolled, Vector
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import substeps

N_LANES = 17  # matrices [n, n] that hold the lanes of advance_beside
# A centre weight below this makes the mean an extrapolation rather than an average.
NEGATIVE_WEIGHT = -10.0


def warnings(n: int, parameters: EstimatorParameters) -> list[str]:
    """Return warnings about the weights of `n` states with these `parameters`."""
    alpha, kappa = parameters.ukf_alpha, parameters.ukf_kappa
    centre = 1.0 - n / (alpha ** 2 * (n + kappa))
    if centre >= NEGATIVE_WEIGHT:
        return []
    return [f'ukf_alpha {alpha:g} gives the central sigma point the weight {centre:.3g}: the '
            'points are closer together than the belief is wide, and friction near standstill is '
            'extrapolated; 1 is advised (docs/filters.md)']


@inline
def cholesky(layout: Layout, a: Array, out: Array) -> bool:
    """
    Write the lower Cholesky factor of a matrix.

    Args:
        layout: of the n states.
        a: symmetric matrix [n * n].
        out: its factor [n * n], written.

    Returns:
        False if `a` is not positive definite.

    """
    n = layout.n
    # L D L' first, as no root is waited for: below the diagonal L D, above it L'.
    for j in unrolled(n):
        s = a[j * n + j]
        for k in unrolled(n):
            if k < j:
                s = fma(-out[j * n + k], out[k * n + j], s)
        if not s > 0.0:
            return False
        out[j * n + j] = s
        inverse = 1.0 / s
        for i in unrolled(n):
            if i > j:
                s = a[i * n + j]
                for k in unrolled(n):
                    if k < j:
                        s = fma(-out[i * n + k], out[k * n + j], s)
                out[i * n + j] = s
                out[j * n + i] = s * inverse
    for j in unrolled(n):
        root = math.sqrt(out[j * n + j])
        out[j * n + j] = root
        for i in unrolled(n):
            if i > j:
                out[i * n + j] = out[j * n + i] * root
                out[j * n + i] = 0.0
    return True


@inline
def transform(layout: Layout, z: Array, factor: Array, reading: Reading, p: Array, rows: Array,
              matrices: Array) -> None:
    """
    Carry a mean and a factor of its covariance through the drive (unscented transform).

    Args:
        layout: of the n states.
        z: mean [n]; becomes the predicted one.
        factor: lower Cholesky factor [n * n] of the covariance.
        reading: the time step and its torques.
        p: process_model.pack.
        rows: [>= 2 n, n]; the first 2 n are written so that rows' rows is the predicted covariance
            without process noise, pair differences first.
        matrices: scratch [N_LANES, n * n].

    """
    n, dt = layout.n, reading.dt
    lanes = matrices.reshape(N_LANES * n * n)[:(n + N_LANE) * BESIDE]
    counted = substeps(dt, p[EIGENVALUE])
    alpha2 = p[UKF_ALPHA] * p[UKF_ALPHA]
    spread = math.sqrt(alpha2 * (n + p[UKF_KAPPA]))
    root = 1.0 / spread
    weight = root * root
    # Rounding alone makes it negative, where the centre weighs nothing.
    shared = (1.0 - math.sqrt(max(1.0 + (p[UKF_BETA] - alpha2) * n * weight, 0.0))) / n
    for j in range(n):  # n points ahead, n behind, the centre, and idle ones
        at, centre = j * BESIDE, z[j]
        lanes[at:at + BESIDE] = centre
        for i in range(n):
            lanes[at + i] = centre + spread * factor[j * n + i]
            lanes[at + n + i] = centre - spread * factor[j * n + i]
    for _ in range(counted):
        advance_beside(layout, lanes, 2 * n + 1, None, (reading.u, reading.load, 0.0),
                       dt / counted, 1, p)
    for j in unrolled(n):
        at, centre = j * BESIDE, lanes[j * BESIDE + 2 * n]
        bends = 0.0
        for i in unrolled(n):
            plus, minus = lanes[at + i] - centre, lanes[at + n + i] - centre
            bend = 0.5 * (plus + minus)
            rows[i, j] = 0.5 * root * (plus - minus)
            rows[n + i, j] = bend
            bends += bend
        z[j] = centre + weight * bends
        for i in unrolled(n):
            rows[n + i, j] = root * (rows[n + i, j] - shared * bends)


@inline
def cross_covariance(layout: Layout, rows: Array, factor: Array, P: Array, slope: Array,
                     out: Array) -> None:
    """
    Write cov(z predicted, z before), by the slope of the statistical linearisation.

    Args:
        layout: as of transform.
        rows: as of transform.
        factor: of P with the first half of the process noise, as of transform.
        P: covariance before any process noise [n * n].
        slope: transposed, of the linearisation [n * n], written.
        out: receives the covariance [n * n].

    """
    n = layout.n
    for behind in unrolled(n):  # slope factor = (pair differences)'
        j = n - 1 - behind
        inverse = 1.0 / factor[j * n + j]
        for r in unrolled(n):
            s = rows[j, r]
            for k in unrolled(n):
                if k > j:
                    s -= slope[k * n + r] * factor[k * n + j]
            slope[j * n + r] = s * inverse
    out[:] = 0.0
    add_transposed_product(layout, slope, P, out)


@folded(*WALKS)
@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
         record: Vector) -> bool:
    """
    Predict over a step and update with its measurements.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    return (predict(layout, belief, reading, p, scratch, record)
            and update(layout, belief, reading.y1, reading.y2, p, record)
            and healthy(layout, belief))


@inline
def predict(layout: Layout, belief: Belief, reading: Reading, p: Array, scratch: Scratch,
            record: Array) -> bool:
    """
    Predict z and the record's P_pred and C by the unscented transform; P stays.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if P is not positive definite.

    """
    n, z, P, dt, matrices = layout.n, belief.z, belief.P, reading.dt, scratch.matrices
    at_z, at_P, at_cross, _, _, _, _, _, _ = places(n)
    factor, slope, rows = matrices[0], matrices[1], matrices[2:4].reshape(2 * n, n)
    cross, P_pred = record[at_cross:at_cross + n * n], record[at_P:at_P + n * n]
    slope[:] = P
    for i in range(n):
        slope[i * n + i] += 0.5 * dt * noise(z, p, i)
    if not cholesky(layout, slope, factor):
        return False
    transform(layout, z, factor, reading, p, rows, matrices[4:])
    cross_covariance(layout, rows, factor, P, slope, cross)
    record[at_z:at_z + n] = z
    P_pred[:] = 0.0
    for i in range(n):
        P_pred[i * n + i] = 0.5 * dt * noise(z, p, i)
    add_transposed_product(layout, matrices[2], matrices[2], P_pred)
    add_transposed_product(layout, matrices[3], matrices[3], P_pred)
    return True


FILTER = FilterKind(step, n_matrices=4 + N_LANES, warnings=warnings)
