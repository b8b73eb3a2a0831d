# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Functions of a user that C calls back, where they cannot be translated or nothing can compile them.

A call costs half a microsecond and what Python takes for the function.
"""
from collections.abc import Callable
import ctypes
from functools import cache
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.kernel import declared, instruction
from gearbox_monitor.kernels.translate.values import Refused
from gearbox_monitor.kernels.types import Array, Triple

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
def called_back(address: int, numbers: tuple[float, ...], theta: Array) -> Triple:
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
