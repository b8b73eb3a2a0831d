# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Publish a bag's messages, as they are, with their recorded spacing and /clock."""
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
import sys
import time

from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.read import BagReader, open_bag
from gearbox_monitor.recordings.topics import JOINT_STATES, PLANT_TRANSMISSION_STATE
from gearbox_monitor.ros.convert import import_message, to_time
from gearbox_monitor.ros.runtime import advertise, finish, spin_node, steady_timer

SECOND = 1_000_000_000
BLOCK_TIME = 0.02      # s between two checks for signals and services
CLOCK_PERIOD = 0.01    # s between two /clock messages
MATCH_TIME = 5.0       # s to wait for a subscriber before the first message
SETTLE_TIME = 1.0      # s for the subscriber to see the match, too
QUEUE = 10_000         # messages kept for a slow subscriber


def default_topics(topics: Iterable[str]) -> list[str]:
    """Return the inputs among the bag's `topics`: joint_states and the plant's true state."""
    return [topic for topic in topics
            if topic.lstrip('/') in (JOINT_STATES, PLANT_TRANSMISSION_STATE)
            or topic.endswith(('/' + JOINT_STATES, '/' + PLANT_TRANSMISSION_STATE))]


def chosen_topics(bag: BagReader, topics: Sequence[str] | None, everything: bool) -> list[str]:
    """
    Return the topics to publish.

    Args:
        bag: that is played.
        topics: chosen by the user, with or without a leading slash; none: the inputs.
        everything: whether to publish all topics but /clock.

    Returns:
        Their names in the bag.

    Raises:
        InputError: a topic is not in the bag, or there is none to play.

    """
    if everything:
        chosen = [topic for topic in bag.topics if topic != '/clock']
    elif topics:
        chosen = []
        for topic in topics:
            names = [name for name in (topic, '/' + topic) if name in bag.topics]
            bag.require(names[0] if names else topic)
            chosen.append(names[0])
    else:
        chosen = default_topics(bag.topics)
    if not chosen:
        available = ', '.join(sorted(bag.topics)) or 'none'
        raise InputError(f'{bag.path}: topics: none to play, expected {JOINT_STATES} or a choice '
                         f'of {available}')
    return chosen


class PlayNode(Node):
    """
    Publishes `topics` of `bag`, `rate` times as fast as recorded.

    loop: whether to start again at the end; clock: whether to publish /clock.
    """

    def __init__(self, bag: BagReader, topics: Sequence[str], rate: float, loop: bool,
                 clock: bool) -> None:
        super().__init__('play')
        self.bag, self.topics, self.rate, self.loop = bag, topics, rate, loop
        self.count: Counter[str] = Counter()
        self._outputs = {}
        for topic in topics:
            msgtype = bag.topics[topic][0]
            try:
                message = import_message(msgtype)
            except ImportError:
                raise InputError(f'{bag.path}: topic {topic} has type {msgtype}, which is not '
                                 'installed here; choose others with --topics') from None
            self._outputs[topic] = advertise(self, message, topic, QUEUE)
        self._clock_out = advertise(self, ClockMessage, '/clock', 10) if clock else None
        self._next: tuple[str, int, int, bytes] | None = None
        self._created = time.monotonic()
        self._matched: float | None = None
        self._timer = steady_timer(self, 1e-3, self._work)

    def _may_begin(self) -> bool:
        """Return whether somebody listens, or nobody has come in time."""
        time_s = time.monotonic()
        if self._matched is None and any(
                out.get_subscription_count() for out in self._outputs.values()):
            self._matched = time_s
        if self._matched is not None:
            return time_s > self._matched + SETTLE_TIME
        if time_s > self._created + MATCH_TIME:
            self.get_logger().warning('nobody listens to ' + ', '.join(self.topics))
            return True
        return False

    def _begin(self) -> None:
        """Start with the first message of the bag."""
        self._messages = self.bag.messages(self.topics)
        self._next = next(self._messages, None)
        if self._next is None:
            raise InputError(f'{self.bag.path}: no message on {", ".join(self.topics)}')
        self._first = self._next[1]
        self._start = time.monotonic_ns()
        self._clock_due = self._start

    def _work(self) -> None:
        """Publish for one block of time, each message when it is due."""
        if self._next is None:
            if not self._may_begin():
                time.sleep(BLOCK_TIME)
                return
            self._begin()
        end = time.monotonic_ns() + int(BLOCK_TIME * SECOND)
        while self._next is not None:
            topic, log_ns, _, raw = self._next
            deadline = self._start + int((log_ns - self._first) / self.rate)
            self._sleep_until(min(deadline, end))
            if deadline > end:
                return
            self._outputs[topic].publish(raw)
            self.count[topic] += 1
            self._next = next(self._messages, None)
            if time.monotonic_ns() > end:
                return
        if self.loop:
            self._begin()
        else:
            finish(self._timer, self._outputs.values())

    def _sleep_until(self, deadline: int) -> None:
        """Sleep until `deadline` (monotonic, ns), publishing /clock on the way."""
        while True:
            time_ns = time.monotonic_ns()
            if self._clock_out and time_ns >= self._clock_due:
                self._clock_out.publish(ClockMessage(clock=to_time(
                    self._first + int((time_ns - self._start) * self.rate))))
                self._clock_due = time_ns + int(CLOCK_PERIOD * SECOND)
            if time_ns >= deadline:
                return
            wake = min(deadline, self._clock_due) if self._clock_out else deadline
            time.sleep(max(0, wake - time_ns) / SECOND)

    def close(self) -> None:
        """Report how many messages were published."""
        counts = ', '.join(f'{topic} {self.count[topic]}' for topic in self.topics)
        print(f'{self.bag.path}: published {counts}', file=sys.stderr)
        if self.bag.notice:
            print(self.bag.notice, file=sys.stderr)


def play(path: str | Path, rate: float = 1.0, topics: Sequence[str] | None = None,
         everything: bool = False, loop: bool = False, clock: bool = True,
         ros_args: Sequence[str] = ()) -> int:
    """
    Publish a bag, until its end, SIGINT or SIGTERM; call it from the main thread.

    Args:
        path: of the bag.
        rate: times as fast as recorded.
        topics: to publish, see chosen_topics.
        everything: whether to publish all topics.
        loop: whether to start again at the end.
        clock: whether to publish /clock.
        ros_args: further arguments of rclpy.init.

    Returns:
        The exit code.

    Raises:
        InputError: the bag or a topic cannot be read.

    """
    with open_bag(path) as bag:
        chosen = chosen_topics(bag, topics, everything)
        return spin_node(lambda: PlayNode(bag, chosen, rate, loop, clock),
                         ['gearbox_monitor play', *ros_args])
