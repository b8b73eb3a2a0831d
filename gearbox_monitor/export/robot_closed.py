# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The file of a robot with what a diagnosis found: joints and bodies change, all else stays."""
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.export.mjcf_file import read_file
from gearbox_monitor.export.mjcf_patch import number
from gearbox_monitor.export.robot_model import ChainFile
from gearbox_monitor.export.xml_edit import (
    Edit, edited, parse_xml, with_attributes, with_child, XmlDocument, XmlElement)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import body_of, inertial
from gearbox_monitor.robot.description import turn

# Value of a finding -> attribute of an MJCF joint, of a URDF's <dynamics>.
OF_JOINT = {'Cc_change': ('frictionloss', 'friction'), 'Cv_change': ('damping', 'damping'),
            'm1_change': ('armature', '')}
GRAVITY_SIZE = 9.80665


def closed_file(file: ChainFile, findings: Sequence[Mapping[str, Any]], author: str
                ) -> tuple[str | None, list[str]]:
    """
    Return the text of the file with the findings.

    Args:
        file: of the robot.
        findings: as plain data.
        author: who writes it, for a comment.

    Returns:
        The text, None if nothing of them can stand in it, and what cannot, in words.
    """
    document = parse_xml(read_file(file.path), str(file.path))
    urdf = document.root.tag == 'robot'
    edits: list[Edit] = []
    left: list[str] = []
    joints: dict[str, dict[str, float]] = {}
    bodies: dict[str, Array] = {}
    for finding in findings:
        joint, values = finding.get('joint'), finding['values']
        change = {k: v for k, v in values.items() if k in OF_JOINT and not (
            urdf and not OF_JOINT[k][1])}
        name = f'{finding["effect"]} of {joint or finding.get("link") or "the base"}'
        if joint and change:
            for key, value in change.items():
                joints.setdefault(joint, {})[key] = joints.get(joint, {}).get(key, 0.0) + value
            if 'Ca' in values:
                left.append(f'the difference by direction of {joint}')
        elif finding['effect'] == 'payload':
            at = np.array([values['cx'], values['cy'], values['cz']])
            bodies[finding['link']] = bodies.get(finding['link'], np.zeros(10)) + inertial(
                values['m'], at, np.zeros((3, 3)))
        elif finding['effect'] == 'base_tilt' and not urdf:
            edits += _tilted(document, file, values)
        else:
            left.append(name)
    try:
        for joint, change in joints.items():
            edits += (_urdf_joint if urdf else _mjcf_joint)(document, file, joint, change)
        for link, theta in bodies.items():
            edits += (_urdf_body if urdf else _mjcf_body)(document, file, link, theta)
    except InputError as error:
        return None, [*left, str(error)]
    if not edits:
        return None, left
    text = edited(document, edits).decode('utf-8')
    head, root, tail = text.partition(f'<{document.root.tag}')
    return f'{head}<!-- {author} -->\n{root}{tail}', left


def _element(document: XmlDocument, tag: str, name: str) -> XmlElement:
    for element in document.root.walk():
        if element.tag == tag and element.attributes.get('name') == name:
            return element
    raise InputError(f'{document.name}: {tag}: {name!r} is not in this file itself')


def _index(file: ChainFile, joint: str) -> int:
    return file.chain.joints.index(joint)


def _mjcf_joint(document: XmlDocument, file: ChainFile, joint: str, change: Mapping[str, float]
                ) -> list[Edit]:
    m, i = file.compiled, _index(file, joint)
    base = {'Cc_change': float(m.dof_frictionloss[i]), 'Cv_change': float(m.dof_damping[i]),
            'm1_change': float(m.dof_armature[i])}
    return with_attributes(document, _element(document, 'joint', joint), {
        OF_JOINT[key][0]: number(max(base[key] + value, 0.0)) for key, value in change.items()})


def _urdf_joint(document: XmlDocument, file: ChainFile, joint: str, change: Mapping[str, float]
                ) -> list[Edit]:
    i, element = _index(file, joint), _element(document, 'joint', joint)
    base = {'Cc_change': float(file.chain.coulomb[i]), 'Cv_change': float(file.chain.viscous[i])}
    values = {OF_JOINT[key][1]: number(max(base[key] + value, 0.0))
              for key, value in change.items()}
    present = element.all('dynamics')
    if present:
        return with_attributes(document, present[0], dict(values))
    text = ' '.join(f'{key}="{value}"' for key, value in values.items())
    return [with_child(document, element, f'<dynamics {text}/>')]


def _heavier(theta: Array, where: str) -> tuple[float, Array, Array]:
    if not theta[0] > 0.0:
        raise InputError(f'{where}: mass {theta[0]:.3g} kg with the finding, expected more than 0')
    mass, centre, tensor = body_of(theta)
    least = float(np.linalg.eigvalsh(tensor)[0])
    if least <= 0.0:   # a mass less than a point's: the remainder must be a body
        tensor = tensor + (1e-9 - least) * np.eye(3)
    return mass, centre, tensor


def _mjcf_body(document: XmlDocument, file: ChainFile, link: str, theta: Array) -> list[Edit]:
    """Return the edits that add `theta` [10], in the frame of the link's joint, to a body."""
    m, body = file.compiled, file.compiled.body(link)
    b, i = int(body.id), int(m.body_jntadr[body.id] + m.body_jntnum[body.id] - 1)
    anchor = m.jnt_pos[i]
    mass, at = float(theta[0]), theta[1:4] / theta[0]
    frame = _rotation(m.body_iquat[b])
    own = inertial(float(m.body_mass[b]), m.body_ipos[b].copy(),
                   frame @ np.diag(m.body_inertia[b]) @ frame.T)
    whole, centre, tensor = _heavier(own + inertial(mass, at + anchor, np.zeros((3, 3))),
                                     f'{document.name}: body {link}')
    values: dict[str, str | None] = {
        'pos': number(*centre), 'mass': number(whole), 'fullinertia': number(
            *np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])}
    element = _element(document, 'body', link)
    present = element.all('inertial')
    if present:
        gone = dict.fromkeys(('diaginertia', 'quat', 'axisangle', 'xyaxes', 'zaxis', 'euler'))
        return with_attributes(document, present[0], {**values, **gone})
    text = ' '.join(f'{key}="{value}"' for key, value in values.items())
    return [with_child(document, element, f'<inertial {text}/>', first=True)]


def _rotation(quat: Array) -> Array:
    """Return the rotation [3, 3] of a unit quaternion w, x, y, z."""
    w, x, y, z = quat
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def _urdf_body(document: XmlDocument, file: ChainFile, link: str, theta: Array) -> list[Edit]:
    element = _element(document, 'link', link)
    own: Array = np.zeros(10)
    present = element.all('inertial')
    if present:
        part = {child.tag: child.attributes for child in present[0].children}
        place = part.get('origin', {})
        xyz, rpy = (np.array([float(x) for x in place.get(k, '0 0 0').split()])
                    for k in ('xyz', 'rpy'))
        i = {k: float(v) for k, v in part.get('inertia', {}).items()}
        tensor = np.array([[i['ixx'], i.get('ixy', 0.0), i.get('ixz', 0.0)],
                           [i.get('ixy', 0.0), i['iyy'], i.get('iyz', 0.0)],
                           [i.get('ixz', 0.0), i.get('iyz', 0.0), i['izz']]])
        axes = turn(*rpy)
        own = inertial(float(part['mass']['value']), xyz, axes @ tensor @ axes.T)
    mass, centre, tensor = _heavier(own + theta, f'{document.name}: link {link}')
    text = (f'<inertial>\n  <origin xyz="{number(*centre)}" rpy="0 0 0"/>\n'
            f'  <mass value="{number(mass)}"/>\n  <inertia ixx="{number(tensor[0, 0])}" '
            f'ixy="{number(tensor[0, 1])}" ixz="{number(tensor[0, 2])}" '
            f'iyy="{number(tensor[1, 1])}" iyz="{number(tensor[1, 2])}" '
            f'izz="{number(tensor[2, 2])}"/>\n</inertial>')
    if not present:
        return [with_child(document, element, text, first=True)]
    inner = document.indentation(present[0])
    return [Edit(present[0].start, present[0].end, text.replace('\n', f'\n{inner}'))]


def _tilted(document: XmlDocument, file: ChainFile, values: Mapping[str, float]) -> list[Edit]:
    gravity = file.chain.gravity + GRAVITY_SIZE * np.array([values['ax'], values['ay'], 0.0])
    option = document.root.all('option')
    if option:
        return with_attributes(document, option[0], {'gravity': number(*gravity)})
    return [with_child(document, document.root, f'<option gravity="{number(*gravity)}"/>', True)]
