# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The damping of steps: what counts as help, and what is tried where nothing helps."""

import numpy as np
import pytest

from gearbox_monitor.kernels.linear_least_squares import Damping, minimise
from gearbox_monitor.simulators.user_simulator import fitted_start


class Lines:
    """Two straight lines through 0, of which the second is read in steps of 1."""

    def __init__(self):
        self.passes = np.zeros(2, int)

    def evaluated(self, theta, index):
        self.passes[index] += 1
        residual = np.where(index[:, None] == 1, np.round(theta), theta)
        return residual, (residual ** 2).sum(axis=1)

    def linearised(self, theta, residual, index):
        return np.ones((len(theta), 1, 1)), -0.3 * np.sign(residual)


def test_a_step_of_equal_cost_helps_where_the_rule_says_so():
    for level, passes in ((True, 1), (False, 4)):
        problems = Lines()
        rule = Damping(0.0, 10.0, 0.1, attempts=4, relative=1e-12, level=level)
        theta, _, cost = minimise(problems, np.array([[0.0], [2.2]]), rule, 1e-3, 20)
        assert problems.passes.tolist() == [1 + passes, 1 + passes]
        assert theta[0, 0] == 0.0 and cost.tolist() == [0.0, 4.0]
        assert theta[1, 0] == pytest.approx(1.9 if level else 2.2)


def test_a_start_beside_which_runs_fail_is_tried_nearer_and_nearer():
    tried = []

    def residual_of(start):
        tried.append(float(start[0]))
        return np.array([1.0 - start[0] if abs(start[0]) < 0.01 else 2.0])
    fit = fitted_start(residual_of, np.zeros(1), np.array([1e-4]))
    assert max(tried) > 0.9  # the minimum of the line, where runs fail
    assert 0.005 < fit.x[0] < 0.01 and fit.fun.tolist() == [1.0 - fit.x[0]]


def test_a_start_of_straight_lines_is_fitted_exactly():
    lines, start = np.array([[1.0, 2.0], [3.0, -1.0], [0.5, 4.0]]), np.array([0.3, -0.2])
    fit = fitted_start(lambda s: lines @ (s - start), np.zeros(2), np.array([1e-4, 1e-3]))
    np.testing.assert_allclose(fit.x, start, atol=1e-9)
    np.testing.assert_allclose(fit.jac, lines, atol=1e-9)
