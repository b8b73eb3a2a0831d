# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Start-up: CPU time of a process until the monitor has taken its first step, kernels cached."""
import os
import subprocess
import sys

import numpy as np

CODES = {
    'import numba': 'import numba',
    'first step': """
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.monitoring.monitor import Monitor, Sample
monitor = Monitor(DriveModel())
for k in (1, 2):
    monitor.step(Sample(k * 1_000_000, (0.0, float('nan')), (0.0, 0.0)))
assert monitor.stamp_ns == 2_000_000
""",
}


def cpu_seconds(rounds: int) -> dict[str, float]:
    """Return the CPU time (s) of a process for each of CODES, median of interleaved `rounds`."""
    times: dict[str, list[float]] = {name: [] for name in CODES}
    for k in range(rounds + 1):
        for name, code in CODES.items():
            begin = _of_children()
            subprocess.run([sys.executable, '-c', code], check=True)
            if k:  # the first one fills the cache
                times[name].append(_of_children() - begin)
    return {name: float(np.median(values)) for name, values in times.items()}


def _of_children() -> float:
    times = os.times()
    return times.children_user + times.children_system
