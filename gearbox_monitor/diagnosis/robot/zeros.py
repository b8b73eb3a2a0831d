# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Zeros of a robot's encoders against its description: named, in doubt, or not shown by a log.

The evidence is the weight and inertia that the description states, within its tolerances. A zero
that is off competes with every effect. It is named if it explains more than each of them; where an
effect explains as much (a tilted base and the first horizontal axis), both are possible. Joints
whose zero neither motion nor weight shows are listed.
"""
from collections.abc import Collection, Sequence
from dataclasses import replace
import math
from typing import NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.contest import leading
from gearbox_monitor.diagnosis.hypothesis import Hypothesis
from gearbox_monitor.diagnosis.robot.balance_evidence import BalanceEvidence, visible_size
from gearbox_monitor.diagnosis.robot.candidates import Candidate, library, of_robot
from gearbox_monitor.diagnosis.robot.likelihood import RobotFit, RobotLikelihood
from gearbox_monitor.diagnosis.robot.robot_effects import READ_OFF
from gearbox_monitor.diagnosis.robot.robot_log import LogSection, RobotLog, SETPOINT
from gearbox_monitor.diagnosis.robot.rows import RobotModel, rows_of
from gearbox_monitor.diagnosis.settings import CONTEST, SETTINGS
from gearbox_monitor.robot.chain import PER_LINK


class Zeros(NamedTuple):
    """
    What a log says of zeros.

    joint, zero: number of the joint whose reading is that much too large, rad; None: all pay less
    than their price. rival: effect and place that explain it as well, None without one. hidden:
    numbers of joints in which a zero off by SETTINGS.zero_shown might hide.
    """

    joint: int | None
    zero: float
    rival: tuple[str, str] | None
    hidden: tuple[int, ...]


def zeros_in(log: RobotLog, robot: RobotModel, settled: Collection[int] = ()) -> Zeros:
    """
    Return what a log says of the zeros of its joints.

    Args:
        log: of the robot.
        robot: its model, with the tolerances of its description.
        settled: numbers of joints whose zero is known.
    """
    names = robot.chain.joints
    joints = [j for j, link in enumerate(robot.chain.links)
              if j not in settled and not link.slides]
    unknown = Zeros(None, 0.0, None, tuple(joints))
    if log.kind == SETPOINT or not joints:   # with which zero a servo computes weight is unknown
        return unknown
    rows = rows_of(excerpt(log), robot)
    evidence, laws = RobotLikelihood([rows]), library([rows])
    own = [c for c in of_robot(READ_OFF, [rows]) if names.index(c.place) in joints
           and any(np.abs(x).max() > SETTINGS.least_slope for x in c.columns.values())]
    balance, blank = BalanceEvidence.of(evidence, laws), evidence.fit()

    def raced(field: Sequence[Candidate]) -> list[Hypothesis]:
        """Return each of the leading candidates of a `field`, the best first."""
        none = balance.none()
        return sorted(balance.grown(none, leading(
            balance.estimates_of(none, field), SETTINGS.zero_rivals, False)),
            key=lambda h: -h.fit.likeness)
    best = next((h for h in raced(own) if h.fit.worth[0] > CONTEST.margin), None)
    zero = best.fit.fit if best else blank
    bodies = [i for i, label in enumerate(evidence.labels) if label in {
        f'{link.name} {p}' for link in robot.chain.links for p in range(PER_LINK)}]

    def another(fit: RobotFit) -> bool:
        """Return whether in a `fit` the description is that of another robot, or lacks a load."""
        return bool(np.abs(fit.nuisance[bodies]).max(initial=0.0) > SETTINGS.certain)
    others, beside = list[Hypothesis](), list[RobotFit]()
    if best or another(blank):
        others = raced([c for c in laws if c.effect != READ_OFF.id])
        beside = [evidence.fit((*h.fit.fit.chosen, *zero.chosen), h.fit.fit, 4) for h in others]
    # What explains the log best tells whether the description is that of this robot.
    if another(min([(zero.deviance, zero), *(
            (both.deviance + balance.price(h), both) for h, both in zip(others, beside))],
            key=lambda explained: explained[0])[1]):
        return unknown
    seen = {c.place: visible_size(balance, c, e.covariance, balance.loads(blank)) or math.inf
            for c, e in zip(own, evidence.estimates(blank, own))}
    hidden = tuple(j for j in joints if seen.get(names[j], math.inf) > SETTINGS.zero_shown)
    if best is None:
        return Zeros(None, 0.0, None, hidden)
    price = balance.price(best) + CONTEST.margin
    rival = min((h for h, both in zip(others, beside) if h.deviance - both.deviance < price),
                key=lambda h: h.deviance, default=None)
    return Zeros(names.index(best.members[0].place), float(zero.values[0]),
                 (rival.members[0].effect, rival.members[0].place) if rival else None, hidden)


def excerpt(log: RobotLog) -> RobotLog:
    """Return a log of a few short pieces at most, spread over all of it."""
    size = max(round(SETTINGS.part * log.rate), 4)
    pieces = [LogSection(s.t[a:a + size], s.position[a:a + size], s.input[a:a + size])
              for s in log.sections for a in range(0, len(s.t), size)]
    pieces = [p for p in pieces if p.t[-1] - p.t[0] >= 0.3 * SETTINGS.part]
    if len(pieces) <= SETTINGS.pieces:
        return log
    at = np.linspace(0, len(pieces) - 1, SETTINGS.pieces).astype(int)
    return replace(log, sections=tuple(pieces[i] for i in at))
