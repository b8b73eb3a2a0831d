# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the effort is: a torque, a current, or a torque without that against the weight.

Motor and twist give the torque a second time, in which the load on the arm has no part:

    tau = M1 x1'' + Cv x1' + Cc (2/pi) atan(alpha x1') + K dz(x1 - x2, b) + D (x1' - x2') + u0

with the values of the model within their tolerances. A torque equals it, a current is a constant
multiple of it far from 1, and a torque that lacks the weight differs by a sine and a cosine of the
arm's angle. Each is fitted (least squares with priors); its likelihood takes an error of a model
for granted and counts only independent samples, as in wiring.
"""
from itertools import product
import math

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.signals.finding import DataFinding, hurts, WARN
from gearbox_monitor.signals.recording_limits import LIMITS
from gearbox_monitor.signals.smoothed_motion import SmoothedMotion
from gearbox_monitor.signals.wiring import independent

ROWS = 1000        # that are fitted
GAPS = (0.5, 0.7, 1.0, 1.4, 2.0)  # parts of the model's half gap that are tried
FACTORS = 10.0 ** np.arange(-3.0, 3.01, 0.05)
(TORQUE, CURRENT, COMPENSATED) = READINGS = ('torque', 'current', 'gravity_compensated')


def likelihoods(smooth: SmoothedMotion, model: DriveModel) -> tuple[dict[str, float], float]:
    """
    Return the log-likelihood of each of READINGS, and the factor of the current.

    Args:
        smooth: smoothed motion, torque as converted by the model.
        model: model of the drive.

    """
    rows = slice(None, None, max(1, len(smooth.u) // ROWS))
    p, v, a, u = smooth.p[rows], smooth.v[rows], smooth.a[rows], smooth.u[rows]
    shape, rms = model.transmission, math.sqrt(float(np.mean(u ** 2)))
    twist, weight = p[:, 0] - p[:, 1], [np.sin(p[:, 1]), np.cos(p[:, 1])]
    side = model.friction_side(v[:, 0])
    low, high = np.percentile(twist, (2, 98))
    gaps = [part * shape.half_gap for part in (GAPS if shape.half_gap > 0.0 else (1.0,))]
    curves = [twist - zero - np.clip(twist - zero, -gap, gap)
              for zero, gap in product((0.0, 0.5 * (low + high)), gaps)]
    sizes = np.array([model.motor_inertia, model.viscous_friction, model.coulomb_friction,
                      shape.stiffness])
    stds = np.array([max(LIMITS.effort_inertia, model.inertia_tolerance), LIMITS.effort_friction,
                     LIMITS.effort_friction, LIMITS.effort_stiffness]) * sizes
    torque = model.position_gain * p[:, 0] + model.damping * (v[:, 0] - v[:, 1])

    def best(factors: Array, more: list[Array]) -> Array:
        """Return the log-likelihood of effort = factor tau less what `more` columns give [F]."""
        scale = rms / factors[:, None]
        weights = np.hstack([stds / scale, np.full((len(scale), 1), LIMITS.effort_offset),
                             np.ones((len(scale), len(more)))])
        y = u / factors[:, None] - torque
        tables = [np.column_stack([a[:, 0], v[:, 0], side, curve, np.ones(len(u)), *more])
                  for curve in curves]
        return np.max([_likelihood(columns, weights, (y - columns[:, :4] @ sizes) / scale)
                       for columns in tables], axis=0)

    distant = FACTORS[np.abs(np.log(FACTORS)) > math.log(LIMITS.effort_near)]
    currents = best(distant, [])
    k = int(np.argmax(currents))
    return {TORQUE: float(best(np.ones(1), [])[0]),
            CURRENT: float(currents[k]) - math.log(len(distant)),
            COMPENSATED: float(best(np.ones(1), weight)[0])}, float(distant[k])


def _likelihood(columns: Array, weights: Array, y: Array) -> Array:
    """
    Return the log-likelihoods [F] of `y` by its best fit, with what its parameters cost (Laplace).

    Args:
        columns: [M, P].
        weights: standard deviation of each column's parameter, in the scale of `y` [F, P].
        y: torque less that by the prior means, over its rms as it would be [F, M].

    """
    m = len(columns)
    gram = weights[:, :, None] * (columns.T @ columns / m) * weights[:, None, :]
    right = weights * (y @ columns / m)
    count, floor = np.full((2, len(y)), [[LIMITS.model_samples], [LIMITS.torque_accuracy]])
    for _ in range(3):
        ratio = count / floor
        information = np.eye(columns.shape[1]) + ratio[:, None, None] * gram
        x = np.linalg.solve(information, (ratio[:, None] * right)[:, :, None])[:, :, 0]
        residual = y - (x * weights) @ columns.T
        count = np.clip(independent(residual), 1.0, LIMITS.model_samples)
        floor = LIMITS.torque_accuracy + np.mean(residual ** 2, axis=1)
    return -0.5 * (count * np.log(floor) + np.sum(x ** 2, axis=1)
                   + np.linalg.slogdet(information)[1])


def finding(smooth: SmoothedMotion, model: DriveModel, stated: str) -> DataFinding:
    """
    Return what the effort reads like, against what is stated.

    Args:
        smooth: smoothed motion, torque as converted by the model.
        model: model of the drive.
        stated: parameter effort_is.

    """
    if not (np.isfinite(smooth.u).all() and smooth.u.any()):
        return DataFinding('torque', 'effort', 'no torque to compare')
    scores, factor = likelihoods(smooth, model)
    first, second = sorted(READINGS, key=lambda name: -scores[name])[:2]
    ratio = scores[first] - scores[second]
    values: dict[str, float | str] = {
        f'log_likelihood_{name}': score for name, score in scores.items()}
    if not ratio >= LIMITS.effort_ratio:  # NaN tells nothing, either
        return DataFinding('torque', 'effort', f'{first} or {second}: undecided (log of the '
                           f'likelihood ratio {ratio:.1f}, {LIMITS.effort_ratio:g} wanted)',
                           values=values)
    figure = f'reads like {first} (log of the likelihood ratio {ratio:.0f} over {second})'
    values['effort_is'] = first
    if first == CURRENT:
        values['factor'] = factor
        return DataFinding('torque', 'effort', f'{figure}: {factor:.2g} times the torque',
                           f'set torque_constant: {model.torque_constant / factor:.2g} in the '
                           'model file, and effort_is: current', hurts(WARN, WARN, WARN), values)
    # Where the model converts a current, its torque is what is looked for.
    same = {TORQUE: (TORQUE, 'unknown', CURRENT), COMPENSATED: (COMPENSATED,)}[first]
    if stated in same:
        return DataFinding('torque', 'effort', figure, values=values)
    advice = ('set effort_is: gravity_compensated, with a robot_description'
              if first == COMPENSATED else 'set effort_is: torque')
    return DataFinding('torque', 'effort', figure, advice, hurts(WARN, WARN, WARN), values)
