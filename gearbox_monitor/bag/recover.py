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

"""
Make a whole bag of what a crash, a power cut or a full disk has left of one.

Every message that can be read is copied as it is: times, sequence number, bytes, type, order.
"""
from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import blake2b
import math
import os
from pathlib import Path
import struct
import tempfile
import threading

from mcap.exceptions import McapError
from mcap.reader import make_reader
import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag import metadata
from gearbox_monitor.bag.mcap_file import ALL_CHANNELS, McapFile
from gearbox_monitor.bag.message_block import find_messages, MESSAGE_HEAD
from gearbox_monitor.bag.read import named_files, natural, open_bag
from gearbox_monitor.bag.record_file import sync_folder
from gearbox_monitor.bag.write import BagWriter
from gearbox_monitor.errors import InputError

RECOVERED = 'gearbox_monitor_recovered'  # name of the metadata record
HEAD = struct.Struct('<IQQQ')  # sequence, log time, publish time, size


@dataclass
class TopicRecovery:
    """
    What became of one topic: kept and lost messages.

    about: `lost` is estimated from the topic's rate. first_ns, last_ns: log times of what is kept;
    away_ns: time between them that is known to be missing.
    """

    msgtype: str
    kept: int = 0
    lost: int = 0
    about: bool = False
    first_ns: int | None = None
    last_ns: int | None = None
    away_ns: int = 0

    @property
    def period(self):
        """Mean time between two messages (s); None where less than two are kept."""
        if self.kept < 2:
            return None
        return max(self.last_ns - self.first_ns - self.away_ns, 0) * 1e-9 / (self.kept - 1)

    def add(self, log_ns):
        """Count a kept message."""
        self.kept += 1
        self.first_ns = log_ns if self.first_ns is None else min(self.first_ns, log_ns)
        self.last_ns = log_ns if self.last_ns is None else max(self.last_ns, log_ns)


@dataclass
class Recovery:
    """
    What was kept and lost.

    written: the new bag, None where the old one is whole and needs none. topics: {name:
    TopicRecovery}. lost: [(begin, end)] log times (ns) of what is missing. cut: the old bag has
    no end. notes: what else is wrong with it.
    """

    written: Path | None = None
    topics: dict = field(default_factory=dict)
    lost: list = field(default_factory=list)
    notes: list = field(default_factory=list)
    cut: bool = False

    @property
    def kept_s(self):
        """Time from the first to the last message kept (s)."""
        times = [t for topic in self.topics.values() if topic.kept
                 for t in (topic.first_ns, topic.last_ns)]
        return (max(times) - min(times)) * 1e-9 if times else 0.0

    @property
    def lost_s(self):
        """Time known to be missing (s)."""
        total, until = 0, -math.inf
        for begin, end in sorted(self.lost):
            total += max(0, end - max(begin, until))
            until = max(until, end)
        return total * 1e-9


def recover(source, out, progress=iter):
    """
    Write what can be read of the bag `source` to the new bag `out`; return the Recovery.

    `source` is only read. `out` has its name once it was read again and holds the same messages,
    so after a failure there is nothing of it. A whole bag is not copied. `progress` wraps the list
    of the parts to be copied, as tqdm. Raises InputError.
    """
    source, out = Path(source), Path(os.path.abspath(out))
    if os.path.lexists(out):
        raise InputError(f'{out}: exists already, expected a new bag directory')
    recordings, recovery, told = _recordings(source)
    files = _opened(recordings, recovery)
    try:
        if not recovery.notes and _is_whole(files, told):
            _count_whole(files, recovery)
            return recovery
        with _scratch(out) as path:
            digest = _copy(source, files, path, recovery, told, progress)
            _check(path, digest, recovery)
            os.replace(path, out)
            sync_folder(out.parent)
    finally:
        for file in files:
            file.close()
    recovery.written, recovery.cut = out, any(file.truncated for file in files)
    recovery.notes += [f'{file.path}: {text}' for file in files for text in
                       (['cut off'] if file.truncated else [])
                       + [f'damaged {text}' for text in file.damaged]]
    return recovery


def _recordings(source):
    """Return (files of the bag `source`, new Recovery, what its metadata.yaml tells)."""
    recovery, told = Recovery(), {}
    if os.path.isdir(source):
        told = metadata.read_information(source)
        named = named_files(source, told)
        # A file that was begun after metadata.yaml was written is not named in it.
        files = sorted({*source.glob('*.mcap'), *(f for f in named if f.is_file())}, key=natural)
        for file, about in zip(named, told.get('files') or [{}] * len(named)):
            if not file.is_file():
                recovery.notes.append(f'{file}: missing')
                begin = about.get('starting_time', {}).get('nanoseconds_since_epoch', 0)
                recovery.lost.append((begin, begin + about.get('duration', {}).get(
                    'nanoseconds', 0)))
        if not told:
            recovery.notes.append(f'{source / metadata.FILE_NAME}: missing or damaged')
    elif os.path.exists(source):
        files = [source]
    else:
        raise InputError(f'{source}: no such file or directory, expected a bag')
    if not files or told.get('compression_mode') or any(f.suffix == '.db3' for f in files):
        raise InputError(f'{source}: holds no MCAP file, expected a bag directory or .mcap file; '
                         'others: ros2 bag reindex')
    return files, recovery, told


def _opened(paths, recovery):
    """Return the McapFiles of `paths`; of several, one may be unreadable, which is noted."""
    files = []
    for path in paths:
        try:
            files.append(McapFile(path))
        except InputError as error:
            if len(paths) == 1:
                raise
            recovery.notes.append(str(error))
    if not files:
        raise InputError(recovery.notes[-1])
    return files


def _is_whole(files, told):
    """Return whether nothing is to be done: index, metadata.yaml where due, every checksum."""
    if any(file.truncated or file.damaged for file in files):
        return False
    counts = Counter()
    for file in files:
        for chunk in file.chunks:
            for channel_id, count in chunk.counts.items():
                if channel_id not in file.channels:
                    return False
                counts[file.channels[channel_id].topic] += count
    if told and counts != Counter(_told_counts(told)):
        return False
    for file in files:
        for chunk in file.chunks:
            file.unpacked(chunk)
    return not any(file.damaged for file in files)


def _told_counts(told):
    """Return {topic: number of messages} as metadata.yaml tells it, {} where it does not."""
    try:
        return {entry['topic_metadata']['name']: int(entry['message_count'])
                for entry in told['topics_with_message_count']}
    except (KeyError, TypeError, ValueError):
        return {}


def _count_whole(files, recovery):
    """Note what a whole bag holds."""
    for file in files:
        for channel in file.channels.values():
            schema = file.schemas.get(channel.schema_id)
            recovery.topics.setdefault(channel.topic, TopicRecovery(schema.name if schema else ''))
        for chunk in file.chunks:
            for channel_id, _, log_ns, _, _ in _messages(file, chunk):
                recovery.topics[file.channels[channel_id].topic].add(log_ns)


@contextmanager
def _scratch(out):
    """Give the path of a bag beside `out`, on the same file system; nothing is left of it."""
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


def _messages(file, chunk):
    """Yield (channel id, sequence, log_ns, publish_ns, bytes) of `chunk` in its order."""
    raw = file.unpacked(chunk)
    rows = len(raw) // MESSAGE_HEAD
    at, size = np.empty((2, rows), np.int64)
    channel, (log_ns, publish_ns) = np.empty(rows, np.int32), np.empty((2, rows), np.uint64)
    count, _ = find_messages(np.frombuffer(raw, np.uint8), 0, len(raw), ALL_CHANNELS, False, 0,
                             at, size, channel, log_ns, publish_ns)
    for channel_id, log, publish, begin, length in zip(*(
            column[:count].tolist() for column in (channel, log_ns, publish_ns, at, size))):
        yield (channel_id, int.from_bytes(raw[begin - 20:begin - 16], 'little'), log, publish,
               raw[begin:begin + length])


class _Digest:
    """Running hash of messages: one per topic would not see a changed order."""

    def __init__(self):
        self._hash, self._numbers = blake2b(), {}

    def add(self, topic, sequence, log_ns, publish_ns, raw):
        number = self._numbers.setdefault(topic, len(self._numbers))
        self._hash.update(number.to_bytes(4, 'little')
                          + HEAD.pack(sequence, log_ns, publish_ns, len(raw)) + raw)

    def value(self):
        return self._hash.digest(), tuple(self._numbers)


def _copy(source, files, path, recovery, told, progress):
    """Write the messages of `files` of `source` to the new bag `path`; return their digest."""
    packing = next((chunk.compression for file in files for chunk in file.chunks), 'zstd')
    digest, unknown = _Digest(), 0
    writer = BagWriter(path, packing or 'none', told.get('custom_data') or {}, math.inf,
                       threading.TIMEOUT_MAX)
    try:
        for file in files:
            for name, values in file.metadata.items():
                if name != 'rosbag2':  # what the old metadata.yaml was to say
                    writer.add_metadata(name, values)
        ends = {file: [] for file in files}  # [(offset, newest log time)] of what was read
        newest = {}  # {(file, topic): newest log time}
        topics_of = {file: _announce(file, writer, recovery.topics) for file in files}
        for file, chunk in progress([(part, chunk) for part in files for chunk in part.chunks]):
            topic_of, found, last_ns = topics_of[file], Counter(), 0
            for channel, sequence, log_ns, publish_ns, raw in _messages(file, chunk):
                found[channel] += 1
                last_ns = max(log_ns, last_ns)
                if channel not in topic_of:
                    unknown += 1
                    continue
                topic = topic_of[channel]
                writer.write(topic, log_ns, raw, publish_ns, sequence)
                digest.add(topic, sequence, log_ns, publish_ns, raw)
                recovery.topics[topic].add(log_ns)
                newest[file, topic] = max(log_ns, newest.get((file, topic), log_ns))
            for channel, count in chunk.counts.items():
                if channel in topic_of:
                    recovery.topics[topic_of[channel]].lost += count - found[channel]
            if last_ns:
                ends[file].append((chunk.begin, last_ns))
        if not writer.message_count:
            raise InputError(f'{source}: no whole message is left, nothing to recover')
        _tell_losses(ends, newest, recovery, told)
        if unknown:
            recovery.notes.append(f'{unknown} messages have lost their definition and are left '
                                  'out')
        writer.add_metadata(RECOVERED, {
            'version': __version__, 'from': os.path.abspath(source),
            'lost_s': f'{recovery.lost_s:.3f}',
            'lost_messages': sum(topic.lost for topic in recovery.topics.values())})
    finally:
        writer.close()
    return digest.value()


def _announce(file, writer, topics):
    """Announce the topics of `file`; return {channel id: topic}, without what nothing defines."""
    topic_of = {}
    for channel in file.channels.values():
        schema = file.schemas.get(channel.schema_id)
        if schema is None:
            continue
        if channel.topic not in topics:
            writer.copy_topic(schema, channel)
            topics[channel.topic] = TopicRecovery(schema.name)
        if topics[channel.topic].msgtype == schema.name:
            topic_of[channel.id] = channel.topic
    return topic_of


def _tell_losses(ends, newest, recovery, told):
    """Note what is missing: exactly where metadata.yaml tells it, else about."""
    topics = recovery.topics
    end_ns = max(topic.last_ns for topic in topics.values() if topic.kept)
    for file, read in ends.items():
        for at, (begin, end) in file.torn.items():
            begin = max((time for offset, time in read if offset <= at), default=begin)
            recovery.lost += [(begin, end)] if begin < end else []
    counts = _told_counts(told)
    if counts:
        told_end = (told.get('starting_time', {}).get('nanoseconds_since_epoch', 0)
                    + told.get('duration', {}).get('nanoseconds', 0))
        recovery.lost += [(end_ns, told_end)] if told_end > end_ns else []
    cuts = {file: max(file.torn.values(), key=lambda times: times[1]) for file in ends
            if file.truncated and file.torn}
    for name, topic in topics.items():
        topic.away_ns = sum(end - begin for begin, end in recovery.lost
                            if topic.kept and topic.first_ns <= begin and end <= topic.last_ns)
        if name in counts:
            topic.lost = max(topic.lost, counts[name] - topic.kept)
        elif topic.period:
            missing = sum(max(0, int((end - newest.get((file, name), begin)) * 1e-9
                                     / topic.period)) for file, (begin, end) in cuts.items())
            topic.lost += missing
            topic.about = missing > 0


def _check(path, digest, recovery):
    """Read the new bag again, by its index, too; InputError unless it holds what was copied."""
    found = _Digest()
    with open_bag(path) as reader:
        counts = {topic: count for topic, (_, count) in reader.topics.items()}
        good = not reader.notice and counts == {
            name: topic.kept for name, topic in recovery.topics.items()}
    (file_path,) = named_files(path, metadata.read_information(path))
    file = McapFile(file_path)
    try:
        for chunk in file.chunks:
            for channel, *message in _messages(file, chunk):
                found.add(file.channels[channel].topic, *message)
        good &= not file.damaged and found.value() == digest
    finally:
        file.close()
    try:
        with open(file_path, 'rb') as stream:
            summary = make_reader(stream, validate_crcs=True).get_summary()
        statistics = summary.statistics
        good &= statistics.message_count == sum(counts.values()) and len(
            summary.chunk_indexes) == len(file.chunks)
    except (McapError, AttributeError):
        good = False
    if not good:
        raise InputError(f'{path}: what was written could not be read again as it was; expected '
                         'a medium without errors')
