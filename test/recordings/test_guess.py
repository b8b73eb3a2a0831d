# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The proposed mapping: formats, times, roles, units and signs that names and motion show."""
import json

import numpy as np
import pyarrow as pa
from pyarrow import feather, parquet
import pytest
import scipy.io
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.recordings.guess import Answers, guessed
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.table import load_table

T = np.round(np.arange(1400) * 0.002, 6)
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


def test_a_test_bench_is_asked_for_its_gear_and_signs_alone(tmp_path, capsys):
    """Degrees, ms, a reversed arm, a gear and a setpoint: names and units say the rest."""
    path = csv(tmp_path / 'bench.csv', {
        'setpoint [deg]': 50.0 * np.rad2deg(ARM), 'linkAngle [deg]': np.round(-np.rad2deg(ARM), 2),
        'motorAngle [deg]': 50.0 * np.rad2deg(ARM), 'motorSpeed [rpm]': 50.0 * SPEED * 9.5492966,
        'motor_torque [N mm]': TORQUE / 50.0 * 1e3, 'time_ms': T * 1e3, 'temp': 20.0 + T})
    assert main(['import', str(path), '--guess']) == 3
    out, err = capsys.readouterr()
    assert yaml.safe_load(out) == {
        'time': {'column': 'time_ms', 'unit': 'ms'}, 'signals': {
            'motor_position': {'column': 'motorAngle [deg]', 'unit': 'deg'},
            'arm_position': {'column': 'linkAngle [deg]', 'unit': 'deg'},
            'motor_velocity': {'column': 'motorSpeed [rpm]', 'unit': 'rpm'},
            'motor_effort': {'column': 'motor_torque [N mm]', 'unit': 'N mm'},
            'motor_setpoint': {'column': 'setpoint [deg]', 'unit': 'deg'}}}
    assert 'runs against' in err and 'the motor moves 50 times as much as the arm' in err
    answers = ('--set', 'signals.arm_position.sign=-1', '--set', 'gear_ratio=50')
    joints = imported(tmp_path, path, '--guess', *answers)
    (tmp_path / 'map.yaml').write_text(out)
    (tmp_path / 'bag').rename(tmp_path / 'by_guess')
    for bag in (joints, imported(tmp_path, path, '--map', tmp_path / 'map.yaml', *answers)):
        np.testing.assert_allclose(bag.position[:, 0], ARM, atol=1e-9)
        np.testing.assert_allclose(bag.position[:, 1], ARM, atol=np.deg2rad(0.0051))
        np.testing.assert_allclose(bag.velocity[:, 0], SPEED, atol=1e-6)
        np.testing.assert_allclose(bag.effort[:, 0], TORQUE, atol=1e-9)


NO_GEARS = [
    # One glitch of an encoder is no gear, degrees under a header [rad] are a unit.
    {'motor_pos': np.where(np.arange(len(T)) == 700, 500.0, ARM), 'arm_pos': ARM + 0.0},
    {'motor_pos': np.rad2deg(ARM) + 1e-3 * np.sin(T ** 3), 'arm_pos': ARM}]


def test_an_effort_is_never_multiplied_by_a_guess(new_folder, capsys):
    for columns in NO_GEARS:
        folder = new_folder()
        path = csv(folder / 'r.csv', {'t [s]': T, **{f'{name} [rad]': x for name, x in
                                                     columns.items()}, 'torque [N m]': TORQUE})
        code = main(['import', str(path), '--guess'])
        out, err = capsys.readouterr()
        assert 'gear_ratio' not in (yaml.safe_load(out) or {})
        assert code == (3 if 'looks like a unit: --unit motor=deg' in err else 0)


def test_a_velocity_that_the_position_contradicts_is_left_out(tmp_path, capsys):
    path = csv(tmp_path / 'r.csv', {'t': T, 'q': ARM, 'dq': 57.3 * SPEED, 'tau': TORQUE})
    assert main(['import', str(path), '--guess']) == 0
    out, err = capsys.readouterr()
    assert 'motor_velocity' not in yaml.safe_load(out)['signals']
    assert 'no unit, and 57.4 times the derivative of' in err


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


def test_signed_integers_are_asked_for(tmp_path, capsys):
    raw = np.rint(100.0 * TORQUE)
    path = csv(tmp_path / 'r.csv', {'time': T, 'position': ARM,
                                    'load': np.where(raw < 0, 65536 + raw, raw)})
    assert main(['import', str(path), '--guess', '--torque-constant', '0.01']) == 3
    assert '--set signals.motor_effort.bits=16 if they are signed' in capsys.readouterr().err
    joints = imported(tmp_path, path, '--guess', '--torque-constant', '0.01', '--set',
                      'signals.motor_effort.bits=16')
    np.testing.assert_allclose(joints.effort[:, 0], raw / 100.0, atol=1e-12)


def test_two_encoders_whose_names_say_no_side_are_asked_for(tmp_path, capsys):
    path = csv(tmp_path / 's.csv', {'t': T, 'enc_a': ARM, 'enc_b': 3.0 * ARM + np.sin(T ** 3)})
    assert main(['import', str(path), '--guess']) == 3
    assert '--use motor=enc_b --use arm=enc_a' in capsys.readouterr().err


NOT_GUESSED = [
    ({'q': ARM, 'tau': TORQUE}, 'grows like a time, expected one, or --rate HZ', 3),
    ({'t': T, 'tau': TORQUE, 'x1': SPEED}, 'no position or velocity among tau, x1', 2),
    ({'t': T, 'q': 0.0 * ARM, 'tau': TORQUE}, 'q never changes, expected a motion', 2),
    ({'t': T[:50], 'q': ARM[:50]}, 'expected two or more of at least 100', 2)]


def test_what_cannot_be_guessed_is_said_in_one_line(new_folder, capsys):
    for columns, expected, code in NOT_GUESSED:
        folder = new_folder()
        path = csv(folder / 'r.csv', columns)
        assert main(['import', str(path), '--guess', str(folder / 'bag')]) == code
        message = capsys.readouterr().err
        assert message.count('\n') == 1 and expected in message and str(path) in message


def robot(path, joints, first=0, effort='i'):
    """Write a recording of joints with names q_0 and i_0 or q_1 and i_1 and so on."""
    return csv(path, {'t': T, **{f'{name}_{k + first}': np.roll(values, 100 * k)
                                 for name, values in (('q', ARM), (effort, TORQUE))
                                 for k in range(joints)}})


CONSTANTS = [
    (('--torque-constant', '2'), (2.0, 2.0, 2.0)),
    (('--torque-constant', '2,3,4'), (2.0, 3.0, 4.0)),
    (('--joint', '1', '--torque-constant', '2,3,4'), (3.0,)),
    (('--joint', '1', '--torque-constant', '5'), (5.0,))]


def test_each_joint_takes_its_own_torque_constant(new_folder):
    for options, constants in CONSTANTS:
        folder = new_folder()
        path = robot(folder / 'r.csv', 3)
        bag = folder / 'bag'
        assert main(['import', str(path), '--guess', *options, str(bag)]) == 0
        with open_bag(bag) as reader:
            names = reader.joint_names('/joint_states')
            effort = reader.joint_states('/joint_states', names).effort[:, :len(constants)]
        truth = [np.roll(TORQUE, 100 * int(1 if len(constants) == 1 else k)) * constant
                 for k, constant in enumerate(constants)]
        np.testing.assert_allclose(np.abs(effort), np.abs(np.column_stack(truth)), atol=1e-9)


NO_CONSTANTS = [
    (('--torque-constant', '2,3'), '2 constants (2, 3), expected 1 or 3, one of each joint '
     '(joint_0, joint_1, joint_2)'),
    (('--joint', '1', '--torque-constant', '2,3'), '2 constants (2, 3), expected 1 or 3, one of'),
    (('--torque-constant', '2', '--unit', 'effort=N m'), 'no effort needs one')]


def test_torque_constants_that_fit_no_joints_are_refused(new_folder, capsys):
    for options, says in NO_CONSTANTS:
        folder = new_folder()
        path = robot(folder / 'r.csv', 3)
        assert main(['import', str(path), '--guess', *options, str(folder / 'bag')]) == 2
        assert says in capsys.readouterr().err


def test_names_of_joints_in_a_list_count_from_the_first_column(new_folder):
    for first in (0, 1):
        folder = new_folder()
        path = robot(folder / 'r.csv', 3, first, 'tau')
        (folder / 'joint_list.txt').write_text('base\nelbow\nwrist\n')
        guess = guessed(load_table(path))
        columns = {name: block['position']['column']
                   for name, block in guess.data['joints'].items()}
        assert columns == {
            name: f'q_{k + first}' for k, name in enumerate(('base', 'elbow', 'wrist'))}


def test_a_role_that_is_stated_needs_no_name_that_tells(tmp_path):
    path = csv(tmp_path / 'r.csv', {'t': T, 'x1': ARM, 'tau': TORQUE})
    joints = imported(tmp_path, path, '--guess', '--use', 'position=x1')
    np.testing.assert_allclose(joints.position[:, 0], ARM, atol=1e-12)


NO_UNITS = [
    ('position=degs', '--unit position=degs: unknown unit, expected one of rad, mrad, deg'),
    ('arm=deg', '--unit arm=deg: no such role, joint or column, expected one of '),
    ('Q=deg', '--unit Q=deg: no such role, joint or column')]


def test_a_unit_of_nothing_is_refused(new_folder, capsys):
    for stated, says in NO_UNITS:
        folder = new_folder()
        path = csv(folder / 'r.csv', NAMED)
        assert main(['import', str(path), '--guess', '--unit', stated, str(folder / 'bag')]) == 2
        assert says in capsys.readouterr().err


def test_a_unit_is_stated_by_column_or_role(new_folder):
    for name in ('q', 'position', 'motor', 'motor_position'):
        folder = new_folder()
        joints = imported(folder, csv(folder / 'r.csv', NAMED), '--guess', '--unit', f'{name}=deg')
        np.testing.assert_allclose(joints.position[:, 0], np.deg2rad(ARM), atol=1e-12)


BAD_NUMBERS = [
    (('--rate', '0'), '--rate: 0, expected > 0'),
    (('--rate', 'nan'), '--rate: nan, expected > 0'),
    (('--counts-per-turn', '0'), '--counts-per-turn: 0, expected > 0'),
    (('--torque-constant', '0'), '--torque-constant: 0, expected > 0'),
    (('--counts-per-turn', '4096'), '--counts-per-turn: no signal is in counts'),
    (('--episode', '2'), '--episode: no column tells episodes apart'),
    (('--use', 'effort=none', '--torque-constant', '2'),
     '--torque-constant: no effort needs one'),
    (('--topic', 'x'), '--topic: no effect with a log as FILE'),
    (('--set', 'time.rate=0'), 'time.rate: 0, expected 0.001 to'),
    (('--set', 'signals.motor_position.counts_per_rev=0'), 'expected a number > 0'),
    (('--columns', 't,q[0],tau'), '--columns: q[0], expected 1 to 1000'),
    (('--columns', 't,q[99999999999],tau'), 'expected 1 to 1000')]


def test_numbers_without_sense_or_effect_are_refused(tmp_path, capsys):
    for options, says in BAD_NUMBERS:
        path = csv(tmp_path / 'r.csv', NAMED)
        assert main(['import', str(path), '--guess', *options, str(tmp_path / 'bag')]) == 2
        assert says in capsys.readouterr().err


def test_two_filtered_positions_are_asked_for(tmp_path, capsys):
    path = csv(tmp_path / 'r.csv', {'t': T, 'q_filt_a': ARM, 'q_filt_b': np.sin(T ** 2)})
    assert main(['import', str(path), '--guess', str(tmp_path / 'bag')]) == 3
    assert 'no name tells motor from arm: --use motor=q_filt_a' in capsys.readouterr().err


BESIDE = [
    (('joint_states.csv', 'joint_commands.csv'), 0.0, True),
    (('run3_state_motor.csv', 'run3_control.csv'), 0.0, True),
    (('friction_gravity_state.csv', 'friction_gravity_control.csv'), 0.0, True),
    (('run3_state.csv', 'run4_control.csv'), 0.0, False),
    (('states.csv', 'commands.csv'), 100.0, False)]


def test_setpoints_in_a_file_beside_the_states(new_folder, capsys):
    """Names that differ in words of the vocabulary, the same joints, and the same clock."""
    for names, start, used in BESIDE:
        folder = new_folder()
        path = csv(folder / names[0], {'t [s]': T, **{f'q_{k} [deg]': np.roll(ARM, k)
                                                      for k in range(3)}})
        csv(folder / names[1], {'time_ms': 1e3 * (T + start), **{
            f'q_{k}': 2.0 * np.roll(ARM, k) for k in range(3)}})
        assert main(['import', str(folder if used else path), '--guess',
                     str(folder / 'bag')]) == 0
        with open_bag(folder / 'bag') as reader:
            assert ('/joint_setpoints' in reader.topics) == used
            if used:
                setpoints = reader.joint_states('/joint_setpoints', ['joint_0', 'joint_2'])
                np.testing.assert_allclose(
                    setpoints.position[:, 1], np.deg2rad(2.0 * np.roll(ARM, 2)), atol=1e-12)
        # Setpoints alone are no positions, unless a user says so.
        alone = ['import', str(folder / names[1]), '--guess']
        assert main(alone) == (3 if used else 0)
        assert (f'{names[0]} beside it has the positions' in capsys.readouterr().err) == used
        assert main([*alone, '--use', 'motor=q']) == 0


def test_two_files_of_setpoints_are_asked_for_and_none_can_be_stated(tmp_path, capsys):
    folder = tmp_path / 'run'
    folder.mkdir()
    for name in ('joint_states.csv', 'joint_commands.csv', 'joint_control.csv'):
        robot(folder / name, 2)
    state = [str(folder), '--guess', '--torque-constant', '2']
    assert main(['import', *state, str(tmp_path / 'bag')]) == 3
    assert 'joint_commands.csv, joint_control.csv: setpoints' in capsys.readouterr().err
    (folder / 'joint_control.csv').unlink()
    assert main(['import', *state, '--use', 'setpoint=none', str(tmp_path / 'bag')]) == 0
    with open_bag(tmp_path / 'bag') as reader:
        assert '/joint_setpoints' not in reader.topics


def test_a_list_of_joints_is_no_second_recording_of_a_folder(tmp_path):
    folder = tmp_path / 'run'
    folder.mkdir()
    robot(folder / 'state_motor.csv', 2, effort='tau')
    (folder / 'joint_list.txt').write_text('base\nelbow\n')
    assert main(['import', str(folder), '--guess', str(tmp_path / 'bag')]) == 0
    with open_bag(tmp_path / 'bag') as reader:
        assert reader.joint_names('/joint_states') == ('base', 'elbow')


def test_a_robot_with_prismatic_and_revolute_joints(tmp_path):
    """Each joint in its own units: deg and N m, mm and N, m and A."""
    path = csv(tmp_path / 'r.csv', {
        't': T, 'q_1 [deg]': np.rad2deg(ARM), 'q_2 [mm]': 1e3 * np.roll(ARM, 50),
        'q_3 [m]': np.roll(ARM, 90), 'tau_1 [Nm]': TORQUE, 'tau_2 [kN]': 1e-3 * TORQUE,
        'tau_3 [A]': 0.5 * TORQUE})
    bag = tmp_path / 'bag'
    assert main(['import', str(path), '--guess', str(bag)]) == 3
    assert main(['import', str(path), '--guess', '--joint', '3', '--torque-constant', '2',
                 str(tmp_path / 'third')]) == 0
    assert main(['import', str(path), '--guess', '--set',
                 'joints.joint_3.effort.torque_constant=2', str(tmp_path / 'by_key')]) == 0
    assert main(['import', str(path), '--guess', '--torque-constant', '1,1,2', str(bag)]) == 0
    with open_bag(bag) as reader:
        names = reader.joint_names('/joint_states')
        states = reader.joint_states('/joint_states', names)
    truth = np.column_stack([ARM, np.roll(ARM, 50), np.roll(ARM, 90)])
    np.testing.assert_allclose(states.position, truth, atol=1e-9)
    np.testing.assert_allclose(states.effort, TORQUE[:, None] * np.ones(3), atol=1e-9)


def test_counts_of_a_prismatic_axis_are_asked_for(tmp_path, capsys):
    path = csv(tmp_path / 'r.csv', {'t': T, 'position [counts]': np.round(1e5 * ARM),
                                    'force [N]': TORQUE})
    assert main(['import', str(path), '--guess', str(tmp_path / 'bag')]) == 3
    assert '--set signals.motor_position.scale=M (m per count)' in capsys.readouterr().err
    joints = imported(tmp_path, path, '--guess', '--set', 'signals.motor_position.scale=1e-5')
    np.testing.assert_allclose(joints.position[:, 0], ARM, atol=6e-6)


def test_a_resolution_of_both_encoders_shows_the_gear_ratio(tmp_path, capsys):
    """Stated for both, it tells by how much the motor turns more than the arm."""
    path = csv(tmp_path / 'r.csv', {'t [s]': T, 'motor [counts]': np.rint(20 * 4096 * ARM),
                                    'arm [counts]': np.rint(4096 * ARM), 'tau [Nm]': TORQUE})
    assert main(['import', str(path), '--guess', '--counts-per-turn', '4096']) == 3
    assert 'the motor moves 20 times as much' in capsys.readouterr().err


def test_torques_of_an_arm_without_a_motor_are_asked_for(new_folder, capsys):
    for second in ('output_torque', 'current'):
        folder = new_folder()
        path = csv(folder / 'r.csv', {'t': T, 'link_position': ARM, 'link_torque': TORQUE,
                                      second: 0.8 * TORQUE + 0.1 * np.cos(T)})
        assert main(['import', str(path), '--guess']) == 3
        assert f'--use effort=link_torque or --use effort={second}' in capsys.readouterr().err


def test_options_of_a_question_can_be_pasted(tmp_path, capsys):
    path = csv(tmp_path / 'r.csv', {'t': T, 'Encoder A': ARM, 'Encoder B': np.sin(T ** 2)})
    assert main(['import', str(path), '--guess']) == 3
    assert "--use 'motor=Encoder A' --use 'arm=Encoder B'" in capsys.readouterr().err


LONG = {'t': np.round(np.repeat(T, 2) + 0.001 * np.tile([0, 1], len(T)), 6),
        'q': np.column_stack([ARM, 2.0 * ARM]).ravel(),
        'dq': np.column_stack([SPEED, np.nan * T]).ravel(),
        'tau': np.column_stack([TORQUE, 3.0 * TORQUE]).ravel()}
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(len(T))
ROW_KEYS = np.tile(['elbow', 'wrist'], len(T))


def test_rows_name_their_joints_whatever_the_words_mean(tmp_path):
    """'a' is a word of units, 'motor' a side; beside others they are joints."""
    for names in ('ab', ('motor 1', 'pos')):
        (tmp_path / 'c.csv').write_text('t,joint,q,tau\n' + ''.join(
            f'{t},{name},{q},{tau}\n' for t, q, tau in zip(T, ARM, TORQUE) for name in names))
        guess = guessed(load_table(tmp_path / 'c.csv'))
        assert guess.data['joints'] == {name: {
            'position': {'column': f'q {name}'}, 'effort': {'column': f'tau {name}'}}
            for name in names}


def _long_files(folder):
    """Yield a row for each joint, of which the second has no velocity, in four formats."""
    columns = {'joint': ROW_KEYS.tolist(), **{
        name: [None if np.isnan(x) else float(x) for x in values]
        for name, values in LONG.items()}}
    (folder / 'c.csv').write_text(','.join(columns) + '\n' + ''.join(
        ','.join('' if x is None else str(x) for x in row) + '\n'
        for row in zip(*columns.values())))
    yield folder / 'c.csv'
    (folder / 'j.jsonl').write_text('\n'.join(
        json.dumps(dict(zip(columns, row))) for row in zip(*columns.values())))
    yield folder / 'j.jsonl'
    np.savez(folder / 'n.npz', joint=ROW_KEYS, **LONG)
    yield folder / 'n.npz'
    parquet.write_table(pa.table({**columns, 'joint': pa.array(
        columns['joint']).dictionary_encode()}), folder / 'p.parquet')
    yield folder / 'p.parquet'


def test_a_row_for_each_joint_in_every_format(tmp_path, capsys):
    for path in _long_files(tmp_path):
        bag = path.with_suffix('.bag')
        assert main(['import', str(path), '--guess', '--stamps', 'even', str(bag)]) == 0
        out, told = capsys.readouterr()
        assert "by its name: 'dq'" in told and 'JOINT' not in told
        assert 'laid on an even grid' in out
        with open_bag(bag) as reader:
            states = reader.joint_states('/joint_states', ['elbow', 'wrist'])
        assert np.isnan(states.velocity[:, 1]).all()
        np.testing.assert_allclose(states.position[:, 0], ARM, atol=1e-9, err_msg=str(path))
        np.testing.assert_allclose(states.effort[1:, 1], 3.0 * np.interp(
            T, T + 0.001, TORQUE)[1:], atol=1e-4)


def test_rows_of_signals_with_dates_and_units_with_a_factor(tmp_path, capsys):
    start = np.datetime64('2026-03-01T12:00:00', 'ns')
    dates = start + np.round(T * 1e9).astype('m8[ns]')
    path = tmp_path / 'plot.csv'
    path.write_text('receive time,header.stamp,topic,value\n' + ''.join(
        f'{date},,/joint_states.{name},{x:.9f}\n' for name, values in (
            ('position[0]', ARM), ('effort[0]', TORQUE)) for date, x in zip(dates, values)))
    assert main(['import', str(path), '--guess', str(tmp_path / 'dated')]) == 0
    with open_bag(tmp_path / 'dated') as reader:
        states = reader.joint_states('/joint_states', ['motor'])
    np.testing.assert_allclose(states.position[:, 0], ARM, atol=1e-8)
    assert states.stamp_ns[0] == start.astype(np.int64)
    capsys.readouterr()
    keys = ('Name', 'SampleTime[ms]', 'Unit')
    scope = [','.join(f'{key},{value}' for value in values) for key, values in zip(
        keys, (('ActPos', 'ActTorque'), ('5', '5'), ('deg', '0.1%')))]
    path.write_text('\n'.join([*scope, '', *(f'{k},{q:.9f},{k},{u:.9f}' for k, (q, u) in enumerate(
        zip(np.rad2deg(ARM), 300.0 * TORQUE)))]))
    assert main(['import', str(path), '--guess']) == 3
    out, err = capsys.readouterr()
    assert yaml.safe_load(out)['signals']['motor_effort'] == {
        'column': 'ActTorque', 'unit': '%', 'scale': 0.1} and '--torque-constant' in err


def test_a_unit_that_is_not_known_is_asked_for(tmp_path, capsys):
    path = tmp_path / 'run.csv'
    path.write_text('t,pos [furlong],torque [actual]\n' + ''.join(
        f'{t:.3f},{q:.6f},{u:.6f}\n' for t, q, u in zip(T, ARM, TORQUE)))
    assert main(['import', str(path), '--guess']) == 3
    err = capsys.readouterr().err
    assert '[furlong] is no unit that is known: --unit position=UNIT' in err
    assert '[actual]' not in err.splitlines()[-1]
    assert main(['import', str(path), '--guess', '--unit', 'position=deg']) == 0
    capsys.readouterr()


ROLES = [
    # What a robot states of its joints as such, as episodes of demonstrations have it.
    ({'t': T, 'obs.joint_states': ARM, 'obs.ee_pos': NOISE, 'actions': ARM + NOISE},
     {'motor_position': 'obs.joint_states', 'motor_setpoint': 'actions'}),
    # A temperature that flickers between two numbers is no name of a joint.
    ({**NAMED, 'motor_temp': np.random.default_rng(0).integers(41, 43, len(T))},
     {'motor_position': 'q', 'motor_effort': 'tau'}),
    # Of an ODrive: what it is to do, no input shaft.
    ({'t': T, 'input_pos': ARM, 'pos_estimate': np.roll(ARM, 3), 'torque_estimate': TORQUE},
     {'motor_position': 'pos_estimate', 'motor_setpoint': 'input_pos',
      'motor_effort': 'torque_estimate'}),
    ({'t': T, 'input_pos': 20.0 * ARM, 'output_pos': ARM + NOISE, 'tau': TORQUE},
     {'motor_position': 'input_pos', 'arm_position': 'output_pos', 'motor_effort': 'tau'}),
    # Axes of a current, however they are spelled: d makes no torque.
    ({'t': T, 'stats.position': ARM, 'stats.velocity': SPEED, 'stats.qA': TORQUE,
      'stats.dA': NOISE},
     {'motor_position': 'stats.position', 'motor_velocity': 'stats.velocity',
      'motor_effort': 'stats.qA'}),
    # A controller writes what it measures, too.
    ({'control/t': T, 'control/q': ARM, 'control/dq': SPEED, 'control/tau': TORQUE},
     {'motor_position': 'control/q', 'motor_velocity': 'control/dq',
      'motor_effort': 'control/tau'}),
    # Motor and link of an elastic joint.
    ({'t': T, 'state.q_1': ARM, 'state.theta_1': ARM + NOISE, 'state.tau_1': TORQUE},
     {'motor_position': 'state.theta_1', 'arm_position': 'state.q_1',
      'motor_effort': 'state.tau_1'})]


ROBOTS = [
    # 'qd' is a speed, but what is desired beside 'dq'.
    ({'q1': ARM, 'q2': SPEED, 'qd1': ARM, 'qd2': SPEED, 'dq1': SPEED, 'dq2': ACCELERATION}, {
        k: {'position': f'q{k}', 'velocity': f'dq{k}', 'setpoint': f'qd{k}'} for k in '12'}),
    # A joint whose own torque is missing takes no commanded one, nor that of the outside.
    ({'q_1': ARM, 'q_2': SPEED, 'tau_J_1': TORQUE, 'tau_J_d_1': ARM, 'tau_J_d_2': ARM,
      'tau.ext.filtered_2': ARM}, {
        '1': {'position': 'q_1', 'effort': 'tau_J_1'}, '2': {'position': 'q_2'}}),
    # Small counts of one joint are counts, too, and words written as one are the words.
    ({'actualposition_1': np.rint(1e4 * ARM), 'actualposition_2': np.rint(20.0 * ARM)}, {
        '1': {'position': 'actualposition_1', 'unit': 'counts'},
        '2': {'position': 'actualposition_2', 'unit': 'counts'}}),
    # A goal before a joint says that the joint alone is where it is; a pose is no joint.
    ({'elbow': ARM, 'state/hip': SPEED, 'goal/elbow': ARM, 'goal/hip': SPEED,
      'yaw': NOISE, 'goal/yaw': NOISE, 'volt_hip': NOISE}, {
        'elbow': {'position': 'elbow', 'setpoint': 'goal/elbow'},
        'hip': {'position': 'state/hip', 'setpoint': 'goal/hip'}}),
    # A word that says nothing, in all names of a signal, is of no joint.
    ({'hip_q_kalman': ARM, 'knee_q_kalman': SPEED, 'hip_dq': SPEED, 'knee_dq': ARM,
      'hip_tau_kalman': TORQUE, 'knee_tau_kalman': TORQUE}, {
        joint: {'position': f'{joint}_q_kalman', 'velocity': f'{joint}_dq',
                'effort': f'{joint}_tau_kalman'} for joint in ('hip', 'knee')}),
    # Some count from 0, others from 1: in order, with a note. A torque comes before a current.
    ({'q0': ARM, 'q1': SPEED, 'q2': ARM, **{f'tau{k}': TORQUE for k in (1, 2, 3)},
      **{f'current{k}': NOISE for k in (1, 2, 3)}}, {
        str(k + 1): {'position': f'q{k}', 'effort': f'tau{k + 1}'} for k in range(3)}),
    # Left and right, no link; units before numbers; a number within a speed.
    ({'L_pos_0': ARM, 'L_pos_1': SPEED, 'R_pos_0': SPEED, 'R_pos_1': ARM}, {
        f'{side}_{k}': {'position': f'{side.upper()}_pos_{k}'} for side in 'lr' for k in '01'}),
    ({'theta_deg_1': ARM, 'theta_deg_2': SPEED, 'theta1_dot': SPEED, 'theta2_dot': ARM,
      'tool_x [mm]': ARM, 'pos_x': NOISE}, {
        k: {'position': f'theta_deg_{k}', 'velocity': f'theta{k}_dot', 'unit': 'deg/s'}
        for k in '12'}),
    # Names of joints that are words, and words of other languages.
    ({'base.pos': ARM, 'base.eff': TORQUE, 'elbow.pos': SPEED, 'elbow.eff': NOISE}, {
        joint: {'position': f'{joint}.pos', 'effort': f'{joint}.eff'}
        for joint in ('base', 'elbow')}),
    ({'关节1位置': ARM, '关节2位置': SPEED, '关节1目标位置': ARM, '关节2目标位置': SPEED}, {
        k: {'position': f'关节{k}位置', 'setpoint': f'关节{k}目标位置'} for k in '12'}),
    ({'Axe 1 position mesurée (deg)': ARM, 'Axe 2 position mesurée (deg)': SPEED,
      'Axe 1 couple': TORQUE, 'Axe 2 couple': NOISE}, {
        k: {'position': f'Axe {k} position mesurée (deg)', 'effort': f'Axe {k} couple',
            'unit': 'deg'} for k in '12'}),
    # Numbers in all names are of joints, however few signals each of them has.
    ({'Axis 1 ActVelo [rad/s]': SPEED, 'Axis 2 ActPos [rad]': ARM}, {
        '1': {'velocity': 'Axis 1 ActVelo [rad/s]', 'unit': 'rad/s'},
        '2': {'position': 'Axis 2 ActPos [rad]', 'unit': 'rad'}})]


def test_roles_of_one_joint_and_of_several(new_folder):
    for columns, expected in ROLES:
        folder = new_folder()
        guess = guessed(load_table(csv(folder / 'log.csv', columns)))
        assert {role: block['column'] for role, block in guess.data['signals'].items()} == expected
    for columns, expected in ROBOTS:
        guess = guessed(load_table(csv(new_folder() / 'log.csv', {'t': T, **columns})))
        assert ('q0' in columns) == any('q0 is of joint_1' in text for text in guess.notes)
        assert ('current1' in columns) == ('effort: tau; not used: current' in guess.notes)
        assert {joint.removeprefix('joint_'): {
            name: value for role, block in own.items() for name, value in (
                (role, block['column']), ('unit', block.get('unit'))) if value}
            for joint, own in guess.data['joints'].items()} == expected
    fast = guessed(load_table(csv(new_folder() / 'log.csv', {
        'time': (T - T[0]) * 5e-5 / (T[1] - T[0]), 'q': ARM, 'tau': TORQUE})))
    assert fast.data['time'] == {'column': 'time'}  # 20 kHz in seconds, no minutes
    late = csv(new_folder() / 'log.csv', {'time': np.cumsum(0.11 + 0.01 * ARM), 'q': ARM})
    slow = csv(new_folder() / 'log.csv', {'time': np.arange(len(T)) * 200.0, 'q': ARM})
    days = csv(new_folder() / 'log.csv', {'time': 46082.5 + T / 86400.0, 'q': ARM})
    for path, says in ((late, '0.00011.* s in ms.*time=s or =ms'), (slow, '=ms or =us'),
                       (days, 'like a time')):
        with pytest.raises(Undecided, match=says):
            guessed(load_table(path))
    assert guessed(load_table(late), (), Answers(units={'time': 's'})).data['time'] == {
        'column': 'time'}
    with pytest.raises(InputError, match='no position'):  # not the elbow alone
        guessed(load_table(csv(new_folder() / 'log.csv', {
            't': T, 'elbow': ARM, 'hip': SPEED, 'goal/elbow': ARM})))


def test_names_of_joints_with_words_of_signals_beside_units_and_temperatures(tmp_path):
    columns = {'t': T}
    for k, joint in enumerate(('motor0', 'motor1', 'motor2'), 1):
        columns.update({f'{joint}.pos_estimate': k * ARM, f'{joint}.vel_estimate': k * SPEED,
                        f'{joint}.temp': 30.0 + 0.1 * ARM})
    guess = guessed(load_table(csv(tmp_path / 'log.csv', columns)))
    assert guess.data['joints'] == {joint: {
        'position': {'column': f'{joint}.pos_estimate', 'unit': 'turns'},
        'velocity': {'column': f'{joint}.vel_estimate', 'unit': 'turns/s'}}
        for joint in ('motor0', 'motor1', 'motor2')}


def test_runs_one_after_another_and_torques_with_gaps_are_asked_for(tmp_path, capsys):
    rows = ''.join(f'{run},{t!r},{q!r},{tau!r}\n' for run in ('slow', 'fast')
                   for t, q, tau in zip(T.tolist(), ARM.tolist(), TORQUE.tolist()))
    (tmp_path / 'runs.csv').write_text('trial,t,q,tau\n' + rows)
    assert main(['import', str(tmp_path / 'runs.csv'), '--guess']) == 3
    assert 't: starts again where trial changes' in capsys.readouterr().err
    (tmp_path / 'runs.csv').write_text('-,t,q,tau\n' + rows.replace('slow', 'fast'))
    assert main(['import', str(tmp_path / 'runs.csv'), str(tmp_path / 'bag')]) == 0
    gaps = np.where(np.arange(len(T)) % 50, TORQUE, np.nan)
    path = csv(tmp_path / 'two.csv', {'t': T, 'q': ARM, 'tau_meas': gaps,
                                      'torque_b': 0.9 * TORQUE + 50.0 * NOISE})
    assert main(['import', str(path), '--guess']) == 3
    assert 'no name tells which' in capsys.readouterr().err


def test_names_that_the_user_gives_to_columns_without(tmp_path, capsys):
    path = tmp_path / 'r.csv'
    np.savetxt(path, np.column_stack([T, ARM, 0.0 * T, TORQUE]), delimiter=',')
    names = ('--columns', 't,q,-,tau')
    assert main(['import', str(path), '--guess', *names]) == 0
    (tmp_path / 'map.yaml').write_text(capsys.readouterr().out)
    joints = imported(tmp_path, path, *names)
    (tmp_path / 'bag').rename(tmp_path / 'by_guess')
    for bag in (joints, imported(tmp_path, path, '--map', tmp_path / 'map.yaml')):
        np.testing.assert_array_equal(bag.position[:, 0], ARM)
        np.testing.assert_array_equal(bag.effort[:, 0], TORQUE)


def test_text_that_is_no_table_is_refused_by_name(tmp_path, capsys):
    for text, says in (
            ('<Rob TYPE="KUKA"><AIPos A1="1.0"/></Rob>\n', 'XML, as KUKA RSI writes it, expected'),
            ('0.1;1,234\n', 'expected one decimal mark, and none between thousands'),
            ('target:0.5,angle:0.4\n', 'a name beside each value, expected a table'),
            ('t: 0.1\nq: 0.2\n\n', 'a name beside each value, expected a table')):
        (tmp_path / 'log').write_text(text * 400)
        assert main(['import', str(tmp_path / 'log'), str(tmp_path / 'bag')]) == 2
        assert says in capsys.readouterr().err


def test_a_stated_motor_leaves_the_arm_open_where_two_positions_remain(tmp_path, capsys):
    path = csv(tmp_path / 'r.csv', {
        't': T, 'encoder [rad]': ARM, 'position [rad]': ARM + 0.01 * SPEED,
        'angle [rad]': ARM - 0.01 * SPEED, 'torque [N m]': TORQUE})
    motor = ('--use', 'motor=encoder [rad]')
    assert main(['import', str(path), *motor, str(tmp_path / 'bag')]) == 3
    assert 'no name tells the arm: --use' in capsys.readouterr().err
    joints = imported(tmp_path, path, *motor, '--use', 'arm=angle [rad]')
    np.testing.assert_array_equal(joints.position, np.column_stack([ARM, ARM - 0.01 * SPEED]))


def test_a_position_without_a_joint_among_joints_is_asked_for(tmp_path, capsys):
    """'a' may be amperes, so that three letters are two joints and one without a name."""
    path = csv(tmp_path / 'r.csv', {'t': T, **{f'enc_{x} [rad]': k * ARM for k, x in enumerate(
        'abc', 1)}, 'torque_b [N m]': TORQUE, 'torque_c [N m]': TORQUE})
    assert main(['import', str(path), str(tmp_path / 'bag')]) == 3
    assert 'enc_a [rad]: no joint in the name, beside those of b, c' in capsys.readouterr().err
    path = csv(tmp_path / 'r.csv', {'t': T, 'q_1 [deg]': ARM, 'angle [deg] q_2': ARM, 'q_3': ARM})
    assert main(['import', str(path), str(tmp_path / 'bag')]) == 3
    assert 'q_3: no unit in the file, beside others in deg: --unit joint_3=deg' in \
        capsys.readouterr().err
    assert not (tmp_path / 'bag').exists()
