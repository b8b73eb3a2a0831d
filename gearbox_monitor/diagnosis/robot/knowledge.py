# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What references teach of a robot: Knowledge, the prior of every comparison.

Friction in any shape, rotor inertias and wrong link inertias stand in a reference as in what is
compared with it. So they are learnt, until nothing more pays; what differs between healthy parts
of the references is measured for every effect, and their over-dispersion for every joint.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.diagnosis.robot.bursts import worst_segments
from gearbox_monitor.diagnosis.robot.candidates import Candidate, free_functions, library
from gearbox_monitor.diagnosis.robot.evidence import Prior, RobotEvidence, RobotFit
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog
from gearbox_monitor.diagnosis.robot.rows import nuisance_of, RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.diagnosis.robot.shapes import dictionary, shape_of
from gearbox_monitor.diagnosis.robot.visits import States, states_of, Visits, visits_of
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_RIPPLE
from gearbox_monitor.plant.effects.controller import SERVO_LIMIT
from gearbox_monitor.plant.effects.motor_side import COGGING

VERSION = 5
MOST_PARTS = 12
CALMED = 0.9  # the shapes have made parts alike where their over-dispersion falls to this
MOST_PASSES = 4


@dataclass(frozen=True, eq=False)
class Knowledge:
    """
    What healthy recordings of a robot taught.

    prior: of the nuisance, for another day. shapes: (joint, name) that its friction needs.
    scatter: {key of an effect: deviation of each coefficient between healthy parts}.
    dispersion [J]: squared misfit of the model between parts over what noise explains, 1 or more.
    bursts [J]: rms of the residual in the worst tenth of the segments, N m. visits: {joint:
    {variable: Visits}}; sizes [J]: rms of the taught torque, N m. variance [J, bands]: of what is
    left, per row: a part of it is no noise, and other recordings have it as well.
    joints, kind, measured, rate: of the logs; references: their names; seconds: their length;
    model: hash of the file; parts: number of parts compared. states: of all joints at once.
    """

    prior: Prior
    shapes: tuple[tuple[int, str], ...]
    scatter: Mapping[str, Array]
    dispersion: Array
    bursts: Array
    visits: Mapping[str, Mapping[str, Visits]]
    sizes: Array
    variance: Array
    joints: tuple[str, ...]
    kind: str
    measured: bool
    rate: float
    references: tuple[str, ...]
    seconds: float
    parts: int
    states: States
    model: str = ''
    version: int = VERSION

    @property
    def mean(self) -> dict[str, float]:
        """{label: coefficient} that was taught."""
        return dict(zip(self.prior.labels, self.prior.mean.tolist()))


def key_of(candidate: Candidate) -> str:
    """Return what names effect and place of `candidate` in a Knowledge, whatever its setting."""
    return '|'.join(candidate.name)


def learn(robot: RobotModel, logs: Sequence[RobotLog], model: str = '',
          progress: Callable[[int, int], None] = lambda done, of: None) -> Knowledge:
    """
    Return the Knowledge that `logs` of a healthy robot teach.

    Args:
        robot: its model; `learnt` must be set.
        logs: references.
        model: hash of the model's file.
        progress: called with (steps done, steps in sum).
    """
    shapes = _shapes(robot, logs, progress)
    recordings = [rows_of(log, robot, shapes) for log in logs]
    noisy = _noisy(recordings)
    for _ in range(2):     # the second time with the torque that the first one taught
        evidence = RobotEvidence(recordings, variance=noisy)
        prior = evidence.posterior(evidence.fit())
        mean = dict(zip(prior.labels, prior.mean.tolist()))
        recordings = [rows_of(log, robot, shapes, mean) for log in logs]
    evidence = RobotEvidence(recordings, variance=noisy)
    fit = evidence.fit()
    candidates = [c for c in library(recordings) + free_functions(recordings)
                  if c.effect not in (SATURATION.id, SERVO_LIMIT.id, COGGING.id, TORQUE_RIPPLE.id)]
    scatter, dispersion, parts = scattered(evidence, fit, candidates)
    progress(SETTINGS.rounds + 1, SETTINGS.rounds + 1)
    joints = range(evidence.joints)
    taught = [np.concatenate([r.joints[j].model - r.joints[j].load for r in recordings])
              for j in joints]
    return Knowledge(
        another_day(evidence, fit, dispersion), tuple(shapes), scatter, dispersion,
        worst_segments(evidence, fit),
        {name: visits_of(recordings, j) for j, name in enumerate(robot.chain.joints)},
        np.array([np.sqrt(np.mean(x ** 2)) for x in taught]),
        np.maximum(_variance(evidence, fit), noisy),
        logs[0].joints, logs[0].kind, logs[0].measured,
        float(np.median([log.rate for log in logs])), tuple(log.name for log in logs),
        sum(log.seconds for log in logs), parts,
        states_of(recordings), model)


def _noisy(recordings: Sequence[Rows]) -> Array:
    """
    Return a variance [J, bands] that is infinite where the model is worse than none, else 0.

    The acceleration that positions tell is noise from some frequency on, where a fit draws masses
    to 0: from the highest band down, those in which it leaves more than the effort are out. Where
    that is all of them, something else is wrong.
    """
    evidence = RobotEvidence(recordings)
    noisy = np.zeros((evidence.joints, len(SETTINGS.bands) - 1))
    open_joints = set(range(evidence.joints))
    while open_joints:
        fit = evidence.fit()
        for j in sorted(open_joints):
            a = evidence.at[j]
            effort = np.concatenate([r.target[j] + r.model[j] for r in recordings])[a.order]
            of_effort, of_residual = (np.bincount(a.band, [np.sum(x[c] ** 2) for c in a.cells])
                                      for x in (effort, fit.residual[j]))
            if of_residual[-1] <= of_effort[-1]:
                open_joints.discard(j)
            elif len(np.unique(a.band)) > 1:
                noisy[j, len(of_residual) - 1] = np.inf
            else:
                noisy[j] = 0.0
                open_joints.discard(j)
        evidence = RobotEvidence(recordings, variance=noisy)
    return noisy


def _variance(evidence: RobotEvidence, fit: RobotFit) -> Array:
    """Return the variance [J, bands] of what a fit leaves, 0 where there are no rows."""
    out = np.zeros((evidence.joints, len(SETTINGS.bands) - 1))
    for j, a in enumerate(evidence.at):
        total, rows = (np.bincount(a.band, x, out.shape[1])
                       for x in (a.count / fit.weights[j], a.count))
        out[j] = np.where(rows > 0.0, total / np.maximum(rows, 1e-9), 0.0)
    return out


def _shapes(robot: RobotModel, logs: Sequence[RobotLog],
            progress: Callable[[int, int], None]) -> list[tuple[int, str]]:
    """
    Return the shapes that references need: one more per joint and round while it pays.

    It pays if it gains more than the over-dispersion of the joint: where parts of the references
    differ, what one of them needs is no property of the joint.
    """
    shapes: list[tuple[int, str]] = []
    recordings = [rows_of(log, robot) for log in logs]
    joints, names = range(len(robot.chain.links)), list(dictionary())
    offers: list[list[Candidate]] = []
    for j in joints:
        offers.append([])
        for name in names:
            parts = [rows.tested(j, shape_of(name)(rows.joints[j])) for rows in recordings]
            offers[j].append(Candidate(name, {j: np.concatenate(parts)}))
    free = free_functions(recordings)
    evidence = RobotEvidence(recordings)
    fit = evidence.fit()
    dispersion = scattered(evidence, fit, free)[1]
    done, open_joints = 0, set(joints)
    for _ in range(MOST_PASSES):
        while open_joints and done < SETTINGS.rounds:
            progress(done, SETTINGS.rounds + 1)
            done += 1
            count = len(shapes)
            for j in sorted(open_joints):
                remaining = [c for c in offers[j] if (j, c.effect) not in shapes]
                rows = max(evidence.at[j].count.sum(), 3.0)
                worth = [e.gain / dispersion[j] - c.width * np.log(rows)
                         - 2.0 * np.log(len(names))
                         for c, e in zip(remaining, evidence.estimates(fit, remaining))]
                i = int(np.argmax(worth))
                if worth[i] > SETTINGS.margin:
                    shapes.append((j, remaining[i].effect))
                else:
                    open_joints.discard(j)
            if len(shapes) > count:
                recordings = [replace(rows, nuisance=tuple(nuisance_of(rows, shapes)))
                              for rows in recordings]
                evidence = RobotEvidence(recordings)
                fit = evidence.fit()
        before_pass, dispersion = dispersion, scattered(evidence, fit, free)[1]
        open_joints = set(np.flatnonzero(dispersion < CALMED * before_pass).tolist())
        if not open_joints or done >= SETTINGS.rounds:
            break
    return shapes


def another_day(evidence: RobotEvidence, fit: RobotFit, dispersion: Array) -> Prior:
    """
    Return the prior of another day.

    Dry friction of a joint scales as a whole, and so does viscous (temperature), a little of both
    column by column; the lag of a recording is its own.
    """
    prior = evidence.posterior(fit, dispersion)
    groups = [column.group for column in evidence.nuisance.values()]
    covariance = prior.covariance.copy()
    for group in {g for g in groups if g is not None}:
        whole = np.where([g == group for g in groups], prior.mean, 0.0)
        covariance += SETTINGS.drift ** 2 * np.outer(whole, whole)
    own = np.array([g is not None for g in groups])
    covariance += np.diag(np.where(own, SETTINGS.drift_own * prior.mean, 0.0) ** 2)
    keep = np.array([not column.own for column in evidence.nuisance.values()])
    return Prior(tuple(label for label, k in zip(prior.labels, keep) if k), prior.mean[keep],
                 covariance[np.ix_(keep, keep)])


def partitions(evidence: RobotEvidence) -> list[list[Array]]:
    """
    Return divisions of the references' segments [S] into parts: by time, by speed, by posture.

    Equal repeats of a motion do not differ over time; where the robot stands and how fast it
    moves, a wrong model differs even then.
    """
    number, speed, posture = [], [], []
    for i, rows in enumerate(evidence.recordings):
        hop = rows.tests.value.shape[0]
        for s in rows.tests.starts:
            number.append(i)
            speed.append(np.sqrt(np.mean(rows.motion.v[s:s + hop] ** 2, axis=0)))
            posture.append(rows.motion.q[s:s + hop].mean(axis=0))
    by_time, parts = [], 0
    for own in np.bincount(number):
        count = max(2 if len(evidence.recordings) == 1 else 1,
                    int(own * SETTINGS.hop / SETTINGS.part))
        by_time += (parts + np.arange(own) * count // own).tolist()
        parts += count
    out = [_parts(np.array(by_time))]
    for feature in (speed, posture):
        x = np.array(feature)
        x = (x - x.mean(axis=0)) / (x.std(axis=0) + 1e-9)
        main = x @ np.linalg.svd(x, full_matrices=False)[2][0]
        rank = np.argsort(np.argsort(main))
        out.append(_parts(rank * 3 // len(rank)))
    return [p for p in out if len(p) > 1]


def _parts(labels: Integers) -> list[Array]:
    """Return a flag [S] of each label."""
    values = np.unique(labels)
    if len(values) > MOST_PARTS:
        labels = np.searchsorted(values, labels) * MOST_PARTS // len(values)
        values = np.unique(labels)
    return [labels == v for v in values]


def scattered(evidence: RobotEvidence, fit: RobotFit, candidates: Sequence[Candidate]
              ) -> tuple[dict[str, Array], Array, int]:
    """
    Return what differs between healthy parts.

    Each part is compared with all others: an effect that acts in it alone would be 0 were the
    model true. The mean gain per coefficient of all effects of a joint is its over-dispersion; the
    variance of one effect's coefficients beyond it is the scatter of this effect.

    Args:
        evidence: of the references.
        fit: of their nuisance.
        candidates: effects and functions to compare.

    Returns:
        {key: deviation of each coefficient}, over-dispersion [J], number of parts.
    """
    joints = {name: j for j, name in enumerate(evidence.recordings[0].robot.chain.joints)}
    # One function at many settings would count as often.
    candidates = [c for c in candidates if not c.free or c.setting is None]
    table: dict[str, list[tuple[Array, Array]]] = {}
    over, count = np.ones(len(joints)), 0
    for division in partitions(evidence):
        division_gains: list[list[float]] = [[] for _ in joints]
        for flags in division:
            count += 1
            part = [flags[a.segment].astype(float) for a in evidence.at]
            for c, e in zip(candidates, evidence.estimates(fit, candidates, part)):
                if len(c.columns) == 1:
                    j = next(iter(c.columns))
                    division_gains[j].append(e.gain / c.width)
                table.setdefault(key_of(c), []).append((e.values, np.diag(e.covariance)))
        over = np.maximum(over, np.array([np.mean(g) if g else 1.0 for g in division_gains]))
    scatter = {}
    of_key = {key_of(c): c for c in candidates}
    for key, entries in table.items():
        c = of_key[key]
        phi = float(np.mean([over[j] for j in c.columns]))
        values = np.array([v for v, _ in entries])
        variance = np.array([s for _, s in entries])
        weight = 1.0 / (variance + 1e-300)
        excess = (weight * (values ** 2 - phi * variance)).sum(axis=0) / weight.sum(axis=0)
        scatter[key] = np.sqrt(np.maximum(excess, 0.0))
    return scatter, over, count
