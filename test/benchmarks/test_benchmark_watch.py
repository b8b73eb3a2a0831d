# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of the watch in small: one arm, each planted change."""
import json
from types import SimpleNamespace

from benchmarks import watch_robots
import pytest


@pytest.mark.benchmark
def test_each_planted_change_is_named_and_nothing_else(tmp_path):
    out = tmp_path / 'rows.json'
    args = SimpleNamespace(seeds=[201], kinds=[*watch_robots.SIZES], hours=0.0, accelerated=1,
                           load=None, json=str(out))
    assert watch_robots.run(args) == 0
    rows = json.loads(out.read_text())
    assert [row['kind'] for row in rows] == args.kinds
    for row in rows:
        assert {place for _, place, _ in row['raised']} == {row['joint']}
        assert 0 <= min(k for k, *_ in row['raised']) < watch_robots.AFTER
        assert row['within_2_std'] > 0.9
