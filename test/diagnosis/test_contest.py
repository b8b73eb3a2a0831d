# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The contest on evidence with known answers: linear regression, where sets can be counted out."""
from dataclasses import dataclass, replace
from itertools import combinations
import math

import numpy as np
import pytest

from gearbox_monitor.diagnosis.contest import CONTEST, contest
from gearbox_monitor.diagnosis.hypothesis import (
    FUNCTION, Hypothesis, LAW, Member, MemberEstimate, Remains)

ROWS = 400


@dataclass(frozen=True, eq=False)
class Regression:
    """
    y = X b + noise of variance 1 / scale; laws are columns, a function is four of them at once.

    offset: a nuisance without a derivative, which is settled once: y is shifted by it. Laws are
    at the place that begins their name.
    """

    shown = 1.0

    y: np.ndarray
    laws: dict
    functions: dict
    bounded: tuple = ()
    offset: float = 0.0
    settles: float | None = None

    def fitted(self, names):
        """Return the hypothesis of these members by least squares."""
        known = {**self.laws, **self.functions}
        columns = [np.atleast_2d(known[n].T).T for n in names]
        X = np.column_stack([np.zeros((ROWS, 0)), *columns])
        b = np.linalg.lstsq(X, self.y - self.offset, rcond=None)[0]
        r = self.y - self.offset - X @ b
        members = tuple(Member(FUNCTION if n in self.functions else LAW, n, n[:3], n,
                               (n,) * (n in self.bounded)) for n in names)
        return Hypothesis(members, float(r @ r), (tuple(names), r))

    def none(self):
        return self.fitted(())

    def dispersed(self, dispersion):
        return self

    def gain(self, less, more):
        return less.deviance - more.deviance

    def likeness(self, less, more):
        return self.gain(less, more) - self.price(more) + self.price(less)

    def price(self, h):
        size = sum(4 if m.kind == FUNCTION else 1 for m in h.members)
        return size * math.log(ROWS) + 2.0 * len(h.members) * math.log(len(self.laws))

    def reach(self, h):
        return h.deviance

    def _estimates(self, h, field, kind):
        out = []
        for name in field:
            if name not in h.fit[0]:
                more = self.fitted((*h.fit[0], name))
                price = self.price(more) - self.price(h)
                out.append(MemberEstimate(Member(kind, name, name[:3], name),
                                          h.deviance - more.deviance, price, name))
        return sorted(out, key=lambda e: -e.worth)

    def estimates(self, h):
        return self._estimates(h, self.laws, LAW)

    def remains(self, h, thorough=False):
        functions = self._estimates(h, self.functions, FUNCTION)
        torque = h.deviance - ROWS - 2.0 * math.sqrt(2.0 * ROWS)
        return Remains(torque, -math.inf, max((f.worth for f in functions), default=-math.inf),
                       tuple(functions), 1.0)

    def grown(self, h, added):
        fits = sorted((self.fitted((*h.fit[0], e.source)) for e in added),
                      key=lambda f: f.deviance)
        placed = {} if h.members else {f.members[0].place: f for f in reversed(fits)}
        return list(dict.fromkeys((*fits[:CONTEST.finalists], *placed.values())))

    def without(self, h, number):
        return self.fitted(tuple(n for i, n in enumerate(h.fit[0]) if i != number))

    def settled(self, h, remains):
        if self.settles is None or remains.worth <= CONTEST.margin:
            return None
        return replace(self, offset=self.settles, settles=None)

    def variants(self, h, remains):
        return []

    def moved(self, h):
        return self.fitted(h.fit[0])

    def trains(self, h, best):
        return ()


def columns(seed, count=12):
    """Return laws of which the last imitates the sum of the first two, and a function."""
    random = np.random.default_rng(seed)
    X = random.standard_normal((ROWS, count))
    X[:, -1] = X[:, 0] + X[:, 1] + 1.2 * random.standard_normal(ROWS)
    return ({f'law{i}': X[:, i] for i in range(count)},
            {'smooth': random.standard_normal((ROWS, 4))}, random)


def names_of(outcome):
    return {m.effect for m in outcome.best.members}


@pytest.mark.parametrize('true', [(), ('law3',), ('law0', 'law1'), ('law2', 'law5', 'law7')])
def test_the_contest_finds_the_set_that_counting_all_sets_finds(true):
    """Also where an imitator of two laws is first: it is dropped or exchanged."""
    for seed in range(5):
        laws, functions, random = columns(seed)
        y = sum((0.5 * laws[n] for n in true), random.standard_normal(ROWS))
        evidence = Regression(y, laws, functions)
        outcome = contest(evidence)

        def score(h):
            return h.deviance + evidence.price(h)
        best = min((evidence.fitted(c) for size in range(4) for c in combinations(laws, size)),
                   key=score)
        assert names_of(outcome) == set(true) == {m.effect for m in best.members}
        assert not outcome.lawless
        assert outcome.worth(outcome.none, outcome.best) == evidence.likeness(
            outcome.none, outcome.best)


def test_a_function_is_chosen_where_no_law_does_as_much_and_makes_the_verdict_lawless():
    laws, functions, random = columns(1)
    shape = functions['smooth'] @ [0.6, -0.5, 0.4, 0.5]
    outcome = contest(Regression(shape + random.standard_normal(ROWS), laws, functions))
    assert names_of(outcome) == {'smooth'} and outcome.lawless
    both = contest(Regression(0.6 * laws['law4'] + shape + random.standard_normal(ROWS), laws,
                              functions))
    assert names_of(both) == {'law4', 'smooth'} and both.lawless


@pytest.mark.parametrize('seed', range(2))
def test_a_search_that_imitators_led_astray_starts_again_at_another_place(seed):
    """Of two laws each of four imitates the sum; together they take all seats, and leave much."""
    random = np.random.default_rng(seed)
    X = random.standard_normal((ROWS, 2))
    both = X.sum(axis=1)
    laws = {'arm0': X[:, 0], 'arm1': X[:, 1], **{
        f'motor{i}': both + random.standard_normal(ROWS) for i in range(CONTEST.most)}}
    outcome = contest(Regression(both + random.standard_normal(ROWS), laws, {}))
    assert names_of(outcome) == {'arm0', 'arm1'} and not outcome.lawless


def test_what_no_member_explains_is_left():
    """A law that is worth less than the margin is none, though much is left."""
    laws, functions, random = columns(2)
    noise = 1.5 * random.standard_normal(ROWS)
    for size in np.linspace(0.0, 0.4, 41):
        evidence = Regression(noise + size * laws['law5'], laws, functions)
        none, law = evidence.fitted(()), evidence.fitted(('law5',))
        outcome, worth = contest(evidence), evidence.likeness(none, law)
        assert outcome.lawless and (worth > CONTEST.margin or not outcome.best.members)
        if worth > 0.5 * CONTEST.margin:
            break
    assert 0.0 < worth < CONTEST.margin


def test_a_nuisance_is_settled_before_a_member_imitates_it():
    laws, functions, random = columns(3)
    laws['law0'] = laws['law0'] + 1.0
    y = 0.8 + random.standard_normal(ROWS)
    assert contest(Regression(y, laws, functions)).best.members
    assert not contest(Regression(y, laws, functions, settles=0.8)).best.members


def test_a_train_is_taken_where_all_of_it_pays_though_its_first_member_does_not():
    laws, functions, random = columns(5)
    laws['law1'] = random.standard_normal(ROWS) - laws['law0']

    class Trained(Regression):
        def estimates(self, h):
            return []

        def trains(self, h, best):
            return [self.fitted(('law0', 'law1')[:count]) for count in (1, 2)]
    for size, expected in ((1.5, {'law0', 'law1'}), (0.0, set())):
        y = size * (laws['law0'] + laws['law1']) + 1.3 * random.standard_normal(ROWS)
        assert names_of(contest(Trained(y, laws, {}))) == expected


def test_a_member_at_a_bound_of_physics_is_none():
    laws, functions, random = columns(4)
    y = 0.5 * laws['law3'] + random.standard_normal(ROWS)
    outcome = contest(Regression(y, laws, functions, bounded=('law3',)))
    assert 'law3' not in names_of(outcome)


def test_no_function_is_fitted_where_a_law_leaves_nothing():
    laws, functions, random = columns(1)
    kinds = []

    class Told(Regression):
        def reach(self, h):
            return max(0.0, h.deviance - 1.2 * ROWS)

        def grown(self, h, added):
            kinds.extend(e.member.kind for e in added)
            return super().grown(h, added)
    for size, expected in ((0.0, {LAW}), (1.0, {LAW, FUNCTION})):
        kinds.clear()
        contest(Told(0.8 * laws['law3'] + size * functions['smooth'].sum(axis=1)
                     + random.standard_normal(ROWS), laws, functions))
        assert set(kinds) == expected
