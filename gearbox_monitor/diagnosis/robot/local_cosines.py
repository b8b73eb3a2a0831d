# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Test functions: local cosines, multiplied by a mask that leaves out rest and reversal.

Local cosines with a sine window (Malvar's lapped transform) are orthonormal and zero at both ends:
one per time and frequency. White noise stays white, coloured noise gets one variance per band.
"""
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from gearbox_monitor.diagnosis.robot.motion import RobotMotion
from gearbox_monitor.diagnosis.robot.settings import SETTINGS
from gearbox_monitor.kernels.cosine_basis import cosine_basis, motion_mask
from gearbox_monitor.kernels.types import Array, Integers

COVERED = 0.3  # share of a segment in motion from which its energy counts


@dataclass(frozen=True, eq=False)
class TestFunctions:
    """
    Test functions of one motion, with the masks of its joints.

    value, slope [2 hop, M]: the M functions of a segment and their derivatives, 1/s.
    starts [S]: first sample of each segment; frequency [S M] Hz of each row, band [S M].
    mask, mask_slope [N, J]: 1 where a joint moves, 0 at rest, and its derivative.
    """

    value: Array
    slope: Array
    starts: Integers
    frequency: Array
    band: Integers
    mask: Array
    mask_slope: Array

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.frequency)

    @cached_property
    def share(self) -> Array:
        """Mean square of the mask of each joint [J] in the segments."""
        return self.covered.mean(axis=0)

    @cached_property
    def covered(self) -> Array:
        """Mean square of the mask in each segment [S, J]."""
        return np.stack([self._window @ self.mask[s:s + len(self._window)] ** 2
                         for s in self.starts])

    @cached_property
    def _window(self) -> Array:
        window = self.value[:, 0] ** 2 + self.value[:, 1] ** 2
        return np.asarray(window / window.sum())

    def mean_in_motion(self, x: Array, joint: int) -> Array:
        """Return the mean [S] of `x` [N] over the time of each segment in which `joint` moves."""
        weighted = self.mask[:, joint] ** 2 * x
        total = [self._window @ weighted[s:s + len(self._window)] for s in self.starts]
        return np.array(total) / np.maximum(self.covered[:, joint], 1e-9)

    def _project(self, x: Array, basis: Array) -> Array:
        blocks = np.stack([x[s:s + len(basis)] for s in self.starts])     # S, 2 hop, K
        return np.matmul(basis.T, blocks).reshape(-1, x.shape[1])

    def of(self, x: Array, joint: int) -> Array:
        """Return the integrals [R, K] of phi mu x, `x` [N, K] acting on `joint`."""
        return self._project(x * self.mask[:, joint, None], self.value)

    def of_rate(self, x: Array, joint: int) -> Array:
        """Return the integrals [R, K] of phi mu dx/dt, by parts: `x` is not differentiated."""
        return -self._project(x * self.mask[:, joint, None], self.slope) \
            - self._project(x * self.mask_slope[:, joint, None], self.value)


def local_cosines(motion: RobotMotion, highest: float) -> TestFunctions:
    """Return the test functions of `motion` up to `highest` Hz."""
    step = motion.step
    hop = int(round(SETTINGS.hop / step))
    count = int(min(highest, 0.4 / step) * 2 * hop * step)
    value, slope = cosine_basis(hop, count)
    starts = np.concatenate([np.arange(s.start, s.stop - 2 * hop + 1, hop)
                             for s in motion.sections])
    frequency = np.tile((np.arange(count) + 0.5) / (2 * hop * step), len(starts))
    mask, mask_slope = _masks(motion)
    return TestFunctions(value, slope / step, starts, frequency,
                        np.digitize(frequency, SETTINGS.bands) - 1, mask, mask_slope)


def _masks(motion: RobotMotion) -> tuple[Array, Array]:
    """
    Return the masks [N, J] and their derivatives, 1/s.

    Static friction is any torque up to Coulomb's: no law can be held against it. The mask
    multiplies the test functions, so the weak form stays exact.
    """
    slow = np.maximum(3.0 * motion.sigma_v, SETTINGS.slow)
    width = max(1, int(round(SETTINGS.ramp / motion.step)))
    mask, slope = np.empty_like(motion.v), np.empty_like(motion.v)
    for section in motion.sections:
        for j in range(motion.v.shape[1]):
            mask[section, j] = motion_mask(np.abs(motion.v[section, j]) < slow[j], width)
        # Parts need the derivative itself: along a ramp of 3 samples a difference is too small.
        t = motion.t[section]
        slope[section] = scipy.interpolate.CubicSpline(t, mask[section])(t, 1)
    return mask, slope
