# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A slip of clutch or hub in a recording: both ends of the twist move by the same angle."""
from dataclasses import replace

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import said
from gearbox_monitor.signals.finding import BAD, DataFinding, hurts, judged, WARN
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.uniform import UniformRecording


def without_slip(part: UniformRecording) -> tuple[UniformRecording, list[DataFinding]]:
    """
    Return a recording whose motor is counted on over a slip, and the finding about it, if any.

    Motion and load must be alike before and after: the range of the twist keeps its width, and
    moves by more than a change of the mean torque can twist the drive.
    """
    n = round(LIMITS.slip_window / part.dt)
    count = len(part.y) // max(n, 1)
    if len(part.channels) < 2 or count < 5 or np.isnan(part.torque).any():
        return part, []
    twist = part.y[:, 0] - part.y[:, 1]
    ends = np.percentile(twist[:count * n].reshape(count, n), LIMITS.slip_ends, axis=1)
    middle, width = ends.mean(axis=0), np.diff(ends, axis=0)[0]
    torque = part.torque[:count * n].reshape(count, n).mean(axis=1)
    # From the windows before k to those after it: the slip is in window k, or where it begins.
    steps = [float(np.median(middle[k + 1:]) - np.median(middle[:k])) for k in range(2, count - 2)]
    k = 2 + int(np.argmax(np.abs(steps)))
    size, sides = steps[k - 2], (slice(0, k), slice(k + 1, count))
    usual = float(np.median(width))
    scatter = max(float(np.abs(middle[s] - np.median(middle[s])).max()) for s in sides)
    loads, widths = (np.diff([float(np.median(v[s])) for s in sides])[0] for v in (torque, width))
    doubt = LIMITS.slip_scatter * scatter + LIMITS.slip_room * usual + LIMITS.slip_load * (
        usual * abs(loads) / max(float(np.ptp(part.torque)), 1e-300))
    if not abs(size) > max(doubt, LIMITS.slip_widened * abs(widths)):
        return part, []
    row = _row(twist, size, ends, k, n)
    y = part.y.copy()
    y[row:, 0] -= size
    seconds = part.begin + row * part.dt
    return replace(part, y=y, slip=(float(part.t[row]), size)), [judged(
        'motion', 'slip', said('drive_slips', size=size, at=seconds),
        hurts(WARN, WARN, BAD if scatter > 0.5 * abs(size) else WARN),
        {'slip_rad': size, 'slip_s': seconds})]


def _row(twist: Array, size: float, ends: Array, k: int, n: int) -> int:
    """
    Return the row of the slip: without it, the twist stays between its earlier ends.

    Args:
        twist: [N], rad.
        size: of the slip, rad.
        ends: lower and upper one of each window [2, W], rad.
        k: window in which it slips, or where this window begins.
        n: rows of a window.

    """
    low, high = np.median(ends[:, :k], axis=1)
    rows = slice((k - 1) * n, (k + 1) * n)

    def beyond(x: Array) -> Array:
        return np.maximum(x - high, 0.0) + np.maximum(low - x, 0.0)
    before = np.append(0.0, np.cumsum(beyond(twist[rows])))
    after = np.append(0.0, np.cumsum(beyond(twist[rows] - size)))
    cost = before + after[-1] - after
    best = np.flatnonzero(cost <= cost.min() + 1e-12)
    return int(rows.start + best[len(best) // 2])
