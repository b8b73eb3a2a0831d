# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a model, such as the closed one of diagnose, into the file of your simulator.

Edits the values of one joint in an MJCF file and nothing else: comments and formatting stay. One
joint takes a model with transmission.kind: rigid; for one with backlash and stiffness it becomes
the joint of the arm, and the motor's joint with the actuator is added beside it. --model-arm-joint
names the arm's joint where the file has both. What MuJoCo cannot express is listed with the
reason. Needs MuJoCo 4.0 (pip install '.[mujoco]' in a checkout).

The verdict on a whole robot (verdict.json of diagnose) goes into its MJCF or URDF: joints and
bodies that have a finding.

--backlash gives a joint backlash without any model; a gearbox of unknown stiffness gets the
stiffest one that the timestep resolves.

With --to urdf it edits friction, effort limit and inertia of the joint in a URDF file, and lists
what URDF lacks.

With --to c it writes the estimator's filter with the model as C99 for the firmware of the drive:
FILE.c of --out, and FILE.h beside it. --params states the parameters of the estimator. See
docs/firmware.md.

--ranges turns several estimates into the domain randomisation of a simulator: 90 % ranges of a new
drive with their correlation, as YAML, or as event terms of Isaac Lab or mjlab (docs/actuators.md).
The estimates are JSON files of fit or diagnose, one of each drive or recording. MODEL may
also be the name of an actuator of the catalogue (docs/actuators.md); a file of that name wins.

--check BAG runs the drives in the file and in the patched file on a recording and prints the
misfit of both, in standard deviations of the encoder noise, beside that of the model: 1 is the
floor. Use a recording that did not serve to find the model.

usage examples:
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow --out fits.xml
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint m --model-arm-joint e
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow --check BAG2
  gearbox_monitor export --backlash 0.012 --to mjcf --into robot.xml --joint elbow --out play.xml
  gearbox_monitor export drive.closed.yaml --to urdf --into robot.urdf --joint elbow --out new.urdf
  gearbox_monitor export drive.yaml --params estimator.yaml --to c --out elbow.c --prefix elbow
  gearbox_monitor export verdict.json --to mjcf --into robot.xml --out closed.xml
  gearbox_monitor export unit1.json unit2.json unit3.json --to isaac --ranges --out events.py
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
import math
from pathlib import Path
import sys
from typing import Any

from gearbox_monitor import __version__
from gearbox_monitor.cli.inputs import add_bag_arguments, add_joint_arguments, load_recording
from gearbox_monitor.cli.options import estimator_options, refuse, wrapped, write_or_print
from gearbox_monitor.diagnosis.joint.closed_model import overlay
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import read_json, write_new
from gearbox_monitor.files.yaml_files import expect_new, expect_new_file
from gearbox_monitor.library.ranges import ranges
from gearbox_monitor.library.simulator_file import (
    CatalogueActuator, export_model, in_units, is_actuator, load_actuator, load_model, NAMES,
    SimulatorFile, SIMULATORS, TARGETS, with_backlash, written_model)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import number
from gearbox_monitor.simulators.c99 import firmware
from gearbox_monitor.simulators.file_edits import Patch
from gearbox_monitor.simulators.mjcf_file import MjcfDrive, read_file
from gearbox_monitor.simulators.randomisation import randomisation, WRITERS
from gearbox_monitor.simulators.robot_model import read_robot
from gearbox_monitor.simulators.robot_patch import closed_file, title_of
from gearbox_monitor.simulators.xml_edit import difference, parse_xml

OF_FILES = ('into', 'joint', 'model_arm_joint', 'keyframe', 'actuator', 'root', 'check')


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    parser.add_argument('models', metavar='MODEL', nargs='*',
                        help='model file, such as drive.closed.yaml, or verdict.json on a whole '
                        'robot; with --ranges JSON files of fit or diagnose')
    parser.add_argument('--to', required=True,
                        choices=(*TARGETS, 'c', *WRITERS),
                        help='simulator; yaml, isaac, mjlab: with --ranges; c: filter for '
                        'firmware')
    parser.add_argument('--backlash', metavar='WIDTH', type=float,
                        help='give the joint backlash, full width in rad or m, instead of a MODEL')
    parser.add_argument('--stiffness', metavar='K', type=float,
                        help='with --backlash: stiffness of the gearbox, N m/rad or N/m')
    parser.add_argument('--ranges', action='store_true',
                        help='domain randomisation: ranges of a new drive')
    parser.add_argument('--into', metavar='FILE',
                        help='MJCF or URDF file that is patched; it stays as it is')
    add_joint_arguments(parser)
    parser.add_argument('--out', metavar='FILE',
                        help='write the patched file (default: print the difference)')
    parser.add_argument('--check', metavar='BAG',
                        help='recording on which the file is run before and after')
    add_bag_arguments(parser)
    parser.add_argument('--params', metavar='FILE',
                        help='with --to c: ROS parameter file of the estimator')
    parser.add_argument('--prefix', metavar='NAME',
                        help='with --to c: prefix of the names of functions and types '
                        '(default: gm)')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    expect_new_file(args.out)
    if args.to != 'c' or args.ranges:
        refuse(args, ('params', 'prefix'), f'with --to {args.to}, expected it with --to c')
    if args.backlash is not None:
        return _with_backlash(args)
    refuse(args, ('stiffness',), 'without --backlash, expected it with --backlash')
    if not args.models:
        raise InputError('MODEL: missing, expected a model file, or --backlash')
    if args.ranges:
        return _export_ranges(args)
    if args.to in WRITERS:
        raise InputError(f'--to {args.to}: without --ranges, expected it with --ranges')
    if len(args.models) > 1:
        raise InputError(f'{len(args.models)} models: without --ranges, expected one')
    args.model = args.models[0]
    if args.to == 'c':
        return _write_c(args)
    if is_verdict(args):
        return run_robot(args)
    model = _model(args.model)
    if args.to == 'urdf':
        refuse(args, ('check',), 'with --to urdf, expected it with --to mjcf')
    for option in ('into', 'joint'):
        if getattr(args, option) is None:
            raise InputError(f'--{option}: missing, --to {args.to} needs it')
    file = export_model(model, args.to, args.into, joint=args.joint,
                        arm_joint=args.model_arm_joint, keyframe=args.keyframe,
                        actuator=args.actuator, root=args.root)
    print('\n'.join(_patched(args, file, model)))
    return 1 if file.lacking else 0


def _with_backlash(args: Namespace) -> int:
    """Write the file of a simulator with backlash at a joint; return the exit code."""
    refuse(args, ('ranges', 'check', 'params', 'prefix'), 'with --backlash, expected one of both')
    if args.models or args.to != 'mjcf' or args.into is None or args.joint is None:
        raise InputError('--backlash: expected --to mjcf, --into FILE, --joint NAME and no MODEL')
    file = with_backlash(args.into, args.backlash, joint=args.joint, stiffness=args.stiffness,
                         arm_joint=args.model_arm_joint, keyframe=args.keyframe,
                         actuator=args.actuator, root=args.root)
    print('\n'.join(_patched(args, file)))
    return 0


def _actuator(name: str) -> CatalogueActuator | None:
    """Return the actuator of the catalogue, None without; a file of its name wins."""
    if name in NAMES and Path(name).exists():
        print(f'note: {name}: the file of this name, not the actuator of the catalogue',
              file=sys.stderr)
        return None
    return load_actuator(name) if is_actuator(name) else None


def _model(name: str) -> DriveModel:
    """Return the model of an actuator of the catalogue, or in a file."""
    actuator = _actuator(name)
    return load_model(name) if actuator is None else actuator.model


def _write_c(args: Namespace) -> int:
    """Write the filter and its header; return the exit code."""
    refuse(args, OF_FILES, 'with --to c, expected it with the file of a simulator')
    if not args.out or Path(args.out).suffix != '.c':
        raise InputError(f'--out: {args.out or "missing"}, with --to c expected FILE.c')
    header = Path(args.out).with_suffix('.h')
    expect_new(header)
    if Path(args.model).suffix.lower() in SIMULATORS:
        raise InputError(f'{args.model}: the file of a simulator, with --to c expected a model '
                         'file')
    parameters, _ = estimator_options(args)
    text = firmware(_model(args.model), parameters, header.name, args.prefix or 'gm')
    write_new(args.out, text.source)
    write_new(header, text.header)
    print(f'written {args.out} and {header}')
    return 0


def _export_ranges(args: Namespace) -> int:
    """Write or print the domain randomisation of several estimates; return the exit code."""
    if args.to not in WRITERS:
        raise InputError(f'--to {args.to}: with --ranges, expected one of {", ".join(WRITERS)}')
    refuse(args, OF_FILES, 'with --ranges, expected none of it')
    actuator = _actuator(args.models[0]) if len(args.models) == 1 else None
    of_drives = ranges(args.models) if actuator is None else actuator.ranges
    write_or_print(args.out, randomisation(of_drives, args.to))
    return 0


def _patched(args: Namespace, file: SimulatorFile, model: DriveModel | None = None) -> list[str]:
    """Write or show a patched file; return the lines of output."""
    patch, notes = file.patch, [line for note in file.notes for line in wrapped(note, '', '  ')]
    if args.out:
        write_new(args.out, patch.data.decode('utf-8'))
        ending = [f'written {args.out}']
    else:
        ending = ['', *difference(args.into, file.before, patch.data)]
    if args.check and file.drive is not None and model is not None:
        ending += ['', *checked(file.drive, file, model, args)]
    return [*described(patch, args.into), *notes, *ending]


def described(patch: Patch, path: str) -> list[str]:
    """Return lines about what `patch` changed in the file `path`, and what it could not."""
    lines = [f'{path}: {len(patch.changes)} changes']
    lines += [f'  {change.words}' for change in patch.changes]
    for row in patch.exported:
        lines += wrapped(f'{row.id}: {row.kind}: {row.words}', '', '  ')
    return lines


def checked(drive: MjcfDrive, file: SimulatorFile, model: DriveModel, args: Namespace
            ) -> list[str]:
    """
    Return lines about the misfit of the drive in the file before and after, and of the model.

    Args:
        drive: in the file before.
        file: that was patched.
        model: that was exported.
        args: options of the command.

    """
    recording, notes = load_recording(args.check, model, args)
    models = {drive.path.name: in_units(drive, model), 'patched': written_model(
        file, model, keyframe=args.keyframe, actuator=args.actuator, root=args.root),
        Path(args.model).name: model}
    laid = overlay(recording, models)
    lines = [f'misfit on {args.check}, {len(laid.windows)} windows of 1 s, in standard deviations '
             'of the noise']
    lines += [f'  {name:<40s}{number(run.gap):>10s}' for name, run in zip(models, laid.runs)]
    return [*lines, *(f'note: {note}' for note in notes)]


ROBOT_ROOTS = {'mjcf': 'mujoco', 'urdf': 'robot'}
OF_ONE_JOINT = ('joint', 'model_arm_joint', 'keyframe', 'actuator', 'check', 'topic',
                'motor_joint', 'arm_joint')


def is_verdict(args: Namespace) -> bool:
    """Return whether the options `args` of export name a verdict."""
    return Path(args.model).suffix.lower() == '.json'


def run_robot(args: Namespace) -> int:
    """Write the findings of the verdict that `args` name into a file; return the exit code."""
    refuse(args, OF_ONE_JOINT, f'of one joint, expected a model file of a drive, not {args.model}')
    if not args.into:
        raise InputError(f'--into: missing, expected the {args.to.upper()} file of the robot')
    data = load_verdict(args.model)
    path = Path(args.into)
    original = read_file(path)
    tag = parse_xml(original, str(path)).root.tag
    if tag != ROBOT_ROOTS[args.to]:
        raise InputError(f'{path}: <{tag}>, expected <{ROBOT_ROOTS[args.to]}> with --to {args.to}')
    file = read_robot(path, args.root, data.get('locked'))
    text, unwritten = closed_file(file, data['findings'], f'gearbox_monitor {__version__} export')
    count = len(data['findings'])
    lines = [f'{path}: {count} finding{"" if count == 1 else "s"}']
    lines += [f'  {title_of(finding)}: ' + ', '.join(
        f'{name} {value:.6g}' for name, value in finding['values'].items())
        for finding in data['findings']]
    lines += [f'not in the file: {title}: {reason}' for title, reason in unwritten.items()]
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
