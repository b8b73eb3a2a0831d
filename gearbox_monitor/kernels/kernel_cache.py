# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compiled kernels on disk, each under a name made of all that its machine code depends on.

numba's own cache looks at the time of a kernel's file: it compiles again what an upgrade did not
change, and goes on with what a change in another file has made wrong. This one looks at the code
of a kernel, at that of the kernels it calls, and at the constants they read.
"""
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
import hashlib
import os
from pathlib import Path
import pickle
import sys
import tempfile
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numba
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
import numpy as np

# Their functions change with their versions only, and numba replaces most of them by its own.
FOREIGN = ('math', 'numba', 'numpy', 'builtins')
# Compiled with another of these, a kernel is another; the last two are how the package compiles.
SETUP = (numba.__version__, sys.implementation.cache_tag, *(
    hashlib.sha256(Path(__file__).with_name(name).read_bytes()).hexdigest()
    for name in ('jit.py', 'pipeline.py')))
_open: list[FunctionType] = []  # whose content is being read


@cache
def content(function: FunctionType) -> str:
    """Return a digest of a function: its code, and what it reaches of functions and constants."""
    if function in _open:  # it calls itself
        return function.__qualname__
    _open.append(function)
    try:
        code = function.__code__
        values = [cell.cell_contents for cell in function.__closure__ or ()]
        values += [function.__defaults__, *(function.__kwdefaults__ or {}).items()]
        parts = [_value(value, _names(code)) for value in values]
        parts += _code(code, function.__globals__, function.__doc__)
    finally:
        _open.pop()
    return hashlib.sha256('\n'.join(parts).encode()).hexdigest()


def _code(code: CodeType, names: dict[str, Any], doc: str | None) -> Iterator[str]:
    """Yield what `code` is made of, with the global `names` that it reads, without its `doc`."""
    yield f'{code.co_code.hex()} {code.co_exceptiontable.hex()} {code.co_names}'
    yield (f'{code.co_varnames} {code.co_argcount} {code.co_posonlyargcount} '
           f'{code.co_kwonlyargcount} {code.co_flags}')
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant, names, None)
        else:
            yield '' if constant == doc else _value(constant, ())
    for name in code.co_names:
        if name in names:
            yield f'{name} {_value(names[name], code.co_names)}'


def _names(code: CodeType) -> tuple[str, ...]:
    """Return the names of attributes and globals in `code`, and in functions inside it."""
    parts = [_names(c) for c in code.co_consts if isinstance(c, CodeType)]
    return sum(parts, code.co_names)


def _value(value: Any, attributes: tuple[str, ...]) -> str:
    """Return what stands for `value`, of a module what stands for its `attributes`."""
    function = getattr(value, '__wrapped__', value)  # of a kernel, or of an instruction
    if isinstance(function, FunctionType) and not _foreign(function.__module__):
        return f'{content(function)} {_options(value)}'
    if isinstance(function, (FunctionType, BuiltinFunctionType)):
        return f'{function.__module__}.{function.__qualname__}'
    if isinstance(value, ModuleType):
        own = () if _foreign(value.__name__) else sorted(set(attributes) & set(vars(value)))
        return value.__name__ + ''.join(
            f' {name} {_value(getattr(value, name), attributes)}' for name in own)
    if isinstance(value, type):
        parts = [getattr(value, name, '') for name in ('__members__', '_fields')]
        defaults = [*getattr(value, '_field_defaults', {}).items()]
        return f'{value.__module__}.{value.__qualname__} {parts} {_value(defaults, attributes)}'
    if isinstance(value, (tuple, list)):
        return (f'{type(value).__qualname__} {getattr(value, "_fields", "")}'
                f'({", ".join(_value(v, attributes) for v in value)})')
    if isinstance(value, np.ndarray):
        return f'{value.dtype} {value.shape} {value.tobytes().hex()}'
    # An object whose text is its address is another in each process: it is compiled again.
    return f'{type(value).__qualname__} {value!r}'


def _foreign(module: str) -> bool:
    return module.partition('.')[0] in FOREIGN


def _options(value: Any) -> list[tuple[str, Any]]:
    """Return the options that a kernel was made with."""
    return sorted(getattr(value, 'targetoptions', {}).items())


def _kind(kind: Any) -> str:
    """Return what stands for the type `kind` of an argument: of a named tuple its class, too."""
    parts, made_of = getattr(kind, 'types', None), getattr(kind, 'instance_class', None)
    return f'{made_of and _value(made_of, ())} ' + (
        str(kind) if parts is None else f'({", ".join(map(_kind, parts))})')


class KernelCache(_Cache):
    """
    What numba asks for kernels, and gives them to; all kernels share one folder.

    kernel: as numba made it; name: of its files.
    """

    def __init__(self, kernel: Any, name: str, folder: str) -> None:
        self._kernel, self._name, self._folder = kernel, name, folder

    @property
    def cache_path(self) -> str:
        """The folder."""
        return self._folder

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel compiled for arguments of the types `sig`, None if it is not there."""
        target_context.refresh()
        try:
            data = self._path(sig, target_context.codegen()).read_bytes()
            # From a folder that nobody else can write into: see usable_cache.
            return CompileResult._rebuild(target_context, *pickle.loads(data))  # noqa: S301
        except (OSError, EOFError, pickle.UnpicklingError, ImportError, AttributeError,
                IndexError):  # damaged
            return None

    def save_overload(self, sig: Any, compiled: Any) -> None:
        """Keep a kernel `compiled` for arguments of the types `sig`."""
        if compiled.library.has_dynamic_globals:  # addresses in this process
            return
        data = dumps(compiled._reduce())
        path = self._path(sig, compiled.codegen)
        with suppress(OSError), _written_whole(path) as file:
            file.write(data)

    def _path(self, sig: Any, codegen: Any) -> Path:
        parts = (*SETUP, *codegen.magic_tuple(), content(self._kernel.py_func),
                 _options(self._kernel), *map(_kind, sig))
        digest = hashlib.sha256('\n'.join(map(str, parts)).encode()).hexdigest()
        return Path(self._folder, f'{self._name}-{digest[:24]}.nbc')

    def enable(self) -> None:
        """Do nothing: it is always in use."""

    disable = flush = enable


@contextmanager
def _written_whole(path: Path) -> Iterator[Any]:
    """Open a file that stands at `path` once it is complete."""
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        try:
            yield file
            file.close()
            os.replace(file.name, path)
        except BaseException:
            os.unlink(file.name)
            raise
