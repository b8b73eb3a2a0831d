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
Join what motor and arm encoder publish in messages of their own into samples, by their stamps.

What comes out depends on the two streams only, not on how they reached us in between, as long as
neither falls behind the other by more than WAIT.
"""
from collections import deque

WAIT = 1_000_000_000  # ns of stamps that a message waits for its partner


class Joiner:
    """
    Pairs messages whose stamps are at most `tolerance` (int ns) apart, each message once.

    A motor message gets the first arm message that fits. Without one it goes on alone, an arm
    message is left out. pairs, alone, unused: how many of each.
    """

    def __init__(self, tolerance):
        self.tolerance = tolerance
        self.pairs = self.alone = self.unused = 0
        self._nearest = None
        self._motor, self._arm = deque(), deque()  # (stamp, values)

    def motor(self, stamp_ns, values):
        """Take a motor message; return the [(stamp_ns, motor values, arm values or None)] due."""
        if stamp_ns <= 0:  # says nothing about when
            self.alone += 1
            return [(stamp_ns, values, None)]
        due = self._make_room(stamp_ns, self._motor)
        self._motor.append((stamp_ns, values))
        return due + self._matched()

    def arm(self, stamp_ns, values):
        """Take an arm message; return what is due, see motor."""
        if stamp_ns <= 0:
            self.unused += 1
            return []
        due = self._make_room(stamp_ns, self._arm)
        self._arm.append((stamp_ns, values))
        return due + self._matched()

    def clear(self):
        """Forget what waits."""
        self._motor.clear()
        self._arm.clear()

    def ask(self):
        """Return the smallest distance (ns) of stamps that did not fit, since last asked."""
        nearest, self._nearest = self._nearest, None
        return nearest

    def _make_room(self, stamp_ns, own):
        """Give up what waits in vain once `stamp_ns` has come, on the side `own`."""
        due = []
        back = bool(own) and own[-1][0] > stamp_ns  # a new time has begun
        while self._motor and (back and own is self._motor
                               or abs(self._motor[0][0] - stamp_ns) > WAIT):
            due.append(self._single())
        while self._arm and (back and own is self._arm
                             or abs(self._arm[0][0] - stamp_ns) > WAIT):
            self._drop()
        return due

    def _matched(self):
        due = []
        while self._motor and self._arm:
            apart = self._arm[0][0] - self._motor[0][0]
            if abs(apart) <= self.tolerance:
                due.append((*self._motor.popleft(), self._arm.popleft()[1]))
                self.pairs += 1
                continue
            self._nearest = min(abs(apart), self._nearest or abs(apart))
            if apart < 0:
                self._drop()
            else:
                due.append(self._single())
        return due

    def _single(self):
        self.alone += 1
        return (*self._motor.popleft(), None)

    def _drop(self):
        self.unused += 1
        self._arm.popleft()
