# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Read rosbag2 bags: directories, single ``.mcap`` or ``.db3`` files and the remains of a crash.

A recording of another kind is a VirtualBag: its joint states are encoded where they are read, in
blocks.
"""
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from functools import cached_property
import heapq
from itertools import chain
import math
import os
from pathlib import Path
import re
from types import TracebackType
from typing import Any

import numpy as np
from rosbags.typesys import get_types_from_idl, get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags, Integers, Numbers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings import storage
from gearbox_monitor.recordings.cdr import (
    block_of, CHANNELS, compact, Decoder, empty_index, find_messages, joined, joined_blocks,
    joint_state_rows, JointStates, Message, MESSAGE_HEAD, MessageBlock, STATE_TYPE)
from gearbox_monitor.recordings.mcap_file import McapFile, ScannedChunk
from gearbox_monitor.recordings.meaning import ROTARY
from gearbox_monitor.recordings.storage import SqliteFile

JOINT_STATE = STATE_TYPE
DYNAMIC, CONTROLLER = ('control_msgs/msg/DynamicJointState',
                       'control_msgs/msg/JointTrajectoryControllerState')
# Definitions of messages that SQLite bags often lack.
DEFINITIONS = {DYNAMIC: (
    'std_msgs/Header header\nstring[] joint_names\n'
    'control_msgs/InterfaceValue[] interface_values\n' + '=' * 80 +
    '\nMSG: control_msgs/InterfaceValue\nstring[] interface_names\nfloat64[] values\n')}
ROS1_TEXT = 'ros1msg'  # encoding of a definition, and of its messages
BLOCK_BYTES = 1 << 20  # unpacked at once, or one chunk where that is larger
BLOCK_MESSAGES = 4096  # of a bag that is read message by message
MAX_HELD = 1 << 26  # bytes of messages that wait for chunks with earlier ones
FORMATS = ('.mcap', '.db3')
PACKED = '.zstd'  # suffix of a file that rosbag2 has compressed
ROS1 = b'#ROSBAG V2.0'  # first bytes of a bag of ROS 1
OR_NONE = "one of these, or '' for an encoder that the drive does not have"


def open_bag(path: str | Path) -> 'BagReader':
    """
    Return a BagReader of `path`: bag directory, ``.mcap`` or ``.db3`` file, complete or cut.

    Raises InputError if there is nothing to read.
    """
    path = Path(path)
    if os.path.isdir(path):
        files = _files_of(path)
    elif os.path.exists(path):
        files = expect_unpacked(path, [path], {})
        if is_ros1(path):
            raise InputError(f'{path}: a ROS 1 bag, expected one of ROS 2: gearbox_monitor import '
                             f'{path} NEW converts its joint states')
    else:
        raise InputError(f'{path}: no such file or directory, expected a bag')
    kinds = {file.suffix == '.db3' for file in files}
    if len(kinds) > 1:
        raise InputError(f'{path}: holds .mcap and .db3 files, expected one kind')
    with ExitStack() as stack:
        reader = (SqliteReader if kinds == {True} else McapReader)(path, files, stack)
        reader.opened = stack.pop_all()
    return reader


def is_ros1(path: Path) -> bool:
    """Return whether the file `path` is a bag of ROS 1."""
    if not path.is_file():
        return False
    try:
        with path.open('rb') as stream:
            return stream.read(len(ROS1)) == ROS1
    except OSError:
        return False


def _files_of(path: Path) -> list[Path]:
    """Return the recordings of the bag directory `path` in order."""
    content = storage.read_information(path)  # if damaged, the recordings themselves suffice
    files = named_files(path, content)
    missing = [file for file in files if not os.path.isfile(file)]
    if missing:
        problem = 'a pipe or device, not a file' if os.path.exists(missing[0]) else (
            f'missing, but {path / storage.FILE_NAME} names it')
        raise InputError(f'{missing[0]}: {problem}')
    files = files or sorted((file for suffix in FORMATS for pattern in (suffix, suffix + PACKED)
                             for file in path.glob('*' + pattern)), key=natural)
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file, expected a bag directory')
    return expect_unpacked(path, files, content)


def unpacked(files: Iterable[Path]) -> list[Path]:
    """Return `files`, in place of compressed ones those that zstd has unpacked beside them."""
    beside = {file: file.with_suffix('') for file in files if file.suffix == PACKED}
    return list(dict.fromkeys(own if (own := beside.get(file, file)).is_file() else file
                              for file in files))


def expect_unpacked(path: Path, files: list[Path], content: Mapping[str, Any]) -> list[Path]:
    """
    Return the `files` of a bag. Raises InputError: rosbag2 has compressed them, or its messages.

    Args:
        path: of the bag.
        files: recordings of it.
        content: information of its metadata.yaml.
    """
    files = unpacked(files)
    packed = next((file for file in files if file.suffix == PACKED), None)
    if packed is not None:
        raise InputError(f'{packed}: compressed by rosbag2, expected it unpacked: '
                         f'zstd -d {packed}')
    if str(content.get('compression_mode', '')).lower() == 'message':
        raise InputError(f'{path}: rosbag2 has compressed each message by itself, expected chunks '
                         'or none compressed: ros2 bag convert')
    return files


def named_files(path: Path, content: Mapping[str, Any]) -> list[Path]:
    """Return the files of the bag directory `path` that its information `content` names."""
    # Before 2020 these paths were relative to the directory that holds the bag.
    return unpacked([path / Path(str(name)).name
                     for name in content.get('relative_file_paths', ())])


def natural(path: str | Path) -> list[int | str]:
    """Return a key of `path` that sorts bag_2 before bag_10."""
    return [int(part) if part.isdigit() else part for part in re.split(r'(\d+)', str(path))]


class BagReader(AbstractContextManager['BagReader']):
    """
    The bag `path`: what all storage formats have in common.

    topics: {topic: (message type, number of messages)}; metadata: {record name: {key: value}};
    start_ns, end_ns: log times (None in an empty bag); truncated: the recording was cut off;
    notice: one line for the user about that or about damage, else ''; notes: sentences about a
    recording of another kind; opened: what is released with the reader. arm_side: positions
    and efforts of the motor are referred to the output already; axis: of its joints, 'prismatic'
    where their units say so; effort_units {joint: unit} of efforts that are no torque or force.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, tuple[str, int]] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self.truncated = False
        self.notice, self.notes = '', tuple[str, ...]()
        self.arm_side = False
        self.axis = ROTARY
        self.effort_units: dict[str, str] = {}
        self.opened = ExitStack()
        self._definitions: dict[str, tuple[str, str]] = {}
        self._decoded: dict[str, tuple[JointStates, tuple[str, ...]]] = {}  # of the last topic

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[Message]:
        """Yield the messages on `topics` (None: all) by log time, equal times in file order."""
        for block in self.blocks(topics):
            yield from block.messages()

    def blocks(self, topics: Iterable[str] | None = None) -> Iterator[MessageBlock]:
        """
        Yield MessageBlocks of the messages on `topics` (None: all), in the same order.

        A block holds about BLOCK_BYTES, whatever the length of the bag.
        """
        raise NotImplementedError

    def close(self) -> None:
        """Release the files."""
        self.opened.close()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        self.close()

    def referred(self, model: DriveModel) -> DriveModel:
        """Return `model` with the gear ratio by which the motor in this bag is read."""
        return replace(model, gear_ratio=1.0) if self.arm_side else model

    def count(self, topic: str) -> int:
        """Return the number of messages on `topic`, 0 if the bag does not have it."""
        return self.topics.get(topic, ('', 0))[1]

    def require(self, topic: str, msgtype: str | None = None) -> None:
        """Raise InputError unless the bag holds `topic`, with `msgtype` if that is not None."""
        if topic not in self.topics:
            topics = ', '.join(sorted(self.topics)) or 'none'
            raise InputError(f'{self.path}: no topic {topic}, the bag has {topics}')
        kind = self.topics[topic][0]
        if msgtype is not None and kind != msgtype:
            raise InputError(f'{self.path}: topic {topic} has type {kind}, expected {msgtype}')

    def decode(self, msgtype: str, raw: bytes) -> Any:
        """Return the message object of type `msgtype` in the CDR bytes `raw`."""
        name = msgtype if msgtype.count('/') != 1 else msgtype.replace('/', '/msg/')
        old = self.is_ros1(msgtype)
        store = self._ros1_typestore if old else self._typestore
        try:
            if name not in store.types:
                self._register(msgtype, name, store)
            return (store.deserialize_ros1 if old else store.deserialize_cdr)(raw, name)
        except InputError:
            raise
        except Exception as error:  # generated code raises many kinds for damaged bytes
            raise InputError(f'{self.path}: cannot decode a message of type {msgtype}: '
                             f'{type(error).__name__} {" ".join(str(error).split())}') from None

    def is_ros1(self, msgtype: str) -> bool:
        """Return whether messages of type `msgtype` are serialised as ROS 1 does it."""
        return self._definitions.get(msgtype, ('', ''))[0] == ROS1_TEXT

    @cached_property
    def _typestore(self) -> Typestore:
        return get_typestore(Stores.ROS2_JAZZY)

    @cached_property
    def _ros1_typestore(self) -> Typestore:
        return get_typestore(Stores.ROS1_NOETIC)

    def joint_names(self, topic: str, names: Sequence[str] | None = None) -> tuple[str, ...]:
        """
        Return the joint names on `topic` in order of appearance.

        names: joints whose states are read with them, for joint_states; None: all.
        """
        return self._joint_states(topic, names)[1]

    def joint_states(self, topic: str, names: Sequence[str]) -> JointStates:
        """Return the JointStates of `topic` with the joints `names` as columns."""
        states, joints = self._joint_states(topic, names)
        self.require_joints(topic, names, joints)
        return states.of(names)

    def require_joints(self, topic: str, names: Iterable[str], joints: Iterable[str],
                       expected: str = OR_NONE) -> None:
        """
        Check that a topic has some joints.

        Args:
            topic: its name, for the message.
            names: joints that are required; '' stands for a joint that the drive does not have.
            joints: joints on the topic.
            expected: in place of a joint that is missing.

        Raises:
            InputError: a joint is missing.
        """
        for name in names:
            if name and name not in joints:
                raise InputError(f'{self.path}: topic {topic} has no joint {name!r}, it has '
                                 f'{", ".join(joints) or "none"}; expected {expected}')

    def decoder(self, topic: str, names: Sequence[str]) -> Decoder:
        """Return the cdr.Decoder of `topic` with the joints `names` as columns."""
        self.require(topic, JOINT_STATE)
        return Decoder(names, lambda raw: self.decode(JOINT_STATE, raw),
                       f'{self.path}: topic {topic}: ')

    def _joint_states(self, topic: str, names: Sequence[str] | None
                      ) -> tuple[JointStates, tuple[str, ...]]:
        """Return (JointStates of the joints `names` or more, None: all; joints on `topic`)."""
        states, joints = self._decoded.get(topic, (None, ()))
        if states is not None and {*(joints if names is None else names)} <= {'', *states.names}:
            return states, joints
        look = self.decoder(topic, ())
        blocks = self.blocks([topic])
        first = next(blocks, block_of((topic,), []))
        look(first)
        wanted = (joints or look.joints) if names is None else names
        decode = self.decoder(topic, tuple(dict.fromkeys(wanted)))
        states = joined([decode(block) for block in chain([first], blocks)])
        self._decoded = {topic: (states, tuple(decode.joints))}
        return self._joint_states(topic, names)  # of all, if some came later

    def _register(self, msgtype: str, name: str, store: Typestore) -> None:
        encoding, text = self._definitions.get(msgtype, ('', ''))
        if not text:
            encoding, text = 'ros2msg', DEFINITIONS.get(msgtype, '')
        if not text:
            raise InputError(f'{self.path}: holds no definition of the type {msgtype}')
        if encoding not in ('ros2msg', 'ros2idl', ROS1_TEXT):
            raise InputError(f'{self.path}: definition of {msgtype} is {encoding!r}, '
                             'expected ros2msg or ros2idl')
        types = get_types_from_idl(text) if encoding == 'ros2idl' else get_types_from_msg(
            text, name)
        store.register({other: kind for other, kind in types.items()
                        if other not in store.types})


class McapReader(BagReader):
    """Bag `path` of one or more MCAP `files`, released by `opened`."""

    def __init__(self, path: Path, files: Iterable[Path], opened: ExitStack) -> None:
        super().__init__(path)
        self._files, self._unreadable = opened_files(files)
        undefined = 0  # messages
        placed: list[tuple[McapFile, ScannedChunk]] = []
        for file in self._files:
            opened.callback(file.close)
            self.metadata.update(file.metadata)
            for channel in file.channels.values():
                schema = file.schemas.get(channel.schema_id)
                msgtype = schema.name if schema else ''
                if channel.message_encoding not in ('', 'cdr', 'ros1'):
                    msgtype += f' in {channel.message_encoding}'
                self.topics.setdefault(channel.topic, (msgtype, 0))
                if schema:
                    text = schema.data.decode(errors='replace')
                    self._definitions.setdefault(schema.name, (schema.encoding, text))
            for chunk in file.chunks:
                for channel_id, count in chunk.counts.items():
                    definition = file.channels.get(channel_id)
                    if definition is None:
                        undefined += count
                        continue
                    msgtype, total = self.topics[definition.topic]
                    self.topics[definition.topic] = (msgtype, total + count)
            placed += [(file, chunk) for chunk in sorted(
                file.chunks, key=lambda chunk: chunk.begin)]
        # (Place in file order, file, chunk) by log time; equal times stay in file order.
        self._chunks = sorted(((k, *part) for k, part in enumerate(placed)),
                              key=lambda part: part[2].start_ns)
        if placed:
            self.start_ns = self._chunks[0][2].start_ns
            self.end_ns = max(chunk.end_ns for _, chunk in placed)
        self.truncated = bool(self._unreadable) or any(file.truncated for file in self._files)
        self.notice = self._notice(undefined)

    def blocks(self, topics: Iterable[str] | None = None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        tables = {file: _topic_numbers(file, names) for file in self._files}
        waiting: dict[int, MessageBlock] = {}  # by the place of its chunk in file order
        size = 0
        for (rank, file, chunk), following in zip(self._chunks, [
                *(chunk.start_ns for *_, chunk in self._chunks[1:]), math.inf]):
            if any(tables[file][channel] >= 0 for channel in chunk.counts):
                waiting[rank] = _messages_of(file, chunk, names, tables[file])
                size += chunk.unpacked_size
            if not waiting or following < math.inf and size < BLOCK_BYTES:
                continue
            block = joined_blocks([own.take(np.flatnonzero(own.log_ns < following))
                                   for _, own in sorted(waiting.items())])
            if (np.diff(block.log_ns) < 0).any():
                block = block.take(np.argsort(block.log_ns, kind='stable'))
            if len(block):
                yield block
            waiting = {rank: compact(own.take(np.flatnonzero(own.log_ns >= following)))
                       for rank, own in waiting.items() if (own.log_ns >= following).any()}
            size = 0
            if sum(own.data.nbytes for own in waiting.values()) > MAX_HELD:
                raise InputError(f'{self.path}: the times of more than {MAX_HELD >> 20} MB of '
                                 'messages overlap, expected chunks in order of their times')
        self.notice = self._notice(0) or self.notice

    def _notice(self, undefined: int) -> str:
        """Return one line about what is missing; undefined: messages without a definition."""
        texts = list(self._unreadable)
        if self.truncated:
            cut = [str(file.path) for file in self._files if file.truncated]
            texts += [f'{file}: recording was cut off, read up to its last whole message'
                      for file in cut[:1]]
        damage = [f'{file.path}: damaged {text}' for file in self._files
                  for text in file.damaged]
        if damage:
            texts.append(damage[0] + (f' and {len(damage) - 1} more' if damage[1:] else ''))
        if undefined:
            texts.append(f'{self.path}: {undefined} messages lost their channel definition')
        return '; '.join(texts)


def _messages_of(file: McapFile, chunk: ScannedChunk, topics: tuple[str, ...], numbers: Numbers
                 ) -> MessageBlock:
    """Return the messages of a chunk on `topics`; numbers: see _topic_numbers."""
    data = np.frombuffer(file.unpacked(chunk), np.uint8)
    index = empty_index(len(data) // MESSAGE_HEAD)
    rows, _ = find_messages(data, 0, len(data), numbers, False, 0, index)
    return MessageBlock(topics, data, index.offset[:rows], index.size[:rows], index.number[:rows],
                        index.log_ns[:rows].view(np.int64), index.publish_ns[:rows].view(np.int64))


def _topic_numbers(file: McapFile, topics: Sequence[str]) -> Numbers:
    """Return [CHANNELS]: place in `topics` of each channel of `file`, -1 = none."""
    number = {topic: k for k, topic in enumerate(topics)}
    table = np.full(CHANNELS, -1, np.int32)
    for channel_id, channel in file.channels.items():
        table[channel_id] = number.get(channel.topic, -1)
    return table


def opened_files(files: Iterable[Path]) -> tuple[list[McapFile], list[str]]:
    """
    Return (McapFiles of the readable `files`, problems of the unreadable ones).

    The last file of a cut bag may be empty. Raises InputError if no file can be read.
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


def blocks_of(topics: tuple[str, ...], messages: Iterable[Message]) -> Iterator[MessageBlock]:
    """Yield the `messages` on `topics` in blocks of bounded size."""
    waiting: list[Message] = []
    size = 0
    for message in messages:
        waiting.append(message)
        size += len(message[-1])
        if len(waiting) == BLOCK_MESSAGES or size > BLOCK_BYTES:
            yield block_of(topics, waiting)
            waiting, size = [], 0
    if waiting:
        yield block_of(topics, waiting)


class SqliteReader(BagReader):
    """Bag `path` of one or more SQLite `files`, released by `opened`."""

    def __init__(self, path: Path, files: Iterable[Path], opened: ExitStack) -> None:
        super().__init__(path)
        self._files: list[SqliteFile] = []
        for file in files:
            self._files.append(SqliteFile(file))
            opened.callback(self._files[-1].close)
        for content in self._files:
            for topic, (kind, count) in content.topics.items():
                self.topics[topic] = (kind, self.topics.get(topic, ('', 0))[1] + count)
            self._definitions.update(content.definitions)
        times = [time for content in self._files for time in content.log_times]
        if times:
            self.start_ns, self.end_ns = min(times), max(times)

    def blocks(self, topics: Iterable[str] | None = None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        return blocks_of(names, heapq.merge(*(file.messages(names) for file in self._files),
                                            key=lambda message: message[1]))


# --- recordings of other kinds ------------------------------------------------------------------
@dataclass(frozen=True)
class Frames:
    """
    Messages [N] on one topic that name the same J joints.

    stamp_ns, log_ns [N]: of measurement, of receipt. values {field: [N, J]}: a message leaves a
    field empty that was measured of no joint in its block.
    """

    topic: str
    joints: tuple[str, ...]
    stamp_ns: Integers
    log_ns: Integers
    values: Mapping[str, Array]


def frames_of(topic: str, joints: Sequence[str], is_there: Flags,
              stamps: tuple[Integers, Integers], values: Mapping[str, Array]) -> Iterator[Frames]:
    """
    Yield the Frames of messages that name some of J joints each.

    Args:
        topic: of them.
        joints: names of all.
        is_there: which of them a message names [N, J].
        stamps: of measurement and of receipt [N].
        values: {field: [N, J]}.
    """
    for named in np.unique(is_there, axis=0):
        rows = np.flatnonzero((is_there == named).all(axis=1))
        yield Frames(topic, tuple(np.array(joints, object)[named]), stamps[0][rows],
                     stamps[1][rows], {field: x[np.ix_(rows, named)]
                                       for field, x in values.items()})


class VirtualBag(BagReader):
    """
    The bag of a recording that is none.

    Args:
        path: of the recording.
        topics: {topic: number of messages, as far as it is known}.
        chunks: yields the Frames of the recording in parts, in order of time.
        span: (start_ns, end_ns) as far as it is known.
        notes: sentences for the user.
    """

    def __init__(self, path: Path, topics: Mapping[str, int],
                 chunks: Callable[[], Iterator[Sequence[Frames]]], span: tuple[int, int],
                 notes: Sequence[str] = ()) -> None:
        super().__init__(path)
        self.topics = {topic: (JOINT_STATE, count) for topic, count in topics.items()}
        self.start_ns, self.end_ns = span
        self.notes, self.notice = tuple(notes), '; '.join(notes)
        self._chunks = chunks

    def blocks(self, topics: Iterable[str] | None = None) -> Iterator[MessageBlock]:
        names = tuple(self.topics if topics is None else topics)
        for frames in self._chunks():
            block = block_of_frames(names, [f for f in frames if f.topic in names])
            for begin in range(0, len(block), BLOCK_MESSAGES):
                yield block.take(slice(begin, begin + BLOCK_MESSAGES))


def block_of_frames(topics: Sequence[str], frames: Sequence[Frames], whole: bool = False
                    ) -> MessageBlock:
    """
    Return the messages of all `frames` on `topics`, by log time, then in the given order.

    whole: fields that were measured of no joint are written, too.
    """
    def measured(f: Frames, field: str) -> Array | None:
        return f.values[field] if field in f.values and (
            whole or not np.isnan(f.values[field]).all()) else None
    rows = [joint_state_rows(f.stamp_ns, f.joints, measured(f, 'position'), measured(
        f, 'velocity'), measured(f, 'effort')) for f in frames]
    sizes = [np.full(len(data), data.shape[1], np.int64) for data in rows]
    size = np.concatenate([np.empty(0, np.int64), *sizes])
    offset = np.cumsum(size) - size
    log_ns = np.concatenate([np.empty(0, np.int64), *(f.log_ns for f in frames)])
    topic = np.concatenate([np.empty(0, np.int32), *(
        np.full(len(data), topics.index(f.topic), np.int32) for f, data in zip(frames, rows))])
    data = np.concatenate([np.empty(0, np.uint8), *(data.ravel() for data in rows)])
    block = MessageBlock(tuple(topics), data, offset, size, topic, log_ns, log_ns)
    return block if len(frames) < 2 else block.take(np.argsort(log_ns, kind='stable'))
