# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Robots of a fleet: the bags of each are folded in order of time, as `watch` does.

The result of a bag depends on earlier bags: the bags of a robot are analysed one after the other,
robots side by side. If a bag has changed, all later ones are analysed again.
"""
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
import hashlib
from pathlib import Path

from gearbox_monitor.errors import InputError
from gearbox_monitor.fleet.fleet_run import Results, run, Workers
from gearbox_monitor.fleet.fleet_table import FleetFolder
from gearbox_monitor.fleet.job import FleetBag, JobSettings, name_of, RobotBag
from gearbox_monitor.recordings.read import natural
from gearbox_monitor.recordings.reading import open_recording


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

    `settings`, `executor`, `workers` and `stop` are those of fleet_run.run. After a bag that is
    to be tried again, the others of its robot wait for the next run.
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
