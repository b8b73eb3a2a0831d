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

"""Words for a verdict, shared by the terminal and the page: effects, places, what to do next."""
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.arm_side import DISTURBANCE
from gearbox_monitor.plant.units import on_axis

NEAR_FLOOR = 1.5  # gap that may be noise of the encoders
DENSE = 1.5  # share of the gap over share of the time, from which on it is told
PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'actuator': 'actuator', 'motor_sensor': 'motor encoder', 'arm_sensor': 'arm encoder'}
# What each effect means on a real drive.
MEANINGS = {name: effect.meaning for name, effect in EFFECTS.items()}
SUGGESTED = 'a motion that tells more, no larger than that of the recording, is found by'
# Recordings that separate what others leave open.
SEPARATES = tuple(({name, other}, motion) for name, effect in EFFECTS.items()
                  for other, motion in effect.separated_by.items())


def meaning(name, axis):
    """Return what the effect `name` means on a drive with this axis, '' for ids not known here."""
    return on_axis(MEANINGS.get(name, ''), axis)


def unit_of(reading, angle):
    """Return the unit of what is compared, `reading` of Recording.readings; angle: rad or m."""
    return ('N m' if angle == 'rad' else 'N') if reading == 'torque' else angle


def ids_of(data):
    """Return the ids of the effect that `data` (the JSON of a verdict) names."""
    return data['effect'].split('+') if data.get('effect') else []


def headline(data):
    """Return the verdict in one sentence."""
    if data['verdict'] == 'none' and (data.get('gap_after') or 0.0) > NEAR_FLOOR:
        return ('No effect stands out: what the model leaves is no more than what lasts '
                'unexplained on a real drive.')
    if data['verdict'] == 'none':
        return 'No gap: the model explains the recording down to the noise of the encoders.'
    places = data.get('location') or []
    places = [places] if isinstance(places, str) else list(places)
    named = [PLACES.get(place, place) for place in places]
    if data['verdict'] == 'unknown':
        known = [name for name in named if name not in ('unknown', 'none')]
        at = f'Place: {" and ".join(known)}.' if known else 'Its place is not clear either.'
        return f'There is a gap, and no known effect explains it. {at}'
    ids = ids_of(data)
    if len(ids) > 1 and len(named) == len(ids):
        return 'Two effects: ' + ' and '.join(
            f'{name} ({place})' for name, place in zip(ids, named)) + '.'
    return f'Effect: {"+".join(ids)} ({" and ".join(named)}).'


def number(value):
    """Return `value` with three or four digits, 'none' for None."""
    return 'none' if value is None else f'{value:.4g}'


def behind(gains, name):
    """Return the gain of `name` and, in brackets, how far it is behind the best of `gains`."""
    lag = max(gains.values()) - gains[name]
    return f'{gains[name]:.0f}' + (f' (-{lag:.0f})' if lag > 0.0 else '')


def percent(value):
    """Return the share `value` in percent, 'not defined' for None."""
    return 'not defined' if value is None else f'{100 * value:.1f} %'


def undefined(data):
    """Return why there is no closed fraction."""
    ids = set(ids_of(data))
    if DISTURBANCE.id in ids:
        return 'a disturbance does not repeat'
    if any(name in EFFECTS and EFFECTS[name].lattice for name in ids):
        return 'rounding does not move the model'
    return 'the gap is too small'


def dense_regions(regions):
    """Return phrases about where in the motion the gap is much denser than elsewhere."""
    words = []
    for name, shares in regions.items():
        if name == 'frequency':
            continue
        time, residual = shares['time'], shares['residual']
        dense = {k: residual[k] / time[k] for k in time if time[k] and residual.get(k)}
        most = max(dense, key=dense.get, default=None)
        if most and dense[most] >= DENSE:
            words.append(f'{name} {most.replace("_", " ")} ({100 * residual[most]:.0f} % of it in '
                         f'{100 * time[most]:.0f} % of the time)')
    return words


def next_steps(data, closed_written, validated, axis='rotary'):
    """
    Return sentences about what to do now.

    closed_written: whether the closed model was written; validated: the second recording or None;
    axis: of the model.
    """
    ids, advice = set(ids_of(data)), []
    if data['verdict'] == 'none':
        return ['nothing: simulate with the model as it is. An effect too small for this motion '
                'and noise stays unseen']
    if data['verdict'] == 'unknown':
        follows = (data.get('misfit') or {}).get('follows')
        law = f': what is left is a function of the {follows["over"]}' if follows else ''
        return [f'look at the place named{law}; record again with other motion, to see whether it '
                'is the same; add an effect of your own (docs/effects.md) and diagnose again']
    rivals = set(data.get('confusable') or ())
    for pair, motion in SEPARATES:
        if pair & ids and (pair - ids) & rivals and not pair <= ids:
            other = ', '.join(sorted(pair - ids))
            named = ', '.join(sorted(pair & ids))
            advice.append(f'{named} or {other}: {motion}' if motion.startswith('no ') else
                          on_axis(f'to tell {named} from {other}, record {motion}', axis))
    if DISTURBANCE.id in ids:
        return [*advice, 'look for contacts at the times given, and record again without']
    if any(name in EFFECTS and EFFECTS[name].lattice for name in ids):
        return [*advice, 'the model is right; a finer encoder reading would show more']
    if not closed_written:
        advice.append('write the model that closes the gap: --out DIR')
    if not validated:
        advice.append('test it on a recording with other motion: --validate BAG2')
    return advice
