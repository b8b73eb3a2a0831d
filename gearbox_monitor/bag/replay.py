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
Run a recording through the estimator, and compare with what was published live.

Replay starts at the estimator's recorded snapshots (state, parameters, input counter) and hands
each sample to the same Monitor. Where no message was lost the live estimates come out bit for bit.
A sample that the recorder or the estimator missed is counted; comparison is meaningful again from
the next snapshot on.
"""
from dataclasses import asdict, dataclass, field
import json

import numpy as np

from gearbox_monitor.drive.model import DriveModel, model_from_dict
from gearbox_monitor.errors import InputError
from gearbox_monitor.filters.smoother import N_SMOOTHED, S_TAU_K, smoother_parameters
from gearbox_monitor.interval import smooth_interval
from gearbox_monitor.jit import KERNELS
from gearbox_monitor.monitor import Estimates, Monitor, Samples, SnapshotError
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.signals import ARM, MOTOR, SIGNALS
from gearbox_monitor.stream import REASONS

JOINT_STATE = 'sensor_msgs/msg/JointState'
DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
CLOSE = 1e-9  # relative, absolute below 1
KEEP_GOING = ('period', 'baseline')  # snapshots that do not touch the state


@dataclass(frozen=True)
class Recording:
    """
    The inputs of a bag, on the arm side, and where they stand.

    samples: Samples [N]; log_ns int64 [N]; topic: of the joint states; namespace: its prefix.
    """

    samples: Samples
    log_ns: np.ndarray
    topic: str
    namespace: str


@dataclass(frozen=True)
class Snapshot:
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


@dataclass
class Comparison:
    """
    Replay against the recorded estimates, in messages.

    compared = identical + close + explained + different. `close` agree to 1e-9, as they do with
    other versions or on another machine. `explained` differ behind a lost sample, before
    the next snapshot. early_inputs: recorded before the estimator was ready. lost_inputs:
    estimated live, but not in the recording; lost_outputs: recorded inputs whose estimate is not
    in the recording. first: where the first unexplained difference is.
    """

    compared: int = 0
    identical: int = 0
    close: int = 0
    explained: int = 0
    different: int = 0
    early_inputs: int = 0
    lost_inputs: int = 0
    lost_outputs: int = 0
    first: str = ''

    @property
    def verdict(self):
        """'yes', 'to 1e-9', 'no', or 'nothing to compare'."""
        if not self.compared:
            return 'nothing to compare'
        return 'no' if self.different else 'to 1e-9' if self.close else 'yes'


@dataclass
class Replay:
    """What a replay gave: estimates, the Monitor at its end, and the comparison (or None)."""

    recording: Recording
    estimates: Estimates
    monitor: Monitor
    comparison: Comparison | None = None
    notes: list = field(default_factory=list)


def find_topic(reader, name, msgtype):
    """
    Return the topic of `reader` called `name`, in whatever namespace; absolute names as they are.

    Raises InputError when there is none, or more than one.
    """
    if name.startswith('/'):
        reader.require(name, msgtype)
        return name
    found = [topic for topic, (kind, _) in reader.topics.items()
             if kind == msgtype and (topic == '/' + name or topic.endswith('/' + name))]
    if len(found) > 1:
        raise InputError(f'{reader.path}: topic {name}: {", ".join(sorted(found))}, expected one; '
                         'choose it with --topic')
    if not found:
        reader.require('/' + name, msgtype)  # says what there is
    return found[0]


def read_recording(reader, motor_joint, arm_joint, gear_ratio, topic):
    """Return the Recording of `topic` in `reader` (bag.read). Raises InputError."""
    states = reader.joint_states(topic, (motor_joint, arm_joint))
    ours = states.named.any(axis=1)  # others may publish on the same topic
    position, effort = states.position[ours], states.effort[ours]
    samples = Samples(
        states.stamp_ns[ours],
        np.column_stack([effort[:, 0] * gear_ratio, effort[:, 1]]),
        np.column_stack([position[:, 0] / gear_ratio, position[:, 1]]))
    return Recording(samples, states.log_ns[ours], topic, topic.rsplit('/', 1)[0])


def read_snapshots(reader, namespace):
    """Return the Snapshots recorded from the estimator in `namespace` ('' is the root)."""
    topics = [topic for topic, (kind, _) in reader.topics.items()
              if kind == DIAGNOSTIC_ARRAY and topic.endswith('/snapshot')
              and topic.rsplit('/', 2)[0] == namespace]
    found = []
    for _, log_ns, _, raw in reader.messages(topics) if topics else ():
        for status in reader.decode(DIAGNOSTIC_ARRAY, raw).status:
            content = {value.key: value.value for value in status.values}
            if 'z' in content and 'stamp_ns' in content:
                found.append(Snapshot(content, log_ns))
    return found


def replay(reader, model=None, parameters=None, topic='joint_states'):
    """
    Run the bag `reader` through the estimator; return a Replay.

    Without `model` and `parameters` the recorded ones apply and the result is compared with the
    recorded estimates. With any of them, they replace the recorded (or default) ones.
    Raises InputError.
    """
    topic = find_topic(reader, topic, JOINT_STATE)
    snapshots = read_snapshots(reader, topic.rsplit('/', 1)[0])
    recorded_model, recorded = DriveModel(), {}
    if snapshots:
        recorded_model = model_from_dict(json.loads(snapshots[0].content['model']),
                                         str(reader.path))
        known = {row.name for row in ESTIMATOR}  # another version may have others
        recorded = {name: value for name, value in
                    json.loads(snapshots[0].content['parameters']).items() if name in known}
    overridden = model is not None or parameters
    monitor = Monitor(model or recorded_model, {**recorded, **(parameters or {})})
    recording = read_recording(reader, monitor.parameters['motor_joint'],
                               monitor.parameters['arm_joint'], monitor.model.gear_ratio, topic)
    if overridden:
        reason = 'parameters were given'
    elif not snapshots:
        reason = 'the bag holds no snapshot of an estimator'
    else:
        try:
            return _from_snapshots(reader, recording, snapshots)
        except SnapshotError as error:
            reason = str(error)
    return Replay(recording, monitor.run(recording.samples), monitor,
                  notes=[f'not compared: {reason}'])


def _from_snapshots(reader, recording, snapshots):
    samples, parts, resumed = recording.samples, [], []
    snapshots = _followed(recording, snapshots)
    starts = [_index_after(recording, s) for s in snapshots]
    ends = starts[1:] + [len(samples.stamp_ns)]
    monitor, early = None, 0
    if len(snapshots) > 1 and snapshots[0].input_count == 0:
        # The counter tells how many of the samples before the second snapshot were seen live.
        early = max(0, ends[0] - starts[0] - snapshots[1].input_count)
        starts[0] += early
    for snapshot, start, end in zip(snapshots, starts, ends):
        if monitor is None or not _goes_on(monitor, snapshot):
            monitor = Monitor.restore(snapshot.content, f'{reader.path}: snapshot')
        if end > start:
            resumed.append(samples.stamp_ns[start])
            parts.append(monitor.run(Samples(
                samples.stamp_ns[start:end], samples.u[start:end], samples.y[start:end])))
    if not parts:
        parts = [monitor.run(Samples(samples.stamp_ns[:0], samples.u[:0], samples.y[:0]))]
    estimates = Estimates(*(np.concatenate([getattr(p, name) for p in parts])
                            for name in Estimates.__dataclass_fields__))
    result = Replay(recording, estimates, monitor)
    result.comparison = _compare(reader, result, np.array(resumed, np.int64))
    result.comparison.early_inputs = early
    kernels = {snapshot.content.get('kernels', KERNELS) for snapshot in snapshots}
    if kernels != {KERNELS}:
        result.notes.append(f'recorded with {", ".join(sorted(kernels))}, replayed with '
                            f'{KERNELS}: the last bits may differ')
    return result


def _followed(recording, snapshots):
    """
    Return the snapshots from where every input is recorded.

    A recorder that joins late gets the latched snapshots of earlier, but not the samples that
    followed them. Raises SnapshotError when none is left.
    """
    stamps = recording.samples.stamp_ns
    missed = [k for k, s in enumerate(snapshots)
              if len(stamps) and 0 < s.stamp_ns < stamps[0] and s.stamp_ns not in stamps]
    if missed and missed[-1] + 1 == len(snapshots):
        raise SnapshotError('the recording begins behind the last snapshot of the estimator')
    return snapshots[missed[-1] + 1:] if missed else snapshots


def _goes_on(monitor, snapshot):
    """Return whether `monitor` stands exactly where `snapshot` was taken."""
    if snapshot.content.get('reason') not in KEEP_GOING:
        return False
    now = monitor.snapshot()
    same = all(now[key] == snapshot.content.get(key)
               for key in ('z', 'P', 'memory', 'gate', 'clock', 'efforts', 'parameters', 'model'))
    if same:
        monitor.adopt_baseline(snapshot.content)
    return same


def _index_after(recording, snapshot):
    """Return the index of the first sample that came after `snapshot`."""
    stamps = recording.samples.stamp_ns
    if snapshot.stamp_ns == 0:
        if snapshot.input_count == 0:
            return 0
        return int(np.searchsorted(recording.log_ns, snapshot.log_ns))
    same = np.flatnonzero(stamps == snapshot.stamp_ns)
    if len(same):  # a stamp can come back after the clock was set: take the nearest in time
        return int(same[np.argmin(np.abs(recording.log_ns[same] - snapshot.log_ns))]) + 1
    return int(np.searchsorted(recording.log_ns, snapshot.log_ns))


def _compare(reader, result, resumed):
    """Compare the replayed signals with the recorded ones, message by message."""
    comparison = Comparison()
    parameters = result.monitor.parameters
    names = {MOTOR: parameters['motor_joint'], ARM: parameters['arm_joint']}
    recorded = {}
    for signal in SIGNALS:
        topic = f'{result.recording.namespace}/{signal.topic}'
        if topic in reader.topics and reader.topics[topic][1]:
            there = reader.joint_names(topic)
            joints = [names.get(j, j) for j in signal.joints]
            recorded[signal.topic] = reader.joint_states(
                topic, [j for j in joints if j in there])
    state = recorded.get(SIGNALS[0].topic)
    live = state.stamp_ns if state is not None else np.empty(0, np.int64)
    ours = result.estimates.stamp_ns
    if len(ours):  # what was estimated before the first snapshot has nothing to be compared with
        live = live[np.argmax(live == ours[0]):]
    lost_inputs, lost_outputs = np.setdiff1d(live, ours), np.setdiff1d(ours, live)
    comparison.lost_inputs, comparison.lost_outputs = len(lost_inputs), len(lost_outputs)
    losses = np.sort(np.concatenate([lost_inputs, lost_outputs]))
    for signal in SIGNALS:
        if signal.topic in recorded:
            _compare_signal(signal, recorded[signal.topic], result, names, resumed, losses,
                            comparison)
    return comparison


def _compare_signal(signal, states, result, names, resumed, losses, comparison):
    stamps, values = signal_values(signal, result.estimates, result.monitor.model.gear_ratio)
    keep = [names.get(j, j) in states.names for j in signal.joints]
    ours = {name: array[:, keep] for name, array in values.items()}
    i, j = _match(stamps, states.stamp_ns)
    same, close = np.ones(len(i), bool), np.ones(len(i), bool)
    for name, array in ours.items():
        a, b = array[i], getattr(states, name)[j]
        absent = np.isnan(a) & np.isnan(b)
        same &= ((a == b) | absent).all(axis=1)
        close &= ((np.abs(a - b) <= CLOSE * np.maximum(1.0, np.abs(b))) | absent).all(axis=1)
    # A smoothed value depends on samples behind it, up to one and a half lags.
    lag = result.monitor.parameters['smoother_lag'] * 1e9
    ahead = round(1.5 * lag) + 1 if signal.smoothed else 0
    comparison.compared += len(i)
    comparison.identical += int(same.sum())
    for stamp, near in zip(stamps[i[~same]], close[~same]):
        since = resumed[resumed <= stamp].max(initial=0)
        if ((losses >= since) & (losses <= stamp + ahead)).any():
            comparison.explained += 1
        elif near:
            comparison.close += 1
        else:
            comparison.different += 1
            comparison.first = comparison.first or f'{signal.topic} at stamp {stamp} ns'


def _match(a, b):
    """Return indices (i, j) with a[i] == b[j], the k-th occurrence of a value with the k-th."""
    def keyed(stamps):
        order = np.argsort(stamps, kind='stable')
        ordered = stamps[order]
        first = np.searchsorted(ordered, ordered)
        occurrence = np.empty(len(stamps), np.int64)
        occurrence[order] = np.arange(len(stamps)) - first
        return stamps, occurrence

    (sa, ka), (sb, kb) = keyed(np.asarray(a)), keyed(np.asarray(b))
    if not ka.any() and not kb.any():
        _, i, j = np.intersect1d(sa, sb, assume_unique=True, return_indices=True)
        return i, j
    place = {key: index for index, key in enumerate(zip(sb.tolist(), kb.tolist()))}
    pairs = [(index, place[key]) for index, key in enumerate(zip(sa.tolist(), ka.tolist()))
             if key in place]
    return (np.array([p[0] for p in pairs], int), np.array([p[1] for p in pairs], int))


def signal_values(signal, estimates, gear_ratio):
    """
    Return (stamp_ns [M], {field: [M, J]}) of `signal` for all estimates; see joint_values.

    Values of joints that were not measured are NaN.
    """
    stamps = estimates.smoothed_stamp_ns if signal.smoothed else estimates.stamp_ns
    rows = estimates.smoothed if signal.smoothed else estimates.rows
    scale = np.array([(abs(gear_ratio) if signal.deviation else gear_ratio)
                      if joint == MOTOR else 1.0 for joint in signal.joints])
    values = {'position': rows[:, signal.position] * scale}
    if signal.velocity:
        values['velocity'] = rows[:, signal.velocity] * scale
    if signal.effort:
        values['effort'] = rows[:, signal.effort]
    return stamps, values


def truth(reader, recording):
    """
    Return (stamp_ns, tau_k) of the true or reference torque in the bag, or None.

    A simulated plant publishes plant/transmission_state, an imported recording with a torque
    sensor reference/transmission_state.
    """
    for name in ('plant/transmission_state', 'reference/transmission_state'):
        topic = f'{recording.namespace}/{name}'
        if topic in reader.topics and reader.topics[topic][1]:
            states = reader.joint_states(topic, ('transmission',))
            return states.stamp_ns, states.effort[:, 0]
    return None


def smoothed(result):
    """
    Return rows [M, N_SMOOTHED] for the estimates of a Replay, smoothed over the whole recording.

    With the last parameters in force, changed for a smoother; NaN where a run from the first
    sample, without snapshots, has no estimate.
    """
    found = smooth_interval(
        result.monitor.model, smoother_parameters(result.monitor.parameters),
        result.recording.samples)
    rows = np.full((len(result.estimates.stamp_ns), N_SMOOTHED), np.nan)
    i, j = _match(result.estimates.stamp_ns, found.stamp_ns)
    rows[i] = found.rows[j]
    return rows


def interval_error(reader, result, rows, burn_in=1.0):
    """Return the rms error of tau_K (N m) of the `rows` of `smoothed`, None without a truth."""
    known, stamps = truth(reader, result.recording), result.estimates.stamp_ns
    if known is None or not len(stamps):
        return None
    keep = (stamps >= stamps[0] + round(burn_in * 1e9)) & np.isfinite(rows[:, S_TAU_K])
    i, j = _match(stamps[keep], known[0])
    return _rms(rows[keep, S_TAU_K][i] - known[1][j])


def summary(reader, result, burn_in=1.0):
    """
    Return {name: value} of a Replay for people and machines; the first `burn_in` s do not count.

    Errors are root mean squares in N m against the truth in the bag, where there is one.
    """
    estimates, stamps = result.estimates, result.recording.samples.stamp_ns
    after = estimates.stamp_ns >= (estimates.stamp_ns[0] if len(estimates.stamp_ns) else 0) + \
        round(burn_in * 1e9)
    span = float(stamps.max() - stamps.min()) * 1e-9 if len(stamps) else 0.0
    data = {
        'bag': str(reader.path), 'samples': len(stamps), 'estimates': len(estimates.stamp_ns),
        'duration_s': span, 'rate_hz': (len(stamps) - 1) / span if span > 0 else 0.0,
        'filter': result.monitor.parameters['filter'],
        'adapted': result.monitor.adapted(),
        'adaptation_guards': result.monitor.adaptation_guards(),
        'refused': {text: int(result.monitor.counts[code]) for code, text in REASONS.items()
                    if result.monitor.counts[code]},
        'nis': float(estimates.nis[after].mean()) if after.any() else None,
        'gap_rad': [round(w.gap, 6) for w in result.monitor.windows],
        'levels': {k: f.level.name for k, f in result.monitor.findings.items()},
    }
    known = truth(reader, result.recording)
    if known is not None and after.any():
        i, j = _match(estimates.stamp_ns[after], known[0])
        error = estimates.tau_k[after][i] - known[1][j]
        std = estimates.tau_k_std[after][i]
        data['tau_k_rms'] = _rms(known[1][j])
        data['tau_k_error'] = _rms(error)
        data['coverage_1_sigma'] = float((np.abs(error) <= std).mean()) if len(i) else None
        late = estimates.smoothed_stamp_ns >= estimates.stamp_ns[after][0]
        i, j = _match(estimates.smoothed_stamp_ns[late], known[0])
        data['tau_k_error_smoothed'] = _rms(
            estimates.smoothed[late, S_TAU_K][i] - known[1][j])
    if result.comparison:
        data['replay_identical'] = result.comparison.verdict
        data['comparison'] = asdict(result.comparison)
    data['notes'] = (result.notes + result.monitor.warnings + result.monitor.divergence_notes()
                     + ([reader.notice] if reader.notice else []))
    return data


def _rms(values):
    return float(np.sqrt(np.mean(values ** 2))) if len(values) else None
