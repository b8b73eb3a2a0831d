# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Shapes of a joint's torque that a reference may need: friction and ripple that no file knows."""
from collections.abc import Callable, Mapping
from functools import cache, partial
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.balance_column import JointMotion, waves

Shape: TypeAlias = Callable[[JointMotion], Array]  # -> [N, k]
DRY, VISCOUS = 'dry', 'viscous'  # friction that scales with the day, each as a whole
ORDERS, FEW, SPEEDS = 60, 6, (0.03, 0.06, 0.12, 0.25, 0.5)


def _angle(m: JointMotion, n: int) -> Array:
    return waves(n * m.q)


def _angle_direction(m: JointMotion, n: int) -> Array:
    return m.sign[:, None] * waves(n * m.q)


def _angle_load(m: JointMotion, n: int) -> Array:
    return m.load[:, None] * waves(n * m.q)


def _slow(m: JointMotion, vs: float) -> Array:
    return (m.sign * np.exp(-(m.v / vs) ** 2))[:, None]


def _slow_angle(m: JointMotion, vs: float) -> Array:
    return _slow(m, vs) * waves(m.q)


def _speed_angle(m: JointMotion, n: int) -> Array:
    return m.v[:, None] * waves(n * m.q)


FIRST: Mapping[str, Shape] = MappingProxyType({   # what every joint may have
    'direction': lambda m: m.sign[:, None],
    'speed': lambda m: m.v[:, None],
    'square of speed': lambda m: (m.v * np.abs(m.v))[:, None],
    'slow 0.1': partial(_slow, vs=0.1),
    'load and direction': lambda m: (m.sign * np.abs(m.load))[:, None],
    'constant': lambda m: np.ones((len(m.t), 1)),
    'load': lambda m: m.load[:, None],
    'angle 1': partial(_angle, n=1)})


@cache
def dictionary() -> Mapping[str, Shape]:
    """Return {name: shape} of what is searched beside FIRST."""
    shapes: dict[str, Shape] = {f'angle {n}': partial(_angle, n=n) for n in range(2, ORDERS + 1)}
    for n in range(1, FEW + 1):
        shapes[f'angle {n} and direction'] = partial(_angle_direction, n=n)
    for n in range(1, 4):
        shapes[f'angle {n} and speed'] = partial(_speed_angle, n=n)
        shapes[f'angle {n} and load'] = partial(_angle_load, n=n)
    for vs in SPEEDS:
        shapes[f'slow {vs}'] = partial(_slow, vs=vs)
        shapes[f'slow {vs} and angle'] = partial(_slow_angle, vs=vs)
    shapes['root of speed'] = lambda m: (m.sign * np.sqrt(np.abs(m.v)))[:, None]
    shapes['size of speed'] = lambda m: np.abs(m.v)[:, None]
    shapes['load and signed direction'] = lambda m: (m.sign * m.load)[:, None]
    shapes['square of load and direction'] = lambda m: (m.sign * m.load ** 2)[:, None]
    shapes['load and speed'] = lambda m: (m.v * np.abs(m.load))[:, None]
    shapes['square of load'] = lambda m: (m.load * np.abs(m.load))[:, None]
    return MappingProxyType(shapes)


def shape_of(name: str) -> Shape:
    """Return the shape `name`, of FIRST or the dictionary."""
    return FIRST.get(name) or dictionary()[name]


def group_of(name: str) -> str:
    """Return DRY or VISCOUS of the shape `name` of friction, '' of another one."""
    if any(word in name for word in ('direction', 'slow', 'root')):
        return DRY
    return VISCOUS if 'speed' in name else ''
