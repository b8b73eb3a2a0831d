# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The estimator as a real process: what it publishes, replay of it, bad data, bad parameters."""
from array import array
from dataclasses import dataclass
import json
import math
from pathlib import Path
import time

import numpy as np
import pytest
import yaml

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from drives import driven  # noqa: E402
from harness import Graph, RELIABLE  # noqa: E402
from processes import refusals  # noqa: E402
from rcl_interfaces.srv import DescribeParameters  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState, Temperature  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.files.baselines import health_text, STATE, write_whole  # noqa: E402
from gearbox_monitor.health.backlash.features import Backlash  # noqa: E402
from gearbox_monitor.health.health_record import HealthSettings, Window  # noqa: E402
from gearbox_monitor.health.judgement import Health, judge  # noqa: E402
from gearbox_monitor.parameters import EstimatorParameters  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.recordings.replay import replay  # noqa: E402
from gearbox_monitor.recordings.topics import SIGNALS  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 4_000_000  # 250 Hz
GEAR, TORQUE_CONSTANT = -50.0, 0.1
DEEP = QoSProfile(depth=10000)
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def drive():
    return driven(DriveModel(), 6000 * DT * 1e-9, dt=DT * 1e-9)


class Feeder:
    """Publishes samples of a trajectory at given stamps, faster than real time, paced."""

    def __init__(self, graph, drive, names=('arm', 'motor'), gear=1.0, subscribers=1):
        self.graph, self.drive, self.names, self.gear = graph, drive, names, gear
        self.publisher = graph.node.create_publisher(JointState, 'joint_states', DEEP)
        graph.until(lambda: self.publisher.get_subscription_count() >= subscribers, 'matching')

    def message(self, k, stamp_ns=None):
        """Return sample k: another joint, the arm, and the motor in front of its gear."""
        message = JointState(name=['other', *self.names])
        message.header.stamp = to_time(T0 + k * DT if stamp_ns is None else stamp_ns)
        motor, arm = self.drive.y[k]
        message.position = array('d', [9.0, arm, motor * self.gear])
        message.effort = array('d', [1.0, math.nan, self.drive.u[k] / (
            self.gear * TORQUE_CONSTANT if self.gear != 1.0 else 1.0)])
        return message

    def send(self, messages, rate=750.0):
        """Publish `messages` at about `rate` per second, the test's node spinning."""
        begin = time.monotonic()
        for k, message in enumerate(messages):
            self.publisher.publish(message)
            if k % 10 == 9:
                self.graph.executor.spin_once(timeout_sec=0.0)
                time.sleep(max(0.0, begin + k / rate - time.monotonic()))
        self.graph.spin(0.5)


def levels_of(message):
    return {s.name.split(': ', 1)[1]: (s.level[0], s.message) for s in message.status}


@dataclass
class Run:
    """What an estimator, its recorder and one that joined late left, and what was answered."""

    folder: Path
    answers: dict
    told: dict  # {when: levels_of the diagnostics at that time}
    errors: str


@pytest.fixture(scope='module')
def run(drive, tmp_path_factory):
    """Take one estimator through bad samples, services, changes and a late recorder."""
    folder, answers, told, reports = tmp_path_factory.mktemp('run'), {}, {}, []
    model = folder / 'drive.yaml'
    model.write_text(yaml.safe_dump({
        'gear_ratio': GEAR, 'torque_constant': TORQUE_CONSTANT, 'arm_load': 'none'}))
    with pytest.MonkeyPatch.context() as monkeypatch:
        graph = Graph(folder, monkeypatch)
        graph.node.create_subscription(
            DiagnosticArray, '/diagnostics', lambda m: 'estimator: ' in m.status[0].name
            and reports.append(levels_of(m)), 10)

        def tell(when, condition, messages=()):
            """Keep a report that meets the condition, of the time that messages take or later."""
            reports.clear()
            if messages:
                feeder.send(messages, rate=350.0)
            graph.until(lambda: any(map(condition, reports)), when)
            told[when] = next(filter(condition, reports))

        try:
            recorder = graph.start('recorder_node', output=folder / 'bag', queue_depth=20_000)
            estimator = graph.start(
                'estimator_node', model=model, motor_joint='m7', arm_joint='a7',
                snapshot_period=1.0, drift_window=3.0, baseline_file=folder / 'baseline.yaml',
                gearbox_serial='g7', **RELIABLE)
            feeder = Feeder(graph, drive, ('a7', 'm7'), GEAR, subscribers=2)
            graph.until(lambda: graph.node.count_subscribers('/transmission_state'), 'recorder')
            tell('no data', bool)
            strangers = [feeder.message(k) for k in range(100)]
            for message in strangers:
                message.name = ['other', 'shoulder', 'wrist']
            tell('other names', lambda report: 'm7' in report['input'][1], strangers)
            answers['early'] = graph.call(
                Trigger, 'estimator/save_baseline', Trigger.Request())
            tell('good data', lambda report: report['input'][0] == report['prediction error'][
                0] == 0, [feeder.message(k) for k in range(1000)])
            messages = {k: feeder.message(k) for k in range(1000, 3000)}
            messages[1350].position[2] = math.nan
            messages[1351].effort = array('d')
            messages[1352].position = array('d', [9.0, math.nan, math.inf])
            for k in range(1450, 1455):
                messages[k] = feeder.message(k, T0 + 1449 * DT)  # repeated
            messages[1500] = feeder.message(1500, 0)
            for k in (1550, 1551):
                messages[k] = feeder.message(k, T0 + (k - 250) * DT)
            for k in range(1750, 1900):  # a dropout longer than max_gap
                del messages[k]
            messages = list(messages.values())
            feeder.send(messages[:1000])
            for name, value in (('q_std_tau_k', 12.0), ('q_std_tau_k', -1.0),
                                ('q_std_tau_k', math.nan), ('max_gap', 1.0),
                                ('friction_error_std', 0.1)):
                answers[name, str(value)] = graph.set('estimator', **{name: value})[0]
            answers['described'] = graph.call(
                DescribeParameters, 'estimator/describe_parameters',
                DescribeParameters.Request(names=['q_std_tau_k', 'filter']))
            late = graph.start('recorder_node', '-r', '__node:=late', output=folder / 'late',
                               queue_depth=20_000)
            graph.until(lambda: feeder.publisher.get_subscription_count() == 3, 'recorder')
            feeder.send(messages[1000:1300])
            answers['reset'] = graph.call(Trigger, 'estimator/reset', Trigger.Request())
            feeder.send(messages[1300:])
            feeder.send([feeder.message(k) for k in range(3000, 5000)])
            answers['saved'] = graph.call(
                Trigger, 'estimator/save_baseline', Trigger.Request())
            graph.stop(late)
            # No effort at all: estimation stops, and says why. Then nobody stamps.
            silent = [feeder.message(k) for k in range(5000, 5500)]
            for message in silent:
                message.effort = array('d', [math.nan] * 3)
            tell('no effort', lambda report: 'effort' in report['input'][1], silent)
            tell('no stamps', lambda report: 'zero stamps' in report['input'][1],
                 [feeder.message(k, 0) for k in range(500)])
            feeder.send([feeder.message(k) for k in range(5500, 6000)])
            errors = graph.stop(estimator)
            graph.stop(recorder)
        finally:
            graph.close()
    return Run(folder, answers, told, errors)


def test_live_equals_replay_bit_for_bit(run, tmp_path):
    """Through bad samples, a reset and changes of parameters; from a whole and a cut bag."""
    with open_bag(run.folder / 'bag') as bag:
        result = replay(bag)
    comparison = result.comparison
    assert result.summary['replay_identical'] == 'yes', comparison
    assert comparison.different == comparison.explained == 0
    # The recorder may find the estimator's topics a moment after its first estimates.
    assert comparison.compared == comparison.identical > 0
    refused = result.summary['refused']
    assert refused['starts'] >= 1 and refused['repeated stamps'] == 5
    whole = result.estimates
    mcap = next((run.folder / 'bag').glob('*.mcap'))
    cut = tmp_path / 'cut.mcap'
    cut.write_bytes(mcap.read_bytes()[:int(0.5 * mcap.stat().st_size)])
    with open_bag(cut) as bag:
        assert bag.truncated
        part, live = replay(bag), bag.topics['/transmission_state'][1]
    assert part.comparison.verdict == 'yes' and part.comparison.compared
    # At its very end a snapshot may be missing that the last samples came after: on a starved
    # machine, what the recorder took behind the last estimates that it holds.
    n = min(live, len(part.estimates.stamp_ns) - 250)
    assert n > 100
    np.testing.assert_array_equal(part.estimates.rows[:n], whole.rows[:n])


def test_recorder_that_joins_late_is_compared_from_the_next_snapshot(run):
    """The latched snapshots of earlier times are not taken for the begin of the bag."""
    with open_bag(run.folder / 'late') as bag:
        result = replay(bag)
        inputs = bag.joint_states('/joint_states', ['m7']).stamp_ns
        live = bag.joint_states('/transmission_state', ['transmission']).stamp_ns
    comparison, begin = result.comparison, result.estimates.stamp_ns[0]
    assert comparison.verdict == 'yes', comparison
    assert comparison.compared and comparison.early_inputs == 0
    assert begin > T0 + 2000 * DT
    # A starved recorder misses samples: as many as the comparison says, which explain the rest.
    assert comparison.lost_inputs == len(np.setdiff1d(live[live >= begin], inputs))
    assert comparison.compared == comparison.identical + comparison.explained
    assert comparison.lost_inputs or not comparison.explained


def test_outputs_of_a_joint_among_others_with_a_gear(run, drive):
    """Order of joints, others, a gear ratio with its sign, a current; stamps are of the input."""
    with open_bag(run.folder / 'bag') as bag:
        state = bag.joint_states('/transmission_state', ['transmission'])
        estimated = bag.joint_states('/estimated_joint_states', ['m7', 'a7'])
        deviations = bag.joint_states('/innovations_stddev', ['m7', 'a7'])
        counts = {signal.topic: bag.topics[f'/{signal.topic}'][1] for signal in SIGNALS
                  if not signal.gated}  # ratios follow from two others and are not recorded
    rows = (state.stamp_ns > T0 + 250 * DT) & (state.stamp_ns < T0 + 1000 * DT)
    k = (state.stamp_ns[rows] - T0) // DT
    assert len(k) > 700 and (T0 + k * DT == state.stamp_ns[rows]).all()
    error = state.effort[rows, 0] - drive.tau_k[k]
    assert np.sqrt((error ** 2).mean()) < 0.3 * drive.tau_k.std()
    rows = np.flatnonzero(estimated.stamp_ns == T0 + 999 * DT)[0]
    assert estimated.position[rows, 0] == pytest.approx(GEAR * drive.x[999, 0], abs=0.5)
    assert (deviations.position > 0).all() and min(counts.values()) > 3500
    for states in (state, estimated):
        assert np.isfinite(states.position).all()


def test_bad_live_data_is_reported_and_survived(run):
    told = run.told
    assert all(level > 0 for level, _ in told['no data'].values())
    assert told['no stamps']['input'][0] == 2 and told['no effort']['input'][0] == 2
    assert 'input: ERROR' in run.errors


def test_parameters_are_described_and_checked(run):
    tau, kind = run.answers['described'].descriptors
    assert 'N m/sqrt(s)' in tau.description and tau.floating_point_range[0].from_value == 0.0
    assert kind.read_only and not tau.read_only
    assert run.answers['q_std_tau_k', '12.0'].successful and run.answers['reset'].success
    for key in (('q_std_tau_k', '-1.0'), ('q_std_tau_k', 'nan'), ('max_gap', '1.0')):
        assert not run.answers[key].successful
    assert run.answers['friction_error_std', '0.1'].successful  # a state more


def test_baseline_is_saved_and_loaded(run, graph):
    early, answer = run.answers['early'], run.answers['saved']
    assert not early.success and 'no backlash measured' in early.message
    assert answer.success, answer.message
    file = run.folder / 'baseline.yaml'
    saved = json.loads(file.read_text().splitlines()[0])
    assert saved['gearbox_serial'] == 'g7' and saved['date'] and saved['parameters']
    assert 'gap 0.2' in answer.message or 'gap 0.19' in answer.message
    latched = []
    graph.start('estimator_node', baseline_file=file, gearbox_serial='g7')
    graph.node.create_subscription(DiagnosticArray, 'estimator/snapshot', latched.append, LATCHED)
    graph.until(lambda: latched, 'snapshot')
    content = {v.key: v.value for v in latched[0].status[0].values}
    assert json.loads(content['health']) == saved['health']


def test_drift_state_survives_a_restart(graph, drive, tmp_path):
    """An alarm and its baseline; without the file's sense it is set aside, and the node runs."""
    file, serial = tmp_path / 'state.json', 'g7'
    health = Health(HealthSettings.of(EstimatorParameters(), DriveModel()))
    random = np.random.default_rng(0)
    for k in range(60):
        gap = 0.2 * (1.0 if k < 40 else 1.3) + 1e-3 * random.standard_normal()
        health = judge(health, Window(Backlash(
            T0 - (60 - k) * 10 ** 10, gap, 1e-3, 25.0, 0.1, angle=0.0, speed=18.0, load=3.6,
            flank=0.4)))
    write_whole(file, health_text(STATE, health, serial, recording_ns=0))
    alerts, snapshots, diagnostics = [], [], []
    for kind, topic, got, qos in ((DiagnosticArray, 'drift_alerts', alerts, LATCHED),
                                  (DiagnosticArray, 'estimator/snapshot', snapshots, LATCHED),
                                  (DiagnosticArray, '/diagnostics', diagnostics, 10)):
        graph.node.create_subscription(kind, topic, got.append, qos)
    parameters = {'drift_state_file': file, 'gearbox_serial': serial, 'drift_window': 2.0,
                  'temperature_topic': 'gearbox_temperature', **RELIABLE}
    estimator = graph.start('estimator_node', **parameters)
    graph.until(lambda: alerts and snapshots, 'alert from before')
    status = alerts[0].status[0]
    assert status.name == 'estimator: backlash' and status.level == b'\x02'
    assert 'backlash has grown by 30' in status.message and status.hardware_id == serial
    values = {v.key: v.value for v in status.values}
    assert float(values['baseline_gap_rad']) == pytest.approx(0.2, rel=0.01)
    # Windows go on from there, at their temperature, and are written.
    warm = graph.node.create_publisher(Temperature, 'gearbox_temperature', 10)
    graph.until(lambda: warm.get_subscription_count(), 'temperature')
    for _ in range(10):
        warm.publish(Temperature(temperature=41.5))
        graph.spin(0.1)
    feeder = Feeder(graph, drive)
    feeder.send([feeder.message(k) for k in range(2000)], rate=4000.0)  # several windows a status
    graph.stop(estimator)
    state = json.loads(file.read_text().splitlines()[0])['health']
    told = [(s.name, s.message) for a in alerts for s in a.status]
    # What is fed has the gap of the baseline: the alarm may be over, and nothing else is told.
    assert state['stamp_ns'] > T0 and all('over: ' in text for _, text in told[1:]), told
    assert state['data']['points'][-1]['temperature'] == 41.5
    file.write_text(file.read_text()[:1000])
    baseline = tmp_path / 'baseline.yaml'
    baseline.write_text(file.read_text()[100:])
    graph.spin(0.5)  # what the first node sent last would pass for the second one's
    diagnostics.clear()
    estimator = graph.start('estimator_node', baseline_file=baseline, **parameters)
    graph.until(lambda: diagnostics, 'diagnostics')
    errors = graph.stop(estimator)
    lost, = (s for s in diagnostics[-1].status if s.name == 'estimator: backlash')
    assert lost.level > b'\x00' and 'the earlier state of wear is lost: ' in lost.message
    for path in (file, baseline):
        for words in (errors, lost.message):
            assert f'set aside as {path.name}.corrupt-' in words
        assert not path.exists()


def test_a_bad_parameter_ends_with_one_line(tmp_path):
    said = {'filter:=kalman9': "filter: 'kalman9', expected one of aekf, ekf",
            'model:=nowhere.yaml': 'nowhere.yaml: No such file',
            'other_publishers:=accept': 'two publishers of one joint are an ERROR'}
    runs = refusals('estimator_node', [['-p', parameter] for parameter in said], tmp_path)
    for (code, lines), words in zip(runs, said.values()):
        assert code == 2 and len(lines) == 1 and words in lines[0], lines
