# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

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
