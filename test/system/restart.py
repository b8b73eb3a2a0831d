# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Nodes stopped and started in any order, at any time: what is left behind, and what goes on.

Each time plant, estimator (adaptive filter, state and baseline file) and recorder start and are
stopped, in a drawn order, after drawn times: while they start, before a sample has come, or at
work. Then every process, piece of shared memory, temporary file and handle must be gone, and the
estimator must begin with what its state file held. On this machine only; results are in
benchmarks/README.md.

usage examples:
  .venv/bin/python test/system/restart.py
  .venv/bin/python test/system/restart.py --times 5 --seed 3 --json restart.json
"""
from dataclasses import dataclass
import json
import os
from pathlib import Path
import random
import re
import signal
import sys
import time

from node_processes import live_nodes
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish, require_whole
from gearbox_monitor.files.baselines import load_state
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.health.judgement import to_data
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.ros.live_node import Watcher

TIMES = 50
BETWEEN, AT_WORK = (0.0, 1.0), (0.5, 6.0)  # s, drawn: from one start to the next; then to the end
EARLY = 0.25  # share of the times that nothing waits for the estimator to be ready
END = 30.0  # s: a node that has not ended by then hangs
SHARED = '/dev/shm/'
SERIAL = 'restarted'
ESTIMATOR = {'filter': 'aekf', 'arm_load': 'none', 'drift_window': 2.0, 'gearbox_serial': SERIAL}
NODES = ('plant', 'estimator', 'recorder')


def add_arguments(parser):
    parser.add_argument('--times', type=int, default=TIMES, metavar='N',
                        help='default: %(default)s')
    parser.add_argument('--seed', type=int, default=0, help='of orders and times (default: 0)')
    add_json_option(parser)


@dataclass
class Found:
    """What was seen of one node from start to end."""

    name: str
    session: int
    shared: set
    code: int | None = None
    early: bool = False
    told: str = ''


class Restarts:
    """Runs the nodes again and again in `nodes` (LiveNodes); drawn from `seed`."""

    def __init__(self, nodes, seed):
        self.nodes, self.random = nodes, random.Random(seed)
        self.state, self.baseline = (nodes.folder / name for name in ('state.json', 'base.yaml'))
        self.temporary = nodes.folder / 'tmp'
        self.temporary.mkdir()
        self.shared = set()  # whatever any node had of shared memory
        self.before = _there()
        self.bags = 0

    def once(self):
        """Start all, stop all; return the row of figures."""
        draw, watcher = self.random, Watcher('restarts', self.nodes.domain)
        kept, seen = self._state(), []
        early = draw.random() < EARLY
        order = draw.sample(NODES, len(NODES))
        try:
            for name in order:
                seen.append((self._start(name), name))
                watcher.spin(draw.uniform(*BETWEEN))
            if not early:
                self.nodes.until(lambda: watcher.snapshots, 'a start of the estimator',
                                 lambda: watcher.spin(0.05))
            watcher.spin(draw.uniform(*AT_WORK))
            ready = bool(watcher.snapshots)
            handles = [len(os.listdir(f'/proc/{child.process.pid}/fd'))
                       for child, name in seen if name == 'estimator' and ready]
            found = [Found(name, child.process.pid, _shared(child.process.pid))
                     for child, name in seen]
            first = watcher.snapshots[0] if ready else None
        finally:
            watcher.close()
        for k in draw.sample(range(len(seen)), len(seen)):
            self._stop(seen[k][0], found[k], early)
        self.nodes.children.clear()
        self.shared.update(*(row.shared for row in found))
        return {
            'order': order, 'early': early, 'ready': ready, 'samples': _samples(first),
            'handles': handles[0] if handles else None,
            'wrong_ends': [f'{row.name}: exit code {row.code}{row.told}' for row in found
                           if row.told or not _clean(row)],
            'processes': sum(_alive(row.session) for row in found),
            'own_handles': len(os.listdir('/proc/self/fd')),
            'went_on': None if first is None else _goes_on(kept, first),
            'state_whole': self._state() is not None or not self.state.exists(),
            'windows': self._windows()}

    def _start(self, name):
        parameters = {
            'plant': {'seed': self.random.randrange(1000)},
            'estimator': {**ESTIMATOR, 'drift_state_file': str(self.state),
                          'baseline_file': str(self.baseline)},
            'recorder': {'output': str(self.nodes.folder / f'bag_{self.bags}')}}[name]
        self.bags += name == 'recorder'
        return self.nodes.start(name, f'gearbox_monitor.ros.{name}_node', parameters)

    def _stop(self, child, found, early):
        """Stop one node; a terminal's signal only where Python has begun to look for it."""
        found.early = early
        if child.running and not early and self.random.random() < 0.5:
            child.process.send_signal(signal.SIGINT)
            time.sleep(self.random.uniform(0.0, 0.1))
            end = time.monotonic() + END
            while child.running and time.monotonic() < end:
                time.sleep(0.01)
        found.told = child.stop(END)
        found.code = child.process.returncode
        log = child.log.read_text(encoding='utf-8', errors='replace')
        if 'Traceback' in log or 'set aside' in log:
            found.told += '\n' + child.tail()

    def _state(self):
        """Return what the state file holds, None where there is none."""
        return load_state(self.state, SERIAL)[0] if self.state.exists() else None

    def _windows(self):
        state = self._state()
        return state['health']['stamp_ns'] if state else 0

    def left(self):
        """Return what stays behind when all have ended: shared memory, files that nobody knows."""
        known = {self.state.name, self.baseline.name, 'tmp', 'log'}
        files = [path.name for path in self.nodes.folder.iterdir() if path.name not in known
                 and path.suffix != '.log' and not path.name.startswith('bag_')]
        # Some is of the machine: there before, of another's nodes that run now, or a port that
        # nodes of all domains use in turn.
        others = set().union(*(_shared(path.name) for path in Path('/proc').glob('[0-9]*')))
        ours = range(7400 + 250 * self.nodes.domain, 7400 + 250 * (self.nodes.domain + 1))
        return {'shared': sorted(name for name in self.shared & _there() - self.before - others
                                 if (port := _port(name)) is None or port in ours),
                'files': sorted(files + [f'tmp/{path.name}'
                                         for path in self.temporary.iterdir()])}


def _port(name):
    """Return the number of a port of Fast DDS in the file `name`, None where it is another."""
    found = re.search(r'fastrtps_port(\d+)', name)
    return int(found[1]) if found else None


def _there():
    """Return the files that are in shared memory now."""
    return {str(path) for path in Path(SHARED).iterdir()}


def _shared(pid):
    """Return the files in shared memory that the process `pid` uses."""
    try:
        maps = Path(f'/proc/{pid}/maps').read_text()
    except OSError:  # ended already
        return set()
    return {line[line.index(SHARED):].removesuffix(' (deleted)') for line in maps.splitlines()
            if SHARED in line}


def _alive(session):
    """Return how many processes there are in `session`."""
    count = 0
    for stat in Path('/proc').glob('[0-9]*/stat'):
        try:
            count += int(stat.read_text().rpartition(')')[2].split()[3]) == session
        except OSError:  # ended meanwhile
            continue
    return count


def _clean(found):
    # During its imports Python ends quietly on SIGTERM, with its number.
    return found.code == 0 or found.early and found.code == -signal.SIGTERM


def _samples(snapshot):
    return int(snapshot['input_count']) if snapshot else 0


def _goes_on(kept, snapshot):
    """Return whether the `snapshot` at the start has what the file had `kept`; None: no file."""
    if kept is None:
        return None
    began = Monitor.restore(snapshot)
    health = json.loads(json.dumps(to_data(began.health)))
    return health == kept['health']


def evaluate(times, seed):
    """Return all figures as plain data."""
    rows = []
    with live_nodes() as nodes:
        restarts = Restarts(nodes, seed)
        temporary = os.environ.get('TMPDIR')
        os.environ['TMPDIR'] = str(restarts.temporary)
        try:
            for _ in tqdm(range(times), desc='restart', disable=None, leave=False):
                rows.append(restarts.once())
        finally:
            os.environ.pop('TMPDIR')
            if temporary is not None:
                os.environ['TMPDIR'] = temporary
        nodes.end()
        left, state = restarts.left(), restarts._state()
    data = {'times': times, 'seed': seed, 'rows': rows, 'left': left,
            'adapted': bool(state and state['adaptation']),
            'points': len(state['health']['data']['points']) if state else 0}
    return {**data, 'bars': bars(data)}


def bars(data):
    """Return the rows of a BarTable for the figures `data` of evaluate()."""
    rows, table = data['rows'], BarTable()
    add = table.check
    ends = [text for row in rows for text in row['wrong_ends']]
    add('nodes that did not end cleanly', len(ends), 0, not ends)
    processes = sum(row['processes'] for row in rows)
    add('processes left behind', processes, 0, not processes)
    add('pieces of shared memory left behind', len(data['left']['shared']), 0,
        not data['left']['shared'])
    add('temporary files left behind', len(data['left']['files']), 0, not data['left']['files'])
    own = [row['own_handles'] for row in rows]
    add('handles of the process that starts them', f'{own[0]} to {own[-1]}', 'no more',
        own[-1] <= own[0])
    whole = sum(not row['state_whole'] for row in rows)
    add('state files that cannot be read', whole, 0, not whole)
    judged = [row['went_on'] for row in rows if row['went_on'] is not None]
    add('starts with another state than the file had', judged.count(False),
        f'0 of {len(judged)}', not judged.count(False) and judged)
    add('state holds what was adapted, and drift', f'{data["adapted"]}, {data["points"]}',
        'True, > 0 points', data['adapted'] and data['points'] > 0)
    stamps = [row['windows'] for row in rows]
    add('drift went back', sum(b < a for a, b in zip(stamps, stamps[1:])), 0,
        stamps == sorted(stamps))
    return table.rows


def text(data):
    """Return figures and verdicts for the terminal."""
    rows = data['rows']
    lines = [f'{len(rows)} times plant, estimator, recorder: '
             f'{len({tuple(row["order"]) for row in rows})} orders, '
             f'{sum(row["early"] for row in rows)} times stopped without waiting for a start, '
             f'{sum(not row["ready"] for row in rows)} before the estimator was ready, '
             f'{len({row["windows"] for row in rows})} states written', '']
    lines += [f'  {text}' for row in rows for text in row['wrong_ends']]
    lines += [f'  left: {name}' for names in data['left'].values() for name in names]
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    require_whole('--times', args.times)
    expect_folder_of(args.json)
    data = evaluate(args.times, args.seed)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
