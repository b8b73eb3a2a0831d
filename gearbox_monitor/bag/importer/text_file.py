# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Text recordings: header rows, comments, a row per sample or per signal, columns of unequal length.

Numbers are read by numpy.loadtxt; row by row only to name the first bad value, to admit missing
ones, and for times that a double does not hold.
"""
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
import csv
from dataclasses import dataclass, replace
from itertools import chain, islice, zip_longest
import math
from pathlib import Path
import re
from typing import TypeAlias

import numpy as np

from gearbox_monitor.bag.importer.mapping import ImportMapping, TextFormat, TimeMapping
from gearbox_monitor.bag.importer.raw_columns import (
    key_of, label_of, MIN_SAMPLES, Places, RawColumns)
from gearbox_monitor.bag.importer.unit_table import (
    number_with_unit, standard_unit, TIME, unit_of_label)
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.packed_files import lines_of
from gearbox_monitor.kernels.types import AnyArray, Array

MISSING = ('', 'na', 'n/a', 'null', 'none', '-')  # besides nan
AS_TEXT = ('iso8601', 'text')  # units of dates and words
EXACT = 2.0 ** 53  # ns from which on a double rounds
Lines: TypeAlias = Iterator[tuple[int, str]]  # line number, line


@dataclass(frozen=True)
class TextTable:
    """
    Cells of a text file.

    names: of each column, the cells of its header rows. rows: (line or column number, cells).
    numbers: of the lines of the signals, where each signal is a row. comment: the last one before
    the data.
    """

    names: tuple[tuple[str, ...], ...]
    rows: Iterator[tuple[int, list[str]]]
    numbers: tuple[int, ...] = ()


def text_lines(path: str | Path, text: TextFormat, comments: list[str] | None = None) -> Lines:
    """
    Yield ``(line number, line)`` of lines that are neither skipped, empty nor a comment.

    Args:
        path: of the file, gzipped or not.
        text: its format.
        comments: takes the comments and the skipped lines.
    """
    for number, line in enumerate(lines_of(path, text.encoding), 1):
        if number == 1:
            line = line.removeprefix('\ufeff')
        if number <= text.skip or line.lstrip().startswith(text.comment):
            if comments is not None:
                comments.append(line)
        elif line.strip():
            yield number, line


def split_line(line: str, text: TextFormat) -> list[str]:
    """Return the cells of `line` in the format `text`."""
    if text.delimiter == 'whitespace':
        return line.split()
    return next(csv.reader([line.rstrip('\n')], delimiter=text.delimiter,
                           skipinitialspace=True))


def is_number(cell: str, text: TextFormat) -> bool:
    """Return whether `cell` holds a number in the format `text`."""
    try:
        float(cell.replace(',', '.') if text.decimal == ',' else cell)
    except ValueError:
        return False
    return True


def row_per_signal(path: str | Path, text: TextFormat) -> bool:
    """Return whether each row of the file `path` is a signal, by `text` or by its shape."""
    if text.rows != 'auto':
        return text.rows == 'signals'
    rows = list(islice(text_lines(path, text), MIN_SAMPLES))
    if not 0 < len(rows) < MIN_SAMPLES:
        return False
    # All rows, so that a long line of a foreign file is not taken for samples.
    return all(len(split_line(line, text)) >= MIN_SAMPLES for _, line in rows)


def signal_rows(path: str | Path, text: TextFormat) -> TextTable:
    """Return the TextTable of `path` in format `text`: a row per signal, its names first."""
    lines = list(text_lines(path, text))
    cells = [split_line(line, text) for _, line in lines]
    columns = list(zip_longest(*cells, fillvalue=''))
    header = int(text.header) if isinstance(text.header, int) else 0
    if not header and columns and not any(is_number(cell, text) for cell in columns[0]):
        header = 1
    names = tuple(tuple(cell.strip() for cell in row[:header]) for row in cells)
    return TextTable(names, ((k + 1, list(column)) for k, column in
                             enumerate(columns) if k >= header),
                     tuple(number for number, _ in lines))


def sample_rows(path: str | Path, text: TextFormat) -> tuple[tuple[tuple[str, ...], ...], Lines]:
    """Return (names, lines of data) of `path`, a row per sample, in the format `text`."""
    comments: list[str] = []
    lines = text_lines(path, text, comments)
    if text.header == 'comment':
        first = next(lines, None)
        names = comments[-1].lstrip().lstrip(text.comment) if comments else ''
        return (tuple((cell.strip(),) for cell in split_line(names, text)),
                lines if first is None else chain([first], lines))
    rows = [split_line(line, text) for _, line in islice(lines, int(text.header))]
    return tuple(tuple(cell.strip() for cell in column)
                 for column in zip_longest(*rows, fillvalue='')), lines


def column_numbers(path: str | Path, mapping: ImportMapping, places: Places,
                   names: Sequence[Sequence[str]]) -> dict[str, int]:
    """
    Return {name of the signal: column from 0}.

    Args:
        path: of the recording, for messages.
        mapping: of the recording, for messages.
        places: of signals and times.
        names: of each column, the cells of its header rows; one of them, or all of them joined by
            a blank, is its name.

    Raises:
        InputError: a column is missing, or stands twice.
    """
    numbers = {}
    for name, signal in places.items():
        column = signal.column
        if isinstance(column, str):
            if not names and not mapping.text.header:
                raise InputError(f'{mapping.source}: {key_of(name)}.column: {column!r}, expected '
                                 'a number, or text.header: true for a name')
            matches = [k for k, cells in enumerate(names)
                       if column in cells or column == ' '.join(filter(None, cells))]
            if len(matches) != 1:
                listed = ', '.join(' '.join(filter(None, cells)) for cells in names) or 'none'
                raise InputError(f'{path}: header row: column {column!r} of {key_of(name)} stands '
                                 f'{len(matches)} times, expected once in: {listed}')
            column = matches[0] + 1
        assert column is not None  # the mapping was checked
        numbers[name] = column - 1
    return numbers


def list_columns(names: Sequence[Sequence[str]], places: Places) -> dict[str, tuple[str, int]]:
    """
    Return {name of the signal: (column, place in its list from 1)} of 'COLUMN.NUMBER'.

    names: cells above each column of the file. places: of signals, as stated.
    """
    cells = {cell for column in names for cell in (*column, ' '.join(filter(None, column)))}
    result = {}
    for name, place in places.items():
        if isinstance(place.column, str) and place.column not in cells:
            stem, _, digits = place.column.rpartition('.')
            if stem in cells and digits.isdigit() and int(digits):
                result[name] = stem, int(digits)
    return result


def numbers_of_list(cell: str) -> list[float] | None:
    """Return the numbers of a cell such as '[1.0, 2.0]', None if it is none."""
    brackets = re.fullmatch(r'\s*[\[(](.*)[\])]\s*', cell, re.DOTALL)
    if brackets is None:
        return None
    try:
        return [float(part) for part in brackets[1].replace(',', ' ').split()]
    except ValueError:
        return None


def _read_lists(path: str | Path, mapping: ImportMapping, places: Places,
                lists: Mapping[str, tuple[str, int]]) -> RawColumns:
    """Return the RawColumns of a text file with lists of numbers in cells."""
    names, rows = sample_rows(path, mapping.text)
    plain = {name: replace(place, column=lists[name][0]) if name in lists else place
             for name, place in places.items()}
    numbers = column_numbers(path, mapping, plain, names)
    table = [(line, split_line(text, mapping.text)) for line, text in rows]

    def _place(row: int, name: str) -> str:
        return f'line {table[row][0]}, column {numbers[name] + 1} ({label_of(name)})'
    cell_value = _parser(path, mapping, places)
    parsed: dict[int, list[list[float]]] = {}
    values: dict[str, AnyArray] = {}
    for name, column in numbers.items():
        cells = [row[column].strip() if column < len(row) else '' for _, row in table]
        if name not in lists:
            place = places[name]
            values[name] = np.array(cells) if isinstance(place, TimeMapping) and (
                place.unit in AS_TEXT) else np.array(
                [cell_value(cell, name, _place(k, name)) for k, cell in enumerate(cells)])
            continue
        if column not in parsed:
            parsed[column] = [numbers_of_list(cell) or [] for cell in cells]
        element = lists[name][1]
        for k, row in enumerate(parsed[column]):
            if len(row) < element:
                raise InputError(f'{path}: {_place(k, name)} value {cells[k][:40]!r}: expected a '
                                 f'list of at least {element} numbers')
        values[name] = np.array([row[element - 1] for row in parsed[column]])
    return RawColumns(values, _place, (), _units(numbers, names))


def read_text(path: str | Path, mapping: ImportMapping, places: Places) -> RawColumns:
    """
    Return the RawColumns of a text file.

    Args:
        path: of the file, gzipped or not.
        mapping: its format and its name for messages.
        places: of signals and times.

    Raises:
        InputError: it names line, column, value and what was expected.
    """
    text = mapping.text
    if row_per_signal(path, text):
        return _read_signal_rows(path, mapping, places)
    names, rows = sample_rows(path, text)
    lists = list_columns(names, places)
    if lists:
        return _read_lists(path, mapping, places, lists)
    numbers = column_numbers(path, mapping, places, names)
    lines = array('q')

    def _data() -> Iterator[str]:
        for number, line in rows:
            lines.append(number)
            yield line.replace(',', '.') if text.decimal == ',' else line

    def _place(row: int, name: str) -> str:
        return f'line {lines[row]}, column {numbers[name] + 1} ({label_of(name)})'

    texts = {name for name, place in places.items()
             if isinstance(place, TimeMapping) and place.unit in AS_TEXT}
    columns = sorted({numbers[name] for name in places if name not in texts})
    delimiter = None if text.delimiter == 'whitespace' else text.delimiter
    first = next(rows, None)
    if first is None:
        raise InputError(f'{path}: no rows of data, expected at least {MIN_SAMPLES}')
    rows = chain([first], rows)
    try:
        if not columns:
            raise ValueError  # times only
        values: Array = np.loadtxt(_data(), delimiter=delimiter, usecols=columns, comments=None,
                                   quotechar=None if delimiter is None else '"', ndmin=2)
    except UnicodeDecodeError:
        raise
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        lines = array('q')
        values = _carefully(path, mapping, places, (numbers, columns), lines)
    result: dict[str, AnyArray] = {}
    for name, column in numbers.items():
        place = places[name]
        if name in texts or isinstance(place, TimeMapping) and _rounded(
                values[:, columns.index(column)], place):
            result[name] = np.array([
                cells[column].strip() if column < len(cells) else '' for _, cells in
                ((n, split_line(line, text)) for n, line in sample_rows(path, text)[1])])
        else:
            result[name] = values[:, columns.index(column)].copy()
    return RawColumns(result, _place, (), _units(numbers, names))


def _rounded(raw: Array, time: TimeMapping) -> bool:
    """Return whether doubles round the times `raw`, as they do with ns since 1970."""
    return bool(time.scale == 1.0 and np.isfinite(raw).all() and len(raw)
                and np.abs(raw).max() * TIME[time.unit] > EXACT)


def _units(numbers: Mapping[str, int], names: Sequence[Sequence[str]]) -> dict[str, str]:
    """Return {signal: unit that its header cells state}, '' for none."""
    units = {}
    for name, column in numbers.items():
        cells = names[column] if column < len(names) else ()
        stated = [unit_of_label(cell) or (unit_of_label(f'[{cell}]') if k else '')
                  for k, cell in enumerate(cells)]
        units[name] = next(filter(None, stated), '')
    return units


def _read_signal_rows(path: str | Path, mapping: ImportMapping, places: Places) -> RawColumns:
    """Return the RawColumns of a file with a row per signal."""
    table = signal_rows(path, mapping.text)
    numbers = column_numbers(path, mapping, places, table.names)
    rows = list(table.rows)

    def _place(row: int, name: str) -> str:
        return f'line {table.numbers[numbers[name]]}, column {rows[row][0]} ({label_of(name)})'
    values: dict[str, AnyArray] = {}
    cell_value = _parser(path, mapping, places)
    for name, column in numbers.items():
        if column >= len(table.numbers):
            raise InputError(f'{path}: {len(table.numbers)} rows, one per signal, expected row '
                             f'{column + 1} ({label_of(name)})')
        place = places[name]
        cells = [row[column].strip() for _, row in rows]
        values[name] = np.array(cells) if isinstance(place, TimeMapping) and (
            place.unit in AS_TEXT) else np.array(
            [cell_value(cell, name, _place(k, name)) for k, cell in enumerate(cells)])
    notice = (f'one row per signal ({len(table.numbers)} rows of {len(rows)} samples): column '
              'numbers count the rows')
    return RawColumns(values, _place, (notice,), _units(numbers, table.names))


def _parser(path: str | Path, mapping: ImportMapping, places: Places
            ) -> Callable[[str, str, str], float]:
    """Return the function that makes a number of a cell, of a signal's name and of its place."""
    # Where signals have times of their own, the shorter columns end in empty cells.
    unequal = any(getattr(place, 'time', None) is not None for place in places.values())
    may_miss = {name for name, place in places.items()
                if unequal or getattr(place, 'missing', 'error') == 'nan'}

    def _value(cell: str, name: str, place: str) -> float:
        try:
            if name in may_miss and cell.lower() in MISSING:
                return math.nan
            return float(cell.replace(',', '.') if mapping.text.decimal == ',' else cell)
        except ValueError:
            number = number_with_unit(cell)
            if number is not None and number[1] == standard_unit(
                    str(getattr(places[name], 'unit', ''))):
                return number[0]
            raise InputError(f'{path}: {place} value {cell!r}: expected a number') from None
    return _value


def _carefully(path: str | Path, mapping: ImportMapping, places: Places,
               numbered: tuple[Mapping[str, int], Sequence[int]], lines: 'array[int]') -> Array:
    """Return columns [N, C] read row by row; `numbered`: of signals, of columns; fill `lines`."""
    numbers, columns = numbered
    values = array('d')
    names: dict[int, str] = {}
    cell_value = _parser(path, mapping, places)
    for name, column in numbers.items():
        # Of two signals in one column, that which may miss decides.
        if column not in names or getattr(places[name], 'missing', 'error') == 'nan':
            names[column] = name
    unequal = any(getattr(place, 'time', None) is not None for place in places.values())
    for number, line in sample_rows(path, mapping.text)[1]:
        lines.append(number)
        cells = split_line(line, mapping.text)
        if len(cells) <= max(numbers.values()):
            if not unequal:
                raise InputError(f'{path}: line {number}: {len(cells)} columns, expected at least '
                                 f'{max(numbers.values()) + 1}')
            cells += [''] * (max(numbers.values()) + 1 - len(cells))
        for column in columns:
            place = f'line {number}, column {column + 1} ({label_of(names[column])})'
            values.append(cell_value(cells[column].strip(), names[column], place))
    return np.array(values).reshape(-1, len(columns))
