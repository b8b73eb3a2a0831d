# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
An estimator in a bag: its input, two topics of it joined into one, snapshots, innovations.

The motor and the arm encoder may publish on two topics: their messages are joined by their stamps
into samples, live and offline by the same Joiner.

An estimator has left in a bag what it took and how it went on. A snapshot holds its state, its
parameters and its input counter. Innovations are read of whatever filter published them: two
topics of one type belong together where the second is called as the first one, with `variances`
or the like behind it.
"""
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from itertools import islice
import json
from pathlib import Path
import re
import shlex
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.estimator import expect_format, SnapshotError
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.recordings.cdr import joined, JointStates, MessageBlock, rows_of
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.recordings.topics import (
    JOINT_SETPOINTS, JOINT_STATES, PAIRED_JOINT_STATES, SNAPSHOT, TRANSMISSION)

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
        if any(is_called(alias, name) for alias in aliases):
            candidates[node] = JointInput(topic, namespace, snapshots, names,
                                          gearbox or TRANSMISSION)
    return candidates


def is_called(topic: str, name: str) -> bool:
    """Return whether `topic` is `name`; relative names are in any namespace."""
    topic = '/' + topic.strip('/')
    return topic == name or not name.startswith('/') and topic.endswith('/' + name if name else '')


def topics_called(reader: BagReader, name: str) -> list[str]:
    """Return the topics of joint states in `reader` that are called `name`, '': all of them."""
    return [topic for topic, (kind, _) in reader.topics.items()
            if kind == JOINT_STATE and is_called(topic, name)]


def find_topic(reader: BagReader, name: str) -> str:
    """Return the topic of joint states called `name` in `reader`. Raises InputError."""
    topics = topics_called(reader, name)
    topics = list(filter(reader.count, topics)) or topics
    if not topics and name == JOINT_STATES:
        topics = [topic for topic in topics_called(reader, '') if reader.count(topic)
                  and not is_called(topic, JOINT_SETPOINTS)]
    if not topics:
        reader.require('/' + name.removeprefix('/'), JOINT_STATE)  # raises and lists the topics
    return only_topic(reader, topics)


def only_topic(reader: BagReader, topics: Sequence[str]) -> str:
    """Return the only one of `topics` with joint states. Raises Undecided: there are more."""
    if len(topics) > 1:
        names = sorted(topics)
        raise Undecided(f'{reader.path}: {", ".join(names)}: {len(names)} topics of joint states, '
                        'expected one: --topic ' + ' or --topic '.join(names))
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


NO_SAMPLES = Samples(np.empty(0, np.int64), *np.empty((2, 0, 2)))


def sample_parts(reader: BagReader, topic: str, decode: Callable[[MessageBlock], JointStates],
                 model: DriveModel, size: int, progress: Callable[[int], object]
                 ) -> Iterator[Samples]:
    """
    Read the samples of a topic in parts of bounded size.

    Each part begins with the last sample of its predecessor: the interval between them belongs to
    it.

    Args:
        reader: the bag.
        topic: topic of the joint states.
        decode: makes columns of the joints motor and arm.
        model: see samples_of.
        size: number of samples per part; the last part has up to twice as many.
        progress: called with the number of messages read.

    Returns:
        An iterator over Samples.
    """
    parts, count = [NO_SAMPLES], 0
    for block in reader.blocks([topic]):
        samples, _ = samples_of(decode(block), model)
        parts.append(samples)
        count += len(samples.stamp_ns)
        progress(len(block))
        while count >= 2 * size:
            samples = joined(parts)
            yield rows_of(samples, slice(0, size))
            parts, count = [rows_of(samples, slice(size - 1, count))], count - size + 1
    yield joined(parts)


def samples_of(states: JointStates, model: DriveModel,
               robot: bool = False) -> tuple[Samples, Integers]:
    """
    Return (Samples [N], log_ns [N]) of the JointStates `states` with the columns motor and arm.

    The gear_ratio and torque_constant of `model` refer them to the arm side. A third column is the
    setpoint of the motor, which then stands in place of its torque; in a `robot` all columns from
    the third on are the joints of its description.
    """
    rows: slice | Flags = slice(None)
    if not states.named.all():  # other publishers may use the same topic
        rows = np.asarray(states.named[:, :2 if robot else None].any(axis=1))
    position, effort = states.position[rows], states.effort[rows]
    u, y = np.empty((len(position), 2)), np.empty((len(position), 2))
    if len(states.names) > 2 and not robot:
        np.divide(position[:, 2], model.gear_ratio, u[:, 0])
    else:
        np.multiply(effort[:, 0], model.effort_scale, u[:, 0])
    np.divide(position[:, 0], model.gear_ratio, y[:, 0])
    u[:, 1], y[:, 1] = effort[:, 1], position[:, 1]
    return Samples(states.stamp_ns[rows], u, y, position[:, 2:] if robot else None), (
        states.log_ns[rows])


NO_SERIAL = 'no gearbox_serial is recorded: the folder of the bag names the gearbox'
NO_MODEL = ('the bag records no model and --model names none: the values of the packaged '
            'drive.yaml were used, which are wrong for any other drive')


@dataclass(frozen=True)
class RecordedSnapshot:
    """One recorded snapshot: `content` {name: text} (Monitor.snapshot) logged at `log_ns`."""

    content: Mapping[str, str]
    log_ns: int

    @property
    def stamp_ns(self) -> int:
        """Stamp of the sample that precedes it, 0 without one."""
        return int(self.content['stamp_ns'])

    @property
    def input_count(self) -> int:
        """Number of samples that the estimator had taken."""
        return int(self.content['input_count'])

    def settings(self, source: str) -> tuple[DriveModel, dict[str, Any]]:
        """
        Return (DriveModel, {parameter: value}) that the estimator used.

        Raises InputError, in which `source` names the bag.
        """
        try:
            model, parameters = (dict(json.loads(self.content[name]))
                                 for name in ('model', 'parameters'))
        except (KeyError, ValueError, TypeError, RecursionError):
            raise InputError(f'{source}: snapshot: no model and parameters, expected what an '
                             'estimator writes') from None
        return model_from_dict(model, f'{source}: snapshot'), parameters


def read_snapshots(reader: BagReader, joint_input: JointInput, is_needed: bool = True
                   ) -> list[RecordedSnapshot]:
    """
    Return the snapshots of an estimator.

    Args:
        reader: of the bag.
        joint_input: of the estimator.
        is_needed: whether the model comes from them: else those of another version are left out.

    Returns:
        The snapshots, [] without one.

    Raises:
        InputError: a snapshot is of another version, or a stamp or a counter is no whole number.
    """
    if joint_input.snapshots is None:
        return []
    contents = ((log_ns, snapshot_of(reader, raw))
                for _, log_ns, _, raw in reader.messages([joint_input.snapshots]))
    snapshots = [RecordedSnapshot(content, log_ns) for log_ns, content in contents if content]
    try:
        for snapshot in snapshots:
            expect_format(snapshot.content, f'{reader.path}: snapshot')
    except SnapshotError:
        if is_needed:
            raise
        return []
    for snapshot in snapshots:
        for name in ('stamp_ns', 'input_count'):
            value = snapshot.content.get(name, '')
            if not re.fullmatch('-?[0-9]{1,18}|[0-9]{19}', value):
                raise InputError(f'{reader.path}: snapshot: {name}: {value!r}, expected a whole '
                                 'number')
    return snapshots


def recorded_settings(snapshots: Sequence[RecordedSnapshot], source: str,
                      model: DriveModel | None, stated: Values) -> tuple[
                          DriveModel | None, dict[str, Any]]:
    """
    Return (model, {parameter: value}) of an estimator: as stated, else as recorded.

    Args:
        snapshots: of the estimator, [] without one.
        source: the name of the bag in messages.
        model: in place of the recorded one; None: the recorded one, None without any.
        stated: {name: value} that replace recorded parameters.

    Raises:
        InputError: a snapshot is damaged.
    """
    recorded_model, recorded = snapshots[0].settings(source) if snapshots else (None, {})
    return recorded_model if model is None else model, {**recorded, **stated}


SPREAD = re.compile(r'(.*innovation)s?_(stddev|std|variances?|covariances?)')
MOST = 20_000  # messages that are read
HEADS = ('header', 'stamp', 'timestamp', 'timestamp_sample', 'name')


def innovation_topics(reader: BagReader) -> dict[str, str]:
    """Return {topic of innovations: topic of their deviations or variances} in the bag."""
    pairs = {}
    for topic, (kind, _) in reader.topics.items():
        if (match := SPREAD.fullmatch(topic)) is not None:
            pairs.update({own: topic for own in (match[1], f'{match[1]}s')
                          if own in reader.topics and reader.topics[own][0] == kind})
    return pairs


def nis_of(reader: BagReader, innovations: str, spreads: str) -> dict[str, tuple[float, int]]:
    """
    Return {reading: (mean of its squared innovation over the variance, number)}.

    Args:
        reader: of the bag.
        innovations: topic.
        spreads: topic of their deviations or variances, as innovation_topics gives it.

    """
    match = SPREAD.fullmatch(spreads)
    power = 2 if match and match[2].startswith('std') else 1
    variances = dict(_messages(reader, spreads))
    ratios: dict[str, list[float]] = {}
    for stamp, values in _messages(reader, innovations):
        for name, error in values.items():
            variance = variances.get(stamp, {}).get(name, 0.0) ** power
            if variance > 0.0 and np.isfinite(error):
                ratios.setdefault(name, []).append(error ** 2 / variance)
    return {name: (float(np.mean(own)), len(own)) for name, own in ratios.items()}


def _messages(reader: BagReader, topic: str) -> Iterator[tuple[Any, dict[str, float]]]:
    """Yield (stamp or number, {reading: value}) of the first messages of a `topic`."""
    kind = reader.topics[topic][0]
    for number, (*_, raw) in enumerate(islice(reader.messages((topic,)), MOST)):
        content = reader.decode(kind, raw)
        stamp = getattr(getattr(content, 'header', None), 'stamp', None)
        key = getattr(content, 'timestamp', number) if stamp is None else (
            stamp.sec, stamp.nanosec)
        yield key, dict(_numbers(content, tuple(getattr(content, 'name', ()))))


def _numbers(content: Any, joints: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    """Yield (name, value) of all numbers in a message; joints: names of those of an array."""
    for name in (part.name for part in fields(content)):
        value = getattr(content, name)
        if name in HEADS or name.startswith('__'):
            continue
        if is_dataclass(value):
            yield from ((f'{name}.{part}', number) for part, number in _numbers(value, ()))
        elif isinstance(value, float):
            yield name, value
        elif isinstance(value, np.ndarray) and value.dtype.kind == 'f':
            row: Array = value
            yield from zip(joints if len(joints) == len(row) else (
                f'{name}[{k}]' for k in range(len(row))), map(float, row))
