# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Effects that only a robot has: of its links, its base, an end of a range.

Each says what it adds to the balance and what its coefficients mean; those of a single joint's
drive stand beside their equations in plant.effects.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from gearbox_monitor.diagnosis.robot.rows import RobotModel, Rows
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.effect import BalanceColumn, not_negative, one
from gearbox_monitor.robot.chain import Chain, inertial, level_frame, pseudo_inertia

JOINT, LINK, BASE = 'joint', 'link', 'base'
GRAVITY_SIZE = 9.80665
WIDEST = 0.6  # m: farthest place about which the inertia of a payload is linear
LEAST_MASS = 1e-3  # kg, below which a payload has no centre
Columns: TypeAlias = Mapping[int, Array]  # {joint: [R, k]}


@dataclass(frozen=True)
class RobotEffect:
    """
    An effect of a robot.

    id, meaning: as of an Effect; units {parameter: unit}. place: JOINT, LINK or BASE. column: of
    an effect of one joint; else columns(rows, index, setting) of the joint or link `index`, and
    values(b, setting). starts(chain, index): settings to begin with; next_setting(b): what follows
    from the coefficients b, None for an effect without. low: of the first coefficient, beside a
    model file; high: of the size of all; possible(robot, index, b, deviations): whether physics
    allows the coefficients; deviation(chain, index): of the coefficients by their prior, None:
    anything goes. subject: the value by which reports state it, and what it is in words. over:
    what tells it from another one of the same id and place. shows: how it shows in data. since:
    version.
    """

    id: str
    meaning: str
    units: Mapping[str, str]
    place: str
    column: BalanceColumn | None = None
    columns: Callable[[Rows, int, Array], Columns] | None = None
    values: Callable[[Array, Array], Mapping[str, float]] | None = None
    starts: Callable[[Chain, int], Sequence[Array]] = lambda chain, index: [np.zeros(3)]
    next_setting: Callable[[Array], Array] | None = None
    low: float = -math.inf
    high: float = math.inf
    possible: Callable[[RobotModel, int, Array, Array], bool] | None = None
    deviation: Callable[[Chain, int], Array] | None = None
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


def _centres(chain: Chain, link: int) -> list[Array]:
    # At the origin of its link a mass has no inertia: a swing in which that cancels the weight
    # would not show it. About a body's centre near the axis, a load far from it is linear in no
    # way: its inertia made it a mass of tons less. So also where the next links hang.
    hung = [other.origin for other in chain.links if other.parent == link and other.origin.any()]
    return [np.zeros(3), chain.links[link].theta[1:4] / chain.links[link].mass, *hung]


def _mass_values(b: Array, centre: Array) -> dict[str, float]:
    at = b[1:4] / b[0] if abs(b[0]) > 1e-9 else np.zeros(3)
    return {'m': float(b[0]), **{name: float(v) for name, v in zip(('cx', 'cy', 'cz'), at)}}


def centre_of(b: Array) -> Array:
    """Return the centre [3] of a mass with the coefficients `b` [4], within WIDEST."""
    return np.clip(b[1:4] / b[0], -WIDEST, WIDEST) if abs(b[0]) > LEAST_MASS else np.zeros(3)


def reach_of(chain: Chain, link: int) -> float:
    """Return how far from `link` a load may be, m: what hangs behind, or half of the arm."""
    return max(chain.extent(link), 0.5 * max(chain.extent(j) for j in chain.movers[link]))


def _load_size(chain: Chain, link: int) -> Array:
    """Return the deviation [4] of a load at `link`: no load is heavier than the whole robot."""
    return float(chain.theta[:, 0].sum()) * np.array([1.0, *(reach_of(chain, link),) * 3])


def _within_reach(robot: RobotModel, link: int, b: Array, deviations: Array) -> bool:
    """
    Return whether a mass may be where it seems to be, with a mass in sum that is positive.

    What is carried reaches no farther than reach_of.
    """
    chain = robot.chain
    behind = sum(chain.links[k].mass for k in chain.moved_by(link))
    if b[0] + 2.0 * deviations[0] < -behind * (1.0 + robot.tolerance.max()):
        return False
    reach = reach_of(chain, link)
    unsure = float(np.linalg.norm(deviations[1:]))
    return float(np.linalg.norm(b[1:])) - 2.0 * unsure < reach * (abs(b[0]) + 2.0 * deviations[0])


def _has_inertia(robot: RobotModel, link: int, b: Array, deviations: Array) -> bool:
    """Return whether a link, in learnt models with all behind it, stays a body."""
    chain, change = robot.chain, np.r_[np.zeros(4), b]
    behind = sum(chain.links[k].mass for k in chain.moved_by(link))
    size = inertial(behind, np.zeros(3), behind * chain.extent(link) ** 2 * np.eye(3))
    whole = chain.links[link].theta + change + (size if robot.learnt else 0.0)
    unsure = 2.0 * float(np.abs(deviations).max())
    return float(np.linalg.eigvalsh(pseudo_inertia(whole))[0]) > -unsure


INERTIA_NAMES = ('Ixx', 'Iyy', 'Izz', 'Ixy', 'Ixz', 'Iyz')
PAYLOAD = RobotEffect(
    'payload', 'a mass that the model does not have', MappingProxyType(
        {'m': 'kg', 'cx': 'm', 'cy': 'm', 'cz': 'm'}), LINK, columns=_mass, values=_mass_values,
    starts=_centres, next_setting=centre_of, low=0.0, possible=_within_reach,
    deviation=_load_size,
    shows='All joints that carry the link need more torque: against gravity at rest, and in '
          'proportion to their acceleration.')
LINK_INERTIA = RobotEffect(
    'link_inertia', 'inertia of a link differs from the model', MappingProxyType(
        dict.fromkeys(INERTIA_NAMES, 'kg m^2')), LINK, columns=lambda rows, link, c: {
            j: rows.inertial[link, j][:, 4:] for j in rows.robot.chain.movers[link]},
    values=lambda b, c: dict(zip(INERTIA_NAMES, b.tolist())), possible=_has_inertia,
    shows='The difference follows the angular acceleration of the link, and is absent at rest.')


def _gravity(b: Array) -> tuple[float, float]:
    """Return angle (rad) and size (m/s^2) of the gravity that a change `b` [2 or 3] makes."""
    level = math.hypot(b[0], b[1])
    if len(b) == 2:
        return math.asin(min(level / GRAVITY_SIZE, 1.0)), GRAVITY_SIZE
    return math.atan2(level, GRAVITY_SIZE - b[2]), math.hypot(level, GRAVITY_SIZE - b[2])


def _tilt_values(b: Array, setting: Array) -> dict[str, float]:
    return dict(zip(('ax', 'ay'), (
        _gravity(b)[0] / max(math.hypot(b[0], b[1]), 1e-12) * b[:2]).tolist()))


def _of_gravity(robot: RobotModel, index: int, b: Array, deviations: Array) -> bool:
    """Return whether gravity keeps its size, within the tolerance of masses that none taught."""
    off = abs(_gravity(b)[1] / GRAVITY_SIZE - 1.0)
    unsure = 0.0 if robot.learnt else float(robot.tolerance.max())
    return off < 0.1 + unsure + 2.0 * float(deviations.max()) / GRAVITY_SIZE


def tilted(gravity: Array, ax: float, ay: float) -> Array:
    """Return `gravity` [3] as a base sees it that is tilted by `ax`, `ay` (rad, of BASE_TILT)."""
    angle = math.hypot(ax, ay)
    along = np.array([ax, ay]) / max(angle, 1e-12)
    size = float(np.linalg.norm(gravity))
    change = np.array([*(math.sin(angle) * along), 1.0 - math.cos(angle)])
    return gravity + size * change @ level_frame(gravity)


BASE_TILT = RobotEffect(
    'base_tilt', 'the base is not level as the model says', MappingProxyType(
        {'ax': 'rad', 'ay': 'rad'}), BASE, values=_tilt_values, possible=_of_gravity,
    # Torque is linear in gravity, not in its angle: a small tilt has two coefficients, any three.
    columns=lambda rows, i, setting: {j: x[:, :len(setting)] for j, x in rows.tilt.items()},
    starts=lambda chain, i: [np.zeros(2), np.zeros(3)],
    shows='The torque against gravity is off at all joints at once, as if gravity had another '
          'direction.')
JOINT_ZERO = RobotEffect(
    'joint_zero', 'the encoder of a joint has another zero', MappingProxyType({'c': 'rad'}),
    JOINT, columns=lambda rows, joint, c: rows.zero[joint],
    values=lambda b, c: {'c': float(b[0])}, high=math.pi,  # half a turn off: the farthest
    subject=('c', 'zero of the encoder'),
    shows='The torque against gravity of this joint and those before it belongs to another '
          'angle.')
# Of any size, inertia included: for logs that are read wrongly.
READ_OFF = replace(
    JOINT_ZERO, columns=lambda rows, joint, c: rows.read_off(joint, float(c[0])),
    starts=lambda chain, i: [np.full(1, 1e-4)],
    next_setting=lambda b: np.clip(np.where(np.abs(b) < 1e-4, 1e-4, b), -math.pi, math.pi))
QUADRATIC = RobotEffect(
    'quadratic_friction', 'friction that grows with the square of the speed', MappingProxyType(
        {'Cq': 'N m s^2/rad^2'}), JOINT, BalanceColumn(
            lambda m, _: (m.v * np.abs(m.v))[:, None], one('Cq'), low=not_negative,
            dissipates=True),
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
ROBOT_EFFECTS = (PAYLOAD, LINK_INERTIA, BASE_TILT, JOINT_ZERO, QUADRATIC, UPPER_SPRING,
                 LOWER_SPRING)
