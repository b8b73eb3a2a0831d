# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compilation at a node's first start, in a process of its own.

A compiler leaves some 200 MB behind, which the node would hold until its end.
"""
from collections.abc import Callable
import pickle
import subprocess
import sys
import time
from typing import Any

from gearbox_monitor.kernels.compilation import (
    announced_compilation, FIRST_START, KernelMissing, only_from_cache)
from gearbox_monitor.kernels.jit import CACHE_FOLDER

_CHILD = """import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
function, arguments = pickle.load(sys.stdin.buffer)
sys.exit(function(*arguments))
"""


def in_child(function: Callable[..., object], *arguments: Any,
             folder: str | None = None) -> 'subprocess.CompletedProcess[bytes]':
    """
    Call `function` with `arguments` in a process of its own, and wait for its end.

    Args:
        function: belongs to a module.
        arguments: of the function, as pickle can write them.
        folder: that it works in.

    Returns:
        What became of the process, with what it wrote on stderr.

    """
    return subprocess.run(
        [sys.executable, '-c', _CHILD], cwd=folder,
        input=pickle.dumps(sys.path) + pickle.dumps((function, arguments)),
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def compile_first(announce: Callable[[str], object], function: Callable[..., object],
                  *arguments: Any) -> None:
    """
    Call `function`; where it needs kernels that the cache lacks, a child calls it before.

    Where no folder can keep kernels, or the child fails, this process compiles them.

    Args:
        announce: takes a line of text when a compilation begins, and when it has ended.
        function: calls kernels; see in_child, and can be called twice.
        arguments: see in_child.
    """
    if CACHE_FOLDER is not None:
        try:
            with only_from_cache():
                function(*arguments)
            return
        except KernelMissing:
            begin = time.monotonic()
            announce(FIRST_START)
            if in_child(function, *arguments).returncode == 0:
                announce(f'compiled in {time.monotonic() - begin:.1f} s')
    with announced_compilation(announce):
        function(*arguments)
