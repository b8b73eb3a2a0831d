# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Faults of the stream of samples: that bad data is never called good, and how soon all is well.

Each fault is put into the messages of a simulated drive (the packaged one, 1 kHz unless said),
with a load on the arm that the model knows (none) and with an unknown one. A Monitor takes what
arrives, and the silence of the stream is judged by the clock once per second, both as in the
node. benchmarks/README.md says what counts as bad data, and explains the table.

usage examples:
  .venv/bin/python test/system/faults.py
  .venv/bin/python test/system/faults.py --only clock --seeds 5
  .venv/bin/python test/system/faults.py --node 64 --json faults.json
"""
import sys
import time

from fault_cases import CASES
import fault_node
from fault_runs import BARS, run_case
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, require_whole, write_json
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.health.monitor import JUDGED

LOADS = ('none', 'unknown')


def add_arguments(parser):
    parser.add_argument('--only', metavar='TEXT', help='faults whose name contains TEXT')
    parser.add_argument('--seeds', type=int, default=1, metavar='N',
                        help='runs of each fault (default: %(default)s)')
    parser.add_argument('--node', type=int, metavar='DOMAIN',
                        help='besides, real nodes in this ROS domain: the source is killed and '
                        'started again')
    add_json_option(parser)


def evaluate(only='', seeds=1, progress=lambda rows: rows):
    """Return the figures of all faults whose name contains `only`, as plain data."""
    rows = []
    cases = [case for case in CASES if only in case.name]
    for case, load in progress([(case, load) for case in cases for load in LOADS]):
        rows.append(_worst([run_case(case, load, seed) for seed in range(seeds)]))
    return rows


def _worst(runs):
    """Return one row for the `runs` of a fault: its worst figures, all missed bars."""
    worst = dict(runs[0])
    for run in runs[1:]:
        for name, value in run.items():
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                known = [v for v in (worst[name], value) if v is not None]
                worst[name] = max(known) if known else None
    worst['missed'] = sorted({bar for run in runs for bar in run['missed']})
    return worst


def _seconds(value, none='never'):
    return none if value is None else f'{value:.1f}'


def text(rows):
    """Return table and verdicts."""
    lines = ['after: s from its start to a level that is not OK, and whose; good, OK: '
             's from its', 'end to good estimates, and to levels OK. wrong: estimates off the '
             'truth; OK: those of them', 'under OK; lost: samples without estimate; spoilt: '
             'samples that the fault hit.', '',
             f'{"fault":<38}{"load":<8}{"after":>5}{"wrong":>7}{"OK":>5}{"lost":>7}{"spoilt":>7}'
             f'{"good":>6}{"OK":>6}  reported by']
    for row in rows:
        lines.append(
            f'{row["fault"]:<38}{row["load"]:<8}{_seconds(row["told"], "-"):>5}{row["wrong"]:7d}'
            f'{row["wrong_while_ok"]:5d}{row["lost"]:7d}{row["spoilt"]:7d}'
            f'{_seconds(row["good_after"]):>6}{_seconds(row["ok_after"]):>6}  '
            + ('not evaluated' if set(row['by']) >= set(JUDGED) else ', '.join(row['by'])))
    lines += ['', *(f'{"met   " if not missed else "MISSED"} {bar:<58}'
                    + (', '.join(missed[:3]) + (' ...' if missed[3:] else ''))
                    for bar, missed in verdicts(rows).items())]
    return '\n'.join(lines)


def verdicts(rows):
    """Return {bar: faults that miss it}."""
    return {bar: [f'{row["fault"]} ({row["load"]})' for row in rows if bar in row['missed']]
            for bar in BARS}


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    require_whole('--seeds', args.seeds)
    if args.node is not None and not 0 <= args.node <= 232:
        raise InputError(f'--node: {args.node}, expected a ROS domain, 0 to 232')
    expect_folder_of(args.json)
    began = time.process_time()
    rows = evaluate(args.only or '', args.seeds,
                    lambda jobs: tqdm(jobs, disable=not sys.stderr.isatty(), leave=False))
    if not rows:
        raise InputError(f'--only: no fault contains {args.only!r}, expected one of '
                         + ', '.join(case.name for case in CASES))
    data = {'faults': rows, 'bars': verdicts(rows), 'cpu_s': time.process_time() - began}
    print(text(rows))
    if args.node is not None:
        data['node'] = fault_node.restart(args.node)
        print('\n' + fault_node.text(data['node']))
    write_json(data, args.json)
    return 1 if any(data['bars'].values()) or data.get('node', {}).get('missed') else 0


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
