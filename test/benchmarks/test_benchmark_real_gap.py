# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""Pairs of real logs: manifests, a truth that stays sealed, scores, and two simulated pairs."""
import json
import os
import subprocess

import numpy as np
import pytest

from benchmarks import real_gap
from benchmarks.__main__ import main
from benchmarks.least_squares import ranked_of_robot
from benchmarks.real_gap import Answer, answer_of, load_pairs, Runner, scores, Truth
from gearbox_monitor.cli.main import main as run_command
from gearbox_monitor.files.user_files import save_model
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.examples import ExampleMotion, write_robot_pair
from gearbox_monitor.recordings.read import open_bag

MODEL = DriveModel()


@pytest.fixture
def in_process(monkeypatch):
    """Run the commands of the benchmark in this process, which is warm."""
    def _run(line, cwd, **_):
        here = os.getcwd()
        os.chdir(cwd)
        try:
            return subprocess.CompletedProcess(line, run_command(line[3:]), '', 'refused')
        finally:
            os.chdir(here)
    monkeypatch.setattr(real_gap.subprocess, 'run', _run)


def manifests_in(folder):
    """Write the manifests of a changed and an unchanged pair beside each other."""
    (folder / 'joint').mkdir()
    for name in ('oiled', 'same'):
        (folder / 'joint' / f'{name}.csv').touch()
        (folder / 'joint' / f'{name}.pair.yaml').write_text(
            f'log: {name}.csv\nmodel: drive.yaml\n'
            'diagnose: --only motor_viscous\n')
    save_model(folder / 'joint' / 'drive.yaml', MODEL, [])
    (folder / 'truth.yaml').write_text('joint/oiled: motor_viscous\njoint/same: none\n')


@pytest.mark.system
def test_two_simulated_pairs(tmp_path, monkeypatch, in_process):
    manifests_in(tmp_path)
    for name, viscous in (('oiled', 0.25), ('same', 0.1)):
        t = np.arange(1000) / 250.0
        command = ExampleMotion(4.0, kind='varied').command(t, MODEL)
        run = Plant(MODEL.with_(viscous_friction=viscous), Noise(measurement=(1e-3, 1e-3)),
                    1).run(command, 0.004)
        np.savetxt(tmp_path / 'joint' / f'{name}.csv', np.column_stack([run.t, run.u, run.y]),
                   delimiter=',', header='t,u,motor,arm', comments='')
    out, opened = tmp_path / 'out', []
    of_file = real_gap.load_truth

    def _opened(path):
        opened.append(json.loads((out / 'answers.json').read_text()))
        return of_file(path)
    monkeypatch.setattr(real_gap, 'load_truth', _opened)
    assert main(['real_gap', str(tmp_path), '--out', str(out),
                 '--json', str(tmp_path / 'scores.json')]) == 0
    assert [set(answers['diagnose']) for answers in opened] == [{'joint/oiled', 'joint/same'}]
    data = json.loads((tmp_path / 'scores.json').read_text())
    values = {row['bar']: row['value'] for row in data['bars']}
    assert {name: values[f'diagnose: {name}'] for name in (
        'detection', 'false alarm', 'isolation', 'rank')} == {
        'detection': 1.0, 'false alarm': 0.0, 'isolation': 1.0, 'rank': 1.0}
    assert values['least squares: detection'] == 1.0
    assert [line.split()[1] for line in data['commands']['joint/same']] == ['diagnose']


def test_files_in_options_lie_beside_the_manifest_and_are_read_once(tmp_path, in_process):
    manifests_in(tmp_path)
    joint, t = tmp_path / 'joint', np.arange(400) / 200.0
    np.savetxt(joint / 'same.csv', np.column_stack([t, np.sin(t), np.cos(t)]), delimiter=',')
    (joint / 'bench.yaml').write_text(
        'format: text\ntime: {column: 1}\n'
        'signals: {motor_position: {column: 2}, motor_effort: {column: 3}}\n')
    (joint / 'same.pair.yaml').write_text('log: same.csv\nreference: same.csv\nfree: m1\n'
                                          'model: drive.yaml\nimport: --map bench.yaml\n')
    pair = load_pairs(tmp_path, None)[1]
    (tmp_path / 'out').mkdir()
    runner = Runner(tmp_path / 'out')
    logs = runner.logs(pair, pair.log)
    assert logs == runner.logs(pair, pair.reference) and len(runner.commands) == 1
    with open_bag(logs[0]) as bag:
        assert '/joint_states' in bag.topics


def test_the_baseline_takes_the_values_that_diagnose_takes(tmp_path):
    """A current with its constants is a torque; what is measured saturates and delays nothing."""
    write_robot_pair(tmp_path / 'arm', 20.0, 1)
    table = np.loadtxt(tmp_path / 'arm' / 'today.csv', delimiter=',', skiprows=1)
    joints = [f'joint{k}' for k in range(1, 7)]
    table[:, 7:] /= 4.0
    np.savetxt(tmp_path / 'i.csv', table, delimiter=',', comments='', header=','.join(
        ['t', *(f'{what}_{joint}' for what in 'qi' for joint in joints)]))
    values = tmp_path / 'values.yaml'

    def _ranked(log, text):
        values.write_text(text)
        return ranked_of_robot([str(log)], tmp_path / 'arm' / 'robot.urdf', str(values), None, {})
    torque = dict(_ranked(tmp_path / 'arm' / 'today.csv', 'effort: measured'))
    current = dict(_ranked(tmp_path / 'i.csv', f'torque_constants: {dict.fromkeys(joints, 4.0)}'))
    assert torque and current == pytest.approx(torque, rel=1e-3, abs=0.1)
    commanded = _ranked(tmp_path / 'arm' / 'today.csv', 'effort: commanded')
    assert {effect for (effect, _), _ in commanded} - {effect for effect, _ in torque} == {
        'saturation', 'actuator_delay'}


def test_probability_is_divided_among_findings_and_what_remains():
    finding = {'effect': 'payload', 'joint': None, 'link': 'tool',
               'confusable': ['gravity@elbow', 'end_spring (lower end)']}
    answer = answer_of({'verdict': 'incomplete', 'findings': [finding], 'ranked': []}, 1.0)
    assert answer.probabilities == pytest.approx({
        ('payload', 'tool'): 1 / 6, ('gravity', 'elbow'): 1 / 6, ('end_spring', 'tool'): 1 / 6,
        ('unknown', ''): 1 / 2})


def test_scores_of_the_competition():
    payload, friction = ('payload', 'tool'), ('motor_coulomb', 'elbow')
    answers = {
        'right': Answer({payload: 1.0}, (payload,), 2.0),
        'second': Answer({friction: 0.5, payload: 0.5}, (friction, payload), 2.0),
        'missed': Answer({}, (friction, ('stribeck', ''), payload), 2.0),
        'elsewhere': Answer({('payload', 'base'): 1.0}, (('payload', 'base'),), 2.0),
        'same': Answer({}, (), 2.0), 'alarm': Answer({friction: 1.0}, (friction,), 2.0),
        'refused': Answer({}, (), 0.0, 'too short'), 'not stated': Answer({payload: 1.0}, (), 1.0)}
    truths = {name: Truth(('payload',), 'tool') for name in (
        'right', 'second', 'missed', 'elsewhere', 'refused')} | {
        'same': Truth(()), 'alarm': Truth(())}
    assert scores(answers, truths) == {
        'detection': [1.0, 1.0, 0.0, 1.0], 'false alarm': [0.0, 1.0],
        'isolation': [1.0, 0.5, 0.0], 'rank': [1.0, 0.5, 1 / 3, 0.0], 'cpu': [2.0] * 6}


@pytest.mark.parametrize('text, says', [
    ('log: [1]\nmodel: drive.yaml', "log: '[1]', expected a name or a list"),
    ('log: same.csv', 'model: missing, expected a file'),
    ('log: gone.csv\nmodel: drive.yaml', 'log: gone.csv: no such file in'),
    ('log: same.csv\nmodel: drive.yaml\nefort: x', 'efort: expected one of'),
    ('log: same.csv\nmodel: drive.yaml\nfree: m1', "free: ['m1'], expected values"),
    ("log: same.csv\nmodel: drive.yaml\nimport: --columns 't", 'import: No closing quotation')])
def test_bad_manifests_are_one_line(tmp_path, capsys, text, says):
    manifests_in(tmp_path)
    (tmp_path / 'joint' / 'bad.pair.yaml').write_text(text)
    assert main(['real_gap', str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert says in error and 'bad.pair.yaml' in error and error.count('\n') == 1


@pytest.mark.parametrize('text', (
    'joint/same: 3', 'joint/same: {place: tool}', '- none', 'joint/same: paylod',
    'joint/same: {effect: [payload, none]}'))
def test_a_truth_that_says_nothing_is_refused(tmp_path, text):
    (tmp_path / 'truth.yaml').write_text(text)
    with pytest.raises(real_gap.InputError, match='truth.yaml'):
        real_gap.load_truth(tmp_path / 'truth.yaml')
