# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Another subscriber beside the recorder: what came, and when. For benchmarks of the recorder."""
import struct

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

from gearbox_monitor.ros.runtime import drain, PolledCallbackGroup

DEPTH = 8000  # messages that may wait, 8 s at 1 kHz
STAMP = struct.Struct('<iI')  # behind four bytes of encapsulation


class Witness:
    """
    Node in a context of its own that notes the JointStates on `topics` (absolute names).

    seen: {topic: [(time of reception ns, stamp ns)]}, as poll() has found them.
    """

    def __init__(self, topics, domain):
        self.seen = {topic: [] for topic in topics}
        self._context = rclpy.Context()
        rclpy.init(args=['--ros-args', '--disable-external-lib-logs'], context=self._context,
                   domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node('witness', context=self._context, enable_rosout=False,
                          start_parameter_services=False)
        group = PolledCallbackGroup()
        self._subscriptions = {topic: self._node.create_subscription(
            JointState, topic, lambda message: None, DEPTH, callback_group=group, raw=True)
            for topic in topics}

    def poll(self):
        """Note what has come."""
        for topic, subscription in self._subscriptions.items():
            self.seen[topic] += [(info['received_timestamp'], stamp_ns(raw))
                                 for raw, info in drain(subscription)]

    def close(self):
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def stamp_ns(raw):
    """Return the stamp in the header of a serialised message, ns."""
    seconds, nanoseconds = STAMP.unpack_from(raw, 4)
    return seconds * 1_000_000_000 + nanoseconds
