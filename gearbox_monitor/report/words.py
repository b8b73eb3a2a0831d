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
from gearbox_monitor.plant.units import on_axis

NEAR_FLOOR = 1.5  # gap that may be noise of the encoders
DENSE = 1.5  # share of the gap over share of the time, from which on it is told
PLACES = {
    'motor_side': 'motor side', 'arm_side': 'arm side', 'transmission': 'transmission',
    'actuator': 'actuator', 'motor_sensor': 'motor encoder', 'arm_sensor': 'arm encoder'}
# What each effect means on a real drive.
MEANINGS = {
    'motor_viscous': 'viscous friction of the motor is not that of the model',
    'motor_coulomb': 'Coulomb friction of the motor is not that of the model',
    'stribeck': 'friction of the motor is higher at low speed',
    'lugre': 'friction of the motor gives elastically before it slips, and falls with speed',
    'coulomb_asymmetry': 'friction of the motor differs between the directions',
    'load_friction': 'friction of the motor grows with the transmitted torque',
    'motor_inertia': 'inertia of the motor is not that of the model',
    'viscous_drift': 'viscous friction changes during the recording, as oil that warms up',
    'cogging': 'torque of the motor varies with its angle, also without current',
    'arm_viscous': 'viscous friction on the arm',
    'arm_coulomb': 'Coulomb friction on the arm',
    'gravity': 'weight of the arm',
    'load_torque': 'constant torque on the arm',
    'arm_inertia': 'inertia of the arm is not that of the model, as with a payload',
    'disturbance': 'short torque bursts on the arm, as from contacts',
    'backlash_gap': 'backlash is not that of the model',
    'stiffness': 'stiffness of the gearbox is not that of the model',
    'hardening': 'gearbox stiffens (or softens) with load',
    'hysteresis_bouc_wen': 'gearbox loses energy: torque over twist is a loop with soft ends',
    'hysteresis_branch': 'torque over twist has two branches, one per direction',
    'transmission_damping': 'damping of the gearbox is not that of the model',
    'mesh_error': 'transmission error that repeats with the angle of the motor',
    'torque_gain': 'torque is commanded in another scale, as by a wrong torque constant',
    'torque_offset': 'torque has a constant offset',
    'actuator_lag': 'torque follows the command with a lag',
    'actuator_delay': 'torque follows the command with a dead time',
    'saturation': 'torque is limited below the command',
    'torque_ripple': 'torque is modulated with the angle of the motor',
    'motor_encoder_eccentricity': 'disc of the motor encoder is off centre',
    'motor_encoder_quantisation': 'motor encoder is coarse',
    'motor_encoder_delay': 'reading of the motor encoder is late',
    'arm_encoder_eccentricity': 'disc of the arm encoder is off centre',
    'arm_encoder_quantisation': 'arm encoder is coarse',
    'arm_encoder_delay': 'reading of the arm encoder is late',
    'encoder_offset': 'encoders do not share their zero',
}
SUGGESTED = 'a motion that tells more, no larger than that of the recording, is found by'
# Recordings that separate what others leave open.
SEPARATES = (
    ({'torque_offset', 'coulomb_asymmetry'},
     'no motion separates them: they differ only near standstill'),
    ({'actuator_lag', 'actuator_delay'}, 'a chirp or fast motion above 5 Hz'),
    ({'motor_viscous', 'motor_coulomb'}, 'steps to several speeds'),
    ({'arm_viscous', 'arm_coulomb'}, 'steps to several speeds'),
    ({'motor_viscous', 'arm_viscous'}, 'frequent reversals through the backlash'),
    ({'motor_viscous', 'viscous_drift'}, 'a longer recording, the same motion early and late'),
    ({'load_torque', 'torque_offset'}, 'slow moves and dwells'),
    ({'stribeck', 'lugre'}, 'slow reversals'),
    ({'stribeck', 'motor_coulomb'}, 'slow reversals and several speeds'),
    ({'stiffness', 'hardening'}, 'several load amplitudes'),
    ({'stiffness', 'backlash_gap'}, 'several load amplitudes on both flanks'),
    ({'torque_gain', 'motor_coulomb'}, 'dynamic torque instead of slow motion'),
    ({'load_friction', 'motor_coulomb'}, 'several load amplitudes'),
    ({'gravity', 'cogging'}, 'a wide range of angles'),
    ({'motor_encoder_eccentricity', 'arm_encoder_eccentricity'}, 'more than one turn of travel'),
)


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
    if 'disturbance' in ids:
        return 'a disturbance does not repeat'
    if any('quantisation' in name for name in ids):
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
    if 'disturbance' in ids:
        return [*advice, 'look for contacts at the times given, and record again without']
    if any('quantisation' in name for name in ids):
        return [*advice, 'the model is right; a finer encoder reading would show more']
    if not closed_written:
        advice.append('write the model that closes the gap: --out DIR')
    if not validated:
        advice.append('test it on a recording with other motion: --validate BAG2')
    return advice
