# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Products of small matrices for kernels.

Matrices [n * n], row by row. Plain loops beat BLAS calls twelvefold at this size.
"""
import math
from typing import TypeAlias

from gearbox_monitor.kernels.elementary import fma
from gearbox_monitor.kernels.kernel import apart, inline, kernel
from gearbox_monitor.kernels.types import Array, Layout, unrolled

# A row of a matrix in variables: the compiler cannot know that what is written to is none of the
# matrices that are read. Kernels know LEAST to MOST states; behind the n of them are zeros.
Row: TypeAlias = tuple[float, ...]
LEAST, MOST = 5, 11
ZEROS: Row = (0.0,) * MOST


@apart
def multiply(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """
    Write a b into `out`; all [n * n], row by row.

    layout: of the n states.
    """
    n = layout.n
    for i in range(n):
        row = ZEROS
        for k in range(n):
            row = _fused(n, a[i * n + k], b, k * n, row)
        _put(n, row, out, i * n)


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
    for i in unrolled(n):
        row = ZEROS
        for k in unrolled(n):
            if full or k != 1 or i == 1:
                row = _fused(n, phi[i * n + k], P, k * n, row)
        _put(n, row, cross, i * n)
        row = _weighted(n, phi, i * n, half, row)
        for j in unrolled(n):
            _mirrored(out, n, i, j, _product(n, row, phi, j * n, full or j == 1))


@inline
def _carry_curve(curve: int, n: int, phi: Array, P: Array, half: Array,
                 cross: Array, out: Array) -> None:
    """
    Do as carry for `n` states of which `curve` are those of a curve.

    Rows of phi that are those of the unit matrix cost nothing: tau_K, and what is learnt of
    the curve, behind its memory.
    """
    memory = n - curve
    for i in unrolled(n):
        if not _moves(i, memory):
            for j in unrolled(n):
                cross[i * n + j] = out[i * n + j] = P[i * n + j]
            out[i * n + i] += half[i]
    for i in unrolled(n):
        if _moves(i, memory):
            at = i * n
            row = ZEROS
            for k in unrolled(n):
                row = _fused(n, phi[at + k], P, k * n, row)
            _put(n, row, cross, at)
            row = _weighted(n, phi, at, half, row)
            _put(n, row, out, at)
            for j in unrolled(n):
                if not _moves(j, memory):
                    out[j * n + i] = out[at + j]
                elif j <= i:
                    _mirrored(out, n, i, j, _product(n, row, phi, j * n, True))


@inline
def _moves(i: int, memory: int) -> bool:
    """Return whether row `i` of phi is none of the unit matrix; memory: place of its state."""
    return i < 4 or 4 < i <= memory


@inline
def _fused(n: int, v: float, b: Array, at: int, row: Row) -> Row:
    """Return `row` + v times the `n` numbers at `at` of b."""
    return tuple(fma(v, b[at + j], row[j]) if j < LEAST or j < n else 0.0 for j in range(MOST))


@inline
def _added(n: int, v: float, b: Array, at: int, row: Row) -> Row:
    """Do as _fused, but round each product."""
    return tuple(row[j] + v * b[at + j] if j < LEAST or j < n else 0.0 for j in range(MOST))


@inline
def _weighted(n: int, phi: Array, at: int, half: Array, row: Row) -> Row:
    """Return `row` + the `n` numbers at `at` of phi, each times that of `half`."""
    return tuple(fma(phi[at + j], half[j], row[j]) if j < LEAST or j < n else 0.0
                 for j in range(MOST))


@inline
def _product(n: int, row: Row, b: Array, at: int, second: bool) -> float:
    """Return `row` times the `n` numbers at `at` of b, without the second unless `second`."""
    value = row[0] * b[at]
    for j, own in enumerate(row):
        if j > 0 and (j > 1 or second) and (j < LEAST or j < n):
            value = fma(own, b[at + j], value)
    return value


@inline
def _put(n: int, row: Row, out: Array, at: int) -> None:
    """Write the `n` numbers of `row` to `at` of out."""
    for j, value in enumerate(row):
        if j < LEAST or j < n:
            out[at + j] = value


@inline
def _mirrored(out: Array, n: int, i: int, j: int, value: float) -> None:
    if j <= i:
        out[i * n + j] = value
        out[j * n + i] = value


@inline
def add_transposed_product(layout: Layout, a: Array, b: Array, out: Array) -> None:
    """Add a' b to `out`; all [n * n], by rows; `layout` of n states."""
    n = layout.n
    for i in unrolled(n):
        row = _added(n, 1.0, out, i * n, ZEROS)
        for k in unrolled(n):
            row = _fused(n, a[k * n + i], b, k * n, row)
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
