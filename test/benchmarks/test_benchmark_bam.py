# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Servos by their setpoints, beside Better Actuator Models."""
from dataclasses import replace
import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks import bam
from benchmarks.__main__ import main
from gearbox_monitor.plant.simulate import Plant

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data' / 'bam_servo_pendulum'
SERVO = bam.SERVOS['xl330']


def written(folder, name, gain, switched_off=False):
    """Write a recording of the stated servo with `gain`, held setpoints, as BAM's logger does."""
    t = np.arange(800) * bam.DT
    setpoint = 0.8 * np.sin(2.5 * t)
    raw = {'mass': 0.5, 'length': 0.1, 'kp': gain, 'vin': 7.4, 'trajectory': 'sin_sin'}
    log = bam.ServoLog(Path(), raw, setpoint, setpoint, np.zeros(1), 0.0)
    run = Plant(bam.stated_model(SERVO, log)).run(setpoint, bam.DT)
    rows = [{'timestamp': float(when), 'position': float(q), 'goal_position': float(goal),
             'load': 0, 'torque_enable': not switched_off}
            for when, q, goal in zip(t, run.y[:, 1], setpoint)]
    with gzip.open(folder / f'{name}.json.gz', 'wt', encoding='utf-8') as file:
        json.dump({**raw, 'entries': rows}, file)


def test_a_servo_as_stated_has_no_error_at_its_own_gain(tmp_path):
    written(tmp_path, 'a', 200)
    written(tmp_path, 'b', 400)
    written(tmp_path, 'c', 400, switched_off=True)
    logs = bam.read_logs(tmp_path)
    assert [log.kp for log in logs] == [200.0, 400.0]
    model = bam.stated_model(SERVO, logs[0])
    assert [bam.run_error(log, model, SERVO) < 1e-3 for log in logs] == [True, True]
    heavier = replace(model, motor_inertia=3.0 * model.motor_inertia)
    assert bam.run_error(logs[1], heavier, SERVO) > 1e-3


def test_a_folder_without_recordings_is_one_line(tmp_path, capsys):
    assert main(['bam', str(tmp_path), '--servo', 'xl330']) == 2
    assert 'xl330: no *.json.gz with the torque on' in capsys.readouterr().err


@pytest.mark.system
@pytest.mark.skipif(not DATA.is_dir(), reason='no recordings of BAM beside the repository')
def test_load_friction_is_identified_and_the_other_gain_predicted(tmp_path):
    main(['bam', str(DATA), '--servo', 'xl330', '--json', str(tmp_path / 'bam.json')])
    data, = json.loads((tmp_path / 'bam.json').read_text())['servos']
    assert data['identified'] == ['load_friction', 'lugre']  # benchmarks/README.md
    assert np.mean(data['errors'][data['judged']]['held out']) < 0.04
