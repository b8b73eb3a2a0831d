# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fill a Timeline from a bag: with the estimates in it, or with those of the estimator run on it.

Both go through the bag once, block by block.
"""
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TWIST, S_TWIST_NOISE_STD, S_TWIST_RATE)
from gearbox_monitor.estimation.sample_loop import BRIDGED, REASONS, SECOND
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.health.checks.usability import key_of
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.kernels.types import Flags, Integers, Values
from gearbox_monitor.parameters import EstimatorParameters, resolve
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.joint_input import DIAGNOSTIC_ARRAY, find_input
from gearbox_monitor.recordings.player import recorded_robot
from gearbox_monitor.recordings.recorded_samples import samples_of, sliced
from gearbox_monitor.recordings.recorded_snapshots import NO_MODEL, read_snapshots
from gearbox_monitor.recordings.stamp_matching import StampMatcher
from gearbox_monitor.recordings.topics import ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, TRANSMISSION
from gearbox_monitor.report.timeline import gap_limits, PublishedWindows, Timeline, WindowBacklash

STATE, STATE_STD, SMOOTHED = (
    'transmission_state', 'transmission_state_stddev', 'transmission_state_smoothed')
ERRORS, ERRORS_STD = 'innovations', 'innovations_stddev'
MINUTE = 60.0
SHORT, SHORT_SLICE = 180.0, 10.0  # s: shorter recordings have loops of 10 s
MAX_LOOPS = 240
REMEMBERED = 4096  # innovations: more than a smoother's lag


@dataclass
class RecordingFacts:
    """
    What stands beside the Timeline.

    live: whether the estimates are those of the recording; model: DriveModel; parameters: all of
    the estimator; versions [(of, version)]; counts {counter: number}; notes: sentences.
    """

    live: bool
    model: DriveModel
    parameters: EstimatorParameters
    versions: list[tuple[str, str]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class EstimatorChoice:
    """
    What the estimator is run with on the samples of a bag, instead of the estimates in it.

    model: or None; parameters: {name: value} that replace those of the bag; replay: run it
    even without either of them.
    """

    model: DriveModel | None = None
    parameters: Values = field(default_factory=dict)
    replay: bool = False


class TimelineSource:
    """One bag on its way into a Timeline, `run` once."""

    def __init__(self, reader: Any, topic: str = 'joint_states',
                 choice: EstimatorChoice | None = None,
                 progress: Callable[[float], object] | None = None) -> None:
        """
        Prepare the estimates of a bag.

        Args:
            reader: of the bag.
            topic: of the inputs.
            choice: what the estimator is run with; None: the estimates of the bag, if any.
            progress: called with the share that is done, 0 to 1.

        Raises:
            InputError: the bag has no such input, or its parameters are bad.

        """
        choice = choice or EstimatorChoice()
        self.reader, self._input = reader, find_input(reader, topic)
        self.topic = self._input.topic
        self._progress = progress or (lambda share: None)
        snapshots = read_snapshots(reader, self._input, choice.model is None)
        recorded_model, recorded = DriveModel(), dict[str, Any]()
        if snapshots:
            recorded_model, recorded = snapshots[0].settings(str(reader.path))
        settings = {**recorded, **choice.parameters}
        model, values = resolve(choice.model or recorded_model, settings)
        estimated = all(self._count(name) for name in (STATE, ERRORS, ERRORS_STD))
        live = estimated and choice.model is None and not choice.parameters and not choice.replay
        self.facts = RecordingFacts(live, model, values,
                                    self._versions(snapshots))
        if choice.model is None and not snapshots:
            self.facts.notes.append(NO_MODEL)
        seconds = 1e-9 * ((reader.end_ns or 0) - (reader.start_ns or 0))
        slice_seconds = SHORT_SLICE if seconds < SHORT else \
            MINUTE * math.ceil(seconds / MINUTE / MAX_LOOPS)
        self.timeline = Timeline(slice_seconds)
        self._joints = (values.motor_joint, values.arm_joint)
        self._robot = None if live else recorded_robot(settings, recorded, snapshots)

    def run(self) -> tuple[Timeline, RecordingFacts]:
        """Return the filled Timeline and the facts beside it."""
        if self.facts.live:
            self._live()
        else:
            self._replayed()
        self.timeline.finish()
        if self.reader.notice:
            self.facts.notes.append(self.reader.notice)
        return self.timeline, self.facts

    def _count(self, name: str) -> int:
        count: int = self.reader.topics.get(self._input.name(name), ('', 0))[1]
        return count

    def _versions(self, snapshots: Sequence[Any]) -> list[tuple[str, str]]:
        versions = [('this page', __version__)]
        recorder = self.reader.metadata.get('gearbox_monitor', {}).get('version')
        if recorder:
            versions.append(('recorder', recorder))
        for name in ('version', 'kernels'):
            values = dict.fromkeys(s.content[name] for s in snapshots if name in s.content)
            if values:
                versions.append((f'estimator{"" if name == "version" else ", kernels"}',
                                 ', '.join(values)))
        return versions

    def _blocks(self, topics: Sequence[str]) -> Iterator[Any]:
        """Yield the blocks of `topics`, and report the progress."""
        begin, end = self.reader.start_ns or 0, self.reader.end_ns or 1
        for block in self.reader.blocks(tuple(dict.fromkeys(topics))):
            yield block
            self._progress((int(block.log_ns[-1]) - begin) / max(end - begin, 1))

    # ------------------------------------------------------------------ replayed

    def _replayed(self) -> None:
        monitor, timeline = Monitor(
            self.facts.model, self.facts.parameters, robot=self._robot), self.timeline
        joints = (*self._joints, *monitor.estimator.robot_joints)
        decode = self.reader.decoder(self.topic, joints)
        follower = MonitorFollower(monitor, timeline)
        for block in self._blocks([self.topic]):
            samples, _ = samples_of(decode(block), self.facts.model,
                                    bool(monitor.estimator.robot_joints))
            timeline.add_inputs(samples.stamp_ns, samples.u[:, 0])
            for part in _seconds(samples):
                follower.take(monitor.run(part))
        self.reader.require_joints(self.topic, joints, decode.joints)
        self.facts.counts = {text: int(monitor.counts[code]) for code, text in REASONS.items()}
        self.facts.notes += monitor.estimator.warnings + monitor.estimator.divergence_notes()
        self.facts.versions.append(('kernels', KERNELS))

    # ------------------------------------------------------------------ live

    def _live(self) -> None:
        names = {MOTOR: self._joints[0], ARM: self._joints[1]}
        ratio = self.facts.model.gear_ratio
        transmission = (self._input.transmission,)
        joints = {STATE: transmission, STATE_STD: transmission, SMOOTHED: transmission,
                  ERRORS: tuple(names.values()), ERRORS_STD: tuple(names.values())}
        topics = {name: self._input.name(name) for name in joints if self._count(name)}
        decode = {name: self.reader.decoder(topic, joints[name])
                  for name, topic in topics.items()}
        topics['inputs'] = self.topic
        decode['inputs'] = self.reader.decoder(self.topic, self._joints)
        diagnostics = [topic for topic in (DIAGNOSTICS, self._input.name(DRIFT_ALERTS))
                       if topic in self.reader.topics]
        recorded = RecordedDiagnostics(self.reader, self.timeline, self._input)
        errors, torque = StampMatcher(2, 2), StampMatcher(1, 1)
        twist_filter = MeasuredTwist()
        loops = SMOOTHED if self._count(SMOOTHED) else STATE
        scale = np.array([ratio, 1.0])
        for block in self._blocks([*topics.values(), *diagnostics]):
            states = {name: decoder(block.of(topics[name])) for name, decoder in decode.items()}
            if self._input.transmission != TRANSMISSION:  # others are of other gearboxes
                states = {name: rows.of_named() for name, rows in states.items()}
            samples, log_ns = samples_of(states['inputs'], self.facts.model)
            self.timeline.add_inputs(samples.stamp_ns, samples.u[:, 0])
            if self.timeline.first_ns is None:
                continue  # diagnostics from before the first sample have no time
            for stamps, error, std in _paired(errors, block, states, (ERRORS, ERRORS_STD),
                                              'position'):
                self.timeline.add_errors(stamps, error / scale, std / np.abs(scale))
            for stamps, tau_k, std in _paired(torque, block, states, (STATE, STATE_STD),
                                              'effort'):
                self.timeline.add_torque(stamps, tau_k[:, 0], std[:, 0])
            loop = states[loops]
            valid = twist_filter.valid(states, loop.stamp_ns)
            self.timeline.add_loop(loop.stamp_ns[valid], loop.position[valid, 0],
                                   loop.velocity[valid, 0], loop.effort[valid, 0])
            recorded.take(block, diagnostics, log_ns, samples.stamp_ns)
        self.facts.counts = recorded.counts


def _paired(pairing: Any, block: Any, states: Mapping[str, Any], names: Sequence[str],
            field_name: str) -> Iterator[Any]:
    """Yield (stamps, values, deviations) of values that have met their stated deviations."""
    sides = [states[name] for name in names if name in states]
    if len(sides) == 2:
        pairing.put(int(block.log_ns[-1]), *(
            (side.stamp_ns, getattr(side, field_name)) for side in sides))
        yield pairing.pairs()
        pairing.expired(int(block.log_ns[-1]))


def twist_std(parameters: EstimatorParameters) -> float:
    """Return the deviation of the twist (rad) by `parameters`; above it an encoder was missing."""
    return math.hypot(parameters.r_std_motor, parameters.r_std_arm)


def _seconds(samples: Samples) -> Iterator[Samples]:
    """Yield `samples` second by second, so that no evaluation is passed over."""
    stamps = samples.stamp_ns
    if not len(stamps):
        return
    edges = (np.flatnonzero(np.diff(stamps // SECOND)) + 1).tolist()
    for begin, end in zip([0, *edges], [*edges, len(stamps)]):
        yield sliced(samples, begin, end)


class MonitorFollower:
    """Passes the results of a Monitor to a Timeline."""

    def __init__(self, monitor: Monitor, timeline: Timeline) -> None:
        """Follow `monitor` into `timeline`."""
        self._monitor, self._timeline = monitor, timeline
        self._window: Backlash | None = None
        self._outcomes = monitor.outcomes
        self._stages: dict[str, Any] = {}
        self._twist_std = twist_std(monitor.parameters)

    def take(self, estimates: Estimates) -> None:
        """Take the `estimates` of the newest samples."""
        monitor, timeline, stamps = self._monitor, self._timeline, estimates.stamp_ns
        timeline.add_errors(
            stamps, np.column_stack([estimates.innovation_motor, estimates.innovation_arm]),
            np.column_stack([estimates.innovation_std_motor, estimates.innovation_std_arm]))
        timeline.add_torque(stamps, estimates.tau_k, estimates.tau_k_std)
        with np.errstate(invalid='ignore', divide='ignore'):
            timeline.add_nis(stamps, estimates.nis / estimates.dof)
        valid = estimates.smoothed[:, S_TWIST_NOISE_STD] <= self._twist_std
        rows = estimates.smoothed[valid]
        timeline.add_loop(estimates.smoothed_stamp_ns[valid], rows[:, S_TWIST],
                          rows[:, S_TWIST_RATE], rows[:, S_TAU_K])
        if monitor.outcomes is self._outcomes:
            return
        self._outcomes = monitor.outcomes
        timeline.add_outcomes(monitor.stamp_ns, {
            name: (outcome.level, outcome.message) for name, outcome in self._outcomes.items()})
        if monitor.windows and monitor.windows[-1] is not self._window:
            self._window = window = monitor.windows[-1]
            timeline.add_window(window.stamp_ns, WindowBacklash(
                math.nan, window.gap, window.gap_std, window.lost_motion, window.separable,
                *gap_limits(self._outcomes['backlash'].values)))
        for component, stages in monitor.tracker.stages().items():
            if stages != self._stages.get(component, {}):
                self._stages[component] = stages
                outcome = self._outcomes[component]
                timeline.add_alert(monitor.stamp_ns, component, outcome.level, outcome.message)


class MeasuredTwist:
    """
    Knows at which stamps the twist was measured, by the innovations of both encoders.

    The published deviation of the twist cannot tell: it also holds the tolerances of the model.
    """

    def __init__(self) -> None:
        """Begin without a measurement."""
        self._stamps = [np.empty(0, np.int64)] * 2

    def valid(self, states: Mapping[str, Any], stamps: Integers) -> Flags:
        """Return flags [N] at `stamps` [N] ns of the block with `states`."""
        valid = np.ones(len(stamps), bool)
        if ERRORS not in states:
            return valid
        errors = states[ERRORS]
        for i in range(2):
            measured = errors.stamp_ns[np.isfinite(errors.position[:, i])]
            # Smoothed values come later.
            self._stamps[i] = np.concatenate([self._stamps[i][-REMEMBERED:], measured])
            if not len(self._stamps[i]):
                return np.zeros(len(stamps), bool)
            last = np.searchsorted(self._stamps[i], stamps, side='right') - 1
            valid &= (last >= 0) & (stamps - self._stamps[i][np.maximum(last, 0)] <= BRIDGED)
        return valid


class RecordedDiagnostics:
    """Passes recorded diagnostics of the estimator to a Timeline."""

    def __init__(self, reader: Any, timeline: Timeline, source: Any) -> None:
        """Read from the bag of `reader` into `timeline`; `source`: its Input."""
        self._reader, self._timeline = reader, timeline
        self.counts: dict[str, int] = {}
        self._prefix = f'{source.namespace}/'.lstrip('/')
        self._windows = PublishedWindows()
        self._node: str | None = None
        if source.snapshots:
            self._node = source.snapshots.rsplit('/', 1)[0].lstrip('/')
        self._waiting: list[tuple[int, str, Any]] = []
        self._log_ns, self._stamps = np.empty(0, np.int64), np.empty(0, np.int64)

    def take(self, block: Any, topics: Sequence[str], log_ns: Integers,
             stamps: Integers) -> None:
        """
        Take diagnostics at the stamps that the samples had when they were recorded.

        Messages behind the last sample count nothing: the source has ended, not failed.

        Args:
            block: of messages.
            topics: of diagnostics.
            log_ns: times [N] at which the samples of the block were recorded.
            stamps: of these samples [N].

        """
        for topic in topics:
            self._waiting += [(logged, topic, raw)
                              for _, logged, _, raw in block.of(topic).messages()]
        if not len(log_ns):
            return
        logged = np.concatenate([self._log_ns[-1:], log_ns])
        at = np.concatenate([self._stamps[-1:], stamps])
        self._log_ns, self._stamps = logged, at
        self._waiting.sort(key=lambda message: message[0])
        while self._waiting and self._waiting[0][0] <= logged[-1]:
            when, topic, raw = self._waiting.pop(0)
            self._add(topic, int(np.interp(when - logged[0], logged - logged[0], at - at[0]))
                      + int(at[0]), self._reader.decode(DIAGNOSTIC_ARRAY, raw))

    def _add(self, topic: str, stamp: int, message: Any) -> None:
        outcomes = {}
        for status in message.status:
            node, _, component = status.name.partition(': ')
            level = min(int(status.level), 2)
            if not self._ours(node, component):
                continue
            if topic != DIAGNOSTICS:
                self._timeline.add_alert(stamp, component, level, status.message)
                continue
            outcomes[component] = level, status.message
            values = {value.key: value.value for value in status.values}
            if component == 'input':
                counters = {key_of(reason): reason for reason in REASONS.values()}
                self.counts = {counters[key]: int(value) for key, value in values.items()
                               if key in counters}
            elif component == 'prediction error' and 'nis_over_dof' in values:
                self._timeline.add_nis(np.array([stamp]),
                                       np.array([float(values['nis_over_dof'])]))
            elif component == 'backlash':
                window = self._windows.window(math.nan, status.message, values)
                if window is not None:
                    self._timeline.add_window(stamp, window)
        if outcomes:
            self._timeline.add_outcomes(stamp, outcomes)

    def _ours(self, node: str, component: str) -> bool:
        """Return whether this is the estimator beside the topic of the inputs."""
        if node.startswith(self._prefix) and component == 'observability' and self._node is None:
            self._node = node
        return node == self._node
