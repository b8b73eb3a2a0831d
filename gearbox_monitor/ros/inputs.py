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
import time

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.joiner import Joiner
from gearbox_monitor.interfaces.signals import JOINT_STATES, PAIRED_JOINT_STATES
from gearbox_monitor.ros.convert import joint_values_of, SampleReader, stamp_of, to_paired
from gearbox_monitor.ros.lost import Lost
from gearbox_monitor.ros.publishers import ACCEPT, Publishers
from gearbox_monitor.ros.qos import advertise, best_effort, subscribe
from gearbox_monitor.ros.runtime import drain, RMWError

SECOND = 1_000_000_000
# Two seconds at 1 kHz: a pause of this process must not cost samples.
DEPTH = 2000
MOST_TOLD = 16  # different arrangements of joints that are told; names that are listed
# Longer messages are not unpacked; this one has 3000 joints, and is unpacked in a few ms.
MOST_BYTES = 1 << 18


class Inputs:
    """
    Subscribes for `node` and hands every sample to take(sample, raw), see SampleReader.

    topic: where whole samples are, for a recorder. foreign: messages that name neither joint;
    unreadable: those too long, or no joint states at all. disputed() is called where samples were
    taken of a publisher that may have been the wrong one, see Publishers.
    """

    def __init__(self, node, parameters, model, take, disputed):
        self._node, self._take, self._disputed = node, take, disputed
        self.joints = parameters.motor_joint, parameters.arm_joint
        self._reader = SampleReader(*self.joints, model)
        self.foreign, self._others = 0, ''
        self._names, self._told = None, set()
        self.unreadable = 0
        self.publishers = [Publishers(parameters.other_publishers)]  # of the motor; of the arm
        # Endpoints on our topics while nobody else gave our joints; the only one there ever was.
        self._known, self._own = set(), set()
        self._lost, self._lost_told = (Lost(), Lost()), 0  # of the motor's topic, of the arm's
        self.joiner = self._arm = None
        self._main = subscribe(node, JointState, JOINT_STATES, self._on_message,
                               best_effort(DEPTH), raw=True)
        self.topic = self.motor_topic = self._main.topic_name
        self.arm_topic = None
        if parameters.arm_topic:
            if not parameters.arm_joint:
                raise InputError(f'arm_topic: {parameters.arm_topic!r}, expected none where '
                                 'arm_joint is empty')
            self._join(parameters)

    def _join(self, parameters):
        self._pairs = 0  # when asked last
        self.joiner = Joiner(round(parameters.pair_tolerance * SECOND))
        self.publishers.append(Publishers(parameters.other_publishers))
        self._paired = advertise(self._node, JointState, PAIRED_JOINT_STATES, DEPTH)
        self.topic = self._paired.topic_name
        self.arm_topic = self._node.resolve_topic_name(parameters.arm_topic)
        if self.arm_topic != self.motor_topic:
            self._arm = subscribe(self._node, JointState, parameters.arm_topic,
                                  self._on_arm, best_effort(DEPTH), raw=True)

    # ------------------------------------------------------------------ messages

    def _on_message(self, raw, info):
        self._one(raw, info)
        self._rest()

    def _on_arm(self, raw, info):
        self._one_arm(self._unpacked(raw), info)
        self._rest()

    def _rest(self):
        """Take whatever has queued up meanwhile: waking the executor costs more than a step."""
        if self._arm is None:
            for raw, info in drain(self._main, DEPTH):
                self._one(raw, info)
            return
        # By turns: neither stream may run ahead of the other.
        for motor, arm in zip_longest(drain(self._main, DEPTH), drain(self._arm, DEPTH)):
            if motor is not None:
                self._one(*motor)
            if arm is not None:
                self._one_arm(self._unpacked(arm[0]), arm[1])

    def _unpacked(self, raw):
        """Return the JointState of the bytes `raw`, None where they are none or too many."""
        if len(raw) <= MOST_BYTES:
            try:
                return deserialize_message(raw, JointState)
            except (RMWError, UnicodeDecodeError):
                pass  # anybody can publish any bytes
        self.unreadable += 1
        return None

    def _one(self, raw, info):
        message = self._unpacked(raw)
        if message is None:
            return
        if message.name != self._names:
            self._names = message.name
            self._look(message)
        if self.joiner is None:
            sample = self._reader.sample(message)
            if sample is None:
                self._is_foreign(message, 0, info)
            elif self._admitted(0, info):
                self._take(sample, self._reader.raw(message))
            return
        motor, arm = self.joints
        values = joint_values_of(message, motor)
        if values is not None and self._admitted(0, info):
            self._joined(self.joiner.motor(stamp_of(message), values))
        if self._arm is None and arm in message.name:
            if values is None:
                self._lost[0].seen(info, False)
            self._one_arm(message, info)
        elif values is None:
            self._is_foreign(message, 0, info)

    def _one_arm(self, message, info):
        if message is None:
            return
        values = joint_values_of(message, self.joints[1])
        if values is None:
            self._is_foreign(message, 1, info)
        elif self._admitted(1, info):
            self._joined(self.joiner.arm(stamp_of(message), values))

    def _admitted(self, joint, info):
        """Return whether to take a message of motor (0) or arm (1), by who published it."""
        publishers = self.publishers[joint]
        before = publishers.disputes
        admitted = publishers.admit(info['publication_sequence_number'],
                                    info['received_timestamp'] or time.time_ns())
        if publishers.disputes != before:
            self.clear()
            self._lost[joint].forget()
            self._disputed()
        if admitted and (joint == 0 or self._arm is not None):  # what is refused is no hole
            self._lost[joint].seen(info, True)
        return admitted

    def _joined(self, due):
        for stamp_ns, motor, arm in due:
            message = to_paired(stamp_ns, self.joints, motor, arm)
            self._paired.publish(message)
            self._take(self._reader.sample(message), self._reader.raw(message))

    def _is_foreign(self, message, joint, info):
        self._lost[joint].seen(info, False)
        self.foreign += 1
        self._others = _listed(message.name)

    # ------------------------------------------------------------------ words

    def _look(self, message):
        """Log what the message lacks that an estimate needs, once per arrangement of joints."""
        motor, arm = self.joints
        names = list(message.name)
        if motor not in names and arm not in names:
            return  # others may publish here, too
        text = ''
        there = _listed(names)
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
        now = time.time_ns()
        if any(p.disputed and p.others(now) for p in self.publishers):
            return (f'several publishers give our joints and none was the first: '
                    f'{self._rivals()}; nothing was taken',
                    'stop one, or set other_publishers')
        if any(p.waits(now) for p in self.publishers):
            return (f'the publisher that was followed is silent; that of {self._rivals()} spoke '
                    'beside it and is refused', 'start the first again, or call ~/reset')
        if self.foreign and not taken:
            motor, arm = self.joints
            return (f'{self.foreign} messages named neither {motor!r} nor {arm!r} but '
                    f'{self._others or "nothing"}', 'set motor_joint and arm_joint')
        if self.joiner is not None and self.joiner.unused and not taken:
            return (f'messages of the arm came on {self.arm_topic}, none of '
                    f'{self.joints[0]!r} on {self.motor_topic}', 'check motor_joint and its topic')
        return None

    def strangers(self):
        """Return ({name: value}, text of who else publishes our joints or '')."""
        now = time.time_ns()
        values = {'messages_unreadable': self.unreadable} if self.unreadable else {}
        refused = sum(p.refused for p in self.publishers)
        if refused:
            values['messages_of_other_publishers'] = refused
        there = {bytes(info.endpoint_gid) for info in self._infos()}
        if there == self._own and any(p.disputed or p.waits(now) for p in self.publishers):
            self.forget_publishers()  # whatever its numbers look like, there is no other
        if not any(p.others(now) for p in self.publishers):
            if not any(p.disputed for p in self.publishers):
                self._known = there
                self._own = there if len(there) == 1 else self._own
            return values, ''
        values['other_publishers'] = self._rivals()
        accepted = self.publishers[0].policy == ACCEPT
        return values, (f'another publisher gives our joints, its messages are '
                        f'{"taken, too" if accepted else "refused"}: {self._rivals()}')

    def _infos(self):
        """Return what the graph knows of the publishers on our topics."""
        topics = {self.motor_topic, self.arm_topic} - {None}
        return [info for topic in topics
                for info in self._node.get_publishers_info_by_topic(topic)]

    def _rivals(self):
        """Return the names of the nodes that may be the others: who came last, else all."""
        infos = self._infos()
        others = [info for info in infos if bytes(info.endpoint_gid) not in self._own]
        new = [info for info in others if bytes(info.endpoint_gid) not in self._known]
        return _listed(sorted({f'{info.node_namespace.rstrip("/")}/{info.node_name}'
                               for info in new or others or infos}))

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

    def forget_publishers(self):
        """Follow whoever speaks next."""
        for publishers in self.publishers:
            publishers.forget()
        for lost in self._lost:
            lost.forget()


def _listed(names):
    """Return the first of `names`, in one text: others may send any number of any length."""
    text = ', '.join(name[:64] for name in names[:MOST_TOLD])
    text = ''.join(c if c.isprintable() else '?' for c in text)  # no lines of their own in the log
    return text + (f' and {len(names) - MOST_TOLD} more' if len(names) > MOST_TOLD else '')
