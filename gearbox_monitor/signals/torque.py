# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The commanded torque: readings, limits, sign and delay."""
from dataclasses import dataclass
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.signals.encoders import constant_runs, NAMES, Noises
from gearbox_monitor.signals.excitation_checks import (
    low_pass, LowPassedMotion, motion, sign, swing)
from gearbox_monitor.signals.finding import BAD, DataFinding, everything, hurts, OK, WARN
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.stretch import EvenStretch

LAGS = np.arange(-5, 61)  # samples; effort_delay takes -1 to 50
SECONDS = 600.0          # of a recording that are looked at
BLOCKS, BLOCK_SECONDS = 24, 5.0
HINGES = 6               # bends of the torque over the twist
LIGHT = 0.005            # s, half width of the low pass before what bends
ROWS = 100000


def lines(u: Array, part: EvenStretch, has_setpoint: bool = False) -> list[DataFinding]:
    """
    Return Lines on torques u [N] N m as recorded (NaN: none), and on those of a Stretch.

    Args:
        u: torque as recorded [N], N m; NaN: not measured.
        part: even grid of samples.
        has_setpoint: whether a setpoint is recorded.
    """
    share = float(np.isnan(u).mean())
    values = {'missing_share': share}
    if share == 1.0 and has_setpoint:
        return [DataFinding('torque', 'readings', 'none, but a setpoint is recorded',
                            'for diagnose give a model file with the key controller, for '
                            'estimation record the torque', hurts(BAD, BAD, WARN), values)]
    if share > LIMITS.missing_many or part.u is None:
        return [DataFinding('torque', 'readings', 'none' if share == 1.0 else
                            f'{100 * share:.3g} % missing or NaN',
                            'publish the commanded torque as effort of the motor joint',
                            everything(BAD), values)]
    torque = u[np.isfinite(u)]
    rms, span = float(np.sqrt(np.mean(torque ** 2))), float(np.ptp(torque))
    values.update(rms=rms, low=float(torque.min()), high=float(torque.max()))
    figure = f'rms {rms:.3g} N m, {torque.min():.3g} to {torque.max():.3g} N m'
    if span == 0.0:
        return [DataFinding('torque', 'readings', f'{torque[0]:.4g} N m throughout',
                            'check that effort is the commanded torque; then move',
                            everything(BAD), values)]
    grade = WARN if share > LIMITS.missing_notice else OK
    if share:
        figure += f'; {100 * share:.2g} % missing or NaN'
    lines = [DataFinding('torque', 'readings', figure, '' if grade == OK else
                         'publish effort with every position',
                         hurts(grade, grade, BAD if grade else OK), values)]
    return lines + limits(torque)


def limits(u: Array) -> list[DataFinding]:
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
    noise = noises[i]
    valid = np.isfinite(u)
    if noise is None or valid.sum() < 10 or np.ptp(u[valid]) == 0.0:
        return []
    u, p, t = u[valid], y[valid, i], seconds[valid]
    starts, lengths = constant_runs(u)
    ends = starts + lengths
    long = np.flatnonzero(t[ends - 1] - t[starts] >= LIMITS.still)
    elsewhere = len(u) - int(lengths[long].sum())
    if not len(long) or len(starts) - len(long) < LIMITS.lively * max(elsewhere, 1):
        return []
    runs = [slice(starts[k], ends[k]) for k in long
            if _travel(p[starts[k]:ends[k]]) > LIMITS.stuck_travel * (noise[0] + noise[1])]
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


def _travel(positions: Array) -> float:
    """Return how far positions [N] (NaN: not measured) go."""
    positions = positions[np.isfinite(positions)]
    return float(np.ptp(positions)) if len(positions) else 0.0


def setpoint(part: EvenStretch, moved: LowPassedMotion) -> list[DataFinding]:
    """
    Return the finding about a torque that is a position's setpoint, if it is one.

    A setpoint has the slope 1 over the position that follows it, and nothing else in it.

    Args:
        part: even grid of samples.
        moved: low-passed motion of the segment.
    """
    assert moved.u is not None
    u = moved.u - moved.u.mean()
    for i in np.flatnonzero(part.measured).tolist():
        p = moved.p[:, i] - moved.p[:, i].mean()
        for late in range(min(int(LIMITS.behind / part.dt), len(u) // 4)):
            x, y = p[late:], u[:len(u) - late]
            slope = float(x @ y) / max(float(x @ x), 1e-300)
            if (abs(slope - 1.0) < LIMITS.setpoint_share
                    and np.std(y - slope * x) < LIMITS.setpoint_share * np.std(y)):
                return [DataFinding(
                    'torque', 'setpoint', f'the torque equals the position of the {NAMES[i]} '
                    f'{late * part.dt:.2g} s later (slope {slope:.3f}): a setpoint',
                    'log the commanded torque as effort, not the reference position',
                    everything(BAD), {'slope': slope})]
    return []


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
        return self.seen and not self.at_edge and self.delay_std < LIMITS.delay_vague


def answer(part: EvenStretch, sigma: Array, width: int) -> TorqueResponse | None:
    """
    Return the Answer of a Stretch to its torque, or None where it is too short.

    sigma [2] rad: noise of the encoders; width: of the low pass, samples. The first SECONDS are
    enough. The torque u_k, held from t_k to t_k+1, makes the central second difference
    of the positions at t_k by (u_k-1 + u_k) / 2, exactly; both go through the same low pass. What
    depends on speed, friction, position and twist (a bent line) is taken out of either. Standard
    errors: jackknife over blocks of time, and what another low pass changes.

    Args:
        part: even grid of samples.
        sigma: noise of the encoders [2], rad.
        width: half width of the low pass, samples.
    """
    part, i = part.first(SECONDS), int(np.flatnonzero(part.measured)[0])
    moved = motion(part, sigma, width)
    narrow = _regressed(part, moved, i)
    wide = _regressed(part, motion(part, sigma, 2 * width), i)
    if narrow is None or wide is None or moved.u is None:
        return None
    (whole, spread), (wider, _) = narrow, wide
    x = np.diff(moved.p[:, i])
    work = moved.u[:-1] * x
    whole_work = max(np.abs(work).sum(), 1e-300)
    by_block = np.array([block.sum() for block in np.array_split(work, BLOCKS)])
    return TorqueResponse(
        float(whole[0]), math.hypot(spread[0], whole[0] - wider[0], LIMITS.delay_method),
        float(whole[2]),
        float(whole[1]), math.hypot(spread[1], whole[1] - wider[1]), bool(whole[3]),
        float(work.sum() / whole_work),
        float(math.sqrt(BLOCKS) * by_block.std() / whole_work))


def _regressed(part: EvenStretch, moved: LowPassedMotion, i: int) -> tuple[Peak, Array] | None:
    """Return (result of _best, standard errors of delay and gain), None where too short."""
    u, *columns = _columns(part, moved, i)
    blocks = _blocks(len(u), part.dt, moved.width)
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


def _columns(part: EvenStretch, moved: LowPassedMotion, i: int) -> list[Array]:
    """
    Return [M] each: torque, acceleration, and all that this depends on beside the torque.

    What bends is bent before the low pass, as it was on the drive.
    """
    light = motion(part, moved.sigma, max(1, round(LIGHT / part.dt)))
    bent = [sign(light.v[:, i], light.noise_v[i])]
    two = all(part.measured) and swing(moved)[1] is not None
    if two:
        twist = light.p[:, 0] - light.p[:, 1]
        bends = np.quantile(twist[::max(1, len(twist) // ROWS)], np.linspace(0.02, 0.98, HINGES))
        bent += [np.maximum(twist - bend, 0.0) for bend in (twist.min(), *bends)]
    bent = [low_pass(column, moved.width) for column in bent]
    same = slice(light.width, light.width + len(bent[0]))  # samples of the recording
    assert moved.u is not None
    straight = [moved.u, moved.a[:, i], moved.v[:, i], moved.p[:, i]]
    straight += [moved.v[:, 1]] if two else []
    return [*(column[same] for column in straight), *bent]


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
    Return what a TorqueResponse shows of delay and sign (None: the stretch is too short).

    dt: s between samples; stated: parameter effort_delay; i: encoder that was used, 0 or 1.

    Args:
        response: response of the acceleration to the torque, None if too short.
        dt: sample time, s.
        stated: parameter effort_delay, samples.
        i: encoder that was used, 0 or 1.
    """
    if response is None:
        return [DataFinding('torque', 'effort delay', 'too short', 'record 10 s or more',
                            hurts(WARN, OK, WARN))]
    return [_delay(response, dt, stated), _sign(response, NAMES[i])]


def _delay(response: TorqueResponse, dt: float, stated: int) -> DataFinding:
    values = {'delay_samples': response.delay, 'delay_std_samples': response.delay_std,
              'correlation': response.correlation}
    if not response.timed:
        reason = 'the torque hardly shows in the acceleration' if not response.seen else \
            'beyond what is tried' if response.at_edge else \
            f'{response.delay:.1f} +- {response.delay_std:.1f} samples'
        return DataFinding('torque', 'effort delay', f'not determined: {reason} '
                           f'(correlation {abs(response.correlation):.2f})',
                           'accelerate more, quick starts and stops', hurts(WARN, OK, WARN),
                           values)
    figure = (f'{response.delay:.2f} +- {response.delay_std:.2f} samples, '
              f'{response.delay * dt * 1e3:.3g} +- {response.delay_std * dt * 1e3:.2g} ms')
    rounded = int(np.rint(response.delay))
    off = abs(response.delay - stated) > max(0.7, LIMITS.certain * response.delay_std)
    if not off:
        return DataFinding('torque', 'effort delay', f'{figure}; effort_delay is {stated}',
                           values=values)
    if not LIMITS.delay_earliest <= rounded <= LIMITS.delay_latest:
        return DataFinding('torque', 'effort delay', f'{figure}; effort_delay is {stated}, and '
                           f'takes {LIMITS.delay_earliest} to {LIMITS.delay_latest}',
                           f'stamp the torque when it acts: it is logged {abs(rounded)} samples '
                           f'too {"late" if rounded < 0 else "early"}',
                           hurts(WARN, WARN, WARN), values)
    return DataFinding('torque', 'effort delay', f'{figure}; effort_delay is {stated}',
                       f'set effort_delay: {rounded} in the parameter file; for diagnose, log the '
                       'torque when it acts', hurts(WARN, WARN, WARN), values)


def _sign(response: TorqueResponse, name: str) -> DataFinding:
    values = {'gain': response.gain, 'gain_std': response.gain_std, 'work': response.work,
              'work_std': response.work_std}
    figure = (f'1 N m gives {response.gain:.3g} +- {response.gain_std:.1g} rad/s^2'
              if response.seen else f'net work {100 * response.work:+.0f} +- '
              f'{100 * response.work_std:.0f} % of its amounts')
    size, error = ((response.gain, response.gain_std) if response.seen else
                   (response.work, max(response.work_std, LIMITS.work / LIMITS.certain)))
    if size < -LIMITS.certain * error:
        return DataFinding('signs', f'torque and {name}', f'{figure}: the wrong way',
                           'turn the sign of ' f'the effort, or of the {name} position',
                           everything(BAD), values)
    if size < 0.0 or not response.seen and response.work < LIMITS.work:
        return DataFinding('signs', f'torque and {name}', f'{figure}: not determined',
                           'accelerate more, or move against friction', everything(WARN), values)
    return DataFinding('signs', f'torque and {name}', figure, values=values)
