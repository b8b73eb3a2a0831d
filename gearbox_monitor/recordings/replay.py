# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Replay a bag, compare it with the estimates that were recorded, and summarise and write both.

The comparison is bit for bit, in bounded memory.

It is written as a table (CSV, or Parquet with pyarrow), or as a bag with the recorded topics and
the estimates, as if published live.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
import json
import os
from pathlib import Path
import shutil
from typing import Any, NamedTuple, ParamSpec

import numpy as np
from rosbags.typesys import get_typestore, Stores

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import S_TAU_K
from gearbox_monitor.estimation.sample_loop import ESTIMATE, REASONS, stamp_codes, START
from gearbox_monitor.health import judgement
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import (
    block_of, compact, Decoder, joined, joined_blocks, MessageBlock)
from gearbox_monitor.recordings.joint_input import (
    DIAGNOSTIC_ARRAY, GEARBOX, MATCH_WAIT, NO_SAMPLES, StampMatcher)
from gearbox_monitor.recordings.player import Player, ReplayPart, ReplaySink
from gearbox_monitor.recordings.read import (
    BagReader, block_of_frames, Frames, frames_of, JOINT_STATE)
from gearbox_monitor.recordings.topics import (
    ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, PLANT_TRANSMISSION_STATE, Signal, signal_values,
    SIGNALS, SNAPSHOT, TRANSMISSION)
from gearbox_monitor.recordings.write import BagWriter

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
            'wear': judgement.figures(player.monitor.health) if player.whole else None,
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
