# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Map `analyse` over bags, on processes of this machine or a Dask cluster; robots bag by bag.

The result of a bag of a robot depends on earlier bags: they are analysed one after the other, in
order of time, as `watch` does; robots side by side. If a bag has changed, all later ones are
analysed again.
"""
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor)
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
import hashlib
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

from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.fleet import job
from gearbox_monitor.fleet.fleet_table import FleetFolder
from gearbox_monitor.fleet.job import FleetBag, JobSettings, name_of, RobotBag
from gearbox_monitor.recordings.read import natural
from gearbox_monitor.recordings.reading import open_recording

TICK = 0.2  # s between two checks whether to stop
CONNECT_TIMEOUT = 10.0  # s to wait for a scheduler
DIED = 'its worker died (killed, or out of memory)'
# workers -> executor
Workers: TypeAlias = Callable[[int], AbstractContextManager[Executor]]
Results: TypeAlias = Iterator[tuple[FleetBag, job.Row]]


def run(bags: Sequence[FleetBag], settings: JobSettings, executor: Workers, workers: int,
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


def _done(executor: Executor, bags: Sequence[FleetBag], settings: JobSettings,
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
    # Workers are forked from a process that has imported the modules of a run.
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


def robot_bags(bags: Iterable[FleetBag], pattern: str) -> list[RobotBag]:
    """Return bags in order of time, of robots that `pattern` or a folder names (JobSettings)."""
    out, last = [], dict[str, str]()     # {robot: fingerprint of its bags so far}
    for bag in sorted(bags, key=lambda bag: (_start(bag), natural(bag.path))):
        try:
            robot, _ = name_of(Path(bag.path), '', '', pattern)
        except InputError:
            robot = ''      # its row will say it
        prints = f'{last.get(robot, "")} {bag.path} {bag.fingerprint}'.encode(
            'utf-8', 'surrogateescape')
        fingerprint = hashlib.sha256(prints).hexdigest()[:16]
        if not bag.problem:
            last[robot] = fingerprint
        out.append(RobotBag(bag.path, bag.bytes, fingerprint, bag.problem, bag.root, robot))
    return out


def _start(bag: FleetBag) -> int:
    """Return when a `bag` begins, ns, 0 if it does not say it."""
    try:
        with open_recording(Path(bag.path)) as reader:
            return reader.start_ns or 0
    except (InputError, OSError):
        return 0


def pending_of(bags: Sequence[RobotBag], folder: FleetFolder, key: str) -> list[RobotBag]:
    """
    Return those of `bags` that are to be analysed, the first of each robot with what is known.

    Args:
        bags: of robot_bags.
        folder: of this or an earlier run.
        key: of the settings.
    """
    out = [bag for bag in bags if bag.problem]
    for robot in dict.fromkeys(bag.robot for bag in bags):
        own = [bag for bag in bags if bag.robot == robot and not bag.problem]
        done = next((k for k, bag in enumerate(own) if not folder.has(bag, key)), len(own))
        state = folder.state(own[done - 1], key) if done else b''
        if state is None and done < len(own):
            done, state = 0, b''    # what the bags taught is lost
        out += [replace(bag, state=state or b'') for bag in own[done:done + 1]] + own[done + 1:]
    return out


def run_robots(bags: Sequence[RobotBag], settings: JobSettings, executor: Workers, workers: int,
               stop: Callable[[], bool] = lambda: False) -> Results:
    """
    Yield (bag, row) of `bags` of pending_of, as they are done.

    `settings`, `executor`, `workers` and `stop` are those of `run`. After a bag that is to be
    tried again, the others of its robot wait for the next run.
    """
    yield from run([bag for bag in bags if bag.problem], settings, executor, workers, stop)
    waiting: dict[str, list[RobotBag]] = {}
    for bag in bags:
        if not bag.problem:
            waiting.setdefault(bag.robot, []).append(bag)
    while waiting and not stop():
        known: dict[str, bytes] = {}
        for done, row in run([own[0] for own in waiting.values()], settings, executor, workers,
                             stop):
            assert isinstance(done, RobotBag)
            if not row['retry']:
                known[done.robot] = row['state']
            yield done, row
        waiting = {robot: [replace(own[1], state=known[robot]), *own[2:]]
                   for robot, own in waiting.items() if robot in known and own[1:]}
