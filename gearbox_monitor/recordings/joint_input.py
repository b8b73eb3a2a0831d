# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The input of an estimator in a bag: its topic, its joints, and two topics joined into one.

The motor and the arm encoder may publish on two topics: their messages are joined by their stamps
into samples, live and offline by the same Joiner.
"""
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
import json
from pathlib import Path
import shlex
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.topics import (
    JOINT_STATES, PAIRED_JOINT_STATES, SNAPSHOT, TRANSMISSION)

MATCH_WAIT = 10_000_000_000  # ns of log time that a row waits for its partner


def match_stamps(a: Integers, b: Integers) -> tuple[Integers, Integers]:
    """Return indices (i, j) with a[i] == b[j]; `a`, `b` [N], [M]: k-th occurrence with k-th."""
    a, b = np.asarray(a), np.asarray(b)
    if np.array_equal(a, b):
        return np.arange(len(a)), np.arange(len(a))
    if (np.diff(a) > 0).all() and (np.diff(b) > 0).all():
        j = np.searchsorted(b, a)
        i = np.flatnonzero(b[np.minimum(j, len(b) - 1)] == a) if len(b) else np.empty(0, int)
        return i, j[i]
    place = {key: index for index, key in enumerate(_numbered(b))}
    pairs = [(index, place[key]) for index, key in enumerate(_numbered(a)) if key in place]
    i, j = np.array(pairs, int).reshape(-1, 2).T
    return i, j


def _numbered(stamps: Integers) -> list[tuple[int, int]]:
    """Return [(stamp, number of its earlier occurrences)]."""
    order = np.argsort(stamps, kind='stable')
    ordered = stamps[order]
    occurrence = np.empty(len(stamps), np.int64)
    occurrence[order] = np.arange(len(stamps)) - np.searchsorted(ordered, ordered)
    return list(zip(stamps.tolist(), occurrence.tolist()))


class _WaitingRows(NamedTuple):
    """Rows of one stream: stamps [N], log times of their arrival [N], values [N, width]."""

    stamps: Integers
    arrival: Integers
    values: Array

    def take(self, rows: slice | Flags) -> '_WaitingRows':
        """Return some `rows`."""
        return _WaitingRows(self.stamps[rows], self.arrival[rows], self.values[rows])


class StampMatcher:
    """
    Match the rows of two streams as they arrive; each waits for its partner for MATCH_WAIT.

    Args:
        left_width: number of values per row on the left.
        right_width: the same on the right.
    """

    def __init__(self, left_width: int, right_width: int) -> None:
        self._sides = [_WaitingRows(np.empty(0, np.int64), np.empty(0, np.int64),
                                    np.empty((0, width))) for width in (left_width, right_width)]

    def put(self, log_ns: int, left: tuple[Integers, Array], right: tuple[Integers, Array]
            ) -> None:
        """
        Add rows.

        Args:
            log_ns: log time at which they arrive, ns.
            left: (stamps [N], values [N, left_width]).
            right: (stamps [M], values [M, right_width]).
        """
        for side, (stamps, values) in enumerate((left, right)):
            new = stamps, np.full(len(stamps), log_ns), values
            self._sides[side] = _WaitingRows(*map(np.concatenate, zip(self._sides[side], new)))

    def skip_until(self, stamp: int) -> bool:
        """Drop the rows on the right that precede `stamp`; return whether it has arrived."""
        rows = np.flatnonzero(self._sides[1].stamps == stamp)
        if len(rows):
            self._sides[1] = self._sides[1].take(slice(rows[0], None))
        return len(rows) > 0

    def pairs(self) -> tuple[Integers, Array, Array]:
        """Return (stamps, left values, right values) of the rows matched since the last call."""
        ours, theirs = self._sides
        i, j = match_stamps(ours.stamps, theirs.stamps)
        for side, rows in enumerate((i, j)):
            waiting = np.ones(len(self._sides[side].stamps), bool)
            waiting[rows] = False
            self._sides[side] = self._sides[side].take(waiting)
        return ours.stamps[i], ours.values[i], theirs.values[j]

    def expired(self, log_ns: int | None = None) -> tuple[Integers, Integers]:
        """Remove rows that waited for MATCH_WAIT at `log_ns` (None: all); return their stamps."""
        overdue = [np.ones(len(side.arrival), bool) if log_ns is None else
                   side.arrival < log_ns - MATCH_WAIT for side in self._sides]
        ours, theirs = (side.stamps[rows] for side, rows in zip(self._sides, overdue))
        self._sides = [side.take(~rows) for side, rows in zip(self._sides, overdue)]
        return ours, theirs


WAIT = 1_000_000_000  # ns of stamps that a message waits for its partner
V = TypeVar('V')
JoinedSample: TypeAlias = tuple[int, V, V | None]  # stamp (ns), motor values, arm values if paired


class Joiner(Generic[V]):
    """
    Pairs messages whose stamps are at most `tolerance` (int ns) apart, each message once.

    A motor message is paired with the first arm message that fits. Without one it becomes a sample
    of its own; an arm message without a partner is dropped. pairs, unpaired, dropped: how many.
    """

    def __init__(self, tolerance: int) -> None:
        self.tolerance = tolerance
        self.pairs = self.unpaired = self.dropped = 0
        self._distance: int | None = None
        self._motor: deque[tuple[int, V]] = deque()
        self._arm: deque[tuple[int, V]] = deque()

    def motor(self, stamp_ns: int, values: V) -> list[JoinedSample[V]]:
        """Take the motor message `values` stamped `stamp_ns`; return the completed samples."""
        if stamp_ns <= 0:  # no stamp
            self.unpaired += 1
            return [(stamp_ns, values, None)]
        samples = self._expire(stamp_ns, self._motor)
        self._motor.append((stamp_ns, values))
        return samples + self._matched()

    def arm(self, stamp_ns: int, values: V) -> list[JoinedSample[V]]:
        """Take the arm message `values` stamped `stamp_ns`; return the completed samples."""
        if stamp_ns <= 0:
            self.dropped += 1
            return []
        samples = self._expire(stamp_ns, self._arm)
        self._arm.append((stamp_ns, values))
        return samples + self._matched()

    def clear(self) -> None:
        """Forget the waiting messages."""
        self._motor.clear()
        self._arm.clear()

    def pop_distance(self) -> int | None:
        """Return the smallest distance (ns) of stamps that did not fit since the last call."""
        distance, self._distance = self._distance, None
        return distance

    def _expire(self, stamp_ns: int, queue: deque[tuple[int, V]]) -> list[JoinedSample[V]]:
        """Give up messages too old for `stamp_ns`, which is about to join `queue`."""
        samples: list[JoinedSample[V]] = []
        back = bool(queue) and queue[-1][0] > stamp_ns  # the clock was set back
        while self._motor and (back and queue is self._motor
                               or abs(self._motor[0][0] - stamp_ns) > WAIT):
            samples.append(self._pop_unpaired())
        while self._arm and (back and queue is self._arm
                             or abs(self._arm[0][0] - stamp_ns) > WAIT):
            self._drop()
        return samples

    def _matched(self) -> list[JoinedSample[V]]:
        samples: list[JoinedSample[V]] = []
        while self._motor and self._arm:
            offset = self._arm[0][0] - self._motor[0][0]
            if abs(offset) <= self.tolerance:
                samples.append((*self._motor.popleft(), self._arm.popleft()[1]))
                self.pairs += 1
                continue
            self._distance = min(abs(offset), self._distance or abs(offset))
            if offset < 0:
                self._drop()
            else:
                samples.append(self._pop_unpaired())
        return samples

    def _pop_unpaired(self) -> JoinedSample[V]:
        self.unpaired += 1
        return (*self._motor.popleft(), None)

    def _drop(self) -> None:
        self.dropped += 1
        self._arm.popleft()


DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
PAYLOAD_CHANGE = 'payload'  # reason of a snapshot: what the robot carries
GEARBOX = 'gearbox'  # key of a snapshot: its name, where an estimator has several


@dataclass(frozen=True)
class JointInput:
    """
    A topic of joint states in a bag and the estimator that took it, if any.

    namespace: of the estimator; snapshots: its topic of snapshots, None without one. names {topic
    as in signals: name in the bag}: topics that were remapped differ from the namespace's.
    transmission: its name in the estimates, that of the gearbox where an estimator has several.
    """

    topic: str
    namespace: str
    snapshots: str | None = None
    names: Mapping[str, str] = field(default_factory=dict)
    transmission: str = TRANSMISSION

    @property
    def joints(self) -> dict[str, str]:
        """Names of the joints of a signal in messages, where they differ."""
        return {TRANSMISSION: self.transmission}

    def name(self, topic: str) -> str:
        """Return the name in the bag of the estimator's `topic`."""
        return self.names.get(topic, f'{self.namespace}/{topic}')


def bag_arguments(bag: str | Path, topic: str) -> str:
    """Return the recording `bag` with its `topic` of inputs as arguments of a command."""
    return shlex.quote(str(bag)) + (
        '' if topic == JOINT_STATES else f' --topic {shlex.quote(topic)}')


def find_input(reader: BagReader, name: str = JOINT_STATES) -> JointInput:
    """
    Return the JointInput called `name` in the bag `reader`, in whatever namespace.

    `name` is a topic, as recorded or as the estimator called it before it was remapped or paired,
    or an estimator, /NAMESPACE/NODE; of several gearboxes TOPIC/GEARBOX or
    /NAMESPACE/NODE/GEARBOX. Raises InputError unless exactly one fits.
    """
    inputs = recorded_inputs(reader, name)
    if len(inputs) > 1:
        nodes = sorted(inputs)
        raise InputError(f'{reader.path}: topic {name}: taken by {", ".join(nodes)}, expected '
                         f'one; choose it with --topic {nodes[0]}')
    if inputs:
        (recorded,) = inputs.values()
        reader.require(recorded.topic, JOINT_STATE)
        return recorded
    of_robot = name.rpartition('/')[0]  # where no estimator was recorded: TOPIC/GEARBOX
    if of_robot and not topics_called(reader, name) and topics_called(reader, of_robot):
        name = of_robot
    topic = find_topic(reader, name)
    namespace = topic.rsplit('/', 1)[0]
    paired = f'{namespace}/{PAIRED_JOINT_STATES}'
    if topic == f'{namespace}/{JOINT_STATES}' and reader.count(paired):
        topic = paired
    return JointInput(topic, namespace)


def recorded_inputs(reader: BagReader, name: str = JOINT_STATES) -> dict[str, JointInput]:
    """Return {estimator: JointInput} of the estimators in `reader` that took a topic `name`."""
    candidates: dict[str, JointInput] = {}  # by node
    for snapshots, content in _estimators(reader).items():
        names, gearbox = _recorded_names(content.get('topics', '{}')), content.get(GEARBOX)
        node = snapshots.removesuffix(f'/{SNAPSHOT}')
        namespace = node.rsplit('/', 2 if gearbox else 1)[0]
        original = f'{namespace}/{JOINT_STATES}'
        topic = names.get(JOINT_STATES, original)
        aliases = [topic, original, node]
        if gearbox:
            aliases += [f'{topic}/{gearbox}', f'{original}/{gearbox}']
        if any(_is_called(alias, name) for alias in aliases):
            candidates[node] = JointInput(topic, namespace, snapshots, names,
                                          gearbox or TRANSMISSION)
    return candidates


def _is_called(topic: str, name: str) -> bool:
    """Return whether `topic` is `name`; relative names are in any namespace."""
    return topic == name or not name.startswith('/') and topic.endswith('/' + name)


def topics_called(reader: BagReader, name: str) -> list[str]:
    """Return the topics of joint states in `reader` that are called `name`, in any namespace."""
    return [topic for topic, (kind, _) in reader.topics.items()
            if kind == JOINT_STATE and _is_called(topic, name)]


def find_topic(reader: BagReader, name: str) -> str:
    """Return the topic of joint states called `name` in `reader`. Raises InputError."""
    if name.startswith('/'):
        reader.require(name, JOINT_STATE)
        return name
    topics = topics_called(reader, name)
    if len(topics) > 1:
        raise InputError(f'{reader.path}: topic {name}: {", ".join(sorted(topics))}, expected '
                         'one; choose it with --topic')
    if not topics:
        reader.require('/' + name, JOINT_STATE)  # raises and lists the topics
    return topics[0]


def _estimators(reader: BagReader) -> dict[str, dict[str, str]]:
    """Return {topic of snapshots: content of the first one, {} if it is damaged}."""
    topics = [topic for topic, (kind, count) in reader.topics.items()
              if kind == DIAGNOSTIC_ARRAY and topic.endswith(f'/{SNAPSHOT}') and count]
    contents: dict[str, dict[str, str]] = {}
    for topic, _, _, raw in reader.messages(topics) if topics else ():
        content = snapshot_of(reader, raw)
        if topic not in contents and content:
            contents[topic] = content
            if len(contents) == len(topics):
                break
    return contents


def _recorded_names(text: str) -> dict[str, str]:
    """Return {topic: name} in the JSON `text` of a snapshot, {} if it is damaged."""
    try:
        names = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return {key: str(name) for key, name in names.items()} if isinstance(names, dict) else {}


def snapshot_of(reader: BagReader, raw: bytes) -> dict[str, str]:
    """Return {name: text} of a snapshot in the CDR bytes `raw` of `reader`, {} if it is none."""
    for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
        content: dict[str, str] = {value.key: value.value for value in status.values}
        if 'z' in content and 'stamp_ns' in content:
            return content
    return {}
