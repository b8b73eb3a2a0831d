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
How far a closed model reduces the misfit on windows that were not fitted, with an interval.

The misfit is the root mean square of the readings against free runs of 1 s, in standard deviations
of the encoder noise; each window starts from its own best state. Its floor is 1.
"""
from collections.abc import Sequence
from dataclasses import replace
import math
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood, window_states
from gearbox_monitor.identification.candidates import (
    CandidateModel, NOT_FITTED, PERIODIC, ZERO)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.localisation import labels
from gearbox_monitor.identification.noise_model import spectrum
from gearbox_monitor.identification.position_search import PositionSearch
from gearbox_monitor.identification.process_noise import noise_weighted_residual
from gearbox_monitor.identification.search import Search, SETTLING
from gearbox_monitor.identification.shooting import N_MEMORY, ShootingWindows
from gearbox_monitor.identification.smoothed_windows import fit_none
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.identification.torque_domain import driven
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import MEMORIES
from gearbox_monitor.quality.recording import UniformRecording

FOLDS = 5
DRAWS = 2000
COVERAGE = (5.0, 95.0)  # percentiles
# Standard deviation of log sigma, measured above the frequencies of motion, beyond that of the
# root mean square of all n readings: times 1 / sqrt(n).
SIGMA_ERROR = 0.3
Figures: TypeAlias = dict[str, dict[str, float | None] | None]  # of channels, of bins
Windowed: TypeAlias = tuple[Search, CandidateModel, likelihood.FitPoint]


def gap_of(chi2: Array, size: int) -> float:
    """Return the gap of windows with chi2 [W] over `size` readings each."""
    return float(math.sqrt(np.mean(chi2) / size))


def closed_of(gap_before: float, gap_after: float) -> float | None:
    """
    Return the closed fraction, None where there was no gap to speak of.

    Args:
        gap_before: misfit of the nominal model, in standard deviations.
        gap_after: misfit of the closed model, in standard deviations.
    """
    return (gap_before - gap_after) / (gap_before - 1.0) if gap_before >= THRESHOLDS.gap else None


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
    if not len(validation) or set(candidate.ids) & set(NOT_FITTED):
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


def closure(search: Search, none: CandidateFit, fitted: CandidateFit | None = None,
            seed: int = 0) -> dict[str, Any]:
    """
    Return how far the CandidateFit `best` (None: none) closes the gap, as plain data.

    gap_before (model as published), gap_after, closed_fraction on the held-out windows;
    closed_fraction_ci [low, high], 90 %; channels, regions: {name: {before, after, closed}};
    standard_errors {id: {parameter}}, condition of the scaled normal matrix, at_bound [names].

    Args:
        search: fits of all candidates to one recording.
        none: fit without effects.
        fitted: fit on the long windows.
        seed: seed of the random numbers.
    """
    published_point = published(search, none, fitted)
    settled_fit = settled(search, fitted or none, [published_point])
    if not none.candidate.coordinates and fitted is not None:
        published_point = settled(search, none, [settled_fit.point]).point
    validation = ~search.long.train
    if not validation.any():
        validation = ~validation
    size = published_point.residual.shape[1]
    gaps = gap_of(published_point.chi2[validation],
                  size), gap_of(settled_fit.point.chi2[validation], size)
    repeatable = not set(settled_fit.candidate.ids) & set(NOT_FITTED)
    fraction = closed_of(*gaps) if fitted is not None and repeatable else None
    interval = None
    if fraction is not None:
        readings = len(search.long.channels) * len(search.recording.u)
        interval = _interval(published_point.chi2 / size, left_out(search, settled_fit) / size,
                             _noise(search, settled_fit), readings, np.random.default_rng(seed))
        # It judges all windows, the fraction the held-out ones.
        interval = [min(interval[0], fraction), max(interval[1], fraction)]
    errors, condition = standard_errors(search, settled_fit) if repeatable else ({}, None)
    channels, regions = _parts(search, none, published_point.residual, settled_fit.point.residual,
                               validation)
    return {'gap_before': gaps[0], 'gap_after': gaps[1], 'floor': 1.0, 'closed_fraction': fraction,
            'closed_fraction_ci': interval, 'channels': channels, 'regions': regions,
            'standard_errors': errors, 'condition': condition,
            'at_bound': settled_fit.candidate.at_bound(settled_fit.point.z)}


def left_out(search: Search, fitted: CandidateFit) -> Array:
    """
    Return chi2 [W] of all long windows under coordinates that were fitted without them.

    Interleaved folds; each takes one linearised step from where the fit ended.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
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


def _interval(chi2_before: Array, chi2_after: Array, noise: Array, readings: int,
              random: np.random.Generator) -> list[float]:
    """
    Return [low, high] of the closed fraction; before, after [W]: chi2 per reading.

    noise [W]: power of the encoders' noise in the windows. sigma is measured in them as well: what
    is drawn of it moves gap and sigma alike.
    """
    count = len(chi2_before)
    draw = random.integers(0, count, (DRAWS, count))
    sigma = np.exp(random.standard_normal(DRAWS) * SIGMA_ERROR / math.sqrt(readings))
    sigma /= np.sqrt(noise[draw].mean(axis=1))
    gap0 = np.sqrt(chi2_before[draw].mean(axis=1)) * sigma
    gap1 = np.sqrt(chi2_after[draw].mean(axis=1)) * sigma
    closed = (gap0 - gap1) / np.maximum(gap0 - 1.0, 1e-3)
    middle = np.median(closed)
    # Resampling few windows understates their scatter.
    closed = middle + (closed - middle) * math.sqrt(count / max(count - 1.0, 1.0))
    return np.percentile(closed, COVERAGE).tolist()


def _parts(search: Search, none: CandidateFit, residual_before: Array, residual_after: Array,
           validation: Flags) -> tuple[Figures, dict[str, Figures]]:
    """Return ({channel: figures}, {region: {bin: figures}}) of residuals [W, C L] in `held`."""
    residual_before = search.long.parted(residual_before[validation]) ** 2
    residual_after = search.long.parted(residual_after[validation]) ** 2

    def figures(use: Flags) -> dict[str, float | None] | None:
        """Return the misfits of the readings of the mask `use`, None if it is empty."""
        if not use.any():
            return None
        gaps = [float(math.sqrt(power[use].mean())) for power in (residual_before, residual_after)]
        return {'before': gaps[0], 'after': gaps[1], 'closed': closed_of(*gaps)}
    channels = {}
    for i, name in enumerate(np.array(search.recording.readings)[search.long.channels].tolist()):
        use = np.zeros(residual_before.shape, bool)
        use[:, :, i] = True
        channels[name] = figures(use)
    regions = {}
    for name, (bins, label) in labels(search, none).items():
        label = label[validation]
        regions[name] = {b: figures(label == k) for k, b in enumerate(bins)}
    return channels, regions


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
    # The order of a periodic effect is a whole number, identified by search.
    out = {name: {'N': 0.0} if name in PERIODIC else {} for name in candidate.ids}
    for c, error, z in zip(candidate.coordinates, errors, point.z):
        if c.owner >= 0:
            out[candidate.ids[c.owner]][candidate.parameter(c)] = float(
                error * (math.exp(z) if c.log else 1.0))
    return out, condition


def validate(recording: UniformRecording, nominal: DriveModel, closed: DriveModel,
             sigma: Array) -> dict[str, Any]:
    """
    Return how two DriveModels do on a Recording that was used for nothing else.

    {'gap_before', 'gap_after', 'closed_fraction', 'windows', 'free_run': {'seconds', 'before',
    'after': {'motor' or 'torque', 'arm': rms from the first window on}}}; None: the run diverges.

    Args:
        recording: recording of the drive.
        nominal: model before the diagnosis.
        closed: model with the effects that were identified.
        sigma: noise of the encoders [2], rad.
    """
    recording = driven(recording, nominal)
    fits = crossed([windowed(recording, model, sigma) for model in (nominal, closed)])
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


def windowed(recording: UniformRecording, model: DriveModel, sigma: Array,
             settling: float = SETTLING) -> Windowed:
    """
    Return (Search, Candidate, FitPoint) of `model` on all windows, only their states fitted.

    Args:
        recording: recording of the drive.
        model: model of the drive.
        sigma: noise of the encoders [2], rad.
        settling: s at the beginning that no window reads where the torque drives the model.
    """
    plain = replace(model, tolerance=0.0, process_torque_time=0.0,
                    controller=model.controller and replace(model.controller, tolerance=0.0))
    if recording.motor is not None:
        by_position = PositionSearch(recording, plain, sigma, [])
        none = by_position.none()
        return by_position, none.candidate, none.point
    search = Search(recording, plain, sigma, [], settling=settling)
    none = fit_none(search)
    return search, none.candidate, none.point


def crossed(fits: Sequence[Windowed]) -> list[Windowed]:
    """
    Return both models with the better of each other's window states, and memories handed over.

    Args:
        fits: fits of the two models, both over the same windows.
    """
    out = []
    for k, (search, candidate, point) in enumerate(fits):
        if search.model.transmission.kind in ('play', 'passive_play') or any(
                e['id'] in MEMORIES for e in search.model.effects):
            for _ in range(2):
                point = window_states.solved(search.long, candidate, replace(
                    point, memory=likelihood.carried(point.memory, point.carry)))
        out.append((search, candidate, window_states.rescue(
            search.long, candidate, point, [fits[1 - k][2]], half_gap=search.half_gap)))
    return out


def free_run(search: Search, model: DriveModel, point: likelihood.FitPoint) -> Array:
    """
    Return the readings [N, 2] of one run of `model` from the first window on, NaN before it.

    Args:
        search: fits of all candidates to one recording.
        model: model of the drive.
        point: where the fit stands: coordinates, window states and memories.
    """
    n, begin = len(search.recording.u), search.long.windows.begin[:1]
    whole = ShootingWindows(begin, n - int(begin[0]), begin, np.full(1, n))
    y, _ = search.long.simulator.run(whole, model, point.states[:1], np.zeros((1, N_MEMORY)))
    return np.concatenate([np.full((int(begin[0]), 2), np.nan), y[0]])


def rms(recording: UniformRecording, y: Array) -> Array:
    """Return [2] rad, rms of the recording against a free run; NaN: diverges, or not read."""
    begin = int(np.isfinite(y).any(axis=1).argmax())
    with np.errstate(over='ignore', invalid='ignore'):
        deviation = np.sqrt(np.mean((recording.y[begin:] - y[begin:]) ** 2, axis=0))
    deviation[[i for i in (0, 1) if i not in recording.channels]] = np.nan
    return np.where(np.isfinite(deviation), deviation, np.nan)
