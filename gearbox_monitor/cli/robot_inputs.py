# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Options of commands about whole robots, and the robot that they name."""
from argparse import ArgumentParser, Namespace
from dataclasses import replace
import shlex

from gearbox_monitor.cli.drive_recordings import add_root_argument, written_options
from gearbox_monitor.cli.options import reading_of
from gearbox_monitor.library.robot import load_robot, recorded_names, Robot
from gearbox_monitor.recordings.from_bag import ANY
from gearbox_monitor.recordings.reading import ReadOptions
from gearbox_monitor.signals.convention import RULES


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
    parser.add_argument('--prefix', metavar='PREFIX', default='',
                        help='of a whole robot: what the names in the log begin with, as left_')
    parser.add_argument('--convention', metavar='JOINT=RULE', nargs='+', default=[],
                        help='of a whole robot: how a joint counts in the log, unlike in the '
                        f'model: {RULES}, joined by commas; as-recorded to judge it as it is; '
                        'JOINT all for all')


def reading_of_robot(args: Namespace) -> ReadOptions:
    """Return how the logs of a robot are read, as the options `args` state it."""
    return replace(reading_of(args), conventions=tuple(args.convention))


def robot_options(args: Namespace) -> str:
    """Return the options in `args` that say how model and logs of a robot are read."""
    written = written_options(args, ('root', 'values', 'topic'))
    names = f'--recorded {shlex.join(args.recorded)}' if args.recorded else ''
    names += f' --prefix {shlex.quote(args.prefix)}' if args.prefix else ''
    names += f' --convention {shlex.join(args.convention)}' if args.convention else ''
    return f'{written} {names}'.strip()


def robot_of(args: Namespace) -> Robot:
    """Return the robot that --model, --values and --root of `args` name. Raises InputError."""
    return load_robot(args.model, values=args.values, root=args.root)


def names_of(args: Namespace) -> dict[str, str]:
    """Return {joint: its name in the log} as the options `args` state it. Raises InputError."""
    return recorded_names(args.recorded) | ({ANY: args.prefix} if args.prefix else {})
