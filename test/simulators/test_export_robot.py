# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The verdict on a whole robot, written into its file: diagnosed with that, no gap remains."""
import json

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.simulators import robot_patch
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.robot_patch import closed_file


def simulated(folder, seed, kinds, renamed=()):
    """Write robot.xml and log.csv of a random robot with changes; {name in the file: new one}."""
    pytest.importorskip('mujoco')
    import random_robots
    case = random_robots.make(seed, False, kinds, 100)
    for name, new in dict(renamed).items():
        case.xml = case.xml.replace(f'"{name}"', f'"{new}"')
    log = random_robots.log(case, 1, 10.0)[0]
    (folder / 'robot.xml').write_text(case.xml.replace('<worldbody>', '<!-- ours --><worldbody>'))
    section = log.sections[0]
    header = ','.join(['t', *(f'q_{j}' for j in case.joints), *(f'tau_{j}' for j in case.joints)])
    np.savetxt(folder / 'log.csv', np.column_stack([section.t, section.position, section.input]),
               '%.9g', ',', header=header, comments='')


@pytest.mark.parametrize('seed, kinds', [
    (10, ['payload', 'motor_coulomb']), (12, ['base_tilt']),
    *(pytest.param(10, [kind], marks=pytest.mark.system)
      for kind in ('motor_inertia', 'motor_viscous'))])
def test_no_gap_remains_with_the_written_file(tmp_path, monkeypatch, seed, kinds):
    monkeypatch.chdir(tmp_path)
    simulated(tmp_path, seed, kinds)
    assert main(['diagnose', 'log.csv', '--model', 'robot.xml', '--out', 'gap']) == 1
    findings = json.loads((tmp_path / 'gap/verdict.json').read_text())['findings']
    assert sorted(f['effect'] for f in findings) == sorted(kinds)
    assert all(f['confirmed'] is True for f in findings)
    assert '<!-- ours -->' in (tmp_path / 'gap/robot.closed.xml').read_text()
    assert main(['diagnose', 'log.csv', '--model', 'gap/robot.closed.xml']) == 0


def test_a_veto_is_of_a_finding_and_not_of_its_name(tmp_path, monkeypatch):
    """The body of the load and the joint that rubs have one name; the load alone is vetoed."""
    monkeypatch.chdir(tmp_path)
    simulated(tmp_path, 10, ['payload', 'motor_coulomb'], {'link2': 'j1'})
    runs = iter((np.ones(3), np.array([9.0, 0.5, 1.0]), np.full(3, 0.5)))  # the last: as written
    monkeypatch.setattr(robot_patch, '_runs', lambda model, verdict, added: next(runs))
    assert main(['diagnose', 'log.csv', '--model', 'robot.xml', '--out', 'gap']) == 1
    data = json.loads((tmp_path / 'gap/verdict.json').read_text())
    assert {f['effect']: f['confirmed'] for f in data['findings']} == {
        'payload': False, 'motor_coulomb': True}
    assert data['rollouts'].keys() == {'window', 'joints', 'confirmed', 'vetoed', 'without'}
    assert data['rollouts']['vetoed'] == ['payload of j1']
    assert [gap['after'] for gap in data['rollouts']['joints'].values()] == [0.5, 0.5, 0.5]
    assert data['lacking'] == ['payload of j1: free runs are farther off with it than without']
    words = 'payload of j1: free runs in MuJoCo are farther off with it than without'
    assert words in data['warnings']
    before, after = (read_robot(tmp_path / name).chain
                     for name in ('robot.xml', 'gap/robot.closed.xml'))
    assert after.coulomb[1] != before.coulomb[1]
    np.testing.assert_allclose(after.theta, before.theta)


FINDING = {'effect': 'motor_coulomb', 'joint': 'joint1', 'link': None,
           'values': {'Cc_change': 1.0}, 'deviations': {'Cc_change': 0.1}}


def test_what_the_file_has_no_place_for_is_said_and_the_rest_is_written():
    file = read_robot(config_path('arm6.urdf'))
    joint, link = file.chain.joints[0], file.chain.links[0].name
    own = {**FINDING, 'joint': joint}
    gain = {'effect': 'servo_gain', 'values': {'kp_factor': 0.5}, 'deviations': {'kp_factor': 0.1}}
    text, unwritten = closed_file(file, [
        own, {**own, 'joint': 'nobody'}, {**own, 'effect': 'payload'},
        {**own, 'effect': 'plug_in'}, {**own, **gain},
        {**own, **gain, 'joint': None, 'link': link}], 'a test')
    assert '<dynamics' in text and len(unwritten) == 5
    assert any('a URDF has no actuators' in reason for reason in unwritten.values())
    assert "joint: 'nobody' is not in" in unwritten['motor_coulomb of nobody']
    assert 'servo_gain of ' + link in unwritten
    _, unwritten = closed_file(file, [{**own, 'values': {}}], 'a test')
    assert 'no Cc_change, expected it in the finding' in str(unwritten)
