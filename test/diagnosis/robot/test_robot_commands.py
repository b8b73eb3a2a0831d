# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Commands on whole robots: the simulated pair, learn, the file of knowledge, the page."""
from dataclasses import replace
import json
from pathlib import Path
import re

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.hypothesis import Remainder
from gearbox_monitor.errors import InputError
from gearbox_monitor.files import knowledge_file
from gearbox_monitor.files.knowledge_file import load_knowledge, save_knowledge
from gearbox_monitor.library.robot import check_robot, load_robot
from gearbox_monitor.simulators.robot_model import read_robot


@pytest.fixture(scope='module')
def arm(tmp_path_factory):
    """Return a folder with a simulated pair and what was learnt of the healthy arm."""
    folder = tmp_path_factory.mktemp('robot') / 'arm'
    assert main(['example', str(folder), '--robot', '--seconds', '15']) == 0
    assert main(['learn', str(folder / 'healthy.csv'), '--model', str(folder / 'robot.urdf'),
                 '--out', str(folder / 'arm.knowledge')]) == 0
    return folder


def diagnose(arm, *options, log='today.csv'):
    """Return the exit code of diagnose on a log of the arm."""
    return main(['diagnose', str(arm / log), '--model', str(arm / 'robot.urdf'), *options])


@pytest.fixture(scope='module')
def out(arm):
    """Return the folder that diagnose wrote of the pair."""
    folder = arm.parent / 'out'
    assert diagnose(arm, '--reference', str(arm / 'arm.knowledge'), '--out', str(folder)) == 1
    return folder


def test_pair_names_the_load_and_the_rubbing_joint(arm, out):
    data = json.loads((out / 'verdict.json').read_text())
    for key in ('verdict', 'findings', 'remainders', 'gaps', 'visible', 'not_tried', 'cpu_s'):
        assert key in data
    payload = next(f for f in data['findings'] if f['effect'] == 'payload')
    assert payload['link'] == 'flange'
    assert abs(payload['values']['m'] - 2.0) < 0.05 and abs(payload['values']['cz'] - 0.08) < 0.02
    rubbing = next(f for f in data['findings'] if f['effect'] == 'motor_coulomb')
    # The load takes most of the misfit; the shares of two effects of little overlap add up to it.
    assert payload['share'] > 0.9 and 0.001 < rubbing['share'] < 0.1
    assert abs(payload['share'] + rubbing['share'] - 1.0) < 0.05
    assert rubbing['joint'] == 'joint2' and 10.0 < rubbing['values']['Cc_change'] < 15.0
    # The patched file has the load, and nothing else moved.
    before, after = read_robot(arm / 'robot.urdf').chain, read_robot(
        out / 'robot.closed.urdf').chain
    added = after.theta - before.theta
    assert added[-1, 0] == pytest.approx(payload['values']['m'], rel=1e-4)
    np.testing.assert_allclose(added[:-1], 0.0, atol=1e-9)
    assert after.coulomb[1] - before.coulomb[1] == pytest.approx(
        rubbing['values']['Cc_change'], rel=1e-4)
    page = (out / 'report.html').read_text()
    assert 'kg more at flange' in page
    assert re.findall(r'>(joint.)</text>\n<text class="hit"[^>]*>([^<]+)<', page) == [
        ('joint2', '+13 N m'), ('joint6', '+2.0 kg')]
    assert re.search(r'class="added">\+ .*mass', page) and 'joint3, before and after' in page


def test_a_joint_beyond_its_range_is_named_with_what_to_check(arm):
    robot = load_robot(arm / 'robot.urdf')
    narrow = replace(robot, file=replace(robot.file, low=np.full(6, -0.1), high=np.full(6, 0.1)))
    notes = [f for f in check_robot(arm / 'healthy.csv', narrow) if f.name == 'note']
    assert {'joint1', 'joint2', 'joint3'} <= {f.group for f in notes}
    for note in notes:
        assert note.figure.startswith('from ') and 'beyond the range of the model' in note.figure
        assert f'--convention {note.group}=zero:RAD' in note.advice
        assert f'as of degrees: --convention {note.group}=deg' in note.figure


def test_all_keys_of_a_verdict_are_documented(out):
    page = (Path(__file__).parents[3] / 'docs/robot_gap.md').read_text()
    words = set(re.findall(r'`(\w+)`', page.split('## What it says')[1].split('\n## ')[0]))
    data = json.loads((out / 'verdict.json').read_text())
    remainder = Remainder('arm_side', joint='a', times=((0.0, 1.0),), recordings=('b',))
    for table in (data, *data['findings'], *data['gaps'], remainder.to_dict()):
        assert table.keys() <= words, table.keys() - words
    assert {'confirmed', 'vetoed', 'without', 'window', 'joints', 'burstiness'} <= words


def test_reference_itself_is_none(arm, capsys):
    """Also as logs, to be learnt now."""
    assert diagnose(arm, '--reference', str(arm / 'arm.knowledge'), '--json', '-',
                    log='healthy.csv') == 0
    data = json.loads(capsys.readouterr().out)
    assert data['verdict'] == 'none' and data['findings'] == []
    assert data['visible']['payload']


def test_knowledge_survives_its_file_and_is_refused_for_another_model(arm, tmp_path, capsys):
    digest = read_robot(arm / 'robot.urdf').digest
    knowledge = load_knowledge(arm / 'arm.knowledge', digest)
    save_knowledge(tmp_path / 'copy.knowledge', knowledge)
    copy = load_knowledge(tmp_path / 'copy.knowledge', digest)
    np.testing.assert_array_equal(copy.prior.covariance, knowledge.prior.covariance)
    assert copy.visits == knowledge.visits and copy.shapes == knowledge.shapes
    text = (arm / 'robot.urdf').read_text()
    (tmp_path / 'robot.urdf').write_text(text + '<!-- moved -->')
    assert main(['diagnose', str(arm / 'today.csv'), '--model', str(tmp_path / 'robot.urdf'),
                 '--reference', str(arm / 'arm.knowledge')]) == 2
    assert 'learnt with another file' in capsys.readouterr().err
    (tmp_path / 'bad.knowledge').write_bytes(b'PK\x03\x04 nothing')
    assert diagnose(arm, '--reference', str(tmp_path / 'bad.knowledge')) == 2
    assert 'expected a file that learn wrote' in capsys.readouterr().err


def test_knowledge_of_an_older_version_is_refused_with_what_to_do(
        arm, tmp_path, capsys, monkeypatch):
    knowledge = load_knowledge(arm / 'arm.knowledge', read_robot(arm / 'robot.urdf').digest)
    with monkeypatch.context() as patch:
        patch.setattr(knowledge_file, 'VERSION', 2)
        save_knowledge(tmp_path / 'old.knowledge', knowledge)
    assert diagnose(arm, '--reference', str(tmp_path / 'old.knowledge')) == 2
    error = capsys.readouterr().err
    assert error.endswith('old.knowledge: version: 2, expected 9: learn it again\n')


def test_a_damaged_file_of_knowledge_is_refused_in_one_line(arm, tmp_path):
    digest = read_robot(arm / 'robot.urdf').digest
    whole = (arm / 'arm.knowledge').read_bytes()
    rng, path, refused = np.random.default_rng(1), tmp_path / 'damaged.knowledge', 0
    for k in range(150):
        damaged = bytearray(whole[:len(whole) - int(k % 3 == 0) * int(rng.integers(len(whole)))])
        for place in rng.integers(0, len(damaged), 3) if len(damaged) else ():
            damaged[place] ^= int(rng.integers(1, 256))
        path.write_bytes(damaged)
        try:
            load_knowledge(path, digest)
        except InputError as error:
            refused += len(error.args) == 1
    assert refused > 140


BAD_OPTIONS = [
    (['--recorded', 'jint1=a'], 'did you mean'), (['--recorded', 'joint1'], 'NAME=LOGNAME'),
    (['--only', 'payloud'], "did you mean 'payload'"), (['--validate', 'x'], 'of one joint'),
    (['--reference', 'a.knowledge', 'b.csv'], 'one file of learn'),
    (['--root', '.'], '--root: .: of a URDF no other file is read'),
    (['--jobs', '0'], '--jobs: 0'),
    *((['--' + option, 'sum'], f'--{option}: of one joint, expected --joint')
      for option in ('model-arm-joint', 'keyframe', 'actuator', 'recorded-motor',
                     'recorded-arm', 'recorded-setpoint', 'validate', 'simulator'))]


def test_bad_options_are_one_line(arm, capsys):
    for options, words in BAD_OPTIONS:
        assert diagnose(arm, *options) == 2
        error = capsys.readouterr().err
        assert words in error and error.count('\n') == 1


def test_values_are_checked(arm, tmp_path, capsys):
    values = tmp_path / 'values.yaml'
    values.write_text('link_tolerance: {flangee: 0.2}\n')
    assert diagnose(arm, '--values', str(values)) == 2
    assert "did you mean 'flange'" in capsys.readouterr().err


SERVO = """<mujoco><option timestep="0.001" integrator="implicitfast"/>
<default><joint axis="0 1 0" damping=".3" frictionloss=".3" armature=".03"
  solreffriction="0.002 1"/></default>
<worldbody><body pos="0 0 .3"><joint name="j1"/><inertial pos="0 0 .2" mass="3"
  diaginertia=".05 .05 .01"/><body name="fore" pos="0 0 .4"><joint name="j2"/><inertial
  pos="0 0 .15" mass="{mass}" diaginertia=".02 .02 .005"/></body></body></worldbody>
<actuator><position joint="j1" kp="{kp}" kv="12"/><position joint="j2" kp="80" kv="3"/></actuator>
</mujoco>"""


@pytest.mark.parametrize('mass, kp, found', [(1.5, 330, []), (2.5, 300, ['payload'])])
def test_setpoints_of_position_actuators_in_the_file(tmp_path, capsys, mass, kp, found):
    mujoco = pytest.importorskip('mujoco')
    (tmp_path / 'robot.xml').write_text(SERVO.format(mass=1.5, kp=300))
    (tmp_path / 'values.yaml').write_text('gain_tolerance: 0.05\n')
    m = mujoco.MjModel.from_xml_string(SERVO.format(mass=mass, kp=kp))
    d, rng, rows = mujoco.MjData(m), np.random.default_rng(1), []
    t = np.arange(0.0, 18.0, 1e-3)[:, None]
    goal = np.stack([0.5 + np.sum(rng.uniform(0.1, 0.35, 5) * np.sin(
        2.0 * np.pi * rng.uniform(0.05, 0.6, 5) * t + rng.uniform(0.0, 6.28, 5)), axis=1)
        for _ in range(2)], axis=1)
    d.qpos[:] = goal[0]
    for k, r in enumerate(goal):
        if k % 5 == 0:
            d.ctrl[:] = r
        if k % 10 == 0:
            rows.append([k * 1e-3, *(d.qpos + rng.normal(0.0, 1e-4, 2)), *d.ctrl,
                         *d.actuator_force])
        mujoco.mj_step(m, d)
    header = 't,q_j1,q_j2,setpoint_j1,setpoint_j2'
    np.savetxt(tmp_path / 'log.csv', np.array(rows)[:, :5], '%.9g', ',', comments='',
               header=header)
    np.savetxt(tmp_path / 'both.csv', rows, '%.9g', ',', comments='',
               header=f'{header},tau_j1,tau_j2')
    options = ['--model', str(tmp_path / 'robot.xml'), '--values', str(tmp_path / 'values.yaml')]
    main(['check', str(tmp_path / 'both.csv'), *options])
    assert ' used ' in capsys.readouterr().out
    main(['diagnose', str(tmp_path / 'log.csv'), *options, '--json', '-'])
    findings = json.loads(capsys.readouterr().out)['findings']
    assert [f['effect'] for f in findings] == found
    assert all(f['link'] == 'fore' and 0.5 < f['values']['m'] < 1.3 for f in findings)


@pytest.mark.parametrize('command', ['diagnose', 'learn'])
def test_root_is_where_the_parts_of_a_file_lie(tmp_path, capsys, command):
    pytest.importorskip('mujoco')
    (tmp_path / 'robots').mkdir()
    (tmp_path / 'parts.xml').write_text(
        '<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody></mujoco>')
    model = tmp_path / 'robots' / 'robot.xml'
    model.write_text('<mujoco><include file="../parts.xml"/></mujoco>')
    arguments = [command, str(tmp_path / 'no.csv'), '--model', str(model)]
    if command == 'learn':
        arguments += ['--out', str(tmp_path / 'a.knowledge')]
    assert main(arguments) == 2 and 'parts.xml' in capsys.readouterr().err
    assert main([*arguments, '--root', str(tmp_path)]) == 2
    assert 'no.csv: no such file' in capsys.readouterr().err


@pytest.mark.system
def test_replay_weighs_the_load_as_the_page_says(arm, capsys):
    assert main(['replay', str(arm / 'today.csv'), '--model', str(arm / 'robot.urdf'),
                 '--reference', str(arm / 'arm.knowledge')]) == 0
    headline = capsys.readouterr().out.splitlines()[0]
    assert headline in (Path(__file__).parents[3] / 'docs/watch.md').read_text()
    assert abs(float(headline.split()[0]) - 2.0) < 0.2
