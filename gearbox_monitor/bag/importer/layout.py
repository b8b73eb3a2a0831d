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
Columns of a foreign recording of unknown layout: its format, and all series of numbers in it.

Formats by their first bytes; of text also encoding, comments, delimiter, decimal and header rows.
"""
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
import re
from typing import Any

import numpy as np

from gearbox_monitor.bag.importer.containers import (
    HDF5, MATLAB_HEADER, opened_table, opened_tree, readable)
from gearbox_monitor.bag.importer.mapping import TextFormat
from gearbox_monitor.bag.importer.raw_columns import MIN_SAMPLES
from gearbox_monitor.bag.importer.text_file import (
    is_number, row_per_signal, sample_rows, signal_rows, split_line, text_lines)
from gearbox_monitor.bag.importer.unit_table import standard_unit, unit_of_label
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.packed_files import open_unpacked
from gearbox_monitor.kernels.types import AnyArray

DATE = re.compile(r'\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d')
MOST_ROWS = 200_000  # that are looked at
HEAD_LINES = 300  # from which the layout of a text is seen
MAX_HEADER = 5  # rows
MAX_DEPTH = 8  # of fields inside fields
MOST_COLUMNS = 64  # of a matrix
COMMENTS = ('#', '%', '//')
DELIMITERS = (',', ';', '\t', 'whitespace')


@dataclass(frozen=True)
class Series:
    """A column of a recording: its place in a mapping, name, unit ('' = not stated), values."""

    place: Mapping[str, int | str]
    label: str
    unit: str
    values: AnyArray


@dataclass(frozen=True)
class Format:
    """Blocks of the mapping that describe the format, and the series of a recording."""

    blocks: Mapping[str, Any]
    series: Sequence[Series]


def recognised_layout(path: str | Path) -> Format:
    """
    Return the Format of the file `path`, with the series of the most frequent length.

    Raises InputError: no such file, or fewer series than a recording needs.
    """
    with readable(path), open_unpacked(path) as stream:
        head = stream.read(MATLAB_HEADER + 8)
    kind = _format(head)
    with readable(path):
        if kind == 'text':
            blocks, series = _text(path)
        elif kind in ('parquet', 'feather'):
            blocks, series = {'format': kind}, list(_of_table(path, kind))
        else:
            blocks, series = _tree(path, kind)
    lengths = Counter(len(column.values) for column in series)
    length = max(lengths, key=lambda n: (lengths[n] > 1, n >= MIN_SAMPLES, lengths[n]), default=0)
    series = [column for column in series if len(column.values) == length]
    if len(series) < 2 or length < MIN_SAMPLES:
        raise InputError(f'{path}: {len(series)} columns of {length} numbers, read as {kind}: '
                         f'expected two or more of at least {MIN_SAMPLES}')
    return Format(blocks, series)


def _format(head: bytes) -> str:
    """Return the format of a file whose first bytes are `head`."""
    if head.startswith(b'MATLAB'):
        return 'mat'
    for start, kind in ((HDF5, 'hdf5'), (b'PAR1', 'parquet'), (b'ARROW1', 'feather'),
                        (b'FEA1', 'feather'), (b'\x93NUMPY', 'numpy'), (b'PK\x03\x04', 'numpy')):
        if head.startswith(start):
            return kind
    return 'json' if head.removeprefix(b'\xef\xbb\xbf').lstrip()[:1] in (b'{', b'[') else 'text'


# --- text ---------------------------------------------------------------------------------------
def _text(path: str | Path) -> tuple[dict[str, Any], list[Series]]:
    text, names = _text_format(path)
    if row_per_signal(path, text):
        table = signal_rows(path, text)
        rows = (cells for _, cells in table.rows)
        names = table.names if any(map(any, table.names)) else ()
        text = replace(text, header=bool(names), rows='signals')
    else:
        rows = (split_line(line, text) for _, line in sample_rows(path, text)[1])
    cells = list(islice(rows, MOST_ROWS))
    columns = Counter(map(len, cells)).most_common(1)[0][0] if cells else 0
    cells = [row for row in cells if len(row) == columns]
    labels = [' '.join(filter(None, names[k])) if k < len(names) else '' for k in range(columns)]
    default = TextFormat()
    block = {key: value for key, value in vars(text).items() if value != getattr(default, key)}
    series = []
    for k, label in enumerate(labels):
        values = _column_values([row[k] for row in cells], text)
        if values is not None:
            unique = label and labels.count(label) == 1
            unit = unit_of_label(label) or (standard_unit(names[k][-1]) if unique and
                                            len(names[k]) > 1 else '')
            place = {'column': label if unique else k + 1}
            series.append(Series(place, label or f'column {k + 1}', unit, values))
    return {'format': 'text', **({'text': block} if block else {})}, series


def _column_values(cells: Sequence[str], text: TextFormat) -> AnyArray | None:
    """Return the numbers of a column (NaN: missing), or its dates; None: it has neither."""
    if DATE.match(cells[0] if cells else ''):
        return np.array([cell.strip() for cell in cells])
    if text.decimal == ',':
        cells = [cell.replace(',', '.') for cell in cells]
    values = np.full(len(cells), np.nan)
    for k, cell in enumerate(cells):
        try:
            values[k] = float(cell)
        except ValueError:
            continue
    return values if np.isfinite(values).mean() > 0.5 else None


def _text_format(path: str | Path) -> tuple[TextFormat, Sequence[Sequence[str]]]:
    """Return the TextFormat of a file and the header cells of its columns."""
    with open_unpacked(path) as stream:
        raw = list(islice(iter(lambda: stream.readline(1 << 22), b''), HEAD_LINES))
    try:
        encoding, _ = 'utf-8', b''.join(raw).decode('utf-8')
    except UnicodeDecodeError:
        encoding = 'latin-1'
    first = next((line.decode(encoding).strip() for line in raw if line.strip()), '')
    comment = next((mark for mark in COMMENTS if first.lstrip('\ufeff').startswith(mark)), '#')
    text = TextFormat(encoding=encoding, comment=comment)
    lines = [line for _, line in islice(text_lines(path, text), HEAD_LINES)]
    body = lines[len(lines) // 2:]
    layouts = [(delimiter, decimal) for delimiter in DELIMITERS for decimal in '.,'
               if delimiter != decimal]

    def _score(layout: tuple[str, str]) -> tuple[float, int]:
        trial = replace(text, delimiter=layout[0], decimal=layout[1])
        cells = [split_line(line, trial) for line in body]
        flat = [cell for row in cells for cell in row]
        numeric = sum(is_number(cell, trial) or not cell.strip() or bool(DATE.match(cell))
                      for cell in flat)
        return (round(numeric / max(len(flat), 1), 2) * (max(map(len, cells), default=0) > 1),
                layout[1] == '.')
    delimiter, decimal = max(layouts, key=_score)
    text = replace(text, delimiter=delimiter, decimal=decimal)
    columns = Counter(len(split_line(line, text)) for line in body).most_common(1)[0][0] \
        if body else 0
    head = [split_line(line, text) for line in lines[:HEAD_LINES // 2]]
    is_data = [len(row) == columns and sum(
        is_number(cell, text) or bool(DATE.match(cell)) for cell in row) > len(row) / 2
        for row in head]
    before = is_data.index(True) if True in is_data else 0
    header = 0
    while header < min(before, MAX_HEADER) and len(head[before - 1 - header]) == columns:
        header += 1
    text = replace(text, header=header, skip=_lines_before(path, text, before - header))
    if not header:  # numpy.savetxt and others: names in the last comment
        names = sample_rows(path, replace(text, header='comment'))[0]
        if len(names) == columns and not any(is_number(cell[0], text) for cell in names):
            return replace(text, header='comment'), names
    return replace(text, header=True if header == 1 else header), sample_rows(path, text)[0]


def _lines_before(path: str | Path, text: TextFormat, rows: int) -> int:
    """Return the number of the last of the first `rows` rows that are no header."""
    return max((number for number, _ in islice(text_lines(path, text), rows)), default=0)


# --- fields and tables --------------------------------------------------------------------------
def _of_table(path: str | Path, kind: str) -> Iterator[Series]:
    import pyarrow as pa
    table = opened_table(path, kind)
    for name in table.column_names:
        column = table[name]
        if pa.types.is_timestamp(column.type) and not column.null_count:
            values = column.cast(pa.int64()).to_numpy().astype(f'M8[{column.type.unit}]')
            yield Series({'column': name}, name, '', values)
        elif pa.types.is_integer(column.type) or pa.types.is_floating(column.type):
            yield Series({'column': name}, name, unit_of_label(name), column.to_numpy())
        elif pa.types.is_string(column.type) and len(column) and DATE.match(
                str(column[0].as_py())):
            yield Series({'column': name}, name, '', np.array([str(text) for text in
                                                               column.to_pylist()]))


def _tree(path: str | Path, kind: str) -> tuple[dict[str, Any], list[Series]]:
    with opened_tree(path, kind) as tree:
        if kind == 'json':
            where, entries = _entries(tree, '')
            if entries is not None:
                block = {'json': {'entries': where}} if where else {}
                return {'format': kind, **block}, list(_of_entries(entries))
        return {'format': kind}, list(_of_fields(tree, ''))


def _entries(tree: Any, where: str) -> tuple[str, list[Any] | None]:
    """Return (dotted path, entries) of the list of mappings or rows in JSON data."""
    if isinstance(tree, list):
        rows = len(tree) >= MIN_SAMPLES or tree and isinstance(tree[0], list)
        return where, tree if rows and isinstance(tree[0], (dict, list)) else None
    for name, value in tree.items() if isinstance(tree, dict) and where.count('.') < 3 else ():
        path, entries = _entries(value, f'{where}.{name}'.lstrip('.'))
        if entries is not None:
            return path, entries
    return where, None


def _of_entries(entries: list[Any]) -> Iterator[Series]:
    if isinstance(entries[0], list):
        matrix = _matrix(entries)
        if matrix is not None:
            yield from _columns({}, '', '', matrix)
        return
    for field in _leaves(entries[0], ''):
        values = [_at(entry, field.split('.')) for entry in entries[:MOST_ROWS]]
        array = _matrix([v for v in values if v is not None]) if len(values) else None
        if array is not None and len(array) == len(values):
            yield from _columns({'field': field}, field, unit_of_label(field), array)
        elif array is not None and array.ndim == 1 and array.dtype.kind != 'U':
            yield from _columns({'field': field}, field, unit_of_label(field), np.array(
                [np.nan if v is None else v for v in values], float))


def _leaves(entry: Any, prefix: str) -> Iterator[str]:
    for name, value in entry.items():
        if isinstance(value, dict):
            yield from _leaves(value, f'{prefix}{name}.')
        else:
            yield prefix + name


def _at(entry: Any, parts: Sequence[str]) -> Any:
    for part in parts:
        entry = entry.get(part) if isinstance(entry, dict) else None
    return entry


def _matrix(value: Any) -> AnyArray | None:
    """Return numbers or dates of `value` as an array of one or two dimensions, None otherwise."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind == 'U' and array.size and DATE.match(str(array.flat[0])):
        return array
    if array.dtype.kind not in 'iuf' or array.ndim not in (1, 2):
        return None
    return array


def _columns(place: Mapping[str, str], label: str, unit: str, array: AnyArray
             ) -> Iterator[Series]:
    """Yield the Series of a vector, or of the columns of a matrix, with a row per sample."""
    if array.ndim == 2 and 1 in array.shape:
        array = array.ravel()
    if array.ndim == 1:
        yield Series(place, label, unit, array)
        return
    if array.shape[0] < MIN_SAMPLES <= array.shape[1]:
        array = array.T
    for k in range(min(array.shape[1], MOST_COLUMNS)):
        yield Series({**place, 'column': k + 1}, f'{label} {k + 1}'.strip(), unit, array[:, k])


def _of_fields(tree: Any, prefix: str) -> Iterator[Series]:
    """Yield the Series of all arrays in a tree of fields."""
    if not isinstance(tree, Mapping):
        array = _matrix(tree)
        if array is not None and array.size >= MIN_SAMPLES:
            yield from _columns({}, '', '', array)
        return
    for name, value in tree.items() if prefix.count('.') < MAX_DEPTH else ():
        field = f'{prefix}{name}'
        if isinstance(value, Mapping):
            yield from _of_fields(value, field + '.')
            continue
        records = getattr(getattr(value, 'dtype', None), 'names', None)
        if records:
            for part in records:
                yield from _of_fields({part: value[part]}, field + '.')
            continue
        attributes = getattr(value, 'attrs', {})
        array = _matrix(value[()] if hasattr(value, 'attrs') else value)
        if array is None or array.size < MIN_SAMPLES:
            continue
        array = array.T if 'MATLAB_class' in attributes else array
        stated = attributes.get('units', attributes.get('unit', ''))
        stated = stated.decode() if isinstance(stated, bytes) else str(stated)
        yield from _columns({'field': field}, field, standard_unit(stated) or
                            unit_of_label(name), array)
