# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Newton-Euler dynamics of a tree of joints and bodies, in coordinates of the base.

The torque of a joint is the sum over bodies of Jv' F + Jw' N: force and moment that move the body,
with the Jacobians of its centre of mass. So each body's share is at hand, and with it what an
error of its mass or inertia makes of the torque.
"""
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import Array, Cube, Integers, Matrix, Triple, Vector
from gearbox_monitor.robot.description import RobotDescription

GRAVITY = (0.0, 0.0, -9.80665)
# Of a joint's frame: rotation, origin, axis, angular velocity and acceleration, acceleration.
ORIGIN, AXIS, OMEGA, ALPHA, ACCELERATION, N_FRAME = 9, 12, 15, 18, 21, 24
# Of a body: centre of mass, force, moment, inertia about the base's axes.
CENTRE, FORCE, MOMENT, TENSOR, N_BODY = 0, 3, 6, 9, 18


class RobotArrays(NamedTuple):
    """
    A description as kernels take it; the last body is the payload, of mass 1 kg.

    Arrays as of RobotDescription. amounts [B]: how much of each body there is: 1, or the payload's
    mass. deviations [B]: standard deviation of the amounts. gravity [3]: m/s^2. frames [N,
    N_FRAME], bodies [B, N_BODY]: scratch.
    """

    parent: Integers
    source: Integers
    ratio: Vector
    offset: Vector
    prismatic: Vector
    rotation: Cube
    origin: Matrix
    axis: Matrix
    body_joint: Integers
    mass: Vector
    com: Matrix
    inertia: Cube
    amounts: Vector
    deviations: Vector
    gravity: Vector
    frames: Matrix
    bodies: Matrix


class Payload(NamedTuple):
    """A point of `mass` +- `tolerance` kg at `position` [3] (m) in the frame of `link`."""

    mass: float = 0.0
    tolerance: float = 0.0
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    link: str = ''


NO_PAYLOAD = Payload()


def arrays_of(robot: RobotDescription, payload: Payload = NO_PAYLOAD, tolerance: float = 0.0,
              gravity: tuple[float, ...] = GRAVITY) -> RobotArrays:
    """
    Return what kernels take of a `robot` with a `payload`.

    Args:
        robot: its description.
        payload: at which link, '' for the last one that moves; how heavy.
        tolerance: how far mass and inertia of each link may be off, either way, relative.
        gravity: [3] in the frame of the base, m/s^2.

    Returns:
        The arrays.

    Raises:
        InputError: the payload's link does not exist or does not move.

    """
    moving = [name for name, (joint, _, _) in robot.links.items() if joint >= 0]
    link = payload.link or moving[-1]
    if link not in moving:
        raise InputError(f'payload_link: {link!r}, {unknown(link, moving)}')
    joint, rotation, origin = robot.links[link]
    com = rotation @ np.array(payload.position) + origin
    count, uniform = len(robot.mass), 1.0 / math.sqrt(3.0)
    return RobotArrays(
        robot.parent, robot.source, robot.ratio, robot.offset, robot.prismatic.astype(float),
        robot.rotation, robot.origin, robot.axis, np.append(robot.body_joint, joint),
        np.append(robot.mass, 1.0), np.vstack([robot.com, com]),
        np.concatenate([robot.inertia, np.zeros((1, 3, 3))]),
        np.append(np.ones(count), payload.mass),
        uniform * np.append(np.full(count, tolerance), payload.tolerance),
        np.array(gravity, float), np.zeros((len(robot.parent), N_FRAME)),
        np.zeros((count + 1, N_BODY)))


@inline
def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inline
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline
def _at(row: Array, i: int) -> Triple:
    return row[i], row[i + 1], row[i + 2]


@inline
def _put(row: Array, i: int, a: Triple) -> None:
    row[i], row[i + 1], row[i + 2] = a


@inline
def _turned(frame: Array, a: Triple) -> Triple:
    """Return the vector `a` of the frame in coordinates of the base."""
    return (frame[0] * a[0] + frame[1] * a[1] + frame[2] * a[2],
            frame[3] * a[0] + frame[4] * a[1] + frame[5] * a[2],
            frame[6] * a[0] + frame[7] * a[1] + frame[8] * a[2])


@inline
def _times(tensor: Array, a: Triple) -> Triple:
    return _turned(tensor[TENSOR:], a)


@entry
def move(robot: RobotArrays, motion: Matrix) -> None:
    """
    Place the frames and bodies of a robot, with the forces that its motion takes.

    Args:
        robot: its frames and bodies are written.
        motion: position, speed and acceleration of each joint [>= 3, n], rad, s.

    """
    frames = robot.frames
    for i in range(frames.shape[0]):
        frame, j = frames[i], robot.source[i]
        q = robot.ratio[i] * motion[0, j] + robot.offset[i]
        v, a = robot.ratio[i] * motion[1, j], robot.ratio[i] * motion[2, j]
        axis = (robot.axis[i, 0], robot.axis[i, 1], robot.axis[i, 2])
        slides = robot.prismatic[i] > 0.0
        _place_frame(robot, i, axis, 0.0 if slides else q)
        parent = robot.parent[i]
        at = (robot.origin[i, 0], robot.origin[i, 1], robot.origin[i, 2])
        omega = alpha = (0.0, 0.0, 0.0)
        base = (0.0, 0.0, 0.0)
        acceleration = (-robot.gravity[0], -robot.gravity[1], -robot.gravity[2])
        if parent >= 0:
            parent_frame = frames[parent]
            at, base = _turned(parent_frame, at), _at(parent_frame, ORIGIN)
            omega, alpha = _at(parent_frame, OMEGA), _at(parent_frame, ALPHA)
            acceleration = _at(parent_frame, ACCELERATION)
        s = _turned(frame, axis)
        if slides:
            at = (at[0] + s[0] * q, at[1] + s[1] * q, at[2] + s[2] * q)
        inner, outer = _cross(alpha, at), _cross(omega, _cross(omega, at))
        acceleration = (acceleration[0] + inner[0] + outer[0],
                        acceleration[1] + inner[1] + outer[1],
                        acceleration[2] + inner[2] + outer[2])
        swing = _cross(omega, s)
        if slides:
            acceleration = (acceleration[0] + a * s[0] + 2.0 * v * swing[0],
                            acceleration[1] + a * s[1] + 2.0 * v * swing[1],
                            acceleration[2] + a * s[2] + 2.0 * v * swing[2])
        else:
            alpha = (alpha[0] + a * s[0] + v * swing[0], alpha[1] + a * s[1] + v * swing[1],
                     alpha[2] + a * s[2] + v * swing[2])
            omega = (omega[0] + v * s[0], omega[1] + v * s[1], omega[2] + v * s[2])
        _put(frame, ORIGIN, (base[0] + at[0], base[1] + at[1], base[2] + at[2]))
        _put(frame, AXIS, s)
        _put(frame, OMEGA, omega)
        _put(frame, ALPHA, alpha)
        _put(frame, ACCELERATION, acceleration)
    for b in range(robot.bodies.shape[0]):
        _move_body(robot, b)


@inline
def _place_frame(robot: RobotArrays, i: int, axis: Triple, angle: float) -> None:
    """Write the rotation of joint `i`, turned by `angle` (rad) about its `axis`."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = axis
    k = 1.0 - c
    about = (c + x * x * k, x * y * k - z * s, x * z * k + y * s,
             y * x * k + z * s, c + y * y * k, y * z * k - x * s,
             z * x * k - y * s, z * y * k + x * s, c + z * z * k)
    frame, parent = robot.frames[i], robot.parent[i]
    for row in range(3):
        mount = (robot.rotation[i, row, 0], robot.rotation[i, row, 1], robot.rotation[i, row, 2])
        for column in range(3):
            frame[3 * row + column] = (mount[0] * about[column] + mount[1] * about[3 + column]
                                       + mount[2] * about[6 + column])
    if parent >= 0:
        for column in range(3):
            a = _turned(robot.frames[parent],
                        (frame[column], frame[3 + column], frame[6 + column]))
            frame[column], frame[3 + column], frame[6 + column] = a


@inline
def _move_body(robot: RobotArrays, b: int) -> None:
    """Write centre, force, moment and inertia of body `b`."""
    body, frame = robot.bodies[b], robot.frames[robot.body_joint[b]]
    r = _turned(frame, (robot.com[b, 0], robot.com[b, 1], robot.com[b, 2]))
    for column in range(3):  # R I, then (R I) R'
        a = _turned(frame, (robot.inertia[b, 0, column], robot.inertia[b, 1, column],
                            robot.inertia[b, 2, column]))
        body[TENSOR + column], body[TENSOR + 3 + column], body[TENSOR + 6 + column] = a
    for row in range(3):
        at = TENSOR + 3 * row
        _put(body, at, _turned(frame, _at(body, at)))
    omega, alpha = _at(frame, OMEGA), _at(frame, ALPHA)
    inner, outer = _cross(alpha, r), _cross(omega, _cross(omega, r))
    spin, turning = _cross(omega, _times(body, omega)), _times(body, alpha)
    origin, mass = _at(frame, ORIGIN), robot.mass[b]
    for k in range(3):
        body[CENTRE + k] = origin[k] + r[k]
        body[FORCE + k] = mass * (frame[ACCELERATION + k] + inner[k] + outer[k])
        body[MOMENT + k] = turning[k] + spin[k]


@inline
def _jacobians(robot: RobotArrays, b: int, joint: int) -> tuple[Triple, Triple]:
    """Return how centre and orientation of body `b` answer to `joint` of RobotDescription."""
    body, i = robot.bodies[b], robot.body_joint[b]
    linear = angular = (0.0, 0.0, 0.0)
    while i >= 0:
        if robot.source[i] == joint:
            frame, k = robot.frames[i], robot.ratio[i]
            s = _at(frame, AXIS)
            if robot.prismatic[i] > 0.0:
                linear = (linear[0] + k * s[0], linear[1] + k * s[1], linear[2] + k * s[2])
            else:
                arm = _cross(s, (body[CENTRE] - frame[ORIGIN], body[CENTRE + 1]
                                 - frame[ORIGIN + 1], body[CENTRE + 2] - frame[ORIGIN + 2]))
                linear = (linear[0] + k * arm[0], linear[1] + k * arm[1], linear[2] + k * arm[2])
                angular = (angular[0] + k * s[0], angular[1] + k * s[1], angular[2] + k * s[2])
        i = robot.parent[i]
    return linear, angular


@entry
def torque_on(robot: RobotArrays, joint: int, acceleration: float = 0.0) -> Triple:
    """
    Return the torque that a joint needs for the motion of `move`.

    Args:
        robot: moved.
        joint: number in RobotDescription.joints.
        acceleration: of the joint beyond that of `move`, rad/s^2; the variance counts it.

    Returns:
        Torque (N m), its variance by the deviations of the bodies, and the inertia (kg m^2) that
        the joint moves.

    """
    torque = variance = inertia = 0.0
    for b in range(robot.bodies.shape[0]):
        body = robot.bodies[b]
        linear, angular = _jacobians(robot, b, joint)
        by_mass, by_inertia = _dot(linear, _at(body, FORCE)), _dot(angular, _at(body, MOMENT))
        of_mass, of_inertia = (robot.mass[b] * _dot(linear, linear),
                               _dot(angular, _times(body, angular)))
        amount, deviation = robot.amounts[b], robot.deviations[b]
        torque += amount * (by_mass + by_inertia)
        inertia += amount * (of_mass + of_inertia)
        by_mass, by_inertia = (by_mass + acceleration * of_mass,
                               by_inertia + acceleration * of_inertia)
        variance += deviation * deviation * (by_mass * by_mass + by_inertia * by_inertia)
    return torque, variance, inertia


@entry
def coupled_inertia(robot: RobotArrays, i: int, j: int) -> float:
    """Return the element (`i`, `j`) of the inertia matrix of a `robot` that was moved, kg m^2."""
    total = 0.0
    for b in range(robot.bodies.shape[0]):
        linear, angular = _jacobians(robot, b, i)
        of_linear, of_angular = _jacobians(robot, b, j)
        total += robot.amounts[b] * (robot.mass[b] * _dot(linear, of_linear)
                                     + _dot(angular, _times(robot.bodies[b], of_angular)))
    return total


LOAD, DEVIATION, INERTIA, NOISE, N_LOAD = range(5)
SMOOTHED, UNSEEN = 3, 4
LAG = 3.0  # of the acceleration, in times of the filter
SETTLED = 10.0  # times of the filter until its accelerations count
LONGEST = 0.25  # s without a position over which it extrapolates


class MotionState(NamedTuple):
    """
    What is carried from sample to sample.

    joints [5, n]: position, speed, acceleration, acceleration smoothed over its lag, and the s
    since a measured position; clock int64 [2]: stamp of the last sample and time since the start,
    ns. acting [3, n]: scratch.
    """

    joints: Matrix
    clock: Integers
    acting: Matrix


def motion_at_start(n: int) -> MotionState:
    """Return the MotionState of `n` joints before the first sample."""
    return MotionState(np.zeros((5, n)), np.zeros(2, np.int64), np.zeros((3, n)))


@kernel
def _follow(motion: MotionState, stamp: int, positions: Array, time: float) -> bool:
    """Take the `positions` [n] (rad) at `stamp` (ns); return whether the sample is a next one."""
    joints, clock = motion.joints, motion.clock
    elapsed = stamp - clock[0]
    dt = elapsed * 1e-9
    if clock[0] > 0 and -LONGEST < dt <= 0.0:
        return False  # late, or once more
    if clock[0] == 0 or dt < 0.0 or dt > LONGEST:
        for i in range(positions.shape[0]):
            joints[0, i], joints[1, i], joints[2, i] = positions[i], 0.0, 0.0
            joints[SMOOTHED, i] = 0.0
            joints[UNSEEN, i] = 0.0 if math.isfinite(positions[i]) else math.inf
        clock[0], clock[1] = stamp, 0
        return False
    clock[0] = stamp
    clock[1] += elapsed
    fading, late = math.exp(-dt / time), 1.0 - math.exp(-dt / (LAG * time))
    fresh = 1.0 - fading
    gain1 = 1.0 - fading * fading * fading
    gain2 = 1.5 * (fresh * fresh) * (1.0 + fading) / dt
    gain3 = fresh * fresh * fresh / (dt * dt)
    for i in range(positions.shape[0]):
        q, v, a = joints[0, i], joints[1, i], joints[2, i]
        q, v = q + dt * (v + 0.5 * dt * a), v + dt * a
        error = positions[i] - q
        if math.isfinite(positions[i]) and not joints[UNSEEN, i] <= LONGEST:
            q, v, a, error = positions[i], 0.0, 0.0, 0.0
            clock[1] = 0
        if math.isfinite(error):
            joints[0, i], joints[1, i] = q + gain1 * error, v + gain2 * error
            joints[2, i], joints[UNSEEN, i] = a + gain3 * error, 0.0
        else:
            joints[0, i], joints[1, i] = q, v
            joints[UNSEEN, i] += dt
        joints[SMOOTHED, i] += late * (joints[2, i] - joints[SMOOTHED, i])
    return True


@entry
def write_loads(robot: RobotArrays, motion: MotionState, joint: int, time: float, stamps: Integers,
                positions: Matrix, out: Matrix, weight: Vector) -> None:
    """
    Write load, its errors and the inertia of a joint for N samples.

    The load is what the joint's own acceleration does not take: weight, friction-free coupling
    with the other joints, centrifugal and Coriolis torque. The deviation is by masses and inertias
    of the description that are off, in the torque for the joint's own acceleration, too. What the
    accelerations of the others lag behind, as in an impact, changes as fast as they do: the noise.

    Args:
        robot: with the payload.
        motion: changed in place.
        joint: number in RobotDescription.joints.
        time: of the filter for speeds and accelerations, s.
        stamps: [N], ns.
        positions: of all joints [N, n], rad; NaN = not measured.
        out: [N, N_LOAD]: load and its deviation, N m; inertia, kg m^2; spectral density of the
            noise in the rate of the load, (N m)^2/s. NaN where the motion is not known (well
            enough).
        weight: [N], the load at rest, N m, NaN likewise; [0]: it is not wanted.

    """
    joints, clock, acting = motion
    for k in range(stamps.shape[0]):
        good = _follow(motion, stamps[k], positions[k], time)
        good = good and clock[1] * 1e-9 > SETTLED * time
        for i in range(joints.shape[1]):
            good = good and joints[UNSEEN, i] <= LONGEST
        if not good:
            out[k, :] = math.nan
            if weight.shape[0] > 0:
                weight[k] = math.nan
            continue
        if weight.shape[0] > 0:
            for i in range(joints.shape[1]):
                acting[0, i], acting[1, i], acting[2, i] = joints[0, i], 0.0, 0.0
            move(robot, acting)
            weight[k] = torque_on(robot, joint)[0]
        for i in range(joints.shape[1]):
            acting[0, i], acting[1, i], acting[2, i] = joints[0, i], joints[1, i], joints[2, i]
        acting[2, joint] = 0.0
        move(robot, acting)
        out[k, LOAD], variance, out[k, INERTIA] = torque_on(robot, joint, joints[2, joint])
        for i in range(joints.shape[1]):
            acting[2, i] = joints[SMOOTHED, i] if i != joint else 0.0
        move(robot, acting)
        lag = torque_on(robot, joint)[0] - out[k, LOAD]
        out[k, DEVIATION] = math.sqrt(variance)
        out[k, NOISE] = 2.0 * lag * lag / (LAG * time)


class ArmLoad:
    """
    The load on joint `joint` of the robot `arrays`, with its filter for accelerations of `time` s.

    motion: where a restart goes on from; a new one by default. compensated: whether torques lack
    what holds the weight.
    """

    def __init__(self, arrays: RobotArrays, joint: int, time: float,
                 motion: MotionState | None = None, compensated: bool = False) -> None:
        self._arrays, self._joint, self._time = arrays, joint, time
        self._compensated = compensated
        self.motion = motion or motion_at_start(len(set(arrays.source.tolist())))

    def inputs(self, stamps: Integers, u: Array, positions: Array) -> Array:
        """
        Return the inputs [N, 6] of sample_loop.Stream.

        Args:
            stamps: [N], ns.
            u: motor torque and measured load [N, 2], N m.
            positions: of all joints of the robot [N, n], rad.
        """
        rows = np.empty((len(stamps), 2 + N_LOAD))
        loads = np.empty((len(stamps), N_LOAD))
        weight = np.empty(len(stamps) if self._compensated else 0)
        write_loads(self._arrays, self.motion, self._joint, self._time, stamps,
                    np.ascontiguousarray(positions, float), loads, weight)
        rows[:, :2], rows[:, 2:] = u, loads
        if self._compensated:
            rows[:, 0] += weight
        return rows
