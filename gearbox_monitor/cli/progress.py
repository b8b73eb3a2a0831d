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
Progress of a command at a terminal: a bar, or the elapsed time without one.

Nothing is shown where stderr is no terminal.
"""
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import sys
import threading
import time
from typing import Any

from tqdm import tqdm

QUIET = 2.0  # s without a bar before the time is shown
FORM = '{desc} {percentage:3.0f} %|{bar:20}| {elapsed}, {remaining} left'


def percent_bar(name: str) -> 'tqdm[None]':
    """Return a progress bar in percent, called `name`."""
    return count_bar(name, 100)


def count_bar(name: str, total: int, initial: int = 0) -> 'tqdm[None]':
    """
    Return a progress bar.

    Args:
        name: of the activity.
        total: number of items.
        initial: number of items that are done already.

    """
    return tqdm(total=total, initial=initial, desc=name, disable=None, leave=False,
                bar_format=FORM)


def progress_of(bar: 'tqdm[None]') -> Callable[..., None]:
    """Return progress(done, total, text) that moves `bar`, never back."""
    def progress(done: float, total: float, text: str = '') -> None:
        """Show the share of done in total, and text."""
        if text:
            bar.set_description_str(text[:40], refresh=False)
        bar.update(max(0.0, 100.0 * done / max(total, 1) - bar.n))
    return progress


class Progress:
    """Takes the parts of a Player and moves a progress bar."""

    topics: tuple[str, ...] = ()

    def __init__(self, bar: 'tqdm[None]') -> None:
        """Move `bar`."""
        self._bar = bar

    def add(self, part: Any) -> None:
        """Take a `part` of the recording."""
        self._bar.update(len(part.samples.stamp_ns))

    def finish(self) -> None:
        """Leave the bar to its owner."""


@contextmanager
def shown_time(command: str) -> Iterator[None]:
    """Show at a terminal how long `command` has been running while it shows no bar."""
    if not sys.stderr.isatty():
        yield
        return
    ended, begin = threading.Event(), time.monotonic()

    def show() -> None:
        """Write the time once per second, and clear the line at the end."""
        shown = False
        while not ended.wait(QUIET if not shown else 1.0):
            shown = not getattr(tqdm, '_instances', ())
            if shown:
                seconds = round(time.monotonic() - begin)
                sys.stderr.write(f'{command}: running for {seconds} s\r')
                sys.stderr.flush()
        if shown:
            sys.stderr.write('\r' + ' ' * 60 + '\r')

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
