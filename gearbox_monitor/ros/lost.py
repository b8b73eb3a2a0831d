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

"""Messages that were sent and never came, by the numbers that their publisher gives them."""


class Lost:
    """
    Counts what is missing among the messages of one publisher: `count` in all.

    DDS drops without a word what does not fit into a full queue, and steps of the stamps do not
    show it where every second message is dropped. Numbers start anew with each publisher.
    """

    def __init__(self):
        self.count, self._next = 0, None

    def forget(self):
        """Begin anew: what was not looked at is not lost."""
        self._next = None

    def seen(self, info, ours):
        """Take the `info` of a message (rclpy); ours: it is of the publisher that is counted."""
        number = info.get('publication_sequence_number')  # None: the middleware has none
        if number is None or not (ours or number == self._next):
            return  # the publisher of our joints may send others, too
        if self._next is not None and number > self._next:
            self.count += number - self._next
        self._next = number + 1
