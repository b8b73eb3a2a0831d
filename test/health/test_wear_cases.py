# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Two things at once: each of them has the size that it has, and ends by itself."""
from copy import deepcopy
from dataclasses import replace
from functools import cache
import math

import numpy as np
import pytest
from test_change import alarmed, Gearbox, learnt, read_again, settings

from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import FEATURES
from gearbox_monitor.health.health_record import GROSS, WARNED
from gearbox_monitor.health.judgement import accepted, Health, outcomes

FRICTION = 0.1 + 0.27 / 18.0  # of the model, at the speed of the windows: N m s/rad
COULOMB = 0.27 / 18.0 / FRICTION  # its share of it


def size(gearbox, key, true, stage=None):
    """Assert that a change is found, of the size `true` within 3 deviations; return it."""
    change = gearbox.health.alerts[key]
    assert abs(change.growth - true) < 3 * change.std + 1e-3, (change, true)
    assert stage is None or change.stage == stage
    return change


def test_growth_together_with_a_new_motion_or_a_warming():
    for growth, stage, new in ((0.2, WARNED, {'load': 9.0}), (0.5, GROSS, {'temperature': 45.0})):
        gearbox = learnt(**({'temperature': 20.0} if 'temperature' in new else {}))
        gearbox.go(3, growth, **new)
        assert size(gearbox, 'gap', growth, stage).std < 0.04
        gearbox.go(24, growth, **new)  # nor is it learnt as healthy
        size(gearbox, 'gap', growth, stage)


def test_growth_learnt_in_a_new_motion_has_its_size_in_the_old_one():
    gearbox = learnt()
    gearbox.go(36, 0.2, load=9.0)
    found = gearbox.go(10, 0.2)
    assert size(gearbox, 'gap', 0.2, WARNED).std < 0.005
    assert found[-1]['backlash'].level == Level.WARN


def test_a_little_in_a_new_motion_is_not_separable_until_the_old_one():
    gearbox = learnt()
    found = gearbox.go(100, 0.03, load=9.0)  # beyond the horizon of the test
    assert not gearbox.health.alerts
    values = found[-1]['backlash'].values
    assert abs(values['growth'] - 0.03) < 3 * values['growth_std'] and values['growth_std'] > 0.01
    found = gearbox.go(20, 0.08, load=9.0)  # what comes later does not hide in the motion
    assert size(gearbox, 'gap', 0.08).std > 0.01
    gearbox.go(8, 0.08)
    assert size(gearbox, 'gap', 0.08).std < 0.005


def test_a_step_below_its_deviation_in_a_new_motion_is_told_once_its_size_is_known():
    gearbox = learnt()
    gearbox.go(36, load=9.0)
    gearbox.go(30, 0.015, load=9.0)
    growth, std = gearbox.health.growth(FEATURES.index('gap'))
    assert not gearbox.health.alerts and abs(growth - 0.015) < 3 * std < 0.09 and growth < std
    told = gearbox.go(20, 0.015)[-1]['backlash'].message
    assert size(gearbox, 'gap', 0.015).std < 0.005 and 'separable' not in told


def test_a_motion_that_hides_a_service_is_a_warning():
    outcome = learnt().go(3, 0.07, load=9.0)[-1]['backlash']
    assert outcome.level == Level.WARN and len(outcome.message) <= 120
    assert 'not separable from the new motion: drive the old one' in outcome.message


def test_shrinkage_is_a_change_and_over_when_it_has_gone():
    gearbox = learnt()
    found = gearbox.go(30, -0.1)
    size(gearbox, 'gap_loss', 0.1)
    assert 'backlash has shrunk by 10' in found[-1]['backlash'].message
    found = gearbox.go(10, 0.0)
    assert not gearbox.health.alerts and found[-1]['backlash'].level == Level.OK
    assert any('over: backlash had shrunk by' in f['backlash'].message for f in found)
    gearbox.go(10, 0.05)
    size(gearbox, 'gap', 0.05)


def test_friction_is_an_alarm_and_the_gap_beside_it_too():
    """Prediction errors speak against the windows: the features that cause it do not hide."""
    gearbox = learnt()
    for growth, windows in ((0.0, 6), (0.1, 6)):
        for _ in range(windows):
            window = gearbox.window(growth, viscous=0.6 * FRICTION)
            found = gearbox.take(window, False, comparable=True)
    size(gearbox, 'friction', 0.6, GROSS)
    size(gearbox, 'gap', 0.1)
    assert found['friction'].level == Level.ERROR
    for _ in range(6):  # in a new motion, still
        gearbox.take(gearbox.window(0.1, viscous=0.6 * FRICTION, load=9.0), False,
                     comparable=True)
    size(gearbox, 'gap', 0.1)


def test_slow_friction_keeps_up():
    gearbox = learnt()
    for k in range(50):
        gearbox.go(1, viscous=4.0 * k / 360 * FRICTION)
    size(gearbox, 'friction', 4.0 * 49 / 360, GROSS)
    assert not [key for key in gearbox.health.alerts if key != 'friction']


FRICTIONS = [
    (-0.3, 0.3, 'viscous_share_loss'), (0.08, -0.08, 'viscous_share'),  # one for the other
    (0.3 * (1.0 - COULOMB), 0.3 * COULOMB, 'friction'), (0.4, 0.0, 'friction'),
    (0.0, 0.4, 'friction')]


def test_one_change_of_friction_is_one_alert():
    """viscous, coulomb: changes over the friction at the speed of the windows."""
    for viscous, coulomb, key in FRICTIONS:
        gearbox, told = learnt(), []
        for _ in range(10):
            found = gearbox.go(1, viscous=viscous * FRICTION, coulomb=18.0 * coulomb * FRICTION)
            told.append(gearbox.health.stages()['friction'])
        alerts = [stage for before, stage in zip([{}, *told], told) if stage != before]
        assert len(alerts) == 1 and list(alerts[0]) == [key], alerts
        true = viscous + coulomb if key == 'friction' else abs(viscous)
        size(gearbox, key, true)
        values = found[0]['friction'].values
        for name, share, change in (
                ('viscous', 1.0 - COULOMB, viscous), ('coulomb', COULOMB, coulomb)):
            growth, std = values[f'{name}_growth'], values[f'{name}_growth_std']
            assert abs(growth - change / share) < 3 * std + 1e-3
        # A repair ends it.
        assert gearbox.go(12)[-1]['friction'].level == Level.OK


def test_a_shift_of_friction_names_both_coefficients():
    message = learnt().go(4, viscous=-0.3 * FRICTION, coulomb=5.4 * FRICTION)[-1][
        'friction'].message
    assert 'friction has shifted to Coulomb by' in message
    assert '(viscous -3' in message and ', Coulomb +2' in message


def test_a_slow_shift_of_friction_is_found_while_the_sum_stays():
    gearbox = learnt()
    for k in range(40):
        gearbox.go(1, viscous=-0.2 * k / 40 * FRICTION, coulomb=3.6 * k / 40 * FRICTION)
    size(gearbox, 'viscous_share_loss', 0.2)
    assert list(gearbox.health.alerts) == ['viscous_share_loss']


class OiledGearbox(Gearbox):
    """Friction of the model at 20 deg C: viscous falls by 3 %/K, Coulomb by 0.2 %/K."""

    def warm(self, speed, temperatures, coulomb=0.0, gap=0.0):
        """Return the outcomes of friction; the share of Coulomb friction at the end is `share`."""
        found = []
        for kelvin in np.asarray(temperatures) - 20.0:
            viscous, new = 0.1 * math.exp(-0.03 * kelvin), 0.27 * math.exp(-0.002 * kelvin)
            self.share = new / (viscous * speed + new)
            errors = self.random.standard_normal(2) * (0.0013, 0.0065)
            found.append(self.take(self.window(
                gap, speed=speed, viscous=viscous - 0.1 + errors[0], coulomb_std=0.0065,
                coulomb=new * (1.0 + coulomb) - 0.27 + errors[1]), True, kelvin + 20.0))
        return [f['friction'] for f in found]


WARMING = 45.0 - 25.0 * np.exp(-np.arange(24) / 7.0)


@cache
def warmed():
    """Return a gearbox that has learnt one warming at 18 rad/s."""
    gearbox = OiledGearbox(5)
    gearbox.warm(18.0, np.concatenate([np.full(30, 20.0), WARMING]))
    return gearbox


def test_coulomb_friction_grows_in_a_warming_oil_at_another_speed():
    """Learnt at 18 rad/s, where viscous friction rules; 4 rad/s were only driven cold."""
    gearbox = deepcopy(warmed())
    gearbox.warm(4.0, np.full(10, 20.0))
    gearbox.warm(18.0, np.full(2, 20.0))
    learnt, stamp = gearbox.health, gearbox.stamp
    found = gearbox.warm(4.0, WARMING)
    growth, std = gearbox.health.growth(FEATURES.index('friction'))
    assert {f.level for f in found} == {Level.OK} and abs(growth) < 3 * std < 0.2
    gearbox.health, gearbox.stamp = learnt, stamp
    assert gearbox.warm(4.0, WARMING, 0.6)[-1].level == Level.WARN
    size(gearbox, 'friction', 0.6 * gearbox.share)


def test_growth_does_not_hide_behind_points_that_a_warming_founds():
    """Never warmed up before: motion, oil and Coulomb friction change at once."""
    gearbox = OiledGearbox(5)
    gearbox.warm(18.0, np.full(35, 20.0))
    found = gearbox.warm(4.0, WARMING, 0.6)
    assert 'not separable from the new motion' in found[-1].message
    assert found[-1].level == Level.WARN
    growth, std = gearbox.health.growth(FEATURES.index('friction'))
    assert abs(growth - 0.6 * gearbox.share) < 3 * std


def test_a_gap_grows_in_a_warming_oil():
    gearbox = deepcopy(warmed())
    gearbox.warm(18.0, WARMING, gap=0.2)
    size(gearbox, 'gap', 0.2, WARNED)
    assert not [key for key in gearbox.health.alerts if key != 'gap']


def test_one_of_two_changes_ends():
    gearbox = learnt()
    gearbox.go(12, 0.3, viscous=0.6 * FRICTION)
    levels = {f['friction'].level for f in gearbox.go(14, 0.0, viscous=0.6 * FRICTION)}
    assert levels == {Level.ERROR} and list(gearbox.health.alerts) == ['friction']
    size(gearbox, 'friction', 0.6, GROSS)


def test_a_stiffer_gearbox_is_told_and_is_no_gap():
    gearbox = learnt()
    found = gearbox.go(20, stiffness=5.75)
    size(gearbox, 'stiffness_growth', 0.15)
    assert 'stiffness has grown by 1' in found[-1]['backlash'].message
    assert list(gearbox.health.alerts) == ['stiffness_growth']


def test_a_saved_baseline_is_zero_everywhere():
    gearbox = learnt()
    gearbox.go(20, load=9.0)
    gearbox.go(20, 0.3)
    gearbox.health, _ = accepted(gearbox.health)
    outcome = outcomes(gearbox.health)['backlash']
    assert outcome.level == Level.OK and not gearbox.health.alerts
    # Also in the motion that was not driven since the change.
    assert not alarmed(gearbox.go(10, 0.3)) and not alarmed(gearbox.go(10, 0.3, load=9.0))
    gearbox.go(10, 1.3 * 1.05 - 1.0, load=9.0)
    size(gearbox, 'gap', 0.05)


def test_what_seems_to_come_with_a_change_is_saved_with_it():
    """A loop that appears makes the gap look 1 % smaller."""
    gearbox = learnt(90)
    gearbox.go(4, -0.01, hysteresis=-0.13 * 3.6)
    assert list(gearbox.health.alerts) == ['hysteresis_down']
    gearbox.health, _ = accepted(gearbox.health)
    assert not alarmed(gearbox.go(40, -0.01, hysteresis=-0.13 * 3.6))
    gearbox.go(10, 0.05, hysteresis=-0.13 * 3.6)
    size(gearbox, 'gap', 0.06)


def test_points_without_end():
    gearbox = Gearbox(11, speed_bin=1.2)
    for k in range(60):
        gearbox.go(1, speed=20.0 * 1.25 ** (k % 30))
    assert len(gearbox.health.data.points) == 30 and not gearbox.health.alerts
    found = [gearbox.go(1, 0.2, speed=20.0 * 1.25 ** (k % 30))[0] for k in range(10)]
    size(gearbox, 'gap', 0.2)
    assert found[-1]['backlash'].level == Level.WARN


@pytest.mark.parametrize('turns, points', [(True, 1), (False, 2)])
def test_a_lifting_axis_does_not_come_round(turns, points):
    gearbox, by = Gearbox(0), settings(angle_bin=1.0)
    gearbox.health = Health(replace(by, bins=replace(by.bins, turns=turns)))
    gearbox.go(1, angle=0.1)
    gearbox.go(1, angle=6.4)
    assert len(gearbox.health.data.points) == points


@pytest.mark.parametrize('restarted', [False, True])
def test_a_new_motion_that_is_not_compared_does_not_end_the_measurement(restarted):
    """A window that is not trusted, at a point without any other: nothing was learnt there."""
    gearbox = Gearbox(5)
    gearbox.go(19)
    window = gearbox.window(0.0, load=36.0, gap_std=6.0, stiffness_std=50.0, hysteresis_std=9.0,
                            viscous_std=9.0, coulomb_std=9.0, lost_motion_std=9.0)
    gearbox.take(window, False, comparable=True)
    assert len(gearbox.health.data.points) == 2 and not gearbox.health.compared
    if restarted:
        gearbox.health = read_again(gearbox.health)
    gearbox.health, windows = accepted(gearbox.health)
    assert windows == 19
    gearbox.go(10, 0.2)
    size(gearbox, 'gap', 0.2)
