# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The command line ``gearbox_monitor``: runs a subcommand of commands.toml.

Only the module of that command is imported. Errors become the exit code.
"""
import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
import contextlib
import importlib
from importlib.resources import files
import inspect
from itertools import takewhile
import os
from pkgutil import resolve_name
import re
import sys
import textwrap
import tomllib
from typing import Any, NoReturn, TypeAlias
import warnings

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, refusal, Undecided, unknown

BAD_INPUT, UNDECIDED, INTERRUPTED = 2, 3, 130
Row: TypeAlias = str | dict[str, Any]  # of options
TABLE: dict[str, Any] = tomllib.loads(
    files('gearbox_monitor.cli').joinpath('commands.toml').read_text(encoding='utf-8'))
SHARED: dict[str, list[Row]] = TABLE.pop('shared')
# command -> (module, function, one line of help)
COMMANDS = {name: (*entry.get('runs', f'{name}:run').split(':'), entry['says'])
            for name, entry in TABLE.items()}
# command -> meaning of its codes
EXIT_CODES = {name: {int(code): words for code, words in entry['exit'].items()}
              for name, entry in TABLE.items() if 'exit' in entry}
TYPES = {'int': int, 'float': float}
_KNOWN = re.compile(r'\$\{([\w.]+:\w+)\}')


def declare(parser: Any, rows: Iterable[Row]) -> None:
    """Declare in `parser`, or a group of one, the options `rows` of commands.toml."""
    for row in rows:
        if isinstance(row, str):
            declare(parser, SHARED[row])
        elif 'options' in row:
            declare(parser.add_argument_group(row['group']) if 'group' in row else
                    parser.add_mutually_exclusive_group(), row['options'])
        else:
            given = {key: _KNOWN.sub(_words, value) if key == 'help' else _known(value)
                     for key, value in row.items()}
            if 'type' in given:
                given['type'] = TYPES.get(given['type'], given['type'])
            parser.add_argument(*given.pop('name').split(), **given)


def _known(value: Any) -> Any:
    """Return the object that a `value` names, else the value."""
    named = _KNOWN.fullmatch(value) if isinstance(value, str) else None
    return resolve_name(f'gearbox_monitor.{named[1]}') if named else value


def _words(match: re.Match[str]) -> str:
    """Return the object that a `match` names, in words."""
    known = resolve_name(f'gearbox_monitor.{match[1]}')
    return ', '.join(known) if isinstance(known, tuple) else format(
        known, 'g' if isinstance(known, float) else '')


def declared(parser: argparse.ArgumentParser, command: str) -> None:
    """Declare in `parser` the options of a `command`, and --json."""
    declare(parser, TABLE[command]['options'])
    if TABLE[command].get('json', True):
        parser.add_argument('--json', metavar='FILE', nargs='?', const='-',
                            help='write the result as JSON; - or nothing prints it alone')


def commands_text() -> str:
    """Return the commands in their groups, one line each."""
    lines: list[str] = []
    for name, entry in TABLE.items():
        if entry['group'] not in lines:
            lines.append(entry['group'])
        lines.append(f'  {name:12s} {entry["says"]}')
    return '\n'.join(lines)


def exit_code_text(meanings: Mapping[int, str]) -> str:
    """Return the lines of --help about exit codes, `meanings` by code; 2 and 130 are added."""
    codes = {BAD_INPUT: 'bad usage or input', **meanings}
    if 'Ctrl-C' not in codes[0]:
        codes[INTERRUPTED] = 'ended by Ctrl-C'
    words = '; '.join(f'{code} {meaning}' for code, meaning in sorted(codes.items()))
    return textwrap.fill(f'exit code: {words}', 80)


ENDS = ('--', '--ros-args')  # end the options of the command


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line, as those of bad input."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse a mistyped option in `args`, as --modle, before `namespace` misses one."""
        if self._subparsers is None:
            for word in takewhile(lambda word: word not in ENDS, args):
                name = word.partition('=')[0]
                if name.startswith('--') and not any(
                        option.startswith(name) for option in self._option_string_actions):
                    self.refuse(name)
        return super().parse_known_args(args, namespace)

    def refuse(self, option: str) -> NoReturn:
        """Refuse an `option` that the command does not have."""
        self.error(f'{option}: no option of this command, '
                   + unknown(option, self._option_string_actions, self._command))

    @property
    def _command(self) -> str:
        return self.prog.removeprefix('gearbox_monitor ')

    def error(self, message: str) -> NoReturn:
        """Print `message` in the words of other bad input, and end with exit code 2."""
        words = in_own_words(message, self._command)
        self.exit(BAD_INPUT, f'{self.prog}: {words}; see {self.prog} --help\n')


# What argparse says, and how all other errors say it.
SAYINGS = (
    (r'the following arguments are required: (.*)', r'\1: missing'),
    (r'one of the arguments (.*) is required', r'expected one of \1'),
    (r'argument ([^:]+): invalid int value: (.*)', r'\1: \2, expected a whole number'),
    (r'argument ([^:]+): invalid float value: (.*)', r'\1: \2, expected a number'),
    (r'argument ([^:]+): expected (\d+ arguments)', r'\1: expected \2'),
    (r'argument ([^:]+): expected (.*)', r'\1: no value, expected \2'),
    (r'argument ([^:]+): not allowed with argument (.*)', r'\1 and \2 exclude each other'),
    (r'ambiguous option: (.*) could match (.*)', r'\1: expected one of \2'),
    (r'argument ([^:]+): (.*)', r'\1: \2'))


def in_own_words(message: str, command: str) -> str:
    """Return a `message` of argparse on a `command` as other errors are worded."""
    choice = re.fullmatch(r"argument ([^:]+): invalid choice: '?(.*?)'? \(choose from (.*)\)",
                          message)
    if choice:
        names = re.findall(r"[^', ]+", choice[3])
        place = f'{command} {choice[1]}'
        return f'{choice[1]}: {choice[2]!r}, {unknown(choice[2], names, place)}'
    for pattern, words in SAYINGS:
        if match := re.fullmatch(pattern, message):
            return match.expand(words)
    return message


def parsed_whole(parser: argparse.ArgumentParser,
                 subparsers: 'argparse._SubParsersAction[Any]',
                 argv: Sequence[str]) -> argparse.Namespace:
    """
    Return the parsed `argv`; its subcommand refuses the first word that it does not take.

    Args:
        parser: of the command line.
        subparsers: of its subcommands.
        argv: words of the command line.
    """
    args, unparsed = parser.parse_known_args(argv)
    if unparsed:
        chosen = subparsers.choices[getattr(args, subparsers.dest)]
        word = unparsed[0].partition('=')[0]
        if word.startswith('-'):
            chosen.refuse(word)
        chosen.error(f'{word}: one argument too many, expected none')
    return args


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run one subcommand with `argv`, or the arguments of the process.

    Returns its exit code, see EXIT_CODES.
    """
    if argv is None:
        argv = sys.argv[1:]
        if not sys.warnoptions:  # of numpy and others: for developers, who ask with python -W
            warnings.simplefilter('ignore')
            os.environ.setdefault('PYTHONWARNINGS', 'ignore')  # of the processes of the command
    if not argv:
        print(f'{commands_text()}\n\ngearbox_monitor COMMAND --help shows options and examples.')
        return 0
    command = next((word for word in argv if not word.startswith('-')), None)
    if gone := refusal(f'gearbox_monitor {command}'):
        print(f'gearbox_monitor: {command}: {gone}', file=sys.stderr)
        return BAD_INPUT
    return run_parsed(f'gearbox_monitor {command}', lambda: _parse(argv, command),
                      '' if command == 'live' else str(command))


def run_parsed(name: str, parse: Callable[[], argparse.Namespace], timed: str = '') -> int:
    """
    Run what a command line asks for, and turn errors into exit codes.

    Args:
        name: of the command, at the head of its messages.
        parse: returns the parsed command line; its `run` takes it and returns an exit code.
        timed: shown with the elapsed time; '' for a command that shows its progress itself.

    Returns:
        The exit code, see EXIT_CODES.
    """
    for stream in ('stdout', 'stderr'):
        if getattr(sys, stream) is None:  # closed by the shell: what is printed goes nowhere
            setattr(sys, stream, open(os.devnull, 'w', encoding='utf-8'))
    try:
        args = parse()
        from gearbox_monitor.library.progress import shown_time
        with shown_time(timed) if timed else contextlib.nullcontext():
            code: int = args.run(args) or 0
            return code
    except InputError as error:
        if guess := getattr(error, 'guess', None):  # what was recognised of a log
            from gearbox_monitor.cli.options import table_text
            print(table_text(guess), file=sys.stderr)
        print(f'{name}: {error}', file=sys.stderr)
        return UNDECIDED if isinstance(error, Undecided) else BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # the reader of the output has ended (| head)
        sys.stderr.close()
        return 0


def _parse(argv: Sequence[str], command: str | None) -> argparse.Namespace:
    """Return the parsed `argv`; only the module of `command` is imported."""
    parser = OneLineParser(
        prog='gearbox_monitor', description='Condition monitor for robot joint gearboxes.',
        formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f'{commands_text()}\n\n' + (
            'exit code: 0 done, 1 a finding that asks for action, 2 bad usage or input,\n'
            '3 undecided, 130 ended by Ctrl-C'))
    parser.add_argument('--version', action='version', version=__version__)
    subparsers = parser.add_subparsers(dest='command', metavar='COMMAND', required=True,
                                       help='one of those below; COMMAND --help shows its options')
    for name, (module, function, _) in COMMANDS.items():
        sub = subparsers.add_parser(
            name, epilog=exit_code_text(EXIT_CODES.get(name, {0: 'done'})),
            formatter_class=argparse.RawDescriptionHelpFormatter)
        if name == command:
            # Small matrices, and fits in own threads: threads of BLAS would only slow them down.
            os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
            shell = importlib.import_module('gearbox_monitor.cli.' + module)
            run = getattr(shell, function)
            # A further command of a module has its help in its function.
            sub.description = shell.__doc__ if function == 'run' else inspect.getdoc(run)
            declared(sub, name)
            sub.set_defaults(run=run, parser=sub)
    args = parsed_whole(parser, subparsers, argv)
    if file := getattr(args, 'json', None):
        from gearbox_monitor.files.user_files import expect_new_file
        expect_new_file(file)
    return args


if __name__ == '__main__':
    sys.exit(main())
