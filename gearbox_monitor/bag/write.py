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

"""Write a rosbag2-compatible MCAP bag that a crash or a full disk leaves readable."""
from dataclasses import dataclass, replace
import os
from pathlib import Path
import time

from rosbags.typesys import get_types_from_msg, get_typestore, Stores, TypesysError

from gearbox_monitor.bag import metadata
from gearbox_monitor.bag.bag_part import BagPart, COMPRESSIONS
from gearbox_monitor.bag.record_file import sync_folder, Syncer
from gearbox_monitor.errors import InputError

CHUNK_BYTES = 1 << 20
CHUNK_SECONDS = 0.25


class WriteError(InputError):
    """The bag cannot be continued (disk full, medium gone); what it holds stays readable."""


@dataclass
class McapTopic:
    """A topic of a bag; schema: definition of its type; about: metadata of its channel."""

    name: str
    msgtype: str
    qos: list
    type_hash: str
    schema: bytes
    about: dict
    schema_encoding: str = 'ros2msg'
    encoding: str = 'cdr'
    count: int = 0


class BagWriter:
    """
    Writer of one bag directory ``<path>/<name>_0.mcap``, ... with ``metadata.yaml``.

    Chunks reach the operating system after `chunk_seconds` at the latest, so that a killed
    process loses no more than that: :meth:`write` sees to it while messages come, whoever has
    slower topics calls :meth:`flush_if_due` from a timer, too. With `sync_seconds` they reach the
    medium as much later at the latest, or as long after as that takes, against power cuts; closed,
    the bag is on the medium as a whole.

    The next file begins where one has `max_size` bytes or its messages span `max_seconds` (0: no
    limit). Each is whole by itself and has the metadata records so far. A file that was removed or
    moved is the last one: its content is not given up for another.

    ``metadata.yaml`` is written when the bag is closed, as rosbag2 does: without it rosbag2 asks
    to reindex, with a premature one it would show an empty bag.

    After the first failed write (WriteError, once) the file is cut back to its last whole record
    and every further message is only counted in `dropped`.
    """

    def __init__(self, path, compression='zstd', custom_data=None, chunk_seconds=CHUNK_SECONDS,
                 sync_seconds=None, max_size=0, max_seconds=0.0):
        """Create the bag; InputError when `path` exists or cannot be created."""
        if compression not in COMPRESSIONS:
            raise InputError(f'compression: {compression!r} is unknown, '
                             f'expected one of {", ".join(COMPRESSIONS)}')
        self.path = Path(os.path.abspath(path))
        self.custom_data = dict(custom_data or {})
        self.chunk_seconds = chunk_seconds
        self.message_count = 0
        self.dropped = 0
        self.error = None
        self.last_flush = time.monotonic()
        self._compression = compression
        self._max_size, self._max_ns = max_size, round(max_seconds * 1e9)
        self._unflushed, self._unflushed_bytes = 0, 0
        self._topics, self._records = {}, []
        self._parts = []
        self._typestore = get_typestore(Stores.ROS2_JAZZY)
        self._closed = False
        self._syncer = None
        if os.path.lexists(self.path):
            raise InputError(f'{self.path}: exists already, expected a new bag directory')
        try:
            self.path.mkdir(parents=True)
            self._open_part()
        except OSError as error:
            raise InputError(f'{self.path}: cannot create the bag: {error.strerror}') from None
        if sync_seconds is not None:
            self._syncer = Syncer(self._part.file, sync_seconds)
        self._guarded(self._part.start)

    @property
    def _part(self):
        return self._parts[-1]

    @property
    def byte_count(self):
        """Size of all files so far, bytes."""
        return sum(part.file.end for part in self._parts)

    @property
    def removed(self):
        """Tell in words that the file was removed or moved while it is written, else ''."""
        held = self._part.file.held_at()
        return held and (f'{self._part.path}: removed or moved while it is recorded; as long as '
                         f'the recorder runs, save it: cp {held} saved.mcap')

    @property
    def topics(self):
        """Map of topic to (message type, number of messages)."""
        return {t.name: (t.msgtype, t.count) for t in self._topics.values()}

    def add_topic(self, topic, msgtype, qos=None, msgdef=None):
        """
        Announce `topic` with the `qos` profiles its publishers offer.

        `qos` is a list of :func:`metadata.qos_profile`, one reliable profile when None.
        `msgdef` is the ``ros2msg`` text, dependencies included, of a type outside ROS 2's own.
        """
        if topic in self._topics:
            raise ValueError(f'{topic} was added before')
        qos = [metadata.qos_profile()] if qos is None else list(qos)
        text, type_hash = self._definition(msgtype, msgdef)
        self._announce(McapTopic(topic, msgtype, qos, type_hash, text.encode(), {
            'offered_qos_profiles': metadata.to_yaml(qos) if qos else '',
            'topic_type_hash': type_hash}))

    def copy_topic(self, schema, channel):
        """Announce the topic that `schema` and `channel` (mcap.records) of another bag define."""
        about = channel.metadata
        qos = metadata.read_qos(about.get('offered_qos_profiles', ''))
        self._announce(McapTopic(
            channel.topic, schema.name, qos, about.get('topic_type_hash', ''), schema.data, about,
            schema.encoding, channel.message_encoding))

    def _announce(self, topic):
        if self.error is None:
            self._guarded(self._part.add_topic, topic)
            self._topics[topic.name] = topic

    def write(self, topic, log_ns, cdr_bytes, publish_ns=None, sequence=0):
        """Append one serialised message; times in ns since the epoch."""
        if self.error is not None:
            self.dropped += 1
            return
        if self._is_full(log_ns):
            try:
                self._split()
            except WriteError:
                self.dropped += 1
                raise
        self._unflushed += 1
        self._unflushed_bytes += len(cdr_bytes) + 31
        self._topics[topic].count += 1
        self.message_count += 1
        self._guarded(self._part.write, topic, log_ns, cdr_bytes,
                      log_ns if publish_ns is None else publish_ns, sequence)
        if (self._unflushed_bytes > CHUNK_BYTES
                or time.monotonic() - self.last_flush > self.chunk_seconds):
            self.flush()

    def write_message(self, topic, log_ns, msg, publish_ns=None):
        """Append one message object of rosbags' ROS 2 Jazzy types."""
        msgtype = self._topics[topic].msgtype
        self.write(topic, log_ns, bytes(self._typestore.serialize_cdr(msg, msgtype)), publish_ns)

    def add_metadata(self, name, values):
        """Add an MCAP metadata record, repeated in ``custom_data`` as ``<name>.<key>``."""
        values = {str(key): str(value) for key, value in values.items()}
        self.custom_data.update({f'{name}.{key}': value for key, value in values.items()})
        if self.error is None:
            self._guarded(self._part.add_metadata, name, values)
            self._records.append((name, values))

    def flush_if_due(self):
        """Flush when messages wait and the last flush is `chunk_seconds` ago."""
        if self._unflushed and time.monotonic() - self.last_flush > self.chunk_seconds:
            self.flush()

    def flush(self):
        """End the chunk and hand it to the operating system."""
        if self.error is None and not self._closed:
            self._guarded(self._part.finish_chunk)
            self._unflushed, self._unflushed_bytes = 0, 0
        self.last_flush = time.monotonic()

    def close(self):
        """
        Write index, footer and ``metadata.yaml``; further calls do nothing.

        A bag that has failed keeps its last whole record and gets neither.
        """
        if self._closed:
            return
        self._closed = True
        try:
            if self.error is None:
                self._guarded(self._finish_part)
            if self._syncer is not None:
                self._syncer.close()
            if self.error is None:
                self._guarded(self._part.file.write, b'')  # it raises what the syncer has met
                info = metadata.bag_information(
                    self._parts, list(self._topics.values()), self.custom_data)
                self._guarded(self._write_yaml, {'rosbag2_bagfile_information': info})
        finally:
            self._part.file.close()

    def _is_full(self, log_ns):
        """Return whether a message of `log_ns` belongs into the next file."""
        part = self._part
        return part.start_ns is not None and bool(
            self._max_size and part.file.end + self._unflushed_bytes > self._max_size
            or self._max_ns and log_ns - part.start_ns >= self._max_ns) and not part.file.held_at()

    def _split(self):
        """Finish the file and begin the next one."""
        self.flush()
        self._guarded(self._finish_part)
        if self._syncer is None:
            self._part.file.close()
        self._guarded(self._open_part)
        self._guarded(self._part.start)
        for record in self._records:
            self._guarded(self._part.add_metadata, *record)
        for topic in self._topics.values():
            self._guarded(self._part.add_topic, topic)

    def _open_part(self):
        """Create the next file."""
        name = f'{self.path.name}_{len(self._parts)}.mcap'
        self._parts.append(BagPart(self.path / name, self._compression))
        if self._syncer is not None:
            self._syncer.follow(self._part.file)

    def _finish_part(self):
        """Make the file whole."""
        part = self._part
        part.finish_chunk()
        info = metadata.bag_information(
            [part], [replace(topic, count=part.counts[name])
                     for name, topic in self._topics.items()], self.custom_data)
        part.add_metadata('rosbag2', {'serialized_metadata': metadata.to_yaml(info)})
        part.finish()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _definition(self, msgtype, msgdef):
        """Return (ros2msg text, type hash) of `msgtype`; without a hash if rosbags knows none."""
        try:
            if msgtype not in self._typestore.types and msgdef:
                types = get_types_from_msg(msgdef, msgtype)
                self._typestore.register(
                    {name: t for name, t in types.items() if name not in self._typestore.types})
            text, _ = self._typestore.generate_msgdef(msgtype, ros_version=2)
            return text, self._typestore.hash_rihs01(msgtype)
        except (TypesysError, KeyError):
            return msgdef or '', ''

    def _write_yaml(self, content):
        path = self.path / metadata.FILE_NAME
        temporary = path.with_suffix('.yaml.tmp')
        try:
            with open(temporary, 'w', encoding='utf-8') as file:
                file.write(metadata.to_yaml(content))
                file.flush()
                if self._syncer is not None:
                    os.fsync(file.fileno())
            temporary.replace(path)
            if self._syncer is not None:
                sync_folder(self.path)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise

    def _guarded(self, function, *args, **kwargs):
        """Call `function`; an OSError ends the recording with a WriteError."""
        try:
            return function(*args, **kwargs)
        except OSError as error:
            self.dropped += self._unflushed
            self.message_count -= self._unflushed
            kept = self.byte_count
            if self._part.file.error is not None:  # what else is on the medium is not known
                kept = sum(part.file.synced for part in self._parts)
            self.error = WriteError(
                f'{self._part.path}: cannot write: {error.strerror or error}; '
                f'the {kept} bytes written before are kept')
            raise self.error from None
