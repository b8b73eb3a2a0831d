# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The live page: what is kept of each gearbox, and the parts that are drawn while messages come.

A history holds the newest seconds, levels, backlash and alerts, in bounded memory. Times (s) come
from the caller, of any clock that never goes back.
"""
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
import math
from typing import Any

import numpy as np

from gearbox_monitor.health.backlash.features import width_of
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.presentation import number, on_axis
from gearbox_monitor.report.builder import (
    framed, Page, page_summary, PageTable, render_section, Section)
from gearbox_monitor.report.chart import (
    Chart, Lane, LoopSlice, Panel, Plane, round_span, thinned_rows, Trace)
from gearbox_monitor.report.recording_page import (
    backlash_panel, drawn_windows, joint_table, JointRow, ROLES, trusted_share, worst_rows)
from gearbox_monitor.report.timeline import (
    is_number, LARGEST, LEVELS, LevelSpans, PublishedWindows, SECOND_NS, State, state_of,
    WindowBacklash, worst_first)
from gearbox_monitor.report.watch_page import watch_part
from gearbox_monitor.report.words import answer, GEARBOXES, sentence

MOTION_SECONDS = 10.0   # of torque and twist
MOTION_ROWS = 20_000    # samples of them: 10 s at 2 kHz
DROPOUT = 0.2           # s without a sample that leave a gap in the curves
LEVEL_SECONDS = 600.0   # of levels
MAX_WINDOWS, MAX_ALERTS = 300, 20
SILENT_SECONDS = 3.0    # without diagnostics: the last ones no longer count


@dataclass(frozen=True)
class RecentMotion:
    """Torque and twist: t [N] s before the newest sample, twist [N] rad, tau_k [N] N m."""

    t: Array
    twist: Array
    tau_k: Array


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
        self.alerts: deque[str] = deque(maxlen=MAX_ALERTS)
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

    def add_alert(self, state: State, when: str) -> None:
        """Take a change on drift_alerts to a `state`, and the time of day `when` it came."""
        self.alerts.append(f'{when}: {state}')
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


DRAWN = 12         # gearboxes with charts, the worst ones; the table has all
LOOP_SLICES = 5    # each with its colour
LOOP_POINTS, TIME_POINTS = 1600, 600
MINUTE = 60.0
NOTHING = np.empty(0)


def live_frame() -> tuple[str, str]:
    """Return the page into which the parts are put, and its Content-Security-Policy."""
    return framed(Page('Live', Section('', {}), ()), 'live/frame.html', 'live.js',
                  "; connect-src 'self'")


@dataclass(frozen=True)
class WatchNews:
    """
    The newest of the watch `node` of a robot.

    heard: time of its newest diagnostics, None without any; data: of its findings; description:
    URDF; problem: of its stream, in words.
    """

    node: str
    heard: float | None = None
    data: Mapping[str, Any] = field(default_factory=dict)
    description: str = ''
    problem: str = ''


class LivePage:
    """Draws the parts of the page; those that only diagnostics change, only when they do."""

    def __init__(self) -> None:
        self._conditions: dict[str, tuple[int, str]] = {}
        self._watch: tuple[WatchNews | None, str] = None, ''

    def parts(self, gearboxes: Sequence[GearboxHistory], source: str, time_s: float,
              watch: WatchNews | None = None) -> dict[str, str]:
        """
        Return {id: HTML} of all parts, from top to bottom.

        Args:
            gearboxes: in the order of the page.
            source: name of the estimator.
            time_s: now, by the clock of the histories.
            watch: of the robot, if there is one.

        """
        axis = gearboxes[0].axis if gearboxes else 'rotary'
        watched = watch is not None and watch.heard is not None
        parts = {'watch': self._watched(watch, time_s) if watch is not None and watched else '',
                 'summary': '' if watched and not gearboxes else
                 render_section(live_summary(gearboxes, source, time_s), axis),
                 'joints': render_section(joint_table(worst_rows(
                     [live_row(gearbox, title(gearbox)) for gearbox in gearboxes])), axis)}
        order = sorted(range(len(gearboxes)), key=lambda k: -gearboxes[k].worst().level)[:DRAWN]
        for k in sorted(order):
            gearbox = gearboxes[k]
            changes, html = self._conditions.get(gearbox.name, (-1, ''))
            if changes != gearbox.changes:
                html = render_section(_condition(gearbox), gearbox.axis)
                self._conditions[gearbox.name] = gearbox.changes, html
            for name, part in (('motion', render_section(_motion(gearbox), gearbox.axis)),
                               ('condition', html)):
                if len(gearboxes) > 1:
                    name_of = f'{escape(title(gearbox))}: {name}'
                    part = (f'<details{" open" * (k == order[0])}><summary>{name_of}</summary>'
                            f'{part}</details>')
                parts[f'{name}{k}'] = f'<div class="old">{part}</div>' \
                    if gearbox.is_old(time_s) else part
        return parts

    def _watched(self, watch: WatchNews, time_s: float) -> str:
        """Return the part of a `watch` that was heard; findings that are none are a problem."""
        silent = time_s - (watch.heard or 0.0)
        if silent > SILENT_SECONDS:
            watch = replace(watch, problem=f'{watch.node} has been silent for {silent:.0f} s')
        shown = replace(watch, heard=0.0)
        if shown != self._watch[0]:
            try:
                html = watch_part(watch.data, watch.description, watch.node, watch.problem)
            except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
                html = watch_part({}, '', watch.node, f'{watch.node}: findings of another kind')
            self._watch = shown, html
        return self._watch[1]


def live_summary(gearboxes: Sequence[GearboxHistory], source: str, time_s: float) -> Section:
    """
    Return the worst of all gearboxes in one sentence.

    Args:
        gearboxes: all gearboxes of the node.
        source: name of the estimator.
        time_s: now.

    """
    heard = [gearbox.heard for gearbox in gearboxes if gearbox.heard is not None]
    if not heard:
        return page_summary('', f'Waiting for diagnostics of {source}.')
    if time_s - max(heard) > SILENT_SECONDS:
        return page_summary('error', f'{source} has been silent for {time_s - max(heard):.0f} s.')
    worst = [gearbox.worst() for gearbox in gearboxes]
    raised = [state for state in worst_first(worst) if state.level]
    if not raised:
        states = [gearbox.levels['backlash'].newest for gearbox in gearboxes
                  if 'backlash' in gearbox.levels]
        uncompared = [state for state in states if not state.is_compared]
        return page_summary('' if uncompared else 'good', ' '.join(
            ('The estimates are trusted.',
             *(sentence(state.first) for state in (uncompared or states)[:1]))))
    state = raised[0]
    first = next(gearbox for gearbox, own in zip(gearboxes, worst) if own is state)
    spans = first.levels.get('diagnosis')
    cause = [('cause', spans.newest.message)] if spans and spans.newest.level else []
    return page_summary(
        ROLES[state.level], answer([f'{title(first)}: {state.component}: {state.first}',
                                    *(other.first for other in raised[1:])], (), GEARBOXES),
        cause if state.component != 'diagnosis' else ())


def live_row(gearbox: GearboxHistory, name: str) -> JointRow:
    """Return the row of a `gearbox` that the live page calls `name`."""
    state = gearbox.worst()
    kind = ROLES[state.level] if gearbox.levels else ''
    tau_k = gearbox.motion(MOTION_ROWS).tau_k
    tau_k = tau_k[np.isfinite(tau_k)]
    span = (float(tau_k.min()), float(tau_k.max())) if len(tau_k) else (math.nan, math.nan)
    return JointRow(name, kind, f'{state.component}: {state.first}' if state.level else '', span,
                    list(gearbox.windows), trusted_share(gearbox.levels), worn=state.is_wear)


def title(gearbox: GearboxHistory) -> str:
    """Return the name of `gearbox` on the page."""
    if gearbox.serial in ('', gearbox.name):
        return gearbox.name
    return gearbox.serial if gearbox.name == 'transmission' else \
        f'{gearbox.name} ({gearbox.serial})'


def _motion(gearbox: GearboxHistory) -> Section:
    """Return torque over twist and over time, if there are samples."""
    motion, loop = gearbox.motion(TIME_POINTS), gearbox.motion(LOOP_POINTS)
    data: dict[str, Any] = {'title': title(gearbox), 'facts': (), 'plane': None, 'torque': None}
    if not len(motion.t):
        return Section('live/motion.html', data)

    def label(text: str) -> str:
        return on_axis(text, gearbox.axis)
    limits = round_span(motion.tau_k)
    known = not math.isnan(gearbox.tau_k_std)
    data['torque'] = Chart('Torque over time', [Panel(
        label('torque (N m)'), [Trace(
            motion.t, motion.tau_k, 'torque' + ', ± 2 sigma' * known,
            'signal').around(gearbox.tau_k_std)],
        height=420, limits=limits)],
        'time before the newest sample (s)', span=(-MOTION_SECONDS, 0.0), zoom=False)
    facts = [(name, label(f'{values[-1]:{width}} {unit}')) for name, values, width, unit in (
        ('torque', motion.tau_k[np.isfinite(motion.tau_k)], '.2f', 'N m'),
        ('twist', motion.twist[np.isfinite(motion.twist)], '.4f', 'rad')) if len(values)]
    if np.isfinite(loop.twist).any():
        edges = np.linspace(-MOTION_SECONDS, 0.0, LOOP_SLICES + 1)
        slices = []
        for begin, end in zip(edges[:-1], edges[1:]):
            rows = (loop.t >= begin) & (loop.t <= end)
            slices.append(LoopSlice(f'{begin:g} s' if end else 'now', (NOTHING, NOTHING),
                                    [(loop.twist[rows], loop.tau_k[rows])]))
        data['plane'] = Plane(
            'Torque over twist', slices, label('twist, motor - arm (rad)'),
            label('torque (N m)'), limits=(round_span(loop.twist), limits))
    if gearbox.windows:
        window = gearbox.windows[-1]
        facts.append(('backlash', str(width_of(window.gap, window.gap_std, label('rad'))))
                     if window.separable else
                     ('lost motion', number(window.lost_motion, label('rad'))))
    facts.append(('samples per second', f'{gearbox.rate():.0f}'))
    return Section('live/motion.html', {**data, 'facts': facts})


def _condition(gearbox: GearboxHistory) -> Section:
    """Return trust, backlash and alerts, if anything was heard."""
    data: dict[str, Any] = {'levels': None, 'backlash': None}
    if gearbox.heard is None:
        return Section('live/condition.html', data)
    time_s, last = gearbox.heard, LEVEL_SECONDS / MINUTE
    lanes = [Lane(
        f'{name}: {LEVELS[spans.newest.level]}',
        [(max(begin, time_s - LEVEL_SECONDS) - time_s) / MINUTE for begin in spans.begins],
        (spans.end - time_s) / MINUTE, spans.levels,
        [f'{name} {LEVELS[level]}' for level in spans.levels])
        for name, spans in gearbox.levels.items()]
    windows, lost_motion = drawn_windows(
        [replace(window, t=window.t - time_s) for window in gearbox.windows])
    if windows:
        data['backlash'] = Chart(
            'Lost motion' if lost_motion else 'Backlash',
            [backlash_panel(windows, lost_motion, MINUTE, gearbox.axis)], 'time (min)',
            span=(1.03 * min(windows[0].t / MINUTE, -1.0), 0.0), zoom=False)
    states = sorted((spans.newest for spans in gearbox.levels.values()),
                    key=lambda state: -state.level)
    return Section('live/condition.html', {
        **data,
        'levels': Chart('Levels', lanes, 'time (min)', span=(-last, 0.0), zoom=False),
        'components': PageTable(('level', 'component', 'message'), [
            (LEVELS[state.level], state.component, state.message) for state in states]),
        'alerts': [*reversed(gearbox.alerts)]})
