# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The rules of the ament linters, by plain tools: they themselves are not on PyPI."""
import ast
from configparser import ConfigParser
import subprocess
import sys

import pytest
from sources import MODULES, nodes, ROOT

REPORT = ROOT / 'gearbox_monitor/report'
SOURCES = ['gearbox_monitor', 'benchmarks', 'test', 'docs', 'setup.py']
HEADER = '# Copyright 2026 gearbox_monitor authors\n# SPDX-License-Identifier: Apache-2.0\n'
SCOPES = ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef
FORKS = ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler
pytestmark = pytest.mark.linter


def python_files():
    return [ROOT / 'setup.py', *(path for source in SOURCES
                                 for path in sorted((ROOT / source).rglob('*.py')))]


def check(tool, *arguments):
    pytest.importorskip(tool)
    result = subprocess.run([sys.executable, '-m', tool, *arguments], cwd=ROOT,
                            capture_output=True, text=True)
    assert result.returncode == 0, '\n' + result.stdout + result.stderr


def test_ruff_rules():
    check('ruff', 'check', *SOURCES)


@pytest.mark.system
def test_imports_are_in_the_order_of_ament_flake8():
    checker = pytest.importorskip('flake8_import_order.checker').ImportOrderChecker
    styles = pytest.importorskip('flake8_import_order.styles')
    setup = ConfigParser()
    setup.read(ROOT / 'setup.cfg')
    rules, wrong = setup['flake8'], []
    options = {'import_order_style': styles.lookup_entry_point(rules['import-order-style']),
               'application_import_names': rules['application-import-names'].split(',')}
    for path in python_files():
        text = path.read_text(encoding='utf-8')
        file = checker(str(path), ast.parse(text))
        file.lines, file.options = text.splitlines(keepends=True), options
        wrong += [f'{path.relative_to(ROOT)}:{error.lineno}: {error.code} {error.message}'
                  for error in file.check_order() if error.code not in rules['extend-ignore']]
    assert not wrong, '\n' + '\n'.join(wrong)


def test_spelling():
    check('codespell_lib', *SOURCES, 'config', *map(str, ROOT.glob('*.md')),
          'CHANGELOG.rst')


@pytest.mark.system
def test_types_of_the_core():
    check('mypy')


def test_page_templates_are_well_formed():
    check('djlint', str(REPORT / 'templates'), '--lint', '--profile', 'jinja',
          '--ignore', 'H021')  # places on an axis are computed: styles stand inline


def test_page_style_parses():
    tinycss2 = pytest.importorskip('tinycss2')
    pending = tinycss2.parse_stylesheet((REPORT / 'assets/page.css').read_text(encoding='utf-8'),
                                        skip_whitespace=True, skip_comments=True)
    assert len(pending) > 100
    while pending:
        node = pending.pop()
        assert node.type != 'error', f'page.css:{node.source_line}: {node.message}'
        if node.type == 'qualified-rule':
            pending += tinycss2.parse_declaration_list(node.content, skip_whitespace=True,
                                                       skip_comments=True)
        elif node.type == 'at-rule' and node.content is not None:
            pending += tinycss2.parse_rule_list(node.content, skip_whitespace=True,
                                                skip_comments=True)


def test_page_scripts_parse_and_are_strict():
    esprima = pytest.importorskip('esprima')
    for script in ('page.js', 'live.js'):
        tree = esprima.parseScript((REPORT / 'assets' / script).read_text(encoding='utf-8'))
        scope, = tree.body  # one function, so that nothing is global
        assert scope.expression.callee.body.body[0].directive == 'use strict', script


def branch_points(function):
    """Return how often the function forks, the functions inside it left out."""
    inner = [node for node in ast.iter_child_nodes(function) if not isinstance(node, SCOPES)]
    return sum(isinstance(node, FORKS) + branch_points(node) for node in inner)


def test_functions_fork_at_most_twelve_times():
    """All but kernels, whose loops go over indices."""
    many = []
    for path in MODULES:
        for node in nodes(path):
            if isinstance(node, SCOPES[1:]) and branch_points(node) > 12:
                marks = {mark.id for mark in node.decorator_list if isinstance(mark, ast.Name)}
                if not marks & {'entry', 'kernel', 'inline', 'apart'}:
                    many.append(f'{path.relative_to(ROOT)}:{node.lineno}: {node.name}')
    assert not many, '\n'.join(many)


def test_licence_headers():
    missing = []
    for path in python_files():
        text = path.read_text(encoding='utf-8')
        if text.startswith('#!'):
            text = text.split('\n', 1)[1]
        if text and not text.startswith(HEADER):
            missing.append(str(path.relative_to(ROOT)))
    assert not missing, 'no licence header: ' + ' '.join(missing)
