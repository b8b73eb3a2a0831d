# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the benchmark and the tests of a fleet run on: a Dask cluster, CPU times."""
from contextlib import contextmanager
import json
import os
from pathlib import Path
import subprocess
import sys
import time

from gearbox_monitor.errors import InputError
from gearbox_monitor.fleet.executors import MMAP_BYTES, TRIM_BYTES

# Of workers: freed memory is kept, see docs/fleet.md.
ENVIRONMENT = {'MALLOC_TRIM_THRESHOLD_': str(TRIM_BYTES),
               'MALLOC_MMAP_THRESHOLD_': str(MMAP_BYTES)}


@contextmanager
def dask_cluster(folder, workers):
    """
    Run a Dask scheduler and `workers` workers of one thread each as processes.

    Gives (address, processes: the scheduler's first); their files lie in the new `folder`.
    Raises InputError where the scheduler does not start.
    """
    folder = Path(folder)
    folder.mkdir()
    file, processes = folder / 'scheduler.json', []

    def start(what, *arguments):
        log = folder / f'{what}{len(processes)}.log'
        with open(log, 'wb') as output:
            processes.append(subprocess.Popen(
                [sys.executable, '-m', 'dask', what, '--no-dashboard', *arguments],
                stdout=output, stderr=output, start_new_session=True,
                env={**os.environ, **ENVIRONMENT}))
        return log
    try:
        log = start('scheduler', '--host', '127.0.0.1', '--port', '0', '--scheduler-file',
                    str(file))
        while not (file.exists() and file.stat().st_size):
            if processes[0].poll() is not None:
                raise InputError(f'dask scheduler: {log.read_text().strip()[-300:]}, expected it '
                                 'to run')
            time.sleep(0.05)
        for _ in range(workers):
            start('worker', '--scheduler-file', str(file), '--nthreads', '1',
                  '--local-directory', str(folder))
        yield json.loads(file.read_text(encoding='utf-8'))['address'], processes
    finally:
        for process in reversed(processes):
            process.terminate()
        for process in reversed(processes):
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def below(pid, without=()):
    """
    Return the ids of all processes below `pid`, by generation: [[children], ...].

    without: ids that are left out, with all below them.
    """
    children, generations = {}, [[pid]]
    for entry in Path('/proc').glob('[0-9]*'):
        fields = _stat(entry.name)
        if fields and int(entry.name) not in without:
            children.setdefault(int(fields[1]), []).append(int(entry.name))
    while generations[-1]:
        generations.append([child for parent in generations[-1]
                            for child in children.get(parent, ())])
    return generations[1:-1]


def cpu_seconds(without=()):
    """Return the CPU time (s) of this process and of all below it that run; without: see below."""
    ticks = 0
    for generation in below(os.getpid(), without):
        for child in generation:
            fields = _stat(child)
            ticks += sum(map(int, fields[11:13])) if fields else 0
    return time.process_time() + ticks / os.sysconf('SC_CLK_TCK')


def _stat(pid):
    """Return the fields of /proc/PID/stat behind the name, () when the process has ended."""
    try:
        return Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    except OSError:
        return ()
