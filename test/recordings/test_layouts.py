# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Roles of public log layouts: right, or asked for; never wrong in silence."""
import driver_layouts
import log_layouts
import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
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


@pytest.mark.parametrize('make', (*log_layouts.LAYOUTS, *driver_layouts.LAYOUTS),
                         ids=lambda make: make.__name__.strip('_'))
def test_roles_are_right_or_asked_for(tmp_path, capsys, make):
    if make.__name__ == '_aloha':
        pytest.importorskip('h5py')
    layout = make(tmp_path)
    code = main(['import', str(layout.path), '--guess'])
    out, errors = capsys.readouterr()
    content = yaml.safe_load(out) or {}
    assert code == (3 if layout.open else 0), errors
    verdict = verdict_of(layout, code, content, errors)
    assert verdict == ('asked' if layout.open else 'right'), errors
    # One call more answers everything, and the bag holds what was simulated.
    options = ['import', str(layout.path), '--guess', *layout.options, str(tmp_path / 'bag')]
    assert main(options) == 0, capsys.readouterr().err
    with open_bag(tmp_path / 'bag') as reader:
        joints = reader.joint_names('/joint_states')
        states = reader.joint_states('/joint_states', joints)
    moving = layout.roles.get('position', layout.roles.get('velocity'))
    assert len(joints) == max(2, len(moving)) or 'setpoint' in joints
    assert np.nanmax(np.abs(states.position)) < 8.0
