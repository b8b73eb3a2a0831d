# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What texts call the units of a drive: the one place that tells rotary from prismatic axes."""
import re

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
