# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Second trust indicator: prediction errors are zero-mean, white and as large as predicted.

All tests run on innovations whitened by the Cholesky factor of S, each on the window that suits
it: the mean on a short one, because over whole periods of the excitation a model error averages
out; whiteness and size on a long one.

An outcome wants an effect of some size beside its significance: with enough samples every model is
significantly wrong.

All but whiteness follows from sums over the window; the firmware of a drive keeps these sums
sample by sample (`watch`) and judges them by the same kernels.

One window of biased or coloured errors can be a bump; a minute of them is the model
(`judge_model`). The next step is then a diagnosis (docs/diagnose.md), not another tuning.

Third trust indicator: the filter's uncertainty of tau_K is at its reference. It is that of the
filter alone: what the tolerances of the model add to it varies with the motion.
"""
from collections import deque
from collections.abc import Mapping
import math
from typing import NamedTuple, TypeAlias

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.score import LAGS, ljung_box, MIN_SAMPLES
from gearbox_monitor.health.alarms import Condition, Level, LIMITS, Outcome, outcome_of
from gearbox_monitor.kernels.kernel import entry, inline, kernel
from gearbox_monitor.kernels.types import Array, Integers, Matrix, Pair, Values, Vector
from gearbox_monitor.parameters import EstimatorParameters, LEARNED
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said


def _deviations(share: float) -> float:
    """Return how many deviations a normal variable exceeds, either way, with that probability."""
    z = LIMITS.gate
    for _ in range(9):  # Newton
        z += (math.erfc(z / math.sqrt(2.0)) - share) / (
            math.sqrt(2.0 / math.pi) * math.exp(-0.5 * z * z))
    return z


NIS_DEVIATIONS = _deviations(LIMITS.error_significance)
MEAN_LIMIT = _deviations(0.5 * LIMITS.error_significance)  # two channels
# Of scipy.special, which takes longer to load than all of this; a test computes it.
LJUNG_BOX_LIMIT = 67.29689616943706

_ERROR, _NIS = ('prediction error', Level.WARN), ('nis_over_dof',)
BIASED = Condition('biased', *_ERROR, ('mean',), ('mean_threshold',))
COLOURED = Condition('coloured', *_ERROR, ('ljung_box', 'predictable_share'),
                     ('ljung_box_threshold', 'predictable_share_threshold'))
LARGER = Condition('larger', *_ERROR, _NIS, ('nis_high',))
SMALLER = Condition('smaller', *_ERROR, _NIS, ('nis_low',))
GROSS = Condition('gross', 'prediction error', Level.ERROR, _NIS, ('nis_gross',))
MOTOR_VARIANCE, ARM_VARIANCE = (Condition(
    f'{joint}_variance', *_ERROR, (f'variance_ratio_{joint}',),
    ('variance_ratio_low', 'variance_ratio_high')) for joint in ('motor', 'arm'))
OUTLIERS = Condition('outliers', *_ERROR, ('test_ratio',), ('test_ratio_threshold',))
TOO_FEW = Condition('too_few', *_ERROR, ('window_samples',))
CONDITIONS = (BIASED, COLOURED, LARGER, SMALLER, GROSS, MOTOR_VARIANCE, ARM_VARIANCE, OUTLIERS,
              TOO_FEW)


# Sums over a window; pairs of motor and arm from COUNT on. LARGEST: of its newest errors in stated
# deviations; RECENT, MEAN: number and sum of its last whitened ones.
SAMPLES, NIS, DOF, LARGEST, COUNT, SQUARE, RECENT, MEAN, N_SUMS = 0, 1, 2, 3, 4, 6, 8, 10, 12
# What a window and its newest sample broke, in bits.
(SETTLING, BEYOND_GATE, BIASED_BIT, LARGER_BIT, SMALLER_BIT, GROSS_BIT, MOTOR_BIT, ARM_BIT,
 OUTLIERS_BIT, TOO_FEW_BIT) = (1 << k for k in range(10))
# mean, NIS over dof, its bounds low and high, variance ratios of motor and arm, test ratio
Statistics: TypeAlias = tuple[float, float, float, float, float, float, float]


@inline
def _add(white: Pair, nis: Pair, errors: Pair, stds: Pair, recent: bool, newest: bool,
         sums: Array) -> None:
    """
    Add a sample to the `sums` of a window.

    Args:
        white: whitened innovations.
        nis: normalised innovation squared, and its degrees of freedom.
        errors: innovations, rad; NaN = not measured.
        stds: their predicted standard deviations, rad.
        recent: whether the mean is judged over it.
        newest: whether the gate is.
        sums: [N_SUMS].

    """
    sums[SAMPLES] += 1.0
    sums[NIS] += nis[0]
    sums[DOF] += nis[1]
    for c in range(2):
        if math.isfinite(errors[c]):
            ratio = errors[c] / stds[c]
            sums[SQUARE + c] += ratio * ratio
            sums[COUNT + c] += 1.0
            if newest:
                sums[LARGEST] = max(sums[LARGEST], abs(ratio))
        if recent and math.isfinite(white[c]):
            sums[MEAN + c] += white[c]
            sums[RECENT + c] += 1.0


@entry
def nis_limits(dof: float) -> Pair:
    """
    Return (low, high) of the mean NIS per degree of freedom, of `dof` in all.

    Quantiles of chi-square by Cornish and Fisher's expansion, within 1e-6 from 150 dof on.
    """
    z, root = NIS_DEVIATIONS, math.sqrt(2.0 * dof)
    z2 = z * z
    even = dof + 2.0 / 3.0 * (z2 - 1.0) - (6.0 * z2 * z2 + 14.0 * z2 - 32.0) / (405.0 * dof)
    odd = z * (root + (z2 - 7.0) / (9.0 * root)
               + (9.0 * z2 * z2 + 256.0 * z2 - 433.0) / (4860.0 * dof * root))
    return (even - odd) / dof, (even + odd) / dof


@inline
def _ratio(square: float, count: float) -> float:
    return square / count if count >= MIN_SAMPLES else 1.0


@inline
def _mean(total: float, count: float) -> float:
    return abs(total) / math.sqrt(count) if count >= LAGS else 0.0


@entry
def judged(sums: Vector) -> tuple[Statistics, int]:
    """Return the Statistics of a window, and the bits of what is broken, by its `sums`."""
    dof = sums[DOF]
    if sums[SAMPLES] < MIN_SAMPLES or dof < MIN_SAMPLES:
        return (0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0), TOO_FEW_BIT
    mean = max(_mean(sums[MEAN], sums[RECENT]), _mean(sums[MEAN + 1], sums[RECENT + 1]))
    ratio = sums[NIS] / dof
    low, high = nis_limits(dof)
    low, high = min(low, LIMITS.nis_low), max(high, LIMITS.nis_high)
    motor = _ratio(sums[SQUARE], sums[COUNT])
    arm = _ratio(sums[SQUARE + 1], sums[COUNT + 1])
    gate = sums[LARGEST] / LIMITS.gate
    broken = BIASED_BIT if mean > MEAN_LIMIT else 0
    if not ratio <= LIMITS.nis_gross:
        broken |= GROSS_BIT
    elif ratio > high:
        broken |= LARGER_BIT
    if ratio < low:
        broken |= SMALLER_BIT
    if not LIMITS.variance_low <= motor <= LIMITS.variance_high:
        broken |= MOTOR_BIT
    if not LIMITS.variance_low <= arm <= LIMITS.variance_high:
        broken |= ARM_BIT
    if gate > 1.0:
        broken |= OUTLIERS_BIT
    return (mean, ratio, low, high, motor, arm, gate), broken


@entry
def _sum(white: Matrix, nis: Vector, dof: Vector, errors: Matrix, stds: Matrix, recent: int,
         newest: int, sums: Vector) -> None:
    """Add the samples of a window to `sums`; all others as in check."""
    n = nis.shape[0]
    for i in range(n):
        _add((white[i, 0], white[i, 1]), (nis[i], dof[i]), (errors[i, 0], errors[i, 1]),
             (stds[i, 0], stds[i, 1]), i >= n - recent, i >= n - newest, sums)


@inline
def due_after(stamp: int, due: int, phase: int) -> int:
    """
    Return when evaluations are due after a sample: with the first one of each second of stamps.

    Args:
        stamp: of the sample, ns.
        due: stamp at which one was due, ns; 0: none yet.
        phase: of the seconds, ns.

    """
    second = sample_loop.SECOND
    if due == 0:
        return stamp + second
    if due - second <= stamp < due:
        return due
    return stamp + second - (stamp - phase) % second


class ErrorWatch(NamedTuple):
    """
    What firmware carries to judge prediction errors once per second; it is changed in place.

    sums [2, N_SUMS]: since the last judgement, and between the two before. due int64 [2]: stamp
    of the next judgement (ns, 0: none yet), and the bits of the last one.
    """

    sums: Matrix
    due: Integers


@kernel
def watch(row: Array, code: int, stamp: int, started: int, carried: ErrorWatch) -> int:
    """
    Return what a sample and the last window broke, in bits.

    Args:
        row: of the estimate, sample_loop.E_*, where there is one.
        code: what became of the sample.
        stamp: of the sample, ns.
        started: since when estimates are as good as stated, ns.
        carried: changed in place.

    """
    sums, due = carried
    if code != sample_loop.ESTIMATE and code != sample_loop.START and (
            code != sample_loop.NO_EFFORT and code != sample_loop.NO_MEASUREMENT):
        return due[1]
    beyond = 0
    if started == stamp:
        sums[:] = 0.0
        due[1] = SETTLING
    if code == sample_loop.ESTIMATE:
        e1, e2 = row[sample_loop.E_INNOVATION_MOTOR], row[sample_loop.E_INNOVATION_ARM]
        s1, s2 = row[sample_loop.E_INNOVATION_STD_MOTOR], row[sample_loop.E_INNOVATION_STD_ARM]
        if abs(e1) > LIMITS.gate * s1 or abs(e2) > LIMITS.gate * s2:
            beyond = BEYOND_GATE
        if (stamp - started) * 1e-9 >= LIMITS.settle:
            _add((row[sample_loop.E_WHITE_1], row[sample_loop.E_WHITE_2]),
                 (row[sample_loop.E_NIS], row[sample_loop.E_DOF]), (e1, e2), (s1, s2),
                 (due[0] - stamp) * 1e-9 < LIMITS.mean_window, True, sums[0])
    if due[0] != 0 and stamp >= due[0]:
        due[1] = _judge(sums, (stamp - started) * 1e-9)
    due[0] = due_after(stamp, due[0], 0)
    return due[1] | beyond


@inline
def _judge(sums: Array, settled: float) -> int:
    """Return the bits of the last 2 s; settled: s since estimates are as good as stated."""
    newest, whole = sums[0], sums[1]
    for k in range(N_SUMS):
        whole[k] = newest[k] if k == LARGEST or k >= RECENT else whole[k] + newest[k]
    broken = SETTLING if settled < LIMITS.settle + 1.0 else judged(whole)[1]
    for k in range(N_SUMS):
        whole[k], newest[k] = newest[k], 0.0
    return broken


def _whiteness(white: Array) -> tuple[float, float]:
    """Return ljung_box of the channel of `white` [N, 2] that is farther from white."""
    return max(ljung_box(white[:, 0]), ljung_box(white[:, 1]))


def systematic(values: Values) -> bool:
    """
    Return whether `values` of check() are biased or not white, as no noise makes them.

    Noise of the encoders that is larger or smaller than stated, or outliers, are neither.
    """
    return 'mean' in values and (
        values['mean'] > values['mean_threshold']
        or (values['ljung_box'] > values['ljung_box_threshold']
            and values['predictable_share'] > values['predictable_share_threshold']))


def check(white: Array, nis: Array, dof: Array, errors: Array, stds: Array, recent: int,
          newest: int) -> Outcome:
    """
    Return the Outcome for a window of N samples; NaN where not measured.

    Args:
        white: whitened innovations [N, 2].
        nis: normalised innovation squared [N].
        dof: its degrees of freedom [N].
        errors: innovations [N, 2], rad.
        stds: their predicted standard deviations [N, 2], rad.
        recent: number of last samples for the test of the mean.
        newest: number of last samples for the gate.

    Returns:
        The Outcome with all test values and their thresholds.

    """
    sums = np.zeros(N_SUMS)
    _sum(white, nis, dof, errors, stds, recent, newest, sums)
    (mean, ratio, low, high, motor, arm, gate), broken = judged(sums)
    if broken & TOO_FEW_BIT:
        return outcome_of([TOO_FEW.said()], None, {'window_samples': len(nis)})
    box, predictable = _whiteness(white)
    predictable_limit = LIMITS.predictable + LAGS / len(nis)
    values = {
        'mean': mean, 'mean_threshold': MEAN_LIMIT,
        'ljung_box': box, 'ljung_box_threshold': LJUNG_BOX_LIMIT,
        'predictable_share': predictable, 'predictable_share_threshold': predictable_limit,
        'nis_over_dof': ratio, 'nis_low': low, 'nis_high': high, 'nis_gross': LIMITS.nis_gross,
        'variance_ratio_motor': motor, 'variance_ratio_arm': arm,
        'variance_ratio_low': LIMITS.variance_low, 'variance_ratio_high': LIMITS.variance_high,
        'test_ratio': gate, 'test_ratio_threshold': 1.0, 'window_samples': len(nis)}
    says = [condition.said() for condition, is_broken in (
        (BIASED, broken & BIASED_BIT),
        (COLOURED, box > LJUNG_BOX_LIMIT and predictable > predictable_limit),
        (GROSS, broken & GROSS_BIT), (LARGER, broken & LARGER_BIT),
        (SMALLER, broken & SMALLER_BIT), (MOTOR_VARIANCE, broken & MOTOR_BIT),
        (ARM_VARIANCE, broken & ARM_BIT), (OUTLIERS, broken & OUTLIERS_BIT)) if is_broken]
    return outcome_of(says, Said('as_predicted'), values)


BELOW = Condition('below', 'covariance', Level.WARN, ('tau_k_noise_std',), ('lower_bound',))
ABOVE = Condition('above', 'covariance', Level.WARN, ('tau_k_noise_std',), ('upper_bound',))
COVARIANCE_CONDITIONS = (BELOW, ABOVE)


def judge_covariance(stated: float, std: float, reference: float | None) -> Outcome:
    """
    Return the Outcome for the uncertainty of tau_K.

    Args:
        stated: median stated deviation, N m.
        std: the same by noise alone, which is judged.
        reference: healthy value of `std`; None: not complete yet.

    """
    if reference is None:
        return outcome_of([], Said('no_reference'),
                          {'tau_k_std': stated, 'tau_k_noise_std': std})
    values = {'tau_k_std': stated, 'tau_k_noise_std': std, 'reference': reference,
              'lower_bound': LIMITS.covariance_low * reference,
              'upper_bound': LIMITS.covariance_high * reference}
    broken = []
    if std < LIMITS.covariance_low * reference:
        broken.append(BELOW.said())
    elif not std <= LIMITS.covariance_high * reference:  # NaN is untrusted, too
        broken.append(ABOVE.said())
    return outcome_of(broken, Said('usual'), values)


SECOND = 1_000_000_000

MISSING = Condition('mismatch', 'model', Level.WARN, ('systematic_s',),
                    ('systematic_s_threshold',))
STIFFNESS = Condition('learned_stiffness', 'model', Level.WARN, ('learned_stiffness',))
GAP = Condition('learned_gap', 'model', Level.WARN, ('learned_gap_rad',))
MODEL_CONDITIONS = (MISSING, STIFFNESS, GAP)


class Systematic:
    """The evaluations, one per second of stamps, whose prediction errors were systematic."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque()

    def add(self, stamp_ns: int, systematic: bool) -> None:
        """Take the evaluation at `stamp_ns`: whether its errors were `systematic`."""
        if systematic:
            self._stamps.append(stamp_ns)

    def seconds(self, stamp_ns: int, window: float) -> int:
        """Return how many of the last `window` s before `stamp_ns` were systematic."""
        first = stamp_ns - round(window * SECOND)
        while self._stamps and not first < self._stamps[0] <= stamp_ns:
            self._stamps.popleft()
        return len(self._stamps)


def judge_model(systematic: Systematic, stamp_ns: int, window: float, unknown_load: bool
                ) -> Outcome:
    """
    Return the Outcome on model mismatch.

    Args:
        systematic: the evaluations with systematic errors.
        stamp_ns: now.
        window: s before it that count.
        unknown_load: whether a load on the arm is estimated, which absorbs most mismatches.

    Returns:
        WARN if the errors were systematic in more than `systematic_share` of it.

    """
    seconds = systematic.seconds(stamp_ns, window)
    values = {'systematic_s': float(seconds),
              'systematic_s_threshold': LIMITS.most * window,
              'window_s': window}
    hidden = (Said('load_hides'),) if unknown_load else ()
    return outcome_of([MISSING.said()] if seconds > LIMITS.most * window else [],
                      Said('holds', {'hidden': hidden}), values)


def learned_curve(values: Mapping[str, float], drive: DriveModel,
                  parameters: EstimatorParameters) -> list[Said]:
    """
    Return the broken conditions: the learned curve should be the curve of the model file.

    A load on the arm absorbs an error of the torque, but not the curve. Where the learned curve is
    not the likeliest model, what was learnt says nothing.

    Args:
        values: of Estimator.learned_curve; {} where nothing is learnt.
        drive: whose curve is compared with.
        parameters: how far the values may be from it.

    """
    if not values or values.get(f'probability_{LEARNED}', 1.0) < LIMITS.most:
        return []
    shape, broken = drive.transmission, list[Said]()
    for condition, key, unit, model, tolerance in (
            (STIFFNESS, 'learned_stiffness', '', shape.stiffness, parameters.stiffness_error),
            (GAP, 'learned_gap', '_rad', 2.0 * shape.half_gap, parameters.gap_error)):
        value, std = values[key + unit], values[f'{key}_std{unit}']
        beyond = max(value - model * (1.0 + tolerance), model / (1.0 + tolerance) - value)
        if (std < LIMITS.learned_std * value and beyond > LIMITS.deviations * std
                and model > 0.0):
            broken.append(condition.said(factor=value / model))
    return broken
