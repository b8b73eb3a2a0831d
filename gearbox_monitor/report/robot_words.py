# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A robot's verdict in words, for terminals and pages."""
from collections.abc import Mapping, Sequence
import math
import shlex
from types import MappingProxyType
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, RobotReading
from gearbox_monitor.diagnosis.robot.power import UNDECIDED
from gearbox_monitor.diagnosis.robot.robot_effects import JOINT, ROBOT_EFFECTS
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.summary import change, in_unit, pretty, sized, with_deviation
from gearbox_monitor.report.words import counted

OF_CHANGES = {'Cc_change': 'N m', 'Cv_change': 'N m s/rad', 'm1_change': 'kg m^2',
              'T_change': 's', 'kp_factor': '', 'Ca': 'N m', 'moment': 'kg m', 'moved': 'm'}
UNITS = {**{e.id: {p.name: p.unit for p in e.parameters} for e in EFFECTS.values()},
         **{e.id: dict(e.units) for e in ROBOT_EFFECTS}}
ALL_ROTARY: Mapping[str, str] = MappingProxyType({})
ON_BODIES = {e.id for e in ROBOT_EFFECTS if e.place != JOINT}
MEANINGS = {**{e.id: e.meaning for e in EFFECTS.values()},
            **{e.id: e.meaning for e in ROBOT_EFFECTS}}
# The value by which a report states an effect, and what it is in words.
SUBJECTS = {**{e.id: (e.column.states or e.parameters[0].name, e.noun)
               for e in EFFECTS.values() if e.column is not None},
            **{e.id: e.subject for e in ROBOT_EFFECTS if e.subject[0]}}


def axes_of(data: Mapping[str, Any]) -> dict[str, str]:
    """Return {joint: rotary or prismatic} of a verdict's data."""
    return {gap['joint']: gap.get('axis', 'rotary') for gap in data.get('ranked', ())}


def unit_of(effect: str, name: str, axis: str) -> str:
    """Return the unit of the value `name` of an effect at an `axis`, '' for a pure number."""
    unit = OF_CHANGES.get(name) or UNITS.get(effect, {}).get(name, '')
    return pretty(unit if effect in ON_BODIES else on_axis(unit, axis))


def size_unit(effect: str, axis: str) -> str:
    """Return the unit of the value by which a report states an effect at an `axis`."""
    first = {'payload': 'm', 'base_tilt': 'ax', 'link_inertia': 'Ixx'}.get(
        effect) or SUBJECTS.get(effect, ('', ''))[0]
    return unit_of(effect, first, axis)


def rounded(value: float, deviation: float | None) -> str:
    """Return `value` ± `deviation`, or in words that the motion does not determine it."""
    if deviation is None:
        return f'about {value:.2g} (not determined by this motion)'
    return with_deviation(value, deviation) if 0.0 < deviation < math.inf else sized(value)


def finding_words(finding: Mapping[str, Any], axes: Mapping[str, str] = ALL_ROTARY) -> str:
    """Return one sentence, without a full stop, on a finding; `axes`: of the joints."""
    axis = axes.get(finding.get('joint') or '', 'rotary')
    values, deviations = finding['values'], finding['deviations']
    where = finding.get('joint') or finding.get('link') or 'base'
    effect = finding['effect']
    if effect == 'payload':
        if 'moved' in values:
            return (f'{where}: the centre of what it carries moved by '
                    f'{rounded(100.0 * values["moved"], 100.0 * (deviations["moved"] or 0.0))} cm')
        if 'moment' in values:
            return (f'a load at {where} whose mass times distance is '
                    f'{rounded(values["moment"], deviations["moment"])} kg m: this motion does '
                    'not tell the mass from the distance')
        if deviations['m'] is None:
            return f'a load at {where} that this motion does not weigh'
        reach = math.sqrt(sum(values[c] ** 2 for c in ('cx', 'cy', 'cz')))
        size = rounded(abs(values['m']), deviations['m'])
        comparison = 'more' if values['m'] >= 0.0 else 'less'
        place = (f'centre {100 * reach:.0f} cm out'
                 if None not in (deviations['cx'], deviations['cy'], deviations['cz'])
                 else 'this motion does not say where')
        return f'{size} kg {comparison} at {where}, {place}'
    if effect == 'base_tilt':
        angle = math.degrees(math.hypot(values['ax'], values['ay']))
        return f'the base is tilted by {angle:.2f}° against the model'
    if effect == 'link_inertia':
        return f'{where}: inertia of the link is not that of the model'
    name, words = SUBJECTS.get(effect, (next(iter(values)), MEANINGS.get(effect, effect)))
    value, deviation = values[name], deviations[name]
    if name.endswith('_factor'):
        text = f'{where}: {words} {rounded(value, deviation)} times that of the model'
    elif name.endswith('_change'):
        text = f'{where}: {words} {_changed(effect, name, finding, axis)}'
    else:
        text = f'{where}: {words} ' + in_unit(rounded(value, deviation),
                                              unit_of(effect, name, axis))
    if 'Ca' in values and name != 'Ca':
        text += (f', {rounded(values["Ca"], deviations["Ca"])} {on_axis("N m", axis)} more one '
                 'way than the other')
    if 'N' in values:
        text += f', {values["N"]:.0f} per turn'
    if 'q0' in values:
        text += f' from {values["q0"]:.2f} {on_axis("rad", axis)} on'
    return text + (f' ({finding["channel"]})' if finding.get('channel') else '')


def _changed(effect: str, name: str, finding: Mapping[str, Any], axis: str) -> str:
    """Return the change `name` in words, beside the whole value and the model's where known."""
    value, deviation = finding['values'][name], finding['deviations'][name]
    unit = unit_of(effect, name, axis)
    signed = '+' * (value >= 0.0) + in_unit(rounded(value, deviation), unit)
    whole = finding['values'].get(name.removesuffix('_change'))
    if whole is None:
        return signed
    nominal = whole - value
    if nominal <= 0.0:
        return f'{signed}, none in the model'
    return f'{signed}: {sized(whole)}, not {sized(nominal)} ({change(whole, nominal)})'


def remainder_words(remainder: Mapping[str, Any], axes: Mapping[str, str]) -> str:
    """Return a `remainder` in a sentence without a full stop; `axes`: of the joints."""
    unit = on_axis('N m', axes.get(remainder['joint'], 'rotary'))
    size = f'{remainder["size"]:.2g} {unit} rms'
    if remainder['over'] == 'bursts':
        names = remainder.get('recordings') or [''] * len(remainder['times'])
        times = ', '.join(f'{begin:.0f} s' + (f' of {name}' if name else '')
                          for name, (begin, _) in list(zip(names, remainder['times']))[:4])
        return f'{remainder["joint"]}: {size} in bursts, at {times}'
    if remainder['over'] is None:
        return (f'{remainder["joint"]}: {size} without a pattern, '
                f'{remainder["excess"] ** 0.5:.2g} times what healthy parts leave')
    return f'{remainder["joint"]}: {size} over {remainder["over"]}, by no law of the library'


def reading_words(named: NamedReading, joints: Sequence[str]) -> str:
    """Return how a log of `joints` has to be read, with the option that says so."""
    reading = named.reading
    options = ' or '.join(_option(r, joints) for r in (reading, *named.rivals))
    changed = list(reading.swapped or reading.joints)
    names = [joints[j] for j in changed]
    before, after = (100.0 * math.sqrt(float(np.mean(score.unexplained[changed])))
                     for score in (named.recorded, named.score))
    known = (f'read so, weight and inertia of the model leave {after:.2g} % of the effort there, '
             f'as recorded {before:.2g} % even with any load, friction or mounting')
    if reading.swapped:
        first, second = names
        return f'{first} and {second} are exchanged in the log: {known}; {options} settles it'
    convention = next(iter(reading.joints.values()))
    where = 'all joints' if len(names) > 1 and len(names) == len(joints) else ', '.join(names)
    says = {'reversed': f'{where} counts the other way in the log than in the model',
            'effort:-1': f'the effort of {where} has the other sign than in the model',
            'reversed,effort:-1': f'the position of {where} has the other sign than in the model, '
                                  'the effort has not',
            'deg': f'the position of {where} is in degrees',
            'mm': f'the position of {where} is in mm'}.get(convention.rules)
    if says is None:
        says = (f'the log has {where} at {convention.zero:.3g} rad where the model is at 0'
                if convention.zero else
                f'the effort of {where} is {1.0 / abs(convention.effort):.3g} times the torque of '
                'the model' + (' with the other sign' if convention.effort < 0.0 else '')
                + ', as of another unit or a current')
    return f'{says}: {known}; {options} settles it'


def _option(reading: RobotReading, joints: Sequence[str]) -> str:
    """Return the option of a command that has a log of `joints` read so."""
    if reading.swapped:
        first, second = (joints[j] for j in reading.swapped)
        return f'--recorded {first}={second} {second}={first}'
    (joint, *others), convention = reading.joints, next(iter(reading.joints.values()))
    return f'--convention {"all" if others else joints[joint]}={convention.rules}'


def robot_headline(data: Mapping[str, Any]) -> str:
    """Return the verdict `data` in words: what differs, by how much, whether that is all."""
    if data.get('readings'):
        rest = robot_headline({**data, 'readings': []})
        return f'{"; ".join(data["readings"])}. Read so: {rest}'
    findings, remainders, axes = data['findings'], data['remainders'], axes_of(data)
    against = 'the references' if data.get('references') else 'the model file'
    if data['verdict'] == 'none':
        gap = max(data['ranked'], key=lambda g: g['before'])
        return (f'The robot is as {against} say{"s" * ("file" in against)}: no joint differs by '
                f'more than noise ({gap["joint"]}, the largest: {gap["before"]:.2g} '
                f'{on_axis("N m", axes[gap["joint"]])} rms).')
    if data['verdict'] == UNDECIDED:
        return f'Nothing differs from {against} as far as this motion shows: {_unseen(data)}.'
    if data['verdict'] == 'unknown':
        cause = ('or they do not know this motion' if data['unvisited'] else
                 'and no known effect explains it')
        return (f'The robot differs from {against}, {cause}: '
                f'{remainder_words(remainders[0], axes)}.')
    words = '; '.join(finding_words(f, axes) for f in findings)
    if data['verdict'] == 'effect':
        return (f'{words}. '
                + ('This explains' if len(findings) == 1 else 'Together they explain')
                + ' the whole difference.')
    return f'{words}. The rest has no known cause: {remainder_words(remainders[0], axes)}.'


def _unseen(data: Mapping[str, Any]) -> str:
    """Return what the motion of an undecided verdict does not show, in words."""
    axes, asked = axes_of(data), data['questions']
    if data['not_judged']:
        return f'no reference explains the effort of {", ".join(data["not_judged"])}'
    if not asked:
        return 'the reference is too short for what remains'
    first = asked[0]
    least = (f'any {_named(first["effect"])}' if first['smallest'] is None else
             f'{_named(first["effect"])} below {_size(first, "smallest", axes)}')
    more = f', and {counted(len(asked) - 1, "more change")}' if len(asked) > 1 else ''
    return f'it would not show {least} at {first["place"]}{more}'


def _named(effect: str) -> str:
    return SUBJECTS.get(effect, ('', effect))[1]


def _size(question: Mapping[str, Any], key: str, axes: Mapping[str, str]) -> str:
    axis = axes.get(question['joint'], 'rotary')
    return in_unit(f'{question[key]:.2g}', size_unit(question['effect'], axis))


def question_words(question: Mapping[str, Any], axes: Mapping[str, str]) -> str:
    """Return the motion that would answer a `question` of a verdict; `axes`: of the joints."""
    joint, effect = question['joint'], question['effect']
    unit = pretty(on_axis('rad/s', axes.get(joint, 'rotary')))
    speed, seconds = max(question['speed'], 0.1), question['seconds']
    how = {MOTOR_COULOMB.id: f'move {joint} alone, to and fro at {0.2 * speed:.2g} to '
                             f'{speed:.2g} {unit}',
           TORQUE_GAIN.id: f'move {joint} fast or against gravity, with and without a load, to '
                           f'and fro at up to {2.0 * speed:.2g} {unit}'}.get(
        effect, f'move all joints that carry {question["place"]} against gravity')
    return (f'{how} for {seconds:.0f} s: it would show {_named(effect)} of '
            f'{_size(question, "plausible", axes)} at {question["place"]}')


def next_steps(data: Mapping[str, Any]) -> list[str]:
    """Return what to do after the verdict `data`, with its own file names."""
    logs = shlex.join(data['logs'])
    model = ' '.join(filter(None, (shlex.quote(data['model']), data['options'])))
    steps = []
    if data['unvisited']:
        steps.append('the reference visited less than this motion: record the healthy robot on it '
                     'too, and learn both: gearbox_monitor learn '
                     f'{shlex.join(data["references"])} NEW --model {model} --out robot.knowledge')
    if data['verdict'] == 'none' and not data.get('references'):
        steps.append('compare with a log of the healthy robot to see smaller changes: '
                     f'gearbox_monitor diagnose {logs} --model {model} --reference HEALTHY')
    for f in data['findings']:
        rivals = [name for name in f['confusable'] if not name.startswith('arm_')]
        if rivals:
            steps.append(f'{f["effect"]} at {f.get("joint") or f.get("link")} is '
                         f'indistinguishable from {", ".join(rivals)}')
    if data['verdict'] == UNDECIDED:
        steps += [question_words(q, axes_of(data)) for q in data['questions'][:2]]
    if data['findings'] and data.get('closed'):
        steps.append(f'use {data["closed"]}: the model with what was found')
    if data['remainders']:
        steps.append(f'look at {data["remainders"][0]["joint"]}: what remains follows no law; '
                     'record slow moves of this joint alone')
    return steps


def robot_text(data: Mapping[str, Any]) -> str:
    """Return the verdict `data` in some ten lines."""
    lines, axes = [data['summary']], axes_of(data)
    lines += [f'  remains: {remainder_words(r, axes)}' for r in data['remainders'][
        0 if data['verdict'] == 'none' else 1:]]
    gaps = ', '.join(f'{g["joint"]} {g["before"]:.2g} -> {g["after"]:.2g}'
                     + ' N' * (axes[g['joint']] == 'prismatic') for g in data['ranked'][:4])
    lines.append(f'gap of the torque, N m rms before -> after: {gaps}')
    runs = (data.get('rollouts') or {}).get('joints') or {}
    if runs:
        lines.append('MuJoCo after 0.5 s, mrad rms off with the file -> with the closed one: '
                     + ', '.join(f'{j} {1e3 * v["before"]:.2g} -> {1e3 * v["after"]:.2g}'
                                 + ' mm' * (axes[j] == 'prismatic') for j, v in runs.items()))
    lines += [f'not in the closed file: {words}' for words in data.get('lacking') or ()]
    if data['verdict'] in ('none', 'unknown', UNDECIDED):
        sizes = []
        for effect in ('payload', MOTOR_COULOMB.id, TORQUE_GAIN.id):
            places = data['visible'].get(effect)
            if places:
                # What a motion shows at its worst joint; a load at the link that shows it best.
                worst = min if effect == 'payload' else max
                place, size = worst(places.items(), key=lambda item: item[1])
                sizes.append(f'{effect} of {size:.2g} '
                             f'{size_unit(effect, axes.get(place, "rotary"))} at {place}')
        if sizes:
            lines.append(f'would have been seen, from: {", ".join(sizes)}')
    lines += [f'caution: {c}' for c in data['cautions'][:3]]
    lines += [f'note: {n}' for n in data['warnings'][:3]]
    lines += [f'next: {s}' for s in next_steps(data)[:2]]
    return '\n'.join(lines)
