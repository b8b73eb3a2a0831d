# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the wear of one gearbox is judged by: settings, windows, features and alerts."""
from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import Self

from gearbox_monitor.health.backlash.change_tests import limits_of, ModelFriction, tests_of, WEAR
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.backlash.operating_point import Bins
from gearbox_monitor.parameters import CURVES, EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

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
