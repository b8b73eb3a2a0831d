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
Torque noise on the motor as part of the likelihood: independent triangles of 40 ms in each window.

To first order the residual then has the covariance I + s^2 H H', H the response to each triangle.
On a real drive the residual torque persists: with `process_torque_time` triangles are correlated
by exp(-distance / time), and H stands for H times a Cholesky factor of that. Whitening by the
eigenvectors of H'H (Woodbury identity) equals the innovations likelihood of a linearised Kalman
filter.
"""
from collections.abc import Sequence
import math

import numpy as np

from gearbox_monitor.identification import gauss_newton, likelihood
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.input_estimation import InputEstimator, SPACING
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel

# N m rms per sample that are tried where the torque is some N m; see levels().
LEVELS = (0.0, 0.002, 0.004, 0.007, 0.01, 0.014, 0.02, 0.03, 0.04, 0.055, 0.075, 0.1)
LASTING = np.geomspace(0.003, 0.6, 12)  # of the torque's standard deviation


def levels(model: DriveModel, u: Array) -> tuple[float, ...]:
    """
    Return the levels that are tried for the torque u [N] of a DriveModel.

    Args:
        model: model of the drive.
        u: torque of the motor [N], N m.
    """
    if model.process_torque is not None:
        return (model.process_torque,)
    size = max(float(np.std(u)), 1e-9)
    if model.process_torque_time > SPACING:
        return (0.0, *(size * LASTING))
    scale = 10.0 ** int(math.log10(size))  # 0.1 to 10 N m: as they are
    return tuple(scale * np.array(LEVELS))


class Whitener:
    """
    Whitening of arrays [W, C L, ...] for torque noise.

    level: N m rms per sample; of the torque itself where it lasts.
    """

    def __init__(self, data: likelihood.WindowData, candidate: CandidateModel,
                 point: likelihood.FitPoint) -> None:
        free = InputEstimator(data, candidate.model(point.z), 'motor_side', point)
        count = free.basis.shape[1]
        H = free.sensitivity(np.zeros((len(point.states), count)), point.states,
                             point.residual)[:, :, :count]
        time = candidate.nominal.process_torque_time
        self.samples = SPACING / data.recording.dt if time <= SPACING else 1.0
        if time > SPACING:
            distance = SPACING * np.abs(np.arange(count)[:, None] - np.arange(count))
            H = H @ np.linalg.cholesky(np.exp(-distance / time))
        gram = np.swapaxes(H, 1, 2) @ H
        values, vectors = np.linalg.eigh(gram)
        self.values = np.maximum(values, 1e-12 * max(values.max(), 1e-300))
        self.U = (H @ vectors) / np.sqrt(
            self.values)[:, None, :]
        self.level = 0.0

    def _variance(self, level: float) -> float:
        """Return the variance of a triangle's torque: the mean of so many samples' noise."""
        return level * level / self.samples

    def __call__(self, array: Array) -> Array:
        """Return `array` whitened at the level in force."""
        if self.level == 0.0:
            return array
        f = 1.0 - 1.0 / np.sqrt(1.0 + self._variance(self.level) * self.values)
        flat = array.reshape(*array.shape[:2], -1)
        projection = np.swapaxes(self.U, 1, 2) @ flat
        out = flat - self.U @ (f[:, :, None] * projection)
        return out.reshape(array.shape)

    def deviance(self, level: float, residual: Array, Jx: Array, train: Flags) -> float:
        """
        Return -2 log L (restricted: window states integrated out) of the windows `train`.

        Args:
            level: torque noise, N m rms per sample.
            residual: residual of the windows [W, C L].
            Jx: sensitivity to the window states [W, C L, 4].
            train: windows that count [W].
        """
        self.level = level
        r, J = self(residual)[train], self(Jx)[train]
        A = np.einsum('wli,wlj->wij', J, J) + 1e-9 * np.eye(4)
        g = np.einsum('wli,wl->wi', J, r)
        chi2 = (r ** 2).sum() - np.einsum('wi,wi->', g, np.linalg.solve(A, g[:, :, None])[:, :, 0])
        spread = np.log1p(self._variance(level) * self.values[train]).sum()
        return float(chi2 + spread + np.linalg.slogdet(A)[1].sum())


def noise_weighted_residual(data: likelihood.WindowData,
                            fitted: CandidateFit) -> tuple[Array, Whitener | None]:
    """
    Return (what a search.CandidateFit leaves [W, C L], whitened if it is; its Whitener or None).

    Args:
        data: windows of readings and how residuals are weighted.
        fitted: fit on the long windows.
    """
    if fitted.white is None:
        return fitted.point.residual, None
    whitener = Whitener(data, fitted.candidate, fitted.point)
    whitener.level = fitted.s
    return fitted.white, whitener


def fit_with_process_noise(data: likelihood.WindowData, candidate: CandidateModel,
                           point: likelihood.FitPoint, levels: Sequence[float] = LEVELS,
                           rounds: int = 2) -> tuple[likelihood.FitPoint, float, float, Array]:
    """
    Refit a copy of `point` with torque noise; return (point, deviance, level, whitened residual).

    The level is chosen for each candidate: otherwise the noise of a wrong model is charged to the
    right one. The deviance is -2 log L of the training windows and the prior.

    Args:
        data: windows of readings and how residuals are weighted.
        candidate: model to be fitted, with its coordinates.
        point: where the fit stands: coordinates, window states and memories.
        levels: noise levels that are tried, N m.
        rounds: number of rounds of fit and noise level.
    """
    point = likelihood.copied(point)
    for k in range(rounds + 1):
        whitener = Whitener(data, candidate, point)
        Jx = likelihood.state_sensitivity(data, candidate.model(point.z), point.states,
                                          point.memory, point.residual)
        costs = [whitener.deviance(level, point.residual, Jx, data.train) for level in levels]
        chosen = int(np.argmin(costs))
        whitener.level = levels[chosen]
        if k == rounds or not math.isfinite(costs[chosen]):
            break
        if levels[chosen] == 0.0 and k:
            break
        gauss_newton.fit(data, candidate, point, 3, refresh=(0,), whiten=whitener)
    return (point, costs[chosen] + candidate.penalty(point.z), levels[chosen],
            whitener(point.residual))
