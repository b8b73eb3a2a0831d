# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of models laid over a recording, and of where in the motion they miss it."""
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TypeAlias

from matplotlib.figure import Figure
import numpy as np

from gearbox_monitor.diagnosis.joint.model_overlay import Overlay
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.report.diagnosis_evidence import DiagnosisEvidence, explained_by
from gearbox_monitor.report.plots import BLACK, BLUE, GREEN, GREY, label_axes, put_title, RED
from gearbox_monitor.report.residual_views import clipped_to_range, smoothed
from gearbox_monitor.report.summary import PLACES
from gearbox_monitor.report.words import gain_text, unit_of

COLORS = (RED, BLUE)  # nominal, closed
STYLES = ('--', '-')
RANKED = 12  # effects
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


def maps_figure(evidence: DiagnosisEvidence, title: str = '') -> Figure:
    """Return the Figure of the residual over the motion in `evidence`, with `title`."""
    missing, labels = evidence.missing, evidence.labels
    rows = 2 if missing else 1
    figure = Figure(figsize=(15, 3.6 * rows + 0.6), layout='constrained')
    put_title(figure, title)
    grid = figure.subplots(rows, len(labels), squeeze=False)
    for k, (name, label) in enumerate(labels.items()):
        axes = grid[0][k]
        for run, color, style, residual in zip(evidence.overlay.runs, COLORS, STYLES,
                                               evidence.maps[name]):
            axes.stairs(residual.rms, residual.edges, color=color, ls=style, lw=1.6,
                        label=run.name, baseline=None)
        axes.axhline(1.0, color=GREY, lw=0.8, ls=':')
        _label(axes, f'gap over {name}', label, 'gap (1: noise)' if k == 0 else '')
        if missing:
            law, axes = missing.laws[name], grid[1][k]
            axes.fill_between(law.centers, law.value - 2.0 * law.error,
                              law.value + 2.0 * law.error, color=GREEN, alpha=0.2, lw=0)
            axes.plot(law.centers, law.value, color=GREEN, lw=1.8)
            axes.axhline(0.0, color=GREY, lw=0.8, ls=':')
            place = PLACES[missing.place]
            _label(axes, f'missing at {place} {explained_by(name, law)}', label,
                   f'{missing.unit}, 2 standard errors' if k == 0 else '')
    grid[0][0].legend(fontsize=8)
    return figure


def ranking_figure(gains: Mapping[str, float], effect: str | None, title: str) -> Figure:
    """
    Return the Figure of gains.

    Args:
        gains: {effect: gain over the nominal model}.
        effect: the one of the verdict, which stands out.
        title: above them.

    """
    ranking = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED][::-1]
    figure = Figure(figsize=(9, 0.34 * len(ranking) + 1.4), layout='constrained')
    put_title(figure, title)
    axes = figure.subplots()
    bars = axes.barh(ranking, [max(gains[name], 0.0) for name in ranking],
                     color=[BLUE if name == effect else '#9cc4dd' for name in ranking])
    axes.bar_label(bars, [gain_text(gains, name) for name in ranking], padding=4, fontsize=8)
    axes.set_xlim(right=1.25 * max(1.0, *(gains[name] for name in ranking)))
    axes.spines[['top', 'right']].set_visible(False)
    _label(axes, '',
           'gain over the nominal model: 2 log likelihood less a penalty per parameter', '')
    return figure


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
            for run, y, color, style in zip(laid.runs, runs, COLORS, STYLES):
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
