# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The newest minutes of the measurement: kept in memory, exported on request or at an alert.

No ROS here. Rows are gathered in a block; a full one is packed without loss, so memory follows the
rate. Packed blocks never change, so a reader unpacks them without holding up the samples.
"""
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
import os
from pathlib import Path
import re
import shlex
import shutil
from threading import Lock, Thread
import time
from typing import Any, TypeAlias

import lz4.block
import numpy as np
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.task import Future

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import save_model
from gearbox_monitor.health import judgement
from gearbox_monitor.health.health_record import GROSS
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.storage import next_free
from gearbox_monitor.recordings.write import BagWriter, WriteError
from gearbox_monitor.signals.examine import admitted
from gearbox_monitor.signals.uniform import UniformRecording

SECOND = 1_000_000_000
BLOCK = 1024       # rows
MAX_RATE = 4000.0  # rows/s up to which the whole span is kept
MOTOR, ARM, MOTOR_EFFORT, ARM_EFFORT = range(4)
DTYPE = np.dtype([('stamp_ns', np.int64), ('good', np.bool_), ('values', np.float64, 4)])
Rows: TypeAlias = np.ndarray[tuple[int], np.dtype[Any]]  # of DTYPE


class RecordingBuffer:
    """
    The rows of the last `seconds`, at most MAX_RATE of them per second, in blocks of `block` rows.

    A row: stamp (ns), good (whether the estimator could use it), values [4] as received: position
    of motor and arm, effort of motor and arm; NaN = not measured.
    """

    def __init__(self, seconds: float, block: int = BLOCK) -> None:
        self.span = round(seconds * SECOND)
        self._size = block
        self._max_blocks = int(np.ceil(seconds * MAX_RATE / block)) + 1
        # Full blocks: (packed rows, newest good stamp when it was full).
        self._full: deque[tuple[bytes, int]] = deque()
        self._rows, self._n = np.empty(block, DTYPE), 0
        self.newest_ns = 0  # stamp of the newest good row, 0 before the first
        self.first_ns = 0  # stamp of the first good row since the clock was set back

    def add(self, stamp_ns: int, good: bool, values: tuple[float, float, float, float]) -> None:
        """
        Add one row.

        Args:
            stamp_ns: of the measurement, ns.
            good: whether the estimator could use it.
            values: position of motor and arm (rad), effort of motor and arm (N m), as received.

        """
        if self._n == self._size:
            self._next_block()
        self._rows[self._n] = (stamp_ns, good, values)
        self._n += 1
        if good:
            if stamp_ns < self.newest_ns or not self.first_ns:
                self.first_ns = stamp_ns
            self.newest_ns = stamp_ns

    def _next_block(self) -> None:
        self._full.append((packed(self._rows), self.newest_ns))
        # Rows stamped later than the newest one, too: they are from before a clock was set back.
        while self._full and not 0 <= self.newest_ns - self._full[0][1] <= self.span:
            self._full.popleft()
        while len(self._full) >= self._max_blocks:
            self._full.popleft()
        self._n = 0

    def __len__(self) -> int:
        return len(self._full) * self._size + self._n

    def blocks(self, seconds: float) -> Callable[[], list[bytes]]:
        """
        Return a function that gives the last `seconds` in packed blocks, from any thread.

        Without rows stamped later than the newest one: they are from before a clock was set back.
        """
        first = self.newest_ns - round(seconds * SECOND)
        full = [block for block, newest in self._full if first < newest <= self.newest_ns]
        rows = self._rows[:self._n]
        newest_rows = rows[rows['stamp_ns'] <= self.newest_ns]
        return lambda: [*full, packed(newest_rows)] if len(newest_rows) else full

    def rows(self) -> Callable[[], Rows]:
        """Return a function that gives the present rows [N], oldest first, from any thread."""
        blocks, newest = [block for block, _ in self._full], self._rows[:self._n].copy()
        first, span = self.newest_ns - self.span, self.span

        def joined() -> Rows:
            rows = np.concatenate([*map(unpacked, blocks), newest])
            in_span = np.flatnonzero(rows['good'] & (rows['stamp_ns'] > first)
                                     & (rows['stamp_ns'] <= first + span))
            return rows[in_span[0]:] if len(in_span) else rows
        return joined


def packed(rows: Rows) -> bytes:
    """
    Return `rows` [N] in about half of the memory.

    Each number, taken as an integer, becomes its difference from the row before. lz4 packs byte 0
    of all differences, byte 1 of all, and so on, and then `good`.
    """
    numbers = np.column_stack([rows[name].view(np.uint64) for name in ('stamp_ns', 'values')])
    differences = np.diff(numbers, axis=0, prepend=np.zeros_like(numbers[:1]))
    return lz4.block.compress(differences.view(np.uint8).T.tobytes() + rows['good'].tobytes())


def unpacked(packed: bytes) -> Rows:
    """Return the rows of a `packed` block."""
    by_place = np.frombuffer(lz4.block.decompress(packed), np.uint8).reshape(DTYPE.itemsize, -1)
    numbers = np.cumsum(by_place[:-1].T.copy().view(np.uint64), axis=0, dtype=np.uint64)
    rows = np.empty(len(numbers), DTYPE)
    rows['stamp_ns'], rows['values'] = numbers[:, 0].view(np.int64), numbers[:, 1:].view(float)
    rows['good'] = by_place[-1]
    return rows


def unpacked_rows(blocks: Iterable[bytes], since_ns: int = 0) -> Rows:
    """Return the rows of packed `blocks`, from `since_ns` on."""
    rows = np.concatenate([np.empty(0, DTYPE), *map(unpacked, blocks)])
    return rows[rows['stamp_ns'] >= since_ns]


def with_effort_moved(rows: Rows, delay: int) -> Rows:
    """
    Return rows whose effort is that of `delay` samples earlier (later, if negative).

    Then the effort stamped t_k acts from t_k on. Without a delay all rows are returned, otherwise
    those that the estimator accepted.
    """
    if not delay:
        return rows
    rows = rows[rows['good']]
    values = rows['values'][:, [MOTOR_EFFORT, ARM_EFFORT]]
    rows = (rows[delay:] if delay > 0 else rows[:delay]).copy()
    rows['values'][:, [MOTOR_EFFORT, ARM_EFFORT]] = (
        values[:-delay] if delay > 0 else values[-delay:])
    return rows


JOINT_STATE = 'sensor_msgs/msg/JointState'
PATTERN = 'kept_%Y_%m_%d-%H_%M_%S'
KEPT = re.compile(r'kept_\d{4}_\d\d_\d\d-\d\d_\d\d_\d\d(_\d+)?')
# No gearbox deletes what another one is writing.
TURN = Lock()
# The thread that estimates waits for this one only while a chunk is encoded.
CHUNK, PAUSE = 100, 1e-3
MB = 10 ** 6
ROW_BYTES = 200  # of a message in a bag, not compressed
SPARE = 500 * MB  # of the disk stay free


@dataclass(frozen=True)
class RecordingContext:
    """
    Where a recording comes from: `topic`, `joints` (motor, arm), `model` as it was read.

    arm_load: in force; parameters: of the estimator; reason: why the recording is kept.
    """

    topic: str
    joints: tuple[str, str]
    model: DriveModel
    arm_load: str
    parameters: EstimatorParameters
    reason: str


def export_recording(parent: str | Path, rows: Rows, context: RecordingContext,
                     clock: Callable[[], time.struct_time] = time.localtime) -> str:
    """
    Write a recording into a new folder; then delete the oldest ones beyond keep_newest.

    Args:
        parent: folder of all recordings.
        rows: of a RecordingBuffer.
        context: where the rows come from.
        clock: gives the time that the folder is named after.

    Returns:
        A text for the user: what was written, and the command that diagnoses it.

    Raises:
        InputError: nothing could be written; then the folder is removed again.

    """
    parent = Path(os.path.abspath(os.path.expanduser(parent)))
    with TURN:
        folder = _new_folder(parent, clock)
        try:
            text = _write_folder(folder, rows, context)
        except BaseException as error:
            shutil.rmtree(folder, ignore_errors=True)  # a full disk shall not stay full
            if isinstance(error, WriteError):  # it ends with what the bag still holds
                raise InputError(f'{str(error).rpartition(";")[0]}; removed again, the '
                                 'measurement is still in memory') from None
            raise
        _delete_oldest(folder, context.parameters.keep_newest)
    return text


def _write_folder(folder: Path, rows: Rows, context: RecordingContext) -> str:
    """Write all bags and files of a recording; see export_recording."""
    size, free = 2 * ROW_BYTES * len(rows), shutil.disk_usage(folder).free
    if size > free - SPARE:
        raise InputError(f'{folder.parent}: {free / MB:.0f} MB are free, expected '
                         f'{(size + SPARE) / MB:.0f} MB; the measurement is still in memory')
    rows = with_effort_moved(rows, context.parameters.effort_delay)
    _write(folder / 'bag', rows, context)
    save_model(folder / 'drive.yaml', context.model.with_(
        arm_load=load_of(rows, context.model, context.arm_load)), [
        f'Model of the estimator whose measurement is in {folder.name}.',
        f'Written by gearbox_monitor {__version__}.'])
    return f'{_seconds(rows):.1f} s kept: {diagnosis_command(folder, context)}'


def _delete_oldest(newest: Path, count: int) -> None:
    """Delete the oldest recordings in the folder of `newest`, so that `count` remain."""
    others = [path for path in newest.parent.iterdir()
              if KEPT.fullmatch(path.name) and path != newest]
    others.sort(key=lambda path: path.stat().st_mtime_ns)
    for path in others[:len(others) + 1 - count]:
        shutil.rmtree(path, ignore_errors=True)


def diagnosis_command(folder: Path, context: RecordingContext) -> str:
    """Return the shell command that diagnoses the recording of `context` in `folder`."""
    words: list[str | Path] = ['gearbox_monitor', 'diagnose', folder / 'bag', '--model',
                               folder / 'drive.yaml']
    if not context.topic.endswith('/joint_states'):
        words += ['--topic', context.topic]
    for option, joint in zip(('motor', 'arm'), context.joints):
        words += [f'--recorded-{option}', joint] if joint != option else []
    return shlex.join(map(str, words))


def _new_folder(parent: Path, clock: Callable[[], time.struct_time]) -> Path:
    """Make and return a new folder in `parent`."""
    first = path = parent / time.strftime(PATTERN, clock())
    while True:
        try:
            path.mkdir(parents=True)
            return path
        except FileExistsError:  # perhaps of another process, just now
            path = next_free(first)
        except OSError as error:
            raise InputError(f'{path}: {error.strerror}, expected a folder that can be made; '
                             'see parameter keep_folder') from None


def _seconds(rows: Rows) -> float:
    """Return the time between the first and the last good stamp."""
    stamps = rows['stamp_ns'][rows['good']]
    return float(stamps[-1] - stamps[0]) / SECOND if len(stamps) else 0.0


def load_of(rows: Rows, model: DriveModel, arm_load: str) -> str:
    """
    Return the arm_load to diagnose with: a load counts as measured only if the rows have it.

    Args:
        rows: of the recording.
        model: of the model file.
        arm_load: in force.
    """
    load = 'measured' if 'measured' in (model.arm_load, arm_load) else model.arm_load
    measured = np.isfinite(rows['values'][rows['good'], ARM_EFFORT])
    if load == 'measured' and not measured.all():
        return 'unknown'
    return load


def recording_of(rows: Rows, model: DriveModel, name: str, seconds: float) -> UniformRecording:
    """
    Return rows as a recording to diagnose, of `seconds` in which the drive moves most.

    Args:
        rows: that were kept.
        model: of the drive, with the load to diagnose with.
        name: of the recording in messages.
        seconds: length of the recording.

    Raises:
        InputError: the rows allow no statement about the drive.
    """
    rows = rows[rows['good']]
    motor, arm, effort, arm_effort = rows['values'].T
    return admitted(
        rows['stamp_ns'], model.effort_scale * effort,
        np.column_stack([motor / model.gear_ratio, arm]), arm_effort, name, model,
        'the model file', seconds)[0]


def _write(path: Path, rows: Rows, context: RecordingContext) -> None:
    """Write the new bag `path`: every row one message on the topic, logged at its stamp."""
    metadata = {'version': __version__, 'source': f'estimator: {context.reason}',
                **{f'estimator.{name}': value for name, value
                   in context.parameters.replace(effort_delay=0).to_dict().items()}}
    with BagWriter(path) as writer:
        writer.add_metadata('gearbox_monitor', metadata)
        writer.add_topic(context.topic, JOINT_STATE)
        joints = [joint for joint in context.joints if joint]
        n = len(joints)
        for begin in range(0, len(rows), CHUNK):
            part = rows[begin:begin + CHUNK]
            values = part['values']
            messages = encode_joint_states(part['stamp_ns'], joints, values[:, :n],
                                           effort=values[:, 2:2 + n])
            for stamp_ns, message in zip(part['stamp_ns'].tolist(), messages):
                writer.write(context.topic, max(stamp_ns, 0), message)
            time.sleep(PAUSE)


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
        p, outcomes = monitor.parameters, judgement.outcomes(monitor.health)
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
