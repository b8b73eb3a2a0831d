# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Live nodes under load, in a long run and restarted: the commands in small, and their pieces."""
import json

import numpy as np
import pytest

pytest.importorskip('rclpy')
import load  # noqa: E402, I100
import restart  # noqa: E402
import robot  # noqa: E402
from sample_source import FEW  # noqa: E402
from script import run_script  # noqa: E402
import soak  # noqa: E402

from benchmarks.harness import all_met  # noqa: E402
from gearbox_monitor.ros.gearbox_input import MessageLossCounter  # noqa: E402

pytestmark = [pytest.mark.ros, pytest.mark.benchmark]


def test_lost_messages_are_counted_by_their_numbers():
    losses = MessageLossCounter()
    for number, ours in ((7, True), (8, True), (11, True), (12, False), (13, True), (3, True),
                         (4, True), (900, False), (6, True), (None, True)):
        losses.add({'publication_sequence_number': number}, ours)
    # 9, 10 and, of the next publisher, 5; 12 came without our joints, 900 is of another one.
    assert losses.count == 3


def bar(data, name):
    """Return whether the one bar of `data` whose text contains `name` is met."""
    found, = (entry for entry in data['bars'] if name in entry['bar'])
    return found['met']


@pytest.mark.system
def test_load(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(load, 'LAYOUTS', (load.ONE,))
    file = tmp_path / 'load.json'
    code = run_script(load, ['--rates', '200', '--numbers', '2', '--seconds', '1',
                             '--past', '20000', '--json', str(file)])
    data, out = json.loads(file.read_text()), capsys.readouterr().out
    row, = data['runs']
    assert row['number'] == 2 and row['sent'] == 200 + FEW and row['counted'] == row['dropped']
    assert 0.0 < row['p50'] <= row['p99'] <= row['max']
    assert data['past']['sent'] == 20000 + FEW and data['past']['estimates_per_s'] > 0.0
    assert bar(data, 'drops that the node counts'), json.dumps(data['past'])
    assert 'highest number without a dropped sample' in out
    assert code == (0 if all_met(data['bars']) else 1)


@pytest.mark.system
def test_naming_costs_no_sample(tmp_path):
    file = tmp_path / 'naming.json'
    assert run_script(load, ['--naming', '--rates', '500', '--json', str(file)]) == 0
    named, plain = json.loads(file.read_text())['naming']
    assert named['effect'] == 'backlash_gap' and plain['effect'] == ''
    assert named['sent'] == pytest.approx(plain['sent'], rel=0.05)


@pytest.mark.system
def test_soak(tmp_path):
    file = tmp_path / 'soak.json'
    assert run_script(soak, ['--hours', '0.01', '--rate', '500', '--every', '0.05',
                             '--json', str(file)]) in (0, 1)
    data = json.loads(file.read_text())
    assert data['sent'] == 18000 and bar(data, 'without estimate') and bar(data, 'drift alerts')
    assert bar(data, 'errors in the log') and bar(data, 'samples per second of stamps')
    rows = data['rows']
    assert rows[-1]['estimates'] > rows[0]['estimates'] and rows[0]['memory'] > 1e7
    # What must not be: a leak, a growing number of handles, a slower node, an alert.
    rows = [{'wall': float(k), 'stamps': float(10 * k), 'estimates': 1000 * k, 'cpu': 0.1 * k,
             'memory': 2e8, 'handles': 20, 'threads': 12, 'rate_hz': 100.0}
            for k in range(200)]
    good = {**data, 'rows': rows, 'seconds': 2000.0, 'rate': 100.0, 'not_ok': [],
            'judged': True, 'real_time': True}
    assert all(entry['met'] for entry in soak.bars(good))
    for name, change in (('growth', {'memory': lambda k: 2e8 + 5e4 * k}),
                         ('handles', {'handles': lambda k: 20 + k // 50}),
                         ('estimates per second', {'estimates': lambda k: 1000 * k - k * k // 4}),
                         ('as the node states', {'rate_hz': lambda k: 100.0 - (k == 180) * 9.0})):
        bad = [{**row, **{key: f(k) for key, f in change.items()}} for k, row in enumerate(rows)]
        assert not bar({'bars': soak.bars({**good, 'rows': bad})}, name)
    assert not bar({'bars': soak.bars({**good, 'not_ok': ['x']})}, 'levels other than OK')


def test_slope_has_its_interval():
    x = np.arange(100.0)
    y = 3.0 + 0.5 * x + np.random.default_rng(0).normal(0.0, 1.0, 100)
    y[40] = 1e3
    middle, low, high = soak.slope(x, y)
    assert low < 0.5 < high and high - low < 0.03 and low < middle < high


@pytest.mark.system
def test_restart(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(restart, 'AT_WORK', (2.5, 3.0))
    monkeypatch.setattr(restart, 'EARLY', 0.0)
    file = tmp_path / 'restart.json'
    code = run_script(restart, ['--times', '2', '--json', str(file)])
    data, out = json.loads(file.read_text()), capsys.readouterr().out
    assert [row['went_on'] for row in data['rows']] == [None, True], out
    assert data['adapted'] and code == (0 if all_met(data['bars']) else 1)
    for name in ('end cleanly', 'processes', 'shared memory', 'temporary', 'handles', 'cannot'):
        assert bar(data, name), out


@pytest.mark.parametrize('script, arguments, message', [
    (load, ['--numbers', '0'], '--numbers: 0'), (load, ['--rates', '-1'], '--rates: -1'),
    (load, ['--naming', '--numbers', '2'], '--numbers with --naming'),
    (load, ['--naming', '--past', '9000'], '--past with --naming'),
    (soak, ['--hours', 'nan'], '--hours: nan'), (restart, ['--times', '0'], '--times: 0'),
    (robot, ['--runs', '7'], '--runs: 7'),
    (restart, ['--json', 'no/where/x'], 'no/where/x')])
def test_bad_options_are_refused_in_one_line(script, arguments, message, capsys):
    assert run_script(script, arguments) == 2
    assert message in capsys.readouterr().err
