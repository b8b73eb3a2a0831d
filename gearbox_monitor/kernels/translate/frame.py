# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a function under translation is made of: variables, arrays, temporaries, lines of C."""
import ast
from collections import Counter
from functools import cache
from types import FunctionType
from typing import Any, NoReturn, TypeAlias

from gearbox_monitor.kernels.translate.values import (
    alike, Array, C_NUMBERS, constant, definition, ELEMENTS, integer, join, NATURAL, Number,
    Object, OPEN, real, Record, Refused, Scalar, stored, Tuple, Type, type_of, Value, View, words)


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


Slice: TypeAlias = tuple[Value | None, Value | None, int]  # from, to, step


class Arrays(Frame):
    """Translate what has to do with arrays."""

    def e(self, node: Any) -> Value:
        """Return the value of an expression."""
        raise NotImplementedError

    def indices(self, node: Any) -> list[Scalar | Slice]:
        """Return the indices and slices in the brackets of a subscript."""
        found: list[Scalar | Slice] = []
        for part in node.elts if isinstance(node, ast.Tuple) else [node]:
            if isinstance(part, ast.Slice):
                step = 1 if part.step is None else getattr(self.e(part.step), 'constant', OPEN)
                if not isinstance(step, int) or step < 1:
                    self.refuse(part, 'a slice with a step that is no constant > 0')
                bounds = [None if b is None else self.settled(self.e(b))
                          for b in (part.lower, part.upper)]
                found.append((bounds[0], bounds[1], step))
                continue
            value = self.e(part)
            found += map(self.number, value.items if isinstance(value, Tuple) else [value])
        return found

    def place(self, index: Scalar, length: str) -> str:
        """Return where an index stands in a dimension of that length."""
        if index.type.kind == 'f':
            raise Refused('a float as an index')
        if index.constant is not OPEN:
            i = int(index.constant)
            return str(i) if i >= 0 else f'({length} - {-i})'
        natural = index.type.natural or index.type.kind == 'b'
        return f'({index.c})' if natural else f'gm_at({index.c}, {length})'

    def element(self, array: Value, index: list[Scalar | Slice]) -> Value:
        """Return the element (something to write to, too) or the part of an array at an index."""
        if not isinstance(array, View):
            raise Refused(f'an index into {words(type_of(array))}')
        if len(index) > array.type.ndim:
            raise Refused('too many indices')
        if len(index) < array.type.ndim or not all(isinstance(i, Scalar) for i in index):
            return self._part(array, index)
        numbers = [i for i in index if isinstance(i, Scalar)]
        places = [self.place(i, n) for i, n in zip(numbers, array.shape)]
        if array.data is not None and all(i.constant is not OPEN for i in numbers):
            return constant(array.data[tuple(i.constant for i in numbers)])
        if array.strides is None:
            offset = places[0]
            for p, n in zip(places[1:], array.shape[1:]):
                offset = p if offset == '0' else f'({offset} * {n} + {p})'
        else:
            offset = ' + '.join(f'{p} * {s}' for p, s in zip(places, array.strides))
        pointer = array.pointer if array.name else f'({array.pointer})'
        return Scalar(ELEMENTS[array.type.element][1], f'{pointer}[{offset}]')

    def _part(self, array: View, index: list[Scalar | Slice]) -> View:
        offsets: list[str] = []
        shape: list[str] = []
        steps: list[str] = []
        contiguous = array.strides is None
        strides = array.steps()
        for k, (n, s) in enumerate(zip(array.shape, strides)):
            i = index[k] if k < len(index) else (None, None, 1)
            if isinstance(i, Scalar):
                offsets.append(f'{self.place(i, n)} * ({s})')
                contiguous &= not shape
                continue
            low, high, step = i
            whole = low is None and high is None and step == 1
            contiguous &= step == 1 and (whole or not shape)
            begin, length = '0', n
            if not whole:
                if low is not None and getattr(low, 'constant', OPEN) != 0:
                    begin = self.whole(f'gm_bound({self.number(low).c}, {n})')
                length = n if high is None else self.whole(
                    f'gm_bound({self.number(high).c}, {n})')
                if begin != '0':
                    offsets.append(f'{begin} * ({s})')
                    length = self.whole(f'gm_span({begin}, {length})')
                if step > 1:
                    length = self.whole(f'({length} + {step - 1}) / {step}')
            shape.append(length)
            steps.append(s if step == 1 else f'({s}) * {step}')
        pointer = ' + '.join([array.pointer, *offsets])
        return View(Array(array.type.element, len(shape), contiguous), pointer, shape,
                    None if contiguous else steps)

    def store(self, place: Value, value: Value) -> None:
        """Write `value` to an element; into a part of an array a number, or an array like it."""
        if isinstance(place, Scalar):
            if place.constant is not OPEN:
                raise Refused('a constant array is written to')
            self.emit(f'{place.c} = {self.cast(self.number(value), place.type.kind)};')
            return
        target = self.temporary(place)
        value = self.temporary(value) if isinstance(value, View) else self.settled(value)
        assert isinstance(target, View)
        if isinstance(value, View) and value.type.ndim != target.type.ndim:
            raise Refused('an array is written into one of other dimensions')
        counters = []
        for n in target.shape:
            counters.append(self.fresh('k'))
            self.emit(f'for (int64_t {counters[-1]} = 0; {counters[-1]} < {n}; {counters[-1]}++)')
        source = self._at(value, counters) if isinstance(value, View) else self.number(value)
        self.emit(f'    {self._at(target, counters).c} = '
                  f'{self.cast(source, ELEMENTS[target.type.element][1].kind)};')

    def _at(self, array: View, counters: list[str]) -> Scalar:
        offset = ' + '.join(f'{k} * ({s})' for k, s in zip(counters, array.steps()))
        return Scalar(ELEMENTS[array.type.element][1], f'{array.pointer}[{offset}]')

    # ------------------------------------------------------------------ attributes and methods

    def length(self, value: Value) -> Value:
        """Return len(value)."""
        if isinstance(value, View):
            return self._natural(value.shape[0])
        return constant(len(self.items(value)))

    def _natural(self, c: str) -> Scalar:
        return Scalar(NATURAL, c, int(c) if c.isdigit() else OPEN, True)

    def shape_of(self, array: View, name: str) -> Value:
        """Return the attribute shape of an array."""
        if name != 'shape':
            raise Refused(f'attribute {name} of an array')
        return Tuple([self._natural(n) for n in array.shape])

    def method(self, array: View, name: str, arguments: list[Value]) -> Value:
        """Return what a method of an array returns: reshape to numbers that are stated."""
        if name != 'reshape':
            raise Refused(f'method {name} of an array')
        if array.strides is not None:
            raise Refused(f'{name} of an array that is not contiguous')
        shape = [self.whole(self.number(n).c) for n in arguments]
        return View(Array(array.type.element, len(shape)), array.pointer, shape)
