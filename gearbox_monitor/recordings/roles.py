# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Roles of the columns of one joint, by their names and units; else a question.

What is desired, commanded, filtered or predicted is offered in its own role or in none. Values
decide nothing: they only contradict, a copy is no second encoder, and a command that no position
follows is no setpoint of it.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import shlex

import numpy as np

from gearbox_monitor.kernels.elementary import quantisation_step
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.log_units import (
    COUNTS, EFFORT, POSITION, PRISMATIC, ROTARY, units_of, VELOCITY, vocabulary)
from gearbox_monitor.recordings.meaning import (
    FILTERED, Meaning, MEASURED, RELATIVE, SENSOR, SETPOINT, words_of)

FOLLOWED = 0.7  # correlation of a position with its setpoint, at least
TOGETHER = 0.9  # correlation of the two ends of a gear, at least
EXACT, OF_STEP = 1e-6, 0.05  # of the spread, of the own lattice: an encoder rounds by 0.29
LEAST, ROWS = 50, 20_000  # rows that are compared
NONE = 'none'  # in place of a column, for a role that nobody has


@dataclass(frozen=True)
class OpenQuestion:
    """What names and units leave open, and the option that settles it."""

    topic: str
    text: str
    option: str

    def __str__(self) -> str:
        return f'{self.text}: {self.option}'


@dataclass(frozen=True)
class NamedColumn:
    """A column of a recording: its name in the table, Meaning and values [N], NaN: none."""

    column: str
    meaning: Meaning
    values: Array


@dataclass
class Choice:
    """
    The columns of one joint by role, why each was chosen or left, and what is open.

    roles {role: NamedColumn}: names of mapping.SIGNALS. left {column: why it has no role}.
    """

    joint: str
    roles: dict[str, NamedColumn] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    left: dict[str, str] = field(default_factory=dict)
    questions: list[OpenQuestion] = field(default_factory=list)

    def take(self, role: str, candidate: NamedColumn, why: str = '') -> None:
        """Give `candidate` a `role`; `why`: in words, '' for its name."""
        self.roles[role] = candidate
        self.reasons[role] = why or f'by its name: {candidate.meaning.why}'

    def ask(self, topic: str, text: str, *options: str) -> None:
        """Add a question about `topic`, with `options` that settle it."""
        self.questions.append(OpenQuestion(topic, text, ' or '.join(options)))


def use_option(role: str, column: str) -> str:
    """Return the option that gives a `column` a `role`, as it is typed in a shell."""
    return f'--use {shlex.quote(f"{role}={column}")}'


def matches(given: str, meaning: Meaning) -> bool:
    """Return whether `given` is the label of `meaning`, whole or without words of its joint."""
    request = words_of(given)
    return given == meaning.label or request == words_of(meaning.label) or bool(
        meaning.joint) and request == meaning.words


def choice_of(columns: Sequence[NamedColumn], joint: str, use: Mapping[str, str]) -> Choice:
    """
    Return the Choice for the columns of one joint.

    Args:
        columns: of the joint.
        joint: its name, '' for the only one.
        use: {role: name of a column, or NONE} as the user states them.
    """
    choice = Choice(joint)
    refused = {role for role, name in use.items() if name == NONE}
    for role, name in use.items():
        fitting = [c for c in columns if name != NONE and matches(name, c.meaning)]
        if fitting:
            choice.take(role, fitting[0], 'as stated')
    taken = {c.column for c in choice.roles.values()}
    columns = [c for c in columns if c.column not in taken]
    _positions(choice, columns, refused)
    _velocities(choice, columns)
    _efforts(choice, columns, refused)
    _setpoints(choice, columns, refused)
    return choice


def _kind(columns: Sequence[NamedColumn], quantity: str, *sources: str) -> list[NamedColumn]:
    return [c for c in columns if c.meaning.quantity == quantity and c.meaning.source in sources]


def _preferred(choice: Choice, columns: Sequence[NamedColumn]) -> list[NamedColumn]:
    """Return those of `columns` that the vocabulary prefers, of copies the first; note others."""
    kept = list(columns)
    for row in vocabulary()['preferred']:
        chosen = [c for c in kept if set(row['words']) <= set(words_of(c.meaning.label))]
        if chosen and len(chosen) < len(kept) and {c.meaning.side for c in kept} == {
                chosen[0].meaning.side}:
            choice.left |= {c.column: f'another one is {row["why"]}: {chosen[0].meaning.stem}'
                            for c in kept if c not in chosen}
            kept = chosen
    originals: list[NamedColumn] = []
    for c in sorted(kept, key=lambda c: not c.meaning.stated):
        origin = next((o for o in originals if is_copy(c.values, o.values)), None)
        if origin is None:
            originals.append(c)
        else:
            choice.left[c.column] = f'a copy of {origin.meaning.stem}'
    return originals


def is_copy(values: Array, origin: Array) -> bool:
    """
    Return whether `values` [N] are `origin` [N] in another unit, to a fraction of their rounding.

    An encoder at the other end of a gear has noise and a lattice of its own.
    """
    if len(values) != len(origin):
        return False
    x, y = np.asarray(origin, float)[:ROWS], np.asarray(values, float)[:ROWS]
    valid = np.isfinite(x) & np.isfinite(y)
    x, y = x[valid], y[valid]
    if len(y) < LEAST or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return False
    x, y = (x - x.mean()) / np.abs(x).max(), y - y.mean()
    left = y - x * (x @ y) / (x @ x)
    rounding = max(EXACT * float(np.std(y)), OF_STEP * quantisation_step(y))
    return float(np.sqrt(np.mean(left ** 2))) < rounding


def correlation(a: Array, b: Array) -> float:
    """Return the correlation of two columns [N]; 1.0 where nothing contradicts one."""
    if len(a) != len(b):  # of clocks of their own
        return 1.0
    at = [np.interp(np.arange(len(x)), np.flatnonzero(np.isfinite(x)), x[np.isfinite(x)])
          if np.isfinite(x).any() else np.zeros(len(x)) for x in (a, b)]
    if min(np.std(at[0]), np.std(at[1])) == 0.0:
        return 1.0
    return float(np.corrcoef(at[0], at[1])[0, 1])


# --- positions, velocities ----------------------------------------------------------------------
def _positions(choice: Choice, columns: Sequence[NamedColumn], refused: set[str]) -> None:
    """Choose the encoders of motor and arm."""
    measured, filtered = (_kind(columns, POSITION, *sources) for sources in (
        (MEASURED, ''), (FILTERED, RELATIVE)))
    candidates = measured or filtered
    missing = [role for role in ('motor_position', 'arm_position')
               if role not in choice.roles and role not in refused]
    own = [c for role, c in choice.roles.items() if role.endswith('_position')]
    candidates = [c for c in _preferred(choice, [*own, *candidates]) if c not in own]
    if not candidates or not missing:
        return
    by_side = {side: [c for c in candidates if c.meaning.side == side]
               for side in ('motor', 'arm')}
    silent = [c for c in candidates if not c.meaning.side]
    if len(missing) == 1:
        side = missing[0].partition('_')[0]
        chosen = by_side[side] or (silent if own else []) or (
            [] if own and 'as stated' in choice.reasons.values() else candidates)
        if len(chosen) == 1:
            choice.take(missing[0], chosen[0], 'the one without a role')
        elif chosen:
            choice.ask('positions', f'{", ".join(c.meaning.stem for c in chosen)}: positions of '
                       f'one joint, and no name tells the {side}', *(
                           use_option(side, c.meaning.stem) for c in chosen[:3]),
                       use_option(side, NONE))
        return
    if len(candidates) == 1:
        side = candidates[0].meaning.side or 'motor'
        choice.take(f'{side}_position', candidates[0],
                    'the only position' if side == 'motor' else 'the only position, of the arm')
        return
    labelled = [c for side in by_side.values() for c in side]
    if len(labelled) <= 2 and all(len(side) <= 1 for side in by_side.values()) and not silent:
        for c in labelled:
            choice.take(f'{c.meaning.side}_position', c)
        return
    if len(silent) == 1 == len(labelled) and abs(correlation(
            silent[0].values, labelled[0].values)) > TOGETHER:
        side = labelled[0].meaning.side
        choice.take(f'{side}_position', labelled[0])
        choice.take('arm_position' if side == 'motor' else 'motor_position', silent[0],
                    'the other end')
        return
    names = ', '.join(c.meaning.stem for c in candidates)
    spread = sorted(candidates, key=lambda c: -float(np.nanstd(c.values)))
    choice.questions.append(OpenQuestion(
        'positions', f'{names}: positions of one joint, and no name tells motor from arm',
        f'{use_option("motor", spread[0].meaning.stem)} '
        f'{use_option("arm", spread[1].meaning.stem)} (or none), or --columns'))


def _velocities(choice: Choice, columns: Sequence[NamedColumn]) -> None:
    """Choose the velocities of motor and arm."""
    candidates = _kind(columns, VELOCITY, MEASURED, '') or _kind(
        columns, VELOCITY, FILTERED, RELATIVE)
    motor = choice.roles.get('motor_position')
    usual = 'arm' if 'arm_position' in choice.roles and (
        motor is None or motor.meaning.side == 'motor' and not
        choice.roles['arm_position'].meaning.side) else 'motor'
    for side in ('motor', 'arm'):
        own = [c for c in candidates if (c.meaning.side or usual) == side]
        if not own or f'{side}_velocity' in choice.roles:
            continue
        chosen = max(_preferred(choice, own), key=lambda c: np.isfinite(c.values).mean())
        choice.take(f'{side}_velocity', chosen)


# --- efforts, setpoints -------------------------------------------------------------------------
def _efforts(choice: Choice, columns: Sequence[NamedColumn], refused: set[str]) -> None:
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
    if sensors and 'reference_torque' not in {*choice.roles, *refused} and (
            measured or commanded or 'motor_effort' in choice.roles):
        torques = [c for c in sensors if c.meaning.unit in units_of(
            EFFORT, ROTARY, PRISMATIC)] or sensors
        if torques[0].meaning.unit not in COUNTS:  # of which nothing tells the torque
            choice.take('reference_torque', torques[0], f'a sensor: {torques[0].meaning.why}')
    if 'motor_effort' in choice.roles or 'motor_effort' in refused:
        return
    if measured or commanded or filtered:
        _drive_effort(choice, _preferred(choice, measured or filtered),
                      _preferred(choice, commanded))
    elif sensors:
        choice.ask('effort', f'{sensors[0].meaning.stem}: a torque sensor, and no effort of the '
                   'motor', use_option('reference', sensors[0].meaning.stem),
                   f'{use_option("effort", sensors[0].meaning.stem)} if it is the motor torque')


def _drive_effort(choice: Choice, measured: Sequence[NamedColumn],
                  commanded: Sequence[NamedColumn]) -> None:
    """Choose between measured and commanded efforts, torques and what needs a constant."""
    measured = [c for c in measured if np.nanmax(c.values) > np.nanmin(c.values)] or measured
    torques = [c for c in measured if not c.meaning.is_input]
    commanded_torques = [c for c in commanded if not c.meaning.is_input]
    if torques:
        _take_effort(choice, [c for c in torques if c.meaning.side == 'motor'] or torques,
                     "torques of one joint, and no name tells which is the motor's")
    elif measured and commanded_torques:
        first, second = measured[0].meaning.stem, commanded_torques[0].meaning.stem
        choice.ask('effort', f'{first}, {second}: a measured current or duty, and a commanded '
                   'torque', f'{use_option("effort", first)} --torque-constant K (N m per A),',
                   use_option('effort', second))
    elif measured:
        of_motor = [c for c in measured if c.meaning.side == 'motor'] or measured
        if len(of_motor) > 1:
            of_unit = [c for c in of_motor if c.meaning.unit == 'A' or set(
                c.meaning.words) & {'current', 'iq', 'i'}]
            of_motor = of_unit if len(of_unit) == 1 else of_motor
        _take_effort(choice, of_motor, 'inputs of one motor')
    else:
        _take_effort(choice, commanded_torques or commanded, 'commanded efforts of one joint',
                     'commanded, the only effort')


def _take_effort(choice: Choice, columns: Sequence[NamedColumn], question: str,
                 reason: str = '') -> None:
    """Choose the effort of the motor, or ask which of several `columns` it is."""
    if len(columns) > 1:
        _ask_effort(choice, columns, question)
    else:
        choice.take('motor_effort', columns[0], reason)


def _ask_effort(choice: Choice, columns: Sequence[NamedColumn], question: str) -> None:
    choice.ask('effort', f'{", ".join(c.meaning.stem for c in columns)}: {question}',
               *(use_option('effort', c.meaning.stem) for c in columns[:3]))


def _setpoints(choice: Choice, columns: Sequence[NamedColumn], refused: set[str]) -> None:
    """Choose the setpoint of the position."""
    position = next((choice.roles[role] for role in ('motor_position', 'arm_position')
                     if role in choice.roles), None)
    candidates = _kind(columns, POSITION, SETPOINT)
    if not candidates or {'motor_setpoint'} & {*choice.roles, *refused}:
        return
    loose = [c for c in candidates if not c.meaning.unit and c.meaning.implied and (
        position is not None and correlation(position.values, c.values) < FOLLOWED)]
    choice.left |= {c.column: 'a command that the position does not follow' for c in loose}
    asked = any(question.topic == 'effort' for question in choice.questions)
    if loose and 'motor_effort' not in {*choice.roles, *refused} and not asked:
        _ask_effort(choice, loose, 'a command that the position does not follow, maybe of the '
                    'torque')
    candidates = [c for c in candidates if c not in loose]
    if not candidates:
        return
    first, *rivals = _preferred(choice, candidates)
    if rivals and 'motor_effort' not in choice.roles and not asked:
        choice.ask('setpoint', f'{", ".join(c.meaning.stem for c in (first, *rivals))}: setpoints '
                   'of one joint', *(use_option('setpoint', c.meaning.stem)
                                     for c in (first, *rivals[:2])))
        return
    choice.take('motor_setpoint', first)
