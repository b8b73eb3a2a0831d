# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash and stiffness of a lost-motion test: the input is locked, a torque turns the output.

No drive moves, so no filter is asked: the torque that is measured at the output, or that holds the
input, depends on the twist as

    torque = K dz(twist - zero, gap / 2) + F direction

by robust least squares, F what the bearings of the output brake. Each to and fro is one window.
"""
import math

import numpy as np
import scipy

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.features import (
    Backlash, fit_all, NotExcited, regression_of, sides_of, start_of, visits_of)
from gearbox_monitor.health.elastic_regression import (
    COULOMB, D_FRICTION, D_TORQUE, D_TWIST, D_U, HALF_GAP, N_DATA, N_SHAPE, STIFFNESS, ZERO)
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.types import Array

LEAST = 200        # samples of a test
MAX_POINTS = 4000


def is_locked(samples: Samples) -> bool:
    """Return whether the input of `samples` stands still while the output turns."""
    y = samples.y[np.isfinite(samples.y).all(axis=1)]
    if len(y) < LEAST:
        return False
    sigma, quantum = noise_levels(y)
    motor, arm = np.ptp(y, axis=0)
    return bool(motor <= LIMITS.locked_share * arm
                and motor <= LIMITS.locked_noise * sigma[0] + 2.0 * quantum[0] + 1e-12
                and arm > LIMITS.locked_noise * sigma[1] + 2.0 * quantum[1])


def locked_windows(samples: Samples) -> list[Backlash | NotExcited]:
    """
    Return the features of a lost-motion test.

    Args:
        samples: of a drive whose input is locked, on the arm side.
    """
    last = int(samples.stamp_ns[-1])
    torque = _torque(samples)
    if torque is None:
        return [NotExcited(last, 'locked')]
    good = np.isfinite(samples.y).all(axis=1) & np.isfinite(torque)
    t = (samples.stamp_ns[good] - samples.stamp_ns[good][0]) * 1e-9
    twist, torque = samples.y[good, 0] - samples.y[good, 1], torque[good]
    # The direction: of the twist without its noise, over a fiftieth of the test.
    width = max(3, len(t) // 50)
    smooth = scipy.ndimage.uniform_filter1d(twist, width)
    rate = np.gradient(smooth, t)
    direction = np.tanh(3.0 * rate / max(float(np.sqrt(np.mean(rate ** 2))), 1e-300))
    # Noise of the twist on both sides of the slope would flatten it.
    twist = scipy.ndimage.uniform_filter1d(twist, max(1, width // 10))
    fits: list[Backlash | NotExcited] = []
    for part in _strokes(smooth):
        fits.append(_fit(twist[part], torque[part], direction[part],
                         int(samples.stamp_ns[good][part][-1])))
    return fits or [NotExcited(last, 'locked_flank')]


def _torque(samples: Samples) -> Array | None:
    """Return the torque [N] that the gearbox transmits, None where none is measured."""
    arm, motor = -samples.u[:, 1], samples.u[:, 0]
    for torque in (arm, motor):
        if np.isfinite(torque).any() and np.nanstd(torque) > 0.0:
            return torque
    return None


def _strokes(twist: Array) -> list[slice]:
    """Return the parts of a smooth `twist` [N] that go from one side to the other and back."""
    low, high = np.percentile(twist, (2, 98))
    middle, side = 0.5 * (low + high), 0.35 * (high - low)
    reached = np.sign(twist - middle) * (np.abs(twist - middle) > side)
    at = np.flatnonzero(reached)
    ends = at[1:][np.diff(reached[at]) != 0]
    if len(ends) < 2:
        return [slice(0, len(twist))] if len(ends) else []
    edges = [0, *ends[2::2].tolist(), len(twist)]
    if len(edges) > 2 and edges[-1] - edges[-2] < 0.5 * (edges[1] - edges[0]):
        del edges[-2]
    return [slice(a, b) for a, b in zip(edges, edges[1:])]


def _fit(twist: Array, torque: Array, direction: Array, stamp_ns: int) -> Backlash | NotExcited:
    """Return the features of one to and fro [N]."""
    rows = slice(None, None, max(1, len(twist) // MAX_POINTS))
    x, d = twist[rows], direction[rows]
    data = np.zeros((len(x), N_DATA))
    data[:, D_TWIST], data[:, D_FRICTION], data[:, D_TORQUE] = x, d, torque[rows]
    data[:, D_U] = 1.0  # its gain is an offset of the torque
    fitted = fit_all(regression_of(data, 1, np.ones(len(x))), *start_of(data),
                     np.full(N_SHAPE, np.inf), loop=False)
    theta, std = fitted.theta, np.sqrt(np.maximum(np.diag(fitted.covariance), 0.0))
    side = sides_of(x - theta[ZERO], theta[HALF_GAP])
    flank, traversals = visits_of(side)
    if flank < LIMITS.flank or not theta[STIFFNESS] > 0.0:
        return NotExcited(stamp_ns, 'locked_flank')
    up, down = x[d > 0.5], x[d < -0.5]
    lost_motion = abs(float(np.median(up)) - float(np.median(down))) if (
        len(up) and len(down)) else math.nan
    gap_std = 2.0 * float(std[HALF_GAP])
    return Backlash(
        stamp_ns, 2.0 * float(theta[HALF_GAP]), gap_std, float(theta[STIFFNESS]),
        float(std[STIFFNESS]), zero=float(theta[ZERO]), flank=flank,
        coverage=float(traversals),
        coulomb=float(abs(theta[COULOMB])), coulomb_std=float(std[COULOMB]),
        lost_motion=lost_motion, lost_motion_std=gap_std)
