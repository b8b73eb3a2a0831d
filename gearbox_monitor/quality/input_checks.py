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
Check that a recording is one of the drive in the model file and holds enough motion.

A fatal finding (see finding.FATAL) means that a verdict would be about the recording, not about
the drive: wrong channel, sign or unit, a dead or clipped encoder, no motion. The others name what
the recording cannot show.
"""
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from gearbox_monitor.kernels.sensor_noise import noise_levels
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.quality import encoders
from gearbox_monitor.quality.excitation_checks import reversal_finding, REVERSALS, reversals
from gearbox_monitor.quality.finding import Finding
from gearbox_monitor.quality.recording import (
    DIAGNOSIS_RATES as RATES, MIN_DURATION, SHORT, UniformRecording)
from gearbox_monitor.quality.stretch import Segment
from gearbox_monitor.quality.torque import limits as torque_limits

MIN_TRAVEL = 10.0           # noise standard deviations
MIN_MOVING = 4              # windows of 1 s with motion
LOOSE = (0.33, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0)  # parts of the half gap that are tried
SWINGS = np.array([0.0, 0.25, 0.4, 0.45])  # half gaps in parts of the twist's swing
LASTING = 0.5   # share of what is unexplained that smoothing leaves where it is no noise
HALF_WIDTHS = (0.015, 0.03, 0.06, 0.12)  # s, of the smoothing
# A channel, sign or unit is called wrong where putting it right takes the misfit from above the
# first number down to the second part of it and below the third. Sound recordings with effects as
# strong as they come stay below 0.8, and no change makes them much better.
WRONG = {'unit': ((0.45, 0.4, 0.3), (0.15, 0.12, 0.3), (100.0, 0.02, 0.7)),
         'wiring': ((0.45, 0.4, 0.3), (0.15, 0.12, 0.3), (1.0, 0.4, 0.7))}
LEAST_DECADES = 0.9         # of an unknown factor between units
IMPLAUSIBLE = 5.0           # misfit that no effect explains
STRANGE = 1.0               # misfit worth a word
SAME_FACTOR = 0.3          # how near (relative) a factor comes to a known one


def _finding(code: str, text: str) -> Finding:
    """Return a Finding of the diagnosis alone."""
    return Finding('model', 'diagnose', text, code=code)


def check(recording: UniformRecording, model: DriveModel) -> list[Finding]:
    """
    Return what a recording says about itself and about the model of its drive.

    Args:
        recording: recording of the drive.
        model: model of the drive.
    """
    return [replace(finding, figure=on_axis(finding.figure, model.axis),
                    advice=on_axis(finding.advice, model.axis))
            for finding in _problems(recording, model)]


def _problems(recording: UniformRecording, model: DriveModel) -> list[Finding]:
    problems = _rate_and_length(recording)
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
    wrong = [] if rigid else _wrong(recording, sigma, smooth, model)
    if fatal:
        # In wrong units, a coarse encoder that stands still looks frozen or clipped.
        looks = quantum.any() and any(p.code == 'units' for p in wrong)
        return wrong if looks else problems
    problems += wrong
    if any(p.fatal for p in wrong):
        return problems
    return problems + torque_limits(recording.u) + _motion(recording, smooth, model)


def _rate_and_length(r: UniformRecording) -> list[Finding]:
    rate = 1.0 / r.dt
    if not RATES[0] * 0.99 <= rate <= RATES[1] * 1.01:
        hint = ''
        for unit, factor in (('ms', 1e3), ('us', 1e6), ('ns', 1e9)):
            if RATES[0] * 0.99 <= rate * factor <= RATES[1] * 1.01:
                hint = f'; is t in {unit}? It must be in s'
        return [_finding('rate', f'{rate:.4g} samples/s, expected {RATES[0]:g} to '
                         f'{RATES[1]:g}{hint}')]
    if r.duration < MIN_DURATION * 0.999:
        return [_finding('too_short', f'{r.duration:.3g} s, expected at least {MIN_DURATION:g} s: '
                         'the verdict is tested on windows of 1 s that are not fitted')]
    if r.duration < SHORT:
        return [_finding('short', f'{r.duration:.3g} s: few windows are left for the test, '
                         'intervals will be wide; 10 s or more are better')]
    return []


# --- each encoder for itself --------------------------------------------------------------------
def _encoders(r: UniformRecording, model: DriveModel, sigma: Array,
              quantum: Array) -> list[Finding]:
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
    segment = Segment(0.0, r.duration, r.dt, r.u, r.y, (True, True))
    moving = [f for f in encoders.broken(segment, noises, model)
              if not still[encoders.NAMES.index(f.group)]]
    return findings + moving


# --- smoothed motion ----------------------------------------------------------------------------
class SmoothedMotion:
    """
    Torque and positions smoothed alike, with the positions' derivatives, every few samples.

    u [M] N m; p, v, a [M, 2] rad, rad/s, rad/s^2; k [M] samples they stand at; noise [2] rad, what
    is left of the noise in p. As wide as the noise asks for, and half the width `least` s.
    """

    def __init__(self, recording: UniformRecording, sigma: Array, shortest: float = 0.0) -> None:
        r = recording
        for half_width in (w for w in HALF_WIDTHS if w >= shortest):
            n = max(3, int(round(half_width / r.dt)))
            kernels = _kernels(n, r.dt)
            a = np.column_stack([np.convolve(y - y[0], kernels[2], 'valid') for y in r.y.T])
            gain = np.sqrt((kernels[2] ** 2).sum())
            if (sigma * gain <= 0.15 * a.std(axis=0)).all() or half_width == HALF_WIDTHS[-1]:
                break
        self.half_width = half_width
        decimated = slice(None, None, max(1, n // 3))
        self.k = np.arange(n, len(r.u) - n)[decimated]
        self.a = a[decimated]
        self.p, self.v = (np.column_stack(
            [np.convolve(y - y[0], kernels[i],
                         'valid') for y in r.y.T])[decimated] for i in (0, 1))
        self.p += r.y[0]
        self.u = np.convolve(r.u, kernels[0], 'valid')[decimated]
        self.noise = sigma * np.sqrt((kernels[0] ** 2).sum())
        self.noise_v = sigma * np.sqrt((kernels[1] ** 2).sum())


def _kernels(n: int, dt: float) -> tuple[Array, Array, Array]:
    """Return weights [2n+1] for np.convolve of smoothed value, first and second derivative."""
    s = np.arange(-n, n + 1) / (n + 1)
    w = 1.0 - s * s
    t = s * (n + 1) * dt
    value = w ** 4
    value /= value.sum()
    first = -s * w ** 3  # of w^4, turned round by the convolution
    first *= 1.0 / (first @ -t)
    second = w ** 2 * (7.0 * s * s - 1.0)
    second -= value * second.sum()
    second *= 2.0 / (second @ (t * t))
    return value, first, second


# --- channels, signs and units ------------------------------------------------------------------
def _wrong(recording: UniformRecording, sigma: Array, smooth: SmoothedMotion,
           model: DriveModel) -> list[Finding]:
    """Find what _wiring does where it is still there when more is smoothed away."""
    wrong = _wiring(smooth, model)
    # Noise that lasts is more than its high frequencies tell. Much wider hides what is wrong, too.
    wider = [w for w in HALF_WIDTHS if w > smooth.half_width]
    if wrong and wider and wrong[0].code not in ('implausible', 'strange'):
        wide = SmoothedMotion(recording, sigma, wider[0])
        lasts = misfit(wide, model) > LASTING * misfit(smooth, model) or _wiring(wide, model)
        return wrong if lasts else []
    for width in wider:
        wrong = wrong and _wiring(SmoothedMotion(recording, sigma, width), model)
    return wrong


def _wiring(smooth: SmoothedMotion, model: DriveModel) -> list[Finding]:
    """Find the change of channels, signs or units without which the model says nothing."""
    as_recorded = misfit(smooth, model)
    if as_recorded < min(threshold for threshold, _, _ in WRONG['wiring']):
        return []
    lowest = as_recorded
    change: tuple[Any, ...] | None = None
    for swap, arm, torque in product((False, True), (1, -1), (1, -1)):
        value = misfit(smooth, model, swap, (1.0, float(arm)), float(torque))
        if value < lowest:
            lowest, change = value, ('wiring', swap, arm, torque)
    # One position against the other must fit to a few percent: known units, the slope, a grid.
    motor, arm = smooth.p[:, 0] - smooth.p[:, 0].mean(), smooth.p[:, 1] - smooth.p[:, 1].mean()
    slope = abs(motor @ arm) / (motor @ motor)
    ratio = abs(model.gear_ratio)
    usual_factors = np.array([180 / np.pi, 1e3, 2 * np.pi])
    decades = np.arange(-4.5, 4.51, 0.1)
    # Inertias and loads of a model may be off by several times: other factors must be large.
    grid = 10.0 ** decades[np.abs(decades) > LEAST_DECADES]
    usual = np.concatenate([usual_factors, 1 / usual_factors])
    for quantity, usual_ones in product(('both', 'torque', 'motor', 'arm', 'side'), (True, False)):
        extra_factors = {'both': [], 'arm': [1 / slope]}.get(quantity, [slope, ratio, 1 / ratio])
        factors = np.append(usual if usual_ones else grid,
                            [f for f in extra_factors if abs(np.log10(f)) > 0.4])
        for factor in factors:
            scale = (factor if quantity in ('motor', 'both', 'side') else 1.0,
                     factor if quantity in ('arm', 'both') else 1.0)
            value = misfit(smooth, model, False, scale,
                           {'torque': factor, 'side': 1.0 / factor}.get(quantity, 1.0))
            # Signs are the simpler explanation, and usual units that of odd factors.
            handicap = 0.8 if change and change[0] == 'wiring' else 1.0 if usual_ones else 0.6
            if value < handicap * lowest:
                lowest, change = value, ('unit', quantity, 1.0 / factor)
    if change is None or not any(
            as_recorded > threshold and lowest < min(part * as_recorded, limit)
            for threshold, part, limit in WRONG[change[0]]):
        if as_recorded < STRANGE:
            return []
        return [_finding('implausible' if as_recorded > IMPLAUSIBLE else 'strange',
                         'the torque that motion and model leave unexplained is '
                         f'{np.sqrt(as_recorded):.3g} times the commanded one; check model file, '
                         'channels, signs and units')]
    text = _wiring_text(*change[1:]) if change[0] == 'wiring' else _unit_text(model, *change[1:])
    code = 'units' if change[0] == 'unit' else 'swapped' if change[1] else 'sign'
    return [_finding(code, f'{text}: with that changed, {100 * np.sqrt(lowest):.0f} % of the '
                     'torque stay unexplained instead of '
                     f'{100 * np.sqrt(as_recorded):.0f} %')]


def misfit(smooth: SmoothedMotion, model: DriveModel, swap: bool = False,
           scale: tuple[float, float] = (1.0, 1.0), torque: float = 1.0) -> float:
    """
    Return how far torque and positions are from the two equations of motion, in parts of |u|^2.

    0: they hold exactly; 1: as much torque is unexplained as there is. The data are read with
    motor and arm swapped or not, positions times scale [2], torque times `torque`. What real
    drives have anyway is free: loads on the arm, a constant torque, encoders that share no zero,
    gap and stiffness within a factor of three.

    Args:
        smooth: smoothed motion.
        model: model of the drive.
        swap: whether motor and arm change places.
        scale: factors on the positions [2].
        torque: factor on the torque.
    """
    order = (1, 0) if swap else (0, 1)
    p, v, a = (x[:, order] * scale for x in (smooth.p, smooth.v, smooth.a))
    u = smooth.u * torque
    damping = model.damping * (v[:, 0] - v[:, 1])
    friction = _sign(v[:, 0], model)
    motor = (u - model.motor_inertia * a[:, 0] - model.viscous_friction * v[:, 0] - damping
             - model.coulomb_friction * friction - model.position_gain * p[:, 0])
    motor -= motor.mean()
    loads = np.column_stack([np.ones(len(u)), v[:, 1], _sign(v[:, 1], model),
                             np.sin(p[:, 1]), np.cos(p[:, 1])])
    loads, _ = np.linalg.qr(loads)
    arm = model.arm_inertia * a[:, 1] - damping
    arm -= loads @ (loads.T @ arm)
    twist = p[:, 0] - p[:, 1]
    middle = 0.5 * (np.percentile(twist, 2) + np.percentile(twist, 98))
    t = model.transmission
    lowest, loose = np.inf, 3.0
    gaps = [factor * t.half_gap for factor in (LOOSE if t.half_gap > 0.0 else (1.0,))]
    if model.driven_by == 'position':  # gap and stiffness are looked for in the twist itself
        swing = min(np.ptp(np.percentile(twist, (2, 98))),
                    2.0 * encoders.OWN_PLAY * np.ptp(p[:, 1]))
        gaps, loose = [*gaps, *(SWINGS * swing)], 100.0
    for zero, gap in product((0.0, middle), gaps):
        bent = twist - zero
        bent = bent - np.clip(bent, -gap, gap)
        moved = bent - bent.mean()
        stiffness = (motor @ moved) / max(float(moved @ moved), 1e-300)
        stiffness = np.clip(stiffness, t.stiffness / loose, t.stiffness * loose)
        motor_off = motor - stiffness * moved
        arm_off = stiffness * (bent - loads @ (loads.T @ bent)) - arm
        lowest = min(lowest, motor_off @ motor_off + arm_off @ arm_off)
    return float(lowest / max(float(u @ u), 1e-300))


def _sign(v: Array, model: DriveModel) -> Array:
    return 2.0 / np.pi * np.arctan(model.friction_sharpness * v)


def _wiring_text(swap: bool, arm: float, torque: float) -> str:
    phrases = []
    if swap:
        phrases.append('motor and arm positions are swapped')
    if arm < 0 and torque < 0:
        phrases.append('the sign of the motor position is wrong')
    elif arm < 0:
        phrases.append('the sign of the arm position is wrong')
    elif torque < 0:
        phrases.append('the sign of the torque u is wrong')
    return ' and '.join(phrases)


def _unit_text(model: DriveModel, quantity: str, factor: float) -> str:
    """Describe `factor`, what the recording's values are times the expected ones."""
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
    if distance < SAME_FACTOR:
        return f'{text}, probably {unit}{current}'
    if abs(ratio - 1.0) <= 0.1 and quantity != 'both':
        return f'{text}, perhaps for a gear_ratio that is not in the model file{current}'
    return text + current


# --- motion -------------------------------------------------------------------------------------
def _still(r: UniformRecording, smooth: SmoothedMotion, sigma: Array) -> list[Finding]:
    """Find a drive that stands still, or a torque that never changes."""
    for i, name in enumerate(('motor', 'arm')):
        travel = np.ptp(smooth.p[:, i])
        if travel < MIN_TRAVEL * sigma[i]:
            return [_finding(
                'unexcited', f'the {name} travels {travel:.3g} rad, {travel / sigma[i]:.1f} times '
                f'its noise of {sigma[i]:.2g} rad: expected at least {MIN_TRAVEL:g} times')]
    if np.ptp(r.u) == 0.0:
        return [_finding('unexcited', f'the torque u is {r.u[0]:.4g} N m throughout: expected a '
                         'torque that changes')]
    return []


def _motion(r: UniformRecording, smooth: SmoothedMotion, model: DriveModel) -> list[Finding]:
    problems = []
    windows = (smooth.k * r.dt).astype(int)
    n = int(r.duration + 1e-9)
    moving = sum(np.ptp(smooth.p[windows == w, 0]) > MIN_TRAVEL * smooth.noise[0]
                 for w in range(n) if (windows == w).any())
    if moving < MIN_MOVING:
        return [_finding('unexcited', f'the motor moves in {moving} of {n} s, expected at least '
                         f'{MIN_MOVING}')]
    v = smooth.v
    slow = np.maximum(5 * smooth.noise_v, 0.02 * np.abs(v).max(axis=0))
    turns = len(reversals(v[:, 0], slow[0]))
    crossings = _crossings(smooth, model)
    if turns == 0 and crossings == 0:
        return [_finding('unexcited', 'the motor speed never reverses and the teeth stay on one '
                         'flank: friction, load and offsets are one number then; expected motion '
                         'in both directions')]
    if turns < REVERSALS:
        problems.append(reversal_finding(turns, r.duration, 'motor'))
    if crossings == 0 and model.transmission.kind != 'rigid' and model.transmission.half_gap > 0.0:
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
