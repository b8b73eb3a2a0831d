# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Propose the mapping of a foreign recording: meaning first, motion last, questions for the rest.

Names and units say what a column is (`meaning`); copies of other columns are no second encoders
(`copies`); the motion decides what they leave open and gives signs and units (`guess_units`).
What remains is asked, with the option that settles it.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
import re
from typing import Any

import numpy as np
import yaml

from gearbox_monitor.errors import InputError, Undecided
from gearbox_monitor.kernels.types import Array
from gearbox_monitor.recordings.importer.guess_time import found_time, FoundTime
from gearbox_monitor.recordings.importer.guess_units import (
    decoded, effort_sign, relate_encoders, scale_of, velocity_units)
from gearbox_monitor.recordings.importer.header import with_settings
from gearbox_monitor.recordings.importer.layout import Format, recognised_layout, Series
from gearbox_monitor.recordings.importer.mapping import (
    ImportMapping, mapping_from_dict, signal_kind, SIGNALS)
from gearbox_monitor.recordings.importer.meaning import (
    EFFORT, joints_of, Meaning, meanings, POSITION, stem_of, VELOCITY, with_listed_names)
from gearbox_monitor.recordings.importer.roles import (
    Choice, choice_of, Column, is_input, matches, NONE, Question)
from gearbox_monitor.recordings.importer.row_keys import row_key, RowKey
from gearbox_monitor.recordings.importer.sibling_file import sibling_setpoints, states_beside
from gearbox_monitor.recordings.importer.unit_table import (
    ANGLE, ANGULAR_SPEED, axis_of, COUNT_RATE, COUNTS, DRIVE_INPUT, FORCE, LENGTH, scaled_unit,
    SPEED, standard_unit, TIME, TORQUE)

COARSE = 100.0  # whole numbers over a wider range are counts
WIDE = 4.0 * np.pi  # rad: a joint turns less; a wider range without a unit may be degrees
MOST_JOINTS = 1000  # that q[6] in --columns may stand for
BLANK = 0.05  # share of empty cells from which on curves have samples of their own
ROLES = {'motor': 'motor_position', 'arm': 'arm_position', 'position': 'motor_position',
         'velocity': 'motor_velocity', 'effort': 'motor_effort', 'setpoint': 'motor_setpoint',
         'reference': 'reference_torque'}
SI = {'rotary': {'position': 'rad', 'velocity': 'rad/s', 'effort': 'N m'},
      'prismatic': {'position': 'm', 'velocity': 'm/s', 'effort': 'N'}}
OF_ROBOT = (('position', ('arm_position', 'motor_position')),
            ('velocity', ('arm_velocity', 'motor_velocity')), ('effort', ('motor_effort',)),
            ('setpoint', ('motor_setpoint',)))


@dataclass(frozen=True)
class Answers:
    """
    What a user states about a recording.

    use {role: column, or 'none'}; units {role or column: unit}; torque_constants: N m per A (or
    per other unit of the effort) of all joints, or of each; counts: per turn; joint: that alone;
    columns: names of all columns, 'q[6]' for q_1 to q_6; rate, Hz; episode: of a dataset.
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


@dataclass(frozen=True)
class TableRow:
    """A line of the table of columns: what became of one, or of a family of them."""

    column: str
    role: str
    unit: str
    why: str


@dataclass(frozen=True)
class Guess:
    """A proposed mapping: plain `data`, what it assumes, what is open, and the columns."""

    source: str
    data: Mapping[str, Any]
    assumptions: tuple[str, ...]
    questions: tuple[Question, ...] = ()
    table: tuple[TableRow, ...] = ()

    @property
    def yaml_text(self) -> str:
        """Return the mapping as a file, its assumptions and questions as comments."""
        lines = [f'# {line}' for line in (
            f'Proposed for {self.source}.', *self.assumptions,
            *(f'Open: {question}' for question in self.questions))]
        return '\n'.join(lines) + '\n' + yaml.safe_dump(
            dict(self.data), sort_keys=False, default_flow_style=None, allow_unicode=True)

    def mapping(self) -> ImportMapping:
        """
        Return the checked mapping.

        Raises Undecided: something is open; InputError: a value could not be guessed.
        """
        if self.questions:
            raise Undecided(*(f'{self.source}: {question}' for question in self.questions))
        try:
            return mapping_from_dict(self.data, f'guess of {self.source}', self.yaml_text)
        except InputError as error:
            raise InputError(*(f'{line} (--set KEY=VALUE)' for line in error.args)) from None


def guessed_mapping(path: str | Path, settings: Sequence[str] = (),
                    answers: Answers | None = None) -> Guess:
    """
    Return the Guess of a mapping for the file `path`.

    Args:
        path: of the recording.
        settings: ``KEY=VALUE`` that replace what is proposed.
        answers: what the user states; None: nothing.

    Raises:
        InputError: the file holds no motion that can be recognised.
        Undecided: its columns have no names, or none of them is a time.
    """
    return _Proposal(Path(path), settings, answers or Answers()).guess()


class _Proposal:
    """The steps from a file to its Guess, and what they gather."""

    def __init__(self, path: Path, settings: Sequence[str], answers: Answers) -> None:
        self.path, self.settings, self.answers = path, settings, answers
        self.layout: Format = _renamed(path, recognised_layout(path), answers.columns)
        self.key = row_key(self.layout.series, self.layout.row_keys)
        self.all_series = self.layout.series
        if self.key is not None:
            self.layout = replace(self.layout, series=self.key.of_first(self.all_series))
        self.assumptions: list[str] = []
        self.questions: list[Question] = []
        self.decoding: dict[int, dict[str, Any]] = {}
        self.blocks: dict[int, dict[str, Any]] = {}  # of the mapping, by column
        self.constants: dict[str, float] = {}
        self.constants_used = False
        self.kind = 'rotary'

    def guess(self) -> Guess:
        """Return the Guess."""
        self._require_units()
        time = self._time()
        series = [column for column in self.layout.series if column.label not in time.labels
                  and column.values.dtype.kind in 'iuf' and np.isfinite(column.values).any()]
        descriptions = with_listed_names(meanings(
            [c.label for c in series], [self._unit_of(c) for c in series]), self.layout.joints)
        if self.key is not None:
            by_label = {c.label: meaning for c, meaning in zip(series, descriptions)}
            pairs = [(joint, column) for joint, column in self.key.by_joint(self.all_series)
                     if column.label in by_label and np.isfinite(column.values).any()]
            series = [column for _, column in pairs]
            descriptions = [replace(by_label[c.label], joint=joint) for joint, c in pairs]
        joints = joints_of(descriptions)
        joint = self._selected(joints)
        self.constants = self._constants(joints)
        robot = joint is None and len(joints) > 1
        columns = [Column(k, meaning, self._values(k, column, time.t),
                          float(np.isfinite(column.values).mean()))
                   for k, (column, meaning) in enumerate(zip(series, descriptions))
                   if robot or np.nanmax(column.values) > np.nanmin(column.values)]
        use = self._use(descriptions)
        if not joints and not any(role.endswith(('_position', '_velocity')) for role in use):
            raise InputError(f'{self.path}: no position or velocity among '
                             f'{", ".join(c.label for c in series)[:200]}, expected a mapping '
                             'file (--map), or --use position=COLUMN')
        names = joints if robot else [joint or '']
        choices = [choice_of([c for c in columns if c.meaning.joint == name or not robot and (
            joint is None)], time.t, name, use) for name in names]
        if not robot and not any(role.endswith(('_position', '_velocity'))
                                 for role in choices[0].roles) and not choices[0].questions:
            still = [m.label for c, m in zip(series, descriptions)
                     if m.quantity in (POSITION, VELOCITY)
                     and np.nanmax(c.values) == np.nanmin(c.values)]
            problem = f'{", ".join(still)[:200]} never changes' if still else \
                f'no position or velocity among {", ".join(c.label for c in series)[:200]}'
            raise InputError(f'{self.path}: {problem}, expected a motion')
        for question in (question for choice in choices for question in choice.questions):
            self._ask(question.topic, question.text, question.option)
        self._require_used(time, descriptions, choices)
        axes = {self._axis(choice) for choice in choices}
        self.kind = 'prismatic' if axes == {'prismatic'} else 'rotary'
        data: dict[str, Any] = {**self.layout.blocks, 'time': time.block, 'kind': self.kind}
        if robot:
            data['joints'] = {choice.joint: self._of_joint(choice, series)
                              for choice in choices}
        else:
            data['signals'] = self._of_drive(data, choices[0], series, time)
        self._require_effect(data)
        if self.key is not None:
            _with_row_key(data, self.key, time)
        else:
            self._blanks(data, series, choices, time)
        if robot and self.key is None and 'motor_setpoint' not in use:
            self._setpoints_beside(data, time)
        table = self._table(series, descriptions, choices, time)
        unused = [row.column for row in table if not row.role]
        if unused:
            self.assumptions.append(f'Not used: {", ".join(unused)[:400]}.')
        return Guess(self.path.name, with_settings(data, self.settings), tuple(self.assumptions),
                     tuple(self.questions), tuple(table))

    def _setpoints_beside(self, data: dict[str, Any], time: FoundTime) -> None:
        """Add the setpoints of a robot in a file of their own to the mapping `data`, or ask."""
        if any('setpoint' in joint for joint in data['joints'].values()):
            return
        states = states_beside(self.path, time, data['joints'])
        if states and 'motor' not in self.answers.use:
            self._ask('motor', f'setpoints by the name of the file, {states} beside it has '
                      'the positions of the run', f'import {states}, or --use motor=COLUMN')
        blocks = sibling_setpoints(self.path, time, data['joints'])
        names = ', '.join(block['path'] for block in blocks)
        if len(blocks) == 1:
            data['second_file'] = blocks[0]
            self.assumptions.append(f'Setpoints: {names} beside it, on the same clock.')
        elif blocks:
            self._ask('setpoint', f'{names}: setpoints of the same joints and time beside it',
                      '--use setpoint=none, or second_file in a mapping (--map)')

    # --- time, names and units ------------------------------------------------------------------
    def _time(self) -> FoundTime:
        """Return the time of the recording. Raises Undecided: it has none, or no names at all."""
        answers, series = self.answers, self.layout.series
        if not self.layout.named and not answers.columns:
            raise Undecided(f'{self.path}: {len(series)} columns without names, expected their '
                            "names in order: --columns 't,q[6],dq[6],i[6]' (q[6]: q_1 to q_6; - "
                            'for a column that is not used)')
        rate = self._setting('time.rate') or answers.rate
        if rate is None:
            units = {name: standard_unit(unit) for name, unit in answers.units.items()}
            if 'time' in units:
                units.update({column.label: units['time'] for column in series})
            time = found_time(self.path, series, units, answers.use.get('time', ''))
            if time is not None:
                if answers.episode is not None:
                    time.block['only'] = answers.episode
                if answers.stamps:
                    time.block['stamps'] = answers.stamps
                self.assumptions += time.remarks
                return time
            rate = self.layout.rate
            if rate is None:
                raise Undecided(f'{self.path}: no column of '
                                f'{", ".join(c.label for c in series)[:200]} grows like a time, '
                                'expected one, or --rate HZ')
        return FoundTime(np.arange(len(series[0].values)) / rate, {'rate': rate})

    def _constants(self, joints: Sequence[str]) -> dict[str, float]:
        """Return {joint: its torque constant} as stated. Raises InputError: another number."""
        constants = self.answers.torque_constants
        if len(constants) not in (0, 1, len(joints)):
            names = f' or {len(joints)}, one of each joint ({", ".join(joints)})' \
                if len(joints) > 1 else ''
            raise InputError(f'--torque-constant: {len(constants)} constants '
                             f'({", ".join(f"{constant:g}" for constant in constants)}), expected '
                             f'1{names}')
        return dict(zip(joints, constants if len(constants) > 1 else [*constants] * len(joints)))

    def _setting(self, key: str) -> float | None:
        """Return the number > 0 of a setting KEY=VALUE, None without it. Raises InputError."""
        value = {text.partition('=')[0]: text.partition('=')[2] for text in self.settings}.get(key)
        try:
            number = None if value is None else float(value)
        except ValueError:
            number = 0.0
        if number is not None and not 0.0 < number < 1e300:
            raise InputError(f'--set {key}={value}: expected a number > 0')
        return number

    def _require_units(self) -> None:
        """Raise InputError: an option --unit states what is no unit."""
        for name, unit in self.answers.units.items():
            if not standard_unit(unit):
                raise InputError(f'--unit {name}={unit}: unknown unit, expected one of '
                                 + ', '.join({**ANGLE, **LENGTH, **ANGULAR_SPEED, **SPEED,
                                              **COUNTS, **COUNT_RATE, **TORQUE, **FORCE,
                                              **DRIVE_INPUT, **TIME}))

    def _unit_of(self, column: Series) -> str:
        """Return the unit of a column as stated by its name, or in the file."""
        return self.answers.units.get(column.label, column.unit)

    def _stated_unit(self, role: str, column: Column) -> str:
        """Return the unit of a column in a `role` as the user states it, '' if not."""
        units = self.answers.units
        return next((standard_unit(units[name]) for name in (
            column.meaning.label, stem_of(column.meaning), *_names_of(role)) if name in units), '')

    def _axis(self, choice: Choice) -> str:
        """Return the axis of a joint, as the units of its columns say."""
        return axis_of((self._stated_unit(role, column) or column.meaning.unit
                        for role, column in choice.roles.items()),
                       'prismatic' if 'kind=prismatic' in self.settings else 'rotary')

    def _require_used(self, time: FoundTime, descriptions: Sequence[Meaning],
                      choices: Sequence[Choice]) -> None:
        """Raise InputError: an option --unit names neither a column nor a role that one has."""
        columns = [*time.labels, *(name for meaning in descriptions for name in (
            meaning.label, stem_of(meaning)))]
        roles = [role for choice in choices for role in choice.roles]
        names = dict.fromkeys(['time'] * bool(time.labels) + [
            name for role in roles for name in _names_of(role)])
        asked = (*ROLES, *SI['rotary']) if any(choice.questions for choice in choices) else ()
        for name, unit in self.answers.units.items():
            if name not in (*columns, *names, *asked):
                raise InputError(f'--unit {name}={unit}: no such role or column, expected one of '
                                 f'{", ".join((*names, *dict.fromkeys(columns)))[:400]}')

    def _require_effect(self, data: Mapping[str, Any]) -> None:
        """Raise InputError: a number was stated that no signal and no time of `data` needs."""
        answers = self.answers
        if self.questions:  # whose answers may need it
            return
        signals = data.get('joints', {'': data.get('signals')}).values()
        blocks = {name: block for joint in signals for name, block in joint.items()}
        used = {key for joint in signals for block in joint.values() for key in block}
        if answers.episode is not None and 'segment' not in data['time']:
            raise InputError(f'--episode {answers.episode}: no column tells episodes apart, '
                             'expected a recording without this option')
        if answers.counts and 'counts_per_rev' not in used:
            raise InputError(f'--counts-per-turn {answers.counts:g}: no signal is in counts, '
                             'expected --unit position=counts beside it')
        if answers.torque_constants and not self.constants_used:
            reason = 'a torque as it is' if any('effort' in name for name in blocks) else \
                'it has no effort'
            raise InputError(f'--torque-constant: no effort that needs one ({reason}), expected '
                             '--use effort=COLUMN or --unit effort=A beside it')

    def _selected(self, joints: Sequence[str]) -> str | None:
        """Return the joint that is asked for, None for all. Raises InputError: there is none."""
        joint = self.answers.joint
        if joint is None:
            return None
        candidates = [name for name in joints if joint in (name, name.removeprefix('joint_'))]
        if not candidates:
            raise InputError(f'{self.path}: --joint {joint}: expected one of '
                             f'{", ".join(filter(None, joints)) or "none: it has a single joint"}')
        return candidates[0]

    def _values(self, number: int, column: Series, t: Array) -> Array:
        """Return the values of a column; of a curve with samples of its own, between them, too."""
        if np.nanmax(column.values) == np.nanmin(column.values):
            return column.values.astype(float)
        values, self.decoding[number] = decoded(column, self.assumptions)
        valid = np.isfinite(values)
        return values if valid.mean() > 1.0 - BLANK else np.interp(t, t[valid], values[valid])

    def _use(self, descriptions: Sequence[Meaning]) -> dict[str, str]:
        """Return {role: column} as stated, of a robot without the words of the joint."""
        use = {}
        for role, name in self.answers.use.items():
            if role == 'time':
                continue
            full = ROLES.get(role, role)
            if full not in SIGNALS:
                raise InputError(f'--use {role}={name}: unknown role, expected one of time, '
                                 f'{", ".join((*ROLES, *SIGNALS))}')
            fitting = [meaning for meaning in descriptions if matches(name, meaning)]
            if name != NONE and not fitting:
                labels = ', '.join(dict.fromkeys(meaning.label for meaning in descriptions))
                raise InputError(f'--use {role}={name}: no such column, expected one of '
                                 f'{labels[:300]}')
            use[full] = stem_of(fitting[0]) if fitting and fitting[0].joint else name
        return use

    # --- keys -----------------------------------------------------------------------------------
    def _block(self, role: str, column: Column, series: Sequence[Series]) -> dict[str, Any]:
        """Return the block of the mapping for a `column` in a role."""
        own = series[column.number]
        block: dict[str, Any] = {**own.place, **self.decoding.get(column.number, {})}
        column_of_file = own if self.key is None else next(
            whole for whole in self.all_series if whole.label == own.label)
        if not np.isfinite(column_of_file.values.astype(float)).all():
            block['missing'] = 'nan'
        stated = self._stated_unit(role, column)
        unit = stated or column.meaning.unit
        if unit:
            block['unit'] = unit
        if column.meaning.scale != 1.0 and not stated:
            block['scale'] = column.meaning.scale
        self.blocks[column.number] = block
        return block

    def _of_drive(self, data: dict[str, Any], choice: Choice, series: Sequence[Series],
                  time: FoundTime) -> dict[str, dict[str, Any]]:
        """Return the blocks of the signals of one drive; add its gear ratio to `data`."""
        blocks = {role: self._block(role, column, series)
                  for role, column in choice.roles.items()}
        values = {role: column.values for role, column in choice.roles.items()}
        for role, column in choice.roles.items():
            self._numbers(role, blocks[role], column, choice)
            count = self._setting(f'signals.{role}.counts_per_rev')
            if count is not None:
                blocks[role]['counts_per_rev'] = count
        if {'motor_position', 'arm_position'} <= set(blocks):
            if self.answers.counts:
                for role in ('motor_position', 'arm_position'):
                    self._counts(blocks[role], '', f'signals.{role}', self.kind)
            relate_encoders(data, blocks, (values['motor_position'], values['arm_position']),
                            self.assumptions)
        self._setpoint(data, blocks, values)
        velocity_units(self.kind, blocks, values, time.t, self.assumptions)
        if not choice.joint and 'effort' not in {question.topic for question in self.questions}:
            effort_sign(blocks, values, time.t, self.assumptions)
        self._note_units({role: column.meaning.label for role, column in choice.roles.items()
                          if 'unit' not in blocks[role]})
        self._setpoint_counts(blocks, values)
        self._missing_numbers(blocks, choice.joint)
        order = ('motor_position', 'arm_position')
        return {role: blocks[role] for role in sorted(
            blocks, key=lambda name: (name not in order, name == 'arm_position'))}

    def _of_joint(self, choice: Choice, series: Sequence[Series]) -> dict[str, dict[str, Any]]:
        """Return the blocks of the signals of a robot's joint."""
        blocks: dict[str, dict[str, Any]] = {}
        for name, roles in OF_ROBOT:
            role = next((role for role in roles if role in choice.roles), None)
            if role is None:
                continue
            column, key = choice.roles[role], f'joints.{choice.joint}.{name}'
            block = blocks[name] = self._block(role, column, series)
            self._numbers(name, block, column, choice)
            if name == 'effort':
                self._torque_constant(block, column.meaning.label, key, choice.joint)
            else:
                self._counts(block, column.meaning.label, key, self._axis(choice))
        if 'unit' in blocks.get('position', {}) and 'setpoint' in blocks:
            blocks['setpoint'].setdefault('unit', blocks['position']['unit'])
        return blocks

    def _numbers(self, name: str, block: dict[str, Any], column: Column, choice: Choice) -> None:
        """Add or ask for the unit of a column that states none."""
        values = column.values[np.isfinite(column.values)]
        if 'unit' in block or not len(values):
            return
        label, quantity = column.meaning.label, signal_kind(
            name if '_' in name else f'joint:{name}').quantity
        span = float(np.ptp(values))
        is_coarse = span > COARSE and (values == np.floor(values)).all()
        if quantity == 'effort':
            if is_input(column.meaning) and 'reference' not in name:
                words = set(column.meaning.words)
                current = words & {'current', 'currents', 'curr', 'cur', 'amps', 'i', 'iq',
                                   'strom'}
                block['unit'] = 'counts' if is_coarse else 'A' if current else '1'
                if block['unit'] == 'A':
                    self.assumptions.append(f'{label}: a current, so A.')
            return
        if quantity == 'position' and is_coarse:
            block['unit'] = 'counts'
            self.assumptions.append(f'{label}: whole numbers, so counts.')
            return
        single = not ({'motor_position', 'arm_position'} <= set(choice.roles) and 'motor' in name)
        wide = quantity == 'position' and span > WIDE and self._axis(choice) == 'rotary'
        if wide and single and not any(
                question.topic in ('unit', 'positions') for question in self.questions):
            self._ask('unit', f'{label}: no unit in the file, and its range of {span:.4g} is wide '
                      'for rad', '--unit position=deg (or turns, or rad)')

    def _setpoint(self, data: Mapping[str, Any], blocks: dict[str, dict[str, Any]],
                  values: Mapping[str, Array]) -> None:
        """Give the setpoint the unit of the position, and the side that it is on."""
        block = blocks.get('motor_setpoint')
        position = next((role for role in ('motor_position', 'arm_position') if role in blocks),
                        None)
        if block is None or position is None:
            return
        if 'unit' not in block and 'unit' in blocks[position]:
            block['unit'] = blocks[position]['unit']
        ratio = data.get('gear_ratio', 1.0)
        if 'arm_position' in blocks and ratio != 1.0:
            scales = {role: scale_of(blocks[role], self.kind) or np.nan for role in
                      ('motor_setpoint', 'motor_position', 'arm_position')}
            spread = {role: float(np.nanstd(values[role])) * scale
                      for role, scale in scales.items()}
            sides = {side: abs(np.log(spread['motor_setpoint'] / spread[f'{side}_position']))
                     for side in ('motor', 'arm') if spread[f'{side}_position'] > 0.0}
            if sides and min(sides, key=lambda side: sides[side]) == 'arm':
                block['scale'] = float(f'{block.get("scale", 1.0) * ratio:.8g}')
                self.assumptions.append('The setpoint is as large as the motion of the arm: on '
                                        f'its side, so times the gear ratio {ratio:g}.')

    def _setpoint_counts(self, blocks: dict[str, dict[str, Any]], values: Mapping[str, Array]
                         ) -> None:
        """Give a setpoint in counts the resolution of the encoder that it is as large as."""
        block = blocks.get('motor_setpoint', {})
        if block.get('unit') not in COUNTS or 'counts_per_rev' in block or self.answers.counts:
            return
        likely = [role for role in ('motor_position', 'arm_position') if role in blocks
                  and 0.5 * np.nanstd(values[role]) < np.nanstd(values['motor_setpoint'])
                  < 2.0 * np.nanstd(values[role])]
        if likely:  # asked for where the encoder's is not known either
            if 'counts_per_rev' in blocks[likely[0]]:
                block['counts_per_rev'] = blocks[likely[0]]['counts_per_rev']
        elif 'motor_effort' in blocks or self.questions:
            del blocks['motor_setpoint']
            self.assumptions.append('The setpoint is in counts of no encoder that is used, so it '
                                    'is left out.')

    def _missing_numbers(self, blocks: dict[str, dict[str, Any]], joint: str) -> None:
        """Fill in, or ask for, counts per turn and torque constant."""
        for name, block in blocks.items():
            if 'effort' not in name and 'torque' not in name:
                self._counts(block, f'signals.{name}.unit', f'signals.{name}', self.kind)
            elif name != 'motor_effort' and block.get('unit') in COUNTS and not any(
                    text.startswith(f'signals.{name}.scale=') for text in self.settings):
                self._ask('scale', f'signals.{name}.unit: counts, and no torque of one in the '
                          'file', f'--set signals.{name}.scale=K (N m per count)')
        if 'motor_effort' in blocks:
            self._torque_constant(blocks['motor_effort'], 'signals.motor_effort.unit',
                                  'signals.motor_effort', joint)

    def _counts(self, block: dict[str, Any], where: str, key: str, axis: str) -> None:
        """Add the resolution of an encoder in counts to its `block`, or ask for it."""
        if block.get('unit') not in (*COUNTS, *COUNT_RATE) or 'counts_per_rev' in block or any(
                text.startswith((f'{key}.counts_per_rev=', f'{key}.scale='))
                for text in self.settings):
            return
        if axis == 'prismatic':
            self._ask('counts', f'{where}: counts, and no length of one in the file',
                      f'--set {key}.scale=M (m per count)')
        elif self.answers.counts:
            block['counts_per_rev'] = self.answers.counts
        else:
            self._ask('counts', f'{where}: counts, and no resolution in the file',
                      f'--counts-per-turn N, or --set {key}.counts_per_rev=N')

    def _torque_constant(self, block: dict[str, Any], where: str, key: str, joint: str) -> None:
        """Add the torque constant of a joint to the `block` of its effort, or ask for it."""
        unit = block.get('unit', '')
        constant = self.constants.get(joint, next(iter(self.constants.values()), None))
        if unit in {**TORQUE, **FORCE} or any(text.startswith((
                f'{key}.torque_constant=', f'{key}.scale=')) for text in self.settings):
            return
        if constant is not None:
            block['scale' if unit in COUNTS else 'torque_constant'] = constant
            self.constants_used = True
        elif unit:
            per = 'count' if unit in COUNTS else 'A' if unit in ('A', 'mA') else 'full scale'
            self._ask('constant', f'{where}: {unit}, and no constant in the file that makes it '
                      f'N m (or N)', f'--torque-constant K (N m per {per}, or K1,K2,... of each '
                      'joint; 1 keeps it, for a model with torque_constant), or --use effort=none')

    def _ask(self, topic: str, text: str, option: str) -> None:
        if topic not in {question.topic for question in self.questions}:
            self.questions.append(Question(topic, text, option))

    def _note_units(self, silent: Mapping[str, str]) -> None:
        if silent:
            units = 'rad, rad/s, N m (m, m/s, N where the model has axis: prismatic)' \
                if self.kind == 'rotary' else 'm, m/s, N'
            self.assumptions.append(f'No unit in the name, so {units} unless stated below: '
                                    f'{", ".join(silent)}.')

    def _blanks(self, data: dict[str, Any], series: Sequence[Series], choices: Sequence[Choice],
                time: FoundTime) -> None:
        """Give each signal its own time where curves have their samples in different rows."""
        used = [series[column.number] for choice in choices for column in choice.roles.values()]
        if time.column is None or not any(
                np.isnan(column.values.astype(float)).mean() > BLANK for column in used):
            return
        for block in _blocks_of(data):
            block.pop('missing', None)
            block['time'] = _own_time(time)
        self.assumptions.append('Empty cells: each curve has its own samples; they are '
                                'interpolated onto those of the first signal.')

    # --- table ----------------------------------------------------------------------------------
    def _table(self, series: Sequence[Series], descriptions: Sequence[Meaning],
               choices: Sequence[Choice], time: FoundTime) -> list[TableRow]:
        """Return a line for each column; of joints that are alike one for all of them."""
        rows = [TableRow(', '.join(time.labels) or 'none', 'time', _time_unit(time.block), 'given'
                         if time.column is None else time.remarks[0].partition(', ')[2])]
        if self.key is not None:
            rows.append(TableRow(self.key.column.label, 'joint', '',
                                 f'a row for each: {", ".join(self.key.rows)}'))
        by_number = {column.number: (choice, role) for choice in choices
                     for role, column in choice.roles.items()}
        unused = {number: reason for choice in choices for number, reason in choice.left.items()}
        families: dict[tuple[str, ...], tuple[str, list[str]]] = {}  # reason of the first, labels
        for k, meaning in enumerate(descriptions):
            choice, role = by_number.get(k, (None, ''))
            unit = meaning.unit
            if role:
                usual = SI[self._axis(choice) if choice else self.kind][
                    signal_kind(role).quantity]
                unit = self.blocks.get(k, {}).get('unit') or unit or usual
                unit += '' if meaning.stated else '?'
            reason = choice.reasons[role] if choice is not None else unused.get(
                k, _no_role(meaning, bool(choices[0].joint), series[k]))
            key = (stem_of(meaning), role, unit, _alike(reason, meaning))
            families.setdefault(key, (reason, []))[1].append(meaning.label)
        for (_, role, unit, _), (reason, labels) in families.items():
            name = labels[0] if len(set(labels)) == 1 else f'{labels[0]} ... {labels[-1]}'
            rows.append(TableRow(name, role, unit, reason))
        return rows


def _blocks_of(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the blocks of all signals of a mapping."""
    return [block for signals in (data.get('joints') or {'': data['signals']}).values()
            for block in signals.values()]


def _with_row_key(data: Mapping[str, Any], key: RowKey, time: FoundTime) -> None:
    """Give each signal of a table with a row for each joint the time of its own rows."""
    for block in _blocks_of(data):
        block['time'] = {**_own_time(time), 'only': block.pop('only'),
                         'segment': next(iter(key.column.place.values()))}


def _own_time(time: FoundTime) -> dict[str, Any]:
    """Return the block of the time of one signal; the recording begins at the common one."""
    return {name: value for name, value in time.block.items() if name != 'start_stamp_ns'}


def _names_of(role: str) -> list[str]:
    """Return what --unit may call a role, the most special name first."""
    return [role, *(name for name in ROLES if ROLES[name] == role), signal_kind(role).quantity]


def _alike(reason: str, meaning: Meaning) -> str:
    """Return the reason without what differs from joint to joint."""
    return re.sub(rf'\b{re.escape(meaning.joint)}\b', 'JOINT', reason) if meaning.joint else reason


def _time_unit(block: Mapping[str, Any]) -> str:
    return f'{block["rate"]:g} Hz' if 'rate' in block else str(block.get('unit', 's'))


def _no_role(meaning: Meaning, several: bool, column: Series) -> str:
    """Return why a column has no role."""
    if meaning.quantity in (POSITION, VELOCITY, EFFORT):
        if np.nanmax(column.values) == np.nanmin(column.values):
            return 'the same value throughout'
        if several and not meaning.joint:
            return 'no joint in its name'
        return f'{meaning.source or "another"} {meaning.quantity}'
    return f'{meaning.quantity}' if meaning.quantity else 'nothing of a joint by its name'


def _renamed(path: Path, layout: Format, columns: str) -> Format:
    """Return `layout` with the names that the text `columns` gives all of its columns."""
    if not columns:
        return layout
    names: list[str] = []
    for part in re.split(r',(?![^\[]*\])', columns):
        match = re.fullmatch(r'\s*(.*?)\[(\d+)\]\s*(.*?)\s*', part)
        if match and not 1 <= int(match[2]) <= MOST_JOINTS:
            raise InputError(f'--columns: {part.strip()}, expected 1 to {MOST_JOINTS} in brackets')
        names += [f'{match[1]}_{k + 1} {match[3]}'.strip() for k in range(int(match[2]))] \
            if match else [part.strip()]
    if len(names) != len(layout.series):
        raise InputError(f'{path}: --columns names {len(names)} columns, expected '
                         f'{len(layout.series)}, those of numbers: '
                         f'{", ".join(c.label for c in layout.series)[:200]}')
    return replace(layout, named=True, series=[
        replace(column, label=name, unit=scaled_unit(name, True)[1])
        for column, name in zip(layout.series, names) if name not in ('-', '')])
