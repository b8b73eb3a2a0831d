# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Noise of the encoders: level, spectrum above the frequencies of motion, prewhitening."""
import numpy as np
import scipy

from gearbox_monitor.kernels.elementary import noise_levels, white_noise_std
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.uniform import UniformRecording

MOTION = 60.0  # Hz, above which motion has hardly anything
STILL = 0.05   # s, after which a reading that repeats stands still: slower encoders repeat less
LEAST = 1e-8   # of the travel: readings without any noise are no more accurate than the model
FINEST = 1e-4  # of the travel: on a real drive, differences below are no gap


def spectrum(residual: Array, dt: float) -> tuple[Array, Array, Flags]:
    """
    Return (power [W, L, C], frequencies [L] Hz, high [L]) of residuals [W, L, C], dt s apart.

    high: above the frequencies of motion; all of them at low sample rates.

    Args:
        residual: residual [W, L, C], in standard deviations.
        dt: sample time, s.
    """
    length = residual.shape[1]
    power = scipy.fft.dct(residual, axis=1, norm='ortho') ** 2
    at = np.arange(length) * 0.5 / (length * dt)
    return power, at, at > MOTION if at[-1] > 2.0 * MOTION else at >= 0.0


def prewhitened(residual: Array, phi: Array) -> Array:
    """
    Return `residual` [W, L, C] with the noise of the C encoders made white, as large.

    Args:
        residual: residual [W, L, C], in standard deviations.
        phi: correlation of neighbouring readings of each encoder.
    """
    out = residual.copy()
    out[:, 1:] = (residual[:, 1:] - phi * residual[:, :-1]) / np.sqrt(1.0 - phi * phi)
    return out


def variance_over_white(phi: float) -> float:
    """
    Return the variance of coloured noise over that of white noise of the same fourth differences.

    Args:
        phi: correlation of neighbouring readings.
    """
    # Coefficients of the autocorrelation of (1, -4, 6, -4, 1).
    return 70.0 / (70.0 - 112.0 * phi + 56.0 * phi ** 2 - 16.0 * phi ** 3 + 2.0 * phi ** 4)


def noise_floor(recording: UniformRecording, model: DriveModel) -> tuple[Array, Array]:
    """
    Return (sigma [2], quantum [2]) of a Recording, rad; sigma not below what matters.

    Args:
        recording: recording of the drive.
        model: model of the drive; one with lasting process torque is that of a real drive.
    """
    sigma, quantum = noise_levels(recording.y)
    for channel in np.flatnonzero(quantum == 0.0):
        # Noise never repeats: while a reading stands still, nothing is measured.
        y, count = recording.y[:, channel], max(4, round(STILL / recording.dt))
        begins = np.flatnonzero(np.convolve(np.diff(y) != 0.0, np.ones(count), 'valid') == 0.0)
        if len(begins):
            sigma[channel] = white_noise_std(np.delete(y, np.unique(
                begins[:, None] + np.arange(1, count + 1))))
    sigma = np.maximum(sigma, recording.floor)
    sigma = np.maximum(sigma, LEAST * np.ptp(recording.y, axis=0) + 1e-12)
    if model.lasting:
        sigma = np.maximum(sigma, FINEST * np.ptp(recording.y, axis=0))
    return sigma, quantum
