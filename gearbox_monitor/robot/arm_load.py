# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The load on one joint of a robot, from the measured positions of all of them.

Speeds and accelerations come from a fading-memory polynomial filter of second degree: least
squares over the past, each sample weighted by exp(-age / time). Its acceleration is late by about
three times that time; how far it is off shows by its change over as long.
"""
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.types import Array, Integers, Matrix, Vector
from gearbox_monitor.robot.dynamics import move, RobotArrays, torque_on

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
