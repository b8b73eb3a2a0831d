# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""How the drive moves: travel, speed, reversals, traversals of the backlash, ratio and signs."""
from dataclasses import dataclass

import numpy as np
import scipy

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.signals.encoders import NAMES
from gearbox_monitor.signals.finding import BAD, DataFinding, everything, hurts, OK, WARN
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.stretch import EvenStretch

HALF_WIDTHS = (0.005, 0.01, 0.02, 0.04, 0.08)  # s, of the low pass
ROWS = 200000


@dataclass(frozen=True)
class LowPassedMotion:
    """
    Torque and positions through one low pass, M samples `dt` s apart, from `first` on.

    u [M] N m or None; p, v, a [M, 2] rad, rad/s, rad/s^2, exact differences of the same p; sigma
    [2] rad: noise of the encoders; noise [2] rad, noise_v [2] rad/s: its remainder in p and
    v; width: half width of the low pass, samples.
    """

    u: Array | None
    p: Array
    v: Array
    a: Array
    sigma: Array
    noise: Array
    noise_v: Array
    dt: float
    width: int
    first: int


def kernel_of(width: int) -> Array:
    """Return the weights [2 width + 1] of the low pass of half width `width` samples."""
    kernel = np.hanning(2 * width + 3)[1:-1]
    return kernel / kernel.sum()


def low_pass(x: Array, width: int) -> Array:
    """Return x [N, C] or [N] without its first and last `width` samples, smoothed."""
    kernel = kernel_of(width)
    return scipy.signal.oaconvolve(x, kernel[:, None] if x.ndim > 1 else kernel, 'valid', axes=0)


def motion(part: EvenStretch, sigma: Array, width: int) -> LowPassedMotion:
    """
    Return the Motion of a Stretch, encoders with noise sigma [2] rad; width: samples.

    Args:
        part: even grid of samples.
        sigma: noise of the encoders [2], rad.
        width: half width of the low pass, samples.
    """
    start, kernel = part.y[:1], kernel_of(width)
    p = low_pass(part.y - start, width)
    u = None if part.u is None else low_pass(part.u, width)[1:-1]
    slope = np.linalg.norm(np.pad(kernel, (0, 2)) - np.pad(kernel, (2, 0))) / (2.0 * part.dt)
    return LowPassedMotion(
        u, p[1:-1] + start, (p[2:] - p[:-2]) / (2.0 * part.dt),
        (p[2:] - 2.0 * p[1:-1] + p[:-2]) / part.dt ** 2, sigma,
        sigma * np.linalg.norm(kernel), sigma * slope, part.dt, width, width + 1)


def quiet_motion(part: EvenStretch, sigma: Array) -> LowPassedMotion:
    """
    Return the Motion of a Stretch with the shortest low pass that the noise allows.

    Args:
        part: even grid of samples.
        sigma: noise of the encoders [2], rad.
    """
    measured = list(part.measured)
    for half_width in HALF_WIDTHS:
        width = max(2, round(half_width / part.dt))
        moved = motion(part, np.where(measured, sigma, 0.0), width)
        noise = moved.sigma * np.linalg.norm(np.diff(np.pad(kernel_of(width), 2),
                                                     2)) / part.dt ** 2
        if (noise[measured] <= LIMITS.acceleration_noise * moved.a[:, measured].std(axis=0)).all():
            break
    return moved


def reversals(v: Array, slow: float) -> Integers:
    """Return the samples at which the speed v [M] has gone from beyond one `slow` to the other."""
    side = np.sign(v) * (np.abs(v) > slow)
    at = np.flatnonzero(side)
    return at[1:][np.diff(side[at]) != 0]


def reversal_finding(count: int, seconds: float, name: str) -> DataFinding:
    """
    Return the finding about how often the speed changes its sign.

    Args:
        count: number of reversals.
        seconds: duration of the motion, s.
        name: motor or arm.
    """
    times = {0: 'never', 1: 'only once'}.get(count, f'{count} times')
    sufficient = count >= LIMITS.reversals
    return DataFinding(
        'motion', 'reversals',
        f'the {name} speed reverses {times}, {60 * count / seconds:.3g} per minute',
        '' if sufficient else 'move to and fro, else friction that depends on the '
        'direction, torque offset and load cannot be distinguished',
        {} if sufficient else hurts(OK, BAD, WARN), {'reversals': count},
        '' if sufficient else 'no_reversal')


def swing(moved: LowPassedMotion) -> tuple[float, float | None]:
    """
    Return (middle, swing) of the twist of a Motion, rad; swing None where it is only noise.

    Args:
        moved: low-passed motion of the segment.
    """
    twist = moved.p[:, 0] - moved.p[:, 1]
    low, high = np.percentile(twist, (1, 99))
    visible = high - low > 2.0 * LIMITS.twist_seen * np.hypot(*moved.noise)
    return 0.5 * (low + high), float(high - low) if visible else None


def lines(part: EvenStretch, moved: LowPassedMotion, half_gap: float | None,
          drift_window: float) -> list[DataFinding]:
    """
    Return Lines on the Motion `moved` of a Stretch.

    half_gap: rad, of the model, or None where there is none; drift_window: s.

    Args:
        part: even grid of samples.
        moved: low-passed motion of the segment.
        half_gap: half backlash of the model, rad, or None.
        drift_window: window of the drift estimate, s.
    """
    lines = []
    travels = [float(np.ptp(moved.p[:, i])) for i in (0, 1)]
    still = False
    for i in np.flatnonzero(part.measured).tolist():
        sufficient = travels[i] > LIMITS.travel * max(moved.noise[i], 1e-300)
        still |= not sufficient
        figure = f'{travels[i]:.4g} rad' + ('' if sufficient else ': hardly above noise')
        lines.append(DataFinding(
            'motion', f'travel, {NAMES[i]}', figure,
            '' if sufficient else 'move the joint; check unit and joint name of this encoder',
            {} if sufficient else everything(BAD), {'travel_rad': travels[i]}))
    if still:
        return lines
    i = int(np.flatnonzero(part.measured)[0])
    v = moved.v[:, i]
    fast, rms = float(np.abs(v).max()), float(np.sqrt(np.mean(v ** 2)))
    lines.append(DataFinding('motion', f'speed, {NAMES[i]}',
                             f'rms {rms:.3g}, largest {fast:.3g} rad/s',
                             values={'speed_rms': rms, 'speed_max': fast}))
    turns = len(reversals(v, max(LIMITS.slow_noise * moved.noise_v[i], LIMITS.slow_share * fast)))
    lines.append(reversal_finding(turns, part.duration, NAMES[i]))
    if all(part.measured):
        ratio = _ratio(moved)
        lines.append(ratio)
        if ratio.verdict() == OK:
            lines.append(_traversals(part, moved, half_gap, drift_window))
    return lines


def _ratio(moved: LowPassedMotion) -> DataFinding:
    """Return the Line about arm over motor travel: sign and gear ratio."""
    motor, arm = (moved.p[:, i] - moved.p[:, i].mean() for i in (0, 1))
    slope = float(motor @ arm) / max(float(motor @ motor), 1e-300)
    same = float(motor @ arm) / max(float(np.linalg.norm(motor) * np.linalg.norm(arm)), 1e-300)
    # Noise and backlash flatten the slope of one on the other, not that of their sizes.
    size = float(np.linalg.norm(arm)) / max(float(np.linalg.norm(motor)), 1e-300)
    values = {'slope': slope, 'correlation': same}
    figure = f'arm moves {np.sign(slope) * size:.4g} x the motor, correlation {same:.3f}'
    if abs(same) < 0.5:
        return DataFinding(
            'signs', 'motor and arm', f'{figure}: not one drive',
            'check the joint names: ' 'motor and arm must be the two ends of one gearbox',
            everything(BAD), values)
    if slope < 0.0:
        return DataFinding('signs', 'motor and arm', figure, 'turn the sign of one encoder, or '
                           'make gear_ratio in the model file negative', everything(BAD), values)
    if not LIMITS.ratio_low < size < LIMITS.ratio_high:
        return DataFinding('signs', 'motor and arm', figure,
                           f'multiply gear_ratio in the model file by {1.0 / size:.4g} (--model), '
                           'or check the units', everything(BAD), values)
    return DataFinding('signs', 'motor and arm', figure, values=values)


def _traversals(part: EvenStretch, moved: LowPassedMotion, half_gap: float | None,
                drift_window: float) -> DataFinding:
    """Return the Line about how often the twist goes from one flank to the other."""
    middle, width = swing(moved)
    if width is None:
        return DataFinding('motion', 'gap traversals', 'no twist seen above the noise',
                           'load the joint to and fro; backlash below the noise of the encoders '
                           'cannot be watched', hurts(OK, BAD, WARN), {'traversals': 0})
    flank = LIMITS.flank_swing * width if not half_gap else LIMITS.flank_gap * half_gap
    flank = max(flank, LIMITS.twist_seen * float(np.hypot(*moved.noise)))
    at = reversals(moved.p[:, 0] - moved.p[:, 1] - middle, flank)
    windows = max(1, int(part.duration / drift_window))
    per_window = np.bincount((at * moved.dt / drift_window).astype(int), minlength=windows)
    share = float((per_window[:windows] >= 2).mean())
    values = {'traversals': len(at), 'swing_rad': width, 'windows_share': share}
    figure = (f'{len(at)}, {60 * len(at) / part.duration:.3g} per minute; the twist swings '
              f'{width:.3g} rad')
    if share == 1.0:
        return DataFinding('motion', 'gap traversals', figure, values=values)
    spoilt = hurts(OK, WARN if share >= 0.5 else BAD, OK if len(at) else WARN)
    return DataFinding('motion', 'gap traversals',
                       f'{figure}; in {100 * share:.0f} % of the windows there ' 'and back',
                       f'load both flanks in every {drift_window:g} s: reverse under load', spoilt,
                       values)


def excitation(part: EvenStretch, moved: LowPassedMotion) -> DataFinding:
    """
    Return the Line about whether inertia, friction and offset are distinguishable.

    Args:
        part: even grid of samples.
        moved: low-passed motion of the segment.
    """
    i = int(np.flatnonzero(part.measured)[0])
    step = max(1, len(moved.v) // ROWS)
    v, a = moved.v[::step, i], moved.a[::step, i]
    columns = np.column_stack([a, v, sign(v, moved.noise_v[i]), np.ones(len(v))])
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    condition = float(np.linalg.cond(columns))
    sufficient = condition < LIMITS.excited
    return DataFinding('motion', 'excitation', f'condition {condition:.3g} of acceleration, '
                       'speed, friction, offset', '' if sufficient else
                       'move at several speeds, in both directions, with quick starts and stops',
                       {} if sufficient else hurts(OK, OK, WARN),
                       {'condition': min(condition, 1e300)})


def sign(v: Array, noise: float) -> Array:
    """Return the direction of the speed v [M], soft where it is within the noise."""
    return v / np.sqrt(v * v + (3.0 * noise) ** 2 + 1e-300)
