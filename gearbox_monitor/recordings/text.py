# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Text recordings: their layout, found in the first lines, and their rows in blocks.

The layout is encoding, comments, delimiter, decimal point, rows of names and units, and where the
data begin. Blocks of plain numbers are read by numpy at once, others cell by cell.
"""
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
import contextlib
import csv
from dataclasses import dataclass, field, replace
import gzip
from pathlib import Path
import re
import warnings
import zlib

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import LONGEST_LINE, open_unpacked
from gearbox_monitor.kernels.types import AnyArray, Array
from gearbox_monitor.recordings.meaning import number_with_unit, scaled_unit

DATE = re.compile(r'\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d')
POINTED = re.compile(r'\s*[-+]?\d*\.\d+\s*')
COMMENTS = ('#', '%', '//')
DELIMITERS = (',', ';', '\t', '|', 'whitespace')
MISSING = frozenset(('', 'nan', 'na', 'n/a', 'null', 'none', '-'))
HEAD_LINES = 300   # from which the layout is seen
HEAD_BYTES = 1 << 26
MAX_HEADER = 5     # rows of names
MAX_COLUMNS = 4096
BLOCK = 1 << 22    # bytes of text that are read at once
MIN_SAMPLES = 100  # of a recording; a text with fewer rows and more columns has rows of signals


@dataclass(frozen=True)
class TextFormat:
    """Format of a text file; delimiter: 'whitespace' is any run of blanks and tabs."""

    encoding: str
    comment: str
    delimiter: str = ''
    decimal: str = '.'


@dataclass(frozen=True)
class TextLayout:
    """
    A complete format and what stands above the data.

    names, units: of the columns, '' for none; first: number of the first line of data, from 1.
    clocks {column: column of its time}, of curves with a time of their own.
    """

    text: TextFormat
    names: tuple[str, ...]
    units: tuple[str, ...]
    first: int
    clocks: Mapping[int, int] = field(default_factory=dict)


# --- layout -------------------------------------------------------------------------------------
def layout_of(path: Path) -> TextLayout:
    """Return the TextLayout of a file, gzipped or not. Raises InputError: it is not a text."""
    raw = list[bytes]()
    with open_unpacked(path) as stream:
        while len(raw) < HEAD_LINES and (line := stream.readline(BLOCK)):
            raw.append(line)
            if len(line) == BLOCK or sum(map(len, raw)) > HEAD_BYTES:
                raise InputError(f'{path}: a line of more than {BLOCK >> 20} MB, or {HEAD_LINES} '
                                 f'of {HEAD_BYTES >> 20}, expected a table of text: is it binary?')
    head = b''.join(raw)
    encoding = 'utf-8' if _decodes(head) else 'latin-1'
    if head.count(0):
        raise InputError(f'{path}: bytes of zero, expected a table of text: is it binary?')
    lines = [line.decode(encoding, 'replace').removeprefix('\ufeff').rstrip('\r\n')
             for line in raw]
    first = next((line.strip() for line in lines if line.strip()), '')
    comment = next((mark for mark in COMMENTS if first.startswith(mark)), '#')
    numbered = [(k, line) for k, line in enumerate(lines, 1)
                if line.strip() and not line.lstrip().startswith(comment)]
    if not numbered:
        raise InputError(f'{path}: no rows of data, expected a recording')
    try:
        text = _with_delimiter(TextFormat(encoding, comment), [
            line for _, line in numbered[len(numbered) // 2:]])
        rows = [(k, split_line(line, text)) for k, line in numbered]
    except InputError as error:
        raise InputError(f'{path}: {error}') from None
    width = max(len(cells) for _, cells in rows)
    if width > MAX_COLUMNS and len(rows) >= MIN_SAMPLES:
        raise InputError(f'{path}: {width} columns, expected at most {MAX_COLUMNS}')
    if len(rows) < MIN_SAMPLES and len(lines) < HEAD_LINES and all(
            len(cells) >= MIN_SAMPLES for _, cells in rows):
        raise InputError(f'{path}: a row for each of {len(rows)} signals, expected a column for '
                         'each: transpose it')
    return _named(text, rows, lines)


def _decodes(data: bytes) -> bool:
    try:
        data.decode('utf-8')
    except UnicodeDecodeError as error:
        return error.start >= len(data) - 3  # cut within a character
    return True


def _with_delimiter(text: TextFormat, body: Sequence[str]) -> TextFormat:
    """Return `text` with the delimiter and decimal point that make most of `body` numbers."""
    layouts = [(delimiter, decimal) for delimiter in DELIMITERS for decimal in '.,'
               if delimiter != decimal]

    def _score(layout: tuple[str, str]) -> tuple[float, int]:
        trial = replace(text, delimiter=layout[0], decimal=layout[1])
        cells = [split_line(line, trial) for line in body]
        flat = [cell for row in cells for cell in row]
        numeric = sum(_is_datum(cell, trial) or not cell.strip() for cell in flat)
        return (round(numeric / max(len(flat), 1), 2) * (max(map(len, cells), default=0) > 1),
                layout[1] == '.')
    delimiter, decimal = max(layouts, key=_score)
    if decimal == ',' and any(POINTED.fullmatch(cell) for line in body for cell in split_line(
            line, replace(text, delimiter=delimiter))):
        raise InputError('some numbers have a point and some a comma, expected one decimal mark, '
                         'and none between thousands')
    return replace(text, delimiter=delimiter, decimal=decimal)


def _named(text: TextFormat, rows: Sequence[tuple[int, list[str]]], lines: Sequence[str]
           ) -> TextLayout:
    """Return the layout of `rows` [(line number, cells)] of samples; `lines`: all of the head."""
    body = rows[len(rows) // 2:]
    width = Counter(len(cells) for _, cells in body).most_common(1)[0][0]
    scope = _scope_layout(text, rows, width)
    if scope is not None:
        return scope
    is_data = [len(cells) == width and sum(_is_datum(cell, text) for cell in cells) > sum(
        map(bool, cells)) / 2 for _, cells in rows]
    half = len(rows) // 2 if len(rows) > 2 else len(rows)
    # Numbers of a preamble stand before the names: data begin behind the last row of words.
    words = [k for k in range(half) if not is_data[k] and _of_words(rows[k][1], text)]
    begin = next((k for k in range(words[-1] + 1 if words else 0, len(rows)) if is_data[k]),
                 0)
    header = 0
    while header < min(begin, MAX_HEADER):
        cells = rows[begin - 1 - header][1]
        if len(cells) != width or is_data[begin - 1 - header] or sum(map(bool, cells)) <= min(
                1, width - 1):
            break
        header += 1
    first = rows[begin][0] if begin < len(rows) else rows[-1][0] + 1
    cells_above = [[cell.strip() for cell in cells] for _, cells in rows[begin - header:begin]]
    names, units = _labels(cells_above, width)
    if not any(units):
        units = _preamble_units(rows[:begin - header], width)
    if not header and begin < len(rows):
        comments = [line.strip().lstrip(text.comment) for line in lines[:first - 1]
                    if line.lstrip().startswith(text.comment)]
        listed = [cell.strip() for cell in split_line(comments[-1], text)] if comments else []
        if len(listed) == width and not any(is_number(cell, text) for cell in listed):
            names = listed  # numpy.savetxt and others: names in the last comment
        else:
            names = _echoed(rows[begin][1], text) or names
    return TextLayout(text, tuple(names), tuple(units), first)


def _scope_layout(text: TextFormat, rows: Sequence[tuple[int, list[str]]], width: int
                  ) -> TextLayout | None:
    """Return the layout of a TwinCAT scope: properties by row, each curve behind its time."""
    whole = [(number, cells) for number, cells in rows if len(cells) == width]
    first = next((number for number, cells in whole[1:] if is_number(cells[0], text)), 0)
    by_key = {cells[0].strip(): [cell.strip() for cell in cells]
              for number, cells in whole if number < first}
    names = by_key.get('Name', [])
    if not first or width < 2 or 'SampleTime[ms]' not in by_key:
        return None
    units = by_key.get('Unit', [''] * width)
    times = [k for k, name in enumerate(names) if name == 'Name']
    labels = [f'time {names[min(k + 1, width - 1)]}' if k in times else name
              for k, name in enumerate(names)]
    return TextLayout(text, tuple(labels), tuple(
        'ms' if k in times else _unit(unit) for k, unit in enumerate(units)), first, {
            k: max((time for time in times if time < k), default=0)
            for k in range(len(names)) if k not in times})


def _labels(rows: list[list[str]], width: int) -> tuple[list[str], list[str]]:
    """Return (names, units) of columns from the header `rows`: the last may hold units."""
    rows = [[*row, *[''] * (width - len(row))][:width] for row in rows]
    units = [''] * width
    if len(rows) > 1:
        last = [_unit(cell.strip('[]()')) for cell in rows[-1]]
        cells = [cell for cell in rows[-1] if cell.strip('-[]() ')]
        if cells and sum(map(bool, last)) >= 0.5 * len(cells):
            units, rows = last, rows[:-1]
    if len(rows) > 1:
        group = ''
        for k, cell in enumerate(rows[0]):
            group = cell or group
            rows[0][k] = group if rows[1][k] else cell
    return [' '.join(filter(None, column)) for column in zip(*rows)] or [''] * width, units


def _unit(cell: str) -> str:
    """Return the unit in a `cell`, with the number in front of it, '' if it holds none."""
    return cell.strip() if scaled_unit(cell)[1] else ''


def _preamble_units(rows: Sequence[tuple[int, list[str]]], width: int) -> list[str]:
    """Return the units in a row above the header with as many cells, most of them units."""
    above = ([*map(_unit, cells)] for _, cells in rows if len(cells) == width
             and 2 * sum(bool(_unit(cell)) for cell in cells) > sum(
                 bool(cell.strip()) for cell in cells))
    return next(above, [''] * width)


def _echoed(row: Sequence[str], text: TextFormat) -> list[str]:
    """Return the labels of joint states as 'ros2 topic echo --csv' writes them, [] for others."""
    if len(row) < 6 or not (row[0].strip().isdigit() and row[1].strip().isdigit()):
        return []
    count = next((k for k, cell in enumerate(row[3:]) if is_number(cell, text)), 0)
    joints = [cell.strip() for cell in row[3:3 + count]]
    quantities = (len(row) - 3 - count) / count if count else 0.0
    if quantities not in (1.0, 2.0, 3.0) or is_number(row[2], text):
        return []
    return ['header.stamp.sec', 'header.stamp.nanosec', 'frame_id', *(
        f'name {k}' for k in range(count)), *(
        f'{quantity} {joint}' for quantity in ('position', 'velocity', 'effort')[:int(quantities)]
        for joint in joints)]


def split_line(line: str, text: TextFormat) -> list[str]:
    """Return the cells of `line` in the format `text`. Raises InputError."""
    if text.delimiter == 'whitespace':
        return line.split()
    line = line.rstrip('\n').replace('\r', '')
    if '"' not in line and 0 < len(line) < csv.field_size_limit():  # as csv does, and faster
        return [cell.lstrip(' ') for cell in line.split(text.delimiter)]
    try:
        return next(csv.reader([line], delimiter=text.delimiter, skipinitialspace=True), [])
    except csv.Error as error:
        raise InputError(f'{error}, expected a table of text with cells of numbers: is it '
                         'binary?') from None


def is_number(cell: str, text: TextFormat) -> bool:
    """Return whether `cell` holds a number in the format `text`."""
    return number_of(cell, text) is not None


def number_of(cell: str, text: TextFormat) -> float | None:
    """Return the number in `cell`, None where there is none."""
    try:
        return float(cell.replace(',', '.') if text.decimal == ',' else cell)
    except ValueError:
        return None


def numbers_of_list(cell: str) -> list[float] | None:
    """Return the numbers of a cell such as '[1.0, 2.0]', None if it is none."""
    brackets = re.fullmatch(r'\s*[\[(](.*)[\])]\s*', cell, re.DOTALL)
    if brackets is None:
        return None
    try:
        return [float(part) for part in brackets[1].replace(',', ' ').split()]
    except ValueError:
        return None


def _is_datum(cell: str, text: TextFormat) -> bool:
    """Return whether `cell` holds a number, a date or a list of numbers."""
    return (is_number(cell, text) or bool(DATE.match(cell)) or numbers_of_list(cell) is not None
            or number_with_unit(cell) is not None)


def _of_words(row: Sequence[str], text: TextFormat) -> bool:
    """Return whether most cells of a row that are not empty are words."""
    filled = [cell for cell in row if cell.strip()]
    return 2 * sum(not _is_datum(cell, text) for cell in filled) > len(filled)


# --- rows ---------------------------------------------------------------------------------------
@dataclass(frozen=True)
class RowBlock:
    """Rows of some columns {name: [N]}; `numbers` [N] of the lines or rows that hold them."""

    values: Mapping[str, AnyArray]
    numbers: AnyArray
    unit: str = 'line'

    def place(self, row: int, name: str) -> str:
        """Return where the value of column `name` in `row` stands, for messages."""
        return f'{self.unit} {self.numbers[row]}, column {name}'


@dataclass(frozen=True)
class TextRows:
    """What reads a text in blocks; places {name: (column, place in its list or None)}."""

    path: Path
    layout: TextLayout
    places: Mapping[str, tuple[int, int | None]]

    def __call__(self, numbers: Collection[str], texts: Collection[str] = ()
                 ) -> Iterator[RowBlock]:
        """
        Yield the rows of the file in blocks.

        Args:
            numbers: columns that are read as numbers, NaN for an empty cell.
            texts: columns that are read as texts.

        Raises:
            InputError: it names line, column and value.
        """
        with readable(self.path), open_unpacked(self.path) as stream:
            number, rest = 1, b''
            while chunk := stream.read(BLOCK):
                data = rest + chunk
                if len(chunk) == BLOCK or stream.peek(1):  # type: ignore[attr-defined]
                    cut = data.rfind(b'\n') + 1
                    data, rest = data[:cut], data[cut:]
                    if not cut and len(rest) > 64 * LONGEST_LINE:
                        raise InputError(f'{self.path}: a line of more than {len(rest) >> 20} MB, '
                                         'expected a table of text: is it binary?')
                else:
                    rest = b''
                yield from self._block(data, number, numbers, texts)
                number += data.count(b'\n')
            yield from self._block(rest, number, numbers, texts)

    def _block(self, data: bytes, number: int, numbers: Collection[str], texts: Collection[str]
               ) -> Iterator[RowBlock]:
        """Yield the rows in `data`, whose first line is line `number` of the file."""
        layout = self.layout
        if number < layout.first:
            _, *behind = data.split(b'\n', layout.first - number)
            if len(behind) < layout.first - number:
                return
            data, number = behind[-1], layout.first
        count = data.count(b'\n') + (not data.endswith(b'\n') and bool(data))
        plain = [self.places[name] for name in numbers]
        if not texts and all(place is None for _, place in plain):
            table = _numbers(data, layout, count)
            if table is not None and max((k for k, _ in plain), default=0) < table.shape[1]:
                yield RowBlock({name: table[:, self.places[name][0]].copy() for name in numbers},
                               np.arange(number, number + count))
                return
        try:
            decoded = data.decode(layout.text.encoding)
        except UnicodeDecodeError as error:
            raise InputError(f'{self.path}: byte {error.object[error.start]:#04x} is not '
                             f'{error.encoding}, expected text in one encoding') from None
        kept = [(k, line) for k, line in enumerate(decoded.splitlines(), number)
                if line.strip() and not line.lstrip().startswith(layout.text.comment)]
        if kept:
            yield self._cells(kept, numbers, texts)

    def _cells(self, lines: Sequence[tuple[int, str]], numbers: Collection[str],
               texts: Collection[str]) -> RowBlock:
        """Return the columns of `lines`, read cell by cell."""
        layout, at = self.layout, [number for number, _ in lines]
        rows: list[list[str]] = []
        try:
            for number, line in lines:
                rows.append(split_line(line, layout.text))
        except InputError as error:
            raise InputError(f'{self.path}: line {number}: {error}') from None
        last = max((self.places[name][0] for name in (*numbers, *texts)), default=0)
        for row, number in zip(rows, at):
            if len(row) <= last and not layout.clocks:
                raise InputError(f'{self.path}: line {number}: {len(row)} columns, expected at '
                                 f'least {last + 1}')
            row += [''] * (last + 1 - len(row))
        columns: dict[str, AnyArray] = {
            name: np.array([row[self.places[name][0]].strip() for row in rows]) for name in texts}
        for name in numbers:
            k, place = self.places[name]
            values = [_cell_value(row[k].strip(), place, layout.text) for row in rows]
            if None in values:
                wrong = values.index(None)
                expected = 'a number' if place is None else f'a list of at least {place + 1} ' \
                    'numbers'
                raise InputError(f'{self.path}: line {at[wrong]}, column {name}: '
                                 f'{rows[wrong][k].strip()[:40]!r}, expected {expected}')
            columns[name] = np.array(values, float)
        return RowBlock(columns, np.array(at))


def _cell_value(cell: str, place: int | None, text: TextFormat) -> float | None:
    """Return the number in a `cell`, that at a `place` of its list; NaN: empty, None: neither."""
    if place is not None:
        listed = numbers_of_list(cell) or []
        return listed[place] if place < len(listed) else None
    value = number_of(cell, text)
    if value is None and cell.lower() in MISSING:
        return np.nan
    pair = number_with_unit(cell) if value is None else None
    return pair[0] if pair else value


@contextlib.contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turn errors of reading the file `path` into InputErrors."""
    try:
        yield
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise InputError(f'{path}: {error}, expected a whole gzip file') from None
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}, expected a readable file') from None


def _numbers(data: bytes, layout: TextLayout, rows: int) -> Array | None:
    """Return the numbers [rows, columns] of `data`, None where a cell holds something else."""
    text, columns = layout.text, len(layout.names)
    if text.encoding.lower().replace('-', '') not in ('utf8', 'latin1', 'ascii') or not rows:
        return None
    if b'\r' in data:
        data = data.replace(b'\r\n', b'\n')
    if text.decimal == ',':
        data = data.replace(b',', b'.')
    separator = ' '
    if text.delimiter != 'whitespace':
        mark, separator = text.delimiter.encode(), ','
        for cut in (mark, b'\n'):  # empty cells
            pair, filled = mark + cut, mark + b'nan' + cut
            if pair in data:
                data = data.replace(pair, filled).replace(pair, filled)
        data = data.replace(b'\n' + mark, b'\nnan' + mark).replace(mark, b',')
        data = data.rstrip(b'\n').replace(b'\n', b',')
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        try:
            values = np.fromstring(data, sep=separator)
        except (DeprecationWarning, ValueError):
            return None
    return values.reshape(rows, columns) if len(values) == rows * columns else None
