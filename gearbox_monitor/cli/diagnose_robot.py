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

"""
Diagnose a whole robot: all joints of a log beside its MJCF or URDF file.

diagnose calls this where --model is the file of a robot and --joint is not given.
"""
from argparse import ArgumentParser, Namespace
import os
from pathlib import Path
import time
from typing import Any

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.robot_values import load_values, robot_model
from gearbox_monitor.balance.knowledge import Knowledge
from gearbox_monitor.balance.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.balance.verdict import diagnose, RobotVerdict, verdict_data
from gearbox_monitor.cli.options import dump, expect_new, plain, write_new
from gearbox_monitor.cli.robot_inputs import (
    add_robot_arguments, load_logs, load_model, reference_knowledge, robot_options)
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.export.robot_closed import closed_file, title_of
from gearbox_monitor.export.robot_model import ChainFile, SUFFIXES
from gearbox_monitor.export.robot_rollout import rollouts
from gearbox_monitor.files.yaml_files import expect_folder_of
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.quality.recording import REPEATED
from gearbox_monitor.report.robot_gap_page import robot_gap_page
from gearbox_monitor.report.robot_words import robot_headline, robot_text

# Options of one joint -> (attribute, its default, why a whole robot has no use for it).
OF_ONE_JOINT = {
    'model-arm-joint': ('model_arm_joint', None, 'a robot has one encoder per joint'),
    'keyframe': ('keyframe', None, 'the log says where all joints are'),
    'actuator': ('actuator', None, 'the position actuators of all joints are read'),
    'recorded-motor': ('motor_joint', 'motor', 'map a name with --recorded NAME=LOGNAME'),
    'recorded-arm': ('arm_joint', 'arm', 'map a name with --recorded NAME=LOGNAME'),
    'recorded-setpoint': ('setpoint_joint', 'setpoint',
                          'setpoints are those of all joints: setpoint_NAME or joint_setpoints'),
    'repeated': ('repeated', REPEATED[0], 'of samples with one stamp the first is used'),
    'validate': ('validate', None, 'give a second log to a command of its own'),
    'simulator': ('simulator', None, 'with an MJCF, MuJoCo runs it')}


def add_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` of diagnose what only whole robots take."""
    parser.add_argument('--reference', metavar='LOG', nargs='+', default=[],
                        help='of a whole robot: logs from before or of the healthy twin, or one '
                        'file of learn')
    add_robot_arguments(parser)


def is_robot(args: Namespace) -> bool:
    """Return whether the options `args` of diagnose are about a whole robot."""
    if args.joint is None and Path(args.model).suffix.lower() in SUFFIXES:
        return True
    for option in ('reference', 'recorded'):
        if getattr(args, option):
            raise InputError(f'--{option}: of a whole robot, expected an MJCF or URDF file as '
                             '--model, and no --joint')
    return False


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for option, (attribute, usual, why) in OF_ONE_JOINT.items():
        if getattr(args, attribute) != usual:
            raise InputError(f'--{option}: of one joint, expected --joint with it ({why})')
    effects = _effects(args)
    for path in (args.json, args.out):
        expect_new(path)
        expect_folder_of(path)
    began = time.process_time()
    file = load_model(args)
    values = load_values(args.values, file)
    knowledge: Knowledge | None = None
    notes: list[str] = []
    if args.reference:
        knowledge, notes = reference_knowledge(args.reference, file, values, args)
    robot = robot_model(file, values, knowledge is not None)
    logs = load_logs(args.bag, file, robot, values, args)
    notes += [f'{log.name}: {note}' for log in logs for note in log.notes]
    if knowledge is not None:
        if knowledge.kind != logs[0].kind:
            raise InputError(f'--reference: learnt from {knowledge.kind}, but {logs[0].name} has '
                             f'{logs[0].kind}, expected one kind of input')
        if not 0.5 < knowledge.rate / logs[0].rate < 2.0:
            notes.append(f'the reference has {knowledge.rate:.0f} samples/s, this log '
                         f'{logs[0].rate:.0f}')
    elif values.tolerance is None:
        notes.append(f'beside the model file, tolerances of {100 * robot.tolerance.max():.0f} %: '
                     'state others with tolerance in --values')
    verdict = diagnose(robot, logs, knowledge, effects)
    data = plain(verdict_data(verdict)) | {
        'logs': list(args.bag), 'model': args.model, 'options': robot_options(args),
        'model_digest': file.digest,
        'references': list(knowledge.references) if knowledge else [],
        'warnings': notes, 'rollouts': None, 'closed': None}
    torque = not verdict.evidence.recordings[0].setpoint
    if file.compiled is not None and verdict.findings and torque:
        runs = data['rollouts'] = plain(rollouts(file, verdict))
        for finding in data['findings']:
            name = title_of(finding)
            finding['confirmed'] = None if name in runs['without'] else name not in runs['vetoed']
        data['cautions'] += [f'{name}: free runs in MuJoCo are farther off with it than without'
                             for name in runs['vetoed']]
    data = {'summary': robot_headline(data), **data}
    data['cpu_s'] = round(time.process_time() - began, 2)
    if args.out:
        _write(args, data, file, verdict)
    if args.json and args.json != '-':
        write_new(args.json, dump(data) + '\n')
    print(dump(data) if args.json == '-' else robot_text(data))
    return 0 if data['verdict'] == 'none' else 1


def _effects(args: Namespace) -> list[str] | None:
    """Return the ids of --only without those of --exclude, None for all. Raises InputError."""
    ids = {e.id for e in EFFECTS.values() if e.column is not None} | {e.id for e in ROBOT_EFFECTS}
    words = {option: [w for part in getattr(args, option) or () for w in part.split(',') if w]
             for option in ('only', 'exclude')}
    for option, listed in words.items():
        for word in listed:
            if word not in ids:
                raise InputError(f'--{option}: {unknown(word, ids)}')
    if not words['only'] and not words['exclude']:
        return None
    return [i for i in sorted(words['only'] or ids) if i not in words['exclude']]


def _write(args: Namespace, data: dict[str, Any], file: ChainFile, verdict: RobotVerdict) -> None:
    """Write verdict, page and the model with the findings into the new folder --out."""
    folder = Path(args.out)
    text, left = closed_file(file, data['findings'], f'gearbox_monitor {__version__} diagnose')
    if text is not None:
        data['closed'] = f'{args.out}/{file.path.stem}.closed{file.path.suffix}'
    if left:
        data['warnings'].append(f'not in the file that closes the gap: {", ".join(left)}')
    posture = np.median(np.concatenate([r.motion.q for r in verdict.evidence.recordings]), axis=0)
    page = robot_gap_page(data, file.chain, posture)
    try:
        os.mkdir(folder)
    except OSError as error:
        raise InputError(f'{folder}: {error.strerror}, expected a new folder') from None
    write_new(folder / 'verdict.json', dump(data) + '\n')
    write_new(folder / 'report.html', page)
    if text is not None:
        write_new(data['closed'], text)
