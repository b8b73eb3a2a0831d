# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A simulated arm: its motion, the example of six axes, and one that works through a shift."""
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.kernel import entry, kernel
from gearbox_monitor.kernels.types import Array, Cube, Matrix, Vector
from gearbox_monitor.plant.drive import (
    D, DriveModel, HALF_GAP, motor_acceleration, STIFFNESS, Transmission)
from gearbox_monitor.plant.transmission import dead_zone
from gearbox_monitor.robot.description import RobotDescription
from gearbox_monitor.robot.dynamics import (
    arrays_of, coupled_inertia, GRAVITY, move, Payload, RobotArrays, torque_on)

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


LOW = np.array([-2.0, -1.2, -0.3, -2.0, -1.5, -3.0])  # rad
HIGH = np.array([2.0, 0.9, 2.2, 2.0, 1.5, 3.0])
SPEED = np.array([2.0, 1.8, 2.2, 3.0, 3.0, 4.0])      # rad/s
MIDDLE = 0.5 * (LOW + HIGH)
# Motor inertia kg m^2, stiffness N m/rad, half gap rad, Coulomb N m, viscous N m s/rad.
DRIVES = ((4.0, 4e4, 2e-4, 9.0, 8.0), (4.0, 4e4, 2e-4, 12.0, 8.0), (1.6, 2e4, 2.5e-4, 6.0, 5.0),
          (0.3, 6e3, 4e-4, 2.0, 1.2), (0.3, 6e3, 4e-4, 2.0, 1.2), (0.15, 3e3, 5e-4, 1.2, 0.6))
RATED = np.array([100.0, 100.0, 50.0, 6.0, 6.0, 3.0])  # N m, scale of the noise of torques
ENCODER = 2e-5                                         # rad, standard deviation
PAYLOAD = Payload(position=(0.0, 0.0, 0.05), link='tool')


def nominal_drives(robot: RobotDescription) -> list[DriveModel]:
    """Return the model of each drive, with the inertia that `robot` has in the middle."""
    arrays = arrays_of(robot)
    move(arrays, np.vstack([MIDDLE, np.zeros((2, len(MIDDLE)))]))
    return [DriveModel(
        motor_inertia=inertia, arm_inertia=torque_on(arrays, joint)[2], damping=1e-3 * stiffness,
        viscous_friction=viscous, coulomb_friction=coulomb, position_gain=0.0,
        transmission=Transmission(stiffness=stiffness, half_gap=half_gap))
        for joint, (inertia, stiffness, half_gap, coulomb, viscous) in enumerate(DRIVES)]


def parameters_of(joint: int) -> dict[str, object]:
    """Return the parameters of the estimator of `joint`, by the size of its torques."""
    rated = float(RATED[joint])
    return {
        'motor_joint': f'motor{joint + 1}', 'arm_joint': f'joint{joint + 1}',
        'arm_load': 'model', 'payload_link': PAYLOAD.link,
        'payload_position': list(PAYLOAD.position), 'r_std_motor': ENCODER, 'r_std_arm': ENCODER,
        'q_std_motor_speed': 0.01, 'q_std_arm_speed': 0.01, 'tau_k_model': 'elastic',
        'q_std_tau_k_deviation': 0.005 * rated, 'q_std_tau_k': 0.1 * rated,
        'q_std_tau_arm': 0.1 * rated, 'p0_std_torque': rated,
        'p0_std_tau_k_deviation': 0.005 * rated, 'p0_std_speed': 1.0,
        'friction_error_std': 0.4 * DRIVES[joint][3]}


def as_built(robot: RobotDescription, rng: np.random.Generator, spread: float) -> RobotArrays:
    """Return a `robot` with masses and inertias that `rng` draws, off by `spread` at most."""
    mass, inertia = (1.0 + spread * rng.uniform(-1.0, 1.0, (2, len(robot.mass))))
    return arrays_of(replace(robot, mass=robot.mass * mass,
                             inertia=robot.inertia * inertia[:, None, None]),
                     PAYLOAD, 0.0, GRAVITY)


def drives_as_built(drives: list[DriveModel], rng: np.random.Generator) -> list[DriveModel]:
    """Return `drives` with frictions and inertias that `rng` draws within their tolerances."""
    def off(tolerance: float) -> float:
        return 1.0 + tolerance * float(rng.uniform(-1.0, 1.0))
    return [replace(d, coulomb_friction=d.coulomb_friction * off(d.friction_tolerance),
                    viscous_friction=d.viscous_friction * off(d.damping_tolerance),
                    motor_inertia=d.motor_inertia * off(d.inertia_tolerance)) for d in drives]


SPREAD = 0.1    # how far masses and inertias of the arm are off, relative
MOVES = 3       # of the program
PROGRAM = 7     # its seed: all joints load both flanks but the second, which carries the weight


@dataclass(frozen=True)
class GapGrowth:
    """From `start` (s) the gap of a `joint` (number from 0) grows by `rate` (1/s) of its width."""

    joint: int = 0
    rate: float = 0.0
    start: float = 0.0

    def factor(self, t: float) -> float:
        """Return the width at `t` (s) over that at the start."""
        return 1.0 + self.rate * max(t - self.start, 0.0)


class MeasuredRun(NamedTuple):
    """An ArmRun and the measured positions of motors and arms [N, n], rad."""

    true: ArmRun
    motor: Array
    arm: Array


def program(dt: float) -> Array:
    """Return the references [N, 2, n] of ArmPlant.run, `dt` s apart; they end where they begin."""
    start = MIDDLE
    for _ in range(2):  # the second time it begins where it ends
        references, _ = pick_and_place(
            np.random.default_rng(PROGRAM),
            (LOW, HIGH, SPEED), start, MOVES, dt)
        start = references[-1, 0]
    return references


class WorkingArm:
    """
    An arm whose masses and frictions are off within their tolerances.

    robot: as described. dt: length of a sample, s. seed: of what is off, and of the noise of the
    encoders.

    drives: as their model files describe them.
    """

    def __init__(self, robot: RobotDescription, dt: float, seed: int,
                 growth: GapGrowth = GapGrowth()) -> None:
        self._dt, self._growth, self._rng = dt, growth, np.random.default_rng(seed)
        self._references, self._count = program(dt), 0
        self.drives: Sequence[DriveModel] = nominal_drives(robot)
        self._plant = ArmPlant(
            as_built(robot, self._rng, SPREAD),
            drives_as_built(list(self.drives), self._rng), self._references[-1, 0])
        self._built = self._plant.drives[growth.joint]

    def run(self, n: int, payload: float = 0.0, rubbing: float = 0.0) -> MeasuredRun:
        """
        Work for `n` samples; the gap is that at their begin.

        Args:
            n: how many.
            payload: what the tool carries, kg.
            rubbing: more Coulomb friction of the joint whose gap grows, N m.
        """
        joint, factor = self._growth.joint, self._growth.factor(self._count * self._dt)
        self._plant.drives[joint] = replace(
            self._built, coulomb_friction=self._built.coulomb_friction + rubbing,
            transmission=replace(self._built.transmission, half_gap=factor * self.drives[
                joint].transmission.half_gap))
        rows = (self._count + np.arange(n)) % len(self._references)
        run = self._plant.run(self._references[rows], np.full(n, payload), self._dt)
        self._count += n
        motor, arm = (true + ENCODER * self._rng.normal(size=true.shape)
                      for true in (run.motor, run.arm))
        return MeasuredRun(run, motor, arm)
