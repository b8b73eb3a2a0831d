# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Compare several filters on one recording.

All use the same model and the same parameters (tune them first). Errors appear if the bag contains
a true or measured torque (plant/transmission_state or reference/transmission_state).

columns: tau_K rms error of the filtered and of the smoothed torque (N m); share of errors within
one stated deviation (0.68 expected); log-likelihood; mean NIS (2 expected); Ljung-Box statistic of
the worse encoder (white below the limit named); CPU time per sample, and over the EKF's.

usage examples:
  gearbox_monitor compare BAG --filters ekf,ukf,srukf,aekf --params tuned.yaml
  gearbox_monitor compare BAG --png compare.png
  gearbox_monitor compare BAG --model drive.yaml --json
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import cycle
from pathlib import Path
import sys
import time
from typing import Any, TypeAlias

import numpy as np

from gearbox_monitor.cli.inputs import load_filter_inputs
from gearbox_monitor.cli.options import (
    add_estimator_arguments, check_filter, opened, show, warn, write_files)
from gearbox_monitor.cli.progress import count_bar
from gearbox_monitor.errors import expect_matplotlib, InputError
from gearbox_monitor.estimation import sample_loop
from gearbox_monitor.estimation.estimates import Estimates, Samples
from gearbox_monitor.estimation.estimator import Estimator, unsmoothed
from gearbox_monitor.estimation.score import (
    reference_at, score, settled, torque_errors, WHITE_LIMIT)
from gearbox_monitor.files.yaml_files import expect_new_file
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.parameters import EstimatorParameters, FILTER_NAMES
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.recordings.read import BagReader
from gearbox_monitor.recordings.recorded_samples import RecordedSamples, sliced
from gearbox_monitor.recordings.replay import truth, truth_of
from gearbox_monitor.recordings.topics import PLANT_TRANSMISSION_STATE
from gearbox_monitor.report.chart import Chart, LoopSlice, Panel, Plane, Trace

KnownTorque: TypeAlias = tuple[Integers, Array]  # stamps [N] ns, torque [N] N m
WARM_UP = 200  # samples that a filter takes before it is timed: kernels are compiled by then
REPEATS = 3    # runs of which the fastest counts
SHORTEST = 1000  # samples
ZOOM = 1.0       # s of torque in the picture
COLOURS = ('closed', 'late', 'signal', 'error', 'nominal')


@dataclass(frozen=True)
class FilterResult:
    """Estimates of one filter, CPU time per sample (s), divergences and notes about them."""

    name: str
    estimates: Estimates
    cpu: float
    diverged: int
    notes: Sequence[str] = ()


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_estimator_arguments(parser)
    parser.add_argument('--filters', default=','.join(FILTER_NAMES), metavar='A,B,...',
                        help='filters, separated by commas (default: all)')
    parser.add_argument('--png', metavar='FILE', help='write the figure')
    parser.add_argument('--json', action='store_true', help='print the table as JSON')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    names = [check_filter(name.strip()) for name in args.filters.split(',')]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f'--filters: {name!r} twice, expected each filter once')
    expect_new_file(args.png)
    if args.png and Path(args.png).suffix.lower() != '.png':
        raise InputError(f'{args.png}: expected a name that ends in .png')
    if args.png:
        expect_matplotlib('--png')
    with opened(args) as reader:
        inputs = load_filter_inputs(args, reader)
        torque = truth(reader, inputs.recording)
        twist = None if torque is None else _true_twist(reader, inputs.recording)
        notes = list(inputs.notes)
    samples, count = inputs.samples, len(inputs.samples.stamp_ns)
    if count < SHORTEST:
        raise InputError(f'{args.bag}: {count} samples, too short to compare, expected at least '
                         f'{SHORTEST}')
    results = []
    with count_bar('compare', len(names)) as bar:
        for name in names:
            bar.set_description_str(f'compare: {name}')
            try:
                results.append(run_filter(name, inputs.model, inputs.parameters, samples))
            except InputError as error:
                raise InputError(f'{args.bag}: {error}') from None
            bar.update()
    notes += [f'{result.name}: {note}' for result in results for note in result.notes]
    data = {'bag': args.bag, 'samples': len(samples.stamp_ns), 'white_limit': WHITE_LIMIT,
            'rows': [row(result, results, torque) for result in results], 'notes': notes}
    data = {'summary': summary(data, inputs.model.axis), **data}
    if args.png:
        _draw(args, results, torque, twist, inputs.model.axis)
    warn(args, notes)
    show(args, data, lambda: text(data, inputs.model.axis))
    return 0


def run_filter(name: str, model: DriveModel, parameters: EstimatorParameters,
               samples: Samples) -> FilterResult:
    """
    Run a filter on a recording.

    Args:
        name: of the filter.
        model: of the drive.
        parameters: of the estimator.
        samples: of the recording.

    Returns:
        Its estimates and the CPU time of its fastest run.

    Raises:
        InputError: the filter cannot take these samples.

    """
    parameters = parameters.replace(filter=name)
    estimator = Estimator(model, parameters)
    estimates = estimator.run(samples)
    # Timed without smoothing: what remains is the filter and its loop.
    bare = unsmoothed(parameters)
    Estimator(model, bare).run(sliced(samples, 0, WARM_UP))
    cpu = []
    for _ in range(REPEATS):
        timed = Estimator(model, bare)
        begin = time.process_time()
        timed.run(samples)
        cpu.append(time.process_time() - begin)
    return FilterResult(name, estimates, min(cpu) / len(samples.stamp_ns),
                        int(estimator.counts[sample_loop.DIVERGED]),
                        tuple(estimator.divergence_notes()))


def row(result: FilterResult, results: Sequence[FilterResult],
        torque: KnownTorque | None) -> dict[str, Any]:
    """
    Return a row of the table as {column: value}.

    Args:
        result: of the filter.
        results: of all filters; the CPU time is compared with that of the EKF.
        torque: true or measured, (stamps [N] ns, torque [N] N m), or None.

    """
    data = asdict(score(result.estimates, result.name, result.diverged))
    errors = torque_errors(result.estimates, *torque) if torque is not None else {}
    for name in ('rmse', 'rmse_smoothed', 'coverage', 'coverage_smoothed'):
        data[name] = errors.get(name)
    data['cpu_us'] = 1e6 * result.cpu
    ekf = next((r for r in results if r.name == 'ekf'), None)
    data['cpu_ratio'] = result.cpu / ekf.cpu if ekf else None
    return {name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in data.items()}


def summary(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the comparison `data` on a drive with `axis` in one sentence."""
    rated = [r for r in data['rows'] if r['rmse'] is not None]
    if rated:
        nearest, farthest = (choose(rated, key=lambda r: r['rmse']) for choose in (min, max))
        words = f'{nearest["filter"]} comes nearest to the torque: {nearest["rmse"]:.4g} N m rms'
        last = f'{farthest["filter"]}, the farthest: {farthest["rmse"]:.4g}'
    else:
        rows = [r for r in data['rows'] if r['loglik'] is not None]
        if not rows:
            return 'No filter has estimates to compare.'
        nearest, farthest = (choose(rows, key=lambda r: r['loglik']) for choose in (max, min))
        words = f'{nearest["filter"]} is the likeliest: log-likelihood {nearest["loglik"]:.1f}'
        last = f'{farthest["filter"]}, the least: {farthest["loglik"]:.1f}'
    return on_axis(words, axis) + (f' ({last}).' if nearest is not farthest else '.')


def text(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the table `data` of a drive with `axis` as lines of at most 80 columns."""
    lines = [data['summary'], '', f'bag  {data["bag"]}, {data["samples"]} samples', '',
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


def _white(value: float | None) -> str:
    """Return a Ljung-Box figure in at most seven columns up to a million."""
    return _show(value, '.1f' if value is None or value < 1e4 else '.0f')


def _show(value: float | None, form: str) -> str:
    return '-' if value is None or not np.isfinite(value) else format(value, form)


def _true_twist(reader: BagReader, recording: RecordedSamples) -> Array | None:
    """Return the true twist [N] beside the torque in the bag, None if it has the torque only."""
    source = truth_of(reader, recording.namespace, recording.transmission)
    if source is None or not source.topic.endswith(PLANT_TRANSMISSION_STATE):
        return None
    return reader.joint_states(source.topic, (source.joint,)).position[:, 0]


def _draw(args: Namespace, results: Sequence[FilterResult], torque: KnownTorque | None,
          twist: Array | None, axis: str) -> None:
    """Write the figure: a loop of each filter, torque and errors of all."""
    from gearbox_monitor.report.plots import figure
    origin = min(r.estimates.stamp_ns[0] for r in results)
    end = max(r.estimates.stamp_ns[-1] for r in results)
    middle = 0.5e-9 * (min(r.estimates.stamp_ns[-1] for r in results) - origin)
    span = (middle - 0.5 * ZOOM, middle + 0.5 * ZOOM)
    tau_k, errors, loop = list[Trace](), list[Trace](), list[Trace]()
    if torque is not None:
        stamps, value = torque
        keep = (stamps >= origin) & (stamps <= end)
        tau_k.append(Trace((stamps[keep] - origin) * 1e-9, value[keep], 'true', 'recording'))
        if twist is not None:
            loop.append(Trace(twist[keep], value[keep], 'true', 'recording'))
    planes = []
    for r, role in zip(results, cycle(COLOURS)):
        e = r.estimates
        keep = settled(e.stamp_ns)
        t = (e.stamp_ns[keep] - origin) * 1e-9
        tau_k.append(Trace(t, e.tau_k[keep], r.name, role))
        if torque is not None:
            value, valid = reference_at(e.stamp_ns, *torque)
            errors.append(Trace(t, np.where(valid, e.tau_k - value, np.nan)[keep], '', role))
        planes.append(Plane(r.name, [LoopSlice(r.name, (e.twist[keep], e.tau_k[keep]))],
                            on_axis('twist, motor - arm (rad)', axis),
                            on_axis('torque (N m)', axis), traces=loop))
    panels = [Panel(on_axis('torque, filtered (N m)', axis), [t.within(span) for t in tau_k])]
    if errors:
        panels.append(Panel(on_axis('error against the truth (N m)', axis),
                            [t.within(span) for t in errors], 0.0))
    write_files({Path(args.png): figure(
        [*(planes[k:k + 3] for k in range(0, len(planes), 3)),
         [Chart(f'{ZOOM:g} s of it', panels, 'time (s)', span=span)]],
        f'Filters on {Path(args.bag).name}')})
    print(f'compare: wrote {args.png}', file=sys.stderr)
