# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write commands.md from the commands and their exit codes: python docs/make_commands.py."""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from gearbox_monitor.cli.main import COMMANDS, EXIT_CODES  # noqa: E402

PAGE = ROOT / 'docs/commands.md'
HEAD = """\
# Commands

`docs/make_commands.py` generates this page. `gearbox_monitor COMMAND --help` shows options and
examples. All but `export` and `live` take `--json [FILE]`, for programs.

Codes of every command: 0 success, 2 bad usage or bad input (one line on stderr), 130 Ctrl-C
(`live`: 0). Code 1 is a finding that requires action, code 3 means undecided: the input
is valid but does not answer the question.

| command | what | exit codes 1 and 3 |
|---|---|---|
"""


def page():
    """Return the text of the page."""
    rows = []
    for name, (_, _, summary) in COMMANDS.items():
        codes = '; '.join(f'{code}: {meaning}' for code, meaning in EXIT_CODES.get(
            name, {}).items() if code in (1, 3))
        rows.append(f'| `gearbox_monitor {name}` | {summary} | {codes} |\n')
    return HEAD + ''.join(rows)


if __name__ == '__main__':
    PAGE.write_text(page(), encoding='utf-8')
