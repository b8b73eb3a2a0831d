# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Where the messages are in the unpacked bytes of MCAP chunks, as arrays."""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from gearbox_monitor.kernels.jit import COMPILED, jit, jit_inline
from gearbox_monitor.kernels.types import Integers

MESSAGE = 5  # opcode
MESSAGE_HEAD = 31  # opcode, length, channel, sequence, log time, publish time
CHANNELS = 1 << 16
U8, U9, U15, U23, U31 = (np.uint64(k) for k in (8, 9, 15, 23, 31))
Bytes: TypeAlias = npt.NDArray[np.uint8]
Numbers: TypeAlias = npt.NDArray[np.int32]  # of channels or topics
Message: TypeAlias = tuple[str, int, int, bytes]  # topic, log_ns, publish_ns, CDR bytes


# Bytes in one word; what is unsigned needs no check for an index from the end.
if COMPILED:
    @jit_inline
    def word(data: Any, offset: Any) -> Any:
        """Return the little-endian uint64 at data[offset] (`data` uint8 [N], `offset` uint64)."""
        value = np.uint64(0)
        for i in range(8):
            value |= np.uint64(data[offset + np.uint64(i)]) << np.uint64(8 * i)
        return value

    @jit_inline
    def copy(source: Any, begin: int, size: int, target: Any, place: int) -> None:
        """Copy source[begin:begin + size] to `target` from `place` on; both are uint8."""
        for i in range(size):
            target[np.uint64(place) + np.uint64(i)] = source[np.uint64(begin) + np.uint64(i)]
else:
    def copy(source: Any, begin: int, size: int, target: Any, place: int) -> None:
        """Copy source[begin:begin + size] to `target` from `place` on; both are uint8."""
        target[place:place + size] = source[begin:begin + size]

    def word(data: Any, offset: Any) -> Any:
        """Return the little-endian uint64 at data[offset] (`data` uint8 [N], `offset` uint64)."""
        return np.uint64(int.from_bytes(data[offset:offset + U8].tobytes(), 'little'))


class MessageIndex(NamedTuple):
    """Columns that find_messages fills, one row per message; number: of its topic or channel."""

    offset: Any      # int64 [rows], first byte of the message
    size: Any        # int64 [rows]
    number: Any      # int32 [rows]
    log_ns: Any      # uint64 [rows]
    publish_ns: Any  # uint64 [rows]


def empty_index(rows: int) -> MessageIndex:
    """Return a MessageIndex with room for `rows` messages."""
    offset, size = np.empty((2, rows), np.int64)
    log_ns, publish_ns = np.empty((2, rows), np.uint64)
    return MessageIndex(offset, size, np.empty(rows, np.int32), log_ns, publish_ns)


@jit
def find_messages(data: Any, begin: int, end: int, number_of: Any, stop: bool, row: int,
                  index: MessageIndex) -> tuple[int, int]:
    """
    Walk over the MCAP records in data[begin:end] and note its messages.

    Args:
        data: uint8 [N], unpacked records.
        begin: offset of the first record.
        end: offset behind the last one.
        number_of: int32 [CHANNELS], number to note for each channel; messages of a channel whose
            number is negative are skipped.
        stop: whether to stop at a record that is no message.
        row: first row of `index` to write.
        index: MessageIndex, written.

    Returns:
        (Next free row, offset behind the records read: of a cut or damaged one, of the one that
        stopped it, or `end`).
    """
    offset, last = np.uint64(begin), np.uint64(end)
    while offset + U9 <= last:
        length = word(data, offset + np.uint64(1))
        if data[offset] == 0 or length > last - offset - U9:
            break
        if data[offset] == MESSAGE and length >= np.uint64(22):
            number = number_of[int(data[offset + U9]) + 256 * int(data[offset + np.uint64(10)])]
            if number >= 0:
                index.offset[row], index.size[row] = offset + U31, length - np.uint64(22)
                index.number[row] = number
                index.log_ns[row] = word(data, offset + U15)
                index.publish_ns[row] = word(data, offset + U23)
                row += 1
        elif stop:
            break
        offset += U9 + length
    return row, int(offset)


@dataclass(frozen=True)
class MessageBlock:
    """N messages: data[offset[i]:offset[i] + size[i]] is on topics[topic[i]]."""

    topics: tuple[str, ...]
    data: Bytes
    offset: Integers      # [N]
    size: Integers        # [N]
    topic: Numbers        # [N]
    log_ns: Integers      # [N]
    publish_ns: Integers  # [N]

    def __len__(self) -> int:
        return len(self.offset)

    def raw(self, row: int) -> bytes:
        """Return the bytes of message `row`."""
        return self.data[self.offset[row]:self.offset[row] + self.size[row]].tobytes()

    def take(self, rows: slice | Integers) -> 'MessageBlock':
        """Return the MessageBlock of `rows` (indices or slice), of the same data."""
        return MessageBlock(self.topics, self.data, self.offset[rows], self.size[rows],
                            self.topic[rows], self.log_ns[rows], self.publish_ns[rows])

    def of(self, topic: str) -> 'MessageBlock':
        """Return the MessageBlock of the messages on `topic` alone."""
        if len(self.topics) == 1:
            return self
        return self.take(np.flatnonzero(self.topic == self.topics.index(topic)))

    def messages(self) -> Iterator[Message]:
        """Yield (topic, log_ns, publish_ns, bytes)."""
        data = self.data.tobytes()
        for offset, size, topic, log_ns, publish_ns in zip(*(column.tolist() for column in (
                self.offset, self.size, self.topic, self.log_ns, self.publish_ns))):
            yield self.topics[topic], log_ns, publish_ns, data[offset:offset + size]


@jit
def _gather(heads: Any, width: int, data: Any, block: Any, out: Any) -> None:
    """
    Write each head and the message behind it to `out`, one after the other.

    heads: uint8 [N * width]. data: uint8. block: (offsets [N], sizes [N]) in `data`. out: uint8.
    """
    offsets, sizes = block
    position = 0
    for k in range(offsets.shape[0]):
        copy(heads, k * width, width, out, position)
        copy(data, offsets[k], sizes[k], out, position + width)
        position += width + sizes[k]


def gathered(block: MessageBlock, heads: Bytes | None = None) -> Bytes:
    """Return the bytes of the messages of `block` in its order, behind `heads` [N, H] if any."""
    heads = np.empty((len(block), 0), np.uint8) if heads is None else heads
    out = np.empty(int(block.size.sum()) + heads.size, np.uint8)
    _gather(heads.ravel(), heads.shape[1], block.data, (block.offset, block.size), out)
    return out


def compact(block: MessageBlock) -> MessageBlock:
    """Return the `block` with the bytes of its own messages only."""
    return replace(block, data=gathered(block), offset=np.cumsum(block.size) - block.size)


def joined_blocks(blocks: Sequence[MessageBlock]) -> MessageBlock:
    """Return the messages of all `blocks`, which have the same topics, in order."""
    sizes = [len(block.data) for block in blocks]
    offsets = [block.offset + begin
               for block, begin in zip(blocks, np.cumsum([0, *sizes]).tolist())]
    return MessageBlock(
        blocks[0].topics, np.concatenate([block.data for block in blocks]),
        np.concatenate(offsets), *(
            np.concatenate([getattr(block, name) for block in blocks])
            for name in ('size', 'topic', 'log_ns', 'publish_ns')))


def block_of(topics: Sequence[str], messages: Sequence[Message]) -> MessageBlock:
    """Return the MessageBlock of `messages`, which are on `topics`."""
    number = {topic: k for k, topic in enumerate(topics)}
    size = np.array([len(raw) for *_, raw in messages], np.int64)
    return MessageBlock(
        tuple(topics), np.frombuffer(b''.join(raw for *_, raw in messages), np.uint8),
        np.cumsum(size) - size, size,
        np.array([number[topic] for topic, *_ in messages], np.int32),
        np.array([log_ns for _, log_ns, *_ in messages], np.int64),
        np.array([publish_ns for *_, publish_ns, _ in messages], np.int64))
