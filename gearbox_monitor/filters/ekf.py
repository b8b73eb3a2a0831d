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
Extended Kalman filter with the exact tangent of the RK4 step and Joseph's update.

Optional: the tangent by forward differences (`ekf_jacobian: numeric`), and the friction linearised
over the present uncertainty of the motor speed (`friction_linearisation: statistical`).

Process noise enters in halves before and after the propagation (Strang), the trapezoid rule for
the integral of Phi Q Phi'; it needs no Phi, so every filter can share it.
"""
import math

from gearbox_monitor.drive.model import substeps
from gearbox_monitor.filters.linalg import multiply, multiply_transposed, symmetrise
from gearbox_monitor.filters.process import (
    EIGENVALUE, finite, noise, NUMERIC, propagate, propagate_numeric, R1, R2, softened,
    STATISTICAL, X3)
from gearbox_monitor.filters.record import correction, predicted, updated
from gearbox_monitor.jit import jit

LOG_TWO_PI = math.log(2.0 * math.pi)
N_VECTORS, N_MATRICES = 4, 4


def memory_size(n):
    """Return how many numbers the filter carries besides z [n] and P [n, n]."""
    return 0


@jit
def step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record):
    """
    Predict over `dt` s and update with y = (y1, y2); a NaN was not measured.

    z [n], P [n, n]: belief, changed in place. memory [memory_size(n)]: what else the filter
    carries; all zero at a start and after a change of parameters, then to be made from z, P and p.
    u, load: motor torque and known arm load (N m), held over the step. p: process.pack. vectors
    [N_VECTORS, n], matrices [N_MATRICES, n, n]: scratch. record: row of record.record_size(n),
    written. Returns False when the result is not finite or P has lost its positive diagonal (z, P
    are then unusable).
    """
    n = z.shape[0]
    predict(z, P, dt, u, load, p, vectors, matrices, record)
    return update(z, P, y1, y2, p, matrices, record) and healthy(z, P, n)


@jit
def predict(z, P, dt, u, load, p, vectors, matrices, record):
    """Predict over `dt` s; arguments as of step."""
    n = z.shape[0]
    z_pred, P_pred, cross = predicted(record, n)
    phi, product = matrices[3], matrices[0]
    for i in range(n):
        z_pred[i] = 0.5 * dt * noise(z, p, i)  # for the first half, which is due below
    counted = substeps(dt, p[EIGENVALUE])
    if p[STATISTICAL] > 0.0:
        p = softened(p, P[X3, X3])
    if p[NUMERIC] > 0.0:
        propagate_numeric(z, phi, u, load, dt, counted, p, vectors)
    else:
        propagate(z, phi, u, load, dt, counted, p, vectors, matrices)
    multiply(phi, P, cross)
    for i in range(n):
        P[i, i] += z_pred[i]
    multiply(phi, P, product)
    multiply_transposed(product, phi, P)
    for i in range(n):
        P[i, i] += 0.5 * dt * noise(z, p, i)
    symmetrise(P)
    for i in range(n):
        z_pred[i] = z[i]
        for j in range(n):
            P_pred[i, j] = P[i, j]


@jit
def update(z, P, y1, y2, p, matrices, record):
    """Update with y; arguments as of step. False when S is not positive or the NIS overflows."""
    n = z.shape[0]
    innovation, S, K, scores = correction(record, n)
    z_out, P_out = updated(record, n)
    r1, r2 = p[R1], p[R2]
    have1, have2 = math.isfinite(y1), math.isfinite(y2)
    innovation[0] = y1 - z[0] if have1 else math.nan
    innovation[1] = y2 - z[1] if have2 else math.nan
    S[0], S[1], S[2] = P[0, 0] + r1, P[0, 1], P[1, 1] + r2
    # Inverse of S over what was measured; zero elsewhere makes the gain's column zero.
    i11 = i12 = i22 = 0.0
    determinant = 1.0
    if have1 and have2:
        determinant = S[0] * S[2] - S[1] * S[1]
        i11, i12, i22 = S[2] / determinant, -S[1] / determinant, S[0] / determinant
    elif have1:
        determinant = S[0]
        i11 = 1.0 / determinant
    elif have2:
        determinant = S[2]
        i22 = 1.0 / determinant
    if not determinant > 0.0:
        return False
    e1 = innovation[0] if have1 else 0.0
    e2 = innovation[1] if have2 else 0.0
    dof = (1.0 if have1 else 0.0) + (1.0 if have2 else 0.0)
    nis = e1 * (i11 * e1 + i12 * e2) + e2 * (i12 * e1 + i22 * e2)
    if not math.isfinite(nis):
        return False
    scores[0] = nis
    scores[1] = -0.5 * (nis + math.log(determinant) + dof * LOG_TWO_PI)
    scores[2] = dof
    factor, product = matrices[0], matrices[1]
    for i in range(n):
        K[i, 0] = P[i, 0] * i11 + P[i, 1] * i12
        K[i, 1] = P[i, 0] * i12 + P[i, 1] * i22
        z[i] += K[i, 0] * e1 + K[i, 1] * e2
        for j in range(n):
            factor[i, j] = 1.0 if i == j else 0.0
        factor[i, 0] -= K[i, 0]
        factor[i, 1] -= K[i, 1]
    multiply(factor, P, product)
    multiply_transposed(product, factor, P)
    for i in range(n):
        for j in range(n):
            P[i, j] += K[i, 0] * r1 * K[j, 0] + K[i, 1] * r2 * K[j, 1]
    symmetrise(P)
    for i in range(n):
        z_out[i] = z[i]
        for j in range(n):
            P_out[i, j] = P[i, j]
    return True


@jit
def healthy(z, P, n):
    """Return True when `z` [n] is finite and `P` [n, n] has a finite, positive diagonal."""
    if not finite(z):
        return False
    for i in range(n):
        if not (P[i, i] > 0.0 and math.isfinite(P[i, i])):
            return False
    return True
