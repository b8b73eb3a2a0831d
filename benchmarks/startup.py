# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Start-up: CPU time of the first commands that a user types.

They run one after the other, each in a process of its own, as after an installation.

usage examples:
  python -m benchmarks startup
"""
from argparse import ArgumentParser, Namespace
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.harness import add_json_option, write_json

TOUR = {
    'example': 'example {bag}', 'replay': 'replay {bag}',
    'fit noise': 'fit noise {bag} --model {bag}.drive.yaml --out {bag}.noise.yaml',
    'diagnose': 'diagnose {bag} --model {bag}.drive.yaml'}
CODES = {
    'import scipy.optimize': 'import scipy.optimize',
    'first step': """
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.health.monitor import Monitor, Sample
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


def add_arguments(parser: ArgumentParser) -> None:
    """Add the options of this benchmark to `parser`."""
    add_json_option(parser)


def run(args: Namespace) -> int:
    """Run the benchmark with the options `args`; returns the exit code."""
    seconds = tour()
    for command, value in {**seconds, 'all': sum(seconds.values())}.items():
        print(f'{command:12s}{value:7.2f} CPU s')
    write_json(seconds, args.json)
    return 0


def tour() -> dict[str, float]:
    """Return the CPU time (s) of each command of TOUR."""
    seconds = {}
    with TemporaryDirectory() as folder:
        for name, line in TOUR.items():
            words = line.format(bag=Path(folder, 'bag')).split()
            begin = _of_children()
            subprocess.run([sys.executable, '-m', 'gearbox_monitor', *words], check=True,
                           capture_output=True)
            seconds[name] = _of_children() - begin
    return seconds


def _of_children() -> float:
    times = os.times()
    return times.children_user + times.children_system
