# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What of backlash and friction is watched for changes: each feature of wear is one object."""
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
import math
from typing import NamedTuple, TypeAlias

from gearbox_monitor.health.alarms import Condition, Level, LIMITS
from gearbox_monitor.health.backlash.features import Backlash
from gearbox_monitor.parameters import EstimatorParameters

COMPONENTS = ('backlash', 'friction')


@dataclass(frozen=True)
class WearLimits:
    """What decides whether and how much a feature has changed; deviations are standard ones."""

    # --- What the wear may be: deviations of logarithms
    # Of the healthy level, of a step, and of one that may have come with a new motion.
    level_std: float = 3.0
    step_std: float = 1.0
    open_std: float = 0.5
    # Courses after a step: (slope per window, random walk per window over the noise of a window),
    # and how probable each is before anything was seen.
    courses: tuple[tuple[float, float], ...] = (
        (0.0, 0.0), (0.01, 0.0), (0.01, 0.06), (0.01, 0.3), (0.1, 3.0))
    course_prior: tuple[float, ...] = (0.5, 0.2, 0.12, 0.12, 0.06)

    # --- A change of the newest windows
    # Steps that are looked for, likely to be small or large: an octave off costs 1.4 of the odds.
    sizes: tuple[float, ...] = (0.02, 0.2)
    # Probability that two features change at once; and per window, that another one does where
    # one has, or the same again.
    pair: float = 0.1
    together: float = 1e-4
    # False alarms over those that the sum of odds bounds: most of it is that of steps far larger
    # than any noise, which chance never shows (test_wear simulates it).
    tightness: float = 0.3
    # Probability that a window is off alone: two in a row weigh as much as the odds of a year.
    outlier: float = 1e-4
    # Windows in which a change may have begun: older ones are sums.
    horizon: int = 120
    # Windows before which nothing is compared: two differences of neighbours.
    min_baseline: int = 3
    # Windows after which a new motion may come with a change.
    settled_windows: int = 30

    # --- Noise of a window
    # Factor by which its stated deviation may be too small, and the windows that it weighs as much
    # as against the spread that was seen.
    stated_excess: float = 1.5
    prior_windows: float = 10.0
    # Windows that hold the correlations of the features to 0.
    correlation_windows: float = 1.0
    # Points that the stated spread of offsets counts as.
    offset_windows: float = 5.0
    # Stated deviation over that of the baseline, and over the change that requires a service, up
    # to which a window is compared that is not trusted: the fit holds then.
    stated_ratio: float = 3.0
    precise: float = 0.1
    # Logarithm below the first value that counts as nothing: 2 %.
    value_floor: float = 4.0

    # --- Words
    # Probability from which on it is said that a change goes on, that nothing is left of it, or
    # that its size has left a limit.
    sure: float = 0.9


WEAR = WearLimits()


class ModelFriction(NamedTuple):
    """Friction of the motor in the model file: viscous (N m s/rad), coulomb (N m)."""

    viscous: float = 0.0
    coulomb: float = 0.0

    def at(self, window: Backlash) -> float:
        """Return the friction (N m) at the speed of a `window`, or its load without friction."""
        friction = self.viscous * window.speed + self.coulomb
        return friction if friction > 0.0 else window.load

    def share(self, speed: float) -> float:
        """Return the viscous share of the friction at a `speed` (rad/s), NaN without friction."""
        friction = self.viscous * speed + self.coulomb
        return self.viscous * speed / friction if friction > 0.0 else math.nan


@dataclass(frozen=True)
class FeaturePrior:
    """
    What is expected of a feature: standard deviations, relative.

    share: of the changes that are of this feature, over those of others (in PRIORS all add up to
    1); up: of these, how many are upwards. offset: between operating points, before some are
    known. distrust: of windows in which the filter is at odds with the drive, all of them
    together. temperature: of the coefficient, per K; of friction,
    that of the viscous part, coulomb: that of the other. scale, crosstalk: what the regression of
    a window misses of a change, over the change; what changes of other features seem to be one of
    this (test/system/wear.py measures both). logarithmic: whether the feature is positive, and its
    changes relative to it; else to the load, those of the viscous share to the friction.
    """

    share: float
    up: float
    offset: float
    distrust: float
    temperature: float
    scale: float
    crosstalk: float
    logarithmic: bool = True
    coulomb: float = 0.0


Value: TypeAlias = tuple[float, float]  # with its standard deviation; NaN: not known
Measure: TypeAlias = Callable[[Backlash, ModelFriction], Value]


@dataclass(frozen=True)
class WearFeature:
    """
    One feature of wear, with all that is known of it beforehand.

    name; noun, in messages; component, of COMPONENTS. measure(window, friction of the model): its
    Value in a window. up, down: key of the test of a change to either side. limits: parameters,
    from which on a change is reported, a warning, an error. unit: of its value in a window, a
    field of Backlash that is published, listed and drawn; '': none is.
    """

    name: str
    noun: str
    component: str
    measure: Measure
    up: str
    down: str
    limits: tuple[str, str, str]
    prior: FeaturePrior
    unit: str = ''


UNKNOWN: Value = math.nan, math.nan
_WIDTH = ('gap_notice', 'gap_warn', 'gap_error')
_STIFFNESS = ('0.2 stiffness_warn', 'stiffness_warn', 'stiffness_error')
_FRICTION = ('0.25 friction_warn', 'friction_warn', 'friction_error')


def _in_windows(name: str, separable: bool | None = None) -> Measure:
    """Return what takes the field `name` of windows, only of those that are `separable` or not."""
    def _measure(window: Backlash, friction: ModelFriction) -> Value:
        if separable not in (None, window.separable):
            return UNKNOWN
        return getattr(window, name), getattr(window, f'{name}_std')
    return _measure


def _friction(window: Backlash, friction: ModelFriction) -> Value:
    """Return the friction at the speed of a window over that of the model."""
    healthy = friction.at(window)
    if not healthy > 0.0:
        return UNKNOWN
    return (1.0 + (window.viscous * window.speed + window.coulomb) / healthy,
            math.hypot(window.viscous_std * window.speed, window.coulomb_std) / healthy)


def _viscous_share(window: Backlash, friction: ModelFriction) -> Value:
    """Return the viscous share of a window's friction less that of the model."""
    w, change = window, window.viscous * window.speed
    total = friction.at(w) + change + w.coulomb
    if not total > 0.0:
        return UNKNOWN
    share = (friction.viscous * w.speed + change) / total
    return share - friction.share(w.speed), math.hypot(
        (1.0 - share) * w.viscous_std * w.speed / total, share * w.coulomb_std / total,
        LIMITS.share_error)


WEAR_FEATURES = (
    WearFeature('gap', 'backlash', 'backlash', _in_windows('gap', True), 'gap', 'gap_loss',
                _WIDTH, FeaturePrior(0.58, 0.9, 0.015, 0.015, 0.0005, 0.02, 0.03), 'rad'),
    WearFeature('lost_motion', 'lost motion', 'backlash', _in_windows('lost_motion', False),
                'lost_motion', 'lost_motion_loss', _WIDTH,
                FeaturePrior(0.11, 0.9, 0.015, 0.015, 0.0005, 0.02, 0.03), 'rad'),
    WearFeature('stiffness', 'stiffness', 'backlash', _in_windows('stiffness'),
                'stiffness_growth', 'stiffness_loss', _STIFFNESS,
                FeaturePrior(0.08, 0.3, 0.02, 0.02, 0.0005, 0.06, 0.05), 'N m/rad'),
    WearFeature('hysteresis', 'hysteresis over load', 'backlash', _in_windows('hysteresis'),
                'hysteresis', 'hysteresis_down', _STIFFNESS,
                FeaturePrior(0.05, 0.5, 0.02, 0.02, 0.0005, 0.06, 0.05, False), 'N m'),
    WearFeature('friction', 'friction', 'friction', _friction, 'friction', 'friction_loss',
                _FRICTION, FeaturePrior(0.07, 0.5, 0.05, 0.04, 0.02, 0.06, 0.05, coulomb=0.005)),
    WearFeature('gain', 'torque gain', 'friction',
                lambda window, _: (1.0 + window.gain, window.gain_std),
                'torque_gain', 'torque_gain_loss', _STIFFNESS,
                FeaturePrior(0.07, 0.5, 0.01, 0.01, 0.0005, 0.05, 0.08)),
    # Where viscous and Coulomb friction go opposite ways: else `friction` tells the change.
    WearFeature('viscous_share', 'share of viscous friction', 'friction', _viscous_share,
                'viscous_share', 'viscous_share_loss', _FRICTION,
                FeaturePrior(0.04, 0.5, 0.05, 0.04, 0.02, 0.2, 0.05, False, 0.005)))
FEATURES = tuple(feature.name for feature in WEAR_FEATURES)
GAP, LOST_MOTION, STIFFNESS, HYSTERESIS, FRICTION, GAIN, VISCOUS_SHARE = map(FEATURES.index, (
    'gap', 'lost_motion', 'stiffness', 'hysteresis', 'friction', 'gain', 'viscous_share'))
_SHARES = sum(feature.prior.share for feature in WEAR_FEATURES)
PRIORS = tuple(replace(feature.prior, share=feature.prior.share / _SHARES)
               for feature in WEAR_FEATURES)
MEASURED = {feature.name: feature.unit for feature in WEAR_FEATURES if feature.unit}


@dataclass(frozen=True)
class ChangeTest:
    """A change of the feature in `column`: upwards or, where `sign` is -1, downwards."""

    key: str
    component: str
    column: int
    sign: int


TESTS = tuple(ChangeTest(key, feature.component, column, sign)
              for column, feature in enumerate(WEAR_FEATURES)
              for sign, key in ((1, feature.up), (-1, feature.down)))


def tests_of(column: int) -> list[ChangeTest]:
    """Return the tests of the feature in `column`."""
    return [test for test in TESTS if test.column == column]


def limits_of(parameters: EstimatorParameters) -> dict[str, tuple[float, float, float]]:
    """Return {test: (notice, warn, error)} by `parameters`, for tests of a feature."""
    def size(text: str) -> float:
        factor, _, name = text.rpartition(' ')
        return float(factor or 1.0) * float(getattr(parameters, name))
    return {test.key: (size(notice), size(warn), size(error)) for test in TESTS
            for notice, warn, error in (WEAR_FEATURES[test.column].limits,)}


def _conditions() -> Iterator[Condition]:
    for component in COMPONENTS:
        yield Condition(f'{component}_unmeasured', component, Level.WARN)
    for test in TESTS:
        name, score = size_name(test), f'{test.key}_score'
        yield Condition(f'{test.key}_1', test.component, Level.WARN, (score,),
                        (f'{score}_threshold',))
        yield Condition(f'{test.key}_2', test.component, Level.WARN, (name,), (f'{name}_warn',))
        yield Condition(f'{test.key}_3', test.component, Level.ERROR, (name,), (f'{name}_error',))


def size_name(test: ChangeTest) -> str:
    """Return the name of the size of a change of `test` in the values of an Outcome."""
    return 'growth' if test.key == 'gap' else f'{test.key}_change'


CONDITIONS = tuple(_conditions())
