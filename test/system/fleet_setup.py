# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What the benchmark and the tests of a fleet run on: a Dask cluster, CPU times."""
import os
from pathlib import Path


def local_cluster(workers):
    """Return a Dask cluster of `workers` processes of one thread each on this machine."""
    from distributed import LocalCluster
    return LocalCluster(n_workers=workers, threads_per_worker=1, processes=True,
                        host='127.0.0.1', dashboard_address=None)


def below(pid):
    """Return the ids of all processes below `pid`, by generation: [[children], ...]."""
    children, generations = {}, [[pid]]
    for entry in Path('/proc').glob('[0-9]*'):
        fields = _stat(entry.name)
        if fields:
            children.setdefault(int(fields[1]), []).append(int(entry.name))
    while generations[-1]:
        generations.append([child for parent in generations[-1]
                            for child in children.get(parent, ())])
    return generations[1:-1]


def cpu_seconds():
    """Return the CPU time (s) of this process and of all below it, those that have ended, too."""
    ticks = 0
    for generation in below(os.getpid()):
        for child in generation:
            fields = _stat(child)
            ticks += sum(map(int, fields[11:15])) if fields else 0
    return sum(os.times()[:4]) + ticks / os.sysconf('SC_CLK_TCK')


def _stat(pid):
    """Return the fields of /proc/PID/stat behind the name, () when the process has ended."""
    try:
        return Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    except OSError:
        return ()
