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
from collections.abc import Callable, Iterator, Sequence
import ctypes
from functools import cache, cached_property, partial, update_wrapper
import inspect
import os
import platform
import struct
from types import FunctionType
from typing import Any, get_args, get_origin, get_type_hints, TypeVar

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels import library
from gearbox_monitor.kernels.translate.values import (
    Array, BOOL, FLOAT, form, INT, Known, NATURAL, Record, Refused, Type)
from gearbox_monitor.kernels.types import Triple, Vector

Function = TypeVar('Function', bound=Callable[..., Any])
INTERPRETED = os.environ.get('GEARBOX_MONITOR_KERNELS', '') == 'python'
# What decides the last bits of a result.
KERNELS = f'{"interpreted" if INTERPRETED else "C"} on {platform.machine()}'
RESULT = 64  # bytes ahead of the arguments
NOTHING = ctypes.c_char * 0
SCALARS: dict[Any, Type] = {float: FLOAT, int: INT, bool: BOOL, type(None): Known(None)}


# ---------------------------------------------------------------------- marks


def _marked(function: Any, **marks: Any) -> Any:
    vars(function).update(marks)
    return function


def kernel(function: Function) -> Function:
    """Mark `function` as a kernel that kernels call."""
    made: Function = _marked(function, placed='static')
    return made


def inline(function: Function) -> Function:
    """Mark `function` as a kernel that is put into its callers: a few lines, or a hot path."""
    made: Function = _marked(function, placed='inline')
    return made


def apart(function: Function) -> Function:
    """Mark `function` as a kernel that stays one function, for a large one that several call."""
    made: Function = _marked(function, placed='apart')
    return made


def folded(*usual: Any) -> Callable[[Function], Function]:
    """
    Return what marks a kernel whose first argument is often one of the `usual` NamedTuples.

    For each of these it is compiled with that as a constant, and once for all others.
    """
    return partial(_marked, usual=usual)


def instruction(c_name: str, results: int = 0) -> Callable[[Function], Function]:
    """
    Return what marks the Python of an instruction.

    Args:
        c_name: what C calls it.
        results: how many floats it writes to its first argument in C; 0: it returns one.
    """
    return partial(_marked, instruction=c_name, results=results)


def entry(function: Function) -> Function:
    """Return the kernel `function` as Python calls it; the library of the package has it."""
    made: Any = function
    if not INTERPRETED:
        made = Entry(function if hasattr(function, 'placed') else kernel(function))
        library.ENTRIES.append(made)
    return made


def bound(template: Any, name: str, **values: Any) -> Any:
    """
    Return a copy of a kernel with other `values` of its globals, an entry if the template is one.

    Args:
        template: kernel or entry.
        name: is added to the template's name.
        values: functions and numbers by the names that the kernel calls them.
    """
    python = getattr(template, '__wrapped__', template)
    code = python.__code__.replace(co_name=f'{python.__name__}_{name}')
    copy: Any = FunctionType(code, {**python.__globals__, **values}, code.co_name,
                             python.__defaults__, python.__closure__)
    copy.__annotations__, copy.__module__ = python.__annotations__, python.__module__
    return Entry(copy) if isinstance(template, Entry) else _marked(copy, **vars(python))


# ---------------------------------------------------------------------- arguments as slots


@cache
def declared(annotation: Any) -> Type:
    """Return the type that an annotation declares. Raises TypeError."""
    if annotation in SCALARS:
        return SCALARS[annotation]
    details = getattr(annotation, '__metadata__', ())
    if details:
        return NATURAL if details == ('natural',) else Array(*details)
    if hasattr(annotation, '_fields'):
        hints = get_type_hints(annotation, include_extras=True)
        return Record(tuple(map(declared, hints.values())), annotation)
    if get_origin(annotation) is not tuple or Ellipsis in get_args(annotation):
        raise TypeError(f'{annotation}, expected float, int, bool, Vector, Matrix or the like, or '
                        'a tuple or NamedTuple of these')
    return Record(tuple(map(declared, get_args(annotation))))


def _flatten(kinds: Sequence[Type], values: Sequence[Any], slots: list[Any],
             copies: list[Any]) -> None:
    """Append `values` to `slots`; to `copies` (copy, original) of what is not contiguous."""
    for kind, value in zip(kinds, values, strict=True):
        if isinstance(kind, Array):
            if type(value) is not np.ndarray or value.ndim != kind.ndim or (
                    value.dtype != kind.dtype):
                raise TypeError(f'{getattr(value, "dtype", type(value).__name__)} '
                                f'{getattr(value, "shape", "")}, expected {kind.element} of '
                                f'{kind.ndim} dimensions')
            if not value.flags.c_contiguous:
                copies.append((np.ascontiguousarray(value), value))
                value = copies[-1][0]
            # The interface of an array takes longer than most kernels.
            slots.append(ctypes.addressof(NOTHING.from_buffer(value)) if value.flags.writeable
                         else value.__array_interface__['data'][0])
            slots += value.shape
        elif isinstance(kind, Record):
            _flatten(kind.items, value, slots, copies)
        else:
            slots.append(value)


def _nested(kind: Type, numbers: Iterator[Any]) -> Any:
    """Return what is of this `kind`, of its `numbers` one after the other."""
    return tuple(_nested(item, numbers) for item in kind.items) if isinstance(
        kind, Record) else next(numbers)


class Entry:
    """A kernel as Python calls it."""

    def __init__(self, kernel: Any) -> None:
        update_wrapper(self, kernel)
        self.__wrapped__: Any = kernel
        self.__name__: str = kernel.__name__
        module = kernel.__module__.replace('gearbox_monitor.', '').replace('.', '_')
        self.symbol = f'gm_{module}_{kernel.__name__}'

    def __deepcopy__(self, memo: object) -> 'Entry':
        """Return itself, as a function does."""
        return self

    @cached_property
    def types(self) -> tuple[tuple[Type, ...], Type]:
        """The declared types of its arguments and of what it returns. Raises TypeError."""
        hints = get_type_hints(self.__wrapped__, include_extras=True)
        hints.setdefault('return', type(None))
        try:
            *arguments, result = map(declared, [*hints.values()])
        except TypeError as error:
            raise TypeError(f'{self.__module__}.{self.__name__}: {error}') from None
        return tuple(arguments), result

    @cached_property
    def function(self) -> Any:
        """The C function, of the package or built around a user's. Raises InputError, Refused."""
        made = getattr(library.installed(), self.symbol, None)
        if made is None:
            from gearbox_monitor.kernels import build
            made = getattr(ctypes.CDLL(str(build.compiled(
                build.text_of([self]), library.cache_folder()))), self.symbol)
        made.argtypes, made.restype = [ctypes.c_void_p], None
        return made

    @cached_property
    def _slots(self) -> struct.Struct:
        return struct.Struct(f'<{RESULT}x{form(self.types[0])}')

    @cached_property
    def _result(self) -> Callable[[Any], Any]:
        kind = self.types[1]
        read = struct.Struct('<' + form([kind])).unpack_from
        if isinstance(kind, Record):
            nested = any(isinstance(item, Record) for item in kind.items)
            return (lambda room: _nested(kind, iter(read(room)))) if nested else read
        return (lambda room: None) if isinstance(kind, Known) else lambda room: read(room)[0]

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Run the compiled kernel."""
        if named or len(arguments) != len(self.types[0]):
            given = inspect.signature(self.__wrapped__).bind(*arguments, **named)
            given.apply_defaults()
            arguments = given.args
        room, copies = self._room(arguments)
        self.function(room)
        for copy, original in copies:
            if original.flags.writeable:
                original[...] = copy
        return self._result(room)

    def _room(self, arguments: tuple[Any, ...]) -> tuple[Any, list[Any]]:
        """Return room for a call that holds its `arguments`, and the _flatten copies."""
        values: list[Any] = []
        copies: list[Any] = []
        try:
            _flatten(self.types[0], arguments, values, copies)
        except (TypeError, ValueError) as error:
            raise TypeError(f'{self.__name__}: {error}') from None
        room = ctypes.create_string_buffer(self._slots.size)
        self._slots.pack_into(room, 0, *values)
        return room, copies

    def prepared(self, *arguments: Any) -> Callable[..., Any]:
        """
        Return the call with these arguments: one foreign call, for a loop over samples.

        Arrays among them stay where they are.
        """
        room, copies = self._room(arguments)
        if copies:
            raise TypeError(f'{self.__name__}: an array that is not contiguous')
        place, function, result = ctypes.addressof(room), self.function, self._result

        def call(held: Any = (arguments, room)) -> Any:
            function(place)
            return result(room)
        return call


class Repeated:
    """
    A kernel that is called with the same objects again and again, as for each sample of a stream.

    Their calls are prepared once, and forgotten where many others come.
    """

    MOST = 4

    def __init__(self, kernel: Any) -> None:
        self.kernel = kernel
        self._calls: dict[tuple[int, ...], Callable[[], Any]] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel."""
        key = tuple(map(id, arguments))  # the prepared call keeps them alive
        call = self._calls.get(key)
        if call is None:
            if len(self._calls) >= self.MOST:
                self._calls.clear()
            call = self._calls[key] = self.kernel.prepared(*arguments) if isinstance(
                self.kernel, Entry) else partial(self.kernel, *arguments)
        return call()

    def __deepcopy__(self, memo: object) -> 'Repeated':
        """Return one without prepared calls, which hold pointers into these arguments."""
        return Repeated(self.kernel)


# ---------------------------------------------------------------------- functions of a user

# C calls them back where they cannot be translated, or nothing can compile them. A call costs
# half a microsecond, and what Python takes for the function.
Torques = Callable[..., Triple]
_Callback = ctypes.CFUNCTYPE(None, ctypes.POINTER(ctypes.c_double), ctypes.c_void_p,
                             ctypes.c_int64, ctypes.POINTER(ctypes.c_double))
N_ARGUMENTS = 7  # t, x1, x2, x3, x4, u, tau_k
_called: dict[int, tuple[Torques, Any]] = {}  # both live as long as the process


@cache
def address_of(torques: Torques) -> int:
    """Return the address at which C calls `torques` of an Effect; NaN if it raises."""
    def call(numbers: Any, theta: Any, n: int, out: Any) -> None:
        try:
            values = (ctypes.c_double * n).from_address(theta) if n else ()
            out[0], out[1], out[2] = torques(*numbers[:N_ARGUMENTS], np.array(values))
        except Exception:  # C has no way to tell
            out[0] = out[1] = out[2] = float('nan')
    callback = _Callback(call)
    address = ctypes.cast(callback, ctypes.c_void_p).value or 0
    _called[address] = torques, callback
    return address


@instruction('gm_called', results=3)
def called_back(address: int, numbers: tuple[float, ...], theta: Vector) -> Triple:
    """Return the torques of the user's function at `address` for its arguments, theta the last."""
    return _called[address][0](*numbers, theta)


def compilable(function: Any, *annotations: Any) -> bool:
    """Return whether a user's `function` of arguments with `annotations` can be compiled here."""
    from gearbox_monitor.kernels import build
    from gearbox_monitor.kernels.translate.program import Program
    try:
        build.compiler()
        Program().instance(function, tuple(map(declared, annotations)))
    except (InputError, Refused):
        return False
    return True
