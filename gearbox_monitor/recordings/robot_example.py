# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A simulated pair of logs of the example arm: healthy, and with a load and a rubbing joint."""
from pathlib import Path

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import Chain, chain_of, inertial, joint_losses
from gearbox_monitor.robot.description import parse
from gearbox_monitor.robot.example_arm import DRIVES, HIGH, LOW

LOAD, AT = 2.0, np.array([0.0, 0.03, 0.08])  # kg, m: at the last link
RUBBING = 1, 12.0                            # joint, N m more of Coulomb friction
RATE, ENCODER, NOISE = 100.0, 5e-5, 0.01     # Hz, rad, share of the torque
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
    chain = chain_of(parse(text, 'arm6.urdf'), joint_losses(text), 'arm6.urdf')
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
    noise = NOISE * torque.std(axis=0) * rng.normal(size=(len(rows), count))
    return np.column_stack([t[rows], q[rows] + ENCODER * rng.normal(size=(len(rows), count)),
                            torque[rows] + noise])
