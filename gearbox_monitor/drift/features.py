# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Backlash features from a window of smoothed torque over twist.

Least squares of tau = K dz(twist - t0, b): stiffness K, half gap b and the zero t0 of the twist
(the encoders share none). Fit on smoothed values only: the filter's lag draws a hysteresis loop
that is not there.
"""
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

MAX_POINTS = 2000
MIN_POINTS = 50
# Each flank must hold this share of the window, or the gap is not excited.
MIN_FLANK = 0.03
# Torque counts as loading a flank, and stiffness as seen, from so many standard deviations on.
LOADED = 3.0


@dataclass(frozen=True)
class Backlash:
    """
    Features of one window: gap (rad, full width 2 b), stiffness (N m/rad), twist zero (rad).

    *_std: standard deviations. `flank`: share of samples on the less visited flank. The window
    ends at `stamp_ns`.
    """

    stamp_ns: int
    gap: float
    gap_std: float
    stiffness: float
    stiffness_std: float
    zero: float
    flank: float


def _dead_zone(twist, half_gap):
    return np.sign(twist) * np.maximum(np.abs(twist) - half_gap, 0.0)


def fit(twist, tau_k, stamp_ns, tau_k_std=0.0):
    """
    Return the Backlash of a window, or None where the motion does not excite it.

    twist [N] rad and tau_k [N] N m, smoothed; the window ends at `stamp_ns`. tau_k_std: stated
    deviation of tau_k, [N] or one for all; each flank must stand out of it.
    """
    loaded = np.asarray(tau_k) / np.maximum(LOADED * np.asarray(tau_k_std), 1e-300)
    if not len(loaded) or min((loaded > 1.0).mean(), (loaded < -1.0).mean()) < MIN_FLANK:
        return None
    stride = max(1, len(twist) // MAX_POINTS)
    twist, tau_k = np.asarray(twist)[::stride], np.asarray(tau_k)[::stride]
    spread = np.ptp(twist) if len(twist) else 0.0
    if len(twist) < MIN_POINTS or not spread > 0.0:
        return None
    middle = 0.5 * (twist.max() + twist.min())

    def residual(theta):
        stiffness, half_gap, zero = theta
        return stiffness * _dead_zone(twist - zero, half_gap) - tau_k

    def jacobian(theta):
        stiffness, half_gap, zero = theta
        shifted = twist - zero
        outside = np.abs(shifted) > half_gap
        return np.stack([_dead_zone(shifted, half_gap),
                         -stiffness * np.sign(shifted) * outside,
                         -stiffness * outside.astype(float)], axis=1)

    best = None
    for share in (0.1, 0.25, 0.4):  # the cost has a local minimum where a flank is missed
        half_gap = share * spread
        basis = _dead_zone(twist - middle, half_gap)
        stiffness = max(float(basis @ tau_k / max(basis @ basis, 1e-300)), 1e-12)
        result = least_squares(
            residual, [stiffness, half_gap, middle], jacobian, x_scale='jac',
            bounds=([0.0, 0.0, twist.min()], [np.inf, spread, twist.max()]), max_nfev=50)
        if best is None or result.cost < best.cost:
            best = result
    stiffness, half_gap, zero = best.x
    shifted = twist - zero
    flank = float(min((shifted > half_gap).mean(), (shifted < -half_gap).mean()))
    if flank < MIN_FLANK or stiffness <= 0.0:
        return None
    # Smoothed residuals are correlated: least squares' own deviations are about half the truth.
    variance = 4.0 * 2.0 * best.cost / (len(twist) - 3)
    covariance = variance * np.linalg.pinv(best.jac.T @ best.jac)
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if stiffness < LOADED * std[0]:
        return None
    return Backlash(stamp_ns, float(2 * half_gap), float(2 * std[1]), float(stiffness),
                    float(std[0]), float(zero), flank)
