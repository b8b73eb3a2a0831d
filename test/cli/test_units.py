# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Units: what commands, pages and errors say of a drive with a prismatic axis."""
import re

import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.presentation import on_axis

ROTARY = re.compile(r'\b[mk]?(rad|N m|kg m\^2|arcmin)\b')
MODEL = 'axis: prismatic\neffects: [{id: load_torque, TL: 0.8}]\n'


LABELS = [
    ('N m s/rad', 'N s/m'), ('N m/rad^3', 'N/m^3'), ('kg m^2', 'kg'), ('rad/s^2', 'm/s^2'),
    ('N m per N m', 'N per N'), ('probably in mN m', 'probably in mN'), ('1/rev', '1/rev'),
    ('torque u (N m), not torque_offset or --max-torque',
     'force u (N), not torque_offset or --max-torque'),
    ('angle of a triangle', 'position of a triangle')]


def test_labels():
    for rotary, prismatic in LABELS:
        assert on_axis(rotary, 'prismatic') == prismatic
        assert on_axis(rotary, 'rotary') == rotary


def test_every_unit_of_the_library_has_a_prismatic_one():
    units = {p.unit for effect in EFFECTS.values() for p in effect.parameters}
    assert not [u for u in units if ROTARY.search(on_axis(u, 'prismatic'))]


@pytest.mark.system
def test_no_command_says_rad_of_a_prismatic_axis(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'true.yaml').write_text(MODEL)
    (tmp_path / 'drive.yaml').write_text('axis: prismatic\n')
    (tmp_path / 'bad.yaml').write_text(
        'axis: prismatic\nmotor_inertia: -1\ntransmission: {stiffness: 0}\n'
        'effects: [{id: gravity, G: x}]\n')
    assert main(['example', 'run', '--model', 'true.yaml', '--seconds', '9', '--rate', '250',
                 '--process-noise', '0']) == 0
    drive = ['--model', 'drive.yaml']
    said = {}
    for words in (
            ['check', 'run', *drive], ['replay', 'run', *drive],
            ['accept', 'run', *drive, '--max-gap', '0.3'],
            ['fit', 'model', 'run', '--model', 'true.yaml', '--free', 'm1', 'b', 'load_torque'],
            ['diagnose', 'run', *drive, '--only', 'load_torque', 'arm_coulomb', '--out', 'found'],
            ['check', 'run', '--model', 'bad.yaml']):
        code = main(words)
        out, err = capsys.readouterr()
        assert code in (0, 1) or words[-1] == 'bad.yaml', err
        said[words[0]] = out + err
    said['page'] = re.sub(r'<script.*?</script>|<style.*?</style>', '', (
        tmp_path / 'found/report.html').read_text(encoding='utf-8'), flags=re.DOTALL)
    for what, text in said.items():
        assert not ROTARY.findall(text), (what, ROTARY.search(text))
    assert re.search(r'm1 .* kg', said['fit'])
    assert 'load_torque TL = 0.' in said['diagnose'] and '(kg)' in said['check']
    assert 'constant force on the arm' in said['page'].lower()
