# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A recording of any kind as a bag: joint states are encoded where they are read, in blocks."""
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.cdr import FIELDS, joint_state_rows, MessageBlock
from gearbox_monitor.recordings.mapping import Mapping as Columns
from gearbox_monitor.recordings.read import BagReader, BLOCK_MESSAGES, JOINT_STATE
from gearbox_monitor.recordings.si_signals import (
    effort_unit, is_streamed, signal_blocks, Signals, signals_of)
from gearbox_monitor.recordings.table import Table

JOINT_TOPIC, SETPOINT_TOPIC = '/joint_states', '/joint_setpoints'
REFERENCE_TOPIC = '/reference/transmission_state'


@dataclass(frozen=True)
class Frames:
    """
    Messages [N] on one topic that name the same J joints.

    stamp_ns, log_ns [N]: of measurement, of receipt. values {field: [N, J]}: a message leaves a
    field empty that was measured of no joint in its block.
    """

    topic: str
    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]


class VirtualBag(BagReader):
    """
    The bag of a recording that is none.

    Args:
        path: of the recording.
        topics: {topic: number of messages, as far as it is known}.
        chunks: yields the Frames of the recording in parts, in order of time.
        span: (start_ns, end_ns) as far as it is known.
        notes: sentences for the user.
    """

    def __init__(self, path: Path, topics: Mapping[str, int],
                 chunks: Callable[[], Iterator[Sequence[Frames]]], span: tuple[int, int],
                 notes: Sequence[str] = ()) -> None:
        super().__init__(path)
        self.topics = {topic: (JOINT_STATE, count) for topic, count in topics.items()}
        self.start_ns, self.end_ns = span
        self.notes, self.notice = tuple(notes), '; '.join(notes)
        self._chunks = chunks

    def _stored_blocks(self, topics: Iterable[str] | None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        for frames in self._chunks():
            block = block_of_frames(names, [f for f in frames if f.topic in names])
            for begin in range(0, len(block), BLOCK_MESSAGES):
                yield block.take(slice(begin, begin + BLOCK_MESSAGES))


def block_of_frames(topics: Sequence[str], frames: Sequence[Frames], whole: bool = False
                    ) -> MessageBlock:
    """
    Return the messages of all `frames` on `topics`, by log time, then in the given order.

    whole: fields that were measured of no joint are written, too.
    """
    def measured(f: Frames, field: str) -> Array | None:
        return f.values[field] if field in f.values and (
            whole or not np.isnan(f.values[field]).all()) else None
    rows = [joint_state_rows(f.stamp_ns, f.joints, measured(f, 'position'), measured(
        f, 'velocity'), measured(f, 'effort')) for f in frames]
    sizes = [np.full(len(data), data.shape[1], np.int64) for data in rows]
    size = np.concatenate([np.empty(0, np.int64), *sizes])
    offset = np.cumsum(size) - size
    log_ns = np.concatenate([np.empty(0, np.int64), *(f.log_ns for f in frames)])
    topic = np.concatenate([np.empty(0, np.int32), *(
        np.full(len(data), topics.index(f.topic), np.int32) for f, data in zip(frames, rows))])
    data = np.concatenate([np.empty(0, np.uint8), *(data.ravel() for data in rows)])
    block = MessageBlock(tuple(topics), data, offset, size, topic, log_ns, log_ns)
    return block if len(frames) < 2 else block.take(np.argsort(log_ns, kind='stable'))


def bag_of_table(table: Table, mapping: Columns) -> VirtualBag:
    """Return the bag of a table as `mapping` reads it. Raises InputError."""
    topics = _signals_of_topics(mapping)
    if is_streamed(table, mapping):
        parts: Callable[[], Iterator[Signals]] = partial(signal_blocks, table, mapping)
        notes, (count, begin, end) = table.notes, _extent(table, mapping)
    else:
        signals = signals_of(table, mapping)
        parts, notes, count = signals.parts, signals.notes, len(signals.stamp_ns)
        begin, end = int(signals.stamp_ns[0]), int(signals.stamp_ns.max())

    def chunks() -> Iterator[Sequence[Frames]]:
        latest = 0
        for part in parts():
            frames = _frames(part, topics, latest)
            latest = int(frames[0].log_ns[-1])
            yield frames
    bag = VirtualBag(table.path, dict.fromkeys(topics, count), chunks, (begin, end), notes)
    bag.arm_side, bag.axis = True, mapping.kind  # whatever the model's gear ratio
    bag.effort_units = {
        name.rpartition(':')[0] or 'motor': unit for name, signal in mapping.signals.items()
        if name.endswith((':effort', 'motor_effort')) and (unit := effort_unit(signal))}
    return bag


def _signals_of_topics(mapping: Columns) -> dict[str, dict[str, dict[str, str]]]:
    """Return {topic: {joint: {field: signal}}} of the topics that `mapping` reads signals of."""
    if mapping.joints:
        topics = {JOINT_TOPIC: {joint: {field: f'{joint}:{field}' for field in FIELDS}
                                for joint in mapping.joints},
                  SETPOINT_TOPIC: {joint: {'position': f'{joint}:setpoint'}
                                   for joint in mapping.joints}}
    else:
        sides = {side: {field: f'{side}_{field}' for field in FIELDS} for side in ('motor', 'arm')}
        if 'motor_setpoint' in mapping.signals:
            sides['setpoint'] = {'position': 'motor_setpoint'}
        topics = {JOINT_TOPIC: sides,
                  REFERENCE_TOPIC: {'transmission': {'effort': 'reference_torque'}}}
    return {topic: joints for topic, joints in topics.items()
            if any(name in mapping.signals for own in joints.values() for name in own.values())}


def _extent(table: Table, mapping: Columns) -> tuple[int, int, int]:
    """Return (number of rows, first and last stamp) of a text that is read in blocks."""
    first = next(signal_blocks(table, mapping)).stamp_ns
    per_row = (int(first[-1]) - int(first[0])) / max(len(first) - 1, 1)
    with table.path.open('rb') as stream:
        count = sum(piece.count(b'\n') for piece in iter(lambda: stream.read(1 << 20), b''))
    return count, int(first[0]), int(first[0] + count * per_row)


def _frames(part: Signals, topics: Mapping[str, Mapping[str, Mapping[str, str]]], latest: int
            ) -> list[Frames]:
    """Return the messages of signals; their log times are not before `latest`."""
    log_ns: Integers = np.maximum(np.maximum.accumulate(part.stamp_ns), latest)
    none = np.broadcast_to(np.nan, len(log_ns))
    return [Frames(topic, tuple(joints), part.stamp_ns, log_ns, {
        field: np.column_stack([part.values.get(own.get(field, ''), none)
                                for own in joints.values()]) for field in FIELDS})
            for topic, joints in topics.items()]
