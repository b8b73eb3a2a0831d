# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures by matplotlib: the demo, recording with models, comparison of filters."""
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
import textwrap
from typing import Any, TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
import numpy as np

from gearbox_monitor.diagnosis.joint.closed_model import Overlay
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.diagnosis_evidence import clipped_to_range, smoothed
from gearbox_monitor.report.words import unit_of

BLUE, ORANGE, GREEN, RED, SKY = '#0072B2', '#E69F00', '#009E73', '#D55E00', '#56B4E9'
BLACK, GREY = '#000000', '#777777'
ZOOM = 2.0  # s of torque
MAX_POINTS = 6000  # more cannot be seen, but make the file large
Span: TypeAlias = tuple[float, float]  # (begin, end) in s


@dataclass(frozen=True)
class Curve:
    """One loop: twist [N] rad, tau_k [N] N m, and its name in the legend, None: no entry."""

    twist: Array
    tau_k: Array
    label: str | None
    color: str = BLUE


@dataclass(frozen=True)
class TorqueCurve:
    """Torque over time: t [N] s, tau_k [N] N m, std [N] N m or None."""

    t: Array
    tau_k: Array
    std: Array | None = None


@dataclass(frozen=True)
class BacklashCurve:
    """
    Backlash of consecutive windows, each ending at t [W] s: value [W] and std [W] in rad.

    baseline, warn, error: levels (rad) or None. alarms: (t, text, is_error). truth: (t, value).
    """

    t: Array
    value: Array
    std: Array
    window: float
    baseline: float | None = None
    warn: float | None = None
    error: float | None = None
    alarms: Sequence[tuple[float, str, bool]] = ()
    truth: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class Innovations:
    """Prediction errors over time: t [N] s, error [N, S] and std [N, S] of S sensors `names`."""

    t: Array
    error: Array
    std: Array
    names: Sequence[str]


@dataclass(frozen=True)
class RunCurves:
    """All that :func:`overview` shows; None or empty leaves a part out."""

    title: str
    loops: Sequence[Curve] = ()
    filtered: TorqueCurve | None = None
    smoothed: TorqueCurve | None = None
    truth: TorqueCurve | None = None
    backlash: BacklashCurve | None = None
    innovations: Innovations | None = None
    notes: Sequence[str] = ()


def overview(run: RunCurves) -> Figure:
    """Return the Figure of `run`: loop, backlash, torque (ZOOM s of it), innovations."""
    figure = Figure(figsize=(14, 10), layout='constrained')
    put_title(figure, run.title, 14)
    if run.notes:
        figure.supxlabel('   |   '.join(run.notes), fontsize=10, color=GREY)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.5, 1.0, 0.9), width_ratios=(1.0, 1.25))
    draw_loops(figure.add_subplot(grid[0, 0]), run.loops)
    if run.backlash is not None:
        draw_backlash(figure.add_subplot(grid[0, 1]), run.backlash)
    last = max((float(s.t[-1]) for s in (run.filtered, run.smoothed)
                if s is not None and len(s.t)), default=0.0)
    whole, zoom = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    begin = max(0.0, last - 1.25 * ZOOM)
    span = (begin, begin + ZOOM)
    draw_torque(whole, None, run.smoothed, run.truth, title='Transmission torque, whole run')
    whole.axvspan(*span, color=SKY, alpha=0.3, lw=0)
    draw_torque(zoom, run.filtered, run.smoothed, run.truth, span,
                f'The same, {ZOOM:g} s of it (shaded on the left)')
    if run.innovations is not None:
        count = len(run.innovations.names)
        for k in range(count):
            place = grid[2, k] if count > 1 else grid[2, :]
            draw_innovations(figure.add_subplot(place), run.innovations, k)
    for axes in figure.axes:
        if last > 0.0 and axes is not zoom and axes.get_xlabel() == 'time (s)':
            axes.set_xlim(0.0, last)
    return figure


def draw_loops(axes: Axes, curves: Sequence[Curve], title: str = 'Torque over twist',
               axis: str = 'rotary') -> None:
    """
    Draw loops over each other.

    Args:
        axes: to draw on.
        curves: the loops; black ones as a thin line.
        title: above them.
        axis: of the drive, for units.

    """
    for curve in curves:
        thin = curve.color == BLACK
        twist, tau_k = _thinned(1 if thin else 2, curve.twist, curve.tau_k)
        axes.plot(twist, tau_k, color=curve.color, label=curve.label,
                  lw=0.7 if thin else 0.0, marker='' if thin else '.', ms=3.0,
                  alpha=1.0 if thin else 0.35, zorder=3 if thin else 2)
    label_axes(axes, title, on_axis('twist: motor - arm (rad)', axis),
               on_axis(r'transmission torque $\tau_K$ (N m)', axis))
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    if curves:
        legend = axes.legend(loc='upper left', fontsize=9)
        for handle in legend.legend_handles:
            if isinstance(handle, Line2D):
                handle.set_alpha(1.0)
                if handle.get_marker() == '.':
                    handle.set_markersize(9)


def draw_backlash(axes: Axes, curve: BacklashCurve,
                  title: str = 'Backlash: alarm when a window beyond a level has ended') -> None:
    """
    Draw the measured backlash with its levels, each window from its begin to its end.

    Args:
        axes: to draw on.
        curve: windows, levels and alarms.
        title: above them.

    """
    for level, color, style, text, side in (
            (curve.error, RED, '--', 'error level', 'bottom'),
            (curve.warn, ORANGE, '--', 'warning level', 'bottom'),
            (curve.baseline, GREY, '-', 'baseline', 'top')):
        if level is not None:
            axes.axhline(level, color=color, ls=style, lw=1.2)
            axes.annotate(text, (0.995, level), xycoords=('axes fraction', 'data'), va=side,
                          ha='right', color=color, fontsize=9)
    crossings: dict[bool, float] = {}
    if curve.truth is not None:
        axes.plot(*curve.truth, color=BLACK, lw=1.0, label='true backlash')
        crossings = {is_error: float(np.interp(level, *curve.truth[::-1]))
                     for is_error, level in ((False, curve.warn), (True, curve.error))
                     if level is not None and curve.truth[1][0] < level <= curve.truth[1][-1]}
        if crossings:
            axes.plot(list(crossings.values()), np.interp(list(crossings.values()), *curve.truth),
                      'o', ms=9, mfc='none', mec=BLACK, zorder=4, label='true crossing of a level')
    axes.errorbar(np.asarray(curve.t) - 0.5 * curve.window, curve.value, xerr=0.5 * curve.window,
                  yerr=2.0 * np.asarray(curve.std), fmt='o', color=BLUE, ms=5, lw=1.5, capsize=3,
                  label=f'measured in windows of {curve.window:.3g} s, ± 2σ')
    for t, text, is_error in curve.alarms:
        color = RED if is_error else ORANGE
        late = t - crossings.get(is_error, t)
        text += f',\n{late:.1f} s after crossing' if late > 0.0 else ''
        axes.axvline(t, color=color, lw=2.0)
        axes.annotate(text, (t, 0.02), xycoords=('data', 'axes fraction'), rotation=90,
                      xytext=(-3, 0), textcoords='offset points', va='bottom', ha='right',
                      color=color, fontsize=9, fontweight='bold')
    label_axes(axes, title, 'time (s)', 'backlash (rad)')
    values = [v for v in (*curve.value, curve.error, *(curve.truth[1] if curve.truth else ()))
              if v is not None and np.isfinite(v)]
    if values and max(values) > 0.0:
        axes.set_ylim(0.0, 1.2 * max(values))
    axes.set_xlim(0.0, max(1e-3, axes.get_xlim()[1]))
    _legend(axes, loc='upper left', fontsize=9)


def draw_torque(axes: Axes, filtered: TorqueCurve | None, smoothed: TorqueCurve | None,
                truth: TorqueCurve | None, span: Span | None = None,
                title: str = 'Transmission torque') -> None:
    """
    Draw torques over time.

    Args:
        axes: to draw on.
        filtered: live estimates, or None.
        smoothed: with a band of two deviations if `span` is given, or None.
        truth: or None.
        span: (begin, end) in s; None: all.
        title: above them.

    """
    if smoothed is not None:
        t, tau_k, std = _cut(span, smoothed)
        if std is not None and span is not None:
            axes.fill_between(t, tau_k - 2.0 * std, tau_k + 2.0 * std, color=ORANGE, alpha=0.3,
                              lw=0, label='smoothed ± 2σ')
        axes.plot(t, tau_k, color=ORANGE, lw=3.0 if span else 1.5, label='smoothed')
    if filtered is not None:
        t, tau_k, _ = _cut(span, filtered)
        axes.plot(t, tau_k, color=BLUE, lw=1.2, label='filtered (live)')
    if truth is not None:
        t, tau_k, _ = _cut(span, truth)
        axes.plot(t, tau_k, color=BLACK, lw=1.0, label='true')
    label_axes(axes, title, 'time (s)', r'$\tau_K$ (N m)')
    if span is not None:
        axes.set_xlim(*span)
    _legend(axes, loc='upper right', fontsize=8, ncols=4)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.18 * (high - low))  # room for the legend


def draw_innovations(axes: Axes, innovations: Innovations, k: int) -> None:
    """
    Draw the prediction errors of one sensor with the band that should hold 95 % of them.

    Args:
        axes: to draw on.
        innovations: of all sensors.
        k: number of the sensor.

    """
    error, std = innovations.error[:, k], innovations.std[:, k]
    finite = np.isfinite(error)
    t, error, std = innovations.t[finite], error[finite], std[finite]
    coverage = 100.0 * float(np.mean(np.abs(error) <= 2.0 * std)) if len(t) else 0.0
    t, error, std = _thinned(1, t, error, std)
    axes.plot(t, error, color=BLUE, lw=0, marker=',', alpha=0.8)
    for sign in (-2.0, 2.0):
        axes.plot(t, sign * std, color=RED, lw=1.3, label='± 2σ stated' if sign > 0 else None)
    label_axes(axes, f'Prediction error of the {innovations.names[k]} encoder: '
               f'{coverage:.1f} % within ± 2σ (95 % expected)', 'time (s)',
               'error (rad)')
    if len(t):
        axes.set_ylim(*(np.array([-1.0, 1.0]) * max(4.0 * np.median(std), 1e-12)))
    _legend(axes, loc='upper right', fontsize=8)


def put_title(figure: Figure, title: str, size: int = 13) -> None:
    """
    Write a title above a picture, in as many lines as its width needs.

    Args:
        figure: the picture.
        title: one or more lines.
        size: of the letters, points; a bold one takes about .65 of it.

    """
    width = int(72.0 * figure.get_figwidth() / (0.65 * size))
    lines = [part for line in title.splitlines() for part in textwrap.wrap(line, width)]
    figure.suptitle('\n'.join(lines), fontsize=size, fontweight='bold')


def label_axes(axes: Axes, title: str, x: str, y: str, size: int = 11) -> None:
    """
    Label a plot.

    Args:
        axes: to label.
        title: above it.
        x: label of the x axis.
        y: label of the y axis.
        size: of the title.

    """
    axes.set_title(title, fontsize=size, loc='left')
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=size - 2)
    axes.grid(True, color='#dddddd', lw=0.5)
    axes.set_axisbelow(True)


def _legend(axes: Axes, **options: Any) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**options)


def _cut(span: Span | None, torque: TorqueCurve) -> tuple[Array, Array, Array | None]:
    keep = slice(None) if span is None else (torque.t >= span[0]) & (torque.t <= span[1])
    columns = (torque.t, torque.tau_k) + (() if torque.std is None else (torque.std,))
    t, tau_k, *std = _thinned(1, *(column[keep] for column in columns))
    return t, tau_k, std[0] if std else None


def _thinned(share: int, *arrays: Array) -> tuple[Array, ...]:
    """Return `arrays` with no more than MAX_POINTS / share evenly taken values each."""
    stride = max(1, share * len(arrays[0]) // MAX_POINTS)
    return tuple(np.asarray(a)[::stride] for a in arrays)


MODEL_COLORS = (RED, BLUE)  # nominal, closed
STYLES = ('--', '-')
_label = partial(label_axes, size=10)
Column: TypeAlias = tuple[str, Array, Array, Sequence[Array]]  # words, t, measured, of runs


def windows_figure(laid: Overlay, windows: Sequence[tuple[str, int]], title: str = '',
                   unit: str = 'rad') -> Figure:
    """
    Return the Figure of windows with the residuals below.

    Args:
        laid: models over a recording.
        windows: (words, number), a column each.
        title: above them.
        unit: of the encoders.

    """
    columns = [(f'{words}: {laid.t[w, 0]:.0f} to {laid.t[w, -1]:.0f} s', laid.t[w],
                laid.measured[w], [run.y[w] for run in laid.runs]) for words, w in windows]
    return _figure(laid, columns, title, unit)


def free_figure(laid: Overlay, title: str = '', unit: str = 'rad') -> Figure:
    """
    Return the Figure of one free run of each model over the whole recording.

    Args:
        laid: models over a recording.
        title: above them.
        unit: of the encoders.

    """
    runs = [np.stack([clipped_to_range(run.free[:, k], laid.recording.y[:, k]) for k in (0, 1)],
                     axis=1)
            for run in laid.runs]
    column = ('one free run', laid.recording.t, laid.recording.y, runs)
    return _figure(laid, [column], title, unit)


def _figure(laid: Overlay, columns: Sequence[Column], title: str, unit: str) -> Figure:
    figure = Figure(figsize=(7.5 * len(columns) + (3.0 if len(columns) == 1 else 0.0),
                             5.2 * len(laid.channels)), layout='constrained')
    put_title(figure, title)
    grid = figure.subplots(2 * len(laid.channels), len(columns), squeeze=False, sharex='col',
                           height_ratios=(2, 1) * len(laid.channels))
    for c, (words, t, measured, runs) in enumerate(columns):
        for r, k in enumerate(laid.channels):
            upper, lower = grid[2 * r][c], grid[2 * r + 1][c]
            upper.plot(t, measured[:, k], color=BLACK, lw=1.6, label='recording')
            for run, y, color, style in zip(laid.runs, runs, MODEL_COLORS, STYLES):
                upper.plot(t, y[:, k], color=color, ls=style, lw=1.2, label=run.name)
                r_k = measured[:, k] - y[:, k]
                lower.plot(t, r_k, color=color, lw=0.6, alpha=0.25)
                lower.plot(t, smoothed(r_k, laid.recording.dt), color=color, lw=1.6)
            lower.axhline(0.0, color=GREY, lw=0.8, ls=':')
            name = laid.recording.readings[k]
            own = unit_of(name, unit)
            _label(upper, words if r == 0 else '', '', f'{name} ({own})')
            _label(lower, '', 'time (s)' if r == len(laid.channels) - 1 else '',
                   f'recording - model\n({own})')
    handles, names = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc='outside lower center', ncols=len(names), fontsize=9)
    return figure


FILTER_ZOOM = 1.0  # s of torque over time
FILTER_COLORS = (BLUE, ORANGE, GREEN, RED, SKY, '#CC79A7', '#F0E442')


@dataclass(frozen=True)
class FilterRun:
    """One filter: t [N] s, twist [N] rad, tau_k [N] and error [N] (or None) in N m."""

    name: str
    t: Array
    twist: Array
    tau_k: Array
    error: Array | None = None


@dataclass(frozen=True)
class TrueTorque:
    """The truth: t [N] s, tau_k [N] N m, twist [N] rad or None."""

    t: Array
    tau_k: Array
    twist: Array | None = None


def comparison(runs: Sequence[FilterRun], truth: TrueTorque | None = None, title: str = '',
               axis: str = 'rotary') -> Figure:
    """
    Return the Figure of several filters.

    Args:
        runs: one per filter.
        truth: or None.
        title: above them.
        axis: of the drive, for units.

    """
    columns = min(3, len(runs))
    rows = -(-len(runs) // columns)
    figure = Figure(figsize=(14, 4.0 * rows + 6.0), layout='constrained')
    put_title(figure, title, 14)
    grid = figure.add_gridspec(rows + 1, 1, height_ratios=[1.0] * rows + [1.5])
    first = None
    for row in range(rows):
        cells = grid[row].subgridspec(1, columns)
        for column, k in enumerate(range(row * columns, min((row + 1) * columns, len(runs)))):
            axes = figure.add_subplot(cells[column], sharex=first, sharey=first)
            first = first or axes
            curves = [Curve(runs[k].twist, runs[k].tau_k, runs[k].name,
                            FILTER_COLORS[k % len(FILTER_COLORS)])]
            if truth is not None and truth.twist is not None:
                curves.append(Curve(truth.twist, truth.tau_k, 'true', BLACK))
            draw_loops(axes, curves, runs[k].name, axis)
    bottom = grid[rows].subgridspec(2, 1)
    zoom = figure.add_subplot(bottom[0])
    errors = figure.add_subplot(bottom[1], sharex=zoom)
    middle = 0.5 * (runs[0].t[0] + min(run.t[-1] for run in runs))
    span = (middle - 0.5 * FILTER_ZOOM, middle + 0.5 * FILTER_ZOOM)
    if truth is not None:
        keep = (truth.t >= span[0]) & (truth.t <= span[1])
        zoom.plot(truth.t[keep], truth.tau_k[keep], color=BLACK, lw=1.5, label='true')
    # Filters that agree lie on each other: thicker lines below let each be seen.
    for k, run in enumerate(runs):
        keep = (run.t >= span[0]) & (run.t <= span[1])
        color, width = FILTER_COLORS[k % len(FILTER_COLORS)], 1.0 + 0.8 * (len(runs) - 1 - k)
        zoom.plot(run.t[keep], run.tau_k[keep], label=run.name, color=color, lw=width)
        if run.error is not None:
            errors.plot(run.t[keep], run.error[keep], color=color, lw=width)
    zoom.set_title(f'Filtered torque, {FILTER_ZOOM:g} s of it', fontsize=11, loc='left')
    low, high = zoom.get_ylim()
    zoom.set_ylim(low, high + 0.2 * (high - low))  # room for the legend
    zoom.legend(fontsize=9, ncols=8, loc='upper left')
    zoom.set_ylabel(on_axis(r'$\tau_K$ (N m)', axis), fontsize=9)
    errors.set_title('Error against the truth' if truth is not None else
                     'No truth in the bag: no error to show', fontsize=11, loc='left')
    errors.set_ylabel(on_axis('error (N m)', axis), fontsize=9)
    errors.set_xlabel('time (s)', fontsize=9)
    for axes in (zoom, errors):
        axes.grid(True, color='#dddddd', lw=0.5)
    return figure
