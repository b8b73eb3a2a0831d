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

"""Two effects at once: where one leaves something, the pair that leaves least."""
from itertools import combinations
import math

import numpy as np

from gearbox_monitor.gap import fit as fitting
from gearbox_monitor.gap.candidate import NOT_FITTED, ORDERS, PERIODIC, with_effects

TOP_FORWARD, TOP_SCREENED, TOP_ORDERS = 3, 3, 4
# The same on the other side: the torque of a motor whose motion is put in shows their sum.
SIDES = {'motor_coulomb': 'arm_coulomb', 'motor_viscous': 'arm_viscous',
         'arm_coulomb': 'motor_coulomb', 'arm_viscous': 'motor_viscous'}


def forward_gains(search, fitted):
    """Return {id: (linearised gain in chi2, N)} of adding each effect to `fitted`."""
    return {name: gains[0] for name, gains in _forward(search, fitted).items()}


def _forward(search, fitted):
    """Return {id: [(linearised gain in chi2 of adding it to `fitted`, N), ..., best first]}."""
    ids = [i for i in search.ids if i not in fitted.candidate.ids]
    found = search.gains(search.long, fitted.candidate, fitted.point, ids, ORDERS)
    gains = {}
    for (name, order), gain in found.items():
        gains.setdefault(name, []).append((gain, order))
    return {name: sorted(some, key=lambda g: -g[0]) for name, some in gains.items()}


def find_pairs(search, firsts):
    """
    Fit pairs; they join search.fitted. Returns their names, best first.

    firsts: names of the single effects to which a second one is added; besides, the best pairs of
    a linearised search over all of them.
    """
    jobs = {}
    for first in firsts:
        fitted = search.fitted[first]
        gains = _forward(search, fitted)
        # A linearised gain tells no order from its neighbour where what is made small is jagged.
        tried = 1 if search.recording.motor is None else TOP_ORDERS
        names = sorted(gains, key=lambda n: -gains[n][0][0])[:TOP_FORWARD]
        if search.recording.motor is not None:
            names += [n for n in map(SIDES.get, names) if n in gains and n not in names]
        for name in names:
            for second in [c for _, order in gains[name][:tried]
                           for c in search.starts.candidates(name, order)]:
                joint = search.starts.joint([(fitted.candidate, fitted.point.z),
                                             (second, second.start())])
                jobs.setdefault(_key(joint.ids), []).append((joint, fitted.point, None))
    for parts in _screened(search)[:TOP_SCREENED]:
        joint = search.starts.joint([(c, c.start()) for c in parts])
        jobs.setdefault(_key(joint.ids), []).append((joint, None, search.short_none))
    rough = search.map(lambda job: _rough(search, *job), [j for g in jobs.values() for j in g],
                       'pairs')
    by_pair = {}
    for fitted in rough:
        key = _key(fitted.candidate.ids)
        if key not in by_pair or fitted.score < by_pair[key].score:
            by_pair[key] = fitted
    chosen = sorted(by_pair.values(), key=lambda f: f.score)[:3]
    if not chosen:
        return []
    if search.recording.motor is not None:
        ids = chosen[0].candidate.ids
        sides = [by_pair.get(_key([SIDES.get(n, n) if n == i else n for n in ids])) for i in ids]
        chosen += [f for f in sides if f is not None and f not in chosen]
    grown = search.map(search.grown, chosen, 'pairs')
    search.fitted.update((f.name, min(f, g, key=lambda f: f.score))
                         for f, g in zip(chosen, grown))
    search.settle([f.name for f in chosen])
    chosen = [search.fitted[f.name] for f in chosen]
    _backward(search, min(chosen, key=lambda f: f.score))
    return sorted((f.name for f in chosen), key=lambda n: search.fitted[n].score)


def _key(ids):
    return tuple(sorted(ids))


def _rough(search, joint, long_point, short_point):
    """Fit a pair roughly, from a fit of its first effect or from none on short windows."""
    if short_point is not None:
        point = search.at_none(joint, short_point)
        fitting.fit(search.short, joint, point, 8, robust=True, refresh=(0, 2, 4, 6))
        point = search.to_long(joint, point)
        fitting.fit(search.long, joint, point, 3, robust=True)
    else:
        point = fitting.copied(long_point, _with_nuisances(search, joint, long_point))
        fitting.fit(search.long, joint, point, 5, robust=True, refresh=(0, 2, 4))
    return search.as_fitted(joint, point)


def _with_nuisances(search, joint, point):
    z, n = joint.start(), sum(c.owner < 0 for c in joint.coordinates)
    fewer = min(n, len(point.z))
    if n:
        names = [c.name for c in search.fitted[''].candidate.coordinates]
        known = dict(zip(names, point.z[:fewer]))
        for i, c in enumerate(joint.coordinates[:n]):
            z[i] = known.get(c.name, 0.0)
    return z


def _screened(search):
    """Return pairs of Candidates, best first by linearised gain at none on short windows."""
    data, base = search.short, search.fitted[''].candidate
    point = search.short_none
    weight = fitting.weights(data, point.chi2, True)
    s = fitting.sensitivity(data, base, point)
    model = base.model(point.z)
    options = []
    for name in search.ids:
        if name in NOT_FITTED:
            continue
        for order in search.found_orders(name) if name in PERIODIC else [None]:
            for candidate, columns in zip(search.starts.candidates(name, order),
                                          search.probes(name, order)):
                options.append((candidate, [{'id': name, **c} for c in columns]))
    columns = search.map(
        lambda e: point.residual - data.residual(
            with_effects(model, [*model.effects, e]), point.states, point.memory)[0],
        [e for _, es in options for e in es], 'pairs')
    known = s.Jz.shape[2]
    joint = fitting.Sensitivity(s.Jx, np.concatenate(
        [s.Jz, np.stack(columns, axis=2)], axis=2))
    S, g, _, _ = fitting.normal_equations(joint, point.residual, weight)
    _, prior = base.prior(point.z)
    S[range(known), range(known)] += prior
    places, at = [], known
    for _, effects in options:
        places.append(list(range(at, at + len(effects))))
        at += len(effects)
    found = {}
    for (i, (a, _)), (j, (b, _)) in combinations(enumerate(options), 2):
        if a.ids == b.ids:
            continue
        use = [*range(known), *places[i], *places[j]]
        gain = float(fitting.damped_solve(S[np.ix_(use, use)], g[use], 1e-6) @ g[use])
        key = _key((*a.ids, *b.ids))
        if gain > found.get(key, (-math.inf,))[0]:
            found[key] = (gain, (a, b))
    return [parts for _, parts in sorted(found.values(), key=lambda v: -v[0])]


def _backward(search, pair):
    """Fit each effect of `pair` alone from where the pair ended: no pair by a local minimum."""
    for i, name in enumerate(pair.candidate.ids):
        keep = [c for c in pair.candidate.coordinates if c.owner in (-1, i)]
        z = [v for c, v in zip(pair.candidate.coordinates, pair.point.z) if c.owner in (-1, i)]
        alone = next(iter(search.starts.candidates(name, pair.candidate.orders.get(i))))
        own = [c for c in alone.coordinates if c.owner == 0]
        point = search.at_none(alone, search.fitted[''].point)
        values = {c.name: v for c, v in zip(keep, z) if c.owner == i}
        start = len(alone.coordinates) - len(own)
        for k, c in enumerate(own):
            point.z[start + k] = values[c.name]
        point.states = pair.point.states.copy()
        fitting.fit(search.long, alone, point, 4, robust=True)
        found = search.polish(search.as_fitted(alone, point))
        search.fitted[name] = min(found, search.fitted[name], key=lambda f: f.score)
