# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The balance of a drive's momentum: a likelihood of models without a run of them.

What a measured motion needs is compared with what acted: the torque on the whole drive, and the
twist that the torque on the arm needs. It is the likelihood of recordings whose measured motor
motion drives the model (`driven_by: position`), and where searches by innovations begin: without a
run, values that are far off lead to the same optimum.

Residuals are taken in windows with a cosine basis (the weak form): no noisy acceleration weighs
more than it says.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.innovations import halves, InnovationLikelihood, named_motion
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows, Simulator
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.linear_least_squares import cosine_basis, motion_mask
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import (
    gains, imbalance, imbalance_with, N_STATE, packed_drive, plugin_of, true_motion)
from gearbox_monitor.signals.uniform import UniformRecording

X1, X3, ACCELERATED, MOVES, SMOOTH_U = range(5)  # of the motor's motion; SMOOTH_U acts on it
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
        plugin, drive = plugin_of(model)[0], packed_drive(model, e)
        moved = np.empty_like(self.read)
        true_motion(self.read, self.dt, e, moved)
        kernel = imbalance if plugin is None else imbalance_with(plugin.torques)
        out = np.zeros((len(moved), 3))
        held, twist = self.acting(e)[:, 0], moved[:, 0] - moved[:, 1]
        acting = 0.5 * (held + np.append(held[:1], held[:-1]))  # each from its stamp on
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


# Tests of 1 s: a held-out part is short. Few bands: a short recording would fit each.
HOP, BANDS = 0.5, (0.0, 2.0, 5.0, 10.0)  # s; Hz
SLOW, RAMP = 0.02, 0.06  # rad/s, below which friction is any torque; s about it


@dataclass(frozen=True, eq=False)
class Balanced:
    """
    The balance under a model.

    innovation, variance [R, 2]: rows of the balances of the drive, N m, and of the twist, rad,
    and their variances; read [R, 2]: whether a row counts; deviance: -2 log L; left [2]: rms of
    the residuals, N m and rad.
    """

    innovation: Array
    variance: Array
    read: Flags
    deviance: float
    left: Array

    @property
    def residual(self) -> Array:
        """Rows [R, 2] in their standard deviations."""
        return self.innovation / np.sqrt(self.variance)


class BalanceLikelihood:
    """Likelihood of models for the parts `spans` of a recording that holds the motor's motion."""

    # Torque noise is what a model leaves: none is free.
    least_noise = first_noise = np.ones(2)
    most_noise = 1.0

    def __init__(self, recording: UniformRecording, model: DriveModel, sigma: Array,
                 spans: Sequence[slice]) -> None:
        self.recording, self.nominal = recording, model
        self.simulator = BalanceSimulator(recording, model)
        read = self.simulator.read
        self.rows = np.concatenate([np.arange(s.start, s.stop) for s in spans])
        hop = max(2, round(HOP / recording.dt))
        count = int(min(BANDS[-1], 0.4 / recording.dt) * 2 * hop * recording.dt)
        self._value, _ = cosine_basis(hop, count)
        self._starts = np.concatenate([
            np.arange(s.start, s.stop - 2 * hop + 1, hop) for s in spans])
        band = np.digitize((np.arange(count) + 0.5) / (2 * hop * recording.dt), BANDS) - 1
        self._cells = [np.tile(band == k, len(self._starts)) for k in range(len(BANDS) - 1)]
        self._mask = np.ones((len(read), 2))
        for side in (0, 1):
            self._mask[:, side] = motion_mask(
                np.abs(read[:, 2 + side]) < SLOW, max(1, round(RAMP / recording.dt)))
        self._mask[:, 0] *= self.simulator.moves
        window = (self._value[:, :2] ** 2).sum(axis=1) / (self._value[:, :2] ** 2).sum()
        covered = np.array([window @ self._mask[k:k + 2 * hop] ** 2
                            for k in self._starts]).reshape(-1, 2)
        self.channels = list(recording.channels)
        self._weight = np.repeat(covered, count, axis=0)
        self._samples = np.maximum(covered.sum(axis=0) * hop, 1.0)
        self._floor = np.asarray(sigma) ** 2
        self.read = np.zeros((count * len(self._starts), 2), bool)
        self.read[:, self.channels] = True

    @property
    def readings(self) -> int:
        """Number of rows that count."""
        return max(1, round(float(self._weight[:, self.channels].sum())))

    def _rows(self, model: DriveModel) -> Array:
        out, length = -self._mask * self.simulator.surplus(model), len(self._value)
        blocks = np.array([out[k:k + length] for k in self._starts]).reshape(-1, length, 2)
        return np.matmul(self._value.T, blocks).reshape(-1, 2)

    def run(self, model: DriveModel, torque: Array) -> Balanced:
        """Return the balance under `model`; `torque` counts for nothing."""
        r, deviance = self._rows(model), 0.0
        r[~np.isfinite(r)] = 1e9
        variance, left = np.ones_like(r), np.zeros(2)
        for i in self.channels:
            for cell in self._cells:
                count, power = float(self._weight[cell, i].sum()), float((r[cell, i] ** 2).sum())
                if count < 1.0:
                    variance[cell, i] = np.inf
                    continue
                own = max(power / count, self._floor[i])
                variance[cell, i] = own
                deviance += count * np.log(own) + power / own
            left[i] = np.sqrt((r[:, i] ** 2).sum() / self._samples[i])
        r[:, [i for i in (0, 1) if i not in self.channels]] = 0.0
        return Balanced(r, variance, self.read, deviance, left)

    def change(self, run: Balanced, model: DriveModel) -> Array:
        """Return the change [R, 2] (N m) of the rows of `run` when the model is `model`."""
        return np.where(self.read, self._rows(model) - run.innovation, 0.0)

    def with_noise(self, run: Balanced, torque: Array) -> tuple[float, Array, Array]:
        """Return (-2 log L, rows, their variance) of `run`: `torque` counts for nothing."""
        return run.deviance, run.innovation, run.variance

    def shares(self, count: int) -> Integers:
        """Return in which of `count` equal parts of the recording each row [R] is."""
        return np.arange(len(self.read)) * count // max(len(self.read), 1)

    def smoothed(self, run: Balanced) -> Array:
        """Return states [N, N_STATE]: none is free."""
        return np.zeros((len(self.recording.u), N_STATE))

    def motion(self, run: Balanced) -> dict[str, Array]:
        """Return {quantity: values} of the motion, see InnovationLikelihood.motion."""
        return named_motion(self.recording, self.simulator.read, self.rows)


def likelihood_of(recording: UniformRecording, model: DriveModel, sigma: Array,
                  spans: Sequence[slice], coarse: bool = False,
                  finer: int = 1) -> InnovationLikelihood | BalanceLikelihood:
    """Return the likelihood that suits a recording: of its innovations or of its balance."""
    if recording.motor is not None:
        return BalanceLikelihood(recording, model, sigma, spans)
    return InnovationLikelihood(recording, model, sigma, halves(spans), coarse, finer)
