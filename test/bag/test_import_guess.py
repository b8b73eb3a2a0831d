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

"""The proposed mapping: formats, times, roles, units and signs that names and motion show."""
import json

import numpy as np
import pyarrow as pa
from pyarrow import feather, parquet
import pytest
import scipy.io
import yaml

from gearbox_monitor.bag.importer.guess import guessed_mapping
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.cli.main import main

T = np.round(np.arange(2000) * 0.002, 6)
ARM = np.sin(5.0 * T) + 0.4 * np.sin(11.0 * T + 1.0)
SPEED = 5.0 * np.cos(5.0 * T) + 4.4 * np.cos(11.0 * T + 1.0)
ACCELERATION = -25.0 * np.sin(5.0 * T) - 48.4 * np.sin(11.0 * T + 1.0)
TORQUE = 0.02 * ACCELERATION + 0.1 * SPEED + 0.5 * np.tanh(20.0 * SPEED)


def imported(tmp_path, *options):
    bag = tmp_path / 'bag'
    assert main(['import', *map(str, options), str(bag)]) == 0
    with open_bag(bag) as reader:
        return reader.joint_states('/joint_states', ['motor', 'arm'])


def csv(path, columns, delimiter=',', head=''):
    rows = '\n'.join(delimiter.join(map(repr, map(float, row))) for row in zip(*columns.values()))
    path.write_text(head + delimiter.join(columns) + '\n' + rows + '\n')
    return path


def test_a_test_bench_without_a_mapping(tmp_path, capsys):
    """Degrees, rpm, ms, a reversed arm and torque sign, a gear ratio, and a set point."""
    path = csv(tmp_path / 'bench.csv', {
        'setpoint [deg]': np.rad2deg(ARM), 'linkAngle [deg]': np.round(-np.rad2deg(ARM), 2),
        'motorAngle [deg]': 50.0 * np.rad2deg(ARM), 'motorSpeed': 50.0 * SPEED * 60 / (2 * np.pi),
        'motor_torque [N mm]': -TORQUE / 50.0 * 1e3, 'time_ms': T * 1e3, 'temp': 20.0 + T})
    assert main(['import', str(path), '--guess']) == 0
    text = capsys.readouterr().out
    assert yaml.safe_load(text) == {
        'format': 'text', 'text': {'header': True}, 'kind': 'rotary', 'gear_ratio': 50.0,
        'time': {'column': 'time_ms', 'unit': 'ms'}, 'signals': {
            'motor_position': {'column': 'motorAngle [deg]', 'unit': 'deg'},
            'arm_position': {'column': 'linkAngle [deg]', 'unit': 'deg', 'sign': -1},
            'motor_velocity': {'column': 'motorSpeed', 'unit': 'rpm'},
            'motor_effort': {'column': 'motor_torque [N mm]', 'unit': 'N mm', 'sign': -1},
            'motor_setpoint': {'column': 'setpoint [deg]', 'unit': 'deg', 'scale': 50.0}}}
    assert '# Not used: temp.' in text
    (tmp_path / 'map.yaml').write_text(text)
    joints = imported(tmp_path, path, '--map', tmp_path / 'map.yaml')
    (tmp_path / 'bag').rename(tmp_path / 'by_file')
    directly = imported(tmp_path, path, '--guess')
    for bag in (joints, directly):
        np.testing.assert_allclose(bag.position[:, 0], ARM, atol=1e-12)
        np.testing.assert_allclose(bag.position[:, 1], ARM, atol=np.deg2rad(0.0051))
        np.testing.assert_allclose(bag.velocity[:, 0], SPEED, atol=1e-12)
        np.testing.assert_allclose(bag.effort[:, 0], TORQUE, atol=1e-12)
    assert 'assumed: Gear ratio 50' in capsys.readouterr().out


NAMED = {'t': T, 'q': ARM, 'tau': TORQUE}


def _files(folder):
    """Yield a recording in each format."""
    rows = np.column_stack(list(NAMED.values()))
    csv(folder / 'semicolon.csv', NAMED, ';')
    yield folder / 'semicolon.csv'
    text = (folder / 'semicolon.csv').read_text().replace('.', ',').replace('t;q', 's;rad')
    (folder / 'decimal_comma.csv').write_text('Made by a machine\nt;q;tau\n' + text)
    yield folder / 'decimal_comma.csv'
    np.savetxt(folder / 'saved.txt', rows, fmt='%.17g', header='t q tau')
    yield folder / 'saved.txt'
    (folder / 'rows.csv').write_text('\n'.join(
        ','.join([name, *map(repr, map(float, values))]) for name, values in NAMED.items()))
    yield folder / 'rows.csv'
    scipy.io.savemat(folder / 'm.mat', {'run': {'log': NAMED}})
    yield folder / 'm.mat'
    entries = [dict(zip(NAMED, map(float, row))) for row in rows]
    (folder / 'j.json').write_text(json.dumps({'meta': 1, 'log': {'samples': entries}}))
    yield folder / 'j.json'
    (folder / 'lines.jsonl').write_text('\n'.join(map(json.dumps, entries)))
    yield folder / 'lines.jsonl'
    np.savez(folder / 'n.npz', **NAMED)
    yield folder / 'n.npz'
    table = pa.table({**NAMED, 't': pa.array((T * 1e9).astype(int), pa.timestamp('ns'))})
    parquet.write_table(table, folder / 'p.parquet')
    yield folder / 'p.parquet'
    feather.write_feather(table, folder / 'f.feather')
    yield folder / 'f.feather'


def test_every_format_is_recognised(tmp_path):
    for path in _files(tmp_path):
        joints = imported(tmp_path, path, '--guess')
        np.testing.assert_allclose(joints.position[:, 0], ARM, atol=1e-9, err_msg=str(path))
        np.testing.assert_allclose(joints.effort[:, 0], TORQUE, atol=1e-9, err_msg=str(path))
        (tmp_path / 'bag').rename(path.with_suffix('.bag'))


def test_hdf5_is_recognised(tmp_path):
    h5py = pytest.importorskip('h5py')
    with h5py.File(tmp_path / 'r.h5', 'w') as file:
        for name, values in NAMED.items():
            file[f'joint/{name}'] = np.rad2deg(values) if name == 'q' else values
        file['joint/q'].attrs['units'] = 'deg'
    np.testing.assert_allclose(imported(tmp_path, tmp_path / 'r.h5', '--guess').position[:, 0],
                               ARM, atol=1e-12)


@pytest.mark.parametrize('coding, bits', [('sign_magnitude', 11), ('twos_complement', 16)])
def test_coded_integers_are_recognised_and_their_scale_is_asked_for(tmp_path, capsys, coding,
                                                                    bits):
    raw = np.rint(100.0 * TORQUE)
    negative = 1024 - raw if coding == 'sign_magnitude' else 65536 + raw
    path = csv(tmp_path / 'r.csv', {'time': T, 'position': ARM,
                                    'load': np.where(raw < 0, negative, raw)})
    assert main(['import', str(path), '--guess', str(tmp_path / 'bag')]) == 3
    message = capsys.readouterr().err.splitlines()[-1]
    assert 'signals.motor_effort.unit' in message and '--torque-constant K' in message
    joints = imported(tmp_path, path, '--guess', '--set', 'signals.motor_effort.scale=0.01')
    np.testing.assert_allclose(joints.effort[:, 0], raw / 100.0, atol=1e-12)
    guess = guessed_mapping(path)
    assert [question.topic for question in guess.questions] == ['constant']
    block = guess.data['signals']['motor_effort']
    assert (block['bits'], block.get('coding', 'twos_complement')) == (bits, coding)


def test_counts_of_the_motor_follow_from_those_of_the_arm(tmp_path):
    path = csv(tmp_path / 'r.csv', {'t': T, 'enc_a': np.rint(8192 * ARM / (2 * np.pi)),
                                    'enc_b': np.rint(300_000 * ARM / (2 * np.pi))})
    guess = guessed_mapping(path, ['signals.arm_position.counts_per_rev=8192'])
    assert guess.data['signals']['motor_position']['column'] == 'enc_b'
    assert abs(guess.data['signals']['motor_position']['counts_per_rev'] / 300_000 - 1) < 1e-3


@pytest.mark.parametrize('columns, expected, code', [
    ({'q': ARM, 'tau': TORQUE}, 'grows like a time, expected one, or --rate HZ', 3),
    ({'t': T, 'tau': TORQUE, 'x1': SPEED}, 'no position or velocity among tau, x1', 2),
    ({'t': T, 'q': 0.0 * ARM, 'tau': TORQUE}, 'q never changes, expected a motion', 2),
    ({'t': T[:50], 'q': ARM[:50]}, 'expected two or more of at least 100', 2)])
def test_what_cannot_be_guessed_is_said_in_one_line(tmp_path, capsys, columns, expected, code):
    path = csv(tmp_path / 'r.csv', columns)
    assert main(['import', str(path), '--guess', str(tmp_path / 'bag')]) == code
    message = capsys.readouterr().err
    assert message.count('\n') == 1 and expected in message and str(path) in message
