# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Read one SQLite file of a rosbag2 bag."""
from collections.abc import Iterator, Sequence
from pathlib import Path
import sqlite3
from typing import Any
from urllib.parse import quote

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_file
from gearbox_monitor.recordings.decompression import MAX_UNPACKED
from gearbox_monitor.recordings.message_block import Message


class SqliteFile:
    """
    The topics and messages of the file `path`, called `shown` in messages.

    topics: {topic: (message type, number of messages)}; definitions: {message type: (encoding,
    text)}; log_times: of its first and last message on each topic (ns). Only tables are read: a
    view can compute without an end. Raises InputError.
    """

    def __init__(self, path: Path, shown: Path) -> None:
        self._shown = shown
        self.topics: dict[str, tuple[str, int]] = {}
        self.definitions: dict[str, tuple[str, str]] = {}
        self.log_times: list[int] = []
        self._names: dict[int, str] = {}
        try:
            open_file(path).close()
            self._base = sqlite3.connect(f'file:{quote(str(path.absolute()))}?immutable=1',
                                         uri=True)
        except (OSError, sqlite3.Error) as error:
            raise self._unreadable(getattr(error, 'strerror', None) or error) from None
        try:
            self._base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_UNPACKED)
            self._base.execute('PRAGMA trusted_schema = OFF')
            self._read_topics()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the database."""
        self._base.close()

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
        counts = {number: (count, *times) for number, count, *times in self._rows(
            'SELECT topic_id, count(*), min(timestamp), max(timestamp) FROM messages '
            'GROUP BY topic_id')}
        for number, name, kind in self._rows('SELECT id, name, type FROM topics'):
            if not isinstance(name, str) or not isinstance(kind, str):
                raise self._unreadable(f'topic {name!r} of type {kind!r}, expected texts')
            count, *times = counts.get(number, (0,))
            self._names[number] = name
            self.topics[name] = (kind, self.topics.get(name, ('', 0))[1] + count)
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
        return InputError(f'{self._shown}: cannot read: {" ".join(str(problem).split())}')
