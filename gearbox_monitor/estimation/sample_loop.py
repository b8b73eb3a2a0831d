# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The loop over samples: check the stamp, step the filter, smooth. One kernel, live and offline.

Time comes only from the stamps. What is refused is counted under its reason, never lost silently.
"""
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.estimation.consider import (
    accompany, Companions, restart, variance_of, variances_of)
from gearbox_monitor.estimation.filter_kind import (
    Belief, filter_kind, places, Reading, record_size, Scratch, sensitivities)
from gearbox_monitor.estimation.process_model import (
    begin_curve, curve_count, EIGENVALUE, FRICTION_AT, K_P, learned_length, LOAD_AT, motor_side,
    P0, Q0, R1, R2, TAU_ARM, TAU_K, TAU_K_MODEL_STD, torque_of, WALKS, X1, X2, X3, X4)
from gearbox_monitor.estimation.rts_smoother import S_TAU_K_NOISE_STD, S_TAU_K_STD, smooth, Span
from gearbox_monitor.kernels.kernel import apart, entry, folded, inline, kernel
from gearbox_monitor.kernels.types import Array, Integers, Layout, Matrix, Vector
from gearbox_monitor.parameters import FILTER_NAMES
from gearbox_monitor.plant.drive import INVERSE_M2


class Chosen(NamedTuple):
    """A filter by its `number` in KINDS; a tuple, as these are folded where they are known."""

    number: int


KINDS = tuple(map(filter_kind, FILTER_NAMES))
CHOICES = {name: Chosen(i) for i, name in enumerate(FILTER_NAMES)}
# What became of a sample.
(ESTIMATE, START, ZERO_STAMP, DUPLICATE, BACKWARD, JUMP, NO_EFFORT, NO_MEASUREMENT, DIVERGED,
 POSITION_JUMP,
 # ... and what was noticed beside it.
 NON_FINITE, MOTOR_MISSING, ARM_MISSING, EFFORT_HELD, SAMPLES_MISSED, N_COUNTS) = range(16)
REASONS = {
    ZERO_STAMP: 'zero stamps', DUPLICATE: 'repeated stamps', BACKWARD: 'backward stamps',
    JUMP: 'stamps after a jump', NO_EFFORT: 'samples without effort',
    NO_MEASUREMENT: 'samples without measurement', DIVERGED: 'filter restarts after divergence',
    POSITION_JUMP: 'positions that jump',
    NON_FINITE: 'values that are infinite or beyond 1e9', MOTOR_MISSING: 'missing motor positions',
    ARM_MISSING: 'missing arm positions', EFFORT_HELD: 'missing efforts',
    SAMPLES_MISSED: 'samples missed (by stamps)', START: 'starts',
}

# Integers that a stream carries from sample to sample; estimates depend on those before
# STOP_AT.
# STARTED is the stamp since when estimates are as good as stated.
(LAST, PENDING_STAMP, PENDING_COUNT, LAST_EFFORT, LAST_MEASUREMENT, STEPS, STARTED, JUMPS,
 STOP_AT, SMOOTH_NEXT, INPUTS, N_GATE) = range(12)
# Numbers that a stream carries: usual distance of stamps (s), and how large the prediction errors
# of motor and arm usually get (rad).
# ... and of a load by a description of the robot: 0 before the first, NEW_PAYLOAD where the next
# one has another payload, else 1 + the variance of what may not have been taken over yet.
# ... and of tau_K: what innovations moved it by and were expected to (variance) in the present
# stretch, the number of stretches, and the mean ratio of both in squares, less 1, of the last
# moments and of the last while.
(PERIOD, ERROR_MOTOR, ERROR_ARM, DESCRIBED, MOVED, EXPECTED, STRETCHES, NOW, WHILE,
 N_CLOCK) = range(10)
SECOND = 1_000_000_000
NEW_PAYLOAD = -1.0  # at DESCRIBED
TRANSFER = 0.05  # s in which a robot takes over a payload, or sets it down: 1 / e is left
NEVER = -1  # at STOP_AT: no evaluation is due
# A jump of the clock, or of a position, is believed when this many samples follow it consistently.
CONFIRM = 3
# Stamps so little before the last one (ns) are late messages, unless so many come in a row.
LATE, LATE_CONFIRM = SECOND // 4, 25
# What is beyond, in rad or N m, is no measurement.
HUGE = 1e9
# Longer without samples, torque or positions (ns, and in usual distances of samples), prediction
# misses by more than its stated deviation says: what follows is not judged.
BRIDGED, BRIDGED_PERIODS = 30_000_000, 2.5
# A position jumps that is farther from its prediction than all of: so many times what is usual,
# or twice the stated noise; so many predicted standard deviations. For so many samples after a
# start what is usual is not known: then it must be ten times as far.
JUMP_USUAL, JUMP_STATED, JUMP_SETTLED, UNSETTLED = 10.0, 6.0, 100, 10.0
N_EFFORTS = 64
# Stretches of the two means of what tau_K wanders, see _watch.
MOMENTS, LONG = 25.0, 500.0

# Columns of an estimate row. Absent states are NaN.
(E_X1, E_X2, E_X3, E_X4, E_TAU_K, E_TAU_ARM, E_TAU_E, E_STD) = range(8)
E_TWIST = E_STD + 7
(E_TWIST_RATE, E_TWIST_STD, E_TWIST_RATE_STD, E_INNOVATION_MOTOR, E_INNOVATION_ARM,
 E_INNOVATION_STD_MOTOR, E_INNOVATION_STD_ARM, E_WHITE_1, E_WHITE_2, E_NIS, E_LOGLIK, E_DOF,
 E_DT, E_U, E_LOAD, E_INNOVATION_COVARIANCE,
 # ... of the curve, where it is learnt: stiffness, N m/rad, half gap and hysteresis, rad.
 E_STIFFNESS, E_HALF_GAP, E_HYSTERESIS, E_STIFFNESS_STD, E_HALF_GAP_STD, E_HYSTERESIS_STD,
 # Standard deviation of tau_K by noise alone: the filter's own, with an exact model.
 E_TAU_K_NOISE_STD, E_READING_MOTOR,
 # ... of tau_K and the friction's error together, see rts_smoother.S_MOTOR_SIDE.
 E_MOTOR_SIDE_NOISE_STD,
 # Probabilities of the models with a curve, where models are mixed (see model_bank).
 E_ELASTIC_WEIGHT, E_LEARNED_WEIGHT, N_ESTIMATE) = range(E_TWIST + 1, E_TWIST + 29)


class Stream(NamedTuple):
    """
    N samples: stamps int64 [N] ns; inputs [N, 2], motor torque and measured load on the arm, N m.

    Where a robot's description gives the load, inputs [N, 6]: also the load by it, its standard
    deviation (N m), the inertia of the arm (kg m^2) and the noise of the load ((N m)^2/s), see
    robot.dynamics.
    outputs [N, 2]: motor and arm position, rad. NaN = not measured.
    """

    stamps: Integers
    inputs: Matrix
    outputs: Matrix


def part_of(stream: Stream, start: int, end: int) -> Stream:
    """Return the samples from `start` to `end` of a `stream`: itself, if these are all."""
    if start == 0 and end == len(stream.stamps):
        return stream
    return Stream(stream.stamps[start:end], stream.inputs[start:end], stream.outputs[start:end])


class DescribedLoad(NamedTuple):
    """
    What a load by a robot's description depends on.

    time: correlation time of its errors, s; noise: spectral density of an unknown load, (N m)^2/s,
    torque_noise: that of tau_K.
    eigenvalue: of the drive with the arm's `inertia` (kg m^2) of its model, 1/s.
    """

    time: float
    noise: float
    torque_noise: float
    eigenvalue: float
    inertia: float


MEASURED = DescribedLoad(0.0, 0.0, 0.0, 0.0, 0.0)


class LoopSettings(NamedTuple):
    """
    What a run depends on besides its numbers.

    filter: see CHOICES; max_gap: longest time between stamps that is bridged, ns; delay: of
    the effort, samples; lag: of the smoother, ns, 0 = none; load_measured: whether the load on the
    arm is an input; narrow: whether less deviation of tau_K is stated where it wanders less than
    it may; described: of a load by a robot's description, MEASURED where there is none.
    """

    filter: Chosen
    max_gap: int
    delay: int
    lag: int
    load_measured: bool
    narrow: bool
    described: DescribedLoad = MEASURED


class LoopState(NamedTuple):
    """
    What a stream carries from sample to sample; all arrays are changed in place.

    gate int64 [N_GATE]; counts int64 [N_COUNTS], how often each code came; clock [N_CLOCK];
    efforts [N_EFFORTS, 2], the last inputs; ring [M, record_size(n, c)], step records, and their
    ring_stamps int64 [M]; saved [n + n * n + memory], the belief before the step (scratch);
    companions: the c of them.
    """

    gate: Integers
    counts: Integers
    clock: Vector
    efforts: Matrix
    ring: Matrix
    ring_stamps: Integers
    saved: Vector
    companions: Companions


class Output(NamedTuple):
    """
    What a run writes.

    codes int64 [N]: what became of each sample; estimates [N, N_ESTIMATE], rows whose code is
    ESTIMATE; smoothed_stamps int64 and smoothed [L, N_SMOOTHED], L as many as samples plus the
    ring's length.
    """

    codes: Integers
    estimates: Matrix
    smoothed_stamps: Integers
    smoothed: Matrix


@inline
def filter_step(chosen: Chosen, layout: Layout, belief: Belief, reading: Reading, p: Array,
                scratch: Scratch, record: Array) -> bool:
    """
    Take the step of a filter.

    Args:
        chosen: the filter.
        layout: as of ekf.step.
        belief: as of ekf.step.
        reading: as of ekf.step.
        p: as of ekf.step.
        scratch: as of ekf.step.
        record: as of ekf.step.

    Returns:
        False if it diverged.

    """
    for i, kind in enumerate(KINDS):
        if chosen.number == i and (layout.curve < 0 or len(kind.tau_k_models) > 1):
            return kind.step(layout, belief, reading, p, scratch, record)
    return False


@inline
def _resume(chosen: Chosen, memory: Array) -> None:
    """Prepare the `memory` of the `chosen` filter for a start."""
    for i, kind in enumerate(KINDS):
        if chosen.number == i:
            kind.resume(memory)


@inline
def in_use(chosen: Chosen, memory: Array, p: Array) -> Array:
    """Return FilterKind.in_use of the `chosen` filter for its `memory` and `p`."""
    for i, kind in enumerate(KINDS):
        if chosen.number == i:
            return kind.in_use(memory, p)
    return p


@kernel
def _gate(stamp: int, gate: Integers, max_gap: int) -> int:
    """Return what to do with a sample stamped `stamp` (ns): ESTIMATE, START or a refusal."""
    if stamp <= 0:
        return ZERO_STAMP
    last = gate[LAST]
    if last == 0:
        return START
    elapsed = stamp - last
    if elapsed == 0:
        return DUPLICATE
    if 0 < elapsed <= max_gap:
        gate[PENDING_COUNT] = 0
        return ESTIMATE
    beyond = stamp - gate[PENDING_STAMP]
    if gate[PENDING_COUNT] > 0 and 0 < beyond <= max_gap:
        gate[PENDING_COUNT] += 1
    else:
        gate[PENDING_COUNT] = 1
    gate[PENDING_STAMP] = stamp
    if gate[PENDING_COUNT] >= (LATE_CONFIRM if -LATE < elapsed < 0 else CONFIRM):
        return START
    return BACKWARD if elapsed < 0 else JUMP


@entry
def _stamp_codes(stamps: Integers, max_gap: int, codes: Integers, gate: Integers) -> None:
    """Write what `_gate` says of each of `stamps` to `codes`."""
    for k in range(stamps.shape[0]):
        codes[k] = _gate(stamps[k], gate, max_gap)
        if codes[k] == START:
            gate[PENDING_COUNT] = 0
        if codes[k] == ESTIMATE or codes[k] == START:
            gate[LAST] = stamps[k]


def stamp_codes(stamp_ns: Integers, max_gap: float) -> Integers:
    """
    Return what becomes of samples by their stamps alone: ESTIMATE, START or a refusal.

    Args:
        stamp_ns: int64 [N].
        max_gap: longest time between stamps that is bridged, s.
    """
    codes: Integers = np.zeros(len(stamp_ns), np.int64)
    gate = np.zeros(N_GATE, np.int64)
    _stamp_codes(stamp_ns.astype(np.int64), round(max_gap * 1e9), codes, gate)
    return codes


@kernel
def _stops(stamp: int, gate: Integers) -> bool:
    at = gate[STOP_AT]
    return at != NEVER and (at == 0 or stamp >= at or stamp < at - SECOND)


@inline
def _described(described: DescribedLoad, measured: float, row: Array,
               at: tuple[int, float], state: LoopState, layout: Layout, belief: Belief,
               p: Array) -> float:
    """
    Return the load on the arm by a robot's description, which sets what p has of the arm.

    The state tau_arm is what the load differs by, an Ornstein-Uhlenbeck process with the stated
    deviation and the noise of the load; here it decays over the step, its noise comes with that
    of the others. Without a value, the last load goes on and the state is an unknown load; with
    the next value it takes over what that differs by. With a new payload the load may jump by as
    much at any moment of the TRANSFER, and tau_K follow it.

    Args:
        described: of a time 0: there is no description; the load is `measured`.
        measured: N m.
        row: of the inputs, see Stream.
        at: place of this sample in the efforts of `state`, and the length of the step, s.
        state: takes the load.
        layout: as of ekf.step.
        belief: before the step, changed.
        p: as of ekf.step, changed.

    """
    if described.time == 0.0:
        return measured
    (place, dt), efforts, clock = at, state.efforts, state.clock
    last = efforts[place - 1, 1]
    load, deviation, inertia, noise = row[2], row[3], row[4], row[5]
    if not math.isfinite(load):
        p[Q0 + TAU_ARM], clock[DESCRIBED] = described.noise, 0.0
        p[Q0 + TAU_K] = described.torque_noise
        load = last
    else:
        if clock[DESCRIBED] == 0.0:
            belief.z[TAU_ARM] += last - load
        elif layout.curve < 0:
            belief.z[TAU_K] += load - last
        n, share = belief.z.shape[0], math.exp(-dt / described.time)
        if clock[DESCRIBED] <= 0.0:
            jump = clock[DESCRIBED] * (load - last)
            variance = jump * jump
            clock[DESCRIBED] = 1.0 + variance
            belief.P[TAU_ARM * n + TAU_ARM] += variance
        variance = clock[DESCRIBED] - 1.0
        clock[DESCRIBED] = 1.0 + math.exp(-2.0 * dt / TRANSFER) * variance
        belief.z[TAU_ARM] *= share
        for i in range(n):
            belief.P[i * n + TAU_ARM] *= share
            belief.P[TAU_ARM * n + i] *= share
        for i in range(state.companions.number):
            state.companions.s[i * n + TAU_ARM] *= share
        p[Q0 + TAU_ARM] = variance / dt + noise + min(
            described.noise, 2.0 * deviation * deviation / described.time)
        if layout.curve < 0:
            p[Q0 + TAU_K] = described.torque_noise + variance / TRANSFER
        p[INVERSE_M2] = 1.0 / inertia
        p[EIGENVALUE] = described.eigenvalue * max(1.0, described.inertia / inertia)
    efforts[place, 1] = load
    return load


@inline
def _save(belief: Belief, saved: Array) -> None:
    z, P, memory = belief
    n, m = z.shape[0], z.shape[0] + P.shape[0]
    saved[:n], saved[n:m], saved[m:] = z, P, memory


@inline
def _put_back(belief: Belief, saved: Array) -> None:
    z, P, memory = belief
    n, m = z.shape[0], z.shape[0] + P.shape[0]
    z[:], P[:], memory[:] = saved[:n], saved[n:m], saved[m:]


@inline
def jumps(error: float, variance: float, usual: float, r: float, step: int) -> bool:
    """
    Return whether a position jumps.

    Args:
        error: innovation, rad.
        variance: its predicted variance, rad^2.
        usual: see usually.
        r: variance of the encoder, rad^2.
        step: number of steps since a start.

    """
    limit = max(JUMP_USUAL * max(usual, 2.0 * math.sqrt(r)), JUMP_STATED * math.sqrt(variance))
    return abs(error) > (limit if step > JUMP_SETTLED else UNSETTLED * limit)


@inline
def usually(error: float, usual: float) -> float:
    """
    Return how large errors usually get, after another `error` (rad): about 2.3 deviations.

    usual: as it was before, 0.0 at a start.
    """
    size = abs(error)
    if not math.isfinite(size):
        return usual
    if usual == 0.0:
        return size
    return usual + 0.25 * (size - usual) if size > usual else 0.999 * usual


@entry
def start(layout: Layout, belief: Belief, y1: float, y2: float, p: Vector, record: Vector) -> None:
    """
    Set the mean and covariance of a belief from the first readings.

    Args:
        layout: as of ekf.step.
        belief: as of ekf.step.
        p: as of ekf.step.
        record: as of ekf.step.
        y1: motor and arm position, rad; NaN = not measured.
        y2: motor and arm position, rad; NaN = not measured.

    """
    n, z, P = layout.n, belief.z, belief.P
    have1, have2 = math.isfinite(y1), math.isfinite(y2)
    for i in range(n):
        z[i] = 0.0
        for j in range(n):
            P[i * n + j] = p[P0 + i] if i == j else 0.0
    z[X1] = y1 if have1 else y2
    z[X2] = y2 if have2 else y1
    # A joint that was not measured can be a few turns away.
    if not have1:
        P[X1 * n + X1] = 100.0
    if not have2:
        P[X2 * n + X2] = 100.0
    begin_curve(layout, z, p)
    _, _, _, at_z, at_P, _, _, _, _ = places(n)
    record[at_z:at_z + n], record[at_P:at_P + n * n] = z, P
    record[record_size(n) - 1:-1] = 0.0


@inline
def first_speed(moved: float, dt: float, variance: float, prior: float) -> float:
    """
    Return the mean of a speed that the first step starts from, rad/s.

    The speed at a start is unknown, and friction is steep where it is 0: linearised there, an EKF
    would hold on to it. A wide prior leaves no other trace of its mean.

    Args:
        moved: position after the first step less that at the start, rad; NaN = not measured.
        dt: length of the step, s.
        variance: of `moved` by noise, rad^2.
        prior: variance of the speed at a start, rad^2/s^2.

    """
    if not math.isfinite(moved):
        return 0.0
    return prior / (prior + variance / (dt * dt)) * moved / dt


@inline
def aim(layout: Layout, belief: Belief, reading: Reading, p: Array) -> None:
    """
    Set the means of the speeds before the first step, see first_speed.

    Args:
        layout: as of ekf.step.
        belief: as of a start, changed in place.
        reading: of the first step.
        p: as of ekf.step.

    """
    n, z, P, dt = layout.n, belief.z, belief.P, reading.dt
    z[X3] = first_speed(reading.y1 - z[X1], dt, P[X1 * n + X1] + p[R1], P[X3 * n + X3])
    z[X4] = first_speed(reading.y2 - z[X2], dt, P[X2 * n + X2] + p[R2], P[X4 * n + X4])


@inline
def write_innovation(row: Array, e1: float, e2: float, s11: float, s12: float,
                     s22: float) -> None:
    """
    Write the innovation of an estimate, whitened too.

    Args:
        row: of the estimate.
        e1: innovation of the motor, rad; NaN = not measured.
        e2: innovation of the arm, rad; NaN = not measured.
        s11: predicted variance of e1, rad^2.
        s12: predicted covariance, rad^2.
        s22: predicted variance of e2, rad^2.

    """
    row[E_INNOVATION_MOTOR], row[E_INNOVATION_ARM] = e1, e2
    row[E_INNOVATION_COVARIANCE] = s12
    row[E_INNOVATION_STD_MOTOR], row[E_INNOVATION_STD_ARM] = math.sqrt(s11), math.sqrt(s22)
    # Whitened by the Cholesky factor of S; with one measurement, by its own deviation.
    have1, have2 = math.isfinite(e1), math.isfinite(e2)
    row[E_WHITE_1] = e1 / math.sqrt(s11) if have1 else math.nan
    row[E_WHITE_2] = math.nan
    if have1 and have2:
        row[E_WHITE_2] = (e2 - s12 / math.sqrt(s11) * row[E_WHITE_1]) / math.sqrt(
            (s11 * s22 - s12 * s12) / s11)
    elif have2:
        row[E_WHITE_2] = e2 / math.sqrt(s22)


@inline
def _watch(n: int, record: Array, clock: Array) -> None:
    """
    Take into `clock` how far a step moved tau_K (`record`, of `n` states) against what it was to.

    Innovations of a filter whose model holds are white: what they move tau_K by in a stretch has
    the sum of their variances. Where tau_K wanders less than q_std_tau_k lets it, they take back
    what they moved. A stretch ends when that sum is twice the variance of tau_K: by then, noise
    of the encoders adds to it what it adds to the error.
    """
    at_pred, at_P_pred, _, at_z, at_P, _, _, _, _ = places(n)
    place = TAU_K * n + TAU_K
    clock[MOVED] += record[at_z + TAU_K] - record[at_pred + TAU_K]
    clock[EXPECTED] += record[at_P_pred + place] - record[at_P + place]
    if clock[EXPECTED] > 2.0 * record[at_P + place]:
        excess = clock[MOVED] * clock[MOVED] / clock[EXPECTED] - 1.0
        clock[NOW] += (excess - clock[NOW]) / MOMENTS
        clock[STRETCHES] += 1.0
        clock[WHILE] += (excess - clock[WHILE]) / min(MOMENTS + clock[STRETCHES], LONG)
        clock[MOVED] = clock[EXPECTED] = 0.0


@inline
def noise_share(clock: Array) -> float:
    """Return the share of the stated variance of tau_K by noise that is there, at most 1."""
    return max(min(1.0 + max(clock[NOW], clock[WHILE]), 1.0), 0.0)


@folded(*WALKS)
@apart
def _write_estimate(layout: Layout, belief: Belief, record: Array, reading: Reading, p: Array,
                    share: float, row: Array) -> None:
    n, z, P = layout.n, belief.z, belief.P
    count, _, at_s, _ = sensitivities(n, record.shape[0])
    off = count, at_s
    row[:E_STD + 7] = math.nan
    for i in range(4):
        row[i] = z[i]
        row[E_STD + i] = math.sqrt(P[i * n + i] + variance_of(n, record, off, i))
    of_twist, of_rate, of_torque = variances_of(layout, z, record, off, p)
    row[E_TAU_K], variance = torque_of(layout, z, P, p)
    row[E_TAU_K_NOISE_STD] = math.sqrt(variance)
    row[E_MOTOR_SIDE_NOISE_STD] = math.sqrt(
        max(motor_side(z, P, (row[E_TAU_K], variance), p)[1], 0.0))
    row[E_STD + TAU_K] = math.sqrt(
        share * variance + of_torque + p[TAU_K_MODEL_STD] * p[TAU_K_MODEL_STD])
    row[E_ELASTIC_WEIGHT] = row[E_LEARNED_WEIGHT] = math.nan
    row[E_STIFFNESS:E_HYSTERESIS_STD + 1] = math.nan
    if curve_count(layout.curve) > 1:
        at = n - 3
        row[E_STIFFNESS], row[E_STIFFNESS_STD] = z[at], math.sqrt(P[at * n + at])
        row[E_HALF_GAP], row[E_HALF_GAP_STD] = learned_length(z, P, n, n - 2)
        row[E_HYSTERESIS], row[E_HYSTERESIS_STD] = learned_length(z, P, n, n - 1)
    if p[LOAD_AT] > 0.0:
        i = int(p[LOAD_AT])
        row[E_TAU_ARM] = z[i] + reading.load
        row[E_STD + E_TAU_ARM] = math.sqrt(P[i * n + i] + variance_of(n, record, off, i))
    if p[FRICTION_AT] > 0.0:
        i = int(p[FRICTION_AT])
        row[E_TAU_E] = z[i]
        row[E_STD + E_TAU_E] = math.sqrt(P[i * n + i] + variance_of(n, record, off, i))
    row[E_TWIST] = z[X1] - z[X2]
    row[E_TWIST_RATE] = z[X3] - z[X4]
    row[E_TWIST_STD] = math.sqrt(
        max(P[X1 * n + X1] + P[X2 * n + X2] - 2.0 * P[X1 * n + X2], 0.0) + of_twist)
    row[E_TWIST_RATE_STD] = math.sqrt(
        max(P[X3 * n + X3] + P[X4 * n + X4] - 2.0 * P[X3 * n + X4], 0.0) + of_rate)
    _, _, _, _, _, at_innovation, at_S, _, at_scores = places(n)
    e1, e2 = record[at_innovation], record[at_innovation + 1]
    s11, s12, s22 = record[at_S], record[at_S + 1], record[at_S + 2]
    write_innovation(row, e1, e2, s11, s12, s22)
    row[E_NIS], row[E_LOGLIK] = record[at_scores], record[at_scores + 1]
    row[E_DOF] = record[at_scores + 2]
    row[E_DT], row[E_U], row[E_LOAD] = reading.dt, reading.u, reading.load
    row[E_READING_MOTOR] = reading.y1


@entry
def run(layout: Layout, settings: LoopSettings, p: Vector, stream: Stream, state: LoopState,
        belief: Belief, scratch: Scratch, output: Output) -> tuple[int, int]:
    """
    Take up to N samples.

    Stops after each start and each sample that a long gap was bridged to; after the sample in
    time, accepted or incomplete, at which a stop is due: the first one, the first at or after
    gate[STOP_AT], and one from before the second that leads up to it (a new time); and after one
    at which the filter diverged, the belief as it then is.

    Args:
        layout: as of ekf.step; scratch.matrices [>= 5, n * n].
        p: as of ekf.step; scratch.matrices [>= 5, n * n].
        belief: as of ekf.step; scratch.matrices [>= 5, n * n].
        scratch: as of ekf.step; scratch.matrices [>= 5, n * n].
        settings: constant during a run.
        stream: the samples.
        state: carried from call to call.
        output: written.

    Returns:
        (number of samples taken, rows written to output.smoothed)

    """
    stamps, inputs, outputs = stream
    chosen, max_gap, delay, lag, load_measured, narrow, described = settings
    gate, counts, clock, efforts, ring, ring_stamps, saved, companions = state
    codes, estimates, smoothed_stamps, smoothed = output
    memory = belief.memory
    rows = ring.shape[0]
    _, _, _, _, _, at_innovation, at_S, _, _ = places(layout.n)
    n_smoothed = 0
    for k in range(stamps.shape[0]):
        stamp = stamps[k]
        gate[INPUTS] += 1
        u, load, y1, y2 = inputs[k, 0], inputs[k, 1], outputs[k, 0], outputs[k, 1]
        if abs(u) > HUGE or abs(load) > HUGE or abs(y1) > HUGE or abs(y2) > HUGE:
            counts[NON_FINITE] += 1
            u, load = u if abs(u) <= HUGE else math.nan, load if abs(load) <= HUGE else math.nan
            y1, y2 = y1 if abs(y1) <= HUGE else math.nan, y2 if abs(y2) <= HUGE else math.nan
        have_y = math.isfinite(y1) or math.isfinite(y2)
        code = _gate(stamp, gate, max_gap)
        if code == ESTIMATE or code == START:
            if code == START:
                gate[LAST_MEASUREMENT], gate[LAST_EFFORT] = stamp, stamp
            if not math.isfinite(y1):
                counts[MOTOR_MISSING] += 1
            if not math.isfinite(y2):
                counts[ARM_MISSING] += 1
            have_u = math.isfinite(u) and (not load_measured or math.isfinite(load))
            if not have_u:
                counts[EFFORT_HELD] += 1
                if code == START or stamp - gate[LAST_EFFORT] > max_gap:
                    code = NO_EFFORT
            elif not have_y and (code == START or stamp - gate[LAST_MEASUREMENT] > max_gap):
                code = NO_MEASUREMENT
            if code == NO_EFFORT or code == NO_MEASUREMENT:
                gate[LAST] = 0  # restart with the next complete sample
                gate[PENDING_COUNT] = 0
        counts[code] += 1
        codes[k] = code
        if code != ESTIMATE and code != START:
            if (code == NO_EFFORT or code == NO_MEASUREMENT) and _stops(stamp, gate):
                return k + 1, n_smoothed
            continue
        if have_u:
            gate[LAST_EFFORT] = stamp
        if have_y:
            gate[LAST_MEASUREMENT] = stamp
        if code == START:
            gate[LAST], gate[STEPS], gate[PENDING_COUNT] = stamp, 0, 0
            gate[SMOOTH_NEXT], gate[JUMPS] = 0, 0
            clock[:] = 0.0
            for i in range(N_EFFORTS):
                efforts[i, 0], efforts[i, 1] = u, load if load_measured else 0.0
            gate[STARTED] = stamp
            start(layout, belief, y1, y2, p, ring[0])
            ring[0, -1] = u
            _resume(chosen, memory)
            restart(companions)
            ring_stamps[0] = stamp
            return k + 1, n_smoothed
        last = gate[LAST]
        dt = (stamp - last) * 1e-9
        step = gate[STEPS] + 1
        place, previous = step % N_EFFORTS, (step - 1) % N_EFFORTS
        efforts[place, 0] = u if math.isfinite(u) else efforts[previous, 0]
        efforts[place, 1] = load if math.isfinite(load) else efforts[previous, 1]
        acting = (step - 1 - delay) % N_EFFORTS
        u_acting = efforts[acting, 0]
        _save(belief, saved)
        load = _described(described, efforts[acting, 1] if load_measured else 0.0, inputs[k],
                          (place, dt), state, layout, belief, p)
        reading = Reading(dt, u_acting, load, y1, y2)
        record = ring[step % rows]
        record[at_innovation], record[at_innovation + 1] = 0.0, 0.0
        record[at_S], record[at_S + 2] = 0.0, 0.0
        if step == 1:
            aim(layout, belief, reading, p)
        good = filter_step(chosen, layout, belief, reading, p, scratch, record)
        e1, e2 = record[at_innovation], record[at_innovation + 1]
        if (jumps(e1, record[at_S], clock[ERROR_MOTOR], p[R1], step)
                or jumps(e2, record[at_S + 2], clock[ERROR_ARM], p[R2], step)):
            # As if it had not come; the belief stays.
            _put_back(belief, saved)
            codes[k] = POSITION_JUMP
            counts[ESTIMATE] -= 1
            counts[POSITION_JUMP] += 1
            gate[JUMPS] += 1
            if gate[JUMPS] >= CONFIRM:
                gate[LAST] = 0  # restart with the next complete sample
                gate[PENDING_COUNT] = 0
            continue
        gate[LAST], gate[STEPS], gate[JUMPS] = stamp, step, 0
        # Follow the usual period robustly, so that a dropout does not move it.
        if clock[PERIOD] == 0.0:
            clock[PERIOD] = dt
        else:
            if dt > 1.7 * clock[PERIOD]:
                counts[SAMPLES_MISSED] += int(dt / clock[PERIOD] + 0.5) - 1
            clock[PERIOD] *= 1.02 if dt > clock[PERIOD] else 1.0 / 1.02
        bridged = stamp - min(last, gate[LAST_EFFORT], gate[LAST_MEASUREMENT])
        in_doubt = bridged > BRIDGED and bridged > BRIDGED_PERIODS * SECOND * clock[PERIOD]
        if in_doubt:
            gate[STARTED] = stamp
        ring_stamps[step % rows] = stamp
        good = good and accompany(layout, companions, saved, reading,
                                  in_use(chosen, memory, p), record)
        if not good:
            codes[k] = DIVERGED
            counts[ESTIMATE] -= 1
            counts[DIVERGED] += 1
            gate[LAST] = 0
            memory[:] = 0.0  # what was adapted may be why
            return k + 1, n_smoothed
        clock[ERROR_MOTOR] = usually(e1, clock[ERROR_MOTOR])
        clock[ERROR_ARM] = usually(e2, clock[ERROR_ARM])
        record[-1] = u_acting
        if narrow and layout.curve < 0 and p[K_P] == 0.0:  # tau_K is a random walk
            _watch(layout.n, record, clock)
        share = noise_share(clock)
        _write_estimate(layout, belief, record, reading, p, share, estimates[k])
        # Blocks end where stamps cross a grid, or steps half a ring (no row may be lost, even at
        # the price of a shorter lag): this depends on no history, so replay cuts the same blocks.
        half = step % (rows // 2) == 0
        if lag > 0 and (half or stamp * 2 // lag != last * 2 // lag):
            oldest = gate[SMOOTH_NEXT]
            keep = max(oldest - 1, step - rows // 2) if half else oldest - 1
            while keep < step and ring_stamps[(keep + 1) % rows] <= stamp - lag:
                keep += 1
            if keep >= oldest:
                smooth(layout, ring, Span(step, oldest, keep), p, scratch.vectors[0],
                       scratch.matrices, smoothed[n_smoothed:])
                for i in range(oldest, keep + 1):
                    smoothed_stamps[n_smoothed] = ring_stamps[i % rows]
                    # By the root of the share, as `benchmarks trust --tolerances` showed: beside
                    # less noise, errors of the model come in bursts.
                    if share < 1.0:
                        row = smoothed[n_smoothed]
                        row[S_TAU_K_STD] = math.sqrt(max(
                            row[S_TAU_K_STD] * row[S_TAU_K_STD]
                            - (1.0 - math.sqrt(share))
                            * (row[S_TAU_K_NOISE_STD] * row[S_TAU_K_NOISE_STD]), 0.0))
                    n_smoothed += 1
                gate[SMOOTH_NEXT] = keep + 1
        if in_doubt or _stops(stamp, gate):
            return k + 1, n_smoothed
    return stamps.shape[0], n_smoothed
