# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Square-root unscented Kalman filter: the factor L of P = L L' is carried, P is never factored.

Time and measurement update are in array form (QR by Householder reflections), without Cholesky
downdates: what those subtract is where a tiny R breaks a filter. It estimates exactly what the UKF
does.
"""
import math

from gearbox_monitor.estimation.filter_kind import Belief, FilterKind, places, Reading, Scratch
from gearbox_monitor.estimation.filters import ukf
from gearbox_monitor.estimation.filters.ekf import healthy, LOG_TWO_PI
from gearbox_monitor.estimation.filters.ukf import cholesky, cross_covariance, N_LANES, transform
from gearbox_monitor.estimation.process_model import noise, R1, R2, WALKS
from gearbox_monitor.kernels.kernel import apart, folded, inline
from gearbox_monitor.kernels.types import Array, Layout, Vector

N_MATRICES = 7 + N_LANES


def memory_size(n: int) -> int:
    """Return the size of the memory with `n` states: it holds the factor L, row by row."""
    return n * n


@folded(*WALKS)
@apart
def step(layout: Layout, belief: Belief, reading: Reading, p: Vector, scratch: Scratch,
         record: Vector) -> bool:
    """
    Predict over a step and update with its measurements; the memory holds L.

    The arguments layout, belief, reading, p, scratch and record are as of ekf.step.

    Returns:
        False if the belief is unusable.

    """
    n, dt = layout.n, reading.dt
    (z, P, memory), (vectors, matrices) = belief, scratch
    at_z, at_P, at_cross, at_z_out, at_P_out, _, _, _, _ = places(n)
    mean, factor = vectors[0], matrices[0]
    if memory[0] == 0.0:
        if not cholesky(layout, P, factor):
            return False
    else:
        factor[:] = memory
    mean[:] = z
    # First half of the process noise: [L'; sqrt(Q / 2)] -> upper triangle
    rows = matrices[1:4].reshape(3 * n, n)
    _upper(layout, factor, rows)
    _noise(layout, rows[n:], mean, dt, p)
    triangularise(rows[:2 * n], n, 0, n)
    _lower(layout, rows, factor)
    # Through the drive, and the second half
    transform(layout, mean, factor, reading, p, rows, matrices[7:])
    cross_covariance(layout, rows, factor, P, matrices[6], record[at_cross:at_cross + n * n])
    _noise(layout, rows[2 * n:], mean, dt, p)
    triangularise(rows, n, 2 * n, 2 * n)
    _lower(layout, rows, factor)
    _square(layout, factor, record, at_P)
    record[at_z:at_z + n] = mean
    array = matrices[4:6].reshape(2 * n * n)[:4 * (n + 2)].reshape(4, n + 2)
    if not _update(layout, mean, factor, reading.y1, reading.y2, p, array, record):
        return False
    _square(layout, factor, P, 0)
    z[:] = mean
    memory[:] = factor
    record[at_z_out:at_z_out + n] = z
    record[at_P_out:at_P_out + n * n] = P
    return healthy(layout, belief)


@inline
def _update(layout: Layout, mean: Array, factor: Array, y1: float, y2: float, p: Array,
            array: Array, record: Array) -> bool:
    """
    Update with what was measured: [[sqrt R, 0], [(H L)', L']] -> [[Sy', Kbar'], [0, L+']].

    H picks the first two states, so only the first two rows of L' take part: array [4, n + 2].
    The predicted covariance stands in the record. False when the NIS overflows.
    """
    n = layout.n
    _, at_P, _, _, _, at_innovation, at_S, at_K, at_scores = places(n)
    have1, have2 = math.isfinite(y1), math.isfinite(y2)
    e1, e2 = y1 - mean[0] if have1 else math.nan, y2 - mean[1] if have2 else math.nan
    record[at_innovation], record[at_innovation + 1] = e1, e2
    record[at_S], record[at_S + 1] = record[at_P] + p[R1], record[at_P + 1]
    record[at_S + 2] = record[at_P + n + 1] + p[R2]
    # A measurement that is missing has a unit variance of its own and no part in the state.
    array[0, 0], array[0, 1] = math.sqrt(p[R1]) if have1 else 1.0, 0.0
    array[1, 0], array[1, 1] = 0.0, math.sqrt(p[R2]) if have2 else 1.0
    for i in range(2):
        array[2 + i, 0] = factor[i] if have1 else 0.0
        array[2 + i, 1] = factor[n + i] if have2 else 0.0
        for j in range(n):
            array[i, 2 + j] = 0.0
            array[2 + i, 2 + j] = factor[j * n + i]
    m = array.shape[0]
    triangularise(array, m - 1, m, m)
    s11, s21, s22 = array[0, 0], array[0, 1], array[1, 1]
    white1 = e1 / s11 if have1 else 0.0
    white2 = (e2 - s21 * white1) / s22 if have2 else 0.0
    nis = white1 * white1 + white2 * white2
    if not math.isfinite(nis):
        return False
    dof = (1.0 if have1 else 0.0) + (1.0 if have2 else 0.0)
    record[at_scores] = nis
    record[at_scores + 1] = (-0.5 * (nis + dof * LOG_TWO_PI) - math.log(abs(s11))
                             - math.log(abs(s22)))
    record[at_scores + 2] = dof
    for i in range(n):
        mean[i] += array[0, 2 + i] * white1 + array[1, 2 + i] * white2
        k2 = array[1, 2 + i] / s22
        record[at_K + 2 * i], record[at_K + 2 * i + 1] = (array[0, 2 + i] - k2 * s21) / s11, k2
        factor[i * n] = array[2, 2 + i]
        if i > 0:
            factor[i * n + 1] = array[3, 2 + i]
    return True


@inline
def triangularise(a: Array, columns: int, dense: int, tail: int) -> None:
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


@inline
def _upper(layout: Layout, lower: Array, out: Array) -> None:
    """Write the transpose of the triangle `lower` [n * n] into the first rows of `out`."""
    n = layout.n
    for i in range(n):
        for j in range(n):
            out[i, j] = lower[j * n + i]


@inline
def _lower(layout: Layout, upper: Array, out: Array) -> None:
    """Write the transpose of the triangle that `upper` starts with into `out` [n * n]."""
    n = layout.n
    for i in range(n):
        for j in range(n):
            out[i * n + j] = upper[j, i] if j <= i else 0.0


@inline
def _noise(layout: Layout, rows: Array, z: Array, dt: float, p: Array) -> None:
    """Write the root of half the process noise of `dt` s at `z` [n] into rows[:n]."""
    n = layout.n
    for i in range(n):
        for j in range(n):
            rows[i, j] = 0.0
        rows[i, i] = math.sqrt(0.5 * dt * noise(z, p, i))


@inline
def _square(layout: Layout, factor: Array, out: Array, at: int) -> None:
    """Write L L' [n, n] into `out` from place `at` on."""
    n = layout.n
    for i in range(n):
        for j in range(i + 1):
            s = 0.0
            for k in range(j + 1):
                s += factor[i * n + k] * factor[j * n + k]
            out[at + i * n + j], out[at + j * n + i] = s, s


FILTER = FilterKind(step, n_matrices=N_MATRICES, memory_size=memory_size,
                    warnings=ukf.warnings)
