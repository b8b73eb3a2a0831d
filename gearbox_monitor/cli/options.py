# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What commands share: how options are read, recordings and robots opened, results shown.

The options themselves are in commands.toml.
"""
from argparse import Action, Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
import os
from pathlib import Path
import re
import shlex
import shutil
import sys
from types import MappingProxyType
from typing import Any, TYPE_CHECKING

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import dump, load_model, load_parameters, plain, write_new
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.parameters import EstimatorParameters, resolve, SETTINGS
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.from_bag import ANY
from gearbox_monitor.recordings.guess import Answers, Guess
from gearbox_monitor.recordings.joint_input import (
    JointInput, NO_MODEL, read_snapshots, recorded_settings)
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.reading import open_recording, ReadOptions
from gearbox_monitor.signals.uniform import UniformRecording

if TYPE_CHECKING:
    from gearbox_monitor.library.recording import DriveRecording
    from gearbox_monitor.library.robot import Robot


def reading_of(args: Namespace) -> ReadOptions:
    """Return the ReadOptions in the options `args`. Raises InputError."""
    def pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
        found = {}
        for text in texts:
            name, equals, value = text.partition('=')
            if not equals or not name or not value:
                raise InputError(f'{option}: {text!r}, expected ROLE=VALUE')
            found[name] = value
        return found
    try:
        constants = [float(text) for text in args.torque_constant.split(',') if text]
    except ValueError:
        raise InputError(f'--torque-constant: {args.torque_constant!r}, expected numbers > 0 '
                         'with commas between them') from None
    for option, values in (('--torque-constant', constants),
                           ('--counts-per-turn', [args.counts_per_turn]), ('--rate', [args.rate])):
        for value in values:
            if value is not None and not 1e-100 < value < 1e100:
                raise InputError(f'{option}: {value:g}, expected > 0')
    return ReadOptions(args.map or '', tuple(args.set), Answers(
        pairs('--use', args.use), pairs('--unit', args.unit), tuple(constants),
        args.counts_per_turn, getattr(args, 'joint_of_log', None), args.columns, args.rate,
        args.episode, '' if args.stamps == 'recorded' else args.stamps))


def opened(args: Namespace) -> BagReader:
    """Return the recording that the options `args` name, of any kind, as a bag."""
    return open_recording(args.bag, reading_of(args), args.topic)


def table_text(guess: Guess) -> str:
    """Return the table of the columns of a guess, as wide as the terminal."""
    width = max(80, min(shutil.get_terminal_size((120, 24)).columns, 160))
    rows = [('column', 'role', 'unit', 'why'), *(
        tuple(cell or '-' for cell in row) for row in guess.rows)]
    first, second, third = (min(max(len(row[k]) for row in rows), room)
                            for k, room in enumerate((44, 18, 9)))
    return '\n'.join(f'{a[:first]:{first}s}  {b[:second]:{second}s}  {c[:third]:{third}s}  {d}'
                     [:width].rstrip() for a, b, c, d in rows)


def estimator_options(args: Namespace) -> tuple[dict[str, Any], str]:
    """Return (parameters without the model, model file or '') of `args`."""
    parameters = (load_parameters(args.params, 'estimator', SETTINGS, args.topic)
                  if args.params else {})
    recorded_file = parameters.pop('model', '')
    return parameters, args.model or recorded_file


def stated(args: Namespace, names: Iterable[str]) -> dict[str, Any]:
    """Return {option: value} of the attributes `names` of `args` that are not as by default."""
    actions: dict[str, Action] = {}
    for action in args.parser._actions:
        actions.setdefault(action.dest, action)
    return {(*actions[name].option_strings, name)[0]: getattr(args, name) for name in names
            if getattr(args, name) != actions[name].default}


def ids_in(words: Iterable[str]) -> list[str]:
    """Return the ids in `words`, each once, also those joined by commas."""
    return list(dict.fromkeys(name for part in words for name in part.split(',') if name))


def refuse(args: Namespace, names: Iterable[str], words: str) -> None:
    """Raise InputError with `words` where `args` state one of the options `names`."""
    for option in stated(args, names):
        raise InputError(f'{option}: {words}')


def warn(args: Namespace, notes: Iterable[str]) -> None:
    """Print on stderr what of the `notes` on the command `args` makes its figures doubtful."""
    if NO_MODEL in notes:
        print(f'gearbox_monitor {args.command}: warning: {NO_MODEL}', file=sys.stderr)


def write_folder(folder: str | Path, contents: Mapping[str, str]) -> list[Path]:
    """
    Write a new folder with all its files, or nothing; return the paths of these.

    Args:
        folder: that does not exist.
        contents: {name of a file: text}.

    Raises:
        InputError: the folder or a file cannot be written.
    """
    target = folder = Path(folder)
    paths = {folder / name: content for name, content in contents.items()}
    made = False
    try:
        folder.mkdir()
        made = True
        for target, content in paths.items():
            target.write_text(content, encoding='utf-8')
    except BaseException as error:
        if made:
            shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            raise InputError(f'{target}: {error.strerror}, expected a new, writable file') \
                from None
        raise
    return list(paths)


def show(args: Namespace, data: Mapping[str, Any] | Sequence[Any], text: Callable[[], str]
         ) -> None:
    """
    Print the result of a command, or write it, as its option --json says.

    Args:
        args: options; json: new file, or '-' for standard output, which then gets nothing else.
        data: the result as plain data.
        text: returns the lines for people.

    Raises:
        InputError: the file cannot be written.
    """
    content = dump(plain(data))
    if args.json == '-':
        print(content)
        return
    if args.json:
        write_new(args.json, content + '\n')
    print(re.sub(r'(?!\n|\x1b\[[\d;]*m)[\x00-\x1f\x7f-\x9f]', '?', text()))


def write_or_print(path: str | Path | None, text: str) -> None:
    """
    Write or print the whole output of a command.

    Args:
        path: new file, or None to print.
        text: the output.
    """
    if path is None:
        print(text, end='')
    else:
        write_new(path, text)
        print(f'written {path}')


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
    return load_recording(name, model, joints=joints, topic=args.topic, reading=reading_of(args))


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
    model, values = recorded_settings(
        read_snapshots(reader, source, not model_file), str(reader.path),
        load_model(model_file) if model_file else None, stated)
    values = {**usual, **values}
    values.pop('model', None)
    changed, parameters = resolve(reader.referred(model or DriveModel()), values,
                                  args.params or str(reader.path))
    return changed, parameters, model is not None
