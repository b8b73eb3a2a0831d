# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Nobody writes into another's object: searches, fits, points and windows."""
import ast
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.diagnosis import joint
from gearbox_monitor.diagnosis.joint.windows import WindowRuns

MODULES = sorted(Path(joint.__file__).parent.glob('*.py'))


def written(node):
    """Return what the statement `node` assigns to."""
    if isinstance(node, ast.AugAssign):
        return [node.target]
    targets = node.targets if isinstance(node, ast.Assign) else []
    return [part for target in targets
            for part in (target.elts if isinstance(target, ast.Tuple) else [target])]


def foreign_writes(source):
    """Return the assignments to attributes of what is neither `self` nor a copy of it."""
    out = []
    for function in ast.walk(ast.parse(source)):
        if not isinstance(function, ast.FunctionDef):
            continue
        nodes = list(ast.walk(function))
        own = {'self'} | {ast.unparse(node.targets[0]) for node in nodes
                          if isinstance(node, ast.Assign)
                          and ast.unparse(node.value) == 'copy(self)'}
        for node in nodes:
            for target in written(node):
                attribute = False
                while isinstance(target, (ast.Attribute, ast.Subscript)):
                    attribute |= isinstance(target, ast.Attribute)
                    target = target.value
                if attribute and ast.unparse(target) not in own:
                    out.append(ast.unparse(node))
            if isinstance(node, ast.Call) and ast.unparse(node.func) == 'setattr':
                out.append(ast.unparse(node))
    return out


def test_a_module_writes_into_no_object_of_another():
    for path in MODULES:
        assert not foreign_writes(path.read_text(encoding='utf-8'))


WRITES = [
    'fit.score = 0.0', 'search.long.held_out[:] = True', 'a, search.smooth = 1, 2',
    'point.chi2[0] += 1.0', 'setattr(point, "z", 0)']


def test_such_a_write_is_seen():
    for statement in WRITES:
        assert foreign_writes(f'def f():\n    {statement}') == [
            ast.unparse(ast.parse(statement))]


def test_where_a_fit_stands_stays_as_it_is():
    runs = WindowRuns(None, None, np.zeros((2, 4)), np.zeros((2, 4)), np.zeros((2, 5, 1)))
    with pytest.raises(FrozenInstanceError):
        runs.states = np.ones((2, 4))
    moved = replace(runs, states=np.ones((2, 4)))
    assert (moved.states == 1.0).all() and (runs.states == 0.0).all()
