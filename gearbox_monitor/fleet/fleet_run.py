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
Analyse many bags: each once, whatever dies, and again only when it or the settings have changed.

Bags of one size may be copies of each other: their content is hashed before one of them is
analysed. A bag of a size that no other has is read once only.
"""
from collections import Counter, deque
from dataclasses import dataclass

from gearbox_monitor import __version__
from gearbox_monitor.fleet import job

TICK = 0.2  # s between two looks at whether to stop


@dataclass
class _Task:
    """A paths.FleetBag on its way, its content once that is known, and how often a worker died."""

    bag: object
    content: str = ''
    deaths: int = 0


class FleetRun:
    """
    One run over `bags` (paths.FleetBag) with job.JobSettings, into a fleet_table.FleetTable.

    counts: {'done', 'failed', 'duplicate', 'skipped': int}. left: how many bags are to be done.
    """

    def __init__(self, bags, settings, table):
        self.settings, self.table, self.engine = settings, table, None
        self.key = settings.key
        self.counts = Counter(done=0, failed=0, duplicate=0, skipped=0)
        self._analyse, self._hash = deque(), deque()  # _Tasks
        self._running = 0
        todo = [_Task(bag) for bag in bags if not table.finished(bag, self.key)]
        self.left = len(todo)
        self.counts['skipped'] = len(bags) - len(todo)
        self._unreadable = [task for task in todo if task.bag.problem]
        todo = [task for task in todo if not task.bag.problem]
        sizes = Counter(task.bag.size for task in todo)
        self._alike = {}  # size: its _Tasks, until all of them are hashed
        self._unhashed = Counter()
        for task in todo:
            size = task.bag.size
            if size is None or size > 0 and (sizes[size] > 1 or table.has_size(size, self.key)):
                self._hash.append(task)
                self._alike.setdefault(size, []).append(task)
                self._unhashed[size] += 1
            else:
                self._analyse.append(task)

    def go(self, engine, stop=lambda: False, progress=lambda: None):
        """
        Let `engine` work until all is done or stop() is true; progress() is called for each bag.

        Returns whether all is done. Raises InputError where nothing can be written any more, or
        the scheduler is lost.
        """
        self.engine = engine
        for task in self._unreadable:
            self._failed(task, task.bag.problem)
            progress()
        while self._analyse or self._hash or self._running:
            while (self._analyse or self._hash) and self.engine.free:
                self._start()
            for result in self.engine.results(TICK):
                self._running -= 1
                before = sum(self.counts.values())
                self._take(result)
                for _ in range(sum(self.counts.values()) - before):
                    progress()
            if stop():
                return False
        return True

    def _start(self):
        self._running += 1
        if self._analyse:
            task = self._analyse.popleft()
            self.engine.submit((task, False), job.analyse, task.bag.url, self.settings)
        else:
            task = self._hash.popleft()
            self.engine.submit((task, True), job.digest, task.bag.url)

    def _take(self, result):
        task, hashed = result.task
        if result.died:
            task.deaths += 1
            if task.deaths < self.engine.attempts:
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

    def _failed(self, task, reason, **columns):
        """Write the row of a bag that another run may have more luck with."""
        self._put(task, {'status': 'failed', 'retry': True,
                         'reason': f'{task.bag.url}: {reason}', **columns})

    def _put(self, task, row, windows=None):
        bag = task.bag
        self.table.put({'version': __version__, 'attempts': task.deaths + 1, **row,
                        'path': bag.url, 'bytes': bag.size, 'fingerprint': bag.fingerprint,
                        'settings': self.key}, windows)
        self.counts[row['status']] += 1

    def _compare(self, size):
        """Sort out bags of one size once all of them are hashed."""
        self._unhashed[size] -= 1
        if self._unhashed[size]:
            return
        first = {}
        for task in self._alike.pop(size):
            if not task.content:  # it could not be read
                continue
            known = self.table.of_content(task.content, self.key)
            if known is not None and known['path'] == task.bag.url:  # its files were touched
                self.table.put({**known, 'fingerprint': task.bag.fingerprint})
                self.counts['skipped'] += 1
                continue
            original = known['path'] if known else first.setdefault(task.content, task.bag.url)
            if original == task.bag.url:
                self._analyse.append(task)
            else:
                self._put(task, {'status': 'duplicate', 'duplicate_of': original,
                                 'content': task.content})
