# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How far findings close the gap in MuJoCo: free runs from recorded states under the recorded torque.

The balance decides; the runs confirm or veto, and give the number that users of a simulator want.
Findings that the file can hold are in the model as they would be in the file. What references
taught beside the file, and effects that no attribute expresses, act as the torque that they have
along the recorded motion.
"""
from collections.abc import Mapping
import copy
from dataclasses import replace
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.robot_effects import BASE_TILT, GRAVITY_SIZE, ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.verdict import RobotVerdict
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.motor_side import MOTOR_INERTIA
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.robot_bodies import body_with
from gearbox_monitor.simulators.robot_closed import finding_title, OF_JOINT, OF_LINK
from gearbox_monitor.simulators.robot_model import ChainFile

WINDOW = 0.5    # s of a run
MOST = 40       # windows
FARTHER = 1.1   # times as far off: more than what noise of the first state makes
ALWAYS = (*OF_LINK, MOTOR_INERTIA.id, BASE_TILT.id)  # in the model, also beside references
COLUMNS = {(e.id, ''): e.column for e in EFFECTS.values()} | {
    (e.id, e.over): e.column for e in ROBOT_EFFECTS}


def rollouts(file: ChainFile, verdict: RobotVerdict) -> dict[str, Any]:
    """
    Return how far free runs are off before and after the findings.

    Args:
        file: of the robot, an MJCF.
        verdict: on recordings of torques; the first one is run.

    Returns:
        {'window': s, 'joints': {joint: {'before', 'after': rms, rad or m}}, 'vetoed': titles (see
        robot_closed) of findings with which the runs are farther off, in units of the motion of
        the joints that they act on; 'confirmed': whether there is none; 'without': titles of
        those that are not in the runs}.
    """
    rows = verdict.evidence.recordings[0]
    nominal, _ = _runs(file, verdict, False)
    closed, without = _runs(file, verdict, True)
    joints = {name: {'before': float(b), 'after': float(a)}
              for name, b, a in zip(rows.robot.chain.joints, nominal, closed)}
    spread = np.std(rows.motion.q, axis=0) + 1e-9
    vetoed = []
    for c in verdict.fit.chosen:
        own = list(c.columns) if c.joint is None else [rows.robot.chain.joints.index(c.joint)]
        size = [math.hypot(*(x / spread)[own]) for x in (nominal, closed)]
        name = finding_title(c.effect, c.place)
        if not c.free and name not in without and not size[1] < FARTHER * size[0]:
            vetoed.append(name)
    return {'window': WINDOW, 'joints': joints, 'confirmed': not vetoed,
            'vetoed': list(dict.fromkeys(vetoed)), 'without': without}


def _runs(file: ChainFile, verdict: RobotVerdict, closed: bool) -> tuple[Array, list[str]]:
    """Return the rms [J] of free runs at the ends of the windows, and what is not in them."""
    mujoco = mujoco_module()
    rows, m = verdict.evidence.recordings[0], _copy(file)
    learnt, chain, motion = rows.robot.learnt, rows.robot.chain, rows.motion
    taught, without = np.zeros_like(motion.q), []
    if learnt:     # friction of the file is not used: that of the references acts along the motion
        m.dof_frictionloss[:] = 0.0
        m.dof_damping[:] = 0.0
        m.actuator_damping[:] = 0.0
        for j in range(len(chain.links)):
            taught[:, j] = rows.joints[j].taught
    effort = np.stack([x.effort for x in rows.joints], axis=1) - taught
    for i, c in enumerate(verdict.fit.chosen if closed else ()):
        b = verdict.fit.values[verdict.fit.of(i)]
        column = COLUMNS.get((c.effect, c.over))
        if c.values is not None and (c.effect in ALWAYS or c.effect in OF_JOINT and not learnt):
            try:
                _edit(m, file, c, c.values(b))
            except InputError:
                without.append(finding_title(c.effect, c.place))
        elif column is not None and c.joint is not None and not column.momentum:
            j = chain.joints.index(c.joint)
            effort[:, j] -= column.series(rows.joints[j], c.setting or 0.0) @ b
        elif not c.free:
            without.append(finding_title(c.effect, c.place))
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
            data.qfrc_applied[:] = effort[low] + (at - low) * (effort[low + 1] - effort[low])
            mujoco.mj_step(m, data)
        total += (data.qpos - motion.q[s + length - 1]) ** 2
    out: Array = np.sqrt(total / max(len(starts), 1))
    return out, without


def _copy(file: ChainFile) -> Any:
    """Return a copy of the compiled model without its actuators and contacts."""
    mujoco = mujoco_module()
    m = copy.copy(file.compiled)
    m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION) | int(
        mujoco.mjtDisableBit.mjDSBL_CONTACT)
    return m


def _edit(m: Any, file: ChainFile, c: Candidate, values: Mapping[str, float]) -> None:
    """Put a finding with its `values` into the compiled model `m`."""
    mujoco = mujoco_module()
    if c.effect in OF_JOINT and c.joint is not None:
        place, j = OF_JOINT[c.effect], file.chain.joints.index(c.joint)
        array = getattr(m, f'dof_{place.mjcf}')
        array[j] = max(array[j] + values[place.value], 0.0)
    elif c.effect == BASE_TILT.id:
        m.opt.gravity[:2] += GRAVITY_SIZE * np.array([values['ax'], values['ay']])
    else:
        body, (mass, centre, tensor) = body_with(
            replace(file, compiled=m), c.link or '', OF_LINK[c.effect](values))
        moments, vectors = np.linalg.eigh(tensor)
        if np.linalg.det(vectors) < 0.0:
            vectors[:, 0] *= -1.0
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, vectors.ravel())
        m.body_mass[body], m.body_ipos[body], m.body_iquat[body] = mass, centre, quat
        m.body_inertia[body] = moments
