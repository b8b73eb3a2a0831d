# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Inertia of a robot's body with something added: one that a body can have."""
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.chain import body_of, inertial
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.robot_model import ChainFile

LEAST = 1e-9    # kg m^2, of a principal inertia
BEYOND = 0.2    # of the largest principal inertia: what may be added to make a body possible


def possible(own: Array, added: Array, where: str) -> tuple[float, Array, Array]:
    """
    Return the body that has the sum of two sets of inertial parameters.

    A mass that is taken away is no point: what remains is filled up to a body's inertia, which is
    above 0 and where no principal inertia exceeds the sum of the others.

    Args:
        own: [10] of the body.
        added: [10], in the same frame.
        where: of the body, for messages.

    Returns:
        Mass kg, centre [3] m, inertia about it [3, 3] kg m^2.

    Raises:
        InputError: no mass remains, or no inertia that a body can have.
    """
    theta = own + added
    if not theta[0] > 0.0:
        raise InputError(f'{where}: mass {theta[0]:.3g} kg with the finding, expected more than 0')
    mass, centre, tensor = body_of(theta)
    smallest, middle, largest = np.linalg.eigvalsh(tensor)
    deficit = max(LEAST - smallest, (1.0 + 1e-6) * (largest - middle - smallest), 0.0)
    if deficit > LEAST and deficit > BEYOND * max(largest, LEAST) and not added[0]:
        raise InputError(f'{where}: no body has such an inertia (principal ones {smallest:.3g}, '
                         f'{middle:.3g}, {largest:.3g} kg m^2)')
    return mass, centre, tensor + deficit * np.eye(3)


def body_with(file: ChainFile, link: str, added: Array) -> tuple[int, tuple[float, Array, Array]]:
    """
    Return the body of a link in a compiled model with something added.

    Args:
        file: of the robot, an MJCF.
        link: its name.
        added: inertial parameters [10], in the frame of the joint that moves the link.

    Returns:
        Number of the body; its mass kg, centre [3] m and inertia about it [3, 3] kg m^2, in the
        body's frame.

    Raises:
        InputError: see possible.
    """
    m: Any = file.compiled
    # A body with several joints is several links of one name, of which the last has the mass.
    joint = max(i for i, of in enumerate(file.chain.links) if of.name == link)
    body = int(m.jnt_bodyid[joint])
    frame = np.zeros(9)
    mujoco_module().mju_quat2Mat(frame, m.body_iquat[body])
    axes = frame.reshape(3, 3)
    own = inertial(float(m.body_mass[body]), m.body_ipos[body].copy(),
                   axes @ np.diag(m.body_inertia[body]) @ axes.T)
    return body, possible(own, moved(added, m.jnt_pos[joint]), f'{file.path}: body {link}')


def moved(theta: Array, by: Array) -> Array:
    """Return inertial parameters `theta` [10] in a frame whose origin lies at -`by` [3] m."""
    mass, first = float(theta[0]), theta[1:4]
    out = theta.copy()
    out[1:4] += mass * by
    # About the new origin: I + 2 (first . by) 1 - first by' - by first' + m (by . by 1 - by by').
    shift = ((2.0 * first @ by + mass * by @ by) * np.eye(3) - np.outer(first, by)
             - np.outer(by, first) - mass * np.outer(by, by))
    out[4:] += *np.diag(shift), shift[0, 1], shift[0, 2], shift[1, 2]
    return out
