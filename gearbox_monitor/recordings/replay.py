# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Replay a bag, compare it with the estimates that were recorded, and summarise both.

The comparison is bit for bit, in bounded memory.
"""
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.estimation.sample_loop import ESTIMATE, REASONS, stamp_codes, START
from gearbox_monitor.health import wear_outcome
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import Decoder, joined
from gearbox_monitor.recordings.joint_input import MATCH_WAIT, StampMatcher
from gearbox_monitor.recordings.player import Player, ReplayPart, ReplaySink
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.recorded_samples import NO_SAMPLES
from gearbox_monitor.recordings.topics import (
    ARM, MOTOR, PLANT_TRANSMISSION_STATE, Signal, signal_values, SIGNALS, TRANSMISSION)

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


class Comparer(ReplaySink):
    """
    Takes the parts of a replay by `player` and fills `comparison`, complete after `finish`.

    An estimate that is recorded WAIT after its sample, or later, counts as lost.
    """

    def __init__(self, player: Player) -> None:
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
        while self._undecided and self._undecided[0].log_ns < self._log_ns - 3 * MATCH_WAIT:
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


BURN_IN = 1_000_000_000  # ns at the start that do not count


class ReplaySummary(ReplaySink):
    """
    Takes the parts of a replay by `player`; `data` is complete after `finish`.

    Errors are root mean squares in N m against the true torque, if the bag holds it.
    """

    def __init__(self, player: Player) -> None:
        self._player = player
        self._truth = truth_of(player.reader, player.topic.rsplit('/', 1)[0],
                               player.input.transmission)
        self.topics = (self._truth.topic,) if self._truth else ()
        if self._truth:
            self._decode = player.reader.decoder(self._truth.topic, (self._truth.joint,))
        self._samples = self._estimates = 0
        self._duration, self._last = 0, 0  # ns, of all runs of the clock; last stamp taken
        self._burnt_in: int | None = None  # stamp from which on estimates count
        self._first_counted: int | None = None
        self._nis, self._nis_expected, self._counted = 0.0, 0.0, 0
        self._filtered, self._smoothed = StampMatcher(2, 1), StampMatcher(1, 1)
        # Of pairs: number, squared error, squared truth, how many within one deviation.
        self._sums, self._smoothed_sums = np.zeros(4), np.zeros(2)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        stamps, estimates = part.samples.stamp_ns, part.estimates
        self._samples += len(stamps)
        self._estimates += len(estimates.stamp_ns)
        self._add_duration(stamps)
        if self._burnt_in is None and len(estimates.stamp_ns):
            self._burnt_in = int(estimates.stamp_ns[0]) + BURN_IN
        settled = estimates.stamp_ns >= (self._burnt_in or 0)
        rows: slice | Flags = slice(None) if settled.all() else settled
        counted = estimates.stamp_ns[rows]
        if len(counted):
            self._nis += float(estimates.nis[rows].sum())
            self._nis_expected += float(estimates.dof[rows].sum())
            self._counted += len(counted)
            if self._first_counted is None:
                self._first_counted = int(counted[0])
        if self._truth:
            self._compare(part, self._truth.topic, estimates, counted, rows)

    def _add_duration(self, stamps: Integers) -> None:
        """Add the time between those of `stamps` (ns) that the estimator takes."""
        stamps = np.append(self._last, stamps)
        codes = stamp_codes(stamps, self._player.estimator.parameters.max_gap)
        stamps = stamps[(codes == ESTIMATE) | (codes == START)]
        step = np.diff(stamps)
        self._duration += int(step[step > 0].sum())  # at a step back the clock restarts
        self._last = int(stamps[-1]) if len(stamps) else 0

    def _compare(self, part: ReplayPart, topic: str, estimates: Estimates, counted: Integers,
                 rows: slice | Flags) -> None:
        states = self._decode(part.block.of(topic))
        reference = states.stamp_ns, states.effort
        self._filtered.put(part.end_ns, (counted, np.column_stack(
            [estimates.tau_k[rows], estimates.tau_k_std[rows]])), reference)
        _, ours, true = self._filtered.pairs()
        error = ours[:, 0] - true[:, 0]
        self._sums += (len(error), (error ** 2).sum(), (true ** 2).sum(),
                       (np.abs(error) <= ours[:, 1]).sum())
        settled = (estimates.smoothed_stamp_ns >= self._first_counted
                   if self._first_counted is not None
                   else np.zeros(len(estimates.smoothed_stamp_ns), bool))
        self._smoothed.put(part.end_ns, (estimates.smoothed_stamp_ns[settled],
                                         estimates.smoothed[settled, S_TAU_K][:, None]), reference)
        _, ours, true = self._smoothed.pairs()
        self._smoothed_sums += (len(ours), ((ours - true) ** 2).sum())
        for matcher in (self._filtered, self._smoothed):
            matcher.expired(part.end_ns)

    def finish(self) -> None:
        """Raise InputError if the topic of the true torque has no transmission."""
        if self._truth:
            self._player.reader.require_joints(self._truth.topic, (self._truth.joint,),
                                               self._decode.joints)

    def data(self, comparison: Comparison | None = None) -> dict[str, Any]:
        """Return {name: value}, with the figures of `comparison` if it is not None."""
        player, estimator = self._player, self._player.estimator
        span = self._duration * 1e-9
        counted = self._counted
        data = {
            'bag': str(player.reader.path), 'samples': self._samples,
            'estimates': self._estimates, 'duration_s': span,
            'rate_hz': (self._samples - 1) / span if span > 0 else 0.0,
            'filter': estimator.parameters.filter,
            'adapted': estimator.adapted(),
            'adaptation_guards': estimator.adaptation_guards(),
            'refused': {text: int(estimator.counts[code]) for code, text in REASONS.items()
                        if estimator.counts[code]},
            'nis': self._nis / counted if counted else None,
            'nis_expected': self._nis_expected / counted if counted else None,
            'gap_rad': [round(w.gap, 6) for w in player.monitor.windows] if player.whole else [],
            'levels': {k: f.level.name for k, f in player.monitor.outcomes.items()}
            if player.whole else {},
            'wear': wear_outcome.figures(player.monitor.health) if player.whole else None,
        }
        if self._truth and counted:
            n, error, true, covered = self._sums
            data['tau_k_rms'] = _rms(true, n)
            data['tau_k_error'] = _rms(error, n)
            data['coverage_1_sigma'] = covered / n if n else None
            data['tau_k_error_smoothed'] = _rms(self._smoothed_sums[1], self._smoothed_sums[0])
        if comparison:
            data['replay_identical'] = comparison.verdict
            data['comparison'] = asdict(comparison)
        reason = [f'not compared: {player.not_compared}'] if player.not_compared else []
        data['notes'] = (player.notes + reason + estimator.warnings + estimator.divergence_notes()
                         + ([player.reader.notice] if player.reader.notice else []))
        return data


class TorqueSource(NamedTuple):
    """Where a bag holds the true or reference torque: `joint` of `topic`."""

    topic: str
    joint: str


def truth_of(reader: BagReader, namespace: str, transmission: str) -> TorqueSource | None:
    """
    Return where the true or reference torque is, or None.

    A simulated plant publishes plant/transmission_state, an imported recording with a torque
    sensor reference/transmission_state.

    Args:
        reader: the bag.
        namespace: of the joint states.
        transmission: name in the estimates; a plant of several gearboxes has the same names.

    """
    for name in (PLANT_TRANSMISSION_STATE, 'reference/transmission_state'):
        topic = f'{namespace}/{name}'
        if reader.count(topic):
            _, _, _, raw = next(reader.messages([topic]))
            names = reader.decode(JOINT_STATE, raw).name
            return TorqueSource(topic, transmission if transmission in names else TRANSMISSION)
    return None


def _rms(squares: float, n: float) -> float | None:
    return float(np.sqrt(squares / n)) if n else None


@dataclass(frozen=True)
class Replay:
    """
    All samples and estimates of a replay, and the Estimator and Monitor at its end.

    comparison: with the recorded estimates, or None. summary: {name: value}, see
    ReplaySummary.data.
    """

    samples: Samples
    estimates: Estimates
    estimator: Estimator
    monitor: Monitor
    comparison: Comparison | None
    summary: dict[str, Any]


class _Collector(ReplaySink):
    """Keeps all samples and estimates."""

    def __init__(self) -> None:
        self.samples, self.estimates = list[Samples](), list[Estimates]()

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        self.samples.append(part.samples)
        self.estimates.append(part.estimates)


def summarised(player: Player, sinks: Iterable[ReplaySink] = (),
               progress: Callable[[int], object] = bool
               ) -> tuple[dict[str, Any], Comparison | None]:
    """
    Run a `player`; return (summary, comparison with the recorded estimates where possible).

    Args:
        player: of the bag.
        sinks: that take its parts, too.
        progress: called with the number of samples of each part.
    """
    summary = ReplaySummary(player)
    comparer = Comparer(player) if player.compared else None
    player.run([summary, *([comparer] if comparer else []), *sinks], progress)
    comparison = comparer.comparison if comparer else None
    return summary.data(comparison), comparison


def replay(reader: BagReader, model: DriveModel | None = None,
           parameters: Mapping[str, Any] | None = None, topic: str = 'joint_states') -> Replay:
    """
    Run a bag through the estimator and compare with the recorded estimates where possible.

    Args:
        reader: the bag.
        model: replaces the recorded model.
        parameters: {name: value} that replace recorded or default parameters of the estimator.
        topic: see find_input.

    Returns:
        The Replay.

    Raises:
        InputError: the bag cannot be replayed.
    """
    player, collector = Player(reader, model, parameters, topic), _Collector()
    summary, comparison = summarised(player, [collector])
    return Replay(joined(collector.samples or [NO_SAMPLES]),
                  joined(collector.estimates or [player.estimator.run(NO_SAMPLES)]),
                  player.estimator, player.monitor, comparison, summary)
