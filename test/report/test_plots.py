# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures from arrays, also from few or none."""
from dataclasses import replace

from matplotlib.figure import Figure
import numpy as np
import pytest

from gearbox_monitor.report import plots


def example(n):
    t = np.linspace(0.0, 10.0, n)
    tau_k = np.sin(t)
    errors = np.column_stack([0.01 * np.cos(50.0 * t), np.full(n, np.nan)])
    torque = plots.TorqueCurve(t, tau_k, np.full(n, 0.1))
    backlash = plots.BacklashCurve(
        np.arange(n)[:3], np.full(min(n, 3), 0.2), np.full(min(n, 3), 0.01), 1.0, 0.2, 0.22, 0.25,
        ((2.0, 'warn', False),))
    return plots.RunCurves(
        'Title', (plots.Curve(tau_k, tau_k, 'loop'),), torque, torque, None, backlash,
        plots.Innovations(t, errors, np.full((n, 2), 0.01), ('motor', 'arm')))


RUNS = [
    example(20000), example(1), example(0), plots.RunCurves('nothing')]


@pytest.mark.filterwarnings('error')
def test_overview_is_drawn(tmp_path):
    for run in RUNS:
        figure = plots.overview(run)
        figure.savefig(tmp_path / 'run.png', dpi=50)
        assert (tmp_path / 'run.png').read_bytes()[:4] == b'\x89PNG'


def test_backlash_axis_shows_levels_and_alarms():
    (axes,) = [a for a in plots.overview(example(100)).axes if 'Backlash' in a.get_title('left')]
    lines = [line.get_xydata().tolist() for line in axes.lines]
    assert all(any(level in np.ravel(line) for line in lines) for level in (0.2, 0.22, 0.25, 2.0))
    assert axes.get_ylim()[1] > 0.25


def test_alarms_say_how_long_after_the_true_crossing_and_times_are_aligned():
    run = example(20000)
    t = np.array([0.0, 10.0, 30.0])
    curve = replace(run.backlash, alarms=((19.0, 'warn', False), (25.0, 'error', True)),
                    truth=(t, np.array([0.2, 0.2, 0.3])))  # 0.22 after 14 s, 0.25 after 20 s
    figure = plots.overview(replace(run, backlash=curve))
    axes = figure.axes[1]
    shown = ' '.join(text.get_text() for text in axes.texts)
    assert 'warn,\n5.0 s after' in shown and 'error,\n5.0 s after' in shown
    whole = [a for a in figure.axes if a.get_xlabel() == 'time (s)' and 'shaded' not in
             a.get_title('left')]
    assert len(whole) == 4 and len({a.get_xlim() for a in whole}) == 1


def test_long_runs_are_thinned():
    run = example(100_000)
    for axes in plots.overview(run).axes:
        assert all(len(line.get_xdata()) <= 2 * plots.MAX_POINTS for line in axes.lines)


def test_a_long_title_stays_inside_its_picture():
    for inches, size in ((9.0, 13), (15.0, 13), (15.0, 14)):
        figure = Figure(figsize=(inches, 4.0), layout='constrained')
        figure.subplots()
        words = "The gearbox's hysteresis torque is 0.0321 N m; the model has none. "
        plots.put_title(figure, 4 * words + '\nWITH WIDE LETTERS', size)
        figure.draw_without_rendering()
        box = figure._suptitle.get_window_extent()
        assert box.x0 > 0.0 and box.x1 < figure.bbox.x1 and box.y1 < figure.bbox.y1
        assert figure.get_suptitle().endswith('\nWITH WIDE LETTERS')
