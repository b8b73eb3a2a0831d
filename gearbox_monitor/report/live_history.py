# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a live page shows of one gearbox: its newest seconds, levels, backlash and alerts.

Memory is bounded. Times (s) come from the caller, of any clock that never goes back.
"""
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.health.monitor import DRIFT_SHOWS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.report.chart import thinned_rows
from gearbox_monitor.report.timeline import (
    is_number, LARGEST, LevelSpans, PublishedWindows, SECOND_NS, State, state_of,
    WindowBacklash)

MOTION_SECONDS = 10.0   # of torque and twist
MOTION_ROWS = 20_000    # samples of them: 10 s at 2 kHz
DROPOUT = 0.2           # s without a sample that leave a gap in the curves
LEVEL_SECONDS = 600.0   # of levels
MAX_WINDOWS, MAX_ALERTS = 300, 20
SILENT_SECONDS = 3.0    # without diagnostics: the last ones no longer count


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


@dataclass(frozen=True)
class RecentMotion:
    """Torque and twist: t [N] s before the newest sample, twist [N] rad, tau_k [N] N m."""

    t: Array
    twist: Array
    tau_k: Array


@dataclass(frozen=True)
class StatusAlert:
    """A change on drift_alerts: the state of its component, and the time of day."""

    state: State
    when: str


class GearboxHistory:
    """
    The newest of the gearbox `name`, from its messages.

    serial: its name on /diagnostics; axis: of its drive; heard: time of its newest diagnostics,
    None without any; changes: how often what they say was updated. levels: {component: spans};
    windows, alerts: from the oldest. tau_k_std: stated deviation of the torque (N m).
    """

    def __init__(self, name: str) -> None:
        self.name, self.serial, self.axis = name, '', 'rotary'
        self.heard: float | None = None
        self.changes = 0
        self.levels: dict[str, LevelSpans] = {}
        self.windows: deque[WindowBacklash] = deque(maxlen=MAX_WINDOWS)
        self.alerts: deque[StatusAlert] = deque(maxlen=MAX_ALERTS)
        self.tau_k_std = math.nan
        self._published = PublishedWindows()
        self._stamps = np.empty(0, np.int64)
        self._values: Array = np.empty((0, 2))

    def add_motion(self, stamps: Integers, values: Array) -> None:
        """Take samples: `stamps` [N] ns, `values` [N, 2] twist (rad) and torque (N m)."""
        stamps = np.concatenate([self._stamps, stamps])
        # Anybody can publish anything.
        values = np.concatenate([self._values, np.where(np.abs(values) < LARGEST, values, np.nan)])
        # Stamps go back where a source began again.
        back = np.flatnonzero(np.diff(stamps) < 0)
        first = int(back[-1]) + 1 if len(back) else 0
        if len(stamps):
            oldest = stamps[-1] - int(MOTION_SECONDS * SECOND_NS)
            first = max(first, len(stamps) - MOTION_ROWS, int(np.searchsorted(
                stamps[first:], oldest)) + first)
        self._stamps, self._values = stamps[first:], values[first:]

    def add_status(self, time_s: float, component: str, level: int, message: str,
                   values: Mapping[str, str]) -> None:
        """
        Take a status of /diagnostics.

        Args:
            time_s: when it came.
            component: that it is about.
            level: 0 fine, 1 warning, 2 and above error.
            message: in words.
            values: {key: text}.

        """
        self.heard, self.changes = time_s, self.changes + 1
        spans = self.levels.setdefault(component, LevelSpans())
        spans.add(time_s, state_of(component, level, message, values))
        spans.forget(time_s - LEVEL_SECONDS)
        if component == 'backlash':
            window = self._published.window(time_s, values)
            if window is not None:
                self.windows.append(window)
        elif component == 'covariance':
            text = values.get('tau_k_std', '')
            self.tau_k_std = float(text) if is_number(text) else math.nan

    def add_alert(self, alert: StatusAlert) -> None:
        """Take an `alert`."""
        self.alerts.append(alert)
        self.changes += 1

    def worst(self) -> State:
        """Return the state of the worst component, see worst_first; an empty one without any."""
        states = worst_first(spans.newest for spans in self.levels.values())
        return states[0] if states else State(0, '', '')

    def is_old(self, time_s: float) -> bool:
        """Return whether the state is old at `time_s`: no diagnostics came, or no samples."""
        silent = self.heard is not None and time_s - self.heard > SILENT_SECONDS
        spans = self.levels.get('input')
        return silent or spans is not None and spans.newest.level > 1

    def rate(self) -> float:
        """Return samples per second of stamps over the motion, 0 for fewer than two."""
        if len(self._stamps) < 2:
            return 0.0
        seconds = float(self._stamps[-1] - self._stamps[0]) / SECOND_NS
        return (len(self._stamps) - 1) / seconds if seconds else 0.0

    def motion(self, points: int) -> RecentMotion:
        """Return the motion with about so many `points`: extremes of the torque stay."""
        at = thinned_rows(self._values[:, 1], points)
        t = (self._stamps[at] - (self._stamps[-1] if len(at) else 0)) / SECOND_NS
        values = self._values[at]
        values[np.diff(t, prepend=t[:1]) > DROPOUT] = np.nan
        return RecentMotion(t, *values.T)
