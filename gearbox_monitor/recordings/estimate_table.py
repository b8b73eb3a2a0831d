# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Write the estimates of a replay as a table: CSV, or Parquet with pyarrow."""
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
import json
import os
from pathlib import Path
from typing import Any, ParamSpec

import numpy as np

from gearbox_monitor import __version__
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import Estimates
from gearbox_monitor.estimation.rts_smoother import S_TAU_K, S_TAU_K_STD, S_TWIST
from gearbox_monitor.kernels.jit import KERNELS
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.recordings.player import EstimatePlayer, ReplayPart

COLUMNS = ('x1', 'x2', 'x3', 'x4', 'tau_k', 'tau_k_std', 'innovation_motor', 'innovation_arm',
           'nis')
SMOOTHED_COLUMNS = {'tau_k_smoothed': S_TAU_K, 'tau_k_smoothed_std': S_TAU_K_STD,
                    'twist_smoothed': S_TWIST}
# Where the filter learns the curve of the torque.
LEARNED_COLUMNS = ('stiffness', 'stiffness_std', 'half_gap', 'half_gap_std', 'hysteresis',
                   'hysteresis_std')
ROW_GROUP = 1 << 17  # rows of a Parquet file that are packed together
P = ParamSpec('P')


class EstimateTable:
    """
    Takes the parts of a replay and writes a row per estimate: stamp_ns, COLUMNS, LEARNED_COLUMNS.

    The file gets its name when all rows are written. With `smoothed`, it also has SMOOTHED_COLUMNS
    and `write` takes all estimates at once.

    Args:
        path: the new file.
        player: whose estimates are written.
        smoothed: whether to write estimates that are smoothed over the whole recording.

    Raises:
        InputError: the file cannot be written.
    """

    topics = ()

    def __init__(self, path: str | Path, player: EstimatePlayer, smoothed: bool = False) -> None:
        self._path, self._part = Path(path), Path(f'{path}.part')
        learns = bool(player.estimator.learned_curve())
        self._columns_of_row = COLUMNS + (LEARNED_COLUMNS if learns else ())
        self._names = (*self._columns_of_row, *(SMOOTHED_COLUMNS if smoothed else ()))
        self._guarded(self._open, player)

    def add(self, part: ReplayPart) -> None:
        """Take the next `part`."""
        self.write(part.estimates)

    def write(self, estimates: Estimates, rows: Array | None = None) -> None:
        """Write `estimates` [M]; `rows` [M, N_SMOOTHED]: smoothed over the whole recording."""
        columns = [getattr(estimates, name) for name in self._columns_of_row]
        if rows is not None:
            columns += [rows[:, column] for column in SMOOTHED_COLUMNS.values()]
        self._guarded(self._write, estimates.stamp_ns, columns)

    def finish(self) -> None:
        """Do nothing: all parts were added."""

    def close(self) -> None:
        """Complete the file."""
        self._guarded(self._close)
        self._guarded(os.replace, self._part, self._path)

    def abandon(self) -> None:
        """Delete the incomplete file."""
        with suppress(OSError, InputError):
            self._close()
        self._part.unlink(missing_ok=True)

    def _guarded(self, function: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except OSError as error:
            raise InputError(f'{self._path}: {error.strerror or error}, expected a new, writable '
                             'file') from None

    def _open(self, player: EstimatePlayer) -> None:
        raise NotImplementedError

    def _write(self, stamps: Integers, columns: Sequence[Array]) -> None:
        raise NotImplementedError

    def _close(self) -> None:
        raise NotImplementedError


class CsvTable(EstimateTable):
    """
    CSV file; its numbers are read back bit for bit.

    pyarrow, where it is installed, prints them five times as fast: `1` then stands for `1.0`.
    """

    def _open(self, player: EstimatePlayer) -> None:
        try:
            import pyarrow
            from pyarrow import csv
            self._arrow: Any = pyarrow
            self._print = partial(csv.write_csv, write_options=csv.WriteOptions(
                include_header=False, batch_size=1 << 14))
        except ImportError:
            self._arrow = None
        self._file = open(self._part, 'wb')
        self._file.write((','.join(('stamp_ns', *self._names)) + '\n').encode())

    def _write(self, stamps: Integers, columns: Sequence[Array]) -> None:
        if self._arrow:
            names = ('stamp_ns', *self._names)
            self._print(self._arrow.table([stamps, *columns], names=names), self._file)
            return
        rows = zip(stamps.tolist(), *(column.tolist() for column in columns))
        self._file.writelines(f'{stamp},{",".join(map(repr, row))}\n'.encode()
                              for stamp, *row in rows)

    def _close(self) -> None:
        self._file.close()


class ParquetTable(EstimateTable):
    """Parquet file of float64 columns; model, parameters and versions are its metadata."""

    def _open(self, player: EstimatePlayer) -> None:
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError:
            raise InputError(f'{self._path}: pyarrow is missing, expected '
                             f'{installed_by("tables")}, or a .csv file') from None
        self._arrow, self._rows = pyarrow, 0
        self._stamps = np.empty(ROW_GROUP, np.int64)
        self._columns = np.empty((len(self._names), ROW_GROUP))
        estimator = player.estimator
        origin = {'version': __version__, 'kernels': KERNELS,
                  'replayed_from': str(player.reader.path),
                  'parameters': json.dumps(estimator.parameters.to_dict()),
                  'model': json.dumps(estimator.model.to_dict())}
        self._schema = pyarrow.schema(
            [('stamp_ns', pyarrow.int64()), *((name, pyarrow.float64()) for name in self._names)],
            metadata={f'gearbox_monitor.{key}': value for key, value in origin.items()})
        # Noise does not repeat, so a dictionary of values would only cost time; but the bytes of
        # sign and exponent resemble each other.
        self._writer = parquet.ParquetWriter(
            self._part, self._schema, compression='lz4', use_dictionary=False,
            write_statistics=['stamp_ns'], column_encoding={
                'stamp_ns': 'DELTA_BINARY_PACKED', **dict.fromkeys(
                    self._names, 'BYTE_STREAM_SPLIT')})

    def _write(self, stamps: Integers, columns: Sequence[Array]) -> None:
        done = 0
        while done < len(stamps):
            target = slice(self._rows, min(self._rows + len(stamps) - done, ROW_GROUP))
            source = slice(done, done + target.stop - target.start)
            self._stamps[target] = stamps[source]
            for buffer, column in zip(self._columns, columns):
                buffer[target] = column[source]
            self._rows, done = target.stop, source.stop
            if self._rows == ROW_GROUP:
                self._flush()

    def _flush(self) -> None:
        table = self._arrow.table([self._stamps[:self._rows], *self._columns[:, :self._rows]],
                                  schema=self._schema)
        self._writer.write_table(table, row_group_size=ROW_GROUP)
        self._rows = 0

    def _close(self) -> None:
        if self._rows:
            self._flush()
        self._writer.close()
