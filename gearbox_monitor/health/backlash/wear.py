# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Wear as a linear Gaussian model of all features together: its data, posterior, and odds.

Level, temperature, operating points and distrust are eliminated once (Posterior); what remains
are the columns of the wear. `evidence` compares the hypotheses "these features changed k windows
ago and the others went on" (Adams and MacKay, 2007); the sum of their odds is the statistic of
Shiryaev and Roberts, so that false alarms are no more often than the prior probability of a
change, however long one waits (e-detectors: Shin, Ramdas and Rinaldo, 2023).

The windows of a gearbox are a History: the newest one by one, older ones as sums. Errors of the
features of a window go together: where the stiffness came out too large, the gap did. Their
correlations come from differences of neighbouring windows.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, UTC
from functools import cached_property
import itertools
import math
from typing import Any, NamedTuple, Self

import numpy as np

from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.backlash.change_tests import (
    FEATURES, FRICTION, ModelFriction, PRIORS, VISCOUS_SHARE, WEAR)
from gearbox_monitor.health.health_record import AT_ODDS, DIFFERENCE, ERRORS_LARGER, OperatingPoint
from gearbox_monitor.kernels.types import Array, Integers

# Columns before those of the points. COULOMB: of the temperature, of Coulomb friction alone.
LEVEL, TEMPERATURE, COULOMB, DISTRUST, N_COMMON = range(5)
TEMPERATURES = slice(TEMPERATURE, COULOMB + 1)
# Ages (windows) at which a random walk may have moved; fine where new.
KNOTS = (1, 2, 3, 4, 6, 8, 11, 15, 21, 29, 41, 57, 80, 113, 160, 226, 320, 640, 1280, 2560)


class Observations(NamedTuple):
    """
    Cells of windows in order of time, of F features.

    design [F, C, B]: columns of level, temperatures, distrust, points, and a distrust of each half
    octave of prediction errors that were larger at a point. y [C, F]; weight [C, F, F]: inverse
    covariance of y, 0 where nothing was measured; counts [C, F]: windows behind it; stamps [C] ns;
    the newest `rows` are single windows. points: of the columns. prior [F, B]: variances. within:
    what temperatures inside of cells add to the information [F, 2, F, 2] on both coefficients, and
    pull [F, 2] to its right side.
    """

    design: Array
    y: Array
    weight: Array
    counts: Array
    stamps: Integers
    rows: int
    points: tuple[int, ...]
    prior: Array
    within: Array
    pull: Array


class Columns(NamedTuple):
    """Columns of the wear: values [T, C], now [T], the features [T] that wear, variances [T]."""

    values: Array
    now: Array
    feature: Integers
    variance: Array

    @classmethod
    def of(cls, parts: Sequence[tuple[int, Array, Array]], age: Array) -> 'Columns':
        """Return those of `parts` (feature, columns [C + 1, W], variances [W]); age: [C + 1]."""
        values = np.concatenate([p[1] for p in parts] or [np.zeros((len(age), 0))], axis=1).T
        return cls(values[:, :-1], values[:, -1],
                   np.repeat([p[0] for p in parts], [p[1].shape[1] for p in parts]).astype(int),
                   np.concatenate([p[2] for p in parts] or [np.zeros(0)]))


def wear_columns(age: Array, steps: Sequence[tuple[float, float, bool]], slope: float = 0.0,
                 walk: float = 0.0) -> tuple[Array, Array]:
    """
    Return the columns [N, W] of the wear of a feature, and their prior variances [W].

    Args:
        age: of the cells [N], windows.
        steps: age, prior deviation, and whether it was found, of each step; oldest first.
        slope: prior deviation of the slope after each step that was found, 0: none; the last
            columns before those of the walk, newest last.
        walk: standard deviation of its random walk per window since the first step found.

    """
    columns = [(age < begin).astype(float) for begin, _, _ in steps]
    variances = [std ** 2 for _, std, _ in steps]
    begins = [begin for begin, _, is_found in steps if is_found]
    for begin, end in zip(begins, (*begins[1:], 0.0)) if slope > 0.0 else ():
        columns.append(np.clip(begin - age, 0.0, begin - end))
        variances.append(slope ** 2)
    if walk > 0.0 and begins:
        knots = [k for k in KNOTS if k < begins[0]]
        for start, knot in zip((0, *knots), knots):
            columns.append((age < knot).astype(float))
            variances.append(walk ** 2 * (knot - start))
    return (np.column_stack(columns) if columns else np.zeros((len(age), 0))), np.array(variances)


class Posterior:
    """
    All that is no wear, eliminated: covariance [F B, F B] and mean [F B] of it without any wear.

    observations: of all features.
    """

    def __init__(self, observations: Observations) -> None:
        o = self.observations = observations
        features, _, width = o.design.shape
        information = np.zeros((features, width, features, width))
        for f, g in itertools.combinations_with_replacement(range(features), 2):
            block = o.design[f].T @ (o.weight[:, f, g, None] * o.design[g])
            information[f, :, g], information[g, :, f] = block, block.T
        information[:, TEMPERATURES, :, TEMPERATURES] += o.within
        right = np.einsum('fcb,cf->fb', o.design, np.einsum('cfg,cg->cf', o.weight, o.y))
        right[:, TEMPERATURES] += o.pull
        # In units of the prior: what it says and what windows say differ by ten orders.
        scale = np.sqrt(o.prior.ravel())
        size = len(scale)
        scaled = information.reshape(size, size) * np.outer(scale, scale)
        root = _root(scaled, scale)
        self.covariance: Array = root @ root.T
        self.mean: Array = self.covariance @ right.ravel()
        self.residual: Array = o.y - np.einsum(
            'fcb,fb->cf', o.design, self.mean.reshape(features, width))
        # Sums over each stretch from a row to the last one.
        newest = o.weight[len(o.y) - o.rows:]
        self.total = _from_end(newest)
        reach = np.einsum('cfg,gcb->cfgb', newest, o.design[:, len(o.y) - o.rows:])
        self.reach: Array = _from_end(reach).reshape(o.rows, features, size)
        self.known: Array = self.reach @ root

    def fit(self, columns: Columns) -> 'Fit':
        """Return the Fit of the wear that has these `columns`."""
        o, c = self.observations, columns
        weighted = o.weight[:, :, c.feature].transpose(2, 0, 1) * c.values[:, :, None]
        reach = (weighted.transpose(2, 0, 1) @ o.design).transpose(1, 0, 2).reshape(
            len(c.feature), self.mean.size)
        gram = np.einsum('tcu,uc->tu', weighted[:, :, c.feature], c.values) \
            - reach @ self.covariance @ reach.T
        pull = np.einsum('tcf,cf->t', weighted, self.residual)
        scale = np.sqrt(c.variance)
        root = _root(gram * np.outer(scale, scale), scale)
        mean = root @ (root.T @ pull)
        return Fit(self, c, reach, mean, root, 0.5 * float(pull @ mean) + float(
            np.log(np.diag(root) / scale).sum()))


@dataclass(frozen=True, eq=False)
class Fit:
    """
    Posterior of the wear: mean [T] of its `columns`, and a root [T, T] of the covariance.

    likelihood: its logarithm, up to a constant. reach [T, F B]: on what is no wear.
    """

    base: Posterior
    columns: Columns
    reach: Array
    mean: Array
    root: Array
    likelihood: float

    @property
    def covariance(self) -> Array:
        """Covariance [T, T] of the columns."""
        result: Array = self.root @ self.root.T
        return result

    def combined(self, at: Array, wear: Array) -> tuple[float, float]:
        """Return (value, deviation) of weights `at` [F B] of no wear and `wear` [T] of it."""
        spread = self.base.covariance @ at
        weights = wear - self.reach @ spread
        variance = float(at @ spread + weights @ self.covariance @ weights)
        return (float(at @ self.base.mean + weights @ self.mean),
                math.sqrt(max(variance, 0.0)))

    def without_wear(self) -> tuple[Array, Array]:
        """Return mean [F, B] and variances [F, B] of all that is no wear."""
        gain = self.base.covariance @ self.reach.T
        shape = self.base.observations.prior.shape
        variance = np.diag(self.base.covariance) + ((gain @ self.covariance) * gain).sum(axis=1)
        return (self.base.mean - gain @ self.mean).reshape(shape), variance.reshape(shape)

    @cached_property
    def scan(self) -> 'Scan':
        """What each stretch of the newest windows says of one more step."""
        o, c = self.base.observations, self.columns
        mean, _ = self.without_wear()
        residual = o.y - np.einsum('fcb,fb->cf', o.design, mean)
        np.subtract.at(residual.T, c.feature, self.mean[:, None] * c.values)
        begin = len(o.y) - o.rows
        pull: Array = np.einsum('cfg,cg->cf', o.weight[begin:], residual[begin:])
        cross = _from_end(o.weight[begin:][:, :, c.feature] * c.values.T[begin:, None, :]) \
            - self.base.reach @ (self.base.covariance @ self.reach.T)
        explained = np.concatenate([self.base.known, cross @ self.root], axis=2)
        free = self.base.total - explained @ explained.transpose(0, 2, 1)
        return Scan(_from_end(pull), free, pull, residual[begin:], explained)


class Scan(NamedTuple):
    """
    What the stretch of windows from each of the newest on says of a step at its beginning.

    pull [R, F], free [R, F, F]: on the step, its information. each, residual [R, F]: of a window.
    known [R, F, K]: of which free lacks the square, what is explained without a step.
    """

    pull: Array
    free: Array
    each: Array
    residual: Array
    known: Array

    def size(self, row: int, column: int) -> tuple[float, float]:
        """Return (size, deviation) of a step of the feature in `column` alone, NaN: not known."""
        free = float(self.free[row, column, column])
        return (float(self.pull[row, column] / free), free ** -0.5) if free > 0.0 else (
            math.nan, math.nan)

    def without(self, window: Integers, weight: Array) -> tuple[Array, Array]:
        """Return (pull, free) without one `window` [R] of each stretch; weight: [R, F, F]."""
        own = self.known - np.append(self.known[1:], np.zeros_like(self.known[:1]), axis=0)
        own, weight = own[window], weight[window]
        own_free = weight - own @ own.transpose(0, 2, 1)
        diagonal = np.diagonal(own_free, axis1=1, axis2=2)
        own_free = own_free + np.eye(len(FEATURES)) * np.where(
            diagonal > 0.0, 1e-9 * diagonal, 1.0)[:, None]
        cross = weight - self.known @ own.transpose(0, 2, 1)
        gain = cross @ np.linalg.inv(own_free)
        return (self.pull - (gain @ self.each[window][:, :, None])[:, :, 0],
                self.free - gain @ cross.transpose(0, 2, 1))


# Hypotheses of one step: the features that change, and the logarithm of its prior probability.
_SHARES = np.array([p.share for p in PRIORS])
FIRST, SECOND_ONE = np.array([(f, f) for f in range(len(FEATURES))]
                             + list(itertools.combinations(range(len(FEATURES)), 2))).T
_PRIOR = np.log(np.where(FIRST == SECOND_ONE, (1.0 - WEAR.pair) * _SHARES[FIRST],
                         2.0 * WEAR.pair * _SHARES[FIRST] * _SHARES[SECOND_ONE]
                         / (1.0 - (_SHARES ** 2).sum())))

# Of the side to which a feature goes: down, up [2, F].
_SIDES = np.log(2.0 * np.array([[1.0 - p.up for p in PRIORS], [p.up for p in PRIORS]]))


def evidence(pull: Array, free: Array) -> tuple[Array, Array]:
    """
    Return the logarithmic odds of each hypothesis against none, and the size of its step.

    Args:
        pull: [R, F], of a Scan.
        free: information [R, F, F], of a Scan.

    Returns:
        Odds [R, H] by FIRST and SECOND_ONE, prior included; most probable steps [R, H, 2].

    """
    a, b = FIRST, SECOND_ONE
    single = a == b
    diagonal = np.maximum(np.diagonal(free, axis1=1, axis2=2), 0.0)
    faa, fbb, fab = diagonal[:, a], diagonal[:, b], free[:, a, b]
    pa, pb = pull[:, a], pull[:, b]
    odds, likeliest, steps = np.full(pa.shape, -np.inf), np.full(pa.shape, -np.inf), \
        np.zeros((*pa.shape, 2))
    for size in WEAR.sizes:
        ia, ib = faa + size ** -2, fbb + size ** -2
        both = np.where(single, ia, np.maximum(ia * ib - fab ** 2, 1e-12 * ia * ib))
        xa = np.where(single, pa, pa * ib - pb * fab) / both
        xb = np.where(single, 0.0, pb * ia - pa * fab) / both
        gain = np.maximum(xa * pa + xb * pb, 0.0)
        value = 0.5 * gain - 0.5 * np.log(
            both * np.where(single, size ** 2, size ** 4)) + _PRIOR - math.log(len(WEAR.sizes))
        odds = np.logaddexp(odds, value)
        steps = np.where((value > likeliest)[:, :, None], np.stack([xa, xb], axis=2), steps)
        likeliest = np.maximum(likeliest, value)
    up, up_second = ((steps > 0.0).astype(int)[:, :, k] for k in (0, 1))
    odds = odds + _SIDES[up, a] + np.where(single, 0.0, _SIDES[up_second, b])
    return odds, steps


def limited_evidence(base: Posterior, scanned: Scan, closed: Scan, dof: Array) -> Array:
    """
    Return the odds [R, H] of `evidence`, as Student's where the noise is estimated.

    Without what a single window off by chance adds.

    Args:
        base: what is no wear.
        scanned: of a fit of it.
        closed: of one in which nothing has changed with a new motion: for that to come with a
            window off by chance is no likelier than a change.
        dof: degrees of freedom [F] of the noise.

    """
    o = base.observations
    # Only the noise is known by so many windows, not what priors add (Satterthwaite).
    total, free = (np.diagonal(m, axis1=1, axis2=2) for m in (base.total, scanned.free))
    dof = dof / np.clip(free / np.where(total > 0.0, total, 1.0), 1e-3, 1.0) ** 2
    odds, steps = evidence(scanned.pull, scanned.free)
    # Of the best explanation; others leave a misfit that larger noise does not excuse.
    odds = odds - _surplus(odds, steps, scanned.pull, dof)[odds.max(axis=1).argmax()]
    rows, weight = np.arange(o.rows), o.weight[len(o.y) - o.rows:]
    likeliest = odds.argmax(axis=1)
    step = np.zeros_like(scanned.pull)
    step[rows, SECOND_ONE[likeliest]] = steps[rows, likeliest, 1]
    step[rows, FIRST[likeliest]] = steps[rows, likeliest, 0]
    pulls = np.where(rows[None, :] >= rows[:, None], step @ scanned.each.T, -np.inf)
    pull, other_free = closed.without(pulls.argmax(axis=1), weight)
    limited, steps = evidence(pull, other_free)
    limit = limited.max(axis=1) - _surplus(limited, steps, pull, dof) - math.log(WEAR.outlier)
    result: Array = odds - np.maximum(odds.max(axis=1) - limit, 0.0)[:, None]
    return result


def _surplus(odds: Array, steps: Array, pull: Array, dof: Array) -> Array:
    """Return by what the best `odds` of each row [R] exceed those of Student's distribution."""
    rows, likeliest = np.arange(len(odds)), odds.argmax(axis=1)
    first, second = FIRST[likeliest], SECOND_ONE[likeliest]
    gain = np.maximum((steps[rows, likeliest] * np.stack(
        [pull[rows, first], pull[rows, second]], axis=1)).sum(axis=1), 0.0)
    nu = np.minimum(dof[rows, first], dof[rows, second])
    result: Array = 0.5 * (gain - nu * np.log1p(gain / nu))
    return result


def step_odds(mean: float, variance: float, prior: float, dof: float) -> float:
    """
    Return the logarithmic odds of a step of the fit against none (Savage and Dickey).

    Args:
        mean: posterior mean.
        variance: posterior variance.
        prior: prior variance.
        dof: degrees of freedom of the noise.

    """
    return 0.5 * dof * math.log1p(mean ** 2 / variance / dof) - 0.5 * math.log(prior / variance)


def _root(information: Array, scale: Array) -> Array:
    """
    Return a root, upper triangular, of the covariance [N, N] of what `information` is about.

    Args:
        information: of windows alone [N, N], in units of the prior.
        scale: deviations of the prior [N].

    """
    factor = np.linalg.cholesky(information + np.eye(len(scale)))
    result: Array = scale[:, None] * np.linalg.inv(factor).T
    return result


def _from_end(values: Array) -> Array:
    """Return sums over each stretch from row k to the last one."""
    sums: Array = np.cumsum(values[::-1], axis=0)[::-1]
    return sums


def reach(growth: float, growth_std: float, slope: float, slope_std: float, limit: float
          ) -> tuple[float, float, float] | None:
    """
    Return (seconds, earliest, latest) until a growth is `limit`, 95 %; None without a trend to it.

    Args:
        growth: now.
        growth_std: its standard deviation.
        slope: of the growth, per second.
        slope_std: its standard deviation.
        limit: of the growth.

    Returns:
        The times; latest is inf where the slope may be that small.
    """
    if not slope > LIMITS.deviations * slope_std:
        return None
    remaining, slow = limit - growth, slope - 2.0 * slope_std
    if remaining <= 0.0:
        return 0.0, 0.0, 0.0
    return (remaining / slope, max(remaining - 2.0 * growth_std, 0.0) / (slope + 2.0 * slope_std),
            (remaining + 2.0 * growth_std) / slow if slow > 0.0 else math.inf)


SECOND = 1_000_000_000


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


N = len(FEATURES)
PER_SIZE = 6       # cells of one size, before the two oldest of them become one
MAX_ACTIVE = 24    # points that take part in a fit, beside those of the newest windows
SMALLEST = 0.02    # eigenvalue of the correlations: errors never go together entirely
COUNT, TOTAL, KELVIN, KELVIN_2, PRODUCT = range(5)  # sums of a cell


def excess(trust: int) -> float:
    """Return the variance of a window over that of one whose prediction errors are not larger."""
    return float(2.0 ** (0.5 * min(max(ERRORS_LARGER - trust, 0), 99)))


def _unknown() -> Any:
    return np.full(N, np.nan)


@dataclass(frozen=True, eq=False)
class History:
    """
    Operating points, and the windows as cells in order of time; arrays are not changed.

    stamps [C] ns: middle of a cell; where [C]: point; trust [C]; sums [C, 5, F]: see COUNT and
    after, of logarithms of the features less `reference` [F] (of hysteresis: over load) and of
    temperatures less `first_kelvin`. The newest `rows` cells are single windows. products,
    differences [F, F]: of errors, and of how many. slopes [F]: temperature coefficients, spread
    [F]: variances of the offsets of points, both as known so far.
    """

    points: tuple[OperatingPoint, ...] = ()
    stamps: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    where: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    trust: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    sums: Array = field(default_factory=lambda: np.zeros((0, 5, N)))
    rows: int = 0
    reference: Array = field(default_factory=_unknown)
    first_kelvin: float | None = None
    products: Array = field(default_factory=lambda: np.zeros((N, N)))
    differences: Array = field(default_factory=lambda: np.zeros((N, N)))
    slopes: Array = field(default_factory=lambda: np.zeros(N))
    spread: Array = field(default_factory=_unknown)

    @property
    def windows(self) -> int:
        """Number of windows, of the feature with most of them in each cell."""
        return int(self.sums[:, COUNT].max(axis=1, initial=0.0).sum())

    def recent_ns(self, count: int) -> int:
        """Return the stamp before the newest `count` windows."""
        return int(self.stamps[max(len(self.stamps) - count, 0)]) - 1

    def count(self, point: int, since_ns: int = -1) -> int:
        """Return the number of windows of a `point` after `since_ns`, of its commonest feature."""
        chosen = (self.where == point) & (self.stamps > since_ns)
        return int(self.sums[chosen, COUNT].sum(axis=0).max())

    def warmth(self, temperature: float | None) -> float:
        """Return `temperature` (deg C) less the first known one; 0 where either is unknown."""
        if temperature is None or self.first_kelvin is None:
            return 0.0
        return temperature - self.first_kelvin

    def with_window(self, stamp_ns: int, point: int, trust: int, temperature: float | None,
                    values: Array) -> Self:
        """
        Take a window.

        Args:
            stamp_ns: its end.
            point: its operating point.
            trust: TRUSTED, AT_ODDS, ERRORS_LARGER or less.
            temperature: deg C, None if unknown.
            values: of the features [F], NaN where unknown.

        """
        first = temperature if self.first_kelvin is None else self.first_kelvin
        kelvin = 0.0 if temperature is None or first is None else temperature - first
        reference = np.where(np.isnan(self.reference), values, self.reference)
        relative = np.array([float(f'{v:.7g}') for v in values - reference])
        place, off = self.points[point].with_window(relative, kelvin, self.slopes, excess(trust))
        finite, off_finite = np.isfinite(relative), np.isfinite(off).astype(float)
        off = np.nan_to_num(off)
        return replace(
            self, reference=reference, first_kelvin=first, stamps=np.append(self.stamps, stamp_ns),
            points=(*self.points[:point], replace(place, last_ns=stamp_ns),
                    *self.points[point + 1:]),
            where=np.append(self.where, point), trust=np.append(self.trust, trust),
            sums=np.concatenate([self.sums, _sums(np.where(finite, 1.0, 0.0), np.where(
                finite, relative, 0.0), kelvin)[None]]), rows=self.rows + 1,
            products=self.products + DIFFERENCE * np.outer(off, off),
            differences=self.differences + DIFFERENCE * np.outer(off_finite, off_finite))

    def merged(self, marks: Sequence[int], moving_ns: int, limit: int) -> Self:
        """
        Merge cells beyond the horizon: fine where new, coarse where old, never across `marks`.

        Args:
            marks: stamps (ns) at which a feature may have changed.
            moving_ns: cells until then are merged to one of each point.
            limit: windows of a point that it holds.

        """
        stamps, where, trust, sums = self.stamps, self.where, self.trust, self.sums
        rows = min(self.rows, WEAR.horizon)
        while True:
            old = len(stamps) - rows
            segment = np.searchsorted(np.sort(np.array(marks, np.int64)), stamps[:old])
            counts = sums[:old, COUNT].max(axis=1, initial=0.0).astype(int)
            groups: dict[tuple[int, ...], list[int]] = {}
            for i in range(old):
                size = -1 if stamps[i] <= moving_ns else int(counts[i]).bit_length()
                groups.setdefault((int(where[i]), int(trust[i]), int(segment[i]), size),
                                  []).append(i)
            pair = next((group[:2] for key, group in groups.items()
                         if len(group) > (1 if key[3] < 0 else PER_SIZE)), None)
            if pair is None:
                return replace(self, stamps=stamps, where=where, trust=trust, sums=sums, rows=rows)
            i, j = pair
            full = stamps[j] <= moving_ns and counts[i] >= limit
            share = 0.0 if full else counts[j] / max(counts[i] + counts[j], 1)
            both = sums[i] if full else sums[i] + sums[j]
            middle = stamps[i] + int(share * (stamps[j] - stamps[i]))
            place = [k for k in range(len(stamps)) if k not in (i, j)]
            at = int(np.searchsorted(stamps[place], middle))
            order = np.array([*place[:at], i, *place[at:]])
            stamps, where, trust, sums = (a[order] for a in (stamps, where, trust, sums))
            stamps[at], sums[at] = middle, both

    def moved(self, by_ns: int) -> Self:
        """Return it with all stamps moved by `by_ns`."""
        return replace(self, stamps=self.stamps + by_ns, points=tuple(
            replace(point, last_ns=point.last_ns + by_ns) for point in self.points))

    def without(self, column: int, begin_ns: int, end_ns: int) -> Self:
        """
        Forget a feature in the windows after `begin_ns` until `end_ns`: they were not healthy.

        column: of the feature.
        """
        sums = self.sums.copy()
        sums[(self.stamps > begin_ns) & (self.stamps <= end_ns), :, column] = 0.0
        return replace(self, sums=sums)

    def shares(self, points: Sequence[int] | Integers, column: int, friction: ModelFriction
               ) -> Array:
        """
        Return the shares [C, 2] of both temperature coefficients of a feature.

        Args:
            points: of the cells [C].
            column: of the feature.
            friction: of the model file.
        """
        parts = np.tile((1.0, 0.0), (len(points), 1))
        if column in (FRICTION, VISCOUS_SHARE) and sum(friction) > 0.0:
            parts = np.array([(friction.viscous * self.points[k].speed, friction.coulomb)
                              for k in points]).reshape(-1, 2)
            parts = parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-300)
        if column == VISCOUS_SHARE:  # the derivative of the share v / (v + c)
            parts = parts.prod(axis=1, keepdims=True) * (1.0, -1.0)
        return parts

    def correlations(self) -> Array:
        """Return the correlations [F, F] of the errors of a window."""
        correlation = (WEAR.correlation_windows * np.eye(N) + self.products) / (
            WEAR.correlation_windows + self.differences)
        values, vectors = np.linalg.eigh(correlation)
        correlation = (vectors * np.maximum(values, SMALLEST)) @ vectors.T
        std = np.sqrt(np.diag(correlation))
        result: Array = correlation / np.outer(std, std)
        return result

    def dof(self, point: int) -> Array:
        """Return the degrees of freedom [F] of the noise at a `point`, given other features."""
        differences = np.diag(self.differences)
        coupled = max(int((differences > 0.0).sum()) - 1, 0)
        result: Array = WEAR.prior_windows - 1.0 + np.minimum(
            self.points[point].freedom, np.maximum(differences - coupled, 0.0))
        return result

    def observations(self, growth: Array, friction: ModelFriction) -> Observations:
        """
        Return the Observations.

        growth [C, F]: factor of the noise, for a smaller feature; friction: of the model file.
        """
        recent = set(self.where[len(self.where) - self.rows:].tolist())
        older = sorted(set(self.where.tolist()) - recent, key=lambda k: -self.points[k].last_ns)
        points = sorted(recent | set(older[:MAX_ACTIVE]))
        keep = np.isin(self.where, points)
        where, trust, sums = self.where[keep], self.trust[keep], self.sums[keep]
        count = sums[:, COUNT]
        larger = sorted({(k, t) for k, t in zip(where.tolist(), trust.tolist())
                         if t <= ERRORS_LARGER})
        n, width = len(where), N_COMMON + len(points) + len(larger)
        shared = np.zeros((n, width))
        shared[:, LEVEL] = 1.0
        shared[:, DISTRUST] = trust == AT_ODDS
        shared[np.arange(n), N_COMMON + np.searchsorted(points, where)] = 1.0
        for k, key in enumerate(larger):
            shared[(where == key[0]) & (trust == key[1]), N_COMMON + len(points) + k] = 1.0
        safe = np.maximum(count, 1.0)
        warmth = sums[:, KELVIN].sum(axis=1) / np.maximum(count.sum(axis=1), 1.0)
        design = np.tile(shared, (N, 1, 1))
        prior = np.zeros((N, width))
        parts = np.array([self.shares(where, f, friction) for f in range(N)])
        for f, p in enumerate(PRIORS):
            design[f, :, TEMPERATURES] = parts[f] * warmth[:, None]
            offset = self.spread[f] if np.isfinite(self.spread[f]) else p.offset ** 2
            prior[f] = p.distrust ** 2
            prior[f, :N_COMMON] = (WEAR.level_std ** 2, p.temperature ** 2, p.coulomb ** 2,
                                   p.distrust ** 2)
            prior[f, N_COMMON:N_COMMON + len(points)] = offset
        variance = np.array([self.points[k].variance() for k in points]).reshape(-1, N)[
            np.searchsorted(points, where)] * np.array([excess(int(t)) for t in trust])[:, None]
        std = np.sqrt(variance) * growth[keep]
        measured = (count > 0.0) & (std > 0.0)
        both = measured[:, :, None] & measured[:, None, :]
        precision = np.linalg.inv(np.where(both, self.correlations(), np.eye(N)))
        root = np.where(measured, 1.0 / np.where(measured, std, 1.0), 0.0)
        precision = precision * both * root[:, :, None] * root[:, None, :]
        root = np.sqrt(count)
        # Temperatures inside of cells tell the coefficients, too.
        spread = np.sqrt(np.maximum(sums[:, KELVIN_2] - sums[:, KELVIN] ** 2 / safe, 0.0))
        product = sums[:, PRODUCT] - sums[:, KELVIN] * sums[:, TOTAL] / safe
        spread_weight = precision * spread[:, :, None] * spread[:, None, :]
        return Observations(
            design, sums[:, TOTAL] / safe, precision * root[:, :, None] * root[:, None, :],
            count, self.stamps[keep], self.rows, tuple(points), prior,
            np.einsum('ncs,cnm,mct->nsmt', parts, spread_weight, parts, optimize=True),
            np.einsum('ncs,cnm,cm->ns', parts, precision, product, optimize=True))


def _sums(count: Array, total: Array, kelvin: float) -> Array:
    """Return the sums [5, F] of `count` [F] windows, `total` [F] of values, at `kelvin`."""
    return np.array([count, total, count * kelvin, count * kelvin ** 2, total * kelvin])
