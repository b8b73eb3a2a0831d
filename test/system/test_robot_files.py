# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The comparison of a collection of robots: what agrees, what is refused, and a wrong reading."""
import pytest

pytest.importorskip('mujoco')
import robot_files  # noqa: E402
from script import run_script  # noqa: E402

pytestmark = pytest.mark.benchmark
ARM = """<mujoco><worldbody><body><joint name="shoulder" axis="0 1 0" damping="0.3"
frictionloss="0.1" armature="0.01"/><inertial pos="0.2 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
<body pos="0.4 0 0"><joint name="elbow" axis="0 1 0" {}/>
<inertial pos="0.1 0 0" mass="0.5" diaginertia="0.002 0.002 0.002"/></body></body></worldbody>
<actuator><motor joint="shoulder" ctrlrange="-20 20"/>
<position joint="elbow" kp="20" kv="1" ctrlrange="-2 2"/></actuator>
<keyframe><key name="home" qpos="0.3 -0.5"/></keyframe></mujoco>"""


def test_joints_agree_with_mujoco_or_are_refused(tmp_path, capsys, monkeypatch):
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a/arm.xml').write_text(ARM.format(''))
    (tmp_path / 'poly.xml').write_text(ARM.format('stiffness="2 1"'))
    (tmp_path / 'scene.xml').write_text('<mujoco><include file="a/arm.xml"/></mujoco>')
    assert run_script(robot_files, [str(tmp_path)]) == 0
    assert '2 files, 4 joints: 3 read, 0 of them apart' in capsys.readouterr().out
    right = robot_files.ours
    monkeypatch.setattr(robot_files, 'ours', lambda *args: right(*args) + 0.01)
    assert run_script(robot_files, [str(tmp_path)]) == 1
    assert run_script(robot_files, [str(tmp_path / 'b')]) == 2
