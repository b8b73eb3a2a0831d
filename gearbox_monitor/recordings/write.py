# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Write a rosbag2-compatible MCAP bag that a crash or a full disk leaves readable.

A bag that a crash, a power cut or a full disk has truncated is repaired: every message that can be
read is copied unchanged, with times, sequence number, bytes, type and order.
"""
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass, field, replace
from hashlib import blake2b
import math
import os
from pathlib import Path
import tempfile
import threading
import time
from types import TracebackType
from typing import Any, ParamSpec, TypeAlias, TypeVar

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Schema
import numpy as np
from rosbags.typesys import get_types_from_msg, get_typestore, Stores, TypesysError

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.recordings import storage
from gearbox_monitor.recordings.cdr import empty_index, find_messages, MESSAGE_HEAD, MessageBlock
from gearbox_monitor.recordings.mcap_file import (
    ALL_CHANNELS, COMPRESSIONS, McapFile, McapWriter, RecordFile, ScannedChunk, sync_folder)
from gearbox_monitor.recordings.read import (
    expect_unpacked, named_files, natural, opened_files, PACKED)

CHUNK_BYTES = 1 << 20
CHUNK_SECONDS = 0.25


P = ParamSpec('P')
T = TypeVar('T')


class WriteError(InputError):
    """The bag cannot be continued (disk full, medium gone); what it holds stays readable."""


class BagWriter(AbstractContextManager['BagWriter']):
    """
    Writer of one bag directory ``<path>/<name>_0.mcap``, ... with ``metadata.yaml``.

    :meth:`write` hands a chunk to the operating system at least every `chunk_seconds`, so that a
    killed process loses no more than that. With slower topics, call :meth:`flush_if_due` from a
    timer, too. A closed bag is on the medium completely if `sync_seconds` is set.

    Each file is complete by itself and holds the metadata records so far. A file that was removed
    or moved stays the last one, because closing it would delete its content.

    ``metadata.yaml`` is written when the bag is closed, as rosbag2 does: without it rosbag2 asks
    to reindex, with a premature one it would show an empty bag.

    The first failed write raises WriteError and truncates the file to its last whole record; every
    further message is only counted in `dropped`.

    Args:
        path: the new bag directory.
        compression: of the chunks, a key of COMPRESSIONS.
        custom_data: {key: text} for ``metadata.yaml``.
        chunk_seconds: longest time that a message waits in a chunk, s.
        sync_seconds: time between two syncs to the medium, s, against power cuts; None: never.
        max_size: size at which the next file begins, bytes; 0: no limit.
        max_seconds: time span at which the next file begins, s; 0: no limit.

    Raises:
        InputError: `path` exists or cannot be created, or the compression is unknown.
    """

    def __init__(self, path: str | Path, compression: str = 'zstd',
                 custom_data: Mapping[str, str] | None = None,
                 chunk_seconds: float = CHUNK_SECONDS, sync_seconds: float | None = None,
                 max_size: int = 0, max_seconds: float = 0.0) -> None:
        if compression not in COMPRESSIONS:
            raise InputError(f'compression: {compression!r} is unknown, '
                             f'expected one of {", ".join(COMPRESSIONS)}')
        self.path = Path(os.path.abspath(path))
        self.custom_data = dict(custom_data or {})
        self.chunk_seconds = chunk_seconds
        self.message_count = 0
        self.dropped = 0
        self.error: WriteError | None = None
        self.last_flush = time.monotonic()
        self._compression = compression
        self._max_size, self._max_ns = max_size, round(max_seconds * 1e9)
        self._unflushed, self._unflushed_bytes = 0, 0
        self._topics: dict[str, storage.BagTopic] = {}
        self._records: list[tuple[str, dict[str, str]]] = []
        self._parts: list[McapWriter] = []
        self._typestore = get_typestore(Stores.ROS2_JAZZY)
        self._closed = False
        self._sync_seconds, self._sync_errors = sync_seconds, list[OSError]()
        if os.path.lexists(self.path):
            raise InputError(f'{self.path}: exists already, expected a new bag directory')
        try:
            self.path.mkdir(parents=True)
            self._open_part()
        except OSError as error:
            raise InputError(f'{self.path}: cannot create the bag: {error.strerror}') from None
        self._guarded(self._part.start)

    @property
    def _part(self) -> McapWriter:
        return self._parts[-1]

    @property
    def byte_count(self) -> int:
        """Size of all files so far, bytes."""
        return sum(part.file.end for part in self._parts)

    @property
    def removed(self) -> str:
        """A warning if the file was removed or moved while it is written, else ''."""
        source = self._part.file.rescue_path()
        return source and (f'{self._part.path}: removed or moved while it is recorded; as long as '
                           f'the recorder runs, save it: cp {source} saved.mcap')

    @property
    def topics(self) -> dict[str, tuple[str, int]]:
        """Map of topic to (message type, number of messages)."""
        return {t.name: (t.msgtype, t.count) for t in self._topics.values()}

    def add_topic(self, topic: str, msgtype: str,
                  qos: Iterable[storage.QosProfile] | None = None, msgdef: str | None = None
                  ) -> None:
        """
        Add a topic with the QoS profiles that its publishers offer.

        Args:
            topic: its name.
            msgtype: type of its messages, such as 'sensor_msgs/msg/JointState'.
            qos: profiles from :func:`metadata.qos_profile`; None: one reliable profile.
            msgdef: ``ros2msg`` text, dependencies included, of a type that ROS 2 does not define.

        Raises:
            WriteError: the file cannot be written.
        """
        if topic in self._topics:
            raise ValueError(f'{topic} was added before')
        qos = [storage.qos_profile()] if qos is None else list(qos)
        text, type_hash = self._definition(msgtype, msgdef)
        self._announce(storage.BagTopic(topic, msgtype, qos, type_hash, text.encode(), {
            'offered_qos_profiles': storage.to_yaml(qos) if qos else '',
            'topic_type_hash': type_hash}))

    def copy_topic(self, schema: Schema, channel: Channel) -> None:
        """Add the topic that `schema` and `channel` of another bag define."""
        offer = channel.metadata
        qos = storage.read_qos(offer.get('offered_qos_profiles', ''))
        self._announce(storage.BagTopic(
            channel.topic, schema.name, qos, offer.get('topic_type_hash', ''), schema.data, offer,
            schema.encoding, channel.message_encoding))

    def _announce(self, topic: storage.BagTopic) -> None:
        if self.error is None:
            self._guarded(self._part.add_topic, topic)
            self._topics[topic.name] = topic

    def write(self, topic: str, log_ns: int, cdr_bytes: bytes, publish_ns: int | None = None,
              sequence: int = 0) -> None:
        """
        Append one serialised message.

        Args:
            topic: name of a topic that was added.
            log_ns: when it was recorded, ns since the epoch.
            cdr_bytes: the message.
            publish_ns: when it was published, ns since the epoch; None: when it was recorded.
            sequence: its number among the messages of its publisher, 0 if unknown.

        Raises:
            InputError: `log_ns` is negative.
            WriteError: the first time that the file cannot be written.
        """
        self._expect_time(log_ns)
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
        self._unflushed_bytes += len(cdr_bytes) + MESSAGE_HEAD
        self._topics[topic].count += 1
        self.message_count += 1
        self._guarded(self._part.write, topic, log_ns, cdr_bytes,
                      log_ns if publish_ns is None else publish_ns, sequence)
        self._flush_if_full()

    def write_block(self, block: MessageBlock) -> None:
        """
        Append the messages of `block`, on topics that were added, in its order.

        The file gets what `write` writes message by message, in a fraction of the time. Raises
        what `write` raises.
        """
        if len(block):
            self._expect_time(int(block.log_ns.min()))
        total = self.message_count + self.dropped + len(block)
        try:
            if self._max_size or self._max_ns:  # each message may begin a file
                for topic, log_ns, publish_ns, raw in block.messages():
                    self.write(topic, log_ns, raw, publish_ns)
            elif self.error is None:
                self._write_chunks(block)
        finally:
            self.dropped = total - self.message_count

    def _expect_time(self, log_ns: int) -> None:
        """Raise InputError if `log_ns` is no log time: a damaged bag may give a negative one."""
        if log_ns < 0:
            raise InputError(f'{self.path}: cannot write a message logged at {log_ns} ns since '
                             '1970, expected 0 or later')

    def _write_chunks(self, block: MessageBlock) -> None:
        """Append the messages of `block`; a chunk ends behind that with which it is full."""
        ends = np.cumsum(block.size + MESSAGE_HEAD)
        begin = done = 0
        while begin < len(block):
            full = np.searchsorted(ends, done + CHUNK_BYTES - self._unflushed_bytes, 'right')
            end = min(int(full) + 1, len(block))
            self._write_rows(block.take(slice(begin, end)))
            begin, done = end, int(ends[end - 1])

    def _write_rows(self, block: MessageBlock) -> None:
        """Append the messages of `block` to the chunk."""
        self._unflushed += len(block)
        self._unflushed_bytes += int(block.size.sum()) + MESSAGE_HEAD * len(block)
        for topic, count in zip(block.topics, np.bincount(block.topic).tolist()):
            if count:
                self._topics[topic].count += count
        self.message_count += len(block)
        self._guarded(self._part.write_block, block)
        self._flush_if_full()

    def _flush_if_full(self) -> None:
        if (self._unflushed_bytes > CHUNK_BYTES
                or time.monotonic() - self.last_flush > self.chunk_seconds):
            self.flush()

    def write_message(self, topic: str, log_ns: int, msg: object) -> None:
        """
        Append one message object.

        Args:
            topic: name of a topic that was added.
            log_ns: when it was recorded, ns since the epoch.
            msg: message of rosbags' ROS 2 Jazzy types.

        Raises:
            WriteError: the first time that the file cannot be written.
        """
        msgtype = self._topics[topic].msgtype
        self.write(topic, log_ns, bytes(self._typestore.serialize_cdr(msg, msgtype)))

    def add_metadata(self, name: str, values: Mapping[str, object]) -> None:
        """Add the MCAP metadata record `name` of `values`; custom_data repeats it as name.key."""
        texts = {str(key): str(value) for key, value in values.items()}
        self.custom_data.update({f'{name}.{key}': text for key, text in texts.items()})
        if self.error is None:
            self._guarded(self._part.add_metadata, name, texts)
            self._records.append((name, texts))

    def flush_if_due(self) -> None:
        """Flush if messages wait and the last flush was `chunk_seconds` ago."""
        if self._unflushed and time.monotonic() - self.last_flush > self.chunk_seconds:
            self.flush()

    def flush(self) -> None:
        """End the chunk and hand it to the operating system."""
        if self.error is None and not self._closed:
            self._guarded(self._finish_chunk)
        self.last_flush = time.monotonic()

    def close(self) -> None:
        """
        Write index, footer and ``metadata.yaml``; further calls do nothing.

        After a failed write, none of them is written.
        """
        if self._closed:
            return
        self._closed = True
        try:
            if self.error is None:
                self._guarded(self._finish_part)
            for part in self._parts:
                part.file.close()
            if self.error is None:
                self._guarded(self._part.file.write, b'')  # raises the error of a sync
                info = storage.bag_information(
                    [part.summary for part in self._parts], list(self._topics.values()),
                    self.custom_data)
                self._guarded(self._write_yaml, {'rosbag2_bagfile_information': info})
        finally:
            self._part.file.close(wait=False)

    def _is_full(self, log_ns: int) -> bool:
        """Return whether a message of `log_ns` belongs in the next file."""
        part = self._part
        return part.span is not None and bool(
            self._max_size and part.file.end + self._unflushed_bytes > self._max_size
            or self._max_ns and log_ns - part.span[0] >= self._max_ns
        ) and not part.file.rescue_path()

    def _split(self) -> None:
        """Finish the file and begin the next one."""
        self.flush()
        self._guarded(self._finish_part)
        self._part.file.close(wait=False)
        self._guarded(self._open_part)
        self._guarded(self._part.start)
        for record in self._records:
            self._guarded(self._part.add_metadata, *record)
        for topic in self._topics.values():
            self._guarded(self._part.add_topic, topic)

    def _open_part(self) -> None:
        """Create the next file."""
        path = self.path / f'{self.path.name}_{len(self._parts)}.mcap'
        self._parts.append(McapWriter(path, self._compression, RecordFile(
            path, self._sync_seconds, self._sync_errors)))

    def _finish_chunk(self) -> None:
        """Write the chunk; none of its messages is lost any more."""
        self._part.finish_chunk()
        self._unflushed, self._unflushed_bytes = 0, 0

    def _finish_part(self) -> None:
        """Write the index and the footer of the file."""
        self._finish_chunk()
        part = self._part
        info = storage.bag_information(
            [part.summary], [replace(topic, count=part.counts[name])
                             for name, topic in self._topics.items()], self.custom_data)
        part.add_metadata('rosbag2', {'serialized_metadata': storage.to_yaml(info)})
        part.finish()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        self.close()

    def _definition(self, msgtype: str, msgdef: str | None) -> tuple[str, str]:
        """Return (ros2msg text, type hash) of `msgtype`; '' if rosbags cannot hash it."""
        try:
            if msgtype not in self._typestore.types and msgdef:
                types = get_types_from_msg(msgdef, msgtype)
                self._typestore.register(
                    {name: t for name, t in types.items() if name not in self._typestore.types})
            text, _ = self._typestore.generate_msgdef(msgtype, ros_version=2)
            return text, self._typestore.hash_rihs01(msgtype)
        except (TypesysError, KeyError):
            return msgdef or '', ''

    def _write_yaml(self, content: dict[str, Any]) -> None:
        path = self.path / storage.FILE_NAME
        temporary = path.with_suffix('.yaml.tmp')
        try:
            with open(temporary, 'w', encoding='utf-8') as file:
                file.write(storage.to_yaml(content))
                file.flush()
                if self._sync_seconds is not None:
                    os.fsync(file.fileno())
            temporary.replace(path)
            if self._sync_seconds is not None:
                sync_folder(self.path)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise

    def _guarded(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call `function`; an OSError ends the recording with a WriteError."""
        try:
            return function(*args, **kwargs)
        except OSError as error:
            self.dropped += self._unflushed
            self.message_count -= self._unflushed
            size = self.byte_count
            if self._sync_errors:  # only synced bytes are surely on the medium
                size = sum(part.file.synced for part in self._parts)
            self.error = WriteError(
                f'{self._part.path}: cannot write: {error.strerror or error}; '
                f'the {size} bytes written before are kept')
            raise self.error from None


RECOVERED = 'gearbox_monitor_recovered'  # name of the metadata record
Work: TypeAlias = list[tuple[McapFile, ScannedChunk]]
Progress: TypeAlias = Callable[[Work], Iterable[tuple[McapFile, ScannedChunk]]]


@dataclass
class TopicRecovery:
    """
    Recovered messages of one topic, and those that an index or metadata.yaml states, but are lost.

    first_ns, last_ns: log times of the first and the last recovered message.
    """

    msgtype: str
    recovered: int = 0
    lost: int = 0
    first_ns: float = math.inf
    last_ns: float = -math.inf

    @property
    def seconds(self) -> float:
        """Time from the first to the last recovered message (s)."""
        return max(0.0, (self.last_ns - self.first_ns) * 1e-9)


@dataclass
class Recovery:
    """
    Result of a repair.

    written: the new bag, None if the old one is complete and needs none. topics: {name:
    TopicRecovery}. dropouts: [(begin, end)] log times (ns) of missing data. cut: the old bag has
    no end. notes: further damage.
    """

    written: Path | None = None
    topics: dict[str, TopicRecovery] = field(default_factory=dict)
    dropouts: list[tuple[float, float]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    cut: bool = False

    @property
    def recovered_s(self) -> float:
        """Time from the first to the last recovered message (s)."""
        first = min((topic.first_ns for topic in self.topics.values()), default=0.0)
        last = max((topic.last_ns for topic in self.topics.values()), default=0.0)
        return max(0.0, (last - first) * 1e-9)

    @property
    def lost_s(self) -> float:
        """Time known to be missing (s)."""
        total, until = 0.0, -math.inf
        for begin, end in sorted(self.dropouts):
            total += max(0.0, end - max(begin, until))
            until = max(until, end)
        return total * 1e-9


def recover(source: str | Path, out: str | Path, progress: Progress = iter) -> Recovery:
    """
    Copy all readable messages of a damaged bag to a new bag; a complete bag is not copied.

    The new bag gets its name after it was read back and holds the same messages; a failure leaves
    no part of it.

    Args:
        source: the damaged bag, directory or file; it is only read.
        out: the new bag directory.
        progress: wraps the list of chunks to copy, such as tqdm.

    Returns:
        The Recovery.

    Raises:
        InputError: there is nothing to recover, or the new bag cannot be written.
    """
    source, out = Path(source), Path(os.path.abspath(out))
    if os.path.lexists(out):
        raise InputError(f'{out}: exists already, expected a new bag directory')
    recordings, recovery, information = _recordings(source)
    with ExitStack() as stack:
        files, problems = opened_files(recordings)
        for file in files:
            stack.callback(file.close)
        recovery.notes += problems
        if not recovery.notes and not any(file.truncated for file in files):
            whole = Recovery()
            _copy(files, whole, None, iter)
            counts = {name: topic.recovered for name, topic in whole.topics.items()}
            if not (whole.notes or any(file.damaged for file in files) or any(
                    topic.lost for topic in whole.topics.values())) and (
                    not information or Counter(counts) == Counter(_stated_counts(information))):
                return whole
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
            folder = stack.enter_context(tempfile.TemporaryDirectory(
                prefix=f'.{out.name}_', dir=out.parent))
            _write(Path(folder) / out.name, files, recovery, information, source, progress)
            os.replace(Path(folder) / out.name, out)
            sync_folder(out.parent)
        except InputError as error:
            raise InputError(str(error).replace(str(Path(folder) / out.name), str(out))) from None
        except OSError as error:
            raise InputError(f'{out}: cannot create the bag: {error.strerror or error}') from None
    recovery.written, recovery.cut = out, any(file.truncated for file in files)
    recovery.notes += [f'{file.path}: {text}' for file in files for text in (
        *['cut off'] * file.truncated, *(f'damaged {text}' for text in file.damaged))]
    return recovery


def _recordings(source: Path) -> tuple[list[Path], Recovery, dict[str, Any]]:
    """Return (files of the bag `source`, new Recovery, content of its metadata.yaml)."""
    recovery, information = Recovery(), {}
    if os.path.isdir(source):
        information = storage.read_information(source)
        listed = named_files(source, information)
        # A file that was begun after metadata.yaml was written is not listed in it.
        files = sorted({*source.glob('*.mcap'), *source.glob('*.mcap' + PACKED),
                        *filter(os.path.isfile, listed)}, key=natural)
        for file, entry in zip(listed, information.get('files') or [{}] * len(listed)):
            if not os.path.isfile(file):
                recovery.notes.append(f'{file}: missing')
                recovery.dropouts.append(_span(entry))
        if not information:
            recovery.notes.append(f'{source / storage.FILE_NAME}: missing or damaged')
    elif os.path.exists(source):
        files = [source]
    else:
        raise InputError(f'{source}: no such file or directory, expected a bag')
    if not files or any('.db3' in f.suffixes for f in files):
        raise InputError(f'{source}: holds no MCAP file, expected a bag directory or .mcap file; '
                         'others: ros2 bag reindex')
    return expect_unpacked(source, files, information), recovery, information


def _span(entry: Values) -> tuple[int, int]:
    """Return the log times (ns) at which a bag or file begins and ends, from metadata.yaml."""
    begin = entry.get('starting_time', {}).get('nanoseconds_since_epoch', 0)
    return begin, begin + entry.get('duration', {}).get('nanoseconds', 0)


def _stated_counts(information: Values) -> dict[str, int]:
    """Return {topic: number of messages} from metadata.yaml, {} if it does not state them."""
    try:
        return {entry['topic_metadata']['name']: entry['message_count']
                for entry in information['topics_with_message_count']}
    except (KeyError, TypeError):
        return {}


def _announced(file: McapFile, recovery: Recovery, writer: BagWriter | None) -> dict[int, str]:
    """Add the topics of `file`; return {channel id: topic} of those with a definition."""
    topic_of, topics = {}, recovery.topics
    for channel in file.channels.values():
        schema = file.schemas.get(channel.schema_id)
        if writer is not None and schema is None:
            continue
        name = '' if schema is None else schema.name
        if channel.topic not in topics:
            if writer is not None and schema is not None:
                writer.copy_topic(schema, channel)
            topics[channel.topic] = TopicRecovery(name)
        if topics[channel.topic].msgtype == name:
            topic_of[channel.id] = channel.topic
    return topic_of


def _copy(files: Sequence[McapFile], recovery: Recovery, writer: BagWriter | None,
          progress: Progress) -> bytes:
    """Count all messages, write them to `writer`, if any, and return their hash."""
    digest, undefined = blake2b(), 0
    topics_of = {file: _announced(file, recovery, writer) for file in files}
    newest: dict[McapFile, list[tuple[int, int]]] = {file: [] for file in files}
    work = [(file, chunk) for file in files for chunk in file.chunks]
    for file, chunk in progress(work):
        raw, counts = file.unpacked(chunk), Counter[int]()
        index = empty_index(len(raw) // MESSAGE_HEAD)
        count, _ = find_messages(np.frombuffer(raw, np.uint8), 0, len(raw), ALL_CHANNELS, False, 0,
                                 index)
        for begin, size, channel, log_ns, publish_ns in zip(*(
                column[:count].tolist() for column in index)):
            counts[channel] += 1
            if channel not in topics_of[file]:
                undefined += 1
                continue
            name, data = topics_of[file][channel], raw[begin:begin + size]
            topic = recovery.topics[name]
            topic.recovered += 1
            topic.first_ns, topic.last_ns = min(topic.first_ns, log_ns), max(topic.last_ns, log_ns)
            if writer is not None:
                sequence = int.from_bytes(raw[begin - 20:begin - 16], 'little')
                writer.write(name, log_ns, data, publish_ns, sequence)
                digest.update(repr((name, log_ns, publish_ns, sequence)).encode() + data)
        newest[file].append((chunk.begin, int(index.log_ns[:count].max(initial=0))))
        for channel, stated in chunk.counts.items():
            if channel in topics_of[file]:  # an index may be damaged, too
                recovery.topics[topics_of[file][channel]].lost += max(0, stated - counts[channel])
    for file in files:
        for place, (first, end) in file.torn.items():
            first = max((time for begin, time in newest[file] if begin <= place), default=first)
            recovery.dropouts += [(first, end)] if first < end else []
    if undefined:
        recovery.notes.append(f'{undefined} messages have lost their definition and are left out')
    return digest.digest()


def _write(path: Path, files: Sequence[McapFile], recovery: Recovery, information: Values,
           source: Path, progress: Progress) -> None:
    """Write the new bag `path`, and read it back by the library. Raises InputError."""
    compression = next((chunk.compression for file in files for chunk in file.chunks), 'zstd')
    with BagWriter(path, compression or 'none', information.get('custom_data') or {}, math.inf,
                   threading.TIMEOUT_MAX) as writer:
        for file in files:
            for name, values in file.metadata.items():
                if name != 'rosbag2':  # the old metadata.yaml
                    writer.add_metadata(name, values)
        digest = _copy(files, recovery, writer, progress)
        if not writer.message_count:
            raise InputError(f'{source}: no whole message remains, nothing to recover')
        counts = _stated_counts(information)
        end_ns = max(topic.last_ns for topic in recovery.topics.values())
        if counts and _span(information)[1] > end_ns:
            recovery.dropouts.append((end_ns, _span(information)[1]))
        for name, topic in recovery.topics.items():
            topic.lost = max(topic.lost, counts.get(name, 0) - topic.recovered)
        writer.add_metadata(RECOVERED, {
            'version': __version__, 'from': os.path.abspath(source),
            'lost_s': f'{recovery.lost_s:.3f}',
            'lost_messages': sum(topic.lost for topic in recovery.topics.values())})
    copied = blake2b()
    (file_path,) = named_files(path, storage.read_information(path))
    with suppress(McapError), open(file_path, 'rb') as stream:
        for _, channel, m in make_reader(stream, validate_crcs=True).iter_messages(
                log_time_order=False):
            copied.update(repr((channel.topic, m.log_time, m.publish_time,
                                m.sequence)).encode() + m.data)
    if copied.digest() != digest:
        raise InputError(f'{path}: the written bag differs when read back, expected a medium '
                         'without errors')
