# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Resident memory of this process."""
import contextlib
from pathlib import Path
import resource

STATUS = Path('/proc/self/status')


def peak_bytes() -> int:
    """Return the largest resident memory so far, or since `forget_peak`."""
    if STATUS.exists():  # getrusage would include the process that started this one
        lines = STATUS.read_text().splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith('VmHWM:'))
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def forget_peak() -> None:
    """Restart `peak_bytes` from the present memory, if the kernel supports it."""
    with contextlib.suppress(OSError):
        Path('/proc/self/clear_refs').write_text('5')
