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
import scipy

from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows, Simulator
from gearbox_monitor.kernels.sensor_noise import noise_levels
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.equivalent_torque import gains, imbalance, imbalance_with, true_motion
from gearbox_monitor.plant.simulate import N_STATE, PackedDrive, plugin_of
from gearbox_monitor.signals.recording import UniformRecording

X1, X3, A1, MOVES, SMOOTH_U = range(5)  # columns of the motor's motion; SMOOTH_U acts on it
HALF_WIDTHS = (0.003, 0.005, 0.008, 0.012, 0.018, 0.025, 0.035, 0.05)  # s
DEGREE = 3
NOISE_SHARE = 0.3   # of the noise of u that noise of the acceleration may come to
MIN_GAIN = 0.05     # of the torque that acts over the torque that is logged
LEAST_NOISE = 0.01  # of u itself, for one without noise
STANDING = 0.02     # of the top speed: below, friction is not that of a moving motor
TOP = 99.0          # percentile
SPEED_NOISE = 5.0   # standard deviations of the speed that are no motion
# An actuator acts on the smooth torque: what it would do to the noise of u is no evidence.
TORQUE_HALF_WIDTH = 0.025  # s


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
    motor = np.column_stack([motion(recording.y[:, column], noise[1], half, recording.dt),
                             scipy.signal.savgol_filter(recording.u, width, DEGREE)])
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
        weights = scipy.signal.savgol_coeffs(2 * half + 1, DEGREE, deriv=2, delta=dt)
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
    x, v, a = (scipy.signal.savgol_filter(y, width, DEGREE, deriv=i, delta=dt) for i in (0, 1, 2))
    weights = scipy.signal.savgol_coeffs(width, DEGREE, deriv=1, delta=dt)
    threshold = max(STANDING * np.percentile(np.abs(v), TOP),
                    SPEED_NOISE * noise * np.linalg.norm(weights))
    stands = np.abs(v) < threshold
    # Local cubics see a stop before it comes.
    stands = np.convolve(stands, np.ones(2 * half + 1), 'same') > 0.5
    return np.column_stack([x, v, a, ~stands])


class BalanceSimulator(Simulator):
    """
    The torque and twist that a measured motion needs, in place of runs.

    Readings are the torque that the motion of both sides needs (N m), and where the arm would
    stand if it were not short of torque (rad). No state and no memory of a window is free.
    """

    begins_known = True

    def __init__(self, recording: UniformRecording, model: DriveModel) -> None:
        assert recording.motor is not None
        super().__init__(replace(recording, u=recording.motor[:, SMOOTH_U]), model)
        self.n, self._logged = 1, recording.u
        self.moves = recording.motor[:, MOVES] != 0.0
        self.stiffness = model.folded().transmission.stiffness
        self.t = np.arange(len(self.u)) * self.dt
        position, arm_position = recording.positions.T
        self.sizes = (max(float(np.std(position - arm_position)), 1e-9),
                      max(float(np.std(recording.u)), 1e-12))
        noise = noise_levels(recording.y)[0][1] if 1 in recording.channels else 0.0
        gain = max(NOISE_SHARE * noise_levels(recording.u[:, None])[0][0],
                   LEAST_NOISE * float(np.std(recording.u)))
        half = half_width(gain / max(model.arm_inertia * noise, 1e-300), self.dt)
        motor = recording.motor[:, :3]
        arm = motor if 1 not in recording.channels else motion(
            recording.y[:, 1], noise, half, self.dt)[:, :3]
        self.read = np.stack([motor, arm], axis=2).reshape(len(self.u), 6)

    def surplus(self, model: DriveModel) -> Array:
        """
        Return (torque on the whole drive, N m, twist, rad) [N, 2] that `model` does not have.

        The twist is the distance from the curve of torque over twist: a transmission that is too
        soft or has too large a gap has no torque, and is far from the readings all the same.
        """
        e = model.pack_effects()
        plugin, theta = plugin_of(model)
        drive = PackedDrive(model.pack(), e, theta)
        moved = np.empty_like(self.read)
        true_motion(self.read, self.dt, e, moved)
        kernel = imbalance if plugin is None else imbalance_with(plugin.torques)
        out = np.zeros((len(moved), 3))
        acting, twist = self.acting(e)[:, 0], moved[:, 0] - moved[:, 1]
        rigid = model.transmission.kind == 'rigid'
        if rigid:
            moved[:, 1::2] = moved[:, ::2]
        kernel((self.t, moved), self.dt, self.sizes, acting, self.extra, drive,
               np.zeros(N_STATE), out)
        # In a rigid one, what shows between the encoders is theirs.
        out[:, 1] = twist if rigid else out[:, 2]
        gains(moved[:, 0], e, acts := np.empty(len(moved)))
        out[:, 0] /= np.maximum(acts, MIN_GAIN)
        return out[:, :2]

    def run(self, windows: ShootingWindows, model: DriveModel, states: Array, memory: Array,
            extra: Array | None = None) -> tuple[Array, Array]:
        """Return (readings [W, L, 2], carry [W, 8]) of Simulator.run; states count for nothing."""
        out = self.surplus(model)
        at = windows.first[:, None] + np.arange(windows.length)
        needed = out[at]
        if extra is not None:
            inside = (windows.first - windows.begin)[:, None] + np.arange(windows.length)
            more = extra[at] if extra.ndim == 2 else extra[np.arange(len(at))[:, None], inside]
            more = more - self.extra[at]
            needed[:, :, 0] -= more[:, :, 0] + more[:, :, 1]
            needed[:, :, 1] -= (more[:, :, 1] + more[:, :, 2]) / self.stiffness
        y = np.stack([np.where(self.moves, self.u, self._logged)[at], self.read[at, 1]], axis=2)
        y[:, :, 0] += self.moves[at] * needed[:, :, 0]
        y[:, :, 1] += needed[:, :, 1]
        return y, np.zeros((len(at), N_STATE))


def simulator(recording: UniformRecording, model: DriveModel, finer: int = 1) -> Simulator:
    """Return the Simulator of free runs of `model`, or of what the motion recorded needs."""
    if recording.motor is not None:
        return BalanceSimulator(recording, model)
    return Simulator(recording, model, finer=finer)
