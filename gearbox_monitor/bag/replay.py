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
Run a recording through the estimator, block by block in bounded memory.

Replay starts at the estimator's recorded snapshots (state, parameters, input counter) and hands
each sample to the same Monitor, or to an Estimator alone. Where no message was lost the live
estimates come out bit for bit.
"""
from dataclasses import dataclass
import json
import re

import numpy as np

from gearbox_monitor.bag.comparison import Comparer, Comparison
from gearbox_monitor.bag.joint_input import find_input, snapshot_of
from gearbox_monitor.bag.message_block import MessageBlock
from gearbox_monitor.bag.replay_summary import BURN_IN, ReplaySummary, truth_topic
from gearbox_monitor.bag.stamp_matching import match_stamps
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator, SnapshotError, unsmoothed
from gearbox_monitor.estimation.interval_smoother import smooth_interval
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_TAU_K, smoother_parameters
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.monitoring.monitor import Monitor
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.drive import DriveModel, model_from_dict

_NOTHING = Samples(np.empty(0, np.int64), *np.empty((2, 0, 2)))
STATE = ('z', 'P', 'memory', 'gate', 'clock', 'efforts', 'parameters', 'model')
KEEP_GOING = ('period', 'baseline')  # snapshots that do not touch the state


@dataclass(frozen=True)
class RecordedSamples:
    """
    The inputs of a bag, on the arm side, and where they stand.

    samples: Samples [N]; log_ns int64 [N]; topic: of the joint states; namespace: its prefix.
    """

    samples: Samples
    log_ns: np.ndarray
    topic: str
    namespace: str


@dataclass(frozen=True)
class RecordedSnapshot:
    """One recorded snapshot: `content` {name: text} (Monitor.snapshot) logged at `log_ns`."""

    content: dict
    log_ns: int

    @property
    def stamp_ns(self):
        """Stamp of the last sample before it, 0 before the first."""
        return int(self.content['stamp_ns'])

    @property
    def input_count(self):
        """How many samples the estimator had taken."""
        return int(self.content['input_count'])

    def used(self, source):
        """
        Return (DriveModel, {parameter: value}) that the estimator used.

        Parameters that this version does not have are left out. Raises InputError, which calls it
        `source`.
        """
        known = {row.name for row in ESTIMATOR}
        try:
            model, parameters = (json.loads(self.content[name])
                                 for name in ('model', 'parameters'))
            parameters = {k: v for k, v in parameters.items() if k in known}
        except (KeyError, ValueError, AttributeError, RecursionError):
            raise InputError(f'{source}: snapshot: no model and parameters, expected what an '
                             'estimator writes') from None
        return model_from_dict(model, f'{source}: snapshot'), parameters


@dataclass(frozen=True)
class ReplayPart:
    """
    What one block of a recording gave.

    block: its messages. samples: Samples [N] among them; log_ns int64 [N]; estimates: of these.
    resumed int64 [K]: stamps of the samples before which a recorded snapshot was taken up.
    """

    block: MessageBlock
    samples: Samples
    log_ns: np.ndarray
    estimates: Estimates
    resumed: np.ndarray

    @property
    def now(self):
        """Log time of the last message."""
        return int(self.block.log_ns[-1])


@dataclass
class Replay:
    """
    What a replay gave: all samples and estimates, and the Estimator and Monitor at its end.

    comparison: with the recorded estimates, or None. told: {name: value}, see ReplaySummary.data.
    """

    recording: RecordedSamples
    estimates: Estimates
    estimator: Estimator
    monitor: Monitor | None
    comparison: Comparison | None
    told: dict | None


def read_samples(reader, motor_joint, arm_joint, model, topic):
    """Return the RecordedSamples of `topic` in `reader` (bag.read); model: see samples_of."""
    states = reader.joint_states(topic, (motor_joint, arm_joint))
    samples, log_ns = samples_of(states, model)
    return RecordedSamples(samples, log_ns, topic, topic.rsplit('/', 1)[0])


def sample_parts(reader, topic, decode, model, least, progress):
    """
    Yield the Samples of `topic` in parts of `least` samples; the last one has up to twice as many.

    decode: cdr.Decoder of the joints motor and arm. A part begins with the last sample of the one
    before: what lies between them belongs to it. progress(count): so many messages were read.
    """
    held, count = [_NOTHING], 0
    for block in reader.blocks([topic]):
        samples, _ = samples_of(decode(block), model)
        held.append(samples)
        count += len(samples.stamp_ns)
        progress(len(block))
        while count >= 2 * least:
            whole = _joined(held)
            yield _some(whole, 0, least)
            held, count = [_some(whole, least - 1, count)], count - least + 1
    yield _joined(held)


def samples_of(states, model):
    """
    Return (Samples [N], log_ns [N]) of JointStates with the columns motor and arm.

    model: DriveModel whose gear_ratio and torque_constant refer them to the arm side.
    """
    ours = slice(None)
    if not states.named.all():  # others may publish on the same topic
        ours = states.named.any(axis=1)
    position, effort = states.position[ours], states.effort[ours]
    u, y = np.empty((len(position), 2)), np.empty((len(position), 2))
    np.multiply(effort[:, 0], model.effort_scale, u[:, 0])
    np.divide(position[:, 0], model.gear_ratio, y[:, 0])
    u[:, 1], y[:, 1] = effort[:, 1], position[:, 1]
    return Samples(states.stamp_ns[ours], u, y), states.log_ns[ours]


def read_snapshots(reader, found):
    """Return the RecordedSnapshots of the estimator of the JointInput `found`, [] without one."""
    if found.snapshots is None:
        return []
    contents = ((log_ns, snapshot_of(reader, raw))
                for _, log_ns, _, raw in reader.messages([found.snapshots]))
    snapshots = [RecordedSnapshot(content, log_ns) for log_ns, content in contents if content]
    for snapshot in snapshots:
        for name in ('stamp_ns', 'input_count'):
            value = snapshot.content.get(name, '')
            if not re.fullmatch('-?[0-9]{1,18}|[0-9]{19}', value):
                raise InputError(f'{reader.path}: snapshot: {name}: {value!r}, expected a whole '
                                 'number')
    return snapshots


class Player:
    """
    A bag on its way through the estimator, part by part.

    Without `model` and `parameters` the recorded ones apply and the result can be compared with
    the recorded estimates (`compared`). With any of them, they replace the recorded (or default)
    ones. topic: as of find_input. estimator: in its present state, as is the monitor.
    early_inputs: samples recorded before the estimator was ready. notes: sentences for the user.
    Raises InputError.
    """

    def __init__(self, reader, model=None, parameters=None, topic='joint_states'):
        self.reader = reader
        self.input = find_input(reader, topic)
        self.topic, self.namespace = self.input.topic, self.input.namespace
        self.notes, self.early_inputs = [], 0
        snapshots = read_snapshots(reader, self.input)
        recorded_model, recorded = DriveModel(), {}
        if snapshots:
            recorded_model, recorded = snapshots[0].used(reader.path)
        self._engine = self._started(model or recorded_model, {**recorded, **(parameters or {})})
        self._names = (self.estimator.parameters.motor_joint,
                       self.estimator.parameters.arm_joint)
        self._require_joints()
        self._snapshots, self._starts, self._running, reason = [], [], False, ''
        if model is not None or parameters:
            reason = 'parameters were given'
        elif not snapshots:
            reason = 'the bag holds no snapshot of an estimator'
        else:
            try:
                self._place(snapshots)
            except SnapshotError as error:
                reason = str(error)
        self.compared = not reason
        if reason:
            self.notes.append(f'not compared: {reason}')

    @property
    def estimator(self):
        """The Estimator, in its present state."""
        return self._engine.estimator

    @property
    def monitor(self):
        """The Monitor, in its present state; None in a player of estimates alone."""
        return self._engine

    def run(self, sinks):
        """Hand all parts to each of `sinks`, which then finish. They name the topics they need."""
        topics = dict.fromkeys(topic for sink in sinks for topic in sink.topics)
        for part in self.parts(topics):
            for sink in sinks:
                sink.add(part)
        for sink in sinks:
            sink.finish()

    def parts(self, topics=()):
        """Yield the ReplayParts; their blocks hold the messages on `topics`, too."""
        decode = self.reader.decoder(self.topic, self._names)
        index, following = 0, 0  # of the next sample, of the next snapshot
        for block in self.reader.blocks(tuple(dict.fromkeys((self.topic, *topics)))):
            samples, log_ns = samples_of(decode(block.of(self.topic)), self.estimator.model)
            begin, end, found, resumed = 0, len(log_ns), [], []
            while begin < end:
                behind = following
                while following < len(self._starts) and self._starts[following] <= index + begin:
                    self._take_up(self._snapshots[following])
                    following += 1
                if following > behind:
                    resumed.append(samples.stamp_ns[begin])
                stop = min([end, *(at - index for at in self._starts[following:following + 1])])
                if following or not self._starts:
                    found.append(self._engine.run(_some(samples, begin, stop)))
                begin = stop
            index += end
            yield ReplayPart(block, samples, log_ns, _joined(found or [self._nothing()]),
                             np.array(resumed, np.int64))
        for snapshot in self._snapshots[following:]:
            self._take_up(snapshot)

    def _nothing(self):
        """Return Estimates of no sample."""
        return self._engine.run(_NOTHING)

    def _require_joints(self):
        """Raise InputError unless both joints are there; seldom takes more than a block."""
        decode = self.reader.decoder(self.topic, self._names)
        for block in self.reader.blocks([self.topic]):
            decode(block)
            if all(name in decode.there for name in self._names):
                return
        self.reader.require_joints(self.topic, self._names, decode.there)

    def _take_up(self, snapshot):
        """Go on from the recorded `snapshot`; an engine that stands exactly there stays."""
        if self._running and self._goes_on(snapshot):
            return
        self._engine, self._running = self._restored(snapshot), True

    def _goes_on(self, snapshot):
        """Return whether the engine stands exactly where `snapshot` was taken."""
        same = (snapshot.content.get('reason') in KEEP_GOING
                and _same_state(self.monitor.snapshot(), snapshot.content))
        if same:
            self.monitor.adopt_baseline(snapshot.content)
        return same

    def _started(self, model, parameters):
        return Monitor(model, parameters)

    def _restored(self, snapshot):
        return Monitor.restore(snapshot.content, f'{self.reader.path}: snapshot')

    def _place(self, snapshots):
        """Find the first sample behind each of `snapshots`. Raises SnapshotError."""
        starts, found, first, count = self._behind(snapshots)
        missed = [k for k, s in enumerate(snapshots)
                  if count and 0 < s.stamp_ns < first and not found[k]]
        # A recorder that joins late gets the latched snapshots of earlier, but not the samples
        # that followed them: replay starts where every input is recorded.
        if missed and missed[-1] + 1 == len(snapshots):
            raise SnapshotError('the recording begins behind the last snapshot of the estimator')
        use = missed[-1] + 1 if missed else 0
        _place_by_count(snapshots, starts, found)
        snapshots, starts = snapshots[use:], np.maximum.accumulate(starts[use:])
        for snapshot in reversed(snapshots):
            self._engine = self._restored(snapshot)  # all of them can be read
        if len(snapshots) > 1 and snapshots[0].input_count == 0:
            # The counter tells how many of the samples before the second snapshot were seen live.
            self.early_inputs = max(0, int(starts[1] - starts[0]) - snapshots[1].input_count)
            starts[0] += self.early_inputs
        self._snapshots, self._starts = snapshots, starts.tolist()
        kernels = {snapshot.content.get('kernels', KERNELS) for snapshot in snapshots}
        if kernels != {KERNELS}:
            self.notes.append(f'recorded with {", ".join(sorted(kernels))}, replayed with '
                              f'{KERNELS}: the last bits may differ')

    def _behind(self, snapshots):
        """
        Return where each of K `snapshots` stands in the recording.

        (index of the first sample behind it int64 [K], whether its own sample is there bool [K],
        stamp of the first sample, number of samples). A stamp can come back after the clock was
        set: the nearest in log time is meant.
        """
        own = np.array([s.stamp_ns for s in snapshots], np.int64)
        logged = np.array([s.log_ns for s in snapshots], np.int64)
        order = np.argsort(own, kind='stable')
        before, count, first = np.zeros(len(own), np.int64), 0, 0
        place, distance = np.full(len(own), -1), np.full(len(own), np.iinfo(np.int64).max)
        decode = self.reader.decoder(self.topic, self._names)
        for block in self.reader.blocks([self.topic]):
            samples, log_ns = samples_of(decode(block), self.estimator.model)
            stamps = samples.stamp_ns
            if not count and len(stamps):
                first = int(stamps[0])
            before += np.searchsorted(log_ns, logged)
            low, high = (np.searchsorted(own[order], stamps, side) for side in ('left', 'right'))
            for row in np.flatnonzero(high > low):
                for k in order[low[row]:high[row]]:
                    off = abs(int(log_ns[row] - logged[k]))
                    if off < distance[k]:
                        place[k], distance[k] = count + row + 1, off
            count += len(stamps)
        start = np.where((own == 0) & (np.array([s.input_count for s in snapshots]) == 0), 0,
                         before)
        found = (place >= 0) & (own > 0)
        return np.where(found, place, start), found, first, count


class EstimatePlayer(Player):
    """A Player of the estimates alone: no fixed-lag smoother, no trust, no drift."""

    @property
    def estimator(self):
        """The Estimator, in its present state."""
        return self._engine

    @property
    def monitor(self):
        """None: nothing is judged."""
        return None

    def _goes_on(self, snapshot):
        return (snapshot.content.get('reason') in KEEP_GOING
                and _same_state(self._engine.snapshot(),
                                self._restored(snapshot).snapshot()))

    def _started(self, model, parameters):
        return Estimator(model, unsmoothed(parameters))

    def _restored(self, snapshot):
        return Estimator.restore(snapshot.content, f'{self.reader.path}: snapshot',
                                 {'smoother_lag': 0.0})


def replay(reader, model=None, parameters=None, topic='joint_states'):
    """
    Run the bag `reader` through the estimator; return a Replay, with everything in memory.

    Arguments as of Player. Compares with the recorded estimates where that can be done.
    """
    player = Player(reader, model, parameters, topic)
    kept, told = ReplayCollector(player), ReplaySummary(player)
    comparer = Comparer(player) if player.compared else None
    player.run([kept, told, *([comparer] if comparer else [])])
    comparison = comparer and comparer.comparison
    return kept.replay(comparison, told.data(comparison))


class ReplayCollector:
    """Takes the parts of a Player and keeps all samples and estimates."""

    topics = ()

    def __init__(self, player):
        self._player = player
        self._samples, self._log_ns = [_NOTHING], [np.empty(0, np.int64)]
        self._estimates = []

    def add(self, part):
        """Take a ReplayPart."""
        self._samples.append(part.samples)
        self._log_ns.append(part.log_ns)
        self._estimates.append(part.estimates)

    def finish(self):
        """Nothing is left to do."""

    def replay(self, comparison=None, told=None):
        """Return the Replay."""
        player = self._player
        recording = RecordedSamples(_joined(self._samples), np.concatenate(self._log_ns),
                                    player.topic, player.topic.rsplit('/', 1)[0])
        estimates = _joined(self._estimates or [player.estimator.run(self._samples[0])])
        return Replay(recording, estimates, player.estimator, player.monitor, comparison, told)


def _place_by_count(snapshots, starts, found):
    """
    Correct `starts` of the snapshots of a reset, in place; arguments as Player._behind gave them.

    They carry no stamp, and their log time says little where the estimator lagged behind the
    recorder: the counters of samples tell how far it is to a neighbour that was found.
    """
    counts = [snapshot.input_count for snapshot in snapshots]
    placed = found.copy()
    for step, order in ((1, range(len(counts) - 2, -1, -1)), (-1, range(1, len(counts)))):
        for k in order:
            if placed[k] or not placed[k + step] or snapshots[k].stamp_ns or not counts[k]:
                continue
            starts[k] = max(0, starts[k + step] - (counts[k + step] - counts[k]))
            placed[k] = True


def _some(samples, begin, end):
    """Return the Samples begin .. end - 1."""
    return Samples(samples.stamp_ns[begin:end], samples.u[begin:end], samples.y[begin:end])


def _joined(parts):
    """Return the dataclasses of arrays `parts`, one behind the other."""
    if len(parts) == 1:
        return parts[0]
    kind = type(parts[0])
    return kind(*(np.concatenate([getattr(part, name) for part in parts])
                  for name in kind.__dataclass_fields__))


def _same_state(present, recorded):
    """Return whether the snapshots `present` and `recorded` {name: text} are of one state."""
    return all(present[key] == recorded.get(key) for key in STATE)


def truth(reader, recording):
    """
    Return (stamp_ns, tau_k) of the true or reference torque in the bag, or None.

    See replay_summary.truth_topic.
    """
    topic = truth_topic(reader, recording.namespace)
    if topic is None:
        return None
    states = reader.joint_states(topic, ('transmission',))
    return states.stamp_ns, states.effort[:, 0]


def smoothed(result):
    """
    Return rows [M, N_SMOOTHED] for the estimates of a Replay, smoothed over the whole recording.

    With the last parameters in force, changed for a smoother; NaN where a run from the first
    sample, without snapshots, has no estimate.
    """
    found = smooth_interval(
        result.estimator.model, smoother_parameters(result.estimator.parameters),
        result.recording.samples)
    rows = np.full((len(result.estimates.stamp_ns), N_SMOOTHED), np.nan)
    i, j = match_stamps(result.estimates.stamp_ns, found.stamp_ns)
    rows[i] = found.rows[j]
    return rows


def interval_error(reader, result, rows):
    """Return the rms error of tau_K (N m) of the `rows` of `smoothed`, None without a truth."""
    known, stamps = truth(reader, result.recording), result.estimates.stamp_ns
    if known is None or not len(stamps):
        return None
    keep = (stamps >= stamps[0] + BURN_IN) & np.isfinite(rows[:, S_TAU_K])
    i, j = match_stamps(stamps[keep], known[0])
    return float(np.sqrt(np.mean((rows[keep, S_TAU_K][i] - known[1][j]) ** 2))) if len(i) else None
