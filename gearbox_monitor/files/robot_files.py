# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

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
