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

"""Join motor and arm that a bag holds on two topics into samples on one, as the estimator does."""
import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.cdr import encode_joint_states
from gearbox_monitor.bag.joint_input import DIAGNOSTIC_ARRAY, find_topic, JOINT_STATE
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.errors import InputError
from gearbox_monitor.interfaces.joiner import Joiner
from gearbox_monitor.interfaces.signals import PAIRED_JOINT_STATES

COPIED = (JOINT_STATE, DIAGNOSTIC_ARRAY)
NOTHING = (np.nan, np.nan)


def write_paired(reader, path, parameters, name):
    """
    Write the new bag `path`: what `reader` has of joint states, and paired_joint_states beside.

    parameters: EstimatorParameters; name: topic with the motor. Returns (topic, number of
    samples, Joiner). Raises InputError.
    """
    joints = parameters.motor_joint, parameters.arm_joint
    sources = _sources(reader, parameters, name)
    namespace = sources[0].rsplit('/', 1)[0]
    paired = f'{namespace}/{PAIRED_JOINT_STATES}'
    if reader.topics.get(paired, ('', 0))[1]:
        raise InputError(f'{reader.path}: holds {paired} already, expected a bag without it')
    decoders = [reader.decoder(topic, (joint,)) for topic, joint in zip(sources, joints)]
    joiner, count = Joiner(round(parameters.pair_tolerance * 1e9)), 0
    with BagWriter(path) as writer:
        writer.add_metadata('gearbox_monitor', {
            'version': __version__, 'paired_from': str(reader.path),
            **{f'estimator.{key}': value for key, value in parameters.to_dict().items()}})
        copied = [topic for topic, (kind, _) in reader.topics.items() if kind in COPIED]
        for topic in copied:
            writer.add_topic(topic, reader.topics[topic][0])
        writer.add_topic(paired, JOINT_STATE)
        for block in reader.blocks(copied):
            for topic, log_ns, publish_ns, raw in block.messages():
                writer.write(topic, log_ns, raw, publish_ns)
            logged, samples = _joined(block, sources, decoders, joiner)
            count += len(samples)
            for log_ns, raw in zip(logged, _encoded(samples, joints)):
                writer.write(paired, log_ns, raw)
    for topic, joint, decoder in zip(sources, joints, decoders):
        reader.require_joints(topic, (joint,), decoder.there)
    return paired, count, joiner


def _sources(reader, parameters, name):
    """Return the topics of motor and arm."""
    motor, arm = find_topic(reader, name), parameters.arm_topic
    if not arm:
        raise InputError("arm_topic: '', expected the topic of the arm in the parameter file")
    if not arm.startswith('/'):
        arm = f'{motor.rsplit("/", 1)[0]}/{arm}'
    reader.require(arm, JOINT_STATE)
    return motor, arm


def _joined(block, sources, decoders, joiner):
    """Return (log times, samples (stamp, motor values, arm values)) that `block` completes."""
    sides = []
    for side, (topic, decode) in enumerate(zip(sources, decoders)):
        states = decode(block.of(topic))
        rows = np.flatnonzero(block.topic == block.topics.index(topic))[states.named[:, 0]]
        named = states.named[:, 0]
        sides += zip(rows.tolist(), [side] * len(rows), states.stamp_ns[named].tolist(),
                     zip(states.position[named, 0].tolist(), states.effort[named, 0].tolist()))
    take, log_ns = (joiner.motor, joiner.arm), block.log_ns
    logged, samples = [], []
    for row, side, stamp_ns, values in sorted(sides, key=lambda part: part[:2]):
        due = take[side](stamp_ns, values)
        samples += due
        logged += [int(log_ns[row])] * len(due)
    return logged, samples


def _encoded(samples, joints):
    """Return the messages of the samples, as the estimator publishes them."""
    if not samples:
        return []
    stamps, motor, arm = zip(*samples)
    values = np.array([(m, a or NOTHING) for m, a in zip(motor, arm)])
    return encode_joint_states(np.array(stamps, np.int64), joints, values[:, :, 0],
                               effort=values[:, :, 1])
