# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Announce that numba compiles kernels, and how long that takes.

numba broadcasts an event when it compiles a function, and none when it loads one from its cache:
the announcement comes only where there is something to wait for.
"""
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from gearbox_monitor.kernels.jit import CACHE_FOLDER, COMPILED

FIRST_START = ('compiling numerical kernels for the first start: takes about 30 s on a free core; '
               'later starts reuse them')
EVERY_START = ('compiling numerical kernels: takes about 30 s on a free core; '
               'no folder can keep the result, so every start compiles')


class KernelMissing(BaseException):
    """The cache lacks a kernel. No Exception: who handles those of a kernel may not take it."""


@contextmanager
def only_from_cache() -> Iterator[None]:
    """Raise KernelMissing where the block would compile what a folder can keep, by numba."""
    from numba.core import event

    class CompilationRefused(event.Listener):

        def on_start(self, compilation: Any) -> None:
            if compilation.data['dispatcher'].stats.cache_path is not None:
                raise KernelMissing

        def on_end(self, compilation: Any) -> None:
            pass

    with event.install_listener('numba:compile', CompilationRefused()):
        yield


@contextmanager
def announced_compilation(announce: Callable[[str], object]) -> Iterator[None]:
    """
    Call `announce` with a line of text when the block compiles its first kernel, and at its end.

    The last line tells for how long kernels were compiled. A block whose kernels all come from the
    cache announces nothing; nor do functions that are compiled in every process by design.
    """
    if not COMPILED:
        yield
        return
    from numba.core import event

    class CompilationListener(event.TimingListener):
        announced = False

        def on_start(self, compilation: Any) -> None:
            super().on_start(compilation)
            cached = compilation.data['dispatcher'].stats.cache_path is not None
            if not self.announced and (cached or CACHE_FOLDER is None):
                self.announced = True
                announce(FIRST_START if CACHE_FOLDER else EVERY_START)

    listener = CompilationListener()
    with event.install_listener('numba:compile', listener):
        yield
    if listener.announced:
        announce(f'compiled in {listener.duration:.1f} s')
