# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The likelihood's slopes are those of the criterion that filters are scored by."""
import math

import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.noise_search import differenced
from gearbox_monitor.estimation.score import likelihood, run_score
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


def slopes(model, base, samples, values):
    def trial(moved):
        return likelihood(model, base.replace(**moved), samples)
    return trial(values), *differenced(trial, values, trial(values))


def parameters(**changes):
    return EstimatorParameters.of({'arm_load': 'none', **NOISE,
                                   'friction_linearisation': 'statistical', **changes})


@pytest.mark.parametrize('changes, effects, dt', [
    ({}, [], DT),
    ({'filter': 'aekf', 'adapt': ['']}, [], DT),
    ({'arm_load': 'unknown', 'friction_error_std': 0.1, 'tau_k_stiffness': 2.0,
      'q_std_tau_k_speed': 1.0, 'effort_delay': 2}, LOADS, 4.0 * DT),
])
def test_value_is_the_criterion_and_slopes_lead_uphill(changes, effects, dt):
    model, samples, base = (
        MODEL.with_(effects=effects), spoiled(recorded(dt=dt)), parameters(**changes))
    values = {name: getattr(base, name) for name in NOISE}
    found, gradient, _ = slopes(model, base, samples, values)
    assert found.criterion == pytest.approx(run_score(model, base, samples).criterion, rel=1e-12)
    assert found.failed == 0
    size = 1e-3 / np.linalg.norm(gradient)
    moved = {name: value * math.exp(size * g)
             for (name, value), g in zip(values.items(), gradient)}
    gained = run_score(model, base.replace(**moved), samples).criterion - found.criterion
    assert gained == pytest.approx(1e-3 * np.linalg.norm(gradient), rel=0.05)


def test_information_is_the_variance_of_the_gradient():
    """By Fisher, at the truth; of the encoders' noise, which the model has right."""
    names = ['r_std_motor', 'r_std_arm']
    samples, base = recorded(8000), parameters()
    _, gradient, information = slopes(MODEL, base, samples, {name: NOISE[name] for name in names})
    step = np.linalg.solve(information, gradient)
    deviations = np.sqrt(np.diag(np.linalg.inv(information)))
    assert (np.abs(step) < 3.0 * deviations).all()
    np.testing.assert_allclose(deviations, 1.0 / math.sqrt(2.0 * 7500), rtol=0.1)


def test_a_filter_that_diverges_costs_and_is_counted():
    samples, values = recorded(), {**NOISE, 'q_std_tau_k': 5e8, 'r_std_motor': 2e-9,
                                   'r_std_arm': 2e-9}
    found, *_ = slopes(MODEL, parameters(), samples, values)
    assert found.failed and run_score(MODEL, parameters(**values), samples).diverged
    assert found.criterion < -1e6
