# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Statements in C, and the function around them."""
import ast
from typing import Any

from gearbox_monitor.kernels.translate.expressions import Expressions
from gearbox_monitor.kernels.translate.values import (
    constant, join, Known, Number, Object, OPEN, Record, Scalar, stored, Tuple, Type, type_of,
    Value, words)
from gearbox_monitor.kernels.types import unrolled

MOST_PASSES = 30
MOST_TURNS = 6  # of a loop that is written out
KEYWORDS = {'inline': 'GM_INLINE', 'apart': 'GM_APART'}


class Function(Expressions):
    """Translate a function for one combination of argument types: text, result."""

    text = ''
    complete = False  # whether it has a body of its own where its first argument is a usual one

    def translate(self) -> None:
        """Translate until no variable widens any more. Raises Refused."""
        for _ in range(MOST_PASSES):
            before = dict(self.variables), self.result
            self._pass()
            if (self.variables, self.result) == before:
                return
        self.refuse(self.node, 'types of variables that do not settle')

    def _pass(self) -> None:
        self.lines, self.known, self.depth, self.temporaries = [], {}, 1, 0
        self.loops: list[Any] = []  # None, or of an unrolled one {name, turn, what leaves it}
        spec = self.node.args
        names = [a.arg for a in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs)]
        names += [spec.vararg.arg] if spec.vararg else []
        parameters = []
        for name, kind in zip(names, self.types):
            if isinstance(kind, Known) and self.stores[name] == 1:
                self.known[name] = self.program.known(kind.value)
                continue
            if isinstance(kind, Known):
                self.refuse(self.node, f'{name}, which is assigned to, is constant here')
            kind = self.declare(name, kind, self.node)
            if stored(kind):
                parameters.append(f'{self.program.c_type(kind)} {name}_')
        chooses = self._leave_usual(names)
        ended = chooses or self._block(self.node.body) if isinstance(
            self.node.body, list) else self.s_Return(ast.Return(self.node.body))
        if not ended:
            self._give(Object(None), self.node)
        given = self.result or Known(None)
        result = self.program.c_type(given) if stored(given) else 'void'
        variables = [f'    {self.program.c_type(kind)} {name}_;' for name, kind in
                     self.variables.items() if name not in names and stored(kind)]
        keyword = KEYWORDS.get('inline' if chooses else getattr(
            self.function, 'placed', 'inline'), 'GM_STATIC')
        code = self.function.__code__
        file = code.co_filename.rpartition('gearbox_monitor/')[2]
        self.text = '\n'.join([
            f'/* {file}: {self.function.__qualname__} */',
            f'{keyword} {result} {self.name}({", ".join(parameters) or "void"})', '{',
            *variables, *self.lines, '}'])

    def _leave_usual(self, names: list[str]) -> bool:
        """Leave all to instances, a usual first argument folded in; return whether it has any."""
        usual = getattr(self.function, 'usual', ())
        if self.complete or not usual or not isinstance(self.types[0], Record):
            return False
        given = self.items(self.program.value(self.types[0], f'{names[0]}_'))
        firsts: list[Type] = [*map(Known, usual), self.types[0]]
        for first in firsts:
            if isinstance(first, Known):
                self.emit('if ({})'.format(' && '.join(
                    f'{self.number(item).c} == {self.number(constant(value)).c}'
                    for item, value in zip(given, first.value))))
            types = first, *self.types[1:]
            made = self.program.instance(self.function, types, True)
            call = '{}({})'.format(made.name, ', '.join(
                f'{name}_' for name, kind in zip(names, types) if stored(kind)))
            result = made.result or Known(None)
            self.emit('{')
            if not stored(result):
                self.emit(f'{call};')
            self._give(self.program.value(result, call), self.node)
            self.emit('}')
        return True

    def _block(self, body: list[Any]) -> bool:
        """Translate statements; return whether what follows them is never reached."""
        for node in body:
            method = getattr(self, f's_{type(node).__name__}', None)
            if method is None:
                self.refuse(node, f'statement {type(node).__name__}')
            if self.located(method, node):
                return True
        return False

    def _indented(self, body: list[Any], head: str = '') -> bool:
        if head:
            self.emit(head)
        self.depth += 1
        ended = self._block(body)
        self.depth -= 1
        return ended

    def s_Pass(self, node: Any) -> bool:
        return False

    def s_Expr(self, node: Any) -> bool:
        if not isinstance(node.value, ast.Constant):
            self.e(node.value)
        return False

    def s_Return(self, node: Any) -> bool:
        self._give(Object(None) if node.value is None else self.e(node.value), node)
        return True

    def _give(self, value: Value, node: Any) -> None:
        kind = type_of(value)
        new = kind if self.result is None else join(self.result, kind)
        if new is None:
            self.refuse(node, f'returns {words(self.result or kind)} and {words(kind)}')
        self.result = new
        self.emit(f'return {self.expression(value, new)};' if stored(new) else 'return;')

    # ------------------------------------------------------------------ assignments

    def s_Assign(self, node: Any) -> bool:
        value = self.e(node.value)
        if len(node.targets) > 1:
            value = self.settled(value)
        for target in node.targets:
            self._assign(target, value)
        return False

    def s_AnnAssign(self, node: Any) -> bool:
        if node.value is not None:
            self._assign(node.target, self.e(node.value))
        return False

    def _assign(self, target: Any, value: Value) -> None:
        if isinstance(target, ast.Name):
            self._name(target, value)
        elif isinstance(target, (ast.Tuple, ast.List)):
            items = self.items(value)
            if len(items) != len(target.elts):
                self.refuse(target, f'{len(items)} values for {len(target.elts)} names')
            if not (isinstance(value, Tuple) and value.name):
                items = [self.settled(item) for item in items]  # all before the first is assigned
            for part, item in zip(target.elts, items):
                self._assign(part, item)
        elif isinstance(target, ast.Subscript):
            before = len(self.lines)
            place = self.element(self.e(target.value), self.indices(target.slice))
            if len(self.lines) > before:  # the value is computed first
                value = self._before(before, [value])[0]
            self.store(place, value)
        else:
            self.refuse(target, f'an assignment to {type(target).__name__}')

    def _name(self, target: Any, value: Value) -> None:
        name = target.id
        if name == '_':
            return
        kind = type_of(value)
        fixed = isinstance(value, Scalar) and value.constant is not OPEN or not stored(kind)
        if fixed and self.stores[name] == 1:
            self.known[name] = value
            return
        kind = self.declare(name, kind if stored(kind) else self._open(value), target)
        if stored(kind):
            self.emit(f'{name}_ = {self.expression(value, kind)};')

    def _open(self, value: Value) -> Type:
        """Return the type of a constant as one of a variable."""
        made = join(type_of(value), type_of(Tuple(value.items, value.made_of))) if isinstance(
            value, Tuple) else None
        return made or type_of(value)

    def s_AugAssign(self, node: Any) -> bool:
        if isinstance(node.target, ast.Name):
            value = self.several([node.target, node.value])
            read = ast.Name(node.target.id, ast.Store())
            self._assign(ast.copy_location(read, node), self.binary(node.op, *value))
            return False
        if not isinstance(node.target, ast.Subscript):
            self.refuse(node, 'an assignment to this')
        place = self.element(self.e(node.target.value), self.indices(node.target.slice))
        before = len(self.lines)
        right = self.e(node.value)
        held = place
        if len(self.lines) > before:  # the left side is read first
            held = self._before(before, [place])[0]
        self.store(place, self.binary(node.op, held, right))
        return False

    # ------------------------------------------------------------------ branches and loops

    def s_If(self, node: Any) -> bool:
        test = self.truth(self.e(node.test))
        if test.constant is not OPEN:
            return self._block(node.body if test.constant else node.orelse)
        ended = self._indented(node.body, f'if ({test.c}) {{')
        other = self._indented(node.orelse, '} else {') if node.orelse else False
        self.emit('}')
        return ended and other

    def s_While(self, node: Any) -> bool:
        if node.orelse:
            self.refuse(node, 'else of a loop')
        self.emit('for (;;) {')
        self.depth += 1
        self.emit(f'if (!{self.truth(self.e(node.test)).c}) break;')
        self.depth -= 1
        self._turn(node.body)
        return False

    def _turn(self, body: list[Any]) -> None:
        """Translate the body of a loop of C."""
        self.loops.append(None)
        self._indented(body)
        self.loops.pop()
        self.emit('}')

    def s_Break(self, node: Any) -> bool:
        loop, ends = self.loops[-1], isinstance(node, ast.Break)
        if loop is None:
            self.emit('break;' if ends else 'continue;')
        else:
            label = f'{loop["name"]}_{"end" if ends else loop["turn"]}'
            loop['left'].add(label)
            self.emit(f'goto {label};')
        return True

    s_Continue = s_Break

    def s_For(self, node: Any) -> bool:
        if node.orelse:
            self.refuse(node, 'else of a loop')
        over = node.iter
        called = self.e(over.func) if isinstance(over, ast.Call) and isinstance(
            over.func, ast.Name) else None
        if isinstance(called, Object) and called.value in (range, unrolled):
            self._range(node, [self.number(self.settled(v)) for v in self.several(over.args)],
                        called.value is unrolled)
            return False
        if isinstance(called, Object) and called.value is enumerate and len(over.args) == 1:
            items: list[Value] = [Tuple([constant(i), item]) for i, item in enumerate(
                self.items(self.e(over.args[0])))]
        elif isinstance(called, Object) and called.value is zip and not over.keywords:
            columns = [self.items(value) for value in self.several(over.args)]
            items = [Tuple(list(row)) for row in zip(*columns)]
        else:
            items = self.items(self.e(over))
        self._unrolled(node, [self.settled(item) for item in items])
        return False

    def _range(self, node: Any, bounds: list[Scalar], written_out: bool) -> None:
        begin, end, *rest = bounds if len(bounds) > 1 else [self.number(constant(0)), *bounds]
        step = rest[0].constant if rest else 1
        if not isinstance(node.target, ast.Name) or any(b.type.kind == 'f' for b in bounds):
            self.refuse(node, 'such a range')
        up = rest[0].type.natural if step is OPEN else step > 0
        natural = begin.type.natural if up else end.constant is not OPEN and end.constant >= -1
        k, name, by = self.fresh('k'), node.target.id, rest[0].c if step is OPEN else str(step)
        last = self.cast(end, 'i')
        test = f'{k} {"<" if up else ">"} {last}'
        if step is OPEN and not up:
            test, natural = f'{by} > 0 ? {k} < {last} : {k} > {last}', False
        if written_out and end.constant is not OPEN and end.constant <= MOST_TURNS:
            self.emit('GM_UNROLLED')
        self.emit(f'for (int64_t {k} = {self.cast(begin, "i")}; {test}; {k} += {by}) {{')
        if name != '_':
            self.declare(name, Number('i', natural), node)
            self.emit(f'    {name}_ = {k};')
        self._turn(node.body)

    def _unrolled(self, node: Any, items: list[Value]) -> None:
        """Translate a loop over a tuple: its body for each item."""
        loop: dict[str, Any] = {'name': self.fresh('loop'), 'turn': 0, 'left': set()}
        self.loops.append(loop)
        for loop['turn'], item in enumerate(items):
            self.emit('{')
            self.depth += 1
            self._assign(node.target, item)
            self._block(node.body)
            self.depth -= 1
            self.emit('}')
            if f'{loop["name"]}_{loop["turn"]}' in loop['left']:
                self.emit(f'{loop["name"]}_{loop["turn"]}: ;')
        self.loops.pop()
        if f'{loop["name"]}_end' in loop['left']:
            self.emit(f'{loop["name"]}_end: ;')
