# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Charts by matplotlib, also of few or no values, against the charts of a page."""
from pathlib import Path
import re

from matplotlib.figure import Figure
import numpy as np
import pytest

import gearbox_monitor
from gearbox_monitor.report import plots, svg
from gearbox_monitor.report.chart import (
    Chart, Lane, LoopSlice, Mark, Panel, Plane, thinned_rows, Trace)


def example(n):
    t = np.linspace(0.0, 10.0, n)
    y = np.sin(t)
    y[n // 2:n // 2 + 2] = np.nan
    return [[
        Chart('torque', [
            Panel('N m', [Trace(t, y, 'smoothed', 'signal', band=(y - 0.1, y + 0.1)),
                          Trace(t, y, '', 'closed faint')], 0.0),
            Panel('rad', [Trace(t, y, 'windows', 'closed', dots=True, band=(y - 0.1, y + 0.1)),
                          Trace(np.append(t, 11.0), y, 'judged', 'nominal', step=True)]),
            Lane('trust', [0.0, 2.0], 5.0, [0, 2], ['OK', 'ERROR'])],
            'time (s)', [Mark(2.0, 'warning', 'warn')], span=(0.0, 12.0)),
        Plane('loop', [LoopSlice('first', (t[:400], y[:400]), [(t[:9], y[:9])]),
                       LoopSlice('last', (t[:9], 2.0 * y[:9]))], 'twist', 'torque')]]


@pytest.mark.filterwarnings('error')
def test_few_or_no_values_are_drawn(tmp_path):
    for rows in (example(20_000), example(2), example(0), []):
        plots.figure(rows, 'Title').savefig(tmp_path / 'run.png', dpi=50)
        assert (tmp_path / 'run.png').read_bytes()[:4] == b'\x89PNG'
        for chart in (part for row in rows for part in row if isinstance(part, Chart)):
            assert 'nan' not in str(svg.chart_view(chart)['panels'])


def test_page_and_picture_have_the_same_scales_and_colours():
    rows = example(1000)
    chart, plane = rows[0]
    torque, windows, lane, loop = plots.figure(rows).axes
    view, flat = svg.chart_view(chart), svg.plane_view(plane)
    for axes, panel in zip((torque, windows, lane), view['panels']):
        assert axes.get_ylim() == pytest.approx((float(panel['low']), float(panel['high'])))
        assert axes.get_xlim() == (float(view['first']), float(view['last'])) == (0.0, 12.0)
    assert loop.get_xlim() == pytest.approx((float(flat['x_low']), float(flat['x_high'])))
    assert 2.0 in np.ravel([line.get_xdata() for line in windows.lines if len(
        line.get_xdata()) == 2])  # the mark is drawn through all panels
    style = Path(gearbox_monitor.__file__).with_name('report').joinpath(
        'assets/page.css').read_text(encoding='utf-8')
    light = dict(re.findall(r'--(\w+): (#\w+)', style[:style.index('@media')]))
    assert {name: light[name] for name in plots.COLOURS} == plots.COLOURS


def test_long_curves_are_thinned_and_keep_their_extremes():
    for axes in plots.figure(example(100_000)).axes:
        assert all(len(line.get_xdata()) < 10_000 for line in axes.lines)
    x, y = np.arange(100_000.0), np.zeros(100_000)
    y[54321] = 1.0
    at = thinned_rows(y, 1000)
    a, b = x[at], y[at]
    assert len(a) <= 1010 and b.max() == 1.0 and a[0] == 0.0 and a[-1] == x[-1]


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
