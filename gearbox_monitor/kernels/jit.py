# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compile numerical kernels with numba, or run the same source interpreted.

numba is optional at run time (an apt-installed Jazzy on Ubuntu 24.04 has none). The environment
variable ``GEARBOX_MONITOR_JIT=0`` chooses the interpreted kernels where numba is installed, too.
``fastmath`` stays off: a monitor needs NaN checks, and replay needs the same bits as live, however
the compiler has put kernels together. What it would gain, `fma` brings: one operation, the same
wherever it stands. Kernels release the GIL, so that fits can run in threads.
"""
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import fcntl
from functools import cache
import hashlib
import os
import platform
import stat
import sys
import tempfile
from types import FunctionType
from typing import Any, TypeVar

try:
    if os.environ.get('GEARBOX_MONITOR_JIT', '1') == '0':
        raise ImportError('switched off by GEARBOX_MONITOR_JIT=0')
    import numba
    from numba.core.compiler_lock import global_compiler_lock
    from numba.extending import intrinsic
    COMPILED = True
except ImportError:
    COMPILED = False
if COMPILED:
    from gearbox_monitor.kernels.kernel_cache import KernelCache
    from gearbox_monitor.kernels.pipeline import ALLOCATING, KERNEL, PART, SHARED
# What decides the last bits of a result.
KERNELS = f'{f"numba {numba.__version__}" if COMPILED else "interpreted"} on {platform.machine()}'


def _own_folders() -> list[str]:
    """
    Return the folders that compiled kernels may go to, the best first.

    Files beside the sources would survive when pip removes the package.
    """
    base = os.environ.get('XDG_CACHE_HOME') or os.path.join(os.path.expanduser('~'), '.cache')
    # Services often have no home; among temporary files a cache lasts until a reboot.
    temporary = os.environ.get('TMPDIR') or '/tmp'
    return [os.path.join(folder, 'kernels') for folder in (
        os.path.join(base, 'gearbox_monitor'),
        os.path.join(temporary, f'gearbox_monitor-{os.getuid()}'))]


def usable_cache(own: Sequence[str], chosen: str = '') -> tuple[str | None, str]:
    """
    Return (the first folder that a cache can be in, or None; else why there is none, one line).

    chosen: by the user, comes first. own: folders of ours, made for this user alone; what others
    put into one of them would be run, so that one they can write into is no good.
    """
    problems = []
    for folder in [chosen, *own] if chosen else own:
        try:
            if not os.path.isabs(folder):
                raise OSError('no absolute path')
            os.makedirs(folder, 0o700, exist_ok=True)
            for path in [] if folder == chosen else [os.path.dirname(folder), folder]:
                status = os.lstat(path)
                if status.st_uid != os.getuid() or status.st_mode & stat.S_IWOTH:
                    raise OSError(f'{path} can be written by others')
            with tempfile.TemporaryFile(dir=folder):
                return folder, ''
        except OSError as error:
            problems.append(f'{folder}: {error.strerror or error}')
    return None, ('no folder can keep compiled kernels, each start compiles them again ('
                  + '; '.join(problems)
                  + '), expected XDG_CACHE_HOME or NUMBA_CACHE_DIR to name a writable one')


CACHE_FOLDER, CACHE_PROBLEM = None, ''
if COMPILED:
    CACHE_FOLDER, CACHE_PROBLEM = usable_cache(_own_folders(), numba.config.CACHE_DIR)


Kernel = TypeVar('Kernel', bound=Callable[..., Any])
# numba's own name for "without reference counts"; one that does not know it counts them.
LEAN: dict[str, Any] = {'_nrt': False}
if COMPILED:
    LEAN['pipeline_class'] = KERNEL


def jit(function: Kernel) -> Kernel:
    """
    Return `function` compiled (cached on disk where a folder is writable) or as it is.

    It may not make or return arrays: without counting references, which costs more than the
    arithmetic of a step, all that a kernel writes into must be handed to it. Kernels that call it
    compile it as a part of themselves; Python calls machine code of its own.
    """
    return _with_part(function, False, PART) if COMPILED else function


def jit_shared(function: Kernel) -> Kernel:
    """Return `function` as jit does, optimised once: for a large one that several kernels call."""
    return _with_part(function, False, SHARED) if COMPILED else function


def jit_inline(function: Kernel) -> Kernel:
    """Return `function` as jit does, put into its callers: for what is a few lines."""
    return _with_part(function, True, PART) if COMPILED else function


def _with_part(function: Kernel, inline: bool, compiler: type) -> Kernel:
    kernel: Any = _compiled(function, LEAN)
    part = _part(function, inline, compiler)
    kernel.get_call_template, kernel.get_overload = part.get_call_template, part.get_overload
    return kernel


def jit_allocating(function: Kernel) -> Kernel:
    """Return `function` as jit does; it may make and return arrays."""
    return _compiled(function, {'pipeline_class': ALLOCATING}) if COMPILED else function


def jit_anew(function: Kernel) -> Kernel:
    """
    Return `function` as jit does, compiled in each process.

    For what is made around a plug-in: files for each state of its functions would pile up.
    """
    if not COMPILED:
        return function
    return numba.njit(error_model='numpy', nogil=True, **LEAN)(function)


def jit_part(function: Kernel) -> Kernel:
    """
    Return `function` as jit_inline does, without a file of its own in the cache.

    For parts that kernels are composed of: closures, and functions of an effect's parameters. The
    kernel around them is cached as a whole. They can be called from kernels only.
    """
    return _part(function, True, PART) if COMPILED else function


def _part(function: Kernel, inline: bool, compiler: type) -> Any:
    """
    Return `function` for kernels to call.

    numba compiles a function once for each constant among its arguments. Where LLVM puts it into
    its callers, that gains nothing: one overload serves all constants.
    """
    part: Any = numba.njit(error_model='numpy', nogil=True, forceinline=inline,
                           no_cpython_wrapper=True, no_cfunc_wrapper=True,
                           **{**LEAN, 'pipeline_class': compiler})(function)
    template = part.get_call_template

    def _of_any_constant(args: Sequence[Any], kws: dict[str, Any]) -> Any:
        return template(tuple(map(_widened, args)), {k: _widened(v) for k, v in kws.items()})
    part.get_call_template = _of_any_constant
    return part


def bound(template: Kernel, name: str, **values: Any) -> Kernel:
    """
    Return the plain function `template` as jit does, with other `values` of its globals.

    name: added to the template's, names its machine code: the linker goes by it.
    """
    code = template.__code__.replace(co_name=f'{template.__name__}_{name}')
    function: Any = FunctionType(code, {**template.__globals__, **values})
    function.__qualname__ = code.co_name
    function.__doc__ = template.__doc__
    return jit(function)


def _widened(kind: Any) -> Any:
    """Return the type `kind` of an argument, that of a constant widened to its number."""
    constant = isinstance(kind, (numba.types.IntegerLiteral, numba.types.BooleanLiteral))
    return numba.types.unliteral(kind) if constant else kind


def _compiled(function: Kernel, options: dict[str, Any]) -> Kernel:
    kernel: Any = numba.njit(error_model='numpy', nogil=True, no_cfunc_wrapper=True,
                             **options)(function)
    if CACHE_FOLDER is None:
        return kernel
    name = f'{function.__module__}.{function.__qualname__}'
    kernel._cache = KernelCache(kernel, name, CACHE_FOLDER)
    load_or_compile = kernel.compile

    def _one_process_compiles(signature: Any) -> Any:
        # numba's lock comes first, so that the threads of a process take both in one order.
        with global_compiler_lock, _overload_lock(f'{name}{signature}'), interrupts_kept():
            return load_or_compile(signature)
    kernel.compile = _one_process_compiles
    return kernel


@contextmanager
def interrupts_kept() -> Iterator[None]:
    """
    Let Ctrl-C end the block even where Python drops it: in a callback that LLVM calls.

    LLVM takes most of the time of compiling, and what comes meanwhile is raised in its callback.
    """
    previous, dropped = sys.unraisablehook, []

    def keep(unraisable: Any) -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            dropped.append(unraisable.exc_type)
        else:
            previous(unraisable)
    sys.unraisablehook = keep
    try:
        yield
    finally:
        sys.unraisablehook = previous
        if dropped:
            raise KeyboardInterrupt


@contextmanager
def _overload_lock(overload: str) -> Iterator[None]:
    """
    Let other processes that want `overload` wait and load it: nodes of a robot start together.

    Each overload is one byte of a file that all processes lock. Kernels call each other without a
    circle, so that no two processes can wait for each other.
    """
    file = _lock_file()
    byte = int.from_bytes(hashlib.sha256(overload.encode()).digest()[:7], 'big')
    try:
        if file is not None:
            fcntl.lockf(file, fcntl.LOCK_EX, 1, byte)
    except OSError:  # a file system without locks: each process compiles for itself
        file = None
    try:
        yield
    finally:
        if file is not None:
            fcntl.lockf(file, fcntl.LOCK_UN, 1, byte)


@cache
def _lock_file() -> int | None:
    """Return the file whose bytes are locked, open as long as the process lives."""
    try:
        return os.open(os.path.join(CACHE_FOLDER or '', 'locks'), os.O_RDWR | os.O_CREAT, 0o600)
    except OSError:
        return None


if COMPILED:
    def _typed(context: Any, a: Any, b: Any, c: Any) -> Any:
        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.fma(*arguments)
        number = numba.float64
        return number(number, number, number), build

    _fused: Any = intrinsic(_typed)

    def _on_bits(shift: int, name: str) -> Any:
        """Return the intrinsic (a, t) -> bits of a, `name` (add, xor) those of t << `shift`."""
        def typed(context: Any, a: Any, t: Any) -> Any:
            def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                integer = context.get_value_type(numba.int64)
                of_a, of_t = (builder.bitcast(v, integer) for v in arguments)
                moved = builder.shl(of_t, integer(shift))
                return builder.bitcast(getattr(builder, name)(of_a, moved), arguments[0].type)
            number = numba.float64
            return number(number, number), build
        return intrinsic(typed)

    _powered: Any = _on_bits(52, 'add')
    _flipped: Any = _on_bits(63, 'xor')

    @jit_inline
    def fma(a: float, b: float, c: float) -> float:
        """Return a b + c of float64, rounded once: one instruction, half as many in a product."""
        return _fused(a, b, c)

    @jit_inline
    def times_power(a: float, t: float) -> float:
        """Return a 2^k, normal numbers both, where t is k + 1.5 2^52: its lowest bits hold k."""
        return _powered(a, t)

    @jit_inline
    def signed(a: float, t: float) -> float:
        """Return (-1)^k a, where t is k + 1.5 2^52."""
        return _flipped(a, t)
else:
    def fma(a: float, b: float, c: float) -> float:
        """Return a b + c; interpreted, it is rounded twice."""
        return a * b + c
