# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Syntax of the sources, parsed once for all tests that read it; one process runs these."""
import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / 'gearbox_monitor'
MODULES = sorted(PACKAGE.rglob('*.py'))


@cache
def tree(path):
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text(encoding='utf-8'))


@cache
def nodes(path):
    """Return all nodes of a file's syntax tree."""
    return list(ast.walk(tree(path)))
