# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Sequential test for a shift of the mean: generalised likelihood ratio over the change point.

After each window every stretch of the newest 1 .. HORIZON windows is compared with the baseline
that lies before it. With one threshold this finds jumps as fast as a CUSUM tuned to them and slow
ramps as well, and needs no size of the change to be chosen beforehand.
"""
from collections.abc import Mapping
import functools
import math

import numpy as np
from scipy.special import ndtr  # scipy.stats would take a third of the time of a start

from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.monitoring.backlash.operating_point import GAP, MIN_COMPLETE, Sums

HORIZON = 120  # windows
# One window alone is no change: the largest counts no more than this many standard deviations
# above the second largest.
LONER = 3.0
# The stated deviation of a window may be too small by this factor ...
STATED = 1.5
# ... and weighs as much as this many windows against the spread that was seen.
PRIOR_WINDOWS = 10.0
MIN_BASELINE = 3  # windows


def _overshoot(x: float) -> float:
    """Siegmund's nu(x), the factor of a random walk in discrete time."""
    h = 0.5 * x
    return (ndtr(h) - 0.5) / (h * (h * ndtr(h) + _normal_density(h)))


def _normal_density(x: float) -> float:
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)


def false_alarm_rate(threshold: float) -> float:
    """
    Return the false alarms per window of the one-sided test at `threshold`, of a known baseline.

    Siegmund and Venkatraman, Annals of Statistics 23(1), 1995.
    """
    from scipy.integrate import quad  # a fifth of the time of a start, and not needed before
    inner, _ = quad(lambda x: x * _overshoot(x) ** 2, threshold / math.sqrt(HORIZON), threshold)
    return 0.5 * threshold * _normal_density(threshold) * inner


@functools.lru_cache(maxsize=64)
def threshold(windows: float) -> float:
    """Return the normal score that gives one false alarm per `windows` windows."""
    from scipy.optimize import brentq
    return brentq(lambda b: math.log(false_alarm_rate(b) * windows), 1.2, 15.0)


def normal_score(t: Array, dof: Array) -> Array:
    """Return the normal deviate as improbable as Student's `t` with `dof` (Wallace)."""
    return np.sign(t) * (8 * dof + 1) / (8 * dof + 3) * np.sqrt(dof * np.log1p(t * t / dof))


class Stretches:
    """
    All stretches of the newest windows against their baselines, for C upward tests at once.

    score [n, C]: normal score of the stretch that begins at row k; growth, std [n, C]: its mean
    growth and standard deviation. 0 and NaN where a stretch cannot be judged.
    """

    def __init__(self, values: Array, points: Integers, learned: Flags,
                 baselines: Mapping[int, Sums], tests: tuple[Integers, Integers, Flags]) -> None:
        """
        Compare rows with what lay before them.

        values [n, F] features of the newest windows, oldest first; points [n]: operating point of
        each; learned [n]: whether the baseline of that point holds the row. baselines {point:
        operating_point.Sums}. tests: (column [C], sign [C], relative [C]) of the features; column
        F is the gap, all else being equal (operating_point.Sums.couplings).
        """
        column, sign, relative = tests
        n, c = len(values), len(column)
        weight, pull, whole, freedom = (np.zeros((n, c)) for _ in range(4))
        for point in np.unique(points):
            base = baselines[point]
            is_point = (points == point)[:, None]
            x = np.where(is_point, values - base.first, np.nan)
            x = np.column_stack([x, base.alone(x)])
            x = x[:, column] * sign
            base_count, base_total, base_squares, stated = (
                a[column] for a in base.extended())
            reference = np.append(base.first, base.first[GAP])[column]
            finite = np.isfinite(x)
            x0 = np.where(finite, x, 0.0)
            old = np.where(learned[:, None] & finite, x0, 0.0)
            count, total = _from_end(finite), _from_end(x0)
            # What the baseline held before the stretch.
            n0 = base_count - _from_end(learned[:, None] & finite)
            min_count = np.where(column == values.shape[1], MIN_COMPLETE, MIN_BASELINE)
            good = (n0 >= min_count) & (count > 0)
            n0 = np.maximum(n0, 1)
            s0 = base_total * sign - _from_end(old)
            mean = s0 / n0
            squares = np.maximum(
                base_squares - _from_end(old * old) - n0 * mean ** 2, 0.0)
            dof = PRIOR_WINDOWS + n0 - 1
            variance = (PRIOR_WINDOWS * STATED ** 2 * stated + squares) / dof
            good &= np.isfinite(variance) & (variance > 0.0)
            variance = np.where(good, variance, 1.0)
            first, second = _two_largest(np.where(finite, x, -np.inf), mean)
            with np.errstate(invalid='ignore'):
                limited = total - np.where(count > 0, np.maximum(
                    first - second - LONER * np.sqrt(variance), 0.0), 0.0)
            unit = np.where(relative, np.abs(reference * sign + mean), base.scale)
            good &= unit > 0.0
            count = np.maximum(count, 1)
            w = np.where(good, unit ** 2 / variance / (1.0 / count + 1.0 / n0), 0.0)
            weight += w
            unit = np.where(good, unit, 1.0)
            pull += w * (limited / count - mean) / unit
            whole += w * (total / count - mean) / unit
            freedom += w * dof
        judged = weight > 0.0
        safe = np.where(judged, weight, 1.0)
        with np.errstate(invalid='ignore'):
            self.growth = np.where(judged, whole / safe, np.nan)
            self.std = np.where(judged, 1.0 / np.sqrt(safe), np.nan)
            self.score = np.where(judged, normal_score(
                pull / np.sqrt(safe), np.where(judged, freedom / safe, 1.0)), 0.0)


def _from_end(values: Array | Flags) -> Array:
    """Return sums over each stretch from row k to the last one."""
    sums: Array = np.cumsum(values[::-1], axis=0)
    return sums[::-1]


def _two_largest(x: Array, floor: Array) -> tuple[Array, Array]:
    """Return the largest and second largest of each stretch; the second is at least `floor`."""
    x = x[::-1]
    first = np.maximum.accumulate(x, axis=0)
    preceding = np.vstack([np.full((1, x.shape[1]), -np.inf), first[:-1]])
    second = np.maximum.accumulate(np.minimum(x, preceding), axis=0)
    return first[::-1], np.maximum(second[::-1], floor)
