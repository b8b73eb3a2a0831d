# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How well other models explain a recording: fits of parameters, the best imitator of an effect.

Gauss-Newton over shared parameters and the four initial states of each window; the states are
profiled out (Schur complement). A linear screening selects the candidates that are fitted.
"""
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.blind import draw, plant, window_fit
from benchmarks.blind.plant import Effects, Nominal, WindowRuns
from gearbox_monitor.kernels.types import Array

Row = tuple[str, float, float, float, float]  # parameter, start, step, low, high
CandidatePart = tuple[str, list[Row], int | None]      # id, its parameters, number of the harmonic
Model = tuple[Nominal, Effects]

LEAD = 30           # samples that runs with a delayed encoder start earlier
FITTED = 5          # single candidates fitted after the linear screening
PAIRS = 2           # pairs fitted
KEPT = 2            # singles that a second id is added to
# id -> starts: lists of (parameter, start, step, low, high); None: filled in from the nominal.
_SMALL = 1e-4
_PROBES: dict[str, list[list[Row]]] = {
    'stribeck': [[('Cs', 0.05, 1e-3, 0.0, 2.0), ('vs', v, 0.02, 0.02, 20.0)]
                 for v in (0.2, 0.8, 3.0)],
    'lugre': [[('sigma0', s, 1.0, 5.0, 5e3), ('sigma1', 0.05, 0.01, 0.0, 3.0),
               ('Cs', 0.05, 2e-3, 0.0, 2.0), ('vs', 0.8, 0.02, 0.02, 20.0)]
              for s in (40.0, 150.0, 500.0)],
    'coulomb_asymmetry': [[('Ca', 0.01, _SMALL, -1.0, 1.0)]],
    'viscous_asymmetry': [[('Cva', 0.01, _SMALL, -1.0, 1.0)]],
    'load_friction': [[('Cl', 0.03, _SMALL, -0.3, 2.0)]],
    'viscous_drift': [[('r', 0.1, 2e-3, -0.95, 5.0), ('T', t, 0.1, 0.5, 60.0)]
                      for t in (3.0, 10.0)],
    'arm_viscous': [[('Cav', 0.003, _SMALL, -0.05, 2.0)]],
    'arm_coulomb': [[('Cac', 0.01, _SMALL, -0.2, 2.0)]],
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
_WAVES = {'gravity': 0.02, 'cogging': 0.02, 'torque_ripple': 0.03, 'mesh_error': 0.001,
          'motor_encoder_eccentricity': 0.004, 'arm_encoder_eccentricity': 0.004}


def probes(name: str, nominal: Nominal,
           recording: plant.MotionRecord) -> list[list[Row]]:
    """
    Return starting values of an effect.

    Args:
        name: its id.
        nominal: values of the drive.
        recording: u [N], y [N, 2], dt.

    Returns:
        Starts, each a list of (parameter, start, step, low, high).
    """
    if name in draw.REPLACES:
        key = draw.REPLACES[name]
        value = nominal[key]
        return [[(key, 1.03 * value, 1e-3 * value, 0.02 * value, 50.0 * value)]]
    if name == 'hardening':
        k3 = 0.1 * nominal['K'] ** 3 / np.mean(recording['u'] ** 2)
        return [[('K3', k3, 0.01 * k3, -3.0 * k3, 100.0 * k3)]]
    if name == 'saturation':
        peak = np.abs(recording['u']).max()
        return [[('umax', share * peak, 2e-3 * peak, 0.05 * peak, peak)]
                for share in (0.9, 0.7, 0.5)]
    if name not in _PROBES:  # of one parameter
        _, (key,), (low, high) = plant.EFFECTS[name]
        return [[(key, 3.0 * low, 0.01 * low, -high, 10.0 * high)]]
    return _PROBES[name]


def wave_effect(name: str, sine: float, cosine: float, n: int | None) -> dict[str, Any]:
    """
    Return a periodic effect.

    Args:
        name: its id.
        sine: amplitude of the sine.
        cosine: amplitude of the cosine.
        n: number of the harmonic, None for a wave of one turn.
    """
    out: dict[str, Any] = {
        'id': name, next(iter(plant.EFFECTS[name][1])): float(np.hypot(sine, cosine)),
        'phi': float(np.arctan2(cosine, sine))}
    return out if n is None else {**out, 'N': n}


class ImitatorCandidate:
    """A set of ids with starting values; `build` makes the model of a parameter vector."""

    def __init__(self, parts: Sequence[CandidatePart], nominal: Nominal) -> None:
        """Keep the `parts` of a model whose other values are `nominal`."""
        self.parts, self.nominal = list(parts), nominal
        rows = [row for _, table, _ in parts for row in table]
        self.start, self.step, self.low, self.high = (
            np.array([row[i] for row in rows], float) for i in (1, 2, 3, 4))
        self.ids = [name for name, _, _ in parts]

    def build(self, theta: Array) -> tuple[Nominal, list[dict[str, Any]]]:
        """Return (nominal, effects) of the parameter vector `theta` [P]."""
        effects: list[dict[str, Any]] = []
        k = 0
        for name, table, fixed in self.parts:
            values = {row[0]: float(theta[k + i]) for i, row in enumerate(table)}
            k += len(table)
            effects.append(wave_effect(name, values['sine'], values['cosine'], fixed)
                           if name in _WAVES else {'id': name, **values})
        return self.nominal, effects

    def joined(self, second: 'ImitatorCandidate') -> 'ImitatorCandidate':
        """Return the candidate with the effects of this one and of a `second`."""
        return ImitatorCandidate(self.parts + second.parts, self.nominal)

    def at(self, theta: Array) -> 'ImitatorCandidate':
        """Return the candidate started from `theta` [P]."""
        parts: list[CandidatePart] = []
        k = 0
        for name, table, fixed in self.parts:
            parts.append((name, [(row[0], float(theta[k + i]), row[2], row[3], row[4])
                                 for i, row in enumerate(table)], fixed))
            k += len(table)
        return ImitatorCandidate(parts, self.nominal)


def candidates(names: Sequence[str], nominal: Nominal,
               recording: plant.MotionRecord) -> list[ImitatorCandidate]:
    """
    Return candidates of single effects; periodic ones for each harmonic of 1 .. 40.

    Args:
        names: ids of the effects.
        nominal: values of the drive.
        recording: u [N], y [N, 2], dt.
    """
    out = []
    for name in names:
        if name in draw.QUANTISATION or name == 'disturbance':
            continue
        if name in _WAVES:
            size = _WAVES[name]
            wave: list[Row] = [('sine', size, 0.1 * size, -2.0, 2.0),
                               ('cosine', size, 0.1 * size, -2.0, 2.0)]
            out += [ImitatorCandidate([(name, wave, n)], nominal)
                    for n in (range(1, 41) if 'N' in plant.EFFECTS[name][1] else [None])]
            continue
        out += [ImitatorCandidate([(name, table, None)], nominal)
                for table in probes(name, nominal, recording)]
    return out


class Fitter:
    """Fits models to one `recording` with encoder noise `sigma` [2], rad."""

    def __init__(self, recording: plant.MotionRecord, sigma: Sequence[float] | Array) -> None:
        self.recording, self.sigma = recording, np.asarray(sigma, float)
        self.starts = window_fit.cut(len(recording['u']))
        self.measured = window_fit.pieces(recording['y'], self.starts)

    def runs(self, model: Model, lead: int = 0) -> WindowRuns:
        """Return the free runs of a `model`, which start at least `lead` samples earlier."""
        nominal, effects = model
        return WindowRuns(nominal, effects, self.recording, self.starts, window_fit.LENGTH,
                          window_fit.SUBSTEPS, lead)

    def back(self, states: Array, lead: int) -> Array:
        """Return the `states` [W, 4], extrapolated to `lead` samples earlier."""
        states = np.array(states)
        states[:, :2] -= lead * self.recording['dt'] * states[:, 2:]
        return states

    def states_columns(self, runs: WindowRuns, states: Array, predictions: Array) -> Array:
        """
        Return the sensitivity to the initial states by finite differences, in units of the noise.

        Args:
            runs: the model's free runs.
            states: initial states [W, 4].
            predictions: readings [W, L, 2] from these states, rad.

        Returns:
            Jacobian [W, 2 L, 4].
        """
        columns = np.empty((*predictions.shape, 4))
        for i, step in enumerate(window_fit.STEPS):
            moved = states.copy()
            moved[:, i] += step
            columns[..., i] = (runs.run(moved) - predictions) / step / self.sigma[:, None].T
        return np.nan_to_num(columns.reshape(len(states), -1, 4))

    def fit(self, candidate: ImitatorCandidate, states: Array,
            iterations: int = 10) -> tuple[float, Array, Array]:
        """
        Fit a candidate by Gauss-Newton with step control.

        Args:
            candidate: model and its starting values.
            states: first guess of the initial states [W, 4].
            iterations: at most so many.

        Returns:
            chi2, parameters [P] and initial states [W, 4].
        """
        lead = LEAD if any('encoder_delay' in i for i in candidate.ids) else 0
        theta, states = candidate.start.copy(), self.back(states, lead)
        runs = self.runs(candidate.build(theta), lead)
        states, chi2, predictions = window_fit.fit_states(
            runs, self.measured, self.sigma, states, 3)
        cost, damping, gained = chi2.sum(), 1e-3, 0.0
        for _ in range(iterations):
            memory = runs.memory.copy()
            jx = self.states_columns(runs, states, predictions)
            residual = ((self.measured - predictions) / self.sigma).reshape(len(states), -1)
            jt = np.empty((*residual.shape, len(theta)))
            for i, step in enumerate(candidate.step):
                moved = theta.copy()
                moved[i] += step if theta[i] + step <= candidate.high[i] else -step
                shifted = self.runs(candidate.build(moved), lead)
                shifted.memory[:] = memory
                jt[..., i] = ((shifted.run(states) - predictions) / (moved[i] - theta[i])
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
                new_states, new_chi2, new_found = window_fit.fit_states(
                    fresh, self.measured, self.sigma, np.where(
                        np.isfinite(moved), moved, states), 1)
                new = new_chi2.sum()
                if new < cost:
                    gained, cost, theta, states = cost - new, new, trial, new_states
                    chi2, predictions, runs, improved = new_chi2, new_found, fresh, True
                    damping *= 0.2
                    break
                damping = max(damping * 10.0, 1e-6)
            if not improved or gained < 0.5:
                break
        return float(cost), theta, self.back(states, -lead)

    def polish(self, candidate: ImitatorCandidate, alternatives: Sequence[Array]) -> float:
        """Return chi2 of the start of `candidate`, windows also tried from `alternatives`."""
        chi2, *_ = window_fit.fit_windows(*candidate.build(candidate.start), self.recording,
                                          self.sigma, alternatives=alternatives)
        return float(chi2.sum())

    def screen(self, many: Sequence[ImitatorCandidate], states: Array,
               base: Model | None = None) -> Array:
        """
        Return the gain in chi2 of each candidate by a linear fit of its sensitivity.

        Args:
            many: candidates [C].
            states: initial states [W, 4].
            base: model that they are added to; None: the nominal one.
        """
        nominal, effects = base if base is not None else (many[0].nominal, [])
        runs = self.runs((nominal, effects))
        states, _, predictions = window_fit.fit_states(
            runs, self.measured, self.sigma, states, 2)
        jx = self.states_columns(runs, states, predictions)
        q, _ = np.linalg.qr(jx)
        residual = np.nan_to_num(
            ((self.measured - predictions) / self.sigma).reshape(len(states), -1))
        residual -= np.einsum('wni,wmi,wm->wn', q, q, residual, optimize=True)
        gains: list[float] = []
        led: Array | None = None
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
                        led = self.runs((nominal, effects), LEAD).run(self.back(states, LEAD))
                    y = self.runs((nominal, [*effects, *extra]), LEAD).run(self.back(states, LEAD))
                    change = y - led
                else:
                    extended = self.runs((nominal, [*effects, *extra]))
                    extended.memory[:] = runs.memory
                    change = extended.run(states) - predictions
                column = np.nan_to_num((change / self.sigma).reshape(len(states), -1))
                columns.append(column - np.einsum('wni,wmi,wm->wn', q, q, column,
                                                  optimize=True))
            c = np.stack([v.ravel() for v in columns], axis=1)
            answer, *_ = np.linalg.lstsq(c, residual.ravel(), rcond=None)
            gains.append(float((residual ** 2).sum()
                               - ((residual.ravel() - c @ answer) ** 2).sum()))
        return np.array(gains)


def _best(many: Sequence[ImitatorCandidate], gains: Array,
          count: int) -> list[ImitatorCandidate]:
    """Return the `count` candidates of the largest gain, of each id two at most."""
    chosen: list[ImitatorCandidate] = []
    count_by_id: dict[str, int] = {}
    for i in np.argsort(-gains):
        key = many[i].ids[-1]
        if count_by_id.get(key, 0) < 2:
            count_by_id[key] = count_by_id.get(key, 0) + 1
            chosen.append(many[i])
        if len(chosen) == count:
            break
    return chosen


def best_imitator(label: Mapping[str, Any], recording: plant.MotionRecord,
                  reported: Model | None = None) -> dict[str, Any]:
    """
    Find the models without an effect that come closest to it.

    Args:
        label: what was drawn.
        recording: u [N], y [N, 2], dt.
        reported: model that a verdict describes, which may be the best imitator.

    Returns:
        left: twice the log likelihood ratio of the truth to the best imitator; evidence: the same
        for the nominal model; imitators: ids (or id+id) with about that likelihood.
    """
    sigma, nominal = np.array(label['sigma']), label['told']
    quantised = [e for e in label['effects'] if e['id'] in draw.QUANTISATION]
    if quantised or 'disturbance' in label['ids']:
        return {'left': None, 'imitators': [], 'why': 'no evidence to imitate'}
    # Only recordings of a torque come here: a servo has no part in them.
    names = [i for i in plant.EFFECTS if i not in label['ids'] and i not in label['exclude']
             and plant.place_of(i) != 'controller']
    fitter = Fitter(recording, sigma)
    true_states = np.array(label['states'])[:len(fitter.starts)]
    lead = plant.lead_of(label['effects'], recording['dt'])
    true, *_ = window_fit.fit_windows(label['truth'], label['effects'], recording, sigma,
                                      states=fitter.back(true_states, lead))
    none, states, _ = window_fit.fit_windows(nominal, [], recording, sigma,
                                             alternatives=(true_states,))
    many = candidates(names, nominal, recording)
    gains = fitter.screen(many, states)
    fits = []
    for candidate in _best(many, gains, FITTED):
        cost, theta, end_states = fitter.fit(candidate, states)
        fits.append((cost, candidate.at(theta), end_states))
    fits.sort(key=lambda f: f[0])
    for _, single, end_states in list(fits[:KEPT]):
        partners = [c for c in many if c.ids[0] not in single.ids
                    and draw.compatible(c.ids[0], single.ids[0])]
        if not partners:
            continue
        base = single.build(single.start)
        if any('encoder_delay' in i for i in single.ids):
            order = gains[[many.index(c) for c in partners]]
        else:
            order = fitter.screen(partners, end_states, base)
        for second in _best(partners, order, PAIRS):
            pair = single.joined(second)
            cost, theta, end = fitter.fit(pair, end_states, 6)
            fits.append((cost, pair.at(theta), end))
    fits.sort(key=lambda f: f[0])
    polished = []
    for cost, candidate, end_states in fits[:3]:
        chi2 = fitter.polish(candidate, (end_states, true_states))
        polished.append((min(cost, chi2), '+'.join(candidate.ids)))
    if reported is not None:
        reported_chi2, *_ = window_fit.fit_windows(*reported, recording, sigma,
                                                   alternatives=(true_states,))
        polished.append((float(reported_chi2.sum()), '+'.join(e['id'] for e in reported[1])))
    polished.sort()
    remaining = polished[0][0] - true.sum()
    imitators = [name for chi2, name in polished if chi2 - true.sum() <= remaining + 25.0]
    return {'left': float(remaining), 'evidence': float(none.sum() - true.sum()),
            'imitators': imitators}
