# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Layouts under other names are read right or asked for, and a wrong reading is noticed."""
import mutated_layouts
import pytest
from script import run_script

from gearbox_monitor.recordings import roles

pytestmark = pytest.mark.system


def test_no_layout_is_wrong_in_silence(capsys, monkeypatch):
    assert run_script(mutated_layouts, ['--seed', '0']) == 0, capsys.readouterr().out
    monkeypatch.setattr(roles, 'MEASUREMENTS', (('setpoint',),))
    assert run_script(mutated_layouts, ['--seed', '0', '--only', 'kuka']) == 1
