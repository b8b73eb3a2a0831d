# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Free functions of the motion: what no effect of the library describes.

A torque at one place as a function of one quantity, linear between knots. A score test (Rao) of
each, beside the coordinates of a fit, tells whether the fit lacks anything that depends on the
motion; the leading ones can be fitted like an effect, as a torque map. The motion is that of the
filter, whose state before a reading knows nothing of the reading's noise.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, Coordinate, FREE_VALUE, with_effects)
from gearbox_monitor.diagnosis.joint.effect_scan import score_test
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    coordinate_columns, evaluated, FilteredFit, fitted, InnovationFit)
from gearbox_monitor.diagnosis.joint.innovations import JointLikelihood
from gearbox_monitor.diagnosis.joint.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.torque_map import QUANTITIES, TORQUE_MAP

KNOTS = 10      # even: none stands at speed 0, where friction jumps
TAIL = 0.5      # percent of the samples beyond the outermost knots, on either end
BEND = 2.0      # speeds are closer about 0 by this power
FITTED = 2      # functions that are fitted
ITERATIONS = 8  # of such a fit
LITTLE = 1e-4   # of the torque's standard deviation: what a probe has
WORDS = {('motor_side', 'speed'): 'speed of the motor', ('arm_side', 'speed'):
         'speed of the arm', ('motor_side', 'angle'): 'angle of the motor',
         ('arm_side', 'angle'): 'angle of the arm', ('transmission', 'twist'): 'twist',
         ('motor_side', 'torque'): 'torque', ('motor_side', 'time'): 'time',
         ('arm_side', 'time'): 'time'}


@dataclass(frozen=True)
class Dependence:
    """
    A free function at `place` of the quantity `over`, tested beside a fit.

    gain: in -2 log L of one linear step; price: what the function that gains most exceeds by
    chance with the probability THRESHOLDS.chance; table: of the torque map (place, variable,
    knots); values [K] at its knots, N m.
    """

    place: str
    over: str
    gain: float
    price: float
    table: Values
    values: Array

    @property
    def beyond_chance(self) -> bool:
        """Whether it gains more than the best of all functions does by chance."""
        return self.gain > self.price


def dependences(likelihood: JointLikelihood, at: FilteredFit,
                places: Sequence[str]) -> list[Dependence]:
    """
    Return the free functions at `places`, tested beside a fit, the one of the largest gain first.

    Args:
        likelihood: of the recordings.
        at: fit whose filter was run.
        places: at which a torque can act in this drive.
    """
    rows, model = [part.motion(own) for part, own in zip(likelihood.parts, at.run.runs)], at.model
    moved = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    tested = score_test(coordinate_columns(likelihood, at), at.candidate.prior(at.z),
                        at.run.residual.ravel())
    scale = 1.0 / np.sqrt(at.run.variance)
    size = LITTLE * max(float(np.std(moved['torque'])), 1e-9)
    choices = [(place, variable, knots_over(moved[WORDS[place, variable]], variable))
               for place, variable in QUANTITIES if place in places]
    choices = [choice for choice in choices if len(choice[2]) > 1]
    out = []
    for place, variable, knots in choices:
        table = {'place': place, 'variable': variable, 'knots': knots}
        columns = np.stack([
            (likelihood.change(at.run, with_effects(model, [map_of(table, size * row)]))
             * scale).ravel() / size for row in np.eye(len(knots))], axis=1)
        columns[~np.isfinite(columns)] = 0.0
        gain, step, _ = tested(columns)
        price = float(scipy.special.chdtri(len(knots), THRESHOLDS.chance / len(choices)))
        out.append(Dependence(place, WORDS[place, variable], gain if np.isfinite(gain) else 0.0,
                              price, table, step))
    return sorted(out, key=lambda d: d.price - d.gain)


def knots_over(x: Array, variable: str) -> list[float]:
    """Return the knots of a map over the values `x` [N]: as close as they are, or about 0."""
    if variable == 'speed':
        share = np.linspace(-1.0, 1.0, KNOTS)
        knots = np.percentile(np.abs(x), 100.0 - TAIL) * np.sign(share) * np.abs(share) ** BEND
    else:
        knots = np.percentile(x, np.linspace(TAIL, 100.0 - TAIL, KNOTS))
    distinct = np.concatenate([[True], np.diff(knots) > 1e-6 * max(float(np.ptp(knots)), 1e-12)])
    return [float(k) for k in knots[distinct]]


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


def mapped(likelihood: JointLikelihood, fit: InnovationFit, places: Sequence[str],
           scale: float) -> InnovationFit | None:
    """
    Return `fit` with the torque map of the largest likelihood, None for no gain in BIC.

    Args:
        likelihood: of the recordings.
        fit: where the innovations are likeliest without a map.
        places: at which a torque can act in this drive.
        scale: usual torque, N m.
    """
    at = evaluated(likelihood, fit)
    cost = float(np.log(likelihood.readings))
    fits = []
    for dependence in dependences(likelihood, at, places)[:FITTED]:
        candidate = with_map(fit.candidate, dependence.table, scale)
        start = InnovationFit(candidate, np.concatenate([fit.z, dependence.values]), fit.torque)
        fits.append(fitted(likelihood, start, ITERATIONS))
    closest = min(fits, key=lambda f: f.deviance + f.candidate.n_effect * cost, default=None)
    if closest is None or fit.deviance - closest.deviance < cost * (
            closest.candidate.n_effect - fit.candidate.n_effect):
        return None
    return closest
