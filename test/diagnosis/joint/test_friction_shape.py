# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Friction of another shape than the model's keeps its name and its size."""
import numpy as np
import pytest

from gearbox_monitor.diagnosis.joint.diagnose import diagnose
from gearbox_monitor.plant.drive import model_from_dict
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant
from gearbox_monitor.signals.uniform import UniformRecording

DT = 1e-3
U = Excitation().torque(DT * np.arange(4000))
TRIED = ['arm_coulomb', 'motor_viscous', 'gravity', 'torque_map']


def verdict(true, noise=1e-3, tried=TRIED, **nominal):
    run = Plant(model_from_dict(true, 'test'), Noise(measurement=(noise, noise)), 1).run(U, DT)
    recording = UniformRecording(run.t, U, run.y, DT)
    return diagnose([recording], model_from_dict(nominal, 'test'), only=tried)


@pytest.mark.system
def test_of_the_arm():
    found = verdict({'arm_friction_sharpness': 8.0,
                     'effects': [{'id': 'arm_coulomb', 'Cac': 0.2}]}, noise=2e-4)
    assert (found.data['verdict'], found.data['effect']) == ('effect', 'arm_coulomb')
    assert found.data['params']['arm_coulomb']['Cac'] == pytest.approx(0.2, rel=0.05)
    assert found.data['nominal']['alpha_arm'] == pytest.approx(8.0, rel=0.2)
    assert any('friction of the arm has another shape' in w for w in found.data['warnings'])
    assert found.model.arm_friction_sharpness == pytest.approx(8.0, rel=0.2)


def test_of_the_motor():
    found = verdict({'friction_sharpness': 15.0})
    assert (found.data['verdict'], found.data['effect']) == ('none', None)
    assert found.data['nominal']['alpha'] == pytest.approx(15.0, rel=0.2)
    assert found.data['gap_after'] < found.data['gap_before'] - 0.03
    assert any('friction of the motor has another shape' in w for w in found.data['warnings'])


def test_an_exact_shape_is_not_fitted_along():
    found = verdict({'friction_sharpness': 15.0}, tried=['gravity'], sharpness_tolerance=0.0)
    assert found.data['verdict'] == 'unknown' and 'alpha' not in found.data['nominal']
