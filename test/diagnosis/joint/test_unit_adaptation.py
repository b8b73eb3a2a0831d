# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``adapt``: values of a unit, what stays open, and how it estimates another run."""
from dataclasses import replace
import json

import numpy as np
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.joint.nominal import (
    _tolerances, FittedValue, NominalFit, samples_of)
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.files.user_files import config_path, load_model, load_parameters
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.signals.uniform import UniformRecording

UNIT = DriveModel().with_(motor_inertia=0.0070, coulomb_friction=0.33, viscous_friction=0.08,
                          stiffness=29.0, half_gap=0.12, arm_load='none')


def test_what_is_not_determined_keeps_the_wider_tolerance():
    def value(name, error, determined=True):
        return FittedValue(name, '', 1.0, 1.0, error, determined)
    model = DriveModel().with_(friction_tolerance=0.0, torque_gain_tolerance=0.0,
                               damping_tolerance=0.5, inertia_tolerance=0.4)
    fit = NominalFit(model, [value('m1', 1e-3), value('m2', 0.05), value('Cv', 0.01),
                             value('D', 0.3, False), value('Cc', 1e-4)], [], 3.0, 2.0)
    tolerances = _tolerances(model, fit)
    assert tolerances['inertia_tolerance'] == pytest.approx(np.sqrt(3.0) * 2.0 * 0.05, rel=0.01)
    assert tolerances['friction_tolerance'] == 0.02  # nothing is that exact every day
    assert tolerances['damping_tolerance'] == 0.5 and tolerances['torque_gain_tolerance'] == 0.1
    assert _tolerances(model, None) == {
        'friction_tolerance': 0.3, 'damping_tolerance': 0.5, 'inertia_tolerance': 0.4,
        'torque_gain_tolerance': 0.1, 'delay_tolerance': 0.002,
        'encoder_delay_tolerance': 0.002}


@pytest.mark.system
def test_a_unit_is_adapted_to(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_example_bag(tmp_path / 'run', UNIT, ExampleMotion(20.0, 500.0))
    (tmp_path / 'start.yaml').write_text(
        'estimator: {ros__parameters: {arm_load: none}}\n')
    assert main(['fit', 'unit', 'run', '--model', str(config_path('drive.yaml')), '--params',
                 'start.yaml', '--out', 'unit', '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert any('torque constant' in sentence for sentence in said['open'])
    model = load_model('unit/drive.yaml')
    for name in ('motor_inertia', 'coulomb_friction', 'viscous_friction'):
        truth = getattr(UNIT, name)
        assert abs(getattr(model, name) - truth) < 0.5 * abs(getattr(DriveModel(), name) - truth)
    assert model.transmission.stiffness == pytest.approx(29.0, rel=0.05)
    assert model.torque_gain_tolerance == 0.1 and model.damping_tolerance < 0.3
    u = 1.1 * Excitation().torque(np.arange(10_000) * 1e-3)
    run = simulate(UNIT, u, 1e-3, Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), 7)
    recording = UniformRecording(np.arange(len(u)) * 1e-3, u, run.y, 1e-3)
    parameters = load_parameters('unit/params.yaml', 'estimator', ESTIMATOR)
    parameters.pop('model')
    assert parameters['tau_k_model'] == 'mixed'
    errors = {}
    for name, (one, values) in {'adapted': (model, parameters), 'before': (
            load_model(config_path('drive.yaml')), {**parameters, 'tau_k_model': 'random_walk'}),
            }.items():
        estimates = Estimator(replace(one, arm_load='none'), values).run(samples_of(recording))
        miss = (estimates.tau_k - run.tau_k[1:])[1000:]
        errors[name] = miss.std(), (np.abs(miss) < 2.0 * estimates.tau_k_std[1000:]).mean()
    assert errors['adapted'][0] < 0.5 * errors['before'][0] and errors['adapted'][1] > 0.93
