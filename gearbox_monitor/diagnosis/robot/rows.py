# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The rows of one recording: every term of the balance, tested; and shapes a reference may need.

The shapes are friction and ripple of a joint that its file does not state.
"""
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.motion import (
    local_cosines, motion_of, RobotMotion, smooth_sign, TestFunctions)
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog, SETPOINT
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.effect import JointMotion, moved, waves
from gearbox_monitor.robot.chain import Chain, level_frame, PER_LINK

Shape: TypeAlias = Callable[[JointMotion], Array]  # -> [N, k]
HELD = 'held setpoint'  # nuisance: torque that is sampled at one end of it
DRY, VISCOUS = 'dry', 'viscous'  # friction that scales with the day, each as a whole
ORDERS, FEW, SPEEDS = 60, 6, (0.03, 0.06, 0.12, 0.25, 0.5)


def _angle(m: JointMotion, n: int) -> Array:
    return waves(n * m.q)


def _angle_direction(m: JointMotion, n: int) -> Array:
    return m.sign[:, None] * waves(n * m.q)


def _slow(m: JointMotion, vs: float) -> Array:
    return (m.sign * np.exp(-(m.v / vs) ** 2))[:, None]


def _slow_angle(m: JointMotion, vs: float) -> Array:
    return _slow(m, vs) * waves(m.q)


FIRST: Mapping[str, Shape] = MappingProxyType({   # what every joint may have
    'direction': lambda m: m.sign[:, None],
    'speed': lambda m: m.v[:, None],
    'square of speed': lambda m: (m.v * np.abs(m.v))[:, None],
    'slow 0.1': partial(_slow, vs=0.1),
    'load and direction': lambda m: (m.sign * np.abs(m.load))[:, None],
    'constant': lambda m: np.ones((len(m.t), 1)),
    'load': lambda m: m.load[:, None],
    'angle 1': partial(_angle, n=1)})


@cache
def dictionary() -> Mapping[str, Shape]:
    """Return {name: shape} of what is searched beside FIRST."""
    shapes: dict[str, Shape] = {f'angle {n}': partial(_angle, n=n) for n in range(2, ORDERS + 1)}
    for n in range(1, FEW + 1):
        shapes[f'angle {n} and direction'] = partial(_angle_direction, n=n)
    for vs in SPEEDS:
        shapes[f'slow {vs}'] = partial(_slow, vs=vs)
        shapes[f'slow {vs} and angle'] = partial(_slow_angle, vs=vs)
    shapes['load and signed direction'] = lambda m: (m.sign * m.load)[:, None]
    return MappingProxyType(shapes)


def shape_of(name: str) -> Shape:
    """Return the shape `name`, of FIRST or the dictionary."""
    return FIRST.get(name) or dictionary()[name]


def group_of(name: str) -> str:
    """Return DRY or VISCOUS of the shape `name` of friction, '' of another one."""
    if 'direction' in name or 'slow' in name:
        return DRY
    return VISCOUS if 'speed' in name else ''


@dataclass(frozen=True, eq=False)
class RobotModel:
    """
    A robot and what is known of its accuracy.

    tolerance [J]: relative, of mass, centre and inertia of each link; friction_tolerance: of
    friction and armature. learnt: friction of any shape and armature come from a reference.
    kp N m/rad, kd N m s/rad [J]: servo, where setpoints are logged; compensated: it adds the
    weight of the model. gain_tolerance: relative, of kp and kd; torque_tolerance: of the scale of
    each joint's effort. carries: links that may hold a load while the robot is learnt.
    """

    chain: Chain
    tolerance: Array
    friction_tolerance: float = SETTINGS.tolerance
    learnt: bool = False
    kp: Array | None = None
    kd: Array | None = None
    compensated: bool = False
    gain_tolerance: float = SETTINGS.gain_tolerance
    torque_tolerance: float = 0.0
    carries: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class NuisanceColumn:
    """
    A column that is no finding: rows {joint: [R]}, `deviation` of its coefficient.

    group: (joint, DRY or VISCOUS) of friction that scales as a whole with the day, None for
    others. own: each recording has a coefficient of its own. of_input: it acts on a setpoint, and
    is no torque.
    """

    label: str
    rows: Mapping[int, Array]
    deviation: float
    group: tuple[int, str] | None = None
    own: bool = False
    of_input: bool = False


@dataclass(frozen=True, eq=False)
class Rows:
    """
    One recording, tested.

    target [J, R]: effort less model. inertial {(link, joint): [R, 10]}. model [J, R]: of the file.
    joints: JointMotion of each joint. nuisance: columns. strange [S, J]: share of each segment in
    which no reference was.
    """

    name: str
    robot: RobotModel
    motion: RobotMotion
    tests: TestFunctions
    sign: Array
    target: Array
    model: Array
    inertial: Mapping[tuple[int, int], Array]
    joints: tuple[JointMotion, ...]
    nuisance: tuple[NuisanceColumn, ...]
    measured: bool = False
    setpoint: bool = False
    rate: float = 100.0
    strange: Array | None = None

    def tested(self, joint: int, series: Array, momentum: bool = False) -> Array:
        """Return the rows [R, k] of `series` [N, k] at `joint`, with `momentum` of its rate."""
        return (self.tests.of_rate if momentum else self.tests.of)(series, joint)

    @cached_property
    def tilt(self) -> Mapping[int, Array]:
        """Rows {joint: [R, 3]} of a gravity of 1 m/s^2 along the axes of level_frame."""
        chain = self.robot.chain
        series = chain.weights(self.motion.q) @ level_frame(chain.gravity).T
        return {j: self.tested(j, series[:, j]) for j in range(len(self.joints))}

    @cached_property
    def inertia(self) -> Array:
        """Matrices [S, J, J] of the inertia that each joint has of each, in mid-segment."""
        middle = self.tests.starts + self.tests.value.shape[0] // 2
        return self.robot.chain.inertia(self.motion.q[middle])

    @cached_property
    def zero(self) -> tuple[Mapping[int, Array], ...]:
        """Of each joint the rows {joint: [R, 1]} of a reading that is 1 rad (1 m) too large."""
        slopes = -self.robot.chain.weight_slopes(self.motion.q)
        size = np.abs(slopes).max(axis=0)
        return tuple({k: self.tested(k, slopes[:, k, j, None]) for k in range(len(size))
                      if size[k, j] > 1e-9} for j in range(len(size)))

    def read_off(self, joint: int, c: float) -> Mapping[int, Array]:
        """Return the rows {joint: [R, 1]} per rad of readings of a `joint` that are `c` larger."""
        chain, q = self.robot.chain, self.motion.q.copy()
        q[:, joint] -= c
        change = dict[int, Array]()
        for r in chain.regressors(q, self.motion.v, links=chain.moved_by(joint)):
            theta = chain.links[r.link].theta[:, None]
            rows = self.tested(r.joint, r.p @ theta, True) + self.tested(
                r.joint, (r.g - r.k) @ theta)
            change[r.joint] = change.get(r.joint, 0.0) + (
                rows - self.inertial[r.link, r.joint] @ theta) / c
        return change


def rows_of(log: RobotLog, robot: RobotModel, shapes: Sequence[tuple[int, str]] = (),
            mean: Mapping[str, float] | None = None) -> Rows:
    """
    Return the Rows of a recording.

    Args:
        log: the recording.
        robot: its model.
        shapes: (joint, name) of shapes that a reference needed.
        mean: {label: coefficient} that a reference taught, for the torque of the model.
    """
    motion, setpoint = motion_of(log), log.kind == SETPOINT
    highest = min(SETTINGS.highest_servo if setpoint else SETTINGS.highest,
                  SETTINGS.highest_share * log.rate)
    rows = tested(motion, local_cosines(motion, highest), robot, shapes, mean,
                  setpoint=setpoint, measured=log.measured)
    return replace(rows, name=log.name, rate=log.rate)


def tested(motion: RobotMotion, tests: TestFunctions, robot: RobotModel,
           shapes: Sequence[tuple[int, str]] = (), mean: Mapping[str, float] | None = None, *,
           setpoint: bool = False, measured: bool = False) -> Rows:
    """
    Return the Rows of a motion.

    Args:
        motion: of the robot.
        tests: functions that every term is multiplied by.
        robot: its model.
        shapes: (joint, name) of shapes that a reference needed.
        mean: {label: coefficient} that a reference taught, for the torque of the model.
        setpoint: whether the input of the motion is a setpoint.
        measured: whether it is a torque behind the drive.
    """
    chain = robot.chain
    count, n = len(chain.links), len(motion.t)
    inertial: dict[tuple[int, int], Array] = {}
    load, weight, momentum, taught_load, taught_momentum = (np.zeros((n, count)) for _ in range(5))
    taught = _bodies(robot, mean)
    for r in chain.regressors(motion.q, motion.v):
        inertial[r.link, r.joint] = tests.of_rate(r.p, r.joint) + tests.of(r.g - r.k, r.joint)
        theta = chain.links[r.link].theta
        load[:, r.joint] += (r.g - r.k) @ theta
        weight[:, r.joint] += r.g @ theta
        momentum[:, r.joint] += r.p @ theta
        taught_load[:, r.joint] += (r.g - r.k) @ taught[r.link]
        taught_momentum[:, r.joint] += r.p @ taught[r.link]
    # A series of accelerations: for shapes over the load and small shifts in time only.
    load += _rate(motion, momentum)
    taught_load += _rate(motion, taught_momentum)    # what a reference taught of the bodies
    sign = smooth_sign(motion.v, motion.sigma_v)
    # Friction that is learnt is learnt whole: on another day all of it scales.
    coulomb, viscous = ((np.zeros(count),) * 2 if robot.learnt else
                        (chain.coulomb, chain.viscous))
    passive = viscous * motion.v + chain.spring * (motion.q - chain.spring_zero)
    model = np.empty((count, tests.rows))
    for j in range(count):
        model[j] = sum(inertial[k, j] @ chain.links[k].theta for k in chain.moved_by(j))
        model[j] += tests.of_rate(chain.armature[j] * motion.v[:, j, None], j)[:, 0]
        series = passive[:, j, None] + coulomb[j] * sign[:, j, None]
        model[j] += tests.of(series, j)[:, 0]
    kp, kd = (np.zeros(count) if x is None else x for x in (robot.kp, robot.kd))
    error = motion.input - motion.q
    added = weight if setpoint and robot.compensated else np.zeros_like(weight)
    effort = kp * error - kd * motion.v + added if setpoint else motion.input
    target = np.stack([tests.of(effort[:, j, None], j)[:, 0] for j in range(count)]) - model
    steady = _steady(motion, effort)
    acceleration = _rate(motion, motion.v)
    friction = passive + chain.armature * acceleration + coulomb * sign
    none = np.zeros(n)
    joints = [JointMotion(
        motion.t, motion.q[:, j], motion.v[:, j], sign[:, j], load[:, j],
        load[:, j] + friction[:, j] + taught_load[:, j], steady[:, j], error[:, j],
        motion.input_speed[:, j], added[:, j], kp[j], kd[j],
        float(np.std(effort[:, j] - steady[:, j])) if not setpoint else
        float(kp[j] * motion.sigma_q[j]), coulomb[j], viscous[j], chain.armature[j],
        robot.learnt, none, none, none, effort[:, j],
        load[:, j] + taught_load[:, j]) for j in range(count)]
    if robot.learnt and mean:
        joints = [_taught(m, name, shapes, mean, j, acceleration[:, j])
                  for j, (m, name) in enumerate(zip(joints, chain.joints))]
    rows = Rows('', robot, motion, tests, sign, target, model, inertial, tuple(joints), (),
                measured=measured, setpoint=setpoint)
    return replace(rows, nuisance=tuple(nuisance_of(rows, shapes)))


def _rate(motion: RobotMotion, x: Array) -> Array:
    """Return dx/dt of `x` [N, K], section by section."""
    out = np.empty_like(x)
    for section in motion.sections:
        t = motion.t[section]
        out[section] = scipy.interpolate.CubicSpline(t, x[section])(t, 1)
    return out


def _steady(motion: RobotMotion, effort: Array) -> Array:
    """Return the effort [N, J] without what is faster than any test function."""
    rate = 1.0 / motion.step
    filter_ = scipy.signal.butter(3, min(SETTINGS.highest, 0.4 * rate), fs=rate, output='sos')
    return np.concatenate([scipy.signal.sosfiltfilt(filter_, effort[s], axis=0)
                           for s in motion.sections])


def _bodies(robot: RobotModel, mean: Mapping[str, float] | None) -> Array:
    """Return what a reference taught of the inertial parameters [J, 10] of the links."""
    return np.array([[(mean or {}).get(f'{link.name} {p}', 0.0) for p in range(PER_LINK)]
                     for link in robot.chain.links])


def _shaped(m: JointMotion, shapes: Sequence[tuple[int, str]], joint: int
            ) -> Iterator[tuple[str, int, Array]]:
    """Yield (shape, number, column [N]) of the shapes that friction of a joint may have."""
    for shape in (*FIRST, *(name for j, name in shapes if j == joint)):
        for k, column in enumerate(shape_of(shape)(m).T):
            yield shape, k, column


def _taught(m: JointMotion, name: str, shapes: Sequence[tuple[int, str]],
            mean: Mapping[str, float], joint: int, acceleration: Array) -> JointMotion:
    """Return `m` with the torque that a reference taught of the joint."""
    rotor = mean.get(f'armature {name}', 0.0) * acceleration
    model = m.model + rotor
    groups = {DRY: np.zeros_like(model), VISCOUS: np.zeros_like(model), '': np.zeros_like(model)}
    for shape, k, x in _shaped(m, shapes, joint):
        groups[group_of(shape)] += mean.get(f'{name}: {shape} {k}', 0.0) * x
    taught = np.sum(list(groups.values()), axis=0)
    return replace(m, model=model + taught, taught=taught, dry=groups[DRY], wet=groups[VISCOUS])


def nuisance_of(rows: Rows, shapes: Sequence[tuple[int, str]]) -> list[NuisanceColumn]:
    """Return what may be off in `rows`: bodies, armature, friction, time, shapes of friction."""
    robot, chain, s = rows.robot, rows.robot.chain, SETTINGS
    columns: list[NuisanceColumn] = []
    for i, link in enumerate(chain.links):
        length = link.reach + 0.03
        for p in range(PER_LINK) if link.mass > 0.0 else ():
            size = robot.tolerance[i] * link.mass * (1.0, length, length ** 2)[(p > 0) + (p > 3)]
            columns.append(NuisanceColumn(
                f'{link.name} {p}', {j: rows.inertial[i, j][:, p] for j in chain.movers[i]}, size))
    reach = (1.0,) + (s.farthest,) * 3 + (s.farthest ** 2,) * 6
    columns += [NuisanceColumn(f'load {chain.links[k].name} {p}', {
        j: rows.inertial[k, j][:, p] for j in chain.movers[k]}, s.heaviest * size, own=True)
        for k in robot.carries for p, size in enumerate(reach)]
    delays = {}
    for j, name in enumerate(chain.joints):
        m, torque = rows.joints[j], float(np.std(rows.joints[j].effort)) + 1e-9

        def add(label: str, x: Array, deviation: float, group: str = '', rate: bool = False,
                j: int = j, of_input: bool = False) -> None:
            columns.append(NuisanceColumn(label, {j: rows.tested(j, x[:, None], rate)[:, 0]},
                                          deviation, (j, group) if group else None,
                                          of_input=of_input))
        spread = s.armature_learnt * torque / 20.0 if robot.learnt else 0.0
        add(f'armature {name}', m.v, robot.friction_tolerance * m.armature + spread + 1e-9,
            rate=True)
        # The command itself acts late; the model's torque lacks a load that the file lacks.
        acting = m.model if rows.setpoint or rows.measured else m.raw
        delays[j] = rows.tested(j, moved(m.t, acting, 0.0))[:, 0]
        columns.append(NuisanceColumn(f'lag {name}', {j: delays[j]}, s.lag_joint))
        slow = m.sign * np.exp(-(m.v / s.creep) ** 2)
        if not robot.learnt:
            add(f'viscous {name}', m.v, robot.friction_tolerance * m.viscous + 1e-9, VISCOUS)
            add(f'coulomb {name}', m.sign, robot.friction_tolerance * m.coulomb + 1e-9, DRY)
            add(f'creep {name}', slow, m.coulomb + 1e-9, DRY)
        else:
            add(f'creep {name}', slow, s.learnt * torque, DRY)
            for shape, k, x in _shaped(m, shapes, j):
                size = np.std(x) + 1e-3 * np.abs(x).max() + 1e-12
                add(f'{name}: {shape} {k}', x, s.learnt * torque / size, group_of(shape))
        if rows.setpoint:
            gain = robot.gain_tolerance
            # The column of the effect itself: two that differ by rounding would explain noise.
            assert SERVO_GAIN.column is not None
            add(f'kp {name}', SERVO_GAIN.column.series(m, 0.0)[:, 0], gain, of_input=True)
            add(f'kd {name}', m.kd * m.v, gain, of_input=True)
            add(f'setpoint lag {name}', m.kp * m.setpoint_speed,
                max(0.25 * rows.motion.step, 0.003), of_input=True)
    if robot.kp is not None:
        columns += _held(rows, robot.kp, np.zeros(len(robot.kp)) if robot.kd is None else robot.kd)
    columns.append(NuisanceColumn('lag', delays, max(s.lag, 0.25 * rows.motion.step), own=True))
    return columns


def _held(rows: Rows, kp: Array, kd: Array) -> list[NuisanceColumn]:
    """
    Return the errors of samples at an end of a period T for which servos hold a setpoint r.

    Setpoints are up to T late. Torques are +-(kp q' + kd q'') T / 2 off their mean, at all servos
    alike, and by T / 2 of the rate of that. The steps kp r' T swing the robot about its mean
    motion by the acceleration M^-1 kp r': speeds are T^2 / 12 of it off, positions behind servos
    of few steps a period up to T^3 / 24 of it.

    Args:
        rows: of torques or setpoints.
        kp: N m/rad [J], 0 where a joint has no servo.
        kd: N m s/rad [J].
    """
    motion, period = rows.motion, rows.motion.step
    if rows.setpoint:
        slope = step = kp * motion.input_speed
    else:
        slope = kp * motion.v + kd * np.gradient(motion.v, period, axis=0)
        step = slope + motion.input_speed
    swing = np.einsum('njk,nk->nj', np.linalg.pinv(rows.robot.chain.inertia(motion.q)), step)
    own, rate, speed, position = columns = [dict[int, Array]() for _ in range(4)]
    for j in np.flatnonzero(kp > 0.0).tolist():
        own[j], swung = rows.tested(j, np.column_stack([slope[:, j], swing[:, j]])).T
        rate[j] = rows.tested(j, slope[:, j, None], True)[:, 0]
        speed[j], position[j] = kd[j] * swung, kp[j] * swung
    sizes = {': lag' if rows.setpoint else '': period, ': rate': 0.5 * period ** 2,
             ': speed': period ** 2 / 12.0, ': position': period ** 3 / 24.0}
    return [NuisanceColumn(HELD + name, column, size, own=True, of_input=True)
            for (name, size), column in zip(sizes.items(), columns)
            if not (rows.setpoint and name == ': speed')]
