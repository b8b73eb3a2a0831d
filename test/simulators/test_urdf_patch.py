# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""A drive in a URDF file: written into it, and read; MuJoCo is the oracle."""
import cmath
import math
from pathlib import Path
import re

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.simulators.drive_patch import in_urdf, patched_urdf
from gearbox_monitor.simulators.mjcf_file import drive_of, model_of, weight

URDF = """<?xml version="1.0"?>
<robot name="arm">
  <!-- measured in June -->
  <link name="base"/>
  <link name="forearm">
    <inertial>
      <origin xyz="0.05 0 -0.1" rpy="0.3 0 0.2"/>
      <mass   value="1.0"/>
      <inertia ixx="0.013" ixy="0" ixz="0" iyy="0.0134" iyz="0" izz="0.002"/>
    </inertial>
  </link>
  <link name="hand">
    <inertial><mass value="0.2"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001"
      iyz="0" izz="0.001"/></inertial>
  </link>
  <joint name="elbow" type="revolute">
    <parent link="base"/>
    <child link="forearm"/>
    <axis xyz="0 2 0"/>
    <dynamics damping='0.1' friction="0.27"/>  <!-- guess -->
    <limit lower="-2" upper="2" effort="10" velocity="3"/>
  </joint>
  <joint name="wrist" type="continuous">
    <origin xyz="0.1 0 -0.3" rpy="0 0.5 0"/>
    <parent link="forearm"/>
    <child link="hand"/>
    <axis xyz="1 0 0"/>
  </joint>
</robot>
"""
MODEL = model_from_dict({
    'position_gain': 0.0, 'transmission': {'kind': 'rigid'}, 'arm_inertia': 0.06, 'effects': [
        {'id': 'motor_coulomb', 'Cc': 0.35}, {'id': 'arm_coulomb', 'Cac': 0.05},
        {'id': 'stribeck', 'Cs': 0.1, 'vs': 0.2}, {'id': 'saturation', 'umax': 4.0}]}, 'test')


def patch_of(model=MODEL, text=URDF, joint='elbow'):
    return patched_urdf(text.encode(), Path('robot.urdf'), joint, model)


def drive_in(data):
    pytest.importorskip('mujoco')
    return drive_of(data, Path('robot.urdf'), ('elbow', None))


def test_the_joint_moves_like_the_model():
    patch = patch_of()
    joint = drive_in(patch.data).motor
    assert joint.inertia == pytest.approx(0.06 + MODEL.motor_inertia, rel=1e-6)
    assert (joint.damping, joint.frictionloss) == pytest.approx((0.1, 0.4))
    assert {row.id: row.kind for row in patch.exported} == {
        'stribeck': 'refused', 'motor_inertia': 'construct'}
    assert not patch_of(text=patch.data.decode()).changes
    changed = [line for line in patch.data.decode().splitlines()
               if line not in URDF.splitlines()]
    assert all(word not in ' '.join(changed) for word in ('mass', 'wrist', 'pose', 'origin'))
    assert '4' in ' '.join(changed) and 'lower="-2"' in patch.data.decode()


def test_less_inertia_keeps_a_tensor_that_a_body_can_have():
    joint = drive_in(URDF.encode()).motor
    patch = patch_of(MODEL.with_(motor_inertia=1e-4, arm_inertia=joint.inertia - 0.005))
    after = drive_in(patch.data)
    assert after.motor.inertia == pytest.approx(joint.inertia - 0.0049, rel=1e-6)


WEIGHTS = [
    (1.5, 0.0, 0.06), (2.5, -2.0, 0.03), (0.2, 1.0, 0.06)]


def test_the_weight_of_the_model_is_that_of_the_link():
    for size, phase, inertia in WEIGHTS:
        model = MODEL.with_(arm_inertia=inertia, effects=[
            {'id': 'gravity', 'G': size, 'phi': phase}])
        patch = patch_of(model)
        drive = drive_in(patch.data)
        assert weight(drive) == pytest.approx(cmath.rect(size, phase), rel=1e-5)
        assert drive.motor.inertia == pytest.approx(inertia + MODEL.motor_inertia, rel=1e-5)
        assert {row.id: row.kind for row in patch.exported}['gravity'] == 'native'
        again = patch_of(model, patch.data.decode())
        assert not [change for change in again.changes if 'link' in change.element]


def test_a_slide_takes_mass():
    text = URDF.replace('revolute', 'prismatic')
    patch = patch_of(model_from_dict({
        'axis': 'prismatic', 'position_gain': 0.0, 'transmission': {'kind': 'rigid'},
        'motor_inertia': 0.5, 'arm_inertia': 1.2}, 'test'), text)
    assert drive_in(patch.data).motor.inertia == pytest.approx(1.7)
    assert b'<mass   value="1.5"/>' in patch.data


def test_the_robot_is_read():
    model = model_of(drive_in(URDF.encode()), {'gear_ratio': 1.0, 'motor_inertia': 0.01})
    # m (x^2 + z^2) and both tensors, turned about the axis y of the joint.
    c, s = np.cos([0.3, 0.2]), np.sin([0.3, 0.2])
    about = np.array([s[1], c[1] * c[0], c[1] * s[0]])  # y in the frame of the inertial, roll, yaw
    assert model.arm_inertia == pytest.approx(
        0.0125 + about ** 2 @ [0.013, 0.0134, 0.002] + 0.2 * (0.1 ** 2 + 0.3 ** 2) + 0.001)
    assert model.viscous_friction == 0.1 and model.coulomb_friction == 0.27
    # Centres of mass: 0.07 kg m ahead of the joint and 0.16 kg m below it.
    load, = (e for e in model.effects if e['id'] == 'gravity')
    assert (load['G'], load['phi']) == pytest.approx(
        (9.81 * math.hypot(0.07, 0.16), math.atan2(-0.07, 0.16)), rel=1e-6)


INEXPRESSIBLE = [
    (('<limit lower="-2" upper="2" effort="10" velocity="3"/>', ''), {},
     'no <limit> in the joint, which needs a velocity: add one with effort="4"'),
    (('', ''), {'arm_inertia': 0.02}, 'weight: MuJoCo makes'),
    (('<axis xyz="0 2 0"/>', '<axis xyz="0 0 1"/>'),
     {'effects': [{'id': 'gravity', 'G': 1.5}]}, 'gravity acts along its axis'),
    (('', ''), {'transmission': {'kind': 'dead_zone'}}, 'a joint is rigid there')]


def test_what_a_file_cannot_express_is_listed():
    for change, model, row in INEXPRESSIBLE:
        data = {**MODEL.to_dict(), **model}
        patch = patch_of(model_from_dict(data, 'test'), URDF.replace(*change))
        assert any(row in one.words and one.kind == 'refused' for one in patch.exported)


def test_an_effect_without_a_parameter_is_listed():
    for effect in EFFECTS.values():
        values = {p.name: p.choices[0] if p.choices else [0.1, 0.2] if p.listed else
                  2 if p.whole else min(max(0.013, p.low), p.high) for p in effect.parameters}
        changes = {'controller': {'kp': 20.0}} if effect.location == 'controller' else {}
        if effect.location in ('transmission', 'arm_sensor'):
            changes['kind'] = 'dead_zone'
        model = MODEL.with_(**changes, effects=[{'id': effect.id, **values}])
        listed = {row.id for row in patch_of(model).exported if row.kind == 'refused'}
        assert in_urdf(effect).startswith('none: ') == bool(
            listed & {effect.id, 'controller', 'transmission'})


BAD_FILES = [
    ('<sdf/>', 'elbow', '<sdf>, expected <robot> with --to urdf'),
    (URDF, 'knee', "'knee' is not in this file, expected one of elbow, wrist")]


def test_one_line_for_a_bad_file():
    for text, joint, problem in BAD_FILES:
        with pytest.raises(InputError) as error:
            patch_of(text=text, joint=joint)
        assert problem in str(error.value)


def test_the_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path('m.yaml').write_text('transmission: {kind: rigid}\nposition_gain: 0\narm_inertia: 0.06\n')
    Path('robot.urdf').write_text(URDF)
    words = ['export', 'm.yaml', '--to', 'urdf', '--into', 'robot.urdf']
    assert main([*words, '--joint', 'elbow', '--out', 'new.urdf']) == 0
    assert 'written new.urdf' in capsys.readouterr().out
    assert Path('robot.urdf').read_text() == URDF != Path('new.urdf').read_text()
    assert main([*words, '--joint', 'elbow']) == 0
    assert '+++ b/robot.urdf' in capsys.readouterr().out
    assert main(words) == 2
    assert '--joint: missing, --to urdf needs it' in capsys.readouterr().err


def test_a_flat_link_turned_any_way_is_a_body():
    """Its largest principal inertia is the sum of the others, which rounding breaks."""
    pytest.importorskip('mujoco')
    random, places = np.random.default_rng(0), ('xx', 'yy', 'zz', 'xy', 'xz', 'yz')
    for _ in range(40):
        a, b = random.uniform(0.001, 1.0, 2) * 10.0 ** random.uniform(-4.0, 2.0)
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        tensor = turn @ np.diag([a, b, a + b]) @ turn.T
        words = ' '.join(f'i{p}="{tensor["xyz".index(p[0]), "xyz".index(p[1])]:.15g}"'
                         for p in places)
        text = re.sub('<inertia ixx="0.013".*/>', f'<inertia {words}/>', URDF)
        assert drive_in(text.encode()).refusals() == []
