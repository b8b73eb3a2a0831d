# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Windowed likelihood of a model with fixed parameters: chi2, evidence, misfit, closed fraction.

A recording is cut into windows of 1 s; in each the model runs freely from the initial state (four
numbers) that fits best, found by Levenberg-Marquardt.
Misfit: normalised output error, the root mean square of the error in units of the noise.
"""
from collections.abc import Sequence

import numpy as np

from benchmarks.blind.plant import Effects, MotionRecord, Nominal, WindowRuns
from gearbox_monitor.kernels.types import Array, Integers

LENGTH = 1000       # samples of a window
NO_MISFIT = 1.02    # below, there is nothing to close
SUBSTEPS = 5
STEPS = np.array([2e-5, 2e-5, 2e-4, 2e-4])  # rad, rad/s, of the sensitivities
RESCUE = 1.25       # over the median chi2: start the window again
BEGINNINGS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0)  # shares of a window: where impacts follow each
#                     other, states that fit all of it follow from those that fit its beginning
# Changes of a start: motor position, arm position, motor speed, arm speed.
RESTARTS = np.array([[0, 0, 0, -1.5], [0, 0, 0, 1.5], [0, 0, 0, -4.0], [0, 0, 0, 4.0],
                     [0, -0.04, 0, 0], [0, 0.04, 0, 0], [0, 0, -1.5, 0], [0, 0, 1.5, 0]], float)


def cut(n: int, length: int = LENGTH) -> Integers:
    """Return the first sample of each whole window of `length` in a recording of `n` samples."""
    return np.arange(n // length) * length


def first_states(y: Array, starts: Integers, dt: float, reach: int = 25) -> Array:
    """
    Read initial states off the encoders: local polynomials around each start.

    Args:
        y: encoder readings [N, 2], rad.
        starts: first sample of each window [W].
        dt: sample time, s.
        reach: samples on either side of a start.

    Returns:
        States [W, 4]: two positions (rad) and two speeds (rad/s).
    """
    states = np.empty((len(starts), 4))
    for w, start in enumerate(starts):
        a, b = max(start - reach, 0), min(start + reach, len(y) - 1) + 1
        t = (np.arange(a, b) - start) * dt
        for c in (0, 1):
            fit = np.polynomial.polynomial.polyfit(t, y[a:b, c], 2 if a < start else 1)
            states[w, c], states[w, 2 + c] = fit[0], fit[1]
    return states


def pieces(y: Array, starts: Integers, length: int = LENGTH) -> Array:
    """
    Return windows [W, length, 2] of a recorded signal.

    Args:
        y: signal [N, 2].
        starts: first sample of each window [W].
        length: samples of a window.
    """
    return np.stack([y[s:s + length] for s in starts])


def _chi2(y: Array, predictions: Array, sigma: Array) -> Array:
    with np.errstate(invalid='ignore', over='ignore'):
        chi2 = (((y - predictions) / sigma) ** 2).sum(axis=(1, 2))
    return np.where(np.isfinite(chi2), chi2, np.inf)


def _finite(array: Array) -> Array:
    """Return `array` with finite numbers whose squares can be summed: poor starts diverge."""
    return np.clip(np.nan_to_num(array), -1e100, 1e100)


def fit_states(runs: WindowRuns, y: Array, sigma: Array, states: Array, iterations: int = 6,
               chosen: Integers | None = None) -> tuple[Array, Array, Array]:
    """
    Fit the initial state of each window by Levenberg-Marquardt, each window on its own.

    Args:
        runs: the model's free runs.
        y: measured windows [W, L, 2], rad.
        sigma: encoder noise [2], rad.
        states: first guess [W, 4].
        iterations: at most so many.
        chosen: windows of `runs` that `states` belong to; None: all of them, and the memories
            (bristle, hysteresis) at the end of a window start the next one.

    Returns:
        States [W, 4], chi2 [W] and predictions [W, L, 2].
    """
    states, carry = np.array(states, float), chosen is None
    chosen = np.arange(len(states)) if chosen is None else np.asarray(chosen)
    predictions = runs.run(states, chosen, keep=carry)
    if carry and runs.memory.any():
        predictions = runs.run(states, chosen, keep=True)
    chi2, damping = _chi2(y, predictions, sigma), np.full(len(states), 1e-3)
    for iteration in range(iterations):
        jacobian = np.empty((len(states), y.shape[1] * 2, 4))
        for i, step in enumerate(STEPS):
            moved = states.copy()
            moved[:, i] += step
            with np.errstate(invalid='ignore'):  # poor starts diverge
                change = runs.run(moved, chosen) - predictions
            jacobian[:, :, i] = (change / step / sigma).reshape(len(states), -1)
        residual = _finite(((y - predictions) / sigma).reshape(len(states), -1))
        jacobian = _finite(jacobian)
        normal = np.einsum('wni,wnj->wij', jacobian, jacobian)
        pull = np.einsum('wni,wn->wi', jacobian, residual)
        scale = np.sqrt(np.einsum('wii->wi', normal)) + 1e-12
        normal = normal / scale[:, :, None] / scale[:, None, :]
        previous_chi2 = chi2.copy()
        for _ in range(3):
            damped = normal + damping[:, None, None] * np.eye(4)
            step = np.linalg.solve(damped, (pull / scale)[:, :, None])[:, :, 0] / scale
            trial = states + step
            tried = runs.run(trial, chosen)
            new = _chi2(y, tried, sigma)
            improved = new < chi2
            states[improved], predictions[improved], chi2[improved] = (
                trial[improved], tried[improved], new[improved])
            damping = np.where(improved, damping * 0.1, damping * 30.0)
            if improved.all() or (chi2 > previous_chi2 - 0.1).all():
                break
        if carry and runs.memory.any():
            predictions = runs.run(states, chosen, keep=True)
            chi2 = _chi2(y, predictions, sigma)
        if np.all(chi2 > previous_chi2 - 0.05):
            break
    return states, chi2, predictions


def fit_windows(nominal: Nominal, effects: Effects, recording: MotionRecord, sigma: Array,
                starts: Integers | None = None, states: Array | None = None, iterations: int = 6,
                alternatives: Sequence[Array] | None = ()) -> tuple[Array, Array, Array]:
    """
    Fit the states of all windows; windows that do not fit are started again elsewhere.

    Args:
        nominal: values of the drive, see plant.NOMINAL.
        effects: its effects.
        recording: u [N], y [N, 2], dt.
        sigma: encoder noise [2], rad.
        starts: first sample of each window [W]; None: whole windows side by side.
        states: first guess [W, 4]; None: read off the encoders.
        iterations: of each fit, at most.
        alternatives: further first guesses [W, 4] for windows that do not fit; None: such windows
            are not started again.

    Returns:
        chi2 [W], states [W, 4] and predictions [W, L, 2].
    """
    u, y, dt = recording['u'], recording['y'], recording['dt']
    starts = cut(len(u)) if starts is None else starts
    runs = WindowRuns(nominal, effects, recording, starts, LENGTH, SUBSTEPS)
    measured = pieces(y, starts)
    guess = first_states(y, np.maximum(starts - runs.lead, 0), dt) if states is None else states
    states, chi2, predictions = fit_states(runs, measured, sigma, guess, iterations)
    if alternatives is None:
        return chi2, states, predictions
    grown, value, predicted = _grown(runs, nominal, recording, sigma, starts, guess)
    improved = value < chi2
    states[improved], chi2[improved], predictions[improved] = (
        grown[improved], value[improved], predicted[improved])
    for _ in range(2):
        poor = np.flatnonzero(chi2 > RESCUE * np.median(chi2))
        poor = poor if len(poor) else np.array([], int)
        if not len(poor) or np.median(chi2) > 1e7 * LENGTH:
            break
        changed = False
        bases = [guess, *alternatives]
        for trial in range(len(bases) + len(RESTARTS)):
            begin = bases[trial][poor] if trial < len(bases) else \
                states[poor] + RESTARTS[trial - len(bases)]
            new, value, predicted = fit_states(runs, measured[poor], sigma, begin, 4, poor)
            improved = value < chi2[poor] - 0.5
            if improved.any():
                changed = True
                rows = poor[improved]
                states[rows], chi2[rows], predictions[rows] = new[improved], value[improved], \
                    predicted[improved]
        if not changed:
            break
        if runs.memory.any():
            states, chi2, predictions = fit_states(runs, measured, sigma, states, 3)
    return chi2, states, predictions


def _grown(runs: WindowRuns, nominal: Nominal, recording: MotionRecord, sigma: Array,
           starts: Integers, states: Array) -> tuple[Array, Array, Array]:
    """Return (states, chi2, predictions) of `runs` fitted on longer and longer beginnings."""
    all_windows = np.arange(len(starts))
    for share in BEGINNINGS:
        length = round(share * LENGTH)
        part = WindowRuns(nominal, runs.effects, recording, starts, length, runs.substeps)
        part.memory = runs.memory
        states, chi2, predictions = fit_states(
            part, pieces(recording['y'], starts, length), sigma, states, chosen=all_windows)
    return states, chi2, predictions


def evidence_of(recording: MotionRecord, nominal: Nominal, effects: Effects, rivals: Effects,
                sigma: Array, states: Array, careful: bool) -> float:
    """
    Return the evidence d: twice the log likelihood ratio of two models.

    Args:
        recording: u [N], y [N, 2], dt.
        nominal: values of the drive.
        effects: effects of the true model.
        rivals: effects of the other model.
        sigma: encoder noise [2], rad.
        states: true initial states of the windows [W, 4].
        careful: start windows of the other model again if they do not fit.
    """
    right, *_ = fit_windows(nominal, effects, recording, sigma, states=states, iterations=3,
                            alternatives=None)
    wrong, *_ = fit_windows(nominal, rivals, recording, sigma, states=states,
                            iterations=6 if careful else 4, alternatives=() if careful else None)
    return float(np.minimum(wrong, 1e9).sum() - right.sum())


def misfit(chi2: Array, length: int = LENGTH) -> float:
    """Return the misfit of windows of `length` samples that have these `chi2` [W]."""
    return float(np.sqrt(np.mean(chi2) / (2 * length)))


def closed(nominal_misfit: float, misfit_with_model: float) -> float | None:
    """
    Return the closed fraction of the misfit.

    Args:
        nominal_misfit: misfit of the nominal model.
        misfit_with_model: misfit of the model to be judged.

    Returns:
        1: nothing but noise is left; None: the nominal model fits already.
    """
    return None if nominal_misfit < NO_MISFIT else (
        nominal_misfit - misfit_with_model) / (nominal_misfit - 1.0)
