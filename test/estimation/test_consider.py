# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the model's tolerances add to the stated deviations, against oracles and drawn drives."""
from dataclasses import replace

from drives import driven, part_of, samples_of
import numpy as np
import pytest

from gearbox_monitor.estimation.consider import UNIFORM
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_NOISE_STD, S_TAU_K_STD, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_STD)
from gearbox_monitor.plant.drive import DriveModel, TOLERANCES
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

DT, N = 1e-3, 500


def recorded(model, count=N, process=0.4):
    return driven(model, count * DT, Noise((0.0, 0.0, process, process), (5e-3, 5e-3)))


def one_step(model, z, u, c):
    """Return z after an RK4 step; c: errors of Cc, Cv, D, m1, m2 (relative), gain and delay."""
    m1, m2 = model.motor_inertia * (1.0 + c[3]), model.arm_inertia * (1.0 + c[4])

    def rates(z):
        friction = (model.viscous_friction * (1.0 + c[1]) * z[2] + model.coulomb_friction
                    * (1.0 + c[0]) * 2.0 / np.pi * np.arctan(model.friction_sharpness * z[2]))
        damping = model.damping * (1.0 + c[2]) * (z[2] - z[3])
        torque = (1.0 + c[5]) * u[0] - c[6] * u[1]
        return np.array([
            z[2], z[3], (torque - damping - z[4] - friction - model.position_gain * z[0]) / m1,
            (damping + z[4]) / m2, 0.0])
    a = rates(z)
    b = rates(z + 0.5 * DT * a)
    d = rates(z + 0.5 * DT * b)
    e = rates(z + DT * d)
    return z + DT / 6.0 * (a + 2.0 * b + 2.0 * d + e)


def slopes(f, at):
    """Return the Jacobian of f at `at` by central differences."""
    steps = 1e-6 * np.eye(len(at))
    return np.array([(f(at + h) - f(at - h)) / 2e-6 for h in steps]).T


def test_cross_covariances_are_those_of_the_state_with_the_errors_added():
    # Schmidt and Kalman: the errors are constant states whose rows of the gain are zero.
    small = 1e-4
    model = DriveModel().with_(friction_sharpness=20.0, **dict.fromkeys(TOLERANCES, small))
    run = recorded(model)
    estimator = Estimator(model, {'arm_load': 'none', 'smoother_lag': 0.0, 'narrow_std': False})
    estimates = estimator.run(samples_of(run))
    p = estimator.parameters
    R = np.diag([p.r_std_motor ** 2, p.r_std_arm ** 2])
    Q = 0.5 * DT * np.diag([0.0, 0.0, p.q_std_motor_speed ** 2, p.q_std_arm_speed ** 2,
                            p.q_std_tau_k ** 2])
    noise = np.zeros((12, 12))
    noise[:5, :5] = Q
    own = np.diag([R[0, 0], R[1, 1], p.p0_std_speed ** 2, p.p0_std_speed ** 2,
                   p.p0_std_torque ** 2])
    P = np.zeros((12, 12))
    P[:5, :5], P[5:, 5:] = own, np.eye(7) * small ** 2 / 3.0
    H = np.eye(2, 12)
    # The first step is linearised at the speeds of its readings, weighed against their prior.
    weight = 1.0 / (1.0 + 2.0 * np.diag(R) / (DT * p.p0_std_speed) ** 2)
    speeds = weight * (run.y[1] - run.y[0]) / DT
    z, exact = np.array([*run.y[0], *speeds, 0.0]), np.zeros(7)
    for k in range(1, N):
        u = run.u[k - 1], (run.u[k - 1] - run.u[k - 2]) / DT if k > 1 else 0.0
        F = np.eye(12)
        F[:5, :5] = slopes(lambda x: one_step(model, x, u, exact), z)
        F[:5, 5:] = slopes(lambda c: one_step(model, z, u, c), exact)
        z = one_step(model, z, u, exact)
        own = F[:5, :5] @ (own + Q) @ F[:5, :5].T + Q
        P = F @ (P + noise) @ F.T + noise
        K = np.zeros((12, 2))
        K[:5] = own[:, :2] @ np.linalg.inv(own[:2, :2] + R)
        z = z + K[:5] @ (run.y[k] - z[:2])
        own = (np.eye(5) - K[:5] @ H[:, :5]) @ own
        P = (np.eye(12) - K @ H) @ P @ (np.eye(12) - K @ H).T + K @ R @ K.T
        added = np.sqrt(P[4, 4] - own[4, 4])
        row = estimates.rows[k - 1]
        if k % 50 == 0:
            assert estimates.tau_k[k - 1] == pytest.approx(z[4], rel=1e-6, abs=1e-6)
            assert np.sqrt(estimates.tau_k_std[k - 1] ** 2 - estimates.tau_k_noise_std[k - 1] ** 2
                           ) == pytest.approx(added, rel=2e-3), row
    sensitivities = estimator._state.companions.s[:-1].reshape(7, 5).T
    # In the order of the packed drive; the drive is changed to where it is slower.
    signs = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
    expected = signs * P[:5, 5:][:, [3, 4, 2, 1, 0, 5, 6]] / (UNIFORM * small)
    np.testing.assert_allclose(sensitivities, expected, rtol=5e-3,
                               atol=1e-3 * np.abs(expected).max(axis=0).min())


FILTERS = [
    ('ekf', 'unknown'), ('ukf', 'unknown'), ('srukf', 'unknown'), ('aekf', 'none')]


def test_an_error_of_the_torque_shifts_the_estimates_by_what_is_stated():
    for name, load in FILTERS:
        # Without Coulomb friction the filters are linear, and their gain depends on no torque.
        tolerance = 0.2
        model = DriveModel().exact().with_(coulomb_friction=0.0, torque_gain_tolerance=tolerance)
        run = recorded(model)
        parameters = {'filter': name, 'arm_load': load, 'adapt': [''], 'narrow_std': False}
        first, second = (Estimator(model, parameters).run(samples_of(replace(run, u=gain * run.u)))
                         for gain in (1.0, 1.0 + UNIFORM * tolerance))
        for estimate, std, noise in (('tau_k', 'tau_k_std', 'tau_k_noise_std'),):
            added = getattr(first, std) ** 2 - getattr(first, noise) ** 2
            shift = getattr(second, estimate) - getattr(first, estimate)
            np.testing.assert_allclose(np.sqrt(np.maximum(added, 0.0)), np.abs(shift), atol=1e-7)
        assert np.abs(shift).max() > 0.3
        before, after = first.smoothed, second.smoothed
        for estimate, std, noise in ((S_TAU_K, S_TAU_K_STD, S_TAU_K_NOISE_STD),
                                     (S_TWIST, S_TWIST_STD, S_TWIST_NOISE_STD)):
            added = np.sqrt(np.maximum(before[:, std] ** 2 - before[:, noise] ** 2, 0.0))
            np.testing.assert_allclose(added, np.abs(after - before)[:, estimate], atol=1e-7)


def test_estimates_and_innovations_do_not_depend_on_the_tolerances():
    run = recorded(DriveModel())
    with_, without = (Estimator(model, {'narrow_std': False}).run(samples_of(run))
                      for model in (DriveModel(), DriveModel().exact()))
    for name in ('tau_k', 'twist', 'nis', 'loglik', 'white_2', 'tau_k_noise_std'):
        np.testing.assert_array_equal(getattr(with_, name), getattr(without, name))
    assert (with_.tau_k_std > without.tau_k_std).all()
    np.testing.assert_array_equal(without.tau_k_std, without.tau_k_noise_std)


def test_a_wrong_value_of_the_model_widens_the_deviation_where_it_matters():
    # Friction is in doubt while the drive slides, inertia while it accelerates.
    run = recorded(DriveModel().with_(half_gap=0.0), 1500, 0.0)
    settled = slice(500, None)
    speed = np.abs(run.x[1:, 2])[settled]
    acceleration = np.abs(np.gradient(run.x[1:, 2], DT))[settled]
    for name, size in (('damping_tolerance', speed), ('inertia_tolerance', acceleration)):
        model = DriveModel().exact().with_(**{name: 0.3})
        estimates = Estimator(model, {'smoother_lag': 0.0, 'narrow_std': False}).run(
            samples_of(run))
        added = np.sqrt(estimates.tau_k_std ** 2 - estimates.tau_k_noise_std ** 2)[settled]
        assert np.corrcoef(added, size)[0, 1] > 0.7
        assert added[size > 0.8 * size.max()].mean() > 5.0 * added[size < 0.1 * size.max()].mean()


def test_errors_that_no_check_sees_stay_as_large_through_a_change_of_parameters():
    """They are taken from steps that are at hand, none from the empty records before them."""
    for lag in (0.0, 0.1):
        run = recorded(DriveModel(), 3000)
        samples = samples_of(run)
        estimator = Estimator(DriveModel(), {'smoother_lag': lag})
        estimator.run(part_of(samples, 0, 2900))
        before = estimator.undetected_errors()
        estimator.set_parameters({'q_std_tau_k': 1.05 * estimator.parameters.q_std_tau_k})
        estimator.run(part_of(samples, 2900, 2903))
        after = estimator.undetected_errors()
        assert set(after) == set(before) and before
        assert sum(after.values()) > 0.3 * sum(before.values())


def test_a_motion_of_little_torque_narrows_the_deviation_to_the_error():
    """The random walk lets tau_K wander five times as far; innovations and noise stay."""
    for load in ('none', 'unknown'):
        model, t = DriveModel().exact(), np.arange(12_000) * DT
        runs = [simulate(model, u, DT, Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), 3)
                for u in (np.sin(2.0 * t), Excitation().torque(t))]
        quiet, lively = (Estimator(model, {'arm_load': load}).run(samples_of(run))
                         for run in runs)
        settled = slice(1000, None)
        for bound, std, noise, error in (
                (1.4, quiet.tau_k_std, quiet.tau_k_noise_std, quiet.tau_k - runs[0].tau_k[1:]),
                (1.7, quiet.smoothed[:, S_TAU_K_STD], quiet.smoothed[:, S_TAU_K_NOISE_STD],
                 quiet.smoothed[:, S_TAU_K] - runs[0].tau_k[1:len(quiet.smoothed) + 1])):
            rms = np.sqrt(np.mean(error[settled] ** 2))
            assert noise[settled].mean() > 1.8 * rms
            assert 0.9 * rms < np.sqrt(np.mean(std[settled] ** 2)) < bound * rms
        assert (lively.tau_k_std[settled] > 0.9 * lively.tau_k_noise_std[settled]).all()


def test_the_narrowing_ends_with_what_taught_it_and_goes_on_from_a_snapshot():
    model, n = DriveModel().exact(), 4000
    run = simulate(model, np.sin(2.0 * DT * np.arange(n)), DT,
                   Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), 3)
    whole = samples_of(run)

    def part(first, end):
        return part_of(whole, first, end)
    expected, half = Estimator(model).run(whole), Estimator(model)
    half.run(part(0, n // 2))
    resumed = Estimator.restore(half.snapshot()).run(part(n // 2, n))
    np.testing.assert_array_equal(resumed.tau_k_std[:50], expected.tau_k_std[n // 2 - 1:][:50])
    assert expected.tau_k_std[-1] < 0.8 * expected.tau_k_noise_std[-1]
    for change in ({'q_std_tau_k': 4.0}, {'p0_std_speed': 20.0}):  # carries on, restarts
        half.set_parameters(change)
        after = half.run(part(n // 2, n // 2 + 5))
        np.testing.assert_array_equal(after.tau_k_std, after.tau_k_noise_std)
