# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Snapshots: the state of a filter as text, from which it goes on bit for bit."""
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import json
import math
import struct
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import model_bank, sample_loop
from gearbox_monitor.estimation.consider import torque_errors_at_tolerance
from gearbox_monitor.estimation.estimates import (
    ARM_COLUMNS, Batch, checked, Divergence, Estimate, Estimates, Sample, Samples,
    SMOOTHED_ARM_COLUMNS)
from gearbox_monitor.estimation.filter_kind import (
    filter_kind, predicted, sensitivities, updated)
from gearbox_monitor.estimation.filter_setup import (
    arm_load_of, COMPENSATED, described, drive_of, expect_effort, loop_arrays, model_warnings,
    settings_of)
from gearbox_monitor.estimation.process_model import (
    EIGENVALUE, layout_of, learned_length, LEARNT, pack, Q0, state_names, TAU_ARM, TAU_K)
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED
from gearbox_monitor.estimation.sample_loop import DescribedLoad, Output, part_of, SECOND, Stream
from gearbox_monitor.kernels.kernel import Repeated
from gearbox_monitor.kernels.types import AnyArray, Array, Integers, Values
from gearbox_monitor.parameters import (
    AT_ONCE, ESTIMATOR, EstimatorParameters, PAYLOAD, resolve, values_of, with_model_values)
from gearbox_monitor.plain_data import classes_of, from_data, to_data
from gearbox_monitor.plant.drive import DriveModel, model_from_dict
from gearbox_monitor.robot.description import RobotDescription

FORMAT = '4'  # of version 0.2: none


class SnapshotError(InputError):
    """A snapshot cannot be read: damaged, or of another version."""


@contextmanager
def snapshot_errors(source: str) -> Iterator[None]:
    """Raise SnapshotError, naming `source`, for what a damaged snapshot raises in the block."""
    try:
        yield
    except InputError:
        raise
    except (KeyError, ValueError, TypeError, AttributeError, OverflowError, IndexError,
            RecursionError) as error:
        raise SnapshotError(f'{source}: not a snapshot of this version ({error})') from None


def expect_format(snapshot: Values, source: str) -> None:
    """Raise SnapshotError, naming `source`, for a snapshot of another version."""
    if snapshot.get('format') != FORMAT:
        raise SnapshotError(f'{source}: of another version, expected format {FORMAT}: state the '
                            'model (--model), and the parameters (--params)')


def _text(a: AnyArray) -> str:
    """Return the elements of `a` as text that reads back bit for bit."""
    return json.dumps([v if type(v) is int else v.hex() for v in a.ravel().tolist()])


def _read(snapshot: Values, arrays: Mapping[str, AnyArray]) -> None:
    """Fill `arrays` {name: of any shape} with what _text wrote; see snapshot_errors."""
    for name, array in arrays.items():
        values = json.loads(snapshot[name])
        if array.dtype == float:
            values = [float.fromhex(value) for value in values]
        elif len(values) != len(array) or any(type(value) is not int for value in values):
            raise ValueError(f'{name}: {str(values)[:60]}, expected {len(array)} whole numbers')
        array[:] = np.array(values).reshape(array.shape)


# The smoother keeps the step records of its lag at RING_RATE (Hz), but no more than RING.
RING, RING_RATE = 2048, 10_000
BATCH = 4096  # samples between two stops, at most
PENDING = 256  # the same, sample by sample

PAIR = struct.Struct('=2d')  # faster than numpy takes two numbers

Observer = Callable[[Batch], None]


def unsmoothed(
        parameters: EstimatorParameters | Values | None) -> EstimatorParameters | Values:
    """Return `parameters` of an Estimator without the smoother."""
    if isinstance(parameters, EstimatorParameters):
        return parameters.replace(smoother_lag=0.0)
    return {**values_of(parameters), 'smoother_lag': 0.0}


class Estimator:
    """
    The filter and smoother of one gearbox.

    model: DriveModel. parameters: EstimatorParameters, or a mapping with some of their names (the
    others take their defaults) and of parameters.MODEL, which replace values of the model;
    `smoother_lag` 0 leaves the smoother out. robot: what the parameter robot_description holds;
    it gives the load on the arm if arm_load is "model". The observer that `step` and `run` take is
    called with a Batch at every stop of the sample loop: after each start, each dropout that was
    bridged, each divergence, at most BATCH samples, and after the first sample that `stop_at` asks
    for.
    With tau_k_model "mixed" this is the random walk, members are the filters beside it, and
    estimates are the mixed ones (see model_bank); Batches, names, packed and the belief are the
    random walk's own.
    Raises InputError for a parameter that is unknown or out of range.
    """

    def __init__(self, model: DriveModel,
                 parameters: EstimatorParameters | Values | None = None,
                 robot: RobotDescription | None = None) -> None:
        self.model, self.parameters = resolve(model, parameters)
        self.robot = robot
        self._arm_load = arm_load_of(robot, self.parameters)
        expect_effort(self.model, self.parameters)
        self.divergences: deque[Divergence] = deque(maxlen=100)  # newest last
        self.counts = np.zeros(sample_loop.N_COUNTS, np.int64)
        self._gate = np.zeros(sample_loop.N_GATE, np.int64)
        self._one = Stream(np.zeros(1, np.int64), np.zeros((1, 2)), np.zeros((1, 2)))
        # What the next Batch of `step` holds: estimates, and chunks of smoothed rows.
        self._pending = np.empty(PENDING, np.int64), np.empty((PENDING, sample_loop.N_ESTIMATE))
        self._n_pending = 0
        self._pending_smoothed: list[tuple[Integers, Array]] = []
        self._setup()

    # ------------------------------------------------------------------ set-up and state

    def _setup(self) -> None:
        p = self.parameters
        self._n_pending = 0
        self._pending_smoothed.clear()
        self.drive = drive_of(self.model, p)
        self.names = state_names(self.drive, p)
        self.packed = pack(self.drive, p)
        self._acting = self.packed  # what the kernels change of it goes with a sample
        self._kind = filter_kind(p.filter)
        self._run_once = Repeated(sample_loop.run)
        self.settings = settings_of(self.drive, p)
        if self._arm_load is not None:
            self._acting = self.packed.copy()
            self.settings = self.settings._replace(described=DescribedLoad(
                p.robot_error_time, self.packed[Q0 + TAU_ARM], self.packed[Q0 + TAU_K],
                self.packed[EIGENVALUE], self.drive.arm_inertia))
        self.states = layout_of(self.packed, len(self.names))
        self.warnings = [*self._kind.warnings(len(self.names), p), *model_warnings(self.drive)]
        if self._arm_load is None and described(p):
            self.warnings.append('robot_description is not at hand: the load on the arm counts '
                                 'as unknown')
        # Few stay in the processor's cache.
        rows = min(RING, 2 + round(RING_RATE * p.smoother_lag))
        self._output_one = _output(1, rows)
        self._belief, self._scratch, self._state = loop_arrays(
            self._kind, len(self.names), rows, self.drive)
        self._gate[:sample_loop.INPUTS] = 0
        self._gate[sample_loop.STOP_AT] = sample_loop.NEVER
        self._state = self._state._replace(gate=self._gate, counts=self.counts)
        self.members = [
            Estimator(self.model, values, self.robot)
            for values in model_bank.member_parameters(p)]
        self._mixture, self._outputs = model_bank.mixture(bool(self.members)), (
            model_bank.outputs(RING if self.settings.lag else 0) if self.members else None)
        self._own = [self._outputs.of(i) for i in range(model_bank.M)] if self._outputs else []
        self._mix, self._mix_smoothed = Repeated(model_bank.mix), Repeated(model_bank.mix_smoothed)

    @property
    def robot_joints(self) -> tuple[str, ...]:
        """The joints whose positions samples must hold; none without a robot's description."""
        return self.robot.joints if self.robot is not None and self._arm_load is not None else ()

    def reset(self) -> None:
        """Restart with the next sample; counters stay."""
        self._arm_load = arm_load_of(self.robot, self.parameters)
        self._setup()

    def set_parameters(self, changes: Values) -> bool:
        """
        Change parameters while running; Q, R and thresholds keep the belief, others restart.

        Those of PAYLOAD change nothing but the load on the arm from the next sample on.

        changes: {name: value} of parameters.ESTIMATOR and MODEL. Returns whether the filter
        restarts. Raises InputError, leaving everything as it was.
        """
        rows = {row.name: row for row in ESTIMATOR}
        model, changes = with_model_values(self.model, changes)
        new = self.parameters.replace(**changes)
        motion = None if self._arm_load is None else self._arm_load.motion
        arm_load = arm_load_of(self.robot, new, motion)
        expect_effort(model, new)
        for values in (new, *model_bank.member_parameters(new)):
            pack(drive_of(model, values), values)  # raises before anything has changed
        changed = [name for name in changes
                   if getattr(new, name) != getattr(self.parameters, name)]
        restart = model != self.model or any(rows[name].change != AT_ONCE for name in changed)
        self.model, self.parameters, self._arm_load = model, new, arm_load
        if PAYLOAD.issuperset(changes) and not restart:
            for estimator in (self, *self.members) if changed else ():
                clock = estimator._state.clock
                if clock[sample_loop.DESCRIBED] > 0.0:
                    clock[sample_loop.DESCRIBED] = sample_loop.NEW_PAYLOAD
            return False
        if restart:
            self.reset()
            return True
        self._carry_on()
        return False

    def _carry_on(self) -> None:
        """Go on with the belief after a change of Q, R or thresholds."""
        packed, belief, state, gate = self.packed, self._belief, self._state, self._gate.copy()
        members, mixture = self.members, self._mixture
        self._setup()
        if not np.array_equal(packed, self.packed):  # the memory is made from the old values
            belief = belief._replace(memory=self._belief.memory)
            state.clock[sample_loop.MOVED:] = 0.0
        self._belief = belief
        self._state = self._state._replace(clock=state.clock, efforts=state.efforts,
                                           companions=state.companions)
        self._gate[:] = gate
        for member, new in zip(members, self.members):
            member.parameters = new.parameters
            member._carry_on()
        self.members, self._mixture = members, mixture
        self._keep_belief_only()

    def _keep_belief_only(self) -> None:
        """Let the smoother begin at the present step: older records are not at hand."""
        step = self._gate[sample_loop.STEPS]
        n = len(self.names)
        place = step % len(self._state.ring)
        row = self._state.ring[place]
        z, P = updated(row, n)
        z[:], P[:] = self._belief.z, self._belief.P.reshape(n, n)
        acting = (step - 1 - self.parameters.effort_delay) % sample_loop.N_EFFORTS
        row[-1] = self._state.efforts[acting, 0]
        companions = self._state.companions
        _, _, at_s, at_smoothed = sensitivities(n, len(row))
        row[at_s:at_smoothed] = companions.s[:-1]
        self._state.ring_stamps[place] = self._gate[sample_loop.LAST]
        self._gate[sample_loop.SMOOTH_NEXT] = step
        if self.members:
            model_bank.begin(self._mixture, int(self._gate[sample_loop.LAST]))

    def snapshot(self) -> dict[str, str]:
        """
        Return everything that the next estimates depend on, as {name: text}.

        Numbers are written so that they read back bit for bit; see restore.
        """
        members = [member.snapshot() for member in self.members]
        for member in members:  # they follow from those of the bank
            for name in ('format', 'model', 'parameters', 'robot'):
                member.pop(name, None)
        return {
            'format': FORMAT,
            **({} if self.robot is None else {'robot': json.dumps(to_data(self.robot))}),
            'model': json.dumps(self.model.to_dict()),
            'parameters': json.dumps(self.parameters.to_dict()),
            'members': json.dumps(members),
            'stamp_ns': str(self._gate[sample_loop.LAST]),
            'input_count': str(self._gate[sample_loop.INPUTS]),
            **{name: _text(a) for name, a in self._arrays().items()}}

    def _arrays(self) -> dict[str, AnyArray]:
        """Return {name in a snapshot: array of the state}."""
        load = {} if self._arm_load is None else {
            'motion': self._arm_load.motion.joints, 'acting': self._acting,
            'motion_clock': self._arm_load.motion.clock}
        return {**self._belief._asdict(), 'clock': self._state.clock,
                'efforts': self._state.efforts, 'sensitivities': self._state.companions.s,
                'weights': self._mixture.weights, 'alone': self._mixture.alone,
                'gate': self._gate[:sample_loop.STOP_AT], 'counts': self.counts, **load}

    @classmethod
    def restore(cls, snapshot: Values, source: str = 'snapshot',
                changes: Values | None = None) -> 'Estimator':
        """
        Return the Estimator that goes on from a snapshot.

        Args:
            snapshot: {name: text} of `snapshot`, or of a Monitor's, which holds more.
            source: what error messages call it.
            changes: parameters that replace those of the snapshot; the filter's state must not
                depend on them (smoother_lag).

        Raises:
            InputError: the snapshot is damaged or of another version (SnapshotError), or holds a
                model or parameters that are invalid.

        """
        expect_format(snapshot, source)
        with snapshot_errors(source):
            robot = json.loads(snapshot.get('robot', 'null'))
            restored = cls(model_from_dict(json.loads(snapshot['model']), source),
                           {**json.loads(snapshot['parameters']), **(changes or {})},
                           from_data(robot, classes_of(RobotDescription)))
            restored._recall(snapshot)
        return restored

    def _recall(self, snapshot: Values) -> None:
        """Take over the state of a `snapshot`."""
        _read(snapshot, self._arrays())
        self._gate[sample_loop.INPUTS] = int(snapshot['input_count'])
        for member, own in zip(self.members, json.loads(snapshot['members']), strict=True):
            member._recall(own)
        self._keep_belief_only()

    def divergence_notes(self) -> list[str]:
        """Return sentences about divergences for the user."""
        count = int(self.counts[sample_loop.DIVERGED])
        if not count:
            return []
        if not self.divergences:
            return [f'{count} divergences before the snapshot that this started from']
        first = str(self.divergences[0])
        return [first if count == 1 else f'{first}; {count} divergences in all']

    @property
    def stamp_ns(self) -> int:
        """Stamp of the last accepted sample, 0 before the first."""
        return int(self._gate[sample_loop.LAST])

    @property
    def accurate_since_ns(self) -> int:
        """Stamp from which on errors are as small as stated: of the last start or dropout."""
        return int(self._gate[sample_loop.STARTED])

    @property
    def input_count(self) -> int:
        """Number of input samples, refused ones included."""
        return int(self._gate[sample_loop.INPUTS])

    @property
    def period(self) -> float:
        """The usual distance of stamps (s), 0 before it is known."""
        return float(self._state.clock[sample_loop.PERIOD])

    # ------------------------------------------------------------------ adaptation

    @property
    def packed_in_use(self) -> Array:
        """The packed parameters (process_model.pack) of the next step, adapted ones included."""
        adaptation = self._kind.adaptation
        return adaptation.packed(self._belief.memory, self.packed) if adaptation else self.packed

    def adapted(self) -> dict[str, float]:
        """Return {parameter: value in use} of what the filter adapts, in the parameter's unit."""
        adaptation = self._kind.adaptation
        return adaptation.values(self._belief.memory, self.packed) if adaptation else {}

    def adapted_to_bound(self) -> list[str]:
        """Return the adapted parameters that stand at the bound of their range."""
        adaptation = self._kind.adaptation
        return adaptation.at_bound(self._belief.memory, self.packed) if adaptation else []

    def adaptation_guards(self) -> dict[str, int]:
        """Return {guard of the adaptation: how often it acted since the start}."""
        adaptation = self._kind.adaptation
        return adaptation.guards(self._belief.memory) if adaptation and self.adapted() else {}

    def learned_curve(self) -> dict[str, float]:
        """
        Return gap (rad), stiffness (N m/rad) and hysteresis (rad) as learnt; {} if not.

        Where models are mixed, with the probability of each.
        """
        if self.members:
            return {**self.members[-1].learned_curve(), **{
                f'probability_{name}': float(weight)
                for name, weight in zip(model_bank.MEMBERS, self._mixture.weights)}}
        n, (z, P, _) = len(self.names), self._belief
        if self.names[-3:] != list(LEARNT):
            return {}
        half_gap, gap_std = learned_length(z, P, n, n - 2)
        width, width_std = learned_length(z, P, n, n - 1)
        return {'learned_gap_rad': 2.0 * half_gap, 'learned_gap_std_rad': 2.0 * gap_std,
                'learned_stiffness': float(z[-3]),
                'learned_stiffness_std': math.sqrt(P[(n - 3) * (n + 1)]),
                'learned_hysteresis_rad': width, 'learned_hysteresis_std_rad': width_std}

    def undetected_errors(self) -> dict[str, float]:
        """
        Return by how much tau_K errs (rms, N m) if a value is off by its tolerance, by name.

        Over the last steps that are at hand. The stated deviation covers these errors, and no
        check reports them. Of the random walk, where models are mixed.
        """
        ring, steps = self._state.ring, int(self._gate[sample_loop.STEPS])
        if not steps or not self._state.companions.number:
            return {}
        # After a change of parameters the records before it are gone.
        first = max(int(self._gate[sample_loop.SMOOTH_NEXT]), steps - len(ring) + 1)
        return torque_errors_at_tolerance(
            self.drive, len(self.names), ring[np.arange(first, steps + 1) % len(ring)])

    # ------------------------------------------------------------------ samples

    def stop_at(self, stamp_ns: int) -> None:
        """
        Let `run` stop after the first sample at or after `stamp_ns`, for its observer.

        It also stops after a sample that is more than a second older: the clock was set. 0: after
        the next sample; sample_loop.NEVER (the default): nowhere.
        """
        self._gate[sample_loop.STOP_AT] = stamp_ns

    def step(self, sample: Sample, observe: Observer | None = None) -> Estimate | None:
        """
        Take one `sample`; return its Estimate, or None if it is refused or the first one.

        observe: see Estimator.
        """
        stream, output = self._one, self._output_one
        try:
            stream.stamps[0] = sample.stamp_ns
            PAIR.pack_into(stream.inputs.data, 0, *sample.u)
            PAIR.pack_into(stream.outputs.data, 0, *sample.y)
        except (AttributeError, TypeError, ValueError, OverflowError, struct.error):
            raise InputError(f'sample: {str(sample)[:80]}, expected a Sample: stamp_ns a whole '
                             'number, u and y two numbers each') from None
        if self._arm_load is None and self.parameters.effort_is == COMPENSATED:
            stream.inputs[0, 0] = np.nan  # without the description it is not known
        if self._arm_load is not None:
            stream = stream._replace(inputs=self._arm_load.inputs(
                stream.stamps, stream.inputs, np.array([sample.joints])))
        _, n = self._advance(stream, output)
        completed = tuple([(int(output.smoothed_stamps[i]), output.smoothed[i].copy())
                           for i in range(n)])
        code = int(output.codes[0])
        good = code == sample_loop.ESTIMATE
        if observe is not None:
            self._collect(int(sample.stamp_ns), code, n, observe)
        if not good:
            return None
        z, P, row = self._belief.z.copy(), self._belief.P.copy(), output.estimates[0].copy()
        if not self.parameters.arm_joint:
            row[ARM_COLUMNS] = np.nan
            for _, values in completed:
                values[SMOOTHED_ARM_COLUMNS] = np.nan
        return Estimate(int(sample.stamp_ns), z, P.reshape(len(z), -1), row, completed)

    def _collect(self, stamp_ns: int, code: int, n_smoothed: int, observe: Observer) -> None:
        """
        Add what one step gave to the next Batch, and hand that to `observe` where `run` stops.

        Args:
            stamp_ns: of the sample.
            code: what became of it.
            n_smoothed: number of rows that it completed.
            observe: see Estimator.

        """
        output, at = self._own_output(self._output_one), self._n_pending
        good = code == sample_loop.ESTIMATE
        if good:
            self._pending[0][at], self._pending[1][at] = stamp_ns, output.estimates[0]
            self._n_pending = at + 1
        if n_smoothed:
            self._pending_smoothed.append((self._output_one.smoothed_stamps[:n_smoothed].copy(),
                                           output.smoothed[:n_smoothed].copy()))
        stop_ns = int(self._gate[sample_loop.STOP_AT])
        if not good or self._n_pending == PENDING or not stop_ns or not (
                stop_ns - SECOND <= stamp_ns < stop_ns) or self.accurate_since_ns == stamp_ns:
            self._hand_over(stamp_ns, code, observe)

    def flush(self, observe: Observer) -> None:
        """Give `observe` what single steps have collected for it."""
        if self._n_pending or self._pending_smoothed:
            self._hand_over(self.stamp_ns, sample_loop.ESTIMATE, observe)

    def _hand_over(self, stamp_ns: int, code: int, observe: Observer) -> None:
        """Give `observe` what was collected up to the sample at `stamp_ns` of this `code`."""
        (stamps, rows), n = self._pending, self._n_pending
        smoothed = self._pending_smoothed or [(stamps[:0], np.empty((0, N_SMOOTHED)))]
        self._n_pending, self._pending_smoothed = 0, []
        observe(Batch(stamp_ns, code, stamps[:n].copy(), rows[:n].copy(),
                      *(np.concatenate(column) for column in zip(*smoothed))))

    def run(self, samples: Samples, observe: Observer | None = None) -> Estimates:
        """Take `samples`; return their Estimates, the same bits as by step; observe: see step."""
        if observe is not None:
            self.flush(observe)
        stamps, u, y = checked(samples)
        if self._arm_load is not None and len(stamps):
            if samples.joints is None:
                raise InputError('samples without the positions of the robot, expected them with '
                                 'robot_description')
            u = self._arm_load.inputs(stamps, u, samples.joints)
        elif self.parameters.effort_is == COMPENSATED:
            u = np.where([True, False], np.nan, u)
        n, start, completed = len(stamps), 0, 0
        output = _output(n, n + RING if self.settings.lag else 0)
        codes, rows, stamps_s, smoothed = output
        while start < n:
            end = start + BATCH
            part = Output(codes[start:end], rows[start:end], stamps_s[completed:],
                          smoothed[completed:])
            n_samples, n_rows = self._advance(
                Stream(stamps[start:end], u[start:end], y[start:end]), part)
            end = start + n_samples
            if observe is not None:
                good = _selection(codes[start:end] == sample_loop.ESTIMATE)
                own = self._own_output(part)
                observe(Batch(int(stamps[end - 1]), codes[end - 1], stamps[start:end][good],
                              own.estimates[:n_samples][good].copy(),
                              part.smoothed_stamps[:n_rows].copy(), own.smoothed[:n_rows].copy()))
            start, completed = end, completed + n_rows
        good = _selection(codes == sample_loop.ESTIMATE)
        rows, smoothed = rows[good], smoothed[:completed]
        if not self.parameters.arm_joint:
            rows[:, ARM_COLUMNS] = smoothed[:, SMOOTHED_ARM_COLUMNS] = np.nan
        return Estimates(stamps[good], rows, stamps_s[:completed], smoothed, codes)

    def _own_output(self, mixed: Output) -> Output:
        """Return what this filter wrote itself when `mixed` was written."""
        return self._own[0] if self._own else mixed

    def _advance(self, stream: Stream, output: Output) -> tuple[int, int]:
        """Take samples up to a stop; return how many, and how many smoothed rows they gave."""
        if self._outputs is None:
            return self._filter(stream, output)
        own = self._outputs
        n, diverged = model_bank.until_second(self._mixture, stream.stamps)
        if diverged:
            self.members[-1]._restart()
        n_samples, own.n_smoothed[0] = self._filter(part_of(stream, 0, n), self._own[0])
        part = part_of(stream, 0, n_samples)
        restarts = bool(n_samples) and own.codes[0, n_samples - 1] == sample_loop.START
        for i, member in enumerate(self.members, 1):
            own.n_smoothed[i] = member._follow(part, self._own[i], restarts)
        mix, mix_smoothed = (self._mix, self._mix_smoothed) if len(stream.stamps) == 1 else (
            model_bank.mix, model_bank.mix_smoothed)
        mix(self._mixture, own, part.stamps, output)
        mix_smoothed(self._mixture, own, output)
        return n_samples, int(own.n_smoothed[0])

    def _follow(self, stream: Stream, output: Output, restarts: bool) -> int:
        """Take what a leader took; return the number of smoothed rows; restarts: at the last."""
        codes, rows, stamps_s, smoothed = output
        start, completed, n = 0, 0, len(stream.stamps)
        while start < n:
            end = n
            if restarts and start < n - 1:
                end = n - 1
            elif restarts:
                self._restart()
            part = Output(codes[start:end], rows[start:end], stamps_s[completed:],
                          smoothed[completed:]) if start or end < n else output
            n_samples, n_rows = self._filter(part_of(stream, start, end), part)
            start, completed = start + n_samples, completed + n_rows
        return completed

    def _restart(self) -> None:
        """Begin again with the next complete sample."""
        self._gate[[sample_loop.LAST, sample_loop.PENDING_COUNT]] = 0

    def _filter(self, stream: Stream, output: Output) -> tuple[int, int]:
        run = self._run_once if len(stream.stamps) == 1 else sample_loop.run
        n_samples, n = run(self.states, self.settings, self._acting, stream, self._state,
                           self._belief, self._scratch, output)
        if n_samples and output.codes[n_samples - 1] == sample_loop.DIVERGED:
            self.divergences.append(self._divergence(int(stream.stamps[n_samples - 1])))
        return n_samples, n

    def _divergence(self, stamp_ns: int) -> Divergence:
        """Return why the filter failed at the last sample, stamped `stamp_ns`."""
        n, step = len(self.names), int(self._gate[sample_loop.STEPS])
        z, P, _ = self._belief
        ring = self._state.ring
        _, predicted_P, _ = predicted(ring[step % len(ring)], n)
        reason, smallest = 'state or covariance is not finite', np.nan
        if np.isfinite(z).all() and np.isfinite(P).all():
            smallest = float(np.linalg.eigvalsh(P.reshape(n, n)).min())
            reason = 'the covariance is not positive definite'
            if smallest > 0.0:
                reason = 'the innovation is not finite or its covariance not positive'
                if np.isfinite(predicted_P).all():
                    smallest = float(np.linalg.eigvalsh(predicted_P).min())
        return Divergence(step, stamp_ns, reason, smallest)


def _output(n: int, n_smoothed: int) -> Output:
    """Return room for `n` estimates and `n_smoothed` smoothed rows."""
    return Output(np.empty(n, np.int64), np.empty((n, sample_loop.N_ESTIMATE)),
                  np.empty(n_smoothed, np.int64), np.empty((n_smoothed, N_SMOOTHED)))


def _selection(good: Any) -> Any:
    """Return what selects the rows `good` (bool [N]): a slice, which copies nothing, or `good`."""
    chosen = np.flatnonzero(good)
    if not len(chosen) or chosen[-1] - chosen[0] + 1 == len(chosen):
        return slice(chosen[0], chosen[-1] + 1) if len(chosen) else slice(0)
    return good
