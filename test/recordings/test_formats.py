# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What laboratories write: each format, clock, unit and coding, with exact values in the bag."""
from datetime import datetime, timedelta, timezone
import json
import math

import numpy as np
import pyarrow as pa
from pyarrow import feather, parquet
import pytest
import scipy.io
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.guess import Answers, guessed
from gearbox_monitor.recordings.mapping import load_mapping, mapping_of
from gearbox_monitor.recordings.meaning import standard_unit, unit_factor, unit_of_label
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.reading import open_recording, read_mapping
from gearbox_monitor.recordings.si_signals import signals_of
from gearbox_monitor.recordings.table import load_table

N = 200
K = np.arange(N)
T = K * 0.005
Q = np.round(np.sin(7.0 * T) + 0.3 * np.sin(17.0 * T), 6)
U = np.round(np.cos(7.0 * T), 6)
STAMPS = (1_000_000_000 + K * 5_000_000).tolist()
SIGNALS = {'motor_position': {'column': 2}, 'motor_effort': {'column': 3}}
FIELDS = {'motor_position': {'column': 'q'}, 'motor_effort': {'column': 'u'}}

EPOCH = 1_767_225_600_123_456_789  # ns


def mapping_from_dict(data, source):
    return data, source


def read_recording(path, mapping):
    """Return the signals of the file `path`, (content, source) of whose mapping is `mapping`."""
    data, source = mapping
    table = load_table(path)
    return signals_of(table, mapping_of(data, source, table.header))


def imported(tmp_path, mapping, path, *options):
    """Import `path` by the command; return the joint states of the bag."""
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump(mapping))
    bag = str(tmp_path / 'bag')
    assert main(['import', str(path), '--map', str(tmp_path / 'map.yaml'), *options, bag]) == 0
    with open_bag(bag) as reader:
        return reader.joint_states('/joint_states', ['motor', 'arm'])


def refused(tmp_path, capsys, mapping, path, *options):
    """Return the one line with which the command refuses `path`."""
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump(mapping))
    assert main(['import', str(path), '--map', str(tmp_path / 'map.yaml'), *options,
                 str(tmp_path / 'bag')]) == 2
    message = capsys.readouterr().err
    assert message.count('\n') == 1 and not (tmp_path / 'bag').exists()
    return message


def table(*columns, delimiter=',', head=''):
    return head + ''.join(delimiter.join(map(str, row)) + '\n' for row in zip(*columns))


def written(tmp_path, text, name='run.csv'):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def text_mapping(time=None, signals=None):
    return {'time': time or {'column': 1}, 'signals': signals or SIGNALS}


def assert_same(joints, stamps=STAMPS):
    assert joints.stamp_ns.tolist() == list(stamps)
    np.testing.assert_array_equal(joints.position[:, 0], Q)
    np.testing.assert_array_equal(joints.effort[:, 0], U)


# --- shapes -------------------------------------------------------------------------------------
def test_text_with_a_row_per_signal_is_refused(tmp_path, capsys):
    path = written(tmp_path, '\n'.join(','.join(map(str, row)) for row in (T, Q, U)))
    message = refused(tmp_path, capsys, text_mapping(), path)
    assert 'a row for each of 3 signals, expected a column for each: transpose it' in message


def test_a_line_without_an_end_is_no_table(tmp_path, capsys):
    path = written(tmp_path, 't,q\n' + '1,' * 3 * 2 ** 20)
    message = refused(tmp_path, capsys, text_mapping(), path)
    assert 'a line of more than 4 MB' in message


def test_mat_with_a_row_per_signal_is_recognised_by_its_shape(tmp_path, capsys):
    scipy.io.savemat(tmp_path / 'm.mat', {'M': np.array([T, Q, U])})
    mapping = {'time': {'column': 'M 1'},
               'signals': {name: {'column': f'M {place["column"]}'}
                           for name, place in SIGNALS.items()}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'm.mat'))
    assert 'M: one row per signal (3 rows of 200 samples)' in capsys.readouterr().out


def expect_rows(tmp_path, by_row, wrapped):
    rows = np.array([T, Q, U]) if by_row else np.array([T, Q, U]).T
    mapping = {'time': {'column': 1}, 'signals': SIGNALS}
    tree = {'data': rows.tolist()} if wrapped else rows.tolist()
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(tree), 'r.json')))


def test_json_rows_of_lists(new_folder):
    for by_row in (False, True):
        for wrapped in (False, True):
            expect_rows(new_folder(), by_row, wrapped)


def test_json_entries_with_a_list_of_joints(tmp_path):
    rows = [{'t': t, 'q': [0, 1, q], 'u': [9, u]} for t, q, u in zip(T, Q, U)]
    mapping = {'time': {'column': 't'}, 'signals': {
        'motor_position': {'column': 'q 3'}, 'motor_effort': {'column': 'u 2'}}}
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(rows), 'r.json')))
    rows = [{'t': t, 'name': ['elbow', 'wrist'], 'position': [q, u]} for t, q, u in zip(T, Q, U)]
    named = load_table(written(tmp_path, json.dumps(rows), 'named.json'))
    assert named.joints == ('elbow', 'wrist')
    rows[7]['name'].reverse()
    with pytest.raises(InputError, match='name: other joints in some entries'):
        load_table(written(tmp_path, json.dumps(rows), 'named.json'))


def test_structured_mat(tmp_path):
    """Of a Simulink scope: structure with time; and a struct array with an entry per sample."""
    signals = np.array([(Q[:, None], 'q'), (U[:, None], 'u')],
                       dtype=[('values', 'O'), ('label', 'O')])
    scope = {'time': T[:, None], 'signals': signals}
    scipy.io.savemat(tmp_path / 'm.mat', {'out': scope})
    mapping = {'time': {'column': 'out.time'}, 'signals': {
        'motor_position': {'column': 'out.signals.1.values'},
        'motor_effort': {'column': 'out.signals.2.values'}}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'm.mat'))
    samples = np.array(list(zip(T, Q, U)), dtype=[('t', 'O'), ('q', 'O'), ('u', 'O')])
    scipy.io.savemat(tmp_path / 's.mat', {'log': samples})
    fields = {name: {'column': f'log.{place["column"]}'} for name, place in FIELDS.items()}
    recording = read_recording(tmp_path / 's.mat', mapping_from_dict(
        {'time': {'column': 'log.t'}, 'signals': fields}, 'map'))
    np.testing.assert_array_equal(recording.values['motor_position'], Q)


def test_numpy_archive_and_matrix(tmp_path):
    np.savez(tmp_path / 'r.npz', t=T, q=Q, u=U)
    mapping = {'time': {'column': 't'}, 'signals': FIELDS}
    assert_same(imported(tmp_path, mapping, tmp_path / 'r.npz'))
    np.save(tmp_path / 'r.npy', np.array([T, Q, U]))
    recording = read_recording(tmp_path / 'r.npy', mapping_from_dict(
        {'time': {'column': 1}, 'signals': SIGNALS}, 'map'))
    np.testing.assert_array_equal(recording.values['motor_effort'], U)
    six = np.column_stack([Q] * 6)
    for size, says in ((5, f'tau: {len(T)} rows of 5 columns, expected 6, one of each joint'),
                       (6, f'tau: {len(T) - 1} rows of 6 columns, expected {len(T)}: not used')):
        np.savez(tmp_path / 'robot.npz', t=T, q=six, tau=six[:len(T) - size + 5, :size])
        guess = guessed(load_table(tmp_path / 'robot.npz'))
        assert says in ' '.join((*map(str, guess.questions), *load_table(
            tmp_path / 'robot.npz').notes))
        assert len(guess.questions) == 6 - size
    np.savez(tmp_path / 'robot.npz', t=T, q=six, tau=np.hstack([six, six[:, :1]]))
    stated = Answers(use={'effort': 'tau'})
    assert guessed(load_table(tmp_path / 'robot.npz')).questions and not guessed(
        load_table(tmp_path / 'robot.npz'), (), stated).questions


def test_hdf5_groups_compound_types_and_attributes(tmp_path, capsys):
    h5py = pytest.importorskip('h5py')
    with h5py.File(tmp_path / 'r.h5', 'w') as file:
        file['run/q'] = np.rad2deg(Q)
        file['run/q'].attrs['units'] = 'rad'
        file['run/log'] = np.array(list(zip(T, U)), dtype=[('t', 'f8'), ('u', 'f8')])
        file.attrs['ratio'] = 2.0
    mapping = {'time': {'column': 'run/log/t'},
               'gear_ratio': {'from_header': 'ratio'}, 'signals': {
                   'motor_position': {'column': 'run/q', 'unit': 'deg'},
                   'motor_effort': {'column': 'run.log.u'}}}
    joints = imported(tmp_path, mapping, tmp_path / 'r.h5')
    np.testing.assert_allclose(joints.position[:, 0], Q / 2.0, rtol=1e-14)
    np.testing.assert_array_equal(joints.effort[:, 0], 2.0 * U)


def test_mat_7_3(tmp_path):
    h5py = pytest.importorskip('h5py')
    with h5py.File(tmp_path / 'r.mat', 'w', userblock_size=512) as file:
        file['run/M'] = np.array([T, Q, U])  # MATLAB's 200 x 3
        file['run/M'].attrs['MATLAB_class'] = np.bytes_('double')
    with open(tmp_path / 'r.mat', 'r+b') as file:
        file.write(b'MATLAB 7.3 MAT-file'.ljust(124) + b'\x00\x02IM')
    mapping = {'time': {'column': 'run.M 1'},
               'signals': {name: {'column': f'run.M {place["column"]}'}
                           for name, place in SIGNALS.items()}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'r.mat'))


def test_parquet_and_feather_by_name(new_folder):
    for kind in ['parquet', 'feather']:
        folder = new_folder()
        data = pa.table({'when': pa.array(EPOCH + K * 5_000_000, pa.timestamp('ns', 'UTC')),
                         'joint': pa.array([{'q': q, 'u': [0.0, u]} for q, u in zip(Q, U)])},
                        metadata={'ratio': '1'})
        (parquet.write_table if kind == 'parquet' else feather.write_feather)(data, folder / 'r')
        mapping = {'time': {'column': 'when'},
                   'gear_ratio': {'from_header': 'ratio'}, 'signals': {
                       'motor_position': {'column': 'joint.q'},
                       'motor_effort': {'column': 'joint.u.2'}}}
        assert_same(imported(folder, mapping, folder / 'r'), (EPOCH + K * 5_000_000).tolist())


def test_several_header_rows_and_names_in_the_last_comment(tmp_path):
    head = 'preamble\nmotor,motor,\nposition,torque,time\nrad,N m,s\n'
    path = written(tmp_path, table(Q, U, T, head=head))
    signals = {'motor_position': {'column': 'motor position'},
               'motor_effort': {'column': 'torque'}}
    mapping = text_mapping({'column': 'time'}, signals)
    assert_same(imported(tmp_path, mapping, path))
    np.savetxt(tmp_path / 's.txt', np.column_stack([T, Q, U]), fmt='%.17g', header='made\nt q u')
    signals = {'motor_position': {'column': 'q'}, 'motor_effort': {'column': 'u'}}
    recording = read_recording(tmp_path / 's.txt', mapping_from_dict(text_mapping(
        {'column': 't'}, signals), 'map'))
    np.testing.assert_array_equal(recording.values['motor_position'], Q)


def test_pairs_of_columns_with_their_own_times(tmp_path, capsys):
    """X,Y pairs of unequal length: the shorter one ends in empty cells."""
    slow = slice(None, None, 2)
    rows = [[t, q, '', ''] for t, q in zip(T, Q)]
    for row, t, u in zip(rows, T[slow], U[slow]):
        row[2:] = t, u
    path = written(tmp_path, 't,q,t2,u\n' + ''.join(','.join(map(str, r)) + '\n' for r in rows))
    mapping = text_mapping(signals={'motor_position': {'column': 2}, 'motor_effort': {
        'column': 4, 'time': {'column': 3}}})
    joints = imported(tmp_path, mapping, path)
    assert joints.stamp_ns.tolist() == STAMPS
    np.testing.assert_array_equal(joints.effort[slow, 0], U[slow])
    np.testing.assert_allclose(joints.effort[1:-1:2, 0], (U[:-2:2] + U[2::2]) / 2, rtol=1e-12)
    assert np.isnan(joints.effort[-1, 0])  # after the last one: nothing is invented
    assert 'motor_effort: 100 samples of another clock' in capsys.readouterr().out


# --- times --------------------------------------------------------------------------------------
def expect_stamps(tmp_path, unit, decimal):
    digits = {'s': 9, 'ms': 6, 'us': 3, 'ns': 0}[unit]
    stamps = [EPOCH + int(k) * 5_000_000 for k in K]
    texts = [f'{s // 10 ** digits}{decimal}{s % 10 ** digits:0{digits}d}' if digits else str(s)
             for s in stamps]
    path = written(tmp_path, table(texts, Q, U, delimiter=';').replace('.', decimal))
    mapping = text_mapping({'column': 1, 'unit': unit})
    assert_same(imported(tmp_path, mapping, path), stamps)


def test_epochs_keep_their_nanoseconds(new_folder):
    for unit in ('s', 'ms', 'us', 'ns'):
        for decimal in ('.', ','):
            expect_stamps(new_folder(), unit, decimal)
    rows = [f'{50_000 * k},{q},{u}' for k, q, u in zip(K, Q, U)]
    path = written(new_folder(), '\n'.join(['Time [100ns],q,tau', *rows]), 'r.csv')
    assert guessed(load_table(path)).data['time'] == {
        'column': 'Time [100ns]', 'unit': 'ns', 'scale': 100.0}


def expect_iso(tmp_path, form):
    texts = [form.format(f'00:00:{s // 10 ** 9:02d}.{s % 10 ** 9:09d}')
             for s in (int(k) * 5_000_000 for k in K)]
    mapping = text_mapping({'column': 1, 'unit': 'iso8601'})
    epoch = int(datetime(2026, 1, 1, tzinfo=timezone.utc).timestamp()) * 10 ** 9
    assert_same(imported(tmp_path, mapping, written(tmp_path, table(texts, Q, U))),
                (epoch + K * 5_000_000).tolist())


def test_iso_8601(new_folder):
    for form in ('2026-01-01T{}Z', '2026-01-01 {}', '2026-01-01T{}+00:00'):
        expect_iso(new_folder(), form)
    start = np.datetime64('2026-01-01T00:00:00.000000')  # slow, and not quite even
    rows = [f'{start + int(101_000 * k + 900 * (k % 3))},{q},{u}' for k, q, u in zip(K, Q, U)]
    path = written(new_folder(), '\n'.join(['time,q,tau', *rows]), 'r.csv')
    table, mapping, _ = read_mapping(path)
    steps = np.diff(signals_of(table, mapping).stamp_ns)
    assert set(steps.tolist()) == {101_900_000, 99_200_000}


def test_iso_8601_with_a_zone_in_json(tmp_path):
    zone = timezone(timedelta(hours=5, minutes=30))
    start = datetime(2026, 1, 1, 5, 30, tzinfo=zone)
    rows = [{'t': (start + timedelta(milliseconds=5 * int(k))).isoformat(), 'q': q, 'u': u}
            for k, q, u in zip(K, Q, U)]
    mapping = {'signals': FIELDS, 'time': {
        'column': 't', 'unit': 'iso8601'}}
    epoch = int(datetime(2026, 1, 1, tzinfo=timezone.utc).timestamp()) * 10 ** 9
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(rows), 'r.json')),
                (epoch + K * 5_000_000).tolist())


def test_stamps_are_kept_as_recorded(tmp_path):
    t = T.copy()
    t[11], t[12] = t[10], t[9] + 0.001
    recording = read_recording(written(tmp_path, table(t, Q, U)), (text_mapping(), 'map'))
    np.testing.assert_array_equal(np.rint((recording.stamp_ns - 10 ** 9) * 1e-6),
                                  np.rint(t * 1e3))


# --- units, codings, velocities -----------------------------------------------------------------
CODINGS = [
    ('motor_position', {'unit': 'deg'}, 180.0, math.pi),
    ('motor_position', {'unit': 'turns'}, 0.5, math.pi),
    ('arm_position', {'unit': 'mrad', 'sign': -1}, 500.0, -0.5),
    ('motor_position', {'unit': 'counts', 'counts_per_rev': 4096, 'zero': 1024}, 3072, math.pi),
    ('motor_position', {'unit': 'counts', 'scale': 0.25, 'offset': 1.0}, 4, 2.0),
    ('motor_velocity', {'unit': 'rpm'}, 30.0, math.pi),
    ('arm_velocity', {'unit': 'counts/s', 'counts_per_rev': 1000}, 500, math.pi),
    ('motor_effort', {'unit': 'N mm'}, 250.0, 0.25),
    ('motor_effort', {'unit': 'mA', 'torque_constant': 0.5}, 250.0, 0.125),
    ('motor_effort', {'unit': '%', 'torque_constant': 8.0}, 25.0, 2.0),
    ('arm_effort', {'unit': 'lbf in'}, 1.0, 0.1129848290276167),
    ('motor_effort', {'bits': 11, 'coding': 'sign_magnitude', 'scale': 0.5}, 1024 + 7, -3.5),
    ('motor_effort', {'bits': 11, 'coding': 'sign_magnitude', 'scale': 0.5}, 7, 3.5),
    ('motor_effort', {'bits': 8, 'scale': 0.5, 'offset': 1.0, 'sign': -1}, 254, 0.0),
]


def expect_value(tmp_path, name, keys, raw, value):
    signals = {'arm_position' if name == 'motor_position' else 'motor_position': {'column': 1},
               name: {'column': 2, **keys}}
    mapping = mapping_from_dict(text_mapping(signals=signals), 'map')
    recording = read_recording(written(tmp_path, table(T, [raw] * N)), mapping)
    np.testing.assert_allclose(recording.values[name], value, rtol=1e-15, atol=1e-15)


def test_units_and_codings(new_folder):
    for name, keys, raw, value in CODINGS:
        expect_value(new_folder(), name, keys, raw, value)


NO_UNITS = [
    ('motor_position', {'unit': 'mm'}, "signals.motor_position.unit: 'mm', expected a unit of "
     'position on a rotary axis: rad, mrad, deg'),
    ('motor_effort', {'unit': 'rad'}, 'expected a unit of effort on a rotary axis'),
    ('motor_position', {'unit': 'counts'}, 'expected counts_per_rev or scale'),
    ('motor_position', {'unit': 'deg', 'counts_per_rev': 9},
     "signals.motor_position.counts_per_rev: with unit 'deg'"),
    ('motor_effort', {'coding': 'sign_magnitude'}, 'signals.motor_effort.bits: missing'),
    ('motor_effort', {'time': {'column': 1, 'start_stamp_ns': 1}}, 'time.start_stamp_ns: unknown'),
]


def test_units_are_checked():
    for name, keys, expected in NO_UNITS:
        signals = {'arm_position': {'column': 2}, name: {'column': 2, **keys}}
        with pytest.raises(InputError, match='map: ') as error:
            mapping_of(text_mapping(signals=signals), 'map', {})
        assert expected in str(error.value)


def test_spellings_of_units():
    spellings = {'Nm': 'N m', 'N*m': 'N m', 'N·m': 'N m', 'Degrees': 'deg', 'rev/min': 'rpm',
                 'µs': 'us', 'x': '', 'deg/sec': 'deg/s', 'rad s^-1': 'rad/s', 'cNm': 'N cm',
                 'in-lb': 'lbf in', 'U/min': 'rpm', 'A rms': 'A', 'inches': 'in', 'MA': ''}
    assert {text: standard_unit(text) for text in spellings} == spellings
    labels = {'q [deg]': 'deg', 'q_deg': 'deg', 'tau(Nm)': 'N m', 'time_m': '', 'i [Amps]': 'A'}
    assert {text: unit_of_label(text)[1] for text in labels} == labels
    assert unit_factor('kN', 'effort', 'prismatic') == (1e3, True)


def test_velocity_is_integrated_where_there_is_no_position(tmp_path, capsys):
    v = 3.0 * T ** 2  # the trapezoidal rule errs by h^2 t / 2 here
    mapping = text_mapping(signals={'motor_velocity': {'column': 2, 'unit': 'rad/s'}})
    mapping['gear_ratio'] = 2.0
    joints = imported(tmp_path, mapping, written(tmp_path, table(T, v)))
    np.testing.assert_allclose(joints.position[:, 0], (T ** 3 + 0.005 ** 2 * T / 2) / 2,
                               atol=1e-14)
    np.testing.assert_array_equal(joints.velocity[:, 0], v / 2.0)
    assert 'motor_position: integrated from motor_velocity' in capsys.readouterr().out


def test_velocity_beside_a_position_is_kept_as_such(tmp_path):
    mapping = text_mapping(signals={'arm_position': {'column': 2}, 'arm_velocity': {'column': 3}})
    joints = imported(tmp_path, mapping, written(tmp_path, table(T, Q, U)))
    np.testing.assert_array_equal(joints.position[:, 1], Q)
    np.testing.assert_array_equal(joints.velocity[:, 1], U)


# --- one mapping, many files --------------------------------------------------------------------
def test_values_by_command_line_and_from_the_header(tmp_path, capsys):
    head = '# zero_count=100\n# ratio: 4\n'
    path = written(tmp_path, table(T, K, U, head=head))
    mapping = text_mapping()
    mapping['gear_ratio'] = {'from_header': 'ratio'}
    mapping['signals'] = {'motor_position': {
        'column': 2, 'zero': {'from_header': 'zero_count', 'scale': -1.0}},
        'motor_effort': {'column': 3}}
    joints = imported(tmp_path, mapping, path, '--set', 'signals.motor_effort.sign=-1')
    np.testing.assert_array_equal(joints.position[:, 0], (K + 100) / 4)
    np.testing.assert_array_equal(joints.effort[:, 0], -4.0 * U)
    with open_bag(tmp_path / 'bag') as reader:
        record = yaml.safe_load(reader.metadata['import']['mapping'])
    assert record['signals']['motor_effort']['sign'] == -1
    (tmp_path / 'bag').rename(tmp_path / 'other')
    mapping['gear_ratio']['from_header'] = 'i'
    assert "gear_ratio: no number 'i' in the header" in refused(tmp_path, capsys, mapping, path)
    assert 'expected KEY=VALUE' in refused(tmp_path, capsys, mapping, path, '--set', 'sign')


# --- what makes no sense ------------------------------------------------------------------------
UNLIKELY = [
    (K * 1.0, 's', '200 samples, one per 1 s, expected one per 5e-06 to 0.5 s (time read '
     'in s: is time.unit right?)'),
    (T, 'us', 'one per 5e-09 s'), (K[:60] * 0.01, 's', '3 columns of 60 numbers'),
    (1.7e12 + K, 's', 'expected one > 0 and < 2^31 s')]


def expect_a_word(tmp_path, capsys, time, unit, expected):
    mapping = text_mapping({'column': 1, 'unit': unit})
    path = written(tmp_path, table([f'{t:.6f}' for t in time], Q, U))
    message = refused(tmp_path, capsys, mapping, path)
    assert str(path) in message and expected in message


def test_stamps_in_a_wrong_unit_and_short_recordings(new_folder, capsys):
    for time, unit, expected in UNLIKELY:
        expect_a_word(new_folder(), capsys, time, unit, expected)


def test_packaged_mappings_load():
    for name in ('davinci_backend', 'emps', 'bam_servo_pendulum'):
        assert mapping_of(*load_mapping(name), None).signals


@pytest.mark.parametrize('text', ['plain', 'blanks', 'epoch', 'robot'])
def test_a_long_text_is_read_in_blocks_as_a_short_one_at_once(tmp_path, monkeypatch, text):
    rows = [[f'{t:.6f}', q, u, 0.5 * q] for t, q, u in zip(T, Q, U)]
    if text == 'blanks':
        rows[7][2], rows[50][1] = '', 'nan'
    if text == 'epoch':
        rows = [[f'{1767225600 + k // 200}.{k % 200 * 5_000_000 + 123:09d}', *row[1:]]
                for k, row in enumerate(rows)]
    head = 't,q_a,tau_a,setpoint_a' if text == 'robot' else 't,motor,u,arm'
    path = written(tmp_path, head + '\n# a comment\n' + ''.join(
        ','.join(map(str, row)) + '\n' for row in rows))
    found = []
    for block in (1 << 22, 6000):
        monkeypatch.setattr('gearbox_monitor.recordings.table.BLOCK', block)
        monkeypatch.setattr('gearbox_monitor.recordings.text.BLOCK', block)
        with open_recording(path) as reader:
            found.append([reader.joint_states(topic, reader.joint_names(topic))
                          for topic in reader.topics])
            begin, end = reader.start_ns, reader.end_ns
    for whole, streamed in zip(*found):
        assert whole.names == streamed.names and len(streamed.stamp_ns) == N
        for field in ('stamp_ns', 'position', 'velocity', 'effort'):
            np.testing.assert_array_equal(getattr(streamed, field), getattr(whole, field))
    assert begin == found[0][0].stamp_ns[0] and abs(end - found[0][0].stamp_ns[-1]) < 5e7
