# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the adaptive filter may adapt, and the refusals, each with its reason.

All of it is adapted as a logarithm: standard deviations, friction and stiffness stay positive.
model: DriveModel. parameters: those of the estimator.
"""
from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel

# Parameters of the estimator, and fields of the model.
NOISE = ('q_std_tau_k', 'r_std_motor', 'r_std_arm')
MODEL = ('viscous_friction', 'coulomb_friction')
ADAPTABLE = NOISE + MODEL + ('tau_k_stiffness',)
REFUSED = {
    'damping': 'it cannot be distinguished from tau_K: a damping of many times the truth '
    'compensates for the lag of the random walk of tau_K',
}


def softened_model(model: DriveModel, parameters: EstimatorParameters) -> DriveModel:
    """
    Return `model` with the friction of an adaptive filter: atan, as soft as `parameters` say.

    A sharp friction step is far narrower than the speed is known to: with it the likelihood is
    rough and its gradient, though exact, leads nowhere.
    """
    soft, arm = parameters.adapt_friction_sharpness, model.arm_sharpness
    return model.with_(friction_law={'kind': 'atan'}, integrator='rk4',
                       friction_sharpness=min(model.friction_sharpness, soft),
                       arm_friction_sharpness=min(arm, soft))


def adapted_names(model: DriveModel, parameters: EstimatorParameters) -> list[str]:
    """Return the names in `parameters` to adapt to `model`. Raises InputError for a bad one."""
    names = [name for name in parameters.adapt if name]  # [''] is how ROS writes "none"
    for name in names:
        where = f'parameters: adapt: {name!r}'
        if name not in ADAPTABLE:
            reason = f' ({REFUSED[name]})' if name in REFUSED else ''
            raise InputError(f'{where}{reason}, expected some of {", ".join(ADAPTABLE)}')
        if names.count(name) > 1:
            raise InputError(f'{where}: named twice, expected once')
        value = getattr(model, name) if name in MODEL else getattr(parameters, name)
        if not value > 0.0:
            raise InputError(f'{where}: adapted as a logarithm, but starts at {value:g}; expected '
                             'a start > 0')
    return names
