# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Units of recordings and their factors to SI: a table of what drives and sensors write."""
from collections.abc import Iterable
from itertools import chain
import math
import re

from gearbox_monitor.errors import InputError

TURN = 2.0 * math.pi
ANGLE = {'rad': 1.0, 'mrad': 1e-3, 'deg': TURN / 360, 'turns': TURN, 'arcmin': TURN / 21600,
         'arcsec': TURN / 1_296_000}
LENGTH = {'m': 1.0, 'cm': 1e-2, 'mm': 1e-3, 'um': 1e-6, 'in': 0.0254}
ANGULAR_SPEED = {'rad/s': 1.0, 'mrad/s': 1e-3, 'deg/s': TURN / 360, 'turns/s': TURN,
                 'rpm': TURN / 60}
SPEED = {'m/s': 1.0, 'cm/s': 1e-2, 'mm/s': 1e-3, 'um/s': 1e-6, 'mm/min': 1e-3 / 60,
         'm/min': 1 / 60}
KILOPOND, POUND = 9.80665, 4.4482216152605
TORQUE = {'N m': 1.0, 'mN m': 1e-3, 'uN m': 1e-6, 'N mm': 1e-3, 'N cm': 1e-2, 'kN m': 1e3,
          'kgf m': KILOPOND, 'kgf cm': KILOPOND * 1e-2, 'lbf in': POUND * 0.0254,
          'lbf ft': POUND * 0.3048, 'ozf in': POUND / 16 * 0.0254}
FORCE = {'N': 1.0, 'mN': 1e-3, 'kN': 1e3, 'kgf': KILOPOND, 'lbf': POUND}
# What a torque constant turns into torque or force.
DRIVE_INPUT = {'A': 1.0, 'mA': 1e-3, 'V': 1.0, 'mV': 1e-3, '1': 1.0, '%': 1e-2, 'per mille': 1e-3}
COUNTS = {'counts': 1.0}
COUNT_RATE = {'counts/s': 1.0}
TIME = {'s': 1_000_000_000, 'ms': 1_000_000, 'us': 1000, 'ns': 1, 'min': 60_000_000_000}  # ns
QUANTITIES: dict[tuple[str, str], dict[str, float]] = {
    ('position', 'rotary'): ANGLE, ('position', 'prismatic'): LENGTH,
    ('velocity', 'rotary'): ANGULAR_SPEED, ('velocity', 'prismatic'): SPEED,
    ('effort', 'rotary'): TORQUE, ('effort', 'prismatic'): FORCE,
}
_SPELLINGS = {
    'degree': 'deg', 'degrees': 'deg', 'grad': 'deg', '°': 'deg', 'radian': 'rad',
    'radians': 'rad', 'turn': 'turns', 'rev': 'turns', 'revs': 'turns', 'rot': 'turns',
    'count': 'counts', 'ticks': 'counts', 'tick': 'counts', 'cts': 'counts', 'inc': 'counts',
    'increments': 'counts', 'pulse': 'counts', 'pulses': 'counts', 'rev/min': 'rpm',
    'r/min': 'rpm', '1/min': 'rpm', 'min-1': 'rpm', 'amps': 'A', 'amp': 'A',
    'amperes': 'A', 'ampere': 'A', 'volts': 'V', 'volt': 'V', 'percent': '%', '‰': 'per mille',
    'permille': 'per mille', 'newton': 'N', 'sec': 's', 'second': 's', 'seconds': 's',
    'msec': 'ms', 'milliseconds': 'ms', 'usec': 'us', 'microseconds': 'us', 'nsec': 'ns',
    'nanoseconds': 'ns',
}
_BY_SPELLING = {
    **{re.sub(r'\s', '', name): name for name in chain(
        *QUANTITIES.values(), DRIVE_INPUT, COUNTS, COUNT_RATE, TIME)},
    **_SPELLINGS,
    **{f'{spelling}/{second}': f'{name}/s' for spelling, name in _SPELLINGS.items()
       for second in ('s', 'sec') if f'{name}/s' in {**ANGULAR_SPEED, **COUNT_RATE}},
}


def standard_unit(text: str) -> str:
    """Return the name in the tables of the unit `text` ('Nm', 'N*m', 'degrees'), '' if none."""
    squeezed = re.sub(r'[\s*·.^_]|(?<=[A-Za-z])-(?=[A-Za-z])', '',
                      text.replace('µ', 'u').replace('μ', 'u'))
    return _BY_SPELLING.get(squeezed) or _BY_SPELLING.get(squeezed.lower(), '')


def number_with_unit(cell: str) -> tuple[float, str] | None:
    """Return (number, unit) of a cell such as '0.005 sec', None if it is none."""
    match = re.fullmatch(r'\s*([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)\s+(\D{1,8}?)\s*', cell)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]), unit) if match and unit else None


def scaled_unit(text: str, of_label: bool = False) -> tuple[float, str]:
    """
    Return (factor, unit) of a unit with a number in front: '0.229rpm' is (0.229, 'rpm').

    Args:
        text: unit as a file writes it; (1, '') is returned for anything else.
        of_label: `text` is the name of a column that may state its unit.
    """
    if of_label:
        bracketed = re.search(r'[\[(<{]([^\[\](){}<>]+)[\])>}]\s*$', text)
        if not bracketed or bracketed[1].strip().isdigit():
            return 1.0, unit_of_label(text)
        text = bracketed[1].rstrip('?')
    match = re.fullmatch(r'\s*(\d*\.?\d+(?:[eE][-+]?\d+)?)?\s*\*?\s*(\D.*)', text)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]) if match and match[1] and unit and match[1] != '1' else 1.0), (
        unit or standard_unit(text))


def unit_of_label(label: str) -> str:
    """Return the unit that the `label` of a column states, 'q [deg]' or 'q_deg'; '' if none."""
    bracketed = re.search(r'[\[(<{]([^\[\](){}<>]+)[\])>}]\s*$', label)
    if bracketed:
        unit = bracketed[1].strip()
        return '' if unit.isdigit() else standard_unit(unit.rstrip('?'))
    # Single letters after an underscore are indices more often than units.
    ending = re.search(r'[_ /-]([A-Za-z%°]{2,})$', label)
    return standard_unit(ending[1]) if ending and ending[1] != 'in' else ''


def axis_of(units: Iterable[str], otherwise: str) -> str:
    """Return 'rotary' or 'prismatic', as one of the `units` says; `otherwise` where none does."""
    for unit in map(standard_unit, units):
        if unit in {**LENGTH, **SPEED, **FORCE}:
            return 'prismatic'
        if unit in {**ANGLE, **ANGULAR_SPEED, **TORQUE}:
            return 'rotary'
    return otherwise


def unit_factor(unit: str, quantity: str, axis: str) -> tuple[float, bool]:
    """
    Return the factor of a unit to SI.

    Args:
        unit: as a user writes it.
        quantity: 'position', 'velocity' or 'effort'.
        axis: 'rotary' or 'prismatic'.

    Returns:
        (factor, whether the unit alone gives SI). Counts and inputs of a motor need a second
        factor: counts per turn, torque constant or scale.

    Raises:
        InputError: not a unit of this quantity; the text names what was expected.
    """
    name, table = standard_unit(unit), QUANTITIES[quantity, axis]
    if name in table:
        return table[name], True
    raw = {'position': COUNTS, 'velocity': COUNT_RATE, 'effort': {**DRIVE_INPUT, **COUNTS}}
    if name in raw[quantity]:
        return raw[quantity][name], False
    raise InputError(f'{unit!r}, expected a unit of {quantity} on a {axis} axis: '
                     + ', '.join([*table, *raw[quantity]]))
