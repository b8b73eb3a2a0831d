# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Check a robot's log: stamps, jumps, ranges and conventions of all joints against its description.

check calls this where --model is the file of a robot.
"""
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gearbox_monitor.cli.inputs import names_of, reading_of_robot, robot_of
from gearbox_monitor.cli.options import refuse, show, wrapped
from gearbox_monitor.files.yaml_files import expect_new_file
from gearbox_monitor.library.robot import check_robot
from gearbox_monitor.robot.description import SUFFIXES
from gearbox_monitor.signals.finding import BAD, DataFinding

OF_DRIVE = ('params', 'motor_joint', 'arm_joint', 'setpoint_joint', 'purposes')
OF_ROBOT = ('values', 'root', 'recorded', 'prefix', 'convention')


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of check are about a whole robot. Raises InputError."""
    robot = args.model is not None and Path(args.model).suffix.lower() in SUFFIXES
    refuse(args, OF_DRIVE if robot else OF_ROBOT,
           f'of a single drive, but --model {args.model} is a whole robot' if robot else
           'of a whole robot, expected its MJCF or URDF file as --model')
    return robot


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_new_file(args.json)
    findings = check_robot(args.bag, robot_of(args), recorded=names_of(args), topic=args.topic,
                           reading=reading_of_robot(args))
    lines = [{'group': f.group, 'name': f.name, 'verdict': f.verdict().name.lower(),
              'figure': f.figure, 'advice': f.advice, 'values': f.values} for f in findings]
    head = summary(str(args.bag), findings)
    show(args, {'summary': head, 'bag': str(args.bag), 'model': str(args.model), 'lines': lines},
         lambda: text(head, lines))
    return int(any(f.verdict() == BAD for f in findings))


def summary(log: str, findings: Sequence[DataFinding]) -> str:
    """Return in one sentence whether a `log` with these findings suits a diagnosis."""
    bad = [f'{f.name} ({f.group})' for f in findings if f.verdict() == BAD]
    return (f'{log} suits the diagnosis of the robot.' if not bad else
            f'{log} does not suit the diagnosis as it is read: {", ".join(bad)}.')


def text(head: str, lines: Sequence[Mapping[str, Any]]) -> str:
    """Return the findings `lines` below a `head`, at most 80 columns wide."""
    rows = wrapped(head)
    group = None
    for line in lines:
        if line['group'] != group:
            group = line['group']
            rows += ['', group]
        rows += wrapped(line['figure'], f'  {line["name"]:16s} {line["verdict"]:4s} ', ' ' * 24)
        rows += wrapped(f'-> {line["advice"]}', ' ' * 24, ' ' * 27) if line['advice'] else []
    return '\n'.join(rows)
