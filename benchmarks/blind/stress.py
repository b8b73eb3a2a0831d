# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How visible an effect is if nominal values scatter and process torque acts on the motor.

A model without the effect may use the states of the windows and the nominal values, within their
tolerance, instead, and the process torque explains what a torque on the motor can. That torque is
a polyline: white above its spacing. Fits are Gauss-Newton with the states profiled out (Schur
complement).
"""
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.blind import draw, window_fit
from benchmarks.blind.plant import Effects, MotionRecord, Nominal, WindowRuns
from benchmarks.blind.scene import Scene
from gearbox_monitor.kernels.types import Array

Start = tuple[Array, Array]  # relative shifts of the nominal values [P], states [W, 4]

SPACING = 40        # samples between the corners of the polyline
STEP = 2e-3         # of a nominal value
PUSH = 1e-3         # N m
ITERATIONS = 6
SETTLING = 6        # iterations of the states, at most
FAR = 2.5            # times the median chi2, from which on a window counts less
LEVELS = (1e-3, 3e-3, 0.01, 0.03, 0.1)  # N m rms per sample
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a step, until one improves the fit


class Likelihood:
    """
    Likelihood of models of one recording, in sensor noise and process torque of unknown size.

    The effect of the process torque is linearised about the truth.
    """

    def __init__(self, scene: Scene, recording: MotionRecord,
                 effects: list[dict[str, Any]], window_states: Array,
                 sigma: Sequence[float]) -> None:
        """
        Keep the recording and compute the effect of the process torque.

        Args:
            scene: in which it was recorded.
            recording: u [N], y [N, 2], dt.
            effects: true effects.
            window_states: true initial states of the windows [W, 4].
            sigma: encoder noise [2], rad.
        """
        self.recording, self.nominal, self.scatter = recording, scene.nominal, scene.scatter
        self.truth, self.effects, self.window_states = scene.truth, effects, window_states
        self.sigma = np.asarray(sigma)
        self.starts = window_fit.cut(len(self.recording['u']))
        self.measured = window_fit.pieces(self.recording['y'], self.starts)
        runs, predicted, states = self._settled(self.truth, self.effects, self.window_states)
        corners = np.arange(0, window_fit.LENGTH + SPACING, SPACING)[:, None]
        shapes = np.maximum(0.0, 1.0 - np.abs(np.arange(window_fit.LENGTH) - corners) / SPACING)
        self.hats = np.stack([self._scaled(self._pushed(runs, states, shape) - predicted) / PUSH
                              for shape in shapes], axis=2) / np.sqrt(SPACING)

    def evidence(self) -> list[float]:
        """Return d of each effect: twice the log likelihood ratio to a model without it."""
        right = self._best(self.truth, self.effects, 0)
        out = []
        for k, own in enumerate(self.effects):
            start = dict(self.truth)
            if own['id'] in draw.REPLACES:
                key = draw.REPLACES[own['id']]
                start[key] = own[key]
            remaining = [e for j, e in enumerate(self.effects) if j != k]
            out.append(float(self._best(start, remaining, ITERATIONS) - right))
        return out

    def _best(self, nominal: Nominal, effects: Effects, iterations: int) -> float:
        """Return the smallest -2 log likelihood over process torque, nominal values and states."""
        start: Start = self._shifts(nominal), self.window_states
        costs: list[float] = []
        for level in LEVELS:
            self._make_noisy(level)
            cost, start = self._fitted(effects, *start, iterations)
            costs.append(cost + self.complexity)
            if costs[-1] > min(costs) + 10.0:
                break
        return min(costs)

    def _make_noisy(self, level: float) -> None:
        hats = self.hats * level
        inner = hats.transpose(0, 2, 1) @ hats + np.eye(hats.shape[2])
        self.noise = hats, np.linalg.inv(inner)
        self.complexity = float(np.linalg.slogdet(inner)[1].sum())

    def _fitted(self, effects: Effects, shifts: Array, states: Array,
                iterations: int) -> tuple[float, Start]:
        """
        Return (-2 log likelihood, (shifts, states)) by Gauss-Newton in the nominal values.

        At first, windows that fit poorly get less weight; they are then started elsewhere.
        """
        for robust in (True, False):
            current = self._at(effects, shifts, states, robust)
            for _ in range(iterations):
                step, gained = np.linalg.solve(current[1], current[2]), 0.0
                for share in SHARES:
                    trial = self._at(effects, shifts + share * step, current[3], robust)
                    if trial[0] < current[0]:
                        gained = current[0] - trial[0]
                        shifts, current = shifts + share * step, trial
                        break
                if gained < 0.5:
                    break
            states = current[3]
            if robust and iterations:
                _, states, _ = window_fit.fit_windows(
                    self._shifted(shifts), effects, self.recording, self.sigma, states=states,
                    iterations=SETTLING, alternatives=(self.window_states,))
        return current[0], (shifts, states)

    def _at(self, effects: Effects, shifts: Array, states: Array,
            robust: bool) -> tuple[float, Array, Array, Array]:
        """Return (-2 log posterior, its curvature, its descent, states) at nominal `shifts`."""
        nominal = self._shifted(shifts)
        runs, predictions, states = self._settled(nominal, effects, states)
        chi2, S, g = self._normal(nominal, runs, predictions, states, robust)
        weight = self.scatter ** -2
        return (float(chi2 + weight * shifts @ shifts), S + weight * np.eye(len(shifts)),
                g - weight * shifts, states)

    def _shifted(self, shifts: Array) -> dict[str, float]:
        """Return the nominal values, those that scatter changed by the relative `shifts`."""
        return {**self.nominal, **{key: self.nominal[key] * (1.0 + shift)
                                   for key, shift in zip(draw.SCATTERED, shifts)}}

    def _shifts(self, nominal: Nominal) -> Array:
        """Return the relative shifts of `nominal`; a value of 0 scatters around 0: by nothing."""
        return np.array([nominal[key] / self.nominal[key] - 1.0 if self.nominal[key] else 0.0
                         for key in draw.SCATTERED])

    def _settled(self, nominal: Nominal, effects: Effects,
                 states: Array) -> tuple[WindowRuns, Array, Array]:
        runs = self._runs(nominal, effects)
        states, _, predictions = window_fit.fit_states(runs, self.measured, self.sigma, states,
                                                       SETTLING)
        return runs, predictions, states

    def _runs(self, nominal: Nominal, effects: Effects) -> WindowRuns:
        return WindowRuns(nominal, effects, self.recording, self.starts, window_fit.LENGTH,
                          window_fit.SUBSTEPS)

    def _pushed(self, runs: WindowRuns, states: Array, shape: Array) -> Array:
        """Return y [W, L, 2] with PUSH times shape [L] more torque on the motor."""
        out, undisturbed = np.empty_like(self.measured), runs.command.copy()
        for w, start in enumerate(self.starts):
            runs.command[start:start + window_fit.LENGTH] += PUSH * shape
            out[w] = runs.run(states[w:w + 1], [w])[0]
            runs.command[:] = undisturbed
        return out

    def _scaled(self, y: Array) -> Array:
        return np.nan_to_num(y / self.sigma).reshape(len(y), -1)

    def _white(self, b: Array) -> Array:
        """Return the inverse covariance of the noise times b [W, M, C]."""
        hats, inverse = self.noise
        return b - hats @ (inverse @ (hats.transpose(0, 2, 1) @ b))

    def _normal(self, nominal: Nominal, runs: WindowRuns, predictions: Array, states: Array,
                robust: bool) -> tuple[float, Array, Array]:
        """Return (chi2, S [P, P], g [P]) in the nominal values, the states profiled out."""
        columns = []
        for i, step in enumerate(window_fit.STEPS):
            moved = states.copy()
            moved[:, i] += step
            columns.append(self._scaled(runs.run(moved) - predictions) / step)
        for key in draw.SCATTERED:
            shifted = self._runs({**nominal, key: nominal[key] + STEP * self.nominal[key]},
                                 runs.effects)
            shifted.memory[:] = runs.memory
            columns.append(self._scaled(shifted.run(states) - predictions) / STEP)
        columns.append(self._scaled(self.measured - predictions))
        design = np.stack(columns, axis=2)
        product = design.transpose(0, 2, 1) @ self._white(design)
        scale = 1.0 / np.sqrt(np.einsum('wii->wi', product[:, :4, :4]) + 1e-12)
        inner = product[:, :4, :4] * scale[:, :, None] * scale[:, None, :] + 1e-9 * np.eye(4)
        cross = product[:, :4, 4:] * scale[:, :, None]
        reduced = product[:, 4:, 4:] - cross.transpose(0, 2, 1) @ np.linalg.solve(inner, cross)
        chi2 = reduced[:, -1, -1]
        # Windows that sit in the wrong contact must not decide.
        limit = FAR * np.median(chi2) if robust else chi2.max()
        cost = np.minimum(chi2, limit) + limit * np.log(np.maximum(chi2 / limit, 1.0))
        reduced = (np.minimum(1.0, limit / chi2)[:, None, None] * reduced).sum(axis=0)
        return float(cost.sum()), reduced[:-1, :-1], reduced[:-1, -1]
