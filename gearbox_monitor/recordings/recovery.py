# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Repair a bag that a crash, a power cut or a full disk has truncated.

Every message that can be read is copied unchanged: times, sequence number, bytes, type, order.
"""
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from hashlib import blake2b
import math
import os
from pathlib import Path
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
from gearbox_monitor.recordings.read import named_files, natural, opened_files
from gearbox_monitor.recordings.storage import PACKED, unpacked_files
from gearbox_monitor.recordings.write import BagWriter

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
        local = stack.enter_context(unpacked_files(recordings))
        files, problems = opened_files(dict(zip(local, recordings)))
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
    if str(information.get('compression_mode', '')).lower() == 'message':
        raise InputError(f'{source}: each message is compressed by itself, expected a bag with '
                         'compressed files or chunks; such bags: ros2 bag reindex')
    return files, recovery, information


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
