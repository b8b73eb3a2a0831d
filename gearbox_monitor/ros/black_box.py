# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The last minutes of the measurement, written on request or at an alert."""
from collections.abc import Callable, Sequence
from threading import Thread

from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.task import Future

from gearbox_monitor.health import wear_outcome
from gearbox_monitor.health.health_record import GROSS
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.ros.recording_export import (
    export_recording, RecordingBuffer, RecordingContext, Rows)

KEEP = 'keep_recording'  # the service
RETRY = 10.0  # s after a recording of an alert failed


class BlackBox:
    """
    The recording of one gearbox that the estimator `node` holds in memory.

    monitor: whose alerts are watched; parameters: of the gearbox; topic: where the samples come
    from; service: full name of the one that keeps the recording. buffer: the rows in memory, None
    if none are kept.
    """

    def __init__(self, node: Node, monitor: Monitor, parameters: EstimatorParameters,
                 topic: str, service: str) -> None:
        self._node, self._monitor, self._topic = node, monitor, topic
        self._service = service
        span = 60.0 * parameters.keep_minutes
        self.buffer = RecordingBuffer(span) if span else None
        self._writer: Thread | None = None  # while it writes what the buffer holds
        self._keeps_alerts = bool(span and parameters.keep_folder)
        # Components that are ERROR: the alert of those from an earlier run is not news.
        self._wrong = self._components_in_error()
        self._alerts: dict[str, float] = {}  # {component: time of an alert not written yet}
        self._attempt = 0.0  # time before which nothing is tried again
        self._texts: dict[str, str] = {}  # {component: what became of its newest alert}

    def add(self, stamp_ns: int, good: bool,
            values: tuple[float, float, float, float]) -> None:
        """
        Take a row.

        Args:
            stamp_ns: of the measurement, ns.
            good: whether the estimator could use it.
            values: see RecordingBuffer.add().

        """
        if self.buffer is not None:
            self.buffer.add(stamp_ns, good, values)

    def command(self) -> str:
        """Return the shell command that keeps the recording, or why it would not."""
        if self.buffer is None:
            return 'nothing is kept: set keep_minutes'
        return f'ros2 service call {self._service} std_srvs/srv/Trigger'

    def look(self, time_s: float) -> dict[str, str]:
        """
        Keep the recording if an alert was raised before `time_s` (s, of a steady clock).

        Returns {component: text}: what became of the newest alert of each.
        """
        if not self._keeps_alerts:
            return {}
        wrong = self._components_in_error()
        for component in wrong - self._wrong:
            self._alerts[component] = time_s
        self._wrong = wrong
        if self._alerts and self._writer is None and self.buffer and time_s >= self._attempt:
            self._attempt = time_s + RETRY
            alerts, self._alerts = self._alerts, {}
            self._texts.update(dict.fromkeys(alerts, 'being written'))
            self._node.executor.create_task(
                self._finish, alerts, time_s, self._start(sorted(alerts)))
        return self._texts

    def close(self) -> None:
        """Let a recording come to its end; keep that of an alert that was still waiting."""
        if self._writer is not None:
            self._writer.join()
        if self._alerts and self.buffer:
            components = sorted(self._alerts)
            _, text = self._export(self.buffer.rows(), self._context(components))
            # The node's own logger wants /rosout, which is gone by now.
            get_logger('estimator_end').warning(f'{", ".join(components)}: {text}')

    async def keep(self) -> tuple[bool, str]:
        """Keep the recording on request; return whether that went well, and the answer."""
        if self.buffer is None:
            return False, 'nothing is kept: keep_minutes is 0, expected more'
        if self._writer is not None:
            return False, 'a recording is being written: wait for its end'
        if not self.buffer:
            return False, f'no samples yet on {self._topic}'
        success, message = await self._start()
        self._writer = None
        if success:
            self._node.get_logger().info(message)
        else:
            self._node.get_logger().error(f'{KEEP}: {message}')
        return success, message

    def _components_in_error(self) -> set[str]:
        """Return the components of drift that are ERROR, also while no samples come."""
        stages = self._monitor.health.stages()
        return {component for component, tests in stages.items() if GROSS in tests.values()}

    def _context(self, components: Sequence[str] = ()) -> RecordingContext:
        monitor = self._monitor
        p, outcomes = monitor.parameters, wear_outcome.outcomes(monitor.health)
        reason = '; '.join(f'{name}: {outcomes[name].message}' for name in components)
        return RecordingContext(self._topic, (p.motor_joint, p.arm_joint), monitor.model,
                                monitor.estimator.drive.arm_load, p, reason or f'~/{KEEP}')

    def _start(self, components: Sequence[str] = ()) -> Future:
        """Write the rows in memory, in a thread; return the Future of (success, message)."""
        assert self.buffer is not None
        future = Future()
        self._writer = Thread(target=self._write, args=(
            self.buffer.rows(), self._context(components), future))
        self._writer.start()
        return future

    def _write(self, rows: Callable[[], Rows], context: RecordingContext,
               future: Future) -> None:
        """Write the rows; the thread."""
        future.set_result(self._export(rows, context))
        if self._node.executor is not None:  # it may have ended meanwhile
            self._node.executor.wake()

    @staticmethod
    def _export(rows: Callable[[], Rows], context: RecordingContext) -> tuple[bool, str]:
        try:
            return True, export_recording(context.parameters.keep_folder, rows(), context)
        except Exception as error:  # whatever it is, the estimates must go on
            return False, str(error) or type(error).__name__

    async def _finish(self, alerts: dict[str, float], time_s: float, future: Future) -> None:
        """Report the recording of `alerts` begun at `time_s`; one that failed is tried again."""
        good, text = await future
        self._writer = None
        names, logger = ', '.join(sorted(alerts)), self._node.get_logger()
        if good:
            if (late := time_s - min(alerts.values())) >= RETRY:
                text = f'{late:.0f} s after the alert: {text}'
            logger.warning(f'{names} became ERROR: {text}')
        else:
            self._alerts = alerts | self._alerts
            text = f'failed, tried every {RETRY:g} s: {text}'
            if all(not self._texts[name].startswith('failed') for name in alerts):
                logger.error(f'{names} became ERROR: {text}')
        self._texts.update(dict.fromkeys(alerts, text))
