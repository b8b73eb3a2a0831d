# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The node that watches a robot: live is offline, to the bit, also after a restart."""
from array import array
from dataclasses import replace
import http.client
import json
import time

from arm_at_work import Arm, messages, NAMES, urdf, watched
import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402, I100, I202
from geometry_msgs.msg import InertiaStamped  # noqa: E402
from harness import RELIABLE  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from test_live import live  # noqa: E402

from gearbox_monitor.files.knowledge_file import load_watch, save_watch, watch_bytes  # noqa: E402
from gearbox_monitor.health.alarms import Level  # noqa: E402
from gearbox_monitor.report.watch_page import watch_part  # noqa: E402
from gearbox_monitor.report.watch_words import watch_data  # noqa: E402
from gearbox_monitor.robot.arm_plant import WorkingArm  # noqa: E402
from gearbox_monitor.robot.description import parse  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402
from gearbox_monitor.watch.features import groups_of, state_levels  # noqa: E402
from gearbox_monitor.watch.fold import begin, learn_again, robot_of, save_baseline, tare  # noqa: E402
from gearbox_monitor.watch.record import (  # noqa: E402
    Change, FRICTION, Held, HeldLoad, ROTOR, SECOND, StateHealth, WATCH)

pytestmark = pytest.mark.ros
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DEEP = QoSProfile(depth=20_000)


def test_live_is_offline_and_goes_on_after_a_restart(graph, tmp_path):
    """It has learnt, weighs a load, is stopped within the next block, and taken up again."""
    arm, state = Arm(), tmp_path / 'arm.state'
    taught, _ = watched(begin(urdf()), messages(arm, 9)[::2])
    save_watch(state, taught)
    arm.load = 1.5
    stream, more = messages(arm, 3)[::2], messages(arm, 2)[::2]
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
    graph.until(lambda: masses and samples() == len(stream), 'a load')
    assert json.loads(findings[-1].data)['phase'] == 'watch'
    assert told()['watch: joint1'].level == DiagnosticStatus.STALE    # not known is not OK
    graph.stop(process)
    offline, _ = watched(taught, stream)
    assert state.read_bytes() == watch_bytes(offline)

    graph.until(lambda: not states.get_subscription_count(), 'the end of the node')
    masses.clear()
    process = graph.start('watch_node', state_file=state, **RELIABLE)
    graph.until(lambda: states.get_subscription_count(), 'the node')
    graph.until(lambda: samples() == 0 and 'watch: joint1' in told(), 'the description')
    feed(more)
    graph.until(lambda: len(masses) > 1 and samples() == len(more), 'all samples')
    assert abs(masses[-1].inertia.m - arm.load) < 0.2 and masses[-1].header.frame_id == 'link3'
    graph.stop(process)
    offline, _ = watched(offline, more)
    assert state.read_bytes() == watch_bytes(offline)


def test_services_change_what_is_known_and_the_page_shows_it(graph, tmp_path):
    """A friction that was found, and a load; nothing moves, so what the page shows is old."""
    state, findings, statuses = tmp_path / 'arm.state', [], []
    since = 1_700_000_000 * SECOND
    robot, _ = robot_of(urdf(), ())
    known = begin(urdf())
    held = Held('link3', np.array([1.5, 0.0, 0.0, 0.3, *np.zeros(6)]), 1e-4 * np.eye(10), since)
    known = replace(
        known, phase=WATCH, stamp_ns=since, states=state_levels(
            robot, groups_of(robot), np.ones(3)), held=(held,), empty=(replace(
                held, values=np.zeros(10)),), payloads=(HeldLoad(
                    'link3', 1.5, 0.1, (0.0, 0.0, 0.2), (0.1, 0.1, 0.1), since),),
        changes=(Change(FRICTION, 'joint2', 0.3, 0.02, since, since),),
        joints=tuple(replace(j, level=Level.OK, states=(
            StateHealth(FRICTION, 0.0, 0.01, True), StateHealth(ROTOR, 0.0, 0.1)))
            for j in known.joints))
    save_watch(state, known)
    graph.node.create_subscription(String, '/watch/findings', findings.append, LATCHED)
    graph.node.create_subscription(DiagnosticArray, '/diagnostics', statuses.append, DEEP)
    process = graph.start('watch_node', state_file=state)
    page = live('--port', '0')
    graph.processes.append(page)
    connection = http.client.HTTPConnection(page.stdout.readline().split('/')[2], timeout=60)
    connection.request('GET', '/events')
    events = connection.getresponse()
    description = graph.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf()))

    shown = part = ''
    for service in (None, tare, save_baseline, learn_again):
        if service:
            name = f'/watch/{service.__name__}'
            assert f'<code>{name}</code>' in part
            assert graph.call(Trigger, name, Trigger.Request()).success
            known = service(known)
        expected = json.loads(json.dumps(watch_data(known)))
        graph.until(lambda: findings and json.loads(findings[-1].data) == expected, 'the answer')
        part = watch_part(expected, urdf(), '/watch', 'no joint_states')
        end = time.monotonic() + 240.0
        while shown != part:
            assert time.monotonic() < end, shown
            if (line := events.readline()).startswith(b'data: '):
                shown = json.loads(line[6:]).get('watch', shown)
    graph.stop(process)
    assert watch_bytes(load_watch(state)) == watch_bytes(known)
    assert known.phase == 'describe' and not known.changes
    told = {(s.name, s.message) for message in statuses for s in message.status}
    assert ('watch: joint1', 'as learnt; not known yet: rotor') in told
    assert not any(     # what is old is not OK
        s.level == DiagnosticStatus.OK for message in statuses for s in message.status)


def test_the_arm_of_the_tutorial_is_as_most_robots_and_changes_while_it_works(graph):
    """Joints of its description with their efforts, those of the plant until it takes a load."""
    described, states = [], []
    graph.node.create_subscription(String, 'robot_description', described.append, LATCHED)
    graph.node.create_subscription(JointState, 'joint_states', states.append, DEEP)
    process = graph.start('arm_plant_node', encoders='arm', rate=100.0, wait_for_subscribers=1)
    graph.until(lambda: described and len(states) > 50, 'its motion')
    for parameter in ('payload', 'rubbing'):
        result, = graph.set('/arm_plant', **{parameter: 5.0})
        assert result.successful, result.reason
    changed = len(states)
    graph.until(lambda: len(states) > changed + 200, 'its motion')
    graph.stop(process)
    robot = parse(described[0].data, 'arm')
    assert all(list(state.name) == list(robot.joints) for state in states)
    effort = np.array([state.effort for state in states])
    healthy = WorkingArm(robot, 0.01, 1).run(len(states)).true.u
    same = (effort == healthy).all(axis=1)
    begun = int(np.argmin(same))
    assert 50 < begun and same[:begun].all() and not same[begun + 1:].any()
    assert np.abs(effort - healthy)[-100:, 1].max() > 5.0
