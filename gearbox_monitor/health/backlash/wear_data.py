# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The windows of a gearbox: the newest one by one, older ones as sums, and how their errors go.

Errors of the features of a window go together: where the stiffness came out too large, the gap
did. Their correlations come from differences of neighbouring windows.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from gearbox_monitor.health.backlash.change_tests import (
    FEATURES, FRICTION, ModelFriction, PRIORS, VISCOUS_SHARE, WEAR)
from gearbox_monitor.health.backlash.operating_point import DIFFERENCE, OperatingPoint
from gearbox_monitor.health.backlash.wear import (
    DISTRUST, LEVEL, N_COMMON, Observations, TEMPERATURES)
from gearbox_monitor.health.health_record import AT_ODDS, ERRORS_LARGER
from gearbox_monitor.kernels.types import Array, Integers

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
