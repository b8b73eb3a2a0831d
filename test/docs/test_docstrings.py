# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Every argument of a public function of the core is explained where a reader looks for it."""
import ast
from pathlib import Path
import re

import pytest

PACKAGE = Path(__file__).parents[2] / 'gearbox_monitor'
CORE = [path for name in ('kernels', 'plant', 'estimation', 'monitoring', 'identification')
        for path in sorted((PACKAGE / name).rglob('*.py'))]
# "see ekf.step", "arguments as of step", "as propagate": that docstring counts, too.
REFERENCE = re.compile(r'\b(?:see|as of|as for|as)\s+((?:\w+\.)?\w+)')


def functions(body, above=''):
    """Yield (function, docstrings of the class around it), of public ones, also under an if."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith('_'):
            yield from functions(node.body, ast.get_docstring(node) or '')
        elif isinstance(node, ast.If):
            yield from functions([*node.body, *node.orelse], above)
        elif isinstance(node, ast.FunctionDef) and (
                node.name == '__init__' or not node.name.startswith('_')) and not any(
                ast.unparse(d).endswith('.setter') for d in node.decorator_list):
            yield node, above


def texts(path):
    """Return {name of a function: its docstring} of a module, also by module.name."""
    found = {}
    for node, _ in functions(ast.parse(path.read_text(encoding='utf-8')).body):
        text = ast.get_docstring(node) or ''
        found.setdefault(node.name, text)
        found.setdefault(f'{path.stem}.{node.name}', text)
    return found


TEXTS = {path: texts(path) for path in CORE}
ELSEWHERE = {name: text for found in TEXTS.values() for name, text in found.items()
             if '.' in name}


def undocumented(source, others):
    """
    Return 'function: argument' for each that no docstring names.

    Looked at are those of function, class and module, and of the function that it refers to.
    """
    tree, missing = ast.parse(source), []
    for node, above in functions(tree.body):
        told = ast.get_docstring(node) or ''
        while True:
            more = [others[name] for name in REFERENCE.findall(told) if name in others]
            if all(text in told for text in more):
                break
            told = '\n'.join([told, *more])
        told = '\n'.join([told, above, ast.get_docstring(tree) or ''])
        a = node.args
        arguments = [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]
        missing += [f'{node.name}: {x.arg}' for x in arguments if x is not None
                    and x.arg not in ('self', 'cls') and not re.search(rf'\b{x.arg}\b', told)]
    return missing


def test_what_is_not_explained_is_found():
    source = 'def f(x, rate):\n    """Return x, see other.g."""\n'
    assert undocumented(source, {}) == ['f: rate']
    assert undocumented(source, {'other.g': 'rate: Hz.'}) == []


@pytest.mark.parametrize('path', CORE, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_arguments_are_explained(path):
    here = {name: text for name, text in TEXTS[path].items() if '.' not in name}
    assert undocumented(path.read_text(encoding='utf-8'), {**ELSEWHERE, **here}) == []
