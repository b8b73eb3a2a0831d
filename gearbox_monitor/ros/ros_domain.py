# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""A ROS domain of one's own on this machine."""
from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
import socket
import tempfile

from gearbox_monitor.errors import InputError

DOMAINS = range(60, 102)  # the ports of higher domains are those that Linux gives away


@contextmanager
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
