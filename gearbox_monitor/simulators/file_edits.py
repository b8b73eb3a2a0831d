# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Edits of one simulator's file: attributes of joints, inertia of bodies, gravity, new elements.

A drive's model and a robot's findings become the same edits. MjcfEdits and UrdfEdits find the
elements of a file by name and write them; all other bytes of the file stay.
"""
import cmath
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import body_of, inertial, PER_LINK
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.xml_edit import (
    Edit, edited, inertial_in, TENSOR, with_attributes, with_child, words_of, XmlDocument,
    XmlElement)

SAME = 1e-6  # relative: numbers that differ by less are not edited; written ones have 9 digits
TURN = ('quat', 'euler', 'axisangle', 'xyaxes', 'zaxis')
LEAST_INERTIA = 1e-9    # kg m^2, of a principal inertia
BEYOND = 0.2  # of the largest principal inertia: what may be added to make a body possible
HEAVY = 0.5   # largest share of the inertia of an arm that its mass takes, off the joint
DISC = 0.05   # least share of the inertia about the axis that stays about the centre of mass


class Body(NamedTuple):
    """Mass (kg), centre [3] (m) and inertia about it [3, 3] (kg m^2), in one frame."""

    mass: float
    centre: Array
    tensor: Array


class Splice(NamedTuple):
    """One attribute that was edited: of which element, its text before ('' for none) and after."""

    element: str
    attribute: str
    before: str
    after: str

    @property
    def words(self) -> str:
        """The change in words: element, attribute, its text before and after."""
        previous = f'{self.before} -> ' if self.before else ''
        return f'{self.element}: ' + f'{self.attribute} ' * bool(self.attribute) + previous \
            + self.after


def number(*values: float) -> str:
    """Return `values` as the files have them, 0 for -0."""
    return ' '.join(f'{value + 0.0:.9g}' for value in values)


def same(a: complex, b: complex) -> bool:
    """Return whether two numbers are the same for a file."""
    return a == b or cmath.isclose(a, b, rel_tol=SAME)  # an infinite one is close to no other


def _alike(value: str | None, present: str | None) -> bool:
    """Return whether two texts of an attribute are the same numbers, or the same text."""
    if value is None or present is None or value == present:
        return value == present
    try:
        new, old = ([float(word) for word in text.split()] for text in (value, present))
    except ValueError:
        return False
    return len(new) == len(old) > 0 and all(map(same, new, old))


def titled(element: XmlElement) -> str:
    """Return the title of an `element` for people: its tag and its name or line."""
    name = element.attributes.get('name')
    return f'{element.tag} "{name}"' if name else f'{element.tag} (line {element.line})'


class FileEdits:
    """Edits of one file as they gather: attributes of elements, new elements, text."""

    def __init__(self, document: XmlDocument) -> None:
        self.document = document
        self.changes: list[Splice] = []
        self._attributes: dict[int, tuple[XmlElement, dict[str, str | None], str]] = {}
        self._sections: dict[str, list[str]] = {}
        self._children: dict[tuple[int, str], tuple[XmlElement, dict[str, str | None], bool]] = {}
        self._edits: list[Edit] = []

    def put(self, element: XmlElement, values: Mapping[str, str | None], tag: str = '',
            title: str = '') -> None:
        """
        Give an element attributes.

        Args:
            element: of the file.
            values: {attribute: text, None removes it}; what is there already is not edited.
            tag: another name for the element, '' keeps it.
            title: of the element for people, '' for its own.
        """
        _, new, old = self._attributes.setdefault(element.start, (element, {}, ''))
        self._attributes[element.start] = element, new, tag or old
        for name, value in values.items():
            present = element.attributes.get(name)
            if _alike(value, present):
                continue
            new[name] = value
            self.changes.append(Splice(title or titled(element), name, present or '',
                                       value or 'removed'))

    def add(self, section: str, title: str, text: str) -> None:
        """Add an element `title`, its `text`, to a section of the file such as tendon."""
        self._sections.setdefault(section, []).append(text)
        self.changes.append(Splice(title, '', '', 'new'))

    def insert(self, edit: Edit, title: str, words: str = 'new') -> None:
        """Add an `edit` of the text; `title` and `words` tell people of it."""
        self._edits.append(edit)
        self.changes.append(Splice(title, '', '', words))

    def put_child(self, parent: XmlElement, tag: str, values: Mapping[str, str | None],
                  title: str, first: bool = False) -> None:
        """
        Give the first child of one tag attributes; a file without one gets it with them.

        Args:
            parent: element of the file.
            tag: of the child.
            values: {attribute: text}.
            title: of the child for people.
            first: a new one stands before all others.
        """
        present = parent.all(tag)
        if present:
            self.put(present[0], values, title=title)
            return
        _, new, first = self._children.setdefault((parent.start, tag), (parent, {}, first))
        new.update(values)
        self.changes.append(Splice(title, '', '', words_of(values)))

    def patched(self, comment: str = '') -> bytes:
        """Return the file with all edits, and a `comment` before its root."""
        edits, new = list(self._edits), ''
        for element, values, tag in self._attributes.values():
            edits += with_attributes(self.document, element, values, tag)
        for (_, tag), (parent, values, first) in self._children.items():
            edits.append(with_child(self.document, parent, f'<{tag} {words_of(values)}/>', first))
        for section, texts in self._sections.items():
            lines = '\n'.join(texts)
            parts = self.document.root.all(section)
            if parts:
                edits.append(with_child(self.document, parts[-1], lines))
            else:
                inner = '\n'.join(f'  {line}' for line in lines.splitlines())
                new += f'<{section}>\n{inner}\n</{section}>\n'
        if new:
            edits.append(with_child(self.document, self.document.root, new))
        if comment:
            start = self.document.root.start
            edits.insert(0, Edit(start, start, f'<!-- {comment} -->\n'))
        return edited(self.document, edits)


class MjcfEdits(FileEdits):
    """Edits of an MJCF file; `compiled`: mujoco.MjModel of it."""

    def __init__(self, document: XmlDocument, compiled: Any) -> None:
        super().__init__(document)
        self._compiled = compiled
        self._bodies = list(_bodies(document.root.all('worldbody')))

    def joint(self, index: int) -> XmlElement:
        """Return the element of a compiled joint, by its number. Raises InputError."""
        return self._element([e for body in self._bodies for e in _joints(body)], 'joint', index)

    def listed(self, section: str, index: int) -> XmlElement:
        """Return an element of the `section` tendon or actuator, see joint."""
        return self._element([e for part in self.document.root.all(section)
                              for e in part.children], section, index)

    def body(self, index: int) -> XmlElement:
        """Return the element of a compiled body, by its number. Raises InputError."""
        return self._element(self._bodies, 'body', index, 1)

    def _element(self, elements: Sequence[XmlElement], kind: str, index: int, first: int = 0
                 ) -> XmlElement:
        """Return the element of a name, or without one by its place among all."""
        m = self._compiled
        count = {'joint': m.njnt, 'body': m.nbody, 'tendon': m.ntendon,
                 'actuator': len(m.actuator_trntype)}[kind]
        names = [getattr(m, kind)(i).name for i in range(first, count)]
        own = [e.attributes.get('name', '') for e in elements]
        name = names[index - first]
        if own == names:
            return elements[index - first]
        if name and name in own:
            return elements[own.index(name)]
        raise InputError(f'{self.document.name}: {kind} {name or index}: ' + (
            'is not in this file itself, expected it here and not in one that it includes'
            if name else 'has no name, expected one'))

    def put_joint(self, index: int, values: Mapping[str, float]) -> None:
        """Give a joint, by its number, attributes {name: value}. Raises InputError."""
        self.put(self.joint(index), {k: number(v) for k, v in values.items()})

    def put_body(self, index: int, body: Body) -> None:
        """Give a body, by its number, mass and inertia. Raises InputError."""
        for compiler in self.document.root.all('compiler'):
            for key, usual in (('settotalmass', '-1'), ('inertiafromgeom', 'auto')):
                if compiler.attributes.get(key, usual) not in (usual, 'false'):
                    raise InputError(f'{self.document.name}: compiler: {key}: replaces masses of '
                                     'bodies, expected none')
        element = self.body(index)
        tensor = np.where(np.abs(body.tensor) < 1e-9 * np.trace(body.tensor), 0.0, body.tensor)
        full = number(*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])
        self.put_child(element, 'inertial', {
            'pos': number(*body.centre), 'mass': number(body.mass), 'fullinertia': full,
            'diaginertia': None, **dict.fromkeys(TURN)}, f'inertial of {titled(element)}', True)

    def put_gravity(self, vector: Array) -> None:
        """Set gravity to `vector` [3] m/s^2."""
        options = self.document.root.all('option')
        values = {'gravity': number(*vector)}
        own = next((o for o in reversed(options) if 'gravity' in o.attributes),
                   options[-1] if options else None)
        if own is not None:
            self.put(own, values)
        else:
            self.put_child(self.document.root, 'option', values, 'option', first=True)


def compiled_body(m: Any, index: int) -> Body:
    """
    Return what a compiled body has itself, in its frame.

    Args:
        m: mujoco.MjModel.
        index: number of the body.
    """
    frame = np.zeros(9)
    mujoco_module().mju_quat2Mat(frame, m.body_iquat[index])
    axes = frame.reshape(3, 3)
    return Body(float(m.body_mass[index]), m.body_ipos[index].copy(),
                axes @ np.diag(m.body_inertia[index]) @ axes.T)


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


class UrdfEdits(FileEdits):
    """Edits of a URDF file."""

    def __init__(self, document: XmlDocument) -> None:
        super().__init__(document)
        self._bodies: dict[str, tuple[XmlElement, dict[str, dict[str, str]]]] = {}

    def patched(self, comment: str = '') -> bytes:
        """Return the file with all edits, and a `comment` before its root."""
        for element, parts in self._bodies.values():
            lines = '\n'.join(f'  <{tag} {words_of(values)}/>' for tag, values in parts.items())
            self._edits.append(with_child(self.document, element,
                                          f'<inertial>\n{lines}\n</inertial>', first=True))
        return super().patched(comment)

    def named(self, tag: str, name: str) -> XmlElement:
        """Return a joint or link of the robot, by its `tag` and `name`. Raises InputError."""
        elements = self.document.root.all(tag)
        names = [e.attributes.get('name', '') for e in elements]
        if name not in names:
            raise InputError(f'{self.document.name}: {tag}: {name!r} is not in this file, '
                             + unknown(name, names))
        return elements[names.index(name)]

    def put_joint(self, name: str, values: Mapping[str, float]) -> None:
        """Give a joint attributes: damping and friction of <dynamics>, effort of <limit>."""
        joint = self.named('joint', name)
        for tag, of in (('dynamics', ('damping', 'friction')), ('limit', ('effort',))):
            own = {k: number(values[k]) for k in of if k in values}
            present = joint.all(tag)
            if present:
                self.put(present[0], _without_zeros(own, present[0].attributes),
                         title=f'{titled(joint)} {tag}')
            elif any(values[k] for k in own):
                self.put_child(joint, tag, own, f'{titled(joint)} {tag}')

    def own(self, link: str) -> Body | None:
        """Return what a `link` has itself, in its frame; None without <inertial>."""
        present = self.named('link', link).all('inertial')
        if not present:
            return None
        part = ElementTree.fromstring(self.document.data[present[0].start:present[0].end])
        mass, centre, axes, tensor = inertial_in(part)
        return Body(mass, centre, axes @ tensor @ axes.T)

    def put_body(self, link: str, body: Body) -> None:
        """Give a `link` mass and inertia; the frame of its <inertial> stays turned as it is."""
        element = self.named('link', link)
        present = element.all('inertial')
        axes: Array = np.eye(3)
        if present:
            axes = inertial_in(ElementTree.fromstring(
                self.document.data[present[0].start:present[0].end]))[2]
        turned = axes.T @ body.tensor @ axes
        tensor = {k: number(float(turned['xyz'.index(k[1]), 'xyz'.index(k[2])])) for k in TENSOR}
        centre = np.where(np.abs(body.centre) < SAME * np.abs(body.centre).max(), 0.0, body.centre)
        parts = {'origin': {'xyz': number(*centre)}, 'mass': {'value': number(body.mass)},
                 'inertia': tensor}
        if not present:
            self._bodies[link] = element, parts
            self.changes.append(Splice(f'inertial of {titled(element)}', '', '', 'new'))
            return
        for tag, values in parts.items():
            title, own = f'{titled(element)} {tag}', present[0].all(tag)
            if own:
                self.put(own[0], _without_zeros(values, own[0].attributes), title=title)
            elif any(float(word) for text in values.values() for word in text.split()):
                self.put_child(present[0], tag, values, title)


def _without_zeros(values: Mapping[str, str], present: Mapping[str, str]) -> dict[str, str | None]:
    """Return `values` without those that are 0, as an attribute that is not `present` is."""
    return {k: v for k, v in values.items()
            if k in present or any(float(word) for word in v.split())}


# ---------------------------------------------------------------------- bodies


def with_added(own: Body | None, added: Array, where: str) -> Body:
    """
    Return the body that has the inertial parameters of a body and of something added.

    A mass that is taken away is no point: what remains is filled up to a body's inertia, which is
    above 0 and where no principal inertia exceeds the sum of the others.

    Args:
        own: the body, None for nothing.
        added: inertial parameters [10], in the same frame.
        where: of the body, for messages.

    Returns:
        The Body.

    Raises:
        InputError: no mass remains, or no inertia that a body can have.
    """
    theta = added + (inertial(*own) if own is not None else np.zeros(PER_LINK))
    if not theta[0] > 0.0:
        raise InputError(f'{where}: mass {theta[0]:.3g} kg with the finding, expected more than 0')
    mass, centre, tensor = body_of(theta)
    smallest, middle, largest = np.linalg.eigvalsh(tensor)
    deficit = max(LEAST_INERTIA - smallest, (1.0 + 1e-6) * (largest - middle - smallest), 0.0)
    if deficit > LEAST_INERTIA and deficit > BEYOND * max(largest, LEAST_INERTIA) and not added[0]:
        raise InputError(f'{where}: no body has such an inertia (principal ones {smallest:.3g}, '
                         f'{middle:.3g}, {largest:.3g} kg m^2)')
    return Body(mass, centre, tensor + deficit * np.eye(3))


def in_frame(theta: Array, by: Array) -> Array:
    """Return inertial parameters `theta` [10] in a frame whose origin lies at -`by` [3] m."""
    mass, first = float(theta[0]), theta[1:4]
    out = theta.copy()
    out[1:4] += mass * by
    # About the new origin: I + 2 (first . by) 1 - first by' - by first' + m (by . by 1 - by by').
    shift = ((2.0 * first @ by + mass * by @ by) * np.eye(3) - np.outer(first, by)
             - np.outer(by, first) - mass * np.outer(by, by))
    out[4:] += *np.diag(shift), shift[0, 1], shift[0, 2], shift[1, 2]
    return out


def across(vector: Array, axis: Array) -> Array:
    """Return the part of `vector` across the unit vector `axis`."""
    return vector - axis * float(axis @ vector)


def about_axis(body: Body, axis: Array, anchor: Array) -> float:
    """
    Return the inertia of a body about an axis, kg m^2.

    Args:
        body: in a frame.
        axis: [3], of length 1.
        anchor: [3] m, a point on it.
    """
    lever = across(body.centre - anchor, axis)
    return float(axis @ body.tensor @ axis) + body.mass * float(lever @ lever)


def balanced(body: Body, axis: Array, anchor: Array, wanted: float, moment: Array | None = None
             ) -> Body:
    """
    Return a body with another inertia about the axis of a joint, and another moment.

    Args:
        body: in a frame.
        axis: [3], of length 1.
        anchor: [3] m, a point on it.
        wanted: inertia about the axis, kg m^2, above 0.
        moment: mass times lever [3] that it gets (kg m), None for its own.

    Returns:
        The Body.
    """
    mass, centre, tensor = body
    lever = across(centre - anchor, axis)
    if moment is not None:
        # A light body far out would have more inertia than the model: heavier, and nearer.
        mass = max(mass, float(moment @ moment) / (HEAVY * wanted))
        centre, lever = centre - lever + moment / mass, moment / mass
    about = wanted - mass * float(lever @ lever)
    before = float(axis @ tensor @ axis)
    if about < DISC * wanted:
        factor = wanted / (before + mass * float(lever @ lever))
        mass, tensor = mass * factor, tensor * factor
    elif about < before:
        tensor = tensor * (about / before)
    else:  # a disc about the axis
        tensor = tensor + (about - before) * 0.5 * (np.eye(3) + np.outer(axis, axis))
    return Body(mass, centre, tensor)
