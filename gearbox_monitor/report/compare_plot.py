# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Picture of several filters on one recording: loops, torque over time, errors."""
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report.plots import (
    BLACK, BLUE, Curve, draw_loops, GREEN, ORANGE, put_title, RED, SKY)

ZOOM = 1.0  # s of torque over time
COLORS = (BLUE, ORANGE, GREEN, RED, SKY, '#CC79A7', '#F0E442')


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
            curves = [Curve(runs[k].twist, runs[k].tau_k, runs[k].name, COLORS[k % len(COLORS)])]
            if truth is not None and truth.twist is not None:
                curves.append(Curve(truth.twist, truth.tau_k, 'true', BLACK))
            draw_loops(axes, curves, runs[k].name, axis)
    bottom = grid[rows].subgridspec(2, 1)
    zoom = figure.add_subplot(bottom[0])
    errors = figure.add_subplot(bottom[1], sharex=zoom)
    middle = 0.5 * (runs[0].t[0] + min(run.t[-1] for run in runs))
    span = (middle - 0.5 * ZOOM, middle + 0.5 * ZOOM)
    if truth is not None:
        keep = (truth.t >= span[0]) & (truth.t <= span[1])
        zoom.plot(truth.t[keep], truth.tau_k[keep], color=BLACK, lw=1.5, label='true')
    # Filters that agree lie on each other: thicker lines below let each be seen.
    for k, run in enumerate(runs):
        keep = (run.t >= span[0]) & (run.t <= span[1])
        color, width = COLORS[k % len(COLORS)], 1.0 + 0.8 * (len(runs) - 1 - k)
        zoom.plot(run.t[keep], run.tau_k[keep], label=run.name, color=color, lw=width)
        if run.error is not None:
            errors.plot(run.t[keep], run.error[keep], color=color, lw=width)
    zoom.set_title(f'Filtered torque, {ZOOM:g} s of it', fontsize=11, loc='left')
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
