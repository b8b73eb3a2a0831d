# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Backlash, stiffness, hysteresis and friction from a window of smoothed torque over twist.

One elastic_regression fits them together. Torque and model are averaged over pairs of neighbouring
groups of samples before they are compared: the noise of a smoothed torque is high-frequency. Each
group belongs to two pairs, so that nothing is lost between them. Fit on smoothed values only: the
filter's lag draws a hysteresis loop that is not there.

In a lost-motion test the input is locked and a torque turns the output. No drive moves, so no
filter is asked: the torque that is measured at the output, or that holds the input, depends on the
twist as

    torque = K dz(twist - zero, gap / 2) + F direction

by robust least squares, F what the bearings of the output brake. Each to and fro is one window.
"""
from collections.abc import Sequence
from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np
import scipy

from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.estimation.rts_smoother import (
    S_TAU_K, S_TAU_K_NOISE_STD, S_TWIST, S_TWIST_RATE_NOISE_STD, S_X2, S_X3, S_X4)
from gearbox_monitor.estimation.sample_loop import HUGE
from gearbox_monitor.health.alarms import LIMITS
from gearbox_monitor.health.elastic_regression import (
    BLOCKS, certainties, COLUMN_OF, COULOMB, D_FRICTION, D_TORQUE, D_TWIST, D_U, D_X3, data_of,
    ElasticLaw, GAIN, HALF_GAP, HEIGHT, N_DATA, N_SHAPE, Regression, STIFFNESS, VISCOUS, WIDTH,
    ZERO)
from gearbox_monitor.kernels.elementary import noise_levels
from gearbox_monitor.kernels.linear_least_squares import Damping
from gearbox_monitor.kernels.types import Array, Flags, Integers
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Quantity, Said

MAX_POINTS = 2500
GROUPS = 300       # of points; the fit compares averages of two neighbours
START_POINTS = 250
REWEIGHTS = 2
RULE = Damping(1e-3, 10.0, 1e-3, hopeless=1e5, relative=1e-12, level=True)  # differ by 1e10
TOLERANCE = 1e-7   # of the cost, for another step
ERRORS = [VISCOUS, COULOMB, GAIN]


@dataclass(frozen=True)
class Backlash:
    """
    Features of the window that ends at `stamp_ns`; *_std: standard deviations.

    gap: width of the twists at which no torque may pass (rad): 2 b, of a play 2 (b + c).
    stiffness in contact (N m/rad). hysteresis: height of the loop (N m), > 0 with the lower branch
    while the twist grows, < 0 the reverse. zero of the twist (rad). flank: share of
    samples on the less visited flank. coverage: how often the gap was crossed. viscous (N m
    s/rad), coulomb (N m): change of the motor's friction against the model; gain: relative change
    of its torque gain; NaN = not identifiable. lost_motion (rad): see lost_motion_of. separable:
    whether the window can tell gap and compliance apart; if not, gap and stiffness stand for each
    other and only the lost motion counts. angle: mean arm position (rad), speed: rms motor speed
    (rad/s), load: rms of the tau_K that was fitted (N m). width: half width of the play behind the
    hysteresis (rad), 0 where none is seen; passive: whether the loop is open in the gap, too
    (passive_play).
    """

    stamp_ns: int
    gap: float = math.nan
    gap_std: float = math.nan
    stiffness: float = math.nan
    stiffness_std: float = math.nan
    hysteresis: float = math.nan
    hysteresis_std: float = math.nan
    zero: float = math.nan
    flank: float = math.nan
    coverage: float = math.nan
    viscous: float = math.nan
    viscous_std: float = math.nan
    coulomb: float = math.nan
    coulomb_std: float = math.nan
    gain: float = math.nan
    gain_std: float = math.nan
    lost_motion: float = math.nan
    lost_motion_std: float = math.nan
    separable: bool = True
    angle: float = math.nan
    speed: float = math.nan
    load: float = math.nan
    width: float = 0.0
    passive: bool = False


@dataclass(frozen=True)
class NotExcited:
    """
    No gap in the window that ends at `stamp_ns`: `reason` is the code of what the motion lacks.

    numbers: of the reason, by name.
    lost_motion (rad): needs no torque and no stiffness; NaN where the motion does not show it.
    friction: of a motion on one flank, without gap and gain, None where there is none.
    """

    stamp_ns: int
    reason: str
    lost_motion: float = math.nan
    lost_motion_std: float = math.nan
    friction: Backlash | None = None
    numbers: dict[str, Any] = field(default_factory=dict)

    @property
    def said(self) -> Said:
        """The reason as an outcome says it."""
        return Said(self.reason, self.numbers)


def fit(rows: Array, model: DriveModel, stamp_ns: int) -> Backlash | NotExcited:
    """
    Return the features of a window by one robust regression (Huber weights, Levenberg-Marquardt).

    Args:
        rows: smoothed values [N, N_SMOOTHED] in order of time (columns rts_smoother.S_*).
        model: the drive that they were estimated with.
        stamp_ns: end of the window.

    Returns:
        The features, or NotExcited if the motion does not determine them.

    """
    reason = _missing(rows)
    if reason:
        return NotExcited(stamp_ns, reason, numbers={'count': len(rows)})
    points = rows[::max(1, len(rows) // MAX_POINTS)]
    group = max(1, len(points) // GROUPS)
    count = len(points) // group
    data = data_of(points, model)
    data[:, D_U] *= -1.0  # a torque gain above the model's is missing in the torque
    certain = _weights(points, model)
    weights = certain[:count * group].reshape(count, group).mean(axis=1)
    expected = _expected(data, model)
    regression = regression_of(data, group, weights.copy())

    def without_gap(reason: str) -> NotExcited:
        regression.weights[:] = weights
        return NotExcited(stamp_ns, reason, friction=_friction_on_one_flank(
            rows, stamp_ns, regression, expected, certain))

    if min(_loaded_shares(rows)) < LIMITS.flank:
        return without_gap('one_flank_loaded')
    start, variance = start_of(data)
    for loop in (True, False):  # a loop that leaves no flank is none
        try:
            fitted = fit_all(regression, start, variance, expected, loop)
        except np.linalg.LinAlgError:
            return NotExcited(stamp_ns, 'no_fit')
        theta = fitted.theta
        if not (np.isfinite(theta).all() and np.isfinite(fitted.covariance).all()):
            return NotExcited(stamp_ns, 'no_fit')
        half_width = theta[HALF_GAP] + (0.0 if fitted.passive else abs(theta[WIDTH]))
        side = sides_of(points[:, S_TWIST] - theta[ZERO], half_width)
        flank, traversals = visits_of(side)
        if flank >= LIMITS.flank or theta[WIDTH] == 0.0:
            break
        regression.weights[:] = weights
    if flank < LIMITS.flank:
        return without_gap('one_flank')
    if traversals < LIMITS.traversals:
        return NotExcited(stamp_ns, 'few_crossings', numbers={'count': traversals})
    variance = max(fitted.covariance[STIFFNESS, STIFFNESS], 0.0)
    if theta[STIFFNESS] <= LIMITS.deviations * math.sqrt(variance):
        return NotExcited(stamp_ns, 'no_stiffness')
    tau_k = _transmitted(data, theta)
    load = _rms(tau_k, certain)
    separable = all(
        _correlation(data[on, D_TWIST], tau_k[on], certain[on]) >= LIMITS.flank_correlation
        for on in (side == 1, side == -1))
    return _features(rows, stamp_ns, fitted, flank, traversals, separable, load)


def _transmitted(data: Array, theta: Array) -> Array:
    """Return tau_K [N] of the motor's side in `data` without the errors that `theta` names."""
    tau_k: Array = data[:, D_TORQUE] - data[:, [COLUMN_OF[i] for i in ERRORS]] @ theta[ERRORS]
    return tau_k


def _rms(values: Array, weights: Array | None = None) -> float:
    return math.sqrt(np.average(values ** 2, weights=weights))


def _missing(rows: Array) -> str:
    """Return the code of what `rows` lack before anything is fitted, '' for nothing."""
    if len(rows) < LIMITS.window_points:
        return 'few_samples'
    if not (np.abs(rows) < HUGE).all():  # NaN is not, either
        return 'implausible'
    if not np.ptp(rows[:, S_TWIST]) > 0.0:
        return 'no_twist'
    if max(_loaded_shares(rows)) < LIMITS.flank:
        return 'no_load'
    return ''


def _loaded_shares(rows: Array) -> tuple[float, float]:
    """Return the shares of samples that load the upper and the lower flank."""
    loaded = rows[:, S_TAU_K] / np.maximum(LIMITS.deviations * rows[:, S_TAU_K_NOISE_STD], 1e-300)
    return float((loaded > 1.0).mean()), float((loaded < -1.0).mean())


def _weights(rows: Array, model: DriveModel) -> Array:
    """Return weights [N] that fall where the speed may be 0, and friction anything."""
    doubt = LIMITS.deviations * float(np.median(rows[:, S_TWIST_RATE_NOISE_STD]))
    if model.coulomb_friction == 0.0 or doubt == 0.0:
        return np.ones(len(rows))
    weights = np.empty(len(rows))
    certainties(rows[:, S_X3], doubt, weights)
    return weights


def regression_of(data: Array, group: int, weights: Array) -> Regression:
    """
    Return the Regression of a window.

    Args:
        data: [N, N_DATA].
        group: samples that are averaged.
        weights: of the groups [N // group].

    """
    result = Regression.of(data, ElasticLaw(
        by_height=True, group=group, paired=True, block=-(-len(weights) // BLOCKS)), weights)
    span = float(np.ptp(data[:, D_TWIST]))
    result.high[HALF_GAP], result.high[WIDTH], result.low[WIDTH] = span, 0.5 * span, -0.5 * span
    return result


def start_of(data: Array) -> tuple[Array, float]:
    """Return (theta, variance of residuals) of a dead zone through every so many points."""
    points = np.ascontiguousarray(data[::max(1, len(data) // START_POINTS)])
    twist, tau_k = points[:, D_TWIST], points[:, D_TORQUE]
    span = float(np.ptp(twist))
    middle = 0.5 * float(twist.max() + twist.min())
    free = np.zeros(N_SHAPE, bool)
    free[[STIFFNESS, HALF_GAP, ZERO]] = True
    regression = regression_of(points, 1, np.ones(len(points)))
    chosen: Array = np.zeros(N_SHAPE)
    lowest_cost = math.inf
    for share in (0.1, 0.25, 0.4):  # the cost has a local minimum where a flank is missed
        theta = np.zeros(N_SHAPE)
        theta[HALF_GAP], theta[ZERO] = share * span, middle
        basis = np.sign(twist - middle) * np.maximum(np.abs(twist - middle) - share * span, 0.0)
        theta[STIFFNESS] = max(float(basis @ tau_k / max(basis @ basis, 1e-300)), 1e-12)
        cost, optimum = regression.solve(theta, free, RULE, TOLERANCE, 20)
        if cost < lowest_cost:
            chosen, lowest_cost = optimum.theta, cost
    return chosen, lowest_cost / len(points)


def _expected(data: Array, model: DriveModel) -> Array:
    """Return the standard deviations [N_SHAPE] expected of the changes, inf for the rest."""
    load, speed = (float(np.sqrt(np.mean(data[:, i] ** 2))) for i in (D_TORQUE, D_X3))
    expected = np.full(N_SHAPE, np.inf)
    if speed > 0.0:
        expected[VISCOUS] = math.hypot(LIMITS.friction_prior * model.viscous_friction,
                                       LIMITS.torque_share * load / speed)
    expected[COULOMB] = math.hypot(LIMITS.friction_prior * model.coulomb_friction,
                                   LIMITS.torque_share * load)
    expected[GAIN] = LIMITS.gain_prior
    return expected


@dataclass(frozen=True)
class _Fit:
    """Parameters and covariance; both with the width free; what was fitted."""

    theta: np.ndarray
    covariance: np.ndarray
    theta_free: np.ndarray
    covariance_free: np.ndarray
    passive: bool
    gain: bool
    loop: bool


def fit_all(regression: Regression, theta: Array, variance: float, expected: Array,
            loop: bool, gap: bool = True) -> _Fit:
    """
    Return the _Fit: robust, the torque gain and the hysteresis only where they are seen.

    Args:
        regression: of the window.
        theta: start [N_SHAPE].
        variance: of the residuals there.
        expected: standard deviations of the changes [N_SHAPE], see _expected.
        loop: whether a hysteresis is looked for.
        gap: whether the gap is; otherwise it stays that of `theta`.

    Returns:
        The _Fit.

    """
    base = regression.weights.copy()
    free = np.zeros(N_SHAPE, bool)
    free[[STIFFNESS, ZERO]], free[WIDTH], free[HALF_GAP] = True, loop, gap
    for error in ERRORS:
        free[error] = regression.data[:, COLUMN_OF[error]].any()

    def refit(theta: Array, free: Flags, rounds: int = 0, law: ElasticLaw = regression.law
              ) -> tuple[Array, Array]:
        nonlocal variance
        for i in range(rounds + 1):
            regression.prior[:] = variance / expected ** 2
            _, optimum = regression._replace(law=law).solve(theta, free, RULE, TOLERANCE, 30)
            theta = optimum.theta
            if i < rounds:
                size = np.abs(regression.residuals)
                scale = 1.4826 * float(np.median(size))
                variance = scale ** 2
                regression.weights[:] = base / np.maximum(1.0,
                                                          size / max(LIMITS.huber * scale, 1e-300))
        return theta, optimum.covariance(variance)

    theta, covariance = refit(theta, free, rounds=REWEIGHTS)
    gain = bool(free[GAIN]) and \
        math.sqrt(max(covariance[GAIN, GAIN], 0.0)) < LIMITS.identified * expected[GAIN]
    if free[GAIN] and not gain:
        free[GAIN], theta = False, theta.copy()
        theta[GAIN] = 0.0
        theta, covariance = refit(theta, free)
    theta_free, covariance_free = theta, covariance
    width, doubt = theta[WIDTH], LIMITS.deviations * math.sqrt(max(covariance[WIDTH, WIDTH], 0.0))
    if width < -doubt:
        passive_theta = theta.copy()
        passive_theta[WIDTH], passive_theta[HEIGHT] = -width, -width * theta[STIFFNESS]
        passive_free = free.copy()
        passive_free[HEIGHT] = True
        weights, off = regression.weights.copy(), np.median(np.abs(regression.residuals))
        regression.weights[:] = base  # those at hand belong to residuals of the other structure
        low = regression.low[WIDTH]
        regression.low[WIDTH] = 2e-3 * regression.high[WIDTH]  # its slope is undefined at 0
        passive_theta, passive_covariance = refit(
            passive_theta, passive_free, REWEIGHTS, regression.law._replace(passive=True))
        regression.low[WIDTH] = low
        if np.median(np.abs(regression.residuals)) < off:
            return _Fit(passive_theta, passive_covariance, passive_theta, passive_covariance,
                        True, gain, loop)
        regression.weights[:] = weights
    # Shrunk towards none, without a jump: a loop that is not seen adds noise to the gap only.
    theta = theta.copy()
    theta[WIDTH] = width - doubt ** 2 / width if abs(width) > doubt else 0.0
    less = free.copy()
    less[WIDTH] = False
    theta, covariance = refit(theta, less)
    if theta[WIDTH] != 0.0:
        covariance = covariance_free
    return _Fit(theta, covariance, theta_free, covariance_free, False, gain, loop)


def _friction_on_one_flank(rows: Array, stamp_ns: int, regression: Regression, expected: Array,
                           certain: Array) -> Backlash | None:
    """
    Return the friction of a motion on one flank; None where it does not determine the friction.

    Args:
        rows: of the window, see fit.
        stamp_ns: its end.
        regression: of it; the other flank is put out of its reach.
        expected: standard deviations of the changes [N_SHAPE], see _expected.
        certain: weights of the samples, see _weights.

    Returns:
        The features, without gap and gain.

    """
    twist, torque = regression.data[:, D_TWIST], regression.data[:, D_TORQUE]
    theta, span = np.zeros(N_SHAPE), float(np.ptp(twist))
    theta[HALF_GAP] = span
    theta[ZERO] = twist.min() - span if torque.sum() > 0.0 else twist.max() + span
    centred = twist - twist.mean()
    theta[STIFFNESS] = max(float(centred @ torque / max(centred @ centred, 1e-300)), 1e-12)
    variance = float(np.var(torque - theta[STIFFNESS] * twist))
    try:
        fitted = fit_all(regression, theta, variance, expected, loop=False, gap=False)
    except np.linalg.LinAlgError:
        return None
    theta, std = fitted.theta, np.sqrt(np.maximum(np.diag(fitted.covariance), 0.0))
    if not (np.isfinite(theta).all() and 0.0 < std[COULOMB]
            < LIMITS.identified * expected[COULOMB]):
        return None
    of, std_of = theta.tolist(), std.tolist()
    return Backlash(
        stamp_ns, viscous=of[VISCOUS], viscous_std=std_of[VISCOUS], coulomb=of[COULOMB],
        coulomb_std=std_of[COULOMB], angle=float(rows[:, S_X2].mean()), speed=_rms(rows[:, S_X3]),
        load=_rms(_transmitted(regression.data, theta), certain))


def _features(rows: Array, stamp_ns: int, fitted: _Fit, flank: float, traversals: int,
              separable: bool, load: float) -> Backlash:
    theta, covariance = fitted.theta, fitted.covariance
    hidden = [] if rows[:, S_X3].any() else [VISCOUS, COULOMB]
    hidden += [] if fitted.gain else [GAIN]
    value, std = theta.copy(), np.sqrt(np.maximum(np.diag(covariance), 0.0))
    value[hidden] = std[hidden] = math.nan
    to_gap, to_height = np.zeros((2, N_SHAPE))
    to_gap[HALF_GAP], to_gap[WIDTH] = 2.0, 0.0 if fitted.passive else 2.0 * np.sign(theta[WIDTH])
    k, c = fitted.theta_free[STIFFNESS], fitted.theta_free[WIDTH]
    if fitted.passive:
        hysteresis, to_height[HEIGHT] = -2.0 * theta[HEIGHT], -2.0
    else:
        hysteresis, to_height[STIFFNESS], to_height[WIDTH] = 2.0 * k * c, 2.0 * c, 2.0 * k
    hysteresis_std = math.sqrt(max(to_height @ fitted.covariance_free @ to_height, 0.0))
    if not fitted.loop:
        hysteresis = hysteresis_std = math.nan
    lost_motion, lost_motion_std = lost_motion_of(rows)
    gap_std = math.sqrt(max(to_gap @ covariance @ to_gap, 0.0))
    if not separable:  # what the load twists on both flanks may be gap as well
        gap_std = math.hypot(gap_std, 2.0 * load / theta[STIFFNESS])
        std[STIFFNESS] = theta[STIFFNESS]
    of, std_of = value.tolist(), std.tolist()
    return Backlash(
        stamp_ns, float(to_gap @ theta), gap_std, of[STIFFNESS], std_of[STIFFNESS],
        float(hysteresis), float(hysteresis_std), of[ZERO], flank, float(traversals),
        of[VISCOUS], std_of[VISCOUS], of[COULOMB], std_of[COULOMB], of[GAIN], std_of[GAIN],
        lost_motion, lost_motion_std, separable,
        angle=float(rows[:, S_X2].mean()), speed=_rms(rows[:, S_X3]), load=load,
        width=float(abs(theta[WIDTH])), passive=fitted.passive)


def shows_motion(rows: Array) -> bool:
    """Return whether `rows` are enough, and values of a drive, for lost_motion_of."""
    return len(rows) >= LIMITS.window_points and bool((np.abs(rows) < HUGE).all())


def lost_motion_of(rows: Array) -> tuple[float, float]:
    """
    Return (lost motion, standard deviation) of `rows` in rad, (nan, nan) where not defined.

    Median of the twist while the arm moves up minus that while it moves down; no torque needed.
    Defined where the twist follows the direction of motion: slow motion against friction.
    """
    twist, speed = rows[:, S_TWIST], rows[:, S_X4]
    moving = np.abs(speed) > 0.2 * float(np.sqrt(np.mean(speed ** 2)))
    up, down = moving & (speed > 0.0), moving & (speed < 0.0)
    if min(up.mean(), down.mean()) < 0.1:
        return math.nan, math.nan
    high, low = float(np.median(twist[up])), float(np.median(twist[down]))
    middle = 0.5 * (high + low)
    agree = (np.sign(twist[moving] - middle) == np.sign(high - low) * np.sign(speed[moving]))
    if agree.mean() < LIMITS.one_sided:
        return math.nan, math.nan
    # Strokes are independent, samples are not.
    direction = np.sign(speed[moving])
    strokes = np.split(np.column_stack([twist[moving], direction]),
                       np.flatnonzero(np.diff(direction)) + 1)
    medians = {s: [float(np.median(part[:, 0])) for part in strokes
                   if part[0, 1] == s and len(part) >= 0.02 * len(direction)] for s in (1.0, -1.0)}
    variance = 0.0
    for s, chosen in ((1.0, up), (-1.0, down)):
        n = max(len(medians[s]), 1)
        spread = float(np.std(medians[s], ddof=1)) if n > 1 else 0.5 * float(np.std(twist[chosen]))
        variance += spread ** 2 / n
    return abs(high - low), math.sqrt(variance)


def _correlation(twist: Array, tau_k: Array, weights: Array) -> float:
    """Return the correlation of torque and twist, 0 where one of them is constant or missing."""
    if not weights.sum() > 0.0:
        return 0.0
    twist, tau_k = (v - np.average(v, weights=weights) for v in (twist, tau_k))
    both = float((weights @ twist ** 2) * (weights @ tau_k ** 2))
    return float(weights @ (twist * tau_k)) / math.sqrt(both) if both > 0.0 else 0.0


def visits_of(sides: Integers) -> tuple[float, int]:
    """Return the share on the less visited flank of `sides` [N], and how often they cross."""
    return (float(min((sides > 0).mean(), (sides < 0).mean())),
            int(np.count_nonzero(np.diff(sides[sides != 0]))))


def sides_of(twist: Array, half_width: float) -> Integers:
    """Return 1, 0 or -1 [N]: on the upper flank, in the gap, on the lower flank."""
    return np.where(twist > half_width, 1, np.where(twist < -half_width, -1, 0))


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


def width_of(width: float | None, std: float | None, unit: str = 'rad') -> Quantity:
    """
    Return the width of a window, as all texts state it.

    Args:
        width: backlash or lost motion, in `unit`.
        std: its standard deviation in the window; that of the method is added.
        unit: rad or m.
    """
    return Quantity(width, math.hypot(std or 0.0, LIMITS.gap_error * (width or 0.0)), unit)


def separable_of(fits: Sequence[Backlash]) -> tuple[list[Backlash], bool]:
    """
    Return (windows that count, whether they tell gap and compliance apart).

    fits: of the windows. Where most windows cannot, all those with features count.
    """
    excited = [w for w in fits if isinstance(w, Backlash)]
    clear = [w for w in excited if w.separable]
    separable = 2 * len(clear) > len(excited)
    return (clear if separable else excited), separable


def reason_of(fits: Sequence[NotExcited]) -> Said:
    """Return what the motion of windows `fits` lacks, of which none has features."""
    reasons = [w.reason for w in fits]
    return max(fits, key=lambda w: reasons.count(w.reason)).said if fits else Said('no_window')


LEAST = 200        # samples of a test
LOCKED_POINTS = 4000


def is_locked(samples: Samples) -> bool:
    """Return whether the input of `samples` stands still while the output turns."""
    y = samples.y[np.isfinite(samples.y).all(axis=1)]
    if len(y) < LEAST:
        return False
    sigma, quantum = noise_levels(y)
    motor, arm = np.ptp(y, axis=0)
    return bool(motor <= LIMITS.locked_share * arm
                and motor <= LIMITS.locked_noise * sigma[0] + 2.0 * quantum[0] + 1e-12
                and arm > LIMITS.locked_noise * sigma[1] + 2.0 * quantum[1])


def locked_windows(samples: Samples) -> list[Backlash | NotExcited]:
    """
    Return the features of a lost-motion test.

    Args:
        samples: of a drive whose input is locked, on the arm side.
    """
    last = int(samples.stamp_ns[-1])
    torque = _torque(samples)
    if torque is None:
        return [NotExcited(last, 'locked')]
    good = np.isfinite(samples.y).all(axis=1) & np.isfinite(torque)
    t = (samples.stamp_ns[good] - samples.stamp_ns[good][0]) * 1e-9
    twist, torque = samples.y[good, 0] - samples.y[good, 1], torque[good]
    # The direction: of the twist without its noise, over a fiftieth of the test.
    width = max(3, len(t) // 50)
    smooth = scipy.ndimage.uniform_filter1d(twist, width)
    rate = np.gradient(smooth, t)
    direction = np.tanh(3.0 * rate / max(float(np.sqrt(np.mean(rate ** 2))), 1e-300))
    # Noise of the twist on both sides of the slope would flatten it.
    twist = scipy.ndimage.uniform_filter1d(twist, max(1, width // 10))
    fits: list[Backlash | NotExcited] = []
    for part in _strokes(smooth):
        fits.append(_fit(twist[part], torque[part], direction[part],
                         int(samples.stamp_ns[good][part][-1])))
    return fits or [NotExcited(last, 'locked_flank')]


def _torque(samples: Samples) -> Array | None:
    """Return the torque [N] that the gearbox transmits, None where none is measured."""
    arm, motor = -samples.u[:, 1], samples.u[:, 0]
    for torque in (arm, motor):
        if np.isfinite(torque).any() and np.nanstd(torque) > 0.0:
            return torque
    return None


def _strokes(twist: Array) -> list[slice]:
    """Return the parts of a smooth `twist` [N] that go from one side to the other and back."""
    low, high = np.percentile(twist, (2, 98))
    middle, side = 0.5 * (low + high), 0.35 * (high - low)
    reached = np.sign(twist - middle) * (np.abs(twist - middle) > side)
    at = np.flatnonzero(reached)
    ends = at[1:][np.diff(reached[at]) != 0]
    if len(ends) < 2:
        return [slice(0, len(twist))] if len(ends) else []
    edges = [0, *ends[2::2].tolist(), len(twist)]
    if len(edges) > 2 and edges[-1] - edges[-2] < 0.5 * (edges[1] - edges[0]):
        del edges[-2]
    return [slice(a, b) for a, b in zip(edges, edges[1:])]


def _fit(twist: Array, torque: Array, direction: Array, stamp_ns: int) -> Backlash | NotExcited:
    """Return the features of one to and fro [N]."""
    rows = slice(None, None, max(1, len(twist) // LOCKED_POINTS))
    x, d = twist[rows], direction[rows]
    data = np.zeros((len(x), N_DATA))
    data[:, D_TWIST], data[:, D_FRICTION], data[:, D_TORQUE] = x, d, torque[rows]
    data[:, D_U] = 1.0  # its gain is an offset of the torque
    fitted = fit_all(regression_of(data, 1, np.ones(len(x))), *start_of(data),
                     np.full(N_SHAPE, np.inf), loop=False)
    theta, std = fitted.theta, np.sqrt(np.maximum(np.diag(fitted.covariance), 0.0))
    side = sides_of(x - theta[ZERO], theta[HALF_GAP])
    flank, traversals = visits_of(side)
    if flank < LIMITS.flank or not theta[STIFFNESS] > 0.0:
        return NotExcited(stamp_ns, 'locked_flank')
    up, down = x[d > 0.5], x[d < -0.5]
    lost_motion = abs(float(np.median(up)) - float(np.median(down))) if (
        len(up) and len(down)) else math.nan
    gap_std = 2.0 * float(std[HALF_GAP])
    return Backlash(
        stamp_ns, 2.0 * float(theta[HALF_GAP]), gap_std, float(theta[STIFFNESS]),
        float(std[STIFFNESS]), zero=float(theta[ZERO]), flank=flank,
        coverage=float(traversals),
        coulomb=float(abs(theta[COULOMB])), coulomb_std=float(std[COULOMB]),
        lost_motion=lost_motion, lost_motion_std=gap_std)
