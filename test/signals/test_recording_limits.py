# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of findings: in one place, none idle, each decides just below and above its value."""
from dataclasses import FrozenInstanceError, replace

from limits import assert_all_decide, assert_decides, loose_numbers
import numpy as np
import pytest

from gearbox_monitor import signals
from gearbox_monitor.signals import checks, stamps
from gearbox_monitor.signals.checks import TorqueResponse
from gearbox_monitor.signals.finding import BAD, LIMITS, RecordingLimits, WARN

# Grids of a search, settings of fits and units: they decide nothing.
NUMERICAL = {
    'uniform': {'SPEED_SPAN', 'HALF_WIDTHS', 'FITTED'}, 'recording': {'UNITS'},
    'jumps': {'PERIODS'}, 'checks': {'SECONDS', 'BLOCKS', 'BLOCK_SECONDS'},
    'wiring': {'GAPS', 'FEW_GAPS', 'SWINGS', 'SLACK', 'EFFORT_GAPS', 'FACTORS'}}
CLOCK = stamps.clock(1_700_000_000_000_000_000 + 2_000_000 * np.arange(2000))


def test_limits_stay_and_none_is_idle():
    with pytest.raises(FrozenInstanceError):
        LIMITS.slip = 0.0
    with pytest.raises(TypeError):
        LIMITS.margins['signs'] = 0.0
    assert_all_decide(signals, RecordingLimits, 'finding')


def test_no_module_has_a_limit_of_its_own():
    assert loose_numbers(signals, NUMERICAL) == []


def response(**values):
    """Return a TorqueResponse that is seen and certain but for `values`."""
    fields = {'correlation': 0.9, 'gain': 1.0, 'gain_std': 0.01, 'delay': 3.0, 'delay_std': 0.2,
              'at_edge': False, 'work': 0.4, 'work_std': 0.01, **values}
    return TorqueResponse(**fields)


def gaps_of(share):
    """Return the purposes that so large a `share` of lost samples hurts."""
    count = len(CLOCK.seconds)
    absent = np.full(count - 1, share * count / (1.0 - share) / (count - 1))
    return stamps._gaps(replace(CLOCK, absent=absent), 1e9).hurts


def readings_of(share):
    """Return what is said of a motor that misses `share` of 1e4 readings, the arm of none."""
    y = np.tile([0.1, 0.3], (10_000, 1))
    y[:round(share * len(y)), 0] = np.nan
    return checks.measured(y, np.arange(10_000) * 1e-3)[0].hurts


def test_a_diagnosis_takes_what_is_left_beside_a_long_gap():
    seconds = np.arange(10_000) * 1e-3
    y = np.sin(seconds[:, None] * [1.0, 2.0])
    for rows, grade in ((slice(0, 3000), WARN), (slice(4500, 5000), WARN),
                        (slice(3900, 6100), BAD), (slice(0, 10_000, 5), BAD)):
        hole = y.copy()
        hole[rows, 1] = np.nan
        (arm,) = checks.measured(hole, seconds)[1:]
        assert arm.verdict(('diagnosis',)) == grade
        torque = checks.torques(hole[:, 1], seconds, True)[0]
        assert torque.verdict(('diagnosis',)) == grade


DECISIONS = [
    ('jitter_notice', lambda x: stamps._jitter(replace(CLOCK, jitter=x * CLOCK.period)).hurts),
    ('lost_notice', gaps_of), ('lost_many', gaps_of), ('max_repaired', gaps_of),
    ('slowest', lambda x: stamps._rate_of(x / 1.01).hurts),
    ('fastest', lambda x: stamps._rate_of(1.01 * x).hurts),
    ('least_rate', lambda x: stamps._rate_of(x).hurts),
    ('diagnosis_slowest', lambda x: stamps._rate_of(x / 1.01).hurts),
    ('diagnosis_fastest', lambda x: stamps._rate_of(1.01 * x).hurts),
    ('min_duration', lambda x: stamps.length(0.999 * x, 1e-2).hurts),
    ('drift_windows_few', lambda x: stamps.length(x, 1.0).hurts),
    ('torque_seen', lambda x: response(correlation=-x).seen)]


def test_a_value_just_below_and_just_above_decides_otherwise():
    for limit, decision in DECISIONS:
        assert_decides(decision, getattr(LIMITS, limit))


def test_one_reading_more_than_the_share_decides_otherwise():
    for limit in ('max_repaired', 'lost_many'):
        share = getattr(LIMITS, limit)
        assert readings_of(share) != readings_of(share + 1e-4)
