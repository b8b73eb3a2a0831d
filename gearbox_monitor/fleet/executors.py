# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Executors of tasks: in this process, in a pool of processes, on a Dask cluster.

All of them return TaskResults in order of completion. A pool consists of ProcessPoolExecutors of
one process each, so that the bag of a process that died is known, and a bag that exceeds its
limits ends one process only.
"""
from collections.abc import Callable
from concurrent.futures import CancelledError, FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
import contextlib
import ctypes
from dataclasses import dataclass, replace
import logging
import math
import multiprocessing
from multiprocessing import connection, forkserver
import os
from pathlib import Path
import queue
import resource
import signal
import threading
import time
from typing import Any, ClassVar, Protocol, TypeAlias

from gearbox_monitor.errors import InputError, installed_by

PRELOADED = 'gearbox_monitor.fleet.preload'
CONNECT_TIMEOUT = 10.0  # s to wait for a scheduler
SIZE_PERIOD = 5.0       # s between two queries for the size of a cluster
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
TRIM_BYTES, MMAP_BYTES = 1 << 27, 1 << 25  # values for these two
Work: TypeAlias = tuple[Any, Callable[..., Any], tuple[Any, ...]]  # task, function, arguments


@dataclass(frozen=True)
class TaskResult:
    """
    Result of `task`: `value`, or, if its worker died, None and the reason.

    given_up: another worker would not come further.
    """

    task: Any
    value: Any = None
    died: str = ''
    given_up: bool = False


class Executor(Protocol):
    """Runs tasks; attempts: number of workers that a task may kill before it is given up."""

    attempts: ClassVar[int]

    @property
    def free(self) -> bool:
        """Whether it can take a task."""

    def submit(self, task: Any, function: Callable[..., Any], *args: Any) -> None:
        """
        Take a task; only if `free`.

        Args:
            task: any object, returned with the result.
            function: what to call, for the value of the result.
            args: its arguments.
        """

    def results(self, timeout: float) -> list[TaskResult]:
        """Return the results since the last call; wait up to `timeout` s for one."""

    def close(self) -> None:
        """End the workers; tasks without a result are dropped."""


class SerialExecutor:
    """Runs each task in this process, when its result is requested."""

    attempts = 1

    def __init__(self) -> None:
        self._next: Work | None = None

    @property
    def free(self) -> bool:
        """Whether it has no task."""
        return self._next is None

    def submit(self, task: Any, function: Callable[..., Any], *args: Any) -> None:
        """Take the `task` function(*args), see Executor; `function` is called in `results`."""
        self._next = task, function, args

    def results(self, timeout: float) -> list[TaskResult]:
        """Run the task and return its result; `timeout` has no effect."""
        if self._next is None:
            return []
        task, function, args = self._next
        self._next = None
        return [TaskResult(task, function(*args))]

    def close(self) -> None:
        """Do nothing: there are no workers."""


@dataclass(frozen=True)
class _Worker:
    """A process and a future that is done, with its number, once it has started."""

    process: ProcessPoolExecutor
    started: 'Future[int]'


@dataclass(frozen=True)
class TaskLimits:
    """What one task of a pool may take: time (s) and memory (bytes) beyond that of the start."""

    seconds: float = math.inf
    memory: int = 0  # 0: no limit


@dataclass(frozen=True)
class _Run:
    """A task under way: its `work`, `worker` and the time it `began` (s, steady clock)."""

    work: Work
    worker: _Worker
    began: float


class PoolExecutor:
    """
    Pool of `workers` processes; a process that dies is reported and replaced.

    One whose task takes longer than the `limits` is killed; more memory it does not get.
    """

    attempts = 3
    MAX_START_FAILURES = 10  # in a row

    def __init__(self, workers: int, limits: TaskLimits = TaskLimits()) -> None:
        self._limits = limits
        methods = multiprocessing.get_all_start_methods()
        self._context: Any = multiprocessing.get_context(
            'forkserver' if 'forkserver' in methods else 'spawn')
        # Workers end when nobody holds the other end any more: also when this process is killed.
        self._ends, self._alive = self._context.Pipe(duplex=False)
        _start_server(self._context)
        self._start_failures = 0
        self._idle = [self._worker() for _ in range(workers)]
        self._running: dict[Future[Any], _Run] = {}
        self._late: set[Future[Any]] = set()  # their workers were killed

    def _worker(self) -> _Worker:
        process = ProcessPoolExecutor(1, self._context, _initialise,
                                      (self._ends, self._limits.memory))
        return _Worker(process, process.submit(os.getpid))

    @property
    def free(self) -> bool:
        """Whether a worker is idle."""
        return bool(self._idle)

    def submit(self, task: Any, function: Callable[..., Any], *args: Any) -> None:
        """Run the `task` `function`(*args) in an idle worker, see Executor; `args` are pickled."""
        worker = self._idle.pop()
        try:
            future = worker.process.submit(function, *args)
        except BrokenProcessPool:  # it died since its last task
            worker = self._worker()
            future = worker.process.submit(function, *args)
        self._running[future] = _Run((task, function, args), worker, time.monotonic())

    def results(self, timeout: float) -> list[TaskResult]:
        """
        Return the results since the last call; wait up to `timeout` s for one.

        Raises InputError if no process can be started.
        """
        done, pending = wait(self._running, timeout, FIRST_COMPLETED)
        for future in pending - self._late:
            run = self._running[future]
            if not run.worker.started.done():
                self._running[future] = replace(run, began=time.monotonic())
            elif time.monotonic() - run.began > self._limits.seconds:
                self._late.add(future)
                with contextlib.suppress(BrokenProcessPool, ProcessLookupError):
                    os.kill(run.worker.started.result(), signal.SIGKILL)
        return [result for future in done for result in self._results(future)]

    def _results(self, future: 'Future[Any]') -> list[TaskResult]:
        run = self._running.pop(future)
        (task, function, args), worker = run.work, run.worker
        try:
            result = TaskResult(task, future.result())
            self._start_failures = 0
        except MemoryError:
            result = TaskResult(task, died='out of memory (--max-memory)', given_up=True)
        except BrokenProcessPool:
            worker.process.shutdown(wait=False)
            self._idle.append(self._worker())
            if future in self._late:
                self._late.remove(future)
                return [TaskResult(task, died=f'took more than {self._limits.seconds:g} s '
                                   '(--max-seconds)', given_up=True)]
            if worker.started.exception() is None:
                return [TaskResult(task, died='the worker died (killed, or out of memory)')]
            self._start_failures += 1  # it died without its task
            if self._start_failures >= self.MAX_START_FAILURES:
                raise InputError(f'--workers: {self._start_failures} processes ended while they '
                                 'started, expected enough memory for them') from None
            self.submit(task, function, *args)
            return []
        self._idle.append(worker)
        return [result]

    def close(self) -> None:
        """End all workers at once; tasks without a result are dropped."""
        self._alive.close()
        for worker in [*self._idle, *(run.worker for run in self._running.values())]:
            worker.process.shutdown(wait=True, cancel_futures=True)


def _start_server(context: Any) -> None:
    """Start the process from which workers are forked; it loads the modules once for all."""
    if context.get_start_method() != 'forkserver':
        return
    context.set_forkserver_preload([PRELOADED])
    # Ctrl-C reaches every process of a terminal; this process ends its workers in order.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _initialise(ends: Any, memory: int) -> None:
    """
    Prepare a worker, which may take `memory` bytes more (0: any number).

    It ends when the other side of the pipe `ends` is closed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if memory:
        used = int(Path('/proc/self/statm').read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + memory, resource.RLIM_INFINITY))
    with contextlib.suppress(OSError, AttributeError):  # not glibc
        # Keep freed memory for the next bag: requesting it again costs some percent of the time.
        libc = ctypes.CDLL(None)
        libc.mallopt(M_TRIM_THRESHOLD, TRIM_BYTES)
        libc.mallopt(M_MMAP_THRESHOLD, MMAP_BYTES)

    def watch() -> None:
        connection.wait([ends])
        os._exit(1)
    threading.Thread(target=watch, daemon=True).start()


class DaskExecutor:
    """The Dask cluster with the scheduler at `address`. Raises InputError if there is none."""

    attempts = 1  # the scheduler itself gives a task to several workers

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client, KilledWorker
            from distributed.comm import get_address_host_port
        except ImportError:
            raise InputError('--scheduler: dask.distributed is not installed, expected '
                             f'{installed_by("fleet")}') from None
        for name in list(logging.Logger.manager.loggerDict):  # our messages say the same
            if name.startswith(('distributed', 'tornado')):
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        self.address, self._killed = address, KilledWorker
        try:
            get_address_host_port(address)  # a Client takes long to notice
            self._client: Any = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f'--scheduler: {address}: {" ".join(str(error).split())}, expected '
                             'the address of a running Dask scheduler, as tcp://host:8786') \
                from None
        self._running: dict[str, tuple[Any, Any]] = {}  # key: (task, future)
        self._done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._size, self._queried = 1, -SIZE_PERIOD

    def threads(self) -> int:
        """Return how many tasks can run at once. Raises InputError."""
        return sum(self._call(self._client.nthreads).values())

    @property
    def free(self) -> bool:
        """Whether the cluster can take another task."""
        if time.monotonic() >= self._queried + SIZE_PERIOD:
            # One task waits for each that runs, so that no worker is idle.
            self._size, self._queried = max(2 * self.threads(), 1), time.monotonic()
        return len(self._running) < self._size

    def submit(self, task: Any, function: Callable[..., Any], *args: Any) -> None:
        """Run the `task` `function`(*args) on the cluster, see Executor; `args` are pickled."""
        future = self._call(self._client.submit, function, *args, pure=False)
        self._running[future.key] = task, future
        future.add_done_callback(self._done.put)

    def results(self, timeout: float) -> list[TaskResult]:
        """Return the results since the last call; wait up to `timeout` s for one."""
        done: list[Any] = []
        with contextlib.suppress(queue.Empty):
            done.append(self._done.get(timeout=timeout))
            while True:
                done.append(self._done.get_nowait())
        if self._client.status != 'running':
            raise self._lost()
        finished = [future for future in done if future.status == 'finished']
        values = self._call(self._client.gather, finished) if finished else []
        results = [TaskResult(self._running.pop(future.key)[0], value)
                   for future, value in zip(finished, values)]
        return results + [self._failed(future) for future in done if future not in finished]

    def _failed(self, future: Any) -> TaskResult:
        task, _ = self._running.pop(future.key)
        error = self._call(future.exception)
        if isinstance(error, self._killed):
            return TaskResult(task, died=f'{error.allowed_failures + 1} workers died (killed, or '
                              'out of memory)')
        if isinstance(error, InputError):
            raise error
        raise InputError(f'--scheduler: {self.address}: a worker cannot run gearbox_monitor: '
                         f'{type(error).__name__} {" ".join(str(error).split())}')

    def _call(self, function: Callable[..., Any], *args: Any, **options: Any) -> Any:
        """Return function(...). Raises InputError if the scheduler is lost."""
        try:
            return function(*args, **options)
        except (OSError, TimeoutError, CancelledError):
            raise self._lost() from None

    def _lost(self) -> InputError:
        return InputError(f'--scheduler: {self.address}: the scheduler is lost; what is done is '
                          'kept, run the same command again to continue')

    def close(self) -> None:
        """Disconnect; tasks without a result are dropped."""
        with contextlib.suppress(OSError, TimeoutError, CancelledError):  # it was lost
            if self._client.status == 'running':
                self._client.cancel([future for _, future in self._running.values()])
            self._client.close(timeout=1.0)
