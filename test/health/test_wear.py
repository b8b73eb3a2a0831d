# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The posterior of the wear against the joint Gaussian of windows, and the scan against refits."""
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import softmax
from scipy.stats import multivariate_normal

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash import wear
from gearbox_monitor.health.backlash.wear import Course, KNOTS, N_COMMON, Observations

CELLS, ROWS, POINTS = 4, 30, 2
COURSE = Course((40.0, 12.5), (20.5,))
PRIOR = np.array([1.0, 4e-4, 9e-4, 0.01, 0.02, 0.03, 0.05])  # of N_COMMON and two points


def observations(within=True, seed=3, jump=0.0):
    """Return cells and windows of two points, some without a value; `jump` in the last 8 rows."""
    random = np.random.default_rng(seed)
    n = CELLS + ROWS
    design = np.zeros((n, N_COMMON + POINTS))
    design[:, wear.LEVEL] = 1.0
    design[:, wear.TEMPERATURES] = random.normal(0.0, 10.0, (n, 2))
    design[:, wear.DISTRUST], design[:, wear.SHIFT] = random.random(n) < 0.2, np.arange(n) < 9
    design[np.arange(n), N_COMMON + random.integers(0, POINTS, n)] = 1.0
    count = np.concatenate([[40.0, 30.0, 20.0, 10.0], np.ones(ROWS)])
    weight = count / 0.02 ** 2 * (1.0 + 0.5 * random.random(n))
    weight[[CELLS + 3, CELLS + 17]] = 0.0
    y = random.normal(0.0, 0.1, n)
    y[-ROWS:] = 0.02 * random.standard_normal(ROWS)
    y[-8:] += jump
    y[weight == 0.0] = 0.0
    age = np.concatenate([[90.0, 70.0, 55.0, 42.0], np.arange(ROWS)[::-1] * 1.0])
    spread = random.normal(0.0, 3.0, (5, 2))  # readings of the temperature coefficients alone
    pull = random.normal(0.0, 0.1, 5)
    return Observations(design, y, weight, count, age, ROWS, (
        (spread.T @ spread, spread.T @ pull) if within else (np.zeros((2, 2)), np.zeros(2)))
        ), spread, pull


def joint(o, spread, pull, columns, variances):
    """Return (mean, covariance, log density of what is measured) of the dense Gaussian."""
    seen = o.weight > 0.0
    extra = np.zeros((len(pull), columns.shape[1]))
    extra[:, wear.TEMPERATURES] = spread
    A = np.concatenate([columns[seen], extra])
    noise = np.concatenate([1.0 / o.weight[seen], np.ones(len(pull))])
    b = np.concatenate([o.y[seen], pull])
    S = A @ np.diag(variances) @ A.T + np.diag(noise)
    gain = np.diag(variances) @ A.T @ np.linalg.inv(S)
    return (gain @ b, np.diag(variances) - gain @ A @ np.diag(variances),
            multivariate_normal(np.zeros(len(b)), S).logpdf(b))


def expect_posterior(within, has_slope, walk):
    o, spread, pull = observations(within)
    if not within:
        spread, pull = spread[:0], pull[:0]
    fit = wear.fit(o, PRIOR, COURSE, has_slope, walk)
    columns, variances, slope = wear.wear_columns(o.age, COURSE, has_slope, walk)
    mean, covariance, density = joint(o, spread, pull, np.column_stack([o.design, columns]),
                                      np.concatenate([PRIOR, variances]))
    assert fit.mean == pytest.approx(mean, rel=1e-6, abs=1e-9)
    assert fit.covariance == pytest.approx(covariance, rel=1e-6, abs=1e-10)
    assert fit.first == len(PRIOR) and fit.slope == (slope + len(PRIOR) if has_slope else -1)
    other = wear.fit(o, PRIOR, Course())
    _, _, without = joint(o, spread, pull, o.design, PRIOR)
    assert fit.likelihood - other.likelihood == pytest.approx(density - without, rel=1e-6)
    assert fit.wear(o.age) == pytest.approx(columns @ mean[len(PRIOR):], abs=1e-9)
    assert (other.wear(o.age) == 0.0).all() and other.slope == -1


def test_a_fit_is_the_posterior_of_the_joint_gaussian():
    for within in (True, False):
        for has_slope, walk in ((False, 0.0), (True, 0.0), (True, 0.004)):
            expect_posterior(within, has_slope, walk)


def test_wear_has_steps_slopes_between_them_and_a_walk_behind_the_first():
    age = np.array([50.0, 40.0, 39.0, 30.0, 20.0, 12.0, 2.0, 0.0])
    columns, variances, slope = wear.wear_columns(age, COURSE, True, 0.003)
    assert columns[:, 0].tolist() == [0, 0, 1, 1, 1, 1, 1, 1]
    assert columns[:, 1].tolist() == [0, 0, 0, 0, 0, 1, 1, 1]
    assert columns[:, 2].tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert columns[:, 3].tolist() == [0, 0, 1, 10, 20, 27.5, 27.5, 27.5]
    assert columns[:, 4].tolist() == [0, 0, 0, 0, 0, 0.5, 10.5, 12.5] and slope == 4
    assert variances[:5] == pytest.approx([LIMITS.step_std ** 2] * 2 + [LIMITS.pending_std ** 2]
                                          + [LIMITS.slope_std ** 2] * 2)
    # A walk: variance by the windows since, as far as knots of it lie behind the first step.
    walk = columns[:, 5:] ** 2 @ variances[5:]
    knots = np.array([0, *(k for k in KNOTS if k < 40)])
    expected = [0.003 ** 2 * (knots[-1] - knots[knots <= a][-1]) for a in age]
    assert walk == pytest.approx(expected, abs=1e-15) and walk[-1] == pytest.approx(9e-6 * 29)
    only, of_steps, none = wear.wear_columns(age, COURSE, False, 0.0)
    assert only.shape == (8, 3) and len(of_steps) == 3 and none == -1
    assert wear.wear_columns(age, Course((), (3.0,)), True, 0.003)[0].shape == (8, 1)
    assert wear.wear_columns(age, Course(), True, 0.003)[0].shape == (8, 0)


def expect_mixture(course):
    o, spread, pull = observations(jump=0.08)
    noise, rows = 0.02, []
    variants = LIMITS.courses if course.steps else ((False, 0.0),)
    for has_slope, walk in variants:
        columns, variances, slope = wear.wear_columns(o.age, course, has_slope, walk * noise)
        mean, covariance, density = joint(o, spread, pull, np.column_stack([o.design, columns]),
                                          np.concatenate([PRIOR, variances]))
        now = wear.wear_columns(np.zeros(1), course, has_slope, walk * noise)[0][0]
        k = len(PRIOR)
        at = k + slope
        rows.append((density, now @ mean[k:], now @ covariance[k:, k:] @ now,
                     *((mean[at], covariance[at, at]) if has_slope else (np.nan, np.nan))))
    density, value, variance, slope, slope_variance = np.array(rows).T
    share = softmax(density + (np.log(LIMITS.course_prior) if course.steps else 0.0))
    estimate = wear.estimate(o, PRIOR, course, noise)
    mean = share @ value
    assert estimate.value == pytest.approx(mean, rel=1e-6)
    assert estimate.std ** 2 == pytest.approx(share @ (variance + (value - mean) ** 2), rel=1e-5)
    assert estimate.moving == pytest.approx(1.0 - share[0] if course.steps else 0.0, abs=1e-9)
    chosen = variants[int(np.argmax(share))]
    assert (estimate.fit.has_slope, estimate.fit.walk) == (chosen[0], chosen[1] * noise)
    k = int(np.argmax(np.where(np.isfinite(slope), share, -1.0)))
    expected = (slope[k], slope_variance[k] ** 0.5) if course.steps else (0.0, 0.0)
    assert (estimate.slope, estimate.slope_std) == pytest.approx(expected, rel=1e-5)


def test_wear_now_is_that_of_all_courses_by_their_probability():
    for course in (COURSE, Course((9.5,)), Course((), (20.5,))):
        expect_mixture(course)


def test_a_scan_finds_the_step_that_one_more_free_column_would_have():
    """The score of a stretch is the root of its likelihood ratio."""
    o, spread, pull = observations(jump=0.08)
    fit = wear.fit(o, PRIOR, Course((25.5,)))
    scanned = wear.scan(o, fit)
    columns, variances, _ = wear.wear_columns(o.age, Course((25.5,)), False, 0.0)
    design = np.column_stack([o.design, columns])
    *_, without = joint(o, spread, pull, design, np.concatenate([PRIOR, variances]))
    wide = 10.0
    for row in (0, 5, 13, 22, 27):
        begin = CELLS + row
        step = np.zeros((len(o.y), 1))
        step[begin:] = 1.0
        mean, covariance, density = joint(
            o, spread, pull, np.column_stack([design, step]),
            np.concatenate([PRIOR, variances, [wide]]))
        variance = 1.0 / (1.0 / covariance[-1, -1] - 1.0 / wide)  # less what the prior says
        size = mean[-1] * (1.0 + variance / wide)
        assert scanned.size[row] == pytest.approx(size, rel=1e-5)
        assert scanned.std[row] == pytest.approx(variance ** 0.5, rel=1e-5)
        gain = (2.0 * (density - without) + np.log1p(wide / variance)) * (1.0 + variance / wide)
        score = np.sign(size) * gain ** 0.5
        assert scanned.up[row] == pytest.approx(score, rel=1e-4)
        assert scanned.down[row] == pytest.approx(-score, rel=1e-4)
        total = o.weight[begin:].sum()
        assert scanned.noise[row] == pytest.approx(1.0 / (total * scanned.std[row] ** 2))
    residual = o.y - fit.design @ fit.mean
    assert scanned.newest == pytest.approx(residual[-1] * o.weight[-1] ** 0.5)


def rows_of(deviations):
    """Return the Observations of windows off a known level by so many standard deviations."""
    n = len(deviations)
    design = np.zeros((n, N_COMMON))
    design[:, wear.LEVEL] = 1.0
    return Observations(design, 0.1 * np.array(deviations), np.full(n, 100.0), np.ones(n),
                        np.arange(n)[::-1] * 1.0, n, (np.zeros((2, 2)), np.zeros(2)))


def test_a_lone_window_counts_no_more_than_a_little_beyond_the_next():
    known = np.full(N_COMMON, 1e-12)
    for sign in (1.0, -1.0):
        off = sign * np.array([0.5, 9.0, 0.25, 1.0, 4.0])
        scanned = wear.scan(rows_of(off), wear.fit(rows_of(off), known, Course()))
        side, other = (scanned.up, scanned.down) if sign > 0.0 else (scanned.down, scanned.up)
        # Of the stretch from the second on, 9 is taken for 4 + the loner's; of the last, itself.
        limited = np.array([14.75 - 2.0, 14.25 - 2.0, 5.25, 5.0, LIMITS.loner])
        lengths = np.array([5.0, 4.0, 3.0, 2.0, 1.0])
        assert side == pytest.approx(limited / lengths ** 0.5, rel=1e-6)
        # The other way none is alone: as many as there are, and the last at most the loner's.
        plain = -np.array([14.75, 14.25, 5.25, 5.0, 4.0]) / lengths ** 0.5
        assert other == pytest.approx(plain, rel=1e-6)
        assert scanned.newest == pytest.approx(off[-1], rel=1e-6)


def test_a_stretch_without_windows_is_not_judged():
    o = rows_of([0.5, 9.0, 0.25, 1.0, 4.0])
    o = replace(o, weight=np.array([100.0, 100.0, 100.0, 0.0, 0.0]))
    scanned = wear.scan(o, wear.fit(o, np.full(N_COMMON, 1e-12), Course()))
    assert np.isnan(scanned.size[-2:]).all() and np.isnan(scanned.std[-2:]).all()
    assert scanned.up[-2:].tolist() == scanned.down[-2:].tolist() == [0.0, 0.0]
    assert scanned.noise[-2:].tolist() == [1.0, 1.0] and scanned.newest == 0.0
    assert scanned.up[2] == pytest.approx(0.25, rel=1e-6)


def test_ages_are_windows_since():
    assert wear.ages([5_000, 9_000], 11_000, 2_000.0).tolist() == [3.0, 1.0]
