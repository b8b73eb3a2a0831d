# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects in the two encoders: what they read beside the position."""
import math

from gearbox_monitor.kernels.kernel import inline
from gearbox_monitor.plant.effects.effect import (
    Coefficients, Effect, FreeParameter, MAX_DELAY, Parameter, positive, Scales, Starts, Three,
    wave)


@inline
def eccentricity_error(c: Coefficients, x: float) -> Three:
    """
    Return the error of an encoder whose disc is off centre.

    Args:
        c: parameters A, phi.
        x: position, rad.

    Returns:
        A sin(x + phi) in rad, and its first and second derivative with respect to x.
    """
    error = c.A * math.sin(x + c.phi)
    return error, c.A * math.cos(x + c.phi), -error


def _delay_starts(s: Scales) -> Starts:
    return [[FreeParameter('T', 0.0005, 0.001, 0.0, MAX_DELAY)]]


def _eccentricity_size(s: Scales) -> float:
    return 0.01 * s.angle


def _most_off(s: Scales) -> float:
    return 0.5  # rad: a disc as far off its centre as half of its radius


_AMPLITUDE, _PHASE = Parameter('A', 'rad'), Parameter('phi', 'rad')
_DELAY = Parameter('T', 's', 0.0, MAX_DELAY)
BOTH = 'no motion tells them apart with one encoder: record both'

MOTOR_ENCODER_ECCENTRICITY = Effect(
    'motor_encoder_eccentricity', 'motor_sensor', 'y1 = x1 + A sin(x1 + phi)',
    (_AMPLITUDE, _PHASE),
    noun='eccentricity',
    shows='The reading of the motor is off by a sine of its own angle, once per turn, at any '
          'speed and load.',
    meaning='disc of the motor encoder is off centre',
    encoder_error=eccentricity_error, starts=wave(_eccentricity_size, _most_off),
    rotary_only=True,
    separated_by={'arm_encoder_eccentricity': 'more than one turn of travel'})

# Read from the lattice of the readings, not fitted.
MOTOR_ENCODER_QUANTISATION = Effect(
    'motor_encoder_quantisation', 'motor_sensor', 'y1 = q round((x1 + n1) / q)',
    (positive('q', 'rad'),),
    noun='step',
    shows='Readings of the motor take only multiples of one step; in slow motion they form '
          'stairs.',
    meaning='motor encoder is coarse', lattice=True, starts=None)

# Delays interpolate between samples: composition.reading has their equation.
MOTOR_ENCODER_DELAY = Effect(
    'motor_encoder_delay', 'motor_sensor', 'y1(t) = x1(t - T)', (_DELAY,),
    noun='delay',
    shows='The reading of the motor comes late by the same time; the difference is proportional '
          'to its speed.',
    meaning='reading of the motor encoder is late', starts=_delay_starts,
    twin_alone='actuator_delay', separated_by={'actuator_delay': BOTH})

ARM_ENCODER_ECCENTRICITY = Effect(
    'arm_encoder_eccentricity', 'arm_sensor', 'y2 = x2 + A sin(x2 + phi)',
    (_AMPLITUDE, _PHASE),
    noun='eccentricity',
    shows='The reading of the arm is off by a sine of its own angle, once per turn, at any speed '
          'and load.',
    meaning='disc of the arm encoder is off centre',
    encoder_error=eccentricity_error, starts=wave(_eccentricity_size, _most_off),
    rotary_only=True)

ARM_ENCODER_QUANTISATION = Effect(
    'arm_encoder_quantisation', 'arm_sensor', 'y2 = q round((x2 + n2) / q)',
    (positive('q', 'rad'),),
    noun='step',
    shows='Readings of the arm take only multiples of one step; in slow motion they form stairs.',
    meaning='arm encoder is coarse', lattice=True, starts=None)

ARM_ENCODER_DELAY = Effect(
    'arm_encoder_delay', 'arm_sensor', 'y2(t) = x2(t - T)', (_DELAY,),
    noun='delay',
    shows='The reading of the arm comes late by the same time; the difference is proportional to '
          'its speed, and a twist seems to follow it.',
    meaning='reading of the arm encoder is late', starts=_delay_starts,
    twin_alone='actuator_delay', separated_by={'actuator_delay': BOTH})


@inline
def offset_error(c: Coefficients, x: float) -> Three:
    """Return the constant error (rad) of `c` at the position `x`, and its derivatives, 0."""
    return c.c, 0.0, 0.0


ENCODER_OFFSET = Effect(
    'encoder_offset', 'arm_sensor', 'y2 = x2 + c', (Parameter('c', 'rad'),),
    noun='zero offset',
    shows='The twist has a constant offset while the torque through the gearbox has none.',
    meaning='encoders do not share their zero', encoder_error=offset_error,
    needs_both_encoders=True,
    starts=lambda s: [[FreeParameter('c', 0.0, 0.1 * s.twist)]])
