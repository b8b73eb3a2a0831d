# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""Every effect with a place in a file: written, read back, and run by MuJoCo without a gap."""
from pathlib import Path

import numpy as np
import pytest
from test_mjcf import assert_read_back, BOUND, CASES, DT, free_run, nominal, PAIR, U
from test_robot_rollout import sampled, SERVOS

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.diagnosis.robot.verdict import diagnose
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.simulators.drive_patch import patched
from gearbox_monitor.simulators.mjcf import EXPRESSIONS, REFUSED, values_of
from gearbox_monitor.simulators.mjcf_file import read_mjcf
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.robot_patch import closed_file, NEEDED, OF_LINK

SERVO_CASES = {
    'servo_gain': {'kp': 30.0}, 'servo_limit': {'umax': 4.0}, 'setpoint_delay': {'T': 0.0053},
    'setpoint_lag': {'T': 0.01}}
ROBOT_CASES = {
    'motor_coulomb': ('lift', {'Cc_change': 1.2}), 'motor_viscous': ('nod', {'Cv_change': 0.8}),
    'motor_inertia': ('turn', {'m1_change': 0.1}), 'servo_gain': ('lift', {'kp_factor': 0.6}),
    'payload': ('tip', {'m': 0.5, 'cx': 0.25, 'cy': 0.0, 'cz': 0.0}),
    'link_inertia': ('tip', dict(zip(('Ixx', 'Iyy', 'Izz', 'Ixy', 'Ixz', 'Iyz'), (
        0.001, 0.02, 0.02, 0.0, 0.0, 0.0)))),
    'base_tilt': ('base', {'ax': 0.1, 'ay': -0.05})}


def test_every_expressed_effect_has_a_case():
    assert {name for name, e in EXPRESSIONS.items() if e.kind != REFUSED} == {
        *CASES, *SERVO_CASES}
    assert set(ROBOT_CASES) == set(NEEDED)


def written(name):
    """Return a model with the effect `name`, its Patch, and what drives it [N]."""
    model, servo = nominal(), name in SERVO_CASES
    if servo:
        model = model.with_(controller={'kp': 40.0, 'kd': 1.0, 'torque_limit': 8.0})
    if name == 'hysteresis_branch':
        model = model.with_(half_gap=0.0)
    effect = {'id': name, **(SERVO_CASES if servo else CASES)[name]}
    model = model.with_(effects=[*(e for e in model.effects if e['id'] != name), effect])
    patch = patched(read_mjcf(PAIR, 'motor', 'arm'), *values_of(model))
    assert not [row for row in patch.exported if row.kind == REFUSED]
    return model, patch, 0.15 * U if servo else U


@pytest.mark.parametrize('names', [list(CASES)[::2], list(CASES)[1::2], list(SERVO_CASES)])
def test_a_joint_moves_in_mujoco_as_here_and_is_read_back(names):
    for name in names:
        model, patch, u = written(name)
        off = free_run(patch, u) - simulate(model, u, DT).y
        # a filter of MuJoCo begins at 0, ours at the first setpoint
        if name in SERVO_CASES:
            assert np.abs(off[200:]).max() < 5.0 * BOUND or name == 'setpoint_lag', name
        else:
            assert np.sqrt(np.mean(off ** 2, axis=0)).max() < BOUND, name
        assert_read_back(model, patch, u)


def kind_of(text, folder, names, setpoints):
    """Return the verdict on MuJoCo's run of a file beside that file itself."""
    (folder / 'closed.xml').write_text(text)
    file = read_robot(folder / 'closed.xml')
    robot = RobotModel(file.chain, np.full(len(file.chain.joints), 0.05), 0.05, kp=file.kp,
                       kd=file.kd, gain_tolerance=0.05)
    return diagnose(robot, [sampled(text, file.chain.joints, 0, setpoints)], None, names).kind


def closed_robot(folder, names):
    """Return the file of the robot with the effects `names`, as findings."""
    (folder / 'robot.xml').write_text(SERVOS)
    text, lacking = closed_file(read_robot(folder / 'robot.xml'), [{
        'effect': name, 'link' if name in (*OF_LINK, 'base_tilt') else 'joint': place,
        'values': values, 'deviations': dict.fromkeys(values, 1e-3)}
        for name, (place, values) in ROBOT_CASES.items() if name in names], 'test')
    assert not lacking
    return text


def test_a_robot_moves_in_mujoco_as_its_written_file(tmp_path):
    """All effects at once: MuJoCo's run of the written file has no gap beside that file."""
    text = closed_robot(tmp_path, ROBOT_CASES)
    assert kind_of(text, tmp_path, list(ROBOT_CASES), True) == 'none'


@pytest.mark.system
@pytest.mark.parametrize('name', list(ROBOT_CASES))
def test_a_run_of_the_written_file_is_diagnosed_none(tmp_path, name):
    text = closed_robot(tmp_path, [name])
    assert kind_of(text, tmp_path, None, name == 'servo_gain') == 'none'


@pytest.mark.system
@pytest.mark.parametrize('name', [*CASES, *SERVO_CASES])
def test_mujocos_run_of_the_written_file_is_diagnosed_none(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    model, patch, _ = written(name)
    Path('robot.xml').write_bytes(patch.data)
    t, random = np.arange(0.0, 8.0, DT), np.random.default_rng(3)
    u = sum(np.sin(2.0 * np.pi * rate * t + k) for k, rate in enumerate((0.4, 0.9, 1.7, 2.3)))
    u *= 0.25 if name in SERVO_CASES else 2.0
    y = free_run(patch, u) + 0.001 * random.standard_normal((len(t), 2))
    column = 'setpoint' if name in SERVO_CASES else 'u'
    np.savetxt('run.csv', np.column_stack([t, u, y]), '%.9g', ',', comments='',
               header=f't,{column},motor,arm')
    words = ['--model', 'robot.xml', '--joint', patch.joints[0], '--model-arm-joint']
    assert main(['diagnose', 'run.csv', *words, patch.joints[1]]) == 0
