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

"""Where the samples come from: joint_states, or motor and arm joined from two topics."""
from itertools import zip_longest

from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.joiner import Joiner
from gearbox_monitor.nodes.convert import joint_values_of, SampleReader, stamp_of, to_paired
from gearbox_monitor.nodes.lost import Lost
from gearbox_monitor.nodes.qos import advertise, best_effort, subscribe
from gearbox_monitor.nodes.runtime import drain
from gearbox_monitor.signals import JOINT_STATES, PAIRED_JOINT_STATES

SECOND = 1_000_000_000
# Two seconds at 1 kHz: a pause of this process must not cost samples.
DEPTH = 2000
MOST_TOLD = 16  # different arrangements of joints that are told


class Inputs:
    """
    Subscribes for `node` and hands every sample to take(sample, raw), see SampleReader.

    topic: where whole samples are, for a recorder. foreign: messages that name neither joint.
    """

    def __init__(self, node, parameters, gear_ratio, take):
        self._node, self._take = node, take
        self.joints = parameters['motor_joint'], parameters['arm_joint']
        self._reader = SampleReader(*self.joints, gear_ratio)
        self.foreign, self._others = 0, ()
        self._names, self._told = None, set()
        self._lost, self._lost_told = (Lost(), Lost()), 0  # of the motor's topic, of the arm's
        self.joiner = self._arm = None
        self._main = subscribe(node, JointState, JOINT_STATES, self._on_message,
                               best_effort(DEPTH))
        self.topic = self.motor_topic = self._main.topic_name
        self.arm_topic = None
        if parameters['arm_topic']:
            if not parameters['arm_joint']:
                raise InputError(f'arm_topic: {parameters["arm_topic"]!r}, expected none where '
                                 'arm_joint is empty')
            self._join(parameters)

    def _join(self, parameters):
        self._pairs = 0  # when asked last
        self.joiner = Joiner(round(parameters['pair_tolerance'] * SECOND))
        self._paired = advertise(self._node, JointState, PAIRED_JOINT_STATES, DEPTH)
        self.topic = self._paired.topic_name
        self.arm_topic = self._node.resolve_topic_name(parameters['arm_topic'])
        if self.arm_topic != self.motor_topic:
            self._arm = subscribe(self._node, JointState, parameters['arm_topic'],
                                  self._on_arm, best_effort(DEPTH))

    # ------------------------------------------------------------------ messages

    def _on_message(self, message, info):
        self._one(message, info)
        self._rest()

    def _on_arm(self, message, info):
        self._one_arm(message, info)
        self._rest()

    def _rest(self):
        """Take whatever has queued up meanwhile: waking the executor costs more than a step."""
        if self._arm is None:
            for message, info in drain(self._main, DEPTH):
                self._one(message, info)
            return
        # By turns: neither stream may run ahead of the other.
        for motor, arm in zip_longest(drain(self._main, DEPTH), drain(self._arm, DEPTH)):
            if motor is not None:
                self._one(*motor)
            if arm is not None:
                self._one_arm(*arm)

    def _one(self, message, info):
        if message.name != self._names:
            self._names = message.name
            self._look(message)
        self._lost[0].seen(info, self.joints[0] in self._names)
        if self.joiner is None:
            self._whole(message)
            return
        motor, arm = self.joints
        values = joint_values_of(message, motor)
        if values is not None:
            self._joined(self.joiner.motor(stamp_of(message), values))
        if self._arm is None and arm in message.name:
            self._of_arm(message)
        elif values is None:
            self._is_foreign(message)

    def _one_arm(self, message, info):
        self._lost[1].seen(info, self.joints[1] in message.name)
        self._of_arm(message)

    def _of_arm(self, message):
        values = joint_values_of(message, self.joints[1])
        if values is None:
            self._is_foreign(message)
        else:
            self._joined(self.joiner.arm(stamp_of(message), values))

    def _joined(self, due):
        for stamp_ns, motor, arm in due:
            message = to_paired(stamp_ns, self.joints, motor, arm)
            self._paired.publish(message)
            self._whole(message)

    def _whole(self, message):
        sample = self._reader.sample(message)
        if sample is None:
            self._is_foreign(message)
        else:
            self._take(sample, self._reader.raw(message))

    def _is_foreign(self, message):
        self.foreign += 1
        self._others = tuple(message.name)

    # ------------------------------------------------------------------ words

    def _look(self, message):
        """Log what the message lacks that an estimate needs, once per arrangement of joints."""
        motor, arm = self.joints
        names = list(message.name)
        if motor not in names and arm not in names:
            return  # others may publish here, too
        text = ''
        there = ', '.join(names)
        if motor not in names and self.joiner is None:
            text = f'no joint {motor!r} among {there}: set motor_joint'
        elif motor in names and names.index(motor) >= len(message.effort):
            text = (f'no effort of {motor!r} ({len(message.effort)} efforts for {len(names)} '
                    'joints): nothing can be estimated; let its driver give the effort')
        elif arm and arm not in names and self.joiner is None:
            text = (f'no joint {arm!r} among {there}: set arm_joint, or arm_topic where it comes '
                    'in messages of its own')
        if text and text not in self._told and len(self._told) < MOST_TOLD:
            self._told.add(text)
            self._node.get_logger().warning(f'{self.motor_topic}: {text}')

    def silence(self, taken):
        """Return (why no sample came, what to do) or None; taken: whether any ever did."""
        if self.foreign and not taken:
            motor, arm = self.joints
            return (f'{self.foreign} messages named neither {motor!r} nor {arm!r} but '
                    f'{", ".join(self._others) or "nothing"}', 'set motor_joint and arm_joint')
        if self.joiner is not None and self.joiner.unused and not taken:
            return (f'messages of the arm came on {self.arm_topic}, none of '
                    f'{self.joints[0]!r} on {self.motor_topic}', 'check motor_joint and its topic')
        return None

    def lost(self):
        """Return how many messages were lost in all, and since last asked."""
        count = sum(lost.count for lost in self._lost)
        new, self._lost_told = count - self._lost_told, count
        return count, new

    def pairing(self):
        """Return ({name: value}, text of what is wrong or '') of the pairs since last asked."""
        if self.joiner is None:
            return {}, ''
        nearest, tolerance = self.joiner.ask(), self.joiner.tolerance / SECOND
        none, self._pairs = self.joiner.pairs == self._pairs, self.joiner.pairs
        values = {'motor_without_arm': self.joiner.alone, 'arm_without_motor': self.joiner.unused,
                  'pair_tolerance_s': tolerance}
        if nearest is None:
            return values, ''
        values['nearest_unpaired_s'] = nearest / SECOND
        text = (f'stamps of motor and arm are {nearest / SECOND:.6f} s apart, pair_tolerance is '
                f'{tolerance:g} s')
        if none:
            self._node.get_logger().warning(f'{self.arm_topic}: nothing is paired: {text}',
                                            throttle_duration_sec=60.0)
        return values, text

    def clear(self):
        """Forget what waits for a partner."""
        if self.joiner is not None:
            self.joiner.clear()
