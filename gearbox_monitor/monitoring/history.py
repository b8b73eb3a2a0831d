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

"""The newest estimates, column by column: what trust reads of them, once per second."""
import numpy as np

from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.process_model import TAU_K

# What is kept, in runs of columns; tests read a column many times, so each lies in one piece.
RUNS = (range(sample_loop.E_X1, sample_loop.E_TAU_E + 1),
        range(sample_loop.E_STD + TAU_K, sample_loop.E_STD + TAU_K + 1),
        range(sample_loop.E_INNOVATION_MOTOR, sample_loop.E_DT + 1))
PLACE = {column: place for place, column in enumerate(column for run in RUNS for column in run)}


BLOCK = 512  # looked through at once


class Recent:
    """W estimates: stamps int64 [W]; recent[column] [W], column one of PLACE, of `columns`."""

    def __init__(self, stamps, columns):
        self.stamps, self._columns = stamps, columns

    def __len__(self):
        return len(self.stamps)

    def __getitem__(self, column):
        return self._columns[PLACE[column]]

    def pair(self, column):
        """Return [W, 2]: `column` and the one behind it, those of motor and arm say."""
        return self._columns[PLACE[column]:PLACE[column] + 2].T

    def stack(self, columns):
        """Return [W, len(columns)] of these columns."""
        return self._columns[[PLACE[column] for column in columns]].T

    def after(self, stamp_ns):
        """Return the part stamped after `stamp_ns`."""
        first = int(np.searchsorted(self.stamps, stamp_ns, 'right'))
        return Recent(self.stamps[first:], self._columns[:, first:])


class History:
    """A ring of the newest `size` estimates."""

    def __init__(self, size):
        self.size = size
        self._stamps, self._columns = np.zeros(size, np.int64), np.zeros((len(PLACE), size))
        self._held = 0  # ever

    def add(self, stamps, rows):
        """Add estimates: stamps int64 [N] ns and rows [N, N_ESTIMATE], N <= size."""
        at, n = self._held % self.size, len(stamps)
        fits = min(n, self.size - at)
        self._write(at, stamps[:fits], rows[:fits])
        if fits < n:
            self._write(0, stamps[fits:], rows[fits:])
        self._held += n

    def _write(self, at, stamps, rows):
        end = at + len(stamps)
        self._stamps[at:end] = stamps
        for run in RUNS:
            place = PLACE[run[0]]
            self._columns[place:place + len(run), at:end] = rows[:, run[0]:run[-1] + 1].T

    def recent(self, first_ns, last_ns):
        """Return the Recent newest estimates stamped within first_ns < stamp <= last_ns."""
        at, parts, look = self._held % self.size, [], True
        # From the newest back, block by block, until one stands out of the time asked for.
        for low, high in ((0, at), (at, self.size if self._held >= self.size else at)):
            while look and high > low:
                begin = max(low, high - BLOCK)
                stamps = self._stamps[begin:high]
                apart = np.flatnonzero((stamps <= first_ns) | (stamps > last_ns))
                if len(apart):
                    begin, look = begin + int(apart[-1]) + 1, False
                if parts and parts[0].start == high:
                    high = parts.pop(0).stop
                parts.insert(0, slice(begin, high))
                high = begin
        parts = [part for part in parts if part.start < part.stop] or [slice(0, 0)]
        if len(parts) == 1:
            return Recent(self._stamps[parts[0]], self._columns[:, parts[0]])
        return Recent(np.concatenate([self._stamps[part] for part in parts]),
                      np.concatenate([self._columns[:, part] for part in parts], axis=1))
