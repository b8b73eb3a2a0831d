# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Real node processes that a benchmark starts, watches from outside and ends."""
from contextlib import contextmanager
from dataclasses import dataclass
import itertools
import os
from pathlib import Path
import sys
import tempfile
import time

from gearbox_monitor.errors import InputError
from gearbox_monitor.ros.middleware import Child, ChildFailed, own_domain

PATIENCE = 120.0  # s, for a start that compiles
TICKS = os.sysconf('SC_CLK_TCK')
HERE = str(Path(__file__).resolve().parent)  # nodes of the system tests stand here


@dataclass(frozen=True)
class Usage:
    """What a process has used: cpu (s) so far; memory (resident bytes), handles, threads now."""

    cpu: float
    memory: int
    handles: int
    threads: int


def usage(pid):
    """Return the Usage of the process `pid`."""
    process = Path('/proc') / str(pid)
    fields = (process / 'stat').read_text().rpartition(')')[2].split()
    pages = int((process / 'statm').read_text().split()[1])
    return Usage((int(fields[11]) + int(fields[12])) / TICKS, pages * os.sysconf('SC_PAGE_SIZE'),
                 len(os.listdir(process / 'fd')), int(fields[17]))


class LiveNodes:
    """Node processes, with a folder for all that they write."""

    def __init__(self, folder, domain):
        self.folder, self.domain, self.children = folder, domain, []
        self._logs = itertools.count()

    def start(self, name, module, parameters, arguments=(), cores=None):
        """
        Start the node `module` with `parameters`; return its Child.

        cores: those that it may use, None: all.
        """
        log = self.folder / f'{next(self._logs)}_{name}.log'
        ours = os.sched_getaffinity(0)
        try:
            os.sched_setaffinity(0, cores or ours)  # a child has what its parent has
            path = os.pathsep.join(filter(None, [HERE, os.environ.get('PYTHONPATH')]))
            child = Child(name, module, parameters, log, {**os.environ, 'PYTHONPATH': path},
                          arguments)
        finally:
            os.sched_setaffinity(0, ours)
        self.children.append(child)
        return child

    def until(self, condition, what, work):
        """Call work() until condition(); raises ChildFailed when a node has ended or hangs."""
        end = time.monotonic() + PATIENCE
        while not condition():
            for child in self.children:
                child.check()
            if time.monotonic() > end:
                raise ChildFailed(f'{what} did not happen within {PATIENCE:g} s')
            work()

    def end(self):
        """End all nodes; return what went wrong."""
        told = [child.stop(30.0) for child in reversed(self.children)]
        self.children.clear()
        return [text for text in told if text]


@contextmanager
def live_nodes():
    """
    Yield LiveNodes on this machine only, in a ROS domain and a folder of its own.

    A node that fails is an InputError with the end of its log.
    """
    if not sys.platform.startswith('linux'):
        raise InputError('expected Linux: memory and handles of a node are read in /proc')
    with tempfile.TemporaryDirectory() as folder, own_domain() as domain:
        for name in ('ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS'):
            os.environ.pop(name, None)  # they would override the range
        logs = Path(folder) / 'log'
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST',
                          ROS_LOG_DIR=str(logs))
        nodes = LiveNodes(Path(folder), domain)
        try:
            yield nodes
        except ChildFailed as error:
            raise InputError(str(error)) from None
        finally:
            nodes.end()
