# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Charts of many, few or no values."""
import numpy as np
import pytest

from gearbox_monitor.report import chart as charts
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
def test_few_or_no_values_are_drawn():
    for (chart, plane), in (example(20_000), example(2), example(0)):
        assert 'nan' not in str(charts.chart_view(chart)['panels']) + str(charts.plane_view(plane))


def test_long_curves_are_thinned_and_keep_their_extremes():
    chart, _ = example(100_000)[0]
    assert all(len(trace.points()[0]) < 10_000 for trace in chart.traces())
    x, y = np.arange(100_000.0), np.zeros(100_000)
    y[54321] = 1.0
    at = thinned_rows(y, 1000)
    a, b = x[at], y[at]
    assert len(a) <= 1010 and b.max() == 1.0 and a[0] == 0.0 and a[-1] == x[-1]
