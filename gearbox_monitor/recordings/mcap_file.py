# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Scan one MCAP file record by record, complete or cut anywhere.

The readers of the mcap package need the footer or raise an exception at the cut. This one returns
every record and every chunk before the cut and, of a cut chunk, all messages that it can unpack. A
chunk takes no more memory than `unpacked_limit`, whatever size it states.
"""
from dataclasses import dataclass, field
from io import BytesIO
import os
from pathlib import Path
import struct
import zlib

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file
from gearbox_monitor.recordings.decompression import MAX_UNPACKED, unpack, unpacked_limit
from gearbox_monitor.recordings.message_block import (
    CHANNELS, empty_index, find_messages, MESSAGE_HEAD)

MAGIC = b'\x89MCAP0\r\n'
RECORD = struct.Struct('<BQ')
CHUNK = struct.Struct('<QQQII')  # start, end, unpacked size, CRC, length of compression name
WINDOW = 1 << 14  # bytes of the file read at once while its structure is scanned
SECTOR = 512  # bytes of the medium that were written, or were not and read as zeros
LONGEST_NAME = 64  # of a compression
DEFINITIONS = 1 << 26  # bytes of schemas, channels and metadata of a file
LOOSE_BYTES = 1 << 20  # messages outside chunks are grouped into runs of about this size
DAMAGE = (McapError, struct.error, UnicodeDecodeError, ValueError, MemoryError, EOFError)
ALL_CHANNELS = np.arange(CHANNELS, dtype=np.int32)


@dataclass(slots=True)
class Chunk:
    """Part of the file that holds messages."""

    begin: int          # offset of the packed data
    end: int            # offset behind the packed data
    compression: str
    unpacked_size: int
    crc: int
    start_ns: int = 0   # log times of its messages
    end_ns: int = 0
    whole: bool = True
    counts: dict[int, int] = field(default_factory=dict)  # channel id: number of messages


class McapFile:
    """
    The chunks, channels and metadata of the file `path`, called `shown` in messages.

    `truncated`: the file has no footer. `damaged`: what could not be read. `torn`: {offset of the
    packed data: (first, last log time)} of cut and damaged chunks, from their heads. The file is
    read, not mapped: a mapping would count as memory in use, and a file that is cut while it is
    mapped would end the process.
    """

    def __init__(self, path: Path, shown: Path | None = None) -> None:
        self.path = shown or path
        self.truncated = True
        self.damaged: list[str] = []
        self.torn: dict[int, tuple[int, int]] = {}
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.chunks: list[Chunk] = []
        self._window_offset, self._window = 0, b''
        self._definitions = 0  # bytes
        try:
            self._file = open_file(path)
        except OSError as error:
            raise InputError(f'{self.path}: cannot read: {error.strerror}') from None
        try:
            self._size = self._file.seek(0, os.SEEK_END)
            if not self._size:
                raise InputError(f'{self.path}: the file is empty, expected an MCAP recording')
            if self._near(0, len(MAGIC)) != MAGIC:
                raise InputError(f'{self.path}: not an MCAP file (no MCAP magic at its start)')
            self._scan()
        except OSError as error:
            self.close()
            raise InputError(f'{self.path}: cannot read: {error.strerror}') from None
        except InputError:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def unpacked(self, chunk: Chunk) -> bytes:
        """Return the records of `chunk`; of a cut or damaged one as much as can be unpacked."""
        packed = self._read(chunk.begin, min(chunk.end, chunk.begin + MAX_UNPACKED))
        data, problem = self._checked(chunk, packed)
        if problem and chunk.whole:
            written = _before_zeros(packed, chunk.begin)
            if len(written) < len(packed):
                data, _ = unpack(written, chunk.compression, chunk.unpacked_size)
                problem = f'zeros from byte {chunk.begin + len(written)} on'
            text = f'chunk at byte {chunk.begin}: {problem}'
            if text not in self.damaged:
                self.damaged.append(text)
                self.torn[chunk.begin] = (chunk.start_ns, chunk.end_ns)
        return data

    def _checked(self, chunk: Chunk, packed: bytes) -> tuple[bytes, str | None]:
        """Return (the records of `chunk` in its `packed` bytes, the problem or None)."""
        data, problem = unpack(packed, chunk.compression, chunk.unpacked_size)
        if chunk.whole and not problem:
            if len(data) != chunk.unpacked_size:
                limit = unpacked_limit(len(packed))
                return data, f'{len(data)} bytes instead of {chunk.unpacked_size}' + (
                    ', more than is unpacked' if chunk.unpacked_size > limit else '')
            if chunk.crc and zlib.crc32(data) != chunk.crc:
                return b'', 'wrong checksum'
        return data, problem

    def _read(self, begin: int, end: int) -> bytes:
        """Return the bytes begin .. end - 1 of the file, fewer at its end."""
        try:
            self._file.seek(begin)
            return self._file.read(end - begin)
        except OSError as error:
            raise InputError(f'{self.path}: cannot read: {error.strerror}') from None

    def _near(self, begin: int, size: int) -> bytes:
        """Return `size` bytes from `begin` on, from the window read last if they are in it."""
        offset = begin - self._window_offset
        if offset < 0 or offset + size > len(self._window):
            self._window_offset, offset = begin, 0
            self._window = self._read(begin, begin + max(size, WINDOW))
        return self._window[offset:offset + size]

    def _scan(self) -> None:
        """Read the file's structure; stop silently where it is cut."""
        size, offset = self._size, len(MAGIC)
        chunk: Chunk | None = None
        loose: Chunk | None = None
        while offset + RECORD.size <= size:
            opcode, length = RECORD.unpack(self._near(offset, RECORD.size))
            body, following = offset + RECORD.size, offset + RECORD.size + length
            if not opcode:
                break  # preallocated space behind a crash
            if opcode == Opcode.CHUNK:
                chunk = self._read_chunk(body, min(following, size), following <= size)
            elif following > size:
                break
            elif opcode == Opcode.MESSAGE:
                loose = self._extend(loose, offset, following)
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
                if self._definitions + length > DEFINITIONS:
                    self._damage(f'definitions of more than {DEFINITIONS >> 20} MB')
                else:
                    self._define(opcode, self._read(body, following))
            if opcode != Opcode.MESSAGE:
                loose = None
            offset = following
        if self.truncated and chunk is not None:
            chunk.counts = {}  # the cut may be amid its index
        for chunk in self.chunks:
            self._complete(chunk)
        self.chunks = [chunk for chunk in self.chunks if chunk.counts]

    def _read_chunk(self, body: int, end: int, whole: bool) -> Chunk | None:
        try:
            start_ns, end_ns, unpacked, crc, length = CHUNK.unpack(
                self._near(body, min(CHUNK.size, end - body)))
            begin = body + CHUNK.size
            if length > LONGEST_NAME:
                return None
            compression = self._near(begin, min(length, end - begin)).decode()
            (packed,) = struct.unpack('<Q', self._near(begin + length, 8))
            begin += length + 8
        except (struct.error, UnicodeDecodeError):
            return None
        if whole and begin + packed != end:
            self.damaged.append(f'chunk at byte {body - RECORD.size}')
            return None
        chunk = Chunk(begin, end, compression, unpacked, crc, start_ns, end_ns, whole)
        self.chunks.append(chunk)
        if not whole:
            self.torn[chunk.begin] = (start_ns, end_ns)
        return chunk

    def _extend(self, loose: Chunk | None, begin: int, following: int) -> Chunk:
        """Add the message record at `begin` to the run `loose` of messages outside chunks."""
        if loose is None or following - loose.begin > LOOSE_BYTES:
            loose = Chunk(begin, begin, '', 0, 0)
            self.chunks.append(loose)
        loose.end = following
        loose.unpacked_size = following - loose.begin
        return loose

    def _complete(self, chunk: Chunk) -> None:
        """Count the messages of a `chunk` without an index, or whose index names new channels."""
        if chunk.counts and all(channel in self.channels for channel in chunk.counts):
            return
        raw = self.unpacked(chunk)
        rows = len(raw) // MESSAGE_HEAD
        index = empty_index(rows)
        data, row, offset = np.frombuffer(raw, np.uint8), 0, 0
        while True:
            row, offset = find_messages(data, offset, len(raw), ALL_CHANNELS, True, row, index)
            if offset + RECORD.size > len(raw):
                break
            opcode, length = RECORD.unpack_from(raw, offset)
            following = offset + RECORD.size + length
            if not opcode or following > len(raw):
                break
            self._define(opcode, raw[offset + RECORD.size:following])
            offset = following
        channels, counts = np.unique(index.number[:row], return_counts=True)
        chunk.counts = dict(zip(channels.tolist(), counts.tolist()))
        if row:
            log_ns = index.log_ns[:row].view(np.int64)
            chunk.start_ns, chunk.end_ns = int(log_ns.min()), int(log_ns.max())

    def _define(self, opcode: int, body: bytes) -> None:
        """Add a schema, channel or metadata record."""
        stream = ReadDataStream(BytesIO(body))
        self._definitions += len(body)
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas.setdefault(schema.id, schema)
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                self.channels.setdefault(channel.id, channel)
            elif opcode == Opcode.METADATA:
                metadata = Metadata.read(stream)
                self.metadata[metadata.name] = dict(metadata.metadata)
        except DAMAGE:
            self._damage(f'{Opcode(opcode).name.lower()} record')

    def _damage(self, text: str) -> None:
        """Note once that something is damaged, in the words `text`."""
        if text not in self.damaged:
            self.damaged.append(text)


def _before_zeros(data: bytes, offset: int) -> bytes:
    """
    Return what of `data`, which stands at `offset` of a file, precedes a SECTOR of zeros.

    Such a hole is what a crash leaves of a block that never reached the medium. Bytes in front of
    it that are zero, too, are taken for part of it.
    """
    first = -offset % SECTOR
    sectors = np.frombuffer(data, np.uint8)[first:]
    sectors = sectors[:len(sectors) // SECTOR * SECTOR].reshape(-1, SECTOR)
    holes = np.flatnonzero(~sectors.any(axis=1))
    return data[:first + SECTOR * int(holes[0])].rstrip(b'\0') if len(holes) else data
