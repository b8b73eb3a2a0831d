# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Map `analyse` over bags, on processes of this machine or a Dask cluster; robots bag by bag.

The result of a bag of a robot depends on earlier bags: they are analysed one after the other, in
order of time, as `watch` does; robots side by side. If a bag has changed, all later ones are
analysed again.

Of each gearbox the bags, in order of time, are folded into one Health. The windows of a bag are
those that its replay judged, in the same way as the live node. So a jump between two bags is a
jump, all features are watched, and dates agree with the node.
"""
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import (
    BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor)
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
import hashlib
import json
import logging
import math
import multiprocessing
from multiprocessing import forkserver, resource_tracker
import os
from pathlib import Path
import queue
import resource
import signal
import socket
import threading
from typing import Any, TypeAlias
from uuid import uuid4

import pyarrow as pa
from pyarrow import dataset, parquet

from gearbox_monitor.errors import InputError, installed_by, refusal
from gearbox_monitor.fleet import job
from gearbox_monitor.fleet.job import FleetBag, JobSettings, name_of, RobotBag, Row
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.backlash.change_tests import FEATURES, MEASURED
from gearbox_monitor.health.health_record import HealthSettings
from gearbox_monitor.health.judgement import (
    CLASSES, figures, folded, from_data as health_from, Health, sentence, serviced)
from gearbox_monitor.plain_data import from_data
from gearbox_monitor.recordings.read import natural
from gearbox_monitor.recordings.reading import open_recording
from gearbox_monitor.report.sentences import say
from gearbox_monitor.watch.record import WATCH

Services = Mapping[str, Sequence[tuple[int, str]]]  # gearbox: (stamp in ns, note) of each service
COPIED = ('trust', 'model_level', 'not_excited', 'unit')  # of the newest bag


def gearboxes(rows: Iterable[Row], services: Services | None = None) -> list[dict[str, Any]]:
    """
    Return the history of each gearbox as plain data, the most urgent first.

    Args:
        rows: of the table of bags (SCHEMA).
        services: of the gearboxes; a new baseline begins with each.

    Returns:
        Dicts: gearbox, level (None: nothing is compared), summary, the `figures` of its health;
        unit, bags (analysed), first, last (ns), trust, model_level, not_excited; points: of each
        bag that shows a feature, {start (ns), means {feature: (mean, deviation)}, changes
        {feature: as judged then}}.

    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row['status'] == 'done':
            groups.setdefault(row['gearbox'], []).append(row)
    boxes = [_history(name, sorted(group, key=lambda row: (row['start'], row['path'])),
                      sorted((services or {}).get(name, ()))) for name, group in groups.items()]
    return sorted(boxes, key=_order)


def joints(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """
    Return the joints of robots as plain data, those with findings first.

    Args:
        rows: of the table of bags (SCHEMA), of robots.

    Returns:
        Dicts: robot, joint ('' for the robot as a whole), level (name; None: not judged), summary
        (its finding, or why it is not judged), finding, states (as of watch_data), bags
        (analysed), first, last (ns); points: of each bag, {start (ns), states}.

    """
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row['gearbox'], []).append(row)
    out = [joint for robot, own in groups.items() if robot is not None
           for joint in _joints_of(robot, [row for row in own if row['status'] == 'done'])]
    return sorted(out, key=lambda joint: (-_urgency(joint), joint['robot']))


def _joints_of(robot: str, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the joints of a `robot` after the bags of `rows`."""
    if not rows:
        return [{'robot': robot, 'joint': '', 'level': None, 'summary': 'no bag could be read',
                 'finding': None, 'states': {}, 'bags': 0, 'first': 0, 'last': 0, 'points': []}]
    rows = sorted(rows, key=lambda row: (row['start'], row['path']))
    known = [json.loads(row['judged']) for row in rows]
    newest, out = known[-1], []
    for joint in (*newest['joints'], ''):
        own = newest['joints'].get(joint) or {'level': int(Level.OK), 'states': {}}
        found = [f for f in newest['findings'] if (f['joint'] or '') == joint]
        if not joint and not found:
            continue        # of the whole robot there is nothing to say
        level = int(Level.WARN) if found else own['level']
        out.append({
            'robot': robot, 'joint': joint, 'level': None if level is None else Level(level).name,
            'summary': '; '.join(f['words'].partition(': ')[2] for f in found) or (
                own['words'] if newest['phase'] == WATCH else newest['summary']),
            'finding': found[0] if found else None, 'states': own['states'], 'bags': len(rows),
            'first': rows[0]['start'], 'last': rows[-1]['start'],
            'points': [{'start': row['start'], 'states': data['joints'][joint]['states']}
                       for row, data in zip(rows, known) if joint in data['joints']]})
    return out


def _urgency(box: Mapping[str, Any]) -> int:
    """Return the number of the level of a gearbox or joint; not judged is the least urgent."""
    return -1 if box['level'] is None else int(Level[box['level']])


def _order(box: dict[str, Any]) -> tuple[int, bool, float, str]:
    width = box['features'][box['feature']]
    sure = 2.0 * width['change_std'] - width['change'] if width['change'] is not None else 0.0
    return -_urgency(box), not box['points'], sure, box['gearbox']


def _history(name: str, rows: Sequence[Row], services: list[tuple[int, str]]) -> dict[str, Any]:
    """
    Fold the windows of the bags `rows`, and the `services` between them.

    The first bag begins with what its estimator knew: a baseline, or the state of a live node.
    """
    health, points, compared = Health(HealthSettings()), [], False
    for row in rows:
        judged, before = json.loads(row['judged'])
        settings, windows = from_data(judged, CLASSES)
        if row is rows[0]:
            health = health_from(settings, before)
        while services and services[0][0] <= row['start']:
            health = serviced(health, *services.pop(0))
        known = health.baseline_ns
        health = folded(replace(health, settings=settings), windows, row['path'])
        compared = compared or bool(known and health.compared)
        means = {feature: (row[feature], row[f'{feature}_std']) for feature in MEASURED
                 if row.get(feature) is not None and math.isfinite(row[f'{feature}_std'])}
        if means:
            points.append({'start': row['start'], 'means': means, 'changes': {
                name: feature.change for name, feature in zip(FEATURES, health.features)}})
    for service in services:
        health = serviced(health, *service)
    level, summary = sentence(health)
    changed = health.alerts or health.slips
    trusted = rows[-1]['trust'] != Level.ERROR.name
    return {
        'gearbox': name, **figures(health),
        'summary': summary if trusted or changed else say('untrusted_bag', summary=summary),
        'level': level.name if changed or compared and trusted else None,
        'bags': len(rows), 'first': rows[0]['start'], 'last': rows[-1]['start'], 'points': points,
        **{key: rows[-1][key] for key in COPIED}}


PARTS, BAGS, PAGE = 'parts', 'bags.parquet', 'fleet.html'
OF_0_2 = ('features/', 'bags.journal')
NUMBER, COUNT, TEXT, FLAG = pa.float64(), pa.int64(), pa.string(), pa.bool_()
SCHEMA = pa.schema({
    'path': TEXT, 'status': TEXT, 'reason': TEXT, 'retry': FLAG, 'duplicate_of': TEXT,
    'gearbox': TEXT, 'named': FLAG, 'date': TEXT,
    'start': pa.timestamp('us', 'UTC'), 'duration_s': NUMBER, 'samples': COUNT,
    'filter': TEXT, 'unit': TEXT, 'windows': COUNT, 'windows_used': COUNT, 'not_excited': TEXT,
    'separable': FLAG, **{name + std: NUMBER for name in MEASURED for std in ('', '_std')},
    'trust': TEXT, 'model_level': TEXT, 'notes': TEXT, 'content': TEXT, 'bytes': COUNT,
    'settings': TEXT, 'version': TEXT, 'kernels': TEXT, 'judged': TEXT,
})
# Of a Row, and between the two: of ns, Python makes dates with pandas only.
IN_NS, DATED = (SCHEMA.set(SCHEMA.get_field_index('start'), pa.field('start', kind))
                for kind in (COUNT, pa.timestamp('ns', 'UTC')))


class FleetFolder:
    """
    The output folder `folder` of a fleet, new or from an earlier run.

    Raises InputError if it holds other files, those of version 0.2, too, or is not writable.
    """

    def __init__(self, folder: str | Path) -> None:
        self.path = Path(folder).absolute()
        self._parts = self.path / PARTS
        try:
            for name in OF_0_2:
                if (self.path / name).exists():
                    raise InputError(f'{self.path / name}: {refusal(name)}')
            if self.path.is_dir() and any(self.path.iterdir()) and not self._parts.is_dir():
                raise InputError(f'{self.path}: holds other files, expected a new folder or one '
                                 'of an earlier fleet run')
            self._parts.mkdir(parents=True, exist_ok=True)
            # {path in hex: name of the file}
            self._names = {part.name[:32]: part.name for part in self._parts.glob('[!.]*.parquet')}
        except OSError as error:
            raise InputError(f'{error.filename or self.path}: {error.strerror}, expected a new '
                             'or writable folder') from None

    def has(self, bag: FleetBag, key: str) -> bool:
        """Return whether `bag`, as it is now, was analysed under the settings `key`."""
        name = _name_of(bag, key)
        return self._names.get(name[:32]) == name

    def put(self, bag: FleetBag, row: Row) -> None:
        """Write the final `row` of `bag` in place of an earlier one. Raises InputError."""
        name = _name_of(bag, row['settings'])
        if isinstance(bag, RobotBag):   # the state before it goes when both are there
            state = _state_of(bag, row['settings'])
            self._write(f'{PARTS}/{state}', lambda part: part.write_bytes(row['state']))
        self._write(f'{PARTS}/{name}', lambda part: _write_table([row], part))
        if isinstance(bag, RobotBag):
            for old in self._parts.glob(f'{state[:32]}-*.watch'):
                if old.name != state:
                    old.unlink(missing_ok=True)
        earlier = self._names.get(name[:32], name)
        self._names[name[:32]] = name
        if earlier != name:
            (self._parts / earlier).unlink(missing_ok=True)

    def state(self, bag: RobotBag, key: str) -> bytes | None:
        """Return what is known after a robot's `bag` with settings `key`, None if it is lost."""
        path = self._parts / _state_of(bag, key)
        return path.read_bytes() if path.is_file() else None

    def finish(self, retried: Iterable[Row]) -> list[Row]:
        """
        Write the table of bags and return its rows, sorted by path.

        Args:
            retried: rows of bags that are to be tried again.

        Raises:
            InputError: the table cannot be written, or a part of it cannot be read.
        """
        try:
            parts = dataset.dataset(
                [str(self._parts / name) for name in self._names.values()], SCHEMA
            ).to_table().cast(DATED).cast(IN_NS)
        except (OSError, pa.ArrowException) as error:
            raise InputError(f'{self._parts}: {" ".join(str(error).split())}, expected files '
                             'written by fleet; delete a damaged one') from None
        again = {row['path']: {name: row.get(name) for name in SCHEMA.names} for row in retried}
        rows = [row for row in parts.to_pylist() if row['path'] not in again]
        rows = sorted([*rows, *again.values()], key=lambda row: row['path'])
        originals: dict[tuple[str, str], str] = {}  # (content, settings): path
        for row in rows:
            if row['status'] == 'done':
                originals.setdefault((row['content'], row['settings']), row['path'])
        for row in rows:    # the copy of a robot's bag fails: its time has been taken
            original = originals.get((row['content'], row['settings']), row['path'])
            if original != row['path']:
                kept = {name: row[name] for name in (
                    'path', 'content', 'bytes', 'settings', 'version')}
                row.update({**dict.fromkeys(row), **kept, 'status': 'duplicate',
                            'duplicate_of': original})
        self._write(BAGS, lambda part: _write_table(rows, part))
        return rows

    def write_page(self, text: str, name: str = PAGE) -> Path:
        """Write the `text` of the file `name`; return its path. Raises InputError."""
        self._write(name, lambda part: part.write_text(text, encoding='utf-8'))
        return self.path / name

    def _write(self, name: str, write: Callable[[Path], object]) -> None:
        """Let write(path) make the file `name`, completely or not at all."""
        part = (self.path / name).with_name(f'.{uuid4().hex}')
        try:
            write(part)
            with open(part, 'rb') as file:
                os.fsync(file.fileno())
            os.replace(part, self.path / name)
        except OSError as error:
            raise InputError(f'{self.path}: cannot write: {error.strerror or error}; what is done '
                             'is kept, run the same command again to continue') from None
        finally:
            part.unlink(missing_ok=True)


def _name_of(bag: FleetBag, key: str) -> str:
    """Return the name of the file of `bag`, as it is now, under the settings `key`."""
    return f'{_hex(bag.path)[:32]}-{_hex(f"{bag.fingerprint} {key}")[:16]}.parquet'


def _state_of(bag: RobotBag, key: str) -> str:
    """Return the name of the file of what is known of a robot after its `bag`."""
    return f'{_hex(bag.robot)[:32]}-{_hex(f"{bag.fingerprint} {key}")[:16]}.watch'


def _hex(text: str) -> str:
    return hashlib.sha256(text.encode('utf-8', 'surrogateescape')).hexdigest()


def _write_table(rows: Iterable[Row], path: Path) -> None:
    table = pa.Table.from_pylist([{name: row.get(name) for name in SCHEMA.names} for row in rows],
                                 IN_NS)
    parquet.write_table(table.cast(DATED).cast(SCHEMA, safe=False), path, compression='zstd')


TICK = 0.2  # s between two checks whether to stop
CONNECT_TIMEOUT = 10.0  # s to wait for a scheduler
CHECKED = 2.0  # s between two looks whether there is still one
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
    stated = os.environ.get('PYTHONSAFEPATH')
    os.environ['PYTHONSAFEPATH'] = stated or '1'  # no folder of the same name is imported
    try:
        forkserver.ensure_running()
    finally:
        if stated is None:
            del os.environ['PYTHONSAFEPATH']
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
        host, port = get_address_host_port(address)  # a Client takes long to notice
        client: Any = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(f'--scheduler: {address}: {" ".join(str(error).split())}, expected the '
                         'address of a running Dask scheduler, as tcp://host:8786') from None

    def cancel() -> None:
        for state in list(client.futures.values()):
            state.cancel()

    def watch() -> None:
        """Cancel what is open once the scheduler is gone: if it ends in order, no client knows."""
        while not ended.wait(CHECKED):
            try:
                socket.create_connection((host, port), CONNECT_TIMEOUT).close()
            except OSError:
                client.loop.add_callback(cancel)

    ended, watcher = threading.Event(), threading.Thread(target=watch, daemon=True)
    with client:
        watcher.start()
        try:
            yield client.get_executor(pure=False)
        finally:
            ended.set()


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
