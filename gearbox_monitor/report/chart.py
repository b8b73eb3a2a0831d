# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Charts as data: panels of curves, levels over time, loops, bars.

A figure is described once; svg.py draws it on pages.
"""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers

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


@dataclass(frozen=True)
class Bars:
    """
    Horizontal bars from top to bottom.

    log: whether lengths are logarithms, from 1 on; top: value of a full bar, None: the largest
    value or end of a whisker.
    """

    rows: Sequence[BarRow]
    log: bool = False
    top: float | None = None

    def full(self) -> float:
        """Return the value of a full bar."""
        return self.top or max((v for row in self.rows for v in (
            row.value, *(row.interval or ())) if v is not None), default=1.0)


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
