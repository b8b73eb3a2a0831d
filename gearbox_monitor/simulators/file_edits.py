# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Edits of a robot's file as data, and what writes them: one function for MJCF and URDF each.

The model of a joint and the findings on a robot both become FileEdits. A writer finds the elements
by name and edits their text; all other bytes of the file stay.
"""
import cmath
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import body_of, inertial, PER_LINK
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.mjcf import Exported
from gearbox_monitor.simulators.xml_edit import (
    behind, Edit, edited, inertial_in, TENSOR, with_attributes, with_child, words_of, XmlDocument,
    XmlElement)

SAME = 1e-6  # relative: numbers that differ by less are not edited; written ones have 9 digits
TURN = ('quat', 'euler', 'axisangle', 'xyaxes', 'zaxis')
LEAST_INERTIA = 1e-9    # kg m^2, of a principal inertia
BEYOND = 0.2  # of the largest principal inertia: what may be added to make a body possible
HEAVY = 0.5   # largest share of the inertia of an arm that its mass takes, off the joint
DISC = 0.05   # least share of the inertia about the axis that stays about the centre of mass
URDF_PLACES = {  # attribute of a joint -> element and attribute of a URDF
    'damping': ('dynamics', 'damping'), 'frictionloss': ('dynamics', 'friction'),
    'effort': ('limit', 'effort')}


class Body(NamedTuple):
    """Mass (kg), centre [3] (m) and inertia about it [3, 3] (kg m^2), in one frame."""

    mass: float
    centre: Array
    tensor: Array


class NewElement(NamedTuple):
    """An element that a file gets: its title for people, its text, and in which section."""

    section: str
    title: str
    text: str


@dataclass(frozen=True)
class FileEdits:
    """
    What changes in a robot's file.

    attributes {(kind, place): {attribute: text, None removes it}}; kind: joint, tendon, actuator,
    sensor or keyframe; place: the compiled number, in a URDF the name; the attribute '' is its
    tag. bodies {place: inertial parameters [10] that a body gains, in its frame}. gravity [3],
    m/s^2. new: elements; rotor: the body that a new one follows, and that.
    """

    attributes: Mapping[tuple[str, int | str], Mapping[str, str | None]] = field(
        default_factory=dict)
    bodies: Mapping[int | str, Array] = field(default_factory=dict)
    gravity: Array | None = None
    new: tuple[NewElement, ...] = ()
    rotor: tuple[int, NewElement] | None = None

    def __or__(self, other: 'FileEdits') -> 'FileEdits':
        """Return both edits; of one attribute those of `other` count, of one body the sum."""
        a, b = (dict(e.attributes) for e in (self, other))
        return FileEdits(
            {key: {**a.get(key, {}), **b.get(key, {})} for key in (*a, *b)},
            {**self.bodies, **{key: self.bodies.get(key, 0.0) + theta
                               for key, theta in other.bodies.items()}},
            self.gravity if other.gravity is None else other.gravity, self.new + other.new,
            other.rotor or self.rotor)


class AttributeChange(NamedTuple):
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


@dataclass(frozen=True)
class Patch:
    """The bytes of a patched file, its changes, what became of effects, joints of the drive."""

    data: bytes
    changes: tuple[AttributeChange, ...]
    exported: tuple[Exported, ...] = ()
    joints: tuple[str, str | None] = ('', None)


def number(*values: float) -> str:
    """Return `values` as the files have them, 0 for -0."""
    return ' '.join(f'{value + 0.0:.9g}' for value in values)


def same(a: complex, b: complex) -> bool:
    """Return whether two numbers are the same for a file."""
    return a == b or cmath.isclose(a, b, rel_tol=SAME)  # an infinite one is close to no other


def differing(values: Mapping[str, str | None], present: Mapping[str, str]
              ) -> dict[str, str | None]:
    """Return those of `values` {attribute: text} that are other numbers than those `present`."""
    return {name: text for name, text in values.items() if not _alike(text, present.get(name))}


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


class _Text:
    """The text of a file while edits are written into it."""

    def __init__(self, document: XmlDocument) -> None:
        self.document = document
        self.changes: list[AttributeChange] = []
        self._edits: list[Edit] = []

    def put(self, element: XmlElement, values: Mapping[str, str | None], title: str = '') -> None:
        """Give an element the attributes `values` under a `title`; what is there is not edited."""
        new = differing({k: v for k, v in values.items() if k}, element.attributes)
        self.changes += [
            AttributeChange(title or titled(element), name, element.attributes.get(name, ''),
                            value or 'removed') for name, value in new.items()]
        self._edits += with_attributes(self.document, element, new, values.get('') or '')

    def put_child(self, parent: XmlElement, tag: str, values: Mapping[str, str | None],
                  title: str) -> None:
        """Give the first child of `parent` with a tag `values` under a `title`, or make one."""
        if present := parent.all(tag):
            self.put(present[0], values, title)
        else:
            self.add(with_child(self.document, parent, f'<{tag} {words_of(values)}/>',
                                tag in ('inertial', 'option')), title, words_of(values))

    def add(self, edit: Edit, title: str, words: str = 'new') -> None:
        """Add an `edit` of the text; `title` and `words` tell people of it."""
        self._edits.append(edit)
        self.changes.append(AttributeChange(title, '', '', words))

    def patch(self, comment: str) -> Patch:
        """Return the file with all edits, and a `comment` before its root."""
        start = self.document.root.start
        first = [Edit(start, start, f'<!-- {comment} -->\n')] if comment else []
        return Patch(edited(self.document, first + self._edits), tuple(self.changes))


# ---------------------------------------------------------------------- MJCF


def mjcf_element(document: XmlDocument, compiled: Any, kind: str, index: int) -> XmlElement:
    """
    Return the element of a name, or without one by its place among all.

    Args:
        document: MJCF file.
        compiled: mujoco.MjModel of it.
        kind: joint, body, tendon or actuator; or sensor or keyframe, by their place in the file.
        index: compiled number.

    Raises:
        InputError: it is in another file, which this one includes.
    """
    m, first = compiled, int(kind == 'body')
    elements = [e for part in document.root.all(kind) for e in part.children]
    if kind in ('sensor', 'keyframe'):
        return elements[index]
    if kind in ('joint', 'body'):
        elements = list(_bodies(document.root.all('worldbody')))
    if kind == 'joint':
        elements = [e for body in elements for e in _joints(body)]
    count = {'joint': m.njnt, 'body': m.nbody, 'tendon': m.ntendon,
             'actuator': len(m.actuator_trntype)}[kind]
    names = [getattr(m, kind)(i).name for i in range(first, count)]
    own = [e.attributes.get('name', '') for e in elements]
    name = names[index - first]
    if own == names:
        return elements[index - first]
    if name and name in own:
        return elements[own.index(name)]
    raise InputError(f'{document.name}: {kind} {name or index}: ' + (
        'is not in this file itself, expected it here and not in one that it includes'
        if name else 'has no name, expected one'))


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


def write_mjcf(document: XmlDocument, compiled: Any, edits: FileEdits, comment: str = '') -> Patch:
    """
    Return an MJCF file with edits.

    Args:
        document: the file.
        compiled: mujoco.MjModel of it.
        edits: what changes, by compiled numbers.
        comment: before the root, '' for none.

    Raises:
        InputError: an element is not in the file, or a body cannot be so.
    """
    text, root = _Text(document), document.root
    for (kind, place), values in edits.attributes.items():
        text.put(mjcf_element(document, compiled, kind, int(place)), values)
    for body, added in edits.bodies.items():
        _put_body(text, compiled, int(body), added)
    if edits.gravity is not None:
        options = root.all('option')
        own = [o for o in options if 'gravity' in o.attributes] or options
        gravity = {'gravity': number(*edits.gravity)}
        if own:
            text.put(own[-1], gravity)
        else:
            text.put_child(root, 'option', gravity, 'option')
    if edits.rotor is not None:
        body, (_, title, words) = edits.rotor
        text.add(behind(document, mjcf_element(document, compiled, 'body', body), words), title)
    _add_elements(text, edits.new)
    return text.patch(comment)


def _add_elements(text: _Text, new: Iterable[NewElement]) -> None:
    """Add elements to their sections, which a file gets that has none."""
    root, missing = text.document.root, dict[str, str]()
    for section, title, words in new:
        if present := root.all(section):
            text.add(with_child(text.document, present[-1], words), title)
        else:
            inner = '\n'.join(f'  {line}' for line in words.splitlines())
            missing[section] = f'{missing.get(section, f"<{section}>")}\n{inner}'
            text.changes.append(AttributeChange(title, '', '', 'new'))
    for section, words in missing.items():
        text._edits.append(with_child(text.document, root, f'{words}\n</{section}>'))


def _put_body(text: _Text, compiled: Any, index: int, added: Array) -> None:
    """Give a body, by its number, what it has and parameters [10] that it gains."""
    document = text.document
    for compiler in document.root.all('compiler'):
        for key, usual in (('settotalmass', '-1'), ('inertiafromgeom', 'auto')):
            if compiler.attributes.get(key, usual) not in (usual, 'false'):
                raise InputError(f'{document.name}: compiler: {key}: replaces masses of '
                                 'bodies, expected none')
    element = mjcf_element(document, compiled, 'body', index)
    body = with_added(compiled_body(compiled, index), added,
                      f'{document.name}: body {compiled.body(index).name or index}')
    tensor = np.where(np.abs(body.tensor) < 1e-9 * np.trace(body.tensor), 0.0, body.tensor)
    full = number(*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])
    text.put_child(element, 'inertial', {
        'pos': number(*body.centre), 'mass': number(body.mass), 'fullinertia': full,
        'diaginertia': None, **dict.fromkeys(TURN)}, f'inertial of {titled(element)}')


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


# ---------------------------------------------------------------------- URDF


def write_urdf(document: XmlDocument, edits: FileEdits, comment: str = '') -> Patch:
    """
    Return a URDF file with edits.

    Args:
        document: the file.
        edits: what changes, by name.
        comment: before the root, '' for none.

    Raises:
        InputError: an element is not in the file, a URDF has no such attribute, or a link cannot
            be so.
    """
    text = _Text(document)
    if edits.gravity is not None:
        raise InputError('a URDF has no gravity')
    for (kind, name), values in edits.attributes.items():
        if kind != 'joint' or not values.keys() <= URDF_PLACES.keys():
            raise InputError(f'a URDF has no {"rotors" if kind == "joint" else f"{kind}s"}')
        joint = _named(document, kind, str(name))
        for tag in dict.fromkeys(URDF_PLACES[k][0] for k in values):
            own = {URDF_PLACES[k][1]: v for k, v in values.items() if URDF_PLACES[k][0] == tag}
            _put_part(text, joint, tag, own)
    for link, added in edits.bodies.items():
        _put_link(text, str(link), added)
    return text.patch(comment)


def _named(document: XmlDocument, tag: str, name: str) -> XmlElement:
    """Return a joint or link of the robot, by its `tag` and `name`. Raises InputError."""
    elements = document.root.all(tag)
    names = [e.attributes.get('name', '') for e in elements]
    if name not in names:
        raise InputError(f'{document.name}: {tag}: {name!r} is not in this file, '
                         + unknown(name, names))
    return elements[names.index(name)]


def _put_part(text: _Text, element: XmlElement, tag: str, values: Mapping[str, str | None],
              parent: XmlElement | None = None) -> None:
    """Give a part of an `element` attributes, but no 0 where the file states none."""
    parent = parent or element
    present = parent.all(tag)
    own = {k: v for k, v in values.items() if (present and k in present[0].attributes)
           or any(float(word) for word in (v or '0').split())}
    if own:
        text.put_child(parent, tag, own if present else values, f'{titled(element)} {tag}')


def _put_link(text: _Text, link: str, added: Array) -> None:
    """Give a link what it has and parameters [10] that it gains; its frame stays turned."""
    element, document = _named(text.document, 'link', link), text.document
    present, own = element.all('inertial'), None
    axes: Array = np.eye(3)
    if present:
        mass, centre, axes, tensor = inertial_in(ElementTree.fromstring(
            document.data[present[0].start:present[0].end]))
        own = Body(mass, centre, axes @ tensor @ axes.T)
    body = with_added(own, added, f'{document.name}: link {link}')
    turned = axes.T @ body.tensor @ axes
    centre = np.where(np.abs(body.centre) < SAME * np.abs(body.centre).max(), 0.0, body.centre)
    parts: dict[str, dict[str, str | None]] = {
        'origin': {'xyz': number(*centre)}, 'mass': {'value': number(body.mass)},
        'inertia': {k: number(float(turned[i, j])) for k, (i, j) in TENSOR.items()}}
    if not present:
        lines = '\n'.join(f'  <{tag} {words_of(values)}/>' for tag, values in parts.items())
        text.add(with_child(document, element, f'<inertial>\n{lines}\n</inertial>', first=True),
                 f'inertial of {titled(element)}')
        return
    for tag, values in parts.items():
        _put_part(text, element, tag, values, present[0])


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
