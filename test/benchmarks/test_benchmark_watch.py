# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of the watch in small: three arms with each planted change, a healthy day."""
import json
from types import SimpleNamespace

import pytest

from benchmarks import watch_robots

pytestmark = pytest.mark.benchmark


def rows_of(folder, seeds, kinds, hours=0.0):
    """Return the rows of the benchmark."""
    out = folder / 'rows.json'
    watch_robots.run(SimpleNamespace(
        seeds=seeds, kinds=kinds, hours=hours, accelerated=14, load=None, json=str(out)))
    return json.loads(out.read_text())


def test_planted_changes_are_named_at_their_joint(tmp_path):
    rows = rows_of(tmp_path, [201, 202, 203], [*watch_robots.SIZES])
    assert len(rows) == 15 and sum(row['right'] for row in rows) >= 14
    assert sum(row['within_2_std'] for row in rows) / len(rows) >= 0.93
    for row in rows:
        assert all(place == row['joint'] and 0 <= block < watch_robots.AFTER
                   for block, place, _ in row['raised'])


def test_a_healthy_day_raises_nothing(tmp_path):
    row, = rows_of(tmp_path, [213], [], 24.0)
    assert not row['raised'] and row['judged'] and row['within_2_std'] >= 0.93
