# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Raw columns of a foreign recording: text, MATLAB, JSON, HDF5, NumPy, Parquet and Feather files.

All may be gzipped. A matrix with one row per signal is recognised by its shape.
"""
from collections.abc import Mapping
from dataclasses import replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.kernels.types import AnyArray
from gearbox_monitor.recordings.importer.containers import opened_table, opened_tree, readable
from gearbox_monitor.recordings.importer.mapping import ImportMapping, Place, TimeMapping
from gearbox_monitor.recordings.importer.raw_columns import (
    key_of, label_of, MIN_SAMPLES, names_of, Places, RawColumns)
from gearbox_monitor.recordings.importer.text_file import read_text
from gearbox_monitor.recordings.importer.unit_table import standard_unit

MAX_INT = 1 << 63  # larger ones are no int64
MAX_FLOAT = 1 << 1000  # larger ones are no float


def read_columns(path: str | Path, mapping: ImportMapping) -> RawColumns:
    """
    Return the RawColumns of the file `path` for the signals and times of `mapping`.

    Raises InputError that names file, line or entry, value and expected value.
    """
    places: dict[str, Place] = _of_time('time', mapping.time)
    for name, signal in mapping.signals.items():
        places[name] = signal
        if signal.time is not None:
            places.update(_of_time(f'{name}.time', signal.time))
    if not mapping.signals:
        raise InputError(f'{mapping.source}: signals: none, expected at least one')
    if mapping.format == 'text':
        with readable(path, mapping.text.encoding):
            return read_text(path, mapping, places)
    if mapping.format in ('parquet', 'feather'):
        return _read_table(path, mapping, places)
    with opened_tree(path, mapping.format) as tree:
        if mapping.format == 'json':
            entries = _entries(path, tree, mapping.json.entries)
            if entries is not None:
                return _read_entries(path, entries, mapping.json.entries or '', places)
        return _read_tree(path, tree, places)


def _of_time(key: str, time: TimeMapping) -> dict[str, Place]:
    """Return the places of a time, called `key`, of its nanoseconds and of its segments."""
    places: dict[str, Place] = {} if time.rate is not None else {key: time}
    for part in ('nanosec', 'segment'):
        column = getattr(time, part)
        if column is not None:
            is_field = time.field is not None
            places[f'{key}.{part}'] = replace(
                time, column=None if is_field else column, field=column if is_field else None,
                unit='ns' if part == 'nanosec' else 'text' if isinstance(time.only, str)
                else 's', scale=1.0, rate=None)
    return places


# --- Parquet and Feather ------------------------------------------------------------------------
def _read_table(path: str | Path, mapping: ImportMapping, places: Places) -> RawColumns:
    table = opened_table(path, mapping.format)
    values: dict[str, AnyArray] = {}
    for name, signal in places.items():
        column, element = signal.column, None
        if isinstance(column, str) and column not in table.column_names:
            stem, _, digits = column.rpartition('.')
            if stem in table.column_names and digits.isdigit() and int(digits):
                column, element = stem, int(digits)
        is_column = table.column_names.count(column) == 1 if isinstance(column, str) else \
            column is not None and column <= len(table.column_names)
        if not is_column:
            raise InputError(f'{path}: column {signal.column!r} ({label_of(name)}): missing, '
                             f'expected one of {", ".join(table.column_names)}')
        data = table[column if isinstance(column, str) else int(column or 1) - 1]
        values[name] = _table_column(path, data, element, f'column {signal.column} '
                                     f'({label_of(name)})', isinstance(signal, TimeMapping))

    def place(row: int, name: str) -> str:
        return f'row {row + 1}, column {places[name].column} ({label_of(name)})'
    return RawColumns(values, place)


def _table_column(path: str | Path, data: Any, element: int | None, where: str, is_time: bool
                  ) -> AnyArray:
    """Return a pyarrow column as an array: whole numbers and stamps exactly, nulls as NaN."""
    import pyarrow as pa
    from pyarrow import compute
    try:
        if element is not None:
            data = compute.list_element(data, element - 1)
        if pa.types.is_timestamp(data.type) or pa.types.is_duration(data.type):
            unit = data.type.unit
            numbers = data.cast(pa.int64())
            if not is_time or numbers.null_count:
                raise InputError(f'{path}: {where}: stamps, expected '
                                 + ('none missing' if is_time else 'numbers'))
            return numbers.to_numpy().astype(f'M8[{unit}]')
        if is_time and (pa.types.is_string(data.type) or pa.types.is_large_string(data.type)):
            return np.array([text or '' for text in data.to_pylist()])
        if pa.types.is_integer(data.type) and not data.null_count:
            return data.cast(pa.int64()).to_numpy()
        return data.cast(pa.float64()).to_numpy()
    except pa.ArrowException as error:
        raise InputError(f'{path}: {where}: {data.type}, expected numbers ({error})') from None


# --- fields: MATLAB, HDF5, NumPy, JSON of arrays ------------------------------------------------
def _read_tree(path: str | Path, tree: Any, places: Places) -> RawColumns:
    """Return the arrays of numbers at the dotted paths of `places`."""
    values: dict[str, AnyArray] = {}
    notices: list[str] = []
    labels: dict[str, str] = {}
    for name, signal in places.items():
        where = f'field {signal.field or "(root)"} ({label_of(name)})'
        value = _field(path, tree, signal, where)
        stated = getattr(value, 'attrs', {}).get('units', getattr(value, 'attrs', {}).get('unit'))
        labels[name] = standard_unit(stated.decode() if isinstance(stated, bytes) else
                                     str(stated)) if stated is not None else ''
        is_time = isinstance(signal, TimeMapping)
        array = _numbers(path, value, where, is_time)
        if signal.column is not None:
            array, transposed = _oriented(path, array, where)
            if int(signal.column) > array.shape[1]:
                raise InputError(f'{path}: {where}: shape {array.shape}, expected a matrix with '
                                 f'column {signal.column}')
            if transposed and transposed not in notices:
                notices.append(transposed)
            array = array[:, int(signal.column) - 1]
        array = np.atleast_1d(np.squeeze(array))
        if array.ndim != 1:
            raise InputError(f'{path}: {where}: shape {array.shape}, expected one number per '
                             'sample, or the column of a matrix (column: 1, ...)')
        values[name] = array
    lengths = {name: len(values[name]) for name in values
               if not name.endswith(('.time', '.nanosec', '.segment'))
               and f'{name}.time' not in places and getattr(places[name], 'time', None) is None}
    for name, length in lengths.items():
        first = next(iter(lengths))
        if length != lengths[first]:
            raise InputError(f'{path}: field {places[name].field} ({label_of(name)}): {length} '
                             f'values, expected {lengths[first]} like {first} (or a time of its '
                             f'own: {key_of(name)}.time)')

    def place(row: int, name: str) -> str:
        signal = places[name]
        column = f', {signal.column}' if signal.column is not None else ''
        return f'{signal.field or ""}[{row}{column}] ({label_of(name)})'
    return RawColumns(values, place, tuple(notices), labels)


def _field(path: str | Path, tree: Any, signal: Place, where: str) -> Any:
    """Return what stands at the dotted path of `signal`; numbers count entries from 1."""
    value = tree
    parts = _parts(signal)
    for k, part in enumerate(parts):
        suffix = '.'.join(parts[k:])
        if isinstance(value, Mapping) and suffix in value:  # a name with dots
            return value[suffix]
        value = _step(path, value, part, where)
    return value


def _step(path: str | Path, value: Any, part: str, where: str) -> Any:
    if isinstance(value, Mapping):
        if part in value:
            return value[part]
    elif _names_of_record(value):
        if part in _names_of_record(value):
            return value[part]
    elif isinstance(value, (list, np.ndarray)) and getattr(value, 'ndim', 1) == 1 and \
            len(value) and isinstance(value[0], Mapping):  # an array of structs
        if part.isdigit() and 1 <= int(part) <= len(value):
            return value[int(part) - 1]
        return [_step(path, entry, part, where) for entry in value]
    elif isinstance(value, list) and part.isdigit() and 1 <= int(part) <= len(value):
        return value[int(part) - 1]
    raise InputError(f'{path}: {where}: missing, expected one of {names_of(value)}')


def _names_of_record(value: Any) -> tuple[str, ...]:
    """Return the names of the fields of a table of records (a compound type), () for others."""
    return getattr(getattr(value, 'dtype', None), 'names', None) or ()


def _numbers(path: str | Path, value: Any, where: str, is_time: bool) -> AnyArray:
    """Return an array of numbers; of a time also texts."""
    try:
        if isinstance(value, list):
            value = [math.nan if v is None else v for v in value]
        matlab = 'MATLAB_class' in getattr(value, 'attrs', ())  # stores columns as rows
        array = np.asarray(value[()] if hasattr(value, 'attrs') else value)
        array = array.T if matlab else array
        if is_time and array.dtype.kind in 'OSU' and array.size and isinstance(
                array.flat[0], (bytes, str)):
            return np.array([text.decode() if isinstance(text, bytes) else str(text)
                             for text in array.ravel()])
        if array.dtype.kind == 'M' and is_time:
            return array
        if array.dtype.kind == 'u':
            array = array.astype(np.int64 if array.dtype.itemsize < 8 else float)
        if array.dtype.kind not in 'if':
            raise TypeError
    except (TypeError, ValueError):
        raise InputError(f'{path}: {where}: not numeric, expected an array of numbers') from None
    return array


def _oriented(path: str | Path, array: AnyArray, where: str) -> tuple[AnyArray, str]:
    """Return a matrix with one row per sample, and a notice if it had one row per signal."""
    if array.ndim > 2:
        array = np.squeeze(array)
    if array.ndim != 2:
        raise InputError(f'{path}: {where}: shape {array.shape}, expected a matrix')
    rows, columns = array.shape
    if rows < MIN_SAMPLES <= columns:
        return array.T, (f'{where.partition(" (")[0]}: one row per signal ({rows} rows of '
                         f'{columns} samples): column numbers count its rows')
    return array, ''


def _parts(signal: Place) -> list[str]:
    """Return the parts of the dotted path of `signal`."""
    return signal.field.strip('/').replace('/', '.').split('.') if signal.field else []


# --- JSON entries -------------------------------------------------------------------------------
def _entries(path: str | Path, tree: Any, where: str | None) -> list[Any] | None:
    """Return the list of entries of a JSON recording; None: it is one of arrays by name."""
    if where is None and isinstance(tree, dict):
        return None
    entries = tree
    for part in where.split('.') if where else ():
        if not isinstance(entries, dict) or part not in entries:
            raise InputError(f'{path}: {where}: missing, expected a list of entries, found '
                             f'{names_of(entries)}')
        entries = entries[part]
    if not isinstance(entries, list):
        raise InputError(f'{path}: {where}: {type(entries).__name__}, expected a list of entries')
    return entries


def _read_entries(path: str | Path, entries: list[Any], where: str, places: Places) -> RawColumns:
    """Return the values of `places` in a list of entries, each a mapping or a row of numbers."""
    notices: tuple[str, ...] = ()
    lists = bool(entries) and all(isinstance(entry, list) for entry in entries)
    if lists and len(entries) < MIN_SAMPLES and len(entries[0]) >= MIN_SAMPLES and all(
            len(entry) == len(entries[0]) for entry in entries):
        notices = (f'{where or "the list"}: one row per signal ({len(entries)} rows of '
                   f'{len(entries[0])} samples): column numbers count its rows',)
        entries = [list(row) for row in zip(*entries)]

    def place(row: int, name: str) -> str:
        signal = places[name]
        field = f'.{signal.field}' if signal.field else ''
        column = f'[{int(signal.column) - 1}]' if signal.column is not None else ''
        return f'{where}[{row}]{field}{column} ({label_of(name)})'
    values: dict[str, AnyArray] = {}
    for name, signal in places.items():
        parts, column = _parts(signal), signal.column
        may_miss = getattr(signal, 'missing', 'error') == 'nan'
        is_time, numbers = isinstance(signal, TimeMapping), []
        for row, entry in enumerate(entries):
            value = entry
            for part in parts:
                value = value.get(part) if isinstance(value, dict) else None
            if column is not None:
                value = value[int(column) - 1] if isinstance(value, list) and \
                    int(column) <= len(value) else None
            if not (is_time and isinstance(value, str)) and (
                    isinstance(value, bool) or not isinstance(value, (int, float)) or
                    isinstance(value, int) and abs(value) > MAX_FLOAT):
                if value is not None or not may_miss:
                    text = 'missing' if value is None else f'value {value!r}'
                    raise InputError(f'{path}: {place(row, name)} {text}: expected a number')
                value = math.nan
            numbers.append(value)
        texts = any(isinstance(value, str) for value in numbers)
        whole = all(isinstance(value, int) and abs(value) < MAX_INT for value in numbers)
        values[name] = np.array([str(v) for v in numbers]) if texts else np.array(
            numbers, np.int64 if whole else float)
    return RawColumns(values, place, notices)
