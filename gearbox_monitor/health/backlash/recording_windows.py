# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The features of a recording: one fit per window, and what all windows say together.

A Monitor fits windows as it goes, for its alarms. Here a whole recording is cut into windows, so
that a short one gives features, too, and each window stands alone.
"""
from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.rts_smoother import S_TWIST_NOISE_STD
from gearbox_monitor.health.backlash import features
from gearbox_monitor.health.backlash.features import Backlash, NotExcited
from gearbox_monitor.health.backlash.hidden_arm import HiddenArm
from gearbox_monitor.kernels.types import Array, Integers

SECOND = 1_000_000_000
SETTLE = 2 * SECOND  # ns after the first value that are not used


class RecordingWindows:
    """
    Fits estimates window by window, as they come: smoothed ones, or readings of a motor alone.

    estimator: what estimates. Holds no more than a window and a half and what was added last.
    Raises InputError without a smoother.
    """

    def __init__(self, estimator: Estimator) -> None:
        parameters = estimator.parameters
        self._hidden_arm = None if parameters.arm_joint else HiddenArm(estimator.model)
        if parameters.smoother_lag <= 0.0 and self._hidden_arm is None:
            raise InputError('smoother_lag: 0, expected a number > 0 (s): backlash is measured on '
                             'the smoothed torque')
        self.model = estimator.drive
        self.length = round(parameters.drift_window * SECOND)
        # A twist known worse than by one reading of both encoders: one of them was missing.
        self._known = np.hypot(parameters.r_std_motor, parameters.r_std_arm)
        self._begin = 0
        self._last: int | None = None
        self._parts: list[tuple[Integers, Array]] = []
        self._fits: list[Backlash | NotExcited] = []

    def add(self, estimates: Estimates) -> None:
        """Take `estimates` that follow those before."""
        if self._hidden_arm is None:
            stamps, rows = estimates.smoothed_stamp_ns, estimates.smoothed
        else:
            stamps, rows = estimates.stamp_ns, self._hidden_arm.columns(estimates.rows)
        backwards = np.flatnonzero(np.diff(stamps) < 0) + 1
        for t, part in zip(np.split(stamps, backwards), np.split(rows, backwards)):
            if len(t):
                self._add(t, part)

    def _add(self, stamps: Integers, rows: Array) -> None:
        if self._last is None:
            self._begin = int(stamps[0]) + SETTLE
        elif stamps[0] < self._last:  # the clock was set back: restart
            self._end()
            self._begin = int(stamps[0])
        self._last = int(stamps[-1])
        keep = stamps >= self._begin
        if self._hidden_arm is None:
            keep &= rows[:, S_TWIST_NOISE_STD] <= self._known
        if keep.any():
            self._parts.append((stamps[keep], rows[keep]))
        while self._parts and self._parts[-1][0][-1] >= self._begin + 3 * self.length // 2:
            self._cut()

    def _cut(self) -> None:
        """Fit the first window of what is held."""
        stamps, rows = self._joined()
        end = int(np.searchsorted(stamps, self._begin + self.length))
        if end:
            self._fit(stamps[:end], rows[:end])
            self._parts = [(stamps[end:], rows[end:])]
            self._begin += self.length
        else:  # nothing was measured for that long
            self._begin = int(stamps[0])

    def _joined(self) -> tuple[Integers, Array]:
        if len(self._parts) > 1:
            stamps, rows = zip(*self._parts)
            self._parts = [(np.concatenate(stamps), np.concatenate(rows))]
        return self._parts[0]

    def _fit(self, stamps: Integers, rows: Array) -> None:
        if self._hidden_arm is not None:
            self._fits.append(self._hidden_arm.fit(stamps, rows, int(stamps[-1])))
            return
        fitted = features.fit(rows, self.model, int(stamps[-1]))
        if isinstance(fitted, NotExcited) and features.shows_motion(rows):
            lost_motion, std = features.lost_motion_of(rows)
            fitted = replace(fitted, lost_motion=lost_motion, lost_motion_std=std)
        self._fits.append(fitted)

    def _end(self) -> None:
        """Fit the last samples if they are half a window, or the only ones."""
        if self._parts:
            stamps, rows = self._joined()
            if not self._fits or stamps[-1] - self._begin >= self.length // 2:
                self._fit(stamps, rows)
        self._parts = []

    def finish(self) -> list[Backlash | NotExcited]:
        """Return all fits, a list of features.Backlash and features.NotExcited."""
        self._end()
        return self._fits


@dataclass(frozen=True)
class Combined:
    """Value and standard deviation of a feature over all windows."""

    value: float
    std: float


def combine(fits: Sequence[Backlash | NotExcited], name: str, relative: float = 0.0
            ) -> Combined | None:
    """
    Return a feature over all windows.

    Args:
        fits: of the windows.
        name: of the feature, a field of Backlash.
        relative: deviation of the method itself, which averaging does not remove.

    Returns:
        The mean with its standard deviation; None without a finite value.

    """
    pairs = np.array([(getattr(w, name), getattr(w, name + '_std')) for w in fits])
    pairs = pairs[np.isfinite(pairs).all(axis=1)] if len(pairs) else pairs
    if not len(pairs):
        return None
    value, n = float(pairs[:, 0].mean()), len(pairs)
    variance = float((pairs[:, 1] ** 2).mean())
    if n > 1:
        variance = max(variance, float(pairs[:, 0].var(ddof=1)))
    return Combined(value, math.hypot(math.sqrt(variance / n), relative * value))


def separable_of(fits: Sequence[Backlash]) -> tuple[list[Backlash], bool]:
    """
    Return (windows that count, whether they tell gap and compliance apart).

    fits: what RecordingWindows gave. Where most windows cannot, all those with features count.
    """
    excited = [w for w in fits if isinstance(w, features.Backlash)]
    clear = [w for w in excited if w.separable]
    separable = 2 * len(clear) > len(excited)
    return (clear if separable else excited), separable


def reason_of(fits: Sequence[NotExcited]) -> str:
    """Return what the motion lacks, of windows `fits`, of which none has features."""
    reasons = [w.reason for w in fits] or ['no estimates after the first seconds']
    return max(set(reasons), key=reasons.count)
