# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The balance of momentum of a chain, against Newton-Euler kernels and MuJoCo."""
from pathlib import Path

import numpy as np
import pytest
from random_robots import make

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.robot.chain import body_of, chain_of, inertial
from gearbox_monitor.robot.description import parse
from gearbox_monitor.robot.dynamics import arrays_of, move, torque_on
from gearbox_monitor.simulators.mjcf_file import read_mjcf
from gearbox_monitor.simulators.robot_model import chain_of_compiled, read_robot

mujoco = pytest.importorskip('mujoco')


def effort(chain, q, v, a, h=1e-5):
    """Return d/dt p - k + g [J] by a central difference of p."""
    def parts(q, v):
        out = np.zeros((3, len(chain.links)))
        for r in chain.regressors(q[None], v[None]):
            for row, x in enumerate((r.p, r.k, r.g)):
                out[row, r.joint] += x[0] @ chain.theta[r.link]
        return out
    curve = 0.5 * h * h * a
    after, before = parts(q + h * v + curve, v + h * a), parts(q - h * v + curve, v - h * a)
    _, k, g = parts(q, v)
    return (after[0] - before[0]) / (2.0 * h) - k + g


def test_balance_is_that_of_mujoco():
    """Arms, legs, SCARA and torso: the effort without friction equals inverse dynamics."""
    for seed in range(3):
        m = mujoco.MjModel.from_xml_string(make(seed).xml)
        m.dof_damping[:], m.dof_frictionloss[:], m.dof_armature[:] = 0, 0, 0
        chain, d = chain_of_compiled(m, Path('robot.xml')), mujoco.MjData(m)
        d.qpos[:], d.qvel[:], d.qacc[:] = np.random.default_rng(seed).normal(size=(3, m.nv))
        mujoco.mj_inverse(m, d)
        np.testing.assert_allclose(effort(chain, d.qpos, d.qvel, d.qacc), d.qfrc_inverse,
                                   rtol=1e-6, atol=1e-7)


def test_slopes_of_weights_are_those_of_a_difference():
    for seed in range(3):
        compiled = mujoco.MjModel.from_xml_string(make(seed).xml)
        chain = chain_of_compiled(compiled, Path('robot.xml'))
        q, h, rest = np.random.default_rng(seed).normal(size=len(chain.links)), 1e-5, np.zeros(
            len(chain.links))
        for j, step in enumerate(h * np.eye(len(q))):
            slope = (effort(chain, q + step, rest, rest) - effort(chain, q - step, rest, rest)) / (
                2.0 * h)
            np.testing.assert_allclose(chain.weight_slopes(q[None])[0, :, j], slope, atol=1e-7)


def test_urdf_balance_is_that_of_the_newton_euler_kernels():
    text = config_path('arm6.urdf').read_text(encoding='utf-8')
    description = parse(text, 'arm6.urdf')
    chain = chain_of(description)
    motion = np.random.default_rng(1).normal(size=(3, len(chain.links)))
    arrays = arrays_of(description)
    move(arrays, motion)
    kernels = [torque_on(arrays, j)[0] for j in range(len(chain.links))]
    np.testing.assert_allclose(effort(chain, *motion), kernels, rtol=1e-6, atol=1e-7)


def test_theta_and_body_are_inverse():
    theta = inertial(2.0, np.array([0.1, -0.2, 0.3]), np.diag([0.1, 0.2, 0.25]))
    mass, centre, tensor = body_of(theta)
    np.testing.assert_allclose(inertial(mass, centre, tensor), theta)


SPRUNG = """<mujoco><option gravity="0 0 -9.81"><flag {flag}="disable"/></option><worldbody>
  <body name="a"><inertial pos="0 .1 .2" mass="2" diaginertia=".1 .2 .3"/>
    <joint name="j" axis="0 1 0" armature=".1" damping=".5" stiffness="3" springref=".4"/>
    <body name="b" pos="0 0 .5"><inertial pos="0 .1 .2" mass="1" diaginertia=".1 .1 .1"/>
      <joint name="k" axis="1 0 0" damping=".2"/></body></body></worldbody>
  <actuator><general joint="j" gear="3" armature=".02" damping=".07" group="1"/>
    <motor joint="k" gear="2" armature=".01"/></actuator></mujoco>"""


FLAGS = ['clampctrl', 'gravity', 'spring', 'damper', 'actuation']


def test_option_flags_and_losses_of_actuators_are_those_of_mujoco():
    for flag in FLAGS:
        m = mujoco.MjModel.from_xml_string(SPRUNG.format(flag=flag))
        chain, d = chain_of_compiled(m, Path('robot.xml')), mujoco.MjData(m)
        d.qpos[:], d.qvel[:], d.qacc[:] = np.random.default_rng(1).normal(size=(3, m.nv))
        mujoco.mj_inverse(m, d)
        passive = (chain.armature * d.qacc + chain.viscous * d.qvel
                   + chain.spring * (d.qpos - chain.spring_zero))
        np.testing.assert_allclose(effort(chain, d.qpos, d.qvel, d.qacc) + passive, d.qfrc_inverse,
                                   rtol=1e-6, atol=1e-7)


ROBOT = ('<mujoco><worldbody><body name="a"><joint name="j" {joint}/><geom size=".1"/>'
         '<body name="b"><joint name="k"/><geom size=".1"/><site name="s"/></body></body>'
         '</worldbody>{more}</mujoco>')


CLOSED = [
    ('type="free"', '', 'joint j: free or ball'),
    ('', '<equality><joint name="gears" joint1="j" joint2="k"/></equality>', 'gears'),
    ('', '<tendon><fixed name="cable" stiffness="5"><joint joint="j" coef="1"/></fixed></tendon>',
     'cable'),
    ('', '<option density="1.2"/>', 'joint j, k: density: 1.2 in option'),
    ('damping=".1 .2"', '', 'joint j: damping: 0.2 0 of higher order, expected one number'),
    ('', '<actuator><motor name="jet" site="s"/></actuator>', 'j, k: actuator jet: acts on a site')
]


def test_closed_and_coupled_chains_are_refused_by_name(tmp_path):
    for joint, more, words in CLOSED:
        path = tmp_path / 'robot.xml'
        path.write_text(ROBOT.format(joint=joint, more=more))
        with pytest.raises(InputError, match=words):
            read_robot(path)


ACTUATORS = [
    ('<position joint="j" kp="9" kv="1"/><position joint="k" kp="5"/>', ''),
    ('<position joint="j" kp="9"/>', 'joint k: no actuator, expected a position'),
    ('<position joint="j" kp="9"/><motor name="push" joint="k"/>', 'joint k: actuator push'),
    ('<position name="slow" joint="j" kp="9" timeconst=".01"/><intvelocity name="far" joint="k" '
     'kp="2" actrange="-1 1"/>', 'actuator far: dyntype')]


def test_what_setpoints_need_is_said(tmp_path):
    for actuators, words in ACTUATORS:
        path = tmp_path / 'robot.xml'
        path.write_text(ROBOT.format(joint='', more=f'<actuator>{actuators}</actuator>'))
        file = read_robot(path)
        assert words in file.no_servo and bool(words) == (file.kp is None)


def test_mimic_joints_are_refused_by_name():
    link = ('<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>'
            '</inertial></link>')
    joint = ('<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>{3}'
             '</joint>')
    text = '<robot name="r">' + ''.join(link.format(x) for x in 'abc') + joint.format(
        'first', 'a', 'b', '') + joint.format(
            'second', 'b', 'c', '<mimic joint="first"/>') + '</robot>'
    with pytest.raises(InputError, match='joint second: <mimic joint="first" .*locked in --val'):
        parse(text, 'hand.urdf', whole=True)


def test_a_joint_that_moves_no_mass_spoils_itself_alone(tmp_path):
    """A whole arm was refused for a tool without <inertial>."""
    text = config_path('arm6.urdf').read_text(encoding='utf-8')
    empty = ('<link name="{0}"/><joint name="{0}_joint" type="revolute"><parent link="{1}"/>'
             '<child link="{0}"/></joint>')
    path = tmp_path / 'arm.urdf'
    path.write_text(text.replace('</robot>', empty.format('tip', 'flange')
                                 + empty.format('claw', 'tip') + '</robot>'))
    arm, whole = read_robot(path), read_robot(config_path('arm6.urdf'))
    assert arm.unread == ('tip_joint', 'claw_joint') and not whole.unread
    assert arm.chain.joints == whole.chain.joints
    np.testing.assert_array_equal(arm.chain.theta, whole.chain.theta)
    path.write_text('<robot name="r"><link name="a"/><link name="b"/>' + empty.format('c', 'b')
                    + '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
                    '</robot>')
    with pytest.raises(InputError, match='joint c_joint: moves no mass'):
        read_robot(path)


HAND = """<mujoco><worldbody><body name="a" euler="20 30 0"><freejoint/><geom size=".1"/>
  <body name="b" pos="0 0 .2"><joint name="j" axis="0 1 0"/><geom size=".1"/>
    <body name="c" pos=".1 0 .2" euler="10 0 0">
      <joint name="hinge" axis="1 0 0" pos=".1 0 .1" ref="5"/><geom size=".1 .2" type="capsule"/>
      <body name="d" pos="0 0 .2"><joint name="k" axis="1 1 0"/><geom size=".1" pos="0 .1 0"/>
        <body name="e" pos="0 .1 .2"><joint name="slide" type="slide" axis="0 1 1"/>
          <geom size=".1" pos=".1 0 0"/></body></body></body></body></body></worldbody>
  <equality><joint joint1="hinge" joint2="slide"/><weld body1="a" body2="world"/></equality>
  <tendon><fixed name="cable"><joint joint="slide" coef="1"/></fixed></tendon>
  <actuator><position tendon="cable"/><position name="of k" joint="k" kp="9"/>
    <motor joint="hinge"/><position name="of j" joint="j" kp="5"/></actuator>
  <sensor><tendonpos tendon="cable"/></sensor>{more}</mujoco>"""


MORE = [
    '', '<asset><texture name="t" type="2d" builtin="flat" width="2" height="2"/></asset>']


def test_locked_joints_weigh_as_in_mujoco_and_move_no_more(tmp_path):
    """Also where a process of its own compiles the file, as one with a texture."""
    for more in MORE:
        path = tmp_path / 'hand.xml'
        path.write_text(HAND.format(more=more))
        m = mujoco.MjModel.from_xml_path(str(path))
        m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        d, locked, rng = mujoco.MjData(m), {'hinge': 0.4, 'a': 0.0, 'slide': -0.05}, (
            np.random.default_rng(1))
        for name in ('hinge', 'slide'):
            d.joint(name).qpos[0] = locked[name]
        moving = np.array([m.joint(name).dofadr[0] for name in 'jk'])
        d.qpos[moving + 1], d.qvel[moving], d.qacc[moving] = rng.normal(size=(3, 2))
        mujoco.mj_inverse(m, d)
        file = read_robot(path, locked=locked)
        assert file.chain.joints == ('j', 'k') and file.kp.tolist() == [5.0, 9.0]
        np.testing.assert_allclose(effort(file.chain, *(x[moving] for x in (
            d.qpos[1:], d.qvel, d.qacc))), d.qfrc_inverse[moving], rtol=1e-6, atol=1e-6)
        if not more:
            other = read_robot(path, locked=locked | {'slide': 0.0})
            assert file.digest != other.digest
        for fewer, words in (
                ({}, 'joint a: free or ball.*locked in --values'),
                ({'a': 0.0}, 'equality 1: .*couples hinge, slide, .*locked in --values'),
                ({'a': 0.0, 'hinge': 0.0}, 'tendon cable: .*couples slide, .*locked in'),
                ({'knee': 0.0}, 'locked: knee: no joint, expected one of a, j, hinge'))[
                    3 * bool(more):]:
            with pytest.raises(InputError, match=words):
                read_robot(path, locked=fewer)


def test_locked_joints_in_a_urdf_weigh_as_before_and_move_no_more():
    """A hinge, and a slide with one that mimics it."""
    text = config_path('arm6.urdf').read_text(encoding='utf-8').replace('</robot>', (
        '<link name="{0}"><inertial><origin xyz="0 0.1 0"/><mass value="1"/><inertia ixx=".1" '
        'iyy=".1" izz=".2"/></inertial></link><joint name="{1}" type="prismatic"><parent '
        'link="{2}"/><child link="{0}"/><axis xyz="1 1 0"/>{3}</joint>').format(
            'finger', 'grip', 'flange', '') + (
        '<link name="{0}"><inertial><origin xyz="0 0.1 0"/><mass value="1"/><inertia ixx=".1" '
        'iyy=".1" izz=".2"/></inertial></link><joint name="{1}" type="prismatic"><parent '
        'link="{2}"/><child link="{0}"/><axis xyz="1 1 0"/>{3}</joint>').format(
            'thumb', 'follows', 'flange', '{}') + '</robot>')
    both = text.format('')
    whole = chain_of(parse(both, 'arm'))
    names = whole.joints
    locked = {names[2]: 0.7, 'grip': 0.03}
    fewer = chain_of(parse(text.format(
        '<mimic joint="grip" multiplier="-2" offset="0.1"/>'), 'arm', locked))
    moving = [i for i, name in enumerate(names) if name in fewer.joints]
    assert len(moving) == len(names) - 3
    motion = np.zeros((3, len(names)))
    motion[:, moving] = np.random.default_rng(1).normal(size=(3, len(moving)))
    for name, position in {**locked, 'follows': 0.1 - 2.0 * 0.03}.items():
        motion[0, names.index(name)] = position
    np.testing.assert_allclose(effort(fewer, *motion[:, moving]), effort(whole, *motion)[moving],
                               rtol=1e-6, atol=1e-6)
    with pytest.raises(InputError, match="arm: locked: 'gripp', did you mean 'grip'"):
        parse(both, 'arm', {'gripp': 0.0})


BAD_NUMBERS = [
    ('joint j: dynamics: damping', 'damping=""'), ('joint j: dynamics: friction', 'friction="x"'),
    ('joint j: dynamics: damping', 'damping="inf"')]


def test_numbers_of_a_urdf_are_read_or_refused_with_their_place(tmp_path):
    for where, text in BAD_NUMBERS:
        path = tmp_path / 'arm.urdf'
        path.write_text(
            '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia '
            'ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="revolute">'
            f'<parent link="a"/><child link="b"/><dynamics {text}/></joint></robot>')
        value = text.partition('=')[2].strip('"')
        for read in (read_robot, lambda path: read_mjcf(path, 'j')):
            with pytest.raises(InputError) as error:
                read(path)
            assert str(error.value) == f'{path}: {where}: {value!r}, expected a number'
