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
Fill a Timeline from a bag: with the estimates in it, or with those of the estimator run on it.

Both go through the bag once, block by block.
"""
from dataclasses import dataclass, field
import math

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.bag.joint_input import DIAGNOSTIC_ARRAY, find_input
from gearbox_monitor.bag.replay import read_snapshots, samples_of
from gearbox_monitor.bag.stamp_matching import StampMatcher
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TWIST, S_TWIST_RATE, S_TWIST_STD
from gearbox_monitor.estimation.sample_loop import REASONS
from gearbox_monitor.interfaces.signals import ARM, DIAGNOSTICS, DRIFT_ALERTS, MOTOR, TRANSMISSION
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.monitoring.checks.usability import key_of
from gearbox_monitor.monitoring.monitor import Monitor, Samples, SECOND
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.report.timeline import Timeline

STATE, STATE_STD, SMOOTHED = (
    'transmission_state', 'transmission_state_stddev', 'transmission_state_smoothed')
ERRORS, ERRORS_STD = 'innovations', 'innovations_stddev'
MINUTE = 60.0
SHORT, SHORT_SLICE = 180.0, 10.0  # s: shorter recordings have loops of 10 s
MAX_LOOPS = 240
KEPT = 4096  # deviations of the twist that are remembered: more than a smoother's lag


@dataclass
class Facts:
    """
    What stands beside the Timeline.

    live: whether the estimates are those of the recording; model: DriveModel; parameters: all of
    the estimator; versions [(what, version)]; counts {counter: number}; notes: sentences.
    """

    live: bool
    model: DriveModel
    parameters: EstimatorParameters
    versions: list = field(default_factory=list)
    counts: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)


class Source:
    """
    One bag on its way into a Timeline.

    model: DriveModel or None; parameters: {name: value} given; either of them, or `again`, or a
    bag without estimates: the estimator runs on the samples. progress: called with the share
    done, 0 to 1. Raises InputError.
    """

    def __init__(self, reader, topic='joint_states', model=None, parameters=None, again=False,
                 progress=None):
        self.reader, self._input = reader, find_input(reader, topic)
        self.topic = self._input.topic
        self._progress = progress or (lambda share: None)
        snapshots = read_snapshots(reader, self._input)
        recorded_model, recorded = DriveModel(), {}
        if snapshots:
            recorded_model, recorded = snapshots[0].used(reader.path)
        values = EstimatorParameters.from_mapping({**recorded, **(parameters or {})})
        there = self._count(STATE) and self._count(ERRORS) and self._count(ERRORS_STD)
        live = bool(there) and model is None and not parameters and not again
        self.facts = Facts(live, model or recorded_model, values, self._versions(snapshots))
        if model is None and not snapshots:
            self.facts.notes.append('the bag names no model and none was given: that of the '
                                    'packaged drive.yaml was used')
        seconds = 1e-9 * ((reader.end_ns or 0) - (reader.start_ns or 0))
        slice_seconds = SHORT_SLICE if seconds < SHORT else \
            MINUTE * math.ceil(seconds / MINUTE / MAX_LOOPS)
        self.timeline = Timeline(slice_seconds)
        self._names = (values.motor_joint, values.arm_joint)

    def run(self):
        """Return (Timeline, Facts)."""
        (self._live if self.facts.live else self._replayed)()
        self.timeline.finish()
        if self.reader.notice:
            self.facts.notes.append(self.reader.notice)
        return self.timeline, self.facts

    def _count(self, name):
        return self.reader.topics.get(self._input.name(name), ('', 0))[1]

    def _versions(self, snapshots):
        versions = [('this page', __version__)]
        recorder = self.reader.metadata.get('gearbox_monitor', {}).get('version')
        if recorder:
            versions.append(('recorder', recorder))
        for name in ('version', 'kernels'):
            found = dict.fromkeys(s.content[name] for s in snapshots if name in s.content)
            if found:
                versions.append((f'estimator{"" if name == "version" else ", kernels"}',
                                 ', '.join(found)))
        return versions

    def _blocks(self, topics):
        """Yield the Blocks of `topics`, and say how far they are."""
        begin, end = self.reader.start_ns or 0, self.reader.end_ns or 1
        for block in self.reader.blocks(tuple(dict.fromkeys(topics))):
            yield block
            self._progress((int(block.log_ns[-1]) - begin) / max(end - begin, 1))

    # ------------------------------------------------------------------ replayed

    def _replayed(self):
        monitor, line = Monitor(self.facts.model, self.facts.parameters), self.timeline
        decode = self.reader.decoder(self.topic, self._names)
        state = _Followed(monitor, line)
        for block in self._blocks([self.topic]):
            samples, _ = samples_of(decode(block), self.facts.model)
            line.add_inputs(samples.stamp_ns, samples.u[:, 0])
            for part in _seconds(samples):
                state.take(monitor.run(part))
        self.reader.require_joints(self.topic, self._names, decode.there)
        self.facts.counts = {text: int(monitor.counts[code]) for code, text in REASONS.items()}
        self.facts.notes += monitor.warnings + monitor.divergence_notes()
        self.facts.versions.append(('kernels', KERNELS))

    # ------------------------------------------------------------------ live

    def _live(self):
        names = {MOTOR: self._names[0], ARM: self._names[1]}
        ratio = self.facts.model.gear_ratio
        joints = {STATE: (TRANSMISSION,), STATE_STD: (TRANSMISSION,), SMOOTHED: (TRANSMISSION,),
                  ERRORS: tuple(names.values()), ERRORS_STD: tuple(names.values())}
        topics = {name: self._input.name(name) for name in joints if self._count(name)}
        decode = {name: self.reader.decoder(topic, joints[name])
                  for name, topic in topics.items()}
        topics['inputs'] = self.topic
        decode['inputs'] = self.reader.decoder(self.topic, self._names)
        said = [topic for topic in (DIAGNOSTICS, self._input.name(DRIFT_ALERTS))
                if topic in self.reader.topics]
        heard = _Heard(self.reader, self.timeline, self._input)
        errors, torque = StampMatcher(2, 2), StampMatcher(1, 1)
        stated = _Stated(measured(self.facts.parameters))
        loops = SMOOTHED if self._count(SMOOTHED) else STATE
        scale = np.array([ratio, 1.0])
        for block in self._blocks([*topics.values(), *said]):
            states = {name: one(block.of(topics[name])) for name, one in decode.items()}
            samples, log_ns = samples_of(states['inputs'], self.facts.model)
            self.timeline.add_inputs(samples.stamp_ns, samples.u[:, 0])
            if self.timeline.first_ns is None:
                continue  # diagnostics from before the first sample tell nothing
            self._paired(errors, block, states, (ERRORS, ERRORS_STD), 'position',
                         lambda stamps, error, std: self.timeline.add_errors(
                             stamps, error / scale, std / np.abs(scale)))
            self._paired(torque, block, states, (STATE, STATE_STD), 'effort',
                         lambda stamps, tau_k, std: self.timeline.add_torque(
                             stamps, tau_k[:, 0], std[:, 0]))
            loop, known = states[loops], stated.known(states, states[loops].stamp_ns)
            self.timeline.add_loop(loop.stamp_ns[known], loop.position[known, 0],
                                   loop.velocity[known, 0], loop.effort[known, 0])
            heard.take(block, said, log_ns, samples.stamp_ns)
        self.facts.counts = heard.counts

    @staticmethod
    def _paired(pairing, block, states, names, name, take):
        """Hand (stamps, values, deviations) of what has met its stated deviation to `take`."""
        sides = [states[n] for n in names if n in states]
        if len(sides) == 2:
            pairing.put(int(block.log_ns[-1]), *(
                (side.stamp_ns, getattr(side, name)) for side in sides))
            take(*pairing.pairs())
            pairing.expired(int(block.log_ns[-1]))


def measured(parameters):
    """Return the deviation of the twist (rad) above which an encoder was missing."""
    return math.hypot(parameters.r_std_motor, parameters.r_std_arm)


def _seconds(samples):
    """Yield the Samples second by second, so that no evaluation is passed over."""
    stamps = samples.stamp_ns
    if not len(stamps):
        return
    edges = np.flatnonzero(np.diff(stamps // SECOND)) + 1
    for part in np.split(np.arange(len(stamps)), edges):
        here = slice(part[0], part[-1] + 1)
        yield Samples(stamps[here], samples.u[here], samples.y[here])


class _Followed:
    """Hands what a Monitor says to a Timeline."""

    def __init__(self, monitor, line):
        self._monitor, self._line = monitor, line
        self._window, self._findings, self._stages = None, monitor.findings, {}
        self._measured = measured(monitor.parameters)

    def take(self, estimates):
        """Take the Estimates of the newest samples."""
        monitor, line, stamps = self._monitor, self._line, estimates.stamp_ns
        line.add_errors(
            stamps, np.column_stack([estimates.innovation_motor, estimates.innovation_arm]),
            np.column_stack([estimates.innovation_std_motor, estimates.innovation_std_arm]))
        line.add_torque(stamps, estimates.tau_k, estimates.tau_k_std)
        with np.errstate(invalid='ignore', divide='ignore'):
            line.add_nis(stamps, estimates.nis / estimates.dof)
        known = estimates.smoothed[:, S_TWIST_STD] <= self._measured
        rows = estimates.smoothed[known]
        line.add_loop(estimates.smoothed_stamp_ns[known], rows[:, S_TWIST],
                      rows[:, S_TWIST_RATE], rows[:, S_TAU_K])
        if monitor.findings is self._findings:
            return
        self._findings = monitor.findings
        line.add_findings(monitor.stamp_ns, {
            name: (finding.level, finding.message) for name, finding in self._findings.items()})
        if monitor.windows and monitor.windows[-1] is not self._window:
            self._window = new = monitor.windows[-1]
            line.add_window(new.stamp_ns, new.gap, new.gap_std, new.lost_motion, new.separable,
                            self._findings['backlash'].values)
        for component, stages in monitor.tracker.stages().items():
            if stages != self._stages.get(component, {}):
                self._stages[component] = stages
                found = self._findings[component]
                line.add_alert(monitor.stamp_ns, component, found.level, found.message)


class _Stated:
    """Tells at which stamps the twist was measured, by its published deviation."""

    def __init__(self, limit):
        self._limit = limit
        self._stamps, self._known = np.empty(0, np.int64), np.empty(0, bool)

    def known(self, states, stamps):
        """Return bool [N] at the stamps int64 [N] of the block with `states`."""
        if STATE_STD not in states:
            return np.ones(len(stamps), bool)
        new = states[STATE_STD]
        keep = slice(-KEPT, None)  # smoothed values come later
        self._stamps = np.concatenate([self._stamps[keep], new.stamp_ns])
        self._known = np.concatenate([self._known[keep], new.position[:, 0] <= self._limit])
        if not len(self._stamps):
            return np.ones(len(stamps), bool)
        at = np.minimum(np.searchsorted(self._stamps, stamps), len(self._stamps) - 1)
        return self._known[at]


class _Heard:
    """Hands recorded diagnostics of the estimator to a Timeline."""

    def __init__(self, reader, line, found):
        self._reader, self._line, self.counts = reader, line, {}
        self._prefix = f'{found.namespace}/'.lstrip('/')
        self._window, self._node = None, None
        if found.snapshots:
            self._node = found.snapshots.rsplit('/', 1)[0].lstrip('/')
        self._waiting, self._last = [], (np.empty(0, np.int64), np.empty(0, np.int64))

    def take(self, block, topics, log_ns, stamps):
        """
        Take the messages on `topics`; log_ns, stamps int64 [N] of the samples in `block`.

        A message counts at the stamp that the samples had when it was recorded. Those behind the
        last sample count nothing: the source has ended, not failed.
        """
        for topic in topics:
            self._waiting += [(logged, topic, raw)
                              for _, logged, _, raw in block.of(topic).messages()]
        if not len(log_ns):
            return
        logged, at = (np.concatenate([self._last[k][-1:], new])
                      for k, new in enumerate((log_ns, stamps)))
        self._last = logged, at
        self._waiting.sort(key=lambda message: message[0])
        while self._waiting and self._waiting[0][0] <= logged[-1]:
            when, topic, raw = self._waiting.pop(0)
            self._told(topic, int(np.interp(when - logged[0], logged - logged[0], at - at[0]))
                       + int(at[0]), self._reader.decode(DIAGNOSTIC_ARRAY, raw))

    def _told(self, topic, stamp, message):
        findings = {}
        for status in message.status:
            node, _, component = status.name.partition(': ')
            level = min(int(status.level), 2)
            if not self._ours(node, component):
                continue
            if topic != DIAGNOSTICS:
                self._line.add_alert(stamp, component, level, status.message)
                continue
            findings[component] = level, status.message
            values = {value.key: value.value for value in status.values}
            if component == 'input':
                counters = {key_of(reason): reason for reason in REASONS.values()}
                # Bags of older versions hold the reasons themselves.
                self.counts = {counters[key_of(key)]: int(value) for key, value in values.items()
                               if key_of(key) in counters}
            elif component == 'prediction error' and 'nis_over_dof' in values:
                self._line.add_nis(np.array([stamp]), np.array([float(values['nis_over_dof'])]))
            elif component == 'backlash':
                self._backlash(stamp, values, status.message)
        if findings:
            self._line.add_findings(stamp, findings)

    def _ours(self, node, component):
        """Return whether this is the estimator beside the topic of the inputs."""
        if node.startswith(self._prefix) and component == 'observability' and self._node is None:
            self._node = node
        return node == self._node

    def _backlash(self, stamp, values, message):
        """Note a window when its figures are new."""
        if 'gap_rad' not in values or message.startswith('not excited now'):
            return
        numbers = {key: float(value) for key, value in values.items() if _is_number(value)}
        window = numbers['gap_rad'], numbers.get('gap_std_rad'), numbers.get('lost_motion_rad')
        if window != self._window:
            self._window = window
            self._line.add_window(
                stamp, window[0], window[1] if window[1] is not None else math.nan,
                window[2] if window[2] is not None else math.nan,
                values.get('separable') != 'False', numbers)


def _is_number(text):
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
