# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether model mismatch: prediction errors that stay systematic.

One window of biased or coloured errors can be a bump; a minute of them is the model. The next step
is then a diagnosis (docs/diagnose.md), not another tuning.
"""
from collections import deque

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Outcome, outcome_of, Said

SECOND = 1_000_000_000

MISSING = Condition('mismatch', 'model', Level.WARN, ('systematic_s',),
                    ('systematic_s_threshold',))
CONDITIONS = (MISSING,)


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
              'systematic_s_threshold': LIMITS.systematic_share * window,
              'window_s': window}
    hidden = (Said('load_hides'),) if unknown_load else ()
    return outcome_of([MISSING.said()] if seconds > LIMITS.systematic_share * window else [],
                      Said('holds', {'hidden': hidden}), values)
