# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Isolability: which effects a recording can distinguish, by the angles between their signatures.

The signature of an effect is the change of the readings by a little of it, less what window states
and nominal values can imitate. With evidence d for an effect (generalised likelihood ratio),
another effect that leaves the share s2 of its signature is indistinguishable unless d s2 is more
than THRESHOLDS.isolable.
"""
from collections.abc import Iterable
import math

import numpy as np

from gearbox_monitor.identification import likelihood
from gearbox_monitor.identification.candidates import NOT_FITTED, PERIODIC
from gearbox_monitor.identification.isolability import (
    direction, remove, Separations, share_left, shares, TWINS)
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.identification.search import Search
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array

CAREFUL = 6   # best single effects, whose fits count


class Space:
    """Scalar products of changes of the training windows, free unknowns taken out."""

    def __init__(self, search: Search, fitted: CandidateFit) -> None:
        self.search, self.fitted = search, fitted
        data, point = search.long, fitted.point
        self.model = fitted.candidate.model(point.z)
        s = likelihood.sensitivity(data, fitted.candidate, point)
        train = data.train
        Jx = s.Jx[train]
        # Orthonormal in each window: the states' part is then a plain product.
        Jx = Jx / np.maximum(np.linalg.norm(Jx, axis=1, keepdims=True), 1e-30)
        self._basis, _ = np.linalg.qr(Jx)
        self.own = self.clean(s.Jz)  # [M, P]

    def clean(self, columns: Array) -> Array:
        """Return columns [W, 2L, C] as [M, C], window states taken out."""
        columns = columns[self.search.long.train]
        columns = columns - self._basis @ (self._basis.transpose(0, 2, 1) @ columns)
        return columns.reshape(columns.shape[0] * columns.shape[1], columns.shape[2])

    def signature(self, name: str, order: int | None = None) -> Array:
        """
        Return the changes [M, C] by a little of effect `name`, one column per way.

        Args:
            name: id of an effect.
            order: order N of a periodic effect, None for the others.
        """
        effects = [effect for probe in self.search.probes(name, order) for effect in probe]
        return self.clean(likelihood.effect_columns(
            self.search.long, self.model, self.fitted.point, effects))


def _orders(search: Search, name: str) -> int | None:
    """Return the order of the periodic effect `name` that fits best, None for others."""
    if name not in PERIODIC:
        return None
    candidate_fit = search.fitted.get(name)
    if candidate_fit is not None:
        return candidate_fit.candidate.orders[0]
    return search.found_orders(name)[0]


def evidence(search: Search, fitted: CandidateFit, owner: int = 0) -> float:
    """
    Return d: 2 log likelihood that the effect `owner` of `best` gains, on training windows.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        owner: index of the effect in the candidate.
    """
    train = search.long.train
    other_ids = [n for i, n in enumerate(fitted.candidate.ids) if i != owner]
    without = search.fitted.get('+'.join(other_ids)) or search.fitted['']
    gain = without.score - fitted.score + (
        fitted.candidate.n_effect - without.candidate.n_effect) * math.log(search.long.n_train)
    if math.isfinite(gain):
        return float(gain)
    return float((without.point.chi2 - fitted.point.chi2)[train].sum())


def separations(search: Search, fitted: CandidateFit) -> Separations:
    """
    Return {id of `best`: (d, {other id: s2})}: how much of its evidence others cannot imitate.

    Other effects of `best`, window states and nominal values (with their prior) give way.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
    """
    candidate = fitted.candidate
    owners = [i for i, n in enumerate(candidate.ids) if n not in NOT_FITTED]
    if not owners:
        return {}
    space = Space(search, fitted)
    _, prior = candidate.prior(fitted.point.z)
    names = [n for n in search.ids if n not in NOT_FITTED and n not in candidate.ids]

    def one(name: str) -> Array:
        """Return the signature of the effect `name`."""
        return space.signature(name, _orders(search, name))
    signatures = dict(zip(names, map(one, names)))
    out = {}
    for owner in owners:
        other_coordinates = [k for k, c in enumerate(candidate.coordinates) if c.owner != owner]
        nuisances, weight = space.own[:, other_coordinates], prior[other_coordinates]
        a = remove(direction(candidate, fitted.point.z, owner, space.own), nuisances, weight)
        table = {name: share_left(a, remove(columns, nuisances, weight))
                 for name, columns in signatures.items()}
        out[candidate.ids[owner]] = (evidence(search, fitted, owner), table)
    return out


def confusable(search: Search, fitted: CandidateFit,
               separation_table: Separations | None = None) -> list[str]:
    """
    Return the ids that this recording cannot distinguish from an effect of `fitted`.

    An effect is confusable if it imitates all but a little of the evidence (generalised likelihood
    ratio) and its own careful fit does not lag behind by more, or if its fit lags by less, linear
    or not. With model error, a fit must lag by a share of the evidence.

    Args:
        search: fits of all candidates to one recording.
        fitted: fit on the long windows.
        separation_table: result of `separations`, computed if None.
    """
    single = len(fitted.candidate.ids) == 1
    limit = THRESHOLDS.isolable
    if search.long.weighing is not None:
        limit = max(limit, THRESHOLDS.isolable_share * (search.fitted[''].score - fitted.score))
    careful = search.ranked()[:CAREFUL]
    out = []
    for d, table in (separation_table or separations(search, fitted)).values():
        for rival, s2 in sorted(table.items(), key=lambda item: item[1]):
            rival_fit = search.fitted.get(rival)
            lags = (single and rival_fit is not None and rival in careful
                    and rival_fit.score > fitted.score + THRESHOLDS.isolable)
            if d * s2 < THRESHOLDS.isolable and not lags:
                out.append(rival)
    if single:
        out += [n for n in careful if search.fitted[n].score < fitted.score + limit
                and (fitted.white is None or search.fitted[n].white is not None)]
    else:  # pairs that have one effect in common with `best`
        neighbours = [f.candidate.ids for f in search.fitted.values()
                      if len(f.candidate.ids) == 2 and f.score < fitted.score + limit
                      and (fitted.white is None or f.white is not None)]
        out += [i for ids in neighbours if set(ids) & set(fitted.candidate.ids) for i in ids]
    out += [TWINS[i] for i in fitted.candidate.ids if i in TWINS and TWINS[i] in search.ids]
    return list(dict.fromkeys(i for i in out if i not in fitted.candidate.ids))


def matrix(search: Search, ids: Iterable[str]) -> tuple[list[str], Array]:
    """
    Return (ids, s2 [A, B]): share of the signature of a that b cannot imitate, about no effect.

    Args:
        search: fits of all candidates to one recording.
        ids: ids of the effects; those that are not fitted as a motion are left out.
    """
    none = search.fitted['']
    space = Space(search, none)
    _, prior = none.candidate.prior(none.point.z)
    ids = [n for n in ids if n not in NOT_FITTED]
    columns = [remove(space.signature(n, _orders(search, n)), space.own, prior) for n in ids]
    return ids, shares(ids, columns)
