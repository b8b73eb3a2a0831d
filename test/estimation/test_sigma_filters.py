# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""UKF, SRUKF and the EKF's options against exact cases, filterpy and one another."""

from drives import interrupted, part_of
from filterpy.kalman import KalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter
import numpy as np
import oracle
import pytest
from test_filter import data, linear, monitored, prior, rms, setup, TUNED, VARIANTS

from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.filter_kind import (
    Belief, filter_kind, predicted, Reading, record_size, Scratch, updated)
from gearbox_monitor.estimation.filters import ekf, srukf, ukf
from gearbox_monitor.estimation.filters.srukf import triangularise
from gearbox_monitor.estimation.process_model import (
    EIGENVALUE, layout_of, Q0, softened_sharpness, X1, X2, X3)
from gearbox_monitor.kernels.kernel import Entry
from gearbox_monitor.parameters import FILTER_NAMES
from gearbox_monitor.plant.drive import ALPHA, CAC, DriveModel, substeps
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate

CASE_A = DriveModel().with_(kind='play', stiffness=5.0, half_gap=0.3, hysteresis_width=0.3)
STEPS = {module: Entry(module.step) for module in (ekf, ukf, srukf)}
KINDS = {'statistical': (ekf, {'friction_linearisation': 'statistical'}),
         'ukf': (ukf, {}), 'srukf': (srukf, {})}


def filtered(module, p, start, inputs, y):
    """Run a filter from `start` (z, P) over (dts, u, load); return records [N, record_size]."""
    kind, (z, P), (dts, u, load), n = module.FILTER, start, inputs, len(start[0])
    belief = Belief(np.array(z, float), np.array(P, float).ravel(),
                    np.zeros(kind.memory_size(n)))
    scratch = Scratch(np.zeros((kind.n_vectors, n)), np.zeros((max(kind.n_matrices, 5), n * n)))
    records = np.zeros((len(dts), record_size(n)))
    for k, dt in enumerate(dts):
        assert STEPS[module](layout_of(p, n), belief, Reading(dt, u[k], load[k], *y[k]), p,
                             scratch, records[k])
    return records


def relative(got, expected, n):
    """Return the largest difference of records: states by the largest, P, C by the deviations."""
    worst = 0.0
    for a, b in zip(got, expected):
        (za, Pa, Ca), (zb, Pb, Cb) = predicted(a, n), predicted(b, n)
        scale = np.outer(*[np.sqrt(np.diag(Pb))] * 2)
        (zua, Pua), (zub, Pub) = updated(a, n), updated(b, n)
        for x, y in ((Pa, Pb), (Ca, Cb), (Pua, Pub)):
            worst = max(worst, np.abs((x - y) / scale).max())
        for x, y in ((za, zb), (zua, zub)):
            worst = max(worst, np.abs((x - y) / (1.0 + np.abs(y))).max())
        for x, y in zip(oracle.correction(a, n), oracle.correction(b, n)):
            np.testing.assert_array_equal(np.isnan(x), np.isnan(y))
            size = 1.0 + np.nanmax(np.abs(y), initial=0.0)
            worst = max(worst, np.nanmax(np.abs(x - y), initial=0.0) / size)
    return worst


@pytest.mark.parametrize('kind, rows', [
    ('statistical', (1,)),
    *(pytest.param(kind, rows, marks=pytest.mark.system)
      for kind in ('ukf', 'srukf') for rows in ((0, 1), (0,), (1,), ()))])
def test_linear_drive_equals_the_kalman_filter(kind, rows):
    _, n, dt, F, B, Q, u, _, y = linear(steps=700)
    module, options = KINDS[kind]
    close = 1e-9
    p, _, _ = setup('unknown load', DriveModel().with_(coulomb_friction=0.0),
                    q_std_motor_position=0.01, q_std_arm_position=0.01, **options)
    stock = KalmanFilter(dim_x=n, dim_z=max(len(rows), 1), dim_u=1)
    stock.x, stock.P = np.zeros((n, 1)), prior(p, n)[1]
    stock.F, stock.B, stock.Q = F, B[:, None], Q
    if rows:
        stock.H, stock.R = np.eye(n)[list(rows)], 25e-6 * np.eye(len(rows))
    seen = np.full_like(y, np.nan)
    seen[:, list(rows)] = y[:, list(rows)]
    records = filtered(
        module, p, prior(p, n), (np.full(len(y), dt), u, np.zeros(len(y))), seen)
    for k, record in enumerate(records):
        before = stock.P.copy()
        stock.predict(u=u[k])
        z_pred, P_pred, cross = predicted(record, n)
        scale = np.outer(*[np.sqrt(np.diag(stock.P))] * 2)
        # One encoder leaves speeds unknown: what is estimated then grows to hundreds of rad/s.
        size = close * max(1.0, np.abs(stock.x).max())
        np.testing.assert_allclose(z_pred, stock.x.ravel(), rtol=0.0, atol=size)
        np.testing.assert_allclose(P_pred / scale, stock.P / scale, rtol=0.0, atol=close)
        np.testing.assert_allclose(cross / scale, F @ before / scale, rtol=0.0, atol=close)
        if rows:
            stock.update(y[k, list(rows)])
        z, P = updated(record, n)
        np.testing.assert_allclose(z, stock.x.ravel(), rtol=0.0, atol=size)
        scale = np.outer(*[np.sqrt(np.diag(stock.P))] * 2)
        np.testing.assert_allclose(P / scale, stock.P / scale, rtol=0.0, atol=close)
        _, _, _, (_, loglik, dof) = oracle.correction(record, n)
        assert dof == len(rows)
        if rows:
            near = 10 * close
            assert loglik == pytest.approx(stock.log_likelihood, rel=near, abs=near)


def test_equals_filterpy_ukf():
    """Textbook weights; in the covariance the last centre counts less, then not at all."""
    for alpha, beta, kappa in ((0.5, 2.0, 1.0), (1.3, 0.5, 0.5), (1.0, 0.0, 0.0)):
        p, constants, n = setup(
            'unknown load', ukf_alpha=alpha, ukf_beta=beta, ukf_kappa=kappa,
            **{k: v for k, v in TUNED.items() if k != 'arm_load'})
        out = data(0.15)
        counted = substeps(1e-3, p[EIGENVALUE])
        points = MerweScaledSigmaPoints(n, alpha, beta, kappa)
        stock = UnscentedKalmanFilter(
            n, 2, 1e-3, lambda x: x[:2],
            lambda x, dt, u: oracle.flow(x, u, 0.0, dt, counted, constants)[0], points)
        stock.x, stock.P = prior(p, n)
        stock.R = np.diag([TUNED['r_std_motor'] ** 2, TUNED['r_std_arm'] ** 2])
        stock.Q = 0.5e-3 * np.diag(p[Q0:Q0 + n])
        inputs = np.full(len(out.y), 1e-3), out.u, np.zeros(len(out.y))
        ours = [filtered(module, p, prior(p, n), inputs, out.y) for module in (ukf, srukf)]
        for k, y in enumerate(out.y):
            stock.P = stock.P + stock.Q
            stock.predict(u=out.u[k])
            stock.sigmas_f = points.sigma_points(stock.x, stock.P)
            stock.update(y)
            for records in ours:
                z, P = updated(records[k], n)
                np.testing.assert_allclose(z, stock.x, rtol=1e-8, atol=1e-8)
                np.testing.assert_allclose(P, stock.P, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize('variant', [
    variant if variant == 'unknown load' else pytest.param(variant, marks=pytest.mark.system)
    for variant in VARIANTS])
def test_square_root_form_is_the_ukf(variant):
    p, _, n = setup(variant, **{k: v for k, v in TUNED.items() if k != 'arm_load'})
    out = data(1.0)
    rng = np.random.default_rng(0)
    y = out.y.copy()
    y[rng.random(y.shape) < 0.2] = np.nan
    dts = np.full(len(y), 1e-3)
    dts[::50] = 4e-3
    args = p, prior(p, n), (dts, out.u, 0.3 * np.sin(out.t)), y
    assert relative(filtered(srukf, *args), filtered(ukf, *args), n) < 1e-6


def test_sigma_points_feel_the_loads_of_the_model():
    """Where friction does not bend, EKF and UKF differ by the sine of the weight alone."""
    tuned = {**TUNED, 'r_std_motor': 1e-3, 'r_std_arm': 1e-3}
    p, _, n = setup('all', DriveModel().with_(coulomb_friction=0.0),
                    **{k: v for k, v in tuned.items() if k != 'arm_load'})
    p[CAC] = 0.0
    out = data(0.5)
    args = p, prior(p, n), (np.full(500, 1e-3), out.u, np.zeros(500)), out.y
    assert 0.0 < relative(filtered(ukf, *args), filtered(ekf, *args), n) < 1e-5


def test_reference_case():
    out, error = data(10.0), {}
    for name, options in {
            'ekf': {}, 'statistical': {'friction_linearisation': 'statistical'},
            'ukf': {'filter': 'ukf'}, 'srukf': {'filter': 'srukf'},
            'narrow': {'filter': 'ukf', 'ukf_alpha': 1e-3}}.items():
        estimates, _ = monitored(out, {**TUNED, 'arm_load': 'unknown', **options})
        assert estimates.nis[500:].mean() == pytest.approx(2.0, abs=0.1)
        assert len(estimates.smoothed) > 9800
        error[name] = rms((estimates.tau_k - out.tau_k[1:])[500:])
    for name in error:
        close = 0.2 if name == 'narrow' else 0.01
        assert error[name] == pytest.approx(error['ekf'], rel=close), name
    assert error['srukf'] == pytest.approx(error['ukf'], rel=1e-6)
    assert error['narrow'] > 1.02 * error['ukf']


def test_square_root_form_survives_tiny_noise_without_process_noise():
    """Encoders of 6.6 urad and nothing that would rescue a covariance: no restart, same error."""
    tuned = {**TUNED, 'arm_load': 'unknown', 'r_std_motor': 6.58e-6, 'r_std_arm': 8.33e-6}
    tuned.update({k: 0.0 for k in tuned if k.startswith('q_std') and k != 'q_std_tau_k'})
    out = simulate(CASE_A, Excitation().torque(1e-3 * np.arange(6000)), 1e-3,
                   Noise((0.0,) * 4, (6.58e-6, 8.33e-6)), 1)
    estimates, _ = monitored(out, {**tuned, 'filter': 'srukf'}, CASE_A)
    assert len(estimates.rows) == 5999
    assert rms((estimates.tau_k - out.tau_k[1:])[500:]) == pytest.approx(0.116, rel=0.1)


def test_covariance_stays_positive_under_extremes():
    for module in (ukf, srukf):
        p, _, n = setup('unknown load', q_std_tau_k=1e5, r_std_motor=1e-6, r_std_arm=1e-6,
                        ukf_alpha=1e-3)
        out = data(2.0)
        y = out.x[:, :2] + 1e-6 * np.random.default_rng(0).standard_normal(out.y.shape)
        y[::7, 0], y[::5, 1] = np.nan, np.nan
        inputs = np.full(len(y), 1e-3), out.u, np.zeros(len(y))
        records = filtered(module, p, prior(p, n), inputs, y)
        for record in records:
            _, P = updated(record, n)
            scale = np.sqrt(np.diag(P))
            assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > -1e-9


def test_triangularise_with_a_diagonal_tail():
    rng = np.random.default_rng(0)
    for dense, n in ((0, 5), (12, 6)):
        block = rng.standard_normal((dense or n, n))
        a = np.vstack([block if dense else np.triu(block), np.diag(rng.random(n) + [0.0] * n)])
        a[-2] = 0.0  # a state without process noise
        gram = a.T @ a
        triangularise(a, n, dense, dense or n)
        np.testing.assert_allclose(np.triu(a[:n]).T @ np.triu(a[:n]), gram, atol=1e-13)


def test_statistical_linearisation_has_the_slope_of_the_mean_friction():
    p, _, _ = setup()
    assert softened_sharpness(p[ALPHA], 0.0) == pytest.approx(p[ALPHA], rel=1e-12)
    std = 2.4  # E[sign(v)] of v ~ N(m, std^2) has the slope sqrt(2 / pi) / std at m = 0
    soft = softened_sharpness(p[ALPHA], std ** 2)
    assert 2.0 / np.pi * soft == pytest.approx(np.sqrt(2.0 / np.pi) / std, rel=1e-3)


def test_narrow_sigma_points_are_warned_of():
    model = DriveModel()
    for name in ('ukf', 'srukf'):
        assert Estimator(model, {'filter': name}).warnings == []
        estimator = Estimator(model, {'filter': name, 'ukf_alpha': 1e-3})
        assert len(estimator.warnings) == 1 and '-1e+06' in estimator.warnings[0]
        estimator.set_parameters({'ukf_alpha': 1.0})
        assert estimator.warnings == []
    assert Estimator(model, {'ukf_alpha': 1e-3}).warnings == []


def test_every_filter_is_chosen_by_its_name():
    """Each differs from the EKF where friction bends, though by little."""
    assert all(filter_kind(name).step.__module__.endswith(f'.{name}') for name in FILTER_NAMES)
    assert set(FILTER_NAMES) >= {'ekf', 'ukf', 'srukf', 'aekf'}
    samples = part_of(interrupted(), 0, 300)
    rows = {name: Estimator(DriveModel(), {'filter': name}).run(samples)
            for name in ('ekf', 'ukf', 'srukf')}
    for name in ('ukf', 'srukf'):
        for state, std in ((X1, 0.005), (X2, 0.005), (X3, 0.5)):
            apart = np.abs(rows[name].rows[:, state] - rows['ekf'].rows[:, state]).max()
            assert 0.0 < apart < 4 * std
