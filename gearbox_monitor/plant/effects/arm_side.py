# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects on the arm's side of the gearbox: its friction, weight, inertia and loads."""
import numpy as np

from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.effect import (
    BalanceColumn, Effect, FreeParameter, of_model, Parameter, positive, PROFILE, Scales, Starts,
    wave, wave_values, waves)

_M2 = Parameter('m2', 'kg m^2', 1e-9)

ARM_VISCOUS = Effect(
    'arm_viscous', 'arm_side', 'tau_arm += Cav x4', (positive('Cav', 'N m s/rad'),),
    noun='viscous friction',
    shows='The arm is braked in proportion to its own speed; the gearbox transmits that torque, '
          'so the twist shows it.',
    meaning='viscous friction on the arm', in_filters=True, additive=True,
    counterpart='motor_viscous', merges_if_rigid=True,
    starts=lambda s: [[FreeParameter('Cav', 0.0, 0.1 * s.torque / s.speed, 0.0)]],
    separated_by={'arm_coulomb': 'steps to several speeds'})


def _coulomb_starts(s: Scales) -> Starts:
    return [[FreeParameter('Cac', f * s.friction, 0.1 * s.torque, 0.0, s.peak)]
            for f in ((0.0, 0.7) if s.swing else (0.0,))]


ARM_COULOMB = Effect(
    'arm_coulomb', 'arm_side', 'tau_arm += Cac s(x4)', (positive('Cac', 'N m'),),
    noun='Coulomb friction',
    shows='The arm stops sooner than in the model, and the twist changes sign with its direction '
          'even at constant speed.',
    meaning='Coulomb friction on the arm', in_filters=True, additive=True,
    counterpart='motor_coulomb', merges_if_rigid=True, starts=_coulomb_starts)

GRAVITY = Effect(
    'gravity', 'arm_side', 'tau_arm += G sin(x2 + phi)',
    (Parameter('G', 'N m'), Parameter('phi', 'rad', default=0.0)),
    noun='weight',
    shows='The torque that holds the arm depends on its angle, as a sine; the arm drifts from '
          'where the model holds it.',
    meaning='weight of the arm', in_filters=True, additive=True, rotary_only=True,
    starts=wave(lambda s: 0.1 * s.torque),
    separated_by={'cogging': 'a wide range of angles'},
    column=BalanceColumn(lambda m, _: waves(m.q), wave_values('G')))

LOAD_TORQUE = Effect(
    'load_torque', 'arm_side', 'tau_arm += TL', (Parameter('TL', 'N m'),),
    noun='constant load',
    shows='The twist has an offset at all angles and in both directions: one tooth flank carries '
          'nearly all the time.',
    meaning='constant torque on the arm', in_filters=True, additive=True, merges_if_rigid=True,
    starts=lambda s: [[FreeParameter('TL', 0.0, 0.1 * s.torque, -s.peak, s.peak)]],
    separated_by={'torque_offset': 'slow moves and dwells'})

ARM_INERTIA = Effect(
    'arm_inertia', 'arm_side', 'm2 differs from the model file', (_M2,),
    noun='inertia',
    shows='The arm accelerates less (or more) than in the model, and its resonance with the '
          'gearbox has another frequency.',
    meaning='inertia of the arm differs from the model, as with a payload',
    replaces='arm_inertia', merges_if_rigid=True,
    starts=of_model(_M2, 'arm_inertia', PROFILE))


def burst(effect: Values, t: Array, dt: float) -> Array:
    """
    Return the torque of a burst.

    Args:
        effect: values of t0 (s), duration (s) and amplitude (N m).
        t: begins of steps [N], s.
        dt: length of the steps, s.

    Returns:
        Mean torque in each step [N], N m.
    """
    begin, end = effect['t0'], effect['t0'] + effect['duration']
    covered = np.minimum(t + dt, end) - np.maximum(t, begin)
    return effect['amplitude'] * np.clip(covered / dt, 0.0, 1.0)


# Found as a free-form torque on the arm, see diagnosis.joint.localisation.
DISTURBANCE = Effect(
    'disturbance', 'arm_side', 'tau_arm += amplitude from t0 for duration, a few times',
    (Parameter('t0', 's', 0.0), positive('duration', 's'), Parameter('amplitude', 'N m')),
    noun='torque bursts',
    shows='The model fits, except in a few short spans of time that do not repeat with the '
          'motion.',
    meaning='short torque bursts on the arm, as from contacts',
    arm_profile=burst, additive=True, starts=None)
