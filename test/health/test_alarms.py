# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of alerts: in one place, none idle, each decides just below and just above its value."""
from dataclasses import FrozenInstanceError

from limits import assert_all_decide, assert_decides, loose_numbers
import numpy as np
import pytest

from gearbox_monitor import health
from gearbox_monitor.estimation.rts_smoother import N_SMOOTHED, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST
from gearbox_monitor.health.alarms import Alarm, AlertLimits, Level, LIMITS, outcome_of
from gearbox_monitor.health.backlash.wear import reach
from gearbox_monitor.health.checks import innovation, observability, row_checks
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

DRIVE, PARAMETERS = DriveModel(), EstimatorParameters()
# Settings of fits, grids, sizes of buffers and units decide nothing; tables of objects decide and
# stand beside their class.
NUMERICAL = {
    'monitor': {'ROOM'}, 'innovation': {'LJUNG_BOX_LIMIT'},
    'observability': {'POSITION_SCALE', 'ROUNDING', 'TINY'},
    'row_checks': {'ENOUGH', 'TINY', 'ITERATIONS', 'ROUNDING'},
    'features': {'TOLERANCE'}, 'change': {'HOUR', 'DAY'}, 'change_tests': {'WEAR_FEATURES'},
    'health_record': {'DIFFERENCE', 'TINY'}, 'wear': {'SMALLEST'},
    'hidden_arm': {'STEP', 'LONGEST', 'SCAN', 'STARTS', 'SHIFT', 'SPREAD', 'LOADS', 'NOISE'}}


def test_limits_stay_and_none_is_idle():
    with pytest.raises(FrozenInstanceError):
        LIMITS.gate = 0.0
    assert_all_decide(health, AlertLimits, 'alarms')


def test_no_module_has_a_limit_of_its_own():
    assert loose_numbers(health, NUMERICAL) == []


def covariance_of(share):
    return innovation.judge_covariance(0.3, 0.2 * share, 0.2).message


def errors_of(nis=1.0, variance=1.0, single=0.0):
    """Return what the check says of 4000 samples of two encoders that differ."""
    n, stds = 4000, np.array([0.01, 0.03])
    rng = np.random.default_rng(3)
    white = rng.standard_normal((n, 2))
    errors = stds * np.sqrt(variance) * np.where(np.arange(n) % 2, 1.0, -1.0)[:, None]
    if single:
        errors[-1] = single * stds
    return innovation.check(
        white, np.full(n, 2.0 * nis), np.full(n, 2.0), errors, np.tile(stds, (n, 1)), 500, 1000
        ).message


def information_of(share=0.1, stated=0.1):
    return observability.check({'tau_k': share, 'x3': 0.1}, stated, {}).level


def mismatch_of(share):
    """Return the level where errors were systematic in `share` of 2e6 s, in whole seconds."""
    systematic = innovation.Systematic()
    for k in range(round(200 * share)):
        systematic.add((k + 1) * 1_000_000_000, True)
    return innovation.judge_model(systematic, 200_000_000_000, 200.0, False).level


def learned_of(deviations=10.0, std=0.01, probability=1.0):
    """Return how many conditions a stiffness breaks that is so many deviations too high."""
    limit = DRIVE.transmission.stiffness * (1.0 + PARAMETERS.stiffness_error)
    value = limit / (1.0 - deviations * std)
    return len(innovation.learned_curve(
        {'learned_stiffness': value, 'learned_stiffness_std': std * value,
         'learned_gap_rad': 2.0 * DRIVE.transmission.half_gap, 'learned_gap_std_rad': 1.0,
         'probability_learned': probability}, DRIVE, PARAMETERS))


def twist_of(share):
    """Return whether a twist of `share` times the model's is beyond what is allowed."""
    rows = np.zeros((100, N_SMOOTHED))
    rows[:, S_TAU_K] = np.linspace(-0.5, 1.0, 100)
    rows[:, S_TAU_K_NOISE_STD] = 0.05
    shape = DRIVE.folded().transmission
    alone = 2.0 * (shape.half_gap + shape.hysteresis_width) + (
        1.5 + 2.0 * LIMITS.deviations * 0.05) / shape.stiffness
    rows[:, S_TWIST] = np.linspace(0.0, share * alone, 100)
    return bool(row_checks.twist_range(rows, DRIVE)[0])


DECISIONS = [
    ('covariance_low', covariance_of), ('covariance_high', covariance_of),
    ('nis_low', lambda x: errors_of(nis=x)), ('nis_high', lambda x: errors_of(nis=x)),
    ('nis_gross', lambda x: errors_of(nis=x)),
    ('variance_low', lambda x: errors_of(variance=[x, 1.0])),
    ('variance_high', lambda x: errors_of(variance=[1.0, x])),
    ('gate', lambda x: errors_of(single=x)),
    ('untrusted', lambda x: information_of(share=x)),
    ('unknown', lambda x: information_of(stated=x)),
    ('deviations', lambda x: learned_of(deviations=x)),
    ('learned_std', lambda x: learned_of(deviations=5.0, std=x)),
    ('most', lambda x: learned_of(probability=x)),
    ('twist_room', twist_of),
    ('deviations', lambda x: reach(0.1, 0.01, 0.02 * x, 0.02, 1.0) is not None)]


def test_a_value_just_below_and_just_above_decides_otherwise():
    for limit, decision in DECISIONS:
        assert_decides(decision, getattr(LIMITS, limit))


def test_counts_decide_at_their_value():
    assert mismatch_of(LIMITS.most) == Level.OK
    assert mismatch_of(LIMITS.most + 1 / 200) == Level.WARN
    rows = np.zeros((LIMITS.window_points, N_SMOOTHED))
    assert row_checks.twist_range(rows, DRIVE) is not None
    assert row_checks.twist_range(rows[1:], DRIVE) is None
    assert row_checks.passivity(rows[:LIMITS.window_points - 1], DRIVE) is None


def judged(white, dof=2.0):
    """Return the Outcome on whitened innovations [N, 2], of which the last 500 tell the mean."""
    n, stds = len(white), np.array([0.01, 0.03])
    return innovation.check(white, np.full(n, dof), np.full(n, dof), stds * white,
                            np.tile(stds, (n, 1)), 500, 1000)


def test_the_mean_is_that_of_the_last_samples_alone():
    white = np.random.default_rng(5).standard_normal((4000, 2))
    for rows, biased in ((slice(0, 3500), False), (slice(3500, 4000), True)):
        shifted = white.copy()
        shifted[rows, 1] += 1.0
        said = judged(shifted)
        assert ('biased' in said.message) == biased
        assert innovation.systematic({**said.values, 'ljung_box': 0.0}) == biased


def test_either_channel_tells_a_mean_and_what_is_not_white():
    for channel in (0, 1):
        white = np.random.default_rng(5).standard_normal((4000, 2))
        white[:, channel] = np.convolve(white[:, channel], [0.6, 0.8], 'same')
        said = judged(white)
        assert 'not white' in said.message
        sums = np.abs(white[-500:].sum(axis=0)) / np.sqrt(500.0)
        assert said.values['mean'] == pytest.approx(sums.max(), rel=1e-12)


def test_few_samples_or_few_that_were_read_are_too_few():
    white = np.random.default_rng(5).standard_normal((innovation.MIN_SAMPLES, 2))
    assert judged(white).message != judged(white[1:]).message == judged(white, 0.99).message
    assert 'too few' in judged(white[1:]).message


def test_bounds_are_stated_in_the_unit_of_the_reference():
    values = innovation.judge_covariance(0.3, 0.2, 0.25).values
    assert values['lower_bound'] == pytest.approx(LIMITS.covariance_low * 0.25)
    assert values['upper_bound'] == pytest.approx(LIMITS.covariance_high * 0.25)


def test_a_level_rises_and_falls_after_its_count_of_evaluations():
    alarm, fine = Alarm(), outcome_of([], None, {})
    broken = outcome_of([innovation.BELOW.said()], None, {})
    stamp = 0

    def levels(outcome, count):
        nonlocal stamp
        result = []
        for _ in range(count):
            stamp += 1_000_000_000
            result.append(alarm.judge(outcome, stamp).level)
        return result

    levels(fine, 20)
    up = levels(broken, LIMITS.debounce_up)
    assert up == [Level.OK] * (LIMITS.debounce_up - 1) + [Level.WARN]
    down = levels(fine, LIMITS.debounce_down)
    assert down == [Level.WARN] * (LIMITS.debounce_down - 1) + [Level.OK]
