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

"""Logs and the model of a whole robot, as the commands of robots read them."""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.bag.robot_input import numbered_names, read_robot_log
from gearbox_monitor.balance.knowledge import Knowledge, learn
from gearbox_monitor.balance.robot_log import checked_log, RobotLog
from gearbox_monitor.balance.rows import RobotModel
from gearbox_monitor.balance.settings import SETTINGS
from gearbox_monitor.cli.progress import percent_bar, progress_of
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.robot_model import ChainFile, read_robot
from gearbox_monitor.files.knowledge_file import load_knowledge, SUFFIX
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.kernels.types import Array

SUFFIXES = ('.xml', '.urdf', '.mjcf')
KEYS = ('tolerance', 'link_tolerance', 'friction_tolerance', 'torque_constants', 'effort', 'kp',
        'kd', 'gain_tolerance', 'compensated')


def add_robot_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` what only whole robots take."""
    parser.add_argument('--recorded', metavar='NAME=LOGNAME', nargs='+', default=[],
                        help='of a whole robot: joints of the model that the log calls otherwise')


@dataclass(frozen=True, eq=False)
class RobotValues:
    """
    What --values says of a robot.

    tolerance, friction_tolerance, gain_tolerance: relative, None for the usual. links {name:
    tolerance}; constants {joint: N m/A}, None if not stated; kp, kd {joint: gain};
    measured: the effort is measured, not commanded; compensated: the servo adds the weight.
    """

    tolerance: float | None
    friction_tolerance: float
    links: Mapping[str, float]
    constants: Mapping[str, float] | None
    kp: Mapping[str, float]
    kd: Mapping[str, float]
    gain_tolerance: float
    measured: bool
    compensated: bool


def load_values(path: str | None, file: ChainFile) -> RobotValues:
    """Return the RobotValues of the YAML file `path` for the robot `file`. Raises InputError."""
    content: Any = {} if path is None else load_yaml(path).content
    if not isinstance(content, dict):
        raise InputError(f'{path}: {str(content)[:40]!r}, expected keys and values')
    for key in content:
        if key not in KEYS:
            raise InputError(f'{path}: {key}: {unknown(str(key), KEYS)}')
    joints = file.chain.joints
    links = [link.name for link in file.chain.links]

    def number(where: str, value: Any, low: float = 0.0) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not (
                math.isfinite(value) and value >= low):
            raise InputError(f'{path}: {where}: {str(value)[:40]!r}, expected a number of {low:g} '
                             'or more')
        return float(value)

    def table(key: str, names: Sequence[str], low: float = 0.0) -> dict[str, float]:
        value = content.get(key, {})
        if not isinstance(value, dict):
            raise InputError(f'{path}: {key}: {str(value)[:40]!r}, expected NAME: number')
        for name in value:
            if name not in names:
                raise InputError(f'{path}: {key}: {unknown(str(name), names)}')
        return {str(name): number(f'{key}.{name}', v, low) for name, v in value.items()}
    effort = content.get('effort', 'commanded')
    if effort not in ('measured', 'commanded'):
        raise InputError(f'{path}: effort: {effort!r}, expected measured or commanded')
    compensated = content.get('compensated', False)
    if not isinstance(compensated, bool):
        raise InputError(f'{path}: compensated: {compensated!r}, expected true or false')
    tolerance = content.get('tolerance')
    return RobotValues(
        None if tolerance is None else number('tolerance', tolerance),
        number('friction_tolerance', content.get('friction_tolerance', SETTINGS.tolerance)),
        table('link_tolerance', links), table('torque_constants', joints, 1e-9)
        if 'torque_constants' in content else None, table('kp', joints), table('kd', joints),
        number('gain_tolerance', content.get('gain_tolerance', SETTINGS.gain_tolerance)),
        effort == 'measured', compensated)


def robot_model(file: ChainFile, values: RobotValues, learnt: bool) -> RobotModel:
    """
    Return the RobotModel of a file.

    Args:
        file: of the simulator.
        values: of the user.
        learnt: whether references teach its friction.
    """
    usual = values.tolerance
    if usual is None:
        usual = SETTINGS.tolerance_learnt if learnt else SETTINGS.tolerance
    tolerance = np.array([values.links.get(link.name, usual) for link in file.chain.links])

    def gains(table: Mapping[str, float], of_file: Array | None) -> Array | None:
        if not table:
            return of_file
        base = np.zeros(len(file.chain.joints)) if of_file is None else of_file
        return np.array([table.get(joint, x) for joint, x in zip(file.chain.joints, base)])
    return RobotModel(file.chain, tolerance, 0.0 if learnt else values.friction_tolerance, learnt,
                      gains(values.kp, file.kp), gains(values.kd, file.kd), values.compensated,
                      values.gain_tolerance)


def recorded_names(words: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """Return {joint: name in the log} of NAME=LOGNAME `words`. Raises InputError."""
    names = {}
    for word in words:
        joint, equals, name = word.partition('=')
        if not equals or not name:
            raise InputError(f'--recorded: {word!r}, expected NAME=LOGNAME')
        if joint not in joints:
            raise InputError(f'--recorded: {unknown(joint, joints)}')
        names[joint] = name
    return names


def load_log(path: str, file: ChainFile, robot: RobotModel, values: RobotValues,
             args: Namespace) -> RobotLog:
    """
    Return the checked log in the file `path`.

    Args:
        path: of a bag or table.
        file: of the robot.
        robot: its model.
        values: of the user.
        args: options --recorded and --topic.
    """
    servo = robot.kp is not None and bool(np.all(robot.kp > 0.0))
    if robot.kp is not None and not servo and values.kp:
        lacking = [j for j, x in zip(file.chain.joints, robot.kp) if not x > 0.0]
        raise InputError(f'{args.values}: kp: none of {", ".join(lacking)}, expected one of each '
                         'joint')
    joints, notes = file.chain.joints, []
    names: Mapping[str, str] = recorded_names(args.recorded, joints)
    if not names and file.chain.serial:
        names = numbered_names(path, joints, args.topic)
        if names:
            notes.append('its joints have only numbers, taken from the base on: ' + ', '.join(
                f'{name} is {joint}' for joint, name in names.items())
                + ' (others: --recorded NAME=LOGNAME)')
    raw = read_robot_log(path, joints, names, values.constants, '' if servo else file.no_servo,
                         args.topic)
    raw = replace(raw, notes=(*raw.notes, *notes))
    if raw.kind == 'current' and values.constants is None:
        raise InputError(f'{path}: current without torque_constants, expected N m/A of each joint '
                         'in --values: a rough one does, masses come in its scale')
    if values.measured and raw.kind == 'torque':
        raw = replace(raw, measured=True)
    return checked_log(raw, joints)


def load_model(args: Namespace) -> ChainFile:
    """Return the robot that --model names. Raises InputError."""
    if Path(args.model).suffix.lower() not in SUFFIXES:
        raise InputError(f'{args.model}: expected an MJCF (.xml) or URDF file of the whole robot; '
                         'with --joint one joint of it, or a model file of a drive')
    return read_robot(args.model, args.root)


def reference_knowledge(paths: Sequence[str], file: ChainFile, values: RobotValues,
                        args: Namespace) -> tuple[Knowledge, list[str]]:
    """
    Return what references teach, and notes: a file of learn, or logs to learn from now.

    Args:
        paths: of --reference.
        file: of the robot.
        values: of the user.
        args: options of the command.
    """
    if len(paths) == 1 and paths[0].endswith(SUFFIX):
        return load_knowledge(paths[0], file.digest), []
    learnt = [path for path in paths if path.endswith(SUFFIX)]
    if learnt:
        raise InputError(f'--reference: {", ".join(learnt)} beside others, expected logs, or one '
                         'file of learn')
    robot = robot_model(file, values, True)
    logs = [load_log(path, file, robot, values, args) for path in paths]
    expect_alike(logs)
    with percent_bar('learn') as bar:
        knowledge = learn(robot, logs, file.digest, progress=progress_of(bar))
    return knowledge, [f'{log.name}: {note}' for log in logs for note in log.notes]


def expect_alike(logs: Sequence[RobotLog]) -> None:
    """Raise InputError unless `logs` have inputs of one kind."""
    for log in logs:
        if log.kind != logs[0].kind:
            raise InputError(f'{log.name}: {log.kind}, but {logs[0].name}: {logs[0].kind}; '
                             'expected one kind of input')
