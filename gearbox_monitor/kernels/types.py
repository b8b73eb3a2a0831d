# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The types of annotations that mypy checks. Shapes and units stand in docstrings."""
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.floating[Any]]  # float64 where nothing else is said
AnyArray: TypeAlias = npt.NDArray[Any]
Integers: TypeAlias = npt.NDArray[np.int64]  # stamps are in ns
Flags: TypeAlias = npt.NDArray[np.bool_]
# Plain data by name: parameters, an effect of a model file, figures beside a finding.
Values: TypeAlias = Mapping[str, Any]
# What kernels take as `states`, see estimation.process_model.markers.
States: TypeAlias = tuple[Any, ...]
# What kernels hand on in one piece: of a 2-vector, a symmetric 2 x 2 matrix, four stages.
Pair: TypeAlias = tuple[float, float]
Triple: TypeAlias = tuple[float, float, float]
Four: TypeAlias = tuple[float, float, float, float]
# Of the elastic torque of a transmission: its parameters, and its slopes; see plant.transmission.
Curve: TypeAlias = tuple[float, float, float, float]
Slopes: TypeAlias = tuple[float, float, float, float, float]
# Packed parameters as kernels take them, by their place; a lane makes a tuple of its own.
Packed: TypeAlias = Array | tuple[float, ...]
