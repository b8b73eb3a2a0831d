# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A C file in the making: its types, constants, functions, and the entries that Python calls."""
from collections.abc import Mapping
from pathlib import Path
import re
from types import FunctionType
from typing import Any

import numpy as np

from gearbox_monitor.kernels.translate.statements import Function
from gearbox_monitor.kernels.translate.values import (
    alike, Array, C_NUMBERS, constant, ELEMENTS, field, integer, Known, Number, Object, real,
    Record, Refused, Scalar, stored, Tuple, Type, Value, View, words)

PRELUDE = Path(__file__).with_name('prelude.h')
RETURNED = 8  # slots before the arguments of an entry, for what it returns


class Program:
    """
    Kernels as one C file.

    real: C type of a float. stand_ins: {function: kernel that is called instead}.
    """

    def __init__(self, real: str = 'double', stand_ins: Mapping[Any, Any] | None = None) -> None:
        self.real, self.stand_ins = real, dict(stand_ins or {})
        self.functions: list[Function] = []  # those that are called first
        self.entries: list[str] = []
        self._structs: dict[Any, str] = {}
        self._typedefs: list[str] = []
        self._constants: dict[int, str] = {}
        self._constant_lines: list[str] = []
        self._instances: dict[Any, Function] = {}
        self._names: dict[str, int] = {}
        self._kept: list[Any] = []  # whose ids are keys
        self._open: list[Any] = []

    def unique(self, wanted: str) -> str:
        """Return a name that the file has not yet, `wanted` if that is free."""
        wanted = re.sub(r'\W+', '_', wanted).strip('_')
        count = self._names.get(wanted, 0)
        self._names[wanted] = count + 1
        return f'{wanted}_{count + 1}' if count else wanted

    # ------------------------------------------------------------------ types

    def c_type(self, kind: Type) -> str:
        """Return the C type of a value that needs room; it is defined where it is new."""
        if isinstance(kind, Number):
            return C_NUMBERS[kind.kind]
        if isinstance(kind, Array):
            name = f'{"array" if kind.contiguous else "view"}{kind.ndim}_{kind.element}'
            steps = '' if kind.contiguous else f' int64_t s[{kind.ndim}];'
            return self._struct(
                kind, name, f'{ELEMENTS[kind.element][0]} *p; int64_t n[{kind.ndim}];{steps}')
        if not isinstance(kind, Record):
            raise Refused(f'no room for {words(kind)}')
        inner = self._members(kind)
        return self._struct(inner, kind.made_of.__name__ if kind.made_of else 'tuple', inner)

    def _members(self, kind: Record) -> str:
        if alike(kind):
            return f'{self.c_type(kind.items[0])} v[{len(kind.items)}];'
        return ' '.join(f'{self.c_type(item)} {field(kind, i)};'
                        for i, item in enumerate(kind.items) if stored(item))

    def _struct(self, key: Any, wanted: str, inner: str) -> str:
        if key not in self._structs:
            name = self._structs[key] = self.unique(wanted)
            self._typedefs.append(f'typedef struct {{ {inner} }} {name};')
        return self._structs[key]

    # ------------------------------------------------------------------ values

    def value(self, kind: Type, c: str, stable: bool = False) -> Value:
        """Return the value of the type that the C variable or member `c` holds."""
        if isinstance(kind, Known):
            return self.known(kind.value)
        if isinstance(kind, Number):
            return Scalar(kind, c, stable=stable)
        if isinstance(kind, Array):
            shape, steps = ([f'{c}.{x}[{i}]' for i in range(kind.ndim)] for x in 'ns')
            return View(kind, f'{c}.p', shape, None if kind.contiguous else steps, name=c)
        members = [f'{c}.v[{i}]' if alike(kind) else f'{c}.{field(kind, i)}'
                   for i in range(len(kind.items))]
        return Tuple([self.value(item, member, stable)
                      for item, member in zip(kind.items, members)], kind.made_of, c)

    def known(self, value: Any) -> Value:
        """Return the value of a Python object."""
        if isinstance(value, np.ndarray):
            element = value.dtype.str[1:]
            return View(Array(element, value.ndim), f'(({ELEMENTS[element][0]} *)'
                        f'{self._array(value)})', [str(n) for n in value.shape], data=value)
        if isinstance(value, tuple):
            made_of = type(value) if hasattr(value, '_fields') else None
            made = Tuple([self.known(v) for v in value], made_of)
            if made_of:
                made.folded = value
            return made
        return constant(value)

    def _array(self, array: Any) -> str:
        if id(array) not in self._constants:
            self._kept.append(array)
            name = self._constants[id(array)] = self.unique('constant')
            literal = real if array.dtype.kind == 'f' else lambda v: integer(int(v))
            numbers = ', '.join(literal(v.item()) for v in array.ravel()) or '0'
            self._constant_lines.append(
                f'GM_STATIC const {ELEMENTS[array.dtype.str[1:]][0]} '
                f'{name}[{max(array.size, 1)}] = {{{numbers}}};')
        return self._constants[id(array)]

    # ------------------------------------------------------------------ functions

    def instance(self, function: FunctionType, types: tuple[Type, ...],
                 complete: bool = False) -> Function:
        """
        Return `function` translated for arguments of the `types`.

        One that has usual first arguments chooses among its instances; `complete`: one of these.
        """
        key = id(function), types, complete
        if key not in self._instances:
            self._kept.append(function)
            made = self._instances[key] = Function(self, function, types)
            made.complete = complete
            self._open.append(key)
            made.translate()
            self._open.pop()
            self.functions.append(made)
        if key in self._open:
            raise Refused(f'{function.__qualname__} calls itself')
        return self._instances[key]

    def entry(self, function: FunctionType, types: tuple[Type, ...], symbol: str) -> Type:
        """
        Export a function to Python.

        Args:
            function: the kernel.
            types: of its arguments; what is Known is folded into it.
            symbol: name of the C function `void symbol(gm_slot *a)`: what it returns is left in
                a[0..RETURNED - 1], its arguments stand behind.

        Returns:
            The type of what it returns.

        Raises:
            Refused: it has a construct that C has not.
        """
        made, at, arguments = self.instance(function, types), [RETURNED], []
        for kind in types:
            value = self._from_slots(kind, at)
            if stored(kind):
                arguments.append(made.expression(value, kind))
        call, lines = f'{made.name}({", ".join(arguments)})', []
        result = made.result or Known(None)
        if stored(result):
            lines.append(f'{self.c_type(result)} r = {call};')
            numbers = list(_numbers(self.value(result, 'r')))
            if len(numbers) > RETURNED:
                raise Refused(f'{function.__qualname__}: returns more than {RETURNED} numbers')
            lines += [f'a[{k}].{"d" if n.type.kind == "f" else "i"} = {n.c};'
                      for k, n in enumerate(numbers)]
        else:
            lines.append(f'{call};')
        self.entries.append('\n'.join(
            [f'void {symbol}(gm_slot *a)', '{', *(f'    {line}' for line in lines), '}']))
        return result

    def _from_slots(self, kind: Type, at: list[int]) -> Value:
        if isinstance(kind, Known):
            return self.known(kind.value)
        k = at[0]
        if isinstance(kind, Number):
            at[0] += 1
            return Scalar(kind, {'f': f'(real)a[{k}].d', 'b': f'(a[{k}].i != 0)'}.get(
                kind.kind, f'a[{k}].i'))
        if isinstance(kind, Array):
            at[0] += 1 + kind.ndim
            return View(kind, f'({ELEMENTS[kind.element][0]} *)a[{k}].p',
                        [f'a[{k + 1 + i}].i' for i in range(kind.ndim)])
        return Tuple([self._from_slots(item, at) for item in kind.items], kind.made_of)

    def text(self) -> str:
        """Return the C file."""
        return '\n'.join([
            f'typedef {self.real} real;', PRELUDE.read_text(), *self._typedefs, '',
            *self._constant_lines, '', '\n\n'.join(f.text for f in self.functions), '',
            *self.entries, ''])


def _numbers(value: Value) -> Any:
    """Yield the numbers in what an entry returns."""
    if isinstance(value, Scalar):
        yield value
    elif isinstance(value, Tuple):
        for item in value.items:
            yield from _numbers(item)
    elif not isinstance(value, Object):
        raise Refused('an entry returns an array')
