# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Tables with a row for each joint: the column that says whose row it is, and rows by joint."""
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gearbox_monitor.kernels.types import Integers
from gearbox_monitor.recordings.importer.layout import MOST_KEYS, MOST_ROWS, Series
from gearbox_monitor.recordings.importer.meaning import (
    COUNTER, meaning_of, NOTHING, STRANGE, TIMES, words_of)

NUMBERED = frozenset('id joint motor servo axis device actuator node can name channel'.split())
TURNS = 0.3    # share of rows behind which another joint's follows
EVEN = 0.5     # rows of the rarest joint to those of the most frequent


@dataclass(frozen=True)
class RowKey:
    """The column that says whose row it is; rows {joint: (its value there, its rows)}."""

    column: Series
    rows: dict[str, tuple[int | str, Integers]]

    def of_first(self, series: Sequence[Series]) -> list[Series]:
        """Return the columns `series`, but this one, in the rows of the first joint."""
        return list(self._of(next(iter(self.rows)), series))

    def by_joint(self, series: Sequence[Series]) -> list[tuple[str, Series]]:
        """Return (joint, column of `series` in its rows) of all joints; the place says whose."""
        return [(joint, replace(column, place={**column.place, 'only': self.rows[joint][0]}))
                for joint in self.rows for column in self._of(joint, series)]

    def _of(self, joint: str, series: Sequence[Series]) -> Iterator[Series]:
        count = min(len(rows) for _, rows in self.rows.values())
        for column in series:
            if column.label != self.column.label:
                yield replace(column, values=column.values[self.rows[joint][1][:count]])


def row_key(series: Sequence[Series], words: Sequence[Series]) -> RowKey | None:
    """
    Return the RowKey of a recording, None where each row holds all joints.

    Joints take turns, or the time restarts with each block of rows of a joint. Blocks of what is
    no joint by its name are runs, and of a file that is read in part blocks may be missing.

    Args:
        series: columns of numbers.
        words: columns of words that come back.
    """
    times = [column for column in series if meaning_of(column.label, column.unit).quantity == TIMES
             and column.values.dtype.kind in 'iuf']
    for column in (*words, *(c for c in series if _names_joints(c)
                             and c.values.dtype.kind in 'iuf')):
        names, place, counts = np.unique(column.values, return_inverse=True, return_counts=True)
        if not 1 < len(names) <= MOST_KEYS or counts.min() < EVEN * counts.max() or (
                names.dtype.kind == 'f' and (names != np.floor(names)).any()):
            continue
        turns = np.diff(place) != 0
        blocks = (turns.sum() == len(names) - 1 and _names_joints(column)
                  and len(place) != MOST_ROWS and any(
                      np.array_equal(np.diff(time.values) < 0, turns) for time in times))
        if turns.mean() > TURNS or blocks:
            order = np.argsort([int(np.flatnonzero(place == k)[0]) for k in range(len(names))])
            return RowKey(column, {
                str(names[k]) if names.dtype.kind == 'U' else f'joint_{int(names[k])}':
                (str(names[k]) if names.dtype.kind == 'U' else int(names[k]),
                 np.flatnonzero(place == k)) for k in order})
    return None


def _names_joints(column: Series) -> bool:
    """Return whether a column tells joints apart by its name: 'motor_id', not 'motor_temp'."""
    words = set(words_of(column.label))
    return bool(words & NUMBERED) and not words & STRANGE and meaning_of(
        column.label, column.unit).quantity in (COUNTER, NOTHING)
