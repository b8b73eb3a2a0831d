# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the numbers of messages tell: two publishers of one joint, and lost messages.

A message does not name its publisher, but each publisher numbers its messages upwards. A number
that does not exceed the previous one comes from another publisher. Once, that is a restart; when
it happens again soon, two publishers deliver. An endpoint that delivers nothing shows no number.
"""
from collections.abc import Mapping

SECOND = 1_000_000_000
RECENT = 2 * SECOND   # ns between two changes of publisher that are no restart; a rival that sends
#                       less often than this is not recognised
HOLD = SECOND // 4    # ns without a sample after a change: a rival would show up meanwhile


class JointPublishers:
    """
    Decides which messages with one joint on one topic are taken.

    None is taken while two publishers deliver the joint, and until one of them has been silent for
    RECENT. A middleware without numbers leaves nothing to decide: all messages are taken then.
    changes: how often another publisher took over, or joined.
    """

    def __init__(self) -> None:
        self.changes = 0
        self._last = 0  # number of the previous message
        self._changed_ns: int | None = None
        self._are_two = False

    def admit(self, number: int | None, now_ns: int) -> bool:
        """
        Return whether to take a message.

        Args:
            number: that its publisher gave it, from 1 on; None: not numbered.
            now_ns: when it was received, ns, by a clock that may be set.

        """
        if not number:
            return True
        if number <= self._last:
            self._are_two = self._changed_within(RECENT, now_ns)
            self.changes += not self._are_two
            self._changed_ns = now_ns
        self._last = number
        return not (self.are_two(now_ns) or self._changed_within(HOLD, now_ns))

    def are_two(self, now_ns: int) -> bool:
        """Return whether two publishers deliver the joint at `now_ns`."""
        return self._are_two and self._changed_within(RECENT, now_ns)

    def _changed_within(self, time_ns: int, now_ns: int) -> bool:
        """Return whether the publisher changed less than `time_ns` ago; not if a clock was set."""
        return self._changed_ns is not None and abs(now_ns - self._changed_ns) < time_ns


class MessageLossCounter:
    """
    Counts the missing messages of one publisher: `count` in all.

    DDS silently drops messages that do not fit into a full queue, and steps of the stamps do not
    show it if every second message is dropped. Each publisher numbers its messages from 1 on.
    """

    def __init__(self) -> None:
        self.count = 0
        self._next: int | None = None

    def forget(self) -> None:
        """Restart: messages that were not looked at are not lost."""
        self._next = None

    def add(self, info: Mapping[str, int | None], ours: bool) -> None:
        """Take the `info` of a message (rclpy); `ours`: the counted publisher has sent it."""
        number = info.get('publication_sequence_number')  # None: not every middleware numbers
        if number is None or not (ours or number == self._next):
            return  # the publisher of our joints may send other messages, too
        if self._next is not None and number > self._next:
            self.count += number - self._next
        self._next = number + 1
