# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page and the notebook about Python run, and so do the doctests of the public functions."""
import doctest
from importlib import import_module
import json
from pathlib import Path
import re
import runpy

import pytest

import gearbox_monitor as gm
from gearbox_monitor.cli.main import main

DOCS = Path(__file__).parents[2] / 'docs'
PAGE = (DOCS / 'python.md').read_text(encoding='utf-8')
NOTEBOOK = (DOCS / 'python.ipynb').read_text(encoding='utf-8')
MODULES = sorted({f'gearbox_monitor.{module}' for module in gm._PUBLIC.values()})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in an empty folder, where pandas is installed."""
    pytest.importorskip('pandas')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(blocks):
    """Execute blocks of code one after the other; return their names."""
    names = {}
    for block in blocks:
        exec(compile(block, 'block', 'exec'), names)
    return names


def blocks_of(*sections):
    """Return the Python blocks of sections of the page, of all without any."""
    parts = [part for part in re.split(r'^## ', PAGE, flags=re.MULTILINE)
             if not sections or part.partition('\n')[0] in sections]
    return [block for part in parts
            for block in re.findall(r'```python\n(.*?)```', part, re.DOTALL)]


def test_notebook_is_made_of_the_page():
    made = runpy.run_path(str(DOCS / 'make_notebook.py'))['notebook'](PAGE)
    assert made == NOTEBOOK, 'run python docs/make_notebook.py'
    data = json.loads(NOTEBOOK)
    assert (data['nbformat'], sum(c['cell_type'] == 'code' for c in data['cells'])) == (4, 8)


def test_a_file_is_read_and_a_mistake_is_named(folder, capsys):
    names = run(blocks_of('A recording', 'Errors'))
    read, said = capsys.readouterr().out.splitlines()
    assert f'print(run1)       # {read}\n' in PAGE
    assert f'print(error)                  # {said}\n' in PAGE
    assert names['run1'].name == 'run1.csv'


@pytest.mark.system
def test_whole_page(folder, capsys):
    assert main(['example', 'arm', '--robot']) == 0
    capsys.readouterr()
    names = run(blocks_of())
    assert (folder / 'page.html').is_file() and (folder / 'params.yaml').is_file()
    assert names['change'].findings[0].effect == 'payload'
    output = capsys.readouterr().out
    shown = re.findall(r'^print\([\w.]+\) +# (.*)$', '\n'.join(blocks_of()), re.MULTILINE)
    assert len(shown) == 8
    for words in shown:  # what stands beside a print is what it prints, up to the dots
        assert words.partition('...')[0].strip() in output, words


@pytest.mark.system
def test_cells_of_the_notebook(folder):
    names = run(''.join(cell['source']) for cell in json.loads(NOTEBOOK)['cells']
                if cell['cell_type'] == 'code')
    assert names['verdict'].effect == 'gravity'


def test_doctests():
    for module in MODULES:
        failed, _ = doctest.testmod(import_module(module))
        assert not failed


def test_public_functions_have_doctests():
    quick = ('simulate', 'load_model', 'load_recording', 'estimate', 'backlash', 'export_model')
    assert [name for name in quick if '>>>' not in getattr(gm, name).__doc__] == []
