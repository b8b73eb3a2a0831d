# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The mapping file: which columns of a recording are which signals of a drive or of a robot.

A value of a signal is ``sign ((raw - zero) scale + offset)`` in its unit, which converts it to SI.
A number may be ``{from_header: NAME, scale: 1.0}``: a number that the recording itself states.
"""
from collections.abc import Mapping as Table, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from gearbox_monitor.errors import (
    Check, expect, expect_choice, expect_keys, expect_values, InputError, number_check, Problems)
from gearbox_monitor.files.user_files import config_path, load_yaml
from gearbox_monitor.recordings.meaning import (
    axis_of, EFFORT, POSITION, PRISMATIC, ROTARY, TIME, unit_factor, units_of, VELOCITY)

TURN = 6.283185307179586
CODINGS = ('twos_complement', 'sign_magnitude')
STAMPS = ('recorded', 'even')
FROM_HEADER = 'from_header'
KEYS = ('description', 'kind', 'gear_ratio', 'time', 'signals', 'joints')


class SignalKind(NamedTuple):
    """Quantity of a signal, whether it is an effort of the motor, or on the motor's side."""

    quantity: str
    motor_effort: bool
    motor_side: bool


SIGNALS = {
    'motor_position': SignalKind(POSITION, False, True),
    'motor_velocity': SignalKind(VELOCITY, False, True),
    'motor_setpoint': SignalKind(POSITION, False, True),
    'motor_effort': SignalKind(EFFORT, True, True),
    'arm_position': SignalKind(POSITION, False, False),
    'arm_velocity': SignalKind(VELOCITY, False, False),
    'arm_effort': SignalKind(EFFORT, False, False),
    'reference_torque': SignalKind(EFFORT, False, False),
}
JOINT_SIGNALS = {  # of a robot, all of them as the joint itself has them
    'position': SignalKind(POSITION, False, False),
    'velocity': SignalKind(VELOCITY, False, False),
    'effort': SignalKind(EFFORT, True, False),
    'setpoint': SignalKind(POSITION, False, False),
}


@dataclass(frozen=True)
class TimeMapping:
    """
    Column of the time of a sample, or the constant `rate` (Hz) of a recording without time.

    unit: of time, or 'iso8601'. nanosec: column of the nanoseconds that are added. segment: column
    whose value changes where another recording begins, with its own time; only: its value in the
    rows that are read. stamps: 'even' lays an even grid through them.
    """

    column: int | str | None = None
    unit: str = 's'
    scale: float = 1.0
    rate: float | None = None
    nanosec: int | str | None = None
    segment: int | str | None = None
    only: int | str | None = None
    stamps: str = STAMPS[0]


@dataclass(frozen=True)
class SignalMapping:
    """
    One signal of the recording; `column` counts from 1 or is a name.

    time: its own, where it was not sampled together with the others. unit_scale: of `unit`, to SI.
    complete: the unit says what a value is, no constant of a model is needed.
    """

    column: int | str
    scale: float = 1.0
    offset: float = 0.0
    counts_per_rev: float | None = None
    torque_constant: float = 1.0
    sign: int = 1
    zero: float | str = 0.0
    bits: int | None = None
    coding: str = CODINGS[0]
    unit: str = ''
    time: TimeMapping | None = None
    unit_scale: float = 1.0
    complete: bool = True

    def factor(self) -> float:
        """Return the factor from the unit of `scale` to SI units."""
        rev = TURN / self.counts_per_rev if self.counts_per_rev else 1.0
        return self.sign * self.unit_scale * rev * self.torque_constant


@dataclass(frozen=True)
class Mapping:
    """
    A checked mapping; `data` is its content as plain values, `source` its path.

    joints: of a robot; their signals are called 'JOINT:QUANTITY'.
    """

    source: str
    data: Table[str, Any]
    time: TimeMapping
    signals: Table[str, SignalMapping]
    kind: str = ROTARY
    gear_ratio: float = 1.0
    joints: tuple[str, ...] = ()


def kind_of(name: str) -> SignalKind:
    """Return the SignalKind of the signal `name`, 'JOINT:QUANTITY' of a robot."""
    return JOINT_SIGNALS[name.rpartition(':')[2]] if ':' in name else SIGNALS[name]


def key_of(name: str) -> str:
    """Return the key of the signal `name` in a mapping."""
    joint, colon, quantity = name.rpartition(':')
    return f'joints.{joint}.{quantity}' if colon else f'signals.{name}'


def load_mapping(name: str | Path, settings: Sequence[str] = ()) -> tuple[dict[str, Any], str]:
    """
    Return (content, path) of the mapping `name`: a file or a packaged mapping.

    Args:
        name: of it.
        settings: ``KEY=VALUE`` that replace values.

    Raises:
        InputError: there is none, or it is no YAML.
    """
    path = Path(name)
    if not path.is_file():
        try:
            path = config_path(f'import/{name}.yaml')
        except InputError:
            packaged = sorted(p.stem for p in config_path('import/emps.yaml').parent.glob(
                '*.yaml'))
            raise InputError(f'--map: {str(name)!r}, expected a mapping file or one of '
                             f'{", ".join(packaged)}') from None
    return with_settings(load_yaml(path).content, settings), str(path)


def with_settings(data: Any, settings: Sequence[str]) -> Any:
    """Return a copy of `data` with the values of the ``KEY=VALUE`` in `settings`."""
    result = deepcopy(data)
    for setting in settings:
        key, equals, text = setting.partition('=')
        if not equals or not key:
            raise InputError(f'--set: {setting!r}, expected KEY=VALUE such as '
                             'signals.arm_position.zero=12')
        value: Any = {'true': True, 'false': False}.get(text, text)
        for kind in (float, int):
            try:
                value = kind(text)
            except ValueError:
                continue
        *parts, last = key.split('.')
        target = result
        for part in parts:
            target = target.setdefault(part, {}) if isinstance(target, dict) else None
        if not isinstance(target, dict):
            raise InputError(f'--set: {setting!r}, expected a dotted key of the mapping')
        target[last] = value
    return result


def mapping_of(data: Any, source: str, header: Table[str, float] | None) -> Mapping:
    """
    Return the checked Mapping.

    Args:
        data: plain values, as in the mapping file.
        source: name of the mapping in messages.
        header: numbers that the recording states, for references; None: not read yet.

    Raises:
        InputError: it names all keys with a wrong value.
    """
    expect_keys(data, 'mapping', source, KEYS, whole=True)
    data = _with_header(data, header, source)
    if ('joints' in data) == ('signals' in data):
        raise InputError(f'{source}: joints: expected either signals of a drive or joints of a '
                         'robot')
    if 'time' not in data:
        raise InputError(f'{source}: time: missing, expected keys and values')
    kind, ratio = data.get('kind', ROTARY), data.get('gear_ratio', 1.0)
    expect_choice(kind, 'kind', source, (ROTARY, PRISMATIC))
    problems, time = Problems(), TimeMapping()
    with problems:
        expect(ratio, 'gear_ratio', source, number_check('a number other than 0', lambda x: (
            abs(x) >= LEAST)))
    with problems:
        time = _time(data['time'], source)
    signals: dict[str, SignalMapping] = {}
    blocks = _blocks(data, source, problems)
    for name, block in blocks.items():
        with problems:
            joint = name.rpartition(':')[0]
            axis = kind if not joint else axis_of((
                str(other['unit']) for key, other in blocks.items() if key.rpartition(':')[0]
                == joint and isinstance(other, dict) and 'unit' in other), kind)
            signals[name] = _signal(name, block, source, axis)
    if 'joints' in data and 'gear_ratio' in data:
        problems.found.append(f'{source}: gear_ratio: stated for joints, expected signals of the '
                              'joints themselves')
    problems.raise_all()
    if not any(kind_of(name).quantity != EFFORT and not name.endswith('setpoint')
               for name in signals):
        raise InputError(f'{source}: signals: no position, expected motor_position, arm_position '
                         'or both, or a velocity')
    return Mapping(source, data, time, signals, kind, ratio, tuple(
        map(str, data.get('joints', ()))))


def _with_header(data: Any, header: Table[str, float] | None, source: str) -> Any:
    """Return a copy of `data` with the numbers of the `header` that it refers to."""
    if not isinstance(data, dict):
        return data
    result: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict) and FROM_HEADER in value:
            name, scale = value[FROM_HEADER], value.get('scale', 1.0)
            if not isinstance(name, str) or set(value) - {FROM_HEADER, 'scale'}:
                raise InputError(f'{source}: {key}: {value!r}, expected {{{FROM_HEADER}: NAME, '
                                 'scale: NUMBER}')
            if header is not None and name not in header:
                raise InputError(f'{source}: {key}: no number {name!r} in the header of the '
                                 'recording, expected one of '
                                 f'{", ".join(sorted(header))[:200] or "none"}')
            expect(scale, f'{key}.scale', source, NUMBER)
            value = scale * (1.0 if header is None else header[name])
        result[key] = _with_header(value, header, source)
    return result


def _blocks(data: Table[str, Any], source: str, problems: Problems) -> dict[str, Any]:
    """Return {name of the signal: its block} of a mapping."""
    is_drive = 'signals' in data
    groups, names = ({'': data['signals']}, SIGNALS) if is_drive else (
        data['joints'], JOINT_SIGNALS)
    blocks: dict[str, Any] = {}
    for joint, signals in groups.items() if isinstance(groups, dict) else ():
        with problems:
            expect_keys(signals, 'signals' if is_drive else f'joints.{joint}', source, names)
            blocks.update({name if is_drive else f'{joint}:{name}': block
                           for name, block in signals.items()})
    if not blocks and not is_drive:
        problems.found.append(f'{source}: joints: {str(groups)[:40]!r}, expected signals by joint')
    return blocks


LEAST = 1e-100  # a smaller number is 0
NUMBER = number_check()
POSITIVE = number_check('a number > 0', lambda x: x >= LEAST)


def _column(value: Any) -> str:
    right = not isinstance(value, bool) and (
        isinstance(value, str) and value or isinstance(value, int) and value >= 1)
    return '' if right else 'the name of a column or a number from 1'


def _choice(*choices: Any) -> Check:
    return lambda value: '' if value in choices else f'one of {", ".join(map(str, choices))}'


OF_TIME: Table[str, Check] = {
    'column': _column, 'nanosec': _column, 'segment': _column, 'scale': POSITIVE,
    'unit': lambda value: _choice(*units_of(TIME), 'iso8601')(value),
    'rate': number_check('0.001 to 1e6 Hz', lambda x: 1e-3 <= x <= 1e6),
    'only': lambda value: '' if isinstance(value, (int, str)) else 'a whole number or a name',
    'stamps': _choice(*STAMPS)}
OF_SIGNAL: Table[str, Check] = {
    'column': _column, 'scale': POSITIVE, 'offset': NUMBER, 'counts_per_rev': POSITIVE,
    'torque_constant': POSITIVE, 'coding': _choice(*CODINGS),
    'sign': lambda value: '' if value in (1, -1) else '1 or -1',
    'zero': lambda value: '' if value == 'first' else NUMBER(value) and "a number or 'first'",
    'bits': number_check('an integer from 2 to 52', lambda n: isinstance(n, int) and 2 <= n <= 52),
    'unit': lambda value: '' if isinstance(value, str) else 'text', 'time': lambda value: ''}


def _time(block: Any, source: str, where: str = 'time') -> TimeMapping:
    """Return the TimeMapping of a `block` at the key `where`. Raises InputError."""
    rated = isinstance(block, dict) and 'rate' in block
    expect_values(block, where, source, OF_TIME, () if rated else ('column',))
    both = [key for key in ('column', 'scale', 'unit') if rated and key in block]
    if both:
        raise InputError(f'{source}: {where}.{both[0]}: with {where}.rate, expected one of the '
                         'two')
    if 'only' in block and 'segment' not in block:
        raise InputError(f'{source}: {where}.only: {block["only"]!r}, expected it with segment')
    return TimeMapping(**block)


def _signal(name: str, block: Any, source: str, axis: str) -> SignalMapping:
    """Return the SignalMapping of a `block` of the signal `name`. Raises InputError."""
    quantity, motor_effort, _ = kind_of(name)
    where = key_of(name)
    has = {'counts_per_rev': quantity != EFFORT and axis == ROTARY,
           'torque_constant': motor_effort}
    expect_values(block, where, source, {key: check for key, check in OF_SIGNAL.items()
                                         if has.get(key, True)}, ('column',))
    if 'coding' in block and 'bits' not in block:
        raise InputError(f'{source}: {where}.bits: missing, expected the bits of this coding')
    values = dict(block)
    if 'unit' in block:
        try:
            values['unit_scale'], complete = unit_factor(block['unit'], quantity, axis)
        except InputError as error:
            raise InputError(f'{source}: {where}.unit: {error}') from None
        second = [key for key in ('counts_per_rev', 'torque_constant') if key in block]
        if complete and second:
            raise InputError(f'{source}: {where}.{second[0]}: with unit {block["unit"]!r}, '
                             'expected one of the two')
        values['complete'] = complete or bool(second) or 'scale' in block
        if quantity != EFFORT and not values['complete']:
            raise InputError(f'{source}: {where}.unit: {block["unit"]!r} needs a factor to SI, '
                             'expected counts_per_rev or scale')
    if 'time' in block:
        values['time'] = _time(block['time'], source, f'{where}.time')
    return SignalMapping(**values)
