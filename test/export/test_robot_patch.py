# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""A drive in URDF and SDF files: written into them, and read; MuJoCo is the oracle."""
import cmath
import math
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.export.mjcf_file import drive_of, model_of, weight
from gearbox_monitor.export.robot_patch import patched_robot
from gearbox_monitor.export.sdf_file import urdf_of
from gearbox_monitor.export.xml_edit import parse_xml
from gearbox_monitor.plant.drive import model_from_dict

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
# The same robot; the frames of links lie elsewhere than those of joints.
SDF = """<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><model name="arm">
  <link name="base"><pose>0 0 1 0 0 0</pose></link>
  <link name="forearm">
    <pose>0 0.2 1 0 0 0</pose>
    <inertial>
      <pose>0.05 -0.2 -0.1 0.3 0 0.2</pose>
      <mass>1.0</mass>
      <inertia><ixx>0.013</ixx><iyy>0.0134</iyy><izz>0.002</izz></inertia>
    </inertial>
  </link>
  <link name="hand">
    <pose relative_to="wrist"/>
    <inertial><mass>0.2</mass>
      <inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.001</izz></inertia></inertial>
  </link>
  <joint name="elbow" type="revolute">
    <pose>0 -0.2 0 0 0 1.5707963267948966</pose>
    <parent>base</parent>
    <child>forearm</child>
    <axis>
      <xyz>1 0 0</xyz> <!-- of the joint -->
      <dynamics><damping>0.1</damping><friction>0.27</friction></dynamics>
    </axis>
  </joint>
  <joint name="wrist" type="revolute">
    <pose relative_to="forearm">0.1 -0.2 -0.3 0 0.5 0</pose>
    <parent>forearm</parent>
    <child>hand</child>
    <axis><xyz>1 0 0</xyz></axis>
  </joint>
</model></world></sdf>
"""
FILES = {'urdf': URDF, 'sdf': SDF}
MODEL = model_from_dict({
    'position_gain': 0.0, 'transmission': {'kind': 'rigid'}, 'arm_inertia': 0.06, 'effects': [
        {'id': 'motor_coulomb', 'Cc': 0.35}, {'id': 'arm_coulomb', 'Cac': 0.05},
        {'id': 'stribeck', 'Cs': 0.1, 'vs': 0.2}, {'id': 'saturation', 'umax': 4.0}]}, 'test')


def patch_of(target, model=MODEL, text=None, joint='elbow'):
    text = FILES[target] if text is None else text
    return patched_robot(text.encode(), Path(f'robot.{target}'), joint, model, target)


def drive_in(target, data):
    pytest.importorskip('mujoco')
    return drive_of(data, Path(f'robot.{target}'), ('elbow', None))


@pytest.mark.parametrize('target', FILES)
def test_the_joint_moves_like_the_model(target):
    patch = patch_of(target)
    joint = drive_in(target, patch.data).motor
    assert joint.inertia == pytest.approx(0.06 + MODEL.motor_inertia, rel=1e-6)
    assert (joint.damping, joint.frictionloss) == pytest.approx((0.1, 0.4))
    assert {row.id: row.kind for row in patch.exported} == {
        'stribeck': 'refused', 'motor_inertia': 'construct'}
    assert not patch_of(target, text=patch.data.decode()).changes
    changed = [line for line in patch.data.decode().splitlines()
               if line not in FILES[target].splitlines()]
    assert all(word not in ' '.join(changed) for word in ('mass', 'wrist', 'pose', 'origin'))
    assert '4' in ' '.join(changed) and 'lower="-2"' in patch.data.decode() or target == 'sdf'


@pytest.mark.parametrize('target', FILES)
def test_less_inertia_keeps_a_tensor_that_a_body_can_have(target):
    joint = drive_in(target, FILES[target].encode()).motor
    patch = patch_of(target, MODEL.with_(motor_inertia=1e-4, arm_inertia=joint.inertia - 0.005))
    after = drive_in(target, patch.data)
    assert after.motor.inertia == pytest.approx(joint.inertia - 0.0049, rel=1e-6)


@pytest.mark.parametrize('target', FILES)
@pytest.mark.parametrize('size, phase, inertia', [
    (1.5, 0.0, 0.06), (2.5, -2.0, 0.03), (0.2, 1.0, 0.06)])
def test_the_weight_of_the_model_is_that_of_the_link(target, size, phase, inertia):
    model = MODEL.with_(arm_inertia=inertia, effects=[
        {'id': 'gravity', 'G': size, 'phi': phase}])
    patch = patch_of(target, model)
    drive = drive_in(target, patch.data)
    assert weight(drive) == pytest.approx(cmath.rect(size, phase), rel=1e-5)
    assert drive.motor.inertia == pytest.approx(inertia + MODEL.motor_inertia, rel=1e-5)
    assert {row.id: row.kind for row in patch.exported}['gravity'] == 'native'
    again = patch_of(target, model, patch.data.decode())
    assert not [change for change in again.changes if 'link' in change.element]


def test_a_slide_takes_mass():
    text = URDF.replace('revolute', 'prismatic')
    patch = patch_of('urdf', model_from_dict({
        'axis': 'prismatic', 'position_gain': 0.0, 'transmission': {'kind': 'rigid'},
        'motor_inertia': 0.5, 'arm_inertia': 1.2}, 'test'), text)
    assert drive_in('urdf', patch.data).motor.inertia == pytest.approx(1.7)
    assert b'<mass   value="1.5"/>' in patch.data


def test_both_formats_are_one_robot():
    models = [model_of(drive_in(target, text.encode()),
                       {'gear_ratio': 1.0, 'motor_inertia': 0.01, 'effects': [
                           {'id': 'gravity', 'G': 1.0}]}) for target, text in FILES.items()]
    assert models[0].arm_inertia == pytest.approx(models[1].arm_inertia, rel=1e-9)
    # m (x^2 + z^2) and both tensors, turned about the axis y of the joint.
    c, s = np.cos([0.3, 0.2]), np.sin([0.3, 0.2])
    about = np.array([s[1], c[1] * c[0], c[1] * s[0]])  # y in the frame of the inertial, roll, yaw
    assert models[0].arm_inertia == pytest.approx(
        0.0125 + about ** 2 @ [0.013, 0.0134, 0.002] + 0.2 * (0.1 ** 2 + 0.3 ** 2) + 0.001)
    assert models[1].viscous_friction == 0.1 and models[1].coulomb_friction == 0.27
    spring = SDF.replace('<damping>', '<spring_stiffness>2</spring_stiffness><damping>')
    assert model_of(drive_in('sdf', spring.encode()), {
        'gear_ratio': 1.0, 'motor_inertia': 0.01,
        'effects': [{'id': 'gravity', 'G': 1.0}]}).position_gain == 2.0
    # Centres of mass: 0.07 kg m ahead of the joint and 0.16 kg m below it.
    load, = (e for e in model_of(drive_in('urdf', URDF.encode()), {
        'gear_ratio': 1.0, 'motor_inertia': 0.01}).effects if e['id'] == 'gravity')
    assert (load['G'], load['phi']) == pytest.approx(
        (9.81 * math.hypot(0.07, 0.16), math.atan2(-0.07, 0.16)), rel=1e-6)


INEXPRESSIBLE = [
    ('urdf', ('<limit lower="-2" upper="2" effort="10" velocity="3"/>', ''), {},
     'no <limit> in the joint, which needs a velocity: add one with effort="4"'),
    ('urdf', ('mass   value="1.0"', 'mass value="one"'), {}, "'one', expected a number"),
    ('urdf', ('', ''), {'arm_inertia': 0.02}, 'expected a sum above 0; the joint moves 0.026442'),
    ('sdf', ('type="revolute">\n    <pose rel', 'type="ball">\n    <pose rel'), {},
     "type 'ball', expected one of"),
    ('sdf', ('relative_to="wrist"', 'relative_to="nobody"'), {}, "frame 'nobody'"),
    ('urdf', ('<axis xyz="0 2 0"/>', '<axis xyz="0 0 1"/>'),
     {'effects': [{'id': 'gravity', 'G': 1.5}]}, 'gravity acts along its axis'),
    ('sdf', ('', ''), {'transmission': {'kind': 'dead_zone'}}, 'a joint is rigid there')]


def test_what_a_file_cannot_express_is_listed():
    for target, change, model, row in INEXPRESSIBLE:
        data = {**MODEL.to_dict(), **model}
        patch = patch_of(target, model_from_dict(data, 'test'), FILES[target].replace(*change))
        assert any(row in one.words and one.kind == 'refused' for one in patch.exported)


BAD_FILES = [
    ('urdf', SDF, 'elbow', '<sdf>, expected <robot> with --to urdf'),
    ('urdf', URDF, 'knee', "'knee' is not in this file, expected one of elbow, wrist"),
    ('sdf', SDF, 'knee', "joint: 'knee', expected one of elbow, wrist"),
    ('sdf', SDF.replace('<xyz>1 0 0</xyz> <!--', '<xyz>1 zero</xyz> <!--'), '',
     "xyz: '1 zero', expected numbers")]


def test_one_line_for_a_bad_file():
    for target, text, joint, problem in BAD_FILES:
        with pytest.raises(InputError) as error:
            if joint:
                patch_of(target, text=text, joint=joint)
            else:
                urdf_of(parse_xml(text.encode(), 'robot.sdf'), 'elbow')
        assert problem in str(error.value).replace('did you mean', 'expected')


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
    assert '--joint: missing, --into needs it' in capsys.readouterr().err
    assert main([*words, '--joint', 'elbow', '--check', 'bag']) == 2
    assert '--check: with --to urdf, expected it with --to mjcf' in capsys.readouterr().err
