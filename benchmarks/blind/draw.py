# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Random nominal drives and effects of random size."""
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.blind.plant import EFFECTS, NOMINAL, Nominal, OUTSIDE

QUANTISATION = ('motor_encoder_quantisation', 'arm_encoder_quantisation')
# A change of one value of the nominal model.
REPLACES = {'motor_viscous': 'Cv', 'motor_coulomb': 'Cc', 'motor_inertia': 'm1',
            'arm_inertia': 'm2', 'backlash_gap': 'b', 'stiffness': 'K',
            'transmission_damping': 'D', 'servo_gain': 'kp'}
# Nominal values that scatter in the stress set.
SCATTERED = ('m1', 'm2', 'D', 'Cv', 'Cc', 'K', 'b')
# Not both at once: they act on the same number, are the same torque, or have no evidence.
CONFLICTS = [{'motor_viscous', 'viscous_drift'}, {'lugre', 'stribeck'},
             {'lugre', 'motor_coulomb'}, {'torque_offset', 'coulomb_asymmetry'},
             {'servo_gain', 'torque_gain'}, {'setpoint_delay', 'setpoint_lag'},
             {'servo_feedforward', 'servo_deadband'}]  # what the deadband acts on is a convention
# A delay hides compliance in other tools: of setpoints each is drawn more often.
DELAYS, COMPLIANCES = ('setpoint_delay', 'servo_delay'), ('stiffness', 'backlash_gap')
# Effects whose size is relative to Coulomb friction; every tenth of the other recordings is of a
# drive without it.
OF_COULOMB = {'motor_coulomb', 'stribeck', 'lugre', 'coulomb_asymmetry', 'motor_friction_angle'}
SMOOTH = 10
NEVER_IN_PAIRS = {'disturbance', *QUANTISATION}


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """
    Return a number whose logarithm is uniformly distributed.

    Args:
        random: source of random numbers.
        low: smallest value, > 0.
        high: largest value.
    """
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def nominal(random: np.random.Generator) -> dict[str, float]:
    """Return nominal values of a drive that `random` spreads around the paper's."""
    values = dict(NOMINAL)
    for name in ('m1', 'm2', 'Cv', 'Cc'):
        values[name] *= log_uniform(random, 0.7, 1.4)
    values['D'] *= log_uniform(random, 0.5, 5.0)
    values['Kr'] *= log_uniform(random, 0.5, 2.0)
    values['K'] = log_uniform(random, 5.0, 60.0)
    values['b'] = log_uniform(random, 0.02, 0.4)
    return {k: float(f'{v:.4g}') for k, v in values.items()}


# id -> (lowest, highest size); what a size means: see effect().
SIZES = {name: sizes for name, (_, _, sizes) in {**EFFECTS, **OUTSIDE}.items()}


def shape(random: np.random.Generator, duration: float) -> dict[str, Any]:
    """Draw with `random` all of an effect but its size, for a recording of `duration` s."""
    return {'sign': float(random.choice([-1.0, 1.0])), 'phi': float(random.uniform(-3.1, 3.1)),
            'N': int(random.integers(1, 41)), 'vs': log_uniform(random, 0.1, 3.0),
            'sigma0': log_uniform(random, 20.0, 500.0), 'sigma1': log_uniform(random, 0.01, 0.3),
            'T': log_uniform(random, 2.0, 15.0), 'width': log_uniform(random, 0.003, 0.08),
            'f': float(random.uniform(0.5, 8.0)),
            'bursts': [{'t0': float(random.uniform(0.3, duration - 0.5)),
                        'duration': log_uniform(random, 0.02, 0.15),
                        'share': float(random.choice([-1.0, 1.0]) * random.uniform(0.5, 1.0))}
                       for _ in range(int(random.integers(2, 5)))]}


def effect(name: str, size: float, form: Mapping[str, Any], values: Nominal,
           scene: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return an effect in the parameters of the vocabulary.

    Args:
        name: its id.
        size: see SIZES.
        form: everything else about it, from shape().
        values: nominal values of the drive.
        scene: peak torque `peak` (N m), its rms `rms` (N m), encoder noise `sigma` [2] (rad).
    """
    sign, phi = form['sign'], form['phi']
    out: dict[str, Any] = {'id': name}
    if name in REPLACES:
        key = REPLACES[name]
        # down by a factor, up by a share: never below zero
        out[key] = values[key] * ((1.0 + size) if sign > 0 else 1.0 / (1.0 + size))
    elif name == 'stribeck':
        out.update(Cs=size, vs=form['vs'])
    elif name == 'lugre':
        out.update(sigma0=form['sigma0'], sigma1=form['sigma1'], Cs=size, vs=form['vs'])
    elif name == 'viscous_drift':
        out.update(r=size if sign > 0 else -size / (1.0 + size), T=form['T'])
    elif name in ('cogging', 'mesh_error', 'torque_ripple'):
        out.update(A=size, N=form['N'], phi=phi)
    elif name == 'gravity':
        out.update(G=size, phi=phi)
    elif name == 'disturbance':
        out['bursts'] = [{'t0': b['t0'], 'duration': b['duration'],
                          'amplitude': size * b['share']} for b in form['bursts']]
    elif name == 'hardening':
        # size: cubic over linear torque at the torque's rms
        out['K3'] = size * values['K'] ** 3 / scene['rms'] ** 2
    elif name == 'hysteresis_bouc_wen':
        out.update(Th=size, dh=form['width'])
    elif name == 'hysteresis_branch':
        # the branches lie apart by a share of the gap, or of the twist at the torque's rms
        out.update(h=size * max(values['b'], scene['rms'] / values['K']) / 2, ds=form['width'])
    elif name in ('saturation', 'servo_limit'):
        out['umax'] = (1.0 - size) * scene['peak']
    elif name in QUANTISATION:
        out['q'] = size * scene['sigma'][name.startswith('arm')]
    elif name.endswith(('_eccentricity', '_harmonic')) or name in (
            'motor_friction_angle', 'stiffness_angle', 'gap_angle', 'arm_fan'):
        out.update(phi=phi)
        out['A' if name == 'arm_fan' or 'encoder' in name else 'a'] = size
        if name == 'arm_fan':
            out['f'] = form['f']
    elif name == 'torque_rate':
        out['rate'] = scene['peak'] / (0.2 * size)
    elif name in ('coulomb_asymmetry', 'viscous_asymmetry', 'load_torque', 'torque_offset',
                  'encoder_offset', 'torque_gain', 'stiffness_sides'):
        key, = {**EFFECTS, **OUTSIDE}[name][1]
        down = name in ('torque_gain', 'stiffness_sides') and sign < 0
        out[key] = -size / (1.0 + size) if down else sign * size
    else:
        key, = {**EFFECTS, **OUTSIDE}[name][1]
        out[key] = size
    return out


def compatible(first: str, second: str) -> bool:
    """Return whether the ids `first` and `second` can be a pair: both visible, well defined."""
    places = EFFECTS[first][0], EFFECTS[second][0]
    return (first != second and not {first, second} & NEVER_IN_PAIRS
            and {first, second} not in CONFLICTS and places != ('actuator', 'actuator'))
