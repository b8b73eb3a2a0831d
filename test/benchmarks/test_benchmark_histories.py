# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Two events at once, as `benchmarks histories` draws them: each has its size."""
import pytest

from benchmarks.histories import healthy, LEARNT, Life, one_percent, PAIRS, verdict


@pytest.mark.system
@pytest.mark.parametrize('pair', PAIRS)
def test_each_of_two_events_at_once_has_its_size(pair):
    for turn in range(3):
        life = Life(1_100_033 + PAIRS.index(pair) + turn * len(PAIRS))
        life.go(LEARNT)
        assert not life.health.alerts
        pair(life)
        assert verdict(life) == ('right', '')


@pytest.mark.system
def test_one_percent_of_backlash_is_found_within_ten_windows():
    delays = [one_percent(7063 + k) for k in range(6)]
    assert all(delay and delay <= 10 for delay in delays) and sum(delays) <= 36


@pytest.mark.system
def test_six_healthy_hours_of_motions_and_temperatures_raise_no_alert():
    assert healthy(77, 2160)[0] == 0
