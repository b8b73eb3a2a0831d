# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a recording: loop, backlash, prediction errors, trust, input, parameters."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
from typing import Any

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.monitoring.alert_limits import LIMITS
from gearbox_monitor.monitoring.backlash.forecast import when
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report.builder import Page, render_page, Section
from gearbox_monitor.report.figures import (
    chart, ChartView, Lane, loop_plane, LoopSlice, Mark, PageTable, Panel, PlaneView, Trace)
from gearbox_monitor.report.shared_sections import NextSteps, PageSummary
from gearbox_monitor.report.timeline import LEVELS, LevelSpans, Loop, Timeline, WindowBacklash
from gearbox_monitor.report.timeline_source import RecordingFacts
from gearbox_monitor.report.words import number, width_and_std

TRUST = ('observability', 'prediction error', 'covariance', 'model', 'input')
WEAR = ('backlash', 'friction')
NO_DATA = 'no data'  # so begins the message of a component that was never evaluated
TRUSTED = 0.9      # share of the time below which that is the headline
MINUTES = 600.0    # s: longer recordings are shown in minutes
LISTED = 200       # changes of level
COARSE = 400       # points of the line of the prediction errors
CHANNELS = ('motor', 'arm')
ROLES = ('good', 'warn', 'error')  # of alerts and of the headline, by level
GROUP = 'time'


def recording_page(timeline: Timeline, facts: RecordingFacts, name: str, bag: str) -> str:
    """
    Return the page of a recording as HTML.

    Args:
        timeline: what the recording showed.
        facts: model, parameters, versions and counters beside it.
        name: of the recording.
        bag: how a command names it: its path, and the topic where it has several.

    Returns:
        One file that loads nothing.

    """
    axis = facts.model.axis
    scale, unit = (60.0, 'min') if timeline.last > MINUTES else (1.0, 's')
    time = TimeAxis(max(timeline.last / scale, 1e-9), scale, unit)
    return render_page(Page(f'Recording {name}', RecordingSummary.of(timeline, facts), (
        NextSteps(next_steps(timeline, bag)), TorqueOverTwist.of(timeline, axis),
        BacklashHistory.of(timeline, time, axis), TrustLevels.of(timeline, time),
        PredictionErrors.of(timeline, time, axis),
        TorqueHistory.of(timeline, time, axis), InputQuality.of(timeline, facts, time),
        ParametersUsed.of(facts)), axis))


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
              marks: Sequence[Mark] = ()) -> ChartView:
        """
        Return a chart on this axis; all of them zoom together.

        Args:
            title: plain text above the chart.
            panels: from top to bottom.
            marks: moments drawn through all panels.

        """
        return chart(title, panels, f'time ({self.unit})', f't ({self.unit})', marks=marks,
                     group=GROUP, span=(0.0, self.last))


def figures(timeline: Timeline, facts: RecordingFacts) -> dict[str, Any]:
    """Return the figures of the page of `timeline` and `facts` as plain data; None: unknown."""
    windows = [w for w in timeline.windows if w.separable and np.isfinite(w.gap)]
    _, _, nis = timeline.nis.of(0)
    nis = nis[np.isfinite(nis)]
    return {
        'samples': timeline.samples, 'duration_s': timeline.last, 'live': facts.live,
        'filter': facts.parameters.filter, 'loops': len(timeline.loops),
        'nis_over_dof': float(nis.mean()) if len(nis) else None,
        'within_2_sigma': {name: float(covered / count) if count else None
                           for name, (count, covered) in zip(CHANNELS, timeline.coverage)},
        'windows': len(timeline.windows),
        'gap_rad': [w.gap for w in windows], 'gap_std_rad': [w.gap_std for w in windows],
        'levels': {name: dict(zip(LEVELS, spans.shares()))
                   for name, spans in timeline.spans.items()},
        'alerts': [{'t': a.t, 'component': a.component, 'level': LEVELS[a.level],
                    'message': a.message} for a in timeline.alerts],
        'counts': facts.counts, 'notes': facts.notes}


def wear(timeline: Timeline) -> list[tuple[int, str]]:
    """Return [(level, message)] of the wear that `timeline` shows at its end."""
    return [(s.levels[-1], s.messages[-1]) for name, s in timeline.spans.items()
            if name in WEAR and s.levels[-1] and not s.messages[-1].startswith(NO_DATA)
            and 'not measured' not in s.messages[-1]]


def headline(timeline: Timeline) -> tuple[str, str]:
    """Return (sentence, 'good', 'warn', 'error' or '') about the recording of `timeline`."""
    worn = wear(timeline)
    if worn:
        message = max(worn)[1].split(' (for ')[0]
        return f'{message[0].upper()}{message[1:]}.', ROLES[max(worn)[0]]
    share = trusted_share(timeline.spans)
    if share is None:
        return ('Nothing was evaluated: the recording is too short, or contains no estimates.',
                '')
    if share < TRUSTED:
        level, message = _longest_alarm(timeline)
        return (f'The estimates were trusted {100 * share:.0f} % of the time: '
                f'{message}.'), ROLES[level]
    if not timeline.windows:
        return f'Trusted {100 * share:.0f} % of the time; backlash was not measured.', ''
    return f'No growth of the backlash; trusted {100 * share:.0f} % of the time.', 'good'


def _longest_alarm(timeline: Timeline) -> tuple[int, str]:
    """Return level and message of the longest among the worst alarms against the estimates."""
    alarms = [(level, end - begin, message) for name in TRUST if name in timeline.spans
              for s in (timeline.spans[name],) for begin, end, level, message in zip(
                  s.begins, (*s.begins[1:], s.end), s.levels, s.messages)
              if level and not message.startswith(NO_DATA)]
    level, _, message = max(alarms)
    return level, message.split(': ')[0].split(' (for ')[0]  # the advice stands in the section


def next_steps(timeline: Timeline, bag: str) -> list[str]:
    """Return advice about the recording of `timeline`, which commands call `bag`."""
    if wear(timeline):  # which may cause prediction errors, too
        return [f'Test the gearbox against its specification: gearbox_monitor accept {bag} '
                '--max-gap ANGLE',
                'Compare with its older recordings: gearbox_monitor fleet FOLDER --out DIR']
    share, steps = trusted_share(timeline.spans), []
    if share is None or share < TRUSTED or not timeline.windows:
        steps.append(f'See what the recording lacks: gearbox_monitor check {bag} --model FILE')
    if share is not None and share < TRUSTED:
        steps.append(f'Identify what the model lacks: gearbox_monitor diagnose {bag} --model FILE')
    return steps or ['Save this state as the healthy one (service ~/save_baseline of the node), '
                     'and compare later recordings with it: gearbox_monitor fleet FOLDER --out '
                     'DIR']


def trusted_share(levels: Mapping[str, LevelSpans]) -> float | None:
    """Return the share of evaluated time of `levels` without an alarm against trust, or None."""
    spans = [levels[name] for name in TRUST if name in levels]
    edges = np.unique([t for s in spans for t in (*s.begins, s.end)])
    if len(edges) < 2:
        return None
    evaluated, alarmed = np.zeros((2, len(edges) - 1), bool)
    for s in spans:
        at = np.maximum(np.searchsorted(s.begins, edges[:-1], 'right') - 1, 0)
        valid = ~np.array([message.startswith(NO_DATA) for message in s.messages])[at]
        evaluated |= valid
        alarmed |= valid & (np.array(s.levels)[at] > 0)
    lengths = np.diff(edges)
    total = float(lengths[evaluated].sum())
    return float(lengths[evaluated & ~alarmed].sum()) / total if total > 0.0 else None


# ---------------------------------------------------------------------- sections


@dataclass(frozen=True)
class RecordingSummary(PageSummary):
    """Headline and figures of a recording; live: whether its own estimates are shown."""

    template = 'recording/summary.html'
    live: bool = False

    @classmethod
    def of(cls, timeline: Timeline, facts: RecordingFacts) -> 'RecordingSummary':
        """Return it for `timeline` and `facts`."""
        words, kind = headline(timeline)
        data = figures(timeline, facts)
        items = [('from', when(timeline.first_ns or 0)), ('duration', f'{timeline.last:.4g} s'),
                 ('samples', str(timeline.samples)), ('filter', data['filter'])]
        if data['nis_over_dof'] is not None:
            items.append(('NIS per reading (1 expected)', f'{data["nis_over_dof"]:.3f}'))
        if data['gap_rad']:
            items.append(('backlash, newest', width_and_std(
                data['gap_rad'][-1], data['gap_std_rad'][-1], on_axis('rad', facts.model.axis))))
        items.append(('alerts', str(len(timeline.alerts))))
        return cls(kind, words, items, facts.notes, facts.live)


@dataclass(frozen=True)
class TorqueOverTwist(Section):
    """Hysteresis loops by slices of time; None: the twist was not measured."""

    heading = 'Torque over twist'
    template = 'recording/loops.html'
    plane: PlaneView | None

    @classmethod
    def of(cls, timeline: Timeline, axis: str) -> 'TorqueOverTwist':
        """Return it for the loops of `timeline`, in the units of `axis`."""
        if not timeline.loops:
            return cls(None)
        minutes = timeline.slice_seconds >= 60.0
        slices = [LoopSlice(_interval(loop, minutes), loop.cloud, (loop.up, loop.down))
                  for loop in timeline.loops]
        length = 'minute' if timeline.slice_seconds == 60.0 else f'{timeline.slice_seconds:g} s'
        return cls(loop_plane(f'One loop per {length}', slices,
                              on_axis('twist, motor - arm (rad)', axis),
                              on_axis('torque (N m)', axis)))


def _interval(loop: Loop, minutes: bool) -> str:
    """Return begin and end of `loop` in words."""
    scale, unit = (60.0, 'min') if minutes else (1.0, 's')
    return f'{loop.begin / scale:.0f} to {np.ceil(loop.end / scale):.0f} {unit}'


@dataclass(frozen=True)
class BacklashHistory(Section):
    """
    Backlash, or lost motion in its place, over time, with alerts.

    chart: None without measurements; message: newest outcome on backlash, '' without one.
    """

    heading = 'Backlash'
    template = 'recording/backlash.html'
    chart: ChartView | None
    lost_motion: bool
    alerts: Sequence[str]
    message: str

    @classmethod
    def of(cls, timeline: Timeline, time: TimeAxis, axis: str) -> 'BacklashHistory':
        """
        Return the history of the backlash.

        Args:
            timeline: its windows and alerts.
            time: axis of the chart.
            axis: of the drive, for units.

        """
        alerts = [f'{k}, {time.text(alert.t)}: {alert.component} {LEVELS[alert.level]}: '
                  f'{alert.message}' for k, alert in enumerate(timeline.alerts, 1)]
        spans = timeline.spans.get('backlash')
        message = spans.messages[-1] if spans and spans.messages else ''
        if not timeline.windows:
            return cls(None, False, alerts, message or 'nothing was evaluated')
        windows, lost_motion = drawn_windows(timeline.windows)
        marks = [Mark(alert.t / time.scale, str(k), ROLES[alert.level])
                 for k, alert in enumerate(timeline.alerts, 1)]
        panel = backlash_panel(windows, lost_motion, time.scale, axis)
        return cls(time.chart('Lost motion' if lost_motion else 'Backlash', [panel], marks),
                   lost_motion, alerts, message)


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
        lost_motion: whether it stands for backlash.
        scale: s per unit of the time axis.
        axis: of the drive, for units.

    """
    t = np.array([w.t for w in windows]) / scale
    value = np.array([w.lost_motion if lost_motion else w.gap for w in windows])
    traces = []
    if lost_motion:
        traces.append(Trace(t, value, 'lost motion', 'closed', dots=True))
    else:
        for name, role, level in (
                ('baseline', 'limit', np.array([w.baseline for w in windows])),
                ('plan a service', 'warn', np.array([w.warn for w in windows])),
                ('service it', 'error', np.array([w.error for w in windows]))):
            if np.isfinite(level).any():
                traces.append(Trace(t, level, name, role))
        std = np.array([w.gap_std for w in windows])
        traces.append(Trace(t, value, 'backlash, ± 2 sigma', 'closed', dots=True,
                            band=(value - 2.0 * std, value + 2.0 * std)))
    curves = np.concatenate([value, *(trace.y for trace in traces[:-1])])
    if not lost_motion and np.isfinite(std).any():  # a first, uncertain window hides no other
        curves = np.concatenate([curves, value - 2.0 * np.nanmedian(std),
                                 value + 2.0 * np.nanmedian(std)])
    curves = curves[np.isfinite(curves)]
    low, high = (float(curves.min()), float(curves.max())) if len(curves) else (0.0, 1.0)
    room = 0.15 * (high - low) or 0.5 * abs(high) or 1.0
    return Panel(on_axis(f'{"lost motion" if lost_motion else "backlash"} (rad)', axis), traces,
                 height=240, limits=(low - room, high + room))


@dataclass(frozen=True)
class TrustLevels(Section):
    """Levels over time; chart: None if nothing was evaluated; listed: the first of all changes."""

    heading = 'Trust'
    template = 'recording/trust.html'
    chart: ChartView | None
    listed: Sequence[str]
    changes: int

    @classmethod
    def of(cls, timeline: Timeline, time: TimeAxis) -> 'TrustLevels':
        """Return it for the levels of `timeline` on the axis `time`."""
        names = [name for name in (*TRUST, *WEAR) if name in timeline.spans]
        if not names:
            return cls(None, (), 0)
        lanes, changes = [], []
        for name in names:
            spans = timeline.spans[name]
            lanes.append(_lane(name, spans, time.scale))
            changes += [(t, name, level, message) for t, level, message in zip(
                spans.begins, spans.levels, spans.messages)]
        changes.sort(key=lambda change: change[0])
        listed = [f'{time.text(t)}: {name} {LEVELS[level]}: {message}'
                  for t, name, level, message in changes[:LISTED]]
        return cls(time.chart('Levels', lanes), listed, len(changes))


def _lane(name: str, spans: LevelSpans, scale: float) -> Lane:
    """Return the lane of one component with the shares of its levels."""
    shares = ', '.join(f'{level} {100 * share:.3g} %'
                       for level, share in zip(LEVELS, spans.shares()) if share)
    return Lane(f'{name}: {shares}', [begin / scale for begin in spans.begins], spans.end / scale,
                spans.levels, [f'{name} {LEVELS[level]}' for level in spans.levels])


@dataclass(frozen=True)
class PredictionErrors(Section):
    """Innovations of the encoders and their NIS; both None without estimates."""

    heading = 'Prediction errors'
    template = 'recording/errors.html'
    errors: ChartView | None
    nis: ChartView | None

    @classmethod
    def of(cls, timeline: Timeline, time: TimeAxis, axis: str) -> 'PredictionErrors':
        """
        Return the prediction errors.

        Args:
            timeline: its envelopes of innovations and NIS.
            time: axis of the charts.
            axis: of the drive, for units.

        """
        t = timeline.errors.t / time.scale
        if not len(t):
            return cls(None, None)
        panels = []
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
        return cls(time.chart('Prediction errors of the encoders', panels),
                   _nis_chart(timeline, time))


def _nis_chart(timeline: Timeline, time: TimeAxis) -> ChartView | None:
    """Return the chart of the NIS with the limits of its alarm, or None without any."""
    _, _, nis = timeline.nis.of(0)
    finite = np.isfinite(nis)  # once per second if it comes from diagnostics
    if not finite.any():
        return None
    edges = np.array([0.0, time.last])
    t, nis = _coarser(timeline.nis.t[finite] / time.scale, nis[finite])
    top = max(1.6, min(4.0, float(np.nanpercentile(nis, 99)) * 1.2))
    return time.chart('Size of the prediction errors: NIS over its degrees of freedom', [
        Panel('1 is expected', (
            Trace(edges, np.full(2, LIMITS.nis_high), 'limits of the alarm', 'warn'),
            Trace(edges, np.full(2, LIMITS.nis_low), '', 'warn'),
            Trace(t, nis, 'NIS', 'closed')), 1.0, 140, limits=(0.0, top))])


def _coarser(t: Array, values: Array) -> tuple[Array, Array]:
    """Return means of neighbours of `t` and `values`, no more than COARSE."""
    size = -(-len(t) // COARSE)
    count = len(t) // size
    return (t[:count * size].reshape(count, size).mean(axis=1),
            values[:count * size].reshape(count, size).mean(axis=1))


@dataclass(frozen=True)
class TorqueHistory(Section):
    """Torque through the gearbox, its stated deviation, and the commanded torque."""

    heading = 'Torque'
    template = 'recording/chart.html'
    chart: ChartView

    @classmethod
    def of(cls, timeline: Timeline, time: TimeAxis, axis: str) -> 'TorqueHistory':
        """
        Return the history of the torque.

        Args:
            timeline: its envelopes of torques.
            time: axis of the chart.
            axis: of the drive, for units.

        """
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
        panels.append(Panel(on_axis('commanded (N m)', axis), (
            Trace(t, u_mean, 'commanded', 'recording', band=(u_low, u_high)),), 0.0, 120))
        return cls(time.chart('Torque, filtered', panels))


@dataclass(frozen=True)
class InputQuality(Section):
    """Rate and longest step of the samples; counts of what was refused or missing."""

    heading = 'Input'
    template = 'recording/input.html'
    chart: ChartView
    counts: PageTable

    @classmethod
    def of(cls, timeline: Timeline, facts: RecordingFacts, time: TimeAxis) -> 'InputQuality':
        """
        Return the quality of the input.

        Args:
            timeline: its rates.
            facts: its counters.
            time: axis of the chart.

        """
        t, rate, step = timeline.rates()
        panels = [
            Panel('samples/s', (Trace(t / time.scale, rate, 'rate', 'closed'),), None, 110,
                  (0.0,)),
            Panel('longest step (ms)', (
                Trace(t / time.scale, 1e3 * step, 'longest step between stamps',
                      'nominal firm'),), None, 110, (0.0,))]
        return cls(time.chart('Samples by their stamps', panels), PageTable(('counter', ''), [
            (name, count) for name, count in facts.counts.items() if count and name != 'starts'],
            (1,)))


@dataclass(frozen=True)
class ParametersUsed(Section):
    """Parameters, model (JSON) and versions."""

    heading = 'Parameters and versions'
    template = 'recording/parameters.html'
    changed: PageTable
    parameters: PageTable
    model: str
    versions: PageTable

    @classmethod
    def of(cls, facts: RecordingFacts) -> 'ParametersUsed':
        """Return it for `facts`."""
        values = facts.parameters.to_dict()
        return cls(
            PageTable(('parameter', 'value', 'default', 'unit'), [
                (row.name, _value(values[row.name]), _value(row.default), row.unit)
                for row in ESTIMATOR if getattr(facts.parameters, row.name) != row.default]),
            PageTable(('parameter', 'value', 'unit', 'description'), [
                (row.name, _value(values[row.name]), row.unit, row.description)
                for row in ESTIMATOR]),
            json.dumps(facts.model.to_dict(), indent=1),
            PageTable(('of', 'version'), facts.versions))


def _value(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)
