# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Logs that users had, outside of this project: read, asked for, or refused in one line."""
import contextlib
from pathlib import Path
import re
import shutil
import sqlite3

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.read import open_bag

CASES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'


def case(name):
    path = CASES / name
    if not path.exists():
        pytest.skip(f'{path} is not here')
    return str(path)


def guess(capsys, name, *options):
    """Return (exit code, mapping, messages) of the guess of a case."""
    code = main(['import', case(name), '--guess', *options])
    out, err = capsys.readouterr()
    assert 'Traceback' not in err
    return code, yaml.safe_load(out) or {}, err


def columns(mapping):
    blocks = mapping.get('joints') or {'': mapping['signals']}
    return {joint: {name: block['column'] for name, block in own.items()}
            for joint, own in blocks.items()}


SUFFICIENT = [
    ('import_twincat/scope.csv', {
        'motor_position': 'ActPos', 'motor_effort': 'ActTorque',
        'arm_position': 'LoadEncoderPos'}),
    ('import_plotjuggler_blanks/log.csv', {
        'motor_position': '/joint_states/elbow/position',
        'motor_velocity': '/joint_states/elbow/velocity',
        'motor_effort': '/joint_states/elbow/effort', 'arm_position': '/encoder/output_angle'})]


def test_names_and_units_suffice(capsys):
    for name, expected in SUFFICIENT:
        code, mapping, err = guess(capsys, name)
        assert code == 0, err
        assert columns(mapping) == {'': expected}


def test_desired_positions_are_setpoints(capsys):
    code, mapping, _ = guess(capsys, 'import_desired_as_encoder/log.csv')
    assert code == 0 and columns(mapping)['joint_3'] == {
        'position': 'q_3', 'velocity': 'dq_3', 'effort': 'tau_J_3', 'setpoint': 'q_d_3'}


def test_rows_of_several_signals_become_columns(capsys):
    code, mapping, _ = guess(capsys, 'import_foxglove_csv/plot.csv')
    assert code == 0 and columns(mapping)['joint_1'] == {
        'position': '/joint_states.position[:]{1}'}


def test_units_in_the_header_are_used_or_asked_for(capsys):
    code, mapping, err = guess(capsys, 'import_dynamixel_units/log.csv')
    assert code == 3 and '--counts-per-turn' in err and '--torque-constant' in err
    assert mapping['signals']['motor_velocity'] == {
        'column': 'Present Velocity [0.229rpm]', 'unit': 'rpm', 'scale': 0.229}


def test_episodes_follow_one_another(capsys, new_folder):
    for name, rows in [('equal.hdf5', 600), ('dataset.hdf5', 690)]:
        folder = new_folder()
        code, mapping, _ = guess(capsys, f'hdf5_demos/{name}', '--rate', '50')
        assert code == 0 and columns(mapping)['joint_1'] == {
            'position': 'states.articulation.robot.joint_position 1',
            'velocity': 'states.articulation.robot.joint_velocity 1',
            'setpoint': 'processed_actions 1'}
        assert main(['import', case(f'hdf5_demos/{name}'), '--rate', '50', str(folder / 'b')]) == 0
        with open_bag(folder / 'b') as reader:
            assert reader.topics['/joint_states'][1] == rows
        assert main(['import', case(f'hdf5_demos/{name}'), '--rate', '50', '--episode', '1',
                     str(folder / 'one')]) == 0
        with open_bag(folder / 'one') as reader:
            assert reader.topics['/joint_states'][1] == rows - (300 if rows == 600 else 360)
        capsys.readouterr()


def test_a_gripper_in_percent_is_asked_for(capsys, tmp_path):
    path = 'import_lerobot_gripper/data/chunk-000/file-000.parquet'
    code, _, err = guess(capsys, path, '--unit', 'position=deg')
    assert code == 3 and '--unit gripper=none' in err
    assert main(['import', case(path), '--unit', 'position=deg', '--unit', 'gripper=none',
                 str(tmp_path / 'bag')]) == 0
    with open_bag(tmp_path / 'bag') as reader:
        assert len(reader.joint_names('/joint_states')) == 5
    capsys.readouterr()
    code, mapping, err = guess(capsys, 'import_lerobot/file-000.parquet')
    assert code == 3 and mapping['time']['segment'] == 'episode_index'
    assert '--unit position=deg' in err


def test_a_write_ahead_log_is_merged_by_the_command_that_is_named(tmp_path):
    shutil.copytree(case('db3_wal_half/bag'), tmp_path / 'bag')
    with pytest.raises(InputError, match="-wal .*'PRAGMA wal_checkpoint") as error:
        open_bag(tmp_path / 'bag')
    file, command = re.search("sqlite3 ([^ ]*) '(.*)'", str(error.value)).groups()
    with contextlib.closing(sqlite3.connect(file)) as base:
        base.execute(command)
    with open_bag(tmp_path / 'bag') as reader:
        assert reader.topics['/joint_states'][1] == 1100
        states = reader.joint_states('/joint_states', ['motor', 'arm'])
    assert len(states.stamp_ns) == 1100 and np.ptp(states.stamp_ns) * 1e-9 > 4.3


def test_all_interfaces_of_a_joint_are_used(capsys, tmp_path):
    assert main(['import', case('dyn_interfaces/bag'), str(tmp_path / 'bag')]) == 0
    with open_bag(tmp_path / 'bag') as reader:
        states = reader.joint_states('/joint_states', ['elbow', 'elbow_absolute'])
    assert np.isfinite(states.effort[:, 0]).all() and np.isfinite(states.position).all()


REFUSED = [
    (('import', 'import_binary/log.csv', '--guess'), 'is it binary?', 2),
    (('import', 'import_echo_yaml/joint_states.yaml', '--guess'), 'ros2 topic echo --csv', 2),
    *(((*words, 'zero_stamps/bag'), '--stamps received', 2) for words in (
        ['check'], ['replay'], ['report'], ['accept', '--max-gap', '0.1'],
        ['watch', '--model', 'robot_wraps/robot.urdf'])),
    (('diagnose', 'robot_prefix/bag', '--model', 'robot_prefix/robot.urdf'), '--prefix left_', 3)]


def test_what_is_refused_is_refused_in_one_line(capsys):
    for words, says, code in REFUSED:
        assert main([case(word) if '/' in word else word for word in words]) == code
        err = capsys.readouterr().err
        assert says in err and err.count('\n') == 1
