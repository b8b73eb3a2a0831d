# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What processes of one machine share: ROS domains, and the shared memory of Fast DDS."""
from collections.abc import Iterator
import contextlib
import fcntl
import os
from pathlib import Path
import socket
import sys
import tempfile
import time

from gearbox_monitor.errors import InputError

MEMORY = Path('/dev/shm')
AGE_S = 2.0
DOMAINS = range(60, 102)  # the ports of higher domains are those that Linux gives away


def remove_cut_ports(folder: Path = MEMORY) -> list[str]:
    """
    Remove ports of Fast DDS in `folder` that killed processes left empty; return their names.

    A process that dies between making the file of a port and sizing it leaves the file empty for
    good, and each node on the machine that comes to this port blocks in its constructor. A live
    process sizes the file within microseconds: an empty file older than AGE_S is an orphan.
    """
    removed = []
    for port in folder.glob('fastrtps_port*'):
        with contextlib.suppress(OSError):  # gone, or another user's
            status = port.stat()
            if status.st_size == 0 and not port.name.endswith('_el') \
                    and time.time() - status.st_mtime > AGE_S:
                port.unlink()
                removed.append(port.name)
    if removed:
        print(f'removed what a killed process left of shared memory: {" ".join(sorted(removed))}',
              file=sys.stderr)
    return sorted(removed)


@contextlib.contextmanager
def own_domain() -> Iterator[int]:
    """
    Yield the number of a ROS domain that nobody else uses while the block runs.

    A lock on a file in the temporary directory keeps other runs of this package out; the lock
    ends with the process, however the process ends. Raises InputError when all domains are taken.
    """
    for domain in DOMAINS:
        if str(domain) == os.environ.get('ROS_DOMAIN_ID') or _in_use(domain):
            continue
        lock = _lock(Path(tempfile.gettempdir()) / f'gearbox_monitor_domain_{domain}.lock')
        if lock is not None:
            try:
                yield domain
            finally:
                os.close(lock)
            return
    raise InputError(f'ROS domains {DOMAINS[0]} to {DOMAINS[-1]}: all are in use, expected a free '
                     'one (is another demo still running?)')


def _in_use(domain: int) -> bool:
    """Return whether the first participant of `domain` has its port on this machine."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('', 7410 + 250 * domain))
        except OSError:
            return True
    return False


def _lock(path: Path) -> int | None:
    """Return the file descriptor of `path`, locked, or None when another process has it."""
    try:
        # Another user's file cannot be opened for creation, but for reading.
        flags = os.O_RDONLY if path.exists() else os.O_RDONLY | os.O_CREAT
        descriptor = os.open(path, flags, 0o644)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor
