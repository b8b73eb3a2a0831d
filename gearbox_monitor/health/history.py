# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The newest estimates and smoothed rows, which trust reads once per second."""
import numpy as np

from gearbox_monitor.kernels.types import Array, Integers

BLOCK = 512  # rows of room, at least
ROOM = 1.25  # of what is kept: rows move when it is full


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
