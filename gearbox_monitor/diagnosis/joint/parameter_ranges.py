# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Ranges of parameters over a population of drives, and values that recordings of one drive share.

A random effect is a value of one drive that differs between its recordings by a stated scatter.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
import math

import numpy as np
import scipy

from gearbox_monitor.diagnosis.joint.candidates import BY_EFFECT, CandidateModel, NUISANCES
from gearbox_monitor.diagnosis.joint.decision import standard_errors
from gearbox_monitor.diagnosis.joint.innovations import fitted, JointLikelihood, unfitted
from gearbox_monitor.diagnosis.joint.nominal import FittedValue
from gearbox_monitor.diagnosis.joint.torque_domain import likelihood_of
from gearbox_monitor.diagnosis.settings import STATEMENTS
from gearbox_monitor.errors import expect_whole, InputError
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.plant.effects import library
from gearbox_monitor.presentation import Saved, Shown
from gearbox_monitor.signals.uniform import UniformRecording

CONFIDENCE = 0.9
NORMAL = 1.6448536269514722  # deviations of a normal that hold CONFIDENCE
COMPONENTS = 200  # of the mixture over the variance between drives
HALVINGS = 60     # of an interval that holds a root
ENDS = np.array([0.05, 0.5, 0.95])  # levels of low, centre, high
PART = 0.3        # of a direction, from which a parameter counts as part of it
SMALLEST = 1e-12  # relative error of a value that has none
LARGEST = 1e6     # relative error of a value on the scale of logarithms


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

    @classmethod
    def of(cls, name: str, values: Sequence[FittedValue], covariance: Array | None
           ) -> 'UnitEstimate':
        """
        Return the estimate of a fit.

        Args:
            name: of it.
            values: of the fit [P].
            covariance: [P, P] of their errors, None where they count as independent.
        """
        if covariance is None:
            covariance = np.diag([v.error ** 2 for v in values])
        return cls(name, {v.name: v.value for v in values}, {v.name: v.unit for v in values},
                   covariance)


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

    names, units: of the parameters [P]. logarithmic [P]: whether a parameter cannot be negative,
    and has its distribution on the scale of logarithms (a normal one, cut off at 0, where an
    estimate is 0). centre, low, high [P]: median and 90 % range.
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

    def sample(self, count: int, seed: int = 0) -> dict[str, Array]:
        """
        Return sets of parameters of new drives, correlated as the estimates are.

        On the scale of a parameter either side of the median is that of a normal.

        Args:
            count: number of drives N, 1 at least.
            seed: of the draw; same seed, same drives.

        Returns:
            {parameter: [N]}, in its unit.

        Raises:
            InputError: count or seed is no such number.
        """
        expect_whole(count, 'count', 1)
        expect_whole(seed, 'seed')
        normal = np.random.default_rng(seed).standard_normal((count, len(self.names)))
        drawn = {}
        for name, step, logarithmic, *ends in zip(
                self.names, (normal @ self.factor.T).T / NORMAL, self.logarithmic, self.low,
                self.centre, self.high):
            low, centre, high = np.log(ends) if logarithmic else ends
            value = centre + step * np.where(step < 0.0, centre - low, high - centre)
            drawn[name] = np.exp(value) if logarithmic else (
                value if is_signed(name) else np.maximum(value, 0.0))
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
        InputError: no estimate, or no parameter that all have; numbers that are no estimate, or
            units that differ.
    """
    names, remarks = _common_names(estimates)
    units = [_common_unit(estimates, name) for name in names]
    y, covariances, size, logarithmic = _comparable(estimates, names)
    spread, directions = np.linalg.eigh(covariances.mean(axis=0))
    unknown = spread > STATEMENTS.determined ** 2
    along, variance = directions[:, unknown], spread[unknown]
    # Where nothing is known, all estimates may err alike: their mean errs as each does.
    common = (along * variance) @ along.T
    alike, errors = np.diag(common), np.einsum('njj->jn', covariances)
    ends = np.empty((3, len(names)))
    for j, own in enumerate(np.maximum(errors - alike[:, None], 0.0)):
        means, differences, errors_left, _ = mixture(y[:, j], own)
        ends[:, j] = _quantiles(means, differences + errors_left + alike[j], ENDS)
    between = np.array([mixture(*row)[3] for row in zip(y.T, errors)])
    if len(estimates) == 1:
        correlation = _normalised(covariances[0])
    else:
        # Of the difference between drives, and of the error of their mean.
        determined = _normalised(
            _between_correlation(y, covariances) * np.outer(between, between)
            + (covariances.mean(axis=0) - common) / len(estimates))
        deviation = np.sqrt(np.maximum(
            ((ends[2] - ends[0]) / (2.0 * NORMAL)) ** 2 - alike, 0.0))
        correlation = _normalised(determined * np.outer(deviation, deviation) + common)
    ends *= size
    cut = ~logarithmic & ~np.array(list(map(is_signed, names)))
    ends[:, cut] = np.maximum(ends[:, cut], 0.0)
    low, middle, high = np.where(logarithmic, np.exp(np.where(logarithmic, ends, 0.0)), ends)
    return ParameterRanges(
        tuple(names), tuple(units), tuple(map(bool, logarithmic)), middle, low, high,
        between * size, correlation, _combinations(names, along, variance),
        tuple(e.name for e in estimates), (*notes, *remarks))


def _common_names(estimates: Sequence[UnitEstimate]) -> tuple[list[str], list[str]]:
    """Return (names of the parameters that all estimates have, remarks on what they lack)."""
    if not estimates:
        raise InputError('estimates: none, expected one or several')
    for estimate in estimates:
        _check(estimate)
    remarks, every = [], dict.fromkeys(chain(*(e.values for e in estimates)))
    names = [name for name in every if all(name in e.values for e in estimates)]
    dropped = [name for name in every if name not in names]
    if dropped:
        remarks.append(f'{", ".join(dropped)}: not in every estimate, no range')
    if not names:
        raise InputError(f'{", ".join(e.name for e in estimates)}: no parameter in common, '
                         'expected estimates of the same parameters')
    if len(estimates) == 1:
        remarks.append('one estimate: the range is that of its error, and says nothing about '
                       'other drives')
    return names, remarks


def _comparable(estimates: Sequence[UnitEstimate], names: Sequence[str]
                ) -> tuple[Array, Array, Array, Flags]:
    """
    Return (values [N, P], covariances [N, P, P], their sizes [P], which are logarithms [P]).

    Parameters that may be negative are in shares of their size, so that directions compare.
    """
    places = [[list(e.values).index(name) for name in names] for e in estimates]
    values = np.array([[e.values[name] for name in names] for e in estimates], float)
    covariances = np.array([np.asarray(e.covariance, float)[np.ix_(at, at)]
                            for e, at in zip(estimates, places)])
    logarithmic = ~np.array(list(map(is_signed, names))) & (values > 0.0).all(axis=0)
    slope = np.where(logarithmic, values, 1.0)
    y = np.where(logarithmic, np.log(slope), values)
    covariances = covariances / (slope[:, :, None] * slope[:, None, :])
    errors = np.sqrt(np.einsum('njj->nj', covariances).mean(axis=0))
    size = np.where(logarithmic, 1.0, np.maximum(np.abs(values).max(axis=0), errors))
    size = np.where(size > 0.0, size, 1.0)
    return y / size, covariances / np.outer(size, size), size, logarithmic


def is_signed(name: str) -> bool:
    """
    Return whether a parameter may be negative.

    Args:
        name: of a value of fit model, or EFFECT.PARAMETER.

    Raises:
        InputError: no parameter of a drive.
    """
    if name in NUISANCES or name == 'kt':  # a factor on the torque, not the change of it
        return False
    if name.startswith('payload.'):  # of a robot, beyond its file: also less
        return True
    effect, _, own = '.'.join(BY_EFFECT.get(name, (name,))).partition('.')
    for parameter in library()[effect].parameters if effect in library() else ():
        if parameter.name == own:
            return parameter.low < 0.0
    raise InputError(f'{name[:40]!r}, expected the name of a value of a drive or EFFECT.PARAMETER')


def _check(estimate: UnitEstimate) -> None:
    """Raise InputError unless an estimate has numbers that its parameters and errors can be."""
    covariance = np.asarray(estimate.covariance, float)
    for i, (name, value) in enumerate(estimate.values.items()):
        where = f'{estimate.name}: {name}'
        if not (math.isfinite(value) and np.isfinite(covariance[i]).all()):
            raise InputError(f'{where}: {value!r} or its error is not finite, expected numbers')
        try:
            signed = is_signed(name)
        except InputError as error:
            raise InputError(f'{estimate.name}: {error}') from None
        if value < 0.0 and not signed:
            raise InputError(f'{where}: {value:g}, expected no negative number')
        if value and not signed and covariance[i, i] > (LARGEST * value) ** 2:
            raise InputError(f'{where}: {value:g} +- {math.sqrt(covariance[i, i]):g}, expected an '
                             f'error of at most {LARGEST:g} times the value')
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    tolerance = 1e-6 * np.outer(size, size)
    if ((np.diag(covariance) < 0.0).any() or (np.abs(covariance - covariance.T) > tolerance).any()
            or (np.abs(covariance) > np.outer(size, size) + tolerance).any()):
        raise InputError(f'{estimate.name}: covariance: neither symmetric nor positive, expected '
                         'that of the errors')


def _common_unit(estimates: Sequence[UnitEstimate], name: str) -> str:
    """Return the unit of a parameter. Raises InputError where estimates differ in it."""
    units = {e.units[name]: e.name for e in estimates if name in e.units}
    if len(units) > 1:
        raise InputError(f'{name}: ' + ', '.join(
            f'{unit or "no unit"} in {source}' for unit, source in units.items())
            + ', expected one unit')
    return next(iter(units), '')


def _combinations(names: Sequence[str], along: Array, variance: Array) -> tuple[Combination, ...]:
    """Return the directions [P, D] without a value, the widest first, in words."""
    rows = []
    for k in np.argsort(variance)[::-1]:
        direction = along[:, k] * np.sign(along[np.argmax(np.abs(along[:, k])), k])
        rows.append(Combination({name: float(weight) for name, weight in zip(names, direction)
                                 if abs(weight) > PART}, math.sqrt(variance[k])))
    return tuple(rows)


def mixture(y: Array, variance: Array) -> tuple[Array, Array, Array, float]:
    """
    Return what a new drive may have: a mixture of normals, and the deviation between drives.

    That is (means [C], variances between drives [C], variances of the means [C], deviation).

    Args:
        y: estimates [N].
        variance: of their errors [N].
    """
    floor = (SMALLEST * max(float(np.abs(y).max()), 1.0)) ** 2
    variance = np.maximum(variance, floor)
    count = len(y)
    if count == 1:
        return y.copy(), np.zeros(1), variance.copy(), math.nan

    def scatter(between: Array) -> tuple[Array, Array, Array]:
        """Return Q, the mean and its variance for variances [C] between drives."""
        weight = 1.0 / (variance[:, None] + between)
        total = weight.sum(axis=0)
        mean = (weight * y[:, None]).sum(axis=0) / total
        return (weight * (y[:, None] - mean) ** 2).sum(axis=0), mean, 1.0 / total
    q = scipy.stats.chi2.ppf((np.arange(COMPONENTS) + 0.5) / COMPONENTS, count - 1)
    target = np.append(q, count - 1.0)  # the last one: the estimate by moments
    low = np.zeros(len(target))
    none = scatter(low)[0] <= target
    high = np.full(len(target), float(((y - y.mean()) ** 2).sum()) + floor) / target
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        excessive = scatter(middle)[0] > target
        low, high = np.where(excessive, middle, low), np.where(excessive, high, middle)
    high[none] = 0.0
    _, mean, spread_at_high = scatter(high)
    return mean[:-1], high[:-1], spread_at_high[:-1], math.sqrt(high[-1])


def _quantiles(means: Array, variances: Array, levels: Array) -> Array:
    """Return the quantiles at `levels` of a mixture of normals of equal weight."""
    deviations = np.sqrt(variances)
    low = np.full(len(levels), float((means - 10.0 * deviations).min()))
    high = np.full(len(levels), float((means + 10.0 * deviations).max()))
    for _ in range(HALVINGS // 2):
        middle = 0.5 * (low + high)
        lower = scipy.special.ndtr((middle[:, None] - means) / deviations).mean(axis=1) < levels
        low, high = np.where(lower, middle, low), np.where(lower, high, middle)
    return 0.5 * (low + high)


def _between_correlation(y: Array, covariances: Array) -> Array:
    """
    Return the correlation [P, P] between drives, less what few drives show by chance.

    Shrunk towards none by the share that chance has in it (Schaefer and Strimmer, 2005): of
    drives without a correlation r^2 is 1 / (N - 1) in the mean, so that two show none.

    Args:
        y: estimates [N, P].
        covariances: of their errors [N, P, P].
    """
    count = len(y)
    scatter = np.cov(y, rowvar=False).reshape(y.shape[1], -1) - covariances.mean(axis=0)
    values, vectors = np.linalg.eigh(scatter)
    r = _normalised((vectors * np.maximum(values, 0.0)) @ vectors.T)
    off = ~np.eye(len(r), dtype=bool)
    chance = float(off.sum()) / (count - 1)
    power = float((r[off] ** 2).sum())
    share = 1.0 if power <= 0.0 else max(0.0, 1.0 - chance / power)
    return np.where(off, share * r, 1.0)


def _normalised(covariance: Array) -> Array:
    """Return the correlation of a covariance [P, P]; none of what has no variance."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    inverse = np.where(deviation > 0.0, 1.0 / np.where(deviation > 0.0, deviation, 1.0), 0.0)
    r = np.clip(covariance * np.outer(inverse, inverse), -1.0, 1.0)
    np.fill_diagonal(r, 1.0)
    return np.asarray(r)


EXACT = 1e-9   # relative error of a value that has none


@dataclass(frozen=True)
class RandomEffect:
    """
    A value of a drive: mean over recordings with its 90 % range `low` to `high`.

    between: standard deviation from recording to recording. recordings, errors: value and standard
    error of each alone.
    """

    mean: float
    low: float
    high: float
    between: float
    recordings: list[float]
    errors: list[float]


def pooled(values: Sequence[float], errors: Sequence[float]) -> RandomEffect:
    """
    Return the RandomEffect of a value that was measured several times.

    Args:
        values: of each recording [N], N >= 2.
        errors: their standard errors [N].
    """
    y, variance = np.array(values, float), np.array(errors, float) ** 2
    variance = np.maximum(variance, (EXACT * max(float(np.abs(y).max()), EXACT)) ** 2)
    between = mixture(y, variance)[3]
    weight = 1.0 / (variance + between ** 2)
    mean = float(weight @ y / weight.sum())
    scatter = float(weight @ (y - mean) ** 2) / (len(y) - 1)  # 1 where drives differ
    reach = float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(y) - 1)) * math.sqrt(
        scatter / weight.sum())
    return RandomEffect(mean, mean - reach, mean + reach, between, y.tolist(),
                        [float(e) for e in errors])


def between_recordings(recordings: Sequence[UniformRecording], candidate: CandidateModel, z: Array,
                       sigma: Array) -> dict[str, dict[str, RandomEffect]]:
    """
    Return {id: {parameter: RandomEffect}} of the effects of a candidate.

    Args:
        recordings: of one drive, which the torque or a setpoint drives; two or more.
        candidate: model with its coordinates.
        z: coordinates [P] of the fit to all recordings.
        sigma: noise of the encoders [2], rad.
    """
    measured: dict[str, dict[str, list[tuple[float, float]]]] = {
        name: {} for name in candidate.ids}
    for recording in recordings:
        likelihood = JointLikelihood([likelihood_of(recording, candidate.nominal, sigma,
                                                    [recording.span])])
        fit = fitted(likelihood, unfitted(likelihood, candidate, z))
        errors, _ = standard_errors(likelihood, fit)
        for name, values in zip(candidate.ids, candidate.values(fit.z)[1]):
            for key, error in errors[name].items():
                if isinstance(values.get(key), float):
                    measured[name].setdefault(key, []).append((values[key], error))
    return {name: {key: pooled(*zip(*pairs)) for key, pairs in rows.items()}
            for name, rows in measured.items()}
