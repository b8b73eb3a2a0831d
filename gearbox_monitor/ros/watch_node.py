# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Node `watch`: learns a robot while it works, then says what changes, and what it holds.

Takes joint_states and robot_description as any robot publishes them. A child process, which gives
way to all others, does the work; it knows no ROS, and gives what `gearbox_monitor watch` gives for
a bag of the same messages. Publishes one status for each joint and one of the robot, ~/findings
(JSON, latched), payload and payload_stddev. Services ~/learn_again, ~/tare, ~/save_baseline.

  ros2 launch gearbox_monitor watch.launch.py
"""
from collections import deque
from collections.abc import Sequence
import json
import math
import os
from pathlib import Path
from queue import Full, Queue
import subprocess
import sys
from threading import Thread
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import InertiaStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from gearbox_monitor.health.alarms import Level
from gearbox_monitor.parameters import WATCH_NODE, WatchParameters
from gearbox_monitor.recordings.topics import (
    DIAGNOSTICS, FINDINGS, JOINT_STATES, PAYLOAD, PAYLOAD_STD, ROBOT_DESCRIPTION)
from gearbox_monitor.ros.convert import LEVELS, stamp_of, to_diagnostics, to_time
from gearbox_monitor.ros.middleware import child_environment
from gearbox_monitor.ros.runtime import (
    advertise, best_effort, declare, drain, latched, spin_node, steady_timer, subscribe,
    subscribe_polled, TableNode)
from gearbox_monitor.ros.watch_child import DESCRIPTION, ROWS, SERVICES

DEPTH = 5000    # messages that may wait
WAITING = 600   # orders of a second each that wait while the child learns
SILENT, BEHIND = 5.0, 300.0     # s without a message, or without a block of them: reported
END = 20.0      # s that the child may take for its last block


class WatchChild:
    """The child process: orders go in, its lines come out; threads of its own wait for it."""

    def __init__(self, state: Path) -> None:
        self.told: deque[dict[str, Any]] = deque(maxlen=100)
        self.dropped = 0
        self._orders: Queue[str | None] = Queue(WAITING)
        self._child = subprocess.Popen(
            [sys.executable, '-m', 'gearbox_monitor.ros.watch_child', str(state),
             str(os.getpid())], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=child_environment(), start_new_session=True)
        self._threads = [Thread(target=x, daemon=True) for x in (self._write, self._read)]
        for thread in self._threads:
            thread.start()

    @property
    def alive(self) -> bool:
        """Whether the child still runs."""
        return self._child.poll() is None

    def order(self, name: str, content: Any = None) -> None:
        """Hand over the order `name` with `content`; if too many wait, it is dropped, counted."""
        try:
            self._orders.put_nowait(json.dumps((name, content), default=list) + '\n')
        except Full:
            self.dropped += len(content) if name == ROWS else 1

    def _write(self) -> None:
        assert self._child.stdin is not None
        try:
            while (order := self._orders.get()) is not None:
                self._child.stdin.write(order)
                self._child.stdin.flush()
            self._child.stdin.close()
        except OSError:
            pass        # the child has ended

    def _read(self) -> None:
        assert self._child.stdout is not None
        for line in self._child.stdout:
            self.told.append(json.loads(line))

    def close(self) -> None:
        """Let the child take what it has, and end it."""
        self._orders.put(None)
        try:
            self._child.wait(END)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()


class WatchNode(TableNode):
    """Shell around a WatchChild; see the module."""

    def __init__(self, **node: Any) -> None:
        super().__init__('watch', **node)
        values = WatchParameters.from_mapping(declare(self, WATCH_NODE))
        home = os.environ.get('ROS_HOME') or Path.home() / '.ros'
        name = self.get_fully_qualified_name().strip('/').replace('/', '.')
        self._child = WatchChild(Path(values.state_file or Path(home, f'{name}.state')))
        self._known: dict[str, Any] = {}
        self._described, self._last, self._count = False, time.monotonic(), 0
        self._taken, self._newest = self._last, -1      # newest: stamp of the child's last block
        self._fresh = False     # until a block was compared: the state file is old
        self._findings = advertise(self, String, FINDINGS, latched())
        self._payload = [advertise(self, InertiaStamped, topic, 10)
                         for topic in (PAYLOAD, PAYLOAD_STD)]
        self._diagnostics = advertise(self, DiagnosticArray, DIAGNOSTICS, 10)
        self._states = subscribe_polled(self, JointState, JOINT_STATES, best_effort(DEPTH))
        self._description = subscribe(
            self, String, ROBOT_DESCRIPTION, self._describe, QoSProfile(
                depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        for service in SERVICES:
            self.create_service(Trigger, f'~/{service}', self._service(service))
        # Wall time: missing data must be reported while a simulation's clock stands, too.
        self._timer = steady_timer(self, 1.0, self._report)
        self.warn_of_unknown()

    def _describe(self, message: String) -> None:
        self._hand_over()
        self._child.order(DESCRIPTION, message.data)
        self._described = True
        self._hand_over()

    def _service(self, name: str) -> Any:
        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self._hand_over()
            self._child.order(name)
            response.success = self._described and self._child.alive
            response.message = ('done with the next block' if response.success else
                                'no robot is watched: no robot_description')
            return response
        return answer

    def _hand_over(self) -> None:
        """Hand over what has come."""
        rows = [(stamp_of(m), m.name, m.position, m.velocity, m.effort)
                for m, _ in drain(self._states)]
        if rows:
            self._count, self._last = self._count + len(rows), time.monotonic()
            self._child.order(ROWS, rows)

    def _report(self) -> None:
        """Publish what the child has told since, and the state of the robot once a second."""
        self._hand_over()
        while self._child.told:
            self._known = self._child.told.popleft()
            for event in self._known['events']:
                self.get_logger().info(event)
            if data := self._known['data']:
                self._publish(data)
                if data['stamp_ns'] != self._newest:
                    self._fresh = self._newest >= 0
                    self._newest, self._taken = data['stamp_ns'], time.monotonic()
        self._diagnostics.publish(to_diagnostics(
            self._statuses(), self.get_clock().now().to_msg()))

    def _publish(self, data: dict[str, Any]) -> None:
        """Publish the findings, and what the last link holds."""
        self._findings.publish(String(data=json.dumps(data)))
        for held in data['payloads'][-1:]:
            for publisher, mass, centre in zip(self._payload, (held['m'], held['m_std']),
                                               (held['centre'], held['centre_std'])):
                message = InertiaStamped()
                message.header.stamp, message.header.frame_id = to_time(
                    data['stamp_ns']), held['link']
                message.inertia.m = mass
                com = message.inertia.com
                com.x, com.y, com.z = (math.nan if x is None else x for x in centre)
                publisher.publish(message)

    def _statuses(self) -> list[DiagnosticStatus]:
        """Return a status of the robot, and one of each joint."""
        known, data, now = self._known, self._known.get('data', {}), time.monotonic()
        problem = (
            'the process that watches has ended: start the node again'
            if not self._child.alive else
            f'no {ROBOT_DESCRIPTION}' if not self._described else
            'no joint_states' if now - self._last > SILENT else
            f'nothing of joint_states is taken for {BEHIND:.0f} s: their stamps are 0 or set '
            'back, or the computer is too slow' if now - self._taken > BEHIND else
            known.get('problem') or ('' if self._fresh or data.get('phase') != 'watch' else
                                     'nothing compared since the start'))
        values = {'phase': data.get('phase', ''), 'problem': problem, 'samples': str(self._count),
                  'dropped': str(self._child.dropped + known.get('dropped', 0))}
        out = [self._status('robot', problem or data.get('summary', 'starts'),
                            DiagnosticStatus.WARN if problem else _level(data.get('level')),
                            values)]
        for name, joint in data.get('joints', {}).items():
            words = [f['words'] for f in data['findings'] if f['joint'] == name]
            out.append(self._status(
                name, '; '.join(words) or joint['words'], _level(joint['level'], problem),
                {f'{kind}_{key}': f'{state[key]:.4g}' for kind, state in joint['states'].items()
                 if state['judged'] for key in ('size', 'std')}))
        return out

    def _status(self, place: str, message: str, level: bytes, values: dict[str, str]
                ) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=level, message=message,
            name=f'{self.get_fully_qualified_name().lstrip("/")}: {place}',
            values=[KeyValue(key=key, value=value) for key, value in values.items()])

    def close(self) -> None:
        """Hand over what has come, and let the child write its state."""
        self._hand_over()
        self._child.close()


def _level(level: int | None, problem: str = '') -> bytes:
    """Return the level of a status; neither an unknown nor, with a `problem`, an old one is OK."""
    out: bytes = DiagnosticStatus.STALE if level is None or (
        problem and level == Level.OK) else LEVELS[level]
    return out


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(WatchNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
