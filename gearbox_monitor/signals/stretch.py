# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The longest part of a recording without a dropout, on an even grid of time."""
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.stamps import StampClock


@dataclass(frozen=True)
class EvenStretch:
    """
    Samples [N] `dt` s apart, on the arm side.

    begin, end (s): where in the recording; u [N] N m or None, where most are not known; y [N, 2]
    rad; measured: (motor, arm), whether there are readings; an encoder without any is NaN.
    """

    begin: float
    end: float
    dt: float
    u: Array | None
    y: Array
    measured: tuple[bool, ...]

    @property
    def duration(self) -> float:
        """Length, s."""
        return self.end - self.begin

    def first(self, seconds: float) -> 'EvenStretch':
        """Return the Stretch of its first `seconds` s, itself where it is not longer."""
        n = int(seconds / self.dt)
        if n >= len(self.y):
            return self
        return replace(self, end=self.begin + n * self.dt, y=self.y[:n],
                       u=None if self.u is None else self.u[:n])


def stretch(clock: StampClock, u: Array, y: Array) -> EvenStretch:
    """
    Return the Stretch of a recording.

    found: Clock of its stamps; u [N] N m, y [N, 2] rad as recorded, NaN: not measured.

    Args:
        clock: usable stamps.
        u: torque as recorded [N], N m; NaN: not measured.
        y: readings as recorded [N, 2], rad; NaN: not measured.
    """
    t, u, y = clock.seconds, u[clock.usable], y[clock.usable]
    edges = np.union1d(np.flatnonzero(np.diff(t) > LIMITS.cut * clock.period) + 1,
                       np.array(clock.restarts, int))
    starts, ends = np.append(0, edges), np.append(edges, len(t))
    longest = int(np.argmax(t[ends - 1] - t[starts]))
    keep = slice(starts[longest], ends[longest])
    t, u, y = t[keep], u[keep], y[keep]
    even = clock.jitter < LIMITS.quiet_jitter * clock.period and len(t) == round(
        (t[-1] - t[0]) / clock.period) + 1
    grid = t if even else np.arange(t[0], t[-1], clock.period)

    def on_grid(value: Array, smallest_share: float, hold: bool = False) -> Array | None:
        """
        Return a channel on the grid, None if too little of it was measured.

        Args:
            value: recorded values [N].
            smallest_share: smallest share of finite values.
            hold: whether values are held instead of interpolated.
        """
        good = np.isfinite(value)
        if good.mean() < smallest_share:
            return None
        if even and good.all():
            return value
        if hold:
            last = np.searchsorted(t[good], grid + 0.5 * clock.period, 'right') - 1
            return value[good][np.maximum(last, 0)]
        return np.interp(grid, t[good], value[good])
    channels = [on_grid(channel, LIMITS.known_readings) for channel in y.T]
    none = np.full(len(grid), np.nan)
    return EvenStretch(float(t[0]), float(t[-1]), clock.period,
                   on_grid(u, LIMITS.known_torques, hold=True),
                   np.column_stack([none if c is None else c for c in channels]),
                   tuple(c is not None for c in channels))
