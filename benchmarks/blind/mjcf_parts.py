# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Parts of MJCF files that drives of two masses and real joints share."""
from dataclasses import dataclass
import math

REACH = 0.2  # m from the joint to what hangs or collides at the end of its link


@dataclass(frozen=True)
class Outside:
    """What an effect outside of the library adds: to the link, to its joint, to the world."""

    body: str = ''
    joint: str = ''
    world: str = ''


def outside_of(name: str, size: float, damping: float, inertia: float) -> Outside:
    """
    Return the parts of the effect `name`, without one for an unknown one.

    Args:
        name: payload (a pendulum at the link's end), hard_stop or contact.
        size: mass, kg, or the angle of the stop or of the wall, rad.
        damping: of the pendulum, N m s/rad.
        inertia: of the pendulum about its centre, kg m^2.
    """
    if name == 'payload':
        return Outside(body=(
            f'<body pos="0 0 {-REACH}"><joint axis="0 1 0" damping="{damping:.9g}"/><inertial '
            f'pos="0 0 -0.1" mass="{size:.9g}" '
            f'diaginertia="{inertia:.9g} {inertia:.9g} {inertia:.9g}"/></body>'))
    if name == 'hard_stop':
        return Outside(joint=f' limited="true" range="-1000 {size:.9g}"')
    if name == 'contact':
        x, z = -REACH * math.sin(size), -REACH * math.cos(size)
        return Outside(body=f'<geom type="sphere" size="0.02" pos="0 0 {-REACH}" mass="0"/>',
                       world=f'<geom type="sphere" size="0.02" pos="{x:.9g} 0 {z:.9g}"/>')
    return Outside()


def actuator_attributes(lag: float, delay: float, limit: float, timestep: float) -> str:
    """
    Return the attributes of an actuator that is late or limited.

    Args:
        lag: of its force, s.
        delay: of its control, s.
        limit: of its force before the gear, N m; inf for none.
        timestep: of MuJoCo, s.
    """
    parts = []
    if lag:
        parts.append(f'dyntype="filterexact" dynprm="{lag:.9g}"')
    if delay:
        steps = math.ceil(delay / timestep) + 1
        parts.append(f'delay="{delay:.9g}" nsample="{steps}" interp="linear"')
    if math.isfinite(limit):
        parts.append(f'forcelimited="true" forcerange="{-limit:.9g} {limit:.9g}"')
    return ' '.join(parts)
