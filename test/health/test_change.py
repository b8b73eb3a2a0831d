# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Sequential test, baselines per operating point, forecast and state of drift; odds stated."""
from copy import deepcopy
from dataclasses import replace
from functools import cache
import gzip
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_TWIST, S_X4
from gearbox_monitor.files.baselines import (
    health_text, load_baseline, load_state, save_baseline, STATE, write_whole)
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import CONDITIONS, FEATURES, GAP, PRIORS, TESTS
from gearbox_monitor.health.backlash.features import Backlash, lost_motion_of, NotExcited
from gearbox_monitor.health.health_record import (
    AT_ODDS, ERRORS_LARGER, FOUND, HealthSettings, TRUSTED, WARNED, Window)
from gearbox_monitor.health.judgement import accepted, from_data, Health, judge, outcomes, to_data
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.sentences import TABLE

WINDOW = 10 * 10 ** 9
MEASURED = [0, 2, 3, 4, 6]  # features of the windows below
REAL = Path(__file__).resolve().parents[3] / 'shared' / 'data' / 'davinci_backend'
# Standard deviation of the gap (rad) in 10 s, and of its part that no other feature explains.
SPREAD = {'A': (0.0103, 0.0035), 'B': (0.0073, 0.0030)}


def settings(**parameters):
    return HealthSettings.of(EstimatorParameters.from_mapping(parameters), DriveModel())


def to_text(health):
    return json.dumps(to_data(health))


def read_again(health):
    """Return `health` after it was written and read."""
    return from_data(health.settings, json.loads(to_text(health)))


class Gearbox:
    """Windows as they are measured on a gap of 1.2 rad: errors of the features go together."""

    def __init__(self, seed, case='B', **parameters):
        self.random, self.case = np.random.default_rng(seed), case
        self.health, self.stamp = Health(settings(**parameters)), 10 ** 18
        self.state = {'angle': 0.3, 'speed': 18.0, 'load': 3.6}

    def window(self, growth=0.0, **changes):
        all_of_it, rest = SPREAD[self.case]
        shared, own, friction, loop = self.random.standard_normal(4)
        gap = 1.2 * (1.0 + growth) + math.sqrt(all_of_it ** 2 - rest ** 2) * shared + rest * own
        self.stamp += WINDOW
        return replace(Backlash(
            self.stamp, gap, 1.1 * all_of_it, 5.0 + 0.04 * shared, 0.044,
            hysteresis=0.02 * loop, hysteresis_std=0.02, zero=0.0, flank=0.4, coverage=18.0,
            viscous=0.0012 * friction, viscous_std=0.0013, coulomb=0.0, coulomb_std=0.001,
            **self.state), **changes)

    def take(self, features, trust=TRUSTED, temperature=None, comparable=False):
        """Return the outcomes after a window with `features`."""
        self.health = judge(self.health, Window(features, trust, temperature, comparable))
        return outcomes(self.health)

    def go(self, windows, growth=0.0, trust=TRUSTED, temperature=None, **changes):
        """Return the outcomes of each of `windows` windows."""
        growth = np.broadcast_to(growth, windows)
        return [self.take(self.window(g, **changes), trust, temperature) for g in growth]


@cache
def healthy(windows, temperature, case):
    gearbox = Gearbox(9, case)
    gearbox.go(windows, temperature=temperature)
    return gearbox


def learnt(windows=60, temperature=None, case='A'):
    """Return a gearbox after healthy windows, which are judged once for all tests."""
    return deepcopy(healthy(windows, temperature, case))


def counts(health):
    """Return the number of windows at each operating point."""
    data = health.data
    return [data.count(k) for k in range(len(data.points))]


def alarmed(outcomes):
    return [k for k, f in enumerate(outcomes) if max(x.level for x in f.values()) > Level.OK]


def test_no_alarm_without_growth():
    """Two joints for 12 minutes each, learning included; odds of an alarm: 144 / 3.15e6."""
    for seed, case in enumerate('AB'):
        assert not alarmed(Gearbox(seed, case).go(72))


def test_one_percent_is_found():
    """Mean delay of 3 jumps of +1 % at the default setting; the bar is 180 s."""
    gearbox, delays = learnt(), []
    healthy, stamp = gearbox.health, gearbox.stamp
    for _ in range(3):
        gearbox.health = healthy
        gearbox.stamp = stamp
        found = alarmed(gearbox.go(20, 0.01))
        change = gearbox.health.alerts['gap']
        assert found and change.growth == pytest.approx(0.01, abs=5 * change.std + 1e-3)
        assert abs(change.since_ns - stamp) <= 12 * WINDOW
        delays.append(10.0 * (found[0] + 1))
    assert np.mean(delays) < 100.0
    # At once, where it is large; but never from one window alone.
    gearbox.health = healthy
    assert not alarmed(gearbox.go(1, 0.5)) and not alarmed(gearbox.go(20, 0.0))
    assert alarmed(gearbox.go(4, 0.05))[0] <= 2


@pytest.mark.system
def test_slow_ramp_is_found_and_forecast():
    """5 % per hour: found within 20 min, limit of 25 % forecast within its interval."""
    gearbox = Gearbox(3)
    gearbox.go(360)
    ramp = 0.05 * np.arange(1, 361) / 360
    found = gearbox.go(360, ramp)
    assert alarmed(found)[0] < 120
    outcome = found[-1]['backlash']
    assert not any('steady' in f['backlash'].message for f in found)
    left = 3600.0 * (0.25 - 0.05) / 0.05
    assert outcome.level == Level.WARN and 'reaches +25.0 % in about' in outcome.message
    assert outcome.values['forecast_s'] == pytest.approx(left, rel=0.2)
    assert outcome.values['forecast_earliest_s'] < left < outcome.values['forecast_latest_s']
    assert outcome.values['growth'] == pytest.approx(0.05, abs=0.005)
    # On to the limits of a warning and an error.
    assert 'plan a service' in gearbox.go(20, 0.12)[-1]['backlash'].message
    assert gearbox.go(20, 0.3)[-1]['backlash'].level == Level.ERROR
    # An absolute limit counts, too; and a repair ends the alarm.
    assert gearbox.go(40, 0.0)[-1]['backlash'].level == Level.OK


def test_fast_growth_is_stated_as_it_is_now_and_so_is_its_end():
    for (windows, case), seed in itertools.product([(4, 'A'), (20, 'B'), (40, 'A')], range(2)):
        gearbox = learnt(windows, case=case)
        gearbox.random = np.random.default_rng(seed)
        for true in (*np.arange(0.09, 0.6, 0.09), 0.6, 0.6, 0.7, 0.7, 0.7):
            known = bool(gearbox.health.wear[GAP].found)  # one window alone shows no slope
            gearbox.go(1, true)
            growth, std = gearbox.health.growth(GAP)
            assert not known or abs(growth - true) < 3.0 * std
        assert growth == pytest.approx(0.7, abs=0.05)


def test_a_repair_in_a_new_motion_ends_the_alert_for_good():
    gearbox = learnt(case='B')
    assert gearbox.go(20, 0.3)[-1]['backlash'].level == Level.ERROR
    gearbox.state = {'angle': 0.3, 'speed': 10.0, 'load': 2.5}
    told = gearbox.go(12, temperature=41.5)
    assert not any('has grown' in found['backlash'].message for found in told)


def test_friction_has_its_own_alert_and_is_no_backlash():
    gearbox, stiff = learnt(case='B'), learnt(case='B')
    found = gearbox.go(10, viscous=0.2 * (0.1 + 0.27 / 18.0))[-1]
    assert found['backlash'].level == Level.OK
    assert found['friction'].level == Level.WARN
    change = gearbox.health.alerts['friction']
    assert 'friction has grown by' in found['friction'].message
    assert change.growth == pytest.approx(0.2, abs=3 * change.std) and change.std < 0.02
    found = stiff.go(20, stiffness=4.2)[-1]['backlash']
    assert found.level == Level.WARN and 'stiffness has dropped by 1' in found.message
    change = stiff.health.alerts['stiffness_loss']
    assert change.growth == pytest.approx(0.16, abs=3 * change.std) and change.std < 0.02
    assert 'gap' not in stiff.health.alerts


def test_a_cold_start_is_not_wear():
    """A gap that shrinks by 0.2 %/K: no alarm where its temperature was learnt, nor elsewhere."""
    gearbox = Gearbox(6)

    def day(windows):
        found = []
        for kelvin in np.linspace(15.0, 45.0, windows):
            found += gearbox.go(1, -0.002 * (kelvin - 15.0), temperature=kelvin)
        return found

    first = day(25)
    assert not alarmed(first) and first[0]['backlash'].message.endswith(
        'above the model file: no earlier recording to compare with')
    assert not alarmed(day(25)) and len(gearbox.health.data.points) > 5
    # Colder than ever: the gap is as large as the coefficient says.
    cold = gearbox.go(2, 0.04, temperature=-5.0)
    assert not alarmed(cold)
    assert abs(cold[-1]['backlash'].values['growth']) < 3 * cold[-1]['backlash'].values[
        'growth_std']
    # Growth is found across temperatures, and at the new point too once it was learnt.
    kelvins = np.tile(np.linspace(15.0, 45.0, 12), 3)
    found = []
    for kelvin in kelvins:
        found += gearbox.go(1, -0.002 * (kelvin - 15.0) + 0.02, temperature=kelvin)
    assert alarmed(found) and alarmed(found)[0] < 30


def test_points_are_kept_apart_and_found_again():
    gearbox = Gearbox(8)
    gearbox.go(40)
    gearbox.state['load'] = 1.0  # far less load: the fitted gap is smaller there
    found = gearbox.go(30, -0.03)
    # It may be the motion or the gearbox: no change is found, and the deviation says so.
    assert not gearbox.health.alerts and found[-1]['backlash'].values['growth_std'] > 0.01
    gearbox.state['load'] = 3.9  # within the bin of the first
    found = gearbox.go(30)
    assert not alarmed(found) and found[-1]['backlash'].values['growth_std'] < 0.005
    assert counts(gearbox.health) == [70, 30]
    # Back in the other motion, which is known now.
    gearbox.state['load'] = 1.0
    assert not alarmed(gearbox.go(3, -0.03)) and alarmed(gearbox.go(6, 0.02))


def test_larger_errors_are_a_distrust_of_their_own():
    """Windows at odds with the filter had no bias; that of noisier encoders is another one."""
    for usual, trust, found in ((AT_ODDS, ERRORS_LARGER, False), (AT_ODDS, AT_ODDS, True),
                                (ERRORS_LARGER, ERRORS_LARGER - 1, False)):
        gearbox = Gearbox(5)

        def go(trust, growth=0.0, gearbox=gearbox):
            return gearbox.take(gearbox.window(growth), trust, comparable=True)
        for _ in range(40):
            go(TRUSTED)
            go(usual)
        alarms = alarmed([go(trust, -0.02) for _ in range(6)])
        assert bool(alarms) == found == ('gap_loss' in gearbox.health.alerts), (usual, trust)
        assert not alarmed([go(TRUSTED) for _ in range(20)][-6:])
        assert to_text(read_again(gearbox.health)) == to_text(gearbox.health)


def test_windows_at_odds_with_the_drive_state_what_they_may_be_off_together():
    gearbox = learnt(case='B')
    for _ in range(30):
        gearbox.take(gearbox.window(-0.05), ERRORS_LARGER - 1, comparable=True)
        growth, std = gearbox.health.growth(GAP)
        assert not gearbox.health.alerts and 0.01 < std < 0.03
        assert abs(growth + 0.05) < 2.0 * std


def test_an_octave_of_errors_is_one_of_variance():
    """Encoders with twice the deviation: a quarter of the weight, once they are known or not."""
    weights = []
    for factor, trust in ((1.0, ERRORS_LARGER), (2.0, ERRORS_LARGER - 4)):
        gearbox = Gearbox(6)
        gearbox.go(5)
        for _ in range(30):
            window = gearbox.window()
            gearbox.take(replace(
                window, gap=1.2 + factor * (window.gap - 1.2), gap_std=factor * window.gap_std),
                trust, comparable=True)
        data = gearbox.health.data
        precise = data.observations(np.ones((len(data.stamps), len(PRIORS))),
                                    gearbox.health.settings.friction).weight
        weights.append(1.0 / np.linalg.inv(precise[:, MEASURED][:, :, MEASURED])[:, 0, 0])
    quiet, loud = weights
    assert loud[:5] == pytest.approx(quiet[:5], rel=0.1)
    assert loud[5:] == pytest.approx(quiet[5:] / 4.0, rel=0.1)


def test_what_is_not_compared_is_never_ok():
    gearbox = Gearbox(9)
    found = gearbox.go(20, 0.3, trust=AT_ODDS)
    assert {f['backlash'].level for f in found} == {Level.WARN}
    assert 'not compared yet: the estimates are not trusted' in found[-1]['backlash'].message
    assert math.isnan(gearbox.health.feature('gap').baseline)
    gearbox.go(20)
    assert gearbox.health.feature('gap').baseline == pytest.approx(1.2, rel=0.02)
    found = gearbox.go(10, 0.1, trust=AT_ODDS)
    assert not gearbox.health.alerts
    assert not alarmed(found[:3]) and len(alarmed(found)) == 7
    assert 'backlash not compared since 2001-09-09' in found[-1]['backlash'].message
    # Nothing is known of that time.
    assert found[-1]['backlash'].values['growth_std'] > found[0]['backlash'].values['growth_std']
    assert alarmed(gearbox.go(10, 0.1)) and 'gap' in gearbox.health.alerts
    for _ in range(5):
        gearbox.stamp += WINDOW
        pause = gearbox.take(NotExcited(gearbox.stamp, 'one_flank'))
    assert pause['backlash'].level == Level.WARN
    assert pause['backlash'].message.startswith('backlash has grown')
    assert 'only one flank' in pause['backlash'].message
    nothing = Gearbox(0).take(NotExcited(1, 'one_flank'))
    assert nothing['backlash'].level == Level.WARN and 'only one' in nothing['backlash'].message


def test_a_good_fit_is_compared_where_the_filter_is_at_odds_with_the_drive():
    gearbox = Gearbox(9)
    gearbox.go(20)

    def go(windows, growth, **changes):
        return [gearbox.take(gearbox.window(growth, **changes), False, comparable=True)
                for _ in range(windows)]

    go(5, 0.3, gap_std=1.0)  # a poor fit of the gap
    gearbox.go(5, 0.3, gap_std=1.0)  # trusted or not
    assert not gearbox.health.alerts
    lasting = Gearbox(9)
    lasting.go(20)
    lasting.go(30, 0.5, gap_std=0.2)  # less certain from now on: these count in the end
    assert 'gap' in lasting.health.alerts
    found = go(10, 0.1)
    assert alarmed(found) and 'backlash has grown' in found[-1]['backlash'].message
    # How far the filter's doubt moves the gap is not known, and stated.
    change = gearbox.health.alerts['gap']
    assert change.growth == pytest.approx(0.1, abs=2 * change.std) and 0.01 < change.std < 0.03
    # Before there is a baseline, nothing is compared.
    fresh = Gearbox(9)
    outcome = fresh.take(gearbox.window(0.3), False, comparable=True)['backlash']
    assert not fresh.health.alerts and 'not compared yet' in outcome.message


def test_friction_is_followed_on_one_flank():
    gearbox, random, stamp = Gearbox(0), np.random.default_rng(2), 0

    def go(windows, coulomb):
        nonlocal stamp
        found = []
        for _ in range(windows):
            stamp += WINDOW
            found.append(gearbox.take(NotExcited(stamp, 'one_flank', friction=Backlash(
                stamp, viscous=0.0, viscous_std=1e-4, angle=0.0, speed=20.0, load=6.0,
                coulomb=coulomb + 1e-3 * random.standard_normal(), coulomb_std=1e-3))))
        return found

    healthy = go(20, 0.1)
    assert [f['friction'].level for f in healthy] == [Level.OK] * 20
    assert healthy[-1]['backlash'].level == Level.WARN
    assert 'only one flank' in healthy[-1]['backlash'].message
    gearbox.health = read_again(gearbox.health)
    assert outcomes(gearbox.health) == healthy[-1]
    found = go(10, 1.1)
    assert 'friction has grown' in found[-1]['friction'].message
    assert 'not measured yet' in found[-1]['backlash'].message
    assert outcomes(read_again(gearbox.health)) == found[-1]


def test_windows_that_do_not_know_all():
    """Unknown features, and a gap that is not separable: the lost motion is followed."""
    gearbox = Gearbox(10)
    nan = dict.fromkeys(('hysteresis', 'viscous', 'coulomb', 'gain', 'zero', 'flank'), math.nan)
    sizes = gearbox.random.normal(0.03, 1e-4, 40)
    for size in sizes:
        found = gearbox.go(1, separable=False, lost_motion=size, lost_motion_std=1e-4, **nan)
    assert found[-1]['backlash'].level == Level.OK
    assert 'lost motion' in found[-1]['backlash'].message
    assert 'friction not compared yet: not identifiable' in found[-1]['friction'].message
    found = gearbox.go(6, separable=False, lost_motion=0.0315, lost_motion_std=1e-4, **nan)
    assert 'lost motion has grown by 5' in found[-1]['backlash'].message


def test_a_stream_of_windows_has_one_answer_wherever_it_is_cut(tmp_path):
    """A jump, a warming, a new motion, a ramp and a retightening; written and read between."""
    gearbox, again, file = Gearbox(11), Gearbox(11), tmp_path / 'state.json'
    warm, loaded, told = 20.0 + 0.8 * np.arange(12), {'load': 9.0}, set()
    stream = [(0.0, 20.0, {})] * 40 + [(0.03, t, {}) for t in warm] + [(0.03, 30.0, loaded)] * 12 \
        + [(g, 30.0, loaded) for g in np.linspace(0.03, 0.12, 12)] + [(0.0, 20.0, {})] * 14
    for k, (growth, temperature, changes) in enumerate(stream):
        if k % 13 == 12:
            write_whole(file, health_text(STATE, again.health, 'g7', adaptation={'gain': 0.1}))
            state, _ = load_state(file, 'g7')
            assert len(file.read_bytes()) < 30000 and state['adaptation'] == {'gain': 0.1}
            again.health = from_data(gearbox.health.settings, state['health'])
        window = gearbox.window(growth, **changes)
        assert repr(again.take(window, temperature=temperature)) == repr(
            gearbox.take(window, temperature=temperature))
        told |= {(key, alert.stage) for key, alert in gearbox.health.alerts.items()}
    assert to_text(replace(again.health, earlier=False)) == to_text(gearbox.health)
    assert told >= {('gap', FOUND), ('gap', WARNED)} and not gearbox.health.alerts


def test_a_baseline_is_read_by_the_names_of_its_features(monkeypatch):
    """One saved before torque gain was a feature, and in another order: the others go on."""
    gearbox = learnt(case='B')
    whole, kept = gearbox.health, [k for k, name in enumerate(FEATURES) if name != 'gain'][::-1]
    names = [FEATURES[k] for k in kept]
    monkeypatch.setattr(judgement, 'FEATURES', tuple(names))
    saved = json.loads(to_text(judgement._by_name(whole, FEATURES)))
    assert len(saved['wear']) == len(saved['features']) == len(names)
    monkeypatch.undo()
    gearbox.health = from_data(whole.settings, saved)
    for name in names:
        assert gearbox.health.feature(name) == whole.feature(name) or name == 'lost_motion'
    assert math.isnan(gearbox.health.feature('gain').baseline)
    found = gearbox.go(20, 0.05)[-1]['backlash']
    assert found.level == Level.WARN and list(gearbox.health.alerts) == ['gap']


def test_a_health_is_a_value():
    """What judges one leaves it as it was, however the two go on."""
    gearbox = learnt(case='B')
    before, text = gearbox.health, to_text(gearbox.health)
    gearbox.go(30, 0.3, load=30.0)
    accepted(before)
    assert to_text(before) == text and before != gearbox.health


def damages(text):
    """Return `text` with each of 200 single bytes changed, cut off at ten places, and others."""
    random = np.random.default_rng(0)
    for at in random.integers(0, len(text), 200).tolist():
        yield text[:at] + chr((ord(text[at]) + 1) % 128) + text[at + 1:]
    yield from (text[:at] for at in random.integers(0, len(text), 10).tolist())
    yield from ('', '{', '[]', 'null', '{"format": 8}')


def test_a_damaged_file_is_found_and_a_state_set_aside(tmp_path):
    """Checked by its sum: no damage is taken for what was known, and none ends the node."""
    gearbox = Gearbox(11)
    gearbox.go(10)
    state, baseline = tmp_path / 'state.json', tmp_path / 'baseline.json'
    assert load_state(state, 'g7') == (None, '')
    for text in damages(health_text(STATE, gearbox.health, 'g7')):
        state.write_text(text)
        read, told = load_state(state, 'g7')
        assert read is None and str(state) in told and not state.exists(), text[:80]
        baseline.write_text(text)
        with pytest.raises(InputError, match='baseline'):
            load_baseline(baseline, 'g7')
    assert next(tmp_path.glob('state.json.corrupt-*')).exists()


def test_files_of_others_are_refused_by_name(tmp_path):
    state, baseline = tmp_path / 'state.json', tmp_path / 'baseline.json'
    write_whole(state, health_text(STATE, Gearbox(0).health, 'g7'))
    read, told = load_state(state, 'g8')
    assert read is None and "'g7', expected 'g8'" in told
    for old in ('{format: 2, gearbox_serial: g7, baseline: []}', '{"format": 5, "drift": {}}'):
        baseline.write_text(old)
        with pytest.raises(InputError, match='of another version: save the baseline again'):
            load_baseline(baseline, 'g7')
    write_whole(baseline, health_text(STATE, Gearbox(0).health, 'g7'))
    with pytest.raises(InputError, match='a state of format 8, expected a baseline'):
        load_baseline(baseline, 'g7')
    snapshot = Monitor(DriveModel()).snapshot()
    del snapshot['format']
    with pytest.raises(InputError, match='snapshot: of another version, .*--model'):
        Monitor.restore(snapshot)


@pytest.mark.parametrize('begin', [10 ** 18 + 10 ** 15, 10 ** 10])
def test_a_baseline_judges_what_comes_later_and_by_another_clock(tmp_path, begin):
    gearbox = learnt(case='B')
    file = tmp_path / 'baseline.json'
    health, windows = accepted(gearbox.health)
    save_baseline(file, health, 'g7', {'drift_window': 10.0})
    gearbox.health = from_data(gearbox.health.settings, load_baseline(file, 'g7'))
    gearbox.stamp = begin
    found = gearbox.go(30, 0.02)
    alert = gearbox.health.alerts['gap']
    assert windows == 60 and found[-1]['backlash'].level == Level.WARN
    assert alert.growth == pytest.approx(0.02, abs=3 * alert.std) and alert.since_ns <= begin
    with pytest.raises(InputError, match="gearbox_serial: 'g7', expected 'g8'"):
        load_baseline(file, 'g8')


def test_accepting_what_is_there():
    """After a repair, or to live with it: the alarm ends, the windows since are the baseline."""
    gearbox = learnt(case='B')
    gearbox.health, windows = accepted(gearbox.health)
    assert windows == 60 and alarmed(gearbox.go(30, 0.05))
    gearbox.health, windows = accepted(gearbox.health)
    assert 20 < windows <= 32 and not gearbox.health.alerts
    assert gearbox.health.feature('gap').baseline == pytest.approx(1.26, rel=0.01)
    assert not alarmed(gearbox.go(60, 0.05))


def test_a_backlash_that_stays_smaller_for_a_day_is_a_new_baseline():
    gearbox = learnt(case='B')
    gearbox.go(20, -0.05)
    alert = gearbox.health.alerts['gap_loss']
    gearbox.stamp += 86_400_000_000_000
    gearbox.go(2, -0.05)
    (stamp, words), = gearbox.health.marks
    assert stamp == alert.since_ns and words.startswith('backlash 5.')
    assert not gearbox.health.alerts and not alarmed(gearbox.go(20, -0.05))
    assert alarmed(gearbox.go(20, 0.0))


@pytest.mark.skipif(not REAL.is_dir(), reason=f'no recordings at {REAL}')
def test_real_recordings_do_not_drift_unless_widened():
    """20 runs of a real drive in windows of 10 s; then 5 % more lost motion from run 11 on."""
    windows = []
    for run, path in enumerate(sorted(REAL.glob('[0-4][0-3].TXT.gz'))):
        with gzip.open(path, 'rt', encoding='latin-1') as file:
            lines = [line for line in file if line.strip() and not line.startswith('%')]
        raw = np.loadtxt(lines, delimiter=',', usecols=(1, 8))
        arm, motor = (np.convolve(a, np.ones(51) / 51, 'valid') * 2 * np.pi for a in
                      (-raw[:, 0] / 8192, raw[:, 1] / 143360))
        rows = np.zeros((len(arm), N_SMOOTHED))
        rows[:, S_TWIST], rows[:, S_X4] = motor - arm, np.gradient(arm, 1e-3)
        for part in (rows[:9900], rows[9900:19800]):
            lost, std = lost_motion_of(part)
            windows.append((run, Backlash(
                (len(windows) + 1) * WINDOW, *4 * [math.nan], lost_motion=lost,
                lost_motion_std=std, separable=False, angle=0.0, load=0.07,
                speed=float(np.sqrt(np.mean(part[:, S_X4] ** 2))))))
    assert len(windows) == 40
    for wider in (0.0, 0.05):
        gearbox, found = Gearbox(0), []
        for run, window in windows:
            lost = window.lost_motion * (1.0 + (wider if run >= 10 else 0.0))
            found_now = gearbox.take(replace(window, lost_motion=lost))
            if found_now['backlash'].level:
                found.append(run)
        assert bool(found) == bool(wider)
    assert found[0] in (10, 11)
    # At the end in a motion that was not driven before.
    change = gearbox.health.alerts['lost_motion']
    assert change.growth == pytest.approx(0.05, abs=change.std) and change.std < 0.04


def test_conditions_of_wear_name_the_figures_they_compare():
    """A score with its threshold where a change is found; then its size with a limit."""
    found = [c for c in CONDITIONS if 'significant' in TABLE[c.code].when]
    assert len(found) == len(TESTS)
    for condition in found:
        assert condition.threshold == tuple(f'{value}_threshold' for value in condition.value)
        assert all(value.endswith('_score') for value in condition.value)
    sizes = [c for c in CONDITIONS if c.value and c not in found]
    assert len(sizes) == 2 * len(found)
    for condition in sizes:
        (value,), (limit,) = condition.value, condition.threshold
        assert limit == f'{value}_{"error" if "_error" in TABLE[condition.code].when else "warn"}'
