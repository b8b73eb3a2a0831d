# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whether the curve that the filter has learnt is that of the model file.

A load on the arm absorbs an error of the torque, but not the curve. Where the learned curve is
not the likeliest model, what was learnt says nothing.
"""
from collections.abc import Mapping
from dataclasses import replace

from gearbox_monitor.health.alert_limits import LIMITS
from gearbox_monitor.health.checks.outcome import Condition, Level
from gearbox_monitor.parameters import EstimatorParameters, LEARNED
from gearbox_monitor.plant.drive import DriveModel


_WHEN = (f'{{}} from the model file by more than `{{}}`, its deviation < {LIMITS.learned_std:g} '
         f'of it, and more than {LIMITS.learned_deviations:g} deviations beyond; `tau_k_model` '
         'learned, or mixed with a probability of the learned curve >= '
         f'{LIMITS.learned_probability:g}')
STIFFNESS = Condition(
    'model', Level.WARN, 'learned stiffness differs from the model file',
    _WHEN.format('`learned_stiffness` differs', 'stiffness_error'), 'the evaluation',
    'check the scale of the torque and of both encoders, then stiffness in the model file; a drop '
    'over weeks is wear', ('learned_stiffness',))
GAP = Condition(
    'model', Level.WARN, 'learned backlash differs from the model file',
    _WHEN.format('`learned_gap_rad` differs', 'gap_error'), 'the evaluation',
    'check the scale of both encoders, then half_gap in the model file; a growth over weeks is '
    'wear', ('learned_gap_rad',))
CONDITIONS = (STIFFNESS, GAP)


def check(values: Mapping[str, float], drive: DriveModel,
          parameters: EstimatorParameters) -> list[Condition]:
    """
    Return the conditions that do not hold.

    Args:
        values: of Estimator.learned_curve; {} where nothing is learnt.
        drive: whose curve is compared with.
        parameters: how far the values may be from it.

    """
    if not values or values.get(f'probability_{LEARNED}', 1.0) < LIMITS.learned_probability:
        return []
    shape, broken = drive.transmission, []
    for condition, key, unit, model, tolerance in (
            (STIFFNESS, 'learned_stiffness', '', shape.stiffness, parameters.stiffness_error),
            (GAP, 'learned_gap', '_rad', 2.0 * shape.half_gap, parameters.gap_error)):
        value, std = values[key + unit], values[f'{key}_std{unit}']
        beyond = max(value - model * (1.0 + tolerance), model / (1.0 + tolerance) - value)
        if (std < LIMITS.learned_std * value and beyond > LIMITS.learned_deviations * std
                and model > 0.0):
            broken.append(replace(
                condition, says=f'{condition.says} (x {value / model:.2f})'))
    return broken
