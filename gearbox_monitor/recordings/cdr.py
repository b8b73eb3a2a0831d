# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Blocks of messages: where they are in unpacked chunks, and their conversion from and to arrays.

Whole blocks of ``sensor_msgs/JointState`` are converted between CDR bytes and arrays at once.
"""
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
import struct
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.kernel import entry, inline
from gearbox_monitor.kernels.types import Array, Bytes, Flags, Integers, Numbers, WordMatrix, Words

MESSAGE = 5  # opcode
MESSAGE_HEAD = 31  # opcode, length, channel, sequence, log time, publish time
CHANNELS = 1 << 16
U9, U15, U23, U31 = (np.uint64(k) for k in (9, 15, 23, 31))
T = TypeVar('T')
Message: TypeAlias = tuple[str, int, int, bytes]  # topic, log_ns, publish_ns, CDR bytes


# Bytes in one word; what is unsigned needs no check for an index from the end.
@inline
def word(data: Any, offset: Any) -> Any:
    """Return the little-endian uint64 at data[offset] (`data` uint8 [N], `offset` uint64)."""
    value = np.uint64(0)
    for i in range(8):
        value |= np.uint64(data[offset + np.uint64(i)]) << np.uint64(8 * i)
    return value


@inline
def copy(source: Any, begin: int, size: int, target: Any, place: int) -> None:
    """Copy source[begin:begin + size] to `target` from `place` on; both are uint8."""
    for i in range(size):
        target[np.uint64(place) + np.uint64(i)] = source[np.uint64(begin) + np.uint64(i)]


class MessageIndex(NamedTuple):
    """Columns that find_messages fills, one row per message; number: of its topic or channel."""

    offset: Integers   # [rows], first byte of the message
    size: Integers     # [rows]
    number: Numbers    # [rows]
    log_ns: Words      # [rows]
    publish_ns: Words  # [rows]


def empty_index(rows: int) -> MessageIndex:
    """Return a MessageIndex with room for `rows` messages."""
    offset, size = np.empty((2, rows), np.int64)
    log_ns, publish_ns = np.empty((2, rows), np.uint64)
    return MessageIndex(offset, size, np.empty(rows, np.int32), log_ns, publish_ns)


@entry
def find_messages(data: Bytes, begin: int, end: int, number_of: Numbers, stop: bool, row: int,
                  index: MessageIndex) -> tuple[int, int]:
    """
    Walk over the MCAP records in data[begin:end] and note its messages.

    Args:
        data: uint8 [N], unpacked records.
        begin: offset of the first record.
        end: offset behind the last one.
        number_of: int32 [CHANNELS], number to note for each channel; messages of a channel whose
            number is negative are skipped.
        stop: whether to stop at a record that is no message.
        row: first row of `index` to write.
        index: MessageIndex, written.

    Returns:
        (Next free row, offset behind the records read: of a cut or damaged one, of the one that
        stopped it, or `end`).
    """
    offset, last = np.uint64(begin), np.uint64(end)
    while offset + U9 <= last:
        length = word(data, offset + np.uint64(1))
        if data[offset] == 0 or length > last - offset - U9:
            break
        if data[offset] == MESSAGE and length >= np.uint64(22):
            number = number_of[int(data[offset + U9]) + 256 * int(data[offset + np.uint64(10)])]
            if number >= 0:
                index.offset[row], index.size[row] = offset + U31, length - np.uint64(22)
                index.number[row] = number
                index.log_ns[row] = word(data, offset + U15)
                index.publish_ns[row] = word(data, offset + U23)
                row += 1
        elif stop:
            break
        offset += U9 + length
    return row, int(offset)


def rows_of(table: T, rows: slice | Integers | Flags) -> T:
    """Return the dataclass `table` with those `rows` of its arrays [N ...]."""
    return replace(table, **{  # type: ignore[type-var]
        name: x[rows] for name, x in vars(table).items() if isinstance(x, np.ndarray)})


def joined(parts: Sequence[T]) -> T:
    """Return the first of the dataclasses `parts` with the rows of the arrays of all."""
    return parts[0] if len(parts) == 1 else replace(parts[0], **{  # type: ignore[type-var]
        name: np.concatenate([getattr(part, name) for part in parts])
        for name, x in vars(parts[0]).items() if isinstance(x, np.ndarray)})


@dataclass(frozen=True)
class MessageBlock:
    """N messages: data[offset[i]:offset[i] + size[i]] is on topics[topic[i]]."""

    topics: tuple[str, ...]
    data: Bytes
    offset: Integers      # [N]
    size: Integers        # [N]
    topic: Numbers        # [N]
    log_ns: Integers      # [N]
    publish_ns: Integers  # [N]

    def __len__(self) -> int:
        return len(self.offset)

    def raw(self, row: int) -> bytes:
        """Return the bytes of message `row`."""
        return self.data[self.offset[row]:self.offset[row] + self.size[row]].tobytes()

    def take(self, rows: slice | Integers) -> 'MessageBlock':
        """Return the MessageBlock of `rows` (indices or slice), of the same data."""
        return MessageBlock(self.topics, self.data, self.offset[rows], self.size[rows],
                            self.topic[rows], self.log_ns[rows], self.publish_ns[rows])

    def of(self, topic: str) -> 'MessageBlock':
        """Return the MessageBlock of the messages on `topic` alone."""
        if len(self.topics) == 1:
            return self
        return self.take(np.flatnonzero(self.topic == self.topics.index(topic)))

    def messages(self) -> Iterator[Message]:
        """Yield (topic, log_ns, publish_ns, bytes)."""
        data = self.data.tobytes()
        for offset, size, topic, log_ns, publish_ns in zip(*(column.tolist() for column in (
                self.offset, self.size, self.topic, self.log_ns, self.publish_ns))):
            yield self.topics[topic], log_ns, publish_ns, data[offset:offset + size]


@entry
def _gather(heads: Bytes, width: int, data: Bytes, block: tuple[Integers, Integers],
            out: Bytes) -> None:
    """
    Write each head and the message behind it to `out`, one after the other.

    heads: uint8 [N * width]. data: uint8. block: (offsets [N], sizes [N]) in `data`. out: uint8.
    """
    offsets, sizes = block
    position = 0
    for k in range(offsets.shape[0]):
        copy(heads, k * width, width, out, position)
        copy(data, offsets[k], sizes[k], out, position + width)
        position += width + sizes[k]


def gathered(block: MessageBlock, heads: Bytes | None = None) -> Bytes:
    """Return the bytes of the messages of `block` in its order, behind `heads` [N, H] if any."""
    heads = np.empty((len(block), 0), np.uint8) if heads is None else heads
    out = np.empty(int(block.size.sum()) + heads.size, np.uint8)
    _gather(heads.ravel(), heads.shape[1], block.data, (block.offset, block.size), out)
    return out


def compact(block: MessageBlock) -> MessageBlock:
    """Return the `block` with the bytes of its own messages only."""
    return replace(block, data=gathered(block), offset=np.cumsum(block.size) - block.size)


def joined_blocks(blocks: Sequence[MessageBlock]) -> MessageBlock:
    """Return the messages of all `blocks`, which have the same topics, in order."""
    begins = np.cumsum([0, *(len(block.data) for block in blocks)]).tolist()
    return joined([replace(block, offset=block.offset + begin)
                   for block, begin in zip(blocks, begins)])


def block_of(topics: Sequence[str], messages: Sequence[Message]) -> MessageBlock:
    """Return the MessageBlock of `messages`, which are on `topics`."""
    number = {topic: k for k, topic in enumerate(topics)}
    size = np.array([len(raw) for *_, raw in messages], np.int64)
    return MessageBlock(
        tuple(topics), np.frombuffer(b''.join(raw for *_, raw in messages), np.uint8),
        np.cumsum(size) - size, size,
        np.array([number[topic] for topic, *_ in messages], np.int32),
        np.array([log_ns for _, log_ns, *_ in messages], np.int64),
        np.array([publish_ns for *_, publish_ns, _ in messages], np.int64))


STATE_TYPE = 'sensor_msgs/msg/JointState'
FIELDS = ('position', 'velocity', 'effort')
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
MAX_JOINTS = 4096   # no robot has more: a message of a million names would take minutes
MAX_BYTES = 1 << 20  # of a joint state, with names of 200 bytes each
MAX_LAYOUTS = 16  # of one topic; messages in further layouts are decoded one by one


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

    def of(self, names: Sequence[str]) -> 'JointStates':
        """Return the columns of the joints `names`, NaN for one that is not among them."""
        if tuple(names) == self.names:
            return self
        index = _first_index(self.names)
        place = np.array([index.get(name, -1) for name in names], int)
        return JointStates(
            tuple(names), self.stamp_ns, self.log_ns, self.named[:, place] & (place >= 0), *(
                np.where(place < 0, np.nan, getattr(self, field)[:, place]) for field in FIELDS))

    def of_named(self) -> 'JointStates':
        """Return the messages that name one of the joints."""
        rows: Flags = np.asarray(self.named.any(axis=1))
        return self if rows.all() else rows_of(self, rows)


@dataclass(frozen=True)
class StateLayout:
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


def read_layout(raw: bytes, ros1: bool = False) -> StateLayout | None:
    """
    Return the StateLayout of a joint state, None unless it is a little-endian one.

    Args:
        raw: CDR bytes.
        ros1: as ROS 1 writes it: stamped at the same place, without padding and ends of texts.
    """
    try:
        if raw[:4] != LITTLE_ENDIAN and not ros1:
            return None
        fixed = [] if ros1 else [range(4)]
        offsets: list[int] = []
        counts: list[int] = []
        names: list[str] = []
        _, offset = _read_text(raw, 12, fixed, ros1)  # frame_id
        count, offset = _read_count(raw, offset, fixed, ros1)
        if count > MAX_JOINTS:
            return None
        for _ in range(count):
            text, offset = _read_text(raw, offset, fixed, ros1)
            names.append(text)
        for _ in FIELDS:
            count, offset = _read_count(raw, offset, fixed, ros1)
            offset = _aligned(offset, 8) if count and not ros1 else offset
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
    return StateLayout(tuple(names), tuple(offsets), tuple(counts), offset,
                       np.array(starts, np.uint64), masks, values)


def _read_count(raw: bytes, offset: int, fixed: list[range], ros1: bool) -> tuple[int, int]:
    """Return the count at `offset` and the offset behind it; padding is no part of the layout."""
    offset = offset if ros1 else _aligned(offset, 4)
    fixed.append(range(offset, offset + 4))
    return struct.unpack_from('<I', raw, offset)[0], offset + 4


def _read_text(raw: bytes, offset: int, fixed: list[range], ros1: bool) -> tuple[str, int]:
    length, offset = _read_count(raw, offset, fixed, ros1)
    text = raw[offset:offset + length]
    if not (length or ros1) or len(text) != length:
        raise struct.error('cut string')
    fixed.append(range(offset, offset + length))
    return text[:length if ros1 else -1].decode(), offset + length


def _aligned(offset: int, size: int) -> int:
    """Round `offset` up to `size`; CDR aligns relative to the end of its 4-byte head."""
    return offset + (4 - offset) % size


@entry
def _decode_rows(data: Bytes, block: tuple[Integers, Integers, Integers],
                 layout: tuple[int, Words, Words, Words], columns: Integers,
                 decoded: tuple[Integers, WordMatrix, Flags]) -> None:
    """
    Write stamps [N] and values [N, 3 J] of the messages in `data` that share one layout.

    block: (offsets [N], sizes [N], rows [M] to decode). layout: (size, starts, mask, fixed) of
    one. columns: its columns. decoded: (stamps, values as uint64, done), written; done [M]: the
    message has that layout.
    """
    offsets, sizes, rows = block
    needed, starts, mask, fixed = layout
    stamps, values, done = decoded
    for m in range(rows.shape[0]):
        k = rows[m]
        done[m] = False
        if sizes[k] < needed:
            continue
        begin, different = np.uint64(offsets[k]), np.uint64(0)
        for i in range(starts.shape[0]):
            different |= (word(data, begin + starts[i]) & mask[i]) ^ fixed[i]
        if different != 0:
            continue
        done[m] = True
        time = word(data, begin + np.uint64(4))
        sec, nanosec = np.int64(time & np.uint64(0xffffffff)), np.int64(time >> np.uint64(32))
        if sec >= 0x80000000:  # it is signed
            sec -= 0x100000000
        stamps[k] = sec * 1000000000 + nanosec
        for i in range(columns.shape[0]):
            if columns[i] >= 0:
                values[k, i] = word(data, begin + np.uint64(columns[i]))


class Decoder:
    """
    Turn the joint states of one topic into arrays, block by block.

    Args:
        names: J joints, the columns.
        decode: function that returns the message object of CDR bytes, for messages in layouts that
            the kernel does not read.
        source: where the messages come from, in front of errors.
        ros1: whether they are serialised as ROS 1 does it.

    Attribute `joints`: {joint: None} of all messages so far, in order of appearance.
    """

    def __init__(self, names: Sequence[str], decode: Callable[[bytes], Any],
                 source: str = '', ros1: bool = False) -> None:
        self.names = tuple(names)
        self._source, self._ros1 = source, ros1
        self.joints: dict[str, None] = {}
        self._decode = decode
        # Of at most MAX_LAYOUTS, newest first, with the offsets of the columns.
        self._layouts: list[tuple[StateLayout, Integers]] = []

    def __call__(self, block: MessageBlock) -> JointStates:
        """Return the JointStates of `block`, in its order."""
        count, joints = len(block), len(self.names)
        stamps, named = np.zeros(count, np.int64), np.zeros((count, joints), bool)
        values = np.full((count, 3 * joints), np.nan)
        position, velocity, effort = np.hsplit(values, 3) if joints else [values] * 3
        states = JointStates(self.names, stamps, block.log_ns, named, position, velocity, effort)
        pending = np.arange(count)
        for layout in list(self._layouts):
            pending = self._read(block, pending, layout, states, values)
        while len(pending):
            raw = block.raw(pending[0])
            if len(raw) > MAX_BYTES:
                raise InputError(f'{self._source}joint state of {len(raw)} bytes, expected at '
                                 f'most {MAX_BYTES}')
            new = read_layout(raw, self._ros1) if len(self._layouts) < MAX_LAYOUTS else None
            if new is None:
                self._decode_one(raw, pending[0], states)
                pending = pending[1:]
                continue
            self._layouts.insert(0, (new, new.columns(self.names)))
            self.joints.update(dict.fromkeys(new.names))
            pending = self._read(block, pending, self._layouts[0], states, values)
        return states

    def _read(self, block: MessageBlock, pending: Integers, layout: tuple[StateLayout, Integers],
              states: JointStates, values: Array) -> Integers:
        """Decode those of the rows `pending` that have a `layout`; return the others."""
        own, columns = layout
        done = np.empty(len(pending), bool)
        _decode_rows(block.data, (block.offset, block.size, pending),
                     (own.size, own.starts, own.mask, own.fixed), columns,
                     (states.stamp_ns, values.view(np.uint64), done))
        states.named[pending[done]] = [name in own.names for name in self.names]
        return pending[~done]

    def _decode_one(self, raw: bytes, row: int, states: JointStates) -> None:
        """Write the message `raw` to one `row` of `states`."""
        message = self._decode(raw)
        if len(message.name) > MAX_JOINTS:
            raise InputError(f'{self._source}joint state of {len(message.name)} joints, expected '
                             f'at most {MAX_JOINTS}')
        index = _first_index(message.name)
        self.joints.update(dict.fromkeys(message.name))
        states.named[row] = [name in index for name in self.names]
        for field in FIELDS:
            values = getattr(message, field)
            for column, name in enumerate(self.names):
                k = index.get(name, len(values))
                if k < len(values):
                    getattr(states, field)[row, column] = values[k]
        stamp = message.header.stamp
        states.stamp_ns[row] = stamp.sec * 1_000_000_000 + stamp.nanosec


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
    from rosbags.typesys import get_typestore, Stores  # not there when kernels are compiled
    store, zeros = get_typestore(Stores.ROS2_JAZZY), np.zeros(len(names))
    header = store.types['std_msgs/msg/Header'](
        store.types['builtin_interfaces/msg/Time'](0, 0), frame_id)
    head = bytes(store.serialize_cdr(store.types[STATE_TYPE](header, list(names), *(
        zeros if field in present else zeros[:0] for field in FIELDS)), STATE_TYPE))
    layout = read_layout(head)
    assert layout is not None  # up to MAX_JOINTS
    offsets = {field: layout.offsets[FIELDS.index(field)] for field in FIELDS if field in present}
    return head, np.dtype({
        'names': ['sec', 'nanosec', *offsets], 'offsets': [4, 8, *offsets.values()],
        'formats': ['<i4', '<u4', *(('<f8', (len(names),)) for _ in offsets)],
        'itemsize': len(head)})
