# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Accidents of the recorder: what is older than one second must be in its bag, whatever happens.

A plant publishes two topics at 1 kHz. Real recorder nodes write them and are killed (kill -9) at
random moments, every fifth while it closes its bag, a third of them with a new file of the bag
every half second; the disk gets full, the bag is removed, the target cannot be written. Slow disk:
every write to the file takes 50 ms, every sync 2 s. A bag is cut at every byte of its last
chunks. Power cut: a file system (ext4 in a file) is stopped without writing what it holds in
memory, and mounted again; only root may do so, and fill a small file system.
What another subscriber has received is the measure. Every bag is recovered, too.

usage examples:
  .venv/bin/python test/system/recorder.py
  .venv/bin/python test/system/recorder.py --kills 10 --power-cuts 3
  .venv/bin/python test/system/recorder.py --kills 100 --domain 65 --json recorder.json

exit code: 0 all bars met, 1 one is missed, 2 bad usage.
"""
import os
from pathlib import Path
import sys
import tempfile

import recorder_accidents as accidents
from recorder_bench import Bench
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, require_whole, write_json
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of

SPLIT = 0.5  # s, a file of the bags that are split


def add_arguments(parser):
    parser.add_argument('--kills', type=int, default=20, metavar='N',
                        help='recorders that are killed (default: %(default)s)')
    parser.add_argument('--power-cuts', type=int, default=5, metavar='N',
                        help='power cuts, only as root (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=0, metavar='N',
                        help='seed of the moments (default: %(default)s)')
    parser.add_argument('--domain', type=int, default=None, metavar='ID',
                        help='ROS domain (default: ROS_DOMAIN_ID, 0)')
    add_json_option(parser)


def text(rows):
    """Return table and verdicts."""
    lines = ['missing: messages older than 1 s that are not in the bag; lost: s before the '
             'accident from which on', 'messages are missing, median and worst; unread: messages '
             'that recover has not saved.', '',
             f'{"accident":<34}{"runs":>6}{"messages":>10}{"missing":>9}{"lost":>7}{"worst":>7}'
             f'{"unread":>8}']
    for row in rows:
        if not row['runs']:
            lines.append(f'{row["accident"]:<34}{"-":>6}  not run: {row["why"]}')
            continue
        figures = [f'{row["runs"]:6d}', *(
            '-'.rjust(width) if row[name] is None else format(row[name], f'{width}{kind}')
            for name, width, kind in (('messages', 10, 'd'), ('missing', 9, 'd'),
                                      ('lost_s', 7, '.2f'), ('worst_s', 7, '.2f'),
                                      ('unread', 8, 'd')))]
        lines.append(f'{row["accident"]:<34}' + ''.join(figures))
    lines.append('')
    for bar in accidents.BARS:
        missed = [row['accident'] for row in rows if bar in row['missed']]
        lines.append(f'{"MISSED" if missed else "met   "} {bar:<48}{", ".join(missed)}'.rstrip())
    return '\n'.join(lines)


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    require_whole('--kills', args.kills, 0)
    require_whole('--power-cuts', args.power_cuts, 0)
    domain = args.domain
    if domain is None:
        text_id = os.environ.get('ROS_DOMAIN_ID') or '0'
        domain = int(text_id) if text_id.isdigit() else -1
    if not 0 <= domain <= 232:
        raise InputError(f'--domain: {domain}, expected a ROS domain, 0 to 232')
    expect_folder_of(args.json)
    rows, split = [], args.kills // 3
    with tempfile.TemporaryDirectory() as folder, tqdm(
            total=args.kills + args.power_cuts + 6, disable=not sys.stderr.isatty(),
            leave=False) as bar:
        bench = Bench(Path(folder), domain, args.seed)
        try:
            for accident in (
                    lambda: accidents.killed(bench, 'kill -9', args.kills - split, bar.update),
                    lambda: accidents.killed(bench, f'kill -9, files of {SPLIT:g} s', split,
                                             bar.update, max_bag_duration=SPLIT),
                    lambda: accidents.slow_disk(bench, bar.update),
                    lambda: accidents.power_cut(bench, args.power_cuts, bar.update),
                    lambda: accidents.disk_full(bench, bar.update),
                    lambda: accidents.file_limit(bench, bar.update),
                    lambda: accidents.removed(bench, bar.update),
                    lambda: accidents.refused(bench, bar.update),
                    lambda: accidents.cut_at_every_byte(bench, bar.update)):
                rows.append(accident())
        finally:
            bench.close()
    print(text(rows))
    write_json(rows, args.json)
    return int(any(row['missed'] for row in rows))


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
