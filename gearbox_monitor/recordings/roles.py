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
    missing = [side for side in ('motor', 'arm')
               if f'{side}_position' not in {*choice.roles, *refused}]
    own = [c for role, c in choice.roles.items() if role.endswith('_position')]
    candidates = [c for c in _preferred(choice, [*own, *(
        _kind(columns, POSITION, MEASURED, '') or _kind(columns, POSITION, FILTERED, RELATIVE))])
        if c not in own]
    if not candidates or not missing:
        return
    by_side = {side: [c for c in candidates if c.meaning.side == side]
               for side in ('motor', 'arm', '')}
    silent, labelled = by_side.pop(''), [c for c in candidates if c.meaning.side]
    taken: list[tuple[str, NamedColumn, str]] = []
    if len(missing) == 1:
        fitting = by_side[missing[0]] or (silent if own else candidates)
        if len(fitting) > 1:
            choice.ask('positions', f'{", ".join(c.meaning.stem for c in fitting)}: positions of '
                       f'one joint, and no name tells the {missing[0]}', *(
                           use_option(missing[0], c.meaning.stem) for c in fitting[:3]),
                       use_option(missing[0], NONE))
        taken = [(missing[0], c, 'the one without a role') for c in fitting * (len(fitting) == 1)]
    elif len(candidates) == 1:
        taken = [(candidates[0].meaning.side or 'motor', candidates[0], 'the only position')]
    elif all(len(side) <= 1 for side in by_side.values()) and not silent:
        taken = [(c.meaning.side, c, '') for c in labelled]
    elif len(silent) == 1 == len(labelled) and abs(correlation(
            silent[0].values, labelled[0].values)) > TOGETHER:
        side = labelled[0].meaning.side
        taken = [(side, labelled[0], ''),
                 ('arm' if side == 'motor' else 'motor', silent[0], 'the other end')]
    else:
        names = ', '.join(c.meaning.stem for c in candidates)
        spread = sorted(candidates, key=lambda c: -float(np.nanstd(c.values)))
        choice.ask('positions', f'{names}: positions of one joint, and no name tells motor from '
                   'arm', f'{use_option("motor", spread[0].meaning.stem)} '
                   f'{use_option("arm", spread[1].meaning.stem)} (or none), or --columns')
    for side, c, why in taken:
        choice.take(f'{side}_position', c, why)


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
    measured = _kind(columns, EFFORT, MEASURED, '')
    of_arm = [c for c in measured if c.meaning.side == 'arm' and len(measured) > 1]
    is_open = not {'motor_effort'} & {*choice.roles, *refused}
    if of_arm and 'motor_position' not in choice.roles and is_open:
        _ask_effort(choice, [*of_arm, *(c for c in measured if c not in of_arm)],
                    'a torque of the arm, of the drive or of a sensor, and another effort')
        return
    sensors = [*_kind(columns, EFFORT, SENSOR), *of_arm]
    measured = [c for c in measured if c not in sensors]
    commanded, filtered = (_kind(columns, EFFORT, source) for source in (SETPOINT, FILTERED))
    if sensors and 'reference_torque' not in {*choice.roles, *refused} and (
            measured or commanded or 'motor_effort' in choice.roles):
        torque = next((c for c in sensors if c.meaning.unit in units_of(
            EFFORT, ROTARY, PRISMATIC)), sensors[0])
        if torque.meaning.unit not in COUNTS:  # of which nothing tells the torque
            choice.take('reference_torque', torque, f'a sensor: {torque.meaning.why}')
    if is_open and (measured or commanded or filtered):
        _drive_effort(choice, _preferred(choice, measured or filtered),
                      _preferred(choice, commanded))
    elif is_open and sensors:
        stem = sensors[0].meaning.stem
        choice.ask('effort', f'{stem}: a torque sensor, and no effort of the motor',
                   use_option('reference', stem),
                   f'{use_option("effort", stem)} if it is the motor torque')


def _drive_effort(choice: Choice, measured: Sequence[NamedColumn],
                  commanded: Sequence[NamedColumn]) -> None:
    """Choose between measured and commanded efforts, torques and what needs a constant."""
    measured = [c for c in measured if np.nanmax(c.values) > np.nanmin(c.values)] or measured
    torques, commanded_torques = ([c for c in efforts if not c.meaning.is_input]
                                  for efforts in (measured, commanded))
    reason, question = '', "torques of one joint, and no name tells which is the motor's"
    chosen: Sequence[NamedColumn] = torques or measured
    chosen = [c for c in chosen if c.meaning.side == 'motor'] or chosen
    if measured and not torques and commanded_torques:
        first, second = measured[0].meaning.stem, commanded_torques[0].meaning.stem
        choice.ask('effort', f'{first}, {second}: a measured current or duty, and a commanded '
                   'torque', f'{use_option("effort", first)} --torque-constant K (N m per A),',
                   use_option('effort', second))
        return
    if measured and not torques:
        currents = [c for c in chosen if c.meaning.unit == 'A'
                    or {'current', 'iq', 'i'} & set(c.meaning.words)]
        chosen, question = currents if len(currents) == 1 else chosen, 'inputs of one motor'
    elif not measured:
        chosen = commanded_torques or commanded
        reason, question = 'commanded, the only effort', 'commanded efforts of one joint'
    if len(chosen) > 1:
        _ask_effort(choice, chosen, question)
    else:
        choice.take('motor_effort', chosen[0], reason)


def _ask_effort(choice: Choice, columns: Sequence[NamedColumn], question: str) -> None:
    choice.ask('effort', f'{", ".join(c.meaning.stem for c in columns)}: {question}',
               *(use_option('effort', c.meaning.stem) for c in columns[:3]),
               use_option('effort', NONE))


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
    is_open = 'motor_effort' not in choice.roles and not any(
        question.topic == 'effort' for question in choice.questions)
    if loose and is_open and 'motor_effort' not in refused:
        _ask_effort(choice, loose, 'a command that the position does not follow, maybe of the '
                    'torque')
    followed = _preferred(choice, [c for c in candidates if c not in loose])
    if len(followed) > 1 and is_open:
        stems = [c.meaning.stem for c in followed]
        choice.ask('setpoint', f'{", ".join(stems)}: setpoints of one joint',
                   *(use_option('setpoint', stem) for stem in stems[:3]))
    elif followed:
        choice.take('motor_setpoint', followed[0])
