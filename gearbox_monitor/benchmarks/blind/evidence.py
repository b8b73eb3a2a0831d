# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Windowed likelihood of a known model: chi2, evidence, gap and closed fraction.

A recording is cut in windows of 1 s; in each the model runs freely from the initial state (four
numbers) that fits best. Held out are the last round(0.3 n) windows.
"""
import numpy as np

from gearbox_monitor.benchmarks.blind.plant import Windows

LENGTH = 1000       # samples of a window
HELD_OUT = 0.3
NO_GAP = 1.02       # below, there is nothing to close
SUBSTEPS = 5
STEPS = np.array([2e-5, 2e-5, 2e-4, 2e-4])  # rad, rad/s, of the sensitivities
RESCUE = 1.25       # over the median chi2: start the window again
BEGINNINGS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0)  # shares of a window: where impacts follow each
#                     other, states that fit all of it are found from those that fit its beginning
# Changes of a start: motor position, arm position, motor speed, arm speed.
RESTARTS = np.array([[0, 0, 0, -1.5], [0, 0, 0, 1.5], [0, 0, 0, -4.0], [0, 0, 0, 4.0],
                     [0, -0.04, 0, 0], [0, 0.04, 0, 0], [0, 0, -1.5, 0], [0, 0, 1.5, 0]], float)


def cut(n, length=LENGTH):
    """Return the first samples of all whole windows of `n` samples."""
    return np.arange(n // length) * length


def held_out(count):
    """Return a mask [count] of the windows that no fit may see."""
    return np.arange(count) >= count - int(round(HELD_OUT * count))


def first_states(y, starts, dt, reach=25):
    """Return states [W, 4] read off the encoders y [N, 2] near each start."""
    states = np.empty((len(starts), 4))
    for w, start in enumerate(starts):
        a, b = max(start - reach, 0), min(start + reach, len(y) - 1) + 1
        t = (np.arange(a, b) - start) * dt
        for c in (0, 1):
            fit = np.polynomial.polynomial.polyfit(t, y[a:b, c], 2 if a < start else 1)
            states[w, c], states[w, 2 + c] = fit[0], fit[1]
    return states


def pieces(y, starts, length=LENGTH):
    return np.stack([y[s:s + length] for s in starts])


def _chi2(y, found, sigma):
    with np.errstate(invalid='ignore', over='ignore'):
        chi2 = (((y - found) / sigma) ** 2).sum(axis=(1, 2))
    return np.where(np.isfinite(chi2), chi2, np.inf)


def _finite(array):
    """Return `array` as numbers whose squares can be summed: runs from far off diverge."""
    return np.clip(np.nan_to_num(array), -1e100, 1e100)


def fit_states(runs, y, sigma, states, iterations=6, chosen=None):
    """Return (states, chi2 [W], predictions): Levenberg-Marquardt, each window on its own."""
    states, carry = np.array(states, float), chosen is None
    chosen = np.arange(len(states)) if chosen is None else np.asarray(chosen)
    found = runs.run(states, chosen, keep=carry)
    if carry and runs.memory.any():
        found = runs.run(states, chosen, keep=True)
    chi2, damping = _chi2(y, found, sigma), np.full(len(states), 1e-3)
    for iteration in range(iterations):
        jacobian = np.empty((len(states), y.shape[1] * 2, 4))
        for i, step in enumerate(STEPS):
            moved = states.copy()
            moved[:, i] += step
            with np.errstate(invalid='ignore'):  # runs from far off diverge
                change = runs.run(moved, chosen) - found
            jacobian[:, :, i] = (change / step / sigma).reshape(len(states), -1)
        residual = _finite(((y - found) / sigma).reshape(len(states), -1))
        jacobian = _finite(jacobian)
        normal = np.einsum('wni,wnj->wij', jacobian, jacobian)
        pull = np.einsum('wni,wn->wi', jacobian, residual)
        scale = np.sqrt(np.einsum('wii->wi', normal)) + 1e-12
        normal = normal / scale[:, :, None] / scale[:, None, :]
        before = chi2.copy()
        for _ in range(3):
            damped = normal + damping[:, None, None] * np.eye(4)
            step = np.linalg.solve(damped, (pull / scale)[:, :, None])[:, :, 0] / scale
            trial = states + step
            tried = runs.run(trial, chosen)
            new = _chi2(y, tried, sigma)
            better = new < chi2
            states[better], found[better], chi2[better] = (
                trial[better], tried[better], new[better])
            damping = np.where(better, damping * 0.1, damping * 30.0)
            if better.all() or (chi2 > before - 0.1).all():
                break
        if carry and runs.memory.any():
            found = runs.run(states, chosen, keep=True)
            chi2 = _chi2(y, found, sigma)
        if np.all(chi2 > before - 0.05):
            break
    return states, chi2, found


def fit_windows(nominal, effects, recording, sigma, starts=None, states=None, rescue=True,
                iterations=6, substeps=SUBSTEPS, others=()):
    """
    Return (chi2 [W], states [W, 4], predictions [W, length, 2]) of a model of fixed parameters.

    recording: dict of u [N], y [N, 2], dt. states: known starts; else read off the encoders.
    others: further starts [W, 4] to try where a window does not fit.
    """
    u, y, dt = recording['u'], recording['y'], recording['dt']
    starts = cut(len(u)) if starts is None else starts
    runs = Windows(nominal, effects, u, dt, starts, LENGTH, substeps)
    measured = pieces(y, starts)
    guess = first_states(y, np.maximum(starts - runs.lead, 0), dt) if states is None else states
    states, chi2, found = fit_states(runs, measured, sigma, guess, iterations)
    if not rescue:
        return chi2, states, found
    again, value, predicted = _grown(runs, nominal, recording, sigma, starts, guess)
    better = value < chi2
    states[better], chi2[better], found[better] = again[better], value[better], predicted[better]
    for _ in range(2):
        poor = np.flatnonzero(chi2 > RESCUE * np.median(chi2))
        poor = poor if len(poor) else np.array([], int)
        if not len(poor) or np.median(chi2) > 1e7 * LENGTH:
            break
        changed = False
        bases = [guess, *others]
        for trial in range(len(bases) + len(RESTARTS)):
            begin = bases[trial][poor] if trial < len(bases) else \
                states[poor] + RESTARTS[trial - len(bases)]
            new, value, predicted = fit_states(runs, measured[poor], sigma, begin, 4, poor)
            better = value < chi2[poor] - 0.5
            if better.any():
                changed = True
                rows = poor[better]
                states[rows], chi2[rows], found[rows] = new[better], value[better], \
                    predicted[better]
        if not changed:
            break
        if runs.memory.any():
            states, chi2, found = fit_states(runs, measured, sigma, states, 3)
    return chi2, states, found


def _grown(runs, nominal, recording, sigma, starts, states):
    """Return (states, chi2, predictions) of `runs` fitted on longer and longer beginnings."""
    every = np.arange(len(starts))
    for share in BEGINNINGS:
        length = round(share * LENGTH)
        part = Windows(nominal, runs.effects, recording['u'], recording['dt'], starts, length,
                       runs.substeps)
        part.memory = runs.memory
        states, chi2, found = fit_states(part, pieces(recording['y'], starts, length), sigma,
                                         states, chosen=every)
    return states, chi2, found


def evidence_of(recording, nominal, effects, rivals, sigma, states, careful):
    """
    Return d: 2 Delta log likelihood of a model with `effects` over that with `rivals`.

    states [W, 4]: where runs begin in truth; careful: start windows again that stick.
    """
    right, *_ = fit_windows(nominal, effects, recording, sigma, states=states, rescue=False,
                            iterations=3)
    wrong, *_ = fit_windows(nominal, rivals, recording, sigma, states=states, rescue=careful,
                            iterations=6 if careful else 4)
    return float(np.minimum(wrong, 1e9).sum() - right.sum())


def gap(chi2, length=LENGTH):
    """Return sqrt of the mean square error in sigmas over windows, samples, both channels."""
    return float(np.sqrt(np.mean(chi2) / (2 * length)))


def closed(before, after):
    """Return the closed fraction, None where nothing is to be closed."""
    return None if before < NO_GAP else (before - after) / (before - 1.0)
