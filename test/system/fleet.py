# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What a fleet run costs beside its bags: at home and on Dask against one process, and how it grows.

Short bags of a simulated drive are written once. Each round analyses all of them in this process,
in processes of their own and on a local Dask cluster (skipped where distributed is missing). CPU
time is that of all processes; what starts the cluster does not count. Two workers against one
count by the clock, and are judged where the machine has two cores to give, which two busy loops
tell.

usage examples:
  .venv/bin/python test/system/fleet.py
  .venv/bin/python test/system/fleet.py --bags 20 --seconds 50 --rounds 2 --json fleet.json
"""
from contextlib import ExitStack
from importlib import import_module
import importlib.util
import multiprocessing
from pathlib import Path
import sys
import tempfile
import time

from fleet_setup import cpu_seconds, local_cluster
import numpy as np
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError, installed_by
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.fleet.fleet_run import at_home, FleetFolder, on_cluster, run as run_fleet
from gearbox_monitor.fleet.job import analyse, find_bags, JobSettings
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag

WORKERS = 2
PARTS = (0.125, 0.25, 0.5, 1.0)  # of the bags, for the exponent
IDLE = 1.9  # so much of one busy loop must two of them get, or there are no two idle cores
# bar: (lowest, highest)
BARS = {'home CPU / serial': (0.0, 1.1), 'Dask CPU / serial': (0.0, 1.8),
        'exponent of CPU over bags': (0.95, 1.05), 'two workers / one, clock': (1.7, np.inf)}


def add_arguments(parser):
    parser.add_argument('--bags', type=int, default=40, help='bags (default: 40)')
    parser.add_argument('--seconds', type=float, default=100.0,
                        help='length of each at 1 kHz (default: 100)')
    parser.add_argument('--rounds', type=int, default=5,
                        help='interleaved rounds; medians count (default: 5)')
    add_json_option(parser)


class FleetRuns:
    """Runs bags into a new folder each time."""

    def __init__(self, folder):
        self.folder, self.count = Path(folder), 0

    def run(self, bags, executor=None, workers=WORKERS):
        """Return (CPU time, time by the clock) of a run over `bags`, s; None: in this process."""
        self.count += 1
        cpu, clock = cpu_seconds(), time.monotonic()
        folder, settings = FleetFolder(self.folder / str(self.count)), JobSettings()
        rows = run_fleet(bags, settings, executor, workers) if executor else (
            (bag, analyse(bag, settings)) for bag in bags)
        for bag, row in rows:
            folder.put(bag, row)
        done = sum(row['status'] == 'done' for row in folder.finish([]))
        if done != len(bags):
            raise InputError(f'{len(bags)} bags: {done} done, expected all')
        return cpu_seconds() - cpu, time.monotonic() - clock


def _spin(seconds):
    """Count for `seconds`; return how far it came."""
    end, count = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        count += sum(range(1000)) >= 0
    return count


def cores(seconds=1.0):
    """Return how much two busy loops get together, in terms of one alone."""
    with multiprocessing.get_context('spawn').Pool(2) as pool:
        pool.map(_spin, [0.01, 0.01], 1)
        alone = pool.apply(_spin, (seconds,))
        return sum(pool.map(_spin, [seconds, seconds], 1)) / alone


def evaluate(count, seconds, rounds):
    """Return all figures as plain data."""
    skipped = None if importlib.util.find_spec('distributed') else \
        f'distributed is not installed, expected {installed_by("fleet")}'
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        for k in tqdm(range(count), 'bags', disable=None, leave=False):
            write_example_bag(folder / f'bags/{k:03d}', DriveModel(), ExampleMotion(seconds),
                              k)
        bags = find_bags([str(folder / 'bags')])
        runs = FleetRuns(folder)
        ways = {'serial': (None, 1), 'home': (at_home, WORKERS), 'one worker': (at_home, 1)}
        if not skipped:
            cluster = stack.enter_context(local_cluster(WORKERS))
            ways['dask'] = (lambda _: on_cluster(cluster.scheduler_address)), WORKERS
        for way in ways.values():
            for _ in range(2):  # each worker is to have run one
                runs.run(bags[:2 * WORKERS], *way)
        times = {name: [] for name in ways}
        sizes = sorted({max(1, round(part * count)) for part in PARTS})
        grown, seen = {size: [] for size in sizes}, []
        for _ in tqdm(range(rounds), 'rounds', disable=None, leave=False):
            for name, way in ways.items():
                times[name].append(runs.run(bags, *way))
            for size in sizes:
                grown[size].append(runs.run(bags[:size], *ways['home'])[0])
            seen.append(cores())
    return figures(times, grown, seen, count, seconds, skipped)


def figures(times, grown, seen, count, seconds, skipped):
    """
    Return the figures and bars.

    times {way: [(CPU, clock) of each round]}; grown {bags: [CPU]}; seen [cores].
    """
    def ratio(one, other, column):
        return float(np.median([a[column] / b[column] for a, b in zip(times[one], times[other])]))
    sizes = sorted(grown)
    exponent = float(np.polyfit(np.log(sizes), np.log(
        [np.median(grown[size]) for size in sizes]), 1)[0])
    values = {'home CPU / serial': ratio('home', 'serial', 0),
              'Dask CPU / serial': None if skipped else ratio('dask', 'serial', 0),
              'exponent of CPU over bags': exponent,
              'two workers / one, clock': ratio('one worker', 'home', 1)}
    there = float(np.median(seen))
    reasons = {'Dask CPU / serial': skipped, 'two workers / one, clock': None if there >= IDLE else
               f'two busy loops got {there:.2f} of one here: no two idle cores'}
    bars = BarTable()
    for bar, (low, high) in BARS.items():
        if reasons.get(bar):
            bars.skip(bar, reasons[bar], values[bar])
        else:
            bars.judge(bar, values[bar], low or -np.inf, high)
    return {'bags': count, 'seconds_each': seconds, 'rounds': len(times['serial']),
            'cpu_s': {name: float(np.median([t[0] for t in rows]))
                      for name, rows in times.items()},
            'clock_s': {name: float(np.median([t[1] for t in rows]))
                        for name, rows in times.items()},
            'cpu_s_by_bags': {size: float(np.median(grown[size])) for size in sizes},
            'cores_seen': there, 'bars': bars.rows}


def text(data):
    """Return the figures as a table for the terminal."""
    lines = [f'{data["bags"]} bags of {data["seconds_each"]:g} s at 1 kHz, medians of '
             f'{data["rounds"]} rounds:', '', f'  {"":<12}{"CPU s":>10}{"clock s":>10}']
    lines += [f'  {name:<12}{cpu:10.2f}{data["clock_s"][name]:10.2f}'
              for name, cpu in data['cpu_s'].items()]
    lines += ['', '  CPU s at home by number of bags: ' + ', '.join(
        f'{size}: {cpu:.2f}' for size, cpu in data['cpu_s_by_bags'].items()), '']
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args):
    for option, value, least in (('--bags', args.bags, 2 * WORKERS), ('--rounds', args.rounds, 1),
                                 ('--seconds', args.seconds, 5.0)):
        if not value >= least:
            raise InputError(f'{option}: {value:g}, expected a number >= {least:g}')
    expect_folder_of(args.json)
    data = evaluate(args.bags, args.seconds, args.rounds)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    # Workers import the script that started them: all of this one, of the command nothing.
    del sys.modules['__main__'].__file__
    sys.exit(run_script(import_module('fleet')))
