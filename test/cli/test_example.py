# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``example``: a bag and the model that made it, in which nothing is missing."""
from itertools import product
import json
import shlex

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import config_path, load_model
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.examples import ENCODERS, MOTIONS, process_torque

PACKAGED = str(config_path('drive.yaml'))
SHORT = ['--seconds', '8', '--rate', '500']
# Options that go round with the number of a combination, so that each meets each in the end.
WEAR, REST, RATE = ('0', '20'), ('2', '0'), ('500', '1000', '400')
MODELS = {
    'rigid': {'transmission': {'kind': 'rigid'}},
    'weight': {'effects': [{'id': 'gravity', 'G': 0.8, 'phi': 0.3}]},
    'servo': {'controller': {'kp': 6.0, 'kd': 0.15, 'torque_limit': 8.0}},
    'lag': {'effects': [{'id': 'actuator_lag', 'T': 0.004}]}}


def recorded(folder, capsys, *words):
    """Make a bag in `folder`; return (bag, its model file, the command that is printed)."""
    bag = folder / 'x'
    assert main(['example', str(bag), *words]) == 0
    command = next(line for line in capsys.readouterr().out.splitlines() if ' diagnose ' in line)
    return bag, folder / 'x.drive.yaml', shlex.split(command)[1:]


def verdict(command, capsys, *words):
    """Return (exit code, verdict as it is reported) of diagnose."""
    code = main([*command, '--json', '-', *words])
    return code, json.loads(capsys.readouterr().out)


def test_the_model_is_that_of_the_drive(tmp_path, capsys):
    """With its wear and its effects; the noise that its speeds have as the torque behind it."""
    stated = {**DriveModel().to_dict(), **MODELS['weight']}
    (tmp_path / 'm.yaml').write_text(yaml.safe_dump(stated))
    bag, written, command = recorded(
        tmp_path, capsys, '--model', str(tmp_path / 'm.yaml'), *SHORT, '--wear', '20',
        '--process-noise', '0.4')
    assert command == ['diagnose', str(bag), '--model', str(written)]
    model = load_model(written)
    assert model.transmission.half_gap == pytest.approx(0.12)
    assert [e['id'] for e in model.effects] == ['gravity']
    assert model.process_torque == pytest.approx(model.motor_inertia * 0.4 * 500 ** 0.5)
    assert main(['example', str(bag)]) == 2 and 'exists' in capsys.readouterr().err
    bag.rename(tmp_path / 'y')
    assert main(['example', str(bag)]) == 2
    assert 'x.drive.yaml: exists' in capsys.readouterr().err and not bag.exists()


def test_the_torque_that_is_stated_is_the_one_that_acts():
    """Of two runs of a drive without friction, their accelerations differ by it."""
    for name in ('rigid', 'weight'):
        model = model_from_dict({**MODELS[name], 'coulomb_friction': 0.0, 'viscous_friction': 0.0,
                                 'damping': 0.0, 'position_gain': 0.0, 'effects': []}, 'test')
        noise, dt = Noise((0.0, 0.0, 0.3, 0.0)), 2e-3
        x = simulate(model, np.zeros(20_000), dt, noise, 3).x
        inertia = model.motor_inertia + (model.arm_inertia if name == 'rigid' else 0.0)
        # Nothing is transmitted.
        slow = np.abs(x[:-1, 0] - x[:-1, 1]) <= model.transmission.half_gap
        torque = inertia * np.diff(x[:, 2])[slow] / dt
        assert torque.std() == pytest.approx(process_torque(model, noise, 1.0 / dt), rel=0.05)
        assert slow.sum() > 1000


@pytest.mark.parametrize('words', [
    ['--encoders', 'arm', '--rest', '2', '--motion', 'varied', '--seed', '4'],
    *(pytest.param(words, marks=pytest.mark.system) for words in (
        [], ['--encoders', 'motor', '--process-noise', '0.4', '--motion', 'varied']))],
    ids=' '.join)
def test_nothing_is_missing(words, tmp_path, capsys):
    *_, command = recorded(tmp_path, capsys, *SHORT, *words)
    code, data = verdict(command, capsys)
    assert (code, data['verdict']) == (0, 'none')


@pytest.mark.system
@pytest.mark.parametrize('motion, encoders, noise', [*product(MOTIONS, ENCODERS, ('0', '0.4'))])
def test_nothing_is_missing_in_any_combination(motion, encoders, noise, tmp_path, capsys):
    number = MOTIONS.index(motion) + 2 * list(ENCODERS).index(encoders)
    *_, command = recorded(
        tmp_path, capsys, '--seconds', '10', '--motion', motion, '--encoders', encoders,
        '--process-noise', noise, '--seed', str(number), '--wear', WEAR[number % 2], '--rest',
        REST[number // 2 % 2], '--rate', RATE[number % 3])
    code, data = verdict(command, capsys)
    assert (code, data['verdict']) == (0, 'none'), data['ranked'][:3]


@pytest.mark.system
@pytest.mark.parametrize('name, noise', [*product(MODELS, ('0', '0.4'))])
def test_nothing_is_missing_in_other_drives(name, noise, tmp_path, capsys):
    path = tmp_path / 'm.yaml'
    path.write_text(yaml.safe_dump(model_from_dict(MODELS[name], 'test').to_dict()))
    *_, command = recorded(tmp_path, capsys, '--model', str(path), '--seconds', '10', '--rate',
                           '500', '--motion', 'varied', '--process-noise', noise)
    code, data = verdict(command, capsys)
    assert (code, data['verdict']) == (0, 'none'), data['ranked'][:3]


@pytest.mark.system
def test_the_packaged_model_is_that_of_the_packaged_example(tmp_path, capsys):
    bag, written, command = recorded(tmp_path, capsys)
    assert load_model(written).exact() == load_model(PACKAGED).with_(process_torque=0.0).exact()
    code, data = verdict(['diagnose', str(bag), '--model', PACKAGED], capsys)
    assert (code, data['verdict']) == (0, 'none')
