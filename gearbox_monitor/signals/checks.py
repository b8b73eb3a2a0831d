# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What an even segment of a recording says of encoders, motion, signs and torque, check by check.

A check is a function that returns one DataFinding or none. Those with a code are the diagnosis',
too, by which it refuses a recording or says what it cannot show; see finding.FATAL.
"""
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from gearbox_monitor.estimation.noise_search import at_rest
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, hurts, judged, OK, WARN)
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.smoothed_motion import constant_runs, reversals, SmoothedMotion
from gearbox_monitor.signals.uniform import UniformRecording

NAMES = ('motor', 'arm')
Noises: TypeAlias = Sequence[tuple[float, float] | None]
ROWS = 200_000


# --- each encoder for itself --------------------------------------------------------------------
def measured(y: Array, without_arm: bool = False) -> list[DataFinding]:
    """Return findings about readings `y` [N, 2] that are missing; without_arm: as is stated."""
    findings = []
    for name, values in zip(NAMES, y.T):
        share, neither = float(np.isnan(values).mean()), bool(np.isnan(y).all())
        grade = (BAD if share > LIMITS.missing_many
                 else WARN if share > LIMITS.missing_notice else OK)
        figure, advice, grades = (f'{100 * share:.2g} % missing or NaN' if share else 'all there',
                                  'check cable, driver and joint name of this encoder',
                                  hurts(min(grade, WARN), grade, grade))
        if share == 1.0 and without_arm and name == 'arm':
            figure, advice, grades = ('no arm encoder', 'expect torque, trust and backlash; no '
                                      'twist', hurts(WARN, WARN))
        elif share == 1.0:
            figure, grades = 'never measured', hurts(BAD, BAD, BAD if neither else WARN)
            advice = ('without a position there is neither estimate nor diagnosis' if neither else
                      'without it there is no estimate; diagnose takes one encoder')
        findings.append(judged(name, 'readings', figure, grades, advice,
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
    findings = [DataFinding(
        'motion', 'standstill', 'none of half a second: tune will find the noise in motion'
        if rest is None else f'{rest[1]:.3g} s: tune measures the noise there',
        values={'rest_s': 0.0 if rest is None else rest[1]})]
    for i in channels:
        sigma, quantum = noises[i] or (0.0, 0.0)
        figure, values = f'{sigma:.3g} rad', {'noise_rad': sigma, 'quantum_rad': quantum}
        if rest is not None:
            sigma = values['noise_at_rest_rad'] = rest[0][channels.index(i)]
            figure = f'{sigma:.3g} rad at rest ({figure} throughout)'
        right = stated[i] / LIMITS.noise_off <= sigma <= LIMITS.noise_off * stated[i]
        findings.append(judged(
            NAMES[i], 'noise', f'{figure}; r_std_{NAMES[i]} is {stated[i]:.3g}',
            {} if right else hurts(WARN, WARN), 'find R and Q with gearbox_monitor fit noise',
            values))
        if quantum > 0.0:
            coarse = swing is not None and quantum > LIMITS.coarse * swing
            findings.append(judged(
                NAMES[i], 'resolution', f'steps of {quantum:.3g} rad'
                + (f', {quantum / swing:.2g} of the swing of the twist' if swing else ''),
                hurts(OK, WARN, WARN) if coarse else {}, 'read the encoder finer (interpolation, '
                'both edges), or use one with more lines', values))
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
    found, rows = list[DataFinding](), max(LIMITS.stuck_samples, LIMITS.stuck_seconds / part.dt)
    for i in part.channels:
        own, opposite, dt = part.y[:, i], part.y[:, 1 - i], part.dt
        if np.ptp(own) == 0.0:
            found.append(DataFinding(
                NAMES[i], 'sticks', f'the position of the {NAMES[i]} never changes: '
                f'{own[0]:.6g} rad throughout', 'check encoder, cable and driver',
                everything(BAD), {'stuck_s': part.duration}, 'frozen'))
            continue
        if len(part.channels) < 2:
            continue
        starts, lengths = constant_runs(own)
        play = free_travel(part, noises, i, model)
        runs = [run for k in np.flatnonzero(lengths >= rows) if np.ptp(opposite[
            run := slice(starts[k], starts[k] + lengths[k])]) > play]
        if not runs:
            continue
        run, seconds = runs[0], sum(run.stop - run.start for run in runs) * dt
        clipped = own[run.start] in (own.min(), own.max())
        cause = ('the reading is clipped, or the joint stands at an end stop' if clipped else
                 'the encoder is frozen')
        found.append(DataFinding(
            NAMES[i], 'sticks', f'the position of the {NAMES[i]} stays exactly the same for '
            f'{(run.stop - run.start) * dt:.3g} s from t = {part.begin + run.start * dt:.4g} s '
            f'while the {NAMES[1 - i]} travels {np.ptp(opposite[run]):.3g} rad: {cause}',
            'check encoder, cable and driver; leave end stops out of the motion', everything(BAD),
            {'stuck_s': seconds}, 'clipped' if clipped else 'frozen'))
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
    if quantum == 0.0 and sigma > LIMITS.noisy * np.ptp(part.y[:, i]):
        return travel
    # Where a reading lives the twist is that of the drive; of what has stuck it tells nothing.
    lengths = constant_runs(part.y[:, i])[1]
    lives = np.repeat(lengths < max(LIMITS.stuck_samples, LIMITS.stuck_seconds / part.dt), lengths)
    mixed = LIMITS.live <= lives.mean() < 1.0
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
    fast, rms = float(np.abs(v).max()), float(np.sqrt(np.mean(v ** 2)))
    speed = DataFinding('motion', f'speed, {NAMES[i]}', f'rms {rms:.3g}, largest {fast:.3g} rad/s',
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
    figure, grades = f'{size:.4g} rad', {}
    if size <= LIMITS.travel * noise:
        figure = (f'the {NAMES[i]} travels {size:.3g} rad, {size / noise:.1f} times its noise of '
                  f'{noise:.2g} rad: expected at least {LIMITS.travel:g} times')
        rests = size <= LIMITS.travel * float(moved.noise[i])
        grades = everything(BAD) if rests else hurts(diagnosis=BAD)
    return judged('motion', f'travel, {NAMES[i]}', figure, grades, 'move the joint; check unit '
                  'and joint name of this encoder', {'travel_rad': size}, 'unexcited')


def reverses(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about how often the speed changes its sign."""
    v, i, seconds = moved.v[:, moved.i], moved.i, moved.recording.duration
    count = len(reversals(v, max(LIMITS.slow_noise * float(moved.noise_v[i]),
                                 LIMITS.slow_share * float(np.abs(v).max()))))
    times = {0: 'never', 1: 'only once'}.get(count, f'{count} times')
    figure = f'the {NAMES[i]} speed reverses {times}, {60 * count / seconds:.3g} per minute'
    return judged(
        'motion', 'reversals', figure, {} if count >= LIMITS.reversals else hurts(OK, BAD, WARN),
        'move to and fro, else friction that depends on the direction, torque offset and load '
        'cannot be distinguished', {'reversals': count}, 'no_reversal')


def _ratio(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about arm over motor travel: sign and gear ratio."""
    motor, arm = (moved.p[:, i] - moved.p[:, i].mean() for i in (0, 1))
    lengths = max(float(np.linalg.norm(motor)), 1e-300), float(np.linalg.norm(arm))
    slope = float(motor @ arm) / lengths[0] ** 2
    same = float(motor @ arm) / max(lengths[0] * lengths[1], 1e-300)
    # Noise and backlash flatten the slope of one on the other, not that of their sizes.
    size = lengths[1] / lengths[0]
    figure = f'arm moves {np.sign(slope) * size:.4g} x the motor, correlation {same:.3f}'
    advice = ''
    if abs(same) < 0.5:
        figure += ': not one drive'
        advice = 'check the joint names: motor and arm must be the two ends of one gearbox'
    elif slope < 0.0:
        advice = 'turn the sign of one encoder, or make gear_ratio in the model file negative'
    elif not LIMITS.ratio_low < size < LIMITS.ratio_high:
        advice = (f'multiply gear_ratio in the model file by {1.0 / size:.4g} (--model), or check '
                  'the units')
    return DataFinding('signs', 'motor and arm', figure, advice,
                       everything(BAD) if advice else {}, {'slope': slope, 'correlation': same})


def crossings(moved: SmoothedMotion, half_gap: float | None) -> Integers:
    """Return the samples at which the twist has gone from one flank of the gap to the other."""
    middle, width = moved.swing
    flank = LIMITS.flank_gap * half_gap if half_gap else LIMITS.flank_swing * (width or 0.0)
    flank = max(flank, LIMITS.twist_seen * float(np.hypot(*moved.noise)))
    return reversals(moved.p[:, 0] - moved.p[:, 1] - middle, flank)


def _traversals(moved: SmoothedMotion, half_gap: float | None, drift_window: float
                ) -> DataFinding:
    """Return the finding about how often the twist goes from one flank to the other."""
    width, seconds = moved.swing[1], moved.recording.duration
    if width is None:
        return judged('motion', 'gap traversals', 'no twist seen above the noise',
                      hurts(OK, BAD, WARN), 'load the joint to and fro; backlash below the noise '
                      'of the encoders cannot be watched', {'traversals': 0})
    at = crossings(moved, half_gap)
    windows = max(1, int(seconds / drift_window))
    per_window = np.bincount((at * moved.dt / drift_window).astype(int), minlength=windows)
    share = float((per_window[:windows] >= 2).mean())
    figure = (f'{len(at)}, {60 * len(at) / seconds:.3g} per minute; the twist swings '
              f'{width:.3g} rad')
    if share < 1.0:
        figure += f'; in {100 * share:.0f} % of the windows there and back'
    return judged(
        'motion', 'gap traversals', figure, {} if share == 1.0 else hurts(
            OK, WARN if share >= 0.5 else BAD, OK if len(at) else WARN),
        f'load both flanks in every {drift_window:g} s: reverse under load',
        {'traversals': len(at), 'swing_rad': width, 'windows_share': share})


def _excitation(moved: SmoothedMotion) -> DataFinding:
    """Return the finding about whether inertia, friction and offset are distinguishable."""
    rows = slice(None, None, max(1, len(moved.v) // ROWS))
    columns = np.column_stack([moved.a[:, moved.i], moved.v[:, moved.i], moved.direction(moved.i),
                               np.ones(len(moved.v))])[rows]
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    condition = float(np.linalg.cond(columns))
    return judged(
        'motion', 'excitation', f'condition {condition:.3g} of acceleration, speed, friction, '
        'offset', {} if condition < LIMITS.excited else hurts(OK, OK, WARN), 'move at several '
        'speeds, in both directions, with quick starts and stops',
        {'condition': min(condition, 1e300)})


# --- torque -------------------------------------------------------------------------------------
def torques(u: Array, known: bool, has_setpoint: bool = False) -> list[DataFinding]:
    """
    Return findings about torques as recorded.

    Args:
        u: torque as recorded [N], N m; NaN: not measured.
        known: whether enough of them are known.
        has_setpoint: whether a setpoint is recorded.
    """
    share, limits = float(np.isnan(u).mean()), list[DataFinding]()
    values, torque = {'missing_share': share}, u[np.isfinite(u)]
    if share == 1.0 and has_setpoint:
        figure, grades = 'none, but a setpoint is recorded', hurts(BAD, BAD, WARN)
        advice = ('for diagnose give a model file with the key controller, for estimation record '
                  'the torque')
    elif share > LIMITS.missing_many or not known:
        figure, grades = 'none' if share == 1.0 else f'{100 * share:.3g} % missing or NaN', \
            everything(BAD)
        advice = 'publish the commanded torque as effort of the motor joint'
    else:
        low, high, rms = float(torque.min()), float(torque.max()), float(np.sqrt(np.mean(
            torque ** 2)))
        values.update(rms=rms, low=low, high=high)
        figure = f'rms {rms:.3g} N m, {low:.3g} to {high:.3g} N m' + (
            f'; {100 * share:.2g} % missing or NaN' if share else '')
        grades = hurts(WARN, WARN, BAD) if share > LIMITS.missing_notice else {}
        advice, limits = 'publish effort with every position', torque_limits(torque)
        if low == high:
            figure, grades, limits = f'{low:.4g} N m throughout', everything(BAD), []
            advice = 'check that effort is the commanded torque; then move'
    return [judged('torque', 'readings', figure, grades, advice, values), *limits]


def torque_limits(u: Array) -> list[DataFinding]:
    """Return the finding about a torque command u [N] that stands on its limits, if it does."""
    high, low = u.max(), u.min()
    starts, lengths = constant_runs(u)
    at_limit = (lengths >= LIMITS.limit_samples) & np.isin(u[starts], (high, low))
    share = float(lengths[at_limit].sum() / len(u))
    rests = float(lengths[lengths >= LIMITS.limit_samples].sum() / len(u)) - share
    # Steps rest everywhere, a clipped command on its limits only.
    if not LIMITS.limit_share <= share < LIMITS.relay_share or rests > 0.2:
        return []
    return [DataFinding('torque', 'limits', 'the commanded torque stands on its limits '
                        f'{low:.4g} and {high:.4g} N m for {100 * share:.0f} % of the time',
                        'log the torque behind the limiter; if it is logged before, expect the '
                        'effect saturation', hurts(WARN, OK, WARN), {'limited_share': share},
                        'torque_limit')]


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
    long = np.flatnonzero(t[ends - 1] - t[starts] >= LIMITS.still)
    elsewhere = len(u) - int(lengths[long].sum())
    if not len(long) or len(starts) - len(long) < LIMITS.lively * max(elsewhere, 1):
        return []
    least = LIMITS.stuck_travel * sum(level)
    runs = [slice(starts[k], ends[k]) for k in long
            if (own := p[starts[k]:ends[k]])[np.isfinite(own)].size
            and np.ptp(own[np.isfinite(own)]) > least]
    share = sum(run.stop - run.start for run in runs) / len(u)
    if share < LIMITS.least_stuck:
        return []
    longest = max(runs, key=lambda run: run.stop - run.start)
    value = float(u[longest.start])
    clamped = value in (u.min(), u.max()) and value != 0.0
    return [DataFinding(
        'torque', 'sticks', f'{len(runs)} times the same value while the {NAMES[i]} moves, '
        f'{100 * share:.2g} % of the time; longest from {t[longest.start]:.4g} s to '
        f'{t[longest.stop - 1]:.4g} s: {value:.4g} N m' + (', clamped' if clamped else ''),
        'check that the drive is on and writes its effort there; leave these times out',
        everything(BAD) if share > 0.5 else hurts(WARN, WARN, WARN), {'stuck_share': share})]


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
                return [DataFinding(
                    'torque', 'setpoint', f'the torque equals the position of the {NAMES[i]} '
                    f'{late * moved.dt:.2g} s later (slope {slope:.3f}): a setpoint',
                    'log the commanded torque as effort, not the reference position',
                    everything(BAD), {'slope': slope})]
    return []
