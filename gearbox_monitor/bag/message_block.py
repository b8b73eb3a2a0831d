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

"""Where the messages stand in the unpacked bytes of MCAP chunks, as arrays."""
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.kernels.jit import COMPILED, jit, jit_inline

MESSAGE = 5  # opcode
RECORD_HEAD = 9  # opcode, length
MESSAGE_HEAD = 31  # ... channel, sequence, log time, publish time
CHANNELS = 1 << 16
U8, U9, U15, U23, U31 = (np.uint64(k) for k in (8, 9, 15, 23, 31))


# Bytes in one word; what is unsigned needs no check for an index from the end.
if COMPILED:
    @jit_inline
    def word(data, at):
        """Return the little-endian uint64 at data[at] (uint8 [N], uint64)."""
        value = np.uint64(0)
        for i in range(8):
            value |= np.uint64(data[at + np.uint64(i)]) << np.uint64(8 * i)
        return value
else:
    def word(data, at):
        """Return the little-endian uint64 at data[at] (uint8 [N], uint64)."""
        return np.uint64(int.from_bytes(data[at:at + U8].tobytes(), 'little'))


@jit
def find_messages(data, begin, end, topic_of, stop, row, at, size, topic, log_ns, publish_ns):
    """
    Note the messages in data[begin:end] from `row` on; return (next row, offset behind them).

    data uint8. topic_of int32 [CHANNELS]: number of each channel's topic; messages where it is
    negative are passed over. Written: at int64, first byte of the message, size int64, topic
    int32, log_ns and publish_ns uint64. Ends at a cut or damaged record and, where `stop` is true,
    at a record that is no message.
    """
    here, last = np.uint64(begin), np.uint64(end)
    while here + U9 <= last:
        length = word(data, here + np.uint64(1))
        if data[here] == 0 or length > last - here - U9:
            break
        if data[here] == MESSAGE and length >= np.uint64(22):
            number = topic_of[int(data[here + U9]) + 256 * int(data[here + np.uint64(10)])]
            if number >= 0:
                at[row], size[row] = here + U31, length - np.uint64(22)
                topic[row] = number
                log_ns[row] = word(data, here + U15)
                publish_ns[row] = word(data, here + U23)
                row += 1
        elif stop:
            break
        here += U9 + length
    return row, int(here)


@dataclass(frozen=True)
class MessageBlock:
    """
    N messages: data[at[i]:at[i] + size[i]] (uint8) on topics[topic[i]].

    at, size, log_ns, publish_ns int64 [N], topic int32 [N].
    """

    topics: tuple
    data: np.ndarray
    at: np.ndarray
    size: np.ndarray
    topic: np.ndarray
    log_ns: np.ndarray
    publish_ns: np.ndarray

    def __len__(self):
        return len(self.at)

    def raw(self, row):
        """Return the bytes of message `row`."""
        return self.data[self.at[row]:self.at[row] + self.size[row]].tobytes()

    def take(self, rows):
        """Return the MessageBlock of `rows` (indices or slice), of the same data."""
        return MessageBlock(self.topics, self.data, *(column[rows] for column in (
            self.at, self.size, self.topic, self.log_ns, self.publish_ns)))

    def of(self, topic):
        """Return the MessageBlock of the messages on `topic` alone."""
        if len(self.topics) == 1:
            return self
        return self.take(np.flatnonzero(self.topic == self.topics.index(topic)))

    def messages(self):
        """Yield (topic, log_ns, publish_ns, bytes)."""
        data = self.data.tobytes()
        for at, size, topic, log, publish in zip(*(column.tolist() for column in (
                self.at, self.size, self.topic, self.log_ns, self.publish_ns))):
            yield self.topics[topic], log, publish, data[at:at + size]


def block_of(topics, messages):
    """Return the MessageBlock of `messages`, a list of (topic, log_ns, publish_ns, bytes)."""
    number = {topic: k for k, topic in enumerate(topics)}
    size = np.array([len(raw) for *_, raw in messages], np.int64)
    return MessageBlock(
        tuple(topics), np.frombuffer(b''.join(raw for *_, raw in messages), np.uint8),
        np.cumsum(size) - size, size,
        np.array([number[topic] for topic, *_ in messages], np.int32),
        np.array([log for _, log, *_ in messages], np.int64),
        np.array([publish for *_, publish, _ in messages], np.int64))
