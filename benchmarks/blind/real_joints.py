# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Joints of real robots as nominal MJCF files of one rigid joint with one encoder.

JOINTS lists attributes that the robots' files in MuJoCo Menagerie have, and the inertia and the
weight that the joint carries there at the first keyframe. Servos record their setpoint, motors
their torque. Whatever is drawn is in the values of mujoco_drives; `scale` says by what an effect
of such a joint is measured.
"""
from collections.abc import Mapping
import math
from typing import Any, NamedTuple

import numpy as np

from benchmarks.blind.draw import log_uniform
from benchmarks.blind.mjcf_parts import actuator_attributes, outside_of
from gearbox_monitor.kernels.types import Array

G = 9.81
RAMP = 0.5  # s, over which the motion begins
Values = Mapping[str, Any]


class RealJoint(NamedTuple):
    """
    Attributes of a joint and its actuator.

    inertia kg m^2 and weight N m: of what it carries; armature kg m^2, damping N m s/rad, friction
    N m, gear, kp N m/rad (0: a motor), kd N m s/rad, force N m (0: no limit), control: range, rad
    or N m before the gear; timestep s.
    """

    robot: str
    joint: str
    inertia: float
    weight: float
    armature: float
    damping: float
    friction: float
    gear: float
    kp: float
    kd: float
    force: float
    control: tuple[float, float]
    timestep: float
    integrator: str


JOINTS = tuple(RealJoint(*row) for row in (
    ('cassie', 'hip roll', 1.084, 22.52, .038125, 1, 0, 25, 0, 0, 0, (-4.5, 4.5), 5e-4, 'Euler'),
    ('cassie', 'hip pitch', .798, 14.88, .09344, 1, 0, 16, 0, 0, 0, (-12.2, 12.2), 5e-4, 'Euler'),
    ('cassie', 'foot', 4.491e-4, .04098, .01225, 1, 0, 50, 0, 0, 0, (-.9, .9), 5e-4, 'Euler'),
    ('go2', 'thigh', .0211, .862, .01, 2, .2, 1, 0, 0, 0, (-23.7, 23.7), 2e-3, 'Euler'),
    ('go2', 'calf', .00633, .335, .01, 2, .2, 1, 0, 0, 0, (-45.43, 45.43), 2e-3, 'Euler'),
    ('anymal b', 'HAA', .1999, 5.705, 0, 1, .1, 1, 100, 0, 40, (-6.28, 6.28), 2e-3, 'Euler'),
    ('anymal c', 'HAA', .3684, 10.77, 0, 1, .1, 1, 100, 0, 80, (-6.28, 6.28), 2e-3, 'Euler'),
    ('panda', '2', 2.695, 46.97, .1, 1, 0, 1, 4500, 450, 87, (-1.7628, 1.7628), 2e-3,
     'implicitfast'),
    ('panda', '4', .9581, 22.38, .1, 1, 0, 1, 3500, 350, 87, (-3.0718, -.0698), 2e-3,
     'implicitfast'),
    ('panda', '6', .05403, 2.868, .1, 1, 0, 1, 2000, 200, 12, (-.0175, 3.7525), 2e-3,
     'implicitfast'),
    ('iiwa 14', '1', 2.646, 0, 0, 0, 0, 1, 2000, 200, 0, (-2.96706, 2.96706), 2e-3,
     'implicitfast'),
    ('iiwa 14', '2', 3.106, 61.34, 0, 0, 0, 1, 2000, 200, 0, (-2.0944, 2.0944), 2e-3,
     'implicitfast'),
    ('sawyer', 'j1', .9557, 22.62, 1, .1, .3, 1, 800, 80, 80, (-3.8095, 2.2736), 2e-3,
     'implicit'),
    ('sawyer', 'j3', .452, 11.49, 1, .1, .3, 1, 800, 80, 40, (-3.0439, 3.0439), 2e-3,
     'implicit'),
    ('sawyer', 'j5', .00796, .7087, 1, .1, .1, 1, 500, 50, 9, (-2.9761, 2.9761), 2e-3,
     'implicit'),
    ('op3', 'head pan', 6.986e-5, 0, .045, 1.084, .03, 1, 21.1, 0, 5, (-3.141592, 3.141592),
     2e-3, 'Euler'),
    ('shadow hand', 'WRJ2', .01171, 0, 2e-4, .5, .01, 1, 10, 0, 10, (-.523599, .174533), 2e-3,
     'Euler'),
    ('shadow hand', 'WRJ1', .006346, .5289, 2e-4, .5, .01, 1, 8, 0, 5, (-.698132, .488692), 2e-3,
     'Euler'),
    ('shadow hand', 'FFJ3', 1.746e-4, .02681, 2e-4, .05, .01, 1, 1, 0, 1, (-.261799, 1.5708),
     2e-3, 'Euler'),
    ('shadow hand', 'THJ4', 2.236e-4, .03402, 2e-4, .05, .01, 1, 1, 0, 2, (0, 1.22173), 2e-3,
     'Euler'),
    ('a1', 'hip', .02039, 1.009, .01, 1, .2, 1, 100, 0, 33.5, (-.802851, .802851), 2e-3, 'Euler'),
    ('a1', 'thigh', .01916, .6856, .01, 2, .2, 1, 100, 0, 33.5, (-1.0472, 4.18879), 2e-3,
     'Euler'),
    ('go1', 'thigh', .01709, .6834, .01, 2, .2, 1, 100, 0, 23.7, (-.686, 4.501), 2e-3, 'Euler'),
    ('go1', 'calf', .005688, .281, .01, 2, .2, 1, 100, 0, 35.55, (-2.818, 0), 2e-3, 'Euler'),
    ('ur5e', 'shoulder lift', 2.039, 40.98, .1, 0, 0, 1, 2000, 400, 150, (-6.2831, 6.2831), 2e-3,
     'implicitfast'),
    ('ur5e', 'elbow', .653, 15.86, .1, 0, 0, 1, 2000, 400, 150, (-3.1415, 3.1415), 2e-3,
     'implicitfast'),
    ('ur5e', 'wrist 1', .02042, 1.389, .1, 0, 0, 1, 500, 100, 28, (-6.2831, 6.2831), 2e-3,
     'implicitfast'),
    ('allegro hand', 'ffj1', 3.135e-4, .03635, 0, .1, 0, 1, 1, 0, 0, (-.196, 1.61), 2e-3,
     'Euler'),
    ('allegro hand', 'thj0', 5.839e-4, .05536, 0, .1, 0, 1, 1, 0, 0, (.263, 1.396), 2e-3,
     'Euler')))

# id of the library -> (value that it changes, range of its size, relative: see changed()).
BOTH = {'motor_inertia': ('m1', (0.05, 1.0)), 'motor_viscous': ('Cv', (0.02, 0.6)),
        'motor_coulomb': ('Cc', (0.02, 0.6)), 'gravity': ('G', (0.05, 1.0))}
OF_MOTORS = {'torque_gain': ('gain', (0.02, 0.4)), 'saturation': ('limit', (0.1, 0.6)),
             'actuator_lag': ('lag', (0.002, 0.03)), 'actuator_delay': ('delay', (0.002, 0.018))}
OF_SERVOS = {'servo_gain': ('kp', (0.05, 0.8)), 'servo_limit': ('limit', (0.1, 0.6)),
             'setpoint_lag': ('lag', (0.002, 0.06)), 'setpoint_delay': ('delay', (0.002, 0.06))}
INSIDE = {**BOTH, **OF_MOTORS, **OF_SERVOS}


def nominal(random: np.random.Generator, kind: str = '') -> dict[str, Any]:
    """
    Return the values of a joint that `random` picks.

    Args:
        random: source of random numbers.
        kind: id of an effect that the joint must be able to have, '' for none.
    """
    joints = [j for j in JOINTS if not (kind in OF_MOTORS and j.kp or kind in OF_SERVOS
                                        and not j.kp)]
    j = joints[random.integers(len(joints))]
    return {'robot': j.robot, 'joint': j.joint, 'm1': j.armature, 'm2': j.inertia,
            'Cv': j.damping, 'Cc': j.friction, 'G': j.weight,
            'phi': float(f'{random.uniform(-3.1, 3.1):.4g}') if j.weight else 0.0,
            'gear': j.gear, 'gain': 1.0, 'kp': j.kp, 'kd': j.kd, 'limit': j.force or math.inf,
            'control': list(j.control), 'lag': 0.0, 'delay': 0.0, 'timestep': j.timestep,
            'integrator': j.integrator, 'outside': None}


def names_of(v: Values) -> dict[str, tuple[str, tuple[float, float]]]:
    """Return the effects that a joint with the values `v` can have, as INSIDE."""
    return {**BOTH, **(OF_SERVOS if v['kp'] else OF_MOTORS)}


def inputs(v: Values, random: np.random.Generator, t: Array) -> Array:
    """
    Return inputs [N]: setpoints, rad, or torques on the joint, N m.

    Args:
        v: values of the joint.
        random: source of random numbers.
        t: times [N], s.
    """
    low, high = v['control']
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    if v['kp']:
        reach, fastest = random.uniform(0.2, 0.8) * min(half, 1.5), 1.5
    else:
        middle, reach, fastest = 0.0, random.uniform(0.1, 0.5) * half * v['gear'], 4.0
    rates = [log_uniform(random, 0.2, fastest) for _ in range(random.integers(2, 5))]
    parts = random.uniform(0.4, 1.0, len(rates))
    u: Array = np.round(middle + np.minimum(t / RAMP, 1.0) * reach / parts.sum() * sum(
        a * np.sin(2.0 * np.pi * f * t + random.uniform(-3.0, 3.0))
        for a, f in zip(parts, rates)), 6)
    return u


def efforts(v: Values, u: Array, q: Array, w: Array) -> Array:
    """
    Return the torques [N] of the actuator on the joint, N m.

    Args:
        v: values of the joint.
        u: inputs [N], rad or N m.
        q: angles [N], rad.
        w: speeds [N], rad/s.
    """
    torque: Array = v['kp'] * (u - q) - v['kd'] * w if v['kp'] else u
    return np.clip(torque, -v['limit'], v['limit'])


def scaled(v: Values, u: Array, q: Array, w: Array) -> dict[str, float]:
    """
    Return {value: unit of the size of its effect} of a motion.

    Args:
        v: values of the joint.
        u: inputs [N], rad or N m.
        q: angles [N], rad.
        w: speeds [N], rad/s.
    """
    torque = float(np.sqrt(np.mean(efforts(v, u, q, w) ** 2)))
    return {'m1': v['m1'] + v['m2'], 'Cc': torque, 'Cv': torque / max(float(w.std()), 1e-9),
            'G': torque}


def changed(v: Values, key: str, size: float, sign: float, peak: float) -> dict[str, Any]:
    """
    Return values with an effect.

    Args:
        v: values of the joint, with `scale`.
        key: the value that changes.
        size: relative; s of a lag and a delay.
        sign: -1 or 1.
        peak: of the effort on the joint, N m.
    """
    if key == 'limit':
        value = (1.0 - size) * peak
    elif key in ('lag', 'delay'):
        value = v[key] + size
    elif key in v['scale']:
        value = max(v[key] + size * (sign if v[key] else 1.0) * v['scale'][key], 0.0)
    else:
        value = v[key] * ((1.0 + size) if sign > 0.0 else 1.0 / (1.0 + size))
    return {**v, key: float(f'{value:.6g}')}


def xml_of(v: Values) -> str:
    """Return the MJCF file of a joint with the values `v`."""
    moment = v['G'] / G
    mass = 2.0 * moment ** 2 / v['m2'] if moment else v['m2']
    centre = moment / mass
    own = v['m2'] - mass * centre ** 2
    ahead, below = centre * math.sin(v['phi']), centre * math.cos(v['phi'])
    name, size = v['outside'] or ('', 0.0)
    weight = size * v['m2'] / 0.04 if name == 'payload' else size
    outside = outside_of(name, weight, 1e-5, 1e-3 * weight)
    low, high = v['control']
    actuator = [f'ctrllimited="true" ctrlrange="{low:.9g} {high:.9g}"', f'gear="{v["gear"]:.9g}"']
    if v['kp']:
        actuator.append(f'gainprm="{v["kp"]:.9g}" biastype="affine" '
                        f'biasprm="0 {-v["kp"]:.9g} {-v["kd"]:.9g}"')
    else:
        actuator.append(f'gainprm="{v["gain"]:.9g}"')
    actuator.append(actuator_attributes(v['lag'], v['delay'], v['limit'] / v['gear'],
                                        v['timestep']))
    return f"""<mujoco model="joint">
  <compiler angle="radian"/>
  <option timestep="{v['timestep']}" integrator="{v['integrator']}"/>
  <worldbody>
    {outside.world}
    <body name="link">
      <joint name="joint" axis="0 1 0" armature="{v['m1']:.9g}" damping="{v['Cv']:.9g}"
             frictionloss="{v['Cc']:.9g}"{outside.joint}/>
      <inertial pos="{-ahead:.9g} 0 {-below:.9g}" mass="{mass:.9g}"
                diaginertia="{own:.9g} {own:.9g} {own:.9g}"/>
      {outside.body}
    </body>
  </worldbody>
  <actuator>
    <general name="drive" joint="joint" {' '.join(actuator)}/>
  </actuator>
</mujoco>
"""
