# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Expressions in C, in the order in which Python evaluates them.

What has effects (a call) is written as a statement into a temporary; operands before it that it
might change are written before it.
"""
import ast
from collections.abc import Callable, Sequence
import math
import operator
from types import FunctionType
from typing import Any

import numpy as np

from gearbox_monitor.kernels.translate.frame import Arrays, plain
from gearbox_monitor.kernels.translate.values import (
    alike, BOOL, constant, definition, FLOAT, INT, join, Known, NATURAL, Number, Object, OPEN,
    Record, Refused, Scalar, stored, Tuple, type_of, Value, View, words)

OPERATORS: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ('+', operator.add), ast.Sub: ('-', operator.sub), ast.Mult: ('*', operator.mul),
    ast.Div: ('/', operator.truediv), ast.FloorDiv: ('gm_div', operator.floordiv),
    ast.Mod: ('gm_mod', operator.mod), ast.BitAnd: ('&', operator.and_),
    ast.BitOr: ('|', operator.or_), ast.BitXor: ('^', operator.xor),
    ast.LShift: ('<<', operator.lshift), ast.RShift: ('>>', operator.rshift)}
SIGNS: dict[type, tuple[str, Callable[[Any], Any]]] = {
    ast.USub: ('-', operator.neg), ast.UAdd: ('+', operator.pos),
    ast.Invert: ('~', operator.invert)}
BITWISE = (ast.BitAnd, ast.BitOr, ast.BitXor, ast.LShift, ast.RShift)
COMPARISONS: dict[type, tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ('<', operator.lt), ast.LtE: ('<=', operator.le), ast.Gt: ('>', operator.gt),
    ast.GtE: ('>=', operator.ge), ast.Eq: ('==', operator.eq), ast.NotEq: ('!=', operator.ne)}
CASTS = {int: 'i', np.int64: 'i', np.uint64: 'u', float: 'f', np.float64: 'f'}
# Of the C library; a filter needs none of them but sqrt and log.
MATH = ('sqrt', 'exp', 'log', 'sin', 'cos', 'tan', 'atan', 'atan2', 'tanh', 'sinh', 'cosh', 'asin',
        'acos', 'hypot', 'pow', 'copysign', 'expm1', 'log1p', 'fabs')
BUILT_IN = {len: 'length', bool: 'truth', abs: '_absolute', tuple: '_tuple', range: '_turns_of'}
MAX_POWER, FOREIGN = 16, ('numpy', 'scipy')


class Expressions(Arrays):
    """Translate expressions."""

    def e(self, node: Any) -> Value:
        """Return the value of an expression."""
        method = getattr(self, f'e_{type(node).__name__}', None)
        if method is None:
            self.refuse(node, f'expression {type(node).__name__}')
        value: Value = self.located(method, node)
        return value

    def several(self, nodes: Sequence[Any]) -> list[Value]:
        """Return the values of `nodes`, one after the other."""
        values: list[Value] = []
        for node in nodes:
            before = len(self.lines)
            value = self.e(node.value if isinstance(node, ast.Starred) else node)
            if len(self.lines) > before:
                values = self._before(before, values)
            values += self.items(value) if isinstance(node, ast.Starred) else [value]
        return values

    def _before(self, place: int, values: list[Value]) -> list[Value]:
        """Settle `values` ahead of the lines from `place` on."""
        later, self.lines = self.lines[place:], self.lines[:place]
        values = [self.settled(v) for v in values]
        self.lines += later
        return values

    def apart(self, nodes: Sequence[Any]) -> tuple[list[Value], list[str]]:
        """Return the values of `nodes`, and the lines that compute them, taken out."""
        before = len(self.lines)
        values = self.several(nodes)
        later, self.lines = self.lines[before:], self.lines[:before]
        return values, later

    # ------------------------------------------------------------------ atoms

    def e_Constant(self, node: Any) -> Value:
        return constant(node.value)

    def e_Name(self, node: Any) -> Value:
        return self.lookup(node.id)

    def e_Tuple(self, node: Any) -> Value:
        return self.tuple_of(self.several(node.elts))

    def tuple_of(self, items: list[Value], made_of: Any = None) -> Tuple:
        """Return a tuple; a NamedTuple of constants is one, too."""
        made = Tuple(items, made_of)
        if made_of is not None:
            constants = [i.constant if isinstance(i, Scalar) else i.folded if isinstance(i, Tuple)
                         else i.value if isinstance(i, Object) else OPEN for i in items]
            if not any(c is OPEN for c in constants):
                made.folded = made_of(*constants)
        return made

    def e_Attribute(self, node: Any) -> Value:
        base, name = self.e(node.value), node.attr
        if isinstance(base, Object):
            if not hasattr(base.value, name):
                raise Refused(f'no attribute {name} of {base.value}')
            return self.program.known(getattr(base.value, name))
        if isinstance(base, Tuple) and base.made_of and name in base.made_of._fields:
            return base.items[base.made_of._fields.index(name)]
        if isinstance(base, View):
            return self.shape_of(base, name)
        raise Refused(f'attribute {name} of {words(type_of(base))}')

    def e_Subscript(self, node: Any) -> Value:
        base = self.e(node.value)
        if not isinstance(base, Tuple):
            before = len(self.lines)
            index = self.indices(node.slice)
            if len(self.lines) > before:
                base = self._before(before, [base])[0]
            return self.element(base, index)
        if isinstance(node.slice, ast.Slice):
            bounds = [None if b is None else self.number(self.e(b)).constant
                      for b in (node.slice.lower, node.slice.upper, node.slice.step)]
            if any(b is OPEN for b in bounds):
                raise Refused('a slice of a tuple whose bounds are no constants')
            return Tuple(base.items[slice(*bounds)])
        index_ = self.number(self.e(node.slice))
        if index_.constant is not OPEN:
            if not -len(base.items) <= index_.constant < len(base.items):
                raise Refused('an index beyond a tuple')
            return base.items[index_.constant]
        return self._chosen(base, index_)

    def _chosen(self, base: Tuple, index: Scalar) -> Value:
        """Return the item of a tuple at an index that is known at run time."""
        joined = type_of(base.items[0])
        for item in base.items[1:]:
            both = join(joined, type_of(item))
            if both is None:
                raise Refused('an index that is no constant into a tuple of several types')
            joined = both
        kind = Record((joined,) * len(base.items))
        if not stored(joined) or not alike(kind):
            raise Refused('an index that is no constant into such a tuple')
        name = base.name if type_of(base) == kind else ''
        if not name:
            name = self.fresh()
            self.emit(f'{self.program.c_type(kind)} {name} = {self.expression(base, kind)};')
        return self.program.value(joined, f'{name}.v[{self.place(index, str(len(base.items)))}]')

    # ------------------------------------------------------------------ operators

    def e_UnaryOp(self, node: Any) -> Value:
        value = self.e(node.operand)
        if isinstance(node.op, ast.Not):
            truth = self.truth(value)
            return self.boolean(not truth.constant) if truth.constant is not OPEN else Scalar(
                BOOL, f'(!{truth.c})')
        number = self.number(value)
        kind = INT if number.type.kind in 'ib' else number.type
        sign, fold = SIGNS[type(node.op)]
        if number.constant is not OPEN:
            return constant(fold(number.constant))
        if kind.kind == 'f' and sign == '~' or kind.kind == 'u' and sign == '-':
            raise Refused(f'{sign} of {words(kind)}')
        return Scalar(kind, f'({sign}{number.c})')

    def e_BinOp(self, node: Any) -> Value:
        left, right = self.several([node.left, node.right])
        return self.binary(node.op, left, right)

    def binary(self, op: Any, left: Value, right: Value) -> Value:
        """Return `left` op `right`."""
        if isinstance(left, Tuple) and isinstance(op, ast.Add):
            return Tuple(left.items + self.items(right))
        a, b, zero = self.number(left), self.number(right), False
        if isinstance(op, ast.Pow):
            return self._power(a, b)
        if type(op) not in OPERATORS:
            raise Refused(f'operator {type(op).__name__}')
        sign, fold = OPERATORS[type(op)]
        zero = isinstance(op, (ast.Div, ast.FloorDiv, ast.Mod)) and b.constant == 0
        kind = join(a.type, b.type)
        if not isinstance(kind, Number):
            raise Refused(f'{sign} of a uint64 and an int')
        if a.constant is not OPEN and b.constant is not OPEN and not zero and kind.kind != 'u':
            return constant(fold(a.constant, b.constant))
        if kind.kind == 'b':
            if isinstance(op, (ast.BitAnd, ast.BitOr, ast.BitXor)):
                return Scalar(BOOL, f'({a.c} {sign} {b.c})')
            kind = NATURAL
        if isinstance(op, ast.Div):
            kind = FLOAT
        if kind.kind == 'f' and (isinstance(op, BITWISE) or sign.startswith('gm_')):
            raise Refused(f'{type(op).__name__} of floats')
        x, y = self.cast(a, kind.kind), self.cast(b, kind.kind)
        if kind.kind != 'i':
            if sign.startswith('gm_'):
                raise Refused(f'{type(op).__name__} of a uint64')
            return Scalar(kind, f'({x} {sign} {y})')
        return self._of_integers(op, sign, (a, x), (b, y))

    def _of_integers(self, op: Any, sign: str, left: tuple[Scalar, str],
                     right: tuple[Scalar, str]) -> Scalar:
        (a, x), (b, y) = left, right
        of_a, of_b = (v.type.natural or v.type.kind == 'b' for v in (a, b))
        both = of_a and of_b
        if sign.startswith('gm_'):
            natural = both or isinstance(op, ast.Mod) and of_b
            c = f'({x} {"/" if sign == "gm_div" else "%"} {y})' if both else f'{sign}({x}, {y})'
            return Scalar(Number('i', natural), c)
        if isinstance(op, ast.LShift):
            return Scalar(Number('i', both), f'(int64_t)((uint64_t){x} << {y})')
        natural = {ast.Sub: False, ast.BitXor: both, ast.BitAnd: of_a or of_b,
                   ast.RShift: of_a}.get(type(op), both)
        return Scalar(Number('i', natural), f'({x} {sign} {y})')

    def _power(self, a: Scalar, b: Scalar) -> Value:
        if a.constant is not OPEN and b.constant is not OPEN:
            return constant(a.constant ** b.constant)
        small = isinstance(b.constant, int) and 0 < b.constant <= MAX_POWER
        if a.type.kind == 'f' or not small:
            raise Refused('** that is no small power of an integer, expected products, math.sqrt '
                          'or math.pow')
        value = self.number(self.settled(a))
        return Scalar(Number(a.type.kind, a.type.natural),
                      f'({" * ".join([value.c] * b.constant)})')

    def e_Compare(self, node: Any) -> Value:
        values = self.several([node.left, *node.comparators])
        if any(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops):
            return self._is(node.ops, values)
        numbers = list(map(self.number, values))
        numbers[1:-1] = [self.number(self.settled(v)) for v in numbers[1:-1]]
        parts: list[str] = []
        for op, a, b in zip(node.ops, numbers, numbers[1:]):
            sign, fold = COMPARISONS.get(type(op), ('', operator.eq))
            kind = join(a.type, b.type)
            if not sign or not isinstance(kind, Number):
                raise Refused(f'{type(op).__name__} of {words(a.type)} and {words(b.type)}')
            if a.constant is OPEN or b.constant is OPEN:
                parts.append(f'({self.cast(a, kind.kind)} {sign} {self.cast(b, kind.kind)})')
            elif not fold(a.constant, b.constant):
                return self.boolean(False)
        return Scalar(BOOL, f'({" && ".join(parts)})') if parts else self.boolean(True)

    def _is(self, ops: list[Any], values: list[Value]) -> Value:
        none = [isinstance(v, Object) and v.value is None for v in values]
        if len(ops) > 1 or not none[-1]:
            raise Refused('is, with something else than None')
        return self.boolean(none[0] == isinstance(ops[0], ast.Is))

    def e_BoolOp(self, node: Any) -> Value:
        both = isinstance(node.op, ast.And)
        left = self.truth(self.e(node.values[0]))
        for part in node.values[1:]:
            if left.constant is not OPEN and bool(left.constant) != both:
                return left
            (value,), lines = self.apart([part])
            right = self.truth(value)
            if left.constant is not OPEN:
                self.lines += lines
                left = right
            elif lines:  # only where it is asked for
                name = self.fresh()
                self.emit(f'bool {name} = {left.c};')
                self.emit(f'if ({"" if both else "!"}{name}) {{')
                self.lines += [*lines, f'{"    " * self.depth}{name} = {right.c};']
                self.emit('}')
                left = Scalar(BOOL, name, stable=True)
            elif right.constant is OPEN:
                left = Scalar(BOOL, f'({left.c} {"&&" if both else "||"} {right.c})')
            elif bool(right.constant) != both:
                left = right  # the left one has no effects
        return left

    def e_IfExp(self, node: Any) -> Value:
        test = self.truth(self.e(node.test))
        if test.constant is not OPEN:
            return self.e(node.body if test.constant else node.orelse)
        (a,), lines_a = self.apart([node.body])
        (b,), lines_b = self.apart([node.orelse])
        kind = join(type_of(a), type_of(b))
        if kind is None or isinstance(kind, Known):
            raise Refused(f'{words(type_of(a))} or {words(type_of(b))}')
        of_a, of_b = self.expression(a, kind), self.expression(b, kind)
        if isinstance(kind, Number) and not lines_a and not lines_b:
            return self.program.value(kind, f'({test.c} ? {of_a} : {of_b})')
        return self._either(kind, test, (of_a, lines_a), (of_b, lines_b))

    def _either(self, kind: Any, test: Scalar, *ways: tuple[str, list[str]]) -> Value:
        name, indent = self.fresh(), '    ' * (self.depth + 1)
        self.emit(f'{self.program.c_type(kind)} {name};')
        for (c, lines), head in zip(ways, (f'if ({test.c}) {{', '} else {')):
            self.emit(head)
            self.lines += [*lines, f'{indent}{name} = {c};']
        self.emit('}')
        return self.program.value(kind, name, stable=True)

    # ------------------------------------------------------------------ calls

    def e_GeneratorExp(self, node: Any) -> Value:
        """Return the items as a tuple, what a kernel makes of them: one for each of a tuple."""
        part, *rest = node.generators
        if rest or part.ifs or not isinstance(part.target, ast.Name):
            raise Refused('such a generator')
        values: list[Value] = []
        for item in self.items(self.e(part.iter)):
            self.turns[part.target.id] = item
            before = len(self.lines)
            value = self.e(node.elt)
            if len(self.lines) > before:
                values = self._before(before, values)
            values.append(value)
        self.turns.pop(part.target.id, None)
        return self.tuple_of(values)

    def e_Call(self, node: Any) -> Value:
        if isinstance(node.func, ast.Attribute):
            base = self.e(node.func.value)
            if isinstance(base, View):
                return self.method(base, node.func.attr, self.several(node.args))
        called = self.e(node.func)
        if not isinstance(called, Object):
            raise Refused(f'a call of {words(type_of(called))}')
        if any(k.arg is None for k in node.keywords):
            raise Refused('** in a call')
        values = self.several([*node.args, *(k.value for k in node.keywords)])
        count = len(values) - len(node.keywords)
        named = dict(zip([k.arg for k in node.keywords], values[count:]))
        return self.call(called.value, values[:count], named)

    def call(self, called: Any, values: list[Value], named: dict[str, Value]) -> Value:
        """Return what a call of a Python object gives."""
        called = self.program.stand_ins.get(called, called)
        function = plain(called)
        instruction = getattr(function, 'instruction', None)
        if instruction:
            return self._instruction(instruction, function.results, values)
        # The code of numpy and scipy is no kernel.
        if isinstance(function, FunctionType) and function.__module__.split('.')[0] not in FOREIGN:
            return self._of_kernel(function, values, named)
        if isinstance(called, type) and hasattr(called, '_fields'):
            return self._named_tuple(called, dict(zip(called._fields, values)) | named)
        if named:
            raise Refused(f'a name in a call of {called}')
        if called in BUILT_IN:
            made: Value = getattr(self, BUILT_IN[called])(*values)
            return made
        if called in (min, max):
            return self._extreme(called, values[0].items if isinstance(
                values[0], Tuple) else values)
        if called in CASTS:
            return self._as(CASTS[called], self.number(values[0]), called)
        if called in (math.isfinite, math.isnan, math.isinf):
            return Scalar(BOOL, f'(bool){called.__name__}({self._reals(values)})')
        if called in (math.floor, math.ceil):
            return Scalar(INT, f'(int64_t)gm_{called.__name__}({self._reals(values)})')
        if getattr(called, '__module__', '') == 'math' and called.__name__ in MATH:
            return Scalar(FLOAT, f'gm_{called.__name__}({self._reals(values)})')
        raise Refused(f'a call of {getattr(called, "__module__", "")}.'
                      f'{getattr(called, "__name__", called)}, which is no kernel')

    def _absolute(self, value: Value) -> Scalar:
        number = self.number(value)
        if number.type.kind == 'f':
            return Scalar(FLOAT, f'gm_fabs({number.c})')
        return Scalar(NATURAL, f'gm_abs_i({self.cast(number, "i")})')

    def _tuple(self, value: Value) -> Tuple:
        return self.tuple_of(self.items(value))

    def _turns_of(self, *values: Value) -> Tuple:
        bounds = [self.number(v).constant for v in values]
        if any(b is OPEN for b in bounds):
            raise Refused('a range whose bounds are no constants')
        return self.tuple_of([constant(i) for i in range(*bounds)])

    def _named_tuple(self, made_of: Any, given: dict[str, Value]) -> Value:
        defaults = made_of._field_defaults.items()
        fields = {name: self.program.known(value) for name, value in defaults} | given
        if set(fields) != set(made_of._fields):
            raise Refused(f'{made_of.__name__} with other fields')
        return self.tuple_of([fields[name] for name in made_of._fields], made_of)

    def _instruction(self, name: str, results: int, values: list[Value]) -> Value:
        if not results:
            return Scalar(FLOAT, f'{name}({self._reals(values)})')
        made = self.fresh()
        flat = [item for v in values for item in (v.items if isinstance(v, Tuple) else [v])]
        passed = [f'{v.pointer}, {v.shape[0]}' if isinstance(v, View) else self.number(v).c
                  for v in flat]
        self.emit(f'real {made}[{results}];')
        self.emit(f'{name}({", ".join([made, *passed])});')
        return Tuple([Scalar(FLOAT, f'{made}[{i}]', stable=True) for i in range(results)])

    def _reals(self, values: list[Value]) -> str:
        return ', '.join(self.cast(self.number(v), 'f') for v in values)

    def _as(self, kind: str, number: Scalar, called: Any) -> Scalar:
        if number.constant is not OPEN:
            return self.number(constant(called(number.constant)))
        natural = kind == 'u' or number.type.natural or number.type.kind == 'b'
        return Scalar(Number(kind, natural and kind != 'f'), self.cast(number, kind))

    def _extreme(self, called: Any, values: list[Value]) -> Value:
        """Return the least or the largest, of equal ones and beside NaN the one Python takes."""
        numbers = list(map(self.number, values))
        if all(n.constant is not OPEN for n in numbers):
            return constant(called(n.constant for n in numbers))
        kind = 'f' if any(n.type.kind == 'f' for n in numbers) else 'i'
        if any(n.type.kind == 'u' for n in numbers):
            raise Refused(f'{called.__name__} of a uint64')
        c = self.cast(numbers[0], kind)
        for n in numbers[1:]:
            c = f'gm_{called.__name__}_{kind}({c}, {self.cast(n, kind)})'
        some = any if called is max else all
        return Scalar(Number(kind, kind == 'i' and some(n.type.natural for n in numbers)), c)

    def _of_kernel(self, function: FunctionType, values: list[Value],
                   named: dict[str, Value]) -> Value:
        spec = definition(function).args
        names = [a.arg for a in (*spec.posonlyargs, *spec.args)]
        defaults = dict(zip(names[::-1], (function.__defaults__ or ())[::-1]))
        defaults |= function.__kwdefaults__ or {}
        rest = values[len(names):]
        given = dict(zip(names, values)) | named
        names += [a.arg for a in spec.kwonlyargs]
        if len(given) < len(values) - len(rest) + len(named) or set(given) - set(names) or (
                rest and not spec.vararg):
            raise Refused(f'other arguments than {function.__qualname__} takes')
        for name in (name for name in names if name not in given | defaults):
            raise Refused(f'{function.__qualname__} without {name}')
        passed = [given[n] if n in given else self.program.known(defaults[n]) for n in names]
        if spec.vararg:
            passed.append(Tuple(rest))
        types = tuple(map(type_of, passed))
        made = self.program.instance(function, types)
        c = ', '.join(self.expression(v, t) for v, t in zip(passed, types) if stored(t))
        call, result = f'{made.name}({c})', made.result or Known(None)
        if stored(result):
            return self.temporary(self.program.value(result, call))
        self.emit(f'{call};')
        return self.program.value(result, '')
