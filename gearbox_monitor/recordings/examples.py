# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Example recordings, simulated: bags of a drive, and two logs of a whole arm.

One log of the arm is healthy, the other has a load and a rubbing joint.
"""
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation, KINDS
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.read import block_of_frames, Frames, JOINT_STATE
from gearbox_monitor.recordings.topics import ARM, MOTOR, PLANT_TRANSMISSION_STATE, TRANSMISSION
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.robot.arm_plant import DRIVES, HIGH, LOW
from gearbox_monitor.robot.chain import Chain, chain_of, inertial
from gearbox_monitor.robot.description import parse

NOISE = Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3))

VARIED = 'varied'
MOTIONS = (VARIED, *(kind for kind in KINDS if kind != 'none'))
SETPOINT = 'setpoint'  # its joint
ANGLE = 0.1   # rad of a setpoint per N m of the torque of a motion
ENCODERS = {'both': (0, 1), 'motor': (0,), 'arm': (1,)}  # columns of the readings
SWING = 10.0  # s, period of the amplitude of VARIED


class ExampleMotion(NamedTuple):
    """
    Duration (s), rate (Hz), first stamp (s), initial standstill (s) and MOTIONS of a recording.

    varied: the multisine with 30 to 100 % of its amplitude. Motion of one amplitude does not
    distinguish Coulomb from viscous friction.
    """

    seconds: float
    rate: float = 1000.0
    start: int = 1_700_000_000
    rest: float = 0.0
    kind: str = 'multisine'

    def command(self, t: Array, model: DriveModel) -> Array:
        """Return what moves `model` at `t` (s): a torque, N m, or a setpoint, rad."""
        torque = self.torque(t)
        return torque if model.controller is None else ANGLE * torque

    def torque(self, t: Array) -> Array:
        """Return the commanded torque (N m), of the shape of `t` (s)."""
        if self.kind != VARIED:
            return Excitation(self.kind).torque(t)
        return (0.3 + 0.7 * np.sin(np.pi * t / SWING) ** 2) * Excitation().torque(t)


def process_torque(model: DriveModel, noise: Noise, rate: float) -> float:
    """
    Return the torque (N m rms per sample) behind the noise of the motor's speed.

    Args:
        model: the drive.
        noise: of its speeds.
        rate: samples per second.
    """
    return float(model.motor_inertia * noise.process[2] * rate ** 0.5)


def write_example_bag(path: str | Path, model: DriveModel, motion: ExampleMotion, seed: int = 0,
                      topic: str = '/joint_states', noise: Noise = NOISE, truth: bool = False,
                      encoders: str = 'both') -> None:
    """
    Simulate a drive and record it.

    A controller of the model follows a setpoint, the position of a joint of its own, which is
    recorded in place of the torque.

    Args:
        path: the new bag.
        model: the drive.
        motion: duration, rate, start, standstill and kind.
        seed: of the noise.
        topic: of the joint states.
        noise: of process and encoders; at standstill only that of the encoders acts.
        truth: whether to record true torque and twist as well.
        encoders: of ENCODERS.

    Raises:
        InputError: the bag cannot be written.
    """
    plant, dt = Plant(model, Noise(measurement=noise.measurement), seed), 1.0 / motion.rate
    still = plant.run(np.zeros(round(motion.rest * motion.rate)), dt)
    plant.noise = noise
    t = np.arange(round(motion.seconds * motion.rate)) * dt
    run = plant.run(motion.command(t, model), dt, len(still.t) * dt)
    t, u, y, x, tau_k, load = (
        np.concatenate([getattr(part, name) for part in (still, run)])
        for name in ('t', 'u', 'y', 'x', 'tau_k', 'tau_arm'))
    stamps = motion.start * 1_000_000_000 + np.round(t * 1e9).astype(np.int64)
    none = np.full(len(t), np.nan)
    motor, arm = (y[:, i] if i in ENCODERS[encoders] else none for i in (0, 1))
    torque, setpoint = (u / model.effort_scale, none) if model.controller is None else (none, u)
    joints = {  # {name: (position, effort)}, the motor on its own side, as on the wire
        MOTOR: (motor * model.gear_ratio, torque),
        ARM: (arm, load if model.arm_load == 'measured' else none),
        SETPOINT: (setpoint * model.gear_ratio, none)}
    joints = {name: columns for name, columns in joints.items() if not np.isnan(columns).all()}
    position, effort = np.stack(list(joints.values()), axis=2)
    frames = [Frames(topic, tuple(joints), stamps, stamps, {
        'position': position, 'effort': effort})]
    if truth:
        frames.append(Frames(f'/{PLANT_TRANSMISSION_STATE}', (TRANSMISSION,), stamps, stamps, {
            'position': (x[:, 0] - x[:, 1])[:, None], 'velocity': (x[:, 2] - x[:, 3])[:, None],
            'effort': tau_k[:, None]}))
    with BagWriter(path, 'lz4') as writer:
        for part in frames:
            writer.add_topic(part.topic, JOINT_STATE)
        writer.write_block(block_of_frames([part.topic for part in frames], frames, whole=True))


LOAD, AT = 2.0, np.array([0.0, 0.03, 0.08])  # kg, m: at the last link
RUBBING = 1, 12.0                            # joint, N m more of Coulomb friction
RATE, ENCODER, ARM_NOISE = 100.0, 5e-5, 0.01     # Hz, rad, share of the torque
NAMES = 'robot.urdf', 'healthy.csv', 'today.csv'


def write_robot_pair(folder: Path, seconds: float, seed: int) -> list[str]:
    """
    Write robot.urdf, healthy.csv and today.csv into the new `folder`.

    Args:
        folder: to make.
        seconds: length of each log.
        seed: of motions and noise.

    Returns:
        Names of the files.

    Raises:
        InputError: they cannot be written.
    """
    text = config_path('arm6.urdf').read_text(encoding='utf-8')
    chain = chain_of(parse(text, 'arm6.urdf'))
    rng = np.random.default_rng(seed)
    try:
        folder.mkdir()
        (folder / NAMES[0]).write_text(text, encoding='utf-8')
        for name, changed in zip(NAMES[1:], (False, True)):
            table = simulated(chain, seconds, rng, changed)
            header = ','.join(['t', *(f'q_{j}' for j in chain.joints),
                               *(f'tau_{j}' for j in chain.joints)])
            np.savetxt(folder / name, table, fmt='%.8g', delimiter=',', header=header, comments='')
    except OSError as error:
        raise InputError(f'{folder}: {error.strerror}, expected a new, writable folder') from None
    return list(NAMES)


def simulated(chain: Chain, seconds: float, rng: np.random.Generator, changed: bool) -> Array:
    """
    Return a log [N, 1 + 2 J]: t, positions and torques of a prescribed motion.

    Args:
        chain: the arm.
        seconds: length.
        rng: of motion and noise.
        changed: with the load and the rubbing joint.
    """
    t, count = np.arange(0.0, seconds, 1e-3), len(chain.joints)
    q = np.tile(0.5 * (LOW + HIGH), (len(t), 1))
    for j in range(count):
        for f in rng.uniform(0.05, 0.4, 4):
            width = 0.12 * (HIGH - LOW)[j] * rng.uniform(0.5, 1.0) / (1.0 + 3.0 * f)
            q[:, j] += width * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 2.0 * np.pi))
    v, a = scipy.interpolate.CubicSpline(t, q)(t, 1), scipy.interpolate.CubicSpline(t, q)(t, 2)
    theta = chain.theta
    if changed:
        theta[-1] += inertial(LOAD, AT, np.diag([2e-3] * 3))
    momentum, torque = np.zeros_like(q), np.zeros_like(q)
    for r in chain.regressors(q, v):
        momentum[:, r.joint] += r.p @ theta[r.link]
        torque[:, r.joint] += (r.g - r.k) @ theta[r.link]
    torque += scipy.interpolate.CubicSpline(t, momentum)(t, 1)
    for j, (rotor, _, _, coulomb, viscous) in enumerate(DRIVES):
        dry = coulomb + (RUBBING[1] if changed and j == RUBBING[0] else 0.0)
        slow = 1.0 + 0.3 * np.exp(-(v[:, j] / 0.1) ** 2)
        torque[:, j] += rotor * a[:, j] + viscous * v[:, j] + dry * slow * np.tanh(v[:, j] / 5e-3)
    rows = np.arange(0, len(t), int(1000 / RATE))
    noise = ARM_NOISE * torque.std(axis=0) * rng.normal(size=(len(rows), count))
    return np.column_stack([t[rows], q[rows] + ENCODER * rng.normal(size=(len(rows), count)),
                            torque[rows] + noise])
