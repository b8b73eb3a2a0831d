# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Units of recordings and their factors to SI, from the vocabulary that the package holds."""
from collections.abc import Iterable
from functools import lru_cache
from importlib import resources
import re
from typing import Any

import yaml

from gearbox_monitor.errors import InputError

POSITION, VELOCITY, EFFORT, TIME = 'position', 'velocity', 'effort', 'time'
ROTARY, PRISMATIC = 'rotary', 'prismatic'
SI = {ROTARY: {POSITION: 'rad', VELOCITY: 'rad/s', EFFORT: 'N m'},
      PRISMATIC: {POSITION: 'm', VELOCITY: 'm/s', EFFORT: 'N'}}
COUNTS = ('counts', 'counts/s')


@lru_cache(None)
def vocabulary() -> dict[str, Any]:
    """Return the content of vocabulary.yaml; what is a text of words there is a set here."""
    text = resources.files(__package__).joinpath('vocabulary.yaml').read_text(encoding='utf-8')
    content: dict[str, Any] = yaml.load(text, getattr(yaml, 'CSafeLoader', yaml.SafeLoader))
    for key, value in content.items():
        if isinstance(value, str):
            content[key] = frozenset(value.split())
        elif key in ('quantities', 'sources', 'sides'):
            content[key] = {kind: frozenset(words.split()) for kind, words in value.items()}
    content['rules'] = [{
        'words': (), 'of': (POSITION, VELOCITY, EFFORT), 'beside': (), 'is': {}, 'unit': '',
        'why': '', **rule, 'any': frozenset(rule.get('any', '').split())}
        for rule in content['rules']]
    return content


def units_of(quantity: str, *axes: str) -> dict[str, float]:
    """Return {unit: factor} of a `quantity` on `axes` (with 'input': what needs a constant)."""
    tables = vocabulary()['units'][quantity]
    return {unit: factor for axis in axes or tables for unit, factor in tables[axis].items()}


@lru_cache(None)
def _spellings() -> dict[str, str]:
    units = [unit for quantity in vocabulary()['units'] for unit in units_of(quantity)]
    table = {}
    for unit in units:
        for word in (re.sub(r'\s', '', unit), *vocabulary()['spellings'].get(unit, '').split()):
            table[word] = unit
            if f'{unit}/s' in units:
                table |= {f'{word}{second}': f'{unit}/s' for second in ('/s', '/sec', 's-1')}
    return table


@lru_cache(4096)
def standard_unit(text: str) -> str:
    """Return the name in the tables of the unit `text` ('Nm', 'N*m', 'degrees'), '' if none."""
    plain = text.replace('µ', 'u').replace('μ', 'u')
    plain = re.sub(r'\s*\((?:angle|torque|velocity|position|force|time)\)\s*$', '', plain,
                   flags=re.IGNORECASE)  # 'deg (Angle)' of a TwinCAT scope
    squeezed = re.sub(r'[\s*·.^_]|(?<=[A-Za-z])-(?=[A-Za-z])', '', plain)
    return _spellings().get(squeezed) or _spellings().get(squeezed.lower(), '')


def scaled_unit(text: str) -> tuple[float, str]:
    """Return (factor, unit) of a unit with a number in front: '0.229rpm' is (0.229, 'rpm')."""
    match = re.fullmatch(r'\s*(\d*\.?\d+(?:[eE][-+]?\d+)?)?\s*\*?\s*(\D.*)', text)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]) if match and match[1] and unit else 1.0), unit or standard_unit(text)


def unit_of_label(label: str) -> tuple[float, str]:
    """Return (factor, unit) that a `label` states: 'q [deg]', 'q_deg'; '' if none."""
    bracketed = re.search(r'[\[(<{]([^\[\](){}<>]+)[\])>}]\s*$', label)
    if bracketed:
        unit = bracketed[1].strip()
        return (1.0, '') if unit.isdigit() else scaled_unit(unit.rstrip('?'))
    # Single letters after an underscore are indices more often than units.
    ending = re.search(r'[_ /-]([A-Za-z%°]{2,})$', label)
    return 1.0, standard_unit(ending[1]) if ending and ending[1] not in ('in', 'min') else ''


def strange_unit(label: str) -> str:
    """Return the text in brackets that names no known unit, as in 'torque [foo]', else ''."""
    match = re.search(r'\s\[([^\[\]]*[^\W\d][^\[\]]*)\]\s*$', label)
    return match[1].strip() if match and not scaled_unit(match[1])[1] else ''


def number_with_unit(cell: str) -> tuple[float, str] | None:
    """Return (number, unit) of a cell such as '0.005 sec', None if it is none."""
    match = re.fullmatch(r'\s*([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)\s+(\D{1,8}?)\s*', cell)
    unit = standard_unit(match[2]) if match else ''
    return (float(match[1]), unit) if match and unit else None


def axis_of(units: Iterable[str], otherwise: str = ROTARY) -> str:
    """Return the axis that one of the `units` says, `otherwise` where none does."""
    for unit in map(standard_unit, units):
        for axis in (PRISMATIC, ROTARY):
            if any(unit in units_of(quantity, axis) for quantity in SI[axis]):
                return axis
    return otherwise


def unit_factor(unit: str, quantity: str, axis: str) -> tuple[float, bool]:
    """
    Return (factor to SI, whether it suffices) of a unit.

    Counts and inputs of a motor need a second factor: counts per turn, a constant or a scale.

    Args:
        unit: as a user writes it.
        quantity: POSITION, VELOCITY or EFFORT.
        axis: ROTARY or PRISMATIC.

    Raises:
        InputError: not a unit of this quantity; the text names what was expected.
    """
    name = standard_unit(unit)
    for axes, complete in ((axis, True), ('input', False)):
        if name in units_of(quantity, axes):
            return units_of(quantity, axes)[name], complete
    raise InputError(f'{unit!r}, expected a unit of {quantity} on a {axis} axis: '
                     + ', '.join(units_of(quantity, axis, 'input')))
