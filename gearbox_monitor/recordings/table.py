# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A file of columns as a Table: text, MATLAB, JSON, HDF5, NumPy, Parquet, Feather.

The first bytes of a file say its kind. Text is read in blocks; all other kinds are read at once,
in a child with limits of time and memory. All may be gzipped.
"""
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
import contextlib
from dataclasses import dataclass, field, replace
import json
from pathlib import Path
import re
import subprocess
import sys
import tempfile
from typing import Any

import numpy as np

from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import BoundedGzip, open_unpacked
from gearbox_monitor.kernels.types import AnyArray, Integers
from gearbox_monitor.recordings import container_child
from gearbox_monitor.recordings.meaning import (
    EFFORT, number_with_unit, POSITION, scaled_unit, TIME, unit_of_label, VELOCITY, vocabulary)
from gearbox_monitor.recordings.text import (
    BLOCK, DATE, layout_of, MIN_SAMPLES, number_of, numbers_of_list, readable, RowBlock,
    TextLayout, TextRows)

HDF5, MATLAB_HEADER = b'\x89HDF\r\n\x1a\n', 512  # bytes before the HDF5 content of MATLAB 7.3
KINDS = ((b'MATLAB', 'mat'), (HDF5, 'hdf5'), (b'PAR1', 'parquet'), (b'ARROW1', 'feather'),
         (b'FEA1', 'feather'), (b'\x93NUMPY', 'numpy'), (b'PK\x03\x04', 'numpy'),
         (b'{', 'json'), (b'[', 'json'))
# First bytes of files that are not read, what the file is, and what to save instead.
REFUSED = tuple((re.compile(mark), what, instead) for mark, what, instead in (
    (rb'\x80[\x02-\x05]|PK(?s:.*)/data\.pkl', 'a Python pickle, which can run any program when it '
     'is loaded', 'data: save it as .npz, .csv or .parquet'),
    (rb'PK(?s:.*)\[Content_Types\]\.xml', 'an Excel workbook', 'its sheet saved as CSV'),
    (rb'\xff\xfe|\xfe\xff', 'text in UTF-16', 'UTF-8: convert it (iconv -f utf-16)'),
    (rb'(?:\xef\xbb\xbf)?\s*<', 'XML, as KUKA RSI writes it', 'a table: export its values as CSV'),
    (rb'(?sm).*^\w+:.*\n---\r?\n\w+:', "documents of 'ros2 topic echo'",
     "a bag, or what 'ros2 topic echo --csv' writes"),
    (rb'(?s)(?:.*?\n)?([A-Za-z_]\w*) ?[:={](?:.*?\n\1 ?[:={]){3}', 'a name beside each value',
     'a table: a column for each name')))
CPU_SECONDS, MEMORY = 20, 1 << 30  # of the child
LEAST_FILLED = 0.01  # share of the cells of a column that holds numbers
MOST_KEYS = 64       # words that tell rows apart, as names of joints do
NUMBERED = frozenset(
    'id joint motor servo axis device actuator node can name channel topic'.split())
NO_JOINT = frozenset('temp temperature status mode error fault'.split())
TURNS, EVEN = 0.3, 0.5  # share of rows behind which another's follows; rows of the rarest
JOINT_LIST = 'joint_list.txt'  # beside a recording
CLOCK = re.compile(r'\d:\d\d:\d\d')
VECTOR = re.compile(r'[ .]\d+$')  # ends names of the columns of a matrix


@dataclass(frozen=True)
class Column:
    """
    A column of a table.

    values: all, or of a text that is read in blocks those of its first rows. unit: standard name,
    '' = not stated; factor: of the number in front of it. clock: column of its own time, '' for
    the common one.
    """

    name: str
    values: AnyArray
    unit: str = ''
    factor: float = 1.0
    clock: str = ''


@dataclass(frozen=True)
class Table:
    """
    Columns of a file, of one length.

    named: the file names them; joints: names of joints that it lists; rate: Hz, as a file beside
    it states; header: numbers by name. rows: reads a text again, in blocks; streamed: its columns
    hold the first rows only.
    """

    path: Path
    columns: tuple[Column, ...]
    named: bool = True
    joints: tuple[str, ...] = ()
    rate: float | None = None
    header: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    rows: TextRows | None = None
    streamed: bool = False

    def find(self, place: int | str, key: str) -> Column:
        """
        Return the column that a mapping calls `place`, a name or a number from 1.

        Raises InputError with the `key` of the mapping: there is none, or several.
        """
        if isinstance(place, int):
            found = list(self.columns[place - 1:place])
        else:
            found = [c for c in self.columns if c.name == place] or [
                c for c in self.columns if place in c.name.split()
                or plain(c.name) == plain(place)]
        if len(found) == 1:
            return found[0]
        raise InputError(f'{self.path}: column {place!r} ({key}): '
                         f'{"occurs several times" if found else "missing"}, expected one of '
                         + (', '.join(column.name for column in self.columns)[:500] or 'none'))

    def blocks(self, numbers: Collection[str], texts: Collection[str] = ()
               ) -> Iterator[RowBlock]:
        """Yield rows of the columns `numbers` and, as they are written, `texts`, in blocks."""
        if self.rows is not None:
            yield from self.rows(numbers, texts)
            return
        values = {c.name: c.values for c in self.columns if c.name in (*numbers, *texts)}
        yield RowBlock(values, np.arange(1, max(map(len, values.values()), default=0) + 1), 'row')


def printable(name: str) -> str:
    """Return a `name` with nothing that a terminal obeys or no text can hold."""
    return re.sub(r'[\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]',
                  '?', name)


def plain(name: str) -> str:
    """Return a dotted `name` however it is written: 'run/q' is 'run.q'."""
    return name.strip('/').replace('/', '.')


def is_log_of_xml(path: str | Path) -> bool:
    """Return whether a file is the log of a robot sensor interface, not a robot's description."""
    try:
        with open_unpacked(Path(path)) as stream:
            return bool(re.search(rb'<(Rob|Sen)\s', stream.read(4096)))
    except OSError:
        return False


def kind_of(path: Path) -> str:
    """Return the kind of a file by its first bytes. Raises InputError for those of REFUSED."""
    with readable(path), open_unpacked(path) as stream:
        head = stream.read(4096)
    for mark, what, instead in REFUSED:
        if mark.match(head):
            raise InputError(f'{path}: {what}, expected {instead}')
    if head.startswith(b'MATLAB') and head[MATLAB_HEADER:MATLAB_HEADER + 8] == HDF5:
        return 'hdf5'
    start = head.removeprefix(b'\xef\xbb\xbf').lstrip()
    return next((kind for mark, kind in KINDS if head.startswith(mark) or start.startswith(mark)
                 and len(mark) == 1), 'text')


def load_table(path: Path, whole: bool = False) -> Table:
    """
    Return the Table of a file.

    Args:
        path: of the file.
        whole: read all rows of a text, too.

    Raises:
        InputError: it cannot be read, or holds no columns of numbers.
    """
    kind = kind_of(path)
    with readable(path):
        if kind == 'text':
            layout = layout_of(path)
            table = _text_table(path, layout, whole)
            if table.streamed and any(_is_key(column, table) for column in table.columns):
                table = _text_table(path, layout, True)
        else:
            table = _with_siblings(_in_child(path, kind))
    table = _long_pivoted(replace(table, columns=tuple(
        replace(c, name=printable(c.name), clock=printable(c.clock)) for c in table.columns)))
    clocks = {column.clock for column in table.columns} - {''}
    lengths = Counter(len(column.values) for column in table.columns)
    length = max(lengths, key=lambda n: (lengths[n] > 1, n >= MIN_SAMPLES, lengths[n]), default=0)
    columns = tuple(column for column in table.columns if len(column.values) == length
                    or column.clock or column.name in clocks)
    kept = {column.name for column in columns}
    left = Counter((VECTOR.sub('', column.name), len(column.values))
                   for column in table.columns if column.name not in kept)
    if len(columns) < 1 or length < MIN_SAMPLES:
        raise InputError(f'{path}: {len(columns)} columns of {length} numbers, read as {kind}: '
                         f'expected two or more of at least {MIN_SAMPLES}')
    names = Counter(column.name for column in columns)
    return replace(table, columns=tuple(
        column for column in columns if names[column.name] == 1 or not column.name), notes=(
            *table.notes,
            *(f'{name}: {rows} rows{f" of {n} columns" * (n > 1)}, expected {length}: not used'
              for (name, rows), n in left.items()),
            *(f'column {name}: occurs {n} times, not used' for name, n in names.items()
              if n > 1 and name)))


# --- text ---------------------------------------------------------------------------------------
def _text_table(path: Path, layout: TextLayout, whole: bool) -> Table:
    """Return the Table of a text; columns of lists become a column for each place."""
    names, units = [printable(name) or str(k + 1)
                    for k, name in enumerate(layout.names)], layout.units
    whole_cells = {str(k): (k, None) for k in range(len(names))}
    head = next(TextRows(path, layout, whole_cells)((), whole_cells), None)
    if head is None:
        raise InputError(f'{path}: no rows of data, expected a recording')
    cells = {k: head.values[str(k)] for k in range(len(names))}
    places: dict[str, tuple[int, int | None]] = {}  # name: column, place in its list
    texts: set[str] = set()
    columns: list[Column] = []
    notes: list[str] = []
    listed = {k: numbers_of_list(cells[k][0]) for k in cells}
    for k, own in listed.items():
        factor, unit = scaled_unit(units[k]) if units[k] else unit_of_label(names[k])
        if own is not None:
            for place in range(len(own)):
                places[f'{names[k]}.{place + 1}'] = k, place
                columns.append(Column(f'{names[k]}.{place + 1}', np.empty(0), unit, factor))
            continue
        kind = _kind_of_cells(cells[k], layout)
        if kind == 'texts':
            texts.add(names[k])
        elif not kind:
            notes += [f'{names[k]}: {cells[k][0]!r}, expected a time in numbers or as '
                      '2026-03-01T12:00:00.001'] * bool(CLOCK.search(str(cells[k][0])))
            continue
        places[names[k]] = k, None
        clock = layout.clocks.get(k)
        columns.append(Column(names[k], np.empty(0), unit, factor,
                              '' if clock is None else names[clock]))
    rows = TextRows(path, layout, places)
    wanted = [c.name for c in columns if c.name not in texts]
    looked = list(rows(wanted, texts)) if whole else [next(rows(wanted, texts))]
    columns = [replace(column, values=np.concatenate([b.values[column.name] for b in looked]))
               for column in columns]
    streamed = not whole and (path.stat().st_size >= BLOCK or _is_packed(path))
    return Table(path, tuple(columns), any(layout.names), _listed_joints(path), None,
                 _text_header(path, layout), tuple(notes), rows, streamed)


def _is_packed(path: Path) -> bool:
    with open_unpacked(path) as stream:
        return isinstance(stream, BoundedGzip)


def _kind_of_cells(cells: AnyArray, layout: TextLayout) -> str:
    """Return 'numbers', 'texts' (dates, or words that come back) or '' of a column of texts."""
    if DATE.match(str(cells[0])):
        return 'texts'
    sample = cells[:20_000].tolist()
    filled = [cell for cell in sample if cell]
    words = set(sample)
    if 1 < len(words) <= MOST_KEYS and all(words) and not any(
            number_of(word, layout.text) is not None for word in words):
        return 'texts'
    numbers = sum(number_of(cell, layout.text) is not None or bool(number_with_unit(cell))
                  for cell in filled)
    # Where another curve has its samples a cell is empty, which says nothing against this one.
    return 'numbers' if numbers > 0.5 * len(filled) and numbers >= LEAST_FILLED * len(
        sample) and numbers else ''


def _text_header(path: Path, layout: TextLayout) -> dict[str, float]:
    """Return the numbers 'NAME = VALUE' above the data and in the first comments."""
    header: dict[str, float] = {}
    with open_unpacked(path) as stream:
        for number, raw in enumerate(iter(lambda: stream.readline(10_000), b''), 1):
            line = raw.decode(layout.text.encoding, 'replace').strip()
            if number >= layout.first and not line.startswith(layout.text.comment):
                break
            match = re.match(r'\W*(\w[\w. ]*?)\W*?[=:,;\t ]\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\b',
                             line)
            if match:
                with contextlib.suppress(ValueError):
                    header.setdefault(match[1].strip(), float(match[2]))
    return header


# --- all other kinds ----------------------------------------------------------------------------
def _in_child(path: Path, kind: str) -> Table:
    """Return the Table of a file that is read in a child with limits. Raises InputError."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / 'columns.npz'
        done = subprocess.run(
            [sys.executable, '-I', container_child.__file__, str(path), kind, str(out),
             str(CPU_SECONDS), str(MEMORY)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, check=False)
        if done.returncode == container_child.FAILED:
            raise InputError(f'{path}: ' + done.stderr.decode('utf-8', 'replace').strip())
        if done.returncode:
            why = 'its library crashes while it reads it' if done.returncode == -11 else \
                f'takes more than {CPU_SECONDS} s or {MEMORY >> 30} GB of memory to read'
            raise InputError(f'{path}: {why}, expected a smaller, sound recording')
        with np.load(out) as archive:
            index: dict[str, Any] = json.loads(archive['index'].tobytes())
            values = [archive[f'c{k}'] for k in range(len(index['columns']))]
    columns = []
    for (name, unit), array in zip(index['columns'], values):
        factor, stated = scaled_unit(unit) if unit else (1.0, '')
        if not stated:
            factor, stated = unit_of_label(re.sub(r' \d+$', '', name))
        columns.append(Column(name, array, stated, factor))
    if kind == 'numpy' and all(not re.sub(r'\d', '', c.name) for c in columns):
        return Table(path, tuple(columns), False, header=index['header'])
    return Table(path, tuple(columns), any(c.name for c in columns), tuple(index['joints']),
                 None, index['header'], tuple(index['notes']))


def _listed_joints(path: Path) -> tuple[str, ...]:
    """Return the names in JOINT_LIST beside the file, one in a line."""
    try:
        text = path.with_name(JOINT_LIST).read_text(encoding='utf-8')
    except (OSError, ValueError):
        return ()
    return tuple(line.strip() for line in text.splitlines() if line.strip())


def _with_siblings(table: Table) -> Table:
    """Return `table` with joints and rate of a dataset, by 'meta/info.json' above its file."""
    for folder in list(table.path.absolute().parents)[:4]:
        try:
            content = json.loads((folder / 'meta' / 'info.json').read_text(encoding='utf-8'))
            names = content['features']['observation.state']['names']
            names = names.get('motors', []) if isinstance(names, dict) else names
            return replace(table, rate=float(content['fps']), joints=tuple(
                str(name).removesuffix('.pos') for name in names or ()))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
    return table


# --- a row for each joint -----------------------------------------------------------------------
def _long_pivoted(table: Table) -> Table:
    """
    Return a table with a row for each joint, or for each signal, with a column for each.

    A column says whose row it is: they take turns, or the time restarts with each block of rows.
    """
    key = next((c for c in table.columns if _is_key(c, table)), None)
    if key is None:
        return table
    time_words, *signals = (vocabulary()['quantities'][q] for q in (
        TIME, POSITION, VELOCITY, EFFORT))
    words, place = np.unique(key.values, return_inverse=True)
    order = np.argsort([int(np.flatnonzero(place == k)[0]) for k in range(len(words))])
    values = [c for c in table.columns if _has_dates(c) or c is not key
              and c.values.dtype.kind in 'iuf' and np.isfinite(c.values).any()]
    times = [c for c in values if _has_dates(c) or _names(c) & time_words]
    if not times:
        return table
    single = [c for c in values if all(c is not time for time in times)]
    alone = len(single) == 1 and not any(_names(single[0]) & named for named in signals)
    columns, names = list[Column](), list[str]()
    for k in order:
        rows = np.flatnonzero(place == k)
        names.append(str(words[k]) if words.dtype.kind == 'U' else f'joint_{int(words[k])}')
        for c in values:
            is_time = any(c is time for time in times)
            columns.append(Column(names[-1] if alone and not is_time else f'{c.name} {names[-1]}',
                                  c.values[rows], c.unit, c.factor,
                                  '' if is_time else f'{times[0].name} {names[-1]}'))
    return replace(table, rows=None, streamed=False, columns=tuple(columns), joints=(
        table.joints if alone else tuple(names)), notes=(
            *table.notes, f'a row for each {key.name}: {", ".join(map(str, words[order]))[:200]}'))


def _has_dates(column: Column) -> bool:
    kind = column.values.dtype.kind
    return kind == 'M' or kind == 'U' and bool(DATE.match(str(column.values[0])))


def _names(column: Column) -> set[str]:
    return {word.lower() for word in re.findall(r'[A-Za-z]+', column.name)}


def _is_key(column: Column, table: Table) -> bool:
    """Return whether a column tells the rows of joints or signals apart."""
    values = column.values
    is_named = bool(_names(column) & NUMBERED) and not _names(column) & (
        NO_JOINT | vocabulary()['quantities'][TIME])
    if values.dtype.kind == 'U':
        if _has_dates(column):
            return False
    elif not is_named or values.dtype.kind not in 'iuf' or (
            column.unit or not np.isfinite(values).all() or (values != np.floor(values)).any()):
        return False
    words, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    if not 1 < len(words) <= MOST_KEYS:
        return False
    turns: Integers = np.diff(place) != 0
    if table.streamed and is_named and values.dtype.kind == 'U' and turns.sum() < len(
            words):  # blocks of which the head shows some
        return True
    if counts.min() < EVEN * counts.max():
        return False
    times = [c.values for c in table.columns if _has_dates(c) or c.values.dtype.kind in 'iuf'
             and _names(c) & vocabulary()['quantities'][TIME]]
    blocks = turns.sum() == len(words) - 1 and is_named and any(
        np.array_equal(time[1:] < time[:-1], turns) for time in times)
    return bool(turns.mean() > TURNS or blocks)
