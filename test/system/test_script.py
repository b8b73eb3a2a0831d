# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command lines of the system tests: those in the pages can be typed as they stand."""
import argparse
import importlib
from pathlib import Path
import re
import shlex

import pytest
import script

ROOT = Path(__file__).parents[2]
PAGES = [*map(ROOT.joinpath, ('README.md', 'CONTRIBUTING.md', 'benchmarks/README.md')),
         *sorted((ROOT / 'docs').glob('*.md'))]
COMMANDS = sorted({match.group(0) for page in PAGES for match in re.finditer(
    r'\.venv/bin/python test/system/[^`#\n]*', page.read_text(encoding='utf-8'))})
NODES = ('load', 'robot', 'soak', 'restart')


def test_commands_in_the_pages_are_accepted():
    for command in COMMANDS:
        _, path, *arguments = shlex.split(command)
        assert (ROOT / path).is_file()
        name = Path(path).stem
        if name in NODES:
            pytest.importorskip('rclpy')
        parser = argparse.ArgumentParser()
        importlib.import_module(name).add_arguments(parser)
        parser.parse_args(arguments)


def test_the_exit_code_is_that_of_the_run(capsys, monkeypatch):
    fuzz = importlib.import_module('fuzz')
    assert script.run_script(fuzz, ['--seconds', '-1']) == 2
    assert capsys.readouterr().err == 'fuzz.py: --seconds: -1, expected a number > 0\n'
    for code in (0, 1):
        monkeypatch.setattr(fuzz, 'run', lambda args, code=code: code)
        assert script.run_script(fuzz, []) == code
