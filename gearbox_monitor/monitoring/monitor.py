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
from dataclasses import dataclass, replace
import json
import math

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.filter_registry import FILTERS
from gearbox_monitor.estimation.process_model import markers, P0, pack, state_names, TAU_K, X2, X4
from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_TWIST, S_TWIST_RATE, S_TWIST_RATE_STD, S_TWIST_STD, S_X2, S_X4)
from gearbox_monitor.estimation.step_record import predicted, record_size
from gearbox_monitor.monitoring.backlash import change, features
from gearbox_monitor.monitoring.backlash.shared import Known
from gearbox_monitor.monitoring.checks import (
    covariance, innovation, model_mismatch, observability, passivity, usability)
from gearbox_monitor.monitoring.checks.level import (
    Alarm, Condition, DEBOUNCE, Finding, finding_of, Level, with_more)
from gearbox_monitor.monitoring.history import History
from gearbox_monitor.parameters import AT_ONCE, ESTIMATOR, resolve, with_model_values
from gearbox_monitor.plant.drive import loads_arm, model_from_dict
from gearbox_monitor.plant.effects import not_in_filters

RING = 2048
HISTORY = 8192
SECOND = sample_loop.SECOND
SETTLE = 2.0  # s after a start that are not judged
COMPONENTS = ('observability', 'prediction error', 'covariance', 'model', 'backlash', 'friction',
              'input')

REASON_CODES = np.array(list(sample_loop.REASONS))
STATE_COLUMNS = {'tau_arm': sample_loop.E_TAU_ARM, 'tau_e': sample_loop.E_TAU_E}
MEDIAN_STRIDE = 8
# Columns that mean nothing where no arm is measured.
OF_ARM = [sample_loop.E_X2, sample_loop.E_X4, sample_loop.E_TWIST, sample_loop.E_TWIST_RATE,
          sample_loop.E_TWIST_STD, sample_loop.E_TWIST_RATE_STD,
          sample_loop.E_STD + X2, sample_loop.E_STD + X4]
SMOOTHED_OF_ARM = [S_TWIST, S_TWIST_RATE, S_TWIST_STD, S_TWIST_RATE_STD, S_X2, S_X4]
NOT_WATCHED = Finding(Level.OK, 'not watched: no arm is measured (arm_joint is empty)')
NO_DATA = Finding(Level.WARN, 'no data yet')
ANEW = Finding(Level.WARN, 'not judged: the filter has started anew, or samples, torque or '
               f'positions were missing, less than {SETTLE + 1.0:g} s ago')
NOTHING = Finding(Level.WARN, 'no estimates')
JUDGED = COMPONENTS[:4]  # once per second, from the newest estimates
# Samples that stand in time: an evaluation may be due with them.
IN_TIME = (sample_loop.ESTIMATE, sample_loop.START, sample_loop.NO_EFFORT,
           sample_loop.NO_MEASUREMENT)
AT_BOUND = Condition(
    'covariance', Level.WARN, 'adapted to its bound', 'an adapted parameter is at its bound (AEKF '
    'only)', 'the evaluation', 'the model or a start value is far off: check it', ('adapted_...',))
CONDITIONS = (
    *usability.CONDITIONS, *observability.CONDITIONS, *innovation.CONDITIONS,
    *passivity.CONDITIONS, *covariance.CONDITIONS, AT_BOUND, *model_mismatch.CONDITIONS)


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
    M estimates: stamp_ns int64 [M], rows [M, sample_loop.N_ESTIMATE] (columns sample_loop.E_*).

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


COLUMNS = {name[2:].lower(): value for name, value in vars(sample_loop).items()
           if name.startswith('E_') and name != 'E_STD'}
COLUMNS.update({f'{name}_std': sample_loop.E_STD + i for i, name in enumerate(
    ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_arm', 'tau_e'))})


@dataclass(frozen=True)
class Estimate:
    """
    What one accepted sample gave.

    x [n] state (see process_model) and P [n, n]; row: all columns (sample_loop.E_*), also by name:
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
        return self.row[[sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_ARM]]

    @property
    def S(self):
        """Covariance of the innovation, [2, 2] rad^2."""
        motor, arm, both = self.row[[sample_loop.E_INNOVATION_STD_MOTOR,
                                     sample_loop.E_INNOVATION_STD_ARM,
                                     sample_loop.E_INNOVATION_COVARIANCE]]
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


@dataclass(frozen=True)
class Divergence:
    """
    A failure of the filter, which then starts anew.

    step: since the (re)start; smallest_eigenvalue: of the covariance, NaN where it is not finite.
    """

    step: int
    stamp_ns: int
    reason: str
    smallest_eigenvalue: float

    def __str__(self):
        return (f'the filter diverged at step {self.step}, stamp {self.stamp_ns * 1e-9:.9f} s: '
                f'{self.reason} (smallest eigenvalue {self.smallest_eigenvalue:.3g})')


def _drive_of(model, p):
    """Return the DriveModel that a filter with the parameters `p` computes with."""
    if p.arm_joint:
        return model.with_(arm_load=model.arm_load if p.arm_load == 'model' else p.arm_load)
    if p.tau_k_stiffness > 0.0:
        raise InputError(f'tau_k_stiffness: {p.tau_k_stiffness:g}, expected 0 where no arm is '
                         'measured (arm_joint is empty)')
    return model.without_arm()


def _known_of(snapshot):
    """Return the Known in a `snapshot`; older ones have none."""
    return Known(json.loads(snapshot['known']) if 'known' in snapshot else None)


def _where(good):
    """Return what chooses the rows `good` (bool [N]): a slice, which copies nothing, or `good`."""
    chosen = np.flatnonzero(good)
    if not len(chosen) or chosen[-1] - chosen[0] + 1 == len(chosen):
        return slice(chosen[0], chosen[-1] + 1) if len(chosen) else slice(0)
    return good


class Monitor:
    """
    Filter, trust and drift of one gearbox.

    model: DriveModel. parameters: EstimatorParameters, or a mapping with some of their names (the
    rest take their defaults) and of parameters.MODEL, which replace values of the model. drift:
    state or baselines of a change.Tracker, or None (then the first windows are healthy).
    temperature: of the gearbox now (deg C), None = not known. judged: whether trust and drift are
    evaluated; smoothed: whether the smoother runs, which drift needs. Without them the same
    estimates come in a fraction of the time.
    Raises InputError for a parameter that is unknown or out of range; what Tracker raises.
    """

    def __init__(self, model, parameters=None, drift=None, judged=True, smoothed=True):
        self.model, self.parameters = resolve(model, parameters)
        self._judged, self._smoothed = judged, smoothed
        self.divergences = deque(maxlen=100)  # newest last
        self.counts = np.zeros(sample_loop.N_COUNTS, np.int64)
        self.findings = dict.fromkeys(COMPONENTS, NO_DATA)
        self.windows = deque(maxlen=1000)  # Backlash of each window, newest last
        self.tracker = change.Tracker(change.Settings.of(self.parameters, self.model), drift)
        if self.tracker.stamp_ns:
            self.findings.update(self.tracker.findings())
        self.temperature = None
        self._gate = np.zeros(sample_loop.N_GATE, np.int64)
        self._given_reference = None
        self._setup()

    # ------------------------------------------------------------------ set-up and state

    def _setup(self):
        p = self.parameters
        if self.model.transmission.kind == 'rigid':
            raise InputError('transmission.kind: rigid: a filter has no twist to see the '
                             'transmission torque by, expected another kind')
        self.drive = _drive_of(self.model, p)
        self.names = state_names(self.drive, p)
        self._packed = pack(self.drive, p)
        self._kind = sample_loop.KINDS[p.filter]
        self.settings = np.array([
            round(p.max_gap * SECOND), p.effort_delay,
            round(p.smoother_lag * SECOND) if self._smoothed else 0,
            self.drive.arm_load == 'measured'], np.int64)
        n, module = len(self.names), FILTERS[p.filter]
        self.states = markers(self._packed, n)
        self.warnings = module.warnings(n, p) if hasattr(module, 'warnings') else []
        ignored = not_in_filters(self.drive.effects)
        if ignored:
            self.warnings = [*self.warnings, f'effects of the model that no filter knows are left '
                             f'out: {", ".join(ignored)}']
        loads = [e['id'] for e in self.drive.effects if loads_arm(e['id'])]
        if loads and self.drive.arm_load == 'measured':
            self.warnings = [*self.warnings, f'effects of the model act besides the measured load '
                             f'on the arm: {", ".join(loads)}; leave out what it contains']
        self._z, self._P = np.zeros(n), np.eye(n).ravel()
        self._memory = np.zeros(module.memory_size(n))
        self._kept = np.zeros(n + n * n + len(self._memory))
        self._clock = np.zeros(sample_loop.N_CLOCK)
        self._efforts = np.zeros((sample_loop.N_EFFORTS, 2))
        rows = RING if self.settings[sample_loop.LAG] else 2  # few stay in the processor's cache
        self._ring, self._ring_stamps = np.zeros((rows, record_size(n))), np.zeros(rows, np.int64)
        self._vectors = np.zeros((module.N_VECTORS, n))
        self._matrices = np.zeros((max(module.N_MATRICES, 5), n * n))
        self._one = (np.zeros(1, np.int64), np.zeros((1, 2)), np.zeros((1, 2)))
        self._codes_one = np.zeros(1, np.int64)
        self._row_one = np.zeros((1, sample_loop.N_ESTIMATE))
        self._smoothed_one = (np.zeros(RING + 1, np.int64), np.zeros((RING + 1, N_SMOOTHED)))
        self._gate[:sample_loop.INPUTS] = 0
        self._forget()

    def _forget(self):
        """Drop all windows: what they hold belongs to another belief."""
        self._history = History(HISTORY)
        self._smoothed_rows = deque()  # chunks (stamps, smoothed rows) of the last seconds
        self._begin_window()
        self._known = Known()  # what the windows have in common
        self._gate[sample_loop.EVALUATE_AT] = 0 if self._judged else sample_loop.NEVER
        self._reference, self._references = self._given_reference, []
        self._systematic = model_mismatch.Systematic()
        self.findings = {**self.findings, **dict.fromkeys((*JUDGED, 'input'), NO_DATA)}
        self._alarms = {name: Alarm(*debounce) for name, debounce in DEBOUNCE.items()}
        self._last_counts = self.counts.copy()

    def _begin_window(self):
        self._smoothed_rows.clear()
        self._drift = []  # chunks (stamps, smoothed rows) of the window under way
        self._window_start = None  # stamp of the first smoothed row of the window under way
        self._window_whole = True  # whether its rows are at hand from there on
        self._window_flagged = 0  # evaluations in it that an indicator of trust flagged

    def _not_judged(self, finding):
        """Say that what was found good says nothing of the estimates that come now."""
        self.findings = {name: finding if name in JUDGED and found.level == Level.OK else found
                         for name, found in self.findings.items()}
        for name in JUDGED:
            self._alarms[name].doubt()

    def reset(self):
        """Start anew with the next sample; counters and baseline stay."""
        self._setup()

    def set_parameters(self, changes):
        """
        Change parameters while running; Q, R and thresholds keep the belief, others restart.

        changes: {name: value} of parameters.ESTIMATOR and MODEL. Returns whether the filter starts
        anew. Raises InputError, leaving everything as it was.
        """
        rows = {row.name: row for row in ESTIMATOR}
        model, changes = with_model_values(self.model, changes)
        new = self.parameters.replace(**changes)
        # Raises before anything has changed.
        pack(_drive_of(model, new), new)
        restart = model != self.model or any(
            rows[name].change != AT_ONCE for name in changes
            if getattr(new, name) != getattr(self.parameters, name))
        self.model, self.parameters = model, new
        self.tracker.settings = change.Settings.of(new, model)
        if restart:
            self._given_reference = None
            self._setup()
            return True
        z, P, clock, efforts, gate = (
            self._z, self._P, self._clock, self._efforts, self._gate.copy())
        packed, memory = self._packed, self._memory
        self._setup()
        self._z, self._P, self._clock, self._efforts = z, P, clock, efforts
        if np.array_equal(packed, self._packed):  # nothing that the filter computes with
            self._memory = memory
        else:
            self._given_reference = self._reference = None
        self._gate[:] = gate
        self._gate[sample_loop.EVALUATE_AT] = 0 if self._judged else sample_loop.NEVER
        self._keep_belief_only()
        return False

    def _keep_belief_only(self):
        """Let the smoother begin at the present step: older records are not at hand."""
        step = self._gate[sample_loop.STEPS]
        n = len(self.names)
        start = n + 2 * n * n
        place = step % len(self._ring)
        row = self._ring[place]
        row[start:start + n] = self._z
        row[start + n:start + n + n * n] = self._P
        acting = (step - 1 - self.parameters.effort_delay) % sample_loop.N_EFFORTS
        row[-1] = self._efforts[acting, 0]
        self._ring_stamps[place] = self._gate[sample_loop.LAST]
        self._gate[sample_loop.SMOOTH_NEXT] = step

    def snapshot(self):
        """
        Return everything that the next estimates depend on, as {name: text}.

        Numbers are written so that they read back bit for bit; see restore.
        """
        def numbers(a):
            return json.dumps([float(v).hex() for v in np.ravel(a)])

        return {
            'model': json.dumps(self.model.to_dict()),
            'parameters': json.dumps(self.parameters.to_dict()),
            'drift': json.dumps(self.tracker.to_dict()),
            'temperature': json.dumps(self.temperature),
            'window_start': json.dumps(self._window_start),
            'known': json.dumps(self._known.to_list()),
            'stamp_ns': str(self._gate[sample_loop.LAST]),
            'input_count': str(self._gate[sample_loop.INPUTS]),
            'gate': json.dumps([int(v) for v in self._gate[:sample_loop.EVALUATE_AT]]),
            'counts': json.dumps([int(v) for v in self.counts]),
            'z': numbers(self._z), 'P': numbers(self._P), 'memory': numbers(self._memory),
            'clock': numbers(self._clock), 'efforts': numbers(self._efforts)}

    @classmethod
    def restore(cls, snapshot, source='snapshot', judged=True, smoothed=True):
        """Return the Monitor that went on from `snapshot` of `source`. Raises InputError."""
        def numbers(name, like):
            values = [float.fromhex(v) for v in json.loads(snapshot[name])]
            return np.array(values).reshape(like.shape)

        def integers(name, count):
            values = json.loads(snapshot[name])
            if len(values) != count or any(type(value) is not int for value in values):
                raise ValueError(f'{name}: {str(values)[:60]}, expected {count} whole numbers')
            return values

        try:
            monitor = cls(model_from_dict(json.loads(snapshot['model']), source),
                          json.loads(snapshot['parameters']), json.loads(snapshot['drift']),
                          judged, smoothed)
            monitor.temperature = json.loads(snapshot['temperature'])
            monitor._window_start = json.loads(snapshot['window_start'])
            monitor._window_whole = monitor._window_start is None
            monitor._known = _known_of(snapshot)
            monitor._gate[:sample_loop.EVALUATE_AT] = integers('gate', sample_loop.EVALUATE_AT)
            monitor._gate[sample_loop.INPUTS] = int(snapshot['input_count'])
            monitor.counts[:] = integers('counts', sample_loop.N_COUNTS)
            monitor._z = numbers('z', monitor._z)
            monitor._P = numbers('P', monitor._P)
            monitor._memory = numbers('memory', monitor._memory)
            monitor._clock = numbers('clock', monitor._clock)
            monitor._efforts = numbers('efforts', monitor._efforts)
        except (KeyError, ValueError, TypeError, AttributeError, OverflowError, IndexError,
                RecursionError) as error:
            if isinstance(error, InputError):
                raise
            raise SnapshotError(f'{source}: not a snapshot of this version ({error})') from None
        monitor._last_counts = monitor.counts.copy()
        monitor._keep_belief_only()
        return monitor

    def adopt_baseline(self, snapshot):
        """
        Take over baselines, drift state and temperature of a `snapshot` of where this stands.

        A baseline may have been saved meanwhile, and the temperature is no sample. What windows
        have in common comes with them: one that was cut at the start is missing here.
        """
        if 'known' in snapshot:
            self._known = _known_of(snapshot)
        self.tracker = change.Tracker(self.tracker.settings, json.loads(snapshot['drift']))
        self.temperature = json.loads(snapshot['temperature'])
        if self.tracker.stamp_ns:
            self.findings = {**self.findings, **self.tracker.findings()}

    @property
    def baseline(self):
        """The change.Baseline of the operating point of the newest window, or None."""
        return self.tracker.baseline

    def divergence_notes(self):
        """Return what to tell about divergences: list of str."""
        count = int(self.counts[sample_loop.DIVERGED])
        if not count:
            return []
        if not self.divergences:
            return [f'{count} divergences before the snapshot that this started from']
        first = str(self.divergences[0])
        return [first if count == 1 else f'{first}; {count} divergences in all']

    def adapted(self):
        """Return {parameter: value in use} of what the filter adapts, in the parameter's unit."""
        module = FILTERS[self.parameters.filter]
        return module.adapted(self._memory, self._packed) if hasattr(module, 'adapted') else {}

    def learnt(self):
        """Return what the filter has adapted, to be kept in a file; {} where nothing is."""
        module = FILTERS[self.parameters.filter]
        return module.learnt(self._memory, self._packed) if hasattr(module, 'learnt') else {}

    def recall(self, kept):
        """
        Go on from what learnt() has `kept`, until a parameter changes or reset().

        Returns False where it is of another filter or began from other parameters; then nothing
        has changed. Raises InputError where it is no such thing.
        """
        module = FILTERS[self.parameters.filter]
        try:
            return hasattr(module, 'recall') and module.recall(self._memory, self._packed, kept)
        except ValueError as error:
            raise InputError(str(error)) from None

    def adaptation_guards(self):
        """Return {guard of the adaptation: how often it acted since the start}."""
        module = FILTERS[self.parameters.filter]
        return module.guards(self._memory) if self.adapted() else {}

    @property
    def stamp_ns(self):
        """Stamp of the last accepted sample, 0 before the first."""
        return int(self._gate[sample_loop.LAST])

    @property
    def input_count(self):
        """How many samples came in, refused ones included."""
        return int(self._gate[sample_loop.INPUTS])

    @property
    def period(self):
        """The usual distance of stamps (s), 0 before it is known."""
        return float(self._clock[sample_loop.PERIOD])

    # ------------------------------------------------------------------ samples

    def step(self, sample):
        """Take one Sample; return its Estimate, or None where it was refused or is the first."""
        stamps, u, y = self._one
        stamps[0] = sample.stamp_ns
        u[0], y[0] = sample.u, sample.y
        stamps_s, smoothed = self._smoothed_one
        _, n = self._run(stamps, u, y, self._codes_one, self._row_one, stamps_s, smoothed)
        due = tuple((int(stamps_s[i]), smoothed[i].copy()) for i in range(n))
        code = self._codes_one[0]
        good = self._codes_one == sample_loop.ESTIMATE
        self._remember(stamps[good], self._row_one[good], stamps_s[:n].copy(),
                       smoothed[:n].copy())
        self._after(int(sample.stamp_ns), code)
        if not good[0]:
            return None
        P, row = self._P.reshape(len(self._z), -1).copy(), self._row_one[0].copy()
        if not self.parameters.arm_joint:
            row[OF_ARM] = np.nan
            for _, values in due:
                values[SMOOTHED_OF_ARM] = np.nan
        return Estimate(int(sample.stamp_ns), self._z.copy(), P, row, due, self.findings)

    def run(self, samples):
        """Take Samples (N of them); return their Estimates. Same bits as step by step."""
        stamps = np.ascontiguousarray(samples.stamp_ns, np.int64)
        u = np.ascontiguousarray(samples.u, float)
        y = np.ascontiguousarray(samples.y, float)
        n, start, due = len(stamps), 0, 0
        room = n + RING if self.settings[sample_loop.LAG] else 0
        codes, rows = np.empty(n, np.int64), np.empty((n, sample_loop.N_ESTIMATE))
        stamps_s, smoothed = np.empty(room, np.int64), np.empty((room, N_SMOOTHED))
        while start < n:
            end = start + HISTORY // 2
            taken, more = self._run(stamps[start:end], u[start:end], y[start:end],
                                    codes[start:end], rows[start:end], stamps_s[due:],
                                    smoothed[due:])
            end = start + taken
            if self._judged:
                good = _where(codes[start:end] == sample_loop.ESTIMATE)
                self._remember(stamps[start:end][good], rows[start:end][good],
                               stamps_s[due:due + more].copy(), smoothed[due:due + more].copy())
                self._after(int(stamps[end - 1]), codes[end - 1])
            start, due = end, due + more
        good = _where(codes == sample_loop.ESTIMATE)
        rows, smoothed = rows[good], smoothed[:due]
        if not self.parameters.arm_joint:
            rows[:, OF_ARM] = smoothed[:, SMOOTHED_OF_ARM] = np.nan
        return Estimates(stamps[good], rows, stamps_s[:due], smoothed, codes)

    def _run(self, stamps, u, y, codes, rows, stamps_s, smoothed):
        taken, n = sample_loop.run(
            self.states, stamps, u, y, *self._kind, self._packed, self.settings,
            self._gate, self.counts, self._clock, self._efforts, self._z, self._P, self._memory,
            self._kept, self._ring, self._ring_stamps, self._vectors, self._matrices, codes, rows,
            stamps_s, smoothed)
        if taken and codes[taken - 1] == sample_loop.DIVERGED:
            self.divergences.append(self._divergence(int(stamps[taken - 1])))
        return taken, n

    def _divergence(self, stamp_ns):
        """Return why the filter failed at the sample that came last."""
        n, step = len(self.names), int(self._gate[sample_loop.STEPS])
        _, predicted_P, _ = predicted(self._ring[step % len(self._ring)], n)
        reason, smallest = 'state or covariance is not finite', np.nan
        if np.isfinite(self._z).all() and np.isfinite(self._P).all():
            smallest = float(np.linalg.eigvalsh(self._P.reshape(n, n)).min())
            reason = 'the covariance is not positive definite'
            if smallest > 0.0:
                reason = 'the innovation is not finite or its covariance not positive'
                if np.isfinite(predicted_P).all():
                    smallest = float(np.linalg.eigvalsh(predicted_P).min())
        return Divergence(step, stamp_ns, reason, smallest)

    # ------------------------------------------------------------------ evaluation

    def _remember(self, stamps, rows, stamps_s, smoothed):
        self._history.add(stamps, rows)
        if len(stamps_s):
            self._drift.append((stamps_s, smoothed))
            self._smoothed_rows.append((stamps_s, smoothed))
            first = stamps_s[-1] - round(passivity.WINDOW * SECOND)
            while self._smoothed_rows[0][0][-1] <= first:
                self._smoothed_rows.popleft()

    def _after(self, stamp_ns, code):
        """Judge when a second of stamps has passed; `code`: what became of the newest sample."""
        if code == sample_loop.START:
            self._begin_window()  # positions may count from elsewhere now
        if code not in IN_TIME:
            return
        if self._gate[sample_loop.STARTED] == stamp_ns:
            self._not_judged(ANEW)
        at = self._gate[sample_loop.EVALUATE_AT]
        if at == sample_loop.NEVER or at and at - SECOND <= stamp_ns < at:
            return
        self._gate[sample_loop.EVALUATE_AT] = stamp_ns + SECOND
        if at and stamp_ns >= at:
            self._evaluate(stamp_ns)

    def _evaluate(self, stamp_ns):
        settled = self._gate[sample_loop.STARTED] + round(SETTLE * SECOND)
        recent = self._history.recent(stamp_ns - round(innovation.WINDOW * SECOND), stamp_ns)
        found = {'input': self._check_input(recent.stamps, stamp_ns)}
        if stamp_ns - settled >= SECOND:
            recent = recent.after(settled - 1)
            if len(recent):
                found['observability'] = self._check_observability(recent)
                found['prediction error'] = self._check_prediction_error(recent, stamp_ns)
                found['covariance'] = self._check_covariance(recent)
                found['model'] = self._check_model(found, stamp_ns)
            else:
                self._not_judged(NOTHING)
        found.update(self._check_backlash(found))
        self.findings = dict(self.findings)
        for name, finding in found.items():
            self.findings[name] = self._alarms[name].judge(finding, stamp_ns)

    def _check_input(self, stamps, stamp_ns):
        new = self.counts - self._last_counts
        self._last_counts = self.counts.copy()
        if not self.parameters.arm_joint:
            new[sample_loop.ARM_MISSING] = 0
        within = stamps[np.searchsorted(stamps, stamp_ns - SECOND, 'right'):]
        values = {
            **dict(zip(map(usability.key_of, sample_loop.REASONS.values()),
                       self.counts[REASON_CODES].tolist())),
            'samples': self.input_count, 'rate_hz': float(len(within)),
            'longest_gap_s': float(np.diff(within).max() * 1e-9) if len(within) > 1 else 0.0}
        return usability.check(dict(zip(sample_loop.REASONS.values(), new[REASON_CODES].tolist())),
                               int(new[sample_loop.ESTIMATE]), values)

    def _check_observability(self, recent):
        recent = recent.after(recent.stamps[-1] - round(observability.WINDOW * SECOND))
        columns = [STATE_COLUMNS.get(name, i) for i, name in enumerate(self.names)]
        seen = np.isfinite(recent.pair(sample_loop.E_INNOVATION_MOTOR))
        packed = self._packed
        if self.adapted():
            packed = FILTERS[self.parameters.filter].in_use(self._memory, packed)
        states = np.ascontiguousarray(recent.stack(columns))
        shares = observability.information_share(
            states, recent[sample_loop.E_DT], np.ascontiguousarray(seen), packed)
        stated = float(np.median(recent[sample_loop.E_STD + TAU_K])) / math.sqrt(
            packed[P0 + TAU_K])
        return observability.check(dict(zip(self.names, shares.tolist())), stated,
                                   observability.paper(states[-1], seen[-1], packed))

    def _check_prediction_error(self, recent, stamp_ns):
        for_mean, newest = (len(recent.after(stamp_ns - round(window * SECOND)))
                            for window in (innovation.MEAN_WINDOW, innovation.GATE_WINDOW))
        white, errors, stds = (recent.pair(column) for column in (
            sample_loop.E_WHITE_1, sample_loop.E_INNOVATION_MOTOR,
            sample_loop.E_INNOVATION_STD_MOTOR))
        found = innovation.check(white, recent[sample_loop.E_NIS], recent[sample_loop.E_DOF],
                                 errors, stds, for_mean, newest)
        if not self._smoothed_rows:
            return found
        broken, values = passivity.check(np.concatenate([rows for _, rows in self._smoothed_rows]))
        if not broken:
            return replace(found, values={**found.values, **values})
        return with_more(found, broken, values)

    def _check_covariance(self, recent):
        stds = np.sort(recent[sample_loop.E_STD + TAU_K][::MEDIAN_STRIDE])  # slow: few will do
        std = float(stds[len(stds) // 2])
        if self._reference is None:
            self._references.append(std)
            if len(self._references) >= covariance.REFERENCE_EVALUATIONS:
                self._reference = float(np.median(self._references))
        return self._with_adaptation(covariance.check(std, self._reference))

    @property
    def tau_k_std_reference(self):
        """
        Healthy median of the stated standard deviation of tau_K (N m), None before it is known.

        Taken from the first evaluations; or set it (to one kept in a file), then it outlasts
        restarts, until a parameter changes that the filter computes with.
        """
        return self._reference

    @tau_k_std_reference.setter
    def tau_k_std_reference(self, value):
        self._given_reference = self._reference = value

    def _with_adaptation(self, finding):
        """Return `finding` with the adapted values; a warning where one is at its bound."""
        adapted = self.adapted()
        if not adapted:
            return finding
        values = {**finding.values, **{f'adapted_{k}': v for k, v in adapted.items()},
                  **{f'adaptation_{k}': v for k, v in self.adaptation_guards().items()}}
        bound = FILTERS[self.parameters.filter].at_bound(self._memory, self._packed)
        if bound and finding.level == Level.OK:
            return finding_of(
                [replace(AT_BOUND, says=f'adapted to its bound: {", ".join(bound)}')], '', values)
        return replace(finding, values=values)

    def _check_model(self, found, stamp_ns):
        # What a lost encoder or a broken stream does to the errors says nothing about the model.
        judged = (found['observability'].level < Level.ERROR
                  and found['input'].level < Level.ERROR)
        systematic = judged and innovation.systematic(found['prediction error'].values)
        self._systematic.add(stamp_ns, systematic)
        return model_mismatch.check(self._systematic, stamp_ns, self.parameters.model_gap_after,
                                    self.drive.arm_load == 'unknown')

    def _check_backlash(self, found):
        """Return {component: Finding} when a window has ended, else nothing."""
        if not self.parameters.arm_joint:
            self._drift = []
            return dict.fromkeys(COMPONENTS[4:6], NOT_WATCHED)
        if any(finding.level > Level.OK for name, finding in found.items() if name != 'model'):
            self._window_flagged += 1
        if not self._drift:
            return {}
        if self._window_start is None:
            self._window_start = int(self._drift[0][0][0])
        length = round(self.parameters.drift_window * SECOND)
        result, newest = {}, int(self._drift[-1][0][-1])
        while newest >= self._window_start + length:
            end = self._window_start + length
            stamps, rows = (np.concatenate(column) for column in zip(*self._drift))
            inside = (stamps >= self._window_start) & (stamps < end)
            if self._window_whole:
                result = self._window_ended(rows[inside], end)
            later = stamps >= end
            self._drift = [(stamps[later], rows[later])]
            # Windows without any row are left out.
            self._window_start += int((stamps[later][0] - self._window_start) // length) * length
            self._window_whole, self._window_flagged = True, 0
        return result

    def _window_ended(self, rows, end):
        p = self.parameters
        # A twist known worse than by one reading of both encoders: one of them was missing.
        known = rows[rows[:, S_TWIST_STD] <= np.hypot(p.r_std_motor, p.r_std_arm)]
        now = features.fit(known, self.drive, end)
        if isinstance(now, features.Backlash):
            now = self._known.refine(now)
            self.windows.append(now)
        return self.tracker.update(now, self._trusted(), self.temperature)

    def _trusted(self):
        """Return whether the window that ends now may be learnt from."""
        # A level takes some evaluations to rise, and single flags are chance.
        return self._window_flagged <= 2 and not any(
            self._alarms[name].since_ns is not None and self.findings[name].level > Level.OK
            for name in (*COMPONENTS[:3], 'input'))
