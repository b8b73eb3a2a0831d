# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What an effect, a condition or a level is, in words: one text for the command and the pages.

Each text comes from the object itself: an Effect, a RobotEffect, a Condition, a Level.
"""
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import math

from gearbox_monitor.diagnosis.robot.robot_effects import BASE, JOINT, ROBOT_EFFECTS, RobotEffect
from gearbox_monitor.health.alarms import Condition, Level
from gearbox_monitor.health.backlash import change_tests
from gearbox_monitor.health.monitor import CONDITIONS
from gearbox_monitor.plant.effects import Effect, EFFECTS, library, Parameter
from gearbox_monitor.report.sentences import PLACES, TABLE, title
from gearbox_monitor.report.words import sentence, SEPARATES
from gearbox_monitor.simulators.drive_patch import in_urdf
from gearbox_monitor.simulators.mjcf import CONSTRUCT, expression_of, NATIVE, REFUSED

OF_EFFECT = ('What it is', 'In the data', 'Confused with', 'In simulators', 'Since')
OF_CONDITION = ('What it says', 'When', 'Window', 'Values', 'What to do', 'Read more')
OF_LEVEL = ('What it says', 'What to do', 'Read more')
WAYS = {NATIVE: '', CONSTRUCT: ' (approximately)', REFUSED: ' (not in the file)'}
ALL_CONDITIONS = (*CONDITIONS, *change_tests.CONDITIONS)
ALIKE = 'no motion distinguishes them'
UNSAID = 'its plug-in does not say'


@dataclass(frozen=True)
class Explanation:
    """A title, and {heading: lines of text} in the order of a page."""

    title: str
    parts: Mapping[str, tuple[str, ...]]


def bounds(parameter: Parameter) -> str:
    """Return the bounds of a `parameter` as words, '' for none."""
    if parameter.choices:
        return f', one of {", ".join(parameter.choices)}'
    low, high = (f'{bound:g}' if math.isfinite(bound) else ''
                 for bound in (parameter.low, parameter.high))
    if low and high:
        return f', {low} to {high}'
    return f', >= {low}' if low else f', <= {high}' if high else ''


def parameters_of(effect: Effect) -> str:
    """Return the parameters of an effect with unit, bounds and default."""
    return '; '.join(
        f'{p.name} ({p.unit}{bounds(p)}'
        + ('' if p.default is None else f', default {p.default:g}') + ')'
        for p in effect.parameters)


def rivals(name: str) -> dict[str, str]:
    """
    Return {id of another effect: motion that distinguishes it from the effect `name`}.

    From the effects' own tables: separating motions, twins, and columns that are the same in the
    balance of a robot.
    """
    out: dict[str, str] = {}
    for pair, motion in SEPARATES.items():
        if name in pair:
            rival, = pair - {name}
            out[rival] = motion
    for effect_id, effect in EFFECTS.items():
        if effect.twin and name in (effect_id, effect.twin):
            out.setdefault(effect.twin if name == effect_id else effect_id, ALIKE)
        for twin in effect.column.twins if effect.column else ():
            if name in (effect_id, twin):
                out.setdefault(twin if name == effect_id else effect_id,
                               f'as torques of a whole robot, {ALIKE}')
    return out


def in_simulators(effect: Effect) -> tuple[str, ...]:
    """Return how the file of each simulator expresses an effect."""
    mjcf = expression_of(effect.id)
    return f'MuJoCo: {mjcf.words}{WAYS[mjcf.kind]}', f'URDF: {in_urdf(effect)}'


def explained_effect(effect: Effect) -> Explanation:
    """Return the Explanation of an effect of a joint."""
    return Explanation(f'{effect.id} ({PLACES.get(effect.location, "anywhere")})', dict(zip(
        OF_EFFECT, (
            (sentence(effect.meaning or UNSAID), effect.equation, parameters_of(effect)),
            (effect.shows or UNSAID,),
            tuple(f'{rival}: {motion}' for rival, motion in rivals(effect.id).items())
            or ('no effect that another motion would distinguish; diagnose lists those that a '
                'recording leaves open',),
            in_simulators(effect),
            ('a plug-in' if effect.torques else effect.since,)))))


def explained_robot_effect(effect: RobotEffect) -> Explanation:
    """Return the Explanation of an effect of a whole robot."""
    place = {JOINT: 'a joint of a robot', BASE: 'the base of a robot'}.get(
        effect.place, 'a link of a robot')
    values = '; '.join(f'{name} ({unit})' for name, unit in effect.units.items())
    return Explanation(f'{effect.id} ({place})', dict(zip(OF_EFFECT, (
        (sentence(effect.meaning), values), (effect.shows,),
        ('diagnose lists the effects that a log leaves open as confusable',),
        ('MuJoCo, URDF: diagnose --out writes the file with all that has an attribute there, '
         'and lists the others',), (effect.since,)))))


def explained_condition(condition: Condition) -> Explanation:
    """Return the Explanation of a condition of a component."""
    words, says = TABLE[condition.code], title(condition.code)
    return Explanation(
        f'{condition.component}: {says}', dict(zip(OF_CONDITION, (
            (f'{condition.level.name} of {condition.component}: {says}.',),
            (words.when,), (words.window,),
            (', '.join(condition.value) or 'none: the message alone',), (words.remedy,),
            (f'docs/{words.page}',)))))


def explained_level(level: Level) -> Explanation:
    """Return the Explanation of a level on /diagnostics."""
    words = TABLE[level.name]
    return Explanation(level.name, dict(zip(OF_LEVEL, (
        (sentence(words.says),), (sentence(words.remedy),), (f'docs/{words.page}',)))))


def explanations() -> Iterator[tuple[tuple[str, ...], Explanation]]:
    """Yield (names by which users may ask, Explanation) of all there is."""
    for name, effect in library().items():
        yield (name,), explained_effect(effect)
    for robot_effect in ROBOT_EFFECTS:
        yield (robot_effect.id,), explained_robot_effect(robot_effect)
    for condition in ALL_CONDITIONS:
        whole = title(condition.code)
        says = whole.removesuffix(' by ... %')
        yield ((says, whole, condition.code, condition.component, *says.split(', '),
                *condition.value),
               explained_condition(condition))
    for level in Level:
        yield (level.name,), explained_level(level)
