# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The watch of a robot in a process of its own, which gives way to all others: of watch_node.

Reads orders from the standard input, lines of JSON: a description, rows of joint states, names of
services. Writes what is known as lines of JSON, one for each block and order, and the state to a
file. Imports no ROS. It ends with its standard input.
"""
from collections import deque
from collections.abc import Iterable
import ctypes
import gc
import json
import os
from pathlib import Path
import signal
import sys
from typing import Any

from gearbox_monitor.ros.middleware import end_with

NICE, EVERY = 19, 9     # EVERY: blocks between two states in the file
EARLY = 15              # blocks that may wait for the description
SOURCE = 'robot_description'
DESCRIPTION, ROWS, SERVICES = 'description', 'rows', ('learn_again', 'tare', 'save_baseline')


class Watching:
    """A Watch, its state in the file `path`, and what collects its blocks."""

    def __init__(self, path: Path) -> None:
        from gearbox_monitor.errors import InputError
        from gearbox_monitor.files.knowledge_file import load_watch
        from gearbox_monitor.watch.record import Cutter, Watch
        self.path, self.problem = path, ''
        self.watch: Watch | None = None
        self.described, self.early = False, deque[Any](maxlen=EARLY)
        try:
            if path.exists():
                self.watch = load_watch(path)
        except InputError as error:
            self.problem = f'{error}: {self.aside("corrupt")}; the robot is learnt again'
        self.cutter = Cutter(self.watch.stamp_ns if self.watch else 0)

    def aside(self, reason: str) -> str:
        """Rename the state file for a `reason`; return what became of it."""
        from gearbox_monitor.errors import InputError
        from gearbox_monitor.files.baselines import set_aside
        try:
            return set_aside(self.path, reason)
        except InputError as error:
            return str(error)

    def take(self, order: str, content: Any) -> None:
        """Carry out an `order` with its `content`, and report the state after it."""
        from gearbox_monitor.errors import InputError
        from gearbox_monitor.watch import fold
        if order == DESCRIPTION:
            doubts: tuple[str, ...] = ()
            if self.watch is None or self.watch.description != content:
                if self.watch is not None and self.path.exists():
                    self.problem = (f'{self.path}: of another {SOURCE}: {self.aside("replaced")}; '
                                    'the robot is learnt again')
                try:
                    self.watch = fold.begin(content)
                    doubts = self.watch.doubts
                except InputError as error:
                    self.watch, self.problem = None, str(error)
            self.tell(doubts)
            self.described = self.watch is not None
            waiting, self.early = self.early, deque(maxlen=EARLY)
            self.blocks(waiting)
        elif order == ROWS:
            self.blocks([b for row in content for b in self.cutter.take(*row)])
        elif self.watch is not None:
            self.watch = getattr(fold, order)(self.watch)
            self.save()
            self.tell()

    def blocks(self, blocks: Iterable[Any]) -> None:
        """Go on with `blocks`; without a description the newest wait."""
        from gearbox_monitor.watch.fold import step
        for block in blocks:
            if self.watch is None or not self.described:
                self.early.append(block)
            else:
                before = self.watch
                self.watch, events = step(self.watch, block)
                self.tell(tuple(f'{e.place}: {e.words}' for e in events))
                if self.watch.phase != before.phase:    # what learning took goes back
                    gc.collect()
                    ctypes.CDLL(None).malloc_trim(0)
                if self.watch.phase != before.phase or self.watch.blocks % EVERY == 0:
                    self.save()

    def save(self) -> None:
        """Write the state; a failure becomes the `problem`."""
        from gearbox_monitor.errors import InputError
        from gearbox_monitor.files.knowledge_file import save_watch
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if self.watch is not None:
                save_watch(self.path, self.watch)
            self.problem = ''
        except (OSError, InputError) as error:
            self.problem = str(error)

    def tell(self, events: tuple[str, ...] = ()) -> None:
        """Write what is known, and the `events` that led to it, as a line."""
        from gearbox_monitor.report.watch_words import watch_data
        data = {} if self.watch is None else watch_data(self.watch)
        print(json.dumps({'data': data, 'events': events, 'dropped': self.cutter.dropped,
                          'problem': self.problem}), flush=True)


def main() -> int:
    """Watch until the standard input ends; then the last block is taken, too."""
    if not end_with(int(sys.argv[2]), signal.SIGKILL):
        return 1
    os.nice(NICE)
    watching = Watching(Path(sys.argv[1]))
    for line in sys.stdin:
        watching.take(*json.loads(line))
    watching.blocks(watching.cutter.end())
    watching.save()
    return 0


if __name__ == '__main__':
    sys.exit(main())
