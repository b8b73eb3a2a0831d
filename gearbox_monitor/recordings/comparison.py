# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compare replayed estimates with the recorded ones, bit for bit, in bounded memory.

A sample that the recorder or the estimator missed is counted; the comparison is meaningful again
from the next snapshot on.
"""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.recordings.cdr import Decoder
from gearbox_monitor.recordings.player import EstimatePlayer, ReplayPart
from gearbox_monitor.recordings.stamp_matching import StampMatcher, WAIT
from gearbox_monitor.recordings.topics import (
    ARM, MOTOR, Signal, signal_values, SIGNALS, TRANSMISSION)

CLOSE = 1e-9  # relative, absolute below 1
NEVER = np.iinfo(np.int64).max
REFERENCE = SIGNALS[0]  # its stamps reveal lost messages


@dataclass
class Comparison:
    """
    Replay against the recorded estimates, in messages.

    compared = identical + close + explained + different. `close` agree to 1e-9, as they do with
    other versions or on another machine. `explained` differ after a lost sample, until the next
    snapshot. early_inputs: recorded before the estimator ran. lost_inputs: estimated live, but not
    recorded; lost_outputs: recorded inputs whose estimate is not recorded. first: signal and stamp
    of the first unexplained difference.
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
    def verdict(self) -> str:
        """'yes', 'to 1e-9', 'no', or 'nothing to compare'."""
        if not self.compared:
            return 'nothing to compare'
        return 'no' if self.different else 'to 1e-9' if self.close else 'yes'


@dataclass(frozen=True)
class _ComparedSignal:
    """A signal with its decoder, None if it was not recorded."""

    signal: Signal
    decode: Decoder | None
    matcher: StampMatcher


@dataclass(frozen=True)
class _Difference:
    """Rows of `signal` that differ, met at `log_ns`; close [N]: whether to 1e-9 only."""

    log_ns: int
    signal: Signal
    stamps: Integers
    close: Flags


class Comparer:
    """
    Takes the parts of a replay by `player` and fills `comparison`, complete after `finish`.

    An estimate that is recorded WAIT after its sample, or later, counts as lost.
    """

    def __init__(self, player: EstimatePlayer) -> None:
        self._player, self._log_ns = player, 0
        self.comparison = Comparison(early_inputs=player.early_inputs)
        names = {**player.input.joints, MOTOR: player.estimator.parameters.motor_joint,
                 ARM: player.estimator.parameters.arm_joint}
        self._signals: dict[str, _ComparedSignal] = {}  # by topic
        for signal in SIGNALS:
            topic = player.input.name(signal.topic)
            recorded = player.reader.count(topic) > 0
            if signal.smoothed and not player.estimator.parameters.smoother_lag:
                continue
            if recorded or signal is REFERENCE:
                joints = [names.get(joint, joint) for joint in signal.joints]
                width = len(joints) * sum(map(bool, (signal.position, signal.velocity,
                                                     signal.effort)))
                decode = player.reader.decoder(topic, joints) if recorded else None
                self._signals[topic] = _ComparedSignal(signal, decode, StampMatcher(width, width))
        self.topics = tuple(topic for topic, entry in self._signals.items() if entry.decode)
        self._first: int | None = None  # stamp of the first estimate
        self._begun, self._unpaired = False, 0
        # Snapshots from which replay continued, and the first loss after each.
        self._resumed, self._loss = np.zeros(1, np.int64), np.array([NEVER])
        self._undecided: list[_Difference] = []

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        self._log_ns = part.end_ns
        self._resume(part.resumed)
        for topic, entry in self._signals.items():
            stamps, values = signal_values(
                entry.signal, part.estimates, self._player.estimator.model.gear_ratio)
            ours = stamps, np.hstack(list(values.values()))
            live = stamps[:0], ours[1][:0]
            if entry.decode:
                states = entry.decode(part.block.of(topic))
                if self._player.input.transmission != TRANSMISSION:
                    states = states.of_named()  # the others are of other gearboxes
                live = states.stamp_ns, np.hstack([getattr(states, name) for name in values])
            entry.matcher.put(self._log_ns, ours, live)
            if entry.signal is REFERENCE:
                self._begin(entry.matcher, stamps)
            self._compare(entry.signal, *entry.matcher.pairs())
            expired = entry.matcher.expired(self._log_ns)
            if entry.signal is REFERENCE:
                self._count_losses(*expired)
        # A loss that explains a difference has expired by then.
        while self._undecided and self._undecided[0].log_ns < self._log_ns - 3 * WAIT:
            self._decide(self._undecided.pop(0))

    def finish(self) -> None:
        """Decide the differences that still wait."""
        for entry in self._signals.values():
            expired = entry.matcher.expired()
            if entry.signal is REFERENCE:
                if self._first is None:
                    self.comparison.lost_inputs += self._unpaired
                self._count_losses(*expired, last=True)
        for difference in self._undecided:
            self._decide(difference)
        self._undecided = []

    def _resume(self, stamps: Integers) -> None:
        if len(stamps):
            resumed = np.concatenate([self._resumed, stamps])
            loss = np.concatenate([self._loss, np.full(len(stamps), NEVER)])
            order = np.argsort(resumed, kind='stable')
            self._resumed, self._loss = resumed[order], loss[order]

    def _begin(self, matcher: StampMatcher, stamps: Integers) -> None:
        """Skip recorded estimates that precede the first snapshot: replay has none of them."""
        if self._first is None and len(stamps):
            self._first = int(stamps[0])
        if self._first is not None and not self._begun:
            self._begun = matcher.skip_until(self._first)

    def _count_losses(self, ours: Integers, live: Integers, last: bool = False) -> None:
        """Count the stamps without a partner."""
        if self._first is None and not last:
            self._unpaired += len(live)
            return
        self.comparison.lost_outputs += len(ours)
        self.comparison.lost_inputs += len(live)
        stamps = np.append(np.sort(np.concatenate([ours, live])), NEVER)
        self._loss = np.minimum(self._loss, stamps[np.searchsorted(stamps, self._resumed)])

    def _compare(self, signal: Signal, stamps: Integers, ours: Array, live: Array) -> None:
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
        close = np.abs(ours - live) <= CLOSE * np.maximum(1.0, np.abs(live))
        self._undecided.append(_Difference(self._log_ns, signal, stamps[~identical],
                                           np.asarray((close | absent).all(axis=1))[~identical]))

    def _decide(self, difference: _Difference) -> None:
        """Attribute the rows of `difference` to a loss, to rounding, or to none of them."""
        # A smoothed value depends on later samples, up to one and a half lags.
        lag = self._player.estimator.parameters.smoother_lag * 1e9
        horizon = round(1.5 * lag) + 1 if difference.signal.smoothed else 0
        stamps = difference.stamps
        loss = self._loss[np.searchsorted(self._resumed, stamps, 'right') - 1]
        explained = loss <= stamps + horizon
        different = ~explained & ~difference.close
        self.comparison.explained += int(explained.sum())
        self.comparison.close += int((~explained & difference.close).sum())
        self.comparison.different += int(different.sum())
        if different.any() and not self.comparison.first:
            self.comparison.first = (f'{difference.signal.topic} at stamp '
                                     f'{stamps[different][0]} ns')
