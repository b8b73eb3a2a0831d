# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""
A URDF file as ROS reads it, made readable for MuJoCo: without shapes, with what counts in ROS.

ROS takes the first of two equal elements, a link without inertial as one without mass, and tensors
that are no tensors by rounding. Meshes move nothing, so that they need not be there.
"""
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import losses_of
from gearbox_monitor.robot.description import PRINCIPAL, turn

SHAPES = ('visual', 'collision')
ONCE = ('origin', 'inertial', 'mass', 'inertia', 'parent', 'child', 'axis', 'limit', 'dynamics')
TENSOR = ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz')
# What counts as nothing: kg and kg m^2 of links that have none.
BOUNDS = {'boundmass': '1e-12', 'boundinertia': '1e-14'}
TRIANGLE = 1e-3  # how far a principal inertia may exceed the sum of the others, of the largest


def inertial_in(element: ElementTree.Element) -> tuple[float, Array, Array, Array]:
    """
    Return what an `element` <inertial> holds, 0 for what is not stated.

    Returns:
        Mass kg, centre [3] m and axes [3, 3] in the frame of the link, tensor [3, 3] kg m^2 along
        these axes.
    """
    def numbers(tag: str, *names: str, usual: str = '0') -> list[float]:
        child = element.find(tag)
        words = [usual if child is None else child.get(name, usual) for name in names]
        return [float(number) for word in words for number in word.split()]
    xyz, rpy = (np.array(numbers('origin', k, usual='0 0 0')) for k in ('xyz', 'rpy'))
    ixx, iyy, izz, ixy, ixz, iyz = numbers('inertia', *TENSOR)
    return numbers('mass', 'value')[0], xyz, turn(*rpy), np.array([
        [ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def readable_urdf(data: bytes, name: str) -> tuple[bytes, list[str]]:
    """
    Return a URDF file that MuJoCo reads as ROS does.

    Args:
        data: bytes of the file.
        name: its name, for messages.

    Returns:
        Its bytes, and notes about what ROS takes although the format forbids it.

    Raises:
        InputError: no XML, or a number that is none.
    """
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f'{name}: {error}, expected a URDF file') from None
    notes: list[str] = []
    for element in root.findall('joint') + root.findall('link'):
        title = f'{name}: {element.tag} {element.get("name", "")}'
        for part in (element, *element.findall('inertial')):
            notes += _first(part, title)
        if element.tag == 'joint':
            losses_of(element, name)  # MuJoCo takes an empty number for none
        for inertial in element.findall('inertial'):
            notes += _tensor(inertial, title)
    compiler = _compiler(root)
    for key, value in BOUNDS.items():
        compiler.attrib.setdefault(key, value)
    return ElementTree.tostring(root), notes


def _first(element: ElementTree.Element, title: str) -> list[str]:
    """Remove shapes and second elements; return notes about the latter."""
    notes, present = [], set()
    for child in list(element):
        if child.tag in SHAPES:
            element.remove(child)
        elif child.tag in ONCE and child.tag in present:
            element.remove(child)
            notes.append(f'{title}: <{child.tag}> appears twice: the first counts, as in ROS')
        present.add(child.tag)
    return notes


def _tensor(inertial: ElementTree.Element, title: str) -> list[str]:
    """Make the tensor of an inertial one that a body can have; return notes about that."""
    element, mass = inertial.find('inertia'), inertial.find('mass')
    if element is None or mass is None:
        return []
    try:
        ixx, iyy, izz, ixy, ixz, iyz = (float(element.get(k, '0')) for k in TENSOR)
        size = float(mass.get('value', '0'))
    except ValueError:
        raise InputError(f'{title}: inertial: {dict(element.attrib)}, expected numbers') from None
    tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if not np.isfinite(tensor).all():
        raise InputError(f'{title}: inertial: {dict(element.attrib)}, expected finite numbers')
    values = np.linalg.eigvalsh(tensor)
    allowed = PRINCIPAL * float(np.abs(tensor).max()) + PRINCIPAL * size * 1e-3
    deficit = max(0.0, -float(values[0]))
    beyond = max(0.0, float(values[2] - values[1] - values[0]))
    if deficit > allowed or beyond > TRIANGLE * float(values[2]) + allowed:
        return []  # MuJoCo says what is wrong
    if not deficit and not beyond:
        return []
    rounded: Array = tensor + (deficit + beyond) * np.eye(3)
    for key, value in zip(TENSOR, (*np.diag(rounded), ixy, ixz, iyz)):
        element.set(key, repr(float(value)))
    return [f'{title}: inertial: a principal inertia is {deficit + beyond:.3g} kg m^2 off what a '
            'body can have: taken for rounding']


def _compiler(root: ElementTree.Element) -> ElementTree.Element:
    extension = root.find('mujoco')
    if extension is None:
        extension = ElementTree.SubElement(root, 'mujoco')
    compiler = extension.find('compiler')
    return ElementTree.SubElement(extension, 'compiler') if compiler is None else compiler
