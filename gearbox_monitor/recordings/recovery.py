# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Repair a bag that a crash, a power cut or a full disk has truncated.

Every message that can be read is copied unchanged: times, sequence number, bytes, type, order.
"""
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, ExitStack
from dataclasses import dataclass, field
from hashlib import blake2b
import math
import os
from pathlib import Path
import struct
import tempfile
import threading
from typing import Any, TypeAlias

from mcap.exceptions import McapError
from mcap.reader import make_reader
import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Values
from gearbox_monitor.recordings import storage
from gearbox_monitor.recordings.cdr import empty_index, find_messages, MESSAGE_HEAD
from gearbox_monitor.recordings.mcap_file import ALL_CHANNELS, McapFile, ScannedChunk, sync_folder
from gearbox_monitor.recordings.read import named_files, natural, open_bag, opened_files
from gearbox_monitor.recordings.storage import PACKED, unpacked_files
from gearbox_monitor.recordings.write import BagWriter

RECOVERED = 'gearbox_monitor_recovered'  # name of the metadata record
HEAD = struct.Struct('<IIQQQ')  # length of the topic, sequence, log time, publish time, size
Work: TypeAlias = list[tuple[McapFile, ScannedChunk]]


@dataclass
class TopicRecovery:
    """
    Recovered and lost messages of one topic.

    estimated: `lost` is estimated from the topic's rate. first_ns, last_ns: log times of the first
    and the last recovered message; dropout_ns: time between them that is known to be missing.
    """

    msgtype: str
    recovered: int = 0
    lost: int = 0
    estimated: bool = False
    first_ns: int | None = None
    last_ns: int | None = None
    dropout_ns: int = 0

    @property
    def period(self) -> float | None:
        """Mean time between two messages (s); None if less than two are recovered."""
        if self.recovered < 2 or self.first_ns is None or self.last_ns is None:
            return None
        span = max(self.last_ns - self.first_ns - self.dropout_ns, 0)
        return span * 1e-9 / (self.recovered - 1)

    def add(self, log_ns: int) -> None:
        """Count a recovered message that was logged at `log_ns`."""
        self.recovered += 1
        self.first_ns = log_ns if self.first_ns is None else min(self.first_ns, log_ns)
        self.last_ns = log_ns if self.last_ns is None else max(self.last_ns, log_ns)


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
    dropouts: list[tuple[int, int]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    cut: bool = False

    @property
    def recovered_s(self) -> float:
        """Time from the first to the last recovered message (s)."""
        times = [time for topic in self.topics.values() for time in (
            topic.first_ns, topic.last_ns) if time is not None]
        return (max(times) - min(times)) * 1e-9 if times else 0.0

    @property
    def lost_s(self) -> float:
        """Time known to be missing (s)."""
        total, until = 0.0, -math.inf
        for begin, end in sorted(self.dropouts):
            total += max(0, end - max(begin, until))
            until = max(until, end)
        return total * 1e-9


def recover(source: str | Path, out: str | Path,
            progress: Callable[[Work], Iterable[tuple[McapFile, ScannedChunk]]] = iter
            ) -> Recovery:
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
        local = stack.enter_context(unpacked_files(recordings))
        files, problems = opened_files(dict(zip(local, recordings)))
        for file in files:
            stack.callback(file.close)
        recovery.notes += problems
        if not recovery.notes and _is_complete(files, information):
            for file in files:
                topic_of = _announce(file, recovery)
                for chunk in file.chunks:
                    for channel, _, log_ns, _, _ in _messages(file, chunk):
                        recovery.topics[topic_of[channel]].add(log_ns)
            return recovery
        with _scratch(out) as path:
            _verify(path, _copied(files, path, recovery, information, source, progress), recovery)
            os.replace(path, out)
            sync_folder(out.parent)
    recovery.written, recovery.cut = out, any(file.truncated for file in files)
    recovery.notes += [f'{file.path}: {text}' for file in files for text in
                       (['cut off'] if file.truncated else [])
                       + [f'damaged {text}' for text in file.damaged]]
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
    if str(information.get('compression_mode', '')).lower() == 'message':
        raise InputError(f'{source}: each message is compressed by itself, expected a bag with '
                         'compressed files or chunks; such bags: ros2 bag reindex')
    return files, recovery, information


def _span(entry: Values) -> tuple[int, int]:
    """Return the log times (ns) at which a bag or file begins and ends, from metadata.yaml."""
    begin = entry.get('starting_time', {}).get('nanoseconds_since_epoch', 0)
    return begin, begin + entry.get('duration', {}).get('nanoseconds', 0)


def _is_complete(files: Sequence[McapFile], information: Values) -> bool:
    """Return whether index, metadata.yaml (if there is one) and every checksum are right."""
    if any(file.truncated or file.damaged for file in files):
        return False
    counts: Counter[str] = Counter()
    for file in files:
        for chunk in file.chunks:
            file.unpacked(chunk)  # notes damage
            for channel_id, count in chunk.counts.items():
                if channel_id not in file.channels:
                    return False
                counts[file.channels[channel_id].topic] += count
    return not any(file.damaged for file in files) and (
        not information or counts == Counter(_stated_counts(information)))


def _stated_counts(information: Values) -> dict[str, int]:
    """Return {topic: number of messages} from metadata.yaml, {} if it does not state them."""
    try:
        return {entry['topic_metadata']['name']: entry['message_count']
                for entry in information['topics_with_message_count']}
    except (KeyError, TypeError):
        return {}


@contextmanager
def _scratch(out: Path) -> Iterator[Path]:
    """Yield the path of a temporary bag on the file system of `out`."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f'.{out.name}_', dir=out.parent) as folder:
            path = Path(folder) / out.name
            try:
                yield path
            except InputError as error:
                raise InputError(str(error).replace(str(path), str(out))) from None
    except OSError as error:
        raise InputError(f'{out}: cannot create the bag: {error.strerror or error}') from None


def _messages(file: McapFile, chunk: ScannedChunk) -> Iterator[tuple[int, int, int, int, bytes]]:
    """Yield (channel id, sequence, log_ns, publish_ns, bytes) of `chunk` in its order."""
    raw = file.unpacked(chunk)
    index = empty_index(len(raw) // MESSAGE_HEAD)
    count, _ = find_messages(np.frombuffer(raw, np.uint8), 0, len(raw), ALL_CHANNELS, False, 0,
                             index)
    for begin, size, channel_id, log_ns, publish_ns in zip(*(
            column[:count].tolist() for column in index)):
        yield (channel_id, int.from_bytes(raw[begin - 20:begin - 16], 'little'), log_ns,
               publish_ns, raw[begin:begin + size])


def _announce(file: McapFile, recovery: Recovery, writer: BagWriter | None = None
              ) -> dict[int, str]:
    """Add the topics of `file`; return {channel id: topic} of those with a definition."""
    topic_of, topics = {}, recovery.topics
    for channel in file.channels.values():
        schema = file.schemas.get(channel.schema_id)
        if schema is None and writer is not None:
            continue
        name = '' if schema is None else schema.name
        if channel.topic not in topics:
            if schema is not None and writer is not None:
                writer.copy_topic(schema, channel)
            topics[channel.topic] = TopicRecovery(name)
        if topics[channel.topic].msgtype == name:
            topic_of[channel.id] = channel.topic
    return topic_of


def _copied(files: Sequence[McapFile], path: Path, recovery: Recovery, information: Values,
            source: Path, progress: Callable[[Work], Iterable[tuple[McapFile, ScannedChunk]]]
            ) -> bytes:
    """
    Copy all messages to the new bag `path`; return their hash, in which the order counts.

    Args:
        files: of the damaged bag.
        path: of the new one.
        recovery: which gets counts, losses and notes.
        information: of metadata.yaml.
        source: the damaged bag, as messages name it.
        progress: passes on the work and shows it.

    Raises:
        InputError: there is no message, or the bag cannot be written.
    """
    compression = next((chunk.compression for file in files for chunk in file.chunks), 'zstd')
    digest, undefined = blake2b(), 0
    newest: dict[McapFile, list[tuple[int, str, int]]] = {file: [] for file in files}
    with BagWriter(path, compression or 'none', information.get('custom_data') or {}, math.inf,
                   threading.TIMEOUT_MAX) as writer:
        for file in files:
            for name, values in file.metadata.items():
                if name != 'rosbag2':  # the old metadata.yaml
                    writer.add_metadata(name, values)
        topics_of = {file: _announce(file, recovery, writer) for file in files}
        work = [(file, chunk) for file in files for chunk in file.chunks]
        for file, chunk in progress(work):
            counts: Counter[int] = Counter()
            last: dict[str, int] = {}
            for channel, sequence, log_ns, publish_ns, raw in _messages(file, chunk):
                counts[channel] += 1
                topic = topics_of[file].get(channel, '')
                last[topic] = max(log_ns, last.get(topic, log_ns))
                if not topic:
                    undefined += 1
                    continue
                writer.write(topic, log_ns, raw, publish_ns, sequence)
                digest.update(_hashed(topic, sequence, log_ns, publish_ns, raw))
                recovery.topics[topic].add(log_ns)
            newest[file] += [(chunk.begin, topic, log_ns) for topic, log_ns in last.items()]
            for channel, count in chunk.counts.items():
                if channel in topics_of[file]:  # an index may be damaged, too
                    recovery.topics[topics_of[file][channel]].lost += max(
                        0, count - counts[channel])
        if not writer.message_count:
            raise InputError(f'{source}: no whole message remains, nothing to recover')
        _estimate_losses(newest, recovery, information)
        if undefined:
            recovery.notes.append(f'{undefined} messages have lost their definition and are left '
                                  'out')
        writer.add_metadata(RECOVERED, {
            'version': __version__, 'from': os.path.abspath(source),
            'lost_s': f'{recovery.lost_s:.3f}',
            'lost_messages': sum(topic.lost for topic in recovery.topics.values())})
    return digest.digest()


def _hashed(topic: str, sequence: int, log_ns: int, publish_ns: int, raw: bytes) -> bytes:
    """Return the bytes of a message that count when two bags are compared."""
    name = topic.encode()
    return HEAD.pack(len(name), sequence, log_ns, publish_ns, len(raw)) + name + raw


def _estimate_losses(newest: dict[McapFile, list[tuple[int, str, int]]], recovery: Recovery,
                     information: Values) -> None:
    """
    Note the missing data: exactly where metadata.yaml states it, else estimated.

    newest: (offset of a chunk, topic, newest log time) of what was read of each file.
    """
    topics, dropouts = recovery.topics, recovery.dropouts
    end_ns = max(topic.last_ns for topic in topics.values() if topic.last_ns is not None)
    for file, ends in newest.items():
        for offset, (begin, end) in file.torn.items():
            begin = max((time for place, _, time in ends if place <= offset), default=begin)
            dropouts += [(begin, end)] if begin < end else []
    counts = _stated_counts(information)
    if counts:
        _, stated_end = _span(information)
        dropouts += [(end_ns, stated_end)] if stated_end > end_ns else []
    cuts = {file: max(file.torn.values(), key=lambda times: times[1]) for file in newest
            if file.truncated and file.torn}
    for name, topic in topics.items():
        if topic.first_ns is not None and topic.last_ns is not None:
            topic.dropout_ns = sum(end - begin for begin, end in dropouts
                                   if topic.first_ns <= begin and end <= topic.last_ns)
        period = topic.period
        if name in counts:
            topic.lost = max(topic.lost, counts[name] - topic.recovered)
        elif period:
            missing = sum(max(0, int((end - max(
                (time for _, own, time in newest[file] if own == name), default=begin))
                * 1e-9 / period)) for file, (begin, end) in cuts.items())
            topic.lost += missing
            topic.estimated = missing > 0


def _verify(path: Path, digest: bytes, recovery: Recovery) -> None:
    """Read the new bag back by the library, too. Raises InputError if a message differs."""
    copied = blake2b()
    with open_bag(path) as reader:
        identical = not reader.notice and {name: count for name, (_, count) in
                                           reader.topics.items()} == {
            name: topic.recovered for name, topic in recovery.topics.items()}
    (file,) = named_files(path, storage.read_information(path))
    try:
        with open(file, 'rb') as stream:
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages(
                    log_time_order=False):
                copied.update(_hashed(channel.topic, message.sequence, message.log_time,
                                      message.publish_time, message.data))
    except McapError:
        identical = False
    if not identical or copied.digest() != digest:
        raise InputError(f'{path}: the written bag differs when read back, expected a medium '
                         'without errors')
