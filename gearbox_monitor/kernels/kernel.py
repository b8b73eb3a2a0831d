# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Mark kernels, and call compiled ones from Python.

A kernel is annotated Python of the constructs that translate/ knows. Those that Python calls are
entries: their annotations declare their arguments, they are compiled when the package is
installed, and a call of one is one foreign call, with the GIL released. All others are plain
functions: kernels call them in C, Python interprets them, and both give the same bits.
GEARBOX_MONITOR_KERNELS=python interprets entries, too.
"""
from collections.abc import Callable, Sequence
import ctypes
from functools import partial, update_wrapper
import os
import platform
import struct
from types import FunctionType
from typing import Any, TypeAlias, TypeVar

from gearbox_monitor.kernels import library
from gearbox_monitor.kernels.declared import (
    argument_types, Declared, flatten, layout_of, result_format, unpacker)

# C function, format of the slots, reader of the result, types of the arguments.
Plan: TypeAlias = tuple[Any, struct.Struct, Callable[[Any], Any], tuple[Declared, ...]]
Function = TypeVar('Function', bound=Callable[..., Any])
INTERPRETED = os.environ.get('GEARBOX_MONITOR_KERNELS', '') == 'python'
# What decides the last bits of a result.
KERNELS = f'{"interpreted" if INTERPRETED else "C"} on {platform.machine()}'
RESULT = 64  # bytes ahead of the arguments


def _placed(function: Any, place: str) -> Any:
    function.placed = place
    return function


def kernel(function: Function) -> Function:
    """Mark `function` as a kernel that kernels call."""
    made: Function = _placed(function, 'static')
    return made


def inline(function: Function) -> Function:
    """Mark `function` as a kernel that is put into its callers: a few lines, or a hot path."""
    made: Function = _placed(function, 'inline')
    return made


def apart(function: Function) -> Function:
    """Mark `function` as a kernel that stays one function, for a large one that several call."""
    made: Function = _placed(function, 'apart')
    return made


def instruction(c_name: str, results: int = 0) -> Callable[[Function], Function]:
    """
    Return what marks the Python of an instruction.

    Args:
        c_name: what C calls it.
        results: how many floats it writes to its first argument in C; 0: it returns one.
    """
    def marked(function: Any) -> Any:
        function.instruction, function.results = c_name, results
        return function
    return marked


def entry(function: Function) -> Function:
    """Return the kernel `function` as Python calls it."""
    made: Any = function if INTERPRETED else Entry(
        function if hasattr(function, 'placed') else kernel(function))
    return made


def folding(*usual: Any) -> Callable[[Function], Function]:
    """
    Return what makes entries whose first argument is often one of the `usual` NamedTuples.

    For each of these the kernel is compiled with it as a constant, and once for all others.
    """
    def made(function: Any) -> Any:
        return function if INTERPRETED else Entry(kernel(function), usual)
    return made


def bound(template: Any, name: str, installed: bool = True, **values: Any) -> Any:
    """
    Return a copy of a kernel with other `values` of its globals, an entry if the template is one.

    Args:
        template: kernel or entry.
        name: is added to the template's name.
        installed: whether the library of the package has the copy.
        values: functions and numbers by the names that the kernel calls them.
    """
    python = getattr(template, '__wrapped__', template)
    code = python.__code__.replace(co_name=f'{python.__name__}_{name}')
    copy: Any = FunctionType(code, {**python.__globals__, **values}, code.co_name,
                             python.__defaults__, python.__closure__)
    copy.__annotations__, copy.__doc__ = python.__annotations__, python.__doc__
    copy.__module__, copy.placed = python.__module__, getattr(python, 'placed', 'inline')
    return Entry(copy, template.usual, installed) if isinstance(template, Entry) else copy


class Entry:
    """
    A kernel as Python calls it.

    usual: what is folded into it, see folding; installed: whether the package's library has it,
    which one around a user's function is not in.
    """

    def __init__(self, function: Any, usual: Sequence[Any] = (), installed: bool = True) -> None:
        update_wrapper(self, function)
        self.__wrapped__: Any = function
        self.__name__: str = function.__name__
        self.usual, self.installed = tuple(usual), installed
        code = function.__code__
        self._count = code.co_argcount
        self._defaults: dict[str, Any] = dict(zip(
            code.co_varnames[:self._count][::-1], (function.__defaults__ or ())[::-1]))
        self._plans: dict[int, Plan] = {}
        if installed:
            library.ENTRIES.append(self)

    def __deepcopy__(self, memo: object) -> 'Entry':
        """Return itself, as a function does."""
        return self

    @property
    def symbol(self) -> str:
        """What the library calls it."""
        module = self.__wrapped__.__module__.replace('gearbox_monitor.', '').replace('.', '_')
        return f'gm_{module}_{self.__wrapped__.__name__}'

    def variants(self) -> list[tuple[str, tuple[Any, ...]]]:
        """Return (symbol, types of the arguments) of the general form and of each folded one."""
        types = argument_types(self.__wrapped__)
        return [(self.symbol, types), *(
            (f'{self.symbol}_{k}', (layout_of(usual), *types[1:]))
            for k, usual in enumerate(self.usual))]

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Run the compiled kernel."""
        if named or len(arguments) < self._count:
            arguments = self._completed(arguments, named)
        function, form, result, types = self._plan(arguments)
        values: list[Any] = []
        keep = flatten(types, arguments, values, self)
        room = bytearray(form.size)
        form.pack_into(room, 0, *values)
        function((ctypes.c_char * form.size).from_buffer(room))
        for copy, original in keep:
            original[...] = copy
        return result(room)

    def prepared(self, *arguments: Any) -> Callable[..., Any]:
        """
        Return the call with these arguments: one foreign call, for a loop over samples.

        Arrays among them stay where they are. What is missing at the end are numbers, which the
        call takes.
        """
        function, form, result, types = self._plan(arguments, len(arguments))
        given, missing = types[:len(arguments)], types[len(arguments):]
        values: list[Any] = []
        if flatten(given, arguments, values, self):
            raise TypeError(f'{self.__name__}: an array that is not contiguous')
        room = bytearray(form.size)
        fixed = struct.Struct(f'<{RESULT}x' + ''.join(t.form for t in given))
        fixed.pack_into(room, 0, *values)
        buffer = (ctypes.c_char * form.size).from_buffer(room)
        place, rest = ctypes.addressof(buffer), struct.Struct('<' + ''.join(
            t.form for t in missing))

        def call(held: Any = (arguments, buffer)) -> Any:
            function(place)
            return result(room)

        def call_with(*numbers: Any, held: Any = (arguments, buffer)) -> Any:
            rest.pack_into(room, fixed.size, *numbers)
            function(place)
            return result(room)
        return call_with if missing else call

    def _completed(self, arguments: tuple[Any, ...], named: dict[str, Any]) -> tuple[Any, ...]:
        names = self.__wrapped__.__code__.co_varnames[len(arguments):self._count]
        given = self._defaults | named
        if not set(named) <= set(names) or not set(names) <= set(given):
            raise TypeError(f'{self.__name__}: other arguments than it takes')
        return (*arguments, *(given[name] for name in names))

    def _plan(self, arguments: tuple[Any, ...],
              count: int | None = None) -> Plan:
        """Return C function, format of the slots, format of the result, types of arguments."""
        expected = self._count if count is None else count
        if len(arguments) != expected:
            raise TypeError(f'{self.__name__}: {len(arguments)} arguments, expected {expected}')
        k = self.usual.index(arguments[0]) + 1 if self.usual and arguments[0] in self.usual else 0
        plan = self._plans.get(k)
        if plan is None:
            symbol, types = self.variants()[k]
            plan = self.use(self._found(symbol, types), types, k)
        return plan

    def _found(self, symbol: str, types: tuple[Declared, ...]) -> Any:
        """Return the C function of a variant; it is built where the library has none."""
        if self.installed:
            try:
                return getattr(library.installed(), symbol)
            except AttributeError:
                pass
        from gearbox_monitor.kernels import build
        path = build.one(self, symbol, types, library.cache_folder())
        return getattr(ctypes.CDLL(str(path)), symbol)

    def use(self, function: Any, types: tuple[Declared, ...],
            variant: int = 0) -> Plan:
        """
        Call a C function from now on; return how.

        Args:
            function: of ctypes.
            types: of its arguments.
            variant: its place in `variants`.
        """
        function.argtypes, function.restype = [ctypes.c_void_p], None
        form = struct.Struct(f'<{RESULT}x' + ''.join(t.form for t in types))
        plan = self._plans[variant] = (
            function, form, unpacker(result_format(self.__wrapped__)), types)
        return plan


class Repeated:
    """
    A kernel that is called with the same objects again and again, as for each sample of a stream.

    Their calls are prepared once, and forgotten where many others come.
    """

    MOST = 4

    def __init__(self, kernel: Any) -> None:
        self._prepare = partial(prepared, kernel)
        self._calls: dict[tuple[int, ...], Callable[[], Any]] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel."""
        key = tuple(map(id, arguments))  # the prepared call keeps them alive
        call = self._calls.get(key)
        if call is None:
            if len(self._calls) >= self.MOST:
                self._calls.clear()
            call = self._calls[key] = self._prepare(*arguments)
        return call()

    def __deepcopy__(self, memo: object) -> 'Repeated':
        """Return one without prepared calls, which hold pointers into these arguments."""
        return Repeated(self._prepare.args[0])


def prepared(kernel: Any, *arguments: Any) -> Callable[..., Any]:
    """Return Entry.prepared of a kernel, which may be interpreted, with its first `arguments`."""
    made: Callable[..., Any] = kernel.prepared(*arguments) if isinstance(
        kernel, Entry) else partial(kernel, *arguments)
    return made


def compilable(function: Any, *annotations: Any) -> bool:
    """Return whether a user's `function` of arguments with `annotations` can be compiled here."""
    from gearbox_monitor.kernels import build
    return build.translates(function, annotations)
