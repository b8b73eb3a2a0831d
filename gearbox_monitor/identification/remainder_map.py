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
What no effect explains, as a torque map: a gap closes even where its cause has no name.

A score test (Rao) of free functions of each quantity of the motion, beside the coordinates of a
fit, chooses what the torque depends on; the best ones are fitted like an effect. A map counts only
if it explains readings that it was not fitted to.
"""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.identification import closed_model, gauss_newton, likelihood
from gearbox_monitor.identification.candidates import (
    CandidateModel, Coordinate, FREE_VALUE, with_effects)
from gearbox_monitor.identification.effect_scan import score_test
from gearbox_monitor.identification.innovation_fit import (
    coordinate_columns, evaluated, fitted as likeliest_fit, InnovationFit)
from gearbox_monitor.identification.innovations import InnovationLikelihood
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.localisation import visible_places
from gearbox_monitor.identification.position_search import PositionSearch
from gearbox_monitor.identification.residual_dependence import motion_of
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.smoothed_windows import training_spans
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.torque_map import QUANTITIES, TORQUE_MAP

KNOTS = 10      # even: none stands at speed 0, where friction jumps
TAIL = 0.5      # percent of the samples beyond the outermost knots, on either end
BEND = 2.0      # speeds are closer about 0 by this power
FITTED = 2      # maps that are fitted
# Of the torque's standard deviation: what a probe has; where contacts are jagged.
LITTLE, JAGGED = 1e-4, 0.03
MEASURED = {('motor_side', 'speed'): 'speed of the motor', ('arm_side', 'speed'):
            'speed of the arm', ('motor_side', 'angle'): 'angle of the motor',
            ('arm_side', 'angle'): 'angle of the arm', ('transmission', 'twist'): 'twist',
            ('motor_side', 'torque'): 'torque'}


@dataclass(frozen=True)
class MapProposal:
    """A map by its table (place, variable, knots), its gain in one linear step, its values."""

    table: Values
    gain: float
    values: Array


@dataclass(frozen=True)
class MapTest:
    """
    A fit as a score test sees it: residual [M] in its standard deviations, its own columns [M, P].

    model: where the fit stands; change(model): change [M] of the residual under another model.
    """

    candidate: CandidateModel
    z: Array
    residual: Array
    own: Array
    change: Callable[[Values], Array]


def tables(search: Search, fitted: CandidateFit) -> list[Values]:
    """
    Return the tables of maps that the places of this drive allow, without values.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit whose motion stands in for an encoder that is missing.
    """
    positions = search.long.positions(fitted.candidate.model(fitted.point.z), fitted.point)
    moved, places = motion_of(search, positions), visible_places(search)
    moved['time'] = np.arange(len(positions)) * search.recording.dt
    rows = np.concatenate([np.arange(span.start, span.stop) for span in training_spans(search)])
    out: list[Values] = []
    for place, variable in QUANTITIES:
        if place in places:
            knots = _knots(moved[MEASURED.get((place, variable), 'time')][rows], variable)
            if len(knots) > 1:
                out.append({'place': place, 'variable': variable, 'knots': knots})
    return out


def _knots(x: Array, variable: str) -> list[float]:
    """Return the knots of a map over the values `x` [N]: as close as they are, or about 0."""
    if variable == 'speed':
        share = np.linspace(-1.0, 1.0, KNOTS)
        knots = np.percentile(np.abs(x), 100.0 - TAIL) * np.sign(share) * np.abs(share) ** BEND
    else:
        knots = np.percentile(x, np.linspace(TAIL, 100.0 - TAIL, KNOTS))
    far = np.concatenate([[True], np.diff(knots) > 1e-6 * max(float(np.ptp(knots)), 1e-12)])
    return [float(k) for k in knots[far]]


def proposals(test: MapTest, choices: Sequence[Values], size: float) -> list[MapProposal]:
    """
    Return a MapProposal for each table, the one with the largest gain first.

    Args:
        test: the fit beside which maps are tried.
        choices: tables of maps.
        size: of the torque in a probe, N m.
    """
    prior = test.candidate.prior(test.z)
    out = []
    for table in choices:
        columns = np.stack([test.change(map_of(table, size * row)) / size
                            for row in np.eye(len(table['knots']))], axis=1)
        columns[~np.isfinite(columns)] = 0.0
        gain, step = score_test(test.own, prior, columns, test.residual)
        out.append(MapProposal(table, gain - len(step) * np.log(len(test.residual)), step))
    return sorted(out, key=lambda p: -p.gain)


def map_of(table: Values, values: Array) -> Values:
    """Return the effect torque_map with `values` [K] (N m) at the knots of `table`."""
    return {'id': TORQUE_MAP.id, **table, 'values': [float(v) for v in values],
            'deviations': [0.0] * len(values)}


def with_map(candidate: CandidateModel, table: Values, scale: float) -> CandidateModel:
    """
    Return `candidate` with a torque map whose values are coordinates.

    Args:
        candidate: effects so far.
        table: of the map.
        scale: usual torque, N m; a weak prior that holds values of which no reading tells.
    """
    owner = len(candidate.ids)
    return replace(
        candidate, ids=(*candidate.ids, TORQUE_MAP.id),
        tables={**candidate.tables, owner: table}, coordinates=(*candidate.coordinates, *(
            Coordinate(owner, f'{FREE_VALUE}{k}', 0.0, 0.1 * scale, prior=scale)
            for k in range(len(table['knots'])))))


def on_measured_motion(search: PositionSearch, fitted: CandidateFit) -> CandidateFit | None:
    """
    Return `fitted` with the map that leaves least of the training windows, None for no gain.

    Args:
        search: fits of all candidates, driven by the measured motion of the motor.
        fitted: fit that is to be improved.
    """
    data, point, candidate = search.long, fitted.point, fitted.candidate
    train, scale = data.train, search.starts.scales.torque
    residual = point.residual[train].ravel()
    model = candidate.model(point.z)

    def change(effect: Values) -> Array:
        """Return the change of the residual by a map."""
        r, _ = data.residual(with_effects(model, [effect]), point.states, point.memory)
        moved: Array = r[train].ravel() - residual
        return moved
    own = -likelihood.coordinate_sensitivity(data, candidate, point)[train].reshape(
        len(residual), -1)
    ranked = proposals(MapTest(candidate, point.z, residual, own, change),
                       tables(search, fitted), JAGGED * scale)
    fits = []
    for proposal in [p for p in ranked if p.gain > 0.0][:FITTED]:
        mapped = with_map(candidate, proposal.table, scale)
        begun = point.at(np.concatenate([point.z, proposal.values]))
        fits.append(search.as_fitted(
            mapped, gauss_newton.robust_then_plain(data, mapped, begun, (6, 6))))
    best = min(fits, key=lambda f: f.score, default=None)
    return best if best is not None and best.score < fitted.score else None


def by_innovations(search: Search, fitted: CandidateFit, fit: InnovationFit,
                   filter_: InnovationLikelihood) -> InnovationFit | None:
    """
    Return `fit` with the map of the largest likelihood, None for no gain in BIC.

    Args:
        search: fits of all candidates to one recording.
        fitted: the same fit on windows.
        fit: where the innovations of the training parts are likeliest.
        filter_: likelihood of these parts.
    """
    candidate, scale = fit.candidate, search.starts.scales.torque
    at = evaluated(filter_, candidate, fit.z, fit.torque)
    model, deviation = candidate.model(fit.z), np.sqrt(at.run.trace.variance)

    def change(effect: Values) -> Array:
        """Return the change of the whitened innovations by a map."""
        moved: Array = (filter_.change(at.run, with_effects(model, [effect])) / deviation).ravel()
        return moved
    ranked = proposals(
        MapTest(candidate, fit.z, at.run.residual.ravel(), coordinate_columns(filter_, at),
                change), tables(search, fitted), LITTLE * scale)
    fits = []
    for proposal in [p for p in ranked if p.gain > 0.0][:FITTED]:
        mapped = with_map(candidate, proposal.table, scale)
        begun = InnovationFit(mapped, np.concatenate([fit.z, proposal.values]), fit.torque)
        fits.append(likeliest_fit(filter_, begun, 8))
    cost = np.log(filter_.readings)
    best = min(fits, key=lambda f: f.deviance + f.candidate.n_effect * cost, default=None)
    if best is None or fit.deviance - best.deviance < cost * (
            best.candidate.n_effect - candidate.n_effect):
        return None
    return best


def closer_on_unseen(search: Search, fitted: CandidateFit, base: CandidateFit) -> bool:
    """
    Return whether `fitted` leaves less than `base` on the windows that are held out.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        base: fit of a simpler model.
    """
    held = ~search.long.train
    if not held.any():
        return True
    chi2 = [closed_model.settled(search, f, [g.point]).point.chi2[held].sum()
            for f, g in ((fitted, base), (base, fitted))]
    return bool(chi2[0] < chi2[1])
