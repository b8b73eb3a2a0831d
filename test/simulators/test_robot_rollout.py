# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Free runs in MuJoCo: nearer with what is right, and a veto for what is wrong."""
from dataclasses import replace
import re

import numpy as np
import pytest

from gearbox_monitor.diagnosis.robot.robot_log import (
    LogSection, RobotLog, SETPOINT, TORQUE)
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.verdict import diagnose
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.robot_patch import closed_file, rollouts

pytest.importorskip('mujoco')


@pytest.mark.parametrize('kind, effect, wrong', [
    ('payload', 'payload', 4.0), ('end_spring', 'end_spring', -1.0),
    pytest.param('motor_coulomb', 'motor_coulomb', -1.0, marks=pytest.mark.system),
    pytest.param('motor_inertia', 'motor_inertia', 4.0, marks=pytest.mark.system)])
def test_right_findings_are_nearer_and_wrong_ones_vetoed(tmp_path, kind, effect, wrong):
    import random_robots
    case = random_robots.make(10, False, [kind], 100)
    (tmp_path / 'robot.xml').write_text(case.xml)
    file = read_robot(tmp_path / 'robot.xml')
    log, count = random_robots.log(case, 1, 10.0)[0], len(case.joints)
    verdict = diagnose(RobotModel(file.chain, np.full(count, 0.05), 0.05), [log])
    finding, = verdict.findings
    assert finding.effect == effect
    runs = rollouts(file, verdict)
    own = [finding.joint] if finding.joint else list(file.chain.joints)
    gap = {key: np.hypot.reduce([runs['joints'][j][key] for j in own])
           for key in ('before', 'after')}
    assert runs['confirmed'] and not runs['without']
    # What has no place in the file confirms itself as a torque; the file as written lacks it.
    assert (gap['after'] < 0.5 * gap['before']) == (effect != 'end_spring')
    fit = replace(verdict.fit, values=wrong * verdict.fit.values)
    values = {k: v if k in ('cx', 'cy', 'cz') else wrong * v for k, v in finding.values.items()}
    deviations = dict.fromkeys(values, 1e3)
    worse = replace(finding, values=values, deviations=deviations)
    runs = rollouts(file, replace(verdict, fit=fit, findings=(worse,)))
    assert runs['vetoed'] == [f'{effect} of {finding.joint or finding.link}']
    assert not runs['confirmed']
    assert all(gap['after'] == gap['before'] for gap in runs['joints'].values())  # nothing written


def test_a_vetoed_finding_is_not_written(tmp_path):
    (tmp_path / 'robot.xml').write_text(
        '<mujoco><worldbody><body name="a"><joint name="j"/><geom size=".1"/></body></worldbody>'
        '</mujoco>')
    finding = {'effect': 'motor_inertia', 'joint': 'j', 'values': {'m1_change': 0.1},
               'deviations': {'m1_change': 0.01}}
    file = read_robot(tmp_path / 'robot.xml')
    assert 'armature="0.1"' in closed_file(file, [{**finding, 'confirmed': True}], 'test')[0]
    text, left = closed_file(file, [{**finding, 'confirmed': False}], 'test')
    assert text is None and 'farther off' in left['motor_inertia of j']


def test_mujoco_writes_no_log_into_the_folder_of_the_user(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mujoco = mujoco_module()
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint axis="0 1 0"/><geom size=".1"/></body></worldbody>'
        '</mujoco>')
    data = mujoco.MjData(model)
    data.qvel[0] = 1e200
    mujoco.mj_step(model, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQVEL].number == 1
    assert not list(tmp_path.iterdir())


SERVOS = """<mujoco><option timestep=".002"/><worldbody><body pos="0 0 .3">
  <joint name="turn" axis="0 0 1" armature=".05" damping="1"/>
  <inertial pos=".02 0 .05" mass="2" diaginertia=".01 .01 .006"/>
  <body pos="0 0 .1"><joint name="lift" axis="0 1 0" armature=".05" damping="1"/>
    <inertial pos=".15 .005 0" mass="1.5" diaginertia=".003 .015 .015"/>
    <body name="tip" pos=".3 0 0"><joint name="nod" axis="0 1 0" armature=".03" damping=".5"/>
      <inertial pos=".12 0 .01" mass=".8" diaginertia=".001 .006 .006"/></body></body>
</body></worldbody><actuator>
  <position joint="turn" kp="200" kv="10"/><position joint="lift" kp="200" kv="10"/>
  <position joint="nod" kp="100" kv="4"/></actuator></mujoco>"""
LOAD = '<body pos=".25 0 0"><inertial pos="0 0 0" mass=".5" diaginertia="1e-4 1e-4 1e-4"/></body>'


def sampled(xml, joints, sample, setpoints=False):
    """Return a log of position servos: setpoints held for 10 ms, the `sample` of five steps."""
    mujoco = mujoco_module()
    m = mujoco.MjModel.from_xml_string(xml)
    data, rng = mujoco.MjData(m), np.random.default_rng(1)
    frequency, phase, size = (rng.uniform(low, high, (3, 5)) for low, high in (
        (0.1, 0.7), (0.0, 6.28), (0.1, 0.3)))
    q, effort = [], []
    for k in range(800):
        data.ctrl[:] = (size * np.sin(2.0 * np.pi * frequency * 0.01 * k + phase)).sum(axis=1)
        steps = []
        for _ in range(5):
            position = data.qpos.copy()
            mujoco.mj_step(m, data)
            steps.append((position, data.actuator_force.copy()))
        q.append(steps[sample][0])
        effort.append(data.ctrl.copy() if setpoints else steps[sample][1])
    section = LogSection(0.01 * np.arange(800), np.array(q) + rng.normal(0.0, 2e-5, (800, 3)),
                         np.array(effort))
    return RobotLog('log', joints, SETPOINT if setpoints else TORQUE, (section,), 100.0)


@pytest.mark.parametrize('sample, end', [
    (-1, 'end'), pytest.param(0, 'start', marks=pytest.mark.system)])
def test_torque_sampled_at_an_end_of_a_held_setpoint_is_no_friction(tmp_path, sample, end):
    """Position servos at 100 Hz gave false viscous findings of kp T / 2 at all joints."""
    (tmp_path / 'robot.xml').write_text(SERVOS)
    file = read_robot(tmp_path / 'robot.xml')
    joints, tolerance = file.chain.joints, np.full(3, 0.05)
    robot = RobotModel(file.chain, tolerance, 0.05, kp=file.kp, kd=file.kd)
    log = sampled(SERVOS, joints, sample)
    verdict = diagnose(robot, [log])
    assert verdict.kind == 'none', verdict.findings
    assert any(f'sampled at the {end} of a held setpoint' in str(c) for c in verdict.cautions)
    wrong = diagnose(RobotModel(file.chain, tolerance, 0.05), [log])
    assert len(wrong.findings) >= 3 and not any('held' in str(c) for c in wrong.cautions)
    load, = diagnose(robot, [sampled(SERVOS.replace('</body></body>', f'{LOAD}</body></body>'),
                                     joints, sample)]).findings
    assert load.effect == 'payload'
    assert load.values['m'] == pytest.approx(0.5, abs=2.0 * load.deviations['m'])


def rubbing(lift=0.3):
    """Return SERVOS with Coulomb friction (N m) of the joint lift, and of turn."""
    return SERVOS.replace('name="turn"', 'name="turn" frictionloss=".3"').replace(
        'name="lift"', f'name="lift" frictionloss="{lift:g}"')


def rubbing_robot(folder):
    """Return file and model of the robot with friction."""
    (folder / 'robot.xml').write_text(rubbing())
    file = read_robot(folder / 'robot.xml')
    return file, RobotModel(file.chain, np.full(3, 0.05), 0.05, kp=file.kp, kd=file.kd)


def test_an_unchanged_arm_with_friction_has_no_findings(tmp_path):
    """It reverses between two samples, and its servos are computed in five steps a period."""
    file, robot = rubbing_robot(tmp_path)
    for setpoints in (False, True):
        verdict = diagnose(robot, [sampled(rubbing(), file.chain.joints, 0, setpoints)])
        assert verdict.kind == 'none', (setpoints, verdict.findings, verdict.remainders)


@pytest.mark.parametrize('sample, mass', [
    (0, 0.5), pytest.param(-1, 1.5, marks=pytest.mark.system)])
def test_setpoints_weigh_a_load_and_its_file_runs(tmp_path, sample, mass):
    """Gains made up for the load: 0.5 kg were 0.35, 1.5 kg 1.27 with a false friction of turn."""
    file, robot = rubbing_robot(tmp_path)
    load = LOAD.replace('mass=".5"', f'mass="{mass:g}"')
    loaded = rubbing(1.5).replace('</body></body>', f'{load}</body></body>')
    verdict = diagnose(robot, [sampled(loaded, file.chain.joints, sample, True)])
    found = {f.effect: (f.values, f.deviations) for f in verdict.findings}
    assert set(found) == {'payload', 'motor_coulomb'} and not verdict.remainders
    for effect, name, true in (('payload', 'm', mass), ('motor_coulomb', 'Cc_change', 1.2)):
        values, deviations = found[effect]
        assert values[name] == pytest.approx(true, abs=2.0 * deviations[name])
    gaps = rollouts(file, verdict)['joints'].values()
    assert max(g['after'] for g in gaps) < 0.15 * max(g['before'] for g in gaps)


def test_a_gain_found_in_setpoints_is_written_and_run(tmp_path):
    """The gap after was that of fitted gains, 24 times less than that of the file."""
    (tmp_path / 'robot.xml').write_text(SERVOS)
    file = read_robot(tmp_path / 'robot.xml')
    robot = RobotModel(file.chain, np.full(3, 0.05), 0.05, kp=file.kp, kd=file.kd,
                       gain_tolerance=0.05)
    softer = SERVOS.replace('"lift" kp="200"', '"lift" kp="90"')
    verdict = diagnose(robot, [sampled(softer, file.chain.joints, 0, setpoints=True)])
    finding, = verdict.findings
    text, lacking = closed_file(file, [finding.to_dict()], 'test')
    assert (finding.effect, finding.joint) == ('servo_gain', 'lift') and not lacking
    kp = float(re.search('joint="lift" kp="(.*?)"', text)[1])
    assert kp == pytest.approx(90.0, rel=0.1) and SERVOS.split('<position')[0] in text
    gap = rollouts(file, verdict)['joints']['lift']
    assert gap['after'] < 0.15 * gap['before']
