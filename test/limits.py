# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What tests of limits read in the sources of a room: limits in use, and loose numbers."""
import ast
from dataclasses import fields
from pathlib import Path
import re

from sources import nodes, tree


def assert_decides(decision, value):
    """Assert that `decision` changes at `value`, and nowhere else near it."""
    below, above = decision((1.0 - 1e-6) * value), decision((1.0 + 1e-6) * value)
    assert below != above
    assert below == decision((1.0 - 1e-4) * value)
    assert above == decision((1.0 + 1e-4) * value)


def assert_all_decide(room, limits, module):
    """Assert that the package uses each field of `limits`, of the room's `module`."""
    used = set()
    for path in Path(room.__file__).parents[1].rglob('*.py'):
        text = path.read_text(encoding='utf-8')
        if path.stem == module or re.search(rf'{module} import [\w\s,(]*\bLIMITS\b', text):
            used |= {node.attr for node in nodes(path)
                     if isinstance(node, ast.Attribute) and ast.unparse(node.value) == 'LIMITS'}
    assert used == {field.name for field in fields(limits)}


def loose_numbers(room, numerical):
    """
    Return 'module.NAME' of each constant of a `room` that holds a fraction of its own.

    numerical: {module: names} of settings that decide nothing; one that is gone counts as loose.
    """
    found = {}
    for path in Path(room.__file__).parent.rglob('*.py'):
        for node in tree(path).body:
            value = getattr(node, 'value', None)
            if not isinstance(node, (ast.Assign, ast.AnnAssign)) or value is None or isinstance(
                    value, ast.Call) or not any(
                    isinstance(part, ast.Constant) and isinstance(part.value, float)
                    for part in ast.walk(value)):
                continue
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = {part.id for target in targets for part in ast.walk(target)
                     if isinstance(part, ast.Name) and re.fullmatch('_?[A-Z][A-Z0-9_]*', part.id)}
            found.setdefault(path.stem, set()).update(names)
    allowed = {f'{module}.{name}' for module, names in numerical.items() for name in names}
    loose = {f'{module}.{name}' for module, names in found.items() for name in names}
    return sorted(loose ^ allowed)
