# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Wear as a linear model: levels, operating points, temperature; steps, pooling and forecast."""
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, UTC
import functools
import math

import numpy as np
import scipy

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.kernels.types import Array, Integers


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


# Columns before those of the points. COULOMB: of the temperature, of Coulomb friction alone.
LEVEL, TEMPERATURE, COULOMB, DISTRUST, SHIFT, N_COMMON = range(6)
TEMPERATURES = slice(TEMPERATURE, COULOMB + 1)
# Ages (windows) at which a random walk may have moved; fine where new.
KNOTS = (1, 2, 3, 4, 6, 8, 11, 15, 21, 29, 41, 57, 80, 113, 160, 226, 320, 640, 1280, 2560)


@dataclass(frozen=True)
class Observations:
    """
    Cells (sums of old windows) and the newest windows of one feature, oldest first.

    design [N, N_COMMON + P + L]: columns of level, temperatures, distrust, shift, points, and a
    distrust of each half octave of prediction errors that were larger at a point. y [N];
    weight [N]: 1 over the variance of y, 0 where nothing was measured; count [N]: windows behind
    each; age [N]: windows since, >= 0; the newest `rows` of them are single windows. within: what
    the temperatures inside of cells add to the information [2, 2] on both c, and to its right
    side [2].
    """

    design: Array
    y: Array
    weight: Array
    count: Array
    age: Array
    rows: int
    within: tuple[Array, Array]


@dataclass(frozen=True)
class Course:
    """
    What is known of the course of the wear: ages (windows, descending) of its steps.

    steps: that were found. pending: where a new motion began, with which one may have come.
    """

    steps: tuple[float, ...] = ()
    pending: tuple[float, ...] = ()


@dataclass(frozen=True)
class Fit:
    """
    Posterior of one course: mean [S] and covariance [S, S] of the columns `design` [N, S].

    likelihood: its logarithm, up to a constant. course, has_slope, walk: see wear_columns. slope:
    column of the newest slope, -1 without one. first: column where the wear begins.
    """

    mean: Array
    covariance: Array
    design: Array
    likelihood: float
    course: Course
    has_slope: bool
    walk: float
    slope: int
    first: int

    def wear(self, age: Array) -> Array:
        """Return the wear at `age` [N], windows."""
        columns = wear_columns(age, self.course, self.has_slope, self.walk)[0]
        values: Array = columns @ self.mean[self.first:]
        return values


@dataclass(frozen=True)
class Wear:
    """
    Wear now (logarithm), its deviation; slope per window and deviation, 0 without one.

    fit: the most probable course; moving: probability that the wear goes on.
    """

    value: float
    std: float
    slope: float
    slope_std: float
    moving: float
    fit: Fit


@dataclass(frozen=True)
class Scan:
    """
    Every stretch of the newest windows against what lay before it, row by row [M].

    size: step at the beginning of the stretch, std: its deviation; up, down: scores either way,
    in standard deviations, a lone window limited; noise: its share of the variance. newest:
    deviation of the newest window, whether it is alone or not.
    """

    size: Array
    std: Array
    up: Array
    down: Array
    noise: Array
    newest: float


def wear_columns(age: Array, course: Course, has_slope: bool, walk: float
                 ) -> tuple[Array, Array, int]:
    """
    Return the columns of the wear at `age`, their prior variances, and that of the newest slope.

    Args:
        age: [N], windows.
        course: its steps.
        has_slope: whether the wear has a slope after each step.
        walk: standard deviation of its random walk per window.

    Returns:
        Columns [N, W], variances [W], index among them (-1: no slope).

    """
    columns = [(age < begin).astype(float) for begin in (*course.steps, *course.pending)]
    variances = ([LIMITS.step_std ** 2] * len(course.steps)
                 + [LIMITS.pending_std ** 2] * len(course.pending))
    slope = -1
    if has_slope:
        for begin, end in zip(course.steps, (*course.steps[1:], 0.0)):
            slope = len(columns)
            columns.append(np.clip(begin - age, 0.0, begin - end))
            variances.append(LIMITS.slope_std ** 2)
    if walk > 0.0 and course.steps:
        knots = [k for k in KNOTS if k < course.steps[0]]
        for start, knot in zip((0, *knots), knots):
            columns.append((age < knot).astype(float))
            variances.append(walk ** 2 * (knot - start))
    if not columns:
        return np.zeros((len(age), 0)), np.zeros(0), -1
    return np.column_stack(columns), np.array(variances), slope


def fit(observations: Observations, prior: Array, course: Course, has_slope: bool = False,
        walk: float = 0.0) -> Fit:
    """
    Return the posterior of one course.

    Args:
        observations: of one feature.
        prior: variances of the columns of `observations` [N_COMMON + P + L].
        course: steps of the wear.
        has_slope: see wear_columns.
        walk: see wear_columns.

    Returns:
        The Fit.

    """
    o = observations
    columns, variances, slope = wear_columns(o.age, course, has_slope, walk)
    design = np.column_stack([o.design, columns]) if columns.size else o.design
    variances = np.concatenate([prior, variances])
    weighted = design * o.weight[:, None]
    information = weighted.T @ design
    right = weighted.T @ o.y
    information[TEMPERATURES, TEMPERATURES] += o.within[0]
    right[TEMPERATURES] += o.within[1]
    # In units of the prior: what it says and what windows say differ by ten orders of magnitude.
    scale = np.sqrt(variances)
    information = information * np.outer(scale, scale)
    information[np.diag_indices(len(scale))] += 1.0
    inverse = np.linalg.inv(information)
    covariance = inverse * np.outer(scale, scale)
    mean = covariance @ right
    likelihood = 0.5 * float(right @ mean) - 0.5 * float(np.linalg.slogdet(information)[1])
    first = o.design.shape[1]
    return Fit(mean, covariance, design, likelihood, course, has_slope, walk,
               slope if slope < 0 else first + slope, first)


def estimate(observations: Observations, prior: Array, course: Course, noise: float) -> Wear:
    """
    Return the wear now, averaged over LIMITS.courses by how probable each is.

    Args:
        observations: of one feature.
        prior: see fit.
        course: steps of the wear; without any, and none pending, the wear is 0.
        noise: standard deviation of a window.

    Returns:
        The Wear.

    """
    if not course.steps:
        fits, logs = [fit(observations, prior, course)], np.zeros(1)
    else:
        fits = [fit(observations, prior, course, has_slope, walk * noise)
                for has_slope, walk in LIMITS.courses]
        logs = np.array([f.likelihood for f in fits]) + np.log(LIMITS.course_prior)
    share = np.exp(logs - logs.max())
    share /= share.sum()
    present = [wear_columns(np.zeros(1), course, f.has_slope, f.walk)[0][0] for f in fits]
    values = np.array([a @ f.mean[f.first:] for a, f in zip(present, fits)])
    variances = np.array([a @ f.covariance[f.first:, f.first:] @ a for a, f in zip(present, fits)])
    value = float(share @ values)
    variance = float(share @ (variances + (values - value) ** 2))
    chosen = int(np.argmax(share))
    slope, slope_std = 0.0, 0.0
    moving = [k for k, f in enumerate(fits) if f.slope >= 0]
    if moving:
        k = max(moving, key=lambda k: float(share[k]))
        slope = float(fits[k].mean[fits[k].slope])
        slope_std = math.sqrt(max(fits[k].covariance[fits[k].slope, fits[k].slope], 0.0))
    return Wear(value, math.sqrt(max(variance, 0.0)), slope, slope_std,
                float(1.0 - share[0]) if len(fits) > 1 else 0.0, fits[chosen])


def scan(observations: Observations, posterior: Fit) -> Scan:
    """
    Return the Scan of the newest windows for one more step.

    observations: of one feature; posterior: of what is known, of all of them.
    """
    m = observations.rows
    y, weight = observations.y[-m:], observations.weight[-m:]
    design = posterior.design[-m:]
    residual = y - design @ posterior.mean
    pull, total = _from_end(weight * residual), _from_end(weight)
    reach = _from_end(design * weight[:, None])
    free = total - ((reach @ posterior.covariance) * reach).sum(axis=1)
    # A stretch that the model explains anyhow cannot be judged.
    judged = free > 1e-6 * np.maximum(total, 1e-300)
    safe = np.where(judged, free, 1.0)
    size = np.where(judged, pull / safe, np.nan)
    root = np.sqrt(weight)
    deviations = residual * root  # 0 where nothing was measured
    unit = float(root.max(initial=0.0))
    scores = []
    for sign in (1.0, -1.0):
        first, second = _two_largest(np.maximum(sign * deviations, 0.0))
        excess = np.maximum(first - second - LIMITS.loner, 0.0)
        limited = sign * pull - excess * unit * safe / np.maximum(total, 1e-300)
        scores.append(np.where(judged, limited / np.sqrt(safe), 0.0))
    single = _from_end((weight > 0.0).astype(float)) < 2
    up, down = (np.where(single, np.minimum(score, LIMITS.loner), score) for score in scores)
    return Scan(size, np.where(judged, 1.0 / np.sqrt(safe), np.nan), up, down,
                np.where(judged, safe / np.maximum(total, 1e-300), 1.0), float(deviations[-1]))


def _from_end(values: Array) -> Array:
    """Return sums over each stretch from row k to the last one."""
    sums: Array = np.cumsum(values[::-1], axis=0)[::-1]
    return sums


def _two_largest(x: Array) -> tuple[Array, Array]:
    """Return the largest and second largest of each stretch of x [M], at least 0."""
    x = x[::-1]
    first = np.maximum.accumulate(x)
    preceding = np.concatenate([[0.0], first[:-1]])
    second = np.maximum.accumulate(np.minimum(x, preceding))
    return first[::-1], second[::-1]


def ages(stamps: Sequence[int] | Integers, now_ns: int, window_ns: float) -> Array:
    """Return how many windows of `window_ns` lie between `stamps` [N] and `now_ns`."""
    result: Array = (now_ns - np.asarray(stamps, np.int64)) / window_ns
    return result


SECOND = 1_000_000_000


@dataclass(frozen=True)
class Trend:
    """Growth now, its slope per second, their standard deviations, and the stamp it is about."""

    stamp_ns: int
    growth: float
    growth_std: float
    slope: float
    slope_std: float

    @property
    def found(self) -> bool:
        """Whether there is a trend upwards."""
        return self.slope > LIMITS.trend_deviations * self.slope_std

    def reach(self, limit: float) -> tuple[float, float, float] | None:
        """
        Return (seconds, earliest, latest) until the growth is `limit`, 95 %; None without a trend.

        latest is inf where the slope may be that small.
        """
        if not self.found:
            return None
        remaining = limit - self.growth
        if remaining <= 0.0:
            return 0.0, 0.0, 0.0
        slow = self.slope - 2.0 * self.slope_std
        return (remaining / self.slope,
                max(remaining - 2.0 * self.growth_std, 0.0) / (self.slope + 2.0 * self.slope_std),
                (remaining + 2.0 * self.growth_std) / slow if slow > 0.0 else math.inf)


def when(stamp_ns: int) -> str:
    """Return `stamp_ns` in words: UTC, or seconds where the clock is a simulated one."""
    if stamp_ns < 10 ** 9 * SECOND:
        return f't = {stamp_ns / SECOND:.1f} s'
    return datetime.fromtimestamp(stamp_ns // SECOND, UTC).strftime(
        '%Y-%m-%d %H:%M:%S UTC')


def span(seconds: float) -> str:
    """Return a time span of `seconds` in words."""
    if not math.isfinite(seconds):
        return 'never'
    for unit, size in (('d', 86400.0), ('h', 3600.0), ('min', 60.0)):
        if seconds >= 2 * size:
            return f'{seconds / size:.0f} {unit}'
    return f'{seconds:.0f} s'
