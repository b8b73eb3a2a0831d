# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The option --ros-args and the import of rclpy for commands that run a ROS node."""
import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from gearbox_monitor.errors import InputError, installed_by


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
                         f'{installed_by("ros")}') from None
