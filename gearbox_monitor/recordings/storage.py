# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Parts of a rosbag2 directory: ``metadata.yaml``, SQLite files, and chunks unpacked.

Metadata is version 9, as ROS 2 Jazzy writes it. Unpacking is bounded in memory: what is packed may
state and yield any size.
"""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, ExitStack, suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import count
import os
from pathlib import Path
import sqlite3
from typing import Any, TypeAlias
from urllib.parse import quote

import lz4.frame
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos
import yaml
import zstandard

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import open_file, parse_yaml, read_text
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.recordings.cdr import Message

PIECE = 1 << 24      # bytes unpacked at a time; so many are always unpacked
EXPANSION = 256      # no whole chunk of data unpacks to more times its size, lz4 to 255 at most
MAX_UNPACKED = 1 << 27  # bytes in memory at once; writers of bags end chunks at 1 to 4 MB
DAMAGE = (zstandard.ZstdError, RuntimeError, EOFError, MemoryError)


def unpacked_limit(size: int) -> int:
    """Return to how many bytes in memory `size` packed bytes may unpack."""
    return min(max(PIECE, EXPANSION * size), MAX_UNPACKED)


def unpack(packed: bytes, compression: str, size: int) -> tuple[bytes, str | None]:
    """
    Unpack a chunk, complete, damaged or cut.

    Args:
        packed: the packed bytes.
        compression: 'zstd', 'lz4' or '' (not packed).
        size: bytes that it shall unpack to.

    Returns:
        (As many of them as can be unpacked within `unpacked_limit`, the problem or None).
    """
    if compression == '':
        return packed[:size], None
    if compression not in ('zstd', 'lz4'):
        return b'', f'unknown compression {compression!r}'
    if compression == 'lz4' and 0 < size <= min(PIECE, EXPANSION * len(packed)):
        with suppress(*DAMAGE):  # whole, in half of the time
            data = bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, size))
            if len(data) == size:
                return data, None
    return _unpack_piecewise(packed, compression, min(size, unpacked_limit(len(packed))))


def _unpack_piecewise(packed: bytes, compression: str, size: int) -> tuple[bytes, str | None]:
    """Return what `unpack` does, of damaged and cut frames, too."""
    data = bytearray()
    read: Any
    try:
        if compression == 'zstd':
            read = zstandard.ZstdDecompressor().stream_reader(packed).read
        else:
            read = lz4.frame.LZ4FrameFile(BytesIO(packed)).read1
        while piece := read(min(PIECE, size - len(data))):
            data += piece
    except DAMAGE as error:
        return bytes(data), str(error) or type(error).__name__
    return bytes(data), None


class SqliteFile:
    """
    The topics and messages of the file `path`.

    topics: {topic: (message type, number of messages)}; definitions: {message type: (encoding,
    text)}; log_times: of its first and last message on each topic (ns). close: releases it. Only
    tables are read: a view can compute without an end. Raises InputError.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.topics: dict[str, tuple[str, int]] = {}
        self.definitions: dict[str, tuple[str, str]] = {}
        self.log_times: list[int] = []
        self._names: dict[int, str] = {}
        with ExitStack() as stack:
            try:
                open_file(path).close()
                log = path.with_name(f'{path.name}-wal')
                if log.is_file() and log.stat().st_size:
                    raise self._unreadable(
                        f"{log.name} holds its newest messages: sqlite3 {path} "
                        "'PRAGMA wal_checkpoint(TRUNCATE)' puts them into one file")
                self._base = stack.enter_context(closing(sqlite3.connect(
                    f'file:{quote(str(path.absolute()))}?immutable=1', uri=True)))
            except (OSError, sqlite3.Error) as error:
                raise self._unreadable(getattr(error, 'strerror', None) or error) from None
            self._base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_UNPACKED)
            self._base.execute('PRAGMA trusted_schema = OFF')
            self._read_topics()
            self.close = stack.pop_all().close

    def messages(self, topics: Sequence[str]) -> Iterator[Message]:
        """Yield the messages on `topics` by log time."""
        numbers = [number for number, name in self._names.items() if name in topics]
        places = ', '.join('?' * len(numbers))
        for number, time, raw in self._rows(
                'SELECT topic_id, timestamp, data FROM messages '
                f'WHERE topic_id IN ({places}) ORDER BY timestamp, id', numbers):
            if not isinstance(time, int) or not isinstance(raw, bytes):
                raise self._unreadable(f'message of {time!r}, expected a time (ns) and bytes')
            yield self._names[number], time, time, raw

    def _read_topics(self) -> None:
        tables = {name for (name,) in self._rows(
            "SELECT name FROM sqlite_master WHERE type = 'table' AND sql LIKE 'CREATE TABLE%'")}
        if not {'topics', 'messages'} <= tables:
            raise self._unreadable('no tables topics and messages, expected a rosbag2 database')
        for number, name, kind, total, *times in self._rows(
                'SELECT id, name, type, ifnull(count, 0), first, last FROM topics LEFT JOIN '
                '(SELECT topic_id, count(*) AS count, min(timestamp) AS first, max(timestamp) AS '
                'last FROM messages GROUP BY topic_id) ON topic_id = id ORDER BY id'):
            if not isinstance(name, str) or not isinstance(kind, str):
                raise self._unreadable(f'topic {name!r} of type {kind!r}, expected texts')
            self._names[number] = name
            self.topics[name] = (kind, self.topics.get(name, ('', 0))[1] + total)
            self.log_times += [time for time in times if isinstance(time, int)]
        if 'message_definitions' in tables:
            for kind, encoding, text in self._rows(
                    'SELECT topic_type, encoding, encoded_message_definition '
                    'FROM message_definitions'):
                self.definitions[str(kind)] = (str(encoding), str(text))

    def _rows(self, query: str, values: Sequence[int] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of `query` with its `values`."""
        try:
            yield from self._base.execute(query, values)
        except (sqlite3.Error, OverflowError) as error:
            raise self._unreadable(error) from None

    def _unreadable(self, problem: object) -> InputError:
        return InputError(f'{self._path}: cannot read: {" ".join(str(problem).split())}')


VERSION = 9
FILE_NAME = 'metadata.yaml'
MAX_BYTES = 16 << 20  # of it: thousands of files and topics are a tenth of that
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
QosProfile: TypeAlias = dict[str, Any]

Part: TypeAlias = tuple[str, tuple[int, int] | None, int]  # file, its log times, its messages


@dataclass
class BagTopic:
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


def next_free(path: Path) -> Path:
    """Return the first of PATH_2, PATH_3 ... that does not exist."""
    names = (path.with_name(f'{path.name}_{k}') for k in count(2))
    return next(name for name in names if not os.path.lexists(name))


def qos_profile(**values: Any) -> QosProfile:
    """
    Return one offered QoS profile as rosbag2 spells it.

    Args:
        values: those that differ from the usual ones: depth and history of the queue, reliability,
            durability, deadline, lifespan and liveliness_lease_duration ({'sec', 'nsec'}),
            liveliness.

    Returns:
        Plain data for ``metadata.yaml`` and the metadata of an MCAP channel.
    """
    return {
        'history': 'keep_last', 'depth': 10, 'reliability': 'reliable', 'durability': 'volatile',
        'deadline': FOREVER, 'lifespan': FOREVER, 'liveliness': 'automatic',
        'liveliness_lease_duration': FOREVER, 'avoid_ros_namespace_conventions': False, **values}


def read_qos(text: str) -> list[QosProfile]:
    """Return the profiles in `text`, as any version of rosbag2 wrote them; [] if damaged."""
    try:
        content = parse_yaml(text, aliases=False)[0]
        return [dict(profile) for profile in dump_qos_v9(parse_qos(content))]
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError):
        return []


def read_information(folder: Path) -> dict[str, Any]:
    """
    Return ``rosbag2_bagfile_information`` of the bag `folder`, {} if it cannot be read.

    Its paths, files, topics, duration and start are of the types that rosbag2 writes.
    """
    try:
        content, _ = parse_yaml(read_text(folder / FILE_NAME, MAX_BYTES), aliases=False)
        content = content['rosbag2_bagfile_information']
        entries = [*(content.get('files') or ()), content]
        times = [entry[name][key] for entry in entries for name, key in (
            ('duration', 'nanoseconds'), ('starting_time', 'nanoseconds_since_epoch'))]
        counts = [content['message_count'], *(
            entry['message_count'] for entry in content['topics_with_message_count'])]
        sound = (isinstance(content['relative_file_paths'], list)
                 and all(isinstance(name, str) for name in content['relative_file_paths'])
                 and isinstance(content.get('custom_data') or {}, dict)
                 and all(isinstance(number, int) and 0 <= number < 1 << 63
                         for number in (*times, *counts)))
        return content if sound else {}
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        return {}


def bag_information(files: Sequence[Part], topics: Iterable[BagTopic],
                    custom_data: Mapping[str, str]) -> dict[str, Any]:
    """
    Describe a bag as ``metadata.yaml`` does.

    Args:
        files: the files of the bag, in order.
        topics: its topics.
        custom_data: {key: text} that the bag carries besides.

    Returns:
        The content of ``rosbag2_bagfile_information``.
    """
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        **_span(files),
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': topic.name,
                'type': topic.msgtype,
                'serialization_format': topic.encoding,
                'offered_qos_profiles': topic.qos,
                'type_description_hash': topic.type_hash,
            },
            'message_count': topic.count,
        } for topic in topics],
        'compression_format': '',  # of rosbag2's own compression; MCAP compresses its chunks
        'compression_mode': '',
        'relative_file_paths': [name for name, *_ in files],
        'files': [{'path': file[0], **_span([file])} for file in files],
        'custom_data': dict(custom_data) or None,
        'ros_distro': 'jazzy',
    }


def _span(files: Sequence[Part]) -> dict[str, Any]:
    """Return time and messages of the `files` together."""
    times = [time for _, span, _ in files for time in span or ()]
    return {
        'duration': {'nanoseconds': max(times) - min(times) if times else 0},
        'starting_time': {'nanoseconds_since_epoch': min(times, default=0)},
        'message_count': sum(count for *_, count in files),
    }


def to_yaml(value: Values | Sequence[Values]) -> str:
    """Return `value` as YAML text without anchors, keys in their order."""
    return str(yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False))


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True
