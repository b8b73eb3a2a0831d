# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A whole arm: rigid links on elastic joints with backlash, each moved by a motor and its servo.

The rotors are taken as turning about their own joint only. RK4, the torque of the servos is held
over a sample.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.types import Array, Cube, Matrix, Vector
from gearbox_monitor.plant.drive import D, DriveModel, HALF_GAP, motor_acceleration, STIFFNESS
from gearbox_monitor.plant.transmission import dead_zone
from gearbox_monitor.robot.dynamics import coupled_inertia, move, RobotArrays, torque_on

LONGEST_STEP = 5e-4  # s: a light link on a stiff joint swings at some hundred Hz


class ServoDrives(NamedTuple):
    """
    Packed parameters [n, ...] of n drives and the gains of their servos.

    u = kp (r - x1) + kd (r' - x3) of each joint; N m/rad and N m s/rad, arm side.
    """

    p: Matrix
    kp: Vector
    kd: Vector


class ArmScratch(NamedTuple):
    """Room for the arm's matrix [n, n], its right side [n], motions [3, n] and slopes [6, 4 n]."""

    matrix: Matrix
    right: Vector
    motion: Matrix
    slopes: Matrix


@dataclass(frozen=True)
class ArmRun:
    """
    N samples of n joints: t [N] s; u [N, n] N m, held from t_k to t_k+1.

    motor, arm [N, n]: true positions, rad; tau_k [N, n]: true torque of the transmissions, N m.
    """

    t: Array
    u: Array
    motor: Array
    arm: Array
    tau_k: Array


@kernel
def _slopes(robot: RobotArrays, p: Array, x: Array, u: Array, scratch: ArmScratch,
            out: Array) -> None:
    """Write the derivative of x = (motor, arm, motor speed, arm speed), n each, to `out`."""
    matrix, right, motion, _ = scratch
    n = u.shape[0]
    for i in range(n):
        motion[0, i], motion[1, i], motion[2, i] = x[n + i], x[3 * n + i], 0.0
    move(robot, motion)
    for i in range(n):
        x3, x4 = x[2 * n + i], x[3 * n + i]
        tau_k = p[i, STIFFNESS] * dead_zone(x[i] - x[n + i], p[i, HALF_GAP])
        out[i], out[n + i] = x3, x4
        out[2 * n + i] = motor_acceleration(x[i], x3, x4, u[i], tau_k, p[i])
        right[i] = tau_k + p[i, D] * (x3 - x4) - torque_on(robot, i)[0]
        for j in range(i + 1):
            matrix[i, j] = coupled_inertia(robot, i, j)
    for i in range(n):  # Cholesky, then forward and back
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = math.sqrt(total) if i == j else total / matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]
        out[3 * n + i] = right[i]


@entry
def _run(robot: RobotArrays, drives: ServoDrives, references: Cube, payload: Vector, x: Vector,
         dt: float, scratch: ArmScratch, out: Cube) -> None:
    """Run the arm; references [N, 2, n], payload [N], x [4 n] changed, out [N, 4, n]."""
    p, kp, kd = drives
    substeps = math.ceil(dt / LONGEST_STEP)
    n, slopes, h = p.shape[0], scratch.slopes, dt / substeps
    u = slopes[4, :n]
    for k in range(references.shape[0]):
        robot.amounts[-1] = payload[k]
        for i in range(n):
            u[i] = (kp[i] * (references[k, 0, i] - x[i])
                    + kd[i] * (references[k, 1, i] - x[2 * n + i]))
            out[k, 0, i], out[k, 1, i], out[k, 2, i] = u[i], x[i], x[n + i]
            out[k, 3, i] = p[i, STIFFNESS] * dead_zone(x[i] - x[n + i], p[i, HALF_GAP])
        for _ in range(substeps):
            stage = scratch.slopes[5]
            for q in range(4):
                a = 0.0 if q == 0 else (h if q == 3 else 0.5 * h)
                for i in range(4 * n):
                    stage[i] = x[i] + (a * slopes[q - 1, i] if q else 0.0)
                _slopes(robot, p, stage, u, scratch, slopes[q])
            for i in range(4 * n):
                x[i] += h / 6.0 * (slopes[0, i] + 2.0 * (slopes[1, i] + slopes[2, i])
                                   + slopes[3, i])


class ArmPlant:
    """
    An arm that keeps its state from run to run; starts at rest at `start` [n] (rad).

    robot: of arrays_of, the true one. drives: one DriveModel of each joint; its arm_inertia is not
    used. bandwidth: of the servos, Hz, for the inertias at the start.

    target: last reference position [n], rad.
    """

    def __init__(self, robot: RobotArrays, drives: Sequence[DriveModel], start: Array,
                 bandwidth: float = 6.0) -> None:
        n = len(drives)
        self._robot, self.drives = robot, list(drives)
        self._scratch = ArmScratch(np.zeros((n, n)), np.zeros(n), np.zeros((3, n)),
                                   np.zeros((6, 4 * n)))
        self._x = np.concatenate([start, start, np.zeros(2 * n)])
        self._time, self.target = 0.0, start
        motion = np.vstack([start, np.zeros((2, n))])
        move(robot, motion)
        inertia = np.array([torque_on(robot, i)[2] + drive.motor_inertia
                            for i, drive in enumerate(drives)])
        omega = 2.0 * np.pi * bandwidth
        self._gains = inertia * omega ** 2, 1.4 * inertia * omega

    def run(self, references: Array, payload: Array, dt: float) -> ArmRun:
        """
        Follow `references` [N, 2, n] (rad, rad/s) with the `payload` [N] (kg), `dt` s apart.

        Returns the ArmRun; the next one continues.
        """
        drives = ServoDrives(np.array([drive.pack() for drive in self.drives]), *self._gains)
        out = np.empty((len(references), 4, len(drives.p)))
        _run(self._robot, drives, np.ascontiguousarray(references),
             np.ascontiguousarray(payload, float), self._x, dt, self._scratch, out)
        t = self._time + dt * np.arange(len(references))
        self._time, self.target = self._time + dt * len(references), references[-1, 0]
        return ArmRun(t, out[:, 0], out[:, 1], out[:, 2], out[:, 3])


def pick_and_place(rng: np.random.Generator, limits: tuple[Array, Array, Array], start: Array,
                   moves: int, dt: float, payloads: tuple[float, float] = (0.0, 0.0)
                   ) -> tuple[Array, Array]:
    """
    Return references and payloads of random moves between poses.

    Each move is the one of least jerk to a random pose, as fast as the slowest joint's `speed`
    allows; a rest follows, in the middle of which the payload changes.

    Args:
        rng: source of the poses.
        limits: lowest and highest positions and highest speeds [n], rad and rad/s.
        start: first pose [n], rad.
        moves: how many; with an even number the arm ends without a payload.
        dt: length of a sample, s.
        payloads: range of the mass that every second move carries, kg.

    Returns:
        references [N, 2, n] of ArmPlant.run and payload [N], kg.

    """
    low, high, speed = limits
    position, mass = start, 0.0
    parts: list[Array] = []
    masses: list[Array] = []
    for k in range(moves):
        target = rng.uniform(low, high)
        length = max(0.3, float(np.max(1.875 * np.abs(target - position) / speed)))
        s = np.arange(1, round(length / dt) + 1)[:, None] * dt / length
        way = position + (target - position) * s ** 3 * (10.0 - 15.0 * s + 6.0 * s ** 2)
        rate = (target - position) / length * 30.0 * s ** 2 * (1.0 - s) ** 2
        pause = round(rng.uniform(0.2, 0.5) / dt)
        parts.append(np.stack([np.vstack([way, np.tile(target, (pause, 1))]),
                               np.vstack([rate, np.zeros((pause, len(low)))])], axis=1))
        next_mass = rng.uniform(*payloads) if k % 2 == 0 else 0.0
        masses += [np.full(len(s) + pause // 2, mass), np.full(pause - pause // 2, next_mass)]
        position, mass = target, next_mass
    return np.concatenate(parts), np.concatenate(masses)
