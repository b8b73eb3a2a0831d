# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Join the messages of a motor encoder and an arm encoder into samples, by their stamps.

The samples depend on the two streams only, not on the order of arrival, as long as neither falls
behind the other by more than WAIT.
"""
from collections import deque
from typing import Generic, TypeAlias, TypeVar

WAIT = 1_000_000_000  # ns of stamps that a message waits for its partner
V = TypeVar('V')
JoinedSample: TypeAlias = tuple[int, V, V | None]  # stamp (ns), motor values, arm values if paired


class Joiner(Generic[V]):
    """
    Pairs messages whose stamps are at most `tolerance` (int ns) apart, each message once.

    A motor message is paired with the first arm message that fits. Without one it becomes a sample
    of its own; an arm message without a partner is dropped. pairs, unpaired, dropped: how many.
    """

    def __init__(self, tolerance: int) -> None:
        self.tolerance = tolerance
        self.pairs = self.unpaired = self.dropped = 0
        self._distance: int | None = None
        self._motor: deque[tuple[int, V]] = deque()
        self._arm: deque[tuple[int, V]] = deque()

    def motor(self, stamp_ns: int, values: V) -> list[JoinedSample[V]]:
        """Take the motor message `values` stamped `stamp_ns`; return the completed samples."""
        if stamp_ns <= 0:  # no stamp
            self.unpaired += 1
            return [(stamp_ns, values, None)]
        samples = self._expire(stamp_ns, self._motor)
        self._motor.append((stamp_ns, values))
        return samples + self._matched()

    def arm(self, stamp_ns: int, values: V) -> list[JoinedSample[V]]:
        """Take the arm message `values` stamped `stamp_ns`; return the completed samples."""
        if stamp_ns <= 0:
            self.dropped += 1
            return []
        samples = self._expire(stamp_ns, self._arm)
        self._arm.append((stamp_ns, values))
        return samples + self._matched()

    def clear(self) -> None:
        """Forget the waiting messages."""
        self._motor.clear()
        self._arm.clear()

    def pop_distance(self) -> int | None:
        """Return the smallest distance (ns) of stamps that did not fit since the last call."""
        distance, self._distance = self._distance, None
        return distance

    def _expire(self, stamp_ns: int, queue: deque[tuple[int, V]]) -> list[JoinedSample[V]]:
        """Give up messages too old for `stamp_ns`, which is about to join `queue`."""
        samples: list[JoinedSample[V]] = []
        back = bool(queue) and queue[-1][0] > stamp_ns  # the clock was set back
        while self._motor and (back and queue is self._motor
                               or abs(self._motor[0][0] - stamp_ns) > WAIT):
            samples.append(self._pop_unpaired())
        while self._arm and (back and queue is self._arm
                             or abs(self._arm[0][0] - stamp_ns) > WAIT):
            self._drop()
        return samples

    def _matched(self) -> list[JoinedSample[V]]:
        samples: list[JoinedSample[V]] = []
        while self._motor and self._arm:
            offset = self._arm[0][0] - self._motor[0][0]
            if abs(offset) <= self.tolerance:
                samples.append((*self._motor.popleft(), self._arm.popleft()[1]))
                self.pairs += 1
                continue
            self._distance = min(abs(offset), self._distance or abs(offset))
            if offset < 0:
                self._drop()
            else:
                samples.append(self._pop_unpaired())
        return samples

    def _pop_unpaired(self) -> JoinedSample[V]:
        self.unpaired += 1
        return (*self._motor.popleft(), None)

    def _drop(self) -> None:
        self.dropped += 1
        self._arm.popleft()
