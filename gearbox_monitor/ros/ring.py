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
The newest minutes of the measurement, in memory, and the stretch of them to diagnose.

No ROS here. A block of rows is allocated when the one before it is full, so memory follows the
rate; full blocks never change, so reading them costs no copy while samples come.
"""
from collections import deque

import numpy as np

SECOND = 1_000_000_000
BLOCK = 8192       # rows
MAX_RATE = 4000.0  # rows/s that the time asked for is kept at; above, it is less
STRETCH = 14.0     # s, a good length for a diagnosis
LEAST = 4.0        # s, that a diagnosis wants at least
LOST = 4           # sample times from one stamp to the next that are a gap; shorter is mended
LIVELY = 0.8       # of the most travel: so much will do, then the newest is better
MOTOR, ARM, MOTOR_EFFORT, ARM_EFFORT = range(4)
DTYPE = np.dtype([('stamp_ns', np.int64), ('good', np.bool_), ('values', np.float64, 4)])


class Ring:
    """
    The rows of the last `seconds`, at most MAX_RATE of them per second.

    A row: stamp (ns), good (whether the estimator could use it), values [4] as received: position
    of motor and arm, effort of motor and arm; NaN = not given.
    """

    def __init__(self, seconds, block=BLOCK):
        self.span = round(seconds * SECOND)
        self._size = block
        self._most = int(np.ceil(seconds * MAX_RATE / block)) + 1
        self._full = deque()  # (rows, newest good stamp when it was full)
        self._rows, self._n = np.empty(block, DTYPE), 0
        self._newest = 0

    def add(self, stamp_ns, good, values):
        """Add one row."""
        if self._n == self._size:
            self._next_block()
        self._rows[self._n] = (stamp_ns, good, values)
        self._n += 1
        if good:
            self._newest = stamp_ns

    def _next_block(self):
        self._full.append((self._rows, self._newest))
        # Also what is stamped after now: the clock was set back, and that time is over.
        while self._full and not 0 <= self._newest - self._full[0][1] <= self.span:
            self._full.popleft()
        while len(self._full) >= self._most:
            self._full.popleft()
        self._rows, self._n = np.empty(self._size, DTYPE), 0

    def __len__(self):
        return sum(len(rows) for rows, _ in self._full) + self._n

    def rows(self):
        """Return a function that gives the rows [N] of now, oldest first, from any thread."""
        parts = [rows for rows, _ in self._full] + [self._rows[:self._n].copy()]
        first, span = self._newest - self.span, self.span

        def joined():
            rows = np.concatenate(parts)
            inside = np.flatnonzero(rows['good'] & (rows['stamp_ns'] > first)
                                    & (rows['stamp_ns'] <= first + span))
            return rows[inside[0]:] if len(inside) else rows
        return joined


def stretch(rows, effort_delay=0):
    """
    Return the rows [M] to diagnose, without gaps, M = 0 where there are none; see Ring.

    At most STRETCH and at least LEAST long; the newest among those that travel far. The effort is
    moved by `effort_delay` samples, so that the one stamped t_k acts from t_k on.
    """
    rows = _where(rows, rows['good'])
    if len(rows) < 2:
        return rows[:0]
    finite = np.isfinite(rows['values'])
    used = finite.mean(axis=0) > 0.5  # what is hardly ever measured is not missed
    rows = _where(rows, finite[:, used].all(axis=1))
    steps = np.diff(rows['stamp_ns'])
    if not used[[MOTOR, MOTOR_EFFORT]].all() or not (steps > 0).any():
        return rows[:0]
    period = float(np.median(steps[steps > 0]))
    edges = np.flatnonzero((steps <= 0) | (steps > LOST * period)) + 1
    found = []  # (begin, end, travel), oldest first
    for begin, end in zip([0, *edges], [*edges, len(rows)]):
        part = rows[begin:end]
        found += [(begin + a, begin + b, travel) for a, b, travel in _pieces(part, period)]
    if not found:
        return rows[:0]
    most = max(travel for _, _, travel in found)
    begin, end, _ = [piece for piece in found if piece[2] >= LIVELY * most][-1]
    return _with_effort_moved(rows[begin:end], effort_delay)


def _where(rows, wanted):
    """Return the rows `wanted`; copying them all would hold up the estimates."""
    return rows if wanted.all() else rows[wanted]


def _pieces(rows, period):
    """Yield (begin, end, travel of the motor) of pieces of `rows` without gaps, 1 s apart."""
    stamps = rows['stamp_ns']
    length, second = round(STRETCH * SECOND / period), max(1, round(SECOND / period))
    if stamps[-1] - stamps[0] + period < LEAST * SECOND:
        return
    stride = max(1, second // 50)  # slower than the noise of the encoder
    travel = np.zeros(len(rows))
    motor = rows['values'][:, MOTOR]
    travel[stride::stride] = np.abs(np.diff(motor[::stride]))[:len(travel[stride::stride])]
    travel = np.concatenate([[0.0], np.cumsum(travel)])
    last = max(0, len(rows) - length)
    for begin in sorted({last % second if last else 0, *range(last % second, last + 1, second)}):
        end = min(begin + length, len(rows))
        yield begin, end, travel[end] - travel[begin]


def _with_effort_moved(rows, delay):
    """Return rows whose effort is that of `delay` samples before (after, where negative)."""
    if not delay:
        return rows
    values = rows['values'][:, [MOTOR_EFFORT, ARM_EFFORT]]
    rows = (rows[delay:] if delay > 0 else rows[:delay]).copy()
    rows['values'][:, [MOTOR_EFFORT, ARM_EFFORT]] = (
        values[:-delay] if delay > 0 else values[-delay:])
    return rows
