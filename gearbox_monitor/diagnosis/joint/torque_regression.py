# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Regression of the torque: the values of a drive by the balance of its momentum, without a run.

m1 x1'' + m2 x2'' equals the torques on motor and arm, whatever acts between them. All of it is
taken through one low pass, whose derivatives give speed and acceleration (weak form). Values enter
linearly, but for those of some effects, so that a few Gauss-Newton steps suffice.

Speed and acceleration are noisy, which pulls the values of an ordinary regression towards zero.
The noise of the encoders is known, and its share in the normal equations is subtracted (Fuller,
Measurement Error Models, 1987, section 3.1). Deviations are those of the sum over blocks of time,
which holds for a residual of any colour (Liang and Zeger, 1986): what the model lacks counts.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.joint.candidates import CandidateModel
from gearbox_monitor.diagnosis.joint.shooting import Simulator
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import N_MEMORY
from gearbox_monitor.plant.effects.composition import COMMAND_PLACES
from gearbox_monitor.plant.equivalent_torque import imbalance
from gearbox_monitor.plant.simulate import PackedDrive, plugin_of
from gearbox_monitor.signals.smoothed_motion import SmoothedMotion
from gearbox_monitor.signals.uniform import UniformRecording

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
