# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Record topics into a rosbag2-compatible MCAP bag.

usage examples:
  ros2 run gearbox_monitor recorder_node
  ros2 run gearbox_monitor recorder_node --ros-args -p output:=run1 -p "topics:=[joint_states]"
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass
import os
from pathlib import Path
import shutil
from tempfile import TemporaryFile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.exceptions import InvalidTopicNameException, NoTypeSupportImportedException
from rclpy.logging import get_logger
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import RECORDER, RecorderParameters
from gearbox_monitor.recordings.storage import FILE_NAME, next_free, qos_profile
from gearbox_monitor.recordings.write import BagWriter, WriteError
from gearbox_monitor.ros.convert import import_message, key_values, message_definition
from gearbox_monitor.ros.runtime import (
    advertise, declare, drain, overridden, PolledCallbackGroup, RCLError, spin_node, steady_timer,
    subscribe, TableNode)

JOINT_STATE = 'sensor_msgs/msg/JointState'
DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
LATCHED = ('drift_alerts', 'estimator/snapshot')
# {topic: (type, latched)} of topics that are subscribed at once: no first message is missed.
CONTRACT = {name: (DIAGNOSTICS if name in ('/diagnostics', *LATCHED) else JOINT_STATE,
                   name in LATCHED) for name in RecorderParameters().topics}
POLL_SECONDS = 0.01
DISCOVERY_SECONDS = 0.25
MEGABYTE = 1_000_000
ROOM = 16 * MEGABYTE  # on the disk, with which recording goes on after it was full


@dataclass
class RecordedTopic:
    """One topic: its subscription and the messages that came and that are missing."""

    name: str
    msgtype: str = ''
    subscription: Subscription | None = None
    in_bag: bool = False
    publishers: int = 0
    last_sequence: int | None = None
    missing: int = 0   # numbers missing in the sequence of the only publisher
    suspects: int = 0  # missing numbers until it is certain that there was only one publisher
    events: int = 0   # messages that the middleware reports as lost
    problem: str = ''

    @property
    def loss(self) -> int:
        """The number of lost messages."""
        return max(self.missing, self.events)

    def count(self, sequence: int) -> None:
        """Count the messages missing before the message with the publisher's `sequence` number."""
        if self.last_sequence is not None and sequence > self.last_sequence + 1:
            self.suspects += sequence - self.last_sequence - 1
        self.last_sequence = sequence

    def confirm(self, publishers: int) -> None:
        """Decide about missing numbers: those of several `publishers` cannot be distinguished."""
        if max(publishers, self.publishers) == 1:
            self.missing += self.suspects
        if publishers != self.publishers:
            self.last_sequence = None
        self.suspects, self.publishers = 0, publishers


class Recorder(TableNode):
    """
    Node that writes the raw messages of its topics to one bag.

    After the disk was full it goes on in a new bag as soon as there is room.

    Log time is the time of reception, publish time that of the publisher, both by the system's
    clock, as in ``ros2 bag record``. A timer takes messages in bulk: the executor alone cannot
    keep up with several topics at 1 kHz.
    """

    def __init__(self) -> None:
        super().__init__('recorder')
        parameters = self._declare()
        names = dict.fromkeys(self._resolve(name) for name in parameters.topics)
        output = Path(os.path.abspath(time.strftime(parameters.output)))
        if list(output.glob('*.mcap')) and not (output / FILE_NAME).exists():
            output = next_free(output)  # of a recorder that was killed, which this one replaces
        self._group = PolledCallbackGroup()
        self._topics = {name: RecordedTopic(name) for name in names}
        self._warned_space = self._warned_removed = False
        self._writers: list[BagWriter] = []  # the newest one writes
        self._open(output)
        for topic in self._topics.values():
            for name, (msgtype, latched) in CONTRACT.items():
                if topic.name == self._resolve(name) or topic.name.endswith(f'/{name}'):
                    self._subscribe(topic, msgtype, latched=latched)
                    break
        self._diagnostics = advertise(self, DiagnosticArray, '/diagnostics', 10)
        # With a simulation clock that stands still, messages must not be left waiting.
        for seconds, callback in ((POLL_SECONDS, self._poll), (1.0, self._diagnose),
                                  (DISCOVERY_SECONDS, self._discover)):
            steady_timer(self, seconds, callback)
        self.warn_of_unknown()
        self.get_logger().info(
            f'recording {len(names)} topics to {self._writer.path}, '
            + ', '.join(f'{name}={value}' for name, value in parameters.to_dict().items()))

    @property
    def _writer(self) -> BagWriter:
        return self._writers[-1]

    def _open(self, output: str | Path) -> None:
        """Begin the bag `output`. Raises InputError."""
        p = self._values
        self._writers.append(BagWriter(
            output, p.compression, sync_seconds=p.sync_period or None, max_size=p.max_bag_size,
            max_seconds=p.max_bag_duration))
        self._record(self._writer.add_metadata, 'gearbox_monitor', {
            'version': __version__,
            **{f'{self.get_name()}.{name}': value for name, value in p.to_dict().items()}})
        self._record(self._writer.flush)

    def close(self) -> None:
        """Take the messages that still wait and close the bag."""
        self._poll()
        for topic in self._topics.values():
            topic.confirm(topic.publishers)
        self._record(self._writer.close)
        losses = {topic.name: topic.loss for topic in self._topics.values() if topic.loss}
        messages, size, dropped = self._totals()
        text = (f'recorded {messages} messages, {size} bytes to '
                f'{", ".join(str(writer.path) for writer in self._writers)}; '
                f'lost {sum(losses.values())} messages'
                + (f' {losses}' if losses else '') + f', not written {dropped}')
        logger = get_logger('recorder_end')  # the node's own wants /rosout, which is gone by now
        if self._writer.error:
            logger.error(f'{text}; {self._writer.error}')
        elif losses or dropped:
            logger.warning(text)
        else:
            logger.info(text)

    def _totals(self) -> tuple[int, int, int]:
        """Return the numbers of messages and bytes in all bags, and of messages not written."""
        writers = self._writers
        return (sum(w.message_count for w in writers), sum(w.byte_count for w in writers),
                sum(w.dropped for w in writers))

    def _declare(self) -> RecorderParameters:
        """Declare and return the parameters."""
        self._values = values = RecorderParameters.from_mapping(declare(self, RECORDER))
        for name in ('output', 'gearbox_serial'):
            if not getattr(values, name):
                raise InputError(f"parameter {name}: '' is empty, expected a text")
        if not values.topics:
            raise InputError('parameter topics: the list is empty, expected topic names')
        return values

    def _resolve(self, name: str) -> Any:
        try:
            return self.resolve_topic_name(name)
        except (InvalidTopicNameException, RCLError) as error:
            reason = str(error).split(', at /')[0].splitlines()[0]
            raise InputError(
                f'parameter topics: {name!r} not a topic name: {reason}') from None

    def _subscribe(self, topic: RecordedTopic, msgtype: str, latched: bool = False,
                   reliable: bool = True) -> None:
        """Subscribe to `topic`, instead of an earlier subscription if there is one."""
        if topic.subscription is not None:
            self._take(topic)
            self.destroy_subscription(topic.subscription)
            topic.subscription = None
        profile = QoSProfile(
            depth=self._values.queue_depth,
            reliability=(ReliabilityPolicy.RELIABLE if reliable
                         else ReliabilityPolicy.BEST_EFFORT),
            durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched
                        else DurabilityPolicy.VOLATILE))

        fixed = overridden(self, topic.name)

        def on_loss(event: Any) -> None:
            topic.events += event.total_count_change

        topic.msgtype = msgtype
        topic.last_sequence = None
        try:
            topic.subscription = subscribe(
                self, import_message(msgtype), topic.name, lambda message: None, profile,
                policies=fixed, callback_group=self._group, raw=True,
                # A QoS that the user overrides may not fit: then rclpy warns of it.
                event_callbacks=SubscriptionEventCallbacks(
                    message_lost=on_loss, use_default_callbacks=bool(fixed)))
        except (ImportError, NoTypeSupportImportedException) as error:
            topic.problem = f'type {msgtype} is not installed'
            self.get_logger().error(f'{topic.name}: cannot record, {topic.problem}: {error}')

    def _discover(self) -> None:
        """Subscribe to topics whose type has become known, follow the QoS that is offered."""
        for topic in self._topics.values():
            infos = self.get_publishers_info_by_topic(topic.name)
            topic.confirm(len(infos))
            if not infos or topic.problem:
                continue
            offers = [info.qos_profile for info in infos]
            types = [info.topic_type for info in infos]
            reliable = all(o.reliability == ReliabilityPolicy.RELIABLE for o in offers)
            latched = all(o.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
            if topic.subscription is None or (not topic.in_bag and topic.msgtype not in types):
                self._subscribe(topic, types[0], latched, reliable)
                continue
            requested, fixed = topic.subscription.qos_profile, overridden(self, topic.name)
            needs_less = (
                (requested.reliability == ReliabilityPolicy.RELIABLE and not reliable
                 and QoSPolicyKind.RELIABILITY not in fixed)
                or (requested.durability == DurabilityPolicy.TRANSIENT_LOCAL and not latched
                    and QoSPolicyKind.DURABILITY not in fixed))
            if needs_less:
                self._subscribe(topic, topic.msgtype, latched, reliable)

    def _poll(self) -> None:
        """Write all messages that wait."""
        for topic in self._topics.values():
            if topic.subscription is not None:
                self._take(topic)
        self._record(self._writer.flush_if_due)

    def _take(self, topic: RecordedTopic) -> None:
        write, name = self._writer.write, topic.name
        for raw, info in drain(topic.subscription):
            if not topic.in_bag:
                topic.in_bag = True
                self._record(self._add_to_bag, topic)
            sequence = info['publication_sequence_number'] or 0
            topic.count(sequence)
            try:
                write(name, info['received_timestamp'] or time.time_ns(), raw,
                      info['source_timestamp'], sequence & 0xffffffff)
            except WriteError as error:
                self._report(error)

    def _add_to_bag(self, topic: RecordedTopic) -> None:
        """Announce `topic` in the bag with the QoS that its publishers offer."""
        try:
            infos = self.get_publishers_info_by_topic(topic.name)
        except RCLError:  # a signal has ended the context: this is the first message, and the last
            infos = []
        assert topic.subscription is not None
        offers = [info.qos_profile for info in infos] or [topic.subscription.qos_profile]
        self._writer.add_topic(topic.name, topic.msgtype, [_as_bag_qos(o) for o in offers],
                               message_definition(topic.msgtype))

    def _record(self, function: Callable[..., object], *args: object) -> None:
        """Call `function` of the writer; report once that writing has ended."""
        try:
            function(*args)
        except WriteError as error:
            self._report(error)

    def _report(self, error: WriteError) -> None:
        self.get_logger().error(
            f'recording has stopped until there is room for a new bag: {error}')

    def _resume(self) -> None:
        """Go on in a new bag if there is room again."""
        folder = self._writers[0].path
        try:
            with TemporaryFile(dir=folder) as file:  # a medium that is gone has no such folder
                os.posix_fallocate(file.fileno(), 0, ROOM)
            self._open(next_free(folder))
        except (OSError, InputError):
            return
        self._record(self._writers[-2].close)
        for topic in self._topics.values():
            topic.in_bag = False
        self.get_logger().warning(
            f'recording goes on in {self._writer.path}; not written: {self._totals()[2]} messages')

    def _diagnose(self) -> None:
        """Publish the state of the recording; go on if it was stopped."""
        if self._writer.error is not None:
            self._resume()
        writer = self._writer
        messages, size, dropped = self._totals()
        losses = {topic.name: topic.loss for topic in self._topics.values()}
        try:
            free = shutil.disk_usage(writer.path).free
        except OSError:
            free = 0
        level, message = DiagnosticStatus.OK, 'recording'
        problems = [f'{t.name}: {t.problem}' for t in self._topics.values() if t.problem]
        if dropped or any(losses.values()):
            level, message = DiagnosticStatus.WARN, 'messages were lost'
        if problems:
            level, message = DiagnosticStatus.WARN, problems[0]
        low = free < self._values.low_space * MEGABYTE
        if low:
            level, message = DiagnosticStatus.WARN, 'free disk space is low'
            if not self._warned_space:
                self.get_logger().warning(
                    f'{writer.path}: {free // MEGABYTE} MB of free disk space remain')
        self._warned_space = low
        removed = writer.removed
        if removed:
            level, message = DiagnosticStatus.ERROR, removed
            if not self._warned_removed:
                self.get_logger().error(removed)
        self._warned_removed = bool(removed)
        if writer.error is not None:
            level, message = DiagnosticStatus.ERROR, str(writer.error)
        values = {
            'bag': writer.path, 'messages': messages, 'bytes': size,
            'topics_with_messages': sum(topic.in_bag for topic in self._topics.values()),
            'topics': len(self._topics), 'lost': sum(losses.values()),
            'not_written': dropped,
            'since_last_flush_s': f'{time.monotonic() - writer.last_flush:.3f}',
            'free_disk_space_mb': free // MEGABYTE,
            'low_space_threshold_mb': self._values.low_space,
            'lost_by_topic': ', '.join(f'{name}: {count}' for name, count in losses.items()),
        }
        status = DiagnosticStatus(
            level=level, message=message,
            name=f'{self.get_fully_qualified_name().lstrip("/")}: recording',
            hardware_id=self._values.gearbox_serial,
            values=key_values('recording', values))
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)


def _as_bag_qos(profile: QoSProfile) -> dict[str, Any]:
    """Return the rclpy QoSProfile `profile` as rosbag2 writes it."""
    def duration(value: Any) -> dict[str, int]:
        sec, nsec = divmod(value.nanoseconds, 10**9)
        return {'sec': sec, 'nsec': nsec}

    named = ('reliability', 'durability', 'history', 'liveliness')
    recorded: dict[str, Any] = qos_profile(depth=profile.depth, **{
        name: getattr(profile, name).name.lower() for name in named}, **{
            name: duration(getattr(profile, name))
            for name in ('deadline', 'lifespan', 'liveliness_lease_duration')})
    return recorded


def main(args: Sequence[str] | None = None) -> int:
    """Run the recorder with the command line `args`; return the exit code."""
    return spin_node(Recorder, args, __doc__)


if __name__ == '__main__':
    raise SystemExit(main())
