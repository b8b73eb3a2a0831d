# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find R and Q of a filter from a recording, without any truth.

R comes from a stretch in which both shafts stand still, if the recording has one. The search finds
the other parameters by maximising the log-likelihood of the innovations over the logarithms of the
parameters. The search starts from numbers taken from the recording, never from the parameters in
force: so the result does not depend on them. Those numbers also carry a weak prior (a factor of 30
costs half a unit of log-likelihood), which decides only what the recording leaves open.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import TypeAlias

import numpy as np
import scipy

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.sensor_noise import MAD_TO_SIGMA, quantisation_step, white_noise_std
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.parameters import CURVES, EstimatorParameters, MIXED

BURN_IN = 0.5            # s after a start that do not count
MIN_SECONDS, MIN_SAMPLES = 5.0, 1000
STILL_SECONDS, STILL_SAMPLES = 0.5, 200
COARSE_SECONDS = 6.0     # the starts are compared on so much of the recording
FINE_SECONDS = 20.0      # ... and the rest of the search is done on so much
EXCITED = 5.0            # motion in units of the encoder noise
PRIOR = math.log(30.0)
REACH = math.log(1e4)    # the search stays within this factor of its first guess
AGREE = 5.0              # log-likelihood by which agreeing starts may differ
SLOPE_STEP = 0.03         # of the logarithms, for slopes
SHARP = 0.05             # a parameter is well determined below this relative error
# Of a parameter that is searched alone: grid and accuracy, logarithms over the guess.
GRID = tuple(math.log(10.0) * k / 2.0 for k in range(-4, 4))
ACCURACY = 0.1
DIVERGED = -1e9          # what a filter gets that cannot run at all

R_NAMES = ('r_std_motor', 'r_std_arm')
SPEED_NAMES = ('q_std_motor_speed', 'q_std_arm_speed')
TORQUE_NAMES = WALK, DEVIATION = ('q_std_tau_k', 'q_std_tau_k_deviation')

# (trials as {name: value}, coarse) -> (criterion, diverged) of each; see search.
Evaluate: TypeAlias = Callable[[Sequence[Mapping[str, float]], bool], list[tuple[float, bool]]]


@dataclass(frozen=True)
class EncoderMotion:
    """
    How a recording moves, and how noisy its encoders are.

    noise: standard deviations [2] of the encoders (rad); seconds: usable length; speed: rms [2]
    of motor and arm (rad/s); torque: rms of the motor torque without its mean (N m);
    standstill_noise: [2] (rad) while both shafts stand still, or None; standstill_seconds: how
    long that was.
    """

    noise: tuple[float, ...]
    seconds: float
    speed: tuple[float, ...]
    torque: float
    standstill_noise: tuple[float, ...] | None
    standstill_seconds: float


@dataclass
class Tuned:
    """
    The result of a search.

    parameters {name: value}; error {name: relative standard error} where the curvature gives it;
    value: of the criterion; evaluations, failed: how many filter runs, and how many diverged;
    starts, agreeing_starts: how many starts there were, and how many ended at the same optimum,
    within `spread` (relative, largest over the parameters that are well determined).
    """

    parameters: dict[str, float]
    value: float
    error: dict[str, float] = field(default_factory=dict)
    evaluations: int = 0
    failed: int = 0
    starts: int = 0
    agreeing_starts: int = 0
    spread: float = 0.0


def noise_of(y: Array) -> float:
    """Return the standard deviation of white noise on `y` [N], NaN if it is too short."""
    y = y[np.isfinite(y)]
    return math.nan if len(y) < 10 else white_noise_std(y, quantisation_step(y))


def at_rest(stamps: Integers, y: Array) -> tuple[tuple[float, ...], float] | None:
    """
    Return (noise [2], seconds) of the longest stretch in which both shafts stand still, or None.

    stamps int64 [N] ns, y [N, 2] rad. Means of short blocks stay within what the encoder noise
    explains, from one block to the next and over the stretch.
    """
    period = float(np.median(np.diff(stamps))) * 1e-9
    size = max(20, round(0.05 / period))
    count = len(y) // size
    if count < 3:
        return None
    blocks = y[:count * size].reshape(count, size, 2)
    complete = np.all(np.isfinite(blocks), axis=(1, 2))
    with np.errstate(invalid='ignore'):
        means = blocks.mean(axis=1)
    sigma = np.array([noise_of(y[:, 0]), noise_of(y[:, 1])])
    if not np.isfinite(sigma).all():
        return None
    allowed = 4.0 * np.maximum(sigma, 1e-12) * math.sqrt(2.0 / size)
    longest, begin = (0, 0), 0
    for end in range(count + 1):
        still = end < count and complete[end]
        if still and end > begin:
            still = bool((np.abs(means[end] - means[end - 1]) < allowed).all() and
                         (np.abs(means[end] - np.median(means[begin:end], axis=0))
                          < allowed).all())
        if not still:
            longest = max(longest, (end - begin, -begin))
            begin = end if end < count and complete[end] else end + 1
    length, begin = longest[0], -longest[1]
    seconds = length * size * period
    if seconds < STILL_SECONDS or length * size < STILL_SAMPLES:
        return None
    standstill = y[begin * size:(begin + length) * size]
    return tuple(_clipped_std(standstill[:, c], sigma[c]) for c in range(2)), seconds


def _clipped_std(y: Array, floor: float) -> float:
    """Return the standard deviation of `y` [N] without outliers, no less than a grid gives."""
    away = y - np.median(y)
    width = max(MAD_TO_SIGMA * float(np.median(np.abs(away))), floor)
    std = float(np.std(away[np.abs(away) <= 5.0 * width]))
    levels = np.unique(y)
    step = float(np.ptp(levels)) if len(levels) == 2 else quantisation_step(y)
    return max(std, step / math.sqrt(12.0), 1e-9)


def describe(stamps: Integers, u: Array, y: Array) -> EncoderMotion:
    """
    Measure the motion and the encoder noise of a recording.

    Args:
        stamps: int64 [N], ns.
        u: motor torque [N], N m.
        y: motor and arm position [N, 2], rad; NaN = not measured.

    Returns:
        The EncoderMotion.

    Raises:
        InputError: the recording is too short to tune on, or the motor does not move.

    """
    forward = np.concatenate([[True], np.diff(stamps) > 0]) if len(stamps) else np.zeros(0, bool)
    good = forward & np.isfinite(u) & np.isfinite(y).any(axis=1)
    stamps, u, y = stamps[good], u[good], y[good]
    seconds = float(np.minimum(np.diff(stamps), 10 ** 8).sum()) * 1e-9 if len(stamps) > 1 else 0.0
    if len(stamps) < MIN_SAMPLES or seconds < MIN_SECONDS:
        raise InputError(f'{len(stamps)} usable samples in {seconds:.2f} s, too short to tune; '
                         f'expected at least {MIN_SECONDS:g} s and {MIN_SAMPLES} samples')
    for c, name in enumerate(('motor', 'arm')):
        if np.isfinite(y[:, c]).mean() < 0.5:
            raise InputError(f'{name} position missing in more than half of the samples, '
                             'expected both encoders')
    noise = np.array([noise_of(y[:, c]) for c in range(2)])
    size = max(1, round(0.02 * len(stamps) / seconds))
    count = len(stamps) // size
    means = np.nanmean(_filled(y)[:count * size].reshape(count, size, 2), axis=1)
    times = stamps[:count * size:size] * 1e-9
    motion = means.std(axis=0)
    if not (motion[0] > EXCITED * noise[0] and motion[0] > 0.0):
        raise InputError(
            f'no excitation: the motor moves by {motion[0]:.3g} rad rms with encoder noise of '
            f'{noise[0]:.3g} rad, expected at least {EXCITED:g} times as much')
    speed = np.diff(means, axis=0) / np.diff(times)[:, None]
    standstill = at_rest(stamps, y)
    return EncoderMotion(tuple(np.maximum(noise, 1e-9).tolist()), seconds,
                         tuple(np.sqrt((speed ** 2).mean(axis=0)).tolist()), float(np.std(u)),
                         *(standstill or (None, 0.0)))


def _filled(y: Array) -> Array:
    """Return `y` [N, 2] with missing values interpolated, for rough figures only."""
    y, at = y.copy(), np.arange(len(y))
    for c in range(2):
        measured = np.isfinite(y[:, c])
        y[:, c] = np.interp(at, at[measured], y[measured, c])
    return y


def liveliest(stamps: Integers, y: Array, seconds: float) -> slice:
    """
    Find the part of a recording in which both shafts travel farthest.

    Args:
        stamps: int64 [N], ns.
        y: motor and arm position [N, 2], rad; NaN = not measured.
        seconds: length of the part, s.

    Returns:
        The slice of the samples; all of them if the recording is hardly longer.

    """
    n = len(stamps)
    span = float(stamps[-1] - stamps[0]) * 1e-9
    length = n if span <= 1.25 * seconds else max(MIN_SAMPLES, int(n * seconds / span))
    if length >= n:
        return slice(0, n)
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(_filled(y), axis=0)).sum(axis=1))])
    starts = np.arange(0, n - length, max(1, length // 8))
    begin = int(starts[np.argmax(travel[starts + length] - travel[starts])])
    return slice(begin, begin + length)


def torque_noise(parameters: EstimatorParameters) -> tuple[str, ...]:
    """Return the names of the process noise of tau_K that a filter with `parameters` uses."""
    if parameters.tau_k_model == MIXED and parameters.arm_joint:
        return TORQUE_NAMES
    return (DEVIATION if parameters.tau_k_model in CURVES else WALK,)


def first_guess(motion: EncoderMotion, free: Sequence[str]) -> dict[str, float]:
    """Return {name: value} for the parameters `free`, from the `motion` alone."""
    torque = motion.torque if motion.torque > 0.0 else 1.0
    speed = [max(v, 1e-3) for v in motion.speed]
    guess = {
        'r_std_motor': motion.noise[0], 'r_std_arm': motion.noise[1],
        'q_std_motor_speed': 0.02 * speed[0], 'q_std_arm_speed': 0.02 * speed[1],
        'q_std_tau_k': 3.0 * torque, 'q_std_tau_k_deviation': 0.3 * torque,
        'q_std_tau_arm': torque}
    return {name: guess[name] for name in free}


def search(evaluate: Evaluate, guess: dict[str, float],
           progress: Callable[[float], None] | None = None, likelihood: bool = True) -> Tuned:
    """
    Maximise a criterion over the logarithms of parameters, by L-BFGS-B from three starts.

    Args:
        evaluate: of (trials as {name: value}, coarse) -> [(criterion, diverged)]; the criterion in
            units of log-likelihood, -inf or NaN where the filter cannot run; coarse: a part of
            the recording will do.
        guess: {name: value > 0}, the centre of the search.
        progress: called with the share done, 0..1.
        likelihood: the curvature gives standard errors.

    Returns:
        The Tuned parameters.

    """
    names = list(guess)
    centre = np.array([guess[name] for name in names])
    result = Tuned({}, 0.0)
    n = len(names)
    starts = [np.zeros(n)]
    for factor in (10.0, 0.1):
        start = np.zeros(n)
        for i, name in enumerate(names):
            if name in TORQUE_NAMES:
                start[i] = math.log(factor)
            elif name in SPEED_NAMES:
                start[i] = -math.log(factor)
        starts.append(start)

    def values(x: Array) -> dict[str, float]:
        """Return the parameters at `x` [n], in logarithms over the guess."""
        return dict(zip(names, (centre * np.exp(x)).tolist()))

    def costs(points: list[Array], coarse: bool) -> list[float]:
        """Return the cost of each of the `points`: misfit, prior and penalty; see `coarse`."""
        trials = [values(np.clip(x, -REACH, REACH)) for x in points]
        penalised = []
        for x, (criterion, failed) in zip(points, evaluate(trials, coarse)):
            excess = np.maximum(np.abs(x) - REACH, 0.0).sum()
            result.evaluations += 1
            result.failed += bool(failed)
            if not math.isfinite(criterion):
                criterion = DIVERGED
            penalised.append(
                -criterion + 0.5 * float((x / PRIOR) @ (x / PRIOR)) + 1e3 * excess)
        return penalised

    def descend(x: Array, coarse: bool, shares: tuple[float, float]) -> tuple[Array, float]:
        """
        Minimise the cost by L-BFGS-B with slopes by central differences.

        Args:
            x: start [n].
            coarse: as of evaluate.
            shares: progress at the start and at the end.

        Returns:
            The minimum and the cost there.

        """
        calls = [0]

        def with_slope(x: Array) -> tuple[float, Array]:
            """Return cost and slope at `x` [n]."""
            calls[0] += 1
            if progress:
                share = 1.0 - 1.0 / (1.0 + 0.15 * calls[0])
                progress(shares[0] + share * (shares[1] - shares[0]))
            steps = SLOPE_STEP * np.eye(n)
            value, *around = costs([x, *(x + steps), *(x - steps)], coarse)
            return value, np.subtract(around[:n], around[n:]) / (2.0 * SLOPE_STEP)

        done = scipy.optimize.minimize(
            with_slope, x, jac=True, method='L-BFGS-B', bounds=[(-REACH, REACH)] * n,
            options={'maxfun': 30 if coarse else 20, 'ftol': 5e-6 if coarse else 5e-7})
        return done.x, float(done.fun)

    ends = [descend(start, True, (0.15 * k, 0.15 * k + 0.15)) for k, start in enumerate(starts)]
    minimum, lowest = min(ends, key=lambda end: end[1])
    agreeing = [x for x, value in ends if value < lowest + AGREE]
    result.starts, result.agreeing_starts = len(starts), len(agreeing)
    x, value = descend(minimum, False, (0.45, 0.8))
    x, value, deviations = _newton(lambda points: costs(points, False), x, value)
    sharp = deviations < SHARP
    if sharp.any():
        distances = np.abs(np.array(agreeing) - minimum)[:, sharp]
        result.spread = float(np.expm1(distances.max()))
    result.parameters, result.value = values(x), -float(value)
    if likelihood:
        result.error = {name: float(d) for name, d in zip(names, deviations)
                        if math.isfinite(d)}
    if progress:
        progress(1.0)
    return result


def with_another(result: Tuned, evaluate: Evaluate, name: str, guess: float) -> Tuned:
    """
    Return `result` with one more parameter, searched on a grid and then between its neighbours.

    Args:
        result: of a search for the others.
        evaluate: as of search, with the others at their values.
        name: of the parameter.
        guess: centre of the search, > 0.

    Returns:
        A copy of `result` with the parameter, without a standard error for it.

    """
    evaluations: list[bool] = []

    def costs(points: Sequence[float]) -> list[float]:
        """Return the cost at each of the `points`, logarithms over the guess."""
        scores = evaluate([{name: guess * math.exp(x)} for x in points], False)
        evaluations.extend(bool(failed) for _, failed in scores)
        return [0.5 * (x / PRIOR) ** 2 - (criterion if math.isfinite(criterion) else DIVERGED)
                for x, (criterion, _) in zip(points, scores)]

    heights = costs(GRID)
    lowest = min(max(int(np.argmin(heights)), 1), len(GRID) - 2)
    between = scipy.optimize.minimize_scalar(
        lambda x: costs([x])[0], bounds=(GRID[lowest - 1], GRID[lowest + 1]), method='bounded',
        options={'xatol': ACCURACY})
    return replace(result, parameters={**result.parameters, name: guess * math.exp(between.x)},
                   value=-float(between.fun), evaluations=result.evaluations + len(evaluations),
                   failed=result.failed + sum(evaluations))


def _newton(cost: Callable[[list[Array]], list[float]], x: Array,
            value: float) -> tuple[Array, float, Array]:
    """
    Fit a paraboloid around `x`; return its minimum, the cost there and standard errors.

    A fit over points some units of cost away sees through roughness on smaller scales.
    """
    n = len(x)
    reach = np.empty(n)
    points: list[Array] = [np.zeros(n)]
    costs = [value]

    def add(steps: list[Array]) -> list[float]:
        """Evaluate the `steps` from x, note points and costs, and return the costs."""
        points.extend(steps)
        costs.extend(cost([x + d for d in steps]))
        return costs[-len(steps):]

    units = list(np.eye(n))
    rises = add([sign * 0.1 * unit for unit in units for sign in (1.0, -1.0)])
    for i in range(n):
        rise = max(0.5 * (rises[2 * i] + rises[2 * i + 1]) - value, 0.02)
        reach[i] = min(max(0.1 * math.sqrt(4.0 / rise), 0.01), 0.5)
    corners = list(np.diag(0.7 * reach))
    add([sign * d for sign in (1.0, -1.0) for d in (
        *(r * unit for r, unit in zip(reach, units)),
        *(corners[i] + side * corners[j]
          for i in range(n) for j in range(i) for side in (1.0, -1.0)))])
    scaled, heights = np.array(points) / reach, np.array(costs)
    usable = (heights < value + 50.0) & (np.abs(scaled).max(axis=1) < 3.0)
    pairs = [(i, j) for i in range(n) for j in range(i + 1)]
    columns = [np.ones(len(scaled)), *scaled.T, *(scaled[:, i] * scaled[:, j] for i, j in pairs)]
    unknown = np.full(n, math.nan)
    if usable.sum() < len(columns):
        return x, value, unknown
    c = np.linalg.lstsq(np.column_stack(columns)[usable], heights[usable], rcond=None)[0]
    hessian = np.zeros((n, n))
    for (i, j), a in zip(pairs, c[1 + n:]):
        hessian[i, j] += a
        hessian[j, i] += a
    if not np.linalg.eigvalsh(hessian).min() > 1e-3:
        return x, value, unknown
    deviations = reach * np.sqrt(np.diag(np.linalg.inv(hessian)))
    step = reach * np.clip(-np.linalg.solve(hessian, c[1:1 + n]), -1.5, 1.5)
    value_at_step, = cost([x + step])
    if value_at_step < value + 1.0:
        return x + step, value_at_step, deviations
    return x, value, deviations


def widened(error: Array, variance: Array, share: float = 0.682689) -> float:
    """
    Return the deviation to add in quadrature, so that the deviations cover a share of the errors.

    Args:
        error: of the estimates [N].
        variance: stated by the filter [N].
        share: of the errors that one standard deviation should cover.

    Returns:
        The deviation, in the unit of the errors; 0.0 if they are covered already.

    """
    # |e| <= sqrt(v + m^2)  <=>  e^2 - v <= m^2
    return math.sqrt(max(float(np.quantile(error ** 2 - variance, share)), 0.0))
