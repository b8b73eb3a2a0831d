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
Square-root unscented Kalman filter: the factor L of P = L L' is carried, P is never factored.

Time and measurement update are in array form (QR by Householder reflections), without Cholesky
downdates: what those subtract is where float32, or a very small R, breaks a filter. It estimates
exactly what the UKF does. `srukf_precision: float32` keeps mean, sigma points and factor in single
precision, as a small controller would.
"""
import math

import numpy as np

from gearbox_monitor.filters import sigma
from gearbox_monitor.filters.ekf import healthy, LOG_TWO_PI
from gearbox_monitor.filters.process import noise, R1, R2, SINGLE
from gearbox_monitor.filters.record import correction, predicted, updated
from gearbox_monitor.filters.sigma import cholesky, cross_covariance, transform
from gearbox_monitor.jit import jit

# Of these, all but the last matrix exist a second time in float32 when that is chosen.
N_VECTORS, N_MATRICES = 5, 7
warnings = sigma.warnings


def memory_size(n):
    """Return how many numbers the filter carries besides z [n] and P [n, n]: the factor."""
    return n * n


@jit
def step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, record):
    """Predict over `dt` s and update with y = (y1, y2); see ekf.step. memory: L, row by row."""
    n = z.shape[0]
    if p[SINGLE] > 0.0:
        return _step(z, P, memory, dt, u, load, y1, y2, p, np.empty((N_VECTORS, n), np.float32),
                     np.empty((N_MATRICES - 1, n, n), np.float32), matrices[N_MATRICES - 1],
                     record)
    return _step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices,
                 matrices[N_MATRICES - 1], record)


@jit
def _step(z, P, memory, dt, u, load, y1, y2, p, vectors, matrices, slope, record):
    """Do the step in the precision of `vectors` and `matrices`."""
    n = z.shape[0]
    z_pred, P_pred, cross = predicted(record, n)
    z_out, P_out = updated(record, n)
    mean, factor = vectors[N_VECTORS - 1], matrices[0]
    if memory[0] == 0.0:
        if not cholesky(P, factor):
            return False
    else:
        for i in range(n):
            for j in range(n):
                factor[i, j] = memory[i * n + j]
    for i in range(n):
        mean[i] = z[i]
    # First half of the process noise: [L'; sqrt(Q / 2)] -> upper triangle
    rows = matrices[1:4].reshape(3 * n, n)
    _upper(factor, rows)
    _noise(rows[n:], mean, dt, p)
    triangularise(rows[:2 * n], n, 0, n)
    _lower(rows, factor)
    # Through the drive, and the second half
    transform(mean, factor, dt, u, load, p, vectors, rows)
    cross_covariance(rows, factor, P, slope, cross)
    _noise(rows[2 * n:], mean, dt, p)
    triangularise(rows, n, 2 * n, 2 * n)
    _lower(rows, factor)
    _square(factor, P_pred)
    for i in range(n):
        z_pred[i] = mean[i]
    array = matrices[4:6].reshape(2 * n * n)[:4 * (n + 2)].reshape(4, n + 2)
    if not _update(mean, factor, P_pred, y1, y2, p, array, record):
        return False
    _square(factor, P)
    for i in range(n):
        z[i] = mean[i]
        z_out[i] = z[i]
        for j in range(n):
            P_out[i, j] = P[i, j]
            memory[i * n + j] = factor[i, j]
    return healthy(z, P, n)


@jit
def _update(mean, factor, P_pred, y1, y2, p, array, record):
    """
    Update with what was measured: [[sqrt R, 0], [(H L)', L']] -> [[Sy', Kbar'], [0, L+']].

    H picks the first two states, so only the first two rows of L' take part: array [4, n + 2].
    False when the NIS overflows.
    """
    n = mean.shape[0]
    innovation, S, K, scores = correction(record, n)
    have1, have2 = math.isfinite(y1), math.isfinite(y2)
    innovation[0] = y1 - mean[0] if have1 else math.nan
    innovation[1] = y2 - mean[1] if have2 else math.nan
    S[0], S[1], S[2] = P_pred[0, 0] + p[R1], P_pred[0, 1], P_pred[1, 1] + p[R2]
    # A measurement that is missing has a unit variance of its own and no part in the state.
    array[0, 0], array[0, 1] = math.sqrt(p[R1]) if have1 else 1.0, 0.0
    array[1, 0], array[1, 1] = 0.0, math.sqrt(p[R2]) if have2 else 1.0
    for i in range(2):
        array[2 + i, 0] = factor[0, i] if have1 else 0.0
        array[2 + i, 1] = factor[1, i] if have2 else 0.0
        for j in range(n):
            array[i, 2 + j] = 0.0
            array[2 + i, 2 + j] = factor[j, i]
    m = array.shape[0]
    triangularise(array, m - 1, m, m)
    s11, s21, s22 = array[0, 0], array[0, 1], array[1, 1]
    white1 = innovation[0] / s11 if have1 else 0.0
    white2 = ((innovation[1] if have2 else 0.0) - s21 * white1) / s22 if have2 else 0.0
    nis = white1 * white1 + white2 * white2
    if not math.isfinite(nis):
        return False
    dof = (1.0 if have1 else 0.0) + (1.0 if have2 else 0.0)
    scores[0] = nis
    scores[1] = -0.5 * (nis + dof * LOG_TWO_PI) - math.log(abs(s11)) - math.log(abs(s22))
    scores[2] = dof
    for i in range(n):
        mean[i] += array[0, 2 + i] * white1 + array[1, 2 + i] * white2
        K[i, 1] = array[1, 2 + i] / s22
        K[i, 0] = (array[0, 2 + i] - K[i, 1] * s21) / s11
        factor[i, 0] = array[2, 2 + i]
        if i > 0:
            factor[i, 1] = array[3, 2 + i]
    return True


@jit
def triangularise(a, columns, dense, tail):
    """
    Make the first `columns` columns of `a` [m, n] upper triangular by Householder reflections.

    Below the diagonal, column j may hold numbers in rows < dense and in rows tail .. tail + j (a
    diagonal block). What then stands below the diagonal is left over and means nothing.
    """
    m, n = a.shape
    for j in range(columns):
        top, end = max(j + 1, dense), min(tail + j + 1, m)
        pivot = a[j, j]
        s = pivot * pivot
        for i in range(j + 1, top):
            s += a[i, j] * a[i, j]
        for i in range(tail, end):
            s += a[i, j] * a[i, j]
        norm = math.sqrt(s)
        if not norm > abs(pivot):  # nothing below
            continue
        if pivot > 0.0:
            norm = -norm
        head = pivot - norm
        scale = head * norm
        for c in range(j + 1, n):
            t = head * a[j, c]
            for i in range(j + 1, top):
                t += a[i, j] * a[i, c]
            for i in range(tail, end):
                t += a[i, j] * a[i, c]
            t /= scale
            a[j, c] += t * head
            for i in range(j + 1, top):
                a[i, c] += t * a[i, j]
            for i in range(tail, end):
                a[i, c] += t * a[i, j]
        a[j, j] = norm


@jit
def _upper(lower, out):
    """Write the transpose of the triangle `lower` [n, n] into the first rows of `out`."""
    n = lower.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = lower[j, i]


@jit
def _lower(upper, out):
    """Write the transpose of the triangle that `upper` starts with into `out` [n, n]."""
    n = out.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = upper[j, i] if j <= i else 0.0


@jit
def _noise(rows, z, dt, p):
    """Write the root of half the process noise of `dt` s at `z` [n] into rows[:n]."""
    n = z.shape[0]
    for i in range(n):
        for j in range(n):
            rows[i, j] = 0.0
        rows[i, i] = math.sqrt(0.5 * dt * noise(z, p, i))


@jit
def _square(factor, out):
    """Write L L' into `out` [n, n]."""
    n = factor.shape[0]
    for i in range(n):
        for j in range(i + 1):
            s = 0.0
            for k in range(j + 1):
                s += factor[i, k] * factor[j, k]
            out[i, j] = s
            out[j, i] = s
