# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Unscented Kalman filter, scaled; by default alpha = 1, beta = 2, kappa = 0.

The measurement is linear in the state, so redrawing the points before it gives exactly the linear
update, which is the EKF's (in Joseph's form).
"""
from gearbox_monitor.estimation import sigma_points
from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, Reading, Scratch
from gearbox_monitor.estimation.filters.ekf import healthy, update
from gearbox_monitor.estimation.process_model import noise, WALKS
from gearbox_monitor.estimation.sigma_points import cholesky, cross_covariance, N_LANES, transform
from gearbox_monitor.estimation.step_record import places
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.linalg import add_transposed_product
from gearbox_monitor.kernels.types import Array, Layout, Vector


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
    for i in range(n):
        for j in range(n):
            slope[i * n + j] = P[i * n + j]
        slope[i * n + i] += 0.5 * dt * noise(z, p, i)
    if not cholesky(layout, slope, factor):
        return False
    transform(layout, z, factor, reading, p, rows, matrices[4:])
    cross_covariance(layout, rows, factor, P, slope, cross)
    for i in range(n):
        record[at_z + i] = z[i]
        for j in range(n):
            P_pred[i * n + j] = 0.5 * dt * noise(z, p, i) if i == j else 0.0
    flat = matrices[2:4].reshape(2 * n * n)
    add_transposed_product(layout, flat, flat, 2 * n, P_pred)
    return True


FILTER = FilterKind(step, n_matrices=4 + N_LANES, warnings=sigma_points.warnings)
