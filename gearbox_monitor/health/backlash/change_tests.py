# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What of backlash and friction is watched for changes: tests, their limits, and what to do.

`explain` prints CONDITIONS.
"""
from collections.abc import Iterator
from dataclasses import dataclass

from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.parameters import EstimatorParameters

FEATURES = ('gap', 'lost_motion', 'stiffness', 'hysteresis', 'friction', 'gain', 'viscous_share')
GAP, LOST_MOTION, STIFFNESS, HYSTERESIS, FRICTION, GAIN, VISCOUS_SHARE = range(len(FEATURES))
COMPONENTS = ('backlash', 'friction')


@dataclass(frozen=True)
class WearLimits:
    """What decides whether and how much a feature has changed; deviations are standard ones."""

    # --- What the wear may be: deviations of logarithms
    # Of the healthy level, of a step, and of one that may have come with a new motion.
    level_std: float = 3.0
    step_std: float = 1.0
    open_std: float = 0.5
    # Slope per window after a step.
    slope_std: float = 0.01
    # Courses after a step: (has a slope, random walk per window over the noise of a window), and
    # how probable each is before anything was seen.
    courses: tuple[tuple[bool, float], ...] = (
        (False, 0.0), (True, 0.0), (True, 0.06), (True, 0.3))
    course_prior: tuple[float, ...] = (0.5, 0.2, 0.15, 0.15)

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
    # Deviations of a difference of neighbours beyond which it is a change rather than noise.
    wild: float = 3.0
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


@dataclass(frozen=True)
class FeaturePrior:
    """
    What is expected of a feature: standard deviations, relative.

    share: of the changes that are of this feature; up: of these, how many are upwards. offset:
    between operating points, before some are known. distrust: of windows in which the filter is at
    odds with the drive, all of them together. temperature: of the coefficient, per K; of friction,
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


PRIORS = (
    FeaturePrior(0.58, 0.9, 0.015, 0.015, 0.0005, 0.02, 0.03),
    FeaturePrior(0.11, 0.9, 0.015, 0.015, 0.0005, 0.02, 0.03),
    FeaturePrior(0.08, 0.3, 0.02, 0.02, 0.0005, 0.06, 0.05),
    FeaturePrior(0.05, 0.5, 0.02, 0.02, 0.0005, 0.06, 0.05, False),
    FeaturePrior(0.07, 0.5, 0.05, 0.04, 0.02, 0.06, 0.05, coulomb=0.005),
    FeaturePrior(0.07, 0.5, 0.01, 0.01, 0.0005, 0.05, 0.08),
    FeaturePrior(0.04, 0.5, 0.05, 0.04, 0.02, 0.2, 0.05, False, 0.005))


@dataclass(frozen=True)
class ChangeTest:
    """A change of the feature in `column`: upwards or, where `sign` is -1, downwards."""

    key: str
    component: str
    column: int
    sign: int
    words: str


TESTS = (
    ChangeTest('gap', 'backlash', GAP, 1, 'backlash has grown by'),
    ChangeTest('gap_loss', 'backlash', GAP, -1, 'backlash has shrunk by'),
    ChangeTest('lost_motion', 'backlash', LOST_MOTION, 1, 'lost motion has grown by'),
    ChangeTest('lost_motion_loss', 'backlash', LOST_MOTION, -1, 'lost motion has shrunk by'),
    ChangeTest('stiffness_loss', 'backlash', STIFFNESS, -1, 'stiffness has dropped by'),
    ChangeTest('stiffness_growth', 'backlash', STIFFNESS, 1, 'stiffness has grown by'),
    ChangeTest('hysteresis', 'backlash', HYSTERESIS, 1, 'hysteresis over load has grown by'),
    ChangeTest('hysteresis_down', 'backlash', HYSTERESIS, -1,
               'hysteresis over load has dropped by'),
    ChangeTest('friction', 'friction', FRICTION, 1, 'friction has grown by'),
    ChangeTest('friction_loss', 'friction', FRICTION, -1, 'friction has dropped by'),
    # Where viscous and Coulomb friction go opposite ways: else `friction` tells the change.
    ChangeTest('viscous_share', 'friction', VISCOUS_SHARE, 1,
               'friction has shifted to viscous by'),
    ChangeTest('viscous_share_loss', 'friction', VISCOUS_SHARE, -1,
               'friction has shifted to Coulomb by'),
    ChangeTest('torque_gain', 'friction', GAIN, 1, 'torque gain has grown by'),
    ChangeTest('torque_gain_loss', 'friction', GAIN, -1, 'torque gain has dropped by'),
)
ADVICE = {
    'gap': ('watch it', 'plan a service', 'service the gearbox'),
    'lost_motion': ('watch it', 'plan a service', 'service the gearbox'),
    'gap_loss': ('save a baseline if it was adjusted', 'check preload and adjustment',
                 'check preload and adjustment now'),
    'lost_motion_loss': ('save a baseline if it was adjusted', 'check preload and adjustment',
                         'check preload and adjustment now'),
    'stiffness_growth': ('watch it', 'check preload and couplings',
                         'check preload and couplings now'),
    'stiffness_loss': ('watch it', 'check couplings and mounting, plan a service',
                       'check couplings, mounting and teeth now'),
    'hysteresis': ('watch it', 'check preload and lubrication', 'check preload and lubrication'),
    'hysteresis_down': ('watch it', 'check preload and lubrication',
                        'check preload and lubrication'),
    'friction': ('watch it', 'check lubrication, bearings, brake',
                 'check lubrication, bearings, brake now'),
    'friction_loss': ('watch it', 'check preload and lubricant', 'check preload and lubricant'),
    'viscous_share': ('watch it', 'check the lubricant', 'check the lubricant now'),
    'viscous_share_loss': ('watch it', 'check lubrication, bearings, seals',
                           'check lubrication, bearings, seals now'),
    'torque_gain': ('watch it', 'check the torque constant of the drive',
                    'check the torque constant of the drive'),
    'torque_gain_loss': ('watch it', 'check motor and torque constant',
                         'check motor and torque constant'),
}
# Limits of each feature, by parameter: stated from, WARN with the second advice from, ERROR from.
_WIDTH = ('gap_notice', 'gap_warn', 'gap_error')
_STIFFNESS = ('0.2 stiffness_warn', 'stiffness_warn', 'stiffness_error')
_FRICTION = ('0.25 friction_warn', 'friction_warn', 'friction_error')
_LIMITS = (_WIDTH, _WIDTH, _STIFFNESS, _STIFFNESS, _FRICTION, _STIFFNESS, _FRICTION)


def limits_of(parameters: EstimatorParameters) -> dict[str, tuple[float, float, float]]:
    """Return {test: (notice, warn, error)} by `parameters`, for tests of a feature."""
    def size(text: str) -> float:
        factor, _, name = text.rpartition(' ')
        return float(factor or 1.0) * float(getattr(parameters, name))
    return {test.key: (size(notice), size(warn), size(error)) for test in TESTS
            for notice, warn, error in (_LIMITS[test.column],)}


def _conditions() -> Iterator[Condition]:
    for component, advice in zip(COMPONENTS, (
            'move so that both flanks are loaded, there and back',
            'load a flank and move in both directions')):
        yield Condition(component, Level.WARN, f'{component} not measured yet',
                        'no window since the start showed it', 'drift_window', advice)
    for test in TESTS:
        name, score = size_name(test), f'{test.key}_score'
        for k, limit in enumerate(_LIMITS[test.column]):
            sure = 'significant (false_alarm_interval) and ' if k == 0 else ''
            also = ', or the backlash > gap_limit' \
                if limit == 'gap_error' and test.key == 'gap' else ''
            yield Condition(
                test.component, Level.ERROR if k == 2 else Level.WARN, f'{test.words} ... %',
                f'{sure}change >= {limit}{also}',
                f'since one of the newest {WEAR.horizon} windows' if k == 0 else
                'since the change', ADVICE[test.key][k],
                (score if k == 0 else name,),
                (f'{score}_threshold' if k == 0 else f'{name}_{"warn" if k == 1 else "error"}',))


def size_name(test: ChangeTest) -> str:
    """Return the name of the size of a change in the values of a Outcome; test: a ChangeTest."""
    return 'growth' if test.key == 'gap' else f'{test.key}_change'


CONDITIONS = tuple(_conditions())
