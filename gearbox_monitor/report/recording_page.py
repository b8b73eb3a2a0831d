# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The page of a recording, with its charts, and that of a robot: its gearboxes, each with a page.

The charts are those of results in a notebook and of the live page, too.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import json
import math
from typing import Any

import numpy as np

from gearbox_monitor.health.backlash.features import width_of
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import ESTIMATOR, ParameterRow
from gearbox_monitor.presentation import number, on_axis
from gearbox_monitor.report.builder import (
    advice, Page, page_summary, PageTable, render_page, Section)
from gearbox_monitor.report.chart import Chart, Drawing, Lane, LoopSlice, Mark, Panel, Plane, Trace
from gearbox_monitor.report.sentences import say
from gearbox_monitor.report.timeline import (
    LEVELS, LevelSpans, LIVE_NODE, Loop, RecordingFacts, State, Timeline, WindowBacklash,
    worst_first)
from gearbox_monitor.report.words import answer, JOINTS, sentence

MINUTES = 600.0    # s: longer recordings are shown in minutes
CHANNELS = ('motor', 'arm')
ROLES = ('good', 'warn', 'error')  # of alerts and of the headline, by level
GROUP = 'time'


@dataclass(frozen=True)
class TimeAxis:
    """The axis of time: its last value, s per unit, and the name of the unit."""

    last: float
    scale: float
    unit: str

    def text(self, t: float) -> str:
        """Return the time `t` s in words."""
        return f'{t / self.scale:.4g} {self.unit}'

    def chart(self, title: str, panels: Sequence[Panel | Lane],
              marks: Sequence[Mark] = ()) -> Chart:
        """
        Return a chart on this axis; all of them zoom together.

        Args:
            title: plain text above the chart.
            panels: from top to bottom.
            marks: moments drawn through all panels.

        """
        return Chart(title, panels, f'time ({self.unit})', marks, (0.0, self.last), GROUP)


def time_axis(timeline: Timeline) -> TimeAxis:
    """Return the axis of all charts of `timeline`."""
    scale, unit = (60.0, 'min') if timeline.last > MINUTES else (1.0, 's')
    return TimeAxis(max(timeline.last / scale, 1e-9), scale, unit)


def loop_plane(timeline: Timeline, axis: str) -> Plane | None:
    """Return the hysteresis loops of `timeline` by slices of time, with units of `axis`."""
    if not timeline.loops:
        return None
    minutes = timeline.slice_seconds >= 60.0
    length = 'minute' if timeline.slice_seconds == 60.0 else f'{timeline.slice_seconds:.3g} s'
    return Plane(f'One loop per {length}', [
        LoopSlice(_interval(loop, minutes), loop.cloud, (loop.up, loop.down))
        for loop in timeline.loops], on_axis('twist, motor - arm (rad)', axis),
        on_axis('torque (N m)', axis))


def _interval(loop: Loop, minutes: bool) -> str:
    """Return begin and end of `loop` in words."""
    scale, unit = (60.0, 'min') if minutes else (1.0, 's')
    return f'{loop.begin / scale:.0f} to {np.ceil(loop.end / scale):.0f} {unit}'


def backlash_chart(timeline: Timeline, axis: str) -> Chart | None:
    """Return backlash of `timeline` with alerts, or lost motion, in units of `axis`."""
    if not timeline.windows:
        return None
    time = time_axis(timeline)
    windows, lost_motion = drawn_windows(timeline.windows)
    marks = [Mark(alert.t / time.scale, str(k), ROLES[alert.state.level])
             for k, alert in enumerate(timeline.alerts, 1)]
    return time.chart('Lost motion' if lost_motion else 'Backlash', [
        backlash_panel(windows, lost_motion, time.scale, axis)], marks)


def drawn_windows(windows: Sequence[WindowBacklash]) -> tuple[Sequence[WindowBacklash], bool]:
    """Return those of `windows` to draw, and whether by their lost motion."""
    separable = [w for w in windows if w.separable]
    lost_motion = 2 * len(separable) < len(windows)
    return windows if lost_motion else separable, lost_motion


def backlash_panel(windows: Sequence[WindowBacklash], lost_motion: bool, scale: float,
                   axis: str) -> Panel:
    """
    Return the panel of backlash, with baseline and limits, or of lost motion.

    Args:
        windows: from the oldest.
        lost_motion: whether it replaces backlash.
        scale: s per unit of the time axis.
        axis: of the drive, for units.

    """
    t = np.array([w.t for w in windows]) / scale
    value = np.array([w.lost_motion if lost_motion else w.gap for w in windows])
    traces, usual = list[Trace](), tuple[Array, ...]()
    if lost_motion:
        traces.append(Trace(t, value, 'lost motion', 'closed', dots=True))
    else:
        for name, role, level in (
                ('baseline', 'limit', np.array([w.baseline for w in windows])),
                ('plan a service', 'warn', np.array([w.warn for w in windows])),
                ('service it', 'error', np.array([w.error for w in windows]))):
            if np.isfinite(level).sum() > 1:
                traces.append(Trace(t, level, name, role))
        std = np.array([w.gap_std for w in windows])
        traces.append(Trace(t, value, 'backlash, ± 2 sigma', 'closed', dots=True).around(std))
        if np.isfinite(std).any():  # a first, uncertain window hides no other
            usual = Trace(t, value, '', '').around(np.nanmedian(std)).band or ()
    curves = np.concatenate([value, *usual, *(trace.y for trace in traces[:-1])])
    curves = curves[np.isfinite(curves)]
    low, high = (float(curves.min()), float(curves.max())) if len(curves) else (0.0, 1.0)
    room = 0.15 * (high - low) or 0.5 * abs(high) or 1.0
    return Panel(on_axis(f'{"lost motion" if lost_motion else "backlash"} (rad)', axis),
                 traces, height=240, limits=(low - room, high + room))


def levels_chart(levels: Mapping[str, LevelSpans], time: TimeAxis) -> Chart | None:
    """Return the `levels` of components over `time`, None without any."""
    lanes = [_lane(name, spans, time.scale) for name, spans in levels.items()]
    return time.chart('Levels', lanes) if lanes else None


def _lane(name: str, spans: LevelSpans, scale: float) -> Lane:
    """Return the lane of one component with the shares of its levels."""
    shares = ', '.join(f'{level} {100 * share:.3g} %'
                       for level, share in zip(LEVELS, spans.shares()) if share)
    return Lane(f'{name}: {shares}', [begin / scale for begin in spans.begins], spans.end / scale,
                spans.levels, [f'{name} {LEVELS[level]}' for level in spans.levels])


def errors_chart(timeline: Timeline, axis: str) -> Chart | None:
    """Return innovations of `timeline` by encoder, in units of `axis`; None without any."""
    time, panels = time_axis(timeline), []
    t = timeline.errors.t / time.scale
    for k, name in enumerate(CHANNELS):
        low, high, mean = timeline.errors.of(k)
        _, _, std = timeline.errors.of(k + 2)
        count, covered = timeline.coverage[k]
        if not count:
            continue
        top = 3.0 * float(np.nanmedian(2.0 * std))
        panels.append(Panel(
            on_axis(f'{name}, rad: {100 * covered / count:.1f} % within 2 sigma', axis),
            (Trace(t, mean, 'mean, lowest, highest', 'closed', band=(low, high)),
             Trace(t, 2.0 * std, '2 sigma as stated', 'nominal firm'),
             Trace(t, -2.0 * std, '', 'nominal firm')), 0.0, 150, limits=(-top, top)))
    return time.chart('Prediction errors of the encoders', panels) if panels else None


def torque_chart(timeline: Timeline, axis: str) -> Chart:
    """Return torque, its deviation and the command of `timeline`, in units of `axis`."""
    time = time_axis(timeline)
    t = timeline.torque.t / time.scale
    low, high, mean = timeline.torque.of(0)
    _, _, std = timeline.torque.of(1)
    u_low, u_high, u_mean = timeline.torque.of(2)
    panels = []
    if np.isfinite(mean).any():
        panels.append(Panel(on_axis('through the gearbox (N m)', axis), (
            Trace(t, mean, 'mean, lowest, highest', 'closed', band=(low, high)),), 0.0))
        panels.append(Panel(on_axis('its stated deviation (N m)', axis), (
            Trace(t, std, 'deviation', 'nominal firm'),), height=90, include=(0.0,)))
    if np.isfinite(u_mean).any() or not panels:
        panels.append(Panel(on_axis('commanded (N m)', axis), (
            Trace(t, u_mean, 'commanded', 'recording', band=(u_low, u_high)),), 0.0, 120))
    return time.chart('Torque, filtered', panels)


def input_chart(timeline: Timeline) -> Chart:
    """Return the steps between the samples of `timeline`."""
    low, high, mean = (1e3 * values for values in timeline.steps.of(0))
    time = time_axis(timeline)
    return time.chart('Samples by their stamps', [Panel('step between samples (ms)', (
        Trace(timeline.steps.t / time.scale, mean, 'mean, lowest, highest', 'closed',
              band=(low, high)),), None, 110, (0.0,))])


def overview(timeline: Timeline, axis: str) -> list[Drawing | None]:
    """Return torque, loops, backlash and prediction errors of `timeline`, in units of `axis`."""
    return [torque_chart(timeline, axis), loop_plane(timeline, axis),
            backlash_chart(timeline, axis), errors_chart(timeline, axis)]


TRUST = ('observability', 'prediction error', 'covariance', 'model', 'input', LIVE_NODE)
WEAR = ('backlash', 'friction')
TRUSTED = 0.9      # share of the time below which that is the headline
LISTED = 200       # changes of level


def recording_page(timeline: Timeline, facts: RecordingFacts, name: str, bag: str) -> str:
    """
    Return the page of a recording as HTML.

    Args:
        timeline: of the recording.
        facts: model, parameters, versions and counters.
        name: of the recording.
        bag: how a command names it: its path, and the topic where it has several.

    Returns:
        One file that loads nothing.

    """
    axis = facts.model.axis
    return render_page(Page(f'Recording {name}', _summary(timeline, facts), (
        advice(next_steps(timeline, facts, bag)), _backlash(timeline, axis),
        Section('recording/loops.html', {'plane': loop_plane(timeline, axis)},
                'Torque over twist'), _trust(timeline),
        Section('recording/errors.html', {'errors': errors_chart(timeline, axis)},
                'Prediction errors'),
        Section('recording/chart.html', {'chart': torque_chart(timeline, axis)}, 'Torque'),
        _input(timeline, facts), _parameters(facts)), axis))


def figures(timeline: Timeline, facts: RecordingFacts) -> dict[str, Any]:
    """Return the figures of the page of `timeline` and `facts` as plain data; None: unknown."""
    windows = [w for w in timeline.windows if w.separable and np.isfinite(w.gap)]
    _, _, nis = timeline.nis.of(0)
    nis = nis[np.isfinite(nis)]
    return {
        'samples': timeline.samples, 'duration_s': timeline.last,
        'filter': facts.parameters.filter, 'loops': len(timeline.loops),
        'nis_over_dof': float(nis.mean()) if len(nis) else None,
        'within_2_sigma': {name: float(covered / count) if count else None
                           for name, (count, covered) in zip(CHANNELS, timeline.coverage)},
        'windows': len(timeline.windows),
        'gap_rad': [w.gap for w in windows], 'gap_std_rad': [w.gap_std for w in windows],
        'levels': {name: dict(zip(LEVELS, spans.shares()))
                   for name, spans in timeline.spans.items()},
        'alerts': [{'t': alert.t, 'component': state.component, 'level': LEVELS[state.level],
                    'message': state.message}
                   for alert in timeline.alerts for state in (alert.state,)],
        'counts': facts.counts, 'notes': facts.notes}


def raised(states: Iterable[State]) -> list[State]:
    """Return those of `states` that are no OK and were judged, the worst first."""
    return worst_first(s for s in states if s.level and s.is_judged and s.is_compared)


def is_worn(states: Sequence[State]) -> bool:
    """Return whether the worst of the raised `states` is about wear."""
    return bool(states) and states[0].component in WEAR


def headline(timeline: Timeline, facts: RecordingFacts) -> tuple[str, str]:
    """Return (sentence, 'good', 'warn', 'error' or '') about the recording of `timeline`."""
    states = raised(timeline.newest)
    if is_worn(states):
        return sentence(states[0].first), ROLES[states[0].level]
    share = trusted_share(timeline.spans)
    if share is None:
        return say('not_evaluated_at_all'), ''
    alarms = states[:1] + ([_longest_alarm(timeline)] if share < TRUSTED else [])
    if alarms:
        alarm = max(alarms, key=lambda state: state.level)
        words = alarm.message.split(': ')[0]  # advice is below
        return say('trusted_in_part' if share < TRUSTED else 'trusted_no_more',
                   percent=100 * share, alarm=words), ROLES[alarm.level]
    if not timeline.windows:
        return say('trusted_unmeasured', percent=100 * share), ''
    state = timeline.spans['backlash'].newest
    return sentence(state.first), 'good' if state.is_compared else ''


def _longest_alarm(timeline: Timeline) -> State:
    """Return the longest among the worst alarms against the estimates."""
    alarms = [(end - begin, state) for name in TRUST if name in timeline.spans
              for begin, end, state in timeline.spans[name].spans()
              if state.level and state.is_judged]
    return max(alarms, key=lambda alarm: (alarm[1].level, alarm[0]))[1]


def next_steps(timeline: Timeline, facts: RecordingFacts, bag: str) -> list[str]:
    """Return advice about a recording, see headline; `bag`: its name in commands."""
    states = raised(timeline.newest)
    if is_worn(states):  # which may cause prediction errors, too
        return [say('test_gearbox', bag=bag), say('compare_older')]
    share, codes = trusted_share(timeline.spans), []
    is_doubted = bool(states) or share is not None and share < TRUSTED
    if is_doubted or share is None or not timeline.windows:
        codes.append('list_faults')
    if is_doubted:
        if not any(row.name.startswith(('q_std_', 'r_std_')) for row in _changed(facts)):
            codes.append('tune_filter')
        codes.append('find_error')
    if not codes and timeline.spans['backlash'].newest.is_compared:
        codes = ['as_it_was']
    return [say(code, bag=bag) for code in codes or ('test_gearbox', 'save_healthy')]


def trusted_share(levels: Mapping[str, LevelSpans]) -> float | None:
    """Return the share of evaluated time of `levels` without an alarm against trust, or None."""
    spans = [levels[name] for name in TRUST if name in levels]
    edges = np.unique([t for s in spans for t in (*s.begins, s.end)])
    if len(edges) < 2:
        return None
    evaluated, alarmed = np.zeros((2, len(edges) - 1), bool)
    for s in spans:
        at = np.maximum(np.searchsorted(s.begins, edges[:-1], 'right') - 1, 0)
        valid = np.array([state.is_judged for state in s.states])[at]
        evaluated |= valid
        alarmed |= valid & (np.array(s.levels)[at] > 0)
    lengths = np.diff(edges)
    total = float(lengths[evaluated].sum())
    return float(lengths[evaluated & ~alarmed].sum()) / total if total > 0.0 else None


# ---------------------------------------------------------------------- sections


def _summary(timeline: Timeline, facts: RecordingFacts) -> Section:
    """Return headline and figures of a recording."""
    words, kind = headline(timeline, facts)
    data = figures(timeline, facts)
    items = [('from', when(timeline.first_ns or 0)), ('duration', f'{timeline.last:.4g} s'),
             ('samples', str(timeline.samples)), ('filter', data['filter'])]
    if data['nis_over_dof'] is not None:
        items.append(('NIS per reading (1 expected)', f'{data["nis_over_dof"]:.3f}'))
    if data['gap_rad']:
        items.append(('backlash, newest', str(width_of(
            data['gap_rad'][-1], data['gap_std_rad'][-1], on_axis('rad', facts.model.axis)))))
    items.append(('alerts', str(len(timeline.alerts))))
    return page_summary(kind, words, items, [*map(sentence, facts.notes)])


def _backlash(timeline: Timeline, axis: str) -> Section:
    """Return backlash, or lost motion in its place, over time, with alerts."""
    time = time_axis(timeline)
    alerts = [f'{k}, {time.text(alert.t)}: {alert.state}'
              for k, alert in enumerate(timeline.alerts, 1)]
    spans = timeline.spans.get('backlash')
    message = spans.newest.message if spans else ''
    if not timeline.windows:
        message = message or 'nothing was evaluated'
    return Section('recording/backlash.html', {
        'chart': backlash_chart(timeline, axis),
        'lost_motion': drawn_windows(timeline.windows)[1], 'alerts': alerts, 'message': message},
        'Backlash')


def _trust(timeline: Timeline) -> Section:
    """Return levels over time, and the first of all changes."""
    time = time_axis(timeline)
    levels = {name: timeline.spans[name] for name in (*TRUST, *WEAR) if name in timeline.spans}
    changes = sorted(((t, state) for spans in levels.values()
                      for t, _, state in spans.spans()), key=lambda change: change[0])
    return Section('recording/trust.html', {
        'chart': levels_chart(levels, time), 'changes': len(changes),
        'listed': [f'{time.text(t)}: {state}' for t, state in changes[:LISTED]]}, 'Trust')


def _input(timeline: Timeline, facts: RecordingFacts) -> Section:
    """Return rate and longest step of the samples; counts of what was refused or missing."""
    return Section('recording/input.html', {
        'chart': input_chart(timeline),
        'counts': PageTable(('counter', ''), [
            (name, count) for name, count in facts.counts.items() if count and name != 'starts'],
            (1,))}, 'Input', folded=True)


def _parameters(facts: RecordingFacts) -> Section:
    """Return parameters, model (JSON) and versions."""
    values = facts.parameters.to_dict()
    return Section('recording/parameters.html', {
        'changed': PageTable(('parameter', 'value', 'default', 'unit'), [
            (row.name, _value(values[row.name]), _value(row.default), row.unit)
            for row in _changed(facts)]),
        'model': json.dumps(facts.model.to_dict(), indent=1),
        'versions': PageTable(('of', 'version'), facts.versions)}, 'Parameters and versions',
        folded=True)


def _changed(facts: RecordingFacts) -> list[ParameterRow]:
    """Return the rows of the parameters that are not the default."""
    return [row for row in ESTIMATOR if getattr(facts.parameters, row.name) != row.default]


def _value(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)


WIDTH, HEIGHT, MARGIN = 120.0, 24.0, 2.0  # of a sparkline


@dataclass(frozen=True)
class JointRow:
    """
    A joint in the table.

    kind: of ROLES, '' where nothing can be said; message: why; torque: lowest and highest (N m);
    windows: measurements of its backlash; trusted: share of the time, None: not evaluated; link:
    its page; worn: whether the message is about wear.
    """

    name: str
    kind: str
    message: str
    torque: tuple[float, float]
    windows: Sequence[WindowBacklash]
    trusted: float | None
    link: str = ''
    worn: bool = False

    @property
    def level(self) -> int:
        """Number of the level, -1 where nothing can be said."""
        return ROLES.index(self.kind) if self.kind else -1

    @property
    def level_text(self) -> str:
        """The level in words; of a joint with a kind."""
        return LEVELS[self.level]

    @property
    def torque_text(self) -> str:
        """The span of the torque."""
        low, high = self.torque
        return f'{low:.3g} to {high:.3g}' if math.isfinite(low + high) else 'none'

    @property
    def gap_text(self) -> str:
        """The newest backlash; lost motion where backlash is not distinguished from it."""
        if not self.windows:
            return 'not measured'
        newest = self.windows[-1]
        if not newest.separable:
            return f'{number(newest.lost_motion)} (lost motion)'
        return str(width_of(newest.gap, newest.gap_std, ''))

    @property
    def trusted_text(self) -> str:
        """The share of trust."""
        return 'not evaluated' if self.trusted is None else f'{100 * self.trusted:.0f} %'

    @property
    def sparkline(self) -> str:
        """The path of the backlash over time, '' for fewer than two windows."""
        separable = bool(self.windows) and self.windows[-1].separable
        points = np.array([(w.t, w.gap if separable else w.lost_motion) for w in self.windows])
        points = points[np.isfinite(points).all(axis=1)] if len(points) else points
        return _path(*points.T) if len(points) > 1 else ''


def _path(t: Array, value: Array) -> str:
    """Return an SVG path of `value` [N] over `t` [N], the lowest value at the bottom."""
    x = MARGIN + (WIDTH - 2 * MARGIN) * (t - t[0]) / max(float(t[-1] - t[0]), 1e-12)
    span = float(np.ptp(value))
    share = (value - value.min()) / span if span > 0.0 else np.full(len(value), 0.5)
    y = HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * share
    return 'M' + 'L'.join(f'{a:.1f},{b:.1f}' for a, b in zip(x, y))


def worst_rows(rows: Iterable[JointRow]) -> list[JointRow]:
    """Return `rows`, worst first; at one level wear comes before doubts about the estimates."""
    return sorted(rows, key=lambda row: (
        -row.level, not row.worn, 1.0 if row.trusted is None else row.trusted))


def joint_table(rows: Sequence[JointRow]) -> Section:
    """Return the table of all joints with their `rows`, empty for a single one."""
    return Section('robot/joints.html', {'rows': rows if len(rows) > 1 else ()}, 'Joints')


def recorded_row(timeline: Timeline, facts: RecordingFacts, name: str, link: str) -> JointRow:
    """
    Return the row of a joint in a recording.

    Args:
        timeline: of the gearbox.
        facts: about it.
        name: of the gearbox.
        link: to its page.

    """
    words, kind = headline(timeline, facts)
    low, high, _ = timeline.torque.of(0)
    span = (float(np.nanmin(low)), float(np.nanmax(high))) if np.isfinite(low).any() else (
        math.nan, math.nan)
    return JointRow(name, kind, words, span, timeline.windows, trusted_share(timeline.spans),
                    link, is_worn(raised(timeline.newest)))


def _robot_summary(joints: Mapping[str, tuple[Timeline, RecordingFacts]], rows: Sequence[JointRow]
                   ) -> Section:
    """Return the summary of `joints`, whose `rows` begin with the worst."""
    highest, raised = rows[0], [f'{row.name}: {row.message}' for row in rows if row.level > 0]
    text = (answer(raised, (), JOINTS) if raised else 'Nothing is raised.'
            if {row.kind for row in rows} == {'good'} else highest.message)
    timelines = [timeline for timeline, _ in joints.values()]
    return page_summary(
        '' if highest.kind == 'good' and rows[-1].kind != 'good' else highest.kind, text,
        [('from', when(timelines[0].first_ns or 0)),
         ('duration', f'{max(t.last for t in timelines):.4g} s'), ('joints', str(len(joints))),
         ('alerts', str(sum(len(t.alerts) for t in timelines)))],
        list(dict.fromkeys(sentence(note) for _, facts in joints.values()
                           for note in facts.notes)))


def robot_page(joints: Mapping[str, tuple[Timeline, RecordingFacts]], links: Mapping[str, str],
               name: str, bags: Mapping[str, str]) -> tuple[str, str]:
    """
    Return the page of a recording of several gearboxes.

    Args:
        joints: {gearbox: its timeline, facts about it}.
        links: {gearbox: its own page, relative}.
        name: of the recording.
        bags: {gearbox: how a command names its recording}.

    Returns:
        One file that loads nothing and links to the pages of the joints, and its headline.

    """
    rows = worst_rows(recorded_row(timeline, facts, joint, links[joint])
                      for joint, (timeline, facts) in joints.items())
    summary, highest = _robot_summary(joints, rows), rows[0].name
    timeline, facts = joints[highest]
    steps = advice([f'{highest}: {step}' for step in next_steps(timeline, facts, bags[highest])])
    return render_page(Page(f'Robot {name}', summary, (steps, joint_table(rows)),
                            facts.model.axis)), summary.data['headline']
