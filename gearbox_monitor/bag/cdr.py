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

FIELDS = ('position', 'velocity', 'effort')
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
MAX_ITEMS = 1 << 20  # no joint state is larger: guards against declared sizes in damaged data


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
    """Where the fields of one serialised joint state are, and the bytes that say so."""

    names: tuple
    offsets: tuple     # byte offset of position, velocity, effort
    counts: tuple      # number of values of each
    fixed: np.ndarray  # int[K], offsets of the bytes that decide the layout
    size: int


def read_layout(raw):
    """Return the Layout of the little-endian CDR bytes `raw`, None when they are none."""
    try:
        if raw[:4] != LITTLE_ENDIAN:
            return None
        fixed, offsets, counts, names = [range(4)], [], [], []
        text, at = _read_text(raw, 12, fixed)  # frame_id
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
    return Layout(tuple(names), tuple(offsets), tuple(counts),
                  np.concatenate([np.asarray(r, int) for r in fixed]), at)


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


def decode_run(raws, layout, names, into, rows):
    """
    Decode the messages of `raws` that share `layout`, all of the same length.

    `into` holds stamp_ns, named, position, velocity, effort; decoded messages go to its `rows`
    (int[n]). Returns bool[n], which messages were decoded.
    """
    size = len(raws[0])
    table = np.frombuffer(b''.join(raws), np.uint8).reshape(len(raws), size)
    same = (table[:, layout.fixed] == table[0, layout.fixed]).all(axis=1)
    if not same.all():
        table, rows = np.ascontiguousarray(table[same]), rows[same]
    record = np.dtype({
        'names': ['sec', 'nanosec', *FIELDS],
        'formats': ['<i4', '<u4', *(('<f8', (count,)) for count in layout.counts)],
        'offsets': [4, 8, *layout.offsets],
        'itemsize': size,
    })
    values = table.view(record)[:, 0]
    into['stamp_ns'][rows] = values['sec'].astype(np.int64) * 1_000_000_000 + values['nanosec']
    index = {name: k for k, name in reversed(list(enumerate(layout.names)))}
    into['named'][rows] = [name in index for name in names]
    for field, count in zip(FIELDS, layout.counts):
        for column, name in enumerate(names):
            k = index.get(name, count)
            if k < count:
                into[field][rows, column] = values[field][:, k]
    return same


def decode_message(message, names, into, row):
    """Decode one deserialised joint state `message` into `row`."""
    stamp = message.header.stamp
    into['stamp_ns'][row] = stamp.sec * 1_000_000_000 + stamp.nanosec
    index = {name: k for k, name in reversed(list(enumerate(message.name)))}
    into['named'][row] = [name in index for name in names]
    for field in FIELDS:
        values = getattr(message, field)
        for column, name in enumerate(names):
            k = index.get(name, len(values))
            if k < len(values):
                into[field][row, column] = values[k]


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
