# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Roles of the columns of a recording, time first, by names, units and values; else a question.

Columns alike of all joints are a family, which has one role in all of them: no joint takes another
column than its neighbours because its own is missing. What is desired, commanded, filtered or
predicted is offered in its own role or in none. Values decide nothing: they only contradict, a
copy is no second encoder, and a command that no position follows is no setpoint of it.

One column, or two, hold the time. A robot's setpoints may be in a separate file next to its
states, on the same clock. Both names differ only in words of the vocabulary:
'run3_state_motor.csv' and 'run3_control.csv', 'joint_states.csv' and 'joint_commands.csv'.
"""
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
import shlex
from statistics import median
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.elementary import quantisation_step
from gearbox_monitor.kernels.types import Array, Flags
from gearbox_monitor.recordings.mapping import TimeMapping
from gearbox_monitor.recordings.meaning import (
    COUNTS, EFFORT, FILTERED, Meaning, meaning_of, meanings, MEASURED, OF_DRIVE, POSITION,
    PRISMATIC, RELATIVE, ROTARY, run_of, SENSOR, SETPOINT, TIME, units_of, VELOCITY, vocabulary,
    words_of)
from gearbox_monitor.recordings.si_signals import absolute_ns, EPOCH, LONGEST, SHORTEST
from gearbox_monitor.recordings.table import Column, JOINT_LIST, load_table, Table, VECTOR

FOLLOWED = 0.7  # correlation of a position with its setpoint, at least
TOGETHER = 0.9  # correlation of the two ends of a gear, at least
EXACT, OF_STEP = 1e-6, 0.05  # of the spread, of the own lattice: an encoder rounds by 0.29
LEAST, ROWS = 20, 20_000  # rows that are compared
STATED = 'as stated'
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
            choice.take(role, fitting[0], STATED)
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
                or 'A' in map(vocabulary()['inputs'].get, f.first.words)]
    if measured and not torques and len(currents) == 1:
        best = currents
    if len(best) > 1:
        choice.ask_for('effort', best, "efforts of one joint, and no name tells which is the "
                       "motor's")
    else:
        choice.take('motor_effort', best[0], '' if measured else 'commanded, the only effort')


ISO = 'iso8601'
NANO = frozenset('nsec nsecs nanosec nanosecs nanoseconds nano nanos'.split())
SECONDS = frozenset('sec secs seconds s'.split())
MEASUREMENT = frozenset('header stamp stamps'.split())  # words of when it was measured
RECEIPT = frozenset('received receive log publish bag wall'.split())
EPISODES = ('episode_index', 'episode')
TABLES = ('.csv', '.csv.gz', '.parquet', '.npz', '.txt')
OVERLAP = 0.5  # of the time of the states, in which setpoints of the same run stand
BESIDE = 'setpoint: '  # in front of the names of columns of such a file
STEADY = 0.5  # of the mean step: spread of the steps of what grows like a time without a name
COARSER = {'ms': 's', 'us': 'ms', 'ns': 'us'}
USUAL = 0.1  # s, longest sample time in a unit that nothing states, and a thousandth of it in ms


@dataclass(frozen=True)
class FoundTime:
    """
    Times [N] in s from 0, their block of the mapping, the labels of their columns and remarks.

    start: first time on the recording's own clock, s; named: a column holds them, no rate.
    """

    t: Array
    block: dict[str, Any]
    labels: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    start: float = 0.0
    named: bool = True

    @property
    def end(self) -> float:
        """Last time on the recording's own clock, s."""
        return self.start + float(self.t[-1])


def found_time(path: Path, columns: Sequence[Column], units: Mapping[str, str], name: str = ''
               ) -> FoundTime | None:
    """
    Return the FoundTime of a recording, None where no column grows like one.

    Dates come before names, a measurement's stamp before other times, and all of them before what
    only grows steadily; what counts rows, or is measured by its name, is never a time.

    Args:
        path: of the recording, for messages.
        columns: of it.
        units: {label: unit} as the user states them.
        name: of the column, as the user states it; '' for none.
    """
    quantity = {c.name: meaning_of(c.name, c.unit).quantity for c in columns}
    episode = _episode(columns)
    candidates = [c for c in columns if c.name == name or not name and (
        _is_date(c) or c.values.dtype.kind in 'iuf' and quantity[c.name] in (TIME, '')
        and c is not episode and not NANO & set(words_of(c.name)))]
    time: FoundTime | None = None
    for column in sorted(candidates, key=lambda c: -_rank(c, quantity[c.name])):
        is_named = quantity[column.name] == TIME or _is_date(column) or column.name == name
        if time is None or is_named:
            this = _as_time(path, column, columns, units.get(column.name, ''), is_named, episode)
            if this and time:
                return replace(time, remarks=(*time.remarks,
                                              f'{column.name}: another time, not used.'))
            time = time or this
    return time


def at_rate(rate: float, columns: Sequence[Column]) -> FoundTime:
    """Return the FoundTime of `columns` [N] that are sampled at a constant `rate`, Hz."""
    episode = _episode(columns)
    labels = () if episode is None else (episode.name,)
    return FoundTime(np.arange(len(columns[0].values)) / rate,
                     {'rate': rate, **dict(zip(['segment'], labels))}, labels, named=False)


def _episode(columns: Sequence[Column]) -> Column | None:
    """Return the column that tells episodes apart, None without several."""
    return next((c for c in columns if c.name in EPISODES and len(np.unique(c.values)) > 1), None)


def _is_date(column: Column) -> bool:
    return column.values.dtype.kind in 'UM'


def _rank(column: Column, quantity: str) -> float:
    """Return how much speaks for `column` as the time of the measurement."""
    words = set(words_of(column.name))
    stamp = 1.0 + 0.5 * len(words & MEASUREMENT) if words & MEASUREMENT else 0.0
    return stamp - 1.5 * bool(words & RECEIPT) + (
        4.0 if _is_date(column) else 2.0 if quantity == TIME else 0.0)


def _as_time(path: Path, column: Column, columns: Sequence[Column], stated: str, is_named: bool,
             episode: Column | None) -> FoundTime | None:
    """Return `column` as a time in the unit that makes sense, None: in none."""
    values = column.values
    rows = np.isfinite(values) if values.dtype.kind == 'f' else np.full(len(values), True)
    if rows.mean() < 0.5:
        return None
    units, others = _units(column, stated), dict[str, str]()
    nano = _nanoseconds_of(column, columns) if is_named and units != [ISO] else None
    if nano is not None:
        units, others['nanosec'] = ['s'], nano.name
    starts = np.zeros(rows.sum() - 1, bool)
    if episode is not None and len(episode.values) == len(rows):
        starts = np.diff(episode.values[rows]) != 0
        if starts.any():
            others['segment'] = episode.name
    own = stated or column.unit
    for unit in units:
        with suppress(InputError):
            stamps = _stamps_in(path, unit, column, nano, rows)
            sure = is_named and (unit in (own, ISO) or nano is not None or stamps[0] >= EPOCH)
            even = _is_even(stamps, starts, is_named, LONGEST if sure else USUAL)
            if even is not None:
                break
    else:
        return None
    step = float(np.median(np.diff(stamps)[~starts])) * 1e-9
    _require_one_run(path, column, columns, rows, (np.diff(stamps) < 0) & ~starts)
    if is_named and not sure and unit in COARSER and USUAL < 1e3 * step < LONGEST:
        raise Undecided(f'{path}: {column.name}: no unit, one sample per {step:.4g} s in {unit}, '
                        f'expected --unit {shlex.quote(column.name)}={COARSER[unit]} or ={unit}')
    scale = _factor(column, unit)
    block = {'column': column.name, **{key: value for key, value in (
        ('unit', unit), ('scale', scale), ('stamps', 'even' * even)) if value not in (
            's', 1.0, '')}, **others}
    how = ('steady growth', 'name')[is_named]
    remarks = [f'Time: {column.name}, by its {how}, in {unit}: one sample per {step:.6g} s.']
    if own in units_of(TIME) and unit != own:
        remarks.append(f'Its name says {own}, at which the sample time makes no sense.')
    steps = np.where(starts, 1e9, np.diff(stamps))
    t = np.interp(np.arange(len(rows)), np.flatnonzero(rows),
                  np.append(0.0, np.cumsum(steps)) * 1e-9)
    return FoundTime(t, block, (column.name, *others.values()), tuple(remarks),
                     float(stamps[0]) * 1e-9)


def _require_one_run(path: Path, column: Column, columns: Sequence[Column], rows: Flags,
                     starts: Flags) -> None:
    """Raise Undecided if a column changes where the time in `column` `starts` again."""
    runs = [c.name for c in columns if starts.any() and len(c.values) == len(rows)
            and np.array_equal(c.values[rows][1:] != c.values[rows][:-1], starts)]
    if runs:
        raise Undecided(f'{path}: {column.name}: starts again where {runs[0]} changes, expected a '
                        f'file of one of them, or --map with time.segment: {runs[0]}')


def _units(column: Column, stated: str) -> list[str]:
    """Return the unit `stated`, else all but minutes, first that of the column, then seconds."""
    known = units_of(TIME)
    if column.values.dtype.kind == 'U':
        return [ISO]
    if stated in known or column.factor != 1.0:
        return [stated or column.unit]
    return sorted({*known} - {'min'} | {column.unit} & {*known}, key=lambda unit: (
        unit != column.unit, [*known].index(unit)))


def _factor(column: Column, unit: str) -> float:
    """Return the factor of a `unit` in a column: 100 of '[100ns]'."""
    return column.factor if unit == column.unit else 1.0


def _stamps_in(path: Path, unit: str, column: Column, nano: Column | None, rows: Flags) -> Array:
    """Return the `rows` of a column in a unit, with nanoseconds, in ns. Raises InputError."""
    mapping = TimeMapping(unit=unit, scale=_factor(column, unit))
    stamps = absolute_ns(path, column.values[rows], mapping, str)
    if nano is not None:
        stamps = stamps + absolute_ns(path, nano.values[rows], TimeMapping(unit='ns'), str)
    return stamps.astype(float)


def _nanoseconds_of(column: Column, columns: Sequence[Column]) -> Column | None:
    """Return the column of the nanoseconds that belong to the seconds in `column`, if any."""
    words = set(words_of(column.name))
    return next((other for other in columns if words & SECONDS
                 and len(other.values) == len(column.values) and NANO & set(words_of(other.name))
                 and set(words_of(other.name)) - NANO - SECONDS == words - SECONDS), None)


def _is_even(stamps: Array, starts: Flags, is_named: bool, longest: float) -> bool | None:
    """
    Return whether `stamps` want an even grid, as if stamped on receipt; None: no times.

    longest: usual distance of times, s. They may start again, seldom.
    """
    step = np.diff(stamps)[~starts]
    if len(stamps) < 3 or not len(step):
        return None
    median = float(np.median(step)) * 1e-9
    bursts = bool(is_named and median < SHORTEST and (step >= 0).all())
    if bursts:  # stamped on receipt: the mean tells the rate
        median = float(np.mean(step)) * 1e-9
    refused = not SHORTEST <= median < longest * 1.001 or (step < 0).mean() > 0.01 or (
        (step == 0).mean() > 0.3 and not bursts) or (
        not is_named and np.std(step) > STEADY * np.mean(step))
    return None if refused else bursts


# --- setpoints of a robot in a file of their own, on the same clock ----------------------------
def _files_beside(path: Path, setpoints: bool) -> list[Path]:
    """Return the files with `setpoints`, or states, of the run whose other ones `path` holds."""
    own, run = run_of(path.name.partition('.')[0])
    return [] if own == setpoints else sorted(
        file for file in path.absolute().parent.iterdir() if file.suffixes == path.suffixes
        and file.is_file() and run_of(file.name.partition('.')[0]) == (setpoints, run))


Motion: TypeAlias = tuple[Table, FoundTime, dict[str, Column]]  # position of each joint


def _motion_of(table: Table, foreign: str | None = None) -> Motion | None:
    """Return the positions in a table; None: no time, or one whose source is `foreign`."""
    time = found_time(table.path, table.columns, {})
    if time is None or not time.named:
        return None
    columns = [c for c in table.columns if c.values.dtype.kind in 'iuf'
               and c.name not in time.labels]
    listed = meanings([c.name for c in columns], [c.unit for c in columns], table.joints)
    positions = [(m, c) for m, c in zip(listed, columns) if m.quantity == POSITION]
    return None if any(m.source == foreign for m, _ in positions) else (
        table, time, {m.joint: c for m, c in positions})


def _motions_beside(table: Table, setpoints: bool) -> list[Motion]:
    """Return the motions of the same joints and time in files beside, of `setpoints` or states."""
    files, fitting = _files_beside(table.path, setpoints), []
    own = _motion_of(table, SETPOINT if setpoints else None) if files else None
    for file in files if own and len(own[2]) > 1 else ():
        with suppress(InputError):
            sibling = _motion_of(load_table(file, whole=True))
            if own and sibling and set(sibling[2]) == set(own[2]) and min(
                    own[1].end, sibling[1].end) - max(own[1].start, sibling[1].start) >= (
                    OVERLAP * (own[1].end - own[1].start)):
                fitting.append(sibling)
    return fitting


def states_beside(table: Table) -> str:
    """Return the name of a file with the states whose setpoints a table holds, '' for none."""
    return next((sibling.path.name for sibling, *_ in _motions_beside(table, False)), '')


def with_setpoints(table: Table) -> Table:
    """
    Return the `table` of a robot's states with the setpoints in a file beside it, if there is one.

    The names of their columns begin with BESIDE. Raises Undecided: several files have them.
    """
    fitting = _motions_beside(table, True)
    names = ', '.join(sibling.path.name for sibling, *_ in fitting)
    if len(fitting) > 1:
        raise Undecided(f'{table.path}: {names}: setpoints of the same joints and time beside it, '
                        'expected --use setpoint=none, or one of the files')
    for sibling, time, positions in fitting:
        table = load_table(table.path, whole=True) if table.streamed else table
        clocks = [c for c in sibling.columns if c.name in time.labels]
        table = replace(table, rows=None, streamed=False, columns=(*table.columns, *(
            replace(c, name=BESIDE + c.name) for c in clocks), *(
            replace(c, name=BESIDE + c.name, clock=BESIDE + time.labels[0])
            for c in positions.values())),
            notes=(*table.notes, f'setpoints: {names} beside it, on the same clock'))
    return table


def file_in(path: Path) -> Path:
    """Return the file of a recording: `path`, or the only one in the folder `path`."""
    if not path.is_dir():
        return path
    files = sorted(path.glob('data/**/*.parquet'))
    if not files:  # episodes, those with setpoints beside, or all tables
        tables = sorted(file for file in path.iterdir() if file.is_file()
                        and file.name.endswith(TABLES) and file.name != JOINT_LIST)
        files = [file for file in tables if _files_beside(file, True)] or tables
    if not files:
        raise InputError(f'{path}: holds no .mcap or .db3 file and no log, expected a recording')
    if len(files) != 1:
        names = ', '.join(file.name for file in files[:12])
        raise Undecided(f'{path}: {len(files)} recordings, expected the path of one of them: '
                        f'{names}')
    return files[0]
