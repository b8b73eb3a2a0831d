# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
All checks of a recording, in order: what it is suited for, and its admission to the diagnosis.

Both read the same findings. A doubt about channels, signs or units refuses nothing by itself: it
is another reading of the recording, which the diagnosis lets compete with the effects.
"""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.presentation import as_written, on_axis, Said, said
from gearbox_monitor.signals import checks, stamps, wiring
from gearbox_monitor.signals.checks import without_slip
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, Grade, hurts, judged, LIMITS, OK, PURPOSES, WARN)
from gearbox_monitor.signals.jumps import OUTLIER, SLIP, strangers, TURNS, without_jumps
from gearbox_monitor.signals.uniform import (
    Doubt, FITTED, HALF_WIDTHS, held_rate, noise_of, physical, prepare, RecordingKind,
    SmoothedMotion, UniformRecording, usable_rows)

GROUPS = ('stamps', 'torque', 'motor', 'arm', 'motion', 'signs', 'model', 'filter')
# Faults of channels, signs and units, which say how the data would have to be read.
READ_OTHERWISE = ('sign', 'swapped', 'units')
# What the model file of a drive with one encoder must have.
ONE_ENCODER = ('transmission.kind: rigid, or dead_zone with driven_by: torque and '
               'process_torque_time: 0')


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
            model: DriveModel | None = None, beside: bool = False) -> Examination:
    """
    Return the Examination of samples on the arm side.

    Args:
        samples: recorded samples [N]; u is the setpoint, rad, if the model has a controller.
        parameters: parameters of the estimator.
        model: model of the drive, None if unknown: then nothing is said against it.
        beside: whether a setpoint is recorded, too, or with a controller a torque.

    Raises:
        InputError: there is nothing to judge.
    """
    stamps.require_stamps('stamps', samples.stamp_ns)
    samples, publishers, apart = of_one_publisher(samples)
    clock = stamps.clock(samples.stamp_ns, parameters.max_gap)
    if clock is None or len(clock.seconds) < LIMITS.min_samples:
        raise InputError(f'{len(samples.stamp_ns)} samples, expected {LIMITS.min_samples} or '
                         'more with increasing stamps')
    samples, unphysical = of_physical_numbers(samples)
    samples, jumping = _jumping(samples)
    y = samples.y
    lines = stamps.lines(samples.stamp_ns, clock, parameters.max_gap, parameters.drift_window)
    lines += publishers + unphysical + jumping
    lines += checks.measured(y[clock.usable], clock.seconds, not parameters.arm_joint)
    lines += stamps.held(clock, y, held_rate(model))
    part = stamps.segment(clock, samples.u[:, 0], y)
    if model is not None and model.controller is not None:
        part = replace(part, u=np.full(len(part.u), np.nan))
        lines.append(judged('torque', 'readings', said(
            'both_recorded' if beside else 'setpoint_read'), hurts(BAD, BAD)))
    if part.channels:
        lines += _moved(samples, clock, part, parameters, model, beside)
    lines += _diagnosis(samples, model, parameters.effort_is) if not publishers else []
    if apart:  # what was interpolated has no noise of its own
        lines = [line for line in lines if line.group != 'arm' or line.name == 'readings']
    return examined(lines, float(samples.stamp_ns[clock.usable][0]) * 1e-9, clock.duration)


def examined(lines: Iterable[DataFinding], begin: float, seconds: float) -> Examination:
    """
    Return the Examination of `lines`, in the order of their groups; begin, seconds: as there.

    Args:
        lines: findings.
        begin: first usable stamp, s.
        seconds: duration from there to the last stamp, s.
    """
    lines = sorted(lines, key=lambda line: GROUPS.index(line.group))
    suits = {}
    for purpose in PURPOSES:
        grade = max(line.hurts.get(purpose, OK) for line in lines)
        suits[purpose] = grade, tuple(f'{line.name} ({line.group})' for line in lines if
                                      grade > OK and line.hurts.get(purpose, OK) == grade)
    return Examination(tuple(lines), suits, begin, seconds)


# --- what is no sample of this drive ------------------------------------------------------------
def of_one_publisher(samples: Samples) -> tuple[Samples, list[DataFinding], bool]:
    """
    Return samples of one publisher, the finding about two, and whether each has one encoder.

    Of two with an encoder each the arm is interpolated to the stamps of the motor, to see what
    else can be said; a posture that comes in between is left out.
    """
    motor, arm = np.isfinite(samples.y).T
    few = max(LIMITS.least_changes, LIMITS.max_repaired * len(motor))
    seconds = max(float(np.ptp(samples.stamp_ns)) * 1e-9, 1e-9) if len(motor) else 0.0
    if min(motor.sum(), arm.sum()) >= few and (
            motor & arm).sum() <= LIMITS.max_repaired * len(motor):
        y, order = samples.y[motor], np.argsort(samples.stamp_ns[arm], kind='stable')
        y[:, 1] = np.interp(samples.stamp_ns[motor], samples.stamp_ns[arm][order],
                            samples.y[arm, 1][order])
        rates = [count / seconds for count in (motor.sum(), arm.sum())]
        return Samples(samples.stamp_ns[motor], samples.u[motor], y), [judged(
            'stamps', 'publishers', said('apart', motor=rates[0], arm=rates[1]), everything(BAD),
            {'motor_hz': rates[0], 'arm_hz': rates[1]})], True
    foreign = strangers(samples.y, samples.stamp_ns)
    if not foreign.any():
        return samples, [], False
    first = float(samples.stamp_ns[foreign][0] - samples.stamp_ns[0]) * 1e-9
    posture = ', '.join(f'{x:.4g}' for x in samples.y[foreign][0] if np.isfinite(x))
    keep = ~foreign
    return Samples(samples.stamp_ns[keep], samples.u[keep], samples.y[keep]), [judged(
        'stamps', 'publishers', said('foreign', posture=posture, count=int(foreign.sum()),
                                     first=first),
        everything(BAD), {'foreign': int(foreign.sum()), 'first_s': first})], False


def of_physical_numbers(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """Return samples without unphysical numbers, and findings about these with their times."""
    findings, u, y = [], samples.u.copy(), samples.y.copy()
    for name, field, column in (('torque', 'u', u[:, 0]), ('motor', 'motor', y[:, 0]),
                                ('arm', 'arm', y[:, 1])):
        values, flags = physical(column, field)
        wild = np.flatnonzero(flags)
        if len(wild):
            seconds = float(samples.stamp_ns[wild[0]] - samples.stamp_ns[0]) * 1e-9
            share = len(wild) / len(values)
            findings.append(judged(
                name, 'unphysical', said('wild', count=len(wild), first=column[wild[0]],
                                         at=seconds),
                everything(BAD if share > LIMITS.max_repaired else WARN), {'share': share}))
            column[:] = values
    return replace(samples, u=u, y=y) if findings else samples, findings


def _jumping(samples: Samples) -> tuple[Samples, list[DataFinding]]:
    """Return samples with turns counted on and outliers as not measured, and what was found."""
    findings, y = [], samples.y.copy()
    for i, name in enumerate(checks.NAMES):
        y[:, i], jumping = without_jumps(y[:, i], samples.stamp_ns)
        for jump in jumping:
            seconds = float(samples.stamp_ns[jump.row] - samples.stamp_ns[0]) * 1e-9
            many = jump.count > LIMITS.max_repaired * len(y)
            line, grades = {TURNS: ('wraps', hurts(BAD, BAD, WARN)),
                            OUTLIER: ('outliers', everything(BAD if many else WARN)),
                            SLIP: ('slips', everything(BAD))}[jump.kind]
            findings.append(judged(name, line, said(
                f'reading_{line}', count=jump.count, size=jump.size, first=seconds), grades,
                {'count': jump.count, 'first_s': seconds, 'size_rad': jump.size}))
    return replace(samples, y=y) if findings else samples, findings


# --- a segment by itself and against a model ----------------------------------------------------
def _moved(samples: Samples, clock: stamps.StampClock, part: UniformRecording,
           parameters: EstimatorParameters, model: DriveModel | None, beside: bool
           ) -> list[DataFinding]:
    """Return the findings about encoders, motion and torque of the segment `part` of samples."""
    part, lines = without_slip(part)
    u, y = samples.u[clock.usable, 0], samples.y[clock.usable]
    stamp_ns = samples.stamp_ns[clock.usable][0] + np.rint(clock.seconds * 1e9).astype(np.int64)
    noises = [noise_of(y[:, i]) if i in part.channels else None for i in (0, 1)]
    moved = SmoothedMotion(part, np.array([n[0] if n else 0.0 for n in noises]), HALF_WIDTHS,
                           whole=True)
    motion = checks.motion(moved, model.transmission.half_gap if model is not None else None,
                           parameters.drift_window)
    geared = any(line.name == 'motor and arm' and line.verdict() == OK for line in motion)
    lines += motion + checks.broken(part, noises, model)
    lines += checks.noise(stamp_ns, y, noises, moved.swing[1] if geared else None,
                          (parameters.r_std_motor, parameters.r_std_arm))
    known = bool(np.isfinite(part.u).all())
    if model is None or model.controller is None:
        lines += checks.torques(u, clock.seconds, known, beside)
        lines += checks.stuck(u, y, clock.seconds, noises)
    moving = len(motion) > len(part.channels)  # else the drive rests, and nothing more is said
    if moving and known and np.ptp(part.u) > 0.0:
        lines += checks.setpoint(moved)
        lines += checks.answered(checks.answer(moved), part.dt, parameters.effort_delay, moved.i)
    return lines


def _diagnosis(samples: Samples, model: DriveModel | None, effort_is: str) -> list[DataFinding]:
    """Return what diagnose itself says of the recording, and what the effort is."""
    if model is None:
        return [judged('model', 'model file', said('no_model'), hurts(OK, OK, WARN))]
    lines = [judged('model', 'model file', said('rigid_model'), hurts(BAD, BAD))
             ] if model.transmission.kind == 'rigid' else []
    rows, repeats = usable_rows(samples.stamp_ns)
    u, y = samples.u[rows], samples.y[rows]
    load = u[:, 1] if model.arm_load == 'measured' else None
    try:
        recording, notes = prepare((samples.stamp_ns[rows] - samples.stamp_ns[rows[:1]]) * 1e-9,
                                   u[:, 0], y, load, kind=kind_of(model))
        recording, _ = without_slip(recording.with_servo(model.controller))
    except InputError as error:
        one_encoder = not takes_one_encoder(model) and np.isnan(samples.y).all(axis=0).any()
        return [*lines, judged('model', 'diagnose', said(
            'refused_encoder' if one_encoder else 'refused', remarks=error,
            expected=ONE_ENCODER), hurts(diagnosis=BAD))]
    found = check(recording, model)
    fatal = [f for f in found if f.fatal]
    doubts = [f for f in found if f.fault in (*READ_OTHERWISE, 'implausible')]
    remarks = [*(f.text for f in fatal or found), *map(str, (*repeats, *notes))]
    code, wired = ('doubted', everything(BAD)) if doubts else (
        'refused', hurts(diagnosis=BAD)) if fatal else (
        'remarked' if remarks else 'accepted', hurts(diagnosis=WARN) if found else {})
    if model.controller is None and len(recording.channels) == 2 and not lines and not any(
            f.fault in ('sign', 'swapped') for f in doubts):
        lines = [wiring.effort(SmoothedMotion(recording, noise_levels(recording.y)[0]), model,
                               effort_is)]
    return [*lines, judged('model', 'diagnose', said(code, remarks='; '.join(remarks)), wired)]


def check(recording: UniformRecording, model: DriveModel) -> list[DataFinding]:
    """
    Return what a recording says about itself and about the model of its drive.

    A fatal finding (see finding.FATAL) means that a verdict would be about the recording, not
    about the drive: a dead or clipped encoder, no motion. The others name what the recording
    cannot show, or how else it may have to be read.

    Args:
        recording: recording of the drive.
        model: model of the drive.
    """
    return [replace(finding, axis=model.axis) for finding in _checked(recording, model)]


def _found(fault: str, code: str, **numbers: object) -> DataFinding:
    """Return the DataFinding of a `fault` for the diagnosis alone, said by a `code`."""
    return DataFinding('model', 'diagnose', (said(code, **numbers),), fault=fault)


def _checked(recording: UniformRecording, model: DriveModel) -> list[DataFinding]:
    found = _rate_and_length(recording, model)
    if not np.isfinite(recording.y).all() or not np.isfinite(recording.u).all():
        found.append(_found('not_finite', 'not_finite'))
    if any(f.fatal for f in found):
        return found
    sigma, quantum = noise_levels(recording.y)
    found += checks.broken(recording, list(zip(sigma.tolist(), quantum.tolist())), model)
    fatal = {f.fault for f in found if f.fatal}
    if (np.ptp(recording.y, axis=0) == 0.0).any():
        return found
    smooth = SmoothedMotion(recording, sigma)
    still = [f for i in recording.channels if (f := checks.travel(smooth, i)).fault][:1]
    if not still and np.ptp(recording.u) == 0.0:
        still = [_found('unexcited', 'same_input', value=recording.u[0], input=(
            'torque u' if recording.servo_torque is None else 'setpoint'))]
    if still and not fatal:  # noise shows no channels, signs and units
        return found + still
    doubts = (_setpoint(recording, model) if model.controller is not None else
              [] if model.transmission.kind == 'rigid' or len(recording.channels) == 1 else
              _read_otherwise(recording, sigma, smooth, model))
    if fatal:
        # In wrong units, a coarse encoder that stands still looks frozen or clipped.
        return doubts if quantum.any() and any(f.fault == 'units' for f in doubts) else found
    found += doubts
    if any(f.fault in (*READ_OTHERWISE, 'implausible') for f in doubts):
        return found
    limits = checks.torque_limits(recording.u) if recording.servo_torque is None else []
    return found + limits + _shown(recording, smooth, model)


def _rate_and_length(r: UniformRecording, model: DriveModel) -> list[DataFinding]:
    # The motor's motion is put in by its acceleration, which slow positions do not show.
    slowest, fastest = (LIMITS.held_rate if model.driven_by == 'position' else
                        LIMITS.diagnosis_slowest), LIMITS.diagnosis_fastest
    rate, lowest = 1.0 / r.dt, held_rate(model)
    rows = max(stamps.held_rows(r.y[:, i]) for i in r.channels)
    if rows > 1 and rate / rows < lowest * 0.99:
        return [_found('rate', 'held_too_long', rate=rate, rows=rows, measured=rate / rows,
                       lowest=lowest)]
    if not slowest * 0.99 <= rate <= fastest * 1.01:
        hint = []
        if model.driven_by == 'position' and rate >= LIMITS.diagnosis_slowest * 0.99:
            hint = [said('needs_acceleration')]
        for unit, factor in (('ms', 1e3), ('us', 1e6), ('ns', 1e9)):
            if slowest * 0.99 <= rate * factor <= fastest * 1.01:
                hint = [said('time_unit', unit=unit)]
        return [_found('rate', 'unusable_rate', rate=rate, slowest=slowest, fastest=fastest,
                       hint=tuple(hint))]
    if r.duration < LIMITS.min_duration * 0.999:
        return [_found('too_short', 'too_short', seconds=r.duration)]
    short = r.duration < 2.0 * LIMITS.min_duration
    return [_found('short', 'short', seconds=r.duration)] if short else []


def _read_otherwise(recording: UniformRecording, sigma: Array, smooth: SmoothedMotion,
                    model: DriveModel) -> list[DataFinding]:
    """Find the change of channels, signs or units that explains the data."""
    kinds = tuple(LIMITS.margins)
    for width in (w for w in FITTED if w >= smooth.half_width):
        if width > smooth.half_width:  # noise that lasts is more than its high frequencies tell
            smooth = SmoothedMotion(recording, sigma, [w for w in FITTED if w >= width])
            kinds = kinds[:3]
        recorded, reading, fit = wiring.better(smooth, model, kinds)
        if reading is not None and fit is not None:
            as_is, changed = (said('unexplained_parts', torque=100.0 * np.sqrt(f.unexplained),
                                   transmitted=100.0 * np.sqrt(f.untransmitted))
                              for f in (recorded, fit))
            fault, wrong = wiring.words(model, reading)
            return [replace(_found(fault, 'reads_otherwise', wrong=(wrong,), as_is=(as_is,),
                                   changed=(changed,)),
                            values={'swap': reading.swap, 'scale': reading.scale,
                                    'torque': reading.torque})]
        if recorded.unexplained < LIMITS.strange:
            return []
    share = recorded.unexplained
    return [_found('implausible' if share > LIMITS.implausible else 'strange', 'strange_torque',
                   factor=np.sqrt(share))]


def _setpoint(r: UniformRecording, model: DriveModel) -> list[DataFinding]:
    """Find a setpoint that the position follows with another sign or in another unit."""
    position, correlation, against, ratio = r.y[:, r.channels[0]], -1.0, 1.0, 1.0
    for lag in range(0, round(LIMITS.behind / r.dt) + 1, max(1, round(0.01 / r.dt))):
        setpoint, follower = r.u[:len(r.u) - lag], position[lag:]
        if np.ptp(setpoint) > 0.0:
            at_lag = float(np.corrcoef(setpoint, follower)[0, 1])
            against = min(against, at_lag)
            if at_lag > correlation:
                correlation, ratio = at_lag, float(np.std(follower) / np.std(setpoint))
    # A motion faster than the servo is behind by half a period: that alone is no wrong sign. The
    # servo of the model is behind as much.
    if correlation < LIMITS.follows:
        expected = simulate(model, r.u, r.dt).x[:, r.channels[0]]
        if np.isfinite(expected).all() and np.ptp(expected) > 0.0:
            as_model = float(np.corrcoef(expected, position)[0, 1])
            if as_model > correlation:
                correlation, ratio = as_model, float(np.std(position) / np.std(expected))
            against = max(against, as_model)
    if correlation < LIMITS.follows and against < -LIMITS.follows:
        return [replace(_found('sign', 'setpoint_turned'), values={'torque': -1.0})]
    if correlation < LIMITS.follows:
        return [_found('strange', 'setpoint_not_followed', correlation=correlation)]
    if not 1.0 / LIMITS.other_unit < ratio < LIMITS.other_unit:
        return [replace(_found('units', 'setpoint_unit', factor=1.0 / ratio),
                        values={'torque': ratio})]
    return []


def _shown(r: UniformRecording, smooth: SmoothedMotion, model: DriveModel) -> list[DataFinding]:
    """Return what the motion of a recording cannot show of the model."""
    windows, n = (smooth.k * r.dt).astype(int), int(r.duration + 1e-9)
    moving = sum(np.ptp(smooth.p[windows == w, 0]) > LIMITS.travel * smooth.noise[0]
                 for w in range(n) if (windows == w).any())
    if moving < LIMITS.min_duration:
        return [_found('unexcited', 'moves_little', moving=moving, seconds=n)]
    turned, half_gap = checks.reverses(smooth), model.transmission.half_gap
    crossed = len(checks.crossings(smooth, half_gap)) if half_gap > 0.0 else 0
    if not turned.values['reversals'] and not crossed:
        return [_found('unexcited', 'one_direction')]
    found = [turned] if turned.fault else []
    if not crossed and half_gap > 0.0 and len(r.channels) == 2 and (
            model.transmission.kind != 'rigid'):
        found.append(_found('gap_not_crossed', 'gap_not_crossed'))
    inertia = model.motor_inertia + model.arm_inertia * (model.transmission.kind == 'rigid')
    if np.abs(smooth.a[:, 0]).max() * inertia < 0.01 * np.abs(smooth.u).max():
        found.append(_found('no_acceleration', 'no_acceleration'))
    return found


# --- admission ----------------------------------------------------------------------------------
def require_samples(name: str, stamp_ns: Integers, y: Array) -> None:
    """
    Refuse messages that are no samples of one drive, with what makes them some.

    Args:
        name: name of the recording in messages.
        stamp_ns: header stamps, int64 [N].
        y: readings of motor and arm [N, 2], rad; NaN: not measured.

    Raises:
        InputError: no message is stamped, or two publishers sent them.
    """
    stamps.require_stamps(name, stamp_ns)
    for finding in of_one_publisher(Samples(stamp_ns, np.empty((len(y), 2)), y))[1]:
        raise InputError(f'{name}: {finding.figure}, expected those of the drive alone: '
                         f'{finding.advice}')


def measured_samples(samples: Samples, name: str) -> tuple[Samples, list[str]]:
    """
    Return the samples of a recording without unphysical numbers, and notes about them.

    Args:
        samples: of one drive.
        name: name of the recording in messages.

    Raises:
        InputError: they are no samples of one drive.
    """
    require_samples(name, samples.stamp_ns, samples.y)
    try:
        samples, findings = of_physical_numbers(samples)
    except InputError as error:
        raise InputError(f'{name}: {error}') from None
    return samples, [f'{finding.group}: {finding.figure}' for finding in findings]


def takes_one_encoder(model: DriveModel) -> bool:
    """
    Return whether a diagnosis of the drive `model` can do without one of the encoders.

    Behind an elastic gear it takes the filter of the innovations, which carries the hidden side.
    """
    return model.transmission.kind == 'rigid' or (
        model.transmission.kind == 'dead_zone' and model.driven_by == 'torque'
        and model.process_torque_time == 0.0)


def kind_of(model: DriveModel) -> RecordingKind:
    """Return what a recording of the drive `model` is."""
    return RecordingKind(takes_one_encoder(model), model.axis, model.controller is not None)


def admitted(t: Array | Integers, u: Array, y: Array, arm_torque: Array | None, name: str,
             model: DriveModel, model_name: str, longest: float = LIMITS.longest
             ) -> tuple[UniformRecording, list[Said]]:
    """
    Return (Recording, notes) of readings that suit a verdict on the drive.

    Args:
        t: stamps [N], s, or integer ns.
        u: torque [N], N m, or setpoint, rad, of a model with a controller; NaN: not measured.
        y: readings of motor and arm [N, 2], rad.
        arm_torque: torque measured on the arm [N], N m, or None or NaN; used with arm_load:
            measured in the model alone.
        name: name of the recording in messages.
        model: model of the drive.
        model_name: name of the model in messages.
        longest: length that is used, s.

    Returns:
        The recording, with how else it may have to be read as its doubt.

    Raises:
        InputError: encoders, stamps or motion allow no verdict.
    """
    notes = list[Said]()
    stamp = np.asarray(t)
    burst = stamps.burst_size(stamp.astype(np.int64)) if stamp.dtype.kind == 'i' and len(t) else 1
    if burst > 1:
        raise InputError(f'{name}: stamped in bursts of {burst} on receipt, expected even stamps: '
                         'gearbox_monitor import BAG --stamps even NEW lays an even grid through '
                         'them')
    measured = arm_torque is not None and np.isfinite(arm_torque).any()
    if model.arm_load == 'measured' and not measured:
        raise InputError(f'{name}: no {on_axis("torque", model.axis)} measured on the arm, '
                         f'expected one (effort of the arm), as {model_name} states arm_load: '
                         'measured')
    if model.arm_load != 'measured':
        if measured and arm_torque is not None and np.nanmax(np.abs(arm_torque)) > 0.0:
            notes.append(said('arm_torque_unused', model=model_name, load=model.arm_load,
                              input=on_axis('torque', model.axis)))
        arm_torque = None
    missing = [side for side, column in zip(checks.NAMES, np.asarray(y, float).T)
               if np.isnan(column).all()]
    if len(missing) == 1 and not takes_one_encoder(model):
        raise InputError(f'{name}: {missing[0]}: never measured, expected both encoders, or in '
                         f'{model_name} {ONE_ENCODER}')
    recording, repaired = prepare(t, u, y, arm_torque, name, kind_of(model), longest)
    recording, _ = without_slip(recording.with_servo(model.controller))
    found = check(recording, model)
    fatal = [f.text for f in found if f.fatal]
    if fatal:
        raise InputError(f'{name}: ' + '; '.join(fatal))
    doubts = [Doubt(f.text, **f.values) for f in found if f.fault in READ_OTHERWISE]
    return (replace(recording, doubt=doubts[0] if doubts else None),
            [*notes, *repaired, *(as_written(f.text) for f in found
                                  if f.fault not in READ_OTHERWISE)])


# --- parts of a long recording ------------------------------------------------------------------
SAMPLES = 150_000  # that a part has at least, 300 MB of memory; less than twice that are one
WINDOWS = 2        # of drift, likewise


def joined(parts: Sequence[Examination], drift_window: float) -> Examination:
    """
    Return the Examination of a recording from those of its `parts`, in order.

    Each line is that of the part in which it is worst, of equal ones the first; samples that are
    refused or lost are counted in all parts. drift_window (s): the estimator's.
    """
    if len(parts) == 1:
        return parts[0]
    moving = [part for part in parts if not _rests(part)] or parts
    by_name: dict[tuple[str, str], list[tuple[float, DataFinding]]] = {}
    for part in parts:
        for line in part.lines:
            if part in moving or _of_rest(line):
                by_name.setdefault((line.group, line.name), []).append((part.begin, line))
    lines = {name: _worst(candidates, parts[0].begin,
                          len(parts if _of_rest(candidates[0][1]) else moving))
             for name, candidates in by_name.items()}
    seconds = parts[-1].begin + parts[-1].seconds - parts[0].begin
    length = stamps.length(seconds, drift_window)
    lines[length.group, length.name] = length
    return examined(lines.values(), parts[0].begin, seconds)


def _worst(candidates: Sequence[tuple[float, DataFinding]], start: float, count: int
           ) -> DataFinding:
    """
    Return the worst of [(begin of its part, finding)], the first of equal ones, with its part.

    start: of the recording, s; count: of the parts that could have such a line.
    """
    begin, line = max(candidates, key=lambda pair: pair[1].verdict())
    counted = line.group == 'stamps' and line.name in ('order', 'gaps')
    if counted:
        line = stamps.counted(line, [(part - start, finding) for part, finding in candidates])
    if sum(candidate.verdict() == line.verdict() for _, candidate in candidates) == count:
        return line
    where = said('worst_in_part' if counted else 'in_part', begin=begin - start)
    return replace(line, says=(*line.says, where),
                   values={**line.values, 'part_from_s': begin - start})


def _rests(part: Examination) -> bool:
    """Return whether neither side moves in a part, by its Examination."""
    travels = [line for line in part.lines if line.name.startswith('travel')]
    return bool(travels) and all(line.hurts.get('estimation') == BAD for line in travels)


def _of_rest(line: DataFinding) -> bool:
    """Return whether a finding says something while the drive rests, too."""
    return line.group == 'stamps' or line.group in ('motor', 'arm') and line.name == 'readings'
