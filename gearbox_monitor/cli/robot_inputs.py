# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Options of commands about whole robots, and the robot that they name."""
from argparse import ArgumentParser, Namespace
import shlex

from gearbox_monitor.cli.drive_recordings import written_options
from gearbox_monitor.library.robot import load_robot, Robot


def add_robot_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` what only whole robots take."""
    parser.add_argument('--recorded', metavar='NAME=LOGNAME', nargs='+', default=[],
                        help='of a whole robot: joints that have another name in the log')


def robot_options(args: Namespace) -> str:
    """Return the options in `args` that say how model and logs of a robot are read."""
    written = written_options(args, ('root', 'values', 'topic'))
    names = f'--recorded {shlex.join(args.recorded)}' if args.recorded else ''
    return f'{written} {names}'.strip()


def robot_of(args: Namespace) -> Robot:
    """Return the robot that --model, --values and --root of `args` name. Raises InputError."""
    return load_robot(args.model, values=args.values, root=args.root)
