# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Cost against the length of a bag and against the number of windows, with bars.

Simulated recordings at 1 kHz (lz4), each replayed to Parquet with the EKF in a process of its own,
whose start is left out; CPU time and peak memory. Windows, in one process: those that a diagnosis
simulates side by side. The exponent p of CPU time ~ size^p is fitted over all sizes; 1 is linear.

usage examples:
  .venv/bin/python test/system/scale.py
  .venv/bin/python test/system/scale.py --of length --minutes 1 10 60 240 --json scale.json
  .venv/bin/python test/system/scale.py --of windows --windows 512 4096
"""
from pathlib import Path
import sys
import tempfile

import numpy as np
import scale_numbers
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, require_whole
from benchmarks.replay_cost import in_a_process, write_recording
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of

MINUTES = (10.0, 20.0, 60.0)
WARM = 12.0  # s of the recording that is replayed before: long enough for a drift window
EXPONENT = 0.95, 1.05  # lowest, highest
MEMORY = 1.2  # highest
LENGTH = 'length'
AXES = (LENGTH, *scale_numbers.NUMBERS)
MODES = {'estimates only': False, 'everything': True}


def add_arguments(parser):
    parser.add_argument('--minutes', type=float, nargs='+', default=list(MINUTES),
                        help='lengths of the bags, at least two (default: '
                        f'{" ".join(f"{m:g}" for m in MINUTES)})')
    for axis, numbers in scale_numbers.NUMBERS.items():
        parser.add_argument(f'--{axis}', type=int, nargs='+', default=list(numbers), metavar='N',
                            help=f'numbers of {axis}, at least two (default: '
                            f'{" ".join(map(str, numbers))})')
    parser.add_argument('--of', nargs='+', choices=AXES, default=list(AXES),
                        help='what to vary (default: all)')
    parser.add_argument('--rounds', type=int, default=3,
                        help='interleaved rounds; medians count (default: 3)')
    add_json_option(parser)


def evaluate(sizes, rounds):
    """Return all figures as plain data; sizes: {axis: sizes}."""
    bars = BarTable()
    rows = by_length(sizes[LENGTH], rounds, bars) if LENGTH in sizes else []
    numbers = {axis: many for axis, many in sizes.items() if axis != LENGTH}
    by_number = []
    with tempfile.TemporaryDirectory() as folder:
        for axis, times in scale_numbers.cpu_times(folder, numbers, rounds).items():
            seconds = [float(np.median(values)) for values in times.values()]
            by_number += [{'axis': axis, 'number': n, 'cpu_s': s} for n, s in zip(times, seconds)]
            bars.judge(f'exponent of CPU time over {axis}', _exponent(times, seconds),
                       *EXPONENT)
    return {'rounds': rounds, 'rows': rows, 'numbers': by_number, 'bars': bars.rows}


def _exponent(sizes, seconds):
    return float(np.polyfit(np.log(list(sizes)), np.log(seconds), 1)[0])


def by_length(minutes, rounds, bars):
    """Return rows of `rounds` replays of bags as long as `minutes`; judges them in `bars`."""
    cells = [(name, length) for name in MODES for length in minutes]
    cpu, peak = ({cell: [] for cell in cells} for _ in range(2))
    with tempfile.TemporaryDirectory() as folder, tqdm(
            total=len(minutes) + rounds * len(cells), desc='scale', disable=None,
            leave=False) as bar:
        warm = Path(folder) / 'warm'
        write_recording(warm, WARM)
        for length in minutes:
            write_recording(Path(folder) / f'{length}', 60.0 * length)
            bar.update()
        for _ in range(rounds):
            for name, length in cells:
                found = in_a_process(Path(folder) / f'{length}', MODES[name], warm)
                cpu[name, length].append(found[0])
                peak[name, length].append(found[1])
                bar.update()
    rows = []
    for name in MODES:
        seconds = [float(np.median(cpu[name, m])) for m in minutes]
        memory = [float(np.median(peak[name, m])) for m in minutes]
        rows += [{'mode': name, 'minutes': m, 'cpu_s': s, 'times_real_time': 60.0 * m / s,
                  'peak_mb': b / 1e6} for m, s, b in zip(minutes, seconds, memory)]
        bars.judge(f'{name}: exponent of CPU time over length', _exponent(minutes, seconds),
                   high=EXPONENT[1])
        bars.judge(f'{name}: peak memory, {minutes[-1]:g} min over {minutes[0]:g} min',
                   memory[-1] / memory[0], high=MEMORY)
    return rows


def text(data):
    """Return the figures as a table for the terminal."""
    lines = []
    if data['rows']:
        lines = [f'  {"replay":<16}{"minutes":>9}{"CPU s":>10}{"x real time":>14}{"peak MB":>10}']
        lines += [f'  {row["mode"]:<16}{row["minutes"]:9g}{row["cpu_s"]:10.2f}'
                  f'{row["times_real_time"]:14.0f}{row["peak_mb"]:10.0f}' for row in data['rows']]
        lines.append('')
    if data['numbers']:
        lines += [f'  {"of":<16}{"number":>9}{"CPU s":>10}']
        lines += [f'  {row["axis"]:<16}{row["number"]:9d}{row["cpu_s"]:10.3f}'
                  for row in data['numbers']]
        lines.append('')
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args):
    sizes = {}
    for axis in args.of:
        option = 'minutes' if axis == LENGTH else axis
        given = getattr(args, option)
        sizes[axis] = sorted(set(given))
        if len(sizes[axis]) < 2 or not all(0.0 < size < np.inf for size in given):
            raise InputError(f'--{option}: {" ".join(f"{size:g}" for size in given)}, expected '
                             'two or more different numbers > 0')
    require_whole('--rounds', args.rounds)
    expect_folder_of(args.json)
    data = evaluate(sizes, args.rounds)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
