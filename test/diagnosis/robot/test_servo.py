# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A log with setpoints and torques tells the mechanics and the servos apart."""
import json
import re

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.library.identify import diagnose
from gearbox_monitor.library.robot import load_robot

ARM = """<mujoco><compiler angle="radian"/><option timestep="0.001" integrator="implicitfast"/>
<default><joint damping="0.2" frictionloss="0.3" armature="0.02"/></default><worldbody>
<body name="upper"><joint name="shoulder" axis="0 1 0"/>
<inertial pos="0 0 .15" mass="1.5" diaginertia=".02 .02 .005"/>
<body name="fore" pos="0 0 .3"><joint name="elbow" axis="0 1 0"/>
<inertial pos="0 0 .12" mass="{mass}" diaginertia=".01 .01 .003"/></body></body></worldbody>
<actuator><position name="a" joint="shoulder" kp="{kp}" kv="8"/>
<position name="b" joint="elbow" kp="80" kv="4"/></actuator></mujoco>"""
RATE, SECONDS = 200, 10


def log(path, mass=1.0, kp=200, late=0, stiff=False, joints=('shoulder', 'elbow'), seed=5):
    """
    Write what the arm does with its servos: position, torque of the period and setpoint.

    stiff: the robot has other servos, which hold it at its setpoints; joints: with a setpoint;
    seed: of motion and noise.
    """
    mujoco = pytest.importorskip('mujoco')
    random = np.random.default_rng(seed)
    m = mujoco.MjModel.from_xml_string(ARM.format(mass=mass, kp=kp))
    d, t = mujoco.MjData(m), np.arange(RATE * SECONDS) / RATE
    setpoint = np.column_stack([sum(a * np.sin(2.0 * np.pi * f * t + p) for a, f, p in zip(
        (0.4, 0.25, 0.15), random.uniform(0.15, 0.7, 3), random.uniform(0.0, 6.0, 3)))
        for _ in range(2)])
    d.qpos[:] = setpoint[0]
    rows = []
    for k in range(len(t)):
        d.ctrl[:] = setpoint[max(k - late, 0)]
        q, torque = d.qpos.copy(), np.zeros(2)
        for _ in range(1000 // RATE):
            mujoco.mj_step(m, d)
            torque += d.qfrc_actuator * RATE / 1000
        rows.append([t[k], *q + random.normal(0.0, 1e-5, 2),
                     *torque + random.normal(0.0, 0.01, 2),
                     *(q if stiff else setpoint[k])[:len(joints)]])
    np.savetxt(path, rows, delimiter=',', comments='', header=','.join([
        't,q_shoulder,q_elbow,tau_shoulder,tau_elbow', *(f'setpoint_{name}' for name in joints)]))
    return str(path)


def test_setpoints_and_torques_in_one_log_are_both_used(tmp_path, capsys):
    model = tmp_path / 'arm.xml'
    model.write_text(ARM.format(mass=1.0, kp=200))
    for name, changes, truth in (
            ('same', {}, {}),
            ('weak', {'kp': 140}, {('servo_gain', 'shoulder'): ('kp_factor', 0.7)}),
            ('late', {'late': 4}, {('setpoint_delay', 'base'): ('T', 0.02)}),
            ('both', {'mass': 1.3, 'kp': 290}, {('payload', 'fore'): ('m', 0.3),
                                                ('servo_gain', 'shoulder'): ('kp_factor', 1.45)})):
        code = main(['diagnose', log(tmp_path / f'{name}.csv', **changes), '--model', str(model),
                     '--json', '-'])
        data = json.loads(capsys.readouterr().out)
        found = {(f['effect'], f.get('joint') or f['link']): f for f in data['findings']}
        assert code == bool(truth) and set(found) == set(truth), name
        for key, (value, size) in truth.items():
            f = found[key]
            assert abs(f['values'][value] - size) < max(3.0 * f['deviations'][value], 0.1 * size)
            if key[0] != 'payload':  # runs with the recorded torques say nothing about a servo
                assert f['confirmed'] is None
        gaps = {gap['joint']: gap for gap in data['servos']}
        assert name != 'weak' or gaps['shoulder']['after'] < 0.2 * gaps['shoulder']['before']


def test_servos_are_compared_with_those_of_a_reference(tmp_path, capsys):
    model, taught = tmp_path / 'arm.xml', str(tmp_path / 'arm.knowledge')
    model.write_text(ARM.format(mass=1.0, kp=200))
    stated = ['--model', str(model), '--json', '-']
    reference = log(tmp_path / 'reference.csv', kp=260, seed=6)
    assert main(['learn', reference, '--model', str(model), '--out', taught]) == 0
    capsys.readouterr()
    for kp, expected in ((260, set()), (180, {('servo_gain', 'shoulder')})):
        main(['diagnose', log(tmp_path / 'log.csv', kp=kp), *stated, '--reference', taught,
              *(['--out', str(tmp_path / 'out')] if expected else [])])
        data = json.loads(capsys.readouterr().out)
        found = {(f['effect'], f['joint']): f['values'] for f in data['findings']}
        assert set(found) == expected
    gain = found['servo_gain', 'shoulder']
    assert abs(gain['kp_factor'] - 180 / 260) < 0.02 and abs(gain['kp_of_model'] - 0.9) < 0.02
    assert re.search(r'times the value of the references, 0\.(90|89)', data['summary'])
    closed = (tmp_path / 'out' / 'arm.closed.xml').read_text()
    assert abs(float(re.search(r'shoulder" kp="([0-9.]+)', closed)[1]) - 180) < 4


def test_setpoints_that_are_not_used_or_not_followed_are_said(tmp_path, capsys):
    model = tmp_path / 'arm.xml'
    model.write_text(ARM.format(mass=1.0, kp=200))
    healthy, stiff, half = (log(tmp_path / f'{name}.csv', **changes) for name, changes in (
        ('healthy', {}), ('stiff', {'stiff': True}), ('half', {'joints': ('shoulder',)})))

    def diagnosed(*logs):
        code = main(['diagnose', *logs, '--model', str(model), '--json', '-'])
        return code, json.loads(capsys.readouterr().out)
    code, data = diagnosed(stiff)  # not "as the model file says": its servos are others
    assert code == 1 and data['verdict'] == 'unknown' and not data['findings']
    assert {(r['joint'], r['place']) for r in data['remainders']} == {
        ('shoulder', 'controller'), ('elbow', 'controller')}
    for logs in ([healthy, half], [healthy, '--reference', half]):
        _, data = diagnosed(*logs)
        assert any('not used' in note for note in data['warnings']) and not data['servos']
    for effects in (['payload'], ['servo_gain']):
        data = diagnose(healthy, load_robot(model), only=effects).data
        tried = effects != ['payload']
        assert data['verdict'] == 'none' and bool(data['servos']) == tried
        assert ('servo_gain' in data['not_tried']) != tried
