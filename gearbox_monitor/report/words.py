# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Words for a verdict, shared by the terminal and the page: effects, places, next steps."""
from collections.abc import Iterable, Mapping, Sequence
import math
from typing import Any

from gearbox_monitor.monitoring.backlash.recording_windows import GAP_ERROR
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.units import on_axis

LACKING = ('incomplete', 'unknown')  # verdicts with a remainder
NAMING = ('effect', 'incomplete')  # verdicts with findings
NEAR_FLOOR = 1.5  # gap that may be noise of the encoders
DENSE = 1.5  # ratio of the share of the gap to the share of the time that is worth a word
PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'controller': 'controller', 'actuator': 'actuator', 'motor_sensor': 'motor encoder',
    'arm_sensor': 'arm encoder'}
# The meaning of each effect on a real drive.
MEANINGS = {name: effect.meaning for name, effect in EFFECTS.items()}
UNDETERMINED = 'not determined'
SUGGESTED = 'this command finds a more informative motion, no larger than that of the recording'
# Motions that separate effects which other motions confuse.
SEPARATES = tuple(({name, rival}, motion) for name, effect in EFFECTS.items()
                  for rival, motion in effect.separated_by.items())


def meaning(name: str, axis: str) -> str:
    """Return the meaning of the effect `name` on a drive with `axis`, '' for unknown ids."""
    return on_axis(MEANINGS.get(name, ''), axis)


def unit_of(reading: str, angle: str) -> str:
    """Return the unit of a `reading` of Recording.readings; `angle`: rad or m."""
    return ('N m' if angle == 'rad' else 'N') if reading == 'torque' else angle


def place_text(place: str) -> str:
    """Return the name of a `place` where a free signal was put."""
    return 'motor, actuator' if place == 'motor_side' else PLACES[place]


def ids_of(data: Mapping[str, Any]) -> list[str]:
    """Return the ids of the effect in `data` (the JSON of a verdict)."""
    return data['effect'].split('+') if data.get('effect') else []


def headline(data: Mapping[str, Any]) -> str:
    """Return the verdict `data` in one sentence."""
    if data['verdict'] == 'none' and (data.get('gap_after') or 0.0) > NEAR_FLOOR:
        return ('No effect stands out: the residual is no larger than that of a real drive '
                'without a known fault.')
    if data['verdict'] == 'none' and (data.get('gap_before') or 0.0) > NEAR_FLOOR:
        return ('No gap beyond the tolerances: with values of the model moved within them, noise '
                'alone is left.')
    if data['verdict'] == 'none':
        return 'No gap: the model explains the recording down to the noise of the encoders.'
    places = data.get('location') or []
    places = [places] if isinstance(places, str) else list(places)
    names = [PLACES.get(place, place) for place in places]
    if data['verdict'] == 'unknown':
        clear = [name for name in names if name not in ('unknown', 'none')]
        at = f'Place: {" and ".join(clear)}.' if clear else 'Its place is not clear either.'
        return f'There is a gap, and no known effect explains it. {at}'
    ids = ids_of(data)
    if len(ids) > 1 and len(names) == len(ids):
        *others, last = (f'{name} ({place})' for name, place in zip(ids, names))
        named = (f'{"Two" if len(ids) == 2 else "Three"} effects: '
                 f'{", ".join(others)} and {last}.')
    else:
        named = f'Effect: {"+".join(ids)} ({" and ".join(names)}).'
    return f'{named} {left_over(data)}'.rstrip()


def left_over(data: Mapping[str, Any]) -> str:
    """Return what the findings of the verdict `data` do not explain, '' for nothing."""
    left = data.get('remainder') if data['verdict'] == 'incomplete' else None
    if not left:
        return ''
    shares = [f['share'] for f in data.get('findings') or () if f.get('share') is not None]
    explained = f'{percent(sum(shares))} of the gap' if len(shares) == 1 else 'a part of the gap'
    over = f', over the {left["over"]}' if left.get('over') else ''
    return (f'That explains {explained}; the rest has no known cause '
            f'({PLACES.get(left["location"], left["location"])}{over}).')


def counted(count: int, noun: str) -> str:
    """Return `count` with the `noun` in singular or plural."""
    plural = f'{noun}es' if noun.endswith('x') else f'{noun}s'
    return f'{count} {noun if count == 1 else plural}'


def number(value: float | None) -> str:
    """Return `value` with three or four digits, 'none' for None."""
    return 'none' if value is None else f'{value:.4g}'


def value_rows(data: Mapping[str, Any], axis: str) -> list[tuple[str, str, str, str, str]]:
    """
    Return (effect, parameter, value, deviation, unit) of each value that a verdict identified.

    Args:
        data: the verdict as plain data.
        axis: of the drive.

    Returns:
        Texts; a deviation is '' where none is stated, UNDETERMINED where the recording does not
        determine the value.
    """
    effects, rows = library(), []
    errors = data.get('standard_errors') or {}
    undetermined = {(f['effect'], name) for f in data.get('findings') or ()
                    for name, deviation in f['deviations'].items() if deviation is None}
    for effect, values in (data.get('params') or {}).items():
        units = {p.name: p.unit for p in effects[effect].parameters} if effect in effects else {}
        for name, value in values.items():
            unit = on_axis(units.get(name, ''), axis)
            error = (errors.get(effect) or {}).get(name)
            is_number = isinstance(value, (int, float))
            rows.append((effect, name, number(value) if is_number else str(value),
                         UNDETERMINED if (effect, name) in undetermined
                         else f'{error:.2g}' if error and is_number else '',
                         '' if unit == '-' else unit))
    return rows


def value_text(row: tuple[str, str, str, str, str], sign: str = '±') -> str:
    """Return a row of value_rows as `name = value ± deviation unit`."""
    _, name, value, deviation, unit = row
    spread = f' ({deviation})' if deviation == UNDETERMINED else f' {sign} {deviation}'
    return f'{name} = {value}{spread if deviation else ""} {unit}'.rstrip()


def width_and_std(width: float, std: float, unit: str) -> str:
    """
    Return a measured width as all pages state it.

    Args:
        width: gap or lost motion, in `unit`.
        std: its standard deviation over windows; that of the method is added.
        unit: rad or m.

    Returns:
        Width and standard deviation.

    """
    return f'{width:.4g} ± {math.hypot(std, GAP_ERROR * width):.2g} {unit}'


def gain_text(gains: Mapping[str, float], name: str) -> str:
    """Return the gain of `name` and, in brackets, its distance to the best of `gains`."""
    lag = max(gains.values()) - gains[name]
    return f'{gains[name]:.0f}' + (f' (-{lag:.0f})' if lag > 0.0 else '')


def percent(value: float | None) -> str:
    """Return the share `value` in percent, 'not defined' for None."""
    return 'not defined' if value is None else f'{100 * value:.1f} %'


def undefined(data: Mapping[str, Any]) -> str:
    """Return why the verdict `data` has no closed fraction."""
    ids = ids_of(data)
    if data['verdict'] in LACKING and (data.get('gap_before') or 0.0) > NEAR_FLOOR:
        return 'no effect and no torque map explains readings that were not fitted'
    if DISTURBANCE.id in ids:
        return 'a disturbance does not repeat'
    if any(name in EFFECTS and EFFECTS[name].lattice for name in ids):
        return 'rounding does not move the model'
    return 'the gap is too small'


def torque_map_of(data: Mapping[str, Any]) -> tuple[str, list[tuple[str, str, str]]] | None:
    """Return (words, [(where, torque, its deviation)]) of the torque map of a verdict, or None."""
    table = (data.get('remainder') or {}).get('torque_map')
    if not table:
        return None
    rows = [(number(x), number(torque), f'{deviation:.2g}') for x, torque, deviation in zip(
        table['knots'], table['values'], table['deviations'])]
    return f'{PLACES[table["place"]]}, torque over {table["variable"]}', rows


def dense_regions(regions: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return phrases about `regions` of the motion where the gap is much denser than elsewhere."""
    words = []
    for name, shares in regions.items():
        if name == 'frequency':
            continue
        time, residual = shares['time'], shares['residual']
        density = {k: residual[k] / time[k] for k in time if time[k] and residual.get(k)}
        densest = max(density, key=lambda k: density[k], default=None)
        if densest and density[densest] >= DENSE:
            words.append(f'{name} {densest.replace("_", " ")} ({100 * residual[densest]:.0f} % of '
                         f'it in {100 * time[densest]:.0f} % of the time)')
    return words


def next_steps(data: Mapping[str, Any], closed_written: bool, validated: str | None,
               axis: str = 'rotary') -> Sequence[str]:
    """
    Return advice after a diagnosis.

    Args:
        data: the verdict as plain data.
        closed_written: whether the closed model was written.
        validated: name of the second recording, or None.
        axis: of the model.

    Returns:
        Sentences without capital letter and full stop.

    """
    if data['verdict'] == 'none':
        return ['nothing: simulate with the model as it is. An effect too small for this motion '
                'and noise stays hidden']
    if data['verdict'] in LACKING:
        follows = (data.get('misfit') or {}).get('follows')
        law = f': the residual depends on the {follows["over"]}' if follows else ''
        fraction = data.get('closed_fraction')
        closed = [f'simulate with drive.closed.yaml, which closes {percent(fraction)} of the gap '
                  'on readings that were not fitted'] if closed_written and fraction else []
        return [*closed, f'look at the place of the verdict{law}; record again with another '
                'motion, to see whether it is the same; add an effect of your own '
                '(docs/effects.md) and diagnose again']
    ids = set(ids_of(data))
    advice = _separating_motions(ids, data.get('confusable') or (), axis)
    if DISTURBANCE.id in ids:
        return [*advice, 'look for contacts at these times, and record again without them']
    if any(name in EFFECTS and EFFECTS[name].lattice for name in ids):
        return [*advice, 'the model is right; a finer encoder reading would show more']
    if closed_written and 'kp' in (data.get('nominal') or {}):  # no torque to export or to fit
        advice.append('simulate with drive.closed.yaml')
    elif closed_written:
        advice += ['simulate with drive.closed.yaml, or write it into the file of your simulator: '
                   'gearbox_monitor export drive.closed.yaml --to mjcf --into robot.xml --joint '
                   'NAME',
                   'fit its values to all recordings of the drive: gearbox_monitor fit-nominal '
                   'BAG BAG2 --model drive.closed.yaml --out fitted.yaml']
    else:
        advice.append('write the model that closes the gap: --out DIR')
    if not validated:
        advice.append('test it on a recording with another motion: --validate BAG2')
    return advice


def _separating_motions(ids: set[str], rivals: Iterable[str], axis: str) -> list[str]:
    """Return the motions that separate the effects `ids` from their rivals."""
    advice = []
    for pair, motion in SEPARATES:
        if pair & ids and (pair - ids) & set(rivals) and not pair <= ids:
            effect, rival = ', '.join(sorted(pair & ids)), ', '.join(sorted(pair - ids))
            advice.append(f'{effect} or {rival}: {motion}' if motion.startswith('no ') else
                          on_axis(f'to distinguish {effect} from {rival}, record {motion}', axis))
    return advice
