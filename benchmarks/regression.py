# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Linear regression as evidence of a contest: quick, and all sets of members can be counted."""
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import ClassVar, Self

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import (
    FUNCTION, Hypothesis, LAW, Member, MemberEstimate, Remains, TRAIN)
from gearbox_monitor.diagnosis.settings import CONTEST
from gearbox_monitor.kernels.types import Array

ROWS = 400


@dataclass(frozen=True, eq=False)
class Regression:
    """
    y = X b + noise of variance 1 / scale; laws are columns, a function is four of them at once.

    Laws are at the place that begins their name. bounded: laws at a bound. untested: laws of which
    a linear step gives no gain. offset: a nuisance without a derivative, by which y is shifted:
    `settles` is settled once where much remains, `others` compete. bursts: columns that a train
    takes one after the other. spread: over-dispersion that remains shows. shy: functions are
    tested beside free torque only where that is asked for. log: what was fitted, in order.
    """

    shown: ClassVar[float] = 1.0
    unstated: ClassVar[frozenset[Member]] = frozenset()

    y: Array
    laws: Mapping[str, Array]
    functions: Mapping[str, Array]
    bounded: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()
    offset: float = 0.0
    settles: float | None = None
    others: tuple[float, ...] = ()
    bursts: tuple[Array, ...] = ()
    spread: float = 1.0
    dispersion: float = 1.0
    shy: bool = False
    log: list[str] = field(default_factory=list)

    def fitted(self, names: Iterable[str]) -> Hypothesis:
        """Return the hypothesis of the members `names` by least squares."""
        h = self._fitted(tuple(names))
        self.log.append(h.name)
        return h

    def _fitted(self, names: tuple[str, ...]) -> Hypothesis:
        known = {**self.laws, **self.functions, **{
            f'train{k}': np.transpose(self.bursts[:k]) for k in range(len(self.bursts) + 1)}}
        X = np.column_stack([np.zeros((ROWS, 0)), *(known[n] for n in names)])
        b = np.linalg.lstsq(X, self.y - self.offset, rcond=None)[0]
        r = self.y - self.offset - X @ b
        members = tuple(Member(
            FUNCTION if n in self.functions else LAW if n in self.laws else TRAIN, n, n[:3], n,
            (n,) * (n in self.bounded)) for n in names)
        return Hypothesis(members, float(r @ r), (names, r))

    def none(self) -> Hypothesis:
        return self.fitted(())

    def with_unstated(self, none: Hypothesis) -> Hypothesis:
        """Return `none`: the regression states all values."""
        return none

    def dispersed(self, dispersion: float | None) -> Self:
        return self if dispersion is None else replace(self, dispersion=dispersion)

    def gain(self, less: Hypothesis, more: Hypothesis) -> float:
        return (less.deviance - more.deviance) / self.dispersion

    def likeness(self, less: Hypothesis, more: Hypothesis) -> float:
        return less.deviance - more.deviance - self.price(more) + self.price(less)

    def price(self, h: Hypothesis) -> float:
        size = sum(4 if m.kind == FUNCTION else 1 for m in h.members)
        return size * math.log(ROWS) + 2.0 * len(h.members) * math.log(len(self.laws))

    def reach(self, h: Hypothesis) -> float:
        return h.deviance

    def _estimates(self, h: Hypothesis, names: Iterable[str], kind: str) -> list[MemberEstimate]:
        out = []
        for name in names:
            if name not in h.fit[0]:
                more = self._fitted((*h.fit[0], name))
                gain = math.inf if name in self.untested else h.deviance - more.deviance
                out.append(MemberEstimate(Member(kind, name, name[:3], name), gain,
                                          self.price(more) - self.price(h), name))
        return sorted(out, key=lambda e: -e.worth)

    def estimates(self, h: Hypothesis) -> Sequence[MemberEstimate]:
        return self._estimates(h, self.laws, LAW)

    def remains(self, h: Hypothesis, thorough: bool = False) -> Remains:
        torque, r = h.deviance - ROWS - 2.0 * math.sqrt(2.0 * ROWS), h.fit[1]
        memory = float(r[1:] @ r[:-1]) ** 2 / h.deviance - math.log(ROWS)
        if self.shy and torque > CONTEST.margin and not thorough:
            return Remains(torque, memory)
        functions = self._estimates(h, self.functions, FUNCTION)
        return Remains(torque, memory, max((f.worth for f in functions), default=-math.inf),
                       tuple(functions), self.spread)

    def grown(self, h: Hypothesis, added: Sequence[MemberEstimate]) -> list[Hypothesis]:
        fits = sorted((self.fitted((*h.fit[0], e.source)) for e in added),
                      key=lambda f: f.deviance)
        placed = {} if h.members else {f.members[0].place: f for f in reversed(fits)}
        return list(dict.fromkeys((*fits[:CONTEST.finalists], *placed.values())))

    def without(self, h: Hypothesis, number: int) -> Hypothesis:
        return self.fitted(n for i, n in enumerate(h.fit[0]) if i != number)

    def settled(self, h: Hypothesis, remains: Remains) -> Self | None:
        if self.settles is None or remains.worth <= CONTEST.margin:
            return None
        return replace(self, offset=self.settles, settles=None)

    def variants(self, h: Hypothesis, remains: Remains) -> Sequence[Self]:
        return [replace(self, offset=other, others=()) for other in self.others]

    def moved(self, h: Hypothesis) -> Hypothesis:
        return self.fitted(h.fit[0])

    def trains(self, h: Hypothesis, best: Hypothesis) -> Iterator[Hypothesis]:
        for k in range(1, len(self.bursts) + 1):
            yield self.fitted((*h.fit[0], f'train{k}'))


def drawn(seed: int) -> Regression:
    """Return a problem of its own for each `seed`: what is true, and what imitates or hides it."""
    rng = np.random.default_rng(seed)

    def one_in(count: int) -> bool:
        return bool(rng.integers(count) == 0)
    X = rng.standard_normal((ROWS, 12))
    X[:, 10] = X[:, 0] + X[:, 1] + rng.uniform(0.3, 1.5) * X[:, 10]
    X[:, 11] = X[:, 2] + rng.uniform(0.3, 1.5) * X[:, 11]
    laws = {f'{"arm motor base".split()[i % 3]}{i}': x for i, x in enumerate(X.T)}
    functions = {f'smooth{i}': rng.standard_normal((ROWS, 4)) for i in range(3)}
    names = [*laws]
    y = (1.0 + 0.4 * one_in(5)) * rng.standard_normal(ROWS)
    for k in rng.permutation(12)[:seed % 6] if one_in(2) else range(seed % 4):
        y = y + rng.uniform(0.15, 0.8) * laws[names[k]]
    for shape in [*functions.values()][:seed % 3 % 2 + one_in(4)]:
        y = y + shape @ rng.uniform(-0.6, 0.6, 4)
    shift = 0.1 * 12.0 ** rng.random() if one_in(2) else 0.0
    bursts = tuple((np.arange(ROWS) // 8 == k).astype(float) for k in (5, 20, 33, 41))
    burst = rng.uniform(1.0, 4.0) * one_in(3)
    settled = one_in(2)
    bounded, untested = ([str(name) for name in rng.choice(names, count * one_in(3))]
                         for count in (1, 2))
    return Regression(
        y + shift + burst * sum(bursts), laws, functions, tuple(bounded), tuple(untested),
        settles=shift if shift and settled else None, others=() if settled else (shift, 0.5),
        bursts=bursts if one_in(2) else (), spread=1.5 if one_in(4) else 1.0, shy=one_in(2))
