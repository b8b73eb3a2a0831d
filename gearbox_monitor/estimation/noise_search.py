# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Find R and Q of a filter from a recording, without any truth.

R comes from a stretch in which both shafts stand still, if the recording has one. The search finds
the other parameters by maximising the log-likelihood of the innovations over the logarithms of the
parameters. The search starts from numbers taken from the recording, never from the parameters in
force: so the result does not depend on them. Those numbers also carry a weak prior (a factor of 30
costs half a unit of log-likelihood), which decides only what the recording leaves open.

Where friction is sharp, the likelihood of a filter with its tangent is rough: it changes by units
within 1e-5 of a parameter, so that its gradient, though exact, leads nowhere. `search` climbs a
smooth one, `polished` tries what the rough one says of the neighbourhood.
"""
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.elementary import MAD_TO_SIGMA, quantisation_step, white_noise_std
from gearbox_monitor.kernels.linear_least_squares import damped_step, Damping
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
# Log-likelihood that is still sought, and while starts are compared.
GAIN, COARSE_GAIN = 0.1, 1.0
LONGEST = 2.0            # step, in logarithms
STEPS = 30               # of an ascent; without a summit, as of a stuck encoder, it would go on
DAMPING = Damping(0.0, raised_from=0.01, attempts=7)
NEAR, TRIALS = 0.5, 8    # of a rough criterion: deviations around the optimum; trials for each
SHARP = 0.05             # a parameter is well determined below this relative error
BLUNT = 0.3              # ... and hardly above this one
# Of a parameter that is searched alone: bounds over the guess, and accuracy of the logarithm.
ALONE, ACCURACY = (1e-3, 30.0), 0.1
DIVERGED = -1e9          # what a filter gets that cannot run at all
DIFFERENCE = 0.03        # of the logarithms; a criterion may be rough on smaller scales

R_NAMES = ('r_std_motor', 'r_std_arm')
SPEED_NAMES = ('q_std_motor_speed', 'q_std_arm_speed')
TORQUE_NAMES = WALK, DEVIATION = ('q_std_tau_k', 'q_std_tau_k_deviation')


class Trial(NamedTuple):
    """
    A criterion and what it is made of.

    criterion: in units of log-likelihood, -inf or NaN where a filter cannot run; failed: how many
    filters diverged; features [M]: of weight `weights` [M] each; residual [M]: the criterion falls
    by changes of features * weights * residual, and by half of their squares.
    """

    criterion: float
    failed: int
    features: Array
    weights: Array
    residual: Array


# ({name: value}, coarse) -> Trial, see search; {name: value} -> (criterion, diverged).
Evaluate: TypeAlias = Callable[[Mapping[str, float], bool], Trial]
Rough: TypeAlias = Callable[[Mapping[str, float]], tuple[float, bool]]


@np.errstate(all='ignore')  # a trial may be anything
def differenced(evaluate: Callable[[Mapping[str, float]], Trial], values: Mapping[str, float],
                at: Trial) -> tuple[Array, Array]:
    """
    Return (gradient [n], information [n, n]) of a criterion over the logarithms of n values.

    Slopes of features are one-sided differences: n more trials.

    Args:
        evaluate: of {name: value}, gives the Trial.
        values: where.
        at: the Trial there.
    """
    slopes = np.nan_to_num([(evaluate({
        **values, name: value * math.exp(DIFFERENCE)}).features - at.features) * at.weights
        / DIFFERENCE for name, value in values.items()])
    return (np.nan_to_num(-slopes @ np.nan_to_num(at.residual)),
            np.nan_to_num(slopes @ slopes.T))


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
           progress: Callable[[float], object] = bool) -> Tuned:
    """
    Maximise a criterion over the logarithms of parameters, by Fisher scoring from three starts.

    Args:
        evaluate: of ({name: value}, coarse), gives the Trial; coarse: a part of the recording
            will do.
        guess: {name: value > 0}, the centre of the search.
        progress: called with the share done, 0..1.

    Returns:
        The Tuned parameters.

    """
    names = list(guess)
    centre, ridge = np.array([guess[name] for name in names]), np.eye(len(names)) / PRIOR ** 2
    result = Tuned({}, 0.0)

    def values(x: Array) -> dict[str, float]:
        """Return the parameters at `x` [n], in logarithms over the guess."""
        return dict(zip(names, (centre * np.exp(x)).tolist()))

    def counted(trial: Mapping[str, float], coarse: bool) -> Trial:
        """Return what `evaluate` gives of a trial, one more evaluation."""
        found = evaluate(trial, coarse)
        result.evaluations += 1
        result.failed += found.failed
        progress(1.0 - 1.0 / (1.0 + 0.01 * result.evaluations))
        return found

    def posterior(x: Array, coarse: bool) -> tuple[Array, Trial]:
        """Return `x` within its REACH, and the Trial there with the prior."""
        x = np.clip(x, -REACH, REACH)
        found = counted(values(x), coarse)
        criterion = found.criterion if math.isfinite(found.criterion) else DIVERGED
        return x, found._replace(criterion=criterion - 0.5 * float(x @ ridge @ x))

    def slopes(x: Array, here: Trial, coarse: bool) -> tuple[Array, Array]:
        """Return gradient and information at `x` with those of the prior."""
        gradient, information = differenced(lambda v: counted(v, coarse), values(x), here)
        return gradient - ridge @ x, information + ridge

    def step_from(x: Array, here: Trial, coarse: bool, slopes: tuple[Array, Array],
                  damping: float) -> tuple[tuple[Array, Trial], float] | None:
        """Return (place and Trial after a step that helps, next damping), None without one."""
        gradient, information = slopes
        return damped_step(
            information, gradient,
            lambda step: posterior(x + np.clip(step, -LONGEST, LONGEST), coarse),
            lambda trial: trial[1].criterion - here.criterion, damping, DAMPING)

    def ascend(x: Array, coarse: bool) -> tuple[Array, Trial, Array]:
        """Return where the criterion is largest, its Trial and information; coarse: as above."""
        (x, here), damping, gained = posterior(x, coarse), DAMPING.start, math.inf
        least = COARSE_GAIN if coarse else GAIN
        for _ in range(STEPS):
            gradient, information = slopes(x, here, coarse)
            expected = 0.5 * float(gradient @ np.linalg.solve(information, gradient))
            if min(gained, expected) < least:
                break
            step = step_from(x, here, coarse, (gradient, information), damping)
            if step is None:
                break
            gained = step[0][1].criterion - here.criterion
            (x, here), damping = step
        return x, here, information

    starts = [np.array([sign * math.log(10.0) * ((name in TORQUE_NAMES) - (name in SPEED_NAMES))
                        for name in names]) for sign in (0.0, 1.0, -1.0)]
    ends = [ascend(start, True) for start in starts]
    top, highest, _ = max(ends, key=lambda end: end[1].criterion)
    agreeing = [x for x, here, _ in ends if here.criterion > highest.criterion - AGREE]
    result.starts, result.agreeing_starts = len(starts), len(agreeing)
    x, here, information = ascend(top, False)
    deviations = np.sqrt(np.diag(np.linalg.inv(information)))
    sharp = deviations < SHARP
    if sharp.any():
        distances = np.abs(np.array(agreeing) - top)[:, sharp]
        result.spread = float(np.expm1(distances.max()))
    result.parameters, result.value = values(x), here.criterion
    result.error = dict(zip(names, deviations.tolist()))
    progress(1.0)
    return result


def polished(result: Tuned, evaluate: Rough) -> Tuned:
    """
    Return the `result` of a search moved to where a rough criterion is larger.

    The simplex of Nelder and Mead, about NEAR deviations wide, needs no slopes.

    Args:
        result: with errors.
        evaluate: of {name: value}, gives (criterion, diverged).

    Returns:
        A copy of `result` with the best of TRIALS for each parameter.

    """
    import scipy
    names, centre = list(result.parameters), np.log(list(result.parameters.values()))
    steps = NEAR * np.diag([min(result.error[name], 1.0) for name in names])
    simplex = np.vstack([centre, centre + steps])
    return _derivative_free(result, evaluate, names, lambda cost: scipy.optimize.minimize(
        cost, centre, method='Nelder-Mead', options={
            'maxfev': TRIALS * len(names), 'initial_simplex': simplex}))


def with_another(result: Tuned, evaluate: Rough, name: str, guess: float) -> Tuned:
    """
    Return `result` with one more parameter, searched between bounds.

    Args:
        result: of a search for the others.
        evaluate: as of polished.
        name: of the parameter.
        guess: centre of the search, > 0.

    Returns:
        A copy of `result` with the parameter, without a standard error for it.

    """
    import scipy
    centre, (low, high) = math.log(guess), np.log(ALONE)
    return _derivative_free(result, evaluate, [name], lambda cost: scipy.optimize.minimize_scalar(
        lambda x: cost(x) + 0.5 * ((x - centre) / PRIOR) ** 2, method='bounded',
        bounds=(centre + low, centre + high), options={'xatol': ACCURACY}))


def _derivative_free(result: Tuned, evaluate: Rough, names: Sequence[str],
                     minimise: Callable[[Callable[[Array], float]], Any]) -> Tuned:
    """Return `result` with the parameters `names` where `minimise` of -`evaluate` ends."""
    failures: list[bool] = []

    def values(x: Array) -> dict[str, float]:
        """Return the parameters, those of logarithms `x` in place of their own."""
        return {**result.parameters, **dict(zip(names, np.exp(np.atleast_1d(x)).tolist()))}

    def cost(x: Array) -> float:
        """Return less the criterion at `x`."""
        criterion, failed = evaluate(values(x))
        failures.append(failed)
        return -criterion if math.isfinite(criterion) else -DIVERGED

    least = minimise(cost)
    return replace(result, parameters=values(least.x), value=-float(least.fun),
                   evaluations=result.evaluations + len(failures),
                   failed=result.failed + sum(failures))


def widened(error: Array, variance: Array) -> float:
    """
    Return the deviation to add in quadrature, so that one deviation covers 68 % of the errors.

    Args:
        error: of the estimates [N].
        variance: stated by the filter [N].

    Returns:
        The deviation, in the unit of the errors; 0.0 if they are covered already.

    """
    # |e| <= sqrt(v + m^2)  <=>  e^2 - v <= m^2
    return math.sqrt(max(float(np.quantile(error ** 2 - variance, 0.682689)), 0.0))
