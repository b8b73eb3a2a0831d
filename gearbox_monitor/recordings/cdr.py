# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Convert whole blocks of ``sensor_msgs/JointState`` between CDR bytes and arrays, vectorised."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.jit import jit
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.recordings.message_block import Bytes, MessageBlock, word

FIELDS = ('position', 'velocity', 'effort')
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
MAX_JOINTS = 4096   # no robot has more: a message of a million names would take minutes
MAX_BYTES = 1 << 20  # of a joint state, with names of 200 bytes each
MAX_LAYOUTS = 16  # of one topic; messages in further layouts are decoded one by one
Words = npt.NDArray[np.uint64]


@dataclass(frozen=True)
class JointStates:
    """Joint states as arrays: N messages, J joints, NaN where a message has no value."""

    names: tuple[str, ...]  # J joint names
    stamp_ns: Integers      # [N], header stamps
    log_ns: Integers        # [N], when recorded
    named: Flags            # [N, J], the message names the joint
    position: Array         # [N, J], rad or m
    velocity: Array         # [N, J], rad/s or m/s
    effort: Array           # [N, J], N m or N

    def of_named(self) -> 'JointStates':
        """Return the messages that name one of the joints."""
        rows = self.named.any(axis=1)
        return self if rows.all() else JointStates(
            self.names, self.stamp_ns[rows], self.log_ns[rows], self.named[rows],
            self.position[rows], self.velocity[rows], self.effort[rows])


@dataclass(frozen=True)
class Layout:
    """
    Where the fields of one serialised joint state are, and the bytes that decide it.

    Those bytes are in K words: from byte starts[k] on, under mask[k], stands fixed[k].
    """

    names: tuple[str, ...]
    offsets: tuple[int, ...]  # byte offset of position, velocity, effort
    counts: tuple[int, ...]   # number of values of each
    size: int                 # bytes up to the last value
    starts: Words             # [K]
    mask: Words               # [K]
    fixed: Words              # [K]

    def columns(self, names: Sequence[str]) -> Integers:
        """Return [3 J] byte offsets of position, velocity, effort of `names`; -1: missing."""
        index = _first_index(self.names)
        return np.array([
            begin + 8 * index[name] if index.get(name, count) < count else -1
            for begin, count in zip(self.offsets, self.counts) for name in names], np.int64)


def _first_index(names: Sequence[str]) -> dict[str, int]:
    """Return {name: index of its first occurrence}."""
    return {name: k for k, name in reversed(list(enumerate(names)))}


def read_layout(raw: bytes) -> Layout | None:
    """Return the Layout of the CDR bytes `raw`, None unless a little-endian joint state."""
    try:
        if raw[:4] != LITTLE_ENDIAN:
            return None
        fixed = [range(4)]
        offsets: list[int] = []
        counts: list[int] = []
        names: list[str] = []
        _, offset = _read_text(raw, 12, fixed)  # frame_id
        count, offset = _read_count(raw, offset, fixed)
        if count > MAX_JOINTS:
            return None
        for _ in range(count):
            text, offset = _read_text(raw, offset, fixed)
            names.append(text)
        for _ in FIELDS:
            count, offset = _read_count(raw, offset, fixed)
            offset = _aligned(offset, 8) if count else offset
            offsets.append(offset)
            counts.append(count)
            offset += 8 * count
        if offset > len(raw):
            return None
    except (struct.error, UnicodeDecodeError):
        return None
    decisive = np.concatenate([np.asarray(r, int) for r in fixed])
    mask = np.zeros(decisive[-1] + 1, np.uint8)
    mask[decisive] = 0xff
    starts = list(range(0, len(mask) - 7, 8))
    if len(mask) % 8:  # whole words only: the last one may overlap
        starts.append(len(mask) - 8)
    masks, values = (np.concatenate([table[k:k + 8] for k in starts]).view('<u8')
                     for table in (mask, mask & np.frombuffer(raw, np.uint8)[:len(mask)]))
    return Layout(tuple(names), tuple(offsets), tuple(counts), offset,
                  np.array(starts, np.uint64), masks, values)


def _read_count(raw: bytes, offset: int, fixed: list[range]) -> tuple[int, int]:
    """Return the count at `offset` and the offset behind it; padding is no part of the layout."""
    offset = _aligned(offset, 4)
    fixed.append(range(offset, offset + 4))
    return struct.unpack_from('<I', raw, offset)[0], offset + 4


def _read_text(raw: bytes, offset: int, fixed: list[range]) -> tuple[str, int]:
    length, offset = _read_count(raw, offset, fixed)
    text = raw[offset:offset + length]
    if not length or len(text) != length:
        raise struct.error('cut string')
    fixed.append(range(offset, offset + length))
    return text[:-1].decode(), offset + length


def _aligned(offset: int, size: int) -> int:
    """Round `offset` up to `size`; CDR aligns relative to the end of its 4-byte head."""
    return offset + (4 - offset) % size


@jit
def _decode_rows(data: Any, block: Any, layout: Any, columns: Any, decoded: Any) -> None:
    """
    Write stamps [N] and values [N, 3 J] of the messages in `data` that share one layout.

    block: (offsets, sizes). layout: (size, starts, mask, fixed) of a Layout. columns: its columns.
    decoded: (stamps, values as uint64, done), written; done [N]: the message has that layout.
    """
    offsets, sizes = block
    needed, starts, mask, fixed = layout
    stamps, values, done = decoded
    for k in range(offsets.shape[0]):
        done[k] = False
        if sizes[k] < needed:
            continue
        begin, different = np.uint64(offsets[k]), np.uint64(0)
        for i in range(starts.shape[0]):
            different |= (word(data, begin + starts[i]) & mask[i]) ^ fixed[i]
        if different != 0:
            continue
        done[k] = True
        time = word(data, begin + np.uint64(4))
        sec, nanosec = np.int64(time & np.uint64(0xffffffff)), np.int64(time >> np.uint64(32))
        if sec >= 0x80000000:  # it is signed
            sec -= 0x100000000
        stamps[k] = sec * 1000000000 + nanosec
        for i in range(columns.shape[0]):
            if columns[i] >= 0:
                values[k, i] = word(data, begin + np.uint64(columns[i]))


@dataclass(frozen=True)
class _Reading:
    """A Layout with the offsets of the decoder's columns in it; named [J]: joints it names."""

    layout: Layout
    columns: Integers
    named: Flags


@dataclass(frozen=True)
class _Rows:
    """What a block is decoded into: stamps [N], named [N, J], values [N, 3 J]."""

    stamp_ns: Integers
    named: Flags
    values: Array


class Decoder:
    """
    Turn the joint states of one topic into arrays, block by block.

    Args:
        names: J joints, the columns.
        decode: function that returns the message object of CDR bytes, for messages in layouts that
            the kernel does not read.
        source: where the messages come from, in front of errors.

    Attribute `joints`: {joint: None} of all messages so far, in order of appearance.
    """

    def __init__(self, names: Sequence[str], decode: Callable[[bytes], Any],
                 source: str = '') -> None:
        self.names = tuple(names)
        self._source = source
        self.joints: dict[str, None] = {}
        self._decode = decode
        self._readings: list[_Reading] = []  # at most MAX_LAYOUTS, newest first

    def __call__(self, block: MessageBlock) -> JointStates:
        """Return the JointStates of `block`, in its order."""
        count, joints = len(block), len(self.names)
        rows = _Rows(np.zeros(count, np.int64), np.zeros((count, joints), bool),
                     np.full((count, 3 * joints), np.nan))
        pending = np.arange(count)
        for reading in list(self._readings):
            pending = self._read(block, pending, reading, rows)
        while len(pending):
            raw = block.raw(pending[0])
            if len(raw) > MAX_BYTES:
                raise InputError(f'{self._source}joint state of {len(raw)} bytes, expected at '
                                 f'most {MAX_BYTES}')
            layout = read_layout(raw) if len(self._readings) < MAX_LAYOUTS else None
            if layout is None:
                self._decode_one(raw, pending[0], rows)
                pending = pending[1:]
                continue
            self._readings.insert(0, _Reading(
                layout, layout.columns(self.names),
                np.array([name in layout.names for name in self.names])))
            self.joints.update(dict.fromkeys(layout.names))
            pending = self._read(block, pending, self._readings[0], rows)
        position, velocity, effort = np.hsplit(rows.values, 3) if joints else [rows.values] * 3
        return JointStates(self.names, rows.stamp_ns, block.log_ns, rows.named, position,
                           velocity, effort)

    def _read(self, block: MessageBlock, pending: Integers, reading: _Reading, rows: _Rows
              ) -> Integers:
        """Decode those of the rows `pending` in the layout of `reading`; return the others."""
        if not len(pending):
            return pending
        layout = reading.layout
        complete = len(pending) == len(block)
        offset, size = (block.offset, block.size) if complete else (
            block.offset[pending], block.size[pending])
        done = np.empty(len(pending), bool)
        stamps = rows.stamp_ns if complete else rows.stamp_ns[pending]
        values = rows.values if complete else rows.values[pending]
        _decode_rows(block.data, (offset, size),
                     (layout.size, layout.starts, layout.mask, layout.fixed), reading.columns,
                     (stamps, values.view(np.uint64), done))
        uniform = bool(done.all())
        decoded = pending if uniform else pending[done]
        if not complete:
            rows.stamp_ns[decoded], rows.values[decoded] = (stamps, values) if uniform else (
                stamps[done], values[done])
        rows.named[decoded] = reading.named
        return pending[:0] if uniform else pending[~done]

    def _decode_one(self, raw: bytes, row: int, rows: _Rows) -> None:
        """Write the message `raw` to one `row` of `rows`."""
        message = self._decode(raw)
        if len(message.name) > MAX_JOINTS:
            raise InputError(f'{self._source}joint state of {len(message.name)} joints, expected '
                             f'at most {MAX_JOINTS}')
        index = _first_index(message.name)
        self.joints.update(dict.fromkeys(message.name))
        rows.named[row] = [name in index for name in self.names]
        for i, field in enumerate(FIELDS):
            values = getattr(message, field)
            for column, name in enumerate(self.names):
                k = index.get(name, len(values))
                if k < len(values):
                    rows.values[row, i * len(self.names) + column] = values[k]
        stamp = message.header.stamp
        rows.stamp_ns[row] = stamp.sec * 1_000_000_000 + stamp.nanosec


def encode_joint_states(stamp_ns: npt.ArrayLike, names: Sequence[str],
                        position: npt.ArrayLike | None = None,
                        velocity: npt.ArrayLike | None = None,
                        effort: npt.ArrayLike | None = None, frame_id: str = '') -> list[bytes]:
    """
    Serialise N joint states as little-endian CDR.

    Args:
        stamp_ns: header stamps, int [N].
        names: J joint names, the same in all messages.
        position: float [N, J], rad or m; None: the messages leave the field empty.
        velocity: float [N, J], rad/s or m/s, or None.
        effort: float [N, J], N m or N, or None.
        frame_id: frame in the header.

    Returns:
        The bytes of each of the N messages.
    """
    data = joint_state_rows(stamp_ns, names, position, velocity, effort, frame_id)
    size, raw = data.shape[1], data.tobytes()
    return [raw[k:k + size] for k in range(0, len(raw), size)]


def joint_state_rows(stamp_ns: npt.ArrayLike, names: Sequence[str],
                     position: npt.ArrayLike | None = None,
                     velocity: npt.ArrayLike | None = None,
                     effort: npt.ArrayLike | None = None, frame_id: str = '') -> Bytes:
    """
    Return messages of JointState as rows of bytes, uint8 [N, size]; see encode_joint_states.

    Args:
        stamp_ns: [N] of the headers.
        names: of J joints.
        position: [N, J] rad, None for an empty field.
        velocity: likewise, rad/s.
        effort: likewise, N m.
        frame_id: of the headers.
    """
    stamp_ns = np.asarray(stamp_ns, np.int64)
    values = {'position': position, 'velocity': velocity, 'effort': effort}
    head, record = _template(tuple(names), tuple(
        field for field, array in values.items() if array is not None and names), frame_id)
    data = np.tile(np.frombuffer(head, np.uint8), (len(stamp_ns), 1))
    table = data.view(record)[:, 0]
    table['sec'], table['nanosec'] = np.divmod(stamp_ns, 1_000_000_000)
    for field in record.names[2:]:
        table[field] = np.asarray(values[field], float).reshape(len(stamp_ns), len(names))
    return data


@lru_cache(maxsize=64)
def _template(names: tuple[str, ...], present: tuple[str, ...], frame_id: str
              ) -> tuple[bytes, Any]:
    """Return (message of the joints `names` with zeros, dtype that finds its values)."""
    head = bytearray(LITTLE_ENDIAN + bytes(8))
    _put_text(head, frame_id)
    _put_count(head, len(names))
    for name in names:
        _put_text(head, name)
    offsets = {}
    for field in FIELDS:
        if field not in present:
            _put_count(head, 0)
            continue
        _put_count(head, len(names))
        head.extend(bytes(_aligned(len(head), 8) - len(head)))
        offsets[field] = len(head)
        head.extend(bytes(8 * len(names)))
    return bytes(head), np.dtype({
        'names': ['sec', 'nanosec', *offsets],
        'formats': ['<i4', '<u4', *(('<f8', (len(names),)) for _ in offsets)],
        'offsets': [4, 8, *offsets.values()],
        'itemsize': len(head),
    })


def _put_count(head: bytearray, count: int) -> None:
    head.extend(bytes(_aligned(len(head), 4) - len(head)))
    head.extend(struct.pack('<I', count))


def _put_text(head: bytearray, text: str) -> None:
    data = text.encode() + b'\x00'
    _put_count(head, len(data))
    head.extend(data)
