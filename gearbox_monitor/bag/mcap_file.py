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

"""
Scan one MCAP file record by record, whole or cut anywhere.

mcap's own readers need the footer or stop with an exception at the cut; here every record and
every chunk before the cut counts, and of a cut chunk all messages that can still be unpacked.
"""
from dataclasses import dataclass, field
from io import BytesIO
import mmap
import struct
import zlib

import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
import numpy as np
import zstandard

from gearbox_monitor.errors import InputError

MAGIC = b'\x89MCAP0\r\n'
RECORD = struct.Struct('<BQ')
MESSAGE = struct.Struct('<BQHIQQ')  # opcode, length, channel, sequence, log time, publish time
CHUNK = struct.Struct('<QQQII')  # start, end, unpacked size, CRC, length of compression name
PIECE = 1 << 24  # bytes unpacked at a time: a declared size is never allocated at once
LOOSE_BYTES = 1 << 22  # messages outside chunks are grouped into runs of about this size
DAMAGE = (McapError, struct.error, UnicodeDecodeError, ValueError, MemoryError, EOFError)


@dataclass
class Chunk:
    """Part of the file that holds messages."""

    begin: int          # offset of the packed data
    end: int            # offset behind it
    compression: str
    unpacked_size: int
    crc: int
    start_ns: int = 0   # log times of its messages
    end_ns: int = 0
    whole: bool = True
    counts: dict = field(default_factory=dict)  # channel id: number of messages
    index: dict = field(default_factory=dict)   # channel id: (offset, bytes) of its index


class McapFile:
    """
    The chunks, channels and metadata of one file.

    `truncated` says that the file has no footer, `damaged` lists what could not be read.
    """

    def __init__(self, path):
        self.path = path
        self.truncated = True
        self.damaged = []
        self.schemas, self.channels = {}, {}
        self.metadata = {}
        self.chunks = []
        try:
            with open(path, 'rb') as file:
                size = file.seek(0, 2)
                if not size:
                    raise InputError(f'{path}: the file is empty, expected an MCAP recording')
                self._data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise InputError(f'{path}: cannot read: {error.strerror}') from None
        if self._data[:len(MAGIC)] != MAGIC:
            raise InputError(f'{path}: not an MCAP file (no MCAP magic at its start)')
        self._scan()

    def close(self):
        self._data.close()

    def messages(self, chunk, channels):
        """
        Return the messages of `chunk` on the channel ids `channels` in file order.

        A list of (log_ns, publish_ns, channel id, bytes).
        """
        data = self._unpacked(chunk)
        offsets = self._indexed(chunk, channels, data) if chunk.index else None
        if offsets is None:
            return [(log, publish, channel, body) for log, publish, channel, body
                    in self._walk(data) if channel in channels]
        found = []
        for at in offsets:
            opcode, length, channel, _, log, publish = MESSAGE.unpack_from(data, at)
            found.append((log, publish, channel, data[at + 31:at + 9 + length]))
        return found

    def _scan(self):
        """Read the file's structure; stop quietly where it is cut."""
        data, size, at = self._data, len(self._data), len(MAGIC)
        chunk, loose = None, None
        while at + 9 <= size:
            opcode, length = RECORD.unpack_from(data, at)
            body, following = at + 9, at + 9 + length
            if not opcode:
                break  # preallocated space behind a crash
            if opcode == Opcode.CHUNK:
                chunk = self._read_chunk(body, min(following, size), following <= size)
            elif following > size:
                break
            elif opcode == Opcode.MESSAGE:
                loose = self._extend(loose, at, following)
            elif opcode == Opcode.MESSAGE_INDEX and chunk is not None:
                channel, count = struct.unpack_from('<HI', data, body) if length >= 6 else (0, 0)
                if count + 6 == length and count % 16 == 0:
                    chunk.index[channel] = (body + 6, count)
                    chunk.counts[channel] = count // 16
            elif opcode == Opcode.FOOTER:
                self.truncated = data[following:] != MAGIC
                break
            else:
                self._define(opcode, data[body:following])
            if opcode != Opcode.MESSAGE:
                loose = None
            at = following
        if self.truncated and chunk is not None:
            chunk.counts = {}  # the cut may be amid its index
        for part in self.chunks:
            self._complete(part)
        self.chunks = [part for part in self.chunks if part.counts]

    def _read_chunk(self, body, end, whole):
        data = self._data
        try:
            start_ns, end_ns, unpacked, crc, length = CHUNK.unpack_from(data, body)
            at = body + CHUNK.size
            compression = data[at:at + length].decode()
            (packed,) = struct.unpack_from('<Q', data, at + length)
            at += length + 8
        except (struct.error, UnicodeDecodeError):
            return None
        if whole and at + packed != end:
            self.damaged.append(f'chunk at byte {body - 9}')
            return None
        chunk = Chunk(at, end, compression, unpacked, crc, start_ns, end_ns, whole)
        self.chunks.append(chunk)
        return chunk

    def _extend(self, loose, at, following):
        """Add the message record at `at` to the run `loose` of messages outside chunks."""
        if loose is None or following - loose.begin > LOOSE_BYTES:
            loose = Chunk(at, at, '', 0, 0)
            self.chunks.append(loose)
        loose.end = following
        loose.unpacked_size = following - loose.begin
        return loose

    def _complete(self, chunk):
        """Find out what `chunk` holds where its index does not tell or names new channels."""
        if chunk.counts and all(channel in self.channels for channel in chunk.counts):
            return
        counts, times = {}, []
        for log, _, channel, _ in self._walk(self._unpacked(chunk), define=True):
            counts[channel] = counts.get(channel, 0) + 1
            times.append(log)
        if counts != chunk.counts:
            chunk.counts, chunk.index = counts, {}
        if times:
            chunk.start_ns, chunk.end_ns = min(times), max(times)

    def _walk(self, data, define=False):
        """Yield (log_ns, publish_ns, channel, bytes) of the whole records in unpacked `data`."""
        at, size = 0, len(data)
        while at + 9 <= size:
            opcode, length = RECORD.unpack_from(data, at)
            following = at + 9 + length
            if following > size or not opcode:
                return
            if opcode == Opcode.MESSAGE and length >= 22:
                _, _, channel, _, log, publish = MESSAGE.unpack_from(data, at)
                yield log, publish, channel, data[at + 31:following]
            elif define:
                self._define(opcode, data[at + 9:following])
            at = following

    def _define(self, opcode, body):
        """Take in a schema, channel or metadata record."""
        kinds = {Opcode.SCHEMA: (Schema, self.schemas), Opcode.CHANNEL: (Channel, self.channels)}
        try:
            if opcode in kinds:
                kind, known = kinds[opcode]
                record = kind.read(ReadDataStream(BytesIO(body)))
                known.setdefault(record.id, record)
            elif opcode == Opcode.METADATA:
                record = Metadata.read(ReadDataStream(BytesIO(body)))
                self.metadata[record.name] = dict(record.metadata)
        except DAMAGE:
            self.damaged.append(f'{Opcode(opcode).name.lower()} record')

    def _indexed(self, chunk, channels, data):
        """Return the sorted offsets that the index gives, None unless each is such a message."""
        parts = []
        for channel in channels:
            begin, size = chunk.index.get(channel, (0, 0))
            table = np.frombuffer(self._data, '<u8', size // 8, begin)
            offsets = table[1::2].astype(np.int64)
            for at in offsets.tolist():
                if not 0 <= at <= len(data) - MESSAGE.size:
                    return None
                opcode, length, found = struct.unpack_from('<BQH', data, at)
                if (opcode, found) != (Opcode.MESSAGE, channel) or at + 9 + length > len(data):
                    return None
            parts.append(offsets)
        return np.sort(np.concatenate(parts)).tolist() if parts else []

    def _unpacked(self, chunk):
        """Return the records of `chunk`; of a cut or damaged one as much as can be had."""
        packed = self._data[chunk.begin:chunk.end]
        data, problem = _unpack(packed, chunk.compression, chunk.unpacked_size)
        if chunk.whole and not problem:
            if len(data) != chunk.unpacked_size:
                problem = f'{len(data)} bytes instead of {chunk.unpacked_size}'
            elif chunk.crc and zlib.crc32(data) != chunk.crc:
                problem = 'wrong checksum'
                data = b''
        if problem and chunk.whole:
            text = f'chunk at byte {chunk.begin}: {problem}'
            if text not in self.damaged:
                self.damaged.append(text)
        return data


def _unpack(packed, compression, size):
    """Return (as many of `size` bytes as can be unpacked, what went wrong or None)."""
    if compression == '':
        return packed[:size], None
    pieces, total = [], 0
    try:
        if compression == 'zstd':
            source = zstandard.ZstdDecompressor().stream_reader(packed)
            read = source.read
        elif compression == 'lz4':
            source = lz4.frame.LZ4FrameFile(BytesIO(packed))
            read = source.read1
        else:
            return b'', f'unknown compression {compression!r}'
        while total < size:
            piece = read(min(PIECE, size - total))
            if not piece:
                break
            pieces.append(piece)
            total += len(piece)
    except (zstandard.ZstdError, RuntimeError, EOFError, MemoryError) as error:
        return b''.join(pieces), str(error) or type(error).__name__
    return b''.join(pieces), None
