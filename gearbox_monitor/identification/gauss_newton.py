# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fit a candidate by multiple shooting: Gauss-Newton with the window states eliminated.

Each window has four states of its own (Bock's multiple shooting without continuity constraints);
they are eliminated from the normal equations by a Schur complement, as in variable projection
(Golub and Pereyra 1973). Steps are damped as by Levenberg and Marquardt.
"""
from collections.abc import Container
from dataclasses import replace
from functools import partial

import numpy as np

from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.likelihood import (
    FitPoint, normal_equations, objective, sensitivity, squares, updated, uses_memory, weights,
    WindowData)
from gearbox_monitor.identification.window_states import hand_over
from gearbox_monitor.kernels.levenberg_marquardt import damped_step, Damping
from gearbox_monitor.kernels.types import Array

RULE = Damping(1e-6, 100.0, 1e-3, smallest=1e-9, attempts=4)


def fit(data: WindowData, candidate: CandidateModel, point: FitPoint, iterations: int = 4,
        robust: bool = False, refresh: Container[int] = (0, 1, 3),
        tolerance: float = 0.05) -> FitPoint:
    """
    Return `point` improved (z, states, memory) by damped Gauss-Newton.

    Window states are eliminated by a Schur complement (`likelihood.normal_equations`); steps are
    damped as by Levenberg and Marquardt.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model to be fitted, with its coordinates.
        point: where the fit stands: coordinates, window states and memories.
        iterations: largest number of iterations.
        robust: whether windows that stand out weigh less.
        refresh: iterations at which the sensitivities are computed.
        tolerance: gain in chi2 below which the fit stops.
    """
    if point.residual is None:
        point = data.evaluate(candidate, point)
    damping, s = RULE.start, None
    for k in range(iterations):
        weight = weights(data, point.chi2, robust)
        objective_before = objective(candidate, point, weight)
        if s is None or k in refresh:
            s = sensitivity(data, candidate, point)
        S, g, X, x = normal_equations(s, point.residual, weight)
        pull, prior = candidate.prior(point.z)
        step = damped_step(
            S + np.diag(prior), g - pull, partial(_moved, data, candidate, point, (X, x)),
            partial(_gain, candidate, weight, objective_before), damping, RULE)
        if step is None:
            if k in refresh:
                break
            s, damping = None, RULE.start
            continue
        trial, damping = step
        gain = _gain(candidate, weight, objective_before, trial)
        point = hand_over(data, candidate, trial) if uses_memory(candidate) else trial
        if gain < tolerance:
            break
    return point


def robust_then_plain(data: WindowData, candidate: CandidateModel, point: FitPoint,
                      iterations: tuple[int, int] = (4, 6)) -> FitPoint:
    """
    Return `point` improved where windows that stand out weigh less, then by all alike.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model to be fitted, with its coordinates.
        point: where the fit stands: coordinates, window states and memories.
        iterations: largest numbers of iterations.
    """
    point = fit(data, candidate, point, iterations[0], robust=True)
    return fit(data, candidate, point, iterations[1])


def _moved(data: WindowData, candidate: CandidateModel, point: FitPoint,
           reduced: tuple[Array, Array], dz: Array) -> FitPoint:
    """Return `point` after the step `dz` [P], its states by X and x of normal_equations."""
    z, (X, x) = candidate.bounded(point.z + dz), reduced
    return _keep_states(data, candidate, point, data.evaluate(candidate, FitPoint(
        z, point.states + x - np.einsum('wij,j->wi', X, z - point.z), point.memory)))


def _gain(candidate: CandidateModel, weight: Array, at_start: float, trial: FitPoint) -> float:
    return at_start - objective(candidate, trial, weight)


def _keep_states(data: WindowData, candidate: CandidateModel, point: FitPoint,
                 trial: FitPoint) -> FitPoint:
    """Return `trial`, windows that became worse with their states of `point` where that helps."""
    degraded = np.flatnonzero(trial.chi2 > point.chi2)
    if not len(degraded) or data.begins_known:
        return trial
    residual, carry = data.residual(candidate.model(trial.z), point.states[degraded],
                                    point.memory[degraded], degraded)
    chi2 = squares(residual)
    use = chi2 < trial.chi2[degraded]
    index = degraded[use]
    return replace(trial, states=updated(trial.states, index, point.states[index]),
                   residual=updated(trial.residual, index, residual[use]),
                   chi2=updated(trial.chi2, index, chi2[use]),
                   carry=updated(trial.carry, index, carry[use]))
