# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The benchmarks of replay measure what they say; their figures are not judged here."""
import json

import numpy as np
import pytest

from gearbox_monitor.benchmarks import replay, scale, scale_numbers
from gearbox_monitor.cli.main import main
from gearbox_monitor.kernels.jit import COMPILED

compiled = pytest.mark.skipif(not COMPILED, reason='numba is not in use')


def test_every_row_takes_all_samples(monkeypatch):
    monkeypatch.setattr(replay, 'SECONDS', 2.0)
    monkeypatch.setattr(replay, 'FEW', 1.0)
    with replay.steppers() as (steppers, samples):
        assert {name: run() for name, run in steppers.items()} == samples
        assert samples['replay, everything'] == 2000 and samples['rosbags, decoding'] == 1000


@compiled
def test_scale_prints_bars_that_follow_from_its_rows(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scale, 'WARM', 1.0)
    monkeypatch.setattr(scale, 'MODES', {'estimates only': False})
    file = tmp_path / 'scale.json'
    code = main(['benchmark', 'scale', '--of', 'length', '--minutes', '0.5', '0.1',
                 '--rounds', '1', '--json', str(file)])
    data = json.loads(file.read_text())
    short, long = data['rows']
    assert (short['minutes'], long['minutes']) == (0.1, 0.5)
    assert short['times_real_time'] == pytest.approx(6.0 / short['cpu_s'])
    memory = next(bar for bar in data['bars'] if 'memory' in bar['bar'])
    assert memory['value'] == pytest.approx(long['peak_mb'] / short['peak_mb'])
    assert 50 < short['peak_mb'] < 1000
    assert code == (0 if all(bar['met'] for bar in data['bars']) else 1)
    assert capsys.readouterr().out.count('expected <=') == len(data['bars']) == 2


@compiled
def test_exponents_follow_from_what_was_done(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scale_numbers, 'SECONDS', dict.fromkeys(scale_numbers.SECONDS, 0.5))
    done, file = [], tmp_path / 'scale.json'

    def count(module, name, size):
        work = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *args: (done.append(size(*args)), work(*args))[1])
    count(scale_numbers, 'criteria', lambda _, candidates, __: len(candidates))
    count(scale_numbers.Simulator, 'run', lambda _, windows, *rest: len(windows))
    count(scale_numbers.Runs, 'run', lambda _, bags, engine: len(bags))
    code = main(['benchmark', 'scale', '--of', 'windows', 'candidates', 'bags', '--rounds', '1',
                 '--bags', '3', '2', '--candidates', '2', '3', '--windows', '20', '40', '80',
                 '--json', str(file)])
    data = json.loads(file.read_text())
    assert [(row['axis'], row['number']) for row in data['numbers']] == [
        ('windows', 20), ('windows', 40), ('windows', 80), ('candidates', 2), ('candidates', 3),
        ('bags', 2), ('bags', 3)]
    assert done == [20, 2, 2, 20, 40, 80, 2, 3, 2, 3]
    cpu = {(row['axis'], row['number']): row['cpu_s'] for row in data['numbers']}
    bar = next(bar for bar in data['bars'] if 'candidates' in bar['bar'])
    assert bar['value'] == pytest.approx(
        np.log(cpu['candidates', 3] / cpu['candidates', 2]) / np.log(1.5))
    assert bar['met'] == (0.95 <= bar['value'] <= 1.05) and bar['expected'] == '0.95 to 1.05'
    assert code == (0 if all(bar['met'] for bar in data['bars']) else 1)
    assert capsys.readouterr().out.count('exponent of CPU time') == len(data['bars']) == 3


@compiled
@pytest.mark.parametrize('words, told', [
    (['--bags', '3'], '--bags: 3, expected two or more different numbers'),
    (['--minutes', '3'], '--minutes: 3, expected two or more different numbers'),
    (['--minutes', '3', '-1'], '--minutes: 3 -1, expected'),
    (['--rounds', '0'], '--rounds: 0, expected'),
    (['--json', 'no/where/x.json'], 'no such folder'),
])
def test_bad_usage(capsys, words, told):
    assert main(['benchmark', 'scale', *words]) == 2
    assert told in capsys.readouterr().err
