# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Options of commands about whole robots, and the robot that they name."""
from argparse import ArgumentParser, Namespace
import shlex
from typing import TYPE_CHECKING

from gearbox_monitor.cli.drive_recordings import add_root_argument, written_options

if TYPE_CHECKING:
    from gearbox_monitor.library.robot import Robot


def add_robot_arguments(parser: ArgumentParser, reference: bool = True, values: bool = True
                        ) -> None:
    """Declare in `parser` what only whole robots take: a `reference`, `values` and folder."""
    if reference:
        parser.add_argument('--reference', metavar='LOG', nargs='+', default=[],
                            help='of a whole robot: logs of the healthy one without a load, or '
                            'one file of learn')
    if values:
        parser.add_argument('--values', metavar='FILE',
                            help='of a whole robot: values that its file does not state')
        add_root_argument(parser)
    parser.add_argument('--recorded', metavar='NAME=LOGNAME', nargs='+', default=[],
                        help='of a whole robot: joints that have another name in the log')


def robot_options(args: Namespace) -> str:
    """Return the options in `args` that say how model and logs of a robot are read."""
    written = written_options(args, ('root', 'values', 'topic'))
    names = f'--recorded {shlex.join(args.recorded)}' if args.recorded else ''
    return f'{written} {names}'.strip()


def robot_of(args: Namespace) -> 'Robot':
    """Return the robot that --model, --values and --root of `args` name. Raises InputError."""
    from gearbox_monitor.library.robot import load_robot
    return load_robot(args.model, values=args.values, root=args.root)
