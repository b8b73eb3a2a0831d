# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Search for the effects whose likelihood is highest: scan, fit, exchange.

Effects are fitted by successive halving: many a little, few to the end. Pairs grow from the best
single effects by the effect that gains most beside each; then each member of the best pair is
exchanged, because the first one had to imitate the other while it was alone (stepwise regression
with exchange, Miller 2002).
"""
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
import math
from typing import TypeVar

from gearbox_monitor.diagnosis.joint.effect_scan import joined, Proposal, scan
from gearbox_monitor.diagnosis.joint.evidence import Evidence
from gearbox_monitor.diagnosis.joint.innovation_fit import (
    evaluated, fitted, InnovationFit, unfitted)

Item = TypeVar('Item')
Value = TypeVar('Value')


@dataclass(frozen=True)
class SearchEffort:
    """
    Number of fits in each round of the search, and of their iterations.

    A score test ranks effects by a linear step, which may mistake a strong non-linear one: some
    screened effects more than can be right. Two starts of an effect are enough after the test.
    """

    screened: int = 12         # effects that are fitted a little
    promising: float = 12.0    # gain of a score test from which on a fit may gain enough
    confirmed: int = 3         # effects that are fitted where none is adequate and promising
    starts: int = 2            # starts or orders of each
    rounds: tuple[tuple[int, int], ...] = ((99, 2), (8, 3), (4, 15))  # how many, iterations
    bases: int = 4             # single effects that pairs grow from
    grown: int = 4             # second effects of each
    growing: tuple[tuple[int, int], ...] = ((16, 1), (8, 2))  # rounds of second effects
    kept: int = 6              # of them, which go on
    exchanges: int = 3


EFFORT = SearchEffort()


@dataclass(frozen=True)
class FitTable:
    """Fits on long steps: without effects and of single ones, best first; orders of periodic."""

    none: InnovationFit
    singles: tuple[InnovationFit, ...]
    orders: tuple[tuple[str, list[int]], ...] = ()


class EffectSearch:
    """The search for effects on long steps."""

    def __init__(self, evidence: Evidence) -> None:
        self.likelihood, self.starts, self.ids = evidence.coarse, evidence.starts, evidence.ids
        self.jobs, self.progress, self.score = evidence.jobs, evidence.progress, evidence.score

    def _map(self, function: Callable[[Item], Value], items: Sequence[Item]) -> list[Value]:
        with ThreadPoolExecutor(self.jobs) as pool:
            return list(pool.map(function, items))

    def none(self) -> InnovationFit:
        """Return the fit without effects."""
        return fitted(self.likelihood, unfitted(self.likelihood, self.starts.none()))

    def begun(self, fit: InnovationFit, proposal: Proposal) -> InnovationFit:
        """Return `fit` with a further effect, at the likeliest point where its fit may begin."""
        return min((evaluated(self.likelihood, trial).alone()
                    for trial in joined(self.starts, fit, proposal)), key=lambda f: f.deviance)

    def _halved(self, fits: Sequence[InnovationFit],
                rounds: Sequence[tuple[int, int]]) -> list[InnovationFit]:
        """
        Return `fits` of which the best went on, best first, one of each name.

        After the first round, one start of each effect and order goes on: other starts lead to the
        same optimum.
        """
        done: list[InnovationFit] = []
        racing = list(fits)
        for number, (survivors, iterations) in enumerate(rounds):
            racing = sorted(racing, key=self.score)
            if number:
                racing = _best_of_each(racing, by_order=True)
            done += racing[survivors:]
            racing = self._map(partial(fitted, self.likelihood, iterations=iterations),
                               racing[:survivors])
        return _best_of_each(sorted([*racing, *done], key=self.score))

    def singles(self, none: InnovationFit, adequate: bool = False) -> FitTable:
        """
        Return the fits of single effects.

        Args:
            none: the fit without effects.
            adequate: whether that leaves nothing but noise; then few are fitted, and none whose
                gain the score test does not tell.
        """
        proposals = scan(self.likelihood, self.starts, none, self.ids)
        self.progress('screening')
        promising = proposals and any(
            EFFORT.promising < p.gain < math.inf for p in proposals)
        few = adequate and not promising
        chosen = self._chosen(proposals, EFFORT.confirmed if few else EFFORT.screened, not few)
        begun_fits = self._map(lambda p: self.begun(none, p), chosen)
        self.progress('fitting')
        fits = self._halved(begun_fits, EFFORT.rounds)
        orders: dict[str, list[int]] = {}
        for p in proposals:
            if p.order is not None and len(orders.setdefault(p.name, [])) < 3:
                orders[p.name].append(p.order)
        return FitTable(none, tuple(fits), tuple(orders.items()))

    def _chosen(self, proposals: Sequence[Proposal], count: int,
                untested: bool) -> list[Proposal]:
        """Return the best starts of the best `count` effects; and of those without a gain."""
        by_name: dict[str, list[Proposal]] = {}
        for p in proposals:
            by_name.setdefault(p.name, []).append(p)
        tested = [name for name in by_name if math.isfinite(by_name[name][0].gain)]
        names = tested[:count] + ([n for n in by_name if n not in tested] if untested else [])
        return [p for name in names for p in by_name[name][:EFFORT.starts]]

    def pairs(self, singles: Sequence[InnovationFit]) -> list[InnovationFit]:
        """Return fits of pairs that grow from `singles`, best first."""
        tried: set[str] = set()
        fits: list[InnovationFit] = []
        bases = list(singles[:EFFORT.bases])
        for number in range(EFFORT.exchanges + 1):
            jobs = []
            for base in bases:
                tried.add(base.name)
                proposals = scan(self.likelihood, self.starts, base, self.ids)
                untested = number == 0 and base is bases[0]
                jobs += [(base, p) for p in self._chosen(proposals, EFFORT.grown, untested)]
            self.progress('pairs')
            grown = self._halved(self._map(lambda job: self.begun(*job), jobs), EFFORT.growing)
            fits = self._halved([*fits, *grown[:EFFORT.kept]], ((4, 4),))
            if not fits:
                break
            bases = [self.reduced(fits[0], [i]) for i, name in enumerate(fits[0].candidate.ids)
                     if name not in tried]
            if not bases:
                break
        return self._halved(fits, ((3, 15),))

    def third(self, pair: InnovationFit) -> list[InnovationFit]:
        """Return fits of `pair` with one more effect, best first."""
        proposals = self._chosen(scan(self.likelihood, self.starts, pair, self.ids),
                                 EFFORT.grown, False)
        return self._halved(self._map(lambda p: self.begun(pair, p), proposals), (
            *EFFORT.growing, (3, 15)))

    def reduced(self, fit: InnovationFit, kept: Sequence[int]) -> InnovationFit:
        """Return the effects number `kept` of `fit`, fitted alone from where it stands."""
        candidate, z = self.starts.reduced(fit.candidate, fit.z, kept)
        return fitted(self.likelihood, InnovationFit(candidate, z, fit.torque), 4)


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
