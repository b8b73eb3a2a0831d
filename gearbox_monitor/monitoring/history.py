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

"""The newest estimates and smoothed rows: what trust reads of them, once per second."""
from collections.abc import Sequence

import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.process_model import TAU_K
from gearbox_monitor.kernels.jit import jit
from gearbox_monitor.kernels.types import Array, Integers

# The columns that are stored, in runs; checks read a column many times, so each lies in one piece.
RUNS = (range(sample_loop.E_X1, sample_loop.E_TAU_E + 1),
        range(sample_loop.E_STD + TAU_K, sample_loop.E_STD + TAU_K + 1),
        range(sample_loop.E_INNOVATION_MOTOR, sample_loop.E_DT + 1),
        *(range(column, column + 1) for column in (
            sample_loop.E_TAU_K_NOISE_STD, sample_loop.E_MOTOR_SIDE_NOISE_STD)))
PLACE = {column: place for place, column in enumerate(column for run in RUNS for column in run)}
COLUMNS = np.array(list(PLACE))
BLOCK = 512  # rows of room, at least


@jit
def _in_time(stamps: Integers, first_ns: int, last_ns: int) -> int:
    """Return how many of the last `stamps` [N] in a row are > `first_ns` and <= `last_ns`."""
    count = 0
    while count < len(stamps) and first_ns < stamps[len(stamps) - 1 - count] <= last_ns:
        count += 1
    return count


class Recent:
    """W estimates: stamps int64 [W]; recent[column] [W], column one of PLACE, of `columns`."""

    def __init__(self, stamps: Integers, columns: Array) -> None:
        self.stamps, self._columns = stamps, columns

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
        return Recent(self.stamps[first:], self._columns[:, first:])


class EstimateHistory:
    """A ring of the newest `size` estimates."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._stamps, self._columns = np.zeros(size, np.int64), np.zeros((len(PLACE), size))
        self._total = 0  # estimates added since the beginning

    def add(self, stamps: Integers, rows: Array) -> None:
        """Add estimates: `stamps` int64 [N] ns and `rows` [N, N_ESTIMATE], N <= size."""
        at, n = self._total % self.size, len(stamps)
        fits = min(n, self.size - at)
        self._write(at, stamps[:fits], rows[:fits])
        if fits < n:
            self._write(0, stamps[fits:], rows[fits:])
        self._total += n

    def _write(self, at: int, stamps: Integers, rows: Array) -> None:
        end = at + len(stamps)
        self._stamps[at:end] = stamps
        self._columns[:, at:end] = rows[:, COLUMNS].T

    def recent(self, first_ns: int, last_ns: int) -> Recent:
        """Return the Recent newest estimates stamped `first_ns` < stamp <= `last_ns`."""
        at = self._total % self.size
        newest = _in_time(self._stamps[:at], first_ns, last_ns)
        parts = [slice(at - newest, at)]
        if newest == at and self._total >= self.size:
            older = _in_time(self._stamps[at:], first_ns, last_ns)
            if older:
                parts.insert(0, slice(self.size - older, self.size))
        if len(parts) == 1:
            return Recent(self._stamps[parts[0]], self._columns[:, parts[0]])
        return Recent(np.concatenate([self._stamps[part] for part in parts]),
                      np.concatenate([self._columns[:, part] for part in parts], axis=1))


class RowHistory:
    """The rows of the last `span` ns, and at times older ones, in one piece."""

    def __init__(self, span: int, width: int) -> None:
        self.span = span
        self._stamps, self._rows = np.empty(BLOCK, np.int64), np.empty((BLOCK, width))
        self._end = 0

    def __len__(self) -> int:
        return self._end

    def clear(self) -> None:
        """Forget all rows."""
        self._end = 0

    def add(self, stamps: Integers, rows: Array) -> None:
        """Add rows: `stamps` int64 [N > 0] ns and `rows` [N, width]."""
        n = len(stamps)
        if self._end + n > len(self._stamps):
            kept = slice(int(np.searchsorted(
                self._stamps[:self._end], stamps[-1] - self.span, 'right')), self._end)
            count = kept.stop - kept.start
            # Twice what is needed, so that rows move seldom.
            size = max(2 * (count + n), BLOCK)
            old = self._stamps[kept], self._rows[kept]
            self._stamps, self._rows = np.empty(size, np.int64), np.empty((size, rows.shape[1]))
            self._stamps[:count], self._rows[:count] = old
            self._end = count
        part = slice(self._end, self._end + n)
        self._stamps[part], self._rows[part] = stamps, rows
        self._end = part.stop

    def after(self, stamp_ns: int) -> Array:
        """Return the rows [N, width] stamped after `stamp_ns`, in order of time; not to keep."""
        first = int(np.searchsorted(self._stamps[:self._end], stamp_ns, 'right'))
        return self._rows[first:self._end]
