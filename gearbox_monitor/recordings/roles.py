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
from gearbox_monitor.recordings.meaning import (
    COUNTS, EFFORT, FILTERED, Meaning, MEASURED, POSITION, PRISMATIC, RELATIVE, ROTARY, SENSOR,
    SETPOINT, units_of, VELOCITY, vocabulary, words_of)

FOLLOWED = 0.7  # correlation of a position with its setpoint, at least
TOGETHER = 0.9  # correlation of the two ends of a gear, at least
EXACT, OF_STEP = 1e-6, 0.05  # of the spread, of the own lattice: an encoder rounds by 0.29
LEAST, ROWS = 20, 20_000  # rows that are compared
NONE = 'none'  # in place of a column, for a role that nobody has
NAMES = {'motor': 'motor_position', 'arm': 'arm_position', 'position': 'motor_position',
         'velocity': 'motor_velocity', 'effort': 'motor_effort', 'setpoint': 'motor_setpoint',
         'reference': 'reference_torque'}  # of roles, as --use has them


@dataclass(frozen=True)
class OpenQuestion:
    """What names and units leave open, and the option that settles it."""

    topic: str
    text: str
    option: str

    def __str__(self) -> str:
        return f'{self.text}: {self.option}'


@dataclass
class Choice:
    """
    The columns of one joint by role, why each was chosen or not, and what is open.

    values {label: [N], NaN = none}; use {role: label, or NONE} as the user states them; roles
    {role: Meaning}: names of mapping.SIGNALS; left {label: why it has no role}.
    """

    joint: str
    values: Mapping[str, Array]
    use: Mapping[str, str]
    roles: dict[str, Meaning] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    left: dict[str, str] = field(default_factory=dict)
    questions: list[OpenQuestion] = field(default_factory=list)

    def take(self, role: str, column: Meaning, why: str = '') -> None:
        """Give a `column` a `role`; `why`: in words, '' for its name."""
        self.roles[role] = column
        self.reasons[role] = why or f'by its name: {column.why}'

    def lacks(self, role: str) -> bool:
        """Return whether no column has the `role`, and the user does not deny it."""
        return role not in self.roles and self.use.get(role) != NONE

    def ask(self, topic: str, text: str, *options: str) -> None:
        """Add a question about `topic`, with `options` that settle it."""
        self.questions.append(OpenQuestion(topic, text, ' or '.join(options)))

    def ask_for(self, name: str, columns: Sequence[Meaning], text: str) -> None:
        """Ask which of the `columns` has the role `name` of NAMES; `text`: what they are."""
        topic = name if name in ('effort', 'setpoint') else 'positions'
        self.ask(topic, f'{", ".join(c.stem for c in columns)}: {text}', *(
            use_option(name, stem) for stem in (*(c.stem for c in columns[:3]), NONE)))

    def correlation(self, a: Meaning, b: Meaning) -> float:
        """Return the correlation of columns `a` and `b`; 1.0 where nothing contradicts one."""
        rows = common_rows(self.values[a.label], self.values[b.label])
        moving = rows and min(np.ptp(x) for x in rows) > 0.0
        return float(np.corrcoef(rows[0], rows[1])[0, 1]) if moving else 1.0


def use_option(role: str, column: str) -> str:
    """Return the option that gives a `column` a `role`, as it is typed in a shell."""
    return f'--use {shlex.quote(f"{role}={column}")}'


def matches(text: str, column: Meaning) -> bool:
    """Return whether `text` is the label of a column, whole or without words of its joint."""
    request = words_of(text)
    return text == column.label or request == words_of(column.label) or bool(
        column.joint) and request == column.words


def choice_of(columns: Sequence[Meaning], values: Mapping[str, Array], joint: str,
              use: Mapping[str, str]) -> Choice:
    """
    Return the Choice for the columns of one joint.

    Args:
        columns: of the joint.
        values: {label: [N], NaN = none} of them.
        joint: its name, '' for the only one.
        use: {role: name of a column, or NONE} as the user states them.
    """
    choice = Choice(joint, values, use)
    for role, name in use.items():
        fitting = [c for c in columns if name != NONE and matches(name, c)]
        if fitting:
            choice.take(role, fitting[0], 'as stated')
    columns = [c for c in columns if c not in choice.roles.values()]
    _positions(choice, columns)
    _velocities(choice, columns)
    _efforts(choice, columns)
    _setpoints(choice, columns)
    return choice


def _kind(columns: Sequence[Meaning], quantity: str, *sources: str) -> list[Meaning]:
    return [c for c in columns if c.quantity == quantity and c.source in sources]


def _preferred(choice: Choice, columns: Sequence[Meaning]) -> list[Meaning]:
    """Return those of `columns` that the vocabulary prefers, of copies the first; note others."""
    kept = list(columns)
    for row in vocabulary()['preferred']:
        chosen = [c for c in kept if set(row['words']) <= set(words_of(c.label))]
        if chosen and {c.side for c in kept} == {chosen[0].side}:
            choice.left |= {c.label: f'another one is {row["why"]}: {chosen[0].stem}'
                            for c in kept if c not in chosen}
            kept = chosen
    originals: list[Meaning] = []
    for c in sorted(kept, key=lambda c: not c.stated):
        origin = next((o for o in originals if is_copy(
            choice.values[c.label], choice.values[o.label])), None)
        if origin is None:
            originals.append(c)
        else:
            choice.left[c.label] = f'a copy of {origin.stem}'
    return originals


def common_rows(*columns: Array) -> list[Array]:
    """Return `columns` [N] where all are finite; [] if they have clocks of their own, or few."""
    if len({len(x) for x in columns}) > 1:
        return []
    rows = np.all([np.isfinite(x) for x in columns], axis=0)
    return [x[rows] for x in columns] if rows.sum() >= LEAST else []


def is_copy(values: Array, origin: Array) -> bool:
    """
    Return whether `values` [N] are `origin` [N] in another unit, to a fraction of their rounding.

    An encoder at the other end of a gear has noise and a lattice of its own.
    """
    x, y = common_rows(origin[:ROWS], values[:ROWS]) or np.zeros((2, 1))
    if np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return False
    x, y = (x - x.mean()) / np.abs(x).max(), y - y.mean()
    left = y - x * (x @ y) / (x @ x)
    rounding = max(EXACT * float(np.std(y)), OF_STEP * quantisation_step(y))
    return float(np.sqrt(np.mean(left ** 2))) < rounding


# --- positions, velocities, setpoints -----------------------------------------------------------
def _positions(choice: Choice, columns: Sequence[Meaning]) -> None:
    """Choose the encoders of motor and arm."""
    missing = [side for side in ('motor', 'arm') if choice.lacks(f'{side}_position')]
    own = [c for role, c in choice.roles.items() if role.endswith('_position')]
    columns = [c for c in _preferred(choice, [*own, *(_kind(
        columns, POSITION, MEASURED, '') or _kind(columns, POSITION, FILTERED, RELATIVE))])
        if c not in own]
    if not columns or not missing:
        return
    sides = [c.side for c in columns]
    if len(missing) == 1:
        fitting = [c for c in columns if c.side == missing[0]] or [
            c for c in columns if not own or not c.side]
        if len(fitting) > 1:
            choice.ask_for(missing[0], fitting, 'positions of one joint, and no name tells the '
                           f'{missing[0]}')
        elif fitting:
            choice.take(f'{missing[0]}_position', fitting[0], 'the one without a role')
    elif len(columns) == 1:
        choice.take(f'{sides[0] or "motor"}_position', columns[0], 'the only position')
    elif sorted(sides) == ['arm', 'motor']:
        for c in columns:
            choice.take(f'{c.side}_position', c)
    elif len(columns) == 2 and sides.count('') == 1 and abs(
            choice.correlation(*columns)) > TOGETHER:
        silent, labelled = sorted(columns, key=lambda c: c.side)
        choice.take(f'{labelled.side}_position', labelled)
        choice.take('arm_position' if labelled.side == 'motor' else 'motor_position', silent,
                    'the other end')
    else:
        spread = sorted(columns, key=lambda c: -float(np.nanstd(choice.values[c.label])))
        choice.ask('positions', f'{", ".join(c.stem for c in columns)}: positions of one joint, '
                   f'and no name tells motor from arm', f'{use_option("motor", spread[0].stem)} '
                   f'{use_option("arm", spread[1].stem)} (or none), or --columns')


def _velocities(choice: Choice, columns: Sequence[Meaning]) -> None:
    """Choose the velocities of motor and arm."""
    columns = _kind(columns, VELOCITY, MEASURED, '') or _kind(
        columns, VELOCITY, FILTERED, RELATIVE)
    motor, arm = (choice.roles.get(f'{side}_position') for side in ('motor', 'arm'))
    usual = 'arm' if arm and (not motor or motor.side == 'motor' and not arm.side) else 'motor'
    for side in ('motor', 'arm'):
        own = [c for c in columns if (c.side or usual) == side]
        if own and choice.lacks(f'{side}_velocity'):
            choice.take(f'{side}_velocity', max(_preferred(choice, own), key=lambda c: np.isfinite(
                choice.values[c.label]).mean()))


def _setpoints(choice: Choice, columns: Sequence[Meaning]) -> None:
    """Choose the setpoint of the position."""
    columns = _kind(columns, POSITION, SETPOINT)
    if not columns or not choice.lacks('motor_setpoint'):
        return
    position = choice.roles.get('motor_position') or choice.roles.get('arm_position')
    loose = [c for c in columns if position and c.implied and not c.unit
             and choice.correlation(position, c) < FOLLOWED]
    choice.left |= {c.label: 'a command that the position does not follow' for c in loose}
    is_open = 'motor_effort' not in choice.roles and not any(
        question.topic == 'effort' for question in choice.questions)
    if loose and is_open and choice.lacks('motor_effort'):
        choice.ask_for('effort', loose, 'a command that the position does not follow, maybe of '
                       'the torque')
    followed = _preferred(choice, [c for c in columns if c not in loose])
    if len(followed) > 1 and is_open:
        choice.ask_for('setpoint', followed, 'setpoints of one joint')
    elif followed:
        choice.take('motor_setpoint', followed[0])


# --- efforts ------------------------------------------------------------------------------------
def _efforts(choice: Choice, columns: Sequence[Meaning]) -> None:
    """Choose the motor's effort and the torque of a sensor."""
    measured, sensors, commanded, filtered = (_kind(columns, EFFORT, *sources) for sources in (
        (MEASURED, ''), (SENSOR,), (SETPOINT,), (FILTERED,)))
    of_arm = [c for c in measured if c.side == 'arm' and len(measured) > 1]
    is_open = choice.lacks('motor_effort')
    if of_arm and 'motor_position' not in choice.roles and is_open:
        choice.ask_for('effort', sorted(measured, key=lambda c: c not in of_arm), 'a torque of '
                       'the arm, of the drive or of a sensor, and another effort')
        return
    sensors, measured = sensors + of_arm, [c for c in measured if c not in of_arm]
    if sensors and choice.lacks('reference_torque') and (
            measured or commanded or 'motor_effort' in choice.roles):
        torque = next((c for c in sensors if c.unit in units_of(EFFORT, ROTARY, PRISMATIC)),
                      sensors[0])
        if torque.unit not in COUNTS:  # of which nothing tells the torque
            choice.take('reference_torque', torque, f'a sensor: {torque.why}')
    if is_open and (measured or commanded or filtered):
        _drive_effort(choice, _preferred(choice, measured or filtered),
                      _preferred(choice, commanded))
    elif is_open and sensors:
        choice.ask('effort', f'{sensors[0].stem}: a torque sensor, and no effort of the motor',
                   use_option('reference', sensors[0].stem),
                   f'{use_option("effort", sensors[0].stem)} if it is the motor torque')


def _drive_effort(choice: Choice, measured: Sequence[Meaning], commanded: Sequence[Meaning]
                  ) -> None:
    """Choose between measured and commanded efforts, torques and what needs a constant."""
    measured = [c for c in measured if np.nanmax(choice.values[c.label]) > np.nanmin(
        choice.values[c.label])] or measured
    torques, commanded_torques = ([c for c in efforts if not c.is_input]
                                  for efforts in (measured, commanded))
    if measured and not torques and commanded_torques:
        first, second = measured[0].stem, commanded_torques[0].stem
        choice.ask('effort', f'{first}, {second}: a measured current or duty, and a commanded '
                   'torque', f'{use_option("effort", first)} --torque-constant K (N m per A),',
                   use_option('effort', second))
        return
    best = torques or measured or commanded_torques or commanded
    best = [c for c in best if c.side == 'motor'] or best
    currents = [c for c in best if c.unit == 'A' or {'current', 'iq', 'i'} & set(c.words)]
    if measured and not torques and len(currents) == 1:
        best = currents
    if len(best) > 1:
        choice.ask_for('effort', best, "efforts of one joint, and no name tells which is the "
                       "motor's")
    else:
        choice.take('motor_effort', best[0], '' if measured else 'commanded, the only effort')
