# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a replay: as a table (CSV, or Parquet with pyarrow), or as a bag.

The bag holds the recorded topics and the estimates, as if published live.
"""
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
import json
import os
from pathlib import Path
import shutil
from typing import Any, ParamSpec

import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.cdr import block_of, compact, joined_blocks, MessageBlock
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, GEARBOX
from gearbox_monitor.recordings.player import Player, ReplayPart, ReplaySink
from gearbox_monitor.recordings.read import (
    BagReader, block_of_frames, Frames, frames_of, JOINT_STATE)
from gearbox_monitor.recordings.topics import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, Signal, signal_values, SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.recordings.write import BagWriter

COLUMNS = ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_k_std', 'innovation_motor', 'innovation_arm',
           'nis')
# Where the filter learns the curve of the torque.
LEARNED_COLUMNS = ('stiffness', 'stiffness_std', 'half_gap', 'half_gap_std', 'hysteresis',
                   'hysteresis_std')
ROW_GROUP = 1 << 17  # rows of a Parquet file that are packed together
P = ParamSpec('P')


class CsvTable(ReplaySink):
    """
    Takes the parts of a replay and writes a row per estimate: stamp_ns, COLUMNS, LEARNED_COLUMNS.

    The numbers of a CSV file are read back bit for bit. The file gets its name when all rows are
    written.

    Args:
        path: the new file.
        player: whose estimates are written.

    Raises:
        InputError: the file cannot be written.
    """

    def __init__(self, path: str | Path, player: Player) -> None:
        self._path, self._part = Path(path), Path(f'{path}.part')
        learns = bool(player.estimator.learned_curve())
        self._names = COLUMNS + (LEARNED_COLUMNS if learns else ())
        self._guarded(self._open, player)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        self.write(part.estimates)

    def write(self, estimates: Estimates) -> None:
        """Write the rows of `estimates`."""
        self._guarded(self._write, estimates.stamp_ns, [
            getattr(estimates, name) for name in self._names])

    def close(self) -> None:
        """Complete the file."""
        self._guarded(self._close)
        self._guarded(os.replace, self._part, self._path)

    def abandon(self) -> None:
        """Delete the incomplete file."""
        with suppress(OSError, InputError):
            self._close()
        self._part.unlink(missing_ok=True)

    def _guarded(self, function: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except OSError as error:
            raise InputError(f'{self._path}: {error.strerror or error}, expected a new, writable '
                             'file') from None

    def _open(self, player: Player) -> None:
        self._file = open(self._part, 'w', encoding='utf-8')
        self._file.write(','.join(('stamp_ns', *self._names)) + '\n')

    def _write(self, stamps: Integers, columns: Sequence[Array]) -> None:
        rows = zip(stamps.tolist(), *(column.tolist() for column in columns))
        self._file.writelines(','.join(map(repr, row)) + '\n' for row in rows)

    def _close(self) -> None:
        self._file.close()


class ParquetTable(CsvTable):
    """Parquet file of float64 columns; model, parameters and versions are its metadata."""

    def _open(self, player: Player) -> None:
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError:
            raise InputError(f'{self._path}: pyarrow is missing, expected '
                             f'{installed_by("tables")}, or a .csv file') from None
        self._table: Any = pyarrow.table
        self._waiting: list[Any] = []
        origin = {'kernels': KERNELS, **_origin(player)}
        self._schema = pyarrow.schema(
            [('stamp_ns', pyarrow.int64()), *((name, pyarrow.float64()) for name in self._names)],
            metadata={f'gearbox_monitor.{key}': value for key, value in origin.items()})
        # Noise does not repeat, so a dictionary of values would only cost time; but the bytes of
        # sign and exponent resemble each other.
        self._writer = parquet.ParquetWriter(
            self._part, self._schema, compression='lz4', use_dictionary=False,
            write_statistics=['stamp_ns'], column_encoding={
                'stamp_ns': 'DELTA_BINARY_PACKED', **dict.fromkeys(
                    self._names, 'BYTE_STREAM_SPLIT')})

    def _write(self, stamps: Integers, columns: Sequence[Array]) -> None:
        self._waiting.append((stamps, *columns))
        if sum(len(rows[0]) for rows in self._waiting) >= ROW_GROUP:
            self._flush()

    def _flush(self) -> None:
        if self._waiting:
            columns = map(np.concatenate, zip(*self._waiting))
            self._writer.write_table(self._table([*columns], schema=self._schema),
                                     row_group_size=ROW_GROUP)
        self._waiting = []

    def _close(self) -> None:
        self._flush()
        self._writer.close()


def _origin(player: Player) -> dict[str, str]:
    """Return where estimates come from, as metadata of a file."""
    estimator = player.estimator
    return {'version': __version__, 'replayed_from': str(player.reader.path),
            'parameters': json.dumps(estimator.parameters.to_dict()),
            'model': json.dumps(estimator.model.to_dict())}


RECENT = 10_000_000_000  # ns of log time that is searched for the sample of a smoothed value


class BagOutput(ReplaySink):
    """
    Takes the parts of a replay by `player` and writes them to the new bag `path`.

    A replay of that bag gives the same estimates: it holds the snapshots from which they started.
    An estimate is logged with its sample's message. Raises InputError if `path` cannot be written.
    """

    def __init__(self, path: str | Path, player: Player) -> None:
        reader, self._input = player.reader, player.input
        estimator = player.estimator
        ours = {self._input.name(signal.topic) for signal in SIGNALS}
        # Diagnostics of the live estimator belong to its estimates, not to these.
        dropped = {DIAGNOSTICS, self._input.name(DRIFT_ALERTS)}
        self.topics = tuple(topic for topic in reader.topics if topic not in ours | dropped
                            and (player.compared or not topic.endswith('/snapshot')))
        self._gear_ratio = estimator.model.gear_ratio
        self._names = {**self._input.joints, MOTOR: estimator.parameters.motor_joint,
                       ARM: estimator.parameters.arm_joint}
        # Smoothed values are about samples up to one and a half lags ago.
        self._lag = round(1.5e9 * estimator.parameters.smoother_lag)
        self._stamps, self._log_ns = np.empty((2, 0), np.int64)
        self._last: dict[str, int] = {}  # topic: log time of its last message
        self._topics = (*self.topics, *sorted(ours))
        self._waiting = block_of(self._topics, [])
        self._writer = BagWriter(path)
        try:
            self._announce(player, ours)
        except BaseException:
            self.abandon()
            raise

    def _announce(self, player: Player, ours: Iterable[str]) -> None:
        """Write metadata, topics and the first snapshot; ours: topics of the estimates."""
        reader = player.reader
        self._writer.add_metadata('gearbox_monitor', _origin(player))
        for topic in self.topics:
            self._writer.add_topic(topic, reader.topics[topic][0])
        for topic in sorted(ours):
            self._writer.add_topic(topic, JOINT_STATE)
        if not player.compared:  # else the recorded snapshots apply
            self._write_snapshot(reader, player.estimator)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        recent = self._log_ns >= part.end_ns - RECENT
        self._stamps = np.concatenate([self._stamps[recent], part.samples.stamp_ns])
        self._log_ns = np.concatenate([self._log_ns[recent], part.log_ns])
        order = np.argsort(self._stamps, kind='stable')
        samples = self._stamps[order], self._log_ns[order]
        frames = [frame for signal in SIGNALS
                  for frame in self._frames_of(signal, part.estimates, samples)]
        waiting = joined_blocks([self._waiting, self._copied(part.block),
                                 block_of_frames(self._topics, frames, whole=True)])
        waiting = waiting.take(np.argsort(waiting.log_ns, kind='stable'))
        done = int(np.searchsorted(waiting.log_ns, part.end_ns - self._lag))
        self._writer.write_block(waiting.take(slice(0, done)))
        self._waiting = compact(waiting.take(slice(done, None)))

    def finish(self) -> None:
        """Write the waiting messages."""
        self._writer.write_block(self._waiting)

    def close(self) -> None:
        """Complete the bag."""
        self._writer.close()

    def abandon(self) -> None:
        """Delete the incomplete bag."""
        self._writer.close()
        shutil.rmtree(Path(self._writer.path))

    def _copied(self, block: MessageBlock) -> MessageBlock:
        """Return the messages of `block` that the new bag takes over."""
        number = {topic: k for k, topic in enumerate(self.topics)}
        numbers = np.array([number.get(topic, -1) for topic in block.topics], np.int32)
        block = replace(block, topics=self._topics, topic=numbers[block.topic])
        return block.take(np.flatnonzero(block.topic >= 0))

    def _write_snapshot(self, reader: BagReader, estimator: Estimator) -> None:
        """Write the initial state."""
        topic = self._input.snapshots or f'{self._input.namespace}/estimator/{SNAPSHOT}'
        types = get_typestore(Stores.ROS2_JAZZY).types
        header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), '')
        content = {'reason': 'start', 'version': __version__, 'kernels': KERNELS,
                   'topics': json.dumps(self._input.names),
                   **({GEARBOX: self._input.transmission}
                      if self._input.transmission != TRANSMISSION else {}),
                   **Monitor(estimator.model, estimator.parameters).snapshot()}
        status = types['diagnostic_msgs/msg/DiagnosticStatus'](
            0, 'estimator: snapshot', 'what replay starts from',
            estimator.parameters.gearbox_serial,
            [types['diagnostic_msgs/msg/KeyValue'](key, value) for key, value in content.items()])
        self._writer.add_topic(topic, DIAGNOSTIC_ARRAY)
        self._writer.write_message(topic, reader.start_ns or 0,
                                   types[DIAGNOSTIC_ARRAY](header, [status]))

    def _frames_of(self, signal: Signal, estimates: Estimates, samples: tuple[Integers, Integers]
                   ) -> list[Frames]:
        """
        Return the messages of a signal.

        Args:
            signal: one of SIGNALS.
            estimates: what it is taken from.
            samples: (stamps, log times) of the latest samples, by stamp.
        """
        stamps, values = signal_values(signal, estimates, self._gear_ratio)
        if not len(stamps):
            return []
        topic = self._input.name(signal.topic)
        place = np.searchsorted(samples[0], stamps)
        log_ns = samples[1][np.minimum(place, len(samples[0]) - 1)]
        log_ns[0] = max(log_ns[0], self._last.get(topic, log_ns[0]))
        log_ns = np.maximum.accumulate(log_ns)
        self._last[topic] = log_ns[-1]
        present = ~np.isnan(values['position']) | (np.array(signal.joints) == TRANSMISSION)
        joints = [self._names.get(joint, joint) for joint in signal.joints]
        return list(frames_of(topic, joints, present, (stamps, log_ns), values))
