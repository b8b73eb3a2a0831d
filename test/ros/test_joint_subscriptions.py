# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Messages of the joints: one wake-up of the executor takes those that follow, too."""
import threading
import time

import pytest

rclpy = pytest.importorskip('rclpy')
from processes import DOMAIN  # noqa: E402, I100, I202
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from gearbox_monitor.parameters import EstimatorParameters  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.ros import gearbox_input  # noqa: E402
from gearbox_monitor.ros.convert import to_time  # noqa: E402
from gearbox_monitor.ros.gearbox_input import GearboxInput  # noqa: E402
from gearbox_monitor.ros.runtime import alone, Arrivals  # noqa: E402

pytestmark = pytest.mark.ros


@pytest.fixture
def nodes(monkeypatch):
    """Return (node that subscribes, node that publishes), in a context of their own."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    both = [rclpy.create_node(name, context=context) for name in ('taker', 'giver')]
    yield both
    for node in both:
        node.destroy_node()
    rclpy.shutdown(context=context)


@pytest.mark.parametrize('others', [False, True])
def test_a_callback_awaits_the_next_messages_unless_another_node_waits(
        nodes, monkeypatch, others):
    taker, giver = nodes
    taken, waits, stop = [], [], threading.Event()

    def take(samples):
        taken.extend(samples)
        if len(taken) > 1:
            monkeypatch.setattr(gearbox_input, 'STAY', 0.0)

    class CountingArrivals(Arrivals):
        def wait(self, seconds):
            waits.append(seconds)
            return super().wait(seconds)

    monkeypatch.setattr(gearbox_input, 'STAY', 60.0)
    monkeypatch.setattr(gearbox_input, 'Arrivals', CountingArrivals)
    source = GearboxInput(taker, EstimatorParameters(), DriveModel(), lambda: None)
    gearbox_input.JointSubscriptions(taker, [source], take)
    publisher = giver.create_publisher(JointState, 'joint_states', 10)
    executor = SingleThreadedExecutor(context=taker.context)
    executor.add_node(taker)
    if others:
        executor.add_node(giver)

    def publish():
        message = JointState(name=['motor', 'arm'], position=[0.0, 0.0], effort=[0.0, 0.0])
        while not stop.wait(0.1):
            message.header.stamp = to_time(time.time_ns())
            publisher.publish(message)

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        while not taken:
            executor.spin_once(timeout_sec=60.0)
    finally:
        stop.set()
        thread.join()
        executor.shutdown()
    assert waits == [] if others else waits and len(taken) > 1


def test_a_node_is_alone_with_one_thread_and_no_other_node(nodes):
    taker, giver = nodes
    assert not alone(taker)
    for executor in (SingleThreadedExecutor(context=taker.context),
                     MultiThreadedExecutor(context=taker.context)):
        executor.add_node(taker)
        assert alone(taker) == isinstance(executor, SingleThreadedExecutor)
        executor.add_node(giver)
        assert not alone(taker)
        executor.remove_node(taker)
        executor.remove_node(giver)
        executor.shutdown()
