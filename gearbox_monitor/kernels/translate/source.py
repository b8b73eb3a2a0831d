# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The syntax trees of kernels, found by their function objects."""
import ast
from functools import cache
import linecache
from types import FunctionType
from typing import Any

from gearbox_monitor.kernels.translate.values import Refused


@cache
def _definitions(file: str) -> dict[int, Any]:
    """Return {first line: definition of a function} of a file."""
    found: dict[int, Any] = {}
    for node in ast.walk(ast.parse(''.join(linecache.getlines(file)))):
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            lines = [node.lineno, *(d.lineno for d in getattr(node, 'decorator_list', []))]
            found.setdefault(min(lines), node)
    return found


def definition(function: FunctionType) -> Any:
    """Return the syntax tree of a function. Raises Refused."""
    code = function.__code__
    try:
        return _definitions(code.co_filename)[code.co_firstlineno]
    except (KeyError, OSError, SyntaxError):
        raise Refused(f'{code.co_filename}:{code.co_firstlineno}: no source of '
                      f'{function.__qualname__}') from None
