# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Knowledge of a robot from its references: the prior of every comparison.

It holds the angles, speeds and loads that the references visited, since a shape is certain only
there, and in how few segments the energy of their remainder comes.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.candidates import Candidate, free_functions, library
from gearbox_monitor.diagnosis.robot.likelihood import Prior, RobotFit, RobotLikelihood
from gearbox_monitor.diagnosis.robot.motion import COVERED
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog
from gearbox_monitor.diagnosis.robot.rows import (
    dictionary, nuisance_of, NuisanceColumn, RobotModel, Rows, rows_of, shape_of)
from gearbox_monitor.diagnosis.settings import CONTEST, SETTINGS
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_RIPPLE
from gearbox_monitor.plant.effects.controller import SERVO_LIMIT
from gearbox_monitor.plant.effects.effect import JointMotion
from gearbox_monitor.plant.effects.motor_side import COGGING

VARIABLES = ('angle', 'speed', 'load')
# Of half the range of a slide (a hinge: by the turn); of the largest; of the deviation.
SPACING = {'angle': 0.3, 'speed': 0.3, 'load': 0.5}
# m, rad/s and N m: of a joint that stands, noise is no range.
LEAST_SPACING = {'angle': 0.01, 'speed': 0.02, 'load': 1e-6}
TURN = 21         # knots of a turn: the torque of a hinge is the same in every turn
SECONDS = 0.5     # spent at a knot from which it is visited
LEAST_LOAD = 0.2  # of the effort's deviation: a load that is less matters to no friction
UNSURE = 0.3      # of the taught torque: what it may be elsewhere
EVERY = 0.05      # s between the states that are kept, unless they are more than MOST
MOST = 2000


@dataclass(frozen=True)
class Visits:
    """Seconds spent at the knots k spacing of one variable, {k: s}."""

    spacing: float
    seconds: Mapping[int, float]


@dataclass(frozen=True, eq=False)
class States:
    """
    Angles and speeds of all joints at once, as references had them.

    points [N, K]: cosine and sine of each hinge, position of each slide, speeds, over their
    deviations [K]. apart: median distance of a point from the nearest one of another part.
    """

    points: Array
    deviations: Array
    apart: float


def _value(m: JointMotion, variable: str) -> Array:
    return {'angle': m.q, 'speed': m.v, 'load': m.load}[variable]


def _hats(x: Array, spacing: float, turns: bool) -> tuple[Integers, Integers, Array]:
    """Return the knots [N] below and above each value and the weight [N] of the one above."""
    u = x / spacing
    low = np.floor(u)
    lower, upper = low.astype(np.int64), low.astype(np.int64) + 1
    return (lower % TURN, upper % TURN, u - low) if turns else (lower, upper, u - low)


def _turns(rows: Rows, joint: int, variable: str) -> bool:
    return variable == 'angle' and not rows.robot.chain.links[joint].slides


def visits_of(recordings: Sequence[Rows], joint: int) -> dict[str, Visits]:
    """Return the Visits of a joint's variables in `recordings`."""
    out = {}
    for variable in VARIABLES:
        values = [_value(rows.joints[joint], variable) for rows in recordings]
        whole = np.concatenate(values)
        slides = recordings[0].robot.chain.links[joint].slides
        size = {'angle': 0.5 * float(np.ptp(whole)) if slides else 1.0,
                'speed': float(np.abs(whole).max()),
                'load': max(float(np.std(whole)), LEAST_LOAD * max(
                    float(np.std(rows.joints[joint].effort)) for rows in recordings))}[variable]
        turns = _turns(recordings[0], joint, variable)
        spacing = 2.0 * np.pi / TURN if turns else max(
            SPACING[variable] * size, LEAST_SPACING[variable])
        seconds: dict[int, float] = {}
        for rows, x in zip(recordings, values):
            low, high, share = _hats(x, spacing, turns)
            for k, weight in ((low, 1.0 - share), (high, share)):
                for knot in np.unique(k):
                    spent = float(weight[k == knot].sum()) * rows.motion.step
                    seconds[int(knot)] = seconds.get(int(knot), 0.0) + spent
        out[variable] = Visits(spacing, seconds)
    return out


def _features(rows: Rows) -> Array:
    """Return the points [N, K] of the States of a recording, in motion only: rests repeat."""
    slides = np.array([link.slides for link in rows.robot.chain.links])
    every = max(round(EVERY / rows.motion.step), 1)
    q, v = rows.motion.q[::every], rows.motion.v[::every]
    moving = np.abs(v).max(axis=1) > SETTINGS.slow
    keep = moving if moving.mean() > SETTINGS.moving else np.ones_like(moving)
    return np.hstack([np.where(slides, q, np.cos(q)), np.where(slides, 0.0, np.sin(q)), v])[keep]


def states_of(recordings: Sequence[Rows]) -> States:
    """Return the States of `recordings`; apart by the parts or recordings that are farther so."""
    count = len(recordings[0].joints)
    own = [_features(rows) for rows in recordings]
    x, number = np.concatenate(own), np.repeat(np.arange(len(own)), list(map(len, own)))
    parts = max(round(len(x) * EVERY / SETTINGS.part), 2)
    part = np.arange(len(x)) * parts // len(x)
    keep = np.arange(0, len(x), -(-len(x) // MOST))
    x, number, part = x[keep], number[keep], part[keep]
    angle = np.hypot(x[:, :count].std(axis=0), x[:, count:2 * count].std(axis=0))
    deviations = np.maximum(np.r_[angle, angle, x[:, 2 * count:].std(axis=0)], SETTINGS.slow)
    x = x / deviations
    # Samples of a program that repeats exactly are a quarter of a step from the nearest.
    apart = 0.25 * float(np.median(np.linalg.norm(np.diff(x, axis=0), axis=1)))
    for labels in (part, number):
        if labels[-1] > labels[0]:
            apart = max(apart, float(np.median(np.concatenate([
                scipy.spatial.cKDTree(x[labels != k]).query(x[labels == k])[0]
                for k in np.unique(labels)]))))
    return States(x, deviations, apart)


def farther(recordings: Sequence[Rows], states: States) -> float:
    """
    Return how far `recordings` are from the references' `states`, over these from themselves.

    Parts of one swing that is repeated are near each other, and say nothing of another motion.
    """
    x = np.concatenate([_features(rows) for rows in recordings]) / states.deviations
    distance = scipy.spatial.cKDTree(states.points).query(x)[0]
    return float(np.median(distance)) / max(states.apart, 1e-9)


def unvisited(rows: Rows, joint: int, variable: str, visits: Visits
              ) -> tuple[tuple[int, ...], Array, float]:
    """
    Return knots [k] where no reference was, hats [N, k] on them, their share of the motion.

    rows: of the recording. variable: of the motion of `joint` (index), which `visits` counts.
    """
    x = _value(rows.joints[joint], variable)
    low, high, share = _hats(x, visits.spacing, _turns(rows, joint, variable))
    knots, hats = [], []
    for knot in np.unique(np.concatenate([low, high])).tolist():
        if visits.seconds.get(knot, 0.0) < SECONDS:
            hat = np.where(low == knot, 1.0 - share, 0.0) + np.where(high == knot, share, 0.0)
            if hat.any():
                knots.append(knot)
                hats.append(hat)
    series = np.stack(hats, axis=1) if hats else np.zeros((len(x), 0))
    return tuple(knots), series, float(series.sum(axis=1).mean()) if hats else 0.0


def unvisited_shares(recordings: Sequence[Rows], visits: Mapping[str, Mapping[str, Visits]]
                     ) -> list[dict[str, float]]:
    """Return of each joint {variable: share of the motion of `recordings` without `visits`}."""
    return [{variable: float(np.mean([unvisited(rows, j, variable, of)[2]
                                      for rows in recordings]))
             for variable, of in visits[name].items()}
            for j, name in enumerate(recordings[0].robot.chain.joints)]


def with_unvisited(rows: Rows, visits: Mapping[str, Mapping[str, Visits]], sizes: Array) -> Rows:
    """
    Return `rows` with nuisance where no reference was, and which segments that are.

    Args:
        rows: of a recording.
        visits: {joint: {variable: Visits}} of the references.
        sizes: taught torque [J], N m.
    """
    columns, tests = list(rows.nuisance), rows.tests
    strange = np.zeros((len(tests.starts), len(sizes)))
    for j, name in enumerate(rows.robot.chain.joints):
        for variable, of in visits[name].items():
            knots, series, _ = unvisited(rows, j, variable, of)
            if knots:
                strange[:, j] = np.maximum(strange[:, j], tests.mean_in_motion(
                    series.sum(axis=1), j))
                shapes = {'': series}
                if variable != 'speed':  # whose sign is in it: its friction is a torque
                    shapes['friction '] = rows.sign[:, j, None] * series
                for kind, x in shapes.items():
                    columns += [NuisanceColumn(f'beyond {name} {kind}{variable} {knot}',
                                               {j: tested}, UNSURE * sizes[j])
                                for knot, tested in zip(knots, rows.tested(j, x).T)]
    return replace(rows, nuisance=tuple(columns), strange=strange)


LEAST = 10  # segments


def _usable(evidence: RobotLikelihood, joint: int) -> tuple[Array, Flags]:
    """Return the share [S] of segments in motion; which [S] say something of a joint's fault."""
    covered = np.concatenate([rows.tests.covered[:, joint] for rows in evidence.recordings])
    strange = np.concatenate([np.zeros(len(rows.tests.starts)) if rows.strange is None else
                              rows.strange[:, joint] for rows in evidence.recordings])
    return covered, (covered > COVERED) & (strange <= 1.0 - SETTINGS.visited)


def _usual(evidence: RobotLikelihood, weights: Array, joint: int) -> Array:
    """
    Return the energy [S] that noise leaves in each segment, over its mean.

    The part of the variance 1 / `weights` [C] of each cell of `joint` that comes from the noise of
    the positions follows the square of the inertia, which the posture changes.
    """
    a = evidence.at[joint]
    size = np.concatenate([((rows.inertia[:, joint] * rows.motion.sigma_q) ** 2).sum(axis=1)
                           for rows in evidence.recordings])
    frequency = np.concatenate([rows.tests.frequency for rows in evidence.recordings])[a.order]
    noise = (2.0 * np.pi * frequency) ** 4 * size[a.segment]
    mean = np.array([noise[cell].mean() for cell in a.cells])
    share = np.minimum(mean * weights, 1.0)
    usual = a.spread(1.0 - share) + a.spread(share / np.maximum(mean, 1e-300)) * noise
    return np.bincount(a.segment, usual, evidence.segments) / np.maximum(
        np.bincount(a.segment, minlength=evidence.segments), 1)


def burstiness(evidence: RobotLikelihood,
               fit: RobotFit) -> tuple[Array, list[list[tuple[str, float, float]]]]:
    """
    Return how bursty the residual of `fit` is on the recordings of `evidence`.

    Returns:
        Whitened energy of the worst tenth of the segments over the median one, per joint [J]: that
        of noise is near 2; and the (recording, begin, end) of these segments, s.
    """
    out = np.zeros(evidence.joints)
    times: list[list[tuple[str, float, float]]] = []
    seconds = 2.0 * SETTINGS.hop
    where = [(rows.name, float(t), float(t) + seconds) for rows in evidence.recordings
             for t in rows.motion.t[rows.tests.starts]]
    for j, a in enumerate(evidence.at):
        energy = np.bincount(
            a.segment, a.spread(fit.weights[j]) * fit.residual[j] ** 2, evidence.segments
            ) / _usual(evidence, fit.weights[j], j)
        covered, usable = _usable(evidence, j)
        use = np.flatnonzero(usable)
        times.append([])
        if len(use) >= LEAST:
            ranked = use[np.argsort(energy[use] / covered[use])]
            top = ranked[-max(1, len(ranked) // 10):]
            e = energy / np.maximum(covered, 1e-9)
            out[j] = e[top].mean() / np.median(e[use])
            times[j] = [where[s] for s in sorted(top)]
    return out, times


def energy_over(evidence: RobotLikelihood, fit: RobotFit, variance: Array) -> Array:
    """
    Return the energy [J] that `fit` leaves, over that of a `variance` [J, bands]; 0 without rows.

    Where references state the level of the noise, even what follows no variable stands out.
    """
    out = np.zeros(evidence.joints)
    for j, a in enumerate(evidence.at):
        covered, usable = _usable(evidence, j)
        usual = a.spread(variance[j][a.band])
        use = usable[a.segment] & (usual > 0.0)
        if use.any():
            out[j] = (fit.residual[j][use] ** 2 / usual[use]).sum() / covered[a.segment][use].sum()
    return out


def worst_segments(evidence: RobotLikelihood, fit: RobotFit) -> Array:
    """Return the rms [J], N m, that `fit` leaves in the worst tenth of segments of `evidence`."""
    out = np.zeros(evidence.joints)
    hops = np.concatenate([np.full(len(rows.tests.starts), rows.tests.value.shape[0] / 2.0)
                           for rows in evidence.recordings])
    for j, a in enumerate(evidence.at):
        energy = np.bincount(a.segment, fit.residual[j] ** 2, evidence.segments) / hops
        covered, use = _usable(evidence, j)
        if use.any():
            e = np.sort(energy[use] / covered[use])
            out[j] = np.sqrt(e[-max(1, len(e) // 10):].mean())
    return out


VERSION = 9
MOST_PARTS = 12
CALMED = 0.9  # the shapes have made parts alike where their over-dispersion falls to this
MOST_PASSES = 4


@dataclass(frozen=True, eq=False)
class ServoKnowledge:
    """What references with setpoints and torques teach of servos: prior, over-dispersion [J]."""

    prior: Prior
    dispersion: Array


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
    unjudged: joints of whose effort the references leave more than half unexplained. servos: that
    made the torques, None where setpoints are not recorded, too.
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
    unjudged: tuple[str, ...] = ()
    model: str = ''
    servos: ServoKnowledge | None = None
    version: int = VERSION

    @property
    def short(self) -> bool:
        """Whether there is one short reference, which does not show how days differ."""
        return len(self.references) == 1 and self.seconds < SETTINGS.short

    @property
    def mean(self) -> dict[str, float]:
        """{label: coefficient} that was taught."""
        return dict(zip(self.prior.labels, self.prior.mean.tolist()))


def key_of(candidate: Candidate) -> str:
    """Return what names effect, place and width of `candidate` in a Knowledge."""
    return '|'.join((*candidate.name, str(candidate.width)))


def learn(robot: RobotModel, logs: Sequence[RobotLog], model: str = '',
          progress: Callable[[int, int], object] = lambda done, of: None) -> Knowledge:
    """
    Return the Knowledge that `logs` of a healthy robot teach.

    Args:
        robot: its model; `learnt` must be set.
        logs: references.
        model: hash of the model's file.
        progress: called with (steps done, steps in sum).
    """
    shapes = _shapes(robot, logs, progress)
    recordings = _references(robot, logs, shapes)
    noisy = _noisy(recordings)
    for _ in range(2):     # the second time with the torque that the first one taught
        mean = _taught(recordings, noisy)
        del recordings     # as in _noisy
        recordings = _references(robot, logs, shapes, mean)
    evidence = RobotLikelihood(recordings, variance=noisy)
    fit = evidence.fit()
    effects = {*EFFECTS, *(e.id for e in ROBOT_EFFECTS)} - {
        SATURATION.id, SERVO_LIMIT.id, COGGING.id, TORQUE_RIPPLE.id}
    candidates = library(recordings, tuple(effects)) + free_functions(recordings)
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
        states_of(recordings), unexplained(evidence, fit), model)


def _references(robot: RobotModel, logs: Sequence[RobotLog],
                shapes: Sequence[tuple[int, str]] = (), mean: Mapping[str, float] | None = None
                ) -> list[Rows]:
    """Return the Rows of references: what a robot holds in the first one is no load."""
    return [rows_of(log, replace(robot, carries=robot.carries if k else ()), shapes, mean)
            for k, log in enumerate(logs)]


def _taught(recordings: Sequence[Rows], variance: Array) -> dict[str, float]:
    """Return {label: coefficient} that references teach, with the `variance` of _noisy."""
    evidence = RobotLikelihood(recordings, variance=variance)
    prior = evidence.posterior(evidence.fit())
    return dict(zip(prior.labels, prior.mean.tolist()))


def unexplained(evidence: RobotLikelihood, fit: RobotFit) -> tuple[str, ...]:
    """Return the joints of whose effort a `fit` leaves more than half unexplained."""
    out = []
    for j, name in enumerate(evidence.recordings[0].robot.chain.joints):
        effort = np.concatenate([rows.target[j] + rows.model[j] for rows in evidence.recordings])
        whole = float(np.sum(effort[evidence.at[j].order] ** 2))
        if float(np.sum(fit.residual[j] ** 2)) > SETTINGS.unexplained ** 2 * whole > 0.0:
            out.append(name)
    return tuple(out)


def _noisy(recordings: Sequence[Rows]) -> Array:
    """
    Return a variance [J, bands] that is infinite where the model is worse than none, else 0.

    The acceleration that positions tell is noise from some frequency on, where a fit draws masses
    to 0: from the highest band down, those in which it leaves more than the effort are out. Where
    that is all of them, something else is wrong.
    """
    noisy = np.zeros((len(recordings[0].joints), len(SETTINGS.bands) - 1))
    open_joints = set(range(len(noisy)))
    while open_joints:
        evidence = RobotLikelihood(recordings, variance=noisy)
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
        del evidence, fit, a    # before the next: two would be the peak of the memory
    return noisy


def _variance(evidence: RobotLikelihood, fit: RobotFit) -> Array:
    """Return the variance [J, bands] of what a fit leaves, 0 where there are no rows."""
    out = np.zeros((evidence.joints, len(SETTINGS.bands) - 1))
    for j, a in enumerate(evidence.at):
        total, rows = (np.bincount(a.band, x, out.shape[1])
                       for x in (a.count / fit.weights[j], a.count))
        out[j] = np.where(rows > 0.0, total / np.maximum(rows, 1e-9), 0.0)
    return out


def _shapes(robot: RobotModel, logs: Sequence[RobotLog],
            progress: Callable[[int, int], object]) -> list[tuple[int, str]]:
    """
    Return the shapes that references need: one more per joint and round while it pays.

    It pays if it gains more than the over-dispersion of the joint: where parts of the references
    differ, what one of them needs is no property of the joint.
    """
    shapes: list[tuple[int, str]] = []
    recordings = _references(robot, logs)
    joints, names = range(len(robot.chain.links)), list(dictionary())
    offers: list[list[Candidate]] = []
    for j in joints:
        offers.append([])
        for name in names:
            parts = [rows.tested(j, shape_of(name)(rows.joints[j])) for rows in recordings]
            offers[j].append(Candidate(name, {j: np.concatenate(parts)}))
    free = free_functions(recordings)
    evidence = RobotLikelihood(recordings)
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
                if worth[i] > CONTEST.margin:
                    shapes.append((j, remaining[i].effect))
                else:
                    open_joints.discard(j)
            if len(shapes) > count:
                recordings = [replace(rows, nuisance=tuple(nuisance_of(rows, shapes)))
                              for rows in recordings]
                del evidence, fit   # as in _noisy
                evidence = RobotLikelihood(recordings)
                fit = evidence.fit()
        before_pass, dispersion = dispersion, scattered(evidence, fit, free)[1]
        open_joints = set(np.flatnonzero(dispersion < CALMED * before_pass).tolist())
        if not open_joints or done >= SETTINGS.rounds:
            break
    return shapes


def another_day(evidence: RobotLikelihood, fit: RobotFit, dispersion: Array) -> Prior:
    """
    Return the prior of another day.

    Dry friction of a joint scales as a whole, and so does viscous (temperature), a little of both
    column by column; the lag of a recording is its own.
    """
    prior = evidence.posterior(fit, dispersion)
    columns = evidence.nuisance.values()
    covariance = prior.covariance + another_day_of([c.group for c in columns], prior.mean)
    keep = np.array([not column.own for column in columns])
    return Prior(tuple(label for label, k in zip(prior.labels, keep) if k), prior.mean[keep],
                 covariance[np.ix_(keep, keep)])


def another_day_of(groups: Sequence[tuple[int, str] | None], mean: Array) -> Array:
    """Return the covariance [K, K] by which friction of `groups` [K] with a `mean` [K] drifts."""
    covariance = np.zeros((len(mean), len(mean)))
    for group in {g for g in groups if g is not None}:
        whole = np.where([g == group for g in groups], mean, 0.0)
        covariance += SETTINGS.drift ** 2 * np.outer(whole, whole)
    own = np.array([g is not None for g in groups])
    return covariance + np.diag(np.where(own, SETTINGS.drift_own * mean, 0.0) ** 2)


@dataclass(frozen=True)
class FrictionDrift:
    """
    Friction of a joint beyond what days differ by: `change`, relative to the references.

    deviation: of the recordings; usual: deviation that references and days allow.
    """

    joint: str
    change: float
    deviation: float
    usual: float


def friction_drifts(evidence: RobotLikelihood, fit: RobotFit, prior: Prior, dispersion: Array
                    ) -> tuple[FrictionDrift, ...]:
    """
    Return the friction by which recordings leave the prior of another day, largest first.

    The change is the projection of the fitted friction torque on the taught one, dry and viscous
    as one: a motion may hardly tell them apart.

    Args:
        evidence: of the recordings.
        fit: of them.
        prior: that the references taught.
        dispersion: [J], by which the information of each joint is divided.
    """
    fit = evidence.fit(fit.chosen, fit.dispersed(dispersion), 1)
    after, taught = evidence.posterior(fit), {label: i for i, label in enumerate(prior.labels)}
    drifts = []
    for j, name in enumerate(evidence.recordings[0].robot.chain.joints):
        own = np.array([i for i, (label, column) in enumerate(evidence.nuisance.items())
                        if column.group is not None and column.group[0] == j and label in taught])
        rows = evidence.at[j]
        columns = rows.z[:, np.searchsorted(rows.index, own)] / evidence.deviation[own]
        theirs = [taught[evidence.labels[i]] for i in own]
        torque = columns @ prior.mean[theirs]
        weighted = rows.spread(fit.weights[j]) * torque
        along = columns.T @ weighted / max(float(weighted @ torque), 1e-30)
        change = float(along @ (after.mean[own] - prior.mean[theirs]))
        usual, deviation = (float(np.sqrt(along @ x @ along)) for x in (
            prior.covariance[np.ix_(theirs, theirs)], after.covariance[np.ix_(own, own)]))
        if abs(change) > SETTINGS.drifted * np.hypot(usual, deviation):
            drifts.append(FrictionDrift(name, change, deviation, usual))
    return tuple(sorted(drifts, key=lambda d: -abs(d.change) / d.usual))


def partitions(evidence: RobotLikelihood) -> list[list[Array]]:
    """
    Return divisions of references into parts [S]: by time, recording, speed and posture.

    Equal repeats of a motion do not differ over time; another motion, where the robot stands and
    how fast it moves show a wrong model even then.
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
    out = [_parts(np.array(by_time)), _parts(np.array(number))]
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


def scattered(evidence: RobotLikelihood, fit: RobotFit, candidates: Sequence[Candidate]
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
