# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Imported by the process that workers are forked from: loads what each bag needs, once for all.

A fresh process takes 1.3 s to import modules and 0.6 s to load kernels.
"""
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor)
from contextlib import AbstractContextManager, contextmanager
import logging
import multiprocessing
from multiprocessing import forkserver, resource_tracker
import os
from pathlib import Path
import queue
import resource
import signal
import threading
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.fleet import job
import gearbox_monitor.fleet.job  # noqa: F401
from gearbox_monitor.fleet.job import FleetBag
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate

PERIOD = 2e-3  # s
T = np.arange(0.0, 13.0, PERIOD)  # a window and its delay
RUN = simulate(DriveModel(), Excitation().torque(T), PERIOD)
MONITOR = Monitor(DriveModel())
MONITOR.run(Samples(np.round(T * 1e9).astype(np.int64), np.column_stack(
    [RUN.u, np.full(len(T), np.nan)]), RUN.y))
MONITOR.all_features()


TICK = 0.2  # s between two checks whether to stop
CONNECT_TIMEOUT = 10.0  # s to wait for a scheduler
DIED = 'its worker died (killed, or out of memory)'
# workers -> executor
Workers: TypeAlias = Callable[[int], AbstractContextManager[Executor]]
Results: TypeAlias = Iterator[tuple[FleetBag, job.Row]]


def run(bags: Sequence[FleetBag], settings: job.JobSettings, executor: Workers, workers: int,
        stop: Callable[[], bool] = lambda: False) -> Results:
    """
    Yield (bag, row) of each of the `bags`, as they are done.

    Args:
        bags: the bags.
        settings: under which all of them are analysed.
        executor: returns the context of an executor with so many workers, at_home or on_cluster.
        workers: number of bags that are analysed side by side at home.
        stop: returns whether to stop.

    Raises:
        InputError: the scheduler is lost.
    """
    unfinished: Sequence[FleetBag] = [bag for bag in bags if not bag.problem]
    yield from ((bag, job.failed(bag, settings, bag.problem)) for bag in bags if bag.problem)
    while unfinished and not stop():
        with executor(min(workers, len(unfinished))) as several:
            unfinished = yield from _done(several, unfinished, settings, stop)
        # A process died, and with it the pool. Bags begin in their order: it had one of the first,
        # which get a pool of their own each.
        for bag in unfinished[:workers]:
            with executor(1) as single:
                if not stop() and (yield from _done(single, [bag], settings, stop)):
                    yield bag, job.failed(bag, settings, DIED)
        unfinished = unfinished[workers:]


def _done(executor: Executor, bags: Sequence[FleetBag], settings: job.JobSettings,
          stop: Callable[[], bool]) -> Generator[tuple[FleetBag, job.Row], None, list[FleetBag]]:
    """Yield (bag, row) of those `bags` that are done; return those that a dead process left."""
    unfinished: list[FleetBag] = []
    bag_of: dict[Future[job.Row], FleetBag] = {}
    ended: queue.SimpleQueue[Future[job.Row]] = queue.SimpleQueue()
    for bag in bags:
        try:
            future = executor.submit(job.analyse, bag, settings)
        except BrokenExecutor:  # so early
            unfinished.append(bag)
        else:
            bag_of[future] = bag
            future.add_done_callback(ended.put)
    while bag_of and not stop():
        try:
            future = ended.get(timeout=TICK)
        except queue.Empty:
            continue
        bag = bag_of.pop(future)
        try:
            yield bag, future.result()
        except BrokenExecutor:
            unfinished.append(bag)
        except CancelledError:
            raise InputError('--scheduler: the scheduler is lost; what is done is kept, run the '
                             'same command again to continue') from None
        except Exception as error:  # of Dask: its workers died, or cannot run this package
            yield bag, job.failed(bag, settings, f'{type(error).__name__} '
                                  f'{" ".join(str(error).split())}')
    order = {bag.path: place for place, bag in enumerate(bags)}
    return sorted(unfinished, key=lambda bag: order[bag.path])


@contextmanager
def at_home(workers: int, memory: int = 0) -> Iterator[Executor]:
    """
    Give an executor of `workers` processes of this machine, which end with the block.

    memory: bytes that one bag may take, 0: any number.
    """
    context: Any = multiprocessing.get_context('forkserver')
    # Workers are forked from a process that has loaded all they need.
    context.set_forkserver_preload(['gearbox_monitor.fleet.fleet_run'])
    resource_tracker.ensure_running()  # or the server starts it, and unblocks SIGINT
    # Ctrl-C reaches every process of a terminal; this one ends the others in order.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    others = multiprocessing.active_children()
    executor = ProcessPoolExecutor(workers, context, _prepare, (memory,), max_tasks_per_child=1)
    try:
        yield executor
    finally:
        end = threading.Thread(target=executor.shutdown, kwargs={'cancel_futures': True})
        end.start()
        while end.is_alive():  # it waits for its processes, and may have just started another one
            for child in set(multiprocessing.active_children()).difference(others):
                child.kill()
            end.join(0.02)


def _prepare(memory: int) -> None:
    """Prepare a worker, which may take `memory` bytes more and ends with its parent."""
    if memory:
        used = int(Path('/proc/self/statm').read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + memory, resource.RLIM_INFINITY))
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)
    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def on_cluster(address: str) -> Iterator[Executor]:
    """Give the executor of the Dask cluster with the scheduler at `address`. Raises InputError."""
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError('--scheduler: dask.distributed is not installed, expected '
                         f'{installed_by("fleet")}') from None
    for name in list(logging.Logger.manager.loggerDict):  # our messages say the same
        if name.startswith(('distributed', 'tornado')):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        get_address_host_port(address)  # a Client takes long to notice
        client: Any = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(f'--scheduler: {address}: {" ".join(str(error).split())}, expected the '
                         'address of a running Dask scheduler, as tcp://host:8786') from None
    with client:
        yield client.get_executor(pure=False)
