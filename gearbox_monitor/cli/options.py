# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Options that commands share, and how commands open recordings, write files and print."""
from argparse import Action, Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
import os
from pathlib import Path
import re
import shutil
import sys
import textwrap
from typing import Any

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import dump, plain, write_new
from gearbox_monitor.files.yaml_files import expect_folder_of, expect_new, load_parameters
from gearbox_monitor.parameters import SETTINGS
from gearbox_monitor.presentation import on_axis, Said
from gearbox_monitor.recordings.guess import Answers, Guess
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.reading import open_recording, ReadOptions
from gearbox_monitor.recordings.recorded_samples import NO_MODEL
from gearbox_monitor.report.sentences import title


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


def wrapped(words: str, first: str = '', further: str = '') -> list[str]:
    """Return `words` in lines of at most 80 columns, which `first` and `further` begin."""
    return textwrap.wrap(words, 80, initial_indent=first, subsequent_indent=further,
                         break_on_hyphens=False)


def entries(rows: Iterable[tuple[str, str]], wide: int = 13) -> list[str]:
    """Return lines with the words of each of `rows` behind its label of `wide` columns."""
    return [line for label, words in rows if words
            for line in wrapped(words, f'{label:<{wide}s}', ' ' * wide)]


def labelled(says: Iterable[Said], axis: str) -> Iterator[tuple[str, str]]:
    """Yield the rows of `entries` for codes on a drive with `axis`, each label once in a row."""
    before = ''
    for said in says:
        label = on_axis(title(said.code), axis)
        yield ('' if label == before else label), str(said)
        before = label


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


def expect_new_files(folder: str | None, names: Iterable[str]) -> None:
    """Raise InputError unless the files `names` in `folder` can be new; None: no folder."""
    expect_new(*(Path(folder) / name for name in names if folder))
    expect_folder_of(folder)
    if folder and Path(folder).exists() and not Path(folder).is_dir():
        raise InputError(f'{folder}: is a file, expected a directory')


def write_files(contents: Mapping[Path, str], folder: str | None = None) -> list[Path]:
    """
    Write all files or none; return their paths.

    Args:
        contents: {path: text}.
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
            parts[target].write_text(content, encoding='utf-8')
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
