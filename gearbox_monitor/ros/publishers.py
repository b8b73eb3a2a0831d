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
Whose messages are taken, where several publishers give the same joints.

A message says nothing about its publisher, but each publisher numbers its messages on a topic one
by one. Numbers that go back, or on elsewhere, are those of another one. No clock here: times are
those of reception, by a clock that may be set back.
"""
from dataclasses import dataclass

from gearbox_monitor.parameters import ACCEPT, REFUSE

SECOND = 1_000_000_000
SILENT = SECOND     # ns without a message after which a publisher counts as gone
FIRST = 3 * SECOND  # ns that a publisher must have been alone to be the first
REACH = 5000        # numbers that one publisher may skip: lost, or messages of other joints
RETURN = 10         # numbers behind a skip that show it to have been another publisher's
NEAR = 100          # with numbers so near to those of another one, a loss confuses the two
MOST = 16           # publishers that are told apart


@dataclass(eq=False)
class Source:
    """One publisher: the `last` number, when it was `seen` first (`born`) and last (ns)."""

    born: int
    last: int
    seen: int
    before: int = 0      # last number before its latest skip,
    skipped: int = 0     # and when that was
    refused: bool = False  # it spoke beside the one that is followed


class Publishers:
    """
    Decides message by message whether it is taken; only those with our joints are asked about.

    policy: of POLICIES. FOLLOW_FIRST takes the messages of the first publisher until it is silent,
    then of one that comes after it, never of one that spoke beside it. Where nobody was first
    (REFUSE: whenever there are two) nothing is taken until one is left. A middleware that does not
    number messages leaves all of them alike: then all are taken. refused: messages not taken.
    disputes: how often it had to be given up which publisher is the first.
    """

    def __init__(self, policy):
        self.policy, self.refused, self.disputes = policy, 0, 0
        self._latest = self._back = 0  # ns: latest time; how far the clock was set back in all
        self.forget()

    def forget(self):
        """Begin anew: whoever speaks next is the first."""
        self._sources, self._followed, self._since = [], None, 0
        self._disputed = None  # when two were heard last, while none is followed

    def admit(self, number, now_ns):
        """Return whether to take the message `number` (None: not numbered) received at now_ns."""
        if not number:
            return True
        source, now_ns = self._followed, self._time(now_ns)
        if source is not None and len(self._sources) == 1 and number == source.last + 1:
            source.last, source.seen = number, now_ns
            return True
        source = self._source_of(number, now_ns)
        if self.policy == ACCEPT or self._is_ours(source, now_ns):
            return True
        self.refused += 1
        return False

    def others(self, now_ns):
        """Return how many publishers are heard besides the one that is followed."""
        heard = self._heard(now_ns + self._back)
        if self.policy == ACCEPT:
            return max(0, len(heard) - 1)
        return sum(source is not self._followed for source in heard)

    @property
    def disputed(self):
        """Whether nothing is taken because it is open which publisher is the first."""
        return self._disputed is not None

    def waits(self, now_ns):
        """Return whether the one that is followed is silent, and only refused ones are heard."""
        now = now_ns + self._back
        return (self._followed is not None and now - self._followed.seen > SILENT
                and any(source.refused for source in self._heard(now)))

    def _time(self, now_ns):
        """Return `now_ns` as if the clock had never been set back."""
        self._back = max(self._back, self._latest - now_ns)
        self._latest = now_ns + self._back
        return self._latest

    def _heard(self, now):
        return [source for source in self._sources if now - source.seen <= SILENT]

    def _is_ours(self, source, now):
        if source is None:
            self._sources.clear()
            self._dispute(now)
            return False
        rivals = [other for other in self._heard(now) if other is not source]
        if self._followed is None:
            if self.disputed and rivals:
                self._disputed = now
            if self.disputed and now - self._disputed <= SILENT:
                return False
            self._follow(source, now)
        elif source is not self._followed:
            if source.refused or now - self._followed.seen <= SILENT:
                return False
            self._follow(source, now)  # the other one had ended before
        for rival in rivals:
            # It has spoken since we last did.
            if self.policy == REFUSE or not rival.refused and rival.born - self._since < FIRST:
                self._dispute(now)
                return False
            rival.refused = True
        return True

    def _follow(self, source, now):
        self._followed, self._since, self._disputed = source, now, None
        source.refused = False

    def _dispute(self, now):
        self.disputes += self._disputed is None
        self._followed, self._disputed = None, now

    def _source_of(self, number, now):
        """Return the Source that sent message `number`; None where it may be one or another."""
        heard = self._heard(now)
        silent = [source for source in self._sources if source not in heard]
        exact = [source for source in heard if source.last == number - 1]
        if len(exact) > 1:
            return None
        exact = exact or [source for source in silent if source.last == number - 1]
        if exact:
            source = exact[0]
        else:
            source = self._behind_a_skip(heard, number, now)
            if source is not None:
                return source
            source = _nearest(heard, number) or _nearest(silent, number)
            if source is None:
                return self._new(number, now)
            if any(other is not source and -NEAR <= number - other.last <= REACH
                   for other in heard):
                return None
            source.before, source.skipped = source.last, now
        source.last, source.seen = number, now
        return source

    def _behind_a_skip(self, heard, number, now):
        """Return who goes on where it seemed to have skipped: that was another, then."""
        for source in heard:
            if 0 < number - source.before <= RETURN and number <= source.last and (
                    now - source.skipped <= SILENT):
                self._new(source.last, now)
                source.last, source.seen, source.skipped = number, now, 0
                return source
        return None

    def _new(self, number, now):
        if len(self._sources) == MOST:
            self._sources.remove(min((s for s in self._sources if s is not self._followed),
                                     key=lambda s: s.seen))
        source = Source(now, number, now)
        self._sources.append(source)
        return source


def _nearest(sources, number):
    """Return the Source that `number` follows most closely, within REACH, or None."""
    near = [source for source in sources if 0 < number - source.last <= REACH]
    return max(near, key=lambda source: source.last, default=None)
