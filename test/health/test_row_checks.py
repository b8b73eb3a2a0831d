# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Torque against twist: exact curves with one error each, and checks that abstain."""

from drives import driven, part_of, samples_of
import numpy as np
import pytest

from gearbox_monitor.estimation.rts_smoother import (
    N_SMOOTHED, S_MOTOR_SIDE, S_MOTOR_SIDE_NOISE_STD, S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST,
    S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD, S_U, S_X2, S_X3, S_X4)
from gearbox_monitor.health import monitor as monitor_module
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.checks import innovation, row_checks
from gearbox_monitor.health.checks.row_checks import AGAINST, passivity, RowCheck, twist_range
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.transmission import KINDS, transmission_torque

MODEL = DriveModel()
T = 0.02 * np.arange(500)


def rows_of(half_gap=0.1, stiffness=25.0, zero=0.3, gain=0.0, viscous=0.0, scale=0.0, delay=0.0):
    """Return exact rows [N, N_SMOOTHED] of a drive whose estimates have these errors."""
    twist = 0.25 * np.sin(7.1 * T) + 0.08 * np.sin(17.3 * T)
    torque = stiffness * (twist - np.clip(twist, -half_gap, half_gap))
    x2, x4 = 2.0 * np.sin(5.3 * T), 10.6 * np.cos(5.3 * T)
    u = torque + 0.2 * x4 + 1.5 * np.cos(11.0 * T)
    rows = np.zeros((len(T), N_SMOOTHED))
    rows[:, S_TWIST] = twist + zero + scale * x2 + delay * x4
    rows[:, S_X2], rows[:, S_X4], rows[:, S_X3], rows[:, S_U] = x2, x4, x4, u
    rows[:, [S_TAU_K_NOISE_STD, S_MOTOR_SIDE_NOISE_STD]] = 0.3
    rows[:, [S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD]] = 0.004, 0.1
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(T))
    rows[:, S_MOTOR_SIDE] = torque + gain * u + viscous * x4 + noise
    rows[:, S_TAU_K] = rows[:, S_MOTOR_SIDE]
    return rows


ERRORS = [
    ({'gain': 0.5}, 'elastic_gain', row_checks.OTHER_TORQUE),
    ({'gain': -0.4}, 'elastic_gain', row_checks.OTHER_TORQUE),
    ({'viscous': 0.15}, 'elastic_viscous', row_checks.OTHER_TORQUE),
    ({'scale': 0.02}, 'elastic_scale', row_checks.OTHER_TWIST),
    ({'delay': 0.005}, 'elastic_delay_s', row_checks.OTHER_TWIST)]


def test_each_error_is_found_with_its_size():
    for error, key, condition in ERRORS:
        broken, values = row_checks.check(rows_of(**error), MODEL)
        assert broken == [condition.said()]
        assert values[key] == pytest.approx(next(iter(error.values())), rel=0.1)


def test_an_estimated_friction_is_no_error_but_a_gain_and_an_encoder_are():
    """tau_K is then what the twist says; friction, within reason, stands in the other state."""
    for error, condition in (({'viscous': 0.3}, None), ({'gain': 0.5}, row_checks.OTHER_TORQUE),
                             ({'delay': 0.02}, row_checks.OTHER_TWIST)):
        rows = rows_of(**error)
        rows[:, S_TAU_K] -= error.get('viscous', 0.0) * rows[:, S_X3] + 1e-3
        assert list(row_checks.check(rows, MODEL)[0]) == (
            [] if condition is None else [condition.said()])


def hysteretic(kind, worn=1.0, **errors):
    """Return a drive with a play of this `kind` and rows_of it, its width off by `worn`."""
    drive = MODEL.with_(kind=kind, stiffness=25.0, half_gap=0.05, hysteresis_width=0.05,
                        hysteresis_stiffness=30.0 if kind == 'passive_play' else 0.0)
    shape, memory, rows = drive.transmission, 0.0, rows_of(**errors)
    twist = (rows[:, S_TWIST] - 0.3 - errors.get('delay', 0.0) * rows[:, S_X4])
    torque = np.empty(len(rows))
    for k in range(len(rows)):
        torque[k], memory = transmission_torque(
            twist[k], memory, KINDS.index(kind), shape.stiffness, shape.half_gap,
            worn * shape.hysteresis_width, shape.hysteresis_stiffness)
    rows[:, S_MOTOR_SIDE] = torque + 0.05 * np.random.default_rng(2).standard_normal(len(rows))
    rows[:, S_TAU_K] = rows[:, S_MOTOR_SIDE]
    return drive, rows


def test_hysteresis_of_the_model_is_no_delay_and_a_delay_is_found_beside_it():
    for kind in ('play', 'passive_play'):
        drive, rows = hysteretic(kind)
        assert row_checks.check(rows, drive)[0] == []
        assert row_checks.check(rows, MODEL.with_(half_gap=0.05))[0]
        worn, rows = hysteretic(kind, worn=1.2)
        assert row_checks.check(rows, worn)[0] == []
        drive, rows = hysteretic(kind, delay=0.005)
        broken, values = row_checks.check(rows, drive)
        assert broken == [row_checks.OTHER_TWIST.said()]
        assert values['elastic_delay_s'] == pytest.approx(0.005, rel=0.1)


def slow(arm=1.5, **errors):
    """Return rows_of in slow motion, where the arm's friction alone loads the flanks."""
    rows = rows_of(**errors)
    x4 = 4.0 * np.sin(1.0 * T)
    torque = arm * np.tanh(20.0 * x4)
    twist = torque / MODEL.transmission.stiffness + 0.1 * np.tanh(20.0 * x4)
    rows[:, S_X2], rows[:, S_X4], rows[:, S_X3] = -4.0 * np.cos(1.0 * T), x4, x4
    rows[:, S_U] = torque + 0.1 * x4 + 0.27 * np.tanh(20.0 * x4)
    rows[:, S_TWIST] = twist + errors.get('delay', 0.0) * x4
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(T))
    rows[:, S_MOTOR_SIDE] = torque + errors.get('viscous', 0.0) * x4 + noise
    rows[:, S_TAU_K] = rows[:, S_MOTOR_SIDE]
    return rows


def test_slow_motion_does_not_tell_delay_from_friction_but_that_one_of_them_is_wrong():
    both = {row_checks.OTHER_TORQUE.code, row_checks.OTHER_TWIST.code}
    for error in ({'delay': 0.01}, {'viscous': 0.3}):
        broken, _ = row_checks.check(slow(**error), MODEL)
        assert broken and {said.code for said in broken} <= both, error
    for error in ({}, {'delay': 0.001}, {'viscous': 0.02}):  # within the tolerances
        assert not row_checks.check(slow(**error), MODEL)[0], error


def test_an_error_in_slow_motion_is_certain_once_several_windows_agree():
    rows = slow()
    rows[:, S_MOTOR_SIDE] += 0.5 * rows[:, S_U] + 0.2 * np.random.default_rng(5).standard_normal(
        len(T))
    rows[:, S_TAU_K] = rows[:, S_MOTOR_SIDE]
    broken, values = row_checks.check(rows, MODEL)
    assert broken == []

    def earlier(*factors):
        return [{**values, 'elastic_gain': k * values['elastic_gain']} for k in factors]

    assert row_checks.check(rows, MODEL, earlier(1.05, 0.95))[0] == []
    assert row_checks.check(rows, MODEL, earlier(1.05, 0.95, 1.0))[0] == [
        row_checks.OTHER_TORQUE.said()]
    assert row_checks.check(rows, MODEL, earlier(0.0, 2.0, -1.0))[0] == []


WORN = [{}, {'half_gap': 0.14}, {'stiffness': 20.0}, {'zero': -2.0}]


def test_wear_and_another_zero_are_no_error():
    for worn in WORN:
        for check in (row_checks.check, twist_range):
            assert check(rows_of(**worn), MODEL)[0] == []


def test_torque_without_a_curve():
    rows = rows_of()
    rows[:, S_MOTOR_SIDE] = 3.0 * np.sign(np.sin(29.0 * T))
    assert row_checks.NO_CURVE.said() in row_checks.check(rows, MODEL)[0]


def test_without_contact_or_rows_the_curve_abstains():
    rows = rows_of()
    assert row_checks.check(rows[:150:5], MODEL) is None
    rows[:, S_TWIST], rows[:, S_MOTOR_SIDE] = 0.02 * np.sin(T), 0.0
    assert row_checks.check(rows, MODEL) is None
    hardening = {'id': 'hardening', 'K3': 100.0}
    assert row_checks.check(rows_of(), MODEL.with_(effects=[hardening])) is None


def test_a_spring_that_unwinds_makes_no_power_but_one_that_pulls_along_does():
    for sign, broken in ((1.0, []), (-1.0, [AGAINST.said()])):
        rows = rows_of()
        rows[:, S_TWIST] = MODEL.transmission.half_gap + 0.5 - 0.04 * T
        rows[:, S_X3], rows[:, S_X4] = -0.04, 0.0
        rows[:, S_TAU_K] = sign * MODEL.transmission.stiffness * (0.5 - 0.04 * T)
        rows[:, S_TWIST_RATE_NOISE_STD] = 1e-3
        assert list(passivity(rows, MODEL)[0]) == broken


def test_correlation_and_power_are_those_of_the_phase_between_torque_and_twist():
    """Over whole turns cos and sin of the phase; a spring that is let go gives back its work."""
    phase, n = 0.7, 4000
    t = np.linspace(0.0, 6.0 * np.pi, n)
    rows = np.zeros((n, N_SMOOTHED))
    rows[:, S_TWIST], rows[:, S_TAU_K] = 0.3 * np.sin(t), 2.0 * np.sin(t + phase)
    rows[:, S_X3] = 0.9 * np.cos(t)
    rows[:, [S_TAU_K_NOISE_STD, S_TWIST_NOISE_STD, S_TWIST_RATE_NOISE_STD]] = 1e-6
    _, values = passivity(rows, MODEL)
    assert values['torque_twist_correlation'] == pytest.approx(np.cos(phase), abs=1e-3)
    assert values['torque_twist_power'] == pytest.approx(np.sin(phase), abs=1e-3)
    spring = rows[:n // 12].copy()  # a quarter of a turn, from the stretched end on
    spring[:, S_TWIST] = 0.3 * np.cos(t[:n // 12])
    spring[:, S_TAU_K] = MODEL.transmission.stiffness * spring[:, S_TWIST]
    _, values = passivity(spring, MODEL)
    assert values['torque_twist_power'] == pytest.approx(0.0, abs=1e-3)


def test_a_twist_of_turns_is_an_error():
    rows = rows_of()
    rows[:, S_TWIST] += 4.0 * np.sin(T)
    broken, values = twist_range(rows, MODEL)
    assert [condition.level for condition in broken] == [Level.ERROR]
    assert values['twist_range'] > 7.0 > values['twist_range_threshold']


def test_an_alarm_counts_only_evaluations_that_reached_a_result(monkeypatch):
    """Violated in 3 results, 3 evaluations apart; then good ones, as seldom, end it."""
    answers = []

    def seldom(rows, drive):
        answers.append(None if len(answers) % 3 else 1 <= len(answers) // 3 <= 3)
        return None if answers[-1] is None else ([innovation.BIASED] if answers[-1] else [], {})

    monkeypatch.setattr(monitor_module, 'ROW_CHECKS', (RowCheck('seldom', 2.0, seldom),))
    samples, monitor, levels = samples_of(driven(MODEL, 36.0)), Monitor(MODEL), []
    for k in range(0, 36_000, 1000):
        monitor.run(part_of(samples, k, k + 1000))
        levels.append(monitor.outcomes['prediction error'].level)
    values = monitor.outcomes['prediction error'].values
    assert values['seldom_evaluations'] == len(answers)
    assert values['seldom_results'] == sum(answer is not None for answer in answers)
    raised = np.flatnonzero(np.array(levels[5:]) > Level.OK) + 5
    first = len(levels) - len(answers) + 9  # the third of them is that of the 10th evaluation
    assert raised[0] == first and np.array_equal(raised, np.arange(first, first + 15))
