# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One subscription to joint_states for all gearboxes of a node, and one to a topic of an arm."""
from collections.abc import Callable, Iterable, Sequence
from itertools import zip_longest
import time
from typing import TypeAlias

from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from gearbox_monitor.recordings.topics import JOINT_STATES
from gearbox_monitor.ros.gearbox_input import GearboxInput, Info, TakenSample
from gearbox_monitor.ros.qos import best_effort, subscribe
from gearbox_monitor.ros.runtime import alone, Arrivals, drain, RMWError

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

    inputs: of the gearboxes. samples [(index of the input, TakenSample)]: of one message, at most
    one of each input.
    """

    def __init__(self, node: Node, inputs: Sequence[GearboxInput],
                 take: Callable[[TakenSamples], None]) -> None:
        self._inputs, self._take = inputs, take
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

    def _unpacked(self, raw: bytes) -> JointState | None:
        """Return the JointState of the bytes `raw`; None if they are none or too many."""
        if len(raw) <= MAX_BYTES:
            try:
                return deserialize_message(raw, JointState)
            except (RMWError, UnicodeDecodeError):
                pass  # anybody can publish any bytes
        for joint_input in self._inputs:
            joint_input.count_unreadable()
        return None

    def _take_message(self, raw: bytes, info: Info) -> None:
        message = self._unpacked(raw)
        if message is None:
            return
        if len(self._inputs) == 1:
            self._take_each(self._inputs[0].samples(message, info))
            return
        samples = [(k, sample) for k, joint_input in enumerate(self._inputs)
                   for sample in joint_input.samples(message, info)]
        if samples:
            self._take(samples)

    def _take_arm(self, raw: bytes, info: Info) -> None:
        message = self._unpacked(raw)
        if message is not None:
            self._take_each(self._inputs[0].arm_samples(message, info))

    def _take_each(self, samples: Iterable[TakenSample]) -> None:
        """Take the `samples` of a single gearbox one by one: a message may complete several."""
        for sample in samples:
            self._take([(0, sample)])
