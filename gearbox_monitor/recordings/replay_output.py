# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write a replay as a bag: the recorded topics and the estimates, as if published live."""
from collections.abc import Iterable
from dataclasses import replace
import json
from pathlib import Path
import shutil

import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.kernels.types import Integers
from gearbox_monitor.recordings.cdr import FIELDS, joint_state_rows
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, GEARBOX
from gearbox_monitor.recordings.message_block import (
    block_of, Bytes, compact, joined_blocks, MessageBlock)
from gearbox_monitor.recordings.player import EstimatePlayer, ReplayPart
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.topics import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, Signal, signal_values, SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.recordings.write import BagWriter

RECENT = 10_000_000_000  # ns of log time that is searched for the sample of a smoothed value


class BagOutput:
    """
    Takes the parts of a replay by `player` and writes them to the new bag `path`.

    A replay of that bag gives the same estimates: it holds the snapshots from which they started.
    An estimate is logged with its sample's message. Raises InputError if `path` cannot be written.
    """

    def __init__(self, path: str | Path, player: EstimatePlayer) -> None:
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

    def _announce(self, player: EstimatePlayer, ours: Iterable[str]) -> None:
        """Write metadata, topics and the first snapshot; ours: topics of the estimates."""
        reader, estimator = player.reader, player.estimator
        self._writer.add_metadata('gearbox_monitor', {
            'version': __version__, 'replayed_from': str(reader.path),
            'parameters': json.dumps(estimator.parameters.to_dict()),
            'model': json.dumps(estimator.model.to_dict())})
        for topic in self.topics:
            self._writer.add_topic(topic, reader.topics[topic][0])
        for topic in sorted(ours):
            self._writer.add_topic(topic, JOINT_STATE)
        if not player.compared:  # else the recorded snapshots apply
            self._write_snapshot(reader, estimator)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        recent = self._log_ns >= part.end_ns - RECENT
        self._stamps = np.concatenate([self._stamps[recent], part.samples.stamp_ns])
        self._log_ns = np.concatenate([self._log_ns[recent], part.log_ns])
        blocks = [self._waiting, self._copied(part.block)]
        order = np.argsort(self._stamps, kind='stable')
        samples = self._stamps[order], self._log_ns[order]
        blocks += [self._messages_of(signal, part.estimates, samples) for signal in SIGNALS]
        waiting = joined_blocks(blocks)
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

    def _messages_of(self, signal: Signal, estimates: Estimates,
                     samples: tuple[Integers, Integers]) -> MessageBlock:
        """
        Return the messages of a signal.

        Args:
            signal: one of SIGNALS.
            estimates: what it is taken from.
            samples: (stamps, log times) of the latest samples, by stamp.

        Returns:
            Its messages, by log time.
        """
        stamps, values = signal_values(signal, estimates, self._gear_ratio)
        if not len(stamps):
            return block_of(self._topics, [])
        topic = self._input.name(signal.topic)
        place = np.searchsorted(samples[0], stamps)
        log_ns = samples[1][np.minimum(place, len(samples[0]) - 1)]
        log_ns[0] = max(log_ns[0], self._last.get(topic, log_ns[0]))
        log_ns = np.maximum.accumulate(log_ns)
        self._last[topic] = log_ns[-1]
        present = ~np.isnan(values['position']) | (np.array(signal.joints) == TRANSMISSION)
        patterns = present @ (1 << np.arange(len(signal.joints)))  # a bit for each joint
        pieces: list[Bytes] = []
        offset, size = np.empty((2, len(stamps)), np.int64)
        for pattern in np.flatnonzero(np.bincount(patterns)):
            rows = np.flatnonzero(patterns == pattern)
            measured = present[rows[0]]
            joints = [self._names.get(signal.joints[k], signal.joints[k])
                      for k in np.flatnonzero(measured)]
            position, velocity, effort = (values[field][rows][:, measured] if field in values
                                          else None for field in FIELDS)
            encoded = joint_state_rows(stamps[rows], joints, position, velocity, effort)
            begin = sum(piece.size for piece in pieces)
            size[rows] = encoded.shape[1]
            offset[rows] = begin + encoded.shape[1] * np.arange(len(rows))
            pieces.append(encoded)
        data = np.concatenate([piece.ravel() for piece in pieces])
        number = np.full(len(stamps), self._topics.index(topic), np.int32)
        return MessageBlock(self._topics, data, offset, size, number, log_ns, log_ns)
