# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Joint states of bags of other robots: ROS 1 bags, and messages of ros2_control.

All become sensor_msgs/JointState, setpoints on a topic of their own. A bag is read twice: first
for its joints and interfaces, then block by block. Of one joint one topic tells the state, and one
the setpoint; the notes list the others, and interfaces that are not used.
"""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
import struct
from typing import Any

import numpy as np
from rosbags.rosbag1 import Reader as Ros1File

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.cdr import Decoder, Message, MessageBlock
from gearbox_monitor.recordings.read import (
    BagReader, blocks_of, CONTROLLER, DYNAMIC, is_ros1, JOINT_STATE, open_bag, ROS1_TEXT)
from gearbox_monitor.recordings.si_signals import even_stamps
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.recordings.virtual_bag import Frames, JOINT_TOPIC, SETPOINT_TOPIC, VirtualBag

STATES = (JOINT_STATE, DYNAMIC, CONTROLLER)  # the most trusted first
MULTI = 'sensor_msgs/msg/MultiDOFJointState'
ABSOLUTE = 'absolute_position'  # of an encoder behind the gear
SETPOINT = 'setpoint'
OF_STATE = ('position', 'velocity', 'effort')
STAMPS = ('recorded', 'received', 'even')
MESSAGE_DATA = 2  # code of a record in a bag of ROS 1
MAX_UNPACKED = 1 << 28  # bytes of one of its chunks


class Ros1Reader(BagReader):
    """The bag of ROS 1 `path`, chunk by chunk."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = _Chunks(path)
        try:
            self._file.open()
        except Exception as error:  # the library raises many kinds for damaged bags
            raise self._damaged(error) from None
        self.opened.callback(self._file.close)
        infos = self._file.chunk_infos
        counts = [(c, sum(info.connection_counts.get(c.id, 0) for info in infos))
                  for c in self._file.connections]
        for c, count in counts:
            self.topics[c.topic] = c.msgtype, self.count(c.topic) + count
            self._definitions[c.msgtype] = ROS1_TEXT, c.msgdef.data
        if infos:
            self.start_ns = min(info.start_time for info in infos)
            self.end_ns = max(info.end_time for info in infos) - 1

    def _damaged(self, error: Exception) -> InputError:
        return InputError(f'{self.path}: {type(error).__name__} {error}, expected a whole ROS 1 '
                          'bag')

    def _stored_blocks(self, topics: Iterable[str] | None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        try:
            yield from blocks_of(names, self._messages({
                c.id: c.topic for c in self._file.connections if c.topic in names}))
        except (struct.error, OSError, LookupError, ValueError, EOFError, RuntimeError) as error:
            raise self._damaged(error) from None

    def _messages(self, topics: Mapping[int, str]) -> Iterator[Message]:
        """Yield the messages of the connections {number: topic} by time."""
        chunks = sorted(self._file.chunk_infos, key=lambda info: info.start_time)
        waiting: list[Message] = []
        for info, following in zip(chunks, [*(c.start_time for c in chunks[1:]), 1 << 63]):
            if not topics.keys().isdisjoint(info.connection_counts):
                waiting += _records(self._file.unpacked(info.pos), topics)
                waiting.sort(key=lambda message: message[1])
            done = next((k for k, message in enumerate(waiting) if message[1] >= following),
                        len(waiting))
            yield from waiting[:done]
            waiting = waiting[done:]


class _Chunks(Ros1File):
    """A bag of ROS 1 whose messages are not listed in memory."""

    def read_index_data(self, pos: int, indexes: Any) -> None:
        """Leave out the times of all messages."""

    def unpacked(self, pos: int) -> bytes:
        """Return the records of the chunk at byte `pos`."""
        chunk = self.chunks[pos]
        assert self.bio is not None
        self.bio.seek(chunk.datapos)
        data: bytes = chunk.decompressor(self.bio.read(chunk.datasize))
        if len(data) > MAX_UNPACKED:
            raise ValueError(f'chunk of {len(data)} bytes')
        return data


def _records(data: bytes, topics: Mapping[int, str]) -> Iterator[Message]:
    """Yield the messages in the records `data` of a chunk on `topics` {connection: name}."""
    size, offset = struct.Struct('<I'), 0
    while offset < len(data):
        (length,) = size.unpack_from(data, offset)
        offset, end = offset + 4, offset + 4 + length
        fields: dict[bytes, bytes] = {}
        while offset < end:
            (length,) = size.unpack_from(data, offset)
            name, _, value = data[offset + 4:offset + 4 + length].partition(b'=')
            fields[name] = value
            offset += 4 + length
        (length,) = size.unpack_from(data, end)
        begin, offset = end + 4, end + 4 + length
        if fields.get(b'op') == bytes([MESSAGE_DATA]):
            (connection,) = size.unpack(fields[b'conn'])
            if connection in topics:
                seconds, ns = struct.unpack('<II', fields[b'time'])
                log_ns = seconds * 1_000_000_000 + ns
                yield topics[connection], log_ns, log_ns, data[begin:offset]


# --- one topic ----------------------------------------------------------------------------------
@dataclass(frozen=True)
class JointColumns:
    """Messages [N] that name the same J joints: stamps, times of receipt, {quantity: [N, J]}."""

    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]


@dataclass
class _Topic:
    """
    A topic of joints and what a first pass has seen of it.

    interfaces: names of all; states, setpoints: joints whose values are taken from here.
    """

    reader: BagReader
    name: str
    is_setpoint: bool
    joints: dict[str, None] = field(default_factory=dict)
    interfaces: set[str] = field(default_factory=set)
    count: int = 0
    is_stamped: bool = False
    states: list[str] = field(default_factory=list)
    setpoints: list[str] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """Type of the messages as ROS 2 names it."""
        return _ros2_name(self.reader.topics[self.name][0])

    @property
    def quantities(self) -> set[str]:
        """What is used of its interfaces."""
        used = self.interfaces & {*OF_STATE, ABSOLUTE, SETPOINT}
        return used | ({'effort'} if 'torque' in self.interfaces else set())

    def decoder(self, names: Sequence[str]) -> Decoder:
        """Return what turns its messages of joint states into columns of the joints `names`."""
        kind = self.reader.topics[self.name][0]
        return Decoder(names, partial(self.reader.decode, kind),
                       f'{self.reader.path}: topic {self.name}: ', self.reader.is_ros1(kind))

    def survey(self, block: MessageBlock, decode: Decoder) -> None:
        """Note what the messages of `block` name; decode: of this topic."""
        self.count += len(block)
        if self.kind == JOINT_STATE:
            states = decode(block)
            self.joints.update(decode.joints)
            self.interfaces |= {SETPOINT} if self.is_setpoint else {*OF_STATE}
            self.is_stamped |= bool(states.stamp_ns.any())
            return
        for part in self.columns(block, decode):
            self.joints.update(dict.fromkeys(part.joints))
            self.interfaces |= set(part.values)
            self.is_stamped |= bool(part.stamp_ns.any())

    def columns(self, block: MessageBlock, decode: Decoder) -> Iterator[JointColumns]:
        """Yield the columns of `block`; decode: of all joints of this topic."""
        if self.kind != JOINT_STATE:
            yield from self._interfaces(block)
            return
        states = decode(block)
        values = {SETPOINT: states.position} if self.is_setpoint else {
            name: getattr(states, name) for name in OF_STATE}
        for named in np.unique(states.named, axis=0):
            rows = np.flatnonzero((states.named == named).all(axis=1))
            if named.any():
                yield JointColumns(
                    tuple(np.array(states.names, object)[named]), states.stamp_ns[rows],
                    states.log_ns[rows], {name: x[np.ix_(rows, named)]
                                          for name, x in values.items()})

    def _interfaces(self, block: MessageBlock) -> Iterator[JointColumns]:
        """Yield the columns of messages of ros2_control, all interfaces of them."""
        rows: dict[tuple[str, ...], list[tuple[int, int, dict[str, list[float]]]]] = {}
        for _, log_ns, _, raw in block.messages():
            message = self.reader.decode(self.reader.topics[self.name][0], raw)
            stamp = message.header.stamp
            rows.setdefault(tuple(message.joint_names), []).append((
                stamp.sec * 1_000_000_000 + stamp.nanosec, log_ns, _values_of(self.kind, message)))
        for joints, own in rows.items():
            names = dict.fromkeys(name for _, _, values in own for name in values)
            stamps, logged, values = zip(*own)
            yield JointColumns(joints, np.array(stamps), np.array(logged), {
                name: np.array([row.get(name, [np.nan] * len(joints)) for row in values])
                for name in names})


def _ros2_name(kind: str) -> str:
    """Return the name of a message type of ROS 1 or 2 as ROS 2 has it."""
    return kind if kind.count('/') != 1 else kind.replace('/', '/msg/')


def _values_of(kind: str, message: Any) -> dict[str, list[float]]:
    """Return {interface: values of all joints} of a message of ros2_control."""
    count = len(message.joint_names)
    if kind == DYNAMIC:
        tables = [dict(zip(part.interface_names, part.values))
                  for part in message.interface_values]
        return {name: [table.get(name, np.nan) for table in tables]
                for name in dict.fromkeys(chain(*tables))} if len(tables) == count else {}
    old = not hasattr(message, 'feedback')  # names of control_msgs before 2023
    feedback = message.actual if old else message.feedback
    reference = message.desired if old else message.reference
    output = getattr(message, 'output', None)
    values = {'position': list(feedback.positions), 'velocity': list(feedback.velocities),
              'effort': list(feedback.effort) or list(getattr(output, 'effort', ())),
              SETPOINT: list(reference.positions)}
    return {name: column for name, column in values.items() if len(column) == count}


# --- the bag ------------------------------------------------------------------------------------
def needs_conversion(reader: BagReader) -> bool:
    """Return whether a bag of ROS 2 has joints, but on no topic of sensor_msgs/JointState."""
    kinds = {_ros2_name(kind) for kind, count in reader.topics.values() if count}
    return JOINT_STATE not in {kind for kind, count in reader.topics.values() if count} and bool(
        kinds & {*STATES, MULTI} or any(kind.startswith('foxglove') for kind in kinds))


def converted_bag(path: Path, topic: str = '', stamps: str = STAMPS[0]) -> VirtualBag:
    """
    Return the joints of a bag as joint_states, and joint_setpoints where they are recorded.

    Args:
        path: of the bag, of ROS 1 or 2.
        topic: of the joint states; '' for joint_states, or the only topic of them.
        stamps: one of STAMPS.

    Raises:
        InputError: the bag holds no joint states, or none that can be read.
        Undecided: several topics tell the state of a joint, or all stamps are 0.
    """
    reader = Ros1Reader(path) if is_ros1(path) else open_bag(path)
    try:
        topics, notes = _surveyed(reader, topic, stamps)
        frames = partial(_frames, reader, topics, stamps == 'received')
        notes += ['time: the times of receipt stand in for the header stamps'] * (
            stamps == 'received')
        if stamps == 'even':
            whole, remarks = _evened(path, _joined(chain(*frames())))
            notes += remarks
            frames = partial(lambda all_frames: iter([all_frames]), whole)
        counts = {JOINT_TOPIC: sum(own.count for own in topics if own.states),
                  SETPOINT_TOPIC: sum(own.count for own in topics if own.setpoints)}
        bag = VirtualBag(path, {name: n for name, n in counts.items() if n}, frames, (
            reader.start_ns or 0, reader.end_ns or 0), notes)
        bag.opened.callback(reader.close)
        return bag
    except BaseException:
        reader.close()
        raise


def _frames(reader: BagReader, topics: Sequence[_Topic], received: bool
            ) -> Iterator[list[Frames]]:
    """Yield the chosen joints of `topics`, block by block; received: stamped on receipt."""
    decode = [own.decoder(list(own.joints)) for own in topics]
    for block in reader.blocks([own.name for own in topics]):
        frames = []
        for own, columns in zip(topics, decode):
            for part in own.columns(block.of(own.name), columns):
                stamps = part.log_ns if received else part.stamp_ns
                frames += _states(own, part, stamps) + _setpoints(own, part, stamps)
        if frames:
            yield frames


def _states(own: _Topic, part: JointColumns, stamps: Integers) -> list[Frames]:
    """Return the states in `part`; an encoder behind the gear is a joint JOINT_absolute."""
    rows = [k for k, joint in enumerate(part.joints) if joint in own.states]
    if not rows or not {*OF_STATE, ABSOLUTE, 'torque'} & set(part.values):
        return []
    joints, none = tuple(part.joints[k] for k in rows), np.full((len(stamps), len(rows)), np.nan)
    values = {name: x[:, rows] for name, x in part.values.items()}
    values.setdefault('effort', values.get('torque', none))
    fields = [values.get(name, none) for name in OF_STATE]
    if ABSOLUTE in values:
        joints += tuple(f'{joint}_absolute' for joint in joints)
        fields = [np.hstack(pair) for pair in zip(fields, (values[ABSOLUTE], none, none))]
    return [Frames(JOINT_TOPIC, joints, stamps, part.log_ns, *fields)]


def _setpoints(own: _Topic, part: JointColumns, stamps: Integers) -> list[Frames]:
    """Return the setpoints in `part`."""
    rows = [k for k, joint in enumerate(part.joints) if joint in own.setpoints]
    if not rows or SETPOINT not in part.values:
        return []
    return [Frames(SETPOINT_TOPIC, tuple(part.joints[k] for k in rows), stamps, part.log_ns,
                   part.values[SETPOINT][:, rows])]


def _joined(frames: Iterable[Frames]) -> list[Frames]:
    """Return all `frames`, those of one topic and the same joints as one."""
    parts: dict[tuple[str, tuple[str, ...]], list[Frames]] = {}
    for frame in frames:
        parts.setdefault((frame.topic, frame.joints), []).append(frame)
    joined = []
    for own in parts.values():
        fields: dict[str, Any] = {
            name: np.concatenate([getattr(f, name) for f in own])
            for name in ('stamp_ns', 'log_ns', *OF_STATE) if getattr(own[0], name) is not None}
        joined.append(replace(own[0], **fields))
    return joined


def _evened(path: Path, frames: Sequence[Frames]) -> tuple[list[Frames], list[str]]:
    """Return `frames` with even stamps, and notes about it."""
    pairs = [even_stamps(path, f.stamp_ns if f.stamp_ns.any() else f.log_ns) for f in frames]
    return [replace(f, stamp_ns=times, log_ns=np.maximum.accumulate(times))
            for f, (times, _) in zip(frames, pairs)], list(dict.fromkeys(
                note for _, notes in pairs for note in notes))


# --- which topic tells what ---------------------------------------------------------------------
def _surveyed(reader: BagReader, topic: str, stamps: str) -> tuple[list[_Topic], list[str]]:
    """Return (the topics of joints in a bag, each joint's state from one of them; notes)."""
    path = reader.path
    names, setpoints, notes = _chosen_topics(reader, topic)
    topics = [_Topic(reader, name, name in setpoints) for name in names]
    decode = [own.decoder(()) for own in topics]
    for block in reader.blocks(names) if names else ():
        for own, columns in zip(topics, decode):
            own.survey(block.of(own.name), columns)
    notes += [reader.notice] if reader.notice else []
    if not any(own.count for own in topics) or topic and not topics[0].count:
        raise _without_joints(reader, topic)
    topics = [own for own in topics if own.count]
    for own in topics:
        unused = own.interfaces - own.quantities - {'torque'}
        if {'effort', 'torque'} <= own.interfaces:
            unused.add('torque')
        if unused:
            notes.append(f'{own.name}: interfaces that are not used: '
                         f'{", ".join(sorted(unused))[:300]}')
    _share_joints(path, topics, bool(topic), notes)
    topics = [own for own in topics if own.states or own.setpoints]
    if not topics:
        raise InputError(f'{path}: messages of joints on {", ".join(names)} without values, '
                         f'expected one of {", ".join((*OF_STATE, SETPOINT))}')
    blank = next((own for own in topics if not own.is_stamped), None)
    if blank is not None and stamps == 'recorded':
        raise Undecided(f'{path}: all {blank.count} header stamps are 0: the driver does not '
                        'stamp its messages, expected --stamps received (the times of receipt in '
                        'the bag), or --stamps even')
    return topics, notes


def _without_joints(reader: BagReader, topic: str) -> InputError:
    """Return why a bag without messages of joints, or without them on `topic`, is refused."""
    kinds = {name: _ros2_name(kind) for name, (kind, _) in reader.topics.items()}
    multi = [name for name, kind in kinds.items() if kind == MULTI]
    schemas = [f'{name} ({kind})' for name, kind in kinds.items() if kind.startswith('foxglove')]
    if schemas:
        return InputError(f'{reader.path}: {", ".join(schemas)[:200]}: schemas of Foxglove, '
                          f'expected messages of {JOINT_STATE}: record that topic')
    if multi:
        return InputError(f'{reader.path}: {multi[0]} has type {MULTI}: poses of bodies, not '
                          f'positions of joints, expected {JOINT_STATE}')
    return InputError(f'{reader.path}: no messages of joints on {topic or "any topic"}, expected '
                      f'{", ".join(STATES)}; the bag has '
                      f'{", ".join(f"{n} ({k})" for n, k in sorted(kinds.items())) or "none"}')


def _chosen_topics(reader: BagReader, topic: str) -> tuple[list[str], set[str], list[str]]:
    """
    Return (topics to read, the most trusted first; those of setpoints among them; notes).

    Of all topics of sensor_msgs/JointState one tells the states: `topic`, else joint_states in
    whatever namespace, else the only one. Another one that is called joint_setpoints tells the
    setpoints. Topics of controllers and of dynamic joint states are all read.
    """
    path = reader.path
    of_joints = {kind: sorted(name for name, (declared, _) in reader.topics.items()
                              if _ros2_name(declared) == kind) for kind in STATES}
    with_messages = [name for name in of_joints[JOINT_STATE] if reader.count(name)]
    stated = _called(topic, [name for names in of_joints.values() for name in names]) \
        if topic else []
    if topic and not stated:
        raise InputError(f'{path}: --topic {topic}: no topic of joints, expected one of '
                         + (', '.join(name for kind in STATES for name in of_joints[kind])
                            or f'type {", ".join(STATES)}'))
    setpoints = [name for name in _called('joint_setpoints', with_messages) if name not in stated]
    candidates = stated or _called(JOINT_STATES, with_messages) or [
        name for name in with_messages if name not in setpoints]
    if len(candidates) > 1:
        raise Undecided(f'{path}: {", ".join(candidates)}: {len(candidates)} topics of joint '
                        f'states, expected one: --topic {candidates[0]}')
    same = [name for name in setpoints if candidates
            and name.rpartition('/')[0] == candidates[0].rpartition('/')[0]]
    setpoints = same or (setpoints if len(setpoints) == 1 else [])
    names = [*candidates, *setpoints, *(name for kind in (DYNAMIC, CONTROLLER)
                                        for name in of_joints[kind] if name not in stated)]
    return names, set(setpoints), [f'{name}: {reader.count(name)} messages left out' + (
        f'; the states are those of {candidates[0]} (--topic)' if candidates else '')
        for name in with_messages if name not in names]


def _called(name: str, topics: Sequence[str]) -> list[str]:
    """Return the `topics` that are `name`, or else those that end with it."""
    ending = '/' + name.strip('/')
    return [topic for topic in topics if '/' + topic.strip('/') == ending] or [
        topic for topic in topics if topic.endswith(ending) and not name.startswith('/')]


def _share_joints(path: Path, topics: Sequence[_Topic], is_asked: bool, notes: list[str]) -> None:
    """
    Give each joint to the most trusted of `topics` that tells its state, or its setpoint.

    Where a user has asked for the topic, the states are those of the first one alone. Raises
    Undecided: two topics of one type tell the state of a joint.
    """
    sources: dict[tuple[str, str], _Topic] = {}
    for own in topics:
        for content, quantities, taken in (
                ('states', {*OF_STATE, ABSOLUTE}, own.states),
                ('setpoints', {SETPOINT}, own.setpoints)):
            dropped: dict[str, list[str]] = {}
            for joint in own.joints if quantities & own.quantities else ():
                first = topics[0] if is_asked and content == 'states' else own
                source = sources.setdefault((content, joint), first)
                if source is own:
                    taken.append(joint)
                elif content == 'states' and source.kind == own.kind and not is_asked:
                    raise Undecided(f'{path}: {source.name}, {own.name}: {own.kind} of {joint}, '
                                    f'expected the topic that tells its state: --topic '
                                    f'{source.name} or --topic {own.name}')
                else:
                    dropped.setdefault(source.name, []).append(joint)
            notes += [f'{own.name}: {content} of {", ".join(joints)} left out: those of {name} '
                      'count' for name, joints in dropped.items()]
