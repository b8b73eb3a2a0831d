# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Inertia of a robot's body with something added: one that a body can have."""
import cmath
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, INERTIA_NAMES, LINK_INERTIA, PAYLOAD, tilted)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel, weight_of
from gearbox_monitor.plant.effects import actuator, arm_side, Effect, EFFECTS, motor_side
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS
from gearbox_monitor.robot.chain import body_of, inertial, PER_LINK
from gearbox_monitor.robot.compiled_model import disabled, mujoco_module
from gearbox_monitor.robot.description import parse, RobotDescription, turn
from gearbox_monitor.robot.dynamics import arrays_of, move, NO_PAYLOAD, Payload, torque_on
from gearbox_monitor.simulators.mjcf import CONSTRUCT, Exported, EXPRESSIONS, NATIVE, REFUSED
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.mjcf_patch import (
    across, balanced, inertial_attributes, number, Patch, Splice)
from gearbox_monitor.simulators.robot_model import ChainFile
from gearbox_monitor.simulators.xml_edit import (
    Edit, edited, inertial_in, parse_xml, TENSOR, with_attributes, with_child, with_element,
    words_of, XmlDocument, XmlElement)

LEAST_INERTIA = 1e-9    # kg m^2, of a principal inertia
BEYOND = 0.2    # of the largest principal inertia: what may be added to make a body possible


def possible(own: Array, added: Array, where: str) -> tuple[float, Array, Array]:
    """
    Return the body that has the sum of two sets of inertial parameters.

    A mass that is taken away is no point: what remains is filled up to a body's inertia, which is
    above 0 and where no principal inertia exceeds the sum of the others.

    Args:
        own: [10] of the body.
        added: [10], in the same frame.
        where: of the body, for messages.

    Returns:
        Mass kg, centre [3] m, inertia about it [3, 3] kg m^2.

    Raises:
        InputError: no mass remains, or no inertia that a body can have.
    """
    theta = own + added
    if not theta[0] > 0.0:
        raise InputError(f'{where}: mass {theta[0]:.3g} kg with the finding, expected more than 0')
    mass, centre, tensor = body_of(theta)
    smallest, middle, largest = np.linalg.eigvalsh(tensor)
    deficit = max(LEAST_INERTIA - smallest, (1.0 + 1e-6) * (largest - middle - smallest), 0.0)
    if deficit > LEAST_INERTIA and deficit > BEYOND * max(largest, LEAST_INERTIA) and not added[0]:
        raise InputError(f'{where}: no body has such an inertia (principal ones {smallest:.3g}, '
                         f'{middle:.3g}, {largest:.3g} kg m^2)')
    return mass, centre, tensor + deficit * np.eye(3)


def body_with(file: ChainFile, link: str, added: Array) -> tuple[int, tuple[float, Array, Array]]:
    """
    Return the body of a link in a compiled model with something added.

    Args:
        file: of the robot, an MJCF.
        link: its name.
        added: inertial parameters [10], in the frame of the joint that moves the link.

    Returns:
        Number of the body; its mass kg, centre [3] m and inertia about it [3, 3] kg m^2, in the
        body's frame.

    Raises:
        InputError: see possible.
    """
    m: Any = file.compiled
    # A body with several joints is several links of one name, of which the last has the mass.
    joint = max(i for i, of in enumerate(file.chain.links) if of.name == link)
    body = int(m.jnt_bodyid[joint])
    frame = np.zeros(9)
    mujoco_module().mju_quat2Mat(frame, m.body_iquat[body])
    axes = frame.reshape(3, 3)
    own = inertial(float(m.body_mass[body]), m.body_ipos[body].copy(),
                   axes @ np.diag(m.body_inertia[body]) @ axes.T)
    return body, possible(own, moved(added, m.jnt_pos[joint]), f'{file.path}: body {link}')


def moved(theta: Array, by: Array) -> Array:
    """Return inertial parameters `theta` [10] in a frame whose origin lies at -`by` [3] m."""
    mass, first = float(theta[0]), theta[1:4]
    out = theta.copy()
    out[1:4] += mass * by
    # About the new origin: I + 2 (first . by) 1 - first by' - by first' + m (by . by 1 - by by').
    shift = ((2.0 * first @ by + mass * by @ by) * np.eye(3) - np.outer(first, by)
             - np.outer(by, first) - mass * np.outer(by, by))
    out[4:] += *np.diag(shift), shift[0, 1], shift[0, 2], shift[1, 2]
    return out


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
          **{e.id: tuple(e.units) for e in (PAYLOAD, LINK_INERTIA, BASE_TILT)}}


def finding_title(effect: str, place: str) -> str:
    """Return what a finding is called: its `effect` and the joint or link that is its `place`."""
    return f'{effect} of {place}'


def title_of(finding: Mapping[str, Any]) -> str:
    """Return the title of a `finding` as plain data."""
    return finding_title(finding['effect'], finding.get('joint') or finding.get('link') or BASE)


def closed_file(file: ChainFile, findings: Sequence[Mapping[str, Any]], author: str
                ) -> tuple[str | None, list[str]]:
    """
    Return the text of the file with the findings.

    Args:
        file: of the robot.
        findings: as plain data; those with `confirmed` false are left out.
        author: who writes it, for a comment.

    Returns:
        The text, None if nothing of them can stand in it, and what cannot, with the reason.
    """
    document = parse_xml(read_file(file.path), str(file.path))
    draft = (_UrdfDraft if document.root.tag == 'robot' else _MjcfDraft)(document, file)
    omitted: list[str] = []
    for finding in findings:
        name = title_of(finding)
        try:
            if finding.get('confirmed', True) is False:
                raise InputError('free runs are farther off with it than without')
            draft.take(finding)
        except InputError as error:
            omitted.append(f'{name}: {error}')
        if 'Ca' in finding['values']:
            omitted.append(f'{name}: its difference by direction: no attribute has it')
    edits = draft.edits()
    if not edits:
        return None, omitted
    start = document.root.start
    try:
        return edited(document, [Edit(start, start, f'<!-- {author} -->\n'), *edits]
                      ).decode('utf-8'), omitted
    except UnicodeDecodeError:
        return None, [*omitted, f'{file.path}: is not UTF-8, expected it for a file to be written']


class _ClosedDraft:
    """What findings change in a file: attributes of joints, inertial parameters of links."""

    def __init__(self, document: XmlDocument, file: ChainFile) -> None:
        self._document, self._file = document, file
        self._joints: dict[int, dict[str, float]] = {}
        self._links: dict[str, Array] = {}
        self._tilt: Mapping[str, float] | None = None

    def take(self, finding: Mapping[str, Any]) -> None:
        """Add a finding. Raises InputError, and changes nothing, if the file has no place."""
        effect, values, chain = finding['effect'], finding['values'], self._file.chain
        kind = 'joint' if finding.get('joint') else 'link'
        names = chain.joints if kind == 'joint' else [BASE, *(link.name for link in chain.links)]
        if finding.get(kind) not in names:
            raise InputError(f'{kind}: {finding.get(kind)!r} is not in {self._document.name}, '
                             + unknown(finding.get(kind), names))
        lacking = [name for name in NEEDED.get(effect, ()) if name not in values]
        if lacking or (effect in OF_JOINT) > (kind == 'joint'):
            raise InputError(f'no {", ".join(lacking) or "joint"}, expected it in the finding')
        if effect in OF_JOINT:
            place = OF_JOINT[effect]
            joint = chain.joints.index(finding['joint'])
            attribute, nominal = self._attribute(joint, place)
            own = self._joints.get(joint, {})
            change, unsure = values[place.value], finding['deviations'][place.value] or 0.0
            changed = own.get(attribute, nominal) + change
            if changed < -TWO * unsure - 1e-9 * nominal:
                raise InputError(f'{attribute} {nominal:.3g} in the file, {change:+.3g}, expected '
                                 'a sum of 0 or more')
            self._joints[joint] = {**own, attribute: max(changed, 0.0)}
        elif effect in OF_LINK:
            theta = OF_LINK[effect](values) + self._links.get(finding['link'], np.zeros(PER_LINK))
            self._inertial(finding['link'], theta)
            self._links[finding['link']] = theta
        elif effect == BASE_TILT.id:
            self._gravity()
            self._tilt = values
        else:
            row = EXPRESSIONS.get(effect)
            raise InputError(row.words if row is not None and row.kind == REFUSED
                             else 'no attribute of a joint or body has it')

    def edits(self) -> list[Edit]:
        """Return the edits of the file."""
        out = [edit for joint, values in self._joints.items()
               for edit in self._of_joint(joint, {k: number(v) for k, v in values.items()})]
        for link, theta in self._links.items():
            out += self._inertial(link, theta)
        return [*out, *(self._of_tilt(self._tilt) if self._tilt is not None else ())]

    def _attribute(self, joint: int, place: JointPlace) -> tuple[str, float]:
        """Return the attribute at `place` of a `joint`, and its value. Raises InputError."""
        raise NotImplementedError

    def _of_joint(self, joint: int, values: dict[str, str]) -> list[Edit]:
        """Return the edits that give a `joint` the attributes `values`."""
        raise NotImplementedError

    def _inertial(self, link: str, theta: Array) -> list[Edit]:
        """Return the edits that add `theta` [10], in the frame of the joint, to a `link`."""
        raise NotImplementedError

    def _gravity(self) -> None:
        """Raise InputError if gravity has no place in the file."""

    def _of_tilt(self, values: Mapping[str, float]) -> list[Edit]:
        """Return the edits that turn gravity by the `values` of a tilt."""
        raise NotImplementedError


class _MjcfDraft(_ClosedDraft):
    def _attribute(self, joint: int, place: JointPlace) -> tuple[str, float]:
        m = self._file.compiled
        self._joint(joint)
        if place.flags and disabled(m, *place.flags):
            raise InputError(f'{place.mjcf}: a flag of <option> switches it off')
        return place.mjcf, float(getattr(m, f'dof_{place.mjcf}')[joint])

    def _of_joint(self, joint: int, values: dict[str, str]) -> list[Edit]:
        return with_attributes(self._document, self._joint(joint), dict(values))

    def _joint(self, joint: int) -> XmlElement:
        m, name = self._file.compiled, self._file.compiled.joint(joint).name
        own = [e for body in _bodies(self._world()) for e in _joints(body)]
        return self._element(own, joint, [m.joint(i).name for i in range(m.njnt)],
                             f'joint {name or joint}')

    def _body(self, body: int) -> XmlElement:
        m, name = self._file.compiled, self._file.compiled.body(body).name
        return self._element(list(_bodies(self._world())), body - 1,
                             [m.body(i).name for i in range(1, m.nbody)], f'body {name or body}')

    def _world(self) -> list[XmlElement]:
        return self._document.root.all('worldbody')

    def _element(self, elements: Sequence[XmlElement], index: int, names: Sequence[str],
                 title: str) -> XmlElement:
        """Return the element of a name, or without one by its place among all."""
        own = [e.attributes.get('name', '') for e in elements]
        if own == list(names):
            return elements[index]
        if names[index] and names[index] in own:
            return elements[own.index(names[index])]
        problem = 'is not in this file itself' if names[index] else 'has no name, expected one'
        raise InputError(f'{self._document.name}: {title}: {problem}')

    def _inertial(self, link: str, theta: Array) -> list[Edit]:
        for compiler in self._document.root.all('compiler'):
            for key, usual in (('settotalmass', '-1'), ('inertiafromgeom', 'auto')):
                if compiler.attributes.get(key, usual) not in (usual, 'false'):
                    raise InputError(f'{self._document.name}: compiler: {key}: replaces masses of '
                                     'bodies, expected none')
        body, (mass, centre, tensor) = body_with(self._file, link, theta)
        return with_element(self._document, self._body(body), 'inertial',
                            inertial_attributes(mass, centre, tensor), first=True)

    def _of_tilt(self, values: Mapping[str, float]) -> list[Edit]:
        turned = tilted(self._file.chain.gravity, values['ax'], values['ay'])
        options = self._document.root.all('option')
        new: dict[str, str | None] = {'gravity': number(*turned)}
        if not options:
            return with_element(self._document, self._document.root, 'option', new, first=True)
        own = next((o for o in reversed(options) if 'gravity' in o.attributes), options[-1])
        return with_attributes(self._document, own, new)


def _bodies(elements: Sequence[XmlElement]) -> Iterator[XmlElement]:
    """Yield the bodies inside elements, in the order of MuJoCo: a parent before its children."""
    for element in elements:
        for child in element.children:
            if child.tag == 'body':
                yield child
            if child.tag in ('body', 'frame'):
                yield from _bodies([child])


def _joints(body: XmlElement) -> Iterator[XmlElement]:
    """Yield the joints of a body, also those in its frames."""
    for child in body.children:
        if child.tag in ('joint', 'freejoint'):
            yield child
        elif child.tag == 'frame':
            yield from _joints(child)


class _UrdfDraft(_ClosedDraft):
    def _attribute(self, joint: int, place: JointPlace) -> tuple[str, float]:
        if not place.urdf:
            raise InputError('a URDF has no rotors')
        return place.urdf, float(getattr(self._file.chain, place.field)[joint])

    def _of_joint(self, joint: int, values: dict[str, str]) -> list[Edit]:
        element = self._named('joint', self._file.chain.joints[joint])
        return with_element(self._document, element, 'dynamics', values)

    def _gravity(self) -> None:
        raise InputError('a URDF has no gravity')

    def _named(self, tag: str, name: str) -> XmlElement:
        """Return a joint or link of the robot; a <transmission> names joints as well."""
        return next(e for e in self._document.root.all(tag) if e.attributes.get('name') == name)

    def _inertial(self, link: str, theta: Array) -> list[Edit]:
        element = self._named('link', link)
        own: Array = np.zeros(PER_LINK)
        present = element.all('inertial')
        if present:
            part = ElementTree.fromstring(self._document.data[present[0].start:present[0].end])
            mass, centre, axes, tensor = inertial_in(part)
            own = inertial(mass, centre, axes @ tensor @ axes.T)
        mass, centre, tensor = possible(own, theta, f'{self._document.name}: link {link}')
        text = (f'<inertial>\n  <origin xyz="{number(*centre)}" rpy="0 0 0"/>\n'
                f'  <mass value="{number(mass)}"/>\n  <inertia ixx="{number(tensor[0, 0])}" '
                f'ixy="{number(tensor[0, 1])}" ixz="{number(tensor[0, 2])}" '
                f'iyy="{number(tensor[1, 1])}" iyz="{number(tensor[1, 2])}" '
                f'izz="{number(tensor[2, 2])}"/>\n</inertial>')
        if not present:
            return [with_child(self._document, element, text, first=True)]
        inner = self._document.indentation(present[0])
        return [Edit(present[0].start, present[0].end, text.replace('\n', f'\n{inner}'))]
