# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Trust indicators against published values, known statistics and their stated odds."""
import itertools
import math

import numpy as np
import pytest

from gearbox_monitor import stream
from gearbox_monitor.drive.excitation import Excitation
from gearbox_monitor.drive.model import DriveModel
from gearbox_monitor.drive.simulate import Noise, simulate
from gearbox_monitor.monitor import Monitor, Samples
from gearbox_monitor.trust import covariance, innovation, observability
from gearbox_monitor.trust.level import Alarm, Finding, Level


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
    t = dt * np.arange(round(seconds / dt))
    out = simulate(model, Excitation().torque(t), dt, noise, seed)
    stamps = START + np.arange(len(t)) * round(dt * 1e9)
    return Samples(stamps, np.stack([out.u, np.full(len(t), np.nan)], axis=1), out.y)


def default_samples(seconds, model=None, scale=1.0, **kwargs):
    noise = Noise((0.0, 0.0, 0.4, 0.4), (0.005 * scale, 0.005 * scale))
    return samples(seconds, model or DriveModel(), noise, **kwargs)


@pytest.fixture(scope='module')
def moving():
    """Return (rows of 6 s of case B, packed parameters)."""
    monitor = Monitor(CASE_B, REFERENCE)
    data = samples(6.0, CASE_B, Noise((0.0612, 0.0828, 0.358, 0.472), (0.0612, 0.0828)))
    return monitor.run(data).rows, monitor._packed


def share(rows, packed, seen):
    inputs = np.nan_to_num(rows[:, [stream.E_U, stream.E_LOAD]])
    return observability.information_share(
        rows[:, :5], inputs, rows[:, stream.E_DT], np.tile(seen, (len(rows), 1)), packed)


# Published medians while moving, for windows of so many milliseconds.
SHARES = {50: (0.161, 0.177, 0.643), 100: (0.030, 0.072, 0.152)}


@pytest.mark.parametrize('window', SHARES)
def test_information_share_ranks_what_was_lost(moving, window):
    rows, packed = moving
    starts = range(1000, 5800, 400)
    medians = [np.median([share(rows[a:a + window], packed, seen)[4] for a in starts])
               for seen in (BOTH, ARM_LOST, MOTOR_LOST)]
    assert medians[0] < medians[1] < medians[2]
    np.testing.assert_allclose(medians, SHARES[window], rtol=0.15)
    assert share(rows[1000:1000 + window], packed, (False, False))[4] > 0.99


def test_standstill_hides_the_speed_not_the_torque(moving):
    _, packed = moving
    rows = np.zeros((100, stream.N_ESTIMATE))
    rows[:, stream.E_DT] = 1e-3
    both, arm_lost, motor_lost = (share(rows, packed, s) for s in (BOTH, ARM_LOST, MOTOR_LOST))
    assert both[4] == pytest.approx(0.142, rel=0.05) and both[2] > 0.95
    assert arm_lost[4] == pytest.approx(0.722, rel=0.05)
    assert motor_lost[4] == pytest.approx(0.143, rel=0.05)
    finding = observability.check(both[4], both[2], 1e-4)
    assert finding.level == Level.OK and 'standstill' in finding.message
    assert observability.check(arm_lost[4], 1.0, 0.0).level == Level.ERROR
    assert observability.check(math.nan, 1.0, 0.0).level == Level.ERROR


def test_condition_of_the_papers_jacobian(moving):
    """Equation (6) in raw units: at rest worse than with the motor encoder lost in motion."""
    _, packed = moving
    rest, fast = np.zeros(5), np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    for state, seen, expected in ((rest, BOTH, 3.7e-4), (fast, BOTH, 6.2e-3),
                                  (rest, MOTOR_LOST, 2.2e-7), (fast, MOTOR_LOST, 6e-4)):
        value = observability.condition(state, np.zeros(2), np.array(seen), packed)
        assert value == pytest.approx(expected, rel=0.05)
    assert observability.condition(fast, np.zeros(2), np.array(ARM_LOST), packed) < 1e-12
    assert observability.condition(fast, np.zeros(2), np.array([False, False]), packed) == 0.0


def test_ljung_box_by_hand():
    e = np.random.default_rng(0).standard_normal(500).cumsum() * 0.02 + 3.0
    d = e - e.mean()
    rho = [sum(d[i] * d[i - k] for i in range(k, 500)) / sum(d * d) for k in range(1, 21)]
    expected = 500 * 502 * sum(r * r / (500 - k) for k, r in enumerate(rho, 1))
    q, predictable = innovation.ljung_box(e)
    assert q == pytest.approx(expected, rel=1e-10)
    assert predictable == pytest.approx(sum(r * r for r in rho), rel=1e-10)
    assert innovation.ljung_box(np.zeros(500)) == (0.0, 0.0)
    # White: Q ~ chi2(20), mean 20, sd sqrt(40); 400 draws, 4 sigma.
    rng = np.random.default_rng(1)
    mean = np.mean([innovation.ljung_box(rng.standard_normal(1000))[0] for _ in range(400)])
    assert mean == pytest.approx(20.0, abs=4 * math.sqrt(40 / 400))


def check(white, recent=500):
    dof = np.isfinite(white).sum(axis=1).astype(float)
    return innovation.check(white, np.nansum(white ** 2, axis=1), dof, recent)


def test_false_alarms_of_the_prediction_error():
    """
    Stated: 0.001 each for mean and NIS; whiteness wants size as well. 4000 windows: 8 expected.

    Poisson(8) leaves 1 .. 20 twice in 10^4 runs; the seed is fixed.
    """
    rng = np.random.default_rng(0)
    count = sum(check(rng.standard_normal((2000, 2))).level > Level.OK for _ in range(4000))
    assert 1 <= count <= 20


def test_prediction_error_names_the_fault():
    rng = np.random.default_rng(0)
    white = rng.standard_normal((2000, 2))
    assert check(white).level == Level.OK
    assert 'larger' in check(1.2 * white).message
    assert 'smaller' in check(0.8 * white).message
    assert check(2.0 * white).level == Level.ERROR
    assert 'biased' in check(white + np.array([0.3, 0.0])).message
    coloured = white.copy()
    for k in range(1, 2000):
        coloured[k, 1] = 0.5 * coloured[k - 1, 1] + math.sqrt(0.75) * white[k, 1]
    assert 'not white' in check(coloured).message
    alone = white.copy()
    alone[:, 0] = np.nan
    assert check(alone).level == Level.OK
    assert check(white[:50]).level == Level.WARN
    assert check(np.full((2000, 2), np.nan)).level == Level.WARN
    for finding in (check(white), check(3 * white)):
        for name in ('mean', 'ljung_box'):
            assert finding.values[f'{name}_threshold'] > 0


def found(monitor, component, data):
    """Return the raw findings of a check while `data` is run."""
    raw, judge = [], {'prediction error': innovation, 'covariance': covariance}[component]
    original = judge.check
    try:
        judge.check = lambda *a: raw.append(original(*a)) or raw[-1]
        monitor.run(data)
    finally:
        judge.check = original
    return raw


@pytest.mark.parametrize('fault', ['none', 'noise', 'frozen', 'friction', 'torque scale'])
def test_faults_of_the_drive_are_found(fault):
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
    late = [finding.level > Level.OK for finding in raw[-4:]]
    assert len(raw) >= 8
    # A healthy drive may raise a single evaluation, which the alarm must not follow.
    assert sum(f.level > Level.OK for f in raw) <= 1 if fault == 'none' else all(late)
    level = monitor.findings['prediction error'].level
    assert level == Level.OK if fault == 'none' else level > Level.OK


def test_covariance_bounds():
    assert covariance.check(1.0, None).level == Level.OK
    for std, level in ((1.0, Level.OK), (0.81, Level.OK), (0.79, Level.WARN),
                       (1.29, Level.OK), (1.31, Level.WARN)):
        assert covariance.check(std, 1.0).level == level
    data = default_samples(16.0)
    data.y[10000:, 0] = np.nan
    raw = found(Monitor(DriveModel()), 'covariance', data)
    assert [f.level for f in raw[:7]] == [Level.OK] * 7 and raw[-1].level == Level.WARN
    assert 'above' in raw[-1].message


def expected_levels(raws, up, down):
    """Two switches, one per level, each with its own runs: the rule in other words."""
    on, run, result = [False, False], [[0, 0], [0, 0]], []
    for k, raw in enumerate(raws):
        for i in range(2):
            above = raw > i
            run[i] = [run[i][0] + 1, 0] if above else [0, run[i][1] + 1]
            if run[i][0] >= up or (k == 0 and i == 0 and above):
                on[i] = True
            elif run[i][1] >= down:
                on[i] = False
        result.append(2 if on[1] else int(on[0]))
    return result


@pytest.mark.parametrize('up, down', [(3, 5), (2, 2), (1, 1), (4, 1)])
def test_alarm_is_two_debounced_switches(up, down):
    rng = np.random.default_rng(0)
    for seed in range(60):
        stay = rng.uniform(0.3, 0.98)
        raws = [int(rng.integers(3))]
        for _ in range(300):
            raws.append(raws[-1] if rng.random() < stay else int(rng.integers(3)))
        alarm = Alarm(up, down)
        assert alarm.level == Level.WARN and alarm.lasted(5) == 0.0
        levels = [int(alarm.update(Level(raw), k)) for k, raw in enumerate(raws)]
        assert levels == expected_levels(raws, up, down)
        changes = [(k, np.sign(b - a)) for k, (a, b) in
                   enumerate(zip(levels, levels[1:]), 1) if a != b]
        for (a, one), (b, other) in zip(changes, changes[1:]):
            if one != other:
                assert b - a >= (up if other > 0 else down)


def test_alarm_latency_and_duration():
    alarm = Alarm(3, 5)
    assert alarm.update(Level.OK, 0) == Level.OK  # the first evaluation may clear "no data yet"
    for _ in range(1000):
        alarm.update(Level.OK, 1)
    levels = [alarm.update(Level.ERROR, k * SECOND) for k in range(10, 14)]
    assert levels == [0, 0, 2, 2] and alarm.lasted(20 * SECOND) == 8.0
    for _ in range(1000):
        alarm.update(Level.ERROR, 30 * SECOND)
    levels = [alarm.update(Level.OK, k * SECOND) for k in range(40, 46)]
    assert levels == [2, 2, 2, 2, 0, 0] and alarm.lasted(50 * SECOND) == 6.0
    assert Alarm().update(Level.ERROR, 0) == Level.WARN  # never OK on a bad first look


@pytest.mark.parametrize('dt', [1e-2, 1e-3, 5e-4])
@pytest.mark.parametrize('disturbed', [False, True])
def test_one_evaluation_per_second_of_stamps(dt, disturbed):
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
    assert isinstance(monitor.findings['input'], Finding)
