# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Roles of public log layouts: right, or asked for; never wrong in silence."""
from functools import cache

import driver_layouts
import log_layouts
import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.recordings import reading
from gearbox_monitor.recordings.read import open_bag

OF_DRIVE = {'motor_position': 'position', 'motor_velocity': 'velocity', 'motor_effort': 'effort',
            'motor_setpoint': 'setpoint', 'arm_position': 'position',
            'arm_velocity': 'velocity'}


def assigned(content):
    """Return ({quantity: names or numbers of columns by joint}, {quantity: unit}) of a mapping."""
    columns, units = {}, {}
    joints = dict(content.get('joints') or {'': {
        OF_DRIVE.get(name, name): block
        for name, block in (content.get('signals') or {}).items()}})
    for signals in joints.values():
        for quantity, block in signals.items():
            columns.setdefault(quantity, []).append(
                str(block['column']).removeprefix('setpoint: '))
            units[quantity] = block.get('unit', '')
    return columns, units


def verdict_of(layout, code, content, errors):
    """Return 'right', 'asked' or what is wrong of the mapping `content` proposed for `layout`."""
    columns, units = assigned(content)
    wrong = []
    for quantity, names in columns.items():
        truth = layout.roles.get(quantity)
        options = truth if isinstance(truth, tuple) else (truth,)
        if quantity == 'effort' and 'effort' in layout.open and code == 3:
            continue
        if not any(option is not None and _same(names, option) for option in options):
            wrong.append(f'{quantity}: {names[:3]} for {truth and truth[:3]}')
    for quantity in layout.roles:
        if quantity not in columns and not (code == 3 and layout.open):
            wrong.append(f'{quantity}: none')
    for quantity, unit in layout.units.items():
        if quantity in units and units[quantity] != unit and code != 3:
            wrong.append(f'{quantity}: {units[quantity]!r} for {unit!r}')
    return '; '.join(wrong) or ('asked' if code == 3 else 'right')


def _same(names, truth):
    """Return whether columns are those of the truth; numbers stand in for names without header."""
    return len(names) == len(truth) and all(
        name.startswith(true) or name.isdigit() for name, true in zip(names, truth))


def test_roles_are_right_or_asked_for(new_folder, capsys, monkeypatch):
    pytest.importorskip('h5py')
    monkeypatch.setattr(reading, 'load_table', cache(reading.load_table))  # read once
    for make in (*log_layouts.LAYOUTS, *driver_layouts.LAYOUTS):
        folder = new_folder()
        layout = make(folder)
        code = main(['import', str(layout.path), '--guess'])
        out, errors = capsys.readouterr()
        content = yaml.safe_load(out) or {}
        assert code == (3 if layout.open else 0), (make, errors)
        verdict = verdict_of(layout, code, content, errors)
        assert verdict == ('asked' if layout.open else 'right'), (make, errors)
        # One call more answers everything, and the bag holds what was simulated.
        options = ['import', str(layout.path), '--guess', *layout.options, str(folder / 'bag')]
        assert main(options) == 0, (make, capsys.readouterr().err)
        capsys.readouterr()
        with open_bag(folder / 'bag') as reader:
            joints = reader.joint_names('/joint_states')
            states = reader.joint_states('/joint_states', joints)
        moving = layout.roles.get('position', layout.roles.get('velocity'))
        assert len(joints) == max(2, len(moving)) or 'setpoint' in joints, make
        assert np.nanmax(np.abs(states.position)) < 8.0, make
