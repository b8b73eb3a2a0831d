# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A hypothesis about the gap, the evidence that judges it, and what a verdict states of it.

A hypothesis has members: laws (an effect of the library at a place), at most one function without
a law, and at most one train of bursts. Nuisances (values with tolerances, noise, the shape of
friction, hidden begins) are part of every fit and no members. `Evidence` is all that the contest
asks of recordings; a drive with its encoders answers by the innovations of a filter. Members that
stand are findings; what they leave is a remainder; what a motion leaves open is a question, with
the motion that would answer it.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import math
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self

from gearbox_monitor.diagnosis.settings import CONTEST

LAW, FUNCTION, TRAIN = 'law', 'function', 'train'
# Kinds of verdicts.
NONE, EFFECT, INCOMPLETE, UNKNOWN = 'none', 'effect', 'incomplete', 'unknown'
UNDECIDED = 'undecided'  # nothing was found, and the motion would not have shown it
KINDS = (NONE, EFFECT, INCOMPLETE, UNKNOWN, UNDECIDED)


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
    shown: share of a gain that a linear step shows at least. unstated: members for which the model
    states no value, such as friction in a URDF; they do not count towards the most members.
    """

    shown: ClassVar[float]

    @property
    def unstated(self) -> frozenset[Member]:
        """Members for which the model states no value."""

    def none(self) -> Hypothesis:
        """Return the fit without members."""

    def with_unstated(self, none: Hypothesis) -> Hypothesis:
        """Return `none` with the members of `unstated` that have no setting; they need not pay."""

    def dispersed(self, dispersion: float | None) -> Self:
        """Return the evidence with an over-dispersion that was found; None changes nothing."""

    def gain(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return by how much `more` beats `less`, beyond what differs between parts."""

    def price(self, h: Hypothesis) -> float:
        """Return the price of all members of `h`."""

    def likeness(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return how much more like the recordings `more` is than `less`: it ranks rivals."""

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


@dataclass(frozen=True)
class Finding:
    """
    One effect that a recording shows.

    effect: its id. place: location class of the effect (actuator, motor_side, ...). joint, link:
    of a robot. channel: reading that shows it. values: parameters in their units. deviations: the
    standard deviation of each value, None where the recording does not determine it. share: of
    the squared misfit beyond noise that it explains, 0 to 1, None where none is beyond noise.
    evidence: 2 log likelihood that it gains less the penalty of its parameters (BIC).
    confusable: ids that explain the recording as well.
    """

    effect: str
    place: str
    values: Mapping[str, float]
    deviations: Mapping[str, float | None]
    evidence: float | None
    share: float | None = None
    channel: str | None = None
    joint: str | None = None
    link: str | None = None
    confusable: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, 'values', MappingProxyType(dict(self.values)))
        object.__setattr__(self, 'deviations', MappingProxyType(dict(self.deviations)))

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the values that the recording does not determine."""
        return tuple(name for name in self.values if self.deviations.get(name) is None)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; joint and link only where there is one."""
        data: dict[str, Any] = {
            'effect': self.effect, 'place': self.place, 'channel': self.channel,
            'values': dict(self.values), 'deviations': dict(self.deviations),
            'share': self.share, 'evidence': self.evidence, 'confusable': list(self.confusable)}
        return data | {key: value for key, value in (('joint', self.joint), ('link', self.link))
                       if value is not None}


@dataclass(frozen=True)
class Remainder:
    """
    What no finding explains.

    place: location class where a torque or an offset takes it up. channel: reading that shows it
    most, of size `size` there (rms beyond noise, in the unit of the reading). over: variable of
    the motion that it follows, None where it follows none. times: (begin, end) of bursts, s, each
    in the recording of the same place in `recordings`, which is empty where there is only one.
    """

    place: str
    channel: str | None = None
    size: float | None = None
    over: str | None = None
    joint: str | None = None
    times: tuple[tuple[float, float], ...] = ()
    recordings: tuple[str, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; joint, times and recordings only where there are any."""
        data: dict[str, Any] = {'location': self.place, 'place': self.place,
                                'channel': self.channel, 'size': self.size, 'over': self.over,
                                **self.figures}
        if self.joint is not None:
            data['joint'] = self.joint
        if self.times:
            data['times'] = [list(pair) for pair in self.times]
        if self.recordings:
            data['recordings'] = list(self.recordings)
        return data


def kind_of(findings: bool, remainder: bool) -> str:
    """
    Return the kind of a verdict.

    Args:
        findings: whether it has findings.
        remainder: whether something beyond noise remains.
    """
    return ((NONE, UNKNOWN), (EFFECT, INCOMPLETE))[findings][remainder]


UNSEEN = 10.0  # times the plausible size, beyond which a change counts as never shown


SHORTEST, LONGEST = 20.0, 600.0  # s, of a motion that is asked for


@dataclass(frozen=True)
class Question:
    """
    A change that a motion does not show, or not apart from a rival, and the motion that would.

    effect, place: of the change. joint: to move, at some speed (rad/s or m/s), for some seconds.
    evidence: 2 log likelihood to expect of that, None where it depends on how the motion differs.
    smallest: size that would have been a finding, infinite for none; plausible: size that should
    be one. rival: effect that explains a recording as well, '' where none is a finding.
    """

    effect: str
    place: str
    joint: str
    speed: float
    seconds: float
    evidence: float | None
    smallest: float | None = None
    plausible: float | None = None
    rival: str = ''


def _rounded(seconds: float) -> float:
    return min(max(10.0 * round(0.1 * seconds), SHORTEST), LONGEST)


def of_size(where: tuple[str, str, str], motion: tuple[float, float],
            sizes: tuple[float, float], price: float) -> Question:
    """
    Return the Question of a change of plausible size that a motion does not show.

    Its evidence grows with the time and with the square of the size.

    Args:
        where: effect, place and joint.
        motion: speed of the joint and length, s.
        sizes: smallest one that would have been a finding, and plausible one.
        price: of the effect in a contest.
    """
    (effect, place, joint), (speed, time), (smallest, plausible) = where, motion, sizes
    longer = min(smallest / plausible, UNSEEN) ** 2
    seconds = _rounded(time * longer)
    return Question(effect, place, joint, speed, seconds,
                    (CONTEST.margin + price) * seconds / (time * longer),
                    smallest if smallest < UNSEEN * plausible else math.inf, plausible)


def of_rival(where: tuple[str, str, str], motion: tuple[float, float], rival: str,
             lag: float) -> Question:
    """
    Return the Question whether an effect or its rival is the cause.

    Args:
        where: effect, place and joint.
        motion: speed of the joint and length, s.
        rival: the other effect.
        lag: 2 log likelihood by which it lags so far, 0 where only another motion decides.
    """
    (effect, place, joint), (speed, time) = where, motion
    seconds = _rounded(time * min(CONTEST.margin / lag, UNSEEN) if lag > 0.0 else 2.0 * time)
    return Question(effect, place, joint, speed, seconds,
                    lag * seconds / time if lag > 0.0 else None, rival=rival)
