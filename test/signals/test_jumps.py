# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Positions that jump: turns, rows of a stranger, outliers, slips; and motion that does not."""
import math

import numpy as np
import pytest

from gearbox_monitor.diagnosis.robot.robot_log import continuous, RawLog, SETPOINT
from gearbox_monitor.signals.jumps import (
    OUTLIER, PERIODS, SLIP, strangers, TURNS, turns, wild_rows, without_jumps)

T = np.arange(0.0, 20.0, 0.01)
SWING = 1.4 * np.sin(2.0 * math.pi * 0.21 * T) + 0.3 * np.sin(2.0 * math.pi * 0.9 * T)
TURNING = 2.8 + SWING


def test_turns_of_any_period_are_counted_on():
    for period in (2.0 * math.pi, 360.0, math.pi, 0.35):
        for noise in (0.0, 1e-3):
            errors = noise * np.random.default_rng(0).normal(size=len(T))
            whole = period / (2.0 * math.pi) * (3.0 * TURNING + errors)
            wrapped = (whole + period / 2.0) % period - period / 2.0
            q, (finding,) = without_jumps(wrapped, T)
            assert finding.kind == TURNS and finding.count == np.count_nonzero(
                np.diff(np.floor((whole + period / 2.0) / period)))
            # Of a period that no convention has, the jumps themselves tell the size.
            accuracy = 1e-9 if period in PERIODS else 2e-3
            np.testing.assert_allclose(q - q[0], whole - whole[0], atol=accuracy * period)


STEADY = [
    SWING, np.round(SWING / 2e-3) * 2e-3, np.repeat(SWING[::10], 10),
    SWING + np.random.default_rng(0).normal(0.0, 0.02, len(T)),
    np.where(T < 10.0, 0.0, 4.0 * (T - 10.0)), np.full(len(T), 0.3),
    np.cumsum(np.random.default_rng(2).normal(0.0, 1.0, len(T)))]


def test_motion_noise_and_coarse_or_slow_encoders_are_no_jumps():
    for q in STEADY:
        changed, found = without_jumps(q, T)
        assert found == () and np.array_equal(changed, q)
        assert not strangers(np.column_stack([q, q]), T).any()


def test_outliers_and_slips_are_found_with_their_place():
    q = SWING + np.random.default_rng(1).normal(0.0, 1e-4, len(T))
    q[[300, 301, 900]] += [0.8, 0.8, -2.0]
    mended, (finding,) = without_jumps(q, T)
    assert (finding.kind, finding.count, finding.row) == (OUTLIER, 3, 300)
    assert np.flatnonzero(np.isnan(mended)).tolist() == [300, 301, 900]
    slipped = np.where(T < 7.0, SWING, SWING + 0.4)
    same, (finding,) = without_jumps(slipped, T)
    assert (finding.kind, finding.row) == (SLIP, 700) and np.array_equal(same, slipped)
    assert finding.size == pytest.approx(0.4, abs=0.03)


def test_outliers_of_one_size_are_no_turns():
    q = SWING.copy()
    q[[700, 1200, 1600]] = 1e4
    without, (finding,) = without_jumps(q, T)
    assert finding.kind == OUTLIER and finding.count == 3
    assert np.isnan(without[[700, 1200, 1600]]).all() and np.nanmax(np.abs(without)) < 2.0


def test_outliers_of_an_effort_are_alone_far_beyond_the_others():
    load = 20.0 * np.sin(T) + np.random.default_rng(0).normal(size=len(T))
    spoilt = load.copy()
    spoilt[[300, 301, 1500]] = 5e5, 4e5, -7e4
    for offset in (0.0, 2e5):
        assert wild_rows(spoilt + offset).tolist() == [300, 301, 1500]
    bump = np.where(np.abs(T - 10.0) < 0.05, 300.0, 0.01 * load)
    for effort in (load, bump, np.sign(load), 0.0 * T, np.where(T > 19.9, load, 0.0), np.nan * T):
        assert not len(wild_rows(effort))


def test_rows_of_a_second_publisher_are_those_of_one_posture():
    q = np.column_stack([1.0 + SWING, -0.7 + 0.5 * SWING])
    rows = np.arange(37, len(q), 53)
    mixed = np.insert(q, rows, [0.0, 0.0], axis=0)
    foreign = strangers(mixed, np.arange(len(mixed)))
    assert foreign.sum() == len(rows)
    np.testing.assert_array_equal(mixed[~foreign], q)
    stops = np.column_stack([np.clip(SWING, -1.0, 1.0), np.clip(SWING, -1.0, 1.0)])
    assert not strangers(stops, T).any()


def test_a_dropout_or_a_restart_of_the_clock_is_no_jump():
    keep = (T < 6.0) | (T > 7.5)
    assert without_jumps(SWING[keep], T[keep])[1] == ()
    twice = np.concatenate([SWING[:1100], SWING[300:]])
    assert without_jumps(twice, np.concatenate([T[:1100], T[:-300]]))[1] == ()


def test_a_robot_log_is_continuous_and_says_what_was_done():
    wrapped = (TURNING + math.pi) % (2.0 * math.pi) - math.pi
    goal = (TURNING + 0.01 + math.pi) % (2.0 * math.pi) - math.pi
    raw = RawLog('log', T, {'a': wrapped, 'b': SWING}, {'a': goal, 'b': SWING}, SETPOINT)
    log = continuous(raw)
    assert 'a: the position jumps by a turn' in str(log.notes[0]) and len(log.notes) == 1
    np.testing.assert_allclose(log.input['a'] - log.position['a'], 0.01, atol=1e-9)
    assert np.ptp(log.position['a']) == pytest.approx(np.ptp(TURNING))
    assert turns(log.position['a'], T)[1].size == 0
