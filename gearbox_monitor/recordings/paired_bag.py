# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Join motor and arm on two topics of a bag into samples on one topic, as the estimator does."""
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.recordings.cdr import Decoder, encode_joint_states
from gearbox_monitor.recordings.joiner import JoinedSample, Joiner
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, find_topic
from gearbox_monitor.recordings.message_block import MessageBlock
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.topics import PAIRED_JOINT_STATES
from gearbox_monitor.recordings.write import BagWriter

COPIED = (JOINT_STATE, DIAGNOSTIC_ARRAY)
NOT_MEASURED = (np.nan, np.nan)
Reading: TypeAlias = tuple[float, float]  # position, effort


def write_paired(reader: BagReader, path: str | Path, parameters: EstimatorParameters, name: str
                 ) -> tuple[str, int, Joiner[Reading]]:
    """
    Copy the joint states of a bag and add the joined samples on paired_joint_states.

    Args:
        reader: the recorded bag.
        path: the new bag.
        parameters: names of the joints, topic of the arm and tolerance of stamps.
        name: topic of the motor, see find_topic.

    Returns:
        (topic of the samples, number of samples, Joiner with its counters).

    Raises:
        InputError: a topic or joint is missing, or the new bag cannot be written.
    """
    joints = parameters.motor_joint, parameters.arm_joint
    sources = _sources(reader, parameters, name)
    namespace = sources[0].rsplit('/', 1)[0]
    paired = f'{namespace}/{PAIRED_JOINT_STATES}'
    if reader.count(paired):
        raise InputError(f'{reader.path}: holds {paired} already, expected a bag without it')
    decoders = [reader.decoder(topic, (joint,)) for topic, joint in zip(sources, joints)]
    joiner = Joiner[Reading](round(parameters.pair_tolerance * 1e9))
    count = 0
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
        reader.require_joints(topic, (joint,), decoder.joints)
    return paired, count, joiner


def _sources(reader: BagReader, parameters: EstimatorParameters, name: str) -> tuple[str, str]:
    """Return the topics of motor and arm."""
    motor, arm = find_topic(reader, name), parameters.arm_topic
    if not arm:
        raise InputError("arm_topic: '', expected the topic of the arm in the parameter file")
    if not arm.startswith('/'):
        arm = f'{motor.rsplit("/", 1)[0]}/{arm}'
    reader.require(arm, JOINT_STATE)
    return motor, arm


def _joined(block: MessageBlock, sources: Sequence[str], decoders: Sequence[Decoder],
            joiner: Joiner[Reading]) -> tuple[list[int], list[JoinedSample[Reading]]]:
    """Return (log times, samples) that `block` completes."""
    readings: list[tuple[int, int, int, Reading]] = []  # row in the block, side, stamp, values
    for side, (topic, decode) in enumerate(zip(sources, decoders)):
        states = decode(block.of(topic))
        names = states.named[:, 0]
        rows = np.flatnonzero(block.topic == block.topics.index(topic))[names]
        readings += zip(rows.tolist(), [side] * len(rows), states.stamp_ns[names].tolist(),
                        zip(states.position[names, 0].tolist(), states.effort[names, 0].tolist()))
    take = (joiner.motor, joiner.arm)
    logged: list[int] = []
    samples: list[JoinedSample[Reading]] = []
    for row, side, stamp_ns, values in sorted(readings, key=lambda reading: reading[:2]):
        completed = take[side](stamp_ns, values)
        samples += completed
        logged += [int(block.log_ns[row])] * len(completed)
    return logged, samples


def _encoded(samples: Sequence[JoinedSample[Reading]], joints: Sequence[str]) -> list[bytes]:
    """Return the messages of the samples, as the estimator publishes them."""
    if not samples:
        return []
    stamps, motor, arm = zip(*samples)
    values = np.array([(m, a or NOT_MEASURED) for m, a in zip(motor, arm)])
    return encode_joint_states(np.array(stamps, np.int64), joints, values[:, :, 0],
                               effort=values[:, :, 1])
