# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""How the motor's acceleration answers to the commanded torque: its sign and its delay."""
from dataclasses import dataclass
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.presentation import percent, Quantity, said
from gearbox_monitor.signals.checks import NAMES
from gearbox_monitor.signals.finding import (
    BAD, DataFinding, everything, Grade, hurts, judged, OK, WARN)
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.smoothed_motion import HALF_WIDTHS, SmoothedMotion

LAGS = np.arange(-5, 61)  # samples; effort_delay takes -1 to 50
SECONDS = 600.0          # of a recording that are looked at
BLOCKS, BLOCK_SECONDS = 24, 5.0
HINGES = 6               # bends of the torque over the twist
ROWS = 100_000


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
        bends = np.quantile(twist[::max(1, len(twist) // ROWS)], np.linspace(0.02, 0.98, HINGES))
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
    rounded, wrong = int(np.rint(delay)), abs(delay - stated) > max(0.7, LIMITS.certain * std)
    code, grades = 'delay', hurts(WARN, WARN, WARN) if wrong else {}
    if not response.timed:
        code = ('delay_hidden' if not response.seen else
                'delay_beyond' if response.at_edge else 'delay_vague')
        grades = hurts(WARN, OK, WARN)
    elif wrong and not LIMITS.delay_earliest <= rounded <= LIMITS.delay_latest:
        code = 'delay_late' if rounded < 0 else 'delay_early'
    return judged('torque', 'effort delay', said(
        code, size=Quantity(delay, std), ms=1e3 * dt, stated=stated, rounded=rounded,
        count=abs(rounded), correlation=abs(response.correlation)), grades, {
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
