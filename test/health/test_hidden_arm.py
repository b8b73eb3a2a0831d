# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Backlash from torque and motor encoder alone, against the blind plant of the benchmarks."""
from dataclasses import replace

from drives import part_of
import numpy as np
import pytest

from benchmarks.wear import axis, model_of, watched, work
from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.health.backlash.hidden_arm import HiddenArm
from gearbox_monitor.health.health_record import GROSS
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import model_from_dict

SEED = 3
WINDOW = 5.0  # s
DT_NS = 1_000_000


@pytest.fixture(scope='module')
def drawn():
    """Return an axis and its model file, whose gap is 35 % off."""
    random = np.random.default_rng(SEED)
    drive = axis(random)
    model = model_of(drive, random).with_(half_gap=1.35 * drive.nominal['b'])
    return drive, model


def watch_of(drive, model):
    """Return the Monitor of an axis with shorter windows, for time."""
    return Monitor(model, replace(watched(drive, model).parameters, drift_window=WINDOW))


def taken(monitor, samples, first, last):
    monitor.run(part_of(samples, first, last))


def test_a_wider_gap_raises_the_alarm_and_replay_repeats_it(drawn):
    drive, model = drawn
    random = np.random.default_rng(SEED)
    monitor = watch_of(drive, model)
    samples = work(drive, 32.0, random)
    taken(monitor, samples, 0, 32_000)
    gaps = np.array([w.gap for w in monitor.windows]) / (2.0 * drive.nominal['b'])
    assert len(gaps) == 6 and np.abs(gaps - 1.0).max() < 0.15
    assert not monitor.health.alerts and monitor.health.point_windows == 6
    assert monitor.outcomes['backlash'].codes == ('alone',)

    wider = work(drive, 17.0, random, 0.5, monitor.stamp_ns + DT_NS)
    taken(monitor, wider, 0, 3_500)  # the snapshot is taken in mid-motion
    again = Monitor.restore(monitor.snapshot())
    taken(monitor, wider, 3_500, 17_000)
    taken(again, wider, 3_500, 17_000)
    change = monitor.health.alerts['gap']
    assert change.stage == GROSS and abs(change.growth - 0.5) < 0.1
    # Of the window in progress at the snapshot replay has a part only.
    assert [w.stamp_ns for w in again.windows][-2:] == [w.stamp_ns for w in monitor.windows][-2:]
    assert 'gap' in again.health.alerts


def test_same_samples_same_windows(drawn):
    drive, model = drawn
    samples = work(drive, 7.0, np.random.default_rng(SEED + 1))
    at_once, one_by_one = watch_of(drive, model), watch_of(drive, model)
    taken(at_once, samples, 0, 7_000)
    for k in range(7_000):
        one_by_one.step(Sample(int(samples.stamp_ns[k]), tuple(samples.u[k]),
                               tuple(samples.y[k])))
    assert len(at_once.windows) == 1 and at_once.snapshot() == one_by_one.snapshot()
    assert list(at_once.windows) == list(one_by_one.windows)


def test_a_servo_of_the_model_is_left_out():
    """Its torque is measured: a model that a setpoint has closed may have effects of it."""
    model = model_from_dict({'controller': {'kp': 6.0}, 'effects': [
        {'id': 'servo_delay', 'T': 0.004}, {'id': 'backlash_gap', 'b': 0.12}]}, 'closed')
    assert HiddenArm(model).model.folded().transmission.half_gap == 0.12


def test_what_the_motion_lacks_is_said(drawn):
    drive, model = drawn
    rest = watch_of(drive, model)
    n = 7_000
    stamps = 1_700_000_000_000_000_000 + DT_NS * np.arange(n)
    none = np.full(n, np.nan)
    rest.run(Samples(stamps, np.column_stack([np.zeros(n), none]), np.column_stack(
        [drive.noise * np.random.default_rng(0).standard_normal(n), none])))
    assert 'the motor stands still' in rest.outcomes['backlash'].message

    heavy = watch_of(drive, model)  # its weight keeps the teeth on one flank
    load = 4.0 * drive.nominal['m2'] * drive.acceleration
    heavier = drive.__class__(drive.nominal, [*drive.effects, {'id': 'load_torque', 'TL': load}],
                              drive.acceleration, drive.noise, 3.0 * drive.torque)
    heavy.run(work(heavier, 7.0, np.random.default_rng(1)))
    assert not heavy.windows and 'backlash not measured yet' in heavy.outcomes['backlash'].message
    # A restored Monitor begins its next fit where this one does.
    again = Monitor.restore(heavy.snapshot())
    assert again._hidden_arm.to_list() == heavy._hidden_arm.to_list() == [1.0]

    light = watch_of(drive, model.with_(driven_by='position', process_torque_time=0.3))
    light.run(work(drive, 7.0, np.random.default_rng(1)))
    assert 'driven_by: position' in light.outcomes['backlash'].message
