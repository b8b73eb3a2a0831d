# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Whiteness of innovations: the portmanteau statistic of Ljung and Box (Biometrika 65, 1978)."""
from functools import lru_cache
import math

import numpy as np

from gearbox_monitor.kernels.kernel import entry
from gearbox_monitor.kernels.types import Array, Vector

MIN_SAMPLES = 100
LAGS = 20


@entry
def _centre(column: Vector, out: Vector) -> int:
    """Write finite values of `column` [N] less their mean behind LAGS of `out`; return the end."""
    at, total = LAGS, 0.0
    for i in range(column.shape[0]):
        if math.isfinite(column[i]):
            out[at] = column[i]
            total += column[i]
            at += 1
    mean = total / (at - LAGS)
    for i in range(LAGS, at):
        out[i] -= mean
    return at


@lru_cache(maxsize=64)
def _weights(n: int) -> Array:
    weights: Array = n * (n + 2.0) / np.arange(n - 1.0, n - LAGS - 1.0, -1.0)
    return weights


def ljung_box(e: Array) -> tuple[float, float]:
    """
    Return (Q of Ljung and Box over LAGS lags, sum of squared correlations) of `e` [N].

    NaN is left out; zeros where fewer than MIN_SAMPLES are left, or all are alike.
    """
    out = np.zeros(LAGS + len(e))
    centred = out[:_centre(e, out)]
    n = len(centred) - LAGS
    if n < MIN_SAMPLES:
        return 0.0, 0.0
    products = np.correlate(centred, centred[LAGS:])
    energy = products[LAGS]
    if not energy > 0.0:
        return 0.0, 0.0  # constant: a matter for the mean
    squares = (products[LAGS - 1::-1] / energy) ** 2
    return float(squares @ _weights(n)), float(squares.sum())
