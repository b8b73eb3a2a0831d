# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Messages that were sent and never came, by the numbers that their publisher gives them."""
from collections.abc import Mapping


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
