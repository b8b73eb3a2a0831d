# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
An SDF model as URDF: links, joints and their dynamics, without shapes.

In URDF the frame of a link is that of the joint that moves it, so inertials move there.
"""
import math
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.urdf_file import TENSOR
from gearbox_monitor.export.xml_edit import XmlDocument, XmlElement
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.description import turn

MODEL_FRAME = '__model__'
AXES_OF_LINKS = 1.5   # first version whose axes are not in the frame of the model


class Frame(NamedTuple):
    """A rotation [3, 3] and an origin [3] m."""

    rotation: Array
    origin: Array

    def behind(self, other: 'Frame') -> 'Frame':
        """Return this frame, which is relative to `other`, in the frame of that one."""
        return Frame(other.rotation @ self.rotation,
                     other.rotation @ self.origin + other.origin)

    def inverse(self) -> 'Frame':
        """Return the frame of the reference, relative to this one."""
        return Frame(self.rotation.T, -self.rotation.T @ self.origin)


HERE = Frame(np.eye(3), np.zeros(3))


def child_of(element: XmlElement, *path: str) -> XmlElement | None:
    """Return the first element at a `path` of tags below `element`."""
    for tag in path:
        inner = element.all(tag)
        if not inner:
            return None
        element = inner[0]
    return element


def sdf_joint(document: XmlDocument, name: str | None) -> tuple[XmlElement, XmlElement]:
    """Return the model in a `document` and its joint `name`, None: first. Raises InputError."""
    names = []
    for model in document.root.walk():
        for joint in model.all('joint') if model.tag == 'model' else ():
            names.append(joint.attributes.get('name', ''))
            if name in (None, names[-1]):
                return model, joint
    raise InputError(f'{document.name}: joint: {name!r}, {unknown(name, names)}')


class _Sdf:
    """A model in an SDF file."""

    def __init__(self, document: XmlDocument, model: XmlElement) -> None:
        self._document = document
        self._links = {e.attributes.get('name', ''): e for e in model.all('link')}
        self.joints = {e.attributes.get('name', ''): e for e in model.all('joint')}
        self._frames = {e.attributes.get('name', ''): e for e in model.all('frame')}
        version = document.root.attributes.get('version', '1.7')
        try:
            self._version = float(version)
        except ValueError:
            self._fail(document.root, f'version {version!r}', 'a number')

    def _fail(self, element: XmlElement, value: str, expected: str) -> None:
        raise InputError(f'{self._document.name}: line {element.line}: {element.tag}: {value}, '
                         f'expected {expected}')

    def text(self, element: XmlElement, *path: str) -> str:
        """Return the text at a path below an element, '' without one."""
        inner = child_of(element, *path)
        return '' if inner is None else self._document.text(inner)

    def number(self, element: XmlElement, default: float, *path: str) -> float:
        """Return the number at a path below an element, `default` where there is none."""
        text = self.text(element, *path)
        return self.numbers(element, text)[0] if text else default

    def numbers(self, element: XmlElement, text: str) -> list[float]:
        """Return the numbers in a text of an element. Raises InputError."""
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        if not values or not all(map(math.isfinite, values)):
            self._fail(element, repr(text), 'numbers')
        return values

    def frame(self, element: XmlElement, base: str, depth: int = 0) -> Frame:
        """Return the pose of `element`; `base`: what it is relative to; `depth` of references."""
        pose = child_of(element, 'pose')
        own = HERE
        if pose is not None:
            base = pose.attributes.get('relative_to') or base
            numbers = self.numbers(pose, self._document.text(pose) or '0 0 0 0 0 0')
            if len(numbers) != 6:
                self._fail(pose, f'{len(numbers)} numbers', 'x y z roll pitch yaw')
            unit = math.pi / 180.0 if pose.attributes.get('degrees') in ('true', '1') else 1.0
            own = Frame(turn(*(unit * v for v in numbers[3:])), np.array(numbers[:3]))
        if depth > 50:
            self._fail(element, 'poses that are relative to each other', 'a tree')
        return own.behind(self.named(base, depth + 1, element))

    def named(self, name: str, depth: int, element: XmlElement) -> Frame:
        """Return the frame `name` at a `depth` of references; `element`: for the message."""
        if name in ('', MODEL_FRAME, 'world'):
            return HERE
        for table in (self._links, self.joints, self._frames):
            if name in table:
                base = (self.text(table[name], 'child') if table is self.joints
                        else table[name].attributes.get('attached_to', ''))
                return self.frame(table[name], base, depth)
        raise InputError(f'{self._document.name}: line {element.line}: {element.tag}: '
                         f'frame {name!r}, ' + unknown(name, (*self._links, *self.joints)))

    def urdf(self) -> str:
        """Return the text of a URDF file."""
        frames = {name: self.frame(e, '') for name, e in self._links.items()}
        parts = ['<robot name="sdf">', '<link name="world"/>']
        loose = set(frames)
        placed: dict[str, Frame] = {'world': HERE, **frames}
        for name, joint in self.joints.items():
            child = self.text(joint, 'child')
            if child in frames:
                loose.discard(child)
                placed[child] = self.named(name, 0, joint)
        parts += [self._link(name, frames[name], placed[name]) for name in frames]
        parts += [_joint(f'world_{name}', 'fixed', ('world', name), placed[name], '')
                  for name in sorted(loose)]
        for name, joint in self.joints.items():
            parent, child = self.text(joint, 'parent'), self.text(joint, 'child')
            if parent not in placed or child not in frames:
                self._fail(joint, f'parent {parent!r}, child {child!r}',
                           'links of its model')
            at = placed[child].behind(placed[parent].inverse())
            parts.append(_joint(name, joint.attributes.get('type', ''), (parent, child), at,
                                self._axis(joint, placed[child])))
        return '\n'.join([*parts, '</robot>'])

    def _link(self, name: str, frame: Frame, placed: Frame) -> str:
        element = self._links[name]
        inertial = child_of(element, 'inertial')
        at, mass, values = HERE, 1.0, dict.fromkeys(TENSOR, 0.0) | dict.fromkeys(TENSOR[:3], 1.0)
        if inertial is not None:
            pose = child_of(inertial, 'pose')
            if pose is not None and pose.attributes.get('relative_to'):
                self._fail(pose, 'relative_to', 'a pose in the frame of the link')
            at = self.frame(inertial, '')
            mass = self.number(inertial, 1.0, 'mass')
            values = {k: self.number(inertial, v, 'inertia', k) for k, v in values.items()}
        at = at.behind(frame).behind(placed.inverse())
        inertia = ' '.join(f'{k}="{v!r}"' for k, v in values.items())
        return (f'<link name={quoteattr(name)}><inertial>{_origin(at)}<mass value="{mass!r}"/>'
                f'<inertia {inertia}/></inertial></link>')

    def _axis(self, joint: XmlElement, placed: Frame) -> str:
        axis = child_of(joint, 'axis')
        if axis is None:
            return ''
        xyz = child_of(axis, 'xyz')
        direction = np.array([0.0, 0.0, 1.0])
        if xyz is not None:
            direction = np.array(self.numbers(xyz, self._document.text(xyz)))
            base = xyz.attributes.get('expressed_in', '')
            if base:
                direction = self.named(base, 0, xyz).rotation @ direction
            if base or self._version < AXES_OF_LINKS or self.text(
                    axis, 'use_parent_model_frame') in ('1', 'true'):
                direction = placed.rotation.T @ direction
        damping, friction = (self.number(axis, 0.0, 'dynamics', k)
                             for k in ('damping', 'friction'))
        lower, upper = (self.number(axis, v, 'limit', k)
                        for k, v in (('lower', -1e16), ('upper', 1e16)))
        limit = (f'<limit lower="{lower!r}" upper="{upper!r}" effort="1e16" velocity="1e16"/>'
                 if max(-lower, upper) < 1e15 else '')
        return (f'<axis xyz="{_words(direction)}"/>{limit}'
                f'<dynamics damping="{damping!r}" friction="{friction!r}"/>')


def _words(values: Array) -> str:
    return ' '.join(repr(float(v)) for v in values)


def _origin(frame: Frame) -> str:
    r = frame.rotation
    angles = (math.atan2(r[2, 1], r[2, 2]), math.asin(min(max(-r[2, 0], -1.0), 1.0)),
              math.atan2(r[1, 0], r[0, 0]))
    return f'<origin xyz="{_words(frame.origin)}" rpy="{_words(np.array(angles))}"/>'


def _joint(name: str, kind: str, links: tuple[str, str], at: Frame, inner: str) -> str:
    limited = 'limit' in inner
    kind = 'continuous' if kind == 'revolute' and not limited else kind
    return (f'<joint name={quoteattr(name)} type={quoteattr(kind)}>{_origin(at)}'
            f'<parent link={quoteattr(links[0])}/><child link={quoteattr(links[1])}/>{inner}'
            '</joint>')


def urdf_of(document: XmlDocument, joint: str | None) -> str:
    """
    Return the model with a joint in an SDF file as the text of a URDF file.

    Args:
        document: the SDF file.
        joint: name of one of its joints, None for the first of the file.

    Returns:
        A URDF file without shapes.

    Raises:
        InputError: no such joint, or what URDF does not have.
    """
    return _Sdf(document, sdf_joint(document, joint)[0]).urdf()


def spring_of(document: XmlDocument, joint: str) -> tuple[float, float]:
    """
    Return stiffness (N m/rad) and reference (rad) of a spring on a joint in an SDF file.

    Args:
        document: the SDF file.
        joint: name of the joint.

    Returns:
        Both 0 without a spring.
    """
    try:
        model, element = sdf_joint(document, joint)
    except InputError:
        return 0.0, 0.0  # a joint that urdf_of added
    reader, axis = _Sdf(document, model), child_of(element, 'axis')
    if axis is None or not (spring := reader.number(axis, 0.0, 'dynamics', 'spring_stiffness')):
        return 0.0, 0.0
    return spring, reader.number(axis, 0.0, 'dynamics', 'spring_reference')
