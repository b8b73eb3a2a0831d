# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The load by a robot's description in a real node: from a topic, with a payload, as in replay."""
from array import array
import json
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from harness import RELIABLE  # noqa: E402, I100, I202
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from robot_arm import worked  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402

from gearbox_monitor.files.user_files import config_path, load_robot, save_model  # noqa: E402
from gearbox_monitor.recordings.read import open_bag  # noqa: E402
from gearbox_monitor.recordings.replay import replay  # noqa: E402
from gearbox_monitor.recordings.topics import SIGNALS  # noqa: E402
from gearbox_monitor.robot import arm_plant  # noqa: E402
from gearbox_monitor.robot.arm_plant import ArmPlant  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = [pytest.mark.ros, pytest.mark.system]
T0 = 1_700_000_000_000_000_000
DT = 2_000_000  # 500 Hz
GEARBOXES = {'elbow': 2, 'tilt': 4}  # joint numbers
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_live_is_replay_with_a_description_and_a_payload(graph, tmp_path):
    """The bag holds what replay needs: the description is in the snapshots."""
    text = config_path('arm6.urdf').read_text()
    robot = load_robot(str(config_path('arm6.urdf')))
    rng = np.random.default_rng(4)
    plant = ArmPlant(arm_plant.as_built(robot, rng, 0.1),
                     arm_plant.nominal_drives(robot), arm_plant.MIDDLE)
    run, payload, motor, arm = worked(plant, rng, 2, DT * 1e-9)
    drives = arm_plant.nominal_drives(robot)
    for name, joint in GEARBOXES.items():
        save_model(tmp_path / f'{name}.yaml', drives[joint], [])
    file = tmp_path / 'robot.yaml'
    file.write_text(json.dumps({'estimator': {'ros__parameters': {
        'gearboxes': list(GEARBOXES), 'robot_description': 'topic:/robot_description',
        'snapshot_period': 1.0,
        **{name: {**arm_plant.parameters_of(joint), 'model': str(tmp_path / f'{name}.yaml')}
           for name, joint in GEARBOXES.items()},
        'qos_overrides': {'/joint_states': {'subscription': {
            key.rpartition('.')[2]: value for key, value in RELIABLE.items()}}}}}}))
    recorder = graph.start(
        'recorder_node', output=tmp_path / 'bag', queue_depth=20_000, topics=str([
            'joint_states', *(signal.topic for signal in SIGNALS),
            *(f'/estimator/{name}/snapshot' for name in GEARBOXES)]))
    estimator = graph.start('estimator_node', '--params-file', str(file))
    publisher = graph.node.create_publisher(JointState, 'joint_states', QoSProfile(depth=20_000))
    time.sleep(1.0)  # the node waits for the description, and does not miss a late one
    description = graph.node.create_publisher(String, '/robot_description', LATCHED)
    description.publish(String(data=text))
    graph.until(lambda: publisher.get_subscription_count() == 2
                and graph.node.count_subscribers('/innovations'), 'matching')
    names = [*robot.joints, *(f'motor{k + 1}' for k in range(6))]
    begin, n = time.monotonic(), len(run.t)
    for k in range(n):
        message = JointState(name=names)
        message.header.stamp = to_time(T0 + k * DT)
        message.position = array('d', [*arm[k], *motor[k]])
        message.effort = array('d', [np.nan] * 6 + list(run.u[k]))
        publisher.publish(message)
        if k == n // 2:
            answer, = graph.set('estimator', **{'elbow.payload_mass': 2.5})
            assert answer.successful, answer
        if k % 10 == 9:
            graph.executor.spin_once(timeout_sec=0.0)
            time.sleep(max(0.0, begin + k / 500.0 - time.monotonic()))
    graph.spin(2.0)
    graph.stop(estimator)
    graph.stop(recorder)
    with open_bag(tmp_path / 'bag') as bag:
        for name, joint in GEARBOXES.items():
            result = replay(bag, topic=name)
            comparison = result.comparison
            assert comparison.verdict == 'yes' and comparison.compared, (name, comparison)
            assert comparison.lost_inputs or not comparison.explained
            assert result.estimator.robot_joints == robot.joints
            mass = result.estimator.parameters.payload_mass
            assert mass == (2.5 if name == 'elbow' else 0.0)
            e = result.estimates
            rows = np.searchsorted(T0 + DT * np.arange(n), e.stamp_ns)
            settled = slice(200, int(np.flatnonzero(payload)[0]))
            error = (e.tau_k - run.tau_k[rows, joint])[settled]
            assert np.sqrt(np.mean(error ** 2)) < 0.3 * np.std(run.tau_k[:, joint])
