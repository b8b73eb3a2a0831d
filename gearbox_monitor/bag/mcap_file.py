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
import os
import struct
import zlib

import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
import numpy as np
import zstandard

from gearbox_monitor.bag.message_block import CHANNELS, find_messages, MESSAGE_HEAD
from gearbox_monitor.errors import InputError

MAGIC = b'\x89MCAP0\r\n'
RECORD = struct.Struct('<BQ')
CHUNK = struct.Struct('<QQQII')  # start, end, unpacked size, CRC, length of compression name
WINDOW = 1 << 14  # bytes of the file read at once while its structure is looked at
PIECE = 1 << 24  # bytes unpacked at a time: a declared size is never allocated at once
EXPANSION = 256  # no whole chunk of data unpacks to more times its size, lz4 to 255 at most
LOOSE_BYTES = 1 << 20  # messages outside chunks are grouped into runs of about this size
DAMAGE = (McapError, struct.error, UnicodeDecodeError, ValueError, MemoryError, EOFError)
ALL_CHANNELS = np.arange(CHANNELS, dtype=np.int32)


@dataclass(slots=True)
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


class McapFile:
    """
    The chunks, channels and metadata of one file.

    `truncated` says that the file has no footer, `damaged` lists what could not be read, `torn`
    where and when: {offset of the packed data: (first, last log time)} of cut and damaged chunks,
    as their heads tell. The file is read, not mapped: what is mapped would count as memory in use,
    and a file that is cut while it is read would end the process.
    """

    def __init__(self, path):
        self.path = path
        self.truncated = True
        self.damaged = []
        self.torn = {}
        self.schemas, self.channels = {}, {}
        self.metadata = {}
        self.chunks = []
        self._window_at, self._window = 0, b''
        try:
            self._file = open(path, 'rb', buffering=0)
        except OSError as error:
            raise InputError(f'{path}: cannot read: {error.strerror}') from None
        try:
            self._size = self._file.seek(0, os.SEEK_END)
            if not self._size:
                raise InputError(f'{path}: the file is empty, expected an MCAP recording')
            if self._near(0, len(MAGIC)) != MAGIC:
                raise InputError(f'{path}: not an MCAP file (no MCAP magic at its start)')
            self._scan()
        except OSError as error:
            self.close()
            raise InputError(f'{path}: cannot read: {error.strerror}') from None
        except InputError:
            self.close()
            raise

    def close(self):
        self._file.close()

    def unpacked(self, chunk):
        """Return the records of `chunk`; of a cut or damaged one as much as can be had."""
        packed = self._read(chunk.begin, chunk.end)
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
                self.torn[chunk.begin] = (chunk.start_ns, chunk.end_ns)
        return data

    def _read(self, begin, end):
        """Return the bytes begin .. end - 1 of the file, fewer where it ends before."""
        try:
            self._file.seek(begin)
            data = self._file.read(end - begin)
            while len(data) < end - begin:
                more = self._file.read(end - begin - len(data))
                if not more:
                    break
                data += more
        except OSError as error:
            raise InputError(f'{self.path}: cannot read: {error.strerror}') from None
        return data

    def _near(self, begin, size):
        """Return what _read does, for few bytes near those asked for before."""
        at = begin - self._window_at
        if at < 0 or at + size > len(self._window):
            self._window_at, at = begin, 0
            self._window = self._read(begin, begin + max(size, WINDOW))
        return self._window[at:at + size]

    def _scan(self):
        """Read the file's structure; stop quietly where it is cut."""
        size, at = self._size, len(MAGIC)
        chunk, loose = None, None
        while at + RECORD.size <= size:
            opcode, length = RECORD.unpack(self._near(at, RECORD.size))
            body, following = at + RECORD.size, at + RECORD.size + length
            if not opcode:
                break  # preallocated space behind a crash
            if opcode == Opcode.CHUNK:
                chunk = self._read_chunk(body, min(following, size), following <= size)
            elif following > size:
                break
            elif opcode == Opcode.MESSAGE:
                loose = self._extend(loose, at, following)
            elif opcode == Opcode.MESSAGE_INDEX and chunk is not None:
                if length >= 6:
                    channel, count = struct.unpack('<HI', self._near(body, 6))
                    if count + 6 == length and count % 16 == 0:
                        chunk.counts[channel] = count // 16
            elif opcode == Opcode.FOOTER:
                end = min(size, following + len(MAGIC) + 1)
                self.truncated = self._read(following, end) != MAGIC
                break
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA):
                self._define(opcode, self._read(body, following))
            if opcode != Opcode.MESSAGE:
                loose = None
            at = following
        if self.truncated and chunk is not None:
            chunk.counts = {}  # the cut may be amid its index
        for part in self.chunks:
            self._complete(part)
        self.chunks = [part for part in self.chunks if part.counts]

    def _read_chunk(self, body, end, whole):
        try:
            start_ns, end_ns, unpacked, crc, length = CHUNK.unpack(
                self._near(body, min(CHUNK.size, end - body)))
            at = body + CHUNK.size
            compression = self._near(at, min(length, end - at)).decode()
            (packed,) = struct.unpack('<Q', self._near(at + length, 8))
            at += length + 8
        except (struct.error, UnicodeDecodeError):
            return None
        if whole and at + packed != end:
            self.damaged.append(f'chunk at byte {body - RECORD.size}')
            return None
        chunk = Chunk(at, end, compression, unpacked, crc, start_ns, end_ns, whole)
        self.chunks.append(chunk)
        if not whole:
            self.torn[chunk.begin] = (start_ns, end_ns)
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
        raw = self.unpacked(chunk)
        rows = len(raw) // MESSAGE_HEAD
        integers = np.empty((2, rows), np.int64)
        channels, times = np.empty(rows, np.int32), np.empty((2, rows), np.uint64)
        data, row, at = np.frombuffer(raw, np.uint8), 0, 0
        while True:
            row, at = find_messages(data, at, len(raw), ALL_CHANNELS, True, row, *integers,
                                    channels, *times)
            if at + RECORD.size > len(raw):
                break
            opcode, length = RECORD.unpack_from(raw, at)
            following = at + RECORD.size + length
            if not opcode or following > len(raw):
                break
            self._define(opcode, raw[at + RECORD.size:following])
            at = following
        found, counts = np.unique(channels[:row], return_counts=True)
        chunk.counts = dict(zip(found.tolist(), counts.tolist()))
        if row:
            log_ns = times[0, :row].view(np.int64)
            chunk.start_ns, chunk.end_ns = int(log_ns.min()), int(log_ns.max())

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


def _unpack(packed, compression, size):
    """Return (as many of `size` bytes as can be unpacked, what went wrong or None)."""
    if compression == '':
        return packed[:size], None
    if compression not in ('zstd', 'lz4'):
        return b'', f'unknown compression {compression!r}'
    if 0 < size <= min(PIECE, EXPANSION * len(packed)):
        data = _unpack_whole(packed, compression, size)
        if data is not None:
            return data, None
    return _unpack_piecewise(packed, compression, size)


def _unpack_whole(packed, compression, size):
    """Return the `size` bytes that a whole frame unpacks to, None where it is no such frame."""
    try:
        if compression == 'lz4':
            data = lz4.frame.LZ4FrameDecompressor().decompress(packed, size)
        elif zstandard.frame_content_size(packed) in (size, -1):  # -1: it does not say
            data = zstandard.ZstdDecompressor().decompress(packed, size)
        else:
            return None
    except (zstandard.ZstdError, RuntimeError, EOFError, MemoryError):
        return None
    return data if len(data) == size else None


def _unpack_piecewise(packed, compression, size):
    """Return what _unpack does, of damaged and cut frames, too."""
    pieces, total = [], 0
    try:
        if compression == 'zstd':
            read = zstandard.ZstdDecompressor().stream_reader(packed).read
        else:
            read = lz4.frame.LZ4FrameFile(BytesIO(packed)).read1
        while total < size:
            piece = read(min(PIECE, size - total))
            if not piece:
                break
            pieces.append(piece)
            total += len(piece)
    except (zstandard.ZstdError, RuntimeError, EOFError, MemoryError) as error:
        return b''.join(pieces), str(error) or type(error).__name__
    return b''.join(pieces), None
