# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The contest: laws and functions without a law compete for what the nuisance leaves.

One more effect is taken while it pays by extended BIC (Chen and Chen, 2008), beyond what differs
between healthy parts and beyond the over-dispersion of its joint. Where a function without a law
pays more than every law, the cause is unknown.

The power of a motion is the smallest size of each effect that would have been a finding. Where a
change of plausible size would not have been one, `none` says nothing: the verdict is undecided,
and names the motion that would decide.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.contest import CONTEST, of_size, Question
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.evidence import RobotEvidence, RobotFit
from gearbox_monitor.diagnosis.robot.knowledge import key_of, Knowledge
from gearbox_monitor.diagnosis.robot.robot_effects import COUPLING, PAYLOAD
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_GAIN
from gearbox_monitor.plant.effects.controller import SERVO_LIMIT
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, STRIBECK

PER_NAME = 2          # settings of one effect among the finalists
SETTLED = 0.005       # of the range of a setting that is searched
MOST_STEPS = 12       # of a fixed point
LEAST_GAIN = 0.3      # of deviance, that matters
SIDE = 0.5            # of the motion's deviation: beyond, the next of a grid is nearer


@dataclass(frozen=True, eq=False)
class Contender:
    """
    A candidate in the contest: its worth beyond its cost, and the fit with it.

    worth: of the gain beyond what differs between healthy parts: whether there is an effect.
    likeness: of the whole gain, over one over-dispersion for all: which effect it is. How much an
    effect scatters between healthy parts says nothing against it as the name of a large change.
    """

    worth: float
    fit: RobotFit
    likeness: float

    @property
    def candidate(self) -> Candidate:
        """The candidate that was added."""
        return self.fit.chosen[-1]


@dataclass(frozen=True, eq=False)
class RobotContest:
    """
    What candidates compete for, and what their evidence is measured by.

    evidence: of the recordings. scatter: {key: deviations} between healthy parts; dispersion [J];
    names: number of laws; lawless: number of functions. Where references are short: extra, cost of
    each; day: share of the effort by which days may differ. loads [J]: deviation of a scale of the
    torque that loads found so far make, which the scale of each joint's effort allows.
    """

    evidence: RobotEvidence
    scatter: dict[str, Array]
    dispersion: Array
    names: int
    lawless: int
    extra: float = 0.0
    day: float = 0.0
    loads: Array | None = None

    @classmethod
    def between(cls, evidence: RobotEvidence, laws: Sequence[Candidate],
                free: Sequence[Candidate], knowledge: Knowledge | None) -> 'RobotContest':
        """
        Return the contest between laws and functions.

        Args:
            evidence: of the recordings.
            laws: candidates.
            free: functions.
            knowledge: of references, None without one.
        """
        names, lawless = (max(len({c.name for c in field}), 1) for field in (laws, free))
        return cls(evidence, dict(knowledge.scatter) if knowledge else {},
                   knowledge.dispersion if knowledge else np.ones(evidence.joints), names, lawless)

    def over_dispersion(self, candidate: Candidate, fit: RobotFit) -> float:
        """
        Return the over-dispersion of a candidate, of several joints by their information.

        Args:
            candidate: effect or function.
            fit: whose weights tell how much each joint says.
        """
        return sum(share * float(self.dispersion[j])
                   for j, share in informed(self.evidence, candidate, fit).items())

    def of_days(self, candidate: Candidate) -> Array:
        """
        Return the covariance [k, k] of a candidate's coefficients between healthy parts and days.

        Of a torque of any of its shapes a short reference leaves a share of the effort open.
        """
        scatter = self.scatter.get(key_of(candidate))
        out = np.zeros((candidate.width, candidate.width))
        if scatter is not None and len(scatter) == candidate.width:
            out = np.diag(scatter ** 2)
        if candidate.effect == TORQUE_GAIN.id and self.loads is not None:
            out = out + self.loads[list(candidate.columns)] ** 2
        if not self.day:
            return out
        effort = sum(float(np.sum((rows.target[j] + rows.model[j]) ** 2))
                     for rows in self.evidence.recordings for j in candidate.columns)
        inner = np.sum([x.T @ x for x in candidate.columns.values()], axis=0)
        size = np.sqrt(np.diag(inner)) + 1e-30
        inverse = np.linalg.pinv(inner / np.outer(size, size), 1e-9) / np.outer(size, size)
        return out + self.day ** 2 * effort * inverse

    def beside(self, fit: RobotFit) -> 'RobotContest':
        """
        Return the contest with what the scale of each joint's effort makes of the loads of a fit.

        One mass is one number; joints read it in scales of their own, and none of that is a
        finding.
        """
        recordings = self.evidence.recordings
        tolerance, loads = recordings[0].robot.torque_tolerance, np.zeros(self.evidence.joints)
        for i, c in enumerate(fit.chosen if tolerance else ()):
            for j, x in fit.torque(i).items() if c.link else ():
                whole = sum(float(np.sum(rows.model[j] ** 2)) for rows in recordings)
                loads[j] += float(np.sum(x ** 2)) / max(whole, 1e-30)
        return replace(self, loads=tolerance * np.sqrt(loads))

    def cost(self, candidate: Candidate) -> float:
        """Return the extended BIC of a candidate: ln n per parameter and the choice among all."""
        return self.price(candidate.size, self.evidence.rows_in(candidate),
                          self.lawless if candidate.free else self.names)

    def price(self, size: int, rows: float, rivals: int = 0) -> float:
        """Return the cost of `size` parameters by some `rows` among rivals; 0: among all laws."""
        return float(size * np.log(max(rows, 3.0)) + 2.0 * np.log(
            rivals or self.names)) + self.extra

    def worth(self, current: RobotFit, fit: RobotFit) -> float:
        """Return the tempered gain of what `fit` adds to `current`, less its cost."""
        c, own, k = fit.chosen[-1], fit.of(len(fit.chosen) - 1), len(self.evidence.labels)
        columns = slice(k + own.start, k + own.stop)
        covariance = fit.covariance[columns, columns] / np.outer(fit.scale[own], fit.scale[own])
        gain = current.deviance - fit.deviance - self.evidence.hidden(fit)
        if gain > 0.0:
            gain = tempered(gain, (fit.values[own], covariance), self.of_days(c),
                            self.over_dispersion(c, fit))
        return gain - self.cost(c)

    def entries(self, current: RobotFit, candidates: Sequence[Candidate],
                finalists: int) -> list[Contender]:
        """
        Return the candidates that pay most: those that pay first, the likest first.

        Args:
            current: fit so far.
            candidates: to add one of.
            finalists: number of candidates of the score test that are fitted.
        """
        fits = []
        for c in self._promising(current, candidates, finalists):
            fit = self.evidence.fit((*current.chosen, c), current, 4)
            if c.at_setting is not None and current.deviance - fit.deviance > self.cost(c):
                fit = _refined(self.evidence, fit)
            if _allowed(self.evidence, fit):
                fits.append((self.worth(current, fit), fit))
        if not fits:
            return []
        likeliest = max(fits, key=lambda e: e[0])[1]
        phi = self.over_dispersion(likeliest.chosen[-1], likeliest)
        entries = [Contender(own, fit, (
            current.deviance - fit.deviance - self.evidence.hidden(fit)) / phi
            - self.cost(fit.chosen[-1])) for own, fit in fits]

        def rank(e: Contender) -> tuple[bool, float]:
            pays = e.worth >= CONTEST.margin
            return pays, e.likeness if pays else e.worth
        entries.sort(key=rank, reverse=True)
        # What explains the same by fewer coefficients is first: of a first link some have no
        # torque.
        pays, largest = rank(entries[0])
        same = sum(rank(e) > (pays, largest - LEAST_GAIN) for e in entries)
        entries = sorted(entries[:same], key=lambda e: e.candidate.width) + entries[same:]
        if entries[0].candidate.effect != PAYLOAD.id:
            return entries
        # Of links that carry a load alike it hangs at the outermost, which most joints move.
        carriers = [e for e in entries if e.candidate.effect == PAYLOAD.id
                    and rank(e) > (pays, largest - CONTEST.margin)
                    and e.candidate.columns.keys() >= entries[0].candidate.columns.keys()]
        outermost = max(carriers, key=lambda e: len(e.candidate.columns))
        return [outermost, *(e for e in entries if e is not outermost)]

    def _promising(self, current: RobotFit, candidates: Sequence[Candidate],
                   finalists: int) -> list[Candidate]:
        """Return the finalists of a score test, a few settings of each name; see entries."""
        names = {c.name for c in current.chosen}
        field = [c for c in candidates if c.name not in names]
        worth = np.array([tempered(
            e.gain, (e.values, e.covariance), self.of_days(c), self.over_dispersion(c, current))
            - self.cost(c) for c, e in zip(field, self.evidence.estimates(current, field))])
        chosen: list[Candidate] = []
        count: dict[tuple[str, str, str], int] = {}
        for i in np.argsort(-worth):
            c = field[i]
            if count.get(c.name, 0) < PER_NAME and (worth[i] > -40.0 or not chosen):
                count[c.name] = count.get(c.name, 0) + 1
                chosen.append(c)
            if len(chosen) == finalists:
                break
        return chosen

    def pruned(self, fit: RobotFit) -> tuple[RobotFit, list[int]]:
        """Return `fit` without what no longer pays beside newer candidates, and who stayed."""
        numbers = list(range(len(fit.chosen)))
        while len(numbers) > 1:
            worth = []
            for i in range(len(fit.chosen)):
                ordered = (*fit.chosen[:i], *fit.chosen[i + 1:], fit.chosen[i])
                less = self.evidence.fit(ordered[:-1], fit, 4)
                worth.append(self.worth(less, self.evidence.fit(ordered, fit, 2)))
            i = int(np.argmin(worth))
            if worth[i] >= CONTEST.margin:
                break
            fit = self.evidence.fit((*fit.chosen[:i], *fit.chosen[i + 1:]), fit, 4)
            del numbers[i]
        return fit, numbers

    def score(self, blank: RobotFit, fit: RobotFit) -> float:
        """Return what all candidates of `fit` gain over `blank` beyond their costs."""
        phi = max((self.over_dispersion(c, fit) for c in fit.chosen), default=1.0)
        return (blank.deviance - fit.deviance) / phi - sum(self.cost(c) for c in fit.chosen)


def informed(evidence: RobotEvidence, candidate: Candidate, fit: RobotFit) -> dict[int, float]:
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


def _allowed(evidence: RobotEvidence, fit: RobotFit) -> bool:
    """
    Return whether physics allows the values of all candidates: a new one moves the others.

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
        if torque > most or not c.allows(b, deviations[fit.of(i)]):
            return False
    return True


def _refined(evidence: RobotEvidence, fit: RobotFit) -> RobotFit:
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


def smallest_visible(contest: RobotContest, fit: RobotFit, laws: Sequence[Candidate]
                     ) -> dict[str, dict[str, float]]:
    """
    Return {effect: {place: smallest size that would have been a finding in this motion}}.

    Args:
        contest: of the recordings.
        fit: of them.
        laws: candidates.
    """
    out: dict[str, dict[str, float]] = {}
    for c, e in zip(laws, contest.evidence.estimates(fit, laws)):
        size = visible_size(contest, fit, c, e.covariance)
        if size is not None and c.high > 0.0:
            places = out.setdefault(c.effect, {})
            places[c.place] = min(places.get(c.place, math.inf), size)
    return {name: {p: v for p, v in places.items() if v < LARGEST}
            for name, places in out.items()}


def visible_size(contest: RobotContest, fit: RobotFit, c: Candidate, covariance: Array
                 ) -> float | None:
    """
    Return the smallest size of a candidate that would be a finding, None where it has no one size.

    The variance of each joint is that of the recording itself: an effect that is large beside a
    few rows gains their number times the logarithm of its size, not its square.

    Args:
        contest: of the recordings.
        fit: of them.
        c: the candidate.
        covariance: of its coefficients.
    """
    if c.values is None or c.effect in (COUPLING.id, SATURATION.id, SERVO_LIMIT.id):
        return None
    along = np.zeros(c.width)
    along[0] = 1.0
    if c.effect == PAYLOAD.id and c.link is not None:
        links = {link.name: link
                 for link in contest.evidence.recordings[0].robot.chain.links}
        along[1:4] = links[c.link].theta[1:4] / links[c.link].mass
    gain = float(along @ np.linalg.solve(covariance, along))
    rows = contest.evidence.rows_in(c)
    sizes = np.geomspace(1.0, 1e6, 400) / math.sqrt(max(gain, 1e-300))
    worth = tempered(rows * np.log1p(sizes ** 2 * gain / rows), (along, covariance),
                     contest.of_days(c), contest.over_dispersion(c, fit), sizes) - contest.cost(c)
    if worth[-1] < CONTEST.margin:
        return math.inf
    size = float(sizes[np.argmax(worth >= CONTEST.margin)])
    value = abs(next(iter(c.values(size * along).values())))
    return value if math.isfinite(value) else None


def speed_of(evidence: RobotEvidence, joint: int) -> tuple[float, float]:
    """Return the usual speed of a `joint`, and the length of the recordings of `evidence`, s."""
    recordings = evidence.recordings
    return (float(np.max([np.quantile(np.abs(rows.joints[joint].v), 0.9) for rows in recordings])),
            sum(len(rows.motion.t) * rows.motion.step for rows in recordings))


def questions(contest: RobotContest, visible: Sizes) -> tuple[Question, ...]:
    """
    Return what the recordings would not have shown.

    Args:
        contest: of the recordings.
        visible: sizes that would have been findings.
    """
    evidence = contest.evidence
    chain, s, recordings = evidence.recordings[0].robot.chain, SETTINGS, evidence.recordings
    moves = [j for j in range(evidence.joints)
             if max(rows.tests.share[j] for rows in recordings) > s.moving]
    out: list[Question] = []

    def ask(effect: str, place: str, plausible: float, joint: int, width: int = 1) -> None:
        smallest = visible.get(effect, {}).get(place, math.inf)
        if smallest > plausible:
            out.append(of_size((effect, place, chain.joints[joint]), speed_of(evidence, joint),
                               (smallest, plausible),
                               contest.price(width, float(evidence.at[joint].count.sum()))))
    for j in moves or range(evidence.joints):
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
