# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Between ROS messages and the core's samples and estimates, in one place."""
from array import array
import math

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from gearbox_monitor.estimation.estimates import Sample
from gearbox_monitor.interfaces.diagnostic_keys import published
from gearbox_monitor.interfaces.signals import joint_values

NAN = math.nan
LEVELS = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR)


def to_time(stamp_ns):
    """Return `stamp_ns` (int ns) as builtin_interfaces/Time."""
    return Time(sec=stamp_ns // 1_000_000_000, nanosec=stamp_ns % 1_000_000_000)


def _at(values, index):
    return values[index] if 0 <= index < len(values) else NAN


def stamp_of(message):
    """Return the stamp of a message (int ns)."""
    stamp = message.header.stamp
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def joint_values_of(message, joint):
    """Return (position, effort) of `joint` in a JointState, None where it does not name it."""
    if joint not in message.name:
        return None
    index = message.name.index(joint)
    return _at(message.position, index), _at(message.effort, index)


def to_paired(stamp_ns, joints, motor, arm):
    """Return the JointState of (position, effort) of `motor` and of `arm`, None = not measured."""
    position, effort = zip(motor, arm or (NAN, NAN))
    return JointState(header=Header(stamp=to_time(stamp_ns)), name=list(joints),
                      position=array('d', position), effort=array('d', effort))


class SampleReader:
    """
    Turn joint states into samples: finds the joints by name and refers all to the arm side.

    Joints may stand in any order among others. With gear ratio N and torque constant kt of the
    DriveModel `model`, x1 = motor angle / N and u = N kt motor effort.
    """

    def __init__(self, motor_joint, arm_joint, model):
        self.motor_joint, self.arm_joint = motor_joint, arm_joint
        self._gear_ratio, self._effort_scale = model.gear_ratio, model.effort_scale
        self._names, self._motor, self._arm = None, -1, -1

    def sample(self, message):
        """Return the Sample of a JointState, or None where it names neither joint."""
        if message.name != self._names:
            self._names = list(message.name)
            self._motor, self._arm = (
                self._names.index(joint) if joint in self._names else -1
                for joint in (self.motor_joint, self.arm_joint))
        motor, arm = self._motor, self._arm
        if motor < 0 and arm < 0:
            return None
        return Sample(
            stamp_of(message),
            (_at(message.effort, motor) * self._effort_scale, _at(message.effort, arm)),
            (_at(message.position, motor) / self._gear_ratio, _at(message.position, arm)))

    def raw(self, message):
        """Return position of motor and arm, effort of motor and arm as sample() found them."""
        motor, arm = self._motor, self._arm
        return (_at(message.position, motor), _at(message.position, arm),
                _at(message.effort, motor), _at(message.effort, arm))


def to_joint_state(signal, stamp_ns, row, names, gear_ratio):
    """Return the JointState of `signal` (signals.Signal); arguments as of joint_values."""
    joints, position, velocity, effort = joint_values(signal, row, names, gear_ratio)
    message = JointState()
    message.header.stamp = to_time(stamp_ns)
    message.name = joints
    message.position = array('d', position)
    message.velocity = array('d', velocity)
    message.effort = array('d', effort)
    return message


def key_values(component, values):
    """Return the KeyValues of `component` on /diagnostics for `values` {key: value}."""
    return [KeyValue(key=key, value=text) for key, text in published(component, values)]


def to_status(name, finding, hardware_id):
    """Return the DiagnosticStatus of a trust.level.Finding."""
    return DiagnosticStatus(
        level=LEVELS[finding.level], name=name, message=finding.message, hardware_id=hardware_id,
        values=key_values(name.rpartition(': ')[2], finding.values))


def to_diagnostics(statuses, stamp):
    """Return the DiagnosticArray of DiagnosticStatus messages, stamped `stamp` (Time)."""
    message = DiagnosticArray(status=list(statuses))
    message.header.stamp = stamp
    return message


def to_snapshot(name, hardware_id, snapshot, stamp_ns):
    """Return the DiagnosticArray that carries `snapshot` {name: text} (Monitor.snapshot)."""
    status = DiagnosticStatus(
        level=DiagnosticStatus.OK, name=f'{name}: snapshot', hardware_id=hardware_id,
        message='what replay starts from',
        values=[KeyValue(key=key, value=value) for key, value in snapshot.items()])
    return to_diagnostics([status], to_time(stamp_ns))
