# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The torque that makes one drive move like another (computed torque).

Run the drive C and ask at each of its states which torque on motor and arm gives the drive E the
accelerations of C: M_E (x'' of C less x'' of E). Nothing of C is needed where this torque acts.
"""
import numpy as np

from gearbox_monitor.kernels.jit import jit
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import INVERSE_M1, INVERSE_M2
from gearbox_monitor.plant.effects import Three
from gearbox_monitor.plant.effects.composition import stored_memories
from gearbox_monitor.plant.simulate import (
    advance, derivative, PackedDrive, ProcessNoise, Schedule)


@jit
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


@jit
def _run(state: Array, schedule: Schedule, noise: ProcessNoise,
         drives: tuple[PackedDrive, PackedDrive], torque: Array) -> None:
    t, u, extra, dt = schedule
    n = u.shape[1]
    h = dt / n
    for k in range(u.shape[0]):
        external = (extra[k, 0], extra[k, 1], extra[k, 2])
        torque[k, 0], torque[k, 1] = external[0], external[1]
        for i in range(n):
            at = t[k] + i * h
            first = torque_difference(at, state, u[k, i], external, drives)
            advance(state, at, h, u[k, i:i + 1], external, noise, drives[0], 0.0)
            second = torque_difference(at + h, state, u[k, i], external, drives)
            torque[k, 0] += (u[k, i] + 0.5 * (first[0] + second[0])) / n
            torque[k, 1] += 0.5 * (first[1] + second[1]) / n


@jit
def imbalance(path: tuple[Array, Array], torque: Array, extra: Array, inertia: Array,
              drive: PackedDrive, state: Array, out: Array) -> None:
    """
    Fill in the torque that moves a drive beyond what its equations say.

    Args:
        path: times [M], s, and positions, speeds and accelerations of motor and arm [M, 6].
        torque: of the actuator [M], N m.
        extra: torques from outside [M, 3], N m.
        inertia: of motor and arm [2], kg m^2.
        drive: PackedDrive.
        state: workspace [N_STATE].
        out: torque [M], N m.
    """
    (t, motion), m = path, stored_memories(state)
    for k in range(len(t)):
        rate = derivative(t[k], (motion[k, 0], motion[k, 1], motion[k, 2], motion[k, 3]), m,
                          (torque[k], (extra[k, 0], extra[k, 1], extra[k, 2]), drive))
        out[k] = (inertia[0] * (motion[k, 4] - rate[2]) + inertia[1] * (motion[k, 5] - rate[3]))


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
    _run(state.copy(), schedule, ProcessNoise(np.zeros((1, 4)), np.zeros(4)),
         (closed, expressed), torque)
    return torque
