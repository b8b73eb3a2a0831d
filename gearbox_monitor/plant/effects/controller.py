# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Effects of the servo whose setpoint is recorded: its gains, limit, deadband, delay, setpoint.

composition.servo has the equation of the servo, composition.actuator that of what happens to its
setpoint. Its damping kd has no effect of its own: it is viscous friction of the motor.
"""
import math

import numpy as np

from gearbox_monitor.plant.effects.actuator import limit_column, limits_below_peak
from gearbox_monitor.plant.effects.effect import (
    BalanceColumn, Effect, FreeParameter, JointMotion, MAX_SERVO_DELAY, MAX_SETPOINT_DELAY,
    not_negative, of_model, one, Parameter, positive, PROFILE, replaced, Scales, SETPOINT as
    OF_SETPOINT, Starts)

_KP = Parameter('kp', 'N m/rad', 1e-9)

SERVO_GAIN = Effect(
    'servo_gain', 'controller', 'kp differs from the model file', (_KP,),
    noun='proportional gain',
    shows='The servo answers an error of position with more or less torque: it follows closer, or'
          ' sags further under load.',
    since='0.2.0',
    meaning='proportional gain of the servo differs from the model', replaces='kp',
    starts=of_model(_KP, 'kp', PROFILE),
    separated_by={'torque_gain': 'fast motion, in which the damping of the servo counts'},
    column=BalanceColumn(
        lambda m, _: (m.model + m.kd * m.v - m.compensation)[:, None],
        lambda b, _: {'kp_factor': float(1.0 / (1.0 + b[0]))}, low=lambda m: -0.75,
        high=lambda m: 99.0,  # files of hobby arms state 60 times the gain
        needs=OF_SETPOINT, of_input=True, states='kp_factor', twins=('torque_gain',)))

SERVO_LIMIT = Effect(
    'servo_limit', 'controller', 'u clipped at +-umax',
    (Parameter('umax', 'N m', 0.0),),
    noun='torque limit',
    shows='Large or fast steps of the setpoint are followed more slowly than in the model; small '
          'ones fit.',
    since='0.2.0',
    meaning='servo limits its torque below the limit of the model', off=math.inf,
    starts=limits_below_peak, column=limit_column(OF_SETPOINT, ('saturation',)))


WIDEST = 0.3  # rad or m: a servo that does not react to more is off


def _deadband_starts(s: Scales) -> Starts:
    error = s.torque / s.values['kp']
    return [[FreeParameter('d', min(f * error, WIDEST), 0.1 * error, 0.0, WIDEST)]
            for f in (0.05, 0.3)]


def errors_reached(m: JointMotion) -> list[float]:
    """Return sizes (rad) of the servo's error in the JointMotion `m`, up to the WIDEST."""
    levels: list[float] = np.quantile(np.abs(m.error), (0.1, 0.2, 0.35, 0.5, 0.7)).tolist()
    return [x for x in levels if x < WIDEST]


SERVO_DEADBAND = Effect(
    'servo_deadband', 'controller', "u = kp dz(r - q, d) - kd q'", (positive('d', 'rad'),),
    noun='dead band',
    shows='The servo stops short of the setpoint and stays there, by up to the width of the band.',
    since='0.2.0',
    meaning='servo does not react to small errors of position', starts=_deadband_starts,
    column=BalanceColumn(
        lambda m, d: (m.kp * np.clip(m.error, -d, d))[:, None], lambda b, d: {'d': d},
        setting='d', grid=errors_reached, low=lambda m: 0.6,
        high=lambda m: 1.5, needs=OF_SETPOINT, of_input=True,
        hides=lambda m, d: np.abs(m.error) < d))

_KI, _LATE = positive('ki', 'N m/(rad s)'), Parameter('T', 's', 0.0, MAX_SERVO_DELAY)

SERVO_INTEGRATOR = Effect(
    'servo_integrator', 'controller', 'ki differs from the model file', (_KI,),
    noun='integral gain',
    shows='Where the setpoint rests, a remaining error shrinks over time, which the model keeps '
          '(or the reverse).',
    since='0.2.0',
    meaning='integral gain of the servo differs from the model', replaces='ki',
    starts=lambda s: [[replaced(_KI, ki, s.values['ki'] or s.values['kp'], s.values['ki'])]
                      for ki in (s.values['ki'], s.values['kp'], 5.0 * s.values['kp'])],
    separated_by={'motor_coulomb': 'standstill under load, of some seconds'})

_KFF = positive('kff', 'N m s/rad')

SERVO_FEEDFORWARD = Effect(
    'servo_feedforward', 'controller', 'feedforward differs from the model file', (_KFF,),
    noun="feedforward of the setpoint's speed",
    shows='The lag behind a setpoint that moves at constant speed is smaller or larger than in '
          'the model; at rest both agree.',
    since='0.2.0',
    meaning="servo adds another torque in proportion to the setpoint's speed than the model says",
    replaces='feedforward', starts=of_model(_KFF, 'feedforward', (1.0,), lambda s: max(
        s.values['kd'], s.values['viscous_friction'])))

SERVO_DELAY = Effect(
    'servo_delay', 'controller', 'delay differs from the model file', (_LATE,),
    noun='delay',
    shows='The servo overshoots and oscillates more than in the model after a step of the '
          'setpoint.',
    since='0.2.0',
    meaning='torque of the servo comes later than the model says', replaces='delay',
    starts=lambda s: [[FreeParameter('T', s.values['delay'] + late, 0.005, 0.0, MAX_SERVO_DELAY)]
                      for late in (0.0, 0.004, 0.015)],
    separated_by={'setpoint_delay': 'steps of the setpoint, after which the drive oscillates'},
    column=BalanceColumn(
        lambda m, _: m.model[:, None], one('T_change'), momentum=True, low=not_negative,
        needs=OF_SETPOINT, states='T_change', twins=('actuator_delay', 'actuator_lag')))

SETPOINT_DELAY = Effect(
    'setpoint_delay', 'controller', 'r(t) -> r(t - T)',
    (Parameter('T', 's', 0.0, MAX_SETPOINT_DELAY),),
    noun='delay of the setpoint',
    shows='All of the motion comes later than in the model by the same time and is otherwise the '
          'same.',
    since='0.2.0',
    meaning='setpoint comes to the servo with a dead time',
    starts=lambda s: [[FreeParameter('T', 0.002, 0.004, 0.0, MAX_SETPOINT_DELAY)],
                      [FreeParameter('T', 0.02, 0.01, 0.0, MAX_SETPOINT_DELAY)]],
    column=BalanceColumn(
        lambda m, _: (m.kp * m.setpoint_speed)[:, None], one('T'), low=not_negative,
        high=lambda m: MAX_SETPOINT_DELAY, needs=OF_SETPOINT, of_input=True,
        twins=('setpoint_lag',)))

SETPOINT_LAG = Effect(
    'setpoint_lag', 'controller', "T r_f' = r - r_f, r_f in place of r",
    (Parameter('T', 's', 0.0, 10.0),),
    noun='time constant of the setpoint filter',
    shows='Corners of the setpoint are rounded: fast parts come later and smaller, slow ones fit.',
    since='0.2.0',
    meaning='servo filters its setpoint',
    starts=lambda s: [[FreeParameter('T', 0.005, 0.01, 0.0, 1.0)]],
    separated_by={'setpoint_delay': 'a chirp or fast motion above 5 Hz'})
