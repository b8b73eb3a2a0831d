# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The newest rows, against all rows that ever came."""
import numpy as np

from gearbox_monitor.health.monitor import BLOCK, ROOM, RowHistory


def test_rows_of_any_interval_that_is_kept():
    rng, history, span = np.random.default_rng(0), RowHistory(), 500
    stamps, rows = np.cumsum(rng.integers(1, 5, 20_000)), rng.normal(size=(20_000, 3))
    at = 0
    while at < len(stamps):
        end = at + int(rng.integers(1, 40))
        newest = int(stamps[at:end][-1])
        history.add(stamps[at:end], rows[at:end], newest - span)
        at = end
        first, last = np.sort(rng.integers(max(newest - span, 0), newest + 2, 2))
        inside = (stamps[:at] >= first) & (stamps[:at] < last)
        part = history.between(int(first), int(last))
        np.testing.assert_array_equal(part[0], stamps[:at][inside])
        np.testing.assert_array_equal(part[1], rows[:at][inside])
        np.testing.assert_array_equal(history.after(int(first)), rows[:at][stamps[:at] > first])
        assert len(history) <= max(BLOCK, ROOM * (span + 40))


def test_a_clock_that_is_set_back_leaves_only_what_follows():
    history = RowHistory()
    history.add(np.arange(100, 200), np.zeros((100, 2)), 0)
    history.add(np.arange(150, 160), np.ones((10, 2)), 0)
    np.testing.assert_array_equal(history.stamps, np.arange(150, 160))
    np.testing.assert_array_equal(history.after(0), np.ones((10, 2)))
