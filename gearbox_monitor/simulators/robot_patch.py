# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write the findings on a whole robot into its MJCF or URDF file.

Each effect has one place: an attribute of a joint, the inertia of a link, gravity. What has none
is left out, with the reason.
"""
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import with_effects
from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, INERTIA_NAMES, LINK_INERTIA, PAYLOAD, tilted)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.files.yaml_files import model_text
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS
from gearbox_monitor.robot.chain import inertial
from gearbox_monitor.robot.compiled_model import actuators_on, disabled
from gearbox_monitor.simulators.file_edits import (
    FileEdits, in_frame, mjcf_element, number, Patch, write_mjcf, write_urdf)
from gearbox_monitor.simulators.mjcf import EXPRESSIONS, REFUSED
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.mjcf_patch import servo_gains
from gearbox_monitor.simulators.robot_model import ChainFile
from gearbox_monitor.simulators.xml_edit import parse_xml, XmlDocument

POINT = np.zeros((3, 3))  # inertia of a point about itself
TWO = 2.0  # deviations within which a sum below 0 is 0


class JointPlace(NamedTuple):
    """
    Where an effect of a joint stands in a file.

    value: of the finding, a change; field: of the Chain; attribute: of an MJCF joint; flags: of
    MuJoCo's options that switch it off.
    """

    value: str
    field: str
    attribute: str
    flags: tuple[str, ...]


# All other effects of joints have no attribute of their own, in either format.
OF_JOINT = {
    MOTOR_COULOMB.id: JointPlace('Cc_change', 'coulomb', 'frictionloss',
                                 ('FRICTIONLOSS', 'CONSTRAINT')),
    MOTOR_VISCOUS.id: JointPlace('Cv_change', 'viscous', 'damping', ('DAMPER',)),
    MOTOR_INERTIA.id: JointPlace('m1_change', 'armature', 'armature', ())}
OF_LINK: dict[str, Callable[[Mapping[str, float]], Array]] = {
    PAYLOAD.id: lambda v: inertial(v['m'], np.array([v['cx'], v['cy'], v['cz']]), POINT),
    LINK_INERTIA.id: lambda v: np.array([*np.zeros(4), *(v[name] for name in INERTIA_NAMES)])}

NEEDED = {**{name: (place.value,) for name, place in OF_JOINT.items()},
          **{e.id: tuple(e.units) for e in (PAYLOAD, LINK_INERTIA, BASE_TILT)},
          SERVO_GAIN.id: ('kp_factor',)}


def finding_title(effect: str, place: str) -> str:
    """Return what a finding is called: its `effect` and the joint or link that is its `place`."""
    return f'{effect} of {place}'


def title_of(finding: Mapping[str, Any]) -> str:
    """Return the title of a `finding` as plain data."""
    return finding_title(finding['effect'], finding.get('joint') or finding.get('link') or BASE)


def closed_file(file: ChainFile, findings: Sequence[Mapping[str, Any]], author: str
                ) -> tuple[str | None, dict[str, str]]:
    """
    Return the text of the file with the findings.

    Args:
        file: of the robot.
        findings: as plain data; those with `confirmed` false are left out.
        author: who writes it, for a comment.

    Returns:
        The text, None if nothing of them can stand in it, and {title of what cannot: reason}.
    """
    if file.drive is not None:
        return _closed_drive(file.drive, findings, author)
    document, omitted = parse_xml(read_file(file.path), str(file.path)), dict[str, str]()
    edits, patch = FileEdits(), Patch(document.data, ())
    for finding in findings:
        name = title_of(finding)
        try:
            if finding.get('confirmed', True) is False:
                raise InputError('free runs are farther off with it than without')
            further = edits | _edits(file, document, finding, edits)
            patch = (write_urdf(document, further, author) if file.compiled is None else
                     write_mjcf(document, file.compiled, further, author))
            edits = further
        except InputError as error:
            omitted[name] = str(error)
        if 'Ca' in finding['values']:
            omitted[f'{name}: its difference by direction'] = 'no attribute has it'
    try:
        return patch.data.decode('utf-8') if patch.changes else None, omitted
    except UnicodeDecodeError:
        return None, {**omitted, str(file.path): 'not UTF-8, expected it for a file to be written'}


def _closed_drive(drive: DriveModel, findings: Sequence[Mapping[str, Any]], author: str
                  ) -> tuple[str | None, dict[str, str]]:
    """Return the same as closed_file, for a `drive`."""
    effects, omitted = list[Values](), dict[str, str]()
    for finding in findings:
        effect, values = EFFECTS.get(finding['effect']), finding['values']
        parameters = effect.parameters if effect is not None else ()
        held = drive.value(effect.replaces) if effect is not None and effect.replaces else 0.0
        own = {p.name: values[p.name] if p.name in values else
               held + values[f'{p.name}_change'] if f'{p.name}_change' in values else
               held * values[f'{p.name}_factor'] for p in parameters
               if {p.name, f'{p.name}_change', f'{p.name}_factor'} & set(values)}
        if own and len(own) == len(parameters):
            effects.append({'id': finding['effect'], **own})
        else:
            omitted[title_of(finding)] = 'a drive has no such effect'
    if not effects:
        return None, omitted
    return model_text(with_effects(drive, effects), [f'Written by {author}.']), omitted


def _edits(file: ChainFile, document: XmlDocument, finding: Mapping[str, Any], before: FileEdits
           ) -> FileEdits:
    """Return the edits for a finding after those `before`. Raises InputError without a place."""
    effect, values, chain = finding['effect'], finding['values'], file.chain
    kind = 'joint' if finding.get('joint') else 'link'
    names = chain.joints if kind == 'joint' else [BASE, *(link.name for link in chain.links)]
    if finding.get(kind) not in names:
        raise InputError(f'{kind}: {finding.get(kind)!r} is not in {file.path}, '
                         + unknown(finding.get(kind), names))
    lacking = [name for name in NEEDED.get(effect, ()) if name not in values]
    if lacking or (effect in (*OF_JOINT, SERVO_GAIN.id)) > (kind == 'joint'):
        raise InputError(f'no {", ".join(lacking) or "joint"}, expected it in the finding')
    if effect in OF_JOINT:
        return _of_joint(file, OF_JOINT[effect], finding, before)
    if effect in OF_LINK:
        return _of_link(file, finding['link'], OF_LINK[effect](values))
    if effect == SERVO_GAIN.id:
        return _of_servo(file, document, finding['joint'], values['kp_factor'])
    if effect == BASE_TILT.id:
        return FileEdits(gravity=tilted(chain.gravity, values['ax'], values['ay']))
    row = EXPRESSIONS.get(effect)
    raise InputError(row.words if row is not None and row.kind == REFUSED
                     else 'no attribute of a joint or body has it')


def _of_joint(file: ChainFile, place: JointPlace, finding: Mapping[str, Any], before: FileEdits
              ) -> FileEdits:
    """Add a finding to the attribute at its `place`. Raises InputError."""
    attribute, m = place.attribute, file.compiled
    joint = file.chain.joints.index(finding['joint'])
    nominal = float((getattr(file.chain, place.field) if m is None
                     else getattr(m, f'dof_{attribute}'))[joint])
    if m is not None and place.flags and disabled(m, *place.flags):
        raise InputError(f'{attribute}: a flag of <option> switches it off')
    key = ('joint', finding['joint'] if m is None else joint)
    nominal = float(before.attributes.get(key, {}).get(attribute) or nominal)
    change = finding['values'][place.value]
    unsure = finding['deviations'][place.value] or 0.0
    changed = nominal + change
    if changed < -TWO * unsure - 1e-9 * nominal:
        raise InputError(f'{attribute} {nominal:.3g} in the file, {change:+.3g}, expected '
                         'a sum of 0 or more')
    return FileEdits({key: {attribute: number(max(changed, 0.0))}})


def _of_link(file: ChainFile, link: str, theta: Array) -> FileEdits:
    """Add `theta` [10], in the frame of its joint, to what a `link` has in the file."""
    m = file.compiled
    if m is None or link == BASE:
        return FileEdits(bodies={link: theta})
    # A body with several joints is several links of one name, of which the last has the mass.
    joint = max(i for i, of in enumerate(file.chain.links) if of.name == link)
    return FileEdits(bodies={int(m.jnt_bodyid[joint]): in_frame(theta, m.jnt_pos[joint])})


def _of_servo(file: ChainFile, document: XmlDocument, joint: str, factor: float) -> FileEdits:
    """Multiply kp of the servo of a `joint` by `factor`. Raises InputError."""
    m = file.compiled
    if m is None:
        raise InputError('a URDF has no actuators')
    if not factor > 0.0:
        raise InputError(f'kp_factor: {factor:g}, expected more than 0')
    servos = list(actuators_on(m, file.chain.joints.index(joint)))
    gains = [servo_gains(mjcf_element(document, m, 'actuator', i).tag, factor * m.actuator_gainprm[
        i, 0], m.actuator_biasprm[i, :3] * [1.0, factor, 1.0]) for i in servos]
    if len(gains) != 1 or not gains[0]:
        raise InputError('kp: expected one actuator <position> of the joint')
    return FileEdits({('actuator', servos[0]): gains[0]})
