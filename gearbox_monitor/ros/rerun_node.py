# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Node `live`: sends the topics of an estimator to a Rerun viewer, by its SDK."""
from collections.abc import Iterable, Sequence
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
import rerun
import rerun.blueprint as layout
from sensor_msgs.msg import JointState

from gearbox_monitor.interfaces.signals import DIAGNOSTICS, DRIFT_ALERTS, JOINT_STATES, SIGNALS
from gearbox_monitor.ros.convert import stamp_of
from gearbox_monitor.ros.qos import best_effort, latched, subscribe
from gearbox_monitor.ros.runtime import (
    drain, RMWError, spin_node, steady_timer, subscribe_polled)
from gearbox_monitor.ros.watcher import level_of

PERIOD = 0.1  # s between two looks at the waiting messages
DEPTH = 2000  # messages of a topic that may wait between them
TIMELINE = 'stamp'
FIELDS = ('position', 'velocity', 'effort')
LEVELS = ('INFO', 'WARN', 'ERROR')  # of OK, WARN, ERROR


def views() -> layout.Blueprint:
    """Return the layout: torque, twist, innovations, and what diagnostics and alerts say."""
    def series(name: str, *contents: str) -> layout.TimeSeriesView:
        return layout.TimeSeriesView(name=name, contents=list(contents))
    return layout.Blueprint(layout.Horizontal(
        layout.Vertical(
            series('torque of the transmission', '/transmission_state/effort/**',
                   '/transmission_state_smoothed/effort/**'),
            series('twist', '/transmission_state/position/**',
                   '/transmission_state_smoothed/position/**'),
            series('innovations', '/innovations/**', '/innovations_stddev/**')),
        layout.Vertical(
            layout.TextLogView(name='diagnostics and alerts',
                               contents=['/diagnostics/text/**', '/drift_alerts/text/**']),
            series('backlash', '/diagnostics/gap_rad/**', '/diagnostics/baseline_gap_rad/**'))))


class RerunNode(Node):
    """Sends the messages of an estimator, with their stamps, to the `stream` of a viewer."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        super().__init__('live')
        self._stream = stream
        self._topics: list[tuple[str, Subscription]] = [
            (topic, subscribe_polled(self, JointState, topic, best_effort(DEPTH), raw=True))
            for topic in (JOINT_STATES, *(signal.topic for signal in SIGNALS))]
        self._texts: dict[str, tuple[int, str]] = {}  # last level and message of each entity
        for topic, qos in ((DIAGNOSTICS, 50), (DRIFT_ALERTS, latched())):
            subscribe(self, DiagnosticArray, topic,
                      partial(self._on_statuses, topic.strip('/')), qos)
        self._timer = steady_timer(self, PERIOD, self._send)

    def _send(self) -> None:
        """Send the messages that wait, one column for each value of a joint."""
        for topic, subscription in self._topics:
            columns: dict[str, list[tuple[int, float]]] = {}
            for raw, _ in drain(subscription, DEPTH):
                try:
                    message = deserialize_message(raw, JointState)
                except (RMWError, UnicodeDecodeError):
                    continue  # anybody can publish anything
                for name, stamp, value in _values(message):
                    columns.setdefault(name, []).append((stamp, value))
            for name, rows in columns.items():
                stamps, values = zip(*rows)
                self._stream.send_columns(
                    f'{topic}/{name}', [_times(stamps)], rerun.Scalars.columns(scalars=values))

    def _on_statuses(self, topic: str, message: DiagnosticArray) -> None:
        """Send new texts of `message` and every number among its values."""
        times = [_times([stamp_of(message)])]
        for status in message.status:
            entity = f'{topic}/text/{_part(status.name)}'
            text = level, words = int(level_of(status)), status.message
            if self._texts.get(entity) != text:
                self._texts[entity] = text
                self._stream.send_columns(entity, times, rerun.TextLog.columns(
                    text=[f'{status.name}: {words}'], level=[LEVELS[min(level, 2)]]))
            for key, number in _numbers(status):
                self._stream.send_columns(
                    f'{topic}/{_part(key)}/{_part(status.name)}', times,
                    rerun.Scalars.columns(scalars=[number]))

    def close(self) -> None:
        """Send what waits in the stream and end it."""
        try:
            self._stream.flush(timeout_sec=1.0)
        except RuntimeError:
            pass  # the viewer has ended
        self._stream.disconnect()


def _part(name: str) -> str:
    """Return `name` as one part of the path of an entity."""
    return rerun.escape_entity_path_part(name)


def _times(stamps_ns: Sequence[int]) -> rerun.TimeColumn:
    return rerun.TimeColumn(TIMELINE, timestamp=np.array(stamps_ns, 'datetime64[ns]'))


def _values(message: JointState) -> Iterable[tuple[str, int, float]]:
    """Yield (field/joint, stamp in ns, value) of each value of `message`."""
    stamp = stamp_of(message)
    for field in FIELDS:
        for joint, value in zip(message.name, getattr(message, field)):
            yield f'{field}/{_part(joint)}', stamp, value


def _numbers(status: DiagnosticStatus) -> Iterable[tuple[str, float]]:
    for pair in status.values:
        try:
            yield pair.key, float(pair.value)
        except ValueError:
            pass  # a text or a flag


def serve(host: str, port: int, ros_args: Sequence[str] = ()) -> int:
    """
    Send to a Rerun viewer until SIGINT or SIGTERM; call it from the main thread.

    Args:
        host: address of the viewer.
        port: of the viewer.
        ros_args: further arguments of rclpy.init.

    Returns:
        The exit code.

    """
    stream = rerun.RecordingStream('gearbox_monitor')
    stream.connect_grpc(f'rerun+http://{host}:{port}/proxy', default_blueprint=views())
    print(f'sending to the Rerun viewer on {host}:{port}; Ctrl-C ends', flush=True)
    return spin_node(lambda: RerunNode(stream), ['gearbox_monitor live', *ros_args])
