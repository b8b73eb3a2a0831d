# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Tests without an effect of the library: functions of the motion, and memory of innovations.

Both are score tests beside a fit, in columns from which the fit's own coordinates are taken out.
A function has a Gaussian prior: smooth over its knots, as large as is likeliest. Its price is the
Occam factor of its marginal likelihood.
"""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, Coordinate, FREE_VALUE, with_effects)
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    FilteredFit, InnovationFit, remaining, Tested)
from gearbox_monitor.diagnosis.joint.innovations import JointLikelihood
from gearbox_monitor.kernels.types import Array, Integers, Values
from gearbox_monitor.plant.effects.torque_map import QUANTITIES, TORQUE_MAP

KNOTS = 10      # even: none stands at speed 0, where friction jumps
TAIL = 0.5      # percent of the samples beyond the outermost knots, on either end
BEND = 2.0      # speeds are closer about 0 by this power
SMOOTH = 2.0    # knots over which a function is smooth
SIZES = 10.0 ** np.arange(-4.0, 0.1, 0.5)  # of its prior over that of the torque: tried
LITTLE = 1e-4   # of the torque's standard deviation: what a probe has
MEMORIES = 10.0 ** np.arange(-3.0, 0.1, 0.25)  # deviations of the coefficients of a memory: tried
TIMES = (1, 4, 16, 64, 256)  # samples over which innovations may be remembered
SEGMENTS = 10   # parts of the recordings between which effects may differ
RANK = 1e-6     # of the largest eigenvalue: columns that act in a segment
WORDS = {('motor_side', 'speed'): 'speed of the motor', ('arm_side', 'speed'):
         'speed of the arm', ('motor_side', 'angle'): 'angle of the motor',
         ('arm_side', 'angle'): 'angle of the arm', ('transmission', 'twist'): 'twist',
         ('motor_side', 'torque'): 'torque', ('motor_side', 'time'): 'time',
         ('arm_side', 'time'): 'time'}


@dataclass(frozen=True, eq=False)
class FreeFunction:
    """
    A function without a law, tested beside a fit.

    table: of the torque map (place, variable, knots); values [K] at its knots, N m; gain in
    -2 log L; occam: its price.
    """

    table: Values
    values: Array
    gain: float
    occam: float

    @property
    def place(self) -> str:
        """Location class; what follows the command is the actuator's."""
        return 'actuator' if self.table['variable'] == 'torque' else str(self.table['place'])

    @property
    def over(self) -> str:
        """Quantity of the motion."""
        return WORDS[self.table['place'], self.table['variable']]


def functions_beside(tested: Tested, places: Sequence[str], torque: float
                     ) -> tuple[tuple[FreeFunction, ...], float]:
    """
    Return functions beside a fit, those that pay most first, and the dispersion that they show.

    Beside a fit with a function there are none.

    Args:
        tested: the fit.
        places: at which a torque can act in this drive.
        torque: its usual size, N m.
    """
    likelihood, residual = tested.likelihood, tested.residual
    if tested.at.candidate.tables:
        return (), _dispersion(likelihood, [tested.own], residual)
    functions, blocks = [], []
    for table, columns in _columns(likelihood, tested.at, places):
        X = tested.without(columns)
        values, _, gain, price = likeliest_values(
            X.T @ X, X.T @ residual, SIZES * torque, correlation(X.shape[1]))
        functions.append(FreeFunction(table, -values, gain, price))
        blocks.append(X)
    dispersion = _dispersion(likelihood, blocks, residual)
    return tuple(sorted(functions, key=lambda f: f.occam - f.gain / dispersion)), dispersion


def _columns(likelihood: JointLikelihood, at: FilteredFit,
             places: Sequence[str]) -> Iterable[tuple[Values, Array]]:
    """Yield (table, derivatives [2 N, K] by its values) of each function."""
    rows = [part.motion(own) for part, own in zip(likelihood.parts, at.run.runs)]
    moved = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    scale = 1.0 / np.sqrt(at.run.variance)
    size = LITTLE * max(float(np.std(moved['torque'])), 1e-9)
    for place, variable in QUANTITIES:
        knots = knots_over(moved[WORDS[place, variable]], variable)
        if place not in places or len(knots) < 2:
            continue
        table = {'place': place, 'variable': variable, 'knots': knots}
        columns = np.stack([
            (likelihood.change(at.run, with_effects(at.model, [map_of(table, size * row)]))
             * scale).ravel() / size for row in np.eye(len(knots))], axis=1)
        columns[~np.isfinite(columns)] = 0.0
        yield table, columns


def _dispersion(likelihood: JointLikelihood, blocks: Sequence[Array], residual: Array) -> float:
    """
    Return the ratio by which parts of the recordings differ more than noise explains.

    In a right model, a value of its own for each part gains one by chance, beyond the common
    value. Gains beyond that are no evidence for an effect of all parts.
    """
    segment = _segments(likelihood)
    residual = residual[:len(segment)]
    excess = freedom = 0.0
    for X in (block[:len(segment)] for block in blocks):
        gains, ranks = -_explained(X, residual)[0], -X.shape[1]
        for s in range(segment.max() + 1):
            gain, rank = _explained(X[segment == s], residual[segment == s])
            gains, ranks = gains + gain, ranks + rank
        excess, freedom = excess + max(gains, 0.0), freedom + max(ranks, 0)
    return max(1.0, excess / max(freedom, 1.0))


def _explained(X: Array, r: Array) -> tuple[float, int]:
    """Return (gain of the columns X in these rows, number of columns that act in them)."""
    values, vectors = np.linalg.eigh(X.T @ X)
    use = values > RANK * max(float(values[-1]), 1e-300)
    return float(((vectors.T @ (X.T @ r))[use] ** 2 / values[use]).sum()), int(use.sum())


def _segments(likelihood: JointLikelihood) -> Integers:
    """Return the number of the segment [2 N] of each reading."""
    each = max(2, round(SEGMENTS / len(likelihood.parts)))
    return np.concatenate([np.repeat(each * number + part.shares(each), 2)
                           for number, part in enumerate(likelihood.parts)])


def occam(likelihood: JointLikelihood, fit: InnovationFit, torque: float) -> float:
    """
    Return the Occam factor of the function in a fit, and what its prior says of its values.

    Where it was fitted, not where it was tested: free torque that has gone weighs no longer.

    Args:
        likelihood: of the recordings.
        fit: with a function.
        torque: its usual size, N m.
    """
    c, own = fit.candidate, Tested.beside(likelihood, fit).own
    mine = np.array([x.owner in c.tables for x in c.coordinates])
    own = np.delete(own, len(own) - len(mine) + np.flatnonzero(mine), axis=0)
    X = remaining(own[:, mine], own[:, ~mine])
    S, v, K = X.T @ X, fit.z[mine], correlation(int(mine.sum()))
    return min(float(v @ S @ np.linalg.solve(M, v)) + float(np.linalg.slogdet(M)[1])
               for M in (np.eye(len(v)) + size ** 2 * K @ S for size in SIZES * torque))


def memory(tested: Tested) -> float:
    """
    Return what a linear memory of past innovations is worth beside a fit, in -2 log L.

    Innovations of a right model are white: where they foretell each other, the model misses
    dynamics, or the noise is coloured (Ljung 16.6; Breusch 1978 and Godfrey 1978).

    Args:
        tested: the fit.
    """
    blocks = []
    for run in tested.at.run.runs:
        past = np.concatenate([np.zeros((1, 2)), run.residual[:-1]])
        smooth = np.concatenate([scipy.signal.lfilter(
            [1.0 / n], [1.0, 1.0 / n - 1.0], past, axis=0) * math.sqrt(2.0 * n - 1.0)
            for n in TIMES], axis=1)
        block = np.zeros((len(past), 2, 2 * smooth.shape[1]))
        for i in (0, 1):
            block[:, i, i * smooth.shape[1]:(i + 1) * smooth.shape[1]] = (
                smooth * run.read[:, i:i + 1])
        blocks.append(block.reshape(2 * len(past), -1))
    X = np.concatenate(blocks)
    X = tested.without(X[:, (X * X).sum(axis=0) > 0.0])
    _, _, gain, price = likeliest_values(
        X.T @ X, X.T @ tested.residual, MEMORIES, np.eye(X.shape[1]))
    return gain - price - 2.0 * math.log(len(MEMORIES))


def knots_over(x: Array, variable: str) -> list[float]:
    """Return the knots of a map over a variable `x` [N]: as close as it is, or about 0."""
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
        scale: usual torque, N m: a weak prior that holds values which no reading determines.
    """
    owner = len(candidate.ids)
    return replace(
        candidate, ids=(*candidate.ids, TORQUE_MAP.id),
        tables={**candidate.tables, owner: table}, coordinates=(*candidate.coordinates, *(
            Coordinate(owner, f'{FREE_VALUE}{k}', 0.0, 0.1 * scale, prior=scale)
            for k in range(len(table['knots'])))))


def likeliest_values(gram: Array, pull: Array, sizes: Array,
                     shape: Array) -> tuple[Array, Array, float, float]:
    """
    Return (values [K], their covariance [K, K], gain in chi2, its price).

    The values have a Gaussian prior of the size under which the data are likeliest; the price is
    the Occam factor of that likelihood.

    Args:
        gram: information [K, K] about the values.
        pull: [K] of the data on them.
        sizes: deviations of the prior, tried.
        shape: correlation [K, K] of the prior.
    """
    out = []
    for size in sizes:
        C = size ** 2 * shape
        M = np.eye(len(pull)) + C @ gram
        values = np.linalg.solve(M, C @ pull)
        out.append((values, np.linalg.solve(M, C), float(pull @ values),
                    float(np.linalg.slogdet(M)[1])))
    return max(out, key=lambda row: row[2] - row[3])


def correlation(count: int) -> Array:
    """Return the prior correlation [K, K] of the values of a function at `count` knots."""
    return np.exp(-np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / SMOOTH)
