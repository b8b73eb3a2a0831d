# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Propose the mapping of a table: names and units decide, questions settle the rest.

Each question comes with the option that settles it, one for a whole group of columns.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import re
from statistics import median
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.errors import expect, InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.mapping import kind_of, OF_TIME, TURN, with_settings
from gearbox_monitor.recordings.meaning import (
    axis_of, COUNTS, EFFORT, FROM_0, joints_of, known_words, Meaning, meaning_of, meanings,
    POSITION, PRISMATIC, ROTARY, SETPOINT, SI, standard_unit, strange_unit, unit_factor,
    unit_of_label, units_of, VELOCITY, vocabulary, words_of)
from gearbox_monitor.recordings.roles import (
    at_rate, BESIDE, Choice, choice_of, common_rows, families_of, Family, found_time, FoundTime,
    matches, NAMES, NONE, OpenQuestion, STATED, states_beside, use_option)
from gearbox_monitor.recordings.table import Table, VECTOR

COARSE = 100.0  # whole numbers over a wider range are counts
WIDE = 4.0 * np.pi  # rad: a joint turns less; a wider range without a unit may be degrees
USUAL = 0.005, 0.995  # quantiles: a glitch beyond them says nothing about the unit
LOOKED = 1 << 20  # rows that a guess looks at
MOST_JOINTS = 1000  # that q[6] in --columns may stand for
GEARED = 0.2  # from 1: lost motion and noise make a ratio of 1 look that different
BLANK = 0.05  # share of empty cells from which on curves have samples of their own
APART = 3.0   # times: a velocity that differs as much from the derivative has another unit
STILL = 20.0  # steps from row to row: a range below is noise
POSITIONS = ('motor_position', 'arm_position')
OF_ROBOT = (('position', ('arm_position', 'motor_position')),
            ('velocity', ('arm_velocity', 'motor_velocity')), ('effort', ('motor_effort',)),
            ('setpoint', ('motor_setpoint',)))
OF_TABLE = {'motor': 'motor_position', 'arm': 'arm_position', 'u': 'motor_effort',
            'torque': 'motor_effort', 'setpoint': 'motor_setpoint', 'arm_torque': 'arm_effort'}
OF_ROBOT_TABLE = {'q': 'position', 'v': 'velocity', 'setpoint': 'setpoint', 'i': 'effort',
                  'tau': 'effort'}


@dataclass(frozen=True)
class Answers:
    """
    What a user states about a recording.

    use {role: column, or 'none'}; units {role, column or joint: unit}; torque_constants: N m per A
    (or per other unit of the effort) of all joints, or of each; counts: per turn; joint: that
    alone; columns: names of all columns, 'q[6]' for q_1 to q_6; rate, Hz; episode: of a dataset.
    """

    use: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    torque_constants: Sequence[float] = ()
    counts: float | None = None
    joint: str | None = None
    columns: str = ''
    rate: float | None = None
    episode: int | None = None
    stamps: str = ''


NO_ANSWERS = Answers()


@dataclass(frozen=True)
class Guess:
    """
    A proposed mapping: plain `data`, what it assumes, what is open, and the columns.

    rows: (column or family of them, role, unit, why). notes: what every command says of it.
    """

    source: str
    data: Mapping[str, Any]
    assumptions: tuple[str, ...]
    questions: tuple[OpenQuestion, ...] = ()
    rows: tuple[tuple[str, str, str, str], ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def yaml_text(self) -> str:
        """Return the mapping as a file, its assumptions and questions as comments."""
        lines = [f'# {line}' for line in (
            f'Proposed for {self.source}.', *self.assumptions, *self.notes,
            *(f'Open: {question}' for question in self.questions))]
        return '\n'.join(lines) + '\n' + yaml.safe_dump(
            dict(self.data), sort_keys=False, default_flow_style=None, allow_unicode=True)


class Unsettled(Undecided):
    """The questions of a `guess`, which is what was recognised of a recording."""

    def __init__(self, guess: Guess) -> None:
        super().__init__(*(f'{guess.source}: {question}' for question in guess.questions))
        self.guess = guess


def guessed(table: Table, settings: Sequence[str] = (), answers: Answers = NO_ANSWERS,
            constants: bool = True) -> Guess:
    """
    Return the Guess of a mapping for a table.

    Args:
        table: of the recording.
        settings: ``KEY=VALUE`` that replace what is proposed.
        answers: what the user states.
        constants: whether a current needs a constant here; a model may have it.

    Raises:
        InputError: the file holds no motion that can be recognised.
        Undecided: its columns have no names, or none of them is a time.
    """
    if answers == NO_ANSWERS and (data := _of_names(table)):
        return Guess(table.path.name, with_settings(data, settings), (), notes=_other_efforts(
            [meaning_of(c.name, c.unit) for c in table.columns], repr(data)))
    return _Proposal(table, settings, answers, constants).guess()


def _of_names(table: Table) -> dict[str, Any]:
    """Return the mapping of a table in this package's own names and SI, {} for another one."""
    names = [column.name for column in table.columns]
    if 't' not in names or table.joints:
        return {}
    data: dict[str, Any] = {'time': {'column': 't'}}
    if {'motor', 'arm'} & set(names):
        if {'u', 'torque'} <= set(names):
            raise InputError(f'{table.path}: torque: stands with u, expected one of them')
        return data | {'signals': {OF_TABLE[name]: {'column': name} for name in names
                                   if name in OF_TABLE}}
    joints: dict[str, dict[str, Any]] = {}
    for name in sorted(names, key=lambda name: name.startswith('tau_')):
        prefix, _, joint = name.partition('_')
        if prefix in OF_ROBOT_TABLE and joint:
            joints.setdefault(f'joint_{joint}' if joint.isdigit() else joint, {})[
                OF_ROBOT_TABLE[prefix]] = {'column': name, **(
                    {'unit': 'A'} if prefix == 'i' else {})}
    placed = {joint: own for joint, own in joints.items() if 'position' in own}
    driven = {joint for joint, own in joints.items() if {'effort', 'setpoint'} & set(own)}
    plain = driven <= set(placed) and all(meaning_of(own['position']['column']).source in (
        '', 'measured') for own in placed.values())
    return data | {'joints': placed} if driven and plain else {}


class _Proposal:
    """
    The steps from a table to its Guess, and what they gather.

    joints: of a robot, or '' alone; axes {joint: axis}; units {column: unit of the mapping}; used:
    options that had an effect.
    """

    def __init__(self, table: Table, settings: Sequence[str], answers: Answers, constants: bool
                 ) -> None:
        table = replace(table, columns=tuple(replace(c, values=c.values[:LOOKED])
                                             for c in table.columns))
        self.table, self.originals = _renamed(table, answers.columns)
        self.settings, self.answers, self.needs_constants = settings, answers, constants
        self.columns = {column.name: column for column in self.table.columns}
        self.assumptions: list[str] = []
        self.units: dict[str, str] = {}
        self.used: set[str] = set()
        for name, unit in answers.units.items():
            if unit != NONE and not standard_unit(unit):
                known = dict.fromkeys(u for q in vocabulary()['units'] for u in units_of(q))
                raise InputError(f'--unit {name}={unit}: unknown unit, expected one of '
                                 + ', '.join(known))
        self.time = self._time()
        self.listed, self.values = self._meanings()
        joints = joints_of(self.listed)
        one = self._selected(joints)
        self.robot = one is None and len(joints) > 1
        self.joints = [joint for joint in joints if joint] if self.robot else ['']
        self.constants = self._constants(joints, one)
        self.choice = self._choice(joints, one)
        if self.robot:
            self._ask_of_joints()
        otherwise = PRISMATIC if 'kind=prismatic' in settings else ROTARY
        self.axes = {joint: axis_of((
            self._stated_unit(role, m) or m.unit for role, family in self.choice.roles.items()
            if (m := family.columns.get(joint))), otherwise) for joint in self.joints}

    def guess(self) -> Guess:
        """Return the Guess."""
        table, blocks = self.table, self._blocks()
        data: dict[str, Any] = {'time': self.time.block, **(
            {'kind': PRISMATIC} if set(self.axes.values()) == {PRISMATIC} else {})}
        data |= {'joints': blocks} if self.robot else {'signals': blocks['']}
        self._grippers(blocks)
        self._own_clocks(blocks)
        states = states_beside(table)
        if self.robot and states and 'motor' not in self.answers.use:
            self.choice.ask('motor', f'setpoints by the name of the file, {states} beside it has '
                            'the positions of the run', f'import {states}, or --use motor=COLUMN')
        self._require_effect()
        rows = self._rows()
        unused = [row[0] for row in rows if not row[1]]
        if unused:
            self.assumptions.append(f'Not used: {", ".join(unused)[:400]}.')
        data = _as_in_file(data, dict(zip(self.columns, self.originals)))
        first = next((m for m in self.listed if m.why.endswith(FROM_0)), None)
        notes = [f'{first.stem}: {FROM_0}, taken in order: {first.label} is of {first.joint}'] \
            if first else []
        return Guess(table.path.name, with_settings(data, self.settings), tuple(self.assumptions),
                     tuple(self.choice.questions.values()), tuple(rows), (
                         *notes, *_other_efforts(self.listed, repr(data))))

    def _meanings(self) -> tuple[list[Meaning], dict[str, Array]]:
        """Return what the columns of numbers mean, and their values by label."""
        clocks = {column.clock for column in self.table.columns}
        columns = [c for c in self.table.columns if c.name not in (*self.time.labels, *clocks)
                   and (c.clock or not c.name.startswith(BESIDE))
                   and c.values.dtype.kind in 'iuf' and np.isfinite(c.values.astype(float)).any()]
        listed = []
        for beside in (False, True):
            own = [c for c in columns if c.name.startswith(BESIDE) == beside]
            found = meanings([c.name.removeprefix(BESIDE) for c in own], [
                self.answers.units.get(c.name, c.unit) for c in own], self.table.joints)
            listed += [replace(m, label=BESIDE + m.label, source=SETPOINT) for m in found] \
                if beside else found
        return listed, {c.name: np.where(np.isfinite(x := c.values.astype(float)), x, np.nan)
                        for c in columns}

    def _choice(self, joints: Sequence[str], one: str | None) -> Choice:
        """Return the Choice among the columns of all `joints`, or of `one`. Raises InputError."""
        moving = {name for name, x in self.values.items() if np.nanmax(x) > np.nanmin(x)}
        columns = [m for m in self.listed if (
            m.joint in self.joints if self.robot else m.label in moving and m.joint in (
                ['', *joints] if one is None else [one]))]
        choice = choice_of(families_of(columns, self.robot), self.values, self._use())
        if 'positions' in choice.questions or any(
                role.endswith(('position', 'velocity')) for role in choice.roles):
            return choice
        still = [m.label for m in self.listed if m.quantity in (POSITION, VELOCITY)
                 and m.label not in moving]
        problem = f'{", ".join(still)[:200]} never changes' if still else 'no position or ' \
            f'velocity among {", ".join(self.values)[:200] or "none"}'
        raise InputError(f'{self.table.path}: {problem}, expected a motion, ' + '; '.join([
            '--use position=COLUMN, or --map', *self.table.notes]))

    def _ask_of_joints(self) -> None:
        """Ask about columns without a joint, and about matrices of more or fewer joints."""
        rotary = any(m.unit in units_of(POSITION, ROTARY) for m in self.listed if m.joint)
        alone = [m.label for m in self.listed if m.moves and not m.joint
                 and vocabulary()['poses'].isdisjoint(words_of(m.label))
                 and not (rotary and axis_of([m.unit]) == PRISMATIC)]
        if alone:
            self.choice.ask('joint', f'{", ".join(alone)[:200]}: no joint in the name, beside '
                            f'those of {", ".join(self.joints)[:200]}', '--columns with names of '
                            'joints, such as q_a, or --joint NAME')
        self._ask_of_matrices()

    def _ask_of_matrices(self) -> None:
        """Ask about a matrix, counted from 1 by its reader, with other columns than positions."""
        labels, sizes = [m.label for m in self.listed], dict[str, int]()
        for role, family in self.choice.roles.items():
            matrix = VECTOR.sub('', family.first.label)
            own = {label for label in labels if VECTOR.sub('', label) == matrix != label}
            if own and {VECTOR.findall(label)[0][1:] for label in own} == {
                    str(k + 1) for k in range(len(own))}:
                sizes[role] = len(own)
        joints = next((sizes[role] for role in POSITIONS if role in sizes), 0)
        for role, size in sizes.items():
            if joints not in (0, size) and self.choice.reasons[role] != STATED:
                column, name = self.choice.roles[role].first, _names_of(role)[1]
                self.choice.ask(role, f'{column.stem}: {len(self.values[column.label])} rows of '
                                f'{size} columns, expected {joints}, one of each joint',
                                use_option(name, NONE), use_option(name, column.stem))

    def _is_set(self, key: str) -> bool:
        """Return whether a setting has this key."""
        return any(text.startswith(f'{key}=') for text in self.settings)

    # --- what the user states ------------------------------------------------------------------
    def _time(self) -> FoundTime:
        """Return the time of the recording. Raises Undecided: it has none, or no names at all."""
        answers, table = self.answers, self.table
        if not table.named and not answers.columns:
            raise Undecided(f'{table.path}: {len(table.columns)} columns without names, expected '
                            "their names in order: --columns 't,q[6],dq[6],i[6]' (q[6]: q_1 to "
                            'q_6; - for a column that is not used)')
        units = {name: standard_unit(unit) for name, unit in answers.units.items()}
        columns = [c for c in table.columns if not c.name.startswith(BESIDE)]
        if 'time' in units:
            units.update({column.name: units['time'] for column in columns})
        clock = next((c.clock for c in columns if c.clock), '')
        time = None if answers.rate else found_time(
            table.path, columns, units, answers.use.get('time', clock))
        rate = answers.rate or table.rate
        if time is None and rate is None:
            raise Undecided(f'{table.path}: no column of '
                            f'{", ".join(c.name for c in table.columns)[:200]} grows like a time, '
                            + '; '.join(('expected one, or --rate HZ', *table.notes)))
        if time is None:
            expect(rate, 'time.rate', str(table.path), OF_TIME['rate'])
            time = at_rate(float(rate or 0.0), table.columns)
        elif answers.stamps:
            time.block['stamps'] = answers.stamps
        if answers.episode is not None and 'segment' in time.block:
            time.block['only'] = answers.episode
        self.assumptions += time.remarks
        return time

    def _selected(self, joints: Sequence[str]) -> str | None:
        """Return the joint that the user has selected, None without; raises InputError."""
        joint = self.answers.joint
        if joint is None or joint in joints:
            return joint
        fitting = [name for name in joints if name == f'joint_{joint}' or name.endswith(
            f'_{joint}')]
        if len(fitting) == 1:
            return fitting[0]
        raise InputError(f'--joint {joint}: expected one of {", ".join(joints) or "none"}')

    def _constants(self, joints: Sequence[str], one: str | None) -> dict[str, float]:
        """Return {joint: its torque constant} as stated. Raises InputError: another number."""
        constants, joints = self.answers.torque_constants, joints or ['']
        if len(constants) not in (0, 1, len(joints)):
            names = f' or {len(joints)}, one of each joint ({", ".join(joints)})' \
                if len(joints) > 1 else ''
            raise InputError(f'--torque-constant: {len(constants)} constants '
                             f'({", ".join(f"{constant:g}" for constant in constants)}), expected '
                             f'1{names}')
        own = dict(zip(joints, constants if len(constants) > 1 else [*constants] * len(joints)))
        return own if self.robot or not own else {'': own[joints[0] if one is None else one]}

    def _use(self) -> dict[str, str]:
        """Return {role: name of its column} as the user states them. Raises InputError."""
        use = {NAMES.get(name, name): column for name, column in self.answers.use.items()
               if name != 'time'}
        for name, column in self.answers.use.items():
            if name != 'time' and NAMES.get(name, name) not in NAMES.values():
                raise InputError(f'--use {name}={column}: no such role, expected one of time, '
                                 f'{", ".join(NAMES)}')
            if not (column in self.columns if name == 'time' else column == NONE or any(
                    matches(column, m) for m in self.listed)):
                stems = self.columns if name == 'time' else dict.fromkeys(
                    m.stem for m in self.listed)
                raise InputError(f'--use {name}={column}: no such column, expected one of '
                                 f'{", ".join(stems)[:400]}')
        return use

    def _stated_unit(self, role: str, column: Meaning) -> str:
        """Return the unit of a column in a `role` as the user states it, '' if not."""
        names = [column.label, column.stem, column.joint, *_names_of(role)]
        name = next((n for n in names if self.answers.units.get(n, NONE) != NONE), None)
        unit = '' if name is None else standard_unit(self.answers.units[name])
        foreign = name == column.joint and unit not in units_of(kind_of(role).quantity)
        return '' if foreign else unit

    # --- units ----------------------------------------------------------------------------------
    def _units_of(self, role: str, family: Family) -> dict[str, str]:
        """Return {joint: unit} of the columns in a `role`; ask where names and values leave it."""
        quantity, units = kind_of(role).quantity, dict[str, str]()
        for joint, m in family.columns.items():
            axis, stated = self.axes[joint], self._stated_unit(role, m)
            units[joint] = stated or m.unit
            if units[joint] not in ('', *units_of(quantity, axis, 'input')):
                if stated not in ('', m.unit):
                    raise InputError(f'--unit: {m.label}: {stated}, expected a unit of {quantity} '
                                     f'on a {axis} axis: {", ".join(units_of(quantity, axis))}')
                units[joint] = ''
        silent = [joint for joint, unit in units.items() if not unit]
        if silent and len(silent) < len(units) and quantity == POSITION:
            known = next(filter(None, units.values()))
            self.choice.ask('unit', f'{family.columns[silent[0]].label}: no unit in the file, '
                            f'beside others in {known}', f'--unit {silent[0]}={known}')
        elif silent:
            units |= dict.fromkeys(silent, self._unit_by_words(
                role, [family.columns[joint] for joint in silent], self.axes[silent[0]]))
        self.units |= {family.columns[joint].label: unit for joint, unit in units.items()}
        return units

    def _unit_by_words(self, role: str, columns: Sequence[Meaning], axis: str) -> str:
        """Return the unit of `columns` alike that state none, '' for SI or where it is asked."""
        first, label, quantity = columns[0], columns[0].label, kind_of(role).quantity
        values = [self._finite(m.label) for m in columns]
        strange = strange_unit(label)
        words = set(words_of(strange))
        if strange and (words & vocabulary()['unit_words'] or not words & {
                *known_words(), *first.own_words}):
            self.choice.ask(f'unit {strange}', f'{label}: [{strange}] is no unit that is known',
                            f'--unit {quantity}=UNIT')
        elif quantity == EFFORT and first.is_input and role != 'reference_torque':
            usual = next((u for w, u in vocabulary()['inputs'].items() if w in first.words), '')
            return 'counts' if _are_counts(values) else usual or '1'
        elif quantity == POSITION and _are_counts(values):
            self.assumptions.append(f'{label}: whole numbers, so counts.')
            return 'counts'
        elif quantity == POSITION and axis == ROTARY and 'positions' not in self.choice.questions:
            width, label = max((float(np.ptp(np.quantile(x, USUAL))), m.label)
                               for x, m in zip(values, columns))
            if width > WIDE:
                self.choice.ask('unit', f'{label}: no unit in the file, and its range of '
                                f'{width:.4g} is wide for rad', '--unit position=deg (or turns, '
                                'or rad)')
        return ''

    def _finite(self, label: str) -> Array:
        values = self.values[label]
        return values[np.isfinite(values)]

    def _ask_signed(self, label: str, key: str) -> None:
        """Ask whether whole numbers that jump across their range are signed ones."""
        values = self._finite(label)
        for bits in (16, 32) if _are_counts([values]) and values.min() >= 0 else ():
            full = 2.0 ** bits
            if values.max() < full and (np.abs(np.diff(values)) > full / 2).any() and (
                    not self._is_set(f'{key}.bits')):
                self.choice.ask('bits', f'{label}: whole numbers that jump between 0 and '
                                f'{full:.0f}', f'--set {key}.bits={bits} if they are signed '
                                'integers')

    # --- blocks of the mapping ------------------------------------------------------------------
    def _blocks(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return {joint: {signal: its block}} of all joints."""
        roles = self._roles()
        blocks: dict[str, dict[str, dict[str, Any]]] = {joint: {} for joint in self.joints}
        for name, role in roles.items():
            family = self.choice.roles[role]
            for joint, unit in self._units_of(role, family).items():
                label, first = family.columns[joint].label, next(iter(blocks[joint].values()), {})
                if role == 'motor_setpoint':
                    unit = unit or first.get('unit', '')
                    if unit in COUNTS and first.get('unit') not in COUNTS:
                        self.assumptions.append('The setpoint is in counts of no encoder that is '
                                                'used: left out.')
                        continue
                key = f'joints.{joint}.{name}' if self.robot else f'signals.{name}'
                column = self.columns[label]
                block = blocks[joint][name] = {'column': label, **({'unit': unit} if unit else {})}
                if column.factor != 1.0 and unit == column.unit:
                    block['scale'] = column.factor
                self._ask_signed(label, key)
                self._second_factor(block, role, joint, key)
        for name in ('position', *POSITIONS):
            velocity = name.replace('position', 'velocity')
            if name in roles and velocity in roles:
                why = self._contradiction(blocks, name, velocity)
                if why:
                    family = self.choice.roles.pop(roles[velocity])
                    self.choice.leave([family], f'{why}{family.stem}=UNIT')
                    for own in blocks.values():
                        own.pop(velocity, None)
        if not self.robot and all(name in roles for name in POSITIONS):
            self._ratio(blocks[''])
        return {joint: own for joint, own in blocks.items() if own or not self.robot}

    def _roles(self) -> dict[str, str]:
        """Return {signal of the mapping: role}; of a robot's encoders that of most joints."""
        found = self.choice.roles
        if not self.robot:
            return {role: role for role in sorted(found, key=lambda role: (
                *POSITIONS, role).index(role))}
        return {name: max(own, key=lambda role: len(found[role].columns))
                for name, options in OF_ROBOT if (own := [r for r in options if r in found])}

    def _second_factor(self, block: dict[str, Any], role: str, joint: str, key: str) -> None:
        """Add what makes SI of an input or of counts to a signal's `block`, or ask for it."""
        unit, effort = block.get('unit', ''), kind_of(role).quantity == EFFORT
        stem, rotary = self.choice.roles[role].stem, self.axes[joint] == ROTARY
        if self._is_set(f'{key}.scale') or (
                unit not in (units_of(EFFORT, 'input') if effort else COUNTS)):
            return
        if role == 'reference_torque':
            self.choice.ask('scale', f'{stem}: {unit}, and no torque of one in the file',
                      f'--set {key}.scale=K (N m per unit)')
        elif effort and not self._is_set(f'{key}.torque_constant'):
            if joint in self.constants:
                block['torque_constant'] = self.constants[joint]
                self.used.add('--torque-constant')
            elif self.needs_constants:
                per = 'count' if unit in COUNTS else 'A' if unit in ('A', 'mA') else 'full scale'
                self.choice.ask('constant', f'{stem}: {unit}, and no constant in the file that '
                                f'makes it N m (or N)', f'--torque-constant K (N m per {per}, or '
                                'K1,K2,... of each joint; 1 keeps it, for a model with '
                                'torque_constant), or --use effort=none')
        elif not effort and not self._is_set(f'{key}.counts_per_rev'):
            if self.answers.counts and rotary:
                block['counts_per_rev'] = self.answers.counts
                self.used.add('--counts-per-turn')
            else:
                self.choice.ask('counts', f'{stem}: counts, and no resolution in the file',
                          f'--counts-per-turn N, or --set {key}.counts_per_rev=N' if rotary else
                          f'--set {key}.scale=M (m per count)')

    def _contradiction(self, blocks: Mapping[str, dict[str, dict[str, Any]]], position: str,
                       velocity: str) -> str:
        """
        Return why velocities without a unit are not used, '' if the positions agree with them.

        The block of a position in a known unit gives that of its velocity this unit per second.
        """
        ratios = []
        for joint, own in blocks.items():
            if position not in own or velocity not in own or 'unit' in own[velocity]:
                continue
            per_second = f'{own[position].get("unit")}/s'
            if per_second in units_of(VELOCITY, self.axes[joint]):
                own[velocity]['unit'] = per_second
            moved = self._moved(own[position]['column'], own[velocity]['column'])
            if moved:
                ratios.append(moved[1] * _scale(own[velocity], VELOCITY, self.axes[joint]) / max(
                    moved[0] * _scale(own[position], POSITION, self.axes[joint]), 1e-12))
        ratio = median(ratios) if ratios else 1.0
        return f'no unit, and {ratio:.3g} times the derivative of the position: --unit ' \
            if ratio <= 1.0 / APART or ratio >= APART else ''

    def _moved(self, position: str, velocity: str) -> tuple[float, float] | None:
        """Return the mean speeds by two columns, in their units; None: too little motion."""
        q, v, t = common_rows(self.values[position], self.values[velocity], self.time.t) or \
            np.zeros((3, 1))
        step = 4 * max(1, len(q) // 2000)
        if len(q) < 10 + step or np.ptp(q) < STILL * np.median(np.abs(np.diff(q))):
            return None
        speed: Array = np.abs(q[step:] - q[:-step]) / np.maximum(t[step:] - t[:-step], 1e-9)
        return float(np.mean(speed)), float(np.mean(np.abs(v)))

    def _ratio(self, blocks: Mapping[str, dict[str, Any]]) -> None:
        """Ask for the gear ratio and for a sign, where the two encoders do not move alike."""
        motor, arm = (blocks[role]['column'] for role in POSITIONS)
        slope = robust_slope(self.values[arm], self.values[motor])
        if slope is None:
            return
        if slope < 0.0 and not any(self._is_set(f'signals.{role}.sign') for role in POSITIONS):
            self.choice.ask('sign', f'{arm} runs against {motor}',
                            '--set signals.arm_position.sign=-1 (or 1 if it does so)')
        scales = [_scale(blocks[role], POSITION, self.axes['']) for role in POSITIONS]
        ratio = abs(slope) * scales[0] / scales[1]
        if np.isnan(ratio) or self._is_set('gear_ratio'):
            return
        unit = next((name for name, factor in units_of(POSITION, ROTARY).items() for ends in (
            factor, 1.0 / factor) if factor != 1.0 and abs(ratio / ends - 1.0) < 0.02), '')
        if unit or abs(ratio - 1.0) > GEARED:
            self.choice.ask('ratio', f'the motor moves {ratio:.4g} times as much as the arm' + (
                ', which looks like a unit' if unit else ''), f'--unit motor={unit} (or arm), or '
                '--set gear_ratio=N' if unit else '--set gear_ratio='
                f'{round(ratio) if ratio > 1.5 else 1} (1: both are at the output)')

    def _grippers(self, blocks: dict[str, dict[str, dict[str, Any]]]) -> None:
        """Ask for the unit of a gripper in percent among joints whose unit was stated."""
        for joint in list(blocks) if self.robot else ():
            words, block = set(re.findall(r'[a-z]+', joint.lower())), blocks[joint].get('position')
            if not words & vocabulary()['grippers'] or not block or next(
                    m.unit for m in self.listed if m.label == block['column']):
                continue
            values = self._finite(block['column'])
            low, high = values.min(), values.max()
            if self.answers.units.get(joint) == NONE:
                del blocks[joint]
            elif joint not in self.answers.units and low >= 0.0 and WIDE < high <= 100.0:
                self.choice.ask('gripper', f'{joint}: from {low:.3g} to {high:.3g}, maybe '
                                f'percent of its travel', f'--unit {joint}=none (left out), or '
                                f'--unit {joint}=deg (or m)')

    def _own_clocks(self, joints: Mapping[str, dict[str, dict[str, Any]]]) -> None:
        """Give each signal its own time where curves have their samples in different rows."""
        blocks = [block for own in joints.values() for block in own.values()]
        columns = [self.columns[block['column']] for block in blocks]
        clocks = [self.columns[c.clock].values for c in columns if c.clock]
        beside = found_time(self.table.path, [c for c in self.table.columns if c.name.startswith(
            BESIDE) and not c.clock], {})
        if beside is not None:
            for block in blocks:
                if block['column'].startswith(BESIDE):
                    block['time'] = beside.block
        elif clocks and not all(np.array_equal(clocks[0], own) for own in clocks):
            for block, column in zip(blocks, columns):
                block['time'] = {**self.time.block,
                                 'column': column.clock or self.time.block['column']}
        elif not clocks and self.time.named and any(
                np.isnan(c.values.astype(float)).mean() > BLANK for c in columns):
            for block in blocks:
                block['time'] = dict(self.time.block)
            self.assumptions.append('Empty cells: each curve has its own samples; they are '
                                    'interpolated onto those of the first signal.')

    def _require_effect(self) -> None:
        """Raise InputError: an answer was stated that nothing of the mapping needs."""
        answers, choice = self.answers, self.choice
        if choice.questions:  # whose answers may need it
            return
        names = {*self.time.labels, 'time', *(n for m in self.listed for n in (
            m.label, m.stem, m.joint)), *(n for role in choice.roles for n in _names_of(role))}
        for name, unit in answers.units.items():
            if name not in names:
                raise InputError(f'--unit {name}={unit}: no such role, joint or column, expected '
                                 f'one of {", ".join(sorted(filter(None, names)))[:400]}')
        for option, value, used, why in (
                ('--counts-per-turn', answers.counts, '--counts-per-turn' in self.used,
                 'no signal is in counts'),
                ('--torque-constant', answers.torque_constants or None,
                 '--torque-constant' in self.used, 'no effort needs one'),
                ('--episode', answers.episode, 'segment' in self.time.block,
                 'no column tells episodes apart')):
            if value is not None and not used:
                raise InputError(f'{option}: {why}, expected no such option')

    # --- table ----------------------------------------------------------------------------------
    def _rows(self) -> list[tuple[str, str, str, str]]:
        """Return a line for each column; of columns alike one for all of them."""
        time, choice = self.time, self.choice
        rows = [(', '.join(time.labels) or 'none', 'time', f'{time.block["rate"]:g} Hz'
                 if 'rate' in time.block else str(time.block.get('unit', 's')), 'given'
                 if not time.named else time.remarks[0].partition(', ')[2])]
        roles = {c.label: (role, self.axes[joint]) for role, family in choice.roles.items()
                 for joint, c in family.columns.items()}
        lines: dict[tuple[str, str, str, str], list[str]] = {}
        for m in self.listed:
            role, axis = roles.get(m.label, ('', ''))
            unit, why = m.unit, choice.reasons[role] if role else choice.left.get(m.label) or (
                'no joint in its name' if self.robot and not m.joint and m.quantity in SI[ROTARY]
                else f'{m.source} {m.quantity}'.strip() or 'nothing of a joint')
            if role:
                unit = (self.units.get(m.label) or unit or SI[axis][kind_of(role).quantity]) + (
                    '' if m.stated else '?')
            stem = VECTOR.sub('', m.stem)
            lines.setdefault((stem, role, unit, why), []).append(m.label)
        return rows + [(labels[0] if len(labels) == 1 else f'{labels[0]} ... {labels[-1]}', role,
                        unit, why) for (_, role, unit, why), labels in lines.items()]


def _other_efforts(columns: Sequence[Meaning], used: str) -> tuple[str, ...]:
    """Return a sentence about those efforts among `columns` that the text `used` does not name."""
    own, others = (dict.fromkeys(m.stem for m in columns if m.quantity == EFFORT and m.source in (
        'measured', '') and (repr(m.label) in used) is given) for given in (True, False))
    return (f'effort: {", ".join(own)}; not used: {", ".join(others)[:200]}',) if (
        own and others) else ()


def _are_counts(columns: Sequence[Array]) -> bool:
    """Return whether all of `columns` hold whole numbers, one of them over a wide range."""
    return any(np.ptp(x) > COARSE for x in columns) and all(
        (x == np.floor(x)).all() for x in columns)


def _scale(block: Mapping[str, Any], quantity: str, axis: str) -> float:
    """Return the factor of a block's column to SI, NaN: not known."""
    factor, complete = unit_factor(block['unit'], quantity, axis) if 'unit' in block else \
        (1.0, True)
    if not complete:
        factor = TURN / block.get('counts_per_rev', np.nan)
    return float(factor * block.get('scale', 1.0))


def robust_slope(x: Array, y: Array) -> float | None:
    """Return the slope of y [N] over x [N] that half of all pairs agree on, None: no motion."""
    x, y = common_rows(x, y) or np.zeros((2, 1))
    if np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return None
    order = np.argsort(x, kind='stable')
    third = len(order) // 3
    dx, dy = (values[order[-third:]] - values[order[:third]] for values in (x, y))
    return float(np.median(dy[dx > 0.0] / dx[dx > 0.0])) if (dx > 0.0).any() else None


def _names_of(role: str) -> list[str]:
    """Return what --unit may call a role, the most special name first."""
    return [role, *(name for name in NAMES if NAMES[name] == role), kind_of(role).quantity]


def _as_in_file(data: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return the mapping `data` with the `names` {new: old} of columns that the file has."""
    return {key: names.get(value, value) if key in ('column', 'nanosec', 'segment') else
            _as_in_file(value, names) if isinstance(value, dict) else value
            for key, value in data.items()}


def _renamed(table: Table, columns: str) -> tuple[Table, list[str]]:
    """Return `table` with the names that `columns` gives its columns, and the old ones."""
    if not columns:
        return table, [column.name for column in table.columns]
    names: list[str] = []
    for part in re.split(r',(?![^\[]*\])', columns):
        match = re.fullmatch(r'\s*(.*?)\[(\d+)\]\s*(.*?)\s*', part)
        if match and not 1 <= int(match[2]) <= MOST_JOINTS:
            raise InputError(f'--columns: {part.strip()}, expected 1 to {MOST_JOINTS} in brackets')
        names += [f'{match[1]}_{k + 1} {match[3]}'.strip() for k in range(int(match[2]))] \
            if match else [part.strip()]
    if len(names) != len(table.columns):
        raise InputError(f'{table.path}: --columns names {len(names)} columns, expected '
                         f'{len(table.columns)}, those of numbers: '
                         f'{", ".join(c.name for c in table.columns)[:200]}')
    kept = [(c, name) for c, name in zip(table.columns, names) if name not in ('-', '')]
    return replace(table, named=True, columns=tuple(
        replace(column, name=name, unit=unit_of_label(name)[1], factor=unit_of_label(name)[0])
        for column, name in kept)), [column.name for column, _ in kept]
