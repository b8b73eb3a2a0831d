# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The free run over the public EMPS recording, beside published figures."""
from dataclasses import replace
import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks import emps
from benchmarks.__main__ import main
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.signals.uniform import UniformRecording

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data' / 'emps'
DT = 1e-3


def test_the_error_is_that_of_the_model_and_not_of_where_the_run_begins():
    t = np.arange(3000) * DT
    force = 40.0 * np.cos(3.0 * t)
    run = Plant(emps.GUESSED, state=np.array([0.1, 0.1, 0.05, 0.05])).run(force, DT)
    recording = UniformRecording(t, force, run.y, DT)
    assert emps.free_run_error(recording, emps.GUESSED) < 0.05
    heavier = replace(emps.GUESSED, motor_inertia=70.0)
    other = Plant(heavier, state=np.array([0.1, 0.1, 0.05, 0.05])).run(force, DT)
    expected = 1e3 * np.sqrt(np.mean((other.y[:, 0] - run.y[:, 0]) ** 2))
    assert emps.free_run_error(recording, heavier) == pytest.approx(expected, rel=0.02)


def test_a_folder_without_the_recordings_is_one_line(tmp_path, capsys):
    assert main(['emps', str(tmp_path)]) == 2
    assert 'DATA_EMPS.mat: no such file, expected' in capsys.readouterr().err


@pytest.mark.system
@pytest.mark.skipif(not DATA.is_dir(), reason='no recordings of the EMPS beside the repository')
def test_the_second_recording_within_six_millimetres(tmp_path):
    assert main(['emps', str(DATA), '--json', str(tmp_path / 'emps.json')]) == 0
    data = json.loads((tmp_path / 'emps.json').read_text())
    assert data['effect'] == 'viscous_asymmetry'
    assert data['errors']['with effect']['test'] < 6.0 < 50.0 < (
        data['errors']['without effect']['test'])
