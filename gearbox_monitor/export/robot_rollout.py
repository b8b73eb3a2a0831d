# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
How far findings close the gap in MuJoCo: free runs from recorded states under the recorded torque.

The balance decides; the runs confirm, and give the number that users of a simulator want. What
references taught beside the file, and effects that no attribute expresses, act as the torque that
they have along the recorded motion.
"""
from collections.abc import Mapping
import copy
from dataclasses import replace
from typing import Any

import numpy as np

from gearbox_monitor.balance.robot_effects import BASE_TILT, GRAVITY_SIZE
from gearbox_monitor.balance.verdict import RobotVerdict
from gearbox_monitor.export.robot_bodies import body_with
from gearbox_monitor.export.robot_closed import OF_LINK
from gearbox_monitor.export.robot_model import ChainFile
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.motor_side import MOTOR_INERTIA
from gearbox_monitor.robot.compiled_model import mujoco_module

WINDOW = 0.5    # s of a run
MOST = 40       # windows
NATIVE = (*OF_LINK, MOTOR_INERTIA.id, BASE_TILT.id)


def rollouts(file: ChainFile, verdict: RobotVerdict) -> dict[str, Any]:
    """
    Return how far free runs are off before and after the findings.

    Returns:
        {'window': s, 'joints': {joint: {'before', 'after': rms, rad or m}}, 'confirmed': whether
        the joint that was off most is nearer}.
    """
    rows = verdict.evidence.recordings[0]
    before = _runs(file, verdict, False)
    after = _runs(file, verdict, True)
    joints = {name: {'before': float(b), 'after': float(a)}
              for name, b, a in zip(rows.robot.chain.joints, before, after)}
    spread = np.std(rows.motion.q, axis=0) + 1e-9
    worst = int(np.argmax(before / spread))
    return {'window': WINDOW, 'joints': joints, 'confirmed': bool(after[worst] < before[worst])}


def _runs(file: ChainFile, verdict: RobotVerdict, closed: bool) -> Array:
    """Return the rms [J] of the free runs at the ends of the windows."""
    mujoco = mujoco_module()
    rows, m = verdict.evidence.recordings[0], _copy(file)
    learnt, chain, motion = rows.robot.learnt, rows.robot.chain, rows.motion
    taught = np.zeros_like(motion.q)
    if learnt:     # friction of the file is not used: that of the references acts along the motion
        m.dof_frictionloss[:] = 0.0
        m.dof_damping[:] = 0.0
        m.actuator_damping[:] = 0.0
        for j in range(len(chain.links)):
            taught[:, j] = rows.joints[j].model - rows.joints[j].smooth
    effort = np.stack([x.effort for x in rows.joints], axis=1) - taught
    for i, c in enumerate(verdict.fit.chosen if closed else ()):
        b = verdict.fit.values[verdict.fit.of(i)]
        if c.effect in NATIVE and c.values is not None:
            _edit(m, file, c.effect, c.joint or c.link or '', c.values(b))
        elif c.effect in EFFECTS and c.joint is not None:
            column = EFFECTS[c.effect].column
            j = chain.joints.index(c.joint)
            if column is not None and not column.momentum:
                effort[:, j] -= column.series(rows.joints[j], c.setting or 0.0) @ b
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
    return out


def _copy(file: ChainFile) -> Any:
    """Return a copy of the compiled model without its actuators and contacts."""
    mujoco = mujoco_module()
    m = copy.copy(file.compiled)
    m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION) | int(
        mujoco.mjtDisableBit.mjDSBL_CONTACT)
    return m


def _edit(m: Any, file: ChainFile, effect: str, place: str, values: Mapping[str, float]) -> None:
    """Put a finding with its `values` into the compiled model `m`."""
    mujoco = mujoco_module()
    if effect == MOTOR_INERTIA.id:
        m.dof_armature[file.chain.joints.index(place)] += values['m1_change']
    elif effect == BASE_TILT.id:
        m.opt.gravity[:2] += GRAVITY_SIZE * np.array([values['ax'], values['ay']])
    else:
        body, (mass, centre, tensor) = body_with(
            replace(file, compiled=m), place, OF_LINK[effect](values))
        moments, vectors = np.linalg.eigh(tensor)
        if np.linalg.det(vectors) < 0.0:
            vectors[:, 0] *= -1.0
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, vectors.ravel())
        m.body_mass[body], m.body_ipos[body], m.body_iquat[body] = mass, centre, quat
        m.body_inertia[body] = moments
