# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Filter and smoother against exact cases, filterpy and an independent oracle."""

from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
import numpy as np
import oracle
import pytest
from scipy import stats

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filter_kind import (
    Belief, predicted, Reading, record_size, Scratch, updated)
from gearbox_monitor.estimation.filters import ekf
from gearbox_monitor.estimation.process_model import (
    EIGENVALUE, layout_of, N_PACKED, P0, pack, propagate, Q0, state_names)
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_TAU_K, S_TAU_K_STD, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE,
    S_TWIST_RATE_NOISE_STD, S_X2, S_X3, S_X4, smooth, Span)
from gearbox_monitor.kernels.kernel import Entry
from gearbox_monitor.kernels.types import Layout
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel, substeps
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate


LOADS = {'gravity': {'G': 1.2, 'phi': 0.5}, 'arm_coulomb': {'Cac': 0.9},
         'arm_viscous': {'Cav': 0.1}, 'load_torque': {'TL': 0.4}}
# Load on the arm, parameters of the filter, effects of the model.
VARIANTS = {
    'paper': ('none', {}, {}),
    'known load': ('measured', {}, {}),
    'unknown load': ('unknown', {}, {}),
    'stiffness': ('unknown', {'tau_k_stiffness': 3.65}, {}),
    'friction error': ('none', {'friction_error_std': 0.2, 'friction_error_time': 0.3}, {}),
    'all': ('unknown', {'tau_k_stiffness': 2.0, 'friction_error_std': 0.2}, LOADS),
}
STEP = Entry(ekf.step)
CASE_B = DriveModel().with_(stiffness=5.0, half_gap=0.6)
TUNED = {'arm_load': 'none', 'r_std_motor': 0.0612, 'r_std_arm': 0.0828,
         'q_std_motor_position': 0.0612, 'q_std_arm_position': 0.0828,
         'q_std_motor_speed': 0.358, 'q_std_arm_speed': 0.472, 'q_std_tau_k': 10.0}


def setup(variant='paper', model=None, **changes):
    """Return (packed parameters, oracle's constants, number of states)."""
    load, options, effects = VARIANTS[variant]
    parameters = EstimatorParameters.from_mapping({**options, **changes})
    model = (model or DriveModel()).with_(
        arm_load=load, effects=[{'id': name, **values} for name, values in effects.items()])
    names = state_names(model, parameters)
    constants = {
        'm1': model.motor_inertia, 'm2': model.arm_inertia, 'D': model.damping,
        'Cv': model.viscous_friction, 'Cc': model.coulomb_friction,
        'alpha': model.friction_sharpness, 'Kr': model.position_gain,
        **{name: v for values in effects.values() for name, v in values.items()},
        'k_p': parameters.tau_k_stiffness, 'T': parameters.friction_error_time,
        'load_at': names.index('tau_arm') if 'tau_arm' in names else None,
        'friction_at': names.index('tau_e') if 'tau_e' in names else None}
    return pack(model, parameters), constants, len(names)


def filtered(p, n, z, P, dts, u, load, y):
    """Run the EKF; return its step records [N, record_size]."""
    belief = Belief(np.array(z, float), np.array(P, float).ravel(), np.zeros(0))
    scratch = Scratch(np.zeros((1, n)), np.zeros((5, n * n)))
    records = np.zeros((len(dts), record_size(n)))
    for k, dt in enumerate(dts):
        assert STEP(layout_of(p, n), belief, Reading(dt, u[k], load[k], *y[k]), p, scratch,
                    records[k])
    return records


def unpack(records, n):
    """Return (z, P, innovation, nis, z_pred, P_pred, loglik) of step records."""
    z, P = zip(*(updated(row, n) for row in records))
    innovation, _, _, scores = zip(*(oracle.correction(row, n) for row in records))
    z_pred, P_pred, _ = zip(*(predicted(row, n) for row in records))
    scores = np.array(scores)
    return (np.array(z), np.array(P), np.array(innovation), scores[:, 0], np.array(z_pred),
            np.array(P_pred), scores[:, 1])


def data(seconds, dt=1e-3, model=CASE_B, seed=1):
    t = dt * np.arange(round(seconds / dt))
    noise = Noise((0.0612, 0.0828, 0.358, 0.472), (0.0612, 0.0828))
    return simulate(model, Excitation().torque(t), dt, noise, seed)


def prior(p, n):
    return np.zeros(n), np.diag(p[P0:P0 + n])


def test_long_steps_are_divided_as_those_of_the_oracle():
    for variant in VARIANTS:
        p, constants, n = setup(variant)
        z = np.array([0.3, -0.2, -0.02, -0.01, 0.02, -0.1, 0.03])[:n]
        counted = substeps(7e-3, p[EIGENVALUE])
        expected, _ = oracle.flow(z, 0.05, 0.2, 7e-3, counted, constants)
        propagate(layout_of(p, n), z, np.empty(n * n), (0.05, 0.2), 7e-3, counted, p)
        np.testing.assert_allclose(z, expected, rtol=1e-12, atol=1e-14)


def test_substeps_cover_what_the_process_model_adds():
    for changes in ({'tau_k_stiffness': 1e6},
                    {'friction_error_std': 0.1, 'friction_error_time': 1e-4}):
        p, _, n = setup('paper', **changes)
        z, phi = np.full(n, 0.01), np.zeros(n * n)
        for _ in range(300):
            propagate(Layout(n, False, -1, False), z, phi, (0.0, 0.0), 1e-3,
                      substeps(1e-3, p[EIGENVALUE]), p)
        assert np.abs(z).max() < 100.0


def test_equals_the_oracle():
    for variant in VARIANTS:
        p, constants, n = setup(variant, **{k: v for k, v in TUNED.items() if k != 'arm_load'})
        out = data(0.25)
        rng = np.random.default_rng(0)
        y = out.y.copy()
        y[rng.random(y.shape) < 0.1] = np.nan
        z0, P_0 = prior(p, n)
        load = 0.3 * np.sin(out.t)
        records = filtered(p, n, z0, P_0, np.full(len(y), 1e-3), out.u, load, y)
        z, P, innovation, nis, z_pred, P_pred, _ = unpack(records, n)
        r = [TUNED['r_std_motor'] ** 2, TUNED['r_std_arm'] ** 2]
        # In blocks that start from our belief: at standstill, where RK4 is at its stability limit,
        # the last bits of a state grow a million-fold within a second.
        for begin in range(10, len(y), 10):
            part = slice(begin, begin + 10)
            expected = oracle.ekf(
                (z[begin - 1], P[begin - 1]), (np.full(10, 1e-3), out.u[part], load[part]),
                y[part], (p[Q0:Q0 + n], r), substeps(1e-3, p[EIGENVALUE]), constants)
            for i, mine in enumerate((z, P, innovation, nis, z_pred, P_pred)):
                np.testing.assert_allclose(mine[part], expected[i], rtol=1e-8, atol=1e-9)


def test_equals_filterpy_ekf():
    p, constants, n = setup('paper', **{k: v for k, v in TUNED.items() if k != 'arm_load'})
    out = data(0.5)
    stock = ExtendedKalmanFilter(dim_x=n, dim_z=2)
    stock.x, stock.P = prior(p, n)
    stock.R = np.diag([TUNED['r_std_motor'] ** 2, TUNED['r_std_arm'] ** 2])
    half = 0.5e-3 * np.diag(p[Q0:Q0 + n])
    H = np.eye(n)[:2]
    records = filtered(p, n, *prior(p, n), np.full(len(out.y), 1e-3), out.u,
                       np.zeros(len(out.y)), out.y)
    z, P, innovation, _, _, _, loglik = unpack(records, n)
    for k, y in enumerate(out.y):
        stock.x, phi = oracle.flow(stock.x, out.u[k], 0.0, 1e-3, 1, constants)
        stock.P = phi @ (stock.P + half) @ phi.T + half
        stock.update(y, lambda x: H, lambda x: H @ x)
        np.testing.assert_allclose(z[k], stock.x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(P[k], stock.P, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(innovation[k], stock.y, atol=1e-9)
        assert loglik[k] == pytest.approx(stock.log_likelihood, rel=1e-8, abs=1e-8)


def linear(seed=0, steps=1500):
    """Return a linear drive's filter set-up, its discretisation and data from its own model."""
    p, constants, n = setup('unknown load', DriveModel().with_(coulomb_friction=0.0),
                            q_std_motor_position=0.01, q_std_arm_position=0.01)
    dt = 1e-3
    _, F = oracle.flow(np.zeros(n), 0.0, 0.0, dt, substeps(dt, p[EIGENVALUE]), constants)
    B, _ = oracle.flow(np.zeros(n), 1.0, 0.0, dt, substeps(dt, p[EIGENVALUE]), constants)
    half = 0.5 * dt * np.diag(p[Q0:Q0 + n])
    Q = F @ half @ F.T + half
    rng = np.random.default_rng(seed)
    factor = np.linalg.cholesky(Q)
    x = np.sqrt(p[P0:P0 + n]) * rng.standard_normal(n)
    u = Excitation().torque(dt * np.arange(steps))
    states, y = np.empty((steps, n)), np.empty((steps, 2))
    for k in range(steps):
        x = F @ x + B * u[k] + factor @ rng.standard_normal(n)
        states[k], y[k] = x, x[:2] + 5e-3 * rng.standard_normal(2)
    return p, n, dt, F, B, Q, u, states, y


def test_linear_drive_equals_the_kalman_filter():
    for rows in ((0, 1), (0,), (1,), ()):
        p, n, dt, F, B, Q, u, _, y = linear()
        stock = KalmanFilter(dim_x=n, dim_z=max(len(rows), 1), dim_u=1)
        stock.x, stock.P = np.zeros((n, 1)), prior(p, n)[1]
        stock.F, stock.B, stock.Q = F, B[:, None], Q
        if rows:
            stock.H, stock.R = np.eye(n)[list(rows)], 25e-6 * np.eye(len(rows))
        seen = np.full_like(y, np.nan)
        seen[:, list(rows)] = y[:, list(rows)]
        records = filtered(p, n, *prior(p, n), np.full(len(y), dt), u, np.zeros(len(y)), seen)
        z, P, *_ = unpack(records, n)
        xs, Ps = [], []
        for k in range(len(y)):
            stock.predict(u=u[k])
            if rows:
                stock.update(y[k, list(rows)])
            xs.append(stock.x.ravel())
            Ps.append(stock.P)
        np.testing.assert_allclose(z, xs, rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(P, Ps, rtol=1e-7, atol=1e-10)
        if len(rows) < 2:
            continue
        # The smoother against filterpy's over the same block; its sequence starts after the first.
        block = slice(200, 500)
        sub = KalmanFilter(dim_x=n, dim_z=2)
        sub.F, sub.Q = F, Q
        # filterpy predicts without an input: compare deviations from the free response.
        free = np.zeros((len(y), n))
        for k in range(1, len(y)):
            free[k] = F @ free[k - 1] + B * u[k]
        mu = (np.array(xs) - free)[block]
        Xs, PsS, _, _ = sub.rts_smoother(mu[:, :, None], np.array(Ps)[block])
        got = smoothed(records, n, 499, 200, 499)
        np.testing.assert_allclose(got[:, S_TAU_K], (Xs[:, :, 0] + free[block])[:, 4],
                                   rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(got[:, S_TAU_K_STD] ** 2, PsS[:, 4, 4], rtol=1e-6)


def smoothed(records, n, newest, oldest, keep_until, ring=None):
    ring = records if ring is None else ring
    out = np.zeros((keep_until - oldest + 1, N_SMOOTHED))
    smooth(Layout(n, False, -1, False), ring, Span(newest, oldest, keep_until),
           np.zeros(N_PACKED), np.zeros(n),
           np.zeros((5, n * n)), out)
    return out


def test_smoother_equals_the_oracle():
    for variant in ('paper', 'all'):
        p, constants, n = setup(variant, **{k: v for k, v in TUNED.items() if k != 'arm_load'})
        out = data(1.0)
        z0, P_0 = prior(p, n)
        dts, none = np.full(len(out.y), 1e-3), np.zeros(len(out.y))
        expected = oracle.ekf(
            (z0, P_0), (dts, out.u, none), out.y,
            (p[Q0:Q0 + n], [TUNED['r_std_motor'] ** 2, TUNED['r_std_arm'] ** 2]), 1, constants)
        records = filtered(p, n, z0, P_0, dts, out.u, none, out.y)
        z, P, _, _, z_pred, P_pred, phi = (a[600:901] for a in expected)
        zs, Ps = oracle.rts(z, P, z_pred, P_pred, phi)
        # From a ring in which the block wraps, and only its older part asked for.
        ring = np.zeros((400, record_size(n)))
        for k in range(600, 901):
            ring[k % 400] = records[k]
        got = smoothed(None, n, 900, 600, 800, ring)
        np.testing.assert_allclose(got[:, S_TAU_K], zs[:201, 4], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(got[:, S_TWIST], (zs[:, 0] - zs[:, 1])[:201], atol=1e-9)
        np.testing.assert_allclose(got[:, S_TWIST_RATE], (zs[:, 2] - zs[:, 3])[:201], atol=1e-7)
        np.testing.assert_allclose(got[:, [S_X2, S_X3, S_X4]], zs[:201, 1:4], atol=1e-7)
        np.testing.assert_allclose(got[:, S_TAU_K_STD], np.sqrt(Ps[:201, 4, 4]), rtol=1e-6)
        for column, (i, j) in ((S_TWIST_NOISE_STD, (0, 1)), (S_TWIST_RATE_NOISE_STD, (2, 3))):
            variance = Ps[:201, i, i] + Ps[:201, j, j] - 2.0 * Ps[:201, i, j]
            np.testing.assert_allclose(got[:, column], np.sqrt(variance), rtol=1e-6)
        # The newest row of a block is the filtered one.
        last = smoothed(None, n, 900, 600, 900, ring)[-1]
        assert last[S_TAU_K] == updated(records[900], n)[0][4]


def test_covariance_stays_positive_under_extremes():
    for r, q in ((1e-12, 1.0), (1e-12, 1e8), (4e-15, 1e8), (1e6, 1e-8)):
        p, _, n = setup('unknown load', q_std_tau_k=10.0 * q ** 0.5, r_std_motor=r ** 0.5,
                        r_std_arm=r ** 0.5)
        out = data(2.0)
        y = out.x[:, :2] + 1e-3 * r ** 0.5 * np.random.default_rng(0).standard_normal(out.y.shape)
        y[::7, 0], y[::5, 1] = np.nan, np.nan
        records = filtered(p, n, *prior(p, n), np.full(len(y), 1e-3), out.u, np.zeros(len(y)), y)
        _, P, _, nis, *_ = unpack(records, n)
        np.testing.assert_array_equal(P, P.transpose(0, 2, 1))
        scale = np.sqrt(np.einsum('kii->ki', P))
        correlation = P / scale[:, :, None] / scale[:, None, :]
        assert np.linalg.eigvalsh(correlation).min() > -1e-9
        assert (nis >= 0).all()


def test_consistency_on_its_own_model():
    """
    NIS and NEES against their chi-square laws, 40 seeds.

    NEES at the last step is independent between seeds: sum ~ chi2(40 n). NIS of 40 x 500 steps is
    white: sum ~ chi2(40000). Each bound fails once in 10^4 for a right filter.
    """
    nees, nis = 0.0, 0.0
    for seed in range(40):
        p, n, dt, *_, u, states, y = linear(seed, 500)
        records = filtered(p, n, *prior(p, n), np.full(500, dt), u, np.zeros(500), y)
        z, P, _, scores, *_ = unpack(records, n)
        error = states[-1] - z[-1]
        nees += error @ np.linalg.solve(P[-1], error)
        nis += scores.sum()
    for total, dof in ((nees, 40 * n), (nis, 40 * 1000)):
        assert stats.chi2.ppf(5e-5, dof) < total < stats.chi2.isf(5e-5, dof)


def monitored(out, parameters, model=CASE_B, dt=1e-3):
    stamps = 10 ** 9 + np.arange(len(out.u)) * round(dt * 1e9)
    u = np.stack([out.u, np.full(len(out.u), np.nan)], axis=1)
    return Estimator(model, parameters).run(Samples(stamps, u, out.y)), stamps


def rms(a):
    return float(np.sqrt(np.mean(np.square(a))))


def test_reference_case_and_what_smoothing_removes():
    """Case B: the filtered torque lags by 20 ms, which also draws a loop that is not there."""
    out = data(20.0)
    estimates, stamps = monitored(out, TUNED)
    error = rms((estimates.tau_k - out.tau_k[1:])[500:])
    assert error == pytest.approx(1.134, rel=0.05)
    assert rms((estimates.innovation_motor)[500:]) == pytest.approx(0.0662, rel=0.05)
    assert estimates.nis[500:].mean() == pytest.approx(2.0, abs=0.06)
    at = np.searchsorted(stamps, estimates.smoothed_stamp_ns)
    assert (np.diff(at) == 1).all() and len(at) > 19800
    row = estimates.smoothed[500:]
    truth, twist = out.tau_k[at][500:], (out.x[:, 0] - out.x[:, 1])[at][500:]
    assert rms(row[:, S_TAU_K] - truth) < error / 3

    def loop(tau, where, rate):
        """Mean torque while the twist falls, less while it grows, on loaded flanks."""
        flank = np.abs(where) > 0.9
        return tau[flank & (rate < 0)].mean() - tau[flank & (rate > 0)].mean()

    rate = (out.x[:, 2] - out.x[:, 3])
    false_loop = abs(loop(estimates.tau_k[500:] - out.tau_k[501:], estimates.twist[500:],
                          rate[501:]))
    smooth_loop = abs(loop(row[:, S_TAU_K] - truth, twist, rate[at][500:]))
    assert false_loop > 0.5 and smooth_loop < 0.2 * false_loop
    spread = rms((row[:, S_TAU_K] - truth) / row[:, S_TAU_K_STD])
    assert 0.2 < spread < 1.3  # the random walk overstates: pessimistic, never over-confident


def test_process_noise_is_a_spectral_density():
    """Another rate needs no other tuning: mean NIS stays 2 (20000 samples: +-0.014 at 1 sigma)."""
    for dt in (5e-4, 1e-3, 2e-3):
        out = data(20000 * dt, dt)
        estimates, _ = monitored(out, TUNED, dt=dt)
        assert estimates.nis[500:].mean() == pytest.approx(2.0, abs=0.08), dt
