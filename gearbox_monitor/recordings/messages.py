# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Joint states of bags of other robots: ROS 1 bags, and messages of ros2_control.

All become sensor_msgs/JointState, setpoints on a topic of their own. Of one joint one topic tells
the state, and one the setpoint; the notes list the others, and interfaces that are not used.
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
from gearbox_monitor.recordings.clocks import interpolated
from gearbox_monitor.recordings.read import BagReader, is_ros1, JOINT_STATE, open_bag
from gearbox_monitor.recordings.si_signals import even_stamps
from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.recordings.virtual_bag import Frames, JOINT_TOPIC, SETPOINT_TOPIC, VirtualBag

DYNAMIC, CONTROLLER = ('control_msgs/msg/DynamicJointState',
                       'control_msgs/msg/JointTrajectoryControllerState')
STATES = (JOINT_STATE, DYNAMIC, CONTROLLER)  # the most trusted first
MULTI = 'sensor_msgs/msg/MultiDOFJointState'
# Definitions of messages that SQLite bags often lack.
DEFINITIONS = {
    'control_msgs/msg/InterfaceValue': 'string[] interface_names\nfloat64[] values\n',
    DYNAMIC: 'std_msgs/Header header\nstring[] joint_names\n'
             'control_msgs/InterfaceValue[] interface_values\n',
}
SETPOINT, ABSOLUTE = 'setpoint', 'absolute_position'  # of an encoder behind the gear
OF_STATE = ('position', 'velocity', 'effort')
STAMPS = ('recorded', 'received', 'even')


@dataclass(frozen=True)
class JointMessages:
    """
    Messages [N] on a topic that name the same J joints; stamps of header and receipt in ns.

    values {quantity: [N, J]}, NaN where a message has none; kind: type of the messages.
    """

    topic: str
    kind: str
    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]

    def only(self, joints: Sequence[str], quantities: Sequence[str]) -> 'JointMessages':
        """Return the messages with no more than these joints and quantities."""
        columns = [self.joints.index(joint) for joint in joints]
        return replace(self, joints=tuple(joints), values={
            name: values[:, columns] for name, values in self.values.items()
            if name in quantities})


def needs_conversion(reader: BagReader) -> bool:
    """Return whether a bag of ROS 2 has joints, but on no topic of sensor_msgs/JointState."""
    kinds = {_ros2_name(kind) for kind, count in reader.topics.values() if count}
    return JOINT_STATE not in {kind for kind, count in reader.topics.values() if count} and bool(
        kinds & {*STATES, MULTI} or any(kind.startswith('foxglove') for kind in kinds))


def converted_bag(path: Path, topic: str = '', stamps: str = STAMPS[0],
                  joint: str | None = None) -> VirtualBag:
    """
    Return the joints of a bag as joint_states, and joint_setpoints where they are recorded.

    Args:
        path: of the bag, of ROS 1 or 2.
        topic: of the joint states; '' for joint_states, or the only topic of them.
        stamps: one of STAMPS.
        joint: the only joint that is read, as motor; None: all.

    Raises:
        InputError: the bag holds no joint states, or none that can be read.
        Undecided: several topics tell the state of a joint, or all stamps are 0.
    """
    parts, notes = _joint_messages(path, topic)
    frames = []
    joints = list(dict.fromkeys(name for part in parts for name in part.joints))
    if joint is not None and joint not in joints:
        raise InputError(f'{path}: --joint {joint}: expected one of {", ".join(joints)}')
    for part in parts:
        if joint is not None and joint not in part.joints:
            continue
        times, remarks = _restamped(path, part, stamps)
        notes += [note for note in remarks if note not in notes]
        log_ns = np.maximum.accumulate(times) if stamps != 'recorded' else part.log_ns
        values = part.values
        frames.append(Frames(SETPOINT_TOPIC, part.joints, times, log_ns, values[SETPOINT])
                      if SETPOINT in values else Frames(
            JOINT_TOPIC, part.joints, times, log_ns, values.get('position', np.full(
                (len(times), len(part.joints)), np.nan)), values.get('velocity'),
            values.get('effort')))
    if joint is not None:
        frames = _as_drive(path, frames, joint)
    publishers = [part for part in parts if SETPOINT not in part.values]
    if len(publishers) > 1:
        notes.append(f'{len(publishers)} publishers: ' + '; '.join(
            f'{len(part.stamp_ns)} messages of {", ".join(part.joints)}'[:120]
            for part in publishers))
    counts: dict[str, int] = {}
    for frame in frames:
        counts[frame.topic] = counts.get(frame.topic, 0) + len(frame.stamp_ns)
    return VirtualBag(path, counts, lambda: iter([frames]), (
        min(int(f.log_ns[0]) for f in frames), max(int(f.log_ns[-1]) for f in frames)), notes)


def _as_drive(path: Path, frames: Sequence[Frames], joint: str) -> list[Frames]:
    """Return the messages of one joint as the motor of a drive, with its setpoint."""
    states = [f for f in frames if f.topic == JOINT_TOPIC and joint in f.joints]
    if not states or states[0].position is None or not np.isfinite(
            states[0].position[:, states[0].joints.index(joint)]).any():
        raise InputError(f'{path}: --joint {joint}: no position in the bag, expected its position '
                         '(without --joint all joints are written)')
    own = states[0]
    k, none = own.joints.index(joint), np.full(len(own.stamp_ns), np.nan)
    position, velocity, effort = (none if x is None else x[:, k] for x in (
        own.position, own.velocity, own.effort))
    names, columns = ['motor', 'arm'], [position, none]
    for other in frames:
        if other.topic == SETPOINT_TOPIC and joint in other.joints and (
                other.position is not None):
            setpoint = other.position[:, other.joints.index(joint)]
            names.append('setpoint')
            columns.append(setpoint if np.array_equal(other.stamp_ns, own.stamp_ns) else
                           interpolated(own.stamp_ns, other.stamp_ns, setpoint))
            break
    rest = [none] * (len(names) - 1)
    return [Frames(JOINT_TOPIC, tuple(names), own.stamp_ns, own.log_ns, np.column_stack(columns),
                   None if np.isnan(velocity).all() else np.column_stack([velocity, *rest]),
                   np.column_stack([effort, *rest]))]


def _joint_messages(path: Path, topic: str) -> tuple[list[JointMessages], list[str]]:
    """Return (messages by topic and joints, each joint's state from one topic; notes)."""
    rows: dict[tuple[str, ...], list[tuple[int, int, dict[str, list[float]]]]] = {}
    unused: dict[str, set[str]] = {}
    with _opened(path) as bag:
        names, setpoints, notes = _chosen_topics(path, bag.topics, topic)
        for name, log_ns, message in bag.messages(names) if names else ():
            joints, values, left = _values_of(bag.topics[name][0], message)
            if left:
                unused.setdefault(name, set()).update(left)
            if name in setpoints:
                values = {SETPOINT: values['position']} if 'position' in values else {}
            stamp = message.header.stamp
            stamp_ns = int(getattr(stamp, 'sec', 0)) * 1_000_000_000 + int(
                getattr(stamp, 'nanosec', getattr(stamp, 'nsec', 0)))
            rows.setdefault((name, *joints), []).append((stamp_ns, log_ns, values))
        kinds = {name: kind for name, (kind, _) in bag.topics.items()}
        notes += [bag.notice] if bag.notice else []
    if not rows or topic and names[0] not in {key[0] for key in rows}:
        multi = [name for name, kind in kinds.items() if kind == MULTI]
        schemas = [f'{name} ({kind})' for name, kind in kinds.items()
                   if kind.startswith('foxglove')]
        if schemas:
            raise InputError(f'{path}: {", ".join(schemas)[:200]}: schemas of Foxglove, expected '
                             f'messages of {JOINT_STATE}: record that topic')
        if multi:
            raise InputError(f'{path}: {multi[0]} has type {MULTI}: poses of bodies, not '
                             f'positions of joints, expected {JOINT_STATE}')
        raise InputError(f'{path}: no messages of joints on {topic or "any topic"}, expected '
                         f'{", ".join(STATES)}; the bag has '
                         f'{", ".join(f"{n} ({k})" for n, k in sorted(kinds.items())) or "none"}')
    parts = []
    for (name, *listed), messages in rows.items():
        quantities = dict.fromkeys(q for row in messages for q in row[2])
        columns: dict[str, Array] = {
            q: np.array([row[2].get(q) or [np.nan] * len(listed) for row in messages], float)
            for q in quantities}
        parts.append(JointMessages(
            name, kinds[name], tuple(listed), np.array([row[0] for row in messages]),
            np.array([row[1] for row in messages]), columns))
    parts.sort(key=lambda part: names.index(part.topic))
    notes += [f'{name}: interfaces that are not used: {", ".join(sorted(left))[:300]}'
              for name, left in unused.items()]
    result = _one_source_each(path, parts, bool(topic), notes)
    if not result:
        raise InputError(f'{path}: messages of joints on {", ".join(names)} without values, '
                         f'expected one of {", ".join((*OF_STATE, SETPOINT))}')
    return [_with_absolute(part) for part in result], notes


def _with_absolute(part: JointMessages) -> JointMessages:
    """Return `part` with an encoder behind the gear as a joint JOINT_absolute of its own."""
    if ABSOLUTE not in part.values:
        return part
    values = dict(part.values)
    absolute = values.pop(ABSOLUTE)
    none = np.full(absolute.shape, np.nan)
    values.setdefault('position', none)
    return replace(part, joints=(*part.joints, *(f'{j}_absolute' for j in part.joints)), values={
        name: np.hstack([x, absolute if name == 'position' else none])
        for name, x in values.items()})


def _chosen_topics(path: Path, topics: Mapping[str, tuple[str, int]], topic: str
                   ) -> tuple[list[str], set[str], list[str]]:
    """
    Return (topics to read, the most trusted first; those of setpoints among them; notes).

    Of all topics of sensor_msgs/JointState one tells the states: `topic`, else joint_states in
    whatever namespace, else the only one. Another one that is called joint_setpoints tells the
    setpoints. Topics of controllers and of dynamic joint states are all read.
    """
    of_joints = {kind: sorted(name for name, declared in topics.items()
                              if declared[0] == kind) for kind in STATES}
    with_messages = [name for name in of_joints[JOINT_STATE] if topics[name][1]]
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
    return names, set(setpoints), [f'{name}: {topics[name][1]} messages left out' + (
        f'; the states are those of {candidates[0]} (--topic)' if candidates else '')
        for name in with_messages if name not in names]


def _called(name: str, topics: Sequence[str]) -> list[str]:
    """Return the `topics` that are `name`, or else those that end with it."""
    ending = '/' + name.strip('/')
    return [topic for topic in topics if '/' + topic.strip('/') == ending] or [
        topic for topic in topics if topic.endswith(ending) and not name.startswith('/')]


def _one_source_each(path: Path, parts: Sequence[JointMessages], is_asked: bool,
                     notes: list[str]) -> list[JointMessages]:
    """
    Return states and setpoints of `parts`, the most trusted first, of each joint from one topic.

    Where a user has asked for the topic, the states are those of the first one alone. Raises
    Undecided: two topics of one type tell the state of a joint.
    """
    sources: dict[tuple[str, str], JointMessages] = {}
    result: list[JointMessages] = []
    dropped: dict[tuple[str, str, str], list[str]] = {}
    for part in parts:
        for content, quantities in (('states', (*OF_STATE, ABSOLUTE)), ('setpoints', (SETPOINT,))):
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
    notes += [f'{topic}: {content} of {", ".join(dict.fromkeys(joints))} left out: those of '
              f'{source_topic} count' for (topic, content, source_topic), joints in
              dropped.items()]
    return result


@dataclass(frozen=True)
class _Bag:
    """An open bag: topics {topic: (type, number of messages)}, and a sentence about it."""

    topics: Mapping[str, tuple[str, int]]
    messages: Callable[[Sequence[str]], Iterator[tuple[str, int, Any]]]
    notice: str = ''


def _ros2_name(kind: str) -> str:
    """Return the name of a message type of ROS 1 or 2 as ROS 2 has it."""
    return kind if kind.count('/') != 1 else kind.replace('/', '/msg/')


@contextmanager
def _opened(path: Path) -> Iterator[_Bag]:
    """Open a bag, whose `messages(topics)` are (topic, log time in ns, message)."""
    if is_ros1(path):
        with _opened_ros1(path) as bag:
            yield bag
        return
    store, old = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.ROS1_NOETIC)
    for name, definition in DEFINITIONS.items():
        store.register(get_types_from_msg(definition, name))
    with open_bag(path) as reader:
        topics = {name: (_ros2_name(kind), count) for name, (kind, count) in reader.topics.items()}

        def messages(chosen: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
            for name, log_ns, _, raw in reader.messages(chosen):
                kind = reader.topics[name][0]
                try:
                    if kind != topics[name][0]:
                        message = old.deserialize_ros1(raw, topics[name][0])
                    else:
                        message = reader.decode(kind, raw)
                except InputError:
                    if kind != DYNAMIC:
                        raise
                    message = store.deserialize_cdr(raw, DYNAMIC)
                except Exception as error:  # generated code raises many kinds for damaged bytes
                    raise InputError(f'{path}: topic {name}: {type(error).__name__} {error}, '
                                     f'expected messages of {kind}') from None
                yield name, log_ns, message
        yield _Bag(topics, messages, reader.notice)


@contextmanager
def _opened_ros1(path: Path) -> Iterator[_Bag]:
    """Open a bag of ROS 1."""
    from rosbags.highlevel import AnyReader
    try:
        with AnyReader([path]) as reader:
            topics: dict[str, tuple[str, int]] = {}
            for c in reader.connections:
                topics[c.topic] = c.msgtype, topics.get(c.topic, ('', 0))[1] + c.msgcount

            def messages(chosen: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
                for c, log_ns, raw in reader.messages(
                        [c for c in reader.connections if c.topic in chosen]):
                    yield c.topic, log_ns, reader.deserialize(raw, c.msgtype)
            yield _Bag(topics, messages)
    except InputError:
        raise
    except Exception as error:  # the library raises many kinds for damaged bags
        raise InputError(f'{path}: {type(error).__name__} {error}, expected a whole ROS 1 '
                         'bag') from None


def _values_of(kind: str, message: Any) -> tuple[tuple[str, ...], dict[str, list[float]],
                                                 set[str]]:
    """Return (joints, {quantity: values}, unused interfaces) of a message of one of STATES."""
    if kind == JOINT_STATE:
        joints = tuple(message.name)
        return joints, {name: list(getattr(message, name)) for name in OF_STATE
                        if len(getattr(message, name)) == len(joints)}, set()
    joints = tuple(message.joint_names)
    if kind == DYNAMIC:
        tables = [dict(zip(part.interface_names, part.values))
                  for part in message.interface_values]
        names: set[str] = set().union(*tables) if tables else set()
        sources = {name: name for name in (*OF_STATE, ABSOLUTE) if name in names}
        if 'effort' not in names and 'torque' in names:
            sources['effort'] = 'torque'
        return joints, {name: [table.get(source, np.nan) for table in tables]
                        for name, source in sources.items()}, names - set(sources.values())
    old = not hasattr(message, 'feedback')  # names of control_msgs before 2023
    feedback = message.actual if old else message.feedback
    reference = message.desired if old else message.reference
    output = getattr(message, 'output', None)
    values = {'position': list(feedback.positions), 'velocity': list(feedback.velocities),
              'effort': list(feedback.effort) or list(getattr(output, 'effort', ())),
              SETPOINT: list(reference.positions)}
    return joints, {name: column for name, column in values.items()
                    if len(column) == len(joints)}, set()


def _restamped(path: Path, part: JointMessages, stamps: str) -> tuple[Integers, list[str]]:
    """
    Return the stamps of the messages `part` of a bag as `stamps` asks, and notes.

    Raises Undecided where all header stamps are 0 and nothing is asked.
    """
    if stamps == 'received':
        return part.log_ns, ['time: the times of receipt stand in for the header stamps']
    if stamps == 'even':
        return even_stamps(path, part.log_ns if not part.stamp_ns.any() else part.stamp_ns)
    if not part.stamp_ns.any():
        raise Undecided(f'{path}: all {len(part.stamp_ns)} header stamps are 0: the driver does '
                        'not stamp its messages, expected --stamps received (the times of receipt '
                        'in the bag), or --stamps even')
    return part.stamp_ns, []
