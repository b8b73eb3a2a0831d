# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the windows have in common makes the gap of each of them sharper.

Friction, torque gain and stiffness change slowly, and much of what a window does not know about
its gap is what it does not know about them. The gap itself stays that of the window.
"""
from dataclasses import replace
import math
from typing import Any

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.features import Backlash

N_COMMON = 4


class PooledFeatures:
    """
    Running means of Backlash.common; all of them restart if a window contradicts one.

    state: what to_list gave, or None.
    """

    def __init__(self, state: Any = None) -> None:
        self._mean, self._variance, self._trend = (
            [[float(v) for v in column] for column in state] if state else self._nothing())
        if {len(self._mean), len(self._variance), len(self._trend)} != {N_COMMON}:
            raise ValueError(f'expected {N_COMMON} numbers')

    @staticmethod
    def _nothing() -> tuple[list[float], list[float], list[float]]:
        return [0.0] * N_COMMON, [math.inf] * N_COMMON, [0.0] * N_COMMON

    def to_list(self) -> list[list[float]]:
        """Return all that the next windows depend on."""
        return [list(self._mean), list(self._variance), list(self._trend)]

    def refine(self, window: Backlash) -> Backlash:
        """Add `window` to the means; return it with the gap that fits them, and its deviation."""
        if not window.separable:  # its gap and stiffness stand for each other
            return window
        pairs = [(value, std ** 2) for value, std in zip(window.common, window.common_std)]
        if self._contradicted(pairs):
            self._mean, self._variance, self._trend = self._nothing()
        own_part = remaining_part = 0.0  # parts of the gap's variance before and now
        for i, (value, variance) in enumerate(pairs):
            if not (math.isfinite(value) and 0.0 < variance < math.inf):
                continue
            prior = self._variance[i] * LIMITS.memory / (LIMITS.memory - 1.0)
            share = 1.0 if math.isinf(prior) else prior / (prior + variance)
            self._mean[i] += share * (value - self._mean[i])
            self._variance[i] = share * variance
            own_part += window.gap_slopes[i] ** 2 * variance
            remaining_part += window.gap_slopes[i] ** 2 * self._variance[i]
        gap, gap_std = window.alone
        known_variance = min(window.gap_std_known, gap_std) ** 2
        if not (math.isfinite(known_variance) and own_part > 0.0):
            return window
        return replace(
            window, gap=window.gap_given(self._mean), gap_alone=gap, gap_alone_std=gap_std,
            gap_std=math.sqrt(known_variance
                              + (gap_std ** 2 - known_variance) * remaining_part / own_part))

    def _contradicted(self, pairs: Any) -> bool:
        contradicted = False
        for i, (value, variance) in enumerate(pairs):
            off = (value - self._mean[i]) / math.sqrt(
                variance + self._variance[i] * LIMITS.memory
                / (LIMITS.memory - 1.0)) if variance > 0.0 else 0.0
            if not math.isfinite(off):
                continue
            self._trend[i] += LIMITS.newest_weight * (off - self._trend[i])
            usual = math.sqrt(LIMITS.newest_weight / (2.0 - LIMITS.newest_weight))
            contradicted |= max(abs(off), abs(self._trend[i]) / usual) > LIMITS.contradicted
        return contradicted
