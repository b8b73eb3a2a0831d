# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Inputs that several commands share: recordings of a drive, bags for filters, logs of a robot."""
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
import os
import shlex
from types import MappingProxyType
from typing import Any, TYPE_CHECKING

from gearbox_monitor.cli.options import reading_of, stated
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.yaml_files import load_model
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.parameters import EstimatorParameters, resolve
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.from_bag import ANY
from gearbox_monitor.recordings.joint_input import JointInput
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.reading import ReadOptions
from gearbox_monitor.recordings.recorded_samples import read_snapshots
from gearbox_monitor.signals.uniform import UniformRecording

if TYPE_CHECKING:
    from gearbox_monitor.library.recording import DriveRecording
    from gearbox_monitor.library.robot import Robot


def written_options(args: Namespace, names: Sequence[str]) -> str:
    """Return the options `names` that `args` state, as a command has them."""
    return ' '.join(f'{option} {shlex.quote(value)}'
                    for option, value in stated(args, names).items())


def joint_of(args: Namespace) -> dict[str, Any]:
    """Return how `load_model` and `export_model` find the joint that `args` name."""
    return {'joint': args.joint, 'arm_joint': args.model_arm_joint, 'keyframe': args.keyframe,
            'actuator': args.actuator, 'root': args.root}


def load_drive(args: Namespace) -> DriveModel:
    """
    Return the model that --model of the options `args` names.

    It is a model file, or the file of a simulator where --joint is given. Raises InputError.
    """
    from gearbox_monitor.library.simulator_file import load_model
    return load_model(args.model, **joint_of(args), values=args.values)


def load_recordings(args: Namespace, weigh: bool = False) -> tuple[
        DriveModel, list[UniformRecording], UniformRecording | None, list[str]]:
    """
    Return (model, recordings of `args` at one rate, the one of --validate or None, notes).

    Args:
        args: options of a command on recordings of a drive.
        weigh: whether a doubt about channels, signs and units is weighed, and no note.

    Raises:
        InputError: one is named twice, cannot be read, or allows no statement about the drive.

    """
    validate = getattr(args, 'validate', None)
    paths = [*args.bag, *filter(None, [validate])]
    places = [os.path.realpath(path) for path in paths]
    for path, place in zip(paths, places):
        if places.count(place) > 1:
            raise InputError(f'{path}: twice, expected different recordings')
    model = load_drive(args)
    from gearbox_monitor.library.identify import uniform
    recordings = [recording_of(path, model, args) for path in paths]
    return model, *uniform(recordings[:len(args.bag)], model,
                           recordings[-1] if validate else None, weigh)


def recording_of(name: str, model: DriveModel, args: Namespace) -> 'DriveRecording':
    """
    Return a recording of a drive. Raises InputError.

    Args:
        name: of a bag or another file.
        model: of the drive.
        args: options of a command on bags of a drive.
    """
    from gearbox_monitor.library.recording import load_recording
    joints = {role: name for role, name in (
        ('motor', args.motor_joint), ('arm', args.arm_joint),
        ('setpoint', getattr(args, 'setpoint_joint', 'setpoint'))) if name != role}
    recording: DriveRecording = load_recording(
        name, model, joints=joints, topic=args.topic, reading=reading_of(args))
    return recording


def reading_of_robot(args: Namespace) -> ReadOptions:
    """Return how the logs of a robot are read, as the options `args` state it."""
    return replace(reading_of(args), conventions=tuple(args.convention))


def robot_options(args: Namespace) -> str:
    """Return the options in `args` that say how model and logs of a robot are read."""
    written = written_options(args, ('root', 'values', 'topic'))
    names = f'--recorded {shlex.join(args.recorded)}' if args.recorded else ''
    names += f' --prefix {shlex.quote(args.prefix)}' if args.prefix else ''
    names += f' --convention {shlex.join(args.convention)}' if args.convention else ''
    return f'{written} {names}'.strip()


def robot_of(args: Namespace) -> 'Robot':
    """Return the robot that --model, --values and --root of `args` name. Raises InputError."""
    from gearbox_monitor.library.robot import load_robot
    return load_robot(args.model, values=args.values, root=args.root)


def names_of(args: Namespace) -> dict[str, str]:
    """Return {joint: its name in the log} as the options `args` state it. Raises InputError."""
    from gearbox_monitor.library.robot import recorded_names
    return recorded_names(args.recorded) | ({ANY: args.prefix} if args.prefix else {})


def settings_of(args: Namespace, reader: BagReader, source: JointInput, stated: Values,
                model_file: str, usual: Values = MappingProxyType({})
                ) -> tuple[DriveModel, EstimatorParameters, bool]:
    """
    Return (model, parameters, whether a file or the bag states the model).

    Both are those that an estimator has recorded, else defaults.

    Args:
        args: options of a command with an estimator.
        reader: of the bag.
        source: the estimator's inputs in it.
        stated: {name: value} that replace recorded parameters.
        model_file: that replaces the recorded model, '' for none.
        usual: {name: value} of parameters that neither the bag nor `stated` has.

    Raises:
        InputError: a parameter or a value of the model is unusable.

    """
    model, recorded = None, dict[str, Any]()
    snapshots = read_snapshots(reader, source, not model_file)
    if snapshots:
        model, recorded = snapshots[0].settings(str(reader.path))
    if model_file:
        model = load_model(model_file)
    values = {**usual, **recorded, **stated}
    values.pop('model', None)
    changed, parameters = resolve(reader.referred(model or DriveModel()), values,
                                  args.params or str(reader.path))
    return changed, parameters, model is not None
