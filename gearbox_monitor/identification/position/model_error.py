# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Model error of a real drive, where the measured motion of the motor drives the model.

Friction varies with the position and gears are not round, so that the residual torque and twist
persist for tenths of a second. Neighbouring readings then carry little information of their own:
residuals are scaled by the size of the model error and count once per `process_torque_time`.
"""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.kernels.sensor_noise import MAD_TO_SIGMA
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.quality.recording import UniformRecording

SHARE = 0.1      # of torque and twist that lasts unexplained, until a fit tells
LEAST = 0.02     # of torque and twist that it is never below
SLOW = 0.04      # s: means over so long are model error, the rest is noise


def scales(recording: UniformRecording) -> Array:
    """
    Return the standard deviations [2] of torque (N m) and twist (rad) of a driven Recording.

    Args:
        recording: recording of the drive.
    """
    positions = recording.positions
    twist = positions[:, 0] - positions[:, 1]
    size = math.sqrt(np.mean([np.var(twist[part]) for part in recording.segments]))
    return np.maximum([float(np.std(recording.u)), size], 1e-12)


@dataclass(frozen=True)
class Weighing:
    """
    How residuals count: sizes [2] N m and rad of the residual, shares [2] that a reading counts.

    robust: those that are larger count by their size, not by its square. A gap that is crossed
    some milliseconds late is no matter of the twist before and after it.
    """

    sizes: Array
    shares: Array
    robust: bool = True

    def __call__(self, residual: Array, sigma: Array, channels: Sequence[int]) -> Array:
        """Return `residual` [W, L, C] in standard deviations of the noise as it counts."""
        r = residual * (sigma / self.sizes)[channels]
        shares = self.shares[channels]
        if not self.robust:
            return np.sqrt(shares) * r
        return np.copysign(np.sqrt(shares * 2.0 * (np.sqrt(1.0 + r * r) - 1.0)), r)


def weighing(recording: UniformRecording, model: DriveModel, sigma: Array,
             levels: Array | None = None) -> Weighing | None:
    """
    Return how residuals count under the model error of a real drive.

    Args:
        recording: recording of the drive.
        model: model of the drive.
        sigma: noise of the torque, N m, and of the arm encoder, rad [2].
        levels: size of the model error [2], by default that before any fit.

    Returns:
        The Weighing; None if the model has no model error or the torque drives it.
    """
    if recording.motor is None or model.process_torque_time <= 0.0:
        return None
    if levels is None:
        levels = SHARE * scales(recording)
    lasting = np.maximum(levels, LEAST * scales(recording)) ** 2
    white, share = sigma ** 2, min(1.0, recording.dt / model.process_torque_time)
    # What lasts counts once in its time, white noise at each reading.
    return Weighing(np.sqrt(white + lasting),
                    share * (white + lasting) / (share * white + lasting))


def persistent_sizes(residual: Array, moving: Flags, dt: float) -> Array:
    """
    Return the sizes [C] of what lasts in the residual of each encoder, in the residual's unit.

    Args:
        residual: of windows [W, L, C].
        moving: whether a reading counts [W, L, C].
        dt: sample time, s.

    Returns:
        Robust standard deviations of means over SLOW; 0 if too few readings count.
    """
    width = max(1, round(SLOW / dt))
    count = residual.shape[1] // width
    r, counts = (x[:, :count * width].reshape(len(x), count, width, -1)
                 for x in (residual, moving))
    mean = (r * counts).sum(axis=2) / np.maximum(counts.sum(axis=2), 1)
    usable = counts.mean(axis=2) > 0.5
    sizes = np.zeros(residual.shape[2])
    for i in np.flatnonzero(usable.any(axis=(0, 1))):
        # Large ones count in no square: see Weighing.
        sizes[i] = MAD_TO_SIGMA * np.median(np.abs(mean[:, :, i][usable[:, :, i]]))
    return sizes
