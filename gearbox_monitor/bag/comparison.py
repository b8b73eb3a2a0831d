# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Compare replayed estimates with the recorded ones, bit for bit, in bounded memory.

A sample that the recorder or the estimator missed is counted; comparison is meaningful again from
the next snapshot on.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.bag.stamp_matching import StampMatcher, WAIT
from gearbox_monitor.interfaces.signals import ARM, MOTOR, signal_values, SIGNALS

CLOSE = 1e-9  # relative, absolute below 1
NEVER = np.iinfo(np.int64).max


@dataclass
class Comparison:
    """
    Replay against the recorded estimates, in messages.

    compared = identical + close + explained + different. `close` agree to 1e-9, as they do with
    other versions or on another machine. `explained` differ behind a lost sample, before
    the next snapshot. early_inputs: recorded before the estimator was ready. lost_inputs:
    estimated live, but not in the recording; lost_outputs: recorded inputs whose estimate is not
    in the recording. first: where the first unexplained difference is.
    """

    compared: int = 0
    identical: int = 0
    close: int = 0
    explained: int = 0
    different: int = 0
    early_inputs: int = 0
    lost_inputs: int = 0
    lost_outputs: int = 0
    first: str = ''

    @property
    def verdict(self):
        """'yes', 'to 1e-9', 'no', or 'nothing to compare'."""
        if not self.compared:
            return 'nothing to compare'
        return 'no' if self.different else 'to 1e-9' if self.close else 'yes'


class Comparer:
    """
    Takes the parts of a replay.Player and fills its `comparison`, complete after `finish`.

    An estimate that is recorded WAIT after its sample, or later, counts as lost.
    """

    def __init__(self, player):
        self._player, self._now = player, 0
        self.comparison = Comparison(early_inputs=player.early_inputs)
        names = {MOTOR: player.estimator.parameters.motor_joint,
                 ARM: player.estimator.parameters.arm_joint}
        self._signals = {}  # topic: (Signal, Decoder or None, StampMatcher)
        for signal in SIGNALS:
            topic = player.input.name(signal.topic)
            there = player.reader.topics.get(topic, ('', 0))[1] > 0
            if signal.smoothed and not player.estimator.parameters.smoother_lag:
                continue
            if there or signal is SIGNALS[0]:  # its stamps tell what was lost
                joints = [names.get(joint, joint) for joint in signal.joints]
                width = len(joints) * sum(bool(f) for f in _fields(signal).values())
                decode = player.reader.decoder(topic, joints) if there else None
                self._signals[topic] = signal, decode, StampMatcher(width, width)
        self.topics = tuple(t for t, (_, decode, _) in self._signals.items() if decode)
        self._first, self._begun, self._unpaired = None, False, 0
        # Snapshots that replay went on from, and the first loss behind each.
        self._since, self._loss = np.zeros(1, np.int64), np.array([NEVER])
        self._undecided = []  # (log time, signal, stamps, whether close)

    def add(self, part):
        """Take a ReplayPart."""
        self._now = part.now
        self._resumed(part.resumed)
        for topic, (signal, decode, pairing) in self._signals.items():
            stamps, values = signal_values(
                signal, part.estimates, self._player.estimator.model.gear_ratio)
            left = stamps, np.hstack(list(values.values()))
            right = left[0][:0], left[1][:0]
            if decode:
                states = decode(part.block.of(topic))
                right = states.stamp_ns, np.hstack([getattr(states, name) for name in values])
            pairing.put(self._now, left, right)
            if signal is SIGNALS[0]:
                self._begin(pairing, stamps)
            self._compare(signal, *pairing.pairs())
            expired = pairing.expired(self._now)
            if signal is SIGNALS[0]:
                self._lost(*expired)
        # What is lost that explains a difference has expired by then.
        while self._undecided and self._undecided[0][0] < self._now - 3 * WAIT:
            self._decide(*self._undecided.pop(0)[1:])

    def finish(self):
        """Decide what is left."""
        for signal, _, pairing in self._signals.values():
            expired = pairing.expired()
            if signal is SIGNALS[0]:
                if self._first is None:
                    self.comparison.lost_inputs += self._unpaired
                self._lost(*expired, last=True)
        for _, *entry in self._undecided:
            self._decide(*entry)
        self._undecided = []

    def _resumed(self, stamps):
        if len(stamps):
            since = np.concatenate([self._since, stamps])
            loss = np.concatenate([self._loss, np.full(len(stamps), NEVER)])
            order = np.argsort(since, kind='stable')
            self._since, self._loss = since[order], loss[order]

    def _begin(self, pairing, stamps):
        """Leave out what was estimated before the first snapshot: nothing to compare it with."""
        if self._first is None and len(stamps):
            self._first = stamps[0]
        if self._first is not None and not self._begun:
            self._begun = pairing.skip_before(self._first)

    def _lost(self, ours, live, last=False):
        """Count the stamps that stayed alone."""
        if self._first is None and not last:
            self._unpaired += len(live)
            return
        self.comparison.lost_outputs += len(ours)
        self.comparison.lost_inputs += len(live)
        stamps = np.append(np.sort(np.concatenate([ours, live])), NEVER)
        self._loss = np.minimum(self._loss, stamps[np.searchsorted(stamps, self._since)])

    def _compare(self, signal, stamps, ours, live):
        if not len(stamps):
            return
        self.comparison.compared += len(stamps)
        same = ours == live
        if same.all():
            self.comparison.identical += len(stamps)
            return
        absent = np.isnan(ours) & np.isnan(live)
        identical = (same | absent).all(axis=1)
        self.comparison.identical += int(identical.sum())
        if identical.all():
            return
        near = np.abs(ours - live) <= CLOSE * np.maximum(1.0, np.abs(live))
        apart = ~identical
        self._undecided.append((self._now, signal, stamps[apart],
                                (near | absent).all(axis=1)[apart]))

    def _decide(self, signal, stamps, near):
        """Say what the differences of `signal` at `stamps` come from."""
        # A smoothed value depends on samples behind it, up to one and a half lags.
        lag = self._player.estimator.parameters.smoother_lag * 1e9
        ahead = round(1.5 * lag) + 1 if signal.smoothed else 0
        loss = self._loss[np.searchsorted(self._since, stamps, 'right') - 1]
        explained = loss <= stamps + ahead
        different = ~explained & ~near
        self.comparison.explained += int(explained.sum())
        self.comparison.close += int((~explained & near).sum())
        self.comparison.different += int(different.sum())
        if different.any() and not self.comparison.first:
            self.comparison.first = f'{signal.topic} at stamp {stamps[different][0]} ns'


def _fields(signal):
    return {'position': signal.position, 'velocity': signal.velocity, 'effort': signal.effort}
