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
import yaml

from gearbox_monitor.bag import metadata
from gearbox_monitor.bag.cdr import (
    decode_message, decode_run, FIELDS, JointStates, read_layout,
)
from gearbox_monitor.bag.mcap_file import McapFile
from gearbox_monitor.errors import InputError

JOINT_STATE = 'sensor_msgs/msg/JointState'
BLOCK = 16384  # messages decoded at once
SMALL_RUN = 4  # fewer messages of one layout are not worth a table


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
    info = path / metadata.FILE_NAME
    if info.is_file():
        try:
            content = yaml.safe_load(info.read_text(encoding='utf-8'))
            content = content['rosbag2_bagfile_information']
            names = [str(name) for name in content['relative_file_paths']]
            if content.get('compression_mode'):
                return [path]
        except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
            names = []  # damaged: the recordings themselves tell all that is needed
        # Before 2020 these paths were relative to the directory that holds the bag.
        files = [path / name if (path / name).exists() else path / Path(name).name
                 for name in names]
        missing = [file for file in files if not file.is_file()]
        if missing:
            raise InputError(f'{missing[0]}: missing, but {info} names it')
        if files:
            return files
    files = sorted([*path.glob('*.mcap'), *path.glob('*.db3')], key=_natural)
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file, expected a bag directory')
    return files


def _natural(path):
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
        for name in names:
            if name not in there:
                raise InputError(f'{self.path}: topic {topic} has no joint {name!r}, '
                                 f'it has {", ".join(there) or "none"}')
        return states

    def _joint_states(self, topic, names):
        if (topic, names) in self._decoded:
            return self._decoded[topic, names]
        self.require(topic, JOINT_STATE)
        log, raws = [], []
        for _, log_ns, _, raw in self.messages([topic]):
            log.append(log_ns)
            raws.append(raw)
        into = {field: np.full((len(raws), len(names)), np.nan) for field in FIELDS}
        into['stamp_ns'] = np.zeros(len(raws), np.int64)
        into['named'] = np.zeros((len(raws), len(names)), bool)
        there = {}
        for begin in range(0, len(raws), BLOCK):
            self._decode_block(raws[begin:begin + BLOCK], begin, names, into, there)
        states = JointStates(names, log_ns=np.array(log, np.int64), **into)
        self._decoded = {(topic, names): (states, tuple(there))}
        return self._decoded[topic, names]

    def _decode_block(self, raws, begin, names, into, there):
        """Decode `raws`, rows `begin` and following: runs of one layout at once."""
        lengths = np.array([len(raw) for raw in raws])
        order = np.arange(len(raws))
        for length in dict.fromkeys(lengths.tolist()):
            left = order[lengths == length]
            while len(left) >= SMALL_RUN:
                layout = read_layout(raws[left[0]])
                if layout is None:
                    break
                done = decode_run([raws[k] for k in left], layout, names, into, left + begin)
                there.update(dict.fromkeys(layout.names))
                left = left[~done]
                if done.sum() < SMALL_RUN:
                    break  # many layouts of one length: message by message
            for k in left.tolist():
                message = self.decode(JOINT_STATE, raws[k])
                decode_message(message, names, into, begin + k)
                there.update(dict.fromkeys(message.name))

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
        self._files = [McapFile(file) for file in files]
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
        if self._parts:
            self.start_ns = self._parts[0][0]
            self.end_ns = max(part[4].end_ns for part in self._parts)
        self.truncated = any(file.truncated for file in self._files)
        self.notice = self._notice(lost)

    def messages(self, topics=None):
        held = []
        for position, (_, number, begin, file, chunk) in enumerate(self._parts):
            names = {channel_id: file.channels[channel_id].topic for channel_id in chunk.counts
                     if channel_id in file.channels
                     and (topics is None or file.channels[channel_id].topic in topics)}
            if names:
                held += [(log, number, begin, order, names[channel], publish, raw)
                         for order, (log, publish, channel, raw)
                         in enumerate(file.messages(chunk, names))]
                held.sort(key=lambda item: item[:4])
            last = position + 1 == len(self._parts)
            until = None if last else self._parts[position + 1][0]
            ready = len(held) if last else _count_before(held, until)
            for log, _, _, _, topic, publish, raw in held[:ready]:
                yield topic, log, publish, raw
            held = held[ready:]
        self.notice = self._notice(0) or self.notice

    def close(self):
        for file in self._files:
            file.close()

    def _notice(self, lost):
        """Return one line about what is missing of the recording."""
        texts = []
        if self.truncated:
            cut = [str(file.path) for file in self._files if file.truncated]
            texts.append(f'{cut[0]}: recording was cut off, read up to its last whole message')
        damage = [f'{file.path}: damaged {text}' for file in self._files
                  for text in file.damaged]
        if damage:
            texts.append(damage[0] + (f' and {len(damage) - 1} more' if damage[1:] else ''))
        if lost:
            texts.append(f'{self.path}: {lost} messages lost their channel definition')
        return '; '.join(texts)


def _count_before(held, until):
    """Return how many of the sorted `held` messages were logged before `until`."""
    low, high = 0, len(held)
    while low < high:
        middle = (low + high) // 2
        if held[middle][0] < until:
            low = middle + 1
        else:
            high = middle
    return low


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

    def messages(self, topics=None):
        wanted = [c for c in self._reader.connections if topics is None or c.topic in topics]
        if not wanted:
            return
        try:
            for connection, log_ns, raw in self._reader.messages(connections=wanted):
                yield connection.topic, log_ns, log_ns, bytes(raw)
        except (ReaderError, OSError, sqlite3.Error) as error:
            raise _unreadable(self.path, error) from None

    def close(self):
        self._reader.close()


def _unreadable(path, error):
    return InputError(f'{path}: cannot read: {" ".join(str(error).split())}')
