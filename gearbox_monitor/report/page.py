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
The one renderer of pages: parts of a self-contained HTML file, which loads nothing.

Functions return HTML strings; text that is given is escaped. Curves are SVG paths, drawn once in
units of their panel, and stay sharp when zoomed.
"""
from dataclasses import dataclass
from html import escape
import json
import math

import numpy as np

UNITS = 10000      # a panel is so many wide and high
MAX_POINTS = 4000  # of a curve
LANE_HEIGHT = 22
SEEN = (0.2, 99.8)  # percentiles of a cloud that are in view
HEIGHTS = (0.25, 0.6, 1.0)  # of a lane, by level
ZOOMS = (('left', 'earlier', '&#8592;'), ('right', 'later', '&#8594;'),
         ('out', 'zoom out', '&#8722;'), ('in', 'zoom in', '+'), ('all', 'show all', 'all'))


@dataclass(frozen=True)
class Line:
    """
    One curve: x [N], y [N] (NaN: none), its name, and its role, which sets the colour.

    role: recording, nominal, closed, signal, warn, error or limit. step: x [N + 1] are edges of y
    [N]. band: (low [N], high [N]) drawn around it, NaN: none, or None. dots: each point on its
    own, no line between them.
    """

    x: np.ndarray
    y: np.ndarray
    name: str
    role: str
    step: bool = False
    band: tuple | None = None
    dots: bool = False


@dataclass(frozen=True)
class Panel:
    """
    Curves on one axis.

    level: y of a dotted line, or None; height in pixels; shown: values that are in view anyway;
    limits: (low, high) of the y axis, whatever lies beyond; None: all is in view.
    """

    label: str
    lines: tuple
    level: float | None = None
    height: int = 170
    shown: tuple = ()
    limits: tuple | None = None


@dataclass(frozen=True)
class Lane:
    """
    What was in force when, as a bar on the x axis: higher is worse.

    begins [K], end of the last one; levels [K]: 0 fine, 1 warning, 2 error; words: [K] of each.
    """

    label: str
    begins: tuple
    end: float
    levels: tuple
    words: tuple


@dataclass(frozen=True)
class Mark:
    """A moment on the x axis: x, what stands there (short) and its role: good, warn or error."""

    x: float
    label: str
    role: str = 'error'


@dataclass(frozen=True)
class Slice:
    """
    Curves of one slice of time in `loops`: its name, and x, y of points and of lines.

    cloud ([P], [P]); lines (([N], [N]), ...).
    """

    name: str
    cloud: tuple
    lines: tuple


def paragraph(text, soft=False):
    """Return a paragraph."""
    return f'<p{" class=soft" if soft else ""}>{escape(text)}</p>'


def bullets(items):
    """Return a list."""
    return f'<ul>{"".join(f"<li>{escape(item)}</li>" for item in items)}</ul>' if items else ''


def details(summary, html):
    """Return a part that opens on a click."""
    return f'<details><summary>{escape(summary)}</summary>{html}</details>'


def facts(items):
    """Return figures side by side; items: [(name, value)]."""
    return '<dl class="facts">' + ''.join(
        f'<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>'
        for name, value in items) + '</dl>'


def grid(*parts):
    """Return parts two in a row, on a phone one."""
    return f'<div class="grid">{"".join(parts)}</div>'


def tabs(items):
    """Return parts of which one shows, chosen by buttons; items: [(name, HTML)]."""
    if len(items) == 1:
        return items[0][1]
    buttons = ''.join(f'<button type="button" role="tab">{escape(n)}</button>' for n, _ in items)
    parts = ''.join(f'<div class="tab"><h3>{escape(n)}</h3>{html}</div>' for n, html in items)
    return f'<div class="tabs"><div class="tabbar" role="tablist">{buttons}</div>{parts}</div>'


def table(header, rows, numeric=()):
    """Return a table; numeric: columns aligned to the right."""
    def line(cells, tag):
        return '<tr>' + ''.join(
            f'<{tag}{" class=n" if k in numeric else ""}>{escape(str(cell))}</{tag}>'
            for k, cell in enumerate(cells)) + '</tr>'
    return ('<div class="scroll"><table><thead>' + line(header, 'th') + '</thead><tbody>'
            + ''.join(line(row, 'td') for row in rows) + '</tbody></table></div>')


def bars(rows, log=False, top=None):
    """
    Return horizontal bars.

    rows: [(name, note, value or None, shown, role, (low, high) or None)]. log: lengths are
    logarithms, from 1 on. top: value of a full bar (default: the largest).
    """
    values = [v for row in rows for v in (row[2], *(row[5] or ())) if v is not None]
    top = top or max(values, default=1.0)

    def part(value):
        if log:
            share = math.log(max(value, 1.0)) / max(math.log(max(top, 1.0)), 1e-9)
        else:
            share = value / top if top > 0.0 else 0.0
        return 100.0 * min(1.0, max(0.0, share))
    out = []
    for name, note, value, shown, role, interval in rows:
        fill = whisker = ''
        if value is not None:
            fill = f'<span class="fill {role}" style="width:{part(value):.2f}%"></span>'
        if interval:
            low, high = part(interval[0]), part(interval[1])
            whisker = (f'<span class="whisker" style="left:min({low:.2f}%,100% - 5px);width:'
                       f'max(5px,{max(high - low, 0.0):.2f}%)"></span>')
        small = f'<small>{escape(note)}</small>' if note else ''
        out.append(f'<div class="row"><div>{escape(name)}{small}</div>'
                   f'<div class="track">{fill}{whisker}</div>'
                   f'<div class="value">{escape(shown)}</div></div>')
    return f'<div class="bars">{"".join(out)}</div>'


def matrix(names, values):
    """
    Return the square table `values` [N, N] of shares; small ones stand out.

    Columns are called by the number of their row.
    """
    head = '<tr><th></th><th></th>' + ''.join(
        f'<th class="n" title="{escape(name)}">{k + 1}</th>'
        for k, name in enumerate(names)) + '</tr>'
    rows = []
    for i, name in enumerate(names):
        cells = ''.join(
            '<td></td>' if i == j else
            f'<td class="cell" style="--v:{1.0 - values[i][j]:.2f}" title="{escape(name)} less '
            f'what {escape(other)} imitates">{100.0 * values[i][j]:.0f}</td>'
            for j, other in enumerate(names))
        rows.append(f'<tr><th class="n">{i + 1}</th><td>{escape(name)}</td>{cells}</tr>')
    return ('<div class="scroll"><table class="matrix"><thead>' + head + '</thead><tbody>'
            + ''.join(rows) + '</tbody></table></div>')


# ---------------------------------------------------------------------- charts


def ticks(low, high, count=5):
    """Return (values, digits behind the point) of round ticks between `low` and `high`."""
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= 0.75 * raw)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return ([k * step for k in range(first, last + 1)],
            max(0, -math.floor(math.log10(step) + 1e-9)))


def chart(title, panels, x_label, unit, zoom=True, marks=(), group='', span=None):
    """
    Return Panels and Lanes above each other on one x axis; a part of it can be zoomed.

    unit: of x, as "t (s)", told with the values under the pointer. zoom: with buttons for it.
    marks: Marks through all panels. group: charts of one group zoom together. span: (first, last)
    of x; None: as far as the lines go.
    """
    if span is None:
        xs = [line.x for panel in panels if isinstance(panel, Panel) for line in panel.lines]
        span = min(x[0] for x in xs), max(x[-1] for x in xs)
    first, last = float(span[0]), float(span[1])
    last = last if last > first else first + 1.0
    values, digits = ticks(first, last)
    grid_lines = ''.join(f'M{_x(v, first, last):.0f} 0V{UNITS}' for v in values)
    legend, seen = '', set()
    for panel in panels:
        for line in panel.lines if isinstance(panel, Panel) else ():
            if line.name and line.name not in seen:
                seen.add(line.name)
                band = '' if line.band is None else \
                    f'<path class="band {line.role}" d="M0 0H26V8H0Z"/>'
                drawn = 'M6 4h0M13 4h0M20 4h0' if line.dots else 'M0 4H26'
                legend += (f'<span><svg viewBox="0 0 26 8" aria-hidden="true">{band}<path '
                           f'class="{_class(line)}" d="{drawn}"/></svg>{escape(line.name)}</span>')
    tools = _tools(*(ZOOMS if zoom else ()))
    crosses = ''.join(f'<path class="mark {mark.role}" d="M{_x(mark.x, first, last):.0f} '
                      f'0V{UNITS}"/>' for mark in marks)
    named = ''.join(
        f'<span class="mk {mark.role}" data-at="{mark.x:.9g}" style="left:'
        f'{100 * (mark.x - first) / (last - first):.2f}%">{escape(mark.label)}</span>'
        for mark in marks)
    labels = ''.join(f'<span style="left:{100 * (v - first) / (last - first):.2f}%">'
                     f'{v:.{digits}f}</span>' for v in values)
    drawn = ''.join(
        (_panel if isinstance(panel, Panel) else _lane)(panel, first, last, grid_lines, crosses)
        for panel in panels)
    return (f'<figure class="chart" data-from="{first:.9g}" data-to="{last:.9g}" '
            f'data-x="{escape(unit)}" data-group="{escape(group)}"><figcaption>{tools}'
            f'{escape(title)}</figcaption><div class="legend">{legend}</div>'
            + (f'<div class="marks">{named}</div>' if named else '') + drawn
            + f'<div class="xt">{labels}</div><div class="xlabel">{escape(x_label)}</div>'
            '<div class="readout"></div></figure>')


def _tools(*buttons):
    """Return buttons (what, says, sign) of a figure."""
    html = ''.join(
        f'<button type="button" data-zoom="{what}" title="{says}" aria-label="{says}">{sign}'
        '</button>' for what, says, sign in buttons)
    return f'<span class="tools">{html}</span>' if html else ''


def loops(title, slices, x_label, y_label, height=420):
    """
    Return Slices over each other in one plane, earliest to latest by colour.

    One of them can be chosen, which shows its points; both axes can be zoomed.
    """
    (left, right), (low, high) = (
        _range(np.concatenate([np.percentile(s.cloud[k], SEEN) for s in slices]))
        for k in (0, 1))

    def path(x, y):
        return [(UNITS * (a - left) / (right - left), UNITS * (high - b) / (high - low))
                for a, b in zip(x, y) if math.isfinite(a) and math.isfinite(b)]
    groups = ''
    for k, s in enumerate(slices):
        cloud = ''.join(f'M{a:.0f} {b:.0f}h0' for a, b in path(*s.cloud))
        lines = ''.join('M' + 'L'.join(f'{a:.0f} {b:.0f}' for a, b in path(*line))
                        for line in s.lines if len(line[0]))
        first = ' first' if k == 0 else ''
        groups += (f'<g class="slice{first}" style="--t:{k / max(len(slices) - 1, 1):.3f}" '
                   f'data-name="{escape(s.name)}"><path class="cloud" d="{cloud}"/>'
                   f'<path class="mean" d="{lines}"/></g>')
    x_marks, x_digits = ticks(left, right)
    y_marks, y_digits = ticks(low, high, height // 48)
    x_ticks = ''.join(f'<span style="left:{100 * (v - left) / (right - left):.2f}%">'
                      f'{v:.{x_digits}f}</span>' for v in x_marks)
    y_ticks = ''.join(f'<span class="yt" style="top:{100 * (high - v) / (high - low):.2f}%">'
                      f'{v:.{y_digits}f}</span>' for v in y_marks)
    lines = ''.join(f'M{UNITS * (v - left) / (right - left):.0f} 0V{UNITS}' for v in x_marks)
    lines += ''.join(f'M0 {UNITS * (high - v) / (high - low):.0f}H{UNITS}' for v in y_marks)
    pick = (f'<div class="pick"><button type="button" data-pick="-1" aria-label="earlier">&#8592;'
            f'</button><input type="range" min="0" max="{len(slices)}" value="0" '
            'aria-label="slice of time"><button type="button" data-pick="1" aria-label="later">'
            '&#8594;</button><output>all</output></div>' if len(slices) > 1 else '')
    scale = (f'<div class="heat">{escape(slices[0].name)}<i class="early-late"></i>'
             f'{escape(slices[-1].name)}</div>')
    alone = ' alone' if len(slices) == 1 else ''
    return (f'<figure class="plane{alone}" data-left="{left:.9g}" data-right="{right:.9g}" '
            f'data-low="{low:.9g}" data-high="{high:.9g}"><figcaption>{_tools(*ZOOMS[2:])}'
            f'{escape(title)}</figcaption>{scale}{pick}<div class="panel"><div class="ylabel">'
            f'{escape(y_label)}</div><div class="plot" style="height:{height}px"><div class="yts">'
            f'{y_ticks}</div><svg viewBox="0 0 {UNITS} {UNITS}" preserveAspectRatio="none" '
            f'role="img" aria-label="{escape(title)}"><path class="grid lattice" d="{lines}"/>'
            f'{groups}</svg><div class="range"></div></div></div><div class="xt">{x_ticks}</div>'
            f'<div class="xlabel">{escape(x_label)}</div></figure>')


def heat_maps(title, planes, x_edges, y_edges, x_label, y_label, unit):
    """
    Return planes [(name, values [Y, X])] side by side, colours on one logarithmic scale.

    Values are 1 and above; NaN stays empty.
    """
    known = [v[np.isfinite(v)] for _, v in planes]
    top = max((float(v.max()) for v in known if len(v)), default=2.0)
    top = max(top, 2.0)
    x_marks, x_digits = ticks(x_edges[0], x_edges[-1])
    y_marks, y_digits = ticks(y_edges[0], y_edges[-1])
    figures = []
    for name, values in planes:
        rows, columns = values.shape
        width, height = UNITS / columns, UNITS / rows
        cells = ''.join(
            f'<rect x="{i * width:.0f}" y="{UNITS - (k + 1) * height:.0f}" '
            f'width="{width + 1:.0f}" height="{height + 1:.0f}" '
            f'fill="{_colour(math.log(max(values[k, i], 1.0)) / math.log(top))}"><title>'
            f'{values[k, i]:.3g}</title></rect>'
            for k in range(rows) for i in range(columns) if np.isfinite(values[k, i]))
        y_ticks = ''.join(
            f'<span class="yt" style="bottom:{100 * _share(v, y_edges):.2f}%;'
            f'transform:translateY(50%)">{v:.{y_digits}f}</span>' for v in y_marks)
        x_ticks = ''.join(f'<span style="left:{100 * _share(v, x_edges):.2f}%">{v:.{x_digits}f}'
                          '</span>' for v in x_marks)
        figures.append(
            f'<figure><figcaption>{escape(name)}</figcaption><div class="panel"><div '
            f'class="ylabel">{escape(y_label)}</div><div class="plot" style="height:200px">'
            f'{y_ticks}<svg viewBox="0 0 {UNITS} {UNITS}" preserveAspectRatio="none" role="img" '
            f'aria-label="{escape(name)}">{cells}</svg></div></div><div class="xt">{x_ticks}'
            f'</div><div class="xlabel">{escape(x_label)}</div></figure>')
    stops = ', '.join(_colour(k / 8) for k in range(9))
    scale = (f'<div class="heat">1<i style="background:linear-gradient(to right, {stops})"></i>'
             f'{top:.3g} {escape(unit)}, logarithmic</div>')
    return f'<h3>{escape(title)}</h3>{scale}{grid(*figures)}'


def _share(value, edges):
    return (value - edges[0]) / (edges[-1] - edges[0])


# Cividis in nine steps: dark to bright for all eyes.
_CIVIDIS = ((0, 34, 78), (18, 53, 112), (59, 73, 108), (87, 93, 109), (112, 113, 115),
            (138, 134, 120), (165, 156, 116), (195, 179, 105), (254, 232, 56))


def _colour(share):
    """Return the colour of `share`, 0 to 1."""
    at = min(1.0, max(0.0, share)) * (len(_CIVIDIS) - 1)
    k = min(int(at), len(_CIVIDIS) - 2)
    mixed = [round(a + (at - k) * (b - a)) for a, b in zip(_CIVIDIS[k], _CIVIDIS[k + 1])]
    return '#{:02x}{:02x}{:02x}'.format(*mixed)


def _x(value, first, last):
    return UNITS * (value - first) / (last - first)


def _class(line):
    return f'{line.role} dots' if line.dots else line.role


def _lane(lane, first, last, grid_lines, marks):
    """Return one Lane; colour and height say the same."""
    ends = (*lane.begins[1:], lane.end)
    paths = ['', '', '']
    for begin, end, level in zip(lane.begins, ends, lane.levels):
        low, high = (UNITS * (0.5 + side * 0.5 * HEIGHTS[level]) for side in (-1, 1))
        paths[level] += (f'M{_x(begin, first, last):.0f} {low:.0f}H{_x(end, first, last):.0f}'
                         f'V{high:.0f}H{_x(begin, first, last):.0f}Z')
    drawn = ''.join(f'<path class="lane level{level}" d="{path}"/>'
                    for level, path in enumerate(paths) if path)
    spans = json.dumps([[float(f'{b:.6g}'), w] for b, w in zip(lane.begins, lane.words)])
    return (f'<div class="panel"><div class="ylabel">{escape(lane.label)}</div><div class="plot" '
            f'style="height:{LANE_HEIGHT}px" data-low="0" data-high="1" '
            f'data-spans="{escape(spans)}" data-end="{lane.end:.6g}"><svg '
            f'viewBox="0 0 {UNITS} {UNITS}" preserveAspectRatio="none" role="img" '
            f'aria-label="{escape(lane.label)}"><path class="grid xgrid" d="{grid_lines}"/>'
            f'{drawn}{marks}</svg><div class="cursor"></div><div class="range"></div></div></div>')


def _panel(panel, first, last, grid_lines, marks):
    low, high = _limits(panel)
    marks, digits = ticks(low, high, max(4, panel.height // 36))

    def y(value):
        return UNITS * (high - value) / (high - low)
    horizontal = ''.join(f'M0 {y(v):.0f}H{UNITS}' for v in marks)
    labels = ''.join(f'<span class="yt" style="top:{y(v) / UNITS:.2%}">{v:.{digits}f}</span>'
                     for v in marks if y(v) / UNITS * panel.height > 6.0)
    level = ('' if panel.level is None else
             f'<path class="zero" d="M0 {y(panel.level):.0f}H{UNITS}"/>')
    curves = ''
    for line in panel.lines:
        if line.band is not None:
            curves += _band(line, first, last, y)
        called = f' data-name="{escape(line.name)}"' if line.name else ''
        curves += (f'<path class="{_class(line)}"{called} '
                   f'd="{_path(line, first, last, y)}"/>')
    return (f'<div class="panel"><div class="ylabel">{escape(panel.label)}</div><div class="plot" '
            f'style="height:{panel.height}px" data-low="{low:.9g}" data-high="{high:.9g}">'
            f'{labels}<svg viewBox="0 0 {UNITS} {UNITS}" preserveAspectRatio="none" role="img" '
            f'aria-label="{escape(panel.label)}"><path class="grid" d="{horizontal}"/>'
            f'<path class="grid xgrid" d="{grid_lines}"/>{level}{marks}{curves}</svg>'
            '<div class="cursor"></div><div class="range"></div></div></div>')


def _limits(panel):
    """Return (low, high) of the y axis of a Panel, with room around what is drawn."""
    if panel.limits is not None:
        return panel.limits
    values = [np.asarray(v, float) for line in panel.lines
              for v in (line.y, *(line.band or ()))]
    values = np.concatenate([v[np.isfinite(v)] for v in values] or [np.zeros(0)])
    values = np.append(values, panel.shown if panel.level is None else
                       (panel.level, *panel.shown))
    return _range(values)


def _range(values):
    """Return (low, high) around values [N], with room; (0, 1) where there are none."""
    values = values[np.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 0.5 * abs(high) or 0.5
    return low - room, high + room


def thinned(x, y, most=MAX_POINTS):
    """Return x, y [N] with no more than about `most` points; extremes stay."""
    if len(x) <= most:
        return x, y
    size = -(-2 * len(x) // most)
    count = len(x) // size
    part = y[:count * size].reshape(count, size)
    part = np.where(np.isfinite(part), part, 0.0)
    at = np.sort(np.stack([part.argmin(axis=1), part.argmax(axis=1)], axis=1), axis=1)
    at = (at + np.arange(count)[:, None] * size).ravel()
    at = np.unique(np.concatenate([[0], at, [len(x) - 1]]))
    return x[at], y[at]


def _path(line, first, last, y):
    """Return the d of an SVG path; it breaks where y is NaN."""
    xs, ys = np.asarray(line.x, float), np.asarray(line.y, float)
    if line.step:
        xs, ys = np.repeat(xs, 2)[1:-1], np.repeat(ys, 2)
    xs, ys = thinned(xs, ys)
    out, pen = [], 'M'
    for a, b in zip(_x(xs, first, last), y(ys)):
        if not math.isfinite(b):
            pen = 'M'
            continue
        out.append(f'{pen}{a:.0f} {b:.0f}{"h0" if line.dots else ""}')
        pen = 'M' if line.dots else 'L'
    return ''.join(out)


def _band(line, first, last, y):
    xs = _x(np.asarray(line.x, float), first, last)
    low, high = (y(np.asarray(v, float)) for v in line.band)
    known = np.isfinite(low) & np.isfinite(high)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]])))
    path = ''
    for begin, end in zip(edges[::2], edges[1::2]):
        there = [f'{a:.0f} {b:.0f}' for a, b in zip(xs[begin:end], high[begin:end])]
        back = [f'{a:.0f} {b:.0f}' for a, b in zip(xs[begin:end][::-1], low[begin:end][::-1])]
        path += f'M{"L".join(there + back)}Z'
    return f'<path class="band {line.role}" d="{path}"/>' if path else ''
