# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Strangers on joint_states: named and counted, they move no estimate and stop none."""
from array import array
import math
import time

import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100, I202
from harness import Graph, RELIABLE  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from rclpy.serialization import serialize_message  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from gearbox_monitor.estimation.estimates import Samples  # noqa: E402
from gearbox_monitor.monitoring.monitor import Monitor  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.plant.excitation import Excitation  # noqa: E402
from gearbox_monitor.plant.simulate import Noise, simulate  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402

pytestmark = pytest.mark.ros
T0 = 1_700_000_000_000_000_000
DT = 2_000_000  # 500 Hz
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
    t = np.arange(40 * N) * DT * 1e-9
    return simulate(DriveModel(), Excitation().torque(t), DT * 1e-9,
                    Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), seed=3)


class Source:
    """A publisher of joint_states in a node of its own."""

    def __init__(self, graph, name, drive, subscribers=1):
        self.graph, self.drive = graph, drive
        self.node = rclpy.create_node(name, context=graph.context)
        self.publisher = self.node.create_publisher(JointState, 'joint_states', DEEP)
        self.sent = 0
        graph.sources.append(self)
        graph.until(lambda: self.publisher.get_subscription_count() >= subscribers, 'matching')

    def message(self, k, offset=0.0, late=0):
        message = JointState(name=['motor', 'arm'])
        message.header.stamp = to_time(T0 + k * DT + late)
        message.position = array('d', self.drive.y[k] + offset)
        message.effort = array('d', [self.drive.u[k], math.nan])
        return message

    def send(self, message):
        self.publisher.publish(message)
        self.sent += 1


class Told:
    """The newest diagnostics of the estimator's input."""

    def __init__(self, graph):
        self.level, self.message, self.values, self.all = None, '', {}, []
        graph.node.create_subscription(DiagnosticArray, '/diagnostics', self._on, 10)

    def _on(self, message):
        for status in message.status:
            if status.name == 'estimator: input':
                self.level, self.message = status.level[0], status.message
                self.values = {v.key: v.value for v in status.values}
                self.all.append((self.level, self.message))


def test_strangers_do_not_move_the_estimate(graph, drive, tmp_path):
    """Forged stamps and positions, foreign joints, huge arrays, no joint states at all."""
    estimator = graph.start('estimator_node', arm_load='none', **RELIABLE)
    got = {}

    def take(message):
        got[message.header.stamp.sec * 10 ** 9 + message.header.stamp.nanosec] = message.effort[0]

    graph.node.create_subscription(JointState, 'transmission_state', take, DEEP)
    told = Told(graph)
    # Matched in the order of their creation: no estimate is published before anyone listens.
    graph.until(lambda: told.all, 'diagnostics')
    driver = Source(graph, 'driver', drive)
    others = stranger = None
    huge = JointState(name=['motor', 'arm'], position=array('d', bytes(8 * 60_000)))
    crowd = JointState(name=[f'joint_{k}' for k in range(5000)])
    rubbish = [bytes(serialize_message(huge)), bytes(serialize_message(crowd)),
               b'\x00\x01\x00\x00' + 20 * b'\xff']
    sent = 0
    for k in range(N):
        driver.send(driver.message(k))
        if k in (1000, 1700):  # the estimator has looked round since those before came
            looks = len(told.all)
            graph.until(lambda: len(told.all) > looks + 1, 'diagnostics')
            name = 'other_joints' if k == 1000 else 'stranger'
            source = Source(graph, name, drive, subscribers=0)
            graph.until(lambda: source.publisher.get_subscription_count(), 'matching')
            others, stranger = (source, None) if k == 1000 else (others, source)
        if k > 1000 and k % 10 == 0:
            others.send(JointState(name=['wrist', 'elbow'], position=array('d', [1.0, 2.0])))
        if k >= 2000:
            # Between two good samples, a little beside: nothing else would refuse it.
            stranger.send(stranger.message(k, 0.01, DT // 2))
            sent += 1
            if k % 250 == 0:
                for raw in rubbish:
                    others.publisher.publish(raw)
        if k % 10 == 9:
            graph.spin(0.02)
            # No queue runs over, whatever else the machine does.
            graph.until(lambda: len(got) > driver.sent - 300, 'estimates')
    graph.until(lambda: len(got) >= N - 1, 'the last estimate')
    graph.until(lambda: told.values.get('messages_of_other_publishers') == str(sent), 'the count')
    assert any(level == 1 and 'are refused: ' in text and '/stranger' in text
               for level, text in told.all), told.all
    samples = Samples(T0 + DT * np.arange(N, dtype=np.int64),
                      np.column_stack([drive.u[:N], np.full(N, np.nan)]), drive.y[:N])
    expected = Monitor(DriveModel(), {'arm_load': 'none'}).run(samples)
    assert got == dict(zip(expected.stamp_ns.tolist(), expected.tau_k.tolist()))
    errors = graph.stop(estimator)
    line = next(line for line in errors.splitlines() if 'another node publishes' in line)
    assert 'its messages are refused: ' in line and '/stranger' in line and '/driver' not in line
    assert int(told.values['messages_unreadable']) == 2 * 8


def test_where_nobody_was_first_nothing_is_taken(graph, drive):
    """Until one is left; a stranger that stays after the first has gone waits for ~/reset."""
    graph.start('estimator_node', arm_load='none', **RELIABLE)
    got = []
    graph.node.create_subscription(JointState, 'transmission_state', got.append, DEEP)
    told = Told(graph)
    one, two = Source(graph, 'one', drive), Source(graph, 'two', drive)
    k = 0

    def both(*sources, seconds=0.0, until=None):
        nonlocal k
        end, due = time.monotonic() + seconds, time.monotonic()
        while time.monotonic() < end or until is not None and not until():
            for source in sources:
                source.send(source.message(k))
            k, due = k + 1, max(due + DT * 1e-9, time.monotonic() - 0.1)
            while time.monotonic() < due:
                graph.executor.spin_once(timeout_sec=0.001)
            assert k < 40 * N, (told.level, told.message, told.values)

    both(one, two, until=lambda: told.level == 2 and 'none was the first: /one, /two'
         in told.message)
    refused_from = to_time(T0 + k * DT)
    both(one, two, seconds=0.5)
    assert all((m.header.stamp.sec, m.header.stamp.nanosec)
               < (refused_from.sec, refused_from.nanosec) for m in got)
    count = len(got)
    both(one, until=lambda: len(got) > count + 100)
    both(one, seconds=3.5)  # alone so long, it is the first
    both(one, two, until=lambda: int(told.values.get('messages_of_other_publishers', 0)) > 100
         and told.level == 1 and 'refused: /one, /two' in told.message)
    both(two, until=lambda: told.level == 2 and 'the publisher that was followed is silent'
         in told.message)
    count = len(got)
    assert graph.call(Trigger, 'estimator/reset', Trigger.Request()).success
    both(two, until=lambda: len(got) > count + 100)
