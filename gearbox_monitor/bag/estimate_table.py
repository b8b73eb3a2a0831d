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

"""Write the estimates of a replay as a table: CSV, or Parquet with pyarrow."""
import json
import os
from pathlib import Path

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_STD, S_TWIST
from gearbox_monitor.kernels.jit import KERNELS

COLUMNS = ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_k_std', 'innovation_motor', 'innovation_arm',
           'nis')
SMOOTHED_COLUMNS = {'tau_k_smoothed': S_TAU_K, 'tau_k_smoothed_std': S_TAU_K_STD,
                    'twist_smoothed': S_TWIST}
ROW_GROUP = 1 << 17  # rows of a Parquet file that are packed together


class EstimateTable:
    """
    Takes the parts of a replay.Player and writes a row per estimate: stamp_ns, COLUMNS.

    The file gets its name when all of it is written. smoothed: with SMOOTHED_COLUMNS; then `write`
    takes everything at once. Raises InputError where `path` cannot be written.
    """

    topics = ()

    def __init__(self, path, player, smoothed=False):
        self._path, self._part = Path(path), Path(f'{path}.part')
        self._names = (*COLUMNS, *(SMOOTHED_COLUMNS if smoothed else ()))
        self._guarded(self._open, player)

    def add(self, part):
        """Take a ReplayPart."""
        self.write(part.estimates)

    def write(self, estimates, whole=None):
        """Write Estimates [M]; whole [M, N_SMOOTHED]: smoothed over the recording."""
        columns = [getattr(estimates, name) for name in COLUMNS]
        if whole is not None:
            columns += [whole[:, column] for column in SMOOTHED_COLUMNS.values()]
        self._guarded(self._write, estimates.stamp_ns, columns)

    def finish(self):
        """Take note that all parts have come."""

    def close(self):
        """Complete the file."""
        self._guarded(self._close)
        self._guarded(os.replace, self._part, self._path)

    def abandon(self):
        """Leave no file behind."""
        try:
            self._close()
        except (OSError, InputError):
            pass
        self._part.unlink(missing_ok=True)

    def _guarded(self, function, *args):
        try:
            function(*args)
        except OSError as error:
            raise InputError(f'{self._path}: {error.strerror or error}, expected a new, writable '
                             'file') from None


class CsvTable(EstimateTable):
    """Numbers read back bit for bit."""

    def _open(self, player):
        self._file = open(self._part, 'w', encoding='utf-8')
        self._file.write(','.join(('stamp_ns', *self._names)) + '\n')

    def _write(self, stamps, columns):
        rows = zip(stamps.tolist(), *(column.tolist() for column in columns))
        self._file.writelines(f'{stamp},{",".join(map(repr, row))}\n' for stamp, *row in rows)

    def _close(self):
        self._file.close()


class ParquetTable(EstimateTable):
    """float64 columns and, as metadata of the file, what they were made with."""

    def _open(self, player):
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError:
            raise InputError(f'{self._path}: pyarrow is missing, expected "pip install pyarrow", '
                             'or a .csv file') from None
        self._arrow, self._rows = pyarrow, 0
        self._stamps = np.empty(ROW_GROUP, np.int64)
        self._columns = np.empty((len(self._names), ROW_GROUP))
        estimator = player.estimator
        about = {'version': __version__, 'kernels': KERNELS,
                 'replayed_from': str(player.reader.path),
                 'parameters': json.dumps(estimator.parameters.to_dict()),
                 'model': json.dumps(estimator.model.to_dict())}
        self._schema = pyarrow.schema(
            [('stamp_ns', pyarrow.int64()), *((name, pyarrow.float64()) for name in self._names)],
            metadata={f'gearbox_monitor.{key}': value for key, value in about.items()})
        # Noise does not repeat: a dictionary of values only costs time; but the bytes that hold
        # sign and exponent resemble each other.
        self._writer = parquet.ParquetWriter(
            self._part, self._schema, compression='lz4', use_dictionary=False,
            write_statistics=['stamp_ns'], column_encoding={
                'stamp_ns': 'DELTA_BINARY_PACKED', **dict.fromkeys(
                    self._names, 'BYTE_STREAM_SPLIT')})

    def _write(self, stamps, columns):
        done = 0
        while done < len(stamps):
            here = slice(self._rows, min(self._rows + len(stamps) - done, ROW_GROUP))
            part = slice(done, done + here.stop - here.start)
            self._stamps[here] = stamps[part]
            for kept, column in zip(self._columns, columns):
                kept[here] = column[part]
            self._rows, done = here.stop, part.stop
            if self._rows == ROW_GROUP:
                self._flush()

    def _flush(self):
        table = self._arrow.table([self._stamps[:self._rows], *self._columns[:, :self._rows]],
                                  schema=self._schema)
        self._writer.write_table(table, row_group_size=ROW_GROUP)
        self._rows = 0

    def _close(self):
        if self._rows:
            self._flush()
        self._writer.close()
