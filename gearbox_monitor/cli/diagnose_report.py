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

"""The verdict of a diagnosis in words: what was found, where, how sure, what to do next."""
import textwrap

from gearbox_monitor.drive.effects import library

WIDTH = 80
LABEL = 15
SHOWN = 8  # lines of the ranking
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


def ids_of(data):
    """Return the ids of the effect that `data` (the JSON of a verdict) names."""
    return data['effect'].split('+') if data.get('effect') else []


def headline(data):
    """Return the verdict in one sentence."""
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


def text(data, recordings, model, written=(), validated=None):
    """
    Return the verdict `data` as lines for people, at most 80 columns.

    recordings: gap.recording.Recording of it; model: nominal DriveModel; written: files.
    """
    lines = []
    for recording in recordings:
        lines += _entry('recording', f'{recording.name}: {recording.duration:.1f} s, '
                        f'{1.0 / recording.dt:.0f} samples/s')
    sigma = data['sigma']
    lines += _entry('noise', ', '.join(f'{name} {value:.3g} rad' for name, value in
                                       zip(('motor', 'arm'), sigma) if value is not None))
    lines += ['', *textwrap.wrap(headline(data), WIDTH)]
    lines += [line for name in ids_of(data) for line in _meaning(name)]
    lines += ['', *_gap(data), *_parameters(data), *_ranking(data), *_where(data)]
    lines += _nominal(data, model)
    lines += _validation(data, validated)
    lines += [line for warning in data.get('warnings', ()) for line in _entry('note', warning)]
    for advice in _next(data, written, validated):
        lines += _entry('next', advice)
    lines += [line for path in written for line in _entry('written', str(path))]
    return '\n'.join(lines)


def _entry(label, words):
    """Return `words` as lines beside `label`."""
    return textwrap.wrap(words, WIDTH, initial_indent=f'{label:<{LABEL}s}',
                         subsequent_indent=' ' * LABEL, break_on_hyphens=False) or [label]


def _meaning(name):
    effect = library().get(name)
    means = MEANINGS.get(name)
    lines = textwrap.wrap(f'{means[0].upper()}{means[1:]}.', WIDTH - 2) if means else []
    lines += textwrap.wrap(effect.equation, WIDTH - 2) if effect else []
    return [f'  {line}' for line in lines]


def number(value):
    """Return `value` with three or four digits, 'none' for None."""
    return 'none' if value is None else f'{value:.4g}'


def percent(value):
    """Return the share `value` in percent, 'not defined' for None."""
    return 'not defined' if value is None else f'{100 * value:.1f} %'


def _gap(data):
    lines = _entry('gap', f'{number(data["gap_before"])} before, {number(data["gap_after"])} '
                   'after, in standard deviations of the noise; 1 is the floor')
    closed, interval = data.get('closed_fraction'), data.get('closed_fraction_ci')
    if data['verdict'] == 'none':
        return lines
    words = percent(closed)
    if closed is not None and interval:
        words += f' (90 % interval {percent(interval[0])} to {percent(interval[1])})'
    if closed is None:
        words += _undefined(data)
    lines += _entry('closed', words)
    for channel, part in (data.get('channels') or {}).items():
        lines.append(f'  {channel:<{LABEL - 2}s}{number(part["before"])} before, '
                     f'{number(part["after"])} after')
    return lines


def _undefined(data):
    ids = set(ids_of(data))
    if 'disturbance' in ids:
        return ': a disturbance does not repeat'
    if any('quantisation' in name for name in ids):
        return ': rounding does not move the model'
    return ': the gap is too small'


def _parameters(data):
    lines, known = [], library()
    errors = data.get('standard_errors') or {}
    if data['verdict'] == 'unknown' and data.get('params'):
        lines += _entry('nearest', ' + '.join(data['params']) + ', which leaves the gap "after"')
    for name, values in (data.get('params') or {}).items():
        units = {p.name: p.unit for p in known[name].parameters} if name in known else {}
        for parameter, value in values.items():
            if not isinstance(value, (int, float)):
                value, error = str(value), None
            else:
                value, error = number(value), (errors.get(name) or {}).get(parameter)
            pm = f' +- {error:.2g}' if error else ''
            unit = units.get(parameter, '')
            first = not any(line.startswith('values') for line in lines)
            lines.append(f'{"values" if first else "":<{LABEL}s}{name} {parameter} = '
                         f'{value}{pm}{" " + unit if unit not in ("", "-") else ""}')
    return lines


def _ranking(data):
    gains = data.get('gains') or {}
    best = sorted(gains, key=gains.get, reverse=True)[:SHOWN]
    lines = [f'{"" if k else "ranking":<{LABEL}s}{k + 1}. {name:<44s}{gains[name]:12.1f}'
             for k, name in enumerate(best)]
    if lines:
        lines += _entry('', 'gain: by how much it beats the plain model, in 2 log likelihood less '
                        'a price per parameter')
    if data.get('confusable') and data['verdict'] == 'effect':
        lines += _entry('not separable', ', '.join(data['confusable'])
                        + ': this recording cannot tell it from the effect named')
    return lines


def _where(data):
    if data['verdict'] == 'none':
        return []
    lines = []
    found = data['where']
    for place, part in found['places'].items():
        shown = 'motor, actuator' if place == 'motor_side' else PLACES[place]
        lines.append(f'{"" if lines else "where":<{LABEL}s}{shown:<18s}a free signal there '
                     f'explains {100 * part["explained"]:5.1f} %')
    return lines + _regions(found.get('region') or {})


def _regions(regions):
    """Return a line about where in the motion the gap is much denser than elsewhere."""
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
    return _entry('gap sits at', ', '.join(words)) if words else []


def _nominal(data, model):
    shifts = data.get('nominal_shift')
    if not shifts:
        return []
    words = [f'{name} {number(data["nominal"][name])} ({shift:+.1f})'
             for name, shift in shifts.items()]
    lines = _entry('model values', ', '.join(words) + '; in brackets: off by so many tolerances')
    if model.tolerance:
        lines += _entry('torque noise', f'{number(data["process_torque"])} N m rms per sample')
    return lines


def _validation(data, validated):
    found = data.get('validation')
    if not found:
        return []
    lines = _entry('validation', f'{validated}: gap {number(found.get("gap_before"))} before, '
                   f'{number(found.get("gap_after"))} after, closed '
                   f'{percent(found.get("closed_fraction"))}')
    run = found.get('free_run')
    if run:
        one, other = (', '.join(
            f'{name} {number(run[when][name])}' for name in ('motor', 'arm'))
            for when in ('before', 'after'))
        lines += _entry('', f'one free run of {run["seconds"]:.0f} s, rms in rad: {one} before; '
                        f'{other} after')
    return lines


def _next(data, written, validated):
    """Return sentences about what to do now."""
    ids, advice = set(ids_of(data)), []
    if data['verdict'] == 'none':
        return ['nothing: simulate with the model as it is. An effect too small for this motion '
                'and noise stays unseen']
    if data['verdict'] == 'unknown':
        return ['look at the place named; record again with other motion, to see whether it is '
                'the same; add an effect of your own (docs/effects.md) and diagnose again']
    rivals = set(data.get('confusable') or ())
    for pair, motion in SEPARATES:
        if pair & ids and (pair - ids) & rivals and not pair <= ids:
            other = ', '.join(sorted(pair - ids))
            advice.append(motion if motion.startswith('no ') else
                          f'to tell {", ".join(sorted(pair & ids))} from {other}, record {motion}')
    if 'disturbance' in ids:
        return [*advice, 'look for contacts at the times given, and record again without']
    if any('quantisation' in name for name in ids):
        return [*advice, 'the model is right; a finer encoder reading would show more']
    if not any(path.name == 'drive.closed.yaml' for path in written):
        advice.append('write the model that closes the gap: --out DIR')
    if not validated:
        advice.append('test it on a recording with other motion: --validate BAG2')
    return advice
