# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a drive into a URDF file: friction and effort limit of its joint, inertia of its link.

A URDF has no rotors, no transmissions and no actuators: what it has no parameter for is listed.
"""
from dataclasses import replace
import math
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side
from gearbox_monitor.simulators.file_edits import FileEdits, number, Patch, write_urdf
from gearbox_monitor.simulators.mjcf import CONSTRUCT, Exported, NATIVE, REFUSED, values_of
from gearbox_monitor.simulators.mjcf_file import drive_of, weight
from gearbox_monitor.simulators.mjcf_patch import inertial_edits, verify
from gearbox_monitor.simulators.xml_edit import parse_xml

ROOT = 'robot'
LINK_INERTIA = 'inertia of the link that the joint moves'
# What an effect becomes in a URDF file.
EXPRESSED = {
    motor_side.MOTOR_INERTIA.id: LINK_INERTIA, arm_side.ARM_INERTIA.id: LINK_INERTIA,
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
        InputError: another format, no such joint, or a file that MuJoCo does not read.
    """
    document = parse_xml(data, str(path))
    if document.root.tag != ROOT:
        raise InputError(f'{path}: line {document.root.line}: <{document.root.tag}>, expected '
                         f'<{ROOT}> with --to urdf')
    drive, exported, folded = drive_of(data, path, (joint, None)), _not_in_urdf(model), \
        model.folded()
    values = replace(values_of(model)[0], rigid=True, motor_friction=folded.coulomb_friction)
    wanted: dict[str, str | None] = {
        'damping': number(values.motor_damping + values.arm_damping),
        'frictionloss': number(values.motor_friction + values.arm_friction)}
    if math.isfinite(values.limit):
        wanted['effort'] = number(values.limit)
        if not any(e.attributes.get('name') == joint and e.all('limit')
                   for e in document.root.all('joint')):
            exported.append(Exported(
                actuator.SATURATION.id, REFUSED, 'no <limit> in the joint, which needs a '
                f'velocity: add one with effort="{wanted.pop("effort")}"'))
    edits = FileEdits({('joint', joint): wanted})
    moved = (f'the joint moves {values.motor_inertia + values.arm_inertia:.6g} '
             f'{"kg" if drive.motor.slide else "kg m^2"}')
    try:
        bodies = {drive.compiled.body(int(body)).name: added
                  for body, added in inertial_edits(drive, values).bodies.items()}
        patch = write_urdf(document, edits | FileEdits(bodies=bodies))
        verify(replace(patch, joints=(joint, None)), drive, replace(
            values, weight=weight(drive) if values.weight is None else values.weight))
        exported.append(Exported(motor_side.MOTOR_INERTIA.id, CONSTRUCT, (
            f'in the inertia of its link, as there is no armature: {moved} in the posture 0')))
        if values.weight is not None:
            exported.append(Exported(arm_side.GRAVITY.id, NATIVE, 'mass and centre of its link: '
                                     'the weight at 9.81 m/s^2, the other joints at 0'))
    except InputError as error:
        patch = write_urdf(document, edits)
        exported.append(Exported('inertia', REFUSED, f'{error}; {moved} in the model'))
    return replace(patch, exported=tuple(exported), joints=(joint, None))
