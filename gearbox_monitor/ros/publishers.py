# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Whose messages are taken if several publishers give the same joints.

A message says nothing about its publisher, but each publisher numbers its messages on a topic one
by one. Numbers that go back, or jump, belong to another publisher. Where the numbers of two come
close, the stamps tell: those of one publisher advance by its step. No clock here: times are those
of reception, by a clock that may be set back.
"""
from dataclasses import dataclass
import math

from gearbox_monitor.parameters import ACCEPT, FOLLOW_FIRST, REFUSE

SECOND = 1_000_000_000
SILENT = SECOND     # ns without a message after which a publisher counts as gone
FIRST = 3 * SECOND  # ns that a publisher must have been alone to be the first
REACH = 5000        # numbers that one publisher may skip: lost, or messages of other joints
RETURN = 10         # numbers behind a skip that show that another publisher sent it
NEAR = 100          # with numbers so close to those of another one, a loss confuses the two
MAX_PUBLISHERS = 16  # that are distinguished
STEADY = 100         # messages after which the step of the stamps is known
# A stamp fits within this share of the step and so many times its usual deviation.
SHARE, SPREADS = 0.25, 4.0
# ns, and steps, for which the followed one may be silent before one that continues its numbers
# with other stamps is the same publisher, whose clock was set.
HOLD, HOLD_STEPS = 50_000_000, 20


@dataclass(eq=False)
class HeardPublisher:
    """One publisher: its `last` number, when it was heard first (`born`) and last (`heard`)."""

    born: int
    last: int
    heard: int
    last_before_skip: int = 0  # last number before its latest skip,
    skipped: int = 0           # and when that was
    refused: bool = False      # it spoke beside the one that is followed
    stamp: int = 0             # of its last message, ns
    step: float = 0.0          # of its stamps per number, ns,
    spread: float = 0.0        # how far they usually miss it, ns,
    messages: int = 0          # and by how many messages that is known
    continues: bool = False    # its first number may be the next one of the followed

    def add_stamp(self, stamp_ns: int, numbers: int) -> None:
        """Take the stamp `stamp_ns` of a message whose number is `numbers` after the last one."""
        elapsed = (stamp_ns - self.stamp) / max(numbers, 1)
        if self.stamp and stamp_ns:
            weight = 1.0 / min(self.messages + 1, STEADY)
            self.spread += weight * (abs(elapsed - self.step) * (self.messages > 0) - self.spread)
            self.step += weight * (elapsed - self.step)
            self.messages += 1
        self.stamp = stamp_ns

    def misses(self, number: int, stamp_ns: int) -> float:
        """Return how far message `number` at `stamp_ns` is off, over the usual; > 1: not ours."""
        numbers = number - self.last
        if not 0 < numbers <= REACH:
            return math.inf
        usual = SHARE * self.step + SPREADS * self.spread * numbers
        return abs(stamp_ns - self.stamp - numbers * self.step) / max(usual, 1.0)


class Publishers:
    """
    Decides message by message whether it is taken; only those with our joints are asked about.

    policy: of POLICIES. FOLLOW_FIRST takes the messages of the first publisher until it is silent,
    then of one that comes after it, never of one that spoke beside it. Where nobody was first
    (REFUSE: whenever there are two) nothing is taken until one is left. A middleware that does not
    number messages leaves all of them alike: then all are taken. refused: messages not taken.
    disputes: how often it had to be given up which publisher is the first.
    """

    def __init__(self, policy: str) -> None:
        self.policy, self.refused, self.disputes = policy, 0, 0
        self._latest = self._back = 0  # ns: latest time; how far the clock was set back in all
        self.forget()

    def forget(self) -> None:
        """Restart: whoever speaks next is the first."""
        self._sources: list[HeardPublisher] = []
        self._followed: HeardPublisher | None = None
        self._since = 0
        self._disputed: int | None = None  # when two were heard last, while none is followed

    def admit(self, number: int | None, now_ns: int, stamp_ns: int = 0) -> bool:
        """
        Return whether to take a message.

        Args:
            number: that its publisher gave it, None: not numbered.
            now_ns: when it was received, ns.
            stamp_ns: of its measurement, 0: not stamped.

        """
        if not number:
            return True
        now_ns = self._time(now_ns)
        source = self._by_stamp(number, now_ns, stamp_ns)
        if source is None:
            source = self._source_of(number, now_ns, stamp_ns)
        if self.policy == ACCEPT or self._is_ours(source, now_ns):
            return True
        self.refused += 1
        return False

    def others(self, now_ns: int) -> int:
        """Return how many publishers are heard at `now_ns` besides the one that is followed."""
        heard = self._heard(now_ns + self._back)
        if self.policy == ACCEPT:
            return max(0, len(heard) - 1)
        return sum(source is not self._followed for source in heard)

    @property
    def disputed(self) -> bool:
        """Whether nothing is taken because it is open which publisher is the first."""
        return self._disputed is not None

    def waits(self, now_ns: int) -> bool:
        """Return whether at `now_ns` only refused ones are heard, not the one that is followed."""
        time_ns = now_ns + self._back
        return (self._followed is not None and time_ns - self._followed.heard > SILENT
                and any(source.refused for source in self._heard(time_ns)))

    def _time(self, now_ns: int) -> int:
        """Return `now_ns` as if the clock had never been set back."""
        self._back = max(self._back, self._latest - now_ns)
        self._latest = now_ns + self._back
        return self._latest

    def _heard(self, time_ns: int) -> list[HeardPublisher]:
        return [source for source in self._sources if time_ns - source.heard <= SILENT]

    def _is_ours(self, source: HeardPublisher | None, time_ns: int) -> bool:
        if source is None:
            self._sources.clear()
            self._dispute(time_ns)
            return False
        rivals = [rival for rival in self._heard(time_ns) if rival is not source]
        if self._followed is None:
            if self.disputed and rivals:
                self._disputed = time_ns
            if self._disputed is not None and time_ns - self._disputed <= SILENT:
                return False
            self._follow(source, time_ns)
        elif source is not self._followed:
            if source.refused or time_ns - self._followed.heard <= SILENT:
                return False
            self._follow(source, time_ns)  # the other one had ended before
        for rival in rivals:
            # It has spoken since we last did.
            if self.policy == REFUSE or not rival.refused and rival.born - self._since < FIRST:
                self._dispute(time_ns)
                return False
            rival.refused = True
        return True

    def _follow(self, source: HeardPublisher, time_ns: int) -> None:
        self._followed, self._since, self._disputed = source, time_ns, None
        source.refused = False

    def _dispute(self, time_ns: int) -> None:
        self.disputes += self._disputed is None
        self._followed, self._disputed = None, time_ns

    def _by_stamp(self, number: int, time_ns: int, stamp_ns: int) -> HeardPublisher | None:
        """
        Return the publisher of message `number` by its stamp, where the followed one is known.

        Numbers alone do not decide then. None: it is not known well enough yet.
        """
        followed = self._followed
        if (followed is None or self.policy != FOLLOW_FIRST or stamp_ns == 0
                or followed.messages < STEADY or time_ns - self._since < FIRST):
            return None
        candidates = [source for source in self._sources if source is not followed]
        exact = [source for source in candidates if source.last == number - 1]
        miss = followed.misses(number, stamp_ns)
        if miss <= 1.0 and not any(source.messages >= STEADY
                                   and source.misses(number, stamp_ns) < miss for source in exact):
            source = followed
        elif exact:
            source = exact[0]
        else:
            ahead = 0 < number - followed.last <= REACH
            source = _nearest(candidates, number) or self._new(number, time_ns)
            source.continues |= ahead and not source.messages and source.born == time_ns
        if source is not followed and source.continues:
            silent = time_ns - followed.heard
            if followed.heard > source.born:
                source.continues = False
            elif silent > max(HOLD, HOLD_STEPS * followed.step):
                self._sources.remove(source)  # its clock was set, or its rate
                source, followed.messages = followed, 0
        source.add_stamp(stamp_ns, number - source.last)
        source.last, source.heard = max(number, source.last), time_ns
        return source

    def _source_of(self, number: int, time_ns: int, stamp_ns: int) -> HeardPublisher | None:
        """Return the publisher of message `number`; None if that is ambiguous."""
        heard = self._heard(time_ns)
        silent = [source for source in self._sources if source not in heard]
        exact = [source for source in heard if source.last == number - 1]
        if len(exact) > 1:
            return None
        exact = exact or [source for source in silent if source.last == number - 1]
        if exact:
            source = exact[0]
        else:
            skipped = self._behind_a_skip(heard, number, time_ns)
            if skipped is not None:
                skipped.stamp = stamp_ns
                return skipped
            nearest = _nearest(heard, number) or _nearest(silent, number)
            if nearest is None:
                return self._new(number, time_ns)
            source = nearest
            if any(rival is not source and -NEAR <= number - rival.last <= REACH
                   for rival in heard):
                return None
            source.last_before_skip, source.skipped = source.last, time_ns
        source.add_stamp(stamp_ns, number - source.last)
        source.last, source.heard = number, time_ns
        return source

    def _behind_a_skip(self, heard: list[HeardPublisher], number: int,
                       time_ns: int) -> HeardPublisher | None:
        """Return who continues before its apparent skip: another publisher sent that one."""
        for source in heard:
            if 0 < number - source.last_before_skip <= RETURN and number <= source.last and (
                    time_ns - source.skipped <= SILENT):
                self._new(source.last, time_ns)
                source.last, source.heard, source.skipped = number, time_ns, 0
                return source
        return None

    def _new(self, number: int, time_ns: int) -> HeardPublisher:
        if len(self._sources) == MAX_PUBLISHERS:
            self._sources.remove(min((s for s in self._sources if s is not self._followed),
                                     key=lambda s: s.heard))
        source = HeardPublisher(time_ns, number, time_ns)
        self._sources.append(source)
        return source


def _nearest(sources: list[HeardPublisher], number: int) -> HeardPublisher | None:
    """Return the publisher that `number` follows most closely, within REACH, or None."""
    candidates = [source for source in sources if 0 < number - source.last <= REACH]
    return max(candidates, key=lambda source: source.last, default=None)
