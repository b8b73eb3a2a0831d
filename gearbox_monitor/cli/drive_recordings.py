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

"""Recordings of a drive, from bags or CSV files, as commands compare them with models."""
from argparse import Action, ArgumentParser, Namespace, SUPPRESS
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import math
from pathlib import Path
import shlex
import signal
import sys
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.bag.csv import read_csv, TEXTS
from gearbox_monitor.bag.joint_input import find_input
from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.recorded_samples import samples_of
from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.export.mjcf_file import MjcfDrive, model_of, NO_LIMIT, read_mjcf
from gearbox_monitor.files.yaml_files import load_model, load_yaml
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.admission import admitted, prepared, require_samples, weighed
from gearbox_monitor.quality.recording import merged, REPEATED, UniformRecording

FIELDS = {'t': 'stamp', 'u': 'effort of the motor', 'setpoint': 'position of the setpoint',
          'motor': 'position of the motor',
          'arm': 'position of the arm', 'arm_torque': 'effort of the arm'}


# Options whose attribute has another name.
OPTIONS = {'motor_joint': 'recorded-motor', 'arm_joint': 'recorded-arm',
           'setpoint_joint': 'recorded-setpoint'}


class Readings(NamedTuple):
    """
    Columns of a recording; place(row, field): where a value stands in the file, in words.

    u: torque, N m, or setpoint, rad, of a model with a controller.
    """

    t: Array | Integers
    u: Array
    y: Array
    arm_torque: Array | None
    place: Callable[[int, str], str]
    notes: list[str]


class FileLimits(NamedTuple):
    """What a simulator's file says of a recording: ranges (rad) of setpoints and positions."""

    notes: tuple[str, ...]
    setpoints: tuple[float, float]
    travel: tuple[float, float]


class Renamed(Action):
    """An option under its old name, which goes on working, with a note: const is the new one."""

    def __call__(self, parser: ArgumentParser, namespace: Namespace, values: Any,
                 option_string: str | None = None) -> None:
        """Store the value and say the new name."""
        print(f'note: {option_string} is called {self.const} now', file=sys.stderr)
        setattr(namespace, self.dest, values)


def add_renamed(parser: ArgumentParser, old: str, new: str, dest: str) -> None:
    """
    Declare in `parser` the old name of an option, which goes on working.

    Args:
        parser: of the command.
        old: name of the option before.
        new: its name now.
        dest: attribute of both.

    """
    parser.add_argument(old, metavar='NAME', dest=dest, action=Renamed, const=new,
                        default=SUPPRESS, help=SUPPRESS)


def add_model_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` the model file, or the joint of a simulator's file."""
    parser.add_argument('--model', metavar='FILE', required=True,
                        help='model file of the drive, or MJCF, URDF or SDF file with --joint')
    add_joint_arguments(parser)
    parser.add_argument('--values', metavar='FILE',
                        help='with --joint: model values that are not in that file')


def add_drive_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` the model file and the joints of a drive."""
    add_model_arguments(parser)
    parser.add_argument('--topic', default='joint_states', help='topic of the inputs, in bags')
    for what in ('motor', 'arm'):
        parser.add_argument(f'--recorded-{what}', metavar='NAME', default=what,
                            dest=f'{what}_joint',
                            help=f'name of the {what} joint, in bags (default: {what})')
        add_renamed(parser, f'--{what}-joint', f'--recorded-{what}', f'{what}_joint')
    add_setpoint_argument(parser)
    parser.add_argument('--repeated', choices=REPEATED, default=REPEATED[0],
                        help='what is used of samples with one and the same stamp: the first '
                        '(default), their average, or none')


def add_setpoint_argument(parser: ArgumentParser) -> None:
    """Declare in `parser` the joint that is a setpoint."""
    parser.add_argument('--recorded-setpoint', '--setpoint-joint', metavar='NAME',
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


def joint_options(args: Namespace) -> str:
    """Return the options of add_joint_arguments that `args` has, as a command has them."""
    return _stated(args, {'joint': None, 'model_arm_joint': None, 'keyframe': None,
                          'actuator': None, 'root': None})


def recording_options(args: Namespace) -> str:
    """Return the options of add_drive_arguments in `args` that say how recordings are read."""
    return _stated(args, {'topic': 'joint_states', 'motor_joint': 'motor', 'arm_joint': 'arm',
                          'setpoint_joint': 'setpoint', 'repeated': REPEATED[0]})


def _stated(args: Namespace, usual: Mapping[str, str | None]) -> str:
    """Return the options of `args` that are not as `usual` {attribute: default}."""
    words = []
    for name, default in usual.items():
        value = getattr(args, name)
        if value != default:
            option = OPTIONS.get(name, name.replace('_', '-'))
            words.append(f'--{option} {shlex.quote(value)}')
    return ' '.join(words)


def load_drive(args: Namespace) -> DriveModel:
    """
    Return the model that --model of the options `args` names.

    It is a model file, or the file of a simulator where --joint is given. Raises InputError.
    """
    if args.joint is None:
        if Path(args.model).suffix.lower() in ('.xml', '.urdf', '.sdf'):
            raise InputError(f'{args.model}: the file of a simulator, expected --joint with the '
                             'joint of the drive in it')
        if args.values is not None:
            raise InputError('--values: needs --joint, expected a --model of a simulator')
        return load_model(args.model)
    drive = read_mjcf(args.model, args.joint, args.model_arm_joint, args.keyframe, args.actuator,
                      args.root)
    given: Mapping[str, Any] = {}
    if args.values is not None:
        file = load_yaml(args.values)
        if not isinstance(file.content, dict):
            raise InputError(f'{args.values}: {str(file.content)[:40]!r}, expected keys and '
                             'values')
        given = file.content
    model = model_of(drive, given)
    args.file_limits = limits_of(drive, model)
    return model


def limits_of(drive: MjcfDrive, model: DriveModel) -> FileLimits:
    """Return the FileLimits of a `drive` in a simulator's file, which makes a `model`."""
    own, setpoints = drive.actuator, NO_LIMIT
    if own is not None and own.law is not None and own.law.setpoint and model.controller:
        low, high = sorted(bound / own.gear for bound in own.law.control)
        setpoints = low, high
    return FileLimits(drive.notes, setpoints, drive.motor.travel)


def add_recording_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` recordings of one drive, its model file and its joints."""
    parser.add_argument('bag', nargs='+', metavar='BAG',
                        help='bag directory, .mcap file or CSV file; several of one drive at once')
    add_drive_arguments(parser)


def load_recording(name: str, model: DriveModel, args: Namespace,
                   weigh: bool = False) -> tuple[UniformRecording, list[str]]:
    """
    Read a recording and check it.

    Args:
        name: of a bag or CSV file.
        model: of the drive.
        args: options of add_drive_arguments.
        weigh: whether a wrong look of channels, signs and units is a doubt, and no refusal.

    Returns:
        The recording and notes about it.

    Raises:
        InputError: it cannot be read, or allows no statement about the drive.

    """
    path = Path(name)
    if not path.exists():
        raise InputError(f'{path}: no such file or directory, expected a bag or a CSV file')
    csv = path.is_file() and path.name.lower().endswith(TEXTS)
    readings = _read_csv(path, model) if csv else _read_bag(path, model, args)
    limits: FileLimits | None = getattr(args, 'file_limits', None)
    if limits is not None:
        readings = _within_limits(readings, limits, model)
        args.file_limits = limits._replace(notes=())  # with the first recording
    arm = np.full(len(readings.u), np.nan) if readings.arm_torque is None else readings.arm_torque
    rows, values, repeats = merged(readings.t, np.column_stack([readings.u, readings.y, arm]),
                                   args.repeated)

    def place(row: int, field: str) -> str:
        """Return where the value of field in a row that is left stands."""
        return readings.place(int(rows[row]), field)
    columns = (readings.t[rows], values[:, 0], values[:, 1:3], values[:, 3])
    words = (str(path), place, model, Path(args.model).name)
    if weigh:
        recording, notes = prepared(*columns, *words)
        recording, doubts = weighed(recording, model)
        notes += doubts
    else:
        recording, notes = admitted(*columns, *words)
    return recording, [*readings.notes, *([repeats] if repeats else []), *notes]


def _within_limits(readings: Readings, limits: FileLimits, model: DriveModel) -> Readings:
    """Return readings with the setpoints that the simulator takes, and notes about limits."""
    notes, (low, high), u = [*limits.notes], limits.setpoints, readings.u
    if model.controller is not None:
        beyond = int(np.count_nonzero((u < low) | (u > high)))
        if beyond:
            u = np.clip(u, low, high)
            notes.append(f'{beyond} setpoints lie beyond ctrlrange ({low:g} to {high:g} rad): '
                         'taken as its ends, as MuJoCo does')
    low, high = limits.travel
    with np.errstate(invalid='ignore'):
        outside = int(np.count_nonzero(((readings.y < low) | (readings.y > high)).any(axis=1)))
    if outside:
        notes.append(f'{outside} samples lie beyond the range of the joint ({low:g} to {high:g} '
                     'rad): its end stops are no part of the model, leave them out')
    return readings._replace(u=u, notes=[*notes, *readings.notes])


def _read_csv(path: Path, model: DriveModel) -> Readings:
    columns = read_csv(path)
    notes = list(columns.notices)
    if model.controller is None:
        u = columns.u * model.torque_constant
        if np.isnan(u).all() and not np.isnan(columns.setpoint).all():
            raise InputError(f'{path}: column setpoint without u, expected the key controller in '
                             'the model: it makes a torque of the setpoint')
        if not np.isnan(columns.setpoint).all():
            notes.append('column setpoint is not used: the model has no controller')
    else:
        u = columns.setpoint
        if np.isnan(u).all():
            raise InputError(f'{path}: no column setpoint, expected one with the controller in '
                             'the model; without the key controller (controller: null in '
                             '--values) the torque u is used')
        if not np.isnan(columns.u).all():
            notes.append('column u is not used: the setpoint drives the controller of the model')
    return Readings(columns.t, u, np.column_stack([columns.motor, columns.arm]),
                    columns.arm_torque, columns.place, notes)


def _read_bag(path: Path, model: DriveModel, args: Namespace) -> Readings:
    """Return the readings of a bag, t in ns, from its measurement topic alone."""
    with open_bag(path) as reader:
        topic = find_input(reader, args.topic).topic
        joints = [args.motor_joint, args.arm_joint]
        if model.controller is not None:
            joints.append(args.setpoint_joint)
        states = reader.joint_states(topic, joints)
        samples, _ = samples_of(states, model)
        require_samples(str(path), samples.stamp_ns, samples.y)
        notes = [reader.notice] if reader.notice else []

    def place(row: int, field: str) -> str:
        """Return where the value of field in a row stands."""
        return f'{topic}, sample {row}, {FIELDS[field]}'
    return Readings(samples.stamp_ns, samples.u[:, 0], samples.y, samples.u[:, 1], place, notes)


@contextmanager
def time_limit(seconds: float, option: str) -> Iterator[None]:
    """
    Raise Undecided when the block takes longer than so many `seconds`; inf: without a limit.

    Args:
        seconds: longest time, s.
        option: name of the option that sets it.
    """
    def _expired(*_: object) -> None:
        raise Undecided(f'{option} {seconds:g}: not finished after so many seconds, nothing is '
                        'written; expected a longer time, or fewer values and recordings')
    if math.isinf(seconds):
        yield
        return
    before = signal.signal(signal.SIGALRM, _expired)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
