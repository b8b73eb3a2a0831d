# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a function under translation is made of: its variables, its lines of C, its temporaries."""
import ast
from collections import Counter
from functools import cache
from types import FunctionType
from typing import Any, NoReturn

from gearbox_monitor.kernels.translate.values import (
    alike, Array, C_NUMBERS, definition, integer, join, Number, Object, OPEN, real, Record,
    Refused, Scalar, stored, Tuple, Type, type_of, Value, View, words)


def plain(function: Any) -> Any:
    """Return the Python function of a kernel."""
    return getattr(function, '__wrapped__', function)


@cache
def _stores(node: Any) -> Counter[str]:
    """Return how often each name is assigned in a definition, arguments included."""
    names = [sub.arg if isinstance(sub, ast.arg) else sub.id for sub in ast.walk(node)
             if isinstance(sub, ast.arg) or isinstance(sub, ast.Name) and isinstance(
                 sub.ctx, ast.Store)]
    return Counter(names)


class Frame:
    """
    A function for one combination of argument types.

    program: the Program that it is for; function: the Python of it; types: of its arguments.

    Attributes:
        variables: {name: type of what it may hold}, which widens from pass to pass.
        known: {name: value} of names that are assigned once, a constant.
        turns: {name: its present value} of generators.
        result: type of what it returns; None: no return was seen.
    """

    def __init__(self, program: Any, function: FunctionType, types: tuple[Type, ...]) -> None:
        self.program, self.function, self.types = program, function, types
        self.node = definition(function)
        code = function.__code__
        self.locals = {*code.co_varnames, *code.co_cellvars}
        self.cells = dict(zip(code.co_freevars,
                              (cell.cell_contents for cell in function.__closure__ or ())))
        self.name = program.unique(
            f'{function.__module__.rpartition(".")[2]}_{code.co_name.strip("_<>")}')
        self.variables: dict[str, Type] = {}
        self.known: dict[str, Value] = {}
        self.turns: dict[str, Value] = {}
        self.result: Type | None = None
        self.lines: list[str] = []
        self.depth = self.temporaries = 0
        self.stores = _stores(self.node)

    def refuse(self, node: Any, what: str) -> NoReturn:
        """Raise Refused that names the line of `node`."""
        line = getattr(node, 'lineno', self.function.__code__.co_firstlineno)
        raise Refused(f'{self.function.__code__.co_filename}:{line}: {what} '
                      f'(in {self.function.__qualname__})')

    def located(self, method: Any, node: Any) -> Any:
        """Return method(node); what is refused in it without a place is refused there."""
        try:
            return method(node)
        except Refused as error:
            if '.py:' in str(error):
                raise
            self.refuse(node, str(error))

    # ------------------------------------------------------------------ lines and names

    def emit(self, line: str) -> None:
        """Add a line of C."""
        self.lines.append('    ' * self.depth + line)

    def fresh(self, letter: str = 't') -> str:
        """Return a name of C that no name of Python has."""
        self.temporaries += 1
        return f'{letter}{self.temporaries}'

    def temporary(self, value: Value) -> Value:
        """Return `value` in a variable of its own, which is written here."""
        kind = type_of(value)
        if not stored(kind):
            return value
        name = self.fresh()
        self.emit(f'{self.program.c_type(kind)} {name} = {self.expression(value, kind)};')
        return self.program.value(kind, name, stable=True)

    def settled(self, value: Value) -> Value:
        """Return `value` such that statements which follow do not change it."""
        if isinstance(value, Scalar):
            return value if value.stable else self.temporary(value)
        if isinstance(value, Tuple):
            items = [self.settled(item) for item in value.items]
            same = all(a is b for a, b in zip(items, value.items))
            return value if same else Tuple(items, value.made_of, '', value.folded)
        return value

    def whole(self, c: str) -> str:
        """Return the name of a new variable with the int64 `c`."""
        if c.isidentifier() or c.isdigit():
            return c
        name = self.fresh()
        self.emit(f'int64_t {name} = {c};')
        return name

    def declare(self, name: str, kind: Type, node: Any) -> Type:
        """Return the type of the variable `name`, which is to hold a `kind`, too."""
        old = self.variables.get(name)
        new = kind if old is None else join(old, kind)
        if new is None:
            self.refuse(node, f'{name} is {words(old or kind)} and later {words(kind)}')
        self.variables[name] = new
        return new

    # ------------------------------------------------------------------ values

    def number(self, value: Value) -> Scalar:
        """Return `value`, a number. Raises Refused."""
        if not isinstance(value, Scalar):
            raise Refused(f'{words(type_of(value))} in place of a number')
        return value

    def items(self, value: Value) -> list[Value]:
        """Return the items of a tuple. Raises Refused."""
        if not isinstance(value, Tuple):
            raise Refused(f'{words(type_of(value))} in place of a tuple')
        return value.items

    def cast(self, value: Scalar, kind: str) -> str:
        """Return the C expression of a number as one of a `kind`."""
        if value.constant is not OPEN and kind in 'fi':
            return real(float(value.constant)) if kind == 'f' else integer(int(value.constant))
        return value.c if value.type.kind == kind else f'({C_NUMBERS[kind]})({value.c})'

    def expression(self, value: Value, kind: Type) -> str:
        """Return the C expression of `value` as a `kind`. Raises Refused."""
        if isinstance(kind, Number):
            return self.cast(self.number(value), kind.kind)
        if isinstance(kind, Array) and isinstance(value, View):
            if value.name and value.type == kind:
                return value.name
            inner = f'{value.pointer}, {{{", ".join(value.shape)}}}'
            if not kind.contiguous:
                inner += f', {{{", ".join(value.steps())}}}'
            return f'({self.program.c_type(kind)}){{{inner}}}'
        if isinstance(kind, Record) and isinstance(value, Tuple):
            name = self.program.c_type(kind)
            if value.name and self.program.c_type(type_of(value)) == name:
                return value.name
            inner = ', '.join(self.expression(item, k)
                              for item, k in zip(value.items, kind.items) if stored(k))
            return f'({name}){{{{{inner}}}}}' if alike(kind) else f'({name}){{{inner}}}'
        raise Refused(f'{words(type_of(value))} in place of {words(kind)}')

    def truth(self, value: Value) -> Scalar:
        """Return whether `value` is true, a bool."""
        if isinstance(value, Object):
            return self.boolean(bool(value.value))
        number = self.number(value)
        if number.constant is not OPEN:
            return self.boolean(bool(number.constant))
        return number if number.type.kind == 'b' else Scalar(Number('b'), f'({number.c} != 0)')

    def boolean(self, value: bool) -> Scalar:
        """Return the constant `value`."""
        return Scalar(Number('b'), 'true' if value else 'false', value)

    def lookup(self, name: str) -> Value:
        """Return what `name` stands for. Raises Refused."""
        if name in self.turns:
            return self.turns[name]
        if name in self.locals:
            if name in self.known:
                return self.known[name]
            if name not in self.variables:
                raise Refused(f'{name} is read before it is assigned')
            return self.program.value(self.variables[name], f'{name}_',
                                      self.stores.get(name, 0) <= 1)
        if name in self.cells:
            return self.program.known(self.cells[name])
        names = self.function.__globals__
        builtins = names['__builtins__']
        builtins = builtins if isinstance(builtins, dict) else vars(builtins)
        if name not in names and name not in builtins:
            raise Refused(f'unknown name {name}')
        return self.program.known(names[name] if name in names else builtins[name])
