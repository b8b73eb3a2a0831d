# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Elements and parts of arrays in C: indices as Python counts them, slices, copies, methods."""
import ast
from typing import Any, TypeAlias

from gearbox_monitor.kernels.translate.frame import Frame
from gearbox_monitor.kernels.translate.values import (
    Array, constant, ELEMENTS, NATURAL, OPEN, Refused, Scalar, Tuple, type_of, Value, View,
    words)

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
