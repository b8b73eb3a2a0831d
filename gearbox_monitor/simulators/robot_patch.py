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

from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, INERTIA_NAMES, LINK_INERTIA, PAYLOAD, tilted)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS
from gearbox_monitor.robot.chain import inertial, PER_LINK
from gearbox_monitor.robot.compiled_model import actuators_on, disabled
from gearbox_monitor.simulators.file_edits import (
    compiled_body, in_frame, MjcfEdits, number, UrdfEdits, with_added)
from gearbox_monitor.simulators.mjcf import EXPRESSIONS, REFUSED
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.robot_model import ChainFile
from gearbox_monitor.simulators.xml_edit import parse_xml

POINT = np.zeros((3, 3))  # inertia of a point about itself
TWO = 2.0  # deviations within which a sum below 0 is 0


class JointPlace(NamedTuple):
    """
    Where an effect of a joint stands in a file.

    value: of the finding, a change; field: of the Chain; mjcf: attribute of a joint; flags: of
    MuJoCo's options that switch it off; urdf: attribute of <dynamics>, '' for none.
    """

    value: str
    field: str
    mjcf: str
    flags: tuple[str, ...]
    urdf: str


# All other effects of joints have no attribute of their own, in either format.
OF_JOINT = {
    MOTOR_COULOMB.id: JointPlace('Cc_change', 'coulomb', 'frictionloss',
                                 ('FRICTIONLOSS', 'CONSTRAINT'), 'friction'),
    MOTOR_VISCOUS.id: JointPlace('Cv_change', 'viscous', 'damping', ('DAMPER',), 'damping'),
    MOTOR_INERTIA.id: JointPlace('m1_change', 'armature', 'armature', (), '')}
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
    closing = _Closing(file)
    omitted: dict[str, str] = {}
    for finding in findings:
        name = title_of(finding)
        try:
            if finding.get('confirmed', True) is False:
                raise InputError('free runs are farther off with it than without')
            closing.take(finding)
        except InputError as error:
            omitted[name] = str(error)
        if 'Ca' in finding['values']:
            omitted[f'{name}: its difference by direction'] = 'no attribute has it'
    if not closing.edits.changes:
        return None, omitted
    try:
        return closing.edits.patched(author).decode('utf-8'), omitted
    except UnicodeDecodeError:
        return None, {**omitted, str(file.path): 'not UTF-8, expected it for a file to be written'}


class _Closing:
    """The edits of a file for findings: those of one attribute or body add up."""

    def __init__(self, file: ChainFile) -> None:
        document = parse_xml(read_file(file.path), str(file.path))
        self.edits: MjcfEdits | UrdfEdits = (
            UrdfEdits(document) if document.root.tag == 'robot'
            else MjcfEdits(document, file.compiled))
        self._file = file
        self._joints: dict[tuple[int, str], float] = {}
        self._links: dict[str, Array] = {}

    def take(self, finding: Mapping[str, Any]) -> None:
        """Write a finding. Raises InputError, and changes nothing, if the file has no place."""
        effect, values, chain = finding['effect'], finding['values'], self._file.chain
        kind = 'joint' if finding.get('joint') else 'link'
        names = chain.joints if kind == 'joint' else [BASE, *(link.name for link in chain.links)]
        if finding.get(kind) not in names:
            raise InputError(f'{kind}: {finding.get(kind)!r} is not in {self._file.path}, '
                             + unknown(finding.get(kind), names))
        lacking = [name for name in NEEDED.get(effect, ()) if name not in values]
        if lacking or (effect in (*OF_JOINT, SERVO_GAIN.id)) > (kind == 'joint'):
            raise InputError(f'no {", ".join(lacking) or "joint"}, expected it in the finding')
        if effect in OF_JOINT:
            self._joint(chain.joints.index(finding['joint']), OF_JOINT[effect], finding)
        elif effect in OF_LINK:
            theta = OF_LINK[effect](values) + self._links.get(finding['link'], np.zeros(PER_LINK))
            self._inertial(finding['link'], theta)
            self._links[finding['link']] = theta
        elif effect == SERVO_GAIN.id:
            self._gain(chain.joints.index(finding['joint']), values['kp_factor'])
        elif effect == BASE_TILT.id:
            if isinstance(self.edits, UrdfEdits):
                raise InputError('a URDF has no gravity')
            self.edits.put_gravity(tilted(chain.gravity, values['ax'], values['ay']))
        else:
            row = EXPRESSIONS.get(effect)
            raise InputError(row.words if row is not None and row.kind == REFUSED
                             else 'no attribute of a joint or body has it')

    def _joint(self, joint: int, place: JointPlace, finding: Mapping[str, Any]) -> None:
        """Add a finding to the attribute at its `place` of a `joint`. Raises InputError."""
        edits, chain, m = self.edits, self._file.chain, self._file.compiled
        if isinstance(edits, UrdfEdits):
            attribute, nominal = place.urdf, float(getattr(chain, place.field)[joint])
            if not attribute:
                raise InputError('a URDF has no rotors')
        else:
            attribute, nominal = place.mjcf, float(getattr(m, f'dof_{place.mjcf}')[joint])
            edits.joint(joint)
            if place.flags and disabled(m, *place.flags):
                raise InputError(f'{attribute}: a flag of <option> switches it off')
        change = finding['values'][place.value]
        unsure = finding['deviations'][place.value] or 0.0
        changed = self._joints.get((joint, attribute), nominal) + change
        if changed < -TWO * unsure - 1e-9 * nominal:
            raise InputError(f'{attribute} {nominal:.3g} in the file, {change:+.3g}, expected '
                             'a sum of 0 or more')
        self._joints[joint, attribute] = max(changed, 0.0)
        written = {attribute: max(changed, 0.0)}
        if isinstance(edits, UrdfEdits):
            edits.put_joint(chain.joints[joint], written)
        else:
            edits.put_joint(joint, written)

    def _gain(self, joint: int, factor: float) -> None:
        """Multiply kp of the servo of a `joint` by `factor`. Raises InputError."""
        edits, m = self.edits, self._file.compiled
        if isinstance(edits, UrdfEdits):
            raise InputError('a URDF has no actuators')
        servos = [(i, edits.listed('actuator', i)) for i in actuators_on(m, joint)]
        if not factor > 0.0:
            raise InputError(f'kp_factor: {factor:g}, expected more than 0')
        if [element.tag for _, element in servos] != ['position']:
            raise InputError('kp: expected one actuator <position> of the joint')
        (i, element), = servos
        edits.put(element, {'kp': number(factor * m.actuator_gainprm[i, 0]),
                            'kv': number(-m.actuator_biasprm[i, 2]), 'dampratio': None})

    def _inertial(self, link: str, theta: Array) -> None:
        """Add `theta` [10], in the frame of its joint, to what a `link` has in the file."""
        edits, m, path = self.edits, self._file.compiled, self._file.path
        if isinstance(edits, UrdfEdits):
            edits.put_body(link, with_added(edits.own(link), theta, f'{path}: link {link}'))
            return
        # A body with several joints is several links of one name, of which the last has the mass.
        joint = max(i for i, of in enumerate(self._file.chain.links) if of.name == link)
        body = int(m.jnt_bodyid[joint])
        edits.put_body(body, with_added(compiled_body(m, body), in_frame(
            theta, m.jnt_pos[joint]), f'{path}: body {link}'))
