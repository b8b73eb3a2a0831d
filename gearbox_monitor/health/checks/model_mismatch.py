# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether model mismatch: prediction errors that stay systematic.

One window of biased or coloured errors can be a bump; a minute of them is the model. The next step
is then a diagnosis (docs/diagnose.md), not another tuning.
"""
from collections import deque
from collections.abc import Mapping

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of
from gearbox_monitor.parameters import EstimatorParameters, LEARNED
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import Said

SECOND = 1_000_000_000

MISSING = Condition('mismatch', 'model', Level.WARN, ('systematic_s',),
                    ('systematic_s_threshold',))
STIFFNESS = Condition('learned_stiffness', 'model', Level.WARN, ('learned_stiffness',))
GAP = Condition('learned_gap', 'model', Level.WARN, ('learned_gap_rad',))
CONDITIONS = (MISSING, STIFFNESS, GAP)


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


def check(systematic: Systematic, stamp_ns: int, window: float, unknown_load: bool) -> Outcome:
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
