# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How well a drive in an MJCF file explains a recording: MuJoCo runs the file on the recorded torque.

As in the package's own simulator, each window of 1 s starts from the positions and speeds that fit
best and runs with nothing but the torque. Activations and delays go on from the window before.
"""
from collections.abc import Callable, Mapping
import copy
from dataclasses import replace
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.joint.closed_model import Overlay
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.robot_effects import BASE_TILT, ROBOT_EFFECTS, tilted
from gearbox_monitor.diagnosis.robot.verdict import RobotVerdict
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.motor_side import MOTOR_INERTIA
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.mjcf_file import MjcfDrive
from gearbox_monitor.simulators.robot_model import ChainFile
from gearbox_monitor.simulators.robot_patch import body_with, finding_title, OF_JOINT, OF_LINK
from gearbox_monitor.simulators.user_simulator import fitted_start, STEPS


class Rig(NamedTuple):
    """
    A drive in MuJoCo as a recording sees it.

    joints: of motor and arm; ctrl: control for a torque of 1 N m; n: steps per sample, negative:
    samples per step. sensors {joint: its place in sensordata}, of readings that are late.
    """

    model: Any
    joints: tuple[int, int]
    ctrl: float
    place: int
    n: int
    sensors: dict[int, int]

    def states(self) -> list[tuple[int, int]]:
        """Return (place in qpos, place in qvel) of each joint once."""
        m = self.model
        return [(int(m.jnt_qposadr[j]), int(m.jnt_dofadr[j])) for j in dict.fromkeys(self.joints)]


def rig_of(drive: MjcfDrive, ctrl: float, dt: float) -> Rig:
    """
    Return the Rig of a drive.

    Args:
        drive: in a file.
        ctrl: control that makes 1 N m on the joint of the motor, nominally.
        dt: sample time of the recording, s.

    Returns:
        The Rig.

    Raises:
        InputError: no actuator, one that follows a setpoint, or steps that do not fit dt.

    """
    m, actuator = drive.compiled, drive.actuator
    if actuator is None or actuator.setpoint:
        raise InputError(f'{drive.path}: joint {drive.motor.name}: no actuator that takes a '
                         'torque, expected a motor for the recorded one')
    ratio = dt / drive.timestep
    n = round(ratio) if ratio > 0.75 else -round(1.0 / ratio)
    if not math.isclose(ratio, n if n > 0 else -1.0 / n, rel_tol=1e-3):
        raise InputError(f'{drive.path}: timestep: {drive.timestep:g} s, expected a whole part or '
                         f'multiple of the sample time {dt:g} s')
    sensors = {int(m.sensor_objid[i]): int(m.sensor_adr[i]) for i in range(m.nsensor)
            if m.sensor_delay[i] > 0.0}
    return Rig(m, (drive.motor.index, drive.arm_joint.index), ctrl,
               int(m.actuator_ctrladr[actuator.index]), n, sensors)


def misfit(rig: Rig, laid: Overlay, progress: Callable[[int, int], None]) -> float:
    """
    Return the misfit of a Rig on the windows of a recording, in standard deviations; 1: floor.

    Args:
        rig: MuJoCo's drive.
        laid: recording with windows, and its first run near which states start.
        progress: function (done, total), called after each window.

    Returns:
        Root mean square of the residuals.

    """
    mujoco = mujoco_module()
    dt, u = laid.recording.dt, laid.recording.u * rig.ctrl
    data, at, squares, count = mujoco.MjData(rig.model), 0, 0.0, 0
    modelled = laid.runs[0].y
    for w, begin in enumerate(laid.windows.first):
        begin, length = int(begin), laid.windows.length
        _run(rig, data, u[at:begin])  # between windows: activations go on
        start = np.empty(2 * len(rig.states()))
        speed = (-3.0 * modelled[w, 0] + 4.0 * modelled[w, 1] - modelled[w, 2]) / (2.0 * dt)
        for k in range(len(start) // 2):
            start[2 * k:2 * k + 2] = modelled[w, 0, k], speed[k]
        data, residual = _fitted(rig, data, (start, u[begin:begin + length], laid.measured[w]),
                                 laid)
        at = begin + length
        squares, count = squares + float(residual @ residual), count + len(residual)
        progress(w + 1, len(laid.windows))
    return math.sqrt(squares / count)


def _fitted(rig: Rig, data: Any, window: tuple[Array, Array, Array], laid: Overlay
            ) -> tuple[Any, Array]:
    """Return MuJoCo's state after a window (start, controls, readings), and its residual."""
    start, u, measured = window
    channels = list(laid.channels)

    def _ended(state: Array) -> tuple[Any, Array]:
        end = copy.copy(data)
        for k, (place, dof) in enumerate(rig.states()):
            end.qpos[place], end.qvel[dof] = state[2 * k:2 * k + 2]
        y = _run(rig, end, u)
        stride = max(1, -rig.n)
        difference = (measured[::stride][:len(y)] - y) / laid.sigma
        return end, np.nan_to_num(difference[:, channels].ravel(), nan=1e9, posinf=1e9)
    start, _ = fitted_start(lambda state: _ended(state)[1], start,
                            np.tile(STEPS, len(start) // 2))
    return _ended(start)


def _run(rig: Rig, data: Any, u: Array) -> Array:
    """Step `data` through the controls `u` [N]; return readings of motor and arm [M, 2]."""
    mujoco, m = mujoco_module(), rig.model
    stride = max(1, -rig.n)
    u = u[:len(u) - len(u) % stride].reshape(-1, stride).mean(axis=1)
    y = np.empty((len(u), 2))
    places = [int(m.jnt_qposadr[j]) for j in rig.joints]
    for k, ctrl in enumerate(u):
        if rig.sensors:  # those of a step are from before it
            mujoco.mj_forward(m, data)
        for i, (joint, place) in enumerate(zip(rig.joints, places)):
            address = rig.sensors.get(joint)
            y[k, i] = data.qpos[place] if address is None else data.sensordata[address]
        data.ctrl[rig.place] = ctrl
        mujoco.mj_step(m, data, nstep=max(1, rig.n))
    return y


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
        m.opt.gravity[:] = tilted(m.opt.gravity.copy(), values['ax'], values['ay'])
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
