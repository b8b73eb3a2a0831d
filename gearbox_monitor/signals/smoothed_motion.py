# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Torque and positions of a recording through one low pass, with the positions' derivatives."""
import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.signals.uniform import UniformRecording

HALF_WIDTHS = (0.015, 0.03, 0.06, 0.12)  # s, of the smoothing


class SmoothedMotion:
    """
    Torque and positions smoothed alike, with the positions' derivatives, every few samples.

    u [M] N m; p, v, a [M, 2] rad, rad/s, rad/s^2; k [M] samples they stand at; noise, noise_v,
    noise_a [2], their remaining noise; kernels [3, 2 n + 1] that make p, v and a of positions.
    As wide as the noise requires, and half the width `shortest` s.
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
        self.half_width, self.kernels = half_width, kernels
        decimated = self._decimated = slice(None, None, max(1, n // 3))
        self.k = np.arange(n, len(r.u) - n)[decimated]
        self.a = a[decimated]
        self.p, self.v = (np.column_stack(
            [np.convolve(y - y[0], kernels[i],
                         'valid') for y in r.y.T])[decimated] for i in (0, 1))
        self.p += r.y[0]
        self.u = self.filtered(r.torque)
        self.noise = sigma * np.sqrt((kernels[0] ** 2).sum())
        self.noise_a = sigma * gain
        self.noise_v = sigma * np.sqrt((kernels[1] ** 2).sum())

    def filtered(self, signal: Array) -> Array:
        """Return a `signal` [N] through the low pass of the positions [M]."""
        smooth: Array = np.convolve(signal, self.kernels[0], 'valid')[self._decimated]
        return smooth


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
