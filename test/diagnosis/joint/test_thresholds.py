# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Thresholds of the verdict: in one place, none of them idle."""
import ast
from dataclasses import fields, FrozenInstanceError
from pathlib import Path

import pytest
from sources import nodes, tree

from gearbox_monitor.diagnosis import joint
from gearbox_monitor.diagnosis.settings import (
    CONTEST, ContestSettings, STATEMENTS, Statements, THRESHOLDS, Thresholds)

FOLDER = Path(joint.__file__).parent
# Modules that decide; the others measure and fit.
DECIDING = ('decision', 'diagnose', 'drive_recordings', 'localisation', 'verdict')


def test_thresholds_stay_as_they_are():
    for constants, name in ((THRESHOLDS, 'isolable'), (STATEMENTS, 'gap'), (CONTEST, 'margin')):
        with pytest.raises(FrozenInstanceError):
            setattr(constants, name, 0.0)


@pytest.mark.parametrize('name, kind', [
    ('THRESHOLDS', Thresholds), ('STATEMENTS', Statements), ('CONTEST', ContestSettings)])
def test_every_threshold_is_used(name, kind):
    used = {node.attr for path in FOLDER.parent.rglob('*.py') for node in nodes(path)
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == name}
    assert used == {field.name for field in fields(kind)}


def test_no_decision_has_a_threshold_of_its_own():
    """Nothing is compared with a number that the module itself defines, but 0 and 1."""
    for module in DECIDING:
        path = FOLDER / f'{module}.py'
        numbers = {target.id for node in tree(path).body if isinstance(node, ast.Assign)
                   for target in node.targets if isinstance(target, ast.Name)
                   and isinstance(node.value, ast.Constant)
                   and isinstance(node.value.value, float)}
        own = [ast.unparse(node) for node in nodes(path) if isinstance(node, ast.Compare)
               for part in ast.walk(node)
               if (isinstance(part, ast.Name) and part.id in numbers)
               or (isinstance(part, ast.Constant) and isinstance(part.value, float)
                   and part.value not in (0.0, 1.0))]
        assert not own
