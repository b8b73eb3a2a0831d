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
Pictures of a run: torque over twist, torque, gap and prediction errors over time.

Functions draw arrays on matplotlib axes; nothing here knows bags or ROS. No pyplot: no state, no
display. Colours of Okabe and Ito, which colour-blind people can tell apart.
"""
from dataclasses import dataclass, field

from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.plant.units import on_axis

BLUE, ORANGE, GREEN, RED, SKY = '#0072B2', '#E69F00', '#009E73', '#D55E00', '#56B4E9'
BLACK, GREY = '#000000', '#777777'
MAX_POINTS = 6000  # more cannot be seen, but make the file large


@dataclass(frozen=True)
class Curve:
    """One loop: twist [N] rad, tau_k [N] N m, and what it is called."""

    twist: np.ndarray
    tau_k: np.ndarray
    label: str
    color: str = BLUE


@dataclass(frozen=True)
class Torque:
    """Torque over time: t [N] s, tau_k [N] N m, std [N] N m or None."""

    t: np.ndarray
    tau_k: np.ndarray
    std: np.ndarray = None


@dataclass(frozen=True)
class Gap:
    """
    Gap of consecutive windows, each ending at t [W] s: value [W] and std [W] in rad.

    baseline, warn, error: levels (rad) or None. alarms: (t, text, is_error). truth: (t, gap).
    """

    t: np.ndarray
    value: np.ndarray
    std: np.ndarray
    window: float
    baseline: float = None
    warn: float = None
    error: float = None
    alarms: tuple = ()
    truth: tuple = None


@dataclass(frozen=True)
class Innovations:
    """Prediction errors over time: t [N] s, error [N, S] and std [N, S] of S sensors `names`."""

    t: np.ndarray
    error: np.ndarray
    std: np.ndarray
    names: tuple
    unit: str = 'rad'


@dataclass(frozen=True)
class Run:
    """All that :func:`overview` shows; None or empty leaves a part out."""

    title: str
    loops: tuple = ()
    filtered: Torque = None
    smoothed: Torque = None
    truth: Torque = None
    gap: Gap = None
    innovations: Innovations = None
    notes: tuple = field(default=())


def overview(run, zoom_seconds=2.0):
    """Return the Figure of `run`: loop, gap, torque (a stretch of `zoom_seconds`), innovations."""
    figure = Figure(figsize=(14, 10), layout='constrained')
    figure.suptitle(run.title, fontsize=14, fontweight='bold')
    if run.notes:
        figure.supxlabel('   |   '.join(run.notes), fontsize=10, color=GREY)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.5, 1.0, 0.9), width_ratios=(1.0, 1.25))
    draw_loops(figure.add_subplot(grid[0, 0]), run.loops)
    if run.gap is not None:
        draw_gap(figure.add_subplot(grid[0, 1]), run.gap)
    last = max((s.t[-1] for s in (run.filtered, run.smoothed) if s is not None and len(s.t)),
               default=0.0)
    middle = grid[1, :].subgridspec(1, 2, width_ratios=(1.0, 1.25))
    whole, zoom = figure.add_subplot(middle[0, 0]), figure.add_subplot(middle[0, 1])
    begin = max(0.0, last - 1.25 * zoom_seconds)
    span = (begin, begin + zoom_seconds)
    draw_torque(whole, None, run.smoothed, run.truth, title='Transmission torque, whole run')
    whole.axvspan(*span, color=SKY, alpha=0.3, lw=0)
    draw_torque(zoom, run.filtered, run.smoothed, run.truth, span,
                f'The same, {zoom_seconds:g} s of it (shaded on the left)')
    if run.innovations is not None:
        count = len(run.innovations.names)
        row = grid[2, :].subgridspec(1, count)
        for k in range(count):
            draw_innovations(figure.add_subplot(row[0, k]), run.innovations, k)
    return figure


def save(figure, path, dpi=110):
    """Write `figure` to `path`, in the format of its suffix."""
    figure.savefig(path, dpi=dpi)


def draw_loops(axes, curves, title='Torque over twist', axis='rotary'):
    """Draw the loops `curves` over each other."""
    for curve in curves:
        thin = curve.color == BLACK
        twist, tau_k = _thinned(1 if thin else 2, curve.twist, curve.tau_k)
        axes.plot(twist, tau_k, color=curve.color, label=curve.label,
                  lw=0.7 if thin else 0.0, marker='' if thin else '.', ms=3.0,
                  alpha=1.0 if thin else 0.35, zorder=3 if thin else 2)
    _label(axes, title, on_axis('twist: motor - arm (rad)', axis),
           on_axis(r'transmission torque $\tau_K$ (N m)', axis))
    axes.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    if curves:
        legend = axes.legend(loc='upper left', fontsize=9)
        for handle in legend.legend_handles:
            handle.set_alpha(1.0)
            if handle.get_marker() == '.':
                handle.set_markersize(9)


def draw_gap(axes, gap, title='Width of the gap (backlash)'):
    """Draw the measured gap with its levels, each window from its begin to its end."""
    for level, color, style, text, side in (
            (gap.error, RED, '--', 'error level', 'bottom'),
            (gap.warn, ORANGE, '--', 'warning level', 'bottom'),
            (gap.baseline, GREY, '-', 'baseline', 'top')):
        if level is not None:
            axes.axhline(level, color=color, ls=style, lw=1.2)
            axes.annotate(text, (0.005, level), xycoords=('axes fraction', 'data'), va=side,
                          color=color, fontsize=9)
    if gap.truth is not None:
        axes.plot(*gap.truth, color=BLACK, lw=1.0, label='true gap')
    axes.errorbar(np.asarray(gap.t) - 0.5 * gap.window, gap.value, xerr=0.5 * gap.window,
                  yerr=2.0 * np.asarray(gap.std), fmt='o', color=BLUE, ms=5, lw=1.5, capsize=3,
                  label=f'measured in windows of {gap.window:.3g} s, ± 2σ')
    for t, text, is_error in gap.alarms:
        color = RED if is_error else ORANGE
        axes.axvline(t, color=color, lw=2.0)
        axes.annotate(text, (t, 0.02), xycoords=('data', 'axes fraction'), rotation=90,
                      xytext=(-3, 0), textcoords='offset points', va='bottom', ha='right',
                      color=color, fontsize=9, fontweight='bold')
    _label(axes, title, 'time (s)', 'gap (rad)')
    values = [v for v in (*gap.value, gap.error, *(gap.truth[1] if gap.truth else ()))
              if v is not None and np.isfinite(v)]
    if values and max(values) > 0.0:
        axes.set_ylim(0.0, 1.2 * max(values))
    axes.set_xlim(0.0, max(1e-3, axes.get_xlim()[1]))
    _legend(axes, loc='upper left', fontsize=9)


def draw_torque(axes, filtered, smoothed, truth, span=None, title='Transmission torque'):
    """Draw torques, each a Torque or None, between the times `span` (s) or whole."""
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
    _label(axes, title, 'time (s)', r'$\tau_K$ (N m)')
    if span is not None:
        axes.set_xlim(*span)
    _legend(axes, loc='upper right', fontsize=8, ncols=4)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.18 * (high - low))  # room for the legend


def draw_innovations(axes, innovations, k, title=None):
    """Draw the prediction errors of sensor `k` with the band that should hold 95 % of them."""
    error, std = innovations.error[:, k], innovations.std[:, k]
    seen = np.isfinite(error)
    t, error, std = innovations.t[seen], error[seen], std[seen]
    inside = 100.0 * float(np.mean(np.abs(error) <= 2.0 * std)) if len(t) else 0.0
    t, error, std = _thinned(1, t, error, std)
    axes.plot(t, error, color=BLUE, lw=0, marker=',', alpha=0.8)
    for sign in (-2.0, 2.0):
        axes.plot(t, sign * std, color=RED, lw=1.3, label='± 2σ stated' if sign > 0 else None)
    _label(axes, title or f'Prediction error of the {innovations.names[k]} encoder: '
           f'{inside:.1f} % within ± 2σ (95 % expected)', 'time (s)',
           f'error ({innovations.unit})')
    if len(t):
        axes.set_ylim(*(np.array([-1.0, 1.0]) * max(4.0 * np.median(std), 1e-12)))
    _legend(axes, loc='upper right', fontsize=8)


def _label(axes, title, x, y):
    axes.set_title(title, fontsize=11, loc='left')
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=9)
    axes.grid(True, color='#dddddd', lw=0.5)
    axes.set_axisbelow(True)


def _legend(axes, **options):
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**options)


def _cut(span, torque):
    t = torque.t
    keep = slice(None) if span is None else (t >= span[0]) & (t <= span[1])
    std = None if torque.std is None else torque.std[keep]
    t, tau_k = t[keep], torque.tau_k[keep]
    if std is None:
        return (*_thinned(1, t, tau_k), None)
    return _thinned(1, t, tau_k, std)


def _thinned(share, *arrays):
    """Return `arrays` with no more than MAX_POINTS / share evenly taken values each."""
    stride = max(1, share * len(arrays[0]) // MAX_POINTS)
    return tuple(np.asarray(a)[::stride] for a in arrays)
