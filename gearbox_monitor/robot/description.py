# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A robot's tree of joints and bodies, read from a URDF description.

Each link with mass is a body of the joint that moves it: a fixed joint only places what hangs on
it. A joint that mimics another one moves by that one's position.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any, NoReturn
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array

SUFFIXES = ('.xml', '.urdf', '.mjcf', '.xacro')  # of files that describe whole robots
MOVABLE = ('revolute', 'continuous', 'prismatic')
LONGEST = 4_000_000  # characters of a description
LOCKED_IN_VALUES = 'or joints that stand still (locked in --values)'
PRINCIPAL = 1e-9     # of the largest: how far below 0 a principal inertia is by rounding


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """
    N movable joints, a parent before its children, and B bodies.

    joints: names of the n joints that move by themselves, as in joint_states. Of each of the N:
    parent int64 [N], -1 = base; source int64 [N], the one of `joints` that moves it, by `ratio`
    times its position plus `offset` [N]; prismatic [N]; rotation [N, 3, 3], origin [N, 3] m and
    unit axis [N, 3], in the frame of its parent; losses [N, 2]: damping N m s/rad, friction N m;
    ranges [N, 2]: lowest and highest position, rad or m, infinite where the file has not both.
    Of each body, in the frame of its joint: joint int64 [B], mass [B] kg, com [B, 3] m and
    inertia [B, 3, 3] kg m^2 about it. links: {name: (joint, rotation [3, 3], origin [3])}.
    """

    joints: tuple[str, ...]
    parent: Any
    source: Any
    ratio: Array
    offset: Array
    prismatic: Any
    rotation: Array
    origin: Array
    axis: Array
    losses: Array
    ranges: Array
    body_joint: Any
    mass: Array
    com: Array
    inertia: Array
    links: Mapping[str, tuple[int, Array, Array]]


def parse(text: str, source: str, locked: Mapping[str, float] | None = None,
          whole: bool = False) -> RobotDescription:
    """
    Return the description in a URDF.

    Args:
        text: of the file.
        source: its name, for messages.
        locked: {joint that stands still, as do those that mimic it: position, rad or m}.
        whole: for the balance of all joints: those that move no mass are taken for fixed, unless
            all do; none may mimic another one.

    Raises:
        InputError: naming what the file holds and what was expected.
    """
    if len(text) > LONGEST:
        raise InputError(f'{source}: {len(text)} characters, expected a URDF of at most {LONGEST}')
    root, still = expanded_root(text, source), dict(locked or {})
    parser = _Parser(root, source, still, whole)
    description = parser.description()
    idle = [name for name in description.joints if name in parser.idle]
    if idle and len(idle) < len(description.joints):
        return _Parser(root, source, {**still, **dict.fromkeys(idle, 0.0)}, whole).description()
    return description


def own_joints(text: str, source: str) -> dict[str, bool]:
    """
    Return {joint that moves by itself: whether others mimic it}.

    Args:
        text: of a URDF.
        source: its name, for messages.

    Raises:
        InputError: it is no URDF.
    """
    joints = [x for x in expanded_root(text, source).findall('joint') if x.get('type') in MOVABLE]
    leaders = {mimic.get('joint') for x in joints for mimic in x.findall('mimic')}
    return {x.get('name', ''): x.get('name') in leaders
            for x in joints if x.find('mimic') is None}


def expanded_root(text: str | bytes, source: str) -> ElementTree.Element:
    """
    Return the root of a URDF without anything that xacro has to expand.

    Args:
        text: of the file.
        source: its name, for messages.

    Raises:
        InputError: no XML, no <robot>, or macros, `${prefix}` or `$(arg name)` of xacro.
    """
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f'{source}: {error}, expected a URDF robot description') from None
    if root.tag != 'robot':
        raise InputError(f'{source}: <{root.tag}>, expected <robot> of a URDF file')
    for element in root.iter():
        namespace, _, tag = element.tag.rpartition('}')
        words = [f'<xacro:{tag}>'] if 'xacro' in namespace else [
                f'<{element.tag} {name}="{value}">'
                for name, value in element.attrib.items() if '${' in value or '$(' in value]
        if words:
            raise InputError(f'{source}: {words[0]}: of xacro, expected a URDF: '
                             f'xacro {source} > robot.urdf')
    return root


class _Parser:
    """
    Walks the tree of the element `root` of a URDF called `source`, with joints `locked`.

    whole: see parse. idle: joints that move no mass.
    """

    def __init__(self, root: ElementTree.Element, source: str, locked: Mapping[str, float],
                 whole: bool = False) -> None:
        self._source, self._locked, self._whole = source, locked, whole
        self.idle: list[str] = []
        self._links = self._named(root, 'link')
        self._joints = self._named(root, 'joint')
        movable = [name for name, joint in self._joints.items() if joint.get('type') != 'fixed']
        if not movable:
            self._fail('joints', 'none can move', 'at least one of ' + ', '.join(MOVABLE))
        for name in locked:
            if name not in movable:
                self._unknown('locked', name, movable)
        self._rows: list[dict[str, Any]] = []   # of movable joints
        self._bodies: list[tuple[int, float, Array, Array]] = []
        self._places: dict[str, tuple[int, Array, Array]] = {}

    def description(self) -> RobotDescription:
        children: dict[str, list[tuple[str, ElementTree.Element]]] = {}
        moved: dict[str, str] = {}
        for name, element in self._joints.items():
            parent, child = (self._link_of(name, element, tag) for tag in ('parent', 'child'))
            if child in moved:
                self._fail(f'joint {name}', f'child {child} hangs on joint {moved[child]}, too',
                           'one joint for each link')
            moved[child] = name
            children.setdefault(parent, []).append((child, element))
        roots = [name for name in self._links if name not in moved]
        if len(roots) != 1:
            self._fail('links', f'{len(roots)} links without a parent', 'a tree with one root')
        waiting: list[tuple[str, int, Array, Array]] = [(roots[0], -1, np.eye(3), np.zeros(3))]
        while waiting:
            link, joint, rotation, origin = waiting.pop()
            self._places[link] = joint, rotation, origin
            self._add_body(link, joint, rotation, origin)
            for child, element in reversed(children.get(link, [])):
                waiting.append((child, *self._place(element, joint, rotation, origin)))
        return self._made()

    def _made(self) -> RobotDescription:
        rows = self._rows
        free = [row['name'] for row in rows if row['mimics'] is None]
        if not free:
            self._fail('joints', 'none can move', 'at least one of ' + ', '.join(MOVABLE))
        source, ratio, offset = [], [], []
        for row in rows:
            of, factor, shift = row['name'], 1.0, 0.0
            if row['mimics'] is not None:
                of, factor, shift = row['mimics']
                if self._whole:
                    self._fail(f'joint {row["name"]}',
                               f'<mimic joint="{of}" multiplier="{factor:g}" offset="{shift:g}">',
                               f'joints that move by themselves, {LOCKED_IN_VALUES}')
                if of not in free:
                    self._unknown(f'joint {row["name"]}: mimic', of, free)
            source.append(free.index(of))
            ratio.append(factor)
            offset.append(shift)
        joints, masses, coms, inertias = zip(*self._bodies) if self._bodies else ([],) * 4
        for i, row in enumerate(rows):
            if any(self._hangs_on(i, int(joint)) for joint in joints):
                continue
            self.idle.append(row['name'])
            if not self._whole or len(self.idle) == len(rows):
                self._fail(f'joint {self.idle[0]}', 'moves no mass',
                           f'an <inertial> in a link behind it, {LOCKED_IN_VALUES}')
        return RobotDescription(
            tuple(free), np.array([row['parent'] for row in rows]), np.array(source),
            np.array(ratio), np.array(offset), np.array([row['prismatic'] for row in rows]),
            np.array([row['rotation'] for row in rows]), np.array([row['origin'] for row in rows]),
            np.array([row['axis'] for row in rows]), np.array([row['losses'] for row in rows]),
            np.array([row['range'] for row in rows]), np.array(joints), np.array(masses),
            np.array(coms), np.array(inertias), self._places)

    def _hangs_on(self, joint: int, other: int) -> bool:
        """Return whether joint `other` is `joint`, or behind it."""
        while other > joint:
            other = self._rows[other]['parent']
        return other == joint

    def _add_body(self, link: str, joint: int, rotation: Array, origin: Array) -> None:
        inertial = self._links[link].find('inertial')
        if inertial is None or joint < 0:
            return  # what does not move loads no joint
        where = f'link {link}: inertial'
        turned, shift = self._origin(inertial, where)
        mass_element, element = inertial.find('mass'), inertial.find('inertia')
        mass = self._number(mass_element, 'value', where, None)
        ixx, iyy, izz, ixy, ixz, iyz = (
            self._number(element, name, where, None if name[1] == name[2] else 0.0)
            for name in ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz'))
        inertia = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        lowest = float(np.linalg.eigvalsh(inertia)[0])
        # A mass has a size of about a millimetre at least: less than that is rounding, too.
        if mass < 0.0 or lowest < -PRINCIPAL * (float(np.abs(inertia).max()) + 1e-3 * mass):
            self._fail(where, f'mass {mass:g} kg, smallest principal inertia {lowest:.3g} kg m^2',
                       'none below 0')
        if mass == 0.0 and not inertia.any():
            return
        whole = rotation @ turned
        self._bodies.append((joint, mass, rotation @ shift + origin, whole @ inertia @ whole.T))

    def _place(self, element: ElementTree.Element, joint: int, rotation: Array,
               origin: Array) -> tuple[int, Array, Array]:
        """Return joint and frame of the child of the joint `element`, on a link placed so."""
        name, kind = element.get('name', ''), element.get('type', '')
        where = f'joint {name}'
        turned, shift = self._origin(element, where)
        frame, at = rotation @ turned, rotation @ shift + origin
        if kind == 'fixed':
            return joint, frame, at
        if kind not in MOVABLE:
            self._fail(where, f'type {kind!r}', 'one of ' + ', '.join((*MOVABLE, 'fixed')))
        axis = self._vector(element.find('axis'), 'xyz', f'{where}: axis', (1.0, 0.0, 0.0))
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            self._fail(f'{where}: axis', '0 0 0', 'a direction')
        mimic, mimics = element.find('mimic'), None
        if mimic is not None:
            mimics = (mimic.get('joint', ''),
                      self._number(mimic, 'multiplier', f'{where}: mimic', 1.0),
                      self._number(mimic, 'offset', f'{where}: mimic', 0.0))
        position = self._locked.get(name)
        if position is None and mimics is not None and mimics[0] in self._locked:
            position = mimics[1] * self._locked[mimics[0]] + mimics[2]
        if position is not None and kind == 'prismatic':
            return joint, frame, at + frame @ axis * (position / length)
        if position is not None:
            return joint, frame @ rotations(axis / length, np.array([position]))[0], at
        self._rows.append({
            'name': name, 'parent': joint, 'mimics': mimics, 'prismatic': kind == 'prismatic',
            'rotation': frame, 'origin': at, 'axis': axis / length,
            'losses': [self._number(element.find('dynamics'), key, f'{where}: dynamics', 0.0)
                       for key in ('damping', 'friction')],
            'range': self._range(element, f'{where}: limit')})
        return len(self._rows) - 1, np.eye(3), np.zeros(3)

    def _range(self, joint: ElementTree.Element, where: str) -> tuple[float, float]:
        limit = joint.find('limit')
        if limit is None or joint.get('type') == 'continuous' or not {
                'lower', 'upper'} <= limit.attrib.keys():
            return -math.inf, math.inf
        low, high = (finite_number(limit.attrib[key], f'{self._source}: {where}: {key}', math.inf)
                     for key in ('lower', 'upper'))
        return (low, high) if low < high else (-math.inf, math.inf)

    def _named(self, root: ElementTree.Element, tag: str) -> dict[str, ElementTree.Element]:
        result: dict[str, ElementTree.Element] = {}
        for element in root.findall(tag):
            name = element.get('name', '')
            if not name or name in result:
                self._fail(tag, f'name {name!r}', 'a name of its own')
            result[name] = element
        return result

    def _link_of(self, name: str, joint: ElementTree.Element, tag: str) -> str:
        element = joint.find(tag)
        link = '' if element is None else element.get('link', '')
        if link not in self._links:
            self._unknown(f'joint {name}: {tag}', link, self._links)
        return link

    def _origin(self, element: ElementTree.Element, where: str) -> tuple[Array, Array]:
        origin = element.find('origin')
        roll, pitch, yaw = self._vector(origin, 'rpy', f'{where}: origin', (0.0,) * 3)
        return turn(roll, pitch, yaw), self._vector(origin, 'xyz', f'{where}: origin', (0.0,) * 3)

    def _vector(self, element: ElementTree.Element | None, name: str, where: str,
                default: Sequence[float]) -> Array:
        text = None if element is None else element.get(name)
        if text is None:
            return np.array(default)
        numbers = [self._finite(part, f'{where}: {name}') for part in text.split()]
        if len(numbers) != 3:
            self._fail(f'{where}: {name}', repr(text), 'three numbers')
        return np.array(numbers)

    def _number(self, element: ElementTree.Element | None, name: str, where: str,
                default: float | None) -> float:
        text = None if element is None else element.get(name)
        if text is None:
            if default is None:
                self._fail(where, f'no {name}', 'a number')
            return default
        return self._finite(text, f'{where}: {name}')

    def _finite(self, text: str, where: str) -> float:
        return finite_number(text, f'{self._source}: {where}')

    def _unknown(self, where: str, name: str, names: Iterable[str]) -> NoReturn:
        raise InputError(f'{self._source}: {where}: {name!r}, {unknown(name, names)}')

    def _fail(self, where: str, value: str, expected: str) -> NoReturn:
        raise InputError(f'{self._source}: {where}: {value}, expected {expected}')


def finite_number(text: str, where: str, most: float = 1e9) -> float:
    """
    Return the number that an attribute holds.

    Args:
        text: of the attribute.
        where: it is, for messages.
        most: size that it may not exceed; infinite: a range may have no end.

    Raises:
        InputError: no number, or a larger one.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) <= most:
        raise InputError(f'{where}: {text!r}, expected a number')
    return value


def rotations(axis: Array, angle: Array) -> Array:
    """Return rotation matrices [N, 3, 3] by `angle` [N] (rad) about the unit vector `axis`."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * cross + (1.0 - c) * (cross @ cross)


def turn(roll: float, pitch: float, yaw: float) -> Array:
    """Return the rotation [3, 3] by `roll`, `pitch` and `yaw` (rad) about fixed axes x, y, z."""
    (cr, sr), (cp, sp), (cy, sy) = (
        (math.cos(angle), math.sin(angle)) for angle in (roll, pitch, yaw))
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])
