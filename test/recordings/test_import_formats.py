# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What laboratories write: each format, clock, unit and coding, with exact values in the bag."""
from datetime import datetime, timedelta, timezone
import json
import math
import sys

import numpy as np
import pyarrow as pa
from pyarrow import feather, parquet
import pytest
import scipy.io
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.recordings.importer import load_mapping, read_recording
from gearbox_monitor.recordings.importer.mapping import mapping_from_dict
from gearbox_monitor.recordings.importer.unit_table import (
    standard_unit, unit_factor, unit_of_label)
from gearbox_monitor.recordings.read import open_bag

N = 200
K = np.arange(N)
T = K * 0.005
Q = np.round(np.sin(7.0 * T) + 0.3 * np.sin(17.0 * T), 6)
U = np.round(np.cos(7.0 * T), 6)
STAMPS = (1_000_000_000 + K * 5_000_000).tolist()
SIGNALS = {'motor_position': {'column': 2}, 'motor_effort': {'column': 3}}
FIELDS = {'motor_position': {'field': 'q'}, 'motor_effort': {'field': 'u'}}
EPOCH = 1_767_225_600_123_456_789  # ns


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


def text_mapping(time=None, signals=None, **text):
    return {'format': 'text', 'text': text, 'time': time or {'column': 1},
            'signals': signals or SIGNALS}


def assert_same(joints, stamps=STAMPS):
    assert joints.stamp_ns.tolist() == list(stamps)
    np.testing.assert_array_equal(joints.position[:, 0], Q)
    np.testing.assert_array_equal(joints.effort[:, 0], U)


# --- shapes -------------------------------------------------------------------------------------
def test_text_with_a_row_per_signal_is_recognised_by_its_shape(tmp_path, capsys):
    path = written(tmp_path, '\n'.join(','.join(map(str, row)) for row in (T, Q, U)))
    assert_same(imported(tmp_path, text_mapping(), path))
    assert 'one row per signal (3 rows of 200 samples)' in capsys.readouterr().out


def test_text_with_a_row_per_signal_has_its_names_in_front(tmp_path):
    path = written(tmp_path, '\n'.join(','.join(map(str, (name, *row))) for name, row in (
        ('u', U), ('t', T), ('q', Q))))
    signals = {'motor_position': {'column': 'q'}, 'motor_effort': {'column': 'u'}}
    assert_same(imported(tmp_path, text_mapping({'column': 't'}, signals, header=True), path))


def test_mat_with_a_row_per_signal_is_recognised_by_its_shape(tmp_path, capsys):
    scipy.io.savemat(tmp_path / 'm.mat', {'M': np.array([T, Q, U])})
    mapping = {'format': 'mat', 'time': {'field': 'M', 'column': 1},
               'signals': {name: {'field': 'M', **place} for name, place in SIGNALS.items()}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'm.mat'))
    assert 'field M: one row per signal (3 rows of 200 samples)' in capsys.readouterr().out


@pytest.mark.parametrize('by_row', [False, True])
@pytest.mark.parametrize('wrapped', [False, True])
def test_json_rows_of_lists(tmp_path, by_row, wrapped):
    rows = np.array([T, Q, U]) if by_row else np.array([T, Q, U]).T
    mapping = {'format': 'json', 'time': {'column': 1}, 'signals': SIGNALS}
    if wrapped:
        mapping['json'] = {'entries': 'data'}
    tree = {'data': rows.tolist()} if wrapped else rows.tolist()
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(tree), 'r.json')))


def test_json_entries_with_a_list_of_joints(tmp_path):
    rows = [{'t': t, 'q': [0, 1, q], 'u': [9, u]} for t, q, u in zip(T, Q, U)]
    mapping = {'format': 'json', 'time': {'field': 't'}, 'signals': {
        'motor_position': {'field': 'q', 'column': 3},
        'motor_effort': {'field': 'u', 'column': 2}}}
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(rows), 'r.json')))


def test_structured_mat(tmp_path):
    """Of a Simulink scope: structure with time; and a struct array with an entry per sample."""
    signals = np.array([(Q[:, None], 'q'), (U[:, None], 'u')],
                       dtype=[('values', 'O'), ('label', 'O')])
    scope = {'time': T[:, None], 'signals': signals}
    scipy.io.savemat(tmp_path / 'm.mat', {'out': scope})
    mapping = {'format': 'mat', 'time': {'field': 'out.time'}, 'signals': {
        'motor_position': {'field': 'out.signals.1.values'},
        'motor_effort': {'field': 'out.signals.2.values'}}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'm.mat'))
    samples = np.array(list(zip(T, Q, U)), dtype=[('t', 'O'), ('q', 'O'), ('u', 'O')])
    scipy.io.savemat(tmp_path / 's.mat', {'log': samples})
    fields = {name: {'field': f'log.{place["field"]}'} for name, place in FIELDS.items()}
    recording = read_recording(tmp_path / 's.mat', mapping_from_dict(
        {'format': 'mat', 'time': {'field': 'log.t'}, 'signals': fields}, 'map'))
    np.testing.assert_array_equal(recording.motor_position, Q)


def test_numpy_archive_and_matrix(tmp_path):
    np.savez(tmp_path / 'r.npz', t=T, q=Q, u=U)
    mapping = {'format': 'numpy', 'time': {'field': 't'}, 'signals': FIELDS}
    assert_same(imported(tmp_path, mapping, tmp_path / 'r.npz'))
    np.save(tmp_path / 'r.npy', np.array([T, Q, U]))
    recording = read_recording(tmp_path / 'r.npy', mapping_from_dict(
        {'format': 'numpy', 'time': {'column': 1}, 'signals': SIGNALS}, 'map'))
    np.testing.assert_array_equal(recording.motor_effort, U)


def test_hdf5_groups_compound_types_and_attributes(tmp_path, capsys):
    h5py = pytest.importorskip('h5py')
    with h5py.File(tmp_path / 'r.h5', 'w') as file:
        file['run/q'] = np.rad2deg(Q)
        file['run/q'].attrs['units'] = 'rad'
        file['run/log'] = np.array(list(zip(T, U)), dtype=[('t', 'f8'), ('u', 'f8')])
        file.attrs['ratio'] = 2.0
    mapping = {'format': 'hdf5', 'time': {'field': 'run/log/t'},
               'gear_ratio': {'from_header': 'ratio'}, 'signals': {
                   'motor_position': {'field': 'run/q', 'unit': 'deg'},
                   'motor_effort': {'field': 'run.log.u'}}}
    joints = imported(tmp_path, mapping, tmp_path / 'r.h5')
    np.testing.assert_allclose(joints.position[:, 0], Q / 2.0, rtol=1e-14)
    np.testing.assert_array_equal(joints.effort[:, 0], 2.0 * U)
    assert 'unit deg in the mapping, rad in the recording' in capsys.readouterr().out


def test_mat_7_3(tmp_path):
    h5py = pytest.importorskip('h5py')
    with h5py.File(tmp_path / 'r.mat', 'w', userblock_size=512) as file:
        file['run/M'] = np.array([T, Q, U])  # MATLAB's 200 x 3
        file['run/M'].attrs['MATLAB_class'] = np.bytes_('double')
    with open(tmp_path / 'r.mat', 'r+b') as file:
        file.write(b'MATLAB 7.3 MAT-file'.ljust(124) + b'\x00\x02IM')
    mapping = {'format': 'mat', 'time': {'field': 'run.M', 'column': 1},
               'signals': {name: {'field': 'run.M', **place} for name, place in SIGNALS.items()}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'r.mat'))


def test_a_reader_that_is_not_installed_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'h5py', None)
    mapping = {'format': 'hdf5', 'time': {'field': 't'}, 'signals': FIELDS}
    message = refused(tmp_path, capsys, mapping, written(tmp_path, 'x', 'r.h5'))
    assert 'r.h5: h5py is not installed, expected it for this format: pip install h5py' in message


@pytest.mark.parametrize('kind', ['parquet', 'feather'])
def test_parquet_and_feather_by_name(tmp_path, kind):
    data = pa.table({'when': pa.array(EPOCH + K * 5_000_000, pa.timestamp('ns', 'UTC')),
                     'joint': pa.array([{'q': q, 'u': [0.0, u]} for q, u in zip(Q, U)])},
                    metadata={'ratio': '1'})
    (parquet.write_table if kind == 'parquet' else feather.write_feather)(data, tmp_path / 'r')
    mapping = {'format': kind, 'time': {'column': 'when', 'start_stamp_ns': 'recorded'},
               'gear_ratio': {'from_header': 'ratio'}, 'signals': {
                   'motor_position': {'column': 'joint.q'},
                   'motor_effort': {'column': 'joint.u.2'}}}
    assert_same(imported(tmp_path, mapping, tmp_path / 'r'), (EPOCH + K * 5_000_000).tolist())


def test_several_header_rows_and_names_in_the_last_comment(tmp_path):
    head = 'preamble\nmotor,motor,\nposition,torque,time\nrad,N m,s\n'
    path = written(tmp_path, table(Q, U, T, head=head))
    signals = {'motor_position': {'column': 'motor position rad'},
               'motor_effort': {'column': 'torque'}}
    mapping = text_mapping({'column': 'time'}, signals, header=3, skip=1)
    assert_same(imported(tmp_path, mapping, path))
    np.savetxt(tmp_path / 's.txt', np.column_stack([T, Q, U]), fmt='%.17g', header='made\nt q u')
    signals = {'motor_position': {'column': 'q'}, 'motor_effort': {'column': 'u'}}
    recording = read_recording(tmp_path / 's.txt', mapping_from_dict(text_mapping(
        {'column': 't'}, signals, header='comment', delimiter='whitespace'), 'map'))
    np.testing.assert_array_equal(recording.motor_position, Q)


def test_pairs_of_columns_with_their_own_times(tmp_path, capsys):
    """X,Y pairs of unequal length: the shorter one ends in empty cells."""
    slow = slice(None, None, 2)
    rows = [[t, q, '', ''] for t, q in zip(T, Q)]
    for row, t, u in zip(rows, T[slow], U[slow]):
        row[2:] = t, u
    path = written(tmp_path, 't,q,t2,u\n' + ''.join(','.join(map(str, r)) + '\n' for r in rows))
    mapping = text_mapping(signals={'motor_position': {'column': 2}, 'motor_effort': {
        'column': 4, 'time': {'column': 3}}}, header=True)
    joints = imported(tmp_path, mapping, path)
    assert joints.stamp_ns.tolist() == STAMPS
    np.testing.assert_array_equal(joints.effort[slow, 0], U[slow])
    np.testing.assert_allclose(joints.effort[1:-1:2, 0], (U[:-2:2] + U[2::2]) / 2, rtol=1e-12)
    assert np.isnan(joints.effort[-1, 0])  # after the last one: nothing is invented
    assert 'motor_effort: 100 samples of another clock' in capsys.readouterr().out


# --- times --------------------------------------------------------------------------------------
@pytest.mark.parametrize('unit', ['s', 'ms', 'us', 'ns'])
@pytest.mark.parametrize('decimal', ['.', ','])
def test_epochs_keep_their_nanoseconds(tmp_path, unit, decimal):
    digits = {'s': 9, 'ms': 6, 'us': 3, 'ns': 0}[unit]
    stamps = [EPOCH + int(k) * 5_000_000 for k in K]
    texts = [f'{s // 10 ** digits}{decimal}{s % 10 ** digits:0{digits}d}' if digits else str(s)
             for s in stamps]
    path = written(tmp_path, table(texts, Q, U, delimiter=';').replace('.', decimal))
    mapping = text_mapping({'column': 1, 'unit': unit, 'start_stamp_ns': 'recorded'},
                           delimiter=';', decimal=decimal)
    assert_same(imported(tmp_path, mapping, path), stamps)


@pytest.mark.parametrize('form', ['2026-01-01T{}Z', '2026-01-01 {}', '2026-01-01T{}+00:00'])
def test_iso_8601(tmp_path, form):
    texts = [form.format(f'00:00:{s // 10 ** 9:02d}.{s % 10 ** 9:09d}')
             for s in (int(k) * 5_000_000 for k in K)]
    mapping = text_mapping({'column': 1, 'unit': 'iso8601', 'start_stamp_ns': 'recorded'})
    epoch = int(datetime(2026, 1, 1, tzinfo=timezone.utc).timestamp()) * 10 ** 9
    assert_same(imported(tmp_path, mapping, written(tmp_path, table(texts, Q, U))),
                (epoch + K * 5_000_000).tolist())


def test_iso_8601_with_a_zone_in_json(tmp_path):
    zone = timezone(timedelta(hours=5, minutes=30))
    start = datetime(2026, 1, 1, 5, 30, tzinfo=zone)
    rows = [{'t': (start + timedelta(milliseconds=5 * int(k))).isoformat(), 'q': q, 'u': u}
            for k, q, u in zip(K, Q, U)]
    mapping = {'format': 'json', 'signals': FIELDS, 'time': {
        'field': 't', 'unit': 'iso8601', 'start_stamp_ns': 'recorded'}}
    epoch = int(datetime(2026, 1, 1, tzinfo=timezone.utc).timestamp()) * 10 ** 9
    assert_same(imported(tmp_path, mapping, written(tmp_path, json.dumps(rows), 'r.json')),
                (epoch + K * 5_000_000).tolist())


def repeated(tmp_path, time):
    """Return the recording of 200 rows, of which 10 and 11 have one stamp; 12 comes before it."""
    t = T.copy()
    t[11], t[12] = t[10], t[9] + 0.001
    mapping = mapping_from_dict(text_mapping({'column': 1, **time}), 'map')
    return read_recording(written(tmp_path, table(t, Q, U)), mapping)


@pytest.mark.parametrize('policy, expected', [
    ('first', [Q[9], Q[12], Q[10], Q[13]]), ('drop', [Q[9], Q[12], Q[13]]),
    ('average', [Q[9], Q[12], (Q[10] + Q[11]) / 2, Q[13]])])
def test_repeated_and_unordered_stamps(tmp_path, policy, expected):
    recording = repeated(tmp_path, {'repeated': policy, 'unordered': 'sort'})
    np.testing.assert_array_equal(recording.motor_position[9:9 + len(expected)], expected)
    assert (np.diff(recording.stamp_ns) > 0).all()
    assert any('1 stamps of more than one sample' in n for n in recording.notices)
    assert any('1 of 200 samples with an earlier stamp' in n for n in recording.notices)


def test_unordered_samples_dropped_and_policies_named(tmp_path):
    recording = repeated(tmp_path, {'repeated': 'first', 'unordered': 'drop'})
    np.testing.assert_array_equal(recording.motor_position[9:12], [Q[9], Q[10], Q[13]])
    with pytest.raises(InputError, match=r'line 12, .* time.repeated: first, average or drop'):
        repeated(tmp_path, {'unordered': 'sort'})
    with pytest.raises(InputError, match='time.unordered: sort or drop|time.repeated'):
        repeated(tmp_path, {'repeated': 'first'})


# --- units, codings, velocities -----------------------------------------------------------------
@pytest.mark.parametrize('name, keys, raw, value', [
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
])
def test_units_and_codings(tmp_path, name, keys, raw, value):
    signals = {'arm_position' if name == 'motor_position' else 'motor_position': {'column': 1},
               name: {'column': 2, **keys}}
    mapping = mapping_from_dict(text_mapping(signals=signals), 'map')
    recording = read_recording(written(tmp_path, table(T, [raw] * N)), mapping)
    np.testing.assert_allclose(getattr(recording, name), value, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize('name, keys, expected', [
    ('motor_position', {'unit': 'mm'}, "signals.motor_position.unit: 'mm', expected a unit of "
     'position on a rotary axis: rad, mrad, deg'),
    ('motor_effort', {'unit': 'rad'}, 'expected a unit of effort on a rotary axis'),
    ('motor_effort', {'unit': 'A'}, "unit: 'A' needs a factor to SI, expected torque_constant"),
    ('arm_effort', {'unit': 'A'}, "unit: 'A' needs a factor to SI, expected scale"),
    ('motor_position', {'unit': 'counts'}, 'expected counts_per_rev or scale beside it'),
    ('motor_position', {'unit': 'deg', 'counts_per_rev': 9},
     "signals.motor_position.counts_per_rev: beside unit 'deg'"),
    ('motor_effort', {'coding': 'sign_magnitude'}, 'signals.motor_effort.bits: missing'),
    ('motor_effort', {'time': {'column': 1, 'start_stamp_ns': 1}}, 'time.start_stamp_ns: unknown'),
])
def test_units_are_checked(name, keys, expected):
    signals = {'arm_position': {'column': 2}, name: {'column': 2, **keys}}
    with pytest.raises(InputError, match='map: ') as error:
        mapping_from_dict(text_mapping(signals=signals), 'map')
    assert expected in str(error.value)


def test_spellings_of_units():
    spellings = {'Nm': 'N m', 'N*m': 'N m', 'N·m': 'N m', 'Degrees': 'deg', 'rev/min': 'rpm',
                 'µs': 'us', 'x': ''}
    assert {text: standard_unit(text) for text in spellings} == spellings
    labels = {'q [deg]': 'deg', 'q_deg': 'deg', 'tau(Nm)': 'N m', 'time_m': '', 'i [Amps]': 'A'}
    assert {text: unit_of_label(text) for text in labels} == labels
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


# --- two files ----------------------------------------------------------------------------------
TRUE_LAG = 0.1375
FINE = np.arange(4000) * 0.002
COARSE = np.arange(1500) * 0.005 + 0.3


def motion(t):
    """Return a motion that does not repeat within 8 s."""
    return np.sin(3.1 * t) + 0.5 * np.sin(7.7 * t + 1.0) + 0.2 * np.sin(2.3 * t ** 1.3)


def two_files(tmp_path, lag, name='arm_position'):
    """Return (recording, response at the first file's stamps) of two files of one run."""
    acceleration = np.gradient(np.gradient(motion(FINE), FINE), FINE)
    response = {'arm_position': motion(FINE), 'motor_effort': 0.01 * acceleration + 0.3 * np.tanh(
        20.0 * np.gradient(motion(FINE), FINE))}[name]
    written(tmp_path, table(FINE, motion(FINE)), 'run7.csv')
    written(tmp_path, table(COARSE - TRUE_LAG + 50.0, np.interp(COARSE, FINE, response)),
            'run7_b.csv')
    mapping = text_mapping(signals={'motor_position': {'column': 2}})
    mapping['second_file'] = {'path': '{stem}_b.csv', 'lag': lag, 'format': 'text',
                              'time': {'column': 1}, 'signals': {name: {'column': 2}}}
    return read_recording(tmp_path / 'run7.csv', mapping_from_dict(mapping, 'map')), response


def test_second_file_with_a_stated_lag(tmp_path):
    recording, response = two_files(tmp_path, TRUE_LAG - 50.0)
    inside = ~np.isnan(recording.arm_position)
    assert FINE[inside][0] == pytest.approx(0.3) and inside.sum() > 3700
    np.testing.assert_allclose(recording.arm_position[inside], response[inside], atol=4e-4)


@pytest.mark.parametrize('name', ['arm_position', 'motor_effort'])
def test_second_file_with_an_estimated_lag(tmp_path, name):
    recording, _ = two_files(tmp_path, 'estimated', name)
    notice = next(n for n in recording.notices if 'run7_b.csv: its clock is' in n)
    lag = float(notice.split('is ')[1].split(' s')[0])
    assert abs(lag - (TRUE_LAG - 50.0)) < (1e-4 if name == 'arm_position' else 2e-3)


def test_no_lag_is_estimated_from_a_periodic_motion_or_from_noise(tmp_path):
    mapping = text_mapping(signals={'motor_position': {'column': 2}})
    mapping['second_file'] = {'path': 'b.csv', 'lag': 'estimated', 'format': 'text',
                              'time': {'column': 1}, 'signals': {'arm_position': {'column': 2}}}
    mapping = mapping_from_dict(mapping, 'map')
    written(tmp_path, table(FINE, np.sin(6.0 * FINE)), 'a.csv')
    noise = np.random.default_rng(1).standard_normal(len(FINE))
    for values, expected in ((np.sin(6.0 * FINE + 1.0), 'a periodic motion'),
                             (noise, 'explains more than'), (FINE, 'explains more than')):
        written(tmp_path, table(FINE, values), 'b.csv')
        with pytest.raises(InputError, match=expected):
            read_recording(tmp_path / 'a.csv', mapping)


# --- one mapping, many files --------------------------------------------------------------------
def test_values_by_command_line_and_from_the_header(tmp_path, capsys):
    head = '# zero_count=100\n# ratio: 4\nstart = 7000000000\n'
    path = written(tmp_path, table(T, K, U, head=head))
    mapping = text_mapping(skip=3)
    mapping['gear_ratio'] = {'from_header': 'ratio'}
    mapping['time']['start_stamp_ns'] = {'from_header': 'start'}
    mapping['signals'] = {'motor_position': {
        'column': 2, 'zero': {'from_header': 'zero_count', 'scale': -1.0}},
        'motor_effort': {'column': 3}}
    joints = imported(tmp_path, mapping, path, '--set', 'signals.motor_effort.sign=-1')
    assert joints.stamp_ns[0] == 7_000_000_000
    np.testing.assert_array_equal(joints.position[:, 0], (K + 100) / 4)
    np.testing.assert_array_equal(joints.effort[:, 0], -4.0 * U)
    with open_bag(tmp_path / 'bag') as reader:
        record = yaml.safe_load(reader.metadata['import']['mapping'])
    assert record['signals']['motor_effort']['sign'] == -1
    (tmp_path / 'bag').rename(tmp_path / 'other')
    mapping['gear_ratio']['from_header'] = 'i'
    assert "header: no 'i' (gear_ratio)" in refused(tmp_path, capsys, mapping, path)
    assert 'expected KEY=VALUE' in refused(tmp_path, capsys, mapping, path, '--set', 'sign')


# --- what makes no sense ------------------------------------------------------------------------
@pytest.mark.parametrize('time, unit, expected', [
    (K * 1.0, 's', '200 samples in 199 s, one per 1 s, expected one per 5e-06 to 0.1 s (time read '
     'in s: is time.unit right?)'),
    (T, 'us', 'one per 5e-09 s'), (K[:60] * 0.01, 's', '60 samples, expected at least 100'),
    (1.7e12 + K, 's', 'expected one > 0 and < 2^31 s')])
def test_stamps_in_a_wrong_unit_and_short_recordings(tmp_path, capsys, time, unit, expected):
    mapping = text_mapping({'column': 1, 'unit': unit})
    path = written(tmp_path, table([f'{t:.6f}' for t in time], Q, U))
    message = refused(tmp_path, capsys, mapping, path)
    assert str(path) in message and expected in message


def test_six_rows_of_a_foreign_shape_are_no_recording(tmp_path, capsys):
    scipy.io.savemat(tmp_path / 'm.mat', {'M': np.array([T, Q, U]), 't': T[:3]})
    mapping = {'format': 'mat', 'time': {'field': 't'},
               'signals': {'motor_position': {'field': 'M'}}}
    assert 'shape (3, 200), expected one number per sample, or the column of a matrix' in refused(
        tmp_path, capsys, mapping, tmp_path / 'm.mat')


def test_packaged_mappings_load():
    assert load_mapping('davinci_backend').references['signals.arm_effort.zero'] == (
        'torque0AverageTorque', -1.0)
