# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Torque signals that move a simulated drive."""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import math

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import Noise, Plant, Trajectory

KINDS = ('multisine', 'chirp', 'square', 'triangle', 'none')


class Excitation:
    """
    A motor torque u(t) in N m from `amplitudes` a_i (N m) and `frequencies` f_i (Hz).

    kind: multisine, sum of a_i cos(2 pi f_i t); a cosine, because a sine from rest leaves the
    drive several rad away from where it started. chirp: a_1 cos with the frequency swept from f_1
    to f_2 (Hz) and back within `period` s. square, triangle: amplitude a_1, frequency f_1.
    none: zero.
    """

    def __init__(self, kind: str = 'multisine', amplitudes: Sequence[float] = (6.0, 2.0),
                 frequencies: Sequence[float] = (0.9, 2.3), period: float = 20.0) -> None:
        if kind not in KINDS:
            raise InputError(f'excitation: {kind!r}, expected one of {", ".join(KINDS)}')
        needed = {'multisine': len(amplitudes), 'chirp': 2, 'none': 0}.get(kind, 1)
        if len(frequencies) < needed or (kind != 'none' and not len(amplitudes)):
            raise InputError(f'excitation: {len(amplitudes)} amplitudes and {len(frequencies)} '
                             f'frequencies, expected {needed} frequencies for {kind}')
        self.kind = kind
        self.amplitudes = np.asarray(amplitudes, float)
        self.frequencies = np.asarray(frequencies, float)
        self.period = float(period)

    def torque(self, t: Array) -> Array:
        """Return u (N m), of the shape of `t` (s)."""
        t = np.asarray(t, float)
        a, f = self.amplitudes, self.frequencies
        if self.kind == 'none':
            return np.zeros_like(t)
        if self.kind == 'multisine':
            return sum((ai * np.cos(2 * np.pi * fi * t) for ai, fi in zip(a, f)),
                       np.zeros_like(t))
        if self.kind == 'chirp':
            half = 0.5 * self.period
            s = np.mod(t, self.period)
            s = np.where(s > half, s - self.period, s)  # there and back: the phase is even in s
            rate = (f[1] - f[0]) / half
            return a[0] * np.cos(2 * np.pi * (f[0] * np.abs(s) + 0.5 * rate * s * s))
        phase = np.mod(t * f[0], 1.0)
        if self.kind == 'square':
            return np.where(phase < 0.5, a[0], -a[0])
        return a[0] * (1.0 - 4.0 * np.abs(phase - 0.5))


GROWTH_STEP = 0.01  # s: a growing gap is held constant for so long
MAX_DELAY = 1.0     # s of readings that are kept for a delay
JOINTS = ('motor', 'arm')


@dataclass(frozen=True)
class EncoderFault:
    """
    What is wrong with one encoder; the defaults are a healthy one.

    The reading is scale x (true position) + noise x (its noise), every so often with an outlier of
    +-outlier_size (rad; `outlier_rate` is the share of samples), `delay` s late (in whole
    samples, up to MAX_DELAY). frozen: the last reading stays. lost: none comes, which is NaN.
    """

    frozen: bool = False
    lost: bool = False
    delay: float = 0.0
    scale: float = 1.0
    noise: float = 1.0
    outlier_rate: float = 0.0
    outlier_size: float = 0.0


HEALTHY = EncoderFault()


@dataclass(frozen=True)
class Faults:
    """
    Faults of a drive, in force from `start` s of simulated time on, for `duration` s.

    motor, arm: EncoderFault. torque: torque that acts over torque commanded. viscous_friction,
    coulomb_friction (of the motor), stiffness, gap: factors on the model's values. Beside them,
    with a start of its own and no end, the gap grows slowly: its factor is
    1 + min(gap_growth_rate (t - gap_growth_start), gap_growth_max), rate in 1/s.
    """

    start: float = 0.0
    duration: float = math.inf
    motor: EncoderFault = field(default=HEALTHY)
    arm: EncoderFault = field(default=HEALTHY)
    torque: float = 1.0
    viscous_friction: float = 1.0
    coulomb_friction: float = 1.0
    stiffness: float = 1.0
    gap: float = 1.0
    gap_growth_rate: float = 0.0
    gap_growth_start: float = 0.0
    gap_growth_max: float = math.inf

    def growth(self, t: float) -> float:
        """Return the relative growth of the gap that `t` s have brought."""
        return min(self.gap_growth_rate * max(0.0, t - self.gap_growth_start),
                   self.gap_growth_max)

    def model(self, model: DriveModel, active: bool, t: float) -> DriveModel:
        """
        Return the drive with its faults.

        Args:
            model: the healthy DriveModel.
            active: whether the faults with a start are in force.
            t: time, s.

        Returns:
            The DriveModel at that time.
        """
        gap = 1.0 + self.growth(t)
        if not active and gap == 1.0:
            return model
        shape, f = model.transmission, self if active else Faults()
        return replace(
            model, viscous_friction=model.viscous_friction * f.viscous_friction,
            coulomb_friction=model.coulomb_friction * f.coulomb_friction,
            transmission=replace(shape, stiffness=shape.stiffness * f.stiffness,
                                 half_gap=shape.half_gap * (f.gap * gap)))


class Encoders:
    """
    Readings of the two encoders with their faults; remembers what delay and freezing need.

    Outliers come from a generator of their own with the plant's `seed`: the noise of a healthy
    drive stays what it is.
    """

    def __init__(self, seed: int = 0) -> None:
        # The third child of the seed; the plant uses the first two.
        self._random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(2,)))
        self._past = [np.empty(0), np.empty(0)]  # readings before they are delayed, newest last
        self._shown = [math.nan, math.nan]       # last readings given out

    def read(self, x: Array, y: Array, dt: float, faults: Faults, active: bool) -> Array:
        """
        Return what the encoders read.

        Args:
            x: true positions [N, 2], rad.
            y: readings of healthy encoders [N, 2], rad.
            dt: time between them, s.
            faults: Faults.
            active: whether they are in force, over the whole block.

        Returns:
            Readings [N, 2], rad.
        """
        # Outliers are drawn for both encoders at once: one does not move the other's.
        chance = None
        if active and (faults.motor.outlier_rate > 0.0 or faults.arm.outlier_rate > 0.0):
            chance = self._random.random((len(y), 2, 2))
        return np.stack([
            self._one(i, x[:, i], y[:, i], dt, getattr(faults, joint) if active else HEALTHY,
                      None if chance is None else chance[:, i])
            for i, joint in enumerate(JOINTS)], axis=1)

    def _one(self, i: int, x: Array, y: Array, dt: float, fault: EncoderFault,
             chance: Array | None) -> Array:
        reading = y
        if fault.noise != 1.0 or fault.scale != 1.0:
            reading = fault.scale * x + fault.noise * (y - x)
        if chance is not None and fault.outlier_rate > 0.0:
            sign = np.where(chance[:, 1] < 0.5, -fault.outlier_size, fault.outlier_size)
            reading = reading + np.where(chance[:, 0] < fault.outlier_rate, sign, 0.0)
        # Kept while healthy, too: a delay that begins finds the readings it delays.
        history = np.concatenate([self._past[i], reading])
        self._past[i] = history[-round(MAX_DELAY / dt):]
        delay = round(fault.delay / dt)
        if delay:
            at = len(history) - len(reading) - delay + np.arange(len(reading))
            reading = history[np.maximum(at, 0)]  # before the first of all: the first
        if fault.frozen and len(reading):
            frozen = self._shown[i] if math.isfinite(self._shown[i]) else reading[0]
            reading = np.full(len(reading), frozen)
        if len(reading):
            self._shown[i] = float(reading[-1])
        return np.full(len(reading), math.nan) if fault.lost else reading


class FaultyPlant:
    """
    A simulated drive with faults; `model`, plant.noise and `faults` may be replaced meanwhile.

    Without faults its samples are those of simulate.Plant (which has `seed`), bit for bit.
    """

    def __init__(self, model: DriveModel, noise: Noise | None = None, seed: int = 0,
                 faults: Faults | None = None) -> None:
        self.plant, self.encoders = Plant(model, noise, seed), Encoders(seed)
        self.model, self.faults = model, faults or Faults()
        self._in_force: object = None

    def run(self, u: Array, dt: float, t0: float = 0.0) -> Trajectory:
        """
        Apply a torque and return what the drive does.

        Args:
            u: torque [N], held over a sample, N m.
            dt: length of a sample, s.
            t0: time at the begin, s.

        Returns:
            The Trajectory.
        """
        u = np.ascontiguousarray(u, float)
        first = round(t0 / dt)  # samples are counted: sums of dt would differ by how they are cut
        cuts = self._cuts(first, first + len(u), dt)
        parts = [self._part(u[a - first:b - first], a, dt) for a, b in zip(cuts, cuts[1:])]
        names = ('t', 'y', 'x', 'tau_k', 'tau_arm')
        columns = {n: np.concatenate([getattr(p, n) for p in parts]) for n in names}
        return Trajectory(u=u, **columns)

    def _cuts(self, begin: int, end: int, dt: float) -> list[int]:
        """Return samples from `begin` to `end`, both included, between which nothing changes."""
        f = self.faults
        inner = {_sample(f.start, dt), _sample(f.start + f.duration, dt)}
        if f.gap_growth_rate > 0.0:
            # Only while it grows: from the start until the largest growth has been reached.
            step = max(1, round(GROWTH_STEP / dt))
            grown = f.gap_growth_start + f.gap_growth_max / f.gap_growth_rate
            low = int(max(begin, _sample(f.gap_growth_start, dt)))
            high = min(end, _sample(grown, dt) + step)
            inner |= set(range(-(-low // step) * step, int(high) + 1, step))
        return [begin, *sorted(int(k) for k in inner if begin < k < end), end]

    def _part(self, u: Array, k: int, dt: float) -> Trajectory:
        """Run from sample `k` on; nothing changes meanwhile."""
        f = self.faults
        active = _sample(f.start, dt) <= k < _sample(f.start + f.duration, dt)
        step = max(1, round(GROWTH_STEP / dt))
        state = (active, f.growth(k // step * step * dt), f, self.model)
        if state != self._in_force:
            self._in_force = state
            # Folded: a fault's factors act on values that effects have replaced, too.
            self.plant.model = f.model(self.model.folded(), active, k // step * step * dt)
        run = self.plant.run(f.torque * u if active and f.torque != 1.0 else u, dt, k * dt)
        y = self.encoders.read(run.x[:, :2], run.y, dt, f, active)
        return replace(run, t=(k + np.arange(len(u))) * dt, y=y)


def _sample(t: float, dt: float) -> float:
    """Return the number of the first sample at or after `t` s (inf for never)."""
    return math.ceil(t / dt - 1e-6) if math.isfinite(t) else math.inf
