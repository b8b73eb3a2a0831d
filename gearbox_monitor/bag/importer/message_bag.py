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

"""
Joint states of bags of other robots: ROS 1 bags, and messages of ros2_control.

All become sensor_msgs/JointState, setpoints on a topic of their own. Messages that name other
joints than those of another publisher stay apart.
"""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
import hashlib
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.importer.clocks import interpolated
from gearbox_monitor.bag.importer.robot_recording import JOINT_TOPIC, SETPOINT_TOPIC, Topic
from gearbox_monitor.bag.importer.robot_recording import write_in_order
from gearbox_monitor.bag.importer.stamp_policy import even_stamps
from gearbox_monitor.bag.read import FORMATS, JOINT_STATE, open_bag, ROS1
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array, Integers

DYNAMIC, CONTROLLER, MULTI = ('control_msgs/msg/DynamicJointState',
                              'control_msgs/msg/JointTrajectoryControllerState',
                              'sensor_msgs/msg/MultiDOFJointState')
# Definitions of messages that SQLite bags often lack.
DEFINITIONS = {
    'control_msgs/msg/InterfaceValue': 'string[] interface_names\nfloat64[] values\n',
    DYNAMIC: 'std_msgs/Header header\nstring[] joint_names\n'
             'control_msgs/InterfaceValue[] interface_values\n',
}
STATES = (JOINT_STATE, DYNAMIC, CONTROLLER)
QUANTITIES = ('position', 'velocity', 'effort', 'setpoint')
STAMPS = ('recorded', 'received', 'even')


@dataclass(frozen=True)
class JointMessages:
    """
    Messages [N] that name the same J joints: header stamps and times of receipt in ns, values.

    values {quantity: [N, J]}, NaN where a message has none.
    """

    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]


def is_bag(path: str | Path) -> bool:
    """Return whether `path` is a ROS bag: a folder with one, or a file of a ROS 1 or 2 bag."""
    path = Path(path)
    if path.is_dir():
        return any(file.suffix in FORMATS or file.name == 'metadata.yaml' or any(
            part in FORMATS for part in file.suffixes) for file in path.iterdir())
    if path.suffix in FORMATS:
        return True
    try:
        with path.open('rb') as stream:
            return stream.read(len(ROS1)) == ROS1
    except OSError:
        return False


def read_bag(path: str | Path, topic: str = '') -> tuple[list[JointMessages], list[str]]:
    """
    Return the joint messages of a bag and notices about them.

    Args:
        path: of the bag.
        topic: of the joint states; '' for all topics of joints.

    Returns:
        JointMessages by joints that are named together; sentences for the user.

    Raises:
        InputError: the bag holds no joint states, or none that can be read.
    """
    path = Path(path)
    notices: list[str] = []
    rows: dict[tuple[str, ...], list[tuple[int, int, dict[str, list[float]]]]] = {}
    kinds: dict[str, str] = {}
    for name, kind, log_ns, message in _messages(path, topic, kinds, notices):
        joints, values = _values_of(kind, message)
        stamp = message.header.stamp
        stamp_ns = int(getattr(stamp, 'sec', 0)) * 1_000_000_000 + int(
            getattr(stamp, 'nanosec', getattr(stamp, 'nsec', 0)))
        rows.setdefault((name, *joints), []).append((stamp_ns, log_ns, values))
    if not rows:
        multi = [name for name, kind in kinds.items() if kind == MULTI]
        if multi:
            raise InputError(f'{path}: {multi[0]} has type {MULTI}: poses of bodies, not '
                             'positions of joints, expected sensor_msgs/msg/JointState')
        raise InputError(f'{path}: no messages of joints on {topic or "any topic"}, expected '
                         f'{", ".join(STATES)}; the bag has '
                         f'{", ".join(f"{n} ({k})" for n, k in sorted(kinds.items())) or "none"}')
    result = []
    for (_, *names), messages in rows.items():
        columns: dict[str, Array] = {
            quantity: np.array([row[2].get(quantity) or [np.nan] * len(names)
                                for row in messages], float)
            for quantity in QUANTITIES if any(quantity in row[2] for row in messages)}
        result.append(JointMessages(tuple(names), np.array([row[0] for row in messages]),
                                    np.array([row[1] for row in messages]), columns))
    return result, notices


def _messages(path: Path, topic: str, kinds: dict[str, str], notices: list[str]
              ) -> Iterator[tuple[str, str, int, Any]]:
    """Yield (topic, type, log time, message) of joint messages; fill `kinds` {topic: type}."""
    if path.is_file() and path.suffix not in FORMATS:
        yield from _ros1_messages(path, topic, kinds)
        return
    with open_bag(path) as reader:
        kinds.update({name: kind for name, (kind, _) in reader.topics.items()})
        chosen = [name for name, kind in kinds.items() if kind in STATES
                  and (not topic or name.strip('/') == topic.strip('/')
                       or kind != JOINT_STATE)]
        if reader.notice:
            notices.append(reader.notice)
        store = get_typestore(Stores.ROS2_JAZZY)
        for name, definition in DEFINITIONS.items():
            store.register(get_types_from_msg(definition, name))
        for name, log_ns, _, raw in reader.messages(chosen) if chosen else ():
            try:
                message = reader.decode(kinds[name], raw)
            except InputError:
                if kinds[name] != DYNAMIC:
                    raise
                message = store.deserialize_cdr(raw, DYNAMIC)
            yield name, kinds[name], log_ns, message


def _ros1_messages(path: Path, topic: str, kinds: dict[str, str]
                   ) -> Iterator[tuple[str, str, int, Any]]:
    """Yield what _messages does, of a ROS 1 bag."""
    from rosbags.highlevel import AnyReader
    try:
        with AnyReader([path]) as reader:
            kinds.update({c.topic: c.msgtype for c in reader.connections})
            chosen = [c for c in reader.connections if c.msgtype in STATES and (
                not topic or c.topic.strip('/') == topic.strip('/')
                or c.msgtype != JOINT_STATE)]
            for connection, log_ns, raw in reader.messages(chosen) if chosen else ():
                yield (connection.topic, connection.msgtype, log_ns,
                       reader.deserialize(raw, connection.msgtype))
    except InputError:
        raise
    except Exception as error:  # the library raises many kinds for damaged bags
        raise InputError(f'{path}: {type(error).__name__} {error}, expected a whole ROS 1 '
                         'bag') from None


def _values_of(kind: str, message: Any) -> tuple[tuple[str, ...], dict[str, list[float]]]:
    """Return (joints, {quantity: values}) of a message of one of STATES."""
    if kind == JOINT_STATE:
        joints = tuple(message.name)
        return joints, {name: list(getattr(message, name)) for name in QUANTITIES[:3]
                        if len(getattr(message, name)) == len(joints)}
    joints = tuple(message.joint_names)
    if kind == DYNAMIC:
        tables = [dict(zip(part.interface_names, part.values))
                  for part in message.interface_values]
        names = set().union(*tables) & set(QUANTITIES[:3]) if tables else set()
        return joints, {name: [table.get(name, np.nan) for table in tables] for name in names}
    old = not hasattr(message, 'feedback')  # names of control_msgs before 2023
    feedback = message.actual if old else message.feedback
    reference = message.desired if old else message.reference
    output = getattr(message, 'output', None)
    values = {'position': list(feedback.positions), 'velocity': list(feedback.velocities),
              'effort': list(feedback.effort) or list(getattr(output, 'effort', ())),
              'setpoint': list(reference.positions)}
    return joints, {name: column for name, column in values.items()
                    if len(column) == len(joints)}


def restamped(path: str | Path, part: JointMessages, stamps: str) -> tuple[Integers, list[str]]:
    """
    Return the stamps of messages as `stamps` asks, one of STAMPS, and notices.

    Raises Undecided where all header stamps are 0 and nothing is asked.
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
        topic: of the joint states; '' for all.
        stamps: one of STAMPS.
        joint: the only joint that is written, as motor; None: all.

    Returns:
        {name: value} for JSON: samples, duration_s, rate_hz, joints, notes.

    Raises:
        InputError: see read_bag; Undecided: see restamped.
    """
    parts, notices = read_bag(source, topic)
    joints = list(dict.fromkeys(name for part in parts for name in part.joints))
    if joint is not None and joint not in joints:
        raise InputError(f'{source}: --joint {joint}: expected one of {", ".join(joints)}')
    topics: list[Topic] = []
    for part in parts:
        if joint is not None and joint not in part.joints:
            continue
        times, notes = restamped(source, part, stamps)
        notices += [note for note in notes if note not in notices]
        topics += _as_drive(part, times, joint, parts) if joint is not None else \
            _as_robot(part, times)
    if len(parts) > 1:
        notices.append(f'{len(parts)} publishers: ' + '; '.join(
            f'{len(part.stamp_ns)} messages of {", ".join(part.joints)}'[:120]
            for part in parts))
    _write(Path(source), Path(bag), topics, notices)
    states = [times for name, times, _ in topics if name == JOINT_TOPIC] or [topics[0][1]]
    count = sum(map(len, states))
    seconds = (max(int(times[-1]) for times in states) - min(
        int(times[0]) for times in states)) * 1e-9
    return {'bag': str(bag), 'samples': count, 'duration_s': seconds,
            'rate_hz': (count - 1) / seconds if seconds > 0.0 else None,
            'signals': [joint] if joint is not None else joints, 'assumptions': [],
            'notes': notices}


def _as_robot(part: JointMessages, times: Integers) -> list[Topic]:
    """Return the topics of all joints of messages."""
    topics: list[Topic] = []
    if any(name in part.values for name in QUANTITIES[:3]):
        none = np.full((len(times), len(part.joints)), np.nan)
        topics.append((JOINT_TOPIC, times, encode_joint_states(
            times, part.joints, part.values.get('position', none), part.values.get('velocity'),
            part.values.get('effort'))))
    if 'setpoint' in part.values:
        topics.append((SETPOINT_TOPIC, times, encode_joint_states(
            times, part.joints, part.values['setpoint'])))
    return topics


def _as_drive(part: JointMessages, times: Integers, joint: str,
              parts: Sequence[JointMessages]) -> list[Topic]:
    """Return the topic of one joint as the motor of a drive, with its setpoint."""
    if 'position' not in part.values:
        return []
    k = part.joints.index(joint)
    columns = {name: [part.values[name][:, k]] if name in part.values else
               [np.full(len(times), np.nan)] for name in QUANTITIES[:3]}
    names = ['motor', 'arm']
    for name in columns:
        columns[name].append(np.full(len(times), np.nan))
    source = next((other for other in parts if 'setpoint' in other.values
                   and joint in other.joints), None)
    if source is not None:
        names.append('setpoint')
        setpoint = source.values['setpoint'][:, source.joints.index(joint)]
        own = source.stamp_ns if source.stamp_ns.any() else source.log_ns
        columns['position'].append(setpoint if source is part else interpolated(
            times, own, setpoint))
        for name in ('velocity', 'effort'):
            columns[name].append(np.full(len(times), np.nan))
    stacked = {name: np.column_stack(values) for name, values in columns.items()}
    return [(JOINT_TOPIC, times, encode_joint_states(
        times, names, stacked['position'],
        None if np.isnan(stacked['velocity']).all() else stacked['velocity'],
        stacked['effort']))]


def _write(source: Path, bag: Path, topics: Sequence[Topic], notices: Sequence[str]) -> None:
    """Write the new bag with its origin as metadata."""
    with BagWriter(bag) as writer:
        for name in dict.fromkeys(name for name, _, _ in topics):
            writer.add_topic(name, JOINT_STATE)
        digest = hashlib.sha256(source.read_bytes()).hexdigest() if source.is_file() else ''
        writer.add_metadata('import', {
            'source': source.name, 'source_sha256': digest, 'notices': '\n'.join(notices),
            'gearbox_monitor_version': __version__})
        write_in_order(writer, topics)
