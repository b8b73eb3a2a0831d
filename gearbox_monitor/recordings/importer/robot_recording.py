# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A robot's recording, as joint states and setpoints; the bag that holds what was imported."""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import hashlib
import heapq
from pathlib import Path

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import JOINT_STATE
from gearbox_monitor.recordings.write import BagWriter

JOINT_TOPIC = '/joint_states'
SETPOINT_TOPIC = '/joint_setpoints'
Topic = tuple[str, Integers, list[bytes]]  # name, stamps, messages


@dataclass(frozen=True)
class RobotRecording:
    """
    Samples [N] of J joints; NaN where not measured.

    values {'position', 'velocity', 'effort', 'setpoint': [N, J]}, rad (or m), rad/s, N m or what
    a torque constant makes N m; a quantity that no joint has is missing. `stamp_ns` is int64 and
    strictly increasing. `notices` are sentences about the data that its owner should read.
    """

    joints: tuple[str, ...]
    stamp_ns: Integers
    values: Mapping[str, Array]
    notices: tuple[str, ...] = ()

    def messages(self) -> Iterator[Topic]:
        """Yield (topic, stamps, messages): joint states and setpoints, where there are any."""
        none = np.full((len(self.stamp_ns), len(self.joints)), np.nan)
        if set(self.values) - {'setpoint'}:
            yield JOINT_TOPIC, self.stamp_ns, encode_joint_states(
                self.stamp_ns, self.joints, self.values.get('position', none),
                self.values.get('velocity'), self.values.get('effort'))
        if 'setpoint' in self.values:
            yield SETPOINT_TOPIC, self.stamp_ns, encode_joint_states(
                self.stamp_ns, self.joints, self.values['setpoint'])


def robot_recording(joints: Sequence[str], stamp_ns: Integers, values: Mapping[str, Array],
                    notices: Iterable[str]) -> RobotRecording:
    """
    Return the RobotRecording of signals called 'JOINT:QUANTITY'.

    Args:
        joints: J names.
        stamp_ns: int64 [N].
        values: {signal: [N]}.
        notices: sentences for the user.
    """
    none = np.full(len(stamp_ns), np.nan)
    quantities = dict.fromkeys(name.rpartition(':')[2] for name in values)
    return RobotRecording(tuple(joints), stamp_ns, {
        quantity: np.column_stack([values.get(f'{joint}:{quantity}', none) for joint in joints])
        for quantity in quantities}, tuple(notices))


def write_topics(bag: str | Path, source: str | Path, topics: Sequence[Topic],
                 notices: Iterable[str], **origin: str) -> None:
    """
    Write messages by their stamps, then in the given order, and metadata ``import``: their origin.

    Args:
        bag: the new bag.
        source: what they were read from; its name and, of a file, its SHA-256 are recorded.
        topics: of the messages.
        notices: sentences for the user.
        origin: further texts to record, by name.

    Raises:
        InputError: `bag` exists or cannot be written.
    """
    source = Path(source)
    with BagWriter(bag) as writer:
        for topic in dict.fromkeys(topic for topic, _, _ in topics):
            writer.add_topic(topic, JOINT_STATE)
        writer.add_metadata('import', {
            'source': source.name, 'source_sha256': hashlib.sha256(
                source.read_bytes()).hexdigest() if source.is_file() else '',
            **origin, 'notices': '\n'.join(notices), 'gearbox_monitor_version': __version__})
        for stamp, _, topic, message in heapq.merge(*(
                [(stamp, k, topic, message) for stamp, message in zip(stamps.tolist(), messages)]
                for k, (topic, stamps, messages) in enumerate(topics))):
            writer.write(topic, stamp, message)
