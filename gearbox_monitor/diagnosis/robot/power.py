# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The power of a motion: the smallest size of each effect that it shows, and what to ask next.

`none` says something only where a change of plausible size would have been a finding. Where it
would not, the verdict is undecided, with the motion that would tell.
"""
from collections.abc import Mapping, Sequence
import math

import numpy as np

from gearbox_monitor.diagnosis.question import of_size, Question
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.contest import RobotContest, tempered
from gearbox_monitor.diagnosis.robot.evidence import RobotEvidence, RobotFit
from gearbox_monitor.diagnosis.robot.robot_effects import COUPLING, PAYLOAD
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects.actuator import SATURATION, TORQUE_GAIN
from gearbox_monitor.plant.effects.controller import SERVO_LIMIT
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB

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
        if size is not None:
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
    if worth[-1] < SETTINGS.margin:
        return math.inf
    size = float(sizes[np.argmax(worth >= SETTINGS.margin)])
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
