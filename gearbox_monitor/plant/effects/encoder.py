# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Effects in the two encoders: what they read beside the position."""
from collections.abc import Mapping
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


def _of(side: str, i: int, seems: str = '', apart: Mapping[str, str] | None = None
        ) -> tuple[Effect, Effect, Effect]:
    """
    Return eccentricity, step and delay of an encoder.

    Args:
        side: of the gearbox.
        i: its number in the symbols.
        seems: what its delay looks like, too.
        apart: separated_by of its eccentricity.
    """
    place = f'{side}_sensor'
    return Effect(
        f'{side}_encoder_eccentricity', place, f'y{i} = x{i} + A sin(x{i} + phi)',
        (_AMPLITUDE, _PHASE), noun='eccentricity',
        shows=f'The reading of the {side} is off by a sine of its own angle, once per turn, at '
              'any speed and load.',
        meaning=f'disc of the {side} encoder is off centre',
        encoder_error=eccentricity_error, starts=wave(_eccentricity_size, _most_off),
        rotary_only=True, separated_by=apart or {},
    ), Effect(  # read from the lattice of the readings, not fitted
        f'{side}_encoder_quantisation', place, f'y{i} = q round((x{i} + n{i}) / q)',
        (positive('q', 'rad'),), noun='step',
        shows=f'Readings of the {side} take only multiples of one step; in slow motion they form '
              'stairs.',
        meaning=f'{side} encoder is coarse', lattice=True, starts=None,
    ), Effect(  # interpolates between samples: composition.reading has its equation
        f'{side}_encoder_delay', place, f'y{i}(t) = x{i}(t - T)', (_DELAY,), noun='delay',
        shows=f'The reading of the {side} comes late by the same time; the difference is '
              f'proportional to its speed{seems}.',
        meaning=f'reading of the {side} encoder is late', starts=_delay_starts,
        twin_alone='actuator_delay', separated_by={'actuator_delay': BOTH})


MOTOR_ENCODER_ECCENTRICITY, MOTOR_ENCODER_QUANTISATION, MOTOR_ENCODER_DELAY = _of(
    'motor', 1, apart={'arm_encoder_eccentricity': 'more than one turn of travel'})
ARM_ENCODER_ECCENTRICITY, ARM_ENCODER_QUANTISATION, ARM_ENCODER_DELAY = _of(
    'arm', 2, ', and a twist seems to follow it')


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
