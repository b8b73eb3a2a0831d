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

"""The one state machine of every alarm: debounced, clamped on both sides, with hysteresis."""
from dataclasses import dataclass, field
import enum


class Level(enum.IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Finding:
    """
    What one check says now.

    level, message in plain words, and values {name: number or text} that stand beside it; every
    value that was judged comes with its threshold.
    """

    level: Level
    message: str
    values: dict = field(default_factory=dict)


class Alarm:
    """
    Turn raw levels, one per evaluation, into a level that neither flaps nor sticks.

    A level is raised after `up` consecutive evaluations at or above it and lowered after `down`
    consecutive ones below it, so the latency is at most `up` or `down` evaluations.
    Before the first evaluation the level is WARN ("no data yet"), never OK.
    """

    def __init__(self, up=3, down=5):
        self.up, self.down = up, down
        self.level, self.since_ns = Level.WARN, None
        self._above = [0, 0]  # evaluations in a row at or above WARN, ERROR
        self._below = [0, 0]
        self._judged = False

    def update(self, raw, stamp_ns):
        """Take the raw level found at `stamp_ns`; return the debounced level."""
        for i, at in enumerate((Level.WARN, Level.ERROR)):
            above = raw >= at
            self._above[i] = min(self._above[i] + 1, self.up) if above else 0
            self._below[i] = 0 if above else min(self._below[i] + 1, self.down)
        new = self.level if self._judged else min(Level(raw), Level.WARN)
        for i, at in enumerate((Level.WARN, Level.ERROR)):
            if self._above[i] >= self.up:
                new = max(new, at)
            if self._below[i] >= self.down and new >= at:
                new = Level(at - 1)
                break
        if new != self.level or self.since_ns is None:
            self.since_ns = stamp_ns
        self.level, self._judged = new, True
        return new

    def lasted(self, stamp_ns):
        """Return how long the level has lasted, in seconds."""
        return 0.0 if self.since_ns is None else (stamp_ns - self.since_ns) * 1e-9
