# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a drive into a URDF file: friction, limit and inertia of one joint, nothing else.

URDF has no rotor: the inertia of the motor goes into the link that the joint moves.
"""
import cmath
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side
from gearbox_monitor.robot.description import parse, RobotDescription, turn
from gearbox_monitor.robot.dynamics import arrays_of, move, NO_PAYLOAD, Payload, torque_on
from gearbox_monitor.simulators.mjcf import CONSTRUCT, Exported, NATIVE, REFUSED
from gearbox_monitor.simulators.mjcf_patch import across, balanced, number, Patch, Splice
from gearbox_monitor.simulators.urdf_file import inertial_in, TENSOR
from gearbox_monitor.simulators.xml_edit import (
    Edit, edited, parse_xml, with_attributes, with_child, words_of, XmlDocument, XmlElement)

SIMULATED_GRAVITY = (0.0, 0.0, -9.81)  # m/s^2: default of MuJoCo, Isaac and Bullet
SAME = 1e-6  # relative: what differs by less is not edited
LEAST = 0.05  # of a tensor about the axis: what is taken from it leaves so much
ROOT = 'robot'
# What an effect becomes in a URDF file.
EXPRESSED = {
    motor_side.MOTOR_INERTIA.id: 'inertia of the link that the joint moves',
    arm_side.ARM_INERTIA.id: 'inertia of the link that the joint moves',
    arm_side.GRAVITY.id: 'mass and origin of the link that the joint moves',
    motor_side.MOTOR_VISCOUS.id: 'dynamics damping', arm_side.ARM_VISCOUS.id: 'dynamics damping',
    motor_side.MOTOR_COULOMB.id: 'dynamics friction',
    arm_side.ARM_COULOMB.id: 'dynamics friction', actuator.SATURATION.id: 'limit effort'}
RIGID = ('a joint is rigid there: two joints with a spring between them, or a model with '
         'transmission.kind: rigid')


class _Draft:
    """Edits of one file as they gather."""

    def __init__(self, document: XmlDocument) -> None:
        self.document = document
        self.edits: list[Edit] = []
        self.changes: list[Splice] = []

    def attributes(self, element: XmlElement, title: str, values: Mapping[str, float]) -> None:
        """Give an element those of the attributes `values` that differ; `title`: of the change."""
        new = {k: number(v) for k, v in values.items()
               if not _same(element.attributes.get(k, ''), v)}
        self.edits += with_attributes(self.document, element, dict(new))
        self.changes += [Splice(title, k, element.attributes.get(k, ''), v)
                         for k, v in new.items()]

    def child(self, parent: XmlElement, title: str, text: str) -> None:
        """Add a child, its `text`, to the element `parent`; `title`: of the change."""
        self.edits.append(with_child(self.document, parent, text))
        self.changes.append(Splice(title, '', '', ' '.join(text.split())))


def child_of(element: XmlElement, tag: str) -> XmlElement | None:
    """Return the first child of `element` with a `tag`."""
    return next(iter(element.all(tag)), None)


def _same(text: str, value: float) -> bool:
    try:
        present = float(text or '0')
    except ValueError:
        return False
    return abs(present - value) <= SAME * max(abs(present), abs(value))


def in_urdf(effect: Effect) -> str:
    """Return what an `effect` of the library becomes in a URDF file, or why nothing."""
    if effect.id in EXPRESSED:
        return EXPRESSED[effect.id]
    of_place = {'transmission': RIGID, 'controller': 'set its gains in your code'}
    return f'none: {of_place.get(effect.location) or _reason(effect)}'


def _reason(effect: Effect | None) -> str:
    """Return why URDF has no parameter for an `effect`; None: of a plug-in."""
    if effect is not None and effect.location.endswith('sensor'):
        return 'no sensor has it: change the reading in your code'
    return 'no parameter has its law: apply it in your code'


def _not_in_urdf(model: DriveModel) -> list[Exported]:
    """Return what of a model URDF has no parameter for."""
    folded, out = model.folded(), dict[str, str]()
    if folded.transmission.kind != 'rigid':
        out['transmission'] = RIGID
    if folded.position_gain:
        out['position_gain'] = 'no spring to the ground: add it in your code'
    if folded.torque_offset:
        out['torque_offset'] = 'add it to the commanded torque'
    if model.controller is not None:
        out['controller'] = 'set its gains in your code'
    for effect in model.effects:
        name = effect['id']
        entry = EFFECTS.get(name)
        of_transmission = entry is not None and entry.location == 'transmission' and (
            entry.replaces or entry.adds_to)
        if name not in EXPRESSED and not of_transmission:
            out.setdefault(name, _reason(entry))
    return [Exported(name, REFUSED, reason) for name, reason in out.items()]


def _values_of(model: DriveModel) -> dict[str, float]:
    """Return {attribute: value} of the joint, N m and N m s/rad, or N and N s/m of a slide."""
    folded = model.folded()
    of = {e['id']: e for e in model.effects}
    values = {'damping': folded.viscous_friction + sum(
                  e['Cav'] for e in folded.effects if e['id'] == arm_side.ARM_VISCOUS.id),
              'friction': folded.coulomb_friction + sum(
                  e['Cac'] for e in folded.effects if e['id'] == arm_side.ARM_COULOMB.id)}
    if limit := of.get(actuator.SATURATION.id):
        values['effort'] = limit['umax']
    return values


def patched_robot(data: bytes, path: Path, joint: str, model: DriveModel) -> Patch:
    """
    Return the Patch that gives a joint in a URDF file the values of a model.

    Args:
        data: bytes of the file.
        path: of the file.
        joint: its name.
        model: of the drive.

    Returns:
        The Patch; `exported` has what is not native there, with the reason.

    Raises:
        InputError: another format, or no such joint.
    """
    document = parse_xml(data, str(path))
    if document.root.tag != ROOT:
        raise InputError(f'{path}: line {document.root.line}: <{document.root.tag}>, expected '
                         f'<{ROOT}> with --to urdf')
    draft = _Draft(document)
    element = _urdf_joint(document, joint)
    exported = [*_not_in_urdf(model), *_joint_of_urdf(draft, element, _values_of(model))]
    try:
        exported += _inertial(draft, element, joint, model, data.decode('utf-8'))
    except InputError as error:
        exported.append(Exported('inertia', REFUSED, f'{error}; the joint moves '
                                 f'{_inertia_of(model):.6g} in the model'))
    patch = Patch(edited(document, draft.edits), tuple(draft.changes), tuple(exported),
                  (joint, None))
    parse_xml(patch.data, str(path))
    return patch


def _inertia_of(model: DriveModel) -> float:
    folded = model.folded()
    return folded.motor_inertia + folded.arm_inertia


def _urdf_joint(document: XmlDocument, name: str) -> XmlElement:
    for element in document.root.all('joint'):
        if element.attributes.get('name') == name:
            return element
    raise InputError(f'{document.name}: joint: {name!r} is not in this file, expected one of '
                     + ', '.join(e.attributes.get('name', '')
                                 for e in document.root.all('joint')))


def _joint_of_urdf(draft: _Draft, joint: XmlElement, values: Mapping[str, float]
                   ) -> Sequence[Exported]:
    title = f'joint "{joint.attributes["name"]}" '
    dynamics, limit = child_of(joint, 'dynamics'), child_of(joint, 'limit')
    own = {k: values[k] for k in ('damping', 'friction')}
    if dynamics is not None:
        draft.attributes(dynamics, title + 'dynamics', own)
    elif any(own.values()):
        words = words_of({k: number(v) for k, v in own.items()})
        draft.child(joint, title + 'dynamics', f'<dynamics {words}/>')
    if 'effort' in values and limit is not None:
        draft.attributes(limit, title + 'limit', {'effort': values['effort']})
    elif 'effort' in values:
        return [Exported(actuator.SATURATION.id, REFUSED, 'no <limit> in the joint, which needs a '
                         f'velocity: add one with effort="{number(values["effort"])}"')]
    return []


def _inertial(draft: _Draft, element: XmlElement, joint: str, model: DriveModel, urdf: str
              ) -> list[Exported]:
    """
    Change the link that a joint moves until inertia and weight at posture 0 are the model's.

    Args:
        draft: gets the edits.
        element: of the joint.
        joint: its name.
        model: of the drive.
        urdf: text of the robot as URDF.

    Returns:
        The rows for the list.

    Raises:
        InputError: the link has no inertial, or less than is to be taken from it.
    """
    robot = parse(urdf, draft.document.name)
    if joint not in robot.joints:
        raise InputError(f'joint {joint}: fixed or a mimic, expected one that moves by itself')
    root = ElementTree.fromstring(urdf)
    moved = next(e for e in root.findall('joint') if e.get('name') == joint)
    link = moved.find('child').get('link', '')  # type: ignore[union-attr]
    slide = moved.get('type') == 'prismatic'
    unit = 'kg' if slide else 'kg m^2'
    rows = [Exported(motor_side.MOTOR_INERTIA.id, CONSTRUCT,
                     f'in the inertia of link {link}, as there is no armature: the joint moves '
                     f'{_inertia_of(model):.6g} {unit} in the posture 0')]
    weight, change = _Weight(robot, joint, link), _inertia_of(model) - _load(robot, joint)[1]
    heavier = 0j
    if any(e['id'] == arm_side.GRAVITY.id for e in model.effects):
        heavier = cmath.rect(*weight_of(model.effects)) - weight.present
        rows.append(Exported(arm_side.GRAVITY.id, NATIVE, f'mass and centre of link {link}: the '
                             'weight on the joint at 9.81 m/s^2, the other joints at 0'))
    if abs(heavier) <= SAME * max(abs(weight.present), abs(weight.present + heavier)):
        heavier = 0j
    if abs(change) <= SAME * _inertia_of(model) and not heavier:
        return rows
    inertial = next(e for e in root.findall('link') if e.get('name') == link).find('inertial')
    own = child_of(_link(draft.document, element, link), 'inertial')
    if inertial is None or own is None:
        raise InputError(f'link {link}: no <inertial>, expected one that {change:+.6g} {unit} can '
                         'be added to')
    # In the frame of the inertial.
    mass, centre, frame, tensor = inertial_in(inertial)
    direction = moved.find('axis')
    axis = np.array((direction.get('xyz', '1 0 0') if direction is not None else '1 0 0').split(),
                    float)
    axis = frame.T @ axis / np.linalg.norm(axis)
    moved_by: Array = np.zeros(3)
    if slide:
        if mass <= 0.0 or mass + change < LEAST * mass:
            raise InputError(f'link {link}: {mass:.6g} kg itself, a change of {change:+.6g}, '
                             'expected a sum above 0')
        mass, tensor = mass + change, tensor * (1.0 + change / mass)
    else:
        lever = across(frame.T @ centre, axis)
        inertia = float(axis @ tensor @ axis)
        target = inertia + mass * float(lever @ lever) + change
        if inertia <= 0.0 or mass <= 0.0 or target < LEAST * inertia or (
                not heavier and inertia + change < LEAST * inertia):
            raise InputError(f'link {link}: {inertia:.6g} {unit} itself, a change of {change:+.6g}'
                             ', expected a sum above 0')
        moment = mass * lever + frame.T @ weight.moment(heavier) if heavier else None
        mass, moved_by, tensor = balanced((mass, lever, tensor), axis, target, moment)
    title = f'link "{link}" '
    if moved_by.any():
        _move_centre(draft, own, title, moved_by)
    values = {k: float(tensor['xyz'.index(k[1]), 'xyz'.index(k[2])]) for k in TENSOR}
    draft.attributes(own.all('mass')[0], title + 'mass', {'value': mass})
    draft.attributes(own.all('inertia')[0], title + 'inertia', values)
    return rows


def _load(robot: RobotDescription, joint: str, angle: float = 0.0,
          payload: Payload = NO_PAYLOAD) -> tuple[float, float]:
    """Return weight (N m) and inertia (kg m^2) on a joint at `angle` (rad), the others at 0."""
    arrays, place = arrays_of(robot, payload, gravity=SIMULATED_GRAVITY), robot.joints.index(joint)
    motion = np.zeros((3, len(robot.joints)))
    motion[0, place] = angle
    move(arrays, motion)
    torque, _, inertia = torque_on(arrays, place)
    return torque, inertia


class _Weight:
    """The weight G sin(x2 + phi) on a joint, as the phasor G e^(j phi), and moments for more."""

    def __init__(self, robot: RobotDescription, joint: str, link: str) -> None:
        self._robot, self._joint, self._link = robot, joint, link
        self.present = self._of(NO_PAYLOAD)

    def _of(self, payload: Payload) -> complex:
        return complex(*(_load(self._robot, self._joint, angle, payload)[0]
                         for angle in (0.5 * np.pi, 0.0)))

    def moment(self, added: complex) -> Array:
        """Return the mass times lever [3] (kg m, link's frame) that adds the weight `added`."""
        parts = [self._of(Payload(1.0, 0.0, tuple(axis), self._link)) - self.present
                 for axis in np.eye(3)]
        columns = np.array([np.real(parts), np.imag(parts)])
        if np.abs(columns).max() < 1e-6:
            raise InputError(f'joint {self._joint}: gravity acts along its axis, expected one '
                             'that the weight of the model can come from')
        solution: Array = np.linalg.lstsq(columns, [added.real, added.imag], None)[0]
        return solution


def _move_centre(draft: _Draft, inertial: XmlElement, title: str, by: Array) -> None:
    """Move the centre of mass of an `inertial` by [3] m in its own frame."""
    place = child_of(inertial, 'origin')
    words, angles = ['0'] * 3, np.zeros(3)
    if place is not None:
        words = place.attributes.get('xyz', '0 0 0').split()
        angles = np.array(place.attributes.get('rpy', '0 0 0').split(), float)
    moved = np.array(words, float) + turn(*angles) @ by
    moved[np.abs(moved) < SAME * np.abs(moved).max()] = 0.0
    centre = number(*moved)
    draft.changes.append(Splice(title + 'origin', '', ' '.join(words), centre))
    draft.edits += ([with_child(draft.document, inertial, f'<origin xyz="{centre}"/>')]
                    if place is None else
                    with_attributes(draft.document, place, {'xyz': centre}))


def _link(document: XmlDocument, joint: XmlElement, name: str) -> XmlElement:
    """Return the link `name` beside a joint."""
    around = document.parent(joint)
    return next(e for e in around.all('link') if e.attributes.get('name') == name)
