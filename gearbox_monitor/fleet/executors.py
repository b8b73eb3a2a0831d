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
Where bags are worked on: in this process, in a pool of processes, on a Dask cluster.

All take tasks and give TaskResults back in the order they are ready. A pool is made of
ProcessPoolExecutors of one process each: when a process dies, it is known which bag it had.
"""
from concurrent.futures import CancelledError, FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
import ctypes
from dataclasses import dataclass
import logging
import multiprocessing
from multiprocessing import connection, forkserver
import os
import queue
import signal
import threading
import time

from gearbox_monitor.errors import InputError

PRELOADED = 'gearbox_monitor.fleet.preload'
ANSWER = 10.0  # s to wait for a scheduler
AGAIN = 5.0    # s between two looks at the size of a cluster
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
KEPT, LARGEST = 1 << 27, 1 << 25  # bytes


@dataclass(frozen=True)
class TaskResult:
    """What `task` gave: `value`, or, where its worker died, None and the reason."""

    task: object
    value: object = None
    died: str = ''


class SerialExecutor:
    """Works on each task in this process, when its result is asked for."""

    attempts = 1
    free = True

    def __init__(self):
        self._next = None

    def submit(self, task, function, *args):
        """Take a task, when `free`."""
        self._next, self.free = (task, function, args), False

    def results(self, timeout):
        """Return the TaskResults that are ready, after `timeout` s perhaps none."""
        task, function, args = self._next
        self.free = True
        return [TaskResult(task, function(*args))]

    def close(self):
        """End; what has no TaskResult yet is dropped."""


class PoolExecutor:
    """`workers` processes; a TaskResult says so when one died, and another takes its place."""

    attempts = 3  # a bag is given to so many workers that die with it
    STARTS = 10   # in a row that fail, before it is said that none can start

    def __init__(self, workers):
        methods = multiprocessing.get_all_start_methods()
        self._context = multiprocessing.get_context(
            'forkserver' if 'forkserver' in methods else 'spawn')
        # Workers end when nobody holds the other end any more: also when this process is killed.
        self._ends, self._alive = self._context.Pipe(duplex=False)
        _start_server(self._context)
        self._failed = 0
        self._idle = [self._worker() for _ in range(workers)]
        self._running = {}

    def _worker(self):
        """Return (executor, future that is done once its process has started)."""
        executor = ProcessPoolExecutor(1, self._context, _begin, (self._ends,))
        return executor, executor.submit(os.getpid)

    @property
    def free(self):
        """Whether a worker has nothing to do."""
        return bool(self._idle)

    def submit(self, task, function, *args):
        """Take a task, when `free`."""
        executor, started = self._idle.pop()
        try:
            future = executor.submit(function, *args)
        except BrokenProcessPool:  # it died since its last task
            executor, started = self._worker()
            future = executor.submit(function, *args)
        self._running[future] = (task, function, *args), executor, started

    def results(self, timeout):
        """
        Return the TaskResults that are ready, after `timeout` s perhaps none.

        Raises InputError when no process can be started.
        """
        ready, _ = wait(self._running, timeout, FIRST_COMPLETED)
        return [result for future in ready for result in self._results(future)]

    def _results(self, future):
        work, executor, started = self._running.pop(future)
        try:
            result = TaskResult(work[0], future.result())
            self._failed = 0
        except BrokenProcessPool:
            executor.shutdown(wait=False)
            self._idle.append(self._worker())
            if started.exception() is None:
                return [TaskResult(work[0], died='the worker died (killed, or out of memory)')]
            self._failed += 1  # before it had its task
            if self._failed >= self.STARTS:
                raise InputError(f'--workers: {self._failed} processes ended while they started, '
                                 'expected enough memory for them') from None
            self.submit(*work)
            return []
        self._idle.append((executor, started))
        return [result]

    def close(self):
        """End all workers at once; what has no TaskResult yet is dropped."""
        self._alive.close()
        executors = [executor for executor, _ in self._idle]
        for executor in executors + [executor for _, executor, _ in self._running.values()]:
            executor.shutdown(wait=True, cancel_futures=True)


def _start_server(context):
    """Start the process that workers are forked from: modules are loaded once for all of them."""
    if context.get_start_method() != 'forkserver':
        return
    context.set_forkserver_preload([PRELOADED])
    # Ctrl-C reaches every process of a terminal; workers are ended by this one, in order.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(ends):
    """Prepare a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        # Freed memory is kept for the next bag: to get it anew costs some percent of the time.
        libc = ctypes.CDLL(None)
        libc.mallopt(M_TRIM_THRESHOLD, KEPT)
        libc.mallopt(M_MMAP_THRESHOLD, LARGEST)
    except (OSError, AttributeError):
        pass  # not glibc

    def watch():
        connection.wait([ends])
        os._exit(1)
    threading.Thread(target=watch, daemon=True).start()


class DaskExecutor:
    """The Dask cluster with the scheduler at `address`. Raises InputError where there is none."""

    attempts = 1  # the scheduler itself gives a task to several workers

    def __init__(self, address):
        try:
            from distributed import Client, KilledWorker
            from distributed.comm import get_address_host_port
        except ImportError:
            raise InputError('--scheduler: dask.distributed is not installed, expected what '
                             '"pip install gearbox_monitor[fleet]" brings') from None
        for name in list(logging.Logger.manager.loggerDict):  # what they would say, we say
            if name.startswith(('distributed', 'tornado')):
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        self.address, self._killed = address, KilledWorker
        try:
            get_address_host_port(address)  # a Client takes long to notice
            self._client = Client(address, timeout=ANSWER, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f'--scheduler: {address}: {" ".join(str(error).split())}, expected '
                             'the address of a running Dask scheduler, as tcp://host:8786') \
                from None
        self._running, self._ready = {}, queue.SimpleQueue()
        self._size, self._looked = 1, -AGAIN

    def threads(self):
        """Return how many tasks can run at once now. Raises InputError."""
        return sum(self._called(self._client.nthreads).values())

    @property
    def free(self):
        """Whether there are fewer tasks than the cluster can take."""
        if time.monotonic() >= self._looked + AGAIN:
            # One waits for each that runs, so that none is idle.
            self._size, self._looked = max(2 * self.threads(), 1), time.monotonic()
        return len(self._running) < self._size

    def submit(self, task, function, *args):
        """Take a task, when `free`."""
        future = self._called(self._client.submit, function, *args, pure=False)
        self._running[future.key] = task, future
        future.add_done_callback(self._ready.put)

    def results(self, timeout):
        """Return the TaskResults that are ready, after `timeout` s perhaps none."""
        ready = []
        try:
            ready.append(self._ready.get(timeout=timeout))
            while True:
                ready.append(self._ready.get_nowait())
        except queue.Empty:
            pass
        if self._client.status != 'running':
            raise self._lost()
        good = [future for future in ready if future.status == 'finished']
        values = self._called(self._client.gather, good) if good else []
        results = [TaskResult(self._running.pop(future.key)[0], value)
                   for future, value in zip(good, values)]
        return results + [self._failed(future) for future in ready if future not in good]

    def _failed(self, future):
        task, _ = self._running.pop(future.key)
        error = self._called(future.exception)
        if isinstance(error, self._killed):
            return TaskResult(task, died=f'{error.allowed_failures + 1} workers died (killed, or '
                              'out of memory)')
        if isinstance(error, InputError):
            raise error
        raise InputError(f'--scheduler: {self.address}: a worker cannot run gearbox_monitor: '
                         f'{type(error).__name__} {" ".join(str(error).split())}')

    def _called(self, function, *args, **options):
        """Return function(...). Raises InputError when the scheduler is gone."""
        try:
            return function(*args, **options)
        except (OSError, TimeoutError, CancelledError):
            raise self._lost() from None

    def _lost(self):
        return InputError(f'--scheduler: {self.address}: the scheduler is lost; what is done is '
                          'kept, the same command goes on from there')

    def close(self):
        """End; what has no TaskResult yet is dropped."""
        try:
            if self._client.status == 'running':
                self._client.cancel([future for _, future in self._running.values()])
            self._client.close(timeout=1.0)
        except (OSError, TimeoutError, CancelledError):
            pass  # it was lost
