# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Products of small matrices for kernels.

Matrices [n * n], row by row. Plain loops beat BLAS calls twelvefold at this size.
"""
import math
from typing import TypeAlias

from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import inline, kernel
from gearbox_monitor.kernels.types import Array, Layout

Seven: TypeAlias = tuple[float, float, float, float, float, float, float]
Eleven: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float,
                          float]
ZEROS: Eleven = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inline
def multiply(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """
    Write a b into `out`; all [n * n], row by row.

    layout: of the n states.
    """
    n = layout.n
    if n > 7:
        for i in range(n):
            for j in range(n):
                out[i * n + j] = 0.0
            for k in range(n):
                v = a[i * n + k]
                for j in range(n):
                    out[i * n + j] = fma(v, b[k * n + j], out[i * n + j])
        return
    for i in range(n):
        s0, s1, s2, s3, s4, s5, s6 = _row(n, -1, a, i, b)
        at = i * n
        out[at], out[at + 1], out[at + 2], out[at + 3], out[at + 4] = s0, s1, s2, s3, s4
        if n > 5:
            out[at + 5] = s5
        if n > 6:
            out[at + 6] = s6


@inline
def _row(n: int, unit: int, a: Array, i: int, b: Array) -> Seven:
    """
    Return row `i` of a b, zeros behind it; column `unit` of `a` is that of the unit matrix.

    Sums stand in variables: the compiler cannot know that what is written to is neither `a`
    nor `b`.
    """
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = 0.0
    for k in range(n):
        v, at = a[i * n + k], k * n
        if k != unit or i == unit:
            s0 = fma(v, b[at], s0)
            s1 = fma(v, b[at + 1], s1)
            s2 = fma(v, b[at + 2], s2)
            s3 = fma(v, b[at + 3], s3)
            s4 = fma(v, b[at + 4], s4)
            if n > 5:
                s5 = fma(v, b[at + 5], s5)
            if n > 6:
                s6 = fma(v, b[at + 6], s6)
    return s0, s1, s2, s3, s4, s5, s6


@inline
def multiply_symmetric(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """Write a b' into `out`, known to be symmetric; all [n * n]; `layout` of n states."""
    n = layout.n
    for i in range(n):
        s0 = s1 = s2 = s3 = s4 = s5 = s6 = 0.0
        for k in range(n):
            v = a[i * n + k]
            s0 = fma(v, b[k], s0)
            s1 = fma(v, b[n + k], s1)
            s2 = fma(v, b[2 * n + k], s2)
            s3 = fma(v, b[3 * n + k], s3)
            s4 = fma(v, b[4 * n + k], s4)
            if n > 5:
                s5 = fma(v, b[5 * n + k], s5)
            if n > 6:
                s6 = fma(v, b[6 * n + k], s6)
        # The compiler drops the sums that no element of the lower triangle needs.
        _mirrored(out, n, i, 0, s0)
        _mirrored(out, n, i, 1, s1)
        _mirrored(out, n, i, 2, s2)
        _mirrored(out, n, i, 3, s3)
        _mirrored(out, n, i, 4, s4)
        _mirrored(out, n, i, 5, s5)
        _mirrored(out, n, i, 6, s6)


@inline
def carry(layout: Layout, phi: Array, P: Array, half: Array, cross: Array,
          out: Array) -> None:
    """
    Write phi P into `cross` and (phi P + phi diag(half)) phi' into `out`; half [n].

    Row by row: what a row needs stays in registers. Without load and curve, the second
    column of phi is that of the unit matrix.
    """
    n = layout.n
    if layout.curve >= 0 and n > 5:
        _carry_curve(layout.curve, n, phi, P, half, cross, out)
        return
    full = layout.loaded or layout.curve >= 0
    for i in range(n):
        s0, s1, s2, s3, s4, s5, s6 = _row(n, -1 if full else 1, phi, i, P)
        at = i * n
        cross[at], cross[at + 1], cross[at + 2], cross[at + 3] = s0, s1, s2, s3
        cross[at + 4] = s4
        s0, s1 = fma(phi[at], half[0], s0), fma(phi[at + 1], half[1], s1)
        s2, s3 = fma(phi[at + 2], half[2], s2), fma(phi[at + 3], half[3], s3)
        s4 = fma(phi[at + 4], half[4], s4)
        if n > 5:
            cross[at + 5] = s5
            s5 = fma(phi[at + 5], half[5], s5)
        if n > 6:
            cross[at + 6] = s6
            s6 = fma(phi[at + 6], half[6], s6)
        for j in range(n):
            at = j * n
            value = s0 * phi[at]
            if full or j == 1:
                value = fma(s1, phi[at + 1], value)
            value = fma(s4, phi[at + 4], fma(s3, phi[at + 3], fma(s2, phi[at + 2], value)))
            if n > 5:
                value = fma(s5, phi[at + 5], value)
            if n > 6:
                value = fma(s6, phi[at + 6], value)
            _mirrored(out, n, i, j, value)


@inline
def _carry_curve(curve: int, n: int, phi: Array, P: Array, half: Array,
                 cross: Array, out: Array) -> None:
    """
    Do as carry for `n` states of which `curve` are those of a curve.

    Rows of phi that are those of the unit matrix cost nothing: tau_K, and what is learnt of
    the curve, behind its memory.
    """
    memory = n - curve
    for i in range(n):
        if not _moves(i, memory):
            for j in range(n):
                cross[i * n + j] = out[i * n + j] = P[i * n + j]
            out[i * n + i] += half[i]
    for i in range(n):
        if _moves(i, memory):
            at = i * n
            row = ZEROS
            for k in range(n):
                row = _fused(n, phi[at + k], P, k * n, row)
            _put(n, row, cross, at)
            row = _weighted(n, phi, at, half, row)
            _put(n, row, out, at)
            for j in range(n):
                if not _moves(j, memory):
                    out[j * n + i] = out[at + j]
                elif j <= i:
                    _mirrored(out, n, i, j, _product(n, row, phi, j * n))


@inline
def _moves(i: int, memory: int) -> bool:
    """Return whether row `i` of phi is none of the unit matrix; memory: place of its state."""
    return i < 4 or 4 < i <= memory


@inline
def _fused(n: int, v: float, b: Array, at: int, row: Eleven) -> Eleven:
    """Return `row` + v times the `n` numbers at `at` of b."""
    return (
        fma(v, b[at], row[0]),
        fma(v, b[at + 1], row[1]),
        fma(v, b[at + 2], row[2]),
        fma(v, b[at + 3], row[3]),
        fma(v, b[at + 4], row[4]),
        fma(v, b[at + 5], row[5]) if n > 5 else 0.0,
        fma(v, b[at + 6], row[6]) if n > 6 else 0.0,
        fma(v, b[at + 7], row[7]) if n > 7 else 0.0,
        fma(v, b[at + 8], row[8]) if n > 8 else 0.0,
        fma(v, b[at + 9], row[9]) if n > 9 else 0.0,
        fma(v, b[at + 10], row[10]) if n > 10 else 0.0)


@inline
def _added(n: int, v: float, b: Array, at: int, row: Eleven) -> Eleven:
    """Do as _fused, but round each product."""
    return (
        row[0] + v * b[at],
        row[1] + v * b[at + 1],
        row[2] + v * b[at + 2],
        row[3] + v * b[at + 3],
        row[4] + v * b[at + 4],
        row[5] + v * b[at + 5] if n > 5 else 0.0,
        row[6] + v * b[at + 6] if n > 6 else 0.0,
        row[7] + v * b[at + 7] if n > 7 else 0.0,
        row[8] + v * b[at + 8] if n > 8 else 0.0,
        row[9] + v * b[at + 9] if n > 9 else 0.0,
        row[10] + v * b[at + 10] if n > 10 else 0.0)


@inline
def _weighted(n: int, phi: Array, at: int, half: Array, row: Eleven) -> Eleven:
    """Return `row` + the `n` numbers at `at` of phi, each times that of `half`."""
    return (
        fma(phi[at], half[0], row[0]),
        fma(phi[at + 1], half[1], row[1]),
        fma(phi[at + 2], half[2], row[2]),
        fma(phi[at + 3], half[3], row[3]),
        fma(phi[at + 4], half[4], row[4]),
        fma(phi[at + 5], half[5], row[5]) if n > 5 else 0.0,
        fma(phi[at + 6], half[6], row[6]) if n > 6 else 0.0,
        fma(phi[at + 7], half[7], row[7]) if n > 7 else 0.0,
        fma(phi[at + 8], half[8], row[8]) if n > 8 else 0.0,
        fma(phi[at + 9], half[9], row[9]) if n > 9 else 0.0,
        fma(phi[at + 10], half[10], row[10]) if n > 10 else 0.0)


@inline
def _product(n: int, row: Eleven, b: Array, at: int) -> float:
    """Return the product of `row` with the `n` numbers at `at` of b."""
    value = row[0] * b[at]
    value = fma(row[1], b[at + 1], value)
    value = fma(row[2], b[at + 2], value)
    value = fma(row[3], b[at + 3], value)
    value = fma(row[4], b[at + 4], value)
    if n > 5:
        value = fma(row[5], b[at + 5], value)
    if n > 6:
        value = fma(row[6], b[at + 6], value)
    if n > 7:
        value = fma(row[7], b[at + 7], value)
    if n > 8:
        value = fma(row[8], b[at + 8], value)
    if n > 9:
        value = fma(row[9], b[at + 9], value)
    if n > 10:
        value = fma(row[10], b[at + 10], value)
    return value


@inline
def _put(n: int, row: Eleven, out: Array, at: int) -> None:
    """Write the `n` numbers of `row` to `at` of out."""
    out[at] = row[0]
    out[at + 1] = row[1]
    out[at + 2] = row[2]
    out[at + 3] = row[3]
    out[at + 4] = row[4]
    if n > 5:
        out[at + 5] = row[5]
    if n > 6:
        out[at + 6] = row[6]
    if n > 7:
        out[at + 7] = row[7]
    if n > 8:
        out[at + 8] = row[8]
    if n > 9:
        out[at + 9] = row[9]
    if n > 10:
        out[at + 10] = row[10]


@inline
def _mirrored(out: Array, n: int, i: int, j: int, value: float) -> None:
    if j <= i:
        out[i * n + j] = value
        out[j * n + i] = value


@inline
def add_transposed_product(layout: Layout, a: Array, b: Array, length: int,
                           out: Array) -> None:
    """Add a' b to `out` [n * n]; a, b [length * n], by rows; `layout` of n states."""
    n = layout.n
    for i in range(n):
        row = _added(n, 1.0, out, i * n, ZEROS)
        for k in range(length):
            row = _added(n, a[k * n + i], b, k * n, row)
        _put(n, row, out, i * n)


@inline
def add_product(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """Add a b to `out`; a and `out` [c * n], b [n * n], by rows; `layout` of n states."""
    n = layout.n
    for at in range(0, out.shape[0], n):
        row = _added(n, 1.0, out, at, ZEROS)
        for k in range(n):
            row = _added(n, a[at + k], b, k * n, row)
        _put(n, row, out, at)


@inline
def transposed_multiply_symmetric(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """Write a' b into `out`, known to be symmetric; all [n * n]; `layout` of n states."""
    n = layout.n
    for i in range(n):
        row = ZEROS
        for k in range(n):
            row = _added(n, a[k * n + i], b, k * n, row)
        _put(n, row, out, i * n)
    for i in range(n):
        for j in range(i):
            out[j * n + i] = out[i * n + j]


@kernel
def solve_positive(layout: Layout, a: Array, b: Array, out: Array) -> bool:
    """
    Write a^-1 b into `out`; all [n * n], `a` symmetric positive definite and overwritten.

    Returns False, with `out` undefined, when `a` is not positive definite.
    """
    n = layout.n
    for j in range(n):  # Cholesky, lower triangle; its diagonal inverted
        s = a[j * n + j]
        for k in range(j):
            s -= a[j * n + k] * a[j * n + k]
        if not s > 0.0:
            return False
        inverse = 1.0 / math.sqrt(s)
        a[j * n + j] = inverse
        for i in range(j + 1, n):
            s = a[i * n + j]
            for k in range(j):
                s -= a[i * n + k] * a[j * n + k]
            a[i * n + j] = s * inverse
    for i in range(n):
        row = _added(n, 1.0, b, i * n, ZEROS)
        for k in range(i):
            row = _added(n, -a[i * n + k], out, k * n, row)
        _put(n, row, out, i * n)
        _put(n, _added(n, a[i * n + i], out, i * n, ZEROS), out, i * n)
    for i in range(n - 1, -1, -1):
        row = _added(n, 1.0, out, i * n, ZEROS)
        for k in range(i + 1, n):
            row = _added(n, -a[k * n + i], out, k * n, row)
        _put(n, row, out, i * n)
        _put(n, _added(n, a[i * n + i], out, i * n, ZEROS), out, i * n)
    return True
