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
What a recording showed over time, gathered as it comes, in bounded memory.

Signals become envelopes (lowest, highest and mean value per bin of time), torque over twist one
loop per slice, findings spans of one level. Stamps are ns of the measurements; times are s from
the first of them.
"""
from dataclasses import dataclass, field
import math

import numpy as np

SECOND = 1e9
MAX_BINS = 3000
FIRST_BIN = 0.01       # s, doubled while there are more than MAX_BINS
CLOUD = 400            # points of a loop
BRANCH_BINS, LEAST = 36, 12  # of the mean of a branch; points in a bin
MOVING = 0.05          # of the rms rate of the twist: slower belongs to no branch
LEVELS = ('OK', 'WARN', 'ERROR')
MAX_RATE_BINS = 3600   # of rate and longest step


class Envelope:
    """Lowest, highest and mean value of signals per bin of time; bins widen as time goes on."""

    def __init__(self, count):
        """Begin with `count` signals."""
        self.width, self._bins = FIRST_BIN, 0
        self._low = np.full((count, MAX_BINS), np.inf)
        self._high = np.full((count, MAX_BINS), -np.inf)
        self._sum, self._seen = np.zeros((2, count, MAX_BINS))

    def add(self, t, *signals):
        """Take signals [N] at the times t [N] s, all >= 0; NaN counts nothing."""
        if not len(t):
            return
        while t.max() >= MAX_BINS * self.width:
            self._widen()
        at = (t / self.width).astype(int)
        self._bins = max(self._bins, int(at.max()) + 1)
        for k, signal in enumerate(signals):
            good = np.isfinite(signal)
            where, value = (at, signal) if good.all() else (at[good], signal[good])
            np.minimum.at(self._low[k], where, value)
            np.maximum.at(self._high[k], where, value)
            self._sum[k] += np.bincount(where, value, MAX_BINS)
            self._seen[k] += np.bincount(where, minlength=MAX_BINS)

    def _widen(self):
        """Join two bins each."""
        for table, join, empty in ((self._low, np.minimum, np.inf),
                                   (self._high, np.maximum, -np.inf), (self._sum, np.add, 0.0),
                                   (self._seen, np.add, 0.0)):
            half = join(table[:, ::2], table[:, 1::2])
            table[:] = empty
            table[:, :half.shape[1]] = half
        self.width, self._bins = 2.0 * self.width, -(-self._bins // 2)

    @property
    def t(self):
        """Middles of the bins [B], s."""
        return (np.arange(self._bins) + 0.5) * self.width

    def of(self, k):
        """Return (lowest, highest, mean) [B] of signal `k`; NaN where there was none."""
        part = np.s_[k, :self._bins]
        none = self._seen[part] == 0.0
        low, high = (np.where(none, np.nan, table[part]) for table in (self._low, self._high))
        with np.errstate(invalid='ignore'):
            return low, high, self._sum[part] / np.where(none, np.nan, self._seen[part])


@dataclass(frozen=True)
class Loop:
    """
    Torque over twist of one slice of time.

    begin, end (s); cloud ([P], [P]): some of the points (rad, N m); up, down ([B], [B]): mean
    torque over twist while the twist grows and while it falls.
    """

    begin: float
    end: float
    cloud: tuple
    up: tuple
    down: tuple


def loop_of(begin, end, twist, rate, tau_k):
    """Return the Loop of twist [N] rad, its rate [N] rad/s and tau_k [N] N m."""
    step = max(1, len(twist) // CLOUD)
    edges = np.linspace(*np.percentile(twist, (0.5, 99.5)), BRANCH_BINS + 1)
    slow = MOVING * float(np.sqrt(np.mean(rate ** 2)))
    branches = []
    for chosen in (rate > slow, rate < -slow):
        x, y = twist[chosen], tau_k[chosen]
        at = np.searchsorted(edges, x) - 1
        inside = (at >= 0) & (at < BRANCH_BINS)
        count = np.bincount(at[inside], minlength=BRANCH_BINS)
        mean = [np.bincount(at[inside], v[inside], BRANCH_BINS) / np.maximum(count, 1)
                for v in (x, y)]
        branches.append(tuple(v[count >= LEAST] for v in mean))
    return Loop(begin, end, (twist[::step], tau_k[::step]), *branches)


@dataclass
class Spans:
    """The levels of one component: begins [s], level of each, message of each; end (s)."""

    begins: list = field(default_factory=list)
    levels: list = field(default_factory=list)
    messages: list = field(default_factory=list)
    end: float = 0.0

    def add(self, t, level, message):
        """Note that `level` is in force at `t` s."""
        if not self.levels or level != self.levels[-1]:
            self.begins.append(t)
            self.levels.append(level)
            self.messages.append(message)
        elif level:  # the words of an alarm grow better with time
            self.messages[-1] = message
        self.end = max(self.end, t)

    def shares(self):
        """Return [share of the time at OK, WARN, ERROR]."""
        lengths = np.diff([*self.begins, self.end])
        total = max(float(lengths.sum()), 1e-300)
        return [float(lengths[np.array(self.levels) == level].sum()) / total
                for level in range(len(LEVELS))]


@dataclass(frozen=True)
class Window:
    """
    What one window of drift said, ended at `t` s; NaN: not known.

    gap, gap_std, lost_motion (rad); separable: whether it is the gap that counts; baseline, warn,
    error: gaps (rad) of the baseline and of the limits at that operating point.
    """

    t: float
    gap: float
    gap_std: float
    lost_motion: float
    separable: bool
    baseline: float
    warn: float
    error: float


@dataclass(frozen=True)
class Alert:
    """Something that changed for good: `t` s, component, level and what was said."""

    t: float
    component: str
    level: int
    message: str


class Timeline:
    """
    All that a page of a recording shows over time.

    slice_seconds: length of a slice of the loops.
    """

    def __init__(self, slice_seconds):
        self.slice_seconds = slice_seconds
        self.first_ns = None
        self.errors = Envelope(4)   # innovation of motor, arm; their stated deviations: rad
        self.inside = np.zeros((2, 2))  # [motor, arm]: errors, and those within two deviations
        self.torque = Envelope(3)   # tau_K, its deviation, commanded torque: N m
        self.nis = Envelope(1)      # over its degrees of freedom
        self.spans, self.windows, self.alerts, self.loops = {}, [], [], []
        self.samples, self.last = 0, 0.0
        self._slice, self._begin = [], 0.0
        self._steps, self._counts, self._previous = {}, {}, None

    def seconds(self, stamps):
        """Return times (s) of stamps int64 [N] ns."""
        return (stamps - self.first_ns) / SECOND

    def add_inputs(self, stamps, torque):
        """Take samples: stamps int64 [N] ns, torque [N] N m."""
        if not len(stamps):
            return
        if self.first_ns is None:
            self.first_ns = int(stamps[stamps > 0][0]) if (stamps > 0).any() else 0
        t = self.seconds(stamps)
        self.samples += len(t)
        known = np.concatenate([[t[0] if self._previous is None else self._previous], t])
        self._previous = float(t[-1])
        steps, good = np.diff(known), t >= 0.0
        self.last = max(self.last, float(t.max()))
        nothing = np.full(int(good.sum()), np.nan)
        self.torque.add(t[good], nothing, nothing, torque[good])
        second = t[good].astype(int)
        for k in np.unique(second):
            here = second == k
            self._counts[k] = self._counts.get(k, 0) + int(here.sum())
            self._steps[k] = max(self._steps.get(k, 0.0), float(steps[good][here].max()))

    def add_errors(self, stamps, errors, stds):
        """Take prediction errors [N, 2] and their stated deviations [N, 2], rad, arm side."""
        t = self.seconds(stamps)
        good = t >= 0.0
        self.errors.add(t[good], *errors[good].T, *stds[good].T)
        known = np.isfinite(errors) & np.isfinite(stds)
        with np.errstate(invalid='ignore'):
            within = known & (np.abs(errors) <= 2.0 * stds)
        self.inside += np.stack([known.sum(axis=0), within.sum(axis=0)], axis=1)

    def add_torque(self, stamps, tau_k, std):
        """Take estimates of the torque [N] and their deviations [N], N m."""
        t = self.seconds(stamps)
        good = t >= 0.0
        self.torque.add(t[good], tau_k[good], std[good], np.full(int(good.sum()), np.nan))

    def add_nis(self, stamps, over_dof):
        """Take NIS over its degrees of freedom [N]."""
        t = self.seconds(stamps)
        self.nis.add(t[t >= 0.0], over_dof[t >= 0.0])

    def add_loop(self, stamps, twist, rate, tau_k):
        """Take twist [N] rad, its rate [N] rad/s and the torque [N] N m, smoothed."""
        rows = np.column_stack([self.seconds(stamps), twist, rate, tau_k])
        rows = rows[np.isfinite(rows).all(axis=1) & (rows[:, 0] >= self._begin)]
        while len(rows):
            end = self._begin + self.slice_seconds
            here = rows[:, 0] < end
            self._slice.append(rows[here])
            rows = rows[~here]
            if len(rows):
                self._end_slice()

    def _end_slice(self):
        end = self._begin + self.slice_seconds
        rows = np.concatenate(self._slice) if self._slice else np.empty((0, 4))
        if len(rows) > 10 * BRANCH_BINS and np.ptp(rows[:, 1]) > 0.0:
            self.loops.append(loop_of(self._begin, min(end, float(rows[-1, 0])), *rows[:, 1:].T))
        self._slice, self._begin = [], end

    def add_findings(self, stamp_ns, findings):
        """Take {component: (level, message)} in force at `stamp_ns`."""
        t = max(float(self.seconds(stamp_ns)), 0.0)
        for component, (level, message) in findings.items():
            self.spans.setdefault(component, Spans()).add(t, min(int(level), 2), message)

    def add_window(self, stamp_ns, gap, gap_std, lost_motion, separable, values):
        """Take a window of drift; values: {name: number} that the finding on backlash shows."""
        def number(name):
            return float(values.get(name, math.nan))
        base = number('baseline_gap_rad')
        self.windows.append(Window(
            float(self.seconds(stamp_ns)), gap, gap_std, lost_motion, separable, base,
            base * (1.0 + number('growth_warn')), base * (1.0 + number('growth_error'))))

    def add_alert(self, stamp_ns, component, level, message):
        """Take a change for good."""
        self.alerts.append(Alert(max(float(self.seconds(stamp_ns)), 0.0), component,
                                 min(int(level), 2), message))

    def finish(self):
        """End what is under way."""
        if self._slice:
            self._end_slice()
        for spans in self.spans.values():
            spans.end = max(spans.end, self.last)

    def rates(self):
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
