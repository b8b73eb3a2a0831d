# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Free runs in MuJoCo of the file of a robot, with findings and without."""
from collections.abc import Collection, Mapping, Sequence
import copy
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.verdict import (
    RobotVerdict, sampled_early, setpoint_lags)
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.balance_column import BalanceColumn
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_VISCOUS
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.compiling import compiled_model
from gearbox_monitor.simulators.robot_model import ChainFile, servo_of
from gearbox_monitor.simulators.robot_patch import closed_file, finding_title, title_of


WINDOW = 0.5    # s of a run
MOST = 40       # windows
FARTHER = 1.1   # times as far off: more than what noise of the first state makes
FRICTION = (MOTOR_COULOMB.id, MOTOR_VISCOUS.id)  # references teach it
COLUMNS = {(e.id, ''): e.column for e in EFFECTS.values()} | {
    (e.id, e.over): e.column for e in ROBOT_EFFECTS}


def rollouts(file: ChainFile, verdict: RobotVerdict) -> dict[str, Any]:
    """
    Return how far free runs are off before and after the findings.

    A finding whose place is not in the file acts as a torque, which decides whether runs confirm
    it. Those `after` are of the file as it is written, without such torques and vetoed findings.

    Args:
        file: of the robot, an MJCF.
        verdict: on recordings, of which the first one is run.

    Returns:
        {'window': s, 'joints': {joint: {'before', 'after': rms, rad or m}}, 'vetoed': titles (see
        robot_patch) of findings with which the runs are farther off, in units of the motion of
        the joints that they act on; 'confirmed': whether there is none; 'without': titles of
        those that are not in the runs}.
    """
    rows, findings = verdict.evidence.recordings[0], [f.to_dict() for f in verdict.findings]
    joints, titles = rows.robot.chain.joints, {title_of(f) for f in findings}
    taught = {title_of(f) for f in findings if rows.robot.learnt and f['effect'] in FRICTION}
    closed, lacking = _written(file, findings)
    torques = {finding_title(c.effect, c.place) for c in verdict.fit.chosen
               if not c.free and _column(c) is not None} - (titles - lacking)
    without = lacking - torques
    before = _runs(file.compiled, verdict, frozenset())
    after = _runs(closed, verdict, torques | taught)
    spread, vetoed = np.std(rows.motion.q, axis=0) + 1e-9, list[str]()
    for c in verdict.fit.chosen:
        own = list(c.columns) if c.joint is None else [joints.index(c.joint)]
        size = [math.hypot(*(x / spread)[own]) for x in (before, after)]
        name = finding_title(c.effect, c.place)
        if name in titles - without and not size[1] < FARTHER * size[0]:
            vetoed.append(name)
    if torques or vetoed:
        closed, _ = _written(file, [f for f in findings if title_of(f) not in vetoed])
        after = _runs(closed, verdict, taught.difference(vetoed))
    return {'window': WINDOW, 'joints': {
        name: {'before': float(b), 'after': float(a)} for name, b, a in zip(joints, before, after)
        }, 'confirmed': not vetoed, 'vetoed': list(dict.fromkeys(vetoed)),
        'without': sorted(without)}


def _written(file: ChainFile, findings: Sequence[Mapping[str, Any]]) -> tuple[Any, set[str]]:
    """Return the model of the file with `findings`, and the titles of those that it lacks."""
    text, lacking = closed_file(file, findings, '')
    m = file.compiled if text is None else compiled_model(
        text.encode(), file.path, file.root, file.locked)
    return m, set(lacking)


def _column(c: Candidate) -> BalanceColumn | None:
    """Return the column of the torque of `c` on its joint, None if it is another one."""
    column = COLUMNS.get((c.effect, c.over))
    return None if column is None or c.joint is None or column.momentum else column


def _runs(model: Any, verdict: RobotVerdict, added: Collection[str]) -> Array:
    """
    Return the rms [J] of free runs at the ends of the windows.

    Args:
        model: mujoco.MjModel of the file.
        verdict: on a recording, whose torques or setpoints act.
        added: titles of findings that act as torques.
    """
    mujoco = mujoco_module()
    rows, m = verdict.evidence.recordings[0], copy.copy(model)
    m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION) | int(
        mujoco.mjtDisableBit.mjDSBL_CONTACT)
    robot, motion, joints = rows.robot, rows.motion, rows.joints
    gains = servo_of(model)[:2]   # a finding may have changed them
    kp, kd = (np.zeros(len(joints)) if x is None else x for x in (
        (robot.kp, robot.kd) if gains[0] is None else gains))
    torque = np.zeros_like(motion.q)
    if robot.learnt:   # friction of the file is not used: that of the references acts
        m.dof_frictionloss[:] = 0.0
        m.dof_damping[:] = 0.0
        m.actuator_damping[:] = 0.0
        torque -= np.stack([x.taught for x in joints], axis=1)
    for i, c in enumerate(verdict.fit.chosen):
        column = _column(c)
        if column is not None and finding_title(c.effect, c.place) in added:
            j = robot.chain.joints.index(c.joint or '')
            torque[:, j] -= column.series(joints[j], c.setting or 0.0) @ verdict.fit.values[
                verdict.fit.of(i)]
    setpoint = motion.input
    if rows.setpoint:   # the servo, whose damping MuJoCo integrates implicitly
        m.dof_damping[:] += kd
        torque += np.stack([x.compensation for x in joints], axis=1)
        # A run holds a setpoint over the timesteps of a period: it is late by their middle.
        late = setpoint_lags(verdict.evidence, verdict.fit) - 0.5 * (
            motion.step - m.opt.timestep)
        setpoint = setpoint - late * motion.input_speed
    else:
        early = sampled_early(verdict.evidence, verdict.fit)[0]
        rate = np.gradient(motion.v, motion.step, axis=0)
        torque += motion.input - early * (kp * motion.v + kd * rate)
    mujoco.mj_setConst(m, mujoco.MjData(m))
    data, step = mujoco.MjData(m), float(m.opt.timestep)
    length = max(int(round(WINDOW / motion.step)), 2)
    starts = [s for part in motion.sections
              for s in range(part.start, part.stop - length, length)]
    starts = starts[::max(1, len(starts) // MOST)]
    total = np.zeros(motion.q.shape[1])
    for s in starts:
        data.qpos[:], data.qvel[:] = motion.q[s], motion.v[s]
        t = motion.t[s:s + length]
        for k in range(int(round((t[-1] - t[0]) / step))):
            at = s + min((k + 0.5) * step / motion.step, length - 1.001)
            low = int(at)
            data.qfrc_applied[:] = torque[low] + (at - low) * (torque[low + 1] - torque[low])
            if rows.setpoint:
                data.qfrc_applied[:] += kp * (setpoint[low] - data.qpos)
            mujoco.mj_step(m, data)
        total += (data.qpos - motion.q[s + length - 1]) ** 2
    out: Array = np.sqrt(total / max(len(starts), 1))
    return out
