# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The samples of one gearbox from the joint states of the publisher that it follows."""
from collections.abc import Callable, Iterable, Iterator, Sequence
import time
from typing import Any, TypeAlias

from rclpy.node import Node
from rclpy.qos import qos_check_compatible, QoSCompatibility
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.interfaces.joiner import Joiner
from gearbox_monitor.interfaces.signals import JOINT_STATES, PAIRED_JOINT_STATES
from gearbox_monitor.parameters import ACCEPT, EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.convert import (
    joint_values_of, RawSample, SampleReader, stamp_of, to_paired)
from gearbox_monitor.ros.message_loss import MessageLossCounter
from gearbox_monitor.ros.publishers import Publishers
from gearbox_monitor.ros.qos import advertise

SECOND = 1_000_000_000
OUTPUT_DEPTH = 2000
MAX_LISTED = 16  # arrangements of joints that are reported; names that are listed
TakenSample: TypeAlias = tuple[Sample, RawSample]
Info: TypeAlias = dict[str, Any]  # of a message, by rclpy


class GearboxInput:
    """
    Turns messages into samples of one gearbox of `node`.

    parameters: of the gearbox; model: of its drive. disputed() is called if samples were taken of
    a publisher that may have been the wrong one, see Publishers. robot_joints: whose positions
    samples hold, too.

    topic: of complete samples, for a recorder. separate_arm: parameter arm_topic, '' unless it
    differs from the motor's. foreign: number of messages that name neither joint.
    """

    def __init__(self, node: Node, parameters: EstimatorParameters, model: DriveModel,
                 disputed: Callable[[], None], robot_joints: Sequence[str] = ()) -> None:
        self._node, self._disputed = node, disputed
        self.joints = parameters.motor_joint, parameters.arm_joint
        self._robot_joints = robot_joints
        self._reader = SampleReader(*self.joints, model, robot_joints)
        self.foreign = 0
        self._foreign_names: Sequence[str] = ()
        self._names: list[str] | None = None
        self._warnings: set[str] = set()
        self._unreadable = 0
        self.publishers = [Publishers(parameters.other_publishers)]  # of the motor; of the arm
        # Endpoints on our topics while nobody else gave our joints; the only one so far.
        self._endpoints: set[bytes] = set()
        self._own: set[bytes] = set()
        self._losses = MessageLossCounter(), MessageLossCounter()  # of motor's topic, of arm's
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

    def _join(self, parameters: EstimatorParameters) -> None:
        self._pairs = 0  # at the last report
        self.joiner = Joiner(round(parameters.pair_tolerance * SECOND))
        self.publishers.append(Publishers(parameters.other_publishers))
        self._paired = advertise(self._node, JointState, PAIRED_JOINT_STATES, OUTPUT_DEPTH)
        self.topic = self._paired.topic_name
        self.arm_topic = self._node.resolve_topic_name(parameters.arm_topic)
        if self.arm_topic != self.motor_topic:
            self.separate_arm = parameters.arm_topic

    # ------------------------------------------------------------------ messages

    def samples(self, message: JointState, info: Info) -> Iterator[TakenSample]:
        """Yield the samples that `message` with `info` of the motor's topic completes."""
        if message.name != self._names:
            self._names = message.name
            self._check_joints(message)
        stamp_ns = stamp_of(message)
        if self.joiner is None:
            sample = self._reader.sample(message, stamp_ns)
            if sample is None:
                self._count_foreign(message, 0, info)
            elif self._admitted(0, info, stamp_ns):
                yield sample
            return
        motor, arm = self.joints
        values = joint_values_of(message, motor)
        if values is not None and self._admitted(0, info, stamp_ns):
            yield from self._joined(self.joiner.motor(stamp_ns, values))
        if not self.separate_arm and arm in message.name:
            if values is None:
                self._losses[0].add(info, False)
            yield from self.arm_samples(message, info)
        elif values is None:
            self._count_foreign(message, 0, info)

    def arm_samples(self, message: JointState, info: Info) -> Iterator[TakenSample]:
        """Yield the samples that `message` with `info` of the arm's topic completes."""
        if self.joiner is None:
            return
        values = joint_values_of(message, self.joints[1])
        if values is None:
            self._count_foreign(message, 1, info)
        elif self._admitted(1, info, stamp_ns := stamp_of(message)):
            yield from self._joined(self.joiner.arm(stamp_ns, values))

    def count_unreadable(self) -> None:
        """Count a message that is too long, or no joint states at all."""
        self._unreadable += 1

    def _admitted(self, joint: int, info: Info, stamp_ns: int) -> bool:
        """Return whether to take a message of motor (0) or arm (1), by who published it."""
        publishers = self.publishers[joint]
        disputes = publishers.disputes
        admitted = publishers.admit(info['publication_sequence_number'],
                                    info['received_timestamp'] or time.time_ns(),
                                    stamp_ns)
        if publishers.disputes != disputes:
            self.clear()
            self._losses[joint].forget()
            self._disputed()
        if admitted and (joint == 0 or self.separate_arm):  # a refused message is not lost
            self._losses[joint].add(info, True)
        return admitted

    def _joined(self, pairs: Iterable[tuple[int, Any, Any]]) -> Iterator[TakenSample]:
        for stamp_ns, motor, arm in pairs:
            message = to_paired(stamp_ns, self.joints, motor, arm)
            self._paired.publish(message)
            if (sample := self._reader.sample(message, stamp_ns)) is not None:
                yield sample

    def _count_foreign(self, message: JointState, joint: int, info: Info) -> None:
        self._losses[joint].add(info, False)
        self.foreign += 1
        self._foreign_names = message.name

    # ------------------------------------------------------------------ words

    def _check_joints(self, message: JointState) -> None:
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

    def silence(self, has_samples: bool) -> tuple[str, str] | None:
        """Return (why no sample came, the cure) or None; `has_samples`: whether any ever came."""
        now_ns = time.time_ns()
        if any(p.disputed and p.others(now_ns) for p in self.publishers):
            return (f'several publishers give our joints and none was the first: '
                    f'{self._rivals()}; nothing was taken',
                    'stop one, or set other_publishers')
        if any(p.waits(now_ns) for p in self.publishers):
            return (f'the publisher that was followed is silent; that of {self._rivals()} spoke '
                    'beside it and is refused', 'start the first again, or call ~/reset')
        if self.foreign and not has_samples:
            motor, arm = self.joints
            return (f'{self.foreign} messages named neither {motor!r} nor {arm!r} but '
                    f'{_listed(self._foreign_names) or "nothing"}',
                    'set motor_joint and arm_joint')
        if self.joiner is not None and self.joiner.dropped and not has_samples:
            return (f'messages of the arm came on {self.arm_topic}, none of '
                    f'{self.joints[0]!r} on {self.motor_topic}', 'check motor_joint and its topic')
        return None if has_samples else self._mismatch()

    def _mismatch(self) -> tuple[str, str] | None:
        """Return (which publisher's QoS does not fit ours, the cure), or None."""
        node, ours = self._node, (self._node.get_name(), self._node.get_namespace())
        for topic in filter(None, (self.motor_topic, self.arm_topic)):
            profiles = [info.qos_profile for info in node.get_subscriptions_info_by_topic(topic)
                     if (info.node_name, info.node_namespace) == ours]
            for info in node.get_publishers_info_by_topic(topic):
                for qos in profiles:
                    fits, reason = qos_check_compatible(info.qos_profile, qos)
                    if fits == QoSCompatibility.ERROR:
                        return (f'the QoS of {info.node_name} on {topic} does not fit ours '
                                f'({reason.strip("; ")})', f'change qos_overrides.{topic}')
        return None

    def strangers(self) -> tuple[dict[str, int | str], str]:
        """Return ({name: value}, text about other publishers of our joints or '')."""
        now_ns = time.time_ns()
        values: dict[str, int | str] = {}
        if self._unreadable:
            values['messages_unreadable'] = self._unreadable
        refused = sum(p.refused for p in self.publishers)
        if refused:
            values['messages_of_other_publishers'] = refused
        endpoints = {bytes(info.endpoint_gid) for info in self._infos()}
        if endpoints == self._own and any(
                p.disputed or p.waits(now_ns) for p in self.publishers):
            self.forget_publishers()  # there is no other one, whatever its numbers look like
        if not any(p.others(now_ns) for p in self.publishers):
            if not any(p.disputed for p in self.publishers):
                self._endpoints = endpoints
                self._own = endpoints if len(endpoints) == 1 else self._own
            return values, ''
        values['other_publishers'] = self._rivals()
        accepted = self.publishers[0].policy == ACCEPT
        return values, ('another node publishes the monitored joints, its messages are '
                        f'{"taken, too" if accepted else "refused"}: {self._rivals()}')

    def _infos(self) -> list[Any]:
        """Return the graph's TopicEndpointInfo of all publishers on our topics."""
        topics = {self.motor_topic, self.arm_topic} - {None}
        return [info for topic in topics
                for info in self._node.get_publishers_info_by_topic(topic)]

    def _rivals(self) -> str:
        """Return the names of the nodes that may be rivals: the newest ones, else all."""
        infos = self._infos()
        rivals = [info for info in infos if bytes(info.endpoint_gid) not in self._own]
        new = [info for info in rivals if bytes(info.endpoint_gid) not in self._endpoints]
        return _listed(sorted({f'{info.node_namespace.rstrip("/")}/{info.node_name}'
                               for info in new or rivals or infos}))

    def loss(self) -> tuple[int, int]:
        """Return how many messages were lost in all, and since the last call."""
        count = sum(loss.count for loss in self._losses)
        new, self._reported_loss = count - self._reported_loss, count
        return count, new

    def pairing(self) -> tuple[dict[str, float], str]:
        """Return ({name: value}, text of a problem or '') of the pairs since the last call."""
        if self.joiner is None:
            return {}, ''
        nearest, tolerance = self.joiner.pop_distance(), self.joiner.tolerance / SECOND
        unpaired, self._pairs = self.joiner.pairs == self._pairs, self.joiner.pairs
        values: dict[str, float] = {
            'motor_without_arm': self.joiner.unpaired, 'arm_without_motor': self.joiner.dropped,
            'pair_tolerance_s': tolerance}
        if nearest is None:
            return values, ''
        values['nearest_unpaired_s'] = nearest / SECOND
        text = (f'stamps of motor and arm are {nearest / SECOND:.6f} s apart, pair_tolerance is '
                f'{tolerance:g} s')
        if unpaired:
            self._node.get_logger().warning(f'{self.arm_topic}: nothing is paired: {text}',
                                            throttle_duration_sec=60.0)
        return values, text

    def clear(self) -> None:
        """Forget messages that wait for their partner."""
        if self.joiner is not None:
            self.joiner.clear()

    def forget_publishers(self) -> None:
        """Follow the publisher that speaks next."""
        for publishers in self.publishers:
            publishers.forget()
        for loss in self._losses:
            loss.forget()


def _listed(names: Sequence[str]) -> str:
    """Return the first `names`, in one text: anybody may send any number of any length."""
    text = ', '.join(name[:64] for name in names[:MAX_LISTED])
    text = ''.join(c if c.isprintable() else '?' for c in text)  # no lines of their own in the log
    return text + (f' and {len(names) - MAX_LISTED} more' if len(names) > MAX_LISTED else '')
