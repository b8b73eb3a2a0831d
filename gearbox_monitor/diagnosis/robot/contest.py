# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The contest: laws and functions without a law compete for what the nuisance leaves.

One more effect is taken while it pays by extended BIC (Chen and Chen, 2008), beyond what differs
between healthy parts and beyond the over-dispersion of its joint. Where a function without a law
pays more than every law, the cause is unknown.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.evidence import RobotEvidence, RobotFit
from gearbox_monitor.diagnosis.robot.knowledge import key_of, Knowledge
from gearbox_monitor.diagnosis.robot.robot_effects import PAYLOAD
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_GAIN
from gearbox_monitor.plant.effects.motor_side import STRIBECK

PER_NAME = 2          # settings of one effect among the finalists
STEPS = (1.25, 1.08, 1.025)
MOST_STEPS = 12       # of a fixed point
LEAST_GAIN = 0.3      # of deviance, for which a setting is moved
SIDE = 0.5            # of the motion's deviation: beyond, the next of a grid is nearer


@dataclass(frozen=True, eq=False)
class ContestScales:
    """
    What the evidence of a candidate is measured by.

    scatter: {key: deviations} between healthy parts; dispersion [J]; names: number of laws;
    lawless: number of functions. Where references are short: extra, cost of each; day: share of
    the effort by which days may differ. loads [J]: deviation of a scale of the torque that loads
    found so far make, which the scale of each joint's effort allows.
    """

    scatter: dict[str, Array]
    dispersion: Array
    names: int
    lawless: int
    extra: float = 0.0
    day: float = 0.0
    loads: Array | None = None


def scales_of(laws: Sequence[Candidate], free: Sequence[Candidate], knowledge: Knowledge | None,
              joints: int) -> ContestScales:
    """
    Return the ContestScales of a contest.

    Args:
        laws: candidates.
        free: functions.
        knowledge: of references, None without one.
        joints: of the robot.
    """
    names, lawless = (max(len({c.name for c in field}), 1) for field in (laws, free))
    if knowledge is None:
        return ContestScales({}, np.ones(joints), names, lawless)
    return ContestScales(dict(knowledge.scatter), knowledge.dispersion, names, lawless)


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


def over_dispersion(evidence: RobotEvidence, candidate: Candidate, scales: ContestScales,
                    fit: RobotFit) -> float:
    """
    Return the over-dispersion of a candidate, of several joints by their information.

    Args:
        evidence: of the recordings.
        candidate: effect or function.
        scales: with the over-dispersion of each joint.
        fit: whose weights tell how much each joint says.
    """
    return sum(share * float(scales.dispersion[j])
               for j, share in informed(evidence, candidate, fit).items())


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


def of_days(evidence: RobotEvidence, candidate: Candidate, scales: ContestScales) -> Array:
    """
    Return the covariance [k, k] of the coefficients of a candidate between healthy parts and days.

    Of a torque of any of its shapes a short reference leaves a share of the effort open.

    Args:
        evidence: of the recordings.
        candidate: effect or function.
        scales: with the scatter of references.
    """
    scatter = scales.scatter.get(key_of(candidate))
    out = np.diag(scatter ** 2) if scatter is not None and len(scatter) == candidate.width else (
        np.zeros((candidate.width, candidate.width)))
    if candidate.effect == TORQUE_GAIN.id and scales.loads is not None:
        out = out + scales.loads[list(candidate.columns)] ** 2
    if not scales.day:
        return out
    effort = sum(float(np.sum((rows.target[j] + rows.model[j]) ** 2))
                 for rows in evidence.recordings for j in candidate.columns)
    inner = np.sum([x.T @ x for x in candidate.columns.values()], axis=0)
    size = np.sqrt(np.diag(inner)) + 1e-30
    inverse = np.linalg.pinv(inner / np.outer(size, size), 1e-9) / np.outer(size, size)
    return out + scales.day ** 2 * effort * inverse


def with_loads(evidence: RobotEvidence, fit: RobotFit, scales: ContestScales) -> ContestScales:
    """
    Return `scales` with what the scale of each joint's effort makes of the loads of a fit.

    One mass is one number; joints read it in scales of their own, and none of that is a finding.

    Args:
        evidence: of the recordings.
        fit: with the loads.
        scales: so far.
    """
    tolerance = evidence.recordings[0].robot.torque_tolerance
    loads = np.zeros(evidence.joints)
    for i, c in enumerate(fit.chosen if tolerance else ()):
        for j, x in c.columns.items() if c.link else ():
            whole = sum(float(np.sum(rows.model[j] ** 2)) for rows in evidence.recordings)
            loads[j] += float(np.sum((x @ fit.values[fit.of(i)]) ** 2)) / max(whole, 1e-30)
    return replace(scales, loads=tolerance * np.sqrt(loads))


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


def cost(evidence: RobotEvidence, candidate: Candidate, scales: ContestScales) -> float:
    """
    Return the extended BIC of a candidate: ln n per parameter and the choice among all.

    Args:
        evidence: of the recordings, with the number n of rows.
        candidate: effect or function.
        scales: with the number of its rivals.
    """
    count = scales.lawless if candidate.free else scales.names
    return float(candidate.size * np.log(max(evidence.rows_in(candidate), 3.0))
                 + 2.0 * np.log(count)) + scales.extra


def contest(evidence: RobotEvidence, current: RobotFit, candidates: Sequence[Candidate],
            scales: ContestScales, finalists: int) -> list[Contender]:
    """
    Return the candidates that pay most, as Contenders: those that pay first, the likest first.

    Args:
        evidence: of the recordings.
        current: fit so far.
        candidates: to add one of.
        scales: of their evidence.
        finalists: number of candidates of the score test that are fitted.
    """
    names = {c.name for c in current.chosen}
    field = [c for c in candidates if c.name not in names]
    worth = []
    for c, e in zip(field, evidence.estimates(current, field)):
        worth.append(tempered(e.gain, (e.values, e.covariance), of_days(evidence, c, scales),
                              over_dispersion(evidence, c, scales, current))
                     - cost(evidence, c, scales))
    chosen: list[Candidate] = []
    count: dict[tuple[str, str, str], int] = {}
    for i in np.argsort(-np.array(worth)):
        c = field[i]
        if count.get(c.name, 0) < PER_NAME and (worth[i] > -40.0 or not chosen):
            count[c.name] = count.get(c.name, 0) + 1
            chosen.append(c)
        if len(chosen) == finalists:
            break
    fits = []
    for c in chosen:
        fit = evidence.fit((*current.chosen, c), current.weights, 4)
        gain = current.deviance - fit.deviance
        if c.at_setting is not None and gain > cost(evidence, c, scales):
            fit = _refined(evidence, fit)
        if _allowed(fit):
            fits.append((worth_of(evidence, current, fit, scales), fit))
    if not fits:
        return []
    likeliest = max(fits, key=lambda e: e[0])[1]
    phi = over_dispersion(evidence, likeliest.chosen[-1], scales, likeliest)
    entries = [Contender(own, fit, (current.deviance - fit.deviance - evidence.hidden(fit)) / phi
                         - cost(evidence, fit.chosen[-1], scales)) for own, fit in fits]

    def rank(e: Contender) -> tuple[bool, float]:
        pays = e.worth >= SETTINGS.margin
        return pays, e.likeness if pays else e.worth
    entries.sort(key=rank, reverse=True)
    # What explains the same by fewer coefficients is first: of a first link some have no torque.
    pays, largest = rank(entries[0])
    same = sum(rank(e) > (pays, largest - LEAST_GAIN) for e in entries)
    entries = sorted(entries[:same], key=lambda e: e.candidate.width) + entries[same:]
    if entries[0].candidate.effect != PAYLOAD.id:
        return entries
    # Of links that carry a load alike it hangs at the outermost, which most joints move.
    carriers = [e for e in entries if e.candidate.effect == PAYLOAD.id
                and rank(e) > (pays, largest - SETTINGS.margin)
                and e.candidate.columns.keys() >= entries[0].candidate.columns.keys()]
    outermost = max(carriers, key=lambda e: len(e.candidate.columns))
    return [outermost, *(e for e in entries if e is not outermost)]


def worth_of(evidence: RobotEvidence, current: RobotFit, fit: RobotFit,
             scales: ContestScales) -> float:
    """
    Return the tempered gain of the candidate that `fit` adds to `current`, less its cost.

    Args:
        evidence: of the recordings.
        current: fit without the candidate.
        fit: with the candidate as its newest.
        scales: of the evidence of candidates.
    """
    c, own = fit.chosen[-1], fit.of(len(fit.chosen) - 1)
    k = len(evidence.labels)
    columns = slice(k + own.start, k + own.stop)
    covariance = fit.covariance[columns, columns] / np.outer(fit.scale[own], fit.scale[own])
    gain = current.deviance - fit.deviance - evidence.hidden(fit)
    if gain > 0.0:
        gain = tempered(gain, (fit.values[own], covariance), of_days(evidence, c, scales),
                        over_dispersion(evidence, c, scales, fit))
    return gain - cost(evidence, c, scales)


def _allowed(fit: RobotFit) -> bool:
    """Return whether physics allows the values of all candidates: a new one moves the others."""
    deviations = np.sqrt(np.diag(fit.covariance)[-len(fit.scale):]) / fit.scale
    return all(c.allows(fit.values[fit.of(i)], deviations[fit.of(i)])
               for i, c in enumerate(fit.chosen))


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
            fit = evidence.fit((*base, c), fit.weights, 3)
            if step > 1 and abs(before - fit.deviance) < LEAST_GAIN:
                break
        return fit
    middle, span = float(c.setting), c.span
    # Beyond, the next of the grid is nearer; speeds and limits lie further apart.
    reach = 1.6 if c.effect in (STRIBECK.id, SATURATION.id) else 1.2
    for factor in STEPS:
        for direction in (1.0, -1.0):
            while True:
                assert c.setting is not None
                if span:
                    setting = float(c.setting) + direction * (factor - 1.0) * span
                    in_range = abs(setting - middle) <= SIDE * span
                else:
                    setting = float(c.setting) * factor ** direction
                    in_range = 1.0 / reach <= setting / middle <= reach
                if not in_range:
                    break
                candidate = remade(setting)
                trial = evidence.fit((*base, candidate), fit.weights, 3)
                if trial.deviance > fit.deviance - LEAST_GAIN:
                    break
                c, fit = candidate, trial
    return fit


def pruned(evidence: RobotEvidence, fit: RobotFit,
           scales: ContestScales) -> tuple[RobotFit, list[int]]:
    """
    Return a fit without what no longer pays beside the newer candidates, and who stayed.

    Args:
        evidence: of the recordings.
        fit: with its candidates.
        scales: of their evidence.
    """
    numbers = list(range(len(fit.chosen)))
    while len(numbers) > 1:
        worth = []
        for i in range(len(fit.chosen)):
            ordered = (*fit.chosen[:i], *fit.chosen[i + 1:], fit.chosen[i])
            less = evidence.fit(ordered[:-1], fit.weights, 4)
            whole = evidence.fit(ordered, fit.weights, 2)
            worth.append(worth_of(evidence, less, whole, scales))
        i = int(np.argmin(worth))
        if worth[i] >= SETTINGS.margin:
            break
        fit = evidence.fit((*fit.chosen[:i], *fit.chosen[i + 1:]), fit.weights, 4)
        del numbers[i]
    return fit, numbers
