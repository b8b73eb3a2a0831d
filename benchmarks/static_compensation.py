# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Static compensation: torque from motor current with friction and inertia, no filter of states.

    tau = kt i - Cc tanh(v/w) - Cv v - J a + offset

The opponent of the estimator. Speed v, acceleration a and current pass one causal Butterworth
low-pass. kt, Cc, Cv, J and the offset are fitted by least squares to a torque sensor; order and
frequency of the low-pass and the width w are chosen on the same runs.
"""
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.signal import butter, sosfilt, sosfilt_zi

from benchmarks.real_fit import DriveRecording
from gearbox_monitor.kernels.types import Array

Filtered = tuple[Array, Array, Array]  # low-passed current (A), speed, acceleration

ORDERS = (1, 2)
FREQUENCIES = (3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0)   # Hz
WIDTHS = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02)      # rad/s


@dataclass(frozen=True)
class StaticCompensation:
    """`coefficients` [5] of current, tanh(v/w), v, a and 1; frequency in Hz, width in rad/s."""

    order: int
    frequency: float
    width: float
    coefficients: Array

    def torque(self, run: DriveRecording) -> Array:
        """Return the estimated torque [N] (N m) of a `run`."""
        return _regressors(_filtered(run, self.order, self.frequency),
                           self.width) @ self.coefficients


def _filtered(run: DriveRecording, order: int, frequency: float) -> Filtered:
    """Return low-passed current, speed and acceleration, each [N]."""
    sos = butter(order, frequency, fs=1.0 / run.period, output='sos')
    speed = np.diff(run.outputs[:, 0], prepend=run.outputs[0, 0]) / run.period

    def low_pass(x: Array) -> Array:
        """Return the signal `x` low-passed, from its steady state on."""
        filtered: Array = sosfilt(sos, x, zi=sosfilt_zi(sos) * x[0])[0]
        return filtered
    speed = low_pass(speed)
    return low_pass(run.current), speed, np.diff(speed, prepend=speed[0]) / run.period


def _regressors(filtered: Filtered, width: float) -> Array:
    current, speed, acceleration = filtered
    return np.column_stack(
        [current, np.tanh(speed / width), speed, acceleration, np.ones_like(speed)])


def _solve(filtered: Sequence[Filtered], targets: Array, burn_in: int,
           width: float) -> tuple[float, Array]:
    matrix = np.concatenate([_regressors(f, width)[burn_in:] for f in filtered])
    coefficients = np.linalg.lstsq(matrix, targets, rcond=None)[0]
    return float(np.sqrt(np.mean((matrix @ coefficients - targets) ** 2))), coefficients


def fit_static(runs: Sequence[DriveRecording], burn_in: int,
               orders: Sequence[int] = ORDERS) -> StaticCompensation:
    """
    Fit static compensation to the torque sensor: least squares within a search over the low-pass.

    Args:
        runs: recordings to fit.
        burn_in: samples that are left out at the beginning of each.
        orders: of the low-pass, to choose from.

    Returns:
        The compensation with the least RMS error.
    """
    targets = np.concatenate([r.reference[burn_in:] for r in runs])
    optimum = (np.inf, 0, 0.0, 0.0)
    for order in orders:
        for frequency in FREQUENCIES:
            filtered = [_filtered(r, order, frequency) for r in runs]
            for width in WIDTHS:
                rmse, _ = _solve(filtered, targets, burn_in, width)
                optimum = min(optimum, (rmse, order, frequency, width))
    order = optimum[1]

    def cost(log: Array) -> float:
        """Return the RMS error at the logarithms `log` of cut-off frequency and width."""
        frequency, width = np.exp(log)
        return _solve([_filtered(r, order, frequency) for r in runs], targets, burn_in, width)[0]
    log = minimize(cost, np.log(optimum[2:]), method='Nelder-Mead',
                   options={'maxfev': 40, 'fatol': 1e-6, 'xatol': 0.01}).x
    frequency, width = np.exp(log)
    filtered = [_filtered(r, order, frequency) for r in runs]
    return StaticCompensation(order, float(frequency), float(width),
                              _solve(filtered, targets, burn_in, width)[1])
