# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Commands never run with a model or parameters that nobody asked for without a word."""
import json

import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.recordings.joint_input import NO_MODEL

COMMANDS = {
    'replay': ['--estimates-only', '--json'], 'accept': ['--max-gap', '0.3', '--json'],
    'report': ['--json', '-', '--out', 'x.html']}


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp('settings') / 'bag'
    write_example_bag(path, DriveModel(), ExampleMotion(4.0, 500.0))
    return str(path)


@pytest.mark.parametrize('command', COMMANDS)
def test_the_packaged_drive_is_never_used_without_a_word(bag, tmp_path, capsys, monkeypatch,
                                                         command):
    for model in ([], ['--model', str(config_path('drive.yaml'))]):
        monkeypatch.chdir(tmp_path)
        main([command, bag, *COMMANDS[command], *model])
        shown = capsys.readouterr()
        said = NO_MODEL in json.loads(shown.out)['notes']
        warned = f'gearbox_monitor {command}: warning: {NO_MODEL}\n' in shown.err
        assert said == warned == (not model)
        (tmp_path / 'x.html').unlink(missing_ok=True)
