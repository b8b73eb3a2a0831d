# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How well a drive in an MJCF file explains a recording: MuJoCo runs the file on the recorded torque.

As in the package's own simulator, each window of 1 s starts from the positions and speeds that fit
best and runs with nothing but the torque. Activations and delays go on from the window before.
"""
from collections.abc import Callable, Collection, Mapping, Sequence
import copy
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.joint.closed_model import Overlay
from gearbox_monitor.diagnosis.robot.candidates import Candidate
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.verdict import RobotVerdict, sampled_early
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.balance_column import BalanceColumn
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_VISCOUS
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.compiling import compiled_model
from gearbox_monitor.simulators.mjcf_file import MjcfDrive
from gearbox_monitor.simulators.robot_model import ChainFile, servo_of
from gearbox_monitor.simulators.robot_patch import closed_file, finding_title, title_of
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
    if rows.setpoint:   # the servo, whose damping MuJoCo integrates implicitly
        m.dof_damping[:] += kd
        torque += np.stack([x.compensation for x in joints], axis=1)
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
                data.qfrc_applied[:] += kp * (motion.input[low] - data.qpos)
            mujoco.mj_step(m, data)
        total += (data.qpos - motion.q[s + length - 1]) ** 2
    out: Array = np.sqrt(total / max(len(starts), 1))
    return out
