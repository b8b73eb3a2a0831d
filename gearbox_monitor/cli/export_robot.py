# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write the verdict on a whole robot into its MJCF or URDF file.

export calls this where its input is a verdict (.json) instead of a model file.
"""
from argparse import Namespace
from collections.abc import Mapping
import math
from pathlib import Path
from typing import Any

from gearbox_monitor import __version__
from gearbox_monitor.cli.options import refuse
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import write_new
from gearbox_monitor.files.plain_data import read_json
from gearbox_monitor.simulators.mjcf_file import read_file
from gearbox_monitor.simulators.robot_closed import closed_file, title_of
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.xml_edit import difference, parse_xml

ROOTS = {'mjcf': 'mujoco', 'urdf': 'robot'}
OF_ONE_JOINT = ('joint', 'model_arm_joint', 'keyframe', 'actuator', 'check', 'topic',
                'motor_joint', 'arm_joint')


def is_verdict(args: Namespace) -> bool:
    """Return whether the options `args` of export name a verdict."""
    return Path(args.model).suffix.lower() == '.json'


def run(args: Namespace) -> int:
    """Write the findings of the verdict that `args` name into a file; return the exit code."""
    refuse(args, OF_ONE_JOINT, f'of one joint, expected a model file of a drive, not {args.model}')
    if not args.into:
        raise InputError(f'--into: missing, expected the {args.to.upper()} file of the robot')
    data = load_verdict(args.model)
    path = Path(args.into)
    original = read_file(path)
    tag = parse_xml(original, str(path)).root.tag
    if tag != ROOTS[args.to]:
        raise InputError(f'{path}: <{tag}>, expected <{ROOTS[args.to]}> with --to {args.to}')
    file = read_robot(path, args.root, data.get('locked'))
    text, unwritten = closed_file(file, data['findings'], f'gearbox_monitor {__version__} export')
    count = len(data['findings'])
    lines = [f'{path}: {count} finding{"" if count == 1 else "s"}']
    lines += [f'  {title_of(finding)}: ' + ', '.join(
        f'{name} {value:.6g}' for name, value in finding['values'].items())
        for finding in data['findings']]
    lines += [f'not in the file: {words}' for words in unwritten]
    if data.get('model_digest') not in (None, file.digest):
        lines.append(f'note: {path} is not the file of the diagnosis ({data.get("model")}): the '
                     'changes are added to what stands in it')
    if data['remainders']:
        lines.append('note: the verdict has remainders without a law, which no file holds')
    if text is not None and args.out:
        write_new(args.out, text)
        lines.append(f'written {args.out}')
    elif text is not None:
        lines += ['', *difference(args.into, original, text.encode())]
    else:
        lines.append('nothing to write')
    print('\n'.join(lines))
    return 1 if unwritten or data['remainders'] else 0


def load_verdict(path: str) -> dict[str, Any]:
    """Return the verdict on a whole robot in the JSON file `path`. Raises InputError."""
    data = read_json(path, 'verdict.json of diagnose')
    if not isinstance(data, dict) or not isinstance(data.get('findings'), list):
        raise InputError(f'{path}: no findings, expected verdict.json of diagnose')
    if not isinstance(data.get('ranked'), list) or not isinstance(data.get('remainders'), list):
        raise InputError(f'{path}: the verdict on one joint, expected one on a whole robot; the '
                         'model of one joint is drive.closed.yaml of diagnose --out')
    locked = data.get('locked', {})
    if not isinstance(locked, dict) or not all(
            isinstance(x, (int, float)) for x in locked.values()):
        raise InputError(f'{path}: locked: {str(locked)[:40]!r}, expected NAME: position')
    for i, finding in enumerate(data['findings']):
        _check(finding, f'{path}: findings[{i}]')
    return data


def _check(finding: Any, where: str) -> None:
    """Raise InputError unless a finding has an effect, a place and numbers."""
    if not isinstance(finding, dict) or not isinstance(finding.get('effect'), str):
        raise InputError(f'{where}: effect: missing, expected an id')
    if not isinstance(finding.get('joint') or finding.get('link'), str):
        raise InputError(f'{where}: joint: missing, expected the name of a joint or a link')
    for key in ('values', 'deviations'):
        if not isinstance(finding.get(key), Mapping):
            raise InputError(f'{where}: {key}: missing, expected numbers by name')
        for name, value in finding[key].items():
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not (number and math.isfinite(value)) and (key == 'values' or value is not None):
                raise InputError(f'{where}: {key}: {name}: {str(value)[:40]!r}, expected a number')
    if set(finding['values']) - set(finding['deviations']):
        raise InputError(f'{where}: deviations: none of '
                         f'{", ".join(set(finding["values"]) - set(finding["deviations"]))}, '
                         'expected one of each value, or null')
