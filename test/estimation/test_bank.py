# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A bank of EKFs gives the criterion of single runs, whatever the candidates and the samples."""
import numpy as np
import pytest

from gearbox_monitor.estimation import batch_score
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.process_model import pack
from gearbox_monitor.estimation.score import run_score
from gearbox_monitor.kernels.jit import COMPILED
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.excitation import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

DT = 1e-3
NAMES = ('r_std_motor', 'r_std_arm', 'q_std_tau_k', 'q_std_motor_speed', 'q_std_arm_speed',
         'q_std_tau_arm', 'q_std_tau_k_speed')
MODEL = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)


def recorded(n=1500, dt=DT):
    rng = np.random.default_rng(2)
    run = simulate(MODEL, Excitation().torque(dt * np.arange(n)), dt,
                   Noise((0.066, 0.083, 0.387, 0.478), (0.0658, 0.0833)), 4)
    stamps = np.round((1.0 + dt * np.arange(n)) * 1e9).astype(np.int64)
    stamps += rng.integers(0, int(dt * 1e8), n)  # steps are not quite alike
    return Samples(stamps, np.column_stack([run.u, np.full(n, np.nan)]), run.y)


def candidates(w=19, **parameters):
    """Return good and bad ones: each value within a factor of 100 of a good one."""
    rng = np.random.default_rng(1)
    good = dict(zip(NAMES, (0.0658, 0.0833, 9.0, 0.387, 0.478, 0.01, 0.1)))
    return [{'arm_load': 'none', **parameters, **{
        name: float(value * 100.0 ** rng.uniform(-1.0, 1.0)) for name, value in good.items()}}
        for _ in range(w)]


def compared(monkeypatch, model, trials, samples):
    """Return (criteria together, criteria alone, how many the bank left to single runs)."""
    alone, left = [run_score(model, trial, samples) for trial in trials], []
    monkeypatch.setattr(batch_score, 'run_score',
                        lambda *args: left.append(args) or run_score(*args))
    found = batch_score.criteria(model, trials, samples)
    return found, [(one.criterion, one.diverged) for one in alone], len(left)


@pytest.mark.skipif(not COMPILED, reason='interpreted, filters run one after the other')
@pytest.mark.parametrize('effects, dt, parameters', [
    ([], DT, {'friction_linearisation': 'statistical'}),
    pytest.param([], DT, {'arm_load': 'measured', 'effort_delay': 2, 'tau_k_stiffness': 5.0},
                 marks=pytest.mark.system),
    pytest.param([{'id': 'arm_viscous', 'Cav': 0.02}, {'id': 'load_torque', 'TL': 0.3}], 4.0 * DT,
                 {'arm_load': 'unknown'},  # two steps of integration to a sample
                 marks=pytest.mark.system),
])
def test_together_and_alone_are_the_same(effects, dt, parameters, monkeypatch):
    samples = recorded(dt=dt)
    samples.u[:, 1] = 0.1 * np.sin(np.arange(len(samples.u)))
    trials = candidates(**parameters)
    trials[3] |= {'q_std_tau_k': 1e9, 'r_std_motor': 1e-9, 'r_std_arm': 1e-9}  # diverges
    trials[5] |= {'r_std_motor': 1e-9, 'r_std_arm': 1e-9, 'q_std_tau_k': 1e-6,
                  'q_std_motor_speed': 1e-6, 'q_std_arm_speed': 1e-6}  # takes positions for jumps
    found, alone, left = compared(monkeypatch, MODEL.with_(effects=effects), trials, samples)
    np.testing.assert_allclose(found, alone, rtol=1e-9)
    assert alone[3][1] > 0 and 1 <= left <= 4


def without_motor(samples):
    samples.y[700, 0] = np.nan


def without_torque(samples):
    samples.u[700, 0] = np.nan


def with_a_gap(samples):
    samples.stamp_ns[700:] += 400_000_000


def repeated(samples):
    samples.stamp_ns[700] = samples.stamp_ns[699]


@pytest.mark.parametrize('spoil', [without_motor, without_torque, with_a_gap, repeated])
def test_samples_that_lanes_cannot_take_run_alone(spoil, monkeypatch):
    samples = recorded(900)
    spoil(samples)
    found, alone, left = compared(monkeypatch, MODEL, candidates(3), samples)
    assert found == alone and left == 3


@pytest.mark.parametrize('suited, effects, one, all_of_them', [
    (COMPILED, [], {}, {}),
    (False, [], {}, {'ekf_jacobian': 'numeric'}),
    (False, [], {}, {'friction_error_std': 0.1}),
    (False, [], {}, {'filter': 'ukf'}),
    (False, [], {'tau_k_stiffness': 5.0}, {}),  # a model of its own
    (False, [{'id': 'gravity', 'G': 0.3}], {}, {}),
    (False, [{'id': 'arm_coulomb', 'Cac': 0.05}], {}, {}),
    (False, [{'id': 'load_friction', 'Cl': 0.1}], {}, {}),
])
def test_filters_that_lanes_can_run(suited, effects, one, all_of_them):
    trials = candidates(3, **all_of_them)
    trials[1] |= one
    estimators = [Estimator(MODEL.with_(effects=effects), trial) for trial in trials]
    packed = np.array([pack(estimator.drive, estimator.parameters) for estimator in estimators])
    assert batch_score.suited([estimator.parameters for estimator in estimators], packed,
                              estimators[0].settings, recorded(900)) == suited


@pytest.mark.skipif(not COMPILED, reason='interpreted, filters run one after the other')
def test_sums_are_those_of_the_estimates():
    samples, trials = recorded(900), candidates(3)
    estimators = [Estimator(MODEL, trial) for trial in trials]
    packed = np.array([pack(one.drive, one.parameters) for one in estimators])
    sums = batch_score.run(packed, estimators[0].states, estimators[0].settings, samples, 200)
    for (loglik, nis), one in zip(sums.T, estimators):
        estimates = one.run(samples)  # begin at the second sample
        assert loglik == pytest.approx(estimates.loglik[199:].sum(), rel=1e-9)
        assert nis == pytest.approx(estimates.nis[199:].sum(), rel=1e-9)
