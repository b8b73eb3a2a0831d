# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash features: exact curves, statistics on simulated drives, a real drive."""
import math
from pathlib import Path
from types import SimpleNamespace

from drives import driven, part_of, samples_of
import numpy as np
import pytest

from benchmarks import paper
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_MOTOR_SIDE, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_U, S_X3, S_X4)
from gearbox_monitor.files.user_files import load_model, load_parameters
from gearbox_monitor.health.backlash import features
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.drive import DriveModel, TWO_OVER_PI
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Plant
from gearbox_monitor.plant.transmission import KINDS, transmission_torque
from gearbox_monitor.recordings.reading import read_mapping, ReadOptions
from gearbox_monitor.recordings.si_signals import signals_of
from gearbox_monitor.report.sentences import phrase

ROOT = Path(__file__).parents[2]
REAL = ROOT.parent / 'shared' / 'data' / 'davinci_backend'
# What "benchmarks paper" tunes for its two drives.
TUNED = {
    'A': {'q_std_motor_position': 0.06584, 'q_std_arm_position': 0.08325,
          'q_std_motor_speed': 0.3855, 'q_std_arm_speed': 0.4771, 'r_std_motor': 0.06556,
          'r_std_arm': 0.08315, 'q_std_tau_k': 9.086},
    'B': {'q_std_motor_position': 0.06119, 'q_std_arm_position': 0.08283,
          'q_std_motor_speed': 0.357, 'q_std_arm_speed': 0.4714, 'r_std_motor': 0.06092,
          'r_std_arm': 0.08272, 'q_std_tau_k': 8.897}}


def curve(kind, stiffness, half_gap, width=0.0, hysteresis_stiffness=0.0, zero=0.0,
          friction=(0.0, 0.0), gain=0.0):
    """Return exact rows [4000, N_SMOOTHED]: a motion whose friction does not follow the twist."""
    t = np.linspace(0.0, 10.0, 4000)
    rows = np.zeros((len(t), N_SMOOTHED))
    rows[:, S_TWIST] = np.sin(5.7 * t) + 0.5 * np.sin(14.0 * t)
    rows[:, S_X3] = 12.0 * np.cos(4.1 * t) + 6.0 * np.sin(11.0 * t)
    memory = 0.0
    for k, twist in enumerate(rows[:, S_TWIST]):
        rows[k, S_TAU_K], memory = transmission_torque(
            twist, memory, KINDS.index(kind), stiffness, half_gap, width, hysteresis_stiffness)
    rows[:, S_U] = 0.8 * rows[:, S_TAU_K] + 2.0 * np.sin(23.0 * t)
    rows[:, S_TAU_K] += (friction[0] * rows[:, S_X3] - gain * rows[:, S_U] + friction[1]
                         * TWO_OVER_PI * np.arctan(100.0 * rows[:, S_X3]))
    rows[:, S_TWIST] += zero
    rows[:, S_MOTOR_SIDE] = rows[:, S_TAU_K]
    return rows


CURVES = [
    ('dead_zone', 0.0, 0.0, 0.8, 0.0),
    ('play', 0.15, 0.0, 1.1, 2.1),
    ('passive_play', 0.1, 5.0, 0.8, -1.0)]


def test_exact_curves():
    for friction, gain in (((0.0, 0.0), 0.0), ((-0.01, 0.2), 0.03)):
        for kind, width, k_s, gap, height in CURVES:
            rows = curve(kind, 7.0, 0.4, width, k_s, 0.3, friction, gain)
            found = features.fit(rows, DriveModel(), 5)
            assert found.stamp_ns == 5 and found.separable
            assert found.gap == pytest.approx(gap, rel=2e-3)
            assert found.stiffness == pytest.approx(7.0, rel=2e-3)
            assert found.hysteresis == pytest.approx(height, abs=0.02)
            assert found.zero == pytest.approx(0.3, abs=2e-3)
            assert found.passive == (kind == 'passive_play')
            assert found.width == pytest.approx(width, abs=2e-3)
            assert found.viscous == pytest.approx(friction[0], abs=2e-4)
            assert found.coulomb == pytest.approx(friction[1], abs=5e-3)
            assert found.gain == pytest.approx(gain, abs=2e-3)


def test_no_gap_at_all_is_one_of_nearly_nothing():
    found = features.fit(curve('dead_zone', 7.0, 0.0), DriveModel(), 5)
    assert found.gap < 0.01 and found.stiffness == pytest.approx(7.0, rel=0.01)


def test_what_strokes_and_windows_scatter_by_is_stated():
    """Each stroke counts once, but for one of 5 samples; windows as they scatter, or more."""
    random = np.random.default_rng(2)
    medians = 0.015 + 1e-3 * random.standard_normal((2, 8))
    strokes = [np.full(100, sign * m) for pair in medians.T for sign, m in zip((1.0, -1.0), pair)]
    strokes[8] = np.concatenate([strokes[8][:45], np.full(5, -0.08), strokes[8][45:]])
    speed = np.sign(np.concatenate(strokes))

    def lost_motion(twist, speed):
        rows = np.zeros((len(twist) + 100, N_SMOOTHED))
        rows[:len(twist), S_TWIST], rows[:len(twist), S_X4] = twist + 0.4, speed
        rows[len(twist):, S_TWIST], rows[len(twist):, S_X4] = 9.0, 0.15 * speed[0]  # slow
        return features.lost_motion_of(rows)
    lost, std = lost_motion(np.concatenate(strokes), speed)
    up, down = (np.concatenate([s[s * sign > 0.0] for s in strokes]) for sign in (1.0, -1.0))
    assert lost == pytest.approx(np.median(up) - np.median(down), rel=1e-12)
    halves = [*medians[0][:4], *[medians[0][4]] * 2, *medians[0][5:]]  # a short one parts one
    assert std == pytest.approx(math.sqrt(
        np.var(halves, ddof=1) / 9 + np.var(medians[1], ddof=1) / 8), rel=1e-9)
    once = np.concatenate([np.linspace(0.1, 0.2, 300), np.linspace(-0.1, -0.4, 300)])
    assert lost_motion(once, np.sign(once)) == pytest.approx(
        (0.4, math.hypot(0.5 * np.std(once[:300]), 0.5 * np.std(once[300:]))))

    def windows(values, stated):
        return [SimpleNamespace(gap=v, gap_std=stated) for v in values]
    for values, stated, relative, expected in (
            ((1.0, 2.0, 3.0), 0.1, 0.0, 1.0 / math.sqrt(3.0)),
            ((1.0, 2.0, 3.0, math.nan), 2.0, 0.0, 2.0 / math.sqrt(3.0)),
            ((2.0,), 0.3, 0.2, 0.5)):
        found = features.combine(windows(values, stated), 'gap', relative)
        assert found.value == 2.0 and found.std == pytest.approx(expected)
    assert features.combine(windows((math.nan,), 0.1), 'gap') is None
    x, y, counts = random.standard_normal(9), random.standard_normal(9), np.arange(1, 10)
    assert features._correlation(x, y, 1.0 * counts) == pytest.approx(
        np.corrcoef(np.repeat(x, counts), np.repeat(y, counts))[0, 1])
    assert features._correlation(x, np.ones(9), 1.0 * counts) == 0.0


def test_units_do_not_matter():
    """A stiff joint whose twist is tenths of a mrad is fitted as well as a soft drive."""
    for angle, torque in ((1e-4, 20.0), (1e3, 1.0)):
        rows = curve('dead_zone', 7.0, 0.4, zero=0.05, friction=(0.02, -0.1), gain=0.03)
        rows[:, S_TWIST] *= angle
        rows[:, [S_TAU_K, S_MOTOR_SIDE, S_U]] *= torque
        model = DriveModel()
        found = features.fit(rows, model.with_(
            viscous_friction=torque * model.viscous_friction,
            coulomb_friction=torque * model.coulomb_friction), 0)
        assert found.gap == pytest.approx(0.8 * angle, rel=2e-3)
        assert found.stiffness == pytest.approx(7.0 * torque / angle, rel=2e-3)
        assert found.viscous == pytest.approx(0.02 * torque, rel=1e-2)
        assert found.coulomb == pytest.approx(-0.1 * torque, rel=5e-2)


def test_a_short_visit_to_the_other_flank_is_enough():
    """An arm that bears weight loads the second flank for a hundredth of the window."""
    t = np.linspace(0.0, 20.0, 20000)
    rows = np.zeros((len(t), N_SMOOTHED))
    rows[:, S_TWIST] = 1e-3 * (2.62 + 0.9 * np.sin(1.3 * t) + 2.2 * np.cos(0.9 * t + 0.4))
    half_gap = 3e-4
    rows[:, S_TAU_K] = 2e4 * np.sign(rows[:, S_TWIST]) * np.maximum(
        np.abs(rows[:, S_TWIST]) - half_gap, 0.0)
    rows[:, S_MOTOR_SIDE] = rows[:, S_TAU_K]
    below = (rows[:, S_TWIST] < -half_gap).mean()
    found = features.fit(rows, DriveModel().with_(coulomb_friction=0.0), 0)
    assert 0.01 < below < 0.02 and found.flank == pytest.approx(below, abs=1e-3)
    assert found.gap == pytest.approx(2.0 * half_gap, rel=1e-2)


def test_the_torque_that_is_fitted_decides_whether_gap_and_compliance_separate():
    """Not the estimated one: a filter that expects another curve draws it there."""
    rows = curve('dead_zone', 7.0, 0.4)
    rows[:, S_TAU_K] = 2.0 * np.sign(rows[:, S_TWIST]) * (np.abs(rows[:, S_TWIST]) > 0.4)
    found = features.fit(rows, DriveModel(), 0)
    assert found.separable and found.gap == pytest.approx(0.8, rel=2e-3)


REASONS = [
    (np.zeros((3000, N_SMOOTHED)), 'stands still'),
    (np.zeros((10, N_SMOOTHED)), 'too few samples: 10'),
    (curve('dead_zone', 7.0, 2.0), 'stands still or is not loaded'),
    (curve('dead_zone', 7.0, 0.4, zero=0.9), None)]


def test_reasons():
    for rows, reason in REASONS:
        found = features.fit(rows, DriveModel(), 3)
        if reason is None:
            assert found.zero == pytest.approx(0.9, abs=1e-3)
        else:
            assert isinstance(found, features.NotExcited) and found.stamp_ns == 3
            assert reason in phrase(found.said)


def test_one_flank_and_one_crossing_are_not_enough():
    t = np.linspace(0.0, 1.0, 3000)
    for twist, reason in ((0.8 + 0.3 * np.sin(20 * t), 'one flank'), (2 * t - 1, 'crossed 1')):
        rows = np.zeros((len(t), N_SMOOTHED))
        rows[:, S_TWIST] = twist
        rows[:, S_TAU_K] = 7.0 * np.sign(twist) * np.maximum(np.abs(twist) - 0.3, 0.0)
        rows[:, S_MOTOR_SIDE] = rows[:, S_TAU_K]
        rows[:, S_TAU_K_NOISE_STD] = 0.01
        assert reason in phrase(features.fit(rows, DriveModel(), 0).said)


def on_one_flank(speed, gain=0.0):
    """Return rows of a joint whose weight keeps one flank loaded, with a friction error."""
    t = np.linspace(0.0, 20.0, 20000)
    rng = np.random.default_rng(4)
    rows = np.zeros((len(t), N_SMOOTHED))
    rows[:, S_X3] = speed(t)
    rows[:, S_TAU_K] = -40.0 - 30.0 * np.sin(1.1 * t)
    rows[:, S_TWIST] = rows[:, S_TAU_K] / 2e4 - 3e-4 + 1e-6 * rng.standard_normal(len(t))
    rows[:, S_U] = rows[:, S_TAU_K] + 12.0 * np.cos(2.7 * t)
    rows[:, S_MOTOR_SIDE] = (
        rows[:, S_TAU_K] + 0.3 * rows[:, S_X3] - gain * rows[:, S_U]
        + 1.5 * TWO_OVER_PI * np.arctan(100.0 * rows[:, S_X3]))
    return rows


def test_friction_of_a_motion_on_one_flank():
    for gain in (0.0, 0.05):
        model = DriveModel().with_(coulomb_friction=6.0, viscous_friction=5.0)
        rows = on_one_flank(lambda t: np.cos(1.7 * t), gain)
        window = features.fit(rows, model, 3)
        assert isinstance(window, features.NotExcited) and window.reason == 'one_flank_loaded'
        friction = window.friction
        assert friction.coulomb == pytest.approx(1.5, abs=0.02) and friction.coulomb_std < 0.1
        assert friction.viscous == pytest.approx(0.3, abs=0.05)
        assert friction.speed == pytest.approx(0.7, abs=0.05)
        assert friction.load == pytest.approx(
            math.sqrt(np.mean(rows[:, S_TAU_K] ** 2)), rel=gain + 0.01)
        # In one direction Coulomb friction is an offset, as the zero of the twist is.
        model = model.with_(viscous_friction=0.0)
        assert features.fit(on_one_flank(lambda t: 1.0 + 0.0 * t), model, 3).friction is None


def test_constant_torque_on_the_flanks_is_not_separable():
    """Two torques only: any gap fits with some stiffness, the lost motion stays."""
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 20.0, 20000)
    side = np.sign(np.sin(2.0 * t))
    rows = np.zeros((len(t), N_SMOOTHED))
    rows[:, S_X4] = rows[:, S_X3] = np.sin(2.0 * t)
    rows[:, S_TWIST] = 0.015 * side + 5e-4 * rng.standard_normal(len(t))
    rows[:, S_MOTOR_SIDE] = rows[:, S_TAU_K] = 0.06 * side + 2e-3 * rng.standard_normal(len(t))
    found = features.fit(rows, DriveModel().with_(coulomb_friction=0.0), 0)
    assert not found.separable
    assert found.lost_motion == pytest.approx(0.03, rel=0.01) and found.lost_motion_std < 1e-3
    assert abs(found.gap - 0.03) < 3.0 * found.gap_std


def windows_of(case, count, parameters=None, seed=1, **changes):
    """Return fits of 10 s windows of the paper's case; `changes` are the plant's."""
    model, noise, _ = paper.drive(case)
    t = 1e-3 * np.arange(1500 + 10000 * count + 200)
    out = Plant(model.with_(**changes) if changes else model, noise, seed).run(
        Excitation().torque(t), 1e-3)
    rows = Monitor(model, {
        **TUNED[case], 'arm_load': 'none', 'drift_window': 600.0, **(parameters or {})}).run(
        samples_of(out)).smoothed
    return [features.fit(rows[1500 + 10000 * k:11500 + 10000 * k], model, k)
            for k in range(count)]


def column(windows, name):
    return np.array([getattr(w, name) for w in windows])


# Of 20 windows: their spread is known to 16 %, so the bounds of a window stand 2.5 times
# that above what 300 windows of other seeds gave (B 0.0067, A 0.0100 rad).
@pytest.mark.parametrize('case, bias, spread, off', [
    ('B', 0.015, 0.0094, 0.02), pytest.param('A', 0.025, 0.014, 0.04, marks=pytest.mark.system)])
def test_gap_of_the_papers_drives(case, bias, spread, off):
    found = windows_of(case, 20)
    for name in ('gap', 'stiffness', 'hysteresis', 'viscous'):
        stated = math.sqrt(np.mean(column(found, name + '_std') ** 2))
        empirical = column(found, name).std(ddof=1)
        assert 0.55 < stated / empirical < 2.1, name
    assert column(found, 'gap').mean() == pytest.approx(1.2, rel=bias)
    assert column(found, 'gap').std(ddof=1) < spread
    assert column(found, 'stiffness').mean() == pytest.approx(5.0, rel=off)
    assert abs(column(found, 'gap') / 1.2 - 1.0).max() < 1.5 * off
    height = 3.0 if case == 'A' else 0.0
    assert column(found, 'hysteresis').mean() == pytest.approx(height, abs=0.2)
    assert all(w.separable and w.coverage >= 10 and w.flank > 0.2 for w in found)


def test_snapshots_carry_what_is_known():
    """The window that a restored one misses is made good by the next snapshot: the same bits."""
    model, noise, _ = paper.drive('B')
    t = 1e-3 * np.arange(14200)
    out = Plant(model, noise, 4).run(Excitation().torque(t), 1e-3)
    samples = samples_of(out)
    live = Monitor(model, {**TUNED['B'], 'arm_load': 'none', 'drift_window': 2.0})
    live.run(part_of(samples, 0, 7000))
    snapshot = live.snapshot()
    later = Monitor.restore(snapshot)
    for monitor in (live, later):
        monitor.run(part_of(samples, 7000, 9600))
    assert live.windows and not later.windows
    later.adopt_baseline(live.snapshot())
    for monitor in (live, later):
        monitor.run(part_of(samples, 9600))
    n = len(later.windows)
    assert n >= 2 and list(live.windows)[-n:] == list(later.windows)


def test_friction_and_gap_do_not_alias():
    """Same noise, another friction: the gap moves by no more than 0.5 %, and friction tells."""
    for arm_load, factor, half_gap in (('none', 0.9, 0.63), ('unknown', 1.1, 0.57)):
        known = windows_of('B', 4, {'arm_load': arm_load})
        other = windows_of('B', 4, {'arm_load': arm_load}, viscous_friction=0.1 * factor)
        # The runs differ in motion, so the noise acts otherwise: 3 sd of that over 4 windows.
        assert column(other, 'gap').mean() / column(known, 'gap').mean() == pytest.approx(
            1.0, abs=0.005 + 3.0 * 0.007 / 1.2 / 2.0)
        assert column(other, 'viscous').mean() == pytest.approx(0.1 * (factor - 1.0), abs=0.003)
        wider = windows_of('B', 4, {'arm_load': arm_load}, half_gap=half_gap)
        assert column(wider, 'gap').mean() == pytest.approx(2.0 * half_gap, rel=0.02)
        assert column(wider, 'viscous').mean() == pytest.approx(0.0, abs=0.003)


LOADS = [{'id': 'gravity', 'G': 1.0}, {'id': 'arm_coulomb', 'Cac': 0.5}]


def test_default_drive_with_a_load():
    for load in LOADS:
        model = DriveModel()
        monitor = Monitor(model, {'drift_window': 600.0})
        rows = monitor.run(samples_of(driven(model.with_(effects=[load]), 32.0))).smoothed
        found = [features.fit(rows[k:k + 10000], model, 0) for k in (1500, 11500, 21500)]
        np.testing.assert_allclose(column(found, 'gap'), 0.2, rtol=0.025)
        np.testing.assert_allclose(column(found, 'stiffness'), 25.0, rtol=0.1)


@pytest.fixture(scope='module')
def real_rows():
    if not REAL.is_dir():
        pytest.skip(f'no recordings at {REAL}')
    model = load_model(ROOT / 'config' / 'davinci_backend.yaml')
    parameters = {**load_parameters(ROOT / 'config' / 'davinci_backend_estimator.yaml',
                                    'estimator', ESTIMATOR), 'drift_window': 600.0}
    mapping, found = ReadOptions('davinci_backend'), {False: [], True: []}
    for index, path in enumerate(sorted(REAL.glob('[0-4][0-3].TXT.gz'))):
        r = signals_of(*read_mapping(path, mapping)[:2])
        torque = np.column_stack([r['motor_effort'], np.full(len(r.stamp_ns), np.nan)])
        for worn in (False, True):
            motor = r['motor_position']
            if worn and index >= 10:  # a dead zone 5 % wider, on the side the motor drives
                speed = np.gradient(r['arm_position'])
                smooth = np.convolve(speed, np.ones(201) / 201, 'same')
                motor = motor + 0.5 * 0.05 * math.radians(1.73) * np.tanh(
                    smooth / (0.05 * smooth.std()))
            rows = Monitor(model, parameters).run(Samples(
                r.stamp_ns, torque, np.column_stack([motor, r['arm_position']]))).smoothed[1000:]
            found[worn].append(features.fit(rows, model, 0))
    return found


@pytest.mark.system
def test_lost_motion_of_a_real_drive(real_rows):
    found = real_rows[False]
    lost = np.degrees(column(found, 'lost_motion'))
    assert len(lost) == 20 and 1.65 <= lost.mean() <= 1.82 and np.ptp(lost) <= 0.08
    assert not column(found, 'separable').any()
    worn = np.degrees(column(real_rows[True], 'lost_motion'))
    np.testing.assert_array_equal(worn[:10], lost[:10])
    # 5 % are six times the spread of the runs.
    growth = worn[10:] / lost[10:] - 1.0
    np.testing.assert_allclose(growth, 0.05, atol=0.01)
    assert worn[10:].min() > worn[:10].max()
