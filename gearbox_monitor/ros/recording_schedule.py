# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""When the estimator keeps its recording, by itself and at all. No ROS, clock or disk here."""
from collections import deque
from collections.abc import Iterable
import math

HOUR = 3600.0  # s


class RecordingQuota:
    """At most `count` recordings in any hour; times are those of a steady clock (s)."""

    def __init__(self, count: int) -> None:
        self._times: deque[float] = deque(maxlen=count)

    def wait(self, time_s: float) -> float:
        """Return how long after `time_s` the next recording may be kept (s), 0: now."""
        if len(self._times) < (self._times.maxlen or 0):
            return 0.0
        return max(0.0, self._times[0] + HOUR - time_s)

    def take(self, time_s: float) -> None:
        """Count the recording kept at `time_s`."""
        self._times.append(time_s)

    def give_back(self) -> None:
        """Count the newest recording no more: it was not written."""
        if self._times:
            self._times.pop()


class RecordingSchedule:
    """
    Tells when to keep the recording: `seconds` after a component became ERROR, once per alert.

    Two such recordings are at least `span` (s) apart, the time that a recording reaches back: an
    alert that comes sooner waits for the next recording. Components in `wrong` are ERROR from an
    earlier run; they raise no alert until they have recovered once.

    texts: {component: text} says what became of the newest alert of each component.
    """

    def __init__(self, seconds: float, span: float, wrong: Iterable[str] = ()) -> None:
        self._seconds, self._span, self._wrong = seconds, span, set(wrong)
        self._deadlines: dict[str, float] = {}  # {component: when to keep its recording}
        self._last_time = -math.inf
        self.texts: dict[str, str] = {}

    def look(self, wrong: Iterable[str], time_s: float, busy: bool = False) -> list[str]:
        """
        Return the components whose alert to keep at once, mostly none.

        Args:
            wrong: components that are ERROR.
            time_s: time by a clock that only goes forward, s.
            busy: whether nothing can be kept at the moment.

        Returns:
            Their names; their alerts are taken for kept from then on.

        """
        wrong = set(wrong)
        for component in wrong - self._wrong:
            self._deadlines.setdefault(component, time_s + self._seconds)
        self._wrong = wrong
        deadline = min(self._deadlines.values(), default=math.inf)
        wait = max(deadline, self._last_time + self._span) - time_s
        if wait <= 0.0 and not busy:
            self._last_time = time_s
            return self.waiting()
        self.texts.update({component: f'due in {max(wait, 0.0):.0f} s'
                           for component in self._deadlines})
        return []

    def waiting(self) -> list[str]:
        """Return the components whose alert was not kept yet; they are taken for kept."""
        components, self._deadlines = sorted(self._deadlines), {}
        return components

    def tell(self, components: Iterable[str], text: str) -> None:
        """Note with `text` what became of the recording of the alerts of `components`."""
        self.texts.update(dict.fromkeys(components, text))
