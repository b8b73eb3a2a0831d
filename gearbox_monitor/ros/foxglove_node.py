# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Node `live`: passes the topics of an estimator to Foxglove, by its SDK."""
from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import foxglove
from foxglove.websocket import WebSocketServer
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.signals import DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, SIGNALS
from gearbox_monitor.ros.message_definition import message_definition
from gearbox_monitor.ros.qos import best_effort, latched
from gearbox_monitor.ros.runtime import drain, spin_node, steady_timer, subscribe_polled

PERIOD = 0.05  # s between two looks at the waiting messages
DEPTH = 2000   # messages of a topic that may wait between them


class FoxgloveNode(Node):
    """Passes the messages of an estimator, as they come, to the clients of `server`."""

    def __init__(self, server: WebSocketServer) -> None:
        super().__init__('live')
        self._server = server
        self._topics: list[tuple[Subscription, foxglove.Channel]] = []
        for topic in (JOINT_STATES, *(signal.topic for signal in SIGNALS)):
            self._pass_on(JointState, topic, best_effort(DEPTH))
        self._pass_on(DiagnosticArray, DIAGNOSTICS, best_effort(DEPTH))
        self._pass_on(DiagnosticArray, DRIFT_ALERTS, latched())
        self._timer = steady_timer(self, PERIOD, self._forward)

    def _pass_on(self, kind: Any, topic: str, qos: QoSProfile) -> None:
        """Open a channel for messages of class `kind` on `topic`."""
        subscription = subscribe_polled(self, kind, topic, qos, raw=True)
        name = f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
        schema = foxglove.Schema(name=name, encoding='ros2msg',
                                 data=message_definition(name).encode())
        self._topics.append((subscription, foxglove.Channel(
            subscription.topic_name, schema=schema, message_encoding='cdr')))

    def _forward(self) -> None:
        """Pass on the messages that wait, with the times of their reception."""
        for subscription, channel in self._topics:
            for raw, info in drain(subscription, DEPTH):
                channel.log(bytes(raw), log_time=info['received_timestamp'])

    def close(self) -> None:
        """End the server."""
        self._server.stop()


def serve(host: str, port: int, ros_args: Sequence[str] = ()) -> int:
    """
    Serve Foxglove until SIGINT or SIGTERM; call it from the main thread.

    Args:
        host: address to listen on.
        port: to listen on, 0: any that is free.
        ros_args: further arguments of rclpy.init.

    Returns:
        The exit code.

    Raises:
        InputError: host or port cannot be used.

    """
    try:
        server = foxglove.start_server(name='gearbox_monitor', host=host, port=port)
    except (RuntimeError, OSError) as error:
        raise InputError(f'--host {host} --port {port}: {error}, expected a free port of an '
                         'address of this machine') from None
    print(f'ws://{host}:{server.port} serves Foxglove; Ctrl-C ends', flush=True)
    return spin_node(lambda: FoxgloveNode(server), ['gearbox_monitor live', *ros_args])
