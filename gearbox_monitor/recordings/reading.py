# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Open a recording of any kind, as a bag: the one way in of all commands.

Joint states of bags of other robots, of ROS 1 and in messages of ros2_control, all become
sensor_msgs/JointState, setpoints on a topic of their own. Such a bag is read twice: first for its
joints and interfaces, then block by block. One topic has the states, one the setpoint of each
joint; the notes list the others, and interfaces that are not used.
"""
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from rosbags.rosbag1 import Reader as Ros1File, ReaderError
from rosbags.rosbag1.reader import Header, read_bytes, read_uint32, RecordType

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.files.user_files import open_file
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.recordings.cdr import Decoder, Message, MessageBlock
from gearbox_monitor.recordings.guess import Answers, Guess, guessed, NO_ANSWERS, Unsettled
from gearbox_monitor.recordings.joint_input import find_topic, is_called, Joiner, only_topic
from gearbox_monitor.recordings.mapping import (
    load_mapping, Mapping as TableMapping, mapping_of)
from gearbox_monitor.recordings.read import (
    BagReader, blocks_of, CONTROLLER, DYNAMIC, FORMATS, Frames, frames_of, is_ros1, JOINT_STATE,
    open_bag, ROS1, ROS1_TEXT, VirtualBag)
from gearbox_monitor.recordings.roles import BESIDE, file_in, NONE, with_setpoints
from gearbox_monitor.recordings.si_signals import (
    bag_of_table, even_stamps, JOINT_TOPIC, SETPOINT_TOPIC, Signals, signals_of)
from gearbox_monitor.recordings.table import load_table, Table
from gearbox_monitor.recordings.topics import JOINT_SETPOINTS, JOINT_STATES
from gearbox_monitor.signals.stamps import unstamped

STATES = (JOINT_STATE, DYNAMIC, CONTROLLER)  # the most trusted first
MULTI = 'sensor_msgs/msg/MultiDOFJointState'
ABSOLUTE = 'absolute_position'  # of an encoder behind the gear
SETPOINT = 'setpoint'
OF_STATE = ('position', 'velocity', 'effort')
STAMPS = ('recorded', 'received', 'even')
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

    def blocks(self, topics: Iterable[str] | None = None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        try:
            yield from blocks_of(names, self._messages({
                c.id: c.topic for c in self._file.connections if c.topic in names}))
        except (ReaderError, OSError, LookupError, ValueError, EOFError, RuntimeError) as error:
            raise self._damaged(error) from None

    def _messages(self, topics: Mapping[int, str]) -> Iterator[Message]:
        """Yield the messages of the connections {number: topic} by time."""
        chunks = sorted(self._file.chunk_infos, key=lambda info: info.start_time)
        waiting: list[Message] = []
        for info, following in zip(chunks, [*(c.start_time for c in chunks[1:]), 1 << 63]):
            if not topics.keys().isdisjoint(info.connection_counts):
                waiting += _records(self._file.unpacked(info.pos), topics)
                waiting.sort(key=lambda message: message[1])
            done = bisect_left(waiting, following, key=lambda message: message[1])
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
    stream = BytesIO(data)
    while stream.tell() < len(data):
        header = Header.read(stream)
        raw = read_bytes(stream, read_uint32(stream))
        if header.get_uint8('op') == RecordType.MSGDATA and header.get_uint32('conn') in topics:
            log_ns = header.get_time('time')
            yield topics[header.get_uint32('conn')], log_ns, log_ns, raw


# --- one topic ----------------------------------------------------------------------------------
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

    def __post_init__(self) -> None:
        self.decode = self._decoder(())

    @property
    def kind(self) -> str:
        """Type of the messages as ROS 2 names it."""
        return _ros2_name(self.reader.topics[self.name][0])

    @property
    def quantities(self) -> set[str]:
        """What is used of its interfaces."""
        used = self.interfaces & {*OF_STATE, ABSOLUTE, SETPOINT}
        return used | ({'effort'} if 'torque' in self.interfaces else set())

    def _decoder(self, names: Sequence[str]) -> Decoder:
        """Return what turns its messages of joint states into columns of the joints `names`."""
        kind = self.reader.topics[self.name][0]
        return Decoder(names, partial(self.reader.decode, kind),
                       f'{self.reader.path}: topic {self.name}: ', self.reader.is_ros1(kind))

    def survey(self, block: MessageBlock) -> None:
        """Note what the messages of `block` name."""
        self.count += len(block)
        if self.kind == JOINT_STATE:
            self.is_stamped |= bool(self.decode(block).stamp_ns.any())
            self.joints.update(self.decode.joints)
            self.interfaces |= {SETPOINT} if self.is_setpoint else {*OF_STATE}
            return
        for part in self._interfaces(block):
            self.joints.update(dict.fromkeys(part.joints))
            self.interfaces |= set(part.values)
            self.is_stamped |= bool(part.stamp_ns.any())

    def columns(self, block: MessageBlock) -> Iterator[Frames]:
        """Yield the columns of `block`, of all joints that the survey has seen."""
        if self.kind != JOINT_STATE:
            yield from self._interfaces(block)
            return
        if not self.decode.names:
            self.decode = self._decoder(list(self.joints))
        states = self.decode(block).of_named()
        values = {SETPOINT: states.position} if self.is_setpoint else {
            name: getattr(states, name) for name in OF_STATE}
        yield from frames_of(self.name, states.names, states.named,
                             (states.stamp_ns, states.log_ns), values)

    def _interfaces(self, block: MessageBlock) -> Iterator[Frames]:
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
            yield Frames(self.name, joints, np.array(stamps), np.array(logged), {
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
    declared = {kind for kind, count in reader.topics.values() if count}
    return JOINT_STATE not in declared and any(
        _ros2_name(kind) in (*STATES, MULTI) or kind.startswith('foxglove') for kind in declared)


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
            whole = _joined(chain(*frames()))
            pairs = [even_stamps(path, f.stamp_ns if f.stamp_ns.any() else f.log_ns)
                     for f in whole]
            notes += dict.fromkeys(note for _, remarks in pairs for note in remarks)
            frames = partial(lambda parts: iter([parts]), [
                replace(f, stamp_ns=times, log_ns=np.maximum.accumulate(times))
                for f, (times, _) in zip(whole, pairs)])
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
    for block in reader.blocks([own.name for own in topics]):
        frames: list[Frames] = []
        for own in topics:
            for part in own.columns(block.of(own.name)):
                part = replace(part, stamp_ns=part.log_ns) if received else part
                effort = 'effort' if 'effort' in part.values else 'torque'
                frames += _selected(part, JOINT_TOPIC, own.states, {
                    'position': 'position', 'velocity': 'velocity', 'effort': effort}, ABSOLUTE)
                frames += _selected(part, SETPOINT_TOPIC, own.setpoints, {'position': SETPOINT})
        if frames:
            yield frames


def _selected(part: Frames, topic: str, joints: Sequence[str], fields: Mapping[str, str],
              behind: str = '') -> list[Frames]:
    """
    Return the columns of `joints` in `part` for a `topic` with `fields` {field: its name}.

    behind: positions of encoders behind the gear, which become joints JOINT_absolute.
    """
    rows = [k for k, joint in enumerate(part.joints) if joint in joints]
    if not rows or part.values.keys().isdisjoint((*fields.values(), behind)):
        return []
    names = [part.joints[k] for k in rows]
    none = np.full((len(part.stamp_ns), len(rows)), np.nan)
    values = {field: part.values[name][:, rows] if name in part.values else none
              for field, name in fields.items()}
    if behind in part.values:
        names += [f'{joint}_absolute' for joint in names]
        values = {field: np.hstack([
            own, part.values[behind][:, rows] if field == 'position' else none])
            for field, own in values.items()}
    return [Frames(topic, tuple(names), part.stamp_ns, part.log_ns, values)]


def _joined(frames: Iterable[Frames]) -> list[Frames]:
    """Return all `frames`, those of one topic and the same joints as one."""
    parts: dict[tuple[str, tuple[str, ...]], list[Frames]] = {}
    for frame in frames:
        parts.setdefault((frame.topic, frame.joints), []).append(frame)
    return [Frames(topic, joints, np.concatenate([f.stamp_ns for f in own]),
                   np.concatenate([f.log_ns for f in own]),
                   {field: np.concatenate([f.values[field] for f in own])
                    for field in own[0].values}) for (topic, joints), own in parts.items()]


# --- topics and their roles ---------------------------------------------------------------------
def _surveyed(reader: BagReader, topic: str, stamps: str) -> tuple[list[_Topic], list[str]]:
    """Return (the topic of the states in a bag and those of setpoints; notes)."""
    names, notes = _chosen_topics(reader, topic)
    topics = [_Topic(reader, name, k > 0) for k, name in enumerate(names)]
    for block in reader.blocks(names):
        for own in topics:
            own.survey(block.of(own.name))
    notes += [reader.notice] if reader.notice else []
    state, taken = topics[0], set[str]()
    if not state.count:
        raise _without_joints(reader, topic)
    for own in topics:
        unused = own.interfaces - own.quantities - {'torque'}
        if {'effort', 'torque'} <= own.interfaces:
            unused.add('torque')
        if unused:
            notes.append(f'{own.name}: interfaces that are not used: '
                         f'{", ".join(sorted(unused))[:300]}')
        if own is state and own.quantities - {SETPOINT}:
            own.states += own.joints
        elif own.quantities - {SETPOINT}:
            notes.append(f'{own.name}: states of {", ".join(own.joints)} left out: those of '
                         f'{state.name} count')
        if SETPOINT in own.quantities:
            own.setpoints += [joint for joint in own.joints if joint not in taken]
            taken.update(own.setpoints)
    topics = [own for own in topics if own.states or own.setpoints]
    if not topics:
        raise InputError(f'{reader.path}: messages of joints on {", ".join(names)} without '
                         f'values, expected one of {", ".join((*OF_STATE, SETPOINT))}')
    blank = next((own for own in topics if not own.is_stamped), None)
    if blank is not None and stamps == 'recorded':
        raise Undecided(f'{reader.path}: {unstamped(blank.count)}')
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


def _chosen_topics(reader: BagReader, topic: str) -> tuple[list[str], list[str]]:
    """
    Return (the topic of the states, then those of setpoints; notes).

    The states are those of `topic`, else of joint_states in whatever namespace, else of the only
    topic of the most trusted type. Setpoints are those of joint_setpoints and of controllers.
    """
    of_joints = {kind: sorted(name for name, (declared, count) in reader.topics.items()
                              if count and _ros2_name(declared) == kind) for kind in STATES}
    topics = [name for names in of_joints.values() for name in names]
    setpoints = [name for name in of_joints[JOINT_STATE] if is_called(name, JOINT_SETPOINTS)]
    candidates = [name for name in topics if is_called(name, topic or JOINT_STATES) and (
        topic or name in of_joints[JOINT_STATE])]
    if not topic and not candidates:
        candidates = next(filter(None, (
            [name for name in of_joints[kind] if name not in setpoints] for kind in STATES)), [])
    if topic and topics and not candidates:
        raise InputError(f'{reader.path}: --topic {topic}: no topic of joints, expected one of '
                         + ', '.join(topics))
    if not candidates:
        raise _without_joints(reader, topic)
    state = only_topic(reader, candidates)
    same = [name for name in setpoints if name.rpartition('/')[0] == state.rpartition('/')[0]]
    names = [state, *(name for name in (
        *(same or setpoints * (len(setpoints) == 1)), *of_joints[CONTROLLER]) if name != state)]
    return names, [f'{name}: {reader.count(name)} messages left out; the states are those of '
                   f'{state} (--topic)' for name in topics if name not in names]


# --- motor and arm from two topics --------------------------------------------------------------
Reading: TypeAlias = tuple[float, float]  # position, effort
NOT_MEASURED: Reading = (np.nan, np.nan)


def paired_bag(reader: BagReader, parameters: EstimatorParameters, topic: str) -> VirtualBag:
    """
    Return a bag of the samples that a live estimator joins of the messages on two topics.

    Args:
        reader: of the recorded bag.
        parameters: names of the joints, topic of the arm and tolerance of stamps.
        topic: of the motor, see find_topic.

    Raises:
        InputError: a topic or joint is missing.
    """
    motor, arm = find_topic(reader, topic), parameters.arm_topic
    namespace = motor.rsplit('/', 1)[0]
    if not arm:
        raise InputError("arm_topic: '', expected the topic of the arm in the parameter file")
    arm = arm if arm.startswith('/') else f'{namespace}/{arm}'
    reader.require(arm, JOINT_STATE)
    joints, sources = (parameters.motor_joint, parameters.arm_joint), (motor, arm)

    def chunks() -> Iterator[list[Frames]]:
        joiner = Joiner[Reading](round(parameters.pair_tolerance * 1e9))
        decoders = [reader.decoder(name, (joint,)) for name, joint in zip(sources, joints)]
        for block in reader.blocks(dict.fromkeys(sources)):
            samples = list(_joined_samples(block, sources, decoders, joiner))
            if samples:
                logged, stamps, *sides = zip(*samples)
                values = np.array([(m, a or NOT_MEASURED) for m, a in zip(*sides)])
                yield [Frames(f'{namespace}/{JOINT_STATES}', joints, np.array(stamps, np.int64),
                              np.array(logged, np.int64),
                              {'position': values[..., 0], 'effort': values[..., 1]})]
        for name, joint, decoder in zip(sources, joints, decoders):
            reader.require_joints(name, (joint,), decoder.joints)
        nearest = joiner.pop_distance()
        bag.notes += (f'{joiner.unpaired} samples without the arm; {joiner.dropped} messages of '
                      'the arm omitted' + (
                          f'; the nearest unpaired stamps are {nearest * 1e-9:.6f} s apart, '
                          f'pair_tolerance is {parameters.pair_tolerance:g} s' if nearest
                          else ''),)
    bag = VirtualBag(reader.path, {f'{namespace}/{JOINT_STATES}': reader.count(motor)}, chunks, (
        reader.start_ns or 0, reader.end_ns or 0), [reader.notice] if reader.notice else [])
    return bag


def _joined_samples(block: MessageBlock, sources: Sequence[str], decoders: Sequence[Decoder],
                    joiner: Joiner[Reading]
                    ) -> Iterator[tuple[int, int, Reading, Reading | None]]:
    """Yield (log time, stamp, motor, arm) of the samples that `block` completes."""
    readings: list[tuple[int, int, int, Reading]] = []  # row in the block, side, stamp, values
    for side, (topic, decode) in enumerate(zip(sources, decoders)):
        states = decode(block.of(topic))
        named = states.named[:, 0]
        rows = np.flatnonzero(block.topic == block.topics.index(topic))[named]
        readings += zip(rows.tolist(), [side] * len(rows), states.stamp_ns[named].tolist(),
                        zip(states.position[named, 0].tolist(), states.effort[named, 0].tolist()))
    for row, side, stamp_ns, values in sorted(readings, key=lambda reading: reading[:2]):
        for sample in (joiner.motor, joiner.arm)[side](stamp_ns, values):
            yield int(block.log_ns[row]), *sample


MAGIC = (b'\x89MCAP0\r\n', b'SQLite format 3\x00', ROS1)


@dataclass(frozen=True)
class ReadOptions:
    """
    How a user says that a recording is read.

    map: mapping file, or the name of a packaged one; settings: ``KEY=VALUE`` that replace values
    of it; answers: to the questions of a guess, where there is no mapping. conventions:
    ``JOINT=RULE`` by which joints of a robot count unlike its description.
    """

    map: str = ''
    settings: tuple[str, ...] = ()
    answers: Answers = NO_ANSWERS
    conventions: tuple[str, ...] = ()


BY_NAMES = ReadOptions()


def is_bag(path: Path) -> bool:
    """Return whether `path` is a ROS bag: a folder with one, or a file of a ROS 1 or 2 bag."""
    if path.is_dir():
        return any(file.name == 'metadata.yaml' or any(part in FORMATS for part in file.suffixes)
                   for file in path.iterdir())
    if any(part in FORMATS for part in path.suffixes):
        return True
    try:
        with open_file(path) as stream:
            return stream.read(16).startswith(MAGIC)
    except OSError:
        return False


def open_recording(path: str | Path, reading: ReadOptions = BY_NAMES, topic: str = ''
                   ) -> BagReader:
    """
    Return a recording of any kind as a bag.

    Args:
        path: of a bag, a table or a folder with one of them.
        reading: how the user says that it is read.
        topic: of the joint states, where a bag has to be converted; '' for the usual one.

    Raises:
        InputError: it cannot be read; Undecided: something about it is open.
    """
    path, topic = Path(path), '' if topic == JOINT_STATES else topic
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a recording')
    if is_bag(path):
        return _opened_bag(path, reading, topic)
    table, mapping, _ = read_mapping(path, reading, False)  # a model may have the constants
    return bag_of_table(table, mapping)


def _opened_bag(path: Path, reading: ReadOptions, topic: str) -> BagReader:
    stamps = reading.answers.stamps or 'recorded'
    if reading != ReadOptions(answers=Answers(stamps=reading.answers.stamps)):
        raise InputError(f'{path}: a bag, which states what its columns are, expected no --map, '
                         '--set, --use, --unit and the like')
    if is_ros1(path) or stamps != 'recorded':
        return converted_bag(path, topic, stamps)
    reader = open_bag(path)
    if not needs_conversion(reader):
        return reader
    reader.close()
    return converted_bag(path, topic)


def read_mapping(path: Path, reading: ReadOptions = BY_NAMES, constants: bool = True
                 ) -> tuple[Table, TableMapping, Guess | None]:
    """
    Return (table, how it is read, what was guessed of it) of a file that is no bag.

    Args:
        path: of the file, or of a folder with one.
        reading: how the user says that it is read.
        constants: whether a current needs a constant here.

    Raises:
        InputError: it cannot be read; Undecided: something about it is open.
    """
    path = file_in(path)
    if reading.map:
        if reading.answers != NO_ANSWERS:
            raise InputError('--map: with --use, --unit and the like, expected --set KEY=VALUE of '
                             'the mapping, or no --map')
        data, source = load_mapping(reading.map, reading.settings)
        mapping_of(data, source, None)  # its own problems before those of the file
        table = load_table(path)
        if BESIDE in str(data.get('joints')):
            table = with_setpoints(table)
        return table, mapping_of(data, source, table.header), None
    if reading.answers.stamps == 'received':
        raise InputError(f'--stamps received: {path} is no bag, expected recorded or even')
    table = load_table(path)
    if reading.answers.use.get('setpoint') != NONE:
        table = with_setpoints(table)
    guess = guessed(table, reading.settings, reading.answers, constants)
    if guess.questions:
        raise Unsettled(guess)
    table = replace(table, notes=(*table.notes, *guess.notes))
    return table, mapping_of(guess.data, f'guess of {path.name}', table.header), guess


def read_signals(path: str | Path, reading: ReadOptions = BY_NAMES) -> Signals:
    """Return the Signals in the file `path`, which is no bag, as `reading` has it."""
    table, mapping, _ = read_mapping(Path(path), reading)
    return signals_of(table, mapping)
