# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A hypothesis about the gap, and the evidence that judges it.

A hypothesis has members: laws (an effect of the library at a place), at most one function without
a law, and at most one train of bursts. Nuisances (values with tolerances, noise, the shape of
friction, hidden begins) are part of every fit and no members. `Evidence` is all that the contest
asks of recordings; a drive with its encoders answers by the innovations of a filter.
"""
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import math
from typing import Any, Protocol, Self

LAW, FUNCTION, TRAIN = 'law', 'function', 'train'
# Kinds of verdicts.
NONE, EFFECT, INCOMPLETE, UNKNOWN = 'none', 'effect', 'incomplete', 'unknown'
UNDECIDED = 'undecided'  # nothing was found, and the motion would not have shown it


@dataclass(frozen=True)
class Member:
    """
    One part of a hypothesis.

    kind: LAW, FUNCTION or TRAIN. effect: id; of a function and a train, of the effect by which a
    model takes it up. place: location class, joint, link or base. over: variable of a function,
    or what tells an effect from another one of its id at the same place. bounded: values that
    stand at a bound of physics: such a member is no finding.
    """

    kind: str
    effect: str
    place: str
    over: str = ''
    bounded: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Id of the effect; of a function, place and variable."""
        return self.effect if self.kind != FUNCTION else f'function of {self.over} at {self.place}'


@dataclass(frozen=True)
class MemberEstimate:
    """
    A member that may be added to a hypothesis, as one linear step estimates it.

    gain: in -2 log L, beyond what differs between parts of the recordings; infinite where a
    linear step gives none. price: that it has to exceed. source: how the evidence begins its
    fit.
    """

    member: Member
    gain: float
    price: float
    source: Any

    @property
    def worth(self) -> float:
        """Gain beyond the price."""
        return self.gain - self.price


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """
    Members, fitted together.

    deviance: -2 log L with the priors of all values. fit: what the evidence knows of it; the
    contest does not look inside.
    """

    members: tuple[Member, ...]
    deviance: float
    fit: Any

    @property
    def laws(self) -> tuple[Member, ...]:
        """Effects of the library."""
        return tuple(m for m in self.members if m.kind == LAW)

    @property
    def function(self) -> Member | None:
        """The function without a law, None without one."""
        return next((m for m in self.members if m.kind == FUNCTION), None)

    @property
    def train(self) -> Member | None:
        """The train of bursts, None without one."""
        return next((m for m in self.members if m.kind == TRAIN), None)

    @property
    def name(self) -> str:
        """Names of the members joined by '+', 'none' without any."""
        return '+'.join(m.name for m in self.members) or 'none'


@dataclass(frozen=True)
class Remains:
    """
    What remains beside a hypothesis, tested against noise alone: gains beyond their prices.

    torque: noise of the torque beyond the allowed. memory: what past innovations foretell.
    follows: the best function without a law. functions: those, tempered, the best first; None
    where they were not tested, since free torque would hide them. dispersion: between parts of
    the recordings, as they show it; None where that was not tested.
    """

    torque: float
    memory: float
    follows: float = -math.inf
    functions: tuple[MemberEstimate, ...] | None = None
    dispersion: float | None = None

    @property
    def worth(self) -> float:
        """The largest of all."""
        return max(self.torque, self.memory, self.follows)


class Evidence(Protocol):
    """
    What a contest asks of recordings. Implementations are frozen: a change returns another one.

    Gains and prices are in -2 log L over the over-dispersion between parts of the recordings.
    """

    def none(self) -> Hypothesis:
        """Return the fit without members."""

    def dispersed(self, dispersion: float | None) -> Self:
        """Return the evidence with an over-dispersion that was found; None changes nothing."""

    def gain(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return by how much `more` beats `less`, beyond what differs between parts."""

    def price(self, h: Hypothesis) -> float:
        """Return the price of all members of `h`."""

    def reach(self, h: Hypothesis) -> float:
        """Return what any other explanation gains over `h` at most."""

    def estimates(self, h: Hypothesis) -> Sequence[MemberEstimate]:
        """Return the laws that may be added to `h`, each at its starts, the best first."""

    def remains(self, h: Hypothesis, thorough: bool = False) -> Remains:
        """Return what remains beside `h`; thorough: functions are tested beside free torque."""

    def grown(self, h: Hypothesis, added: Sequence[MemberEstimate]) -> list[Hypothesis]:
        """
        Return `h` with each of `added`: functions, and the finalists of a race of laws.

        Where `h` has no member, the best law of each place, too: a search may start from it.
        """

    def without(self, h: Hypothesis, number: int) -> Hypothesis:
        """Return `h` without its member `number`, refitted."""

    def settled(self, h: Hypothesis, remains: Remains) -> Self | None:
        """
        Return the evidence whose nuisances without a derivative are set about `h`.

        None where nothing changes. remains: beside `h`.
        """

    def variants(self, h: Hypothesis, remains: Remains) -> Sequence[Self]:
        """Return the evidence by other laws of a nuisance about `h`, if much `remains` there."""

    def moved(self, h: Hypothesis) -> Hypothesis:
        """Return a hypothesis `h` of other evidence on the same recordings, fitted here."""

    def trains(self, h: Hypothesis, best: Hypothesis) -> Iterable[Hypothesis]:
        """Yield `h` with trains of bursts, each longer, while they may pay beside `best`."""
