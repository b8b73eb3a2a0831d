# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Trust and drift: a Monitor judges the estimates of its Estimator once per second.

The live node, replay and the tests call the same Monitor, sample by sample (`step`) or in arrays
(`run`): same samples in, same outcomes out.

Trust reads the newest estimates and smoothed rows once per second, from a RowHistory.
"""
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
import json
from typing import TYPE_CHECKING

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Batch, Estimate, Estimates, Sample, Samples
from gearbox_monitor.estimation.estimator import Estimator, snapshot_errors
from gearbox_monitor.estimation.process_model import P0, R1, R2, TAU_K
from gearbox_monitor.estimation.rts_smoother import S_TWIST_NOISE_STD
from gearbox_monitor.health import judgement
from gearbox_monitor.health.alarms import (
    Alarm, Condition, joined, Level, LIMITS, Outcome, outcome_of, with_more)
from gearbox_monitor.health.backlash import features
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.health.checks import innovation, observability, row_checks
from gearbox_monitor.health.checks.row_checks import middle, PASSIVITY, thinned, TWIST_RANGE
from gearbox_monitor.health.health_record import (
    AT_ODDS, ERRORS_LARGER, HealthSettings, TRUSTED, Window)
from gearbox_monitor.health.judgement import from_data, Health, judge, to_data
from gearbox_monitor.kernels.types import Array, Flags, Integers, Values
from gearbox_monitor.parameters import CURVES, EstimatorParameters, PAYLOAD
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said
from gearbox_monitor.robot.description import RobotDescription

if TYPE_CHECKING:  # it brings the diagnosis with it
    from gearbox_monitor.health.backlash.hidden_arm import HiddenArm

SECOND = sample_loop.SECOND
COMPONENTS = ('observability', 'prediction error', 'covariance', 'model', 'backlash', 'friction',
              'input')

LOST = tuple(code for code in sample_loop.REASONS if code != sample_loop.START)
REASON_CODES = np.array(list(sample_loop.REASONS))
REFUSALS = [sample_loop.REASONS[code] for code in (
    sample_loop.ZERO_STAMP, sample_loop.DUPLICATE, sample_loop.BACKWARD, sample_loop.JUMP,
    sample_loop.NO_EFFORT, sample_loop.NO_MEASUREMENT, sample_loop.DIVERGED,
    sample_loop.POSITION_JUMP)]
RESET = {'reset_motor_rad': sample_loop.E_X1, 'reset_arm_rad': sample_loop.E_X2,
         'reset_tau_k': sample_loop.E_TAU_K}  # what a restart moves
WHITE, INNOVATIONS, INNOVATION_STDS = (slice(column, column + 2) for column in (
    sample_loop.E_WHITE_1, sample_loop.E_INNOVATION_MOTOR, sample_loop.E_INNOVATION_STD_MOTOR))
STATE_COLUMNS = {'tau_arm': sample_loop.E_TAU_ARM, 'tau_e': sample_loop.E_TAU_E}
MEDIAN_STRIDE = 8  # of rows that a median is of: sorting all is slow, few will do
NO_DATA, NOT_EVALUATED, NO_ESTIMATES = (Outcome.of(Level.WARN, code) for code in (
    'no_data_yet', 'not_evaluated', 'no_estimates'))
# Components that a change of the gearbox or of its friction affects.
DRIFT_SHOWS = {'prediction error', 'model'}
JUDGED = COMPONENTS[:4]  # once per second, from the newest estimates
# Samples that stand in time: an evaluation may be due with them.
IN_TIME = (sample_loop.ESTIMATE, sample_loop.START, sample_loop.NO_EFFORT,
           sample_loop.NO_MEASUREMENT)
AT_BOUND = Condition('at_bound', 'covariance', Level.WARN, ('adapted_...',))
# Checks of smoothed torque and twist, reported with the prediction errors.
ROW_CHECKS = (PASSIVITY, TWIST_RANGE, row_checks.CURVE)
CONDITIONS = (
    *observability.INPUT_CONDITIONS, *observability.CONDITIONS, *innovation.CONDITIONS,
    *(condition for check in ROW_CHECKS for condition in check.conditions),
    *innovation.COVARIANCE_CONDITIONS, AT_BOUND, *innovation.MODEL_CONDITIONS)
ROWS_KEPT = round(max(check.window for check in ROW_CHECKS) * SECOND)  # ns
ESTIMATES_KEPT = round(LIMITS.error_window * SECOND)

WINDOWS_KEPT = 1000
Outcomes = dict[str, Outcome]  # by component
BLOCK = 512  # rows of room, at least
ROOM = 1.25  # of what is kept: rows move when it is full


class RowHistory:
    """
    Rows in order of time, in one array.

    Rows that are older than the newest one replace all others: the clock was set back.
    """

    def __init__(self) -> None:
        self._stamps, self._rows = np.empty(0, np.int64), np.empty((0, 0))
        self._end = 0

    def __len__(self) -> int:
        return self._end

    @property
    def stamps(self) -> Integers:
        """Stamps of the rows, int64 [N] ns; not to keep."""
        return self._stamps[:self._end]

    def clear(self) -> None:
        """Forget all rows."""
        self._end = 0

    def add(self, stamps: Integers, rows: Array, keep_ns: int) -> None:
        """
        Add rows; older ones make room for them.

        Args:
            stamps: of the rows, int64 [N > 0] ns, ascending.
            rows: [N, M].
            keep_ns: rows stamped before it may go.

        """
        n = len(stamps)
        if self._end and stamps[0] < self._stamps[self._end - 1]:
            self.clear()
        if self._end + n > len(self._stamps):
            rows_in_memory = slice(int(np.searchsorted(self.stamps, keep_ns)), self._end)
            count = rows_in_memory.stop - rows_in_memory.start
            size = max(round(ROOM * (count + n)), BLOCK)
            old = self._stamps[rows_in_memory], self._rows[rows_in_memory]
            self._stamps, self._rows = np.empty(size, np.int64), np.empty((size, rows.shape[1]))
            if count:
                self._stamps[:count], self._rows[:count] = old
            self._end = count
        part = slice(self._end, self._end + n)
        self._stamps[part], self._rows[part] = stamps, rows
        self._end = part.stop

    def between(self, first_ns: int, end_ns: int) -> tuple[Integers, Array]:
        """Return (stamps, rows) with `first_ns` <= stamp < `end_ns`; not to keep."""
        part = slice(*np.searchsorted(self.stamps, (first_ns, end_ns)))
        return self._stamps[part], self._rows[part]

    def after(self, stamp_ns: int) -> Array:
        """Return the rows [N, M] stamped after `stamp_ns`; not to keep."""
        first = int(np.searchsorted(self.stamps, stamp_ns, 'right'))
        return self._rows[first:self._end]


class Monitor:
    """
    Trust and drift of one gearbox.

    model, parameters, robot: as of Estimator. known: what judgement.to_data gave of an earlier
    Health, or None (then the first windows are healthy). estimator: the Estimator that it judges;
    health: of the gearbox; outcomes {component: Outcome} in force; judged: the newest Windows,
    in order of time; windows: the backlash of those that show it; alerts: (stamp in ns, component,
    its Outcome) of each change of a drift alert that nobody has taken yet: raised, worse, over;
    temperature: of the gearbox (deg C), None = not known, set it when it changes. phase_ns:
    evaluations come with the first sample after each whole second of the stamps plus this offset.
    Raises InputError as Estimator does, and what from_data raises.
    """

    def __init__(self, model: DriveModel,
                 parameters: EstimatorParameters | Values | None = None,
                 known: Values | None = None, robot: RobotDescription | None = None,
                 phase_ns: int = 0) -> None:
        if known is not None:
            known = {**known, 'earlier': bool(known['stamp_ns'])}
        self._begin(Estimator(model, parameters, robot), known, phase_ns)

    def _begin(self, estimator: Estimator, known: Values | None, phase_ns: int) -> None:
        self.estimator = estimator
        self.outcomes: Outcomes = dict.fromkeys(COMPONENTS, NO_DATA)
        self.windows: deque[features.Backlash] = deque(maxlen=WINDOWS_KEPT)
        self.judged: deque[Window] = deque(maxlen=WINDOWS_KEPT)
        self.alerts: deque[tuple[int, str, Outcome]] = deque(maxlen=WINDOWS_KEPT)
        self._stages: dict[str, dict[str, int]] = {}
        self.know(from_data(HealthSettings.of(estimator.parameters, estimator.model), known))
        self.temperature: float | None = None
        self._phase_ns = phase_ns
        self._newest: list[float] = []  # of RESET, in the newest estimate
        self._restarts = False  # whether the next estimate is the first after a restart
        self._said: dict[str, float | str] = {}  # of the newest restart and refusal
        self._forget()

    # ------------------------------------------------------------------ state

    @property
    def model(self) -> DriveModel:
        """The DriveModel of the estimator."""
        return self.estimator.model

    @property
    def parameters(self) -> EstimatorParameters:
        """The parameters of the estimator."""
        return self.estimator.parameters

    @property
    def counts(self) -> Integers:
        """How often each code of sample_loop came, int64 [N_COUNTS]."""
        return self.estimator.counts

    @property
    def stamp_ns(self) -> int:
        """Stamp of the last accepted sample, 0 before the first."""
        return self.estimator.stamp_ns

    @property
    def input_count(self) -> int:
        """Number of input samples, refused ones included."""
        return self.estimator.input_count

    def know(self, health: Health) -> None:
        """Go on from `health`: a baseline was saved, or a cause was named."""
        self.health = health
        if health.stamp_ns:
            self.outcomes = {**self.outcomes, **judgement.outcomes(health)}
            for component, stages in health.stages().items():
                if stages != self._stages.get(component, {}):
                    self.alerts.append((self.stamp_ns, component, self.outcomes[component]))
            self._stages = health.stages()

    @property
    def model_lasts(self) -> tuple[Level, int]:
        """Level of the model, and the stamp (ns) since which it holds; OK, 0 while unknown."""
        alarm = self._alarms['model']
        return (alarm.level, alarm.since_ns) if alarm.judged and alarm.since_ns else (Level.OK, 0)

    def _forget(self) -> None:
        """Drop all windows: what they hold belongs to another belief."""
        self._estimates = RowHistory()  # the newest
        # Smoothed, for a hidden arm what it fits: of the window, and what ROW_CHECKS read.
        self._rows = RowHistory()
        self._begin_window()
        self._counts_on = False  # see Window
        self._hidden_arm = self._hidden_arm_of(None)
        self._evaluate_at(0)
        # Healthy median of the stated deviation of tau_K (N m), once that many are known.
        self._reference: float | None = None
        self._references: list[float] = []
        self._systematic = innovation.Systematic()
        self.outcomes = {**self.outcomes, **dict.fromkeys((*JUDGED, 'input'), NO_DATA)}
        self._alarms = {name: Alarm() for name in (*JUDGED, 'input')}
        # Of each of ROW_CHECKS: its alarm, its evaluations, those that reached a result, and the
        # values of windows one after the other, with their stamps.
        self._row_alarms = [
            Alarm(down=check.down) for check in ROW_CHECKS]
        self._row_counts = np.zeros((len(ROW_CHECKS), 2), np.int64)
        self._row_values: list[deque[tuple[int, Values]]] = [
            deque(maxlen=check.earlier and check.earlier + 1) for check in ROW_CHECKS]
        self._last_counts = self.counts.copy()

    def _hidden_arm_of(self, state: Sequence[float] | None) -> 'HiddenArm | None':
        """Return what fits windows without arm encoder, as `state` left it; else None."""
        if self.parameters.arm_joint:
            return None
        from gearbox_monitor.health.backlash.hidden_arm import HiddenArm
        return HiddenArm(self.model, state)

    def _begin_window(self) -> None:
        self._rows.clear()
        self._window_start: int | None = None  # stamp of its first row
        self._window_whole = True  # whether its rows are at hand from there on
        # Evaluations in it that any indicator of trust flagged, and one outside DRIFT_SHOWS.
        self._window_flagged = self._window_broken = 0
        self._window_nis: list[float] = []  # over degrees of freedom, of the evaluations in it
        self._window_counts = self._lost_and_all()  # at its begin

    def _evaluate_at(self, stamp_ns: int) -> None:
        """Evaluate with the first sample at or after `stamp_ns`; 0: a second after the next."""
        self._due_ns = stamp_ns
        self.estimator.stop_at(stamp_ns)

    def _withdraw(self, outcome: Outcome) -> None:
        """Replace each OK of JUDGED by `outcome`: it says nothing of the estimates from now on."""
        self.outcomes = {name: outcome if name in JUDGED and old.level == Level.OK else old
                         for name, old in self.outcomes.items()}
        for alarm in (*(self._alarms[name] for name in JUDGED), *self._row_alarms):
            alarm.doubt()

    def reset(self) -> None:
        """Restart with the next sample; counters and baseline stay."""
        self.estimator.flush(self._judge)
        self.estimator.reset()
        self._forget()

    def set_parameters(self, changes: Values) -> bool:
        """Apply `changes` as Estimator.set_parameters does; return whether it restarts."""
        self.estimator.flush(self._judge)
        restarts = self.estimator.set_parameters(changes)
        if not PAYLOAD.issuperset(changes):
            self.know(replace(
                self.health, settings=HealthSettings.of(self.parameters, self.model)))
            self._forget()
        return restarts

    def snapshot(self) -> dict[str, str]:
        """Return everything that estimates and outcomes on drift depend on, as {name: text}."""
        self.estimator.flush(self._judge)  # single steps collect samples up to the next second
        return {
            **self.estimator.snapshot(), 'health': json.dumps(to_data(self.health)),
            'monitor': json.dumps([
                self._phase_ns, self.temperature, self._hidden_arm and self._hidden_arm.to_list(),
                self._window_start, self._counts_on, self._newest, self._restarts, self._said,
                list(map(list, self._row_values))])}

    @classmethod
    def restore(cls, snapshot: Values, source: str = 'snapshot') -> 'Monitor':
        """Return the Monitor that goes on from `snapshot` of `source`. Raises InputError."""
        monitor = cls.__new__(cls)
        with snapshot_errors(source):
            phase, temperature, arm, *kept = json.loads(snapshot['monitor'])
            monitor._begin(Estimator.restore(snapshot, source), json.loads(snapshot['health']),
                           phase)
            monitor.temperature, monitor._hidden_arm = temperature, monitor._hidden_arm_of(arm)
            (monitor._window_start, monitor._counts_on, monitor._newest, monitor._restarts,
             monitor._said, *rows) = kept
            for values, found in zip(monitor._row_values, rows[0] if rows else ()):
                values.extend(map(tuple, found))
            monitor._window_whole = monitor._window_start is None
        return monitor

    def adopt_baseline(self, snapshot: Values) -> None:
        """
        Take over baselines, drift state and temperature of a `snapshot` of the same moment.

        A baseline may have been saved meanwhile, and the temperature is no sample.
        """
        _, self.temperature, arm, *_ = json.loads(snapshot['monitor'])
        self._hidden_arm = self._hidden_arm_of(arm)
        self.know(from_data(self.health.settings, json.loads(snapshot['health'])))

    # ------------------------------------------------------------------ samples

    def step(self, sample: Sample) -> Estimate | None:
        """Take one `sample`; return its Estimate, or None if it is refused or the first one."""
        return self.estimator.step(sample, self._judge)

    def run(self, samples: Samples) -> Estimates:
        """Take `samples`; return their Estimates, the same bits as step by step."""
        return self.estimator.run(samples, self._judge)

    def all_features(self) -> list[features.Backlash | features.NotExcited]:
        """
        Return what the newest windows say, at the end of a recording.

        The window in progress counts if it is at least half as long as the others, or the only
        one, which is then judged, too. Raises InputError without a smoother.
        """
        if self.parameters.smoother_lag <= 0.0 and self._hidden_arm is None:
            raise InputError('smoother_lag: 0, expected a number > 0 (s): backlash is measured on '
                             'the smoothed torque')
        found = [window.features for window in self.judged]
        stamps = self._rows.stamps
        if not len(stamps) or not self._window_whole:
            return found
        settled = self.estimator.accurate_since_ns + round(LIMITS.settle * SECOND)
        begin, end = max(self._window_start or int(stamps[0]), settled), int(stamps[-1])
        rows = self._rows.between(begin, end + 1)
        if not self.health.stamp_ns:
            self._window_ended(*rows, end)
            return [self.judged[-1].features]
        if end - begin >= round(0.5 * self.parameters.drift_window * SECOND):
            found.append(self._fitted(*rows, end))
        return found

    def _judge(self, batch: Batch) -> None:
        self._remember(batch)
        self._evaluate_if_due(batch.stamp_ns, batch.code)

    # ------------------------------------------------------------------ evaluation

    def _remember(self, batch: Batch) -> None:
        if len(batch.stamps):
            first, last = batch.rows[[0, -1]][:, list(RESET.values())].tolist()
            if self._restarts and self._newest:
                self._said.update(zip(RESET, np.subtract(first, self._newest).tolist()))
            self._newest, self._restarts = last, False
            self._estimates.add(batch.stamps, batch.rows,
                                int(batch.stamps[-1]) - ESTIMATES_KEPT)
        stamps, rows = batch.smoothed_stamps, batch.smoothed
        if self._hidden_arm is not None:
            stamps, rows = batch.stamps, self._hidden_arm.columns(batch.rows)
        if len(stamps):
            begin = self._window_start or 0  # open until the next evaluation
            self._rows.add(stamps, rows, min(begin, int(stamps[-1]) - ROWS_KEPT))

    def _evaluate_if_due(self, stamp_ns: int, code: int) -> None:
        """Evaluate when the next second of stamps begins; `code`: of the sample at `stamp_ns`."""
        if code == sample_loop.START:
            self._begin_window()
            self._restarts = True
            # After positions that jump the encoders count on, after a silence maybe not.
            _, before = self._estimates.between(
                stamp_ns - round(self.parameters.max_gap * SECOND), stamp_ns)
            self._counts_on &= len(before) > 0 and bool(np.isfinite(before[-1, INNOVATIONS]).all())
        if code not in IN_TIME:
            return
        if self.estimator.accurate_since_ns == stamp_ns:
            self._withdraw(NOT_EVALUATED)
        due_ns = self._due_ns
        self._evaluate_at(innovation.due_after(stamp_ns, due_ns, self._phase_ns))
        if due_ns and stamp_ns >= due_ns:
            self._evaluate(stamp_ns)

    def _evaluate(self, stamp_ns: int) -> None:
        settled = self.estimator.accurate_since_ns + round(LIMITS.settle * SECOND)
        stamps, rows = self._estimates.between(stamp_ns - ESTIMATES_KEPT + 1, stamp_ns + 1)
        outcomes = {'input': self._check_input(stamps, stamp_ns)}
        broken: list[Said] = []
        if stamp_ns - settled >= SECOND:
            first = np.searchsorted(stamps, settled)
            stamps, rows = stamps[first:], rows[first:]
            if len(rows):
                outcomes['observability'] = self._check_observability(stamps, rows)
                outcome = self._check_prediction_error(stamps, rows, stamp_ns)
                broken, values = self._check_rows(settled, stamp_ns)
                outcomes['prediction error'] = replace(
                    outcome, values={**outcome.values, **values})
                outcomes['covariance'] = self._check_covariance(rows)
                outcomes['model'] = self._check_model(outcomes, stamp_ns)
            else:
                self._withdraw(NO_ESTIMATES)
        self._end_windows(outcomes, bool(broken))
        debounced = {name: self._alarms[name].judge(outcome, stamp_ns)
                     for name, outcome in outcomes.items()}
        if 'prediction error' in debounced:
            debounced['prediction error'] = joined([debounced['prediction error'], *(
                alarm.standing() for alarm in self._row_alarms if alarm.judged)])
        if 'model' in debounced:
            level, since_ns = self.model_lasts
            debounced['model'] = replace(debounced['model'], values={
                **debounced['model'].values, 'holds': int(level == Level.OK),
                'since': when(since_ns)})
        self.outcomes = {**self.outcomes, **debounced}

    def _check_input(self, stamps: Integers, stamp_ns: int) -> Outcome:
        new = self.counts - self._last_counts
        self._last_counts = self.counts.copy()
        if not self.parameters.arm_joint:
            new[sample_loop.ARM_MISSING] = 0
        refused = {name: count for name, count in _by_reason(new).items() if name in REFUSALS}
        if any(refused.values()):
            self._said['last_refusal'] = max(refused, key=lambda name: refused[name])
        second = stamps[np.searchsorted(stamps, stamp_ns - SECOND, 'right'):]
        values = {
            **{observability.key_of(reason): count
               for reason, count in _by_reason(self.counts).items()},
            **self._said, 'samples': self.input_count,
            'rate_hz': float(len(second)),
            'longest_gap_s': float(np.diff(second).max() * 1e-9) if len(second) > 1 else 0.0}
        return observability.judge_input(_by_reason(new), int(new[sample_loop.ESTIMATE]), values)

    def _check_observability(self, stamps: Integers, rows: Array) -> Outcome:
        rows = rows[-_count_after(stamps, int(stamps[-1]), LIMITS.information_window):]
        # Whether the torque can be seen, not its curve: by the equations of the random walk.
        names = [name for i, name in enumerate(self.estimator.names)
                 if i <= TAU_K or name in STATE_COLUMNS]
        measured = np.ascontiguousarray(np.isfinite(rows[:, INNOVATIONS]))
        packed = self.estimator.packed_in_use.copy()
        packed[P0 + TAU_K] = self.parameters.p0_std_torque ** 2
        states = np.ascontiguousarray(
            rows[:, [STATE_COLUMNS.get(name, i) for i, name in enumerate(names)]])
        shares = observability.information_share(
            states, np.ascontiguousarray(rows[:, sample_loop.E_DT]), measured, packed)
        stated = middle(rows[:, sample_loop.E_TAU_K_NOISE_STD]) / self.parameters.p0_std_torque
        return observability.check(dict(zip(names, shares.tolist())), stated,
                                   observability.paper(states[-1], measured[-1], packed))

    def _check_prediction_error(self, stamps: Integers, rows: Array, stamp_ns: int) -> Outcome:
        for_mean, newest = (_count_after(stamps, stamp_ns, window)
                            for window in (LIMITS.mean_window, 1.0))
        nis, dof, *pairs = (np.ascontiguousarray(rows[:, columns]) for columns in (
            sample_loop.E_NIS, sample_loop.E_DOF, WHITE, INNOVATIONS, INNOVATION_STDS))
        return innovation.check(pairs[0], nis, dof, pairs[1], pairs[2], for_mean, newest)

    def _check_rows(self, settled: int, stamp_ns: int) -> tuple[list[Said], dict[str, float]]:
        """
        Run ROW_CHECKS on the smoothed rows since `settled`; return (broken conditions, values).

        One that abstains moves its alarm neither way.
        """
        broken: list[Said] = []
        values: dict[str, float] = {}
        if not len(self._rows) or not self.parameters.arm_joint:
            return broken, values
        for check, alarm, counts, kept in zip(
                ROW_CHECKS, self._row_alarms, self._row_counts, self._row_values):
            if check.free_torque and self.parameters.tau_k_model in CURVES:
                continue
            begin = max(settled, stamp_ns - round(check.window * SECOND))
            rows = thinned(self._rows.after(begin))
            before = [found for stamp, found in kept if stamp <= begin][-check.earlier:]
            result = check.check(rows[self._certain(rows)], self.estimator.drive,
                                 *([before] if check.earlier else []))
            counts[0] += 1
            if result is not None:
                counts[1] += 1
                is_whole = settled < begin and int(self._rows.stamps[0]) <= begin
                if is_whole and not (kept and begin < kept[-1][0] <= stamp_ns):
                    kept.append((stamp_ns, result[1]))
                alarm.judge(outcome_of(result[0], None, {}), stamp_ns)
                broken += result[0]
                values.update(result[1])
            values[f'{check.name}_evaluations'] = int(counts[0])
            values[f'{check.name}_results'] = int(counts[1])
        return broken, values

    def _check_covariance(self, rows: Array) -> Outcome:
        stated, std = (middle(rows[::MEDIAN_STRIDE, column]) for column in (
            sample_loop.E_STD + TAU_K, sample_loop.E_MOTOR_SIDE_NOISE_STD))
        if self._reference is None:
            self._references.append(std)
            if len(self._references) >= LIMITS.reference_evaluations:
                self._reference = float(np.median(self._references))
        return self._with_adaptation(innovation.judge_covariance(stated, std, self._reference))

    def _with_adaptation(self, outcome: Outcome) -> Outcome:
        """Return `outcome` with the adapted values; a warning if one is at its bound."""
        adapted = self.estimator.adapted()
        if not adapted:
            return outcome
        guards = self.estimator.adaptation_guards()
        values = {**outcome.values, **{f'adapted_{k}': v for k, v in adapted.items()},
                  **{f'adaptation_{k}': v for k, v in guards.items()}}
        bound = self.estimator.adapted_to_bound()
        if bound and outcome.level == Level.OK:
            return outcome_of([AT_BOUND.said(names=', '.join(bound))], None, values)
        return replace(outcome, values=values)

    def _check_model(self, outcomes: Outcomes, stamp_ns: int) -> Outcome:
        # Errors of a lost encoder or a broken stream say nothing about the model.
        judged = (outcomes['observability'].level < Level.ERROR
                  and outcomes['input'].level < Level.ERROR)
        systematic = judged and innovation.systematic(outcomes['prediction error'].values)
        self._systematic.add(stamp_ns, systematic)
        outcome = innovation.judge_model(
            self._systematic, stamp_ns, self.parameters.model_gap_after,
            self.estimator.drive.arm_load == 'unknown')
        values = self.estimator.learned_curve()
        broken = innovation.learned_curve(values, self.estimator.drive, self.parameters)
        values.update({f'undetected_{name}': error for name, error in
                       self.estimator.undetected_errors().items()})
        if broken:
            return with_more(outcome, broken, values)
        return replace(outcome, values={**outcome.values, **values})

    def _end_windows(self, outcomes: Outcomes, broken: bool) -> None:
        """
        Judge each window that has ended by now.

        broken: whether one of ROW_CHECKS speaks against the estimates now.
        """
        # Of samples that are lost their share counts, over the whole window.
        if broken or any(outcome.level > Level.OK for name, outcome in outcomes.items()
                         if name not in ('model', 'input')):
            self._window_flagged += 1
        if any(outcome.level > Level.OK for name, outcome in outcomes.items()
               if name not in {*DRIFT_SHOWS, 'input'}):
            self._window_broken += 1
        if 'prediction error' in outcomes:
            values = outcomes['prediction error'].values
            self._window_nis.append(values.get('nis_over_dof', 1.0))
        stamps = self._rows.stamps
        if not len(stamps):
            return
        begin = self._window_start
        if begin is None:
            begin = int(stamps[0])
        length = round(self.parameters.drift_window * SECOND)
        while stamps[-1] >= begin + length:
            end = begin + length
            if self._window_whole:
                self._window_ended(*self._rows.between(begin, end), end)
            # Windows without any row are left out.
            following = int(stamps[np.searchsorted(stamps, end)])
            begin += (following - begin) // length * length
            self._window_whole = True
            self._window_flagged = self._window_broken = 0
            self._window_nis, self._window_counts = [], self._lost_and_all()
        self._window_start = begin

    def _fitted(self, stamps: Integers, rows: Array, end: int
                ) -> features.Backlash | features.NotExcited:
        """Return the features of a window with `rows` [N] at `stamps` [N] that ends at `end`."""
        if self._hidden_arm is not None:
            return self._hidden_arm.fit(stamps, rows, end)
        window = features.fit(rows[self._certain(rows)], self.estimator.drive, end)
        if isinstance(window, features.NotExcited) and features.shows_motion(rows):
            lost_motion, std = features.lost_motion_of(rows)
            window = replace(window, lost_motion=lost_motion, lost_motion_std=std)
        return window

    def _window_ended(self, stamps: Integers, rows: Array, end: int) -> None:
        window = self._fitted(stamps, rows, end)
        judged = Window(window, self._trust(), self.temperature, self._comparable(),
                        self._counts_on)
        self.judged.append(judged)
        if isinstance(window, features.Backlash):
            self._counts_on = True
            self.windows.append(window)
        self.know(judge(self.health, judged))

    def _lost_and_all(self) -> tuple[int, int]:
        """Return how many samples were lost or bad so far, and how many there should have been."""
        counts = self.counts
        lost = sum(int(counts[code]) for code in LOST if code != sample_loop.ARM_MISSING
                   or self.parameters.arm_joint)
        return lost, self.input_count + int(counts[sample_loop.SAMPLES_MISSED])

    def _is_complete(self) -> bool:
        """Return whether the window that ends here has nearly all samples."""
        lost, count = (now - begin for now, begin in zip(
            self._lost_and_all(), self._window_counts))
        return lost <= LIMITS.missing_share * count

    def _certain(self, rows: Array) -> Flags:
        """Return which of `rows` [N, N_SMOOTHED] rest on both encoders."""
        # A twist less certain than from one reading of both: one of them was missing.
        packed = self.estimator.packed_in_use
        return rows[:, S_TWIST_NOISE_STD] ** 2 <= packed[R1] + packed[R2]

    def _trust(self) -> int:
        """Return the trust in the window that ends here, see health_record."""
        if self._hidden_arm is not None:  # its fit takes the readings, not the estimates
            return TRUSTED if self._is_complete() else AT_ODDS
        if self._window_flagged < LIMITS.debounce_up and self._is_complete() \
                and not self._alarmed(COMPONENTS[:3]):
            return TRUSTED
        larger = np.array(self._window_nis) / LIMITS.nis_high
        if (larger > 1.0).sum() < LIMITS.debounce_up:
            return AT_ODDS
        return ERRORS_LARGER - int(2.0 * np.log2(max(np.nan_to_num(np.median(larger)), 1.0)))

    def _comparable(self) -> bool:
        """
        Return whether the window that ends here may be compared with the baseline.

        A change of friction or of the gearbox shows in the prediction errors, too; it must not
        hide behind them.
        """
        return (self._hidden_arm is None and self._window_broken < LIMITS.debounce_up
                and self._is_complete()
                and not self._alarmed(set(COMPONENTS[:3]) - DRIFT_SHOWS))

    def _alarmed(self, names: Iterable[str]) -> bool:
        return any(self._alarms[name].since_ns is not None
                   and self.outcomes[name].level > Level.OK for name in names)


def _count_after(stamps: Integers, now_ns: int, window: float) -> int:
    """Return how many of `stamps` [W] lie in the last `window` s before `now_ns`."""
    return int(len(stamps) - np.searchsorted(stamps, now_ns - round(window * SECOND), 'right'))


def _by_reason(counts: Integers) -> dict[str, int]:
    """Return {reason: count} of `counts` int64 [N_COUNTS]."""
    return dict(zip(sample_loop.REASONS.values(), counts[REASON_CODES].tolist()))
