# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Second trust indicator: prediction errors are zero-mean, white and as large as predicted.

All tests run on innovations whitened by the Cholesky factor of S, each on the window that suits
it: the mean on a short one, because over whole periods of the excitation a model error averages
out; whiteness and size on a long one.

`flags` judges one window by significance alone. An outcome (`check`) wants an effect of some size
as well: with enough samples every model is significantly wrong.
"""
from functools import lru_cache
import math

import numpy as np

from gearbox_monitor.estimation.score import LAGS, ljung_box, MIN_SAMPLES
from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of
from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.types import Array, Matrix, Values, Vector

# Numbers of scipy.special, which takes longer to load than all of this; a test computes them.
MEAN_LIMIT = 5.026312836056685  # two channels, two sides
LJUNG_BOX_LIMIT = 67.29689616943706
_TUNE = 'check friction, inertia and torque scale of the model'

BIASED = Condition(
    'prediction error', Level.WARN, 'prediction errors biased',
    f'largest abs(mean) sqrt(N) of the whitened channels > {MEAN_LIMIT:.2f}',
    f'{LIMITS.mean_window:g} s', _TUNE, ('mean',), ('mean_threshold',))
COLOURED = Condition(
    'prediction error', Level.WARN, 'prediction errors not white',
    f'Ljung-Box over {LAGS} lags > {LJUNG_BOX_LIMIT:.1f} and sum of squared correlations > '
    f'{LIMITS.predictable:g} + {LAGS} / N', f'{LIMITS.error_window:g} s',
    _TUNE + ', and the time stamps', ('ljung_box', 'predictable_share'),
    ('ljung_box_threshold', 'predictable_share_threshold'))
LARGER = Condition(
    'prediction error', Level.WARN, 'prediction errors larger than predicted',
    f'NIS over its degrees of freedom > {LIMITS.nis_high:g} and significantly above 1',
    f'{LIMITS.error_window:g} s', _TUNE + ', and the encoders; or raise R',
    ('nis_over_dof',), ('nis_high',))
SMALLER = Condition(
    'prediction error', Level.WARN, 'prediction errors smaller than predicted',
    f'NIS over its degrees of freedom < {LIMITS.nis_low:g} and significantly below 1',
    f'{LIMITS.error_window:g} s', 'R or Q is too large: tune them', ('nis_over_dof',),
    ('nis_low',))
GROSS = Condition(
    'prediction error', Level.ERROR, 'prediction errors much larger than predicted',
    f'NIS over its degrees of freedom > {LIMITS.nis_gross:g}', f'{LIMITS.error_window:g} s',
    'do not trust tau_K; check the encoders first, then the model', ('nis_over_dof',),
    ('nis_gross',))
MOTOR_VARIANCE, ARM_VARIANCE = (Condition(
    'prediction error', Level.WARN, f'{joint} encoder noise differs from r_std_{joint}',
    f'mean squared innovation of the {joint} over predicted variance outside '
    f'{LIMITS.variance_low:g} .. {LIMITS.variance_high:g}', f'{LIMITS.error_window:g} s',
    f'check the {joint} encoder, or tune r_std_{joint}',
    (f'variance_ratio_{joint}',), ('variance_ratio_low', 'variance_ratio_high'))
    for joint in ('motor', 'arm'))
OUTLIERS = Condition(
    'prediction error', Level.WARN, 'outliers',
    f'largest innovation / ({LIMITS.gate:g} predicted standard deviations) > 1',
    f'{LIMITS.gate_window:g} s',
    'check encoder cables and supply, and for impacts', ('test_ratio',),
    ('test_ratio_threshold',))
TOO_FEW = Condition(
    'prediction error', Level.WARN, 'too few innovations',
    f'fewer than {MIN_SAMPLES} samples that gave an estimate', f'{LIMITS.error_window:g} s',
    'wait; check the rate if it stays', ('window_samples',))
CONDITIONS = (BIASED, COLOURED, LARGER, SMALLER, GROSS, MOTOR_VARIANCE, ARM_VARIANCE, OUTLIERS,
              TOO_FEW)


@entry
def _finite_sum(column: Vector) -> tuple[float, int]:
    """Return (sum, number) of the finite values of `column` [N]."""
    total, count = 0.0, 0
    for i in range(column.shape[0]):
        if math.isfinite(column[i]):
            total += column[i]
            count += 1
    return total, count


@entry
def _sizes(errors: Matrix, stds: Matrix, newest: int) -> tuple[float, float, float]:
    """
    Return the mean of (error / std)^2 of motor and arm, and the largest abs(error) / std.

    errors, stds [N, 2], NaN where not measured; the largest of the last `newest` samples. Where
    there is hardly any sample the mean is 1.
    """
    n = errors.shape[0]
    motor, arm, largest = 1.0, 1.0, 0.0
    for c in range(2):
        total, count = 0.0, 0
        for i in range(n):
            if math.isfinite(errors[i, c]):
                ratio = errors[i, c] / stds[i, c]
                total += ratio * ratio
                count += 1
                if i >= n - newest:
                    largest = max(largest, abs(ratio))
        if count >= MIN_SAMPLES and c == 0:
            motor = total / count
        elif count >= MIN_SAMPLES:
            arm = total / count
    return motor, arm, largest


@lru_cache(maxsize=64)
def nis_limits(dof: float) -> tuple[float, float]:
    """Return (low, high) of the mean NIS per degree of freedom, of `dof` in all."""
    import scipy
    return (float(scipy.special.chdtri(dof, 1.0 - LIMITS.error_significance / 2)) / dof,
            float(scipy.special.chdtri(dof, LIMITS.error_significance / 2)) / dof)


def _mean(white: Array) -> float:
    """Return the larger abs(mean) sqrt(N) of the channels of `white` [N, 2]."""
    sums = [_finite_sum(white[:, c]) for c in range(2)]
    return max((abs(total) / math.sqrt(n) for total, n in sums if n >= LAGS), default=0.0)


def _whiteness(white: Array) -> tuple[float, float]:
    """Return ljung_box of the channel of `white` [N, 2] that is farther from white."""
    return max(ljung_box(white[:, 0]), ljung_box(white[:, 1]))


def flags(white: Array, nis: Array, dof: Array) -> dict[str, bool]:
    """
    Return whether significance alone speaks against a window of W samples.

    If the filter's model were exact, each test would flag `error_significance` of windows
    (whiteness: of long ones).

    Args:
        white: whitened innovations [W, 2], NaN where not measured.
        nis: normalised innovation squared [W].
        dof: its degrees of freedom [W].

    Returns:
        {test: bool} for the tests mean, whiteness (Ljung-Box) and nis (chi-square).

    """
    total = float(np.sum(dof))
    low, high = nis_limits(total)
    return {'mean': _mean(white) > MEAN_LIMIT,
            'whiteness': _whiteness(white)[0] > LJUNG_BOX_LIMIT,
            'nis': not low <= float(np.sum(nis)) / total <= high}


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
    total = float(dof.sum())
    if len(nis) < MIN_SAMPLES or total < MIN_SAMPLES:
        return outcome_of([TOO_FEW], '', {'window_samples': len(nis)})
    mean = _mean(white[len(white) - recent:])
    box, predictable = _whiteness(white)
    predictable_limit = LIMITS.predictable + LAGS / len(nis)
    ratio = float(nis.sum()) / total
    low, high = nis_limits(total)
    low, high = min(low, LIMITS.nis_low), max(high, LIMITS.nis_high)
    motor, arm, gate = _sizes(errors, stds, newest)
    gate /= LIMITS.gate
    values = {
        'mean': mean, 'mean_threshold': MEAN_LIMIT,
        'ljung_box': box, 'ljung_box_threshold': LJUNG_BOX_LIMIT,
        'predictable_share': predictable, 'predictable_share_threshold': predictable_limit,
        'nis_over_dof': ratio, 'nis_low': low, 'nis_high': high, 'nis_gross': LIMITS.nis_gross,
        'variance_ratio_motor': motor, 'variance_ratio_arm': arm,
        'variance_ratio_low': LIMITS.variance_low, 'variance_ratio_high': LIMITS.variance_high,
        'test_ratio': gate, 'test_ratio_threshold': 1.0, 'window_samples': len(nis)}
    broken = [condition for condition, is_broken in (
        (BIASED, mean > MEAN_LIMIT),
        (COLOURED, box > LJUNG_BOX_LIMIT and predictable > predictable_limit),
        (GROSS, not ratio <= LIMITS.nis_gross),
        (LARGER, high < ratio <= LIMITS.nis_gross),
        (SMALLER, ratio < low),
        (MOTOR_VARIANCE, not LIMITS.variance_low <= motor <= LIMITS.variance_high),
        (ARM_VARIANCE, not LIMITS.variance_low <= arm <= LIMITS.variance_high),
        (OUTLIERS, gate > 1.0)) if is_broken]
    return outcome_of(broken, 'prediction errors as predicted', values)
