# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Geometry of the charts of a page: curves become SVG paths in the units of their panel.

Functions are pure and return views, plain data by the names by which templates/figures.html draws
them; nothing here is HTML.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import json
import math
from typing import Any, TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers

Span: TypeAlias = tuple[float, float]  # (low, high)
View: TypeAlias = Mapping[str, Any]  # {name in templates/figures.html: value}
Place = TypeVar('Place', float, Array)
UNITS = 10000      # width and height of a panel's view box
PLANE = 420        # height of a plane in pixels
MAX_POINTS = 4000  # of a curve
LANE_HEIGHT = 22
CLOUD_PERCENTILES = (0.2, 99.8)  # range of a cloud that is in view
LEVEL_HEIGHTS = (0.25, 0.6, 1.0)  # of a lane, by level
# Cividis in nine steps: dark to bright for colour-blind eyes, too.
CIVIDIS = ((0, 34, 78), (18, 53, 112), (59, 73, 108), (87, 93, 109), (112, 113, 115),
           (138, 134, 120), (165, 156, 116), (195, 179, 105), (254, 232, 56))


@dataclass(frozen=True)
class Trace:
    """
    One curve: x [N], y [N] (NaN: no point), its name, and its role, which sets the colour.

    role: recording, nominal, closed, signal, warn, error or limit. step: x [N + 1] are edges of y
    [N]. band: (low [N], high [N]) drawn around it, NaN: no band, or None. dots: separate points.
    """

    x: Array
    y: Array
    name: str
    role: str
    step: bool = False
    band: tuple[Array, Array] | None = None
    dots: bool = False

    @property
    def style(self) -> str:
        """Class of its path."""
        return f'{self.role} dots' if self.dots else self.role


@dataclass(frozen=True)
class Panel:
    """
    Traces on one axis.

    level: y of a dotted line, or None; height in pixels; include: values that are always in view;
    limits: (low, high) of the y axis, whatever lies beyond; None: everything is in view.
    """

    label: str
    traces: Sequence[Trace]
    level: float | None = None
    height: int = 170
    include: Sequence[float] = ()
    limits: Span | None = None


@dataclass(frozen=True)
class Lane:
    """
    Levels in force over time, as a bar on the x axis: higher is worse.

    begins [K], end of the last one; levels [K]: 0 fine, 1 warning, 2 error; words: [K] of each.
    """

    label: str
    begins: Sequence[float]
    end: float
    levels: Sequence[int]
    words: Sequence[str]


@dataclass(frozen=True)
class Mark:
    """A moment on the x axis: x, its label (short) and its role: good, warn or error."""

    x: float
    label: str
    role: str = 'error'


@dataclass(frozen=True)
class LoopSlice:
    """
    Curves of one slice of time in a loop plane: its name, and x, y of points and of lines.

    cloud ([P], [P]); lines (([N], [N]), ...).
    """

    name: str
    cloud: tuple[Array, Array]
    lines: Sequence[tuple[Array, Array]]


# ---------------------------------------------------------------------- axes


@dataclass(frozen=True)
class Tick:
    """A labelled place on an axis, in percent of its length."""

    percent: float
    text: str


@dataclass(frozen=True)
class Axis:
    """Maps values between low and high to the units of a view box."""

    low: float
    high: float

    def share(self, value: float) -> float:
        """Return the place of `value` along the axis, 0 to 1."""
        return (value - self.low) / (self.high - self.low)

    def right(self, value: Place) -> Place:
        """Return the place of `value`, or of values [N], in units, growing to the right."""
        return UNITS * (value - self.low) / (self.high - self.low)

    def down(self, value: Place) -> Place:
        """Return the place of `value`, or of values [N], in units from above, as SVG counts y."""
        return UNITS * (self.high - value) / (self.high - self.low)

    def ticks(self, count: int = 5) -> list[tuple[float, str]]:
        """Return about `count` round values with their texts."""
        step = _tick_step(self.low, self.high, count)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        digits = max(0, -math.floor(math.log10(step) + 1e-9))
        return [(k * step, f'{k * step:.{digits}f}') for k in range(first, last + 1)]

    def to_the_right(self) -> list[Tick]:
        """Return the ticks of an x axis."""
        return [Tick(100.0 * self.share(value), text) for value, text in self.ticks()]


def _tick_step(low: float, high: float, count: int) -> float:
    """Return 1, 2 or 5 times a power of ten: about `count` of them from `low` to `high`."""
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= 0.75 * raw)


def round_span(values: Array) -> Span:
    """Return round ends around `values` [N], which stay while the values change a little."""
    axis = range_of(values)
    step = _tick_step(axis.low, axis.high, 4)
    return math.floor(axis.low / step) * step, math.ceil(axis.high / step) * step


def range_of(values: Array) -> Axis:
    """Return the Axis around `values` [N] with room at both ends; 0 to 1 if none is finite."""
    values = values[np.isfinite(values)]
    if not len(values):
        return Axis(0.0, 1.0)
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 0.5 * abs(high) or 0.5
    return Axis(low - room, high + room)


def _panel_axis(panel: Panel) -> Axis:
    """Return the y axis of a Panel, with room around its curves."""
    if panel.limits is not None:
        return Axis(*panel.limits)
    curves = [np.asarray(v, float) for trace in panel.traces
              for v in (trace.y, *(trace.band or ()))]
    level = () if panel.level is None else (panel.level,)
    return range_of(np.concatenate([*curves, level, panel.include]))


# ---------------------------------------------------------------------- charts


def chart(title: str, panels: Sequence[Panel | Lane], x_label: str, unit: str, zoom: bool = True,
          marks: Sequence[Mark] = (), group: str = '', span: Span | None = None) -> View:
    """
    Return Panels and Lanes above each other on one x axis.

    Args:
        title: plain text above the chart.
        panels: from top to bottom.
        x_label: label of the x axis.
        unit: name of x in the readout under the pointer, as "t (s)".
        zoom: whether the chart has buttons to zoom.
        marks: moments drawn through all panels.
        group: charts of one group zoom together.
        span: (first, last) of x; None: as far as the curves go.

    Returns:
        The view that templates/figures.html draws.

    """
    traces = [trace for panel in panels if isinstance(panel, Panel) for trace in panel.traces]
    legend: dict[str, Trace] = {}
    for trace in traces:
        if trace.name:
            legend.setdefault(trace.name, trace)
    if span is None:
        span = min(trace.x[0] for trace in traces), max(trace.x[-1] for trace in traces)
    first, last = float(span[0]), float(span[1])
    axis = Axis(first, last if last > first else first + 1.0)
    return {
        'title': title, 'x_label': x_label, 'unit': unit, 'group': group, 'zoom': zoom,
        'panels': [_panel(panel, axis) if isinstance(panel, Panel) else _lane(panel, axis)
                   for panel in panels],
        'legend': legend.values(),
        'marks': [{'percent': 100.0 * axis.share(mark.x), 'x': f'{mark.x:.9g}',
                   'label': mark.label, 'role': mark.role,
                   'd': f'M{axis.right(mark.x):.0f} 0V{UNITS}'} for mark in marks],
        'ticks': axis.to_the_right(), 'first': f'{axis.low:.9g}', 'last': f'{axis.high:.9g}',
        'vertical': ''.join(f'M{axis.right(value):.0f} 0V{UNITS}' for value, _ in axis.ticks())}


def _lane(lane: Lane, axis: Axis) -> View:
    """Return the view of one Lane; colour and height say the same."""
    ends = (*lane.begins[1:], lane.end)
    paths = ['', '', '']
    for begin, end, level in zip(lane.begins, ends, lane.levels):
        low, high = (UNITS * (0.5 + side * 0.5 * LEVEL_HEIGHTS[level]) for side in (-1, 1))
        paths[level] += (f'M{axis.right(begin):.0f} {low:.0f}H{axis.right(end):.0f}'
                         f'V{high:.0f}H{axis.right(begin):.0f}Z')
    spans = json.dumps([[float(f'{b:.6g}'), w] for b, w in zip(lane.begins, lane.words)])
    return {
        'label': lane.label, 'height': LANE_HEIGHT, 'low': '0', 'high': '1', 'ticks': (),
        'paths': [{'style': f'lane level{level}', 'd': path, 'name': ''}
                  for level, path in enumerate(paths) if path],
        'horizontal': '', 'level': '', 'spans': spans, 'end': f'{lane.end:.6g}'}


def _panel(panel: Panel, axis: Axis) -> View:
    """Return the view of one Panel."""
    y = _panel_axis(panel)
    y_ticks = y.ticks(max(4, panel.height // 36))
    paths = []
    for trace in panel.traces:
        area = '' if trace.band is None else _band(trace.x, trace.band, axis, y)
        if area:
            paths.append({'style': f'band {trace.role}', 'd': area, 'name': ''})
        paths.append({'style': trace.style, 'd': _path(trace, axis, y), 'name': trace.name})
    return {
        'label': panel.label, 'height': panel.height, 'low': f'{y.low:.9g}',
        'high': f'{y.high:.9g}', 'paths': paths, 'spans': '', 'end': '',
        'ticks': _below_label(y, y_ticks, panel.height),
        'horizontal': ''.join(f'M0 {y.down(value):.0f}H{UNITS}' for value, _ in y_ticks),
        'level': '' if panel.level is None else f'M0 {y.down(panel.level):.0f}H{UNITS}'}


def _below_label(axis: Axis, y_ticks: Sequence[tuple[float, str]], height: int) -> list[Tick]:
    """Return the ticks of a y axis, `height` pixels high, but those that would hit its label."""
    return [Tick(100.0 * axis.down(value) / UNITS, text) for value, text in y_ticks
            if axis.down(value) / UNITS * height > 6.0]


def thinned(x: Array, y: Array, limit: int = MAX_POINTS) -> tuple[Array, Array]:
    """
    Return a curve with fewer points; its extremes stay.

    Args:
        x: [N], ascending.
        y: [N]; values that are not finite count as 0 in the search for extremes.
        limit: about so many points are returned.

    Returns:
        x and y of lowest and highest point of each of `limit` / 2 stretches, and of both ends.

    """
    at = thinned_rows(y, limit)
    return x[at], y[at]


def thinned_rows(y: Array, limit: int) -> Integers:
    """Return the rows of `y` [N] that `thinned` keeps with `limit`, ascending."""
    if len(y) <= limit:
        return np.arange(len(y))
    size = -(-2 * len(y) // limit)
    count = len(y) // size
    part = y[:count * size].reshape(count, size)
    part = np.where(np.isfinite(part), part, 0.0)
    at = np.sort(np.stack([part.argmin(axis=1), part.argmax(axis=1)], axis=1), axis=1)
    at = (at + np.arange(count)[:, None] * size).ravel()
    return np.unique(np.concatenate([[0], at, [len(y) - 1]]))


def _path(trace: Trace, axis: Axis, y_axis: Axis) -> str:
    """Return the d of an SVG path; it breaks where y is NaN."""
    xs, ys = np.asarray(trace.x, float), np.asarray(trace.y, float)
    if trace.step:
        xs, ys = np.repeat(xs, 2)[1:-1], np.repeat(ys, 2)
    xs, ys = thinned(xs, ys)
    return _drawn(axis.right(xs), y_axis.down(ys), trace.dots)


def _drawn(xs: Array, ys: Array, dots: bool) -> str:
    """Return the d through `xs`, `ys` [N] in units, `dots` or a line that breaks at NaN."""
    out, pen = [], 'M'
    for a, b in zip(xs, ys):
        if not math.isfinite(a + b):
            pen = 'M'
            continue
        out.append(f'{pen}{a:.0f} {b:.0f}{"h0" if dots else ""}')
        pen = 'M' if dots else 'L'
    return ''.join(out)


def _band(x: Array, band: tuple[Array, Array], axis: Axis, y_axis: Axis) -> str:
    """Return the d of the area between the curves of `band`; it breaks where one is NaN."""
    xs = axis.right(np.asarray(x, float))
    low, high = (y_axis.down(np.asarray(v, float)) for v in band)
    finite = np.isfinite(low) & np.isfinite(high)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], finite, [False]])))
    path = ''
    for begin, end in zip(edges[::2], edges[1::2]):
        upper = [f'{a:.0f} {b:.0f}' for a, b in zip(xs[begin:end], high[begin:end])]
        lower = [f'{a:.0f} {b:.0f}' for a, b in zip(xs[begin:end][::-1], low[begin:end][::-1])]
        path += f'M{"L".join(upper + lower)}Z'
    return path


# ---------------------------------------------------------------------- planes


def loop_plane(title: str, slices: Sequence[LoopSlice], x_label: str, y_label: str,
               limits: tuple[Span, Span] | None = None) -> View:
    """
    Return slices of time over each other in one plane; both axes can be zoomed.

    Args:
        title: plain text above the plane.
        slices: earliest first; colours go with their order.
        x_label: label of the x axis.
        y_label: label of the y axis.
        limits: (low, high) of both axes; None: the clouds are in view.

    Returns:
        The view that templates/figures.html draws.

    """
    x_axis, y_axis = (Axis(*span) for span in limits) if limits else (
        range_of(np.concatenate([np.percentile(s.cloud[k], CLOUD_PERCENTILES) for s in slices]))
        for k in (0, 1))

    def path(x: Array, y: Array, dots: bool) -> str:
        """Return the d of a line through `x`, `y`, or of a cloud of `dots`."""
        return _drawn(x_axis.right(x), y_axis.down(y), dots)
    views = [{'age': k / max(len(slices) - 1, 1), 'name': s.name,
              'cloud': path(*s.cloud, dots=True),
              'lines': ''.join(path(*line, dots=False) for line in s.lines)}
             for k, s in enumerate(slices)]
    y_ticks = y_axis.ticks(PLANE // 48)
    lattice = ''.join(f'M{x_axis.right(value):.0f} 0V{UNITS}' for value, _ in x_axis.ticks())
    lattice += ''.join(f'M0 {y_axis.down(value):.0f}H{UNITS}' for value, _ in y_ticks)
    return {
        'title': title, 'slices': views, 'x_low': f'{x_axis.low:.9g}',
        'x_high': f'{x_axis.high:.9g}', 'y_low': f'{y_axis.low:.9g}',
        'y_high': f'{y_axis.high:.9g}', 'x_ticks': x_axis.to_the_right(),
        'y_ticks': _below_label(y_axis, y_ticks, PLANE), 'lattice': lattice, 'x_label': x_label,
        'y_label': y_label, 'height': PLANE}


def heat_maps(title: str, planes: Sequence[tuple[str, Array]], x: tuple[Array, str],
              y: tuple[Array, str], unit: str) -> View:
    """
    Return planes side by side, with colours on one logarithmic scale.

    Args:
        title: plain text above them.
        planes: (name, values [Y, X]) of each; values are 1 and above, NaN stays empty.
        x: edges of the columns [X + 1], and what they are of.
        y: edges of the rows [Y + 1], and what they are of.
        unit: words behind the largest value of the scale.

    Returns:
        The view that templates/figures.html draws.

    """
    finite = [values[np.isfinite(values)] for _, values in planes]
    top = max((float(values.max()) for values in finite if len(values)), default=2.0)
    top = max(top, 2.0)
    maps = []
    for name, values in planes:
        rows, columns = values.shape
        width, height = UNITS / columns, UNITS / rows
        cells = [{'x': round(i * width), 'y': round(UNITS - (k + 1) * height),
                  'colour': colour(math.log(max(values[k, i], 1.0)) / math.log(top)),
                  'text': f'{values[k, i]:.3g}'}
                 for k in range(rows) for i in range(columns) if np.isfinite(values[k, i])]
        maps.append({'name': name, 'cells': cells, 'width': round(width + 1),
                     'height': round(height + 1)})
    x_ticks, y_ticks = (Axis(float(edges[0]), float(edges[-1])).to_the_right()
                        for edges, _ in (x, y))
    return {'title': title, 'maps': maps, 'x_ticks': x_ticks, 'y_ticks': y_ticks,
            'stops': [colour(k / 8) for k in range(9)], 'top': f'{top:.3g}', 'x_label': x[1],
            'y_label': y[1], 'unit': unit}


def colour(share: float) -> str:
    """Return the colour of `share`, 0 to 1, on the scale Cividis."""
    at = min(1.0, max(0.0, share)) * (len(CIVIDIS) - 1)
    k = min(int(at), len(CIVIDIS) - 2)
    mixed = [round(a + (at - k) * (b - a)) for a, b in zip(CIVIDIS[k], CIVIDIS[k + 1])]
    return '#{:02x}{:02x}{:02x}'.format(*mixed)


# ---------------------------------------------------------------------- bars and tables


@dataclass(frozen=True)
class BarRow:
    """
    One bar: name, note below it, value (None: no bar), its text, its role.

    interval: (low, high) of a whisker, or None.
    """

    name: str
    note: str
    value: float | None
    text: str
    role: str
    interval: Span | None = None


def bars(rows: Sequence[BarRow], log: bool = False, top: float | None = None) -> list[View]:
    """
    Return horizontal bars.

    Args:
        rows: from top to bottom.
        log: whether lengths are logarithms, from 1 on.
        top: value of a full bar (default: the largest value or end of a whisker).

    Returns:
        The views that templates/elements.html draws.

    """
    values = [v for row in rows for v in (row.value, *(row.interval or ())) if v is not None]
    full = top or max(values, default=1.0)

    def part(value: float) -> float:
        """Return the length of a bar of `value` in percent."""
        if log:
            share = math.log(max(value, 1.0)) / max(math.log(max(full, 1.0)), 1e-9)
        else:
            share = value / full if full > 0.0 else 0.0
        return 100.0 * min(1.0, max(0.0, share))
    views: list[View] = []
    for row in rows:
        ends = None if row.interval is None else (part(row.interval[0]), part(row.interval[1]))
        views.append({'row': row, 'fill': None if row.value is None else part(row.value),
                      'whisker': ends and (ends[0], max(ends[1] - ends[0], 0.0))})
    return views


@dataclass(frozen=True)
class PageTable:
    """A table: header and rows of text; numeric: columns aligned to the right."""

    header: Sequence[str]
    rows: Sequence[Sequence[object]]
    numeric: Sequence[int] = field(default=())
