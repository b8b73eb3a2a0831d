# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a diagnosis and a watch of a robot say: words for terminals and pages, data for JSON."""
from collections.abc import Mapping, Sequence
import math
import shlex
from types import MappingProxyType
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.hypothesis import UNDECIDED
from gearbox_monitor.diagnosis.robot.conventions import NamedReading, RobotReading
from gearbox_monitor.diagnosis.robot.robot_effects import BASE_TILT, JOINT, ROBOT_EFFECTS
from gearbox_monitor.diagnosis.robot.servo import SERVO
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.motor_side import COGGING, MOTOR_COULOMB, MOTOR_INERTIA
from gearbox_monitor.presentation import change, credible, number, on_axis, percent, Quantity, Said
from gearbox_monitor.report.sentences import say, TABLE
from gearbox_monitor.report.words import answer, counted, JOINTS, motion_words, sentence
from gearbox_monitor.watch.record import (
    Change, DESCRIBE, FRICTION, HeldLoad, JointWatch, LEARN, RIPPLE, ROTOR, SCALE, StateHealth,
    TILT, WATCH, Watch, WEIGHT)

OF_CHANGES = {'Cc_change': 'N m', 'Cv_change': 'N m s/rad', 'm1_change': 'kg m^2',
              'T_change': 's', 'kp_factor': '', 'kp_of_model': '', 'Ca': 'N m', 'moment': 'kg m',
              'moved': 'm'}
UNITS = {**{e.id: {p.name: p.unit for p in e.parameters} for e in EFFECTS.values()},
         **{e.id: dict(e.units) for e in ROBOT_EFFECTS}}
ALL_ROTARY: Mapping[str, str] = MappingProxyType({})
ON_BODIES = {e.id for e in ROBOT_EFFECTS if e.place != JOINT}
MEANINGS = {**{e.id: e.meaning for e in EFFECTS.values()},
            **{e.id: e.meaning for e in ROBOT_EFFECTS}}
# The value by which a report states an effect, and its name.
SUBJECTS = {**{e.id: (e.column.states or e.parameters[0].name, e.noun)
               for e in EFFECTS.values() if e.column is not None},
            **{e.id: e.subject for e in ROBOT_EFFECTS if e.subject[0]}}


def axes_of(data: Mapping[str, Any]) -> dict[str, str]:
    """Return {joint: rotary or prismatic} of a verdict's data."""
    return {gap['joint']: gap.get('axis', 'rotary') for gap in data.get('ranked', ())}


def unit_of(effect: str, name: str, axis: str) -> str:
    """Return the unit of the value `name` of an effect at an `axis`, '' for a pure number."""
    unit = OF_CHANGES.get(name) or UNITS.get(effect, {}).get(name, '')
    return unit if effect in ON_BODIES else on_axis(unit, axis)


def size_unit(effect: str, axis: str) -> str:
    """Return the unit of the value by which a report states an effect at an `axis`."""
    first = {'payload': 'm', 'base_tilt': 'ax', 'link_inertia': 'Ixx'}.get(
        effect) or SUBJECTS.get(effect, ('', ''))[0]
    return unit_of(effect, first, axis)


def finding_words(finding: Mapping[str, Any], axes: Mapping[str, str] = ALL_ROTARY) -> str:
    """Return one sentence, without a full stop, on a finding; `axes`: of the joints."""
    axis = axes.get(finding.get('joint') or '', 'rotary')
    place = finding.get('joint') or (
        'all joints' if finding.get('place') == 'controller' else finding.get('link') or 'base')
    effect, values = finding['effect'], finding['values']
    if effect == 'payload':
        return _load(finding, place)
    if effect == 'base_tilt':
        return say('tilt', size=_tilt(finding))
    if effect == 'link_inertia':
        return say('inertia', place=place)
    name, noun = SUBJECTS.get(effect, (next(iter(values)), MEANINGS.get(effect, effect)))
    size = _sized(finding, name, unit_of(effect, name, axis))
    more, nominal = [], list[Said]()
    if 'Ca' in values and name != 'Ca':
        more.append(Said('one_way', {'size': _sized(finding, 'Ca', on_axis('N m', axis))}))
    if 'N' in values:
        more.append(Said('turns', {'count': values['N']}))
    if 'q0' in values:
        more.append(Said('begins', {'size': number(values['q0'], on_axis('rad', axis))}))
    if finding.get('channel'):
        more.append(Said('channel', {'channel': finding['channel']}))
    whole = values.get(name.removesuffix('_change'))
    if name.endswith('_change') and whole is not None:
        model = whole - values[name]
        nominal.append(Said('none_in_model') if model <= 0.0 else Said('whole', {
            'size': size._replace(value=whole), 'nominal': number(model, size.unit),
            'change': change(whole, model)}))
    code = next((code for code in ('factor', 'change') if name.endswith(f'_{code}')), 'value')
    if 'kp_of_model' in values:
        more.append(Said('factor_of_model', {'size': _sized(finding, 'kp_of_model', '')}))
        code = 'factor_of_references'
    return say(code, place=place, noun=noun, size=size, nominal=tuple(nominal), more=tuple(more))


def _load(finding: Mapping[str, Any], place: str) -> str:
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


def _sized(finding: Mapping[str, Any], name: str, unit: str) -> Quantity:
    """Return the value `name` of a finding in a `unit`."""
    return credible(finding['values'][name], finding['deviations'][name], unit)


def _tilt(finding: Mapping[str, Any]) -> Quantity:
    """Return the angle by which a finding tilts the base."""
    values, deviations = (np.array([finding[key][axis] for axis in ('ax', 'ay')], float)
                          for key in ('values', 'deviations'))
    angle = float(np.hypot(*values))
    deviation = float(np.hypot(*(values * deviations))) / angle if angle else math.inf
    return Quantity(math.degrees(angle), math.degrees(deviation), '°')


def remainder_words(remainder: Mapping[str, Any], axes: Mapping[str, str]) -> str:
    """Return a `remainder` in a sentence without a full stop; `axes`: of the joints."""
    place, over = remainder['joint'], remainder['over']
    size = number(remainder['size'], on_axis('N m', axes.get(place, 'rotary')))
    if over == 'bursts':
        names = remainder.get('recordings') or [''] * len(remainder['times'])
        times = ', '.join(f'{begin:.0f} s' + (f' of {name}' if name else '')
                          for name, (begin, _) in list(zip(names, remainder['times']))[:4])
        return say('remains_bursts', place=place, size=size, times=times)
    if over == SERVO:
        return say('remains_servo', place=place, size=size)
    if over is None:
        return say('remains_noise', place=place, size=size,
                   factor=number(remainder['excess'] ** 0.5))
    return say('remains', place=place, size=size, over=over)


def reading_words(named: NamedReading, joints: Sequence[str]) -> str:
    """Return how a log of `joints` has to be read, with the option that says so."""
    reading = named.reading
    options = ' or '.join(_option(r, joints) for r in (reading, *named.rivals))
    changed = list(reading.swapped or reading.joints)
    names = [joints[j] for j in changed]
    recorded, left = (percent(math.sqrt(float(np.mean(score.unexplained[changed]))))
                      for score in (named.recorded, named.score))
    convention = None if reading.swapped else next(iter(reading.joints.values()))
    where = ('all joints' if len(names) > 1 and len(names) == len(joints) else
             (' and ' if reading.swapped else ', ').join(names))
    sign: tuple[Said, ...] = ()
    if convention is None:
        code = 'exchanged'
    elif convention.rules in TABLE:
        code = convention.rules
    else:
        code = 'zero' if convention.zero else 'effort_factor'
        sign = (Said('other_sign'),) if convention.effort < 0.0 else ()
    return say(code, place=where, recorded=recorded, left=left, options=options, sign=sign,
               zero=convention.zero if convention else 0.0,
               factor=1.0 / abs(convention.effort) if convention else 1.0)


def _option(reading: RobotReading, joints: Sequence[str]) -> str:
    """Return the option of a command that has a log of `joints` read so."""
    if reading.swapped:
        first, second = (joints[j] for j in reading.swapped)
        return f'--recorded {first}={second} {second}={first}'
    (joint, *others), convention = reading.joints, next(iter(reading.joints.values()))
    return f'--convention {"all" if others else joints[joint]}={convention.rules}'


def robot_headline(data: Mapping[str, Any]) -> str:
    """Return the verdict `data` in words: differences, their sizes, and whether others remain."""
    if data.get('readings'):
        return say('read_so', readings='; '.join(data['readings']),
                   answer=robot_headline({**data, 'readings': []}))
    axes, verdict = axes_of(data), data['verdict']
    reference = 'the references' if data.get('references') else 'the model file'
    remainder = remainder_words(data['remainders'][0], axes) if data['remainders'] else ''
    if verdict == 'none':
        gap = max(data['ranked'], key=lambda g: g['before'])
        return say('as_said', reference=f'{reference} say{"s" * (not data.get("references"))}',
                   place=gap['joint'],
                   size=number(gap['before'], on_axis('N m', axes[gap['joint']])))
    if verdict == UNDECIDED and data['drifts']:
        return say('drift_alone', reference=reference,
                   drifts='; '.join(map(drift_words, data['drifts'])))
    if verdict == UNDECIDED:
        return say('undecided', reference=reference, why=_unseen(data))
    if verdict == 'unknown':
        cause = (Said('unvisited' if data['unvisited'] else 'no_effect'),)
        return say('differs', reference=reference, cause=cause, remainder=remainder)
    findings = '; '.join(finding_words(f, axes) for f in data['findings'])
    code = ('found_part' if verdict != 'effect' else
            'found_all_1' if len(data['findings']) == 1 else 'found_all_n')
    return say(code, findings=findings, remainder=remainder)


def drift_words(drift: Mapping[str, Any]) -> str:
    """Return how far friction of a joint is from the references, without a full stop."""
    return say('drift_above' if drift['change'] > 0.0 else 'drift_below', place=drift['joint'],
               size=Quantity(100.0 * abs(drift['change']), 100.0 * drift['deviation'], '%'),
               usual=percent(drift['usual']))


def _unseen(data: Mapping[str, Any]) -> str:
    """Return in words which changes the motion of an undecided verdict would not show."""
    if data['not_judged']:
        return say('not_explained', joints=', '.join(data['not_judged']))
    questions = data['questions']
    if not questions:
        return say('short_reference')
    first, count = questions[0], len(questions) - 1
    change_words = (f'any {_named(first["effect"])}' if first['smallest'] is None else
                    f'{_named(first["effect"])} below {_size(first, "smallest", axes_of(data))}')
    return say('not_shown', change=change_words, place=first['place'],
               more=f', and {counted(count, "more change")}' * bool(count))


def _named(effect: str) -> str:
    return SUBJECTS.get(effect, ('', effect))[1]


def _size(question: Mapping[str, Any], key: str, axes: Mapping[str, str]) -> str:
    axis = axes.get(question['joint'], 'rotary')
    return str(Quantity(question[key], None, size_unit(question['effect'], axis)))


def question_words(question: Mapping[str, Any], axes: Mapping[str, str]) -> str:
    """Return the motion that would answer a `question` of a verdict; `axes`: of the joints."""
    motion = motion_words(question, axes.get(question['joint'], 'rotary'))
    if question['rival']:
        return motion
    return say('would_show_at', motion=motion, noun=_named(question['effect']),
               size=_size(question, 'plausible', axes), place=question['place'])


def next_steps(data: Mapping[str, Any]) -> list[str]:
    """Return the next steps after the verdict `data`, with its own file names."""
    logs = shlex.join(data['logs'])
    model = ' '.join(filter(None, (shlex.quote(data['model']), data['options'])))
    steps = []
    if data['unvisited']:
        steps.append(say('learn_more', references=shlex.join(data['references']), model=model))
    if data['verdict'] == 'none' and not data.get('references'):
        steps.append(say('compare_healthy', logs=logs, model=model))
    steps += [question_words(q, axes_of(data)) for q in data['questions'] if q['rival']]
    if data['drifts']:
        steps.append(say('record_warm', joint=data['drifts'][0]['joint']))
    if data['verdict'] == UNDECIDED:
        steps += [question_words(q, axes_of(data)) for q in data['questions'][:2]]
    if data['findings'] and data.get('closed'):
        steps.append(say('use_closed', file=data['closed']))
    if data['remainders']:
        first = data['remainders'][0]
        steps.append(say('state_servo' if first['over'] == SERVO else 'look_at_joint',
                         joint=first['joint']))
    return steps


def _gaps(gaps: Sequence[Mapping[str, Any]], axes: Mapping[str, str]) -> str:
    """Return the first `gaps` of joints in words; `axes`: of all joints."""
    return ', '.join(f'{g["joint"]} {number(g["before"])} -> '
                     f'{number(g["after"], on_axis("N m", axes[g["joint"]]))}' for g in gaps[:4])


def robot_text(data: Mapping[str, Any]) -> str:
    """Return the verdict `data` in some ten lines."""
    lines, axes = [data['summary']], axes_of(data)
    lines += [f'  remains: {remainder_words(r, axes)}' for r in data['remainders'][
        0 if data['verdict'] == 'none' else 1:]]
    lines.append(f'gap of the torque, rms before -> after: {_gaps(data["ranked"], axes)}')
    if data.get('servos'):
        lines.append(f'gap of the servos, rms before -> after: {_gaps(data["servos"], axes)}')
    runs = (data.get('rollouts') or {}).get('joints') or {}
    if runs:
        lines.append('MuJoCo after 0.5 s, rms error with the file -> with the closed one: '
                     + ', '.join(f'{j} {number(1e3 * v["before"])} -> '
                                 + number(1e3 * v['after'], on_axis('mrad', axes[j]))
                                 for j, v in runs.items()))
    lines += [f'not in the closed file: {words}' for words in data.get('lacking') or ()]
    if data['verdict'] in ('none', 'unknown', UNDECIDED):
        sizes = []
        for effect in ('payload', MOTOR_COULOMB.id, TORQUE_GAIN.id):
            places = data['visible'].get(effect)
            if places:
                # What a motion shows at its worst joint; a load at the link that shows it best.
                worst = min if effect == 'payload' else max
                place, size = worst(places.items(), key=lambda item: item[1])
                size = Quantity(size, None, size_unit(effect, axes.get(place, 'rotary')))
                sizes.append(f'{effect} of {size} at {place}')
        if sizes:
            lines.append(f'would have been seen, from: {", ".join(sizes)}')
    lines += [f'caution: {drift_words(d)}' for d in data['drifts']
              if data['verdict'] != UNDECIDED]
    lines += [f'caution: {c}' for c in data['cautions'][:3]]
    lines += [f'note: {n}' for n in data['warnings'][:3]]
    lines += [f'next: {s}' for s in next_steps(data)[:2]]
    return '\n'.join(lines)


NOUNS = {FRICTION: 'friction', SCALE: 'torque scale', ROTOR: 'inertia at the rotor',
         WEIGHT: 'weight', RIPPLE: 'ripple', TILT: 'tilt'}
# The effect of the library that a state measures.
EFFECT_OF = {FRICTION: MOTOR_COULOMB.id, SCALE: TORQUE_GAIN.id, ROTOR: MOTOR_INERTIA.id,
             WEIGHT: 'payload', RIPPLE: COGGING.id, TILT: BASE_TILT.id}
# Columns of the states of a joint, and what the page says.
STATE_TITLES = {FRICTION: 'friction %', SCALE: 'torque scale %', ROTOR: 'rotor %',
                WEIGHT: 'weight %'}
NOT_JUDGED, NO_CHANGE = 'not judged', 'No change so far.'
GRAVITY = 9.81
FINEST = 0.002  # smallest deviation of a share that is stated: no model of a robot is truer


def share_words(state: Change | StateHealth) -> str:
    """Return the size of a state or a change with its deviation, as a table has it."""
    if state.kind == TILT:
        factor = 180.0 / math.pi / GRAVITY
        return str(Quantity(factor * abs(state.size), factor * state.std, '°'))
    std = max(state.std, FINEST)
    if state.kind == RIPPLE:
        return str(percent(abs(state.size), std))
    return f'{percent(state.size, std):+}'


def size_words(state: Change | StateHealth) -> str:
    """Return the size of a state or a change with its deviation, and of which quantity."""
    return share_words(state) + {RIPPLE: ' of the effort', ROTOR: " of the joint's"}.get(
        state.kind, '')


def change_label(change: Change) -> str:
    """Return a change as a picture has it at its joint."""
    return f'{NOUNS[change.kind]} {size_words(change)}'


def change_words(change: Change) -> str:
    """Return a change in one sentence without a full stop."""
    order = f' ({change.order} per turn)' if change.order else ''
    over = f', over {when(change.over_ns)}' if change.over_ns else ''
    if change.rival:
        kind, place = change.rival
        over = (f', or {NOUNS[kind]}' if kind != change.kind else '') + (
            f', or at {place}' if place != change.place else '') + over
    label = since_words(f'{change_label(change)}{order}', change.since_ns)
    return f'{change.place}: {label}{over}'


def since_words(label: str, since_ns: int) -> str:
    """Return the `label` of a change with when it began."""
    return f'{label} since {when(since_ns)}'


def payload_words(payload: HeldLoad) -> str:
    """Return a `payload` in words, relative to the load at the time of learning."""
    if not abs(payload.mass) > 2.0 * payload.mass_std:
        return (f'{payload.link}: no load beyond '
                f'{number(abs(payload.mass) + 2.0 * payload.mass_std, "kg")}')
    out = f'{Quantity(payload.mass, payload.mass_std, "kg")} at {payload.link}'
    reach = math.hypot(*payload.centre)
    return out + (f', centre {100.0 * reach:.0f} cm out' if math.isfinite(reach) else '')


def payload_label(payload: HeldLoad) -> str:
    """Return a `payload` as a picture has it at its joint; nothing if none is sure."""
    sure = abs(payload.mass) > 2.0 * payload.mass_std
    return f'{Quantity(payload.mass, payload.mass_std, "kg"):+}' if sure else ''


def watch_headline(watch: Watch) -> str:
    """Return what the watch knows in one sentence: the worst first."""
    if watch.phase == DESCRIBE and watch.others and not any(j.has for j in watch.joints):
        return (f'joint_states has no joint of the description: it names '
                f'{", ".join(watch.others)}, the description '
                f'{", ".join(j.name for j in watch.joints)}.')
    if watch.phase == DESCRIBE:
        return f'Waiting for a minute of motion{": " * bool(watch.notes)}{"".join(watch.notes)}.'
    if watch.phase == LEARN:
        still = [j.name for j in watch.joints if j.name not in watch.locked and j.moved < 1.0]
        waits = f'; {", ".join(still)} has not moved yet' if still else ''
        return f'Learning the robot: {counted(len(watch.kept), "block")} of 20 s so far{waits}.'
    found = [c for c in watch.standing if c.found_ns]
    if found:
        return '; '.join(change_words(c) for c in found) + '.'
    return answer((), [j.level for j in watch.joints], JOINTS)


def watch_text(watch: Watch) -> str:
    """Return the watch in some lines, the answer first."""
    lines = [watch_headline(watch)]
    lines += [f'  {words}' for words in (*watch.doubts, *watch.notes, *readings_of(watch))]
    if watch.phase == WATCH:
        lines += [f'  {payload_words(p)}' for p in watch.payloads]
        lines += [f'  earlier: {change_words(c)}' for c in watch.changes if c.over_ns][-3:]
        for joint in watch.joints:
            own = ', '.join(f'{NOUNS[s.kind]} {size_words(s)}' for s in joint.states if s.judged)
            lines.append(f'  {joint.name}: ' + (f'not judged: {joint.why}' if joint.level is None
                                                else own))
    return '\n'.join(lines[:20])


def problem_words(problem: str) -> str:
    """Return a `problem` of the stream as a sentence; nothing is known without one."""
    return sentence(problem or 'the watch starts')


def services_words(node: str) -> list[tuple[str, str]]:
    """Return the services of the watch `node`, and what each is for."""
    return [(f'{node}/save_baseline', 'takes this as healthy'),
            (f'{node}/tare', 'takes the load as 0'), (f'{node}/learn_again', 'forgets the robot')]


def readings_of(watch: Watch) -> list[str]:
    """Return the conventions by which a `watch` reads its stream, in words."""
    names = [j.name for j in watch.joints if j.name not in watch.locked]
    return [reading_words(named, names) for named in watch.readings]


def watch_data(watch: Watch) -> dict[str, Any]:
    """Return the watch as plain data, with the keys of a diagnosis of a robot."""
    found = [c for c in watch.standing if c.found_ns]
    silent = [j.name for j in watch.joints if j.level is None]
    return {
        'summary': watch_headline(watch), 'phase': watch.phase, 'stamp_ns': watch.stamp_ns,
        'verdict': 'effect' if found else 'none' if watch.level is not None else 'undecided',
        'findings': [_finding(c) for c in found], 'remainder': None, 'remainders': [],
        'not_judged': silent, 'cautions': [*watch.doubts, *watch.notes],
        'readings': readings_of(watch),
        'level': None if watch.level is None else int(watch.level),
        'joints': {j.name: {
            'level': None if j.level is None else int(j.level), 'words': _joint_words(j),
            'rate_hz': j.rate, 'has': list(j.has), 'moved_s': j.moved,
            'position': _finite([j.position])[0],
            'states': _states(j.states)} for j in watch.joints},
        'tilt': None if watch.tilt is None else _states([watch.tilt])[TILT],
        'payloads': [_held(p) for p in watch.payloads],
        'earlier': [_held(p) for p in watch.earlier],
        'changes': [_finding(c) for c in watch.changes if c.found_ns],
        'others': list(watch.others)}


def _finding(change: Change) -> dict[str, Any]:
    return {'effect': EFFECT_OF[change.kind], 'state': change.kind,
            'joint': None if change.kind == TILT else change.place,
            'link': change.place if change.kind == TILT else None,
            'values': {'relative': change.size}, 'deviations': {'relative': change.std},
            'since_ns': change.since_ns, 'found_ns': change.found_ns, 'over_ns': change.over_ns,
            'words': change_words(change), 'label': change_label(change),
            'share': share_words(change)}


def _held(load: HeldLoad) -> dict[str, Any]:
    return {'link': load.link, 'm': load.mass, 'm_std': load.mass_std,
            'centre': _finite(load.centre), 'centre_std': _finite(load.centre_std),
            'since_ns': load.since_ns, 'over_ns': load.over_ns, 'words': payload_words(load),
            'label': payload_label(load)}


def _states(states: Sequence[StateHealth]) -> dict[str, Any]:
    return {s.kind: {'size': s.size, 'std': s.std, 'judged': s.judged, 'words': share_words(s)}
            for s in states}


def _joint_words(joint: JointWatch) -> str:
    """Return what is known of a joint at which nothing is found."""
    unknown = ', '.join(s.kind for s in joint.states if not s.judged)
    well = f'as learnt; not known yet: {unknown}' if unknown else 'as learnt'
    return joint.why if joint.level is None else well


def _finite(values: Sequence[float]) -> list[float | None]:
    return [x if math.isfinite(x) else None for x in values]
