# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What texts call the units of a drive: the one place that tells rotary from prismatic axes."""
import math
import re
from typing import NamedTuple

PRISMATIC = {'kg m^2': 'kg', 'N m': 'N', 'rad': 'm', 'angle': 'position', 'torque': 'force'}
# Whole words, perhaps in mN m or torques; parts of ids, as in torque_offset, and options stay.
_WORDS = re.compile(r'(?<![\w-])([mk]?)(kg m\^2|N m|rad|angle|torque)(s?)(?!\w)')


def on_axis(label: str, axis: str) -> str:
    """
    Return a label with its units as for an axis of DriveModel.axis.

    label: as for a rotary axis, without names that a user has given; axis: 'rotary' leaves it,
    'prismatic' has m, N and kg.
    """
    if axis != 'prismatic':
        return label
    return _WORDS.sub(lambda match: match[1] + PRISMATIC[match[2]] + match[3], label)


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
