# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The last minutes of the measurement, written on request or after an alert."""
from collections.abc import Callable, Sequence
from threading import Thread
import time

from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.task import Future

from gearbox_monitor.errors import InputError
from gearbox_monitor.monitoring.backlash import drift_words
from gearbox_monitor.monitoring.backlash.change import GROSS
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.ros.recording_buffer import RecordingBuffer, Rows
from gearbox_monitor.ros.recording_export import export_recording, RecordingContext
from gearbox_monitor.ros.recording_schedule import RecordingQuota, RecordingSchedule

KEEP = 'keep_recording'  # the service


class BlackBox:
    """
    The recording of one gearbox that the estimator `node` holds in memory.

    monitor: whose alerts are watched; parameters: of the gearbox; topic: where the samples come
    from; service: full name of the one that keeps the recording. buffer: the rows in memory, None
    if none are kept. Raises InputError for a keep_after_error that is impossible.
    """

    def __init__(self, node: Node, monitor: Monitor, parameters: EstimatorParameters,
                 topic: str, service: str) -> None:
        self._node, self._monitor, self._topic = node, monitor, topic
        self._service = service
        span = 60.0 * parameters.keep_minutes
        self._refusal = '' if span else 'nothing is kept: keep_minutes is 0, expected more'
        self.buffer = RecordingBuffer(span) if span else None
        self._writer: Thread | None = None  # while it writes what the buffer holds
        self._schedule: RecordingSchedule | None = None
        self._quota = RecordingQuota(parameters.keep_per_hour)
        if seconds := parameters.keep_after_error:
            if self._refusal:
                raise InputError(f'keep_after_error: {seconds:g} s, expected 0: {self._refusal}')
            if seconds > span:
                raise InputError(f'keep_after_error: {seconds:g} s, expected no more than '
                                 f'keep_minutes: {span:g} s')
            self._schedule = RecordingSchedule(seconds, span, self._wrong())

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
        Keep the recording if an alert asks for it, at `time_s` (s, of a steady clock).

        Returns {component: text}: what became of the alerts.
        """
        if self._schedule is None:
            return {}
        busy = self._writer is not None or not self.buffer or self._wait() > 0.0
        components = self._schedule.look(self._wrong(), time_s, busy)
        if components:
            self._schedule.tell(components, 'being written')
            self._node.executor.create_task(
                self._finish, self._schedule, components, self._start(components))
        return self._schedule.texts

    def close(self) -> None:
        """Let a recording come to its end; keep that of an alert that was still waiting."""
        if self._writer is not None:
            self._writer.join()
        components = self._schedule.waiting() if self._schedule else []
        if components and self.buffer:
            _, text = self._export(self.buffer.rows(), self._context(components))
            # The node's own logger wants /rosout, which is gone by now.
            get_logger('estimator_end').warning(f'{", ".join(components)}: {text}')

    def _wrong(self) -> list[str]:
        """Return the components of drift that are ERROR, also while no samples come."""
        stages = self._monitor.tracker.stages()
        return [component for component, tests in stages.items() if GROSS in tests.values()]

    def _context(self, components: Sequence[str] = ()) -> RecordingContext:
        monitor = self._monitor
        p, outcomes = monitor.parameters, drift_words.outcomes(monitor.tracker)
        reason = '; '.join(f'{name}: {outcomes[name].message}' for name in components)
        return RecordingContext(self._topic, (p.motor_joint, p.arm_joint), monitor.model,
                                monitor.estimator.drive.arm_load, p, reason or f'~/{KEEP}')

    def _start(self, components: Sequence[str] = ()) -> Future:
        """Write the rows in memory, in a thread; return the Future of (success, message)."""
        assert self.buffer is not None
        self._quota.take(time.monotonic())
        future = Future()
        self._writer = Thread(target=self._write, args=(
            self.buffer.rows(), self._context(components), future))
        self._writer.start()
        return future

    def _wait(self) -> float:
        """Return how long keep_per_hour forbids a recording (s)."""
        return self._quota.wait(time.monotonic())

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

    def _written(self, good: bool) -> None:
        """End a recording; one that failed does not count in keep_per_hour."""
        self._writer = None
        if not good:
            self._quota.give_back()

    async def _finish(self, schedule: RecordingSchedule, components: Sequence[str],
                      future: Future) -> None:
        """Tell what became of the recording of the alerts of `components`."""
        good, text = await future
        self._written(good)
        logger, names = self._node.get_logger(), ', '.join(components)
        schedule.tell(components, text if good else f'failed: {text}')
        if good:
            logger.warning(f'{names} became ERROR: {text}')
        else:
            logger.error(f'{names} became ERROR, keep_after_error: {text}')

    async def keep(self) -> tuple[bool, str]:
        """Keep the recording on request; return whether that went well, and the answer."""
        if self._refusal:
            return False, self._refusal
        if self._writer is not None:
            return False, 'a recording is being written: wait for its end'
        if wait := self._wait():
            return False, (f'keep_per_hour: {self._monitor.parameters.keep_per_hour} '
                           f'recordings were kept, the next may follow in {wait:.0f} s')
        if not self.buffer:
            return False, f'no samples yet on {self._topic}'
        success, message = await self._start()
        self._written(success)
        if success:
            self._node.get_logger().info(message)
        else:
            self._node.get_logger().error(f'keep_recording: {message}')
        return success, message
