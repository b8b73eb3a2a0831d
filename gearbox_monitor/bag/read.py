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

"""Read rosbag2 bags: directories, single ``.mcap`` files and what a crash has left of them."""
from functools import cached_property
import os
from pathlib import Path
import re
import sqlite3

import numpy as np
from rosbags.rosbag2 import Reader, ReaderError
from rosbags.typesys import get_types_from_idl, get_types_from_msg, get_typestore, Stores

from gearbox_monitor.bag import metadata
from gearbox_monitor.bag.cdr import Decoder, JointStates
from gearbox_monitor.bag.mcap_file import McapFile
from gearbox_monitor.bag.message_block import (
    block_of, CHANNELS, find_messages, MESSAGE_HEAD, MessageBlock)
from gearbox_monitor.errors import InputError

JOINT_STATE = 'sensor_msgs/msg/JointState'
BLOCK_BYTES = 1 << 20  # unpacked at once, or one chunk where that is larger
BLOCK_MESSAGES = 4096  # of a bag that comes message by message


def open_bag(path):
    """
    Return a BagReader of `path`: bag directory, ``.mcap`` or ``.db3`` file, whole or cut.

    Raises InputError when there is nothing to read.
    """
    path = Path(path)
    if os.path.isdir(path):
        files = _files_of(path)
        if any(file.suffix != '.mcap' for file in files):
            return RosbagsReader(path)
        return McapReader(path, files)
    if not os.path.exists(path):
        raise InputError(f'{path}: no such file or directory, expected a bag')
    if path.suffix == '.db3':
        return RosbagsReader(path)
    return McapReader(path, [path])


def _files_of(path):
    """
    Return the recordings of the bag directory `path` in order.

    The directory itself when rosbag2 has compressed the messages one by one.
    """
    content = metadata.read_information(path)  # if damaged, the recordings themselves tell all
    if content.get('compression_mode'):
        return [path]
    files = named_files(path, content)
    missing = [file for file in files if not os.path.isfile(file)]
    if missing:
        raise InputError(f'{missing[0]}: missing, but {path / metadata.FILE_NAME} names it')
    files = files or sorted([*path.glob('*.mcap'), *path.glob('*.db3')], key=natural)
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file, expected a bag directory')
    return files


def named_files(path, content):
    """Return the files of the bag directory `path` that its information `content` names."""
    return [_inside(path, str(name)) for name in content.get('relative_file_paths', ())]


def _inside(path, name):
    """Return the file `name` of the bag directory `path`: never one outside of it."""
    file = path / name
    if '..' not in file.parts and file.is_relative_to(path) and os.path.exists(file):
        return file
    # Before 2020 these paths were relative to the directory that holds the bag.
    return path / Path(name).name


def natural(path):
    """Return a key that sorts bag_2 before bag_10."""
    return [int(part) if part.isdigit() else part for part in re.split(r'(\d+)', path.name)]


class BagReader:
    """
    What all bags have in common.

    topics: {topic: (message type, number of messages)}; metadata: {record name: {key: value}};
    start_ns, end_ns: log times (None in an empty bag); truncated: the recording was cut off;
    notice: one line for the user about that or about damage, else ''.
    """

    def __init__(self, path):
        self.path = path
        self.topics = {}
        self.metadata = {}
        self.start_ns = self.end_ns = None
        self.truncated = False
        self.notice = ''
        self._definitions = {}
        self._decoded = {}

    def messages(self, topics=None):
        """Yield (topic, log_ns, publish_ns, bytes) by log time, equal times in file order."""
        for block in self.blocks(topics):
            yield from block.messages()

    def blocks(self, topics=None):
        """
        Yield MessageBlocks of the messages on `topics` (all when None), in the same order.

        A block holds about BLOCK_BYTES, whatever the length of the bag.
        """
        raise NotImplementedError

    def close(self):
        """Release the files."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def require(self, topic, msgtype=None):
        """Raise InputError unless the bag holds `topic`, with `msgtype` where given."""
        if topic not in self.topics:
            there = ', '.join(sorted(self.topics)) or 'none at all'
            raise InputError(f'{self.path}: no topic {topic}, the bag has {there}')
        found = self.topics[topic][0]
        if msgtype is not None and found != msgtype:
            raise InputError(f'{self.path}: topic {topic} has type {found}, expected {msgtype}')

    def decode(self, msgtype, raw):
        """Return the message object of the CDR bytes `raw`."""
        try:
            if msgtype not in self._typestore.types:
                self._register(msgtype)
            return self._typestore.deserialize_cdr(raw, msgtype)
        except InputError:
            raise
        except Exception as error:  # generated code meets damaged bytes in many ways
            raise InputError(f'{self.path}: cannot decode a message of type {msgtype}: '
                             f'{type(error).__name__} {" ".join(str(error).split())}') from None

    @cached_property
    def _typestore(self):
        return get_typestore(Stores.ROS2_JAZZY)

    def joint_names(self, topic):
        """Return the joint names on `topic` in order of appearance."""
        return self._joint_states(topic, ())[1]

    def joint_states(self, topic, names):
        """Return the JointStates of `topic` with the joints `names` as columns."""
        states, there = self._joint_states(topic, tuple(names))
        self.require_joints(topic, names, there)
        return states

    def require_joints(self, topic, names, there):
        """Raise InputError unless all `names` are `there`, the joints on `topic`."""
        for name in names:
            if name and name not in there:  # '': there is no such joint
                raise InputError(f'{self.path}: topic {topic} has no joint {name!r}, '
                                 f'it has {", ".join(there) or "none"}')

    def decoder(self, topic, names):
        """Return the cdr.Decoder of `topic` with the joints `names` as columns."""
        self.require(topic, JOINT_STATE)
        return Decoder(names, lambda raw: self.decode(JOINT_STATE, raw))

    def _joint_states(self, topic, names):
        if (topic, names) in self._decoded:
            return self._decoded[topic, names]
        decode = self.decoder(topic, names)
        parts = [decode(block_of((topic,), []))]
        parts += [decode(block) for block in self.blocks([topic])]
        states = JointStates(names, *(
            np.concatenate([getattr(part, field) for part in parts])
            for field in list(JointStates.__dataclass_fields__)[1:]))
        self._decoded = {(topic, names): (states, tuple(decode.there))}
        return self._decoded[topic, names]

    def _register(self, msgtype):
        encoding, text = self._definitions.get(msgtype, ('', ''))
        if not text:
            raise InputError(f'{self.path}: holds no definition of the type {msgtype}')
        parse = {'ros2msg': lambda: get_types_from_msg(text, msgtype),
                 'ros2idl': lambda: get_types_from_idl(text)}.get(encoding)
        if parse is None:
            raise InputError(f'{self.path}: definition of {msgtype} is {encoding!r}, '
                             'expected ros2msg or ros2idl')
        self._typestore.register({name: types for name, types in parse().items()
                                  if name not in self._typestore.types})


class McapReader(BagReader):
    """Bag of one or more MCAP files."""

    def __init__(self, path, files):
        super().__init__(path)
        self._files, self._unreadable = _opened(files)
        self._parts = []
        lost = 0
        for number, file in enumerate(self._files):
            self.metadata.update(file.metadata)
            for channel in file.channels.values():
                schema = file.schemas.get(channel.schema_id)
                msgtype = schema.name if schema else ''
                self.topics.setdefault(channel.topic, (msgtype, 0))
                if schema:
                    text = schema.data.decode(errors='replace')
                    self._definitions.setdefault(schema.name, (schema.encoding, text))
            for chunk in file.chunks:
                for channel_id, count in chunk.counts.items():
                    channel = file.channels.get(channel_id)
                    if channel is None:
                        lost += count
                        continue
                    msgtype, total = self.topics[channel.topic]
                    self.topics[channel.topic] = (msgtype, total + count)
                self._parts.append((chunk.start_ns, number, chunk.begin, file, chunk))
        self._parts.sort(key=lambda part: part[:3])
        self._ranks = np.empty(len(self._parts), np.int64)
        self._ranks[sorted(range(len(self._parts)), key=lambda k: self._parts[k][1:3])] = \
            np.arange(len(self._parts))
        if self._parts:
            self.start_ns = self._parts[0][0]
            self.end_ns = max(part[4].end_ns for part in self._parts)
        self.truncated = bool(self._unreadable) or any(file.truncated for file in self._files)
        self.notice = self._notice(lost)

    def blocks(self, topics=None):
        topics = tuple(self.topics if topics is None else topics)
        tables = [self._topic_of(file, topics) for file in self._files]
        held, group, size = None, [], 0
        for position, (_, number, _, _, chunk) in enumerate(self._parts):
            if any(tables[number][channel] >= 0 for channel in chunk.counts):
                group.append(position)
                size += chunk.unpacked_size
            last = position + 1 == len(self._parts)
            if not last and size < BLOCK_BYTES:
                continue
            block, ranks = self._block(topics, tables, held, group)
            ready = len(block) if last else int(
                np.searchsorted(block.log_ns, self._parts[position + 1][0]))
            held, group, size = None, [], 0
            if ready < len(block):
                held = _compact(block.take(slice(ready, None))), ranks[ready:]
                block = block.take(slice(0, ready))
            if len(block):
                yield block
        self.notice = self._notice(0) or self.notice

    def _topic_of(self, file, topics):
        """Return int32[CHANNELS]: place in `topics` of each channel of `file`, -1 = none."""
        number = {topic: k for k, topic in enumerate(topics)}
        table = np.full(CHANNELS, -1, np.int32)
        for channel_id, channel in file.channels.items():
            table[channel_id] = number.get(channel.topic, -1)
        return table

    def _block(self, topics, tables, held, group):
        """
        Return (MessageBlock of what is `held` and in the parts `group`, ranks of its rows).

        Equal times stay in the order of files, chunks and messages: that of the ranks.
        """
        pieces, ranks = [], []
        if held is not None:
            pieces.append(held[0].data.tobytes())
        pieces += [self._parts[k][3].unpacked(self._parts[k][4]) for k in group]
        data = np.frombuffer(pieces[0] if len(pieces) == 1 else b''.join(pieces), np.uint8)
        rows = len(data) // MESSAGE_HEAD + (len(held[0]) if held else 0)
        at, size = np.empty((2, rows), np.int64)
        log_ns, publish_ns = np.empty((2, rows), np.uint64)
        topic, row, begin = np.empty(rows, np.int32), 0, 0
        if held is not None:
            block, row, begin = held[0], len(held[0]), len(pieces[0])
            at[:row], size[:row], topic[:row] = block.at, block.size, block.topic
            log_ns[:row], publish_ns[:row] = block.log_ns, block.publish_ns
            ranks.append(held[1])
        for k, piece in zip(group, pieces[len(pieces) - len(group):]):
            first, end = row, begin + len(piece)
            row, _ = find_messages(data, begin, end, tables[self._parts[k][1]], False, row, at,
                                   size, topic, log_ns, publish_ns)
            ranks.append(np.full(row - first, self._ranks[k]))
            begin = end
        block = MessageBlock(topics, data, at[:row], size[:row], topic[:row],
                             log_ns[:row].view(np.int64), publish_ns[:row].view(np.int64))
        rank = np.concatenate(ranks) if ranks else np.empty(0, np.int64)
        if not ((np.diff(block.log_ns) >= 0) & (np.diff(rank) >= 0)).all():
            order = np.lexsort((rank, block.log_ns))
            block, rank = block.take(order), rank[order]
        return block, rank

    def close(self):
        for file in self._files:
            file.close()

    def _notice(self, lost):
        """Return one line about what is missing of the recording."""
        texts = list(self._unreadable)
        if self.truncated:
            cut = [str(file.path) for file in self._files if file.truncated]
            texts += [f'{file}: recording was cut off, read up to its last whole message'
                      for file in cut[:1]]
        damage = [f'{file.path}: damaged {text}' for file in self._files
                  for text in file.damaged]
        if damage:
            texts.append(damage[0] + (f' and {len(damage) - 1} more' if damage[1:] else ''))
        if lost:
            texts.append(f'{self.path}: {lost} messages lost their channel definition')
        return '; '.join(texts)


def _opened(files):
    """
    Return (McapFiles, what is wrong with the others) of `files`.

    The last file of a bag that was cut may be empty. InputError when none can be read.
    """
    opened, problems = [], []
    for file in files:
        try:
            opened.append(McapFile(file))
        except InputError as error:
            problems.append(error)
    if not opened:
        raise problems[0]
    return opened, [str(problem) for problem in problems]


def _compact(block):
    """Return the `block` with the bytes of its own messages only."""
    return block_of(block.topics, list(block.messages()))


class RosbagsReader(BagReader):
    """Bag in a form that rosbags reads: SQLite, or compressed by rosbag2."""

    def __init__(self, path):
        super().__init__(path)
        try:
            self._reader = Reader(path.parent if path.is_file() else path)
            self._reader.open()
        except (ReaderError, OSError, AssertionError, sqlite3.Error) as error:
            raise _unreadable(path, error) from None
        for topic, info in self._reader.topics.items():
            self.topics[topic] = (info.msgtype or '', info.msgcount)
        for connection in self._reader.connections:
            text = connection.msgdef.data
            encoding = 'ros2idl' if text.startswith('=' * 80 + '\nIDL: ') else 'ros2msg'
            self._definitions.setdefault(connection.msgtype, (encoding, text))
        if self._reader.message_count:
            self.start_ns = self._reader.start_time
            self.end_ns = self._reader.end_time - 1  # rosbags names the first moment after it

    def blocks(self, topics=None):
        wanted = [c for c in self._reader.connections if topics is None or c.topic in topics]
        topics, messages = tuple(self.topics if topics is None else topics), []
        try:
            for connection, log_ns, raw in self._reader.messages(connections=wanted) \
                    if wanted else ():
                messages.append((connection.topic, log_ns, log_ns, bytes(raw)))
                if len(messages) == BLOCK_MESSAGES:
                    yield block_of(topics, messages)
                    messages = []
        except (ReaderError, OSError, sqlite3.Error) as error:
            raise _unreadable(self.path, error) from None
        if messages:
            yield block_of(topics, messages)

    def close(self):
        self._reader.close()


def _unreadable(path, error):
    return InputError(f'{path}: cannot read: {" ".join(str(error).split())}')
