# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Propose the mapping of a table: names and units decide, questions settle the rest.

Each question comes with the option that settles it, one for a whole group of columns.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import re
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.errors import expect, InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.mapping import kind_of, OF_TIME, TURN, with_settings
from gearbox_monitor.recordings.meaning import (
    axis_of, COUNTS, EFFORT, joints_of, known_words, Meaning, meaning_of, meanings, POSITION,
    PRISMATIC, ROTARY, SETPOINT, SI, standard_unit, strange_unit, unit_factor, unit_of_label,
    units_of, VELOCITY, vocabulary, words_of)
from gearbox_monitor.recordings.roles import (
    Choice, choice_of, common_rows, matches, NAMES, NONE, OpenQuestion)
from gearbox_monitor.recordings.table import Column, Table
from gearbox_monitor.recordings.times import (
    at_rate, BESIDE, found_time, FoundTime, states_beside)

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

    rows: (column or family of them, role, unit, why).
    """

    source: str
    data: Mapping[str, Any]
    assumptions: tuple[str, ...]
    questions: tuple[OpenQuestion, ...] = ()
    rows: tuple[tuple[str, str, str, str], ...] = ()

    @property
    def yaml_text(self) -> str:
        """Return the mapping as a file, its assumptions and questions as comments."""
        lines = [f'# {line}' for line in (
            f'Proposed for {self.source}.', *self.assumptions,
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
        return Guess(table.path.name, with_settings(data, settings), ())
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
    """The steps from a table to its Guess, and what they gather."""

    def __init__(self, table: Table, settings: Sequence[str], answers: Answers, constants: bool
                 ) -> None:
        table = replace(table, columns=tuple(replace(c, values=c.values[:LOOKED])
                                             for c in table.columns))
        self.table, self.originals = _renamed(table, answers.columns)
        self.settings, self.answers = settings, answers
        self.needs_constants = constants
        self.columns = {column.name: column for column in self.table.columns}
        self.assumptions: list[str] = []
        self.questions: dict[str, OpenQuestion] = {}  # by topic
        self.units: dict[str, str] = {}  # of the mapping, by column
        self.constants: dict[str, float] = {}
        self.used: set[str] = set()  # options that had an effect

    def guess(self) -> Guess:
        """Return the Guess."""
        table, answers = self.table, self.answers
        for name, unit in answers.units.items():
            if unit != NONE and not standard_unit(unit):
                known = dict.fromkeys(u for q in vocabulary()['units'] for u in units_of(q))
                raise InputError(f'--unit {name}={unit}: unknown unit, expected one of '
                                 + ', '.join(known))
        time = self._time()
        clocks = {column.clock for column in table.columns}
        columns = [c for c in table.columns if c.name not in (*time.labels, *clocks)
                   and (c.clock or not c.name.startswith(BESIDE))
                   and c.values.dtype.kind in 'iuf' and np.isfinite(c.values.astype(float)).any()]
        listed = self._meanings([c for c in columns if not c.name.startswith(BESIDE)]) + [
            replace(meaning, label=BESIDE + meaning.label, source=SETPOINT)
            for meaning in self._meanings([c for c in columns if c.name.startswith(BESIDE)])]
        values = {c.name: c.values.astype(float) for c in columns}
        varying = {name for name, x in values.items() if np.nanmax(x) > np.nanmin(x)}
        joints = joints_of(listed)
        joint = self._selected(joints)
        self.constants = self._constants(joints)
        robot = joint is None and len(joints) > 1
        if robot and '' in joints:
            joints.remove('')
            alone = ', '.join(m.label for m in listed if m.moves and not m.joint)
            self._ask('joint', f'{alone[:200]}: no joint in the name, beside those of '
                      f'{", ".join(joints)[:200]}', '--columns with names of joints, such as q_a, '
                      'or --joint NAME')
        use = self._use(listed)
        choices = [choice_of([m for m in listed if (robot or m.label in varying) and (
            m.joint == name or not robot and joint is None)], values, name, use)
            for name in (joints if robot else [joint or ''])]
        for choice in choices:
            for question in choice.questions:
                self.questions.setdefault(question.topic, question)
        if 'positions' not in self.questions and not any(role.endswith(('position', 'velocity'))
                                                         for c in choices for role in c.roles):
            still = [m.label for m in listed if m.quantity in (POSITION, VELOCITY)
                     and m.label not in varying]
            problem = f'{", ".join(still)[:200]} never changes' if still else 'no position or ' \
                f'velocity among {", ".join(values)[:200] or "none"}'
            raise InputError(f'{table.path}: {problem}, expected a motion, ' + '; '.join([
                '--use position=COLUMN, or --map', *table.notes]))
        prismatic = {self._axis(choice) for choice in choices} == {PRISMATIC}
        data: dict[str, Any] = {'time': time.block, **({'kind': PRISMATIC} if prismatic else {})}
        if robot:
            data['joints'] = {choice.joint: self._signals(choice, time.t, True)
                              for choice in choices}
            self._grippers(data, choices)
        else:
            data['signals'] = self._signals(choices[0], time.t, False)
        self._blanks(data, time)
        states = states_beside(table)
        if robot and states and 'motor' not in answers.use:
            self._ask('motor', f'setpoints by the name of the file, {states} beside it has '
                      'the positions of the run', f'import {states}, or --use motor=COLUMN')
        self._require_effect(data, listed, choices, time)
        rows = self._rows(listed, choices, time)
        unused = [row[0] for row in rows if not row[1]]
        if unused:
            self.assumptions.append(f'Not used: {", ".join(unused)[:400]}.')
        data = _as_in_file(data, dict(zip(self.columns, self.originals)))
        return Guess(table.path.name, with_settings(data, self.settings), tuple(self.assumptions),
                     tuple(self.questions.values()), tuple(rows))

    def _meanings(self, columns: Sequence[Column]) -> list[Meaning]:
        return meanings([c.name.removeprefix(BESIDE) for c in columns], [
            self.answers.units.get(c.name, c.unit) for c in columns], self.table.joints)

    def _ask(self, topic: str, text: str, option: str) -> None:
        self.questions.setdefault(topic, OpenQuestion(topic, text, option))

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
                            'expected one, or --rate HZ')
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

    def _constants(self, joints: Sequence[str]) -> dict[str, float]:
        """Return {joint: its torque constant} as stated. Raises InputError: another number."""
        constants, joints = self.answers.torque_constants, joints or ['']
        if len(constants) not in (0, 1, len(joints)):
            names = f' or {len(joints)}, one of each joint ({", ".join(joints)})' \
                if len(joints) > 1 else ''
            raise InputError(f'--torque-constant: {len(constants)} constants '
                             f'({", ".join(f"{constant:g}" for constant in constants)}), expected '
                             f'1{names}')
        return dict(zip(joints, constants if len(constants) > 1 else [*constants] * len(joints)))

    def _use(self, listed: Sequence[Meaning]) -> dict[str, str]:
        """Return {role: name of its column} as the user states them. Raises InputError."""
        use = {NAMES.get(name, name): column for name, column in self.answers.use.items()
               if name != 'time'}
        for name, column in self.answers.use.items():
            if name != 'time' and NAMES.get(name, name) not in NAMES.values():
                raise InputError(f'--use {name}={column}: no such role, expected one of time, '
                                 f'{", ".join(NAMES)}')
            if not (column in self.columns if name == 'time' else column == NONE or any(
                    matches(column, m) for m in listed)):
                stems = self.columns if name == 'time' else dict.fromkeys(m.stem for m in listed)
                raise InputError(f'--use {name}={column}: no such column, expected one of '
                                 f'{", ".join(stems)[:400]}')
        return use

    # --- blocks of the mapping ------------------------------------------------------------------
    def _stated_unit(self, role: str, column: Meaning) -> str:
        """Return the unit of a column in a `role` as the user states it, '' if not."""
        names = [column.label, column.stem, column.joint, *_names_of(role)]
        name = next((n for n in names if self.answers.units.get(n, NONE) != NONE), None)
        unit = '' if name is None else standard_unit(self.answers.units[name])
        foreign = name == column.joint and unit not in units_of(kind_of(role).quantity)
        return '' if foreign else unit

    def _axis(self, choice: Choice) -> str:
        return axis_of((self._stated_unit(role, c) or c.unit for role, c in choice.roles.items()),
                       PRISMATIC if 'kind=prismatic' in self.settings else ROTARY)

    def _block(self, role: str, choice: Choice, key: str) -> dict[str, Any]:
        """Return the block of a signal: its column, unit and scale, or a question about them."""
        meaning, quantity, axis = choice.roles[role], kind_of(role).quantity, self._axis(choice)
        column, label = self.columns[meaning.label], meaning.label
        unit = self._stated_unit(role, meaning) or meaning.unit
        if unit and unit not in units_of(quantity, axis, 'input'):
            if unit != meaning.unit:
                raise InputError(f'--unit: {label}: {unit}, expected a unit of {quantity} '
                                 f'on a {axis} axis: {", ".join(units_of(quantity, axis))}')
            unit = ''
        values = choice.values[label][np.isfinite(choice.values[label])]
        coarse = bool(np.ptp(values) > COARSE and (values == np.floor(values)).all())
        strange = strange_unit(label)
        if not unit and strange and not set(words_of(strange)) & {
                *known_words(), *meaning.own_words}:
            self._ask(f'unit {strange}', f'{label}: [{strange}] is no unit that is known',
                      f'--unit {quantity}=UNIT')
        elif not unit and quantity == EFFORT and meaning.is_input and role != 'reference_torque':
            usual = next((u for w, u in vocabulary()['inputs'].items() if w in meaning.words), '')
            unit = 'counts' if coarse else usual or '1'
        elif not unit and quantity == POSITION and coarse:
            unit = 'counts'
            self.assumptions.append(f'{label}: whole numbers, so counts.')
        elif not unit and quantity == POSITION and axis == ROTARY and (
                np.ptp(np.quantile(values, USUAL)) > WIDE) and 'positions' not in self.questions:
            self._ask('unit', f'{label}: no unit in the file, and its range of '
                      f'{np.ptp(values):.4g} is wide for rad', '--unit position=deg (or turns, or '
                      'rad)')
        for bits in (16, 32) if coarse and values.min() >= 0 else ():
            full = 2.0 ** bits
            if values.max() < full and (np.abs(np.diff(values)) > full / 2).any() and (
                    not self._is_set(f'{key}.bits')):
                self._ask('bits', f'{label}: whole numbers that jump between 0 and '
                          f'{full:.0f}', f'--set {key}.bits={bits} if they are signed integers')
        self.units[label] = unit
        scaled = column.factor != 1.0 and unit == column.unit
        return {'column': label, **({'unit': unit} if unit else {}), **(
            {'scale': column.factor} if scaled else {})}

    def _second_factor(self, block: dict[str, Any], role: str, choice: Choice, key: str) -> None:
        """Add what makes SI of an input or of counts to a signal's `block`, or ask for it."""
        unit, effort = block.get('unit', ''), kind_of(role).quantity == EFFORT
        stem, rotary = choice.roles[role].stem, self._axis(choice) == ROTARY
        constant = self.constants.get(choice.joint, next(iter(self.constants.values()), None))
        if role == 'motor_setpoint' or self._is_set(f'{key}.scale') or (
                unit not in (units_of(EFFORT, 'input') if effort else COUNTS)):
            return
        if role == 'reference_torque':
            self._ask('scale', f'{stem}: {unit}, and no torque of one in the file',
                      f'--set {key}.scale=K (N m per unit)')
        elif effort and not self._is_set(f'{key}.torque_constant'):
            if constant is not None:
                block['torque_constant'] = constant
                self.used.add('--torque-constant')
            elif self.needs_constants:
                per = 'count' if unit in COUNTS else 'A' if unit in ('A', 'mA') else 'full scale'
                self._ask('constant', f'{stem}: {unit}, and no constant in the file that makes it '
                          f'N m (or N)', f'--torque-constant K (N m per {per}, or K1,K2,... of '
                          'each joint; 1 keeps it, for a model with torque_constant), or '
                          '--use effort=none')
        elif not effort and not self._is_set(f'{key}.counts_per_rev'):
            if self.answers.counts and rotary:
                block['counts_per_rev'] = self.answers.counts
                self.used.add('--counts-per-turn')
            else:
                self._ask('counts', f'{stem}: counts, and no resolution in the file',
                          f'--counts-per-turn N, or --set {key}.counts_per_rev=N' if rotary else
                          f'--set {key}.scale=M (m per count)')

    def _signals(self, choice: Choice, t: Array, robot: bool) -> dict[str, dict[str, Any]]:
        """Return the blocks of the signals of a drive, or of a joint of a robot; t [N]: times."""
        roles = {name: next(filter(choice.roles.__contains__, options), '')
                 for name, options in OF_ROBOT} if robot else {
            role: role for role in sorted(choice.roles, key=lambda role: (
                *POSITIONS, role).index(role))}
        blocks: dict[str, dict[str, Any]] = {}
        for name, role in roles.items():
            if role:
                key = f'joints.{choice.joint}.{name}' if robot else f'signals.{name}'
                blocks[name] = self._block(role, choice, key)
                self._second_factor(blocks[name], role, choice, key)
        positions = [name for name in ('position', *POSITIONS) if name in blocks]
        first = blocks[positions[0]] if positions else {}
        for name in {'setpoint', 'motor_setpoint'} & set(blocks):
            if 'unit' in first:
                blocks[name].setdefault('unit', first['unit'])
            if blocks[name].get('unit') not in COUNTS:
                continue
            blocks[name].update({key: first[key] for key in ('counts_per_rev',) if key in first})
            if first.get('unit') not in COUNTS:
                del blocks[name]
                self.assumptions.append('The setpoint is in counts of no encoder that is used: '
                                        'left out.')
        for name in positions:
            velocity = name.replace('position', 'velocity')
            if velocity in blocks and 'unit' not in blocks[velocity]:
                why = self._contradiction(blocks[name], blocks[velocity], choice, t)
                if why:
                    choice.left[choice.roles.pop(roles[velocity]).label] = why
                    del blocks[velocity]
        if len(positions) == 2:
            self._ratio(blocks, choice)
        return blocks

    def _scale_of(self, block: Mapping[str, Any], quantity: str, axis: str) -> float:
        """Return the factor of a block's column to SI, NaN: not known."""
        factor, complete = unit_factor(block['unit'], quantity, axis) if 'unit' in block else \
            (1.0, True)
        if not complete:
            factor = TURN / block.get('counts_per_rev', np.nan)
        return float(factor * block.get('scale', 1.0))

    def _contradiction(self, position: Mapping[str, Any], velocity: dict[str, Any],
                       choice: Choice, t: Array) -> str:
        """
        Return why a velocity without a unit is not used, '' if the position agrees with it.

        A block of a position in a known unit gives it this unit per second. t: times [N], s.
        """
        axis = self._axis(choice)
        per_second = f'{position.get("unit")}/s'
        if per_second in units_of(VELOCITY, axis):
            velocity['unit'] = per_second
        q, v, t = common_rows(choice.values[position['column']],
                              choice.values[velocity['column']], t) or np.zeros((3, 1))
        step = 4 * max(1, len(q) // 2000)
        if len(q) < 10 + step or np.ptp(q) < STILL * np.median(np.abs(np.diff(q))):
            return ''
        moved: Array = np.abs(q[step:] - q[:-step]) / np.maximum(t[step:] - t[:-step], 1e-9)
        ratio = float(np.mean(np.abs(v))) * self._scale_of(velocity, VELOCITY, axis) / max(
            float(np.mean(moved)) * self._scale_of(position, POSITION, axis), 1e-12)
        stem = next(c.stem for c in choice.roles.values() if c.label == velocity['column'])
        return '' if not (ratio <= 1.0 / APART or ratio >= APART) else (
            f'no unit, and {ratio:.3g} times the derivative of the position: --unit {stem}=UNIT')

    def _ratio(self, blocks: dict[str, dict[str, Any]], choice: Choice) -> None:
        """Ask for the gear ratio and for a sign, where the two encoders do not move alike."""
        motor, arm = (choice.roles[role].label for role in POSITIONS)
        slope = robust_slope(choice.values[arm], choice.values[motor])
        if slope is None:
            return
        if slope < 0.0 and not any(self._is_set(f'signals.{role}.sign') for role in POSITIONS):
            self._ask('sign', f'{arm} runs against {motor}',
                      '--set signals.arm_position.sign=-1 (or 1 if it does so)')
        scales = [self._scale_of(blocks[role], POSITION, self._axis(choice)) for role in POSITIONS]
        ratio = abs(slope) * scales[0] / scales[1]
        if np.isnan(ratio) or self._is_set('gear_ratio'):
            return
        unit = next((name for name, factor in units_of(POSITION, ROTARY).items() for ends in (
            factor, 1.0 / factor) if factor != 1.0 and abs(ratio / ends - 1.0) < 0.02), '')
        if unit or abs(ratio - 1.0) > GEARED:
            self._ask('ratio', f'the motor moves {ratio:.4g} times as much as the arm' + (
                ', which looks like a unit' if unit else ''), f'--unit motor={unit} (or arm), or '
                '--set gear_ratio=N' if unit else '--set gear_ratio='
                f'{round(ratio) if ratio > 1.5 else 1} (1: both are at the output)')

    def _grippers(self, data: dict[str, Any], choices: Sequence[Choice]) -> None:
        """Ask for the unit of a gripper in percent among joints whose unit was stated."""
        for choice in choices:
            words = set(re.findall(r'[a-z]+', choice.joint.lower()))
            position = choice.roles.get('motor_position') or choice.roles.get('arm_position')
            if not words & vocabulary()['grippers'] or not position or position.unit:
                continue
            low, high = (f(choice.values[position.label]) for f in (np.nanmin, np.nanmax))
            if self.answers.units.get(choice.joint) == NONE:
                del data['joints'][choice.joint]
            elif choice.joint not in self.answers.units and low >= 0.0 and WIDE < high <= 100.0:
                self._ask('gripper', f'{choice.joint}: from {low:.3g} to {high:.3g}, maybe '
                          f'percent of its travel', f'--unit {choice.joint}=none (left out), or '
                          f'--unit {choice.joint}=deg (or m)')

    def _blanks(self, data: dict[str, Any], time: FoundTime) -> None:
        """Give each signal its own time where curves have their samples in different rows."""
        blocks = [block for signals in (data.get('joints') or {'': data['signals']}).values()
                  for block in signals.values()]
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
                block['time'] = {**time.block, 'column': column.clock or time.block['column']}
        elif not clocks and time.named and any(
                np.isnan(c.values.astype(float)).mean() > BLANK for c in columns):
            for block in blocks:
                block['time'] = dict(time.block)
            self.assumptions.append('Empty cells: each curve has its own samples; they are '
                                    'interpolated onto those of the first signal.')

    def _require_effect(self, data: Mapping[str, Any], listed: Sequence[Meaning],
                        choices: Sequence[Choice], time: FoundTime) -> None:
        """Raise InputError: an answer was stated that nothing of `data` needs."""
        answers = self.answers
        if self.questions:  # whose answers may need it
            return
        names = {*time.labels, 'time', *(n for m in listed for n in (m.label, m.stem, m.joint)), *(
            name for choice in choices for role in choice.roles for name in _names_of(role))}
        for name, unit in answers.units.items():
            if name not in names:
                raise InputError(f'--unit {name}={unit}: no such role, joint or column, expected '
                                 f'one of {", ".join(sorted(filter(None, names)))[:400]}')
        for option, value, used, why in (
                ('--counts-per-turn', answers.counts, '--counts-per-turn' in self.used,
                 'no signal is in counts'),
                ('--torque-constant', answers.torque_constants or None,
                 '--torque-constant' in self.used, 'no effort needs one'),
                ('--episode', answers.episode, 'segment' in data['time'],
                 'no column tells episodes apart')):
            if value is not None and not used:
                raise InputError(f'{option}: {why}, expected no such option')

    # --- table ----------------------------------------------------------------------------------
    def _rows(self, listed: Sequence[Meaning], choices: Sequence[Choice], time: FoundTime
              ) -> list[tuple[str, str, str, str]]:
        """Return a line for each column; of joints that are alike one for all of them."""
        rows = [(', '.join(time.labels) or 'none', 'time', f'{time.block["rate"]:g} Hz'
                 if 'rate' in time.block else str(time.block.get('unit', 's')), 'given'
                 if not time.named else time.remarks[0].partition(', ')[2])]
        by_column = {c.label: (choice, role) for choice in choices
                     for role, c in choice.roles.items()}
        unused = {column: why for choice in choices for column, why in choice.left.items()}
        families: dict[tuple[str, ...], tuple[str, list[str]]] = {}
        for meaning in listed:
            choice, role = by_column.get(meaning.label, (None, ''))
            unit = meaning.unit
            if choice is not None:
                unit = self.units.get(meaning.label) or unit or SI[self._axis(choice)][
                    kind_of(role).quantity]
                unit += '' if meaning.stated else '?'
                why = choice.reasons[role]
            else:
                why = unused.get(meaning.label) or (
                    'no joint in its name' if choices[0].joint and not meaning.joint and (
                        meaning.quantity in (POSITION, VELOCITY, EFFORT)) else
                    f'{meaning.source} {meaning.quantity}'.strip() or 'nothing of a joint')
            alike = re.sub(rf'\b{re.escape(meaning.joint)}\b', '', why) if meaning.joint else why
            stem = re.sub(r'[ .]\d+$', '', meaning.stem)  # columns of one matrix
            families.setdefault((stem, role, unit, alike), (why, []))[1].append(meaning.label)
        return rows + [(labels[0] if len(labels) == 1 else f'{labels[0]} ... {labels[-1]}', role,
                        unit, why) for (_, role, unit, _), (why, labels) in families.items()]


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
