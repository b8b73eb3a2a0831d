# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""History of the growth, fine where new and coarse where old, and when it reaches a limit."""
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, UTC
import math
from typing import Any

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS

SECOND = 1_000_000_000
PER_SIZE = 16  # blocks of one size, before the two oldest of them become one


@dataclass(frozen=True)
class Trend:
    """Growth now, its slope per second, their standard deviations, and the stamp it is about."""

    stamp_ns: int
    growth: float
    growth_std: float
    slope: float
    slope_std: float

    @property
    def found(self) -> bool:
        """Whether there is a trend upwards."""
        return self.slope > LIMITS.trend_deviations * self.slope_std

    def reach(self, limit: float) -> tuple[float, float, float] | None:
        """
        Return (seconds, earliest, latest) until the growth is `limit`, 95 %; None without a trend.

        latest is inf where the slope may be that small.
        """
        if not self.found:
            return None
        remaining = limit - self.growth
        if remaining <= 0.0:
            return 0.0, 0.0, 0.0
        slow = self.slope - 2.0 * self.slope_std
        return (remaining / self.slope,
                max(remaining - 2.0 * self.growth_std, 0.0) / (self.slope + 2.0 * self.slope_std),
                (remaining + 2.0 * self.growth_std) / slow if slow > 0.0 else math.inf)


class GrowthHistory:
    """`blocks` [stamp_ns, growth, variance of it, windows], oldest first."""

    def __init__(self, blocks: Iterable[Any] = ()) -> None:
        self.blocks = [list(b) for b in blocks]

    def add(self, stamp_ns: int, growth: float, variance: float) -> None:
        """
        Add a window and merge the oldest blocks, so that their number grows as a logarithm.

        Args:
            stamp_ns: end of the window.
            growth: its relative growth.
            variance: of the growth.

        """
        self.blocks.append([int(stamp_ns), growth, variance, 1])
        size = 1
        while True:
            same = [i for i, b in enumerate(self.blocks) if b[3] == size]
            if len(same) <= PER_SIZE:
                return
            i, j = same[0], same[1]
            a, b = self.blocks[i], self.blocks[j]
            wa, wb = 1.0 / a[2], 1.0 / b[2]
            share = wb / (wa + wb)
            self.blocks[i:j + 1] = [[
                a[0] + round(share * (b[0] - a[0])), a[1] + share * (b[1] - a[1]),
                1.0 / (wa + wb), a[3] + b[3]]]
            size *= 2

    def trend(self, since_ns: int) -> Trend | None:
        """Return the Trend of what came after `since_ns`, None where that is too little."""
        rows = [b for b in self.blocks if b[0] > since_ns]
        if len(rows) < LIMITS.trend_blocks:
            return None
        last = rows[-1][0]
        t = np.array([(b[0] - last) * 1e-9 for b in rows])
        y, w = np.array([b[1] for b in rows]), np.array([1.0 / b[2] for b in rows])
        middle, level = np.average(t, weights=w), np.average(y, weights=w)
        spread = w @ (t - middle) ** 2
        if not spread > 0.0:
            return None
        slope = w @ ((t - middle) * (y - level)) / spread
        # A curve that is no line states less than it should: take its misfit where that is more.
        misfit = w @ (y - level - slope * (t - middle)) ** 2 / (len(rows) - 2)
        inflation = max(misfit, 1.0)
        return Trend(last, float(level - slope * middle),
                     math.sqrt(inflation * (1.0 / w.sum() + middle ** 2 / spread)), float(slope),
                     math.sqrt(inflation / spread))


def when(stamp_ns: int) -> str:
    """Return `stamp_ns` in words: UTC, or seconds where the clock is a simulated one."""
    if stamp_ns < 10 ** 9 * SECOND:
        return f't = {stamp_ns / SECOND:.1f} s'
    return datetime.fromtimestamp(stamp_ns // SECOND, UTC).strftime(
        '%Y-%m-%d %H:%M:%S UTC')


def span(seconds: float) -> str:
    """Return a time span of `seconds` in words."""
    if not math.isfinite(seconds):
        return 'never'
    for unit, size in (('d', 86400.0), ('h', 3600.0), ('min', 60.0)):
        if seconds >= 2 * size:
            return f'{seconds / size:.0f} {unit}'
    return f'{seconds:.0f} s'
