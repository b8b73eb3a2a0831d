# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Threshold of the sequential test for a step: generalised likelihood ratio over the change point.

After each window every stretch of the newest 1 .. `horizon` windows is compared with what lies
before it (wear.scan). With one threshold this finds jumps as fast as a CUSUM tuned to them and
slow ramps as well, and needs no size of the change to be chosen beforehand.
"""
import functools
import math

import numpy as np
import scipy

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.kernels.types import Array


def _overshoot(x: float) -> float:
    """Siegmund's nu(x), the factor of a random walk in discrete time."""
    h = 0.5 * x
    return (scipy.special.ndtr(h) - 0.5) / (h * (h * scipy.special.ndtr(h) + _normal_density(h)))


def _normal_density(x: float) -> float:
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)


def false_alarm_rate(threshold: float) -> float:
    """
    Return the false alarms per window of the one-sided test at `threshold`, of a known baseline.

    Siegmund and Venkatraman, Annals of Statistics 23(1), 1995.
    """
    inner, _ = scipy.integrate.quad(lambda x: x * _overshoot(x) ** 2,
                                    threshold / math.sqrt(LIMITS.horizon), threshold)
    return 0.5 * threshold * _normal_density(threshold) * inner


@functools.lru_cache(maxsize=64)
def threshold(windows: float) -> float:
    """Return the normal score that gives one false alarm per `windows` windows."""
    return scipy.optimize.brentq(lambda b: math.log(false_alarm_rate(b) * windows), 1.2, 15.0)


def normal_score(t: Array, dof: Array) -> Array:
    """Return the normal deviate as improbable as Student's `t` with `dof` (Wallace)."""
    factor = (8.0 * dof + 1.0) / (8.0 * dof + 3.0)
    result: Array = np.sign(t) * factor * np.sqrt(dof * np.log1p(t * t / dof))
    return result
