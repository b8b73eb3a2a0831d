# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Edit an XML file as text: what is not edited keeps every byte, comments and indentation too.

The parser (expat) tells where each element stands; edits replace or insert bytes there.
"""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import difflib
from html import escape  # xml.sax.saxutils would load ssl
import math
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.description import expanded_root, finite_number, PRINCIPAL, turn

_ATTRIBUTE = re.compile(rb'\s+([\w:.-]+)\s*=\s*("[^"]*"|\'[^\']*\')')


@dataclass
class XmlElement:
    """
    An element of a file: where it stands, in bytes.

    start: of its '<'; head: end of its start tag; end: behind its end tag. line: from 1.
    """

    tag: str
    attributes: dict[str, str]
    start: int
    line: int
    head: int = 0
    end: int = 0
    children: list['XmlElement'] = field(default_factory=list)

    def walk(self) -> Iterator['XmlElement']:
        """Yield this element and all inside it, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.walk()

    def all(self, tag: str) -> list['XmlElement']:
        """Return the children of one `tag`."""
        return [child for child in self.children if child.tag == tag]


@dataclass(frozen=True)
class Edit:
    """Bytes from start to end of a file that `text` replaces."""

    start: int
    end: int
    text: str


@dataclass(frozen=True)
class XmlDocument:
    """The bytes of an XML file, called `name` in messages, and its `root`."""

    name: str
    data: bytes
    root: XmlElement

    def head(self, element: XmlElement) -> bytes:
        """Return the start tag of `element`."""
        return self.data[element.start:element.head]

    def indentation(self, element: XmlElement) -> str:
        """Return the white space before `element`, '' where something else precedes it."""
        line = self.data[self.data.rfind(b'\n', 0, element.start) + 1:element.start]
        return '' if line.strip() else line.decode()


def parse_xml(data: bytes, name: str) -> XmlDocument:
    """Return the XmlDocument of the bytes `data` of the file `name`. Raises InputError."""
    parser = expat.ParserCreate()
    stack: list[XmlElement] = []
    roots: list[XmlElement] = []

    def _start(tag: str, attributes: Any) -> None:
        element = XmlElement(tag, attributes, parser.CurrentByteIndex, parser.CurrentLineNumber)
        element.head = _end_of_tag(data, element.start)
        (stack[-1].children if stack else roots).append(element)
        stack.append(element)

    def _end(tag: str) -> None:
        element = stack.pop()
        closed = data[element.head - 2:element.head] == b'/>'
        element.end = element.head if closed else _end_of_tag(data, parser.CurrentByteIndex)
    parser.StartElementHandler, parser.EndElementHandler = _start, _end
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputError(f'{name}: line {error.lineno}: {expat.ErrorString(error.code)}, '
                         'expected XML') from None
    return XmlDocument(name, data, roots[0])


def _end_of_tag(data: bytes, start: int) -> int:
    """Return the place behind the '>' of the tag that starts at `start`."""
    quote = 0
    for place in range(start, len(data)):
        byte = data[place]
        if quote:
            quote = 0 if byte == quote else quote
        elif byte in b'"\'':
            quote = byte
        elif byte == 0x3e:
            return place + 1
    return len(data)


def with_attributes(document: XmlDocument, element: XmlElement,
                    values: dict[str, str | None], tag: str = '') -> list[Edit]:
    """
    Return the edits that give an element other attributes.

    Args:
        document: the file.
        element: of it.
        values: {attribute: value, None to remove it}.
        tag: another name for the element, '' keeps it.

    Returns:
        One edit per attribute, and two for another name.
    """
    head, edits = document.head(element), []
    present = {m[1].decode(): m for m in _ATTRIBUTE.finditer(head)}
    name_end = len(element.tag.encode()) + 1
    if tag and tag != element.tag:
        edits.append(Edit(element.start + 1, element.start + name_end, tag))
        if element.end != element.head:
            close = document.data.rfind(b'</', element.start, element.end)
            edits.append(Edit(close + 2, close + 1 + name_end, tag))
    last = element.start + max([name_end, *(m.end() for m in present.values())])
    added = ''
    for name, value in values.items():
        match = present.get(name)
        if match is None:
            added += f' {name}="{escape(value)}"' if value is not None else ''
        elif value is None:
            edits.append(Edit(element.start + match.start(), element.start + match.end(), ''))
        else:
            edits.append(Edit(element.start + match.start(2), element.start + match.end(2),
                              f'"{escape(value)}"'))
    return [*edits, Edit(last, last, added)] if added else edits


def with_child(document: XmlDocument, parent: XmlElement, text: str, first: bool = False
               ) -> Edit:
    """
    Return the edit that puts a child into an element, indented like its neighbours.

    Args:
        document: the file.
        parent: element that gets the child.
        text: of the child, lines relative to its own indentation.
        first: before all others, else behind them.

    Returns:
        The edit.
    """
    own = document.indentation(parent)
    inner = document.indentation(parent.children[0]) if parent.children else own + '  '
    text = _indented(text, inner)
    if parent.end == parent.head:  # <a/>
        return Edit(parent.head - 2, parent.head, f'>{text}\n{own}</{parent.tag}>')
    if parent.children and not first:
        place = parent.children[-1].end
        return Edit(place, place, text)
    return Edit(parent.head, parent.head, text if parent.children else f'{text}\n{own}')


def words_of(values: Mapping[str, str | None]) -> str:
    """Return attributes `values` as a start tag has them, without those that are None."""
    return ' '.join(f'{name}="{escape(v)}"' for name, v in values.items() if v is not None)


def behind(document: XmlDocument, element: XmlElement, text: str) -> Edit:
    """
    Return the edit that puts a sibling behind an element.

    Args:
        document: the file.
        element: of it.
        text: of the sibling, lines relative to its own indentation.

    Returns:
        The edit.
    """
    return Edit(element.end, element.end, _indented(text, document.indentation(element)))


def _indented(text: str, indentation: str) -> str:
    return ''.join(f'\n{indentation}{line}' for line in text.splitlines())


def edited(document: XmlDocument, edits: Sequence[Edit]) -> bytes:
    """Return the bytes of `document` with all `edits`, insertions at one place in their order."""
    parts, place = [], 0
    for edit in sorted(edits, key=lambda e: (e.start, e.end)):
        if edit.start < place:
            raise ValueError(f'{document.name}: two edits of byte {edit.start}')
        parts += [document.data[place:edit.start], edit.text.encode()]
        place = edit.end
    return b''.join([*parts, document.data[place:]])


def difference(path: str, before: bytes, after: bytes) -> list[str]:
    """
    Return the lines of a unified diff.

    Args:
        path: of the file.
        before: its bytes.
        after: those of the file that it becomes.
    """
    old, new = (data.decode('utf-8').splitlines() for data in (before, after))
    name = Path(path).name
    return list(difflib.unified_diff(old, new, f'a/{name}', f'b/{name}', lineterm='', n=1))


SHAPES = ('visual', 'collision')
ONCE = ('origin', 'inertial', 'mass', 'inertia', 'parent', 'child', 'axis', 'limit', 'dynamics')
NUMBERS = {'origin': ('xyz', 'rpy'), 'axis': ('xyz',), 'mass': ('value',), 'mimic': (
    'multiplier', 'offset'), 'limit': ('lower', 'upper', 'effort', 'velocity'), 'dynamics': (
    'damping', 'friction'), 'inertia': ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz')}
TENSOR = {'ixx': (0, 0), 'iyy': (1, 1), 'izz': (2, 2),
          'ixy': (0, 1), 'ixz': (0, 2), 'iyz': (1, 2)}
# What counts as nothing: kg and kg m^2 of links that have none.
BOUNDS = {'boundmass': '1e-12', 'boundinertia': '1e-14'}
MARGIN = 1e-12   # of the largest principal inertia
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


def readable_urdf(data: bytes, name: str) -> tuple[bytes, list[str], dict[str, float]]:
    """
    Return a URDF file that MuJoCo reads as ROS does.

    Args:
        data: bytes of the file.
        name: its name, for messages.

    Returns:
        Its bytes, notes about what ROS takes although the format forbids it, and {link: kg m^2}
        by how much the tensors that no body has differ from the ones that stand for them.

    Raises:
        InputError: no XML, or a number that is none.
    """
    root = expanded_root(data, name)
    joints = [joint.get('name', '') for joint in root.findall('joint')]
    notes, spoilt = list[str](), dict[str, float]()
    for element in root.findall('joint') + root.findall('link'):
        title = f'{name}: {element.tag} {element.get("name", "")}'
        for part in (element, *element.findall('inertial')):
            notes += _first(part, title)
        _expect_numbers(element, title)
        for mimic in element.findall('mimic'):  # of no joint, MuJoCo would let it move by itself
            if mimic.get('joint') not in joints:
                raise InputError(f'{title}: mimic: {mimic.get("joint")!r}, '
                                 + unknown(mimic.get('joint', ''), joints))
        for inertial in element.findall('inertial'):
            words, off = _tensor(inertial, title)
            notes += words
            if off:
                spoilt[element.get('name', '')] = off
    compiler = _compiler(root)
    for key, value in BOUNDS.items():
        compiler.attrib.setdefault(key, value)
    return ElementTree.tostring(root), notes, spoilt


def _expect_numbers(element: ElementTree.Element, title: str) -> None:
    """Raise InputError unless what has to be a number in an `element` is one, or three of it."""
    for part in element.iter():
        for key in NUMBERS.get(part.tag, ()):
            words = part.get(key, '0').split() or ['']
            if key in ('xyz', 'rpy') and key in part.attrib and len(words) != 3:
                raise InputError(f'{title}: {part.tag}: {key}: {part.get(key)!r}, expected three '
                                 'numbers')
            for word in words:
                finite_number(word, f'{title}: {part.tag}: {key}',
                              math.inf if part.tag == 'limit' else 1e9)


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


def _tensor(inertial: ElementTree.Element, title: str) -> tuple[list[str], float]:
    """
    Make the tensor of an inertial one that a body can have.

    Returns:
        Notes about that, and how far the tensor moved (kg m^2) if it was no rounding.
    """
    element, mass = inertial.find('inertia'), inertial.find('mass')
    if element is None or mass is None:
        return [], 0.0
    ixx, iyy, izz, ixy, ixz, iyz = (float(element.get(k, '0')) for k in TENSOR)
    size = float(mass.get('value', '0'))
    tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    values, axes = np.linalg.eigh(tensor)
    deficit = max(0.0, -float(values[0]))
    body = values + deficit
    beyond = max(0.0, float(body[2] - body[1] - body[0]))
    if not deficit and body[2] - body[1] - body[0] < -MARGIN * body[2]:
        return [], 0.0   # a flat body has equality, which rounding breaks
    # The smallest change: a third of the excess each. The margin is above what rounding takes.
    body += beyond / 3.0 * np.array([1.0, 1.0, -1.0]) + MARGIN * float(body[2])
    moved = axes @ np.diag(body) @ axes.T
    for key, (i, j) in TENSOR.items():
        element.set(key, repr(float(moved[i, j])))
    if not deficit and not beyond:
        return [], 0.0
    allowed = PRINCIPAL * (float(np.abs(tensor).max()) + 1e-3 * size)
    if deficit <= allowed and beyond <= TRIANGLE * float(values[2]) + allowed:
        return [f'{title}: inertial: a principal inertia is {deficit + beyond:.3g} kg m^2 off '
                'that of any body: taken for rounding'], 0.0
    stated, read = (', '.join(f'{value:.3g}' for value in row) for row in (values, body))
    return [f'{title}: inertial: principal inertias {stated} kg m^2: no body has a negative one, '
            f'or one above the sum of the others: read as {read}: check units and signs'
            ], deficit + beyond / 3.0


def _compiler(root: ElementTree.Element) -> ElementTree.Element:
    extension = root.find('mujoco')
    if extension is None:
        extension = ElementTree.SubElement(root, 'mujoco')
    compiler = extension.find('compiler')
    return ElementTree.SubElement(extension, 'compiler') if compiler is None else compiler
