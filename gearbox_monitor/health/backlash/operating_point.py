# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Operating points: where windows were measured, and how much they scatter there.

A window belongs to the known point whose centre is nearest, if it lies within half a bin of it in
every coordinate; otherwise it starts a new point with itself as the centre. So a drive that works
around one point has one point, not two halves of neighbouring bins.
"""
from dataclasses import dataclass, field, replace
import math
from typing import Self

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change_tests import FEATURES, HYSTERESIS, WEAR
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.kernels.types import Array

TINY = 1e-9
N = len(FEATURES)
DIFFERENCE = 2.0 / 3.0  # part of a window that a difference of neighbours tells: they share it


def _zeros() -> Array:
    return np.zeros(N)


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """
    An operating point and the noise of its windows; arrays are [F].

    angle (rad), speed (rad/s), load (N m), temperature (deg C, None = not measured): its centre.
    scale: load that a change of the hysteresis is divided by. stated, stated_count: mean of the
    variances that windows state, of so many. squares, freedom: of the noise, by differences of
    neighbours (von Neumann, 1941), which neither steps nor slopes of the wear touch. previous,
    kelvin: the window before. last_ns: its newest.
    """

    angle: float
    speed: float
    load: float
    temperature: float | None
    scale: float
    stated: Array = field(default_factory=_zeros)
    stated_count: Array = field(default_factory=_zeros)
    squares: Array = field(default_factory=_zeros)
    freedom: Array = field(default_factory=_zeros)
    previous: Array = field(default_factory=lambda: np.full(N, np.nan))
    kelvin: float = 0.0
    last_ns: int = 0

    def unit(self, column: int) -> float:
        """Return what the feature in `column` is divided by if it is not logarithmic."""
        return self.scale if column == HYSTERESIS else 1.0

    def text(self) -> str:
        """Return the point in words."""
        text = f'{self.angle:.2g} rad, {self.speed:.2g} rad/s, {self.load:.2g} N m'
        return text + ('' if self.temperature is None else f', {self.temperature:.0f} deg C')

    def with_stated(self, variances: Array) -> Self:
        """Return the point with the stated `variances` [F] of a window in their means."""
        finite = np.isfinite(variances)
        count = self.stated_count + finite
        return replace(self, stated_count=count, stated=self.stated + np.where(
            finite, np.nan_to_num(variances) - self.stated, 0.0) / np.maximum(count, 1.0))

    def with_window(self, values: Array, kelvin: float, slopes: Array, excess: float
                    ) -> tuple[Self, Array]:
        """
        Take the difference of a window to the previous one into the noise.

        Args:
            values: of the window [F].
            kelvin: its temperature.
            slopes: temperature coefficients [F].
            excess: its variance over the usual one.

        Returns:
            The point, and the difference in standard deviations of one window [F], NaN: none.

        """
        off = values - self.previous - slopes * (kelvin - self.kelvin)
        std = np.sqrt(2.0 * excess * self.variance())
        with np.errstate(divide='ignore', invalid='ignore'):
            off = np.clip(off / std, -LIMITS.deviations, LIMITS.deviations)
        finite, fresh = np.isfinite(off), np.isfinite(values)
        return replace(
            self, squares=self.squares + DIFFERENCE * np.where(
                finite, np.nan_to_num(off) ** 2 * self.variance(), 0.0),
            freedom=self.freedom + DIFFERENCE * finite,
            previous=np.where(fresh, values, self.previous),
            kelvin=kelvin if fresh.any() else self.kelvin), off

    def variance(self) -> Array:
        """Return the variance [F] of one window: what was stated counts as some windows."""
        prior = WEAR.prior_windows * WEAR.stated_excess ** 2 * self.stated
        result: Array = (prior + self.squares) / (WEAR.prior_windows + self.freedom)
        return result


@dataclass(frozen=True)
class Bins:
    """
    Widths of an operating point: angle (rad, or m), speed and load (ratios), temperature (K).

    0, or 1 for a ratio: one bin. turns: whether angles repeat after a turn.
    """

    angle: float = 3.2
    speed: float = 2.0
    load: float = 2.0
    temperature: float = 5.0
    turns: bool = True


def find_point(points: tuple[OperatingPoint, ...], window: Backlash,
               temperature: float | None, bins: Bins) -> tuple[tuple[OperatingPoint, ...], int]:
    """
    Return the operating points, with a new one if none is near, and the index of a window's.

    Args:
        points: seen so far.
        window: its features.
        temperature: of the gearbox (deg C), None if unknown.
        bins: widths.

    """
    offsets = [distance(point, window, temperature, bins) for point in points]
    if min(offsets, default=math.inf) < 0.5 + TINY:
        return points, offsets.index(min(offsets))
    return (*points, OperatingPoint(
        _number(window.angle), _number(window.speed), _number(window.load), temperature,
        max(_number(window.load), TINY))), len(points)


def distance(point: OperatingPoint, window: Backlash, temperature: float | None,
             bins: Bins) -> float:
    """
    Return how far a window lies from an operating point, in bins: the largest of its coordinates.

    Args:
        point: with its centre.
        window: features of the window.
        temperature: of the gearbox (deg C), None if unknown.
        bins: widths.

    Returns:
        The distance; inf if only one of both temperatures is known.

    """
    offsets = [0.0]
    if bins.angle > 0.0:
        off = abs(_number(window.angle) - point.angle)
        if bins.turns:
            off %= 2 * math.pi
            off = min(off, 2 * math.pi - off)
        offsets.append(off / bins.angle)
    for ratio, value, centre in ((bins.speed, window.speed, point.speed),
                                 (bins.load, window.load, point.load)):
        if ratio > 1.0:
            offsets.append(abs(math.log(max(_number(value), TINY) / max(centre, TINY)))
                           / math.log(ratio))
    if bins.temperature > 0.0:
        if temperature is not None and point.temperature is not None:
            offsets.append(abs(temperature - point.temperature) / bins.temperature)
        elif (temperature is None) != (point.temperature is None):
            return math.inf
    return max(offsets)


def _number(value: float) -> float:
    return float(value) if math.isfinite(value) else 0.0
