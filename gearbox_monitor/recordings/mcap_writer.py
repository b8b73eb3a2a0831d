# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write MCAP records: messages one by one or as a block, in chunks with their indexes.

The writer of the mcap package takes messages one by one, at three times the cost, and no finished
chunks; here a block of messages becomes records in one step.
"""
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
import struct
from typing import Any, TypeAlias
import zlib

import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, McapRecord, Metadata, MetadataIndex,
    Schema, Statistics, SummaryOffset)
import numpy as np
import zstandard

from gearbox_monitor import __version__
from gearbox_monitor.recordings.mcap_file import MAGIC, RECORD
from gearbox_monitor.recordings.message_block import gathered, MESSAGE, MESSAGE_HEAD, MessageBlock
from gearbox_monitor.recordings.metadata import BagTopic
from gearbox_monitor.recordings.record_file import RecordFile

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

    A chunk ends with finish_chunk only, so that it is known which messages are on the disk.
    Methods raise OSError. span: first and last log time, None without a message.
    """

    def __init__(self, path: Path, compression: str) -> None:
        self.path, self.file = path, RecordFile(path)
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
    def count(self) -> int:
        """Number of messages."""
        return sum(self._counts.values())

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
            message_count=self.count, message_end_time=end_ns,
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
