# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""95 % confidence intervals of what benchmarks count and measure."""
from collections.abc import Sequence

import numpy as np
from scipy import stats

from gearbox_monitor.kernels.types import Array

LEVEL = 0.95


def share(hits: int, total: int) -> list[float]:
    """Return [low, high] (Wilson) of a share for `hits` in `total` trials."""
    if total == 0:
        return [0.0, 1.0]
    interval = stats.binomtest(int(hits), int(total)).proportion_ci(LEVEL, method='wilson')
    return [float(interval.low), float(interval.high)]


def rate(events: int, exposure: float) -> list[float]:
    """Return [low, high] of a Poisson rate after `events` in `exposure` (s, h ...), exact."""
    tail = 0.5 * (1.0 - LEVEL)
    low = stats.chi2.ppf(tail, 2 * events) / 2.0 if events else 0.0
    return [float(low / exposure), float(stats.chi2.isf(tail, 2 * events + 2) / 2.0 / exposure)]


def mean(values: Sequence[float] | Array) -> list[float]:
    """Return [low, high] of the mean of `values`, by bootstrap (delays are skewed)."""
    values = np.asarray(values, float)
    if len(values) < 2 or np.ptp(values) == 0.0:
        return [float(v) for v in (values.min(), values.max())] if len(values) else [np.nan] * 2
    bootstrapped = stats.bootstrap((values,), np.mean, confidence_level=LEVEL, n_resamples=2000,
                                   method='percentile', random_state=np.random.default_rng(0))
    return [float(v) for v in bootstrapped.confidence_interval]


def median(values: Sequence[float] | Array) -> list[float] | None:
    """Return [low, high] of the median of `values` by their order, None of fewer than 6."""
    low, high = stats.quantile_test(values, p=0.5).confidence_interval(LEVEL)
    return [float(low), float(high)] if np.isfinite([low, high]).all() else None


def spread(values: Sequence[float] | Array) -> list[float]:
    """Return [low, high] of the standard deviation of normal, independent `values`."""
    n, s = len(values), float(np.std(values, ddof=1))
    tail = 0.5 * (1.0 - LEVEL)
    return [s * float(np.sqrt((n - 1) / stats.chi2.isf(tail, n - 1))),
            s * float(np.sqrt((n - 1) / stats.chi2.ppf(tail, n - 1)))]
