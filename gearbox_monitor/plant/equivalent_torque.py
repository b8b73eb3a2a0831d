# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The torque that makes one drive move like another (computed torque).

Run the drive C and ask at each of its states which torque on motor and arm gives the drive E the
accelerations of C: M_E (x'' of C less x'' of E). Nothing of C is needed where this torque acts.
"""
from functools import cache
import math
from typing import Any

import numpy as np

from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.types import Array, Matrix, Vector
from gearbox_monitor.plant.drive import INVERSE_M1, INVERSE_M2, KIND
from gearbox_monitor.plant.effects import Three, Torques
from gearbox_monitor.plant.effects.composition import (
    advanced_memories, arm_corrected, arm_error, base_friction, DELAY1, DELAY2, elastic_torque,
    motor_corrected, motor_error, motor_gain, stored_memories)
from gearbox_monitor.plant.simulate import (
    advance, derivative, PackedDrive, play_after, ProcessNoise, rebuilt, Schedule, torques)
from gearbox_monitor.plant.transmission import RIGID

TANGENT = 0.1        # of the twist, over which a stiffness is taken
TORQUE_SHARE = 0.1   # of the torque, by which it may be off where the twist is off by its size
HALVINGS = 12        # of a range for the twist
NO_SETPOINT = (0.0, 0.0, 0.0)  # of a servo, which a measured motion has not


@kernel
def torque_difference(t: float, state: Array, u: float, extra: Three,
                      drives: tuple[PackedDrive, PackedDrive]) -> tuple[float, float]:
    """
    Return the torque that drive E lacks at a state.

    Args:
        t: time, s.
        state: [N_STATE] of C.
        u: torque of the actuator, N m.
        extra: torques from outside on motor, arm and in the transmission, N m.
        drives: C and E.

    Returns:
        Torques on motor and arm, N m.
    """
    closed, expressed = drives
    x, m = (state[0], state[1], state[2], state[3]), stored_memories(state)
    target = derivative(t, x, m, (u, extra, closed))
    own = derivative(t, x, m, (u, extra, expressed))
    return ((target[2] - own[2]) / expressed.p[INVERSE_M1],
            (target[3] - own[3]) / expressed.p[INVERSE_M2])


@entry
def _run(state: Vector, schedule: Schedule, noise: ProcessNoise,
         drives: tuple[PackedDrive, PackedDrive], torque: Matrix) -> None:
    t, u, extra, dt = schedule
    n = u.shape[1]
    h = dt / n
    for k in range(u.shape[0]):
        external = (extra[k, 0], extra[k, 1], extra[k, 2])
        torque[k, 0], torque[k, 1] = external[0], external[1]
        for i in range(n):
            at = t[k] + i * h
            first = torque_difference(at, state, u[k, i], external, drives)
            advance(state, at, h, u[k, i:i + 1], external, (noise.numbers[0], noise.std),
                    drives[0], 0.0)
            second = torque_difference(at + h, state, u[k, i], external, drives)
            torque[k, 0] += (u[k, i] + 0.5 * (first[0] + second[0])) / n
            torque[k, 1] += 0.5 * (first[1] + second[1]) / n


@kernel
def lacking_twist(lacks: float, x1: float, x2: float, m: Any, sizes: tuple[float, float],
                  drive: PackedDrive) -> float:
    """
    Return how far a twist is from the curve of torque over twist, rad.

    Along the twist, or along the tangent where that is nearer: in the gap, a little torque is no
    reason to be at its end.

    Args:
        lacks: torque that the transmission does not have, N m.
        x1: position of the motor, rad.
        x2: position of the arm, rad.
        m: memories.
        sizes: of the twist in a recording, rad, and of its torque, N m.
        drive: PackedDrive.
    """
    p, e = drive.p, drive.e
    size, torque = sizes
    sign = 1.0 if lacks > 0.0 else -1.0
    here, near = elastic_torque(x1, x2, m, p, e), TANGENT * size
    slope = (elastic_torque(x1, x2 - near, m, p, e)
             - elastic_torque(x1, x2 + near, m, p, e)) / (2.0 * near)
    secant = TORQUE_SHARE * torque / size
    # Which is as far as it is worth looking.
    low, high = 0.0, sign * lacks / math.sqrt(slope * slope + secant * secant)
    if sign * (elastic_torque(x1, x2 - sign * high, m, p, e) - here - lacks) < 0.0:
        return sign * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if sign * (elastic_torque(x1, x2 - sign * middle, m, p, e) - here - lacks) < 0.0:
            low = middle
        else:
            high = middle
    return sign * 0.5 * (low + high)


@entry
def imbalance(path: tuple[Vector, Matrix], step: float, sizes: tuple[float, float],
              torque: Vector, extra: Matrix, drive: PackedDrive, state: Vector,
              out: Matrix) -> None:
    """
    Fill in the torques that move a drive beyond what its equations say.

    Args:
        path: times [M], s, and positions, speeds and accelerations of motor and arm [M, 6].
        step: time from row to row, s, over which memories advance; 0: they stay.
        sizes: of the twist in the recording, rad, and of its torque, N m.
        torque: of the actuator [M], N m.
        extra: torques from outside [M, 3], N m.
        drive: PackedDrive.
        state: workspace [N_STATE].
        out: torques [M, 2] on the whole drive and on the arm, N m; with a step [M, 3]:
            the lacking twist, rad.
    """
    (t, motion), p, e = path, drive.p, drive.e
    base = base_friction(p)
    for k in range(len(t)):
        m = stored_memories(state)
        x = (motion[k, 0], motion[k, 1], motion[k, 2], motion[k, 3])
        if step > 0.0 and k > 0:
            m = advanced_memories(m, NO_SETPOINT, 0.5 * (motion[k - 1, 2] + x[2]),
                                  0.5 * (motion[k - 1, 3] + x[3]), step, base, e)
            state[4] = play_after(x, m, p)
            for i in range(1, len(state) - 4):
                state[4 + i] = m[i]
            m = stored_memories(state)
        rate = derivative(t[k], x, m, (torque[k], (extra[k, 0], extra[k, 1], extra[k, 2]), drive))
        out[k, 1] = (motion[k, 5] - rate[3]) / p[INVERSE_M2]
        out[k, 0] = (motion[k, 4] - rate[2]) / p[INVERSE_M1] + out[k, 1]
        if step > 0.0 and int(p[KIND]) != RIGID:
            out[k, 2] = lacking_twist(out[k, 1], x[0], x[1], m, sizes, drive)


@entry
def true_motion(read: Matrix, dt: float, e: Vector, out: Matrix) -> None:
    """
    Fill in the motion that encoders with their effects read.

    Args:
        read: positions, speeds and accelerations of motor and arm as read [N, 6].
        dt: time from row to row, s.
        e: packed effects.
        out: the same [N, 6] of the drive.
    """
    n = read.shape[0]
    for side in range(2):
        late = e[DELAY1 if side == 0 else DELAY2] / dt
        for k in range(n):
            i = min(int(k + late), n - 1)
            h = (k + late - i) * dt if k + late < n else 0.0
            y, v, a = read[i, side], read[i, 2 + side], read[i, 4 + side]
            y, v = y + h * (v + 0.5 * h * a), v + h * a
            a += h / dt * (read[min(i + 1, n - 1), 4 + side] - a)
            if side == 0:
                error, slope, curvature = motor_error(NO_SETPOINT, e, motor_corrected(y, e))
            else:
                error, slope, curvature = arm_error(NO_SETPOINT, e, arm_corrected(y, e))
            out[k, side], out[k, 2 + side] = y - error, v * (1.0 - slope)
            out[k, 4 + side] = a * (1.0 - slope) - curvature * v * v


@entry
def gains(x1: Vector, e: Vector, out: Vector) -> None:
    """
    Fill in the torque that acts over the torque that is logged.

    Args:
        x1: positions of the motor [N], rad.
        e: packed effects.
        out: ratios [N].
    """
    for k in range(len(x1)):
        out[k] = motor_gain(1.0, e, x1[k])


@cache
def imbalance_with(added: Torques) -> Any:
    """Return imbalance rebuilt around the torques `added` by a plug-in."""
    return rebuilt(imbalance, derivative=rebuilt(
        derivative, torques=rebuilt(torques, plugged=added)))


def equivalent_torque(schedule: Schedule, state: Array, closed: PackedDrive,
                      expressed: PackedDrive) -> Array:
    """
    Return the torques that move a drive E as C moves.

    Args:
        schedule: what drives C.
        state: [N_STATE] where C begins.
        closed: C.
        expressed: E.

    Returns:
        Mean torques on motor and arm over each sample [N, 2], N m: those of the actuator and from
        outside, and what E lacks.
    """
    torque = np.empty((len(schedule.u), 2))
    _run(state.copy(), schedule, ProcessNoise(np.zeros((1, 1, 4)), np.zeros(4)),
         (closed, expressed), torque)
    return torque
