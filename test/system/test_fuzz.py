# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Damaged files: a fixed number of damages of every kind, and what fuzzing has found."""
from pathlib import Path
import re
import time

import fuzz
import fuzz_bombs
import fuzz_targets
import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.baselines import Damaged, load_baseline, load_state
from gearbox_monitor.files.user_files import load_model, load_parameters, load_yaml
from gearbox_monitor.parameters import ESTIMATOR

NUMBERS = {'drive.yaml': 10, 'estimator.yaml': 10, 'data.csv': 30, 'data.bin': 20,
           'joints.csv': 20,
           'baseline.yaml': 6, 'state.json': 50, 'snapshot': 30, 'map.yaml': 5,
           'rows.json': 5, 'bag, none': 10, 'bag, lz4': 10, 'bag, zstd': 10,
           'bag, metadata.yaml': 7, 'bag, recover': 10,
           'bag, SQLite': 10, 'recover, metadata.yaml': 10, 'data.csv.gz': 25, 'data.mat': 4}
# Mutated logs of every kind, 400 in all.
LOGS = {'data.csv': 70, 'data.csv.gz': 30, 'data.bin': 30, 'joints.csv': 70, 'long.csv': 50,
        'old.bag': 30, 'data.mat': 25, 'data.npz': 25, 'data.parquet': 25,
        'data.feather': 20, 'data.h5': 25}


@pytest.fixture(scope='module')
def targets(tmp_path_factory):
    return {t.name: t for t in fuzz_targets.targets(tmp_path_factory.mktemp('sound'))}


def test_damage_is_read_or_refused(targets):
    for name, number in NUMBERS.items():
        found = {}
        fuzz.run_cases(targets[name], 3, range(number), found.__setitem__)
        wrong = {k: what for k, what in found.items() if what not in (fuzz.READ, fuzz.REFUSED)}
        assert len(found) == number and not wrong, name


@pytest.mark.system
@pytest.mark.parametrize('name', LOGS)
def test_mutated_logs_are_read_or_refused(targets, name):
    found = {}
    fuzz.run_cases(targets[name], 11, range(LOGS[name]), found.__setitem__)
    assert sum(LOGS.values()) == 400
    assert not {k: what for k, what in found.items() if what not in (fuzz.READ, fuzz.REFUSED)}


FAILURES = [
    (lambda _: 1 // 0, 'ZeroDivisionError'),
    (lambda _: len(b'x' * (600 << 20)), 'MB of memory')]


def test_failures_are_seen():
    for failure, told in FAILURES:
        # in a child, whose peak of memory is no peak of earlier tests
        target = fuzz_targets.Target('', {'x': b'x'}, lambda data, _: data, failure)
        counts, _ = fuzz.fuzz(target, 0, 0, 1, time.monotonic() + 900.0)
        outcome, = counts
        assert told in outcome


@pytest.mark.system
@pytest.mark.parametrize('bomb', fuzz_bombs.BOMBS, ids=lambda bomb: bomb.name)
def test_a_bomb_ends_one_command_in_one_line(tmp_path, bomb):
    for command, _, end in fuzz_bombs.explode(bomb, tmp_path, 1):
        assert not end.wrong, f'{command}: {end}'


def write(path, text):
    path.write_text(text)
    return path


REFUSED = [
    ('a: &a [*a]\n', 'line 1: an alias that contains itself'),
    ('x: &x [1, 1]\n' + ''.join(f'{b}: &{b} [{", ".join([f"*{a}"] * 10)}]\n'
                                for a, b in zip('xabcdef', 'abcdefg')), 'aliases of aliases'),
    ('[' * 5000, 'nest'),  # PyYAML's own limit may be the first
    ('a0: &a0 {x: 1}\n' + ''.join(f'a{k}: &a{k} {{<<: [*a{k - 1}, *a{k - 1}]}}\n'
                                  for k in range(1, 50)), 'aliases of aliases'),
    ('a: &a {<<: *a}\n', 'contains itself'),
    *((f'a: !!{tag}', 'a tag that its value does not fit') for tag in (
        'int ""', 'float ""', 'bool x', 'timestamp "1"')),
    ('a: !!int ' + '1:' * 10 ** 6 + '1', 'line 1: '),
    ('a: !!float ' + '1:' * 10 ** 6 + '1', 'line 1: '),
    ('damping: 1\narm_inertia: 1\ndamping: 2\n', "line 3: key 'damping' stands in line 1, too"),
    ('a: !!python/object/apply:os.system [true]\n', 'line 1: could not determine a constructor'),
]


def test_yaml_that_is_refused(tmp_path):
    for text, told in REFUSED:
        with pytest.raises(InputError) as info:
            load_yaml(write(tmp_path / 'drive.yaml', text))
        assert told in str(info.value) and '\n' not in str(info.value)


NUMBERS_OF_ROS = [
    ('1e-3', 1e-3), ('-.5', -0.5), ('1_000', 1000), ('0x1F', 31), ('.inf', np.inf),
    ('12:30:00', '12:30:00'), ('1:30.5', '1:30.5'), ('9' * 100, '9' * 100), ('08', '08')]


def test_numbers_are_those_of_ros(tmp_path):
    for text, value in NUMBERS_OF_ROS:
        assert load_yaml(write(tmp_path / 'x.yaml', f'a: {text}')).content == {'a': value}


OTHER_NODES = [
    ('estimatr: {ros__parameters: {filter: ukf}}', 'sets nothing of node estimator'),
    ('/**: {ros__parameters: {use_sim_time: true}}', 'sets nothing of node estimator'),
    ('{}', 'blocks: none'),
    ('motor_inertia: 0.01\ndamping: 1.0', 'damping: a key of a model file'),
]


def test_a_parameter_file_for_another_node_is_an_error(tmp_path):
    for text, told in OTHER_NODES:
        path = write(tmp_path / 'p.yaml', text)
        with pytest.raises(InputError, match=told):
            load_parameters(path, 'estimator', ESTIMATOR)


def test_a_parameter_file_is_no_model_file(tmp_path):
    for text, told in (('estimator: {ros__parameters: {rate: 1.0}}', 'a block of a parameter'),
                       ('# nothing', 'empty')):
        with pytest.raises(InputError, match=told):
            load_model(write(tmp_path / 'drive.yaml', text))


def test_all_problems_of_a_model_file_at_once(tmp_path, capsys):
    path = write(tmp_path / 'drive.yaml', """\
motor_inertai: 1
damping: -1
transmission:
  kind: dead_zon
  half_gap: .nan
effects:
  - {id: stribeck, Cs: 0.1}
  - {id: wobble}
""")
    with pytest.raises(InputError) as info:
        load_model(path)
    lines = str(info.value).split('\n')
    assert [line.split(': ')[1:3] for line in lines if 'wobble' not in line] == [
        ['line 1', 'motor_inertai'], ['line 4', 'transmission.kind'], ['line 5', 'half_gap'],
        ['line 7', 'effects.stribeck.vs'], ['line 2', 'damping']]
    assert "did you mean 'motor_inertia'?" in lines[0] and any('wobble' in x for x in lines)
    assert main(['check', 'no-bag', '--model', str(path)]) == 2
    assert capsys.readouterr().out == ''


def test_all_problems_of_a_parameter_file_at_once(tmp_path):
    path = write(tmp_path / 'p.yaml', """\
/**: {ros__parameters: {max_gap: 100.0}}
estimator:
  ros__parameters:
    filter: efk
    q_std_tau_K: 1.0
recorder: {ros__parameters: {filter: 1}}
""")
    with pytest.raises(InputError) as info:
        load_parameters(path, 'estimator', ESTIMATOR)
    lines = str(info.value).split('\n')
    assert [line.split(': ')[1:3] for line in lines] == [
        ['line 1', 'max_gap'], ['line 4', 'filter'], ['line 5', 'q_std_tau_K']]
    assert "did you mean 'q_std_tau_k'?" in lines[2]


def test_a_bag_names_no_file_outside_of_it(targets, tmp_path):
    secret = write(tmp_path / 'secret.mcap', 'not for the bag')
    for name in (str(secret), '../secret.mcap', '../bag/../secret.mcap'):
        for file, data in targets['bag, metadata.yaml'].files.items():
            path = tmp_path / file
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data.replace(b'bag_zstd_0.mcap', name.encode()))
        with pytest.raises(InputError, match='secret.mcap: missing') as info:
            fuzz_targets.open_bag(tmp_path / 'bag')
        assert str(tmp_path / 'bag' / 'secret.mcap') in str(info.value)


def test_damaged_files_of_drift(targets, tmp_path):
    good = targets['baseline.yaml'].files['baseline.yaml'].decode()
    path = write(tmp_path / 'baseline.yaml', good)
    assert load_baseline(path, 'joint3')
    cut = good[:good.index('parameters') - 40]
    for text in (cut, re.sub(r'"format": \d+', '"format": 1', good), '\0', ''):
        with pytest.raises(Damaged):
            load_baseline(write(path, text), 'joint3')
    state = write(tmp_path / 'state.json', '[' * 100000)
    assert load_state(state, 'joint3')[0] is None and not state.exists()
    assert len(list(Path(tmp_path).glob('state.json.corrupt-*'))) == 1
