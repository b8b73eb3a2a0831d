# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Window states and standard errors where the measured motion of the motor drives the model."""
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood, window_states
from gearbox_monitor.identification.candidates import CandidateModel, ZERO
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.process_noise import noise_weighted_residual
from gearbox_monitor.identification.search import Search


def published(search: Search, none: CandidateFit,
              fitted: CandidateFit | None = None) -> likelihood.FitPoint:
    """
    Return the FitPoint of the model as published: only window states fitted.

    Args:
        search: fits of all candidates to one recording.
        none: fit without effects.
        fitted: fit on the long windows.
    """
    if not none.candidate.coordinates:
        return none.point
    candidate = CandidateModel(search.model, (), ())
    point = none.point.at(np.zeros(0))
    if search.recording.motor is not None:
        # No state of a window holds the zero of the encoders, which nobody knows.
        candidate = replace(candidate, coordinates=tuple(
            c for c in none.candidate.coordinates if c.name == ZERO))
        point = gauss_newton.fit(search.long, candidate, point.at(candidate.start()), 6)
    rivals = [none.point] + ([fitted.point] if fitted else [])
    return window_states.rescue(
        search.long, candidate, window_states.solved(search.long, candidate, point), rivals,
        half_gap=search.half_gap)


def settled(search: Search, fitted: CandidateFit,
            rivals: Sequence[likelihood.FitPoint]) -> CandidateFit:
    """
    Return `fitted` with the states of the held-out windows where they fit best.

    The search looks at the training windows: others may have been left in a wrong contact.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        rivals: points of other fits whose window states are tried.
    """
    data, candidate = search.long, fitted.candidate
    validation = np.flatnonzero(~data.train)
    if not len(validation):
        return fitted
    model, point = candidate.model(fitted.point.z), fitted.point
    rival_points = [*rivals, *(search.fitted[n].point for n in search.ranked()[:4])]
    points = [point, *rival_points]
    index = np.tile(validation, len(points))
    states, chi2 = window_states.solve_states(
        data, model, np.concatenate([k.states[validation] for k in points]), point.memory[index],
        index)
    chi2 = chi2.reshape(len(points), -1)
    winner = chi2.argmin(axis=0)
    improved = chi2.min(axis=0) < point.chi2[validation]
    chosen = states.reshape(len(points), -1, 4)[winner, np.arange(len(validation))]
    point = data.evaluate(candidate, replace(point, states=likelihood.updated(
        point.states, validation[improved], chosen[improved])))
    point = window_states.rescue(data, candidate, point, [point, *rival_points],
                                 half_gap=search.half_gap)
    states = likelihood.updated(point.states, data.train, fitted.point.states[data.train])
    return replace(fitted, point=data.evaluate(candidate, replace(point, states=states)))


def standard_errors(search: Search,
                    fitted: CandidateFit) -> tuple[dict[str, dict[str, float]], float | None]:
    """
    Return ({id: {parameter: standard error}}, condition of the scaled normal matrix).

    Linearised, window states and nominal values free; scaled by the misfit where it is above 1.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    candidate, point, data = fitted.candidate, fitted.point, search.long
    if not len(point.z):
        return {}, None
    s = likelihood.sensitivity(data, candidate, point)
    residual, whiten = noise_weighted_residual(data, fitted)
    S, _, _, _ = likelihood.normal_equations(
        s, point.residual, data.train.astype(float), whiten)
    S = S + np.diag(candidate.prior(point.z)[1])
    scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-300))
    scaled = S * scale[:, None] * scale
    condition = float(np.linalg.cond(scaled))
    misfit = max(1.0, float((residual[data.train] ** 2).mean()))
    covariance = misfit * scale[:, None] * scale * np.linalg.pinv(scaled, rcond=1e-13)
    jacobian = candidate.wave_jacobian(point.z)
    errors = np.sqrt(np.maximum(np.diag(jacobian @ covariance @ jacobian.T), 0.0))
    return candidate.named_errors(point.z, errors), condition
