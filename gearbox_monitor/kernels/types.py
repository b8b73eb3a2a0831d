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
