# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Multiscale Gauss-Newton, for objectives that are not smooth.

A contact that is made a little earlier or later changes a run for a while, so that the objective
is jagged on small scales. Finite differences of several lengths take turns, and each direction is
followed as far as it leads down (line search).
"""
import numpy as np

from gearbox_monitor.identification import likelihood, window_states
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.kernels.types import Array

STRETCHES = (1.0, 5.0, 0.2)  # of the steps of finite differences, in turns
SHARES = (1.0, 0.3, 0.1)     # of a Gauss-Newton step, until one leads down
FARTHER = 2.0                # times the step before, as long as it does
DAMPING = 1e-6


def fit(data: likelihood.WindowData, candidate: CandidateModel, point: likelihood.FitPoint,
        iterations: int, robust: bool, tolerance: float) -> likelihood.FitPoint:
    """
    Return `point` improved (z, memory); see gauss_newton.fit.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model to be fitted, with its coordinates.
        point: where the fit stands: coordinates, window states and memories.
        iterations: largest number of iterations.
        robust: whether windows that stand out weigh less.
        tolerance: gain in chi2 below which the fit stops.
    """
    if not candidate.coordinates:
        return point
    turn = failed = 0
    for _ in range(iterations):
        weight = likelihood.weights(data, point.chi2, robust)
        objective_before = likelihood.objective(candidate, point, weight)
        trial = point
        while trial is point and failed < len(STRETCHES):
            trial = _down(data, candidate, point, weight, STRETCHES[turn % len(STRETCHES)])
            turn += 1
            failed = failed + 1 if trial is point else 0
        if trial is point:
            break
        gain = objective_before - likelihood.objective(candidate, trial, weight)
        point = trial
        if likelihood.uses_memory(candidate):
            point = window_states.hand_over(data, candidate, point)
        failed = failed + 1 if gain < tolerance else 0
    return point


def _down(data: likelihood.WindowData, candidate: CandidateModel, point: likelihood.FitPoint,
          weight: Array, stretch: float) -> likelihood.FitPoint:
    """Return the best point along one Gauss-Newton direction; `point` if none is better."""
    def at(share: float) -> tuple[likelihood.FitPoint, float]:
        """Return the point and its objective after `share` of the step."""
        z = candidate.bounded(point.z + share * step)
        trial = data.evaluate(candidate, likelihood.FitPoint(z, point.states, point.memory))
        return trial, likelihood.objective(candidate, trial, weight)

    J = likelihood.coordinate_sensitivity(data, candidate, point, stretch=stretch)
    pull, prior = candidate.prior(point.z)
    S = np.einsum('w,wli,wlj->ij', weight, J, J, optimize=True) + np.diag(prior)
    g = np.einsum('w,wli,wl->i', weight, J, point.residual, optimize=True) - pull
    step = likelihood.damped_solve(S, g, DAMPING)
    lowest, cost = point, likelihood.objective(candidate, point, weight)
    for share in SHARES:
        trial, trial_cost = at(share)
        if trial_cost < cost:
            break
    while trial_cost < cost:
        lowest, cost, share = trial, trial_cost, FARTHER * share
        trial, trial_cost = at(share)
    return lowest
