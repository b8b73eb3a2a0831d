# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Estimate R and Q of a filter from a recording, and write them as a parameter file.

The noise of the encoders (R) comes from a stretch of at least half a second in which motor and arm
stand still; without one it is estimated together with the process noise (Q) by maximising the
likelihood of the prediction errors. No truth is read. The search starts from the recording itself,
so the result does not depend on --params, which are the "before" and keep all other values. Record
at least 5 s in which the drive moves as it does at work; 20 s are better.

With --reference TOPIC (a JointState whose effort[0] is a measured torque, N m) Q makes the error
of tau_K small instead, and tau_k_model_std makes its stated deviation cover 68 %.

Unless --params or the bag states a law of tau_K, the file selects tau_k_model "mixed" and also
contains q_std_tau_k_deviation.

The file serves filter and drift monitor. With --smoother q_std_tau_k is divided by sqrt(5) and the
EKF averages friction over the uncertain speed: the smoothed torque is then best, the filtered one
about 15 % worse (see docs/tuning.md).

usage examples:
  gearbox_monitor tune BAG --filter ekf --out params.yaml
  gearbox_monitor tune BAG --model drive.yaml --params start.yaml --out tuned.yaml --json
  gearbox_monitor tune BAG --reference /reference/transmission_state --out params.yaml
  gearbox_monitor replay BAG --params params.yaml
"""
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
import math
import sys
import time
from typing import Any

import numpy as np

from gearbox_monitor.cli.inputs import load_filter_inputs
from gearbox_monitor.cli.options import (
    add_estimator_arguments, check_filter, opened, show, warn, wrapped)
from gearbox_monitor.cli.progress import count_bar
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation import noise_search
from gearbox_monitor.estimation.tune import expected_seconds, tune
from gearbox_monitor.files.yaml_files import error_words, expect_new_file, write_parameters
from gearbox_monitor.kernels.types import Array, Integers
from gearbox_monitor.parameters import ESTIMATOR, MIXED
from gearbox_monitor.presentation import change, EXACT, number, on_axis, percent, Quantity
from gearbox_monitor.recordings.read import BagReader, JOINT_STATE
from gearbox_monitor.signals.examine import measured_samples

SAME = 1.0  # of log-likelihood: parameters as good as tuned ones


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the options in `parser`."""
    add_estimator_arguments(parser)
    parser.add_argument('--filter', metavar='F', help='filter to tune (default: as --params, ekf)')
    parser.add_argument('--out', metavar='FILE', required=True, help='parameter file to write')
    parser.add_argument('--smoother', action='store_true',
                        help='tune for the smoothed torque instead of the filtered one')
    parser.add_argument('--fix-speeds', action='store_true',
                        help='keep q_std_motor_speed and q_std_arm_speed as they are')
    parser.add_argument('--reference', metavar='TOPIC', help='JointState with a measured torque')
    parser.add_argument('--json', action='store_true', help='print the result as JSON')


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    if args.filter:
        check_filter(args.filter)
    expect_new_file(args.out)
    with opened(args) as reader:
        inputs = load_filter_inputs(
            args, reader, args.filter,
            {} if args.reference or args.smoother else {'tau_k_model': MIXED})
        reference = _reference(reader, args.reference) if args.reference else None
    samples, notes = measured_samples(inputs.samples, args.bag)
    with count_bar('tune', 100) as bar:
        try:
            noise_search.describe(samples.stamp_ns, samples.u[:, 0], samples.y)  # refuses it
            seconds = expected_seconds(inputs.model, inputs.parameters, samples,
                                       time.perf_counter)
            print(f'tune: takes about {max(seconds, 1.0):.0f} s',
                  file=sys.stderr)
            data = tune(inputs.model, inputs.parameters, [samples], reference,
                        not args.fix_speeds, args.smoother,
                        lambda share: bar.update(100.0 * share - bar.n))
        except InputError as error:
            raise InputError(f'{args.bag}: {error}') from None
    data.update(bag=args.bag, out=args.out)
    data['notes'] += [*inputs.notes, *notes]
    data = {'summary': summary(data, inputs.model.axis), **data}
    write_parameters(args.out, inputs.parameters, (inputs.model_file, inputs.model_values), data)
    warn(args, data['notes'])
    show(args, data, lambda: text(data, inputs.model.axis))
    return int(data['kept_by'] > SAME or data['worse_than_static'])


def _reference(reader: BagReader, topic: str) -> tuple[Integers, Array]:
    """Return (stamps, torque) of the reference topic. Raises InputError."""
    topic = topic if topic.startswith('/') else '/' + topic
    reader.require(topic, JOINT_STATE)
    names = reader.joint_names(topic)
    states = reader.joint_states(topic, names[:1])
    if not names or not np.isfinite(states.effort).any():
        raise InputError(f'{reader.path}: topic {topic}: no effort, expected a measured torque')
    return states.stamp_ns, states.effort[:, 0]


def summary(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the result `data` of a drive with `axis` in words: what changes, what it gains."""
    if data['kept']:
        return 'The parameters stay as they were: none that was tried is likelier.'
    gain = data['after']['loglik'] - data['before']['loglik']
    sentences = [f'The tuned filter is likelier: log-likelihood {data["after"]["loglik"]:.1f} '
                 f'({gain:+.1f}), mean NIS {data["after"]["nis"]:.2f} '
                 f'({data["before"]["nis"]:.2f} before).'] if gain > 0.0 else [
        f'The tuned filter has a log-likelihood of {data["after"]["loglik"]:.1f} ({gain:+.1f}).']
    units = {p.name: p.unit for p in ESTIMATOR}
    before, errors = data['before_parameters'], data['relative_error']
    moved = {name: abs(math.log(value / before[name]))
             for name, value in data['parameters'].items()
             if isinstance(value, float) and value > 0.0 and (before[name] or 0.0) > 0.0
             and errors.get(name, 0.0) <= noise_search.BLUNT}
    name = max(moved, key=lambda n: moved[n], default=None)
    if name is not None and moved[name] > 0.0:
        value, start = data['parameters'][name], before[name]
        size = Quantity(value, value * errors.get(name, EXACT), on_axis(units[name], axis))
        sentences.append(f'{name} changes most: {size}, not {number(start)} '
                         f'({change(value, start)}).')
    return ' '.join(sentences)


def text(data: Mapping[str, Any], axis: str = 'rotary') -> str:
    """Return the result `data` of a drive with `axis` as lines for people."""
    where = {'standstill': f'a stretch of {data["rest_seconds"]:.1f} s at standstill',
             'likelihood': 'the likelihood (no standstill of half a second)',
             'fourth differences': 'fourth differences (no standstill of half a second)'}
    lines = [
        *wrapped(data['summary']), '',
        f'bag          {data["bag"]}, {data["seconds"]:.1f} s; filter {data["filter"]}, '
        f'tau_k_model {data["tau_k_model"]}',
        f'R from       {where[data["noise_from"]]}',
        f'search       {data["evaluations"]} runs; {data["starts_met"]} of {data["starts"]} '
        f'starts agree within {percent(data["spread"])}', '',
        f'{"":24s}{"before":>14s}{"after":>14s}']
    start, tuned = data['before'], data['after']

    def row(label: str, values: Sequence[Any], note: str = '') -> None:
        """Add a line with label, values and note."""
        cells = ''.join(f'{_number(v):>14s}' for v in values)
        lines.append(f'{label:24s}{cells}  {note}'.rstrip())

    row('log-likelihood', [start['loglik'], tuned['loglik']])
    row('mean NIS', [start['nis'], tuned['nis']],
        f'95 % band {data["nis_band"][0]:.3f}..{data["nis_band"][1]:.3f}')
    for k, name in enumerate(('motor', 'arm')):
        row(f'Ljung-Box, {name}', [start['ljung_box'][k], tuned['ljung_box'][k]],
            f'white below {data["white_limit"]:.1f}; autocorrelation '
            f'{data["autocorrelation"][k]:.2g} per lag')
    row('divergences', [start['diverged'], tuned['diverged']])
    if 'reference_after' in data:
        a, b = data['reference_before'], data['reference_after']
        row(on_axis('tau_K error rms (N m)', axis), [a['rmse'], b['rmse']], f'of {b["rms"]:.4g}')
        if data.get('static_rmse') is not None:
            row('static compensation', ['', data['static_rmse']], 'rms of the command less '
                'friction, without a filter')
        row('within 1 sigma', [a['coverage'], b['coverage']], '0.68 expected')
    lines.append('')
    units = {p.name: p.unit for p in ESTIMATOR}
    for name, value in data['parameters'].items():
        error = data['relative_error'].get(name)
        row(name, [data['before_parameters'][name], value],
            on_axis(units[name], axis) + error_words(error))
    lines.append('')
    lines += [f'open         {data["unidentifiable"]}']
    lines += [f'note         {note}' for note in data['notes']]
    lines.append(f'written      {data["out"]}' + (
        ' for the smoothed torque' if data['smoother'] else ' (--smoother: '
        'values best for the smoothed torque)'))
    return '\n'.join(lines)


def _number(value: Any) -> str:
    if isinstance(value, str):
        return value
    if value is None or not math.isfinite(value):
        return 'none'
    return str(value) if isinstance(value, int) else f'{value:.5g}' if abs(value) < 1e4 else \
        f'{value:.1f}'
