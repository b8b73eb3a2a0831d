# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Public functions name their arguments in their own docstring, where a reader looks for them."""
import ast
from collections.abc import Iterator
import re

from sources import MODULES, PACKAGE, tree

SHARE = 0.05  # of all arguments that may go unnamed: those that a name and a type explain


def functions(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    """Yield the public functions and methods in `body`; those inside a function are not public."""
    for node in body:
        if isinstance(node, ast.ClassDef):
            yield from functions(node.body)
        elif isinstance(node, ast.If):
            yield from functions([*node.body, *node.orelse])
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith('_'):
            yield node


def unnamed(module: ast.Module) -> Iterator[tuple[str, bool]]:
    """Yield ('function: argument', whether its docstring lacks it) of public ones in `module`."""
    for node in functions(module.body):
        text = ast.get_docstring(node) or ''
        a = node.args
        for argument in (*a.posonlyargs, *a.args, *a.kwonlyargs):
            if argument.arg not in ('self', 'cls'):
                yield (f'{node.name}: {argument.arg}',
                       not re.search(rf'\b{argument.arg}\b', text))


def test_an_argument_without_a_word_is_detected():
    source = 'def f(x, rate):\n    """Return x."""\ndef _g(y):\n    """Return it."""\n'
    assert list(unnamed(ast.parse(source))) == [('f: x', False), ('f: rate', True)]


def test_arguments_are_named_in_their_own_docstring():
    rows = [(f'{path.relative_to(PACKAGE)}: {name}', missing)
            for path in MODULES for name, missing in unnamed(tree(path))]
    missing = [name for name, is_missing in rows if is_missing]
    assert len(missing) <= SHARE * len(rows), '\n'.join(missing)
