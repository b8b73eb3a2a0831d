# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Effects that only a robot has: of its links, its base, two joints, an end of a range.

Each says what it adds to the balance and what its coefficients mean; those of a single joint's
drive stand beside their equations in plant.effects.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
import math
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.robot.rows import Rows
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.balance_column import BalanceColumn, not_negative, one

JOINT, LINK, BASE = 'joint', 'link', 'base'
GRAVITY_SIZE = 9.80665
WIDEST = 0.6  # m: farthest place of a payload from its link's frame
LEAST_MASS = 1e-3  # kg, below which a payload has no centre
Columns: TypeAlias = Mapping[int, Array]  # {joint: [R, k]}


@dataclass(frozen=True)
class RobotEffect:
    """
    An effect of a robot.

    id, meaning: as of an Effect; units {parameter: unit}. place: JOINT, LINK or BASE. column: of
    an effect of one joint; else columns(rows, index, centre) of the joint or link `index`, and
    values(b, centre). low: of the first coefficient, beside a model file. subject: the value by
    which reports state it, and what it is in words. over: what tells it from another one of the
    same id and place. shows: how it shows in data. since: version.
    """

    id: str
    meaning: str
    units: Mapping[str, str]
    place: str
    column: BalanceColumn | None = None
    columns: Callable[[Rows, int, Array], Columns] | None = None
    values: Callable[[Array, Array], Mapping[str, float]] | None = None
    low: float = -math.inf
    subject: tuple[str, str] = ('', '')
    over: str = ''
    shows: str = ''
    since: str = '0.2.0'


def compact(centre: Array) -> Array:
    """
    Return d theta / d(m, m c) [10, 4] of a compact mass at `centre` [3] (m).

    Its inertia is quadratic in m c over m, so theta is homogeneous of degree 1: it equals this
    matrix times (m, m c).
    """
    x, y, z = centre
    out = np.zeros((10, 4))
    out[:4] = np.eye(4)
    out[4:, 0] = -(y * y + z * z), -(x * x + z * z), -(x * x + y * y), x * y, x * z, y * z
    out[4:, 1:] = [[0, 2 * y, 2 * z], [2 * x, 0, 2 * z], [2 * x, 2 * y, 0],
                   [-y, -x, 0], [-z, 0, -x], [0, -z, -y]]
    return out


def _mass(rows: Rows, link: int, centre: Array) -> Columns:
    return {j: rows.inertial[link, j] @ compact(centre) for j in rows.robot.chain.movers[link]}


def _mass_values(b: Array, centre: Array) -> dict[str, float]:
    at = b[1:4] / b[0] if abs(b[0]) > 1e-9 else np.zeros(3)
    return {'m': float(b[0]), **{name: float(v) for name, v in zip(('cx', 'cy', 'cz'), at)}}


def centre_of(b: Array) -> Array:
    """Return the centre [3] of a mass with the coefficients `b` [4], within WIDEST."""
    return np.clip(b[1:4] / b[0], -WIDEST, WIDEST) if abs(b[0]) > LEAST_MASS else np.zeros(3)


INERTIA_NAMES = ('Ixx', 'Iyy', 'Izz', 'Ixy', 'Ixz', 'Iyz')
PAYLOAD = RobotEffect(
    'payload', 'a mass that the model does not have', MappingProxyType(
        {'m': 'kg', 'cx': 'm', 'cy': 'm', 'cz': 'm'}), LINK, columns=_mass, values=_mass_values,
    low=0.0, shows='All joints that carry the link need more torque: against gravity at rest, and '
                   'in proportion to their acceleration.')
LINK_INERTIA = RobotEffect(
    'link_inertia', 'inertia of a link is not that of the model', MappingProxyType(
        dict.fromkeys(INERTIA_NAMES, 'kg m^2')), LINK, columns=lambda rows, link, c: {
            j: rows.inertial[link, j][:, 4:] for j in rows.robot.chain.movers[link]},
    values=lambda b, c: dict(zip(INERTIA_NAMES, b.tolist())),
    shows='The difference follows the angular acceleration of the link, and is absent at rest.')
BASE_TILT = RobotEffect(
    'base_tilt', 'the base is not level as the model says', MappingProxyType(
        {'ax': 'rad', 'ay': 'rad'}), BASE, columns=lambda rows, i, c: rows.tilt,
    values=lambda b, c: dict(zip(('ax', 'ay'), (b / GRAVITY_SIZE).tolist())),
    shows='The torque against gravity is off at all joints at once, as if gravity had another '
          'direction.')
JOINT_ZERO = RobotEffect(
    'joint_zero', 'the encoder of a joint has another zero', MappingProxyType({'c': 'rad'}),
    JOINT, columns=lambda rows, joint, c: rows.zero[joint],
    values=lambda b, c: {'c': float(b[0])},
        subject=('c', 'zero of the encoder'),
    shows='The torque against gravity of this joint and those before it belongs to another '
          'angle.')
QUADRATIC = RobotEffect(
    'quadratic_friction', 'friction that grows with the square of the speed', MappingProxyType(
        {'Cq': 'N m s^2/rad^2'}), JOINT, BalanceColumn(
            lambda m, _: (m.v * np.abs(m.v))[:, None], one('Cq'), low=not_negative),
        subject=('Cq', 'friction with the square of the speed'),
    shows='The friction grows faster than the speed: slow moves fit, fast ones are too fast in '
          'the model.')


def _end_spring(end: str, side: float, shares: Sequence[float]) -> RobotEffect:
    """Return the spring at one `end` of the range; `shares` of the motion below its begin."""
    beyond = np.maximum if side > 0.0 else np.minimum
    return RobotEffect(
        'end_spring', f'a spring or a cable pulls back at the {end} end of the range',
        MappingProxyType({'k': 'N m/rad', 'q0': 'rad'}), JOINT, BalanceColumn(
            lambda m, q0: beyond(m.q - q0, 0.0)[:, None],
            lambda b, q0: {'k': float(b[0]), 'q0': q0, 'side': side}, setting='q0', place=True,
            grid=lambda m: list(dict.fromkeys(np.quantile(m.q, shares).tolist())),
            low=not_negative),
        subject=('k', 'spring at the end of the range'), over=f'{end} end',
        shows=f'Beyond an angle near the {end} end the joint needs a torque that grows with the '
              'angle.')


UPPER_SPRING = _end_spring('upper', 1.0, (0.5, 0.65, 0.8, 0.9))
LOWER_SPRING = _end_spring('lower', -1.0, (0.1, 0.2, 0.35, 0.5))
COUPLING = RobotEffect(
    'joint_coupling', 'the motion of another joint drags this one', MappingProxyType(
        {'Cc': 'N m', 'Cv': 'N m s/rad'}), JOINT, columns=lambda rows, pair, c: {
            pair // len(rows.joints): rows.tested(
                pair // len(rows.joints), np.stack([
                    rows.joints[pair % len(rows.joints)].sign,
                    rows.joints[pair % len(rows.joints)].v], axis=1))},
    values=lambda b, c: {'Cc': float(b[0]), 'Cv': float(b[1])},
        subject=('Cc', 'drag by another joint'),
    shows='The joint needs a torque while another one moves, with the sign of that motion.')
ROBOT_EFFECTS = (PAYLOAD, LINK_INERTIA, BASE_TILT, JOINT_ZERO, QUADRATIC, UPPER_SPRING,
                 LOWER_SPRING, COUPLING)
