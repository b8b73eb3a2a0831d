# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of the watch in small: three arms, each planted change."""
import json
from types import SimpleNamespace

from benchmarks import watch_robots
import pytest


@pytest.mark.benchmark
def test_planted_changes_are_named_at_their_joint(tmp_path):
    out = tmp_path / 'rows.json'
    watch_robots.run(SimpleNamespace(
        seeds=[201, 202, 203], kinds=[*watch_robots.SIZES], hours=0.0, accelerated=1, load=None,
        json=str(out)))
    rows = json.loads(out.read_text())
    assert len(rows) == 15 and sum(row['right'] for row in rows) >= 14
    assert sum(row['within_2_std'] for row in rows) / len(rows) >= 0.93
    for row in rows:
        assert all(place == row['joint'] and 0 <= block < watch_robots.AFTER
                   for block, place, _ in row['raised'])
