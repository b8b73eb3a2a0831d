# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What no effect explains, as a torque map, where the motor's measured motion is put in."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gearbox_monitor.identification import basis_functions, gauss_newton, likelihood
from gearbox_monitor.identification.candidates import CandidateModel, with_effects
from gearbox_monitor.identification.effect_scan import score_test
from gearbox_monitor.identification.free_functions import (
    FITTED, knots_over, map_of, with_map, WORDS)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.localisation import visible_places
from gearbox_monitor.identification.position import window_closure
from gearbox_monitor.identification.position.position_search import PositionSearch
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.windows import WindowRuns
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.torque_map import QUANTITIES

JAGGED = 0.03  # of the torque's standard deviation: what a probe has where contacts are jagged


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


def tables(search: PositionSearch, fitted: CandidateFit) -> list[Values]:
    """
    Return the tables of maps that the places of this drive allow, without values.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit whose motion stands in for an encoder that is missing.
    """
    positions = search.long.positions(fitted.candidate.model(fitted.point.z), fitted.point)
    recording = search.recording
    motor, arm = (basis_functions.motion(positions[:, order], recording.dt, recording.cuts)
                  for order in ([0, 1], [1, 0]))
    moved = {'speed of the motor': motor['speed'], 'speed of the arm': arm['speed'],
             'angle of the motor': arm['angle'], 'angle of the arm': motor['angle'],
             'twist': motor['twist'], 'torque': recording.torque,
             'time': np.arange(len(positions)) * recording.dt}
    places = visible_places(WindowRuns(search.long, fitted.candidate, fitted.point))
    rows = np.concatenate([np.arange(part.start, part.start + last)
                           for part, last in zip(recording.segments, search.last)])
    out: list[Values] = []
    for place, variable in QUANTITIES:
        if place in places:
            knots = knots_over(moved[WORDS[place, variable]][rows], variable)
            if len(knots) > 1:
                out.append({'place': place, 'variable': variable, 'knots': knots})
    return out


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
        start = point.at(np.concatenate([point.z, proposal.values]))
        fits.append(search.as_fitted(
            mapped, gauss_newton.robust_then_plain(data, mapped, start, (6, 6))))
    best = min(fits, key=lambda f: f.score, default=None)
    return best if best is not None and best.score < fitted.score else None


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
    chi2 = [window_closure.settled(search, f, [g.point]).point.chi2[held].sum()
            for f, g in ((fitted, base), (base, fitted))]
    return bool(chi2[0] < chi2[1])
