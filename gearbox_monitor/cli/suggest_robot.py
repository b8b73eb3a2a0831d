# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Suggest the motion of a whole robot: suggest calls this with --robot."""
from argparse import ArgumentParser, Namespace
import io
import math

import numpy as np
import yaml

from gearbox_monitor.balance.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.cli.options import expect_new, show, stated, write_new
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.errors import InputError
from gearbox_monitor.library.robot import load_robot
from gearbox_monitor.library.robot_motion import goal_lines, suggest_robot
from gearbox_monitor.plant.effects import EFFECTS

OF_ONE_DRIVE = ('verdict', 'pair', 'model', 'noise', 'joint', 'keyframe', 'actuator',
                'model_arm_joint')
OF_A_ROBOT = ('effects', 'payload', 'link')


def add_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` of suggest what only whole robots take."""
    parser.add_argument('--robot', metavar='FILE',
                        help='MJCF or URDF of a whole robot: suggest a motion of all joints')
    parser.add_argument('--effects', metavar='ID,ID',
                        help='of a robot: tell these effects apart')
    parser.add_argument('--payload', action='store_true',
                        help='of a robot: show the smallest payload (the default)')
    parser.add_argument('--link', metavar='NAME',
                        help='link that carries the payload (default: the last one)')


def run(args: Namespace) -> int:
    """Run the command with the options `args` of suggest; returns the exit code."""
    for option in stated(args, OF_ONE_DRIVE):
        raise InputError(f'--robot: with {option}, which is of one drive, expected one of them')
    if args.payload and args.effects is not None:
        raise InputError('--payload: with --effects, expected one of them')
    expect_new(args.out, args.csv, args.json)
    effects = None if args.effects is None else args.effects.split(',')
    robot = load_robot(args.robot, values=args.values, root=args.root)
    with progress_bar('suggest') as progress:
        motion = suggest_robot(
            robot, effects, seconds=args.seconds, link=args.link or '', speed=args.max_speed,
            torque=math.inf if args.max_torque is None else args.max_torque,
            travel=args.max_travel, progress=progress)
    if args.out:
        write_new(args.out, yaml.safe_dump(motion.trajectory, default_flow_style=None,
                                           width=1000, sort_keys=False))
    if args.csv:
        names, table = motion.table
        text = io.StringIO()
        np.savetxt(text, table, '%.9g', ',', header=','.join(names), comments='')
        write_new(args.csv, text.getvalue())
    d = motion.design
    data = {'seconds': float(d.t[-1]), 'gain': d.gain, 'notes': list(motion.notes),
            'goals': [{'effect': e, 'place': p, 'beside': r or None, 'size': size,
                       'usual': d.usual[e, p, r]} for (e, p, r), size in d.goals.items()],
            'visible': d.visible, 'start': dict(zip(motion.joints, d.q[0].tolist()))}
    units = {e.id: e.parameters[0].unit for e in EFFECTS.values() if e.parameters} | {
        e.id: next(iter(e.units.values())) for e in ROBOT_EFFECTS}
    lines = [f'{d.t[-1]:g} s: effects are seen at 1/{d.gain:.2g} of the size that random '
             'motions show', *goal_lines(d, units), 'begins at ' + ', '.join(
                 f'{j} {q:.3g}' for j, q in zip(motion.joints, d.q[0])), *motion.notes,
             *(f'written: {name}' for name in (args.out, args.csv) if name)]
    show(args, data, lambda: '\n'.join(lines))
    return 0
