# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Torque noise on the motor as part of the likelihood: independent triangles of 40 ms in each window.

To first order the residual then has the covariance I + s^2 H H', H the response to each triangle.
On a real drive the residual torque persists: with `process_torque_time` triangles are correlated
by exp(-distance / time), and H stands for H times a Cholesky factor of that. Whitening by the
eigenvectors of H'H (Woodbury identity) equals the innovations likelihood of a linearised Kalman
filter.
"""
import numpy as np

from gearbox_monitor.identification import likelihood
from gearbox_monitor.identification.candidates import CandidateModel
from gearbox_monitor.identification.input_estimation import InputEstimator, SPACING
from gearbox_monitor.identification.likelihood import CandidateFit
from gearbox_monitor.kernels.types import Array


class Whitener:
    """
    Whitening of arrays [W, C L, ...] for torque noise.

    level: N m rms per sample; of the torque itself where it lasts.
    """

    def __init__(self, data: likelihood.WindowData, candidate: CandidateModel,
                 point: likelihood.FitPoint, level: float) -> None:
        free = InputEstimator(data, candidate.model(point.z), 'motor_side', point)
        count = free.basis.shape[1]
        H = free.sensitivity(np.zeros((len(point.states), count)), point.states,
                             point.residual)[:, :, :count]
        time = candidate.nominal.process_torque_time
        samples = SPACING / data.recording.dt if time <= SPACING else 1.0
        if time > SPACING:
            distance = SPACING * np.abs(np.arange(count)[:, None] - np.arange(count))
            H = H @ np.linalg.cholesky(np.exp(-distance / time))
        gram = np.swapaxes(H, 1, 2) @ H
        values, vectors = np.linalg.eigh(gram)
        self.values = np.maximum(values, 1e-12 * max(values.max(), 1e-300))
        self.U = (H @ vectors) / np.sqrt(
            self.values)[:, None, :]
        # Of a triangle's torque: the mean of so many samples' noise.
        self.variance = level * level / samples

    def __call__(self, array: Array) -> Array:
        """Return `array` whitened."""
        if self.variance == 0.0:
            return array
        f = 1.0 - 1.0 / np.sqrt(1.0 + self.variance * self.values)
        flat = array.reshape(*array.shape[:2], -1)
        projection = np.swapaxes(self.U, 1, 2) @ flat
        out = flat - self.U @ (f[:, :, None] * projection)
        return out.reshape(array.shape)


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
    return fitted.white, Whitener(data, fitted.candidate, fitted.point, fitted.s)
