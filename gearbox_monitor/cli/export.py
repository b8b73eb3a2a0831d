# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a model, such as the closed one of diagnose, into the file of your simulator.

Edits the values of one joint in an MJCF file and nothing else: comments and formatting stay. One
joint takes a model with transmission.kind: rigid; for one with backlash and stiffness it becomes
the joint of the arm, and a joint of the motor with the actuator is added. --model-arm-joint
names the arm's joint where the file has both. What MuJoCo cannot express is listed with the
reason. Needs MuJoCo 4.0 (pip install '.[mujoco]' in a checkout). Of a whole robot, diagnose --out
writes the file with the findings.

--backlash gives a joint backlash without any model; a gearbox of unknown stiffness gets the
stiffest one that the timestep resolves.

With --to urdf it edits friction, effort limit and inertia of the joint in a URDF file, and lists
the rest.

With --to c it writes the estimator's filter with the model as C99 for the firmware of the drive:
FILE.c of --out, and FILE.h. --params states the parameters of the estimator. See
docs/firmware.md.

--ranges turns several estimates into ranges for domain randomisation: 90 % ranges of a new drive
with their correlation, as YAML (docs/actuators.md).
The estimates are JSON files of fit or diagnose, one of each drive or recording. MODEL may
also be the name of an actuator of the catalogue (docs/actuators.md); a file of that name wins.

How far the patched file is off, on another recording, diagnose --validate states.

usage examples:
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint elbow --out fits.xml
  gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint m --model-arm-joint e
  gearbox_monitor export --backlash 0.012 --to mjcf --into robot.xml --joint elbow --out play.xml
  gearbox_monitor export drive.closed.yaml --to urdf --into robot.urdf --joint elbow --out new.urdf
  gearbox_monitor export drive.yaml --params estimator.yaml --to c --out elbow.c --prefix elbow
  gearbox_monitor export unit1.json unit2.json unit3.json --to yaml --ranges --out ranges.yaml
"""
from argparse import Namespace
from pathlib import Path
import sys

from gearbox_monitor.cli.options import estimator_options, joint_of, refuse, write_or_print
from gearbox_monitor.errors import InputError, refusal
from gearbox_monitor.files.user_files import expect_new, expect_new_file, write_new
from gearbox_monitor.library.ranges import ranges, ranges_yaml
from gearbox_monitor.library.simulator_file import (
    CatalogueActuator, export_model, is_actuator, load_actuator, load_model, NAMES, SimulatorFile,
    SIMULATORS, TARGETS, with_backlash)
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.sentences import wrapped
from gearbox_monitor.simulators.c99 import firmware
from gearbox_monitor.simulators.file_edits import Patch
from gearbox_monitor.simulators.xml_edit import difference

CHOICES = (*TARGETS, 'c', 'yaml')
OF_FILES = ('into', 'joint', 'model_arm_joint', 'keyframe', 'actuator', 'root')


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
    if args.to == 'yaml':
        raise InputError('--to yaml: without --ranges, expected it with --ranges')
    if len(args.models) > 1:
        raise InputError(f'{len(args.models)} models: without --ranges, expected one')
    args.model = args.models[0]
    if args.to == 'c':
        return _write_c(args)
    model = _model(args.model)
    for option in ('into', 'joint'):
        if getattr(args, option) is None:
            raise InputError(f'--{option}: missing, --to {args.to} needs it')
    file = export_model(model, args.to, args.into, **joint_of(args))
    print('\n'.join(_patched(args, file)))
    return 1 if file.lacking else 0


def _with_backlash(args: Namespace) -> int:
    """Write the file of a simulator with backlash at a joint; return the exit code."""
    refuse(args, ('ranges', 'params', 'prefix'), 'with --backlash, expected one of both')
    if args.models or args.to != 'mjcf' or args.into is None or args.joint is None:
        raise InputError('--backlash: expected --to mjcf, --into FILE, --joint NAME and no MODEL')
    file = with_backlash(args.into, args.backlash, stiffness=args.stiffness, **joint_of(args))
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
    if gone := refusal(Path(name).name):
        raise InputError(f'{name}: {gone}')
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
    print('\n'.join([f'written {args.out} and {header}', *(
        f'note: {note}' for note in text.notes)]))
    return 0


def _export_ranges(args: Namespace) -> int:
    """Write or print the domain randomisation of several estimates; return the exit code."""
    if args.to != 'yaml':
        raise InputError(f'--to {args.to}: with --ranges, expected --to yaml')
    refuse(args, OF_FILES, 'with --ranges, expected none of it')
    actuator = _actuator(args.models[0]) if len(args.models) == 1 else None
    of_drives = ranges(args.models) if actuator is None else actuator.ranges
    write_or_print(args.out, ranges_yaml(of_drives))
    return 0


def _patched(args: Namespace, file: SimulatorFile) -> list[str]:
    """Write or show a patched file; return the lines of output."""
    patch, notes = file.patch, [line for note in file.notes for line in wrapped(note, '', '  ')]
    if args.out:
        write_new(args.out, patch.data.decode('utf-8'))
        ending = [f'written {args.out}']
    else:
        ending = ['', *difference(args.into, file.before, patch.data)]
    return [*described(patch, args.into), *notes, *ending]


def described(patch: Patch, path: str) -> list[str]:
    """Return lines about what `patch` changed in the file `path`, and what it could not."""
    lines = [f'{path}: {len(patch.changes)} changes']
    lines += [f'  {change.words}' for change in patch.changes]
    for row in patch.exported:
        lines += wrapped(f'{row.id}: {row.kind}: {row.words}', '', '  ')
    return lines
