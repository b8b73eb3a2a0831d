# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Each encoder by itself: missing readings, noise, resolution, readings that stick."""
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from gearbox_monitor.estimation.noise_search import at_rest
from gearbox_monitor.kernels.elementary import quantisation_step, white_noise_std
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.finding import BAD, DataFinding, everything, hurts, OK, WARN
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.stretch import EvenStretch

NAMES = ('motor', 'arm')
Noises: TypeAlias = Sequence[tuple[float, float] | None]


def constant_runs(x: Array) -> tuple[Integers, Integers]:
    """Return (starts, lengths) of the runs of one value in x [N]."""
    starts = np.append(0, np.flatnonzero(np.diff(x)) + 1)
    return starts, np.diff(np.append(starts, len(x)))


def noise_of(y: Array) -> tuple[float, float]:
    """Return (noise, step of the lattice or 0) of readings y [N] (rad), NaN: not measured."""
    readings = y[np.isfinite(y)]
    starts, lengths = constant_runs(readings)
    if len(starts) > 4 and lengths.max() > 0.5 * len(readings):  # most of it has stuck
        k = int(lengths.argmax())
        parts = readings[:starts[k]], readings[starts[k] + lengths[k]:]
        readings = max(parts, key=len)
    quantum = quantisation_step(readings)
    return white_noise_std(readings, quantum), quantum


def measured(y: Array, without_arm: bool = False) -> list[DataFinding]:
    """
    Return Lines about readings that are missing.

    Args:
        y: readings [N, 2], rad.
        without_arm: whether the joint has no arm encoder.
    """
    lines = []
    neither = bool(np.isnan(y).all())
    for name, values in zip(NAMES, y.T):
        share = float(np.isnan(values).mean())
        values = {'missing_share': share}
        if share == 1.0 and name == 'arm' and without_arm:
            lines.append(DataFinding(
                name, 'readings', 'no arm encoder', 'expect torque, trust and backlash; no twist',
                hurts(WARN, WARN), values))
            continue
        if share == 1.0:
            lines.append(DataFinding(
                name, 'readings', 'never measured',
                'without a position there is neither estimate nor diagnosis' if neither else
                'without it there is no estimate; diagnose takes one encoder',
                hurts(BAD, BAD, BAD if neither else WARN), values))
            continue
        grade = (BAD if share > LIMITS.missing_many
                 else WARN if share > LIMITS.missing_notice else OK)
        lines.append(DataFinding(
            name, 'readings', 'all there' if share == 0.0 else
            f'{100 * share:.2g} % missing or NaN',
            '' if grade == OK else 'check cable, driver and joint name of this encoder',
            hurts(min(grade, WARN), grade, grade), values))
    return lines


def lines(stamps: Integers, y: Array, noises: Noises, swing: float | None,
          stated: Sequence[float]) -> list[DataFinding]:
    """
    Return Lines about noise and resolution.

    stamps int64 [N] ns and y [N, 2] rad as recorded, stamps increasing; noises ((noise, step),
    ...) of noise_of, None for an encoder without readings; swing (rad): of the twist, or None;
    stated [2] rad: r_std_motor, r_std_arm of the estimator.

    Args:
        stamps: stamps [N], ns.
        y: readings [N, 2] as recorded, rad; NaN: not measured.
        noises: (noise, quantisation step) of each encoder, rad; None without readings.
        swing: swing of the twist, rad; None if unknown.
        stated: r_std_motor and r_std_arm of the estimator, rad.
    """
    channels = [i for i in (0, 1) if noises[i] is not None]
    both = y[:, [channels[0], channels[-1]]]
    standstill = at_rest(stamps, both)
    seconds = 0.0 if standstill is None else standstill[1]
    figure = f'{seconds:.3g} s: tune measures the noise there' if seconds else \
        'none of half a second: tune will find the noise in motion'
    lines = [DataFinding('motion', 'standstill', figure, values={'rest_s': seconds})]
    for i, levels in enumerate(noises):
        if levels is None:
            continue
        noise, quantum = levels
        figure, values = f'{noise:.3g} rad', {'noise_rad': noise, 'quantum_rad': quantum}
        if standstill is not None:
            noise = standstill[0][channels.index(i)]
            figure = f'{noise:.3g} rad at rest ({figure} throughout)'
            values['noise_at_rest_rad'] = noise
        right = stated[i] / LIMITS.noise_off <= noise <= LIMITS.noise_off * stated[i]
        lines.append(DataFinding(
            NAMES[i], 'noise', f'{figure}; r_std_{NAMES[i]} is {stated[i]:.3g}',
            '' if right else 'find R and Q with gearbox_monitor tune',
            {} if right else hurts(WARN, WARN), values))
        if not quantum > 0.0:
            continue
        coarse = swing is not None and quantum > LIMITS.coarse * swing
        lines.append(DataFinding(
            NAMES[i], 'resolution', f'steps of {quantum:.3g} rad'
            + (f', {quantum / swing:.2g} of the swing of the twist' if swing else ''),
            'read the encoder finer (interpolation, both edges), or use one with more lines'
            if coarse else '', hurts(OK, WARN, WARN) if coarse else {}, values))
    return lines


def broken(part: EvenStretch, noises: Noises, model: DriveModel | None = None
           ) -> list[DataFinding]:
    """
    Return findings about readings that stick or are clipped.

    Args:
        part: even grid of samples.
        noises: (noise, quantisation step) of each encoder, rad; None without readings.
        model: model of the drive, None if unknown.
    """
    findings = []
    for i, name in enumerate(NAMES):
        if not part.measured[i]:
            continue
        if all(part.measured):
            play = free_travel(part, noises, i, model)
            findings += sticks(name, part.y, i, play, part.begin, part.dt)
    return findings


def free_travel(part: EvenStretch, noises: Noises, i: int, model: DriveModel | None) -> float:
    """
    Return how far (rad) the other side may go while encoder `i` gives one and the same reading.

    White noise never repeats itself; on a lattice, or without noise, a joint may rest while the
    other side crosses backlash and spring.

    Args:
        part: even grid of samples.
        noises: (noise, quantisation step) of each encoder, rad.
        i: number of the encoder, 0 or 1.
        model: model of the drive, None if unknown.
    """
    own, opposite = noises[i], noises[1 - i]
    assert own is not None and opposite is not None
    noise, quantum = own
    travel = 20.0 * opposite[0] + 2.0 * opposite[1]
    if quantum == 0.0 and noise > LIMITS.noisy * np.ptp(part.y[:, i]):
        return travel
    # Where a reading lives the twist is that of the drive; of what has stuck it tells nothing.
    lives = live_rows(part.y[:, i], part.dt)
    y = part.y[lives] if lives.sum() >= LIMITS.live * len(lives) else part.y
    if lives.all() or len(y) == len(lives):
        low, high = np.percentile(y[:, 0] - y[:, 1], (25, 75))
    else:
        low, high = np.percentile(y[:, 0] - y[:, 1], (5, 95)) / 2.0
    free = 4.0 * float(high - low)
    if model is not None:
        t = model.transmission
        torque = 0.0 if part.u is None else float(np.ptp(part.u))
        free = max(free, 4.0 * (t.half_gap + t.hysteresis_width)
                   + 2.0 * torque / max(t.stiffness, 1e-9))
        if model.driven_by == 'position':  # the backlash may be missing in the model file
            free = max(free, LIMITS.own_play * float(np.ptp(part.y, axis=0).max()))
    return travel + 2.0 * quantum + free


def live_rows(y: Array, dt: float) -> Flags:
    """Return which of the readings y [N] (`dt` s apart) are no part of a long run of one value."""
    lengths = constant_runs(y)[1]
    lives: Flags = np.repeat(lengths < max(LIMITS.stuck_samples, LIMITS.stuck_seconds / dt),
                             lengths)
    return lives


def sticks(name: str, y: Array, i: int, play: float, begin: float, dt: float) -> list[DataFinding]:
    """
    Return the finding about one and the same reading while the other side moves, if there is one.

    Args:
        name: motor or arm.
        y: readings of motor and arm [N, 2], rad.
        i: number of the encoder, 0 or 1.
        play: travel of the other side that is no fault, rad; see `free_travel`.
        begin: time of the first reading, s.
        dt: sample time, s.
    """
    own, opposite = y[:, i], y[:, 1 - i]
    starts, lengths = constant_runs(own)
    runs = [slice(starts[k], starts[k] + lengths[k])
            for k in np.flatnonzero(lengths >= max(LIMITS.stuck_samples,
                                                   LIMITS.stuck_seconds / dt))]
    runs = [run for run in runs if np.ptp(opposite[run]) > play]
    if not runs or np.ptp(own) == 0.0:
        return []
    run, seconds = runs[0], sum(run.stop - run.start for run in runs) * dt
    clipped = own[run.start] in (own.min(), own.max())
    cause = ('the reading is clipped, or the joint stands at an end stop' if clipped else
             'the encoder is frozen')
    return [DataFinding(
        name, 'sticks', f'the position of the {name} stays exactly the same for '
        f'{(run.stop - run.start) * dt:.3g} s from t = {begin + run.start * dt:.4g} s while the '
        f'{NAMES[1 - i]} travels {np.ptp(opposite[run]):.3g} rad: {cause}',
        'check encoder, cable and driver; leave end stops out of the motion', everything(BAD),
        {'stuck_s': seconds}, 'clipped' if clipped else 'frozen')]
