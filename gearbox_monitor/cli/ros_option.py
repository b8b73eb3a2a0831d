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

"""The option --ros-args and the import of rclpy for commands that run a ROS node."""
import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from gearbox_monitor.errors import InputError


def add_ros_option(parser: argparse.ArgumentParser) -> None:
    """Declare --ros-args in `parser`; it takes the rest of the command line."""
    parser.add_argument('--ros-args', nargs=argparse.REMAINDER, default=[],
                        help='arguments for ROS, such as remappings')


def ros_words(args: argparse.Namespace) -> list[str]:
    """Return the words of --ros-args as rclpy.init takes them."""
    return ['--ros-args', *args.ros_args] if args.ros_args else []


@contextmanager
def rclpy_required() -> Iterator[None]:
    """Raise InputError if an import in the block fails."""
    try:
        yield
    except ImportError as error:
        raise InputError(f'rclpy: not installed here ({error}), expected a sourced ROS 2 or '
                         'this package installed with the extra [ros]') from None
