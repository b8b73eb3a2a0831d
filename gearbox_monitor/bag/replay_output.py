# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write a replay as a bag: the recorded topics and the estimates, as if published live."""
from collections.abc import Iterable
import json
from pathlib import Path
import shutil

import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.joint_input import DIAGNOSTIC_ARRAY, GEARBOX
from gearbox_monitor.bag.player import EstimatePlayer, ReplayPart
from gearbox_monitor.bag.read import BagReader, JOINT_STATE
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.interfaces.signals import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, Signal, signal_values, SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.monitoring.monitor import Monitor

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
        self._waiting: list[tuple[int, str, int, bytes]] = []  # log time, topic, publish time
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
        self._waiting += [(log_ns, topic, publish_ns, raw)
                          for topic, log_ns, publish_ns, raw in part.block.messages()
                          if topic in self.topics]
        for signal in SIGNALS:
            self._add_signal(signal, part.estimates)
        self._waiting.sort(key=lambda message: message[0])
        end = part.end_ns - self._lag
        self._write(sum(message[0] < end for message in self._waiting))

    def finish(self) -> None:
        """Write the waiting messages."""
        self._write(len(self._waiting))

    def close(self) -> None:
        """Complete the bag."""
        self._writer.close()

    def abandon(self) -> None:
        """Delete the incomplete bag."""
        self._writer.close()
        shutil.rmtree(Path(self._writer.path))

    def _write(self, count: int) -> None:
        for log_ns, topic, publish_ns, raw in self._waiting[:count]:
            self._writer.write(topic, log_ns, raw, publish_ns)
        del self._waiting[:count]

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

    def _add_signal(self, signal: Signal, estimates: Estimates) -> None:
        """Queue the messages of one signal."""
        stamps, values = signal_values(signal, estimates, self._gear_ratio)
        if not len(stamps):
            return
        topic = self._input.name(signal.topic)
        order = np.argsort(self._stamps, kind='stable')
        place = np.searchsorted(self._stamps[order], stamps)
        log_ns = self._log_ns[order][np.minimum(place, len(order) - 1)]
        log_ns[0] = max(log_ns[0], self._last.get(topic, log_ns[0]))
        log_ns = np.maximum.accumulate(log_ns)
        self._last[topic] = log_ns[-1]
        present = ~np.isnan(values['position']) | (np.array(signal.joints) == TRANSMISSION)
        encoded = [b''] * len(stamps)
        for pattern in np.unique(present, axis=0):
            rows = np.flatnonzero((present == pattern).all(axis=1))
            joints = [self._names.get(j, j) for j, measured in zip(signal.joints, pattern)
                      if measured]
            position, velocity, effort = (
                values[name][rows][:, pattern] if name in values else None
                for name in ('position', 'velocity', 'effort'))
            for row, raw in zip(rows, encode_joint_states(
                    stamps[rows], joints, position, velocity, effort)):
                encoded[row] = raw
        self._waiting += [(log, topic, log, raw) for log, raw in zip(log_ns.tolist(), encoded)]
