# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash features and their growth."""
import copy
import json

import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_MOTOR_SIDE, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST)
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash import features
from gearbox_monitor.health.judgement import to_data
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, Plant


NOISE = Noise((0.0, 0.0, 0.4, 0.4), (0.005, 0.005))


class Stream:
    """A plant that goes on from call to call and the monitor behind it."""

    def __init__(self, model, noise, parameters, seed=0):
        self.plant, self.monitor = Plant(model, noise, seed), Monitor(model, parameters)
        self.steps = 0

    def again(self):
        """Return another one that goes on from here."""
        other = copy.copy(self)
        other.plant = copy.deepcopy(self.plant)
        other.monitor = Monitor.restore(json.loads(json.dumps(self.monitor.snapshot())))
        return other

    def go(self, seconds, scale=1.0, offset=0.0):
        t = 2e-3 * (self.steps + np.arange(round(seconds * 500)))
        out = self.plant.run(offset + scale * Excitation().torque(t), 2e-3)
        self.steps += len(t)
        stamps = 10 ** 18 + np.round(t * 1e9).astype(np.int64)
        u = np.stack([out.u, np.full(len(t), np.nan)], axis=1)
        return self.monitor.run(Samples(stamps, u, out.y))


@pytest.fixture(scope='module')
def settled():
    """Return a function that returns a stream which has been healthy for 40 s."""
    source = Stream(DriveModel(), NOISE, {'drift_window': 2.0})
    source.go(40.0)
    return source.again


def rows_of(twist, tau_k, tau_k_std=0.0):
    rows = np.zeros((len(twist), N_SMOOTHED))
    rows[:, S_TWIST], rows[:, S_TAU_K], rows[:, S_TAU_K_NOISE_STD] = twist, tau_k, tau_k_std
    rows[:, S_MOTOR_SIDE] = tau_k
    return rows


def test_no_answer_without_excitation():
    phase = np.linspace(0, 20, 3000)
    noise = 0.01 * np.random.default_rng(0).standard_normal((2, 3000))

    def loop(twist):
        return twist, 7.0 * np.sign(twist) * np.maximum(np.abs(twist) - 0.3, 0.0)

    for twist, tau in (loop(0.2 * np.sin(phase)), loop(0.8 + 0.4 * np.sin(phase)),
                       loop(0.1 + 0.35 * np.sin(phase))):
        found = features.fit(rows_of(twist + noise[0], tau + noise[1], 0.01), DriveModel(), 7)
        assert isinstance(found, features.NotExcited) and found.reason and found.stamp_ns == 7
    for values in (np.zeros(3000), np.empty(0), np.arange(10.0)):
        found = features.fit(rows_of(values, values), DriveModel(), 0)
        assert isinstance(found, features.NotExcited)


def test_no_alarm_without_growth():
    source = Stream(DriveModel(), NOISE, {'drift_window': 2.0})
    windows = set()
    for second in range(46):
        source.go(1.0)
        level = source.monitor.outcomes['backlash'].level
        assert level == Level.OK or second < 4
        windows.update(w.stamp_ns for w in source.monitor.windows)
    assert len(windows) >= 20
    assert source.monitor.health.feature('gap').baseline == pytest.approx(0.2, rel=0.02)


def test_growing_gap_is_found(settled):
    model, source = DriveModel(), settled()
    healthy = to_data(source.monitor.health)
    levels = []
    for growth in (0.0, 0.05, 0.15, 0.18, 0.35, 0.4):
        source.plant.model = model.with_(half_gap=0.1 * (1 + growth))
        source.go(10.0)
        levels.append(source.monitor.outcomes['backlash'].level)
        assert source.monitor.windows[-1].gap == pytest.approx(0.2 * (1 + growth), rel=0.03)
    assert levels == [Level.OK, *3 * [Level.WARN], *2 * [Level.ERROR]]
    assert source.monitor.health.feature('gap').baseline == pytest.approx(0.2, rel=0.02)
    # The same with a baseline from before: no window is spent on learning it.
    again = Monitor(model, {'drift_window': 2.0}, healthy)
    source.monitor = again
    source.plant.model = model.with_(half_gap=0.13)
    source.go(10.0)
    assert again.outcomes['backlash'].level == Level.ERROR
    assert again.health.alerts['gap'].growth == pytest.approx(0.3, abs=0.04)


def test_replay_from_a_snapshot_has_the_same_drift():
    """Restored in the middle of a window: that window is left out, then all are as live."""
    source = Stream(DriveModel(), NOISE, {'drift_window': 2.0})
    source.go(15.3)
    again = source.again()
    for stream in (source, again):
        stream.go(2.0)  # the window that was under way ends
    again.monitor.adopt_baseline(source.monitor.snapshot())
    for stream in (source, again):
        stream.go(9.0)
    live, replayed = (s.monitor.health for s in (source, again))
    assert live.data.rows > 8
    assert json.dumps(to_data(live)) == json.dumps(to_data(replayed))


def test_standing_still_measures_nothing():
    quiet = Noise((0.0, 0.0, 0.0, 0.0), (0.005, 0.005))
    source = Stream(DriveModel(), quiet, {'drift_window': 2.0})
    source.go(12.0, scale=0.0)
    source.go(8.0, scale=0.03)  # inside the gap
    assert not source.monitor.windows and source.monitor.health.stamp_ns
    assert not source.monitor.health.point_windows
    assert source.monitor.outcomes['backlash'].level == Level.WARN


@pytest.mark.parametrize('lost, arm_load', [(0, 'unknown'), (1, 'unknown'), (0, 'none')])
def test_a_lost_encoder_is_no_backlash(lost, arm_load):
    parameters = {'drift_window': 2.0, 'arm_load': arm_load}
    source = Stream(DriveModel(), NOISE, parameters)
    run = source.monitor.run

    def blind(samples):
        samples.y[:, lost] = np.nan
        return run(samples)

    source.go(10.0)
    for monitor_run in (blind, run):
        source.monitor.run = monitor_run
        for _ in range(10):
            source.go(1.0)
            assert source.monitor.outcomes['backlash'].level < Level.ERROR
    gaps = np.array([window.gap for window in source.monitor.windows])
    np.testing.assert_allclose(gaps, 0.2, rtol=0.05)


def test_twice_the_noise_raises_no_alert(settled):
    source = settled()
    source.plant.noise = Noise(NOISE.process, (0.01, 0.01))
    source.go(30.0)
    assert source.monitor.outcomes['prediction error'].level > Level.OK
    assert not source.monitor.health.alerts


@pytest.mark.parametrize('factor', [0.7, 1.3])
def test_warm_up_raises_one_alert_at_most_and_says_so(settled, factor):
    source = settled()
    for share in np.linspace(0.1, 1.0, 6):
        source.plant.model = DriveModel().with_(
            viscous_friction=0.1 * (1.0 + share * (factor - 1.0)))
        source.go(4.0)
    changes = source.monitor.health.alerts
    assert len(changes) <= 1
    for key in changes:
        assert key == ('friction' if factor > 1.0 else 'friction_loss')
        message = source.monitor.outcomes['friction'].message
        assert 'warm-up?' in message and 'by -' not in message
