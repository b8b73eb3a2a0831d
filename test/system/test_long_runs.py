# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The system tests in full, as developers run them before a release: pytest -m system."""
from pathlib import Path
import subprocess
import sys

import pytest

FOLDER = Path(__file__).parent
OFFLINE = [('fuzz', ['--seconds', '300']), ('faults', ['--seeds', '2']), ('scale', []),
           ('fleet', []), ('motion', []), ('wear', ['--seeds', '0', '200']),
           ('wear', ['--healthy', '24', '--seeds', '0', '1'])]
NODES = {'load': [], 'soak': ['--minutes', '20', '--rate', '1000'], 'restart': ['--times', '50'],
         'recorder': ['--kills', '100'], 'faults': ['--only', 'none', '--node', '64']}
pytestmark = [pytest.mark.system, pytest.mark.timeout(7200)]


def run(name, arguments):
    return subprocess.run([sys.executable, FOLDER / f'{name}.py', *arguments]).returncode


@pytest.mark.parametrize('name, arguments', OFFLINE)
def test_offline_runs_meet_their_bars(name, arguments):
    assert run(name, arguments) == 0


@pytest.mark.ros
@pytest.mark.parametrize('name', NODES)
def test_live_nodes_meet_their_bars(name):
    pytest.importorskip('rclpy')
    assert run(name, NODES[name]) == 0
