# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The mapping file: which columns or fields of a foreign recording are which signals of a drive.

A value of a signal is ``sign (raw - zero) scale``, in SI units. Keys outside this vocabulary raise
an error.
"""
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
import math
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import yaml

from gearbox_monitor.errors import InputError, Problems, unknown
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.yaml_files import load_yaml

FORMATS = ('text', 'mat', 'json')
KINDS = ('rotary', 'prismatic')


class SignalKind(NamedTuple):
    """Whether a signal is a position, the effort of the motor, on the motor side of the gear."""

    position: bool
    motor_effort: bool
    motor_side: bool


SIGNALS = {
    'motor_position': SignalKind(True, False, True),
    'motor_effort': SignalKind(False, True, True),
    'arm_position': SignalKind(True, False, False),
    'arm_effort': SignalKind(False, False, False),
    'reference_torque': SignalKind(False, False, False),
}
FIRST_STAMP_NS = 1_000_000_000  # stamp 0 means "no stamp" to ROS and to the estimator


@dataclass(frozen=True)
class SignalMapping:
    """One signal of the recording; `column` counts from 1 or is a name of the header row."""

    column: int | str | None = None
    field: str | None = None
    scale: float = 1.0
    counts_per_rev: float | None = None
    torque_constant: float = 1.0
    sign: int = 1
    zero: float | str = 0.0
    bits: int | None = None
    missing: str = 'error'
    unit: str = ''

    def factor(self) -> float:
        """Return the factor from raw units to SI units."""
        rev = 2.0 * math.pi / self.counts_per_rev if self.counts_per_rev else 1.0
        return self.sign * self.scale * rev * self.torque_constant


@dataclass(frozen=True)
class TimeMapping:
    """Place of the time of a sample, or the constant `rate` (Hz) of a recording without time."""

    column: int | str | None = None
    field: str | None = None
    scale: float = 1.0
    rate: float | None = None
    start_stamp_ns: int | str = FIRST_STAMP_NS


@dataclass(frozen=True)
class TextFormat:
    """Format of a text file; `delimiter` 'whitespace' is any run of blanks and tabs."""

    delimiter: str = ','
    comment: str = '#'
    encoding: str = 'utf-8'
    header: bool = False
    decimal: str = '.'


@dataclass(frozen=True)
class JsonFormat:
    """Dotted path of the list of entries; None: `field` is the path of a list of numbers."""

    entries: str | None = None


@dataclass(frozen=True)
class ImportMapping:
    """A checked mapping file; `yaml_text` is its content, `source` its path."""

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


Place: TypeAlias = SignalMapping | TimeMapping
_KEYS = ('format', 'description', 'kind', 'gear_ratio', 'time', 'signals', 'text', 'json')


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


def load_mapping(name: str | Path) -> ImportMapping:
    """Return the ImportMapping `name`: a file or a packaged mapping. Raises InputError."""
    path = find_mapping(name)
    data = load_yaml(path)
    with data.located():
        return mapping_from_dict(data.content, str(path), data.text)


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
    text = yaml.safe_dump(data) if yaml_text is None else yaml_text
    _require_keys(data, 'mapping', source, _KEYS)
    for key in ('format', 'time', 'signals'):
        if key not in data:
            raise InputError(f'{source}: {key}: missing, expected one of '
                             f'{", ".join(FORMATS)}' if key == 'format' else
                             f'{source}: {key}: missing, expected keys and values')
    kind = data['format']
    _choice(kind, 'format', source, FORMATS)
    for name in ('text', 'json'):
        if name in data and name != kind:
            raise InputError(f'{source}: {name}: a block for another format, expected only '
                             f'blocks for format {kind}')
    values: dict[str, Any] = {'format': kind, 'description': str(data.get('description', ''))}
    values['kind'] = _choice(data.get('kind', 'rotary'), 'kind', source, KINDS)
    problems = Problems()
    with problems:
        values['gear_ratio'] = _number(data.get('gear_ratio', 1.0), 'gear_ratio', source,
                                       nonzero=True)
    if 'text' in data:
        with problems:
            values['text'] = _text(data['text'], source)
    if 'json' in data:
        with problems:
            _require_keys(data['json'], 'json', source, ('entries',))
            entries = _string(data['json'].get('entries'), 'json.entries', source)
            values['json'] = JsonFormat(entries[:-2] if entries.endswith('[]') else entries)
    with problems:
        values['time'] = _time(data['time'], source, kind)
    with problems:
        _require_keys(data['signals'], 'signals', source, SIGNALS)
    values['signals'], blocks = {}, data['signals'] if isinstance(data['signals'], dict) else {}
    for name in blocks:
        if name in SIGNALS:
            with problems:
                values['signals'][name] = _signal(name, blocks[name], source, kind,
                                                  values['kind'])
    problems.raise_all()
    if not {'motor_position', 'arm_position'} & set(values['signals']):
        raise InputError(f'{source}: signals: no position, expected motor_position, arm_position '
                         'or both')
    return ImportMapping(source=source, yaml_text=text, **values)


def _text(block: Any, source: str) -> TextFormat:
    _require_keys(block, 'text', source, [f.name for f in fields(TextFormat)])
    text = TextFormat(**block)
    for name in ('delimiter', 'comment', 'encoding', 'decimal'):
        _string(getattr(text, name), f'text.{name}', source)
    if not isinstance(text.header, bool):
        raise InputError(f'{source}: text.header: {text.header!r}, expected true or false')
    if text.delimiter != 'whitespace' and len(text.delimiter) != 1:
        raise InputError(f'{source}: text.delimiter: {text.delimiter!r}, expected one character '
                         "or 'whitespace'")
    _choice(text.decimal, 'text.decimal', source, ('.', ','))
    if text.decimal == text.delimiter:
        raise InputError(f'{source}: text.decimal: {text.decimal!r}, expected another character '
                         'than text.delimiter')
    try:
        'x'.encode(text.encoding)
    except LookupError:
        raise InputError(f'{source}: text.encoding: {text.encoding!r}, expected an encoding such '
                         'as utf-8 or latin-1') from None
    return text


def _time(block: Any, source: str, kind: str) -> TimeMapping:
    _require_keys(block, 'time', source, [f.name for f in fields(TimeMapping)])
    if 'rate' in block:
        for key in ('column', 'field', 'scale'):
            if key in block:
                raise InputError(f'{source}: time.{key}: given beside time.rate, expected one of '
                                 'the two')
        _number(block['rate'], 'time.rate', source, positive=True)
    else:
        _place(block, 'time', source, kind)
    _number(block.get('scale', 1.0), 'time.scale', source, positive=True)
    start = block.get('start_stamp_ns', FIRST_STAMP_NS)
    if start != 'recorded' and (isinstance(start, bool) or not isinstance(start, int)
                                or start <= 0):
        raise InputError(f'{source}: time.start_stamp_ns: {start!r}, expected an integer > 0 (ns) '
                         "or 'recorded'")
    return TimeMapping(**block)


def _signal(name: str, block: Any, source: str, kind: str, axis: str) -> SignalMapping:
    position, motor_effort, _ = SIGNALS[name]
    where = f'signals.{name}'
    allowed = ['column', 'field', 'scale', 'sign', 'zero', 'bits', 'missing', 'unit']
    allowed += ['counts_per_rev'] if position and axis == 'rotary' else []
    allowed += ['torque_constant'] if motor_effort else []
    _require_keys(block, where, source, allowed)
    _place(block, where, source, kind)
    for key in ('scale', 'counts_per_rev', 'torque_constant'):
        if key in block:
            _number(block[key], f'{where}.{key}', source, positive=True)
    if block.get('sign', 1) not in (1, -1):
        raise InputError(f'{source}: {where}.sign: {block["sign"]!r}, expected 1 or -1')
    if block.get('zero') != 'first':
        _number(block.get('zero', 0.0), f'{where}.zero', source, also="or 'first'")
    bits = block.get('bits', 16)
    if isinstance(bits, bool) or not isinstance(bits, int) or not 2 <= bits <= 52:
        raise InputError(f'{source}: {where}.bits: {bits!r}, expected an integer from 2 to 52')
    _choice(block.get('missing', 'error'), f'{where}.missing', source, ('error', 'nan'))
    _string(block.get('unit', '-'), f'{where}.unit', source)
    return SignalMapping(**block)


def _place(block: Mapping[str, Any], where: str, source: str, kind: str) -> None:
    """Check `column` and `field`: text has columns, the other formats fields, mat both."""
    allowed: tuple[str, ...]
    if kind == 'text':
        allowed, needed = ('column',), 'column'
    else:
        allowed, needed = ('field', 'column') if kind == 'mat' else ('field',), 'field'
    if needed not in block:
        raise InputError(f'{source}: {where}.{needed}: missing, expected the '
                         f'{needed} of a {kind} recording')
    for key in ('column', 'field'):
        if key in block and key not in allowed:
            raise InputError(f'{source}: {where}.{key}: a {kind} recording has none, expected '
                             f'{needed}')
    if 'field' in block:
        _string(block['field'], f'{where}.field', source)
    column = block.get('column', 1)
    named = isinstance(column, str) and column and kind == 'text'
    if isinstance(column, bool) or not (named or (isinstance(column, int) and column >= 1)):
        raise InputError(f'{source}: {where}.column: {column!r}, expected a number from 1'
                         + (' or a name of the header row' if kind == 'text' else ''))


def _require_keys(data: Any, name: str, source: str, allowed: Collection[str]) -> None:
    if not isinstance(data, dict):
        raise InputError(f'{source}: {name}: {data!r}, expected keys and values')
    prefix = '' if name == 'mapping' else name + '.'
    strange = [key for key in data if key not in allowed]
    if strange:
        raise InputError(*(f'{source}: {prefix}{key}: unknown key, {unknown(key, allowed)}'
                           for key in strange))


def _choice(value: Any, name: str, source: str, choices: Collection[str]) -> Any:
    if value not in choices:
        raise InputError(f'{source}: {name}: {value!r}, expected one of {", ".join(choices)}')
    return value


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
