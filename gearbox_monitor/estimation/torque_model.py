# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a filter takes for the law of tau_K: a random walk, or the model's curve and a deviation.

random_walk: tau_K itself wanders (the paper). elastic: the curve of the model file over the twist,
plus a deviation that wanders. learned: the same with stiffness, half gap and hysteresis as states.
mixed: a filter of each, see model_bank; the random walk leads.
"""
from collections.abc import Collection
import math

from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import CURVES, EstimatorParameters, LEARNED, RANDOM_WALK
from gearbox_monitor.plant.drive import DriveModel

# What is learnt stays within this factor of the model's stiffness.
LEARNT_RANGE = 10.0
MEMORY, LEARNT = 'twist_memory', ('stiffness', 'gap_torque', 'hysteresis_torque')
# Spectral density of the memory's noise over the variance of its start, per s: a smoother needs
# one, as on a branch the memory follows from the other states.
MEMORY_NOISE = 1e-6
# How large the hysteresis may be at a start beside the gap; both shift the flanks, and a wider one
# takes the place of the gap before the twist has turned often enough to tell them apart.
HYSTERESIS_SHARE = 0.3


def curve_states(model: DriveModel, name: str) -> list[str]:
    """Return the names of the states that the torque model `name` adds for the drive `model`."""
    if name not in CURVES:
        return []
    if name == LEARNED:
        return [MEMORY, *LEARNT]
    shape = model.folded().transmission
    return [MEMORY] if shape.kind != 'dead_zone' and shape.hysteresis_width > 0.0 else []


def curve_drive(model: DriveModel, parameters: EstimatorParameters,
                offered: Collection[str]) -> DriveModel:
    """
    Return a drive with only those values of its transmission that its kind uses.

    Args:
        model: of the drive.
        parameters: of the filter.
        offered: torque models that the filter can take.

    Returns:
        The drive.

    Raises:
        InputError: no curve goes with the parameters.

    """
    name = parameters.tau_k_model
    if name not in offered:
        raise InputError(f'tau_k_model: {name}, expected {" or ".join(offered)} with filter '
                         f'{parameters.filter}')
    if parameters.tau_k_stiffness > 0.0:
        raise InputError(f'tau_k_stiffness: {parameters.tau_k_stiffness:g}, expected 0 with '
                         f'tau_k_model {name}, whose curve has a stiffness of its own')
    if not parameters.arm_joint:
        raise InputError(f'tau_k_model: {name}, expected {RANDOM_WALK} where no arm is measured '
                         '(arm_joint is empty): there is no twist')
    model = model.folded()
    shape = model.transmission
    return model.with_(
        hysteresis_width=0.0 if shape.kind == 'dead_zone' else shape.hysteresis_width,
        hysteresis_stiffness=shape.hysteresis_stiffness if shape.kind == 'passive_play' else 0.0)


def start_deviations(model: DriveModel, parameters: EstimatorParameters) -> dict[str, float]:
    """
    Return {state of the curve: its standard deviation at a start} for the drive `model`.

    Relative to the model's values by p0_std_curve; torques are no smaller than p0_std_torque, so
    that a model without backlash can learn one.
    """
    shape, relative = model.transmission, parameters.p0_std_curve
    torque = math.hypot(shape.stiffness * max(shape.half_gap, shape.hysteresis_width),
                        parameters.p0_std_torque)
    return dict(zip((MEMORY, *LEARNT), (
        torque / shape.stiffness, relative * shape.stiffness, relative * torque,
        HYSTERESIS_SHARE * relative * torque)))
