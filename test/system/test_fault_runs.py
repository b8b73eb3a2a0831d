# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bad streams of samples: nothing that is wrong is called good, and all is well soon after."""
import json

from fault_cases import CASES
from fault_runs import run_case
from fault_stream import healthy, MOTOR, wrapped, zeroed
import numpy as np
import pytest

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Sample, Samples
from gearbox_monitor.estimation.estimator import SnapshotError
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel

# The suite runs one of each kind, -m system a second one, too.
QUICK = (
    '20 ms late by 50 ms, every second', 'source gone for 3 s, stamps from 1 s', 'clock - 1 h',
    'motor 1e300 in 1 %', 'both missing', 'motor wraps at 2 pi', 'sign of the motor',
    'sign of the torque')
SECOND = (
    '0.5 s lost every 2 s', 'stall of 10 s, all lost', 'clock + 0.1 s', 'stamps stand still',
    'torque 1e6 in 0.1 %', 'motor frozen', 'new zero of the arm', 'torque missing',
    'none, 250 Hz', 'new zero of the motor, 4000 Hz')
BY_NAME = {case.name: case for case in CASES}
ADAPTIVE = {'filter': 'aekf', 'arm_load': 'none'}


@pytest.mark.parametrize('name', [
    *QUICK, *(pytest.param(name, marks=pytest.mark.system) for name in SECOND)])
def test_no_bar_is_missed(name):
    row = run_case(BY_NAME[name], 'unknown')
    assert not row['missed'], row


def test_the_bars_can_be_missed():
    """A twist of another zero counts as wrong when the fault is not said to move the zero."""
    row = run_case(BY_NAME['none'].__class__('new zero', zeroed(MOTOR, by=0.05)), 'unknown')
    assert row['wrong_while_ok'] > 1000 and 'no wrong estimate under OK' in row['missed']


@pytest.mark.system
def test_step_by_step_equals_run_when_positions_jump():
    base, _ = healthy(seconds=20.0)
    messages = wrapped(MOTOR)(base, None).take(base.at > 14.0)
    samples = Samples(messages.stamp_ns, messages.u, messages.y)
    whole, single = (Monitor(DriveModel(), ADAPTIVE) for _ in range(2))
    rows = whole.run(samples).rows
    stepped = [single.step(Sample(int(s), tuple(u), tuple(y)))
               for s, u, y in zip(samples.stamp_ns, samples.u, samples.y)]
    np.testing.assert_array_equal([e.row for e in stepped if e is not None], rows)
    assert whole.counts[sample_loop.POSITION_JUMP] >= 3 and whole.counts[sample_loop.START] > 1
    assert single.snapshot() == whole.snapshot() and repr(single.outcomes) == repr(whole.outcomes)


def test_a_spike_is_refused_and_changes_nothing_else():
    base, _ = healthy(seconds=4.0)
    y = base.y.copy()
    y[2000, MOTOR] += 1.0
    monitor = Monitor(DriveModel())
    found = monitor.run(Samples(base.stamp_ns, base.u, y))
    expected = Monitor(DriveModel()).run(Samples(*(
        np.delete(a, 2000, axis=0) for a in (base.stamp_ns, base.u, base.y))))
    assert monitor.counts[sample_loop.POSITION_JUMP] == 1
    assert monitor.counts[sample_loop.START] == 1
    np.testing.assert_array_equal(found.rows, expected.rows)


def test_nothing_is_ok_until_it_is_judged_again():
    base, _ = healthy(seconds=20.0)
    monitor = Monitor(DriveModel())
    judged = ('observability', 'prediction error', 'covariance', 'model')
    monitor.run(Samples(base.stamp_ns[:10000], base.u[:10000], base.y[:10000]))
    assert not any(monitor.outcomes[name].level for name in judged)
    for k in range(10300, 14400):  # 0.3 s are missing
        monitor.step(Sample(int(base.stamp_ns[k]), tuple(base.u[k]), tuple(base.y[k])))
        started = monitor.counts[sample_loop.START] > 1
        young = base.stamp_ns[k] < base.stamp_ns[10302] + 3 * sample_loop.SECOND
        if started and young:
            assert all(monitor.outcomes[name].level > Level.OK for name in judged)
    assert started and not any(monitor.outcomes[name].level for name in judged)


def test_a_snapshot_of_another_layout_is_refused():
    """Memory of the adaptive filter, gate and clock of a version that carried less."""
    monitor = Monitor(DriveModel(), ADAPTIVE)
    base, _ = healthy(seconds=0.5)
    monitor.run(Samples(base.stamp_ns, base.u, base.y))
    snapshot = monitor.snapshot()
    assert Monitor.restore(snapshot).snapshot() == snapshot
    for name in ('memory', 'gate', 'clock', 'counts'):
        older = {**snapshot, name: json.dumps(json.loads(snapshot[name])[:-1])}
        with pytest.raises(SnapshotError, match='of this version'):
            Monitor.restore(older)
