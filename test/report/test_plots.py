# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures from arrays, also from few or none."""
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


@pytest.mark.parametrize('run', [
    example(20000), example(1), example(0), plots.RunCurves('nothing')])
@pytest.mark.filterwarnings('error')
def test_overview_is_drawn(run, tmp_path):
    figure = plots.overview(run)
    plots.save(figure, tmp_path / 'run.png', dpi=50)
    assert (tmp_path / 'run.png').read_bytes()[:4] == b'\x89PNG'


def test_backlash_axis_shows_levels_and_alarms():
    (axes,) = [a for a in plots.overview(example(100)).axes if 'Backlash' in a.get_title('left')]
    lines = [line.get_xydata().tolist() for line in axes.lines]
    assert all(any(level in np.ravel(line) for line in lines) for level in (0.2, 0.22, 0.25, 2.0))
    assert axes.get_ylim()[1] > 0.25


def test_long_runs_are_thinned():
    run = example(100_000)
    for axes in plots.overview(run).axes:
        assert all(len(line.get_xdata()) <= 2 * plots.MAX_POINTS for line in axes.lines)
