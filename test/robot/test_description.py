# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a URDF becomes, and how a bad one is refused."""
import json

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path, load_robot
from gearbox_monitor.plain_data import classes_of, from_data, to_data
from gearbox_monitor.robot.description import parse, RobotDescription
from gearbox_monitor.robot.dynamics import arrays_of, move, Payload, torque_on

INERTIAL = ('<inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
            '<inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>')
JOINT = ('<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>'
         '<axis xyz="0 1 0"/>{4}</joint>')


def urdf(*joints, links='base a b', inertial='a b'):
    """Return a URDF of `joints` (name, type, parent, child, more) with `links`."""
    parts = [f'<link name="{name}">{INERTIAL if name in inertial.split() else ""}</link>'
             for name in links.split()]
    return f'<robot name="r">{"".join(parts)}{"".join(JOINT.format(*j) for j in joints)}</robot>'


ONE = ('one', 'revolute', 'base', 'a', '')
TWO = ('two', 'continuous', 'a', 'b', '')


def test_fixed_joints_only_place_what_hangs_on_them():
    robot = parse(urdf(ONE, ('mount', 'fixed', 'a', 'b', '')), 'r')
    assert robot.joints == ('one',) and list(robot.mass) == [2.0, 2.0]
    arrays = arrays_of(robot, gravity=(0.0, 0.0, -10.0))
    move(arrays, np.zeros((3, 1)))
    torque, _, inertia = torque_on(arrays, 0)
    assert torque == pytest.approx(-2 * 2.0 * 0.5 * 10.0)  # about +y the weight turns downwards
    assert inertia == pytest.approx(2 * (0.1 + 2.0 * 0.5 ** 2))


def test_a_mimic_joint_loads_the_joint_that_it_follows():
    """Both turn about one point by q and by q - 2 q: the second link hangs at -q."""
    mimic = '<mimic joint="one" multiplier="-2" offset="0.1"/>'
    robot = parse(urdf(ONE, ('two', 'revolute', 'a', 'b', mimic)), 'r')
    assert robot.joints == ('one',)
    arrays, q = arrays_of(robot, gravity=(0.0, 0.0, -10.0)), 0.3
    move(arrays, np.array([[q], [0.0], [0.0]]))
    # By virtual work; angles about +y lower the tip.
    power = -2.0 * 10.0 * 0.5 * (np.cos(q) - np.cos(0.1 - q))
    assert torque_on(arrays, 0)[0] == pytest.approx(power)
    assert torque_on(arrays, 0)[2] == pytest.approx(2 * (0.1 + 2.0 * 0.25))


def test_a_description_survives_its_text():
    robot = load_robot(str(config_path('arm6.urdf')))
    again = from_data(json.loads(json.dumps(to_data(robot))), classes_of(RobotDescription))
    for name, value in vars(robot).items():
        if name != 'links':
            np.testing.assert_array_equal(getattr(again, name), value)
    assert list(again.links) == list(robot.links)


BAD = [
    ('<robot', 'expected a URDF robot description'),
    ('<sdf/>', '<sdf>, expected <robot>'),
    (urdf(ONE, ('two', 'floating', 'a', 'b', '')), "joint two: type 'floating', expected one of"),
    (urdf(ONE, ('two', 'revolute', 'x', 'b', '')), "joint two: parent: 'x', expected"),
    (urdf(ONE), 'links: 2 links without a parent, expected a tree'),
    (urdf(ONE, TWO, ('three', 'fixed', 'base', 'b', '')), 'child b hangs on joint two, too'),
    (urdf(ONE, TWO, inertial='a'), 'joint two: moves no mass, expected an <inertial>'),
    (urdf(ONE, ('two', 'revolute', 'a', 'b', '<mimic joint="five"/>')),
     "joint two: mimic: 'five', expected one of one"),
    (urdf(ONE, TWO).replace('ixx="0.1"', 'ixx="-1"'), 'link a: inertial: mass 2 kg, smallest'),
    (urdf(ONE, TWO).replace('value="2"', 'value="two"'), "mass: value: 'two'"[6:]),
    (urdf(ONE, TWO).replace('0 1 0', '0 0 0'), 'joint one: axis: 0 0 0, expected a direction')]


def test_a_bad_description_is_refused_by_name():
    for text, said in BAD:
        with pytest.raises(InputError, match='r.urdf: ') as error:
            parse(text, 'r.urdf')
        assert said in str(error.value) and '\n' not in str(error.value)


def test_a_payload_needs_a_link_that_moves():
    with pytest.raises(InputError, match="payload_link: 'base', expected"):
        arrays_of(parse(urdf(ONE, TWO), 'r'), Payload(link='base'))
