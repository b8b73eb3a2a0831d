# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Text recordings: header rows, comments, a row per sample or per signal, columns of unequal length.

Numbers are read by numpy.loadtxt; row by row only to name the first bad value, to admit missing
ones, and for times that a double does not hold.
"""
from array import array
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
import csv
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import chain, islice, zip_longest
import math
from pathlib import Path
import re
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import lines_of
from gearbox_monitor.kernels.types import AnyArray, Array
from gearbox_monitor.recordings.importer.mapping import ImportMapping, TextFormat, TimeMapping
from gearbox_monitor.recordings.importer.raw_columns import (
    key_of, label_of, MIN_SAMPLES, Places, RawColumns)
from gearbox_monitor.recordings.importer.unit_table import (
    number_with_unit, standard_unit, TIME, unit_of_label)

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
    rows: Sequence[tuple[int, list[str]]]
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
    return TextTable(names, [(k + 1, list(column)) for k, column in
                             enumerate(columns) if k >= header],
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


@lru_cache(64)  # signals of one list are read one after the other
def numbers_of_list(cell: str) -> list[float] | None:
    """Return the numbers of a cell such as '[1.0, 2.0]', None if it is none."""
    brackets = re.fullmatch(r'\s*[\[(](.*)[\])]\s*', cell, re.DOTALL)
    if brackets is None:
        return None
    try:
        return [float(part) for part in brackets[1].replace(',', ' ').split()]
    except ValueError:
        return None


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
    text, lines = mapping.text, array('q')
    table = signal_rows(path, text) if row_per_signal(path, text) else None
    names = sample_rows(path, text)[0] if table is None else table.names
    lists = list_columns(names, places)
    numbers = column_numbers(path, mapping, {
        name: replace(place, column=lists[name][0]) if name in lists else place
        for name, place in places.items()}, names)

    def _place(row: int, name: str) -> str:
        line, column = (lines[row], numbers[name] + 1) if table is None else (
            table.numbers[numbers[name]], lines[row])
        return f'line {line}, column {column} ({name if (name,) in names else label_of(name)})'
    texts = {name for name, place in places.items()
             if isinstance(place, TimeMapping) and place.unit in AS_TEXT}
    values = None if table is not None or lists else _by_numpy(path, text, {
        name: column for name, column in numbers.items() if name not in texts}, lines)
    rows = partial(_cells, path, mapping, places, table, numbers)
    value = _parser(path, mapping, places, lists, _place)
    if values is None:
        del lines[:]
        values = _by_cells(rows(), numbers, texts, lines, value)
    reread = {name: numbers[name] for name, place in places.items() if name not in values or (
        isinstance(place, TimeMapping) and name not in texts and _rounded(values[name], place))}
    if reread:
        values |= _by_cells(rows(), reread, reread, array('q'), value)
    notice = () if table is None else (
        f'one row per signal ({len(table.numbers)} rows of {len(lines)} samples): column numbers '
        'count the rows',)
    return RawColumns(values, _place, notice, _units(numbers, names))


def _by_numpy(path: str | Path, text: TextFormat, numbers: Mapping[str, int],
              lines: 'array[int]') -> dict[str, AnyArray] | None:
    """Return {name: column of `numbers`}, None where a cell holds none; fill `lines`."""
    _, rows = sample_rows(path, text)
    first = next(rows, None)
    if first is None:
        raise InputError(f'{path}: no rows of data, expected at least {MIN_SAMPLES}')

    def _data() -> Iterator[str]:
        for number, line in chain([first], rows):
            lines.append(number)
            yield line.replace(',', '.') if text.decimal == ',' else line
    delimiter = None if text.delimiter == 'whitespace' else text.delimiter
    columns = sorted({*numbers.values()})
    if not columns:  # times that are texts alone
        return None
    try:
        values: Array = np.loadtxt(_data(), delimiter=delimiter, usecols=columns, comments=None,
                                   quotechar=None if delimiter is None else '"', ndmin=2)
    except (UnicodeDecodeError, InputError):
        raise
    except ValueError:
        return None
    return {name: values[:, columns.index(column)].copy() for name, column in numbers.items()}


def _cells(path: str | Path, mapping: ImportMapping, places: Places, table: TextTable | None,
           numbers: Mapping[str, int]) -> Iterator[tuple[int, list[str]]]:
    """Yield (number, cells) of each sample: its line, or its column in a `table` of signals."""
    count = max(numbers.values()) + 1
    if table is not None:
        if len(table.numbers) < count:
            name = max(numbers, key=lambda name: numbers[name])
            raise InputError(f'{path}: {len(table.numbers)} rows, one per signal, expected row '
                             f'{count} ({label_of(name)})')
        yield from table.rows
        return
    unequal = any(getattr(place, 'time', None) is not None for place in places.values())
    for number, line in sample_rows(path, mapping.text)[1]:
        cells = split_line(line, mapping.text)
        if len(cells) < count and not unequal:
            raise InputError(f'{path}: line {number}: {len(cells)} columns, expected at least '
                             f'{count}')
        yield number, cells + [''] * (count - len(cells))


def _by_cells(rows: Iterator[tuple[int, list[str]]], numbers: Mapping[str, int],
              texts: Container[str], lines: 'array[int]',
              value: Callable[[str, str, int], float]) -> dict[str, AnyArray]:
    """Return {name: column of `numbers`}, of `texts` as texts, else by `value`; fill `lines`."""
    columns: dict[str, Any] = {name: [] if name in texts else array('d') for name in numbers}
    for row, (number, cells) in enumerate(rows):
        lines.append(number)
        for name, column in numbers.items():
            cell = cells[column].strip()
            columns[name].append(cell if name in texts else value(cell, name, row))
    return {name: np.array(values) for name, values in columns.items()}


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


def _parser(path: str | Path, mapping: ImportMapping, places: Places,
            lists: Mapping[str, tuple[str, int]], place: Callable[[int, str], str]
            ) -> Callable[[str, str, int], float]:
    """Return the function that makes a number of a cell, of a signal's name and of its row."""
    # Where signals have times of their own, the shorter columns end in empty cells.
    unequal = any(getattr(place, 'time', None) is not None for place in places.values())
    may_miss = {name for name, place in places.items()
                if unequal or getattr(place, 'missing', 'error') == 'nan'}

    def _value(cell: str, name: str, row: int) -> float:
        if name in lists:
            element, own = lists[name][1], numbers_of_list(cell) or []
            if len(own) < element:
                raise InputError(f'{path}: {place(row, name)} value {cell[:40]!r}: expected a '
                                 f'list of at least {element} numbers')
            return own[element - 1]
        try:
            if name in may_miss and cell.lower() in MISSING:
                return math.nan
            return float(cell.replace(',', '.') if mapping.text.decimal == ',' else cell)
        except ValueError:
            number = number_with_unit(cell)
            if number is not None and number[1] == standard_unit(
                    str(getattr(places[name], 'unit', ''))):
                return number[0]
            raise InputError(f'{path}: {place(row, name)} value {cell!r}: expected a '
                             'number') from None
    return _value
