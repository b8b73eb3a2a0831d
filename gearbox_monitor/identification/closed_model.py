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
How far the gap closes: on windows that were not fitted, with an interval, and what is known of it.

gap: root mean square of the readings against free runs of 1 s, in standard deviations of the
encoders; each window has its own best start. Its floor is 1.

before, after: gap before and after. sigma [2]: noise of the encoders, rad.
"""
from collections.abc import Sequence
from dataclasses import replace
import math
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood, window_states
from gearbox_monitor.identification.candidates import Candidate, NOT_FITTED, PERIODIC, PHASED, ZERO
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.localisation import labels
from gearbox_monitor.identification.noise_model import spectrum
from gearbox_monitor.identification.process_noise import left_of
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.shooting import N_MEMORY, ShootingWindows
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MEMORIES
from gearbox_monitor.quality.recording import UniformRecording

VISIBLE = 1.02     # gap before, from which on a closed fraction means something
FOLDS = 5
DRAWS = 2000
COVERAGE = (5.0, 95.0)  # percentiles
# Standard deviation of log sigma, measured above the frequencies of motion, beyond that of the
# root mean square of all n readings: times 1 / sqrt(n).
SIGMA_ERROR = 0.3
Figures: TypeAlias = dict[str, dict[str, float | None] | None]  # of channels, of bins
Windowed: TypeAlias = tuple[Search, Candidate, likelihood.FitPoint]


def gap_of(chi2: Array, size: int) -> float:
    """Return the gap of windows with chi2 [W] over `size` readings each."""
    return float(math.sqrt(np.mean(chi2) / size))


def closed_of(before: float, after: float) -> float | None:
    """Return the closed fraction, None where there was no gap to speak of."""
    return (before - after) / (before - 1.0) if before >= VISIBLE else None


def published(search: Search, none: CandidateFit,
              best: CandidateFit | None = None) -> likelihood.FitPoint:
    """Return the FitPoint of the model as published: only window states fitted."""
    if not none.candidate.coordinates:
        return none.point
    candidate = Candidate(search.model, (), ())
    point = likelihood.FitPoint(np.zeros(0), none.point.states.copy(), none.point.memory.copy())
    if search.recording.motor is not None:
        # No state of a window holds the zero of the encoders, which nobody knows.
        candidate = replace(candidate, coordinates=tuple(
            c for c in none.candidate.coordinates if c.name == ZERO))
        point = gauss_newton.fit(search.long, candidate, replace(point, z=candidate.start()), 6)
    every = np.arange(len(search.long.windows))
    point.states, _ = window_states.solve_states(
        search.long, candidate.model(point.z), point.states, point.memory, every)
    search.long.evaluate(candidate, point)
    others = [none.point] + ([best.point] if best else [])
    window_states.rescue(search.long, candidate, point, others, half_gap=search.half_gap)
    return point


def settled(search: Search, fitted: CandidateFit,
            others: Sequence[likelihood.FitPoint]) -> CandidateFit:
    """
    Return `fitted` with the states of the held-out windows where they fit best.

    The search looks at the training windows: others may have been left in a wrong contact.
    """
    data, candidate = search.long, fitted.candidate
    held = np.flatnonzero(~data.train)
    if not len(held) or set(candidate.ids) & set(NOT_FITTED):
        return fitted
    model, point = candidate.model(fitted.point.z), likelihood.copied(fitted.point)
    known = [point, *others, *(search.fitted[n].point for n in search.ranked()[:4])]
    index = np.tile(held, len(known))
    states, chi2 = window_states.solve_states(
        data, model, np.concatenate([k.states[held] for k in known]), point.memory[index], index)
    chi2 = chi2.reshape(len(known), -1)
    best = chi2.argmin(axis=0)
    better = chi2.min(axis=0) < point.chi2[held]
    chosen = states.reshape(len(known), -1, 4)[best, np.arange(len(held))]
    point.states[held[better]] = chosen[better]
    data.evaluate(candidate, point)
    window_states.rescue(data, candidate, point, known, half_gap=search.half_gap)
    point.states[data.train] = fitted.point.states[data.train]
    data.evaluate(candidate, point)
    return replace(fitted, point=point)


def closure(search: Search, none: CandidateFit, best: CandidateFit | None = None,
            seed: int = 0) -> dict[str, Any]:
    """
    Return how far the CandidateFit `best` (None: none) closes the gap, as plain data.

    gap_before (model as published), gap_after, closed_fraction on the held-out windows;
    closed_fraction_ci [low, high], 90 %; channels, regions: {name: {before, after, closed}};
    standard_errors {id: {parameter}}, condition of the scaled normal matrix, at_bound [names].
    """
    before = published(search, none, best)
    fitted = settled(search, best or none, [before])
    if not none.candidate.coordinates and best is not None:
        before = settled(search, none, [fitted.point]).point
    held = ~search.long.train
    if not held.any():
        held = ~held
    size = before.residual.shape[1]
    gaps = gap_of(before.chi2[held], size), gap_of(fitted.point.chi2[held], size)
    repeatable = not set(fitted.candidate.ids) & set(NOT_FITTED)
    fraction = closed_of(*gaps) if best is not None and repeatable else None
    interval = None
    if fraction is not None:
        readings = len(search.long.channels) * len(search.recording.u)
        interval = _interval(before.chi2 / size, left_out(search, fitted) / size,
                             _noise(search, fitted), readings, np.random.default_rng(seed))
        # It judges all windows, the fraction the held-out ones.
        interval = [min(interval[0], fraction), max(interval[1], fraction)]
    errors, condition = standard_errors(search, fitted) if repeatable else ({}, None)
    channels, regions = _parts(search, none, before.residual, fitted.point.residual, held)
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'floor': 1.0,
            'closed_fraction': fraction, 'closed_fraction_ci': interval,
            'channels': channels, 'regions': regions, 'standard_errors': errors,
            'condition': condition, 'at_bound': fitted.candidate.at_bound(fitted.point.z)}


def left_out(search: Search, fitted: CandidateFit) -> Array:
    """
    Return chi2 [W] of all long windows under coordinates that were fitted without them.

    Interleaved folds; each takes one linearised step from where the fit ended.
    """
    data, candidate, point = search.long, fitted.candidate, fitted.point
    if not len(point.z) or fitted.white is not None:
        # With torque noise in the likelihood, a step without it would lead elsewhere.
        return point.chi2
    s = likelihood.sensitivity(data, candidate, point)
    pull, prior = candidate.prior(point.z)
    fold = np.arange(len(data.windows)) % min(FOLDS, len(data.windows))
    chi2 = point.chi2.copy()
    for k in np.unique(fold):
        used = (fold != k).astype(float)
        if not used.any():
            continue
        S, g, X, x = likelihood.normal_equations(s, point.residual, used)
        dz = likelihood.damped_solve(S + np.diag(prior), g - pull, 1e-9)
        z = candidate.bounded(point.z + dz)
        trials = []
        for states in (point.states + x - np.einsum('wij,j->wi', X, z - point.z), point.states):
            trial = likelihood.FitPoint(z, states, point.memory)
            trials.append(data.evaluate(candidate, trial).chi2)
        moved = np.minimum(*trials)
        if used @ moved < used @ point.chi2 * (1.0 + 1e-3):  # else the step was no fit
            chi2[fold == k] = moved[fold == k]
    return chi2


def _noise(search: Search, fitted: CandidateFit) -> Array:
    """Return the power [W] of what `fitted` leaves above the frequencies of motion, mean 1."""
    power, _, high = spectrum(search.long.parted(fitted.point.residual), search.recording.dt)
    noise = power[:, high].mean(axis=(1, 2))
    return noise / noise.mean()


def _interval(before: Array, after: Array, noise: Array, readings: int,
              random: np.random.Generator) -> list[float]:
    """
    Return [low, high] of the closed fraction; before, after [W]: chi2 per reading.

    noise [W]: power of the encoders' noise in the windows. sigma is measured in them as well: what
    is drawn of it moves gap and sigma alike.
    """
    count = len(before)
    draw = random.integers(0, count, (DRAWS, count))
    sigma = np.exp(random.standard_normal(DRAWS) * SIGMA_ERROR / math.sqrt(readings))
    sigma /= np.sqrt(noise[draw].mean(axis=1))
    gap0 = np.sqrt(before[draw].mean(axis=1)) * sigma
    gap1 = np.sqrt(after[draw].mean(axis=1)) * sigma
    closed = (gap0 - gap1) / np.maximum(gap0 - 1.0, 1e-3)
    middle = np.median(closed)
    # Resampling few windows understates their scatter.
    closed = middle + (closed - middle) * math.sqrt(count / max(count - 1.0, 1.0))
    return np.percentile(closed, COVERAGE).tolist()


def _parts(search: Search, none: CandidateFit, before: Array, after: Array,
           held: Flags) -> tuple[Figures, dict[str, Figures]]:
    """Return ({channel: figures}, {region: {bin: figures}}) of residuals [W, C L] in `held`."""
    before = search.long.parted(before[held]) ** 2
    after = search.long.parted(after[held]) ** 2

    def figures(use: Flags) -> dict[str, float | None] | None:
        if not use.any():
            return None
        gaps = [float(math.sqrt(power[use].mean())) for power in (before, after)]
        return {'before': gaps[0], 'after': gaps[1], 'closed': closed_of(*gaps)}
    channels = {}
    for i, name in enumerate(np.array(search.recording.readings)[search.long.channels].tolist()):
        use = np.zeros(before.shape, bool)
        use[:, :, i] = True
        channels[name] = figures(use)
    regions = {}
    for name, (bins, label) in labels(search, none).items():
        label = label[held]
        regions[name] = {b: figures(label == k) for k, b in enumerate(bins)}
    return channels, regions


def standard_errors(search: Search,
                    fitted: CandidateFit) -> tuple[dict[str, dict[str, float]], float | None]:
    """
    Return ({id: {parameter: standard error}}, condition of the scaled normal matrix).

    Linearised, window states and nominal values free; scaled by the misfit where it is above 1.
    """
    candidate, point, data = fitted.candidate, fitted.point, search.long
    if not len(point.z):
        return {}, None
    s = likelihood.sensitivity(data, candidate, point)
    left, whiten = left_of(data, fitted)
    S, _, _, _ = likelihood.normal_equations(
        s, point.residual, data.train.astype(float), whiten)
    S = S + np.diag(candidate.prior(point.z)[1])
    scale = 1.0 / np.sqrt(np.maximum(np.diag(S), 1e-300))
    scaled = S * scale[:, None] * scale
    condition = float(np.linalg.cond(scaled))
    misfit = max(1.0, float((left[data.train] ** 2).mean()))
    covariance = misfit * scale[:, None] * scale * np.linalg.pinv(scaled, rcond=1e-13)
    out = {}
    for i, name in enumerate(candidate.ids):
        own = [k for k, c in enumerate(candidate.coordinates) if c.owner == i]
        part = covariance[np.ix_(own, own)]
        if name in PHASED:
            a = point.z[own]
            size = max(float(np.hypot(*a)), 1e-300)
            along, across = a / size, np.array([-a[1], a[0]]) / size
            out[name] = {'A': _root(along @ part @ along),
                         'phi': _root(across @ part @ across) / size}
            if name in PERIODIC:
                out[name]['N'] = 0.0  # a whole number, found by search
            continue
        out[name] = {}
        for k, variance in zip(own, np.diag(part)):
            c = candidate.coordinates[k]
            factor = math.exp(point.z[k]) if c.log else 1.0
            out[name][c.name] = factor * _root(variance)
    return out, condition


def _root(variance: Any) -> float:
    return float(math.sqrt(max(variance, 0.0)))


def validate(recording: UniformRecording, before: DriveModel, after: DriveModel,
             sigma: Array) -> dict[str, Any]:
    """
    Return how two DriveModels do on a Recording that was used for nothing else.

    {'gap_before', 'gap_after', 'closed_fraction', 'windows', 'free_run': {'seconds', 'before',
    'after': {'motor' or 'torque', 'arm': rms over the whole recording}}}; None: the run diverges.
    """
    recording = driven(recording, before)
    fits = [windowed(recording, model, sigma) for model in (before, after)]
    cross(fits)
    gaps = [gap_of(point.chi2, point.residual.shape[1]) for _, _, point in fits]
    runs = []
    for search, _, point in fits:
        off = rms(recording, free_run(search, search.model, point))
        runs.append({name: float(v) if np.isfinite(v) else None
                     for name, v in zip(recording.readings, off)})
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'closed_fraction': closed_of(*gaps),
            'windows': len(fits[0][2].chi2),
            'free_run': {'seconds': float(recording.duration), 'before': runs[0],
                         'after': runs[1]}}


def windowed(recording: UniformRecording, model: DriveModel, sigma: Array) -> Windowed:
    """Return (Search, Candidate, FitPoint) of `model` on all windows, only their states fitted."""
    search = Search(recording, replace(model, tolerance=0.0, process_torque_time=0.0), sigma, [])
    none = search.none()
    return search, none.candidate, none.point


def cross(fits: Sequence[Windowed]) -> None:
    """Give both models each other's window states, and memories from the window before."""
    known = [likelihood.copied(point) for _, _, point in fits]
    for k, (search, candidate, point) in enumerate(fits):
        data, every = search.long, np.arange(len(search.long.windows))
        if search.model.transmission.kind in ('play', 'passive_play') or any(
                e['id'] in MEMORIES for e in search.model.effects):
            for _ in range(2):
                point.memory = likelihood.carried(point.memory, point.carry)
                point.states, _ = window_states.solve_states(
                    data, search.model, point.states, point.memory, every)
                data.evaluate(candidate, point)
        window_states.rescue(data, candidate, point, [known[1 - k]], half_gap=search.half_gap)


def free_run(search: Search, model: DriveModel, point: likelihood.FitPoint) -> Array:
    """Return the readings [N, 2] of one run of `model` from the states of the first window."""
    n = len(search.recording.u)
    whole = ShootingWindows(np.zeros(1, int), n, np.zeros(1, int), np.full(1, n))
    y, _ = search.simulator.run(whole, model, point.states[:1], np.zeros((1, N_MEMORY)))
    return y[0]


def rms(recording: UniformRecording, y: Array) -> Array:
    """Return [2] rad, rms of the recording against y [N, 2]; NaN: diverges, or no such encoder."""
    with np.errstate(over='ignore', invalid='ignore'):
        found = np.sqrt(np.mean((recording.y - y) ** 2, axis=0))
    found[[i for i in (0, 1) if i not in recording.channels]] = np.nan
    return np.where(np.isfinite(found), found, np.nan)
