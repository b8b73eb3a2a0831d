# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The likelihood's slopes are those of the criterion that filters are scored by."""
import math

import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.score import (
    differenced, likelihood, LikelihoodSlopes, run_score, suited)
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

DT = 1e-3
MODEL = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)
NOISE = {'r_std_motor': 0.0658, 'r_std_arm': 0.0833, 'q_std_tau_k': 9.0,
         'q_std_motor_speed': 0.387, 'q_std_arm_speed': 1.2}
LOADS = [{'id': 'gravity', 'G': 2.0, 'phi': 0.4}, {'id': 'arm_coulomb', 'Cac': 0.5},
         {'id': 'arm_viscous', 'Cav': 0.1}, {'id': 'load_friction', 'Cl': 0.05}]


def recorded(n=2500, dt=DT):
    run = simulate(MODEL, Excitation().torque(dt * np.arange(n)), dt,
                   Noise((0.066, 0.083, 0.387, 0.478), (0.0658, 0.0833)), 4)
    stamps = np.round((1.0 + dt * np.arange(n)) * 1e9).astype(np.int64)
    stamps += np.random.default_rng(2).integers(0, int(dt * 1e8), n)  # steps are not quite alike
    return Samples(stamps, np.column_stack([run.u, np.full(n, np.nan)]), run.y)


def spoiled(samples):
    """Return `samples` with all that the sample loop refuses, holds, bridges or restarts after."""
    samples.y[700:720, 0] = samples.y[800, 1] = samples.u[900, 0] = np.nan
    samples.y[1000, 1] += 50.0  # a jump
    samples.stamp_ns[1100] = samples.stamp_ns[1099]
    samples.stamp_ns[1300:] += 100_000_000  # bridged
    samples.stamp_ns[1800:] += 400_000_000  # a restart
    samples.u[:3, 0] = np.nan
    return samples


def parameters(**changes):
    return EstimatorParameters.of({'arm_load': 'none', **NOISE,
                                   'friction_linearisation': 'statistical', **changes})


@pytest.mark.parametrize('changes, effects, dt', [
    ({}, [], DT),
    ({'filter': 'aekf', 'adapt': ['']}, [], DT),
    pytest.param({'arm_load': 'unknown', 'friction_error_std': 0.1, 'tau_k_stiffness': 2.0,
                  'q_std_tau_k_speed': 1.0, 'effort_delay': 2}, LOADS, 4.0 * DT,
                 marks=pytest.mark.system),
])
def test_value_is_the_criterion_and_slopes_are_its_differences(changes, effects, dt):
    model, samples, base = (
        MODEL.with_(effects=effects), spoiled(recorded(dt=dt)), parameters(**changes))
    values = {name: getattr(base, name) for name in (
        *NOISE, *(['q_std_tau_arm'] if base.arm_load == 'unknown' else []))}
    slopes = LikelihoodSlopes(model, base, list(values), samples)
    found = slopes(values)
    assert found.criterion == pytest.approx(run_score(model, base, samples).criterion, rel=1e-12)
    assert not found.failed

    def moved(name, step):
        return slopes({**values, name: values[name] * math.exp(step)}).criterion
    expected = [(moved(name, 1e-5) - moved(name, -1e-5)) / 2e-5 for name in values]
    np.testing.assert_allclose(found.gradient, expected, rtol=1e-5, atol=1e-3)


def test_differences_tell_what_the_sensitivities_tell():
    """Gradient and information, of samples with one encoder, too."""
    samples, base = recorded(), parameters()
    samples.y[1000:1100, 0] = samples.y[1500:1600, 1] = np.nan
    exact = LikelihoodSlopes(MODEL, base, list(NOISE), samples)(NOISE)
    found = differenced(
        lambda values: likelihood(MODEL, base.replace(**values), samples), NOISE)
    assert found.criterion == pytest.approx(exact.criterion, rel=1e-12)
    assert (found.runs, found.failed) == (11, 0)
    np.testing.assert_allclose(found.gradient, exact.gradient, rtol=0.02, atol=0.5)
    scale = np.sqrt(np.diag(exact.information))
    np.testing.assert_allclose(found.information / np.outer(scale, scale),
                               exact.information / np.outer(scale, scale), atol=0.05)


def test_information_is_the_variance_of_the_gradient():
    """By Fisher, at the truth; of the encoders' noise, which the model has right."""
    names = ['r_std_motor', 'r_std_arm']
    samples, base = recorded(8000), parameters()
    slopes = LikelihoodSlopes(MODEL, base, names, samples)({name: NOISE[name] for name in names})
    step = np.linalg.solve(slopes.information, slopes.gradient)
    deviations = np.sqrt(np.diag(np.linalg.inv(slopes.information)))
    assert (np.abs(step) < 3.0 * deviations).all()
    np.testing.assert_allclose(deviations, 1.0 / math.sqrt(2.0 * 7500), rtol=0.1)


def test_a_filter_that_diverges_costs_and_is_counted():
    samples, values = recorded(), {**NOISE, 'q_std_tau_k': 1e9, 'r_std_motor': 1e-9,
                                   'r_std_arm': 1e-9}
    found = LikelihoodSlopes(MODEL, parameters(), list(NOISE), samples)(values)
    assert found.failed and run_score(MODEL, parameters(**values), samples).diverged
    assert found.criterion < -1e6


EXACT = [
    (True, {}, {}), (True, {'filter': 'aekf', 'adapt': ['']}, {}),
    (True, {'friction_error_std': 0.1, 'tau_k_stiffness': 5.0}, {}),
    (False, {'filter': 'ukf'}, {}), (False, {'tau_k_model': 'elastic'}, {}),
    (False, {'tau_k_model': 'learned'}, {}),
    (False, {}, {'friction_law': {'kind': 'tanh'}}),
]


def test_filters_with_exact_slopes():
    for known, changes, model in EXACT:
        assert suited(MODEL.with_(**model), parameters(**changes)) == known
