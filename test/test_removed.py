# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Every name that is gone is refused, with its advice, wherever a user may still type it."""
from pathlib import Path

import pytest

import gearbox_monitor
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError, refusal, removed
from gearbox_monitor.parameters import check_values, SETTINGS
from gearbox_monitor.simulators.user_simulator import user_simulator


OURS = 'gearbox_monitor '


def test_options_and_their_values(capsys):
    for name in removed():
        if ' ' not in name or name.startswith(OURS):
            continue
        with pytest.raises(SystemExit, match='2'):
            main(name.split())
        line, = capsys.readouterr().err.splitlines()
        assert refusal(name) in line


FILES = [
    ('arm.sdf', gearbox_monitor.load_model), ('arm.sdf', gearbox_monitor.load_robot),
    ('unit.fmu', user_simulator)]


def test_files_by_their_ending():
    for file, read in FILES:
        with pytest.raises(InputError) as caught:
            read(file)
        assert str(caught.value).endswith(f'{file}: {refusal(Path(file).suffix)}')


def test_commands_parameters_and_names_of_the_package(capsys):
    for name in removed():
        if name.startswith('.') or ' ' in name and not name.startswith(OURS):
            continue
        if name.startswith(OURS):
            command = name.removeprefix(OURS)
            assert main([command]) == 2
            assert capsys.readouterr().err == f'gearbox_monitor: {command}: {refusal(name)}\n'
            continue
        with pytest.raises(InputError, match='file: ') as caught:
            check_values(SETTINGS, {name: 1}, 'file')
        assert refusal(name) in str(caught.value)
        with pytest.raises(AttributeError) as missing:
            getattr(gearbox_monitor, name)
        assert refusal(name) in str(missing.value)
