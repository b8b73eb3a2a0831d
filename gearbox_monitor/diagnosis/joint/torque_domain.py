# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The balance of a drive's momentum: a likelihood, and values without a run.

The likelihood is that of recordings whose measured motor motion drives the model (`driven_by:
position`).

Their likelihood is the balance of torques in weak form.

By the same balance the values of any drive follow without a run: m1 x1'' + m2 x2'' equals the
torques on motor and arm, whatever acts between them. All of it is taken through one low pass,
whose derivatives give speed and acceleration. Values enter linearly, but for those of some
effects, so that a few Gauss-Newton steps suffice.

Speed and acceleration are noisy, which pulls the values of an ordinary regression towards zero.
The noise of the encoders is known, and its share in the normal equations is subtracted (Fuller,
Measurement Error Models, 1987, section 3.1). Deviations are those of the sum over blocks of time,
which holds for a residual of any colour (Liang and Zeger, 1986): what the model lacks counts.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel
from gearbox_monitor.diagnosis.joint.innovations import halves, InnovationLikelihood, named_motion
from gearbox_monitor.diagnosis.joint.shooting import ShootingWindows, Simulator
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.linear_least_squares import cosine_basis, motion_mask
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import N_MEMORY
from gearbox_monitor.plant.effects.composition import COMMAND_PLACES
from gearbox_monitor.plant.simulate import (
    gains, imbalance, imbalance_with, N_STATE, packed_drive, PackedDrive, plugin_of, true_motion)
from gearbox_monitor.signals.uniform import SmoothedMotion, UniformRecording

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


STEPS = 8        # of Gauss-Newton, at most
SETTLED = 1e-4   # deviations by which the last one moves a value
BLOCK = 0.5      # s, of a block at least: unexplained torque lasts about 0.3 s on real drives
BLOCKS = 40      # in a recording at most
LEAST_SHARE = 0.5  # of the normal matrix that its noise leaves at least
WIDTH = 0.6      # of half the low pass: two deviations of its kernel
INPUT_GAINS = ('kp', 'kt')  # torque of a servo over its setpoint
P1, P2, V1, V2, A1, A2 = range(6)  # columns of a motion


@dataclass(frozen=True)
class TorqueRegression:
    """
    Values by the balance of momentum, in the coordinates of a candidate.

    z [P]; covariance [P, P] of it; before, after: rms of the torque that is left with the values
    of the model file and with these, N m, each after its mean over a block is taken out of chance.
    """

    z: Array
    covariance: Array
    before: float
    after: float


@dataclass(frozen=True)
class _Rows:
    """
    Rows of a regression: what moved, and how it is known.

    t [M] s; motion [M, 6]; noise [6, 6] covariance of a row of it; parts: Simulator and
    SmoothedMotion of each recording; block [M] of time; width of the low pass, s;
    extra [M, 3]: torques from outside; torques: those of the actuator so far, N m.
    """

    t: Array
    motion: Array
    noise: Array
    parts: Sequence[tuple[Simulator, SmoothedMotion]]
    block: Integers
    width: float
    extra: Array
    torques: dict[Any, Array] = field(default_factory=dict)

    @property
    def sizes(self) -> Array:
        """Uncertainty [6, M] of the motion: its noise, and how far a speed changes in a window."""
        out = np.repeat(np.sqrt(np.diag(self.noise))[:, None], len(self.t), axis=1)
        for speed, acceleration in ((V1, A1), (V2, A2)):
            out[speed] = np.hypot(out[speed], self.width * self.motion[:, acceleration])
        return np.maximum(out, 1e-12)

    def imbalance(self, model: DriveModel, moved: Array | None = None) -> Array:
        """Return the torque [M] (N m) that `model` does not explain, of a `moved` motion."""
        e, (_, theta) = model.pack_effects(), plugin_of(model)
        key = tuple(e[COMMAND_PLACES])
        if key not in self.torques:
            self.torques[key] = np.concatenate([
                smooth.filtered(_at_stamps(simulator.acting(e).mean(axis=1)))
                for simulator, smooth in self.parts])
        out = np.empty((len(self.t), 2))
        imbalance((self.t, self.motion if moved is None else moved), 0.0, (0.0, 0.0),
                  self.torques[key],
                  self.extra, PackedDrive(model.pack(), e, theta), np.zeros(4 + N_MEMORY), out)
        return out[:, 0]

    def columns(self, candidate: CandidateModel, z: Array, moved: Array | None = None) -> Array:
        """Return (derivatives by z, imbalance itself) [M, P + 1] of the candidate at `z`."""
        out = np.empty((len(self.t), len(z) + 1))
        for i, step in enumerate(candidate.steps()):
            ends = []
            for sign in (-1.0, 1.0):
                at = z.copy()
                at[i] += sign * step
                ends.append(self.imbalance(candidate.model(at), moved))
            out[:, i] = (ends[1] - ends[0]) / (2.0 * step)
        out[:, -1] = self.imbalance(candidate.model(z), moved)
        if candidate.nominal.controller is not None:
            # Counted in setpoint: smaller values throughout leave less torque, but no less motion.
            gains = [i for i, c in enumerate(candidate.coordinates) if c.name in INPUT_GAINS]
            out[:, gains] -= out[:, -1:]
        return out


def _at_stamps(torque: Array) -> Array:
    """Return the mean torque [N] about each stamp, of the `torque` [N] held from each stamp on."""
    return np.asarray(0.5 * (torque + np.append(torque[:1], torque[:-1])))


def _rows(recordings: Sequence[UniformRecording], model: DriveModel) -> _Rows:
    """Return the _Rows of recordings, each by itself."""
    sigma, _ = noise_levels(np.concatenate([r.positions for r in recordings]))
    parts, motion, times, block, first = [], [], [], [], 0
    noise = np.zeros((6, 6))
    for recording in recordings:
        part = replace(recording, y=recording.positions, motor=None, servo_torque=None)
        smooth = SmoothedMotion(part, sigma)
        parts.append((Simulator(part, model), smooth))
        motion.append(np.column_stack([smooth.p, smooth.v, smooth.a]))
        times.append(part.t[smooth.k] - part.t[0])
        length = max(BLOCK, 4.0 * smooth.half_width, len(part.u) * part.dt / BLOCKS)
        block.append(first + (times[-1] / length).astype(int))
        first = int(block[-1].max()) + 1
        kernels = np.array(smooth.kernels)  # of position, speed, acceleration
        # Of the other encoder, where there is one: of its copy, no less.
        own = kernels @ kernels.T
        own_noise = np.zeros((6, 6))
        for channel in (0, 1):
            index = np.array([P1, V1, A1]) + channel
            own_noise[np.ix_(index, index)] = sigma[channel] ** 2 * own
        if len(recording.channels) == 1:
            own_noise[:] = np.kron(sigma[recording.channels[0]] ** 2 * own, np.ones((2, 2)))
        noise += own_noise / len(recordings)
    return _Rows(np.concatenate(times), np.concatenate(motion), noise, parts,
                 np.concatenate(block), max(WIDTH * smooth.half_width for _, smooth in parts),
                 np.concatenate([np.column_stack([smooth.filtered(c) for c in simulator.extra.T])
                                 for simulator, smooth in parts]))


def torque_regression(recordings: Sequence[UniformRecording],
                      candidate: CandidateModel) -> TorqueRegression | None:
    """
    Return the values of a candidate by the balance of momentum; None where it does not tell.

    What acts between motor and arm stays where it is. The torque of a servo follows from setpoint
    and motion, unless it has a memory: then there is no regression, nor of a drive with a plug-in.

    Args:
        recordings: of one drive.
        candidate: model to be fitted, with its coordinates.
    """
    model = candidate.nominal
    servo = model.controller
    if plugin_of(model)[0] or servo and (servo.ki or servo.delay or servo.rate):
        return None
    rows = _rows(recordings, model)
    z = candidate.start()
    at_start = rows.imbalance(candidate.model(z))
    weight: Array = np.ones(len(at_start))
    result: Array = np.zeros((len(z), len(z)))
    for _ in range(STEPS):
        step = _step(rows, candidate, z, weight)
        if step is None:
            return None
        change, covariance, weight = step
        if not np.isfinite(change).all():
            return None
        z = candidate.bounded(z + change)
        result = covariance
        if (np.abs(change) <= SETTLED * np.sqrt(np.diag(covariance))).all():
            break
    at_end = rows.imbalance(candidate.model(z))
    return TorqueRegression(z, result, *(
        float(np.sqrt(np.average(r * r, weights=weight))) for r in (at_start, at_end)))


def _step(rows: _Rows, candidate: CandidateModel, z: Array,
          weight: Array) -> tuple[Array, Array, Array] | None:
    """
    Return (step [P], covariance [P, P] at its end, weights [M] of the next) of the regression.

    Args:
        rows: of the regression.
        candidate: model with its coordinates.
        z: coordinates [P].
        weight: of the rows [M].
    """
    count = len(z)
    full = rows.columns(candidate, z)
    X, r = full[:, :count], full[:, count]
    # How rows depend on the motion, by secants as wide as it is uncertain.
    slopes = np.zeros((6, *full.shape))
    for i, size in enumerate(rows.sizes):
        ends = []
        for sign in (-1.0, 1.0):
            moved = rows.motion.copy()
            moved[:, i] += sign * size
            ends.append(rows.columns(candidate, z, moved))
        slopes[i] = (ends[1] - ends[0]) / (2.0 * size[:, None])
    noise = np.einsum('ij,ikp,jkq,k->pq', rows.noise, slopes, slopes, weight, optimize=True)
    spread = ((slopes[:, :, count] * rows.sizes) ** 2)[[V1, V2]].sum(axis=0)
    A = (X * weight[:, None]).T @ X
    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-300))
    share = np.linalg.eigvals(np.linalg.lstsq(A * np.outer(scale, scale), noise[:count, :count] * (
        np.outer(scale, scale)), rcond=1e-10)[0]).real.max(initial=0.0)
    noise *= min(1.0, LEAST_SHARE / max(share, 1e-300))
    A = A - noise[:count, :count]
    g = X.T @ (weight * r) - noise[:count, count]
    # Neighbouring rows say the same: as many as blocks count.
    scores = np.zeros((int(rows.block.max()) + 1, count))
    np.add.at(scores, rows.block, X * (weight * r)[:, None])
    scores = scores[np.bincount(rows.block) > 0]
    blocks = len(scores)
    if blocks <= count + 1:
        return None
    scores -= scores.mean(axis=0)
    meat = scores.T @ scores * (blocks / (blocks - count - 1))
    pull, prior = candidate.prior(z)
    # A prior counts as a block of rows with the torque that is left.
    unit = float((weight * r * r).sum()) / blocks
    H = A + unit * np.diag(prior)
    try:
        inverse = np.linalg.inv(H * np.outer(scale, scale)) * np.outer(scale, scale)
    except np.linalg.LinAlgError:
        return None
    change = -inverse @ (g + unit * pull)
    covariance = inverse @ (meat + unit * unit * np.diag(prior)) @ inverse
    # A row whose friction hangs on a speed of the size of its noise says little.
    level = max(float(np.median(r * r)) / 0.455, 1e-300)
    return change, covariance, level / (level + spread)
