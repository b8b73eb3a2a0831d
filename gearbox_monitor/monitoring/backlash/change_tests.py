# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
What of backlash and friction is watched for changes: tests, their limits, and what to do.

docs/conditions.md is generated from CONDITIONS.
"""
from collections.abc import Iterator
from dataclasses import dataclass

from gearbox_monitor.monitoring.backlash import scan
from gearbox_monitor.monitoring.checks.outcome import Condition, Level

FEATURES = ('gap', 'lost_motion', 'stiffness', 'hysteresis', 'friction', 'gain')
GAP, LOST_MOTION, STIFFNESS, HYSTERESIS, FRICTION, GAIN = range(len(FEATURES))
COMPONENTS = ('backlash', 'friction')
ALONE = 'gap_all_else_equal'


@dataclass(frozen=True)
class ChangeTest:
    """
    One upward test: `sign` times the feature in `column`.

    relative: to the baseline; otherwise to the load, or as it is. share: of the false alarms.
    """

    key: str
    component: str
    column: int
    sign: int
    relative: bool
    share: float
    words: str


TESTS = (
    ChangeTest('gap', 'backlash', GAP, 1, True, 0.15, 'gap has grown by'),
    # Far sharper where the others stay, see Sums.couplings; what it finds is a growth of the gap.
    ChangeTest(ALONE, 'backlash', len(FEATURES), 1, True, 0.45, 'gap has grown by'),
    ChangeTest('lost_motion', 'backlash', LOST_MOTION, 1, True, 0.1, 'lost motion has grown by'),
    ChangeTest('stiffness_loss', 'backlash', STIFFNESS, -1, True, 0.05,
               'stiffness has dropped by'),
    ChangeTest('hysteresis', 'backlash', HYSTERESIS, 1, False, 0.025,
               'hysteresis over load has grown by'),
    ChangeTest('hysteresis_down', 'backlash', HYSTERESIS, -1, False, 0.025,
               'hysteresis over load has dropped by'),
    ChangeTest('friction', 'friction', FRICTION, 1, True, 0.05, 'friction has grown by'),
    ChangeTest('friction_loss', 'friction', FRICTION, -1, True, 0.05, 'friction has dropped by'),
    ChangeTest('torque_gain', 'friction', GAIN, 1, True, 0.05, 'torque gain has grown by'),
    ChangeTest('torque_gain_loss', 'friction', GAIN, -1, True, 0.05, 'torque gain has dropped by'),
)
ADVICE = {
    'gap': ('watch it', 'plan a service', 'service the gearbox'),
    'lost_motion': ('watch it', 'plan a service', 'service the gearbox'),
    'stiffness_loss': ('watch it', 'check couplings and mounting, plan a service',
                       'check couplings, mounting and teeth now'),
    'hysteresis': ('watch it', 'check preload and lubrication', 'check preload and lubrication'),
    'hysteresis_down': ('watch it', 'check preload and lubrication',
                        'check preload and lubrication'),
    'friction': ('watch it', 'check lubrication, bearings and brake',
                 'check lubrication, bearings and brake now'),
    'friction_loss': ('watch it', 'check preload and lubricant', 'check preload and lubricant'),
    'torque_gain': ('watch it', 'check the torque constant of the drive',
                    'check the torque constant of the drive'),
    'torque_gain_loss': ('watch it', 'check motor and torque constant',
                         'check motor and torque constant'),
}
# Limits of each test, by parameter: stated from, WARN with the second advice from, ERROR from.
_WIDTH = ('gap_notice', 'gap_warn', 'gap_error')
_STIFFNESS = ('0.2 stiffness_warn', 'stiffness_warn', 'stiffness_error')
_FRICTION = ('0.25 friction_warn', 'friction_warn', 'friction_error')
_LIMITS = {'gap': _WIDTH, 'lost_motion': _WIDTH, 'stiffness_loss': _STIFFNESS,
           'hysteresis': _STIFFNESS, 'hysteresis_down': _STIFFNESS, 'friction': _FRICTION,
           'friction_loss': _FRICTION, 'torque_gain': _STIFFNESS, 'torque_gain_loss': _STIFFNESS}


def _conditions() -> Iterator[Condition]:
    for component, advice in zip(COMPONENTS, (
            'move so that both flanks are loaded, there and back',
            'load a flank and move in both directions')):
        yield Condition(component, Level.WARN, f'{component} not measured yet',
                        'no window since the start showed it', 'drift_window', advice)
    for test in TESTS:
        if test.key not in _LIMITS:
            continue
        name = size_name(test)
        scores = (f'{test.key}_score', f'{ALONE}_score') if test.key == 'gap' else \
            (f'{test.key}_score',)
        for k, limit in enumerate(_LIMITS[test.key]):
            sure = 'significant (false_alarm_interval) and ' if k == 0 else ''
            also = ', or the gap > gap_limit' if limit == 'gap_error' and test.key == 'gap' else ''
            yield Condition(
                test.component, Level.ERROR if k == 2 else Level.WARN, f'{test.words} ... %',
                f'{sure}change >= {limit}{also}',
                f'best of the newest 1 .. {scan.HORIZON} windows' if k == 0 else
                'since the change', ADVICE[test.key][k],
                scores if k == 0 else (name,),
                tuple(f'{score}_threshold' for score in scores) if k == 0 else
                (f'{name}_{"warn" if k == 1 else "error"}',))


def size_name(test: ChangeTest) -> str:
    """Return the name of the size of a change in the values of a Outcome; test: a ChangeTest."""
    return 'growth' if test.key == 'gap' else f'{test.key}_change'


CONDITIONS = tuple(_conditions())
