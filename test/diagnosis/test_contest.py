# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The contest on evidence with known answers: linear regression, where sets can be counted out."""
from itertools import combinations

import numpy as np
import pytest

from benchmarks.regression import Regression, ROWS
from gearbox_monitor.diagnosis.contest import contest
from gearbox_monitor.diagnosis.hypothesis import FUNCTION, LAW
from gearbox_monitor.diagnosis.settings import CONTEST


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
