# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What `compile` runs, and what it need not run again."""
from subprocess import CompletedProcess

import pytest

from gearbox_monitor.cli import compile_
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.jit import COMPILED


@pytest.mark.skipif(not COMPILED, reason='numba is not in use')
def test_each_command_and_filter_is_run_once_for_a_state_of_the_sources(
        monkeypatch, tmp_path, capsys):
    lines, code = [], 0

    def in_child(function, *arguments, folder):
        lines.append(arguments[0] if len(arguments) == 1 else arguments[1].filter)
        return CompletedProcess([], code, stderr=b'...\ntoo short\n')
    monkeypatch.setattr(compile_, 'in_child', in_child)
    monkeypatch.setattr(compile_, 'CACHE_FOLDER', str(tmp_path))
    monkeypatch.setattr(compile_, '_state', lambda: 'one')
    assert main(['compile', 'node', 'replay', '--filter', 'ukf', 'ekf']) == 0
    assert [line.split()[0] for line in lines] == [
        'ukf', 'ekf', 'example', 'replay', 'example', 'replay']
    assert main(['compile', 'node', '--filter', 'ekf']) == 0 and len(lines) == 6
    assert 'node ekf: is compiled' in capsys.readouterr().out
    monkeypatch.setattr(compile_, '_state', lambda: 'another')
    code = 1  # of a traceback
    assert main(['compile', 'node']) == 2 and lines[6:] == ['ekf']
    assert 'node: ended with exit code 1: too short' in capsys.readouterr().err
    assert main(['compile', 'check']) == 2 and len(lines) == 8  # the bag that it needs
    assert 'example: ended with exit code 1: too short' in capsys.readouterr().err
    assert main(['compile', 'nodes']) == 2 and main(['compile', '--filter', 'kalman']) == 2


def test_a_finding_is_done_and_a_crash_is_none(monkeypatch, tmp_path):
    monkeypatch.setattr(compile_.command_line, 'main', lambda words: 1)
    assert compile_._run_line('diagnose bag') == 0
    with pytest.raises(InputError, match='check: ended with exit code 1: ValueError: crash'):
        compile_._call('check', str(tmp_path), exec, 'raise ValueError("crash")')
