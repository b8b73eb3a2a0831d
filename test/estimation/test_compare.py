# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Filters side by side on one bag."""
import json

import pytest
from test_tune import params, simulated, write

from gearbox_monitor.cli.main import main

TUNED = {'r_std_motor': 0.0658, 'r_std_arm': 0.0833, 'q_std_tau_k': 9.2}


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp('compare') / 'bag', simulated(3, 4000))


def test_table_and_figure(bag, tmp_path, capsys):
    picture = tmp_path / 'c.png'
    arguments = ['compare', str(bag), '--params', params(tmp_path / 'p.yaml', **TUNED)]
    names = ('ekf', 'aekf', 'srukf')
    assert main([*arguments, '--filters', ','.join(names), '--png', str(picture)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert 'comes nearest to the torque: ' in lines[0]
    table = lines[4:6 + len(names)]
    assert max(map(len, table)) <= 80
    assert [line.split()[0] for line in table[1:1 + len(names)]] == list(names)
    assert main([*arguments, '--filters', 'ekf', '--json']) == 0
    row, = json.loads(capsys.readouterr().out)['rows']
    assert row['rmse'] < 1.4 and row['rmse_smoothed'] < 0.5 * row['rmse']
    assert 0.6 < row['coverage'] < 0.9 and row['nis'] == pytest.approx(2.0, abs=0.15)


WRONG = [
    (['--filters', 'ekf,kalman'], "filter: 'kalman', expected one of aekf, ekf"),
    (['--filters', 'ekf,filterpy-ekf'], 'leave it out: tests hold the filters equal'),
    (['--png', 'x.gif'], 'expected a name that ends in .png')]


def test_bad_input_is_one_line(bag, capsys):
    for options, words in WRONG:
        assert main(['compare', str(bag), *options]) == 2
        said = capsys.readouterr().err
        assert words in said and said.count('\n') == 1
