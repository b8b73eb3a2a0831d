# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Roles of the columns of a recording, by their names and units; else a question.

Columns alike of all joints are a family, which has one role in all of them: no joint takes another
column than its neighbours because its own is missing. What is desired, commanded, filtered or
predicted is offered in its own role or in none. Values decide nothing: they only contradict, a
copy is no second encoder, and a command that no position follows is no setpoint of it.
"""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import re
import shlex
from statistics import median

import numpy as np

from gearbox_monitor.kernels.elementary import quantisation_step
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.meaning import (
    COUNTS, EFFORT, FILTERED, Meaning, MEASURED, OF_DRIVE, POSITION, PRISMATIC, RELATIVE, ROTARY,
    SENSOR, SETPOINT, units_of, VELOCITY, vocabulary, words_of)

FOLLOWED = 0.7  # correlation of a position with its setpoint, at least
TOGETHER = 0.9  # correlation of the two ends of a gear, at least
EXACT, OF_STEP = 1e-6, 0.05  # of the spread, of the own lattice: an encoder rounds by 0.29
LEAST, ROWS = 20, 20_000  # rows that are compared
VECTOR = re.compile(r'[ .]\d+$')  # ends names of its columns
NONE = 'none'  # in place of a column, for a role that nobody has
NAMES = {'motor': 'motor_position', 'arm': 'arm_position', 'position': 'motor_position',
         'velocity': 'motor_velocity', 'effort': 'motor_effort', 'setpoint': 'motor_setpoint',
         'reference': 'reference_torque'}  # of roles, as --use has them
# Of each quantity the sources that may have its role, the best first.
MEASUREMENTS = (MEASURED, ''), (FILTERED, RELATIVE)


@dataclass(frozen=True)
class OpenQuestion:
    """What names and units leave open, and the option that settles it."""

    topic: str
    text: str
    option: str

    def __str__(self) -> str:
        return f'{self.text}: {self.option}'


@dataclass(frozen=True)
class Family:
    """Columns alike, {joint: Meaning}; '' is the only joint. `first` is what they mean."""

    columns: Mapping[str, Meaning]

    @property
    def first(self) -> Meaning:
        """Meaning of the first column, whose quantity, source and side are those of all."""
        return next(iter(self.columns.values()))

    @property
    def stem(self) -> str:
        """What an option calls the family."""
        return self.first.stem


def families_of(columns: Iterable[Meaning], robot: bool = True) -> list[Family]:
    """
    Return `columns` as families: of one quantity, source and side, one of each joint.

    Names alike come first; those of other joints, 'hip_angle' and 'knee_position', join them.
    Without a `robot` all columns belong to the joint ''.
    """
    alike: dict[tuple[str, ...], dict[str, Meaning]] = {}
    for c in columns:
        key: tuple[str, ...] = (c.quantity, c.source, c.side, str(c.implied), c.stem)
        joint = c.joint if robot else ''
        if joint in alike.setdefault(key, {}):
            key = *key, c.label
        alike.setdefault(key, {})[joint] = c
    families: dict[tuple[str, ...], list[dict[str, Meaning]]] = {}
    for key, own in alike.items():
        others = families.setdefault(key[:4], [])
        fitting = next((other for other in others if key[0] in OF_DRIVE
                        and other.keys().isdisjoint(own)), None)
        if fitting is None:
            others.append(own)
        else:
            fitting.update(own)
    return [Family(own) for others in families.values() for own in others]


@dataclass
class Choice:
    """
    The families by role, why each was chosen or not, and what is open.

    values {label: [N], NaN = none}; use {role: name of a column, or NONE} as the user states them;
    roles {role: Family}: names of mapping.SIGNALS; left {label: why it has no role}.
    """

    values: Mapping[str, Array]
    use: Mapping[str, str]
    roles: dict[str, Family] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    left: dict[str, str] = field(default_factory=dict)
    questions: dict[str, OpenQuestion] = field(default_factory=dict)

    def take(self, role: str, family: Family, why: str = '') -> None:
        """Give a `family` a `role`; `why`: in words, '' for its name."""
        self.roles[role] = family
        self.reasons[role] = why or f'by its name: {family.first.why}'

    def leave(self, families: Iterable[Family], why: str) -> None:
        """Note `why` the `families` have no role."""
        self.left |= {c.label: why for f in families for c in f.columns.values()}

    def lacks(self, role: str) -> bool:
        """Return whether no family has the `role`, and the user does not deny it."""
        return role not in self.roles and self.use.get(role) != NONE

    def ask(self, topic: str, text: str, *options: str) -> None:
        """Add a question about `topic`, unless there is one, with `options` that settle it."""
        self.questions.setdefault(topic, OpenQuestion(topic, text, ' or '.join(options)))

    def ask_for(self, name: str, families: Sequence[Family], text: str) -> None:
        """Ask which of the `families` has the role `name` of NAMES; `text`: what they are."""
        topic = name if name in ('effort', 'setpoint') else 'positions'
        self.ask(topic, f'{", ".join(f.stem for f in families)}: {text}', *(
            use_option(name, stem) for stem in (*(f.stem for f in families[:3]), NONE)))

    def pairs(self, a: Family, b: Family) -> list[list[Array]]:
        """Return values of `a` and `b`, [2, N], where both are measured, for each such joint."""
        both = (common_rows(self.values[a.columns[joint].label],
                            self.values[b.columns[joint].label])
                for joint in a.columns if joint in b.columns)
        return [rows for rows in both if rows and min(np.ptp(x) for x in rows) > 0.0]

    def correlation(self, a: Family, b: Family) -> float:
        """Return the correlation of `a` and `b`; 1.0 where nothing contradicts one."""
        found = [float(np.corrcoef(x, y)[0, 1]) for x, y in self.pairs(a, b)]
        return median(found) if found else 1.0

    def spread(self, family: Family) -> float:
        """Return the largest standard deviation of the columns of a `family`."""
        return max(float(np.nanstd(self.values[c.label])) for c in family.columns.values())


def use_option(role: str, column: str) -> str:
    """Return the option that gives a `column` a `role`, as it is typed in a shell."""
    return f'--use {shlex.quote(f"{role}={column}")}'


def matches(text: str, column: Meaning) -> bool:
    """Return whether `text` is the label of a column, whole or without words of its joint."""
    request = words_of(text)
    return text == column.label or request == words_of(column.label) or bool(
        column.joint) and request == column.words


def choice_of(families: Sequence[Family], values: Mapping[str, Array], use: Mapping[str, str]
              ) -> Choice:
    """
    Return the Choice among `families`.

    Args:
        families: of the joints that are read.
        values: {label: [N], NaN = none} of their columns.
        use: {role: name of a column, or NONE} as the user states them.
    """
    choice = Choice(values, use)
    for role, name in use.items():
        fitting = [f for f in families if name != NONE and any(
            matches(name, c) for c in f.columns.values())]
        if fitting:
            choice.take(role, fitting[0], 'as stated')
    families = [f for f in families if f not in choice.roles.values()]
    _positions(choice, families)
    _velocities(choice, families)
    _efforts(choice, families)
    _setpoints(choice, families)
    return choice


def _best(families: Sequence[Family], quantity: str, *sources: tuple[str, ...]) -> list[Family]:
    """
    Return the families of a `quantity` and the first of `sources` that any family has.

    A vector of three is none of joints where another one has twelve.
    """
    every = ([f for f in families if f.first.quantity == quantity and f.first.source in own]
             for own in sources)
    found = next(filter(None, every), [])
    most = max((len(f.columns) for f in found), default=0)
    return [f for f in found if len(f.columns) == most or not VECTOR.search(f.first.label)]


def _preferred(choice: Choice, families: Sequence[Family]) -> list[Family]:
    """Return those that the vocabulary prefers, of copies the first; note the others."""
    kept = list(families)
    for row in vocabulary()['preferred']:
        chosen = [f for f in kept if set(row['words']) <= set(words_of(f.first.label))]
        if chosen and {f.first.side for f in kept} == {chosen[0].first.side}:
            choice.leave((f for f in kept if f not in chosen),
                         f'another one is {row["why"]}: {chosen[0].stem}')
            kept = chosen
    originals: list[Family] = []
    for f in sorted(kept, key=lambda f: not f.first.stated):
        origin = next((o for o in originals if (both := choice.pairs(o, f)) and all(
            is_copy(y, x) for x, y in both)), None)
        if origin is None:
            originals.append(f)
        else:
            choice.leave([f], f'a copy of {origin.stem}')
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
    x, y = origin[:ROWS], values[:ROWS]
    if np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return False
    x, y = (x - x.mean()) / np.abs(x).max(), y - y.mean()
    left = y - x * (x @ y) / (x @ x)
    rounding = max(EXACT * float(np.std(y)), OF_STEP * quantisation_step(y))
    return float(np.sqrt(np.mean(left ** 2))) < rounding


# --- positions, velocities, setpoints -----------------------------------------------------------
def _positions(choice: Choice, families: Sequence[Family]) -> None:
    """Choose the encoders of motor and arm."""
    missing = [side for side in ('motor', 'arm') if choice.lacks(f'{side}_position')]
    own = [f for role, f in choice.roles.items() if role.endswith('_position')]
    found = [f for f in _preferred(choice, [*own, *_best(families, POSITION, *MEASUREMENTS)])
             if f not in own]
    if not found or not missing:
        return
    sides = [f.first.side for f in found]
    if len(missing) == 1:
        fitting = [f for f in found if f.first.side == missing[0]] or [
            f for f in found if not own or not f.first.side]
        if len(fitting) > 1:
            choice.ask_for(missing[0], fitting, 'positions of one joint, and no name tells the '
                           f'{missing[0]}')
        elif fitting:
            choice.take(f'{missing[0]}_position', fitting[0], 'the one without a role')
    elif len(found) == 1:
        choice.take(f'{sides[0] or "motor"}_position', found[0], 'the only position')
    elif sorted(sides) == ['arm', 'motor']:
        for f in found:
            choice.take(f'{f.first.side}_position', f)
    elif len(found) == 2 and sides.count('') == 1 and abs(choice.correlation(*found)) > TOGETHER:
        silent, named = sorted(found, key=lambda f: f.first.side)
        choice.take(f'{named.first.side}_position', named)
        choice.take('arm_position' if named.first.side == 'motor' else 'motor_position', silent,
                    'the other end')
    else:
        first, second, *_ = sorted(found, key=choice.spread, reverse=True)
        choice.ask('positions', f'{", ".join(f.stem for f in found)}: positions of one joint, and '
                   f'no name tells motor from arm', f'{use_option("motor", first.stem)} '
                   f'{use_option("arm", second.stem)} (or none), or --columns')


def _velocities(choice: Choice, families: Sequence[Family]) -> None:
    """Choose the velocities of motor and arm."""
    found = _best(families, VELOCITY, *MEASUREMENTS)
    motor, arm = (choice.roles.get(f'{side}_position') for side in ('motor', 'arm'))
    usual = 'arm' if arm and (
        not motor or motor.first.side == 'motor' and not arm.first.side) else 'motor'
    for side in ('motor', 'arm'):
        own = [f for f in found if (f.first.side or usual) == side]
        if own and choice.lacks(f'{side}_velocity'):
            choice.take(f'{side}_velocity', max(_preferred(choice, own), key=lambda f: (
                len(f.columns), np.isfinite(choice.values[f.first.label]).mean())))


def _setpoints(choice: Choice, families: Sequence[Family]) -> None:
    """Choose the setpoint of the position."""
    found = _best(families, POSITION, (SETPOINT,))
    if not found or not choice.lacks('motor_setpoint'):
        return
    position = choice.roles.get('motor_position') or choice.roles.get('arm_position')
    loose = [f for f in found if position and f.first.implied and not f.first.unit
             and choice.correlation(position, f) < FOLLOWED]
    choice.leave(loose, 'a command that the position does not follow')
    is_open = 'motor_effort' not in choice.roles and 'effort' not in choice.questions
    if loose and is_open and choice.lacks('motor_effort'):
        choice.ask_for('effort', loose, 'a command that the position does not follow, maybe of '
                       'the torque')
    followed = _preferred(choice, [f for f in found if f not in loose])
    if len(followed) > 1 and is_open:
        choice.ask_for('setpoint', followed, 'setpoints of one joint')
    elif followed:
        choice.take('motor_setpoint', followed[0])


# --- efforts ------------------------------------------------------------------------------------
def _efforts(choice: Choice, families: Sequence[Family]) -> None:
    """Choose the motor's effort and the torque of a sensor."""
    measured, sensors, commanded, filtered = (_best(families, EFFORT, sources) for sources in (
        (MEASURED, ''), (SENSOR,), (SETPOINT,), (FILTERED,)))
    of_arm = [f for f in measured if f.first.side == 'arm' and len(measured) > 1]
    is_open = choice.lacks('motor_effort')
    if of_arm and 'motor_position' not in choice.roles and is_open:
        choice.ask_for('effort', sorted(measured, key=lambda f: f not in of_arm), 'a torque of '
                       'the arm, of the drive or of a sensor, and another effort')
        return
    sensors, measured = sensors + of_arm, [f for f in measured if f not in of_arm]
    if sensors and choice.lacks('reference_torque') and (
            measured or commanded or 'motor_effort' in choice.roles):
        torque = next((f for f in sensors if f.first.unit in units_of(
            EFFORT, ROTARY, PRISMATIC)), sensors[0])
        if torque.first.unit not in COUNTS:  # of which nothing tells the torque
            choice.take('reference_torque', torque, f'a sensor: {torque.first.why}')
    if is_open and (measured or commanded or filtered):
        _drive_effort(choice, _preferred(choice, measured or filtered),
                      _preferred(choice, commanded))
    elif is_open and sensors:
        choice.ask('effort', f'{sensors[0].stem}: a torque sensor, and no effort of the motor',
                   use_option('reference', sensors[0].stem),
                   f'{use_option("effort", sensors[0].stem)} if it is the motor torque')


def _drive_effort(choice: Choice, measured: Sequence[Family], commanded: Sequence[Family]
                  ) -> None:
    """Choose between measured and commanded efforts, torques and what needs a constant."""
    measured = [f for f in measured if choice.spread(f) > 0.0] or measured
    torques, commanded_torques = ([f for f in efforts if not f.first.is_input]
                                  for efforts in (measured, commanded))
    if measured and not torques and commanded_torques:
        first, second = measured[0].stem, commanded_torques[0].stem
        choice.ask('effort', f'{first}, {second}: a measured current or duty, and a commanded '
                   'torque', f'{use_option("effort", first)} --torque-constant K (N m per A),',
                   use_option('effort', second))
        return
    best = torques or measured or commanded_torques or commanded
    best = [f for f in best if f.first.side == 'motor'] or best
    currents = [f for f in best if f.first.unit == 'A'
                or {'current', 'iq', 'i'} & set(f.first.words)]
    if measured and not torques and len(currents) == 1:
        best = currents
    if len(best) > 1:
        choice.ask_for('effort', best, "efforts of one joint, and no name tells which is the "
                       "motor's")
    else:
        choice.take('motor_effort', best[0], '' if measured else 'commanded, the only effort')
