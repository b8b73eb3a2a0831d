# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Diagnose a whole robot: all joints of a log beside its MJCF or URDF file.

diagnose calls this where --model is the file of a robot and --joint is not given.
"""
from argparse import Namespace
from pathlib import Path
import time
from typing import Any

from gearbox_monitor.cli.options import dump, expect_new_file, ids_in, refuse, show, write_files
from gearbox_monitor.cli.progress import progress_bar
from gearbox_monitor.cli.robot_inputs import names_of, reading_of_robot, robot_of, robot_options
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.robot_model import SUFFIXES
from gearbox_monitor.library.robot import diagnose_robot, robot_effects, RobotDiagnosis
from gearbox_monitor.report.robot_gap_page import robot_gap_page
from gearbox_monitor.report.robot_words import robot_text

# Options of one joint: why a whole robot has no use for each.
OF_ONE_JOINT = {
    'model_arm_joint': 'a robot has one encoder per joint',
    'keyframe': 'the log says where all joints are',
    'actuator': 'the position actuators of all joints are read',
    'motor_joint': 'map a name with --recorded NAME=LOGNAME',
    'arm_joint': 'map a name with --recorded NAME=LOGNAME',
    'setpoint_joint': 'setpoints are those of all joints: setpoint_NAME or joint_setpoints',
    'repeated': 'of samples with one stamp the first is used',
    'validate': 'give a second log to a command of its own',
    'simulator': 'with an MJCF, MuJoCo runs it'}


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of diagnose are about a whole robot."""
    if args.joint is None and Path(args.model).suffix.lower() in SUFFIXES:
        return True
    refuse(args, ('reference', 'recorded', 'prefix', 'convention'),
           'of a whole robot, expected an MJCF or URDF file as --model, and no --joint')
    return False


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for attribute, reason in OF_ONE_JOINT.items():
        refuse(args, [attribute], f'of one joint, expected --joint with it ({reason})')
    effects = _effects(args)
    expect_new_file(args.json, args.out)
    began = time.process_time()
    with progress_bar('diagnose') as progress:
        diagnosis = diagnose_robot(
            args.bag, robot_of(args), reference=args.reference or None, effects=effects,
            recorded=names_of(args), reading=reading_of_robot(args), topic=args.topic,
            progress=progress)
    data = {**diagnosis.data, 'options': robot_options(args),
            'cpu_s': round(time.process_time() - began, 2)}
    if args.out:
        _write(args, diagnosis, data)
    show(args, data, lambda: robot_text(data))
    return 0 if data['verdict'] == 'none' and not data['readings'] else 1


def _effects(args: Namespace) -> list[str] | None:
    """Return the ids of --only without those of --exclude, None for all. Raises InputError."""
    ids = robot_effects()
    words = {option: ids_in(getattr(args, option) or ()) for option in ('only', 'exclude')}
    for option, listed in words.items():
        for word in listed:
            if word not in ids:
                raise InputError(f'--{option}: {unknown(word, ids)}')
    if not words['only'] and not words['exclude']:
        return None
    return [i for i in sorted(words['only'] or ids) if i not in words['exclude']]


def _write(args: Namespace, diagnosis: RobotDiagnosis, data: dict[str, Any]) -> None:
    """Write verdict, page and the model with the findings into the new folder --out."""
    folder, path = Path(args.out), diagnosis.robot.file.path
    if diagnosis.closed is not None:
        data['closed'] = f'{args.out}/{path.stem}.closed{path.suffix}'
    if diagnosis.lacking:
        data['warnings'].append('not in the file that closes the gap: '
                                + ', '.join(diagnosis.lacking))
    page = robot_gap_page(data, diagnosis.robot.file.chain, diagnosis.posture)
    contents = {folder / 'verdict.json': dump(data) + '\n', folder / 'report.html': page}
    if diagnosis.closed is not None:
        contents[Path(data['closed'])] = diagnosis.closed
    write_files(contents, args.out)
