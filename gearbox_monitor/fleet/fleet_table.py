# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The tables of a fleet run in its folder; every file is written completely or not at all.

``features/gearbox=.../date=.../*.parquet``: a row per window, one file per bag; ``bags.parquet``:
a row per bag. During a run its rows are lines of ``bags.journal``; the next run reads the journal
that a killed one has left.
"""
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
import fcntl
import json
import os
from pathlib import Path
import shutil
import time
from types import TracebackType
from typing import Any, IO
from urllib.parse import quote

import pyarrow as pa
from pyarrow import parquet

from gearbox_monitor.errors import InputError
from gearbox_monitor.fleet.job import Row, Window
from gearbox_monitor.fleet.paths import FleetBag
from gearbox_monitor.monitoring.backlash.features import Backlash, NotExcited

FEATURES, BAGS, JOURNAL, PAGE = 'features', 'bags.parquet', 'bags.journal', 'fleet.html'
LOCK, PARTS = '.lock', '.parts'
STAMP = pa.timestamp('us', 'UTC')  # of ns, Python makes dates with pandas only
NUMBER, COUNT, TEXT, FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()
# Columns of bags.parquet.
COLUMNS = {
    'path': TEXT, 'status': TEXT, 'reason': TEXT, 'retry': FLAG, 'duplicate_of': TEXT,
    'gearbox': TEXT, 'date': TEXT, 'start': STAMP, 'duration_s': NUMBER, 'samples': COUNT,
    'filter': TEXT, 'unit': TEXT, 'windows': COUNT, 'windows_used': COUNT, 'not_excited': TEXT,
    'separable': FLAG, 'gap': NUMBER, 'gap_std': NUMBER, 'lost_motion': NUMBER,
    'lost_motion_std': NUMBER, 'stiffness': NUMBER, 'stiffness_std': NUMBER,
    'hysteresis': NUMBER, 'hysteresis_std': NUMBER, 'gap_error': NUMBER, 'trust': TEXT,
    'model_level': TEXT, 'diagnosis': TEXT, 'diagnosis_effect': TEXT, 'diagnosis_place': TEXT,
    'diagnosis_confusable': TEXT, 'diagnosis_gap': NUMBER, 'diagnosis_closed': NUMBER,
    'diagnosis_reason': TEXT, 'notes': TEXT, 'features': TEXT, 'content': TEXT, 'bytes': COUNT,
    'fingerprint': TEXT, 'settings': TEXT, 'version': TEXT, 'kernels': TEXT, 'attempts': COUNT,
    'cpu_s': NUMBER, 'analysed': STAMP,
}
_KINDS: dict[Any, Any] = {float: NUMBER, bool: FLAG, int: COUNT,
                          tuple[float, ...]: pa.list_(NUMBER)}
WINDOW_COLUMNS = {
    'stamp': STAMP, 'excited': FLAG, 'not_excited': TEXT,
    **{f.name: _KINDS[f.type] for f in fields(Backlash)},
    'path': TEXT, 'content': TEXT, 'settings': TEXT}


class FleetTable:
    """
    The rows of a folder, one per path; ``with FleetTable(folder)`` locks and unlocks it.

    Raises InputError if `folder` holds other files, if another run writes to it, or if it is not
    writable.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder).absolute()
        self.rows: dict[str, Row] = {}  # by path
        self._used: Counter[str | None] = Counter()  # of the files of features
        self._by_content: dict[tuple[str, str], str] = {}  # (content, settings): path
        self._sizes: Counter[tuple[str, int | None]] = Counter()  # (settings, bytes)

    def __enter__(self) -> 'FleetTable':
        try:
            self._open()
        except OSError as error:
            raise InputError(f'{error.filename or self.folder}: {error.strerror}, expected a new '
                             'or writable folder') from None
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        with suppress(OSError):  # the disk is full, as was reported
            self._journal.close()
        shutil.rmtree(self.folder / PARTS, ignore_errors=True)
        self._lock.close()

    def _open(self) -> None:
        if self.folder.is_dir() and any(self.folder.iterdir()) and not any(
                (self.folder / name).exists() for name in (BAGS, JOURNAL, LOCK)):
            raise InputError(f'{self.folder}: holds other files, expected a new folder or one of '
                             'an earlier fleet run')
        (self.folder / FEATURES).mkdir(parents=True, exist_ok=True)
        self._lock = open(self.folder / LOCK, 'w')
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f'{self.folder}: another fleet run writes to it, expected one at a '
                             'time') from None
        shutil.rmtree(self.folder / PARTS, ignore_errors=True)  # of a killed run
        (self.folder / PARTS).mkdir()
        for row in self._earlier_rows():
            self._take(row)
        self._journal: IO[str] = open(self.folder / JOURNAL, 'a', encoding='utf-8')
        self._journal_begins = True

    def _earlier_rows(self) -> Iterator[Row]:
        """Yield the rows of earlier runs."""
        path = self.folder / BAGS
        if path.exists():
            try:
                table = parquet.read_table(path)
                for place, name in enumerate(table.column_names):
                    if COLUMNS.get(name) == STAMP:
                        stamps = table[name].cast(pa.timestamp('ns', 'UTC')).cast(COUNT)
                        table = table.set_column(place, name, stamps)
                yield from table.to_pylist()
            except pa.ArrowException as error:
                raise InputError(f'{path}: {" ".join(str(error).split())}, expected a table '
                                 'written by fleet') from None
        path = self.folder / JOURNAL
        for line in path.read_bytes().splitlines() if path.exists() else ():
            try:
                yield json.loads(line)
            except ValueError:  # cut where that run ended
                continue

    def _take(self, row: Row) -> Row | None:
        """Store `row`; return the one that it replaces."""
        row = {name: row.get(name) for name in COLUMNS}
        replaced = self.rows.get(row['path'])
        self.rows[row['path']] = row
        self._used[row['features']] += 1
        self._sizes[row['settings'], row['bytes']] += 1
        if replaced is not None:
            self._used[replaced['features']] -= 1
            self._sizes[replaced['settings'], replaced['bytes']] -= 1
        if row['status'] in ('done', 'failed') and row['content']:
            self._by_content[row['content'], row['settings']] = row['path']
        return replaced

    # ------------------------------------------------------------------ queries

    def finished(self, bag: FleetBag, key: str) -> bool:
        """Return whether `bag` need not be analysed under the settings `key`."""
        row = self.rows.get(bag.url)
        if row is None or row['settings'] != key or row['fingerprint'] != bag.fingerprint:
            return False
        if row['status'] == 'duplicate':
            original = self.of_content(row['content'], key)
            return original is not None and original['path'] != bag.url
        return self._is_final(row)

    def of_content(self, content: str, key: str) -> Row | None:
        """Return the final row of the bag of this `content` under the settings `key`, or None."""
        row = self.rows.get(self._by_content.get((content, key), ''))
        if row is None or (row['content'], row['settings']) != (content, key):
            return None
        return row if self._is_final(row) else None

    def _is_final(self, row: Row) -> bool:
        if row['status'] == 'done':
            return (self.folder / row['features']).is_file()
        return bool(row['status'] == 'failed' and not row['retry'])

    def has_size(self, size: int, key: str) -> bool:
        """Return whether a bag of `size` bytes was analysed under the settings `key`."""
        return self._sizes[key, size] > 0

    # ------------------------------------------------------------------ writing

    def put(self, row: Row, windows: Sequence[Window] | None = None) -> None:
        """
        Write the `row` of a bag, with path and settings at least, and its `windows`, if any.

        Raises InputError if the folder is not writable.
        """
        row = {**row, 'analysed': time.time_ns()}
        try:
            if windows is not None:
                row['features'] = self._write_windows(row, windows)
            # On a line of its own, even if the last one was cut.
            text = ('\n' if self._journal_begins else '') + json.dumps(row) + '\n'
            self._journal.write(text)
            self._journal.flush()
            self._journal_begins = False
            replaced = self._take(row)
            features = replaced['features'] if replaced is not None else None
            if features and not self._used[features]:
                (self.folder / features).unlink(missing_ok=True)
        except OSError as error:
            raise self._unwritable(error) from None

    def _write_windows(self, row: Row, windows: Sequence[Window]) -> str:
        name = Path(FEATURES, f'gearbox={quote(row["gearbox"], safe="")}', f'date={row["date"]}',
                    f'{row["content"][:32]}.parquet')
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        self._write(name, lambda part: parquet.write_table(
            window_table(windows, row), part, compression='zstd'))
        return str(name)

    def _write(self, name: str | Path, write: Callable[[Path], object]) -> None:
        """Let write(path) make the file `name`, completely or not at all."""
        part = self.folder / PARTS / Path(name).name
        try:
            write(part)
            with open(part, 'rb') as file:
                os.fsync(file.fileno())
            os.replace(part, self.folder / name)
        finally:
            part.unlink(missing_ok=True)

    def _unwritable(self, error: OSError) -> InputError:
        return InputError(f'{self.folder}: cannot write: {error.strerror or error}; what is done '
                          'is kept, run the same command again to continue')

    def write_page(self, html: str) -> Path:
        """Write the fleet page `html`; return its path. Raises InputError."""
        try:
            self._write(PAGE, lambda part: part.write_text(html, encoding='utf-8'))
        except OSError as error:
            raise self._unwritable(error) from None
        return self.folder / PAGE

    def finish(self) -> None:
        """Write the table of bags and delete the journal. Raises InputError."""
        rows = sorted(self.rows.values(), key=lambda row: row['path'])
        table = _table(COLUMNS, lambda name: [row[name] for row in rows])
        try:
            self._write(BAGS, lambda part: parquet.write_table(table, part, compression='zstd'))
            (self.folder / JOURNAL).unlink()
        except OSError as error:
            raise self._unwritable(error) from None


def window_table(windows: Sequence[Window], row: Row) -> pa.Table:
    """Return the `windows` of a bag with the `row` as a pyarrow Table of WINDOW_COLUMNS."""
    def value(window: Window, name: str) -> Any:
        if name in ('path', 'content', 'settings'):
            return row[name]
        if name == 'stamp':
            return window.stamp_ns
        if name == 'excited':
            return isinstance(window, Backlash)
        if name == 'not_excited':
            return window.reason if isinstance(window, NotExcited) else None
        figure = getattr(window, name, None)
        return None if isinstance(figure, float) and figure != figure else figure
    return _table(WINDOW_COLUMNS, lambda name: [value(w, name) for w in windows])


def _table(columns: Mapping[str, Any], values: Callable[[str], list[Any]]) -> pa.Table:
    """Return the Table of values(name), plain data, stamps in ns; columns {name: type}."""
    return pa.table({name: (
        pa.array(values(name), COUNT).cast(pa.timestamp('ns', 'UTC')).cast(STAMP, safe=False)
        if kind == STAMP else pa.array(values(name), kind)) for name, kind in columns.items()})
