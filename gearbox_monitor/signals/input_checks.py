# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Check that a recording is one of the drive in the model file and holds enough motion.

A fatal finding (see finding.FATAL) means that a verdict would be about the recording, not about
the drive: wrong channel, sign or unit, a dead or clipped encoder, no motion. The others name what
the recording cannot show.
"""
from dataclasses import replace

import numpy as np

from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.signals import encoders, wiring
from gearbox_monitor.signals.excitation_checks import reversal_finding, reversals
from gearbox_monitor.signals.finding import DataFinding
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.smoothed_motion import HALF_WIDTHS, SmoothedMotion
from gearbox_monitor.signals.stamps import held_rows
from gearbox_monitor.signals.stretch import EvenStretch
from gearbox_monitor.signals.torque import limits as torque_limits
from gearbox_monitor.signals.uniform import held_rate, UniformRecording
from gearbox_monitor.signals.wiring import Variant


def _finding(code: str, text: str, **values: float) -> DataFinding:
    """Return a DataFinding of the diagnosis alone; values: how the data would have to be read."""
    return DataFinding('model', 'diagnose', text, values=values, code=code)


def check(recording: UniformRecording, model: DriveModel) -> list[DataFinding]:
    """
    Return what a recording says about itself and about the model of its drive.

    Args:
        recording: recording of the drive.
        model: model of the drive.
    """
    return [replace(finding, figure=on_axis(finding.figure, model.axis),
                    advice=on_axis(finding.advice, model.axis))
            for finding in _problems(recording, model)]


def _problems(recording: UniformRecording, model: DriveModel) -> list[DataFinding]:
    problems = _rate_and_length(recording, model)
    if problems and problems[0].fatal:
        return problems
    sigma, quantum = noise_levels(recording.y)
    problems += _encoders(recording, model, sigma, quantum)
    fatal = {p.code for p in problems if p.fatal}
    if 'wraps' in fatal or (np.ptp(recording.y, axis=0) == 0.0).any():
        return problems
    smooth = SmoothedMotion(recording, sigma)
    still = _still(recording, smooth, sigma)
    if still and not fatal:  # noise tells nothing of channels, signs and units
        return problems + still
    rigid = model.transmission.kind == 'rigid'
    one_encoder = len(recording.channels) == 1
    wrong = [] if rigid or one_encoder else _wrong(recording, sigma, smooth, model)
    if model.controller is not None:
        wrong = _setpoint(recording, model)
    if fatal:
        # In wrong units, a coarse encoder that stands still looks frozen or clipped.
        looks = quantum.any() and any(p.code == 'units' for p in wrong)
        return wrong if looks else problems
    problems += wrong
    if any(p.fatal for p in wrong):
        return problems
    limits = torque_limits(recording.u) if recording.servo_torque is None else []
    return problems + limits + _motion(recording, smooth, model)


def _rate_and_length(r: UniformRecording, model: DriveModel) -> list[DataFinding]:
    # The motor's motion is put in by its acceleration, which slow positions do not show.
    rates = (LIMITS.held_rate if model.driven_by == 'position' else LIMITS.diagnosis_slowest,
             LIMITS.diagnosis_fastest)
    rate = 1.0 / r.dt
    rows = max(held_rows(r.y[:, i]) for i in r.channels)
    lowest = held_rate(model)
    if rows > 1 and rate / rows < lowest * 0.99:
        return [_finding('rate', f'{rate:.4g} samples/s, but positions are held for {rows} rows: '
                         f'measured at {rate / rows:.4g} Hz, expected {lowest:g} or more, '
                         'or one row for each measurement')]
    if not rates[0] * 0.99 <= rate <= rates[1] * 1.01:
        hint = ''
        if model.driven_by == 'position' and rate >= LIMITS.diagnosis_slowest * 0.99:
            hint = (' with driven_by: position, which needs the acceleration of the motor; log '
                    'faster, or state driven_by: torque, which takes '
                    f'{LIMITS.diagnosis_slowest:g} or more')
        for unit, factor in (('ms', 1e3), ('us', 1e6), ('ns', 1e9)):
            if rates[0] * 0.99 <= rate * factor <= rates[1] * 1.01:
                hint = f'; is t in {unit}? It must be in s'
        return [_finding('rate', f'{rate:.4g} samples/s, expected {rates[0]:g} to '
                         f'{rates[1]:g}{hint}')]
    if r.duration < LIMITS.min_duration * 0.999:
        return [_finding('too_short', f'{r.duration:.3g} s, expected at least '
                                      f'{LIMITS.min_duration:g} s: '
                         'the verdict is tested on windows of 1 s that are not fitted')]
    if r.duration < LIMITS.short:
        return [_finding('short', f'{r.duration:.3g} s: few windows are left for the test, '
                         'intervals will be wide; 10 s or more are better')]
    return []


# --- each encoder for itself --------------------------------------------------------------------
def _encoders(r: UniformRecording, model: DriveModel, sigma: Array,
              quantum: Array) -> list[DataFinding]:
    """Find encoders that do not move at all, stick, are clipped or wrap around."""
    if not np.isfinite(r.y).all() or not np.isfinite(r.u).all():
        return [_finding('not_finite', 'a value is not finite, expected numbers throughout')]
    still = np.ptp(r.y, axis=0) == 0.0
    findings = [_finding('frozen', f'the position of {side} never changes: {r.y[0, i]:.6g} rad '
                         'throughout') for i, side in enumerate(('the motor', 'the arm'))
                if still[i] and not still.all()]
    if still.all():
        return [_finding('frozen', f'the position of motor and arm never changes: {r.y[0, 0]:.6g} '
                         'rad throughout')]
    noises = list(zip(sigma.tolist(), quantum.tolist()))
    segment = EvenStretch(0.0, r.duration, r.dt, r.torque, r.y, (True, True))
    moving = [f for f in encoders.broken(segment, noises, model)
              if not still[encoders.NAMES.index(f.group)]]
    return findings + moving


# --- channels, signs and units ------------------------------------------------------------------
def _wrong(recording: UniformRecording, sigma: Array, smooth: SmoothedMotion,
           model: DriveModel) -> list[DataFinding]:
    """Find the change of channels, signs or units that explains the data."""
    kinds = tuple(LIMITS.margins)
    for width in (w for w in HALF_WIDTHS if w >= smooth.half_width):
        if width > smooth.half_width:  # noise that lasts is more than its high frequencies tell
            smooth, kinds = SmoothedMotion(recording, sigma, width), kinds[:3]
        recorded, reading, fit = wiring.better(smooth, model, kinds)
        if reading is not None and fit is not None:
            as_is, changed = (
                f'{100 * np.sqrt(f.unexplained):.3g} % of the torque and '
                f'{100 * np.sqrt(f.untransmitted):.3g} % of what is transmitted'
                for f in (recorded, fit))
            code = {'signs': 'sign', 'swapped': 'swapped'}.get(reading.kind, 'units')
            text = _unit_text(model, reading) if code == 'units' else _wiring_text(reading)
            return [_finding(code, f'{text}: with that changed, {changed} stay unexplained '
                             f'instead of {as_is}', swap=float(reading.swap),
                             motor=reading.scale[0], arm=reading.scale[1], torque=reading.torque)]
        if recorded.unexplained < LIMITS.strange:
            return []
    share = recorded.unexplained
    return [_finding('implausible' if share > LIMITS.implausible else 'strange',
                     'the torque that motion and model leave unexplained is '
                     f'{np.sqrt(share):.3g} times the commanded one; check model file, '
                     'channels, signs and units')]


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
        return [_finding('sign', 'the sign of the setpoint is wrong: the position runs against '
                         'it', torque=-1.0)]
    if correlation < LIMITS.follows:
        return [_finding('strange', 'the position does not follow the setpoint (correlation '
                         f'{correlation:.2g}); check that it is the setpoint of this drive')]
    if not 1.0 / LIMITS.other_unit < ratio < LIMITS.other_unit:
        return [_finding('units', f'the setpoint is {1.0 / ratio:.3g} times the motion that '
                         'follows it, expected both in rad on the arm side', torque=ratio)]
    return []


def _wiring_text(reading: Variant) -> str:
    phrases, arm, torque = [], reading.scale[1], reading.torque
    if reading.swap:
        phrases.append('motor and arm positions are swapped')
    if arm < 0 and torque < 0:
        phrases.append('the sign of the motor position is wrong')
    elif arm < 0:
        phrases.append('the sign of the arm position is wrong')
    elif torque < 0:
        phrases.append('the sign of the torque u is wrong')
    return ' and '.join(phrases)


def _unit_text(model: DriveModel, reading: Variant) -> str:
    """Describe what the recording's values are times the expected ones."""
    quantity = reading.quantity
    factor = 1.0 / (reading.torque if quantity == 'torque' else
                    reading.scale[1] if quantity == 'arm' else reading.scale[0])
    units = [(180 / np.pi, 'in degrees'), (1000.0, 'in thousandths'), (0.5 / np.pi, 'in turns'),
             (1e-3, 'in thousands')]
    if quantity == 'torque':
        units = [(1000.0, 'in mN m'), (1e-3, 'in kN m'), (100.0, 'in N cm'),
                 (1 / 9.80665, 'in kgf m'), (100 / 9.80665, 'in kgf cm')]
    if model.axis == 'prismatic':
        units = [(1000.0, 'in mN'), (1e-3, 'in kN'), (1 / 9.80665, 'in kgf')] \
            if quantity == 'torque' else [(1000.0, 'in mm')]
    ratio = abs(model.gear_ratio)
    if abs(ratio - 1.0) > 0.1:
        side = 'the gear ratio is applied twice or on the wrong side'
        units += [(ratio, side), (1 / ratio, side)]
    if quantity == 'side':
        return (f'motor position and torque are those of the motor side of a gear of '
                f'{factor:.3g}:1 (model file: gear_ratio {model.gear_ratio:g}; '
                'expected both on the arm side)')
    name = {'motor': 'the motor position is', 'arm': 'the arm position is',
            'both': 'both positions are', 'torque': 'the torque u is'}[quantity]
    unit, distance = min(((unit, abs(np.log(factor / value))) for value, unit in units),
                         key=lambda pair: pair[1])
    text = (f'{name} {factor:.3g} times what the model allows '
            f'(expected {"N m" if quantity == "torque" else "rad"})')
    current = ', or a current (see torque_constant)' if quantity == 'torque' else ''
    if distance < LIMITS.same_factor:
        return f'{text}, probably {unit}{current}'
    if abs(ratio - 1.0) <= 0.1 and quantity != 'both':
        return f'{text}, perhaps for a gear_ratio that is not in the model file{current}'
    return text + current


# --- motion -------------------------------------------------------------------------------------
def _still(r: UniformRecording, smooth: SmoothedMotion, sigma: Array) -> list[DataFinding]:
    """Find a drive that stands still, or a torque that never changes."""
    for i, name in enumerate(('motor', 'arm')):
        travel = np.ptp(smooth.p[:, i])
        if travel < LIMITS.travel * sigma[i]:
            return [_finding(
                'unexcited', f'the {name} travels {travel:.3g} rad, {travel / sigma[i]:.1f} times '
                f'its noise of {sigma[i]:.2g} rad: expected at least {LIMITS.travel:g} times')]
    if np.ptp(r.u) == 0.0:
        label = 'torque u' if r.servo_torque is None else 'setpoint'
        return [_finding('unexcited', f'the {label} is {r.u[0]:.4g} throughout: expected one that '
                         'changes')]
    return []


def _motion(r: UniformRecording, smooth: SmoothedMotion, model: DriveModel) -> list[DataFinding]:
    problems = []
    windows = (smooth.k * r.dt).astype(int)
    n = int(r.duration + 1e-9)
    moving = sum(np.ptp(smooth.p[windows == w, 0]) > LIMITS.travel * smooth.noise[0]
                 for w in range(n) if (windows == w).any())
    if moving < LIMITS.min_moving:
        return [_finding('unexcited', f'the motor moves in {moving} of {n} s, expected at least '
                         f'{LIMITS.min_moving}')]
    v = smooth.v
    slow = np.maximum(5 * smooth.noise_v, 0.02 * np.abs(v).max(axis=0))
    turns = len(reversals(v[:, 0], slow[0]))
    crossings = _crossings(smooth, model)
    geared = model.transmission.kind != 'rigid' and len(r.channels) == 2
    if turns == 0 and crossings == 0:
        return [_finding('unexcited', 'the motor speed never reverses and the teeth stay on one '
                         'flank: friction, load and offsets are one number then; expected motion '
                         'in both directions')]
    if turns < LIMITS.reversals:
        problems.append(reversal_finding(turns, r.duration, 'motor'))
    if crossings == 0 and geared and model.transmission.half_gap > 0.0:
        problems.append(_finding(
            'gap_not_crossed', 'the drive never crosses the gap: its width and an offset between '
            'the encoders cannot be seen'))
    inertia = model.motor_inertia
    if model.transmission.kind == 'rigid':
        inertia += model.arm_inertia
    if np.abs(smooth.a[:, 0]).max() * inertia < 0.01 * np.abs(smooth.u).max():
        problems.append(_finding(
            'no_acceleration', 'the motor hardly accelerates: inertia cannot be seen'))
    return problems


def _crossings(smooth: SmoothedMotion, model: DriveModel) -> int:
    """Return how often the twist goes from one flank of the gap to the other."""
    half_gap = model.transmission.half_gap
    twist = smooth.p[:, 0] - smooth.p[:, 1]
    twist = twist - 0.5 * (twist.max() + twist.min())
    # Encoders share no zero: the swing itself must be wider than most of the gap.
    return len(reversals(twist, max(0.7 * half_gap, 3 * np.hypot(*smooth.noise))))
