# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The verdict on a whole robot: findings of joints and links, what remains, what would show."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.contest import contest, Search
from gearbox_monitor.diagnosis.hypothesis import (
    Finding, FUNCTION, kind_of, of_rival, Question, Remainder, UNDECIDED)
from gearbox_monitor.diagnosis.robot.balance_evidence import (
    BalanceEvidence, gain_at, questions, smallest_visible, speed_of)
from gearbox_monitor.diagnosis.robot.candidates import (
    Candidate, free_functions, library, swings, visible_in)
from gearbox_monitor.diagnosis.robot.knowledge import (
    burstiness, energy_over, farther, friction_drifts, FrictionDrift, Knowledge, scattered,
    unexplained, unvisited_shares, with_unvisited, worst_segments)
from gearbox_monitor.diagnosis.robot.likelihood import RobotFit, RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import (
    BASE, BASE_TILT, JOINT_ZERO, PAYLOAD, QUADRATIC, reach_of, ROBOT_EFFECTS)
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog, SETPOINT
from gearbox_monitor.diagnosis.robot.rows import HELD, RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.settings import CONTEST, SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN, TORQUE_OFFSET
from gearbox_monitor.plant.effects.controller import SERVO_GAIN, SERVO_LIMIT
from gearbox_monitor.plant.effects.effect import COMMAND
from gearbox_monitor.plant.effects.motor_side import COULOMB_ASYMMETRY, MOTOR_COULOMB
from gearbox_monitor.presentation import Said, said

TWO_HEIGHTS = {MOTOR_COULOMB.id, TORQUE_OFFSET.id}
TOO_WIDE = 3.0     # a deviation whose torque exceeds the effort so many times: not determined
SETTING_STEP = 1e-3  # of a setting, over which the slope of its torque is taken
WIDE_PLACE = 1.0   # m: a centre of mass that is not known within this is not determined
KNOWN_MASS = 0.25  # of a link's: a load that is known so well did not change
LARGER = 1.5       # bursts of healthy references that were as large are none
LEAST_SEEN = 0.05  # of a motion: what is new all over is no evidence, but a limit has to be
BURSTS = 'bursts'  # of a remainder, in place of a variable
HELD_SHARE = 0.25   # of the period, which shifts a sampled torque by half of it
TOTALS = {'Cc_change': ('Cc', 'coulomb'), 'Cv_change': ('Cv', 'viscous'),
          'm1_change': ('m1', 'armature')}


@dataclass(frozen=True)
class JointGap:
    """Of a joint: rms of the effort less the model without and with the findings, N m or N."""

    joint: str
    before: float
    after: float
    effort: float
    evidence: float
    axis: str


@dataclass(frozen=True, eq=False)
class RobotVerdict:
    """
    A diagnosis of a robot.

    findings, remainders; ranked: gaps, the worst first; visible {effect: {place: smallest size
    that would have been seen}}; not_tried {effect: why}; cautions: what weakens the verdict;
    unvisited: whether the references lack a part of the motion. questions: what this motion would
    not have shown; not_judged: joints of whose effort references, or the fit beside a file, leave
    over half; unsure: whether what remains may be that references are too short; drifts: friction
    beyond what days differ by, of joints without a finding. fit, evidence: behind it. servos: gaps
    between the torques and those that servos make of their setpoints, where both are recorded.
    """

    findings: tuple[Finding, ...]
    remainders: tuple[Remainder, ...]
    ranked: tuple[JointGap, ...]
    visible: Mapping[str, Mapping[str, float]]
    not_tried: Mapping[str, Said]
    cautions: tuple[Said, ...]
    unvisited: bool
    questions: tuple[Question, ...]
    not_judged: tuple[str, ...]
    unsure: bool
    drifts: tuple[FrictionDrift, ...]
    fit: RobotFit
    evidence: RobotLikelihood
    servos: tuple[JointGap, ...] = ()

    @property
    def kind(self) -> str:
        """One of KINDS; UNDECIDED: nothing was found, and little would have been."""
        if not self.findings and not self.remainders and (
                self.questions or self.not_judged or self.unsure or self.drifts):
            return UNDECIDED
        return kind_of(bool(self.findings), bool(self.remainders))


def diagnose(robot: RobotModel, logs: Sequence[RobotLog], knowledge: Knowledge | None = None,
             effects: Sequence[str] | None = None) -> RobotVerdict:
    """
    Return the verdict on recordings of a robot.

    Args:
        robot: its model.
        logs: recordings to judge.
        knowledge: of references; None, the model's file with its tolerances.
        effects: ids to try, None for all.
    """
    shapes = knowledge.shapes if knowledge else ()
    mean = knowledge.mean if knowledge else None
    recordings, away = [rows_of(log, robot, shapes, mean) for log in logs], 1.0
    if knowledge is None:
        evidence = RobotLikelihood(recordings)
    else:
        away = farther(recordings, knowledge.states) / SETTINGS.farther
        recordings = [with_unvisited(rows, knowledge.visits, knowledge.sizes)
                      for rows in recordings]
        # The squared error of what was taught grows with the distance, like a random walk's.
        evidence = RobotLikelihood(recordings, knowledge.prior,
                                 knowledge.variance * max(away, 1.0))
    unjudged = set(knowledge.unjudged) if knowledge else set()
    laws, free = ([c for c in field if c.joint not in unjudged] for field in (
        library(recordings, effects), free_functions(recordings) + swings(recordings)))
    shares = unvisited_shares(recordings, knowledge.visits) if knowledge else []
    search = judged(BalanceEvidence.of(evidence, laws, free, knowledge), knowledge, shares,
                    max(away, 1.0))
    blank, fit = search.evidence.blank, search.best.fit.fit
    remainders = [r for r in _remainders(search, knowledge, max(away, 1.0))
                  if r.joint not in unjudged]
    short = knowledge is not None and knowledge.short
    # What a short reference does not know of another day is no difference yet, nor is a function
    # of a motion that no reference knows.
    known = tuple(r for r in remainders if (not short or r.over is not None)
                  and (away <= 1.0 or r.over in (None, BURSTS)))
    cautions = _cautions(knowledge.joints, shares, away) if knowledge else ()
    visible = smallest_visible(search.evidence, search.best)
    drifts = friction_drifts(evidence, fit, knowledge.prior, search.evidence.dispersion) if (
        knowledge) else ()
    found, rivals = {c.joint for c in fit.chosen} | unjudged, rivals_in(search)
    if knowledge is None:
        share = np.max([rows.tests.share for rows in recordings], axis=0)
        unjudged = {name for name in unexplained(evidence, fit) if share[
            robot.chain.joints.index(name)] > SETTINGS.moving} - {r.joint for r in remainders}
    alone = _laws_alone(search)
    of_laws = [of for of, m in zip(rivals, search.best.members) if m in alone.best.members]
    gaps = ranked(evidence, blank, alone.best.fit.fit)
    if alone is not search:  # the function and friction may cancel each other in part
        left: dict[str | None, float] = {gap.joint: gap.after for gap in gaps}
        known = tuple(replace(r, size=min(r.size or 0.0, left[r.joint]))
                      if r.joint in left else r for r in known)
    return RobotVerdict(
        findings_of(alone, of_laws), known, gaps, visible,
        _not_tried(recordings[0], laws),
        (*cautions, *_of_reference(knowledge), *_of_gains(evidence, fit),
         *held_setpoints(evidence, fit)), bool(cautions),
        (*_rival_questions(search, rivals),
         *(() if effects else questions(search.evidence, visible))),
        tuple(sorted(unjudged)),
        len(known) < len(remainders), tuple(d for d in drifts if d.joint not in found), fit,
        evidence)


BalanceSearch = Search[BalanceEvidence]
Rivals = Sequence[Mapping[str, float]]  # {effect, with its place: lag} of each member


def _laws_alone(search: BalanceSearch) -> BalanceSearch:
    """
    Return a search without its function, if the file states no friction of the joint of that.

    The function and the friction explain the same torque in part. The values of the friction that
    go into the file are those of a fit of the laws alone.
    """
    function, members = search.best.function, search.best.members
    if function is None or not any(
            m in search.evidence.unstated and m.place == function.place for m in members):
        return search
    return replace(search, best=search.evidence.without(search.best, members.index(function)))


def judged(evidence: BalanceEvidence, knowledge: Knowledge | None = None,
           shares: Sequence[Mapping[str, float]] = (), away: float = 1.0) -> BalanceSearch:
    """
    Return the contest with the scales that the references and the recordings themselves show.

    With references only where they were, a difference from them is evidence; and what parts of
    the recordings differ by beside all findings shows that the model is not true there: it is
    over-dispersion as well. Where more is left than healthy parts may differ by, that they differ
    is no reason against a law: the likeliest laws that leave no more are taken.

    Args:
        evidence: of the recordings.
        knowledge: of references.
        shares: of each joint's motion, where no reference was.
        away: distance of the motion from the references over theirs from each other, 1 or more.
    """
    visible = np.array([max(1.0 - max(of.values()), LEAST_SEEN) for of in shares] or [1.0])
    evidence = replace(evidence, dispersion=evidence.dispersion / visible)
    if knowledge is not None and knowledge.short:
        evidence = replace(evidence, extra=CONTEST.margin, day=SETTINGS.day)
    search = contest(evidence)
    # Without references, a function without a law may be the difference between the parts.
    if search.best.members and (knowledge is not None or search.best.function is None):
        # One function at many settings would count as often.
        of_joints = [c for c in (*evidence.laws, *evidence.functions) if len(c.columns) == 1
                     and not (c.free and c.searched)]
        fit = search.best.fit.fit
        own = scattered(evidence.likelihood, fit, of_joints)[1] / visible
        if any(own[j] > evidence.dispersion[j] for c in fit.chosen for j in c.columns):
            search = contest(replace(evidence, dispersion=np.maximum(own, evidence.dispersion)))
    if knowledge is None or np.all(_excess(search, knowledge, away) <= 1.0):
        return search
    most = (knowledge.variance.T * knowledge.dispersion * SETTINGS.excess * away).T
    likelihood = RobotLikelihood(evidence.likelihood.recordings, knowledge.prior, most)
    certain = contest(replace(evidence, likelihood=likelihood, blank=likelihood.fit(),
                              dispersion=np.ones(likelihood.joints)))
    return search if certain.best.function or np.any(
        _excess(certain, knowledge, away) > 1.0) else certain


def _excess(search: BalanceSearch, knowledge: Knowledge, away: float) -> Array:
    """Return the energy [J] that a search leaves, over the most by which healthy parts differ."""
    return energy_over(search.evidence.likelihood, search.best.fit.fit, knowledge.variance) / (
        knowledge.dispersion * SETTINGS.excess * away)


def examined(robot: RobotModel, logs: Sequence[RobotLog], knowledge: Knowledge
             ) -> tuple[Finding, ...]:
    """
    Return what references differ by from the file itself: mounting, zeros, scales, a load.

    Args:
        robot: its model; friction is that of the references.
        logs: the references.
        knowledge: what they taught.
    """
    if knowledge.kind == SETPOINT:
        return ()
    stated = replace(robot, tolerance=np.full(len(robot.tolerance), SETTINGS.tolerance_examined))
    recordings = [rows_of(log, stated, knowledge.shapes) for log in logs]
    evidence = RobotLikelihood(recordings, variance=np.where(
        np.isinf(knowledge.variance), np.inf, 0.0))
    tips = {robot.chain.links[k].name for k in robot.chain.tips}
    laws = [c for c in library(recordings, [
        BASE_TILT.id, JOINT_ZERO.id, TORQUE_GAIN.id, PAYLOAD.id]) if not c.link or c.link in tips]
    search = contest(replace(BalanceEvidence.of(evidence, laws), dispersion=knowledge.dispersion))
    return findings_of(search, rivals_in(search))


def _rival_questions(search: BalanceSearch, rivals_of: Rivals) -> tuple[Question, ...]:
    """Return which of two effects the recordings leave open, one for each finding."""
    evidence, out = search.evidence.likelihood, []
    chain = evidence.recordings[0].robot.chain
    for c, of in zip(search.best.fit.fit.chosen, rivals_of):
        rivals = {name: lag for name, lag in of.items() if not name.startswith('arm_')}
        if rivals and not c.free:
            j = max(c.columns)  # the outermost joint that shows it
            rival, lag = next(iter(rivals.items()))
            out.append(of_rival((c.effect, c.place, chain.joints[j]), speed_of(evidence, j),
                                rival, lag))
    return tuple(out)


def _shares(evidence: RobotLikelihood, fit: RobotFit) -> list[float]:
    """
    Return the share of the squared misfit that each candidate of a fit explains, 0 to 1.

    What comes back without its torque, of what comes back without that of all candidates.
    """
    def returns(numbers: Iterable[int]) -> float:
        out = 0.0
        for j, (a, w, residual) in enumerate(zip(evidence.at, fit.weights, fit.residual)):
            torque = np.zeros_like(residual)
            for i in numbers:
                if j in fit.chosen[i].columns:
                    torque += fit.torque(i)[j][a.order]
            out += float(a.spread(w) @ (2.0 * residual * torque + torque ** 2))
        return out
    whole = max(returns(range(len(fit.chosen))), 1e-9)
    return [min(max(returns([i]) / whole, 0.0), 1.0) for i in range(len(fit.chosen))]


def rivals_in(search: BalanceSearch) -> Rivals:
    """Return the rivals of each member of the best hypothesis: what explains as much."""
    return [{} if m.kind == FUNCTION or m in search.evidence.unstated else search.evidence.rivals(
        search.best, i) for i, m in enumerate(search.best.members)]


def findings_of(search: BalanceSearch, rivals: Rivals) -> tuple[Finding, ...]:
    """Return the laws that a search has taken as findings, worthiest first, with their rivals."""
    fit, evidence = search.best.fit.fit, search.evidence.likelihood
    spreads, loads = _spreads(evidence, fit), search.evidence.loads(fit)
    out = []
    for i, (c, worth, share) in enumerate(zip(
            fit.chosen, search.best.fit.worth, _shares(evidence, fit))):
        if c.free or c.values is None:
            continue
        b = fit.values[fit.of(i)]
        spread = spreads[i] * max(search.evidence.over_dispersion(c, fit), 1.0)
        spread[:len(b), :len(b)] += search.evidence.of_days(c, loads)
        if c.link is not None:
            # Joints read a load in scales of their own.
            moved = evidence.recordings[0].robot.torque_tolerance * evidence.by_scales(fit, i)
            spread[:len(b), :len(b)] += moved.T @ moved
        determined = _determined(evidence, c, spread)
        if c.searched:
            b = np.append(b, c.setting)
        if c.effect == SERVO_LIMIT.id:
            # A limit is a torque, in the scale of the model's gain.
            by = np.append(1.0, fit.gain[list(c.columns)])
            b, spread = b / by, spread / np.outer(by, by)
        if c.effect == SERVO_GAIN.id:
            # A factor is of the file's gain, or of the one that references taught.
            k = evidence.labels.index(f'kp {c.joint}')
            by = 1.0 + evidence.mean[k] * evidence.deviation[k]
            b, spread = b / by, spread / by ** 2
        values = _values(c, b)
        deviations = _deviations(c, b, spread, determined)
        values, deviations = _with_totals(evidence, fit, c, values, deviations)
        if c.effect == PAYLOAD.id:
            values, deviations = _with_moment(evidence, c, (b, spread), values, deviations)
        out.append(Finding(
            c.effect, _location(c), values, deviations, round(worth, 3),
            share, channel=c.over or None, joint=c.joint,
            link=c.link if c.link else (BASE if c.joint is None else None),
            confusable=tuple(rivals[i])))
    return _joined(out)


def _spreads(evidence: RobotLikelihood, fit: RobotFit) -> list[Array]:
    """
    Return the covariance of the coefficients of each candidate, a searched setting behind them.

    The setting is one more coefficient of the model that is linear about it.
    """
    slopes: list[Candidate] = []
    places: dict[int, int] = {}
    for i, c in enumerate(fit.chosen):
        if c.searched and not c.free:
            places[i] = len(fit.values) + len(slopes)
            slopes.append(_slope(c, fit.values[fit.of(i)]))
    whole = evidence.fit((*fit.chosen, *slopes), fit, 2) if slopes else fit
    covariance = evidence.sandwich(whole)
    own = [np.r_[fit.of(i), [places[i]] if i in places else []].astype(int)
           for i in range(len(fit.chosen))]
    return [covariance[np.ix_(k, k)] for k in own]


def _slope(c: Candidate, b: Array) -> Candidate:
    """Return the slope of the torque of `c` with the coefficients `b` over its setting."""
    assert c.at_setting is not None
    step = SETTING_STEP * (c.span or abs(c.setting))
    lower, upper = c.at_setting(c.setting - step), c.at_setting(c.setting + step)
    return Candidate('slope', {j: (upper.columns[j] - x) @ b[:, None] / (2.0 * step)
                               for j, x in lower.columns.items()}, of_input=c.of_input)


def _values(c: Candidate, b: Array) -> dict[str, float]:
    """Return the values of coefficients `b` of `c`, behind which a searched setting stands."""
    if c.searched:
        assert c.at_setting is not None
        c, b = c.at_setting(float(b[-1])), b[:-1]
    assert c.values is not None
    return dict(c.values(b))


def _determined(evidence: RobotLikelihood, c: Candidate, covariance: Array) -> bool:
    """Return whether the motion excites a candidate's first coefficient."""
    torque, column = 0.0, 0.0
    for j, x in c.columns.items():
        torque += float(np.sum(evidence.at[j].y ** 2))
        torque += sum(float(np.sum(rows.model[j] ** 2)) for rows in evidence.recordings)
        column += float(np.sum(x[:, 0] ** 2))
    return covariance[0, 0] * column < TOO_WIDE ** 2 * torque


def _deviations(c: Candidate, b: Array, covariance: Array, determined: bool
                ) -> dict[str, float | None]:
    """Return the deviation of each value, by the derivatives of values(b)."""
    base = _values(c, b)
    step = 1e-4 * np.maximum(np.abs(b), np.sqrt(np.diag(covariance))) + 1e-12
    slopes: dict[str, Array] = {name: np.zeros(len(b)) for name in base}
    for i in range(len(b)):
        moved = b.copy()
        moved[i] += step[i]
        for name, value in _values(c, moved).items():
            slopes[name][i] = (value - base[name]) / step[i]
    out: dict[str, float | None] = {}
    for name, slope in slopes.items():
        deviation = math.sqrt(max(float(slope @ covariance @ slope), 0.0))
        place = name in ('cx', 'cy', 'cz') and deviation > WIDE_PLACE
        wide = c.searched and slope[-1] != 0.0 and deviation > (c.span or c.setting)
        idle = bool(slope[:c.width][~c.acting].any())
        stated = determined and not (place or wide or idle)
        out[name] = 0.0 if not slope.any() else deviation if stated else None
    return out


def _with_totals(evidence: RobotLikelihood, fit: RobotFit, c: Candidate,
                 values: dict[str, float], deviations: dict[str, float | None]
                 ) -> tuple[dict[str, float], dict[str, float | None]]:
    """
    Return values with the whole beside a change: friction or inertia, if the file has one.

    With references, the gain of a servo beside its factor of theirs.
    """
    rows = evidence.recordings[0]
    if c.effect == SERVO_GAIN.id and rows.robot.learnt:
        whole = float(1.0 / fit.gain[rows.robot.chain.joints.index(c.joint)])
        unsure = deviations['kp_factor']
        return {**values, 'kp_of_model': whole}, {**deviations, 'kp_of_model': (
            unsure and unsure * whole / values['kp_factor'])}
    for change, (name, field) in TOTALS.items():
        if change in values and c.joint is not None and not rows.robot.learnt:
            joint = rows.joints[rows.robot.chain.joints.index(c.joint)]
            values = {name: values[change] + getattr(joint, field), **values}
            deviations = {name: deviations[change], **deviations}
    return values, deviations


def _with_moment(evidence: RobotLikelihood, c: Candidate, estimate: tuple[Array, Array],
                 values: dict[str, float], deviations: dict[str, float | None]
                 ) -> tuple[dict[str, float], dict[str, float | None]]:
    """
    Return the values of a load with its first moment, where that is all a motion says of it.

    Where mass and centre are not separable their product is, as of a centre beyond all that hangs
    there; where the mass is the same, the centre of what the link carries moved.

    Args:
        evidence: of the recordings.
        c: the load.
        estimate: its coefficients and their covariance.
        values: of the load.
        deviations: of the values.
    """
    b, spread = estimate
    unsure, size = deviations['m'], float(np.linalg.norm(b[1:4]))
    chain = evidence.recordings[0].robot.chain
    link = [link.name for link in chain.links].index(c.link or '')
    certain = unsure is not None and abs(values['m']) > 2.0 * unsure
    if certain and size < reach_of(chain, link) * abs(values['m']):
        return values, deviations
    along = b[1:4] / max(size, 1e-12)
    deviation = math.sqrt(max(float(along @ spread[1:4, 1:4] @ along), 0.0))
    if size < 2.0 * deviation:
        return values, {**deviations, 'm': None}
    mass = sum(chain.links[k].mass for k in chain.moved_by(link))
    values, deviations = {**values, 'moment': size}, {**deviations, 'm': None,
                                                      'moment': deviation}
    if not certain and unsure is not None and unsure < KNOWN_MASS * mass:
        values['moved'], deviations['moved'] = size / mass, deviation / mass
    return values, deviations


def _location(c: Candidate) -> str:
    """Return the location class of an effect."""
    if c.effect in EFFECTS:
        return EFFECTS[c.effect].location
    return 'motor_side' if c.effect == QUADRATIC.id else 'arm_side'


def _joined(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings with an offset and a Coulomb friction of one joint as one: two heights."""
    out: list[Finding] = []
    for f in findings:
        twin = next((g for g in out if g.joint == f.joint is not None
                     and {g.effect, f.effect} == TWO_HEIGHTS), None)
        if twin is None:
            out.append(f)
            continue
        coulomb, offset = (twin, f) if twin.effect == MOTOR_COULOMB.id else (f, twin)
        out[out.index(twin)] = Finding(
            MOTOR_COULOMB.id, coulomb.place,
            {**coulomb.values, 'Ca': -offset.values['u0']},
            {**coulomb.deviations, 'Ca': offset.deviations['u0']},
            (coulomb.evidence or 0.0) + (offset.evidence or 0.0),
            min((coulomb.share or 0.0) + (offset.share or 0.0), 1.0), joint=coulomb.joint,
            confusable=(COULOMB_ASYMMETRY.id, TORQUE_OFFSET.id))
    return tuple(sorted(out, key=lambda f: -(f.evidence or 0.0)))


def _remainders(search: BalanceSearch, knowledge: Knowledge | None, away: float
                ) -> tuple[Remainder, ...]:
    """
    Return what no law explains: functions, bursts, what references do not leave.

    Args:
        search: on the recordings.
        knowledge: of references, None without one.
        away: distance of the motion from the references over theirs from each other, 1 or more.
    """
    evidence, fit = search.evidence.likelihood, search.best.fit.fit
    out, chain = [], evidence.recordings[0].robot.chain
    for i, (c, worth) in enumerate(zip(fit.chosen, search.best.fit.worth)):
        if c.free and c.joint is not None:
            j = chain.joints.index(c.joint)
            x = fit.torque(i)[j]
            out.append(Remainder('motor_side' if 'friction' in c.over else 'arm_side', 'effort',
                                 rms_in_motion(evidence, j, x), c.over, c.joint,
                                 figures={'evidence': round(worth, 3)}))
    size, times = burstiness(evidence, fit)
    segments, several = worst_segments(evidence, fit), len(evidence.recordings) > 1
    for j in np.argsort(-size):
        healthy = knowledge is not None and segments[j] < LARGER * knowledge.bursts[j]
        usual = 1.0 if knowledge is None else float(knowledge.dispersion[j])
        if size[j] > SETTINGS.bursts * usual and not healthy and all(
                r.joint != chain.joints[j] for r in out):
            out.append(Remainder(
                'arm_side', 'effort', rms_in_motion(evidence, j, fit.residual[j]), BURSTS,
                chain.joints[j], tuple((begin, end) for _, begin, end in times[j]),
                tuple(name for name, *_ in times[j]) if several else (),
                {'burstiness': round(float(size[j]), 2)}))
    if knowledge is not None:
        excess = _excess(search, knowledge, away)
        out += [Remainder('arm_side', 'effort', rms_in_motion(evidence, j, fit.residual[j]), None,
                          chain.joints[j], figures={'excess': round(
                              float(excess[j]) * SETTINGS.excess * away, 2)})
                for j in np.argsort(-excess) if excess[j] > 1.0
                and all(r.joint != chain.joints[j] for r in out)]
    return tuple(out)


def rms_in_motion(evidence: RobotLikelihood, joint: int, rows: Array) -> float:
    """Return the rms over the time in motion of what has the rows [R] at `joint`."""
    samples = sum(len(r.tests.starts) * r.tests.value.shape[0] / 2.0 * r.tests.share[joint]
                  for r in evidence.recordings)
    return math.sqrt(float(np.sum(rows ** 2)) / max(samples, 1.0))


def ranked(evidence: RobotLikelihood, blank: RobotFit, fit: RobotFit) -> tuple[JointGap, ...]:
    """
    Return the gaps of the joints, those with most evidence first.

    The gap after the findings is that of the model with them alone: gains, delays and tolerances
    that were fitted beside them are in no file.
    """
    out = []
    chain = evidence.recordings[0].robot.chain
    for j, (name, link) in enumerate(zip(chain.joints, chain.links)):
        effort = np.concatenate([r.joints[j].effort for r in evidence.recordings])
        out.append(JointGap(
            name, rms_in_motion(evidence, j, evidence.at[j].y),
            rms_in_motion(evidence, j, _closed(evidence, fit, j)),
            float(np.std(effort)),
            gain_at(evidence, blank, fit, j), 'prismatic' if link.slides else 'rotary'))
    return tuple(sorted(out, key=lambda g: -g.evidence))


def _closed(evidence: RobotLikelihood, fit: RobotFit, joint: int) -> Array:
    """Return the rows [R] at `joint` less those of the findings of `fit` alone."""
    a = evidence.at[joint]
    return np.asarray(a.y - sum((fit.torque(i)[joint][a.order] for i, c in enumerate(fit.chosen)
                                 if not c.free and joint in c.columns), np.zeros_like(a.y)))


@dataclass(frozen=True, eq=False)
class EffortCurves:
    """
    The effort of a joint over t [N] s in one recording, N m or N; NaN where the joint rests.

    recorded [N]; before, after [N]: recording less model without and with the findings.
    """

    joint: str
    axis: str
    t: Array
    recorded: Array
    before: Array
    after: Array


def effort_curves(verdict: RobotVerdict, joint: str) -> EffortCurves:
    """Return the curves of a `joint` in the first recording of `verdict`."""
    evidence, recording = verdict.evidence, verdict.evidence.recordings[0]
    chain, count = recording.robot.chain, recording.tests.rows
    j = chain.joints.index(joint)
    sides = []
    for y in (evidence.at[j].y, _closed(evidence, verdict.fit, j)):
        rows = np.zeros(max(count, int(evidence.at[j].order.max(initial=-1)) + 1))
        rows[evidence.at[j].order] = y
        series = recording.tests.series(rows[:count])
        sides.append(np.where(recording.tests.mask[:, j] > 0.5, series, np.nan))
    return EffortCurves(joint, 'prismatic' if chain.links[j].slides else 'rotary',
                        np.arange(len(sides[0])) / recording.rate, recording.joints[j].effort,
                        *sides)


def _not_tried(rows: Rows, laws: Sequence[Candidate]) -> dict[str, Said]:
    """Return {effect: why it was not tried} of the library's effects."""
    tried = {c.effect for c in laws}
    out = {}
    for effect in EFFECTS.values():
        if effect.id in tried:
            continue
        if effect.column is None:
            out[effect.id] = said('no_column')
        elif effect.column.needs == COMMAND and rows.measured:
            out[effect.id] = said('torque_measured')
        elif not visible_in(effect.column, rows):
            out[effect.id] = said('needs_torque' if rows.setpoint else 'needs_setpoints')
        else:
            out[effect.id] = said('rate_or_motion', rate=rows.rate)
    out |= {e.id: said('motion_hides') for e in ROBOT_EFFECTS if e.id not in tried}
    return out


def _of_reference(knowledge: Knowledge | None) -> tuple[Said, ...]:
    """Return cautions about references: what they do not know, joints that they do not teach."""
    if knowledge is None:
        return ()
    short = [said('one_reference', seconds=knowledge.seconds, percent=100 * SETTINGS.day)]
    return (*(said('unjudged', place=name) for name in knowledge.unjudged),
            *short * knowledge.short)


def _of_gains(evidence: RobotLikelihood, fit: RobotFit) -> tuple[Said, ...]:
    """Return cautions about servos whose gain is not that of the model."""
    rows = evidence.recordings[0]
    if not rows.setpoint:
        return ()
    return tuple(said('other_gain', place=name, factor=1.0 / x)
                 for name, x in zip(rows.robot.chain.joints, fit.gain)
                 if abs(x - 1.0) > 2.0 * rows.robot.gain_tolerance)


def sampled_early(evidence: RobotLikelihood, fit: RobotFit) -> list[float]:
    """Return, of each recording, s by which its servos' torque is not that of mid-period; 0."""
    posterior, out = evidence.posterior(fit), [0.0] * len(evidence.recordings)
    for k, label in enumerate(posterior.labels):
        number = label.removeprefix(f'{HELD} of recording ')
        early, deviation = posterior.mean[k], math.sqrt(posterior.covariance[k, k])
        if number != label and abs(early) > SETTINGS.certain * deviation:
            out[int(number) - 1] = float(early)
    return out


def setpoint_lags(evidence: RobotLikelihood, fit: RobotFit) -> Array:
    """Return by how many s the setpoints [J] of the first recording are late."""
    posterior = evidence.posterior(fit)
    mean = dict(zip(posterior.labels, posterior.mean))
    return np.array([mean[f'{HELD}: lag of recording 1'] + mean[f'setpoint lag {name}']
                     for name in evidence.recordings[0].robot.chain.joints])


def held_setpoints(evidence: RobotLikelihood, fit: RobotFit) -> tuple[Said, ...]:
    """Return a caution about torques that were sampled at one end of a held setpoint."""
    return tuple(
        said('held_setpoint', log=rows.name, ms=1e3 * early,
             end='start' if early > 0.0 else 'end')
        for rows, early in zip(evidence.recordings, sampled_early(evidence, fit))
        if abs(early) > HELD_SHARE * rows.motion.step)


def _cautions(joints: Sequence[str], shares: Sequence[Mapping[str, float]], away: float
              ) -> tuple[Said, ...]:
    """Return what the references did not visit."""
    out = []
    if away > 1.0:
        out.append(said('far_away', factor=away * SETTINGS.farther))
    out += [said('not_visited', place=name, percent=100 * share, variable=variable)
            for name, of in zip(joints, shares) for variable, share in of.items()
            if share > 1.0 - SETTINGS.visited]
    return tuple(out)


def verdict_data(verdict: RobotVerdict) -> dict[str, Any]:
    """Return the verdict as plain data, for JSON."""
    return {
        'verdict': verdict.kind,
        'findings': [f.to_dict() for f in verdict.findings],
        'remainders': [r.to_dict() for r in verdict.remainders],
        'gaps': [asdict(gap) for gap in verdict.ranked],
        'servos': [asdict(gap) for gap in verdict.servos],
        'visible': {k: dict(v) for k, v in verdict.visible.items()},
        'not_tried': {name: str(why) for name, why in verdict.not_tried.items()},
        'warnings': list(map(str, verdict.cautions)), 'unvisited': verdict.unvisited,
        'questions': [asdict(q) for q in verdict.questions],
        'not_judged': list(verdict.not_judged),
        'drifts': [asdict(d) for d in verdict.drifts]}
