# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""All checks of a recording, in order, and what the recording is suited for."""
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.sample_loop import HUGE
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals import (
    effort, encoders, excitation_checks, input_checks as gap_check, stamps, stretch, torque)
from gearbox_monitor.signals.admission import (
    kind_of, ONE_ENCODER, takes_one_encoder, two_publishers, unstamped)
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, Grade, hurts, OK, PURPOSES, WARN)
from gearbox_monitor.signals.jumps import (
    counted_on, OUTLIER, SLIP, strangers, TURNS, without_jumps)
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.smoothed_motion import SmoothedMotion
from gearbox_monitor.signals.stamps import StampClock
from gearbox_monitor.signals.stretch import EvenStretch
from gearbox_monitor.signals.uniform import held_rate, merged, prepare, REPEATED
from gearbox_monitor.signals.unphysical import is_uninitialised, physical_columns

GROUPS = ('stamps', 'torque', 'motor', 'arm', 'motion', 'signs', 'model')
# Findings of the diagnosis' own check that make estimates as wrong as the diagnosis.
WIRING = ('sign', 'swapped', 'units', 'implausible')


@dataclass(frozen=True)
class Examination:
    """
    The findings of a recording; suits {purpose: (Grade, names of the findings that decide it)}.

    begin: its first usable stamp, seconds: from there to the last one, s.
    """

    lines: tuple[DataFinding, ...]
    suits: dict[str, tuple[Grade, tuple[str, ...]]]
    begin: float
    seconds: float


def examine(samples: Samples, parameters: EstimatorParameters,
            model: DriveModel | None = None, has_setpoint: bool = False) -> Examination:
    """
    Return the Examination of Samples [N] (estimates.Samples, on the arm side).

    parameters: EstimatorParameters. model: DriveModel of the drive, or None where
    none is known: then nothing is said against it. Raises InputError where there is nothing to
    judge.

    Args:
        samples: recorded samples; u is the setpoint, rad, if the model has a controller.
        parameters: parameters of the estimator.
        model: model of the drive, None if unknown.
        has_setpoint: whether a setpoint is recorded beside them.
    """
    if len(samples.stamp_ns) >= LIMITS.min_samples and (samples.stamp_ns <= 0).all():
        raise InputError(unstamped(len(samples.stamp_ns)))
    samples, publishers = _of_one_publisher(samples)
    samples, foreign = _of_this_drive(samples)
    publishers = publishers or foreign
    clock = stamps.clock(samples.stamp_ns, parameters.max_gap)
    if clock is None or len(clock.seconds) < LIMITS.min_samples:
        raise InputError(f'{len(samples.stamp_ns)} samples, expected {LIMITS.min_samples} or '
                         f'more with '
                         'increasing stamps')
    samples, unphysical = _physical(samples)
    samples, jumping = _jumping(samples)
    u, y = samples.u[:, 0], samples.y
    servo = model is not None and model.controller is not None
    lines = stamps.lines(samples.stamp_ns, clock, parameters.max_gap, parameters.drift_window)
    lines += publishers + unphysical + jumping
    lines += encoders.measured(y, not parameters.arm_joint)
    lines += stamps.held(clock, y, held_rate(model))
    part = stretch.stretch(clock, u, y)
    if servo:
        part = replace(part, u=None)
        lines.append(DataFinding('torque', 'readings', 'none: the model has a controller, whose '
                                 'setpoint is read', 'for estimation record the torque and give a '
                                 'model without controller', hurts(BAD, BAD)))
    if any(part.measured):
        lines += _moved(samples, clock, part, parameters, model, has_setpoint)
    lines += _diagnosis(samples, model, parameters.effort_is) if not publishers else []
    if publishers and not foreign:  # what was interpolated has no noise of its own
        lines = [line for line in lines if line.group != 'arm' or line.name == 'readings']
    return examined(lines, float(samples.stamp_ns[clock.usable][0]) * 1e-9, clock.duration)


def _of_one_publisher(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """
    Return samples with motor and arm in each of them, and a finding if two publishers sent them.

    The arm is then interpolated to the stamps of the motor, to see what else can be said.
    """
    if not two_publishers(samples.y):
        return samples, []
    motor, arm = np.isfinite(samples.y).T
    y = samples.y[motor]
    order = np.argsort(samples.stamp_ns[arm], kind='stable')
    y[:, 1] = np.interp(samples.stamp_ns[motor], samples.stamp_ns[arm][order],
                        samples.y[arm, 1][order])
    seconds = max(float(np.ptp(samples.stamp_ns)) * 1e-9, 1e-9)
    rates = [count / seconds for count in (motor.sum(), arm.sum())]
    finding = DataFinding(
        'stamps', 'publishers', f'two on one topic: the motor at {rates[0]:.4g} Hz, the arm at '
        f'{rates[1]:.4g} Hz, never in one message', 'set arm_topic to this topic in the parameter '
        'file (docs/ros.md); gearbox_monitor import BAG --arm-topic joint_states NEW pairs this '
        'recording', everything(BAD), {'motor_hz': rates[0], 'arm_hz': rates[1]})
    return Samples(samples.stamp_ns[motor], samples.u[motor], y), [finding]


def _of_this_drive(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """Return samples without one posture that comes in between, and a finding about these."""
    foreign = strangers(samples.y, samples.stamp_ns)
    if not foreign.any():
        return samples, []
    seconds = max(float(np.ptp(samples.stamp_ns)) * 1e-9, 1e-9)
    first = float(samples.stamp_ns[foreign][0] - samples.stamp_ns[0]) * 1e-9
    posture = samples.y[foreign][0]
    figure = ', '.join(f'{value:.4g}' for value in posture if np.isfinite(value))
    finding = DataFinding(
        'stamps', 'publishers', f'two on one topic: the positions jump to {figure} rad and back, '
        f'{foreign.sum() / seconds:.2g} times a second, first at {first:.4g} s', 'stop the second '
        'publisher, as joint_state_publisher beside the driver; other lines leave out its '
        'samples', everything(BAD), {'foreign': int(foreign.sum()), 'first_s': first})
    keep = ~foreign
    return Samples(samples.stamp_ns[keep], samples.u[keep], samples.y[keep]), [finding]


def _jumping(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """Return samples with turns counted on, and findings about jumps with their times."""
    findings, y = [], samples.y.copy()
    for i, name in enumerate(encoders.NAMES):
        y[:, i], turned = counted_on(y[:, i], samples.stamp_ns)
        for jump in (*turned, *without_jumps(y[:, i], samples.stamp_ns)[1]):
            seconds = float(samples.stamp_ns[jump.row] - samples.stamp_ns[0]) * 1e-9
            values = {'count': jump.count, 'first_s': seconds, 'size_rad': jump.size}
            many = jump.count > LIMITS.max_repaired * len(y)
            line, figure, advice, grades = {
                TURNS: ('wraps', f'{jump.count} jumps of one turn ({jump.size:.4g} rad), the '
                        f'first at {seconds:.4g} s', 'count the position over turns (unwrap it) '
                        'before it is published; the diagnosis counts them on',
                        hurts(BAD, BAD, WARN)),
                OUTLIER: ('outliers', f'{jump.count}, the first one {jump.size:.4g} rad off at '
                          f'{seconds:.4g} s', 'check cable, connector and driver of this encoder',
                          everything(BAD if many else WARN)),
                SLIP: ('slips', f'the position jumps by {jump.size:.4g} rad at {seconds:.4g} s '
                       f'and stays there, {jump.count} such jumps', 'look for an encoder that '
                       'slips or counts wrong, a hub that has come loose, or a zero that is set '
                       'while recording', everything(BAD))}[jump.kind]
            findings.append(DataFinding(name, line, figure, advice, grades, values))
    return (replace(samples, y=y) if any(f.name == 'wraps' for f in findings) else samples
            ), findings


def _physical(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """Return samples without unphysical numbers, and findings about these with their times."""
    findings = []
    u, y = samples.u, samples.y
    channels = (('torque', samples.u[:, 0]), ('motor', y[:, 0]), ('arm', y[:, 1]))
    for name, values in channels:
        wild = np.flatnonzero(np.abs(values) > HUGE)
        if len(wild):
            seconds = float(samples.stamp_ns[wild[0]] - samples.stamp_ns[0]) * 1e-9
            share = len(wild) / len(values)
            findings.append(DataFinding(
                name, 'unphysical', f'{len(wild)} numbers infinite or beyond 1e9, the first '
                f'{values[wild[0]]:.3g} at {seconds:.4g} s: they count as not measured',
                'look for memory that the driver does not write', everything(
                    BAD if share > 0.01 else WARN), {'share': share}))
        elif is_uninitialised(values):
            findings.append(DataFinding(
                name, 'unphysical', 'dead: uninitialised memory, the largest amount is '
                f'{np.nanmax(np.abs(values)):.2g}', 'look for a value that the driver never '
                'writes', everything(BAD)))
    if not findings:
        return samples, []
    return Samples(samples.stamp_ns, physical_columns(u)[0], physical_columns(y)[0]), findings


def examined(lines: Iterable[DataFinding], begin: float, seconds: float) -> Examination:
    """
    Return the Examination of `lines`, in the order of their groups; begin, seconds: as there.

    Args:
        lines: findings.
        begin: first usable stamp, s.
        seconds: duration from there to the last stamp, s.
    """
    lines = sorted(lines, key=lambda line: GROUPS.index(line.group))
    return Examination(tuple(lines), {purpose: _suits(lines, purpose) for purpose in PURPOSES},
                       begin, seconds)


def _moved(samples: Samples, clock: StampClock, part: EvenStretch, parameters: EstimatorParameters,
           model: DriveModel | None, has_setpoint: bool) -> list[DataFinding]:
    u, y = samples.u[clock.usable, 0], samples.y[clock.usable]
    stamp_ns = samples.stamp_ns[clock.usable][0] + np.rint(clock.seconds * 1e9).astype(np.int64)
    noises = [encoders.noise_of(y[:, i]) if part.measured[i] else None for i in (0, 1)]
    moved = excitation_checks.quiet_motion(part, np.array([n[0] if n else 0.0 for n in noises]))
    half_gap = model.transmission.half_gap if model is not None else None
    motion_lines = excitation_checks.lines(part, moved, half_gap, parameters.drift_window)
    geared = any(line.name == 'motor and arm' and line.verdict() == OK for line in motion_lines)
    width = excitation_checks.swing(moved)[1] if geared else None
    lines = encoders.broken(part, noises, model)
    lines += encoders.lines(stamp_ns, y, noises, width,
                            (parameters.r_std_motor, parameters.r_std_arm))
    if model is None or model.controller is None:
        lines += torque.lines(u, part, has_setpoint)
        lines += torque.stuck(u, y, clock.seconds, noises)
    moving = all(line.verdict() < BAD for line in motion_lines if line.name.startswith('travel'))
    if moving:
        lines.append(excitation_checks.excitation(part, moved))
    if moving and part.u is not None and np.ptp(part.u) > 0.0:
        i = int(np.flatnonzero(part.measured)[0])
        lines += torque.setpoint(part, moved)
        lines += torque.answered(torque.answer(part, moved.sigma, moved.width), part.dt,
                                 parameters.effort_delay, i)
    return motion_lines + lines


def _diagnosis(samples: Samples, model: DriveModel | None, effort_is: str) -> list[DataFinding]:
    """Return what diagnose itself says of the recording, and what the effort is."""
    if model is None:
        return [DataFinding('model', 'model file', 'none', 'use --model to check signs, units '
                            'and motion against it', hurts(OK, OK, WARN))]
    rigid = [DataFinding('model', 'model file', 'transmission.kind is rigid',
                         'for estimation use the model of a drive with two encoders',
                         hurts(BAD, BAD))] if model.transmission.kind == 'rigid' else []
    rows, values, repeats = merged(samples.stamp_ns, np.column_stack([samples.u, samples.y]),
                                   REPEATED[0])
    load = values[:, 1] if model.arm_load == 'measured' else None
    try:
        recording, notes = prepare((samples.stamp_ns[rows] - samples.stamp_ns[rows[:1]]) * 1e-9,
                                   values[:, 0], values[:, 2:], load, kind=kind_of(model))
        recording = recording.with_servo(model.controller)
    except InputError as error:
        one_encoder = not takes_one_encoder(model) and np.isnan(samples.y).all(axis=0).any()
        return [*rigid, DataFinding('model', 'diagnose', f'refuses it: {error}',
                                    f'with one encoder give a model with {ONE_ENCODER}'
                                    if one_encoder else 'see above', hurts(diagnosis=BAD))]
    problems = gap_check.check(recording, model)
    fatal = [p for p in problems if p.fatal]
    sentences = [p.text for p in fatal or problems] or ['accepted without remarks']
    wired = everything(BAD) if any(p.code in WIRING for p in fatal) else \
        hurts(diagnosis=BAD) if fatal else hurts(diagnosis=WARN) if problems else {}
    advice = '' if not problems else 'check model file, channels, signs and units' if \
        wired.get('estimation') else 'see above'
    if model.controller is None and len(recording.channels) == 2 and not rigid and not any(
            p.code in ('sign', 'swapped') for p in fatal):
        smooth = SmoothedMotion(recording, noise_levels(recording.y)[0])
        rigid = [effort.finding(smooth, model, effort_is)]
    word = 'refuses it: ' if fatal else 'accepted; ' if problems else ''
    return [*rigid,
            DataFinding('model', 'diagnose', word + '; '.join([
                *sentences, *([repeats] if repeats else []), *notes]), advice, wired)]


def _suits(lines: Iterable[DataFinding], purpose: str) -> tuple[Grade, tuple[str, ...]]:
    grade = max(line.hurts.get(purpose, OK) for line in lines)
    return grade, tuple(f'{line.name} ({line.group})' for line in lines
                        if grade > OK and line.hurts.get(purpose, OK) == grade)
