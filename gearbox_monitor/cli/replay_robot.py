# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Replay a whole robot's log: what it held, and the external torque on its joints.

replay calls this where --model is the file of a robot.
"""
from argparse import ArgumentParser, Namespace
import csv
import io
from pathlib import Path

from gearbox_monitor.cli.options import expect_new_file, refuse, show, write_new
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.cli.robot_inputs import (
    add_robot_arguments, names_of, reading_of_robot, robot_of)
from gearbox_monitor.errors import InputError
from gearbox_monitor.export.robot_model import SUFFIXES
from gearbox_monitor.library.payload_track import PayloadTrack, track_payload
from gearbox_monitor.library.views import columns

OF_ESTIMATOR = ('params', 'filter', 'estimates_only', 'smooth')
OF_ROBOT = ('reference', 'values', 'root', 'recorded', 'prefix', 'convention', 'link', 'empty')


def add_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` of replay what only whole robots take."""
    add_robot_arguments(parser)
    parser.add_argument('--link', default='', metavar='NAME',
                        help='of a whole robot: link that carries (default: the last)')
    parser.add_argument('--empty', action='store_true',
                        help='of a whole robot: it holds nothing at the beginning')


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of replay are about a whole robot. Raises InputError."""
    robot = args.model is not None and Path(args.model).suffix.lower() in SUFFIXES
    refuse(args, OF_ESTIMATOR if robot else OF_ROBOT,
           f'of the estimator of a drive, but --model {args.model} is a whole robot'
           if robot else 'of a whole robot, expected its MJCF or URDF file as --model')
    return robot


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if args.out and not args.out.lower().endswith('.csv'):
        raise InputError(f'--out: {args.out}, expected FILE.csv: of a whole robot replay writes '
                         'a table')
    paths = [path for path in (args.out, args.csv) if path]
    expect_new_file(*paths)
    with progress_bar('replay') as progress:
        track = track_payload(
            args.bag, robot_of(args), reference=args.reference or None, link=args.link,
            empty=args.empty, recorded=names_of(args), reading=reading_of_robot(args),
            topic=args.topic, progress=progress)
    for path in paths:
        _write(path, track)
    show(args, {'summary': str(track), 'log': track.log, 'link': track.link,
                'joints': track.joints, 'estimates': len(track.t), 'warnings': track.notes,
                'last': {name: values[-1] for name, values in columns(track).items()}},
         lambda: '\n'.join([str(track), f'{len(track.t)} estimates', *(
             f'note: {note}' for note in track.notes), *(f'written: {path}' for path in paths)]))
    return 0


def _write(path: str, track: PayloadTrack) -> None:
    table, text = columns(track), io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(table)
    writer.writerows(zip(*(values.tolist() for values in table.values())))
    write_new(path, text.getvalue())
