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

"""Pair rows of two streams that carry the same stamp."""
import numpy as np

WAIT = 10_000_000_000  # ns of log time that a row waits for its partner


def match_stamps(a, b):
    """
    Return indices (i, j) with a[i] == b[j], the k-th occurrence of a value with the k-th.

    a, b int64 [N], [M].
    """
    a, b = np.asarray(a), np.asarray(b)
    if np.array_equal(a, b):
        return np.arange(len(a)), np.arange(len(a))
    if (np.diff(a) > 0).all() and (np.diff(b) > 0).all():
        j = np.searchsorted(b, a)
        i = np.flatnonzero(b[np.minimum(j, len(b) - 1)] == a) if len(b) else np.empty(0, int)
        return i, j[i]
    place = {key: index for index, key in enumerate(_numbered(b))}
    pairs = [(index, place[key]) for index, key in enumerate(_numbered(a)) if key in place]
    return tuple(np.array(pairs, int).reshape(-1, 2).T)


def _numbered(stamps):
    """Return [(stamp, how often it stood before)]."""
    order = np.argsort(stamps, kind='stable')
    ordered = stamps[order]
    occurrence = np.empty(len(stamps), np.int64)
    occurrence[order] = np.arange(len(stamps)) - np.searchsorted(ordered, ordered)
    return list(zip(stamps.tolist(), occurrence.tolist()))


class _Side:
    """The rows of one stream that wait: stamps int64 [N], when they came, values [N, K]."""

    def __init__(self, width):
        self.stamps, self.came = np.empty(0, np.int64), np.empty(0, np.int64)
        self.values = np.empty((0, width))

    def put(self, now, stamps, values):
        if len(self.stamps):
            stamps = np.concatenate([self.stamps, stamps])
            values = np.concatenate([self.values, values])
        came = np.full(len(stamps), now)
        came[:len(self.came)] = self.came
        self.stamps, self.came, self.values = stamps, came, values

    def keep(self, rows):
        self.stamps, self.came = self.stamps[rows], self.came[rows]
        self.values = self.values[rows]


class StampMatcher:
    """Pair the rows of two streams as they come; each waits for its partner for WAIT."""

    def __init__(self, left_width, right_width):
        self._left, self._right = _Side(left_width), _Side(right_width)

    def put(self, now, left, right):
        """Add (stamps [N], values [N, K]) on either side, at the log time `now` (ns)."""
        self._left.put(now, *left)
        self._right.put(now, *right)

    def skip_before(self, stamp):
        """Drop what came before `stamp` on the right; returns whether that is there."""
        at = np.flatnonzero(self._right.stamps == stamp)
        if len(at):
            self._right.keep(slice(at[0], None))
        return len(at) > 0

    def pairs(self):
        """Return (stamps, left values, right values) of all that have met since last asked."""
        left, right = self._left, self._right
        i, j = match_stamps(left.stamps, right.stamps)
        met = left.stamps[i], left.values[i], right.values[j]
        for side, rows in ((left, i), (right, j)):
            waiting = np.ones(len(side.stamps), bool)
            waiting[rows] = False
            side.keep(waiting)
        return met

    def expired(self, now=None):
        """Return the stamps (left, right) that have waited too long at `now`; None: all."""
        lost = []
        for side in (self._left, self._right):
            late = np.ones(len(side.came), bool) if now is None else side.came < now - WAIT
            lost.append(side.stamps[late])
            side.keep(~late)
        return tuple(lost)
