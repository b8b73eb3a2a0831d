# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find masses, centres, inertias and limits in a robot's file that no robot has, without any log.

Each body is compared with its neighbours and with the lengths of the robot. Bodies that are fixed
to each other count as one.
"""
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import body_of, Chain
from gearbox_monitor.robot.compiled_model import at_rest, mujoco_module, name_of
from gearbox_monitor.robot.description import expanded_root, MOVABLE


@dataclass(frozen=True)
class PlausibleLimits:
    """
    Bounds of plausible values: they find errors of units and points, not placeholders.

    light: mass over those of both neighbours; a link of 0.05 would break. speck: mass of a last
    link over that of its carrier, with less than `grain` kg. heavy: mass over its neighbours.
    far: distance of a centre from the axis, and radius of an inertia, over the longest link. A
    wrong unit of mass or inertia makes the radius 31 times as large, one of length 1000 times;
    placeholders in published arms reach 2. short: m; a link of less length may be the cross of
    two axes. absent: kg, no mass at all.
    """

    light: float = 0.05
    speck: float = 1e-3
    grain: float = 1e-3
    heavy: float = 300.0
    far: float = 4.0
    short: float = 0.02
    absent: float = 1e-9


LIMITS = PlausibleLimits()


@dataclass(frozen=True)
class _Body:
    """
    Bodies that move as one: name and mass kg, number of the carrier, numbers of those it carries.

    length: largest distance of its joints, m; off: of its centre from the axis, m, NaN without a
    hinge; radius: largest of gyration, m.
    """

    name: str
    mass: float
    carrier: int
    carried: Sequence[int]
    length: float
    off: float
    radius: float


def implausible(m: Any) -> list[str]:
    """Return a line for each value of a mujoco.MjModel `m` that cannot be true, with a remedy."""
    return _of_bodies(_bodies(m)) + _of_limits(m)


def implausible_links(chain: Chain) -> list[str]:
    """Return a line for each link of a `chain` that cannot be true, with a remedy."""
    carried = [[k for k, x in enumerate(chain.links) if x.parent == i]
               for i in range(len(chain.links))]
    bodies = {}
    for i, (link, own) in enumerate(zip(chain.links, carried)):
        off, radius = np.nan, 0.0
        if link.mass > LIMITS.absent:
            _, centre, inertia = body_of(link.theta)
            radius = float(np.sqrt(np.linalg.eigvalsh(inertia)[-1] / link.mass))
            if not link.slides:
                off = float(np.linalg.norm(np.cross(link.axis, centre)))
        length = max([0.0, *(float(np.linalg.norm(chain.links[k].origin)) for k in own)])
        bodies[i] = _Body(link.name, link.mass, link.parent, own, length, off, radius)
    return _of_bodies(bodies)


def implausible_limits(urdf: str | bytes, source: str) -> list[str]:
    """Return a line for each limit of 0 in a `urdf` called `source`; to MuJoCo it is no limit."""
    lines = []
    for joint in expanded_root(urdf, source).findall('joint'):
        if joint.get('type') not in MOVABLE:
            continue
        where = f'joint {joint.get("name", "")}'
        for limit in joint.findall('limit'):
            lines += [f'{where}: {key} limit 0: state what the drive gives'
                      for key in ('effort', 'velocity') if _is_zero(limit.get(key, ''))]
            if joint.get('type') != 'continuous' and all(
                    _is_zero(limit.get(key, '0')) for key in ('lower', 'upper')):
                lines.append(f'{where}: range 0 to 0: state the travel, or type="continuous"')
    return lines


def _is_zero(value: str) -> bool:
    """Return whether a `value` of an attribute is the number 0."""
    try:
        return float(value) == 0.0
    except ValueError:
        return False


def _of_bodies(bodies: dict[int, _Body]) -> list[str]:
    """Return what is wrong with bodies, by number."""
    longest = max([0.0, *(body.length for body in bodies.values())])
    return [line for body in bodies.values()
            for line in _of_mass(body, bodies) + _of_size(body, longest)]


def _bodies(m: Any) -> dict[int, _Body]:
    """Return what moves of `m`, by number."""
    state, roots = at_rest(m), [b for b in range(1, m.nbody) if m.body_weldid[b] == b]
    hinge = int(mujoco_module().mjtJoint.mjJNT_HINGE)
    carrier = {b: int(m.body_weldid[m.body_parentid[b]]) for b in roots}
    joint = {b: int(m.body_jntadr[b]) for b in roots}
    out = {}
    for b in roots:
        own = np.flatnonzero(m.body_weldid == b)
        mass = float(m.body_mass[own].sum())
        carried = [c for c in roots if carrier[c] == b]
        at, off, radius = state.xanchor[joint[b]], np.nan, 0.0
        if mass > LIMITS.absent:
            centre: Array = m.body_mass[own] @ state.xipos[own] / mass
            if m.jnt_type[joint[b]] == hinge:
                off = float(np.linalg.norm(np.cross(state.xaxis[joint[b]], centre - at)))
            real = own[m.body_mass[own] > LIMITS.absent]
            radius = float(np.sqrt(m.body_inertia[real].max(axis=1) / m.body_mass[real]).max())
        length = max([0.0, *(float(np.linalg.norm(state.xanchor[joint[c]] - at))
                             for c in carried)])
        out[b] = _Body(name_of(m, 'body', b), mass, carrier[b], carried, length, off, radius)
    return out


def _of_mass(body: _Body, bodies: dict[int, _Body]) -> list[str]:
    """Return what is wrong with the mass of a `body` among its neighbours."""
    mass, limits, kg = body.mass, LIMITS, 'check the unit (kg) and the point'
    carrier = bodies[body.carrier].mass if body.carrier in bodies else 0.0
    carried = max([0.0, *(bodies[c].mass for c in body.carried)])
    if mass <= limits.absent:
        return []
    if (mass < limits.light * min(carrier, carried) and body.length > limits.short) or (
            not body.carried and mass < min(limits.grain, limits.speck * carrier)):
        return [f'link {body.name}: mass {mass:.3g} kg: it hangs on {carrier:.3g} kg and carries '
                f'{carried:.3g} kg: too light for a link of {1e3 * body.length:.0f} mm; {kg}'
                if body.carried else
                f'link {body.name}: mass {mass:.3g} kg on a link of {carrier:.3g} kg: {kg}']
    neighbours = max(carrier, carried)
    if limits.absent < neighbours < mass / limits.heavy:
        return [f'link {body.name}: mass {mass:.4g} kg, its neighbours {neighbours:.3g} kg or '
                f'less: {kg}']
    return []


def _of_size(body: _Body, longest: float) -> list[str]:
    """Return what is wrong with centre and inertia of a `body` of a robot with such lengths."""
    if longest < LIMITS.short:
        return []
    lines, bound = [], LIMITS.far * longest
    if body.off > bound:
        lines.append(f'link {body.name}: centre of mass {body.off:.3g} m from its axis, the '
                     f'longest link has {longest:.3g} m: check the unit (m) and the origin of '
                     '<inertial>')
    if body.radius > bound:
        lines.append(f'link {body.name}: inertia of a body {body.radius:.3g} m in radius, the '
                     f'longest link has {longest:.3g} m: check the unit (kg m^2) and the mass')
    return lines


def _of_limits(m: Any) -> list[str]:
    """Return which joints of `m` may not move or take no torque."""
    kinds, lines = mujoco_module().mjtJoint, []
    for j in range(m.njnt):
        if m.jnt_type[j] not in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)):
            continue
        where = f'joint {name_of(m, "joint", j)}'
        low, high = (float(x) for x in m.jnt_range[j])
        if m.jnt_limited[j] and low >= high:
            lines.append(f'{where}: range {low:g} to {high:g}: state the travel, or no limit')
        if m.jnt_actfrclimited[j] and not np.any(m.jnt_actfrcrange[j]):
            lines.append(f'{where}: torque limit 0: state what the drive gives, or no limit')
    return lines
