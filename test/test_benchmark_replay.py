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

import pytest

from gearbox_monitor.benchmarks import replay, scale
from gearbox_monitor.cli.main import main
from gearbox_monitor.jit import COMPILED

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
    code = main(['benchmark', 'scale', '--minutes', '0.5', '0.1', '--rounds', '1',
                 '--json', str(file)])
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
@pytest.mark.parametrize('words, told', [
    (['--minutes', '3'], '--minutes: 3, expected two or more different numbers'),
    (['--minutes', '3', '-1'], '--minutes: 3 -1, expected'),
    (['--rounds', '0'], '--rounds: 0, expected'),
    (['--json', 'no/where/x.json'], 'its directory does not exist'),
])
def test_bad_usage(capsys, words, told):
    assert main(['benchmark', 'scale', *words]) == 2
    assert told in capsys.readouterr().err
