# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Read the description of a robot from a URDF file."""
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import read_text
from gearbox_monitor.robot.description import LONGEST, parse, RobotDescription

TOPIC = 'topic:'  # begins a robot_description that names a topic


def load_robot(path: str) -> RobotDescription:
    """Return the robot of the URDF file `path`, a robot_description. Raises InputError."""
    if path.startswith(TOPIC):
        raise InputError(f'robot_description: {path}: a topic, which only a node can read; '
                         'expected a file')
    try:
        text = read_text(path, LONGEST)
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise InputError(f'robot_description: {path}: {reason}, expected a URDF file') from None
    return parse(text, path)
