# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The file of a robot with what a diagnosis found: joints and bodies change, all else stays."""
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, GRAVITY_SIZE, INERTIA_NAMES, LINK_INERTIA, PAYLOAD)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS
from gearbox_monitor.robot.chain import inertial, PER_LINK
from gearbox_monitor.robot.compiled_model import disabled
from gearbox_monitor.simulators.mjcf import EXPRESSIONS, REFUSED
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.mjcf_patch import inertial_attributes, number
from gearbox_monitor.simulators.robot_bodies import body_with, possible
from gearbox_monitor.simulators.robot_model import ChainFile
from gearbox_monitor.simulators.urdf_file import inertial_in
from gearbox_monitor.simulators.xml_edit import (
    Edit, edited, parse_xml, with_attributes, with_child, with_element, XmlDocument, XmlElement)

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


class _Draft:
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


class _MjcfDraft(_Draft):
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
        turned = self._file.chain.gravity + GRAVITY_SIZE * np.array(
            [values['ax'], values['ay'], 0.0])
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


class _UrdfDraft(_Draft):
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
