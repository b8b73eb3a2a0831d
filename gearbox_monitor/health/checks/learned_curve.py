# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether the curve that the filter has learnt is that of the model file.

A load on the arm absorbs an error of the torque, but not the curve. Where the learned curve is
not the likeliest model, what was learnt says nothing.
"""
from collections.abc import Mapping

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level, Said
from gearbox_monitor.parameters import EstimatorParameters, LEARNED
from gearbox_monitor.plant.drive import DriveModel

STIFFNESS = Condition('learned_stiffness', 'model', Level.WARN, ('learned_stiffness',))
GAP = Condition('learned_gap', 'model', Level.WARN, ('learned_gap_rad',))
CONDITIONS = (STIFFNESS, GAP)


def check(values: Mapping[str, float], drive: DriveModel,
          parameters: EstimatorParameters) -> list[Said]:
    """
    Return the conditions that do not hold.

    Args:
        values: of Estimator.learned_curve; {} where nothing is learnt.
        drive: whose curve is compared with.
        parameters: how far the values may be from it.

    """
    if not values or values.get(f'probability_{LEARNED}', 1.0) < LIMITS.learned_probability:
        return []
    shape, broken = drive.transmission, list[Said]()
    for condition, key, unit, model, tolerance in (
            (STIFFNESS, 'learned_stiffness', '', shape.stiffness, parameters.stiffness_error),
            (GAP, 'learned_gap', '_rad', 2.0 * shape.half_gap, parameters.gap_error)):
        value, std = values[key + unit], values[f'{key}_std{unit}']
        beyond = max(value - model * (1.0 + tolerance), model / (1.0 + tolerance) - value)
        if (std < LIMITS.learned_std * value and beyond > LIMITS.learned_deviations * std
                and model > 0.0):
            broken.append(condition.said(factor=value / model))
    return broken
