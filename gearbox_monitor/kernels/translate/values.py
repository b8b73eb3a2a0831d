# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Types of a kernel's values in C, and values while a kernel is translated."""
import ast
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
import linecache
import math
from types import FunctionType
from typing import Any, TypeAlias

import numpy as np


class Refused(Exception):
    """A kernel has a construct that C has not; names it, with file and line."""


class _Open:
    """Stands for the constant of a value that is not known at translation."""

    def __repr__(self) -> str:
        return 'OPEN'


OPEN: Any = _Open()


@dataclass(frozen=True)
class Number:
    """A number: f real, i int64, u uint64, b bool; natural: an integer that is not negative."""

    kind: str
    natural: bool = False


@dataclass(frozen=True)
class Array:
    """An array: element as numpy names it; contiguous in C order, or with strides."""

    element: str
    ndim: int
    contiguous: bool = True

    @cached_property
    def dtype(self) -> 'np.dtype[Any]':
        """Its elements as numpy has them."""
        return np.dtype(self.element)


@dataclass(frozen=True)
class Record:
    """A tuple; made_of: its NamedTuple, None for a plain one."""

    items: 'tuple[Type, ...]'
    made_of: Any = None


@dataclass(frozen=True, eq=False)
class Known:
    """What is known at translation and needs no room in C: None, a function, folded constants."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and _key(self.value) == _key(other.value)

    def __hash__(self) -> int:
        return hash(_key(self.value))


def _key(value: Any) -> Any:
    """Return what two equal constants share, down to the types of their numbers."""
    if isinstance(value, tuple):
        return type(value), tuple(map(_key, value))
    if isinstance(value, (int, float, str, type(None))):
        return type(value), repr(value)
    return id(value)


Type: TypeAlias = Number | Array | Record | Known
INT, NATURAL, WORD, FLOAT, BOOL = (
    Number('i'), Number('i', True), Number('u', True), Number('f'), Number('b'))
SLOTS = {'f': 'd', 'i': 'q', 'b': '?7x'}  # of numbers among arguments, as struct writes them
C_NUMBERS = {'f': 'real', 'i': 'int64_t', 'u': 'uint64_t', 'b': 'bool'}
# Of arrays: C type of an element, and its value.
ELEMENTS = {'f8': ('real', FLOAT), 'i8': ('int64_t', INT), 'b1': ('bool', BOOL),
            'u1': ('uint8_t', NATURAL), 'i4': ('int32_t', INT), 'u8': ('uint64_t', WORD)}


@dataclass
class Scalar:
    """
    A number at translation.

    c: its C expression, without effects. constant: its value, OPEN if it is not known. stable: no
    statement that follows changes what the expression gives.
    """

    type: Number
    c: str
    constant: Any = OPEN
    stable: bool = False

    def __post_init__(self) -> None:
        self.stable = self.stable or self.constant is not OPEN


@dataclass
class View:
    """
    An array, or a part of one.

    pointer, shape and strides (in elements; None: contiguous) are C expressions; data: the numbers
    of a constant array; name: of the C variable that holds all this.
    """

    type: Array
    pointer: str
    shape: list[str]
    strides: list[str] | None = None
    data: Any = None
    name: str = ''

    def steps(self) -> list[str]:
        """Return the strides in elements."""
        if self.strides is not None:
            return self.strides
        return [' * '.join(self.shape[i + 1:]) or '1' for i in range(self.type.ndim)]


@dataclass
class Tuple:
    """A tuple; name: of the C struct that holds it; folded: itself, if callees shall know it."""

    items: 'list[Value]'
    made_of: Any = None
    name: str = ''
    folded: Any = OPEN


@dataclass
class Object:
    """A function, a class, None, a string: no number, and known."""

    value: Any


Value: TypeAlias = Scalar | View | Tuple | Object


def type_of(value: Value) -> Type:
    """Return the type of a value; a function is translated for each combination of them."""
    if isinstance(value, Scalar):
        return value.type
    if isinstance(value, View):
        return Known(value.data) if value.data is not None else value.type
    if isinstance(value, Object):
        return Known(value.value)
    if value.folded is not OPEN:
        return Known(value.folded)
    return Record(tuple(map(type_of, value.items)), value.made_of)


def constant(value: Any) -> Value:
    """Return the Value of a Python object; arrays are constants of a Program."""
    if isinstance(value, (bool, np.bool_)):
        return Scalar(BOOL, 'true' if value else 'false', bool(value))
    if isinstance(value, np.unsignedinteger):
        return Scalar(WORD, f'UINT64_C({int(value)})', int(value))
    if isinstance(value, (int, np.integer)):
        return Scalar(NATURAL if value >= 0 else INT, integer(int(value)), int(value))
    if isinstance(value, (float, np.floating)):
        return Scalar(FLOAT, real(float(value)), float(value))
    return Object(value)


def integer(value: int) -> str:
    """Return the C literal of `value`."""
    text = str(value) if abs(value) < 2 ** 31 else f'INT64_C({value})'
    return f'({text})' if value < 0 else text


def real(value: float) -> str:
    """Return the C literal of `value`; that of a NaN without its sign and payload."""
    if not math.isfinite(value):
        return 'NAN' if math.isnan(value) else 'INFINITY' if value > 0.0 else '(-INFINITY)'
    text = repr(value)
    return f'(real)({text})' if text[0] == '-' else f'(real){text}'


def stored(kind: Type) -> bool:
    """Return whether a value of the type needs room in C."""
    return any(map(stored, kind.items)) if isinstance(kind, Record) else (
        not isinstance(kind, Known))


def form(kinds: Sequence[Type]) -> str:
    """Return the slots of arguments of these `kinds`, as struct writes them."""
    return ''.join(SLOTS[kind.kind] if isinstance(kind, Number) else 'q' * (1 + kind.ndim)
                   if isinstance(kind, Array) else form(kind.items)
                   if isinstance(kind, Record) else '' for kind in kinds)


def join(a: Type, b: Type) -> Type | None:
    """Return the type of what is of type `a` or `b`, None if there is none."""
    if a == b:
        return a
    if isinstance(a, Number) and isinstance(b, Number):
        if a.kind == b.kind:
            return Number(a.kind, a.natural and b.natural)
        kinds = {a.kind, b.kind}
        if 'f' in kinds:
            return FLOAT
        if 'u' not in kinds:
            return INT
        other = a if b.kind == 'u' else b
        return WORD if other.natural or other.kind == 'b' else None
    if isinstance(a, Array) and isinstance(b, Array):
        same = (a.element, a.ndim) == (b.element, b.ndim)
        return Array(a.element, a.ndim, a.contiguous and b.contiguous) if same else None
    a, b = _unfolded(a), _unfolded(b)
    if isinstance(a, Record) and isinstance(b, Record) and len(a.items) == len(b.items):
        items = [join(x, y) for x, y in zip(a.items, b.items)]
        if None not in items:
            return Record(tuple(i for i in items if i is not None),
                          a.made_of if a.made_of is b.made_of else None)
    return None


def _unfolded(kind: Type) -> Type:
    """Return the type of a folded tuple as one of a tuple that is not folded."""
    if isinstance(kind, Known) and isinstance(kind.value, tuple):
        return Record(tuple(type_of(constant(v)) if not isinstance(v, tuple) else _unfolded(
            Known(v)) for v in kind.value), type(kind.value))
    return kind


def words(kind: Type) -> str:
    """Return what messages call a type."""
    if isinstance(kind, Number):
        return {'f': 'a float', 'i': 'an int', 'u': 'a uint64', 'b': 'a bool'}[kind.kind]
    if isinstance(kind, Array):
        return f'an array of {kind.ndim} dimensions of {kind.element}'
    if isinstance(kind, Record):
        return kind.made_of.__name__ if kind.made_of else f'a tuple of {len(kind.items)}'
    return f'{getattr(kind.value, "__qualname__", repr(kind.value))[:40]}'


def alike(kind: Record) -> bool:
    """Return whether a tuple is an array in C: several of one type, without names."""
    return kind.made_of is None and len(kind.items) > 1 and stored(kind.items[0]) and all(
        _c_key(item) == _c_key(kind.items[0]) for item in kind.items)


def _c_key(kind: Type) -> Any:
    return kind.kind if isinstance(kind, Number) else kind


def field(kind: Record, i: int) -> str:
    """Return what the struct of a tuple calls its item `i`."""
    return f'{kind.made_of._fields[i]}_' if kind.made_of else f'f{i}'


@cache
def _definitions(file: str) -> dict[int, Any]:
    """Return {first line: definition of a function} of a file."""
    found: dict[int, Any] = {}
    for node in ast.walk(ast.parse(''.join(linecache.getlines(file)))):
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            lines = [node.lineno, *(d.lineno for d in getattr(node, 'decorator_list', []))]
            found.setdefault(min(lines), node)
    return found


def definition(function: FunctionType) -> Any:
    """Return the syntax tree of a function. Raises Refused."""
    code = function.__code__
    try:
        return _definitions(code.co_filename)[code.co_firstlineno]
    except (KeyError, OSError, SyntaxError):
        raise Refused(f'{code.co_filename}:{code.co_firstlineno}: no source of '
                      f'{function.__qualname__}') from None
