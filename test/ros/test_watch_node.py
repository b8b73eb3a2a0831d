# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The node that watches a robot: live is offline, to the bit, also after a restart."""
from array import array
import json

from arm_at_work import Arm, messages, NAMES, urdf, watched
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402, I100, I202
from geometry_msgs.msg import InertiaStamped  # noqa: E402
from harness import RELIABLE  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.files.watch_file import load_watch, watch_bytes  # noqa: E402
from gearbox_monitor.report.watch_words import watch_data  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402
from gearbox_monitor.watch.fold import begin, tare  # noqa: E402

pytestmark = pytest.mark.ros
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DEEP = QoSProfile(depth=20_000)


def test_live_is_offline_and_goes_on_after_a_restart(graph, tmp_path):
    """It learns from nine blocks, is stopped within the eleventh, and taken up again."""
    arm, state = Arm(), tmp_path / 'arm.state'
    stream = messages(arm, 11)[::2]
    arm.load = 1.5
    more = messages(arm, 3)[::2]
    node, findings, masses, statuses = graph.node, [], [], []
    node.create_subscription(String, '/watch/findings', findings.append, LATCHED)
    node.create_subscription(InertiaStamped, 'payload', masses.append, DEEP)
    node.create_subscription(DiagnosticArray, '/diagnostics', statuses.append, DEEP)
    states = node.create_publisher(JointState, 'joint_states', DEEP)

    def told():
        return {s.name: s for message in statuses[-1:] for s in message.status}

    def samples():
        values = told()['watch: robot'].values if told() else ()
        return int({v.key: v.value for v in values}.get('samples', -1))

    def feed(part):
        for k, (stamp, q, v, effort) in enumerate(part):
            message = JointState(name=NAMES)
            message.header.stamp = to_time(stamp)
            message.position, message.velocity, message.effort = (
                array('d', x) for x in (q, v, effort))
            states.publish(message)
            if k % 50 == 0:
                graph.spin(0.01)

    process = graph.start('watch_node', state_file=state, **RELIABLE)
    graph.until(lambda: states.get_subscription_count(), 'the node')
    graph.until(lambda: told() and told()['watch: robot'].message == 'no robot_description',
                'the warning')
    assert not graph.call(Trigger, '/watch/tare', Trigger.Request()).success
    description = node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf()))
    graph.until(lambda: 'watch: joint1' in told(), 'the description')
    feed(stream)
    graph.until(lambda: findings and json.loads(findings[-1].data)['phase'] == 'watch',
                'what it learns')
    graph.until(lambda: masses, 'a load')
    assert told()['watch: joint1'].level == DiagnosticStatus.STALE    # not known is not OK
    graph.stop(process)
    offline, _ = watched(begin(urdf()), stream)
    assert state.read_bytes() == watch_bytes(offline)

    graph.until(lambda: not states.get_subscription_count(), 'the end of the node')
    masses.clear()
    process = graph.start('watch_node', state_file=state, **RELIABLE)
    graph.until(lambda: states.get_subscription_count(), 'the node')
    graph.until(lambda: samples() == 0 and 'watch: joint1' in told(), 'the description')
    feed(more)
    graph.until(lambda: len(masses) == 2 and samples() == len(more), 'all samples')
    assert abs(masses[-1].inertia.m - arm.load) < 0.2 and masses[-1].header.frame_id == 'link3'
    graph.stop(process)
    offline, _ = watched(offline, more)
    assert state.read_bytes() == watch_bytes(offline)

    process = graph.start('watch_node', state_file=state, **RELIABLE)
    findings.clear()
    graph.until(lambda: findings, 'the findings')
    assert graph.call(Trigger, '/watch/tare', Trigger.Request()).success
    expected = json.loads(json.dumps(watch_data(tare(offline))))
    graph.until(lambda: json.loads(findings[-1].data) == expected, 'the answer')
    graph.stop(process)
    assert watch_bytes(load_watch(state)) == watch_bytes(tare(offline))
