# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Analyse many bags, each once; analyse a bag again only if it or the settings have changed.

Bags of one size may be copies of each other: their content is hashed before one of them is
analysed. A bag of a size that no other has is read once only.
"""
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gearbox_monitor import __version__
from gearbox_monitor.fleet import job
from gearbox_monitor.fleet.executors import Executor, TaskResult
from gearbox_monitor.fleet.fleet_table import FleetTable
from gearbox_monitor.fleet.paths import FleetBag

TICK = 0.2  # s between two checks whether to stop


@dataclass
class _Task:
    """A bag to analyse, its content once hashed, and how many workers died with it."""

    bag: FleetBag
    content: str = ''
    deaths: int = 0


class FleetRun:
    """
    One run over many bags.

    Args:
        bags: the bags.
        settings: under which all of them are analysed.
        table: the rows of earlier runs; results are added to it.

    Attributes: `counts`, {'done', 'failed', 'duplicate', 'skipped': int}; `pending`, number of
    bags to analyse at the start.
    """

    def __init__(self, bags: Sequence[FleetBag], settings: job.JobSettings, table: FleetTable
                 ) -> None:
        self.settings, self.table = settings, table
        self.key = settings.key
        self.counts = Counter(done=0, failed=0, duplicate=0, skipped=0)
        self._analyse: deque[_Task] = deque()
        self._hash: deque[_Task] = deque()
        self._running = 0
        tasks = [_Task(bag) for bag in bags if not table.finished(bag, self.key)]
        self.pending = len(tasks)
        self.counts['skipped'] = len(bags) - len(tasks)
        self._unreadable = [task for task in tasks if task.bag.problem]
        tasks = [task for task in tasks if not task.bag.problem]
        sizes = Counter(task.bag.size for task in tasks)
        self._same_size: dict[int | None, list[_Task]] = {}  # until all of a size are hashed
        self._unhashed: Counter[int | None] = Counter()
        for task in tasks:
            size = task.bag.size
            if size is None or size > 0 and (sizes[size] > 1 or table.has_size(size, self.key)):
                self._hash.append(task)
                self._same_size.setdefault(size, []).append(task)
                self._unhashed[size] += 1
            else:
                self._analyse.append(task)

    def run(self, executor: Executor, stop: Callable[[], bool] = lambda: False,
            progress: Callable[[], object] = lambda: None) -> bool:
        """
        Analyse the bags.

        Args:
            executor: runs the tasks.
            stop: returns whether to stop.
            progress: called once for each bag.

        Returns:
            Whether all bags are done.

        Raises:
            InputError: nothing can be written any more, or the scheduler is lost.
        """
        for task in self._unreadable:
            self._failed(task, task.bag.problem)
            progress()
        while self._analyse or self._hash or self._running:
            while (self._analyse or self._hash) and executor.free:
                self._start(executor)
            for result in executor.results(TICK):
                self._running -= 1
                done = sum(self.counts.values())
                self._take(result, executor.attempts)
                for _ in range(sum(self.counts.values()) - done):
                    progress()
            if stop():
                return False
        return True

    def _start(self, executor: Executor) -> None:
        self._running += 1
        if self._analyse:
            task = self._analyse.popleft()
            executor.submit((task, False), job.analyse, task.bag.url, self.settings)
        else:
            task = self._hash.popleft()
            executor.submit((task, True), job.digest, task.bag.url)

    def _take(self, result: TaskResult, attempts: int) -> None:
        task, hashed = result.task
        if result.died:
            task.deaths += 1
            if task.deaths < attempts and not result.given_up:
                (self._hash if hashed else self._analyse).appendleft(task)
                return
            times = f', {task.deaths} times' if task.deaths > 1 else ''
            self._failed(task, f'{result.died}{times}', attempts=task.deaths)
        elif not hashed:
            row, windows = result.value
            self._put(task, row, windows if row['status'] == 'done' else None)
        else:
            task.content, reason = result.value
            if reason:
                self._failed(task, reason)
        if hashed:
            self._compare(task.bag.size)

    def _failed(self, task: _Task, reason: str, **columns: Any) -> None:
        """Write the row of a bag that is to be tried again."""
        self._put(task, {'status': 'failed', 'retry': True,
                         'reason': f'{task.bag.url}: {reason}', **columns})

    def _put(self, task: _Task, row: job.Row, windows: list[job.Window] | None = None) -> None:
        bag = task.bag
        self.table.put({'version': __version__, 'attempts': task.deaths + 1, **row,
                        'path': bag.url, 'bytes': bag.size, 'fingerprint': bag.fingerprint,
                        'settings': self.key}, windows)
        self.counts[row['status']] += 1

    def _compare(self, size: int | None) -> None:
        """Separate copies and originals once all bags of one size are hashed."""
        self._unhashed[size] -= 1
        if self._unhashed[size]:
            return
        originals: dict[str, str] = {}  # content: url
        for task in self._same_size.pop(size):
            if not task.content:  # it could not be read
                continue
            row = self.table.of_content(task.content, self.key)
            if row is not None and row['path'] == task.bag.url:  # its files were touched
                self.table.put({**row, 'fingerprint': task.bag.fingerprint})
                self.counts['skipped'] += 1
                continue
            original = row['path'] if row else originals.setdefault(task.content, task.bag.url)
            if original == task.bag.url:
                self._analyse.append(task)
            else:
                self._put(task, {'status': 'duplicate', 'duplicate_of': original,
                                 'content': task.content})
