# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The time line of a recording: its windows, levels and alerts, from a bag."""
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE)
from gearbox_monitor.estimation.sample_loop import REASONS
from gearbox_monitor.health.alarms import Outcome
from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.judgement import CHANGED
from gearbox_monitor.health.monitor import DRIFT_SHOWS, Monitor
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.types import Array, Integers, Values
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, read_snapshots
from gearbox_monitor.recordings.player import Player
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.topics import DIAGNOSTICS, SNAPSHOT

SECOND_NS = 1e9
MAX_BINS = 3000
FIRST_BIN = 0.01       # s, doubled while there are more than MAX_BINS
CLOUD = 400            # points of a loop
BRANCH_BINS, MIN_POINTS = 36, 12  # of the mean of a branch; points in a bin
MOVING = 0.05          # of the rms rate of the twist: slower belongs to no branch
LEVELS = ('OK', 'WARN', 'ERROR')
LIVE_NODE = 'live node'  # its input, as recorded: of messages that it lost or refused
# Codes of messages: of what was never evaluated, of wear without an earlier state.
NO_DATA = frozenset(('no_data', 'no_data_yet'))
UNCOMPARED = frozenset(('alone', 'learning', *(f'{name}_unmeasured' for name in COMPONENTS)))
LARGEST = 1e9          # published values from here on are no measurements


class Envelope:
    """Lowest, highest and mean value of signals per bin of time; bins widen as time goes on."""

    def __init__(self, count: int) -> None:
        """Begin with `count` signals."""
        self.width, self._bins = FIRST_BIN, 0
        self._low = np.full((count, MAX_BINS), np.inf)
        self._high = np.full((count, MAX_BINS), -np.inf)
        self._sum, self._count = np.zeros((2, count, MAX_BINS))

    def add(self, t: Array, *signals: Array) -> None:
        """Take `signals` [N] at the times `t` [N] s; NaN, and what is before 0, count nothing."""
        valid = t >= 0.0
        if not valid.all():
            t, signals = t[valid], tuple(signal[valid] for signal in signals)
        if not len(t):
            return
        while t.max() >= MAX_BINS * self.width:
            self._widen()
        at = (t / self.width).astype(int)
        self._bins = max(self._bins, int(at.max()) + 1)
        for k, signal in enumerate(signals):
            finite = np.isfinite(signal)
            index, value = (at, signal) if finite.all() else (at[finite], signal[finite])
            np.minimum.at(self._low[k], index, value)
            np.maximum.at(self._high[k], index, value)
            self._sum[k] += np.bincount(index, value, MAX_BINS)
            self._count[k] += np.bincount(index, minlength=MAX_BINS)

    def _widen(self) -> None:
        """Join two bins each."""
        for table, join, empty in ((self._low, np.minimum, np.inf),
                                   (self._high, np.maximum, -np.inf), (self._sum, np.add, 0.0),
                                   (self._count, np.add, 0.0)):
            half = join(table[:, ::2], table[:, 1::2])
            table[:] = empty
            table[:, :half.shape[1]] = half
        self.width, self._bins = 2.0 * self.width, -(-self._bins // 2)

    @property
    def t(self) -> Array:
        """Middles of the bins [B], s."""
        return (np.arange(self._bins) + 0.5) * self.width

    def of(self, k: int) -> tuple[Array, Array, Array]:
        """Return (lowest, highest, mean) [B] of signal `k`; NaN in empty bins."""
        part = np.s_[k, :self._bins]
        empty = self._count[part] == 0.0
        low, high = (np.where(empty, np.nan, table[part]) for table in (self._low, self._high))
        with np.errstate(invalid='ignore'):
            return low, high, self._sum[part] / np.where(empty, np.nan, self._count[part])


@dataclass(frozen=True)
class Loop:
    """
    Torque over twist of one slice of time.

    begin, end (s); cloud ([P], [P]): some of the points (rad, N m); up, down ([B], [B]): mean
    torque over twist while the twist grows and while it falls, NaN in bins with few points.
    """

    begin: float
    end: float
    cloud: tuple[Array, Array]
    up: tuple[Array, Array]
    down: tuple[Array, Array]


def loop_of(begin: float, end: float, twist: Array, rate: Array, tau_k: Array) -> Loop:
    """
    Return the loop of one slice of time.

    Args:
        begin: of the slice, s.
        end: of the slice, s.
        twist: [N] rad.
        rate: of the twist [N] rad/s.
        tau_k: [N] N m.

    Returns:
        Its points, thinned, and the mean of each branch over bins of the twist.

    """
    step = max(1, len(twist) // CLOUD)
    low, high = (float(np.percentile(twist, share)) for share in (0.5, 99.5))
    edges = np.linspace(low, high, BRANCH_BINS + 1)
    slow = MOVING * float(np.sqrt(np.mean(rate ** 2)))

    def branch(x: Array, y: Array) -> tuple[Array, Array]:
        """Return the means of x and y per bin; NaN: too few points."""
        at = np.searchsorted(edges, x) - 1
        valid = (at >= 0) & (at < BRANCH_BINS)
        count = np.bincount(at[valid], minlength=BRANCH_BINS)
        count = np.where(count < MIN_POINTS, np.nan, count)
        mean_x, mean_y = (np.bincount(at[valid], v[valid], BRANCH_BINS) / count for v in (x, y))
        return mean_x, mean_y
    grows, falls = rate > slow, rate < -slow
    return Loop(begin, end, (twist[::step], tau_k[::step]), branch(twist[grows], tau_k[grows]),
                branch(twist[falls], tau_k[falls]))


class State(NamedTuple):
    """A component at a time: level (0 fine, 1 warning, 2 error), message and its codes."""

    level: int
    component: str
    message: str
    codes: tuple[str, ...] = ()

    @classmethod
    def of(cls, component: str, outcome: Outcome) -> 'State':
        """Return the State of a `component` by its `outcome`."""
        return cls(outcome.level, component, outcome.message, outcome.codes)

    def __str__(self) -> str:
        return f'{self.component} {LEVELS[self.level]}: {self.message}'

    @property
    def first(self) -> str:
        """The first thing that the message says."""
        return self.message.split('; ')[0]

    @property
    def is_judged(self) -> bool:
        """Whether the component was evaluated."""
        return NO_DATA.isdisjoint(self.codes)

    @property
    def is_compared(self) -> bool:
        """Whether wear was compared with an earlier state."""
        return UNCOMPARED.isdisjoint(self.codes)

    @property
    def is_wear(self) -> bool:
        """Whether something has changed for good."""
        return not CHANGED.isdisjoint(self.codes)


def state_of(component: str, level: int, message: str, values: Mapping[str, str]) -> State:
    """Return the State in a status of /diagnostics with these `values` {key: text}."""
    return State(min(level, 2), component, message, tuple(values.get('codes', '').split()))


def worst_first(states: Iterable[State]) -> list[State]:
    """
    Return `states` in the order in which a reader wants them.

    By level, wear before the others of its level. Where there is wear, DRIFT_SHOWS come last:
    prediction errors that a grown gap causes, for example.
    """
    listed = list(states)
    worn = any(state.level and state.is_wear for state in listed)
    return sorted(listed, reverse=True, key=lambda state: (
        not (worn and state.component in DRIFT_SHOWS), state.level, state.is_wear))


@dataclass
class LevelSpans:
    """The states of one component: begins [s], the newest of each level, and the end (s)."""

    begins: list[float] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    end: float = 0.0

    @property
    def levels(self) -> list[int]:
        """The level of each span."""
        return [state.level for state in self.states]

    @property
    def newest(self) -> State:
        """The state in force."""
        return self.states[-1]

    def spans(self) -> Iterator[tuple[float, float, State]]:
        """Yield (begin, end, state) of each span."""
        return zip(self.begins, (*self.begins[1:], self.end), self.states)

    def add(self, t: float, state: State) -> None:
        """Note that a `state` is in force at `t` s."""
        if not self.states or state.level != self.newest.level:
            self.begins.append(t)
            self.states.append(state)
        else:  # the newest state, not the one at the change
            self.states[-1] = state
        self.end = max(self.end, t)

    def forget(self, before: float) -> None:
        """Drop the spans that ended before the time `before` (s); the newest stays."""
        ended = sum(end < before for end in self.begins[1:])
        del self.begins[:ended], self.states[:ended]

    def shares(self) -> list[float]:
        """Return [share of the time at OK, WARN, ERROR]."""
        lengths = np.diff([*self.begins, self.end])
        total = max(float(lengths.sum()), 1e-300)
        return [float(lengths[np.array(self.levels) == level].sum()) / total
                for level in range(len(LEVELS))]


@dataclass(frozen=True)
class WindowBacklash:
    """
    Measurement of one drift window, ended at `t` s; NaN: unknown.

    gap, gap_std, lost_motion (rad); separable: whether the gap is distinguished from compliance;
    baseline, warn, error: gaps (rad) of the baseline and of the limits at that operating point.
    """

    t: float
    gap: float
    gap_std: float
    lost_motion: float
    separable: bool
    baseline: float = math.nan
    warn: float = math.nan
    error: float = math.nan


def gap_limits(values: Mapping[str, Any]) -> tuple[float, float, float]:
    """Return baseline, warning and error limit (rad) in the `values` of an outcome on backlash."""
    baseline, warn, error = (float(values.get(name, math.nan)) for name in (
        'baseline_gap_rad', 'growth_warn', 'growth_error'))
    return baseline, baseline * (1.0 + warn), baseline * (1.0 + error)


def measured(fit: Backlash, values: Mapping[str, Any]) -> WindowBacklash:
    """Return the window of a `fit` with the limits in the `values` of the outcome on backlash."""
    return WindowBacklash(math.nan, fit.gap, fit.gap_std, fit.lost_motion, fit.separable,
                          *gap_limits(values))


class PublishedWindows:
    """Tells the drift windows in what a node publishes about backlash, once per second."""

    def __init__(self) -> None:
        self._newest: tuple[str | None, ...] = ()

    def window(self, t: float, values: Mapping[str, str]) -> WindowBacklash | None:
        """Return the window in the `values` {key: text} at `t` s, None if it is not a new one."""
        if 'gap_rad' not in values:
            return None
        figures = tuple(values.get(f'{key}_rad') for key in ('gap', 'gap_std', 'lost_motion'))
        if figures == self._newest:
            return None
        self._newest = figures
        numbers = {key: float(value) for key, value in values.items() if is_number(value)}
        gap, gap_std, lost_motion = (numbers.get(f'{key}_rad', math.nan)
                                     for key in ('gap', 'gap_std', 'lost_motion'))
        return WindowBacklash(t, gap, gap_std, lost_motion, values.get('separable') != 'False',
                              *gap_limits(numbers))


def is_number(text: str) -> bool:
    """Return whether `text` is a number that a drive can have."""
    try:
        return abs(float(text)) < LARGEST
    except ValueError:
        return False


@dataclass(frozen=True)
class RecordedAlert:
    """A lasting change: `t` s, and the state of its component."""

    t: float
    state: State


class Timeline:
    """
    All that a page of a recording shows over time.

    slice_seconds: length of a slice of the loops; errors: innovations of motor and arm with their
    stated deviations (rad); coverage [motor, arm]: innovations, and those within two deviations;
    torque: tau_K, its deviation, commanded torque (N m); nis: over its degrees of freedom;
    steps: between the stamps of samples (s).
    """

    def __init__(self, slice_seconds: float) -> None:
        """Begin with slices of `slice_seconds`."""
        self.slice_seconds = slice_seconds
        self.first_ns: int | None = None
        self.errors, self.torque, self.nis, self.steps = map(Envelope, (4, 3, 1, 1))
        self.coverage = np.zeros((2, 2))
        self.spans: dict[str, LevelSpans] = {}
        self.windows: list[WindowBacklash] = []
        self.alerts: list[RecordedAlert] = []
        self.loops: list[Loop] = []
        self.samples, self.last = 0, 0.0
        self._slice: list[Array] = []
        self._begin = 0.0
        self._previous = math.nan

    @property
    def newest(self) -> list[State]:
        """The states of all components at the end."""
        return [spans.newest for spans in self.spans.values()]

    def seconds(self, stamps: Integers) -> Array:
        """Return times (s) of `stamps` [N] ns."""
        return (stamps - (self.first_ns or 0)) / SECOND_NS

    def second(self, stamp_ns: int) -> float:
        """Return the time (s) of `stamp_ns`."""
        return float((stamp_ns - (self.first_ns or 0)) / SECOND_NS)

    def add_inputs(self, stamps: Integers, torque: Array) -> None:
        """Take samples: `stamps` [N] ns, `torque` [N] N m."""
        if not len(stamps):
            return
        if self.first_ns is None:
            self.first_ns = int(stamps[stamps > 0][0]) if (stamps > 0).any() else 0
        t = self.seconds(stamps)
        self.samples += len(t)
        self.steps.add(t, np.diff(t, prepend=self._previous))
        self._previous = float(t[-1])
        self.last = max(self.last, float(t.max()))
        nothing = np.full(len(t), np.nan)
        self.torque.add(t, nothing, nothing, torque)

    def add_loop(self, stamps: Integers, twist: Array, rate: Array, tau_k: Array) -> None:
        """
        Take points of the loop, smoothed.

        Args:
            stamps: [N] ns.
            twist: [N] rad.
            rate: of the twist [N] rad/s.
            tau_k: [N] N m.

        """
        rows = np.column_stack([self.seconds(stamps), twist, rate, tau_k])
        rows = rows[np.isfinite(rows).all(axis=1) & (rows[:, 0] >= self._begin)]
        while len(rows):
            in_slice = rows[:, 0] < self._begin + self.slice_seconds
            self._slice.append(rows[in_slice])
            rows = rows[~in_slice]
            if len(rows):
                self._end_slice()

    def _end_slice(self) -> None:
        end = self._begin + self.slice_seconds
        rows = np.concatenate(self._slice) if self._slice else np.empty((0, 4))
        if len(rows) > 10 * BRANCH_BINS and np.ptp(rows[:, 1]) > 0.0:
            self.loops.append(loop_of(self._begin, min(end, float(rows[-1, 0])), *rows[:, 1:].T))
        self._slice, self._begin = [], end

    def add_estimates(self, estimates: Estimates, twist_std: float) -> None:
        """Take `estimates`; `twist_std`: see twist_std."""
        t, smoothed = self.seconds(estimates.stamp_ns), estimates.smoothed
        errors, stds = (np.column_stack(sides) for sides in (
            (estimates.innovation_motor, estimates.innovation_arm),
            (estimates.innovation_std_motor, estimates.innovation_std_arm)))
        finite = np.isfinite(errors) & np.isfinite(stds)
        with np.errstate(invalid='ignore', divide='ignore'):
            covered = finite & (np.abs(errors) <= 2.0 * stds)
            self.nis.add(t, estimates.nis / estimates.dof)
        self.errors.add(t, *errors.T, *stds.T)
        self.coverage += np.stack([finite.sum(axis=0), covered.sum(axis=0)], axis=1)
        self.torque.add(t, estimates.tau_k, estimates.tau_k_std, np.full(len(t), np.nan))
        valid = smoothed[:, S_TWIST_NOISE_STD] <= twist_std
        self.add_loop(estimates.smoothed_stamp_ns[valid], *(
            smoothed[valid, column] for column in (S_TWIST, S_TWIST_RATE, S_TAU_K)))

    def add_states(self, stamp_ns: int, states: Iterable[State]) -> None:
        """Take the `states` of components in force at `stamp_ns`."""
        t = max(self.second(stamp_ns), 0.0)
        for state in states:
            self.spans.setdefault(state.component, LevelSpans()).add(t, state)

    def add_window(self, stamp_ns: int, window: WindowBacklash) -> None:
        """Take the `window` that ended at `stamp_ns`; its time is set here."""
        self.windows.append(replace(window, t=self.second(stamp_ns)))

    def add_alert(self, stamp_ns: int, state: State) -> None:
        """Take a lasting change to a `state` at `stamp_ns`."""
        self.alerts.append(RecordedAlert(max(self.second(stamp_ns), 0.0), state))

    def finish(self) -> None:
        """End the last slice and all spans."""
        if self._slice:
            self._end_slice()
        for spans in self.spans.values():
            spans.end = max(spans.end, self.last)


MINUTE = 60.0
SHORT, SHORT_SLICE = 180.0, 10.0  # s: shorter recordings have loops of 10 s
MAX_LOOPS = 240
PICTURE_LOOPS = 5


@dataclass
class RecordingFacts:
    """
    Facts about a Timeline.

    model: DriveModel; parameters: all of the estimator; versions [(of, version)]; counts
    {counter: number}; notes: sentences.
    """

    model: DriveModel
    parameters: EstimatorParameters
    versions: list[tuple[str, str]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def recorded_timeline(reader: BagReader, topic: str = 'joint_states',
                      model: DriveModel | None = None, parameters: Values | None = None,
                      progress: Callable[[float], object] | None = None
                      ) -> tuple[Timeline, RecordingFacts]:
    """
    Return the time line of a bag, as a replay of it has it, and facts about it.

    Args:
        reader: of the bag.
        topic: of the inputs.
        model: replaces the recorded model.
        parameters: {name: value} that replace those of the bag.
        progress: called with the share that is done, 0 to 1.

    Raises:
        InputError: the bag has no such input, or its parameters are bad.

    """
    begin, seconds = reader.start_ns or 0, 1e-9 * ((reader.end_ns or 0) - (reader.start_ns or 0))
    timeline = Timeline(SHORT_SLICE if seconds < SHORT else
                        MINUTE * math.ceil(seconds / MINUTE / MAX_LOOPS))
    follower = MonitorFollower(timeline)
    player = Player(reader, model, parameters, topic, follow=follower.take)
    clock: list[Integers] = []
    for part in player.parts():
        times = np.stack([part.log_ns, part.samples.stamp_ns])
        clock.append(times[:, ::max(times.shape[1] - 1, 1)])
        if progress:
            progress(1e-9 * (part.end_ns - begin) / max(seconds, 1e-9))
    for stamp, state in _of_live_node(player, np.concatenate(clock, axis=1), follower.codes):
        timeline.add_states(stamp, [state])
    timeline.finish()
    monitor, estimator = player.monitor, player.estimator
    snapshots = read_snapshots(reader, player.input, model is None)
    versions = [('this page', __version__)]
    recorder = reader.metadata.get('gearbox_monitor', {}).get('version')
    versions += [('recorder', recorder)] if recorder else []
    for name, label in (('version', 'estimator'), ('kernels', 'estimator, kernels')):
        values = dict.fromkeys(s.content[name] for s in snapshots if name in s.content)
        versions += [(label, ', '.join(values))] if values else []
    return timeline, RecordingFacts(
        estimator.model, estimator.parameters, [*versions, ('kernels', KERNELS)],
        {text: int(monitor.counts[code]) for code, text in REASONS.items()},
        [*player.notes, *estimator.warnings, *estimator.divergence_notes(),
         *filter(None, [reader.notice])])


def _of_live_node(player: Player, clock: Integers, known: set[str]
                  ) -> Iterator[tuple[int, State]]:
    """
    Yield (stamp, State) of the input as the recorded node stated it while samples came.

    Args:
        player: of the bag.
        clock: log times and stamps [2, N] of some samples, ns; a driver may have its own clock.
        known: codes that the replay raises as well, which are OK here.

    """
    reader, snapshots = player.reader, player.input.snapshots
    if not snapshots or DIAGNOSTICS not in reader.topics:
        return
    name = f'{snapshots.removesuffix(f"/{SNAPSHOT}").lstrip("/")}: input'
    for _, log_ns, _, raw in reader.messages([DIAGNOSTICS]):
        stamp = float(np.interp(log_ns, clock[0], clock[1], left=math.nan, right=math.nan))
        for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
            if status.name == name and math.isfinite(stamp):
                state = state_of(LIVE_NODE, int(status.level), status.message,
                                 {v.key: v.value for v in status.values})
                yield int(stamp), (
                    state._replace(level=0) if known.issuperset(state.codes) else state)


def twist_std(parameters: EstimatorParameters) -> float:
    """Return the deviation of the twist (rad) by `parameters`; above it an encoder was missing."""
    return math.hypot(parameters.r_std_motor, parameters.r_std_arm)


class MonitorFollower:
    """Passes the results of a Monitor to a Timeline; `codes` of its input so far."""

    def __init__(self, timeline: Timeline) -> None:
        """Follow into `timeline`."""
        self._timeline, self.codes = timeline, set[str]()
        self._window: Backlash | None = None
        self._outcomes: Mapping[str, Outcome] = {}

    def take(self, monitor: Monitor, samples: Samples, estimates: Estimates) -> None:
        """Take the newest `samples` and their `estimates` by the `monitor`."""
        timeline = self._timeline
        timeline.add_inputs(samples.stamp_ns, samples.u[:, 0])
        timeline.add_estimates(estimates, twist_std(monitor.parameters))
        if monitor.outcomes is self._outcomes:
            return
        self._outcomes = monitor.outcomes
        self.codes.update(self._outcomes['input'].codes)
        states = [State.of(name, outcome) for name, outcome in self._outcomes.items()]
        if timeline.spans or any(state.is_judged for state in states):
            timeline.add_states(monitor.stamp_ns, states)
        if monitor.windows and monitor.windows[-1] is not self._window:
            self._window = window = monitor.windows[-1]
            timeline.add_window(window.stamp_ns,
                                measured(window, self._outcomes['backlash'].values))
        while monitor.alerts:
            stamp_ns, name, outcome = monitor.alerts.popleft()
            timeline.add_alert(stamp_ns, State.of(name, outcome))


def timeline_of(estimates: Estimates, windows: Iterable[Backlash], values: Mapping[str, Any],
                parameters: EstimatorParameters) -> Timeline:
    """
    Return the time line of estimates that are at hand, for their page.

    Args:
        estimates: all of a recording.
        windows: its measurements of backlash.
        values: of the newest outcome on backlash, for its limits.
        parameters: of the estimator.

    """
    stamps = estimates.stamp_ns
    seconds = float(np.ptp(stamps)) / SECOND_NS if len(stamps) else 0.0
    timeline = Timeline(max(seconds / PICTURE_LOOPS, 1e-3))
    timeline.add_inputs(stamps, np.full(len(stamps), np.nan))
    timeline.add_estimates(estimates, twist_std(parameters))
    for window in windows:
        timeline.add_window(window.stamp_ns, measured(window, values))
    timeline.finish()
    return timeline
