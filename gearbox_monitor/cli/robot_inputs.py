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
from collections.abc import Sequence
from pathlib import Path
import shlex

from gearbox_monitor.bag.robot_values import load_log, robot_model, RobotValues
from gearbox_monitor.balance.knowledge import Knowledge, learn
from gearbox_monitor.balance.robot_log import RobotLog
from gearbox_monitor.balance.rows import RobotModel
from gearbox_monitor.cli.progress import percent_bar, progress_of
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.robot_model import ChainFile, read_robot, SUFFIXES
from gearbox_monitor.files.knowledge_file import load_knowledge, SUFFIX


def add_robot_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` what only whole robots take."""
    parser.add_argument('--recorded', metavar='NAME=LOGNAME', nargs='+', default=[],
                        help='of a whole robot: joints of the model that the log calls otherwise')


def robot_options(args: Namespace) -> str:
    """Return the options in `args` that say how model and logs of a robot are read."""
    words = [f'--{name} {shlex.quote(value)}' for name, value in (
        ('root', args.root), ('values', args.values),
        ('topic', args.topic if args.topic != 'joint_states' else None)) if value]
    if args.recorded:
        words.append(f'--recorded {shlex.join(args.recorded)}')
    return ' '.join(words)


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
    logs = load_logs(paths, file, robot, values, args)
    with percent_bar('learn') as bar:
        knowledge = learn(robot, logs, file.digest, progress=progress_of(bar))
    return knowledge, [f'{log.name}: {note}' for log in logs for note in log.notes]


def load_logs(paths: Sequence[str], file: ChainFile, robot: RobotModel, values: RobotValues,
              args: Namespace) -> list[RobotLog]:
    """
    Return the checked logs in some files, with inputs of one kind. Raises InputError.

    Args:
        paths: of bags or tables.
        file: of the robot.
        robot: its model.
        values: of the user.
        args: options --recorded and --topic.
    """
    recorded = recorded_names(args.recorded, file.chain.joints)
    logs = [load_log(path, file, robot, values, recorded, args.topic) for path in paths]
    for log in logs:
        if log.kind != logs[0].kind:
            raise InputError(f'{log.name}: {log.kind}, but {logs[0].name}: {logs[0].kind}; '
                             'expected one kind of input')
    return logs
