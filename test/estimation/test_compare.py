# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Filters side by side on one bag."""
import json
import sys

import numpy as np
import pytest
from test_tune import DRIVE, params, samples_of, simulated, write

from gearbox_monitor.cli import compare
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimator import Estimator

TUNED = {'r_std_motor': 0.0658, 'r_std_arm': 0.0833, 'q_std_tau_k': 9.2}


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return write(tmp_path_factory.mktemp('compare') / 'bag', simulated(3, 4000))


@pytest.mark.parametrize('name', ['ekf', 'ukf'])
def test_filterpy_agrees(name):
    pytest.importorskip('filterpy')
    from gearbox_monitor.estimation import filterpy_reference
    samples = samples_of(simulated(4, 1000))
    parameters = {**TUNED, 'arm_load': 'unknown', 'filter': name, 'narrow_std': False}
    drive = DRIVE.exact()  # filterpy knows no tolerances
    theirs = filterpy_reference.run(f'filterpy-{name}', drive, parameters, samples)
    ours = Estimator(drive, parameters).run(samples)
    assert theirs.stamp_ns.tolist() == ours.stamp_ns.tolist()
    for column in ('tau_k', 'tau_k_std', 'loglik', 'nis', 'white_2', 'innovation_arm', 'twist'):
        np.testing.assert_allclose(getattr(theirs, column), getattr(ours, column), rtol=1e-6,
                                   atol=1e-7, err_msg=column)


def test_without_filterpy_one_line(monkeypatch):
    from gearbox_monitor.estimation import filterpy_reference
    monkeypatch.setitem(sys.modules, 'filterpy.kalman', None)
    with pytest.raises(InputError, match='filterpy is not installed'):
        filterpy_reference.run('filterpy-ekf', DRIVE, TUNED, samples_of(simulated(4, 100)))


def test_table_and_figure(bag, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(compare, 'FILTERPY_SAMPLES', 3000)
    pytest.importorskip('filterpy')
    picture = tmp_path / 'c.png'
    arguments = ['compare', str(bag), '--params', params(tmp_path / 'p.yaml', **TUNED)]
    names = ('ekf', 'aekf', 'filterpy-ekf')
    assert main([*arguments, '--filters', ','.join(names), '--png', str(picture)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert 'comes nearest to the torque: ' in lines[0]
    table = lines[4:6 + len(names)]
    assert max(map(len, table)) <= 80
    assert [line.split()[0] for line in table[1:1 + len(names)]] == list(names)
    assert any('only the first 3000 of 4000 samples' in line for line in lines)
    assert main([*arguments, '--filters', 'ekf', '--json']) == 0
    row, = json.loads(capsys.readouterr().out)['rows']
    assert row['rmse'] < 1.4 and row['rmse_smoothed'] < 0.5 * row['rmse']
    assert 0.6 < row['coverage'] < 0.9 and row['nis'] == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize('options, words', [
    (['--filters', 'ekf,kalman'], "filter: 'kalman', expected one of aekf, ekf"),
    (['--png', 'x.gif'], 'expected a name that ends in .png')])
def test_bad_input_is_one_line(options, words, bag, capsys):
    assert main(['compare', str(bag), *options]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count('\n') == 1
