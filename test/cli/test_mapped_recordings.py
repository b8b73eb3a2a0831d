# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Recordings with the setpoint of a servo: read from CSV and bags, imported, checked, refused."""
from argparse import ArgumentParser
import json
from pathlib import Path
import re

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import declared, main
from gearbox_monitor.cli.options import load_recordings
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.simulate import Noise, Plant

DT = 0.01
SERVO = {'controller': {'kp': 6.0, 'kd': 0.15, 'torque_limit': 5.0}}


@pytest.fixture(scope='module')
def run():
    """Return 8 s of a servo at 100 Hz, with noise."""
    t = DT * np.arange(800)
    setpoint = 1.5 * np.sin(2 * np.pi * 0.7 * t) + 0.4 * np.sin(2 * np.pi * 2.1 * t)
    return Plant(model_from_dict(SERVO, 'm'), Noise(measurement=(0.002, 0.002)), 1).run(
        setpoint, DT)


def write(folder, columns, model=None):
    """Write a.csv of `columns` {name: values} and drive.yaml; return the options of a command."""
    np.savetxt(folder / 'a.csv', np.column_stack(list(columns.values())), '%.9g', ',',
               header=','.join(columns), comments='')
    (folder / 'drive.yaml').write_text(yaml.safe_dump(SERVO if model is None else model))
    return options(folder / 'a.csv', folder / 'drive.yaml')


def options(recording, model):
    parser = ArgumentParser()
    declared(parser, 'diagnose')
    return parser.parse_args([str(recording), '--model', str(model)])


def loaded(args):
    _, (recording,), _, notes = load_recordings(args)
    return recording, notes


def columns_of(run, **changes):
    return {'t': run.t, 'setpoint': run.u, 'motor': run.y[:, 0], 'arm': run.y[:, 1], **changes}


def test_setpoint_is_the_input_and_the_servo_commands_the_torque(tmp_path, run):
    recording, notes = loaded(write(tmp_path, columns_of(run)))
    assert not notes
    np.testing.assert_allclose(recording.u, run.u, atol=1e-6)
    exact = np.clip(6.0 * (run.u - run.x[:, 0]) - 0.15 * run.x[:, 2], -5.0, 5.0)
    assert np.std(recording.torque - exact) < 0.06 * np.std(exact)
    _, (note,) = loaded(write(tmp_path, columns_of(run, u=2.0 * recording.torque)))
    assert note == ('the torque is 2 times the torque by the controller of the model '
                    '(correlation 1.00)')
    _, (note,) = loaded(write(tmp_path, columns_of(run, u=np.zeros(800))))
    assert note.startswith('column u is not used')  # a log of what nobody measured
    _, notes = loaded(write(tmp_path, columns_of(run, arm=np.full(800, np.nan))))
    assert not notes


MESSAGES = [
    ({'setpoint': None, 'u': 1.0}, None, 'no setpoint, expected one with the controller'),
    ({}, {}, 'a setpoint and no torque, expected the key controller'),
    ({'setpoint': 0.0}, None, 'the setpoint is 0 throughout'),
    ({'setpoint': None, 'u': None}, None, 'never measured')]


def test_messages_name_the_channel(new_folder, run):
    for changes, model, message in MESSAGES:
        folder = new_folder()
        columns = columns_of(run)
        for name, factor in changes.items():
            columns[name] = None if factor is None else factor * run.u
        columns = {name: value for name, value in columns.items() if value is not None}
        with pytest.raises(InputError, match=message):
            loaded(write(folder, columns, model))


MISREAD = [
    (-1.0, 'the sign of the setpoint is wrong'),
    (57.3, 'the setpoint is 5[0-9.]* times the motion that follows it')]


def test_a_setpoint_that_may_be_read_otherwise_gets_a_note(new_folder, run):
    for factor, says in MISREAD:
        folder = new_folder()
        recording, notes = loaded(write(folder, columns_of(run, setpoint=factor * run.u)))
        assert re.search(says, notes[-1]) and recording.doubt.text == notes[-1]


def test_lost_setpoints_are_held_and_named(tmp_path, run):
    setpoint = run.u.copy()
    setpoint[[100, 101]] = np.nan
    recording, notes = loaded(write(tmp_path, columns_of(run, setpoint=setpoint)))
    assert notes == ['2 values of setpoint were NaN and are interpolated']
    assert recording.u[101] == recording.u[99]


def test_imported_bag_has_the_setpoint(tmp_path, run, capsys):
    args = write(tmp_path, columns_of(run, setpoint=np.degrees(run.u)))
    mapping = {'time': {'column': 't'}, 'signals': {
        'motor_setpoint': {'column': 'setpoint', 'unit': 'deg'},
        'motor_position': {'column': 'motor'}, 'arm_position': {'column': 'arm'}}}
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump(mapping))
    bag = tmp_path / 'bag'
    assert main(['import', args.bag[0], '--map', str(tmp_path / 'map.yaml'), str(bag)]) == 0
    recording, _ = loaded(options(bag, args.model))
    np.testing.assert_allclose(recording.u, run.u, atol=1e-6)
    capsys.readouterr()
    assert main(['check', str(bag), '--model', args.model, '--for', 'diagnosis',
                 '--json', '-']) == 0
    findings = json.loads(capsys.readouterr().out)['lines']
    torque, = [line for line in findings if line['group'] == 'torque']
    assert torque['hurts'] == {'estimation': 'bad', 'drift': 'bad'}
    said = next(line for line in findings if line['name'] == 'diagnose')
    assert said['figure'].startswith('accepted')
    guessed = tmp_path / 'guessed'
    (tmp_path / 'log.csv').write_text((tmp_path / 'a.csv').read_text().replace(
        't,setpoint,motor,arm', 't,goal_position [deg],motor_position,link_position'))
    assert main(['import', str(tmp_path / 'log.csv'), '--guess', str(guessed)]) == 0
    recording, _ = loaded(options(guessed, args.model))
    np.testing.assert_allclose(recording.u, run.u, atol=1e-6)
    Path(tmp_path / 'plain.yaml').write_text('damping: 0.01\n')
    with pytest.raises(InputError, match='a setpoint and no torque'):
        loaded(options(bag, tmp_path / 'plain.yaml'))
