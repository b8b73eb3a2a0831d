# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A slip of clutch or hub is found with its size and time; nothing else that happens is one."""
from dataclasses import replace
from itertools import product
import json
import math

from drives import driven, samples_of
import numpy as np
import pytest

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.health_record import HealthSettings, Window
from gearbox_monitor.health.judgement import (
    accepted, from_data, Health, judge, outcomes, sentence, to_data)
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Quantity
from gearbox_monitor.signals.examine import admitted, examine
from gearbox_monitor.signals.uniform import at_one_rate

MODEL, DT = DriveModel(), 2e-3
SECONDS, AT = 26.0, 14.0


@pytest.fixture(scope='module')
def healthy():
    return samples_of(driven(MODEL, SECONDS, dt=DT), DT)


def monitor_of(samples):
    monitor = Monitor(MODEL, {'drift_window': 4.0})
    monitor.run(samples)
    assert sum(isinstance(w.features, Backlash) for w in monitor.judged) >= 5
    return monitor


@pytest.mark.parametrize('size, lasts, at', [(0.15, 0.08, AT), (-0.5, 0.0, AT), (0.15, 0.08, 11.0),
                                             (0.15, 0.08, 15.5)])
def test_a_slip_is_found_with_size_and_time(healthy, size, lasts, at):
    """Anywhere in a window; slowly under load, or at once, which the filter refuses to follow."""
    seconds, y = (healthy.stamp_ns - healthy.stamp_ns[0]) * 1e-9, healthy.y.copy()
    y[:, 0] += size * np.clip((seconds - at) / max(lasts, DT), 0.0, 1.0)
    health = monitor_of(replace(healthy, y=y)).health
    slip, = health.slips
    assert abs(slip.size - size) < 3.0 * slip.std < 0.02
    assert abs(slip.stamp_ns - healthy.stamp_ns[0] - at * 1e9) <= 4e9
    level, words = sentence(health)
    assert level == Level.WARN and words.startswith(
        f'slip of {Quantity(abs(slip.size), slip.std, "rad")} at 2001-09-09 01:46:')
    assert not health.alerts  # the backlash is what it was


def test_a_slip_that_one_window_shows_is_not_healthy(healthy):
    """The recording ends before the second window that would make it sure."""
    y, short = healthy.y.copy(), round((AT + 8.0) / DT)
    y[round((AT - 1.0) / DT):, 0] += 0.15
    health = monitor_of(Samples(healthy.stamp_ns[:short], healthy.u[:short], y[:short])).health
    assert not health.slips and not health.stages()['backlash']
    level, words = sentence(health)
    assert level == Level.WARN
    assert words.startswith('motor and arm slipped by 0.1') and 'if the next window' in words


def gap_opens(y, seconds):
    y[:, 0] += 0.03 * np.sign(y[:, 0] - y[:, 1]) * (seconds > AT)


def dropout(y, seconds):
    y[(seconds > AT) & (seconds < AT + 0.5)] = np.nan
    y[seconds > AT + 0.5, 0] += 0.4  # the driver counts anew


def turn(y, seconds):
    y[seconds > AT, 1] -= 2.0 * math.pi


@pytest.mark.parametrize('change', [gap_opens, dropout, turn])
def test_what_is_no_slip(healthy, change):
    y = healthy.y.copy()
    change(y, (healthy.stamp_ns - healthy.stamp_ns[0]) * 1e-9)
    monitor = monitor_of(replace(healthy, y=y))
    assert not monitor.health.slips
    values = monitor.outcomes['input'].values
    assert values.get('last_refusal', '') == {
        gap_opens: '', dropout: 'samples without measurement', turn: 'positions that jump'}[change]
    if change is turn:
        moved = values['reset_motor_rad'], values['reset_arm_rad']
        assert moved == pytest.approx((0.0, -2.0 * math.pi), abs=0.3)


def test_check_names_a_slip_and_counts_on_over_it(healthy):
    """With size and time; a diagnosis takes the recording as it was read."""
    seconds, y = (healthy.stamp_ns - healthy.stamp_ns[0]) * 1e-9, healthy.y.copy()
    y[:, 0] += 0.15 * np.clip((seconds - AT) / 0.08, 0.0, 1.0)

    def lines(y):
        found = examine(replace(healthy, y=y), EstimatorParameters(), MODEL)
        return [line for line in found.lines if line.name == 'slip']
    slip, = lines(y)
    assert slip.values['slip_rad'] == pytest.approx(0.15, abs=0.01)
    assert slip.values['slip_s'] == pytest.approx(AT, abs=0.3)
    t = replace(healthy, y=y)
    recording, _ = admitted(t.stamp_ns, t.u[:, 0], t.y, None, 'log', MODEL, 'the model')
    assert recording.slip[1] == slip.values['slip_rad']
    note, = recording.counted_on()
    assert 'slip by 0.1' in str(note) and not recording.as_read().counted_on()
    np.testing.assert_allclose(recording.as_read().y, y[:len(recording.y)], atol=1e-9)
    slower, _ = at_one_rate([recording, replace(recording, dt=1.05 * recording.dt)])
    off = slower.as_read().y[:, 0] - np.interp(slower.t, recording.t, y[:len(recording.y), 0])
    assert len(slower.y) < 0.96 * len(y) and (np.abs(off) > 0.1).sum() < 5
    off = recording.y - healthy.y[:len(recording.y)]
    assert np.median(np.abs(off[-1000:])) < 0.01
    for change in (lambda y, s: None, gap_opens):
        y = healthy.y.copy()
        change(y, seconds)
        assert not lines(y)


class Windows:
    """Windows of a drive, with all that may happen to it."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.health = Health(HealthSettings.of(EstimatorParameters(), DriveModel(gear_ratio=50.0)))
        self.stamp, self.zero, self.gap, self.count = 10 ** 18, 0.3, 0.2, 0

    def go(self, count=4, counts_on=True, load=4.0):
        for k in range(count):
            self.stamp += 10 ** 10
            noise = 0.002 * self.random.standard_normal(2)
            self.health = judge(self.health, Window(Backlash(
                self.stamp, self.gap + noise[0], 0.002, 25.0, 0.2, zero=self.zero + noise[1],
                flank=0.4, coverage=9.0, angle=0.3, speed=2.0, load=load),
                counts_on=counts_on or k > 0))

    def slip(self):
        self.zero += 0.15
        self.count += 1

    def restart(self):
        """Read the state again; the encoders count anew."""
        self.health = from_data(self.health.settings, json.loads(json.dumps(to_data(self.health))))
        self.zero -= 0.7
        self.go(1, counts_on=False)

    def wear(self):
        """Let one flank wear."""
        self.gap += 0.06
        self.zero += 0.03

    def turn(self):
        self.zero -= 2.0 * math.pi

    def load(self):
        self.go(3, load=12.0)
        self.zero += 0.01


EVENTS = ('slip', 'restart', 'wear', 'turn', 'load')


def test_two_events_in_a_row():
    for number, events in enumerate(product(EVENTS, repeat=2)):
        gearbox = Windows(number)
        for event in events:
            gearbox.go()
            getattr(gearbox, event)()
        gearbox.go()
        sizes = [slip.size for slip in gearbox.health.slips]
        assert sizes == pytest.approx([0.15] * gearbox.count, abs=0.02), events
        values = outcomes(gearbox.health)['backlash'].values
        assert values.get('slips', 0) == gearbox.count, events
        assert not accepted(gearbox.health)[0].slips, events
