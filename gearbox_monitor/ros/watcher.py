# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A node that follows an estimator in another process: its state and its diagnostics."""
from collections.abc import Sequence
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from gearbox_monitor.health.checks.outcome import Level, Outcome
from gearbox_monitor.recordings.topics import (
    DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, PLANT_TRANSMISSION_STATE, SNAPSHOT)
from gearbox_monitor.ros.runtime import latched


class Watcher:
    """
    Node `name` in ROS domain `domain`, in its own context; it installs no signal handlers.

    gearboxes: of the estimator, ('',) for a single one without a name.

    joints: {gearbox: {component: Outcome}} of the estimator's newest diagnostics, values as texts;
    outcomes: those of the first gearbox; recorder: the recorder's Outcome or None; alerts: texts
    of the drift alerts, oldest first; updates: number of diagnostics of the estimator; snapshots:
    those of the estimator, {name: text}, oldest first: the first one holds the state at its start.
    """

    def __init__(self, name: str, domain: int, gearboxes: Sequence[str] = ('',)) -> None:
        self.joints: dict[str, dict[str, Outcome]] = {gearbox: {} for gearbox in gearboxes}
        self.outcomes = self.joints[gearboxes[0]]
        self.recorder: Outcome | None = None
        self.alerts: list[str] = []
        self.updates = 0
        self.snapshots: list[dict[str, str]] = []
        self._context = rclpy.Context()
        rclpy.init(args=['--ros-args', '--disable-external-lib-logs'], context=self._context,
                   domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(name, context=self._context, enable_rosout=False,
                          start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        subscribe = self._node.create_subscription
        subscribe(DiagnosticArray, DIAGNOSTICS, self._on_diagnostics, 20)
        subscribe(DiagnosticArray, DRIFT_ALERTS, self._on_alert, latched())
        for gearbox in gearboxes:
            subscribe(DiagnosticArray, f'estimator/{gearbox}/{SNAPSHOT}'.replace('//', '/'),
                      self._on_snapshot, latched())

    def spin(self, seconds: float) -> None:
        """Receive messages for `seconds`."""
        end = time.monotonic() + seconds
        while (remaining := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=remaining)

    def ready(self) -> bool:
        """Return whether estimator and recorder subscribe to the topics of a plant."""
        return (len(self.snapshots) >= len(self.joints)
                and self._node.count_subscribers(JOINT_STATES) >= 2
                and self._node.count_subscribers(PLANT_TRANSMISSION_STATE) >= 1)

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def _on_snapshot(self, message: DiagnosticArray) -> None:
        self.snapshots += [{value.key: value.value for value in status.values}
                           for status in message.status]

    def _on_alert(self, message: DiagnosticArray) -> None:
        for status in message.status:
            gearbox = _gearbox(status)
            self.alerts.append(f'{level_of(status).name}: ' + (f'{gearbox}: ' if gearbox else '')
                               + status.message)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            node, _, component = status.name.partition(': ')
            outcome = Outcome.of(level_of(status), 'as_written', {
                value.key: value.value for value in status.values}, text=status.message)
            if node.partition('/')[0] == 'estimator':
                self.joints.setdefault(_gearbox(status), {})[component] = outcome
            elif node == 'recorder':
                self.recorder = outcome
        self.updates += (message.status[0].name.startswith(('estimator: ', 'estimator/'))
                         if message.status else 0)


def _gearbox(status: DiagnosticStatus) -> str:
    """Return the gearbox that a `status` of the estimator is about, '' for a single one."""
    return str(status.name.partition(': ')[0].partition('/')[2])


def level_of(status: DiagnosticStatus) -> Level:
    """Return the Level of `status`."""
    return Level(min(ord(status.level), Level.ERROR))
