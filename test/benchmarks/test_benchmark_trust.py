# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The benchmark of trust and drift: its statistics, its pieces in small, its verdict."""
from dataclasses import replace
import json

import numpy as np
import pytest

from benchmarks import intervals, trust, trust_drift, trust_runs
from benchmarks.__main__ import main
from benchmarks.harness import BarTable
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import Level, Outcome
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.health_record import HealthSettings
from gearbox_monitor.health.judgement import Health
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise


def test_intervals():
    # Wilson, E. B. (1927): 8 of 10; zero of 10; rule of three.
    assert intervals.share(8, 10) == pytest.approx([0.4902, 0.9433], abs=1e-4)
    assert intervals.share(0, 10) == pytest.approx([0.0, 0.2775], abs=1e-4)
    assert intervals.rate(0, 2.0) == pytest.approx([0.0, 3.6889 / 2], abs=1e-4)
    assert intervals.rate(4, 1.0) == pytest.approx([1.0899, 10.2416], abs=1e-4)
    x = np.random.default_rng(1).normal(3.0, 2.0, 400)
    low, high = intervals.mean(x)
    assert low < x.mean() < high and high - low == pytest.approx(4 * 2.0 / 20, rel=0.15)
    low, high = intervals.spread(x)
    assert low < x.std(ddof=1) < high and high / low == pytest.approx(1.15, abs=0.01)
    assert intervals.mean([5.0]) == [5.0, 5.0]


def watched(levels, at=None):
    at = np.arange(1.0, len(levels) + 1) if at is None else at
    return trust_runs.MonitoredRun({}, np.empty(0), at, {'input': np.array(levels)}, [], 1.0)


def test_alarms_and_delays_are_counted():
    assert watched([0, 0, 1, 2, 0, 1]).alarms() == {'input': 2}
    assert watched([1, 0, 0]).alarms() == {'input': 0}  # no data at the start is no alarm
    assert watched([1, 1, 1]).alarms() == {'input': 1}  # never OK is one
    assert watched([0, 0, 0, 0, 1]).delay(2.5) == (2.5, 'input')
    assert watched([0, 0, 0]).delay(1.5) == (None, None)
    assert watched([0, 1, 1, 1]).delay(2.5) == (None, None)  # it was there before


def test_windows_are_drawn_in_time_and_followed(monkeypatch):
    windows = [Backlash(k, 1.0 + k, 0.1, 5.0, 0.1) for k in range(20)]
    drawn = trust_drift.drawn(windows, 15, np.random.default_rng(0))
    assert set(np.diff([w.stamp_ns for w in drawn])) == {10_000_000_000}
    steps = np.diff([w.gap for w in drawn])
    assert (steps.reshape(-1)[:5] == 1.0).all()  # a block keeps its order

    begin, raised = Health(HealthSettings()), [0, 1, 1, 0, 2, 0]

    def judged(health, window):
        assert window.stamp_ns > health.stamp_ns
        return replace(health, stamp_ns=window.stamp_ns)
    monkeypatch.setattr(trust_drift, 'judge', judged)
    monkeypatch.setattr(judgement, 'outcomes',
                        lambda health: {'backlash': Outcome(Level(raised.pop(0)), ())})
    assert trust_drift.false_alarms(begin, trust_drift.later(windows[:6], begin)) == 2


def test_gap_and_growth_of_a_play_count_its_width():
    play = DriveModel().with_(kind='play', half_gap=0.3, hysteresis_width=0.3)
    assert trust_drift.true_gap(play) == pytest.approx(1.2)
    assert trust_drift.half_gap_growth(play, 0.01) == pytest.approx(0.02)
    assert trust_drift.half_gap_growth(DriveModel(), 0.01) == pytest.approx(0.01)


def test_a_watched_drive_is_healthy_until_its_fault():
    packaged = trust_runs.packaged_drive()
    assert packaged.model.effects and not packaged.assumed.effects
    start = 9.4
    due = trust_runs.faults(packaged.noise)['arm frozen'](start)
    found = trust_runs.watch(packaged, 20.0, 3, due)
    late = found.began >= start
    assert not found.any()[found.began < start - 0.5].any()
    assert found.any()[late].mean() > 0.9
    delay, _ = found.delay(start)
    assert 0.0 < delay < 8.0
    # It is the same however often it is run.
    again = trust_runs.watch(packaged, 20.0, 3, due)
    assert all(np.array_equal(found.flags[t], again.flags[t]) for t in trust_runs.TESTS)


def test_a_table_judges_its_rows():
    drive = trust_runs.SimulatedDrive(
        'B', DriveModel(), Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.005)), DriveModel(),
        {'arm_load': 'none', 'q_std_tau_k': 8.0})
    run = trust_runs.watch(drive, 8.0, 1)
    bars = BarTable()
    rows = trust.healthy_table({'B': run}, {'healthy': 8.0}, bars)
    assert rows[0]['windows'] == 10 and len(bars.rows) == 2
    bars.judge('low', 0.5, low=0.6)
    bars.judge('between', 0.5, 0.4, 0.6)
    assert [b['met'] for b in bars.rows[2:]] == [False, True]
    assert bars.rows[3]['expected'] == '0.4 .. 0.6'


@pytest.mark.parametrize('met, code', [(True, 0), (False, 1)])
def test_a_missed_bar_ends_with_1(monkeypatch, capsys, tmp_path, met, code):
    def evaluate(size, full, data, progress):
        assert size['faults'] == 3 and size['healthy'] < 3600 and not full and data is None
        bars = BarTable()
        bars.judge('a bar', 0.5, high=1.0 if met else 0.1, interval=[0.4, 0.6])
        return {'bars': bars.rows, 'faults': {}, 'gap': {}, 'drift': {}, 'tolerances': [],
                'healthy': [{
                    'drive': 'A', 'windows': 10, 'hours': 0.1, 'any': 0.0, 'interval': [0.0, 0.2],
                    'alarms': 0, 'alarms_of': {}, **dict.fromkeys(trust_runs.TESTS, 0.0)}],
                'cost': {'step_us': 1.0, 'trust': 0.1, 'monitor': 1.1, 'all': 5.0}}
    monkeypatch.setattr(trust, 'evaluate', evaluate)
    path = tmp_path / 'trust.json'
    assert main(['trust', '--quick', '--seeds', '3', '--json', str(path)]) == code
    out = capsys.readouterr().out
    assert ('MISSED' in out) is not met and max(map(len, out.splitlines())) <= 80
    assert json.loads(path.read_text())['bars'][0]['interval'] == [0.4, 0.6]


@pytest.mark.system
def test_stated_deviations_cover_drives_within_the_tolerances(tmp_path):
    path = tmp_path / 'tolerances.json'
    main(['trust', '--tolerances', '3', '--json', str(path)])
    rows = json.loads(path.read_text())['tolerances']
    assert len(rows) == 2 * 3 * 2 and all(row['two'] > 0.93 for row in rows)
    for row in rows:
        if row['motion'] == 'multisine' and row['estimate'] == 'smoothed':
            assert row['one_noise'] + 0.1 < row['one'] and row['ratio'] < 1.8


@pytest.mark.parametrize('arguments, words', [
    (['--seeds', '0'], '--seeds: 0'), (['--quick', '--full'], '--full'),
    (['--json', 'no_such/x.json'], 'no_such'), (['no_such_folder'], 'no_such_folder')])
def test_bad_arguments_are_one_line(arguments, words, capsys):
    assert main(['trust', *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error and len(error.splitlines()) == 1


@pytest.mark.system
def test_the_learned_gap_is_that_of_the_drive():
    """The estimator begins with a gap that is 30 % too wide."""
    drive = trust_runs.SimulatedDrive(
        'B', DriveModel(), Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.005)),
        DriveModel().with_(half_gap=1.3 * DriveModel().transmission.half_gap),
        {'arm_load': 'none', 'q_std_tau_k': 8.0})
    gaps = trust_drift.learned_gaps(drive, 30.0, 1)
    assert len(gaps) == 3
    assert gaps[-1] == pytest.approx(trust_drift.true_gap(drive.model), rel=0.03)
    assert trust_drift.minute_scatter(np.repeat([1.0, 2.0, 3.0], trust_drift.BLOCK)) == 1.0
