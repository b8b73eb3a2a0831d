# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Inputs that several commands share: recordings of a drive, bags for filters, logs of a robot."""
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import replace
import os
import shlex
from types import MappingProxyType
from typing import Any, TYPE_CHECKING

from gearbox_monitor.cli.options import add_reading_arguments, BAG_HELP, reading_of, stated
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
from gearbox_monitor.signals.recording import RULES
from gearbox_monitor.signals.uniform import UniformRecording

if TYPE_CHECKING:
    from gearbox_monitor.library.recording import DriveRecording
    from gearbox_monitor.library.robot import Robot


def add_model_arguments(parser: ArgumentParser, required: bool = True) -> None:
    """Declare in `parser` the model file, `required` or not, or the joint of a simulator's."""
    parser.add_argument('--model', metavar='FILE', required=required,
                        help='model file of the drive, or MJCF or URDF file with --joint')
    add_joint_arguments(parser)
    parser.add_argument('--values', metavar='FILE',
                        help='with --joint: model values that are not in that file')


def add_bag_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` topic and joints of a drive in a bag."""
    parser.add_argument('--topic', default='joint_states', help='topic of the inputs, in bags')
    add_reading_arguments(parser)
    for side in ('motor', 'arm'):
        parser.add_argument(f'--recorded-{side}', metavar='NAME', default=side,
                            dest=f'{side}_joint',
                            help=f'name of the {side} joint in the recording (default: {side})')


def add_setpoint_argument(parser: ArgumentParser) -> None:
    """Declare in `parser` the joint that is a setpoint."""
    parser.add_argument('--recorded-setpoint', metavar='NAME',
                        default='setpoint', dest='setpoint_joint',
                        help='joint whose position is the setpoint of the motor, in bags, for a '
                        'model with a controller (default: setpoint)')


def add_joint_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` which joint of a simulator's file is the drive."""
    parser.add_argument('--joint', metavar='NAME',
                        help="joint of the simulator's file that the motor drives")
    parser.add_argument('--model-arm-joint', metavar='NAME',
                        help="joint of the arm in the simulator's file, if it is a different one")
    parser.add_argument('--keyframe', metavar='NAME',
                        help='posture in which inertia and weight are taken, a key of the file')
    parser.add_argument('--actuator', metavar='NAME',
                        help='actuator of the joint, where several act on it')
    add_root_argument(parser)


def add_root_argument(parser: ArgumentParser) -> None:
    """Declare in `parser` the folder below which the parts of a simulator's file lie."""
    parser.add_argument('--root', metavar='DIR',
                        help="folder below which the files lie that the simulator's file includes "
                        '(default: its own folder)')


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


def add_recording_arguments(parser: ArgumentParser, model_required: bool = True) -> None:
    """Declare in `parser` recordings of a drive, its model (`model_required`), its joints."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help=f'{BAG_HELP}; several of one drive at once')
    add_model_arguments(parser, model_required)
    add_bag_arguments(parser)
    add_setpoint_argument(parser)


def load_recordings(args: Namespace, weigh: bool = False) -> tuple[
        DriveModel, list[UniformRecording], UniformRecording | None, list[str]]:
    """
    Return (model, recordings of `args` at one rate, the one of --validate or None, notes).

    Args:
        args: options of add_recording_arguments.
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
        args: options of add_bag_arguments.
    """
    from gearbox_monitor.library.recording import load_recording
    joints = {role: name for role, name in (
        ('motor', args.motor_joint), ('arm', args.arm_joint),
        ('setpoint', getattr(args, 'setpoint_joint', 'setpoint'))) if name != role}
    recording: DriveRecording = load_recording(
        name, model, joints=joints, topic=args.topic, reading=reading_of(args))
    return recording


def add_robot_arguments(parser: ArgumentParser, reference: bool = True, values: bool = True
                        ) -> None:
    """Declare in `parser` what only whole robots take: a `reference`, `values` and folder."""
    if reference:
        parser.add_argument('--reference', metavar='LOG', nargs='+', default=[],
                            help='logs of the healthy robot without a load, or of a drive with '
                            'one encoder; or one file of learn')
    if values:
        parser.add_argument('--values', metavar='FILE',
                            help='of a whole robot: values that its file does not state')
        add_root_argument(parser)
    parser.add_argument('--recorded', metavar='NAME=LOGNAME', nargs='+', default=[],
                        help='of a whole robot: joints that have another name in the log')
    parser.add_argument('--prefix', metavar='PREFIX', default='',
                        help='of a whole robot: what the names in the log begin with, as left_')
    parser.add_argument('--convention', metavar='JOINT=RULE', nargs='+', default=[],
                        help='of a whole robot: how a joint counts in the log, unlike in the '
                        f'model: {RULES}, joined by commas; as-recorded to judge it as it is; '
                        'JOINT all for all')


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
        args: options of add_estimator_arguments.
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
