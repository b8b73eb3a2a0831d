# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What all windows of a recording say together: means of their features, or what they lack."""
from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from gearbox_monitor.health.backlash.features import Backlash, NotExcited


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

    fits: of the windows. Where most windows cannot, all those with features count.
    """
    excited = [w for w in fits if isinstance(w, Backlash)]
    clear = [w for w in excited if w.separable]
    separable = 2 * len(clear) > len(excited)
    return (clear if separable else excited), separable


def reason_of(fits: Sequence[NotExcited]) -> str:
    """Return what the motion lacks, of windows `fits`, of which none has features."""
    reasons = [w.reason for w in fits] or ['no window has ended']
    return max(set(reasons), key=reasons.count)
