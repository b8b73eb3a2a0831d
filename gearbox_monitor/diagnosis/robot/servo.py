# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The servos of a robot whose log holds both their setpoints and their torques.

The torques alone show the mechanics. The torques that the servos of the file would produce from
the setpoints are compared with those recorded: the balance of a log of setpoints, in which the
recorded torque replaces the model, and only effects of the controller compete.
"""
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import Remainder
from gearbox_monitor.diagnosis.robot.balance_evidence import BalanceEvidence, smallest_visible
from gearbox_monitor.diagnosis.robot.candidates import Candidate, library
from gearbox_monitor.diagnosis.robot.knowledge import (
    another_day, Knowledge, scattered, ServoKnowledge)
from gearbox_monitor.diagnosis.robot.likelihood import RobotLikelihood
from gearbox_monitor.diagnosis.robot.motion import motion_of
from gearbox_monitor.diagnosis.robot.robot_log import RobotLog
from gearbox_monitor.diagnosis.robot.rows import HELD, nuisance_of, RobotModel, Rows, rows_of
from gearbox_monitor.diagnosis.robot.verdict import (
    BalanceSearch, findings_of, judged, ranked, rivals_in, RobotVerdict)
from gearbox_monitor.diagnosis.settings import SETTINGS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.controller import SETPOINT_DELAY
from gearbox_monitor.plant.effects.effect import SETPOINT as OF_SETPOINT

CONTROLLER = [e.id for e in EFFECTS.values() if e.column is not None
              and e.column.needs == OF_SETPOINT]


def with_servos(verdict: RobotVerdict, robot: RobotModel, logs: Sequence[RobotLog],
                effects: Sequence[str] | None = None, knowledge: Knowledge | None = None
                ) -> RobotVerdict:
    """
    Return a verdict on torques with findings on the servos that made them from setpoints.

    Args:
        verdict: on the logs.
        robot: its model, with the servos of the file.
        logs: recordings; without setpoints in each of them the verdict stays as it is.
        effects: ids to try, None for all.
        knowledge: of references that taught the servos, too; None, the servos of the file.
    """
    tried = [name for name in CONTROLLER if effects is None or name in effects]
    servos = knowledge.servos if knowledge else None
    # A tolerance of gains is wide where a load looks like a gain. Beside a torque none does.
    recordings = _servo_rows(robot, logs, min(robot.gain_tolerance, SETTINGS.tolerance))
    if not recordings or not tried or (knowledge and not servos):
        return verdict
    laws = _laws(recordings, tried)
    evidence = RobotLikelihood(recordings, servos.prior if servos else None)
    balance = BalanceEvidence.of(evidence, laws)
    search = judged(replace(balance, dispersion=servos.dispersion) if servos else balance)
    gaps = sorted(ranked(evidence, balance.blank, search.best.fit.fit),
                  key=lambda gap: gap.after - gap.before)
    others = _others(search)
    return replace(
        verdict, findings=(*verdict.findings, *(
            f for f in findings_of(search, rivals_in(search)) if f.joint not in others)),
        remainders=(*verdict.remainders, *(
            Remainder('controller', 'effort', gap.after, SERVO, gap.joint)
            for gap in sorted(gaps, key=lambda gap: -gap.after) if gap.joint in others)),
        not_tried={name: why for name, why in verdict.not_tried.items() if name not in tried},
        visible={**verdict.visible, **smallest_visible(search.evidence, search.best)},
        servos=tuple(gaps))


def with_learnt_servos(knowledge: Knowledge, robot: RobotModel, logs: Sequence[RobotLog]
                       ) -> Knowledge:
    """
    Return `knowledge` with what its references teach of the servos.

    Args:
        knowledge: of `logs`.
        robot: its model, with the servos of the file, whose gains may be any.
        logs: references; without setpoints in each of them the knowledge stays as it is.
    """
    recordings = _servo_rows(robot, logs, ANY_GAIN)
    if not recordings:
        return knowledge
    evidence = RobotLikelihood(recordings)
    fit = evidence.fit()
    dispersion = scattered(evidence, fit, _laws(recordings, CONTROLLER))[1]
    return replace(knowledge, servos=ServoKnowledge(
        another_day(evidence, fit, dispersion), dispersion))


ANY_GAIN = 1.0  # deviation of a gain that a reference teaches, of that in the file


def _servo_rows(robot: RobotModel, logs: Sequence[RobotLog], tolerance: float) -> list[Rows]:
    """Return rows of the servos with a `tolerance` of gains, none without servos or setpoints."""
    of_servos = [log.of_servos for log in logs]
    if robot.kp is None or not np.all(robot.kp > 0.0) or None in of_servos:
        return []
    robot = replace(robot, gain_tolerance=tolerance)
    return [_rows(rows_of(log, robot), motion_of(torques).input)
            for log, torques in zip(of_servos, logs) if log is not None]


SERVO = 'setpoint'  # of a remainder, in place of a variable
MOST_LEFT = 0.5  # of the torque: a servo that leaves more follows another law
LATE = 0.5  # period: deviation of when a setpoint acts that is held for one


def _rows(rows: Rows, torque: Array) -> Rows:
    """Return rows of setpoints whose servos have to produce a `torque` [N, J]."""
    acted = np.stack([rows.tested(j, torque[:, j, None])[:, 0] for j in range(torque.shape[1])])
    joints = tuple(replace(m, model=torque[:, j]) for j, m in enumerate(rows.joints))
    out = replace(rows, target=rows.target + rows.model - acted, model=acted, joints=joints)
    late = LATE * rows.motion.step
    return replace(out, nuisance=tuple(
        replace(c, deviation=late) if c.label == f'{HELD}: lag' else c
        for c in nuisance_of(out, ()) if c.of_input or c.label.startswith('lag')))


def _laws(recordings: Sequence[Rows], effects: Sequence[str]) -> list[Candidate]:
    """Return `effects` of the controller at each joint, and a delay of all setpoints alike."""
    laws = library(recordings, effects)
    if not recordings[0].measured:  # a commanded torque is the servo's own: nothing is behind it
        laws = [replace(c, twins=tuple(t for t in c.twins if EFFECTS[t].location == 'controller'))
                for c in laws]
    late = [c for c in laws if c.effect == SETPOINT_DELAY.id]
    return [*laws, *(replace(c, joint=None, columns={j: x for other in late for j, x
                                                     in other.columns.items()})
                     for c in late[:1] if len(late) > 1)]


def _others(search: BalanceSearch) -> set[str]:
    """
    Return the joints whose servo follows another law than the servo in the file.

    Effects explain less than half of the torque, or the fit needs a gain so far from the file that
    it would have been a finding, had its bounds allowed it.
    """
    evidence, fit = search.evidence.likelihood, search.best.fit.fit
    out = set()
    for j, (a, x) in enumerate(zip(evidence.at, fit.residual)):
        name = evidence.recordings[0].robot.chain.joints[j]
        torque = np.concatenate([rows.model[j] for rows in evidence.recordings])[a.order]
        gain = fit.nuisance[evidence.labels.index(f'kp {name}')]  # in deviations
        if abs(gain) > SETTINGS.certain or np.linalg.norm(x) > MOST_LEFT * np.linalg.norm(torque):
            out.add(name)
    return out
