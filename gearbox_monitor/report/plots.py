# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Charts drawn by matplotlib: figures of .plot() and PNG files."""
from collections.abc import Sequence
import textwrap

from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure, SubFigure
import numpy as np

from gearbox_monitor.report.chart import (
    Chart, Drawing, Lane, LANE_HEIGHTS, Mark, Plane, thinned_rows, Trace)

# As assets/page.css has them for a light page.
COLOURS = {'recording': '#1b1d21', 'nominal': '#c94f00', 'closed': '#0072b2', 'signal': '#00795a',
           'warn': '#c94f00', 'error': '#b3001e', 'good': '#00795a',
           'early': '#0072b2', 'late': '#e08a00', 'soft': '#585d66', 'line': '#d6d9de'}
DASHES = {'nominal': '--', 'warn': '--', 'error': ':', 'limit': '--'}
PIXELS = 72.0        # of a panel per inch
HEAD, FOOT = 52, 60  # pixels of a chart for its title and the labels of its axis
BAND_POINTS = 2000


def figure(rows: Sequence[Sequence[Drawing]], title: str = '') -> Figure:
    """
    Return the Figure of charts.

    Args:
        rows: charts side by side, row by row.
        title: above them.

    """
    heights = [max(_height(part) for part in row) for row in rows]
    columns = max((len(row) for row in rows), default=1)
    drawn = Figure(figsize=((10.0, 14.0, 16.5)[min(columns, 3) - 1],
                            (sum(heights) + 70) / PIXELS), layout='constrained')
    put_title(drawn, title)
    if not rows:
        return drawn
    strips = drawn.subfigures(len(rows), 1, height_ratios=heights, squeeze=False)[:, 0]
    for row, strip in zip(rows, strips):
        for part, cell in zip(row, strip.subfigures(1, len(row), squeeze=False)[0]):
            cell.suptitle(part.title, fontsize=11, x=0.01, ha='left')
            if isinstance(part, Chart):
                _draw_chart(cell, part)
            else:
                _draw_plane(cell.subplots(), part)
    return drawn


def put_title(drawn: Figure, title: str, size: int = 13) -> None:
    """
    Write a title above a picture, in as many lines as its width needs.

    Args:
        drawn: the picture.
        title: one or more lines.
        size: of the letters, points; a bold one takes about .65 of it.

    """
    width = int(72.0 * drawn.get_figwidth() / (0.65 * size))
    lines = [part for line in title.splitlines() for part in textwrap.wrap(line, width)]
    drawn.suptitle('\n'.join(lines), fontsize=size, fontweight='bold')


def _height(part: Drawing) -> int:
    """Return the height of a chart in pixels."""
    if isinstance(part, Chart):
        return HEAD + FOOT + sum(panel.height for panel in part.panels)
    return HEAD + part.height


def _draw_chart(cell: SubFigure, chart: Chart) -> None:
    column = cell.subplots(len(chart.panels), 1, sharex=True, squeeze=False, height_ratios=[
        panel.height for panel in chart.panels])[:, 0]
    for axes, panel in zip(column, chart.panels):
        axes.set_title(panel.label, fontsize=8, loc='left', color=COLOURS['soft'])
        axes.tick_params(labelsize=8)
        for mark in chart.marks:
            axes.axvline(mark.x, color=COLOURS[mark.role], lw=1.5)
        if isinstance(panel, Lane):
            _draw_lane(axes, panel)
            continue
        for trace in panel.traces:
            _draw_trace(axes, trace)
        if panel.level is not None:
            axes.axhline(panel.level, color=COLOURS['soft'], lw=0.8, ls=':')
        axes.set_ylim(*panel.extent())
        axes.grid(True, color=COLOURS['line'], lw=0.5)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8, loc='upper left', ncols=4)
    column[-1].set_xlim(*chart.extent())
    column[-1].set_xlabel(chart.x_label, fontsize=9)
    for mark in chart.marks:
        _write_mark(column[0], mark)


def _write_mark(axes: Axes, mark: Mark) -> None:
    axes.annotate(mark.label, (mark.x, 0.02), xycoords=('data', 'axes fraction'), rotation=90,
                  xytext=(-3, 0), textcoords='offset points', va='bottom', ha='right',
                  color=COLOURS[mark.role], fontsize=9, fontweight='bold')


def _draw_trace(axes: Axes, trace: Trace) -> None:
    role, *firmness = trace.role.split()
    color, faint = COLOURS.get(role, COLOURS['soft']), 'faint' in firmness
    x, y = trace.points()
    if trace.band is not None:
        at = thinned_rows(trace.y, BAND_POINTS)
        low, high = (side[at] for side in trace.band)
        if trace.dots:
            axes.vlines(trace.x[at], low, high, color=color, lw=1.2)
        else:
            axes.fill_between(trace.x[at], low, high, color=color, alpha=0.2, lw=0)
    axes.plot(x, y, color=color, label=trace.name or None, alpha=0.3 if faint else 1.0,
              lw=0.0 if trace.dots else 0.8 if faint else 1.4, marker='o' if trace.dots else '',
              ms=4, ls='-' if firmness else DASHES.get(role, '-'))


def _draw_lane(axes: Axes, lane: Lane) -> None:
    for level, (high, role) in enumerate(zip(LANE_HEIGHTS, ('good', 'warn', 'error'))):
        axes.broken_barh([(begin, end - begin) for begin, end, at in lane.spans() if at == level],
                         (0.5 - 0.5 * high, high), color=COLOURS[role])
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([])


def _draw_plane(axes: Axes, plane: Plane) -> None:
    early, late = (np.array(to_rgb(COLOURS[name])) for name in ('early', 'late'))
    for k, part in enumerate(plane.slices):
        share = k / max(len(plane.slices) - 1, 1)
        color = tuple(((1.0 - share) * early + share * late).tolist())
        label = part.name if share in (0.0, 1.0) else None
        axes.plot(*part.cloud, '.', color=color, ms=2.5, alpha=0.35)
        for line in part.lines or [(np.empty(0), np.empty(0))]:
            axes.plot(*line, color=color, lw=1.6, label=label)
            label = None
    (left, right), (low, high) = plane.extent()
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_xlabel(plane.x_label, fontsize=9)
    axes.set_ylabel(plane.y_label, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(True, color=COLOURS['line'], lw=0.5)
    if plane.slices:
        axes.legend(fontsize=8, loc='upper left')
