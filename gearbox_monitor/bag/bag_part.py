# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One MCAP file of a bag that is being written."""
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast, IO

from mcap.writer import CompressionType, Writer

from gearbox_monitor.bag.metadata import QosProfile
from gearbox_monitor.bag.record_file import RecordFile

COMPRESSIONS = {
    'none': CompressionType.NONE,
    'lz4': CompressionType.LZ4,
    'zstd': CompressionType.ZSTD,
}


@dataclass
class McapTopic:
    """A topic of a bag; schema: definition of its type; channel_metadata: of its channel."""

    name: str
    msgtype: str
    qos: list[QosProfile]
    type_hash: str
    schema: bytes
    channel_metadata: Mapping[str, str]
    schema_encoding: str = 'ros2msg'
    encoding: str = 'cdr'
    count: int = 0


class BagPart:
    """
    New MCAP file `path`, its chunks packed by `compression`; methods raise OSError.

    start_ns, end_ns: log times of its messages, None without one; counts: {topic: messages}.
    """

    def __init__(self, path: Path, compression: str) -> None:
        self.path = path
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self.counts: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self.file = RecordFile(path)
        # Only finish_chunk() ends a chunk, so that it is known which messages are on the disk.
        self._writer: Any = Writer(cast(IO[bytes], self.file), chunk_size=1 << 62,
                                   compression=COMPRESSIONS[compression])

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(self.counts.values())

    def start(self) -> None:
        """Write the header."""
        self._writer.start(profile='ros2')

    def add_topic(self, topic: McapTopic) -> None:
        """Write the schema and the channel of `topic`."""
        if topic.msgtype not in self._schemas:
            self._schemas[topic.msgtype] = self._writer.register_schema(
                topic.msgtype, topic.schema_encoding, topic.schema)
        self._channels[topic.name] = self._writer.register_channel(
            topic.name, topic.encoding, self._schemas[topic.msgtype],
            dict(topic.channel_metadata))
        self.counts[topic.name] = 0

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Write the metadata record `name` of `values` {key: text}."""
        self._writer.add_metadata(name, values)

    def write(self, topic: str, log_ns: int, cdr_bytes: bytes, publish_ns: int, sequence: int
              ) -> None:
        """
        Add one message to the chunk.

        Args:
            topic: name of a topic that was added.
            log_ns: when it was recorded, ns since the epoch.
            cdr_bytes: the serialised message.
            publish_ns: when it was published, ns since the epoch.
            sequence: its number among the messages of its publisher, 0 if unknown.
        """
        if self.start_ns is None or self.end_ns is None:
            self.start_ns = self.end_ns = log_ns
        elif log_ns > self.end_ns:
            self.end_ns = log_ns
        elif log_ns < self.start_ns:
            self.start_ns = log_ns
        self.counts[topic] += 1
        self._writer.add_message(self._channels[topic], log_ns, cdr_bytes, publish_ns, sequence)

    def finish_chunk(self) -> None:
        """Write the chunk."""
        if hasattr(self._writer, 'flush'):
            self._writer.flush()
        else:  # mcap before 1.5 has no public way to end a chunk by time
            self._writer._Writer__finalize_chunk()

    def finish(self) -> None:
        """Write index and footer."""
        self._writer.finish()
