# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What an estimator has left in a bag: samples on the arm side, snapshots, innovations.

A snapshot holds the state of the estimator, its parameters and its input counter. Innovations are
read of whatever filter published them: two topics of one type belong together where the second is
called as the first one, with `variances` or the like behind it.
"""
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import islice
import json
import re
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import expect_format, SnapshotError
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.recordings.cdr import Decoder, joined, JointStates, rows_of
from gearbox_monitor.recordings.joint_input import JointInput, snapshot_of
from gearbox_monitor.recordings.read import BagReader

NO_SAMPLES = Samples(np.empty(0, np.int64), *np.empty((2, 0, 2)))


def sample_parts(reader: BagReader, topic: str, decode: Decoder, model: DriveModel, size: int,
                 progress: Callable[[int], object]) -> Iterator[Samples]:
    """
    Read the samples of a topic in parts of bounded size.

    Each part begins with the last sample of its predecessor: the interval between them belongs to
    it.

    Args:
        reader: the bag.
        topic: topic of the joint states.
        decode: decoder of the joints motor and arm.
        model: see samples_of.
        size: number of samples per part; the last part has up to twice as many.
        progress: called with the number of messages read.

    Returns:
        An iterator over Samples.
    """
    parts, count = [NO_SAMPLES], 0
    for block in reader.blocks([topic]):
        samples, _ = samples_of(decode(block), model)
        parts.append(samples)
        count += len(samples.stamp_ns)
        progress(len(block))
        while count >= 2 * size:
            samples = joined(parts)
            yield rows_of(samples, slice(0, size))
            parts, count = [rows_of(samples, slice(size - 1, count))], count - size + 1
    yield joined(parts)


def samples_of(states: JointStates, model: DriveModel,
               robot: bool = False) -> tuple[Samples, Integers]:
    """
    Return (Samples [N], log_ns [N]) of the JointStates `states` with the columns motor and arm.

    The gear_ratio and torque_constant of `model` refer them to the arm side. A third column is the
    setpoint of the motor, which then stands in place of its torque; in a `robot` all columns from
    the third on are the joints of its description.
    """
    rows: slice | Flags = slice(None)
    if not states.named.all():  # other publishers may use the same topic
        rows = np.asarray(states.named[:, :2 if robot else None].any(axis=1))
    position, effort = states.position[rows], states.effort[rows]
    u, y = np.empty((len(position), 2)), np.empty((len(position), 2))
    if len(states.names) > 2 and not robot:
        np.divide(position[:, 2], model.gear_ratio, u[:, 0])
    else:
        np.multiply(effort[:, 0], model.effort_scale, u[:, 0])
    np.divide(position[:, 0], model.gear_ratio, y[:, 0])
    u[:, 1], y[:, 1] = effort[:, 1], position[:, 1]
    return Samples(states.stamp_ns[rows], u, y, position[:, 2:] if robot else None), (
        states.log_ns[rows])


NO_SERIAL = 'no gearbox_serial is recorded: the folder of the bag names the gearbox'
NO_MODEL = ('the bag records no model and --model names none: the values of the packaged '
            'drive.yaml were used, which are wrong for any other drive')


@dataclass(frozen=True)
class RecordedSnapshot:
    """One recorded snapshot: `content` {name: text} (Monitor.snapshot) logged at `log_ns`."""

    content: Mapping[str, str]
    log_ns: int

    @property
    def stamp_ns(self) -> int:
        """Stamp of the sample that precedes it, 0 without one."""
        return int(self.content['stamp_ns'])

    @property
    def input_count(self) -> int:
        """Number of samples that the estimator had taken."""
        return int(self.content['input_count'])

    def settings(self, source: str) -> tuple[DriveModel, dict[str, Any]]:
        """
        Return (DriveModel, {parameter: value}) that the estimator used.

        Raises InputError, in which `source` names the bag.
        """
        try:
            model, parameters = (dict(json.loads(self.content[name]))
                                 for name in ('model', 'parameters'))
        except (KeyError, ValueError, TypeError, RecursionError):
            raise InputError(f'{source}: snapshot: no model and parameters, expected what an '
                             'estimator writes') from None
        return model_from_dict(model, f'{source}: snapshot'), parameters


def read_snapshots(reader: BagReader, joint_input: JointInput, is_needed: bool = True
                   ) -> list[RecordedSnapshot]:
    """
    Return the snapshots of an estimator.

    Args:
        reader: of the bag.
        joint_input: of the estimator.
        is_needed: whether the model comes from them: else those of another version are left out.

    Returns:
        The snapshots, [] without one.

    Raises:
        InputError: a snapshot is of another version, or a stamp or a counter is no whole number.
    """
    if joint_input.snapshots is None:
        return []
    contents = ((log_ns, snapshot_of(reader, raw))
                for _, log_ns, _, raw in reader.messages([joint_input.snapshots]))
    snapshots = [RecordedSnapshot(content, log_ns) for log_ns, content in contents if content]
    try:
        for snapshot in snapshots:
            expect_format(snapshot.content, f'{reader.path}: snapshot')
    except SnapshotError:
        if is_needed:
            raise
        return []
    for snapshot in snapshots:
        for name in ('stamp_ns', 'input_count'):
            value = snapshot.content.get(name, '')
            if not re.fullmatch('-?[0-9]{1,18}|[0-9]{19}', value):
                raise InputError(f'{reader.path}: snapshot: {name}: {value!r}, expected a whole '
                                 'number')
    return snapshots


def recorded_settings(snapshots: Sequence[RecordedSnapshot], source: str,
                      model: DriveModel | None, stated: Values) -> tuple[
                          DriveModel | None, dict[str, Any]]:
    """
    Return (model, {parameter: value}) of an estimator: as stated, else as recorded.

    Args:
        snapshots: of the estimator, [] without one.
        source: the name of the bag in messages.
        model: in place of the recorded one; None: the recorded one, None without any.
        stated: {name: value} that replace recorded parameters.

    Raises:
        InputError: a snapshot is damaged.
    """
    recorded_model, recorded = snapshots[0].settings(source) if snapshots else (None, {})
    return recorded_model if model is None else model, {**recorded, **stated}


SPREAD = re.compile(r'(.*innovation)s?_(stddev|std|variances?|covariances?)')
MOST = 20_000  # messages that are read
HEADS = ('header', 'stamp', 'timestamp', 'timestamp_sample', 'name')


def innovation_topics(reader: BagReader) -> dict[str, str]:
    """Return {topic of innovations: topic of their deviations or variances} in the bag."""
    pairs = {}
    for topic, (kind, _) in reader.topics.items():
        if (match := SPREAD.fullmatch(topic)) is not None:
            pairs.update({own: topic for own in (match[1], f'{match[1]}s')
                          if own in reader.topics and reader.topics[own][0] == kind})
    return pairs


def nis_of(reader: BagReader, innovations: str, spreads: str) -> dict[str, tuple[float, int]]:
    """
    Return {reading: (mean of its squared innovation over the variance, number)}.

    Args:
        reader: of the bag.
        innovations: topic.
        spreads: topic of their deviations or variances, as innovation_topics gives it.

    """
    match = SPREAD.fullmatch(spreads)
    power = 2 if match and match[2].startswith('std') else 1
    variances = dict(_messages(reader, spreads))
    ratios: dict[str, list[float]] = {}
    for stamp, values in _messages(reader, innovations):
        for name, error in values.items():
            variance = variances.get(stamp, {}).get(name, 0.0) ** power
            if variance > 0.0 and np.isfinite(error):
                ratios.setdefault(name, []).append(error ** 2 / variance)
    return {name: (float(np.mean(own)), len(own)) for name, own in ratios.items()}


def _messages(reader: BagReader, topic: str) -> Iterator[tuple[Any, dict[str, float]]]:
    """Yield (stamp or number, {reading: value}) of the first messages of a `topic`."""
    kind = reader.topics[topic][0]
    for number, (*_, raw) in enumerate(islice(reader.messages((topic,)), MOST)):
        content = reader.decode(kind, raw)
        stamp = getattr(getattr(content, 'header', None), 'stamp', None)
        key = getattr(content, 'timestamp', number) if stamp is None else (
            stamp.sec, stamp.nanosec)
        yield key, dict(_numbers(content, tuple(getattr(content, 'name', ()))))


def _numbers(content: Any, joints: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    """Yield (name, value) of all numbers in a message; joints: names of those of an array."""
    for name in (field.name for field in fields(content)):
        value = getattr(content, name)
        if name in HEADS or name.startswith('__'):
            continue
        if is_dataclass(value):
            yield from ((f'{name}.{part}', number) for part, number in _numbers(value, ()))
        elif isinstance(value, float):
            yield name, value
        elif isinstance(value, np.ndarray) and value.dtype.kind == 'f':
            row: Array = value
            yield from zip(joints if len(joints) == len(row) else (
                f'{name}[{k}]' for k in range(len(row))), map(float, row))
