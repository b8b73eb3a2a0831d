# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The answer of a verdict in its first sentence, with sizes.

One definition for the terminal, the page and the JSON of one joint.
"""
from collections.abc import Mapping
import math
from typing import Any

from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.presentation import on_axis

NEAR_FLOOR = 1.5  # misfit that may be noise of the encoders
OWNERS = {
    'motor_side': "The motor's", 'arm_side': "The arm's", 'transmission': "The gearbox's",
    'controller': "The servo's", 'actuator': "The actuator's",
    'motor_sensor': "The motor encoder's", 'arm_sensor': "The arm encoder's"}
PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'controller': 'controller', 'actuator': 'actuator', 'motor_sensor': 'motor encoder',
    'arm_sensor': 'arm encoder'}
DIGITS = 3  # of a size in a sentence
LONGEST = 8  # digits after the point


def summary(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """
    Return the verdict in words: what differs from the model, by how much, what that explains.

    Args:
        data: of a verdict on one joint, as JSON has it.
        axis: of the drive.

    Returns:
        One to four sentences.
    """
    open_gap, closed_gap = data.get('gap_before') or 0.0, data.get('gap_after') or 0.0
    noise = f'(misfit {sized(closed_gap)}, where 1 is noise alone)'
    if data['verdict'] == 'none' and closed_gap > NEAR_FLOOR:
        return ('No effect stands out: the residual is no larger than that of a real drive '
                f'without a known fault {noise}.')
    if data['verdict'] == 'none' and open_gap > NEAR_FLOOR:
        return ('No gap beyond the tolerances: with values of the model moved within them, noise '
                f'alone is left {noise}.')
    if data['verdict'] == 'none':
        return ('No gap: the model explains the recording down to the noise of the encoders '
                f'{noise}.')
    if data['verdict'] == 'unknown':
        return _nothing_fits(data, open_gap)
    findings = [finding_sentence(f, data, axis) for f in data['findings']]
    return ' '.join([*findings, _share(data, len(findings)), *_rivals(data, len(findings))])


def finding_sentence(finding: Mapping[str, Any], data: Mapping[str, Any], axis: str) -> str:
    """
    Return one sentence on one effect: its value, that of the model, the change.

    Args:
        finding: one of the findings of a verdict.
        data: the verdict, with `model_values` and `bursts`.
        axis: of the drive.
    """
    name, values = finding['effect'], finding['values']
    effect = library().get(name)
    if name == DISTURBANCE.id:
        return _bursts(data, values, axis)
    if effect is None or effect.parameters[0].name not in values:
        return f'{name} acts on the drive.'
    parameter = effect.parameters[0]
    unit = on_axis(parameter.unit, axis)
    value = values[parameter.name]
    owner = OWNERS.get(finding['place'], 'The')
    size = in_unit(sized(value), unit)
    if finding['deviations'].get(parameter.name) is None:
        size = f'about {size} (not well determined by this recording)'
    turns = f', {values["N"]:.0f} per turn' if 'N' in values else ''
    return (f'{owner} {effect.noun or name} is {size}{turns}'
            f'{_beside(name, parameter.name, value, data, unit)}.')


def _beside(effect: str, name: str, value: float, data: Mapping[str, Any], unit: str) -> str:
    """Return what the model has in place of the `value` `name` of an effect, in `unit`."""
    nominal = (data.get('model_values') or {}).get(effect, {}).get(name)
    if not nominal:
        return '; the model has none'
    if effect in EFFECTS and EFFECTS[effect].adds_to:
        return f' beyond the {in_unit(sized(nominal), unit)} of the model'
    return f', not {sized(nominal)} ({change(value, nominal)})'


def _bursts(data: Mapping[str, Any], values: Mapping[str, float], axis: str) -> str:
    """Return the sentence on short bursts of torque, of which `values` is the largest."""
    count = len(data.get('bursts') or ()) or 1
    bursts = 'One burst' if count == 1 else f'{count} bursts'
    return on_axis(f'{bursts} of torque on the arm, the largest {sized(values["amplitude"])} N m '
                   f'at {values["t0"]:.2f} s.', axis)


def _share(data: Mapping[str, Any], count: int) -> str:
    """Return which part of the difference `count` findings explain, as a sentence."""
    remainder = data.get('remainder') if data['verdict'] == 'incomplete' else None
    if not remainder:
        return 'This explains the whole difference.' if count == 1 else \
            'Together they explain the whole difference.'
    shares = [f['share'] for f in data['findings'] if f.get('share') is not None]
    part = f'{100.0 * shares[0]:.0f} %' if count == 1 and shares else 'a part'
    return (f'{"This explains" if count == 1 else "Together they explain"} {part} of the '
            f'difference; the rest has no known cause ({_place(remainder)}).')


def _nothing_fits(data: Mapping[str, Any], before: float) -> str:
    """Return the summary of a gap, a misfit of `before`, that no effect explains."""
    remainder = data.get('remainder') or {'location': data.get('location')}
    at = (f': {_place(remainder)}' if remainder['location'] in PLACES
          else '; its place is not clear either')
    return (f'The recording differs from the model by {sized(before)} times the noise, and no '
            f'known effect explains it{at}.')


def _place(remainder: Mapping[str, Any]) -> str:
    """Return where a remainder is and what it follows."""
    over = f', over the {remainder["over"]}' if remainder.get('over') else ''
    return PLACES.get(remainder['location'], remainder['location']) + over


def _rivals(data: Mapping[str, Any], count: int) -> list[str]:
    """Return the sentence on rivals of `count` findings, none without rivals."""
    rivals = data.get('confusable') or ()
    return [f'This motion does not distinguish {"it" if count == 1 else "them"} from '
            f'{", ".join(rivals)}.'] if rivals else []


def sized(value: float) -> str:
    """Return `value` with three digits, those after the point included where they are 0."""
    if not value or not math.isfinite(value):
        return f'{value:g}'
    magnitude = math.floor(math.log10(abs(value)))
    if not -5 < magnitude < 6:
        return f'{value:.{DIGITS - 1}e}'
    return f'{value:.{max(0, DIGITS - 1 - magnitude)}f}'


def to_deviation(value: float, deviation: float) -> tuple[str, str]:
    """
    Return `value` and its `deviation`, both to the same place.

    The deviation has two digits; one that is 0 or infinite says nothing of the digits of `value`.
    """
    if not 0.0 < deviation < math.inf:
        return sized(value), f'{deviation:.2g}'
    decimals = 1 - int(f'{deviation:.1e}'.partition('e')[2])
    if decimals > LONGEST:
        digits = decimals + math.floor(math.log10(max(abs(value), deviation)))
        return f'{value:.{digits}e}', f'{deviation:.1e}'
    value_text, deviation_text = (f'{round(x, decimals):.{max(decimals, 0)}f}'
                                  for x in (value, deviation))
    return value_text, deviation_text


def with_deviation(value: float, deviation: float, sign: str = '±') -> str:
    """Return `value`, `sign` and `deviation`, both to the second digit of the deviation."""
    return f' {sign} '.join(to_deviation(value, deviation))


def change(value: float, nominal: float) -> str:
    """Return the change from `nominal`, which is not 0, to `value` in percent."""
    percent = 100.0 * (value - nominal) / abs(nominal)
    return f'{percent:+.0f} %' if abs(percent) >= 10.0 else f'{percent:+.2g} %'


def pretty(unit: str) -> str:
    """Return `unit` with its exponents as signs, '' for that of a pure number."""
    return '' if unit == '-' else unit.replace('^2', '²').replace('^3', '³')


def in_unit(value: str, unit: str) -> str:
    """Return `value` with its `unit`, alone if it is a pure number."""
    return f'{value} {pretty(unit)}'.rstrip()
