# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
How much live estimators stand: samples dropped, latency and CPU against rate and number.

A simulated drive feeds real nodes over DDS, on this machine only, in a ROS domain of its own. All
estimators share one core, in one process or one each; the source has the other cores. Latency:
from sending a stamped sample to publishing its estimate. And more is sent than can be taken.
With --naming one estimator names the cause of an alert meanwhile, on the same core, and the same
run is repeated without.
benchmarks/README.md explains the tables.

usage examples:
  .venv/bin/python test/system/load.py
  .venv/bin/python test/system/load.py --rates 1000 --numbers 1 7 14 --seconds 30
  .venv/bin/python test/system/load.py --json load.json
  .venv/bin/python test/system/load.py --naming --rates 1000
"""
import os
import sys
import time

from node_processes import live_nodes, usage
import numpy as np
from sample_source import NOTHING_SAID, SampleSource
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of
from gearbox_monitor.ros.gearbox_input import DEPTH

RATES, NUMBERS = (100.0, 500.0, 1000.0, 2000.0, 4000.0), (1, 2, 4, 8)
SECONDS, PAST = 10.0, 20_000.0
BARS = {100.0: 0.010, 500.0: 0.010, 1000.0: 0.010, 2000.0: 0.010}  # s, p99 of one gearbox
# s of a healthy drive, and within which the cause of its change must be named; the change.
HEALTHY, NAMED, CHANGE = 14.0, 900.0, {'half_gap': 0.15}
LATE = 0.01  # share of samples sent late from which on the source is the limit
# Past the limit: the queue's length in time, and some for the machine; growth of memory.
SLACK, GROWTH = 2.0, 16e6
LAYOUTS = ONE, EACH = 'one process', 'a process each'


def add_arguments(parser):
    parser.add_argument('--rates', type=float, nargs='+', default=list(RATES), metavar='HZ',
                        help=f'default: {" ".join(f"{r:g}" for r in RATES)}')
    parser.add_argument('--numbers', type=int, nargs='+', metavar='N',
                        help='of gearboxes; a rate is left out beyond the first number that '
                        f'drops samples (default: {" ".join(map(str, NUMBERS))})')
    parser.add_argument('--seconds', type=float, metavar='S',
                        help=f'length of each run (default: {SECONDS:g})')
    parser.add_argument('--past', type=float, metavar='HZ',
                        help=f'rate that is more than can be taken (default: {PAST:g})')
    parser.add_argument('--naming', action='store_true', help='compare runs of one gearbox in '
                        'which the cause of an alert is named with the same without; of the '
                        'other options, --rates and --json')
    add_json_option(parser)


def evaluate(rates, numbers, seconds, past):
    """Return all figures as plain data; the numbers of gearboxes ascend."""
    rows, over = [], None
    total = len(LAYOUTS) * len(numbers) * len(rates) + 1
    with live_nodes() as nodes, tqdm(total=total, desc='load', disable=None, leave=False) as bar:
        for layout in LAYOUTS:
            left = set(rates)
            for number in numbers:
                if layout == EACH and number == 1:
                    bar.update(len(rates))
                    continue  # the same
                with _Estimators(nodes, layout, number) as estimators:
                    for rate in rates:
                        if rate in left:
                            rows.append(estimators.run(rate, seconds))
                            if not _held(rows[-1]):
                                left.remove(rate)
                        bar.update()
                    if over is None:
                        over = estimators.run(past, seconds)
                        bar.update()
    return {'seconds': seconds, 'cores': os.cpu_count(), 'runs': rows, 'past': over,
            'bars': bars(rows, over)}


def with_naming(rates):
    """Return the rows of one gearbox with and without naming, as plain data."""
    rows = []
    with live_nodes() as nodes:
        for rate in rates:
            seconds = NAMED
            for naming in (True, False):
                file = nodes.folder / f'{rate:g}_{naming}.yaml'
                with _Estimators(nodes, ONE, 1, {
                        'drift_window': 2.0, 'name_changes': naming, 'baseline_file': str(file)
                        }) as estimators:
                    rows.append(estimators.name(rate, seconds, naming))
                    seconds = rows[-1]['seconds']
    table = BarTable()
    for named, plain in zip(rows[::2], rows[1::2]):
        table.check(f'{named["rate"]:g} Hz: the cause is named', named['effect'], 'backlash_gap',
                    named['effect'] == 'backlash_gap')
        table.check(f'{named["rate"]:g} Hz: samples dropped with naming', str(named['dropped']),
                    f'<= {plain["dropped"]}, without', named['dropped'] <= plain['dropped'])
    return {'naming': rows, 'bars': table.rows}


def naming_text(data):
    """Return the figures of with_naming as a table for the terminal."""
    lines = ['  naming      Hz      s      sent   dropped    p99 ms    max ms  effect']
    for row in data['naming']:
        lines.append(
            f'  {"yes" if row["naming"] else "no":6s}{row["rate"]:8g}{row["seconds"]:7.0f}'
            f'{row["sent"]:10d}{row["dropped"]:10d}{1e3 * row["p99"]:10.2f}'
            f'{1e3 * row["max"]:10.1f}  {row["effect"]}')
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


def _held(row):
    return row['dropped'] == 0


class _Estimators:
    """`number` of estimators on the last core, and their SampleSource on the others."""

    def __init__(self, nodes, layout, number, parameters=None):
        self.nodes, self.layout, self.number = nodes, layout, number
        self._parameters = parameters or {}

    def __enter__(self):
        cores = sorted(os.sched_getaffinity(0))
        self._cores = cores
        names = [f'g{k}' for k in range(self.number)]
        self.source = None
        try:
            if self.layout == ONE:
                self._start('estimators', names)
            else:
                for name in names:
                    self._start(name, [name])
            if len(cores) > 1:
                os.sched_setaffinity(0, cores[:-1])
            self.source = SampleSource(self.nodes.domain, names)
            self.nodes.until(self.source.ready, 'a start of all estimators',
                             lambda: self.source.spin(0.1))
            self.source.begin(100.0)  # they know the source only a while after it knows them
            while not all(self.source.taken):
                self.source.in_real_time(0.5)
            self.source.finish()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _start(self, name, arguments):
        self.nodes.start(name, 'load_estimators', {'arm_load': 'none', **self._parameters},
                         arguments, cores=self._cores[-1:])

    def __exit__(self, *_):
        if self.source is not None:
            self.source.close()
        self.nodes.end()
        os.sched_setaffinity(0, self._cores)

    def run(self, rate, seconds):
        """Return the row of one run."""
        source, pids = self.source, [child.process.pid for child in self.nodes.children]
        memory = []

        def tick():
            memory.append(sum(usage(pid).memory for pid in pids))
        source.begin(rate)
        source.slowly()
        source.finish()
        told, not_ok = source.told(), len(source.not_ok)
        source.measure()
        before, began = [usage(pid).cpu for pid in pids], time.monotonic()
        source.in_real_time(seconds, tick)
        took = time.monotonic() - began
        cpu = sum(usage(pid).cpu for pid in pids) - sum(before)
        source.slowly()  # that the last ones were lost shows by the number of the next
        source.finish()
        latency = np.concatenate([np.asarray(row) for row in source.latencies])
        p50, p99, most = np.quantile(latency, (0.5, 0.99, 1.0)) if len(latency) else [np.nan] * 3
        inputs = [text for _, name, text in source.not_ok[not_ok:]
                  if name.endswith(': input') and 'messages lost' in text]
        return {
            'layout': self.layout, 'number': self.number, 'rate': rate, 'sent': source.sent,
            'late': source.late / source.sent, 'dropped': source.missing(),
            'counted': source.told() - told, 'told_not_ok': bool(inputs),
            'estimates_per_s': len(latency) / took, 'cpu': cpu / took, 'p50': float(p50),
            'p99': float(p99), 'max': float(most), 'memory': memory}

    def name(self, rate, seconds, naming):
        """
        Return the row of one run whose drive changes.

        Args:
            rate: Hz.
            seconds: since the change; at most so many until it is named.
            naming: whether its cause is.

        """
        source = self.source
        source.begin(rate)
        source.slowly()
        source.in_real_time(HEALTHY)
        source.save_baseline('g0')
        source.measure()
        source.changes.update(CHANGE)
        began, effect = time.monotonic(), ''
        while time.monotonic() < began + seconds and not effect:
            source.in_real_time(1.0)
            if naming:
                said = source.outcomes.get('g0/estimator: diagnosis', NOTHING_SAID)
                effect = said.values.get('effect', '')
        took = time.monotonic() - began
        source.slowly()
        source.finish()
        latency = np.asarray(source.latencies[0])
        p99, most = np.quantile(latency, (0.99, 1.0))
        return {'naming': naming, 'rate': rate, 'seconds': took, 'sent': source.sent,
                'dropped': source.missing(), 'p99': float(p99), 'max': float(most),
                'effect': effect}


def bars(rows, over):
    """Return the rows of a BarTable for the runs `rows` and the run past the limit, `over`."""
    table = BarTable()
    add = table.check
    for row in rows:
        if row['number'] == 1 and row['rate'] in BARS:
            limit = BARS[row['rate']]
            add(f'1 gearbox, {row["rate"]:g} Hz: samples dropped', str(row['dropped']), '0',
                row['dropped'] == 0)
            add(f'1 gearbox, {row["rate"]:g} Hz: p99 of latency', f'{1e3 * row["p99"]:.2f} ms',
                f'<= {1e3 * limit:g} ms', row['p99'] <= limit)
    wrong = sum(row['counted'] != row['dropped'] for row in rows)
    add('runs whose drops the nodes count otherwise', str(wrong), '0', wrong == 0)
    bound = SLACK * DEPTH / over['estimates_per_s'] if over['estimates_per_s'] else 0.0
    memory = over['memory'][len(over['memory']) // 3:]
    growth = max(memory) - memory[0] if memory else 0.0
    add(f'past the limit ({over["rate"]:g} Hz): samples dropped', str(over['dropped']), '> 0',
        over['dropped'] > 0)
    add('past the limit: drops that the node counts', str(over['counted']),
        str(over['dropped']), over['counted'] == over['dropped'])
    add('past the limit: input says it', str(over['told_not_ok']), 'True', over['told_not_ok'])
    add('past the limit: longest latency', f'{over["max"]:.2f} s',
        f'<= {bound:.2f} s, {SLACK:g} full queues', over['max'] <= bound)
    add('past the limit: memory grows by', f'{1e-6 * growth:.1f} MB', f'<= {1e-6 * GROWTH:g} MB',
        growth <= GROWTH)
    return table.rows


def text(data):
    """Return the figures as tables for the terminal."""
    lines = ['  gearboxes in       number    Hz   dropped  counted    p50 ms    p99 ms  max ms'
             '  CPU of core']
    for row in [*data['runs'], data['past']]:
        lines.append(
            f'  {row["layout"]:<18}{row["number"]:7d}{row["rate"]:7g}{row["dropped"]:9d}'
            f'{row["counted"]:9d}{1e3 * row["p50"]:10.2f}{1e3 * row["p99"]:10.2f}'
            f'{1e3 * row["max"]:8.1f}{row["cpu"]:12.0%}'
            + (f'  source late: {row["late"]:.1%}' if row['late'] > LATE else ''))
    lines += ['', '  highest number without a dropped sample']
    layouts, rates = (dict.fromkeys(row[key] for row in data['runs'])
                      for key in ('layout', 'rate'))
    for layout in layouts:
        best = {rate: max((row['number'] for row in data['runs'] if row['rate'] == rate
                           and row['layout'] in (layout, ONE if row['number'] == 1 else layout)
                           and _held(row)), default=0) for rate in rates}
        lines.append(f'  {layout:<18}' + ', '.join(
            f'{rate:g} Hz: {number}' for rate, number in best.items()))
    return '\n'.join([*lines, '', *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    for option in ('numbers', 'seconds', 'past'):
        if args.naming and getattr(args, option) is not None:
            raise InputError(f'--{option} with --naming: one gearbox runs until its change is '
                             'named, expected no such option')
    rates, numbers = sorted(set(args.rates)), sorted(set(args.numbers or NUMBERS))
    seconds, past = (default if value is None else value for value, default in (
        (args.seconds, SECONDS), (args.past, PAST)))
    for option, values in (('--rates', rates), ('--seconds', [seconds]), ('--past', [past])):
        if not all(0.0 < value < np.inf for value in values):
            raise InputError(f'{option}: {" ".join(f"{v:g}" for v in values)}, expected > 0')
    if numbers[0] < 1:
        raise InputError(f'--numbers: {numbers[0]}, expected whole numbers >= 1')
    expect_folder_of(args.json)
    if args.naming:
        data = with_naming(rates)
        return finish(data, naming_text(data), args.json)
    data = evaluate(rates, numbers, seconds, past)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
