# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The charts of a recording, from its time line: loops, backlash, levels, errors, torque."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.chart import (
    Chart, Drawing, Lane, LoopSlice, Mark, Panel, Plane, Trace)
from gearbox_monitor.report.timeline import (
    LEVELS, LevelSpans, Loop, Timeline, WindowBacklash)

MINUTES = 600.0    # s: longer recordings are shown in minutes
COARSE = 400       # points of the line of the prediction errors
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


def nis_chart(timeline: Timeline) -> Chart | None:
    """Return the NIS of `timeline` with the limits of its alarm, or None without any."""
    _, _, nis = timeline.nis.of(0)
    finite = np.isfinite(nis)
    if not finite.any():
        return None
    time = time_axis(timeline)
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


# ---------------------------------------------------------------------- pictures


def overview(timeline: Timeline, axis: str = 'rotary') -> list[list[Drawing]]:
    """
    Return the charts of a picture, row by row: loop and backlash, torque, prediction errors.

    Args:
        timeline: of the recording.
        axis: of the drive, for units.

    """
    rows: list[list[Drawing | None]] = [
        [loop_plane(timeline, axis), backlash_chart(timeline, axis)],
        [torque_chart(timeline, axis), errors_chart(timeline, axis)]]
    return [row for row in ([part for part in row if part] for row in rows) if row]
