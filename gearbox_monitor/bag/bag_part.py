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

"""One MCAP file of a bag that is being written."""
from mcap.writer import CompressionType, Writer

from gearbox_monitor.bag.record_file import RecordFile

COMPRESSIONS = {
    'none': CompressionType.NONE,
    'lz4': CompressionType.LZ4,
    'zstd': CompressionType.ZSTD,
}


class BagPart:
    """
    New file `path`; methods raise OSError where it cannot be written.

    start_ns, end_ns: log times of its messages, None without one; counts: {topic: messages}.
    """

    def __init__(self, path, compression):
        self.path = path
        self.start_ns = self.end_ns = None
        self.counts = {}
        self._schemas, self._channels = {}, {}
        self.file = RecordFile(path)
        # Chunks are ended by finish_chunk() only, so that it is known what has reached the disk.
        self._writer = Writer(self.file, chunk_size=1 << 62,
                              compression=COMPRESSIONS[compression])

    @property
    def count(self):
        """Number of messages."""
        return sum(self.counts.values())

    def start(self):
        """Write the head."""
        self._writer.start(profile='ros2')

    def add_topic(self, topic):
        """Announce `topic` (write.McapTopic)."""
        if topic.msgtype not in self._schemas:
            self._schemas[topic.msgtype] = self._writer.register_schema(
                topic.msgtype, topic.schema_encoding, topic.schema)
        self._channels[topic.name] = self._writer.register_channel(
            topic.name, topic.encoding, self._schemas[topic.msgtype], topic.about)
        self.counts[topic.name] = 0

    def add_metadata(self, name, values):
        """Write a metadata record of {key: text}."""
        self._writer.add_metadata(name, values)

    def write(self, topic, log_ns, cdr_bytes, publish_ns, sequence):
        """Add one message to the chunk."""
        if self.start_ns is None:
            self.start_ns = self.end_ns = log_ns
        elif log_ns > self.end_ns:
            self.end_ns = log_ns
        elif log_ns < self.start_ns:
            self.start_ns = log_ns
        self.counts[topic] += 1
        self._writer.add_message(self._channels[topic], log_ns, cdr_bytes, publish_ns, sequence)

    def finish_chunk(self):
        """Write the chunk."""
        if hasattr(self._writer, 'flush'):
            self._writer.flush()
        else:  # mcap before 1.5 has no public way to end a chunk by time
            self._writer._Writer__finalize_chunk()

    def finish(self):
        """Write index and footer."""
        self._writer.finish()
