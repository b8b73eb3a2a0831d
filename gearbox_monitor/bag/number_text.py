# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write tables of numbers as text: the fewest digits from which float() gives the same bits.

The text is that of repr(), number by number a tenth as fast. The digits come from R. Giulietti's
"The Schubfach way to render doubles" (2020): with a power of ten in 128 bits, one rounding decides
between the shortest candidates.
"""
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from gearbox_monitor.kernels.jit import COMPILED, jit, jit_inline
from gearbox_monitor.kernels.types import Array, Integers

LEAST_POWER, GREATEST_POWER = -292, 324  # of ten
LONGEST_FLOAT, LONGEST_INTEGER = len('-2.2250738585072014e-308'), len('-9223372036854775808')
ROWS = 4096  # written at once
FRACTION, LOW = np.uint64((1 << 52) - 1), np.uint64((1 << 32) - 1)
HIDDEN, EXPONENT = np.uint64(1 << 52), np.uint64(0x7ff)
U0, U1, U2, U4, U10, U32, U40, U52, U63 = (
    np.uint64(k) for k in (0, 1, 2, 4, 10, 32, 40, 52, 63))
ZERO, MINUS, PLUS, POINT, COMMA, LINE, EXPONENT_SIGN = (np.uint8(ord(c)) for c in '0-+.,\ne')
NAN, INFINITE = (np.frombuffer(text, np.uint8) for text in (b'nan', b'inf'))


@cache
def _powers() -> npt.NDArray[np.uint64]:
    """Return [617, 2]: upper and lower half of 10^k, scaled to 128 bits and rounded up."""
    rows = []
    for k in range(LEAST_POWER, GREATEST_POWER + 1):
        if k >= 0:
            shift = (10 ** k).bit_length() - 128
            value = -(-10 ** k >> shift) if shift > 0 else 10 ** k << -shift
        else:
            shift = (10 ** -k).bit_length() + 127
            value = -(-(1 << shift) // 10 ** -k)
        rows.append((value >> 64, value & (1 << 64) - 1))
    return np.array(rows, np.uint64)


@jit_inline
def _product(a: Any, b: Any) -> Any:
    """Return (upper, lower) half of the product of two uint64."""
    a1, a0, b1, b0 = a >> U32, a & LOW, b >> U32, b & LOW
    low, middle = a0 * b0, a1 * b0
    cross = (low >> U32) + (middle & LOW) + a0 * b1
    return a1 * b1 + (middle >> U32) + (cross >> U32), (cross << U32) | (low & LOW)


@jit_inline
def _scaled(upper: Any, lower: Any, factor: Any) -> Any:
    """Return the upper 64 bits of (upper, lower) * factor, its last bit set if any bit follows."""
    carried, _ = _product(lower, factor)
    high, low = _product(upper, factor)
    total = low + carried
    if total < low:
        high += U1
    return high | (U1 if total > U1 else U0)


@jit
def _shortest(bits: Any, powers: Any) -> Any:
    """
    Return (digits, power of ten) of the shortest decimal number that rounds to a float.

    bits: uint64 of a finite float that is neither zero nor negative. powers: see _powers.
    """
    fraction, exponent = bits & FRACTION, np.int64((bits >> U52) & EXPONENT)
    c, q = fraction, np.int64(-1074)
    if exponent != 0:
        c, q = fraction | HIDDEN, exponent - 1075
        if -53 < q <= 0 and c & ((U1 << np.uint64(-q)) - U1) == U0:
            return c >> np.uint64(-q), np.int64(0)
    odd = c & U1  # of an even one, the bounds round to it, too
    closer = fraction == U0 and exponent > 1  # the neighbour below is half as far away
    k = (q * 1262611 - (524031 if closer else 0)) >> 22  # log10
    h = np.uint64(q + ((-k * 1741647) >> 19) + 1)
    upper, lower = powers[-k - LEAST_POWER, 0], powers[-k - LEAST_POWER, 1]
    centre = c << U2
    below = _scaled(upper, lower, (centre - (U1 if closer else U2)) << h) + odd
    value = _scaled(upper, lower, centre << h)
    above = _scaled(upper, lower, (centre + U2) << h) - odd
    s = value >> U2
    if s >= U10:
        tens = s // U10
        down, up = below <= U40 * tens, U40 * tens + U40 <= above
        if down != up:
            return tens + (U1 if up else U0), k + 1
    down, up = below <= U4 * s, U4 * s + U4 <= above
    if down != up:
        return s + (U1 if up else U0), k
    middle = U4 * s + U2
    nearer = value > middle or (value == middle and s & U1 != U0)
    return s + (U1 if nearer else U0), k


@jit_inline
def _put_digits(value: Any, out: Any, place: Any) -> Any:
    """Write the uint64 `value` to `out` from `place` on; return the place behind it."""
    count, bound = 1, U10
    while count < 20 and value >= bound:
        count += 1
        bound *= U10
    for i in range(place + count - 1, place - 1, -1):
        rest = value // U10
        out[i] = ZERO + np.uint8(value - rest * U10)
        value = rest
    return place + count


@jit
def _put_float(bits: Any, powers: Any, out: Any, place: Any) -> Any:
    """Write the float with `bits` to `out` from `place` on; return the place behind it."""
    special = bits & (FRACTION | EXPONENT << U52)
    if bits >> U63 and special <= EXPONENT << U52:  # NaN has no sign
        out[place] = MINUS
        place += 1
    if special >= EXPONENT << U52:
        for i in range(3):
            out[place + i] = INFINITE[i] if special == EXPONENT << U52 else NAN[i]
        return place + 3
    digits, power = U0, np.int64(0)
    if special != U0:
        digits, power = _shortest(special, powers)
        while digits // U10 * U10 == digits:
            digits, power = digits // U10, power + 1
    end = _put_digits(digits, out, place)
    count = end - place
    point = count + power  # place of the decimal point among the digits
    if -4 < point <= 0:  # 0.000ddd
        shift = 2 - point
        for i in range(end - 1, place - 1, -1):
            out[i + shift] = out[i]
        for i in range(place, place + shift):
            out[i] = ZERO
        out[place + 1] = POINT
        return end + shift
    if count <= point <= 16:  # ddd000.0
        for i in range(end, place + point + 2):
            out[i] = ZERO
        out[place + point] = POINT
        return place + point + 2
    before = point if 0 < point <= 16 else np.int64(1)
    if count > before:
        for i in range(end - 1, place + before - 1, -1):
            out[i + 1] = out[i]
        out[place + before] = POINT
        end += 1
    if 0 < point <= 16:  # dd.ddd
        return end
    out[end], power = EXPONENT_SIGN, point - 1  # d.dde+dd
    out[end + 1] = MINUS if power < 0 else PLUS
    out[end + 2] = ZERO
    return _put_digits(np.uint64(abs(power)), out, end + (3 if abs(power) < 10 else 2))


@jit
def _put_rows(integers: Any, values: Any, powers: Any, out: Any) -> int:
    """
    Write rows of an integer and floats, separated by commas; return the number of bytes.

    integers: int64 [N]. values: uint64 [N, C], the bits of floats. powers: see _powers. out:
    uint8, written.
    """
    place = 0
    for row in range(integers.shape[0]):
        number = np.uint64(integers[row])
        if integers[row] < 0:
            out[place] = MINUS
            place += 1
            number = ~number + U1
        place = _put_digits(number, out, place)
        for column in range(values.shape[1]):
            out[place] = COMMA
            place = _put_float(values[row, column], powers, out, place + 1)
        out[place] = LINE
        place += 1
    return place


def csv_rows(integers: Integers, columns: Sequence[Array]) -> bytes:
    """
    Return lines of comma-separated values that are read back bit for bit.

    Args:
        integers: int64 [N], the first column.
        columns: float64 [N] each.

    Returns:
        N lines, each with its line feed; floats as repr() writes them.
    """
    if not COMPILED:  # as a plain loop, repr is faster
        rows = zip(integers.tolist(), *(column.tolist() for column in columns))
        return ''.join(f'{number},{",".join(map(repr, row))}\n' for number, *row in rows).encode()
    width = LONGEST_INTEGER + (LONGEST_FLOAT + 1) * len(columns) + 1
    out = np.empty(min(ROWS, len(integers)) * width, np.uint8)
    pieces = []
    for begin in range(0, len(integers), ROWS):
        part = slice(begin, begin + ROWS)
        values = np.column_stack([column[part] for column in columns])
        size = _put_rows(integers[part], values.view(np.uint64), _powers(), out)
        pieces.append(out[:size].tobytes())
    return b''.join(pieces)
