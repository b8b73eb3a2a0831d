# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Further effects of a fit: score tests, their gain in one linear step, and fits of the best.

Fits race on long steps by successive halving: many a little, few to the end. The angles between
signatures tell which effects a recording distinguishes.

Without an effect of the library, functions of the motion and memory of innovations are tested.
Both are score tests beside a fit, in columns from which the fit's own coordinates are taken out. A
function has a Gaussian prior: smooth over its knots, as large as is likeliest. Its price is the
Occam factor of its marginal likelihood.
"""
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
import math
from typing import TypeAlias

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import (
    CandidateModel, Coordinate, FREE_VALUE, NOT_FITTED, origin, PERIODIC, PHASED, probes, Starts,
    with_effects)
from gearbox_monitor.diagnosis.joint.drive_recordings import DriveRecordings
from gearbox_monitor.diagnosis.joint.innovations import (
    evaluated, FilteredFit, fitted, InnovationFit, JointLikelihood, Likelihood, remaining, Tested)
from gearbox_monitor.diagnosis.settings import THRESHOLDS
from gearbox_monitor.kernels.types import Array, Integers, Values
from gearbox_monitor.plant.effects import EFFECTS, MEMORIES
from gearbox_monitor.plant.effects.controller import SERVO_DELAY, SERVO_INTEGRATOR
from gearbox_monitor.plant.effects.torque_map import QUANTITIES, TORQUE_MAP

# Of the scale of a coordinate: so little that a nominal value that scatters and the effect that
# replaces it have the same column; less where a memory has to be there first; where a fit begins.
A_LITTLE, TINY, BEGUN = 1e-4, 1e-6, 1e-3
# Values of a servo that has a memory where they are not 0.
REMEMBERED = (SERVO_INTEGRATOR.id, SERVO_DELAY.id)


@dataclass(frozen=True)
class Proposal:
    """
    A further effect: id, order (of a periodic one) and number of the start of its fit.

    gain: in -2 log L of one linear step, or of the start itself; infinite for an effect that is
    not off where its fits begin, and has none. begins: where a fit may begin, as (coordinates of
    the effect, None: those of its start; change [P] of the coordinates of the fit).
    """

    name: str
    order: int | None
    number: int
    gain: float
    begins: tuple[tuple[Array | None, Array], ...]


def scan(likelihood: JointLikelihood, starts: Starts, fit: InnovationFit,
         ids: Iterable[str]) -> list[Proposal]:
    """
    Return a Proposal for each way in which an effect of `ids` may be added to `fit`, best first.

    Args:
        likelihood: of the recordings.
        starts: of the effects.
        fit: where the model stands.
        ids: effects to try.
    """
    tested = Tested.beside(likelihood, fit)
    return sorted((
        _proposal(tested, name, order, number, candidate)
        for name in ids if name not in fit.candidate.ids and name not in NOT_FITTED
        for order in (starts.orders if name in PERIODIC else (None,))
        for number, candidate in enumerate(starts.candidates(name, order))),
        key=lambda p: -p.gain)


def _proposal(tested: Tested, name: str, order: int | None, number: int,
              candidate: CandidateModel) -> Proposal:
    """Return the Proposal of the start `number` of an effect, the `candidate`, beside a fit."""
    at, likelihood = tested.at, tested.likelihood
    free = candidate.of(0)
    at_rest = origin(at.model, name, order)
    as_it_is = (None, np.zeros(len(at.z)))
    if at_rest and number:
        # All of its starts have one derivative; what they gain themselves is exact.
        (values,) = candidate.values(candidate.start())[1]
        trial = with_effects(at.model, [{'id': name, **values}])
        gain = at.run.deviance - likelihood.run(trial, at.torque).deviance
        return Proposal(name, order, number, gain, (as_it_is,))
    if not at_rest and name in MEMORIES and free[0].start != 0.0:
        return Proposal(name, order, number, math.inf, (as_it_is,))
    columns, sizes = signature(likelihood, at, candidate)
    gain, step, yielding = tested.step(columns)
    # The fit may have moved the values that the effect replaces.
    free = [replace(c, start=at_rest.get(c.name, c.start)) for c in free]
    start, taken = _started(name, free, step * sizes, bool(at_rest))
    rest = np.array([c.at(c.start) for c in free])
    stays = any(at_rest.values())
    begins = ((start, yielding @ (taken / sizes)), (rest if stays else start, as_it_is[1]))
    return Proposal(name, order, number, gain if math.isfinite(gain) else 0.0,
                    begins if stays or begins[0][1].any() else begins[:1])


def signature(likelihood: Likelihood, at: FilteredFit,
              candidate: CandidateModel) -> tuple[Array, Array]:
    """
    Return the changes [2 N, C] of whitened innovations by a little of one effect, and how much.

    Args:
        likelihood: of the recordings.
        at: fit beside which the effect is added.
        candidate: of this effect alone.

    Returns:
        A column for each direction in which the effect is linear, and its size [C] in the unit
        of the effect's first parameter.
    """
    name, model = candidate.ids[0], at.model
    free = candidate.of(0)
    at_rest, run = origin(model, name, candidate.orders.get(0)), at.run
    # A memory must be there before its tangent is.
    if at_rest.get(free[0].name) == 0.0 and name in REMEMBERED:
        run = likelihood.run(with_effects(model, [
            {'id': name, free[0].name: TINY * free[0].scale}]), at.torque)
    elif not at_rest and name in MEMORIES:
        run = likelihood.run(with_effects(model, [probes(candidate, TINY, {})[0][0]]), at.torque)
    effects, sizes = zip(*probes(candidate, A_LITTLE, at_rest))
    scale = 1.0 / np.sqrt(at.run.variance)
    columns = np.stack([(likelihood.change(run, with_effects(model, [effect])) * scale).ravel()
                        for effect in effects], axis=1)
    columns[~np.isfinite(columns)] = 0.0
    return columns, np.array(sizes)


def _started(name: str, free: Sequence[Coordinate], step: Array,
             replaces: bool) -> tuple[Array, Array]:
    """
    Return (coordinates of the effect after a linear `step` [C], how much of it was taken).

    Args:
        name: id of the effect.
        free: its coordinates.
        step: of its amplitude.
        replaces: whether its first coordinate is a value that the model has.
    """
    if name in PHASED:
        return np.array([c.start for c in free]) + step, step
    values, first = [c.start for c in free], free[0]
    taken = np.clip(step[:1], -first.scale, first.scale)
    at = first.start + float(taken[0])
    if first.start == 0.0:
        smallest = BEGUN * first.scale  # a memory that is off has no derivative
        at = math.copysign(max(abs(at), smallest), at)
        if not first.low <= at <= first.high:
            at = smallest if first.high > 0.0 else -smallest
    else:
        at = min(max(at, first.low), first.high) if replaces else first.start
    values[0] = at
    return (np.array([c.at(v) for c, v in zip(free, values)]),
            np.array([at - first.start]))


def joined(starts: Starts, fit: InnovationFit, proposal: Proposal) -> list[InnovationFit]:
    """
    Return `fit` with the effect of `proposal`, not evaluated, wherever its fit may begin.

    Args:
        starts: of the effects.
        fit: of the effects so far.
        proposal: the further effect.
    """
    single = starts.candidates(proposal.name, proposal.order)[proposal.number]
    out = []
    for start, change in proposal.begins:
        own = fit.candidate.bounded(fit.z + change)
        begin = single.start()
        if start is not None:
            begin[[c.owner == 0 for c in single.coordinates]] = start
        candidate = starts.joint([(fit.candidate, own), (single, begin)])
        out.append(InnovationFit(candidate, candidate.start_from(fit.candidate, own), fit.torque))
    return out


# Iterations of all; of further rounds, how many go on and iterations of each.
Rounds: TypeAlias = tuple[int, Sequence[tuple[int, int]]]
FIRST: Rounds = 1, ((9, 3), (4, 12))
FURTHER: Rounds = 2, ((6, 4), (3, 12))


def raced(evidence: DriveRecordings, fit: InnovationFit, proposals: Sequence[Proposal],
          score: Callable[[InnovationFit], float]) -> list[InnovationFit]:
    """
    Return `fit` with each of the effects proposed, fitted on long steps, best first.

    After the first round, one start of each effect and order goes on: other starts lead to the
    same optimum.

    Args:
        evidence: the recordings.
        fit: of the effects so far.
        proposals: further effects.
        score: of a fit; smaller is better.
    """
    first, rounds = FURTHER if fit.candidate.ids else FIRST
    with ThreadPoolExecutor(evidence.jobs) as pool:
        racing = list(pool.map(partial(_begun, evidence, fit, first), proposals))
        done: list[InnovationFit] = []
        for survivors, iterations in rounds:
            racing = _best_of_each(sorted(racing, key=score), by_order=True)
            done += racing[survivors:]
            racing = list(pool.map(partial(fitted, evidence.coarse, iterations=iterations),
                                   racing[:survivors]))
    return _best_of_each(sorted([*racing, *done], key=score))


def _begun(evidence: DriveRecordings, fit: InnovationFit, iterations: int, proposal: Proposal
           ) -> InnovationFit:
    """Return `fit` with a further effect, fitted from the likeliest point where it may begin."""
    begin = min((evaluated(evidence.coarse, trial)
                 for trial in joined(evidence.starts, fit, proposal)), key=lambda f: f.deviance)
    return fitted(evidence.coarse, begin, iterations)


def _best_of_each(ranked: Sequence[InnovationFit], by_order: bool = False) -> list[InnovationFit]:
    """
    Return the first of `ranked` fits of each name.

    Args:
        ranked: fits, best first.
        by_order: whether a periodic effect of another order counts as another one.
    """
    best: dict[object, InnovationFit] = {}
    for fit in ranked:
        orders = tuple(fit.candidate.orders.items()) if by_order else ()
        best.setdefault((fit.candidate.key, orders), fit)
    return list(best.values())


Separations: TypeAlias = dict[str, tuple[float, dict[str, float]]]


def twins(alone: bool) -> list[tuple[str, str]]:
    """
    Return the pairs of effects of which no motion distinguishes the first from the second.

    Args:
        alone: whether one encoder is read and the torque is recorded: a drive moves as late as its
            torque comes.
    """
    return [pair for name, effect in EFFECTS.items() for pair in (
        (name, effect.twin), *((name, effect.twin_alone), (effect.twin_alone, name)) * alone)
        if all(pair)]


def direction(candidate: CandidateModel, z: Array, owner: int, own: Array) -> Array:
    """
    Return the change [M, 1] towards no effect number `owner` of a candidate.

    Args:
        candidate: with the effect.
        z: its coordinates [P].
        owner: index of the effect in the candidate.
        own: changes by each coordinate [M, P].
    """
    name = candidate.ids[owner]
    at_rest = origin(candidate.nominal, name, candidate.orders.get(owner))
    total, has_coordinates = np.zeros(len(own)), False
    for k, c in enumerate(candidate.coordinates):
        if c.owner != owner:
            continue
        if name in EFFECTS and any(p.name == c.name and p.off_at_infinity
                                   for p in EFFECTS[name].parameters):
            total -= own[:, k]
        elif not c.log:
            total += own[:, k] * ((z[k] - at_rest.get(c.name, 0.0)) or c.scale)
        has_coordinates = True
    return total[:, None] if has_coordinates else np.zeros((len(own), 0))


def evidence_for(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
                 owner: int) -> float:
    """
    Return d: 2 log likelihood that the effect `owner` of `fit` gains.

    Args:
        evidence: the recordings.
        fit: with the effect.
        fits: all that were scored; the best of those without the effect is what it is against.
        owner: index of the effect in the candidate.
    """
    remaining = {name for i, name in enumerate(fit.candidate.ids) if i != owner}
    without = min((f for f in fits if set(f.candidate.ids) <= remaining), key=evidence.score)
    return float(without.deviance - fit.deviance)


def separations(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
                orders: Mapping[str, int]) -> Separations:
    """
    Return {id of `fit`: (d, {other id: s2})}: how much of its evidence others cannot imitate.

    The other effects of `fit` and nominal values (with their prior) give way.

    Args:
        evidence: the recordings.
        fit: that is reported.
        fits: all that were scored.
        orders: {id: N} of periodic effects.
    """
    candidate = fit.candidate
    owners = [i for i, name in enumerate(candidate.ids)
              if name not in (*NOT_FITTED, TORQUE_MAP.id)]
    if not owners:
        return {}
    tested = Tested.beside(evidence.fine, fit)
    names = [n for n in evidence.ids if n not in NOT_FITTED and n not in candidate.ids]
    signatures = {name: signature(
        evidence.fine, tested.at, evidence.starts.candidates(
            name, orders.get(name, 1) if name in PERIODIC else None)[0])[0] for name in names}
    out = {}
    for owner in owners:
        others = tested.own[:, [c.owner != owner for c in candidate.coordinates]]
        effect = remaining(direction(candidate, fit.z, owner, tested.own), others).sum(axis=1)
        total, beside = float(effect @ effect), replace(tested, own=others, residual=effect)
        out[candidate.ids[owner]] = evidence_for(evidence, fit, fits, owner), {
            name: max(0.0, 1.0 - beside.step(columns)[0] / total) if total else 1.0
            for name, columns in signatures.items()}
    return out


def rivals(evidence: DriveRecordings, fit: InnovationFit, fits: Sequence[InnovationFit],
           separation_table: Separations) -> dict[str, list[str]]:
    """
    Return {id of `fit`: ids that these recordings cannot distinguish from this effect}.

    A rival imitates all but a little of the evidence for the effect (generalised likelihood ratio)
    and its own fit does not lag behind by more; or the fit in which it replaces the effect lags by
    less, linear or not. An effect that both fits have in common has no rival by that.

    Args:
        evidence: the recordings.
        fit: that is reported.
        fits: all that were scored.
        separation_table: result of `separations`.
    """
    ids = fit.candidate.ids
    lag = {f.candidate.key: evidence.score(f) - evidence.score(fit) for f in fits}
    limit = THRESHOLDS.isolable
    if evidence.model.lasting:
        limit = max(limit, THRESHOLDS.isolable_share * lag.get((), 0.0))
    alone = evidence.model.controller is None and all(
        len(r.channels) == 1 for r in evidence.recordings)
    pairs = [*_imitators(ids, lag, separation_table), *_exchanged(ids, lag, limit),
             *(pair for pair in twins(alone) if pair[1] in evidence.ids)]
    out: dict[str, list[str]] = {name: [] for name in ids}
    for name, rival in pairs:
        if name in out and rival not in (*out[name], *ids, TORQUE_MAP.id):
            out[name].append(rival)
    return out


def _imitators(ids: Sequence[str], lag: Mapping[tuple[str, ...], float],
               separation_table: Separations) -> Iterator[tuple[str, str]]:
    """Yield (effect, another one that imitates its evidence), the nearest first."""
    for name, (d, table) in separation_table.items():
        for rival, s2 in sorted(table.items(), key=lambda item: item[1]):
            lags = len(ids) == 1 and lag.get((rival,), -math.inf) > THRESHOLDS.isolable
            if d * s2 < THRESHOLDS.isolable and not lags:
                yield name, rival


def _exchanged(ids: Sequence[str], lag: Mapping[tuple[str, ...], float], limit: float
               ) -> Iterator[tuple[str, str]]:
    """Yield (effect, another one) of fits in which that takes its place and lags by no `limit`."""
    for key, value in lag.items():
        if len(key) == len(ids) and value < limit and (len(ids) == 1 or set(key) & set(ids)):
            yield from product([name for name in ids if name not in key], key)


KNOTS = 10      # even: none stands at speed 0, where friction jumps
TAIL = 0.5      # percent of the samples beyond the outermost knots, on either end
BEND = 2.0      # speeds are closer about 0 by this power
SMOOTH = 2.0    # knots over which a function is smooth
SIZES = 10.0 ** np.arange(-4.0, 0.1, 0.5)  # of its prior over that of the torque: tried
LITTLE = 1e-4   # of the torque's standard deviation: what a probe has
MEMORY_SIZES = 10.0 ** np.arange(-3.0, 0.1, 0.25)  # of the coefficients of a memory: tried
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
        ones = np.ones(len(past))
        smooth = np.concatenate([scipy.linalg.solve_banded(
            (1, 0), [n * ones, (1.0 - n) * ones], past) * math.sqrt(2.0 * n - 1.0)
            for n in TIMES], axis=1)
        block = np.zeros((len(past), 2, 2 * smooth.shape[1]))
        for i in (0, 1):
            block[:, i, i * smooth.shape[1]:(i + 1) * smooth.shape[1]] = (
                smooth * run.read[:, i:i + 1])
        blocks.append(block.reshape(2 * len(past), -1))
    X = np.concatenate(blocks)
    X = tested.without(X[:, (X * X).sum(axis=0) > 0.0])
    _, _, gain, price = likeliest_values(
        X.T @ X, X.T @ tested.residual, MEMORY_SIZES, np.eye(X.shape[1]))
    return gain - price - 2.0 * math.log(len(MEMORY_SIZES))


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
