# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Node `payload`: what a robot holds, and the external torque on its joints, ten times a second.

Takes positions and torques of all joints from joint_states and publishes, 0.35 s later with the
stamp of the measurement: payload (mass and centre in the frame of the link that carries) and
external_torque (N m, positive where it helps the motor), each with a topic of deviations,
..._stddev. diagnosis.robot.payload does all the work. Call ~/tare while the robot holds nothing.

  ros2 run gearbox_monitor payload_node --ros-args -p model:=robot.urdf -p reference:=r.knowledge
"""
from array import array
from collections.abc import Sequence
import math
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import InertiaStamped
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from gearbox_monitor.diagnosis.robot.payload import PayloadEstimate, PayloadTracker, SECOND
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.knowledge_file import load_knowledge
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.library.robot import load_robot, payload_tracker, recorded_names
from gearbox_monitor.parameters import PAYLOAD_NODE, PayloadParameters
from gearbox_monitor.recordings.topics import (
    DIAGNOSTICS, EXTERNAL_TORQUE, EXTERNAL_TORQUE_STD, JOINT_STATES, PAYLOAD, PAYLOAD_STD)
from gearbox_monitor.report.robot_words import payload_words
from gearbox_monitor.ros.convert import stamp_of, to_diagnostics, to_time
from gearbox_monitor.ros.paced_node import declare, TableNode
from gearbox_monitor.ros.qos import advertise, best_effort, subscribe
from gearbox_monitor.ros.runtime import spin_node, steady_timer

DEPTH = 2000  # messages that may wait: two seconds at 1 kHz


class PayloadNode(TableNode):
    """Shell around a PayloadTracker; see the module."""

    def __init__(self, **node: Any) -> None:
        super().__init__('payload', **node)
        values = PayloadParameters.from_mapping(declare(self, PAYLOAD_NODE))
        if not values.model:
            raise InputError("payload: model: '', expected the MJCF or URDF file of the robot")
        robot = load_robot(values.model, values=values.values or None)
        knowledge = load_knowledge(values.reference, robot.file.digest) if (
            values.reference) else None
        names = recorded_names(filter(None, values.recorded), 'payload: recorded')
        self._joints = [names.get(joint, joint) for joint in robot.joints]
        self._tracker = payload_tracker(robot, values.link, knowledge, values.empty)
        warm_up(payload_tracker(robot, values.link, knowledge), len(self._joints))
        self._payload = [advertise(self, InertiaStamped, topic, 10)
                         for topic in (PAYLOAD, PAYLOAD_STD)]
        self._external = [advertise(self, JointState, topic, 10)
                          for topic in (EXTERNAL_TORQUE, EXTERNAL_TORQUE_STD)]
        self._diagnostics = advertise(self, DiagnosticArray, DIAGNOSTICS, 10)
        self._latest: PayloadEstimate | None = None
        self._first_ns = self._taken = self._incomplete = 0
        self._lacking = ''
        self._subscription = subscribe(self, JointState, JOINT_STATES, self._take,
                                       best_effort(DEPTH))
        self.create_service(Trigger, '~/tare', self._tare)
        # Wall time: missing data must be reported while a simulation's clock stands, too.
        self._timer = steady_timer(self, 1.0, self._report)
        self.warn_of_unknown()
        self.get_logger().info(
            f'{values.model}: {len(self._joints)} joints, {self._tracker.link} carries, '
            + (f'reference {values.reference}' if values.reference else
               'no reference: the deviations are those of the tolerances of the model'))

    def _take(self, message: JointState) -> None:
        """Take a message with all joints; count others."""
        where = {name: i for i, name in enumerate(message.name)}
        at = [where.get(joint, -1) for joint in self._joints]
        count = min(len(message.position), len(message.effort))
        lacking = [joint for joint, i in zip(self._joints, at) if not 0 <= i < count]
        if lacking:
            self._incomplete += 1
            self._lacking = ', '.join(lacking)
            return
        self._taken += 1
        stamp = stamp_of(message)
        self._first_ns = self._first_ns or stamp
        for estimate in self._tracker.take(stamp, [message.position[i] for i in at],
                                           [message.effort[i] for i in at]):
            self._publish(estimate)

    def _publish(self, estimate: PayloadEstimate) -> None:
        self._latest = estimate
        stamp = to_time(estimate.stamp_ns)
        for publisher, mass, centre in zip(
                self._payload, (estimate.mass, estimate.mass_std),
                (estimate.centre, estimate.centre_std)):
            held = InertiaStamped()
            held.header.stamp, held.header.frame_id = stamp, self._tracker.link
            held.inertia.m = mass
            held.inertia.com.x, held.inertia.com.y, held.inertia.com.z = centre.tolist()
            publisher.publish(held)
        for publisher, torque in zip(self._external, (estimate.external, estimate.external_std)):
            publisher.publish(self._joint_state(stamp, torque))

    def _joint_state(self, stamp: Any, torque: Array) -> JointState:
        message = JointState(name=self._joints, effort=array('d', torque.tolist()))
        message.header.stamp = stamp
        return message

    def _tare(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._tracker.tare()
        response.success, response.message = True, f'nothing is held at {self._tracker.link} now'
        return response

    def _report(self) -> None:
        """Publish a status: what is held, or why nothing is known."""
        level, e = DiagnosticStatus.OK, self._latest
        if not self._taken:
            level = DiagnosticStatus.WARN
            message = (f'joint_states without position and effort of {self._lacking}'
                       if self._incomplete else 'no joint_states')
        elif e is None:
            message = 'waiting for 3 s of motion'
        else:
            since = (e.since_ns - self._first_ns) / SECOND if e.since_ns else math.nan
            message = payload_words(e.mass, e.mass_std, e.centre, self._tracker.link, since)
        status = DiagnosticStatus(
            level=level, name=f'{self.get_name()}: payload', hardware_id=self._tracker.link,
            message=message, values=[
                KeyValue(key='samples', value=str(self._taken)),
                KeyValue(key='samples_without_all_joints', value=str(self._incomplete))])
        if e is not None:
            status.values += [KeyValue(key='payload_kg', value=f'{e.mass:.6g}'),
                              KeyValue(key='payload_std_kg', value=f'{e.mass_std:.6g}')]
        self._taken = self._incomplete = 0
        self._diagnostics.publish(to_diagnostics([status], self.get_clock().now().to_msg()))


def warm_up(tracker: PayloadTracker, joints: int) -> None:
    """Load what the first windows of `tracker`, of so many `joints`, need: no sample waits."""
    for k in range(300):  # 3 s: the first estimate
        angle = 0.5 * math.sin(0.02 * k)
        tracker.take(SECOND + k * SECOND // 100, [angle] * joints, [angle] * joints)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node with the command line `args`; return the exit code."""
    return spin_node(PayloadNode, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
