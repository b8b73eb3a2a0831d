# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Ranges of parameters over a population of drives: from several estimates to the next drive.

Each estimate scatters about its drive by its own error, and drives scatter about their mean
(normal hierarchical model, positive parameters on the scale of logarithms). Q of the scatter is
chi-squared at the right variance between drives, so its distribution follows from that of Q
without an approximation for few drives (Nagashima, Noma and Furukawa, 2019); the prediction for a
new drive is the mixture of normals over it. With estimates that have no error it is Student's t.

A direction that the recordings do not determine is that of an eigenvalue of the errors. All
estimates hold it by the same prior, so that their scatter says nothing: there the error of a
single estimate remains, and parameters are drawn along it.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any

import numpy as np
from scipy.special import ndtr
from scipy.stats import chi2

from gearbox_monitor.errors import InputError
from gearbox_monitor.identification.thresholds import THRESHOLDS
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.presentation import Saved, Shown

CONFIDENCE = 0.9
NORMAL = 1.6448536269514722  # deviations of a normal that hold CONFIDENCE
COMPONENTS = 200  # of the mixture over the variance between drives
HALVINGS = 60     # of an interval that holds a root
LEVELS = np.concatenate([[1e-3], np.arange(1, 200) / 200, [1.0 - 1e-3]])
PART = 0.3        # of a direction, from which a parameter counts as part of it
SMALLEST = 1e-12  # relative error of a value that has none


@dataclass(frozen=True)
class UnitEstimate:
    """
    Parameters of one drive, or by one recording.

    name: of it. values {parameter: value}, units {parameter: unit}. covariance [P, P] of the
    errors, in the units and the order of the values.
    """

    name: str
    values: Mapping[str, float]
    units: Mapping[str, str]
    covariance: Array


@dataclass(frozen=True)
class Combination:
    """
    Direction in which the recordings determine no value.

    exponents {parameter: exponent}: the product of powers (of parameters with a logarithm) that is
    known is at right angles to it. deviation: standard deviation along it.
    """

    exponents: Mapping[str, float]
    deviation: float

    def __str__(self) -> str:
        if len(self.exponents) == 1:
            return (f'not determined: {next(iter(self.exponents))}, with a deviation of '
                    f'{self.deviation:.2g}')
        terms = ', '.join(f'{name} {weight:+.2f}' for name, weight in self.exponents.items())
        return (f'known only in combination: {terms} move together, with a deviation of '
                f'{self.deviation:.2g}')


@dataclass(frozen=True, eq=False, repr=False)
class ParameterRanges(Shown, Saved):
    """
    What a new drive of the kind may have.

    names, units: of the parameters [P]. logarithmic [P]: whether a parameter is positive, and has
    its distribution on the scale of logarithms. centre, low, high [P]: median and 90 % range.
    between [P]: standard deviation between drives (relative of a logarithmic one), NaN of one
    estimate alone. correlation [P, P] of a new drive's parameters, on these scales. combinations:
    directions without a value. sources: names of the estimates. notes: sentences.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    logarithmic: tuple[bool, ...]
    centre: Array
    low: Array
    high: Array
    between: Array
    correlation: Array
    combinations: tuple[Combination, ...]
    sources: tuple[str, ...]
    notes: tuple[str, ...]
    quantiles: Array

    def sample(self, count: int, seed: int = 0) -> dict[str, Array]:
        """
        Return sets of parameters of new drives, correlated as the estimates are.

        Args:
            count: number of drives N, 1 at least.
            seed: of the draw; same seed, same drives.

        Returns:
            {parameter: [N]}, in its unit.

        Raises:
            InputError: count or seed is no such number.
        """
        for name, value, least in (('count', count, 1), ('seed', seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise InputError(f'{name}: {value!r}, expected a whole number >= {least}')
        normal = np.random.default_rng(seed).standard_normal((count, len(self.names)))
        level = ndtr(normal @ self.factor.T)
        drawn = {}
        for i, name in enumerate(self.names):
            value = np.interp(level[:, i], LEVELS, self.quantiles[:, i])
            drawn[name] = np.exp(value) if self.logarithmic[i] else value
        return drawn

    @cached_property
    def factor(self) -> Array:
        """Matrix [P, P] whose product with standard normal numbers has the correlation."""
        values, vectors = np.linalg.eigh(self.correlation)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))

    def index(self, name: str) -> int | None:
        """Return the place of the parameter `name`, None where it has no range."""
        return self.names.index(name) if name in self.names else None


def ranges_of(estimates: Sequence[UnitEstimate], notes: Sequence[str] = ()) -> ParameterRanges:
    """
    Return the ranges that several estimates allow for a new drive.

    Args:
        estimates: one of each drive (or recording, for the next recording); one alone gives the
            range of its own error. Parameters that not all of them have are left out, with a note.
        notes: sentences that go with the result.

    Raises:
        InputError: no estimate, or no parameter that all have.
    """
    if not estimates:
        raise InputError('estimates: none, expected one or several')
    names = [name for name in estimates[0].values
             if all(name in estimate.values for estimate in estimates)]
    dropped = list(dict.fromkeys(name for estimate in estimates for name in estimate.values
                                 if name not in names))
    remarks = list(notes)
    if dropped:
        remarks.append(f'{", ".join(dropped)}: not in every estimate, no range')
    if not names:
        raise InputError(f'{", ".join(e.name for e in estimates)}: no parameter in common, '
                         'expected estimates of the same parameters')
    if len(estimates) == 1:
        remarks.append('one estimate: the range is that of its error, and says nothing about '
                       'other drives')
    places = [[list(e.values).index(name) for name in names] for e in estimates]
    values = np.array([[e.values[name] for name in names] for e in estimates], float)
    covariances = np.array([np.asarray(e.covariance, float)[np.ix_(at, at)]
                            for e, at in zip(estimates, places)])
    logarithmic = np.asarray((values > 0.0).all(axis=0))
    slope = np.where(logarithmic, np.where(logarithmic, values, 1.0), 1.0)
    y = np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)
    covariances = covariances / (slope[:, :, None] * slope[:, None, :])
    # Parameters that may be negative: in shares of their size, so that directions compare.
    errors = np.sqrt(np.einsum('njj->nj', covariances).mean(axis=0))
    size = np.where(logarithmic, 1.0, np.maximum(np.abs(values).max(axis=0), errors))
    size = np.where(size > 0.0, size, 1.0)
    y, covariances = y / size, covariances / np.outer(size, size)
    spread, directions = np.linalg.eigh(covariances.mean(axis=0))
    unknown = spread > THRESHOLDS.determined ** 2
    along, variance = directions[:, unknown], spread[unknown]
    across = np.eye(len(names)) - along @ along.T
    inside = np.einsum('ij,njk,kl->nil', across, covariances, across)
    beside = (along ** 2) @ variance
    centre = y.mean(axis=0) @ (along @ along.T)
    known = y @ across
    quantiles = np.empty((len(LEVELS), len(names)))
    between = np.full(len(names), math.nan)
    deviation = np.empty(len(names))
    for j in range(len(names)):
        means, variances, between[j] = _mixture(known[:, j], inside[:, j, j])
        quantiles[:, j] = centre[j] + _quantiles(means, variances + beside[j], LEVELS)
        low, high = _quantiles(means, variances, np.array([0.05, 0.95]))
        deviation[j] = (high - low) / (2.0 * NORMAL)
    if len(estimates) == 1:
        correlation = _normalised(covariances[0])
    else:
        # Of the difference between drives, and of the error of their mean.
        inner = _normalised(_between_correlation(known, inside) * np.outer(between, between)
                            + inside.mean(axis=0) / len(estimates))
        correlation = _normalised(inner * np.outer(deviation, deviation)
                                  + (along * variance) @ along.T)
    quantiles *= size
    low, middle, high = (_at(quantiles, level, logarithmic) for level in (0.05, 0.5, 0.95))
    units = [next((e.units[name] for e in estimates if name in e.units), '') for name in names]
    return ParameterRanges(
        tuple(names), tuple(units), tuple(bool(v) for v in logarithmic), middle, low, high,
        between * size, correlation, _combinations(names, along, variance),
        tuple(e.name for e in estimates), tuple(remarks), quantiles)


def _at(quantiles: Array, level: float, logarithmic: Any) -> Array:
    """Return the values [P] at a level of the distributions."""
    value = np.array([np.interp(level, LEVELS, column) for column in quantiles.T])
    return np.where(logarithmic, np.exp(np.where(logarithmic, value, 0.0)), value)


def _combinations(names: Sequence[str], along: Array, variance: Array) -> tuple[Combination, ...]:
    """Return the directions [P, D] without a value, the widest first, in words."""
    rows = []
    for k in np.argsort(variance)[::-1]:
        direction = along[:, k] * np.sign(along[np.argmax(np.abs(along[:, k])), k])
        rows.append(Combination({name: float(weight) for name, weight in zip(names, direction)
                                 if abs(weight) > PART}, math.sqrt(variance[k])))
    return tuple(rows)


def _mixture(y: Array, variance: Array) -> tuple[Array, Array, float]:
    """
    Return (means [C], variances [C], deviation between drives) of the prediction for a new one.

    Args:
        y: estimates [N].
        variance: of their errors [N].
    """
    floor = (SMALLEST * max(float(np.abs(y).max()), 1.0)) ** 2
    variance = np.maximum(variance, floor)
    count = len(y)
    if count == 1:
        return y.copy(), variance.copy(), math.nan

    def scatter(between: Array) -> tuple[Array, Array, Array]:
        """Return Q, the mean and its variance for variances [C] between drives."""
        weight = 1.0 / (variance[:, None] + between)
        total = weight.sum(axis=0)
        mean = (weight * y[:, None]).sum(axis=0) / total
        return (weight * (y[:, None] - mean) ** 2).sum(axis=0), mean, 1.0 / total
    q = chi2.ppf((np.arange(COMPONENTS) + 0.5) / COMPONENTS, count - 1)
    target = np.append(q, count - 1.0)  # the last one: the estimate by moments
    low = np.zeros(len(target))
    high = np.full(len(target), float(((y - y.mean()) ** 2).sum()) + floor) / target
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        more = scatter(middle)[0] > target
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    _, mean, least = scatter(high)
    return mean[:-1], (high + least)[:-1], math.sqrt(high[-1])


def _quantiles(means: Array, variances: Array, levels: Array) -> Array:
    """Return the quantiles at `levels` of a mixture of normals of equal weight."""
    deviations = np.sqrt(variances)
    low = np.full(len(levels), float((means - 10.0 * deviations).min()))
    high = np.full(len(levels), float((means + 10.0 * deviations).max()))
    for _ in range(HALVINGS // 2):
        middle = 0.5 * (low + high)
        below = ndtr((middle[:, None] - means) / deviations).mean(axis=1) < levels
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


def _between_correlation(y: Array, covariances: Array) -> Array:
    """
    Return the correlation [P, P] between drives, less what few drives show by chance.

    Shrunk towards none by the share that chance has in it (Schaefer and Strimmer, 2005).

    Args:
        y: estimates [N, P].
        covariances: of their errors [N, P, P].
    """
    count = len(y)
    scatter = np.cov(y, rowvar=False).reshape(y.shape[1], -1) - covariances.mean(axis=0)
    values, vectors = np.linalg.eigh(scatter)
    r = _normalised((vectors * np.maximum(values, 0.0)) @ vectors.T)
    off = ~np.eye(len(r), dtype=bool)
    chance = float(((1.0 - r[off] ** 2) ** 2).sum()) / (count - 1)
    seen = float((r[off] ** 2).sum())
    share = 1.0 if seen <= 0.0 else max(0.0, 1.0 - chance / seen)
    return np.where(off, share * r, 1.0)


def _normalised(covariance: Array) -> Array:
    """Return the correlation of a covariance [P, P]; none of what has no variance."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    inverse = np.where(deviation > 0.0, 1.0 / np.where(deviation > 0.0, deviation, 1.0), 0.0)
    r = np.clip(covariance * np.outer(inverse, inverse), -1.0, 1.0)
    np.fill_diagonal(r, 1.0)
    return np.asarray(r)
