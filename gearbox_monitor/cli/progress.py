# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Progress of a command: a bar or the elapsed time; without a terminal a line every 10 s."""
import bisect
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
import math
import os
import sys
import threading
import time
from typing import Any, cast, ClassVar, TextIO

from tqdm import tqdm

QUIET = 2.0  # s without a bar before the time is shown
EVERY = 10.0  # s between the lines where stderr is no terminal
EVEN = 3.0  # a half of the time passes a third to two thirds of the items: rates within 1 to 2
LATE = 1.5  # times an earlier answer: it is wrong; less than 2, as a rate has an error
FORM = '{desc} {percentage:3.0f} %|{bar:20}| {elapsed}{rest}'


class Bar(tqdm):
    """A bar at a terminal; elsewhere it counts for the lines of shown_time."""

    shown: ClassVar[list['Bar']] = []

    def __init__(self, **options: Any) -> None:
        self.steps = [(time.monotonic(), float(options.get('initial', 0)))]  # (s, items done)
        self.end = math.inf  # s, the earliest end that was shown
        super().__init__(**options)
        Bar.shown.append(self)

    def update(self, n: float | None = 1) -> bool | None:
        """Count `n` more."""
        if n:
            self.steps.append((time.monotonic(), self.steps[-1][1] + n))
        if self.disable:
            self.n += n or 0
        return super().update(n)

    def close(self) -> None:
        """End it."""
        Bar.shown = [bar for bar in Bar.shown if bar is not self]  # tqdm's are equal by place
        super().close()

    @property
    def format_dict(self) -> Any:
        """The values of FORM."""
        return {**super().format_dict, 'rest': self.rest()}

    def rest(self) -> str:
        """
        Return how long the rest takes, '' where that is not known within a factor of 2.

        It is known while both halves of the time passed the items at a similar rate, and while
        no earlier answer has turned out too short; a later answer is never a later end.
        """
        now = time.monotonic()
        (began, initial), (_, done) = self.steps[0], self.steps[-1]
        passed, elapsed, total = done - initial, now - began, float(self.total or 0)
        if not 0.1 * (total - initial) <= passed < total - initial:
            return ''
        place = bisect.bisect_right(self.steps, began + 0.5 * elapsed, key=lambda step: step[0])
        half = self.steps[place - 1][1] - initial
        left = elapsed * (total - done) / passed
        late = left > LATE * (self.end - now) + 1.0
        if late or not passed <= EVEN * half <= (EVEN - 1.0) * passed:
            return ''
        self.end = min(self.end, now + left)
        return f', about {max(self.end - now, 0.0):.0f} s left'

    def state(self) -> str:
        """Return how much is done and how long the rest takes; '' at first."""
        done = self.steps[-1][1]
        if done <= self.steps[0][1]:
            return ''
        return f'{100.0 * done / self.total:.0f} %{self.rest()}, '


@contextmanager
def progress_bar(name: str) -> Iterator[Callable[..., None]]:
    """
    Show a progress bar in percent, called `name`, while the block runs.

    Yields progress(done, total, text), which moves the bar, never back.
    """
    with count_bar(name, 100) as bar:
        def progress(done: float, total: float, text: str = '') -> None:
            """Show the share of `done` in `total`, and `text`."""
            if text:
                bar.set_description_str(text[:40], refresh=False)
            bar.update(max(0.0, 100.0 * done / max(total, 1) - bar.n))
        yield progress


def count_bar(name: str, total: int, initial: int = 0) -> 'tqdm[None]':
    """
    Return a progress bar.

    Args:
        name: of the activity.
        total: number of items.
        initial: number of items that are done already.

    """
    columns, rows = _screen()
    return Bar(total=total, initial=initial, desc=name, disable=None, leave=False,
               bar_format=FORM, ncols=columns, nrows=rows)


def _screen() -> tuple[int, int] | tuple[None, None]:
    """Return a size for a terminal that does not know its own, where tqdm would draw nothing."""
    try:
        sized = all(os.get_terminal_size(sys.stderr.fileno()))
    except OSError:
        sized = True
    return (None, None) if sized else (80, 24)


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


class ElapsedTime:
    """The line with the elapsed time at a terminal; whoever writes to the terminal clears it."""

    def __init__(self, command: str, terminal: TextIO) -> None:
        """Show on `terminal` how long `command` has been running."""
        self._command, self._terminal = command, terminal
        self._begin, self._shown, self._lock = time.monotonic(), False, threading.Lock()

    def show(self) -> None:
        """Write the time, or refresh that of the bars: a step may take long."""
        bars = list(getattr(tqdm, '_instances', ()))
        for bar in bars:  # not under the lock: a bar has its own, and clears this line
            bar.refresh()
        with self._lock:
            self._shown = not bars
            if self._shown:
                seconds = round(time.monotonic() - self._begin)
                self._terminal.write(f'\r{self._command}: running for {seconds} s')
                self._terminal.flush()

    def clear(self) -> None:
        """Clear the line, if it is shown."""
        with self._lock:
            if self._shown:
                self._terminal.write('\r\x1b[K')
                self._terminal.flush()
            self._shown = False


class ClearedStream:
    """The text stream `stream` of a terminal from which `line` is cleared before each output."""

    def __init__(self, stream: TextIO, line: ElapsedTime) -> None:
        self._stream, self._line = stream, line

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Clear the line and write `text`."""
        self._line.clear()
        return self._stream.write(text)


@contextmanager
def shown_time(command: str) -> Iterator[None]:
    """Show how long `command` has been running, at a terminal while it shows no bar."""
    terminal, output, begin = sys.stderr, sys.stdout, time.monotonic()
    if not terminal.isatty():
        def write() -> None:
            state = ''.join(bar.state() for bar in Bar.shown[-1:])
            with suppress(OSError, ValueError):  # its reader has ended
                print(f'{command}: {state}running for {time.monotonic() - begin:.0f} s',
                      file=terminal, flush=True)
        with _repeated(write, EVERY, EVERY):
            yield
        return
    line = ElapsedTime(command, terminal)
    try:
        with _repeated(line.show, QUIET, 1.0):
            sys.stderr = cast(TextIO, ClearedStream(terminal, line))
            if output.isatty():
                sys.stdout = cast(TextIO, ClearedStream(output, line))
            yield
    finally:
        line.clear()
        sys.stderr, sys.stdout = terminal, output


@contextmanager
def _repeated(action: Callable[[], None], first: float, every: float) -> Iterator[None]:
    """Call `action` after `first` s and then once in `every` s, until the block ends."""
    ended = threading.Event()

    def repeat() -> None:
        pause = first
        while not ended.wait(pause):
            action()
            pause = every

    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
