# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What an even segment of a recording says of encoders, motion, signs and torque, check by check.

The torque is checked by how the motor's acceleration answers to it: its sign and its delay.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.estimation.noise_search import at_rest
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.parameters import ESTIMATOR
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import percent, Quantity, said
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, Grade, hurts, judged, LIMITS, OK, WARN)
from gearbox_monitor.signals.uniform import (
    constant_runs, HALF_WIDTHS, missing_long, reversals, rms_of, SmoothedMotion, UniformRecording)

NAMES = ('motor', 'arm')
DELAYS = next(row for row in ESTIMATOR if row.name == 'effort_delay')
Noises: TypeAlias = Sequence[tuple[float, float] | None]
ROWS = 200_000


# --- each encoder for itself --------------------------------------------------------------------
def _for_diagnosis(values: Array, seconds: Array) -> Grade:
    """Return the Grade of the longest part without a gap of `values` [N] at `seconds` [N]."""
    missing = np.isnan(values)
    if missing.mean() <= LIMITS.max_repaired:
        return OK
    edges = np.flatnonzero(np.diff(missing_long(values), prepend=True, append=True))
    length, share = max(((seconds[end - 1] - seconds[begin], missing[begin:end].mean())
                         for begin, end in zip(edges[::2], edges[1::2])), default=(0.0, 1.0))
    few = length < 0.99 * LIMITS.min_duration or share > LIMITS.max_repaired
    return BAD if few else WARN


def measured(y: Array, seconds: Array, without_arm: bool = False) -> list[DataFinding]:
    """
    Return findings about readings that are missing.

    Args:
        y: readings of motor and arm [N, 2], rad.
        seconds: their stamps [N], s.
        without_arm: whether it is stated that the arm has no encoder.
    """
    findings = []
    for name, values in zip(NAMES, y.T):
        share, neither = float(np.isnan(values).mean()), bool(np.isnan(y).all())
        grade = (BAD if share > LIMITS.lost_many
                 else WARN if share > LIMITS.max_repaired else OK)
        code = 'readings' if share else 'all_readings'
        grades = hurts(min(grade, WARN), grade, _for_diagnosis(values, seconds))
        if share == 1.0 and without_arm and name == 'arm':
            code, grades = 'no_arm', hurts(WARN, WARN)
        elif share == 1.0:
            code = 'nothing_measured' if neither else 'never_measured'
            grades = hurts(BAD, BAD, BAD if neither else WARN)
        findings.append(judged(name, 'readings', said(code, percent=100.0 * share), grades,
                               {'missing_share': share}))
    return findings


def noise(stamps: Integers, y: Array, noises: Noises, swing: float | None,
          stated: Sequence[float]) -> list[DataFinding]:
    """
    Return findings about standstill, noise and resolution.

    Args:
        stamps: stamps [N], ns, increasing.
        y: readings [N, 2] as recorded, rad; NaN: not measured.
        noises: (noise, quantisation step) of each encoder, rad; None without readings.
        swing: swing of the twist, rad; None if unknown.
        stated: r_std_motor and r_std_arm of the estimator, rad.
    """
    channels = [i for i in (0, 1) if noises[i] is not None]
    rest = at_rest(stamps, y[:, [channels[0], channels[-1]]])
    seconds = 0.0 if rest is None else rest[1]
    findings = [judged('motion', 'standstill', said(
        'no_rest' if rest is None else 'rest', seconds=seconds), values={'rest_s': seconds})]
    for i in channels:
        sigma, quantum = noises[i] or (0.0, 0.0)
        code, values = 'noise', {'noise_rad': sigma, 'quantum_rad': quantum}
        if rest is not None:
            code, sigma = 'noise_at_rest', rest[0][channels.index(i)]
            values['noise_at_rest_rad'] = sigma
        right = stated[i] / LIMITS.noise_off <= sigma <= LIMITS.noise_off * stated[i]
        findings.append(judged(
            NAMES[i], 'noise', said(code, noise=sigma, throughout=values['noise_rad'],
                                    side=NAMES[i], stated=stated[i]),
            {} if right else hurts(WARN, WARN), values))
        if quantum > 0.0:
            coarse = swing is not None and quantum > LIMITS.swing_share * swing
            share = (said('of_swing', share=quantum / swing),) if swing else ()
            findings.append(judged(
                NAMES[i], 'resolution', said('resolution', step=quantum, swing=share),
                hurts(OK, WARN, WARN) if coarse else {}, values))
    return findings


def broken(part: UniformRecording, noises: Noises, model: DriveModel | None = None
           ) -> list[DataFinding]:
    """
    Return findings about readings that never change, stick or are clipped.

    Args:
        part: even samples.
        noises: (noise, quantisation step) of each encoder, rad; None without readings.
        model: model of the drive, None if unknown.
    """
    found = list[DataFinding]()
    for i in part.channels:
        own, opposite, dt = part.y[:, i], part.y[:, 1 - i], part.dt
        if np.ptp(own) == 0.0:
            found.append(judged(
                NAMES[i], 'sticks', said('frozen', side=NAMES[i], value=own[0]), everything(BAD),
                {'stuck_s': part.duration}, 'frozen'))
            continue
        if len(part.channels) < 2:
            continue
        starts, lengths = constant_runs(own)
        play = free_travel(part, noises, i, model)
        runs = [run for k in np.flatnonzero(lengths >= LIMITS.stuck_samples) if np.ptp(opposite[
            run := slice(starts[k], starts[k] + lengths[k])]) > play]
        if not runs:
            continue
        run, seconds = runs[0], sum(run.stop - run.start for run in runs) * dt
        fault = 'clipped' if own[run.start] in (own.min(), own.max()) else 'frozen'
        found.append(judged(
            NAMES[i], 'sticks', said(
                f'sticks_{fault}', side=NAMES[i], other=NAMES[1 - i],
                seconds=(run.stop - run.start) * dt, begin=part.begin + run.start * dt,
                travel=np.ptp(opposite[run])), everything(BAD), {'stuck_s': seconds}, fault))
    return found


def free_travel(part: UniformRecording, noises: Noises, i: int, model: DriveModel | None
                ) -> float:
    """
    Return how far (rad) the other side may go while encoder `i` gives one and the same reading.

    White noise never repeats itself; on a lattice, or without noise, a joint may rest while the
    other side crosses backlash and spring.

    Args:
        part: even samples.
        noises: (noise, quantisation step) of each encoder, rad.
        i: number of the encoder, 0 or 1.
        model: model of the drive, None if unknown.
    """
    own, opposite = noises[i], noises[1 - i]
    assert own is not None and opposite is not None
    sigma, quantum = own
    travel = 20.0 * opposite[0] + 2.0 * opposite[1]
    if quantum == 0.0 and sigma > np.finfo(np.float32).eps * np.ptp(part.y[:, i]):
        return travel
    # The twist is the drive's while a reading changes; while it sticks, the twist says nothing.
    lengths = constant_runs(part.y[:, i])[1]
    lives = np.repeat(lengths < LIMITS.stuck_samples, lengths)
    mixed = LIMITS.least_share <= lives.mean() < 1.0
    y = part.y[lives] if mixed else part.y
    low, high = np.percentile(y[:, 0] - y[:, 1], (5, 95) if mixed else (25, 75)) / (1.0 + mixed)
    free = 4.0 * float(high - low)
    if model is not None:
        t = model.transmission
        torque = 0.0 if np.isnan(part.torque).any() else float(np.ptp(part.torque))
        free = max(free, 4.0 * (t.half_gap + t.hysteresis_width)
                   + 2.0 * torque / max(t.stiffness, 1e-9))
        if model.driven_by == 'position':  # the backlash may be missing in the model file
            free = max(free, LIMITS.own_play * float(np.ptp(part.y, axis=0).max()))
    return travel + 2.0 * quantum + free


# --- motion -------------------------------------------------------------------------------------
def motion(moved: SmoothedMotion, half_gap: float | None, drift_window: float
           ) -> list[DataFinding]:
    """
    Return findings about how a drive moves.

    Args:
        moved: smoothed motion of the segment, all samples.
        half_gap: half backlash of the model, rad, or None.
        drift_window: window of the drift estimate, s.
    """
    part = moved.recording
    travels = [travel(moved, i) for i in part.channels]
    if any(line.hurts.get('estimation') for line in travels):
        return travels
    v, i = moved.v[:, moved.i], moved.i
    fast, rms = float(np.abs(v).max()), rms_of(v)
    speed = judged('motion', f'speed, {NAMES[i]}', said('speed', rms=rms, largest=fast),
                   values={'speed_rms': rms, 'speed_max': fast})
    found = [*travels, speed, reverses(moved)]
    if len(part.channels) == 2:
        found.append(_ratio(moved))
        if found[-1].verdict() == OK:
            found.append(_traversals(moved, half_gap, drift_window))
    return [*found, _excitation(moved)]


def travel(moved: SmoothedMotion, i: int) -> DataFinding:
    """Return the finding about how far side `i` travels: a filter sees less than a diagnosis."""
    size, noise = float(np.ptp(moved.p[:, i])), max(float(moved.sigma[i]), 1e-300)
    code, grades = 'travel', {}
    if size <= LIMITS.travel * noise:
        rests = size <= LIMITS.travel * float(moved.noise[i])
        code, grades = 'rests', everything(BAD) if rests else hurts(diagnosis=BAD)
    return judged('motion', f'travel, {NAMES[i]}', said(
        code, side=NAMES[i], travel=size, ratio=size / noise, noise=noise), grades,
        {'travel_rad': size}, 'unexcited')


def reverses(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about how often the speed changes its sign."""
    v, i, seconds = moved.v[:, moved.i], moved.i, moved.recording.duration
    count = len(reversals(v, max(LIMITS.certain * float(moved.noise_v[i]),
                                 LIMITS.slow_share * float(np.abs(v).max()))))
    return judged(
        'motion', 'reversals', said(('never_reverses', 'reverses_once', 'reverses')[min(count, 2)],
                                    side=NAMES[i], count=count, pace=60.0 * count / seconds),
        {} if count > 1 else hurts(OK, BAD, WARN), {'reversals': count},
        'no_reversal')


def _ratio(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about arm over motor travel: sign and gear ratio."""
    motor, arm = (moved.p[:, i] - moved.p[:, i].mean() for i in (0, 1))
    lengths = max(float(np.linalg.norm(motor)), 1e-300), float(np.linalg.norm(arm))
    slope = float(motor @ arm) / lengths[0] ** 2
    same = float(motor @ arm) / max(lengths[0] * lengths[1], 1e-300)
    # Noise and backlash flatten the slope of one on the other, not that of their sizes.
    size = lengths[1] / lengths[0]
    code = ('two_drives' if abs(same) < 0.5 else 'ratio_negative' if slope < 0.0 else
            'ratio' if 1.0 / LIMITS.near < size < LIMITS.near else 'ratio_off')
    return judged('signs', 'motor and arm', said(
        code, ratio=np.sign(slope) * size, correlation=same, factor=1.0 / max(size, 1e-300)),
        {} if code == 'ratio' else everything(BAD), {'slope': slope, 'correlation': same})


def crossings(moved: SmoothedMotion, half_gap: float | None) -> Integers:
    """Return the samples at which the twist has gone from one flank of the gap to the other."""
    middle, width = moved.swing
    flank = max(LIMITS.flank * (half_gap or 0.5 * (width or 0.0)),
                LIMITS.certain * float(np.hypot(*moved.noise)))
    return reversals(moved.p[:, 0] - moved.p[:, 1] - middle, flank)


def _traversals(moved: SmoothedMotion, half_gap: float | None, drift_window: float
                ) -> DataFinding:
    """Return the finding about how often the twist goes from one flank to the other."""
    width, seconds = moved.swing[1], moved.recording.duration
    if width is None:
        return judged('motion', 'gap traversals', said('twist_hidden'), hurts(OK, BAD, WARN),
                      {'traversals': 0})
    at = crossings(moved, half_gap)
    windows = max(1, int(seconds / drift_window))
    per_window = np.bincount((at * moved.dt / drift_window).astype(int), minlength=windows)
    share = float((per_window[:windows] >= 2).mean())
    part = (said('in_windows', percent=100.0 * share),) if share < 1.0 else ()
    return judged(
        'motion', 'gap traversals', said('traversals', count=len(at), swing=width, windows=part,
                                         pace=60.0 * len(at) / seconds, window=drift_window),
        {} if share == 1.0 else hurts(OK, WARN if share >= 0.5 else BAD, OK if len(at) else WARN),
        {'traversals': len(at), 'swing_rad': width, 'windows_share': share})


def _excitation(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about whether inertia, friction and offset are distinguishable."""
    rows = slice(None, None, max(1, len(moved.v) // ROWS))
    columns = np.column_stack([moved.a[:, moved.i], moved.v[:, moved.i], moved.direction(moved.i),
                               np.ones(len(moved.v))])[rows]
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    condition = float(np.linalg.cond(columns))
    return judged(
        'motion', 'excitation', said('excitation', condition=condition),
        {} if condition < LIMITS.excited else hurts(OK, OK, WARN),
        {'condition': min(condition, 1e300)})


# --- torque -------------------------------------------------------------------------------------
def torques(u: Array, seconds: Array, known: bool, has_setpoint: bool = False
            ) -> list[DataFinding]:
    """
    Return findings about torques as recorded.

    Args:
        u: torque as recorded [N], N m; NaN: not measured.
        seconds: its stamps [N], s.
        known: whether enough of them are known.
        has_setpoint: whether a setpoint is recorded.
    """
    share, limits = float(np.isnan(u).mean()), list[DataFinding]()
    values, torque = {'missing_share': share}, u[np.isfinite(u)]
    if share == 1.0 and has_setpoint:
        code, grades = 'setpoint_alone', hurts(BAD, BAD, WARN)
    elif share > LIMITS.lost_many or not known:
        code = 'no_torque' if share == 1.0 else 'torque_missing'
        grades = hurts(BAD, BAD, _for_diagnosis(u, seconds))
    else:
        low, high = float(torque.min()), float(torque.max())
        values.update(rms=rms_of(torque), low=low, high=high)
        code, limits = 'torque', torque_limits(torque)
        limits += [judged('torque', 'used', said('torque_used'))] * has_setpoint
        grades = hurts(WARN, WARN, _for_diagnosis(u, seconds)) if (
            share > LIMITS.max_repaired) else {}
        if low == high:
            code, grades, limits = 'same_torque', everything(BAD), []
    missing = (said('and_missing', percent=100.0 * share),) if share else ()
    return [judged('torque', 'readings', said(code, **values, percent=100.0 * share,
                                              missing=missing), grades, values), *limits]


def torque_limits(u: Array) -> list[DataFinding]:
    """Return the finding about a torque command u [N] that rests on its limits, if it does."""
    high, low = u.max(), u.min()
    starts, lengths = constant_runs(u)
    at_limit = (lengths >= LIMITS.limit_samples) & np.isin(u[starts], (high, low))
    share = float(lengths[at_limit].sum() / len(u))
    rests = float(lengths[lengths >= LIMITS.limit_samples].sum() / len(u)) - share
    # Steps rest everywhere, a clipped command on its limits only.
    if not LIMITS.stuck_share <= share < LIMITS.relay_share or rests > 0.2:
        return []
    return [judged('torque', 'limits', said('at_limits', low=low, high=high,
                                            percent=100.0 * share),
                   hurts(WARN, OK, WARN), {'limited_share': share}, 'torque_limit')]


def stuck(u: Array, y: Array, seconds: Array, noises: Noises) -> list[DataFinding]:
    """
    Return the finding about an effort that keeps one value while the drive moves, if there is one.

    A command that changes with nearly every sample, and then does not, is frozen or clamped, or
    the drive was off.

    Args:
        u: torque as recorded [N], N m; NaN: not measured.
        y: readings of motor and arm [N, 2], rad.
        seconds: times [N], s.
        noises: (noise, quantisation step) of each encoder, rad; None without readings.
    """
    i = 0 if noises[0] is not None else 1
    level, valid = noises[i], np.isfinite(u)
    if level is None or valid.sum() < 10 or np.ptp(u[valid]) == 0.0:
        return []
    u, p, t = u[valid], y[valid, i], seconds[valid]
    starts, lengths = constant_runs(u)
    ends = starts + lengths
    long = np.flatnonzero(t[ends - 1] - t[starts] >= LIMITS.max_gap)
    elsewhere = len(u) - int(lengths[long].sum())
    if not len(long) or len(starts) - len(long) < LIMITS.lively * max(elsewhere, 1):
        return []
    least = LIMITS.stuck_travel * sum(level)
    runs = [slice(starts[k], ends[k]) for k in long
            if (own := p[starts[k]:ends[k]])[np.isfinite(own)].size
            and np.ptp(own[np.isfinite(own)]) > least]
    share = sum(run.stop - run.start for run in runs) / len(u)
    if share < LIMITS.stuck_share:
        return []
    longest = max(runs, key=lambda run: run.stop - run.start)
    value = float(u[longest.start])
    clamped = value in (u.min(), u.max()) and value != 0.0
    return [judged(
        'torque', 'sticks', said(
            'torque_sticks', count=len(runs), side=NAMES[i], percent=100.0 * share,
            begin=t[longest.start], end=t[longest.stop - 1], value=value,
            clamped=(said('clamped'),) if clamped else ()),
        everything(BAD if share > 0.5 else WARN), {'stuck_share': share})]


def setpoint(moved: SmoothedMotion) -> list[DataFinding]:
    """
    Return the finding about a torque that is a position's setpoint, if it is one.

    A setpoint has the slope 1 over the position that follows it, and nothing else in it.
    """
    u = moved.u - moved.u.mean()
    for i in moved.recording.channels:
        p = moved.p[:, i] - moved.p[:, i].mean()
        for late in range(min(int(LIMITS.behind / moved.dt), len(u) // 4)):
            x, y = p[late:], u[:len(u) - late]
            slope = float(x @ y) / max(float(x @ x), 1e-300)
            if (abs(slope - 1.0) < LIMITS.setpoint_share
                    and np.std(y - slope * x) < LIMITS.setpoint_share * np.std(y)):
                return [judged('torque', 'setpoint', said(
                    'is_setpoint', side=NAMES[i], seconds=late * moved.dt, slope=slope),
                    everything(BAD), {'slope': slope})]
    return []


def without_slip(part: UniformRecording) -> tuple[UniformRecording, list[DataFinding]]:
    """
    Return a recording whose motor is counted on over a slip, and the finding about it, if any.

    Motion and load must be alike before and after: the range of the twist keeps its width, and
    moves by more than a change of the mean torque can twist the drive.
    """
    n = round(LIMITS.min_duration / part.dt)
    count = len(part.y) // max(n, 1)
    if len(part.channels) < 2 or count < 5 or np.isnan(part.torque).any():
        return part, []
    twist = part.y[:, 0] - part.y[:, 1]
    ends = np.percentile(twist[:count * n].reshape(count, n), (2, 98), axis=1)
    middle, width = ends.mean(axis=0), np.diff(ends, axis=0)[0]
    torque = part.torque[:count * n].reshape(count, n).mean(axis=1)
    # From the windows before k to those after it: the slip is in window k, or where it begins.
    steps = [float(np.median(middle[k + 1:]) - np.median(middle[:k])) for k in range(2, count - 2)]
    k = 2 + int(np.argmax(np.abs(steps)))
    size, sides = steps[k - 2], (slice(0, k), slice(k + 1, count))
    usual = float(np.median(width))
    scatter = max(float(np.abs(middle[s] - np.median(middle[s])).max()) for s in sides)
    loads, widths = (np.diff([float(np.median(v[s])) for s in sides])[0] for v in (torque, width))
    doubt = LIMITS.swing_share * usual + LIMITS.slip * (
        scatter + usual * abs(loads) / max(float(np.ptp(part.torque)), 1e-300))
    if not abs(size) > max(doubt, LIMITS.slip * abs(widths)):
        return part, []
    row = _row(twist, size, ends, k, n)
    y = part.y.copy()
    y[row:, 0] -= size
    seconds = part.begin + row * part.dt
    return replace(part, y=y, slip=(float(part.t[row]), size)), [judged(
        'motion', 'slip', said('drive_slips', size=size, at=seconds),
        hurts(WARN, WARN, BAD if scatter > 0.5 * abs(size) else WARN),
        {'slip_rad': size, 'slip_s': seconds})]


def _row(twist: Array, size: float, ends: Array, k: int, n: int) -> int:
    """
    Return the row of the slip: without it, the twist stays between its earlier ends.

    Args:
        twist: [N], rad.
        size: of the slip, rad.
        ends: lower and upper one of each window [2, W], rad.
        k: window in which it slips, or where this window begins.
        n: rows of a window.

    """
    low, high = np.median(ends[:, :k], axis=1)
    rows = slice((k - 1) * n, (k + 1) * n)

    def beyond(x: Array) -> Array:
        return np.maximum(x - high, 0.0) + np.maximum(low - x, 0.0)
    before = np.append(0.0, np.cumsum(beyond(twist[rows])))
    after = np.append(0.0, np.cumsum(beyond(twist[rows] - size)))
    cost = before + after[-1] - after
    best = np.flatnonzero(cost <= cost.min() + 1e-12)
    return int(rows.start + best[len(best) // 2])


LAGS = np.arange(-5, 61)  # samples; effort_delay takes -1 to 50
SECONDS = 600.0          # of a recording that are looked at
BLOCKS, BLOCK_SECONDS = 24, 5.0
HINGES = 6               # bends of the torque over the twist
TWIST_ROWS = 100_000


# Delay in samples, gain, correlation, whether at the edge.
Peak: TypeAlias = tuple[float, float, float, bool]


@dataclass(frozen=True)
class TorqueResponse:
    """
    How the motor's acceleration answers to the torque.

    delay, delay_std: samples that the effort acts later than its stamp says; correlation: of
    torque and acceleration at that delay, once speed, friction, position and twist are accounted
    for; gain, gain_std: rad/s^2 per N m; at_edge: the best delay is the last one that was tried;
    work, work_std: net work of the motor over the sum of its amounts, -1 to 1.
    """

    delay: float
    delay_std: float
    correlation: float
    gain: float
    gain_std: float
    at_edge: bool
    work: float
    work_std: float

    @property
    def seen(self) -> bool:
        """Whether the torque shows in the acceleration."""
        return abs(self.correlation) > LIMITS.torque_seen and abs(self.gain) > self.gain_std

    @property
    def timed(self) -> bool:
        """Whether the delay is determined."""
        return self.seen and not self.at_edge and self.delay_std < 1.0


def answer(moved: SmoothedMotion) -> TorqueResponse | None:
    """
    Return the TorqueResponse of a motion, None where it is too short; its first SECONDS suffice.

    The torque u_k, held from t_k to t_k+1, makes the central second difference of the positions at
    t_k by (u_k-1 + u_k) / 2, exactly; both go through the same low pass. What depends on speed,
    friction, position and twist (a bent line) is taken out of either. Standard errors: jackknife
    over blocks of time, and what another low pass changes.
    """
    part, sigma = moved.recording.first(SECONDS), moved.sigma
    widths = moved.half_width, 2.0 * moved.half_width
    moved, other = (SmoothedMotion(part, sigma, (w,), whole=True) for w in widths)
    narrow, wide = _regressed(moved), _regressed(other)
    if narrow is None or wide is None:
        return None
    (whole, spread), (wider, _) = narrow, wide
    work = moved.u[:-1] * np.diff(moved.p[:, moved.i])
    whole_work = max(np.abs(work).sum(), 1e-300)
    by_block = np.array([block.sum() for block in np.array_split(work, BLOCKS)])
    return TorqueResponse(
        float(whole[0]), math.hypot(spread[0], whole[0] - wider[0], LIMITS.delay_method),
        float(whole[2]),
        float(whole[1]), math.hypot(spread[1], whole[1] - wider[1]), bool(whole[3]),
        float(work.sum() / whole_work),
        float(math.sqrt(BLOCKS) * by_block.std() / whole_work))


def _regressed(moved: SmoothedMotion) -> tuple[Peak, Array] | None:
    """Return (result of _best, standard errors of delay and gain), None where too short."""
    u, *columns = _columns(moved)
    blocks = _blocks(len(u), moved.dt, moved.kernels.shape[1] // 2)
    if blocks is None:
        return None
    rows = np.stack([column[blocks] for column in columns], axis=-1)
    acting = 0.5 * (u[1:] + u[:-1])  # [k]: mean of u_k and u_k+1
    torque = np.stack([acting[blocks - 1 - lag] for lag in LAGS], axis=-1)
    rows -= rows.mean(axis=1, keepdims=True)
    torque -= torque.mean(axis=1, keepdims=True)
    a, correlated = rows[..., :1], rows[..., 1:].reshape(-1, rows.shape[-1] - 1)
    scale = np.linalg.norm(correlated, axis=0)
    basis, size, _ = np.linalg.svd(correlated[:, scale > 0.0] / scale[scale > 0.0],
                                   full_matrices=False)
    basis = basis[:, size > 1e-8 * size[0]]

    def remainder(x: Array) -> Array:
        """Return what the correlated columns do not explain of `x` [blocks, rows, C]."""
        x = x.reshape(len(correlated), -1)
        return (x - basis @ (basis.T @ x)).reshape(*blocks.shape, -1)
    a, torque = remainder(a), remainder(torque)
    both, power = (a * torque).sum(axis=1), (torque ** 2).sum(axis=1)  # [blocks, lags]
    own = (a ** 2).sum(axis=(1, 2))
    sums = both.sum(axis=0), power.sum(axis=0), own.sum()
    parts = np.array([_best(*(whole - term for whole, term in zip(sums, part)))[:2]
                      for part in zip(both, power, own)])
    return _best(*sums), np.sqrt((len(blocks) - 1) * parts.var(axis=0))


def _columns(moved: SmoothedMotion) -> list[Array]:
    """
    Return [M] each: torque, acceleration, and all else that this depends on.

    What bends is bent before the low pass, as it was on the drive.
    """
    light, i = SmoothedMotion(moved.recording, moved.sigma, HALF_WIDTHS[:1], whole=True), moved.i
    bent = [light.direction(i)]
    two = len(moved.recording.channels) == 2 and moved.swing[1] is not None
    if two:
        twist = light.p[:, 0] - light.p[:, 1]
        bends = np.quantile(twist[::max(1, len(twist) // TWIST_ROWS)],
                            np.linspace(0.02, 0.98, HINGES))
        bent += [np.maximum(twist - bend, 0.0) for bend in (twist.min(), *bends)]
    bent = [moved.filtered(column) for column in bent]
    lost = light.kernels.shape[1] // 2  # samples at either end
    straight = [moved.u, moved.a[:, i], moved.v[:, i], moved.p[:, i]]
    straight += [moved.v[:, 1]] if two else []
    return [*(column[lost:lost + len(bent[0])] for column in straight), *bent]


def _blocks(count: int, dt: float, width: int) -> Integers | None:
    """Return indices [blocks, rows] of evenly spread blocks of time, None where too few."""
    first, last = LAGS[-1] + 2, count + LAGS[0] - 2
    length = min(int(BLOCK_SECONDS / dt), (last - first) // BLOCKS)
    if length < max(4 * width, 40):
        return None
    starts = np.linspace(first, last - length, BLOCKS).astype(int)
    return starts[:, None] + np.arange(0, length, max(1, width // 2))


def _best(both: Array, power: Array, own: float) -> Peak:
    """Return (delay, gain, correlation, at the edge) of sums over the lags [L]."""
    power = np.maximum(power, 1e-300)
    share = np.abs(both) / np.sqrt(power)
    k = int(np.argmax(share))
    edge = k in (0, len(share) - 1)
    inner = min(max(k, 1), len(share) - 2)
    low, top, high = share[inner - 1:inner + 2]
    bend = low - 2.0 * top + high
    shift = 0.5 * (low - high) / bend if bend < 0.0 and not edge else 0.0
    return (LAGS[k] + min(max(shift, -0.5), 0.5), both[k] / power[k],
            both[k] / np.sqrt(power[k] * max(own, 1e-300)), edge)


def answered(response: TorqueResponse | None, dt: float, stated: int, i: int = 0
             ) -> list[DataFinding]:
    """
    Return what a TorqueResponse shows of delay and sign.

    Args:
        response: response of the acceleration to the torque, None if too short.
        dt: sample time, s.
        stated: parameter effort_delay, samples.
        i: encoder that was used, 0 or 1.
    """
    if response is None:
        return [judged('torque', 'effort delay', said('delay_short'), hurts(WARN, OK, WARN))]
    return [_delay(response, dt, stated), _sign(response, NAMES[i])]


def _delay(response: TorqueResponse, dt: float, stated: int) -> DataFinding:
    delay, std = response.delay, response.delay_std
    rounded, wrong = int(np.rint(delay)), abs(delay - stated) > LIMITS.certain * std
    code, grades = 'delay', hurts(WARN, WARN, WARN) if wrong else {}
    if not response.timed:
        code = ('delay_hidden' if not response.seen else
                'delay_beyond' if response.at_edge else 'delay_vague')
        grades = hurts(WARN, OK, WARN)
    elif wrong and not DELAYS.low <= rounded <= DELAYS.high:
        code = 'delay_late' if rounded < 0 else 'delay_early'
    return judged('torque', 'effort delay', said(
        code, size=Quantity(delay, std), ms=1e3 * dt, stated=stated, rounded=rounded,
        count=abs(rounded), earliest=DELAYS.low, latest=DELAYS.high,
        correlation=abs(response.correlation)), grades, {
            'delay_samples': delay, 'delay_std_samples': std,
            'correlation': response.correlation})


def _sign(response: TorqueResponse, name: str) -> DataFinding:
    first = (said('gain', size=Quantity(response.gain, response.gain_std, 'rad/s^2'))
             if response.seen else said('work', size=percent(response.work, response.work_std)))
    size, error = ((response.gain, response.gain_std) if response.seen else
                   (response.work, max(response.work_std, LIMITS.work / LIMITS.certain)))
    says, grades = [first], dict[str, Grade]()
    if size < -LIMITS.certain * error:
        says, grades = [first, said('wrong_way', side=name)], everything(BAD)
    elif size < 0.0 or not response.seen and response.work < LIMITS.work:
        says, grades = [first, said('sign_unknown')], everything(WARN)
    return judged('signs', f'torque and {name}', tuple(says), grades, {
        'gain': response.gain, 'gain_std': response.gain_std, 'work': response.work,
        'work_std': response.work_std})
