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

"""Publish a bag's messages, as they are, with their recorded spacing and /clock."""
from collections import Counter
import sys
import time

from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.signals import JOINT_STATES, PLANT_TRANSMISSION_STATE
from gearbox_monitor.ros.definition import import_message
from gearbox_monitor.ros.qos import advertise
from gearbox_monitor.ros.runtime import spin_node

SECOND = 1_000_000_000
BLOCK_TIME = 0.02      # s between two looks at signals and services
CLOCK_PERIOD = 0.01    # s between two /clock messages
MATCH_TIME = 5.0       # s to wait for a subscriber before the first message
SETTLE_TIME = 0.3      # s for the match to become known on the other side, too
QUEUE = 10_000         # messages kept for a slow subscriber


def default_topics(topics):
    """Return those of the bag's `topics` that are inputs: joint_states and the plant's truth."""
    return [topic for topic in topics
            if topic.lstrip('/') in (JOINT_STATES, PLANT_TRANSMISSION_STATE)
            or topic.endswith(('/' + JOINT_STATES, '/' + PLANT_TRANSMISSION_STATE))]


def chosen_topics(bag, topics, everything):
    """Return the topics of `bag` (bag.read) to publish; raises InputError."""
    if everything:
        chosen = [topic for topic in bag.topics if topic != '/clock']
    elif topics:
        chosen = []
        for topic in topics:
            there = [t for t in (topic, '/' + topic) if t in bag.topics]
            bag.require(there[0] if there else topic)
            chosen.append(there[0])
    else:
        chosen = default_topics(bag.topics)
    if not chosen:
        there = ', '.join(sorted(bag.topics)) or 'none at all'
        raise InputError(f'{bag.path}: topics: none to play, expected {JOINT_STATES} or a choice '
                         f'of {there}')
    return chosen


class PlayNode(Node):
    """Publishes `topics` of `bag`, `rate` times as fast as recorded."""

    def __init__(self, bag, topics, rate, loop, clock):
        super().__init__('play')
        self.bag, self.topics, self.rate, self.loop = bag, topics, rate, loop
        self.count = Counter()
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
        self._messages = self._next = None
        self._created = time.monotonic()
        self._matched = None
        self._timer = self.create_timer(
            1e-3, self._work, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _ready(self):
        """Return True once somebody listens, or has not come in time."""
        now = time.monotonic()
        if self._matched is None and any(
                out.get_subscription_count() for out in self._outputs.values()):
            self._matched = now
        if self._matched is not None:
            return now > self._matched + SETTLE_TIME
        if now > self._created + MATCH_TIME:
            self.get_logger().warning('nobody listens to ' + ', '.join(self.topics))
            return True
        return False

    def _begin(self):
        """Take the bag from its first message."""
        self._messages = self.bag.messages(self.topics)
        self._next = next(self._messages, None)
        if self._next is None:
            raise InputError(f'{self.bag.path}: no message on {", ".join(self.topics)}')
        self._first = self._next[1]
        self._start = time.monotonic_ns()
        self._clock_due = self._start

    def _work(self):
        """Publish for one block of time, each message when it is due."""
        if self._messages is None:
            if not self._ready():
                time.sleep(BLOCK_TIME)
                return
            self._begin()
        end = time.monotonic_ns() + int(BLOCK_TIME * SECOND)
        while self._next is not None:
            topic, log_ns, _, raw = self._next
            due = self._start + int((log_ns - self._first) / self.rate)
            self._sleep_until(min(due, end))
            if due > end:
                return
            self._outputs[topic].publish(raw)
            self.count[topic] += 1
            self._next = next(self._messages, None)
            if time.monotonic_ns() > end:
                return
        if self.loop:
            self._begin()
        else:
            self._finish()

    def _sleep_until(self, due):
        """Sleep until `due` (monotonic, ns), publishing /clock on the way."""
        while True:
            now = time.monotonic_ns()
            if self._clock_out and now >= self._clock_due:
                self._publish_clock(self._first + int((now - self._start) * self.rate))
                self._clock_due = now + int(CLOCK_PERIOD * SECOND)
            if now >= due:
                return
            wake = min(due, self._clock_due) if self._clock_out else due
            time.sleep(max(0, wake - now) / SECOND)

    def _publish_clock(self, ns):
        message = ClockMessage()
        message.clock.sec, message.clock.nanosec = divmod(ns, SECOND)
        self._clock_out.publish(message)

    def _finish(self):
        """End, after all messages have arrived."""
        self._timer.cancel()
        for publisher in self._outputs.values():
            publisher.wait_for_all_acked(Duration(seconds=2))
        raise ExternalShutdownException

    def close(self):
        """Say what was published."""
        counts = ', '.join(f'{topic} {self.count[topic]}' for topic in self.topics)
        print(f'{self.bag.path}: published {counts}', file=sys.stderr)
        if self.bag.notice:
            print(self.bag.notice, file=sys.stderr)


def play(path, rate=1.0, topics=None, everything=False, loop=False, clock=True, ros_args=()):
    """
    Publish the bag `path`; return the exit code. Raises InputError.

    Call it from the main thread; ends with the bag, or with SIGINT or SIGTERM.
    """
    with open_bag(path) as bag:
        chosen = chosen_topics(bag, topics, everything)
        return spin_node(lambda: PlayNode(bag, chosen, rate, loop, clock),
                         ['gearbox_monitor play', *ros_args])
