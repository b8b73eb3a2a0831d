# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash and stiffness of a lost-motion test: the input is locked, a torque turns the output.

No drive moves, so no filter is asked: the torque that is measured at the output, or that holds the
input, stands over the twist as

    torque = K dz(twist - zero, gap / 2) + F direction

by least squares, F what the bearings of the output brake. Each to and fro is a window of its own.
"""
from collections.abc import Sequence
import math

import numpy as np
import scipy

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.types import Array

LEAST = 200        # samples of a test
MAX_POINTS = 4000
STARTS = (0.05, 0.15, 0.3, 0.45)  # half gaps over the twist's swing


def is_locked(samples: Samples) -> bool:
    """Return whether the input of `samples` stands still while the output turns."""
    y = samples.y[np.isfinite(samples.y).all(axis=1)]
    if len(y) < LEAST:
        return False
    sigma, quantum = noise_levels(y)
    motor, arm = np.ptp(y, axis=0)
    return bool(motor <= LIMITS.locked_share * arm
                and motor <= LIMITS.locked_still * sigma[0] + 2.0 * quantum[0] + 1e-12
                and arm > LIMITS.locked_turned * sigma[1] + 2.0 * quantum[1])


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
    x, y, d = twist[rows], torque[rows], direction[rows]
    span, middle = float(np.ptp(x)), 0.5 * float(x.max() + x.min())
    scale = float(np.std(y)) + 1e-300

    def columns(shape: Sequence[float]) -> Array:
        """Return the columns of stiffness, friction and offset for (half gap, zero)."""
        dead = x - shape[1] - np.clip(x - shape[1], -shape[0], shape[0])
        return np.column_stack([dead, d, np.ones(len(x))])

    def remainder(shape: Sequence[float]) -> Array:
        table = columns(shape)
        return np.asarray(y - table @ np.linalg.lstsq(table, y, rcond=None)[0]) / scale
    shapes: list[tuple[float, Array]] = []
    for share in STARTS:
        fitted = scipy.optimize.least_squares(
            remainder, (share * span, middle), x_scale=span, loss='soft_l1', f_scale=0.1,
            bounds=((0.0, x.min()), (0.5 * span, x.max())))
        shapes.append((float(fitted.cost), fitted.x))
    half_gap, zero = min(shapes, key=lambda shape: shape[0])[1]
    table = columns((half_gap, zero))
    stiffness, friction, offset = np.linalg.lstsq(table, y, rcond=None)[0]
    side = np.sign(x - zero) * (np.abs(x - zero) > half_gap)
    flank = float(min((side > 0).mean(), (side < 0).mean()))
    if flank < 0.02 or not stiffness > 0.0:
        return NotExcited(stamp_ns, 'locked_flank')
    # Residuals of neighbouring samples are alike: only so many count.
    residual = y - table @ [stiffness, friction, offset]
    correlation = np.corrcoef(residual[1:], residual[:-1])[0, 1]
    inflation = (1.0 + max(correlation, 0.0)) / max(1.0 - max(correlation, 0.0), 0.01)
    on = side != 0
    slopes = np.column_stack([table, -stiffness * side, -stiffness * on])
    covariance = np.linalg.pinv(slopes.T @ slopes) * float(np.mean(residual ** 2)) * inflation
    stds = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    up, down = x[d > 0.5], x[d < -0.5]
    lost_motion = abs(float(np.median(up)) - float(np.median(down))) if (
        len(up) and len(down)) else math.nan
    return Backlash(
        stamp_ns, 2.0 * float(half_gap), 2.0 * float(stds[3]), float(stiffness), float(stds[0]),
        zero=float(zero), flank=flank, coverage=float(np.count_nonzero(np.diff(side[on]))),
        coulomb=float(abs(friction)), coulomb_std=float(stds[1]),
        lost_motion=lost_motion, lost_motion_std=2.0 * float(stds[3]))
