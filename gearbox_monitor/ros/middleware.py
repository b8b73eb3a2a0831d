# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Shared memory of Fast DDS that a killed process left unusable."""
import contextlib
from pathlib import Path
import sys
import time

MEMORY = Path('/dev/shm')
AGE_S = 2.0


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
