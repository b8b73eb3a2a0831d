# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How well a drive in an MJCF file explains a recording: MuJoCo runs the file on the recorded torque.

As in the package's own simulator, each window of 1 s starts from the positions and speeds that fit
best and runs with nothing but the torque. Activations and delays go on from the window before.
"""
from collections.abc import Callable
import copy
import math
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.joint.model_overlay import Overlay
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.robot.compiled_model import mujoco_module
from gearbox_monitor.simulators.mjcf_file import MjcfDrive
from gearbox_monitor.simulators.start_fit import fitted_start, STEPS


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
