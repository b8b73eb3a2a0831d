# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a verdict says in words, of a drive and of a robot alike: for terminals, pages and JSON.

All of it reads the plain data of a verdict, as JSON has them. Those of a drive have an `axis`;
those of a robot have it at each joint of `gaps`.
"""
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, groupby
import math
from pathlib import Path
import shlex
from typing import Any, NamedTuple

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import EFFECT, INCOMPLETE, NONE, UNDECIDED, UNKNOWN
from gearbox_monitor.diagnosis.robot.robot_effects import JOINT, LINK, ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.servo import SERVO
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.arm_side import ARM_INERTIA, DISTURBANCE
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA, STRIBECK
from gearbox_monitor.presentation import (
    change, credible, number, on_axis, percent, Quantity, Said, said)
from gearbox_monitor.report.sentences import entries, labelled, PLACES, say, wrapped

VerdictData = Mapping[str, Any]  # a verdict as plain data
NO_DATA: VerdictData = {}
NEAR_FLOOR = 1.5  # misfit that may be noise of the encoders
WHOLE = 0.3       # of a gap: the most that remains where findings explain the whole of it
NOTHING = ('none', 'undecided')  # verdicts without a gap
LACKING = ('incomplete', 'unknown')  # verdicts with a remainder
# The meaning of each effect on a real drive or robot.
MEANINGS = {e.id: e.meaning for e in EFFECTS.values()} | {
    e.id: e.meaning for e in ROBOT_EFFECTS}
OF_ROBOTS = {effect.id: effect for effect in ROBOT_EFFECTS}
EVENTS = {DISTURBANCE.id, SLIP.id}
OF_CHANGES = {'Cc_change': 'N m', 'Cv_change': 'N m s/rad', 'm1_change': 'kg m^2',
              'T_change': 's', 'kp_factor': '', 'kp_of_model': '', 'Ca': 'N m', 'moment': 'kg m',
              'moved': 'm'}
# Motions that separate effects which other motions confuse.
SEPARATES = {frozenset((name, rival)): motion for name, effect in EFFECTS.items()
             for rival, motion in effect.separated_by.items()}
# Motions that show an effect; all others are shown by the weight of the arm.
SHOWS = {MOTOR_COULOMB.id: 'move_alone', TORQUE_GAIN.id: 'move_fast',
         SERVO_GAIN.id: 'step_setpoint', MOTOR_INERTIA.id: 'accelerate',
         ARM_INERTIA.id: 'accelerate'}


def meaning(name: str, axis: str) -> str:
    """Return the meaning of the effect `name` on a drive with `axis`, '' for unknown ids."""
    return on_axis(MEANINGS.get(name, ''), axis)


def reading_unit(reading: str | None, axis: str) -> str:
    """Return the unit of a `reading` of Recording.readings at an `axis`."""
    return on_axis('N m' if reading == 'torque' else 'rad', axis)


def axis_of(data: VerdictData, joint: str | None = None) -> str:
    """Return rotary or prismatic: the axis of the drive, or of a `joint`, of a verdict `data`."""
    if 'axis' in data:
        return str(data['axis'])
    return next((gap.get('axis', 'rotary') for gap in data.get('gaps', ())
                 if gap['joint'] == joint), 'rotary')


def unit_of(effect: str, name: str, axis: str) -> str:
    """Return the unit of the value `name` of an effect at an `axis`, '' for a pure number."""
    known, of_robot = library().get(effect), OF_ROBOTS.get(effect)
    units = {p.name: p.unit for p in known.parameters} if known else dict(
        of_robot.units if of_robot else {})
    unit = OF_CHANGES.get(name) or units.get(name, '')
    return unit if of_robot and of_robot.place != JOINT else on_axis(unit, axis)


def subject_of(effect: str, values: Mapping[str, Any] | None = None) -> tuple[str, str]:
    """Return the one of `values` by which reports state an effect, None: of any, and its noun."""
    known, of_robot = library().get(effect), OF_ROBOTS.get(effect)
    names, noun = [], MEANINGS.get(effect, effect)
    if of_robot is not None:
        names, noun = [of_robot.subject[0] or next(iter(of_robot.units))], (
            of_robot.subject[1] or noun)
    elif known is not None:
        names, noun = [known.column.states] if known.column else [], known.noun or noun
        names += [known.parameters[0].name]
    return next((name for name in names if name and (values is None or name in values)),
                next(iter(values or ()), '')), noun


def size_unit(effect: str, axis: str) -> str:
    """Return the unit of the value by which a report states an effect at an `axis`."""
    return unit_of(effect, subject_of(effect)[0], axis)


def ids_of(data: Mapping[str, Any]) -> list[str]:
    """Return the ids of the effect in `data` (the JSON of a verdict)."""
    return data['effect'].split('+') if data.get('effect') else []


def counted(count: int, noun: str) -> str:
    """Return `count` with the `noun` in singular or plural."""
    plural = f'{noun}es' if noun.endswith('x') else f'{noun}s'
    return f'{count} {noun if count == 1 else plural}'


class AnswerWords(NamedTuple):
    """The answer about many: their noun, codes for none, for those that hold, for the others."""

    noun: str
    none: str
    well: str
    rest: str


GEARBOXES = AnswerWords('gearbox', 'no_gearbox', 'gearboxes_well', 'and_uncompared')
JOINTS = AnswerWords('joint', 'no_joint', 'joints_well', 'and_unjudged')


def answer(found: Sequence[str], levels: Sequence[object], words: AnswerWords) -> str:
    """
    Return the answer about many gearboxes or joints in one sentence.

    Args:
        found: what was found at each that is raised, in words, the worst first.
        levels: of all; None: not judged.
        words: by which to say it.
    """
    if found:
        more = (said('more_found', count=counted(len(found) - 1, f'more {words.noun}')),)
        return say('with_more', found=found[0].removesuffix('.'), more=more if found[1:] else ())
    judged = sum(level is not None for level in levels)
    if not judged:
        return say(words.none)
    rest = (said(words.rest, count=len(levels) - judged),) if judged < len(levels) else ()
    return say(words.well, count=counted(judged, words.noun), rest=rest)


def sentence(words: str) -> str:
    """Return `words` with a capital letter, unless an id comes first, and a full stop."""
    first = words[0] if '_' in words.split(' ')[0] else words[0].upper()
    return f'{first}{words[1:]}.'.replace('..', '.')


class ValueRow(NamedTuple):
    """
    One value of a finding: effect, name, size with its deviation.

    nominal: value of the model, '' where it has none; change: from it.
    """

    effect: str
    name: str
    size: Quantity
    nominal: str
    change: str

    def __str__(self) -> str:
        model = f' (model: {self.nominal}{", " * bool(self.change)}{self.change})'
        return f'{self.name} = {self.size}' + model * bool(self.nominal)


def value_rows(data: VerdictData) -> list[ValueRow]:
    """Return a ValueRow for each value of the findings of a verdict `data`; events have none."""
    rows = []
    for finding in data['findings']:
        effect, axis = finding['effect'], axis_of(data, finding.get('joint'))
        stated = (data.get('model_values') or {}).get(effect, {})
        for name, value in finding['values'].items() if effect not in EVENTS else ():
            nominal = stated.get(name)
            rows.append(ValueRow(
                effect, name, _sized(finding, name, unit_of(effect, name, axis)),
                '' if nominal is None else number(nominal),
                change(value, nominal) if nominal else ''))
    return rows


def gain_text(gains: Mapping[str, float], name: str) -> str:
    """Return the gain of `name` and, in brackets, its distance to the best of `gains`."""
    lag = max(gains.values()) - gains[name]
    return f'{gains[name]:.0f}' + (f' (-{lag:.0f})' if lag > 0.0 else '')


def undefined(data: VerdictData) -> str:
    """Return why the verdict `data` has no closed fraction."""
    ids = ids_of(data)
    if data['verdict'] in LACKING and (data.get('gap_before') or 0.0) > NEAR_FLOOR:
        return say('nothing_explains')
    if EVENTS & set(ids):
        return say('never_again', effect=DISTURBANCE.id if DISTURBANCE.id in ids else SLIP.id)
    return say('rounds' if _rounds(ids) else 'near_noise')


def _rounds(ids: Iterable[str]) -> bool:
    """Return whether one of the effects `ids` rounds readings."""
    return any(name in EFFECTS and EFFECTS[name].lattice for name in ids)


def torque_map_of(data: VerdictData) -> tuple[str, list[tuple[str, str, str]]] | None:
    """Return (words, [(where, torque, deviation)]) of the torque map in `data` of a verdict."""
    table = next((r['torque_map'] for r in data['remainders'] if r.get('torque_map')), None)
    if not table:
        return None
    rows = [(number(x), *Quantity(torque, deviation).digits()) for x, torque, deviation in zip(
        table['knots'], table['values'], table['deviations'])]
    return f'{PLACES[table["place"]]}, torque over {table["variable"]}', rows


# --- what is found ------------------------------------------------------------------------------
def place_of(found: Mapping[str, Any], data: VerdictData) -> str:
    """Return where what is `found` by a verdict `data` is: a joint, a link, a part of a drive."""
    if found.get('joint') or found.get('link'):
        return str(found.get('joint') or found['link'])
    if 'axis' in data:
        return PLACES.get(found['place'], 'a place that does not show')
    return 'all joints' if found.get('place') == 'controller' else 'base'


def _sized(finding: Mapping[str, Any], name: str, unit: str) -> Quantity:
    """Return the value `name` of a finding in a `unit`."""
    return credible(finding['values'][name], finding['deviations'].get(name), unit)


def finding_words(finding: Mapping[str, Any], data: VerdictData = NO_DATA) -> str:
    """Return one sentence, without a full stop, on a finding of the verdict `data`."""
    rivals = dict.fromkeys(filter(None, (
        _rival_of(finding, rival, data) for rival in finding.get('confusable') or ())))
    return _finding_words(finding, data) + (
        say('or_else', rivals=' or '.join(rivals)) if rivals else '')


def _rival_of(finding: Mapping[str, Any], rival: str, data: VerdictData) -> str:
    """Return the `rival` of a finding, effect (form)@place, in words; '' if both have one name."""
    name, _, place = rival.partition('@')
    effect, *form = name.split(' ', 1)
    noun, known = subject_of(effect)[1], library().get(effect)
    if effect == finding['effect'] and place:
        return f'at {place}'
    if noun == subject_of(finding['effect'], finding['values'])[1] and not form:
        place = PLACES[known.location] if known and 'axis' in data else place
        noun = noun if place else ''  # of a joint, both are one
    return ' '.join((noun, *form, *(['at ' + place] if place else []))).strip()


def _finding_words(finding: Mapping[str, Any], data: VerdictData) -> str:
    effect, values, place = finding['effect'], finding['values'], place_of(finding, data)
    axis = axis_of(data, finding.get('joint'))
    if effect in SENTENCES:
        return SENTENCES[effect](finding, data, place)
    name, noun = subject_of(effect, values)
    if not name:
        return say('acts', place=place, effect=effect)
    size = _sized(finding, name, unit_of(effect, name, axis))
    more = []
    if 'Ca' in values and name != 'Ca':
        more.append(Said('one_way', {'size': _sized(finding, 'Ca', on_axis('N m', axis))}))
    if 'N' in values:
        more.append(Said('turns', {'count': values['N']}))
    if 'q0' in values:
        more.append(Said('begins', {'size': number(values['q0'], on_axis('rad', axis))}))
    if finding.get('channel') and 'axis' not in data:
        more.append(Said('channel', {'channel': finding['channel']}))
    code = next((code for code in ('factor', 'change') if name.endswith(f'_{code}')), 'value')
    if 'kp_of_model' in values:
        more.append(Said('factor_of_model', {'size': _sized(finding, 'kp_of_model', '')}))
        code = 'factor_of_references'
    return say(code, place=place, noun=noun, size=size, more=tuple(more),
               nominal=_nominal(finding, data, name, size))


def _nominal(finding: Mapping[str, Any], data: VerdictData, name: str, size: Quantity
             ) -> tuple[Said, ...]:
    """Return the value of the model in place of the value `name` of a finding, of a `size`."""
    effect, values = finding['effect'], finding['values']
    if name.endswith('_change'):
        whole = values.get(name.removesuffix('_change'))
        model = None if whole is None else whole - values[name]
        code = 'whole'
    else:
        whole = values[name]
        model = data['model_values'].get(effect, {}).get(name, 0.0) if (
            'model_values' in data) else None
        code = 'not_model'
    if model is None or whole is None:
        return ()
    if not model or code == 'whole' and model <= 0.0:
        return Said('none_in_model'),
    if code == 'not_model' and effect in EFFECTS and EFFECTS[effect].adds_to:
        return Said('beyond_model', {'size': Quantity(model, unit=size.unit)}),
    return Said(code, {'size': size._replace(value=whole), 'change': change(whole, model),
                       'nominal': number(model, size.unit)}),


def _bursts(finding: Mapping[str, Any], data: VerdictData, place: str) -> str:
    """Return the sentence on bursts of torque at a `place`."""
    values, count = finding['values'], len(data.get('bursts') or ()) or 1
    axis = axis_of(data)
    return say('bursts', place=place, bursts=counted(count, 'burst'),
               torque=on_axis('torque', axis), time=number(values['t0'], 's'),
               size=number(values['amplitude'], on_axis('N m', axis)))


def _slips(finding: Mapping[str, Any], data: VerdictData, place: str) -> str:
    """Return the sentence on slips at a `place`."""
    count = len(data.get('slips') or ()) or 1
    size = Quantity(abs(finding['values']['Ds']), finding['deviations']['Ds'],
                    on_axis('rad', axis_of(data)))
    return say('slipped_n' if count > 1 else 'slipped_1', place=place, count=count, size=size,
               time=number(finding['values']['t0'], 's'))


def _load(finding: Mapping[str, Any], data: VerdictData, place: str) -> str:
    """Return the sentence on a payload at a `place`."""
    values, deviations = finding['values'], finding['deviations']
    if 'moved' in values:
        moved = deviations['moved']
        return say('load_moved', place=place, size=Quantity(
            100.0 * values['moved'], moved and 100.0 * moved, 'cm'))
    if 'moment' in values:
        return say('load_moment', place=place, size=_sized(finding, 'moment', 'kg m'))
    if deviations['m'] is None:
        return say('load_unknown', place=place)
    is_placed = None not in (deviations['cx'], deviations['cy'], deviations['cz'])
    reach = 100.0 * math.sqrt(sum(values[c] ** 2 for c in ('cx', 'cy', 'cz')))
    centre = Said('centre', {'size': f'{reach:.0f} cm'}) if is_placed else Said('no_centre')
    size = _sized(finding, 'm', 'kg')
    return say('load', place=place, size=size._replace(value=abs(values['m'])),
               side='more' if values['m'] >= 0.0 else 'less', centre=(centre,))


def _tilt(finding: Mapping[str, Any], data: VerdictData, place: str) -> str:
    """Return the sentence on the angle by which a finding tilts the base."""
    values, deviations = (np.array([finding[key][axis] for axis in ('ax', 'ay')], float)
                          for key in ('values', 'deviations'))
    angle = float(np.hypot(*values))
    deviation = float(np.hypot(*(values * deviations))) / angle if angle else math.inf
    return say('tilt', size=Quantity(math.degrees(angle), math.degrees(deviation), '°'))


# Effects with a sentence of their own.
SENTENCES: Mapping[str, Callable[[Mapping[str, Any], VerdictData, str], str]] = {
    DISTURBANCE.id: _bursts, SLIP.id: _slips, 'payload': _load, 'base_tilt': _tilt,
    'link_inertia': lambda finding, data, place: say('inertia', place=place)}


def remainder_words(remainder: Mapping[str, Any], data: VerdictData = NO_DATA) -> str:
    """Return a `remainder` of the verdict `data` in a sentence without a full stop."""
    place, over = place_of(remainder, data), remainder['over']
    unit = reading_unit(remainder['channel'] if 'axis' in data else 'torque',
                        axis_of(data, remainder.get('joint')))
    size = say('rms', size=number(remainder['size'], unit)) if remainder['size'] else say(
        'below_noise')
    if over == 'bursts':
        names = remainder.get('recordings') or [''] * len(remainder['times'])
        times = ', '.join(f'{begin:.0f} s' + (f' of {name}' if name else '')
                          for name, (begin, _) in list(zip(names, remainder['times']))[:4])
        return say('remains_bursts', place=place, size=size, times=times)
    if over == SERVO:
        return say('remains_servo', place=place, size=size)
    if over is not None:
        return say('remains', place=place, size=size, over=over)
    factor = () if 'excess' not in remainder else (
        Said('times_usual', {'factor': number(remainder['excess'] ** 0.5)}),)
    return say('remains_noise', place=place, size=size, factor=factor)


# --- the answer ---------------------------------------------------------------------------------
def headline(data: VerdictData) -> str:
    """Return the verdict `data` in words: differences, their sizes, and whether others remain."""
    if data.get('readings'):
        return say('read_so', readings='; '.join(data['readings']),
                   answer=headline({**data, 'readings': []}))
    verdict, findings = data['verdict'], data['findings']
    reference = 'the references' if data.get('references') else 'the model file'
    drifts = '; '.join(map(drift_words, data.get('drifts', ())))
    unexplained = _unseen(data) if data.get('not_judged') else ''
    remainder = '; '.join(filter(None, (
        *(remainder_words(r, data) for r in data['remainders'][:1]), unexplained, drifts)))
    if verdict == NONE:
        return _no_gap(data, reference)
    if verdict == UNDECIDED and drifts:
        return say('drift_alone', reference=reference, drifts=drifts)
    if verdict == UNDECIDED:
        return say('undecided', reference=reference, why=_unseen(data))
    if verdict == UNKNOWN:
        cause = (Said('unvisited' if data.get('unvisited') else 'no_effect'),)
        return say('differs', reference=reference, cause=cause, remainder=remainder)
    # Of a robot: joints at which the findings act, and tolerances or days allow the rest.
    open_joints = 'axis' not in data and any(
        gap['after'] > WHOLE * gap['before'] for gap in data.get('gaps', ())
        if gap.get('evidence', 0.0) > 0.0)
    code = ('found_part' if verdict != EFFECT or unexplained else 'found_drift' if drifts else
            'found_most' if open_joints else
            'found_all_1' if len(findings) == 1 else 'found_all_n')
    return say(code, findings='; '.join(_found(data)), remainder=remainder)


def _found(data: VerdictData) -> list[str]:
    """Return each finding in words, with one last entry for all values that the file omits."""
    unstated = unstated_in(data)
    words = [finding_words(f, data) for f in data['findings'] if f not in unstated]
    if unstated:
        nouns, joints = (list(dict.fromkeys(names)) for names in zip(*(
            (subject_of(f['effect'])[1], f['joint']) for f in unstated)))
        words.append(say('unstated', nouns=', '.join(nouns), joints='all joints' if len(
            joints) == len(data['gaps']) else ', '.join(joints)))
    return words


def _stated_size(finding: Mapping[str, Any], data: VerdictData) -> Quantity:
    """Return the value by which reports state a finding, with its unit."""
    name = subject_of(finding['effect'], finding['values'])[0]
    return _sized(finding, name, unit_of(finding['effect'], name, axis_of(data, finding['joint'])))


def unstated_in(data: VerdictData) -> list[Mapping[str, Any]]:
    """Return the findings on values that the file of a robot omits, by joint, if they are many."""
    out = [f for f in data['findings'] if any(
        name.endswith('_change') and f['values'].get(name.removesuffix('_change'), math.inf) <= x
        for name, x in f['values'].items())]
    joints = {f['joint'] for f in out}
    out += [f for f in data['findings'] if f['effect'] == STRIBECK.id and f.get(
        'joint') in joints]
    order = list(EFFECTS)
    return sorted(out, key=lambda f: (f['joint'], order.index(f['effect']))) if len(
        out) > FEW else []


def _no_gap(data: VerdictData, reference: str) -> str:
    """Return that nothing is found, and how much is left."""
    before, after = data.get('gap_before') or 0.0, data.get('gap_after') or 0.0
    code = ('small_residual' if after > NEAR_FLOOR else
            'within_tolerances' if before > NEAR_FLOOR else 'no_gap')
    if 'axis' in data:
        return say(code, reference=reference, most=(said('misfit_left', misfit=number(after)),))
    gap = max(data['gaps'], key=lambda g: g['before'])
    size = number(gap['before'], on_axis('N m', axis_of(data, gap['joint'])))
    return say(code, reference=reference,
               most=(said('largest_gap', place=gap['joint'], size=size),))


def drift_words(drift: Mapping[str, Any]) -> str:
    """
    Return a `drift` in words: how far friction of a joint is from the references.

    No friction is lower by more than 100 %: its form differs.
    """
    code = ('drift_above' if drift['change'] > 0.0 else
            'drift_below' if drift['change'] > -1.0 else 'drift_unlike')
    return say(code, place=drift['joint'],
               size=Quantity(100.0 * abs(drift['change']), 100.0 * drift['deviation'], '%'),
               usual=percent(drift['usual']))


def _unseen(data: VerdictData) -> str:
    """Return in words which changes the motion of an undecided verdict would not show."""
    if data.get('not_judged'):
        return say('not_explained', joints=', '.join(data['not_judged']))
    questions = data['questions']
    if not questions:
        return say('short_reference')
    first, count = questions[0], len(questions) - 1
    noun = subject_of(first['effect'])[1]
    below = '' if first['smallest'] is None else f' below {_size(first, "smallest", data)}'
    return say('not_shown', change=f'any {noun}{below}', place=_part(first['place']),
               more=f', and {counted(count, "more change")}' * bool(count))


def _size(question: Mapping[str, Any], key: str, data: VerdictData) -> str:
    axis = axis_of(data, question['joint'])
    return str(Quantity(question[key], None, size_unit(question['effect'], axis)))


def question_words(question: Mapping[str, Any], data: VerdictData = NO_DATA) -> str:
    """Return the motion that would answer a `question` of the verdict `data`."""
    motion = motion_words(question, axis_of(data, question['joint']))
    if question['rival']:
        return motion
    return say('would_show', motion=motion, noun=subject_of(question['effect'])[1],
               size=_size(question, 'plausible', data), place=_part(question['place']))


def next_steps(data: VerdictData) -> list[str]:
    """Return the next steps after a verdict `data`, with files and options of the user."""
    verdict, ids, is_drive = data['verdict'], set(ids_of(data)), 'axis' in data
    asked = [(q, question_words(q, data)) for q in data.get('questions', ())]
    steps = []
    if data.get('unvisited'):
        steps.append(say('learn_more', references=shlex.join(data['references']),
                         model=_model(data)))
    if verdict == NONE:
        steps.append(say('nothing_to_do') if is_drive or data['references'] else say(
            'compare_healthy', command=_command(data, '--reference HEALTHY')))
    steps += [words for q, words in asked if q['rival']]
    if data.get('drifts'):
        steps.append(say('record_warm', joint=data['drifts'][0]['joint']))
    if verdict == UNDECIDED:
        steps += [words for _, words in asked[:2]]
    steps += [say(code) for ours, code in (
        (SLIP.id in ids, 'check_clutch'), (DISTURBANCE.id in ids, 'look_for_contacts'),
        (_rounds(ids), 'read_finer')) if ours]
    if data['findings'] and not ids & EVENTS and not _rounds(ids):
        steps += _closing_steps(data, is_drive)
    if data['remainders']:
        first = data['remainders'][0]
        steps.append(say('state_servo' if first['over'] == SERVO else 'look_at_place',
                         joint=place_of(first, data)))
    return steps


def _model(data: VerdictData) -> str:
    return ' '.join(filter(None, (shlex.quote(data['model']), data['options'])))


def _command(data: VerdictData, more: str) -> str:
    """Return the diagnosis of the user as a command, with `more` options."""
    return f'gearbox_monitor diagnose {shlex.join(data["logs"])} --model {_model(data)} {more}'


def _closing_steps(data: VerdictData, is_drive: bool) -> Iterator[str]:
    """Yield what to do with the model that closes the gap."""
    closed = data.get('closed')
    if closed:
        yield say('simulate', file=closed)
    elif is_drive:
        yield say('write_closed', command=_command(data, '--out DIR'))
    if closed and is_drive and 'kp' not in (data.get('nominal') or {}):
        robot = data['model'] if data['joint'] else 'ROBOT.xml'  # else no torque to fit
        target = 'urdf' if Path(robot).suffix.lower() == '.urdf' else 'mjcf'
        yield say('export', command=f'gearbox_monitor export {shlex.quote(closed)} --to {target} '
                  f'--into {shlex.quote(robot)} {data["joint"] or "--joint NAME"}')
    if is_drive and not data.get('validation'):
        yield say('test_elsewhere', command=_command(data, '--validate BAG2'))


def motion_words(question: Mapping[str, Any], axis: str) -> str:
    """
    Return the motion that a question of a verdict asks for, and its expected evidence.

    Args:
        question: as JSON has it.
        axis: of its joint.
    """
    joint, effect, rival = question['joint'], question['effect'], question['rival']
    speed, evidence = max(question['speed'], 0.1), question['evidence']
    slow, fast = (on_axis(f'{factor * speed:.2g} rad/s', axis) for factor in (0.2, 2.0))
    how = say(SHOWS.get(effect, 'move_carriers'), joint=joint, place=_part(question['place']))
    if rival:
        name, _, other = rival.partition('@')
        apart = SEPARATES.get(frozenset((effect, name)), '')
        code = ('no_motion' if apart.startswith('no ') else 'distinguish' if apart else
                'distinguish_joints' if other else 'distinguish_loaded')
        if name in OF_ROBOTS and OF_ROBOTS[name].place == LINK:
            other = f'the joint of {other}'
        how = say(code, effect=effect, rival=rival.replace('@', ' at '), joint=joint,
                  other=other, why=apart, motion=on_axis(apart, axis))
        if code == 'no_motion':
            return how
    more = () if evidence is None else (said('evidence', evidence=evidence),)
    return say('at_speed', how=how, slow=slow, fast=fast, seconds=question['seconds'],
               evidence=more)


def change_sentence(verdict: Mapping[str, Any]) -> str:
    """Return a verdict on a change, as ChangeVerdict.to_dict has it, in one sentence."""
    kind, remainder = verdict['verdict'], verdict.get('remainder')
    code = {NONE: 'no_cause', UNKNOWN: 'unknown_cause', INCOMPLETE: 'part_of_cause'}
    return say(code.get(kind, 'cause'), findings='; '.join(map(_changed, verdict['findings'])),
               place=remainder and _part(remainder), model=model_words(verdict))


def model_words(verdict: Mapping[str, Any]) -> str:
    """Return whether the model file holds by `verdict`, in words."""
    if verdict['model_holds'] or verdict['model_held']:
        return say('model_holds' if verdict['model_holds'] else 'model_no_longer')
    missed = ' and '.join(verdict['effects_before'])
    return say('model_never', missed=(said('missed_effects', effects=missed),) if missed else ())


def _changed(finding: Mapping[str, Any]) -> str:
    """Return what changed in one finding: the value by which reports state it, before and now."""
    values = {value['name']: value for value in finding['values']}
    name, noun = subject_of(finding['effect'], values)
    value = values[name]
    known = value['relative'] is not None
    return say('changed', place=_part(finding['place']), noun=noun,
               before=number(value['before']), now=number(value['now'], value['unit']) if known
               else Quantity(value['now'], value['std'], value['unit']),
               change=(said('by_share', size=percent(value['relative'], value['relative_std'])),)
               if known else ())


def _part(location: str) -> str:
    return PLACES.get(location, location)


# --- the lines for people -----------------------------------------------------------------------
Rows = Iterator[Said]  # of a line, whose label is the name of the code
LABEL = 15
FEW = 4     # joints whose gaps are printed
RANKED = 8  # lines of the ranking
NEXT = 1    # steps that are printed without -v


def verdict_text(data: VerdictData, verbose: bool = False) -> str:
    """
    Return a verdict as lines for people, at most 80 columns.

    Args:
        data: the verdict as plain data.
        verbose: whether all that is known is printed, not only answer, values and next step.
    """
    says = chain(_gap_rows(data), _value_rows(data), _details(data) if verbose else (),
                 _simulator(data), _validation(data), _run_rows(data))
    notes, changes = list(data['warnings']), list(data.get('changes') or ())
    if not verbose:
        notes = [f'{notes[0]} (-v prints {counted(len(notes) - 1, "more note")})'
                 ] if len(notes) > 1 else notes
        changes = [f'{counted(len(changes), "line")} of {Path(data["model"]).name}: -v prints them'
                   ] if changes else changes
    rows = [*labelled(says, axis_of(data)), *(('note', note) for note in notes),
            *(('' if k else 'change', row) for k, row in enumerate(changes)),
            *(('', f'not in it: {words}') for words in data.get('lacking') or ()),
            *(('next', step) for step in next_steps(data)[:None if verbose else NEXT])]
    return '\n'.join([*wrapped(data['summary']), *entries(rows, LABEL)])


def _gap_rows(data: VerdictData) -> Rows:
    """Yield the lines on the gap before and after: of a drive, or of the first joints."""
    if 'axis' in data:
        share, closed = data['closed_fraction'], tuple[Said, ...]()
        if data['verdict'] not in NOTHING:
            closed = (said('closed_undefined', why=undefined(data)) if share is None else
                      said('closed_share', share=percent(share)),)
        yield said('misfit_row', before=number(data['gap_before']),
                   after=number(data['gap_after']), closed=closed)
        return
    for remainder in data['remainders'][0 if data['verdict'] == NONE else 1:]:
        yield said('remains_row', remains=remainder_words(remainder, data))
    for code, gaps in (('joints_row', data['gaps']), ('servo_row', data['servos'])):
        if gaps:
            yield said(code, gaps=', '.join(
                f'{g["joint"]} {number(g["before"])} to '
                f'{number(g["after"], on_axis("N m", axis_of(data, g["joint"])))}'
                for g in gaps[:FEW]))


def _value_rows(data: VerdictData) -> Rows:
    axis = axis_of(data)
    for row in value_rows(data) if 'axis' in data else ():   # the answer has those of a robot
        yield said('value_row', effect=row.effect, value=row)
    for joint, findings in groupby(unstated_in(data), key=lambda f: str(f['joint'])):
        yield said('unstated_row', joint=joint, values=', '.join(
            f"{subject_of(f['effect'])[1]} {_stated_size(f, data)}" for f in findings))
    for name, ranges in (data.get('between_recordings') or {}).items():
        for parameter, part in ranges.items():
            yield said('between_row', name=name, parameter=parameter,
                       count=len(part['recordings']), **{key: number(part[key]) for key in (
                           'mean', 'low', 'high', 'between')})
    for burst in data.get('bursts') or ():
        yield said('burst_row', begin=burst['t0'], end=burst['t0'] + burst['duration'],
                   size=number(burst['amplitude'], on_axis('N m', axis)))
    for slip in data.get('slips') or ():
        yield said('slip_row', begin=slip['t0'],
                   size=Quantity(slip['size'], slip['std'], on_axis('rad', axis)))
    for words in data.get('equivalent') or ():
        yield said('same_row', words=words)
    torque_map = torque_map_of(data)
    if torque_map is not None:
        place, knots = torque_map
        yield said('torque_map_row', place=place, unit=on_axis('N m', axis), knots=', '.join(
            f'{x}: {torque} ± {error}' for x, torque, error in knots))


def _details(data: VerdictData) -> Rows:
    """Yield the ranking of the effects, the values estimated along, the smallest sizes shown."""
    gains: Mapping[str, float] = data.get('gains') or {}
    ranking = sorted(gains, key=lambda name: gains[name], reverse=True)[:RANKED]
    for place, name in enumerate(ranking, 1):
        yield said('ranking_row', place=place, name=name, gain=gains[name])
    if ranking:
        yield said('gain_row')
    shifts = data.get('nominal_shift')
    if shifts:
        yield said('nominal_row', values=', '.join(
            f'{name} {number(data["nominal"][name])} ({shift:+.1f})'
            for name, shift in shifts.items()))
    if shifts and data['process_torque'] is not None:
        yield said('noise_row', noise=number(
            data['process_torque'], on_axis('N m', axis_of(data))))


def _closed(code: str, name: str, part: Mapping[str, Any]) -> Said:
    return said(code, name=name, before=number(part.get('gap_before')),
                after=number(part.get('gap_after')), share=percent(part.get('closed_fraction')))


def _simulator(data: VerdictData) -> Rows:
    theirs = data.get('simulator')
    if not theirs:
        return
    yield _closed('simulator_row', theirs['name'], theirs)
    yield _closed('simulator_row', 'this package', theirs['here'])
    if theirs['passed']:
        yield said('passed_row', effects=', '.join(
            f'{name} as {way}' for name, way in theirs['passed'].items()))
    if theirs['values']:
        yield said('values_row', values=', '.join(
            f'{name} {key} = {Quantity(value, deviation)}'
            for name, values in theirs['values'].items()
            for key, (value, deviation) in values.items()))


def _validation(data: VerdictData) -> Rows:
    result = data.get('validation')
    if not result:
        return
    yield _closed('validation_row', result['recording'], result)
    if run := result.get('free_run'):
        yield said('free_run_row', seconds=run['seconds'], units=', '.join(dict.fromkeys(
            reading_unit(name, axis_of(data)) for name in run['before'])), **{when: ', '.join(
                f'{name} {number(value)}' for name, value in run[when].items())
                for when in ('before', 'after')})


def _run_rows(data: VerdictData) -> Rows:
    """Yield the lines of a robot on free runs, and on sizes that its motion would have shown."""
    runs = (data.get('rollouts') or {}).get('joints') or {}
    if runs:
        yield said('runs_row', runs=', '.join(
            f'{j} {number(1e3 * v["before"])} to '
            f'{number(1e3 * v["after"], on_axis("mrad", axis_of(data, j)))}'
            for j, v in runs.items()))
    if data['verdict'] not in (NONE, UNKNOWN, UNDECIDED) or 'visible' not in data:
        return
    sizes = []
    for effect in ('payload', MOTOR_COULOMB.id, TORQUE_GAIN.id):
        places = data['visible'].get(effect)
        if places:
            # What a motion shows at its worst joint; a load at the link that shows it best.
            worst = min if effect == 'payload' else max
            place, size = worst(places.items(), key=lambda item: item[1])
            unit = size_unit(effect, axis_of(data, place))
            sizes.append(f'{effect} of {Quantity(size, None, unit)} at {place}')
    if sizes:
        yield said('visible_row', sizes=', '.join(sizes))
