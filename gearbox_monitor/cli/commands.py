# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The commands, their exit codes and their options, by commands.toml."""
import argparse
from collections.abc import Iterable
from importlib.resources import files
from pkgutil import resolve_name
import re
import tomllib
from typing import Any, TypeAlias

Row: TypeAlias = str | dict[str, Any]  # of options
TABLE: dict[str, Any] = tomllib.loads(
    files('gearbox_monitor.cli').joinpath('commands.toml').read_text(encoding='utf-8'))
SHARED: dict[str, list[Row]] = TABLE.pop('shared')
# command -> (module, one line of help); only the module of a requested command is imported
COMMANDS = {name: (entry.get('module', name), entry['says']) for name, entry in TABLE.items()}
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
