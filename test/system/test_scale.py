# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The measurements of scale and fleet count what they say; their figures are not judged here."""
import json

import fleet
import numpy as np
import pytest
import scale
import scale_numbers
from script import run_script

from benchmarks.harness import all_met

pytestmark = pytest.mark.benchmark


@pytest.mark.system
def test_scale_prints_bars_that_follow_from_its_rows(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scale, 'WARM', 1.0)
    monkeypatch.setattr(scale, 'MODES', {'estimates only': False})
    file = tmp_path / 'scale.json'
    code = run_script(scale, ['--of', 'length', '--minutes', '0.5', '0.1',
                              '--rounds', '1', '--json', str(file)])
    data = json.loads(file.read_text())
    short, long = data['rows']
    assert (short['minutes'], long['minutes']) == (0.1, 0.5)
    assert short['times_real_time'] == pytest.approx(6.0 / short['cpu_s'])
    memory = next(bar for bar in data['bars'] if 'memory' in bar['bar'])
    assert memory['value'] == pytest.approx(long['peak_mb'] / short['peak_mb'])
    assert 50 < short['peak_mb'] < 1000
    assert code == (0 if all_met(data['bars']) else 1)
    assert capsys.readouterr().out.count('expected <=') == len(data['bars']) == 2


def test_exponents_follow_from_what_was_done(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scale_numbers, 'SECONDS', dict.fromkeys(scale_numbers.SECONDS, 0.5))
    done, file = [], tmp_path / 'scale.json'

    def count(module, name, size):
        work = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *args: (done.append(size(*args)), work(*args))[1])
    count(scale_numbers.Simulator, 'run', lambda _, windows, *rest: len(windows))
    code = run_script(scale, ['--of', 'windows', '--rounds', '1', '--windows', '80', '20', '40',
                              '--json', str(file)])
    data = json.loads(file.read_text())
    assert [(row['axis'], row['number']) for row in data['numbers']] == [
        ('windows', 20), ('windows', 40), ('windows', 80)]
    assert done == [20, 20, 40, 80]
    cpu = [row['cpu_s'] for row in data['numbers']]
    bar, = data['bars']
    assert bar['value'] == pytest.approx(np.log(cpu[2] / cpu[0]) / np.log(4.0))
    assert bar['met'] == (0.95 <= bar['value'] <= 1.05) and bar['expected'] == '0.95 .. 1.05'
    assert code == (0 if all_met(data['bars']) else 1)
    assert capsys.readouterr().out.count('exponent of CPU time') == 1


@pytest.mark.parametrize('arguments, message', [
    (['--windows', '3'], '--windows: 3, expected two or more different numbers'),
    (['--minutes', '3'], '--minutes: 3, expected two or more different numbers'),
    (['--minutes', '3', '-1'], '--minutes: 3 -1, expected'),
    (['--rounds', '0'], '--rounds: 0, expected'),
    (['--json', 'no/where/x.json'], 'no such folder'),
])
def test_bad_options_are_refused_in_one_line(capsys, arguments, message):
    assert run_script(scale, arguments) == 2
    assert message in capsys.readouterr().err


def test_a_fleet_run_that_costs_too_much_misses_its_bars(monkeypatch, capsys):
    times = {'serial': [(1.0, 1.0)], 'home': [(1.2, 0.5)], 'one worker': [(1.1, 1.0)],
             'dask': [(1.7, 0.9)]}
    grown = {5: [0.15], 10: [0.3], 20: [0.6], 40: [1.2]}
    data = fleet.figures(times, grown, [1.95], 40, 100.0, None)
    assert [bar['met'] for bar in data['bars']] == [False, True, True, True]
    without_dask = {name: rows for name, rows in times.items() if name != 'dask'}
    skipped = fleet.figures(
        without_dask, {5: [0.1], 40: [1.2]}, [1.2], 40, 100.0, 'no distributed')
    assert [bar['met'] for bar in skipped['bars']] == [False, None, False, None]
    monkeypatch.setattr(fleet, 'evaluate', lambda *_: skipped)
    assert run_script(fleet, []) == 1
    output = capsys.readouterr().out
    assert 'MISSED home CPU / serial' in output and 'no two idle cores' in output
