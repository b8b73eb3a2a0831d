# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Other publishers on joint_states: of other joints they are welcome, of ours an ERROR."""
from array import array
import math

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from drives import driven  # noqa: E402
from harness import Graph, RELIABLE  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from rclpy.serialization import serialize_message  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from gearbox_monitor.estimation.estimates import Samples  # noqa: E402
from gearbox_monitor.health.monitor import Monitor  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.ros.convert import stamp_of, to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 4_000_000  # 250 Hz
N = 4000
DEEP = QoSProfile(depth=10000)


@pytest.fixture
def graph(tmp_path, monkeypatch):
    graph = Graph(tmp_path, monkeypatch)
    graph.sources = []
    yield graph
    for source in graph.sources:
        source.node.destroy_node()
    graph.close()


@pytest.fixture(scope='module')
def drive():
    return driven(DriveModel(), N * DT * 1e-9, dt=DT * 1e-9)


class Source:
    """A publisher of joint_states in a node of its own."""

    def __init__(self, graph, name, drive):
        self.graph, self.drive = graph, drive
        self.node = rclpy.create_node(name, context=graph.context)
        self.publisher = self.node.create_publisher(JointState, 'joint_states', DEEP)
        graph.sources.append(self)
        graph.until(self.publisher.get_subscription_count, 'matching')

    def send(self, k):
        message = JointState(name=['motor', 'arm'])
        message.header.stamp = to_time(T0 + k * DT)
        message.position = array('d', self.drive.y[k])
        message.effort = array('d', [self.drive.u[k], math.nan])
        self.publisher.publish(message)

    def end(self):
        self.graph.sources.remove(self)
        self.node.destroy_node()


class Input:
    """The diagnostics of the estimator's input."""

    def __init__(self, graph):
        self.all, self.values = [], {}
        graph.node.create_subscription(DiagnosticArray, '/diagnostics', self._on, 10)

    def _on(self, message):
        for status in message.status:
            if status.name == 'estimator: input':
                self.values = {v.key: v.value for v in status.values}
                self.all.append((status.level[0], status.message))


def test_other_joints_are_welcome_and_a_second_publisher_stops_all(graph, drive):
    """Broadcasters of other joints, rubbish, silent endpoints and a restart: no ERROR."""
    estimator = graph.start('estimator_node', arm_load='none', **RELIABLE)
    got = {}

    def take(message):
        got[stamp_of(message)] = message.effort[0]

    graph.node.create_subscription(JointState, 'transmission_state', take, DEEP)
    told = Input(graph)
    # Matched in the order of their creation: no estimate is published before anyone listens.
    graph.until(lambda: told.all, 'diagnostics')
    driver, gripper = Source(graph, 'driver', drive), Source(graph, 'gripper', drive)
    silent = Source(graph, 'silent', drive)
    k = 0

    def move(count, *sources):
        """Publish `count` samples of each source, as the estimates come."""
        nonlocal k
        for _ in range(count):
            for source in sources:
                source.send(k)
            if k % 10 == 0:
                gripper.publisher.publish(JointState(
                    name=['finger', 'thumb'], position=array('d', [1.0, 2.0])))
            k += 1
            graph.spin(0.02 if k % 5 == 0 else 0.0)

    move(500, driver)
    huge = JointState(name=['motor', 'arm'], position=array('d', bytes(8 * 60_000)))
    crowd = JointState(name=[f'joint_{k}' for k in range(5000)])
    for raw in (bytes(serialize_message(huge)), bytes(serialize_message(crowd)),
                b'\x00\x01\x00\x00' + 20 * b'\xff'):
        gripper.publisher.publish(raw)
    move(500, driver)
    graph.until(lambda: len(got) >= 999, 'the last estimate')
    graph.until(lambda: told.values.get('messages_unreadable') == '2', 'the count')
    samples = Samples(T0 + DT * np.arange(1000, dtype=np.int64),
                      np.column_stack([drive.u[:1000], np.full(1000, np.nan)]), drive.y[:1000])
    expected = Monitor(DriveModel(), {'arm_load': 'none'}).run(samples)
    assert got == dict(zip(expected.stamp_ns.tolist(), expected.tau_k.tolist()))

    restarted = Source(graph, 'driver_2', drive)  # the endpoint of the first one stays a while
    move(750, restarted)
    graph.until(lambda: T0 + (k - 1) * DT in got, 'its estimates')
    good = [level for level, _ in told.all].index(0)
    assert all(level < 2 for level, _ in told.all[good:]), told.all
    silent.end()
    driver.end()
    rival, begin = Source(graph, 'rival', drive), k
    move(500, restarted, rival)
    level, text = told.all[-1]
    assert level == 2 and text.startswith(
        "two publishers of 'motor' and 'arm' on /joint_states: two of /driver_2, /gripper, "
        '/rival: stop one of them'), told.all
    # The estimator may match the rival a moment after the rival matches it.
    taken = sum(stamp >= T0 + begin * DT for stamp in got)
    assert taken < 250 and T0 + (begin + taken + 2) * DT > max(got), taken
    graph.until(lambda: int(told.values['messages_of_two_publishers']) > 900, 'the count')
    rival.end()
    while told.all[-1][0] == 2 and k < N - 50:
        move(50, restarted)
    graph.until(lambda: T0 + (k - 1) * DT in got, 'estimates again')
    graph.until(lambda: told.all[-1][0] < 2, 'the end of the ERROR')
    errors = graph.stop(estimator)
    assert errors.count('input: ERROR: two publishers of') == 1
