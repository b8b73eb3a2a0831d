# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The motion of a drive: torque and positions through one low pass, speeds, accelerations."""
from collections.abc import Sequence

import numpy as np
import scipy

from gearbox_monitor.kernels.elementary import quantisation_step, white_noise_std
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.uniform import UniformRecording

HALF_WIDTHS = (0.006, 0.012, 0.024, 0.048, 0.096)  # s, of the low pass
FITTED = (0.015, 0.03, 0.06, 0.12)  # where the equations of a model are fitted


def constant_runs(x: Array) -> tuple[Integers, Integers]:
    """Return (starts, lengths) of the runs of one value in x [N]."""
    starts = np.append(0, np.flatnonzero(np.diff(x)) + 1)
    return starts, np.diff(np.append(starts, len(x)))


def noise_of(y: Array) -> tuple[float, float]:
    """
    Return (noise, step of the lattice or 0) of readings y [N] (rad), NaN: not measured.

    Where most of them are one value, the encoder has stuck: noise is that of the longest rest.
    """
    readings = y[np.isfinite(y)]
    starts, lengths = constant_runs(readings)
    if len(starts) > 4 and lengths.max() > 0.5 * len(readings):
        k = int(lengths.argmax())
        readings = max(readings[:starts[k]], readings[starts[k] + lengths[k]:], key=len)
    quantum = quantisation_step(readings)
    return white_noise_std(readings, quantum), quantum


class SmoothedMotion:
    """
    Torque and positions smoothed alike, with the positions' derivatives, every few samples.

    u [M] N m; p, v, a [M, 2] rad, rad/s, rad/s^2, exact differences of one low pass; k [M] samples
    they stand at; noise, noise_v, noise_a [2], their remaining noise; kernels [3, 2 n + 1] that
    make p, v and a of positions. Half as wide as the first of `widths` s that the noise allows.
    """

    p: Array
    v: Array
    a: Array
    noise: Array
    noise_v: Array
    noise_a: Array
    kernels: Array

    def __init__(self, recording: UniformRecording, sigma: Array,
                 widths: Sequence[float] = FITTED, whole: bool = False) -> None:
        self.recording, self.sigma, self.dt = recording, sigma, recording.dt
        for half_width in widths:
            self._smooth(half_width)
            channels = list(recording.channels)
            if (self.noise_a <= LIMITS.acceleration_noise * self.a.std(axis=0))[channels].all():
                break
        n = self.kernels.shape[1] // 2
        self.half_width = half_width
        self._decimated = slice(None, None, 1 if whole else max(1, n // 3))
        self.k = np.arange(n, len(recording.y) - n)[self._decimated]
        self.p, self.v, self.a = (x[self._decimated] for x in (self.p, self.v, self.a))
        self.u = self.filtered(recording.torque)

    def _smooth(self, half_width: float) -> None:
        """Smooth positions over `half_width` s."""
        r = self.recording
        n = max(3, round(half_width / r.dt))
        weights = (1.0 - (np.arange(-n, n + 1) / (n + 1)) ** 2) ** 4
        weights /= weights.sum()
        before, at, after = (np.pad(weights, pad) for pad in ((0, 2), (1, 1), (2, 0)))
        self.kernels = np.array([at, (before - after) / (2.0 * r.dt),
                                 (before - 2.0 * at + after) / r.dt ** 2])
        low = scipy.signal.oaconvolve(r.y - r.y[0], weights[:, None], 'valid', axes=0)
        self.p = low[1:-1] + r.y[0]
        self.v = (low[2:] - low[:-2]) / (2.0 * r.dt)
        self.a = (low[2:] - 2.0 * low[1:-1] + low[:-2]) / r.dt ** 2
        self.noise, self.noise_v, self.noise_a = (
            self.sigma * np.linalg.norm(kernel) for kernel in self.kernels)

    def filtered(self, signal: Array) -> Array:
        """Return a `signal` [N] or [N, C] through the low pass of the positions [M]."""
        kernel = self.kernels[0] if signal.ndim == 1 else self.kernels[0][:, None]
        smooth: Array = scipy.signal.oaconvolve(signal, kernel, 'valid', axes=0)[self._decimated]
        return smooth

    @property
    def i(self) -> int:
        """The first encoder that is there: 0 or 1."""
        return self.recording.channels[0]

    @property
    def swing(self) -> tuple[float, float | None]:
        """(middle, swing) of the twist, rad; swing None where it is only noise."""
        low, high = np.percentile(self.p[:, 0] - self.p[:, 1], (1, 99))
        visible = high - low > 2.0 * LIMITS.twist_seen * np.hypot(*self.noise)
        return 0.5 * (low + high), float(high - low) if visible else None

    def direction(self, i: int) -> Array:
        """Return the direction of the speed of side `i` [M], soft where it is within the noise."""
        v, noise = self.v[:, i], float(self.noise_v[i])
        return np.asarray(v / np.sqrt(v * v + (3.0 * noise) ** 2 + 1e-300))


def reversals(v: Array, slow: float) -> Integers:
    """Return the samples at which the speed v [M] has gone from beyond one `slow` to the other."""
    side = np.sign(v) * (np.abs(v) > slow)
    at = np.flatnonzero(side)
    return at[1:][np.diff(side[at]) != 0]
