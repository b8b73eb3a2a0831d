# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Foreign recordings become bags: values, units and signs; bad input gets one line and exit 2."""
import gzip
import hashlib
import json
import math
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import yaml

from gearbox_monitor import __version__
from gearbox_monitor.cli.main import main
from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.reading import open_recording, read_mapping, ReadOptions
from gearbox_monitor.recordings.si_signals import signals_of

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data'
TEXT = """\
% a comment in latin-1: \xb5
t;motor;arm;i;sensor
0,000;100;4096;65535;10

0,001;228;4064;2;11
% another comment
0,003;356;4032;3;12
"""
REST = ''.join(f'0,{k:03d};356;4032;3;12\n' for k in range(4, 101))
TEXT_MAP = {
    'time': {'column': 't'},
    'gear_ratio': 2.0,
    'signals': {
        'motor_position': {'column': 'motor', 'counts_per_rev': 256, 'zero': 'first'},
        'arm_position': {'column': 3, 'counts_per_rev': 8192, 'sign': -1, 'zero': 4096},
        'motor_effort': {'column': 'i', 'bits': 16, 'scale': 0.001, 'torque_constant': 0.5},
        'reference_torque': {'column': 'sensor', 'scale': 0.1, 'unit': 'counts'},
    },
}


def write(path, mapping, content):
    """Write `content` and its mapping; return the arguments of ``gearbox_monitor import``."""
    data = content.encode('latin-1') if isinstance(content, str) else content
    path.write_bytes(gzip.compress(data) if path.suffix == '.gz' else data)
    map_file = path.with_name('map.yaml')
    map_file.write_text(mapping if isinstance(mapping, str) else yaml.safe_dump(mapping))
    return ['import', str(path), '--map', str(map_file), str(path.with_name('bag'))]


def changed(mapping, **changes):
    """Return a copy of `mapping` with nested keys ``a__b=value`` changed; None removes."""
    result = json.loads(json.dumps(mapping))
    for names, value in changes.items():
        block, *rest = names.split('__')
        target = result
        for name in rest:
            target, block = target[block], name
        if value is None:
            del target[block]
        else:
            target[block] = value
    return result


def read(path, mapping):
    """Return the Signals of the file `path` by the mapping file `mapping`."""
    table, content, _ = read_mapping(Path(path), ReadOptions(str(mapping)))
    return signals_of(table, content)


def states(bag, reference=False):
    with open_bag(bag) as reader:
        joints = reader.joint_states('/joint_states', ['motor', 'arm'])
        if not reference:
            return joints
        return joints, reader.joint_states('/reference/transmission_state', ['transmission'])


@pytest.mark.parametrize('name', ['run.csv', 'run.csv.gz'])
def test_text_with_every_feature(tmp_path, capsys, name):
    arguments = write(tmp_path / name, TEXT_MAP, TEXT + REST)
    assert main(arguments) == 0
    assert '100 samples' in capsys.readouterr().out
    joints, reference = states(tmp_path / 'bag', reference=True)
    assert joints.stamp_ns.tolist() == [
        1_000_000_000 + k * 1_000_000 for k in (0, 1, *range(3, 101))]
    assert joints.log_ns.tolist() == joints.stamp_ns.tolist()
    turn = 2.0 * math.pi
    np.testing.assert_allclose(joints.position[:3, 0], [0.0, turn / 4, turn / 2], rtol=1e-14)
    np.testing.assert_allclose(joints.position[:3, 1], [0.0, turn / 256, turn / 128], rtol=1e-14)
    np.testing.assert_allclose(joints.effort[:3, 0], [-1e-3, 2e-3, 3e-3], rtol=1e-12)
    assert np.isnan(joints.effort[:, 1]).all() and np.isnan(joints.velocity).all()
    np.testing.assert_allclose(reference.effort[:3, 0], [1.0, 1.1, 1.2], rtol=1e-12)
    with open_bag(tmp_path / 'bag') as reader:
        assert set(reader.topics) == {'/joint_states', '/reference/transmission_state'}
        record = reader.metadata['import']
    assert record['source'] == name and record['gearbox_monitor_version'] == __version__
    assert record['source_sha256'] == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
    assert yaml.safe_load(record['mapping']) == TEXT_MAP


def test_missing_values_and_gaps_are_kept(tmp_path):
    mapping = {'kind': 'prismatic', 'time': {'rate': 100.0},
               'signals': {'motor_position': {'column': 1},
                           'motor_effort': {'column': 2}}}
    rows = '# x\n0.1 1\n nan   2\n0.3\t3\n' + '0.4 4\n' * 97
    assert main(write(tmp_path / 'a.txt', mapping, rows)) == 0
    joints = states(tmp_path / 'bag')
    assert joints.stamp_ns.tolist() == [1_000_000_000 + 10_000_000 * k for k in range(100)]
    np.testing.assert_array_equal(joints.position[:4, 0], [0.1, np.nan, 0.3, 0.4])
    assert np.isnan(joints.position[:, 1]).all()
    rows = TEXT + ''.join(f'0,{k:03d};1;;1;1\n' for k in (*range(4, 101), 190))
    recording = read(write(tmp_path / 'b.csv', TEXT_MAP, rows)[1], tmp_path / 'map.yaml')
    assert np.isnan(recording.values['arm_position']).tolist() == [False] * 3 + [True] * 98


def test_mat(tmp_path):
    t = np.arange(120) * 0.005
    scipy.io.savemat(tmp_path / 'm.mat', {
        't': t[:, None], 'run': {'q': np.column_stack([t, 2 * t])}, 'v': t[None, :] + 1})
    mapping = {'kind': 'prismatic', 'time': {'column': 't', 'scale': 2.0},
               'signals': {'motor_position': {'column': 'run.q 2'},
                           'motor_effort': {'column': 'v', 'torque_constant': 3.0}}}
    content = (tmp_path / 'm.mat').read_bytes()
    assert main(write(tmp_path / 'm.mat', mapping, content)) == 0
    joints = states(tmp_path / 'bag')
    assert joints.stamp_ns.tolist() == [1_000_000_000 + 10_000_000 * k for k in range(120)]
    np.testing.assert_array_equal(joints.position[:, 0], 2 * t)
    np.testing.assert_array_equal(joints.effort[:, 0], 3 * (t + 1))


def expect_json(tmp_path, shape):
    entries = [{'t': 1.0 + 0.01 * k, 'servo': {'q': 0.5 * k}, 'pwm': 65526 if k == 0 else 10}
               for k in range(100)]
    mapping = {'time': {'column': 't'},
               'signals': {'arm_position': {'column': 'servo.q'},
                           'motor_effort': {'column': 'pwm', 'bits': 16, 'scale': 0.1}}}
    text = json.dumps({'log': {'entries': entries}} if shape == 'wrapped' else entries)
    if shape == 'lines':
        text = '\n'.join(map(json.dumps, entries))
    assert main(write(tmp_path / 'j.json.gz', mapping, text)) == 0
    joints = states(tmp_path / 'bag')
    np.testing.assert_array_equal(joints.position[:, 1], 0.5 * np.arange(100))
    np.testing.assert_allclose(joints.effort[:2, 0], [-1.0, 1.0])


def test_json_entries(new_folder):
    for shape in ('wrapped', 'list', 'lines'):
        expect_json(new_folder(), shape)


def test_json_arrays(tmp_path):
    mapping = {'time': {'column': 't', 'unit': 'ms'}, 'signals': {'arm_position': {'column': 'q'}}}
    tree = {'t': list(range(100)), 'q': [1, None] + [2] * 98}
    assert main(write(tmp_path / 'j.json', mapping, json.dumps(tree))) == 0
    np.testing.assert_array_equal(states(tmp_path / 'bag').position[:3, 1], [1.0, np.nan, 2.0])


ONE_COLUMN = {'time': {'rate': 10}, 'signals': {'motor_position': {'column': 1}}}
OF_TREE = {'time': {'column': 't'}, 'signals': {'arm_position': {'column': 'q'}}}
BAD_DATA = {
    'no number': (TEXT_MAP, TEXT.replace('228', 'abc'),
                  "line 5, column motor: 'abc', expected a number"),
    'no number in time': (TEXT_MAP, TEXT.replace('0,001', 'x'),
                          "line 5, column t: 'x', expected a number"),
    'infinite': (TEXT_MAP, TEXT.replace(';11', ';1e999'), 'line 5, column sensor '
                 '(signals.reference_torque): inf, expected a finite number'),
    'no value of a drive': (TEXT_MAP, TEXT.replace(';11', ';1e308'), '1e+308, expected a finite'),
    'short row': (TEXT_MAP, TEXT.replace('228;4064;2;11', '228'),
                  'line 5: 2 columns, expected at least 5'),
    'too many bits': (TEXT_MAP, TEXT.replace('65535', '65536'),
                      'line 3, column i (signals.motor_effort): 65536, expected an integer from'),
    'header': (TEXT_MAP, TEXT.replace('motor', 'rotor'),
               "column 'motor' (signals.motor_position.column): missing, expected one of"),
    'empty': (ONE_COLUMN, '# nothing\n', 'no rows of data, expected a recording'),
    'one row': (ONE_COLUMN, '1\n', '1 columns of 1 numbers'),
    'no JSON': (OF_TREE, '{"e": [', 'expected JSON'),
    'no entries': (OF_TREE, '{"f": []}', '0 columns of 0 numbers, read as json'),
    'no column': (OF_TREE, json.dumps([{'t': k, 'p': k} for k in range(200)]),
                  "column 'q' (signals.arm_position.column): missing, expected one of t, p"),
    'no MATLAB file': (OF_TREE, 'MATLAB', 'expected a MATLAB file'),
    'cut gzip': (OF_TREE, gzip.compress(b'{"e": []}' * 9999)[:-12], 'end-of-stream'),
}


def refused(arguments, capsys):
    """Check exit code 2, one line and no bag; return the line."""
    assert main(arguments) == 2
    message = capsys.readouterr().err
    assert message.startswith('gearbox_monitor import: ') and message.endswith('\n')
    assert 'Traceback' not in message and message.count('\n') <= 2  # a line for each problem
    assert not Path(arguments[-1]).exists()
    return message


def expect_refusal(tmp_path, capsys, case):
    mapping, content, expected = BAD_DATA[case]
    if isinstance(content, str) and content.startswith('%'):
        content += REST
    arguments = write(tmp_path / 'data', mapping, content)
    message = refused(arguments, capsys)
    assert str(tmp_path / 'data') in message and expected in message


def test_bad_data(new_folder, capsys):
    for case in BAD_DATA:
        expect_refusal(new_folder(), capsys, case)


BAD_MAPS = {
    'unknown key': (changed(TEXT_MAP, colour=1), 'colour: unknown key, expected one of'),
    'unknown signal': (changed(TEXT_MAP, signals__torque={'column': 1}),
                       'signals.torque: unknown key, expected one of arm_effort'),
    'unknown signal key': (changed(TEXT_MAP, signals__motor_position__gain=1),
                           'signals.motor_position.gain: unknown key'),
    'old keys': (changed(TEXT_MAP, text={}, second_file={}),
                 'text: unknown key, gone since 0.3'),
    'scale': (changed(TEXT_MAP, signals__motor_effort__scale=0),
              'signals.motor_effort.scale: 0, expected a number > 0'),
    'sign': (changed(TEXT_MAP, signals__motor_effort__sign=2), 'sign: 2, expected 1 or -1'),
    'zero': (changed(TEXT_MAP, signals__motor_effort__zero='last'),
             "zero: 'last', expected a number or 'first'"),
    'bits': (changed(TEXT_MAP, signals__motor_effort__bits=1), 'bits: 1, expected an integer'),
    'column': (changed(TEXT_MAP, signals__arm_position__column=0),
               'signals.arm_position.column: 0, expected the name of a column or a number from 1'),
    'counts of a prismatic axis': (changed(TEXT_MAP, kind='prismatic'),
                                   'counts_per_rev: unknown key, '),
    'gear ratio': (changed(TEXT_MAP, gear_ratio=0), 'gear_ratio: 0, expected a number other than'),
    'rate and column': (changed(TEXT_MAP, time__rate=10), 'time.column: with time.rate, '),
    'no position': (changed(TEXT_MAP, signals={'motor_effort': {'column': 1}}),
                    'signals: no position, expected motor_position'),
    'no mapping': ('- a\n', "mapping: ['a'], expected keys and values"),
    'no YAML': ('a: [', 'expected YAML'),
}


def test_bad_mapping(tmp_path, capsys):
    for case in BAD_MAPS:
        mapping, expected = BAD_MAPS[case]
        message = refused(write(tmp_path / 'data', mapping, TEXT), capsys)
        assert 'map.yaml' in message and expected in message


UNUSED = [
    ('--use', 'arm=x'), ('--unit', 'arm=deg'), ('--torque-constant', '2'), ('--rate', '50'),
    ('--joint', 'a'), ('--topic', 'x')]


def test_options_that_a_mapping_does_not_use_are_refused(tmp_path, capsys):
    for option in UNUSED:
        arguments = write(tmp_path / 'r.csv', TEXT_MAP, TEXT + REST)
        assert main([*arguments, *option]) == 2
        assert f'{option[0]}: no effect with --map, expected --set' in capsys.readouterr().err
        assert not (tmp_path / 'bag').exists()


def test_bad_paths(tmp_path, capsys):
    arguments = write(tmp_path / 'data', TEXT_MAP, TEXT)
    (tmp_path / 'bag').mkdir()
    assert main(arguments) == 2
    assert 'expected the name of a new bag' in capsys.readouterr().err
    arguments[-1] = str(tmp_path / 'new')
    arguments[1] = str(tmp_path / 'none.csv')
    assert 'none.csv: no such file' in refused(arguments, capsys)
    arguments[1], arguments[3] = str(tmp_path / 'data'), 'da_vinci'
    message = refused(arguments, capsys)
    assert 'expected a mapping file or one of bam_servo_pendulum, davinci_backend, emps' in message


# ------------------------------------------------------------------------- recordings of others
def shared(name):
    path = DATA / name
    if not path.exists():
        pytest.skip(f'{path} is not here')
    return str(path)


def test_davinci_backend(tmp_path):
    bag = str(tmp_path / 'bag')
    assert main(['import', shared('davinci_backend/30.TXT.gz'), '--map', 'davinci_backend',
                 bag]) == 0
    joints, reference = states(bag, reference=True)
    assert len(joints.stamp_ns) == len(reference.stamp_ns) == 19995
    assert np.median(np.diff(joints.stamp_ns)) == 1_000_000
    # Lost motion: the twist with the motor moving forward less that with it moving back.
    late = slice(1000, None)
    motor = joints.position[late, 0]
    twist = np.rad2deg(motor - joints.position[late, 1])
    speed = np.convolve(np.gradient(motor, 1e-3), np.full(20, 0.05), 'same')
    lost = np.median(twist[speed > 0.1]) - np.median(twist[speed < -0.1])
    assert 1.71 < lost < 1.73
    # Current and sensor agree in sign and size (friction and offset are the rest).
    u, tau = joints.effort[late, 0], reference.effort[late, 0]
    assert np.corrcoef(u, tau)[0, 1] > 0.95
    assert 0.05 < np.std(tau) < 0.07


def test_emps(tmp_path, capsys):
    bag = str(tmp_path / 'bag')
    assert main(['import', shared('emps/DATA_EMPS.mat'), '--map', 'emps', bag, '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['samples'] == 24841
    joints = states(bag)
    assert len(joints.stamp_ns) == 24841 and np.isnan(joints.position[:, 1]).all()
    # The published rigid model: 95.1 kg x acceleration + friction, so tens of newtons.
    assert 0.2 < np.ptp(joints.position[:, 0]) < 0.3
    assert 20 < np.std(joints.effort[:, 0]) < 60


def test_bam_servo_pendulum(tmp_path):
    bag = str(tmp_path / 'bag')
    source = shared('bam_servo_pendulum/xl330/2026-01-15_10h28m42.json.gz')
    assert main(['import', source, '--map', 'bam_servo_pendulum', bag]) == 0
    joints = states(bag)
    assert len(joints.stamp_ns) == 1116 and np.isnan(joints.position[:, 0]).all()
    duty = joints.effort[:, 0]
    assert -0.9 < duty.min() < 0 < duty.max() < 0.9  # saturates at 885 per mille


def test_a_constant_rate_counts_on_over_blocks(tmp_path):
    q = np.sin(1e-3 * np.arange(300_000))  # 5 MB of text: two blocks
    (tmp_path / 'r.csv').write_text('\n'.join(map('{:.14f}'.format, q)) + '\n')
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump({**ONE_COLUMN, 'time': {'rate': 1000}}))
    with open_recording(tmp_path / 'r.csv', ReadOptions(str(tmp_path / 'map.yaml'))) as reader:
        states = reader.joint_states('/joint_states', ['motor'])
    np.testing.assert_array_equal(np.diff(states.stamp_ns), 1_000_000)
    np.testing.assert_allclose(states.position[:, 0], q, atol=1e-14)
