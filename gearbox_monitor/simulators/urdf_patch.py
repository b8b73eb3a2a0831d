# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a drive into a URDF file: friction and effort limit of its joint, inertia of its link.

A URDF has no rotors, no transmissions and no actuators: what it has no parameter for is listed.
"""
import cmath
from pathlib import Path

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side
from gearbox_monitor.robot.description import parse, RobotDescription
from gearbox_monitor.robot.dynamics import arrays_of, move, NO_PAYLOAD, Payload, torque_on
from gearbox_monitor.simulators.file_edits import (
    about_axis, across, balanced, Body, number, SAME, UrdfEdits)
from gearbox_monitor.simulators.mjcf import CONSTRUCT, Exported, NATIVE, REFUSED
from gearbox_monitor.simulators.mjcf_patch import Patch
from gearbox_monitor.simulators.xml_edit import parse_xml

SIMULATED_GRAVITY = (0.0, 0.0, -9.81)  # m/s^2: default of MuJoCo, Isaac and Bullet
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


def patched_urdf(data: bytes, path: Path, joint: str, model: DriveModel) -> Patch:
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
    edits = UrdfEdits(document)
    values, exported = _values_of(model), list(_not_in_urdf(model))
    if 'effort' in values and not edits.named('joint', joint).all('limit'):
        effort = number(values.pop('effort'))
        exported.append(Exported(actuator.SATURATION.id, REFUSED, 'no <limit> in the joint, which '
                                 f'needs a velocity: add one with effort="{effort}"'))
    edits.put_joint(joint, values)
    try:
        exported += _inertial(edits, joint, model)
    except InputError as error:
        exported.append(Exported('inertia', REFUSED, f'{error}; the joint moves '
                                 f'{_inertia_of(model):.6g} in the model'))
    patch = Patch(edits.patched(), tuple(edits.changes), tuple(exported), (joint, None))
    parse_xml(patch.data, str(path))
    return patch


def _inertia_of(model: DriveModel) -> float:
    folded = model.folded()
    return folded.motor_inertia + folded.arm_inertia


def _inertial(edits: UrdfEdits, joint: str, model: DriveModel) -> list[Exported]:
    """Change the link of a joint until inertia and weight at posture 0 are the model's."""
    document = edits.document
    robot = parse(document.data.decode('utf-8'), document.name)
    if joint not in robot.joints:
        raise InputError(f'joint {joint}: fixed or a mimic, expected one that moves by itself')
    element = edits.named('joint', joint)
    link = element.all('child')[0].attributes['link']
    slide = element.attributes.get('type') == 'prismatic'
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
    own = edits.own(link)
    if own is None:
        raise InputError(f'link {link}: no <inertial>, expected one that {change:+.6g} {unit} can '
                         'be added to')
    if slide:
        if own.mass <= 0.0 or own.mass + change < LEAST * own.mass:
            raise InputError(f'link {link}: {own.mass:.6g} kg itself, a change of {change:+.6g}, '
                             'expected a sum above 0')
        edits.put_body(link, Body(own.mass + change, own.centre,
                                  own.tensor * (1.0 + change / own.mass)))
        return rows
    direction = [e.attributes.get('xyz', '1 0 0') for e in element.all('axis')] or ['1 0 0']
    axis = np.array(direction[0].split(), float)
    axis, anchor = axis / np.linalg.norm(axis), np.zeros(3)
    inertia = float(axis @ own.tensor @ axis)
    target = about_axis(own, axis, anchor) + change
    if inertia <= 0.0 or own.mass <= 0.0 or target < LEAST * inertia or (
            not heavier and inertia + change < LEAST * inertia):
        raise InputError(f'link {link}: {inertia:.6g} {unit} itself, a change of {change:+.6g}, '
                         'expected a sum above 0')
    moment = own.mass * across(own.centre, axis) + weight.moment(heavier) if heavier else None
    edits.put_body(link, balanced(own, axis, anchor, target, moment))
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
