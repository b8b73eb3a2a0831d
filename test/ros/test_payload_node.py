# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The payload node: live is what the library gives for the same samples, and what it refuses."""
from array import array
import subprocess
import sys

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from geometry_msgs.msg import InertiaStamped  # noqa: E402
from harness import RELIABLE  # noqa: E402
from processes import refusals  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor import load_robot  # noqa: E402
from gearbox_monitor.files.opening import config_path  # noqa: E402
from gearbox_monitor.library.robot import payload_tracker  # noqa: E402
from gearbox_monitor.ros.convert import stamp_of, to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0, DT, N = 1_700_000_000_000_000_000, 10_000_000, 400
DEEP = QoSProfile(depth=1000)


def test_live_is_what_the_library_gives_and_incomplete_messages_are_told(graph):
    robot = load_robot(config_path('arm6.urdf'))
    rng, t = np.random.default_rng(1), np.arange(N) * 0.01
    q = 0.5 * np.sin(t[:, None] * np.linspace(1.0, 3.0, 6))
    u = rng.normal(0.0, 5.0, (N, 6))
    process = graph.start('payload_node', model=config_path('arm6.urdf'), **RELIABLE)
    masses, torques, statuses = [], [], []
    node = graph.node
    node.create_subscription(InertiaStamped, 'payload', masses.append, DEEP)
    node.create_subscription(JointState, 'external_torque', torques.append, DEEP)
    node.create_subscription(DiagnosticArray, '/diagnostics', statuses.append, DEEP)
    publisher = node.create_publisher(JointState, 'joint_states', DEEP)
    graph.until(lambda: publisher.get_subscription_count() and node.count_publishers('payload'),
                'the node')
    torso = JointState(name=list(robot.joints[:5]), position=array('d', [0.0] * 5),
                       effort=array('d', [0.0] * 5))
    torso.header.stamp = to_time(T0)
    publisher.publish(torso)
    graph.until(lambda: any('without position and effort of joint6' in status.message
                            for message in statuses for status in message.status), 'the warning')
    names = ['gripper', *reversed(robot.joints)]  # messages may hold more, in another order
    for k in range(N):
        message = JointState(name=names, position=array('d', [9.0, *q[k, ::-1]]),
                             effort=array('d', [9.0, *u[k, ::-1]]))
        message.header.stamp = to_time(T0 + k * DT)
        publisher.publish(message)
        if k % 50 == 0:
            graph.spin(0.01)
    tracker = payload_tracker(robot)
    expected = [e for k in range(N) for e in tracker.take(T0 + k * DT, q[k], u[k])]
    graph.until(lambda: len(masses) >= len(expected) and len(torques) >= len(expected),
                'all estimates')
    assert [stamp_of(m) for m in masses] == [e.stamp_ns for e in expected]
    assert [m.inertia.m for m in masses] == [e.mass for e in expected]
    assert [list(m.effort) for m in torques] == [e.external.tolist() for e in expected]
    assert masses[0].header.frame_id == 'flange' and torques[0].name == list(robot.joints)
    answer = graph.call(Trigger, '/payload/tare', Trigger.Request())
    assert answer.success and 'flange' in answer.message
    graph.until(lambda: any('held at flange' in status.message.lower()
                            for message in statuses for status in message.status), 'the status')
    graph.stop(process)


def test_no_sample_waits_for_a_module():
    code = f"""
import sys
import numpy as np
import rclpy
from gearbox_monitor.ros.payload_node import PayloadNode
rclpy.init(args=['--ros-args', '-p', 'model:={config_path('arm6.urdf')}'])
tracker = PayloadNode()._tracker
loaded = set(sys.modules)
out = [e for k in range(400) for e in tracker.take({T0} + k * {DT}, np.full(6, np.sin(0.02 * k)),
                                                   np.full(6, np.cos(0.05 * k)))]
print(len(out) > 0, sorted(set(sys.modules) - loaded))
"""
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout == 'True []\n'


def test_what_cannot_work_is_refused_in_one_line(tmp_path):
    model = ['-p', f'model:={config_path("arm6.urdf")}']
    said = {(): "payload: model: '', expected the MJCF or URDF file of the robot",
            (*model, '-p', 'reference:=no.knowledge'): 'no.knowledge: ',
            (*model, '-p', 'link:=flang'): "link: did you mean 'flange'?",
            (*model, '-p', "recorded:=['joint1']"):
                "payload: recorded: 'joint1', expected NAME=LOGNAME"}
    runs = refusals('payload_node', [list(words) for words in said], tmp_path)
    for (code, lines), words in zip(runs, said.values()):
        assert code == 2 and len(lines) == 1 and words in lines[0], lines
