# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Kernels in C do what Python does, construct by construct, and name what they refuse."""
import ctypes
import inspect
import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest

from gearbox_monitor.kernels import build
from gearbox_monitor.kernels.elementary import exponential, fma, signed, sine, times_power
from gearbox_monitor.kernels.kernel import apart, Entry, folded, instruction
from gearbox_monitor.kernels.translate.program import Program
from gearbox_monitor.kernels.translate.values import FLOAT, INT, Known, Refused
from gearbox_monitor.kernels.types import (
    IntegerMatrix, Integers, Layout, Matrix, unrolled, Vector, Words)

FLOATS = (0.0, -0.0, 1.5, -2.25, 1e300, math.inf, -math.inf, math.nan)
WHOLE = (-7, -1, 0, 1, 2, 5)
GLOBAL = np.array([[1.5, -2.0], [0.25, 4.0]])


class Point(NamedTuple):
    x: float
    y: float = 2.5


class Nested(NamedTuple):
    point: Point
    count: int


def divides(a: int, b: int) -> tuple[int, int]:
    return (a // b, a % b) if b != 0 else (0, 0)


def divides_by_constant(a: int) -> tuple[int, int, int, int]:
    return a // 3, a % 3, a // -3, a % -3


def bits(a: int, b: int) -> tuple[int, int, int, int, int]:
    return a & b, a | b, a ^ b, ~a, (a << 3) + (a >> 1)


def words(a: Words) -> int:
    value = np.uint64(0)
    for i in range(a.shape[0]):
        value |= (a[i] & np.uint64(255)) << np.uint64(8 * i)
    return int(value >> np.uint64(1))


def powers(a: int) -> int:
    return a ** 3 - a ** 2


def extremes(a: float, b: float, c: float) -> tuple[float, float, float, float]:
    return min(a, b), max(a, b), min(a, b, c), max(a, b, c)


def extremes_of_mixed(a: float, n: int) -> tuple[float, float, int]:
    return min(a, n), max(n, a), max(n, 2)


def compares(a: float, b: float, c: float) -> tuple[bool, bool, bool, bool]:
    return a < b < c, a <= b != c, not a > b, a == b


def in_order(z: Vector) -> float:
    def moved(by: float) -> float:
        z[0] += by
        return z[0]
    return z[0] + moved(1.0) * 10.0 + z[0] + moved(2.0) * 100.0


def written(z: Vector, by: float) -> float:
    z[0] += by
    return z[0]


def arguments_in_order(z: Vector) -> float:
    return math.copysign(z[0], written(z, 1.0)) + written(z, 2.0) * z[0]


def only_where_asked(z: Vector, a: bool) -> tuple[bool, float]:
    good = a and written(z, 1.0) > 0.0 or written(z, 10.0) > 0.0
    return good, z[0]


def generated(z: Vector, n: int) -> tuple[float, float, float, float]:
    j = 2.0
    row = tuple(written(z, 1.0) if i < n else z[i] * j for i in range(3))
    doubled = tuple(2.0 * value for value in row)
    return doubled[0], doubled[1], doubled[2], z[0]


def choice(z: Vector, a: bool) -> float:
    return written(z, 1.0) if a else written(z, 2.0) - z[1]


def swapped(a: float, b: float) -> tuple[float, float]:
    a, b = b, a + b
    return a, b


def augmented(z: Vector, i: int) -> float:
    z[i] += written(z, 1.0)
    z[-1] *= 2.0
    return z[i]


def negative_indices(z: Vector, i: int) -> tuple[float, float]:
    return z[i], z[-2]


def slices(z: Vector, low: int, high: int) -> tuple[float, int, int, float]:
    part, stepped = z[low:high], z[1::2]
    total = 0.0
    for i in range(len(part)):
        total += part[i]
    return total, len(part), stepped.shape[0], stepped[-1]


def filled(z: Vector, m: Matrix) -> float:
    z[1:-1] = 0.5
    m[0] = z[:3]
    m[1, :] = m[0]
    m[:, 2] = 7.0
    return m[1, 1] + m[0, 2] + len(m)


def reshaped(z: Vector) -> tuple[float, int, int]:
    m = z.reshape(len(z) // 2, 2)
    m[1, 0] = 9.0
    return z[2], m.shape[0], m.shape[1]


def matrices(m: Matrix, n: IntegerMatrix) -> float:
    rows, columns = m.shape
    total = 0.0
    for i in range(rows):
        row = m[i]
        for j in range(columns - 1, -1, -1):
            total = 0.5 * total + row[j] * n[i, j]
    return total


def tuples(a: float, n: int) -> tuple[float, float, float]:
    x = (a, 2.0 * a, -a)
    y = x[1:] + (1.0,)
    total = 0.0
    for i, value in enumerate(y):
        if i == 1:
            continue
        total += value * i
    for p, q in zip(x, y):
        if p > 1e10:
            break
        total += p * q
    return x[n % 3], total, (2.0, 3.0)[1] + y[-1]


def over_tuples(a: float) -> float:
    total = 0.0
    for scale in (1.0, 2.0, 4.0):
        if a * scale > 3.0:
            break
        if scale == 2.0:
            continue
        total += a * scale
    return total


def records(n: Nested, a: float) -> tuple[float, int]:
    point, count = n
    moved = Point(point.x + a)
    deeper = Nested(Point(y=moved.x, x=moved.y), count + 1)
    return deeper.point.x * deeper.point.y, deeper.count


def _applied(function, *arguments):
    return function(*arguments)


def _scaled(factor):
    def scaled(x: float, offset: float = 1.0) -> float:
        return factor * x + offset
    return scaled


TWICE, THRICE = _scaled(2.0), _scaled(3.0)


def closures(a: float) -> float:
    return _applied(TWICE, a) + THRICE(a, offset=-a)


def written_out(a: Vector, n: int) -> float:
    total = 0.0
    for i in unrolled(6):
        if i == 2:
            continue
        for j in unrolled(n):
            if j > i:
                break
            total = 2.0 * total + a[i] * a[j]
    return total


def loops(n: int, step: int) -> tuple[int, int, float]:
    total = count = 0
    for i in range(n, -n, step if step != 0 else -1):
        total += i
    while True:
        count += 1
        if count % 2:
            continue
        if count > n:
            break
    x = 0.0
    for i in (1, 2, 3):
        x = x * 10 + i
    return total, count, x


def globals_and_casts(a: float, n: int) -> tuple[float, float, int, bool, int]:
    safe = a if math.isfinite(a) and abs(a) < 1e9 else 0.25
    return (GLOBAL[1, n % 2] + GLOBAL[0, 1], float(n), int(safe), bool(n),
            math.ceil(safe) - math.floor(safe) + abs(n))


def of_math(a: float) -> tuple[float, float, float, bool]:
    x = abs(a) if math.isfinite(a) else 0.5
    x = min(x, 20.0)
    return math.sqrt(x), math.exp(-x) + math.atan(a), math.hypot(x, 1.0), math.isnan(a)


def instructions(a: float, b: float) -> tuple[float, float, float]:
    x = min(max(a, -5.0), 5.0)
    return fma(x, b, 0.1), exponential(x) + sine(b), signed(
        times_power(1.5, 3.0 + 1.5 * 2.0 ** 52), 1.0 + 1.5 * 2.0 ** 52)


def none_is_pruned(a: float) -> float:
    return _maybe(a, None) + _maybe(a, 2.0)


def _maybe(a, b):
    if b is None:
        return a
    return a * b


def stamps(s: Integers) -> tuple[int, float]:
    last = s[-1]
    return last - s[0], (last - s[0]) * 1e-9


USUAL = Layout(5, False, -1, False)
LAYOUTS = (USUAL, USUAL._replace(curve=0), USUAL._replace(n=6), USUAL._replace(law=True))


@folded(USUAL)
@apart
def curved(layout: Layout, a: Vector) -> float:
    if layout.curve >= 0:
        a[0] *= 7.0
    return a[0] * layout.n


@folded(USUAL)
@apart
def curved_in_place(layout: Layout, a: Vector) -> None:
    a[1] = curved(layout, a)


KERNELS = [value for value in list(globals().values()) if inspect.isfunction(value)
           and value.__module__ == __name__ and not value.__name__.startswith('_')
           and 'return' in value.__annotations__ and value.__closure__ is None
           and value is not in_order]


def values_of(annotation):
    """Yield arguments to try for a declared type."""
    if annotation is float:
        return FLOATS
    if annotation is int:
        return WHOLE
    if annotation is bool:
        return (True, False)
    if annotation is Layout:
        return LAYOUTS
    if annotation is Nested:
        return (Nested(Point(1.5, -2.0), 3),)
    shape = {Matrix: (2, 3), IntegerMatrix: (2, 3)}.get(annotation, 6)
    numbers = 1.0 + np.arange(np.prod(shape)).reshape(shape)
    kind = {Words: np.uint64, Integers: np.int64, IntegerMatrix: np.int64}.get(annotation, float)
    return (np.ascontiguousarray(numbers.astype(kind)),)


@pytest.fixture(scope='module')
def compiled(tmp_path_factory):
    """Return {kernel: the same in C}, compiled together."""
    entries = {kernel: Entry(kernel) for kernel in KERNELS}
    path = tmp_path_factory.mktemp('kernels') / 'kernels.so'
    build.compile_(build.text_of(entries.values()), path, '-O1')
    library = ctypes.CDLL(str(path))
    for entry in entries.values():
        entry.function = getattr(library, entry.symbol)
        entry.function.argtypes = [ctypes.c_void_p]
    return entries


def same(a, b):
    """Return whether two results are the same bits; one NaN is as good as another."""
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(b, float) or isinstance(a, float):
        return math.isnan(a) and math.isnan(b) or (
            a == b and math.copysign(1.0, a) == math.copysign(1.0, b))
    return a == b


def test_a_kernel_gives_what_python_gives(compiled):
    for kernel in KERNELS:
        kinds = [v for k, v in kernel.__annotations__.items() if k != 'return']
        for arguments in itertools.product(*map(values_of, kinds)):
            if kernel in (negative_indices, augmented) and not -6 <= arguments[1] < 6:
                continue
            ours, theirs = ([a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
                            for _ in range(2))
            with np.errstate(all='ignore'):
                expected = kernel(*ours)
            result = compiled[kernel](*theirs)
            assert same(result, expected), (arguments, result, expected)
            for a, b in zip(ours, theirs):
                if isinstance(a, np.ndarray):
                    np.testing.assert_array_equal(a, b, str(arguments))


def test_an_array_with_strides_is_written_through(compiled):
    wide = np.arange(12.0).reshape(6, 2)
    compiled[augmented](wide[:, 1], 2)
    expected = np.arange(12.0).reshape(6, 2)
    augmented(expected[:, 1], 2)
    np.testing.assert_array_equal(wide, expected)


OTHER_TYPES = [
    (np.zeros(3, np.float32), 1), (np.zeros((2, 2)), 1), ([1.0, 2.0], 1), (np.zeros(3),)]


def test_an_argument_of_another_type_is_refused(compiled):
    for arguments in OTHER_TYPES:
        with pytest.raises(TypeError, match='negative_indices|required argument'):
            compiled[negative_indices](*arguments)


def test_what_is_folded_in_leaves_out_what_it_excludes():
    program = Program()
    program.instance(curved, (Known(USUAL), *Entry(curved).types[0][1:]))
    assert '7.0' not in program.text()


def _dictionary(a):
    return {1: a}


def _of_floats(a):
    return a // 2.0


def _power(a):
    return a ** 0.5


def _changes_type(a):
    x = a
    x = (a, a)
    return x[0]


def _unknown_function(a):
    return np.linalg.norm(a)


def _makes_an_array(a):
    return np.zeros(3)[0] + a


def _is_something(a):
    return a is True


def _calls_itself(a):
    return _calls_itself(a)


def _keyword(a):
    return _scaled(1.0)(a)


def _with_statement(a):
    with a:
        return a


def _unassigned(a):
    return a + b  # noqa: F821


def _of_constants(a):
    GLOBAL[0, 0] = a
    return a


NOT_IN_C = [
    (_dictionary, 1, 'Dict'), (_of_floats, 1, 'FloorDiv of floats'), (_power, 1, 'math.sqrt'),
    (_changes_type, 2, 'x is a float and later a tuple of 2'),
    (_unknown_function, 1, 'norm, which is no kernel'), (_makes_an_array, 1, 'zeros'),
    (_is_something, 1, 'is, with something else than None'),
    (_calls_itself, 1, 'calls itself'), (_keyword, 1, 'FunctionDef'),
    (_with_statement, 1, 'With'), (_unassigned, 1, 'unknown name b'),
    (_of_constants, 1, 'constant array')]


def test_what_c_has_not_is_refused_by_file_and_line():
    for kernel, line, words_ in NOT_IN_C:
        with pytest.raises(Refused) as refused:
            Program().entry(kernel, (FLOAT,), 'symbol')
        place = f'{__file__}:'
        assert place in str(refused.value) and words_ in str(refused.value)
        if kernel is not _keyword:
            assert f'{place}{kernel.__code__.co_firstlineno + line}: ' in str(refused.value)


def test_the_c_of_one_kernel_is_always_the_same():
    texts = []
    for _ in range(2):
        program = Program()
        program.entry(tuples, (FLOAT, INT), 'symbol')
        texts.append(program.text())
    assert texts[0] == texts[1]


def test_an_instruction_may_write_several_results():
    @instruction('gm_three', results=3)
    def three(a):
        return a, a, a

    def sums(a: float) -> float:
        x, y, z = three(a)
        return x + y + z

    program = Program()
    program.entry(sums, (FLOAT,), 'symbol')
    assert 'gm_three(t1, a_)' in program.text()
