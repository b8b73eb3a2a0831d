# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Match the rows of two streams that carry the same stamp."""
import numpy as np

from gearbox_monitor.kernels.types import Array, Flags, Integers

WAIT = 10_000_000_000  # ns of log time that a row waits for its partner


def match_stamps(a: Integers, b: Integers) -> tuple[Integers, Integers]:
    """Return indices (i, j) with a[i] == b[j]; `a`, `b` [N], [M]: k-th occurrence with k-th."""
    a, b = np.asarray(a), np.asarray(b)
    if np.array_equal(a, b):
        return np.arange(len(a)), np.arange(len(a))
    if (np.diff(a) > 0).all() and (np.diff(b) > 0).all():
        j = np.searchsorted(b, a)
        i = np.flatnonzero(b[np.minimum(j, len(b) - 1)] == a) if len(b) else np.empty(0, int)
        return i, j[i]
    place = {key: index for index, key in enumerate(_numbered(b))}
    pairs = [(index, place[key]) for index, key in enumerate(_numbered(a)) if key in place]
    i, j = np.array(pairs, int).reshape(-1, 2).T
    return i, j


def _numbered(stamps: Integers) -> list[tuple[int, int]]:
    """Return [(stamp, number of its earlier occurrences)]."""
    order = np.argsort(stamps, kind='stable')
    ordered = stamps[order]
    occurrence = np.empty(len(stamps), np.int64)
    occurrence[order] = np.arange(len(stamps)) - np.searchsorted(ordered, ordered)
    return list(zip(stamps.tolist(), occurrence.tolist()))


class _WaitingRows:
    """Rows of one stream: stamps [N], log times of their arrival [N], values [N, width]."""

    def __init__(self, width: int) -> None:
        self.stamps, self.arrival = np.empty(0, np.int64), np.empty(0, np.int64)
        self.values: Array = np.empty((0, width))

    def put(self, log_ns: int, stamps: Integers, values: Array) -> None:
        """Append `stamps` [N] and `values` [N, width], which arrived at `log_ns`."""
        if len(self.stamps):
            stamps = np.concatenate([self.stamps, stamps])
            values = np.concatenate([self.values, values])
        arrival = np.full(len(stamps), log_ns)
        arrival[:len(self.arrival)] = self.arrival
        self.stamps, self.arrival, self.values = stamps, arrival, values

    def keep(self, rows: slice | Flags) -> None:
        """Drop all but `rows`."""
        self.stamps, self.arrival = self.stamps[rows], self.arrival[rows]
        self.values = self.values[rows]


class StampMatcher:
    """
    Match the rows of two streams as they arrive; each waits for its partner for WAIT.

    Args:
        left_width: number of values per row on the left.
        right_width: the same on the right.
    """

    def __init__(self, left_width: int, right_width: int) -> None:
        self._left, self._right = _WaitingRows(left_width), _WaitingRows(right_width)

    def put(self, log_ns: int, left: tuple[Integers, Array], right: tuple[Integers, Array]
            ) -> None:
        """
        Add rows.

        Args:
            log_ns: log time at which they arrive, ns.
            left: (stamps [N], values [N, left_width]).
            right: (stamps [M], values [M, right_width]).
        """
        self._left.put(log_ns, *left)
        self._right.put(log_ns, *right)

    def skip_until(self, stamp: int) -> bool:
        """Drop the rows on the right that precede `stamp`; return whether it has arrived."""
        rows = np.flatnonzero(self._right.stamps == stamp)
        if len(rows):
            self._right.keep(slice(rows[0], None))
        return len(rows) > 0

    def pairs(self) -> tuple[Integers, Array, Array]:
        """Return (stamps, left values, right values) of the rows matched since the last call."""
        first, right = self._left, self._right
        i, j = match_stamps(first.stamps, right.stamps)
        matched = first.stamps[i], first.values[i], right.values[j]
        for side, rows in ((first, i), (right, j)):
            waiting = np.ones(len(side.stamps), bool)
            waiting[rows] = False
            side.keep(waiting)
        return matched

    def expired(self, log_ns: int | None = None) -> tuple[Integers, Integers]:
        """Remove rows that have waited for WAIT at `log_ns` (None: all); return their stamps."""
        stamps = []
        for side in (self._left, self._right):
            overdue = np.ones(len(side.arrival), bool) if log_ns is None else \
                side.arrival < log_ns - WAIT
            stamps.append(side.stamps[overdue])
            side.keep(~overdue)
        return stamps[0], stamps[1]
