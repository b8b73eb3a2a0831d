# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The servos of a robot whose log has setpoints, and the torques that they made of them.

The torques say all of the mechanics, whatever made them. What the servos of the file make of the
setpoints is compared with the torques themselves: the balance of a log of setpoints, in which the
recorded torque takes the place of the model, and only effects of the controller compete.
"""
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gearbox_monitor.diagnosis.robot.candidates import Candidate, library
from gearbox_monitor.diagnosis.robot.contest import smallest_visible
from gearbox_monitor.diagnosis.robot.evidence import RobotEvidence
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog, SETPOINT
from gearbox_monitor.diagnosis.robot.rows import HELD, nuisance_of, RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.diagnosis.robot.verdict import (
    contested, findings_of, ranked, RobotSearch, RobotVerdict)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.balance_column import SETPOINT as OF_SETPOINT
from gearbox_monitor.plant.effects.controller import SETPOINT_DELAY
from gearbox_monitor.presentation import said

CONTROLLER = [e.id for e in EFFECTS.values() if e.column is not None
              and e.column.needs == OF_SETPOINT]


def with_servos(verdict: RobotVerdict, robot: RobotModel, logs: Sequence[RobotLog]
                ) -> RobotVerdict:
    """
    Return a verdict on torques with findings on the servos that made them of setpoints.

    Args:
        verdict: on the logs.
        robot: its model, with the servos of the file.
        logs: recordings; without setpoints in each of them the verdict stays as it is.
    """
    of_servos = [log.of_servos for log in logs]
    if logs[0].kind == SETPOINT or robot.kp is None or None in of_servos:
        return verdict
    # A tolerance of gains is wide where a load looks like a gain. Beside a torque none does.
    robot = replace(robot, gain_tolerance=min(robot.gain_tolerance, SETTINGS.tolerance))
    recordings = [_rows(rows_of(log, robot), torques.motion.input) for log, torques in zip(
        (log for log in of_servos if log is not None), verdict.evidence.recordings)]
    laws = _laws(recordings)
    evidence = RobotEvidence(recordings)
    blank = evidence.fit()
    search = contested(evidence, blank, laws)
    other = _left(search)
    joints = robot.chain.joints
    found = [f for f in findings_of(search)
             if f.joint is None or other[joints.index(f.joint)] < MOST_LEFT]
    cautions = [said('other_servo', place=name, percent=100.0 * share)
                for name, share in zip(joints, other) if share >= MOST_LEFT]
    visible = smallest_visible(search.contest, blank, laws)
    return replace(verdict, findings=(*verdict.findings, *found),
                   visible={**verdict.visible, **visible},
                   cautions=(*verdict.cautions, *cautions),
                   servos=tuple(sorted(ranked(evidence, blank, search.fit),
                                       key=lambda gap: gap.after - gap.before)))


MOST_LEFT = 0.5  # of the torque: a servo that leaves more is not that of the file
LATE = 0.5  # period: deviation of when a setpoint acts that is held for one


def _rows(rows: Rows, torque: Array) -> Rows:
    """Return rows of setpoints whose servos have to make a `torque` [N, J]."""
    acted = np.stack([rows.tested(j, torque[:, j, None])[:, 0] for j in range(torque.shape[1])])
    joints = tuple(replace(m, model=torque[:, j]) for j, m in enumerate(rows.joints))
    out = replace(rows, target=rows.target + rows.model - acted, model=acted, joints=joints)
    late = LATE * rows.motion.step
    return replace(out, nuisance=tuple(
        replace(c, deviation=late) if c.label == f'{HELD}: lag' else c
        for c in nuisance_of(out, ()) if c.of_input or c.label.startswith('lag')))


def _laws(recordings: Sequence[Rows]) -> list[Candidate]:
    """Return effects of the controller at each joint, and a delay of all setpoints alike."""
    laws = library(recordings, CONTROLLER)
    if not recordings[0].measured:  # a commanded torque is the servo's own: nothing is behind it
        laws = [replace(c, twins=tuple(t for t in c.twins if EFFECTS[t].location == 'controller'))
                for c in laws]
    late = [c for c in laws if c.effect == SETPOINT_DELAY.id]
    return [*laws, *(replace(c, joint=None, columns={j: x for other in late for j, x
                                                     in other.columns.items()})
                     for c in late[:1] if len(late) > 1)]


def _left(search: RobotSearch) -> list[float]:
    """Return the share of the torque [J] that the servos with all findings do not make."""
    evidence = search.contest.evidence
    out = []
    for j, (a, x) in enumerate(zip(evidence.at, search.fit.residual)):
        torque = np.concatenate([rows.model[j] for rows in evidence.recordings])[a.order]
        out.append(float(np.linalg.norm(x)) / max(float(np.linalg.norm(torque)), 1e-30))
    return out
