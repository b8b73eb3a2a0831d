# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a recording showed over time, gathered block by block, in bounded memory.

Signals become envelopes (lowest, highest and mean value per bin of time), torque over twist one
loop per slice, outcomes spans of one level. Stamps are ns of the measurements; times are s from
the first of them.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers

SECOND = 1e9
MAX_BINS = 3000
FIRST_BIN = 0.01       # s, doubled while there are more than MAX_BINS
CLOUD = 400            # points of a loop
BRANCH_BINS, MIN_POINTS = 36, 12  # of the mean of a branch; points in a bin
MOVING = 0.05          # of the rms rate of the twist: slower belongs to no branch
LEVELS = ('OK', 'WARN', 'ERROR')
MAX_RATE_BINS = 3600   # of rate and longest step
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
        """Take `signals` [N] at the times `t` [N] s, all >= 0; NaN counts nothing."""
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


@dataclass
class LevelSpans:
    """The levels of one component: begins [s], level of each, newest message of each; end (s)."""

    begins: list[float] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    end: float = 0.0

    def add(self, t: float, level: int, message: str) -> None:
        """
        Note that a level is in force.

        Args:
            t: time, s.
            level: 0 fine, 1 warning, 2 error.
            message: of the outcome.

        """
        if not self.levels or level != self.levels[-1]:
            self.begins.append(t)
            self.levels.append(level)
            self.messages.append(message)
        else:  # the newest state, not that of the change
            self.messages[-1] = message
        self.end = max(self.end, t)

    def forget(self, before: float) -> None:
        """Drop the spans that ended before the time `before` (s); the newest stays."""
        ended = sum(end < before for end in self.begins[1:])
        del self.begins[:ended], self.levels[:ended], self.messages[:ended]

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


class PublishedWindows:
    """Tells the drift windows in what a node publishes about backlash, once per second."""

    def __init__(self) -> None:
        self._newest: tuple[str | None, ...] = ()

    def window(self, t: float, message: str, values: Mapping[str, str]) -> WindowBacklash | None:
        """
        Return the window of a status, None if it holds no new one.

        Args:
            t: its time, s.
            message: of the status.
            values: {key: text} of the status.

        """
        if 'gap_rad' not in values or message.startswith('not excited now'):
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
    """A lasting change: `t` s, component, level and message."""

    t: float
    component: str
    level: int
    message: str


class Timeline:
    """
    All that a page of a recording shows over time.

    slice_seconds: length of a slice of the loops; errors: innovations of motor and arm with their
    stated deviations (rad); coverage [motor, arm]: innovations, and those within two deviations;
    torque: tau_K, its deviation, commanded torque (N m); nis: over its degrees of freedom.
    """

    def __init__(self, slice_seconds: float) -> None:
        """Begin with slices of `slice_seconds`."""
        self.slice_seconds = slice_seconds
        self.first_ns: int | None = None
        self.errors, self.torque, self.nis = Envelope(4), Envelope(3), Envelope(1)
        self.coverage = np.zeros((2, 2))
        self.spans: dict[str, LevelSpans] = {}
        self.windows: list[WindowBacklash] = []
        self.alerts: list[RecordedAlert] = []
        self.loops: list[Loop] = []
        self.samples, self.last = 0, 0.0
        self._slice: list[Array] = []
        self._begin = 0.0
        self._steps: dict[int, float] = {}
        self._counts: dict[int, int] = {}
        self._previous: float | None = None

    def seconds(self, stamps: Integers) -> Array:
        """Return times (s) of `stamps` [N] ns."""
        return (stamps - (self.first_ns or 0)) / SECOND

    def second(self, stamp_ns: int) -> float:
        """Return the time (s) of `stamp_ns`."""
        return float((stamp_ns - (self.first_ns or 0)) / SECOND)

    def add_inputs(self, stamps: Integers, torque: Array) -> None:
        """Take samples: `stamps` [N] ns, `torque` [N] N m."""
        if not len(stamps):
            return
        if self.first_ns is None:
            self.first_ns = int(stamps[stamps > 0][0]) if (stamps > 0).any() else 0
        t = self.seconds(stamps)
        self.samples += len(t)
        steps = np.diff(np.append(t[0] if self._previous is None else self._previous, t))
        self._previous = float(t[-1])
        valid = t >= 0.0
        self.last = max(self.last, float(t.max()))
        nothing = np.full(int(valid.sum()), np.nan)
        self.torque.add(t[valid], nothing, nothing, torque[valid])
        second = t[valid].astype(int)
        for k in np.unique(second).tolist():
            same = second == k
            self._counts[k] = self._counts.get(k, 0) + int(same.sum())
            self._steps[k] = max(self._steps.get(k, 0.0), float(steps[valid][same].max()))

    def add_errors(self, stamps: Integers, errors: Array, stds: Array) -> None:
        """
        Take innovations.

        Args:
            stamps: [N] ns.
            errors: measured less predicted position [N, 2] rad, arm side.
            stds: their stated deviations [N, 2] rad, arm side.

        """
        t = self.seconds(stamps)
        valid = t >= 0.0
        self.errors.add(t[valid], *errors[valid].T, *stds[valid].T)
        finite = np.isfinite(errors) & np.isfinite(stds)
        with np.errstate(invalid='ignore'):
            covered = finite & (np.abs(errors) <= 2.0 * stds)
        self.coverage += np.stack([finite.sum(axis=0), covered.sum(axis=0)], axis=1)

    def add_torque(self, stamps: Integers, tau_k: Array, std: Array) -> None:
        """
        Take estimates of the torque.

        Args:
            stamps: [N] ns.
            tau_k: [N] N m.
            std: stated deviations [N] N m.

        """
        t = self.seconds(stamps)
        valid = t >= 0.0
        self.torque.add(t[valid], tau_k[valid], std[valid], np.full(int(valid.sum()), np.nan))

    def add_nis(self, stamps: Integers, over_dof: Array) -> None:
        """Take the NIS `over_dof`, its degrees of freedom, [N] at `stamps` [N] ns."""
        t = self.seconds(stamps)
        self.nis.add(t[t >= 0.0], over_dof[t >= 0.0])

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

    def add_outcomes(self, stamp_ns: int, outcomes: Mapping[str, tuple[int, str]]) -> None:
        """Take `outcomes` {component: (level, message)} in force at `stamp_ns`."""
        t = max(self.second(stamp_ns), 0.0)
        for component, (level, message) in outcomes.items():
            self.spans.setdefault(component, LevelSpans()).add(t, min(int(level), 2), message)

    def add_window(self, stamp_ns: int, window: WindowBacklash) -> None:
        """Take the `window` that ended at `stamp_ns`; its time is set here."""
        self.windows.append(replace(window, t=self.second(stamp_ns)))

    def add_alert(self, stamp_ns: int, component: str, level: int, message: str) -> None:
        """
        Take a lasting change.

        Args:
            stamp_ns: its time.
            component: of the outcome.
            level: 0 fine, 1 warning, 2 and above error.
            message: of the outcome.

        """
        self.alerts.append(RecordedAlert(max(self.second(stamp_ns), 0.0), component,
                                         min(int(level), 2), message))

    def finish(self) -> None:
        """End the last slice and all spans."""
        if self._slice:
            self._end_slice()
        for spans in self.spans.values():
            spans.end = max(spans.end, self.last)

    def rates(self) -> tuple[Array, Array, Array]:
        """Return (t [B] s, samples per second [B], longest step [B] s)."""
        seconds = int(self.last) + 1
        width = -(-seconds // MAX_RATE_BINS)
        bins = -(-seconds // width)
        rate, step = np.zeros(bins), np.zeros(bins)
        for k, count in self._counts.items():
            rate[k // width] += count / width
            step[k // width] = max(step[k // width], self._steps[k])
        if self.last >= 2.0:  # the last second is not whole
            rate = rate[:-1] if width == 1 else rate
        bins = len(rate)
        return (np.arange(bins) + 0.5) * width, rate, step[:bins]
