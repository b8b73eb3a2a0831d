# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The types of annotations that mypy checks. Units stand in docstrings.

What Python hands to compiled kernels is annotated with its number of dimensions: Vector, Matrix,
Cube and the like; what only kernels hand to each other may be any Array.
"""
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from gearbox_monitor.errors import InputError

Array: TypeAlias = npt.NDArray[np.floating[Any]]  # float64 where nothing else is said
AnyArray: TypeAlias = npt.NDArray[Any]
Natural: TypeAlias = Annotated[int, 'natural']  # not negative: an index from the front
# Of an annotation: the element, as numpy names it, and the number of dimensions.
Vector: TypeAlias = Annotated[Array, 'f8', 1]
Matrix: TypeAlias = Annotated[Array, 'f8', 2]
Cube: TypeAlias = Annotated[Array, 'f8', 3]
Block: TypeAlias = Annotated[Array, 'f8', 4]
Integers: TypeAlias = Annotated[npt.NDArray[np.int64], 'i8', 1]  # stamps are in ns
IntegerMatrix: TypeAlias = Annotated[npt.NDArray[np.int64], 'i8', 2]
Flags: TypeAlias = Annotated[npt.NDArray[np.bool_], 'b1', 1]
FlagMatrix: TypeAlias = Annotated[npt.NDArray[np.bool_], 'b1', 2]
Bytes: TypeAlias = Annotated[npt.NDArray[np.uint8], 'u1', 1]
Words: TypeAlias = Annotated[npt.NDArray[np.uint64], 'u8', 1]
WordMatrix: TypeAlias = Annotated[npt.NDArray[np.uint64], 'u8', 2]
Numbers: TypeAlias = Annotated[npt.NDArray[np.int32], 'i4', 1]
# Plain data by name: parameters, an effect of a model file, figures beside a finding.
Values: TypeAlias = Mapping[str, Any]
# What kernels hand on in one piece: of a 2-vector, a symmetric 2 x 2 matrix, four stages.
Pair: TypeAlias = tuple[float, float]
Triple: TypeAlias = tuple[float, float, float]
Four: TypeAlias = tuple[float, float, float, float]
# Of the elastic torque of a transmission: its parameters, and its slopes; see plant.transmission.
Curve: TypeAlias = tuple[float, float, float, float]
Slopes: TypeAlias = tuple[float, float, float, float, float]
# Packed parameters as kernels take them, by their place; a lane makes a tuple of its own.
Packed: TypeAlias = Array | tuple[float, ...]


class Layout(NamedTuple):
    """
    What the states of a filter are.

    n: number of states. loaded: whether the model has a load on the arm of its own. curve: number
    of states that a curve of tau_K adds, -1 without a curve. law: whether friction is another than
    the arctangent. The usual ones are folded into kernels, which then leave out what they lack.
    """

    n: Natural
    loaded: bool
    curve: int
    law: bool


def unrolled(n: int) -> range:
    """Return range(n); C writes the turns of such a loop out where `n` is a small constant."""
    return range(n)


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
