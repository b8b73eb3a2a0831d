# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What is said never contradicts what was measured, nor what was said before."""
from dataclasses import replace

from drives import part_of
from live import PARAMETERS, worn
import numpy as np
import pytest
from test_change import Gearbox

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.health_record import TRUSTED
from gearbox_monitor.health.judgement import accepted, Health
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

FRICTION = 0.1 + 0.27 / 18.0  # of the model, at the speed of the windows: N m s/rad


def learnt(windows=60, **changes):
    gearbox = Gearbox(3)
    gearbox.health = Health(replace(gearbox.health.settings, **changes))
    gearbox.go(windows)
    return gearbox


def test_a_backlash_above_its_limit_is_an_error_whatever_the_baseline():
    gearbox = Gearbox(0, gap_limit=1.1)
    outcome = gearbox.go(5)[-1]['backlash']
    assert outcome.level == Level.ERROR and 'exceeds gap_limit 1.1 rad' in outcome.message
    assert gearbox.health.stages()['backlash'] == {'gap_limit': 3}
    gearbox.go(5, -0.2)
    assert not gearbox.health.over_limit and 'gap_limit' not in gearbox.health.stages()


ORDERS = [
    ({'gap_notice': 0.5, 'gap_warn': 0.1, 'gap_error': 0.05},
     'gap_warn: 0.1, expected a number >= gap_notice'),
    ({'stiffness_warn': 0.3}, 'stiffness_error: 0.25, expected a number >= stiffness_warn'),
    ({'friction_error': 0.1}, 'friction_error: 0.1, expected a number >= friction_warn')]


def test_limits_are_in_order_at_the_start_and_at_run_time():
    for values, expected in ORDERS:
        with pytest.raises(InputError, match=expected):
            EstimatorParameters.from_mapping(values)
        with pytest.raises(InputError, match=expected):
            Monitor(DriveModel()).set_parameters(values)


def test_the_baseline_does_not_move_by_what_is_being_judged():
    gearbox = learnt()
    gearbox.health, _ = accepted(gearbox.health)
    before = gearbox.health.feature('gap').baseline
    first, *others = [f['backlash'] for f in gearbox.go(8, 0.3)]
    assert 'no wear detected' not in first.message and 'in the newest window' in first.message
    assert first.values['baseline_gap_rad'] == before
    for outcome in others:
        assert outcome.level == Level.ERROR
        assert outcome.values['baseline_gap_rad'] == pytest.approx(before, rel=0.005)


def test_what_is_not_known_is_not_ok():
    gearbox = learnt()
    for _ in range(20):
        found = gearbox.take(gearbox.window(
            load=30.0, viscous=0.3 * FRICTION * gearbox.random.standard_normal(),
            viscous_std=0.3 * FRICTION), TRUSTED)['friction']
    change, std = gearbox.health.growth(4)
    if 2.0 * std > 0.2:
        assert found.level == Level.WARN and abs(change) < 3.0 * std
        assert 'no wear detected' not in found.message


def test_a_grown_backlash_under_the_curve_of_the_model_is_one_alert():
    """The torque follows the curve that the filter has: stiffness, gain and friction seem off."""
    changes = {'stiffness': 5.0 * 0.67, 'gain': -0.19, 'gain_std': 0.005,
               'viscous': -0.18 * FRICTION}
    gearbox, free = learnt(follows_curve=True), learnt()
    for g in (gearbox, free):
        found = g.go(20, 0.25, **changes)[-1]
    assert set(free.health.alerts) > {'gap', 'stiffness_loss'}
    assert set(gearbox.health.alerts) == {'gap'}
    free.go(1)
    assert gearbox.go(1, 0.25, **changes)[0]['friction'].level == Level.OK
    assert 'elastic curve' in gearbox.go(1, 0.25, **changes)[0]['friction'].message
    assert found['friction'].level > Level.OK


SHARES = [
    (1500, 0.5, True), (150, 0.0, True), (20, 0.0, False)]


def test_lost_and_bad_samples_count_by_their_share():
    for every, bad, compared in SHARES:
        samples = worn(14, rate=0.0, per_second=1000)
        y = samples.y.copy()
        y[::every, 0] += bad  # a bad reading, rad
        kept = np.arange(len(y)) % every != every // 2  # and a lost one
        monitor = Monitor(DriveModel(), PARAMETERS)
        monitor.run(Samples(samples.stamp_ns[kept], samples.u[kept], y[kept]))
        assert monitor.outcomes['input'].level == Level.WARN
        trusted = [window.trust == TRUSTED for window in monitor.judged]
        assert len(trusted) >= 5 and any(trusted[2:]) == compared
        assert monitor.health.compared == compared


def test_messages_do_not_change_from_second_to_second():
    samples = worn(8, rate=0.0, per_second=1000)
    samples.y[:, 1] = np.nan
    monitor, told = Monitor(DriveModel(), PARAMETERS), set()
    for k in range(8):
        monitor.run(part_of(samples, 1000 * k, 1000 * (k + 1)))
        if k >= 5:
            told.add(monitor.outcomes['input'].message)
            assert monitor.outcomes['input'].values['lasts_s'] > 0.0
    assert len(told) == 1 and len(told.pop()) < 160
