# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

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
