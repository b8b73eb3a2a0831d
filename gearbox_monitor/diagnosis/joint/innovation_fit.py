# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Maximum likelihood of a candidate by its innovations.

Levenberg-Marquardt on whitened innovations, coordinates and logarithms of the torque noise in one
Fisher step; the exact likelihood accepts it. The noise anneals by itself: it is large where the
model is wrong. One start is enough for most effects, that without it.
"""
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel
from gearbox_monitor.diagnosis.joint.innovations import JointLikelihood, Likelihood
from gearbox_monitor.kernels.linear_least_squares import (
    covariance, damped_solve, damped_step, Damping)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel

FAR = 2.0                    # change of the logarithm of the noise in a step
LOG_STEP = 0.05              # of finite differences in that logarithm
COORDINATE_STEP = 0.1        # of the steps of a candidate: a single sample is nearly linear
REACH = 3.0                  # a step is not longer than so many times value or scale
LOG_REACH = 1.5              # the same of coordinates that are logarithms
FACTORS = (1.5, 4.0, 16.0)   # by which the noise is tried, the next one after each gain
ENOUGH = 1e-3                # gain in -2 log L of a step that is taken
RULE = Damping(1e-4, 20.0, 1e-3, smallest=1e-9, attempts=5)
RIDGE = 1e-9                 # of the power of a column that is tested
UNHELPFUL = 1e-2             # damping after steps that did not help


@dataclass(frozen=True)
class InnovationFit:
    """
    State of the fit of a candidate.

    z [P] coordinates; torque [2] noise on motor and arm, N m; deviance: -2 log L with the prior,
    as the likelihood counts it, infinite before it is evaluated.
    """

    candidate: CandidateModel
    z: Array
    torque: Array
    deviance: float = math.inf

    @property
    def name(self) -> str:
        """Ids joined by '+'."""
        return self.candidate.name

    @property
    def model(self) -> DriveModel:
        """The model where the fit stands."""
        return self.candidate.model(self.z)


@dataclass(frozen=True)
class FilteredFit(InnovationFit):
    """An InnovationFit with the run of its filter, which needs much memory."""

    run: Any = field(kw_only=True)

    def alone(self) -> InnovationFit:
        """Return the InnovationFit without the run."""
        return InnovationFit(self.candidate, self.z, self.torque, self.deviance)


def unfitted(likelihood: Likelihood, candidate: CandidateModel,
             z: Array | None = None) -> InnovationFit:
    """
    Return where the fit of a candidate begins.

    Args:
        likelihood: of the recording.
        candidate: model with its coordinates.
        z: coordinates [P], None: the candidate's own start.
    """
    return InnovationFit(candidate, candidate.start() if z is None else z, likelihood.first_noise)


def evaluated(likelihood: Likelihood, fit: InnovationFit) -> FilteredFit:
    """
    Return a fit where it stands, with the run of its filter.

    Args:
        likelihood: of the recording.
        fit: of a candidate.
    """
    run = likelihood.run(fit.model, fit.torque)
    return FilteredFit(fit.candidate, fit.z, fit.torque,
                       run.deviance + fit.candidate.penalty(fit.z), run=run)


def annealed(likelihood: Likelihood, fit: FilteredFit) -> Array:
    """Return the torque noise [2] that is likeliest at `fit`, by tangents of `likelihood`."""
    torque, deviance = fit.torque, fit.run.deviance
    smallest, largest = likelihood.least_noise, likelihood.most_noise
    for sides in ([0, 1], [0], [1]):
        number, sign, failures = 0, -1.0, 0
        while failures < 2:
            trial = torque.copy()
            trial[sides] = np.clip(trial[sides] * FACTORS[number] ** sign, smallest[sides],
                                   largest)
            value = np.inf if (trial == torque).all() else likelihood.with_noise(
                fit.run, trial)[0]
            if value < deviance - 0.02:
                torque, deviance, failures = trial, value, 0
                number = min(number + 1, len(FACTORS) - 1)
            elif number:
                number -= 1
            else:
                sign, failures = -sign, failures + 1
    return torque


def coordinate_columns(likelihood: Likelihood, fit: FilteredFit, central: bool = False) -> Array:
    """
    Return the derivatives of whitened innovations [2 N, P] by the coordinates of a fit.

    Args:
        likelihood: of the recording.
        fit: where the model stands.
        central: whether differences are central; one-sided ones see what is not determined.
    """
    candidate, z = fit.candidate, fit.z
    steps = COORDINATE_STEP * candidate.steps()
    scale = 1.0 / np.sqrt(fit.run.variance)
    columns = np.empty((scale.size, len(z)))
    for i, step in enumerate(steps):
        moved = z.copy()
        moved[i] += step
        if candidate.bounded(moved)[i] != moved[i]:
            step = -step
            moved[i] = z[i] + step
        change = likelihood.change(fit.run, candidate.model(moved))
        if central:
            moved[i] = z[i] - step
            change = 0.5 * (change - likelihood.change(fit.run, candidate.model(moved)))
        columns[:, i] = (change * scale).ravel() / step
    columns[~np.isfinite(columns)] = 0.0
    return columns


def remaining(columns: Array, own: Array) -> Array:
    """Return columns [M, C] less what columns `own` [M, P] imitate."""
    return np.asarray(columns - own @ (covariance(own.T @ own) @ (own.T @ columns)))


@dataclass(frozen=True, eq=False)
class Tested:
    """
    A fit whose filter was run, beside which columns of its innovations are tested.

    own: derivatives [M, P] by its coordinates, which give way; residual [M]; both in standard
    deviations. Their last P rows are the prior of the coordinates.
    """

    likelihood: JointLikelihood
    at: FilteredFit
    own: Array
    residual: Array

    @classmethod
    def beside(cls, likelihood: JointLikelihood, fit: InnovationFit) -> 'Tested':
        """Return what may be tested beside `fit` on a `likelihood`."""
        at = evaluated(likelihood, fit)
        pull, weight = fit.candidate.prior(fit.z)
        root = np.sqrt(weight)
        return cls(likelihood, at,
                   np.concatenate([coordinate_columns(likelihood, at), np.diag(root)]),
                   np.append(at.run.residual, pull / np.where(root > 0.0, root, 1.0)))

    @cached_property
    def covariance(self) -> Array:
        """Covariance [P, P] of the coordinates."""
        return covariance(self.own.T @ self.own)

    def with_prior(self, columns: Array) -> Array:
        """Return columns [N, C] of innovations with rows [M, C] of the prior, which are 0."""
        return np.pad(columns, ((0, len(self.own) - len(columns)), (0, 0)))

    def without(self, columns: Array) -> Array:
        """Return columns [M, C] of innovations less what the coordinates of the fit imitate."""
        return self._split(columns)[0]

    def _split(self, columns: Array) -> tuple[Array, Array]:
        """Return (columns [M, C] less what the coordinates imitate, their change [P, C])."""
        columns = self.with_prior(columns)
        change = self.covariance @ (self.own.T @ columns)
        return columns - self.own @ change, -change

    def step(self, columns: Array) -> tuple[float, Array, Array]:
        """
        Return the test of one linear step along `columns` [N, C] of innovations.

        Returns:
            Gain in -2 log L, step [C], change [P, C] of the coordinates per unit of the step.
        """
        X, change = self._split(columns)
        S = X.T @ X
        S[np.diag_indices_from(S)] += RIDGE * (columns ** 2).sum(axis=0) + 1e-300
        h = X.T @ self.residual
        step = np.linalg.solve(S, h)
        return float(h @ step), -step, change


def _noise_columns(likelihood: Likelihood, fit: FilteredFit) -> tuple[Array, Array]:
    """Return derivatives of whitened innovations and of log variances [2 N, 2] by log noise."""
    run = fit.run
    scale = 1.0 / np.sqrt(run.variance)
    means, spreads = np.empty((2, scale.size, 2))
    for i in range(2):
        torque = fit.torque.copy()
        torque[i] *= np.exp(LOG_STEP)
        _, innovation, variance = likelihood.with_noise(run, torque)
        means[:, i] = ((innovation - run.innovation) * scale).ravel() / LOG_STEP
        spreads[:, i] = np.log(variance / run.variance).ravel() / LOG_STEP
    return means, spreads


def fitted(likelihood: Likelihood, fit: InnovationFit, iterations: int = 12,
           tolerance: float = 0.5, free_noise: bool = True) -> InnovationFit:
    """
    Return the fit of maximum likelihood that `fit` leads to.

    Args:
        likelihood: of the recording.
        fit: start of the iterations.
        iterations: at most so many.
        tolerance: gain in -2 log L below which it stops.
        free_noise: whether the torque noise is fitted, too.
    """
    damping = RULE.start
    at = evaluated(likelihood, fit)
    for _ in range(iterations):
        torque = annealed(likelihood, at) if free_noise else at.torque
        deviance = at.deviance
        if (torque != at.torque).any():
            moved = evaluated(likelihood, replace(at.alone(), torque=torque))
            at = moved if moved.deviance < at.deviance else at
        at, damping = _step(likelihood, at, damping, free_noise)
        if deviance - at.deviance < tolerance:
            break
    return at.alone()


def _step(likelihood: Likelihood, fit: FilteredFit, damping: float,
          free_noise: bool) -> tuple[FilteredFit, float]:
    """Return `fit` after a Fisher step on coordinates and noise, and the damping of the next."""
    candidate, count = fit.candidate, len(fit.z)
    read = fit.run.read.ravel()
    residual = fit.run.residual.ravel()
    means, spreads = (_noise_columns(likelihood, fit) if free_noise
                      else np.zeros((2, len(residual), 2)))
    J = np.concatenate([coordinate_columns(likelihood, fit), means], axis=1)
    pull, weight = candidate.prior(fit.z)
    H = J.T @ J
    H[count:, count:] += 0.5 * spreads.T @ spreads
    H[range(count), range(count)] += weight
    g = J.T @ residual
    g[count:] += 0.5 * spreads.T @ (read - residual ** 2)
    g[:count] += pull
    smallest, largest = likelihood.least_noise, likelihood.most_noise
    moves = free_noise & ~((fit.torque <= smallest * 1.001) & (g[count:] > 0.0))
    free = np.array([*range(count), *(count + np.flatnonzero(moves))], int)
    if not len(free):
        return fit, damping
    log = np.array([c.log for c in candidate.coordinates], bool)
    scale = np.array([c.scale for c in candidate.coordinates])
    reach = np.where(log, LOG_REACH, REACH * np.maximum(np.abs(fit.z), scale))

    def trial_of(change: Array) -> FilteredFit:
        step = np.zeros(count + 2)
        step[free] = -change
        z = candidate.bounded(fit.z + np.clip(step[:count], -reach, reach))
        torque = np.clip(fit.torque * np.exp(np.clip(step[count:], -FAR, FAR)), smallest,
                         largest) if free_noise else fit.torque
        return evaluated(likelihood, InnovationFit(candidate, z, torque))

    def gain_of(trial: FilteredFit) -> float:
        return fit.deviance - ENOUGH - trial.deviance
    normal, right = H[np.ix_(free, free)], g[free]
    if right @ damped_solve(normal, right, RULE.smallest) < ENOUGH:  # the most a step promises
        return fit, damping
    return damped_step(normal, right, trial_of, gain_of, damping, RULE) or (fit, UNHELPFUL)
