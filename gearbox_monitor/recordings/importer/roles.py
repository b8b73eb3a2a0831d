# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Roles of the columns of one joint: names first, then copies, then the motion; else a question.

What is desired, commanded, filtered or predicted is offered in its own role or in none. Where two
columns remain for one role, or a number is missing, the Question names the option that settles it.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import shlex

import numpy as np

from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.importer.clocks import motion_regressors, unexplained
from gearbox_monitor.recordings.importer.copies import copy_of
from gearbox_monitor.recordings.importer.meaning import (
    EFFORT, FILTERED, INPUTS, Meaning, MEASURED, POSITION, SENSOR, SETPOINT, stem_of, STRANGE,
    VELOCITY, words_of)
from gearbox_monitor.recordings.importer.unit_table import COUNTS, DRIVE_INPUT, FORCE, TORQUE

SAME_MOTION = 0.98  # share of the variance that one encoder explains of the other
NEARLY = 0.02  # of the variance: shares that say the same
DERIVATIVE = 0.7  # share of a velocity that the derivative of a position explains
FOLLOWED = 0.7  # correlation of a position with its setpoint, at least
FOLLOWS = 0.3  # share of an effort that the motion explains
GEARED = 1.05  # times the motion of the other encoder: the side of the motor
NONE = 'none'  # in place of a column, for a role that nobody has


@dataclass(frozen=True)
class Question:
    """What names, units and motion leave open, the readings, and the option that settles it."""

    topic: str
    text: str
    option: str

    def __str__(self) -> str:
        return f'{self.text}: {self.option}'


@dataclass(frozen=True)
class Column:
    """
    A column of a recording: its number, Meaning and values [N] (NaN: not measured).

    filled: share of the rows in which it has a value of its own.
    """

    number: int
    meaning: Meaning
    values: Array
    filled: float = 1.0


@dataclass
class Choice:
    """
    The columns of one joint by role, why each was chosen or left, and what is open.

    roles {role: Column}: motor_position, arm_position, motor_velocity, arm_velocity,
    motor_effort, motor_setpoint, reference_torque. left {number of a column: why it has no role}.
    """

    joint: str
    roles: dict[str, Column] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    left: dict[int, str] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)

    def take(self, role: str, column: Column, why: str) -> None:
        """Give `column` a `role`; `why`: in words."""
        self.roles[role], self.reasons[role] = column, why


@dataclass(frozen=True)
class Motion:
    """The position that all others are compared with, at times `t` in s."""

    t: Array
    position: Array

    @property
    def velocity(self) -> Array:
        """Return the derivative of the position over some 10 samples."""
        velocity: Array = motion_regressors(self.t, self.position, False)[:, 1]
        return velocity

    def explained(self, values: Array, is_position: bool = False) -> float:
        """
        Return the share of the variance of `values` that the motion explains.

        is_position: whether they are positions themselves, so that none is among the regressors.
        """
        valid = np.isfinite(values)
        if valid.sum() < 10 or np.ptp(values[valid]) == 0.0:
            return 0.0
        regressors = motion_regressors(self.t, self.position, is_position)
        return 1.0 - unexplained(self.t, regressors, self.t[valid], values[valid])


def motion_of(t: Array, position: Array) -> Motion:
    """Return the Motion of `position` [N] (NaN: not measured) at times `t` [N], s."""
    order = np.argsort(t, kind='stable')
    t, position = t[order] + 1e-12 * np.arange(len(t)), position[order]
    valid = np.isfinite(position)
    return Motion(t, np.interp(t, t[valid], position[valid]))


def is_input(meaning: Meaning) -> bool:
    """Return whether an effort of `meaning` needs a constant: a current, a duty, counts."""
    if meaning.unit:
        return meaning.unit in DRIVE_INPUT or meaning.unit in COUNTS
    words = set(meaning.words)
    return bool(words & set(INPUTS)) and not words & {'torque', 'torques', 'tau', 'trq', 'effort',
                                                      'efforts', 'force', 'moment'}


def use_option(role: str, column: str) -> str:
    """Return the option that gives a `column` a `role`, as it is typed in a shell."""
    return f'--use {shlex.quote(f"{role}={column}")}'


def matches(given: str, meaning: Meaning) -> bool:
    """Return whether `given` is the label of `meaning`, whole or without words of its joint."""
    words, request = words_of(meaning.label), words_of(given)
    return given == meaning.label or request == words or bool(meaning.joint) and (
        request == meaning.words)


def choice_of(columns: Sequence[Column], t: Array, joint: str, use: Mapping[str, str]) -> Choice:
    """
    Return the Choice for the columns of one joint.

    Args:
        columns: of the joint, constant ones left out.
        t: times [N], s.
        joint: its name, '' for the only one.
        use: {role: name of a column, or NONE} as the user states them.
    """
    choice = Choice(joint)
    stated = {role: [c for c in columns if matches(name, c.meaning)]
              for role, name in use.items() if name != NONE}
    refused = {role for role, name in use.items() if name == NONE}
    for role, fitting in stated.items():
        if fitting:
            choice.take(role, fitting[0], 'as stated')
    numbers = {column.number for column in choice.roles.values()}
    columns = [c for c in columns if c.number not in numbers]
    _positions(choice, columns, t, refused)
    position = next((choice.roles[role] for role in ('motor_position', 'arm_position')
                     if role in choice.roles), None)
    if position is None and choice.questions:  # any of them shows what is an effort
        position = next(iter(_kind(columns, POSITION, MEASURED, '', FILTERED)), None)
    motion = None if position is None else motion_of(t, position.values)
    _velocities(choice, columns, motion)
    if motion is None and 'motor_velocity' in choice.roles:
        speed = choice.roles['motor_velocity'].values
        motion = motion_of(t, np.cumsum(np.nan_to_num(speed) * np.gradient(
            np.sort(t) + 1e-12 * np.arange(len(t)))))
    if motion is not None:
        _efforts(choice, columns, motion, t, refused)
        _setpoints(choice, columns, refused, t, position)
    return choice


def _kind(columns: Sequence[Column], quantity: str, *sources: str) -> list[Column]:
    return [c for c in columns if c.meaning.quantity == quantity and c.meaning.source in sources]


def _without_copies(choice: Choice, columns: Sequence[Column]) -> list[Column]:
    """Return the columns that are no copies of another one of them; say so of the others."""
    originals: list[Column] = []
    for column in sorted(columns, key=lambda c: (not c.meaning.stated, c.number)):
        for origin in originals:
            kind = copy_of(column.values, origin.values)
            if kind:
                choice.left[column.number] = f'{kind} copy of {stem_of(origin.meaning)}'
                break
            if copy_of(origin.values, column.values) == 'filtered':
                choice.left[origin.number] = f'filtered copy of {stem_of(column.meaning)}'
                originals[originals.index(origin)] = column
                break
        else:
            originals.append(column)
    return originals


# --- positions ----------------------------------------------------------------------------------
def _positions(choice: Choice, columns: Sequence[Column], t: Array, refused: set[str]) -> None:
    """Choose the encoders of motor and arm."""
    candidates = _kind(columns, POSITION, MEASURED, '') or _kind(columns, POSITION, FILTERED)
    for column in _kind(columns, POSITION, FILTERED):
        if column not in candidates:
            choice.left[column.number] = 'filtered, beside the position itself'
    missing = [role for role in ('motor_position', 'arm_position')
               if role not in choice.roles and role not in refused]
    candidates = _without_copies(choice, [*candidates, *(
        column for role, column in choice.roles.items() if role.endswith('_position'))])
    candidates = [c for c in candidates if c not in choice.roles.values()]
    if not candidates or not missing:
        return
    if len(missing) == 1:
        role = missing[0]
        of_side = [c for c in candidates if c.meaning.side == role.partition('_')[0]]
        if of_side or refused & {'motor_position', 'arm_position'}:
            choice.take(role, (of_side or candidates)[0], 'the one without a role')
        return
    by_side = {side: [c for c in candidates if c.meaning.side == side] for side in
               ('motor', 'arm')}
    silent = [c for c in candidates if not c.meaning.side]
    if len(candidates) == 1:
        side = candidates[0].meaning.side or 'motor'
        choice.take(f'{side}_position', candidates[0],
                    'the only position' if side == 'motor' else 'the only position, of the arm')
        return
    if all(len(found) <= 1 for found in by_side.values()) and not silent:
        for side, found in by_side.items():
            for column in found:
                choice.take(f'{side}_position', column, f'by its name: {column.meaning.why}')
        return
    if len(silent) == 1 and sum(map(len, by_side.values())) == 1:
        labelled = next(column for found in by_side.values() for column in found)
        if _together(t, labelled, silent[0]) > SAME_MOTION:
            opposite = 'arm' if labelled.meaning.side == 'motor' else 'motor'
            choice.take(f'{labelled.meaning.side}_position', labelled,
                        f'by its name: {labelled.meaning.why}')
            choice.take(f'{opposite}_position', silent[0], 'the other end: it moves with it')
            return
    pairs = [(a, b) for k, a in enumerate(candidates) for b in candidates[k + 1:]
             if _together(t, a, b) > SAME_MOTION]
    if len(pairs) == 1 and not any(c.meaning.side for c in pairs[0]):
        a, b = sorted(pairs[0], key=lambda c: -float(np.nanstd(c.values)))
        ratio = float(np.nanstd(a.values) / np.nanstd(b.values))
        reason = 'of two encoders that move together the motor is the one with more motion'
        if a.meaning.unit == b.meaning.unit and ratio > GEARED:
            choice.take('motor_position', a, reason)
            choice.take('arm_position', b, reason)
            return
    if choice.joint and not any(by_side.values()) and 2 * len(pairs) == len(candidates) * (
            len(candidates) - 1) and _alike(candidates):  # one position that two topics tell
        densest = max(candidates, key=lambda c: c.filled)
        choice.take('motor_position', densest, f'by its name: {densest.meaning.why}')
        for column in candidates:
            if column is not densest:
                choice.left[column.number] = f'the same motion as {stem_of(densest.meaning)}'
        return
    names = ', '.join(c.meaning.label for c in candidates)
    candidates = sorted(candidates, key=lambda c: -float(np.nanstd(c.values)))
    moving = 'move together' if pairs else 'do not move together'
    choice.questions.append(Question(
        'positions', f'{names}: positions of one joint that {moving}, and no name tells motor '
        'from arm', f'{use_option("motor", candidates[0].meaning.label)} '
        f'{use_option("arm", candidates[1].meaning.label)} (or none), or --columns'))


def _alike(columns: Sequence[Column]) -> bool:
    """Return whether `columns` are as large as each other, and about one and the same mean."""
    spreads = np.array([np.nanstd(c.values) for c in columns])
    means = np.array([np.nanmean(c.values) for c in columns])
    return bool(max(np.ptp(spreads), np.ptp(means)) < 0.01 * spreads.max())


def _together(t: Array, a: Column, b: Column) -> float:
    return motion_of(t, a.values).explained(b.values[np.argsort(t, kind='stable')], True)


# --- velocities ---------------------------------------------------------------------------------
def _velocities(choice: Choice, columns: Sequence[Column], motion: Motion | None) -> None:
    """Choose the velocities of motor and arm."""
    candidates = _kind(columns, VELOCITY, MEASURED, '') or _kind(columns, VELOCITY, FILTERED)
    by_side: dict[str, list[Column]] = {}
    motor = choice.roles.get('motor_position')
    usual = 'arm' if 'arm_position' in choice.roles and (
        motor is None or motor.meaning.side == 'motor' and not
        choice.roles['arm_position'].meaning.side) else 'motor'
    for column in candidates:
        side = column.meaning.side or usual
        if f'{side}_velocity' not in choice.roles:
            by_side.setdefault(side, []).append(column)
    for side, columns_of_side in by_side.items():
        share = {c.number: motion.explained(c.values) if motion is not None else 1.0
                 for c in columns_of_side}
        likely = max(share.values()) - NEARLY
        chosen = max((c for c in columns_of_side if share[c.number] >= likely),
                     key=lambda c: c.filled)
        reason = f'by its name: {chosen.meaning.why}'
        if share[chosen.number] < DERIVATIVE and np.ptp(chosen.values) > 0.0:
            reason += '; noisy: the position hardly explains it'
        choice.take(f'{side}_velocity', chosen, reason)
        for column in columns_of_side:
            if column is not chosen:
                choice.left[column.number] = f'beside {stem_of(chosen.meaning)}'


# --- efforts ------------------------------------------------------------------------------------
def _efforts(choice: Choice, columns: Sequence[Column], motion: Motion, t: Array,
             refused: set[str]) -> None:
    """Choose the motor's effort and the torque of a sensor."""
    sensors = _kind(columns, EFFORT, SENSOR)
    measured = _kind(columns, EFFORT, MEASURED, '')
    of_arm = [c for c in measured if c.meaning.side == 'arm' and len(measured) > 1]
    if of_arm and 'motor_position' not in choice.roles and not {'motor_effort'} & {
            *choice.roles, *refused}:
        _ask_effort(choice, [*of_arm, *(c for c in measured if c not in of_arm)],
                    'a torque of the arm, of the drive or of a sensor, and another effort')
        return
    sensors += of_arm
    measured = [c for c in measured if c not in sensors]
    commanded = _kind(columns, EFFORT, SETPOINT)
    filtered = _kind(columns, EFFORT, FILTERED)
    unused = [c for c in columns if c.meaning.quantity == EFFORT and c not in
              (*sensors, *measured, *commanded, *filtered)]
    for column in unused:
        choice.left[column.number] = f'{column.meaning.source}: no torque of the motor as it is'
    if sensors and 'reference_torque' not in {*choice.roles, *refused} and (
            measured or commanded or 'motor_effort' in choice.roles):
        torques = [c for c in sensors if c.meaning.unit in (*TORQUE, *FORCE)] or sensors
        if torques[0].meaning.unit not in COUNTS:  # of which nothing tells the torque
            choice.take('reference_torque', torques[0], f'a sensor: {torques[0].meaning.why}')
    for column in sensors:
        if column not in choice.roles.values():
            choice.left[column.number] = 'a torque sensor: reference_torque, for scores'
    if 'motor_effort' in choice.roles or 'motor_effort' in refused:
        return
    if not (measured or commanded or filtered):
        _silent_efforts(choice, columns, sensors, motion, t)
        return
    _drive_effort(choice, measured or filtered, commanded)


def _drive_effort(choice: Choice, measured: Sequence[Column], commanded: Sequence[Column]) -> None:
    """Choose between measured and commanded efforts, torques and what needs a constant."""
    measured = _without_copies(choice, measured)
    measured = [c for c in measured if np.nanmax(c.values) > np.nanmin(c.values)] or measured
    torques = [c for c in measured if not is_input(c.meaning)]
    commanded_torques = [c for c in commanded if not is_input(c.meaning)]
    if torques:
        _take_effort(choice, [c for c in torques if c.meaning.side == 'motor'] or torques,
                     "torques of one joint, and no name tells which is the motor's")
    elif measured and commanded_torques:
        choice.questions.append(Question(
            'effort', f'{stem_of(measured[0].meaning)}, {stem_of(commanded_torques[0].meaning)}: '
            'a measured current or duty, and a commanded torque',
            f'{use_option("effort", stem_of(measured[0].meaning))} --torque-constant K (N m per '
            f'A), or {use_option("effort", stem_of(commanded_torques[0].meaning))}'))
    elif measured:
        of_motor = [c for c in measured if c.meaning.side == 'motor'] or measured
        if len(of_motor) > 1:
            of_unit = [c for c in of_motor if c.meaning.unit == 'A' or set(
                c.meaning.words) & {'current', 'iq', 'i'}]
            of_motor = of_unit if len(of_unit) == 1 else of_motor
        _take_effort(choice, of_motor, 'inputs of one motor')
    else:
        commanded = _without_copies(choice, commanded_torques or commanded)
        _take_effort(choice, commanded, 'commanded efforts of one joint',
                     'commanded, the only effort')
    for column in (*measured, *commanded):
        if column not in choice.roles.values():
            choice.left.setdefault(column.number, 'another effort: '
                                   + use_option('effort', stem_of(column.meaning)))


def _take_effort(choice: Choice, columns: Sequence[Column], question: str,
                 reason: str = 'by its name') -> None:
    """Choose the effort of the motor, or ask which of several `columns` it is."""
    if len(columns) > 1:
        _ask_effort(choice, columns, question)
    else:
        choice.take('motor_effort', columns[0], f'{reason}: {columns[0].meaning.why}')


def _ask_effort(choice: Choice, columns: Sequence[Column], question: str) -> None:
    names = ', '.join(stem_of(c.meaning) for c in columns)
    choice.questions.append(Question(
        'effort', f'{names}: {question}', ' or '.join(
            use_option('effort', stem_of(c.meaning)) for c in columns[:3])))


def _silent_efforts(choice: Choice, columns: Sequence[Column], sensors: Sequence[Column],
                    motion: Motion, t: Array) -> None:
    """Ask whether a sensor's torque, or a column without a name that tells, is the effort."""
    if sensors:
        choice.questions.append(Question(
            'effort', f'{sensors[0].meaning.label}: a torque sensor, and no effort of the motor '
            'beside it', f'{use_option("reference", sensors[0].meaning.label)}, or '
            f'{use_option("effort", sensors[0].meaning.label)} if it is the motor torque'))
        return
    order = np.argsort(t, kind='stable')
    shares = [(motion.explained(c.values[order]), motion.explained(c.values[order], True), c)
              for c in columns if not c.meaning.quantity and not c.meaning.source
              and not set(words_of(c.meaning.label)) & STRANGE]
    likely = [(share, c) for share, as_position, c in shares
              if share > FOLLOWS and as_position < SAME_MOTION]
    if likely:
        share, column = max(likely, key=lambda pair: pair[0])
        choice.questions.append(Question(
            'effort', f'no column is named as an effort; the motion explains {share:.0%} of '
            f'{column.meaning.label}', f'{use_option("effort", column.meaning.label)}, or '
            '--use effort=none'))


# --- setpoints ----------------------------------------------------------------------------------
def _setpoints(choice: Choice, columns: Sequence[Column], refused: set[str], t: Array,
               position: Column | None) -> None:
    """Choose the setpoint of the position."""
    for quantity in (VELOCITY, EFFORT):
        for column in _kind(columns, quantity, SETPOINT):
            if column not in choice.roles.values():
                choice.left.setdefault(column.number, f'a setpoint of the {quantity}')
    candidates = _kind(columns, POSITION, SETPOINT)
    if not candidates or {'motor_setpoint'} & {*choice.roles, *refused}:
        return
    silent = [c for c in candidates if c.meaning.source == SETPOINT and not c.meaning.unit
              and c.meaning.implied and not _followed(t, position, c)]
    for column in silent:  # 'ctrl' of a motor without a servo is its torque
        choice.left[column.number] = 'a command that the position does not follow'
    if silent and 'motor_effort' not in {*choice.roles, *refused} and not any(
            question.topic == 'effort' for question in choice.questions):
        _ask_effort(choice, silent, 'a command that the position does not follow, maybe of the '
                    'torque')
    candidates = [c for c in candidates if c not in silent]
    if not candidates:
        return
    first, *rivals = _without_copies(choice, candidates)
    only_input = 'motor_effort' not in choice.roles and not any(
        question.topic == 'effort' for question in choice.questions)
    if rivals and only_input:
        names = ', '.join(c.meaning.label for c in (first, *rivals))
        choice.questions.append(Question(
            'setpoint', f'{names}: setpoints of one joint', ' or '.join(
                use_option('setpoint', stem_of(c.meaning)) for c in (first, *rivals[:2]))))
        return
    choice.take('motor_setpoint', first, f'by its name: {first.meaning.why}')
    for column in rivals:
        choice.left[column.number] = f'another setpoint beside {stem_of(first.meaning)}'


def _followed(t: Array, position: Column | None, command: Column) -> bool:
    """Return whether the position of a joint follows a command; at rest nothing says it does."""
    if position is None or np.nanstd(command.values) == 0.0:
        return True
    both = np.array([motion_of(t, c.values).position for c in (position, command)])
    return bool(both[0].std() == 0.0 or np.corrcoef(both)[0, 1] > FOLLOWED)
