# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
A long run of one live estimator: memory, handles, threads, rate and false alerts over time.

--hours: that much time of the stamps as fast as the node takes the samples, each sample waiting
for room, so that none is lost. --minutes: in real time. A simulated healthy drive is the source,
over DDS, on this machine only; below 500 Hz one that is slower in proportion: the packaged drive
moves too far in 10 ms. benchmarks/README.md explains the bars.

usage examples:
  .venv/bin/python test/system/soak.py --hours 24 --rate 100
  .venv/bin/python test/system/soak.py --minutes 20 --rate 1000 --json soak.json
"""
import sys
import time

from node_processes import live_nodes, usage
import numpy as np
from sample_source import NOTHING_SAID, parameters_of, SampleSource, slowness
from scipy.stats import theilslopes
from script import run_script
from tqdm import tqdm

from benchmarks.harness import add_json_option, bar_lines, BarTable, finish
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.user_files import expect_folder_of

WINDOW = 500         # samples that may wait for their estimate: a quarter of the node's queue
LEAD = 2.0           # s of samples before the measurement
SETTLE = 15.0        # s of stamps, of the packaged drive, until all components have been judged
SEEN = 1.5           # s: so long before diagnostics the node may have looked for new stamps
GROWTH = 4.0         # MB, over the part that is judged
RATE_DRIFT, SLOWER = 1e-3, 0.8
LEAST = 20           # looks at the node in the part that is judged


def add_arguments(parser):
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument('--hours', type=float, metavar='H',
                        help='of stamps, as fast as the node takes them')
    length.add_argument('--minutes', type=float, metavar='M', help='in real time')
    parser.add_argument('--rate', type=float, default=1000.0, metavar='HZ',
                        help='default: %(default)g')
    parser.add_argument('--every', type=float, default=1.0, metavar='S',
                        help='how often to look at the node (default: %(default)g)')
    add_json_option(parser)


def evaluate(seconds, rate, real_time, every=1.0):
    """Return all figures of a run of `seconds` of stamps as plain data."""
    slow = slowness(rate)
    parameters = parameters_of(slow)
    rows, count = [], round(seconds * rate)
    with live_nodes() as nodes, tqdm(total=round(seconds), unit='s', desc='soak', disable=None,
                                     leave=False) as bar:
        child = nodes.start('estimator', 'load_estimators',
                            parameters, ['g0'])
        source = SampleSource(nodes.domain, ['g0'])
        try:
            nodes.until(source.ready, 'a start of the estimator', lambda: source.spin(0.1))
            source.begin(rate, slow)
            while not source.taken[0]:
                source.in_real_time(LEAD)
            source.finish()
            source.measure()
            told, began = source.told(), time.monotonic()

            def tick():
                child.check()
                used, latencies = usage(child.process.pid), source.latencies[0]
                values = source.outcomes.get('g0/estimator: input', NOTHING_SAID).values
                rows.append({
                    'clock': time.time_ns(), 'rate_hz': float(values.get('rate_hz', 'nan')),
                    'wall': time.monotonic() - began, 'stamps': source.sent / rate,
                    'estimates': source.taken[0], 'memory': used.memory,
                    'handles': used.handles, 'threads': used.threads, 'cpu': used.cpu,
                    'latency': [float(v) for v in np.quantile(latencies, (0.5, 0.99, 1.0))]
                    if latencies else None})
                latencies.clear()
                bar.update(round(rows[-1]['stamps']) - bar.n)
            if real_time:
                source.in_real_time(seconds, tick, every)
            else:
                source.as_fast_as_taken(count, WINDOW, tick, every)
            ended = time.time_ns()
            source.finish()
        finally:
            source.close()
        errors = [line for line in child.log.read_text().splitlines() if '[ERROR]' in line]
    settled = next((row['clock'] for row in rows if row['stamps'] > SETTLE * slow), np.inf)
    told_ns = [(at, f'{name}: {text}') for at, name, text in source.not_ok
               if settled < at < ended]
    silences = [text for at, text in told_ns if _silent(text, at, source.pauses)]
    data = {
        'seconds': seconds, 'rate': rate, 'real_time': real_time, 'sent': source.sent,
        'late': source.late, 'missing': source.missing(), 'counted': source.told() - told,
        'alerts': source.alerts, 'errors': errors, 'parameters': parameters, 'rows': rows,
        'not_ok': [text for at, text in told_ns if not _silent(text, at, source.pauses)],
        'judged': bool(np.isfinite(settled)), 'silences': len(silences),
        'longest_pause': 1e-9 * max((b - a for a, b in source.pauses
                                     if settled < b and a < ended), default=0)}
    return {**data, 'bars': bars(data)}


def _silent(text, at, pauses):
    """Return whether `text`, told `at` (ns), says that no sample came, and it is true."""
    return ('no data' in text or 'no samples received' in text) and any(
        begin < at and end > at - SEEN * 1e9 for begin, end in pauses)


def slope(x, y):
    """Return [slope, its 95 % interval] of y over x by Theil and Sen, which outliers spare."""
    found = theilslopes(y, x, 0.95)
    return [float(found[0]), float(found[2]), float(found[3])]


def judged(data):
    """Return the rows that are judged: the last two thirds, when memories have filled."""
    return [row for row in data['rows'] if row['stamps'] > data['seconds'] / 3.0]


def _rate(rows):
    """Return estimates per s in `rows`; a short pause of the machine does not count."""
    return slope([row['wall'] for row in rows], [row['estimates'] for row in rows])[0]


def bars(data):
    """Return the rows of a BarTable for the figures `data` of evaluate()."""
    table = BarTable()
    add = table.check
    rows = judged(data)
    if len(rows) < LEAST:
        raise InputError(f'--minutes or --hours: {len(rows)} looks at the node in the part that '
                         f'is judged, expected at least {LEAST}: a longer run, or --every')
    wall, memory = (np.array([row[key] for row in rows]) for key in ('wall', 'memory'))
    span = wall[-1] - wall[0]
    per_s, low, high = slope(wall, memory * 1e-6)
    hour = 3600.0
    data['memory_mb_per_h'] = [per_s * hour, low * hour, high * hour]
    add('samples without estimate', str(data['missing']), '0', data['missing'] == 0)
    add(f'memory: slope over {span / 60.0:.1f} min',
        f'{per_s * hour:+.2f} MB/h', f'0 (95 %: {low * hour:+.2f} to {high * hour:+.2f})',
        low <= 0.0 <= high or abs(high) * span <= GROWTH)
    add('memory: growth by the upper end', f'{high * span:+.2f} MB', f'<= {GROWTH:g} MB',
        high * span <= GROWTH)
    for name in ('handles', 'threads'):
        values = [row[name] for row in rows]
        add(name, f'{min(values)} to {max(values)}', 'constant', min(values) == max(values))
    stated = [row['rate_hz'] for row in rows if np.isfinite(row['rate_hz'])]
    add('samples per second of stamps, as the node states it',
        f'{min(stated):g} to {max(stated):g}' if stated else 'nothing', f'{data["rate"]:g} +- 1',
        stated and max(abs(rate - data['rate']) for rate in stated) <= 1.0)
    part = len(rows) // 3
    if data['real_time']:
        drift = _rate(rows[-part:]) / _rate(rows[:part]) - 1.0
        add('estimates per second, last third over first', f'{1e6 * drift:+.0f} ppm',
            f'within {1e6 * RATE_DRIFT:g} ppm', abs(drift) <= RATE_DRIFT)
    else:
        cost = [(part[-1]['cpu'] - part[0]['cpu']) / (part[-1]['estimates'] - part[0]['estimates'])
                for part in (rows[:part], rows[-part:])]
        add('CPU per sample, first third over last', f'{cost[0] / cost[1]:.2f}',
            f'>= {SLOWER:g}', cost[0] / cost[1] >= SLOWER)
    add('drift alerts', str(len(data['alerts'])), '0', not data['alerts'])
    add('levels other than OK', str(len(data['not_ok'])) if data['judged'] else 'too short', '0',
        data['judged'] and not data['not_ok'])
    add('errors in the log', str(len(data['errors'])), '0', not data['errors'])
    return table.rows


def text(data):
    """Return figures and verdicts for the terminal."""
    rows = data['rows']
    lines = [f'{data["seconds"] / 3600.0:.2f} h of stamps at {data["rate"]:g} Hz in '
             f'{rows[-1]["wall"] / 60.0:.1f} min, {data["sent"]} samples, '
             f'{data["sent"] / rows[-1]["wall"]:.0f} per second, '
             f'{rows[-1]["cpu"] / rows[-1]["wall"]:.0%} of a core', '',
             '  minutes   hours of stamps   memory MB   handles   threads   p50 ms   p99 ms'
             '   max ms']
    for k in np.unique(np.linspace(0, len(rows) - 1, 11).round().astype(int)):
        row = rows[k]
        latency = ''.join(f'{1e3 * v:9.2f}' for v in row['latency'] or [])
        lines.append(f'{row["wall"] / 60.0:9.2f}{row["stamps"] / 3600.0:18.3f}'
                     f'{1e-6 * row["memory"]:12.1f}{row["handles"]:10d}{row["threads"]:10d}'
                     f'{latency}')
    if data['silences']:
        lines += ['', f'  {data["silences"]} times a component said that no sample came, which '
                  f'was so: pauses of up to {data["longest_pause"]:.1f} s']
    lines += ['', *(f'  alert: {told}' for told in data['alerts'][:5]),
              *(f'  not OK: {told}' for told in data['not_ok'][:5]),
              *(f'  log: {told}' for told in data['errors'][:5])]
    return '\n'.join([*lines, *bar_lines(data['bars'])])


def run(args):
    """Run the benchmark; returns 1 when a bar is missed."""
    option, value = ('--hours', args.hours) if args.minutes is None else (
        '--minutes', args.minutes)
    for name, number in ((option, value), ('--rate', args.rate), ('--every', args.every)):
        if not 0.0 < number < np.inf:
            raise InputError(f'{name}: {number:g}, expected > 0')
    expect_folder_of(args.json)
    seconds = 3600.0 * args.hours if args.minutes is None else 60.0 * args.minutes
    data = evaluate(seconds, args.rate, args.minutes is not None, args.every)
    return finish(data, text(data), args.json)


if __name__ == '__main__':
    sys.exit(run_script(sys.modules[__name__]))
