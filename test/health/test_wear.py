# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Posterior of the wear against the joint Gaussian of windows; odds of a change, their rate."""
import numpy as np
import pytest
from scipy.stats import multivariate_normal

from gearbox_monitor.health.backlash import wear
from gearbox_monitor.health.backlash.change_tests import FEATURES, PRIORS, WEAR
from gearbox_monitor.health.backlash.wear import (
    Columns, evidence, FIRST, KNOTS, limited_evidence, N_COMMON, Observations, Posterior,
    SECOND_ONE, step_odds)

F, CELLS, ROWS, POINTS = len(FEATURES), 4, 24, 2
STEPS = ((30.0, 1.0, True), (18.5, 0.5, False), (9.5, 1.0, True))


def observations(seed=3, jump=0.0, rows=ROWS):
    """Return cells and windows of two points, some without a feature; `jump` in the last 8."""
    random = np.random.default_rng(seed)
    n = CELLS + rows
    design = np.zeros((F, n, N_COMMON + POINTS))
    design[:, :, wear.LEVEL] = 1.0
    design[:, :, wear.TEMPERATURES] = random.normal(0.0, 10.0, (F, n, 2))
    design[:, :, wear.DISTRUST] = random.random(n) < 0.2
    design[:, np.arange(n), N_COMMON + random.integers(0, POINTS, n)] = 1.0
    count = np.ones((n, F))
    count[:CELLS] = np.array([[40.0], [30.0], [20.0], [10.0]])
    count[CELLS + 3, 0] = count[CELLS + 7, 2:] = 0.0
    mixed = random.normal(0.0, 0.02, (F, F))
    noise = mixed @ mixed.T + 1e-4 * np.eye(F)
    weight = np.zeros((n, F, F))
    for k in range(n):
        seen = np.flatnonzero(count[k])
        weight[np.ix_([k], seen, seen)] = count[k, 0] * np.linalg.inv(noise[np.ix_(seen, seen)]) \
            if count[k, 0] > 1.0 else np.linalg.inv(noise[np.ix_(seen, seen)])
    y = random.multivariate_normal(np.zeros(F), noise, n)
    y[-8:, [0, 2]] += jump
    prior = np.tile([1.0, 4e-4, 9e-4, 0.01, 0.03, 0.05], (F, 1))
    inside = random.normal(0.0, 3.0, (5, F, 2))  # readings of the temperature coefficients alone
    pull = random.normal(0.0, 0.1, 5)
    return Observations(
        design, y, weight, count, np.arange(n) * 10, rows, (0, 1), prior,
        np.einsum('kfs,kgt->fsgt', inside, inside), np.einsum('kfs,k->fs', inside, pull)
    ), inside, pull


def columns(o, parts=((0, STEPS), (2, STEPS[:1])), **course):
    age = np.append(np.arange(len(o.y))[::-1] * 1.0, 0.0)
    return Columns.of([(f, *wear.wear_columns(age, steps, **course)) for f, steps in parts], age)


def joint(o, inside, pull, c):
    """Return (mean, covariance, log density of what is measured) of the dense Gaussian."""
    width = o.prior.shape[1]
    size = F * width
    A, b, blocks = [], [], []
    for k in range(len(o.y)):
        seen = np.flatnonzero(o.counts[k])
        for f in seen:
            row = np.zeros(size + len(c.feature))
            row[f * width:(f + 1) * width] = o.design[f, k]
            row[size:] = (c.feature == f) * c.values[:, k]
            A.append(row)
            b.append(o.y[k, f])
        blocks.append(np.linalg.inv(o.weight[np.ix_([k], seen, seen)][0]))
    for reading, value in zip(inside, pull):
        row = np.zeros((F, width))
        row[:, wear.TEMPERATURES] = reading
        A.append(np.append(row.ravel(), np.zeros(len(c.feature))))
        b.append(value)
        blocks.append(np.eye(1))
    noise, at = np.zeros((len(b), len(b))), 0
    for block in blocks:
        noise[at:at + len(block), at:at + len(block)] = block
        at += len(block)
    A, b = np.array(A), np.array(b)
    variances = np.concatenate([o.prior.ravel(), c.variance])
    S = A @ np.diag(variances) @ A.T + noise
    gain = np.diag(variances) @ A.T @ np.linalg.inv(S)
    return (gain @ b, np.diag(variances) - gain @ A @ np.diag(variances),
            multivariate_normal(np.zeros(len(b)), S).logpdf(b))


@pytest.mark.parametrize('course', [{}, {'slope': 0.01}, {'slope': 0.1, 'walk': 0.004}])
def test_a_fit_is_the_posterior_of_the_joint_gaussian(course):
    o, inside, pull = observations()
    base, c = Posterior(o), columns(o, **course)
    fit, size = base.fit(c), o.prior.size
    mean, covariance, density = joint(o, inside, pull, c)
    assert fit.mean == pytest.approx(mean[size:], rel=1e-6, abs=1e-7)
    assert fit.covariance == pytest.approx(covariance[size:, size:], rel=1e-6, abs=1e-6)
    known, variance = fit.without_wear()
    assert known.ravel() == pytest.approx(mean[:size], rel=1e-6, abs=1e-7)
    assert variance.ravel() == pytest.approx(np.diag(covariance)[:size], rel=1e-6, abs=1e-6)
    none = base.fit(columns(o, ()))
    *_, without = joint(o, inside, pull, columns(o, ()))
    assert fit.likelihood - none.likelihood == pytest.approx(density - without, rel=1e-6)
    weights = np.random.default_rng(1).standard_normal(len(mean))
    value, std = fit.combined(weights[:size], weights[size:])
    assert value == pytest.approx(weights @ mean, rel=1e-6)
    assert std ** 2 == pytest.approx(weights @ covariance @ weights, rel=1e-5)


def test_wear_has_steps_slopes_between_them_and_a_walk_behind_the_first():
    age = np.array([50.0, 30.0, 29.0, 20.0, 18.0, 9.0, 2.0, 0.0])
    found, variances = wear.wear_columns(age, STEPS, 0.01, 0.003)
    assert found[:, 0].tolist() == [0, 0, 1, 1, 1, 1, 1, 1]
    assert found[:, 1].tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    assert found[:, 2].tolist() == [0, 0, 0, 0, 0, 1, 1, 1]
    assert found[:, 3].tolist() == [0, 0, 1, 10, 12, 20.5, 20.5, 20.5]
    assert found[:, 4].tolist() == [0, 0, 0, 0, 0, 0.5, 7.5, 9.5]
    assert variances[:5] == pytest.approx([1.0, 0.25, 1.0] + [0.01 ** 2] * 2)
    # A walk: variance by the windows since, as far as knots of it lie behind the first step.
    walk = found[:, 5:] ** 2 @ variances[5:]
    knots = np.array([0, *(k for k in KNOTS if k < 30)])
    expected = [0.003 ** 2 * (knots[-1] - knots[knots <= a][-1]) for a in age]
    assert walk == pytest.approx(expected, abs=1e-15)
    assert wear.wear_columns(age, STEPS[1:2], 0.01, 0.003)[0].shape == (8, 1)
    assert wear.wear_columns(age, (), True, 0.003)[0].shape == (8, 0)


def test_the_odds_of_a_step_are_those_of_one_more_column():
    """Of one feature and of two, against refits of the joint Gaussian; sizes and priors mixed."""
    o, inside, pull = observations(jump=0.3)
    parts = ((0, STEPS[:1]), (3, STEPS[1:2]))
    fit = Posterior(o).fit(columns(o, parts))
    scanned = fit.scan
    odds, steps = evidence(scanned.pull, scanned.free)
    *_, without = joint(o, inside, pull, columns(o, parts))
    shares = np.array([p.share for p in PRIORS])
    for row, h in ((2, 1), (16, 0), (16, F + 1), (21, F + 9)):
        a, b = int(FIRST[h]), int(SECOND_ONE[h])
        age = ROWS - row - 0.5
        ratios = []
        for size in WEAR.sizes:
            more = [(f, ((age, size, False),)) for f in sorted({a, b})]
            mean, _, density = joint(o, inside, pull, columns(o, (*parts, *more)))
            ratios.append((density - without, mean[-len(more):]))
        prior = (1.0 - WEAR.pair) * shares[a] if a == b else \
            2.0 * WEAR.pair * shares[a] * shares[b] / (1.0 - (shares ** 2).sum())
        expected = np.logaddexp.reduce([r for r, _ in ratios]) - np.log(len(WEAR.sizes))
        best = max(ratios, key=lambda r: r[0])[1]
        for f, step in zip(sorted({a, b}), best):
            prior *= 2.0 * (PRIORS[f].up if step > 0.0 else 1.0 - PRIORS[f].up)
        assert odds[row, h] == pytest.approx(expected + np.log(prior), rel=1e-5)
        assert steps[row, h][:len(best)] == pytest.approx(best, rel=1e-5)
    assert (FIRST[odds.max(axis=0).argmax()], SECOND_ONE[odds.max(axis=0).argmax()]) == (0, 2)
    total = sum(np.exp(wear._PRIOR))
    assert total == pytest.approx(1.0) and sum(shares) == pytest.approx(1.0)


def test_the_odds_of_a_step_of_the_fit_are_those_of_its_column():
    o, inside, pull = observations(jump=0.05)
    fit = Posterior(o).fit(columns(o, ((0, STEPS[2:]),)))
    *_, density = joint(o, inside, pull, columns(o, ((0, STEPS[2:]),)))
    *_, without = joint(o, inside, pull, columns(o, ()))
    odds = step_odds(fit.mean[0], fit.covariance[0, 0], STEPS[2][1] ** 2, 1e12)
    assert odds == pytest.approx(density - without, rel=1e-5)


def known_level(y, dof=1e9):
    """Return the limited odds of windows [N, F] off a known level by standard deviations."""
    n = len(y)
    o = Observations(
        np.ones((F, n, N_COMMON)), 0.01 * y, np.tile(1e4 * np.eye(F), (n, 1, 1)), np.ones((n, F)),
        np.arange(n), n, (), np.full((F, N_COMMON), 1e-12), np.zeros((F, 2, F, 2)),
        np.zeros((F, 2)))
    base = Posterior(o)
    scanned = base.fit(columns(o, ())).scan
    return limited_evidence(base, scanned, scanned, np.full(F, dof))


def test_one_window_alone_is_chance_and_two_that_agree_are_none():
    chance = -np.log(3.15e6)
    for size in (7.0, 50.0, -50.0):
        y = np.zeros((6, F))
        y[4, 0] = size
        assert known_level(y).max() + chance < 0.0
        y[5, 0] = size * 1.02
        odds = known_level(y)
        assert odds.max() + chance > 0.0
        assert np.unravel_index(odds.argmax(), odds.shape) == (4, 0)


def test_false_alarms_are_no_more_often_than_asked_for():
    """Windows of 7 features without a change: mean time to a false alarm against the one asked."""
    random, windows, times, alarms = np.random.default_rng(5), 100, 0, 0
    for _ in range(8):
        y = random.standard_normal((3 * windows, F))
        for n in range(1, len(y) + 1):
            odds = known_level(y[max(n - WEAR.horizon, 0):n])
            times += 1
            if np.logaddexp.reduce(odds, axis=None) >= np.log(WEAR.tightness * windows):
                alarms += 1
                break
    assert times > windows * alarms > 0


def test_spans_are_told_in_the_largest_unit_that_holds_two():
    told = [wear.span(seconds) for seconds in (0.0, 119.0, 120.0, 7199.0, 7200.0, 172800.0)]
    assert told == ['0 s', '119 s', '2 min', '120 min', '2 h', '2 d']
    assert wear.span(float('inf')) == 'never'
