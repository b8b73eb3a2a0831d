# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Operating points: where windows were measured, and how much they scatter there.

A window belongs to the known point whose centre is nearest, if it lies within half a bin of it in
every coordinate; otherwise it founds a new point with itself as the centre. So a drive that works
around one point has one point, not two halves of neighbouring bins.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field
import math
from typing import Any, Self

import numpy as np

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.change_tests import FEATURES, GAP, HYSTERESIS, SHARP
from gearbox_monitor.health.backlash.features import Backlash, Friction
from gearbox_monitor.kernels.types import Array, Values

N_COLUMNS = len(FEATURES) + 1  # the features, and the gap, all else being equal (SHARP)
TINY = 1e-9


def _columns(value: float = 0.0) -> Array:
    return np.full(N_COLUMNS, value)


@dataclass
class OperatingPoint:
    """
    An operating point and the noise of its windows.

    angle (rad), speed (rad/s), load (N m), temperature (deg C, None = not measured): its centre.
    scale: load that a change of the hysteresis is divided by. stated, stated_count [F]:
    mean of the variances that windows state, of so many. squares, freedom [F + 1]: of the noise,
    by differences of neighbours (von Neumann, 1941), which neither steps nor slopes of the wear
    touch. previous [F + 1], kelvin: the window before. since_ns: its first window, last_ns: its
    newest.
    """

    angle: float
    speed: float
    load: float
    temperature: float | None
    scale: float
    stated: Array = field(default_factory=lambda: np.zeros(len(FEATURES)))
    stated_count: Array = field(default_factory=lambda: np.zeros(len(FEATURES)))
    squares: Array = field(default_factory=_columns)
    freedom: Array = field(default_factory=_columns)
    previous: Array = field(default_factory=lambda: _columns(math.nan))
    kelvin: float = 0.0
    since_ns: int = 0
    last_ns: int = 0

    def place(self) -> dict[str, float | None]:
        """Return the centre as plain data."""
        return {'angle': self.angle, 'speed': self.speed, 'load': self.load,
                'temperature': self.temperature}

    def unit(self, column: int) -> float:
        """Return what the feature in `column` is divided by if it is not logarithmic."""
        return self.scale if column == HYSTERESIS else 1.0

    def text(self) -> str:
        """Return the point in words."""
        text = f'{self.angle:.2g} rad, {self.speed:.2g} rad/s, {self.load:.2g} N m'
        return text + ('' if self.temperature is None else f', {self.temperature:.0f} deg C')

    def state(self, variances: Array) -> None:
        """Take the stated `variances` [F] of a window into their means."""
        finite = np.isfinite(variances)
        self.stated_count = self.stated_count + finite
        self.stated = self.stated + np.where(
            finite, np.nan_to_num(variances) - self.stated, 0.0) / np.maximum(
                self.stated_count, 1.0)

    def scatter(self, values: Array, kelvin: float, slopes: Array, excess: float = 1.0) -> None:
        """
        Take the difference of a window to the previous one into the noise.

        Args:
            values: of the window [F + 1].
            kelvin: its temperature.
            slopes: temperature coefficients [F + 1].
            excess: its variance over the usual one.

        """
        off = values - self.previous - slopes * (kelvin - self.kelvin)
        finite = np.isfinite(off)
        squares = np.minimum(0.5 * np.where(finite, off, 0.0) ** 2 / excess,
                             LIMITS.wild ** 2 * self.variance())
        self.squares = self.squares + LIMITS.difference * np.where(finite, squares, 0.0)
        self.freedom = self.freedom + LIMITS.difference * finite
        fresh = np.isfinite(values)
        self.previous = np.where(fresh, values, self.previous)
        self.kelvin = kelvin if fresh.any() else self.kelvin

    def variance(self) -> Array:
        """Return the variance [F + 1] of one window: what was stated counts as some windows."""
        stated = np.append(self.stated, LIMITS.sharp_stated * self.stated[GAP])
        prior = LIMITS.prior_windows * LIMITS.stated_excess ** 2 * stated
        result: Array = (prior + self.squares) / (LIMITS.prior_windows + self.freedom)
        return result

    def dof(self, column: int) -> float:
        """Return the degrees of freedom of the variance of a `column`."""
        return LIMITS.prior_windows + float(self.freedom[column]) - 1.0

    def forget_sharp(self) -> None:
        """Drop the noise of SHARP: it is defined again."""
        self.squares[SHARP] = self.freedom[SHARP] = 0.0
        self.previous[SHARP] = math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return all of it as plain data; floats read back exactly."""
        return {**self.place(), 'scale': self.scale, 'kelvin': self.kelvin,
                'since_ns': self.since_ns, 'last_ns': self.last_ns,
                **{name: [float(v) for v in getattr(self, name)] for name in _ARRAYS}}

    @classmethod
    def from_dict(cls, row: Values) -> Self:
        """Return the OperatingPoint of `row`, which to_dict gave."""
        point = cls.at(row)
        point.kelvin, point.since_ns = float(row['kelvin']), int(row['since_ns'])
        point.last_ns = int(row['last_ns'])
        for name in _ARRAYS:
            setattr(point, name, numbers(row[name], len(getattr(point, name))))
        return point

    @classmethod
    def at(cls, row: Values) -> Self:
        """Return an OperatingPoint without windows whose centre `row` names, see place."""
        temperature = row['temperature']
        return cls(float(row['angle']), float(row['speed']), float(row['load']),
                   None if temperature is None else float(temperature), float(row['scale']))


_ARRAYS = ('stated', 'stated_count', 'squares', 'freedom', 'previous')


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


def find_point(points: list[OperatingPoint], window: Backlash | Friction,
               temperature: float | None, bins: Bins) -> int:
    """
    Return the index of the operating point of a window; add one if none is near.

    Args:
        points: seen so far.
        window: its features.
        temperature: of the gearbox (deg C), None if unknown.
        bins: widths.

    Returns:
        The index.

    """
    offsets = [distance(point, window, temperature, bins) for point in points]
    if min(offsets, default=math.inf) < 0.5 + TINY:
        return offsets.index(min(offsets))
    points.append(OperatingPoint(
        _number(window.angle), _number(window.speed), _number(window.load), temperature,
        max(_number(window.load), TINY)))
    return len(points) - 1


def distance(point: OperatingPoint, window: Backlash | Friction, temperature: float | None,
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


def numbers(values: Sequence[Any] | Any, size: int) -> Array:
    """Return `values` as an array [size]; raises ValueError."""
    array = np.array(values, float)
    if array.size != size:
        raise ValueError(f'{array.size} numbers, expected {size}')
    return array.ravel()
