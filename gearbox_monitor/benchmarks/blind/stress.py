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
How visible an effect is where nominal values scatter and torque noise acts.

Without the effect, the states of the windows and the nominal values, within their tolerance, may
take its place, and torque noise explains what a torque on the motor can. That noise is a polyline:
white above its spacing.
"""
import numpy as np

from gearbox_monitor.benchmarks.blind import draw, evidence, plant

SPACING = 40        # samples between the corners of the polyline
SCATTERED = ('m1', 'm2', 'D', 'Cv', 'Cc', 'K', 'b')
STEP = 2e-3         # of a nominal value
PUSH = 1e-3         # N m
ITERATIONS = 6
SETTLING = 6        # iterations of the states, at most
FAR = 2.5            # times the median chi2, from which on a window counts less
LEVELS = (1e-3, 3e-3, 0.01, 0.03, 0.1)  # N m rms per sample
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a step, until one is better


class Likelihood:
    """
    Of models of one recording, in sensor noise and in torque noise of a size that nobody knows.

    scene: Scene; found: Found, what was recorded in it; sigma [2]: noise of the encoders, rad.
    The torque noise is linearised about the truth.
    """

    def __init__(self, scene, found, sigma):
        """Keep what the arguments of the class say, and what torque noise does."""
        self.recording, self.told, self.scatter = found.recording, scene.told, scene.scatter
        self.truth, self.effects, self.known = scene.truth, found.effects, found.known
        self.sigma = np.asarray(sigma)
        self.starts = evidence.cut(len(self.recording['u']))
        self.measured = evidence.pieces(self.recording['y'], self.starts)
        runs, predicted, states = self._settled(self.truth, self.effects, self.known)
        corners = np.arange(0, evidence.LENGTH + SPACING, SPACING)[:, None]
        shapes = np.maximum(0.0, 1.0 - np.abs(np.arange(evidence.LENGTH) - corners) / SPACING)
        self.hats = np.stack([self._scaled(self._pushed(runs, states, shape) - predicted) / PUSH
                              for shape in shapes], axis=2) / np.sqrt(SPACING)

    def evidence(self):
        """Return [d of each effect]: 2 Delta log likelihood of the truth over what lacks it."""
        right = self._best(self.truth, self.effects, 0)
        out = []
        for k, own in enumerate(self.effects):
            start = dict(self.truth)
            if own['id'] in draw.REPLACES:
                key = draw.REPLACES[own['id']]
                start[key] = own[key]
            others = [e for j, e in enumerate(self.effects) if j != k]
            out.append(float(self._best(start, others, ITERATIONS) - right))
        return out

    def _best(self, nominal, effects, iterations):
        """Return the least -2 log likelihood with `effects` over torque noise, values, states."""
        start, costs = (self._shifts(nominal), self.known), []
        for level in LEVELS:
            self._make_noisy(level)
            cost, start = self._fitted(effects, *start, iterations)
            costs.append(cost + self.complexity)
            if costs[-1] > min(costs) + 10.0:
                break
        return min(costs)

    def _make_noisy(self, level):
        hats = self.hats * level
        inner = hats.transpose(0, 2, 1) @ hats + np.eye(hats.shape[2])
        self.noise = hats, np.linalg.inv(inner)
        self.complexity = float(np.linalg.slogdet(inner)[1].sum())

    def _fitted(self, effects, shifts, states, iterations):
        """
        Return (-2 log likelihood, (shifts, states)) by Gauss-Newton in the nominal values.

        Windows that are far off count less, first, and are then started elsewhere.
        """
        def nominal_of(shifts):
            return {**self.told, **{key: self.told[key] * (1.0 + shift)
                                    for key, shift in zip(SCATTERED, shifts)}}

        def at(shifts, states, robust):
            nominal = nominal_of(shifts)
            runs, found, states = self._settled(nominal, effects, states)
            chi2, S, g = self._normal(nominal, effects, runs, found, states, robust)
            weight = self.scatter ** -2
            return (chi2 + weight * shifts @ shifts, S + weight * np.eye(len(shifts)),
                    g - weight * shifts, states)
        for robust in (True, False):
            now = at(shifts, states, robust)
            for _ in range(iterations):
                step, gained = np.linalg.solve(now[1], now[2]), 0.0
                for share in SHARES:
                    trial = at(shifts + share * step, now[3], robust)
                    if trial[0] < now[0]:
                        gained, shifts, now = now[0] - trial[0], shifts + share * step, trial
                        break
                if gained < 0.5:
                    break
            states = now[3]
            if robust and iterations:
                _, states, _ = evidence.fit_windows(
                    nominal_of(shifts), effects, self.recording, self.sigma, states=states,
                    iterations=SETTLING, others=(self.known,))
        return now[0], (shifts, states)

    def _shifts(self, nominal):
        return np.array([nominal[key] / self.told[key] - 1.0 for key in SCATTERED])

    def _settled(self, nominal, effects, states):
        runs = plant.Windows(nominal, effects, self.recording['u'], self.recording['dt'],
                             self.starts, evidence.LENGTH, evidence.SUBSTEPS)
        states, _, found = evidence.fit_states(runs, self.measured, self.sigma, states, SETTLING)
        return runs, found, states

    def _pushed(self, runs, states, shape):
        """Return y [W, L, 2] with PUSH times shape [L] more torque on the motor."""
        out, before = np.empty_like(self.measured), runs.command.copy()
        for w, start in enumerate(self.starts):
            runs.command[start:start + evidence.LENGTH] += PUSH * shape
            out[w] = runs.run(states[w:w + 1], [w])[0]
            runs.command[:] = before
        return out

    def _scaled(self, y):
        return np.nan_to_num(y / self.sigma).reshape(len(y), -1)

    def _white(self, b):
        """Return the inverse covariance of the noise times b [W, M, C]."""
        hats, inverse = self.noise
        return b - hats @ (inverse @ (hats.transpose(0, 2, 1) @ b))

    def _normal(self, nominal, effects, runs, found, states, robust):
        """Return (chi2, S [P, P], g [P]) in the nominal values, the states profiled out."""
        columns = []
        for i, step in enumerate(evidence.STEPS):
            moved = states.copy()
            moved[:, i] += step
            columns.append(self._scaled(runs.run(moved) - found) / step)
        for key in SCATTERED:
            other = plant.Windows({**nominal, key: nominal[key] + STEP * self.told[key]}, effects,
                                  self.recording['u'], self.recording['dt'], self.starts,
                                  evidence.LENGTH, evidence.SUBSTEPS)
            other.memory[:] = runs.memory
            columns.append(self._scaled(other.run(states) - found) / STEP)
        columns.append(self._scaled(self.measured - found))
        all_ = np.stack(columns, axis=2)
        product = all_.transpose(0, 2, 1) @ self._white(all_)
        scale = 1.0 / np.sqrt(np.einsum('wii->wi', product[:, :4, :4]) + 1e-12)
        inner = product[:, :4, :4] * scale[:, :, None] * scale[:, None, :] + 1e-9 * np.eye(4)
        cross = product[:, :4, 4:] * scale[:, :, None]
        left = product[:, 4:, 4:] - cross.transpose(0, 2, 1) @ np.linalg.solve(inner, cross)
        chi2 = left[:, -1, -1]
        # Windows that sit in the wrong contact must not decide.
        limit = FAR * np.median(chi2) if robust else chi2.max()
        cost = np.minimum(chi2, limit) + limit * np.log(np.maximum(chi2 / limit, 1.0))
        left = (np.minimum(1.0, limit / chi2)[:, None, None] * left).sum(axis=0)
        return cost.sum(), left[:-1, :-1], left[:-1, -1]
