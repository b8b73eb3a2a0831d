# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the annotations of an entry declare, and arguments of Python as the slots of a C call."""
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
import struct
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np


@dataclass(frozen=True)
class Declared:
    """
    The type of an argument.

    kind: float, int, natural, bool, array, tuple or folded. form: of its slots, as struct writes
    them. element, ndim: of an array. items, made_of: of a tuple. value: what is folded.
    """

    kind: str
    form: str
    element: str = ''
    ndim: int = 0
    items: 'tuple[Declared, ...]' = ()
    made_of: Any = None
    value: Any = None


SCALARS = {float: Declared('float', 'd'), int: Declared('int', 'q'), bool: Declared('bool', 'q')}


@cache
def declared(annotation: Any) -> Declared:
    """Return what an annotation declares. Raises TypeError."""
    if annotation in SCALARS:
        return SCALARS[annotation]
    details = getattr(annotation, '__metadata__', ())
    if details == ('natural',):
        return Declared('natural', 'q')
    if details:
        return Declared('array', 'q' * (1 + details[1]), *details)
    if get_origin(annotation) is tuple and Ellipsis not in get_args(annotation):
        items = tuple(map(declared, get_args(annotation)))
    elif isinstance(annotation, type) and hasattr(annotation, '_fields'):
        items = tuple(map(declared, get_type_hints(annotation, include_extras=True).values()))
    else:
        raise TypeError(f'{annotation}, expected float, int, bool, Vector, Matrix or the like, or '
                        'a tuple or NamedTuple of these')
    made_of = annotation if hasattr(annotation, '_fields') else None
    return Declared('tuple', ''.join(i.form for i in items), '', 0, items, made_of)


def layout_of(value: Any) -> Declared:
    """Return the type of an argument that is folded into a kernel; it has no slots."""
    return Declared('folded', '', value=value)


def argument_types(function: Any) -> tuple[Declared, ...]:
    """Return the declared types of the arguments of an entry. Raises TypeError."""
    hints = get_type_hints(function, include_extras=True)
    hints.pop('return', None)
    try:
        return tuple(map(declared, hints.values()))
    except TypeError as error:
        raise TypeError(f'{function.__module__}.{function.__qualname__}: {error}') from None


def result_format(function: Any) -> str:
    """Return what an entry returns: d, q, ? (a bool) or, in brackets, several; '' for None."""
    kind = get_type_hints(function, include_extras=True).get('return')
    return '' if kind in (None, type(None)) else _result(declared(kind))


def _result(kind: Declared) -> str:
    if kind.kind == 'tuple':
        return f'({"".join(map(_result, kind.items))})'
    return '?' if kind.kind == 'bool' else kind.form


def unpacker(form: str) -> Callable[[Any], Any]:
    """Return the function (room) -> what result_format `form` says, from the start of `room`."""
    plain = struct.Struct('<' + ''.join(c for c in form if c not in '()').replace('?', 'q'))
    read = plain.unpack_from
    if not form:
        return _nothing
    if form in ('d', 'q'):
        return lambda room: read(room)[0]
    if form == '?':
        return lambda room: read(room)[0] != 0
    if form.count('(') == 1 and '?' not in form:
        return read
    return lambda room: _nested(form, read(room))


def _nothing(room: Any) -> None:
    return None


def _nested(form: str, numbers: tuple[Any, ...]) -> Any:
    values = iter(numbers)
    stack: list[list[Any]] = [[]]
    for c in form:
        if c == '(':
            stack.append([])
        elif c == ')':
            done = tuple(stack.pop())
            stack[-1].append(done)
        else:
            stack[-1].append(next(values) != 0 if c == '?' else next(values))
    return stack[0][0]


def flatten(types: Any, arguments: Any, slots: list[Any], owner: Any) -> list[tuple[Any, Any]]:
    """
    Append the numbers of `arguments` to `slots`.

    Args:
        types: Declared types of the arguments.
        arguments: as many values.
        slots: numbers and addresses, extended.
        owner: whose arguments they are, for messages.

    Returns:
        Pairs (copy, original) of arrays that are not contiguous: what the kernel has written to a
        copy belongs into the original. The copies live as long as the list.

    Raises:
        TypeError: an argument is not of the declared type.
    """
    keep: list[tuple[Any, Any]] = []
    for kind, value in zip(types, arguments, strict=True):
        what = kind.kind
        if what == 'array':
            if type(value) is not np.ndarray or value.ndim != kind.ndim or (
                    value.dtype.str[1:] != kind.element):
                raise TypeError(
                    f'{owner.__name__}: {getattr(value, "dtype", type(value).__name__)} '
                    f'{getattr(value, "shape", "")}, expected {kind.element} of {kind.ndim} '
                    'dimensions')
            if not value.flags.c_contiguous:
                copy = np.ascontiguousarray(value)
                keep.append((copy, value if value.flags.writeable else copy))
                value = copy
            slots.append(value.__array_interface__['data'][0])
            slots += value.shape
        elif what == 'tuple':
            keep += flatten(kind.items, value, slots, owner)
        elif what != 'folded':
            slots.append(bool(value) if what == 'bool' else value)
    return keep
