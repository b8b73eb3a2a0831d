# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Recordings whose measured motor motion drives the model (`driven_by: position`).

Position, speed and acceleration of the motor come from its encoder by local cubics (Savitzky and
Golay 1964), as wide as the noise requires: their noise in the torque m1 x3' stays well below that
of the torque u.
"""
from dataclasses import replace

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from gearbox_monitor.identification.shooting import ShootingWindows, Simulator
from gearbox_monitor.kernels.sensor_noise import noise_levels
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant import prescribed_motion as kernels
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects.composition import arm_positions, DELAY2
from gearbox_monitor.plant.effects.effect import Torques
from gearbox_monitor.plant.free_runs import Begin, Driving, RunResult, RunSpans
from gearbox_monitor.plant.simulate import PackedDrive
from gearbox_monitor.quality.recording import UniformRecording

HALF_WIDTHS = (0.003, 0.005, 0.008, 0.012, 0.018, 0.025, 0.035, 0.05)  # s
DEGREE = 3
NOISE_SHARE = 0.3   # of the noise of u that noise of the acceleration may come to
LEAST_NOISE = 0.01  # of u itself, for one without noise
STANDING = 0.02     # of the top speed: below, friction is not that of a moving motor
TOP = 99.0          # percentile
SPEED_NOISE = 5.0   # standard deviations of the speed that are no motion
# An actuator acts on the smooth torque: what it would do to the noise of u is no evidence.
TORQUE_HALF_WIDTH = 0.025  # s
ARM_HALF_WIDTH = 0.006  # s, for position and speed of the arm


def driven(recording: UniformRecording, model: DriveModel) -> UniformRecording:
    """
    Return `recording` as the DriveModel `model` wants it: with the motor's motion if that drives.

    Of a rigid drive with one encoder, the motion is that of this encoder.
    """
    if model.driven_by != 'position' or recording.motor is not None:
        return recording
    rigid = model.transmission.kind == 'rigid'
    column = recording.channels[0]
    noise, _ = noise_levels(np.column_stack([recording.u, recording.y[:, column]]))
    inertia = model.motor_inertia + (model.arm_inertia if rigid else 0.0)
    half = half_width(max(NOISE_SHARE * noise[0], LEAST_NOISE * np.std(recording.u)) / max(
        inertia * noise[1], 1e-300), recording.dt)
    width = 2 * max(2, round(TORQUE_HALF_WIDTH / recording.dt)) + 1
    motor = np.concatenate([
        np.column_stack([motion(recording.y[part, column], noise[1], half, recording.dt),
                         savgol_filter(recording.u[part], width, DEGREE)])
        for part in recording.segments])
    y = recording.y.copy()
    y[:, 0] = recording.u
    channels = (0,) if len(recording.channels) == 1 else (0, 1)
    return replace(recording, y=y, channels=channels, motor=motor)


def half_width(gain: float, dt: float) -> int:
    """
    Return how many samples on either side a local cubic takes.

    Args:
        gain: largest gain from position noise to acceleration noise, 1/s^2.
        dt: sample time, s.
    """
    for seconds in HALF_WIDTHS:
        half = max(2, round(seconds / dt))
        weights = savgol_coeffs(2 * half + 1, DEGREE, deriv=2, delta=dt)
        if np.linalg.norm(weights) <= gain:
            break
    return half


def motion(y: Array, noise: float, half: int, dt: float) -> Array:
    """
    Return position, speed, acceleration and whether it moves [N, 4] of readings y [N], rad.

    Args:
        y: readings of one encoder [N], rad.
        noise: standard deviation of the readings, rad.
        half: samples on each side of the filter.
        dt: sample time, s.
    """
    width = min(2 * half + 1, (len(y) - 1) // 2 * 2 + 1)
    x, v, a = (savgol_filter(y, width, DEGREE, deriv=i, delta=dt) for i in (0, 1, 2))
    weights = savgol_coeffs(width, DEGREE, deriv=1, delta=dt)
    threshold = max(STANDING * np.percentile(np.abs(v), TOP),
                    SPEED_NOISE * noise * np.linalg.norm(weights))
    stands = np.abs(v) < threshold
    # Local cubics see a stop before it comes.
    stands = np.convolve(stands, np.ones(2 * half + 1), 'same') > 0.5
    return np.column_stack([x, v, a, ~stands])


class DrivenSimulator(Simulator):
    """
    Free runs of the arm alone, over a Recording that holds the motor's motion.

    They begin where the arm's encoder says: a light arm forgets its start within milliseconds.
    """

    begins_known = True
    # Contacts that are made a little earlier or later make small differences jagged.
    stretch = 25.0
    nonsmooth = True

    def __init__(self, recording: UniformRecording, model: DriveModel) -> None:
        assert recording.motor is not None
        super().__init__(replace(recording, u=recording.motor[:, kernels.SMOOTH_U]), model)
        self.motor = recording.motor
        # One number of steps for all candidates: otherwise a difference in accuracy is evidence.
        self.n = kernels.steps(model, self.dt)
        self._logged = np.ascontiguousarray(recording.u)
        self._arm = np.concatenate([_arm(recording.y[part, 1], self.dt)
                                    for part in recording.segments])

    def _begun(self, windows: ShootingWindows, model: DriveModel, states: Array) -> Array:
        """Return the states [W, 4] of the arm as its encoder says; `states` count for nothing."""
        e = model.pack_effects()
        read, speed = self._arm[windows.begin].T
        x2 = np.empty(len(read))
        arm_positions(read, e, x2)
        starts = np.zeros_like(states)
        starts[:, 1], starts[:, 3] = x2 + e[DELAY2] * speed, speed
        return starts

    def _fill(self, spans: RunSpans, start: Begin, driving: Driving, drive: PackedDrive,
              added: Torques | None, result: RunResult) -> None:
        """Fill in the torque that the motor needs (N m) as y [W, L, 0], the reading of the arm."""
        kernel = kernels.driven_runs if added is None else kernels.with_plugin(added)
        kernel(spans, start, driving, kernels.MotorMotion(self._logged, self.motor), drive,
               self._rows(spans), result)


def _arm(y: Array, dt: float) -> Array:
    """Return position and speed [N, 2] of readings y [N], rad."""
    width = 2 * max(2, round(ARM_HALF_WIDTH / dt)) + 1
    return np.column_stack([savgol_filter(y, width, 2, deriv=i, delta=dt) for i in (0, 1)])


def simulator(recording: UniformRecording, model: DriveModel) -> Simulator:
    """Return the Simulator of free runs of `model`, driven by the torque or motion recorded."""
    if recording.motor is not None:
        return DrivenSimulator(recording, model)
    return Simulator(recording, model)
