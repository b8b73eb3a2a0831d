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
One sample in, one estimate out: filter, trust and drift. No ROS, no I/O, no clock.

The live node, replay and the tests call the same `Monitor`, sample by sample (`step`) or in arrays
(`run`): same samples in, same bits out.
"""
from collections import deque
from dataclasses import asdict, dataclass, replace
import json

import numpy as np

from gearbox_monitor import stream
from gearbox_monitor.drift import change, features
from gearbox_monitor.drive.model import model_from_dict
from gearbox_monitor.errors import InputError
from gearbox_monitor.filters import FILTERS
from gearbox_monitor.filters.process import pack, state_names, TAU_K, X3
from gearbox_monitor.filters.record import record_size
from gearbox_monitor.filters.smoother import (
    N_SMOOTHED, S_TAU_K, S_TAU_K_STD, S_TWIST, S_TWIST_STD)
from gearbox_monitor.parameters import checked, ESTIMATOR
from gearbox_monitor.trust import covariance, innovation, observability
from gearbox_monitor.trust.level import Alarm, Finding, Level

RING = 2048
HISTORY = 8192
SECOND = stream.SECOND
SETTLE = 2.0  # s after a start that are not judged
REFERENCE_EVALUATIONS = 5
COMPONENTS = ('observability', 'prediction error', 'covariance', 'backlash', 'input')


class SnapshotError(InputError):
    """A snapshot cannot be read: damaged, or of another version."""


@dataclass(frozen=True)
class Sample:
    """
    One stamped measurement.

    stamp_ns: int. u: (motor torque, known load on the arm), N m. y: (motor, arm) position, rad on
    the arm side. NaN = not measured.
    """

    stamp_ns: int
    u: tuple
    y: tuple


@dataclass(frozen=True)
class Samples:
    """N samples as arrays: stamp_ns int64 [N], u [N, 2], y [N, 2]; see Sample."""

    stamp_ns: np.ndarray
    u: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Estimates:
    """
    M estimates: stamp_ns int64 [M], rows [M, stream.N_ESTIMATE] (columns stream.E_*).

    smoothed_stamp_ns int64 [L], smoothed [L, N_SMOOTHED] (columns smoother.S_*). codes int64 [N]:
    what became of each sample that came in.
    """

    stamp_ns: np.ndarray
    rows: np.ndarray
    smoothed_stamp_ns: np.ndarray
    smoothed: np.ndarray
    codes: np.ndarray

    def __getattr__(self, name):
        """Give columns by name: e.tau_k, e.tau_k_std, e.nis, e.x1, e.innovation_motor ..."""
        column = COLUMNS.get(name)
        if column is None:
            raise AttributeError(name)
        return self.rows[:, column]


COLUMNS = {name[2:].lower(): value for name, value in vars(stream).items()
           if name.startswith('E_') and name != 'E_STD'}
COLUMNS.update({f'{name}_std': stream.E_STD + i for i, name in enumerate(
    ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_arm', 'tau_e'))})


@dataclass(frozen=True)
class Estimate:
    """
    What one accepted sample gave.

    x [n] state (see filters.process) and P [n, n]; row: all columns (stream.E_*), also by name:
    tau_k and tau_k_std (N m), nis with dof degrees of freedom ...; smoothed: rows (stamp_ns,
    smoother.S_* [N_SMOOTHED]) that became due; findings {component: Finding} in force.
    """

    stamp_ns: int
    x: np.ndarray
    P: np.ndarray
    row: np.ndarray
    smoothed: tuple
    findings: dict

    @property
    def innovation(self):
        """Prediction errors y - yhat of motor and arm, [2] rad; NaN = not measured."""
        return self.row[[stream.E_INNOVATION_MOTOR, stream.E_INNOVATION_ARM]]

    @property
    def S(self):
        """Covariance of the innovation, [2, 2] rad^2."""
        motor, arm, both = self.row[[stream.E_INNOVATION_STD_MOTOR, stream.E_INNOVATION_STD_ARM,
                                     stream.E_INNOVATION_COVARIANCE]]
        return np.array([[motor ** 2, both], [both, arm ** 2]])

    @property
    def trust(self):
        """The findings of the three trust indicators, {component: Finding}."""
        return {name: self.findings[name] for name in COMPONENTS[:3]}

    @property
    def drift(self):
        """The Finding on backlash."""
        return self.findings['backlash']

    def __getattr__(self, name):
        """Give columns by name, as Estimates does."""
        column = COLUMNS.get(name)
        if column is None:
            raise AttributeError(name)
        return self.row[column]


class Monitor:
    """
    Filter, trust and drift of one gearbox.

    model: DriveModel. parameters: mapping with names of parameters.ESTIMATOR; the rest take their
    defaults. baseline: change.Baseline or None (then the first windows make it).
    Raises InputError for a parameter that is unknown or out of range.
    """

    def __init__(self, model, parameters=None, baseline=None):
        self.model = model
        self.parameters = checked(ESTIMATOR, parameters or {}, 'parameters')
        self.baseline = baseline
        self.counts = np.zeros(stream.N_COUNTS, np.int64)
        self.findings = {name: Finding(Level.WARN, 'no data yet') for name in COMPONENTS}
        self.windows = deque(maxlen=1000)  # Backlash of each window, newest last
        self._gate = np.zeros(stream.N_GATE, np.int64)
        self._setup()

    # ------------------------------------------------------------------ set-up and state

    def _setup(self):
        p = self.parameters
        if p['arm_load'] == 'model':
            p = {**p, 'arm_load': self.model.arm_load}
        self.drive = self.model.with_(arm_load=p['arm_load'])
        self.names = state_names(self.drive, p)
        self._packed = pack(self.drive, p)
        self._kind = stream.KINDS[p['filter']]
        self._settings = np.array([
            round(p['max_gap'] * SECOND), p['effort_delay'], round(p['smoother_lag'] * SECOND),
            self.drive.arm_load == 'measured'], np.int64)
        n, module = len(self.names), FILTERS[p['filter']]
        self.warnings = module.warnings(n, p) if hasattr(module, 'warnings') else []
        self._z, self._P = np.zeros(n), np.eye(n)
        self._memory = np.zeros(module.memory_size(n))
        self._clock, self._efforts = np.zeros(1), np.zeros((stream.N_EFFORTS, 2))
        self._ring = np.zeros((RING, record_size(n)))
        self._ring_stamps = np.zeros(RING, np.int64)
        self._vectors = np.zeros((module.N_VECTORS, n))
        self._matrices = np.zeros((max(module.N_MATRICES, 5), n, n))
        self._one = (np.zeros(1, np.int64), np.zeros((1, 2)), np.zeros((1, 2)))
        self._codes_one = np.zeros(1, np.int64)
        self._row_one = np.zeros((1, stream.N_ESTIMATE))
        self._smoothed_one = (np.zeros(RING + 1, np.int64), np.zeros((RING + 1, N_SMOOTHED)))
        self._gate[:stream.INPUTS] = 0
        self._forget()

    def _forget(self):
        """Drop all windows: what they hold belongs to another belief."""
        self._history = np.zeros((HISTORY, stream.N_ESTIMATE))
        self._history_stamps = np.zeros(HISTORY, np.int64)
        self._held = 0  # rows ever written to the history
        self._drift = []  # chunks (stamps, smoothed rows) of the window under way
        self._drift_start = None
        self._gate[stream.EVALUATE_AT] = 0
        self._reference = None
        self._references = []
        self._alarms = {name: Alarm() for name in COMPONENTS}
        self._alarms['backlash'] = Alarm(up=2, down=2)
        self._last_counts = self.counts.copy()

    def reset(self):
        """Start anew with the next sample; counters and baseline stay."""
        self._setup()

    def set_parameters(self, changes):
        """
        Change parameters while running; Q, R and thresholds keep the belief, others restart.

        Raises InputError, leaving everything as it was.
        """
        rows = {row.name: row for row in ESTIMATOR}
        new = checked(ESTIMATOR, {**self.parameters, **changes}, 'parameters')
        pack(self.drive, new)  # raises before anything has changed
        restart = any(rows[name].change != 'at once' for name in changes
                      if new[name] != self.parameters[name])
        self.parameters = new
        if restart:
            self._setup()
            return
        z, P, clock, efforts, gate = (
            self._z, self._P, self._clock, self._efforts, self._gate.copy())
        packed, memory = self._packed, self._memory
        self._setup()
        self._z, self._P, self._clock, self._efforts = z, P, clock, efforts
        if np.array_equal(packed, self._packed):  # nothing that the filter computes with
            self._memory = memory
        self._gate[:] = gate
        self._gate[stream.EVALUATE_AT] = 0
        self._keep_belief_only()

    def _keep_belief_only(self):
        """Let the smoother begin at the present step: older records are not at hand."""
        step = self._gate[stream.STEPS]
        n = len(self.names)
        start = n + 2 * n * n
        row = self._ring[step % RING]
        row[start:start + n] = self._z
        row[start + n:start + n + n * n] = self._P.ravel()
        row[-1] = self._efforts[(step - 1 - self.parameters['effort_delay']) % stream.N_EFFORTS, 0]
        self._ring_stamps[step % RING] = self._gate[stream.LAST]
        self._gate[stream.SMOOTH_NEXT] = step

    def snapshot(self):
        """
        Return everything that the next estimates depend on, as {name: text}.

        Numbers are written so that they read back bit for bit; see restore.
        """
        def numbers(a):
            return json.dumps([float(v).hex() for v in np.ravel(a)])

        return {
            'model': json.dumps(self.model.to_dict()),
            'parameters': json.dumps(self.parameters),
            'baseline': json.dumps(self.baseline and asdict(self.baseline)),
            'stamp_ns': str(self._gate[stream.LAST]),
            'input_count': str(self._gate[stream.INPUTS]),
            'gate': json.dumps([int(v) for v in self._gate[:stream.EVALUATE_AT]]),
            'counts': json.dumps([int(v) for v in self.counts]),
            'z': numbers(self._z), 'P': numbers(self._P), 'memory': numbers(self._memory),
            'clock': numbers(self._clock), 'efforts': numbers(self._efforts)}

    @classmethod
    def restore(cls, snapshot, source='snapshot'):
        """Return the Monitor that went on from `snapshot`. Raises InputError."""
        def numbers(name, like):
            values = [float.fromhex(v) for v in json.loads(snapshot[name])]
            return np.array(values).reshape(like.shape)

        try:
            baseline = json.loads(snapshot['baseline'])
            monitor = cls(model_from_dict(json.loads(snapshot['model']), source),
                          json.loads(snapshot['parameters']),
                          baseline and change.Baseline(**baseline))
            monitor._gate[:stream.EVALUATE_AT] = np.reshape(
                json.loads(snapshot['gate']), stream.EVALUATE_AT)
            monitor._gate[stream.INPUTS] = int(snapshot['input_count'])
            monitor.counts[:] = json.loads(snapshot['counts'])
            monitor._z = numbers('z', monitor._z)
            monitor._P = numbers('P', monitor._P)
            monitor._memory = numbers('memory', monitor._memory)
            monitor._clock = numbers('clock', monitor._clock)
            monitor._efforts = numbers('efforts', monitor._efforts)
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            raise SnapshotError(f'{source}: not a snapshot of this version ({error})') from None
        monitor._last_counts = monitor.counts.copy()
        monitor._keep_belief_only()
        return monitor

    def adopt_baseline(self, snapshot):
        """Take over the baseline of a `snapshot`, which may have been saved meanwhile."""
        baseline = json.loads(snapshot['baseline'])
        self.baseline = baseline and change.Baseline(**baseline)

    def adapted(self):
        """Return {parameter: value in use} of what the filter adapts, in the parameter's unit."""
        module = FILTERS[self.parameters['filter']]
        return module.adapted(self._memory, self._packed) if hasattr(module, 'adapted') else {}

    def adaptation_guards(self):
        """Return {guard of the adaptation: how often it acted since the start}."""
        module = FILTERS[self.parameters['filter']]
        return module.guards(self._memory) if self.adapted() else {}

    @property
    def stamp_ns(self):
        """Stamp of the last accepted sample, 0 before the first."""
        return int(self._gate[stream.LAST])

    @property
    def input_count(self):
        """How many samples came in, refused ones included."""
        return int(self._gate[stream.INPUTS])

    @property
    def period(self):
        """The usual distance of stamps (s), 0 before it is known."""
        return float(self._clock[0])

    # ------------------------------------------------------------------ samples

    def step(self, sample):
        """Take one Sample; return its Estimate, or None where it was refused or is the first."""
        stamps, u, y = self._one
        stamps[0] = sample.stamp_ns
        u[0], y[0] = sample.u, sample.y
        stamps_s, smoothed = self._smoothed_one
        _, n = self._run(stamps, u, y, self._codes_one, self._row_one, stamps_s, smoothed)
        due = tuple((int(stamps_s[i]), smoothed[i].copy()) for i in range(n))
        good = self._codes_one == stream.ESTIMATE
        self._remember(stamps[good], self._row_one[good], stamps_s[:n].copy(),
                       smoothed[:n].copy())
        if good[0] or self._codes_one[0] == stream.START:
            self._after(int(sample.stamp_ns))
        if not good[0]:
            return None
        return Estimate(int(sample.stamp_ns), self._z.copy(), self._P.copy(),
                        self._row_one[0].copy(), due, self.findings)

    def run(self, samples):
        """Take Samples (N of them); return their Estimates. Same bits as step by step."""
        stamps = np.ascontiguousarray(samples.stamp_ns, np.int64)
        u = np.ascontiguousarray(samples.u, float)
        y = np.ascontiguousarray(samples.y, float)
        parts, start = [self._run_part(stamps[:0], u[:0], y[:0])[1:]], 0
        while start < len(stamps):
            end = start + HISTORY // 2
            taken, *part = self._run_part(stamps[start:end], u[start:end], y[start:end])
            parts.append(part)
            start += taken
        return Estimates(*(np.concatenate(column) for column in zip(*parts)))

    def _run_part(self, stamps, u, y):
        codes = np.empty(len(stamps), np.int64)
        rows = np.empty((len(stamps), stream.N_ESTIMATE))
        stamps_s = np.empty(len(stamps) + RING, np.int64)
        smoothed = np.empty((len(stamps) + RING, N_SMOOTHED))
        taken, n = self._run(stamps, u, y, codes, rows, stamps_s, smoothed)
        stamps, rows, codes = stamps[:taken], rows[:taken], codes[:taken]
        good = codes == stream.ESTIMATE
        self._remember(stamps[good], rows[good], stamps_s[:n], smoothed[:n])
        if taken and codes[-1] in (stream.ESTIMATE, stream.START):
            self._after(int(stamps[-1]))
        return taken, stamps[good], rows[good], stamps_s[:n], smoothed[:n], codes

    def _run(self, stamps, u, y, codes, rows, stamps_s, smoothed):
        return stream.run(
            stamps, u, y, *self._kind, self._packed, self._settings, self._gate, self.counts,
            self._clock, self._efforts, self._z, self._P, self._memory, self._ring,
            self._ring_stamps, self._vectors, self._matrices, codes, rows, stamps_s, smoothed)

    # ------------------------------------------------------------------ evaluation

    def _remember(self, stamps, rows, stamps_s, smoothed):
        at = (self._held + np.arange(len(stamps))) % HISTORY
        self._history[at], self._history_stamps[at] = rows, stamps
        self._held += len(stamps)
        if len(stamps_s):
            self._drift.append(
                (stamps_s, smoothed[:, [S_TWIST, S_TAU_K, S_TAU_K_STD, S_TWIST_STD]]))

    def _after(self, stamp_ns):
        """Judge when a second of accepted stamps has passed."""
        at = self._gate[stream.EVALUATE_AT]
        if at and at - SECOND <= stamp_ns < at:
            return
        self._gate[stream.EVALUATE_AT] = stamp_ns + SECOND
        if at and stamp_ns >= at:
            self._evaluate(stamp_ns)

    def _recent(self, stamp_ns, seconds):
        """Return (stamps, rows) of the newest estimates within `seconds` before `stamp_ns`."""
        held = min(self._held, HISTORY)
        at = np.arange(self._held - held, self._held) % HISTORY
        stamps = self._history_stamps[at]
        keep = (stamps > stamp_ns - round(seconds * SECOND)) & (stamps <= stamp_ns)
        return stamps[keep], self._history[at[keep]]

    def _evaluate(self, stamp_ns):
        stamps, rows = self._recent(stamp_ns, innovation.WINDOW)
        found = {'input': self._check_input(stamps, stamp_ns)}
        settled = stamps >= self._gate[stream.STARTED] + round(SETTLE * SECOND)
        if settled.any() and stamp_ns - self._gate[stream.STARTED] >= (SETTLE + 1.0) * SECOND:
            stamps, rows = stamps[settled], rows[settled]
            found['observability'] = self._check_observability(stamps, rows)
            recent = int((stamps > stamp_ns - round(innovation.MEAN_WINDOW * SECOND)).sum())
            found['prediction error'] = innovation.check(
                rows[:, [stream.E_WHITE_1, stream.E_WHITE_2]], rows[:, stream.E_NIS],
                rows[:, stream.E_DOF], recent)
            found['covariance'] = self._check_covariance(rows)
        backlash = self._check_backlash(stamp_ns)
        if backlash is not None:
            found['backlash'] = backlash
        self.findings = dict(self.findings)
        for name, finding in found.items():
            alarm = self._alarms[name]
            level = alarm.update(finding.level, stamp_ns)
            message = finding.message
            lasted = alarm.lasted(stamp_ns)
            if level > Level.OK and lasted > 0.0:
                message += f' (for {lasted:.1f} s)'
            self.findings[name] = Finding(level, message, finding.values)

    def _check_input(self, stamps, stamp_ns):
        new = self.counts - self._last_counts
        self._last_counts = self.counts.copy()
        values = {text: int(self.counts[code]) for code, text in stream.REASONS.items()}
        values['samples'] = self.input_count
        within = stamps > stamp_ns - SECOND
        values['rate_hz'] = float(within.sum())
        values['longest_gap_s'] = (
            float(np.diff(stamps[within]).max() * 1e-9) if within.sum() > 1 else 0.0)
        seen = [f'{new[code]} {text}' for code, text in stream.REASONS.items()
                if new[code] and code != stream.START]
        if not new[stream.ESTIMATE]:
            return Finding(Level.ERROR, 'no usable sample in the last second: ' +
                           (', '.join(seen) or 'none came') + self._advice(new), values)
        if seen:
            return Finding(Level.WARN, 'in the last second: ' + ', '.join(seen) +
                           self._advice(new), values)
        return Finding(Level.OK, f'{values["rate_hz"]:.0f} samples/s', values)

    def _advice(self, new):
        if new[stream.NO_EFFORT] or new[stream.EFFORT_HELD]:
            return '; publish effort of the motor joint with every position'
        if new[stream.ZERO_STAMP] or new[stream.DUPLICATE] or new[stream.BACKWARD]:
            return '; stamp each message with the time of its measurement, from one publisher'
        if new[stream.MOTOR_MISSING] or new[stream.ARM_MISSING]:
            return '; check the encoders and the joint names'
        return ''

    def _check_observability(self, stamps, rows):
        take = stamps > stamps[-1] - round(observability.WINDOW * SECOND)
        rows = rows[take]
        columns = [{'tau_arm': stream.E_TAU_ARM, 'tau_e': stream.E_TAU_E}.get(name, i)
                   for i, name in enumerate(self.names)]
        inputs = rows[:, [stream.E_U, stream.E_LOAD]]
        seen = np.isfinite(rows[:, [stream.E_INNOVATION_MOTOR, stream.E_INNOVATION_ARM]])
        packed = self._packed
        if self.adapted():
            packed = FILTERS[self.parameters['filter']].in_use(self._memory, packed)
        share = observability.information_share(
            rows[:, columns], inputs, rows[:, stream.E_DT], seen, packed)
        eps6 = observability.condition(rows[-1, columns], inputs[-1], seen[-1], packed)
        return observability.check(float(share[TAU_K]), float(share[X3]), eps6)

    def _check_covariance(self, rows):
        std = float(np.median(rows[:, stream.E_STD + TAU_K]))
        if self._reference is None:
            self._references.append(std)
            if len(self._references) >= REFERENCE_EVALUATIONS:
                self._reference = float(np.median(self._references))
        return self._with_adaptation(covariance.check(std, self._reference))

    def _with_adaptation(self, finding):
        """Return `finding` with the adapted values; a warning where one is at its bound."""
        adapted = self.adapted()
        if not adapted:
            return finding
        values = {**finding.values, **{f'adapted_{k}': v for k, v in adapted.items()},
                  **{f'adaptation_{k}': v for k, v in self.adaptation_guards().items()}}
        bound = FILTERS[self.parameters['filter']].at_bound(self._memory, self._packed)
        if bound and finding.level == Level.OK:
            return Finding(Level.WARN, f'adapted to its bound: {", ".join(bound)}: the model or '
                           'a start value is far off', values)
        return replace(finding, values=values)

    def _check_backlash(self, stamp_ns):
        """Return a Finding when a window has ended, else None."""
        if not self._drift:
            return None
        if self._drift_start is None:
            self._drift_start = int(self._drift[0][0][0])
        end = int(self._drift[-1][0][-1])
        window = round(self.parameters['drift_window'] * SECOND)
        if 0 <= end - self._drift_start < window:
            return None
        smoothed = np.concatenate([chunk[1] for chunk in self._drift])
        self._drift, self._drift_start = [], None
        # A twist known worse than by one reading of both encoders: one of them was missing.
        p = self.parameters
        smoothed = smoothed[smoothed[:, 3] <= np.hypot(p['r_std_motor'], p['r_std_arm'])]
        now = features.fit(smoothed[:, 0], smoothed[:, 1], stamp_ns, smoothed[:, 2])
        if now is not None:
            self.windows.append(now)
            if self.baseline is None and len(self.windows) == change.BASELINE_WINDOWS:
                self.baseline = change.baseline_of(self.windows)
            return change.check(now, self.baseline, p['gap_warn'], p['gap_error'])
        # A pause is no news about the gap: what was measured last stands.
        last = self.windows[-1] if self.windows else None
        found = change.check(last, self.baseline, p['gap_warn'], p['gap_error'])
        if last is None:
            return found
        return replace(found, message='not excited now; measured last: ' + found.message)
