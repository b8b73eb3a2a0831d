# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The description of a robot for a node: from a file, or from the topic that latches it."""
import time

from rclpy.node import Node
from std_msgs.msg import String

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.robot_files import load_robot, TOPIC
from gearbox_monitor.robot.description import parse, RobotDescription
from gearbox_monitor.ros.qos import latched
from gearbox_monitor.ros.runtime import drain, subscribe_polled

PATIENCE = 15.0  # s until a latched description must have come


def robot_of(node: Node, source: str) -> RobotDescription:
    """
    Return the robot of the parameter robot_description of a `node`.

    source: its value, a file or topic:TOPIC. Waits for the topic. Raises InputError if it is no
    URDF, or does not come.
    """
    if not source.startswith(TOPIC):
        return load_robot(source)
    subscription = subscribe_polled(node, String, source.removeprefix(TOPIC), latched())
    topic = subscription.topic_name
    node.get_logger().info(f'waiting for the robot description on {topic}')
    try:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and node.context.ok():
            for message, _ in drain(subscription):
                return parse(message.data, topic)
            time.sleep(0.05)
    finally:
        node.destroy_subscription(subscription)
    raise InputError(f'robot_description: {topic}: nothing came in {PATIENCE:g} s, expected a '
                     'robot description, as robot_state_publisher gives it')
