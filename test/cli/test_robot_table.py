# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""The table of all joints of a robot, and options that name joints."""
import json
from pathlib import Path
import re

import pytest

from gearbox_monitor.cli.check import doubts_of
from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.simulators.mjcf_file import compiled_file, model_of, read_mjcf
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.watch.fold import begin

pytest.importorskip('mujoco')
ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / 'shared' / 'data'
ROBOT = """<mujoco>
  <worldbody><body name="trunk"><freejoint name="base"/><geom size="0.1"/>
    <body name="thigh"><joint name="hip" armature="0.02" damping="0.4" range="-60 60"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
      <body name="shank" pos="0.3 0 0"><joint name="knee" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/></body></body></body>
  </worldbody>
  <tendon><fixed name="belt" stiffness="3"><joint joint="knee" coef="1"/></fixed></tendon>
  <actuator><position name="hip" joint="hip" kp="80" kv="3" forcerange="-9 9"/></actuator>
  <keyframe><key name="bent" qpos="0 0 0 1 0 0 0 0 1.2"/></keyframe>
</mujoco>"""


def test_what_is_read_and_what_is_refused(tmp_path, capsys):
    (tmp_path / 'robot.xml').write_text(ROBOT)
    words = ['check', str(tmp_path / 'robot.xml')]
    assert main([*words, '--json']) == 1
    data = json.loads(capsys.readouterr().out)
    base, hip, knee = data['joints']
    assert (data['read'], base['read'], hip['read'], knee['read']) == (1, False, True, False)
    assert base['refused'] == ['type: free, expected hinge or slide']
    assert hip['control'] == 'position' and hip['units']['kp'] == 'N m/rad'
    assert (hip['values']['kp'], hip['values']['limit']) == (80.0, 9.0)
    assert hip['values']['high'] == pytest.approx(1.0472, rel=1e-4)
    assert 'tendon belt: stiffness: acts on it' in knee['refused'][0]
    assert main([*words, '--keyframe', 'bent']) == 1
    out = capsys.readouterr().out
    assert '1 of 3 joints are read' in out and 'position, kp 80 kd 3, +-9' in out
    assert main([*words, '--keyframe', 'up']) == 2
    assert "keyframe: 'up' is not in the file, expected one of bent" in capsys.readouterr().err


def test_a_file_without_problems(tmp_path, capsys):
    (tmp_path / 'robot.xml').write_text(ROBOT.replace('<freejoint name="base"/>', '').replace(
        ' stiffness="3"', '').replace('0 0 0 1 0 0 0 0 1.2', '0 1.2'))
    target = tmp_path / 'table.json'
    assert main(['check', str(tmp_path / 'robot.xml'), '--json', str(target)]) == 0
    assert json.loads(target.read_text())['read'] == 2
    assert 'no actuator' in capsys.readouterr().out


URDF = """<robot name="arm"><link name="base"/>
  <link name="arm"><visual><geometry><mesh filename="package://absent/a.dae"/></geometry></visual>
    <inertial><mass value="2"/><origin xyz="0 0 -0.1"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"><inertial><mass value="0.2"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="1e-20" iyz="0"/></inertial></link>
  <joint name="elbow" type="revolute"><origin xyz="0 0 1"/><origin xyz="0 5 1" rpy="1 0 0"/>
    <parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="12" velocity="3"/>
    <dynamics damping="0.3" friction="0.2"/></joint>
  <joint name="wrist" type="continuous"><origin xyz="0 0 -0.3"/><parent link="arm"/>
    <child link="tip"/><axis xyz="1 0 0"/>{mimic}</joint>
</robot>"""


def test_a_urdf_is_read_as_ros_does(tmp_path, capsys):
    """Meshes that are absent, a second origin, a tensor that is none by rounding, limits."""
    path = tmp_path / 'arm.urdf'
    path.write_text(URDF.format(mimic=''))
    model = model_of(read_mjcf(path, 'elbow'))
    assert model.arm_inertia + model.motor_inertia == pytest.approx(
        0.02 + 2.0 * 0.1 ** 2 + 0.2 * 0.3 ** 2)
    assert {e['id'] for e in model.effects} == {'gravity', 'saturation'}
    assert main(['check', str(path)]) == 1
    out = ' '.join(capsys.readouterr().out.split())
    assert '1 of 2 joints are read' in out and '<origin> appears twice: the first counts' in out
    assert 'taken for rounding' in out and 'it moves nothing' in out
    path.write_text(URDF.format(mimic='<mimic joint="elbow" multiplier="2"/>'))
    assert main(['check', str(path)]) == 1
    assert '0 of 2 joints are read' in capsys.readouterr().out


ARM = config_path('arm6.urdf').read_text()


DOUBTS = [
    ('<mass value="11.5"/>', '<mass value="0.0115"/>', 'link upper_arm: mass 0.0115 kg: it hangs'),
    ('<mass value="0.9"/>', '<mass value="900"/>', 'link flange: mass 900 kg, its neighbours'),
    ('<origin xyz="0.01 0.03 0.26"/>', '<origin xyz="1 3 260"/>',
     'link upper_arm: centre of mass 260'),
    ('ixx="0.52" iyy="0.50" izz="0.055"', 'ixx="520" iyy="500" izz="55"',
     'link upper_arm: inertia of a body 6.'),
    ('lower="-1.8" upper="1.8" effort="250"', 'lower="0" upper="0" effort="250"',
     'joint joint2: range 0 to 0'),
    ('effort="250" velocity="3"', 'effort="0" velocity="3"', 'joint joint1: effort limit 0')]


def described(path, capsys, old, new):
    """Return exit code and output of check for the arm with `new` for `old`."""
    assert old in ARM
    path.write_text(ARM.replace(old, new, 1))
    code = main(['check', str(path)])
    return code, ' '.join(''.join(capsys.readouterr()).split())


def test_what_no_robot_has_is_doubted_without_a_log(tmp_path, capsys):
    """Nor without MuJoCo, in a chain, as whoever reads the whole robot has it."""
    path = tmp_path / 'arm.urdf'
    for old, new, said in DOUBTS:
        code, out = described(path, capsys, old, new)
        assert code == 1 and said in out and '6 of 6 joints are read' in out, said
        doubts = read_robot(path).doubts
        assert any(doubt.startswith(said) for doubt in doubts), said
        assert begin(path.read_text()).doubts == doubts


def test_a_link_spoils_its_own_joints_only(tmp_path, capsys):
    """A tensor of no body, at the shoulder and at the flange; no mass behind the last joint."""
    path, inertial = tmp_path / 'arm.urdf', ARM[ARM.rindex('<inertial>'):ARM.rindex('</inertial>')]
    tensor = re.search('ixx="0.52" iyy="0.50"[^/]*', ARM)[0]
    for new in (tensor.replace('0.50', '0.05'), tensor.replace('0.50', '-0.5'),
                'ixx="0.52" iyy="-0.52" izz="0.52" ixy="0" ixz="0" iyz="0"'):
        code, out = described(path, capsys, tensor, new)
        assert code == 1 and 'link upper_arm: a tensor of no body' in out
        assert '5 of 6 joints are read' in out or '4 of 6 joints are read' in out
    code, out = described(path, capsys, f'{inertial}</inertial>', '')
    assert code == 1 and '5 of 6 joints are read' in out and 'flange, tool: no mass' in out


NO_URDF = [
    ('name="joint2"', 'name="${prefix}joint2"', 'of xacro, expected a URDF: xacro '),
    ('effort="250"', 'effort="$(arg effort)"', 'of xacro, expected a URDF: xacro '),
    ('<link name="base', '<xacro:arm xmlns:xacro="http://www.ros.org/wiki/xacro"/><link '
     'name="base', 'of xacro, expected a URDF: xacro '),
    (ARM[ARM.index('<joint'):ARM.rindex('</robot>')], '', 'no joint that moves'),
    ('type="revolute"', 'type="ball"', "joint joint1: type 'ball', expected one of revolute"),
    ('effort="250"', 'effort="ten"', "joint joint1: limit: effort: 'ten', expected a number"),
    ('<mass value="11.5"/>', '<mass value="11,5"/>', "link upper_arm: mass: value: '11,5', expe"),
    ('</joint>', '<mimic joint="joint7"/></joint>', "joint joint1: mimic: 'joint7', did you mean")]


def test_what_is_no_urdf_is_refused_in_its_own_words(tmp_path, capsys):
    for old, new, said in NO_URDF:
        code, out = described(tmp_path / 'arm.urdf', capsys, old, new)
        assert code == 2 and said in out, out


OTHERS = [  # what spoils a joint, and how many of six remain
    ('</joint>', '<mimic joint="joint3"/></joint>', 'mimic: couples it with joint3', 4),
    ('<mass value="11.5"/>', '<mass value="-11.5"/>', 'link upper_arm: mass -11.5 kg', 4),
    ('type="revolute"', 'type="planar"', 'type: planar, expected revolute', 5)]


def test_what_spoils_a_joint_is_said_in_words_of_the_format(tmp_path, capsys):
    for old, new, said, count in OTHERS:
        code, out = described(tmp_path / 'arm.urdf', capsys, old, new)
        assert code == 1 and said in out and f'{count} of ' in out, out


def test_what_mujoco_refuses_is_said_with_its_line_and_element(tmp_path, capsys):
    path = tmp_path / 'robot.xml'
    path.write_text(ROBOT.replace('<freejoint name="base"/>', '\n<freejoint title="base"/>'))
    assert main(['check', str(path)]) == 2
    line = ROBOT[:ROBOT.index('<freejoint name="base"/>')].count('\n') + 2
    assert f"robot.xml: line {line}: freejoint: unrecognized attribute: 'title'" in (
        capsys.readouterr().err)


def test_healthy_robots_are_not_doubted():
    for path in [config_path('arm6.urdf'), *ROOT.glob('benchmarks/real_logs/*/*.urdf'),
                 *SHARED.glob('*/*.urdf')]:
        assert doubts_of(compiled_file(path.read_bytes(), path)) == [], path
        assert begin(path.read_text()).doubts == (), path


@pytest.mark.skipif(not (SHARED / 'lwr4').is_dir(), reason='recordings of others are not here')
def test_the_urdf_of_a_real_arm(capsys):
    assert main(['check', str(SHARED / 'lwr4/kuka_lwr4.urdf')]) == 0
    assert '7 of 7 joints are read' in capsys.readouterr().out
