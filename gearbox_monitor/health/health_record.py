# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the wear of one gearbox is judged by: settings, operating points, windows, and alerts.

A window belongs to the known operating point whose centre is nearest, if it lies within half a bin
of it in every coordinate; otherwise it starts a new point with itself as the centre. So a drive
that works around one point has one point, not two halves of neighbouring bins.
"""
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
import math
from typing import Self

import numpy as np

from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.backlash.change_tests import (
    FEATURES, HYSTERESIS, limits_of, ModelFriction, tests_of, WEAR)
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.parameters import CURVES, EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

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


# Trust in a window: whether the filter agrees with the drive, and if not, whether prediction
# errors are larger than predicted, as of an encoder with more noise: 1 below per half octave of
# their variance, which of one motion stays within a tenth, and doubles with such an encoder.
ERRORS_LARGER, AT_ODDS, TRUSTED = -1, 0, 1
FOUND, WARNED, GROSS = 1, 2, 3  # stages of an alert


@dataclass(frozen=True)
class HealthSettings:
    """
    What a gearbox is judged by.

    windows_per_false_alarm: mean number of windows between two false alarms, of all tests
    together. baseline_windows: how many a point learns. bins: of operating points.
    limits {test: (notice, warn, error)}: relative changes; below `notice` nothing is reported.
    gap_limit: rad, 0 = none. friction: of the motor in the model file; half_gap:
    its half backlash (rad). motor_turn: of the motor's encoder, on the arm side (rad), 0 for an
    axis that is not rotary. window: s. follows_curve: whether the filter's torque follows the
    elastic curve of the model.
    """

    windows_per_false_alarm: float = 3.15e6
    baseline_windows: int = 720
    bins: Bins = field(default_factory=Bins)
    limits: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    gap_limit: float = 0.0
    friction: ModelFriction = field(default_factory=ModelFriction)
    half_gap: float = 0.0
    motor_turn: float = 0.0
    window: float = 10.0
    follows_curve: bool = False

    @classmethod
    def of(cls, parameters: EstimatorParameters, model: DriveModel) -> Self:
        """Return the HealthSettings of `parameters` and the DriveModel `model`."""
        p, shape = parameters, model.transmission
        play = shape.hysteresis_width if shape.kind == 'play' else 0.0
        return cls(
            max(p.false_alarm_interval / p.drift_window, 20.0), p.baseline_windows,
            Bins(p.angle_bin, p.speed_bin, p.load_bin, p.temperature_bin, model.axis == 'rotary'),
            limits_of(p), p.gap_limit,
            ModelFriction(model.viscous_friction, model.coulomb_friction),
            shape.half_gap + play,
            2.0 * math.pi / abs(model.gear_ratio) if model.axis == 'rotary' else 0.0,
            p.drift_window, p.tau_k_model in CURVES)

    @property
    def threshold(self) -> float:
        """Logarithm (base 10) of the odds at which a change is found."""
        return math.log10(WEAR.tightness * self.windows_per_false_alarm)

    def notice(self, column: int) -> float:
        """Return the smallest change (logarithm) of the feature in `column` that is reported."""
        return math.log1p(self.limits.get(tests_of(column)[0].key, (0.0,))[0])


@dataclass(frozen=True)
class Window:
    """
    A drift window, as a Monitor hands it over to be judged.

    features: of the window, or why there are none. trust: in its estimates, see TRUSTED; those one
    level below may be off together. temperature: of the gearbox (deg C), None if unknown.
    comparable: whether a window that is not trusted is compared where its fit is as good as those
    of the baseline; else it is only shown. counts_on: whether the encoders count from where they
    did in the last window with a gap.
    """

    features: Backlash | NotExcited
    trust: int = TRUSTED
    temperature: float | None = None
    comparable: bool = False
    counts_on: bool = False

    @property
    def stamp_ns(self) -> int:
        """Stamp of its end."""
        return self.features.stamp_ns

    @property
    def friction(self) -> Backlash | None:
        """What the window says of the friction, None for nothing."""
        features = self.features
        return features.friction if isinstance(features, NotExcited) else features


@dataclass(frozen=True)
class Alert:
    """
    A change that was found, until it is over.

    since_ns: where it began, found_ns: where it was found; found: its relative size then;
    growth, std: now; stage: FOUND, WARNED (above the limit for a warning) or GROSS (for an error).
    """

    since_ns: int
    found_ns: int
    found: float
    growth: float
    std: float
    stage: int = FOUND


@dataclass(frozen=True)
class FeatureHealth:
    """
    What is known about one feature; NaN: not known.

    level: of the newest window that shows it, baseline: healthy, at the operating point of the
    newest window, both in the unit of the feature. change: against the baseline, relative;
    compared_ns: the newest window that shows it, 0 without any. rate: of the change per second
    while there is a trend, else 0; reach: (s, earliest, latest) until the change is an error, None
    without a trend; steady: whether it has stopped changing. is_open: whether a part of the change
    may belong to a new motion. newest: change of the newest window alone while it contradicts
    those before, 0 otherwise. *_std: standard deviations.
    """

    level: float = math.nan
    level_std: float = math.nan
    baseline: float = math.nan
    baseline_std: float = math.nan
    change: float = math.nan
    change_std: float = math.nan
    compared_ns: int = 0
    rate: float = 0.0
    rate_std: float = 0.0
    reach: tuple[float, float, float] | None = None
    steady: bool = False
    is_open: bool = False
    newest: float = 0.0
