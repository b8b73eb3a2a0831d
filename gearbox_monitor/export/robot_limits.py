# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of a robot's joints as its file states them, and whether a path collides in MuJoCo."""
from collections.abc import Callable
import math
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gearbox_monitor.balance.robot_experiment import RobotLimits
from gearbox_monitor.export.mjcf_file import read_file
from gearbox_monitor.export.robot_model import ChainFile
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.compiled_model import (
    actuator_law, actuators_on, disabled, mujoco_module, name_of, Unread)
from gearbox_monitor.robot.description import finite_number

CHECKED = 25.0  # Hz, of postures that are tested for contacts


def limits_in(file: ChainFile) -> RobotLimits:
    """Return the RobotLimits in the `file` of a robot; infinite where it states none."""
    return _of_urdf(file) if file.compiled is None else _of_compiled(file.compiled)


def _of_urdf(file: ChainFile) -> RobotLimits:
    joints = {joint.get('name', ''): joint for joint in ElementTree.fromstring(
        read_file(file.path).decode('utf-8', 'replace')).findall('joint')}
    rows = []
    for name in file.chain.joints:
        limit, turns = joints[name].find('limit'), joints[name].get('type') == 'continuous'

        def stated(key: str, usual: float, name: str = name, limit: Any = limit) -> float:
            text = None if limit is None else limit.get(key)
            return usual if text is None else finite_number(
                text, f'{file.path}: joint {name}: limit: {key}')
        rows.append((-math.inf if turns else stated('lower', -math.inf),
                     math.inf if turns else stated('upper', math.inf),
                     stated('velocity', math.inf), stated('effort', math.inf)))
    return RobotLimits(*np.array(rows).T)


def _of_compiled(m: Any) -> RobotLimits:
    limited = m.jnt_limited.astype(bool)
    torque = np.full(m.njnt, math.inf)
    for j in range(m.njnt):
        if m.jnt_actfrclimited[j]:
            torque[j] = np.abs(m.jnt_actfrcrange[j]).min()
        try:
            laws = [actuator_law(m, i) for i in actuators_on(m, j)]
        except Unread:
            continue
        most = [min(-law.force[0], law.force[1], *(() if law.setpoint else (
            abs(law.gear * law.gain) * x for x in (-law.control[0], law.control[1]))))
            for law in laws]
        torque[j] = min(torque[j], sum(most) if most else math.inf)
    low, high = m.jnt_range.T
    return RobotLimits(np.where(limited, low, -math.inf), np.where(limited, high, math.inf),
                       np.full(m.njnt, math.inf), torque)


def contacts_in(file: ChainFile, rate: float) -> tuple[Callable[[Array], bool], str]:
    """
    Return whether a path [N, J] collides, by MuJoCo, and a note of what is not tested.

    Pairs of shapes that touch where all joints are at 0 of the file stand for neighbours.

    Args:
        file: of the robot.
        rate: of the path, Hz.
    """
    m = file.compiled
    if m is None:
        return lambda q: False, ('contacts are not tested: a URDF is read without its shapes, '
                                 'expected an MJCF')
    if disabled(m, 'CONTACT') or disabled(m, 'CONSTRAINT'):
        return lambda q: False, 'contacts are not tested: the file switches them off'
    if not np.any((m.geom_contype != 0) | (m.geom_conaffinity != 0)):
        return lambda q: False, 'contacts are not tested: the file has no shapes that collide'
    mujoco = mujoco_module()
    state, step = mujoco.MjData(m), max(1, round(rate / CHECKED))

    def touching(q: Array) -> set[tuple[int, int]]:
        state.qpos[:] = q
        mujoco.mj_kinematics(m, state)
        mujoco.mj_comPos(m, state)
        mujoco.mj_collision(m, state)
        return {(int(c.geom1), int(c.geom2)) for c in state.contact[:state.ncon]
                if c.dist < 0.0}
    always = touching(m.qpos0)
    words = ', '.join(f'{name_of(m, "geom", a)} and {name_of(m, "geom", b)}'
                      for a, b in sorted(always))
    return (lambda q: any(touching(x) - always for x in q[::step]),
            f'touching in the file as well, so allowed: {words}' if words else '')
