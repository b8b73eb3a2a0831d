# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Charts as data, panels of curves, levels over time, loops and bars, and their views on pages.

A figure is described once. Its view is plain data, by the names by which templates/figures.html
and templates/sketch.html draw it: curves become SVG paths, a robot becomes lines and dots. Nothing
here is HTML.
"""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import itertools
import json
import math
from typing import Any, TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.robot.chain import Chain

Span: TypeAlias = tuple[float, float]  # (low, high)
MAX_POINTS = 4000  # of a curve
CLOUD_PERCENTILES = (0.2, 99.8)  # range of a cloud that is in view
LANE_HEIGHTS = (0.25, 0.6, 1.0)  # of a lane, by level
SIGMAS = 2.0  # of bands


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

    @property
    def around_style(self) -> str:
        """Class of what is drawn around it: a band, or a bar per dot."""
        return f'{self.role} around' if self.dots else f'band {self.role}'

    def around(self, std: Array | float) -> 'Trace':
        """Return it with the band of SIGMAS deviations `std` [N]."""
        return replace(self, band=(self.y - SIGMAS * std, self.y + SIGMAS * std))

    def points(self) -> tuple[Array, Array]:
        """Return x, y of the line to draw, thinned; edges become corners."""
        x, y = np.asarray(self.x, float), np.asarray(self.y, float)
        if self.step:
            x, y = np.repeat(x, 2)[1:-1], np.repeat(y, 2)
        at = thinned_rows(y)
        return x[at], y[at]


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

    def extent(self) -> Span:
        """Return the ends of the y axis, with room around the curves."""
        if self.limits is not None:
            return self.limits
        curves = [np.asarray(v, float) for trace in self.traces
                  for v in (trace.y, *(trace.band or ()))]
        level = () if self.level is None else (self.level,)
        return range_of(np.concatenate([*curves, level, self.include]))


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
    height: int = 22

    def spans(self) -> Iterator[tuple[float, float, int]]:
        """Yield (begin, end, level) of each span."""
        return zip(self.begins, (*self.begins[1:], self.end), self.levels)


@dataclass(frozen=True)
class Mark:
    """A moment on the x axis: x, its label (short) and its role: good, warn or error."""

    x: float
    label: str
    role: str = 'error'


@dataclass(frozen=True)
class Chart:
    """
    Panels and Lanes above each other on one x axis.

    title: plain text above; panels: from top to bottom; marks: moments drawn through all panels;
    span: (first, last) of x, None: as far as the curves go; group: charts of one group zoom
    together; zoom: whether a page has buttons for it.
    """

    title: str
    panels: Sequence[Panel | Lane]
    x_label: str
    marks: Sequence[Mark] = ()
    span: Span | None = None
    group: str = ''
    zoom: bool = True

    def traces(self) -> list[Trace]:
        """Return the curves of all panels."""
        return [t for panel in self.panels if isinstance(panel, Panel) for t in panel.traces]

    def extent(self) -> Span:
        """Return the ends of the x axis."""
        ends = [float(trace.x[k]) for trace in self.traces() for k in (0, -1) if len(trace.x)]
        first, last = self.span or (min(ends, default=0.0), max(ends, default=0.0))
        return first, last if last > first else first + 1.0


@dataclass(frozen=True)
class LoopSlice:
    """
    Curves of one slice of time in a loop plane: its name, and x, y of points and of lines.

    cloud ([P], [P]); lines (([N], [N]), ...).
    """

    name: str
    cloud: tuple[Array, Array]
    lines: Sequence[tuple[Array, Array]] = ()


@dataclass(frozen=True)
class Plane:
    """
    Slices of time over each other in one plane; on a page both axes can be zoomed.

    slices: earliest first, colours go with their order; limits: (low, high) of both axes; None:
    the clouds are in view.
    """

    title: str
    slices: Sequence[LoopSlice]
    x_label: str
    y_label: str
    limits: tuple[Span, Span] | None = None
    height: int = 420

    def extent(self) -> tuple[Span, Span]:
        """Return the ends of both axes."""
        if self.limits is not None:
            return self.limits
        x, y = (range_of(np.concatenate(
            [_inner(part.cloud[k]) for part in self.slices] or [np.empty(0)])) for k in (0, 1))
        return x, y


def _inner(values: Array) -> Array:
    """Return the percentiles of `values` that are in view, [2] or [0]."""
    values = values[np.isfinite(values)]
    return np.percentile(values, CLOUD_PERCENTILES) if len(values) else values


@dataclass(frozen=True)
class BarRow:
    """One bar: name, note below it, value (None: no bar), its text, its role."""

    name: str
    note: str
    value: float | None
    text: str
    role: str


@dataclass(frozen=True)
class Bars:
    """
    Horizontal bars from top to bottom.

    log: whether lengths are logarithms, from 1 on; top: value of a full bar, None: the largest
    value.
    """

    rows: Sequence[BarRow]
    log: bool = False
    top: float | None = None

    def full(self) -> float:
        """Return the value of a full bar."""
        return self.top or max((row.value for row in self.rows if row.value is not None),
                               default=1.0)


Drawing: TypeAlias = Chart | Plane


def tick_step(low: float, high: float, count: int) -> float:
    """
    Return the distance of ticks.

    Args:
        low: begin of the axis.
        high: its end, in the same unit.
        count: about so many ticks.

    Returns:
        1, 2 or 5 times a power of ten.
    """
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= 0.75 * raw)


def range_of(values: Array) -> Span:
    """Return the ends of an axis around `values` [N]; 0 and 1 if none is finite."""
    values = values[np.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 0.5 * abs(high) or 0.5
    return low - room, high + room


def round_span(values: Array) -> Span:
    """Return round ends around `values` [N], which stay while the values change a little."""
    low, high = range_of(values)
    step = tick_step(low, high, 4)
    return math.floor(low / step) * step, math.ceil(high / step) * step


def thinned_rows(y: Array, limit: int = MAX_POINTS) -> Integers:
    """
    Return the rows of fewer points of a curve, ascending; its extremes stay.

    Args:
        y: [N]; values that are not finite count as 0 in the search for extremes.
        limit: about so many rows are returned.

    Returns:
        Rows of lowest and highest point of each of `limit` / 2 stretches, and of both ends.

    """
    if len(y) <= limit:
        return np.arange(len(y))
    size = -(-2 * len(y) // limit)
    count = len(y) // size
    part = y[:count * size].reshape(count, size)
    part = np.where(np.isfinite(part), part, 0.0)
    at = np.sort(np.stack([part.argmin(axis=1), part.argmax(axis=1)], axis=1), axis=1)
    at = (at + np.arange(count)[:, None] * size).ravel()
    return np.unique(np.concatenate([[0], at, [len(y) - 1]]))


View: TypeAlias = Mapping[str, Any]  # {name in templates/figures.html: value}
Place = TypeVar('Place', float, Array)
UNITS = 10000      # width and height of a panel's view box


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
        step = tick_step(self.low, self.high, count)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        digits = max(0, -math.floor(math.log10(step) + 1e-9))
        return [(k * step, f'{k * step:.{digits}f}') for k in range(first, last + 1)]

    def to_the_right(self) -> list[Tick]:
        """Return the ticks of an x axis."""
        return [Tick(100.0 * self.share(value), text) for value, text in self.ticks()]


def chart_view(chart: Chart) -> View:
    """Return the view of `chart` that templates/figures.html draws."""
    legend: dict[str, Trace] = {}
    for trace in chart.traces():
        if trace.name:
            legend.setdefault(trace.name, trace)
    axis = Axis(*chart.extent())
    return {
        'title': chart.title, 'x_label': chart.x_label, 'group': chart.group, 'zoom': chart.zoom,
        'panels': [_panel(panel, axis) if isinstance(panel, Panel) else _lane(panel, axis)
                   for panel in chart.panels],
        'legend': [*legend.values()],
        'marks': [{'percent': 100.0 * axis.share(mark.x), 'x': f'{mark.x:.9g}',
                   'label': mark.label, 'role': mark.role,
                   'd': f'M{axis.right(mark.x):.0f} 0V{UNITS}'} for mark in chart.marks],
        'ticks': axis.to_the_right(), 'first': f'{axis.low:.9g}', 'last': f'{axis.high:.9g}',
        'vertical': ''.join(f'M{axis.right(value):.0f} 0V{UNITS}' for value, _ in axis.ticks())}


def _lane(lane: Lane, axis: Axis) -> View:
    """Return the view of one Lane; colour and height say the same."""
    paths = ['', '', '']
    for begin, end, level in lane.spans():
        low, high = (UNITS * (0.5 + side * 0.5 * LANE_HEIGHTS[level]) for side in (-1, 1))
        paths[level] += (f'M{axis.right(begin):.0f} {low:.0f}H{axis.right(end):.0f}'
                         f'V{high:.0f}H{axis.right(begin):.0f}Z')
    spans = json.dumps([[float(f'{b:.6g}'), w] for b, w in zip(lane.begins, lane.words)])
    return {
        'label': lane.label, 'height': lane.height, 'low': '0', 'high': '1', 'ticks': (),
        'paths': [{'style': f'lane level{level}', 'd': path, 'name': ''}
                  for level, path in enumerate(paths) if path],
        'horizontal': '', 'level': '', 'spans': spans, 'end': f'{lane.end:.6g}'}


def _panel(panel: Panel, axis: Axis) -> View:
    """Return the view of one Panel."""
    y = Axis(*panel.extent())
    y_ticks = y.ticks(max(4, panel.height // 36))
    return {
        'label': panel.label, 'height': panel.height, 'low': f'{y.low:.9g}',
        'high': f'{y.high:.9g}', 'paths': _paths(panel.traces, axis, y), 'spans': '', 'end': '',
        'ticks': _below_label(y, y_ticks, panel.height),
        'horizontal': ''.join(f'M0 {y.down(value):.0f}H{UNITS}' for value, _ in y_ticks),
        'level': '' if panel.level is None else f'M0 {y.down(panel.level):.0f}H{UNITS}'}


def _paths(traces: Sequence[Trace], axis: Axis, y: Axis) -> list[View]:
    """Return the paths of `traces`, each above its band."""
    paths = list[View]()
    for trace in traces:
        area = '' if trace.band is None else (_bars if trace.dots else _band)(
            trace.x, trace.band, axis, y)
        if area:
            paths.append({'style': trace.around_style, 'd': area, 'name': ''})
        xs, ys = trace.points()
        paths.append({'style': trace.style, 'name': trace.name,
                      'd': _drawn(axis.right(xs), y.down(ys), trace.dots)})
    return paths


def _below_label(axis: Axis, y_ticks: Sequence[tuple[float, str]], height: int) -> list[Tick]:
    """Return the ticks of a y axis, `height` pixels high, but those that would hit its label."""
    return [Tick(100.0 * axis.down(value) / UNITS, text) for value, text in y_ticks
            if axis.down(value) / UNITS * height > 6.0]


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


def _bars(x: Array, band: tuple[Array, Array], axis: Axis, y_axis: Axis) -> str:
    """Return the d of one upright bar per point between the curves of `band`, none where NaN."""
    low, high = (y_axis.down(np.asarray(v, float)) for v in band)
    return ''.join(f'M{a:.0f} {b:.0f}V{c:.0f}' for a, b, c in zip(
        axis.right(np.asarray(x, float)), low, high) if math.isfinite(b + c))


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


def plane_view(plane: Plane) -> View:
    """Return the view of a loop `plane` that templates/figures.html draws."""
    x_axis, y_axis = (Axis(*span) for span in plane.extent())

    def path(x: Array, y: Array, dots: bool) -> str:
        """Return the d of a line through `x`, `y`, or of a cloud of `dots`."""
        return _drawn(x_axis.right(x), y_axis.down(y), dots)
    slices = [{'age': k / max(len(plane.slices) - 1, 1), 'name': s.name,
               'cloud': path(*s.cloud, dots=True),
               'lines': ''.join(path(*line, dots=False) for line in s.lines)}
              for k, s in enumerate(plane.slices)]
    y_ticks = y_axis.ticks(plane.height // 48)
    lattice = ''.join(f'M{x_axis.right(value):.0f} 0V{UNITS}' for value, _ in x_axis.ticks())
    lattice += ''.join(f'M0 {y_axis.down(value):.0f}H{UNITS}' for value, _ in y_ticks)
    return {
        'title': plane.title, 'slices': slices, 'x_low': f'{x_axis.low:.9g}',
        'x_high': f'{x_axis.high:.9g}', 'y_low': f'{y_axis.low:.9g}',
        'y_high': f'{y_axis.high:.9g}', 'x_ticks': x_axis.to_the_right(),
        'y_ticks': _below_label(y_axis, y_ticks, plane.height), 'lattice': lattice,
        'x_label': plane.x_label, 'y_label': plane.y_label, 'height': plane.height}


def bar_views(bars: Bars) -> list[View]:
    """Return the views of `bars` that templates/elements.html draws."""
    full = bars.full()

    def part(value: float) -> float:
        """Return the length of a bar of `value` in percent."""
        if bars.log:
            share = math.log(max(value, 1.0)) / max(math.log(max(full, 1.0)), 1e-9)
        else:
            share = value / full if full > 0.0 else 0.0
        return 100.0 * min(1.0, max(0.0, share))
    return [{'row': row, 'fill': None if row.value is None else part(row.value)}
            for row in bars.rows]


WIDTH, HEIGHT, MARGIN = 460.0, 300.0, 40.0
LINE, LETTER = 17.0, 8.8    # height of a line of text, and width of a bold letter on average


@dataclass(frozen=True)
class Dot:
    """
    A joint in the picture.

    name, lines: written next to it; role: hit, lost, held or calm, sets its colour; r: radius, px.
    needed: whether the text must be there, however full the picture is.
    """

    name: str
    lines: Sequence[str] = ()
    role: str = 'calm'
    r: float = 5.0
    needed: bool = True


@dataclass(frozen=True)
class Box:
    """A rectangle in the picture, px."""

    left: float
    top: float
    right: float
    bottom: float

    def inside(self) -> bool:
        """Return whether it is within the picture."""
        return (self.left >= 0.0 and self.right <= WIDTH and self.top >= 0.0
                and self.bottom <= HEIGHT)

    def hits(self, other: 'Box') -> bool:
        """Return whether it covers a part of an `other` one."""
        return (self.left < other.right and other.left < self.right and self.top < other.bottom
                and other.top < self.bottom)


def sketch(chain: Chain, posture: Array, dots: Mapping[str, Dot]) -> View:
    """
    Return the picture of a robot, which templates/sketch.html draws.

    Args:
        chain: the robot.
        posture: usual positions [J].
        dots: {joint: its dot}, the most important first; others are drawn without text.
    """
    _, places, _, _ = chain.poses(posture[None])
    xy = _seen(np.vstack([np.zeros(3), *(place[0] for place in places)]))
    at = {link.joint: xy[i + 1] for i, link in enumerate(chain.links)}
    taken = [Box(x - 7.0, y - 7.0, x + 7.0, y + 7.0) for x, y in xy]
    views = []
    for joint, dot in dots.items():
        x, y = map(float, at[joint])
        view = {'x': x, 'y': y, 'dot': dot, 'text': None}
        lines = [dot.name, *dot.lines]
        box = next((b for b in _places(x, y, lines, dot)
                    if b.inside() and not any(b.hits(t) for t in taken)), None)
        if box is not None:
            taken.append(box)
            left = box.right < x
            middle = 0.5 * (box.top + box.bottom)
            view['text'] = {'x': box.right if left else box.left, 'left': left, 'middle': middle,
                            'far': abs(middle - y) > LINE,
                            'lines': [(box.top + LINE * (k + 0.8), line)
                                      for k, line in enumerate(lines)]}
        views.append(view)
    top, bottom = min(b.top for b in taken) - 4.0, max(b.bottom for b in taken) + 4.0
    return {'width': WIDTH, 'top': top, 'height': bottom - top, 'dots': views, 'base': xy[0],
            'bones': [(*xy[link.parent + 1], *xy[i + 1]) for i, link in enumerate(chain.links)]}


def _seen(places: Array) -> Array:
    """Return `places` [N, 3] in px [N, 2], seen from the side from which they are widest."""
    flat = places - places.mean(axis=0)
    turned = np.arctan2(*np.linalg.svd(flat[:, :2], full_matrices=False)[2][0][::-1])
    across = flat[:, 0] * np.cos(turned) + flat[:, 1] * np.sin(turned)
    points = np.column_stack([across, -flat[:, 2]])
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    scale = float(min((WIDTH - 2 * MARGIN) / max(size[0], 1e-3),
                      (HEIGHT - 2 * MARGIN) / max(size[1], 1e-3), 600.0))
    out: Array = points * scale + np.array([WIDTH, HEIGHT]) / 2 - scale * (low + size / 2)
    return out


def _places(x: float, y: float, lines: Sequence[str], dot: Dot) -> Iterator[Box]:
    """Yield where the `lines` of a `dot` at (x, y) may be written, the best place first."""
    width, height = LETTER * max(map(len, lines)), LINE * len(lines)
    reach = HEIGHT if dot.needed else 2.0 * LINE
    shifts = sorted(np.arange(-reach, reach + 1.0, 0.25 * LINE).tolist(), key=abs)
    for shift, away in itertools.product(shifts, (dot.r + 8.0, dot.r + 40.0)):
        top = y + shift - 0.5 * height
        yield Box(x + away, top, x + away + width, top + height)
        yield Box(x - away - width, top, x - away, top + height)
