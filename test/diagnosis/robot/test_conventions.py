# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Conventions of a robot's log: named by weight and inertia, never in place of an effect."""
from dataclasses import replace
import json
import math
from pathlib import Path

import numpy as np
import pytest
import random_robots

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.robot.conventions import (
    least_explained, log_as_read, named_readings, RobotReading)
from gearbox_monitor.diagnosis.robot.robot_log import checked_log, continuous, RawLog, read_by
from gearbox_monitor.diagnosis.robot.rows import RobotModel
from gearbox_monitor.errors import InputError
from gearbox_monitor.robot.chain import Chain, inertial, Link
from gearbox_monitor.signals.recording import Convention, conventions_of
from gearbox_monitor.simulators.robot_model import chain_of_compiled

JOINTS = ('base', 'shoulder', 'elbow')


def arm():
    """Return a chain: about the vertical, then two about the horizontal."""
    rows = [('base', -1, (0, 0, 0.2), (0, 0, 1), 5.0),
            ('shoulder', 0, (0, 0, 0.1), (0, 1, 0), 4.0),
            ('elbow', 1, (0.4, 0.03, 0), (0, 1, 0), 2.0)]
    links = tuple(Link(name, name, parent, np.eye(3), np.array(at, float), np.array(axis, float),
                       False, inertial(mass, np.array([0.18, 0.01, 0.02]),
                                       mass * np.diag([0.002, 0.01, 0.011])))
                  for name, parent, at, axis, mass in rows)
    return Chain(links, np.full(3, 0.05), np.array([2.0, 2.0, 1.0]), np.array([3.0, 3.0, 1.5]),
                 np.array([0.0, 0.0, -9.81]))


def raw(payload=0.0, seed=0, seconds=15.0):
    """Return the columns of a healthy arm, or of one that carries a payload (kg)."""
    rng, chain, t = np.random.default_rng(seed), arm(), np.arange(0.0, seconds, 0.01)
    f, phase = rng.uniform(0.1, 0.6, (3, 3, 1)), rng.uniform(0.0, 2.0 * math.pi, (3, 3, 1))
    wave, turn = 2.0 * math.pi * f, 2.0 * math.pi * f * t + phase
    q = (0.4 * np.sin(turn).sum(axis=1) + [[0.1], [0.3], [-0.5]]).T
    v = (0.4 * wave * np.cos(turn)).sum(axis=1).T
    theta = chain.theta + 0.0
    theta[2] += inertial(payload, np.array([0.3, 0.0, 0.05]), np.zeros((3, 3)))
    p, load = np.zeros_like(q), np.zeros_like(q)
    for r in chain.regressors(q, v):
        p[:, r.joint] += r.p @ theta[r.link]
        load[:, r.joint] += (r.g - r.k) @ theta[r.link]
    p += chain.armature * v
    u = np.gradient(p, t, axis=0) + load + chain.viscous * v + chain.coulomb * np.tanh(v / 0.01)
    q, u = q + rng.normal(0.0, 1e-4, q.shape), u + rng.normal(0.0, 0.05, u.shape)
    return RawLog('log', t, dict(zip(JOINTS, q.T)), dict(zip(JOINTS, u.T)), 'torque')


def named(columns, settled=(), limits=None):
    chain = arm()
    robot = RobotModel(chain, np.full(3, 0.05), 0.05)
    return named_readings(checked_log(continuous(columns), JOINTS), robot, limits, settled)


def test_no_convention_stands_for_a_payload():
    for payload in (0.0, 0.5, 3.0):
        assert named(raw(payload)) == []


NAMED = [
    (2, 'reversed'), (1, 'effort:-1'), (1, 'effort:0.1'), (1, 'zero:1.571'),
    (2, 'deg'), (1, 'reversed,effort:-1'), (1, 'zero:0.37')]


def expect_named(payload, joint, rules):
    convention = conventions_of([f'{JOINTS[joint]}={rules}'], JOINTS)[JOINTS[joint]]
    columns = raw(payload)
    name = JOINTS[joint]
    columns.position[name][:] = (convention.sign * columns.position[name]
                                 + convention.zero) / convention.unit
    columns.input[name][:] = columns.input[name] / (convention.sign * convention.effort)
    (found,) = named(columns)
    ((number, reading),) = found.reading.joints.items()
    assert number == joint and reading.unit == convention.unit
    assert reading.sign == convention.sign and reading.effort == pytest.approx(
        convention.effort, rel=0.15)
    assert reading.zero == pytest.approx(convention.zero, abs=0.1)
    assert named(columns, settled=[0, 1, 2]) == []
    stated = conventions_of([f'{name}={reading.rules}'], JOINTS)
    assert named(read_by(columns, stated)) == []


def test_a_convention_is_named_with_the_option_that_undoes_it():
    """A driver that counts otherwise: the reading is the inverse of what it did."""
    for k, (joint, rules) in enumerate(NAMED):
        expect_named(float(k % 2), joint, rules)


def test_two_efforts_of_another_sign_are_named_where_one_alone_explains_less():
    """An arm of seven joints was in order: with one sign right, the other joint was worse."""
    columns = raw(1.0)
    for joint in ('shoulder', 'elbow'):
        columns.input[joint] *= -1.0
    assert sorted((*n.reading.joints, c.effort) for n in named(columns)
                  for c in n.reading.joints.values()) == [(1, -1.0), (2, -1.0)]


def test_a_log_that_no_reading_explains_is_doubted():
    """Where none was named, the log of another robot was in order."""
    columns, robot = raw(), RobotModel(arm(), np.full(3, 0.05), 0.05)
    assert least_explained(checked_log(continuous(columns), JOINTS), robot) is None
    columns.input['elbow'][:] = 20.0 * np.sin(3.0 * columns.t)
    log = checked_log(continuous(columns), JOINTS)
    joint, left = least_explained(log, robot)
    assert named_readings(log, robot) == [] and joint == 2 and left > 0.5


def test_exchanged_joints_are_named():
    columns = raw()
    for values in (columns.position, columns.input):
        values['shoulder'], values['elbow'] = values['elbow'], values['shoulder']
    (found,) = named(columns)
    assert found.reading.swapped == (1, 2)
    # A slide and a hinge have no positions to exchange: a torso in motor units was a wrist.
    links = (*arm().links[:2], replace(arm().links[2], slides=True))
    robot = RobotModel(replace(arm(), links=links), np.full(3, 0.05), 0.05)
    assert not any(n.reading.swapped and 2 in n.reading.swapped for n in named_readings(
        checked_log(continuous(columns), JOINTS), robot))


def test_a_slide_exchanged_with_a_hinge_is_no_other_unit():
    """The exchange explains the log best, and an effort 68 times as large passed for it."""
    case = random_robots.make(181028, False)
    chain = chain_of_compiled(random_robots.mujoco.MjModel.from_xml_string(case.xml),
                              Path('robot.xml'))
    robot = RobotModel(chain, np.full(len(chain.links), 0.05), 0.05)
    log = random_robots.log(case, 1, 20.0)[0]
    assert [link.slides for link in chain.links] == [False, False, True]
    for pair, readings in (((1, 2), []), ((0, 1), [(0, 1)])):
        misread = log_as_read(log, [RobotReading(swapped=pair)])
        assert [n.reading.swapped for n in named_readings(misread, robot)] == readings


def test_conventions_are_stated_in_words():
    stated = conventions_of(['elbow=deg,reversed,zero:0.5', 'all=effort:-1'], JOINTS)
    assert stated['elbow'] == Convention(True, 0.5, math.pi / 180.0, -1.0)
    assert stated['base'] == Convention(effort=-1.0)
    assert stated['elbow'].position(np.array([90.0])) == pytest.approx(0.5 - math.pi / 2.0)
    assert conventions_of([f'base={stated["elbow"].rules}'], JOINTS)['base'].unit == (
        stated['elbow'].unit)
    for word in ('elbow', 'hand=reversed', 'elbow=backwards', 'elbow=zero:x', 'elbow=effort:0'):
        with pytest.raises(InputError, match='--convention'):
            conventions_of([word], JOINTS)


URDF = """<robot name="arm"><link name="ground"/>{}</robot>"""
LINK = """
<link name="{name}"><inertial><origin xyz="0.18 0.01 0.02"/><mass value="{mass}"/>
<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/><dynamics damping="{damping}" friction="{friction}"/>
<limit lower="-3" upper="3" effort="100" velocity="5"/></joint>"""


def test_commands_read_a_robot_as_it_is_named_and_learn_refuses_it(tmp_path, capsys):
    """One joint counted backwards: no load of tons, the option that settles it, exit code 1."""
    parents = ('ground', 'base', 'shoulder')
    text = URDF.format(''.join(LINK.format(
        name=link.name, mass=link.mass, xx=link.mass * 0.002, yy=link.mass * 0.01,
        zz=link.mass * 0.011, parent=parent, at=' '.join(map(str, link.origin)),
        axis=' '.join(map(str, link.axis)), damping=damping, friction=friction)
        for link, parent, damping, friction in zip(arm().links, parents, (3.0, 3.0, 1.5),
                                                   (2.0, 2.0, 1.0))))
    text = text.replace('effort="100"', 'effort="0"', 1)
    (tmp_path / 'arm.urdf').write_text(text)
    columns = raw(1.0, seconds=20.0)
    table = np.column_stack([columns.t, *(x for j in JOINTS for x in (
        columns.position[j], columns.input[j]))])
    table[:, 5:7] *= -1.0
    np.savetxt(tmp_path / 'log.csv', table, '%.6g', ',', comments='', header='t,' + ','.join(
        f'q_{j},tau_{j}' for j in JOINTS))
    words = [str(tmp_path / 'log.csv'), '--model', str(tmp_path / 'arm.urdf')]
    assert main(['check', *words]) == 1
    said, doubt = ' '.join(capsys.readouterr().out.split()), 'effort limit 0: state what the drive'
    assert '--convention elbow=reversed' in said and doubt in said
    assert 'zero not checked - base: a zero that is 0.2 rad off might stay unseen' in said
    assert main(['learn', *words, '--out', str(tmp_path / 'a.knowledge')]) == 2
    assert '--convention elbow=reversed' in capsys.readouterr().err
    assert main(['diagnose', *words, '--json', '-']) == 1
    misread = json.loads(capsys.readouterr().out)
    assert 'elbow counts the other way' in misread['readings'][0]
    assert doubt in misread['warnings'][0]
    assert main(['diagnose', *words, '--convention', 'elbow=reversed', '--json', '-']) == 1
    stated = json.loads(capsys.readouterr().out)
    assert stated['readings'] == [] and stated['findings'] == misread['findings']
    table[:, 5:7] *= -1.0
    table[:, 6] = 20.0 * np.sin(3.0 * columns.t)
    np.savetxt(tmp_path / 'log.csv', table, '%.6g', ',', comments='', header='t,' + ','.join(
        f'q_{j},tau_{j}' for j in JOINTS))
    assert main(['check', *words]) == 0
    said = ' '.join(capsys.readouterr().out.split())
    assert 'with care: note (log), reading (conventions).' in said
    assert 'reading warn elbow: weight and inertia of the model leave ' in said
    payload = stated['findings'][0]
    assert payload['effect'] == 'payload' and payload['values']['m'] == pytest.approx(1.0, abs=0.2)
