# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Node `live`: gathers what an estimator publishes and lets an EventServer show it."""
from collections.abc import Sequence
from datetime import datetime
import json
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from gearbox_monitor.recordings.topics import (
    DIAGNOSTICS, DRIFT_ALERTS, SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.report.live_history import GearboxHistory, StatusAlert
from gearbox_monitor.report.live_page import live_frame, LivePage
from gearbox_monitor.ros.convert import stamp_of
from gearbox_monitor.ros.event_server import EventServer
from gearbox_monitor.ros.qos import best_effort, latched, subscribe
from gearbox_monitor.ros.runtime import drain, RMWError, spin_node, steady_timer, subscribe_polled
from gearbox_monitor.ros.watcher import level_of

MOTION = next(signal.topic for signal in SIGNALS if signal.smoothed)
PERIOD = 0.1           # s between two drawings
DEPTH = 2000           # messages that may wait between them
MAX_BYTES = 1 << 16    # longer messages are left out
MAX_GEARBOXES = 32     # anybody can publish any names


class LiveNode(Node):
    """Shows the gearboxes of the node `estimator` on the page of `server`."""

    def __init__(self, estimator: str, server: EventServer) -> None:
        super().__init__('live')
        self._server, self._page = server, LivePage()
        namespace = self.get_namespace().rstrip('/')
        self._source = estimator if estimator.startswith('/') else f'{namespace}/{estimator}'
        self._gearboxes: dict[str, GearboxHistory] = {}
        self._motion = subscribe_polled(self, JointState, MOTION, best_effort(DEPTH), raw=True)
        subscribe(self, DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, 50)
        subscribe(self, DiagnosticArray, DRIFT_ALERTS, self._on_alert, latched())
        self._timer = steady_timer(self, PERIOD, self._draw)

    def _gearbox(self, name: str) -> GearboxHistory | None:
        """Return the gearbox `name`; None: there are too many."""
        if name not in self._gearboxes and len(self._gearboxes) < MAX_GEARBOXES:
            self._gearboxes[name] = gearbox = GearboxHistory(name)
            path = self._source if name == TRANSMISSION else f'{self._source}/{name}'
            try:
                self.create_subscription(
                    DiagnosticArray, f'{path}/{SNAPSHOT}',
                    lambda message: _read_axis(gearbox, message), latched())
            except InvalidTopicNameException:
                pass  # anybody can publish any name: it is shown, in the units of a rotary axis
        return self._gearboxes.get(name)

    def _draw(self) -> None:
        """Take the messages that wait; draw, if anybody looks."""
        rows: dict[str, list[tuple[int, float, float]]] = {}
        for raw, _ in drain(self._motion, DEPTH):
            if len(raw) > MAX_BYTES:
                continue
            try:
                message = deserialize_message(raw, JointState)
            except (RMWError, UnicodeDecodeError):
                continue
            stamp = stamp_of(message)
            for name, twist, torque in zip(message.name, message.position, message.effort):
                rows.setdefault(name, []).append((stamp, twist, torque))
        for name, samples in rows.items():
            gearbox = self._gearbox(name)
            if gearbox is not None:
                gearbox.add_motion(np.array([s[0] for s in samples], np.int64),
                                   np.array([s[1:] for s in samples]))
        if self._server.clients:
            self._server.publish(self._page.parts(
                list(self._gearboxes.values()), self._source, time.monotonic()))

    def _ours(self, status: DiagnosticStatus) -> tuple[GearboxHistory | None, str]:
        """Return gearbox and component of `status`; None: it is of another node."""
        node, _, component = status.name.partition(': ')
        source = self._source.lstrip('/')
        if node == source:
            gearbox = self._gearbox(TRANSMISSION)
        elif node.startswith(f'{source}/'):
            gearbox = self._gearbox(node.removeprefix(f'{source}/'))
        else:
            gearbox = None
        if gearbox is not None:
            gearbox.serial = status.hardware_id
        return gearbox, component

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            gearbox, component = self._ours(status)
            if gearbox is not None:
                gearbox.add_status(time.monotonic(), component, int(level_of(status)),
                                   status.message, {v.key: v.value for v in status.values})

    def _on_alert(self, message: DiagnosticArray) -> None:
        when = datetime.fromtimestamp(stamp_of(message) * 1e-9).strftime('%Y-%m-%d %H:%M:%S')
        for status in message.status:
            gearbox, component = self._ours(status)
            if gearbox is not None:
                gearbox.add_alert(StatusAlert(
                    component, int(level_of(status)), status.message, when))

    def close(self) -> None:
        """End the server."""
        self._server.close()


def _read_axis(gearbox: GearboxHistory, message: DiagnosticArray) -> None:
    """Take the axis of `gearbox` from the model in a snapshot."""
    for status in message.status:
        for value in status.values:
            if value.key == 'model':
                try:
                    gearbox.axis = str(json.loads(value.value)['axis'])
                except (ValueError, KeyError, TypeError):
                    pass  # anybody can publish anything: the units stay


def serve(host: str, port: int, estimator: str, ros_args: Sequence[str] = ()) -> int:
    """
    Serve the live page until SIGINT or SIGTERM; call it from the main thread.

    Args:
        host: address to listen on.
        port: to listen on, 0: any that is free.
        estimator: name of the node, relative to the namespace or absolute.
        ros_args: further arguments of rclpy.init.

    Returns:
        The exit code.

    Raises:
        InputError: host or port cannot be used.

    """
    server = EventServer(live_frame(), host, port)
    print(f'{server.address} shows {estimator}; Ctrl-C ends', flush=True)
    code = spin_node(lambda: LiveNode(estimator, server), ['gearbox_monitor live', *ros_args])
    if not server.ended:  # the node never began
        server.close()
    return code
