# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Torque signals that move a simulated drive."""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array

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
