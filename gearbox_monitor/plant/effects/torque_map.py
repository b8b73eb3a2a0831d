# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Torque as a table over a quantity of the motion: what a drive does and no law of the library says.

The empirical counterpart of the laws in the other files: diagnose fits one where the remainder
depends on one quantity, so that a gap closes whose cause has no name.
"""
from collections.abc import Sequence

from gearbox_monitor.kernels.kernel import inline, kernel
from gearbox_monitor.kernels.types import Array, Values
from gearbox_monitor.plant.effects.effect import (
    AtRest, Coefficients, Effect, MotorFriction, Parameter)

MOST_KNOTS = 16
# Where a map may act, and over what: each pair has its number in the packed effect.
(MOTOR_SPEED, MOTOR_TIME, MOTOR_ANGLE, MOTOR_TORQUE, ARM_SPEED, ARM_TIME, ARM_ANGLE,
 TWIST) = range(1, 9)
QUANTITIES = {
    ('motor_side', 'speed'): MOTOR_SPEED, ('motor_side', 'time'): MOTOR_TIME,
    ('motor_side', 'angle'): MOTOR_ANGLE, ('motor_side', 'torque'): MOTOR_TORQUE,
    ('arm_side', 'speed'): ARM_SPEED, ('arm_side', 'time'): ARM_TIME,
    ('arm_side', 'angle'): ARM_ANGLE, ('transmission', 'twist'): TWIST}
SIDES = tuple(dict.fromkeys(place for place, _ in QUANTITIES))
VARIABLES = tuple(dict.fromkeys(variable for _, variable in QUANTITIES))
# The packed effect: kind, number of knots, knots, values.
COUNT, KNOTS, VALUES, SIZE = 1, 2, 2 + MOST_KNOTS, 2 + 2 * MOST_KNOTS


@kernel
def interpolated(e: Array, k: int, x: float) -> float:
    """
    Return the torque of a map, constant beyond its last knots.

    Args:
        e: packed effects.
        k: place of the map in `e`.
        x: the quantity over which it stands.

    Returns:
        Torque, N m.
    """
    last, knots, values = int(e[k + COUNT]) - 1, k + KNOTS, k + VALUES
    if not x > e[knots]:
        return e[values]
    for i in range(last):
        if x < e[knots + i + 1]:
            share = (x - e[knots + i]) / (e[knots + i + 1] - e[knots + i])
            return e[values + i] + share * (e[values + i + 1] - e[values + i])
    return e[values + last]


@inline
def map_friction(c: Coefficients, t: float, x3: float, z: float, base: MotorFriction) -> float:
    """
    Return what a map of the motor's speed or of time takes from the motor's torque.

    Args:
        c: packed effects, and where in them the map begins.
        t: time from the start of the recording, s.
        x3: speed of the motor, rad/s.
        z: not used.
        base: not used.

    Returns:
        Torque, N m.
    """
    e, k = c
    if e[k] == MOTOR_SPEED:
        return -interpolated(e, k, x3)
    if e[k] == MOTOR_TIME:
        return -interpolated(e, k, t)
    return 0.0


@inline
def with_map(c: Coefficients, x1: float, x3: float, u: float) -> float:
    """
    Return the torque of the motor with a map of its angle or of the torque itself.

    Args:
        c: packed effects, and where in them the map begins.
        x1: position of the motor, rad.
        x3: its speed; not used.
        u: torque of the motor, N m.

    Returns:
        Torque, N m.
    """
    e, k = c
    if e[k] == MOTOR_ANGLE:
        return u + interpolated(e, k, x1)
    if e[k] == MOTOR_TORQUE:
        return u + interpolated(e, k, u)
    return u


@inline
def map_on_arm(c: Coefficients, t: float, x2: float, x4: float, z: float) -> float:
    """
    Return what a map of the arm's motion or of time takes from the arm's torque.

    Args:
        c: packed effects, and where in them the map begins.
        t: time from the start of the recording, s.
        x2: position of the arm, rad.
        x4: its speed, rad/s.
        z: not used.

    Returns:
        Torque, N m.
    """
    e, k = c
    if e[k] == ARM_SPEED:
        return -interpolated(e, k, x4)
    if e[k] == ARM_ANGLE:
        return -interpolated(e, k, x2)
    if e[k] == ARM_TIME:
        return -interpolated(e, k, t)
    return 0.0


@inline
def map_of_twist(c: Coefficients, twist: float, z: float, half_gap: float) -> float:
    """
    Return what a map of the twist adds to the torque of the transmission.

    Args:
        c: packed effects, and where in them the map begins.
        twist: that acts, rad.
        z: not used.
        half_gap: not used.

    Returns:
        Torque, N m.
    """
    e, k = c
    return interpolated(e, k, twist) if e[k] == TWIST else 0.0


def packed(effect: Values) -> list[float]:
    """Return the numbers [SIZE] of the map in `effect` in the order that kernels take."""
    knots, values = ([*effect[name], *[0.0] * (MOST_KNOTS - len(effect[name]))]
                     for name in ('knots', 'values'))
    return [QUANTITIES[effect['place'], effect['variable']], len(effect['knots']), *knots, *values]


def problem_of(effect: Values) -> str:
    """Return what is wrong with a map `effect` of fields that are each valid, '' for nothing."""
    if (effect['place'], effect['variable']) not in QUANTITIES:
        possible = ', '.join(v for p, v in QUANTITIES if p == effect['place'])
        return (f'variable: {effect["variable"]!r}, expected one of {possible} with place: '
                f'{effect["place"]}')
    knots = effect['knots']
    if not 2 <= len(knots) <= MOST_KNOTS:
        return f'knots: {len(knots)} numbers, expected 2 to {MOST_KNOTS}'
    if any(b <= a for a, b in zip(knots, knots[1:])):
        return f'knots: {knots}, expected numbers that rise'
    for name in ('values', 'deviations'):
        if len(effect[name]) != len(knots):
            return f'{name}: {len(effect[name])} numbers, expected one for each of the ' \
                   f'{len(knots)} knots'
    return ''


def _steepest(effect: Values) -> float:
    knots: Sequence[float] = effect['knots']
    values: Sequence[float] = effect['values']
    return max(abs(b - a) / (y - x)
               for a, b, x, y in zip(values, values[1:], knots, knots[1:]))


def _at_rest(effect: Values, sharpness: float) -> AtRest:
    """Return the steepest part of a map as a damper or a spring."""
    kind = QUANTITIES[effect['place'], effect['variable']]
    if kind in (MOTOR_TIME, MOTOR_TORQUE, ARM_TIME):
        return AtRest(0.0)
    slope = _steepest(effect)
    if kind == MOTOR_SPEED:
        return AtRest(slope)
    return AtRest(0.0, arm_damper=slope) if kind == ARM_SPEED else AtRest(0.0, slope)


TORQUE_MAP = Effect(
    'torque_map', '', 'torque that acts on the motor, on the arm or in the transmission '
    '+= f(variable): linear between knots, constant beyond the last ones',
    (Parameter('place', '-', choices=SIDES), Parameter('variable', '-', choices=VARIABLES),
     Parameter('knots', 'of the variable', listed=True), Parameter('values', 'N m', listed=True),
     Parameter('deviations', 'N m', 0.0, listed=True)),
    noun='torque',
    shows='What no law of the library describes remains after the fit and repeats over one '
          'quantity: angle, speed, twist, torque or time.',
    since='0.2.0',
    meaning='torque that depends on one quantity in a way that no law of the library describes',
    order=-1,  # over the torque of the actuator, not over what other effects make of it
    friction=map_friction, motor_torque=with_map, arm_torque=map_on_arm, elastic=map_of_twist,
    at_rest=_at_rest, packed=packed, size=SIZE, problem=problem_of,
    starts=lambda s: [])  # it is fitted to what the laws leave, never as one of them
