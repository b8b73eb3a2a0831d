# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What a watch of a robot says, and how its logs have to be read, in words and as JSON has it."""
from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.conventions import NamedReading, RobotReading
from gearbox_monitor.diagnosis.robot.robot_effects import BASE_TILT
from gearbox_monitor.health.backlash.wear import when
from gearbox_monitor.plant.effects.actuator import TORQUE_GAIN
from gearbox_monitor.plant.effects.motor_side import COGGING, MOTOR_COULOMB, MOTOR_INERTIA
from gearbox_monitor.presentation import number, percent, Quantity, Said
from gearbox_monitor.report.sentences import say, TABLE
from gearbox_monitor.report.words import answer, counted, JOINTS, sentence
from gearbox_monitor.watch.record import (
    Change, DESCRIBE, FRICTION, HeldLoad, JointWatch, LEARN, RIPPLE, ROTOR, SCALE, StateHealth,
    TILT, WATCH, Watch, WEIGHT)


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
        'findings': [_finding(c) for c in found], 'remainders': [],
        'not_judged': silent, 'warnings': [*watch.doubts, *watch.notes],
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
