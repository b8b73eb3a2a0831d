# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Run a recording through the estimator, block by block in bounded memory.

Replay starts at the estimator's recorded snapshots (state, parameters, input counter) and hands
each sample to the same Monitor, or to an Estimator alone. Unless a message was lost, the estimates
equal the live ones bit for bit.
"""
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import json
from typing import Any, cast, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import (
    Estimator, snapshot_errors, SnapshotError, unsmoothed)
from gearbox_monitor.estimation.sample_loop import SECOND
from gearbox_monitor.files.baselines import earlier
from gearbox_monitor.files.user_files import load_robot
from gearbox_monitor.health.health_record import Window
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.kernel import KERNELS
from gearbox_monitor.kernels.types import Flags, Integers
from gearbox_monitor.parameters import PAYLOAD
from gearbox_monitor.plain_data import classes_of, from_data
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.cdr import joined, JointStates, MessageBlock, rows_of
from gearbox_monitor.recordings.joint_input import (
    find_input, NO_MODEL, NO_SAMPLES, PAYLOAD_CHANGE, read_snapshots, recorded_settings,
    RecordedSnapshot, samples_of)
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.robot.description import RobotDescription
from gearbox_monitor.signals.stamps import unstamped

Follower: TypeAlias = Callable[[Monitor, Samples, Estimates], None]
STATE = ('z', 'P', 'memory', 'gate', 'clock', 'efforts', 'parameters', 'model')
# Reasons of snapshots that do not touch the state.
STATE_UNCHANGED = ('period', 'baseline', PAYLOAD_CHANGE)


@dataclass(frozen=True)
class ReplayPart:
    """
    Replay of one block of a recording.

    block: its messages. samples: Samples [N] among them; log_ns: their log times [N]; estimates:
    of these samples. resumed [K]: stamps of the samples at which a recorded snapshot was restored.
    """

    block: MessageBlock
    samples: Samples
    log_ns: Integers
    estimates: Estimates
    resumed: Integers

    @property
    def end_ns(self) -> int:
        """Log time of the last message."""
        return int(self.block.log_ns[-1])


class ReplaySink:
    """Takes the parts of a replay. topics: those whose messages it needs."""

    topics: Sequence[str] = ()

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""

    def finish(self) -> None:
        """Complete the result: all parts were added."""


@dataclass(frozen=True)
class _SnapshotPlaces:
    """
    Places of K snapshots in a recording of `count` samples, the first of them stamped `stamp_ns`.

    index [K]: of the first sample that follows each; matched [K]: its own sample is recorded.
    """

    index: Integers
    matched: Flags
    stamp_ns: int
    count: int


class Player:
    """
    Replays a bag part by part: estimates, and where `whole` fixed-lag smoother, trust and drift.

    Without `model` and `parameters` the recorded ones apply, and the estimates can be compared
    with the recorded ones (`compared`).

    Args:
        reader: the bag.
        model: replaces the recorded model.
        parameters: {name: value} that replace recorded or default parameters of the estimator.
        topic: see find_input.
        whole: whether more than the estimates is computed.
        follow: called with the Monitor, the Samples and the Estimates of each second.

    Attributes: `early_inputs`, number of samples that were recorded before the estimator ran;
    `notes`, sentences for the user; `not_compared`, why the estimates cannot be compared, or ''.

    Raises:
        InputError: the bag cannot be replayed.
    """

    def __init__(self, reader: BagReader, model: DriveModel | None = None,
                 parameters: Mapping[str, Any] | None = None, topic: str = 'joint_states',
                 whole: bool = True, follow: Follower | None = None) -> None:
        self.reader, self.whole, self._follow = reader, whole, follow
        self._judged: list[Window] = []  # of Monitors that a snapshot has replaced
        self.input = find_input(reader, topic)
        self.topic, self.namespace = self.input.topic, self.input.namespace
        self.notes: list[str] = []
        self.early_inputs = 0
        snapshots = read_snapshots(reader, self.input, model is None)
        drive, settings = recorded_settings(snapshots, str(reader.path), model, parameters or {})
        self._robot = recorded_robot(settings, snapshots, str(reader.path))
        self._is_fresh = model is not None or bool(parameters) or not snapshots
        self._engine = self._started(reader.referred(drive or DriveModel()), settings)
        self._names = (self.estimator.parameters.motor_joint,
                       self.estimator.parameters.arm_joint, *self.estimator.robot_joints)
        self._require_joints()
        self._snapshots: list[RecordedSnapshot] = []
        self._starts: list[int] = []
        self._running, reason = False, ''
        if model is not None or parameters:
            reason = 'parameters or model replaced'
        elif not snapshots:
            reason = 'the bag holds no snapshot of an estimator'
        else:
            try:
                self._place(snapshots)
            except SnapshotError as error:
                reason = str(error)
        if model is None and not snapshots:
            self.notes.append(NO_MODEL)
        self.compared, self.not_compared = not reason, reason

    @property
    def estimator(self) -> Estimator:
        """The Estimator, in its present state."""
        return self._engine if isinstance(self._engine, Estimator) else self._engine.estimator

    @property
    def monitor(self) -> Monitor:
        """The Monitor of a whole replay, in its present state."""
        return cast(Monitor, self._engine)

    def judged(self) -> list[Window]:
        """Return the Windows that were judged since the last call, in order of time."""
        windows, self._judged = [*self._judged, *self.monitor.judged], []
        self.monitor.judged.clear()
        return windows

    def run(self, sinks: Sequence[ReplaySink], progress: Callable[[int], object] = bool) -> None:
        """Hand all parts to `sinks`, the number of samples to `progress`; finish `sinks`."""
        topics = dict.fromkeys(topic for sink in sinks for topic in sink.topics)
        for part in self.parts(topics):
            for sink in sinks:
                sink.add(part)
            progress(len(part.samples.stamp_ns))
        for sink in sinks:
            sink.finish()

    def parts(self, topics: Iterable[str] = ()) -> Iterator[ReplayPart]:
        """
        Yield the ReplayParts; their blocks also hold the messages on `topics`.

        Raises InputError behind the last one: no sample was stamped.
        """
        decode = self.reader.decoder(self.topic, self._names)
        index, following = 0, 0  # of the next sample, of the next snapshot
        stamped = False
        for block in self.reader.blocks(tuple(dict.fromkeys((self.topic, *topics)))):
            samples, log_ns = self._samples_of(decode(block.of(self.topic)))
            begin, end = 0, len(log_ns)
            estimates: list[Estimates] = []
            resumed: list[int] = []
            while begin < end:
                previous = following
                while following < len(self._starts) and self._starts[following] <= index + begin:
                    self._resume(self._snapshots[following])
                    following += 1
                if following > previous:
                    resumed.append(int(samples.stamp_ns[begin]))
                stop = min([end, *(start - index
                                   for start in self._starts[following:following + 1])])
                if following or not self._starts:
                    estimates += self._run(rows_of(samples, slice(begin, stop)))
                begin = stop
            index += end
            stamped |= bool((samples.stamp_ns > 0).any())
            yield ReplayPart(block, samples, log_ns,
                             joined(estimates or [self._engine.run(NO_SAMPLES)]),
                             np.array(resumed, np.int64))
        if index > 1 and not stamped:
            raise InputError(f'{self.reader.path}: {self.topic}: {unstamped(index)}')
        for snapshot in self._snapshots[following:]:
            self._resume(snapshot)

    def _run(self, samples: Samples) -> list[Estimates]:
        """Return the estimates of `samples`: all at once, or second by second if followed."""
        if self._follow is None:
            return [self._engine.run(samples)]
        edges = (np.flatnonzero(np.diff(samples.stamp_ns // SECOND)) + 1).tolist()
        out = []
        for begin, end in zip([0, *edges], [*edges, len(samples.stamp_ns)]):
            part = rows_of(samples, slice(begin, end))
            out.append(self._engine.run(part))
            self._follow(self.monitor, part, out[-1])
        return out

    def _samples_of(self, states: JointStates) -> tuple[Samples, Integers]:
        """Return (Samples, log_ns) of the JointStates `states`."""
        return samples_of(states, self.estimator.model, bool(self.estimator.robot_joints))

    def _require_joints(self) -> None:
        """Raise InputError unless both joints are recorded; seldom reads more than a block."""
        decode = self.reader.decoder(self.topic, self._names)
        for block in self.reader.blocks([self.topic]):
            decode(block)
            if all(name in decode.joints for name in self._names):
                return
        self.reader.require_joints(self.topic, self._names, decode.joints)

    def _resume(self, snapshot: RecordedSnapshot) -> None:
        """Continue from the recorded `snapshot`; an engine in exactly that state stays."""
        if self._running and snapshot.content.get('reason') == PAYLOAD_CHANGE:
            _, values = snapshot.settings(str(self.reader.path))
            self._engine.set_parameters({name: values[name] for name in PAYLOAD})
        if self._running and self._continues(snapshot):
            return
        if self.whole:
            self._judged += self.monitor.judged
        self._engine, self._running = self._restored(snapshot), True

    def _continues(self, snapshot: RecordedSnapshot) -> bool:
        """Return whether the engine is exactly in the state of `snapshot`; adopt its baseline."""
        if snapshot.content.get('reason') not in STATE_UNCHANGED:
            return False
        recorded = snapshot.content if self.whole else self._restored(snapshot).snapshot()
        present = self._engine.snapshot()
        same = all(present[key] == recorded.get(key) for key in STATE)
        if same and self.whole:
            self.monitor.adopt_baseline(snapshot.content)
        return same

    def _started(self, model: DriveModel, parameters: Mapping[str, Any]) -> Estimator | Monitor:
        if not self.whole:
            return Estimator(model, unsmoothed(parameters), self._robot)
        known, note = earlier(parameters) if self._is_fresh else (None, '')
        self.notes += [note] if note else []
        return Monitor(model, parameters, known, self._robot)

    def _restored(self, snapshot: RecordedSnapshot) -> Estimator | Monitor:
        source = f'{self.reader.path}: snapshot'
        return Monitor.restore(snapshot.content, source) if self.whole else Estimator.restore(
            snapshot.content, source, {'smoother_lag': 0.0})

    def _place(self, snapshots: list[RecordedSnapshot]) -> None:
        """Find the first sample that follows each of `snapshots`. Raises SnapshotError."""
        places = self._places(snapshots)
        missed = [k for k, snapshot in enumerate(snapshots)
                  if places.count and 0 < snapshot.stamp_ns < places.stamp_ns
                  and not places.matched[k]]
        # A recorder that joins late gets the latched earlier snapshots, but not the samples that
        # followed them: replay starts where every input is recorded.
        if missed and missed[-1] + 1 == len(snapshots):
            raise SnapshotError('the recording begins behind the last snapshot of the estimator')
        first = missed[-1] + 1 if missed else 0
        starts = np.maximum.accumulate(_placed_by_count(snapshots, places)[first:])
        snapshots = snapshots[first:]
        for snapshot in reversed(snapshots):
            self._engine = self._restored(snapshot)  # raises unless all of them can be read
        if len(snapshots) > 1 and snapshots[0].input_count == 0:
            # The counter of the second snapshot is the number of samples that were seen live.
            self.early_inputs = max(0, int(starts[1] - starts[0]) - snapshots[1].input_count)
            starts[0] += self.early_inputs
        self._snapshots, self._starts = snapshots, starts.tolist()
        kernels = {snapshot.content.get('kernels', KERNELS) for snapshot in snapshots}
        if kernels != {KERNELS}:
            self.notes.append(f'recorded with {", ".join(sorted(kernels))}, replayed with '
                              f'{KERNELS}: the last bits may differ')

    def _places(self, snapshots: Sequence[RecordedSnapshot]) -> _SnapshotPlaces:
        """
        Return where `snapshots` are in the recording.

        A stamp can repeat after the clock was set: the occurrence nearest in log time counts.
        """
        own = np.array([s.stamp_ns for s in snapshots], np.int64)
        logged = np.array([s.log_ns for s in snapshots], np.int64)
        counters = np.array([s.input_count for s in snapshots])
        order = np.argsort(own, kind='stable')
        by_log_time, count, first = np.zeros(len(own), np.int64), 0, 0
        place, distance = np.full(len(own), -1), np.full(len(own), np.iinfo(np.int64).max)
        decode = self.reader.decoder(self.topic, self._names)
        for block in self.reader.blocks([self.topic]):
            samples, log_ns = self._samples_of(decode(block))
            stamps = samples.stamp_ns
            if not count and len(stamps):
                first = int(stamps[0])
            by_log_time += np.searchsorted(log_ns, logged)
            low = np.searchsorted(own[order], stamps, 'left')
            high = np.searchsorted(own[order], stamps, 'right')
            for row in np.flatnonzero(high > low):
                for k in order[low[row]:high[row]]:
                    offset = abs(int(log_ns[row] - logged[k]))
                    if offset < distance[k]:
                        place[k], distance[k] = count + row + 1, offset
            count += len(stamps)
        matched = (place >= 0) & (own > 0)
        index = np.where(matched, place, np.where((own == 0) & (counters == 0), 0, by_log_time))
        return _SnapshotPlaces(index, matched, first, count)


def recorded_robot(settings: Mapping[str, Any], snapshots: Sequence[RecordedSnapshot],
                   source: str) -> RobotDescription | None:
    """
    Return the robot that an estimator is run with: that of the snapshots, else that of a file.

    Args:
        settings: parameters {name: value} of the estimator now.
        snapshots: of the bag.
        source: the name of the bag in messages.

    Returns:
        Its description, None without one.

    Raises:
        InputError: the snapshot is damaged, or the file is no URDF.

    """
    path = settings.get('robot_description', '')
    if path and snapshots and 'robot' in snapshots[0].content and snapshots[0].settings(
            source)[1].get('robot_description') == path:
        with snapshot_errors(source):
            return cast(RobotDescription, from_data(json.loads(snapshots[0].content['robot']),
                                                    classes_of(RobotDescription)))
    return load_robot(path) if path else None


def _placed_by_count(snapshots: Sequence[RecordedSnapshot], places: _SnapshotPlaces) -> Integers:
    """
    Return the indices of `places`, corrected for snapshots of a reset.

    They carry no stamp, and their log time means little if the estimator lagged behind the
    recorder: the counters of samples say how far it is to a neighbour that was matched.
    """
    counts = [snapshot.input_count for snapshot in snapshots]
    starts, placed = places.index.copy(), places.matched.copy()
    for step, order in ((1, range(len(counts) - 2, -1, -1)), (-1, range(1, len(counts)))):
        for k in order:
            if placed[k] or not placed[k + step] or snapshots[k].stamp_ns or not counts[k]:
                continue
            starts[k] = max(0, starts[k + step] - (counts[k + step] - counts[k]))
            placed[k] = True
    return starts
