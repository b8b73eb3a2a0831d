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
What other models can make of a recording: fits of parameters, and the best imitator of an effect.

Gauss-Newton over shared parameters and the four initial states of each window.
"""
import numpy as np

from gearbox_monitor.benchmarks.blind import draw, evidence, plant

LEAD = 30           # samples that runs with a delayed encoder start earlier
FITTED = 5          # single candidates fitted after the linear screening
PAIRS = 2           # pairs fitted
KEPT = 2            # singles that a second id is added to
# id -> starts: lists of (parameter, start, step, low, high); None: filled in from the nominal.
_SMALL = 1e-4
_PROBES = {
    'stribeck': [[('Cs', 0.05, 1e-3, 0.0, 2.0), ('vs', v, 0.02, 0.02, 20.0)]
                 for v in (0.2, 0.8, 3.0)],
    'lugre': [[('sigma0', s, 1.0, 5.0, 5e3), ('sigma1', 0.05, 0.01, 0.0, 3.0),
               ('Cs', 0.05, 2e-3, 0.0, 2.0), ('vs', 0.8, 0.02, 0.02, 20.0)]
              for s in (40.0, 150.0, 500.0)],
    'coulomb_asymmetry': [[('Ca', 0.01, _SMALL, -1.0, 1.0)]],
    'load_friction': [[('Cl', 0.03, _SMALL, -0.3, 2.0)]],
    'viscous_drift': [[('r', 0.1, 2e-3, -0.95, 5.0), ('T', t, 0.1, 0.5, 60.0)]
                      for t in (3.0, 10.0)],
    'arm_viscous': [[('Cav', 0.003, _SMALL, -0.05, 2.0)]],
    'arm_coulomb': [[('Cac', 0.01, _SMALL, -0.2, 2.0)]],
    'gravity': [[('G', 0.03, _SMALL, -2.0, 5.0)]],
    'load_torque': [[('TL', 0.01, _SMALL, -3.0, 3.0)]],
    'hysteresis_bouc_wen': [[('Th', 0.03, _SMALL, -0.3, 5.0), ('dh', d, 1e-4, 1e-3, 0.5)]
                            for d in (0.006, 0.02, 0.06)],
    'hysteresis_branch': [[('h', 0.003, 2e-5, -0.1, 0.5), ('ds', d, 1e-4, 1e-3, 0.5)]
                          for d in (0.006, 0.02, 0.06)],
    'torque_gain': [[('g', 0.02, _SMALL, -0.8, 2.0)]],
    'torque_offset': [[('u0', 0.01, _SMALL, -1.0, 1.0)]],
    'actuator_lag': [[('T', 0.003, 1e-4, 2e-5, 0.1)]],
    'actuator_delay': [[('T', 0.003, 1e-4, 0.0, 0.08)]],
    'encoder_offset': [[('c', 0.005, 1e-4, -0.5, 0.5)]],
    'motor_encoder_delay': [[('T', 0.002, 1e-4, 0.0, 0.028)]],
    'arm_encoder_delay': [[('T', 0.002, 1e-4, 0.0, 0.028)]],
}
_WAVES = {'cogging': 0.02, 'torque_ripple': 0.03, 'mesh_error': 0.001,
          'motor_encoder_eccentricity': 0.004, 'arm_encoder_eccentricity': 0.004}


def probes(name, told, recording):
    """Return starts of the id `name`: lists of (parameter, start, step, low, high)."""
    if name in draw.REPLACES:
        key = draw.REPLACES[name]
        value = told[key]
        return [[(key, 1.03 * value, 1e-3 * value, 0.02 * value, 50.0 * value)]]
    if name == 'hardening':
        k3 = 0.1 * told['K'] ** 3 / np.mean(recording['u'] ** 2)
        return [[('K3', k3, 0.01 * k3, -3.0 * k3, 100.0 * k3)]]
    if name == 'saturation':
        peak = np.abs(recording['u']).max()
        return [[('umax', share * peak, 2e-3 * peak, 0.05 * peak, peak)]
                for share in (0.9, 0.7, 0.5)]
    return _PROBES[name]


def wave_effect(name, sine, cosine, n):
    """Return a periodic effect of the amplitudes of sine and cosine."""
    out = {'id': name, 'A': float(np.hypot(sine, cosine)),
           'phi': float(np.arctan2(cosine, sine))}
    return out if 'eccentricity' in name else {**out, 'N': int(n)}


class Candidate:
    """A set of ids with starting values; `build` makes the model of a parameter vector."""

    def __init__(self, parts, told):
        """Keep parts: [(id, [(name, start, step, low, high)], fixed parameters)]."""
        self.parts, self.told = parts, told
        rows = [row for _, table, _ in parts for row in table]
        self.start, self.step, self.low, self.high = (
            np.array([row[i] for row in rows], float) for i in (1, 2, 3, 4))
        self.ids = [name for name, _, _ in parts]

    def build(self, theta):
        """Return (nominal, effects)."""
        effects, k = [], 0
        for name, table, fixed in self.parts:
            values = {row[0]: float(theta[k + i]) for i, row in enumerate(table)}
            k += len(table)
            effects.append(wave_effect(name, values['sine'], values['cosine'], fixed)
                           if name in _WAVES else {'id': name, **values})
        return self.told, effects

    def joined(self, other):
        return Candidate(self.parts + other.parts, self.told)

    def at(self, theta):
        """Return the candidate started from `theta`."""
        parts, k = [], 0
        for name, table, fixed in self.parts:
            parts.append((name, [(row[0], float(theta[k + i]), *row[2:])
                                 for i, row in enumerate(table)], fixed))
            k += len(table)
        return Candidate(parts, self.told)


def candidates(names, told, recording, waves=True):
    """Return Candidates of the ids `names`; periodic ones for each N of 1..40."""
    out = []
    for name in names:
        if name in draw.QUANTISATION or name == 'disturbance':
            continue
        if name in _WAVES:
            size = _WAVES[name]
            table = [('sine', size, 0.1 * size, -2.0, 2.0),
                     ('cosine', size, 0.1 * size, -2.0, 2.0)]
            for n in (range(1, 41) if waves and 'eccentricity' not in name else [1]):
                out.append(Candidate([(name, table, n)], told))
            continue
        out += [Candidate([(name, table, None)], told)
                for table in probes(name, told, recording)]
    return out


class Fitter:
    """Fits on one recording; starts from the states of the nominal model."""

    def __init__(self, recording, sigma):
        self.recording, self.sigma = recording, np.asarray(sigma, float)
        self.starts = evidence.cut(len(recording['u']))
        self.measured = evidence.pieces(recording['y'], self.starts)

    def runs(self, model, lead=0):
        return plant.Windows(*model, self.recording['u'], self.recording['dt'], self.starts,
                             evidence.LENGTH, evidence.SUBSTEPS, lead)

    def back(self, states, lead):
        """Return states at the starts of runs that begin `lead` samples earlier."""
        states = np.array(states)
        states[:, :2] -= lead * self.recording['dt'] * states[:, 2:]
        return states

    def states_columns(self, runs, states, found):
        columns = np.empty((*found.shape, 4))
        for i, step in enumerate(evidence.STEPS):
            moved = states.copy()
            moved[:, i] += step
            columns[..., i] = (runs.run(moved) - found) / step / self.sigma[:, None].T
        return np.nan_to_num(columns.reshape(len(states), -1, 4))

    def fit(self, candidate, states, iterations=10):
        """Return (chi2, theta, states) from the start of `candidate`."""
        lead = LEAD if any('encoder_delay' in i for i in candidate.ids) else 0
        theta, states = candidate.start.copy(), self.back(states, lead)
        runs = self.runs(candidate.build(theta), lead)
        states, chi2, found = evidence.fit_states(runs, self.measured, self.sigma, states, 3)
        cost, damping = chi2.sum(), 1e-3
        for _ in range(iterations):
            memory = runs.memory.copy()
            jx = self.states_columns(runs, states, found)
            residual = ((self.measured - found) / self.sigma).reshape(len(states), -1)
            jt = np.empty((*residual.shape, len(theta)))
            for i, step in enumerate(candidate.step):
                moved = theta.copy()
                moved[i] += step if theta[i] + step <= candidate.high[i] else -step
                other = self.runs(candidate.build(moved), lead)
                other.memory[:] = memory
                jt[..., i] = ((other.run(states) - found) / (moved[i] - theta[i])
                              / self.sigma).reshape(len(states), -1)
            jt, residual = np.nan_to_num(jt), np.nan_to_num(residual)
            # windows that sit in the wrong contact must not decide
            median = np.median(chi2)
            weight = np.minimum(1.0, 2.5 * median / chi2)[:, None, None]
            a = np.einsum('wni,wnj->wij', jx, jx)
            scale = np.sqrt(np.einsum('wii->wi', a)) + 1e-12
            a = a / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(4)
            b = np.einsum('wni,wnj->wij', jx, jt) / scale[:, :, None]
            g = np.einsum('wni,wn->wi', jx, residual) / scale
            inverse_b = np.linalg.solve(a, b)
            inverse_g = np.linalg.solve(a, g[:, :, None])
            normal = np.einsum('wni,wnj->wij', jt, jt) - np.einsum('wki,wkj->wij', b, inverse_b)
            pull = np.einsum('wni,wn->wi', jt, residual)[:, :, None] - np.einsum(
                'wki,wkj->wij', b, inverse_g)
            normal, pull = (weight * normal).sum(axis=0), (weight * pull).sum(axis=0)[:, 0]
            size = np.sqrt(np.diag(normal)) + 1e-12
            improved = False
            for _ in range(5):
                matrix = normal / np.outer(size, size) + damping * np.eye(len(theta))
                trial = np.clip(theta + np.linalg.solve(matrix, pull / size) / size,
                                candidate.low, candidate.high)
                moved = states + (inverse_g[:, :, 0] - np.einsum(
                    'wij,j->wi', inverse_b, trial - theta)) / scale
                fresh = self.runs(candidate.build(trial), lead)
                fresh.memory[:] = memory
                # windows settle before the step is judged
                new_states, new_chi2, new_found = evidence.fit_states(
                    fresh, self.measured, self.sigma, np.where(
                        np.isfinite(moved), moved, states), 1)
                new = new_chi2.sum()
                if new < cost:
                    gained, cost, theta, states = cost - new, new, trial, new_states
                    chi2, found, runs, improved = new_chi2, new_found, fresh, True
                    damping *= 0.2
                    break
                damping = max(damping * 10.0, 1e-6)
            if not improved or gained < 0.5:
                break
        return cost, theta, self.back(states, -lead)

    def polish(self, candidate, theta, others):
        """Return chi2 with windows started again where they stick."""
        chi2, *_ = evidence.fit_windows(*candidate.build(theta), self.recording, self.sigma,
                                        others=others)
        return float(chi2.sum())

    def screen(self, many, states, base=None):
        """Return the linear gain in chi2 of each candidate, beyond the model `base`."""
        told, effects = base if base is not None else (many[0].told, [])
        runs = self.runs((told, effects))
        states, _, found = evidence.fit_states(runs, self.measured, self.sigma, states, 2)
        jx = self.states_columns(runs, states, found)
        q, _ = np.linalg.qr(jx)
        residual = np.nan_to_num(((self.measured - found) / self.sigma).reshape(len(states), -1))
        residual -= np.einsum('wni,wmi,wm->wn', q, q, residual, optimize=True)
        gains, led = [], None
        for candidate in many:
            start = candidate.start.copy()
            models = [start]
            if candidate.ids[0] in _WAVES:  # sine and cosine on their own
                models = [np.array([start[0], 0.0]), np.array([0.0, start[1]])]
            columns = []
            for theta in models:
                extra = candidate.build(theta)[1]
                if any('encoder_delay' in e['id'] for e in extra):
                    if led is None:
                        led = self.runs((told, effects), LEAD).run(self.back(states, LEAD))
                    y = self.runs((told, effects + extra), LEAD).run(self.back(states, LEAD))
                    change = y - led
                else:
                    other = self.runs((told, effects + extra))
                    other.memory[:] = runs.memory
                    change = other.run(states) - found
                column = np.nan_to_num((change / self.sigma).reshape(len(states), -1))
                columns.append(column - np.einsum('wni,wmi,wm->wn', q, q, column,
                                                  optimize=True))
            c = np.stack([v.ravel() for v in columns], axis=1)
            answer, *_ = np.linalg.lstsq(c, residual.ravel(), rcond=None)
            gains.append(float((residual ** 2).sum()
                               - ((residual.ravel() - c @ answer) ** 2).sum()))
        return np.array(gains)


def _best(many, gains, count):
    """Return the `count` best candidates, of each id the best two at most."""
    chosen, seen = [], {}
    for i in np.argsort(-gains):
        key = many[i].ids[-1]
        if seen.get(key, 0) < 2:
            seen[key] = seen.get(key, 0) + 1
            chosen.append(many[i])
        if len(chosen) == count:
            break
    return chosen


def best_imitator(label, recording, reported=None):
    """
    Return what the best other single id and pair leave of the evidence of a label's effect.

    reported: (nominal, effects) that a verdict describes, which may be the best one. left: 2 log
    likelihood by which the truth stays ahead of the best imitator; imitators: ids (or id+id) that
    leave least, best first.
    """
    sigma, told = np.array(label['sigma']), label['told']
    quantised = [e for e in label['effects'] if e['id'] in draw.QUANTISATION]
    if quantised or 'disturbance' in label['ids']:
        return {'left': None, 'imitators': [], 'why': 'no evidence to imitate'}
    names = [i for i in plant.EFFECTS if i not in label['ids'] and i not in label['exclude']]
    fitter = Fitter(recording, sigma)
    known = np.array(label['states'])[:len(fitter.starts)]
    lead = plant.lead_of(label['effects'], recording['dt'])
    true, *_ = evidence.fit_windows(label['truth'], label['effects'], recording, sigma,
                                    states=fitter.back(known, lead))
    none, states, _ = evidence.fit_windows(told, [], recording, sigma, others=(known,))
    many = candidates(names, told, recording)
    gains = fitter.screen(many, states)
    fits = []
    for candidate in _best(many, gains, FITTED):
        cost, theta, found = fitter.fit(candidate, states)
        fits.append((cost, candidate.at(theta), found))
    fits.sort(key=lambda f: f[0])
    for _, single, found in list(fits[:KEPT]):
        rest = [c for c in many if c.ids[0] not in single.ids
                and draw.compatible(c.ids[0], single.ids[0])]
        if not rest:
            continue
        base = single.build(single.start)
        if any('encoder_delay' in i for i in single.ids):
            order = gains[[many.index(c) for c in rest]]
        else:
            order = fitter.screen(rest, found, base)
        for second in _best(rest, order, PAIRS):
            pair = single.joined(second)
            cost, theta, end = fitter.fit(pair, found, 6)
            fits.append((cost, pair.at(theta), end))
    fits.sort(key=lambda f: f[0])
    polished = []
    for cost, candidate, found in fits[:3]:
        chi2 = fitter.polish(candidate, candidate.start, (found, known))
        polished.append((min(cost, chi2), '+'.join(candidate.ids)))
    if reported is not None:
        chi2, *_ = evidence.fit_windows(*reported, recording, sigma, others=(known,))
        polished.append((float(chi2.sum()), '+'.join(e['id'] for e in reported[1])))
    polished.sort()
    left = polished[0][0] - true.sum()
    near = [name for chi2, name in polished if chi2 - true.sum() <= left + 25.0]
    return {'left': float(left), 'evidence': float(none.sum() - true.sum()), 'imitators': near}
