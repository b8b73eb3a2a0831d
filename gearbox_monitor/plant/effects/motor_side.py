# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects on the motor's side of the gearbox: its friction, inertia and cogging."""
import math

import numpy as np

from gearbox_monitor.kernels.elementary import exponential, sine
from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.plant.effects.effect import (
    AtRest, BalanceColumn, Coefficients, Effect, FreeParameter, logarithmic, MotorFriction,
    not_negative, of_model, one, Parameter, per_unit, PERIOD, positive, PROFILE, Scales, Starts,
    wave, wave_values, waves, whole_friction)
from gearbox_monitor.plant.transmission import side, TANH, TWO_OVER_PI

_CV, _CC = positive('Cv', 'N m s/rad'), positive('Cc', 'N m')
_M1 = Parameter('m1', 'kg m^2', 1e-9)
_SEVERAL_SPEEDS = 'steps to several speeds'


@inline
def relaxed(memory: float, target: float, rate: float, h: float) -> float:
    """
    Return a memory of memory' = rate (target - memory) after a step.

    Args:
        memory: at the begin of the step.
        target: that it approaches, in the unit of `memory`.
        rate: 1/s.
        h: length of the step, s.

    Returns:
        The memory at the end, exact for a constant target.
    """
    return target + (memory - target) * exponential(-rate * h)


@inline
def friction_side(x3: float, base: MotorFriction) -> float:
    """Return the sign of the speed `x3` (rad/s) in the Coulomb friction `base`."""
    return side(base.sharpness * x3, base.law)


# ---------------------------------------------------------------------- values of the model


MOTOR_VISCOUS = Effect(
    'motor_viscous', 'motor_side', 'Cv differs from the model file', (_CV,),
    noun='viscous friction',
    shows='The unexplained torque is proportional to the speed: fast moves are too fast '
          'or too slow, slow ones fit.',
    meaning='viscous friction of the motor differs from the model',
    replaces='viscous_friction', counterpart='arm_viscous',
    starts=of_model(_CV, 'viscous_friction', usual=lambda s: s.torque / s.speed),
    separated_by={'motor_coulomb': _SEVERAL_SPEEDS,
                  'arm_viscous': 'frequent reversals through the backlash',
                  'viscous_drift': 'a longer recording, the same motion early and late'},
    column=BalanceColumn(
        lambda m, whole: per_unit(m.wet, m.v) if whole else m.v[:, None], one('Cv_change'),
        grid=whole_friction, low=lambda m: -math.inf if m.learnt else -m.viscous,
        dissipates=True, states='Cv_change', twins=('arm_viscous',)))

MOTOR_COULOMB = Effect(
    'motor_coulomb', 'motor_side', 'Cc differs from the model file', (_CC,),
    noun='Coulomb friction',
    shows='The unexplained torque has one size at all speeds and changes sign with the '
          'direction; the difference is largest right after a reversal.',
    meaning='Coulomb friction of the motor differs from the model',
    replaces='coulomb_friction', counterpart='arm_coulomb',
    starts=of_model(_CC, 'coulomb_friction', usual=lambda s: s.friction),
    column=BalanceColumn(
        lambda m, whole: per_unit(m.dry, m.sign) if whole else m.sign[:, None], one('Cc_change'),
        grid=whole_friction, low=lambda m: -math.inf if m.learnt else -m.coulomb,
        dissipates=True, states='Cc_change', twins=('arm_coulomb',)))


# ---------------------------------------------------------------------- friction


@inline
def stribeck_torque(c: Coefficients, t: float, x3: float, z: float, base: MotorFriction) -> float:
    """
    Return the torque (N m) that Stribeck friction adds.

    Args:
        c: parameters Cs, vs.
        t: time, s; not used.
        x3: speed of the motor, rad/s.
        z: not used.
        base: friction of the model.

    Returns:
        Cs exp(-(x3/vs)^2) s(x3).
    """
    v = x3 / c.vs
    return c.Cs * exponential(-v * v) * friction_side(x3, base)


def _stribeck_starts(s: Scales) -> Starts:
    return [[FreeParameter('Cs', 0.3 * s.friction, s.friction, 0.0, s.peak),
             logarithmic('vs', f * s.speed, 1e-3, 1e3)] for f in (0.03, 0.15, 0.6)]


STRIBECK = Effect(
    'stribeck', 'motor_side', 'Cc -> Cc + Cs exp(-(x3/vs)^2)',
    (positive('Cs', 'N m'), Parameter('vs', 'rad/s', 1e-3, 1e3)),
    noun='friction at low speed',
    shows='The drive sticks and breaks away at low speed where the model glides; moves faster '
          'than a few times vs fit.',
    meaning='friction of the motor is higher at low speed',
    friction=stribeck_torque, starts=_stribeck_starts,
    at_rest=lambda effect, sharpness: AtRest(TWO_OVER_PI * sharpness * effect['Cs']),
    separated_by={'lugre': 'slow reversals',
                  'motor_coulomb': 'slow reversals and several speeds'},
    column=BalanceColumn(
        lambda m, vs: (m.sign * np.exp(-(m.v / vs) ** 2))[:, None],
        lambda b, vs: {'Cs': float(b[0]), 'vs': vs}, setting='vs',
        grid=lambda m: (0.05, 0.1, 0.2, 0.4), low=not_negative, dissipates=True))


@inline
def lugre_level(c: Coefficients, x3: float, base: MotorFriction) -> float:
    """
    Return g (N m), the friction of LuGre's model in steady sliding.

    Args:
        c: parameters of lugre.
        x3: speed of the motor, rad/s.
        base: friction of the model.

    Returns:
        Cc + Cs exp(-(x3/vs)^2).
    """
    v = x3 / c.vs
    return base.coulomb + c.Cs * exponential(-v * v)


@inline
def lugre_torque(c: Coefficients, t: float, x3: float, z: float, base: MotorFriction) -> float:
    """
    Return what the LuGre model (Canudas de Wit et al., 1995) adds to Coulomb friction.

    Args:
        c: parameters sigma0, sigma1, Cs, vs.
        t: time, s; not used.
        x3: speed of the motor, rad/s.
        z: deflection of the bristles, rad.
        base: friction of the model.

    Returns:
        Torque, N m.
    """
    g = lugre_level(c, x3, base)
    slip = abs(x3) * z / g if g > 0.0 else 0.0
    bristles = c.sigma0 * z + c.sigma1 * (x3 - c.sigma0 * slip)
    # A constraint is off: DriveModel.pack.
    return bristles - base.coulomb * friction_side(x3, base) if base.law <= TANH else bristles


@inline
def bristle(c: Coefficients, z: float, x3: float, x4: float, h: float,
            base: MotorFriction) -> float:
    """
    Return the deflection of LuGre's bristles after a step.

    Args:
        c: parameters of lugre.
        z: deflection at the begin, rad.
        x3: speed of the motor, rad/s.
        x4: speed of the arm; not used.
        h: length of the step, s.
        base: friction of the model.

    Returns:
        The deflection, rad.
    """
    g = lugre_level(c, x3, base)
    if x3 == 0.0 or g <= 0.0:
        return z
    return relaxed(z, math.copysign(g / c.sigma0, x3), c.sigma0 * abs(x3) / g, h)


def _lugre_starts(s: Scales) -> Starts:
    return [[logarithmic('sigma0', s0 * s.friction, 1e-3, 1e6),
             logarithmic('sigma1', s1, 1e-6, 1e3),
             FreeParameter('Cs', 0.3 * s.friction, s.friction, 0.0, s.peak),
             logarithmic('vs', f * s.speed, 1e-3, 1e3)]
            for s0, s1, f in ((100.0, 0.3, 0.1), (1000.0, 0.1, 0.1), (30.0, 0.3, 0.3))]


LUGRE = Effect(
    'lugre', 'motor_side', "Cc s(x3) replaced by sigma0 z + sigma1 z', "
    "z' = x3 - sigma0 |x3| z / g, g = Cc + Cs exp(-(x3/vs)^2)",
    (Parameter('sigma0', 'N m/rad', 1e-3, 1e6, off_at_infinity=True),
     positive('sigma1', 'N m s/rad'), positive('Cs', 'N m'),
     Parameter('vs', 'rad/s', 1e-3, 1e3)),
    noun='stiffness before friction slips',
    shows='At a reversal the motor springs back by a small angle before it slips, and friction '
          'falls as speed rises.',
    meaning='friction of the motor gives elastically before it slips, and falls with speed',
    friction=lugre_torque, memory=bristle, starts=_lugre_starts,
    at_rest=lambda effect, sharpness: AtRest(effect['sigma1'], effect['sigma0']))


@inline
def asymmetry_torque(c: Coefficients, t: float, x3: float, z: float,
                     base: MotorFriction) -> float:
    """
    Return the torque (N m) by which friction differs between the directions.

    Args:
        c: parameter Ca.
        t: time, s; not used.
        x3: speed of the motor, rad/s.
        z: not used.
        base: friction of the model.

    Returns:
        Ca |s(x3)|.
    """
    return c.Ca * abs(friction_side(x3, base))


COULOMB_ASYMMETRY = Effect(
    'coulomb_asymmetry', 'motor_side', 'tau_f += Ca |s(x3)|', (Parameter('Ca', 'N m'),),
    noun='friction that differs by direction',
    shows='One direction needs more torque than the other, by the same amount at all speeds and '
          'angles.',
    meaning='friction of the motor differs between the directions',
    friction=asymmetry_torque, twin='torque_offset',
    starts=lambda s: [[FreeParameter('Ca', 0.0, s.friction, -s.peak, s.peak)]],
    at_rest=lambda effect, sharpness: AtRest(TWO_OVER_PI * sharpness * abs(effect['Ca'])))


@inline
def viscous_asymmetry_torque(c: Coefficients, t: float, x3: float, z: float,
                             base: MotorFriction) -> float:
    """
    Return the torque (N m) by which viscous friction differs between the directions.

    Args:
        c: parameter Cva.
        t: time, s; not used.
        x3: speed of the motor, rad/s.
        z: not used.
        base: not used.

    Returns:
        Cva |x3|.
    """
    return c.Cva * abs(x3)


VISCOUS_ASYMMETRY = Effect(
    'viscous_asymmetry', 'motor_side', 'tau_f += Cva |x3|', (Parameter('Cva', 'N m s/rad'),),
    noun='viscous friction that differs by direction',
    shows='One direction needs more torque than the other, by an amount proportional to the '
          'speed.',
    since='0.2.0',
    meaning='viscous friction of the motor differs between the directions',
    friction=viscous_asymmetry_torque,
    starts=lambda s: [[FreeParameter('Cva', 0.0, 0.3 * s.torque / s.speed)]],
    at_rest=lambda effect, sharpness: AtRest(abs(effect['Cva'])),
    separated_by={'coulomb_asymmetry': _SEVERAL_SPEEDS, 'torque_offset': _SEVERAL_SPEEDS},
    column=BalanceColumn(lambda m, _: np.abs(m.v)[:, None], one('Cva')))

LOAD_FRICTION = Effect(
    'load_friction', 'motor_side', 'tau_f += Cl |tau_K| s(x3)',
    (positive('Cl', 'N m per N m', 1.0),),
    noun='friction per load',
    shows='Friction rises and falls with the torque through the gearbox: light moves fit, loaded '
          'ones are too fast in the model.',
    meaning='friction of the motor grows with the transmitted torque',
    in_filters=True, additive=True,
    starts=lambda s: [[FreeParameter('Cl', 0.0, 0.1, 0.0, 1.0)]],
    separated_by={'motor_coulomb': 'several load amplitudes'},
    column=BalanceColumn(
        lambda m, _: (np.abs(m.bodies) * m.sign)[:, None], one('Cl'), low=not_negative,
        dissipates=True))

MOTOR_INERTIA = Effect(
    'motor_inertia', 'motor_side', 'm1 differs from the model file', (_M1,),
    noun='rotor inertia',
    shows='The difference follows the acceleration of the motor, also while the backlash '
          'separates it from the arm.',
    meaning='inertia of the motor differs from the model', replaces='motor_inertia',
    starts=of_model(_M1, 'motor_inertia', PROFILE),
    column=BalanceColumn(
        lambda m, _: m.v[:, None], one('m1_change'), momentum=True,
        low=lambda m: -math.inf if m.learnt else -m.armature, states='m1_change'))


@inline
def drift_torque(c: Coefficients, t: float, x3: float, z: float, base: MotorFriction) -> float:
    """
    Return the torque (N m) that a drift of viscous friction adds.

    Args:
        c: parameters r, T.
        t: time from the start of the recording, s.
        x3: speed of the motor, rad/s.
        z: not used.
        base: friction of the model.

    Returns:
        Cv r (1 - exp(-t/T)) x3.
    """
    return base.viscous * c.r * (1.0 - exponential(-t / c.T)) * x3


def _drift_starts(s: Scales) -> Starts:
    return [[FreeParameter('r', 0.05, 0.3, -1.0), logarithmic('T', tc, 0.05, 1e3)]
            for tc in (1.0, 6.0)]


VISCOUS_DRIFT = Effect(
    'viscous_drift', 'motor_side', 'Cv -> Cv (1 + r (1 - exp(-t/T))), t from the start',
    (Parameter('r', '-', -1.0), Parameter('T', 's', 1e-2, 1e5)),
    noun='drift of viscous friction',
    shows='The same motion fits at one end of the recording and not at the other; the difference '
          'changes smoothly with time.',
    meaning='viscous friction changes during the recording, as oil that warms up',
    friction=drift_torque, starts=_drift_starts,
    column=BalanceColumn(
        lambda m, tc: (m.v * -np.expm1(-m.t / tc))[:, None],
        lambda b, tc: {'Cv_change': float(b[0]), 'T': tc}, setting='T',
        grid=lambda m: (3.0, 10.0), dissipates=True, states='Cv_change'))


# ---------------------------------------------------------------------- torque


@inline
def with_cogging(c: Coefficients, x1: float, x3: float, u: float) -> float:
    """
    Return the torque of the motor with cogging.

    Args:
        c: parameters A, N, phi.
        x1: position of the motor, rad.
        x3: its speed; not used.
        u: torque of the motor, N m.

    Returns:
        u + A sin(N x1 + phi), N m.
    """
    return u + c.A * sine(c.N * x1 + c.phi)


COGGING = Effect(
    'cogging', 'motor_side', "m1 x3' += A sin(N x1 + phi)", (Parameter('A', 'N m'), *PERIOD),
    noun='cogging torque',
    shows='The difference repeats N times per turn of the motor and has the same size with and '
          'without load.',
    meaning='torque of the motor varies with its angle, also without current',
    motor_torque=with_cogging, rotary_only=True,
    starts=wave(lambda s: 0.1 * s.torque, lambda s: s.peak),
    column=BalanceColumn(
        lambda m, n: waves(n * m.q), wave_values('A', -1.0), setting='N',
        grid=lambda m: range(2, 41), whole=True))
