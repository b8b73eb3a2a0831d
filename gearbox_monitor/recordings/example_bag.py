# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bags of a simulated drive, to try commands and for benchmarks and tests."""
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation, KINDS
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.topics import ARM, MOTOR, PLANT_TRANSMISSION_STATE, TRANSMISSION
from gearbox_monitor.recordings.write import BagWriter

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
    topics = {topic: encode_joint_states(stamps, list(joints), position, effort=effort)}
    if truth:
        topics['/' + PLANT_TRANSMISSION_STATE] = encode_joint_states(
            stamps, [TRANSMISSION], (x[:, 0] - x[:, 1])[:, None], (x[:, 2] - x[:, 3])[:, None],
            tau_k[:, None])
    with BagWriter(path, 'lz4') as writer:
        for name in topics:
            writer.add_topic(name, 'sensor_msgs/msg/JointState')
        for stamp, *messages in zip(stamps.tolist(), *topics.values()):
            for name, message in zip(topics, messages):
                writer.write(name, stamp, message)
