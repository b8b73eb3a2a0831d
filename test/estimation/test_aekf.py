# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Adaptive filter: exact gradient, bars of convergence, refusals, and the same bits in replay."""

from dataclasses import replace
from functools import cache

from drives import driven, part_of, samples_of
import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filter_kind import Belief, places, Reading, record_size, Scratch
from gearbox_monitor.estimation.filters import aekf, ekf
from gearbox_monitor.estimation.process_model import (
    ADAPT_AT, ADAPTABLE, layout_of, P0, pack, state_names)
from gearbox_monitor.estimation.sample_loop import START
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.kernel import Entry
from gearbox_monitor.kernels.types import Layout
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise

# With hysteresis, and the noise of two percent.
CASE_A = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)
R_A = (0.0658, 0.0833)
Q_A = tuple(0.02 * s for s in (3.29, 4.16, 19.3, 23.9))
TUNED = {
    'filter': 'aekf', 'arm_load': 'none', 'r_std_motor': R_A[0], 'r_std_arm': R_A[1],
    'q_std_motor_position': Q_A[0], 'q_std_arm_position': Q_A[1], 'q_std_motor_speed': Q_A[2],
    'q_std_arm_speed': Q_A[3], 'q_std_tau_k': 10.0}

DIFFERENTIATE = Entry(aekf.differentiate)
STEP = Entry(ekf.step)


@cache
def simulated(seconds, seed=1, dt=1e-3):
    return driven(CASE_A, seconds, Noise(Q_A, R_A), seed, dt)


def samples(out, y=None):
    data = samples_of(out, begin_ns=10 ** 9)
    return data if y is None else replace(data, y=y)


def settled(estimator, out, seconds, y=None):
    """Run; return the rms error of tau_K between `seconds` (from, to)."""
    estimates = estimator.run(samples(out, y))
    at = (estimates.stamp_ns - 1_000_000_000) // 1_000_000
    keep = (at >= 1000 * seconds[0]) & (at < 1000 * seconds[1])
    return float(np.sqrt(np.mean((estimates.tau_k[keep] - out.tau_k[at[keep]]) ** 2)))


# model's load, further parameters, dt, effects
LOADS = ({'id': 'load_friction', 'Cl': 0.05}, {'id': 'gravity', 'G': 20.0, 'phi': 0.4},
         {'id': 'arm_coulomb', 'Cac': 0.9}, {'id': 'arm_viscous', 'Cav': 0.1},
         {'id': 'load_torque', 'TL': 0.4})
SETUPS = {
    'paper': ('none', {}, 1e-3, ()),
    'sharp friction': ('none', {'adapt_friction_sharpness': 100.0}, 1e-3, ()),
    'long steps': ('none', {'adapt_friction_sharpness': 100.0}, 4e-3, ()),
    'all states': ('unknown', {'friction_error_std': 0.2, 'q_std_tau_k_speed': 1.0}, 4e-3,
                   LOADS),
}


@pytest.mark.parametrize('setup', [
    name if name == 'long steps' else pytest.param(name, marks=pytest.mark.system)
    for name in SETUPS])
def test_gradient_is_that_of_the_log_likelihood(setup):
    load, options, dt, effects = SETUPS[setup]
    parameters = EstimatorParameters.from_mapping(
        {**TUNED, 'adapt': list(ADAPTABLE), 'tau_k_stiffness': 2.0, **options})
    model = CASE_A.with_(arm_load=load, effects=effects)
    p, n = pack(model, parameters), len(state_names(model, parameters))
    out = simulated(300 * dt, dt=dt)
    y = out.y.copy()
    y[np.random.default_rng(0).random(y.shape) < 0.1] = np.nan

    def likelihood(change):
        z, P = np.zeros(n), np.diag(p[P0:P0 + n]).ravel()
        memory = np.zeros(aekf.memory_size(n))
        aekf.begin(memory, p)
        for i, c in enumerate(change):
            memory[aekf.IN_USE + int(p[ADAPT_AT + i])] *= np.exp(c)
        scratch = Scratch(np.zeros((aekf.N_VECTORS, n)), np.zeros((5, n * n)))
        value, gradient, record = 0.0, np.zeros(aekf.MAX_THETA), np.zeros(record_size(n))
        for u, (y1, y2) in zip(out.u, y):
            assert DIFFERENTIATE(layout_of(p, n), Belief(z, P, memory),
                                 Reading(dt, u, 0.0, y1, y2), p, scratch, record)
            value += record[places(n)[-1] + 1]
            gradient -= scratch.vectors[aekf._GRADIENT:aekf._GRADIENT + aekf.MAX_THETA, 0]
        assert aekf.guards(memory)['sensitivity_resets'] == 0
        return value, gradient

    gradient = likelihood(np.zeros(6))[1]
    steps = 1e-6 * np.eye(6)
    expected = [(likelihood(s)[0] - likelihood(-s)[0]) / 2e-6 for s in steps]
    np.testing.assert_allclose(gradient, expected, rtol=1e-4, atol=1e-5)


FASTER = [
    ({}, 0.0),
    ({'Cv': 0.5}, 0.5 / CASE_A.motor_inertia), ({'Cv': -0.5}, 0.0),
    ({'K': 3.0}, np.sqrt(3.0 / CASE_A.motor_inertia + 3.0 / CASE_A.arm_inertia)),
    ({'K': -3.0}, 0.0)]


def test_steps_get_shorter_only_where_the_drive_got_faster():
    for changes, more in FASTER:
        p = pack(CASE_A, EstimatorParameters.from_mapping({**TUNED, 'tau_k_stiffness': 4.0}))
        current = p.copy()
        for name, change in changes.items():
            current[{'Cv': aekf.CV, 'K': aekf.K_P}[name]] += change
        assert aekf._eigenvalue(current, p) - p[aekf.EIGENVALUE] == pytest.approx(more, rel=1e-9)


def test_without_adaptation_it_is_the_ekf():
    for adapt in ([], ['']):
        out = simulated(1.0)
        model = CASE_A.with_(friction_sharpness=1.0)
        estimator = Estimator(CASE_A, {**TUNED, 'adapt': adapt})
        ours = estimator.run(samples(out))
        theirs = Estimator(model, {**TUNED, 'filter': 'ekf'}).run(samples(out))
        np.testing.assert_allclose(ours.rows, theirs.rows, rtol=1e-12, atol=1e-12)
        assert estimator.adapted() == {}


def test_frozen_adaptation_is_the_ekf():
    """The belief is that of the EKF with the theta in use: the extra work leaves it alone."""
    parameters = EstimatorParameters.from_mapping(
        {**TUNED, 'adapt': list(ADAPTABLE), 'tau_k_stiffness': 2.0})
    p, n, out = pack(CASE_A, parameters), 5, simulated(0.5)
    scratch = Scratch(np.zeros((aekf.N_VECTORS, n)), np.zeros((5, n * n)))
    memory = np.zeros(aekf.memory_size(n))
    aekf.begin(memory, p)
    beliefs = [(np.zeros(n), np.diag(p[P0:P0 + n]).ravel(), np.zeros(record_size(n)))
               for _ in range(2)]
    for u, (y1, y2) in zip(out.u, out.y):
        (z, P, record), (z_e, P_e, record_e) = beliefs
        reading = Reading(1e-3, u, 0.0, y1, y2)
        layout = Layout(n, False, -1, False)
        assert DIFFERENTIATE(layout, Belief(z, P, memory), reading, p, scratch, record)
        assert STEP(layout, Belief(z_e, P_e, np.zeros(0)), reading, p, scratch, record_e)
        np.testing.assert_allclose(record, record_e, rtol=1e-9, atol=1e-9)


def test_finds_the_noise_from_a_wrong_start():
    out = simulated(30.0)
    tuned = settled(Estimator(CASE_A, {**TUNED, 'filter': 'ekf'}), out, (15, 30))
    for q, r in ((1.0, 1.0), (100.0, 3.0)):
        monitor = Monitor(CASE_A, {
            **TUNED, 'q_std_tau_k': q, 'r_std_motor': r * R_A[0], 'r_std_arm': r * R_A[1]})
        assert settled(monitor, out, (15, 30)) < 1.02 * tuned
        found = monitor.estimator.adapted()
        np.testing.assert_allclose([found['r_std_motor'], found['r_std_arm']], R_A, rtol=0.03)
        assert monitor.estimator.adaptation_guards()['sensitivity_resets'] == 0
        values = monitor.outcomes['covariance'].values
        assert values['adapted_q_std_tau_k'] == pytest.approx(found['q_std_tau_k'], rel=0.1)


def test_what_was_adapted_survives_a_start():
    out = simulated(8.0)
    data = samples(out)
    wrong = {**TUNED, 'r_std_motor': 3.0 * R_A[0], 'adapt': ['q_std_tau_k', 'r_std_motor']}
    estimator = Estimator(CASE_A, wrong)
    estimator.run(part_of(data, 0, 5000))
    found = estimator.adapted()
    assert found['r_std_motor'] < 2.0 * R_A[0]
    estimator.run(part_of(data, 5500, 5600))  # max_gap is 0.25 s
    assert estimator.counts[START] == 2 and estimator.adapted() == found
    estimator.run(part_of(data, 5600, 8000))
    assert estimator.adapted()['r_std_motor'] == pytest.approx(R_A[0], rel=0.2)


def test_finds_viscous_friction_from_twice_its_value():
    estimator = Estimator(CASE_A.with_(viscous_friction=0.2),
                          {**TUNED, 'adapt': ['viscous_friction']})
    estimator.run(samples(simulated(30.0)))
    assert estimator.adapted()['viscous_friction'] == pytest.approx(0.1, abs=2e-3)


def test_finds_a_stiffness_that_halves_the_error():
    estimator = Estimator(CASE_A, {**TUNED, 'adapt': ['q_std_tau_k', 'tau_k_stiffness'],
                                   'tau_k_stiffness': 1.0})
    assert settled(estimator, simulated(30.0), (15, 30)) < 0.66


def test_follows_encoders_that_become_noisier():
    out = simulated(40.0)
    y = out.y.copy()
    y[20000:] += 15 ** 0.5 * np.random.default_rng(1).normal(0.0, R_A, (20000, 2))
    adaptive = settled(Estimator(CASE_A, TUNED), out, (20, 40), y)
    fixed = settled(Estimator(CASE_A, {**TUNED, 'filter': 'ekf'}), out, (20, 40), y)
    assert adaptive < 1.75 < 2.4 < fixed


def test_six_at_once_all_wrong():
    estimator = Estimator(CASE_A.with_(viscous_friction=0.05), {
        **TUNED, 'adapt': list(ADAPTABLE), 'q_std_tau_k': 100.0, 'r_std_motor': 0.2,
        'r_std_arm': 0.2, 'tau_k_stiffness': 1.0})
    assert settled(estimator, simulated(40.0), (25, 40)) < 0.7


def test_rests_while_nothing_is_measured_and_keeps_going():
    out = simulated(3.0)
    y = out.y.copy()
    y[1500:1600] = np.nan  # both encoders
    y[2000:2400, 1] = np.nan  # the arm's
    estimator = Estimator(CASE_A, TUNED)
    estimator.run(part_of(samples(out, y), 0, 1500))
    before = estimator.adapted()
    estimator.run(part_of(samples(out, y), 1500, 1600))
    assert estimator.adapted() == before
    estimator.run(part_of(samples(out, y), 1600, 3000))
    after = estimator.adapted()
    assert after != before and all(np.isfinite(list(after.values())))


def test_a_threshold_changes_without_restarting_the_adaptation():
    estimator = Estimator(CASE_A, TUNED)
    estimator.run(samples(simulated(1.0)))
    adapted = estimator.adapted()
    estimator.set_parameters({'gap_warn': 0.2})
    assert estimator.adapted() == adapted
    estimator.set_parameters({'q_std_tau_k': 5.0})
    assert estimator.adapted()['q_std_tau_k'] == pytest.approx(5.0)


REFUSALS = [
    ({'adapt': ['damping']}, {}, 'cannot be distinguished from tau_K'),
    ({'adapt': ['inertia']}, {}, 'expected some of q_std_tau_k'),
    ({'adapt': ['r_std_arm', 'r_std_arm']}, {}, 'named twice'),
    ({'adapt': ['tau_k_stiffness']}, {}, 'starts at 0'),
    ({'adapt': ['q_std_tau_k'], 'q_std_tau_k': 0.0}, {}, 'starts at 0'),
    ({'adapt': ['viscous_friction']}, {'viscous_friction': -0.1}, 'adapted as a logarithm'),
]


def test_refusals_say_why():
    for changes, model, text in REFUSALS:
        with pytest.raises(InputError, match=text) as error:
            Estimator(CASE_A.with_(**model), {**TUNED, **changes})
        assert '\n' not in str(error.value)
        running = Estimator(CASE_A.with_(**model), TUNED)
        before = running.parameters
        with pytest.raises(InputError, match=text):
            running.set_parameters(changes)
        assert running.parameters == before
