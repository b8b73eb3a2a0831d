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

"""Where a model of a drive is from."""
import math
from typing import NamedTuple

NO_LIMIT = (-math.inf, math.inf)


class FileLimits(NamedTuple):
    """What a simulator's file says of a recording: ranges (rad) of setpoints and positions."""

    notes: tuple[str, ...] = ()
    setpoints: tuple[float, float] = NO_LIMIT
    travel: tuple[float, float] = NO_LIMIT


NO_LIMITS = FileLimits()


class ModelOrigin(NamedTuple):
    """The file of a model, as messages call it, and the limits in that file."""

    name: str = 'the model'
    limits: FileLimits = NO_LIMITS
