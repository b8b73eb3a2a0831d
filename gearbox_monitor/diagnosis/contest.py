# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The contest: laws, functions without a law, bursts and noise compete for what recordings show.

    score = -2 log L / over-dispersion + price of the members

The price is that of the extended BIC (Chen and Chen, 2008): the logarithm of the effective number
of readings for each parameter, and twice that of the number of rivals for each choice; of a
function its Occam factor. One margin decides everything. The search is best first: what remains?
settle the nuisances; take the member that pays most; drop what no longer pays; exchange each
member once. The verdict is what is a member. What decides is CONTEST (settings.py).
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Generic, TypeVar

from gearbox_monitor.diagnosis.hypothesis import (
    Evidence, Hypothesis, Member, MemberEstimate, Remains)
from gearbox_monitor.diagnosis.settings import CONTEST

UNTESTED = Remains(0.0, -math.inf)
E = TypeVar('E', bound=Evidence)


@dataclass(frozen=True, eq=False)
class Search(Generic[E]):
    """
    Where a search stands, and what it found.

    evidence: its nuisances settled about `best`. none: without members. rivals: all that were
    fitted with these nuisances, in the order of their fits. grown: sets of members that were
    grown, once each. first: hypotheses of one member. remains: beside `best`.
    """

    evidence: E
    none: Hypothesis
    best: Hypothesis
    rivals: tuple[Hypothesis, ...] = ()
    grown: frozenset[frozenset[Member]] = frozenset()
    first: tuple[Hypothesis, ...] = ()
    remains: Remains = UNTESTED

    @property
    def lawless(self) -> bool:
        """Whether something without a law explains a part, or something remains."""
        return self.best.function is not None or bool(self.remains.worth > CONTEST.margin)

    def worth(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return by how much `more` beats `less` beyond the price of what it adds."""
        price = self.evidence.price
        return self.evidence.gain(less, more) - price(more) + price(less)

    def pays(self, h: Hypothesis) -> bool:
        """Return whether `h` beats the best hypothesis by the margin."""
        return self.worth(self.best, h) > CONTEST.margin

    def dispersed(self, remains: Remains) -> 'Search[E]':
        """Return the search that knows what remains beside its best hypothesis."""
        return replace(self, evidence=self.evidence.dispersed(remains.dispersion),
                       remains=remains)

    def settled_about(self, evidence: E) -> 'Search[E]':
        """Return the search on evidence with other nuisances."""
        out = replace(self, evidence=evidence, none=evidence.moved(self.none), rivals=(),
                      grown=self.grown - {frozenset(self.best.members)})
        current = pruned(out, evidence.moved(self.best)) if self.best.members else out.none
        return replace(out, best=current, rivals=(out.none, current))


def contest(evidence: E) -> Search[E]:
    """Return what explains the recordings of `evidence` best."""
    none = evidence.none()
    search = carried(Search(evidence, none, evidence.with_unstated(none), (none,)))
    # The member that pays most alone need not be among those that pay most together.
    for start in other_starts(search):
        other = carried(replace(search, best=search.evidence.moved(start)))
        if search.worth(search.none, other.best) > CONTEST.margin:
            search = max(search, other, key=lambda s: search.evidence.likeness(
                search.none, s.best))
    return ended(search)


def carried(search: Search[E]) -> Search[E]:
    """Return a search after as many steps as change anything."""
    goes_on = True
    while goes_on:
        search, goes_on = stepped(search)
    return search


def other_starts(search: Search[E]) -> list[Hypothesis]:
    """
    Return other first members of a search, the best of each place, if one law is not enough.

    What is alone imitates the others: a first member may win by that, and then needs helpers.
    """
    enough = len(search.best.members) < 2 and not search.lawless
    if enough or not search.first or search.evidence.reach(search.best) <= CONTEST.margin:
        return []  # nothing gains more
    least = 0.0 if search.remains.worth > CONTEST.margin else CONTEST.close * max(
        (search.worth(search.none, h) for h in search.first if h.laws), default=0.0)
    best: dict[str, Hypothesis] = {}
    for h in sorted(search.first, key=partial(rank, search, search.none)):
        if h.laws and h.laws[0] not in search.best.members and search.worth(
                search.none, h) > least:
            best.setdefault(h.laws[0].place, h)
    return list(best.values())[:CONTEST.others]


def stepped(search: Search[E]) -> tuple[Search[E], bool]:
    """Return (the search after one more step, whether that changed anything)."""
    remains = search.evidence.remains(search.best)
    search = search.dispersed(remains)
    left = remains.worth > CONTEST.margin
    if (settled := search.evidence.settled(search.best, remains)) is not None:
        return search.settled_about(settled), True
    added = [m for m in search.best.members if m not in search.evidence.unstated]
    if len(added) >= CONTEST.most or frozenset(search.best.members) in search.grown:
        return search, False
    search, entries = entered(search, remains)
    best = entries[0] if entries and search.pays(entries[0]) else None
    if left or best is not None:
        varied = with_variant(search, best or search.best, remains)
        if varied is not None:
            return varied, True
    if best is not None:
        current = pruned(search, best)
        return replace(search, best=current, rivals=(*search.rivals, current)), True
    return exchanged(search, left)


def entered(search: Search[E], remains: Remains) -> tuple[Search[E], list[Hypothesis]]:
    """
    Return (the search, its best hypothesis with one more member where so much `remains`).

    Free torque as large as what is missing hides a function from a linear step: where no law
    pays, functions are tested beside it.
    """
    entries = grown(search, search.best, remains)
    if remains.functions is None and remains.worth > CONTEST.margin and not (
            entries and search.pays(min(entries, key=partial(rank, search, search.best)))):
        remains = search.evidence.remains(search.best, thorough=True)
        search = search.dispersed(remains)
        entries += with_functions(search, search.best, remains)
    entries.sort(key=partial(rank, search, search.best))
    return replace(search, rivals=(*search.rivals, *entries), first=search.first if
                   search.best.members else tuple(entries),
                   grown=search.grown | {frozenset(search.best.members)}), entries


def grown(search: Search[E], h: Hypothesis, remains: Remains) -> list[Hypothesis]:
    """Return `h` of a search with one more law or a function; so much `remains` beside `h`."""
    laws = possible(with_laws(search, h, remains.worth > CONTEST.margin))
    best = min(laws, key=partial(rank, search, h), default=None)
    # Where a law leaves nothing, no function beats it by the margin.
    if best is not None and search.worth(h, best) > CONTEST.margin > search.evidence.reach(best):
        return laws
    return laws + possible(with_functions(search, h, remains))


def possible(entries: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the entries off all bounds of physics: a value at one imitates another cause."""
    return [h for h in entries if not any(m.bounded for m in h.members)]


def with_laws(search: Search[E], h: Hypothesis, left: bool) -> list[Hypothesis]:
    """Return `h` of a search with one more law, one that may pay unless noise alone is `left`."""
    estimates = search.evidence.estimates(h)
    if not (left or not h.members or any(
            search.evidence.shown * e.price < e.gain < math.inf for e in estimates)):
        return []
    count = CONTEST.confirmed if not left else CONTEST.further if h.members else CONTEST.screened
    return search.evidence.grown(h, leading(estimates, count, left))


def leading(estimates: Sequence[MemberEstimate], count: int,
            untested: bool) -> list[MemberEstimate]:
    """
    Return the leading starts of each of the best `count` members.

    Args:
        estimates: the best first.
        count: number of members whose gain a linear step gives.
        untested: whether members whose gain is unknown are added.
    """
    by_name: dict[Member, list[MemberEstimate]] = {}
    for e in estimates:
        by_name.setdefault(e.member, []).append(e)
    tested = [name for name, starts in by_name.items() if math.isfinite(starts[0].gain)]
    names = tested[:count] + [n for n in by_name if untested and n not in tested]
    return [e for name in names for e in by_name[name][:CONTEST.starts]]


def with_functions(search: Search[E], h: Hypothesis, remains: Remains) -> list[Hypothesis]:
    """Return `h` of a search with functions; all that lead are fitted if something `remains`."""
    if h.function is not None or not remains.functions:
        return []
    left = remains.worth > CONTEST.margin
    chosen = [e for e in remains.functions[:CONTEST.leaders if left else 1]
              if left or e.worth > CONTEST.margin]
    return search.evidence.grown(h, chosen)


def rank(search: Search[E], base: Hypothesis, h: Hypothesis) -> float:
    """Return how far `h` lags in a search, over its base: a function has to beat each law."""
    return (CONTEST.margin if h.function is not None else 0.0) - search.evidence.likeness(base, h)


def pruned(search: Search[E], h: Hypothesis, whole: bool = False) -> Hypothesis:
    """
    Return `h` of a search without the members that no longer pay beside the others.

    Members of which the model states no value are pruned only if `whole`, at the end of a search:
    one of them may pay once a later member is there.
    """
    while len(h.members) > 1:
        less = [search.evidence.without(h, i) for i, m in enumerate(h.members)
                if whole or m not in search.evidence.unstated]
        best = max(less, key=partial(search.worth, h), default=h)
        if best is h or search.worth(best, h) >= CONTEST.margin:
            break
        h = best
    return h


def with_variant(search: Search[E], best: Hypothesis, remains: Remains) -> Search[E] | None:
    """
    Return the search by another law of a nuisance, None where none pays.

    Another law costs a choice of two, and competes with the member that `best` adds: what a
    missing member leaves (`remains`) is neither another friction nor coloured noise.
    """
    for evidence in search.evidence.variants(search.best, remains):
        there = evidence.moved(search.best)
        if search.worth(best, there) > CONTEST.margin + 2.0 * math.log(2.0):
            return search.settled_about(evidence)
    return None


def exchanged(search: Search[E], left: bool) -> tuple[Search[E], bool]:
    """
    Return (the search with one member exchanged, whether an exchange pays).

    The first member had to imitate the others while it was alone. A function, which takes up
    what laws beside it do not, is exchanged for a law.

    Args:
        search: where no further member pays.
        left: whether something remains.
    """
    current = search.best
    for number, member in enumerate(current.members if len(current.members) > 1 else ()):
        fewer = frozenset(current.members) - {member}
        if member in search.evidence.unstated or fewer in search.grown or (
                member != current.function and (current.function is not None or not left)):
            continue
        base = search.evidence.without(current, number)
        entries = possible(with_laws(search, base, True)) if member == current.function else grown(
            search, base, search.evidence.remains(base, thorough=True))
        entries.sort(key=partial(rank, search, base))
        search = replace(search, rivals=(*search.rivals, *entries),
                         grown=search.grown | {fewer})
        if entries and search.pays(entries[0]):
            return replace(search, best=pruned(search, entries[0])), True
    return search, False


def ended(search: Search[E]) -> Search[E]:
    """Return the outcome of a search, with a train of bursts where that pays."""
    evidence, remains = search.evidence, search.remains
    best = search.best
    if evidence.unstated & set(best.members):
        best = pruned(search, best, True)
    if remains.dispersion is None:
        remains = evidence.remains(best, thorough=True)
    if remains.torque > CONTEST.margin:
        for base in dict.fromkeys((search.none, best)):
            train = base
            for longer in evidence.trains(base, best):
                # One burst alone may not pay where all do.
                if search.worth(train, longer) > CONTEST.margin:
                    train = longer
            if train is not base and search.pays(train):
                best, remains = train, evidence.remains(train)
                break
    return replace(search, best=best, remains=remains)
