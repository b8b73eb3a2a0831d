# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One MCAP file of a bag that is being written."""
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gearbox_monitor.bag.mcap_writer import McapWriter, Span
from gearbox_monitor.bag.message_block import MessageBlock
from gearbox_monitor.bag.metadata import QosProfile
from gearbox_monitor.bag.record_file import RecordFile


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
    """New MCAP file `path`, its chunks packed by `compression`; methods raise OSError."""

    def __init__(self, path: Path, compression: str) -> None:
        self.path = path
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self.file = RecordFile(path)
        # Only finish_chunk() ends a chunk, so that it is known which messages are on the disk.
        self._writer = McapWriter(self.file, compression)

    @property
    def span(self) -> Span | None:
        """First and last log time, None without a message."""
        return self._writer.span

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(self._writer.counts.values())

    @property
    def counts(self) -> dict[str, int]:
        """Map of topic to number of messages."""
        return {topic: self._writer.counts.get(channel, 0)
                for topic, channel in self._channels.items()}

    def start(self) -> None:
        """Write the header."""
        self._writer.start('ros2')

    def add_topic(self, topic: McapTopic) -> None:
        """Write the schema and the channel of `topic`."""
        if topic.msgtype not in self._schemas:
            self._schemas[topic.msgtype] = self._writer.add_schema(
                topic.msgtype, topic.schema_encoding, topic.schema)
        self._channels[topic.name] = self._writer.add_channel(
            topic.name, topic.encoding, self._schemas[topic.msgtype], topic.channel_metadata)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
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
        self._writer.add_message(self._channels[topic], log_ns, cdr_bytes, publish_ns, sequence)

    def write_block(self, block: MessageBlock) -> None:
        """Add the messages of `block` to the chunk, in its order."""
        self._writer.add_block(block, np.array([self._channels.get(topic, 0)
                                                for topic in block.topics]))

    def finish_chunk(self) -> None:
        """Write the chunk."""
        self._writer.finish_chunk()

    def finish(self) -> None:
        """Write index and footer."""
        self._writer.finish()
