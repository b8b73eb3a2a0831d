# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Joint states of bags of other robots: ROS 1 bags, and messages of ros2_control.

All become sensor_msgs/JointState, setpoints on a topic of their own. Messages that name other
joints than those of another publisher stay apart. Of one joint one topic tells the state, and one
the setpoint; the notes list the others.
"""
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.importer import ImportedRecording
from gearbox_monitor.recordings.importer.clocks import interpolated
from gearbox_monitor.recordings.importer.message_topics import chosen_topics, DYNAMIC, STATES
from gearbox_monitor.recordings.importer.robot_recording import (
    JOINT_TOPIC, RobotRecording, Topic, write_topics)
from gearbox_monitor.recordings.importer.stamp_policy import even_stamps
from gearbox_monitor.recordings.read import FORMATS, is_ros1, JOINT_STATE, open_bag

MULTI = 'sensor_msgs/msg/MultiDOFJointState'
# Definitions of messages that SQLite bags often lack.
DEFINITIONS = {
    'control_msgs/msg/InterfaceValue': 'string[] interface_names\nfloat64[] values\n',
    DYNAMIC: 'std_msgs/Header header\nstring[] joint_names\n'
             'control_msgs/InterfaceValue[] interface_values\n',
}
SETPOINT = 'setpoint'
QUANTITIES = ('position', 'velocity', 'effort', SETPOINT)
OF_STATE = QUANTITIES[:3]
STAMPS = ('recorded', 'received', 'even')


@dataclass(frozen=True)
class JointMessages:
    """
    Messages [N] that name the same J joints: header stamps and times of receipt in ns, values.

    values {quantity: [N, J]}, NaN where a message has none. topic: that all of them are from;
    kind: its type.
    """

    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]
    topic: str = ''
    kind: str = JOINT_STATE

    def only(self, joints: Sequence[str], quantities: Sequence[str]) -> 'JointMessages':
        """Return the messages with no more than these joints and quantities."""
        columns = [self.joints.index(joint) for joint in joints]
        return replace(self, joints=tuple(joints), values={
            name: values[:, columns] for name, values in self.values.items()
            if name in quantities})


def is_bag(path: str | Path) -> bool:
    """Return whether `path` is a ROS bag: a folder with one, or a file of a ROS 1 or 2 bag."""
    path = Path(path)
    if path.is_dir():
        return any(file.suffix in FORMATS or file.name == 'metadata.yaml' or any(
            part in FORMATS for part in file.suffixes) for file in path.iterdir())
    return path.suffix in FORMATS or is_ros1(path)


def read_bag(path: str | Path, topic: str = '') -> tuple[list[JointMessages], list[str]]:
    """
    Return the joint messages of a bag and notices about them.

    Args:
        path: of the bag.
        topic: of the joint states; '' for joint_states, or the only topic of them.

    Returns:
        JointMessages by joints that are named together, either their states or their setpoints,
        of each joint from one topic; sentences for the user.

    Raises:
        InputError: the bag holds no joint states, or none that can be read.
        Undecided: several topics tell the state of a joint, and none is called joint_states.
    """
    path = Path(path)
    rows: dict[tuple[str, ...], list[tuple[int, int, dict[str, list[float]]]]] = {}
    with _opened(path) as bag:
        choice = chosen_topics(path, bag.topics, topic)
        for name, log_ns, message in bag.messages(choice.names) if choice.names else ():
            joints, values = _values_of(bag.topics[name][0], message)
            if name in choice.setpoints:
                values = {SETPOINT: values['position']} if 'position' in values else {}
            stamp = message.header.stamp
            stamp_ns = int(getattr(stamp, 'sec', 0)) * 1_000_000_000 + int(
                getattr(stamp, 'nanosec', getattr(stamp, 'nsec', 0)))
            rows.setdefault((name, *joints), []).append((stamp_ns, log_ns, values))
    kinds = {name: kind for name, (kind, _) in bag.topics.items()}
    if not rows or topic and choice.names[0] not in {key[0] for key in rows}:
        multi = [name for name, kind in kinds.items() if kind == MULTI]
        if multi:
            raise InputError(f'{path}: {multi[0]} has type {MULTI}: poses of bodies, not '
                             'positions of joints, expected sensor_msgs/msg/JointState')
        raise InputError(f'{path}: no messages of joints on {topic or "any topic"}, expected '
                         f'{", ".join(STATES)}; the bag has '
                         f'{", ".join(f"{n} ({k})" for n, k in sorted(kinds.items())) or "none"}')
    parts = []
    for (name, *names), messages in rows.items():
        columns: dict[str, Array] = {
            quantity: np.array([row[2].get(quantity) or [np.nan] * len(names)
                                for row in messages], float)
            for quantity in QUANTITIES if any(quantity in row[2] for row in messages)}
        parts.append(JointMessages(tuple(names), np.array([row[0] for row in messages]),
                                   np.array([row[1] for row in messages]), columns, name,
                                   kinds[name]))
    parts.sort(key=lambda part: choice.names.index(part.topic))
    notices = [*([bag.notice] if bag.notice else []), *choice.notices]
    result = _one_source_each(path, parts, bool(topic), notices)
    if not result:
        raise InputError(f'{path}: messages of joints on {", ".join(choice.names)} '
                         f'without values, expected one of {", ".join(QUANTITIES)}')
    return result, notices


def _one_source_each(path: Path, parts: Sequence[JointMessages], is_asked: bool,
                     notices: list[str]) -> list[JointMessages]:
    """
    Return states and setpoints of `parts`, the most trusted first, of each joint from one topic.

    Where a user has asked for the topic, the states are those of the first one alone. Raises
    Undecided: two topics of one type tell the state of a joint.
    """
    sources: dict[tuple[str, str], JointMessages] = {}
    result: list[JointMessages] = []
    dropped: dict[tuple[str, str, str], list[str]] = {}
    for part in parts:
        for content, quantities in (('states', OF_STATE), ('setpoints', (SETPOINT,))):
            if not set(quantities) & set(part.values):
                continue
            own = []
            for joint in part.joints:
                is_set = is_asked and content == 'states'
                source = sources.setdefault((content, joint), parts[0] if is_set else part)
                if source.topic == part.topic:
                    own.append(joint)
                elif content == 'states' and source.kind == part.kind and not is_asked:
                    raise Undecided(f'{path}: {source.topic}, {part.topic}: {part.kind} of '
                                    f'{joint}, expected the topic that tells its state: --topic '
                                    f'{source.topic} or --topic {part.topic}')
                else:
                    dropped.setdefault((part.topic, content, source.topic), []).append(joint)
            if own:
                result.append(part.only(own, quantities))
    notices += [f'{topic}: {content} of {", ".join(dict.fromkeys(joints))} left out: those of '
                f'{source_topic} count' for (topic, content, source_topic), joints in
                dropped.items()]
    return result


@dataclass(frozen=True)
class _Bag:
    """An open bag: topics {topic: (type, number of messages)}, and a sentence about it."""

    topics: Mapping[str, tuple[str, int]]
    messages: Callable[[Sequence[str]], Iterator[tuple[str, int, Any]]]
    notice: str = ''


@contextmanager
def _opened(path: Path) -> Iterator[_Bag]:
    """Open a bag, whose `messages(topics)` are (topic, log time in ns, message)."""
    if path.is_file() and path.suffix not in FORMATS:
        with _opened_ros1(path) as bag:
            yield bag
        return
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, definition in DEFINITIONS.items():
        store.register(get_types_from_msg(definition, name))
    with open_bag(path) as reader:
        def _messages(topics: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
            for name, log_ns, _, raw in reader.messages(topics):
                kind = reader.topics[name][0]
                try:
                    message = reader.decode(kind, raw)
                except InputError:
                    if kind != DYNAMIC:
                        raise
                    message = store.deserialize_cdr(raw, DYNAMIC)
                yield name, log_ns, message
        yield _Bag(reader.topics, _messages, reader.notice)


@contextmanager
def _opened_ros1(path: Path) -> Iterator[_Bag]:
    """Open a bag of ROS 1."""
    from rosbags.highlevel import AnyReader
    try:
        with AnyReader([path]) as reader:
            topics: dict[str, tuple[str, int]] = {}
            for c in reader.connections:
                topics[c.topic] = c.msgtype, topics.get(c.topic, ('', 0))[1] + c.msgcount

            def _messages(chosen: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
                for c, log_ns, raw in reader.messages(
                        [c for c in reader.connections if c.topic in chosen]):
                    yield c.topic, log_ns, reader.deserialize(raw, c.msgtype)
            yield _Bag(topics, _messages)
    except InputError:
        raise
    except Exception as error:  # the library raises many kinds for damaged bags
        raise InputError(f'{path}: {type(error).__name__} {error}, expected a whole ROS 1 '
                         'bag') from None


def _values_of(kind: str, message: Any) -> tuple[tuple[str, ...], dict[str, list[float]]]:
    """Return (joints, {quantity: values}) of a message of one of STATES."""
    if kind == JOINT_STATE:
        joints = tuple(message.name)
        return joints, {name: list(getattr(message, name)) for name in OF_STATE
                        if len(getattr(message, name)) == len(joints)}
    joints = tuple(message.joint_names)
    if kind == DYNAMIC:
        tables = [dict(zip(part.interface_names, part.values))
                  for part in message.interface_values]
        names = set().union(*tables) & set(OF_STATE) if tables else set()
        return joints, {name: [table.get(name, np.nan) for table in tables] for name in names}
    old = not hasattr(message, 'feedback')  # names of control_msgs before 2023
    feedback = message.actual if old else message.feedback
    reference = message.desired if old else message.reference
    output = getattr(message, 'output', None)
    values = {'position': list(feedback.positions), 'velocity': list(feedback.velocities),
              'effort': list(feedback.effort) or list(getattr(output, 'effort', ())),
              SETPOINT: list(reference.positions)}
    return joints, {name: column for name, column in values.items()
                    if len(column) == len(joints)}


def restamped(path: str | Path, part: JointMessages, stamps: str) -> tuple[Integers, list[str]]:
    """
    Return the stamps of the messages `part` of a bag as `stamps` asks, and notices.

    path: of the bag, for messages. stamps: one of STAMPS. Raises Undecided where all header
    stamps are 0 and nothing is asked.
    """
    if stamps == 'received':
        return part.log_ns, ['time: the times of receipt stand in for the header stamps']
    if stamps == 'even':
        source = part.log_ns if not part.stamp_ns.any() else part.stamp_ns
        return even_stamps(path, source)
    if not part.stamp_ns.any():
        raise Undecided(f'{path}: all {len(part.stamp_ns)} header stamps are 0: the driver does '
                        'not stamp its messages, expected --stamps received (the times of receipt '
                        'in the bag), or --stamps even')
    return part.stamp_ns, []


def import_bag(source: str | Path, bag: str | Path, topic: str = '', stamps: str = STAMPS[0],
               joint: str | None = None) -> dict[str, Any]:
    """
    Write the joints of a bag as joint_states, and joint_setpoints where they are recorded.

    Args:
        source: the bag, of ROS 1 or 2.
        bag: the new bag.
        topic: of the joint states; '' for joint_states, or the only topic of them.
        stamps: one of STAMPS.
        joint: the only joint that is written, as motor; None: all.

    Returns:
        {name: value} for JSON: samples, duration_s, rate_hz, joints, notes.

    Raises:
        InputError: see read_bag, or the joint has no position; Undecided: see read_bag and
            restamped.
    """
    parts, notices = read_bag(source, topic)
    joints = list(dict.fromkeys(name for part in parts for name in part.joints))
    if joint is not None and joint not in joints:
        raise InputError(f'{source}: --joint {joint}: expected one of {", ".join(joints)}')
    stamped: list[tuple[JointMessages, Integers]] = []
    for part in parts:
        if joint is None or joint in part.joints:
            times, notes = restamped(source, part, stamps)
            notices += [note for note in notes if note not in notices]
            stamped.append((part, times))
    topics = [topic_of_bag for part, times in stamped for topic_of_bag in (
        RobotRecording(part.joints, times, part.values).messages() if joint is None else
        _as_drive(part, times, joint, stamped))]
    if not topics:
        measured = sorted({name for part, _ in stamped for name in part.values})
        raise InputError(f'{source}: --joint {joint}: {", ".join(measured)} without a position, '
                         'expected its position (without --joint all joints are written)')
    publishers = [part for part in parts if SETPOINT not in part.values]
    if len(publishers) > 1:
        notices.append(f'{len(publishers)} publishers: ' + '; '.join(
            f'{len(part.stamp_ns)} messages of {", ".join(part.joints)}'[:120]
            for part in publishers))
    write_topics(bag, source, topics, notices)
    states = [times for name, times, _ in topics if name == JOINT_TOPIC] or [topics[0][1]]
    count = sum(map(len, states))
    seconds = (max(int(times[-1]) for times in states) - min(
        int(times[0]) for times in states)) * 1e-9
    return {'bag': str(bag), 'samples': count, 'duration_s': seconds,
            'rate_hz': (count - 1) / seconds if seconds > 0.0 else None,
            'signals': [joint] if joint is not None else joints, 'assumptions': [],
            'notes': notices}


def _as_drive(part: JointMessages, times: Integers, joint: str,
              stamped: Sequence[tuple[JointMessages, Integers]]) -> Iterator[Topic]:
    """Yield the topic of one joint as the motor of a drive, with its setpoint."""
    k, none = part.joints.index(joint), np.full(len(times), np.nan)
    position, velocity, effort = (part.values[name][:, k] if name in part.values else none
                                  for name in OF_STATE)
    if not np.isfinite(position).any():
        return
    setpoint = none
    for source, own in stamped:
        if SETPOINT in source.values and joint in source.joints:
            setpoint = source.values[SETPOINT][:, source.joints.index(joint)]
            if not np.array_equal(times, own):
                setpoint = interpolated(times, own, setpoint)
            break
    yield from ImportedRecording(times, position, effort, none, none, None, velocity, none,
                                 setpoint).messages()
