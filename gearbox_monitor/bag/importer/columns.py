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
Read the raw columns of a foreign recording: text, MATLAB and JSON files, gzipped or not.

Every reader returns ``(columns, place)``: `columns` maps the name of a signal to a float64 array
[N] in raw units (NaN for an admitted missing value), ``place(row, name)`` names the place of a
value in error messages.
"""
from array import array
from collections.abc import Callable, Iterator, Mapping
import csv
import gzip
import io
from itertools import chain
import json
import math
from pathlib import Path
from typing import Any, cast, IO, TypeAlias
import zlib

import numpy as np
import scipy.io

from gearbox_monitor.bag.importer.mapping import ImportMapping, Place, TextFormat
from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import Array

MAX_INT = 1 << 1000  # larger ones are no float
Places: TypeAlias = Mapping[str, Place]  # by name of the signal, and 'time'
Columns: TypeAlias = tuple[dict[str, Array], Callable[[int, str], str]]
Rows: TypeAlias = Iterator[tuple[int, str]]  # line number, line


def read_columns(path: str | Path, mapping: ImportMapping) -> Columns:
    """
    Return ``(columns, place)`` of the file `path` for the signals and the time of `mapping`.

    Raises InputError that names file, line or entry, value and expected value.
    """
    places: Places = mapping.signals
    if mapping.time.rate is None:
        places = {'time': mapping.time, **mapping.signals}
    reader = {'text': _read_text, 'mat': _read_mat, 'json': _read_json}[mapping.format]
    try:
        return reader(path, mapping, places)
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise InputError(f'{path}: {error}, expected a whole gzip file') from None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected a readable file') from None
    except UnicodeDecodeError as error:
        raise InputError(f'{path}: byte {error.object[error.start]:#04x} is not '
                         f'{error.encoding}, expected text in the encoding of the mapping '
                         f'({mapping.text.encoding})') from None


def _open(path: str | Path) -> IO[bytes]:
    """Open `path` for reading bytes, unpacked if its first bytes are those of gzip."""
    stream = Path(path).open('rb')
    packed = stream.read(2) == b'\x1f\x8b'
    stream.seek(0)
    return cast(IO[bytes], gzip.open(stream)) if packed else stream


def _label(name: str) -> str:
    return name.replace('_', ' ')


# --- text ---------------------------------------------------------------------------------------
def _rows(path: str | Path, text: TextFormat) -> Rows:
    """Yield ``(line number, line)`` of lines that are neither empty nor a comment."""
    with io.TextIOWrapper(_open(path), encoding=text.encoding, newline=None) as stream:
        for number, line in enumerate(stream, 1):
            if number == 1:
                line = line.removeprefix('\ufeff')
            if line.strip() and not line.lstrip().startswith(text.comment):
                yield number, line


def _split(line: str, text: TextFormat) -> list[str]:
    if text.delimiter == 'whitespace':
        return line.split()
    return next(csv.reader([line.rstrip('\n')], delimiter=text.delimiter))


def _column_numbers(path: str | Path, mapping: ImportMapping, places: Places, rows: Rows
                    ) -> dict[str, int]:
    """Return {name: column from 0}; takes the header row, if any, from `rows`."""
    header = None
    if mapping.text.header:
        number, line = next(rows, (0, ''))
        header = [name.strip() for name in _split(line, mapping.text)] if number else []
    numbers = {}
    for name, signal in places.items():
        column = signal.column
        if isinstance(column, str):
            if header is None:
                raise InputError(f'{mapping.source}: {_key(name)}.column: {column!r}, expected a '
                                 'number, or text.header: true for a name')
            if header.count(column) != 1:
                names = ', '.join(header) or 'none'
                raise InputError(f'{path}: header row: column {column!r} of {_key(name)} stands '
                                 f'{header.count(column)} times, expected once in: {names}')
            column = header.index(column) + 1
        assert column is not None  # the mapping was checked
        numbers[name] = column - 1
    return numbers


def _key(name: str) -> str:
    return name if name == 'time' else f'signals.{name}'


def _read_text(path: str | Path, mapping: ImportMapping, places: Places) -> Columns:
    text = mapping.text
    rows = _rows(path, text)
    numbers = _column_numbers(path, mapping, places, rows)
    if not numbers:
        raise InputError(f'{mapping.source}: signals: none, expected at least one')
    lines = array('q')

    def data() -> Iterator[str]:
        for number, line in rows:
            lines.append(number)
            yield line.replace(',', '.') if text.decimal == ',' else line

    def place(row: int, name: str) -> str:
        return f'line {lines[row]}, column {numbers[name] + 1} ({_label(name)})'

    columns = sorted(set(numbers.values()))
    delimiter = None if text.delimiter == 'whitespace' else text.delimiter
    try:
        first = next(rows, None)
        if first is None:
            raise InputError(f'{path}: no rows of data, expected at least two')
        rows = chain([first], rows)
        values: Array = np.loadtxt(data(), delimiter=delimiter, usecols=columns, comments=None,
                                   quotechar=None if delimiter is None else '"', ndmin=2)
    except UnicodeDecodeError:
        raise
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        lines = array('q')
        values = _read_carefully(path, mapping, places, numbers, lines)
    result: dict[str, Array] = {}
    for name, column in numbers.items():
        result[name] = values[:, columns.index(column)].copy()
    return result, place


def _read_carefully(path: str | Path, mapping: ImportMapping, places: Places,
                    numbers: Mapping[str, int], lines: 'array[int]') -> Array:
    """Read row by row, to name the first bad value or to admit missing ones; fill `lines`."""
    text, columns = mapping.text, sorted(set(numbers.values()))
    rows = _rows(path, text)
    _column_numbers(path, mapping, places, rows)
    values = array('d')
    names: dict[int, str] = {}
    for name, column in numbers.items():
        names.setdefault(column, name)
    may_miss = {numbers[name] for name, signal in places.items() if _may_miss(signal)}
    for number, line in rows:
        lines.append(number)
        cells = _split(line, text)
        if len(cells) <= columns[-1]:
            raise InputError(f'{path}: line {number}: {len(cells)} columns, expected at least '
                             f'{columns[-1] + 1}')
        for column in columns:
            cell = cells[column].strip()
            try:
                number_text = cell.replace(',', '.') if text.decimal == ',' else cell
                values.append(math.nan if not cell and column in may_miss else
                              float(number_text))
            except ValueError:
                raise InputError(f'{path}: line {number}, column {column + 1} '
                                 f'({_label(names[column])}) value {cell!r}: expected a number'
                                 ) from None
    return np.array(values).reshape(-1, len(columns))


# --- MATLAB -------------------------------------------------------------------------------------
def _read_mat(path: str | Path, mapping: ImportMapping, places: Places) -> Columns:
    with _open(path) as stream:
        content = io.BytesIO(stream.read())
    try:
        tree = scipy.io.loadmat(content, simplify_cells=True)
    except NotImplementedError:
        raise InputError(f'{path}: MATLAB version 7.3, expected version 7.2 or older (save -v7)'
                         ) from None
    except Exception as error:  # scipy raises many kinds for a foreign or a cut file
        raise InputError(f'{path}: {type(error).__name__} {error}, expected a MATLAB file'
                         .replace('\n', ' ')) from None
    tree = {k: v for k, v in tree.items() if not k.startswith('__')}
    return _arrays(path, tree, places)


def _arrays(path: str | Path, tree: Any, places: Places) -> Columns:
    """Return the arrays of numbers at the dotted paths of `places` in nested mappings."""
    columns: dict[str, Array] = {}
    for name, signal in places.items():
        value: Any = tree
        for part in _path(signal):
            if not isinstance(value, dict) or part not in value:
                raise InputError(f'{path}: field {signal.field} ({_label(name)}): missing, '
                                 f'expected one of {_names(value)}')
            value = value[part]
        try:
            if isinstance(value, list):
                value = [math.nan if v is None else v for v in value]
            value = np.asarray(value)
            if value.dtype.kind not in 'iuf':
                raise TypeError
        except (TypeError, ValueError):
            raise InputError(f'{path}: field {signal.field} ({_label(name)}): not numeric, '
                             'expected an array of numbers') from None
        if signal.column is not None:
            if value.ndim != 2 or int(signal.column) > value.shape[1]:
                raise InputError(f'{path}: field {signal.field} ({_label(name)}): shape '
                                 f'{value.shape}, expected a matrix with column {signal.column}')
            value = value[:, int(signal.column) - 1]
        value = np.atleast_1d(np.squeeze(value)).astype(float)
        if value.ndim != 1:
            raise InputError(f'{path}: field {signal.field} ({_label(name)}): shape '
                             f'{value.shape}, expected one number per sample')
        columns[name] = value
        length = len(next(iter(columns.values())))
        if len(value) != length:
            raise InputError(f'{path}: field {signal.field} ({_label(name)}): {len(value)} '
                             f'values, expected {length} like {next(iter(columns))}')

    def place(row: int, name: str) -> str:
        return f'{places[name].field}[{row}] ({_label(name)})'
    return columns, place


def _path(signal: Place) -> list[str]:
    """Return the parts of the dotted path of `signal`."""
    assert signal.field is not None  # the mapping was checked
    return signal.field.split('.')


def _may_miss(signal: Place) -> bool:
    """Return whether values of `signal` may be missing."""
    return getattr(signal, 'missing', 'error') == 'nan'


def _names(value: object) -> str:
    return ', '.join(sorted(map(str, value))) if isinstance(value, dict) and value else 'no fields'


# --- JSON ---------------------------------------------------------------------------------------
def _read_json(path: str | Path, mapping: ImportMapping, places: Places) -> Columns:
    with _open(path) as stream:
        content = stream.read()
    try:
        tree = json.loads(content)
    except json.JSONDecodeError as error:
        raise InputError(f'{path}: line {error.lineno} column {error.colno}: {error.msg}, '
                         'expected JSON') from None
    except (ValueError, RecursionError) as error:  # an endless number, nested too deeply
        raise InputError(f'{path}: {error}, expected JSON') from None
    where = mapping.json.entries
    if where is None and isinstance(tree, dict):
        return _arrays(path, tree, places)
    entries = tree
    for part in where.split('.') if where else ():
        if not isinstance(entries, dict) or part not in entries:
            raise InputError(f'{path}: {where}: missing, expected a list of entries, found '
                             f'{_names(entries)}')
        entries = entries[part]
    if not isinstance(entries, list):
        raise InputError(f'{path}: {where}: {type(entries).__name__}, expected a list of entries')

    def place(row: int, name: str) -> str:
        return f'{where or ""}[{row}].{places[name].field} ({_label(name)})'
    columns: dict[str, Array] = {}
    for name, signal in places.items():
        parts, may_miss = _path(signal), _may_miss(signal)
        values = np.empty(len(entries))
        for row, entry in enumerate(entries):
            value = entry
            for part in parts:
                value = value.get(part) if isinstance(value, dict) else None
            if isinstance(value, bool) or not isinstance(value, (int, float)) or \
                    isinstance(value, int) and abs(value) > MAX_INT:
                if value is not None or not may_miss:
                    text = 'missing' if value is None else f'value {value!r}'
                    raise InputError(f'{path}: {place(row, name)} {text}: expected a number')
                value = math.nan
            values[row] = value
        columns[name] = values
    return columns, place
