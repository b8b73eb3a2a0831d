# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Which topics of a bag tell the states of the joints and their setpoints."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.read import JOINT_STATE
from gearbox_monitor.recordings.topics import JOINT_STATES

DYNAMIC, CONTROLLER = ('control_msgs/msg/DynamicJointState',
                       'control_msgs/msg/JointTrajectoryControllerState')
STATES = (JOINT_STATE, DYNAMIC, CONTROLLER)  # the most trusted first
JOINT_SETPOINTS = 'joint_setpoints'


@dataclass(frozen=True)
class TopicChoice:
    """
    Topics to read, the most trusted first, and sentences on those that are left out.

    setpoints: topics of joint states among `names` whose positions are setpoints.
    """

    names: tuple[str, ...]
    setpoints: frozenset[str] = frozenset()
    notices: tuple[str, ...] = ()


def chosen_topics(path: Path, topics: Mapping[str, tuple[str, int]], topic: str = ''
                  ) -> TopicChoice:
    """
    Return the TopicChoice of a bag.

    Of all topics of sensor_msgs/JointState one tells the states: `topic`, else joint_states in
    whatever namespace, else the only one. Another one that is called joint_setpoints tells the
    setpoints. Topics of controllers and of dynamic joint states are all read.

    Args:
        path: of the bag, for messages.
        topics: {topic: (type, number of messages)}.
        topic: of the states, as the user states it; '' for none.

    Raises:
        InputError: no topic of joints is called `topic`.
        Undecided: several topics may be meant.
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
    setpoints = [name for name in _called(JOINT_SETPOINTS, with_messages) if name not in stated]
    candidates = stated or _called(JOINT_STATES, with_messages) or [
        name for name in with_messages if name not in setpoints]
    if len(candidates) > 1:
        raise Undecided(f'{path}: {", ".join(candidates)}: {len(candidates)} topics of joint '
                        f'states, expected one: --topic {candidates[0]}')
    beside = [name for name in setpoints if candidates
              and _namespace(name) == _namespace(candidates[0])]
    setpoints = beside or (setpoints if len(setpoints) == 1 else [])
    names = [*candidates, *setpoints, *(name for kind in (DYNAMIC, CONTROLLER)
                                        for name in of_joints[kind] if name not in stated)]
    unused = [name for name in with_messages if name not in names]
    return TopicChoice(tuple(names), frozenset(setpoints), tuple(
        f'{name}: {topics[name][1]} messages left out' + (
            f'; the states are those of {candidates[0]} (--topic)' if candidates else '')
        for name in unused))


def _called(name: str, topics: Sequence[str]) -> list[str]:
    """Return the `topics` that are `name`, or else those that end with it."""
    ending = '/' + name.strip('/')
    return [topic for topic in topics if '/' + topic.strip('/') == ending] or [
        topic for topic in topics if topic.endswith(ending) and not name.startswith('/')]


def _namespace(topic: str) -> str:
    return topic.rpartition('/')[0]
