# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The newest estimates and smoothed rows, which trust reads once per second."""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.process_model import TAU_K
from gearbox_monitor.kernels.types import Array, Integers

# The columns of estimates that are stored, in runs.
RUNS = (range(sample_loop.E_X1, sample_loop.E_TAU_E + 1),
        range(sample_loop.E_STD + TAU_K, sample_loop.E_STD + TAU_K + 1),
        range(sample_loop.E_INNOVATION_MOTOR, sample_loop.E_DT + 1),
        *(range(column, column + 1) for column in (
            sample_loop.E_TAU_K_NOISE_STD, sample_loop.E_MOTOR_SIDE_NOISE_STD)))
PLACE = {column: place for place, column in enumerate(column for run in RUNS for column in run)}
COLUMNS = np.array(list(PLACE))
BLOCK = 512  # rows of room, at least
ROOM = 1.25  # of what is kept: rows move when it is full


class Recent:
    """
    W estimates: stamps int64 [W]; recent[column] [W], column one of PLACE.

    rows: the COLUMNS of each, [W, len(COLUMNS)].
    """

    def __init__(self, stamps: Integers, rows: Array) -> None:
        self.stamps = stamps
        self._columns = np.ascontiguousarray(rows.T)  # checks read a column many times

    def __len__(self) -> int:
        return len(self.stamps)

    def __getitem__(self, column: int) -> Array:
        row: Array = self._columns[PLACE[column]]
        return row

    def pair(self, column: int) -> Array:
        """Return [W, 2]: `column` and the one behind it, for example those of motor and arm."""
        return self._columns[PLACE[column]:PLACE[column] + 2].T

    def stack(self, columns: Sequence[int]) -> Array:
        """Return [W, len(columns)] of these `columns`."""
        return self._columns[[PLACE[column] for column in columns]].T

    def after(self, stamp_ns: int) -> 'Recent':
        """Return the part stamped after `stamp_ns`."""
        first = int(np.searchsorted(self.stamps, stamp_ns, 'right'))
        return Recent(self.stamps[first:], self._columns[:, first:].T)


class RowHistory:
    """
    Rows in order of time, in one array.

    Rows that are older than the newest one replace all others: the clock was set back.
    """

    def __init__(self) -> None:
        self._stamps, self._rows = np.empty(0, np.int64), np.empty((0, 0))
        self._end = 0

    def __len__(self) -> int:
        return self._end

    @property
    def stamps(self) -> Integers:
        """Stamps of the rows, int64 [N] ns; not to keep."""
        return self._stamps[:self._end]

    def clear(self) -> None:
        """Forget all rows."""
        self._end = 0

    def add(self, stamps: Integers, rows: Array, keep_ns: int) -> None:
        """
        Add rows; older ones make room for them.

        Args:
            stamps: of the rows, int64 [N > 0] ns, ascending.
            rows: [N, M].
            keep_ns: rows stamped before it may go.

        """
        n = len(stamps)
        if self._end and stamps[0] < self._stamps[self._end - 1]:
            self.clear()
        if self._end + n > len(self._stamps):
            rows_in_memory = slice(int(np.searchsorted(self.stamps, keep_ns)), self._end)
            count = rows_in_memory.stop - rows_in_memory.start
            size = max(round(ROOM * (count + n)), BLOCK)
            old = self._stamps[rows_in_memory], self._rows[rows_in_memory]
            self._stamps, self._rows = np.empty(size, np.int64), np.empty((size, rows.shape[1]))
            if count:
                self._stamps[:count], self._rows[:count] = old
            self._end = count
        part = slice(self._end, self._end + n)
        self._stamps[part], self._rows[part] = stamps, rows
        self._end = part.stop

    def between(self, first_ns: int, end_ns: int) -> tuple[Integers, Array]:
        """Return (stamps, rows) with `first_ns` <= stamp < `end_ns`; not to keep."""
        part = slice(*np.searchsorted(self.stamps, (first_ns, end_ns)))
        return self._stamps[part], self._rows[part]

    def after(self, stamp_ns: int) -> Array:
        """Return the rows [N, M] stamped after `stamp_ns`; not to keep."""
        first = int(np.searchsorted(self.stamps, stamp_ns, 'right'))
        return self._rows[first:self._end]
