# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Free runs in MuJoCo: nearer with what is right, and a veto for what is wrong."""
from dataclasses import replace

import numpy as np
import pytest

from gearbox_monitor.balance.rows import RobotModel
from gearbox_monitor.balance.verdict import diagnose
from gearbox_monitor.export.robot_closed import closed_file
from gearbox_monitor.export.robot_model import read_robot
from gearbox_monitor.export.robot_rollout import rollouts
from gearbox_monitor.robot.compiled_model import mujoco_module

pytest.importorskip('mujoco')


@pytest.mark.parametrize('kind, effect, wrong', [
    ('payload', 'payload', 4.0), ('motor_coulomb', 'motor_coulomb', -1.0),
    ('end_spring', 'end_spring', -1.0), ('motor_inertia', 'motor_inertia', 4.0)])
def test_right_findings_are_nearer_and_wrong_ones_vetoed(tmp_path, kind, effect, wrong):
    import random_robots
    case = random_robots.make(10, False, [kind], 100)
    (tmp_path / 'robot.xml').write_text(case.xml)
    file = read_robot(tmp_path / 'robot.xml')
    log, count = random_robots.log(case, 1, 20.0)[0], len(case.joints)
    verdict = diagnose(RobotModel(file.chain, np.full(count, 0.05), 0.05), [log])
    finding, = verdict.findings
    assert finding.effect == effect
    runs = rollouts(file, verdict)
    own = [finding.joint] if finding.joint else list(file.chain.joints)
    gap = {key: np.hypot.reduce([runs['joints'][j][key] for j in own])
           for key in ('before', 'after')}
    assert gap['after'] < 0.5 * gap['before'] and runs['confirmed'] and not runs['without']
    fit = replace(verdict.fit, values=wrong * verdict.fit.values)
    runs = rollouts(file, replace(verdict, fit=fit))
    assert runs['vetoed'] == [f'{effect} of {finding.joint or finding.link}']
    assert not runs['confirmed']


def test_a_vetoed_finding_is_not_written(tmp_path):
    (tmp_path / 'robot.xml').write_text(
        '<mujoco><worldbody><body name="a"><joint name="j"/><geom size=".1"/></body></worldbody>'
        '</mujoco>')
    finding = {'effect': 'motor_inertia', 'joint': 'j', 'values': {'m1_change': 0.1},
               'deviations': {'m1_change': 0.01}}
    file = read_robot(tmp_path / 'robot.xml')
    assert 'armature="0.1"' in closed_file(file, [{**finding, 'confirmed': True}], 'test')[0]
    text, left = closed_file(file, [{**finding, 'confirmed': False}], 'test')
    assert text is None and 'farther off' in left[0]


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
