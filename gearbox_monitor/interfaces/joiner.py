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
from typing import Generic, TypeVar

WAIT = 1_000_000_000  # ns of stamps that a message waits for its partner
Values = TypeVar('Values')


class Joiner(Generic[Values]):
    """
    Pairs messages whose stamps are at most `tolerance` (int ns) apart, each message once.

    A motor message gets the first arm message that fits. Without one it goes on alone, an arm
    message is left out. pairs, alone, unused: how many of each.
    """

    def __init__(self, tolerance: int) -> None:
        self.tolerance = tolerance
        self.pairs = self.alone = self.unused = 0
        self._nearest: int | None = None
        self._motor: deque[tuple[int, Values]] = deque()
        self._arm: deque[tuple[int, Values]] = deque()

    def motor(self, stamp_ns: int, values: Values) -> list[tuple[int, Values, Values | None]]:
        """Take `values` of the motor at `stamp_ns`; return the samples that are complete now."""
        if stamp_ns <= 0:  # says nothing about when
            self.alone += 1
            return [(stamp_ns, values, None)]
        samples = self._make_room(stamp_ns, self._motor)
        self._motor.append((stamp_ns, values))
        return samples + self._matched()

    def arm(self, stamp_ns: int, values: Values) -> list[tuple[int, Values, Values | None]]:
        """Take `values` of the arm at `stamp_ns`; return the samples that are complete now."""
        if stamp_ns <= 0:
            self.unused += 1
            return []
        samples = self._make_room(stamp_ns, self._arm)
        self._arm.append((stamp_ns, values))
        return samples + self._matched()

    def clear(self) -> None:
        """Drop all messages that wait for a partner."""
        self._motor.clear()
        self._arm.clear()

    def ask(self) -> int | None:
        """Return the smallest distance (ns) of stamps that did not fit since the last call."""
        nearest, self._nearest = self._nearest, None
        return nearest

    def _make_room(self, stamp_ns: int, own: deque[tuple[int, Values]]
                   ) -> list[tuple[int, Values, Values | None]]:
        """Give up what waits in vain once `stamp_ns` has come, on the side `own`."""
        samples: list[tuple[int, Values, Values | None]] = []
        back = bool(own) and own[-1][0] > stamp_ns  # a new time has begun
        while self._motor and (back and own is self._motor
                               or abs(self._motor[0][0] - stamp_ns) > WAIT):
            samples.append(self._single())
        while self._arm and (back and own is self._arm
                             or abs(self._arm[0][0] - stamp_ns) > WAIT):
            self._drop()
        return samples

    def _matched(self) -> list[tuple[int, Values, Values | None]]:
        """Return the samples of messages that have a partner, or can have none any more."""
        samples: list[tuple[int, Values, Values | None]] = []
        while self._motor and self._arm:
            distance = self._arm[0][0] - self._motor[0][0]
            if abs(distance) <= self.tolerance:
                samples.append((*self._motor.popleft(), self._arm.popleft()[1]))
                self.pairs += 1
                continue
            self._nearest = min(abs(distance), self._nearest or abs(distance))
            if distance < 0:
                self._drop()
            else:
                samples.append(self._single())
        return samples

    def _single(self) -> tuple[int, Values, None]:
        """Return the oldest motor message as a sample without arm."""
        self.alone += 1
        return (*self._motor.popleft(), None)

    def _drop(self) -> None:
        """Leave out the oldest arm message."""
        self.unused += 1
        self._arm.popleft()
