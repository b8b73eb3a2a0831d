# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Trust indicators against published values, known statistics and their stated odds."""
import itertools
import math

from drives import driven, part_of, samples_of
import numpy as np
import pytest
from scipy import stats

from benchmarks import paper
from benchmarks.trust_runs import significant
from gearbox_monitor.estimation import process_model, sample_loop
from gearbox_monitor.estimation.score import LAGS, ljung_box, WHITE_LIMIT
from gearbox_monitor.health.alarms import Level, LIMITS, Outcome
from gearbox_monitor.health.checks import innovation, observability, row_checks
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate


START = 10 ** 18
SECOND = 1_000_000_000
CASE_B = DriveModel().with_(stiffness=5.0, half_gap=0.6)
# Noise of 2 % of each state's spread; scales of the states as the prior.
REFERENCE = {'arm_load': 'none', 'r_std_motor': 0.0612, 'r_std_arm': 0.0828,
             'q_std_motor_position': 0.0612, 'q_std_arm_position': 0.0828,
             'q_std_motor_speed': 0.358, 'q_std_arm_speed': 0.472, 'q_std_tau_k': 10.0,
             'p0_std_speed': 20.0, 'p0_std_torque': 3.6}
BOTH, ARM_LOST, MOTOR_LOST = (True, True), (True, False), (False, True)


def samples(seconds, model, noise, dt=1e-3, seed=1):
    return samples_of(driven(model, seconds, noise, seed, dt), dt, START)


def default_samples(seconds, model=None, scale=1.0, **kwargs):
    noise = Noise((0.0, 0.0, 0.4, 0.4), (0.005 * scale, 0.005 * scale))
    return samples(seconds, model or DriveModel(), noise, **kwargs)


@pytest.fixture(scope='module')
def moving():
    """Return (rows of 6 s of case B, packed parameters)."""
    monitor = Monitor(CASE_B, REFERENCE)
    data = samples(6.0, CASE_B, Noise((0.0612, 0.0828, 0.358, 0.472), (0.0612, 0.0828)))
    return monitor.run(data).rows, monitor.estimator.packed


def share(rows, packed, seen, n=5):
    """Return [n] shares; a state beyond the first five is an unknown load of zero."""
    states = np.zeros((len(rows), n))
    states[:, :5] = rows[:, :5]
    return observability.information_share(
        states, rows[:, sample_loop.E_DT].copy(), np.tile(seen, (len(rows), 1)), packed)


# Published medians while moving, for windows of so many milliseconds.
SHARES = {50: (0.161, 0.177, 0.643), 100: (0.030, 0.072, 0.152)}


def test_information_share_ranks_what_was_lost(moving):
    for window in SHARES:
        rows, packed = moving
        starts = range(1000, 5800, 400)
        medians = [np.median([share(rows[a:a + window], packed, seen)[4] for a in starts])
                   for seen in (BOTH, ARM_LOST, MOTOR_LOST)]
        assert medians[0] < medians[1] < medians[2]
        np.testing.assert_allclose(medians, SHARES[window], rtol=0.15)
        assert share(rows[1000:1000 + window], packed, (False, False))[4] > 0.99


def test_information_share_with_an_unknown_load(moving):
    """The same order for tau_K; the load itself needs both encoders."""
    rows, _ = moving
    packed = Monitor(CASE_B, {**REFERENCE, 'arm_load': 'unknown'}).estimator.packed
    shares = np.median([[share(rows[a:a + 100], packed, seen, 6) for seen in
                         (BOTH, ARM_LOST, MOTOR_LOST)] for a in range(1000, 5800, 400)], axis=0)
    tau_k, tau_arm = shares[:, 4], shares[:, 5]
    assert tau_k[0] < tau_k[1] < LIMITS.untrusted < tau_k[2]
    assert tau_arm[0] < LIMITS.untrusted < min(tau_arm[1:])


LOADS = [{'id': 'gravity', 'G': 2.3}, {'id': 'arm_coulomb', 'Cac': 1.65}]


def test_gramian_against_the_exact_tangent(moving):
    """The cheap linearised steps agree with the filter's own map, at rest and moving."""
    for effects in ([], LOADS):
        rows, _ = moving
        packed = Monitor(CASE_B.with_(effects=effects), REFERENCE).estimator.packed
        for states in (rows[2000:2100, :5].copy(), np.zeros((100, 5))):
            phi, z, product, gramian = np.empty((5, 5)), np.empty(5), np.eye(5), np.zeros((5, 5))
            for state in states:
                information = np.diag(1.0 / packed[[process_model.R1, process_model.R2]])
                gramian += product[:2].T @ information @ product[:2]
                z[:] = state
                process_model.propagate(process_model.layout_of(packed, 5), z, phi.reshape(-1),
                                        (0.0, 0.0), 1e-3, 8, packed)
                product = phi @ product
            scale = np.array([1.0, 1.0, 20.0, 20.0, 3.6])
            exact = np.sqrt(np.diag(np.linalg.inv(scale[:, None] * gramian * scale + np.eye(5))))
            seen = np.ones((100, 2), bool)
            ours = observability.information_share(states, np.full(100, 1e-3), seen, packed)
            np.testing.assert_allclose(ours, exact, rtol=0.03)


def judge(shares, tau_arm=None):
    named = {'tau_k': shares[4], 'x3': shares[2]}
    if tau_arm is not None:
        named['tau_arm'] = tau_arm
    return observability.check(named, 0.2, {})


def test_standstill_hides_the_speed_not_the_torque(moving):
    _, packed = moving
    rows = np.zeros((100, sample_loop.N_ESTIMATE))
    rows[:, sample_loop.E_DT] = 1e-3
    both, arm_lost, motor_lost = (share(rows, packed, s) for s in (BOTH, ARM_LOST, MOTOR_LOST))
    assert both[4] == pytest.approx(0.142, rel=0.05) and both[2] > 0.95
    assert arm_lost[4] == pytest.approx(0.722, rel=0.05)
    assert motor_lost[4] == pytest.approx(0.143, rel=0.05)
    outcome = judge(both)
    assert outcome.level == Level.OK and 'standstill' in outcome.message
    assert judge(arm_lost).level == Level.ERROR
    assert judge([0, 0, 0, math.nan, math.nan]).level == Level.ERROR
    # The default drive with an unknown load stands still, too.
    packed = Monitor(DriveModel()).estimator.packed
    both = share(rows, packed, BOTH, 6)
    outcome = judge(both, both[5])
    assert outcome.level == Level.OK and 'standstill' in outcome.message
    assert 'load' not in outcome.message and 'load' in judge(both, 0.9).message


def test_lost_encoder_under_an_unknown_load_with_precise_encoders():
    """100 ms of an exact model would see tau_K there; what the filter states does not."""
    for lost in (0, 1):
        noise = Noise((0.0, 0.0, 0.4, 0.4), (5e-5, 5e-5))
        data = samples(16.0, DriveModel(), noise)
        data.y[6000:, lost] = np.nan
        monitor = Monitor(DriveModel(), {'r_std_motor': 5e-5, 'r_std_arm': 5e-5})
        for begin, level in ((0, Level.OK), (6000, Level.ERROR)):
            end = begin + 6000 if begin == 0 else 16000
            monitor.run(part_of(data, begin, end))
            found = monitor.outcomes['observability']
            assert found.level == level
        assert found.values['information_share_tau_k'] < 0.5  # of what both encoders tell
        assert found.values['stated_share_tau_k'] > found.values['stated_share_threshold']
        assert 'above its initial value' in found.message


def test_condition_of_the_papers_jacobian(moving):
    """Equation (6): in raw units no threshold parts rest from a lost encoder, scaled one does."""
    _, packed = moving
    rest, fast = np.zeros(5), np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    for state, seen, raw, scaled in (
            (rest, BOTH, 3.7e-4, 1.0e-2), (fast, BOTH, 6.2e-3, 0.62),
            (rest, MOTOR_LOST, 2.2e-7, 3.0e-7), (fast, MOTOR_LOST, 6e-4, 1.2e-3)):
        value = observability.paper(state, np.array(seen), packed)
        assert value['condition_eq6'] == pytest.approx(raw, rel=0.05)
        assert value['condition_eq6_scaled'] == pytest.approx(scaled, rel=0.05)
        assert value['condition_eq6_p'] == 1.0  # one column: says nothing
        assert value['signal_eq6_p'] == pytest.approx(
            3.6 * math.hypot(1 / 0.006442 / 0.358, 1 / 0.023454 / 0.472), rel=1e-6)
    for seen in (ARM_LOST, (False, False)):
        value = observability.paper(fast, np.array(seen), packed)
        assert max(value['condition_eq6'], value['condition_eq6_scaled']) < 1e-12
    unknown = Monitor(CASE_B, {**REFERENCE, 'arm_load': 'unknown'}).estimator.packed
    value = observability.paper(np.append(fast, 0.0), np.array(BOTH), unknown)
    assert value['condition_eq6'] == pytest.approx(6.1e-3, rel=0.05)
    assert 0.1 < value['condition_eq6_p'] < 1.0  # of tau_K and load


def test_scaled_condition_with_the_spread_of_the_motion():
    """With columns and rows scaled by the simulated spreads, as published for case B."""
    u = Excitation().torque(1e-3 * np.arange(20000))
    run = simulate(CASE_B, u, 1e-3)
    state, rate = run.x.std(axis=0), np.gradient(run.x, 1e-3, axis=0).std(axis=0)
    packed = Monitor(CASE_B, REFERENCE).estimator.packed
    for speed, seen, expected in ((1.0, BOTH, 0.28), (1.0, MOTOR_LOST, 1.4e-3)):
        a = np.empty((5, 5))
        process_model.tangent(np.array([0, 0, speed, speed, 0.0]), np.eye(5), packed, a)
        jacobian = np.vstack([a[:4], np.eye(5)[:2] * np.array(seen)[:, None]])
        jacobian *= np.append(state, np.sqrt(np.mean(run.tau_k ** 2)))
        jacobian /= np.append(rate, state[:2])[:, None]
        s = np.linalg.svd(jacobian, compute_uv=False)
        assert expected / 1.5 < s[-1] / s[0] < 1.5 * expected


def test_ljung_box_by_hand():
    e = np.random.default_rng(0).standard_normal(500).cumsum() * 0.02 + 3.0
    d = e - e.mean()
    rho = [sum(d[i] * d[i - k] for i in range(k, 500)) / sum(d * d) for k in range(1, 21)]
    expected = 500 * 502 * sum(r * r / (500 - k) for k, r in enumerate(rho, 1))
    q, predictable = ljung_box(e)
    assert q == pytest.approx(expected, rel=1e-10)
    assert predictable == pytest.approx(sum(r * r for r in rho), rel=1e-10)
    assert ljung_box(np.zeros(500)) == (0.0, 0.0)
    # White: Q ~ chi2(20), mean 20, sd sqrt(40); 400 draws, 4 sigma.
    rng = np.random.default_rng(1)
    mean = np.mean([ljung_box(rng.standard_normal(1000))[0] for _ in range(400)])
    assert mean == pytest.approx(20.0, abs=4 * math.sqrt(40 / 400))


def check(white, recent=500):
    measured = np.isfinite(white)
    return innovation.check(
        white, np.nansum(white ** 2, axis=1), measured.sum(axis=1).astype(float), white,
        np.where(measured, 1.0, np.nan), recent, 2 * recent)


def test_correlations_of_white_errors_are_allowed_for():
    """LAGS squared ones sum to LAGS / N."""
    for count in (150, 1000):
        shares = []
        for seed in range(40):
            white = np.random.default_rng(seed).standard_normal((count, 2))
            values = check(white).values
            shares.append(values['predictable_share'])
        limit = values['predictable_share_threshold']
        assert limit == pytest.approx(LIMITS.predictable + LAGS / count)
        assert np.mean(shares) == pytest.approx(LAGS / count, rel=0.5)


def test_thresholds_have_the_stated_odds():
    """Against scipy.stats, and by drawing: the shape of each test at odds that can be drawn."""
    alpha = LIMITS.error_significance
    assert innovation.MEAN_LIMIT == pytest.approx(stats.norm.isf(alpha / 4))
    assert innovation.LJUNG_BOX_LIMIT == pytest.approx(stats.chi2.isf(alpha / 2, LAGS))
    assert LIMITS.curve_often == pytest.approx(stats.t.ppf(0.95, row_checks.BLOCKS - 1))
    assert WHITE_LIMIT == pytest.approx(stats.chi2.isf(0.025, LAGS))
    for dof in (200.0, 4000.0):
        low, high = innovation.nis_limits(dof)
        assert low * dof == pytest.approx(stats.chi2.ppf(alpha / 2, dof), rel=1e-6)
        assert high * dof == pytest.approx(stats.chi2.isf(alpha / 2, dof), rel=1e-6)
    rng = np.random.default_rng(0)
    draws = rng.standard_normal((3000, 500, 2))
    means = np.array([check(w).values['mean'] for w in draws])
    boxes = np.array([ljung_box(w[:, 0])[0] for w in draws])
    sums = (draws ** 2).sum(axis=(1, 2))
    for values, limit in ((means, stats.norm.isf(0.01 / 4)),
                          (boxes, stats.chi2.isf(0.01, LAGS)),
                          (sums, stats.chi2.isf(0.01, 1000))):
        # 30 expected of 3000; +- 4 standard deviations. The chi-square of Ljung and Box is
        # asymptotic.
        assert 8 <= (values > limit).sum() <= 55
    flagged = sum(any(significant(w, (w ** 2).sum(axis=1), np.full(500, 2.0)).values())
                  for w in draws)
    assert flagged <= 2


def case_rows(case, fault, seconds=12.0):
    """Return estimate rows of the fixed EKF with the true noise on a case of the paper."""
    model, noise, _ = paper.drive(case)
    u = Excitation().torque(1e-3 * np.arange(round(seconds * 1e3)))
    measured = np.array(noise.measurement) * (1.2 if fault == 'noise' else 1.0)
    real = model.with_(viscous_friction=0.12) if fault == 'friction' else model
    run = simulate(real, u, 1e-3, Noise(noise.process, tuple(measured)), 3)
    for encoder, name in enumerate(('motor frozen', 'arm frozen')):
        if fault == name:
            run.y[1000:, encoder] = run.y[1000, encoder]
    parameters = {
        'arm_load': 'none', 'smoother_lag': 0.0, 'r_std_motor': noise.measurement[0],
        'r_std_arm': noise.measurement[1], 'q_std_tau_k': 9.0,
        'q_std_motor_position': noise.process[0], 'q_std_arm_position': noise.process[1],
        'q_std_motor_speed': noise.process[2], 'q_std_arm_speed': noise.process[3]}
    return Monitor(model, parameters).run(paper.run_samples(run)).rows[1500:]


NOISES = [
    ('none', 0.0, 0.06), ('noise', 0.9, 1.0), ('friction', 0.95, 1.0), ('motor frozen', 0.95, 1.0),
    ('arm frozen', 0.95, 1.0)]


def expect_share(case, fault, low, high):
    rows = case_rows(case, fault, 12.0 if fault == 'none' else 7.0)
    windows = rows[:len(rows) // 500 * 500].reshape(-1, 500, sample_loop.N_ESTIMATE)
    flagged = np.mean([any(significant(
        w[:, [sample_loop.E_WHITE_1, sample_loop.E_WHITE_2]], w[:, sample_loop.E_NIS],
        w[:, sample_loop.E_DOF]).values()) for w in windows])
    assert low <= flagged <= high


def test_share_of_windows_that_any_test_flags():
    """21 windows of 0.5 s, 11 with a fault; the bounds leave room for one or two by chance."""
    for (fault, low, high), cases in zip(NOISES, ('AB', 'A', 'B', 'A', 'B')):
        for case in cases:
            expect_share(case, fault, low, high)


def test_prediction_error_names_the_fault():
    rng = np.random.default_rng(0)
    white = rng.standard_normal((2000, 2))
    assert check(white).level == Level.OK
    assert 'larger' in check(1.2 * white).message
    assert 'smaller' in check(0.8 * white).message
    assert check(2.0 * white).level == Level.ERROR
    assert 'biased' in check(white + np.array([0.3, 0.0])).message
    one = check(white * np.array([1.0, 1.3]))
    assert 'arm encoder noise' in one.message and 'motor encoder noise' not in one.message
    assert one.values['variance_ratio_arm'] == pytest.approx(1.69, rel=0.15)
    hit = white.copy()
    hit[-700, 0] = 7.0
    assert 'outliers' in check(hit).message
    assert check(hit).values['test_ratio'] == pytest.approx(1.4)
    hit[-700, 0], hit[-1200, 0] = 0.0, 7.0  # before the window of the gate
    assert check(hit).level == Level.OK
    coloured = white.copy()
    for k in range(1, 2000):
        coloured[k, 1] = 0.5 * coloured[k - 1, 1] + math.sqrt(0.75) * white[k, 1]
    assert 'not white' in check(coloured).message
    alone = white.copy()
    alone[:, 0] = np.nan
    assert check(alone).level == Level.OK
    assert check(white[:50]).level == Level.WARN
    assert check(np.full((2000, 2), np.nan)).level == Level.WARN


def found(monitor, component, data):
    """Return the raw outcomes of a check while `data` is run."""
    raw, name = [], {'prediction error': 'check', 'covariance': 'judge_covariance'}[component]
    original = getattr(innovation, name)
    try:
        setattr(innovation, name, lambda *a: raw.append(original(*a)) or raw[-1])
        monitor.run(data)
    finally:
        setattr(innovation, name, original)
    return raw


def test_faults_of_the_drive_are_found():
    for fault in ('none', 'noise', 'frozen', 'friction', 'torque scale'):
        data = default_samples(12.0, scale=1.25 if fault == 'noise' else 1.0)
        model = DriveModel()
        if fault == 'frozen':
            data.y[5000:, 1] = data.y[5000, 1]
        elif fault == 'friction':
            model = model.with_(viscous_friction=0.2, coulomb_friction=0.54)
        elif fault == 'torque scale':
            data.u[:, 0] *= 1.3
        monitor = Monitor(model, {'arm_load': 'none'})
        raw = found(monitor, 'prediction error', data)
        late = [outcome.level > Level.OK for outcome in raw[-4:]]
        assert len(raw) >= 8
        # A healthy drive may raise a single evaluation, which the alarm must not follow.
        assert sum(f.level > Level.OK for f in raw) <= 1 if fault == 'none' else all(late)
        level = monitor.outcomes['prediction error'].level
        assert level == Level.OK if fault == 'none' else level > Level.OK


def test_covariance_bounds():
    assert innovation.judge_covariance(9.0, 1.0, None).level == Level.OK
    for std, level in ((1.0, Level.OK), (0.81, Level.OK), (0.79, Level.WARN),
                       (1.29, Level.OK), (1.31, Level.WARN)):
        assert innovation.judge_covariance(9.0, std, 1.0).level == level
    data = default_samples(16.0)
    data.y[10000:, 0] = np.nan
    raw = found(Monitor(DriveModel()), 'covariance', data)
    assert [f.level for f in raw[:7]] == [Level.OK] * 7 and raw[-1].level == Level.WARN
    assert 'above' in raw[-1].message


def test_reference_of_the_uncertainty_is_that_of_noise_alone():
    monitor = Monitor(DriveModel())
    monitor.run(default_samples(8.0))
    values = monitor.outcomes['covariance'].values
    assert values['reference'] == pytest.approx(values['tau_k_noise_std'], rel=0.05)
    assert values['reference'] < values['tau_k_std']
    monitor.reset()
    assert all(monitor.outcomes[name].level == Level.WARN
               for name in ('observability', 'prediction error', 'covariance', 'input'))


def test_one_evaluation_per_second_of_stamps():
    for dt, disturbed in ((5e-4, False), (1e-2, True), (1e-3, True)):
        data = default_samples(6.0, dt=dt)
        if disturbed:
            data.stamp_ns[1::5] -= 7 * SECOND
            data.stamp_ns[3::5] += 7 * SECOND
            data.stamp_ns[4::50] = 0
        monitor, at = Monitor(DriveModel()), []
        judge = monitor._check_input
        monitor._check_input = lambda stamps, stamp: at.append(stamp) or judge(stamps, stamp)
        monitor.run(data)
        assert len(at) == 5
        assert all(SECOND <= b - a < 1.05 * SECOND for a, b in itertools.pairwise(at))
        assert isinstance(monitor.outcomes['input'], Outcome)
