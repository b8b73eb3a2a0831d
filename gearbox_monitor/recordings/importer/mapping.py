# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The mapping file: which columns or fields of a foreign recording are which signals of a drive.

A value of a signal is ``sign ((raw - zero) scale + offset)`` in its unit, which converts it to SI.
Keys outside this vocabulary raise an error.
"""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import yaml

from gearbox_monitor.errors import expect_choice, expect_keys, InputError, Problems
from gearbox_monitor.files.opening import config_path
from gearbox_monitor.files.yaml_files import load_yaml
from gearbox_monitor.recordings.importer.header import (
    header_references, header_values, with_header, with_settings)
from gearbox_monitor.recordings.importer.unit_table import axis_of, TIME, TURN, unit_factor

FORMATS = ('text', 'mat', 'json', 'hdf5', 'numpy', 'parquet', 'feather')
TABLES = ('text', 'parquet', 'feather')  # columns with names; the others have fields
KINDS = ('rotary', 'prismatic')
CODINGS = ('twos_complement', 'sign_magnitude')
REPEATED = ('error', 'first', 'average', 'drop')
UNORDERED = ('error', 'sort', 'drop')


class SignalKind(NamedTuple):
    """Quantity of a signal, and whether it is the effort of the motor, or on the motor side."""

    quantity: str
    motor_effort: bool
    motor_side: bool


SIGNALS = {
    'motor_position': SignalKind('position', False, True),
    'motor_velocity': SignalKind('velocity', False, True),
    'motor_setpoint': SignalKind('position', False, True),
    'motor_effort': SignalKind('effort', True, True),
    'arm_position': SignalKind('position', False, False),
    'arm_velocity': SignalKind('velocity', False, False),
    'arm_effort': SignalKind('effort', False, False),
    'reference_torque': SignalKind('effort', False, False),
}
JOINT_SIGNALS = {  # of a robot, all of them as the joint itself has them
    'position': SignalKind('position', False, False),
    'velocity': SignalKind('velocity', False, False),
    'effort': SignalKind('effort', True, False),
    'setpoint': SignalKind('position', False, False),
}
STAMPS = ('recorded', 'even')
MAX_HEADER = 100  # rows
SECOND = ': second_file'  # in the name of a mapping
FIRST_STAMP_NS = 1_000_000_000  # stamp 0 means "no stamp" to ROS and to the estimator


@dataclass(frozen=True)
class TimeMapping:
    """
    Place of the time of a sample, or the constant `rate` (Hz) of a recording without time.

    unit: of TIME, or 'iso8601'. repeated, unordered: what becomes of samples with one stamp, and
    of those whose stamp is before an earlier one. nanosec: column of the nanoseconds that are
    added. segment: column whose value changes where another recording begins, with its own time,
    or that names the joint of a row; only: its value in the rows that are read. stamps: 'even'
    lays an even grid through them.
    """

    column: int | str | None = None
    field: str | None = None
    scale: float = 1.0
    unit: str = 's'
    rate: float | None = None
    start_stamp_ns: int | str = FIRST_STAMP_NS
    repeated: str = 'error'
    unordered: str = 'error'
    nanosec: int | str | None = None
    segment: int | str | None = None
    only: int | str | None = None
    stamps: str = 'recorded'


@dataclass(frozen=True)
class SignalMapping:
    """
    One signal of the recording; `column` counts from 1 or is a name of the header row.

    time: its own, where it was not sampled together with the others. unit_scale: of `unit`, to SI.
    """

    column: int | str | None = None
    field: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    counts_per_rev: float | None = None
    torque_constant: float = 1.0
    sign: int = 1
    zero: float | str = 0.0
    bits: int | None = None
    coding: str = 'twos_complement'
    missing: str = 'error'
    unit: str = ''
    unit_scale: float = 1.0
    time: TimeMapping | None = None

    def factor(self) -> float:
        """Return the factor from the unit of `scale` to SI units."""
        rev = TURN / self.counts_per_rev if self.counts_per_rev else 1.0
        return self.sign * self.unit_scale * rev * self.torque_constant


@dataclass(frozen=True)
class TextFormat:
    """
    Format of a text file; `delimiter` 'whitespace' is any run of blanks and tabs.

    header: number of header rows (true: 1), or 'comment': names in the last comment before the
    data. skip: lines before anything else. rows: 'samples', 'signals' (a row per signal) or
    'auto': by shape.
    """

    delimiter: str = ','
    comment: str = '#'
    encoding: str = 'utf-8'
    header: bool | int | str = False
    decimal: str = '.'
    skip: int = 0
    rows: str = 'auto'


@dataclass(frozen=True)
class JsonFormat:
    """Dotted path of the list of entries; None: `field` is the path of a list of numbers."""

    entries: str | None = None


@dataclass(frozen=True)
class ImportMapping:
    """
    A checked mapping file; `yaml_text` is its content, `source` its path.

    references: {dotted key of `data`: (name in the header of a recording, scale)}, for bound_to.
    joints: of a robot; their signals are called 'JOINT:QUANTITY'.
    """

    source: str
    yaml_text: str
    format: str
    time: TimeMapping
    signals: Mapping[str, SignalMapping]
    kind: str = 'rotary'
    gear_ratio: float = 1.0
    description: str = ''
    text: TextFormat = field(default_factory=TextFormat)
    json: JsonFormat = field(default_factory=JsonFormat)
    second_file: 'SecondFile | None' = None
    data: Any = None
    references: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    joints: tuple[str, ...] = ()


@dataclass(frozen=True)
class SecondFile:
    """
    Further signals of the same run in a file with its own clock.

    path: beside the first file; ``{stem}`` stands for the name of that without its endings. lag:
    s, added to the times of this file; 'estimated': from the motion.
    """

    path: str
    lag: float | str
    mapping: ImportMapping


Place: TypeAlias = SignalMapping | TimeMapping
_KEYS = ('format', 'description', 'kind', 'gear_ratio', 'time', 'signals', 'joints', 'text',
         'json', 'second_file')


def signal_kind(name: str) -> SignalKind:
    """Return the SignalKind of the signal `name`, 'JOINT:QUANTITY' of a robot."""
    return JOINT_SIGNALS[name.rpartition(':')[2]] if ':' in name else SIGNALS[name]


def key_of(name: str) -> str:
    """Return the key of the signal or time `name` in a mapping."""
    if name.partition('.')[0] == 'time':
        return name
    joint, colon, quantity = name.rpartition(':')
    return f'joints.{joint}.{quantity}' if colon else f'signals.{name}'


def find_mapping(name: str | Path) -> Path:
    """Return the path of the mapping `name`: a path or the name of a packaged mapping."""
    if Path(name).is_file():
        return Path(name)
    try:
        return config_path(f'import/{name}.yaml')
    except InputError:
        packaged = sorted(p.stem for p in config_path(
            'import/davinci_backend.yaml').parent.glob('*.yaml'))
        raise InputError(f'--map: {str(name)!r}, expected a mapping file or one of '
                         f'{", ".join(packaged)}') from None


def load_mapping(name: str | Path, settings: Sequence[str] = ()) -> ImportMapping:
    """
    Return the ImportMapping `name`: a file or a packaged mapping.

    `settings` are ``KEY=VALUE`` that replace values, keys dotted as in 'time.unit=ms'. Raises
    InputError.
    """
    path = find_mapping(name)
    data = load_yaml(path)
    with data.located():
        content = with_settings(data.content, settings)
        return mapping_from_dict(content, str(path), None if settings else data.text)


def bound_to(mapping: ImportMapping, recording: str | Path) -> ImportMapping:
    """Return `mapping` with the values that it takes from the header of `recording`."""
    if not mapping.references:
        return mapping
    names = [name for name, _ in mapping.references.values()]
    values = header_values(recording, mapping.data, names)
    return mapping_from_dict(with_header(mapping.data, mapping.references, values,
                                         str(recording)), mapping.source, mapping.yaml_text)


def mapping_from_dict(data: Any, source: str, yaml_text: str | None = None) -> ImportMapping:
    """
    Check a mapping.

    Args:
        data: plain values, as in the mapping file.
        source: name of the mapping in error messages.
        yaml_text: text of the file; None: `data` as YAML.

    Returns:
        The ImportMapping.

    Raises:
        InputError: it names all keys with a wrong value.
    """
    text = yaml.safe_dump(data, sort_keys=False) if yaml_text is None else yaml_text
    original = data
    try:
        references = header_references(data)
    except InputError as error:
        raise InputError(f'{source}: {error}') from None
    # The numbers are checked once they were read; until then any will do.
    data = with_header(data, references, {name: 1.0 for name, _ in references.values()}, '')
    expect_keys(data, 'mapping', source, _KEYS, whole=True)
    if 'joints' in data and 'signals' in data:
        raise InputError(f'{source}: joints: beside signals, expected one of the two')
    needed = 'joints' if 'joints' in data else 'signals'
    for key in ('format', 'time', needed):
        if key not in data:
            raise InputError(f'{source}: {key}: missing, expected one of '
                             f'{", ".join(FORMATS)}' if key == 'format' else
                             f'{source}: {key}: missing, expected keys and values')
    kind = data['format']
    expect_choice(kind, 'format', source, FORMATS)
    for name in ('text', 'json'):
        if name in data and name != kind:
            raise InputError(f'{source}: {name}: a block for another format, expected only '
                             f'blocks for format {kind}')
    values: dict[str, Any] = {'format': kind, 'description': str(data.get('description', ''))}
    values['kind'] = expect_choice(data.get('kind', 'rotary'), 'kind', source, KINDS)
    problems = Problems()
    with problems:
        values['gear_ratio'] = _number(data.get('gear_ratio', 1.0), 'gear_ratio', source,
                                       nonzero=True)
    if 'second_file' in data:
        with problems:
            values['second_file'] = _second_file(data, source)
    if 'text' in data:
        with problems:
            values['text'] = _text(data['text'], source)
    if 'json' in data:
        with problems:
            expect_keys(data['json'], 'json', source, ('entries',))
            entries = _string(data['json'].get('entries'), 'json.entries', source)
            values['json'] = JsonFormat(entries[:-2] if entries.endswith('[]') else entries)
    with problems:
        values['time'] = _time(data['time'], source, kind)
    values['signals'] = {}
    blocks = _blocks(data, needed, source, problems)
    for name, block in blocks.items():
        with problems:
            values['signals'][name] = _signal(name, block, source, kind,
                                              _axis_of_signal(name, blocks, values['kind']))
    if needed == 'joints' and isinstance(data['joints'], dict):
        values['joints'] = tuple(map(str, data['joints']))
        if 'gear_ratio' in data:
            problems.found.append(f'{source}: gear_ratio: beside joints, expected signals of the '
                                  'joints themselves')
    problems.raise_all()
    second = values.get('second_file')
    if not source.endswith(SECOND) and not any(
            signal_kind(name).quantity != 'effort' and not name.endswith('setpoint') for name in
            (*values['signals'], *(second.mapping.signals if second else ()))):
        raise InputError(f'{source}: signals: no position, expected motor_position, arm_position '
                         'or both, or a velocity')
    return ImportMapping(source=source, yaml_text=text, data=original, references=references,
                         **values)


def _axis_of_signal(name: str, blocks: Mapping[str, Any], kind: str) -> str:
    """Return the axis of a signal: of a drive `kind`, of a robot what its joint's units say."""
    joint, colon, _ = name.rpartition(':')
    return axis_of((str(block['unit']) for signal, block in blocks.items()
                    if signal.rpartition(':')[0] == joint and isinstance(block, dict)
                    and 'unit' in block), kind) if colon else kind


def _blocks(data: Mapping[str, Any], key: str, source: str, problems: Problems) -> dict[str, Any]:
    """Return {name of the signal: its block} of `data[key]`, 'signals' or 'joints'."""
    content = data[key]
    if key == 'signals':
        with problems:
            expect_keys(content, 'signals', source, SIGNALS)
        return {name: block for name, block in content.items() if name in SIGNALS} \
            if isinstance(content, dict) else {}
    blocks = {}
    for joint, signals in content.items() if isinstance(content, dict) else ():
        with problems:
            expect_keys(signals, f'joints.{joint}', source, JOINT_SIGNALS)
            blocks.update({f'{joint}:{name}': block for name, block in signals.items()})
    if not blocks:
        problems.found.append(f'{source}: joints: {str(content)[:40]!r}, expected signals by '
                              'joint')
    return blocks


def _second_file(data: Mapping[str, Any], source: str) -> SecondFile:
    """Return the SecondFile of the mapping `data`, whose axis and gear ratio are those of it."""
    block = data['second_file']
    expect_keys(block, 'second_file', source, ('path', 'lag', *_KEYS[:-1]))
    path = _string(block.get('path'), 'second_file.path', source)
    lag = block.get('lag')
    if lag != 'estimated':
        lag = _number(lag, 'second_file.lag', source, also="(s) or 'estimated'")
    inner = {**{key: data[key] for key in ('kind', 'gear_ratio') if key in data},
             **{key: value for key, value in block.items() if key not in ('path', 'lag')}}
    mapping = mapping_from_dict(inner, source + SECOND)
    first = _blocks(data, 'joints' if 'joints' in data else 'signals', source, Problems())
    both = set(mapping.signals) & set(first)
    if both or not mapping.signals:
        raise InputError(f'{source}: second_file.signals: {", ".join(sorted(both)) or "none"}, '
                         'expected signals that the first file does not have')
    return SecondFile(path, lag, mapping)


def _text(block: Any, source: str) -> TextFormat:
    expect_keys(block, 'text', source, [f.name for f in fields(TextFormat)])
    text = TextFormat(**block)
    for name in ('delimiter', 'comment', 'encoding', 'decimal'):
        _string(getattr(text, name), f'text.{name}', source)
    if text.header != 'comment' and not (
            isinstance(text.header, int) and 0 <= text.header <= MAX_HEADER):
        raise InputError(f'{source}: text.header: {text.header!r}, expected true, false, a number '
                         f"of rows up to {MAX_HEADER} or 'comment'")
    if isinstance(text.skip, bool) or not isinstance(text.skip, int) or text.skip < 0:
        raise InputError(f'{source}: text.skip: {text.skip!r}, expected a number of lines')
    expect_choice(text.rows, 'text.rows', source, ('auto', 'samples', 'signals'))
    if text.delimiter != 'whitespace' and len(text.delimiter) != 1:
        raise InputError(f'{source}: text.delimiter: {text.delimiter!r}, expected one character '
                         "or 'whitespace'")
    expect_choice(text.decimal, 'text.decimal', source, ('.', ','))
    if text.decimal == text.delimiter:
        raise InputError(f'{source}: text.decimal: {text.decimal!r}, expected another character '
                         'than text.delimiter')
    try:
        'x'.encode(text.encoding)
    except LookupError:
        raise InputError(f'{source}: text.encoding: {text.encoding!r}, expected an encoding such '
                         'as utf-8 or latin-1') from None
    return text


def _time(block: Any, source: str, kind: str, where: str = 'time') -> TimeMapping:
    allowed = [f.name for f in fields(TimeMapping)]
    if where != 'time':  # of one signal: the recording begins where the common time begins
        allowed.remove('start_stamp_ns')
    expect_keys(block, where, source, allowed)
    if 'rate' in block:
        for key in ('column', 'field', 'scale', 'unit'):
            if key in block:
                raise InputError(f'{source}: {where}.{key}: given beside {where}.rate, expected '
                                 'one of the two')
        _number(block['rate'], f'{where}.rate', source, positive=True)
    else:
        _place(block, where, source, kind)
    for key in ('nanosec', 'segment'):
        _column(block.get(key, 1), f'{where}.{key}', source, kind in TABLES)
    if 'only' in block and ('segment' not in block or not isinstance(
            block['only'], (int, str))):
        raise InputError(f'{source}: {where}.only: {block["only"]!r}, expected a whole number '
                         'or a name beside segment')
    expect_choice(block.get('stamps', STAMPS[0]), f'{where}.stamps', source, STAMPS)
    _number(block.get('scale', 1.0), f'{where}.scale', source, positive=True)
    expect_choice(block.get('unit', 's'), f'{where}.unit', source, (*TIME, 'iso8601'))
    expect_choice(block.get('repeated', 'error'), f'{where}.repeated', source, REPEATED)
    expect_choice(block.get('unordered', 'error'), f'{where}.unordered', source, UNORDERED)
    start = block.get('start_stamp_ns', FIRST_STAMP_NS)
    if start != 'recorded' and (isinstance(start, bool) or not isinstance(start, int)
                                or start <= 0):
        raise InputError(f'{source}: {where}.start_stamp_ns: {start!r}, expected an integer > 0 '
                         "(ns) or 'recorded'")
    return TimeMapping(**block)


def _signal(name: str, block: Any, source: str, kind: str, axis: str) -> SignalMapping:
    quantity, motor_effort, _ = signal_kind(name)
    where = key_of(name)
    allowed = ['column', 'field', 'scale', 'offset', 'sign', 'zero', 'bits', 'coding', 'missing',
               'unit', 'time']
    allowed += ['counts_per_rev'] if quantity != 'effort' and axis == 'rotary' else []
    allowed += ['torque_constant'] if motor_effort else []
    expect_keys(block, where, source, allowed)
    _place(block, where, source, kind)
    for key in ('scale', 'counts_per_rev', 'torque_constant'):
        if key in block:
            _number(block[key], f'{where}.{key}', source, positive=True)
    if block.get('sign', 1) not in (1, -1):
        raise InputError(f'{source}: {where}.sign: {block["sign"]!r}, expected 1 or -1')
    _number(block.get('offset', 0.0), f'{where}.offset', source)
    if block.get('zero') != 'first':
        _number(block.get('zero', 0.0), f'{where}.zero', source, also="or 'first'")
    bits = block.get('bits', 16)
    if isinstance(bits, bool) or not isinstance(bits, int) or not 2 <= bits <= 52:
        raise InputError(f'{source}: {where}.bits: {bits!r}, expected an integer from 2 to 52')
    expect_choice(block.get('coding', CODINGS[0]), f'{where}.coding', source, CODINGS)
    if 'coding' in block and 'bits' not in block:
        raise InputError(f'{source}: {where}.bits: missing, expected the bits of this coding')
    expect_choice(block.get('missing', 'error'), f'{where}.missing', source, ('error', 'nan'))
    values = {**block, 'unit_scale': _unit_scale(block, where, source, (quantity, axis))}
    if 'time' in block:
        values['time'] = _time(block['time'], source, kind, f'{where}.time')
    return SignalMapping(**values)


def _unit_scale(block: Mapping[str, Any], where: str, source: str, quantity: tuple[str, str]
                ) -> float:
    """Return the factor to SI of the unit in `block`; check it against what stands beside it."""
    if 'unit' not in block:
        return 1.0
    unit = _string(block['unit'], f'{where}.unit', source)
    try:
        factor, complete = unit_factor(unit, *quantity)
    except InputError as error:
        raise InputError(f'{source}: {where}.unit: {error}') from None
    second = [key for key in ('counts_per_rev', 'torque_constant') if key in block]
    if complete and second:
        raise InputError(f'{source}: {where}.{second[0]}: beside unit {unit!r}, expected one of '
                         'the two')
    if not complete and not second and ('scale' not in block or factor != 1.0):
        expected = ('counts_per_rev or scale' if quantity == ('position', 'rotary') or
                    quantity == ('velocity', 'rotary') else
                    'torque_constant or scale' if 'motor_effort' in where or
                    where.startswith('joints.') else 'scale')
        raise InputError(f'{source}: {where}.unit: {unit!r} needs a factor to SI, expected '
                         f'{expected} beside it')
    return factor


def _place(block: Mapping[str, Any], where: str, source: str, kind: str) -> None:
    """Check `column` and `field`: tables have columns, the other formats fields or both."""
    if kind in TABLES:
        allowed, needed = ['column'], ['column']
    else:
        allowed = ['field', 'column']
        needed = allowed if kind in ('json', 'numpy') else ['field']
    if not any(key in block for key in needed):
        raise InputError(f'{source}: {where}.{needed[0]}: missing, expected the '
                         f'{" or ".join(needed)} of a {kind} recording')
    for key in ('column', 'field'):
        if key in block and key not in allowed:
            raise InputError(f'{source}: {where}.{key}: a {kind} recording has none, expected '
                             f'{needed[0]}')
    if 'field' in block:
        _string(block['field'], f'{where}.field', source)
    _column(block.get('column', 1), f'{where}.column', source, kind in TABLES)


def _column(column: Any, where: str, source: str, has_names: bool) -> None:
    """Check the `column` that the key `where` names; has_names: a name will do, too."""
    by_name = isinstance(column, str) and column and (has_names or not where.endswith('.column'))
    if isinstance(column, bool) or not (by_name or (isinstance(column, int) and column >= 1)):
        raise InputError(f'{source}: {where}: {column!r}, expected a number from 1'
                         + (' or a name of the header row' if has_names else ''))


def _string(value: Any, name: str, source: str) -> str:
    if not isinstance(value, str) or not value:
        raise InputError(f'{source}: {name}: {value!r}, expected text')
    return value


def _number(value: Any, name: str, source: str, positive: bool = False, nonzero: bool = False,
            also: str = '') -> float:
    finite = isinstance(value, (int, float)) and not isinstance(value, bool)
    finite = finite and -1e300 < value < 1e300
    if not finite or (positive and value <= 0) or (nonzero and value == 0):
        bound = ' > 0' if positive else ' other than 0' if nonzero else ''
        raise InputError(f'{source}: {name}: {value!r}, expected a number{bound} {also}'.rstrip())
    return float(value)
