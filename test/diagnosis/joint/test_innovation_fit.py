# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The fit of a candidate against steps and optima of Gaussian readings that are known exactly."""
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
import scipy

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel, Coordinate
from gearbox_monitor.diagnosis.joint.innovations import (
    annealed, coordinate_columns, ENOUGH, evaluated, FACTORS, fitted, InnovationFit, LOG_REACH,
    REACH, RULE)
from gearbox_monitor.plant.drive import DriveModel

COUNT, READ = 30, np.arange(30) % 5 != 2
RANDOM = np.random.default_rng(4)
X = RANDOM.standard_normal((COUNT, 2, 2)) * [[1.0, 0.3]] + [[[0.2, 0.5], [0.0, -0.4]]]
W = RANDOM.standard_normal((COUNT, 2, 2)) * [[0.1, 0.3], [0.2, 0.1]]
NOISE = RANDOM.standard_normal((COUNT, 2))
SIZE = np.array([0.5, 2.0])  # of the readings' noise, over the torque noise of a side


class Plain(CandidateModel):
    """A candidate whose model are its coordinates."""

    def model(self, z):
        return z


def candidate_of(*coordinates):
    """Return a Plain of (start, scale, and what else a Coordinate has)."""
    return Plain(DriveModel(), (), tuple(
        Coordinate(-1, f'z{i}', start, scale, **more)
        for i, (start, scale, more) in enumerate(coordinates)))


@dataclass
class Gaussian:
    """
    Readings `y` with the mean X z + bend z^2 + W log(torque) and deviation SIZE torque.

    Of some nothing is read. Moved coordinates `lost` give no number.
    """

    y: np.ndarray
    x: np.ndarray = field(default_factory=lambda: X)
    w: np.ndarray = field(default_factory=lambda: W)
    bend: float = 0.0
    lost: int | None = None
    least_noise: np.ndarray = field(default_factory=lambda: np.full(2, 1e-6))
    most_noise: float = 1e3
    first_noise: np.ndarray = field(default_factory=lambda: np.array([0.4, 1.1]))
    count: int = 0

    def _innovation(self, z, torque):
        return np.where(READ[:, None], self.y - self.x @ z - self.bend * np.sum(z ** 2)
                        - self.w @ np.log(torque), 0.0)

    def _variance(self, torque):
        return np.where(READ[:, None], (SIZE * torque) ** 2, 1.0)

    def run(self, z, torque):
        self.count += 1
        innovation, variance = self._innovation(z, torque), self._variance(torque)
        return SimpleNamespace(
            z=z, innovation=innovation, variance=variance, residual=innovation / variance ** 0.5,
            read=np.repeat(READ[:, None], 2, axis=1), torque=torque,
            deviance=float((innovation ** 2 / variance + np.log(variance) - 1.0)[READ].sum()))

    def change(self, run, z):
        lost = self.lost is not None and z[self.lost] != run.z[self.lost]
        return (self._innovation(z, run.torque) - run.innovation) * (np.nan if lost else 1.0)

    def with_noise(self, run, torque):
        other = self.run(run.z, torque)
        return other.deviance, other.innovation, other.variance


def readings(z, torque, noise=1.0):
    """Return what Gaussian has of the truth `z` under `torque`, with this share of its noise."""
    return X @ z + W @ np.log(torque) + noise * SIZE * torque * NOISE


def fisher_step(likelihood, candidate, z, torque, free):
    """Return the damped Fisher step [P + 2] on `free` ones, the gradient by differences."""
    def half(point):
        return 0.5 * (likelihood.run(point[:-2], np.exp(point[-2:])).deviance
                      + candidate.penalty(point[:-2]))
    at = np.concatenate([z, np.log(torque)])
    gradient = np.array([(half(at + h) - half(at - h)) / 2e-4 for h in 1e-4 * np.eye(len(at))])
    slopes = np.concatenate([likelihood.x, likelihood.w], axis=2)[READ]
    scaled = (slopes / (SIZE * torque)[:, None]).reshape(-1, len(at))
    information = scaled.T @ scaled
    information[range(-2, 0), range(-2, 0)] += 2.0 * READ.sum()
    information[range(len(z)), range(len(z))] += [
        c.prior ** -2 if c.prior else 0.0 for c in candidate.coordinates]
    information[np.diag_indices(len(at))] *= 1.0 + RULE.start
    out = np.zeros(len(at))
    out[free] = -np.linalg.solve(information[np.ix_(free, free)], gradient[free])
    return out


TRUE, TORQUE = np.array([0.5, -1.0]), np.array([0.3, 0.7])


def likeliest(likelihood, z):
    """Return the torque noise [2] that is likeliest at `z`."""
    return np.exp(scipy.optimize.minimize(
        lambda log: likelihood.run(z, np.exp(log)).deviance, np.log(TORQUE), tol=1e-9).x)


STEPS = [
    ([1.15, 0.9], [0.1, 0.1], [0, 1, 2, 3]), ([0.9, 1.15], [0.1, 0.1], [0, 1, 2, 3]),
    ([0.9, 1.1], [0.1, 1.1], [0, 1, 2]), ([0.9, 1.1], [0.1, 0.7], [0, 1, 2, 3]),
    ([0.9, 0.95], [0.9, 0.8], [0, 1, 2, 3]), ([1.07, 0.9], [1.07, 0.9], [0, 1, 3])]


def expect_step(factor, least, free):
    likelihood = Gaussian(readings(TRUE, TORQUE))
    candidate = candidate_of((0.3, 0.2, {'prior': 0.5}), (-0.8, 0.1, {}))
    z = np.array([0.45, -0.95])
    best = likeliest(likelihood, z)
    torque, likelihood.least_noise = factor * best, least * best
    at = evaluated(likelihood, InnovationFit(candidate, z, torque))
    assert annealed(likelihood, at).tolist() == torque.tolist()  # it has nothing to do
    step = fisher_step(likelihood, candidate, z, torque, free)
    fit = fitted(likelihood, InnovationFit(candidate, z, torque), iterations=1)
    assert fit.deviance < at.deviance
    assert fit.z == pytest.approx(z + step[:2], abs=1e-6)
    assert fit.torque == pytest.approx(
        np.maximum(torque * np.exp(step[2:]), likelihood.least_noise), rel=1e-6)
    known = fitted(likelihood, InnovationFit(candidate, z, torque), 1, free_noise=False)
    step = fisher_step(likelihood, candidate, z, torque, [0, 1])
    assert known.z == pytest.approx(z + step[:2], abs=1e-6)
    assert known.torque.tolist() == torque.tolist()


def test_a_step_is_that_of_fisher_on_coordinates_and_noise():
    """In units of the likeliest noise; at its least it stays where less would be likelier."""
    for factor, least, free in STEPS:
        expect_step(factor, least, free)


def test_a_fit_ends_at_the_optimum_that_a_general_minimiser_finds():
    likelihood = Gaussian(readings(TRUE, TORQUE), bend=0.2)
    candidate = candidate_of((0.3, 0.2, {'prior': 0.5}), (-0.8, 0.1, {}))

    def cost(point):
        return evaluated(likelihood, InnovationFit(
            candidate, point[:2], np.exp(point[2:]))).deviance
    best = scipy.optimize.minimize(cost, [0.3, -0.8, -1.0, 0.0], tol=1e-10)
    fit = fitted(likelihood, InnovationFit(candidate, candidate.start(), np.array([30.0, 1e-3])),
                 40, 1e-6)
    assert fit.deviance == pytest.approx(best.fun, abs=2.0 * ENOUGH)
    assert [*fit.z, *np.log(fit.torque)] == pytest.approx(best.x, abs=1e-2)
    run = likelihood.run(fit.z, fit.torque)
    assert fit.deviance == run.deviance + ((fit.z[0] - 0.3) / 0.5) ** 2


def test_steps_reach_as_far_as_scale_value_or_logarithm_allow():
    x = np.zeros((COUNT, 2, 3))
    x[::3, 0, 0], x[1::3, 1, 1], x[2::3, 0, 2] = 1.0, 1.0, 1.0
    likelihood = Gaussian(np.where(x.any(axis=2), 100.0, 0.0) - 200.0 * x[:, :, 1], x)
    candidate = candidate_of((0.01, 0.1, {}), (2.0, 0.1, {}), (1.0, 0.1, {'log': True}))
    fit = fitted(likelihood, InnovationFit(candidate, candidate.start(), np.ones(2)), 1,
                 free_noise=False)
    assert fit.z == pytest.approx([0.01 + REACH * 0.1, 2.0 - REACH * 2.0, LOG_REACH])


def test_a_step_is_taken_for_what_is_worth_it():
    for share, taken in ((0.5, False), (2.0, True)):
        likelihood = Gaussian(readings(TRUE, TORQUE))
        candidate = candidate_of((0.5, 0.2, {}), (-1.0, 0.1, {}))
        fit = fitted(likelihood, InnovationFit(candidate, TRUE, TORQUE), 30, 0.0, free_noise=False)
        curvature = float((X[READ, :, 0] ** 2 / (SIZE * TORQUE) ** 2).sum())
        z = fit.z + [(share * ENOUGH / curvature) ** 0.5, 0.0]
        begun = InnovationFit(candidate, z, TORQUE)
        again = fitted(likelihood, begun, 30, 0.0, free_noise=False)
        assert (again.z.tolist() != z.tolist()) == taken


def test_iterations_end_with_little_gain_or_when_they_are_used_up():
    candidate = candidate_of((0.5, 0.2, {}), (-1.0, 0.1, {}))

    def runs(iterations, tolerance):
        likelihood = Gaussian(readings(TRUE, TORQUE), bend=2.0)
        fitted(likelihood, InnovationFit(candidate, np.array([1.5, -0.6]), TORQUE), iterations,
               tolerance, free_noise=False)
        return likelihood.count
    assert runs(1, 0.0) == runs(20, 1e9) < runs(2, 0.0) < runs(3, 0.0)
    assert runs(20, 0.5) == runs(30, 0.5) < runs(20, 0.0)


@dataclass
class Valley:
    """-2 log L over the logarithms of the torque noise [2]."""

    cost: object
    least_noise: np.ndarray = field(default_factory=lambda: np.full(2, 1e-9))
    most_noise: float = 1e9

    def with_noise(self, run, torque):
        return float(self.cost(*np.log(torque))), None, None

    def annealed(self, *torque):
        """Return the logarithms of the noise [2] to which annealing from `torque` leads."""
        deviance = self.with_noise(None, torque)[0]
        return np.log(annealed(self, SimpleNamespace(
            torque=np.array(torque), run=SimpleNamespace(deviance=deviance))))


def test_noise_anneals_to_the_likeliest_of_both_sides_and_of_each():
    """Along a valley, where neither side alone gains, and across; within what is allowed."""
    finest = 0.5 * np.log(FACTORS[0])
    for begin in ([1e-5, 1e-5], [1e4, 1e4], [1.0, 1.0]):
        together = Valley(lambda a, b: (a + b - 1.0) ** 2 + 1e4 * (a - b) ** 2)
        assert together.annealed(*begin) == pytest.approx([0.5, 0.5], abs=1.01 * finest)
    for begin in ([1e-5, 1e4], [1e4, 1e-5], [1.0, 1.0]):
        apart = Valley(lambda a, b: 3.0 * (a - 2.0) ** 2 + (b + 3.0) ** 2)
        assert apart.annealed(*begin) == pytest.approx([2.0, -3.0], abs=1.01 * finest)
    bounded = Valley(lambda a, b: a - 2.0 * b, np.array([1e-2, 1e-3]), 50.0)
    assert np.exp(bounded.annealed(1.0, 1.0)) == pytest.approx([1e-2, 50.0])
    bounded = Valley(lambda a, b: b - 2.0 * a, np.array([1e-2, 1e-3]), 50.0)
    assert np.exp(bounded.annealed(1.0, 1.0)) == pytest.approx([50.0, 1e-3])


def test_noise_moves_by_the_least_factor_for_a_gain_that_counts():
    """A factor beyond it would be too far."""
    for at in (-1.0, 1.0):
        for side in (0, 1):
            step = at * np.log(FACTORS[0])
            for depth, moved in ((0.1, step), (0.03, step), (0.015, 0.0)):
                valley = Valley(lambda *log: depth * min((log[side] / step - 1.0) ** 2, 1.0)
                                + 9.0 * log[1 - side] ** 2)
                expected = np.zeros(2)
                expected[side] = moved
                assert valley.annealed(1.0, 1.0) == pytest.approx(expected)


def test_columns_are_derivatives_by_coordinates_also_at_bounds():
    likelihood = Gaussian(readings(TRUE, TORQUE), bend=5.0)
    candidate = candidate_of((0.5, 0.2, {'high': 0.5}), (-1.0, 0.1, {}))
    fit = evaluated(likelihood, InnovationFit(candidate, TRUE, TORQUE))
    scale = READ[:, None] / (SIZE * TORQUE)
    steps = 0.1 * candidate.steps()

    def columns(shift):
        return np.stack([-(X[:, :, i] + 5.0 * (2.0 * TRUE[i] + shift[i])) * scale
                         for i in (0, 1)], axis=2).reshape(-1, 2)
    np.testing.assert_allclose(coordinate_columns(likelihood, fit), columns([-steps[0], steps[1]]),
                               atol=1e-8)
    np.testing.assert_allclose(coordinate_columns(likelihood, fit, central=True),
                               columns([0.0, 0.0]), atol=1e-8)
    likelihood.lost = 1
    lost = coordinate_columns(likelihood, fit)
    assert (lost[:, 1] == 0.0).all() and (lost[:, 0] != 0.0).any()


def test_a_fit_leaves_its_run_behind():
    fit = evaluated(Gaussian(readings(TRUE, TORQUE)), InnovationFit(candidate_of(
        (0.3, 0.2, {'prior': 0.5}), (-0.8, 0.1, {})), TRUE, TORQUE))
    assert fit.deviance == pytest.approx(fit.run.deviance + 0.4 ** 2)
    alone = fit.alone()
    assert type(alone) is InnovationFit and alone.deviance == fit.deviance
    assert alone.z is fit.z and alone.torque is fit.torque and alone.name == fit.name == ''
