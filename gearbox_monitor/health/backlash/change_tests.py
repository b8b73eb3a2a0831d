# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What of backlash and friction is watched for changes: tests, their limits, and what to do.

`explain` prints CONDITIONS.
"""
from collections.abc import Iterator
from dataclasses import dataclass

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.parameters import EstimatorParameters

FEATURES = ('gap', 'lost_motion', 'stiffness', 'hysteresis', 'friction', 'gain', 'viscous_share')
GAP, LOST_MOTION, STIFFNESS, HYSTERESIS, FRICTION, GAIN, VISCOUS_SHARE = range(len(FEATURES))
SHARP = len(FEATURES)  # the gap, all else being equal: see wear_data.WearData
COMPONENTS = ('backlash', 'friction')
ALONE, ALONE_LOSS = 'gap_all_else_equal', 'gap_loss_all_else_equal'


@dataclass(frozen=True)
class FeaturePrior:
    """
    What is expected of a feature besides wear: standard deviations, relative.

    offset: between operating points, before some are known. distrust: of windows in which the
    filter is at odds with the drive, all of them together. temperature: of the coefficient, per K;
    of friction, that of the viscous part, coulomb: that of the other.
    scale, crosstalk: what the regression of a window misses of a change, over the change; what
    changes of other features seem to be one of this (test/system/wear.py measures both).
    logarithmic: whether the feature is positive, and its changes relative to it; else to the load,
    those of the viscous share to the friction.
    """

    offset: float
    distrust: float
    temperature: float
    scale: float
    crosstalk: float
    logarithmic: bool = True
    coulomb: float = 0.0


PRIORS = (
    FeaturePrior(0.015, 0.015, 0.0005, 0.02, 0.03), FeaturePrior(0.015, 0.015, 0.0005, 0.02, 0.03),
    FeaturePrior(0.02, 0.02, 0.0005, 0.06, 0.05),
    FeaturePrior(0.02, 0.02, 0.0005, 0.06, 0.05, False),
    FeaturePrior(0.05, 0.04, 0.02, 0.06, 0.05, coulomb=0.005),
    FeaturePrior(0.01, 0.01, 0.0005, 0.05, 0.08),
    FeaturePrior(0.05, 0.04, 0.02, 0.2, 0.05, False, 0.005))


@dataclass(frozen=True)
class ChangeTest:
    """
    One upward test: `sign` times the feature in `column`.

    share: of the false alarms.
    """

    key: str
    component: str
    column: int
    sign: int
    share: float
    words: str


TESTS = (
    ChangeTest('gap', 'backlash', GAP, 1, 0.13, 'backlash has grown by'),
    # Far sharper where the others stay; what it finds is a change of the gap.
    ChangeTest(ALONE, 'backlash', SHARP, 1, 0.42, 'backlash has grown by'),
    ChangeTest('gap_loss', 'backlash', GAP, -1, 0.03, 'backlash has shrunk by'),
    ChangeTest(ALONE_LOSS, 'backlash', SHARP, -1, 0.05, 'backlash has shrunk by'),
    ChangeTest('lost_motion', 'backlash', LOST_MOTION, 1, 0.09, 'lost motion has grown by'),
    ChangeTest('lost_motion_loss', 'backlash', LOST_MOTION, -1, 0.02, 'lost motion has shrunk by'),
    ChangeTest('stiffness_loss', 'backlash', STIFFNESS, -1, 0.05, 'stiffness has dropped by'),
    ChangeTest('stiffness_growth', 'backlash', STIFFNESS, 1, 0.02, 'stiffness has grown by'),
    ChangeTest('hysteresis', 'backlash', HYSTERESIS, 1, 0.02, 'hysteresis over load has grown by'),
    ChangeTest('hysteresis_down', 'backlash', HYSTERESIS, -1, 0.02,
               'hysteresis over load has dropped by'),
    ChangeTest('friction', 'friction', FRICTION, 1, 0.03, 'friction has grown by'),
    ChangeTest('friction_loss', 'friction', FRICTION, -1, 0.03, 'friction has dropped by'),
    # Where viscous and Coulomb friction go opposite ways: else `friction` tells the change.
    ChangeTest('viscous_share', 'friction', VISCOUS_SHARE, 1, 0.01,
               'friction has shifted to viscous by'),
    ChangeTest('viscous_share_loss', 'friction', VISCOUS_SHARE, -1, 0.01,
               'friction has shifted to Coulomb by'),
    ChangeTest('torque_gain', 'friction', GAIN, 1, 0.035, 'torque gain has grown by'),
    ChangeTest('torque_gain_loss', 'friction', GAIN, -1, 0.035, 'torque gain has dropped by'),
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
            if test.column != SHARP for notice, warn, error in (_LIMITS[test.column],)}


def _conditions() -> Iterator[Condition]:
    for component, advice in zip(COMPONENTS, (
            'move so that both flanks are loaded, there and back',
            'load a flank and move in both directions')):
        yield Condition(component, Level.WARN, f'{component} not measured yet',
                        'no window since the start showed it', 'drift_window', advice)
    for test in TESTS:
        if test.column == SHARP:
            continue
        name = size_name(test)
        sharper = {'gap': ALONE, 'gap_loss': ALONE_LOSS}.get(test.key)
        scores = (f'{test.key}_score', *((f'{sharper}_score',) if sharper else ()))
        for k, limit in enumerate(_LIMITS[test.column]):
            sure = 'significant (false_alarm_interval) and ' if k == 0 else ''
            also = ', or the backlash > gap_limit' \
                if limit == 'gap_error' and test.key == 'gap' else ''
            yield Condition(
                test.component, Level.ERROR if k == 2 else Level.WARN, f'{test.words} ... %',
                f'{sure}change >= {limit}{also}',
                f'best of the newest 1 .. {LIMITS.horizon} windows' if k == 0 else
                'since the change', ADVICE[test.key][k],
                scores if k == 0 else (name,),
                tuple(f'{score}_threshold' for score in scores) if k == 0 else
                (f'{name}_{"warn" if k == 1 else "error"}',))


def size_name(test: ChangeTest) -> str:
    """Return the name of the size of a change in the values of a Outcome; test: a ChangeTest."""
    return 'growth' if test.key == 'gap' else f'{test.key}_change'


CONDITIONS = tuple(_conditions())
