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

"""Pictures of models laid over a recording, and of where in the motion they miss it."""
from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.identification.model_overlay import clipped_to_range, smoothed
from gearbox_monitor.report.evidence import explained_by
from gearbox_monitor.report.plots import BLACK, BLUE, GREEN, GREY, RED
from gearbox_monitor.report.words import behind, PLACES, unit_of

COLORS = (RED, BLUE)  # nominal, closed
STYLES = ('--', '-')


def windows_figure(laid, shown, title='', unit='rad'):
    """
    Return the Figure of windows of an Overlay, residuals below.

    shown: [(words, window)], a column each.
    """
    columns = [(f'{words}: {laid.t[w, 0]:.0f} to {laid.t[w, -1]:.0f} s', laid.t[w],
                laid.measured[w], [run.y[w] for run in laid.runs]) for words, w in shown]
    return _figure(laid, columns, title, unit)


def free_figure(laid, title='', unit='rad'):
    """Return the Figure of one free run of each model over the whole recording."""
    runs = [np.stack([clipped_to_range(run.free[:, k], laid.recording.y[:, k]) for k in (0, 1)],
                     axis=1)
            for run in laid.runs]
    column = ('one free run', laid.recording.t, laid.recording.y, runs)
    return _figure(laid, [column], title, unit)


def maps_figure(evidence, title=''):
    """Return the Figure of the residual over the motion, from report.evidence.Evidence."""
    missing, labels = evidence.missing, evidence.labels
    rows = 2 if missing else 1
    figure = Figure(figsize=(15, 3.6 * rows + 0.6), layout='constrained')
    figure.suptitle(title, fontsize=13, fontweight='bold')
    grid = figure.subplots(rows, len(labels), squeeze=False)
    for k, (name, label) in enumerate(labels.items()):
        axes = grid[0][k]
        for run, color, style, found in zip(evidence.overlay.runs, COLORS, STYLES,
                                            evidence.maps[name]):
            axes.stairs(found.rms, found.edges, color=color, ls=style, lw=1.6, label=run.name,
                        baseline=None)
        axes.axhline(1.0, color=GREY, lw=0.8, ls=':')
        _label(axes, f'gap over {name}', label, 'gap (1: noise)' if k == 0 else '')
        if missing:
            found, axes = missing.laws[name], grid[1][k]
            axes.fill_between(found.centers, found.value - 2.0 * found.error,
                              found.value + 2.0 * found.error, color=GREEN, alpha=0.2, lw=0)
            axes.plot(found.centers, found.value, color=GREEN, lw=1.8)
            axes.axhline(0.0, color=GREY, lw=0.8, ls=':')
            place = PLACES[missing.place]
            _label(axes, f'missing at {place} {explained_by(name, found)}', label,
                   f'{missing.unit}, 2 standard errors' if k == 0 else '')
    grid[0][0].legend(fontsize=8)
    return figure


def ranking_figure(gains, named, title='', most=12):
    """Return the Figure of `gains` {effect: gain over the plain model}; `named` stands out."""
    best = sorted(gains, key=gains.get, reverse=True)[:most][::-1]
    figure = Figure(figsize=(9, 0.34 * len(best) + 1.4), layout='constrained')
    figure.suptitle(title, fontsize=13, fontweight='bold')
    axes = figure.subplots()
    bars = axes.barh(best, [max(gains[name], 0.0) for name in best],
                     color=[BLUE if name == named else '#9cc4dd' for name in best])
    axes.bar_label(bars, [behind(gains, name) for name in best], padding=4, fontsize=8)
    axes.set_xlim(right=1.25 * max(1.0, *(gains[name] for name in best)))
    axes.spines[['top', 'right']].set_visible(False)
    _label(axes, '', 'gain over the plain model: 2 log likelihood less a price per parameter', '')
    return figure


def _figure(laid, columns, title, unit):
    figure = Figure(figsize=(7.5 * len(columns) + (3.0 if len(columns) == 1 else 0.0),
                             5.2 * len(laid.channels)), layout='constrained')
    figure.suptitle(title, fontsize=13, fontweight='bold')
    grid = figure.subplots(2 * len(laid.channels), len(columns), squeeze=False, sharex='col',
                           height_ratios=(2, 1) * len(laid.channels))
    for c, (words, t, measured, runs) in enumerate(columns):
        for r, k in enumerate(laid.channels):
            over, left = grid[2 * r][c], grid[2 * r + 1][c]
            over.plot(t, measured[:, k], color=BLACK, lw=1.6, label='recording')
            for run, y, color, style in zip(laid.runs, runs, COLORS, STYLES):
                over.plot(t, y[:, k], color=color, ls=style, lw=1.2, label=run.name)
                r_k = measured[:, k] - y[:, k]
                left.plot(t, r_k, color=color, lw=0.6, alpha=0.25)
                left.plot(t, smoothed(r_k, laid.recording.dt), color=color, lw=1.6)
            left.axhline(0.0, color=GREY, lw=0.8, ls=':')
            name = laid.recording.readings[k]
            own = unit_of(name, unit)
            _label(over, words if r == 0 else '', '', f'{name} ({own})')
            _label(left, '', 'time (s)' if r == len(laid.channels) - 1 else '',
                   f'recording - model\n({own})')
    handles, names = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc='outside lower center', ncols=len(names), fontsize=9)
    return figure


def _label(axes, title, x, y):
    axes.set_title(title, fontsize=10, loc='left')
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(True, color='#dddddd', lw=0.5)
    axes.set_axisbelow(True)
