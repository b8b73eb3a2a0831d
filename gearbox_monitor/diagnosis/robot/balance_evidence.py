# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The evidence of a whole robot: the balance of all its joints, as the contest asks for it.

It implements hypothesis.Evidence. A gain is what pays beyond the over-dispersion of its joints and
beyond what differs between healthy parts and days; a set gains what its members add to each other
in the order in which they were taken. Where a function without a law pays more than every law,
the cause is unknown.

The power of a motion is the smallest size of each effect that would have been a finding. Where a
change of plausible size would not have been one, `none` says nothing: the verdict is undecided,
and names the motion that would decide.
"""
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any, ClassVar

import numpy as np
import scipy

from gearbox_monitor.diagnosis.contest import leading
from gearbox_monitor.diagnosis.hypothesis import (
    FUNCTION, Hypothesis, LAW, Member, MemberEstimate, of_size, Question, Remains)
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.knowledge import key_of, Knowledge
from gearbox_monitor.diagnosis.robot.likelihood import RobotFit, RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import PAYLOAD
from gearbox_monitor.diagnosis.settings import CONTEST, SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_GAIN
from gearbox_monitor.plant.effects.controller import SERVO_LIMIT
from gearbox_monitor.plant.effects.motor_side import (
    MOTOR_COULOMB, MOTOR_INERTIA, MOTOR_VISCOUS, STRIBECK)

SETTLED = 0.005       # of the range of a setting that is searched
MOST_STEPS = 12       # of a fixed point
LEAST_GAIN = 0.3      # of deviance, that matters
# Effects that any joint has, whether its file states them or not.
UNSTATED = (MOTOR_INERTIA.id, MOTOR_COULOMB.id, MOTOR_VISCOUS.id, STRIBECK.id)
SIDE = 0.5            # of the motion's deviation: beyond, the next of a grid is nearer
TIE = 0.03            # price of a coefficient: of ties, fewer are first, as some have no torque


@dataclass(frozen=True, eq=False)
class BalanceFit:
    """
    The fit of a hypothesis to the balance of a robot.

    fit: of its members. gained: by all of them, tempered. worth: of each member when it was taken,
    beyond its price. likeness: of the last member, None where it was not grown with others.
    """

    fit: RobotFit
    gained: float = 0.0
    worth: tuple[float, ...] = ()
    likeness: float | None = None


@dataclass(frozen=True, eq=False)
class BalanceEvidence:
    """
    Recordings of one robot as Evidence.

    likelihood: of the recordings; blank: its fit without members. laws, functions: candidates.
    scatter: {key: deviations} between healthy parts; dispersion [J]. Where references are short:
    extra, price of each member; day: share of the effort by which days may differ.
    """

    # Variances are fitted, too: a linear step understates what explains most of a joint's rows.
    shown: ClassVar[float] = 0.5

    likelihood: RobotLikelihood
    blank: RobotFit
    laws: Sequence[Candidate]
    functions: Sequence[Candidate]
    scatter: Mapping[str, Array]
    dispersion: Array
    extra: float = 0.0
    day: float = 0.0

    @classmethod
    def of(cls, likelihood: RobotLikelihood, laws: Sequence[Candidate],
           functions: Sequence[Candidate] = (), knowledge: Knowledge | None = None
           ) -> 'BalanceEvidence':
        """Return the evidence of a `likelihood` between laws and functions; knowledge: learnt."""
        return cls(likelihood, likelihood.fit(), laws, functions,
                   knowledge.scatter if knowledge else {},
                   knowledge.dispersion if knowledge else np.ones(likelihood.joints))

    # --- prices

    def cost(self, candidate: Candidate) -> float:
        """Return the extended BIC of a candidate: ln n per parameter and the choice among all."""
        return TIE * candidate.width + self.cost_of(
            candidate.size, self.likelihood.rows_in(candidate), candidate.free)

    def cost_of(self, size: int, rows: float, free: bool = False) -> float:
        """Return the cost of `size` parameters by some `rows`, among laws or `free` functions."""
        return float(size * np.log(max(rows, 3.0)) + 2.0 * np.log(self._rivals[free])) + self.extra

    @cached_property
    def _efforts(self) -> list[float]:
        """Sums of squares of each joint's effort."""
        recordings = self.likelihood.recordings
        return [sum(float(np.sum((rows.target[j] + rows.model[j]) ** 2)) for rows in recordings)
                for j in range(self.likelihood.joints)]

    @cached_property
    def _rivals(self) -> tuple[int, int]:
        """The numbers of laws and of functions."""
        laws, functions = (max(len({c.name for c in field}), 1)
                           for field in (self.laws, self.functions))
        return laws, functions

    def price(self, h: Hypothesis) -> float:
        """Return the price of all members of `h`."""
        return sum(map(self.cost, h.fit.fit.chosen))

    def over_dispersion(self, candidate: Candidate, fit: RobotFit) -> float:
        """
        Return the over-dispersion of a candidate, by which the information of each joint is less.

        Args:
            candidate: effect or function.
            fit: whose weights tell how much each joint says.
        """
        return 1.0 / sum(share / float(self.dispersion[j])
                         for j, share in informed(self.likelihood, candidate, fit).items())

    def loads(self, fit: RobotFit) -> Array:
        """
        Return the deviation of a scale of each joint's torque [J] that the loads of a fit make.

        One mass is one number; joints read it in scales of their own, and none of that is a
        finding.
        """
        recordings = self.likelihood.recordings
        tolerance, loads = recordings[0].robot.torque_tolerance, np.zeros(self.likelihood.joints)
        for i, c in enumerate(fit.chosen if tolerance else ()):
            for j, x in fit.torque(i).items() if c.link else ():
                whole = sum(float(np.sum(rows.model[j] ** 2)) for rows in recordings)
                loads[j] += float(np.sum(x ** 2)) / max(whole, 1e-30)
        return np.asarray(tolerance * np.sqrt(loads))

    def of_days(self, candidate: Candidate, loads: Array) -> Array:
        """
        Return the covariance [k, k] of a candidate's coefficients between healthy parts and days.

        A short reference leaves open a torque of any shape, up to a share of the effort of each
        joint: the force of a slide tells nothing about a wrist.

        Args:
            candidate: effect or function.
            loads: deviations of the scale of each joint's torque [J].
        """
        scatter = self.scatter.get(key_of(candidate))
        out = np.zeros((candidate.width, candidate.width))
        if scatter is not None and len(scatter) == candidate.width:
            out = np.diag(scatter ** 2)
        if candidate.effect == TORQUE_GAIN.id:
            out = out + loads[list(candidate.columns)] ** 2
        if not self.day:
            return out
        inner = sum((x.T @ x / self._efforts[j] for j, x in candidate.columns.items()),
                    np.zeros_like(out))
        size = np.sqrt(np.diag(inner)) + 1e-30
        inverse = np.linalg.pinv(inner / np.outer(size, size), 1e-9) / np.outer(size, size)
        return out + self.day ** 2 * len(candidate.columns) * inverse

    def gain(self, less: Hypothesis, more: Hypothesis) -> float:
        """Return by how much `more` beats `less`, beyond what differs between parts and days."""
        return float(more.fit.gained - less.fit.gained)

    def likeness(self, less: Hypothesis, more: Hypothesis) -> float:
        """
        Return what `more` gains over `less` beyond its price, not tempered by days.

        How much an effect scatters between healthy parts says nothing against it as the name of a
        large change. Members that were grown together share one over-dispersion; sets have that of
        their joint with the largest.
        """
        if more.fit.likeness is not None and len(more.members) == len(less.members) + 1:
            return float(more.fit.likeness)
        phi = max([self.over_dispersion(c, more.fit.fit) for c in more.fit.fit.chosen] or [1.0])
        return (less.deviance - more.deviance) / phi - self.price(more) + self.price(less)

    def reach(self, h: Hypothesis) -> float:
        """Return what any other explanation gains over `h` at most: nothing bounds it."""
        return math.inf

    # --- fits

    def none(self) -> Hypothesis:
        """Return the fit without members."""
        return Hypothesis((), self.blank.deviance, BalanceFit(self.blank))

    @cached_property
    def unstated(self) -> frozenset[Member]:
        """
        Friction and rotors of the joints for which the file states none.

        A URDF without them does not say that there are none.
        """
        motions = dict(zip(self.likelihood.recordings[0].robot.chain.joints,
                           self.likelihood.recordings[0].joints))

        def is_stated(c: Candidate) -> bool:
            m = motions[c.place]
            return bool(m.learnt or (m.armature if c.effect == MOTOR_INERTIA.id else
                                     m.coulomb or m.viscous))
        return frozenset(member_of(c) for c in self.laws if c.place in motions
                         and c.effect in UNSTATED and not is_stated(c))

    def with_unstated(self, none: Hypothesis) -> Hypothesis:
        """
        Return `none` with friction and rotors of all joints for which the file states none.

        All are fitted together: one alone would have to imitate those of the other joints.
        """
        chosen = tuple(c for c in self.laws if c.setting is None and member_of(c) in self.unstated)
        if not chosen:
            return none
        fit, gains = self._bounded(self.likelihood.fit(chosen, self.blank), len(chosen)), []
        chosen = fit.chosen
        for i in range(len(chosen)):
            c, others = apart(chosen, i)
            gains.append(self.tempered_gain(self.likelihood.fit(others, fit, 2),
                                            self.likelihood.fit((*others, c), fit, 2)))
        return Hypothesis(tuple(map(member_of, chosen)), fit.deviance, BalanceFit(
            fit, sum(gains), tuple(g - self.cost(c) for g, c in zip(gains, chosen))))

    def _bounded(self, fit: RobotFit, count: int) -> RobotFit:
        """Return `fit` without unstated candidates at a bound, of its first `count`."""
        while out := {c.name for c, ok in zip(fit.chosen[:count], _possible(self.likelihood, fit))
                      if not ok and member_of(c) in self.unstated}:
            kept = tuple(c for c in fit.chosen if c.name not in out)
            fit = self.likelihood.fit(kept, fit, 4)
            count -= len(out)
        return fit

    def dispersed(self, dispersion: float | None) -> 'BalanceEvidence':
        """Return the evidence itself: references and parts tell the dispersion of each joint."""
        return self

    def moved(self, h: Hypothesis) -> Hypothesis:
        """Return a hypothesis `h` of evidence on the same recordings."""
        return h

    def settled(self, h: Hypothesis, remains: Remains) -> None:
        """Return None, whatever `remains` of `h`: all nuisances are coefficients of each fit."""

    def variants(self, h: Hypothesis, remains: Remains) -> Sequence['BalanceEvidence']:
        """Return nothing, whatever `remains` of `h`: friction of any shape is a coefficient."""
        return ()

    def trains(self, h: Hypothesis, best: Hypothesis) -> Sequence[Hypothesis]:
        """Return nothing for `h` and the `best` one: bursts of a robot are a remainder."""
        return ()

    def estimates(self, h: Hypothesis) -> list[MemberEstimate]:
        """
        Return the laws that may be added to `h`, each at its settings, the best first.

        Where only a function without a law explains a joint, the model is not true: no further law
        is a finding.
        """
        return self.estimates_of(h, () if h.function else self.laws)

    def remains(self, h: Hypothesis, thorough: bool = False) -> Remains:
        """Return what remains beside `h`, `thorough` or not: functions without a law."""
        functions = self.estimates_of(h, () if h.function else self.functions)
        return Remains(-math.inf, -math.inf, functions[0].worth if functions else -math.inf,
                       tuple(functions), 1.0)

    def estimates_of(self, h: Hypothesis, field: Sequence[Candidate]) -> list[MemberEstimate]:
        """Return the candidates of a `field` that `h` lacks, by a score test, the best first."""
        fit: RobotFit = h.fit.fit
        taken, loads = {c.name for c in fit.chosen}, self.loads(fit)
        field = [c for c in field if c.name not in taken]
        out = [MemberEstimate(member_of(c), tempered(
            e.gain, (e.values, e.covariance), self.of_days(c, loads),
            self.over_dispersion(c, fit)), self.cost(c), c)
            for c, e in zip(field, self.likelihood.estimates(fit, field))]
        return sorted(out, key=lambda e: -e.worth)

    def grown(self, h: Hypothesis, added: Sequence[MemberEstimate]) -> list[Hypothesis]:
        """Return `h` with each of `added` that physics allows."""
        base: RobotFit = h.fit.fit
        fits = []
        for c in (e.source for e in added):
            fit = self.likelihood.fit((*base.chosen, c), base, 4)
            if c.at_setting is not None and base.deviance - fit.deviance > self.cost(c):
                fit = _refined(self.likelihood, fit)
            fit = self._bounded(fit, len(base.chosen))
            if all(_possible(self.likelihood, fit)):  # a new one moves the others
                fits.append((self.tempered_gain(base, fit), fit))
        if not fits:
            return []
        last = [fit.chosen[-1] for _, fit in fits]
        worth = [gain - self.cost(c) for (gain, _), c in zip(fits, last)]
        best = int(np.argmax(worth))
        phi = self.over_dispersion(last[best], fits[best][1])
        likeness = [(base.deviance - fit.deviance - self.likelihood.hidden(fit)) / phi
                    - self.cost(c) for (_, fit), c in zip(fits, last)]
        # What pays is before what does not.
        likeness = [max(x, CONTEST.margin) if own > CONTEST.margin else own
                    for x, own in zip(likeness, worth)]
        _carried_outermost(last, likeness)
        known = {c.name: w for c, w in zip(base.chosen, h.fit.worth)}
        return [Hypothesis(tuple(map(member_of, fit.chosen)), fit.deviance, BalanceFit(
            fit, h.fit.gained + gain, (*(known[c.name] for c in fit.chosen[:-1]), own), like))
            for (gain, fit), own, like in zip(fits, worth, likeness)]

    def without(self, h: Hypothesis, number: int) -> Hypothesis:
        """Return `h` without its member `number`, refitted."""
        known, (c, others) = h.fit, apart(h.fit.fit.chosen, number)
        less = self.likelihood.fit(others, known.fit, 4)
        lost = self.tempered_gain(less, self.likelihood.fit((*others, c), known.fit, 2))
        return Hypothesis(apart(h.members, number)[1], less.deviance, BalanceFit(
            less, known.gained - lost, apart(known.worth, number)[1]))

    def rivals(self, h: Hypothesis, number: int) -> dict[str, float]:
        """Return {effect, with its place: lag} of what explains as much as `number` of `h`."""
        c, base = h.fit.fit.chosen[number], self.without(h, number)
        estimates = self.estimates_of(base, self.laws)
        most = max((e.worth for e in estimates), default=0.0)
        least = min(CONTEST.close * most, most - 2.0 * CONTEST.margin)
        near = [e for e in estimates if e.worth > least]
        race = self.grown(base, [*leading(near, CONTEST.screened, False),
                                 MemberEstimate(h.members[number], 0.0, 0.0, c)])
        best = {e.members[-1]: e.fit for e in sorted(race, key=lambda e: e.fit.likeness)}
        winner = best.pop(h.members[number], None)
        lags: dict[str, float] = {}
        for m, e in sorted(best.items(), key=lambda item: -item[1].likeness):
            if winner and e.worth[-1] > 0.0 and e.likeness > winner.likeness - CONTEST.margin:
                name = (f'{m.effect}@{m.place}' if m.place != c.place else
                        f'{m.effect} ({m.over})' if m.effect == c.effect else m.effect)
                lags.setdefault(name, max(winner.likeness - e.likeness, 0.0))
        return {**lags, **dict.fromkeys(c.twins, 0.0)}

    def tempered_gain(self, less: RobotFit, fit: RobotFit) -> float:
        """Return the tempered gain of what `fit` adds to `less`."""
        c, own, k = fit.chosen[-1], fit.of(len(fit.chosen) - 1), len(self.likelihood.labels)
        columns = slice(k + own.start, k + own.stop)
        covariance = fit.covariance[columns, columns] / np.outer(fit.scale[own], fit.scale[own])
        gain = less.deviance - fit.deviance - self.likelihood.hidden(fit)
        return gain if gain <= 0.0 else float(tempered(
            gain, (fit.values[own], covariance), self.of_days(c, self.loads(less)),
            self.over_dispersion(c, fit)))


def apart(items: Sequence[Any], number: int) -> tuple[Any, tuple[Any, ...]]:
    """Return item `number` of `items` and all others."""
    return items[number], (*items[:number], *items[number + 1:])


def member_of(c: Candidate) -> Member:
    """Return the candidate `c` as a member."""
    return Member(FUNCTION if c.free else LAW, c.effect, c.place, c.over)


def _carried_outermost(last: Sequence[Candidate], likeness: list[float]) -> None:
    """
    Let the outermost of the links that carry a load alike be the likeliest of them, in place.

    Args:
        last: candidates of a race.
        likeness: of each.
    """
    first = int(np.argmax(likeness))
    if last[first].effect == PAYLOAD.id:
        alike = [i for i, c in enumerate(last) if c.effect == PAYLOAD.id
                 and likeness[i] > likeness[first] - CONTEST.margin
                 and c.columns.keys() >= last[first].columns.keys()]
        outermost = max(alike, key=lambda i: len(last[i].columns))
        likeness[outermost] = math.nextafter(likeness[first], math.inf)


def gain_at(likelihood: RobotLikelihood, blank: RobotFit, fit: RobotFit, joint: int) -> float:
    """Return by how much 2 log likelihood of a joint's rows by `fit` is above that of `blank`."""
    count = likelihood.at[joint].count
    return float((count * np.log(fit.weights[joint] / blank.weights[joint])).sum())


def informed(evidence: RobotLikelihood, candidate: Candidate, fit: RobotFit) -> dict[int, float]:
    """
    Return from which joints the information on a candidate comes.

    Args:
        evidence: of the recordings.
        candidate: of one or several joints.
        fit: whose variances count.

    Returns:
        {joint: share}, 1 in sum.
    """
    if len(candidate.columns) == 1:
        return dict.fromkeys(candidate.columns, 1.0)
    total = {}
    for j, x in candidate.columns.items():
        a = evidence.at[j]
        total[j] = float(a.spread(fit.weights[j]) @ (x[a.order] ** 2).sum(axis=1))
    whole = sum(total.values()) + 1e-300
    return {j: t / whole for j, t in total.items()}


def tempered(gain: float | Array, estimate: tuple[Array, Array], days: Array, dispersion: float,
             times: float | Array = 1.0) -> Any:
    """
    Return what of a gain in 2 log likelihood is more than healthy parts and days differ by.

    Over-dispersion divides the gain; what days differ by adds to the variance of the values.

    Args:
        gain: of the values, or of each of several sizes.
        estimate: values [k] and covariance [k, k] of the likelihood.
        days: covariance [k, k] between healthy parts and days.
        dispersion: of the joint.
        times: size of the values, over those of `estimate`.
    """
    values, covariance = estimate
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-60))
    plain, b = covariance / np.outer(size, size), values / size
    plain = plain + 1e-9 * np.eye(len(b))
    wide = plain * dispersion + days / np.outer(size, size)
    own, tame = (float(b @ np.linalg.solve(x, b)) for x in (plain, wide))
    between = max(1.0 / max(tame, 1e-300) - dispersion / max(own, 1e-300), 0.0) / times ** 2
    return 1.0 / (dispersion / np.maximum(gain, 1e-300) + between)


def _possible(evidence: RobotLikelihood, fit: RobotFit) -> Iterator[bool]:
    """
    Yield of each candidate whether physics allows its values.

    No candidate may take more torque than effort and model together; two candidates that cancel
    each other would.
    """
    deviations = np.sqrt(np.diag(fit.covariance)[-len(fit.scale):]) / fit.scale
    for i, c in enumerate(fit.chosen):
        b = fit.values[fit.of(i)]
        torque = sum(float(np.sum(x ** 2)) for x in fit.torque(i).values())
        most = sum((math.sqrt(np.sum((rows.target[j] + rows.model[j]) ** 2))
                    + math.sqrt(np.sum(rows.model[j] ** 2))) ** 2
                   for rows in evidence.recordings for j in c.columns)
        yield torque <= most and c.allows(b, deviations[fit.of(i)])


def _refined(evidence: RobotLikelihood, fit: RobotFit) -> RobotFit:
    """
    Return `fit` with a better setting of its newest candidate.

    A place of mass by its fixed point, a speed or level by a search around the grid's.
    """
    c, base, remade = fit.chosen[-1], fit.chosen[:-1], fit.chosen[-1].at_setting
    assert remade is not None
    if c.next_setting is not None:
        for step in range(MOST_STEPS):
            c, before = remade(c.next_setting(fit.values[fit.of(len(base))])), fit.deviance
            fit = evidence.fit((*base, c), fit, 3)
            if step > 1 and abs(before - fit.deviance) < LEAST_GAIN:
                break
        return fit
    # Beyond, the next of the grid is nearer; speeds and limits lie further apart.
    reach = 1.6 if c.effect in (STRIBECK.id, SATURATION.id) else 1.2
    bounds = (c.setting - SIDE * c.span, c.setting + SIDE * c.span) if c.span else (
        c.setting / reach, c.setting * reach)
    trials = [fit]

    def deviance(setting: float) -> float:
        trials.append(evidence.fit((*base, remade(float(setting))), fit, 3))
        return trials[-1].deviance
    scipy.optimize.minimize_scalar(deviance, bounds=bounds, method='bounded',
                                   options={'xatol': SETTLED * (bounds[1] - bounds[0])})
    return min(trials, key=lambda trial: trial.deviance)


LARGEST = 1e6  # beyond it a motion does not show an effect at all

Sizes = Mapping[str, Mapping[str, float]]  # {effect: {place: size}}


def smallest_visible(evidence: BalanceEvidence, best: Hypothesis) -> dict[str, dict[str, float]]:
    """
    Return {effect: {place: smallest size that would have been a finding in this motion}}.

    Args:
        evidence: of the recordings.
        best: what explains them.
    """
    out: dict[str, dict[str, float]] = {}
    loads = evidence.loads(best.fit.fit)
    for c, e in zip(evidence.laws, evidence.likelihood.estimates(evidence.blank, evidence.laws)):
        size = visible_size(evidence, c, e.covariance, loads)
        if size is not None and c.high > 0.0:
            places = out.setdefault(c.effect, {})
            places[c.place] = min(places.get(c.place, math.inf), size)
    return {name: {p: v for p, v in places.items() if v < LARGEST}
            for name, places in out.items()}


def visible_size(evidence: BalanceEvidence, c: Candidate, covariance: Array, loads: Array
                 ) -> float | None:
    """
    Return the smallest size of a candidate that would be a finding, None where it has no one size.

    The variance of each joint is that of the recording itself: an effect that is large beside a
    few rows gains their number times the logarithm of its size, not its square.

    Args:
        evidence: of the recordings.
        c: the candidate.
        covariance: of its coefficients.
        loads: deviations of the scale of each joint's torque [J].
    """
    if c.values is None or c.effect in (SATURATION.id, SERVO_LIMIT.id):
        return None
    along = np.zeros(c.width)
    along[0] = 1.0
    if c.effect == PAYLOAD.id and c.link is not None:
        links = {link.name: link
                 for link in evidence.likelihood.recordings[0].robot.chain.links}
        along[1:4] = links[c.link].theta[1:4] / links[c.link].mass
    gain = float(along @ np.linalg.solve(covariance, along))
    rows = evidence.likelihood.rows_in(c)
    sizes = np.geomspace(1.0, 1e6, 400) / math.sqrt(max(gain, 1e-300))
    worth = tempered(rows * np.log1p(sizes ** 2 * gain / rows), (along, covariance),
                     evidence.of_days(c, loads), evidence.over_dispersion(c, evidence.blank),
                     sizes) - evidence.cost(c)
    if worth[-1] < CONTEST.margin:
        return math.inf
    size = float(sizes[np.argmax(worth >= CONTEST.margin)])
    value = abs(next(iter(c.values(size * along).values())))
    return value if math.isfinite(value) else None


def speed_of(evidence: RobotLikelihood, joint: int) -> tuple[float, float]:
    """Return the usual speed of a `joint`, and the length of the recordings of `evidence`, s."""
    recordings = evidence.recordings
    return (float(np.max([np.quantile(np.abs(rows.joints[joint].v), 0.9) for rows in recordings])),
            sum(len(rows.motion.t) * rows.motion.step for rows in recordings))


def questions(evidence: BalanceEvidence, visible: Sizes) -> tuple[Question, ...]:
    """
    Return what the recordings would not have shown.

    Args:
        evidence: of the recordings.
        visible: sizes that would have been findings.
    """
    likelihood, recordings, s = evidence.likelihood, evidence.likelihood.recordings, SETTINGS
    chain = recordings[0].robot.chain
    moves = [j for j in range(likelihood.joints)
             if max(rows.tests.share[j] for rows in recordings) > s.moving]
    out: list[Question] = []

    def ask(effect: str, place: str, plausible: float, joint: int, width: int = 1) -> None:
        smallest = visible.get(effect, {}).get(place, math.inf)
        if smallest > plausible:
            out.append(of_size((effect, place, chain.joints[joint]), speed_of(likelihood, joint),
                               (smallest, plausible),
                               evidence.cost_of(width, likelihood.at[joint].rows)))
    for j in moves or range(likelihood.joints):
        effort = np.concatenate([rows.joints[j].effort for rows in recordings])
        size = math.sqrt(float(np.mean(effort ** 2)))
        ask(MOTOR_COULOMB.id, chain.joints[j], s.plausible_friction * size, j)
        if not recordings[0].setpoint:
            ask(TORQUE_GAIN.id, chain.joints[j], s.plausible_gain, j)
    for k, link in enumerate(chain.links):
        carried = sum(chain.links[i].mass for i in chain.movers[k])
        if link.mass > 0.0 and not any(other.parent == k for other in chain.links):
            ask(PAYLOAD.id, link.name, s.plausible_load * carried, k, 4)
    return tuple(sorted(out, key=lambda q: -(q.smallest or 0.0) / (q.plausible or 1.0)))
