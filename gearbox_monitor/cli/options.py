# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The exit codes of all commands: --help shows them, docs/README.md and a test agree with them."""
import argparse
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
import sys
import textwrap
from typing import Any, TYPE_CHECKING

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.files.opening import dump, plain, write_new
from gearbox_monitor.files.yaml_files import expect_folder_of, expect_new, load_parameters
from gearbox_monitor.parameters import FILTER_NAMES, SETTINGS
from gearbox_monitor.recordings.recorded_samples import NO_MODEL
from gearbox_monitor.recordings.topics import JOINT_STATES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BAG_HELP = 'bag directory or .mcap file, complete or truncated'
JSON_FILE_HELP = '; - prints it, and nothing else'


def add_estimator_arguments(parser: ArgumentParser) -> None:
    """Declare in `parser` the bag and what an estimator is run with."""
    parser.add_argument('bag', metavar='BAG', help=BAG_HELP)
    parser.add_argument('--model', metavar='FILE', help='model file of the drive')
    parser.add_argument('--params', metavar='FILE', help='ROS parameter file of the estimator')
    parser.add_argument('--topic', default=JOINT_STATES, help='topic of the inputs')


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


def wrapped(words: str, first: str = '', further: str = '') -> list[str]:
    """Return `words` in lines of at most 80 columns, which `first` and `further` begin."""
    return textwrap.wrap(words, 80, initial_indent=first, subsequent_indent=further,
                         break_on_hyphens=False)


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


def check_filter(name: str, extra: Sequence[str] = ()) -> str:
    """Return the `name` of a filter, one of those of `extra`, too. Raises InputError."""
    names = (*FILTER_NAMES, *extra)
    if name not in names:
        raise InputError(f'filter: {name!r}, expected one of {", ".join(names)}')
    return name


def expect_new_files(folder: str | None, names: Iterable[str], file: str | None) -> None:
    """
    Raise InputError unless the files `names` in `folder`, and `file`, can be new ones.

    None: no folder, no file; '-' is standard output.
    """
    expect_new(*(Path(folder) / name for name in names if folder), file)
    expect_folder_of(folder)
    expect_folder_of(file)
    if folder and Path(folder).exists() and not Path(folder).is_dir():
        raise InputError(f'{folder}: is a file, expected a directory')


def write_files(contents: 'Mapping[Path, str | Figure]', folder: str | None = None) -> list[Path]:
    """
    Write all files or none; return their paths.

    Args:
        contents: {path: text or picture}.
        folder: of some of them, made where there is none.

    Raises:
        InputError: a file cannot be written.
    """
    new_folder = Path(folder) if folder and not Path(folder).exists() else None
    parts = {path: path.with_name(f'.{path.name}.{os.getpid()}.part') for path in contents}
    target = new_folder or Path()
    try:
        if new_folder is not None:
            new_folder.mkdir()
        for target, content in contents.items():
            if isinstance(content, str):
                parts[target].write_text(content, encoding='utf-8')
            else:
                content.savefig(parts[target], dpi=110, format='png')
        for target, part in parts.items():
            os.replace(part, target)
    except OSError as error:
        raise InputError(f'{target}: {error.strerror}, expected a new, writable file') from None
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
        if new_folder is not None and new_folder.is_dir() and not any(new_folder.iterdir()):
            new_folder.rmdir()
    return list(contents)


def show(args: Namespace, data: Mapping[str, Any] | Sequence[Any], text: Callable[[], str],
         replaces: bool = False) -> None:
    """
    Print the result of a command, or write it, as its option --json says.

    Args:
        args: options; json: whether JSON is printed, or the file that it is written to, '-' for
            standard output, where nothing else is printed then.
        data: the result as plain data.
        text: returns the lines for people.
        replaces: whether the file may be one that exists.

    Raises:
        InputError: the file cannot be written.
    """
    content = dump(plain(data))
    if args.json in (True, '-'):
        print(content)
        return
    if args.json:
        try:
            with open(args.json, 'w' if replaces else 'x', encoding='utf-8') as file:
                file.write(content + '\n')
        except OSError as error:
            raise InputError(f'{args.json}: {error.strerror}, expected a '
                             f'{"" if replaces else "new, "}writable file') from None
    print(text())


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


def add_ros_option(parser: argparse.ArgumentParser) -> None:
    """Declare --ros-args in `parser`; it takes the rest of the command line."""
    parser.add_argument('--ros-args', nargs=argparse.REMAINDER, default=[],
                        help='arguments for ROS, such as remappings')


def ros_words(args: argparse.Namespace) -> list[str]:
    """Return the words of --ros-args as rclpy.init takes them."""
    return ['--ros-args', *args.ros_args] if args.ros_args else []


@contextmanager
def rclpy_required() -> Iterator[None]:
    """Raise InputError if an import in the block fails."""
    try:
        yield
    except ImportError as error:
        raise InputError(f'rclpy: not installed here ({error}), expected a sourced ROS 2 or '
                         f'{installed_by("ros")}') from None
