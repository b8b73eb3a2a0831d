# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The estimator beside a stack: its namespace, topics of others, their clock, their parameters."""
from array import array
import json
import math
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from drives import driven  # noqa: E402
from rcl_interfaces.srv import DescribeParameters  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.files.user_files import load_parameters  # noqa: E402
from gearbox_monitor.parameters import resolve, SETTINGS  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.recordings.joint_input import find_input, read_snapshots  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.recordings.reading import paired_bag  # noqa: E402
from gearbox_monitor.recordings.replay import replay  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 2_000_000  # 500 Hz
DEEP = QoSProfile(depth=10000)
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
RELIABLE = {'subscription': {'reliability': 'reliable', 'depth': 20_000}}
ROBOT = {
    '/**/estimator': {'ros__parameters': {
        'arm_load': 'none', 'snapshot_period': 1.0, 'use_sim_time': True,
        'qos_overrides': {'/joint_states': RELIABLE, '/encoders/elbow': RELIABLE, '/tau': {
            'publisher': {'reliability': 'best_effort'}}}}},
    '/shoulder/estimator': {'ros__parameters': {'q_std_tau_k': 1.0}},
    '/elbow/estimator': {'ros__parameters': {
        'motor_joint': 'elbow_motor', 'arm_joint': 'elbow', 'arm_topic': '/encoders/elbow',
        'pair_tolerance': 0.0004, 'coulomb_friction': 0.26}}}
UNPAIRED = range(1000, 1100)


@pytest.fixture(scope='module')
def drive():
    return driven(DriveModel(), 3000 * DT * 1e-9, dt=DT * 1e-9)


class Robot:
    """A driver that publishes the motor among other joints, and an encoder of its own."""

    def __init__(self, graph, drive):
        self.graph, self.drive = graph, drive
        publish = graph.node.create_publisher
        self.motor = publish(JointState, '/joint_states', DEEP)
        self.arm = publish(JointState, '/encoders/elbow', DEEP)
        self.clock = publish(Clock, '/clock', 10)
        self.jitter = np.random.default_rng(1).integers(-300_000, 300_000, 3000).tolist()

    def move(self, begin, end, rate=600.0):
        """Publish the samples begin .. end - 1 at about `rate` per second."""
        start = time.monotonic()
        for k in range(begin, end):
            stamp = T0 + k * DT
            others = ['wrist', 'gripper'][:1 + k // 300 % 2]
            message = JointState(name=[*others, 'elbow_motor'] if k // 200 % 2
                                 else ['elbow_motor', *others])
            at = message.name.index('elbow_motor')
            message.header.stamp = to_time(stamp)
            for field, value in ((message.position, self.drive.y[k, 0]),
                                 (message.effort, self.drive.u[k])):
                field.extend([math.nan] * len(message.name))
                field[at] = value
            self.motor.publish(message)
            message = JointState(name=['elbow'], position=array('d', [self.drive.y[k, 1]]))
            message.header.stamp = to_time(
                stamp + (900_000 if k in UNPAIRED else self.jitter[k]))
            self.arm.publish(message)
            if k % 10 == 9:
                self.tell_time(k)
                self.graph.executor.spin_once(timeout_sec=0.0)
                time.sleep(max(0.0, start + (k - begin) / rate - time.monotonic()))

    def tell_time(self, k):
        self.clock.publish(Clock(clock=to_time(T0 + k * DT)))


@pytest.mark.system
def test_one_gearbox_of_a_robot(graph, drive, tmp_path):
    """Motor and arm on two topics, remapped, in simulated time, through changes: as in replay."""
    file = tmp_path / 'robot.yaml'
    file.write_text(json.dumps(ROBOT))  # is YAML, without anchors
    recorder = graph.start(
        'recorder_node', '-r', '__ns:=/elbow', output=tmp_path / 'bag', use_sim_time='true',
        queue_depth=20_000,
        topics='[/joint_states, /encoders/elbow, paired_joint_states, estimator/snapshot, /tau, '
               'innovations, transmission_state_smoothed, drift_alerts]')
    # The simulation clock does not run yet.
    estimator = graph.start(
        'estimator_node', '-r', '__ns:=/elbow', '-r', 'joint_states:=/joint_states',
        '-r', 'transmission_state:=/tau', '--params-file', str(file), '-p', 'misspelt:=1')
    robot = Robot(graph, drive)
    snapshots, said, estimated = [], [], []
    listen = graph.node.create_subscription
    listen(DiagnosticArray, '/elbow/estimator/snapshot',
           lambda m: snapshots.append({v.key: v.value for v in m.status[0].values}), LATCHED)
    listen(JointState, '/tau', lambda m: estimated.append(m.header.stamp), QoSProfile(
        depth=5000, reliability=ReliabilityPolicy.BEST_EFFORT))
    listen(DiagnosticArray, '/diagnostics', lambda m: said.extend(
        {v.key: v.value for v in s.values} for s in m.status
        if s.name == 'elbow/estimator: input'), 50)
    graph.until(lambda: snapshots and robot.motor.get_subscription_count() == 2
                and robot.arm.get_subscription_count() == 2, 'matching')

    def taken():
        return int(said[-1].get('samples', 0)) if said else 0

    robot.move(0, 1500)
    assert graph.set('/elbow/estimator', q_std_tau_k=9.0)[0].successful
    robot.move(1500, 2000)
    assert graph.set('/elbow/estimator', coulomb_friction=0.27)[0].successful
    refused = graph.set('/elbow/estimator', filter='ukf')[0]
    assert not refused.successful
    assert refused.reason == ('filter: read-only while the node runs; change it in the parameter '
                              'file (or with -p) and start estimator again')
    assert not graph.set('/elbow/estimator', motor_inertia=-1.0)[0].successful
    robot.move(2000, 3000)
    assert not any(s['reason'] == 'clock' for s in snapshots)
    # Samples that still wait when the clock is set back are of another time: they are refused.
    until = time.monotonic() + 20.0
    graph.until(lambda: to_time(T0 + 2999 * DT) in estimated or time.monotonic() > until)
    robot.tell_time(1000)  # the simulation starts again
    graph.until(lambda: snapshots[-1]['reason'] == 'clock', 'answer to the clock')
    robot.move(1200, 2400)
    graph.until(lambda: taken() > 3500 and said[-1].get('clock_set_back') == '1', 'all samples')
    answer = graph.call(DescribeParameters, '/elbow/estimator/describe_parameters',
                        DescribeParameters.Request(names=['coulomb_friction', 'max_gap']))
    friction, gap = answer.descriptors
    assert friction.description.endswith('[N m]') and friction.floating_point_range
    assert 'restarts the filter' in friction.additional_constraints and gap.read_only
    assert graph.call(Trigger, '/elbow/estimator/reset', Trigger.Request()).success
    offered = graph.node.get_publishers_info_by_topic('/tau')[0].qos_profile
    assert offered.reliability == ReliabilityPolicy.BEST_EFFORT
    errors = graph.stop(estimator)
    graph.stop(recorder)
    assert 'no parameters of this node, ignored: misspelt' in errors
    assert '/clock was set back by' in errors
    unpaired = [values for values in said if 'motor_without_arm' in values][-1]
    assert int(unpaired['motor_without_arm']) == len(UNPAIRED)
    assert any(values.get('nearest_unpaired_s') == '0.0009' for values in said)

    with open_bag(tmp_path / 'bag') as bag:
        found = find_input(bag)
        assert found.topic == '/elbow/paired_joint_states' and found.namespace == '/elbow'
        recorded = read_snapshots(bag, found)
        result = replay(bag)
        given = load_parameters(file, 'estimator', SETTINGS, 'elbow/estimator')
        joints = given['motor_joint'], given['arm_joint']
        live = bag.joint_states(found.topic, joints)
        del bag.topics[found.topic]
        paired = paired_bag(bag, resolve(DriveModel(), given)[1], '/joint_states')
        again = paired.joint_states('/joint_states', joints)
    # The recorder may find the estimator a moment after its first sample.
    assert len(again.stamp_ns) == 4200 >= len(live.stamp_ns) > 0
    assert paired.notes[-1].startswith(f'{len(UNPAIRED)} samples without the arm; ')
    for field in ('stamp_ns', 'position', 'effort'):
        np.testing.assert_array_equal(
            getattr(again, field)[-len(live.stamp_ns):], getattr(live, field))
    reasons = [s.content['reason'] for s in recorded]
    assert reasons.count('parameters') == 2 and reasons.count('clock') == 1
    friction = [json.loads(s.content['model'])['coulomb_friction'] for s in recorded]
    assert friction[0] == 0.26 and friction[-1] == 0.27
    comparison = result.comparison
    assert result.summary['replay_identical'] == 'yes', comparison
    assert comparison.different == comparison.explained == comparison.lost_inputs == 0
    assert comparison.compared
    # Q goes on: two starts are those of the first sample, of the friction and of the clock.
    assert int(result.monitor.counts[1]) == 3
