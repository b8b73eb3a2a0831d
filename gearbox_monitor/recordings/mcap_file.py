# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
MCAP files: scan one record by record, complete or cut anywhere; write records into a new one.

The writer puts messages one by one or as a block into chunks with their indexes, and syncs whole
records to the medium from a thread of its own.
"""
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from io import BytesIO
import os
from pathlib import Path
import struct
from threading import Event, Thread
from typing import Any, TypeAlias
import zlib

import lz4.frame
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, McapRecord, Metadata, MetadataIndex,
    Schema, Statistics, SummaryOffset)
import numpy as np
import zstandard

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import open_file
from gearbox_monitor.recordings.cdr import (
    CHANNELS, empty_index, find_messages, gathered, MESSAGE, MESSAGE_HEAD, MessageBlock)
from gearbox_monitor.recordings.storage import BagTopic, MAX_UNPACKED, Part, unpack, unpacked_limit

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
class ScannedChunk:
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
    The chunks, channels and metadata of the file `path`.

    `truncated`: the file has no footer. `damaged`: what could not be read. `torn`: {offset of the
    packed data: (first, last log time)} of cut and damaged chunks, from their heads. close:
    releases the file. It is read, not mapped: a mapping would count as memory in use, and a file
    that is cut while it is mapped would end the process.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.truncated = True
        self.damaged: list[str] = []
        self.torn: dict[int, tuple[int, int]] = {}
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.chunks: list[ScannedChunk] = []
        self._definitions = 0  # bytes
        with ExitStack() as stack:
            try:
                self._file = stack.enter_context(open_file(path, WINDOW))
                self._size = self._file.seek(0, os.SEEK_END)
            except OSError as error:
                raise InputError(f'{self.path}: cannot read: {error.strerror}') from None
            if not self._size:
                raise InputError(f'{self.path}: the file is empty, expected an MCAP recording')
            if self._read(0, len(MAGIC)) != MAGIC:
                raise InputError(f'{self.path}: not an MCAP file (no MCAP magic at its start)')
            self._scan()
            self.close = stack.pop_all().close

    def unpacked(self, chunk: ScannedChunk) -> bytes:
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

    def _checked(self, chunk: ScannedChunk, packed: bytes) -> tuple[bytes, str | None]:
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

    def _scan(self) -> None:
        """Read the file's structure; stop silently where it is cut."""
        size, offset = self._size, len(MAGIC)
        chunk: ScannedChunk | None = None
        loose: ScannedChunk | None = None
        while offset + RECORD.size <= size:
            opcode, length = RECORD.unpack(self._read(offset, offset + RECORD.size))
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
                self._count(chunk, body, length)
            elif opcode == Opcode.FOOTER:
                end = min(size, following + len(MAGIC) + 1)
                self.truncated = self._read(following, end) != MAGIC
                break
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA):
                self._define_bounded(opcode, body, following)
            if opcode != Opcode.MESSAGE:
                loose = None
            offset = following
        if self.truncated and chunk is not None:
            chunk.counts = {}  # the cut may be amid its index
        for chunk in self.chunks:
            self._complete(chunk)
        self.chunks = [chunk for chunk in self.chunks if chunk.counts]

    def _count(self, chunk: ScannedChunk, body: int, length: int) -> None:
        """Add the number of messages that the index at `body`, of `length` bytes, states."""
        if length >= 6:
            channel, count = struct.unpack('<HI', self._read(body, body + 6))
            if count + 6 == length and count % 16 == 0:
                chunk.counts[channel] = count // 16

    def _read_chunk(self, body: int, end: int, whole: bool) -> ScannedChunk | None:
        try:
            start_ns, end_ns, unpacked, crc, length = CHUNK.unpack(
                self._read(body, min(body + CHUNK.size, end)))
            begin = body + CHUNK.size
            if length > LONGEST_NAME:
                return None
            compression = self._read(begin, min(begin + length, end)).decode()
            (packed,) = struct.unpack('<Q', self._read(begin + length, begin + length + 8))
            begin += length + 8
        except (struct.error, UnicodeDecodeError):
            return None
        if whole and begin + packed != end:
            self.damaged.append(f'chunk at byte {body - RECORD.size}')
            return None
        chunk = ScannedChunk(begin, end, compression, unpacked, crc, start_ns, end_ns, whole)
        self.chunks.append(chunk)
        if not whole:
            self.torn[chunk.begin] = (start_ns, end_ns)
        return chunk

    def _extend(self, loose: ScannedChunk | None, begin: int, following: int) -> ScannedChunk:
        """Add the message record at `begin` to the run `loose` of messages outside chunks."""
        if loose is None or following - loose.begin > LOOSE_BYTES:
            loose = ScannedChunk(begin, begin, '', 0, 0)
            self.chunks.append(loose)
        loose.end = following
        loose.unpacked_size = following - loose.begin
        return loose

    def _complete(self, chunk: ScannedChunk) -> None:
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

    def _define_bounded(self, opcode: int, begin: int, end: int) -> None:
        """Add the definition in the bytes begin .. end - 1, as long as they are not too many."""
        if self._definitions + end - begin > DEFINITIONS:
            self._damage(f'definitions of more than {DEFINITIONS >> 20} MB')
        else:
            self._define(opcode, self._read(begin, end))

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
    Return the part of `data`, read at `offset` of a file, before the first SECTOR of zeros.

    A crash leaves such a hole where a block never reached the medium. Zero bytes right before it
    count as part of it.
    """
    first = -offset % SECTOR
    sectors = np.frombuffer(data, np.uint8)[first:]
    sectors = sectors[:len(sectors) // SECTOR * SECTOR].reshape(-1, SECTOR)
    holes = np.flatnonzero(~sectors.any(axis=1))
    return data[:first + SECTOR * int(holes[0])].rstrip(b'\0') if len(holes) else data


class RecordFile:
    """
    Unbuffered new file `path`; after a failed write it still ends with a whole record.

    Args:
        path: of the file.
        sync_seconds: time between two syncs to the medium by a thread of its own, so that the
            writer need not wait; None: never.
        errors: of syncs, shared by all files of a bag; a write raises the first.

    end: bytes written; synced: those that are on the medium.
    """

    def __init__(self, path: Path, sync_seconds: float | None = None,
                 errors: list[OSError] | None = None) -> None:
        self.path, self.end, self.synced = path, 0, 0
        self._errors = [] if errors is None else errors
        self._file, self._done = open(path, 'xb', buffering=0), Event()
        self._thread = Thread(target=self._sync_until_done, args=(sync_seconds,), daemon=True)
        if sync_seconds is not None:
            self._thread.start()

    def write(self, data: bytes | bytearray) -> None:
        """Append the records `data`: all of them or, with an OSError, none."""
        if self._errors:
            raise self._errors[0]
        view = memoryview(data)
        try:
            while view:
                view = view[self._file.write(view):]
        except OSError:
            self._file.truncate(self.end)
            raise
        self.end += len(data)

    def _sync_until_done(self, seconds: float) -> None:
        while not self._done.wait(seconds):
            self._sync()
        self._sync()
        self._file.close()

    def _sync(self) -> None:
        """Sync the file, the first time with its folders, to the medium."""
        end = self.end
        if end == self.synced or self._errors:
            return
        try:
            os.fdatasync(self._file.fileno())
            if not self.synced:
                folder = os.path.dirname(self.path)
                sync_folder(folder)
                sync_folder(os.path.dirname(folder))
        except OSError as error:
            self._errors.append(error)
        else:
            self.synced = end

    def rescue_path(self) -> str:
        """Return the path of the content after the file was removed or moved, else ''."""
        if self._file.closed:
            return ''
        opened = os.fstat(self._file.fileno())
        with suppress(OSError):
            if os.path.samestat(os.stat(self.path), opened):
                return ''
        return f'/proc/{os.getpid()}/fd/{self._file.fileno()}'

    def close(self, wait: bool = True) -> None:
        """Close the file; its thread, for which one may `wait`, syncs it before."""
        self._done.set()
        if not self._thread.ident:
            self._file.close()
        elif wait:
            self._thread.join()


def sync_folder(path: str | Path) -> None:
    """Sync the names in the folder `path` to the medium."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


HEAD = struct.Struct('<BQHIQQ')  # opcode, length, channel, sequence, log time, publish time
HEADS = np.dtype([('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'), ('sequence', '<u4'),
                  ('log_ns', '<u8'), ('publish_ns', '<u8')])
INDEX = struct.Struct('<BQHI')  # opcode, length, channel, bytes of the entries
ENTRY = struct.Struct('<QQ')  # log time and offset of a message
# Level 1 packs estimates like level 3, in two thirds of the time.
ZSTD_LEVEL = 1
Span: TypeAlias = tuple[int, int]  # first and last log time


def _zstd(data: bytes | bytearray) -> bytes:
    return bytes(zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress(data))


# Compression -> (its name in MCAP, function that packs).
COMPRESSIONS: dict[str, tuple[str, Callable[[bytes | bytearray], bytes]]] = {
    'none': ('', bytes), 'lz4': ('lz4', lz4.frame.compress), 'zstd': ('zstd', _zstd)}


class McapWriter:
    """
    Writes the new MCAP file `path`, its chunks packed by `compression`, a key of COMPRESSIONS.

    A chunk ends with finish_chunk only, so that it is known which messages are on the disk. file:
    the new file, where it is synced.
    Methods raise OSError. span: first and last log time, None without a message.
    """

    def __init__(self, path: Path, compression: str, file: RecordFile | None = None) -> None:
        self.path, self.file = path, file or RecordFile(path)
        self.span: Span | None = None
        self._compression, self._pack = COMPRESSIONS[compression]
        self._schemas: dict[str, Schema] = {}  # by type
        self._channels: dict[str, Channel] = {}  # by topic
        self._counts: Counter[int] = Counter()  # messages by channel
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._begin()

    def _begin(self) -> None:
        """Begin a chunk."""
        self._records = bytearray()
        self._entries: dict[int, bytearray] = {}  # by channel
        self._chunk_span: Span | None = None

    @property
    def summary(self) -> Part:
        """Its name, first and last log time, and number of messages."""
        return self.path.name, self.span, sum(self._counts.values())

    @property
    def counts(self) -> dict[str, int]:
        """Map of topic to number of messages."""
        return {topic: self._counts[channel.id] for topic, channel in self._channels.items()}

    def start(self) -> None:
        """Write the header."""
        self.file.write(MAGIC + _bytes_of(Header('ros2', f'gearbox_monitor {__version__}')))

    def add_topic(self, topic: BagTopic) -> None:
        """Add the schema, once for each type, and the channel of `topic`."""
        if topic.msgtype not in self._schemas:
            schema = Schema(id=len(self._schemas) + 1, data=topic.schema,
                            encoding=topic.schema_encoding, name=topic.msgtype)
            self._schemas[topic.msgtype] = schema
            self._records += _bytes_of(schema)
        channel = Channel(id=len(self._channels) + 1, topic=topic.name,
                          message_encoding=topic.encoding, metadata=dict(topic.channel_metadata),
                          schema_id=self._schemas[topic.msgtype].id)
        self._channels[topic.name] = channel
        self._records += _bytes_of(channel)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write the metadata record `name` of `values` {key: text}."""
        record = _bytes_of(Metadata(name=name, metadata=dict(values)))
        self._metadata.append(MetadataIndex(self.file.end, len(record), name))
        self.file.write(record)

    def write(self, topic: str, log_ns: int, data: bytes, publish_ns: int, sequence: int) -> None:
        """
        Add a message to the chunk.

        Args:
            topic: name of a topic that was added.
            log_ns: when it was recorded, ns since the epoch.
            data: the message.
            publish_ns: when it was published, ns since the epoch.
            sequence: its number among the messages of its publisher, 0 if unknown.
        """
        channel = self._channels[topic].id
        self._counts[channel] += 1
        self._cover(log_ns, log_ns)
        self._entries.setdefault(channel, bytearray()).extend(
            ENTRY.pack(log_ns, len(self._records)))
        self._records += HEAD.pack(MESSAGE, MESSAGE_HEAD - RECORD.size + len(data), channel,
                                   sequence, log_ns, publish_ns)
        self._records += data

    def write_block(self, block: MessageBlock) -> None:
        """Add the messages of `block` in its order, without sequence numbers."""
        channels = np.array([self._channels[topic].id if topic in self._channels else 0
                             for topic in block.topics])
        sizes = block.size + MESSAGE_HEAD
        heads = np.zeros(len(block), HEADS)
        heads['opcode'], heads['length'] = MESSAGE, sizes - RECORD.size
        heads['channel'] = channels[block.topic]
        heads['log_ns'], heads['publish_ns'] = block.log_ns, block.publish_ns
        entries = np.column_stack([block.log_ns, len(self._records) + np.cumsum(sizes) - sizes])
        rows_of = [np.flatnonzero(block.topic == topic)
                   for topic in np.flatnonzero(np.bincount(block.topic))]
        for rows in sorted(rows_of, key=lambda rows: int(rows[0])):
            channel = int(channels[block.topic[rows[0]]])
            self._counts[channel] += len(rows)
            self._entries.setdefault(channel, bytearray()).extend(entries[rows].tobytes())
        self._cover(int(block.log_ns.min()), int(block.log_ns.max()))
        self._records.extend(gathered(
            block, heads.view(np.uint8).reshape(len(block), MESSAGE_HEAD)))

    def _cover(self, begin: int, end: int) -> None:
        """Widen the spans to log times from `begin` to `end`."""
        self.span = _widened(self.span, begin, end)
        self._chunk_span = _widened(self._chunk_span, begin, end)

    def finish_chunk(self) -> None:
        """Write the chunk, unless it holds no message, and its index: both or neither."""
        if self._chunk_span is None:
            return
        start_ns, end_ns = self._chunk_span
        packed, begin = self._pack(self._records), self.file.end
        chunk = _bytes_of(Chunk(
            compression=self._compression, data=packed, message_end_time=end_ns,
            message_start_time=start_ns, uncompressed_crc=zlib.crc32(self._records),
            uncompressed_size=len(self._records)))
        indexes, offsets = bytearray(), {}
        for channel, entries in self._entries.items():
            offsets[channel] = begin + len(chunk) + len(indexes)
            indexes += INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries))
            indexes += entries
        self.file.write(chunk + indexes)
        self._chunks.append(ChunkIndex(
            chunk_length=len(chunk), chunk_start_offset=begin, compression=self._compression,
            compressed_size=len(packed), message_end_time=end_ns,
            message_index_length=len(indexes), message_index_offsets=offsets,
            message_start_time=start_ns, uncompressed_size=len(self._records)))
        self._begin()

    def finish(self) -> None:
        """Write the last chunk, summary and footer."""
        self.finish_chunk()
        self.file.write(_bytes_of(DataEnd(0)))
        begin, summary, offsets = self.file.end, bytearray(), bytearray()
        groups: dict[Opcode, list[McapRecord]] = {
            Opcode.SCHEMA: [*self._schemas.values()], Opcode.CHANNEL: [*self._channels.values()],
            Opcode.STATISTICS: [self._statistics()], Opcode.CHUNK_INDEX: [*self._chunks],
            Opcode.METADATA_INDEX: [*self._metadata]}
        for opcode, records in groups.items():
            data = b''.join(map(_bytes_of, records))
            if data:
                offsets += _bytes_of(SummaryOffset(opcode, begin + len(summary), len(data)))
                summary += data
        footer = _bytes_of(Footer(begin, begin + len(summary), 0))
        summary += offsets + footer[:-4]  # the checksum covers all in front of it
        self.file.write(summary + struct.pack('<I', zlib.crc32(summary)) + MAGIC)

    def _statistics(self) -> Statistics:
        start_ns, end_ns = self.span or (0, 0)
        return Statistics(
            attachment_count=0, channel_count=len(self._channels),
            channel_message_counts=self._counts, chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()), message_end_time=end_ns,
            message_start_time=start_ns, metadata_count=len(self._metadata),
            schema_count=len(self._schemas))


def _widened(span: Span | None, begin: int, end: int) -> Span:
    """Return `span`, widened to log times from `begin` to `end`."""
    return (begin, end) if span is None else (min(span[0], begin), max(span[1], end))


def _bytes_of(record: McapRecord) -> bytes:
    """Return the bytes of `record`."""
    builder: Any = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
