# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The estimator as a real process: what it publishes, replay of it, bad data, bad parameters."""
from array import array
import json
import math
import time

import numpy as np
import pytest
import yaml

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from harness import RELIABLE  # noqa: E402
from processes import refusals  # noqa: E402
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import DescribeParameters, SetParameters  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState, Temperature  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.bag.read import open_bag  # noqa: E402
from gearbox_monitor.bag.replay import replay  # noqa: E402
from gearbox_monitor.files.baselines import state_text, write_whole  # noqa: E402
from gearbox_monitor.interfaces.signals import SIGNALS  # noqa: E402
from gearbox_monitor.monitoring.backlash.change import Tracker, TrackerSettings  # noqa: E402
from gearbox_monitor.monitoring.backlash.features import Backlash  # noqa: E402
from gearbox_monitor.parameters import EstimatorParameters  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.plant.excitation import Excitation  # noqa: E402
from gearbox_monitor.plant.simulate import Noise, simulate  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 2_000_000  # 500 Hz
DEEP = QoSProfile(depth=10000)
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def drive():
    t = np.arange(12000) * DT * 1e-9
    return simulate(DriveModel(), Excitation().torque(t), DT * 1e-9,
                    Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=3)


class Feeder:
    """Publishes samples of a trajectory at given stamps, faster than real time, paced."""

    def __init__(self, graph, drive, subscribers=1):
        self.graph, self.drive = graph, drive
        self.publisher = graph.node.create_publisher(JointState, 'joint_states', DEEP)
        graph.until(lambda: self.publisher.get_subscription_count() >= subscribers, 'matching')

    def message(self, k, stamp_ns=None):
        message = JointState(name=['motor', 'arm'])
        message.header.stamp = to_time(T0 + k * DT if stamp_ns is None else stamp_ns)
        message.position = array('d', self.drive.y[k])
        message.effort = array('d', [self.drive.u[k], math.nan])
        return message

    def send(self, messages, rate=1500.0):
        """Publish `messages` at about `rate` per second, the test's node spinning."""
        begin = time.monotonic()
        for k, message in enumerate(messages):
            self.publisher.publish(message)
            if k % 10 == 9:
                self.graph.executor.spin_once(timeout_sec=0.0)
                time.sleep(max(0.0, begin + k / rate - time.monotonic()))
        self.graph.spin(0.5)


def set_parameter(graph, name, value):
    request = SetParameters.Request(parameters=[Parameter(name=name, value=ParameterValue(
        type=ParameterType.PARAMETER_DOUBLE, double_value=value))])
    return graph.call(SetParameters, 'estimator/set_parameters', request).results[0]


def levels_of(message):
    return {s.name.split(': ', 1)[1]: (s.level[0], s.message) for s in message.status}


def test_live_equals_replay_bit_for_bit(graph, drive, tmp_path):
    """Through bad samples, a reset and changes of parameters; from a whole and a cut bag."""
    recorder = graph.start('recorder_node', output=tmp_path / 'bag', queue_depth=20_000)
    estimator = graph.start('estimator_node', snapshot_period=1.5, **RELIABLE)
    feeder = Feeder(graph, drive, subscribers=2)
    graph.until(lambda: graph.node.count_subscribers('/transmission_state'), 'recorder')
    messages = [feeder.message(k) for k in range(4000)]
    messages[700].position = array('d', [math.nan, drive.y[700, 1]])
    messages[701].effort = array('d')
    messages[702].position = array('d', [math.inf, math.nan])
    messages[900:905] = [feeder.message(k, T0 + 899 * DT) for k in range(900, 905)]  # repeated
    messages[1000] = feeder.message(1000, 0)
    messages[1100:1120] = [feeder.message(k, T0 + (k - 500) * DT) for k in range(1100, 1102)]
    del messages[1500:1800]  # a dropout longer than max_gap
    feeder.send(messages[:2000])
    assert set_parameter(graph, 'q_std_tau_k', 12.0).successful
    feeder.send(messages[2000:2600])
    assert graph.call(Trigger, 'estimator/reset', Trigger.Request()).success
    feeder.send(messages[2600:])
    graph.stop(estimator)
    graph.stop(recorder)
    with open_bag(tmp_path / 'bag') as bag:
        result = replay(bag)
    comparison = result.comparison
    assert result.summary['replay_identical'] == 'yes', comparison
    assert comparison.different == comparison.explained == 0
    # The recorder may find the estimator's topics a moment after its first estimates.
    assert comparison.compared == comparison.identical > 0
    refused = result.summary['refused']
    assert refused['starts'] >= 1 and refused['repeated stamps'] == 5
    whole = result.estimates
    mcap = next((tmp_path / 'bag').glob('*.mcap'))
    cut = tmp_path / 'cut.mcap'
    cut.write_bytes(mcap.read_bytes()[:int(0.7 * mcap.stat().st_size)])
    with open_bag(cut) as bag:
        assert bag.truncated
        part, live = replay(bag), bag.topics['/transmission_state'][1]
    assert part.comparison.verdict == 'yes' and part.comparison.compared
    # At its very end a snapshot may be missing that the last samples came after: on a starved
    # machine, what the recorder took behind the last estimates that it holds.
    n = min(live, len(part.estimates.stamp_ns) - 500)
    assert n > 100
    np.testing.assert_array_equal(part.estimates.rows[:n], whole.rows[:n])


def test_recorder_that_joins_late_is_compared_from_the_next_snapshot(graph, drive, tmp_path):
    """The latched snapshots of earlier times are not taken for the begin of the bag."""
    estimator = graph.start('estimator_node', snapshot_period=1.0, **RELIABLE)
    feeder = Feeder(graph, drive)
    feeder.send([feeder.message(k) for k in range(1000)])
    recorder = graph.start('recorder_node', output=tmp_path / 'bag', queue_depth=20_000)
    graph.until(lambda: feeder.publisher.get_subscription_count() == 2, 'recorder')
    feeder.send([feeder.message(k) for k in range(1000, 6000)])
    graph.stop(estimator)
    graph.stop(recorder)
    with open_bag(tmp_path / 'bag') as bag:
        result = replay(bag)
        inputs = bag.joint_states('/joint_states', ['motor']).stamp_ns
        live = bag.joint_states('/transmission_state', ['transmission']).stamp_ns
    comparison, begin = result.comparison, result.estimates.stamp_ns[0]
    assert comparison.verdict == 'yes', comparison
    assert comparison.compared and comparison.early_inputs == 0
    assert begin > T0 + 1000 * DT
    # A starved recorder misses samples: as many as the comparison says, which explain the rest.
    assert comparison.lost_inputs == len(np.setdiff1d(live[live >= begin], inputs))
    assert comparison.compared == comparison.identical + comparison.explained
    assert comparison.lost_inputs or not comparison.explained


def test_outputs_of_a_joint_among_others_with_a_gear(graph, drive, tmp_path):
    """Order of joints, others, a gear ratio with its sign, a current; stamps are of the input."""
    model = tmp_path / 'drive.yaml'
    model.write_text(yaml.safe_dump({
        'gear_ratio': -50.0, 'torque_constant': 0.1, 'arm_load': 'none'}))
    estimator = graph.start('estimator_node', model=model, motor_joint='m7', arm_joint='a7',
                            **RELIABLE)
    got = {signal.topic: [] for signal in SIGNALS}
    for topic, messages in got.items():
        graph.node.create_subscription(JointState, topic, messages.append, DEEP)
    diagnostics = []
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', diagnostics.append, 10)
    feeder = Feeder(graph, drive)
    graph.until(lambda: diagnostics, 'diagnostics')
    sent = []
    for k in range(3000):
        message = feeder.message(k)
        message.name = ['other', 'a7', 'm7']
        message.position = array('d', [9.0, drive.y[k, 1], drive.y[k, 0] * -50.0])
        message.effort = array('d', [1.0, math.nan, drive.u[k] / -5.0])
        sent.append(message)
    feeder.send(sent, rate=600.0)
    states = got['transmission_state']
    graph.until(lambda: len(states) >= 2999, 'the last estimate')
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in states]
    assert stamps == [T0 + k * DT for k in range(1, 3000)]
    tau_k = np.array([m.effort[0] for m in states])
    error = tau_k - drive.tau_k[1:3000]
    assert np.sqrt((error[500:] ** 2).mean()) < 0.3 * drive.tau_k.std()
    estimated = got['estimated_joint_states'][-1]
    assert estimated.name == ['m7', 'a7']
    assert estimated.position[0] == pytest.approx(-50.0 * drive.x[2999, 0], abs=0.5)
    assert all(m.position[0] > 0 for m in got['innovations_stddev'])
    assert len(got['transmission_state_smoothed']) > 2900
    reports = [levels_of(m) for m in diagnostics]  # the last may be of the time without data
    assert any(r['prediction error'][0] == r['input'][0] == 0 for r in reports), reports[-1]
    for message in [m for messages in got.values() for m in messages]:
        assert np.isfinite([*message.position, *message.velocity, *message.effort]).all()
    graph.stop(estimator)


def test_bad_live_data_is_reported_and_survived(graph, drive, tmp_path):
    estimator = graph.start('estimator_node', **RELIABLE)
    diagnostics, states = [], []
    graph.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda m: diagnostics.append(levels_of(m)), 10)
    graph.node.create_subscription(JointState, 'transmission_state', states.append, DEEP)
    feeder = Feeder(graph, drive)

    def until_input_is(level):
        """Wait for the report of that level of the input, then forget all reports."""
        graph.until(lambda: any(report['input'][0] == level for report in diagnostics),
                    f'input of level {level}')
        diagnostics.clear()

    graph.until(lambda: diagnostics and diagnostics[-1]['input'][0] > 0, 'report of no data')
    assert all(level > 0 for level, _ in diagnostics[-1].values())
    feeder.send([feeder.message(k) for k in range(1500)], rate=700.0)
    until_input_is(0)
    # No effort at all: estimation stops, and says why.
    silent = [feeder.message(k) for k in range(1500, 3500)]
    for message in silent:
        message.effort = array('d', [math.nan, math.nan])
    feeder.send(silent, rate=700.0)
    until_input_is(2)
    # By stamps: on a loaded machine good samples are still under way.
    since = to_time(T0 + 1500 * DT)
    predicted = [m for m in states if (m.header.stamp.sec, m.header.stamp.nanosec)
                 >= (since.sec, since.nanosec)]
    assert len(predicted) < 200
    # Nobody stamps: nothing comes out, and zero stamps are named.
    feeder.send([feeder.message(k, 0) for k in range(1500)], rate=700.0)
    until_input_is(2)
    # Back to good data, for the five evaluations that lower a level.
    feeder.send([feeder.message(k) for k in range(3500, 10500)])
    until_input_is(0)
    for message in states:
        assert np.isfinite([*message.position, *message.velocity, *message.effort]).all()
    errors = graph.stop(estimator)
    assert 'input: ERROR' in errors


def test_names_that_do_not_occur_are_told(graph, drive):
    estimator = graph.start('estimator_node', motor_joint='elbow_motor')
    diagnostics = []
    graph.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda m: diagnostics.append(levels_of(m)), 10)
    feeder = Feeder(graph, drive)
    messages = [feeder.message(k) for k in range(400)]
    for message in messages:
        message.name = ['shoulder', 'wrist']
    feeder.send(messages)
    graph.until(lambda: diagnostics and 'elbow_motor' in diagnostics[-1]['input'][1], 'the name')
    graph.stop(estimator)


def test_baseline_is_saved_and_loaded(graph, drive, tmp_path):
    file = tmp_path / 'baseline.yaml'
    estimator = graph.start('estimator_node', drift_window=3.0, baseline_file=file,
                            gearbox_serial='g7', **RELIABLE)
    feeder = Feeder(graph, drive)
    answer = graph.call(Trigger, 'estimator/save_baseline', Trigger.Request())
    assert not answer.success and 'no backlash measured' in answer.message
    feeder.send([feeder.message(k) for k in range(6000)], rate=3000.0)
    answer = graph.call(Trigger, 'estimator/save_baseline', Trigger.Request())
    assert answer.success, answer.message
    graph.stop(estimator)
    saved = yaml.safe_load(file.read_text())
    assert saved['gearbox_serial'] == 'g7' and saved['date'] and saved['parameters']
    assert saved['baseline'][0]['features']['gap']['mean'] == pytest.approx(0.2, rel=0.03)
    latched = []
    graph.start('estimator_node', baseline_file=file, gearbox_serial='g7')
    graph.node.create_subscription(DiagnosticArray, 'estimator/snapshot', latched.append, LATCHED)
    graph.until(lambda: latched, 'snapshot')
    content = {v.key: v.value for v in latched[0].status[0].values}
    drift = json.loads(content['drift'])
    assert len(drift['points']) == len(saved['baseline'])
    counts = drift['blocks'][0][3][0][2:]
    assert counts[0] == saved['baseline'][0]['features']['gap']['windows']


def test_drift_state_survives_a_restart(graph, drive, tmp_path):
    """An alarm and its baseline; without the file's sense it is set aside, and the node runs."""
    file, serial = tmp_path / 'state.json', 'g7'
    tracker = Tracker(TrackerSettings.of(EstimatorParameters(), DriveModel()))
    random = np.random.default_rng(0)
    for k in range(60):
        gap = 0.2 * (1.0 if k < 40 else 1.3) + 1e-3 * random.standard_normal()
        tracker.update(Backlash(T0 - (60 - k) * 10 ** 10, gap, 1e-3, 25.0, 0.1, angle=0.0,
                                speed=18.0, load=3.6, flank=0.4))
    write_whole(file, state_text(tracker, serial))
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
    assert 'backlash has grown by +30' in status.message and status.hardware_id == serial
    values = {v.key: v.value for v in status.values}
    assert float(values['baseline_gap_rad']) == pytest.approx(0.2, rel=0.01)
    # Windows go on from there, at their temperature, and are written.
    warm = graph.node.create_publisher(Temperature, 'gearbox_temperature', 10)
    graph.until(lambda: warm.get_subscription_count(), 'temperature')
    for _ in range(10):
        warm.publish(Temperature(temperature=41.5))
        graph.spin(0.1)
    feeder = Feeder(graph, drive)
    feeder.send([feeder.message(k) for k in range(4000)], rate=2000.0)
    graph.stop(estimator)
    state = json.loads(file.read_text())['drift']
    told = [(s.name, s.message) for a in alerts for s in a.status]
    # What is fed has the gap of the baseline: the alarm may be over, and nothing else is told.
    assert state['stamp_ns'] > T0 and all('over: ' in text for _, text in told[1:]), told
    assert state['points'][-1]['temperature'] == 41.5
    file.write_text(file.read_text()[:1000])
    baseline = tmp_path / 'baseline.yaml'
    baseline.write_text('baseline: [{angle: 0.1,')
    graph.spin(0.5)  # what the first node sent last would pass for the second one's
    diagnostics.clear()
    estimator = graph.start('estimator_node', baseline_file=baseline, **parameters)
    graph.until(lambda: diagnostics, 'diagnostics')
    errors = graph.stop(estimator)
    for path in (file, baseline):
        assert f'set aside as {path.name}.corrupt-' in errors and not path.exists()


def test_parameters_are_described_and_checked(graph):
    graph.start('estimator_node')
    answer = graph.call(DescribeParameters, 'estimator/describe_parameters',
                        DescribeParameters.Request(names=['q_std_tau_k', 'filter']))
    tau, kind = answer.descriptors
    assert 'N m/sqrt(s)' in tau.description and tau.floating_point_range[0].from_value == 0.0
    assert kind.read_only and not tau.read_only
    for value in (-1.0, math.nan):
        assert not set_parameter(graph, 'q_std_tau_k', value).successful
    assert not set_parameter(graph, 'max_gap', 1.0).successful
    assert set_parameter(graph, 'friction_error_std', 0.1).successful  # a state more


def test_bad_parameters_end_with_one_line(tmp_path):
    said = {
        'filter:=kalman9': "filter: 'kalman9', expected one of aekf, ekf",
        'q_std_tau_k:=-3.0': 'q_std_tau_k: -3.0, expected a number >= 0',
        'q_std_tau_k:=fast': "q_std_tau_k: 'fast', expected a number",
        'model:=nowhere.yaml': 'nowhere.yaml: No such file',
        'baseline_file:=/': '/: Is a directory'}
    runs = refusals('estimator_node', [['-p', parameter] for parameter in said], tmp_path)
    for (code, lines), words in zip(runs, said.values()):
        assert code == 2 and len(lines) == 1 and words in lines[0], lines
