# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
Run several filters on one recording and set them side by side.

All get the same model and the same parameters (tune them first). filterpy_ekf and filterpy_ukf are
the filters of the package filterpy on the same process model; being tens of times slower they
take only the first part of a long bag (--filterpy-samples), and so do the others then, so that the
figures can be compared. Errors appear where the bag holds a true or measured torque
(plant/transmission_state or reference/transmission_state).

columns: tau_K rms error of the filtered and of the smoothed torque (N m); share of errors within
one stated deviation (0.68 expected); log-likelihood; mean NIS (2 expected); Ljung-Box statistic of
the worse encoder (white below the limit named); CPU time per sample, and over the EKF's.

usage examples:
  gearbox_monitor compare BAG --filters ekf,ukf,srukf,aekf --params tuned.yaml
  gearbox_monitor compare BAG --filters ekf,filterpy_ekf,filterpy_ukf --png compare.png
  gearbox_monitor compare BAG --model drive.yaml --json

exit code: 0 done, 2 bad usage or input.
"""
from dataclasses import asdict, dataclass
import json
from pathlib import Path
import sys
import time

import numpy as np
from tqdm import tqdm

from gearbox_monitor.bag.read import open_bag
from gearbox_monitor.bag.replay import truth
from gearbox_monitor.benchmarks import filterpy_reference
from gearbox_monitor.cli.inputs import add_input_arguments, check_filter, load
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.score import known_at, score, settled, torque_errors, WHITE_LIMIT
from gearbox_monitor.monitoring.monitor import Monitor, Samples
from gearbox_monitor.parameters import FILTER_NAMES
from gearbox_monitor.plant.units import on_axis
from gearbox_monitor.report import compare_plot, plots

WARM_UP = 200  # samples that a filter takes before it is timed: kernels are compiled by then
REPEATS = 3    # runs of which the fastest counts
SHORTEST = 1000


@dataclass(frozen=True)
class Result:
    """What one filter gave: estimates, CPU time per sample (s), divergences and words on them."""

    name: str
    estimates: object
    cpu: float
    diverged: int
    notes: tuple = ()


def add_arguments(parser):
    """Declare the options."""
    add_input_arguments(parser)
    parser.add_argument('--filters', default=','.join(FILTER_NAMES), metavar='A,B,...',
                        help='filters, separated by commas: '
                        + ', '.join((*FILTER_NAMES, *filterpy_reference.NAMES)))
    parser.add_argument('--png', metavar='FILE', help='write the figure')
    parser.add_argument('--filterpy-samples', type=int, default=20000, metavar='N',
                        help='with a filter of filterpy, take the first N samples only '
                        '(default: %(default)s)')
    parser.add_argument('--json', action='store_true', help='print the table as JSON')


def run(args):
    """Run the command; returns the exit code."""
    names = [check_filter(name.strip(), filterpy_reference.NAMES)
             for name in args.filters.split(',')]
    names = list(dict.fromkeys(names))
    if args.filterpy_samples < SHORTEST:
        raise InputError(f'--filterpy-samples: {args.filterpy_samples}, expected at least '
                         f'{SHORTEST}')
    if args.png and Path(args.png).exists():
        raise InputError(f'{args.png}: exists, expected a new file')
    if args.png and Path(args.png).suffix.lower() != '.png':
        raise InputError(f'{args.png}: expected a name that ends in .png')
    with open_bag(args.bag) as reader:
        inputs = load(args, reader)
        known = truth(reader, inputs.recording)
        twist = _true_twist(reader, inputs.recording) if known is not None else None
        notes = [reader.notice] if reader.notice else []
    samples, count = inputs.samples, len(inputs.samples.stamp_ns)
    if count < SHORTEST:
        raise InputError(f'{args.bag}: {count} samples, too short to compare, expected at least '
                         f'{SHORTEST}')
    if set(names) & set(filterpy_reference.NAMES) and count > args.filterpy_samples:
        samples = Samples(*(getattr(samples, field)[:args.filterpy_samples]
                            for field in ('stamp_ns', 'u', 'y')))
        notes.append(f'first {args.filterpy_samples} of {count} samples only, for filterpy '
                     '(--filterpy-samples)')
    results = []
    for name in tqdm(names, desc='compare', disable=None, leave=False):
        try:
            results.append(run_filter(name, inputs.model, inputs.parameters, samples))
        except InputError as error:
            raise InputError(f'{args.bag}: {error}') from None
    notes += [f'{result.name}: {note}' for result in results for note in result.notes]
    data = {'bag': args.bag, 'samples': len(samples.stamp_ns), 'white_limit': WHITE_LIMIT,
            'rows': [row(result, results, known) for result in results], 'notes': notes}
    if args.png:
        _draw(args, results, known, twist, inputs.model.axis)
    print(json.dumps(data, indent=2) if args.json else text(data, inputs.model.axis))
    return 0


def run_filter(name, model, parameters, samples):
    """Return the Result of filter `name` on Samples. Raises InputError."""
    if name in filterpy_reference.NAMES:
        few = Samples(*(getattr(samples, field)[:3] for field in ('stamp_ns', 'u', 'y')))
        filterpy_reference.run(name, model, parameters, few)
        begin = time.process_time()
        estimates = filterpy_reference.run(name, model, parameters, samples)
        return Result(name, estimates,
                      (time.process_time() - begin) / len(samples.stamp_ns), 0)
    parameters = parameters.replace(filter=name)
    monitor = Monitor(model, parameters)
    estimates = monitor.run(samples)
    # Timed without smoothing and its drift windows: what remains is the filter and its loop.
    bare = parameters.replace(smoother_lag=0.0)
    few = Samples(*(getattr(samples, f)[:WARM_UP] for f in ('stamp_ns', 'u', 'y')))
    Monitor(model, bare).run(few)
    cpu = []
    for _ in range(REPEATS):
        timed = Monitor(model, bare)
        begin = time.process_time()
        timed.run(samples)
        cpu.append(time.process_time() - begin)
    return Result(name, estimates, min(cpu) / len(samples.stamp_ns),
                  int(monitor.counts[sample_loop.DIVERGED]), tuple(monitor.divergence_notes()))


def row(result, results, known):
    """Return {column: value} of one Result."""
    data = asdict(score(result.estimates, result.name, result.diverged))
    errors = torque_errors(result.estimates, *known) if known is not None else {}
    for name in ('rmse', 'rmse_smoothed', 'coverage', 'coverage_smoothed'):
        data[name] = errors.get(name)
    data['cpu_us'] = 1e6 * result.cpu
    ekf = next((r for r in results if r.name == 'ekf'), None)
    data['cpu_ratio'] = result.cpu / ekf.cpu if ekf else None
    return {name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in data.items()}


def text(data, axis='rotary'):
    """Return the table as lines of at most 80 columns."""
    lines = [f'bag  {data["bag"]}, {data["samples"]} samples', '',
             f'{"":12s}{"tau_K":>8s}{"smooth":>8s}{"in 1 s.":>8s}{"log-lik.":>11s}{"NIS":>7s}'
             f'{"white":>8s}{"us/step":>9s}{"/ EKF":>7s}']
    notes = list(data['notes'])
    for r in data['rows']:
        white = max((w for w in r['ljung_box'] if np.isfinite(w)), default=None)
        lines.append(
            f'{r["filter"]:12s}{_show(r["rmse"], ".4f"):>8s}{_show(r["rmse_smoothed"], ".4f"):>8s}'
            f'{_show(r["coverage"], ".2f"):>8s}{_show(r["loglik"], ".1f"):>11s}'
            f'{_show(r["nis"], ".3f"):>7s}{_white(white):>8s}'
            f'{_show(r["cpu_us"], ".2f"):>9s}{_show(r["cpu_ratio"], ".2f"):>7s}')
    band = data['rows'][0]
    lines += ['', f'errors in {on_axis("N m", axis)} rms; 95 % band of the mean NIS '
              f'{_show(band["nis_low"], ".3f")}..{_show(band["nis_high"], ".3f")}; white below '
              f'{data["white_limit"]:.1f}']
    if all(r['rmse'] is None for r in data['rows']):
        notes.append('no true or reference torque in the bag: no errors')
    lines += [f'note: {note}' for note in notes]
    return '\n'.join(lines)


def _white(value):
    """Return a Ljung-Box figure in at most seven columns up to a million."""
    return _show(value, '.1f' if value is None or value < 1e4 else '.0f')


def _show(value, form):
    return '-' if value is None or not np.isfinite(value) else format(value, form)


def _true_twist(reader, recording):
    """Return (stamps, twist) of the truth in the bag, or None where it holds a torque only."""
    topic = f'{recording.namespace}/plant/transmission_state'
    if topic not in reader.topics or not reader.topics[topic][1]:
        return None
    states = reader.joint_states(topic, ('transmission',))
    return states.stamp_ns, states.position[:, 0]


def _draw(args, results, known, twist, axis):
    """Write the figure."""
    origin = min(r.estimates.stamp_ns[0] for r in results)
    runs = []
    for r in results:
        e = r.estimates
        keep = settled(e.stamp_ns)
        error = None
        if known is not None:
            value, found = known_at(e.stamp_ns, *known)
            error = np.where(found, e.tau_k - value, np.nan)[keep]
        runs.append(compare_plot.FilterRun(
            r.name, (e.stamp_ns[keep] - origin) * 1e-9, e.twist[keep], e.tau_k[keep], error))
    shown = None
    if known is not None:
        inside = (known[0] >= origin) & (known[0] <= max(r.estimates.stamp_ns[-1]
                                                         for r in results))
        shown = compare_plot.TrueTorque((known[0][inside] - origin) * 1e-9, known[1][inside],
                                        twist[1][inside] if twist is not None else None)
    figure = compare_plot.comparison(runs, shown, f'Filters on {Path(args.bag).name}',
                                     axis=axis)
    try:
        plots.save(figure, args.png)
    except OSError as error:
        raise InputError(f'{args.png}: {error.strerror}, expected a new, writable file') from None
    print(f'compare: wrote {args.png}', file=sys.stderr)
