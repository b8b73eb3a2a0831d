# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The normal equations of torque over twist, against differences of their cost."""
import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from gearbox_monitor.health.elastic_regression import (
    COULOMB, DELAY, ElasticLaw, GAIN, HALF_GAP, HEIGHT, INERTIA, N_DATA, N_SHAPE, Regression,
    SCALE, STIFFNESS, VISCOUS, WIDTH, ZERO)
from gearbox_monitor.kernels.linear_least_squares import Damping

SHAPE = [STIFFNESS, HALF_GAP, WIDTH, ZERO, VISCOUS, COULOMB, GAIN]


def data(seed=0):
    """Return a motion [2000, N_DATA] whose columns differ, with noise on the torque."""
    t, random = np.linspace(0.0, 2.5, 2000), np.random.default_rng(seed)
    twist = np.sin(5.7 * t) + 0.5 * np.sin(14.0 * t)
    x3 = 12.0 * np.cos(4.1 * t) + 6.0 * np.sin(11.0 * t)
    rows = np.column_stack([
        twist, np.gradient(twist, t), 2.0 * np.sin(5.3 * t), 10.6 * np.cos(5.3 * t), x3,
        np.sign(x3), 3.0 * np.sin(23.0 * t),
        7.0 * (twist - np.clip(twist, -0.4, 0.4)) + 0.3 * random.standard_normal(len(t))])
    assert rows.shape[1] == N_DATA
    return rows


WINDOW = ElasticLaw(by_height=True, group=4, paired=True, block=25)  # of features
ROWS = ElasticLaw(friction=(0.02, 0.3, 0.1), block=100, huber=1.5)   # of the check


GRADIENTS = [
    (WINDOW, SHAPE, 0.12), (WINDOW, SHAPE, -0.12),
    (WINDOW._replace(passive=True), [*SHAPE, HEIGHT], 0.12),
    (ROWS._replace(side=-1.0), [*SHAPE, SCALE, DELAY, INERTIA], 0.12),
    (ROWS._replace(passive=True, side=1.0), [*SHAPE, SCALE, DELAY, INERTIA], 0.12),
    (ROWS._replace(passive=True, side=1.0), [
        p for p in SHAPE if p != WIDTH] + [SCALE, DELAY], 0.0)]


def expect_gradient(law, free, width):
    rows = data()
    fit = Regression.of(rows, law, np.linspace(0.5, 1.5, len(rows) // law.group))
    fit.units[:] = 1.0 / 0.3
    mask = np.isin(np.arange(N_SHAPE), free)
    theta = np.array([6.0, 0.35, width, 0.02, 0.01, 0.1, 0.02, 0.4, 0.003, 0.002, 0.01])
    theta[(theta != 0.0) & ~mask & (np.arange(N_SHAPE) >= SCALE)] = 0.0
    _, optimum = fit.evaluate(theta, mask)
    right = optimum.rights.sum(axis=0)
    for i in free:
        step = 1e-7 * np.eye(N_SHAPE)[i]
        slope = (fit.evaluate(theta + step, mask)[0] - fit.evaluate(theta - step, mask)[0]) / 2e-7
        assert -0.5 * slope == pytest.approx(right[i], rel=2e-3, abs=2e-2), i
    assert not right[~mask].any()


def test_the_right_side_is_minus_half_the_gradient_of_the_cost():
    for law, free, width in GRADIENTS:
        expect_gradient(law, free, width)


def test_another_prior_is_the_fit_that_it_gives():
    """Of a linear problem: gap and zero held."""
    rows, free = data(), np.isin(np.arange(N_SHAPE), [STIFFNESS, VISCOUS, COULOMB, GAIN])
    law = ROWS._replace(passive=True, side=1.0, huber=math.inf)
    theta = np.zeros(N_SHAPE)
    theta[HALF_GAP] = 0.4
    held = np.where(np.arange(N_SHAPE) == GAIN, 1e9, 1e-3)
    found = []
    for prior in (np.full(N_SHAPE, 1e-3), held):
        fit = Regression.of(rows, law, np.ones(len(rows)))
        fit.prior[:] = prior
        found.append(fit.solve(theta, free, Damping(0.0), 0.0, 3)[1])
    again = found[0].with_prior(held)
    np.testing.assert_allclose(again.theta, found[1].theta, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(again.covariance(held=True), found[1].covariance(held=True),
                               rtol=1e-4, atol=1e-9)
    assert again.theta[STIFFNESS] == pytest.approx(7.0, rel=0.05)
    assert abs(again.theta[GAIN]) < 1e-6 < abs(found[0].theta[GAIN])


MINIMA = [
    (ElasticLaw(by_height=True, group=4, block=25), [STIFFNESS, HALF_GAP, ZERO, VISCOUS, GAIN]),
    (ROWS._replace(huber=math.inf, side=1.0), [
        STIFFNESS, HALF_GAP, ZERO, COULOMB, SCALE, DELAY])]


def expect_minimum(law, free):
    rows = data()
    fit = Regression.of(rows, law, np.ones(len(rows) // law.group))
    mask, theta = np.isin(np.arange(N_SHAPE), free), np.zeros(N_SHAPE)
    theta[[STIFFNESS, HALF_GAP]] = 6.0, 0.35

    def residuals(part):
        whole = np.zeros(N_SHAPE)
        whole[mask] = part
        fit.evaluate(whole, mask)
        return fit.residuals.copy()
    expected = least_squares(residuals, theta[mask], x_scale='jac', xtol=1e-12, ftol=1e-12)
    cost, optimum = fit.solve(theta, mask, Damping(1e-3), 1e-12, 50)
    assert cost == pytest.approx(2.0 * expected.cost, rel=1e-6)
    np.testing.assert_allclose(optimum.theta[mask], expected.x, rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(fit.residuals, residuals(expected.x), atol=1e-3)


def test_the_minimum_is_that_of_scipy():
    for law, free in MINIMA:
        expect_minimum(law, free)


def test_no_step_leaves_the_bounds():
    """The drive has a gap of 0.4: the best one allowed is at the bound, or just within."""
    for strict in (False, True):
        rows = data()
        law = ROWS._replace(huber=math.inf, side=1.0)
        fit = Regression.of(rows, law, np.ones(len(rows)), strict)
        mask, theta = np.isin(np.arange(N_SHAPE), [STIFFNESS, HALF_GAP]), np.zeros(N_SHAPE)
        theta[[STIFFNESS, HALF_GAP]] = 6.0, 0.2
        fit.high[HALF_GAP] = 0.3
        before = fit.evaluate(theta, mask)[0]
        cost, optimum = fit.solve(theta, mask, Damping(1e-3), 1e-9, 50)
        assert cost < before and optimum.theta[HALF_GAP] <= 0.3
        assert strict or optimum.theta[HALF_GAP] == 0.3
