# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Two simultaneous effects on windows: forward selection, exchange and backward elimination.

Many proposals start on the beginnings of the windows, and the best of each round continue on
longer parts (successive halving).
"""
from collections.abc import Sequence
from functools import partial
from itertools import combinations
import math
from typing import TypeAlias

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood
from gearbox_monitor.identification.candidates import (
    CandidateModel, NOT_FITTED, ORDERS, PERIODIC)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.position import window_isolability
from gearbox_monitor.identification.position.position_search import PositionSearch
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS

# Proposals: by the linearised gain of a second effect over whole windows and over their beginnings
# (where a model that is far off still follows the readings), and of both over none.
TOP_FORWARD, TOP_BEGUN, TOP_SCREENED, TOP_SINGLE = 3, 5, 4, 3
TOP_ORDERS = 4  # where the motor is driven: what is made small is jagged, a gain tells no order
# The same on the other side: the torque of a motor whose motion is put in shows their sum.
SIDES = {name: effect.counterpart for name, effect in EFFECTS.items() if effect.counterpart}
EXCHANGED = 3
SETTLED = 4
RACE = ((0.25, 6), (0.5, 4), (1.0, 3))  # share of the windows fitted, pairs that go on from there
Gain: TypeAlias = tuple[float, int | None]
Started: TypeAlias = tuple[CandidateModel, likelihood.FitPoint]


def gains_beside(search: PositionSearch, data: likelihood.WindowData, candidate: CandidateModel,
                 point: likelihood.FitPoint) -> dict[str, list[Gain]]:
    """
    Return {id: [(linearised gain in chi2 of adding it, N), ..., best first]}, best first.

    Args:
        search: fits of all candidates to one recording.
        data: its windows, or their beginnings.
        candidate: effects so far.
        point: where its fit stands.
    """
    ids = [i for i in search.ids if i not in candidate.ids]
    gains: dict[str, list[Gain]] = {}
    for (name, order), gain in search.gains(data, candidate, point, ids, ORDERS).items():
        gains.setdefault(name, []).append((gain, order))
    for effect_gains in gains.values():
        effect_gains.sort(key=lambda g: -g[0])
    return dict(sorted(gains.items(), key=lambda item: -item[1][0][0]))


def _starts(search: PositionSearch, gains: dict[str, list[Gain]], name: str,
            orders: int = 1) -> list[CandidateModel]:
    """Return the starts of the effect `name` with its best `orders`."""
    return [start for _, order in gains[name][:orders]
            for start in search.starts.candidates(name, order)]


def find_pairs(search: PositionSearch, firsts: Sequence[str]) -> list[str]:
    """
    Fit pairs; they join search.fitted. Returns their names, best first.

    firsts: names of the single effects to which a second one is added; besides, the best pairs of
    a linearised search over all of them. Many start on the beginnings of the windows, few arrive
    at whole ones.
    """
    gains = {first: gains_beside(search, search.long, search.fitted[first].candidate,
                           search.fitted[first].point) for first in firsts}
    chosen = [*_raced(search, _proposed(search, gains)), *_joined(search, gains)]
    chosen = sorted({*chosen} & {*search.fitted},
                    key=lambda n: search.fitted[n].score)[:SETTLED]
    if not chosen:
        return []
    search.settle(chosen)
    best_pair = min((search.fitted[n] for n in chosen), key=lambda f: f.score)
    exchanged = _raced(search, _exchanged(search, best_pair))
    search.settle(list({best_pair.name, *exchanged} & set(search.fitted)))
    chosen = sorted({n for n in (*chosen, *exchanged) if n in search.fitted},
                    key=lambda n: search.fitted[n].score)
    _backward(search, search.fitted[chosen[0]])
    return chosen


def with_third(search: PositionSearch, pair: CandidateFit) -> CandidateFit | None:
    """
    Return the best fit of `pair` with one more effect on whole windows, None if none is left.

    From where the pair stands; it joins search.fitted.

    Args:
        search: fits of all candidates to one recording.
        pair: fit of two effects.
    """
    gains = gains_beside(search, search.long, pair.candidate, pair.point)
    thirds = [third for name in list(gains)[:TOP_FORWARD]
              for third in _starts(search, gains, name, TOP_ORDERS)]
    fits = search.map(lambda third: _extended(search, pair, third, third.start()), thirds,
                      'three effects')
    if not fits:
        return None
    best = min(fits, key=lambda f: f.score)
    return search.keep(best)


def _raced(search: PositionSearch, racing: list[Started]) -> list[str]:
    """
    Run pairs [(Candidate, FitPoint at its start on the beginnings)] against each other.

    Those that arrive join search.fitted where they are better; returns their names.
    """
    for share, survivors in RACE:
        data = likelihood.shortened(search.long, share)
        racing = search.map(partial(_run_on, data), racing, 'pairs')
        best_starts: dict[tuple[object, ...], Started] = {}
        # Of starts of one pair all windows tell: where an effect shows in few of them, all of its
        # starts are alike to the others.
        all_windows = np.ones(len(data.windows))
        for joint, point in sorted(racing,
                                   key=lambda r: likelihood.objective(r[0], r[1], all_windows)):
            best_starts.setdefault((joint.key, *sorted(joint.orders.values())), (joint, point))
        racing = sorted(best_starts.values(), key=lambda r: search.score(data, *r))[:survivors]
    return [search.keep_better(search.as_fitted(*r)).name for r in racing]


def _joined(search: PositionSearch, gains: dict[str, dict[str, list[Gain]]]) -> list[str]:
    """
    Fit pairs on whole windows at once; returns names.

    Of the best single effects from where they are, and of each first one with what it lacks most
    (`gains`). What shows in few windows, and late in them, does not count in a race over their
    beginnings.
    """
    singles = [search.fitted[name] for name in search.ranked()[:TOP_SINGLE]]
    jobs = [(first_fit, second_fit.candidate, second_fit.point.z)
            for first_fit, second_fit in combinations(singles, 2)]
    for first, effect_gains in gains.items():
        jobs += [(search.fitted[first], second, second.start())
                 for name in list(effect_gains)[:1]
                 for second in _starts(search, effect_gains, name)]
    return [search.keep_better(pair).name for pair in search.map(
        lambda job: _extended(search, *job), jobs, 'pairs')]


def _extended(search: PositionSearch, fitted: CandidateFit, added: CandidateModel,
              z: Array) -> CandidateFit:
    """Return the fit on whole windows of `fitted` with the effect `added`, which begins at `z`."""
    joint = search.starts.joint([(fitted.candidate, fitted.point.z), (added, z)])
    point = fitted.point.at(joint.start_from(fitted.candidate, fitted.point.z))
    return search.polish(search.as_fitted(joint, search.long.evaluate(joint, point)))


def _proposed(search: PositionSearch, forward: dict[str, dict[str, list[Gain]]]) -> list[Started]:
    """
    Return [(Candidate, FitPoint at its start on the beginnings of the windows)] of pairs.

    forward: {first effect: gains of a second one over whole windows}.
    """
    data = likelihood.shortened(search.long, RACE[0][0])
    jobs = []
    for first, whole in forward.items():
        fitted = search.fitted[first]
        base, point = fitted.candidate, _begun(search, data, fitted)
        for gains, top in ((whole, TOP_FORWARD),
                           (gains_beside(search, data, base, point), TOP_BEGUN)):
            names = list(gains)[:top]
            names += [n for n in map(SIDES.get, names) if n in gains and n not in names]
            for name in names:
                for second in _starts(search, gains, name, TOP_ORDERS):
                    joint = search.starts.joint([(base, point.z), (second, second.start())])
                    jobs.append((joint, point.at(joint.start_from(base, point.z))))
    none = _begun(search, data, search.fitted[''])
    for parts in _screened(search)[:TOP_SCREENED]:
        joint = search.starts.joint([(c, c.start()) for c in parts])
        jobs.append((joint, search.at_none(joint, none)))
    return jobs


def _begun(search: PositionSearch, data: likelihood.WindowData,
           fitted: CandidateFit) -> likelihood.FitPoint:
    """Return the FitPoint of `fitted` on `data`, the beginnings of the long windows."""
    point = data.evaluate(fitted.candidate, fitted.point)
    return gauss_newton.fit(data, fitted.candidate, point, 5, robust=True)


def _run_on(data: likelihood.WindowData, pair: Started) -> Started:
    """Fit a pair on `data`, the beginnings of the windows."""
    joint, point = pair
    return joint, gauss_newton.fit(data, joint, data.evaluate(joint, point), 6, robust=True,
                                   refresh=(0, 1, 2, 4))


def _screened(search: PositionSearch) -> list[tuple[CandidateModel, CandidateModel]]:
    """Return pairs of Candidates, best first by linearised gain at none."""
    data, base, point = search.long, search.fitted[''].candidate, search.fitted[''].point
    weight = likelihood.weights(data, point.chi2, True)
    s = likelihood.sensitivity(data, base, point)
    model = base.model(point.z)
    options = []
    for name in search.ids:
        if name in NOT_FITTED:
            continue
        for order in search.found_orders(name) if name in PERIODIC else [None]:
            for candidate, probe in zip(search.starts.candidates(name, order),
                                        search.probes(name, order)):
                options.append((candidate, probe))
    columns = search.map(
        lambda option: likelihood.effect_columns(data, model, point, option[1]), options, 'pairs')
    base_size = s.Jz.shape[2]
    S, g, _, _ = likelihood.normal_equations(
        likelihood.widened(s, np.concatenate(columns, axis=2)), point.residual, weight)
    _, prior = base.prior(point.z)
    S[range(base_size), range(base_size)] += prior
    places, at = [], base_size
    for _, effects in options:
        places.append(list(range(at, at + len(effects))))
        at += len(effects)
    best_gains: dict[tuple[str, ...], tuple[float, tuple[CandidateModel, CandidateModel]]] = {}
    for (i, (a, _)), (j, (b, _)) in combinations(enumerate(options), 2):
        if a.ids == b.ids:
            continue
        use = [*range(base_size), *places[i], *places[j]]
        gain = float(likelihood.damped_solve(S[np.ix_(use, use)], g[use], 1e-6) @ g[use])
        key = tuple(sorted((*a.ids, *b.ids)))
        if gain > best_gains.get(key, (-math.inf,))[0]:
            best_gains[key] = (gain, (a, b))
    return [parts for _, parts in sorted(best_gains.values(), key=lambda v: -v[0])]


def _exchanged(search: PositionSearch, pair: CandidateFit) -> list[Started]:
    """
    Return `pair` with one effect exchanged, as proposals for a race.

    For what imitates it best, what the other one lacks most, or another order of its own: on the
    way to a pair one effect had to bear what was the other's.
    """
    data = likelihood.shortened(search.long, RACE[0][0])
    separations = window_isolability.separations(search, pair)
    jobs = []
    for i, name in enumerate(pair.candidate.ids):
        kept_single = _alone(search, pair, 1 - i)
        base = kept_single.candidate
        point = data.evaluate(base, kept_single.point)
        gains = gains_beside(search, data, base, point)
        _, shares = separations[name]
        names = [*sorted(shares, key=shares.__getitem__)[:EXCHANGED],
                 *list(gains)[:EXCHANGED]]
        options = [(replacement, gains[replacement][0][1]) for replacement in dict.fromkeys(names)
                   if replacement != name and replacement in gains]
        if name in PERIODIC:
            at_pair = search.long.evaluate(base, kept_single.point)
            whole = search.gains(search.long, base, at_pair, [name], ORDERS)
            orders = [*(order for _, order in gains[name][:EXCHANGED]),
                      *sorted(ORDERS, key=lambda n: -whole[name, n])[:EXCHANGED]]
            options += [(name, order) for order in dict.fromkeys(orders)
                        if order != pair.candidate.orders[i]]
        for replacement, order in options:
            for second in search.starts.candidates(replacement, order):
                joint = search.starts.joint([(base, point.z), (second, second.start())])
                jobs.append((joint, point.at(joint.start_from(pair.candidate, pair.point.z))))
    return jobs


def _alone(search: PositionSearch, pair: CandidateFit, i: int) -> CandidateFit:
    """Return the effect number `i` of `pair` with its values and window states, not fitted."""
    single, z = search.starts.alone(pair.candidate, pair.point.z, i)
    none = search.fitted['']
    nominal = np.array([c.owner < 0 for c in single.coordinates])
    z = np.where(nominal, single.start_from(none.candidate, none.point.z), z)
    return CandidateFit(single, pair.point.at(z))


def _backward(search: PositionSearch, pair: CandidateFit) -> None:
    """Fit each effect of `pair` alone from where the pair ended: no pair by a local minimum."""
    for i in range(len(pair.candidate.ids)):
        single = _alone(search, pair, i)
        point = gauss_newton.fit(search.long, single.candidate, single.point, 4, robust=True)
        search.keep_better(search.polish(search.as_fitted(single.candidate, point)))
