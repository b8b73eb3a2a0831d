# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Columns of a foreign recording of unknown layout: its format, and all series of numbers in it.

Formats by their first bytes; of text also encoding, comments, delimiter, decimal and header rows.
"""
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
import json
from pathlib import Path
import re
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import open_unpacked
from gearbox_monitor.kernels.types import AnyArray
from gearbox_monitor.recordings.importer.containers import (
    HDF5, MATLAB_HEADER, opened_table, opened_tree, readable)
from gearbox_monitor.recordings.importer.mapping import TextFormat
from gearbox_monitor.recordings.importer.raw_columns import MIN_SAMPLES
from gearbox_monitor.recordings.importer.text_file import (
    is_number, numbers_of_list, row_per_signal, sample_rows, signal_rows, split_line, text_lines)
from gearbox_monitor.recordings.importer.unit_table import (
    number_with_unit, standard_unit, unit_of_label)

DATE = re.compile(r'\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d')
MOST_ROWS = 200_000  # that are looked at
HEAD_LINES = 300  # from which the layout of a text is seen
PICKLES = (b'\x80\x02', b'\x80\x03', b'\x80\x04', b'\x80\x05')
LEAST_FILLED = 0.01  # share of the cells of a column that holds numbers
MAX_HEADER = 5  # rows
MAX_DEPTH = 8  # of fields inside fields
MOST_COLUMNS = 64  # of a matrix
MOST_KEYS = 64  # words that tell rows apart, as names of joints do
JOINT_LIST = 'joint_list.txt'  # beside a recording
JOINT_LISTS = ('joint_names', 'joint_sequence', 'dof_names', 'joints', 'names')
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
    """
    Blocks of the mapping that describe the format, and the series of a recording.

    named: the file names its columns; joints: names of the joints, if the file lists them; rate
    (Hz): as a file beside it states, or None. row_keys: columns of words that come back.
    """

    blocks: Mapping[str, Any]
    series: Sequence[Series]
    named: bool = True
    joints: Sequence[str] = ()
    rate: float | None = None
    row_keys: Sequence[Series] = ()


def recognised_layout(path: str | Path) -> Format:
    """
    Return the Format of the file `path`, with the series of the most frequent length.

    Raises InputError: no such file, or fewer series than a recording needs.
    """
    with readable(path), open_unpacked(path) as stream:
        head = stream.read(MATLAB_HEADER + 8)
    kind = _format(path, head)
    joints: Sequence[str] = ()
    rate, labelled = None, True
    with readable(path):
        if kind == 'text':
            blocks, series, labelled = _text(path)
            joints = _listed_joints(path)
        elif kind in ('parquet', 'feather'):
            blocks, series = {'format': kind}, list(_of_table(path, kind))
            joints, rate = _of_dataset(path)
        else:
            blocks, series, joints = _tree(path, kind)
            labelled = any(column.label and not column.label.isdigit() for column in series)
    lengths = Counter(len(column.values) for column in series)
    length = max(lengths, key=lambda n: (lengths[n] > 1, n >= MIN_SAMPLES, lengths[n]), default=0)
    row_keys = [column for column in series if len(column.values) == length and _of_keys(column)]
    series = [column for column in series if len(column.values) == length
              and column not in row_keys]
    if len(series) < 2 or length < MIN_SAMPLES:
        raise InputError(f'{path}: {len(series)} columns of {length} numbers, read as {kind}: '
                         f'expected two or more of at least {MIN_SAMPLES}')
    return Format(blocks, series, labelled, joints, rate, row_keys)


def _may_be_keys(words: Sequence[str]) -> bool:
    """Return whether `words` may tell rows apart: few different ones, none empty."""
    return 1 < len(set(words)) <= MOST_KEYS and all(words)


def _of_keys(column: Series) -> bool:
    return column.values.dtype.kind == 'U' and not DATE.match(str(column.values[0]))


def _format(path: str | Path, head: bytes) -> str:
    """Return the format of a file whose first bytes are `head`. Raises InputError for a pickle."""
    if head[:2] in PICKLES or head.startswith(b'PK') and b'/data.pkl' in head:
        raise InputError(f'{path}: a Python pickle, which can run any program when it is loaded, '
                         'expected data: save it as .npz, .csv or .parquet')
    if head.startswith(b'MATLAB'):
        return 'mat'
    for start, kind in ((HDF5, 'hdf5'), (b'PAR1', 'parquet'), (b'ARROW1', 'feather'),
                        (b'FEA1', 'feather'), (b'\x93NUMPY', 'numpy'), (b'PK\x03\x04', 'numpy')):
        if head.startswith(start):
            return kind
    return 'json' if head.removeprefix(b'\xef\xbb\xbf').lstrip()[:1] in (b'{', b'[') else 'text'


# --- text ---------------------------------------------------------------------------------------
def _text(path: str | Path) -> tuple[dict[str, Any], list[Series], bool]:
    """Return (blocks of the mapping, series, whether the columns have names)."""
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
    own = [' '.join(filter(None, names[k])) if k < len(names) else '' for k in range(columns)]
    labels, units = _labelled(names, columns)
    units = units if any(units) else _preamble_units(path, text, columns)
    if not any(labels):
        labels = _echoed(cells, text) or labels
    default = TextFormat()
    block = {key: value for key, value in vars(text).items() if value != getattr(default, key)}
    series: list[Series] = []
    for k, label in enumerate(labels):
        column = [row[k] for row in cells]
        place: int | str = own[k] if own[k] and own.count(own[k]) == 1 else k + 1
        lists = numbers_of_list(column[0]) if column else None
        if lists and isinstance(place, str):
            series += _of_lists(label, place, [numbers_of_list(cell) or [] for cell in column])
            continue
        first = number_with_unit(column[0]) if column else None
        if first is not None:
            column = [cell.split()[0] if (number_with_unit(cell) or ('', ''))[1] == first[1]
                      else cell for cell in column]
        values = _column_values(column, text)
        if values is not None:
            unit = (first[1] if first else '') or unit_of_label(label) or units[k]
            series.append(Series({'column': place}, label or f'column {k + 1}', unit, values))
    return {'format': 'text', **({'text': block} if block else {})}, series, any(labels)


def _labelled(names: Sequence[Sequence[str]], columns: int) -> tuple[list[str], list[str]]:
    """
    Return (label, unit) of each column from the cells of its header rows.

    A row of units names none; a cell of a first row that stands above several columns is the name
    of their group.
    """
    rows = [[names[k][row] if k < len(names) and row < len(names[k]) else '' for k in
             range(columns)] for row in range(max(map(len, names), default=0))]
    units = [''] * columns
    if len(rows) > 1:
        last = [standard_unit(cell.strip('[]()')) for cell in rows[-1]]
        cells = [cell for cell in rows[-1] if cell.strip('-[]() ')]
        if cells and sum(map(bool, last)) >= 0.5 * len(cells):
            units, rows = last, rows[:-1]
    if len(rows) > 1:
        group = ''
        for k, cell in enumerate(rows[0]):
            group = cell or group
            rows[0][k] = group if rows[1][k] else cell
    return [' '.join(filter(None, column)) for column in zip(*rows)] or [''] * columns, units


def _preamble_units(path: str | Path, text: TextFormat, columns: int) -> list[str]:
    """Return the unit of each column from a skipped row with as many cells, most of them units."""
    lines = islice(text_lines(path, replace(text, skip=0)), HEAD_LINES) if text.skip else ()
    for number, line in lines:
        cells = split_line(line, text)
        units = [standard_unit(cell) for cell in cells]
        filled = sum(bool(cell.strip()) for cell in cells)
        if number <= text.skip and len(cells) == columns and 2 * sum(map(bool, units)) > filled:
            return units
    return [''] * columns


def _echoed(cells: Sequence[Sequence[str]], text: TextFormat) -> list[str]:
    """Return the labels of joint states as 'ros2 topic echo --csv' writes them, [] for others."""
    row = cells[0] if cells else []
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


def _of_lists(label: str, place: str, rows: Sequence[Sequence[float]]) -> Iterator[Series]:
    """Yield a Series for each place in lists of numbers, one list for each row."""
    width = min(map(len, rows))
    for k in range(min(width, MOST_COLUMNS)):
        yield Series({'column': f'{place}.{k + 1}'}, f'{label}.{k + 1}', unit_of_label(label),
                     np.array([row[k] for row in rows]))


def _column_values(cells: Sequence[str], text: TextFormat) -> AnyArray | None:
    """Return the numbers of a column (NaN: missing), or its dates; None: it has neither."""
    if DATE.match(cells[0] if cells else ''):
        return np.array([cell.strip() for cell in cells])
    if text.decimal == ',':
        cells = [cell.replace(',', '.') for cell in cells]
    words = [cell.strip() for cell in cells]
    if _may_be_keys(words) and not any(is_number(word, text) for word in set(words)):
        return np.array(words)
    values = np.full(len(cells), np.nan)
    filled = 0
    for k, cell in enumerate(cells):
        filled += bool(cell.strip())
        try:
            values[k] = float(cell)
        except ValueError:
            continue
    # Where another curve has its samples a cell is empty, which says nothing against this one.
    numbers = int(np.isfinite(values).sum())
    return values if numbers > 0.5 * filled and numbers >= LEAST_FILLED * len(cells) else None


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
        numeric = sum(_is_datum(cell, trial) or not cell.strip() for cell in flat)
        return (round(numeric / max(len(flat), 1), 2) * (max(map(len, cells), default=0) > 1),
                layout[1] == '.')
    delimiter, decimal = max(layouts, key=_score)
    text = replace(text, delimiter=delimiter, decimal=decimal)
    columns = Counter(len(split_line(line, text)) for line in body).most_common(1)[0][0] \
        if body else 0
    head = [split_line(line, text) for line in lines[:HEAD_LINES // 2]]
    is_data = [len(row) == columns and sum(
        _is_datum(cell, text) for cell in row) > sum(map(bool, row)) / 2 for row in head]
    # Numbers of a preamble stand before the names: data begin behind the last row of words.
    words = [k for k, row in enumerate(head) if not is_data[k] and _of_words(row, text)]
    begin = next((k for k in range(words[-1] + 1 if words else 0, len(head)) if is_data[k]), 0)
    header = 0
    while header < min(begin, MAX_HEADER) and _names_columns(head[begin - 1 - header], columns,
                                                              is_data[begin - 1 - header]):
        header += 1
    text = replace(text, header=header, skip=_lines_before(path, text, begin - header))
    if not header:  # numpy.savetxt and others: names in the last comment
        names = sample_rows(path, replace(text, header='comment'))[0]
        if len(names) == columns and not any(is_number(cell[0], text) for cell in names):
            return replace(text, header='comment'), names
    return replace(text, header=True if header == 1 else header), sample_rows(path, text)[0]


def _of_words(row: Sequence[str], text: TextFormat) -> bool:
    """Return whether most cells of a row that are not empty are words."""
    filled = [cell for cell in row if cell.strip()]
    return 2 * sum(not _is_datum(cell, text) for cell in filled) > len(filled)


def _names_columns(row: Sequence[str], columns: int, is_data: bool) -> bool:
    """Return whether a row may be one of the header: several cells, as many as data have."""
    return len(row) == columns and not is_data and sum(map(bool, row)) > min(1, columns - 1)


def _is_datum(cell: str, text: TextFormat) -> bool:
    """Return whether `cell` holds a number, a date or a list of numbers."""
    return (is_number(cell, text) or bool(DATE.match(cell)) or numbers_of_list(cell) is not None
            or number_with_unit(cell) is not None)


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
        elif _is_list(column.type) and not column.null_count:
            rows = column.to_pylist()
            if all(isinstance(cell, (int, float)) for cell in rows[0] or ['']):
                yield from _of_lists(name, name, rows)
        elif pa.types.is_string(column.type) and len(column) and (
                DATE.match(str(column[0].as_py())) or _may_be_keys(column.unique().to_pylist())):
            yield Series({'column': name}, name, '', np.array([str(text) for text in
                                                               column.to_pylist()]))


def _is_list(kind: Any) -> bool:
    import pyarrow as pa
    return bool(pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind)
                or pa.types.is_large_list(kind))


def _listed_joints(path: str | Path) -> Sequence[str]:
    """Return the names in JOINT_LIST beside the file, one in a line."""
    try:
        text = Path(path).with_name(JOINT_LIST).read_text(encoding='utf-8')
    except (OSError, ValueError):
        return ()
    return [line.strip() for line in text.splitlines() if line.strip()]


def _of_dataset(path: str | Path) -> tuple[Sequence[str], float | None]:
    """Return (joints, rate) of the folder of a dataset, by 'meta/info.json' above the file."""
    for folder in list(Path(path).absolute().parents)[:4]:
        try:
            content = json.loads((folder / 'meta' / 'info.json').read_text(encoding='utf-8'))
            names = content['features']['observation.state']['names']
            names = names.get('motors', []) if isinstance(names, dict) else names
            return [str(name).removesuffix('.pos') for name in names or ()], float(content['fps'])
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
    return (), None


def _tree(path: str | Path, kind: str) -> tuple[dict[str, Any], list[Series], Sequence[str]]:
    """Return (blocks of the mapping, series, names of joints that the file lists)."""
    with opened_tree(path, kind) as tree:
        if kind == 'json':
            where, entries = _entries(tree, '')
            if entries is not None:
                block = {'json': {'entries': where}} if where else {}
                return {'format': kind, **block}, list(_of_entries(entries)), ()
        names: Any = next((tree[key] for key in JOINT_LISTS if isinstance(tree, Mapping)
                           and key in tree), ())
        joints = [text.decode() if isinstance(text, bytes) else str(text) for text in
                  np.atleast_1d(names[()] if hasattr(names, 'attrs') else names)]
        return {'format': kind}, list(_of_fields(tree, '')), joints


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
    """Return numbers, dates or keys of rows in `value` as an array; None: it holds none."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind == 'U' and array.size and (DATE.match(str(array.flat[0])) or (
            array.ndim == 1 and _may_be_keys(array.tolist()))):
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
