# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Progress: a bar at a terminal or in a notebook; where none is shown, a line every 10 s."""
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
import os
import sys
import threading
import time
from typing import Any, ClassVar

from tqdm import tqdm

EVERY = 10.0  # s between the lines where no bar is shown
FORM = '{desc} {percentage:3.0f} %|{bar:20}| {elapsed}'
Progress = Callable[..., object]  # called with (done, total, text)


class Bar(tqdm):
    """A bar at a terminal or in a notebook; elsewhere it counts for the lines of shown_time."""

    shown: ClassVar[list['Bar']] = []
    timed: ClassVar[int] = 0  # shown_time that run

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.begun_at = self.n
        Bar.shown.append(self)

    def update(self, n: float | None = 1) -> bool | None:
        """Count `n` more."""
        if self.disable:
            self.n += n or 0
        return super().update(n)

    def close(self) -> None:
        """End it."""
        Bar.shown = [bar for bar in Bar.shown if bar is not self]  # tqdm's are equal by place
        super().close()

    def state(self) -> str:
        """Return how much is done, '' at first."""
        return f'{100.0 * self.n / self.total:.0f} %, ' if self.n > self.begun_at else ''


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
    return Bar(total=total, initial=initial, desc=name, leave=False,
               disable=False if 'ipykernel' in sys.modules else None,
               bar_format=FORM, ncols=columns, nrows=rows)


def _screen() -> tuple[int, int] | tuple[None, None]:
    """Return a size for a terminal that does not know its own, where tqdm would draw nothing."""
    try:
        sized = all(os.get_terminal_size(sys.stderr.fileno()))
    except OSError:
        sized = True
    return (None, None) if sized else (80, 24)


@contextmanager
def shown_time(command: str) -> Iterator[None]:
    """Let the time of the bars of `command` go on at a terminal; without one, write lines."""
    terminal, begin, ended = sys.stderr, time.monotonic(), threading.Event()

    def show() -> None:
        next_line = EVERY
        while not ended.wait(min(EVERY, 0.5)):
            elapsed = time.monotonic() - begin
            if any(not bar.disable for bar in Bar.shown):
                for bar in list(Bar.shown):
                    bar.refresh()
            elif elapsed >= next_line:
                next_line += EVERY
                state = ''.join(bar.state() for bar in Bar.shown[-1:])
                with suppress(OSError, ValueError):  # its reader has ended
                    print(f'{command}: {state}running for {elapsed:.0f} s', file=terminal,
                          flush=True)
    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    Bar.timed += 1
    try:
        yield
    finally:
        Bar.timed -= 1
        ended.set()
        thread.join()


@contextmanager
def reported(name: str, progress: Progress | None) -> Iterator[Progress]:
    """
    Yield the function that takes the progress of a computation: the user's, a bar or lines.

    Args:
        name: of the computation.
        progress: of the user, None to show it here.
    """
    if progress is not None:
        yield progress
        return
    with nullcontext() if Bar.timed else shown_time(name), progress_bar(name) as show:
        yield show
