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
What a fleet run leaves in its folder, written whole or not at all.

``features/gearbox=.../date=.../*.parquet``: a row per window, one file per bag; ``bags.parquet``:
a row per bag. While a run goes on its rows are lines of ``bags.journal``; the next run takes over
what a killed one has left there.
"""
from collections import Counter
from dataclasses import fields
import fcntl
import json
import os
from pathlib import Path
import shutil
import time
from urllib.parse import quote

import pyarrow as pa
from pyarrow import parquet

from gearbox_monitor.errors import InputError
from gearbox_monitor.monitoring.backlash.features import Backlash, NotExcited

FEATURES, BAGS, JOURNAL, PAGE = 'features', 'bags.parquet', 'bags.journal', 'fleet.html'
LOCK, PARTS = '.lock', '.parts'
STAMP = pa.timestamp('us', 'UTC')  # of ns, Python makes dates with pandas only
NUMBER, COUNT, TEXT, FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()
# Columns of bags.parquet; see docs/fleet.md.
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
_KINDS = {float: NUMBER, bool: FLAG, int: COUNT,
          tuple[float, ...]: pa.list_(NUMBER)}
WINDOW_COLUMNS = {
    'stamp': STAMP, 'excited': FLAG, 'not_excited': TEXT,
    **{f.name: _KINDS[f.type] for f in fields(Backlash)},
    'path': TEXT, 'content': TEXT, 'settings': TEXT}


class FleetTable:
    """
    The rows of a folder, one per path; ``with FleetTable(folder)`` locks and unlocks it.

    Raises InputError for a folder of something else, one that another run writes to, and where
    nothing can be written.
    """

    def __init__(self, folder):
        self.folder = Path(folder).absolute()
        self.rows, self._used, self._by_content, self._sizes = {}, Counter(), {}, Counter()

    def __enter__(self):
        try:
            self._open()
        except OSError as error:
            raise InputError(f'{error.filename or self.folder}: {error.strerror}, expected a new '
                             'or writable folder') from None
        return self

    def __exit__(self, *_):
        try:
            self._journal.close()
        except OSError:  # the disk is full, and was said to be
            pass
        shutil.rmtree(self.folder / PARTS, ignore_errors=True)
        self._lock.close()

    def _open(self):
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
        shutil.rmtree(self.folder / PARTS, ignore_errors=True)  # what a killed run has left
        (self.folder / PARTS).mkdir()
        for row in self._kept():
            self._take(row)
        self._journal = open(self.folder / JOURNAL, 'a', encoding='utf-8')
        self._journal_begins = True

    def _kept(self):
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

    def _take(self, row):
        row = {name: row.get(name) for name in COLUMNS}
        before = self.rows.get(row['path'])
        self.rows[row['path']] = row
        self._used[row['features']] += 1
        self._sizes[row['settings'], row['bytes']] += 1
        if before is not None:
            self._used[before['features']] -= 1
            self._sizes[before['settings'], before['bytes']] -= 1
        if row['status'] in ('done', 'failed') and row['content']:
            self._by_content[row['content'], row['settings']] = row['path']
        return before

    # ------------------------------------------------------------------ what is known

    def finished(self, bag, key):
        """Return whether nothing is left to do for a paths.FleetBag under the settings `key`."""
        row = self.rows.get(bag.url)
        if row is None or row['settings'] != key or row['fingerprint'] != bag.fingerprint:
            return False
        if row['status'] == 'duplicate':
            other = self.of_content(row['content'], key)
            return other is not None and other['path'] != bag.url
        return self._stands(row)

    def of_content(self, content, key):
        """Return the row of the bag of this `content` that needs no other run, or None."""
        row = self.rows.get(self._by_content.get((content, key)))
        same = row is not None and (row['content'], row['settings']) == (content, key)
        return row if same and self._stands(row) else None

    def _stands(self, row):
        if row['status'] == 'done':
            return (self.folder / row['features']).is_file()
        return row['status'] == 'failed' and not row['retry']

    def has_size(self, size, key):
        """Return whether a bag of `size` bytes was analysed under the settings `key`."""
        return self._sizes[key, size] > 0

    # ------------------------------------------------------------------ writing

    def put(self, row, windows=None):
        """
        Write the row of a bag and, where it has any, its `windows` (list of fits of features).

        row: {column: plain value}, path and settings at least. Raises InputError.
        """
        row = {**row, 'analysed': time.time_ns()}
        try:
            if windows is not None:
                row['features'] = self._write_windows(row, windows)
            # On a line of its own, also behind one that was cut.
            text = ('\n' if self._journal_begins else '') + json.dumps(row) + '\n'
            self._journal.write(text)
            self._journal.flush()
            self._journal_begins = False
            before = self._take(row)
            if before is not None and before['features'] and not self._used[before['features']]:
                (self.folder / before['features']).unlink(missing_ok=True)
        except OSError as error:
            raise self._unwritable(error) from None

    def _write_windows(self, row, windows):
        name = Path(FEATURES, f'gearbox={quote(row["gearbox"], safe="")}', f'date={row["date"]}',
                    f'{row["content"][:32]}.parquet')
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        self._write(name, lambda part: parquet.write_table(
            window_table(windows, row), part, compression='zstd'))
        return str(name)

    def _write(self, name, write):
        """Let write(path) make the file `name`, whole or not at all."""
        part = self.folder / PARTS / Path(name).name
        try:
            write(part)
            with open(part, 'rb') as file:
                os.fsync(file.fileno())
            os.replace(part, self.folder / name)
        finally:
            part.unlink(missing_ok=True)

    def _unwritable(self, error):
        return InputError(f'{self.folder}: cannot write: {error.strerror or error}; what is done '
                          'is kept, the same command goes on from there')

    def write_page(self, html):
        """Write the fleet page; return its Path. Raises InputError."""
        try:
            self._write(PAGE, lambda part: part.write_text(html, encoding='utf-8'))
        except OSError as error:
            raise self._unwritable(error) from None
        return self.folder / PAGE

    def finish(self):
        """Write the table of bags anew and end the journal. Raises InputError."""
        rows = sorted(self.rows.values(), key=lambda row: row['path'])
        table = _table(COLUMNS, lambda name: [row[name] for row in rows])
        try:
            self._write(BAGS, lambda part: parquet.write_table(table, part, compression='zstd'))
            (self.folder / JOURNAL).unlink()
        except OSError as error:
            raise self._unwritable(error) from None


def window_table(windows, row):
    """Return the windows of a bag with the `row` as a pyarrow Table of WINDOW_COLUMNS."""
    known = {'path': row['path'], 'content': row['content'], 'settings': row['settings']}

    def value(window, name):
        if name in known:
            return known[name]
        if name == 'stamp':
            return window.stamp_ns
        if name == 'excited':
            return isinstance(window, Backlash)
        if name == 'not_excited':
            return window.reason if isinstance(window, NotExcited) else None
        found = getattr(window, name, None)
        return None if isinstance(found, float) and found != found else found
    return _table(WINDOW_COLUMNS, lambda name: [value(w, name) for w in windows])


def _table(columns, values):
    """Return the Table of values(name), plain data, stamps in ns; columns {name: type}."""
    return pa.table({name: (
        pa.array(values(name), COUNT).cast(pa.timestamp('ns', 'UTC')).cast(STAMP, safe=False)
        if kind == STAMP else pa.array(values(name), kind)) for name, kind in columns.items()})
