# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The catalogue of actuators: each entry loads, draws and is exported."""
from decimal import Decimal
from pathlib import Path
import re

import numpy as np
import pytest
import yaml

from benchmarks.actuators import SOURCES
import gearbox_monitor as gm
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import config_path
from gearbox_monitor.library.ranges import ranges_data
from gearbox_monitor.library.simulator_file import NAMES


def test_catalogue_has_the_entries_of_its_folder():
    folder = config_path(f'actuators/{NAMES[0]}.yaml').parent
    assert sorted(path.stem for path in folder.glob('*.yaml')) == sorted(NAMES) == sorted(SOURCES)


def test_entry_has_values_within_its_ranges_and_their_source():
    for name in NAMES:
        found = gm.load_actuator(name)
        stored = yaml.safe_load(config_path(f'actuators/{name}.yaml').read_text())
        assert ranges_data(found.ranges) == stored['ranges']
        i = found.ranges.names.index('Cc')
        assert found.ranges.low[i] < found.model.coulomb_friction < found.ranges.high[i]
        assert all(found.provenance.values())
        fitted, unseen = set(found.ranges.sources), set(found.held_out['recordings'])
        assert unseen and not fitted & unseen
        assert len(found.held_out['error']) == len(unseen)
        drawn = found.ranges.sample(2000, seed=1)['Cc']
        inside = (drawn >= found.ranges.low[i]) & (drawn <= found.ranges.high[i])
        assert np.mean(inside) == pytest.approx(0.9, abs=0.03)


def is_rounded(stated, value):
    """Return whether the number `stated` is `value` to the last digit of it."""
    half = 0.5 * 10.0 ** Decimal(stated).as_tuple().exponent
    return abs(float(stated) - value) <= 1.001 * half


def test_page_states_the_entry_and_what_is_open():
    for name in NAMES:
        page = (Path(__file__).parents[2] / 'docs/actuators.md').read_text()
        row, = re.findall(rf'^\| {name} \| (.*) \|$', page, re.MULTILINE)
        *cells, error = row.split(' | ')
        found = gm.load_actuator(name)
        model = found.model
        undetermined = {key for c in found.ranges.combinations for key in c.exponents}
        for cell, (key, value) in zip(cells, (
                ('m1', model.motor_inertia), ('Cc', model.coulomb_friction),
                ('Cv', model.viscous_friction), ('kt', model.torque_constant)), strict=True):
            stated = cell.split()[0]
            assert (stated == 'open') == (key in undetermined), key
            assert stated == 'open' or is_rounded(stated, value), key
        for stated, values in zip(error.split(' of '), ('error', 'motion'), strict=True):
            numbers = re.findall(r'[0-9.]+', stated)
            ends = min(found.held_out[values]), max(found.held_out[values])
            assert is_rounded(min(numbers, key=float), ends[0]), values
            assert is_rounded(max(numbers, key=float), ends[1]), values
        assert error.endswith(f' {found.held_out["unit"]}')


def test_unknown_name_lists_the_catalogue():
    with pytest.raises(InputError, match='davinci_backend'):
        gm.load_actuator('davinci')


@pytest.mark.parametrize('options', [['--to', 'urdf'], ['--to', 'yaml', '--ranges']])
def test_export_names_the_actuator_that_was_meant(options, capsys):
    assert main(['export', 'davinci_backnd', *options]) == 2
    assert capsys.readouterr().err == (
        "gearbox_monitor export: actuator: 'davinci_backnd', did you mean 'davinci_backend'?\n")


def test_export_takes_a_name_of_the_catalogue(capsys):
    for name in NAMES:
        arm = str(config_path('arm6.urdf'))
        model = gm.load_actuator(name).model
        code = main(['export', name, '--to', 'urdf', '--into', arm, '--joint', 'joint6'])
        shown = capsys.readouterr().out
        for value in (model.viscous_friction, model.coulomb_friction):
            assert f'"{value:.9g}"' in shown
        lacking = [line for line in shown.splitlines() if 'refused' in line]
        assert code == (1 if lacking else 0)
        loaded = any(e['id'] == 'load_friction' for e in model.effects)
        assert any('load_friction' in line for line in lacking) == loaded


def test_ranges_of_the_catalogue_are_exported(capsys):
    for name in NAMES:
        assert main(['export', name, '--to', 'yaml', '--ranges']) == 0
        assert yaml.safe_load(capsys.readouterr().out)['parameters']


def test_file_of_the_same_name_wins(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path('davinci_backend').write_text('motor_inertia: 0.5\ntransmission: {kind: rigid}\n')
    main(['export', 'davinci_backend', '--to', 'urdf', '--into', str(config_path('arm6.urdf')),
          '--joint', 'joint6'])
    shown = capsys.readouterr()
    assert 'the joint moves 0.523454' in ' '.join(shown.out.split())
    assert 'note: davinci_backend: the file of this name' in shown.err
