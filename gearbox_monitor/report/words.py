# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Words for a verdict, shared by the terminal and the page: effects, places, next steps."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import shlex
from typing import Any, NamedTuple

from gearbox_monitor.diagnosis.hypothesis import INCOMPLETE, NONE, UNKNOWN
from gearbox_monitor.plant.effects import EFFECTS, library
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.arm_side import ARM_INERTIA, DISTURBANCE
from gearbox_monitor.plant.effects.controller import SERVO_GAIN
from gearbox_monitor.plant.effects.gearbox import SLIP
from gearbox_monitor.plant.effects.motor_side import MOTOR_COULOMB, MOTOR_INERTIA
from gearbox_monitor.presentation import (
    change, credible, EXACT, number, on_axis, percent, Quantity, said)
from gearbox_monitor.report.sentences import NEAR_FLOOR, PLACES, say

NOTHING = ('none', 'undecided')  # verdicts without a gap
LACKING = ('incomplete', 'unknown')  # verdicts with a remainder
NAMING = ('effect', 'incomplete')  # verdicts with findings
# The meaning of each effect on a real drive.
MEANINGS = {name: effect.meaning for name, effect in EFFECTS.items()}
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


def unit_of(reading: str, angle: str) -> str:
    """Return the unit of a `reading` of Recording.readings; `angle`: rad or m."""
    return ('N m' if angle == 'rad' else 'N') if reading == 'torque' else angle


def place_text(place: str) -> str:
    """Return the name of a `place` where a free signal was put."""
    return 'motor, actuator' if place == 'motor_side' else PLACES[place]


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
    One identified value of an effect.

    size: with its deviation, None for a text; text: the size or that text. nominal: value of
    the model, '' where it has none; change: from it.
    """

    effect: str
    name: str
    size: Quantity | None
    text: str
    nominal: str
    change: str

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of a table: effect, name, value with deviation and unit, nominal, change."""
        return self.effect, self.name, self.text, self.nominal, self.change

    def __str__(self) -> str:
        model = f' (model: {self.nominal}{", " * bool(self.change)}{self.change})'
        return f'{self.name} = {self.text}' + model * bool(self.nominal)


def value_rows(data: Mapping[str, Any], axis: str) -> list[ValueRow]:
    """
    Return a ValueRow for each value that a verdict identified.

    Args:
        data: the verdict as plain data.
        axis: of the drive.
    """
    effects, rows = library(), []
    errors = data.get('standard_errors') or {}
    stated = data.get('model_values') or {}
    undetermined = {(f['effect'], name) for f in data.get('findings') or ()
                    for name, deviation in f['deviations'].items() if deviation is None}
    for effect, values in (data.get('params') or {}).items():
        units = {p.name: p.unit for p in effects[effect].parameters} if effect in effects else {}
        for name, value in values.items():
            error = (errors.get(effect) or {}).get(name) or EXACT
            size = credible(value, None if (effect, name) in undetermined else error, on_axis(
                units.get(name, ''), axis)) if isinstance(value, (int, float)) else None
            nominal = stated.get(effect, {}).get(name)
            rows.append(ValueRow(
                effect, name, size, str(value if size is None else size),
                '' if nominal is None else number(nominal),
                change(value, nominal) if nominal and size else ''))
    return rows


def gain_text(gains: Mapping[str, float], name: str) -> str:
    """Return the gain of `name` and, in brackets, its distance to the best of `gains`."""
    lag = max(gains.values()) - gains[name]
    return f'{gains[name]:.0f}' + (f' (-{lag:.0f})' if lag > 0.0 else '')


def undefined(data: Mapping[str, Any]) -> str:
    """Return why the verdict `data` has no closed fraction."""
    ids = ids_of(data)
    if data['verdict'] in LACKING and (data.get('gap_before') or 0.0) > NEAR_FLOOR:
        return say('nothing_explains')
    if {DISTURBANCE.id, SLIP.id} & set(ids):
        return say('never_again', effect=DISTURBANCE.id if DISTURBANCE.id in ids else SLIP.id)
    return say('rounds' if _rounds(ids) else 'near_noise')


def _rounds(ids: Iterable[str]) -> bool:
    """Return whether one of the effects `ids` rounds readings."""
    return any(name in EFFECTS and EFFECTS[name].lattice for name in ids)


def torque_map_of(data: Mapping[str, Any]) -> tuple[str, list[tuple[str, str, str]]] | None:
    """Return (words, [(where, torque, deviation)]) of the torque map in `data` of a verdict."""
    table = (data.get('remainder') or {}).get('torque_map')
    if not table:
        return None
    rows = [(number(x), *Quantity(torque, deviation).digits()) for x, torque, deviation in zip(
        table['knots'], table['values'], table['deviations'])]
    return f'{PLACES[table["place"]]}, torque over {table["variable"]}', rows


@dataclass(frozen=True)
class UserFiles:
    """
    Files and options of a diagnosis, as the user's commands have them.

    model, bags: as given. options: those that say how the recordings are read. closed: the closed
    model, '' where it is not written. validated: the second recording, or None. robot: the file
    of a simulator with the joint, '' for a model file. joint: options that select the joint.
    values: file of values that the robot's file does not state, or None. changes: of the file of
    the simulator, in words.
    """

    model: str = 'drive.yaml'
    bags: Sequence[str] = ('BAG',)
    options: str = ''
    closed: str = ''
    validated: str | None = None
    robot: str = ''
    joint: str = ''
    values: str | None = None
    changes: Sequence[str] = ()

    def command(self, name: str, model: str = '', options: str = '') -> str:
        """Return the command `name` on the recordings, for a `model` and with `options`."""
        bags = ' '.join(map(shlex.quote, self.bags))
        joint = '' if model else self.joint
        values = f'--values {shlex.quote(self.values)}' if self.values and not model else ''
        words = (f'gearbox_monitor {name}', bags, f'--model {shlex.quote(model or self.model)}',
                 joint, values, self.options, options)
        return ' '.join(word for word in words if word)

    def export(self) -> str:
        """Return the command that writes the closed model into the file of a simulator."""
        target = 'urdf' if Path(self.robot).suffix.lower() == '.urdf' else 'mjcf'
        into = shlex.quote(self.robot) if self.robot else 'ROBOT.xml'
        return (f'gearbox_monitor export {shlex.quote(self.closed)} --to {target} --into {into} '
                f'{self.joint or "--joint NAME"}')


NO_FILES = UserFiles()


def next_steps(data: Mapping[str, Any], files: UserFiles, axis: str = 'rotary') -> Sequence[str]:
    """
    Return advice after a diagnosis.

    Args:
        data: the verdict as plain data.
        files: of the user.
        axis: of the model.

    Returns:
        Sentences without capital letter and full stop.

    """
    if data['verdict'] == 'undecided':
        return [say('would_show', motion=motion_words(q, axis), noun=effect.noun, size=number(
            q['plausible'], on_axis(effect.parameters[0].unit, axis)))
            for q in data['questions'] for effect in (EFFECTS[q['effect']],)]
    if data['verdict'] == 'none':
        return [say('nothing_to_do')]
    if data['verdict'] in LACKING:
        follows = (data.get('misfit') or {}).get('follows')
        law = (said('depends_on', over=follows['over']),) if follows else ()
        share = data.get('closed_fraction')
        closed = [say('simulate_most', file=files.closed, share=percent(share))
                  ] if files.closed and share else []
        return [*closed, say('look_at_place', law=law)]
    ids = set(ids_of(data))
    advice = [motion_words(q, axis) for q in data.get('questions', ())
              if frozenset((q['effect'], q['rival'])) in SEPARATES]
    if SLIP.id in ids:
        advice.append(say('check_clutch'))
    if ids == {SLIP.id}:
        return advice
    if DISTURBANCE.id in ids:
        return [*advice, say('look_for_contacts')]
    if _rounds(ids):
        return [*advice, say('read_finer')]
    if files.closed and 'kp' in (data.get('nominal') or {}):  # no torque to export or to fit
        advice.append(say('simulate', file=files.closed))
    elif files.closed:
        advice += [say('simulate_or_export', file=files.closed, command=files.export()),
                   say('fit_to_all', command=files.command('fit model', files.closed,
                                                           '--out fitted.yaml'))]
    else:
        advice.append(say('write_closed', command=files.command(
            'diagnose', options='--out DIR')))
    if not files.validated:
        advice.append(say('test_elsewhere', command=files.command(
            'diagnose', options='--validate BAG2')))
    return advice


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
    how = say(SHOWS.get(effect, 'move_carriers'), joint=joint, place=question['place'])
    if rival:
        name, _, other = rival.partition('@')
        apart = SEPARATES.get(frozenset((effect, name)), '')
        code = ('no_motion' if apart.startswith('no ') else 'distinguish' if apart else
                'distinguish_joints' if other else 'distinguish_loaded')
        how = say(code, effect=effect, rival=rival, joint=joint, other=other, why=apart,
                  motion=on_axis(apart, axis))
        if code == 'no_motion':
            return how
    more = () if evidence is None else (said('evidence', evidence=evidence),)
    return say('at_speed', how=how, slow=slow, fast=fast, seconds=question['seconds'],
               evidence=more)


def change_sentence(verdict: Mapping[str, Any]) -> str:
    """Return a verdict on a change, as ChangeVerdict.to_dict has it, in one sentence."""
    kind, remainder = verdict['verdict'], verdict.get('remainder')
    code = {NONE: 'no_cause', UNKNOWN: 'unknown_cause', INCOMPLETE: 'part_of_cause'}
    return say(code.get(kind, 'cause'), findings=', '.join(map(_finding, verdict['findings'])),
               place=remainder and _place(remainder), model=model_words(verdict))


def model_words(verdict: Mapping[str, Any]) -> str:
    """Return whether the model file holds by `verdict`, in words."""
    if verdict['model_holds'] or verdict['model_held']:
        return say('model_holds' if verdict['model_holds'] else 'model_no_longer')
    missed = ' and '.join(verdict['effects_before'])
    return say('model_never', missed=(said('missed_effects', effects=missed),) if missed else ())


def _finding(finding: Mapping[str, Any]) -> str:
    return say('one_cause', effect=finding['effect'], place=_place(finding['place']),
               sizes=', '.join(map(_value, finding['values'])))


def _place(location: str) -> str:
    return PLACES.get(location, location)


def _value(value: Mapping[str, Any]) -> str:
    name, before = value['name'], number(value['before'])
    if value['relative'] is None:
        return say('was_and_is_now', name=name, before=before,
                   now=Quantity(value['now'], value['std'], value['unit']))
    return say('was_and_is', name=name, before=before, now=number(value['now'], value['unit']),
               size=percent(value['relative'], value['relative_std']))
