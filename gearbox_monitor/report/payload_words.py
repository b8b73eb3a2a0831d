# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot holds and who pushes it, in words."""
from collections.abc import Sequence
import math

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.report.summary import with_deviation

CERTAIN = 3.0  # deviations from which a mass counts as held
PUSHED = 5.0   # from which a torque counts as external: the errors of a model reach 3


def payload_words(mass: float, mass_std: float, centre: Array, link: str, since: float) -> str:
    """
    Return a payload in words.

    Args:
        mass: kg.
        mass_std: its standard deviation.
        centre: [3] m in the frame of the link, NaN if uncertain.
        link: that carries.
        since: s, NaN for no change so far.
    """
    size = f'{with_deviation(mass, mass_std)} kg'
    if abs(mass) <= CERTAIN * mass_std:
        words = f'Nothing held at {link} ({size})'
    else:
        words = f'{size} held at {link}'
        if np.isfinite(centre).all():
            words += f', centre {100.0 * float(np.linalg.norm(centre)):.2g} cm out'
    return words if math.isnan(since) else f'{words}, since {since:.1f} s'


def push_words(t: Array, external: Array, std: Array, joints: Sequence[str]) -> str:
    """
    Return the largest external torque in words.

    Args:
        t: [N] s.
        external: [N, J] N m.
        std: its standard deviations [N, J].
        joints: names of the J joints.
    """
    beyond = np.abs(external) / std
    k, j = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    if beyond[k, j] <= PUSHED:
        return f'no external torque beyond {PUSHED:g} standard deviations'
    return (f'largest external torque {with_deviation(external[k, j], std[k, j])} N m at '
            f'{joints[int(j)]}, {t[k]:.1f} s')
