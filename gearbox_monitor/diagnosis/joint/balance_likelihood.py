# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The likelihood of a recording whose motion is put in: the balance of torques in weak form.

One joint is a chain of one link, with a second balance where a second encoder is: the torque that
the twist transmits against the load of the arm. Both are taken through local cosines with a mask
at rest, where friction takes any value. Each band of frequencies has a variance of its own, that
which the model leaves (Whittle); none is less than the sensors' noise.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.diagnosis.joint.innovations import halves, InnovationLikelihood, named_motion
from gearbox_monitor.diagnosis.joint.torque_domain import BalanceSimulator
from gearbox_monitor.kernels.cosine_basis import cosine_basis, motion_mask
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.simulate import N_STATE
from gearbox_monitor.signals.recording import UniformRecording

# Tests of 1 s: a held-out part is short. Few bands: a short recording would fit each.
HOP, BANDS = 0.5, (0.0, 2.0, 5.0, 10.0)  # s; Hz
SLOW, RAMP = 0.02, 0.06  # rad/s, below which friction is any torque; s about it


@dataclass(frozen=True, eq=False)
class Balanced:
    """
    The balance under a model.

    innovation, variance [R, 2]: rows of the balances of the drive, N m, and of the twist, rad,
    and their variances; read [R, 2]: whether a row counts; deviance: -2 log L; left [2]: rms of
    the residuals, N m and rad; readings: number of rows that count.
    """

    innovation: Array
    variance: Array
    read: Flags
    deviance: float
    left: Array
    readings: int

    @property
    def gap(self) -> float:
        """
        Geometric mean of what each band of each balance leaves.

        Of two models, it has the ratio that the rms residuals of runs would have.
        """
        return math.exp(0.5 * self.deviance / self.readings)

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
        return Balanced(r, variance, self.read, deviance, left, self.readings)

    def change(self, run: Balanced, model: DriveModel) -> Array:
        """Return the change [R, 2] (N m) of the rows of `run` when the model is `model`."""
        return np.where(self.read, self._rows(model) - run.innovation, 0.0)

    def with_noise(self, run: Balanced, torque: Array) -> tuple[float, Array, Array]:
        """Return (-2 log L, rows, their variance) of `run`: `torque` counts for nothing."""
        return run.deviance, run.innovation, run.variance

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
