# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The file of a robot with the findings of a diagnosis: what changes, and what is said."""
import numpy as np
import pytest

from gearbox_monitor.report.words import finding_words
from gearbox_monitor.robot.chain import inertial
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.robot_patch import closed_file

MJCF = """<?xml version="1.0"?>
<!-- the <mujoco> of our arm -->
<mujoco>
  <default><joint damping="0.5" frictionloss="1.5"/></default>
  <worldbody>
    <body name="upper" pos="0 0 .1">  <!-- weighed -->
      <joint name="shoulder" axis="0 1 0" armature=".1"/>
      <inertial pos="0 0 .2" mass="4" diaginertia=".06 .06 .01"/>
      <geom size=".1"/>
      <frame pos="0 0 .4">
        <body>
          <joint axis="0 1 0" pos="0 .05 0"/>
          <geom type="box" size=".03 .04 .2" pos="0 0 .1"/>
        </body>
      </frame>
    </body>
  </worldbody>
  <equality><joint name="shoulder" joint1="shoulder" active="false"/></equality>
</mujoco>
"""
URDF = """<robot name="arm">
  <transmission name="t"><joint name="shoulder"/></transmission>
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 .2"/><mass value="4"/>
    <inertia ixx=".06" iyy=".06" izz=".01"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/></joint>
</robot>
"""


def finding(effect, place, **values):
    """Return a finding as plain data."""
    where = 'link' if effect in ('payload', 'link_inertia', 'base_tilt') else 'joint'
    return {'effect': effect, where: place, 'values': values,
            'deviations': dict.fromkeys(values, 0.1)}


def closed(tmp_path, text, *findings):
    """Return the chains of a file before and after, its text and what was left out."""
    suffix = '.urdf' if '<robot' in text else '.xml'
    if suffix == '.xml':
        pytest.importorskip('mujoco')
    before, after = tmp_path / f'robot{suffix}', tmp_path / f'closed{suffix}'
    before.write_text(text)
    file = read_robot(before)
    made, left = closed_file(file, findings, 'test')
    if made is None:
        return file.chain, None, None, left
    after.write_text(made)
    return file.chain, read_robot(after).chain, made, left


LOAD = {'m': 2.0, 'cx': 0.1, 'cy': 0.0, 'cz': 0.3}


def test_each_effect_goes_to_its_own_place_or_is_said(tmp_path):
    for text in (MJCF, URDF):
        before, after, made, left = closed(
            tmp_path, text, finding('motor_coulomb', 'shoulder', Cc=2.0, Cc_change=0.5),
            finding('viscous_drift', 'shoulder', Cv_change=3.0, T=10.0),
            finding('payload', 'upper', **LOAD), finding('torque_offset', 'shoulder', u0=1.0),
            finding('motor_viscous', 'shoulder', Cv_change=-9.0))
        assert after.coulomb[0] - before.coulomb[0] == pytest.approx(0.5)
        np.testing.assert_allclose(after.viscous, before.viscous)
        added = inertial(2.0, np.array([0.1, 0.0, 0.3]), np.zeros((3, 3)))
        np.testing.assert_allclose(after.theta[0] - before.theta[0], added, atol=1e-7)
        np.testing.assert_allclose(after.theta[1:], before.theta[1:])
        words = '; '.join(f'{title}: {why}' for title, why in left.items())
        assert len(left) == 3
        assert 'viscous_drift of shoulder: no attribute changes with time' in words
        assert 'torque_offset of shoulder' in words and 'expected a sum of 0 or more' in words
        unchanged = [line for line in text.splitlines() if not any(
            word in line for word in ('inertia', 'shoulder', 'axis'))]
        assert len(unchanged) > 2 and all(line in made.splitlines() for line in unchanged)


def test_bodies_and_joints_without_a_name_are_found_by_their_place(tmp_path):
    before, after, made, left = closed(
        tmp_path, MJCF, finding('payload', 'body2', **LOAD),
        finding('motor_inertia', 'joint1', m1_change=0.2),
        finding('link_inertia', 'upper', Ixx=.01, Iyy=.02, Izz=.005, Ixy=0., Ixz=0., Iyz=0.))
    assert not left and made.count('<inertial') == 2
    np.testing.assert_allclose(after.armature, [0.1, 0.2])
    np.testing.assert_allclose(after.theta[1] - before.theta[1], inertial(
        2.0, np.array([0.1, 0.0, 0.3]), np.zeros((3, 3))), atol=1e-6)
    np.testing.assert_allclose((after.theta - before.theta)[0, 4:7], [.01, .02, .005], atol=1e-8)


OVERRIDDEN = [
    ('<default>', '<option><flag frictionloss="disable"/></option><default>', 'switches it off'),
    ('<default>', '<compiler inertiafromgeom="true"/><default>', 'inertiafromgeom')]


def test_what_the_file_overrides_is_said_and_the_rest_stays(tmp_path):
    for old, new, words in OVERRIDDEN:
        _, after, _, left = closed(
            tmp_path, MJCF.replace(old, new), finding('motor_coulomb', 'shoulder', Cc_change=0.5),
            finding('payload', 'upper', **LOAD),
            finding('motor_inertia', 'shoulder', m1_change=0.2))
        reason, = left.values()
        assert words in reason and after.armature[0] == pytest.approx(0.3)


def test_nothing_to_write_is_no_file(tmp_path):
    _, after, _, left = closed(tmp_path, URDF, finding('motor_inertia', 'shoulder', m1_change=.2),
                               finding('payload', 'upper', **{**LOAD, 'm': -5.0}),
                               finding('base_tilt', 'base', ax=0.01, ay=0.0))
    assert after is None and list(left) == [
        'motor_inertia of shoulder', 'payload of upper', 'base_tilt of base']


def test_a_drift_is_not_worded_as_a_change():
    words = finding_words(finding('viscous_drift', 'shoulder', Cv_change=3.0, T=10.0))
    assert words.startswith('shoulder: drift of viscous friction +3.0')
