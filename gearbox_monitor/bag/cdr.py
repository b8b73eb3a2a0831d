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

"""Whole runs of ``sensor_msgs/JointState`` between CDR bytes and arrays, without a loop."""
from dataclasses import dataclass
import struct

import numpy as np

from gearbox_monitor.bag.message_block import word
from gearbox_monitor.kernels.jit import jit

FIELDS = ('position', 'velocity', 'effort')
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
MAX_ITEMS = 1 << 20  # no joint state is larger: guards against declared sizes in damaged data
MAX_LAYOUTS = 16  # of one topic; messages in others are decoded one by one


@dataclass(frozen=True)
class JointStates:
    """Joint states as arrays: N messages, J joints, NaN where a message lacks a value."""

    names: tuple         # J joint names
    stamp_ns: np.ndarray  # int64[N], header stamps
    log_ns: np.ndarray   # int64[N], when recorded
    named: np.ndarray    # bool[N, J], the message names the joint
    position: np.ndarray  # float64[N, J], rad or m
    velocity: np.ndarray  # float64[N, J], rad/s or m/s
    effort: np.ndarray   # float64[N, J], N m or N


@dataclass(frozen=True)
class Layout:
    """
    Where the fields of one serialised joint state are, and the bytes that decide it.

    Those bytes are in K words: from byte starts[k] on, under mask[k], stands fixed[k].
    """

    names: tuple
    offsets: tuple      # byte offset of position, velocity, effort
    counts: tuple       # number of values of each
    size: int           # bytes up to the last value
    starts: np.ndarray  # uint64[K]
    mask: np.ndarray    # uint64[K]
    fixed: np.ndarray   # uint64[K]

    def columns(self, names):
        """Return int64[3 J]: byte offsets of position, velocity, effort of `names`, -1 = none."""
        index = {name: k for k, name in reversed(list(enumerate(self.names)))}
        return np.array([
            begin + 8 * index[name] if index.get(name, count) < count else -1
            for begin, count in zip(self.offsets, self.counts) for name in names], np.int64)


def read_layout(raw):
    """Return the Layout of the little-endian CDR bytes `raw`, None when they are none."""
    try:
        if raw[:4] != LITTLE_ENDIAN:
            return None
        fixed, offsets, counts, names = [range(4)], [], [], []
        _, at = _read_text(raw, 12, fixed)  # frame_id
        count, at = _read_count(raw, at, fixed)
        if count > MAX_ITEMS:
            return None
        for _ in range(count):
            text, at = _read_text(raw, at, fixed)
            names.append(text)
        for _ in FIELDS:
            count, at = _read_count(raw, at, fixed)
            at = _aligned(at, 8) if count else at
            offsets.append(at)
            counts.append(count)
            at += 8 * count
        if at > len(raw):
            return None
    except (struct.error, UnicodeDecodeError):
        return None
    decides = np.concatenate([np.asarray(r, int) for r in fixed])
    mask = np.zeros(decides[-1] + 1, np.uint8)
    mask[decides] = 0xff
    starts = list(range(0, len(mask) - 7, 8))
    if len(mask) % 8:  # whole words only: the last one may overlap
        starts.append(len(mask) - 8)
    words = [np.concatenate([table[k:k + 8] for k in starts]).view('<u8')
             for table in (mask, mask & np.frombuffer(raw, np.uint8)[:len(mask)])]
    return Layout(tuple(names), tuple(offsets), tuple(counts), at,
                  np.array(starts, np.uint64), *words)


def _read_count(raw, at, fixed):
    """Return the count at `at` and the offset behind it; padding is no part of the layout."""
    at = _aligned(at, 4)
    fixed.append(range(at, at + 4))
    return struct.unpack_from('<I', raw, at)[0], at + 4


def _read_text(raw, at, fixed):
    length, at = _read_count(raw, at, fixed)
    text = raw[at:at + length]
    if not length or len(text) != length:
        raise struct.error('cut string')
    fixed.append(range(at, at + length))
    return text[:-1].decode(), at + length


def _aligned(at, size):
    """Round the offset `at` up to `size`; CDR aligns relative to the end of its 4-byte head."""
    return at + (4 - at) % size


@jit
def _gather(data, at, size, needed, starts, mask, fixed, columns, stamps, values, done):
    """Write stamps [N] and values [N, 3 J] of the messages at data[at] that share a layout."""
    for k in range(at.shape[0]):
        done[k] = False
        if size[k] < needed:
            continue
        here, different = np.uint64(at[k]), np.uint64(0)
        for i in range(starts.shape[0]):
            different |= (word(data, here + starts[i]) & mask[i]) ^ fixed[i]
        if different != 0:
            continue
        done[k] = True
        time = word(data, here + np.uint64(4))
        sec, nanosec = np.int64(time & np.uint64(0xffffffff)), np.int64(time >> np.uint64(32))
        if sec >= 0x80000000:  # it is signed
            sec -= 0x100000000
        stamps[k] = sec * 1000000000 + nanosec
        for i in range(columns.shape[0]):
            if columns[i] >= 0:
                values[k, i] = word(data, here + np.uint64(columns[i]))


class Decoder:
    """
    Turn the joint states of one topic into arrays, block by block.

    names: J joints, the columns. decode: function that returns the message object of CDR bytes,
    for messages in no layout of the kernel's. there: {joint: None} met so far, in order.
    """

    def __init__(self, names, decode):
        self.names, self.there = tuple(names), {}
        self._decode = decode
        self._layouts = []  # of MAX_LAYOUTS at most: (Layout, columns, named), newest first

    def __call__(self, block):
        """Return the JointStates of a MessageBlock, in its order."""
        count, joints = len(block), len(self.names)
        stamp_ns, named = np.zeros(count, np.int64), np.zeros((count, joints), bool)
        values = np.full((count, 3 * joints), np.nan)
        left = np.arange(count)
        for known in list(self._layouts):
            left = self._gather(block, left, known, stamp_ns, named, values)
        while len(left):
            raw = block.raw(left[0])
            layout = read_layout(raw) if len(self._layouts) < MAX_LAYOUTS else None
            if layout is None:
                stamp_ns[left[0]] = self._decode_one(raw, named[left[0]], values[left[0]])
                left = left[1:]
                continue
            self._layouts.insert(0, (layout, layout.columns(self.names),
                                     np.array([name in layout.names for name in self.names])))
            self.there.update(dict.fromkeys(layout.names))
            left = self._gather(block, left, self._layouts[0], stamp_ns, named, values)
        position, velocity, effort = np.hsplit(values, 3) if joints else [values] * 3
        return JointStates(self.names, stamp_ns, block.log_ns, named, position, velocity, effort)

    def _gather(self, block, rows, known, stamp_ns, named, values):
        """Decode those of `rows` that have a `known` layout; return the others."""
        layout, columns, has = known
        if not len(rows):
            return rows
        every = len(rows) == len(block)
        at, size = (block.at, block.size) if every else (block.at[rows], block.size[rows])
        done = np.empty(len(rows), bool)
        stamps = stamp_ns if every else stamp_ns[rows]
        found = values if every else values[rows]
        _gather(block.data, at, size, layout.size, layout.starts, layout.mask, layout.fixed,
                columns, stamps, found.view(np.uint64), done)
        whole = bool(done.all())
        good = rows if whole else rows[done]
        if not every:
            stamp_ns[good], values[good] = (stamps, found) if whole else (
                stamps[done], found[done])
        named[good] = has
        return rows[:0] if whole else rows[~done]

    def _decode_one(self, raw, named, values):
        """Write the message `raw` to one row; return its stamp."""
        message = self._decode(raw)
        index = {name: k for k, name in reversed(list(enumerate(message.name)))}
        self.there.update(dict.fromkeys(message.name))
        named[:] = [name in index for name in self.names]
        for i, field in enumerate(FIELDS):
            given = getattr(message, field)
            for column, name in enumerate(self.names):
                k = index.get(name, len(given))
                if k < len(given):
                    values[i * len(self.names) + column] = given[k]
        stamp = message.header.stamp
        return stamp.sec * 1_000_000_000 + stamp.nanosec


def encode_joint_states(stamp_ns, names, position=None, velocity=None, effort=None, frame_id=''):
    """
    Return the CDR bytes of N joint states, a list of bytes.

    `stamp_ns` int[N]; `names` J joints; position, velocity, effort float[N, J], each None when
    the messages leave that field empty.
    """
    stamp_ns = np.asarray(stamp_ns, np.int64)
    head = bytearray(LITTLE_ENDIAN + bytes(8))
    _put_text(head, frame_id)
    _put_count(head, len(names))
    for name in names:
        _put_text(head, name)
    offsets = {}
    values = {'position': position, 'velocity': velocity, 'effort': effort}
    for field, array in values.items():
        if array is None or not len(names):
            _put_count(head, 0)
            continue
        _put_count(head, len(names))
        head.extend(bytes(_aligned(len(head), 8) - len(head)))
        offsets[field] = len(head)
        head.extend(bytes(8 * len(names)))
    record = np.dtype({
        'names': ['sec', 'nanosec', *offsets],
        'formats': ['<i4', '<u4', *(('<f8', (len(names),)) for _ in offsets)],
        'offsets': [4, 8, *offsets.values()],
        'itemsize': len(head),
    })
    data, size = head * len(stamp_ns), len(head)
    table = np.frombuffer(data, record)
    table['sec'], table['nanosec'] = np.divmod(stamp_ns, 1_000_000_000)
    for field in offsets:
        table[field] = np.asarray(values[field], float).reshape(len(stamp_ns), len(names))
    return [bytes(data[k:k + size]) for k in range(0, len(data), size)]


def _put_count(head, count):
    head.extend(bytes(_aligned(len(head), 4) - len(head)))
    head.extend(struct.pack('<I', count))


def _put_text(head, text):
    data = text.encode() + b'\x00'
    _put_count(head, len(data))
    head.extend(data)
