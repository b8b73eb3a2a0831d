# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Arrays as a caller passes them: checked and made float64, or refused in words."""
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array


def column(value: Any, name: str, what: str, length: int | None = None) -> Array:
    """
    Return `value` as a float64 array [N].

    Args:
        value: array, list or column of a table.
        name: what messages call it.
        what: quantity and unit that was expected.
        length: expected N, None for any.

    Raises:
        InputError: not numbers, not of one dimension, or of another length.
    """
    array = _floats(value, name, what)
    if array.ndim != 1:
        raise InputError(f'{name}: {_shape(array)}, expected one dimension: {what}')
    if length is not None and len(array) != length:
        raise InputError(f'{name}: {len(array)} values, expected {length} as of t')
    return array


def table(value: Any, name: str, what: str, length: int, columns: int = 2) -> Array:
    """
    Return `value` as a float64 array [length, columns].

    Args:
        value: array or nested list.
        name: what messages call it.
        what: quantities and units of the columns.
        length: number of rows.
        columns: number of columns.

    Raises:
        InputError: not numbers, or of another shape.
    """
    array = _floats(value, name, what)
    if array.shape != (length, columns):
        raise InputError(f'{name}: {_shape(array)}, expected shape ({length}, {columns}): {what}')
    return array


def _floats(value: Any, name: str, what: str) -> Array:
    """Return `value` as a float64 array of any shape."""
    try:
        if isinstance(value, np.ma.MaskedArray):  # asarray would forget what is masked
            value = np.ma.filled(value.astype(float), np.nan)
        array = np.asarray(value)
        if array.dtype.kind in 'fiub' or array.dtype.kind == 'O' and not isinstance(value, str):
            return array.astype(float)
    except (TypeError, ValueError, OverflowError):
        pass
    raise InputError(f'{name}: {_shown(value)}, expected numbers: {what}')


def _shape(array: Array) -> str:
    return f'shape {array.shape}' if array.ndim else f'one number ({array:g})'


def _shown(value: Any) -> str:
    """Return `value` in a few words: its type, and the first element of a sequence."""
    words = type(value).__name__
    if isinstance(value, str) or not hasattr(value, '__len__'):
        return f'{words} {str(value)[:40]!r}'
    first = next(iter(np.ravel(np.asarray(value, object))), None)
    return f'{words} with {str(first)[:40]!r}'
