# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the numbers of messages tell: two publishers of one joint, and lost messages.

A message does not name its publisher, but each publisher numbers its messages upwards. A number
that does not exceed the previous one comes from another publisher. Once, that is a restart; when
it happens again soon, two publishers deliver. An endpoint that delivers nothing shows no number.
"""
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
import time
from typing import Any, TypeAlias

from rclpy.node import Node
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said
from gearbox_monitor.recordings.joint_input import Joiner
from gearbox_monitor.recordings.topics import JOINT_STATES, PAIRED_JOINT_STATES
from gearbox_monitor.ros.convert import (
    joint_state, JointReader, Joints, NAN, RawSample, SampleReader)
from gearbox_monitor.ros.runtime import (
    advertise, alone, Arrivals, best_effort, drain, RMWError, subscribe)

SECOND = 1_000_000_000
# ns between two changes of publisher that are no restart; a slower rival is not recognised
RECENT = 2 * SECOND
HOLD = SECOND // 4    # ns without a sample after a change: a rival would show up meanwhile


class JointPublishers:
    """
    Decides which messages with one joint on one topic are taken.

    None is taken while two publishers deliver the joint, and until one of them has been silent for
    RECENT. A middleware without numbers leaves nothing to decide: all messages are taken then.
    changes: how often another publisher took over, or joined.
    """

    def __init__(self) -> None:
        self.changes = 0
        self._last = 0  # number of the previous message
        self._changed_ns: int | None = None
        self._are_two = False

    def admit(self, number: int | None, now_ns: int) -> bool:
        """
        Return whether to take a message.

        Args:
            number: that its publisher gave it, from 1 on; None: not numbered.
            now_ns: when it was received, ns, by a clock that may be set.

        """
        if not number:
            return True
        if number <= self._last:
            self._are_two = self._changed_within(RECENT, now_ns)
            self.changes += not self._are_two
            self._changed_ns = now_ns
        self._last = number
        return self._changed_ns is None or not (
            self.are_two(now_ns) or self._changed_within(HOLD, now_ns))

    def are_two(self, now_ns: int) -> bool:
        """Return whether two publishers deliver the joint at `now_ns`."""
        return self._are_two and self._changed_within(RECENT, now_ns)

    def _changed_within(self, time_ns: int, now_ns: int) -> bool:
        """Return whether the publisher changed less than `time_ns` ago; not if a clock was set."""
        return self._changed_ns is not None and abs(now_ns - self._changed_ns) < time_ns


class MessageLossCounter:
    """
    Counts the missing messages of one publisher: `count` in all.

    DDS silently drops messages that do not fit into a full queue, and steps of the stamps do not
    show it if every second message is dropped. Each publisher numbers its messages from 1 on.
    """

    def __init__(self) -> None:
        self.count = 0
        self._next: int | None = None

    def forget(self) -> None:
        """Restart: messages that were not looked at are not lost."""
        self._next = None

    def add(self, info: Mapping[str, int | None], ours: bool) -> None:
        """Take the `info` of a message (rclpy); `ours`: the counted publisher has sent it."""
        number = info.get('publication_sequence_number')  # None: not every middleware numbers
        if number is None or not (ours or number == self._next):
            return  # the publisher of our joints may send other messages, too
        if self._next is not None and number > self._next:
            self.count += number - self._next
        self._next = number + 1


OUTPUT_DEPTH = 2000
MAX_LISTED = 16  # arrangements of joints that are reported; names that are listed
TakenSample: TypeAlias = tuple[Sample, RawSample]
Info: TypeAlias = dict[str, Any]  # of a message, by rclpy


class GearboxInput:
    """
    Turns messages into samples of one gearbox of `node`.

    parameters: of the gearbox; model: of its drive. changed() is called when another publisher
    delivers a joint: earlier samples may be of either. robot_joints: whose positions samples hold,
    too.

    topic: of complete samples, for a recorder. separate_arm: parameter arm_topic, '' unless it
    differs from the motor's. foreign: number of messages that name neither joint.
    """

    def __init__(self, node: Node, parameters: EstimatorParameters, model: DriveModel,
                 changed: Callable[[], None], robot_joints: Sequence[str] = ()) -> None:
        self._node, self._changed = node, changed
        self.joints = parameters.motor_joint, parameters.arm_joint
        self._robot_joints = robot_joints
        self._reader = SampleReader(*self.joints, model, robot_joints)
        self.foreign = 0
        self._foreign_names: Sequence[str] = ()
        self._names: Sequence[str] | None = None
        self._warnings: set[str] = set()
        self._unreadable = 0
        self._refused = 0  # messages while two publishers deliver a joint
        self._changes = 0  # of all publishers
        self._reported_loss = 0
        self.joiner: Joiner[Any] | None = None
        self.motor_topic: str = node.resolve_topic_name(JOINT_STATES)
        self.topic = self.motor_topic
        self.arm_topic: str | None = None
        self.separate_arm = ''
        if parameters.arm_topic:
            if not parameters.arm_joint:
                raise InputError(f'arm_topic: {parameters.arm_topic!r}, expected none where '
                                 'arm_joint is empty')
            self._join(parameters)
        # Publishers of the joints that are taken from each topic.
        self._publishers = {self.motor_topic: {
            joint: JointPublishers() for joint in self.joints if joint}}
        if self.separate_arm and self.arm_topic:
            arm = self.joints[1]
            self._publishers[self.arm_topic] = {arm: self._publishers[self.motor_topic].pop(arm)}
        self._losses = {topic: MessageLossCounter() for topic in self._publishers}

    def _join(self, parameters: EstimatorParameters) -> None:
        self._pairs = 0  # at the last report
        self.joiner = Joiner(round(parameters.pair_tolerance * SECOND))
        self._paired = advertise(self._node, JointState, PAIRED_JOINT_STATES, OUTPUT_DEPTH)
        self.topic = self._paired.topic_name
        self.arm_topic = self._node.resolve_topic_name(parameters.arm_topic)
        if self.arm_topic != self.motor_topic:
            self.separate_arm = parameters.arm_topic

    # ------------------------------------------------------------------ messages

    def samples(self, message: Joints, info: Info) -> Iterator[TakenSample]:
        """Yield the samples that `message` with `info` of the motor's topic completes."""
        if message.name != self._names:
            self._names = message.name
            self._check_joints(message)
        if not self._takes(message, info, self.motor_topic):
            return
        if self.joiner is None:
            if (sample := self._reader.sample(message)) is not None:
                yield sample
            return
        motor, arm = map(message.of, self.joints)
        if motor is not None:
            yield from self._joined(self.joiner.motor(message.stamp_ns, motor))
        if not self.separate_arm and arm is not None:
            yield from self._joined(self.joiner.arm(message.stamp_ns, arm))

    def arm_samples(self, message: Joints, info: Info) -> Iterator[TakenSample]:
        """Yield the samples that `message` with `info` of the arm's own topic completes."""
        if self.joiner is None or self.arm_topic is None:
            return
        if self._takes(message, info, self.arm_topic):
            values = message.of(self.joints[1])
            assert values is not None
            yield from self._joined(self.joiner.arm(message.stamp_ns, values))

    def count_unreadable(self) -> None:
        """Count a message that is too long, or no joint states at all."""
        self._unreadable += 1

    def _takes(self, message: Joints, info: Info, topic: str) -> bool:
        """Return whether `message` on `topic` has joints of ours, from one publisher each."""
        now_ns = info['received_timestamp'] or time.time_ns()
        number = info['publication_sequence_number']
        publishers = [publishers for joint, publishers in self._publishers[topic].items()
                      if joint in message.name]
        admitted = [p.admit(number, now_ns) for p in publishers]
        if not all(admitted):
            self._refused += 1
            self._losses[topic].forget()  # a refused message is not lost
            changes, self._changes = self._changes, sum(
                p.changes for watched in self._publishers.values() for p in watched.values())
            if self._changes > changes:
                self.clear()
                self._changed()
            return False
        self._losses[topic].add(info, self.joints[topic != self.motor_topic] in message.name)
        if not publishers:
            self.foreign += 1
            self._foreign_names = message.name
        return bool(publishers)

    def _joined(self, pairs: Iterable[tuple[int, Any, Any]]) -> Iterator[TakenSample]:
        for stamp_ns, motor, arm in pairs:
            position, effort = zip(motor, arm or (NAN, NAN))
            self._paired.publish(joint_state(stamp_ns, self.joints, position, (), effort))
            if (sample := self._reader.sample(
                    Joints(stamp_ns, self.joints, position, effort))) is not None:
                yield sample

    # ------------------------------------------------------------------ words

    def _check_joints(self, message: Joints) -> None:
        """Warn once per arrangement of joints if `message` is incomplete for an estimate."""
        motor, arm = self.joints
        names = list(message.name)
        if motor not in names and arm not in names:
            return  # others may publish here, too
        text = ''
        listed = _listed(names)
        if motor not in names and self.joiner is None:
            text = f'no joint {motor!r} among {listed}: set motor_joint'
        elif motor in names and names.index(motor) >= len(message.effort):
            text = (f'no effort of {motor!r} ({len(message.effort)} efforts for {len(names)} '
                    'joints): nothing can be estimated; make its driver publish the effort')
        elif arm and arm not in names and self.joiner is None:
            text = (f'no joint {arm!r} among {listed}: set arm_joint, or arm_topic if separate '
                    'messages carry it')
        elif missing := [name for name in self._robot_joints if name not in names]:
            text = (f'no joint {_listed(missing)!r} of robot_description among {listed}: without '
                    'it the load on the arm counts as unknown')
        if text and text not in self._warnings and len(self._warnings) < MAX_LISTED:
            self._warnings.add(text)
            self._node.get_logger().warning(f'{self.motor_topic}: {text}')

    def silence(self, has_samples: bool) -> Said | None:
        """Return why no sample came, or None; `has_samples`: whether any ever came."""
        if self.foreign and not has_samples:
            motor, arm = self.joints
            return Said('other_joints', {
                'count': self.foreign, 'motor': motor, 'arm': arm,
                'names': _listed(self._foreign_names) or 'nothing'}, Level.ERROR)
        if self.joiner is not None and self.joiner.dropped and not has_samples:
            return Said('arm_alone', {'arm_topic': self.arm_topic, 'motor': self.joints[0],
                                      'motor_topic': self.motor_topic}, Level.ERROR)
        return None

    def counts(self) -> dict[str, int]:
        """Return {key: number} of messages that were refused, without zeros."""
        return {key: count for key, count in (
            ('messages_unreadable', self._unreadable),
            ('messages_of_two_publishers', self._refused)) if count}

    def rivals(self) -> str:
        """Return which joints two publishers deliver, where, and their nodes; '' if none."""
        now_ns = time.time_ns()
        return '; '.join(
            f'two publishers of {" and ".join(joints)} on {topic}: {self._publisher_names(topic)}'
            for topic, watched in self._publishers.items()
            if (joints := [repr(joint) for joint, publishers in watched.items()
                           if publishers.are_two(now_ns)]))

    def _publisher_names(self, topic: str) -> str:
        """Return the nodes that publish on `topic`, with GIDs where a name does not suffice."""
        infos = self._node.get_publishers_info_by_topic(topic)
        named = [(f'{info.node_namespace.rstrip("/")}/{info.node_name}',
                  bytes(info.endpoint_gid).hex()) for info in infos]
        count = Counter(name for name, _ in named)
        names = sorted(f'{name} (GID {gid})' if count[name] > 1 or name.endswith('_') else name
                       for name, gid in named)
        return ('two of ' if len(names) > 2 else '') + _listed(names) + (
            ', and one that has ended' if len(names) < 2 else '')

    def loss(self) -> tuple[int, int]:
        """Return how many messages were lost in all, and since the last call."""
        count = sum(loss.count for loss in self._losses.values())
        new, self._reported_loss = count - self._reported_loss, count
        return count, new

    def pairing(self) -> tuple[dict[str, float], Said | None]:
        """Return ({name: value}, a problem or None) of the pairs since the last call."""
        if self.joiner is None:
            return {}, None
        nearest, tolerance = self.joiner.pop_distance(), self.joiner.tolerance / SECOND
        unpaired, self._pairs = self.joiner.pairs == self._pairs, self.joiner.pairs
        values: dict[str, float] = {
            'motor_without_arm': self.joiner.unpaired, 'arm_without_motor': self.joiner.dropped,
            'pair_tolerance_s': tolerance}
        if nearest is None:
            return values, None
        values['nearest_unpaired_s'] = nearest / SECOND
        problem = Said('unpaired', {'apart': nearest / SECOND, 'tolerance': tolerance})
        if unpaired:
            self._node.get_logger().warning(
                f'{self.arm_topic}: nothing is paired: {problem}',
                throttle_duration_sec=60.0)
        return values, problem

    def clear(self) -> None:
        """Forget messages that wait for their partner."""
        if self.joiner is not None:
            self.joiner.clear()


def _listed(names: Sequence[str]) -> str:
    """Return the first `names`, in one text: anybody may send any number of any length."""
    text = ', '.join(name[:64] for name in names[:MAX_LISTED])
    text = ''.join(c if c.isprintable() else '?' for c in text)  # no lines of their own in the log
    return text + (f' and {len(names) - MAX_LISTED} more' if len(names) > MAX_LISTED else '')


# Two seconds at 1 kHz: a pause of this process must not cost samples.
DEPTH = 2000
# s after which queued messages wait for the next turn: services and signals want answers.
TURN = 0.2
# s for which a callback awaits further messages, if no other node waits meanwhile.
STAY = 0.02
# Longer messages are not unpacked; one of this length has 3000 joints and takes a few ms.
MAX_BYTES = 1 << 18
TakenSamples: TypeAlias = list[tuple[int, TakenSample]]


class JointSubscriptions:
    """
    Subscribes for `node`, unpacks each message once and hands its samples to take(samples).

    inputs: of the gearboxes. samples [(index of the input, TakenSample)]: of one message.
    """

    def __init__(self, node: Node, inputs: Sequence[GearboxInput],
                 take: Callable[[TakenSamples], None]) -> None:
        self._inputs, self._take, self._read = inputs, take, JointReader()
        self._main = subscribe(node, JointState, JOINT_STATES, self._on_message,
                               best_effort(DEPTH), raw=True)
        arm_topic = inputs[0].separate_arm  # only a single gearbox may have one
        self._arm = subscribe(node, JointState, arm_topic, self._on_arm, best_effort(DEPTH),
                              raw=True) if arm_topic else None
        self._node = node
        self._arrivals = Arrivals([self._main, *([self._arm] if self._arm else [])], node.context)

    def _on_message(self, raw: bytes, info: Info) -> None:
        self._take_message(raw, info)
        self._take_queued()

    def _on_arm(self, raw: bytes, info: Info) -> None:
        self._take_arm(raw, info)
        self._take_queued()

    def _take_queued(self) -> None:
        """Take what waits and what comes soon: waking the executor costs more than a step."""
        begin = time.monotonic()
        self._take_waiting(begin + TURN)
        while (alone(self._node) and (pause := begin + STAY - time.monotonic()) > 0.0
               and self._arrivals.wait(pause)):
            self._take_waiting(begin + TURN)

    def _take_waiting(self, end: float) -> None:
        """Take the messages that wait, until the time `end`."""
        if self._arm is None:
            for raw, info in drain(self._main, DEPTH):
                self._take_message(raw, info)
                if time.monotonic() > end:
                    break
            return
        # By turns: neither stream may run ahead of the other.
        for motor, arm in zip_longest(drain(self._main, DEPTH), drain(self._arm, DEPTH)):
            if motor is not None:
                self._take_message(*motor)
            if arm is not None:
                self._take_arm(*arm)
            if time.monotonic() > end:
                break

    def _unpacked(self, raw: bytes) -> Joints | None:
        """Return what the bytes `raw` tell; None if they are no JointState or too many."""
        if len(raw) <= MAX_BYTES:
            try:
                return self._read(raw)
            except (RMWError, UnicodeDecodeError):
                pass  # anybody can publish any bytes
        for joint_input in self._inputs:
            joint_input.count_unreadable()
        return None

    def _take_message(self, raw: bytes, info: Info) -> None:
        if (message := self._unpacked(raw)) is not None:
            self._take_all((k, sample) for k, joint_input in enumerate(self._inputs)
                           for sample in joint_input.samples(message, info))

    def _take_arm(self, raw: bytes, info: Info) -> None:
        if (message := self._unpacked(raw)) is not None:
            self._take_all((0, sample) for sample in self._inputs[0].arm_samples(message, info))

    def _take_all(self, samples: Iterable[tuple[int, TakenSample]]) -> None:
        """Hand over the `samples` of a message, if there are any."""
        if taken := list(samples):
            self._take(taken)
