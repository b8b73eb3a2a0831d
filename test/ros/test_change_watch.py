# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""When a change is named, against which recording, and what is said of it; no ROS."""
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pytest

from gearbox_monitor.files.baselines import load_recording, StateFile
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import COMPONENTS, FEATURES, FRICTION
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.ros.change_watch import ChangeWatch
from gearbox_monitor.ros.recording_export import RecordingBuffer, SECOND, unpacked_rows

T0 = 1_700_000_000 * SECOND
NAMED = {'verdict': 'effect', 'findings': [{'effect': 'backlash_gap'}], 'remainder': None,
         'model_holds': False, 'text': 'backlash_gap: +20 %', 'cpu_s': 12.0}
NOTHING = {**NAMED, 'verdict': 'none', 'findings': [], 'text': 'nothing named',
           'model_holds': True}


class Gearbox:
    """A gearbox whose health says what the test says, at 10 samples/s; orders are collected."""

    def __init__(self, file=None, recording_ns=0, serial='A', model=None, **parameters):
        self.orders, self.seconds = [], 0
        self.buffer = RecordingBuffer(300.0)
        self.health = SimpleNamespace(stamp_ns=0, alerts={}, pause=None, trusted=True,
                                      compared=True, stages=self.stages, temperature=None,
                                      features=[SimpleNamespace(compared_ns=0) for _ in FEATURES])
        self.monitor = SimpleNamespace(
            health=self.health, model=model or DriveModel(), model_lasts=(Level.OK, 0),
            stamp_ns=0, parameters=EstimatorParameters.of({'gearbox_serial': serial,
                                                           **parameters}),
            estimator=SimpleNamespace(drive=SimpleNamespace(arm_load='none')))
        self.file = file
        self.watch = ChangeWatch(self.monitor, self.buffer, self, file, recording_ns)

    def submit(self, order):
        self.orders.append(order)
        self.job = Future()
        return self.job

    def end(self, verdict=None, problem=''):
        if problem:
            self.job.set_exception(RuntimeError(problem))
        else:
            self.job.set_result(verdict)

    def stages(self):
        return {component: {test: change.stage for test, change in self.health.alerts.items()
                            if (test == 'friction') == (component == 'friction')}
                for component in COMPONENTS}

    def alert(self, test='gap', stage=1, since_s=None):
        since = T0 + round((self.seconds if since_s is None else since_s) * SECOND)
        self.health.alerts[test] = SimpleNamespace(stage=stage, since_ns=since)

    def run(self, seconds):
        """Let time pass; return the last (Outcome, verdict)."""
        for _ in range(seconds):
            for k in range(10):
                self.monitor.stamp_ns = T0 + self.seconds * SECOND + k * SECOND // 10
                self.buffer.add(self.monitor.stamp_ns, True, (1.0, 1.0, 0.0, np.nan))
            self.seconds += 1
            if self.seconds % 10 == 0:
                self.health.stamp_ns = self.monitor.stamp_ns
                self.watch.window()
                if self.file is not None:
                    self.file.keep('state')
        return self.watch.look()


def mismatch(compared=True):
    """Return a Gearbox with an order for a mismatch; `compared`: friction since it came."""
    gearbox = Gearbox(name_changes_after=30.0)
    gearbox.run(60)
    gearbox.monitor.model_lasts = (Level.WARN, gearbox.monitor.stamp_ns)
    gearbox.health.features[FRICTION].compared_ns = gearbox.monitor.stamp_ns - (not compared)
    gearbox.run(31)
    return gearbox


def friction(effects, remainder=None):
    """Return a verdict that names `effects`, all by the same words."""
    return {**NAMED, 'verdict': 'incomplete' if remainder else 'effect', 'remainder': remainder,
            'findings': [{'effect': effect} for effect in effects], 'text': 'friction: -5 %'}


def test_an_alert_is_named_against_the_healthy_minute_by_rows_since_it_came():
    gearbox = Gearbox()
    outcome, _ = gearbox.run(59)
    assert outcome.level == Level.OK and 'needs 60 s of healthy windows' in outcome.message
    gearbox.run(1)
    healthy = gearbox.watch.recording_ns
    assert healthy == gearbox.monitor.stamp_ns
    gearbox.run(40)
    gearbox.alert(since_s=96.0)
    outcome, _ = gearbox.run(1)
    assert outcome.level == Level.OK and 'backlash has grown: recording 8 s' in outcome.message
    assert not gearbox.orders
    gearbox.run(4)
    (order,) = gearbox.orders
    assert order.since_ns == T0 + 96 * SECOND and order.cpu_seconds == 300
    assert unpacked_rows(order.reference.blocks)['stamp_ns'][-1] == healthy
    later = unpacked_rows(order.later(), order.since_ns)['stamp_ns']
    assert (later[0], later[-1]) == (order.since_ns, gearbox.monitor.stamp_ns)
    assert gearbox.run(3)[0].message == 'backlash has grown: its cause is being named'
    gearbox.end(NAMED)
    outcome, verdict = gearbox.run(1)
    assert outcome.level == Level.WARN
    assert outcome.message == 'backlash_gap: +20 %, since 2023-11-14 22:14:56 UTC'
    assert verdict['alert'] == 'gap' and verdict['since_ns'] == order.since_ns
    assert verdict['baseline_recording_ns'] == healthy
    assert gearbox.run(60)[1] is None and len(gearbox.orders) == 1  # once an alert
    gearbox.health.alerts.clear()
    outcome, _ = gearbox.run(1)
    assert outcome.level == Level.OK and outcome.message == 'over: backlash_gap: +20 %'


def test_a_failure_is_said_and_the_next_alert_tries_again():
    gearbox = Gearbox()
    gearbox.run(60)
    gearbox.alert()
    gearbox.run(11)
    gearbox.end(problem='the diagnosis took more than 300 s of CPU time (name_changes_cpu)')
    outcome, verdict = gearbox.run(1)
    assert verdict is None and outcome.level == Level.WARN
    assert outcome.message.startswith('backlash has grown: the diagnosis took more than 300 s')
    gearbox.run(30)
    assert len(gearbox.orders) == 1
    gearbox.alert(stage=2, since_s=60.0)  # it grew; and a second one comes while that is named
    gearbox.run(1)
    gearbox.alert('stiffness_loss')
    gearbox.run(12)
    assert len(gearbox.orders) == 2
    gearbox.end(NOTHING)
    outcome, _ = gearbox.run(1)
    assert len(gearbox.orders) == 3
    assert outcome.message == 'stiffness has dropped: its cause is being named'
    gearbox.end(NOTHING)
    assert gearbox.run(1)[0].message == 'nothing named'


def test_a_mismatch_of_the_model_is_named_when_it_lasts():
    gearbox = Gearbox(name_changes_after=30.0)
    gearbox.run(60)
    since = gearbox.monitor.stamp_ns
    gearbox.monitor.model_lasts = (Level.WARN, since)
    gearbox.run(29)
    assert not gearbox.orders
    gearbox.run(2)
    (order,) = gearbox.orders
    assert order.since_ns == since
    gearbox.end(NAMED)
    assert gearbox.run(1)[1]['alert'] == 'model mismatch'
    gearbox.monitor.model_lasts = (Level.WARN, gearbox.monitor.stamp_ns)  # gone, and there again
    gearbox.run(60)
    assert len(gearbox.orders) == 1


@pytest.mark.parametrize('verdict, minutes', [
    (NAMED, [10, 10, 10]), (NOTHING, [20, 40, 80, 120, 120]), (None, [20, 40, 80])])
def test_a_mismatch_in_which_nothing_is_named_is_diagnosed_less_and_less_often(verdict, minutes):
    """Nothing because nothing has changed, or because the diagnosis failed."""
    gearbox = mismatch()
    for pause in minutes:
        gearbox.end(verdict, '' if verdict else 'more CPU time than allowed')
        gearbox.run(60 * pause - 60)
        orders = len(gearbox.orders)
        gearbox.monitor.model_lasts = (Level.WARN, gearbox.monitor.stamp_ns)  # there again
        gearbox.run(31)
        assert len(gearbox.orders) == orders
        gearbox.run(60)
        assert len(gearbox.orders) == orders + 1


def test_friction_that_has_not_worn_is_temperature():
    """Two recordings do not tell wear from temperature; the wear model does."""
    for effects, remainder, kind in (
            (['motor_viscous'], None, 'none'), (['motor_viscous', 'motor_coulomb'], None, 'none'),
            (['motor_viscous'], 'arm_side', 'unknown'),
            (['motor_viscous', 'backlash_gap'], None, 'effect')):
        gearbox = mismatch()
        gearbox.health.temperature = 26.0
        gearbox.end(friction(effects, remainder))
        outcome, verdict = gearbox.run(1)
        assert verdict['verdict'] == kind and bool(verdict['findings']) == (kind == 'effect')
        assert verdict['text'].endswith('friction: -5 %')
        assert ('as temperature has it' in verdict['text']) == (kind != 'effect')
        assert (outcome.level == Level.OK) == (kind == 'none')
        assert 'friction: -5 %' in outcome.message


def test_without_a_temperature_friction_that_has_not_worn_may_be_warm():
    gearbox = mismatch()
    gearbox.end(friction(['motor_viscous']))
    assert gearbox.run(1)[1]['text'] == 'no wear, friction (warm-up?): friction: -5 %'


@pytest.mark.parametrize('named_first', [True, False])
def test_friction_that_wears_beside_a_mismatch_is_named(named_first):
    """Its alert comes after the mismatch has been named, or while it is."""
    gearbox = mismatch()
    if named_first:
        gearbox.end(friction(['motor_viscous']))
        assert not gearbox.run(1)[1]['findings']
    gearbox.alert('friction')
    gearbox.run(12)
    assert len(gearbox.orders) == 1 + named_first
    gearbox.end(friction(['motor_viscous']))
    verdict = gearbox.run(1)[1]
    assert verdict['findings']
    assert verdict['alert'] == ('friction' if named_first else 'model mismatch')
    assert len(gearbox.orders) == 2


def test_a_rest_before_the_verdict_takes_back_no_comparison_of_friction():
    for compared in (True, False):
        gearbox = mismatch(compared)
        gearbox.health.compared = False  # the drive has stopped since
        gearbox.end(friction(['motor_viscous']))
        assert bool(gearbox.run(1)[1]['findings']) != compared


def test_without_a_baseline_recording_it_says_so():
    gearbox = Gearbox()
    gearbox.run(30)
    gearbox.alert()
    outcome, _ = gearbox.run(30)
    assert outcome.level == Level.WARN and not gearbox.orders
    assert 'no healthy minute was recorded before; after a repair' in outcome.message
    gearbox.run(60)
    assert not gearbox.watch.recording_ns  # an alert is no healthy window
    nothing = ChangeWatch(gearbox.monitor, None, gearbox, None)
    assert 'keep_minutes is 0' in nothing.look()[0].message


def test_the_recording_survives_a_restart_and_a_saved_baseline_replaces_it(tmp_path):
    path = tmp_path / 'state.json'
    gearbox = Gearbox(StateFile(path, 'e'))
    gearbox.run(70)
    first = gearbox.watch.recording_ns
    gearbox.file.close()
    gearbox = Gearbox(StateFile(path, 'e'), first)
    assert gearbox.watch.recording_ns == first and not gearbox.watch.note
    gearbox.alert(since_s=-1e9)  # an alert from before the restart
    gearbox.run(7)
    assert not gearbox.orders
    gearbox.run(2)
    assert unpacked_rows(gearbox.orders[0].reference.blocks)['stamp_ns'][-1] == first
    gearbox.watch.accept()
    gearbox.run(10)
    gearbox.file.close()
    second = gearbox.watch.recording_ns
    assert second > 0 and load_recording(f'{path}.recording').stamp_ns == second != first


def test_a_baseline_saved_while_a_child_runs_is_not_the_one_compared_with():
    """And an alert that still waits for its rows is accepted with the baseline."""
    gearbox = Gearbox()
    gearbox.run(60)
    healthy = gearbox.watch.recording_ns
    gearbox.alert()
    gearbox.run(11)
    gearbox.alert('stiffness_loss')
    gearbox.run(1)
    gearbox.health.alerts.clear()  # as a saved baseline does
    gearbox.watch.accept()
    assert gearbox.watch.recording_ns == gearbox.monitor.stamp_ns
    gearbox.end(NAMED)
    outcome, verdict = gearbox.run(1)
    assert verdict['baseline_recording_ns'] == healthy
    assert outcome.level == Level.OK and outcome.message == 'over: backlash_gap: +20 %'
    gearbox.run(20)
    assert len(gearbox.orders) == 1


def test_a_baseline_saved_at_rest_waits_for_the_next_healthy_minute():
    """A minute at rest tells nothing of the drive: each later alert would be refused for it."""
    gearbox = Gearbox()
    gearbox.run(60)
    gearbox.health.pause = SimpleNamespace(friction=None)
    gearbox.run(60)
    gearbox.watch.accept()
    assert not gearbox.watch.recording_ns
    gearbox.health.pause = None
    gearbox.run(59)
    assert not gearbox.watch.recording_ns
    gearbox.run(1)
    assert gearbox.watch.recording_ns == gearbox.monitor.stamp_ns


def test_what_is_over_does_not_come_back_with_another_alert():
    gearbox = Gearbox()
    gearbox.alert()
    outcome, _ = gearbox.run(1)
    assert outcome.level == Level.WARN and 'no healthy minute was recorded' in outcome.message
    gearbox.health.alerts.clear()
    outcome, _ = gearbox.run(69)
    assert outcome.level == Level.OK and outcome.message.startswith('over: backlash has grown: ')
    gearbox.alert()
    gearbox.run(11)
    gearbox.end(NAMED)
    assert gearbox.run(1)[0].level == Level.WARN
    gearbox.health.alerts.clear()
    gearbox.run(1)
    gearbox.monitor.model_lasts = (Level.WARN, gearbox.monitor.stamp_ns)
    outcome, _ = gearbox.run(20)
    assert outcome.level == Level.OK and outcome.message == 'over: backlash_gap: +20 %'


def test_a_mismatch_that_stands_is_named_with_the_alert():
    gearbox = Gearbox()
    gearbox.run(60)
    gearbox.monitor.model_lasts = (Level.WARN, gearbox.monitor.stamp_ns)
    gearbox.run(9)
    gearbox.alert(since_s=61.0)
    gearbox.run(1)
    gearbox.end(NAMED)
    gearbox.run(120)
    assert len(gearbox.orders) == 1


def test_a_clock_set_back_leaves_no_rows_from_before_it():
    """While an alert waits for its 8 s: they are counted from the clock's new start."""
    gearbox = Gearbox()
    gearbox.run(100)
    gearbox.alert()
    gearbox.run(3)
    gearbox.seconds = 10
    gearbox.run(7)
    assert not gearbox.orders
    gearbox.run(2)
    (order,) = gearbox.orders
    stamps = unpacked_rows(order.later(), order.since_ns)['stamp_ns']
    assert (stamps[0], stamps[-1]) == (T0 + 10 * SECOND, gearbox.monitor.stamp_ns)


@pytest.mark.parametrize(('changes', 'words'), [
    ({'serial': 'B'}, 'gearbox_serial: A, expected B'),
    ({'model': DriveModel(damping=0.02)}, 'model: damping: 0.01, expected 0.02'),
    ({'recording_ns': 7}, 'baseline: stamp_ns'), ({'damage': True}, 'expected a baseline')])
def test_a_recording_of_another_is_set_aside_by_name(tmp_path, changes, words):
    path = tmp_path / 'state.json'
    gearbox = Gearbox(StateFile(path, 'e'))
    gearbox.run(70)
    gearbox.file.close()
    if changes.pop('damage', False):
        (tmp_path / 'state.json.recording').write_bytes(b'{}\n')
    settings = {'recording_ns': gearbox.watch.recording_ns, **changes}
    again = Gearbox(StateFile(path, 'e'), **settings)
    assert not again.watch.recording_ns and words in again.watch.note
    assert 'set aside as state.json.recording.refused-' in again.watch.note
    outcome, _ = again.run(1)
    assert outcome.level == Level.WARN and words in outcome.message
    outcome, _ = again.run(70)  # the next healthy minute takes its place
    assert outcome.level == Level.OK and again.watch.recording_ns
    again.file.close()
